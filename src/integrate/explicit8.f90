!> `explicit8`: an explicit Runge-Kutta method of order 8 for problems that are not stiff.
!>
!> The pair of `rk8pd`, whose steps are the GNU Scientific Library's. What the library lacks is
!> here: the local error, the root of the mean of the squares of the errors over the admissible
!> ones, is held below 1 by a proportional-integral control of the step.
!> Events are located on the continuous extension to the resolution of time; the step is then taken
!> again up to there, so that no step contains the kink of the right-hand side at an event.
!> E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed. (1993),
!> sections II.4 and II.6.
!>
!> An explicit method pays for a stiff problem with steps far shorter than the solution asks for.
!> That shows in the solution itself: a polynomial through states that lie many steps apart
!> foretells the next of them within the tolerance, of which a BDF method would make its steps.
module contensou_integrate_explicit8
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite
   use contensou_base_errors, only : error_type, fatal, status_failed
   use contensou_base_kinds, only : i8, wp
   use contensou_base_numbers, only : power_text
   use contensou_integrate_integrator, only : graded, integrator_type, statistics_type
   use contensou_integrate_problem, only : problem_type
   use contensou_integrate_rk8pd, only : begin_rk8pd, end_rk8pd, evaluate, extend, last_stage, &
      rk8pd_type, take_step, value_within
   implicit none(type, external)
   private

   public :: explicit8_type

   !> Factor of the length that the error estimates admit: they settle at about half the tolerance.
   real(wp), parameter :: safety = 0.96_wp

   !> Exponent of the error of the last step but one in the control of the step.
   real(wp), parameter :: memory_exponent = 0.04_wp

   !> Exponent of the error of the last step in the control of the step.
   real(wp), parameter :: exponent = 1.0_wp/8.0_wp - 0.75_wp*memory_exponent

   !> Largest growth of a step.
   real(wp), parameter :: largest_growth = 6.0_wp

   !> Error below which it is rounding for the most part, 1 at the tolerance, and the growth of a
   !> step then, where lengths are not to depend on that.
   real(wp), parameter :: rounding_error = 0.1_wp, growth_by_rounding = 1.3_wp

   !> Largest error of a first step where contacts remember, 1 at the tolerance: it may begin at a
   !> touch, where the force grows with the power 3/2 of the overlap, and the estimate is too small.
   real(wp), parameter :: first_error = 0.01_wp

   !> What is admitted of how bodies in flight tumble, over what is else, where contacts remember.
   real(wp), parameter :: part_in_flight = 0.1_wp

   !> Largest decrease of a step.
   real(wp), parameter :: largest_decrease = 0.05_wp

   !> Decrease of a step that leaves the domain of the model, or whose error estimate is not to be
   !> trusted.
   real(wp), parameter :: decrease_outside = 0.25_wp

   !> Largest difference of the last two stages, both at the end of a step, times the step and over
   !> the tolerance. Stages 2 to 5 have no part in the error estimate: when a contact that touches
   !> them alone throws all later ones out of its reach, the estimate is that of a free flight
   !> through the floor. In sound steps this is below 1e4, in those above 1e11.
   real(wp), parameter :: disagreement = 1.0e7_wp

   !> Step that is not taken any more, in units of the rounding of the time.
   real(wp), parameter :: shortest = 4.0_wp

   !> Steps between two states that are kept to see how smooth the solution is: as many times longer
   !> would the steps of a BDF method be.
   integer, parameter :: spacing_of_states = 10

   !> States that are kept.
   integer, parameter :: kept = 7

   !> Error of a state up to which it counts as foretold by the BDF methods of orders 2 to 5, 1 at
   !> the tolerance. Steps at the limit of stability have errors near the tolerance, which
   !> extrapolation amplifies, and steps shorter by the cube root of 10 still are the longer ones;
   !> but with orders 4 and 5 the ringing of a lightly damped contact limits the steps of BDF, too.
   real(wp), parameter :: foretold_within(2:5) = [10.0_wp, 10.0_wp, 1.0_wp, 1.0_wp]

   !> States in a row that are foretold before the steps are called limited by stability.
   integer, parameter :: foretold_enough = 20

   !> Steps to the end of time, of the present length, from which on it pays to say so.
   real(wp), parameter :: many_steps = 2.0e4_wp

   !> The same where the march can change to another method: what that one gains is to make up for
   !> its short first steps.
   real(wp), parameter :: some_steps = 1.0e3_wp

   !> Steps between two states that are kept where the march can change to another method.
   integer, parameter :: spacing_alert = 4

   !> Steps to the end of time, of the present length, from which on there is no hope: an hour for
   !> one body with one contact.
   real(wp), parameter :: too_many_steps = 1.0e9_wp

   !> States in a row that are foretold before there is no hope.
   integer, parameter :: foretold_hopeless = 2000

   !> Error constants of the BDF methods of orders 2 to 5 over those of extrapolation.
   real(wp), parameter :: bdf_error(2:5) = [2.0_wp/9.0_wp, 3.0_wp/22.0_wp, 12.0_wp/125.0_wp, &
      10.0_wp/137.0_wp]

   !> One integration.
   type, extends(integrator_type) :: explicit8_type
      private
      class(problem_type), pointer :: problem => null()
      !> Number of unknowns.
      integer :: n = 0
      !> Beginning of the last step [s].
      real(wp) :: t_old = 0.0_wp
      !> End of the last step [s].
      real(wp) :: t = 0.0_wp
      !> End of time [s].
      real(wp) :: t_end = 0.0_wp
      !> Length of the last step [s].
      real(wp) :: h = 0.0_wp
      !> Length of the next step [s]; 0 if it is to be guessed.
      real(wp) :: h_next = 0.0_wp
      !> Largest step [s]; 0 for no bound.
      real(wp) :: max_step = 0.0_wp
      !> Error of the last step, 1 at the tolerance.
      real(wp) :: last_error = 1.0_wp
      !> Whether the right-hand side at `t` is yet to be evaluated.
      logical :: fresh = .true.
      !> Whether the next step is the first one, and whether the last one was.
      logical :: at_start = .true., was_at_start = .true.
      !> Whether the continuous extension of the last step is set.
      logical :: dense_set = .false.
      !> State at the beginning of the last step.
      real(wp), allocatable :: y_old(:)
      !> State at its end.
      real(wp), allocatable :: y(:)
      !> State within a step, or at the end of one that is tried.
      real(wp), allocatable :: z(:)
      !> Inverse of the admissible error of each unknown.
      real(wp), allocatable :: weight(:)
      type(rk8pd_type) :: pair
      !> Sign of each event function since it last changed; 0 before it has left zero.
      integer, allocatable :: side(:)
      !> The same at the beginning of the last step.
      integer, allocatable :: side_old(:)
      !> Values of the event functions.
      real(wp), allocatable :: g(:)
      !> States at multiples of `spacing_of_states`, the latest last.
      real(wp), allocatable :: y_kept(:, :)
      !> Times of these [s].
      real(wp) :: t_kept(kept) = 0.0_wp
      !> Number of these.
      integer :: n_kept = 0
      !> Steps since the latest of these.
      integer :: steps_since = 0
      !> States in a row that were foretold by those before.
      integer :: foretold = 0
      !> Whether the advice was given.
      logical :: advised = .false.
      type(statistics_type) :: counters
   contains
      procedure, public :: start
      procedure, public :: step
      procedure, public :: interpolate
      procedure, public :: restart
      procedure, public :: bound_step
      procedure, public :: statistics
      procedure, public :: free
   end type explicit8_type

