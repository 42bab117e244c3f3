!> Friction of a contact with a curved spot, in SI units: Heathcote slip.
!>
!> The kernel is `contensou_contact_wrench_curved`; here it gets the friction of a contact, the
!> curvature of its spot and how fast the bodies roll on it.
module contensou_contact_curved_spot
   use contensou_base_kinds, only : wp
   use contensou_contact_friction_ladder, only : smoothing
   use contensou_contact_friction_law, only : sliding_type
   use contensou_contact_spot, only : spot_shape_type
   use contensou_contact_wrench_curved, only : bend_type, wrench_curved, wrench_curved_jacobian
   use contensou_contact_wrench_scaling, only : slip_type
   implicit none(type, external)
   private

   public :: curved_spot_type

   !> A curved spot with its friction.
   type :: curved_spot_type
      !> Bound of the error of the wrench over f N.
      real(wp) :: error = 1.0e-10_wp
      !> Bound where derivatives are wanted, for a Jacobian, if it is larger.
      real(wp) :: error_of_slopes = 1.0e-6_wp
      !> Friction coefficient f [-] and regularisation velocity [m/s].
      real(wp) :: coefficient = 0.0_wp, delta = 0.0_wp
      !> Mean curvature of the two surfaces, (L_B - L_A)/2, in the axes of the spot: components 11,
      !> 12, 22 [1/m]; the spot lies at (1/2) r.L r along the normal from A into B.
      real(wp) :: form(3) = 0.0_wp
   contains
      procedure :: wrench
      procedure :: linearize
   end type curved_spot_type

contains

   !> Force, drilling torque and tangential moment on the body that slips.
   pure subroutine wrench(self, shape, at, rolling, force, moment)
      class(curved_spot_type), intent(in) :: self
      type(spot_shape_type), intent(in) :: shape
      type(sliding_type), intent(in) :: at
      !> Relative angular velocity along the major and the minor axis [rad/s].
      real(wp), intent(in) :: rolling(2)
      !> Force along the axes [N], torque about the normal [N m].
      real(wp), intent(out) :: force(3)
      !> Moment along the axes [N m].
      real(wp), intent(out) :: moment(2)
      type(slip_type) :: slip
      type(bend_type) :: bend
      real(wp) :: by_turning(2), limit

      call prepare(self, at, rolling, slip, bend)
      call wrench_curved(shape, slip, bend, self%error, force, by_turning)
      limit = self%coefficient*at%load
      force = limit*force*[1.0_wp, 1.0_wp, at%a]
      moment = limit*[-by_turning(2), by_turning(1)]
   end subroutine wrench

   !> The same with the derivatives by N, a, vx, vy, w and the components of `rolling`.
   pure subroutine linearize(self, shape, at, rolling, values, slopes)
      class(curved_spot_type), intent(in) :: self
      type(spot_shape_type), intent(in) :: shape
      type(sliding_type), intent(in) :: at
      !> Relative angular velocity along the major and the minor axis [rad/s].
      real(wp), intent(in) :: rolling(2)
      !> Force along the axes [N], torque about the normal, moment along the axes [N m].
      real(wp), intent(out) :: values(5)
      !> Derivative of value i by quantity j.
      real(wp), intent(out) :: slopes(5, 7)
      type(slip_type) :: slip
      type(bend_type) :: bend
      real(wp) :: jacobian(5, 5), velocity(5), change(5), unit(5), rise, square, moment(2)

      call prepare(self, at, rolling, slip, bend)
      call wrench_curved_jacobian(shape, slip, bend, max(self%error, self%error_of_slopes), &
         values(1:3), moment, jacobian)
      velocity = [slip%x, slip%y, slip%spin, bend%turning]
      rise = maxval(abs(bend%rise))
      if (slip%delta > self%delta) then
         ! All is homogeneous of degree zero in the velocities and delta together.
         change = matmul(jacobian, velocity)
         square = at%resolution + sum(velocity(1:3)**2) + rise**2*sum(velocity(4:5)**2)
         jacobian = jacobian + spread(change*(3.0_wp/square), 2, 5) &
            *spread(velocity*[1.0_wp, 1.0_wp, 1.0_wp, rise**2, rise**2], 1, 5)
      end if
      ! From the moment by q = w_t x n, and the derivatives by it.
      values(4:5) = [-moment(2), moment(1)]
      jacobian(4:5, :) = reshape([-jacobian(5, :), jacobian(4, :)], [2, 5], order=[2, 1])
      jacobian(:, 4:5) = reshape([-jacobian(:, 5), jacobian(:, 4)], [5, 2])
      unit = self%coefficient*[1.0_wp, 1.0_wp, at%a, 1.0_wp, 1.0_wp]
      slopes(:, 1) = unit*values
      unit = at%load*unit
      values = unit*values
      slopes(:, 3) = unit*jacobian(:, 1)
      slopes(:, 4) = unit*jacobian(:, 2)
      slopes(:, 5) = unit*jacobian(:, 3)*at%a
      slopes(:, 6) = unit*jacobian(:, 4)
      slopes(:, 7) = unit*jacobian(:, 5)
      slopes(:, 2) = 0.0_wp
      if (.not. at%a > 0.0_wp) return
      ! The rise grows with the square of the size.
      slopes(:, 2) = (slopes(:, 5)*at%w + values*[0.0_wp, 0.0_wp, 1.0_wp, 2.0_wp, 2.0_wp] &
         + 2.0_wp*(slopes(:, 6)*rolling(1) + slopes(:, 7)*rolling(2)))/at%a
   end subroutine linearize

   !> Arguments of the kernel.
   pure subroutine prepare(self, at, rolling, slip, bend)
      class(curved_spot_type), intent(in) :: self
      type(sliding_type), intent(in) :: at
      real(wp), intent(in) :: rolling(2)
      type(slip_type), intent(out) :: slip
      type(bend_type), intent(out) :: bend

      bend%rise = 0.5_wp*at%a*at%a*self%form
      bend%turning = [rolling(2), -rolling(1)]
      slip = slip_type(at%vx, at%vy, at%a*at%w, self%delta)
      if (at%resolution > 0.0_wp) slip%delta = smoothing(self%delta, at%resolution, &
         at%vx**2 + at%vy**2 + slip%spin**2 + maxval(bend%rise**2)*sum(rolling**2))
   end subroutine prepare

end module contensou_contact_curved_spot
