!> Errors of the rungs of `contensou bench kernels` against the reference.
module contensou_drivers_bench_errors
   use, intrinsic :: ieee_arithmetic, only : ieee_is_nan, ieee_quiet_nan, ieee_value
   use contensou_base_kinds, only : wp
   use contensou_base_operating_system, only : wall_seconds
   use contensou_drivers_bench_baselines, only : boost_ke
   use contensou_drivers_bench_curved, only : curved_reference
   use contensou_drivers_bench_reference, only : new_rule, qp, reference_elliptic, &
      reference_hertz, reference_wrench, rule_type
   use contensou_contact_hertz, only : hertz_spot_type
   use contensou_contact_wrench, only : slip_type
   use contensou_drivers_bench_suite, only : case_type, kernel_creep, kernel_creep_jacobian, &
      kernel_curved, kernel_elliptic, kernel_hertz, kernel_jacobian, kernel_ke, kernel_log, &
      kernel_tangential, kernel_wrench, max_results, motion_of, n_arguments, rung_type, &
      suite_type, way_boost_ke, way_creep, way_creep_jacobian, way_elliptic, way_fixed_hertz, &
      way_gsl_ke, way_hertz, way_tables_ke, way_wrench
   use contensou_drivers_bench_tangential, only : follow_history, most_layers
   use contensou_special_elliptic, only : complete_elliptic
   use contensou_special_gsl, only : gsl_complete_ke
   implicit none(type, external)
   private

   public :: check_errors

   !> Kernels whose arguments are those of the one before.
   integer, parameter :: same_arguments(3) = [kernel_ke, kernel_jacobian, kernel_creep_jacobian]

