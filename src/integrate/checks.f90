!> What no tolerance tells of: the balance of energy, sudden overlaps, positions too large.
module contensou_integrate_checks
   use contensou_base_errors, only : error_type, fatal
   use contensou_base_kinds, only : wp
   use contensou_base_numbers, only : power_text
   use contensou_contact_geometry, only : trouble_far, trouble_missed, trouble_none, &
      trouble_sudden
   use contensou_dynamics_reports, only : energy_type, find_energy
   use contensou_dynamics_rests, only : sunk
   use contensou_dynamics_state, only : position_of
   use contensou_integrate_motion, only : motion_type
   use contensou_integrate_step, only : keep_workspace, kept_type, march_type, restore_workspace, &
      zero_gap
   implicit none(type, external)
   private

   public :: check_step, begin_balance, check_balance

   !> Share of the energy that moved by which the balance may be off before a run is ended ...
   real(wp), parameter :: leak = 1.0e-3_wp

   !> ... or this many times the tolerance, where that is more ...
   real(wp), parameter :: leak_of_tolerance = 1.0e3_wp

   !> ... the share of that from which on it is told at the end ...
   real(wp), parameter :: warned = 0.1_wp

   !> ... and share of the whole energy that rounding may take.
   real(wp), parameter :: rounded = 1.0e-12_wp

   !> Resolution of the time of an event, in units of its rounding.
   real(wp), parameter :: time_of_event = 1.0e4_wp

   !> Gap at an event, in units of the tolerance of positions: it is found on an interpolant.
   real(wp), parameter :: place_of_event = 1.0e3_wp

   !> Steps after which what a tolerance does not tell of is checked, beside touches and the end.
   integer, parameter :: checked_steps = 100

