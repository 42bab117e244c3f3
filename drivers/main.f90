!> From the command line to an exit status.
module contensou_drivers_main
   use contensou_base_errors, only : error_type, status_interrupted, status_ok
   use contensou_base_operating_system, only : open_standard_streams, write_stderr, write_stdout
   use contensou_base_text, only : string_type
   use contensou_drivers_bench, only : bench_command
   use contensou_drivers_command_line, only : command_line_words, command_type, &
      parse_command_line, usage_text
   use contensou_drivers_cost, only : cost_command
   use contensou_drivers_diff, only : diff_command
   use contensou_drivers_eval, only : eval_command
   use contensou_drivers_inform, only : check_command, help_command, models_command, print_version
   use contensou_drivers_merge, only : merge_command
   use contensou_drivers_run, only : run_command
   use contensou_drivers_sweep, only : sweep_command
   implicit none(type, external)
   private

   public :: execute

contains

   !> Do what the command line asks for.
   subroutine execute(status)
      !> Exit status.
      integer, intent(out) :: status
      type(string_type), allocatable :: words(:)
      type(command_type) :: command
      type(error_type), allocatable :: error

      call open_standard_streams()
      words = command_line_words()
      call parse_command_line(words, command, error)
      if (.not. allocated(error)) then
         select case (command%name)
         case ("run")
            call run_command(command, words, error)
         case ("check")
            call check_command(command, error)
         case ("models")
            call models_command(command, error)
         case ("eval")
            call eval_command(command, error)
         case ("bench")
            call bench_command(command, error)
         case ("cost")
            call cost_command(command, words, error)
         case ("sweep")
            call sweep_command(command, words, error)
         case ("merge")
            call merge_command(command, words, error)
         case ("diff")
            call diff_command(command, status, error)
            if (.not. allocated(error)) return
         case ("help")
            call help_command(command, error)
         case ("usage")
            call write_stdout(usage_text(command%subject) // new_line("a"), error)
         case default
            call print_version(error)
         end select
      end if
      status = status_ok
      if (.not. allocated(error)) return
      status = error%status
      if (status == status_interrupted) then
         call write_stderr("contensou: " // error%message // new_line("a"))
      else if (index(error%message, ": error: ") > 0) then
         ! Diagnostics carry their own heading.
         call write_stderr(error%message // new_line("a"))
      else
         call write_stderr("error: " // error%message // new_line("a"))
      end if
   end subroutine execute

end module contensou_drivers_main