contains

   !> Errors of all rungs against the reference.
   subroutine check_errors(suite, quick)
      type(suite_type), intent(inout), target :: suite
      !> Whether few arguments are to do.
      logical, intent(in) :: quick
      type(case_type), pointer :: c
      real(wp), allocatable :: errors(:, :)
      real(wp) :: results(max_results), history(3, n_arguments)
      integer :: i, j, n, n_quantities

      call fill_references(suite, quick)
      do i = 1, size(suite%rungs)
         associate (rung => suite%rungs(i))
            c => suite%cases(rung%place)
            if (c%kernel == kernel_log) cycle
            n_quantities = quantity_count(c%kernel)
            if (rung%is_reference) then
               rung%error_max = ieee_value(rung%error_max, ieee_quiet_nan)
               rung%error_median = rung%error_max
               rung%seconds = c%reference_seconds
               cycle
            end if
            allocate(errors(c%checked, n_quantities))
            n = 0
            if (c%kernel == kernel_tangential) call follow_history(rung%layers, c%shape, &
               c%arguments(1:3, :c%checked), history)
            do j = 1, c%checked
               if (c%kernel == kernel_tangential) then
                  results = 0.0_wp
                  results(:3) = history(:, j)
               else
                  call evaluate(rung, c, j, results)
               end if
               if (any(ieee_is_nan(results))) cycle
               n = n + 1
               errors(n, :) = errors_of(c, j, results, n_quantities)
            end do
            rung%misses = c%checked - n
            do j = 1, n_quantities
               if (n > 0) then
                  call sort(errors(:n, j))
                  rung%error_max(j) = errors(n, j)
                  rung%error_median(j) = 0.5_wp*(errors((n + 1)/2, j) + errors(n/2 + 1, j))
               else
                  rung%error_max(j) = ieee_value(rung%error_max(j), ieee_quiet_nan)
                  rung%error_median(j) = rung%error_max(j)
               end if
            end do
            deallocate(errors)
         end associate
      end do
   end subroutine check_errors

   !> The references of all cases.
   subroutine fill_references(suite, quick)
      type(suite_type), intent(inout) :: suite
      !> Whether few arguments are to do.
      logical, intent(in) :: quick
      type(rule_type) :: rule
      real(qp) :: wrench(3), jacobian(3, 3)
      real(wp) :: exact(3), history(3, n_arguments), start
      integer :: i, j

      rule = new_rule()
      do i = 1, size(suite%cases)
         associate (c => suite%cases(i))
            if (c%kernel == kernel_log) cycle
            c%checked = n_arguments
            if (quick) c%checked = 256
            if (any(c%kernel == [kernel_wrench, kernel_jacobian, kernel_curved])) c%checked &
               = c%checked/4
            ! Boundary elements take a tenth of a second.
            if (any(c%kernel == [kernel_creep, kernel_creep_jacobian])) then
               c%checked = max(c%checked/256, 2)
            end if
            ! The reference has many layers.
            if (c%kernel == kernel_tangential) c%checked = c%checked/8
            allocate(c%reference(max_results, c%checked))
            if (c%kernel == kernel_tangential) then
               call follow_history(most_layers, c%shape, c%arguments(1:3, :c%checked), history)
               c%reference = 0.0_qp
               c%reference(:3, :) = real(history(:, :c%checked), qp)
               cycle
            end if
            if (any(c%kernel == same_arguments)) cycle
            start = wall_seconds()
            do j = 1, c%checked
               associate (x => c%arguments(:, j), results => c%reference(:, j))
                  results = 0.0_qp
                  select case (c%kernel)
                  case (kernel_elliptic)
                     results(:6) = reference_elliptic(real(x(1), qp))
                  case (kernel_hertz)
                     results(:5) = reference_hertz(x(1), x(2), x(3), x(4))
                  case (kernel_curved)
                     call curved_reference(c%shape, slip_type(x(1), x(2), x(3)), exact)
                     results(:3) = real(exact, qp)
                  case (kernel_creep)
                     call c%laws(c%reference_law)%creep%kernel(c%spot, motion_of(c, x(:3)), &
                        exact)
                     results(:3) = real(exact, qp)
                  case default
                     call reference_wrench(rule, c%ratio, x(1), x(2), x(3), wrench, jacobian)
                     results = [wrench, reshape(jacobian, [9])]
                  end select
               end associate
            end do
            c%reference_seconds = (wall_seconds() - start)/c%checked
         end associate
      end do
      ! The arguments are those of the case of the same name.
      do i = 1, size(suite%cases)
         if (all(suite%cases(i)%kernel /= same_arguments)) cycle
         do j = 1, i - 1
            if (suite%cases(j)%kernel == suite%cases(i)%kernel - 1 .and. &
               suite%cases(j)%name == suite%cases(i)%name) then
               suite%cases(i)%reference = suite%cases(j)%reference
            end if
         end do
      end do
   end subroutine fill_references

   !> Number of quantities whose errors are told: as many as `quantities_of` names.
   pure integer function quantity_count(kernel)
      integer, intent(in) :: kernel
      integer, parameter :: counts(10) = [0, 6, 2, 5, 3, 4, 3, 2, 2, 2]

      quantity_count = counts(kernel)
   end function quantity_count

   !> Results of a rung for one argument.
   subroutine evaluate(rung, c, j, results)
      type(rung_type), intent(in) :: rung
      type(case_type), intent(in) :: c
      !> Number of the argument.
      integer, intent(in) :: j
      !> Results in the order of the reference; zero beyond those that the kernel has.
      real(wp), intent(out) :: results(max_results)
      type(hertz_spot_type) :: spot
      real(wp) :: jacobian(3, 3), slopes(3, 5)
      logical :: found

      results = 0.0_wp
      associate (x => c%arguments(:, j), r => results)
         select case (rung%way)
         case (way_elliptic)
            call rung%elliptic(x(1), r(1), r(2), r(3), r(4), r(5), r(6))
         case (way_tables_ke)
            call complete_elliptic(x(1), r(1), r(2))
         case (way_boost_ke)
            call boost_ke(x(1), r(1), r(2))
         case (way_gsl_ke)
            call gsl_complete_ke(sqrt(1.0_wp - x(1)), r(1), r(2), found)
            if (.not. found) r(1) = ieee_value(r(1), ieee_quiet_nan)
         case (way_hertz)
            call rung%hertz(x(1), x(2), x(3), x(4), spot)
            r(:5) = [spot%c1, spot%a, spot%b, spot%force, spot%pressure]
         case (way_fixed_hertz)
            call c%contacts(j)%contact(x(4), spot)
            r(:5) = [spot%c1, spot%a, spot%b, spot%force, spot%pressure]
         case (way_wrench)
            call rung%wrench(c%shape, slip_type(x(1), x(2), x(3)), .true., r(:3))
         case (way_creep)
            call c%laws(rung%law)%creep%kernel(c%spot, motion_of(c, x(:3)), r(:3))
         case (way_creep_jacobian)
            call c%laws(rung%law)%creep%kernel_slopes(c%spot, motion_of(c, x(:3)), r(:3), slopes)
         case default
            call rung%jacobian(c%shape, slip_type(x(1), x(2), x(3)), r(:3), jacobian)
            r(4:) = reshape(jacobian, [9])
         end select
      end associate
   end subroutine evaluate

   !> Errors of the quantities for one argument.
   function errors_of(c, j, results, n_quantities) result(errors)
      type(case_type), intent(in) :: c
      !> Number of the argument.
      integer, intent(in) :: j
      real(wp), intent(in) :: results(max_results)
      integer, intent(in) :: n_quantities
      real(wp) :: errors(n_quantities)
      real(qp) :: differences(max_results)

      associate (reference => c%reference(:, j))
         differences = abs(real(results, qp) - reference)
         select case (c%kernel)
         case (kernel_wrench, kernel_jacobian, kernel_curved)
            errors(1) = real(maxval(differences(1:2)), wp)
            errors(2) = real(differences(3), wp)
            errors(3) = real(differences(3)/abs(reference(3)), wp)
            if (c%kernel == kernel_jacobian) then
               errors(4) = real(maxval(differences(4:))/maxval(abs(reference(4:))), wp)
            end if
         case (kernel_creep, kernel_creep_jacobian, kernel_tangential)
            errors = real([hypot(differences(1), differences(2)), differences(3)], wp)
         case default
            ! In units in the last place of the rounded reference.
            associate (exact => reference(:n_quantities))
               errors = real(differences(:n_quantities)/real(spacing(real(exact, wp)), qp), wp)
            end associate
         end select
      end associate
   end function errors_of

   !> Sort a list in rising order.
   pure subroutine sort(x)
      real(wp), intent(inout) :: x(:)
      real(wp) :: item
      integer :: gap, i, j

      gap = size(x)
      do while (gap > 1)
         gap = max(1, int(0.45_wp*gap))
         do i = gap + 1, size(x)
            item = x(i)
            j = i - gap
            do while (j >= 1)
               if (x(j) <= item) exit
               x(j + gap) = x(j)
               j = j - gap
            end do
            x(j + gap) = item
         end do
      end do
   end subroutine sort

end module contensou_drivers_bench_errors
