!> March a motion from its initial state to the end: rows at fixed intervals, touch and lift-off
!> as events, a chance to stop after every step.
module contensou_integrate_march
   use contensou_base_checkpoint, only : checkpoint_type
   use contensou_base_errors, only : error_type, fatal
   use contensou_base_kinds, only : i8, wp
   use contensou_contact_geometry, only : track_type
   use contensou_dynamics_impact, only : open_contact, settle, touching_gap
   use contensou_dynamics_mechanism, only : contact_motion_type
   use contensou_integrate_choice, only : choice_type, choose_method, &
      explicit_reach
   use contensou_integrate_cvode, only : cvode_type
   use contensou_integrate_explicit8, only : explicit8_type
   use contensou_integrate_integrator, only : integrator_type, statistics_type
   use contensou_integrate_motion, only : motion_type
   implicit none(type, external)
   private

   public :: observer_type, begin_march, march, event_touch, event_lift, integrator_methods, &
      jacobian_kinds, new_integrator, row_count, memory_type, plan_type, switch_type

   !> Methods of integration, as named in a scene.
   character(len=*), parameter :: integrator_methods(*) = [character(len=11) :: &
      "cvode_bdf", "cvode_adams", "explicit8", "auto"]

   !> Jacobians of implicit methods, as named in a scene.
   character(len=*), parameter :: jacobian_kinds(*) = [character(len=11) :: "analytic", &
      "differences"]

   !> A gap closes.
   integer, parameter :: event_touch = 1

   !> A gap opens.
   integer, parameter :: event_lift = 2

   !> Steps between two looks of `auto` at their mean.
   integer, parameter :: steps_between_looks = 200

   !> Steps of `explicit8` after the first return to it before which it is not left again.
   integer(i8), parameter :: first_patience = 2000_i8

   !> Which methods `auto` has used, and when another one is due.
   type :: switch_type
      !> Whether the march may change the method.
      logical :: may = .false.
      !> Method in use.
      character(len=11) :: method = ""
      !> Counters of the methods before.
      type(statistics_type) :: before
      !> Time of the last look at the steps [s].
      real(wp) :: t_look = 0.0_wp
      !> Steps since then.
      integer :: steps = 0
      !> Steps of `explicit8` before which it is not left again; doubled with each return to it, so
      !> that two methods that are equally fast do not take turns for ever.
      integer(i8) :: patience = first_patience
      !> Steps of `explicit8` to go before it may be left.
      integer(i8) :: to_go = 0
      !> Largest mean step of `explicit8` between two looks [s]; 0 if it has not been in use.
      real(wp) :: explicit_step = 0.0_wp
   end type switch_type

   !> What a march is to do.
   type :: plan_type
      !> One of `integrator_methods`.
      character(len=11) :: method = ""
      !> End of time [s].
      real(wp) :: t_end = 0.0_wp
      !> Interval of the rows [s].
      real(wp) :: interval = 0.0_wp
      !> Largest step [s], 0 for no bound.
      real(wp) :: max_step = 0.0_wp
   end type plan_type

   !> What a march needs to go on later where it stopped, besides what the contacts of its motion
   !> remember.
   type :: memory_type
      !> Time [s].
      real(wp) :: t = 0.0_wp
      real(wp), allocatable :: y(:)
      !> Next row; 0 if the march has not begun.
      integer(i8) :: row = 0
      !> Which contacts are closed.
      logical, allocatable :: closed(:)
      !> Which contacts have not left the gap of zero, to rounding, that they had at the beginning.
      logical, allocatable :: undecided(:)
      !> Time up to which the step is bounded, because a contact closes and opens there [s]; 0 for
      !> none.
      real(wp) :: bounded_until = 0.0_wp
      !> The method in use, and what `auto` knows.
      type(switch_type) :: switch
      !> Counters so far.
      type(statistics_type) :: statistics
   contains
      procedure :: exchange => exchange_memory
   end type memory_type

   !> Who looks on; this one does nothing.
   type :: observer_type
      !> Whether `keep` is to be called after this step; `after_step` may set it.
      logical :: keep_due = .false.
      !> Time of a state that is asked for beside the rows [s]; a march hands it to `between` when
      !> it has come there, and runs on as if it had not been asked.
      real(wp) :: next_time = huge(1.0_wp)
   contains
      procedure :: sample
      procedure :: event
      procedure :: after_step
      procedure :: between
      procedure :: advise
      procedure :: change_method
      procedure :: keep
   end type observer_type

   !> Steps after which the pace is looked at.
   integer, parameter :: watched_steps = 50000

   !> Steps are hopelessly small below this share of the shortest time that a contact takes [-] ...
   real(wp), parameter :: hopeless = 1.0e-5_wp

   !> ... and if the end is farther than this number of steps.
   real(wp), parameter :: hopeless_steps = 1.0e8_wp

   !> Steps are too small to go on with below this share of the shortest time of a contact [-] ...
   real(wp), parameter :: poor = 1.0e-4_wp

   !> ... if the end is farther than this number of steps, a minute or so of them ...
   real(wp), parameter :: poor_steps = 5.0e6_wp

   !> ... and they were so for this number of looks: a stiff impact passes.
   integer, parameter :: poor_looks = 10

