!> Tests of the integrators on problems with a known solution, and of the march with its rows and
!> events.
module test_integrate
   use contensou_base_errors, only : error_type, fatal, status_failed
   use contensou_base_kinds, only : i8, pi, wp
   use contensou_contact_damping_coefficient, only : coefficient_damping_type, tsuji_factor
   use contensou_dynamics_scene, only : scene_type
   use contensou_integrate_cvode, only : sundials_version
   use contensou_integrate_integrator, only : integrator_type, statistics_type
   use contensou_integrate_memory, only : row_count
   use contensou_integrate_methods, only : integrator_methods, new_integrator
   use contensou_integrate_observer, only : event_lift, event_touch, observer_type
   use contensou_integrate_motion, only : motion_type
   use contensou_integrate_problem, only : problem_type
   use contensou_study_simulation, only : new_simulation, simulate, simulation_options_type, &
      simulation_type
   use test_contact, only : impact_coefficient, new_damping, rebound
   use test_harness, only : check, check_close, worst_type
   use test_scenes, only : ball, damping_index, friction_index, set_motion
   implicit none(type, external)
   private

   public :: run_integrate_tests

   !> What is wrong with the oscillator: nothing.
   integer, parameter :: sound = 0

   !> Its state is never in the domain.
   integer, parameter :: never_inside = 1

   !> Its state leaves the domain.
   integer, parameter :: leaves = 2

   !> Its solution grows beyond all bounds at t = 1.
   integer, parameter :: blows_up = 3

   !> More accuracy is asked for than there is.
   integer, parameter :: too_accurate = 4

   !> Largest number of rows that are kept.
   integer, parameter :: max_rows = 9000

   !> Largest number of events that are kept.
   integer, parameter :: max_events = 200

   !> y1' = y2, y2' = -4 pi^2 y1, the events are the zeros of y1 and of y1 - 1/2.
   type, extends(problem_type) :: oscillator_type
      !> What is wrong, one of the codes above.
      integer :: defect = sound
      !> Admissible error.
      real(wp) :: tolerance = 1.0e-10_wp
      !> Evaluations of the right-hand side.
      integer :: evaluations = 0
   contains
      procedure :: derivative
      procedure :: events
      procedure :: admissible_error
   end type oscillator_type

   !> Keeps what it is shown.
   type, extends(observer_type) :: recorder_type
      !> Number of rows.
      integer :: n_rows = 0
      !> Number of events.
      integer :: n_events = 0
      !> Number of steps.
      integer :: n_steps = 0
      !> Times of the rows [s].
      real(wp), allocatable :: t_row(:)
      !> Heights of the first body [m].
      real(wp), allocatable :: height(:)
      !> Vertical velocity of the first body [m/s].
      real(wp), allocatable :: velocity(:)
      !> Times of the events [s].
      real(wp), allocatable :: t_event(:)
      !> Kinds of the events.
      integer, allocatable :: kind(:)
      !> Contacts of the events.
      integer, allocatable :: contact(:)
      !> Step after which to stop; 0 for none.
      integer :: stop_after = 0
      !> Time after which to stop [s].
      real(wp) :: stop_at = huge(1.0_wp)
      !> Row at which to fail; 0 for none.
      integer :: fail_at_row = 0
      !> Event at which to fail; 0 for none.
      integer :: fail_at_event = 0
   contains
      !> Forget what was shown before.
      procedure :: clear
      procedure :: sample
      procedure :: event
      procedure :: after_step
   end type recorder_type

