!> What accuracy costs: a scene over models, methods and tolerances, against reference solutions.
!>
!> Each model has a reference of its own, computed at a tight tolerance and checked by a second
!> method; the first model is the exact one. The numerical error of a run is the distance to the
!> reference of its own model, its error that to the reference of the exact model, and the distance
!> of the two references is the error of the model. docs/cost.md defines the distances.
module contensou_study_work_precision
   use contensou_base_errors, only : error_type
   use contensou_base_kinds, only : wp
   use contensou_base_rotations, only : unit_quaternion
   use contensou_base_operating_system, only : cpu_seconds
   use contensou_dynamics_scene, only : motion_spindle, moves_freely, scene_type
   use contensou_dynamics_state, only : body_size, position_of, quaternion_of, spin_of, velocity_of
   use contensou_integrate_integrator, only : statistics_type
   use contensou_integrate_observer, only : event_touch, observer_type
   use contensou_integrate_motion, only : motion_type
   use contensou_study_quantity, only : moment_type
   use contensou_study_simulation, only : new_simulation, simulate, simulation_options_type, &
      simulation_type
   implicit none(type, external)
   private

   public :: onlooker_type, distance_type, trial_type, reference_type, run_trial, run_reference, &
      reference_distance, reference_scales
   public :: outcome_done, outcome_failed, outcome_slow, outcome_stopped, kinds, measures

   !> Kinds of quantities of a trajectory: position, angle, velocity, angular velocity.
   integer, parameter :: kinds = 4

   !> Measures of their errors: at the end, largest, root mean square.
   integer, parameter :: measures = 3

   !> How a trial ended: at the end of time, in a failure, at its limit of CPU time, by a signal.
   integer, parameter :: outcome_done = 1, outcome_failed = 2, outcome_slow = 3, outcome_stopped = 4

   !> Distance of two motions.
   type :: distance_type
      !> Of each kind [m, rad, m/s, rad/s] in each measure, (measures, kinds).
      real(wp) :: value(measures, kinds) = 0.0_wp
      !> Largest distance of corresponding events [s]; 0 if there are none or they do not
      !> correspond.
      real(wp) :: events = 0.0_wp
      !> Whether the two have the same events in the same order, each contact by itself.
      logical :: same_events = .true.
   end type distance_type

   !> A motion that is kept.
   type :: reference_type
      logical :: known = .false.
      character(len=11) :: method = ""
      !> Relative tolerance [-].
      real(wp) :: rtol = 0.0_wp
      !> States of the bodies at the samples, (13 bodies, 0:samples).
      real(wp), allocatable :: y(:, :)
      integer :: n_events = 0
      !> Times of the events [s].
      real(wp), allocatable :: event_time(:)
      !> What they were: contact, negative for a lift-off.
      integer, allocatable :: event_code(:)
      !> Largest kinetic energy [J].
      real(wp) :: largest_kinetic = 0.0_wp
      !> Share of the time in which explicit8 was in use [-].
      real(wp) :: explicit_share = 0.0_wp
   end type reference_type

   !> A run of one model by one method at one tolerance.
   type :: trial_type
      !> One of the `outcome_*` codes.
      integer :: outcome = 0
      !> Why it failed.
      character(len=:), allocatable :: message
      !> Least CPU time [s].
      real(wp) :: cpu = huge(1.0_wp)
      !> Counters.
      type(statistics_type) :: statistics
      integer :: n_events = 0
      type(distance_type) :: own
      type(distance_type) :: total
      !> Largest residual of the energy balance [J].
      real(wp) :: energy = 0.0_wp
   end type trial_type

   !> Who looks on at a study; this one does nothing.
   type :: onlooker_type
   contains
      procedure :: stage
      procedure :: tell
      procedure :: stops
   end type onlooker_type

   !> Observer that measures distances or keeps the motion.
   type, extends(observer_type) :: gauge_type
      !> Motion that is kept, or the events of a run that is not.
      type(reference_type) :: kept
      !> Whether the states are kept.
      logical :: keep_states = .false.
      !> Number of the next sample.
      integer :: row = 0
      !> CPU time at which to give up [s].
      real(wp) :: deadline = huge(1.0_wp)
      !> Whether it was given up.
      logical :: late = .false.
      !> Whether the onlooker stopped it.
      logical :: interrupted = .false.
      class(onlooker_type), pointer :: onlooker => null()
      !> Steps since the clock was looked at.
      integer :: steps = 0
      !> Reference of the own model and of the exact one; not associated: none.
      type(reference_type), pointer :: own => null()
      !> Reference of the exact model.
      type(reference_type), pointer :: exact => null()
      !> Distances so far, with sums of squares in place of means.
      type(distance_type) :: distance(2)
      !> What is known of the motion at a sample.
      type(moment_type) :: moment
      !> Sum of energies and works at the beginning [J].
      real(wp) :: balance = 0.0_wp
      !> Largest residual [J].
      real(wp) :: energy = 0.0_wp
      !> Which bodies move freely.
      logical, allocatable :: free(:)
      !> Since when explicit8 is in use [s]; negative while it is not.
      real(wp) :: explicit_since = -1.0_wp
      !> Time in which it was in use before [s].
      real(wp) :: explicit_time = 0.0_wp
   contains
      procedure :: sample
      procedure :: change_method
      procedure :: event
      procedure :: after_step
   end type gauge_type

   !> Steps between two looks at the clock.
   integer, parameter :: steps_between = 256