contains

   !> Begin an integration.
   subroutine start(self, problem, method, t, y, t_end, max_step, error)
      class(explicit8_type), intent(inout) :: self
      !> The problem; must outlive the integration.
      class(problem_type), intent(in), target :: problem
      !> `explicit8`.
      character(len=*), intent(in) :: method
      !> Initial time [s].
      real(wp), intent(in) :: t
      !> Initial state.
      real(wp), intent(in) :: y(:)
      !> The right-hand side is never evaluated beyond this time [s].
      real(wp), intent(in) :: t_end
      !> Largest step [s]; 0 for no bound.
      real(wp), intent(in) :: max_step
      !> Never set.
      type(error_type), allocatable, intent(out) :: error

      call self%free()
      self%problem => problem
      self%n = problem%n
      self%t_end = t_end
      associate (n => problem%n, m => problem%n_events)
         allocate(self%y_old(n), self%y(n), self%z(n), self%weight(n))
         allocate(self%side(m), self%side_old(m), self%g(m), self%y_kept(n, kept))
      end associate
      call begin_rk8pd(self%pair, problem)
      call self%bound_step(max_step)
      call begin_at(self, t, y)
      if (allocated(problem%side)) where (self%side == 0) self%side = problem%side
   end subroutine start

   !> Set the state, and on which side of zero the event functions are.
   subroutine begin_at(self, t, y)
      type(explicit8_type), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)

      self%t = t
      self%t_old = t
      self%h = 0.0_wp
      self%y = y
      self%y_old = y
      self%fresh = .true.
      self%at_start = .true.
      self%dense_set = .false.
      self%last_error = 1.0_wp
      call forget_states(self)
      if (size(self%g) > 0) call self%problem%events(t, self%y, self%g)
      self%side = merge(0, side_of(self%g), abs(self%g) <= self%problem%rounding)
   end subroutine begin_at

   !> Sign of a value, 0 for zero.
   elemental function side_of(g) result(side)
      real(wp), intent(in) :: g
      integer :: side

      side = merge(1, 0, g > 0.0_wp) - merge(1, 0, g < 0.0_wp)
   end function side_of

   !> Forget the states by which stiffness is seen.
   subroutine forget_states(self)
      type(explicit8_type), intent(inout) :: self

      self%n_kept = 0
      self%steps_since = 0
      self%foretold = 0
   end subroutine forget_states

   !> Advance by one step, or to the next event within it.
   subroutine step(self, t, y, events, error)
      class(explicit8_type), intent(inout) :: self
      !> Time reached [s].
      real(wp), intent(inout) :: t
      real(wp), intent(out) :: y(:)
      !> For each event function: 1 it rose through zero here, -1 it fell, 0 no event.
      integer, intent(out) :: events(:)
      !> Set when the integration cannot go on.
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: h, t_new, t_last, estimate, factor, h_event
      real(wp) :: admitted
      logical :: outside, rejected, was_outside, last

      events = 0
      y = self%y
      self%events_last = .false.
      call prepare(self, error)
      if (allocated(error)) return

      rejected = .false.
      was_outside = .false.
      t_last = min(self%t_end, self%t_stop)
      admitted = 1.0_wp
      if (self%problem%remembers .and. self%at_start) admitted = first_error
      do
         h = self%h_next
         if (self%problem%remembers) h = graded(h)
         if (self%max_step > 0.0_wp) h = min(h, self%max_step)
         last = h*(1.0_wp + 1.0e-9_wp) >= t_last - self%t
         if (last) h = t_last - self%t
         t_new = merge(t_last, self%t + h, last)
         ! A spacing is two calls of the library, and no larger than this.
         if (h <= shortest*max(epsilon(h)*abs(self%t), tiny(h)) .and. .not. last) then
            if (h <= shortest*spacing(self%t)) then
               call fatal(error, trim(reason(was_outside, rejected)), status_failed)
               return
            end if
         end if
         call take_step(self%pair, self%t_old, h, self%y_old, self%z, outside)
         if (outside) then
            was_outside = .true.
            rejected = .true.
            self%counters%error_test_failures = self%counters%error_test_failures + 1
            self%h_next = decrease_outside*h
            cycle
         end if
         estimate = size_of(self%pair%error, self%weight)
         if (.not. ieee_is_finite(estimate)) estimate = huge(estimate)
         if (estimate <= admitted) then
            call evaluate(self%pair, last_stage, t_new, self%z, outside)
            if (.not. outside) then
               associate (k => self%pair%k)
                  k(:, 2) = k(:, last_stage) - k(:, last_stage - 1)
                  if (h*size_of(k(:, 2), self%weight) <= disagreement) exit
               end associate
            else
               was_outside = .true.
            end if
            self%h_next = decrease_outside*h
         else
            self%h_next = h*max(largest_decrease, safety*estimate**(-0.125_wp))
            ! There it hardly falls faster than with the cube of the step, and is rounding in part.
            if (admitted < 1.0_wp) self%h_next = h*max(largest_decrease, &
               2.0_wp**floor(log(safety*(admitted/estimate)**(1.0_wp/3.0_wp))/log(2.0_wp)))
         end if
         rejected = .true.
         self%counters%error_test_failures = self%counters%error_test_failures + 1
      end do

      self%was_at_start = self%at_start
      self%at_start = .false.
      call take_end(self, h, t_new)
      estimate = max(estimate, 1.0e-10_wp)
      factor = safety*estimate**(-exponent)*self%last_error**memory_exponent
      if (self%problem%remembers .and. estimate < rounding_error) factor = growth_by_rounding
      factor = min(max(factor, largest_decrease), merge(1.0_wp, largest_growth, rejected))
      self%last_error = max(estimate, merge(rounding_error, 1.0e-4_wp, self%problem%remembers))
      ! A step that is short because time ends says nothing of the next one's length.
      self%h_next = merge(max(self%h_next, h*factor), h*factor, last .and. .not. rejected)

      if (size(events) > 0) then
         self%problem%at_last = .true.
         call self%problem%events(self%t, self%y, self%g)
         self%problem%at_last = .false.
         self%events_last = .true.
         if (any(self%side*side_of(self%g) < 0)) then
            self%events_last = .false.
            call locate(self, events, h_event)
            if (h_event < h) then
               t_new = min(self%t_old + h_event, t_new)
               call take_step(self%pair, self%t_old, h_event, self%y_old, self%z, outside)
               if (.not. outside) call evaluate(self%pair, last_stage, t_new, self%z, outside)
               if (outside) then
                  call fatal(error, trim(reason(.true., .true.)), status_failed)
                  return
               end if
               call take_end(self, h_event, t_new)
            end if
            where (events /= 0) self%side = events
            call forget_states(self)
         else
            where (self%side == 0) self%side = side_of(self%g)
         end if
      end if
      self%counters%steps = self%counters%steps + 1
      self%counters%last_step = self%h
      t = self%t
      y = self%y
      call judge(self, error)
   end subroutine step

   !> Right-hand side, weights and a first guess of the length of the step, where the next begins.
   subroutine prepare(self, error)
      type(explicit8_type), intent(inout) :: self
      !> Set when there can be no step.
      type(error_type), allocatable, intent(out) :: error
      logical :: outside

      if (self%fresh) then
         call evaluate(self%pair, 1, self%t, self%y, outside)
         if (outside) then
            call fatal(error, "the state it starts from is outside the domain of the model", &
               status_failed)
            return
         end if
         self%fresh = .false.
      else
         self%pair%k(:, 1) = self%pair%k(:, last_stage)
      end if
      self%pair%t_last = min(self%t_end, self%t_stop)
      self%t_old = self%t
      self%y_old = self%y
      self%side_old = self%side
      self%dense_set = .false.
      call self%problem%admissible_error(self%y, self%weight)
      call self%problem%flight_errors(part_in_flight, self%weight, self%side > 0)
      self%weight = 1.0_wp/self%weight
      if (size_of(self%y, self%weight)*epsilon(self%t) > 1.0_wp) then
         call fatal(error, "the tolerance is below what double precision can resolve", &
            status_failed)
         return
      end if
      if (self%h_next <= 0.0_wp) call guess_step(self)
   end subroutine prepare

   !> Root of the mean of the squares of weighted values.
   pure function size_of(values, weight) result(norm)
      real(wp), intent(in) :: values(:)
      real(wp), intent(in) :: weight(:)
      real(wp) :: norm
      integer :: i

      norm = 0.0_wp
      do i = 1, size(values)
         norm = norm + (values(i)*weight(i))**2
      end do
      norm = sqrt(norm/size(values))
   end function size_of

   !> Guess the length of the first step.
   subroutine guess_step(self)
      type(explicit8_type), intent(inout) :: self
      real(wp) :: d0, d1, d2, h0
      logical :: outside
      integer :: i

      d0 = size_of(self%y, self%weight)
      d1 = size_of(self%pair%k(:, 1), self%weight)
      h0 = 1.0e-6_wp
      if (d0 > 1.0e-5_wp .and. d1 > 1.0e-5_wp) h0 = 0.01_wp*d0/d1
      h0 = min(h0, min(self%t_end, self%t_stop) - self%t)
      if (self%max_step > 0.0_wp) h0 = min(h0, self%max_step)
      d2 = 0.0_wp
      do i = 1, 40
         self%z = self%y + h0*self%pair%k(:, 1)
         call evaluate(self%pair, 2, self%t + h0, self%z, outside)
         if (.not. outside) exit
         h0 = 0.1_wp*h0
      end do
      if (.not. outside) then
         self%z = self%pair%k(:, 2) - self%pair%k(:, 1)
         d2 = size_of(self%z, self%weight)/h0
      end if
      self%h_next = max(1.0e-6_wp, 1.0e-3_wp*h0)
      if (max(d1, d2) > 1.0e-15_wp) self%h_next = (0.01_wp/max(d1, d2))**0.125_wp
      self%h_next = min(100.0_wp*h0, self%h_next)
   end subroutine guess_step

   !> End the step at the state that was tried, whose right-hand side is the last one evaluated.
   subroutine take_end(self, h, t_new)
      type(explicit8_type), intent(inout) :: self
      !> Length of the step [s].
      real(wp), intent(in) :: h
      !> Where it ends [s].
      real(wp), intent(in) :: t_new

      self%y = self%z
      self%t = t_new
      self%h = h
      self%dense_set = .false.
   end subroutine take_end

   !> Why there is no step; of a fixed length, as threads fail at the same time.
   pure function reason(outside, rejected) result(words)
      !> Whether the model was left.
      logical, intent(in) :: outside
      !> Whether the error was too large.
      logical, intent(in) :: rejected
      character(len=80) :: words

      words = "the step size fell below the resolution of time"
      if (rejected) words = "the local error stays above the tolerance however small the step"
      if (outside) words = "the motion leaves the domain of the model"
   end function reason

   !> Have the continuous extension of the last step.
   subroutine have_extension(self)
      type(explicit8_type), intent(inout) :: self

      if (.not. self%dense_set) call extend(self%pair, self%t_old, self%h, self%y_old, self%y, &
         self%weight)
      self%dense_set = .true.
   end subroutine have_extension

   !> Find the first events within the last step.
   subroutine locate(self, events, h_event)
      type(explicit8_type), intent(inout) :: self
      !> For each event function: 1 it rises through zero there, -1 it falls, 0 no event.
      integer, intent(out) :: events(:)
      !> Time of the first events after the beginning of the step [s].
      real(wp), intent(out) :: h_event
      real(wp) :: low, high, f_low, f_high, tolerance, x, half, regula, radius, delta, f
      logical :: known
      integer :: i, j, most, first

      call have_extension(self)
      ! Shares of the step.
      tolerance = spacing(max(abs(self%t_old), abs(self%t)))/self%h
      high = 1.0_wp
      first = 0
      call values_at(self, high)
      known = .true.
      do i = 1, size(events)
         ! Others may have crossed before: the first ones are looked for only up to here.
         if (.not. known) call values_at(self, high)
         known = .true.
         if (self%side(i)*side_of(self%g(i)) >= 0) cycle
         first = i
         known = .false.
         f_high = self%g(i)
         low = 0.0_wp
         call values_at(self, low)
         f_low = self%g(i)
         ! After an event the value may still be on the old side by rounding.
         if (self%side(i)*side_of(f_low) <= 0) f_low = self%side(i)*tiny(f_low)
         ! Bisection, or interpolation where that is at least as fast: the ITP method.
         ! I. F. D. Oliveira, R. H. C. Takahashi, ACM Trans. Math. Software 47 (2021) 5.
         most = ceiling(log((high - low)/(2.0_wp*tolerance))/log(2.0_wp)) + 1
         do j = 0, max(most, 0)
            if (high - low <= 2.0_wp*tolerance) exit
            half = 0.5_wp*(low + high)
            radius = tolerance*2.0_wp**(most - j) - 0.5_wp*(high - low)
            delta = 0.2_wp*(high - low)**2
            regula = (f_high*low - f_low*high)/(f_high - f_low)
            x = half
            if (delta <= abs(half - regula)) x = regula + sign(delta, half - regula)
            if (abs(x - half) > radius) x = half - sign(radius, half - regula)
            if (x <= low .or. x >= high) x = half
            if (x <= low .or. x >= high) exit
            call values_at(self, x)
            f = self%g(i)
            if (self%side(i)*side_of(f) < 0) then
               high = x
               f_high = f
            else
               low = x
               f_low = f
               if (side_of(f) == 0) f_low = self%side(i)*tiny(f_low)
            end if
         end do
      end do
      ! What crosses within the resolution of time crosses together; there a value whose rounding
      ! is coarser than the resolution of time may be back on the old side.
      events = 0
      call values_at(self, high)
      where (self%side*side_of(self%g) < 0) events = -self%side
      call values_at(self, min(1.0_wp, high + 8.0_wp*tolerance))
      where (self%side*side_of(self%g) < 0) events = -self%side
      ! A gap that is found by a search is not the same to the last bit each time.
      if (first > 0) events(first) = -self%side(first)
      h_event = high*self%h
   end subroutine locate

   !> Event functions within the last step.
   subroutine values_at(self, s)
      !> The integration, its continuous extension set; `g` is set.
      type(explicit8_type), intent(inout) :: self
      !> Share of the step.
      real(wp), intent(in) :: s

      call value_within(self%pair, s, self%y_old, self%z)
      if (s >= 1.0_wp) self%z = self%y
      call self%problem%events(self%t_old + s*self%h, self%z, self%g)
   end subroutine values_at

   !> State at a time within the last step.
   subroutine interpolate(self, t, y)
      class(explicit8_type), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(out) :: y(:)

      if (t >= self%t .or. self%h <= 0.0_wp) then
         y = self%y
         return
      end if
      call have_extension(self)
      call value_within(self%pair, max((t - self%t_old)/self%h, 0.0_wp), self%y_old, y)
   end subroutine interpolate

   !> Begin anew at a state.
   subroutine restart(self, t, y, error)
      class(explicit8_type), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)
      !> Never set.
      type(error_type), allocatable, intent(out) :: error
      integer :: side(size(self%side))
      real(wp) :: g(size(self%side))
      logical :: same, at_start

      ! At an event the sides are those after it, whatever the rounding of the values; another
      ! state has sides of its own, unless it is another one of what has no part in them.
      same = abs(t - self%t) <= 0.0_wp .and. maxval(abs(y - self%y)) <= 0.0_wp
      side = self%side
      g = huge(g)
      at_start = .true.
      if (self%problem%remembers .and. .not. same) then
         if (abs(t - self%t) <= 0.0_wp) then
            call self%problem%events(t, self%y, g)
         else if (abs(t - self%t_old) <= 0.0_wp) then
            ! The last step is taken again.
            same = maxval(abs(y - self%y_old)) <= 0.0_wp
            side = self%side_old
            if (same) at_start = self%was_at_start
         end if
      end if
      call begin_at(self, t, y)
      self%at_start = at_start
      if (allocated(self%problem%turns)) where (self%problem%turns) g = huge(g)
      where (same .or. abs(self%g - g) <= 0.0_wp) self%side = side
   end subroutine restart

   subroutine bound_step(self, max_step)
      class(explicit8_type), intent(inout) :: self
      !> Largest step [s]; 0 for no bound.
      real(wp), intent(in) :: max_step

      self%max_step = max(max_step, 0.0_wp)
   end subroutine bound_step

   !> Counters so far.
   function statistics(self) result(s)
      class(explicit8_type), intent(in) :: self
      type(statistics_type) :: s

      s = self%counters
      s%derivatives = self%pair%derivatives
   end function statistics

   !> Release everything.
   subroutine free(self)
      class(explicit8_type), intent(inout) :: self

      if (allocated(self%y)) then
         deallocate(self%y_old, self%y, self%z, self%weight, self%side, self%side_old, &
            self%g, self%y_kept)
      end if
      call end_rk8pd(self%pair)
      if (allocated(self%advice)) deallocate(self%advice)
      nullify(self%problem)
      self%h_next = 0.0_wp
      self%advised = .false.
      self%counters = statistics_type()
   end subroutine free

   !> See whether the steps are far shorter than the solution asks for.
   subroutine judge(self, error)
      type(explicit8_type), intent(inout) :: self
      !> Set when there is no hope to reach the end.
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: steps_left
      integer :: i, spacing

      spacing = merge(spacing_alert, spacing_of_states, self%alert)
      self%steps_since = self%steps_since + 1
      if (self%steps_since < spacing .and. self%n_kept > 0) return
      self%steps_since = 0
      if (self%n_kept == kept) then
         do i = 1, kept - 1
            self%y_kept(:, i) = self%y_kept(:, i + 1)
            self%t_kept(i) = self%t_kept(i + 1)
         end do
      end if
      self%n_kept = min(self%n_kept + 1, kept)
      self%y_kept(:, self%n_kept) = self%y
      self%t_kept(self%n_kept) = self%t
      if (self%n_kept < kept) return
      if (.not. is_foretold(self)) then
         self%foretold = 0
         return
      end if
      self%foretold = self%foretold + 1
      if (self%foretold < foretold_enough) return
      steps_left = (self%t_end - self%t)*spacing/(self%t - self%t_kept(kept - 1))
      if (.not. self%advised .and. steps_left > merge(some_steps, many_steps, self%alert)) then
         self%advised = .not. self%alert
         self%advice = "the steps of explicit8 are limited by stability, not by accuracy: " // &
            "cvode_bdf may take longer ones"
      end if
      if (self%foretold < foretold_hopeless .or. steps_left < too_many_steps) return
      self%hopeless = .true.
      if (self%alert) return
      call fatal(error, &
         "the problem is stiff: stability limits the steps of explicit8 to " // &
         power_text((self%t - self%t_kept(kept - 1))/spacing, 2) // &
         " s, far too short to reach the end; integrator.method = " // &
         "'cvode_bdf' is for such problems", status_failed)
   end subroutine judge

   !> Whether a BDF method of some order would meet the tolerance with a step as long as the time
   !> between two of the states that are kept.
   pure function is_foretold(self) result(is)
      !> The integration, all states kept.
      type(explicit8_type), intent(in) :: self
      logical :: is
      real(wp) :: share(kept), total, value
      integer :: order, i, j, first

      is = .true.
      do order = 5, 2, -1
         first = kept - order - 1
         do i = first, kept - 1
            share(i) = 1.0_wp
            do j = first, kept - 1
               if (j /= i) share(i) = share(i)*(self%t_kept(kept) - self%t_kept(j)) &
                  /(self%t_kept(i) - self%t_kept(j))
            end do
         end do
         total = 0.0_wp
         do i = 1, self%n
            value = self%y_kept(i, kept)
            do j = first, kept - 1
               value = value - share(j)*self%y_kept(i, j)
            end do
            total = total + (value*self%weight(i))**2
         end do
         if (bdf_error(order)*sqrt(total/self%n) <= foretold_within(order)) return
      end do
      is = .false.
   end function is_foretold

end module contensou_integrate_explicit8
