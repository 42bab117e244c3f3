!> What a sweep says of itself: how far it is, and what it came to.
module contensou_drivers_sweep_report
   use contensou_base_errors, only : error_type
   use contensou_base_kinds, only : i8, wp
   use contensou_base_numbers, only : counted, number_text, to_text
   use contensou_base_operating_system, only : file_exists, write_stdout
   use contensou_base_text, only : command_text, string_type
   use contensou_drivers_progress, only : progress_type
   use contensou_sweep_cases, only : cases_type, tally_type
   use contensou_sweep_plan, only : sweep_type
   use contensou_sweep_table, only : case_complete, status_names
   use contensou_sweep_trajectories, only : run_words, trajectories_type
   implicit none(type, external)
   private

   public :: shown_cases_type, begin_progress, print_summary

   !> The cases of a sweep; a bar or words on stderr tell how far they are.
   type, extends(cases_type) :: shown_cases_type
      !> Cases in all.
      integer(i8) :: total = 0
      !> Cases that were done before.
      integer(i8) :: before = 0
      type(progress_type) :: progress
   contains
      procedure :: look => look_cases
   end type shown_cases_type

   character(len=*), parameter :: nl = new_line("a")

contains

   !> What was done before, and the first words.
   subroutine begin_progress(cases, again, quiet, threads, left)
      type(shown_cases_type), intent(inout) :: cases
      !> Whether the journal was there.
      logical, intent(in) :: again
      !> Whether to be silent.
      logical, intent(in) :: quiet
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
               counted(total, "case") // " on " // counted(int(threads, i8), "thread"))
         else
            call cases%progress%note(counted(total, "case") // " on " // &
               counted(int(threads, i8), "thread"))
         end if
      end associate
   end subroutine begin_progress

   !> Show how far the sweep is.
   subroutine look_cases(self, finished)
      class(shown_cases_type), intent(inout) :: self
      !> Cases that were run by now.
      integer(i8), intent(in) :: finished
      real(wp) :: share

      share = min(real(self%before + finished, wp)/real(self%total, wp), 1.0_wp)
      if (self%progress%is_due(share)) call self%progress%tell(share, &
         to_text(self%before + finished) // " of " // counted(self%total, "case"))
   end subroutine look_cases

   !> Print what the sweep came to.
   subroutine print_summary(name, sweep, tally, trajectories, threads, wall, error)
      character(len=*), intent(in) :: name
      type(sweep_type), intent(in) :: sweep
      type(tally_type), intent(in) :: tally
      type(trajectories_type), intent(in) :: trajectories
      integer, intent(in) :: threads
      !> Wall time [s].
      real(wp), intent(in) :: wall
      !> Set when the standard output cannot be written.
      type(error_type), allocatable, intent(out) :: error
      type(string_type), allocatable :: overrides(:), words(:)
      character(len=:), allocatable :: text
      integer :: i, shown

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
         if (file_exists(trajectories%files(i)%s)) then
            text = text // "  trajectory " // trajectories%files(i)%s // nl
         else
            text = text // "  trajectory of case " // to_text(trajectories%numbers(i)) // &
               ": none, the case did not complete" // nl
         end if
      end do
      text = text // "  work       " // number_text(wall, 3) // " s wall on " // &
         counted(int(threads, i8), "thread") // nl // "  table      " // name // nl
      call write_stdout(text, error)

   contains

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

end module contensou_drivers_sweep_report
