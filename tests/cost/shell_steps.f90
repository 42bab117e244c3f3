!> The times of docs/tangential.md: steps of all shells of a spot.
!>
!> shell_steps [LAYERS [STEPS]] prints a line for each motion of a circle and of an ellipse with
!> k = 0.5: microseconds of CPU time a step, the best of five runs, and the shells that slip in it.
!> shell_steps LAYERS STEPS MOTION K runs one of them once, for a profiler.
program shell_steps
   use, intrinsic :: iso_fortran_env, only : error_unit
   use contensou, only : shells_type, spot_shape_type, spring_spot_type, wp
   implicit none(type, external)

   !> Shift at which the spot slides is one, as are the limit and the major semi-axis.
   real(wp), parameter :: poisson = 0.3_wp

   !> Steps on the way from one place to the next, of motions that turn.
   integer, parameter :: steps_a_way = 10

   character(len=*), parameter :: motions(*) = [character(len=6) :: "stick", "load", "shift", &
      "twist", "turn", "slide"]

   call run_all()

contains

   !> What the command line says.
   subroutine run_all()
      character(len=16) :: word
      integer :: layers, n, i
      real(wp) :: ratio

      layers = 12
      n = 20000
      if (command_argument_count() > 0) then
         call get_command_argument(1, word)
         read (word, *) layers
      end if
      if (command_argument_count() > 1) then
         call get_command_argument(2, word)
         read (word, *) n
      end if
      if (command_argument_count() > 3) then
         call get_command_argument(4, word)
         read (word, *) ratio
         call get_command_argument(3, word)
         call run_motion(word(:6), ratio, layers, n, 1)
         return
      end if
      write (*, "(a)") "motion     k    us a step   slipping shells"
      do i = 1, size(motions)
         call run_motion(motions(i), 1.0_wp, layers, n, 5)
         call run_motion(motions(i), 0.5_wp, layers, n, 5)
      end do
   end subroutine run_all

   !> Time a motion.
   subroutine run_motion(motion, ratio, layers, n, runs)
      character(len=6), intent(in) :: motion
      !> Axis ratio.
      real(wp), intent(in) :: ratio
      integer, intent(in) :: layers
      !> Number of steps, and of runs of which the best counts.
      integer, intent(in) :: n, runs
      real(wp), allocatable :: steps(:, :), sizes(:)
      real(wp) :: begin, end, best, wrench(3), stored, lost, sum_of_all, modulus
      type(shells_type) :: shells
      type(spring_spot_type) :: spot
      logical :: varies
      integer :: i, run, slips

      allocate(steps(3, n), sizes(n))
      call set_steps(motion, steps, sizes)
      spot%shape = spot_shape_type(ratio)
      spot%a = 1.0_wp
      spot%limit = 1.0_wp
      call spot%stiffen(1.0_wp, poisson)
      modulus = 1.5_wp/spot%stiffness(1)
      call spot%stiffen(modulus, poisson)
      varies = motion == "load"
      best = huge(best)
      sum_of_all = 0.0_wp
      do run = 1, runs
         call shells%begin(layers)
         slips = 0
         call cpu_time(begin)
         do i = 1, n
            if (varies) then
               spot%a = sizes(i)
               spot%limit = sizes(i)**3
               call spot%stiffen(modulus, poisson)
            end if
            call shells%advance(spot, steps(:, i), wrench, stored, lost)
            sum_of_all = sum_of_all + wrench(1)
            slips = slips + count(shells%slipped(:shells%n))
         end do
         call cpu_time(end)
         best = min(best, end - begin)
      end do
      write (*, "(a, f6.2, f13.3, f18.2)") motion, ratio, 1.0e6_wp*best/n, real(slips, wp)/n
      ! So that nothing is left out.
      write (error_unit, "(a, es24.16)", advance="no") char(13), sum_of_all
   end subroutine run_motion

   !> Steps of a motion, and sizes of the spot.
   subroutine set_steps(motion, steps, sizes)
      character(len=6), intent(in) :: motion
      real(wp), intent(out) :: steps(:, :), sizes(:)
      real(wp) :: from(3), to(3), x, sense
      integer :: i, j

      sizes = 1.0_wp
      x = 0.3_wp
      to = 0.0_wp
      do i = 1, size(sizes)
         sense = real(1 - 2*modulo(i, 2), wp)
         select case (motion)
         case ("stick")
            steps(:, i) = sense*[1.0e-3_wp, -2.0e-3_wp, 3.0e-3_wp]
         case ("load")
            steps(:, i) = sense*[1.0e-3_wp, -2.0e-3_wp, 3.0e-3_wp]
            sizes(i) = 1.0_wp + 1.0e-3_wp*sin(0.7_wp*i)
         case ("shift", "twist")
            if (modulo(i - 1, steps_a_way) == 0) then
               from = to
               do j = 1, 3
                  ! The logistic map, whose values are spread evenly by the arc sine.
                  x = 4.0_wp*x*(1.0_wp - x)
                  to(j) = (4.0_wp/acos(-1.0_wp))*asin(sqrt(x)) - 1.0_wp
               end do
               if (motion == "shift") to(3) = 0.0_wp
            end if
            steps(:, i) = (to - from)/steps_a_way
         case ("turn")
            steps(:, i) = 0.3_wp*[cos(0.1_wp*i), sin(0.1_wp*i), 0.7_wp*sin(0.13_wp*i)]
         case default
            steps(:, i) = [0.3_wp, 0.2_wp, 0.3_wp]
         end select
      end do
   end subroutine set_steps

end program shell_steps
