!> `contensou diff`: compare two output files.
!>
!> The work is done by a worker process, because HDF5 can crash, hang or take all memory over a
!> damaged file. Exit status: 0 same, 1 different, 2 trouble of any kind.
module contensou_drivers_diff
   use contensou_base_errors, only : error_type, fatal, status_failed, status_ok, status_usage
   use contensou_base_guard, only : finish_guard, start_guard, wait_for_worker
   use contensou_base_kinds, only : wp
   use contensou_base_operating_system, only : write_stderr, write_stdout
   use contensou_base_text, only : string_type
   use contensou_drivers_command_line, only : command_type
   use contensou_compare_comparison, only : comparison_output_type, comparison_type
   use contensou_compare_rules, only : built_in_rules, read_rules
   implicit none(type, external)
   private

   public :: diff_command

   !> Results on stdout, trouble on stderr.
   type, extends(comparison_output_type) :: terminal_output_type
      !> Whether results are not wanted.
      logical :: quiet = .false.
      !> Why stdout takes no more.
      type(error_type), allocatable :: error
   contains
      procedure :: line => write_line
      procedure :: trouble => write_trouble
   end type terminal_output_type

   !> Memory that the worker may use [bytes].
   real(wp), parameter :: memory = 1073741824.0_wp

contains

   !> Compare two files.
   subroutine diff_command(command, status, error)
      !> What the user asks for.
      type(command_type), intent(in) :: command
      !> Exit status when no error is set.
      integer, intent(out) :: status
      !> Set when there is trouble.
      type(error_type), allocatable, intent(out) :: error

      type(comparison_type) :: comparison
      character(len=:), allocatable :: place, reason, output
      logical :: is_worker, finished, inside

      status = status_ok
      call built_in_rules(command%has_until, comparison%rules)
      if (command%rules /= "") call read_rules(command%rules, comparison%rules, error)
      if (.not. allocated(error)) call start_guard(memory, is_worker, error)
      if (allocated(error)) then
         error%status = status_usage
         return
      end if
      if (is_worker) then
         call compare(command, comparison, status)
         call finish_guard(status)
      end if
      call wait_for_worker(finished, status, inside, place, reason, output)
      if (finished) then
         call write_stderr(output)
      else if (inside) then
         call fatal(error, "cannot read " // place // ": the HDF5 library failed (" // reason // &
            "); this file or the other one is damaged", status_usage)
      else
         call write_stderr(output)
         call fatal(error, "the comparison failed after reading " // place // " (" // reason // &
            "): the file is damaged, or this is a mistake in the program", status_usage)
      end if
   end subroutine diff_command

   !> Compare two files in the worker.
   subroutine compare(command, comparison, status)
      !> What the user asks for.
      type(command_type), intent(in) :: command
      !> The comparison with its rules.
      type(comparison_type), intent(inout) :: comparison
      !> Exit status.
      integer, intent(out) :: status

      type(terminal_output_type), target :: output
      type(error_type), allocatable :: error
      type(string_type) :: paths(2)

      paths(1)%s = command%subject
      paths(2)%s = command%input
      output%quiet = command%quiet
      comparison%has_until = command%has_until
      comparison%until = command%until
      call comparison%run(paths, output, error)
      if (.not. allocated(error) .and. allocated(output%error)) then
         call move_alloc(output%error, error)
      end if
      if (allocated(error)) then
         call write_stderr("error: " // error%message // new_line("a"))
         status = status_usage
      else if (comparison%n_trouble > 0) then
         status = status_usage
      else if (comparison%different()) then
         status = status_failed
      else
         status = status_ok
      end if
   end subroutine compare

   !> Write a line of results.
   subroutine write_line(self, text)
      !> Where it goes.
      class(terminal_output_type), intent(inout) :: self
      !> The line.
      character(len=*), intent(in) :: text

      if (self%quiet .or. self%broken) return
      call write_stdout(text // new_line("a"), self%error)
      self%broken = allocated(self%error)
   end subroutine write_line

   !> Write a message about what could not be compared.
   subroutine write_trouble(self, text)
      !> Where it goes.
      class(terminal_output_type), intent(inout) :: self
      !> The message.
      character(len=*), intent(in) :: text

      call write_stderr("error: " // text // new_line("a"))
   end subroutine write_trouble

end module contensou_drivers_diff
