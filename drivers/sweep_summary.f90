!> What a sweep comes to: the table that is made from its journal, and the printed summary.
module contensou_drivers_sweep_summary
   use contensou_sweep_crew, only : stop_requested
   use contensou_base_errors, only : error_type, fatal, status_failed
   use contensou_sweep_journal, only : journal_message_length
   use contensou_base_kinds, only : i8, wp
   use contensou_base_operating_system, only : file_exists, write_stdout
   use contensou_base_text, only : number_text, string_type, to_text
   use contensou_drivers_command_line, only : command_text
   use contensou_drivers_sweep_cases, only : cases_type, threads_text
   use contensou_drivers_sweep_trajectories, only : run_words, trajectories_type
   use contensou_sweep_plan, only : sweep_type
   use contensou_sweep_table, only : case_complete, status_names, sweep_table_type
   use contensou_files_trajectory, only : part_suffix
   implicit none(type, external)
   private

   public :: tally_type, write_table, print_summary

   !> Rows that go into the table at a time.
   integer, parameter :: rows_at_a_time = 4096

   !> End of a line.
   character(len=*), parameter :: nl = new_line("a")

   !> What the cases come to.
   type :: tally_type
      !> Cases by status.
      integer(i8) :: counts(0:size(status_names) - 1) = 0
      !> First case of each status; 0 for none.
      integer(i8) :: first(0:size(status_names) - 1) = 0
      type(string_type) :: message(0:size(status_names) - 1)
   end type tally_type

contains

   !> Make the table from the journal.
   subroutine write_table(name, force, cases, command_line, tally, stopped, error)
      !> Name of the table.
      character(len=*), intent(in) :: name
      !> Whether it may replace an existing file.
      logical, intent(in) :: force
      !> The cases, all done.
      type(cases_type), intent(in) :: cases
      !> Command line, for the table.
      character(len=*), intent(in) :: command_line
      !> What they come to.
      type(tally_type), intent(out) :: tally
      !> Whether a signal came.
      logical, intent(out) :: stopped
      !> Set when it cannot be written.
      type(error_type), allocatable, intent(out) :: error
      type(sweep_table_type) :: table
      type(error_type), allocatable :: append_error
      type(string_type), allocatable :: messages(:)
      character(len=journal_message_length) :: message
      real(wp), allocatable :: results(:, :)
      integer(i8), allocatable :: numbers(:)
      integer, allocatable :: status(:)
      integer(i8) :: position
      integer :: n, length
      logical :: found

      stopped = .false.
      allocate(numbers(rows_at_a_time), status(rows_at_a_time), messages(rows_at_a_time))
      allocate(results(size(cases%sweep%results), rows_at_a_time))
      call table%open(name, force, cases%sweep, cases%selection%text(), command_line, error)
      if (allocated(error)) return
      n = 0
      do position = 1, cases%selection%count()
         n = n + 1
         call cases%journal%read(position, found, numbers(n), status(n), results(:, n), message, &
            length, error)
         if (.not. allocated(error) .and. .not. found) call fatal(error, "the row of case " // &
            to_text(cases%selection%case_at(position)) // " is missing in " // name // &
            part_suffix // "; the same command runs it again", status_failed)
         if (allocated(error)) exit
         messages(n)%s = message(:length)
         call count_case(tally, numbers(n), status(n), messages(n)%s)
         if (n < rows_at_a_time .and. position < cases%selection%count()) cycle
         call table%append(cases%sweep, numbers(:n), status(:n), messages(:n), results(:, :n), &
            append_error)
         n = 0
         if (position < cases%selection%count()) stopped = stop_requested()
         if (stopped .or. allocated(append_error)) exit
      end do
      if (allocated(append_error)) call move_alloc(append_error, error)
      if (stopped .or. allocated(error)) then
         call table%abandon()
      else
         call table%finish(error)
      end if
   end subroutine write_table

   !> Count a case.
   subroutine count_case(tally, number, status, message)
      type(tally_type), intent(inout) :: tally
      !> Number of the case.
      integer(i8), intent(in) :: number
      integer, intent(in) :: status
      character(len=*), intent(in) :: message

      tally%counts(status) = tally%counts(status) + 1
      if (tally%first(status) > 0) return
      tally%first(status) = number
      tally%message(status)%s = message
   end subroutine count_case

   !> Print what the sweep came to.
   subroutine print_summary(name, sweep, tally, trajectories, threads, wall, error)
      !> Name of the table.
      character(len=*), intent(in) :: name
      type(sweep_type), intent(in) :: sweep
      type(tally_type), intent(in) :: tally
      type(trajectories_type), intent(in) :: trajectories
      !> Number of threads.
      integer, intent(in) :: threads
      !> Wall time [s].
      real(wp), intent(in) :: wall
      !> Set when the standard output cannot be written.
      type(error_type), allocatable, intent(out) :: error
      type(string_type), allocatable :: overrides(:), words(:)
      character(len=:), allocatable :: text
      integer :: i, shown
      logical :: is

      text = "sweep of " // sweep%scene_path // nl // "  cases      " // &
         to_text(sum(tally%counts)) // ": " // to_text(tally%counts(case_complete)) // " complete"
      do i = 1, ubound(tally%counts, 1)
         if (tally%counts(i) > 0) text = text // ", " // to_text(tally%counts(i)) // " " // &
            words_of(i)
      end do
      text = text // nl
      shown = 0
      do i = 1, ubound(tally%counts, 1)
         if (tally%counts(i) == 0) cycle
         if (shown == 0) shown = i
         text = text // "  " // words_of(i) // repeat(" ", max(11 - len(words_of(i)), 1)) // &
            "first case " // to_text(tally%first(i)) // ": " // indented(tally%message(i)%s) // nl
      end do
      if (shown > 0) then
         call sweep%overrides_of(tally%first(shown), overrides)
         call run_words(sweep%scene_path, overrides, "", words)
         text = text // "  to see     /status and /message in " // name // "; case " // &
            to_text(tally%first(shown)) // " alone is" // nl // "             " // &
            command_text(words) // nl
      end if
      do i = 1, size(trajectories%numbers)
         is = file_exists(trajectories%files(i)%s)
         if (is) then
            text = text // "  trajectory " // trajectories%files(i)%s // nl
         else
            text = text // "  trajectory of case " // to_text(trajectories%numbers(i)) // &
               ": none, the case did not complete" // nl
         end if
      end do
      text = text // "  work       " // number_text(wall, 3) // " s wall on " // &
         threads_text(threads) // nl // "  table      " // name // nl
      call write_stdout(text, error)

   contains

      !> A status in words.
      pure function words_of(status) result(name_of_it)
         integer, intent(in) :: status
         character(len=:), allocatable :: name_of_it
         integer :: k

         name_of_it = trim(status_names(status))
         do k = 1, len(name_of_it)
            if (name_of_it(k:k) == "_") name_of_it(k:k) = " "
         end do
      end function words_of

      !> A message, its lines after the first one indented as far as it is.
      pure function indented(message) result(lines)
         character(len=*), intent(in) :: message
         character(len=:), allocatable :: lines
         integer :: k

         lines = ""
         do k = 1, len(message)
            lines = lines // message(k:k)
            if (message(k:k) == nl) lines = lines // repeat(" ", 13)
         end do
      end function indented

   end subroutine print_summary

end module contensou_drivers_sweep_summary
