!> The pair and the weights of explicit8 in a bare loop, one step after the other, with a look at
!> the gap after each step: no output, no events, no interpolation.
module cost_bare_loop
   use contensou_base_kinds, only : wp
   use cost_bare_pair, only : local_error, set_stage, stages, step_stages
   use cost_problem, only : bracket_type, derivative, gap, handle_type, narrow, &
      outcome_type, resolved, trial
   implicit none(type, external)
   private

   public :: integrate_bare

contains

   !> Integrate to the touch or the end.
   subroutine integrate_bare(self, outcome)
      !> The problem; its state becomes that at the end of the last step before the touch.
      type(handle_type), intent(inout), target :: self
      !> What comes of it.
      type(outcome_type), intent(out) :: outcome
      type(bracket_type) :: bracket
      real(wp), allocatable :: y(:), z(:), weight(:), k(:, :)
      real(wp) :: h, estimate, value, start, finish
      integer :: n, i
      logical :: outside

      n = size(self%y)
      y = self%y
      allocate(z(n), weight(n), k(n, stages))
      call cpu_time(start)
      h = 1.0e-6_wp
      value = gap(self, y)
      call derivative(self, outcome%t, y, k(:, 1), outside)
      call self%motion%admissible_error(y, weight)
      weight = 1.0_wp/weight
      do while (outcome%t < self%t_end)
         h = min(h, self%t_end - outcome%t)
         call take_stages(h, outside)
         estimate = 1.0e8_wp
         if (.not. outside) estimate = local_error(n, h, weight, k)
         if (estimate <= 1.0_wp) then
            call set_stage(step_stages, n, h, y, k, z)
            outcome%steps = outcome%steps + 1
            bracket%h = [0.0_wp, h]
            bracket%gap = [value, gap(self, z)]
            if (bracket%gap(2) <= 0.0_wp) exit
            outcome%t = outcome%t + h
            y = z
            value = bracket%gap(2)
            call derivative(self, outcome%t, y, k(:, 1), outside)
            call self%motion%admissible_error(y, weight)
            weight = 1.0_wp/weight
         end if
         h = h*min(max(0.9_wp*max(estimate, 1.0e-10_wp)**(-0.125_wp), 0.1_wp), 6.0_wp)
      end do
      if (bracket%gap(2) <= 0.0_wp) then
         outcome%touched = .true.
         i = 0
         do while (.not. resolved(bracket, outcome%t) .and. i < 100)
            i = i + 1
            h = trial(bracket, i)
            call take_stages(h, outside)
            call set_stage(step_stages, n, h, y, k, z)
            call narrow(bracket, h, gap(self, z))
         end do
         outcome%t = outcome%t + bracket%h(2)
      end if
      call cpu_time(finish)
      outcome%cpu = finish - start
      self%y = y

   contains

      !> Stages 2 to 13 of a step.
      subroutine take_stages(length, left)
         !> Length of the step [s].
         real(wp), intent(in) :: length
         !> Whether a stage is outside the domain of the model.
         logical, intent(out) :: left
         integer :: stage

         do stage = 2, step_stages - 1
            call set_stage(stage, n, length, y, k, z)
            call derivative(self, outcome%t, z, k(:, stage), left)
            if (left) exit
         end do
      end subroutine take_stages

   end subroutine integrate_bare

end module cost_bare_loop
