!> March a motion from its initial state to the end: rows at fixed intervals, touch and lift-off
!> as events, a chance to stop after every step.
module contensou_integrate_march
   use contensou_base_checkpoint, only : checkpoint_type
   use contensou_base_errors, only : error_type, fatal, status_failed
   use contensou_base_kinds, only : i8, wp
   use contensou_base_numbers, only : power_text
   use contensou_contact_geometry, only : contact_point_type, track_type, trouble_conforming, &
      trouble_far, trouble_none, trouble_pulls, trouble_sudden, trouble_unseen
   use contensou_dynamics_impact, only : rest, slow_rate, stop_closed_gaps
   use contensou_dynamics_links, only : link_type
   use contensou_dynamics_mechanism, only : contact_motion_type, gap_type
   use contensou_dynamics_reports, only : energy_type, find_energy
   use contensou_dynamics_rests, only : agree, check_contacts, open_contact, resolve_contacts, &
      set_thresholds, sunk, touching_gap
   use contensou_dynamics_scene, only : stop_spec_type
   use contensou_dynamics_spots, only : assign_spots, change_spots, take_back_spots
   use contensou_dynamics_state, only : position_of
   use contensou_integrate_choice, only : choice_type, choose_method, explicit_reach
   use contensou_integrate_cvode, only : cvode_type
   use contensou_integrate_explicit8, only : explicit8_type
   use contensou_integrate_integrator, only : integrator_type, statistics_type
   use contensou_integrate_motion, only : motion_type
   use contensou_integrate_stops, only : stops_type
   use contensou_special_bisection, only : bisection_type
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
      !> Conditions that end the march before; not allocated for none.
      type(stop_spec_type), allocatable :: stops(:)
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
      !> Energy at the beginning, with what was lost and without what was supplied [J], and the
      !> largest part of it that has moved since: kinetic or elastic energy, change of the
      !> potential one, work [J].
      real(wp) :: energy = 0.0_wp, energy_moved = 0.0_wp
      !> Potential energy at the beginning [J].
      real(wp) :: potential = 0.0_wp
      !> Largest share of the energy that moved by which the balance was off; 0 as long as that is
      !> too little to be told.
      real(wp) :: imbalance = 0.0_wp
      !> How many times the tolerance was tightened, as rigid contacts sank in.
      integer :: tightened = 0
      !> The method in use, and what `auto` knows.
      type(switch_type) :: switch
      !> Counters so far.
      type(statistics_type) :: statistics
      !> What is known of the conditions that end the march, and which one has.
      type(stops_type) :: stops
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
      procedure :: warn
      procedure :: change_method
      procedure :: keep
   end type observer_type

   !> Bounds of the gap of an open contact within a step.
   type :: bounds_type
      !> How strongly it bends down over convex surfaces [m/s2].
      real(wp) :: bend = 0.0_wp
      !> Where a surface is concave, of its rate [m/s]; else 0.
      real(wp) :: speed = 0.0_wp
      !> Overlap that goes unseen [m].
      real(wp) :: overlap = 0.0_wp
   end type bounds_type

   !> A march under way: what takes part in it. Where it is stands in its memory.
   type :: march_type
      class(integrator_type), allocatable :: integrator
      class(motion_type), pointer :: motion => null()
      type(plan_type) :: plan
      type(memory_type), pointer :: memory => null()
      class(observer_type), pointer :: observer => null()
      !> Number of the last row.
      integer(i8) :: rows = 0
      !> Right-hand sides for states beside the rows, which do not count.
      integer(i8) :: unasked = 0
      !> Gap that is zero to rounding [m].
      real(wp) :: resolution = 0.0_wp
      !> For each contact 1, -1 or 0 as its gap opens, closes, or neither at the end of the step.
      integer, allocatable :: events(:)
      !> Gaps and their motion where they were looked at last: not while all contacts are closed,
      !> nor while those that are open are so far away that none can have touched.
      type(gap_type), allocatable :: gap(:)
      !> Part of each gap that cannot have been passed since then [m], and the bound of its rate at
      !> the end of the last step [m/s].
      real(wp), allocatable :: clearance(:), fastest(:)
      !> Whether looks may be left out, and whether the last one was at the end of the last step.
      logical :: may_skip = .false., seen = .false.
      !> Time, state and gaps at the beginning of the step.
      real(wp) :: t_before = 0.0_wp
      real(wp), allocatable :: y_before(:)
      type(gap_type), allocatable :: gap_before(:)
      !> State of a row, contacts that may have closed and opened again within the step, those that
      !> missed a touch, and those that pull: room that is not allocated at each step.
      real(wp), allocatable :: y_row(:)
      logical, allocatable :: suspect(:), missed(:), pulls(:)
      !> Time at which the pace was looked at last [s], steps since, and looks at which it was poor.
      real(wp) :: t_watch = 0.0_wp
      integer :: steps = 0, looks = 0
      !> Time since which no event was, and steps since then, started anew from time to time.
      real(wp) :: t_quiet = 0.0_wp
      integer :: quiet_steps = 0
      !> Steps since the last check of what a tolerance does not tell of.
      integer :: unchecked = 0
      !> How often the step was taken again because its spots were others.
      integer :: retaken = 0
      !> Condition that is met where the march is; 0 for none.
      integer :: met = 0
      !> Whether there is any.
      logical :: has_stops = .false.
   end type march_type

   !> What a look at a state changes in a system, though the march is to go on as if there had been
   !> none.
   type :: kept_type
      type(track_type), allocatable :: track(:)
      !> Normal forces of rigid contacts [N].
      real(wp), allocatable :: force(:)
      integer :: too_deep, trouble, trouble_code
      logical :: outside
   end type kept_type

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

   !> Overlap of a closed rigid contact, over that which ends a run, and its growth since the last
   !> time, at which the tolerance is tightened: the errors of the integration make it.
   real(wp), parameter :: drift_step = 0.2_wp

   !> Gap at an event, in units of the tolerance of positions: it is found on an interpolant.
   real(wp), parameter :: place_of_event = 1.0e3_wp

   !> Ratio of the curvatures below which surfaces as good as conform: where a march fails, they do.
   real(wp), parameter :: nearly = 1.0e-3_wp

   !> Steps after which what a tolerance does not tell of is checked, beside touches and the end.
   integer, parameter :: checked_steps = 100

   !> How often a step is taken again before its spots are given up.
   integer, parameter :: most_retaken = 200

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

   !> Steps without an event after which it is seen whether friction sticks.
   integer, parameter :: quiet_enough = 2000

   !> Steps to the end from which on another method is to take over where friction sticks.
   real(wp), parameter :: stuck_steps = 1.0e5_wp

   !> Overlap within a step that goes unseen, over the smallest radius.
   real(wp), parameter :: unseen_overlap = 2.0e-7_wp

   !> Speed at which nothing moves, and through which a length can be divided [m/s].
   real(wp), parameter :: still = 1.0e-100_wp

   !> Step that cannot be halved any more, in units of the rounding of the time.
   real(wp), parameter :: shortest = 4.0_wp

   !> Looks at the gap of one contact within a step; one that needs more is taken in smaller ones.
   integer, parameter :: most_looks = 2000

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
   subroutine between(self, motion, t, y, error)
      class(observer_type), intent(inout) :: self
      class(motion_type), intent(inout) :: motion
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)
      !> Set to end the march.
      type(error_type), allocatable, intent(out) :: error

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

   !> What the user should know of a run that came to its end; nobody listens unless an observer
   !> overrides this.
   subroutine warn(self, text)
      class(observer_type), intent(inout) :: self
      !> What it is.
      character(len=*), intent(in) :: text
   end subroutine warn

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
      call checkpoint%exchange("energy", self%energy)
      call checkpoint%exchange("energy_moved", self%energy_moved)
      call checkpoint%exchange("potential", self%potential)
      call checkpoint%exchange("imbalance", self%imbalance)
      call self%statistics%exchange(checkpoint)
      call checkpoint%exchange("method", self%switch%method)
      call checkpoint%exchange("patience", self%switch%patience)
      call checkpoint%exchange("to_go", self%switch%to_go)
      call checkpoint%exchange("explicit_step", self%switch%explicit_step)
      call checkpoint%exchange("tightened", self%tightened)
      do i = 1, size(motion%system%contacts)
         call motion%system%contacts(i)%exchange(checkpoint)
      end do
      call self%stops%exchange(checkpoint)
   end subroutine exchange_memory

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

   !> March to the end, or until the observer stops it; then another call goes on.
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
      self%rows = row_count(plan%t_end, plan%interval)
      ! All rows were written when it stopped.
      if (memory%row > self%rows) return
      self%motion => motion
      self%plan = plan
      self%memory => memory
      self%observer => observer
      memory%switch%before = memory%statistics
      memory%switch%may = plan%method == "auto"
      call start(self, trim(memory%switch%method), error)
      if (.not. allocated(error)) call advance(self, stopped, error)
      if (allocated(error)) call heed_conforming(self, error)
      memory%statistics = counters(self)
      call self%integrator%free()
   end subroutine march

   !> Start a method where the march is.
   subroutine start(self, method, error)
      type(march_type), intent(inout) :: self
      !> One of `integrator_methods`.
      character(len=*), intent(in) :: method
      !> Set when it cannot be started.
      type(error_type), allocatable, intent(out) :: error

      if (self%memory%tightened > 0 .or. self%plan%method /= method) call refine(self, method)
      call new_integrator(method, self%integrator)
      self%integrator%alert = self%memory%switch%may
      call set_stop(self)
      call self%integrator%start(self%motion, method, self%memory%t, self%memory%y, &
         self%plan%t_end, self%plan%max_step, error)
      self%memory%switch%t_look = self%memory%t
      self%memory%switch%steps = 0
   end subroutine start

   !> Set the tolerance that a method needs to hold rigid contacts.
   subroutine refine(self, method)
      type(march_type), intent(inout) :: self
      !> One of `integrator_methods`.
      character(len=*), intent(in) :: method

      call self%motion%set_tolerance(self%plan%method /= "explicit8" .or. method /= "explicit8", &
         self%memory%tightened)
   end subroutine refine

   !> Counters of a march so far, and of those that it continues.
   function counters(self) result(statistics)
      type(march_type), intent(in) :: self
      type(statistics_type) :: statistics

      statistics = self%memory%switch%before + self%integrator%statistics()
      statistics%derivatives = statistics%derivatives - self%unasked
   end function counters

   !> Let the integration, to be started or restarted, go up to the end of the next ramp of a drive,
   !> no further.
   subroutine set_stop(self)
      type(march_type), intent(inout) :: self

      self%integrator%t_stop = self%motion%system%next_corner(self%memory%t)
      self%motion%system%corner = self%integrator%t_stop
   end subroutine set_stop

   !> The loop of `march`.
   subroutine advance(self, stopped, error)
      !> The march, its integration started.
      type(march_type), intent(inout) :: self
      !> Whether the observer asked to stop.
      logical, intent(inout) :: stopped
      !> Set when the integration or the observer failed.
      type(error_type), allocatable, intent(out) :: error
      logical :: too_deep, again, unresolved

      call set_out(self, error)
      if (allocated(error)) return
      associate (system => self%motion%system, memory => self%memory, t => self%memory%t)
         do while (memory%row <= self%rows)
            call watch_pace(self, error)
            if (allocated(error)) return
            self%t_before = t
            self%y_before = memory%y
            if (self%seen) self%gap_before = self%gap
            ! Trouble of a trial of the last step is over.
            system%trouble = 0
            call self%integrator%step(t, memory%y, self%events, error)
            if (allocated(error)) return
            too_deep = system%too_deep > 0
            if (too_deep) call find_depth(self, too_deep)
            if (system%several_spots) then
               call follow_spots(self, again, error)
               if (allocated(error)) return
               if (again) cycle
            end if
            if (self%motion%unfound .and. .not. too_deep) then
               call fatal(error, "the forces of the rigid contacts are not found")
               return
            end if
            if (.not. all(memory%closed)) then
               call avoid_dip(self, again, error)
               if (allocated(error)) return
               if (again) cycle
            end if
            if (self%has_stops) call watch_stops(self)
            call give_rows(self, error)
            if (.not. allocated(error) .and. self%met > 0) call end_here(self, error)
            if (allocated(error) .or. self%met > 0) return
            if (self%observer%next_time < t) call look_between(self, error)
            if (allocated(error)) return
            if (too_deep) then
               call fatal(error, "the motion leaves the domain of the model")
               return
            end if
            self%unchecked = self%unchecked + 1
            if (self%unchecked >= checked_steps .or. any(self%events < 0) .or. &
               memory%row > self%rows) then
               self%unchecked = 0
               call check_resolution(self, error)
               if (.not. allocated(error)) call check_touches(self, error)
               if (.not. allocated(error)) call check_balance(self, error)
               if (allocated(error)) return
            end if
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
            if (memory%switch%may .and. memory%bounded_until <= 0.0_wp .and. &
               memory%row <= self%rows) then
               call switch_if_due(self, error)
               if (allocated(error)) return
            else if (sticks(self)) then
               call change_method_to(self, "cvode_bdf", "friction that sticks at rigid contacts " &
                  // "is too stiff for " // trim(self%plan%method), error)
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

   !> Begin with the first row, or go on where a march has stopped.
   subroutine set_out(self, error)
      type(march_type), intent(inout) :: self
      !> Set when the observer failed.
      type(error_type), allocatable, intent(out) :: error
      logical :: changed
      integer :: i, n

      n = self%motion%n_events
      allocate(self%events(n), self%gap(n), self%suspect(n), self%missed(n), self%pulls(n), &
         self%y_row(self%motion%n))
      associate (system => self%motion%system, memory => self%memory, y => self%memory%y)
         self%may_skip = system%constraints%n_rigid == 0 .and. .not. system%several_spots
         allocate(self%clearance(n), self%fastest(n))
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

   !> Gaps and their motion at the state that is reached.
   subroutine look_at_gaps(self)
      type(march_type), intent(inout) :: self
      integer :: i

      associate (system => self%motion%system)
         call system%set_poses(self%memory%y)
         do i = 1, size(self%gap)
            call system%gap_motion(i, self%gap(i))
         end do
         self%seen = .true.
         self%clearance = 0.0_wp
         if (.not. (self%may_skip .and. self%integrator%free_interpolation)) return
         self%clearance = self%gap%value
         do i = 1, size(self%gap)
            self%fastest(i) = system%fastest(i, self%memory%y)
         end do
      end associate
   end subroutine look_at_gaps

   !> Gaps and their motion at the beginning of the step.
   subroutine look_before(self)
      type(march_type), intent(inout) :: self
      integer :: i

      associate (system => self%motion%system)
         call system%set_poses(self%y_before)
         do i = 1, size(self%gap)
            call system%gap_motion(i, self%gap_before(i))
         end do
      end associate
   end subroutine look_before

   !> If a contact closed and opened again within the step, go back to take it in smaller ones.
   subroutine avoid_dip(self, again, error)
      type(march_type), intent(inout) :: self
      !> Whether the march is at the beginning of the step again.
      logical, intent(out) :: again
      !> Set when the integration cannot go on there.
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: t_dip
      integer :: index
      logical :: looked, near

      again = .false.
      associate (memory => self%memory, t => self%memory%t)
         if (far_away(self)) then
            self%seen = .false.
            if (memory%bounded_until > 0.0_wp) call lift_bound(self)
            return
         end if
         if (.not. self%seen) call look_before(self)
         call look_at_gaps(self)
         self%suspect = .not. memory%closed .and. self%events == 0 .and. &
            self%gap_before%rate < 0.0_wp .and. self%gap%rate > 0.0_wp .and. &
            .not. self%motion%system%contacts%leaving
         t_dip = huge(t_dip)
         index = findloc(self%suspect, .true., dim=1)
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
         if (again .and. t - self%t_before <= shortest*spacing(t)) then
            ! There are no smaller ones.
            self%motion%system%trouble = index
            self%motion%system%trouble_code = trouble_unseen
            call fatal(error, "a gap cannot be followed")
         else if (again) then
            t = self%t_before
            memory%y = self%y_before
            self%gap = self%gap_before
            self%clearance = 0.0_wp
            memory%bounded_until = t_dip
            call self%integrator%bound_step((t_dip - t)/4.0_wp)
            call self%integrator%restart(t, memory%y, error)
         else if (memory%bounded_until > 0.0_wp) then
            call lift_bound(self)
         end if
      end associate
   end subroutine avoid_dip

   !> Let the steps be as long as they were before they were made smaller, once that is passed.
   subroutine lift_bound(self)
      type(march_type), intent(inout) :: self

      associate (memory => self%memory)
         if (memory%t <= memory%bounded_until) return
         call self%integrator%bound_step(self%plan%max_step)
         memory%bounded_until = 0.0_wp
      end associate
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
         if (self%memory%closed(i) .or. self%events(i) /= 0) cycle
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

   !> See the spots as they are at a state within the step, with what touches in it.
   subroutine view_spots(self, y)
      type(march_type), intent(inout) :: self
      real(wp), intent(in) :: y(:)
      integer :: index, trouble

      call self%motion%system%set_poses(y)
      call assign_spots(self%motion%system, self%memory%closed, index, trouble)
   end subroutine view_spots

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
      real(wp) :: height, bend, root

      reach = 0.0_wp
      height = gap%value + bounds%overlap
      if (height <= 0.0_wp) return
      bend = bounds%bend + 2.0_wp*gap%sharpness*bounds%speed**2
      root = sqrt(rate**2 + 2.0_wp*bend*height)
      if (rate > 0.0_wp) then
         reach = (rate + root)/max(bend, tiny(bend)*max(rate, 1.0_wp)*4.0_wp)
      else
         reach = 2.0_wp*height/max(root - rate, tiny(root)*max(height, 1.0_wp)*4.0_wp)
      end if
      if (bounds%speed > still) reach = max(min(reach, 0.5_wp/(gap%sharpness*bounds%speed)), &
         height/bounds%speed)
   end function reach

   !> Whether all open contacts are so far away that none can have touched in the step.
   logical function far_away(self)
      type(march_type), intent(inout) :: self
      real(wp) :: fastest
      integer :: i

      ! Looks within a step are part of the counts that others compare: a method that pays for them
      ! looks at each step.
      far_away = self%may_skip .and. self%integrator%free_interpolation
      if (.not. far_away) return
      do i = 1, size(self%clearance)
         fastest = self%motion%system%fastest(i, self%memory%y)
         ! Between the ends it may be faster, though not by much.
         self%clearance(i) = self%clearance(i) &
            - 2.0_wp*max(fastest, self%fastest(i))*(self%memory%t - self%t_before)
         self%fastest(i) = fastest
         if (self%memory%closed(i) .and. self%events(i) == 0) cycle
         far_away = far_away .and. self%clearance(i) > 0.0_wp .and. self%events(i) == 0
      end do
   end function far_away

   !> Suspect the open contacts whose gaps may fall below zero as seen from the ends of the step.
   pure subroutine suspect_near(self)
      type(march_type), intent(inout) :: self
      type(bounds_type) :: bounds
      integer :: i

      do i = 1, size(self%suspect)
         self%suspect(i) = .not. self%memory%closed(i)
         if (.not. self%suspect(i)) cycle
         bounds = bounds_of(self, i)
         associate (now => self%gap(i), before => self%gap_before(i))
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

   !> Begin to look at states within the step, of which nothing that follows is to depend, and keep
   !> what is to be put back.
   subroutine open_step(self, t, kept)
      type(march_type), intent(inout) :: self
      !> Time within the step [s].
      real(wp), intent(in) :: t
      type(kept_type), intent(out) :: kept
      type(statistics_type) :: before, after
      real(wp) :: y(self%motion%n)

      call keep_workspace(self%motion, kept)
      before = self%integrator%statistics()
      call self%integrator%interpolate(t, y)
      after = self%integrator%statistics()
      if (min(self%memory%row*self%plan%interval, self%plan%t_end) < self%memory%t) then
         ! A row has the same need of what the interpolation takes.
         call keep_workspace(self%motion, kept)
      else
         self%unasked = self%unasked + after%derivatives - before%derivatives
      end if
   end subroutine open_step

   !> Hand over the rows that the step has come by.
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
            if (t > self%memory%t) exit
            call self%integrator%interpolate(t, self%y_row)
            if (several) then
               call keep_workspace(self%motion, kept)
               call view_spots(self, self%y_row)
            end if
            call self%observer%sample(self%motion, t, self%y_row, error)
            if (allocated(error)) return
            if (several) call restore_workspace(self%motion, kept)
            row = row + 1
         end do
      end associate
   end subroutine give_rows

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

   !> Keep what a look at a state changes.
   subroutine keep_workspace(motion, kept)
      class(motion_type), intent(in) :: motion
      type(kept_type), intent(out) :: kept

      associate (system => motion%system)
         kept%too_deep = system%too_deep
         kept%trouble = system%trouble
         kept%trouble_code = system%trouble_code
         kept%outside = system%outside
         allocate(kept%track(motion%n_events), kept%force(motion%n_events))
         kept%track = system%contacts%track
         kept%force = system%contacts%normal_force
      end associate
   end subroutine keep_workspace

   !> Put back what a look at a state has changed.
   subroutine restore_workspace(motion, kept)
      class(motion_type), intent(inout) :: motion
      type(kept_type), intent(in) :: kept

      associate (system => motion%system)
         system%contacts%track = kept%track
         system%contacts%normal_force = kept%force
         system%too_deep = kept%too_deep
         system%trouble = kept%trouble
         system%trouble_code = kept%trouble_code
         system%outside = kept%outside
      end associate
   end subroutine restore_workspace

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

   !> Go on with another method where the steps of this one are too short.
   subroutine switch_if_due(self, error)
      type(march_type), intent(inout) :: self
      !> Set when the other method cannot be started.
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: mean

      associate (switch => self%memory%switch)
         switch%steps = switch%steps + 1
         switch%to_go = max(switch%to_go - 1_i8, 0_i8)
         if (self%integrator%steps_of_trial > 0) call look()
         if (any(self%events /= 0) .or. self%integrator%steps_of_trial > 0) return
         mean = (self%memory%t - switch%t_look)/switch%steps
         if (switch%method == "explicit8") then
            if (switch%steps >= steps_between_looks .or. allocated(self%integrator%advice)) then
               switch%explicit_step = max(switch%explicit_step, mean)
               call look()
            end if
            if (.not. allocated(self%integrator%advice)) return
            deallocate(self%integrator%advice)
            if (switch%to_go > 0 .and. .not. self%integrator%hopeless) return
            call change_method_to(self, "cvode_bdf", &
               "stability, not accuracy, bounds the steps of explicit8", error)
         else if (switch%steps >= steps_between_looks) then
            call look()
            if (switch%explicit_step <= 0.0_wp .or. mean >= switch%explicit_step) return
            switch%to_go = switch%patience
            switch%patience = 2_i8*switch%patience
            call change_method_to(self, "explicit8", "the steps of cvode_bdf are " // &
               power_text(mean, 2) // " s, those of explicit8 were " // &
               power_text(switch%explicit_step, 2) // " s", error)
            switch%explicit_step = 0.0_wp
         end if
      end associate

   contains

      !> Begin to look anew.
      subroutine look()
         self%memory%switch%t_look = self%memory%t
         self%memory%switch%steps = 0
      end subroutine look

   end subroutine switch_if_due

   !> Go on with another method.
   subroutine change_method_to(self, method, reason, error)
      type(march_type), intent(inout) :: self
      character(len=*), intent(in) :: method
      !> Why.
      character(len=*), intent(in) :: reason
      !> Set when it cannot be started.
      type(error_type), allocatable, intent(out) :: error

      self%memory%switch%before = self%memory%switch%before + self%integrator%statistics()
      call self%integrator%free()
      call start(self, method, error)
      self%memory%switch%method = method
      call self%observer%change_method(self%memory%t, method, reason)
   end subroutine change_method_to

   !> Whether friction that sticks at closed rigid contacts makes the steps of a method so short
   !> that it would not come to the end.
   logical function sticks(self)
      type(march_type), intent(inout) :: self
      real(wp) :: left
      integer :: i

      sticks = .false.
      if (self%motion%system%constraints%n_links == 0 .or. self%memory%switch%may) return
      if (self%memory%switch%method == "cvode_bdf") return
      if (any(self%events /= 0)) self%quiet_steps = 0
      if (self%quiet_steps == 0) self%t_quiet = self%memory%t
      self%quiet_steps = self%quiet_steps + 1
      if (self%quiet_steps <= quiet_enough) return
      left = self%plan%t_end - self%memory%t
      if (left > stuck_steps/self%quiet_steps*(self%memory%t - self%t_quiet)) then
         do i = 1, self%motion%n_events
            associate (contact => self%motion%system%contacts(i))
               sticks = sticks .or. (contact%rigid .and. contact%closed .and. &
                  allocated(contact%law%friction))
            end associate
         end do
      end if
      self%quiet_steps = 0
   end function sticks

   !> End a march whose steps have become so small that it would not come to its end.
   subroutine watch_pace(self, error)
      type(march_type), intent(inout) :: self
      !> Set when there is no sense in going on.
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: step, left

      self%steps = self%steps + 1
      if (self%steps < watched_steps) return
      step = (self%memory%t - self%t_watch)/self%steps
      left = self%plan%t_end - self%memory%t
      self%looks = self%looks + 1
      if (step >= poor*self%motion%contact_time .or. left <= poor_steps*step) self%looks = 0
      if (self%looks >= poor_looks .or. &
         (step < hopeless*self%motion%contact_time .and. left > hopeless_steps*step)) then
         call fatal(error, "the steps have shrunk to " // power_text(step, 2) // " s, and " // &
            power_text(left/step, 2) // " more would be needed")
         return
      end if
      self%t_watch = self%memory%t
      self%steps = 0
      self%motion%system%trouble = 0
   end subroutine watch_pace

   !> Find where within the step a contact becomes too deep, and move its end there.
   subroutine find_depth(self, too_deep)
      !> The march; `too_deep` of its system names the contact.
      type(march_type), intent(inout) :: self
      !> Whether a contact of the accepted state is too deep, not only one of a trial.
      logical, intent(out) :: too_deep
      real(wp), dimension(self%motion%n_events) :: gap, limit
      type(bisection_type) :: search
      integer :: i

      associate (system => self%motion%system, y => self%memory%y)
         limit = [(system%contacts(i)%law%largest_approach, i=1, size(limit))]
         call system%gaps(y, gap)
         too_deep = any(-gap > limit)
         if (.not. too_deep) return
         call search%begin(self%t_before, self%memory%t, steps=60)
         do while (search%goes_on)
            call self%integrator%interpolate(search%middle, y)
            call system%gaps(y, gap)
            associate (deep => any(-gap > limit))
               if (deep) system%too_deep = maxloc(-gap - limit, dim=1)
               call search%narrow(deep)
            end associate
         end do
         self%memory%t = search%high
         call self%integrator%interpolate(search%high, y)
      end associate
   end subroutine find_depth

   !> First time within the step at which an open gap that falls and rises again is closed; a time
   !> after the step if there is none.
   subroutine find_dip(self, t_dip)
      !> The march, with the contacts whose gap is open at both ends of the step, falls at the first
      !> and rises at the second.
      type(march_type), intent(inout) :: self
      !> The time [s].
      real(wp), intent(out) :: t_dip
      real(wp) :: y(self%motion%n)
      real(wp), dimension(self%motion%n_events) :: gap, rate
      type(bisection_type) :: search
      integer :: i

      t_dip = huge(t_dip)
      do i = 1, size(self%suspect)
         if (.not. self%suspect(i)) cycle
         call search%begin(self%t_before, self%memory%t, steps=60)
         do while (search%goes_on)
            call self%integrator%interpolate(search%middle, y)
            call self%motion%system%gaps(y, gap)
            if (gap(i) < -self%resolution) then
               t_dip = min(t_dip, search%middle)
               exit
            end if
            call self%motion%system%gap_rates(y, rate)
            call search%narrow(rate(i) >= 0.0_wp)
         end do
      end do
   end subroutine find_dip

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

   !> Tell the observer of an event, and see whether it ends the march.
   subroutine tell_event(self, kind, contact, error)
      type(march_type), intent(inout) :: self
      !> `event_touch` or `event_lift`.
      integer, intent(in) :: kind
      integer, intent(in) :: contact
      !> Set when the observer failed.
      type(error_type), allocatable, intent(out) :: error

      call self%observer%event(self%memory%t, kind, contact, error)
      if (.not. self%has_stops .or. self%met > 0) return
      self%met = self%memory%stops%of_event(self%plan%stops, kind == event_touch, &
         first_spot(self, contact))
      self%memory%stops%contact = contact
   end subroutine tell_event

   !> The contact of the first spot of the surfaces of a contact.
   pure integer function first_spot(self, contact)
      type(march_type), intent(in) :: self
      integer, intent(in) :: contact

      first_spot = contact - self%motion%system%contacts(contact)%spot + 1
   end function first_spot

   !> If a condition is met within the step, move its end there.
   subroutine watch_stops(self)
      type(march_type), intent(inout) :: self
      type(kept_type) :: kept
      real(wp) :: t_end, t_found, y(self%motion%n)

      associate (memory => self%memory, stops => self%memory%stops, specs => self%plan%stops, &
         bodies => self%motion%system%bodies, before => self%y_before)
         t_end = min(memory%t, self%plan%t_end)
         if (t_end <= self%t_before) return
         t_found = memory%t
         if (.not. stops%near(specs, bodies, self%t_before, before, t_found, memory%y)) return
         call open_step(self, 0.5_wp*(self%t_before + t_end), kept)
         call stops%find(specs, bodies, self%integrator, self%t_before, before, t_end, &
            self%met, t_found)
         if (self%met > 0) call self%integrator%interpolate(t_found, y)
         call restore_workspace(self%motion, kept)
         if (self%met == 0) return
         if (t_found <= self%t_before) y = before
         self%events = 0
         memory%t = t_found
         memory%y = y
         call look_at_gaps(self)
      end associate
   end subroutine watch_stops

   !> A condition is met here: the last row, and no more.
   subroutine end_here(self, error)
      type(march_type), intent(inout) :: self
      !> Set when the observer failed, or the energy is not where it should be.
      type(error_type), allocatable, intent(out) :: error

      associate (memory => self%memory)
         ! What comes after the end of time ends nothing.
         if (memory%row > self%rows) return
         memory%stops%ended_by = self%met
         if (memory%t > (memory%row - 1)*self%plan%interval) call self%observer%sample( &
            self%motion, memory%t, memory%y, error)
         memory%row = self%rows + 1
         if (.not. allocated(error)) call check_balance(self, error)
      end associate
   end subroutine end_here

   !> Where the march has failed and surfaces conform, or nearly do, see whether it is to end there.
   subroutine heed_conforming(self, error)
      type(march_type), intent(inout) :: self
      !> Why it has failed; not allocated if that is a condition to end.
      type(error_type), allocatable, intent(inout) :: error
      integer :: contact, met

      associate (system => self%motion%system, memory => self%memory)
         if (.not. self%has_stops .or. error%status /= status_failed) return
         if (memory%row > self%rows) return
         contact = system%trouble
         if (contact == 0 .or. system%trouble_code /= trouble_conforming) contact = &
            nearly_conforming(self)
         if (contact == 0) return
         met = memory%stops%of_conforming(self%plan%stops, first_spot(self, contact))
         if (met == 0) return
         self%met = met
         memory%stops%contact = contact
         if (self%motion%unfound) then
            memory%t = self%t_before
            memory%y = self%y_before
         end if
      end associate
      deallocate(error)
      call end_here(self, error)
   end subroutine heed_conforming

   !> A closed contact whose spot is so long that its surfaces as good as conform; 0 for none.
   integer function nearly_conforming(self) result(contact)
      type(march_type), intent(inout) :: self
      type(contact_point_type) :: at
      real(wp) :: gap

      associate (system => self%motion%system)
         call system%set_poses(self%memory%y)
         do contact = 1, size(system%contacts)
            if (.not. self%memory%closed(contact)) cycle
            associate (candidate => system%contacts(contact), &
               a => system%pose(system%contacts(contact)%a), &
               b => system%pose(system%contacts(contact)%b))
               call candidate%find_gap(a, b, gap)
               if (candidate%track%lost) cycle
               call candidate%locate(a, b, gap, at)
               if (at%curvature_a <= nearly*abs(at%curvature_b)) return
            end associate
         end do
      end associate
      contact = 0
   end function nearly_conforming

   !> See whether surfaces that touch overlap without having approached.
   subroutine check_touches(self, error)
      type(march_type), intent(inout) :: self
      !> Set where they do.
      type(error_type), allocatable, intent(out) :: error
      type(kept_type) :: kept
      real(wp), dimension(self%motion%n_events) :: gap, rate
      real(wp) :: explained
      integer :: i

      if (.not. any(self%events < 0)) return
      associate (system => self%motion%system, memory => self%memory)
         call keep_workspace(self%motion, kept)
         call system%gaps(memory%y, gap)
         call system%gap_rates(memory%y, rate)
         do i = 1, size(gap)
            if (self%events(i) >= 0 .or. memory%closed(i) .or. gap(i) >= 0.0_wp) cycle
            associate (contact => system%contacts(i))
               if (contact%track%lost) cycle
               ! An event is where the gap is zero, to the resolution of time.
               explained = time_of_event*epsilon(explained)*(abs(memory%t) + (memory%t &
                  - self%t_before))*(abs(rate(i)) + abs(self%gap_before(i)%rate))
               explained = explained + 16.0_wp*zero_gap(memory%y) &
                  + place_of_event*self%motion%scales%rtol*self%motion%scales%length
               ! One that has just opened may close below zero.
               if (contact%rigid) explained = explained &
                  + sunk*contact%law%geometry%smallest_radius()
               if (-gap(i) <= explained) cycle
            end associate
            system%trouble = i
            system%trouble_code = trouble_sudden
            call fatal(error, "a contact does not know where it touches")
            return
         end do
         call restore_workspace(self%motion, kept)
      end associate
   end subroutine check_touches

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

   !> See whether the energy is where it should be.
   subroutine check_balance(self, error)
      type(march_type), intent(inout) :: self
      !> Set when the balance is off by more than the tolerance explains.
      type(error_type), allocatable, intent(out) :: error
      type(energy_type) :: energy
      type(kept_type) :: kept
      real(wp) :: off, bound
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
         if (.not. abs(off) > bound) then
            if (abs(off) > warned*bound) memory%imbalance = max(memory%imbalance, &
               abs(off)/max(memory%energy_moved, tiny(off)))
            ! At the end it is told.
            if (memory%imbalance <= 0.0_wp .or. memory%row <= self%rows) return
            write(digits, "(es9.2)") memory%imbalance
            call self%observer%warn("the energy balance was off by" // trim(digits) // &
               " of the energy that moved: a smaller integrator.rtol closes it")
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
      !> Set when a contact has sunk in, drives or pulls.
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
            call open_contact(system, i)
         end do
      end associate
   end subroutine ignore_drift

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

end module contensou_integrate_march
