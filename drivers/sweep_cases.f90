!> The cases of a sweep as pieces of work for a crew: each ends as a row of a journal, and a bar or
!> words on stderr tell how far they are.
module contensou_drivers_sweep_cases
   use, intrinsic :: ieee_arithmetic, only : ieee_quiet_nan, ieee_value
   use contensou_sweep_crew, only : job_type, piece_stopped
   use contensou_sweep_journal, only : journal_type
   use contensou_base_kinds, only : i8, wp
   use contensou_base_text, only : number_text, to_text
   use contensou_drivers_progress, only : progress_type
   use contensou_study_case, only : outline_type
   use contensou_sweep_case, only : run_case
   use contensou_sweep_selection, only : selection_type
   use contensou_sweep_plan, only : sweep_type
   use contensou_sweep_table, only : case_crashed, case_too_long
   implicit none(type, external)
   private

   public :: cases_type, begin_progress, threads_text

   !> The cases as pieces of work for a crew.
   type, extends(job_type) :: cases_type
      type(sweep_type), pointer :: sweep => null()
      !> Its cases.
      type(selection_type) :: selection
      !> Where its columns come from.
      type(outline_type) :: outline
      !> Where rows go.
      type(journal_type) :: journal
      !> Cases in all.
      integer(i8) :: total = 0
      !> Cases that were done before.
      integer(i8) :: before = 0
      type(progress_type) :: progress
   contains
      procedure :: work => work_case
      procedure :: done => done_case
      procedure :: lost => lost_case
      procedure :: look => look_cases
   end type cases_type

contains

   !> What was done before, and the first words.
   subroutine begin_progress(cases, again, quiet, threads, left)
      type(cases_type), intent(inout) :: cases
      !> Whether the journal was there.
      logical, intent(in) :: again
      !> Whether to be silent.
      logical, intent(in) :: quiet
      !> Number of threads.
      integer, intent(in) :: threads
      !> Cases to do.
      integer(i8), intent(out) :: left
      integer(i8) :: i

      associate (total => cases%total, before => cases%before)
         total = cases%selection%count()
         if (again) then
            do i = 1, total
               if (cases%journal%has(i)) before = before + 1
            end do
         end if
         left = total - before
         call cases%progress%begin(quiet, real(before, wp)/real(total, wp))
         if (again) then
            call cases%progress%note("going on with " // to_text(left) // " of " // &
               to_text(total) // " cases on " // threads_text(threads))
         else
            call cases%progress%note(to_text(total) // " cases on " // threads_text(threads))
         end if
      end associate
   end subroutine begin_progress

   !> A number of threads in words.
   pure function threads_text(threads) result(text)
      !> The number.
      integer, intent(in) :: threads
      character(len=:), allocatable :: text

      text = to_text(threads) // " threads"
      if (threads == 1) text = "1 thread"
   end function threads_text

   !> Run a case in a thread of the worker.
   subroutine work_case(self, thread, piece, code)
      class(cases_type), intent(in) :: self
      !> Number of the thread.
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
   function done_case(self, piece) result(answer)
      class(cases_type), intent(in) :: self
      !> Position of the case.
      integer(i8), intent(in) :: piece
      logical :: answer

      answer = self%journal%has(piece)
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

   !> Show how far the sweep is.
   subroutine look_cases(self, finished)
      class(cases_type), intent(inout) :: self
      !> Cases that were run by now.
      integer(i8), intent(in) :: finished
      real(wp) :: share

      share = min(real(self%before + finished, wp)/real(self%total, wp), 1.0_wp)
      if (self%progress%is_due(share)) call self%progress%tell(share, &
         to_text(self%before + finished) // " of " // to_text(self%total) // " cases")
   end subroutine look_cases

end module contensou_drivers_sweep_cases
