!> Evaluates the right-hand side of a scene many times at its initial state, and does nothing else:
!> counted by an instruction-level profiler, two runs differ by the cost of the evaluations.
!>
!>    rhs_probe SCENE COUNT
program rhs_probe
   use, intrinsic :: iso_fortran_env, only : error_unit, output_unit
   use contensou_base_errors, only : error_type
   use contensou_base_kinds, only : wp
   use contensou_base_text, only : string_type
   use contensou_scene_reader, only : read_scene, scene_file_type
   use contensou_study_simulation, only : new_simulation, simulation_type
   implicit none(type, external)
   type(scene_file_type) :: file
   type(simulation_type) :: simulation
   type(error_type), allocatable :: error
   type(string_type) :: overrides(0)
   real(wp), allocatable :: y(:), rate(:)
   real(wp) :: t
   character(len=:), allocatable :: path
   character(len=32) :: digits
   integer :: length, count, status, i

   call get_command_argument(1, length=length)
   allocate(character(len=length) :: path)
   call get_command_argument(1, path)
   call get_command_argument(2, digits)
   read(digits, *, iostat=status) count
   if (status /= 0 .or. length == 0) then
      write(error_unit, "(a)") "usage: rhs_probe SCENE COUNT"
      stop 2, quiet=.true.
   end if
   call read_scene(path, overrides, "", file, error)
   if (.not. allocated(error)) call new_simulation(file, simulation, error)
   if (allocated(error)) then
      write(error_unit, "(a)") error%message
      stop 2, quiet=.true.
   end if
   y = simulation%state()
   ! Not a constant, for which the compiler would make a right-hand side of its own.
   t = simulation%time()
   allocate(rate(size(y)))
   rate = 0.0_wp
   associate (system => simulation%motion%system)
      where (system%contacts%rigid) system%contacts%closed = .true.
      do i = 1, count
         call system%derivative(t, y, rate)
      end do
   end associate
   write(output_unit, "(*(es24.16))") rate
end program rhs_probe
