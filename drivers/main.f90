!> From the command line to an exit status.
module contensou_drivers_main
   use contensou_base_errors, only : error_type, status_interrupted, status_ok
   use contensou_base_operating_system, only : open_standard_streams, release_signals, &
      restore_signals, write_stderr, write_stdout
   use contensou_drivers_command_line, only : command_line_type, command_line_words, &
      command_type, parse_command_line
   use contensou_drivers_commands, only : all_commands
   implicit none(type, external)
   private

   public :: execute

contains

   !> Do what the command line asks for.
   subroutine execute(status)
      integer, intent(out) :: status
      type(command_type), allocatable :: commands(:)
      type(command_line_type) :: line
      type(error_type), allocatable :: error
      character(len=*), parameter :: nl = new_line("a")

      call restore_signals()
      call open_standard_streams()
      call all_commands(commands)
      call parse_command_line(command_line_words(), commands, line, error)
      if (allocated(error)) then
         call release_signals()
      else if (allocated(line%usage)) then
         call release_signals()
         call write_stdout(line%usage // nl, error)
      else
         associate (command => line%commands(line%command))
            if (.not. command%heeds_signals) call release_signals()
            call command%execute(line, error)
         end associate
      end if
      status = status_ok
      if (.not. allocated(error)) return
      status = error%status
      if (error%message == "") return
      if (status == status_interrupted) then
         call write_stderr("contensou: " // error%message // nl)
      else if (index(error%message, ": error: ") > 0) then
         ! Diagnostics carry their own heading.
         call write_stderr(error%message // nl)
      else
         call write_stderr("error: " // error%message // nl)
      end if
   end subroutine execute

end module contensou_drivers_main
