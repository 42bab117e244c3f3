!> Times of the rungs of `contensou bench kernels`.
!>
!> A batch is one pass of a rung over all arguments of its case, or over those that are compared if
!> a call is long, repeated if that is short. In throughput the calls do not depend on each other;
!> in a chain the next argument takes bits of the last results by way of a mask that is zero, which
!> the compiler does not know. Results are returned through arguments of external procedures or kept
!> in a volatile variable.
module contensou_drivers_bench_times
   use contensou_base_kinds, only : i8, wp
   use contensou_base_operating_system, only : wall_seconds
   use contensou_drivers_bench_baselines, only : boost_ke
   use contensou_contact_hertz, only : hertz_spot_type
   use contensou_contact_wrench, only : slip_type
   use contensou_drivers_bench_suite, only : case_type, motion_of, n_arguments, rung_type, &
      suite_type, way_boost_ke, way_creep, way_creep_jacobian, way_elliptic, way_fixed_hertz, &
      way_gsl_ke, way_hertz, way_log, way_tables_ke, way_tangential, way_wrench
   use contensou_drivers_bench_tangential, only : follow_history
   use contensou_special_elliptic, only : complete_elliptic
   use contensou_special_gsl, only : gsl_complete_ke
   implicit none(type, external)
   private

   public :: measure_times

   !> Shortest batch [s].
   real(wp), parameter :: batch_time = 4.0e-5_wp

   !> A rung whose pass takes longer is measured in one round of so many.
   real(wp), parameter :: slow_pass = 4.0e-4_wp

   !> See `slow_pass`.
   integer, parameter :: slow_stride = 8

   !> Takes results, so that they are computed.
   real(wp), volatile :: sink = 0.0_wp

   !> Bits of the last results that the next argument takes: none.
   integer(i8), volatile :: no_bits = 0_i8

