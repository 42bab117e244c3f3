!> `auto`: which method suits a motion, from its contacts.
!>
!> A step of `explicit8` costs about as much as a step of `cvode_bdf` (twelve right-hand sides
!> against one and the algebra of the implicit method), so the one with the longer steps is the
!> cheaper one. The ringing of a contact has to be followed by either; a rate that only decays, that
!> of a strongly damped contact or of friction that sticks, bounds the steps of `explicit8` alone.
!> The choice is where a run begins; `march` changes it where the steps prove it wrong.
module contensou_integrate_choice
   use contensou_base_kinds, only : wp
   use contensou_base_numbers, only : power_text, to_text
   use contensou_base_vectors, only : cross
   use contensou_contact_geometry, only : contact_point_type, contact_variation_type, &
      rolling_velocity
   use contensou_contact_tangential_spot, only : spring_spot_type
   use contensou_dynamics_equations, only : system_type
   use contensou_dynamics_mechanism, only : body_type, relative_motion, slip_velocity
   use contensou_dynamics_scene, only : motion_free, motion_rotor, moves_freely
   use contensou_dynamics_state, only : spin_of
   use contensou_integrate_motion, only : motion_type
   implicit none(type, external)
   private

   public :: explicit_reach, choice_type, choose_method, choice_text

   !> Length of the stable step of `explicit8` along a rate that only decays, times that rate [-].
   real(wp), parameter :: explicit_reach = 5.0_wp

   !> What a choice rests on.
   type :: choice_type
      !> The method: cvode_bdf or explicit8.
      character(len=11) :: method = "explicit8"
      !> Contact that decided: the stiffest one; 0 without contacts.
      integer :: contact = 0
      integer :: unknowns = 0
      !> Angular frequency of that contact about its load under gravity, or about half the largest
      !> force of an impact at velocity_scale [rad/s].
      real(wp) :: frequency = 0.0_wp
      !> Its damping ratio there [-].
      real(wp) :: damping_ratio = 0.0_wp
      !> Rate at which its friction takes away sliding at the beginning: f N (1/m + r^2/I) over the
      !> largest of delta, the sliding velocity, a w, what the tolerance resolves, and the creep at
      !> which what rolls would slip everywhere [1/s]. Where it sticks by tangential elasticity, the
      !> rate at which rolling by a law of creep carries strain out of the spot.
      real(wp) :: friction_rate = 0.0_wp
      !> Angular frequency at which it rings along its tangent plane, sqrt(k (1/m + r^2/I)), where
      !> it sticks by tangential elasticity; else 0 [rad/s].
      real(wp) :: shear_frequency = 0.0_wp
      !> Fastest rate that only decays, of a contact that is closed at the beginning [1/s].
      real(wp) :: fastest = 0.0_wp
   end type choice_type

   !> A rate that only decays bounds the steps of an explicit method if it exceeds all that is to
   !> be followed by this factor. Between 3 and 30 either method does.
   real(wp), parameter :: stiff_from = 10.0_wp

   !> Rate at which a law of creep carries strain out of a spot that rolls steadily, over the
   !> velocity of the material through it and its half-length [-].
   real(wp), parameter :: carried_out = 4.0_wp

