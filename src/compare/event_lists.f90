!> Comparison of the events of two runs as events.
module contensou_compare_event_lists
   use, intrinsic :: ieee_arithmetic, only : ieee_is_nan
   use contensou_base_errors, only : error_type
   use contensou_base_kinds, only : i8, wp
   use contensou_base_numbers, only : to_text
   use contensou_base_text, only : string_type
   use contensou_compare_events, only : event_matcher_type, event_note_type
   use contensou_compare_items, only : outcome_type
   use contensou_compare_listing, only : brief, listing_type, numbers_text, side_names
   use contensou_compare_places, only : printable, time_text
   use contensou_compare_rules, only : rules_type, verdict_type
   use contensou_compare_values, only : block_texts, span_type
   use contensou_files_hdf5_reader, only : class_real, class_text, hdf5_item_type, &
      hdf5_reader_type, max_rank
   implicit none(type, external)
   private

   public :: compare_events, event_parts

   !> Data sets that are compared as events.
   character(len=*), parameter :: event_parts(3) = [character(len=15) :: "/events/time", &
      "/events/kind", "/events/contact"]

contains

   !> Compare the events as events, if both files have them in the form of a run.
   subroutine compare_events(readers, listing, rules, span, outcome, compared)
      type(hdf5_reader_type), intent(inout) :: readers(2)
      !> Where the results go.
      type(listing_type), intent(inout) :: listing
      type(rules_type), intent(in) :: rules
      type(span_type), intent(in) :: span
      type(outcome_type), intent(out) :: outcome
      !> Whether both files have events in the form of a run.
      logical, intent(out) :: compared
      type(hdf5_item_type) :: items(3, 2)
      type(event_matcher_type) :: matcher
      type(error_type), allocatable :: error
      type(verdict_type) :: verdicts(3)
      integer(i8) :: done(2)
      integer :: i, side

      do i = 1, 3
         verdicts(i) = rules%verdict(trim(event_parts(i)), "")
      end do
      compared = .not. all(verdicts%ignore)
      do side = 1, 2
         do i = 1, 3
            if (.not. compared) cycle
            call readers(side)%open_item(trim(event_parts(i)), "", items(i, side), error)
            compared = .not. allocated(error)
            if (.not. compared) cycle
            compared = items(i, side)%rank == 1 .and. items(i, side)%class == &
               merge(class_real, class_text, i == 1) .and. &
               items(i, side)%extents(1) == items(1, side)%extents(1) .and. &
               items(i, side)%size == items(i, 1)%size
         end do
      end do
      if (compared) then
         matcher%atol = verdicts(1)%atol
         matcher%rtol = verdicts(1)%rtol
         done = 0
         do while (any(done < items(1, :)%extents(1)))
            do side = 1, 2
               call feed(matcher, side, items(:, side), verdicts%ignore, span, done(side), error)
               if (allocated(error)) exit
            end do
            if (allocated(error)) exit
            call matcher%match()
         end do
         if (allocated(error)) then
            call listing%trouble(error%message)
         else
            call matcher%finish()
            call report_events(listing, matcher, outcome)
         end if
      end if
      do side = 1, 2
         do i = 1, 3
            call items(i, side)%close()
         end do
      end do
   end subroutine compare_events

   !> Hand a block of events to the matcher.
   subroutine feed(matcher, side, items, ignore, span, done, error)
      type(event_matcher_type), intent(inout) :: matcher
      !> File, 1 or 2.
      integer, intent(in) :: side
      !> Times, kinds and contacts.
      type(hdf5_item_type), intent(in) :: items(3)
      !> Which of the three the rules leave out.
      logical, intent(in) :: ignore(3)
      type(span_type), intent(in) :: span
      !> Events handed over so far.
      integer(i8), intent(inout) :: done
      type(error_type), allocatable, intent(out) :: error
      type(string_type), allocatable :: kinds(:), contacts(:)
      real(wp) :: times(block_texts)
      integer(i8) :: start(1), count(1)
      integer :: i, n
      logical :: later

      n = int(min(int(block_texts, i8), items(1)%extents(1) - done))
      if (n == 0) return
      start = done
      count = n
      call items(1)%read(start, count, times, error)
      if (.not. allocated(error)) call items(2)%read_texts(start, count, n, kinds, error)
      if (.not. allocated(error)) call items(3)%read_texts(start, count, n, contacts, error)
      if (allocated(error)) return
      done = done + n
      do i = 1, n
         if (span%is_cut .and. .not. ieee_is_nan(times(i))) then
            later = times(i) > span%until
            if (later) cycle
         end if
         if (ignore(1)) times(i) = 0.0_wp
         if (ignore(2)) kinds(i)%s = "event"
         if (ignore(3)) contacts(i)%s = ""
         call matcher%add(side, contacts(i)%s, kinds(i)%s, times(i))
      end do
   end subroutine feed

   !> Report how the events differ.
   subroutine report_events(listing, matcher, outcome)
      type(listing_type), intent(inout) :: listing
      !> The matcher at its end.
      type(event_matcher_type), intent(in) :: matcher
      type(outcome_type), intent(out) :: outcome
      integer :: side

      outcome%is_different = matcher%differ()
      outcome%is_within = matcher%n_shifted > 0 .and. .not. outcome%is_different
      if (.not. (outcome%is_different .or. outcome%is_within)) return
      if (matcher%n_shifted > 0) then
         call listing%row("/events", numbers_text(brief(matcher%largest), brief(matcher%relative), &
            matcher%n_beyond, matcher%n_pairs))
      else
         call listing%row("/events", "        differs")
      end if
      if (matcher%n(1) /= matcher%n(2)) call listing%detail("count", to_text(matcher%n(1)) // &
         " events in A, " // to_text(matcher%n(2)) // " in B")
      do side = 1, 2
         if (matcher%n_only(side) > 0) call listing%detail("missing", &
            to_text(matcher%n_only(side)) // " only in " // side_names(side) // ", first " // &
            event_text(matcher%first_only(side), side))
      end do
      if (matcher%n_kind > 0) call listing%detail("kind", to_text(matcher%n_kind) // &
         " of another kind, first " // event_text(matcher%first_kind, 1) // " in A, " // &
         printable(matcher%first_kind%kind(2)%s) // " in B")
      if (matcher%at_largest%present) call say("shift", matcher%at_largest)
      if (matcher%first_beyond%present) call say("first", matcher%first_beyond)

   contains

      !> Say how an event has moved.
      subroutine say(label, note)
         character(len=*), intent(in) :: label
         type(event_note_type), intent(in) :: note

         call listing%detail(label, event_text(note, 1))
         call listing%detail("", to_text(note%time(1)) // " s in A, " // to_text(note%time(2)) // &
            " s in B")
      end subroutine say

   end subroutine report_events

   !> Words for an event.
   pure function event_text(note, side) result(text)
      type(event_note_type), intent(in) :: note
      !> File, 1 or 2.
      integer, intent(in) :: side
      !> Such as "touch of stem_floor at t = 1.8 s".
      character(len=:), allocatable :: text

      text = printable(note%kind(side)%s)
      if (note%contact /= "") text = text // " of " // printable(note%contact)
      text = text // " at t = " // time_text(note%time(side)) // " s"
   end function event_text

end module contensou_compare_event_lists
