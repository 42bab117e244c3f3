!> Touch and lift-off: states and impacts of contacts, and which rigid contacts are closed.
module contensou_integrate_events
   use contensou_base_errors, only : error_type, fatal
   use contensou_base_kinds, only : wp
   use contensou_contact_geometry, only : contact_motion_type, trouble_pulls
   use contensou_dynamics_impact, only : rest, slow_rate, stop_closed_gaps
   use contensou_dynamics_links, only : link_type
   use contensou_dynamics_rests, only : agree, check_contacts, lower_threshold, open_contact, &
      resolve_contacts, set_thresholds, touching_gap
   use contensou_integrate_ends, only : tell_event
   use contensou_integrate_motion, only : motion_type
   use contensou_integrate_observer, only : event_lift, event_touch
   use contensou_integrate_pace, only : refine
   use contensou_integrate_step, only : march_type, zero_gap
   implicit none(type, external)
   private

   public :: take_events, watch_contacts, decide, begin_states, begin_rigid, note_separation, &
      begin_impact

   !> Overlap of a closed rigid contact, over that which ends a run, and its growth since the last
   !> time, at which the tolerance is tightened: the errors of the integration make it.
   real(wp), parameter :: drift_step = 0.2_wp

contains

   !> Record events, and let the contacts take note of the impact speed.
   subroutine take_events(self, unresolved, error)
      type(march_type), intent(inout) :: self
      !> Whether rigid contacts are to be resolved without an event.
      logical, intent(in) :: unresolved
      !> Set when the observer failed.
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: rate(size(self%events))
      logical :: changed, any_changed, any_rigid
      integer :: i

      any_changed = .false.
      associate (motion => self%motion, t => self%memory%t, y => self%memory%y, &
         closed => self%memory%closed, events => self%events)
         any_rigid = unresolved .or. any(motion%system%contacts%rigid .and. events /= 0)
         call motion%system%gap_rates(y, rate)
         if (any_rigid) call add_simultaneous(motion, y, rate, closed, events)
         do i = 1, size(events)
            if (events(i) < 0 .and. .not. closed(i)) then
               closed(i) = .true.
               call begin_impact(motion, i, -rate(i), changed)
               any_changed = any_changed .or. changed
               call renew_states(motion, i, .true., y, any_changed)
               call tell_event(self, event_touch, i, error)
            else if (events(i) > 0 .and. closed(i)) then
               closed(i) = .false.
               call renew_states(motion, i, .false., y, any_changed)
               call tell_event(self, event_lift, i, error)
            end if
            if (allocated(error)) return
         end do
         if (any_rigid) then
            call take_rigid_events(self, error)
            if (allocated(error)) return
            any_changed = .true.
         end if
         if (any_changed) call self%integrator%restart(t, y, error)
      end associate
   end subroutine take_events

   !> What follows from an event of a rigid contact: impacts, and which contacts stay closed.
   subroutine take_rigid_events(self, error)
      type(march_type), intent(inout) :: self
      !> Set when the impacts cannot be resolved or the observer failed.
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: gap(size(self%events))
      logical, dimension(size(self%events)) :: candidate, near
      logical :: changed, again
      integer :: i

      associate (motion => self%motion, t => self%memory%t, y => self%memory%y, &
         closed => self%memory%closed, events => self%events)
         call motion%system%gaps(y, gap)
         do i = 1, size(events)
            associate (contact => motion%system%contacts(i))
               ! What touches within rounding is decided together, whichever the event is of.
               near(i) = .false.
               if (contact%rigid .and. .not. contact%closed) near(i) = gap(i) <= &
                  touching_gap(contact)
            end associate
         end do
         do i = 1, size(events)
            ! One that lifts off has no force and its gap no acceleration.
            if (motion%system%contacts(i)%closed .and. events(i) > 0) call open_contact( &
               motion%system, i)
         end do
         candidate = motion%system%contacts%rigid .and. &
            (motion%system%contacts%closed .or. events /= 0 .or. near)
         again = any(motion%system%contacts%rigid .and. events < 0)
         if (.not. again) again = .not. agree(motion%system, t, y, near, motion%scales%velocity)
         if (again) call resolve_rigid(motion, t, y, candidate, error)
         if (allocated(error)) return
         if (any(motion%system%contacts%closed)) call set_thresholds(motion%system, t, y)
         do i = 1, size(events)
            associate (contact => motion%system%contacts(i))
               if (.not. contact%rigid .or. (contact%closed .eqv. closed(i))) cycle
               closed(i) = contact%closed
            end associate
            call renew_states(motion, i, closed(i), y, changed)
            call tell_event(self, merge(event_touch, event_lift, closed(i)), i, error)
            if (allocated(error)) return
         end do
      end associate
   end subroutine take_rigid_events

   !> Add the open rigid contacts that touch within rounding and approach to the events of others.
   subroutine add_simultaneous(motion, y, rate, closed, events)
      class(motion_type), intent(inout) :: motion
      real(wp), intent(in) :: y(:)
      !> Rates of the gaps [m/s].
      real(wp), intent(in) :: rate(:)
      !> Which contacts are closed.
      logical, intent(in) :: closed(:)
      !> For each contact 1, -1 or 0 as it opens, closes, or neither.
      integer, intent(inout) :: events(:)
      real(wp) :: gap(size(events))
      integer :: i

      call motion%system%gaps(y, gap)
      do i = 1, size(events)
         associate (contact => motion%system%contacts(i))
            if (.not. contact%rigid .or. closed(i) .or. events(i) /= 0) cycle
            if (gap(i) <= touching_gap(contact) .and. &
               rate(i) < -slow_rate*motion%scales%velocity) events(i) = -1
         end associate
      end do
   end subroutine add_simultaneous

   !> See whether the rigid contacts are as they should be at the end of a step: touches that no
   !> event told of are added to the events.
   subroutine watch_contacts(self, resolved, unresolved, error)
      type(march_type), intent(inout) :: self
      !> Whether they have been resolved here: then none may pull.
      logical, intent(in) :: resolved
      !> Whether one pulls without an event.
      logical, intent(out) :: unresolved
      !> Set when a contact has sunk in, is apart, drives or pulls.
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: drift
      integer :: index, trouble

      unresolved = .false.
      call check_contacts(self%motion%system, self%gap%value, self%missed, self%pulls, drift, &
         index, trouble)
      if (resolved .and. index == 0 .and. any(self%pulls)) then
         index = findloc(self%pulls, .true., dim=1)
         trouble = trouble_pulls
      end if
      if (index > 0) then
         self%motion%system%trouble = index
         self%motion%system%trouble_code = trouble
         call fatal(error, "a rigid contact does not hold")
         return
      end if
      if (resolved) return
      where (self%missed .and. self%events == 0) self%events = -1
      call ignore_drift(self)
      unresolved = any(self%pulls .and. self%events == 0)
      if (drift > drift_step*(self%memory%tightened + 1)) call hold_contacts(self, error)
   end subroutine watch_contacts

   !> Where the errors of the integration make closed contacts sink in, take their rates away and
   !> go on with a finer tolerance.
   subroutine hold_contacts(self, error)
      type(march_type), intent(inout) :: self
      !> Set when the integration cannot be started again.
      type(error_type), allocatable, intent(out) :: error
      type(link_type), allocatable :: links(:)
      real(wp) :: y_rate(self%motion%n)

      associate (memory => self%memory, system => self%motion%system)
         memory%tightened = memory%tightened + 1
         call refine(self, memory%switch%method)
         call system%derivative(memory%t, memory%y, y_rate)
         if (.not. system%outside) then
            allocate(links, source=system%constraints%links(:system%constraints%n_links))
            call stop_closed_gaps(system, memory%y, links, system%contacts%closed &
               .and. system%contacts%rigid, rest*slow_rate*self%motion%scales%velocity)
         end if
         call self%integrator%restart(memory%t, memory%y, error)
      end associate
   end subroutine hold_contacts

   !> No touch is what the errors of the integration make of a gap that has just opened and grows.
   subroutine ignore_drift(self)
      type(march_type), intent(inout) :: self
      integer :: i

      associate (system => self%motion%system)
         do i = 1, size(self%events)
            if (self%events(i) >= 0 .or. .not. system%contacts(i)%leaving) cycle
            if (self%gap(i)%rate < 0.0_wp) cycle
            self%events(i) = 0
            call system%set_poses(self%memory%y)
            call lower_threshold(system, i)
         end do
      end associate
   end subroutine ignore_drift

   !> Tell whether contacts with a gap of zero at the beginning are closed, once they show it.
   subroutine decide(self)
      type(march_type), intent(inout) :: self
      real(wp) :: gap(self%motion%n_events)

      call self%motion%system%gaps(self%memory%y, gap)
      associate (closed => self%memory%closed, undecided => self%memory%undecided, &
         events => self%events)
         where (undecided .and. events /= 0)
            closed = events < 0
            undecided = .false.
            events = 0
         else where (undecided .and. abs(gap) > self%resolution)
            closed = gap < 0.0_wp
            undecided = .false.
         end where
      end associate
   end subroutine decide

   !> Set the states of parts at the beginning.
   subroutine begin_states(motion, y)
      class(motion_type), intent(inout) :: motion
      !> State.
      real(wp), intent(inout) :: y(:)
      type(contact_motion_type) :: now
      real(wp) :: limit
      integer :: i

      call motion%system%set_poses(y)
      do i = 1, motion%n_events
         call motion%system%observe(i, now)
         associate (contact => motion%system%contacts(i))
            limit = zero_gap(y)
            if (contact%rigid) limit = touching_gap(contact)
            call contact%renew(now, now%at%gap <= limit, y)
         end associate
      end do
   end subroutine begin_states

   !> Set the states of the parts of a contact that touches or lifts off.
   subroutine renew_states(motion, contact, closed, y, changed)
      class(motion_type), intent(inout) :: motion
      !> Index of the contact.
      integer, intent(in) :: contact
      !> Whether it is closed now.
      logical, intent(in) :: closed
      !> State.
      real(wp), intent(inout) :: y(:)
      !> Set if it has states: their rates change at once.
      logical, intent(inout) :: changed
      type(contact_motion_type) :: now

      if (motion%system%contacts(contact)%states%n == 0) return
      call motion%system%set_poses(y)
      call motion%system%observe(contact, now)
      call motion%system%contacts(contact)%renew(now, closed, y)
      changed = .true.
   end subroutine renew_states

   !> Close the rigid contacts that touch at the beginning.
   subroutine begin_rigid(motion, t, y, error)
      class(motion_type), intent(inout) :: motion
      !> Time [s].
      real(wp), intent(in) :: t
      !> State; velocities change if surfaces touch at once and approach.
      real(wp), intent(inout) :: y(:)
      !> Set when the contacts cannot be settled.
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: gap(motion%n_events)
      logical :: touching(motion%n_events)
      integer :: i

      call motion%system%gaps(y, gap)
      do i = 1, motion%n_events
         associate (contact => motion%system%contacts(i))
            contact%closed = .false.
            contact%leaving = .false.
            touching(i) = .false.
            if (contact%rigid) touching(i) = gap(i) <= touching_gap(contact)
         end associate
      end do
      if (any(touching)) call resolve_rigid(motion, t, y, touching, error)
      if (allocated(error)) return
      if (any(motion%system%contacts%closed)) call set_thresholds(motion%system, t, y)
   end subroutine begin_rigid

   !> Resolve the impacts of rigid contacts that touch, and find which of them stay closed.
   subroutine resolve_rigid(motion, t, y, touching, error)
      class(motion_type), intent(inout) :: motion
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(inout) :: y(:)
      !> Contacts whose gaps are zero.
      logical, intent(in) :: touching(:)
      !> Set when the contacts cannot be settled.
      type(error_type), allocatable, intent(out) :: error
      integer :: index, trouble

      call resolve_contacts(motion%system, t, y, touching, motion%scales%velocity, index, trouble)
      if (index == 0) return
      motion%system%trouble = index
      motion%system%trouble_code = trouble
      call fatal(error, "the rigid contacts cannot be resolved")
   end subroutine resolve_rigid

   !> Note that gaps have become distinct from zero.
   subroutine note_separation(motion, y)
      class(motion_type), intent(inout) :: motion
      real(wp), intent(in) :: y(:)
      real(wp) :: gap(motion%n_events)
      integer :: i

      call motion%system%gaps(y, gap)
      do i = 1, size(gap)
         associate (contact => motion%system%contacts(i))
            if (contact%leaving) contact%leaving = gap(i) <= touching_gap(contact)
         end associate
      end do
   end subroutine note_separation

   !> Tell a contact the speed of an impact.
   subroutine begin_impact(motion, contact, speed, changed)
      class(motion_type), intent(inout) :: motion
      integer, intent(in) :: contact
      !> Speed of approach [m/s].
      real(wp), intent(in) :: speed
      !> Whether the right-hand side changed by that.
      logical, intent(out) :: changed

      changed = .false.
      associate (law => motion%system%contacts(contact)%law)
         if (allocated(law%damping)) call law%damping%begin_impact(speed, changed)
      end associate
   end subroutine begin_impact

end module contensou_integrate_events