contains

   !> A reference is begun; nobody is told unless an onlooker overrides this.
   subroutine stage(self, text)
      class(onlooker_type), intent(inout) :: self
      !> Which one.
      character(len=*), intent(in) :: text
   end subroutine stage

   !> A run is begun; nobody is told unless an onlooker overrides this.
   subroutine tell(self, share, run, runs, round, rounds)
      class(onlooker_type), intent(inout) :: self
      !> Share of the runs that are done.
      real(wp), intent(in) :: share
      integer, intent(in) :: run
      integer, intent(in) :: runs
      integer, intent(in) :: round
      integer, intent(in) :: rounds
   end subroutine tell

   !> Whether to stop; no unless an onlooker overrides this.
   logical function stops(self)
      class(onlooker_type), intent(in) :: self

      stops = .false.
   end function stops

   !> Compute a reference.
   subroutine run_reference(scene, method, rtol, deadline, onlooker, reference, trial)
      !> The scene with the model in question; a row is a sample.
      type(scene_type), intent(in) :: scene
      character(len=*), intent(in) :: method
      !> Relative tolerance [-].
      real(wp), intent(in) :: rtol
      !> CPU time that it may take [s].
      real(wp), intent(in) :: deadline
      class(onlooker_type), intent(inout), target :: onlooker
      !> The reference; known if it came to the end.
      type(reference_type), intent(out) :: reference
      type(trial_type), intent(inout) :: trial
      type(gauge_type) :: gauge

      gauge%keep_states = .true.
      gauge%onlooker => onlooker
      call run_gauge(scene, method, rtol, deadline, gauge, trial)
      reference = gauge%kept
      reference%method = method
      reference%rtol = rtol
      reference%known = trial%outcome == outcome_done
   end subroutine run_reference

   !> Run a trial: errors are those of this run, the CPU time is the least so far.
   subroutine run_trial(scene, method, rtol, deadline, own, exact, onlooker, trial)
      !> The scene with the model in question; a row is a sample.
      type(scene_type), intent(in) :: scene
      character(len=*), intent(in) :: method
      !> Relative tolerance [-].
      real(wp), intent(in) :: rtol
      !> CPU time that it may take [s].
      real(wp), intent(in) :: deadline
      !> Reference of this model.
      type(reference_type), intent(in), target :: own
      !> Reference of the exact model.
      type(reference_type), intent(in), target :: exact
      class(onlooker_type), intent(inout), target :: onlooker
      type(trial_type), intent(inout) :: trial
      type(gauge_type) :: gauge

      gauge%own => own
      gauge%exact => exact
      gauge%onlooker => onlooker
      call run_gauge(scene, method, rtol, deadline, gauge, trial)
      if (trial%outcome /= outcome_done) return
      call compare_events(gauge%kept, own, gauge%distance(1))
      call compare_events(gauge%kept, exact, gauge%distance(2))
      trial%own = gauge%distance(1)
      trial%total = gauge%distance(2)
   end subroutine run_trial

   !> March with a gauge, and measure the CPU time.
   subroutine run_gauge(scene, method, rtol, deadline, gauge, trial)
      !> The scene with the model in question; a row is a sample.
      type(scene_type), intent(in) :: scene
      character(len=*), intent(in) :: method
      !> Relative tolerance [-].
      real(wp), intent(in) :: rtol
      !> CPU time that it may take [s].
      real(wp), intent(in) :: deadline
      type(gauge_type), intent(inout) :: gauge
      type(trial_type), intent(inout) :: trial
      type(simulation_type) :: simulation
      type(simulation_options_type) :: options
      type(error_type), allocatable :: error
      integer :: samples, k

      samples = nint(scene%t_end/scene%output%interval)
      options%method = method
      options%rtol = rtol
      options%to_the_end = .true.
      options%one_method = .true.
      call new_simulation(scene, simulation, error, options)
      allocate(gauge%kept%event_time(64), gauge%kept%event_code(64))
      if (gauge%keep_states) allocate(gauge%kept%y(body_size*size(scene%bodies), 0:samples))
      gauge%free = moves_freely(scene%bodies%motion)
      if (simulation%choice%method == "explicit8") gauge%explicit_since = 0.0_wp
      gauge%deadline = cpu_seconds() + deadline
      if (.not. allocated(error)) call simulate(simulation, gauge, error)
      trial%statistics = simulation%memory%statistics
      trial%n_events = gauge%kept%n_events
      trial%energy = gauge%energy
      trial%cpu = min(trial%cpu, simulation%cpu)
      trial%outcome = outcome_done
      trial%message = ""
      if (allocated(error)) then
         trial%outcome = outcome_failed
         trial%message = simulation%failure
      else if (gauge%interrupted) then
         trial%outcome = outcome_stopped
      else if (simulation%stopped) then
         trial%outcome = outcome_slow
      end if
      do k = 1, 2
         call take_root(gauge%distance(k), samples, gauge%free)
      end do
      if (gauge%explicit_since >= 0.0_wp) call count_explicit(gauge, simulation%time())
      gauge%kept%explicit_share = gauge%explicit_time/scene%t_end
   end subroutine run_gauge

   !> Count the time in which explicit8 was in use up to now.
   pure subroutine count_explicit(gauge, t)
      type(gauge_type), intent(inout) :: gauge
      !> Now [s].
      real(wp), intent(in) :: t

      gauge%explicit_time = gauge%explicit_time + (t - gauge%explicit_since)
      gauge%explicit_since = -1.0_wp
   end subroutine count_explicit

   !> Turn the sums of squares of a distance into root mean squares.
   pure subroutine take_root(distance, samples, free)
      type(distance_type), intent(inout) :: distance
      !> Number of samples after the beginning.
      integer, intent(in) :: samples
      !> Which bodies move freely.
      logical, intent(in) :: free(:)

      distance%value(3, :) = sqrt(distance%value(3, :)/(real(samples, wp)*max(1, count(free))))
   end subroutine take_root

   !> Distance of two references.
   pure function reference_distance(a, b, scene) result(distance)
      type(reference_type), intent(in) :: a
      !> The other one.
      type(reference_type), intent(in) :: b
      type(scene_type), intent(in) :: scene
      type(distance_type) :: distance
      logical :: free(size(scene%bodies))
      integer :: j, samples

      samples = ubound(a%y, 2)
      free = moves_freely(scene%bodies%motion)
      do j = 0, samples
         call add_distance(free, a%y(:, j), b%y(:, j), j > 0, distance)
      end do
      call take_root(distance, samples, free)
      call compare_events(a, b, distance)
   end function reference_distance

   !> What the errors of a kind are compared with, from the reference of the exact model: the
   !> largest distance from the initial place [m], 1 rad, the largest speed [m/s], the largest
   !> angular velocity [rad/s], the end of time [s], the largest kinetic energy [J]. None is less
   !> than what the tolerance refers to: a ball that spins in its place moves by rounding errors.
   pure function reference_scales(reference, scene) result(scales)
      type(reference_type), intent(in) :: reference
      type(scene_type), intent(in) :: scene
      real(wp) :: scales(kinds + 2)
      integer :: i, j

      associate (least => scene%integrator)
         scales = [least%length_scale, 1.0_wp, least%velocity_scale, &
            least%angular_velocity_scale, scene%t_end, 0.5_wp*least%velocity_scale**2* &
            sum(scene%bodies%mass, mask=moves_freely(scene%bodies%motion))]
      end associate
      do i = 1, size(scene%bodies)
         if (.not. moves_freely(scene%bodies(i)%motion)) cycle
         do j = lbound(reference%y, 2), ubound(reference%y, 2)
            associate (y => reference%y(:, j), y0 => reference%y(:, 0))
               scales(1) = max(scales(1), norm2(position_of(y, i) - position_of(y0, i)))
               scales(3) = max(scales(3), norm2(velocity_of(y, i)))
               ! A drive turns a spindle, without an error.
               if (scene%bodies(i)%motion /= motion_spindle) scales(4) = max(scales(4), &
                  norm2(spin_of(y, i)))
            end associate
         end do
      end do
      scales(kinds + 2) = max(scales(kinds + 2), reference%largest_kinetic)
      ! Where all bodies are driven and at rest there is no energy.
      where (scales <= 0.0_wp) scales = 1.0_wp
   end function reference_scales

   !> A row is due.
   subroutine sample(self, motion, t, y, error)
      class(gauge_type), intent(inout) :: self
      class(motion_type), intent(inout) :: motion
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)
      type(error_type), allocatable, intent(out) :: error
      integer :: n

      n = body_size*size(motion%system%bodies)
      call take_energy(self, motion, t, y, error)
      if (allocated(error)) return
      if (self%keep_states) self%kept%y(:, self%row) = y(:n)
      if (associated(self%own)) call add_distance(self%free, y, self%own%y(:, self%row), &
         self%row > 0, self%distance(1))
      if (associated(self%exact)) call add_distance(self%free, y, self%exact%y(:, self%row), &
         self%row > 0, self%distance(2))
      self%row = self%row + 1
   end subroutine sample

   !> Residual of the energy balance.
   subroutine take_energy(self, motion, t, y, error)
      type(gauge_type), intent(inout) :: self
      class(motion_type), intent(inout) :: motion
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)
      type(error_type), allocatable, intent(out) :: error

      associate (now => self%moment)
         call now%look(motion%system, t, y, error)
         if (allocated(error)) return
         self%kept%largest_kinetic = max(self%kept%largest_kinetic, now%kinetic)
         if (self%row == 0) self%balance = now%balance()
         self%energy = max(self%energy, abs(now%balance() - self%balance))
      end associate
   end subroutine take_energy

   !> Add a sample to a distance.
   pure subroutine add_distance(free, y, reference, counts, distance)
      !> Which bodies move freely.
      logical, intent(in) :: free(:)
      real(wp), intent(in) :: y(:)
      !> State of the reference at the same time.
      real(wp), intent(in) :: reference(:)
      !> Whether it counts for the mean: the beginning does not.
      logical, intent(in) :: counts
      type(distance_type), intent(inout) :: distance
      real(wp) :: d(kinds), p(4), q(4)
      integer :: i

      distance%value(1, :) = 0.0_wp
      do i = 1, size(free)
         if (.not. free(i)) cycle
         p = unit_quaternion(quaternion_of(y, i))
         q = unit_quaternion(quaternion_of(reference, i))
         d(1) = norm2(position_of(y, i) - position_of(reference, i))
         ! Angle of the rotation between two attitudes; q and -q are the same one.
         d(2) = 4.0_wp*asin(min(1.0_wp, 0.5_wp*min(norm2(p - q), norm2(p + q))))
         d(3) = norm2(velocity_of(y, i) - velocity_of(reference, i))
         d(4) = norm2(spin_of(y, i) - spin_of(reference, i))
         distance%value(1, :) = max(distance%value(1, :), d)
         distance%value(2, :) = max(distance%value(2, :), d)
         if (counts) distance%value(3, :) = distance%value(3, :) + d**2
      end do
   end subroutine add_distance

   !> Events of two motions, contact by contact.
   pure subroutine compare_events(a, b, distance)
      type(reference_type), intent(in) :: a
      !> The other one.
      type(reference_type), intent(in) :: b
      type(distance_type), intent(inout) :: distance
      logical :: taken(b%n_events)
      integer :: i, j

      distance%events = 0.0_wp
      distance%same_events = a%n_events == b%n_events
      if (.not. distance%same_events) return
      taken = .false.
      do i = 1, a%n_events
         ! The first one of that contact that is left must be of the same kind.
         do j = 1, b%n_events
            if (.not. taken(j) .and. abs(a%event_code(i)) == abs(b%event_code(j))) exit
         end do
         if (j <= b%n_events) then
            if (a%event_code(i) == b%event_code(j)) then
               taken(j) = .true.
               distance%events = max(distance%events, abs(a%event_time(i) - b%event_time(j)))
               cycle
            end if
         end if
         distance%same_events = .false.
         distance%events = 0.0_wp
         return
      end do
   end subroutine compare_events

   !> `auto` goes on with another method.
   subroutine change_method(self, t, method, reason)
      class(gauge_type), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      character(len=*), intent(in) :: method
      !> Not needed.
      character(len=*), intent(in) :: reason

      if (self%explicit_since >= 0.0_wp) call count_explicit(self, t)
      if (method == "explicit8") self%explicit_since = t
   end subroutine change_method

   !> A contact touched or lifted off.
   subroutine event(self, t, kind, contact, error)
      class(gauge_type), intent(inout) :: self
      real(wp), intent(in) :: t
      integer, intent(in) :: kind
      integer, intent(in) :: contact
      type(error_type), allocatable, intent(out) :: error
      real(wp), allocatable :: times(:)
      integer, allocatable :: codes(:)

      associate (n => self%kept%n_events)
         if (n == size(self%kept%event_time)) then
            allocate(times(2*n), codes(2*n))
            times(:n) = self%kept%event_time
            codes(:n) = self%kept%event_code
            call move_alloc(times, self%kept%event_time)
            call move_alloc(codes, self%kept%event_code)
         end if
         n = n + 1
         self%kept%event_time(n) = t
         self%kept%event_code(n) = merge(contact, -contact, kind == event_touch)
      end associate
   end subroutine event

   !> A step is done.
   subroutine after_step(self, t, stop_now, error)
      class(gauge_type), intent(inout) :: self
      real(wp), intent(in) :: t
      logical, intent(out) :: stop_now
      type(error_type), allocatable, intent(out) :: error

      self%interrupted = self%onlooker%stops()
      stop_now = self%interrupted
      self%steps = self%steps + 1
      if (self%steps < steps_between) return
      self%steps = 0
      self%late = cpu_seconds() > self%deadline
      stop_now = stop_now .or. self%late
   end subroutine after_step

end module contensou_study_work_precision
