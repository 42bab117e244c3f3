!> What contacts with tangential elasticity remember, which changes with an accepted step: the step
!> is taken again, in smaller ones, where the memory would differ with it.
module contensou_integrate_history
   use contensou_base_errors, only : error_type
   use contensou_base_kinds, only : wp
   use contensou_integrate_step, only : march_type
   implicit none(type, external)
   private

   public :: doubt_memory, remember

   !> Deviation of a step that is admitted, over the root of the relative tolerance.
   real(wp), parameter :: admitted = 1.0_wp

   !> Part of the step that would just do, and the smallest and the largest change of a step.
   real(wp), parameter :: cautious = 0.7_wp, shrinking = 0.1_wp, growing = 4.0_wp

   !> Step that is not taken again, in units of the rounding of the time.
   real(wp), parameter :: shortest = 64.0_wp

contains

   !> See whether the step is to be taken again, for the sake of what the contacts are to remember.
   subroutine doubt_memory(self, again, error)
      type(march_type), intent(inout) :: self
      !> Whether the march is at the beginning of the step again.
      logical, intent(out) :: again
      !> Set when the integration cannot go on there.
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: time_step, deviation, largest, bound
      integer :: i

      again = .false.
      associate (system => self%motion%system, memory => self%memory, t => self%memory%t)
         time_step = t - self%t_before
         call system%evaluate_memory(memory%t, memory%y)
         largest = 0.0_wp
         do i = 1, size(system%contacts)
            if (.not. allocated(system%contacts(i)%tangential)) cycle
            call system%contacts(i)%tangential%deviate(time_step, deviation)
            largest = max(largest, deviation)
         end do
         bound = admitted*sqrt(self%motion%scales%rtol)
         self%next_step = time_step*cautious*sqrt(bound/max(largest, tiny(largest)))
         again = largest > bound .and. time_step > shortest*spacing(t)
         if (.not. again) return
         call self%integrator%bound_step(max(self%next_step, shrinking*time_step))
         self%bounded = .true.
         t = self%t_before
         memory%y = self%y_before
         where (self%seen) self%gap = self%gap_before
         self%clearance = 0.0_wp
         call self%integrator%restart(t, memory%y, error)
      end associate
   end subroutine doubt_memory

   !> Let the contacts remember the step, and bound the next one.
   subroutine remember(self)
      type(march_type), intent(inout) :: self
      real(wp) :: time_step, bound
      integer :: i

      associate (system => self%motion%system, memory => self%memory)
         call system%evaluate_memory(memory%t, memory%y)
         do i = 1, size(system%contacts)
            if (allocated(system%contacts(i)%tangential)) call system%contacts(i)%tangential%keep()
         end do
         ! Bounds for the sake of gaps are lifted elsewhere.
         if (memory%bounded_until > 0.0_wp) return
         time_step = memory%t - self%t_before
         bound = min(self%next_step, growing*time_step)
         if (self%plan%max_step > 0.0_wp) bound = min(bound, self%plan%max_step)
         if (self%next_step < growing*time_step) then
            call self%integrator%bound_step(bound)
            self%bounded = .true.
         else if (self%bounded) then
            if (bound > self%plan%t_end) bound = self%plan%max_step
            call self%integrator%bound_step(bound)
            self%bounded = bound < self%plan%t_end .and. bound > 0.0_wp
         end if
      end associate
   end subroutine remember

end module contensou_integrate_history
