!> An integration of an initial value problem, one step at a time, whatever the method.
module contensou_integrate_integrator
   use contensou_base_checkpoint, only : checkpoint_type
   use contensou_base_errors, only : error_type
   use contensou_base_kinds, only : i8, wp
   use contensou_integrate_problem, only : problem_type
   implicit none(type, external)
   private

   public :: graded, integrator_type, statistics_type

   !> Lengths of steps between one and its double, where they are graded.
   integer, parameter :: grades = 16

   !> What a length may fall short of its grade.
   real(wp), parameter :: edge = 1.0e-6_wp

   !> Counters of an integration.
   type :: statistics_type
      integer(i8) :: steps = 0
      !> Evaluations of the right-hand side, including those for Jacobians.
      integer(i8) :: derivatives = 0
      integer(i8) :: jacobians = 0
      !> Failed error tests.
      integer(i8) :: error_test_failures = 0
      !> Failed nonlinear iterations.
      integer(i8) :: convergence_failures = 0
      !> Size of the last step [s].
      real(wp) :: last_step = 0.0_wp
   contains
      procedure, private :: plus
      procedure :: exchange => exchange_statistics
      generic :: operator(+) => plus
   end type statistics_type

   !> One integration.
   type, abstract :: integrator_type
      !> What the user should know about the method and this problem; whoever takes note of it
      !> deallocates it. Not allocated: nothing.
      character(len=:), allocatable :: advice
      !> Whether it is to look out early for another method that suits better, as the march can
      !> change to it.
      logical :: alert = .false.
      !> Whether it would hardly reach the end; unless `alert`, it fails as well, the step taken.
      logical :: hopeless = .false.
      !> Steps for which the size of its steps tells nothing about the problem, as it tries
      !> something.
      integer :: steps_of_trial = 0
      !> Whether a state within a step costs no right-hand side.
      logical :: free_interpolation = .false.
      !> Whether the right-hand side changes more within a step than a Jacobian tells.
      logical :: steep = .false.
      !> Steps since the path within one was of account for what contacts remember.
      integer :: steps_of_no_path = 0
      !> Whether the event functions at the end of the last step are what was evaluated last.
      logical :: events_last = .false.
      !> Time at which a step must end, as the right-hand side is not smooth there [s]; taken note
      !> of at a start and a restart.
      real(wp) :: t_stop = huge(1.0_wp)
      !> What the next step should not exceed near a touch or a lift-off [s], for methods that
      !> estimate its error from the steps before.
      real(wp) :: reach = huge(1.0_wp)
      !> Whether such a contact is in an impact, where lengths of steps must not depend on rounding.
      logical :: impact = .false.
   contains
      !> Begin at a state.
      procedure(start_interface), deferred :: start
      !> Advance by one step, or to the next event within it.
      procedure(step_interface), deferred :: step
      !> State at a time within the last step.
      procedure(interpolate_interface), deferred :: interpolate
      !> Time derivative of that.
      procedure :: interpolate_rate
      !> Begin anew at a state, after the right-hand side has changed or to try again.
      procedure(restart_interface), deferred :: restart
      procedure(bound_interface), deferred :: bound_step
      !> Counters so far.
      procedure(statistics_interface), deferred :: statistics
      !> Release everything.
      procedure(free_interface), deferred :: free
   end type integrator_type

   abstract interface
      !> Begin an integration.
      subroutine start_interface(self, problem, method, t, y, t_end, max_step, error)
         import :: error_type, integrator_type, problem_type, wp
         implicit none(type, external)
         class(integrator_type), intent(inout) :: self
         !> The problem; must outlive the integration.
         class(problem_type), intent(in), target :: problem
         character(len=*), intent(in) :: method
         !> Initial time [s].
         real(wp), intent(in) :: t
         !> Initial state.
         real(wp), intent(in) :: y(:)
         !> The right-hand side is never evaluated beyond this time [s].
         real(wp), intent(in) :: t_end
         !> Largest step [s]; 0 for no bound.
         real(wp), intent(in) :: max_step
         !> Set when the integration cannot be set up.
         type(error_type), allocatable, intent(out) :: error
      end subroutine start_interface

      !> Advance by one step, or to the next event within it.
      subroutine step_interface(self, t, y, events, error)
         import :: error_type, integrator_type, wp
         implicit none(type, external)
         class(integrator_type), intent(inout) :: self
         !> Time reached [s].
         real(wp), intent(inout) :: t
         real(wp), intent(out) :: y(:)
         !> For each event function: 1 it rose through zero here, -1 it fell, 0 no event.
         integer, intent(out) :: events(:)
         !> Set when the integration cannot go on; its message says why.
         type(error_type), allocatable, intent(out) :: error
      end subroutine step_interface

      !> State at a time within the last step.
      subroutine interpolate_interface(self, t, y)
         import :: integrator_type, wp
         implicit none(type, external)
         class(integrator_type), intent(inout) :: self
         !> Time [s].
         real(wp), intent(in) :: t
         real(wp), intent(out) :: y(:)
      end subroutine interpolate_interface

      !> Begin anew at a state.
      subroutine restart_interface(self, t, y, error)
         import :: error_type, integrator_type, wp
         implicit none(type, external)
         class(integrator_type), intent(inout) :: self
         !> Time [s].
         real(wp), intent(in) :: t
         real(wp), intent(in) :: y(:)
         !> Set when the integration cannot begin there.
         type(error_type), allocatable, intent(out) :: error
      end subroutine restart_interface

      !> Bound the step.
      subroutine bound_interface(self, max_step)
         import :: integrator_type, wp
         implicit none(type, external)
         class(integrator_type), intent(inout) :: self
         !> Largest step [s]; 0 for no bound.
         real(wp), intent(in) :: max_step
      end subroutine bound_interface

      !> Counters so far.
      function statistics_interface(self) result(s)
         import :: integrator_type, statistics_type
         implicit none(type, external)
         class(integrator_type), intent(in) :: self
         type(statistics_type) :: s
      end function statistics_interface

      !> Release everything.
      subroutine free_interface(self)
         import :: integrator_type
         implicit none(type, external)
         class(integrator_type), intent(inout) :: self
      end subroutine free_interface
   end interface

