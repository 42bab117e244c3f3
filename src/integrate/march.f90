!> March a motion from its initial state to the end: rows at fixed intervals, touch and lift-off
!> as events, a chance to stop after every step.
module contensou_integrate_march
   use contensou_base_errors, only : error_type, fatal
   use contensou_base_kinds, only : wp
   use contensou_dynamics_constraints, only : constraints_type
   use contensou_dynamics_reports, only : energy_type, find_energy
   use contensou_dynamics_spots, only : assign_spots
   use contensou_integrate_checks, only : begin_balance, check_step
   use contensou_integrate_choice, only : choice_type, choose_method, explicit_reach
   use contensou_integrate_ends, only : end_here, heed_conforming, watch_stops
   use contensou_integrate_events, only : begin_impact, begin_rigid, begin_states, decide, &
      note_separation, take_events, watch_contacts
   use contensou_integrate_gaps, only : avoid_dip, find_depth, follow_spots, lift_bound
   use contensou_integrate_history, only : doubt_memory, remember
   use contensou_integrate_integrator, only : statistics_type
   use contensou_integrate_memory, only : memory_type, plan_type, row_count
   use contensou_integrate_motion, only : motion_type
   use contensou_integrate_observer, only : observer_type
   use contensou_integrate_pace, only : change_method_to, counters, may_leave, set_stop, &
      start, sticks, switch_if_due, watch_pace
   use contensou_integrate_sticking, only : balance_forces, look_at_sliding
   use contensou_integrate_step, only : keep_workspace, kept_type, look_at_gaps, march_type, &
      restore_workspace, view_spots, zero_gap
   implicit none(type, external)
   private

   public :: begin_march, march, open_march, go_on, close_march, adopt_state

   !> Relative tolerance with which a step is no more than 1.7 rad of an oscillation, with any
   !> method: in the middle nothing is twice as fast as at both ends.
   real(wp), parameter :: short_steps = 1.0e-5_wp