contains

   !> Time all rungs in turn, again and again; of each the shortest batch counts.
   subroutine measure_times(suite, duration, rounds)
      type(suite_type), intent(inout), target :: suite
      !> Time after which no round begins [s].
      real(wp), intent(in) :: duration
      integer, intent(out) :: rounds
      real(wp) :: start, pass_time
      integer :: i, mode
      logical :: slow(2, size(suite%rungs))

      slow = .false.
      ! What a pass takes, the second time: the first one loads tables and libraries.
      do i = 1, size(suite%rungs)
         do mode = 1, 2
            associate (rung => suite%rungs(i))
               if (.not. is_timed(rung, mode)) cycle
               call time_batch(rung, suite%cases(rung%place), mode, pass_time)
               call time_batch(rung, suite%cases(rung%place), mode, pass_time)
               slow(mode, i) = pass_time > slow_pass
               rung%passes(mode) = max(1, ceiling(batch_time/max(pass_time, 1.0e-9_wp)))
            end associate
         end do
      end do
      start = wall_seconds()
      rounds = 0
      do
         do i = 1, size(suite%rungs)
            do mode = 1, 2
               associate (rung => suite%rungs(i))
                  if (.not. is_timed(rung, mode)) cycle
                  if (slow(mode, i) .and. mod(rounds, slow_stride) /= 0) cycle
                  call time_batch(rung, suite%cases(rung%place), mode, pass_time)
                  rung%seconds(mode) = min(rung%seconds(mode), &
                     pass_time/arguments_of(rung, suite%cases(rung%place)))
               end associate
            end do
         end do
         rounds = rounds + 1
         if (wall_seconds() - start > duration) exit
      end do
      do i = 1, size(suite%rungs)
         associate (rung => suite%rungs(i))
            if (rung%is_long) rung%seconds(2) = rung%seconds(1)
         end associate
      end do
   end subroutine measure_times

   !> Whether a rung takes part in a mode.
   pure logical function is_timed(rung, mode)
      type(rung_type), intent(in) :: rung
      !> 1 for throughput, 2 for a chain.
      integer, intent(in) :: mode

      is_timed = .not. rung%is_reference .and. (mode == 1 .or. .not. rung%is_long)
   end function is_timed

   !> Number of arguments of a pass.
   pure integer function arguments_of(rung, c)
      type(rung_type), intent(in) :: rung
      type(case_type), intent(in) :: c

      arguments_of = merge(c%checked, n_arguments, rung%is_long)
   end function arguments_of

   !> Mean wall time of a pass over the arguments of a case.
   subroutine time_batch(rung, c, mode, pass_time)
      type(rung_type), intent(in) :: rung
      type(case_type), intent(in) :: c
      !> 1 for throughput, 2 for a chain.
      integer, intent(in) :: mode
      !> Time of a pass [s].
      real(wp), intent(out) :: pass_time
      real(wp) :: start
      integer :: i

      start = wall_seconds()
      do i = 1, rung%passes(mode)
         if (mode == 1) then
            call pass_in_throughput(rung, c)
         else
            call pass_in_chain(rung, c)
         end if
      end do
      pass_time = (wall_seconds() - start)/rung%passes(mode)
   end subroutine time_batch

   !> Call a rung for all arguments; no call waits for another.
   subroutine pass_in_throughput(rung, c)
      type(rung_type), intent(in) :: rung
      type(case_type), intent(in) :: c
      type(hertz_spot_type) :: spot
      real(wp) :: total, r(6), wrench(3), jacobian(3, 3), slopes(3, 5), history(3, n_arguments)
      integer :: i
      logical :: found

      total = 0.0_wp
      associate (x => c%arguments)
         select case (rung%way)
         case (way_log)
            do i = 1, n_arguments
               total = total + log(x(1, i))
            end do
         case (way_elliptic)
            do i = 1, n_arguments
               call rung%elliptic(x(1, i), r(1), r(2), r(3), r(4), r(5), r(6))
            end do
            total = r(1)
         case (way_tables_ke)
            do i = 1, n_arguments
               call complete_elliptic(x(1, i), r(1), r(2))
               total = total + (r(1) + r(2))
            end do
         case (way_boost_ke)
            do i = 1, n_arguments
               call boost_ke(x(1, i), r(1), r(2))
               total = total + (r(1) + r(2))
            end do
         case (way_gsl_ke)
            do i = 1, n_arguments
               call gsl_complete_ke(sqrt(1.0_wp - x(1, i)), r(1), r(2), found)
               total = total + (r(1) + r(2))
            end do
         case (way_hertz)
            do i = 1, n_arguments
               call rung%hertz(x(1, i), x(2, i), x(3, i), x(4, i), spot)
            end do
            total = spot%force
         case (way_fixed_hertz)
            do i = 1, n_arguments
               call c%contacts(i)%contact(x(4, i), spot)
               total = total + ((spot%a + spot%b) + (spot%force + spot%pressure))
            end do
         case (way_wrench)
            do i = 1, n_arguments
               call rung%wrench(c%shape, slip_type(x(1, i), x(2, i), x(3, i)), .true., wrench)
            end do
            total = wrench(1)
         case (way_creep)
            do i = 1, arguments_of(rung, c)
               call c%laws(rung%law)%creep%kernel(c%spot, motion_of(c, x(:3, i)), wrench)
            end do
            total = wrench(1)
         case (way_creep_jacobian)
            do i = 1, n_arguments
               call c%laws(rung%law)%creep%kernel_slopes(c%spot, motion_of(c, x(:3, i)), wrench, &
                  slopes)
            end do
            total = slopes(1, 1)
         case (way_tangential)
            call follow_history(rung%layers, c%shape, x(1:3, :), history)
            total = history(1, n_arguments)
         case default
            do i = 1, n_arguments
               call rung%jacobian(c%shape, slip_type(x(1, i), x(2, i), x(3, i)), wrench, jacobian)
            end do
            total = jacobian(1, 1)
         end select
      end associate
      sink = total
   end subroutine pass_in_throughput

   !> Call a rung for all arguments; each call waits for the results of the one before.
   subroutine pass_in_chain(rung, c)
      type(rung_type), intent(in) :: rung
      type(case_type), intent(in) :: c
      type(hertz_spot_type) :: spot
      real(wp) :: r(6), wrench(3), jacobian(3, 3), slopes(3, 5), history(3, n_arguments)
      integer(i8) :: mask
      integer :: i
      logical :: found

      mask = no_bits
      r = 0.0_wp
      spot = hertz_spot_type(0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp)
      wrench = 0.0_wp
      jacobian = 0.0_wp
      associate (x => c%arguments)
         select case (rung%way)
         case (way_log)
            do i = 1, n_arguments
               r(1) = log(tied(x(1, i), r(1), r(1), mask))
            end do
         case (way_elliptic)
            do i = 1, n_arguments
               call rung%elliptic(tied(x(1, i), r(2), r(5), mask), r(1), r(2), r(3), r(4), r(5), &
                  r(6))
            end do
         case (way_tables_ke)
            do i = 1, n_arguments
               call complete_elliptic(tied(x(1, i), r(1), r(2), mask), r(1), r(2))
            end do
         case (way_boost_ke)
            do i = 1, n_arguments
               call boost_ke(tied(x(1, i), r(1), r(2), mask), r(1), r(2))
            end do
         case (way_gsl_ke)
            do i = 1, n_arguments
               call gsl_complete_ke(sqrt(1.0_wp - tied(x(1, i), r(1), r(2), mask)), r(1), r(2), &
                  found)
            end do
         case (way_hertz)
            do i = 1, n_arguments
               call rung%hertz(tied(x(1, i), spot%force, spot%pressure, mask), x(2, i), x(3, i), &
                  x(4, i), spot)
            end do
         case (way_fixed_hertz)
            do i = 1, n_arguments
               call c%contacts(i)%contact(tied(x(4, i), spot%force, spot%pressure, mask), spot)
            end do
         case (way_wrench)
            do i = 1, n_arguments
               call rung%wrench(c%shape, slip_type(tied(x(1, i), wrench(1), wrench(3), mask), &
                  x(2, i), x(3, i)), .true., wrench)
            end do
         case (way_creep)
            do i = 1, n_arguments
               call c%laws(rung%law)%creep%kernel(c%spot, motion_of(c, [tied(x(1, i), wrench(1), &
                  wrench(3), mask), x(2:3, i)]), wrench)
            end do
         case (way_creep_jacobian)
            do i = 1, n_arguments
               call c%laws(rung%law)%creep%kernel_slopes(c%spot, motion_of(c, [tied(x(1, i), &
                  wrench(1), wrench(3), mask), x(2:3, i)]), wrench, slopes)
            end do
         case (way_tangential)
            ! What is remembered makes each step wait for the one before.
            call follow_history(rung%layers, c%shape, x(1:3, :), history)
            wrench = history(:, n_arguments)
         case default
            do i = 1, n_arguments
               call rung%jacobian(c%shape, slip_type(tied(x(1, i), wrench(1), jacobian(3, 3), &
                  mask), x(2, i), x(3, i)), wrench, jacobian)
            end do
         end select
      end associate
      sink = r(1) + wrench(1) + spot%force
   end subroutine pass_in_chain

   !> A number that is not known before two others are.
   pure real(wp) function tied(x, first, second, mask)
      real(wp), intent(in) :: x
      !> The first of the others.
      real(wp), intent(in) :: first
      real(wp), intent(in) :: second
      !> Zero.
      integer(i8), intent(in) :: mask

      tied = transfer(ior(transfer(x, 0_i8), iand(ior(transfer(first, 0_i8), &
         transfer(second, 0_i8)), mask)), 0.0_wp)
   end function tied

end module contensou_drivers_bench_times