contains

   !> The next shorter length of a scale by which lengths of steps do not depend on rounding, of the
   !> directions in which a scene happens to lie, but for where one is at the very edge of a grade.
   pure real(wp) function graded(length)
      !> > 0 [s].
      real(wp), intent(in) :: length

      graded = 2.0_wp**(real(floor(grades*log(length)/log(2.0_wp) + edge), wp)/grades)
   end function graded

   !> Time derivative of the state within the last step; not known here.
   subroutine interpolate_rate(self, t, rate, known)
      class(integrator_type), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> The derivative; only set if it is known.
      real(wp), intent(inout) :: rate(:)
      !> Whether the method knows it, to the accuracy of the state.
      logical, intent(out) :: known

      known = .false.
   end subroutine interpolate_rate

   !> Counters of two integrations together, one after the other.
   pure function plus(self, later) result(sum)
      !> The first one.
      class(statistics_type), intent(in) :: self
      type(statistics_type), intent(in) :: later
      type(statistics_type) :: sum

      sum%steps = self%steps + later%steps
      sum%derivatives = self%derivatives + later%derivatives
      sum%jacobians = self%jacobians + later%jacobians
      sum%error_test_failures = self%error_test_failures + later%error_test_failures
      sum%convergence_failures = self%convergence_failures + later%convergence_failures
      sum%last_step = later%last_step
   end function plus

   !> Write them to a checkpoint or read them back.
   subroutine exchange_statistics(self, checkpoint)
      class(statistics_type), intent(inout) :: self
      type(checkpoint_type), intent(inout) :: checkpoint

      call checkpoint%exchange("steps", self%steps)
      call checkpoint%exchange("derivatives", self%derivatives)
      call checkpoint%exchange("jacobians", self%jacobians)
      call checkpoint%exchange("error_test_failures", self%error_test_failures)
      call checkpoint%exchange("convergence_failures", self%convergence_failures)
      call checkpoint%exchange("last_step", self%last_step)
   end subroutine exchange_statistics

end module contensou_integrate_integrator