contains

   !> Number of rows after the first one: multiples of the interval up to the end, and the end.
   pure function row_count(t_end, interval) result(rows)
      !> End of time [s].
      real(wp), intent(in) :: t_end
      !> Interval of the rows [s].
      real(wp), intent(in) :: interval
      integer(i8) :: rows

      rows = ceiling(t_end/interval*(1.0_wp - 4.0_wp*epsilon(t_end)), i8)
   end function row_count

   !> An integration by a method.
   subroutine new_integrator(method, integrator)
      !> One of `integrator_methods`.
      character(len=*), intent(in) :: method
      !> The integration, to be started.
      class(integrator_type), allocatable, intent(out) :: integrator

      if (method == "explicit8") then
         allocate(explicit8_type :: integrator)
      else
         allocate(cvode_type :: integrator)
      end if
   end subroutine new_integrator

   !> A row is due; nobody looks at it unless an observer overrides this.
   subroutine sample(self, motion, t, y, error)
      class(observer_type), intent(inout) :: self
      class(motion_type), intent(inout) :: motion
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)
      !> Set to end the march.
      type(error_type), allocatable, intent(out) :: error
   end subroutine sample

   !> A contact touched or lifted off; nobody takes note unless an observer overrides this.
   subroutine event(self, t, kind, contact, error)
      class(observer_type), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> `event_touch` or `event_lift`.
      integer, intent(in) :: kind
      integer, intent(in) :: contact
      !> Set to end the march.
      type(error_type), allocatable, intent(out) :: error
   end subroutine event

   !> A step is done; another one follows unless an observer overrides this.
   subroutine after_step(self, t, stop_now, error)
      class(observer_type), intent(inout) :: self
      !> Time reached [s].
      real(wp), intent(in) :: t
      logical, intent(out) :: stop_now
      !> Set to end the march.
      type(error_type), allocatable, intent(out) :: error

      stop_now = .false.
   end subroutine after_step

   !> The state at `next_time`; nobody asked for it unless an observer overrides this.
   subroutine between(self, motion, t, y)
      class(observer_type), intent(inout) :: self
      class(motion_type), intent(inout) :: motion
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)

      self%next_time = huge(t)
   end subroutine between

   !> The method has something to say to the user; nobody listens unless an observer overrides this.
   subroutine advise(self, t, text)
      class(observer_type), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> What it says.
      character(len=*), intent(in) :: text
   end subroutine advise

   !> `auto` goes on with another method; nobody takes note unless an observer overrides this.
   subroutine change_method(self, t, method, reason)
      class(observer_type), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> The method from here on.
      character(len=*), intent(in) :: method
      !> Why.
      character(len=*), intent(in) :: reason
   end subroutine change_method

   !> The march can be continued from here; forgotten unless an observer overrides this.
   subroutine keep(self, motion, memory, error)
      class(observer_type), intent(inout) :: self
      class(motion_type), intent(inout) :: motion
      type(memory_type), intent(inout) :: memory
      !> Set to end the march.
      type(error_type), allocatable, intent(out) :: error

      self%keep_due = .false.
   end subroutine keep

   !> Write what a march needs to go on, and what the contacts of its motion remember, to a
   !> checkpoint, or read it back.
   subroutine exchange_memory(self, motion, checkpoint)
      class(memory_type), intent(inout) :: self
      class(motion_type), intent(inout) :: motion
      type(checkpoint_type), intent(inout) :: checkpoint
      integer :: i

      if (.not. allocated(self%y)) allocate(self%y(motion%n))
      if (.not. allocated(self%closed)) allocate(self%closed(motion%n_events), &
         self%undecided(motion%n_events))
      call checkpoint%exchange("t", self%t)
      call checkpoint%exchange("state", self%y)
      call checkpoint%exchange("row", self%row)
      call checkpoint%exchange("contacts_closed", self%closed)
      call checkpoint%exchange("contacts_undecided", self%undecided)
      call checkpoint%exchange("bounded_until", self%bounded_until)
      call self%statistics%exchange(checkpoint)
      call checkpoint%exchange("method", self%switch%method)
      call checkpoint%exchange("patience", self%switch%patience)
      call checkpoint%exchange("to_go", self%switch%to_go)
      call checkpoint%exchange("explicit_step", self%switch%explicit_step)
      do i = 1, size(motion%system%contacts)
         call motion%system%contacts(i)%exchange(checkpoint)
      end do
   end subroutine exchange_memory

   !> Make ready for a march: settle rigid contacts that touch at once, choose a method.
   subroutine begin_march(motion, method, memory, choice, error)
      class(motion_type), intent(inout) :: motion
      !> One of `integrator_methods`.
      character(len=*), intent(in) :: method
      !> Where the march begins: time and state are set.
      type(memory_type), intent(inout) :: memory
      !> What `auto` chose; only the method without it.
      type(choice_type), intent(out) :: choice
      !> Set when the rigid contacts cannot be settled.
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

   !> March to the end, or until the observer stops it; then another call goes on.
   subroutine march(motion, plan, memory, observer, stopped, error)
      !> The motion; its contacts remember their impacts.
      class(motion_type), intent(inout), target :: motion
      type(plan_type), intent(in) :: plan
      !> From where it goes on, as `begin_march` or a march left it.
      type(memory_type), intent(inout) :: memory
      class(observer_type), intent(inout) :: observer
      !> Whether the observer asked to stop.
      logical, intent(out) :: stopped
      !> Set when the integration or the observer failed.
      type(error_type), allocatable, intent(out) :: error
      class(integrator_type), allocatable :: integrator
      integer(i8) :: unasked

      stopped = .false.
      ! All rows were written when it stopped.
      if (memory%row > row_count(plan%t_end, plan%interval)) return
      associate (switch => memory%switch)
         switch%before = memory%statistics
         switch%may = plan%method == "auto"
         switch%t_look = memory%t
         switch%steps = 0
         call new_integrator(trim(switch%method), integrator)
         integrator%alert = switch%may
         call set_stop(integrator, motion, memory%t)
         call integrator%start(motion, trim(switch%method), memory%t, memory%y, plan%t_end, &
            plan%max_step, error)
         unasked = 0
         if (.not. allocated(error)) call advance(integrator, motion, plan, memory, observer, &
            unasked, stopped, error)
         memory%statistics = counters(switch, integrator, unasked)
      end associate
      call integrator%free()
   end subroutine march

   !> Counters of a march so far, and of those that it continues.
   function counters(switch, integrator, unasked) result(statistics)
      !> Which methods were used.
      type(switch_type), intent(in) :: switch
      !> The integration at present.
      class(integrator_type), intent(in) :: integrator
      !> Right-hand sides for states beside the rows, which do not count.
      integer(i8), intent(in) :: unasked
      type(statistics_type) :: statistics

      statistics = switch%before + integrator%statistics()
      statistics%derivatives = statistics%derivatives - unasked
   end function counters

   !> Let an integration go up to the end of the next ramp of a drive, no further.
   subroutine set_stop(integrator, motion, t)
      !> The integration, to be started or restarted.
      class(integrator_type), intent(inout) :: integrator
      class(motion_type), intent(inout) :: motion
      !> Time [s].
      real(wp), intent(in) :: t

      integrator%t_stop = motion%system%next_corner(t)
      motion%system%corner = integrator%t_stop
   end subroutine set_stop

   !> The loop of `march`.
   subroutine advance(integrator, motion, plan, memory, observer, unasked, stopped, error)
      !> The integration, started.
      class(integrator_type), allocatable, intent(inout) :: integrator
      class(motion_type), intent(inout), target :: motion
      type(plan_type), intent(in) :: plan
      !> Where it is: time and state always, the rest when it is kept or at the end.
      type(memory_type), intent(inout), target :: memory
      class(observer_type), intent(inout) :: observer
      !> Right-hand sides that were evaluated for states that the observer asked for.
      integer(i8), intent(inout) :: unasked
      !> Whether the observer asked to stop.
      logical, intent(inout) :: stopped
      !> Set when the integration or the observer failed.
      type(error_type), allocatable, intent(out) :: error
      integer(i8) :: row, rows
      real(wp), pointer, contiguous :: y(:)
      real(wp), pointer :: t
      real(wp) :: t_row, row_state(motion%n), t_before, y_before(motion%n), t_dip, bounded_until
      real(wp) :: gap(motion%n_events), rate(motion%n_events), rate_before(motion%n_events)
      real(wp) :: resolution
      real(wp) :: t_watch
      integer :: steps, looks
      logical :: closed(motion%n_events), undecided(motion%n_events), suspect(motion%n_events)
      logical :: changed, too_deep
      integer :: events(motion%n_events), i

      t => memory%t
      y => memory%y
      call motion%system%gaps(y, gap)
      call motion%system%gap_rates(y, rate)
      ! A gap that is zero to rounding is a contact from the start, not a touch.
      resolution = zero_gap(y)
      rows = row_count(plan%t_end, plan%interval)
      if (memory%row > 0) then
         undecided = memory%undecided
         closed = memory%closed
         row = memory%row
         bounded_until = memory%bounded_until
         if (bounded_until > t) call integrator%bound_step((bounded_until - t)/4.0_wp)
      else
         undecided = abs(gap) <= resolution
         closed = gap <= 0.0_wp .or. undecided
         where (motion%system%contacts%rigid)
            undecided = .false.
            closed = motion%system%contacts%closed
         end where
         do i = 1, motion%n_events
            if (closed(i)) call begin_impact(motion, i, -rate(i), changed)
         end do
         call observer%sample(motion, t, y, error)
         if (allocated(error)) return
         row = 1
         bounded_until = 0.0_wp
      end if
      t_watch = t
      steps = 0
      looks = 0
      do while (row <= rows)
         steps = steps + 1
         if (steps >= watched_steps) then
            call watch_pace(motion, (t - t_watch)/steps, plan%t_end - t, looks, error)
            if (allocated(error)) return
            t_watch = t
            steps = 0
            motion%system%trouble = 0
         end if
         t_before = t
         y_before = y
         rate_before = rate
         call integrator%step(t, y, events, error)
         if (allocated(error)) return
         too_deep = motion%system%too_deep > 0
         if (too_deep) call find_depth(integrator, motion, t_before, t, y, too_deep)
         if (.not. all(closed)) then
            call motion%system%gap_rates(y, rate)
            suspect = .not. closed .and. events == 0 .and. rate_before < 0.0_wp .and. &
               rate > 0.0_wp .and. .not. motion%system%contacts%leaving
            t_dip = huge(t_dip)
            if (any(suspect)) call find_dip(integrator, motion, t_before, t, suspect, resolution, &
               t_dip)
            if (t_dip < t) then
               ! A contact closed and opened again within the step: take it in smaller ones.
               t = t_before
               y = y_before
               rate = rate_before
               bounded_until = t_dip
               call integrator%bound_step((t_dip - t)/4.0_wp)
               call integrator%restart(t, y, error)
               if (allocated(error)) return
               cycle
            end if
            if (bounded_until > 0.0_wp .and. t > bounded_until) then
               call integrator%bound_step(plan%max_step)
               bounded_until = 0.0_wp
            end if
         end if
         do while (row <= rows)
            t_row = min(row*plan%interval, plan%t_end)
            if (row == rows) t_row = plan%t_end
            if (t_row > t) exit
            call integrator%interpolate(t_row, row_state)
            call observer%sample(motion, t_row, row_state, error)
            if (allocated(error)) return
            row = row + 1
         end do
         if (observer%next_time < t) call look_between(integrator, motion, t, observer, unasked)
         if (too_deep) then
            call fatal(error, "the motion leaves the domain of the model")
            return
         end if
         if (any(undecided)) then
            call motion%system%gaps(y, gap)
            where (undecided .and. events /= 0)
               closed = events < 0
               undecided = .false.
               events = 0
            else where (undecided .and. abs(gap) > resolution)
               closed = gap < 0.0_wp
               undecided = .false.
            end where
         end if
         if (any(events /= 0)) then
            call take_events(integrator, motion, t, y, events, closed, observer, error)
            if (allocated(error)) return
            ! While all contacts were closed the rates were not kept; impacts change velocities.
            call motion%system%gap_rates(y, rate)
         end if
         if (motion%system%constraints%n_rigid > 0) then
            if (any(motion%system%contacts%leaving)) call part(motion, y)
         end if
         if (t >= integrator%t_stop) then
            call set_stop(integrator, motion, t)
            call integrator%restart(t, y, error)
            if (allocated(error)) return
         end if
         if (memory%switch%may .and. bounded_until <= 0.0_wp .and. row <= rows) then
            call switch_if_due(integrator, memory%switch, motion, plan, t, y, all(events == 0), &
               observer, error)
            if (allocated(error)) return
         else if (allocated(integrator%advice)) then
            call observer%advise(t, integrator%advice)
            deallocate(integrator%advice)
         end if
         call observer%after_step(t, stopped, error)
         if (allocated(error)) return
         if (stopped .or. observer%keep_due) then
            call take_stock()
            call observer%keep(motion, memory, error)
            if (allocated(error) .or. stopped) return
         end if
      end do
      call take_stock()

   contains

      !> Bring up to date from where the march goes on.
      subroutine take_stock()
         memory%row = row
         memory%closed = closed
         memory%undecided = undecided
         memory%bounded_until = bounded_until
         memory%statistics = counters(memory%switch, integrator, unasked)
      end subroutine take_stock

   end subroutine advance

   !> States that are asked for beside the rows, so that nothing that follows depends on it.
   subroutine look_between(integrator, motion, t, observer, unasked)
      class(integrator_type), intent(inout) :: integrator
      class(motion_type), intent(inout) :: motion
      !> End of the step [s].
      real(wp), intent(in) :: t
      class(observer_type), intent(inout) :: observer
      !> Right-hand sides that were evaluated for this.
      integer(i8), intent(inout) :: unasked
      type(statistics_type) :: before, after
      type(track_type) :: track(motion%n_events)
      real(wp) :: y(motion%n), force(motion%n_events)
      integer :: too_deep, trouble, trouble_code
      logical :: outside

      associate (system => motion%system)
         too_deep = system%too_deep
         trouble = system%trouble
         trouble_code = system%trouble_code
         outside = system%outside
         track = system%contacts%track
         force = system%contacts%normal_force
         before = integrator%statistics()
         do while (observer%next_time < t)
            call integrator%interpolate(observer%next_time, y)
            call observer%between(motion, observer%next_time, y)
         end do
         after = integrator%statistics()
         unasked = unasked + after%derivatives - before%derivatives
         system%contacts%track = track
         system%contacts%normal_force = force
         system%too_deep = too_deep
         system%trouble = trouble
         system%trouble_code = trouble_code
         system%outside = outside
      end associate
   end subroutine look_between

   !> Go on with another method where the steps of this one are too short.
   subroutine switch_if_due(integrator, switch, motion, plan, t, y, quiet, observer, error)
      class(integrator_type), allocatable, intent(inout) :: integrator
      !> Which methods are used.
      type(switch_type), intent(inout) :: switch
      class(motion_type), intent(inout), target :: motion
      type(plan_type), intent(in) :: plan
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)
      !> Whether no contact has just opened or closed.
      logical, intent(in) :: quiet
      class(observer_type), intent(inout) :: observer
      !> Set when the other method cannot be started.
      type(error_type), allocatable, intent(out) :: error
      character(len=64) :: digits
      real(wp) :: mean

      switch%steps = switch%steps + 1
      switch%to_go = max(switch%to_go - 1_i8, 0_i8)
      if (integrator%steps_of_trial > 0) call look()
      if (.not. quiet .or. integrator%steps_of_trial > 0) return
      mean = (t - switch%t_look)/switch%steps
      if (switch%method == "explicit8") then
         if (switch%steps >= steps_between_looks .or. allocated(integrator%advice)) then
            switch%explicit_step = max(switch%explicit_step, mean)
            call look()
         end if
         if (.not. allocated(integrator%advice)) return
         deallocate(integrator%advice)
         if (switch%to_go > 0 .and. .not. integrator%hopeless) return
         call change("cvode_bdf", "stability, not accuracy, bounds the steps of explicit8")
      else if (switch%steps >= steps_between_looks) then
         call look()
         if (switch%explicit_step <= 0.0_wp .or. mean >= switch%explicit_step) return
         switch%to_go = switch%patience
         switch%patience = 2_i8*switch%patience
         write(digits, "(es8.1, a, es8.1, a)") mean, " s, those of explicit8 were", &
            switch%explicit_step, " s"
         switch%explicit_step = 0.0_wp
         call change("explicit8", "the steps of cvode_bdf are" // trim(digits))
      end if

   contains

      !> Begin to look anew.
      subroutine look()
         switch%t_look = t
         switch%steps = 0
      end subroutine look

      !> Go on with a method.
      subroutine change(method, reason)
         character(len=*), intent(in) :: method
         !> Why.
         character(len=*), intent(in) :: reason

         switch%before = switch%before + integrator%statistics()
         call integrator%free()
         call new_integrator(method, integrator)
         integrator%alert = .true.
         call set_stop(integrator, motion, t)
         call integrator%start(motion, method, t, y, plan%t_end, plan%max_step, &
            error)
         switch%method = method
         call look()
         call observer%change_method(t, method, reason)
      end subroutine change

   end subroutine switch_if_due

   !> End a march whose steps have become so small that it would not come to its end.
   subroutine watch_pace(motion, step, left, looks, error)
      class(motion_type), intent(in) :: motion
      !> Mean step of late [s].
      real(wp), intent(in) :: step
      !> Time to go [s].
      real(wp), intent(in) :: left
      !> For how many looks the steps have been too small.
      integer, intent(inout) :: looks
      !> Set when there is no sense in going on.
      type(error_type), allocatable, intent(out) :: error
      character(len=64) :: digits

      looks = looks + 1
      if (step >= poor*motion%contact_time .or. left <= poor_steps*step) looks = 0
      if (looks < poor_looks .and. &
         (step >= hopeless*motion%contact_time .or. left <= hopeless_steps*step)) return
      write(digits, "(es8.1, a, es8.1, a)") step, " s, and ", left/step, " more would be needed"
      call fatal(error, "the steps have shrunk to" // trim(digits))
   end subroutine watch_pace

   !> Find where within a step a contact becomes too deep.
   subroutine find_depth(integrator, motion, t_before, t, y, too_deep)
      !> The integration, its last step from `t_before` to `t`.
      class(integrator_type), intent(inout) :: integrator
      !> The motion; `too_deep` of its system names the contact.
      class(motion_type), intent(inout) :: motion
      !> Beginning of the step [s].
      real(wp), intent(in) :: t_before
      !> End of the step, moved to where the contact is as deep as is admitted [s].
      real(wp), intent(inout) :: t
      real(wp), intent(inout) :: y(:)
      !> Whether a contact of the accepted state is too deep, not only one of a trial.
      logical, intent(out) :: too_deep
      real(wp) :: gap(motion%n_events), limit(motion%n_events), low, high, middle
      integer :: i

      limit = [(motion%system%contacts(i)%law%largest_approach, i=1, motion%n_events)]
      call motion%system%gaps(y, gap)
      too_deep = any(-gap > limit)
      if (.not. too_deep) return
      low = t_before
      high = t
      do i = 1, 60
         middle = 0.5_wp*(low + high)
         if (middle <= low .or. middle >= high) exit
         call integrator%interpolate(middle, y)
         call motion%system%gaps(y, gap)
         if (any(-gap > limit)) then
            high = middle
            motion%system%too_deep = maxloc(-gap - limit, dim=1)
         else
            low = middle
         end if
      end do
      t = high
      call integrator%interpolate(t, y)
   end subroutine find_depth

   !> First time within a step at which an open gap that falls and rises again is closed; a time
   !> after the step if there is none.
   subroutine find_dip(integrator, motion, t_before, t, suspect, resolution, t_dip)
      !> The integration, its last step from `t_before` to `t` or beyond.
      class(integrator_type), intent(inout) :: integrator
      class(motion_type), intent(inout) :: motion
      !> Beginning of the step [s].
      real(wp), intent(in) :: t_before
      !> End of the step [s].
      real(wp), intent(in) :: t
      !> Contacts whose gap is open at both ends, falls at the first and rises at the second.
      logical, intent(in) :: suspect(:)
      !> Overlaps below this are not seen [m].
      real(wp), intent(in) :: resolution
      !> The time [s].
      real(wp), intent(out) :: t_dip
      real(wp) :: low, high, middle, y(motion%n), gap(motion%n_events), rate(motion%n_events)
      integer :: i, k

      t_dip = huge(t_dip)
      do i = 1, size(suspect)
         if (.not. suspect(i)) cycle
         low = t_before
         high = t
         do k = 1, 60
            middle = 0.5_wp*(low + high)
            if (middle <= low .or. middle >= high) exit
            call integrator%interpolate(middle, y)
            call motion%system%gaps(y, gap)
            if (gap(i) < -resolution) then
               t_dip = min(t_dip, middle)
               exit
            end if
            call motion%system%gap_rates(y, rate)
            if (rate(i) < 0.0_wp) then
               low = middle
            else
               high = middle
            end if
         end do
      end do
   end subroutine find_dip

   !> Record events, and let the contacts take note of the impact speed.
   subroutine take_events(integrator, motion, t, y, events, closed, observer, error)
      class(integrator_type), intent(inout) :: integrator
      class(motion_type), intent(inout) :: motion
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(inout) :: y(:)
      !> For each contact 1, -1 or 0 as the gap opens, closes, or neither.
      integer, intent(in) :: events(:)
      !> Which contacts are closed.
      logical, intent(inout) :: closed(:)
      class(observer_type), intent(inout) :: observer
      !> Set when the observer failed.
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: rate(size(events))
      logical :: changed, any_changed, any_rigid
      integer :: i

      any_changed = .false.
      any_rigid = .false.
      call motion%system%gap_rates(y, rate)
      do i = 1, size(events)
         any_rigid = any_rigid .or. (motion%system%contacts(i)%rigid .and. events(i) /= 0)
         if (events(i) < 0 .and. .not. closed(i)) then
            closed(i) = .true.
            call begin_impact(motion, i, -rate(i), changed)
            any_changed = any_changed .or. changed
            call renew_states(motion, i, .true., y, any_changed)
            call observer%event(t, event_touch, i, error)
         else if (events(i) > 0 .and. closed(i)) then
            closed(i) = .false.
            call renew_states(motion, i, .false., y, any_changed)
            call observer%event(t, event_lift, i, error)
         end if
         if (allocated(error)) return
      end do
      if (any_rigid) then
         call meet(motion, t, y, events, closed, observer, error)
         if (allocated(error)) return
         any_changed = .true.
      end if
      if (any_changed) call integrator%restart(t, y, error)
   end subroutine take_events

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

   !> Gap that is zero to rounding [m].
   pure real(wp) function zero_gap(y)
      !> State.
      real(wp), intent(in) :: y(:)

      zero_gap = 64.0_wp*epsilon(y)*(1.0_wp + maxval(abs(y)))
   end function zero_gap

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
      if (any(touching)) call settle_all(motion, t, y, touching, error)
   end subroutine begin_rigid

   !> Settle rigid contacts.
   subroutine settle_all(motion, t, y, touching, error)
      class(motion_type), intent(inout) :: motion
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(inout) :: y(:)
      !> Contacts whose gaps are zero.
      logical, intent(in) :: touching(:)
      !> Set when the contacts cannot be settled.
      type(error_type), allocatable, intent(out) :: error
      integer :: index, trouble

      call settle(motion%system, t, y, touching, motion%scales%velocity, index, trouble)
      if (index == 0) return
      motion%system%trouble = index
      motion%system%trouble_code = trouble
      call fatal(error, "the rigid contacts cannot be settled")
   end subroutine settle_all

   !> What follows from an event of a rigid contact: impacts, and which contacts stay closed.
   subroutine meet(motion, t, y, events, closed, observer, error)
      class(motion_type), intent(inout) :: motion
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(inout) :: y(:)
      !> For each contact 1, -1 or 0 as it opens, closes, or neither.
      integer, intent(in) :: events(:)
      !> Which contacts are closed.
      logical, intent(inout) :: closed(:)
      class(observer_type), intent(inout) :: observer
      !> Set when the contacts cannot be settled or the observer failed.
      type(error_type), allocatable, intent(out) :: error
      logical :: touching(size(events)), changed
      integer :: i

      associate (contacts => motion%system%contacts)
         ! One that lifts off has no force and its gap no acceleration.
         call motion%system%set_poses(y)
         do i = 1, size(events)
            if (contacts(i)%closed .and. events(i) > 0) call open_contact(motion%system, i)
         end do
         touching = contacts%rigid .and. (contacts%closed .or. events < 0)
         if (any(touching .and. events < 0)) then
            call settle_all(motion, t, y, touching, error)
            if (allocated(error)) return
         end if
         do i = 1, size(events)
            if (.not. contacts(i)%rigid .or. (contacts(i)%closed .eqv. closed(i))) cycle
            closed(i) = contacts(i)%closed
            call renew_states(motion, i, closed(i), y, changed)
            call observer%event(t, merge(event_touch, event_lift, closed(i)), i, error)
            if (allocated(error)) return
         end do
      end associate
   end subroutine meet

   !> Note that gaps have become distinct from zero.
   subroutine part(motion, y)
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
   end subroutine part

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

end module contensou_integrate_march
