!> Tests of the explicit method of order 8 alone: its orders, its tolerance, its events, and that it
!> knows when a problem is not for it.
module test_explicit
   use contensou_base_errors, only : error_type
   use contensou_base_kinds, only : wp
   use contensou_integrate_explicit8, only : explicit8_type
   use contensou_integrate_integrator, only : statistics_type
   use contensou_integrate_problem, only : problem_type
   use contensou_integrate_rk8pd, only : begin_rk8pd, end_rk8pd, evaluate, extend, last_stage, &
      rk8pd_type, take_step, value_within
   use test_harness, only : check, check_close, worst_type
   implicit none(type, external)
   private

   public :: run_explicit_tests

   !> Four coupled equations with a known solution, in all of whose terms time takes part.
   integer, parameter :: coupled = 1

   !> y' = 1 with events in one place, close together, at the start and in both directions.
   integer, parameter :: ramp = 2

   !> y' = -stiffness (y - cos t) - sin t with the solution cos t.
   integer, parameter :: stiff = 3

   !> y_1' = t^power, y_2' = 1, y_1(0) = y_2(0) = 0.
   integer, parameter :: quadrature = 4

   !> y' = 1 with many events, of which one occurs.
   integer, parameter :: crowd = 5

   !> A problem.
   type, extends(problem_type) :: problem_of_test_type
      !> Which one, one of the codes above.
      integer :: kind = coupled
      !> Admissible error.
      real(wp) :: tolerance = 1.0e-8_wp
      !> Stiffness [1/s].
      real(wp) :: stiffness = 1.0_wp
      !> Latest time of an evaluation.
      real(wp) :: latest = 0.0_wp
      integer :: evaluations = 0
      !> Evaluations of the event functions.
      integer :: looks = 0
      !> Power of time.
      integer :: power = 0
      !> Largest difference of the second unknown from time.
      real(wp) :: apart = 0.0_wp
      !> States beyond this are outside the domain.
      real(wp) :: wall = huge(1.0_wp)
   contains
      procedure :: derivative
      procedure :: events
      procedure :: admissible_error
   end type problem_of_test_type