contains

   !> Make ready for a march: resolve impacts of rigid contacts that touch at once, choose a method.
   subroutine begin_march(motion, method, memory, choice, error)
      class(motion_type), intent(inout) :: motion
      !> One of `integrator_methods`.
      character(len=*), intent(in) :: method
      !> Where the march begins: time and state are set.
      type(memory_type), intent(inout) :: memory
      !> What `auto` chose; only the method without it.
      type(choice_type), intent(out) :: choice
      !> Set when the rigid contacts cannot be resolved.
      type(error_type), allocatable, intent(out) :: error

      if (motion%system%layout%states > 0) call begin_states(motion, memory%y)
      if (motion%system%constraints%n_rigid > 0) call begin_rigid(motion, memory%t, memory%y, error)
      if (allocated(error)) return
      choice%method = method
      if (method == "auto") then
         call choose_method(motion, memory%y, choice)
         if (choice%method /= "explicit8") memory%switch%explicit_step = &
            explicit_reach/choice%fastest
      end if
      memory%switch%method = choice%method
   end subroutine begin_march

   !> March to the end, or until the observer stops it; then another call goes on, with the method
   !> started anew.
   subroutine march(motion, plan, memory, observer, stopped, error)
      !> The motion; its contacts remember their impacts.
      class(motion_type), intent(inout), target :: motion
      type(plan_type), intent(in) :: plan
      !> From where it goes on, as `begin_march` or a march left it.
      type(memory_type), intent(inout), target :: memory
      class(observer_type), intent(inout), target :: observer
      !> Whether the observer asked to stop.
      logical, intent(out) :: stopped
      !> Set when the integration or the observer failed.
      type(error_type), allocatable, intent(out) :: error
      type(march_type) :: self

      stopped = .false.
      call open_march(self, motion, plan, memory, observer, error)
      if (.not. allocated(error)) call go_on(self, stopped, error)
      call close_march(self)
   end subroutine march

   !> Start the method of a march that is to be gone on with.
   subroutine open_march(self, motion, plan, memory, observer, error)
      !> The march, closed.
      type(march_type), intent(out) :: self
      !> The motion; its contacts remember their impacts.
      class(motion_type), intent(inout), target :: motion
      type(plan_type), intent(in) :: plan
      !> From where it goes on, as `begin_march` or a march left it.
      type(memory_type), intent(inout), target :: memory
      class(observer_type), intent(inout), target :: observer
      !> Set when the method cannot be started.
      type(error_type), allocatable, intent(out) :: error

      self%rows = row_count(plan%t_end, plan%interval)
      self%motion => motion
      ! A march that goes on knows no more than one from a checkpoint.
      motion%way_speed = 0.0_wp
      self%plan = plan
      self%memory => memory
      self%observer => observer
      ! All rows were written when it stopped.
      if (memory%row > self%rows) return
      memory%switch%before = memory%statistics
      memory%switch%may = plan%method == "auto"
      call start(self, trim(memory%switch%method), error)
   end subroutine open_march

   !> March to the end, or until the observer stops it or lets it wait; then another call goes on as
   !> if it had not been stopped.
   subroutine go_on(self, stopped, error)
      !> The march, open.
      type(march_type), intent(inout) :: self
      !> Whether the observer asked to stop or to wait.
      logical, intent(out) :: stopped
      !> Set when the integration or the observer failed.
      type(error_type), allocatable, intent(out) :: error

      stopped = .false.
      if (.not. allocated(self%integrator)) return
      call advance(self, stopped, error)
      if (allocated(error)) call heed_conforming(self, error)
      self%memory%statistics = counters(self)
   end subroutine go_on

   !> Release the method of a march.
   subroutine close_march(self)
      type(march_type), intent(inout) :: self

      if (.not. allocated(self%integrator)) return
      self%memory%statistics = counters(self)
      call self%integrator%free()
      deallocate(self%integrator)
   end subroutine close_march

   !> The loop of a march.
   subroutine advance(self, stopped, error)
      !> The march, its integration started.
      type(march_type), intent(inout) :: self
      !> Whether the observer asked to stop or to wait.
      logical, intent(inout) :: stopped
      !> Set when the integration or the observer failed.
      type(error_type), allocatable, intent(out) :: error
      logical :: again, unresolved

      if (.not. allocated(self%events)) call set_out(self, error)
      if (allocated(error)) return
      associate (system => self%motion%system, memory => self%memory, t => self%memory%t)
         do while (memory%row <= self%rows .or. self%inside)
            if (.not. self%inside) then
               call take_step(self, again, error)
               if (allocated(error)) return
               if (again) cycle
            end if
            call give_rows(self, error)
            if (allocated(error)) return
            self%inside = self%observer%wait < t
            if (self%inside) then
               call wait_within(self, error)
               stopped = .true.
               return
            end if
            if (self%met > 0) call end_here(self, error)
            if (allocated(error) .or. self%met > 0) return
            if (self%observer%next_time < t) call look_between(self, error)
            if (allocated(error)) return
            if (self%deep) then
               call fatal(error, "the motion leaves the domain of the model")
               return
            end if
            call check_step(self, error)
            if (allocated(error)) return
            if (system%remembers) call remember(self)
            if (any(memory%undecided)) call decide(self)
            unresolved = .false.
            if (system%constraints%n_rigid > 0) then
               call watch_contacts(self, .false., unresolved, error)
               if (allocated(error)) return
            end if
            if (any(self%events /= 0) .or. unresolved) then
               call take_events(self, unresolved, error)
               if (allocated(error)) return
               ! While all contacts were closed the gaps were not kept; impacts change velocities.
               call look_at_gaps(self)
               if (unresolved) call watch_contacts(self, .true., unresolved, error)
               if (allocated(error)) return
            end if
            if (self%met > 0) then
               call end_here(self, error)
               return
            end if
            if (system%constraints%n_rigid > 0) then
               if (any(system%contacts%leaving)) call note_separation(self%motion, memory%y)
            end if
            if (t >= self%integrator%t_stop) then
               call set_stop(self)
               call self%integrator%restart(t, memory%y, error)
               if (allocated(error)) return
            end if
            if (memory%switch%may .and. memory%row <= self%rows) then
               call switch_if_due(self, error)
               if (allocated(error)) return
            else if (sticks(self)) then
               call change_method_to(self, "cvode_bdf", &
                  "friction that sticks is too stiff for " // trim(self%plan%method), error)
               if (allocated(error)) return
            else if (allocated(self%integrator%advice)) then
               call self%observer%advise(t, self%integrator%advice)
               deallocate(self%integrator%advice)
            end if
            call self%observer%after_step(t, stopped, error)
            if (allocated(error)) return
            if (stopped .or. self%observer%keep_due) then
               memory%statistics = counters(self)
               call self%observer%keep(self%motion, memory, error)
               if (allocated(error) .or. stopped) return
            end if
         end do
      end associate
   end subroutine advance

   !> Take a step, and see whether it is to be taken again in smaller ones.
   subroutine take_step(self, again, error)
      type(march_type), intent(inout) :: self
      !> Whether the march is at the beginning of the step again.
      logical, intent(out) :: again
      !> Set when the integration failed.
      type(error_type), allocatable, intent(out) :: error

      again = .false.
      associate (system => self%motion%system, memory => self%memory, t => self%memory%t)
         call watch_pace(self, error)
         if (allocated(error)) return
         self%integrator%steep = .false.
         if (system%constraints%n_links > 0) call look_at_sliding(self%motion, &
            t - self%t_before, self%sliding, self%integrator%steep)
         self%t_before = t
         self%y_before = memory%y
         ! Trouble of a trial of the last step is over.
         system%trouble = 0
         call self%integrator%step(t, memory%y, self%events, error)
         if (allocated(error) .and. self%integrator%hopeless .and. may_leave(self)) then
            deallocate(error)
            self%stuck = .true.
         end if
         if (allocated(error)) return
         self%deep = system%too_deep > 0
         self%posed = self%integrator%events_last .and. .not. self%deep
         if (self%deep) call find_depth(self, self%deep)
         if (system%several_spots) then
            self%posed = .false.
            call follow_spots(self, again, error)
            if (allocated(error) .or. again) return
         end if
         if (self%motion%unfound .and. .not. self%deep) then
            call fatal(error, "the forces of the rigid contacts are not found")
            return
         end if
         if (all(memory%closed .and. .not. memory%undecided)) then
            self%seen = .false.
            ! No gap is open that could be missed.
            call lift_bound(self)
         else
            call avoid_dip(self, again, error)
            if (allocated(error) .or. again) return
         end if
         if (system%remembers) then
            call doubt_memory(self, again, error)
            if (allocated(error) .or. again) return
         end if
         if (self%has_stops) call watch_stops(self)
      end associate
   end subroutine take_step

   !> Let a state that was set anew be one from which a march goes on: contacts are closed where
   !> surfaces overlap, and the energy there is what it is balanced against.
   subroutine adopt_state(motion, memory, error)
      class(motion_type), intent(inout) :: motion
      !> Time and state are set; what was known of contacts and energy is renewed.
      type(memory_type), intent(inout) :: memory
      !> Set when rigid contacts or spots cannot be settled.
      type(error_type), allocatable, intent(out) :: error
      type(energy_type) :: energy
      real(wp) :: gap(motion%n_events), rate(motion%n_events)
      logical :: was, changed
      integer :: i, index, trouble

      associate (system => motion%system, y => memory%y)
         if (system%constraints%n_rigid > 0) call begin_rigid(motion, memory%t, y, error)
         ! The beginning of a march does the rest.
         if (allocated(error) .or. memory%row == 0) return
         call system%set_poses(y)
         if (system%several_spots) then
            call assign_spots(system, memory%closed, index, trouble)
            if (index > 0) then
               system%trouble = index
               system%trouble_code = trouble
               call fatal(error, "the spots of a contact cannot be told apart")
               return
            end if
         end if
         call system%gaps(y, gap)
         call system%gap_rates(y, rate)
         do i = 1, motion%n_events
            associate (contact => system%contacts(i), closed => memory%closed(i), &
               undecided => memory%undecided(i))
               was = closed
               undecided = abs(gap(i)) <= zero_gap(y) .and. .not. contact%rigid
               closed = gap(i) <= 0.0_wp .or. undecided
               if (contact%rigid) closed = contact%closed
               if (closed .and. .not. was) call begin_impact(motion, i, -rate(i), changed)
               if (allocated(contact%tangential)) call contact%tangential%forget()
            end associate
         end do
         memory%bounded_until = 0.0_wp
         call find_energy(system, memory%t, y, energy)
         memory%energy = energy%total()
         memory%potential = energy%potential
         memory%energy_moved = max(energy%kinetic, energy%elastic)
         memory%lost = energy%friction - energy%stored
      end associate
   end subroutine adopt_state

   !> Begin with the first row, or go on where a march has stopped.
   subroutine set_out(self, error)
      type(march_type), intent(inout) :: self
      !> Set when the observer failed.
      type(error_type), allocatable, intent(out) :: error
      logical :: changed
      integer :: i, n

      n = self%motion%n_events
      allocate(self%events(n), self%gap(n), self%gap_before(n), self%suspect(n), self%missed(n), &
         self%pulls(n), self%clearance(n), self%fastest(n), self%seen(n), self%near(n), &
         self%y_row(self%motion%n))
      allocate(self%sliding(n), source=0.0_wp)
      associate (system => self%motion%system, memory => self%memory, y => self%memory%y)
         self%may_skip = system%constraints%n_rigid == 0 .and. .not. system%several_spots
         self%may_pass = self%may_skip .and. self%motion%scales%rtol <= short_steps
         self%t_before = memory%t
         self%clearance = 0.0_wp
         call look_at_gaps(self)
         if (allocated(self%plan%stops)) self%has_stops = size(self%plan%stops) > 0
         if (self%has_stops) call memory%stops%begin(self%plan%stops, &
            system%bodies, memory%row > 0, memory%t, y)
         self%resolution = zero_gap(y)
         self%t_watch = memory%t
         if (memory%row > 0) then
            if (memory%bounded_until > memory%t) call self%integrator%bound_step( &
               (memory%bounded_until - memory%t)/4.0_wp)
            return
         end if
         ! A gap that is zero to rounding is a contact from the start, not a touch.
         memory%undecided = abs(self%gap%value) <= self%resolution
         memory%closed = self%gap%value <= 0.0_wp .or. memory%undecided
         where (system%contacts%rigid)
            memory%undecided = .false.
            memory%closed = system%contacts%closed
         end where
         do i = 1, n
            if (memory%closed(i)) call begin_impact(self%motion, i, -self%gap(i)%rate, changed)
         end do
         call begin_balance(self)
         call self%observer%sample(self%motion, memory%t, y, error)
         if (allocated(error)) return
         memory%row = 1
         memory%bounded_until = 0.0_wp
      end associate
   end subroutine set_out

   !> Hand over the rows that the step has come by, as far as the observer does not let it wait.
   subroutine give_rows(self, error)
      type(march_type), intent(inout) :: self
      !> Set when the observer failed.
      type(error_type), allocatable, intent(out) :: error
      type(kept_type) :: kept
      real(wp) :: t

      associate (row => self%memory%row, several => self%motion%system%several_spots)
         do while (row <= self%rows)
            t = min(row*self%plan%interval, self%plan%t_end)
            if (row == self%rows) t = self%plan%t_end
            if (t > min(self%memory%t, self%observer%wait)) exit
            call self%integrator%interpolate(t, self%y_row)
            if (several) then
               call keep_workspace(self%motion, kept)
               call view_spots(self, self%y_row)
            end if
            if (self%motion%system%constraints%n_links > 0) call balance(self, t)
            call self%observer%sample(self%motion, t, self%y_row, error)
            if (allocated(error)) return
            if (several) call restore_workspace(self%motion, kept)
            row = row + 1
         end do
      end associate
   end subroutine give_rows

   !> Hand over the state at the time within the step at which the observer lets the march wait.
   subroutine wait_within(self, error)
      type(march_type), intent(inout) :: self
      !> Set when the observer failed.
      type(error_type), allocatable, intent(out) :: error
      type(statistics_type) :: before, after
      type(kept_type) :: kept
      type(constraints_type) :: constraints

      associate (observer => self%observer)
         call keep_workspace(self%motion, kept)
         constraints = self%motion%system%constraints
         before = self%integrator%statistics()
         call self%integrator%interpolate(observer%wait, self%y_row)
         after = self%integrator%statistics()
         if (min(self%memory%row*self%plan%interval, self%plan%t_end) < self%memory%t) then
            ! A row has the same need of what the interpolation takes.
            call keep_workspace(self%motion, kept)
            constraints = self%motion%system%constraints
         else
            self%unasked = self%unasked + after%derivatives - before%derivatives
         end if
         if (self%motion%system%several_spots) call view_spots(self, self%y_row)
         if (self%motion%system%constraints%n_links > 0) call balance(self, observer%wait)
         call observer%at_wait(self%motion, observer%wait, self%y_row, error)
         self%motion%system%constraints = constraints
         call restore_workspace(self%motion, kept)
      end associate
   end subroutine wait_within

   !> Let the forces of a row at rigid contacts be those of its accelerations.
   subroutine balance(self, t)
      type(march_type), intent(inout) :: self
      !> Time of the row [s].
      real(wp), intent(in) :: t
      real(wp) :: rate(size(self%y_row))
      logical :: known

      call self%integrator%interpolate_rate(t, rate, known)
      if (known) call balance_forces(self%motion, t, rate, self%memory%t - self%t_before, &
         self%y_row)
   end subroutine balance

   !> States that are asked for beside the rows, so that nothing that follows depends on it.
   subroutine look_between(self, error)
      type(march_type), intent(inout) :: self
      !> Set when the observer failed.
      type(error_type), allocatable, intent(out) :: error
      type(statistics_type) :: before, after
      type(kept_type) :: kept
      real(wp) :: y(self%motion%n)

      associate (observer => self%observer)
         call keep_workspace(self%motion, kept)
         before = self%integrator%statistics()
         do while (observer%next_time < self%memory%t)
            call self%integrator%interpolate(observer%next_time, y)
            if (self%motion%system%several_spots) call view_spots(self, y)
            call observer%between(self%motion, observer%next_time, y, error)
            if (allocated(error)) return
         end do
         after = self%integrator%statistics()
         self%unasked = self%unasked + after%derivatives - before%derivatives
         call restore_workspace(self%motion, kept)
      end associate
   end subroutine look_between

end module contensou_integrate_march
