!> Vectors in three dimensions.
module contensou_base_vectors
   use contensou_base_kinds, only : wp
   implicit none(type, external)
   private

   public :: cross, any_perpendicular, any_tangent, frame_along, unit_vector

contains

   !> Vector product `a x b`.
   pure function cross(a, b) result(c)
      !> First factor.
      real(wp), intent(in) :: a(3)
      !> Second factor.
      real(wp), intent(in) :: b(3)
      real(wp) :: c(3)

      c(1) = a(2)*b(3) - a(3)*b(2)
      c(2) = a(3)*b(1) - a(1)*b(3)
      c(3) = a(1)*b(2) - a(2)*b(1)
   end function cross

   !> A unit vector perpendicular to a given one, chosen without cancellation.
   pure function any_perpendicular(n) result(e)
      !> Vector of any length but zero.
      real(wp), intent(in) :: n(3)
      real(wp) :: e(3)
      real(wp) :: axis(3)

      axis = 0.0_wp
      axis(minloc(abs(n), dim=1)) = 1.0_wp
      e = cross(cross(n, axis), n)
      e = e/norm2(e)
   end function any_perpendicular

   !> A unit vector perpendicular to a given one, without a root or a choice of axes (T. Duff et
   !> al., J. Computer Graphics Techniques 6 (2017) 1).
   pure function any_tangent(normal) result(tangent)
      !> Unit vector.
      real(wp), intent(in) :: normal(3)
      real(wp) :: tangent(3)
      real(wp) :: up, a

      up = sign(1.0_wp, normal(3))
      a = -1.0_wp/(up + normal(3))
      tangent(1) = 1.0_wp + up*normal(1)**2*a
      tangent(2) = up*normal(1)*normal(2)*a
      tangent(3) = -up*normal(1)
   end function any_tangent

   !> Rotation matrix whose third column points along a vector.
   pure function frame_along(n) result(frame)
      !> Vector of any length but zero.
      real(wp), intent(in) :: n(3)
      real(wp) :: frame(3, 3)

      frame(:, 3) = unit_vector(n)
      frame(:, 1) = any_perpendicular(frame(:, 3))
      frame(:, 2) = cross(frame(:, 3), frame(:, 1))
   end function frame_along

   !> Vector of unit length; gfortran's norm2 loses vectors whose squares underflow.
   pure function unit_vector(v) result(e)
      !> Vector of any length but zero.
      real(wp), intent(in) :: v(:)
      real(wp) :: e(size(v))

      e = v/maxval(abs(v))
      e = e/norm2(e)
   end function unit_vector

end module contensou_base_vectors
