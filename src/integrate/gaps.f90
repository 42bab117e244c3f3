!> What gaps do within a step: a touch between its ends, spots that appear, contacts too deep.
module contensou_integrate_gaps
   use contensou_base_errors, only : error_type, fatal
   use contensou_base_kinds, only : wp
   use contensou_contact_geometry, only : contact_motion_type, trouble_sudden, trouble_unseen
   use contensou_dynamics_mechanism, only : gap_type
   use contensou_dynamics_spots, only : change_spots, take_back_spots
   use contensou_integrate_step, only : kept_type, look_at_gap, look_at_gaps, march_type, &
      open_step, restore_workspace
   use contensou_special_bisection, only : bisection_type
   implicit none(type, external)
   private

   public :: avoid_dip, find_depth, follow_spots, lift_bound, time_to_fall

   !> Bounds of the gap of an open contact within a step.
   type :: bounds_type
      !> How strongly it bends down over convex surfaces [m/s2].
      real(wp) :: bend = 0.0_wp
      !> Where a surface is concave, of its rate [m/s]; else 0.
      real(wp) :: speed = 0.0_wp
      !> Overlap that goes unseen [m].
      real(wp) :: overlap = 0.0_wp
   end type bounds_type

   !> Overlap within a step that goes unseen, over the smallest radius.
   real(wp), parameter :: unseen_overlap = 2.0e-7_wp

   !> Speed at which nothing moves, and through which a length can be divided [m/s].
   real(wp), parameter :: still = 1.0e-100_wp

   !> Step that cannot be halved any more, in units of the rounding of the time.
   real(wp), parameter :: shortest = 4.0_wp

   !> Looks at the gap of one contact within a step; one that needs more is taken in smaller ones.
   integer, parameter :: most_looks = 2000

   !> How often a step is taken again before its spots are given up.
   integer, parameter :: most_retaken = 200

