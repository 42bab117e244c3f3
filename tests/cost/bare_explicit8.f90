!> The right-hand side of a scene driven by the pair of explicit8 in a bare loop to the end. What
!> the executable needs beyond this is its own.
!>
!>    bare_explicit8 SCENE
!>
!> Prints the number of steps, the final height of the first body and the CPU time of the loop.
program bare_explicit8
   use, intrinsic :: iso_fortran_env, only : error_unit, output_unit
   use contensou_base_errors, only : error_type
   use contensou_base_text, only : string_type
   use contensou_scene_reader, only : read_scene, scene_file_type
   use contensou_study_simulation, only : new_simulation, simulation_type
   use cost_bare_loop, only : integrate_bare
   use cost_problem, only : handle_type, outcome_type
   implicit none(type, external)

   call simulate()

contains

   !> From the scene to the end of its time.
   subroutine simulate()
      type(scene_file_type) :: file
      type(simulation_type) :: simulation
      type(handle_type), target :: handle
      type(outcome_type) :: outcome
      type(error_type), allocatable :: error
      type(string_type) :: overrides(0)
      character(len=:), allocatable :: path
      integer :: length

      call get_command_argument(1, length=length)
      allocate(character(len=length) :: path)
      call get_command_argument(1, path)
      call read_scene(path, overrides, "", file, error)
      if (.not. allocated(error)) call new_simulation(file, simulation, error)
      if (allocated(error)) then
         write(error_unit, "(a)") error%message
         stop 2, quiet=.true.
      end if
      handle%motion = simulation%motion
      handle%y = simulation%state()
      handle%t_end = file%scene%t_end
      call integrate_bare(handle, outcome)
      write(output_unit, "(i0, 2es25.16)") outcome%steps, handle%y(3), outcome%cpu
   end subroutine simulate

end program bare_explicit8
