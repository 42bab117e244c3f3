!>    bare_sweep SWEEP
!>
!> The sweep has one parameter, the friction coefficient of all contacts. Prints the number of
!> right-hand sides of all cases.
program bare_sweep
   use, intrinsic :: iso_fortran_env, only : error_unit, output_unit
   use bare_sweep_witness, only : witness_type
   use contensou_base_errors, only : error_type
   use contensou_base_kinds, only : i8, wp
   use contensou_base_text, only : string_type
   use contensou_dynamics_scene, only : output_spec_type, scene_type
   use contensou_scene_reader, only : read_scene, scene_file_type
   use contensou_study_simulation, only : new_simulation, simulate, simulation_type
   use contensou_sweep_plan, only : sweep_type
   use contensou_sweep_reader, only : read_sweep
   implicit none(type, external)

   call run_all()

contains

   !> From the sweep file to its last case.
   subroutine run_all()
      type(sweep_type) :: sweep
      type(scene_file_type) :: file
      type(string_type) :: words(1)
      type(error_type), allocatable :: error
      character(len=:), allocatable :: path
      real(wp) :: values(1)
      integer(i8) :: i, total
      integer :: length, k

      call get_command_argument(1, length=length)
      allocate(character(len=length) :: path)
      call get_command_argument(1, path)
      call read_sweep(path, [string_type ::], "", sweep, error)
      if (.not. allocated(error)) then
         call read_scene(sweep%scene_path, sweep%overrides, "", file, error)
      end if
      if (allocated(error)) then
         write(error_unit, "(a)") error%message
         stop 2, quiet=.true.
      end if
      total = 0
      do i = 1, sweep%n_cases
         call sweep%parameters_of(i, values, words)
         do k = 1, size(file%scene%contacts)
            call file%scene%contacts(k)%parameters%set("friction_coefficient", values(1))
         end do
         total = total + evaluations(file%scene)
      end do
      write(output_unit, "(i0)") total
   end subroutine run_all

   !> Right-hand sides of a case.
   function evaluations(scene) result(count)
      type(scene_type), intent(in) :: scene
      integer(i8) :: count
      type(simulation_type) :: simulation
      type(witness_type) :: witness
      type(error_type), allocatable :: error

      call new_simulation(scene, simulation, error)
      call witness%row%prepare(simulation%motion%system, output_spec_type())
      if (.not. allocated(error)) call simulate(simulation, witness, error)
      if (allocated(error)) then
         write(error_unit, "(a)") error%message
         stop 1, quiet=.true.
      end if
      count = simulation%memory%statistics%derivatives
   end function evaluations

end program bare_sweep