contains

   !> Gaps of the near contacts and their motion at both ends of the step.
   subroutine look_at_near(self)
      type(march_type), intent(inout) :: self
      logical :: before
      integer :: i

      associate (system => self%motion%system)
         before = .false.
         do i = 1, size(self%gap)
            if (self%seen(i) .or. .not. self%near(i)) cycle
            if (.not. before) call system%set_poses(self%y_before)
            before = .true.
            call system%gap_motion(i, self%gap(i))
         end do
         if (before .or. .not. self%posed) call system%set_poses(self%memory%y)
         do i = 1, size(self%gap)
            self%seen(i) = self%near(i)
            if (.not. self%near(i)) cycle
            self%gap_before(i) = self%gap(i)
            call look_at_gap(self, i)
         end do
      end associate
   end subroutine look_at_near

   !> If a contact closed and opened again within the step, go back to take it in smaller ones.
   subroutine avoid_dip(self, again, error)
      type(march_type), intent(inout) :: self
      !> Whether the march is at the beginning of the step again.
      logical, intent(out) :: again
      !> Set when the integration cannot go on there.
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: t_dip
      integer :: index
      logical :: looked, near, any_near

      again = .false.
      associate (memory => self%memory, t => self%memory%t)
         call find_near(self, any_near)
         if (.not. any_near) then
            self%seen = .false.
            call pass_bound(self)
            return
         end if
         call look_at_near(self)
         call suspect_dips(self, index)
         t_dip = huge(t_dip)
         looked = index > 0
         if (looked) then
            self%motion%system%contacts%felt = 0.0_wp
            call find_dip(self, t_dip)
         end if
         ! A step that ends at once where a contact is too deep has no inside.
         if (t_dip > t .and. t > self%t_before) then
            call suspect_near(self)
            near = any(self%suspect)
            if (near) then
               if (.not. looked) self%motion%system%contacts%felt = 0.0_wp
               call follow_gaps(self, t_dip, index)
            end if
            if (near .or. looked) call doubt_interpolant(self, t_dip, index)
         end if
         again = t_dip < t
         if (again) then
            if (t - self%t_before <= shortest*spacing(t)) then
               ! There are no smaller ones.
               self%motion%system%trouble = index
               self%motion%system%trouble_code = trouble_unseen
               call fatal(error, "a gap cannot be followed")
               return
            end if
            t = self%t_before
            memory%y = self%y_before
            where (self%seen) self%gap = self%gap_before
            self%clearance = 0.0_wp
            memory%bounded_until = t_dip
            call self%integrator%bound_step((t_dip - t)/4.0_wp)
            call self%integrator%restart(t, memory%y, error)
         else
            call pass_bound(self)
         end if
      end associate
   end subroutine avoid_dip

   !> Lift the bound of the steps once what it was for is passed.
   subroutine pass_bound(self)
      type(march_type), intent(inout) :: self

      if (self%memory%t > self%memory%bounded_until) call lift_bound(self)
   end subroutine pass_bound

   !> Let the steps be as long as they were before they were made smaller for the sake of gaps.
   subroutine lift_bound(self)
      type(march_type), intent(inout) :: self

      if (self%memory%bounded_until <= 0.0_wp) return
      call self%integrator%bound_step(self%plan%max_step)
      self%memory%bounded_until = 0.0_wp
   end subroutine lift_bound

   !> Where the interpolant has felt the force of an open contact it is of no use: the step is
   !> taken in smaller ones.
   pure subroutine doubt_interpolant(self, t_dip, index)
      type(march_type), intent(in) :: self
      !> The time [s].
      real(wp), intent(inout) :: t_dip
      !> Contact that was felt; unchanged if none was.
      integer, intent(inout) :: index
      integer :: i

      do i = 1, size(self%gap)
         if (.not. is_open(self, i) .or. self%events(i) /= 0) cycle
         associate (felt => self%motion%system%contacts(i)%felt)
            if (felt <= 0.0_wp) cycle
            if (felt <= unseen(self, i)) cycle
         end associate
         t_dip = min(t_dip, 0.5_wp*(self%t_before + self%memory%t))
         index = i
      end do
   end subroutine doubt_interpolant

   !> Give the places of contacts with several spots at the end of the step to these; where one
   !> touches that was not followed, go back to take the step with it.
   subroutine follow_spots(self, again, error)
      type(march_type), intent(inout) :: self
      !> Whether the march is at the beginning of the step again.
      logical, intent(out) :: again
      !> Set where they cannot be followed.
      type(error_type), allocatable, intent(out) :: error
      logical :: born
      integer :: index, trouble

      associate (system => self%motion%system, memory => self%memory, t => self%memory%t)
         call system%set_poses(memory%y)
         call change_spots(system, memory%closed, self%events < 0, again, index, trouble)
         again = again .and. t > self%t_before
         if (.not. again) self%retaken = 0
         if (index == 0 .and. again) then
            call system%set_poses(self%y_before)
            call take_back_spots(system, memory%closed, born, index, trouble)
            self%retaken = self%retaken + 1
            if (index == 0 .and. self%retaken > most_retaken) then
               index = findloc(system%contacts%spots > 1, .true., dim=1)
               trouble = trouble_sudden
            end if
         end if
         if (index > 0) then
            system%trouble = index
            system%trouble_code = trouble
            call fatal(error, "a contact does not know where it touches")
            return
         end if
         if (.not. again) return
         if (born) then
            memory%bounded_until = t
            call self%integrator%bound_step((t - self%t_before)/4.0_wp)
         end if
         t = self%t_before
         memory%y = self%y_before
         self%motion%unfound = .false.
         call look_at_gaps(self)
         call self%integrator%restart(t, memory%y, error)
      end associate
   end subroutine follow_spots

   !> Whether a contact is open, as one is whose gap was zero at the beginning and is not any more.
   pure logical function is_open(self, index)
      type(march_type), intent(in) :: self
      !> Contact.
      integer, intent(in) :: index

      is_open = .not. self%memory%closed(index)
      if (self%memory%undecided(index)) is_open = self%gap(index)%value > self%resolution
   end function is_open

   !> Overlap within a step that goes unseen, from that with which a contact has opened [m].
   pure real(wp) function unseen(self, index)
      type(march_type), intent(in) :: self
      !> Contact.
      integer, intent(in) :: index

      unseen = unseen_overlap*self%motion%system%contacts(index)%law%geometry%smallest_radius() &
         + max(-self%gap_before(index)%value, 0.0_wp)
   end function unseen

   !> Bounds of the gap of a contact in the step.
   !>
   !> The distance of two convex bodies without spin that move uniformly never bends down. What
   !> spins do is bounded; accelerations are smooth, or the step were shorter.
   pure type(bounds_type) function bounds_of(self, index) result(bounds)
      type(march_type), intent(in) :: self
      !> Contact.
      integer, intent(in) :: index

      associate (now => self%gap(index), before => self%gap_before(index))
         bounds%bend = 3.0_wp*abs(now%rate - before%rate)/(self%memory%t - self%t_before) &
            + max(now%bend, before%bend)
         bounds%speed = max(now%speed, before%speed)
         bounds%overlap = unseen(self, index)
      end associate
   end function bounds_of

   !> Time for which a gap cannot fall below an overlap that goes unseen [s].
   !>
   !> Over a hollow the gap bends down the more, the nearer the surfaces are to conforming: what is
   !> known here holds for as long only as that cannot have doubled. But no gap falls faster than
   !> the bodies move.
   pure real(wp) function reach(gap, rate, bounds)
      !> The gap here.
      type(gap_type), intent(in) :: gap
      !> Its rate away from here [m/s].
      real(wp), intent(in) :: rate
      type(bounds_type), intent(in) :: bounds
      real(wp) :: height

      reach = 0.0_wp
      height = gap%value + bounds%overlap
      if (height <= 0.0_wp) return
      reach = time_to_fall(height, rate, bounds%bend + 2.0_wp*gap%sharpness*bounds%speed**2)
      if (bounds%speed > still) reach = max(min(reach, 0.5_wp/(gap%sharpness*bounds%speed)), &
         height/bounds%speed)
   end function reach

   !> Time after which a height is zero whose rate goes on to change as it does [s]; a quarter of
   !> the largest number if it never is, so that sums are finite.
   pure real(wp) function time_to_fall(height, rate, bend) result(time)
      !> > 0 [m].
      real(wp), intent(in) :: height
      !> Its rate [m/s], and how fast that falls [m/s^2].
      real(wp), intent(in) :: rate, bend
      real(wp) :: square, root

      time = 0.25_wp*huge(time)
      square = rate**2 + 2.0_wp*bend*height
      if (square < 0.0_wp .or. (rate >= 0.0_wp .and. bend <= 0.0_wp)) return
      root = sqrt(square)
      if (rate > 0.0_wp) then
         time = (rate + root)/max(bend, tiny(bend)*max(rate, 1.0_wp)*4.0_wp)
      else
         time = 2.0_wp*height/max(root - rate, tiny(root)*max(height, 1.0_wp)*4.0_wp)
      end if
   end function time_to_fall

   !> Find the contacts at whose gaps to look: those that are open and not so far away that they
   !> cannot have touched in the step.
   subroutine find_near(self, any_near)
      type(march_type), intent(inout) :: self
      !> Whether there is one.
      logical, intent(out) :: any_near
      real(wp) :: fastest, time
      logical :: may_pass
      integer :: i

      any_near = .true.
      if (.not. self%may_skip) then
         self%near = .true.
         return
      end if
      ! Looks within a step are part of the counts that others compare: a method that pays for them
      ! looks at each step.
      may_pass = self%may_pass .and. self%integrator%free_interpolation
      time = self%memory%t - self%t_before
      any_near = .false.
      do i = 1, size(self%near)
         self%near(i) = self%events(i) /= 0 .or. self%memory%undecided(i) &
            .or. .not. (may_pass .or. self%memory%closed(i))
         any_near = any_near .or. self%near(i)
         if (self%near(i) .or. self%memory%closed(i)) cycle
         fastest = self%motion%system%fastest(i, self%memory%y, time)
         ! Between the ends it may be faster, though not by much.
         self%clearance(i) = self%clearance(i) - 2.0_wp*max(fastest, self%fastest(i))*time
         self%fastest(i) = fastest
         self%near(i) = self%clearance(i) <= 0.0_wp
         any_near = any_near .or. self%near(i)
      end do
   end subroutine find_near

   !> Suspect the open contacts whose gaps fall at the beginning of the step and rise at its end.
   pure subroutine suspect_dips(self, first)
      type(march_type), intent(inout) :: self
      !> The first of them; 0 for none.
      integer, intent(out) :: first
      integer :: i

      first = 0
      do i = 1, size(self%suspect)
         if (.not. (is_open(self, i) .and. self%near(i)) .or. (self%events(i) /= 0 &
            .and. .not. self%memory%undecided(i))) then
            self%suspect(i) = .false.
         else
            self%suspect(i) = self%gap_before(i)%rate < 0.0_wp .and. self%gap(i)%rate > 0.0_wp &
               .and. .not. self%motion%system%contacts(i)%leaving
            if (self%suspect(i) .and. first == 0) first = i
         end if
      end do
   end subroutine suspect_dips

   !> Suspect the open contacts whose gaps may fall below zero as seen from the ends of the step.
   pure subroutine suspect_near(self)
      type(march_type), intent(inout) :: self
      type(bounds_type) :: bounds
      integer :: i

      do i = 1, size(self%suspect)
         self%suspect(i) = self%near(i) .and. is_open(self, i)
         if (.not. self%suspect(i)) cycle
         bounds = bounds_of(self, i)
         associate (now => self%gap(i), before => self%gap_before(i), &
            time => self%memory%t - self%t_before)
            if (.not. now%speed > 0.0_wp) then
               ! Most are far above what they can fall.
               self%suspect(i) = now%value <= time*(max(now%rate, 0.0_wp) + bounds%bend*time)
               if (.not. self%suspect(i)) cycle
            end if
            self%suspect(i) = reach(before, before%rate, bounds) + reach(now, -now%rate, bounds) &
               < self%memory%t - self%t_before
         end associate
      end do
   end subroutine suspect_near

   !> First time within the step at which one of the gaps is below zero by more than what goes
   !> unseen; a time after the step if none is. From each place the next is where the gap could be
   !> so at the earliest. Where a gap is so near zero that it cannot be followed to the end of the
   !> step, the time to which it was. Nothing that follows depends on it.
   subroutine follow_gaps(self, t_dip, index)
      type(march_type), intent(inout) :: self
      !> The time [s].
      real(wp), intent(inout) :: t_dip
      !> Contact of that gap; unchanged if the time is.
      integer, intent(inout) :: index
      type(kept_type) :: kept
      type(gap_type) :: gap
      type(bounds_type) :: bounds
      real(wp) :: t, t_clear, y(self%motion%n)
      integer :: i, k

      associate (system => self%motion%system, t_end => self%memory%t)
         call open_step(self, 0.5_wp*(self%t_before + t_end), kept)
         do i = 1, size(self%suspect)
            if (.not. self%suspect(i)) cycle
            bounds = bounds_of(self, i)
            t_clear = t_end - reach(self%gap(i), -self%gap(i)%rate, bounds)
            t = self%t_before
            gap = self%gap_before(i)
            do k = 1, most_looks
               t = t + max(reach(gap, gap%rate, bounds), 4.0_wp*spacing(t))
               if (t >= min(t_clear, t_dip)) exit
               call self%integrator%interpolate(t, y)
               call system%set_poses(y)
               call system%gap_motion(i, gap)
               if (2.0_wp*gap%value <= min(self%gap_before(i)%value, 0.0_wp) - bounds%overlap) exit
            end do
            if (t >= min(t_clear, t_dip)) cycle
            t_dip = t
            index = i
         end do
         call restore_workspace(self%motion, kept)
      end associate
   end subroutine follow_gaps

   !> Find where within the step a contact becomes too deep, and move its end there.
   subroutine find_depth(self, too_deep)
      !> The march; `too_deep` of its system names the contact.
      type(march_type), intent(inout) :: self
      !> Whether a contact of the accepted state is too deep, not only one of a trial.
      logical, intent(out) :: too_deep
      type(bisection_type) :: search
      integer :: deep

      deep = deepest_of(self)
      too_deep = deep > 0
      if (.not. too_deep) return
      call search%begin(self%t_before, self%memory%t, steps=60)
      do while (search%goes_on)
         call self%integrator%interpolate(search%middle, self%memory%y)
         deep = deepest_of(self)
         if (deep > 0) self%motion%system%too_deep = deep
         call search%narrow(deep > 0)
      end do
      self%memory%t = search%high
      call self%integrator%interpolate(search%high, self%memory%y)
   end subroutine find_depth

   !> The contact that is the most too deep in the state reached; 0 if none is.
   integer function deepest_of(self) result(deep)
      !> The march; the workspace of its system is changed.
      type(march_type), intent(inout) :: self
      real(wp), dimension(self%motion%n_events) :: gap, excess
      integer :: i

      associate (system => self%motion%system)
         call system%gaps(self%memory%y, gap)
         do i = 1, size(gap)
            associate (contact => system%contacts(i))
               excess(i) = -gap(i) - contact%deepest(system%pose(contact%a), &
                  system%pose(contact%b), gap(i))
            end associate
         end do
      end associate
      deep = 0
      if (any(excess > 0.0_wp)) deep = maxloc(excess, dim=1)
   end function deepest_of

   !> First time within the step at which an open gap that falls and rises again is closed; a time
   !> after the step if there is none.
   subroutine find_dip(self, t_dip)
      !> The march, with the contacts whose gap is open at both ends of the step, falls at the first
      !> and rises at the second.
      type(march_type), intent(inout) :: self
      !> The time [s].
      real(wp), intent(out) :: t_dip
      real(wp) :: y(self%motion%n), gap
      type(contact_motion_type) :: now
      type(bisection_type) :: search
      integer :: i

      t_dip = huge(t_dip)
      ! What the interpolation feels is judged whether a contact is looked at or not.
      call self%integrator%interpolate(0.5_wp*(self%t_before + self%memory%t), y)
      associate (system => self%motion%system)
         do i = 1, size(self%suspect)
            if (.not. self%suspect(i)) cycle
            if (out_of_reach(self, i)) cycle
            call search%begin(self%t_before, self%memory%t, steps=60)
            do while (search%goes_on)
               call self%integrator%interpolate(search%middle, y)
               call system%set_poses(y)
               associate (contact => system%contacts(i))
                  call contact%find_gap(system%pose(contact%a), system%pose(contact%b), gap)
               end associate
               if (gap < -self%resolution) then
                  t_dip = min(t_dip, search%middle)
                  exit
               end if
               call system%observe(i, now)
               call search%narrow(now%gap_rate() >= 0.0_wp)
            end do
         end do
      end associate
   end subroutine find_dip

   !> Whether a gap that is open at both ends of the step is wider than its bodies can have moved.
   pure logical function out_of_reach(self, index)
      type(march_type), intent(in) :: self
      !> Contact.
      integer, intent(in) :: index
      real(wp) :: fastest, time

      time = self%memory%t - self%t_before
      ! Between the ends they may be faster, though not by much.
      fastest = 2.0_wp*max(self%motion%system%fastest(index, self%y_before, time), &
         self%motion%system%fastest(index, self%memory%y, time))
      out_of_reach = min(self%gap_before(index)%value, self%gap(index)%value) &
         > fastest*time
   end function out_of_reach

end module contensou_integrate_gaps
