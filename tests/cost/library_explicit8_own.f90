!> explicit8 itself, with its events, without what the executable puts around it.
module library_explicit8_own
   use contensou_base_errors, only : error_type
   use contensou_base_kinds, only : wp
   use contensou_integrate_explicit8, only : explicit8_type
   use contensou_integrate_integrator, only : statistics_type
   use cost_problem, only : handle_type, outcome_type
   implicit none(type, external)
   private

   public :: integrate_own

contains

   !> Integrate to the touch.
   subroutine integrate_own(self, outcome, calls, message)
      !> The problem.
      type(handle_type), intent(inout), target :: self
      !> What comes of it.
      type(outcome_type), intent(out) :: outcome
      !> Calls of the right-hand side.
      integer, intent(out) :: calls
      !> Set when it fails.
      character(len=:), allocatable, intent(out) :: message
      type(explicit8_type) :: integrator
      type(statistics_type) :: counters
      type(error_type), allocatable :: error
      real(wp), allocatable :: y(:)
      integer, allocatable :: events(:)
      real(wp) :: start, finish

      y = self%y
      allocate(events(self%motion%n_events), source=0)
      call cpu_time(start)
      call integrator%start(self%motion, "explicit8", 0.0_wp, y, self%t_end, 0.0_wp, error)
      do while (outcome%t < self%t_end .and. events(self%contact) >= 0)
         call integrator%step(outcome%t, y, events, error)
         if (allocated(error)) exit
      end do
      call cpu_time(finish)
      outcome%cpu = finish - start
      outcome%touched = events(self%contact) < 0
      counters = integrator%statistics()
      outcome%steps = int(counters%steps)
      calls = int(counters%derivatives)
      call integrator%free()
      if (allocated(error)) message = error%message
   end subroutine integrate_own

end module library_explicit8_own
