!> What a ball bearing loses by friction when all is steady, from its loads alone, and how long it
!> lives.
!>
!> Loss: a ball rolls on a race about the major axis of a curved spot and pivots on it; it slides
!> as a whole at the velocity at which the force of friction is zero, which is where the power that
!> is lost is least. A ball whose contacts are opposite each other pivots on both races with rates
!> that add up to (w_inner - w_outer) sin(contact angle), however they share it.
!>
!> Life: basic reference life of ISO/TS 16281 for radial ball bearings, in 10^6 revolutions,
!>    L10r = ((Q_i/Q_ci)^(10/3) + (Q_o/Q_co)^(10/3))^(-9/10),
!> of the loads Q_i, Q_o of the races, means with the exponent 3 on the ring that turns against the
!> load and 10/3 on the other one, and their ratings, from the rating C of the bearing with Z balls
!>    Q_ci = C (1 + q^(10/3))^0.3/(0.407 Z cos^0.7 alpha),
!>    Q_co = C (1 + q^(-10/3))^0.3/(0.389 Z cos^0.7 alpha),
!>    q = 1.044 ((1 - gamma)/(1 + gamma))^1.72 (r_i (2 r_o - D)/(r_o (2 r_i - D)))^0.41,
!> gamma = D cos(alpha)/d_m, with the nominal contact angle alpha.
module contensou_study_race_losses
   use contensou_base_kinds, only : wp
   use contensou_contact_curved_spot, only : curved_spot_type
   use contensou_contact_friction_law, only : sliding_type
   use contensou_contact_spot, only : elliptic_shape, spot_shape_type
   use contensou_special_bisection, only : bisection_type
   implicit none(type, external)
   private

   public :: race_spot_type, reference_life

   !> Bound of the error of the wrench of a spot over f N.
   real(wp), parameter :: spot_error = 1.0e-7_wp

   !> Halvings with which a velocity or a share is found.
   integer, parameter :: halvings = 30

   !> The spot of a ball on a race.
   type :: race_spot_type
      !> Normal force [N].
      real(wp) :: load = 0.0_wp
      !> Semi-axes [m]: across the groove, along it.
      real(wp) :: semi_axes(2) = 0.0_wp
      !> Curvatures of the spot (L_B - L_A)/2 along these [1/m].
      real(wp) :: form(2) = 0.0_wp
      !> Angular velocity of the ball against the ring in the plane of the spot [rad/s].
      real(wp) :: rolling = 0.0_wp
      !> Friction coefficient [-].
      real(wp) :: friction = 0.0_wp
   contains
      procedure :: power
      procedure :: least_power
   end type race_spot_type

contains

   !> Power that is lost in a spot [W], and the torque of friction about the normal [N m].
   pure subroutine power(self, spin, loss, torque)
      class(race_spot_type), intent(in) :: self
      !> Pivoting [rad/s].
      real(wp), intent(in) :: spin
      real(wp), intent(out) :: loss
      real(wp), intent(out) :: torque
      type(curved_spot_type) :: spot
      type(sliding_type) :: at
      type(spot_shape_type) :: shape
      type(bisection_type) :: search
      real(wp) :: force(3), moment(2), largest

      loss = 0.0_wp
      torque = 0.0_wp
      if (.not. self%load > 0.0_wp) return
      shape = elliptic_shape(min(self%semi_axes(2)/self%semi_axes(1), 1.0_wp))
      spot%error = spot_error
      spot%coefficient = self%friction
      spot%form = [self%form(1), 0.0_wp, self%form(2)]
      at = sliding_type(load=self%load, a=self%semi_axes(1), w=spin)
      ! No point of the spot slips faster by rolling and pivoting.
      largest = at%a*abs(spin) + 0.5_wp*abs(self%rolling)*sum(abs(self%form)*self%semi_axes**2)
      call search%begin(-largest, largest, steps=halvings)
      do while (search%goes_on)
         at%vy = search%middle
         call spot%wrench(shape, at, [self%rolling, 0.0_wp], force, moment)
         call search%narrow(force(2) < 0.0_wp)
      end do
      at%vy = 0.5_wp*(search%low + search%high)
      call spot%wrench(shape, at, [self%rolling, 0.0_wp], force, moment)
      loss = -(force(2)*at%vy + force(3)*spin + moment(1)*self%rolling)
      torque = force(3)
   end subroutine power

   !> Power that is lost on both races [W] where they share the pivoting of the ball so that least
   !> is lost: the torques about the line of contacts are then equal.
   pure real(wp) function least_power(self, other, spin) result(loss)
      class(race_spot_type), intent(in) :: self
      !> Spot on the other race.
      type(race_spot_type), intent(in) :: other
      !> Pivoting on both together [rad/s], >= 0.
      real(wp), intent(in) :: spin
      type(bisection_type) :: search
      real(wp) :: losses(2), torques(2)

      call search%begin(0.0_wp, spin, steps=halvings/2)
      do while (search%goes_on)
         call self%power(search%middle, losses(1), torques(1))
         call other%power(spin - search%middle, losses(2), torques(2))
         ! Torques are against the pivoting.
         call search%narrow(torques(1) < torques(2))
      end do
      call self%power(search%middle, losses(1), torques(1))
      call other%power(spin - search%middle, losses(2), torques(2))
      loss = sum(losses)
   end function least_power

   !> Basic reference life [10^6 revolutions].
   pure real(wp) function reference_life(loads, rotating, rating, ratio, angle, grooves) &
      result(life)
      !> Loads by ball on the inner and the outer race [N].
      real(wp), intent(in) :: loads(:, :)
      !> Whether a ring turns against the load: inner, outer.
      logical, intent(in) :: rotating(2)
      !> Basic dynamic load rating C [N].
      real(wp), intent(in) :: rating
      !> Diameter of a ball over that of the pitch circle.
      real(wp), intent(in) :: ratio
      !> Nominal contact angle [rad].
      real(wp), intent(in) :: angle
      !> Radii of the grooves over the diameter of a ball: inner, outer.
      real(wp), intent(in) :: grooves(2)
      real(wp), parameter :: slope = 10.0_wp/3.0_wp
      real(wp) :: gamma, base, capacity(2), load(2), exponent
      integer :: k

      gamma = ratio*cos(angle)
      base = 1.044_wp*((1.0_wp - gamma)/(1.0_wp + gamma))**1.72_wp*(grooves(1)/grooves(2) &
         *(2.0_wp*grooves(2) - 1.0_wp)/(2.0_wp*grooves(1) - 1.0_wp))**0.41_wp
      capacity = rating/(size(loads, 1)*cos(angle)**0.7_wp)/[0.407_wp, 0.389_wp] &
         *(1.0_wp + base**[slope, -slope])**0.3_wp
      do k = 1, 2
         exponent = merge(3.0_wp, slope, rotating(k))
         load(k) = (sum(loads(:, k)**exponent)/size(loads, 1))**(1.0_wp/exponent)
      end do
      life = huge(life)
      if (any(load > 0.0_wp)) life = sum((load/capacity)**slope)**(-0.9_wp)
   end function reference_life

end module contensou_study_race_losses
