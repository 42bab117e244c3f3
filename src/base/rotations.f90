!> Rotations as quaternions (w, x, y, z), from the body frame to the inertial frame.
!>
!> The rotation matrix is homogeneous of degree zero in the quaternion, so that a norm that an
!> integrator lets drift is a scale without meaning: nothing has to be projected back.
module contensou_base_rotations
   use contensou_base_kinds, only : wp
   use contensou_base_vectors, only : unit_vector
   implicit none(type, external)
   private

   public :: norm_rate
   public :: rotation_matrix, set_rotation, to_inertial, to_body
   public :: quaternion_from_axis_angle, quaternion_rate, unit_quaternion
   public :: rotation_vector, quaternion_of_matrix

   !> Rate at which `quaternion_rate` pulls the norm to one [1/s].
   real(wp), parameter :: norm_rate = 1.0_wp

contains

   !> Rotation matrix of a quaternion of any norm but zero: x_inertial = matmul(r, x_body).
   pure function rotation_matrix(q) result(r)
      !> Quaternion (w, x, y, z), need not have unit norm.
      real(wp), intent(in) :: q(4)
      real(wp) :: r(3, 3)

      call set_rotation(q, r)
   end function rotation_matrix

   !> Rotation matrix of a quaternion where it stays, without a copy.
   pure subroutine set_rotation(q, r)
      !> Quaternion (w, x, y, z), of any norm but zero.
      real(wp), intent(in) :: q(4)
      real(wp), intent(out) :: r(3, 3)
      real(wp) :: s, x, y, z

      s = 2.0_wp/(q(1)*q(1) + q(2)*q(2) + q(3)*q(3) + q(4)*q(4))
      x = s*q(2)
      y = s*q(3)
      z = s*q(4)
      r(1, 1) = 1.0_wp - (y*q(3) + z*q(4))
      r(2, 2) = 1.0_wp - (x*q(2) + z*q(4))
      r(3, 3) = 1.0_wp - (x*q(2) + y*q(3))
      r(1, 2) = x*q(3) - z*q(1)
      r(2, 1) = x*q(3) + z*q(1)
      r(1, 3) = x*q(4) + y*q(1)
      r(3, 1) = x*q(4) - y*q(1)
      r(2, 3) = y*q(4) - x*q(1)
      r(3, 2) = y*q(4) + x*q(1)
   end subroutine set_rotation

   !> A vector of the body frame in the inertial frame, matmul(r, x), which gfortran makes loops of.
   pure function to_inertial(r, x) result(v)
      !> Rotation matrix, body to inertial.
      real(wp), intent(in) :: r(3, 3)
      !> Vector, body frame.
      real(wp), intent(in) :: x(3)
      real(wp) :: v(3)

      v(1) = r(1, 1)*x(1) + r(1, 2)*x(2) + r(1, 3)*x(3)
      v(2) = r(2, 1)*x(1) + r(2, 2)*x(2) + r(2, 3)*x(3)
      v(3) = r(3, 1)*x(1) + r(3, 2)*x(2) + r(3, 3)*x(3)
   end function to_inertial

   !> A vector of the inertial frame in the body frame, matmul(x, r).
   pure function to_body(r, x) result(v)
      !> Rotation matrix, body to inertial.
      real(wp), intent(in) :: r(3, 3)
      !> Vector, inertial frame.
      real(wp), intent(in) :: x(3)
      real(wp) :: v(3)

      v(1) = r(1, 1)*x(1) + r(2, 1)*x(2) + r(3, 1)*x(3)
      v(2) = r(1, 2)*x(1) + r(2, 2)*x(2) + r(3, 2)*x(3)
      v(3) = r(1, 3)*x(1) + r(2, 3)*x(2) + r(3, 3)*x(3)
   end function to_body

   !> Quaternion of the rotation by an angle about an axis.
   pure function quaternion_from_axis_angle(axis, angle) result(q)
      !> Axis, of any length but zero.
      real(wp), intent(in) :: axis(3)
      !> Angle [rad].
      real(wp), intent(in) :: angle
      real(wp) :: q(4)

      q(1) = cos(0.5_wp*angle)
      q(2:4) = sin(0.5_wp*angle)*unit_vector(axis)
   end function quaternion_from_axis_angle

   !> Time derivative of a quaternion, q' = (1/2) q o (0, w) + norm_rate (1 - |q|^2) q.
   !>
   !> The second term only moves the norm, which the rotation does not depend on; it keeps the
   !> norm near one so that relative tolerances keep their meaning over millions of revolutions.
   pure function quaternion_rate(q, w) result(rate)
      !> Quaternion (w, x, y, z).
      real(wp), intent(in) :: q(4)
      !> Angular velocity in the body frame [rad/s].
      real(wp), intent(in) :: w(3)
      real(wp) :: rate(4)
      real(wp) :: pull

      pull = norm_rate*(1.0_wp - (q(1)*q(1) + q(2)*q(2) + q(3)*q(3) + q(4)*q(4)))
      rate(1) = -0.5_wp*(q(2)*w(1) + q(3)*w(2) + q(4)*w(3)) + pull*q(1)
      rate(2) = 0.5_wp*(q(1)*w(1) + q(3)*w(3) - q(4)*w(2)) + pull*q(2)
      rate(3) = 0.5_wp*(q(1)*w(2) + q(4)*w(1) - q(2)*w(3)) + pull*q(3)
      rate(4) = 0.5_wp*(q(1)*w(3) + q(2)*w(2) - q(3)*w(1)) + pull*q(4)
   end function quaternion_rate

   !> The quaternion scaled to unit norm.
   pure function unit_quaternion(q) result(unit)
      !> Quaternion of any norm but zero.
      real(wp), intent(in) :: q(4)
      real(wp) :: unit(4)

      ! As `unit_vector` does, whose result of any size takes memory.
      unit = q/maxval(abs(q))
      unit = unit/norm2(unit)
   end function unit_quaternion

   !> Rotation vector of a rotation matrix, of a length up to pi [rad].
   pure function rotation_vector(r) result(vector)
      real(wp), intent(in) :: r(3, 3)
      real(wp) :: vector(3)
      real(wp) :: sine(3), s, c, largest
      integer :: i

      sine = 0.5_wp*[r(3, 2) - r(2, 3), r(1, 3) - r(3, 1), r(2, 1) - r(1, 2)]
      s = norm2(sine)
      c = 0.5_wp*(r(1, 1) + r(2, 2) + r(3, 3) - 1.0_wp)
      vector = sine
      if (c > -0.5_wp) then
         if (s > 0.0_wp) vector = sine*(atan2(s, c)/s)
         return
      end if
      ! Near to half a turn the symmetric part tells the axis, the other one only its sense.
      i = maxloc([r(1, 1), r(2, 2), r(3, 3)], dim=1)
      largest = sqrt(max((r(i, i) - c)/(1.0_wp - c), 0.0_wp))
      vector = 0.5_wp*(r(:, i) + r(i, :))/((1.0_wp - c)*largest)
      vector(i) = largest
      if (dot_product(vector, sine) < 0.0_wp) vector = -vector
      vector = vector*atan2(s, c)
   end function rotation_vector

   !> Unit quaternion of a rotation matrix.
   pure function quaternion_of_matrix(r) result(q)
      real(wp), intent(in) :: r(3, 3)
      real(wp) :: q(4)
      real(wp) :: vector(3)

      q = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      vector = rotation_vector(r)
      if (norm2(vector) > 0.0_wp) q = quaternion_from_axis_angle(vector, norm2(vector))
   end function quaternion_of_matrix

end module contensou_base_rotations
