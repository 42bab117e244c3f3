!> The right-hand side of a scene driven by the pair of explicit8 in a bare loop: the same pair and
!> weights as the executable, one step after the other to the end; no output, no events, no
!> interpolation. What the executable needs beyond this is its own.
!>
!>    bare_explicit8 SCENE
!>
!> Prints the number of steps, the final height of the first body and the CPU time of the loop.
program bare_explicit8
   use, intrinsic :: iso_fortran_env, only : error_unit, output_unit
   use contensou_base_errors, only : error_type
   use contensou_base_kinds, only : wp
   use contensou_base_text, only : string_type
   use contensou_dynamics_assembly, only : assemble, initial_state
   use contensou_integrate_motion, only : motion_type, set_up_motion
   use contensou_integrate_prince_dormand, only : local_error, set_stage, stages, step_stages
   use contensou_io_scene_reader, only : read_scene, scene_file_type
   implicit none(type, external)

   call simulate()

contains

   !> From the scene to the end of its time.
   subroutine simulate()
      type(scene_file_type) :: file
      type(motion_type), target :: motion
      type(error_type), allocatable :: error
      type(string_type) :: overrides(0)
      real(wp), allocatable :: y(:), z(:), weight(:), k(:, :)
      character(len=:), allocatable :: path
      real(wp) :: t, h, estimate, start, finish
      integer :: length, steps, i
      logical :: outside

      call get_command_argument(1, length=length)
      allocate(character(len=length) :: path)
      call get_command_argument(1, path)
      call read_scene(path, overrides, "", file, error)
      if (allocated(error)) then
         write(error_unit, "(a)") error%message
         stop 2, quiet=.true.
      end if
      call assemble(file%scene, motion%system)
      y = initial_state(file%scene, motion%system%n)
      call set_up_motion(motion, file%scene, y)
      allocate(z(motion%n), weight(motion%n), k(motion%n, stages))

      call cpu_time(start)
      t = 0.0_wp
      h = 1.0e-6_wp
      steps = 0
      call motion%derivative(t, y, k(:, 1), outside)
      call motion%admissible_error(y, weight)
      weight = 1.0_wp/weight
      do while (t < file%scene%t_end)
         h = min(h, file%scene%t_end - t)
         do i = 2, step_stages - 1
            call set_stage(i, motion%n, h, y, k, z)
            call motion%derivative(t, z, k(:, i), outside)
            if (outside) exit
         end do
         estimate = 1.0e8_wp
         if (.not. outside) estimate = local_error(motion%n, h, weight, k)
         if (estimate <= 1.0_wp) then
            call set_stage(step_stages, motion%n, h, y, k, z)
            t = t + h
            y = z
            steps = steps + 1
            call motion%derivative(t, y, k(:, 1), outside)
            call motion%admissible_error(y, weight)
            weight = 1.0_wp/weight
         end if
         h = h*min(max(0.9_wp*max(estimate, 1.0e-10_wp)**(-0.125_wp), 0.1_wp), 6.0_wp)
      end do
      call cpu_time(finish)
      write(output_unit, "(i0, 2es25.16)") steps, y(3), finish - start
   end subroutine simulate

end program bare_explicit8
