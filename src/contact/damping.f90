!> Damping part of a contact: what the normal force gains from the rate of approach.
!>
!> All laws are of the form N = max(F_el + damping, 0): a contact never pulls.
!>
!> Sources: K. H. Hunt, F. R. E. Crossley, J. Appl. Mech. 42 (1975) 440; Y. Tsuji, T. Tanaka,
!> T. Ishida, Powder Technol. 71 (1992) 239; E. N. Antypov, J. A. Elliott, Europhys. Lett. 94 (2011)
!> 50004 (restitution of Tsuji's law in closed form).
module contensou_contact_damping
   use, intrinsic :: ieee_arithmetic, only : ieee_quiet_nan, ieee_value
   use contensou_base_kinds, only : wp, pi
   use contensou_contact_catalogue, only : model_info_type
   implicit none(type, external)
   private

   public :: damping_type, damping_model_type, damping_models, damping_kernel, damping_slopes
   public :: hunt_crossley_number, hunt_crossley_restitution, tsuji_factor
   public :: restitution_none, restitution_at_speed, restitution_any_speed

   !> A law has no formula for a coefficient of restitution.
   integer, parameter :: restitution_none = 0

   !> The law's restitution depends on the impact speed.
   integer, parameter :: restitution_at_speed = 1

   !> The law's restitution does not depend on the impact speed.
   integer, parameter :: restitution_any_speed = 2

   abstract interface
      !> Damping force [N].
      pure function damping_kernel(elastic, approach, rate, coefficient) result(f)
         import :: wp
         implicit none(type, external)
         !> Elastic force [N].
         real(wp), intent(in) :: elastic
         !> Approach d [m], >= 0.
         real(wp), intent(in) :: approach
         !> Rate of approach [m/s].
         real(wp), intent(in) :: rate
         !> Coefficient of the law, in its own unit.
         real(wp), intent(in) :: coefficient
         real(wp) :: f
      end function damping_kernel

      !> Derivatives of a damping force.
      pure function damping_slopes(elastic, approach, rate, coefficient) result(slopes)
         import :: wp
         implicit none(type, external)
         !> Elastic force [N], > 0.
         real(wp), intent(in) :: elastic
         !> Approach d [m], > 0.
         real(wp), intent(in) :: approach
         !> Rate of approach [m/s].
         real(wp), intent(in) :: rate
         !> Coefficient of the law, in its own unit.
         real(wp), intent(in) :: coefficient
         !> By the elastic force [-], the approach [N/m] and its rate [N s/m].
         real(wp) :: slopes(3)
      end function damping_slopes
   end interface

   !> A damping law with its coefficient.
   type :: damping_type
      !> Coefficient of the law, in its own unit (for `tsuji` times sqrt(m)).
      real(wp) :: coefficient = 0.0_wp
      !> The law.
      procedure(damping_kernel), pointer, nopass :: kernel => null()
      !> Its derivatives.
      procedure(damping_slopes), pointer, nopass :: slopes => null()
      !> Number D = (3/2) alpha v0 of a Hunt-Crossley law whose coefficient follows the speed v0
      !> of each impact; zero when the coefficient is constant.
      real(wp) :: impact_number = 0.0_wp
      !> Smallest v0 that is distinguished [m/s].
      real(wp) :: slowest_impact = 0.0_wp
   contains
      !> Total normal force.
      procedure :: total
      !> Take note of the speed of an impact.
      procedure :: begin_impact
   end type damping_type

   !> An entry of the table.
   type :: damping_model_type
      !> What a user reads.
      type(model_info_type) :: info
      !> The law; not associated for `none`.
      procedure(damping_kernel), pointer, nopass :: kernel => null()
      !> Its derivatives.
      procedure(damping_slopes), pointer, nopass :: slopes => null()
      !> Which restitution formula there is, one of the `restitution_*` codes.
      integer :: restitution = restitution_none
   end type damping_model_type

contains

   !> Table of the damping laws.
   function damping_models() result(models)
      type(damping_model_type), allocatable :: models(:)

      allocate(models(4))
      models(1)%info = model_info_type("none", "no damping: N = F_el", "", "")
      models(2)%info = model_info_type("hunt_crossley", &
         "N = F_el (1 + (3/2) alpha d')", &
         "damping_coefficient alpha [s/m], or restitution [-] with impact_velocity [m/s]", &
         "K. H. Hunt, F. R. E. Crossley, J. Appl. Mech. 42 (1975) 440")
      models(2)%kernel => hunt_crossley
      models(2)%slopes => hunt_crossley_slopes
      models(2)%restitution = restitution_at_speed
      models(3)%info = model_info_type("viscous", "N = F_el + D d d'", &
         "damping_coefficient D [N s/m2]", "Kosenko and Aleksandrov (2009)")
      models(3)%kernel => viscous
      models(3)%slopes => viscous_slopes
      models(4)%info = model_info_type("tsuji", &
         "N = F_el + alpha sqrt(m k_n) d^(1/4) d', m the reduced mass", &
         "damping_coefficient alpha [-], or restitution [-]", &
         "Y. Tsuji et al., Powder Technol. 71 (1992) 239")
      models(4)%kernel => tsuji
      models(4)%slopes => tsuji_slopes
      models(4)%restitution = restitution_any_speed
   end function damping_models

   !> Normal force with damping [N], >= 0.
   pure function total(self, elastic, approach, rate) result(f)
      !> The part.
      class(damping_type), intent(in) :: self
      !> Elastic force [N].
      real(wp), intent(in) :: elastic
      !> Approach d [m], >= 0.
      real(wp), intent(in) :: approach
      !> Rate of approach [m/s].
      real(wp), intent(in) :: rate
      real(wp) :: f

      f = max(elastic + self%kernel(elastic, approach, rate, self%coefficient), 0.0_wp)
   end function total

   !> Set the coefficient of a law that restitutes each impact alike.
   pure subroutine begin_impact(self, speed)
      !> The part.
      class(damping_type), intent(inout) :: self
      !> Speed of approach at touch [m/s].
      real(wp), intent(in) :: speed

      if (self%impact_number > 0.0_wp) then
         self%coefficient = self%impact_number/(1.5_wp*max(speed, self%slowest_impact))
      end if
   end subroutine begin_impact

   !> Hunt-Crossley damping [N], F_el (3/2) alpha d'.
   pure function hunt_crossley(elastic, approach, rate, coefficient) result(f)
      !> Elastic force [N].
      real(wp), intent(in) :: elastic
      !> Approach [m] (in the elastic force already).
      real(wp), intent(in) :: approach
      !> Rate of approach [m/s].
      real(wp), intent(in) :: rate
      !> alpha [s/m].
      real(wp), intent(in) :: coefficient
      real(wp) :: f

      f = 1.5_wp*coefficient*elastic*rate
   end function hunt_crossley

   !> Viscous damping [N], D d d'.
   pure function viscous(elastic, approach, rate, coefficient) result(f)
      !> Elastic force [N] (not used).
      real(wp), intent(in) :: elastic
      !> Approach [m].
      real(wp), intent(in) :: approach
      !> Rate of approach [m/s].
      real(wp), intent(in) :: rate
      !> D [N s/m2].
      real(wp), intent(in) :: coefficient
      real(wp) :: f

      f = coefficient*approach*rate
   end function viscous

   !> Derivatives of Hunt-Crossley damping.
   pure function hunt_crossley_slopes(elastic, approach, rate, coefficient) result(slopes)
      !> Elastic force [N].
      real(wp), intent(in) :: elastic
      !> Approach [m] (in the elastic force already).
      real(wp), intent(in) :: approach
      !> Rate of approach [m/s].
      real(wp), intent(in) :: rate
      !> alpha [s/m].
      real(wp), intent(in) :: coefficient
      !> By elastic force, approach and rate.
      real(wp) :: slopes(3)

      slopes = 1.5_wp*coefficient*[rate, 0.0_wp, elastic]
   end function hunt_crossley_slopes

   !> Derivatives of viscous damping.
   pure function viscous_slopes(elastic, approach, rate, coefficient) result(slopes)
      !> Elastic force [N] (not used).
      real(wp), intent(in) :: elastic
      !> Approach [m].
      real(wp), intent(in) :: approach
      !> Rate of approach [m/s].
      real(wp), intent(in) :: rate
      !> D [N s/m2].
      real(wp), intent(in) :: coefficient
      !> By elastic force, approach and rate.
      real(wp) :: slopes(3)

      slopes = coefficient*[0.0_wp, rate, approach]
   end function viscous_slopes

   !> Tsuji's damping [N], alpha sqrt(m k_n) d^(1/4) d', with k_n d^(1/2) = F_el/d.
   pure function tsuji(elastic, approach, rate, coefficient) result(f)
      !> Elastic force [N].
      real(wp), intent(in) :: elastic
      !> Approach [m].
      real(wp), intent(in) :: approach
      !> Rate of approach [m/s].
      real(wp), intent(in) :: rate
      !> alpha sqrt(m) [kg^(1/2)].
      real(wp), intent(in) :: coefficient
      real(wp) :: f

      f = 0.0_wp
      if (approach > 0.0_wp) f = coefficient*sqrt(elastic/approach)*rate
   end function tsuji

   !> Derivatives of Tsuji's damping.
   pure function tsuji_slopes(elastic, approach, rate, coefficient) result(slopes)
      !> Elastic force [N], > 0.
      real(wp), intent(in) :: elastic
      !> Approach [m], > 0.
      real(wp), intent(in) :: approach
      !> Rate of approach [m/s].
      real(wp), intent(in) :: rate
      !> alpha sqrt(m) [kg^(1/2)].
      real(wp), intent(in) :: coefficient
      !> By elastic force, approach and rate.
      real(wp) :: slopes(3)

      slopes = coefficient*sqrt(elastic/approach)*[0.5_wp*rate/elastic, -0.5_wp*rate/approach, &
         1.0_wp]
   end function tsuji_slopes

   !> Number D = (3/2) alpha v0 of the Hunt-Crossley law that returns the speed v0 as e v0: the
   !> root of (1 + e) D = ln((1 + D)/(1 - e D)). Zero for e = 1; NaN outside (0, 1].
   pure function hunt_crossley_number(restitution) result(d)
      !> Coefficient of restitution e, in (0, 1].
      real(wp), intent(in) :: restitution
      real(wp) :: d
      real(wp) :: low, high
      integer :: i

      if (.not. (restitution > 0.0_wp .and. restitution <= 1.0_wp)) then
         d = ieee_value(d, ieee_quiet_nan)
         return
      end if
      low = 0.0_wp
      high = 1.0_wp/restitution
      if (restitution >= 1.0_wp) high = 0.0_wp
      d = high
      do i = 1, 1100
         d = 0.5_wp*(low + high)
         if (d <= low .or. d >= high) exit
         if (number_excess(restitution, d) > 0.0_wp) then
            high = d
         else
            low = d
         end if
      end do
   end function hunt_crossley_number

   !> Restitution e of the Hunt-Crossley law at a number D = (3/2) alpha v0, the root of
   !> (1 + e) D = ln((1 + D)/(1 - e D)) in (0, 1].
   pure function hunt_crossley_restitution(number) result(e)
      !> D, >= 0.
      real(wp), intent(in) :: number
      real(wp) :: e
      real(wp) :: low, high
      integer :: i

      e = 1.0_wp
      if (number <= 0.0_wp) return
      low = 0.0_wp
      high = min(1.0_wp, 1.0_wp/number)
      do i = 1, 1100
         e = 0.5_wp*(low + high)
         if (e <= low .or. e >= high) exit
         if (number_excess(e, number) > 0.0_wp) then
            high = e
         else
            low = e
         end if
      end do
   end function hunt_crossley_restitution

   !> (ln((1 + D)/(1 - e D)) - (1 + e) D)/D^2, negative below the root and positive above it.
   pure function number_excess(e, d) result(f)
      !> Coefficient of restitution e, in (0, 1).
      real(wp), intent(in) :: e
      !> Number D, in (0, 1/e].
      real(wp), intent(in) :: d
      real(wp) :: f
      integer :: n

      if (d >= 0.05_wp) then
         f = huge(f)
         if (1.0_wp - e*d > 0.0_wp) then
            f = (log(1.0_wp + d) - log(1.0_wp - e*d) - (1.0_wp + e)*d)/d**2
         end if
      else
         ! The logarithms cancel: sum of (e^n - (-1)^n) D^(n - 2)/n from n = 2.
         f = 0.0_wp
         do n = 16, 2, -1
            f = f*d + (e**n - (-1.0_wp)**n)/n
         end do
      end if
   end function number_excess

   !> Factor alpha of Tsuji's law, -sqrt(5) ln e/sqrt(pi^2 + ln^2 e).
   pure function tsuji_factor(restitution) result(alpha)
      !> Coefficient of restitution e, in (0, 1].
      real(wp), intent(in) :: restitution
      real(wp) :: alpha

      alpha = -sqrt(5.0_wp)*log(restitution)/sqrt(pi**2 + log(restitution)**2)
   end function tsuji_factor

end module contensou_contact_damping
