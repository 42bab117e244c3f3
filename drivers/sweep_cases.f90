!> The cases of a sweep as pieces of work for a crew: each ends as a row of a journal, and a bar or
!> words on stderr tell how far they are.
module contensou_drivers_sweep_cases
   use, intrinsic :: ieee_arithmetic, only : ieee_quiet_nan, ieee_value
   use contensou_base_crew, only : job_type, piece_stopped
   use contensou_base_journal, only : journal_type
   use contensou_base_kinds, only : i8, wp
   use contensou_base_system, only : is_terminal, terminal_width, wall_seconds, write_stderr
   use contensou_base_text, only : to_text
   use contensou_drivers_report, only : number_text
   use contensou_drivers_sweep_case, only : outline_type, run_case
   use contensou_drivers_sweep_selection, only : selection_type
   use contensou_io_sweep, only : sweep_type
   use contensou_io_sweep_table, only : case_crashed, case_too_long
   implicit none(type, external)
   private

   public :: cases_type, begin_progress, clear_bar, threads_text

   !> End of a line.
   character(len=*), parameter :: nl = new_line("a")

   !> Progress on stderr.
   type :: progress_type
      !> Whether it is shown.
      logical :: show = .true.
      !> Whether stderr is a terminal.
      logical :: terminal = .false.
      !> Cases in all.
      integer(i8) :: total = 0
      !> Cases that were done before.
      integer(i8) :: before = 0
      !> Tenths that were told.
      integer :: tenths = 0
      !> Wall time at the beginning and of the last change of the bar [s].
      real(wp) :: start = 0.0_wp, last = 0.0_wp
   end type progress_type

   !> The cases as pieces of work for a crew.
   type, extends(job_type) :: cases_type
      !> The sweep.
      type(sweep_type), pointer :: sweep => null()
      !> Its cases.
      type(selection_type) :: selection
      !> Where its columns come from.
      type(outline_type) :: outline
      !> Where rows go.
      type(journal_type) :: journal
      !> Progress.
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
      !> The cases.
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

      associate (p => cases%progress)
         p%show = .not. quiet
         p%terminal = is_terminal(2)
         p%total = cases%selection%count()
         if (again) then
            do i = 1, p%total
               if (cases%journal%has(i)) p%before = p%before + 1
            end do
         end if
         left = p%total - p%before
         p%tenths = int(10*p%before/p%total)
         p%start = wall_seconds()
         p%last = p%start
         if (.not. p%show) return
         if (again) then
            call write_stderr("contensou: going on with " // to_text(left) // " of " // &
               to_text(p%total) // " cases on " // threads_text(threads) // nl)
         else
            call write_stderr("contensou: " // to_text(p%total) // " cases on " // &
               threads_text(threads) // nl)
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

   !> Remove the bar from the terminal.
   subroutine clear_bar(progress)
      !> The progress.
      type(progress_type), intent(in) :: progress

      if (progress%show .and. progress%terminal) call write_stderr(achar(13) // achar(27) // "[K")
   end subroutine clear_bar

   !> Run a case in a thread of the worker.
   subroutine work_case(self, thread, piece, code)
      !> The cases.
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
      !> The cases.
      class(cases_type), intent(in) :: self
      !> Position of the case.
      integer(i8), intent(in) :: piece
      logical :: answer

      answer = self%journal%has(piece)
   end function done_case

   !> Write the row of a case that never ended.
   subroutine lost_case(self, piece, late, reason, code)
      !> The cases.
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
      !> The cases.
      class(cases_type), intent(inout) :: self
      !> Cases that were run by now.
      integer(i8), intent(in) :: finished
      integer, parameter :: widest = 40
      real(wp) :: now, share
      integer :: filled, width
      character(len=:), allocatable :: words

      associate (p => self%progress)
         if (.not. p%show .or. finished == 0) return
         share = min(real(p%before + finished, wp)/real(p%total, wp), 1.0_wp)
         now = wall_seconds()
         words = to_text(p%before + finished) // " of " // to_text(p%total) // " cases, " // &
            time_left() // " left"
         if (p%terminal) then
            if (now - p%last < 0.1_wp) return
            p%last = now
            width = max(min(widest, terminal_width() - len(words) - 11), 0)
            filled = int(share*width)
            call write_stderr(achar(13) // achar(27) // "[K[" // repeat("#", filled) // &
               repeat(" ", width - filled) // "] " // to_text(int(100.0_wp*share)) // " %, " // &
               words)
         else if (int(10.0_wp*share) > p%tenths) then
            p%tenths = int(10.0_wp*share)
            call write_stderr("contensou: " // to_text(10*p%tenths) // " %, " // words // nl)
         end if
      end associate

   contains

      !> Estimated wall time to the end.
      function time_left() result(text)
         character(len=:), allocatable :: text
         integer(i8) :: seconds

         associate (p => self%progress)
            seconds = nint(min((now - p%start)*real(p%total - p%before - finished, wp) &
               /real(finished, wp), 1.0e9_wp), i8)
         end associate
         text = to_text(seconds) // " s"
         if (seconds >= 120) text = to_text(seconds/60) // " min"
         if (seconds >= 7200) text = to_text(seconds/3600) // " h " // &
            to_text(mod(seconds, 3600_i8)/60) // " min"
      end function time_left

   end subroutine look_cases

end module contensou_drivers_sweep_cases
