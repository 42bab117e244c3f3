!> Oblique impact of a solid sphere on a half-space of the same material, with Hertz pressure and
!> tangential elasticity (N. Maw, J. Barber, J. Fawcett, Wear 38 (1976) 101).
!>
!> psi = kappa v_t/(f v_n) with the velocities at the point of contact and v_n that of the approach,
!> kappa = 2 (1 - nu)/(2 - nu). In units where mass, v_n and the radius of the spot per root of the
!> approach are one, the approach d obeys d'' = -(5/4) d^(3/2), the force of the spring at x is
!> kappa (5/4) (3/2) q dx for the elastic displacement q, its limit f times the normal one, and the
!> velocity of the point of contact v_t' = (7/2) F. The steps are those of Verlet, so the normal
!> impulse is exact.
module contensou_contact_tangential_oblique
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite, ieee_quiet_nan, ieee_value
   use contensou_base_kinds, only : wp
   use contensou_contact_spot, only : circular_shape
   use contensou_contact_tangential_shells, only : shells_type, spring_spot_type
   implicit none(type, external)
   private

   public :: oblique_impact

   !> Steps of an impact.
   integer, parameter :: steps = 4000

contains

   !> Velocity of the point of contact after the impact.
   pure function oblique_impact(shells, poisson, before) result(after)
      !> Shells without a contact, or a single spring.
      type(shells_type), intent(in) :: shells
      !> Poisson's ratio, from -1 to 1/2.
      real(wp), intent(in) :: poisson
      !> psi before.
      real(wp), intent(in) :: before
      !> psi after; NaN outside the domain.
      real(wp) :: after
      !> Duration of the impact: 2.9432 d/v for the deepest approach d = 1.
      real(wp), parameter :: duration = 2.9432_wp
      type(shells_type) :: memory
      type(spring_spot_type) :: spot
      real(wp) :: kappa, approach, rate, velocity, time_step, force, wrench(3)
      integer :: i

      after = ieee_value(after, ieee_quiet_nan)
      if (.not. (ieee_is_finite(poisson) .and. ieee_is_finite(before))) return
      if (poisson < -1.0_wp .or. poisson > 0.5_wp) return
      kappa = 2.0_wp*(1.0_wp - poisson)/(2.0_wp - poisson)
      memory = shells
      spot%shape = circular_shape
      approach = 0.0_wp
      rate = 1.0_wp
      force = 0.0_wp
      ! f = 1; psi is kappa times the velocity.
      velocity = before/kappa
      time_step = duration/real(steps, wp)
      do i = 1, 2*steps
         ! Half a step with the forces before, a step of the places, and the forces after.
         rate = rate - 0.5_wp*time_step*force
         approach = approach + time_step*rate
         if (approach <= 0.0_wp) exit
         force = 1.25_wp*approach*sqrt(approach)
         spot%a = sqrt(approach)
         spot%limit = force
         spot%stiffness = kappa*1.875_wp*spot%a*[1.0_wp, 1.0_wp, 1.0_wp]
         call memory%advance(spot, [time_step*velocity, 0.0_wp, 0.0_wp], wrench)
         velocity = velocity + 3.5_wp*time_step*wrench(1)
         rate = rate - 0.5_wp*time_step*force
      end do
      after = kappa*velocity
   end function oblique_impact

end module contensou_contact_tangential_oblique