contains

   !> Run all tests.
   subroutine run_explicit_tests()
      call test_conditions()
      call test_order()
      call test_tolerance()
      call test_first_events()
      call test_crowd()
      call test_return()
      call test_end_of_time()
      call test_wall()
      call test_stiff()
   end subroutine run_explicit_tests

   !> Right-hand side.
   subroutine derivative(self, t, y, rate, outside)
      class(problem_of_test_type), intent(inout) :: self
      !> Time.
      real(wp), intent(in) :: t
      !> Unknowns.
      real(wp), intent(in) :: y(self%n)
      !> Their rates.
      real(wp), intent(out) :: rate(self%n)
      !> Whether the state is outside the domain.
      logical, intent(out) :: outside

      self%evaluations = self%evaluations + 1
      self%latest = max(self%latest, t)
      outside = y(1) > self%wall
      select case (self%kind)
      case (coupled)
         rate(1) = 2.0_wp*t*y(2)**0.2_wp*y(4)
         rate(2) = 10.0_wp*t*exp(5.0_wp*(y(3) - 1.0_wp))*y(4)
         rate(3) = 2.0_wp*t*y(4)
         rate(4) = -2.0_wp*t*log(y(1))
      case (ramp, crowd)
         rate = 1.0_wp
      case (quadrature)
         self%apart = max(self%apart, abs(y(2) - t))
         rate = [t**self%power, 1.0_wp]
      case default
         rate = -self%stiffness*(y - cos(t)) - sin(t)
      end select
   end subroutine derivative

   !> Event functions.
   subroutine events(self, t, y, g)
      class(problem_of_test_type), intent(inout) :: self
      !> Time.
      real(wp), intent(in) :: t
      !> Unknowns.
      real(wp), intent(in) :: y(:)
      !> Values.
      real(wp), intent(out) :: g(:)
      integer :: i

      self%looks = self%looks + 1
      if (self%kind == crowd) then
         g = 1.0_wp
         g(size(g)/2) = 0.3_wp - y(1)
         return
      end if
      ! The last one has a double root at 0.9.
      g = [y(1), y(1) - 0.6_wp, y(1) - 0.3_wp, 0.3_wp - y(1), y(1) - 0.300001_wp, &
         (y(1) - 0.9_wp)**2]
      do i = 1, size(g)
         if (self%kind /= ramp) g(i) = 1.0_wp
      end do
   end subroutine events

   !> Admissible error.
   subroutine admissible_error(self, y, size_of_error)
      class(problem_of_test_type), intent(in) :: self
      !> Unknowns.
      real(wp), intent(in) :: y(:)
      !> Admissible error.
      real(wp), intent(out) :: size_of_error(:)

      size_of_error = self%tolerance
   end subroutine admissible_error

   !> Solution of the coupled equations.
   pure function solution(t) result(y)
      !> Time.
      real(wp), intent(in) :: t
      real(wp) :: y(4)

      y = [exp(sin(t**2)), exp(5.0_wp*sin(t**2)), sin(t**2) + 1.0_wp, cos(t**2)]
   end function solution

   !> Integrate the coupled equations from 0.5 to 2.
   subroutine solve(tolerance, max_step, at_end, statistics)
      !> Admissible error.
      real(wp), intent(in) :: tolerance
      !> Largest step; 0 for no bound.
      real(wp), intent(in) :: max_step
      !> Error at the end.
      real(wp), intent(out) :: at_end
      !> Counters.
      type(statistics_type), intent(out) :: statistics
      type(problem_of_test_type), target :: problem
      type(explicit8_type) :: integrator
      type(error_type), allocatable :: error
      real(wp) :: t, y(4)
      integer :: found(0)

      problem%n = 4
      problem%tolerance = tolerance
      t = 0.5_wp
      y = solution(t)
      call integrator%start(problem, "explicit8", t, y, 2.0_wp, max_step, error)
      do while (t < 2.0_wp .and. .not. allocated(error))
         call integrator%step(t, y, found, error)
      end do
      call check(.not. allocated(error), "explicit8: integrates the coupled equations")
      at_end = maxval(abs(y - solution(t)))
      statistics = integrator%statistics()
      call integrator%free()
   end subroutine solve

   !> Largest error of the interpolation within a single step that begins with the exact solution.
   subroutine interpolate_one(h, within)
      !> Length of the step.
      real(wp), intent(in) :: h
      !> The error.
      real(wp), intent(out) :: within
      type(problem_of_test_type), target :: problem
      type(explicit8_type) :: integrator
      type(error_type), allocatable :: error
      real(wp) :: t, y(4)
      real(wp), parameter :: t_start = 1.1_wp
      integer :: found(0), i

      problem%n = 4
      problem%tolerance = 1.0e3_wp
      t = t_start
      y = solution(t)
      call integrator%start(problem, "explicit8", t, y, 2.0_wp, h, error)
      call integrator%step(t, y, found, error)
      call check_close(t - t_start, h, 1.0e-15_wp, "explicit8: one step of that length")
      within = 0.0_wp
      do i = 0, 20
         t = t_start + 0.05_wp*i*h
         call integrator%interpolate(t, y)
         within = max(within, maxval(abs(y - solution(t))))
      end do
      call integrator%free()
   end subroutine interpolate_one

   !> The method is of order 8, its continuous extension of order 7: an error of the eighth power
   !> within a single step.
   subroutine test_order()
      real(wp) :: coarse, fine, order
      type(statistics_type) :: statistics

      call solve(1.0e3_wp, 0.1_wp, coarse, statistics)
      call check(statistics%error_test_failures == 0 .and. statistics%steps <= 16, &
         "explicit8: constant steps")
      call solve(1.0e3_wp, 0.05_wp, fine, statistics)
      order = log(coarse/fine)/log(2.0_wp)
      call check(order > 7.5_wp .and. order < 10.0_wp, "explicit8: order of the method")
      call interpolate_one(0.08_wp, coarse)
      call interpolate_one(0.04_wp, fine)
      order = log(coarse/fine)/log(2.0_wp)
      call check(order > 7.5_wp .and. order < 9.0_wp, "explicit8: order of the interpolation")
   end subroutine test_order

   !> The coefficients meet the conditions of quadrature: polynomials in time are integrated
   !> exactly, of degree 7 by the solution, 6 by the continuous extension. Each stage is at the
   !> state of its time.
   subroutine test_conditions()
      type(problem_of_test_type), target :: problem
      type(rk8pd_type) :: pair
      real(wp) :: y(2), y_new(2), z(2), value
      logical :: outside
      integer :: power, i
      real(wp), parameter :: s(*) = [0.0_wp, 0.1_wp, 0.25_wp, 0.5_wp, 0.8_wp, 1.0_wp]

      problem%kind = quadrature
      problem%n = 2
      y = 0.0_wp
      do power = 0, 7
         problem%power = power
         call begin_rk8pd(pair, problem)
         call evaluate(pair, 1, 0.0_wp, y, outside)
         call take_step(pair, 0.0_wp, 1.0_wp, y, y_new, outside)
         value = 1.0_wp/(power + 1)
         call check_close(y_new(1), value, 1.0e-14_wp, "rk8pd: quadrature")
         if (power < 7) call check(abs(pair%error(1)) < 1.0e-14_wp, &
            "rk8pd: no error is seen where there is none")
         if (power == 7) call check(abs(pair%error(1)) > 1.0e-7_wp, &
            "rk8pd: the embedded method is of order 7")
         call evaluate(pair, last_stage, 1.0_wp, y_new, outside)
         call extend(pair, 0.0_wp, 1.0_wp, y, y_new)
         call check(pair%derivatives == 17, "rk8pd: stages")
         do i = 1, size(s)
            call value_within(pair, s(i), y, z)
            if (power < 7) call check_close(z(1), s(i)**(power + 1)/(power + 1), 1.0e-14_wp, &
               "rk8pd: quadrature within the step")
         end do
      end do
      call check(problem%apart <= 1.0e-14_wp, "rk8pd: times of the stages")
      ! A stage outside the domain is the last one.
      problem%wall = 0.1_wp
      problem%power = 0
      call begin_rk8pd(pair, problem)
      call evaluate(pair, 1, 0.0_wp, y, outside)
      call check(.not. outside, "rk8pd: the beginning is inside the domain")
      call take_step(pair, 0.0_wp, 1.0_wp, y, y_new, outside)
      call check(outside .and. pair%derivatives == 4, "rk8pd: a stage outside the domain")
      call end_rk8pd(pair)
   end subroutine test_conditions

   !> The error follows the tolerance.
   subroutine test_tolerance()
      real(wp) :: error, before, tolerance
      type(statistics_type) :: statistics
      integer :: i

      before = 0.0_wp
      do i = 4, 12, 2
         tolerance = 10.0_wp**(-i)
         call solve(tolerance, 0.0_wp, error, statistics)
         call check(error < 1.0e3_wp*tolerance, "explicit8: error within reach of the tolerance")
         if (i > 4) call check(error < 0.2_wp*before, "explicit8: error falls with the tolerance")
         before = error
      end do
   end subroutine test_tolerance

   !> Of several events in a step the first ones are found, those in one place together, at the
   !> resolution of time; a value that is zero at the start makes none.
   subroutine test_first_events()
      type(problem_of_test_type), target :: problem
      type(explicit8_type) :: integrator
      type(error_type), allocatable :: error
      real(wp) :: t, y(1)
      real(wp), parameter :: due(*) = [0.3_wp, 0.300001_wp, 0.6_wp]
      integer :: found(6), expected(6, 3), n

      expected(:, 1) = [0, 0, 1, -1, 0, 0]
      expected(:, 2) = [0, 0, 0, 0, 1, 0]
      expected(:, 3) = [0, 1, 0, 0, 0, 0]
      problem%n = 1
      problem%n_events = 6
      problem%kind = ramp
      t = 0.0_wp
      y = 0.0_wp
      call integrator%start(problem, "explicit8", t, y, 2.0_wp, 0.0_wp, error)
      n = 0
      do while (t < 2.0_wp .and. .not. allocated(error))
         call integrator%step(t, y, found, error)
         if (all(found == 0)) cycle
         n = n + 1
         if (n > 3) exit
         call check(all(found == expected(:, n)), "explicit8: events of one place")
         call check_close(t, due(n), 8.0_wp*epsilon(t), "explicit8: time of an event")
         call check_close(y(1), t, 4.0_wp*epsilon(t), "explicit8: state at an event")
         if (n == 2) call integrator%restart(t, y, error)
      end do
      call check(.not. allocated(error) .and. n == 3, "explicit8: each event once")
      call integrator%free()
   end subroutine test_first_events

   !> Where nothing happens costs nothing when an event is located, however much of it there is.
   subroutine test_crowd()
      type(problem_of_test_type), target :: problem
      type(explicit8_type) :: integrator
      type(error_type), allocatable :: error
      real(wp) :: t, y(1)
      integer :: found(1000)

      problem%n = 1
      problem%n_events = 1000
      problem%kind = crowd
      t = 0.0_wp
      y = 0.0_wp
      call integrator%start(problem, "explicit8", t, y, 2.0_wp, 0.0_wp, error)
      found = 0
      do while (all(found == 0) .and. t < 2.0_wp .and. .not. allocated(error))
         problem%looks = 0
         call integrator%step(t, y, found, error)
      end do
      call check(.not. allocated(error) .and. found(500) == -1, "explicit8: an event of many")
      call check_close(t, 0.3_wp, 8.0_wp*epsilon(t), "explicit8: time of an event of many")
      call check(problem%looks < 100, "explicit8: looks for an event of many")
      call integrator%free()
   end subroutine test_crowd

   !> An event in each direction within one step after another, as in a short contact.
   subroutine test_return()
      type(problem_of_test_type), target :: problem
      type(explicit8_type) :: integrator
      type(error_type), allocatable :: error
      type(worst_type) :: timing
      real(wp) :: t, y(1)
      integer :: found(6), n

      ! Begun where another function is zero: it has to leave zero first.
      problem%n = 1
      problem%n_events = 6
      problem%kind = ramp
      t = 0.0_wp
      y = 0.6_wp
      call integrator%start(problem, "explicit8", t, y, 1.0_wp, 0.01_wp, error)
      n = 0
      do while (t < 1.0_wp .and. .not. allocated(error))
         call integrator%step(t, y, found, error)
         if (any(found /= 0)) n = n + 1
         call timing%note(abs(y(1) - 0.6_wp - t), 1)
      end do
      call check(n == 0, "explicit8: no event where a value begins at zero or touches zero")
      call timing%check_below(1.0e-13_wp, "explicit8: a ramp is exact")
      call integrator%free()
   end subroutine test_return

   !> Nothing is evaluated beyond the end, and the end is reached exactly.
   subroutine test_end_of_time()
      type(problem_of_test_type), target :: problem
      type(explicit8_type) :: integrator
      type(error_type), allocatable :: error
      real(wp) :: t, y(4), t_end
      integer :: found(0), i

      do i = 1, 7
         problem%n = 4
         problem%latest = 0.0_wp
         problem%evaluations = 0
         t_end = 0.3_wp*i/7.0_wp + 1.0e-3_wp
         t = 0.0_wp
         y = solution(t)
         call integrator%start(problem, "explicit8", t, y, t_end, 0.0_wp, error)
         do while (t < t_end .and. .not. allocated(error))
            call integrator%step(t, y, found, error)
         end do
         call check(problem%latest <= t_end, "explicit8: nothing is evaluated beyond the end")
         call check_close(t, t_end, 0.0_wp, "explicit8: ends at the end")
         associate (s => integrator%statistics())
            call check(s%derivatives == problem%evaluations, "explicit8: counts the derivatives")
         end associate
      end do
      call integrator%free()
   end subroutine test_end_of_time

   !> A state that may not be passed is approached in smaller steps, as long as they help.
   subroutine test_wall()
      type(problem_of_test_type), target :: problem
      type(explicit8_type) :: integrator
      type(error_type), allocatable :: error
      real(wp) :: t, y(4), top
      integer :: found(0), i

      ! The first unknown has its maximum e at t = 1.2533.
      top = exp(1.0_wp)
      do i = 1, 2
         problem%n = 4
         problem%tolerance = 1.0e-6_wp
         problem%wall = merge(top + 1.0e-3_wp, 0.99_wp*top, i == 1)
         t = 0.0_wp
         y = solution(t)
         call integrator%start(problem, "explicit8", t, y, 2.0_wp, 0.0_wp, error)
         do while (t < 2.0_wp .and. .not. allocated(error))
            call integrator%step(t, y, found, error)
         end do
         if (i == 1) then
            call check(.not. allocated(error), "explicit8: passes below a wall")
         else
            call check(allocated(error), "explicit8: does not pass through a wall")
            if (allocated(error)) call check(index(error%message, "domain of the model") > 0, &
               "explicit8: a wall: " // error%message)
            call check_close(y(1), problem%wall, 1.0e-6_wp, "explicit8: comes to the wall")
         end if
      end do
      call integrator%free()
   end subroutine test_wall

   !> Where stability limits the steps the user is told once, and where that is hopeless it ends;
   !> nothing is said of steps that accuracy limits.
   subroutine test_stiff()
      type(problem_of_test_type), target :: problem
      type(explicit8_type) :: integrator
      type(error_type), allocatable :: error
      real(wp), parameter :: stiffness(*) = [1.0e-2_wp, 1.0_wp, 1.0e4_wp, 1.0e9_wp]
      real(wp) :: t, y(1)
      integer :: found(0), i, k, n

      do i = 1, size(stiffness)
         problem%n = 1
         problem%kind = stiff
         problem%stiffness = stiffness(i)
         t = 0.0_wp
         y = 1.0_wp
         call integrator%start(problem, "explicit8", t, y, 1.0e5_wp, 0.0_wp, error)
         n = 0
         do k = 1, 60000
            call integrator%step(t, y, found, error)
            if (allocated(error)) exit
            if (allocated(integrator%advice)) then
               n = n + 1
               call check(index(integrator%advice, "cvode_bdf") > 0, "explicit8: what to change to")
               deallocate(integrator%advice)
            end if
         end do
         call check(n == merge(1, 0, i > 2), "explicit8: says once that a problem is stiff")
         call check(allocated(error) .eqv. i == 4, "explicit8: ends where there is no hope")
         if (allocated(error)) call check(index(error%message, "cvode_bdf") > 0, &
            "explicit8: no hope: " // error%message)
         call check_close(y(1), cos(t), 1.0e-5_wp, "explicit8: right, stiff or not")
         call integrator%free()
      end do
   end subroutine test_stiff

end module test_explicit
