!> The right-hand side of a scene driven by explicit methods of libraries, and by a bare loop with
!> the pair of explicit8, to the first touch of a contact that is open at the beginning.
!>
!> All are held to the admissible errors of the executable and measured by the same clock.
!>
!>    library_explicit8 SCENE METHOD RTOL CONTACT [SETTING...]
!>
!> METHOD is
!>    gsl_rk8pd        GSL's stepper with its evolution
!>    erkstep          ERKStep with its table of order 8
!>    erkstep_mended   the same without a defect of SUNDIALS before 6.7
!>    erkstep_pair     ERKStep with the pair of explicit8 as a table, without that defect
!>    bare             the pair of explicit8 in a bare loop
!>    explicit8        explicit8 with its events
!>
!> CONTACT names a contact that is open at the beginning; a SETTING is what `contensou run` takes
!> after --set. Prints the time of the first touch and `touch`, or the end of time and `end`;
!> then steps, calls of the right-hand side, and the CPU time of the loop.
program library_explicit8
   use, intrinsic :: iso_fortran_env, only : error_unit, output_unit
   use contensou_base_errors, only : error_type
   use contensou_base_text, only : string_type
   use contensou_scene_reader, only : read_scene, scene_file_type
   use contensou_study_simulation, only : new_simulation, simulation_type
   use cost_bare_loop, only : integrate_bare
   use library_explicit8_gsl, only : integrate_gsl
   use library_explicit8_own, only : integrate_own
   use cost_problem, only : gap, handle_type, outcome_type
   use library_explicit8_sundials, only : integrate_erkstep
   implicit none(type, external)

   call simulate()

contains

   !> From the scene to the touch.
   subroutine simulate()
      type(scene_file_type) :: file
      type(simulation_type) :: simulation
      type(handle_type), target :: handle
      type(outcome_type) :: outcome
      type(error_type), allocatable :: error
      type(string_type), allocatable :: settings(:)
      character(len=:), allocatable :: method, contact, message
      integer :: i

      if (command_argument_count() < 4) call give_up("SCENE METHOD RTOL CONTACT [SETTING...]", 2)
      allocate(settings(command_argument_count() - 2))
      do i = 5, command_argument_count()
         settings(i - 4)%s = argument(i)
      end do
      settings(size(settings) - 1)%s = "integrator.method=explicit8"
      settings(size(settings))%s = "integrator.rtol=" // argument(3)
      call read_scene(argument(1), settings, "", file, error)
      if (.not. allocated(error)) call new_simulation(file, simulation, error)
      if (allocated(error)) call give_up(error%message, 2)
      method = argument(2)
      contact = argument(4)
      handle%motion = simulation%motion
      handle%y = simulation%state()
      handle%t_end = file%scene%t_end
      allocate(handle%gaps(size(file%scene%contacts)))
      do i = 1, size(file%scene%contacts)
         if (file%scene%contacts(i)%name == contact) handle%contact = i
      end do
      if (handle%contact == 0) call give_up("there is no contact " // contact, 2)
      if (gap(handle, handle%y) <= 0.0) call give_up(contact // " is closed at the beginning", 2)

      select case (method)
      case ("bare")
         call integrate_bare(handle, outcome)
      case ("explicit8")
         call integrate_own(handle, outcome, handle%calls, message)
      case ("gsl_rk8pd")
         call integrate_gsl(handle, outcome, message)
      case ("erkstep", "erkstep_mended", "erkstep_pair")
         call integrate_erkstep(handle, method == "erkstep_pair", method /= "erkstep", outcome, &
            message)
      case default
         call give_up("there is no method " // method, 2)
      end select
      if (allocated(message)) call give_up(message, 1)
      write(output_unit, "(es23.16, 1x, a, 2(1x, i0), es13.6)") outcome%t, &
         trim(merge("touch", "end  ", outcome%touched)), outcome%steps, handle%calls, outcome%cpu
   end subroutine simulate

   !> An argument of the command line.
   function argument(number) result(text)
      integer, intent(in) :: number
      character(len=:), allocatable :: text
      integer :: length

      call get_command_argument(number, length=length)
      allocate(character(len=length) :: text)
      call get_command_argument(number, text)
   end function argument

   !> End with a message.
   subroutine give_up(message, status)
      character(len=*), intent(in) :: message
      !> Exit status.
      integer, intent(in) :: status

      write(error_unit, "(a)") "error: " // message
      stop status, quiet=.true.
   end subroutine give_up

end program library_explicit8
