!> The cases of a sweep as pieces of work for a crew: each ends as a row of a journal, and the
!> journal becomes the table.
module contensou_sweep_cases
   use, intrinsic :: ieee_arithmetic, only : ieee_quiet_nan, ieee_value
   use contensou_base_errors, only : error_type, fatal, status_failed, status_usage
   use contensou_base_kinds, only : i8, wp
   use contensou_base_numbers, only : number_text, to_text
   use contensou_base_text, only : string_type
   use contensou_base_operating_system, only : free_bytes, lock_suffix, longest_temporary
   use contensou_base_output_path, only : check_output_path
   use contensou_files_earlier, only : companions
   use contensou_files_trajectory, only : part_suffix
   use contensou_study_case, only : outline_type
   use contensou_sweep_case, only : run_case
   use contensou_sweep_crew, only : job_type, piece_stopped, stop_requested
   use contensou_sweep_journal, only : journal_bytes, journal_message_length, journal_type
   use contensou_sweep_plan, only : sweep_type
   use contensou_sweep_selection, only : named, selection_type
   use contensou_sweep_table, only : case_crashed, case_too_long, status_names, sweep_table_type
   implicit none(type, external)
   private

   public :: cases_type, tally_type, write_table, check_output_paths

   !> The cases as pieces of work for a crew.
   type, extends(job_type) :: cases_type
      type(sweep_type), pointer :: sweep => null()
      type(selection_type) :: selection
      !> Where its columns come from.
      type(outline_type) :: outline
      !> Where rows go.
      type(journal_type) :: journal
   contains
      procedure :: work => work_case
      procedure :: done => done_case
      procedure :: lost => lost_case
      procedure :: look => look_cases
   end type cases_type

   !> Rows that go into the table at a time.
   integer, parameter :: rows_at_a_time = 4096

   !> What the cases come to.
   type :: tally_type
      !> Cases by status.
      integer(i8) :: counts(0:size(status_names) - 1) = 0
      !> First case of each status; 0 for none.
      integer(i8) :: first(0:size(status_names) - 1) = 0
      type(string_type) :: message(0:size(status_names) - 1)
   end type tally_type

contains

   !> See that the files of a sweep can be written under their names, and that the disk can hold
   !> the rows of its cases.
   subroutine check_output_paths(name, sweep, selection, force, error)
      !> Name of the table.
      character(len=*), intent(in) :: name
      type(sweep_type), intent(in) :: sweep
      type(selection_type), intent(in) :: selection
      !> Whether existing files are replaced.
      logical, intent(in) :: force
      !> Set when the sweep must not begin.
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: beside(*) = [character(len=24) :: part_suffix, lock_suffix, &
         longest_temporary]
      type(string_type), allocatable :: inputs(:)
      real(wp) :: wanted, free
      integer :: i

      inputs = sweep%inputs()
      call check_output_path(name, "table", inputs, beside, force, error)
      do i = 1, size(sweep%trajectories)
         if (allocated(error)) return
         if (selection%position_of(sweep%trajectories(i)) == 0) cycle
         call check_output_path(named(sweep%output, "_case_" // to_text(sweep%trajectories(i))), &
            "trajectory", inputs, companions, force, error)
      end do
      if (allocated(error)) return
      wanted = real(selection%count(), wp)*journal_bytes(size(sweep%results))
      free = free_bytes(name // part_suffix)
      if (wanted > free) call fatal(error, "the rows of " // to_text(selection%count()) // &
         " cases take " // number_text(1.0e-9_wp*wanted, 3) // " GB in " // name // part_suffix // &
         ", and " // number_text(1.0e-9_wp*free, 3) // " GB are free there; fewer cases, " // &
         "parts of them by --shard or --cases, or -o FILE on another disk", status_usage)
   end subroutine check_output_paths

   !> Run a case in a thread of the worker.
   subroutine work_case(self, thread, piece, code)
      class(cases_type), intent(in) :: self
      integer, intent(in) :: thread
      !> Position of the case.
      integer(i8), intent(in) :: piece
      !> `piece_done`, `piece_stopped` or a value of errno.
      integer, intent(out) :: code
      real(wp) :: results(size(self%sweep%results))
      character(len=:), allocatable :: message
      integer(i8) :: number
      integer :: status
      logical :: stopped

      number = self%selection%case_at(piece)
      call run_case(self%sweep, self%outline, number, thread, results, status, message, stopped)
      code = piece_stopped
      if (.not. stopped) call self%journal%write(piece, number, status, results, message, code)
   end subroutine work_case

   !> Whether the row of a case is in the journal.
   logical function done_case(self, piece)
      class(cases_type), intent(in) :: self
      !> Position of the case.
      integer(i8), intent(in) :: piece

      done_case = self%journal%has(piece)
   end function done_case

   !> Write the row of a case that never ended.
   subroutine lost_case(self, piece, late, reason, code)
      class(cases_type), intent(inout) :: self
      !> Position of the case.
      integer(i8), intent(in) :: piece
      !> Whether it did not end in time.
      logical, intent(in) :: late
      !> How its process died.
      character(len=*), intent(in) :: reason
      !> 0, or a value of errno.
      integer, intent(out) :: code
      real(wp) :: results(size(self%sweep%results))

      results = ieee_value(results, ieee_quiet_nan)
      if (late) then
         call self%journal%write(piece, self%selection%case_at(piece), case_too_long, results, &
            "given up without an answer after " // number_text(self%sweep%time_limit, 4) // &
            " s of wall time", code)
      else
         call self%journal%write(piece, self%selection%case_at(piece), case_crashed, results, &
            "the program crashed: " // reason, code)
      end if
   end subroutine lost_case

   !> Show nothing.
   subroutine look_cases(self, finished)
      class(cases_type), intent(inout) :: self
      !> Cases that were run by now.
      integer(i8), intent(in) :: finished
   end subroutine look_cases

   !> Make the table from the journal.
   subroutine write_table(name, force, cases, command_line, tally, stopped, error)
      character(len=*), intent(in) :: name
      !> Whether it may replace an existing file.
      logical, intent(in) :: force
      !> The cases, all done.
      class(cases_type), intent(in) :: cases
      !> Command line, for the table.
      character(len=*), intent(in) :: command_line
      type(tally_type), intent(out) :: tally
      !> Whether a signal came.
      logical, intent(out) :: stopped
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

   !> Count a case by its status, and keep the message of the first with each.
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

end module contensou_sweep_cases
