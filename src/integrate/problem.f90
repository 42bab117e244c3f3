!> An initial value problem as the integrators see it.
module contensou_integrate_problem
   use contensou_base_kinds, only : wp
   implicit none(type, external)
   private

   public :: problem_type

   !> y' = f(t, y) with error weights and functions whose zeros are events.
   type, abstract :: problem_type
      !> Number of unknowns.
      integer :: n = 0
      !> Number of event functions.
      integer :: n_events = 0
   contains
      !> Right-hand side.
      procedure(derivative_interface), deferred :: derivative
      !> Event functions.
      procedure(events_interface), deferred :: events
      !> Admissible local error of each unknown.
      procedure(admissible_interface), deferred :: admissible_error
   end type problem_type

   abstract interface
      !> Right-hand side.
      subroutine derivative_interface(self, t, y, rate, outside)
         import :: problem_type, wp
         implicit none(type, external)
         !> The problem.
         class(problem_type), intent(inout) :: self
         !> Time [s].
         real(wp), intent(in) :: t
         !> Unknowns.
         real(wp), intent(in) :: y(:)
         !> Their time derivative.
         real(wp), intent(out) :: rate(:)
         !> Whether the state is outside the domain of the model: a smaller step may help.
         logical, intent(out) :: outside
      end subroutine derivative_interface

      !> Event functions.
      subroutine events_interface(self, t, y, g)
         import :: problem_type, wp
         implicit none(type, external)
         !> The problem.
         class(problem_type), intent(inout) :: self
         !> Time [s].
         real(wp), intent(in) :: t
         !> Unknowns.
         real(wp), intent(in) :: y(:)
         !> Values whose zeros are located.
         real(wp), intent(out) :: g(:)
      end subroutine events_interface

      !> Admissible local error.
      subroutine admissible_interface(self, y, size_of_error)
         import :: problem_type, wp
         implicit none(type, external)
         !> The problem.
         class(problem_type), intent(in) :: self
         !> Unknowns.
         real(wp), intent(in) :: y(:)
         !> Admissible local error of each unknown, > 0.
         real(wp), intent(out) :: size_of_error(:)
      end subroutine admissible_interface
   end interface

end module contensou_integrate_problem