contains

   !> The method for a motion, by the rates of its contacts where it begins.
   subroutine choose_method(motion, y, choice)
      class(motion_type), intent(inout) :: motion
      real(wp), intent(in) :: y(:)
      type(choice_type), intent(out) :: choice
      real(wp) :: gap(motion%n_events), frequency, ratio, friction, shear, decay, followed
      integer :: i

      choice%unknowns = motion%n
      if (motion%n_events == 0) return
      call motion%system%gaps(y, gap)
      followed = fastest_spin(motion%system, y)
      do i = 1, motion%n_events
         call figures_of(motion, y, i, gap(i), frequency, ratio, friction, shear)
         ! Beyond the critical damping one of two decays is fast.
         decay = 0.0_wp
         if (ratio > 1.0_wp) decay = frequency*(ratio + sqrt(ratio**2 - 1.0_wp))
         decay = max(decay, friction)
         if (gap(i) > motion%scales%length) decay = 0.0_wp
         if (decay > choice%fastest .or. choice%contact == 0) then
            choice%contact = i
            choice%frequency = frequency
            choice%damping_ratio = ratio
            choice%friction_rate = friction
            choice%shear_frequency = shear
            choice%fastest = decay
         end if
         if (ratio < 1.0_wp) followed = max(followed, frequency*sqrt(1.0_wp - ratio**2))
         followed = max(followed, shear)
      end do
      if (choice%fastest > stiff_from*followed) choice%method = "cvode_bdf"
   end subroutine choose_method

   !> Largest angular velocity of a free body [rad/s].
   pure real(wp) function fastest_spin(system, y) result(spin)
      type(system_type), intent(in) :: system
      real(wp), intent(in) :: y(:)
      integer :: i

      spin = 0.0_wp
      do i = 1, size(system%bodies)
         if (system%bodies(i)%motion == motion_free) spin = max(spin, norm2(spin_of(y, i)))
      end do
   end function fastest_spin

   !> Frequency, damping ratio, rate of friction and tangential frequency of a contact.
   subroutine figures_of(motion, y, index, gap, frequency, ratio, friction, shear)
      !> The motion; the poses of its system are those of the state.
      class(motion_type), intent(inout) :: motion
      real(wp), intent(in) :: y(:)
      !> Contact.
      integer, intent(in) :: index
      !> Its gap [m].
      real(wp), intent(in) :: gap
      !> Angular frequency [rad/s].
      real(wp), intent(out) :: frequency
      !> Damping ratio [-].
      real(wp), intent(out) :: ratio
      !> Rate of friction [1/s].
      real(wp), intent(out) :: friction
      !> Angular frequency along the tangent plane [rad/s]; 0 for what does not stick elastically.
      real(wp), intent(out) :: shear
      type(contact_point_type) :: at
      type(contact_variation_type) :: variation
      real(wp) :: yields, turns, load, approach, stiffness, slopes(3), velocity(3), spin(3)
      real(wp) :: slip, limit, rolling(3), along, across, carried, arm(3)
      type(spring_spot_type) :: spot

      ratio = 0.0_wp
      friction = 0.0_wp
      shear = 0.0_wp
      associate (system => motion%system, c => motion%system%contacts(index))
         yields = mobility(system, c%a) + mobility(system, c%b)
         stiffness = c%law%normal%stiffness
         load = norm2(system%gravity)/yields
         if (load <= 0.0_wp) load = 0.5_wp*stiffness*(1.25_wp*motion%scales%velocity**2 &
            /(yields*stiffness))**0.6_wp
         approach = (load/stiffness)**(2.0_wp/3.0_wp)
         frequency = sqrt(1.5_wp*stiffness*sqrt(approach)*yields)
         if (allocated(c%law%damping)) then
            slopes = c%law%damping%slopes(load, approach, 0.0_wp)
            ratio = 0.5_wp*abs(slopes(3))*yields/frequency
         end if
         if (.not. allocated(c%law%friction)) return
         associate (a => system%pose(c%a), b => system%pose(c%b))
            if (c%track%lost .or. c%track%away) return
            call c%locate(a, b, gap, at)
            call relative_motion(a, b, at%point, velocity, spin)
            slip = norm2(slip_velocity(velocity, at%normal))
            slip = max(slip, c%law%friction%delta, &
               c%law%normal%major_axis(approach)*abs(dot_product(spin, at%normal)))
            carried = 0.0_wp
            if (.not. allocated(c%tangential)) then
               slip = max(slip, sqrt(system%resolution%of(a, b, at%point)))
            else if (allocated(c%tangential%carry)) then
               call c%law%geometry%vary(a, b, c%track, at, variation)
               rolling = slip_velocity(rolling_velocity(variation, velocity, spin), at%normal)
               along = dot_product(rolling, at%major)
               across = dot_product(rolling, cross(at%normal, at%major))
               carried = carried_out*norm2([along, across/c%law%normal%shape%k]) &
                  /c%law%normal%major_axis(approach)
            end if
            if (allocated(c%law%steady)) then
               call c%law%geometry%vary(a, b, c%track, at, variation)
               slip = max(slip, c%law%steady%reach(c%law%normal%shape, load, &
                  c%law%normal%major_axis(approach), norm2(slip_velocity(rolling_velocity( &
                  variation, velocity, spin), at%normal))))
            end if
            turns = 0.0_wp
            if (c%a > 0) then
               arm = at%point - a%position
               turns = turns + leverage(system%bodies(c%a), norm2(arm))
            end if
            if (c%b > 0) then
               arm = at%point - b%position
               turns = turns + leverage(system%bodies(c%b), norm2(arm))
            end if
         end associate
         limit = c%law%friction%coefficient*load
         if (allocated(c%tangential)) then
            spot = spring_spot_type(c%law%normal%shape, c%law%normal%major_axis(approach), limit, &
               c%tangential%modulus, c%tangential%poisson)
            shear = sqrt(maxval(spot%stiffness(1:2))*(yields + turns))
            ! It sticks while sliding does not outrun the ringing, whose speed is at most limit
            ! (yields + turns)/shear; beyond, friction takes sliding away more slowly than that.
            if (limit*(yields + turns) >= shear*slip) then
               friction = carried
               return
            end if
            shear = 0.0_wp
         end if
         if (slip > 0.0_wp) friction = limit*(yields + turns)/slip
      end associate
   end subroutine figures_of

   !> Inverse mass of a body that yields [1/kg].
   pure real(wp) function mobility(system, body)
      type(system_type), intent(in) :: system
      !> Its index; 0 for the ground.
      integer, intent(in) :: body

      mobility = 0.0_wp
      if (body == 0) return
      associate (b => system%bodies(body))
         if (moves_freely(b%motion)) mobility = 1.0_wp/b%mass
      end associate
   end function mobility

   !> What its rotation adds to the mobility of the surface of a body [1/kg].
   pure real(wp) function leverage(body, length)
      type(body_type), intent(in) :: body
      !> Lever arm [m].
      real(wp), intent(in) :: length

      leverage = 0.0_wp
      if (body%motion == motion_free) leverage = length**2/minval(body%inertia)
      if (body%motion == motion_rotor) leverage = length**2/minval(body%inertia(:2))
   end function leverage

   !> Why a method was chosen, in words.
   function choice_text(choice, contact) result(text)
      type(choice_type), intent(in) :: choice
      !> Name of the contact that decided; blank without contacts.
      character(len=*), intent(in) :: contact
      character(len=:), allocatable :: text

      if (choice%contact == 0) then
         text = trim(choice%method) // ", because there is no contact that could be stiff"
         return
      end if
      text = "because contact " // contact // " "
      if (choice%method == "explicit8") then
         text = text // "decays " // trim(merge("not much faster", "no faster      ", &
            choice%shear_frequency > 0.0_wp .and. &
            choice%fastest > max(choice%frequency, choice%shear_frequency))) // " than it rings"
      else
         text = text // "decays far faster than anything turns or rings"
      end if
      text = trim(choice%method) // ", " // text // ": frequency " // &
         power_text(choice%frequency, 2) // " rad/s, damping ratio " // &
         power_text(choice%damping_ratio, 2)
      if (choice%shear_frequency > 0.0_wp) then
         text = text // ", tangential frequency " // power_text(choice%shear_frequency, 2) // &
            " rad/s"
         if (choice%friction_rate > 0.0_wp) text = text // ", creep " // &
            power_text(choice%friction_rate, 2) // " 1/s"
      else
         text = text // ", friction " // power_text(choice%friction_rate, 2) // " 1/s"
      end if
      text = text // "; " // to_text(choice%unknowns) // " unknowns"
   end function choice_text

end module contensou_integrate_choice
