!> Damping laws of one coefficient: Hunt-Crossley's, the viscous one and Tsuji's.
!>
!> Sources: K. H. Hunt, F. R. E. Crossley, J. Appl. Mech. 42 (1975) 440; Y. Tsuji, T. Tanaka,
!> T. Ishida, Powder Technol. 71 (1992) 239; E. N. Antypov, J. A. Elliott, Europhys. Lett. 94 (2011)
!> 50004 (restitution of Tsuji's law in closed form).
module contensou_contact_damping_coefficient
   use, intrinsic :: ieee_arithmetic, only : ieee_quiet_nan, ieee_value
   use contensou_base_checkpoint, only : checkpoint_type
   use contensou_base_kinds, only : pi, wp
   use contensou_base_schema, only : kind_real
   use contensou_contact_catalogue, only : law_keys_type, model_info_type
   use contensou_contact_damping_law, only : damping_kernel, damping_model_type, damping_slopes, &
      damping_type
   use contensou_contact_parameters, only : parameters_type, surroundings_type
   use contensou_special_bisection, only : bisection_type
   implicit none(type, external)
   private

   public :: coefficient_damping_type, hunt_crossley_law, viscous_law, tsuji_law
   public :: hunt_crossley_number, hunt_crossley_restitution, tsuji_factor

   !> Smallest impact speed that a restitution per impact distinguishes [m/s].
   real(wp), parameter :: slowest_impact = 1.0e-3_wp

   !> A law with its coefficient.
   type, extends(damping_type) :: coefficient_damping_type
      !> Coefficient of the law, in its own unit (for `tsuji` times sqrt(m)).
      real(wp) :: coefficient = 0.0_wp
      procedure(damping_kernel), pointer, nopass :: kernel => null()
      procedure(damping_slopes), pointer, nopass :: kernel_slopes => null()
      !> Number D = (3/2) alpha v0 of a Hunt-Crossley law whose coefficient follows the speed v0
      !> of each impact; zero when the coefficient is constant.
      real(wp) :: impact_number = 0.0_wp
   contains
      procedure :: force
      procedure :: slopes
      procedure :: begin_impact
      procedure :: exchange
   end type coefficient_damping_type

contains

   !> Row of the Hunt-Crossley law.
   function hunt_crossley_law() result(model)
      type(damping_model_type) :: model

      model%info = model_info_type("hunt_crossley", "N = F_el (1 + (3/2) alpha d')", "", &
         "K. H. Hunt, F. R. E. Crossley, J. Appl. Mech. 42 (1975) 440")
      model%put_keys => put_hunt_crossley_keys
      model%create => new_hunt_crossley
      model%restitute => restitute_hunt_crossley
      model%kernel => hunt_crossley
      model%slopes => hunt_crossley_slopes
   end function hunt_crossley_law

   !> Row of the viscous law.
   function viscous_law() result(model)
      type(damping_model_type) :: model

      model%info = model_info_type("viscous", "N = F_el + D d d'", "", &
         "Kosenko and Aleksandrov (2009)")
      model%put_keys => put_viscous_keys
      model%create => new_viscous
      model%kernel => viscous
      model%slopes => viscous_slopes
   end function viscous_law

   !> Row of Tsuji's law.
   function tsuji_law() result(model)
      type(damping_model_type) :: model

      model%info = model_info_type("tsuji", &
         "N = F_el + alpha sqrt(m k_n) d^(1/4) d', m the reduced mass", "", &
         "Y. Tsuji et al., Powder Technol. 71 (1992) 239")
      model%put_keys => put_tsuji_keys
      model%create => new_tsuji
      model%kernel => tsuji
      model%slopes => tsuji_slopes
   end function tsuji_law

   !> The keys of the Hunt-Crossley law.
   subroutine put_hunt_crossley_keys(list)
      type(law_keys_type), intent(inout) :: list

      call put_coefficient(list, "alpha", "s m-1", instead="restitution")
      call put_restitution(list, "coefficient of restitution, instead of damping_coefficient")
      call list%put("impact_velocity", kind_real, "speed of approach at which the contact has " // &
         "its restitution; not given, the coefficient follows the speed of each touch (not " // &
         "below 1e-3 m/s)", unit="m s-1", above=0.0_wp, with="restitution")
   end subroutine put_hunt_crossley_keys

   !> The keys of the viscous law.
   subroutine put_viscous_keys(list)
      type(law_keys_type), intent(inout) :: list

      call put_coefficient(list, "D", "N s m-2")
   end subroutine put_viscous_keys

   !> The keys of Tsuji's law.
   subroutine put_tsuji_keys(list)
      type(law_keys_type), intent(inout) :: list

      call put_coefficient(list, "alpha", "1", instead="restitution")
      call put_restitution(list, "instead of damping_coefficient, by the formula of a contact " // &
         "that may pull at its end: as it may not, 0.5 returns 0.55")
   end subroutine put_tsuji_keys

   !> The key damping_coefficient.
   subroutine put_coefficient(list, symbol, unit, instead)
      type(law_keys_type), intent(inout) :: list
      !> Its symbol in the formula.
      character(len=*), intent(in) :: symbol
      character(len=*), intent(in) :: unit
      !> Key that may be given in its place.
      character(len=*), intent(in), optional :: instead

      call list%put("damping_coefficient", kind_real, "coefficient of the damping law", &
         symbol=symbol, unit=unit, least=0.0_wp, mandatory=.true., instead=instead)
   end subroutine put_coefficient

   !> The key restitution.
   subroutine put_restitution(list, doc)
      type(law_keys_type), intent(inout) :: list
      !> What it means.
      character(len=*), intent(in) :: doc

      call list%put("restitution", kind_real, doc, unit="1", above=0.0_wp, most=1.0_wp, &
         mandatory=.true., instead="damping_coefficient")
   end subroutine put_restitution

   !> A law with a given coefficient.
   subroutine new_law(model, coefficient, damping)
      class(damping_model_type), intent(in) :: model
      !> Coefficient in the unit of the law.
      real(wp), intent(in) :: coefficient
      type(coefficient_damping_type), allocatable, intent(out) :: damping

      allocate(damping)
      damping%kernel => model%kernel
      damping%kernel_slopes => model%slopes
      damping%coefficient = coefficient
   end subroutine new_law

   !> A Hunt-Crossley law.
   subroutine new_hunt_crossley(self, parameters, around, damping)
      class(damping_model_type), intent(in) :: self
      type(parameters_type), intent(in) :: parameters
      type(surroundings_type), intent(in) :: around
      class(damping_type), allocatable, intent(out) :: damping
      type(coefficient_damping_type), allocatable :: law
      real(wp) :: restitution, speed

      call new_law(self, parameters%number("damping_coefficient"), law)
      restitution = parameters%number("restitution")
      if (restitution > 0.0_wp) then
         speed = parameters%number("impact_velocity")
         law%impact_number = hunt_crossley_number(restitution)
         law%coefficient = law%impact_number/(1.5_wp*max(speed, slowest_impact))
         if (speed > 0.0_wp) law%impact_number = 0.0_wp
      end if
      call move_alloc(law, damping)
   end subroutine new_hunt_crossley

   !> A viscous law.
   subroutine new_viscous(self, parameters, around, damping)
      class(damping_model_type), intent(in) :: self
      type(parameters_type), intent(in) :: parameters
      type(surroundings_type), intent(in) :: around
      class(damping_type), allocatable, intent(out) :: damping
      type(coefficient_damping_type), allocatable :: law

      call new_law(self, parameters%number("damping_coefficient"), law)
      call move_alloc(law, damping)
   end subroutine new_viscous

   !> Tsuji's law.
   subroutine new_tsuji(self, parameters, around, damping)
      class(damping_model_type), intent(in) :: self
      type(parameters_type), intent(in) :: parameters
      type(surroundings_type), intent(in) :: around
      class(damping_type), allocatable, intent(out) :: damping
      type(coefficient_damping_type), allocatable :: law
      real(wp) :: factor

      factor = parameters%number("damping_coefficient")
      if (parameters%number("restitution") > 0.0_wp) then
         factor = tsuji_factor(parameters%number("restitution"))
      end if
      call new_law(self, factor*sqrt(around%mass), law)
      call move_alloc(law, damping)
   end subroutine new_tsuji

   !> Restitution of a rigid contact with a Hunt-Crossley law.
   pure subroutine restitute_hunt_crossley(parameters, restitution, alpha)
      type(parameters_type), intent(in) :: parameters
      real(wp), intent(out) :: restitution
      real(wp), intent(out) :: alpha

      restitution = parameters%number("restitution")
      alpha = 0.0_wp
      if (parameters%number("impact_velocity") > 0.0_wp) then
         alpha = hunt_crossley_number(restitution)/(1.5_wp*parameters%number("impact_velocity"))
      else if (restitution <= 0.0_wp) then
         restitution = 1.0_wp
         alpha = parameters%number("damping_coefficient")
      end if
   end subroutine restitute_hunt_crossley

   !> Damping force [N].
   pure function force(self, elastic, approach, rate) result(f)
      class(coefficient_damping_type), intent(in) :: self
      real(wp), intent(in) :: elastic, approach, rate
      real(wp) :: f

      f = self%kernel(elastic, approach, rate, self%coefficient)
   end function force

   !> Derivatives of the force by the elastic force, the approach and its rate.
   pure function slopes(self, elastic, approach, rate)
      class(coefficient_damping_type), intent(in) :: self
      !> Elastic force [N], > 0.
      real(wp), intent(in) :: elastic
      !> Approach d [m], > 0.
      real(wp), intent(in) :: approach
      real(wp), intent(in) :: rate
      real(wp) :: slopes(3)

      slopes = self%kernel_slopes(elastic, approach, rate, self%coefficient)
   end function slopes

   !> Set the coefficient of a law that restitutes each impact alike.
   pure subroutine begin_impact(self, speed, changed)
      class(coefficient_damping_type), intent(inout) :: self
      !> Speed of approach at touch [m/s].
      real(wp), intent(in) :: speed
      !> Whether the force has changed.
      logical, intent(out) :: changed
      real(wp) :: before

      before = self%coefficient
      if (self%impact_number > 0.0_wp) then
         self%coefficient = self%impact_number/(1.5_wp*max(speed, slowest_impact))
      end if
      changed = abs(self%coefficient - before) > 0.0_wp
   end subroutine begin_impact

   !> Write the coefficient to a checkpoint or read it back, as it may be that of the last impact.
   subroutine exchange(self, checkpoint)
      class(coefficient_damping_type), intent(inout) :: self
      type(checkpoint_type), intent(inout) :: checkpoint

      call checkpoint%exchange("damping", self%coefficient)
   end subroutine exchange

   !> Hunt-Crossley damping [N], F_el (3/2) alpha d', alpha in s/m.
   pure function hunt_crossley(elastic, approach, rate, coefficient) result(f)
      real(wp), intent(in) :: elastic, approach, rate, coefficient
      real(wp) :: f

      f = 1.5_wp*coefficient*elastic*rate
   end function hunt_crossley

   !> Viscous damping [N], D d d', D in N s/m2.
   pure function viscous(elastic, approach, rate, coefficient) result(f)
      real(wp), intent(in) :: elastic, approach, rate, coefficient
      real(wp) :: f

      f = coefficient*approach*rate
   end function viscous

   !> Derivatives of Hunt-Crossley damping.
   pure function hunt_crossley_slopes(elastic, approach, rate, coefficient) result(slopes)
      real(wp), intent(in) :: elastic, approach, rate, coefficient
      real(wp) :: slopes(3)

      slopes = 1.5_wp*coefficient*[rate, 0.0_wp, elastic]
   end function hunt_crossley_slopes

   !> Derivatives of viscous damping.
   pure function viscous_slopes(elastic, approach, rate, coefficient) result(slopes)
      real(wp), intent(in) :: elastic, approach, rate, coefficient
      real(wp) :: slopes(3)

      slopes = coefficient*[0.0_wp, rate, approach]
   end function viscous_slopes

   !> Tsuji's damping [N], alpha sqrt(m k_n) d^(1/4) d', with k_n d^(1/2) = F_el/d; its
   !> coefficient is alpha sqrt(m) [kg^(1/2)].
   pure function tsuji(elastic, approach, rate, coefficient) result(f)
      real(wp), intent(in) :: elastic, approach, rate, coefficient
      real(wp) :: f

      f = 0.0_wp
      if (approach > 0.0_wp) f = coefficient*sqrt(elastic/approach)*rate
   end function tsuji

   !> Derivatives of Tsuji's damping.
   pure function tsuji_slopes(elastic, approach, rate, coefficient) result(slopes)
      real(wp), intent(in) :: elastic, approach, rate, coefficient
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
      type(bisection_type) :: root

      if (.not. (restitution > 0.0_wp .and. restitution <= 1.0_wp)) then
         d = ieee_value(d, ieee_quiet_nan)
         return
      end if
      call root%begin(0.0_wp, merge(0.0_wp, 1.0_wp/restitution, restitution >= 1.0_wp))
      do while (root%goes_on)
         call root%narrow(number_excess(restitution, root%middle) > 0.0_wp)
      end do
      d = root%middle
   end function hunt_crossley_number

   !> Restitution e of the Hunt-Crossley law at a number D = (3/2) alpha v0, the root of
   !> (1 + e) D = ln((1 + D)/(1 - e D)) in (0, 1].
   pure function hunt_crossley_restitution(number) result(e)
      !> D, >= 0.
      real(wp), intent(in) :: number
      real(wp) :: e
      type(bisection_type) :: root

      e = 1.0_wp
      if (number <= 0.0_wp) return
      call root%begin(0.0_wp, min(1.0_wp, 1.0_wp/number))
      do while (root%goes_on)
         call root%narrow(number_excess(root%middle, number) > 0.0_wp)
      end do
      e = root%middle
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

end module contensou_contact_damping_coefficient