contains

   !> Run all tests.
   subroutine run_integrate_tests()
      integer :: i

      do i = 1, size(integrator_methods)
         call test_oscillator(trim(integrator_methods(i)))
         call test_known_side(trim(integrator_methods(i)))
         call test_failures(trim(integrator_methods(i)))
         call test_free_fall(trim(integrator_methods(i)))
         call test_bouncing(trim(integrator_methods(i)))
         call test_restitution(trim(integrator_methods(i)))
         call test_dip(trim(integrator_methods(i)))
         call test_deep(trim(integrator_methods(i)))
         call test_missed(trim(integrator_methods(i)))
         call test_given_back(trim(integrator_methods(i)))
      end do
      call test_row_count()
      call test_rows()
      call test_stop()
      call test_resting()
      call test_thrown_up()
      call test_touching_at_start()
      call test_short_contact()
      call test_tsuji()
      call check(len(sundials_version()) >= 3, "sundials_version")
   end subroutine run_integrate_tests

   !> Right-hand side of the oscillator.
   subroutine derivative(self, t, y, rate, outside)
      !> The problem.
      class(oscillator_type), intent(inout) :: self
      !> Time.
      real(wp), intent(in) :: t
      !> Unknowns.
      real(wp), intent(in) :: y(self%n)
      !> Their rates.
      real(wp), intent(out) :: rate(self%n)
      !> Whether the state is outside the domain.
      logical, intent(out) :: outside

      self%evaluations = self%evaluations + 1
      rate(1) = y(2)
      rate(2) = -4.0_wp*pi**2*y(1)
      if (self%defect == blows_up) rate = y**2
      outside = self%defect == never_inside .or. (self%defect == leaves .and. y(1) < 0.3_wp)
   end subroutine derivative

   !> Event functions of the oscillator.
   subroutine events(self, t, y, g)
      !> The problem.
      class(oscillator_type), intent(inout) :: self
      !> Time.
      real(wp), intent(in) :: t
      !> Unknowns.
      real(wp), intent(in) :: y(:)
      !> Values.
      real(wp), intent(out) :: g(:)

      g(1) = y(1)
      g(2) = y(1) - 0.5_wp
   end subroutine events

   !> Admissible error of the oscillator.
   subroutine admissible_error(self, y, size_of_error)
      !> The problem.
      class(oscillator_type), intent(in) :: self
      !> Unknowns.
      real(wp), intent(in) :: y(:)
      !> Admissible error.
      real(wp), intent(out) :: size_of_error(:)

      size_of_error = self%tolerance
      if (self%defect == too_accurate) size_of_error = 1.0e-20_wp
   end subroutine admissible_error

   !> Forget what was shown before.
   subroutine clear(self)
      class(recorder_type), intent(inout) :: self

      if (.not. allocated(self%t_row)) then
         allocate(self%t_row(0:max_rows), self%height(0:max_rows), self%velocity(0:max_rows))
         allocate(self%t_event(max_events), self%kind(max_events), self%contact(max_events))
      end if
      self%n_rows = 0
      self%n_events = 0
      self%n_steps = 0
      self%t_row = 0.0_wp
      self%height = 0.0_wp
      self%velocity = 0.0_wp
      self%t_event = 0.0_wp
      self%kind = 0
      self%contact = 0
   end subroutine clear

   !> Take a row.
   subroutine sample(self, motion, t, y, error)
      class(recorder_type), intent(inout) :: self
      class(motion_type), intent(inout) :: motion
      !> Time [s].
      real(wp), intent(in) :: t
      !> State.
      real(wp), intent(in) :: y(:)
      !> Set to end the march.
      type(error_type), allocatable, intent(out) :: error

      self%n_rows = self%n_rows + 1
      self%t_row(self%n_rows - 1) = t
      self%height(self%n_rows - 1) = y(3)
      self%velocity(self%n_rows - 1) = y(10)
      if (self%n_rows == self%fail_at_row) call fatal(error, "this row is too much")
   end subroutine sample

   !> Take an event.
   subroutine event(self, t, kind, contact, error)
      class(recorder_type), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> `event_touch` or `event_lift`.
      integer, intent(in) :: kind
      !> Index of the contact.
      integer, intent(in) :: contact
      !> Set to end the march.
      type(error_type), allocatable, intent(out) :: error

      self%n_events = self%n_events + 1
      if (self%n_events <= max_events) then
         self%t_event(self%n_events) = t
         self%kind(self%n_events) = kind
         self%contact(self%n_events) = contact
      end if
      if (self%n_events == self%fail_at_event) call fatal(error, "this event is too much")
   end subroutine event

   !> A step is done.
   subroutine after_step(self, t, stop_now, error)
      class(recorder_type), intent(inout) :: self
      !> Time reached [s].
      real(wp), intent(in) :: t
      !> Whether to stop here.
      logical, intent(out) :: stop_now
      !> Set to end the march.
      type(error_type), allocatable, intent(out) :: error

      self%n_steps = self%n_steps + 1
      stop_now = self%n_steps == self%stop_after .or. t >= self%stop_at
      if (t < 0.0_wp) call fatal(error, "time runs back")
   end subroutine after_step

   !> What is known to be below zero where an integration begins, and hardly is, rises through it;
   !> what is not counts as zero, on neither side.
   subroutine test_known_side(method)
      character(len=*), intent(in) :: method
      type(oscillator_type), target :: problem
      class(integrator_type), allocatable :: integrator
      type(error_type), allocatable :: error
      real(wp) :: t, y(2)
      integer :: found(2), known, side

      problem%n = 2
      problem%n_events = 2
      problem%remembers = .true.
      problem%rounding = 1.0e-6_wp
      do known = 0, 1
         side = 0
         problem%side = -[known, 1]
         t = 0.0_wp
         y = [-1.0e-16_wp, 1.0_wp]
         call new_integrator(method, integrator)
         call integrator%start(problem, method, t, y, 1.0_wp, 0.0_wp, error)
         do while (t < 0.02_wp .and. .not. allocated(error) .and. side == 0)
            call integrator%step(t, y, found, error)
            side = found(1)
         end do
         call check(side == known .and. .not. allocated(error), method &
            // ": an event at the beginning" // trim(merge(", of a known side", &
            "                 ", known == 1)))
         call integrator%free()
         deallocate(integrator)
      end do
   end subroutine test_known_side

   !> An oscillator: solution, events, interpolation, restart, counters.
   subroutine test_oscillator(method)
      character(len=*), intent(in) :: method
      type(oscillator_type), target :: problem
      class(integrator_type), allocatable :: integrator
      type(error_type), allocatable :: error
      type(statistics_type) :: first, second
      type(worst_type) :: solution, between, timing, ahead
      real(wp) :: t, t_before, y(2), middle(2), due
      real(wp), parameter :: t_end = 5.1_wp
      integer :: found(2), rising, falling, half, n, signs
      logical :: right_sign

      problem%n = 2
      problem%n_events = 2
      t = 0.0_wp
      y = [1.0_wp, 0.0_wp]
      call new_integrator(method, integrator)
      call integrator%start(problem, method, t, y, t_end, 0.0_wp, error)
      call check(.not. allocated(error), method // ": starts")
      rising = 0
      falling = 0
      half = 0
      n = 0
      signs = 0
      right_sign = .true.
      do while (t < t_end .and. n < 100000)
         t_before = t
         call integrator%step(t, y, found, error)
         if (allocated(error)) exit
         n = n + 1
         call ahead%note(t - t_end, n)
         call solution%note(abs(y(1) - cos(2.0_wp*pi*t)), n)
         call integrator%interpolate(0.5_wp*(t_before + t), middle)
         call between%note(abs(middle(1) - cos(pi*(t_before + t))), n)
         if (found(1) /= 0) then
            if (found(1) > 0) rising = rising + 1
            if (found(1) < 0) falling = falling + 1
            ! Zeros of the cosine at 1/4 + n/2, falling first.
            due = 0.25_wp + 0.5_wp*(rising + falling - 1)
            call timing%note(abs(t - due), n)
            right_sign = right_sign .and. (modulo(rising + falling, 2) == 1 .eqv. found(1) < 0)
         end if
         if (found(2) /= 0) then
            half = half + 1
            due = half/2 + merge(1.0_wp, -1.0_wp, modulo(half, 2) == 1)/6.0_wp
            call timing%note(abs(t - due), n)
            right_sign = right_sign .and. (modulo(half, 2) == 1 .eqv. found(2) < 0)
         end if
      end do
      call check(.not. allocated(error), method // ": integrates")
      call check_close(t, t_end, 0.0_wp, method // ": ends at the end")
      call ahead%check_below(0.0_wp, method // ": never beyond the end")
      call solution%check_below(1.0e-6_wp, method // ": solution of the oscillator")
      call between%check_below(1.0e-6_wp, method // ": interpolation within the step")
      call check(rising == 5 .and. falling == 5 .and. half == 10, method // ": all events once")
      call timing%check_below(1.0e-6_wp, method // ": times of the events")
      call check(right_sign, method // ": signs of the events")

      first = integrator%statistics()
      call check(first%steps >= n - 20 .and. first%steps <= n .and. &
         n > merge(40, 100, method == "explicit8"), method // ": counts its steps")
      call check(first%derivatives == problem%evaluations, method // ": counts the derivatives")
      ! Without a choice from a motion, auto is cvode_bdf.
      call check((first%jacobians > 0) .eqv. (method == "cvode_bdf" .or. method == "auto"), &
         method // ": counts Jacobians")
      call check(first%last_step > 0.0_wp .and. first%last_step < 1.0_wp, method // ": last step")
      call check(first%error_test_failures >= 0 .and. first%convergence_failures >= 0, &
         method // ": failures")

      t = 4.0_wp
      y = [0.0_wp, 2.0_wp*pi]
      call integrator%restart(t, y, error)
      call check(.not. allocated(error), method // ": restarts")
      do while (t < t_end)
         call integrator%step(t, y, found, error)
         if (allocated(error)) exit
      end do
      call check(.not. allocated(error), method // ": integrates again")
      call check_close(y(1), sin(2.0_wp*pi*1.1_wp), 1.0e-6_wp, method // ": solution after restart")
      second = integrator%statistics()
      call check(second%steps > first%steps + 10 .and. second%derivatives == problem%evaluations, &
         method // ": counts on after a restart")
      call integrator%free()
      second = integrator%statistics()
      call check(second%steps == 0, method // ": nothing counted after the end")
      call integrator%free()
      call check(.true., method // ": can be freed twice")

      ! A bound of the step.
      t = 0.0_wp
      y = [1.0_wp, 0.0_wp]
      problem%tolerance = 1.0e-2_wp
      call integrator%start(problem, method, t, y, 1.0_wp, 1.0e-3_wp, error)
      due = 0.0_wp
      n = 0
      do while (t < 1.0_wp .and. .not. allocated(error))
         t_before = t
         call integrator%step(t, y, found, error)
         due = max(due, t - t_before)
         n = n + 1
      end do
      call check(due <= 1.0001e-3_wp .and. n >= 1000, method // ": largest step")
      call integrator%free()
   end subroutine test_oscillator

   !> Problems that cannot be integrated end with a message.
   subroutine test_failures(method)
      character(len=*), intent(in) :: method

      call expect(never_inside, "the state it starts from is outside the domain of the model", &
         method // ": never inside the domain")
      call expect(leaves, "", method // ": leaves the domain")
      call expect(blows_up, "", method // ": grows beyond all bounds")
      call expect(too_accurate, "the tolerance is below what double precision can resolve", &
         method // ": too much accuracy")

   contains

      !> Check that a problem ends with a message.
      subroutine expect(defect, part, name)
         !> What is wrong with the problem.
         integer, intent(in) :: defect
         !> Part of the message.
         character(len=*), intent(in) :: part
         !> What is checked.
         character(len=*), intent(in) :: name
         type(oscillator_type), target :: problem
         class(integrator_type), allocatable :: integrator
         type(error_type), allocatable :: error
         real(wp) :: t, y(2)
         integer :: found(2), i

         problem%n = 2
         problem%n_events = 2
         problem%defect = defect
         t = 0.0_wp
         y = [1.0_wp, 0.0_wp]
         call new_integrator(method, integrator)
         call integrator%start(problem, method, t, y, 2.0_wp, 0.0_wp, error)
         do i = 1, 100000
            if (allocated(error)) exit
            call integrator%step(t, y, found, error)
         end do
         call check(allocated(error), name // " is an error")
         if (allocated(error)) then
            call check(error%status == status_failed .and. len(error%message) > 10 .and. &
               index(error%message, part) > 0, name // " says: " // error%message)
         end if
         call check(t < 1.01_wp, name // ": not beyond that time")
         call integrator%free()
      end subroutine expect

   end subroutine test_failures

   !> March a scene.
   subroutine run(scene, recorder, interval, error, stopped, statistics, t_reached)
      type(scene_type), intent(inout) :: scene
      !> Who looks on.
      type(recorder_type), intent(inout) :: recorder
      !> Interval of the rows [s].
      real(wp), intent(in) :: interval
      !> Set when the march failed.
      type(error_type), allocatable, intent(out) :: error
      !> Whether it was stopped.
      logical, intent(out), optional :: stopped
      !> Counters.
      type(statistics_type), intent(out), optional :: statistics
      !> Time reached [s].
      real(wp), intent(out), optional :: t_reached
      type(simulation_type) :: simulation
      type(simulation_options_type) :: options

      call recorder%clear()
      options%interval = interval
      call new_simulation(scene, simulation, error, options)
      if (.not. allocated(error)) call simulate(simulation, recorder, error)
      if (allocated(simulation%failure)) error%message = simulation%failure
      if (present(stopped)) stopped = simulation%stopped
      if (present(statistics)) statistics = simulation%memory%statistics
      if (present(t_reached)) t_reached = simulation%time()
   end subroutine run

   !> Number of rows.
   subroutine test_row_count()
      call check(row_count(1.0_wp, 0.1_wp) == 10_i8, "row_count: a multiple")
      call check(row_count(1.0_wp, 0.3_wp) == 4_i8, "row_count: the end counts")
      call check(row_count(8.0_wp, 1.0e-3_wp) == 8000_i8, "row_count: a multiple but for rounding")
      call check(row_count(0.3_wp, 0.1_wp) == 3_i8, "row_count: rounded up")
      call check(row_count(2.1_wp, 0.3_wp) == 7_i8, "row_count: rounded down")
      call check(row_count(1.0_wp, 5.0_wp) == 1_i8, "row_count: interval beyond the end")
      call check(row_count(1.0_wp, 1.0e-9_wp) == 1000000000_i8, "row_count: very many")
   end subroutine test_row_count

   !> Rows at the multiples of the interval and at the end, each once.
   subroutine test_rows()
      type(scene_type) :: scene
      type(recorder_type) :: recorder
      type(error_type), allocatable :: error
      real(wp), parameter :: intervals(*) = [0.1_wp, 0.3_wp, 1.0e-3_wp, 0.7_wp, 1.0_wp, 5.0_wp]
      real(wp) :: expected
      logical :: good
      integer :: i, k, rows

      do i = 1, size(intervals)
         call ball(scene, 1.0e-2_wp)
         scene%gravity = [0.0_wp, 0.0_wp, -9.81_wp]
         scene%bodies(1)%velocity = [0.0_wp, 0.0_wp, 1.0_wp]
         scene%t_end = 0.7_wp
         call run(scene, recorder, intervals(i), error)
         rows = nint(0.7_wp/intervals(i) + 0.49_wp)
         good = .not. allocated(error) .and. recorder%n_rows == rows + 1
         do k = 0, min(rows, recorder%n_rows - 1)
            expected = min(k*intervals(i), 0.7_wp)
            if (k == rows) expected = 0.7_wp
            good = good .and. abs(recorder%t_row(k) - expected) <= 0.0_wp
         end do
         call check(good, "rows at the multiples of the interval and at the end")
      end do
      recorder%fail_at_row = 5
      call run(scene, recorder, 1.0e-3_wp, error)
      call check(allocated(error) .and. recorder%n_rows == 5, "a row that fails ends the march")
      if (allocated(error)) call check(error%message == "this row is too much", &
         "a row that fails says why")
   end subroutine test_rows

   !> Without a contact the rows are those of free flight.
   subroutine test_free_fall(method)
      character(len=*), intent(in) :: method
      type(scene_type) :: scene
      type(recorder_type) :: recorder
      type(error_type), allocatable :: error
      type(worst_type) :: height
      type(statistics_type) :: statistics
      real(wp) :: t
      integer :: k

      call ball(scene, 10.0_wp)
      scene%gravity = [0.0_wp, 0.0_wp, -9.81_wp]
      scene%integrator%method = method
      scene%bodies(1)%spin = [1.0_wp, 20.0_wp, 3.0_wp]
      scene%t_end = 1.0_wp
      call run(scene, recorder, 0.01_wp, error, statistics=statistics, t_reached=t)
      do k = 0, recorder%n_rows - 1
         call height%note(abs(recorder%height(k) - 10.02_wp + 4.905_wp*recorder%t_row(k)**2), k + 1)
      end do
      call check(.not. allocated(error) .and. recorder%n_rows == 101, method // ": free fall")
      call height%check_below(1.0e-9_wp, method // ": rows of free fall")
      call check(recorder%n_events == 0, method // ": no events in free fall")
      call check(recorder%n_steps <= statistics%steps .and. statistics%steps > 0, &
         method // ": the observer sees each step")
      call check_close(t, 1.0_wp, 0.0_wp, method // ": ends at the end of time")
   end subroutine test_free_fall

   !> An elastic ball on the ground against the closed form: flights of 2 v/g, an impact that takes
   !> 2.9432752 (m^2/(k^2 v))^(1/5) (25/16)^(1/5).
   subroutine test_bouncing(method)
      character(len=*), intent(in) :: method
      type(scene_type) :: scene
      type(motion_type) :: motion
      type(recorder_type) :: recorder
      type(error_type), allocatable :: error
      real(wp), allocatable :: y(:)
      real(wp), parameter :: g = 9.81_wp, height = 0.1_wp
      real(wp) :: v, duration
      logical :: good
      integer :: i

      call ball(scene, height)
      scene%gravity = [0.0_wp, 0.0_wp, -g]
      scene%t_end = 1.5_wp
      scene%integrator%method = method
      call run(scene, recorder, 0.01_wp, error)
      call check(.not. allocated(error), method // ": a bouncing ball")
      v = sqrt(2.0_wp*g*height)
      call check(recorder%n_events == 10, method // ": bouncing ball: five impacts")
      good = .true.
      do i = 1, recorder%n_events
         good = good .and. recorder%contact(i) == 1 .and. recorder%kind(i) == merge(event_touch, &
            event_lift, modulo(i, 2) == 1)
      end do
      call check(good, method // ": bouncing ball: touch and lift in turns")
      call check_close(recorder%t_event(1), v/g, 1.0e-9_wp, &
         method // ": bouncing ball: first touch")
      call set_motion(scene, motion, y)
      ! Without gravity; the weight makes it longer by about 1e-4 of itself.
      duration = 2.9432752_wp*(25.0_wp/16.0_wp)**0.2_wp*(scene%bodies(1)%mass**2 &
         /(motion%system%contacts(1)%law%normal%stiffness**2*v))**0.2_wp
      do i = 1, 4
         call check_close(recorder%t_event(2*i) - recorder%t_event(2*i - 1), duration, &
            1.0e-3_wp*duration, method // ": bouncing ball: duration of an impact")
         call check_close(recorder%t_event(2*i + 1) - recorder%t_event(2*i), 2.0_wp*v/g, &
            1.0e-6_wp, method // ": bouncing ball: duration of a flight")
      end do
      recorder%fail_at_event = 3
      call run(scene, recorder, 0.01_wp, error)
      call check(allocated(error) .and. recorder%n_events == 3, &
         method // ": an event that fails ends the march")
   end subroutine test_bouncing

   !> A march that takes a ball in flight to touch, or one that touches to fly, as it would after an
   !> event that it missed, ends at the next event; one that knows does not.
   subroutine test_missed(method)
      character(len=*), intent(in) :: method
      type(scene_type) :: scene
      type(simulation_type) :: simulation
      type(recorder_type) :: recorder
      type(error_type), allocatable :: error
      real(wp) :: middle
      integer :: touches, wrong
      logical :: told

      call ball(scene, 0.1_wp)
      scene%gravity = [0.0_wp, 0.0_wp, -9.81_wp]
      scene%t_end = 0.4_wp
      scene%integrator%method = method
      call run(scene, recorder, 0.01_wp, error)
      middle = 0.5_wp*(recorder%t_event(1) + recorder%t_event(2))
      do touches = 0, 1
         do wrong = 0, 1
            call recorder%clear()
            recorder%stop_at = merge(middle, 0.1_wp, touches == 1)
            call new_simulation(scene, simulation, error)
            if (.not. allocated(error)) call simulate(simulation, recorder, error)
            call check(.not. allocated(error) .and. simulation%stopped .and. &
               (simulation%memory%closed(1) .eqv. touches == 1), method // &
               ": before an event that is missed")
            recorder%stop_at = huge(middle)
            if (wrong == 1) simulation%memory%closed = .not. simulation%memory%closed
            if (.not. allocated(error)) call simulate(simulation, recorder, error)
            told = .false.
            if (allocated(error)) told = index(error%message, "was missed") > 0
            call check(merge(told, .not. allocated(error), wrong == 1), method // &
               merge(": a lift-off", ": a touch   ", touches == 0) // &
               merge(" that was missed", " that is known  ", wrong == 1))
         end do
      end do
   end subroutine test_missed

   !> A march in which less is lost in friction than before ends with a message, one in which that
   !> is a millionth of the energy does not.
   subroutine test_given_back(method)
      character(len=*), intent(in) :: method
      type(scene_type) :: scene
      type(simulation_type) :: simulation
      type(recorder_type) :: recorder
      type(error_type), allocatable :: error
      real(wp), parameter :: share(2) = [1.0e-6_wp, 1.0e-2_wp]
      logical :: told
      integer :: i

      call ball(scene, 0.1_wp)
      scene%gravity = [0.0_wp, 0.0_wp, -9.81_wp]
      scene%t_end = 0.4_wp
      scene%integrator%method = method
      do i = 1, size(share)
         call recorder%clear()
         recorder%stop_at = 0.2_wp
         call new_simulation(scene, simulation, error)
         if (.not. allocated(error)) call simulate(simulation, recorder, error)
         call check(.not. allocated(error) .and. simulation%stopped, method // ": with friction")
         recorder%stop_at = huge(scene%t_end)
         associate (memory => simulation%memory)
            memory%lost = memory%lost + share(i)*memory%energy_moved
         end associate
         if (.not. allocated(error)) call simulate(simulation, recorder, error)
         told = .false.
         if (allocated(error)) told = index(error%message, "friction has given back") > 0
         call check(told .eqv. i == 2, method // ": friction that gives back")
      end do
   end subroutine test_given_back

   !> The observer can stop the march after any step.
   subroutine test_stop()
      type(scene_type) :: scene
      type(recorder_type) :: recorder
      type(error_type), allocatable :: error
      type(statistics_type) :: statistics
      real(wp) :: t
      logical :: stopped

      call ball(scene, 0.1_wp)
      scene%gravity = [0.0_wp, 0.0_wp, -9.81_wp]
      recorder%stop_after = 30
      call run(scene, recorder, 1.0e-3_wp, error, stopped, statistics, t)
      call check(.not. allocated(error) .and. stopped, "stop: asked for")
      call check(recorder%n_steps == 30 .and. t > 0.0_wp .and. t < 1.0_wp, "stop: after that step")
      associate (last => recorder%t_row(recorder%n_rows - 1))
         call check(last <= t .and. last > t - 1.0e-3_wp, "stop: the rows up to then are there")
      end associate
      call check(statistics%steps > 0, "stop: steps are counted")
      recorder%stop_after = 0
      call run(scene, recorder, 1.0e-3_wp, error, stopped)
      call check(.not. stopped, "stop: not asked for")
   end subroutine test_stop

   !> A ball whose gap is zero at the start and that sinks in does not touch again.
   subroutine test_resting()
      type(scene_type) :: scene
      type(recorder_type) :: recorder
      type(error_type), allocatable :: error
      real(wp), parameter :: offsets(*) = [0.0_wp, 1.0e-17_wp, -1.0e-17_wp]
      integer :: i

      do i = 1, size(offsets)
         call ball(scene, offsets(i))
         scene%gravity = [0.0_wp, 0.0_wp, -9.81_wp]
         scene%t_end = 0.02_wp
         scene%contacts(1)%damping = damping_index("hunt_crossley")
         call scene%contacts(1)%parameters%set("damping_coefficient", 1.0e4_wp)
         call run(scene, recorder, 1.0e-3_wp, error)
         call check(.not. allocated(error), "gap zero at the start: runs")
         call check(recorder%n_events == 0, "gap zero at the start: no event")
         call check(recorder%height(recorder%n_rows - 1) < 0.02_wp, &
            "gap zero at the start: sinks in")
      end do
   end subroutine test_resting

   !> A ball thrown up from the floor: its first event is the touch when it comes back.
   subroutine test_thrown_up()
      type(scene_type) :: scene
      type(recorder_type) :: recorder
      type(error_type), allocatable :: error
      real(wp), parameter :: offsets(*) = [0.0_wp, 1.0e-17_wp, -1.0e-17_wp]
      integer :: i

      do i = 1, size(offsets)
         call ball(scene, offsets(i))
         scene%gravity = [0.0_wp, 0.0_wp, -9.81_wp]
         scene%bodies(1)%velocity = [0.0_wp, 0.0_wp, 0.981_wp]
         scene%t_end = 0.3_wp
         call run(scene, recorder, 1.0e-3_wp, error)
         call check(.not. allocated(error), "thrown up: runs")
         call check(recorder%n_events == 2 .and. recorder%kind(1) == event_touch .and. &
            recorder%kind(2) == event_lift, "thrown up: touches when it comes back")
         call check_close(recorder%t_event(1), 0.2_wp, 1.0e-9_wp, "thrown up: time of the touch")
      end do
   end subroutine test_thrown_up

   !> A ball that begins on the floor with a velocity into it: an impact without a touch event, and
   !> with the restitution of that speed.
   subroutine test_touching_at_start()
      type(scene_type) :: scene
      type(recorder_type) :: recorder
      type(error_type), allocatable :: error

      call ball(scene, 0.0_wp)
      scene%bodies(1)%velocity = [0.0_wp, 0.0_wp, -0.5_wp]
      scene%contacts(1)%damping = damping_index("hunt_crossley")
      call scene%contacts(1)%parameters%set("restitution", 0.6_wp)
      scene%t_end = 0.01_wp
      call run(scene, recorder, 1.0e-3_wp, error)
      call check(.not. allocated(error), "impact at the start: runs")
      call check(recorder%n_events == 1 .and. recorder%kind(1) == event_lift, &
         "impact at the start: lifts off")
      call check_close(recorder%velocity(recorder%n_rows - 1), 0.3_wp, 1.0e-6_wp, &
         "impact at the start: restitution")
   end subroutine test_touching_at_start

   !> No impact is stepped over, however short it is against the flights.
   subroutine test_short_contact()
      type(scene_type) :: scene
      type(recorder_type) :: recorder
      type(error_type), allocatable :: error
      integer :: i

      call ball(scene, 0.5_wp, 0.54_wp + 0.5_wp)
      scene%bodies(1)%velocity = [0.0_wp, 0.0_wp, -1.0_wp]
      scene%materials(1)%young = 2.0e12_wp
      scene%t_end = 19.9_wp
      do i = 1, size(integrator_methods)
         scene%integrator%method = trim(integrator_methods(i))
         call run(scene, recorder, 0.1_wp, error)
         call check(.not. allocated(error) .and. recorder%n_events == 40, &
            trim(integrator_methods(i)) // ": no impact is stepped over")
         call check(all(recorder%height(:recorder%n_rows - 1) > 0.0_wp .and. &
            recorder%height(:recorder%n_rows - 1) < 1.1_wp), &
            trim(integrator_methods(i)) // ": the ball stays between floor and ceiling")
      end do
   end subroutine test_short_contact

   !> A touch within a single step of free flight: a ball thrown up just reaches the ceiling.
   subroutine test_dip(method)
      character(len=*), intent(in) :: method
      type(scene_type) :: scene
      type(recorder_type) :: recorder
      type(error_type), allocatable :: error
      real(wp), parameter :: g = 9.81_wp, v = 0.981_wp
      real(wp), parameter :: excess(*) = [1.0e-4_wp, 1.0e-5_wp, 1.0e-6_wp]
      real(wp) :: height
      integer :: i

      do i = 1, size(excess)
         height = v**2/(2.0_wp*g) - excess(i)
         call ball(scene, 1.0_wp, 1.04_wp + height)
         scene%gravity = [0.0_wp, 0.0_wp, -g]
         scene%bodies(1)%velocity = [0.0_wp, 0.0_wp, v]
         scene%integrator%method = method
         scene%t_end = 0.3_wp
         call run(scene, recorder, 0.3_wp, error)
         call check(.not. allocated(error) .and. recorder%n_events == 2, &
            method // ": a touch within a step is seen")
         call check(all(recorder%kind(:2) == [event_touch, event_lift]) .and. &
            all(recorder%contact(:2) == 2), method // ": a touch within a step, then a lift")
         ! The slower the touch, the less its time is determined by its place.
         call check_close(recorder%t_event(1), (v - sqrt(2.0_wp*g*excess(i)))/g, 1.0e-6_wp, &
            method // ": time of a touch within a step")
      end do
   end subroutine test_dip

   !> Speeds of a ball between floor and ceiling without gravity, from the rows of each flight.
   subroutine speeds_of_flights(recorder, n, speeds)
      !> The record.
      type(recorder_type), intent(in) :: recorder
      !> Number of flights, the one before the first touch included.
      integer, intent(in) :: n
      !> Speed of each [m/s]; zero if there was none.
      real(wp), intent(out) :: speeds(n)
      real(wp) :: from, to
      integer :: i, k

      speeds = 0.0_wp
      from = 0.0_wp
      do i = 1, n
         to = recorder%t_event(2*i - 1)
         do k = 0, recorder%n_rows - 1
            if (recorder%t_row(k) > from .and. recorder%t_row(k) < to) then
               speeds(i) = abs(recorder%velocity(k))
            end if
         end do
         from = recorder%t_event(2*i)
      end do
   end subroutine speeds_of_flights

   !> With a restitution of each impact every bounce has it, whatever its speed.
   subroutine test_restitution(method)
      character(len=*), intent(in) :: method
      type(scene_type) :: scene
      type(recorder_type) :: recorder
      type(error_type), allocatable :: error
      real(wp) :: speeds(6)
      real(wp), parameter :: e(*) = [0.3_wp, 0.7_wp, 0.95_wp]
      integer :: i, k

      do k = 1, size(e)
         call ball(scene, 0.01_wp, 0.06_wp)
         scene%bodies(1)%velocity = [0.0_wp, 0.0_wp, -1.0_wp]
         scene%contacts%damping = damping_index("hunt_crossley")
         do i = 1, size(scene%contacts)
            call scene%contacts(i)%parameters%set("restitution", e(k))
         end do
         scene%integrator%method = method
         scene%t_end = 0.01_wp + sum([(0.02_wp/e(k)**i, i=1, 5)]) + 0.02_wp
         call run(scene, recorder, 2.5e-3_wp, error)
         call check(.not. allocated(error), method // ": restitution of each impact: runs")
         call speeds_of_flights(recorder, 6, speeds)
         do i = 2, 6
            call check_close(speeds(i)/speeds(i - 1), e(k), 1.0e-5_wp, &
               method // ": restitution of each impact")
         end do
      end do
   end subroutine test_restitution

   !> Bounces with Tsuji's law have the same restitution at any speed. It is larger than that of the
   !> formula, which is for a law that pulls at the end of an impact.
   subroutine test_tsuji()
      type(scene_type) :: scene
      type(recorder_type) :: recorder
      type(error_type), allocatable :: error
      type(coefficient_damping_type) :: damping
      real(wp) :: speeds(4), expected
      real(wp), parameter :: e(*) = [0.3_wp, 0.7_wp, 0.95_wp]
      integer :: i, k

      damping = new_damping("tsuji")
      do k = 1, size(e)
         call ball(scene, 0.01_wp, 0.06_wp)
         scene%bodies(1)%velocity = [0.0_wp, 0.0_wp, -1.0_wp]
         scene%contacts%damping = damping_index("tsuji")
         do i = 1, size(scene%contacts)
            call scene%contacts(i)%parameters%set("restitution", e(k))
         end do
         scene%t_end = 0.01_wp + sum([(0.02_wp/e(k)**i, i=1, 3)]) + 0.002_wp
         call run(scene, recorder, 2.5e-3_wp, error)
         call check(.not. allocated(error), "tsuji: runs")
         call speeds_of_flights(recorder, 4, speeds)
         expected = speeds(2)/speeds(1)
         damping%coefficient = tsuji_factor(e(k))*impact_coefficient
         call check_close(expected, rebound(damping, 1.0_wp, .true.), 1.0e-4_wp, &
            "tsuji: restitution of the first impact")
         call check(expected >= e(k), "tsuji: not less than the restitution of the formula")
         do i = 3, 4
            call check_close(speeds(i)/speeds(i - 1), expected, 1.0e-5_wp, &
               "tsuji: the same restitution at any speed")
         end do
      end do
   end subroutine test_tsuji

   !> An impact too hard for the contact model ends with a message.
   subroutine test_deep(method)
      character(len=*), intent(in) :: method
      type(scene_type) :: scene
      type(recorder_type) :: recorder
      type(error_type), allocatable :: error

      call ball(scene, 0.01_wp)
      scene%materials(1)%young = 1.0e6_wp
      scene%bodies(1)%velocity = [0.0_wp, 0.0_wp, -10.0_wp]
      scene%contacts(1)%friction = friction_index("contensou_exact")
      call scene%contacts(1)%parameters%set("friction_coefficient", 0.3_wp)
      scene%integrator%method = method
      recorder%stop_after = 100000
      call run(scene, recorder, 1.0e-3_wp, error)
      call check(allocated(error), method // ": too deep is an error")
      if (allocated(error)) call check(index(error%message, "domain of the model") > 0, &
         method // ": too deep says: " // error%message)
      call check(recorder%n_events == 1 .and. recorder%kind(1) == event_touch, &
         method // ": too deep, the touch is recorded")
   end subroutine test_deep

end module test_integrate