contains

   !> Check what a tolerance does not tell of: after touches, at the end, and now and then.
   subroutine check_step(self, error)
      type(march_type), intent(inout) :: self
      !> Set when something is wrong.
      type(error_type), allocatable, intent(out) :: error

      logical :: twice

      ! A touch of what is closed, or a lift-off of what is open: one between them was missed.
      twice = any(self%events /= 0 .and. (self%events < 0 .eqv. self%memory%closed))
      self%unchecked = self%unchecked + 1
      if (self%unchecked < checked_steps .and. .not. any(self%events < 0) .and. .not. twice &
         .and. self%memory%row <= self%rows) return
      self%unchecked = 0
      call check_resolution(self, error)
      if (.not. allocated(error)) call check_gaps(self, twice, error)
      if (.not. allocated(error)) call check_balance(self, error)
   end subroutine check_step

   !> See whether surfaces that touch overlap without having approached, and whether those overlap
   !> that are taken to.
   subroutine check_gaps(self, twice, error)
      type(march_type), intent(inout) :: self
      !> Whether one of the events is that of a contact that was so before.
      logical, intent(in) :: twice
      !> Set where gaps are not what is known of them.
      type(error_type), allocatable, intent(out) :: error
      type(kept_type) :: kept
      real(wp), dimension(self%motion%n_events) :: before, gap, rate
      real(wp) :: explained
      integer :: i, trouble

      associate (system => self%motion%system, memory => self%memory)
         call keep_workspace(self%motion, kept)
         if (twice) then
            call system%gaps(self%y_before, before)
            call restore_workspace(self%motion, kept)
         end if
         call system%gaps(memory%y, gap)
         call system%gap_rates(memory%y, rate)
         do i = 1, size(gap)
            associate (contact => system%contacts(i), closed => memory%closed(i), &
               event => self%events(i))
               if (contact%track%lost .or. contact%track%away .or. memory%undecided(i)) cycle
               ! An event is where the gap is zero, to the resolution of time.
               explained = time_of_event*epsilon(explained)*(abs(memory%t) + (memory%t &
                  - self%t_before))*(abs(rate(i)) + abs(self%gap_before(i)%rate))
               explained = explained + 16.0_wp*zero_gap(memory%y) &
                  + place_of_event*self%motion%scales%rtol*self%motion%scales%length
               ! One that has just opened may close below zero.
               if (contact%rigid) explained = explained &
                  + sunk*contact%law%geometry%smallest_radius()
               trouble = trouble_none
               if (event < 0 .and. .not. closed) then
                  if (-gap(i) > explained) trouble = trouble_sudden
               else if (contact%rigid .or. (event > 0 .and. closed)) then
                  cycle
               else if (event /= 0) then
                  if (is_other(before(i), closed, explained)) trouble = trouble_missed
               else
                  if (is_other(gap(i), closed, explained)) trouble = trouble_missed
               end if
            end associate
            if (trouble == trouble_none) cycle
            system%trouble = i
            system%trouble_code = trouble
            call fatal(error, "a contact does not know where it touches")
            return
         end do
         call restore_workspace(self%motion, kept)
      end associate
   end subroutine check_gaps

   !> Whether a gap is not that of a contact that is closed, or not.
   pure logical function is_other(gap, closed, explained)
      real(wp), intent(in) :: gap
      logical, intent(in) :: closed
      !> What is zero [m].
      real(wp), intent(in) :: explained

      is_other = merge(gap, -gap, closed) > explained
   end function is_other

   !> Take note of the energy at the beginning.
   subroutine begin_balance(self)
      type(march_type), intent(inout) :: self
      type(energy_type) :: energy
      type(kept_type) :: kept

      associate (memory => self%memory)
         call keep_workspace(self%motion, kept)
         call find_energy(self%motion%system, memory%t, memory%y, energy)
         call restore_workspace(self%motion, kept)
         memory%energy = energy%total()
         memory%potential = energy%potential
         memory%energy_moved = max(energy%kinetic, energy%elastic)
      end associate
   end subroutine begin_balance

   !> See whether the energy is where it should be, and what is lost in friction remains so.
   subroutine check_balance(self, error)
      type(march_type), intent(inout) :: self
      !> Set when it is off by more than the tolerance explains.
      type(error_type), allocatable, intent(out) :: error
      type(energy_type) :: energy
      type(kept_type) :: kept
      real(wp) :: off, bound, back
      character(len=48) :: digits

      associate (memory => self%memory, motion => self%motion)
         call keep_workspace(motion, kept)
         call find_energy(motion%system, memory%t, memory%y, energy)
         call restore_workspace(motion, kept)
         memory%energy_moved = max(memory%energy_moved, energy%kinetic, energy%elastic, &
            abs(energy%potential - memory%potential), abs(energy%friction), &
            abs(energy%damping), abs(energy%applied))
         off = energy%total() - memory%energy
         bound = max(leak, leak_of_tolerance*motion%scales%rtol) &
            *max(memory%energy_moved, motion%scales%energy) &
            + rounded*max(abs(memory%energy), abs(energy%potential))
         memory%lost = max(memory%lost, energy%friction - energy%stored)
         back = memory%lost - (energy%friction - energy%stored)
         if (back > bound) then
            write(digits, "(es9.2, a, es9.2)") back, " J of", memory%energy_moved
            call fatal(error, "friction has given back what was lost in it:" // trim(digits) // &
               " J that moved. A smaller integrator.rtol or integrator.max_step keeps it " // &
               "where steps are to blame")
            return
         end if
         if (abs(off) <= bound) then
            if (abs(off) > warned*bound) memory%imbalance = max(memory%imbalance, &
               abs(off)/max(memory%energy_moved, tiny(off)))
            ! At the end it is told.
            if (memory%imbalance <= 0.0_wp .or. memory%row <= self%rows) return
            write(digits, "(es9.2)") memory%imbalance
            call self%observer%warn("the energy balance was off by" // trim(digits) // &
               " of the energy that moved: " // remedy(motion))
            return
         end if
         write(digits, "(es9.2, a, es9.2)") abs(off), " J of", memory%energy_moved
         call fatal(error, "energy has " // trim(merge("appeared   ", "disappeared", &
            off > 0.0_wp)) // " that no force gave or took:" // trim(digits) // &
            " J that moved. A smaller integrator.rtol or integrator.max_step closes the " // &
            "balance where steps are to blame; a contact whose surfaces touch in two places " // &
            "needs two contacts")
      end associate
   end subroutine check_balance

   !> What closes a balance.
   function remedy(motion) result(text)
      class(motion_type), intent(in) :: motion
      character(len=:), allocatable :: text

      if (motion%system%constraints%n_rigid == 0) then
         text = "a smaller integrator.rtol closes it"
      else
         ! They take a finer tolerance than is asked for.
         text = "an integrator.rtol below " // power_text(motion%scales%rtol, 2) // &
            ", which the steps had as rigid contacts need it, closes it, except where " // &
            "surfaces of rigid contacts all but conform, as a ball that just fits into a " // &
            "ring: there other dimensions do"
      end if
   end function remedy

   !> See whether the rounding of positions is small against the overlaps where surfaces touch, or
   !> are as close as that.
   subroutine check_resolution(self, error)
      type(march_type), intent(inout) :: self
      !> Set where it is not.
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: largest(0:size(self%motion%system%bodies)), gap(self%motion%n_events), far
      integer :: i

      associate (system => self%motion%system)
         largest(0) = 0.0_wp
         do i = 1, size(system%bodies)
            largest(i) = maxval(abs(position_of(self%memory%y, i)))
         end do
         if (all(maxval(largest) <= system%contacts%largest_position)) return
         call system%gaps(self%memory%y, gap)
         do i = 1, size(gap)
            associate (contact => system%contacts(i))
               far = max(largest(contact%a), largest(contact%b))
               if (far <= contact%largest_position .or. gap(i) > 64.0_wp*spacing(far)) cycle
               system%trouble = i
               system%trouble_code = trouble_far
               call fatal(error, "a contact is not resolved")
               return
            end associate
         end do
      end associate
   end subroutine check_resolution

end module contensou_integrate_checks
