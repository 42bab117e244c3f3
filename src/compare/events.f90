!> Comparison of two lists of events as events.
!>
!> The events of each contact are matched in their order. Where two do not fit, in kind or in time,
!> the nearest fitting one among those that follow tells whether one list has events that the other
!> has not. Events are taken in as they come; only those that wait for a partner are kept.
module contensou_compare_events
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite
   use contensou_base_kinds, only : i8, wp
   use contensou_base_text, only : string_type
   implicit none(type, external)
   private

   public :: event_matcher_type, event_note_type

   !> An event that is worth a word.
   type :: event_note_type
      logical :: present = .false.
      character(len=:), allocatable :: contact
      !> Its kind in each of the lists.
      type(string_type) :: kind(2)
      !> Its time in each of the lists [s].
      real(wp) :: time(2) = 0.0_wp
   end type event_note_type

   !> An event that waits for its partner.
   type :: event_type
      !> Time [s].
      real(wp) :: time = 0.0_wp
      integer :: kind = 0
   end type event_type

   !> Events of one contact in one list, from `head` to `tail`.
   type :: queue_type
      type(event_type), allocatable :: events(:)
      !> First one.
      integer :: head = 1
      !> Last one.
      integer :: tail = 0
   end type queue_type

   !> Events of one contact.
   type :: lane_type
      !> Those of the two lists.
      type(queue_type) :: queue(2)
   end type lane_type

   !> State and result of a comparison.
   type :: event_matcher_type
      !> Absolute tolerance of times [s].
      real(wp) :: atol = 0.0_wp
      !> Relative tolerance of times.
      real(wp) :: rtol = 0.0_wp
      !> Events of the two lists.
      integer(i8) :: n(2) = 0_i8
      integer(i8) :: n_pairs = 0_i8
      !> Pairs of equal kind whose times differ at all.
      integer(i8) :: n_shifted = 0_i8
      !> Pairs of equal kind whose times differ beyond the tolerance.
      integer(i8) :: n_beyond = 0_i8
      !> Pairs of different kind.
      integer(i8) :: n_kind = 0_i8
      !> Events that one list alone has.
      integer(i8) :: n_only(2) = 0_i8
      !> Largest difference of time [s].
      real(wp) :: largest = 0.0_wp
      !> Largest relative difference of time.
      real(wp) :: relative = 0.0_wp
      !> Pair of the largest difference.
      type(event_note_type) :: at_largest
      !> Earliest pair beyond the tolerance.
      type(event_note_type) :: first_beyond
      !> Earliest pair of different kind.
      type(event_note_type) :: first_kind
      !> Earliest event that one list alone has.
      type(event_note_type) :: first_only(2)
      type(string_type), allocatable, private :: contacts(:)
      !> Events that wait, by contact.
      type(lane_type), allocatable, private :: lanes(:)
      integer, private :: n_contacts = 0
      type(string_type), allocatable, private :: kinds(:)
      integer, private :: n_kinds = 0
   contains
      procedure :: add
      procedure :: match
      procedure :: finish
      procedure :: differ
   end type event_matcher_type

   !> Names of contacts or kinds that are told apart; the rest is lumped together.
   integer, parameter :: max_names = 4096

   !> Pairs of events that may be found to be those of one list alone.
   integer, parameter :: look_ahead = 16

   !> Events of one contact that may wait for a partner.
   integer, parameter :: max_waiting = 100000

contains

   !> Take in an event.
   subroutine add(self, side, contact, kind, time)
      class(event_matcher_type), intent(inout) :: self
      !> List, 1 or 2.
      integer, intent(in) :: side
      character(len=*), intent(in) :: contact
      !> Kind, such as "touch".
      character(len=*), intent(in) :: kind
      !> Time [s].
      real(wp), intent(in) :: time
      type(event_type), allocatable :: longer(:)
      type(lane_type), allocatable :: lanes(:)
      integer :: lane, kind_index, i, waiting

      if (.not. allocated(self%contacts)) allocate(self%contacts(max_names), self%lanes(8))
      if (.not. allocated(self%kinds)) allocate(self%kinds(max_names))
      call index_of(self%contacts, self%n_contacts, contact, lane)
      call index_of(self%kinds, self%n_kinds, kind, kind_index)
      if (lane > size(self%lanes)) then
         allocate(lanes(2*size(self%lanes)))
         do i = 1, size(self%lanes)
            lanes(i)%queue(1) = self%lanes(i)%queue(1)
            lanes(i)%queue(2) = self%lanes(i)%queue(2)
         end do
         call move_alloc(lanes, self%lanes)
      end if
      self%n(side) = self%n(side) + 1
      waiting = waiting_of(self%lanes(lane), side)
      if (waiting >= max_waiting) call drop(self, lane, side)
      associate (queue => self%lanes(lane)%queue(side))
         if (.not. allocated(queue%events)) allocate(queue%events(64))
         if (queue%tail == size(queue%events)) then
            waiting = queue%tail - queue%head + 1
            allocate(longer(max(64, 2*waiting)))
            longer(:waiting) = queue%events(queue%head:queue%tail)
            call move_alloc(longer, queue%events)
            queue%head = 1
            queue%tail = waiting
         end if
         queue%tail = queue%tail + 1
         queue%events(queue%tail)%time = time
         queue%events(queue%tail)%kind = kind_index
      end associate
   end subroutine add

   !> Index of a name in a list, which grows if it is new.
   subroutine index_of(names, n, name, i)
      type(string_type), intent(inout) :: names(:)
      integer, intent(inout) :: n
      character(len=*), intent(in) :: name
      integer, intent(out) :: i

      do i = 1, n
         if (len(names(i)%s) == len(name)) then
            if (names(i)%s == name) return
         end if
      end do
      i = n
      if (n == size(names)) return
      n = n + 1
      i = n
      names(n)%s = name
   end subroutine index_of

   !> Match those that can be matched by now.
   subroutine match(self)
      class(event_matcher_type), intent(inout) :: self
      integer :: lane

      do lane = 1, self%n_contacts
         call match_lane(self, lane, .false.)
      end do
   end subroutine match

   !> Match all: the lists are at their end.
   subroutine finish(self)
      class(event_matcher_type), intent(inout) :: self
      integer :: lane

      do lane = 1, self%n_contacts
         call match_lane(self, lane, .true.)
      end do
   end subroutine finish

   !> Whether the lists differ beyond the tolerance.
   pure logical function differ(self)
      class(event_matcher_type), intent(in) :: self

      differ = self%n_beyond + self%n_kind + sum(self%n_only) > 0_i8
   end function differ

   !> Number of events that wait.
   pure integer function waiting_of(lane, side)
      !> Events of a contact.
      type(lane_type), intent(in) :: lane
      !> List, 1 or 2.
      integer, intent(in) :: side

      waiting_of = lane%queue(side)%tail - lane%queue(side)%head + 1
   end function waiting_of

   !> Match the events of a contact.
   subroutine match_lane(self, lane, at_end)
      class(event_matcher_type), intent(inout) :: self
      integer, intent(in) :: lane
      !> Whether no more events come.
      logical, intent(in) :: at_end
      type(event_type) :: a, b, candidate
      real(wp) :: shift, best, other
      integer :: n(2), i, j, side, skip, skip_side

      do
         n = [waiting_of(self%lanes(lane), 1), waiting_of(self%lanes(lane), 2)]
         if (minval(n) == 0) exit
         if (.not. at_end .and. minval(n) <= 2*look_ahead) return
         a = event_at(self, lane, 1, 0)
         b = event_at(self, lane, 2, 0)
         shift = shift_of(a%time, b%time)
         if (a%kind /= b%kind) then
            if (shift < 0.5_wp*min(gap_after(1, a%time), gap_after(2, b%time)) .or. &
               maxval(n) == 1) then
               call pair(self, lane, a, b)
            else if (a%time < b%time) then
               call drop(self, lane, 1)
            else
               call drop(self, lane, 2)
            end if
            cycle
         end if
         skip = 0
         skip_side = 0
         if (shift > self%atol + self%rtol*max(abs(a%time), abs(b%time))) then
            ! Is there one of its kind further on in one list that fits far better?
            best = 0.25_wp*shift
            do side = 1, 2
               do i = 1, look_ahead
                  if (2*i >= n(side)) exit
                  candidate = event_at(self, lane, side, 2*i)
                  if (candidate%kind /= a%kind) cycle
                  other = shift_of(candidate%time, merge(b%time, a%time, side == 1))
                  if (other < best) then
                     best = other
                     skip = 2*i
                     skip_side = side
                  end if
               end do
            end do
         end if
         do j = 1, skip
            call drop(self, lane, skip_side)
         end do
         if (skip == 0) call pair(self, lane, a, b)
      end do
      if (.not. at_end) return
      do side = 1, 2
         do i = 1, n(side)
            call drop(self, lane, side)
         end do
      end do

   contains

      !> Time from an event to the next one of the same list; no end of it if there is none.
      function gap_after(side, time) result(gap)
         !> List, 1 or 2.
         integer, intent(in) :: side
         !> Time of the event [s].
         real(wp), intent(in) :: time
         !> The difference [s].
         real(wp) :: gap
         type(event_type) :: next

         gap = huge(1.0_wp)
         if (n(side) < 2) return
         next = event_at(self, lane, side, 1)
         gap = shift_of(next%time, time)
      end function gap_after

   end subroutine match_lane

   !> An event that waits.
   pure function event_at(self, lane, side, offset) result(event)
      class(event_matcher_type), intent(in) :: self
      integer, intent(in) :: lane
      !> List, 1 or 2.
      integer, intent(in) :: side
      !> 0 for the first one.
      integer, intent(in) :: offset
      type(event_type) :: event

      associate (queue => self%lanes(lane)%queue(side))
         event = queue%events(queue%head + offset)
      end associate
   end function event_at

   !> Difference of two times; as large as can be unless both are numbers.
   pure function shift_of(a, b) result(shift)
      !> A time [s].
      real(wp), intent(in) :: a
      !> Another time [s].
      real(wp), intent(in) :: b
      !> The difference [s].
      real(wp) :: shift

      shift = 0.0_wp
      if (transfer(a, 0_i8) == transfer(b, 0_i8)) return
      shift = huge(1.0_wp)
      if (.not. ieee_is_finite(a) .or. .not. ieee_is_finite(b)) return
      if (max(abs(a), abs(b)) < 0.25_wp*huge(1.0_wp)) shift = abs(a - b)
   end function shift_of

   !> Take the first events of both lists as a pair.
   subroutine pair(self, lane, a, b)
      class(event_matcher_type), intent(inout) :: self
      integer, intent(in) :: lane
      !> Event of the first list.
      type(event_type), intent(in) :: a
      !> Event of the second list.
      type(event_type), intent(in) :: b
      real(wp) :: shift

      self%n_pairs = self%n_pairs + 1
      self%lanes(lane)%queue%head = self%lanes(lane)%queue%head + 1
      if (a%kind /= b%kind) then
         self%n_kind = self%n_kind + 1
         call note_first(self%first_kind)
         return
      end if
      shift = shift_of(a%time, b%time)
      if (shift > 0.0_wp) self%n_shifted = self%n_shifted + 1
      if (shift > self%largest) then
         self%largest = shift
         call note(self%at_largest)
      end if
      if (shift < huge(1.0_wp) .and. shift > 0.0_wp) self%relative = max(self%relative, &
         shift/max(abs(a%time), abs(b%time)))
      if (shift > 0.0_wp) then
         if (shift >= huge(1.0_wp)) then
            self%n_beyond = self%n_beyond + 1
            call note_first(self%first_beyond)
         else if (shift > self%atol + self%rtol*max(abs(a%time), abs(b%time))) then
            self%n_beyond = self%n_beyond + 1
            call note_first(self%first_beyond)
         end if
      end if

   contains

      !> Note the pair if it is the earliest.
      subroutine note_first(place)
         !> Where to.
         type(event_note_type), intent(inout) :: place

         if (place%present) then
            if (.not. earlier(a%time, place%time(1))) return
         end if
         call note(place)
      end subroutine note_first

      !> Note the pair.
      subroutine note(place)
         !> Where to.
         type(event_note_type), intent(inout) :: place

         place%present = .true.
         place%contact = self%contacts(lane)%s
         place%kind(1)%s = self%kinds(a%kind)%s
         place%kind(2)%s = self%kinds(b%kind)%s
         place%time = [a%time, b%time]
      end subroutine note

   end subroutine pair

   !> Take the first event of a list as one that the other has not.
   subroutine drop(self, lane, side)
      class(event_matcher_type), intent(inout) :: self
      integer, intent(in) :: lane
      !> List, 1 or 2.
      integer, intent(in) :: side
      type(event_type) :: event

      event = event_at(self, lane, side, 0)
      self%lanes(lane)%queue(side)%head = self%lanes(lane)%queue(side)%head + 1
      self%n_only(side) = self%n_only(side) + 1
      associate (place => self%first_only(side))
         if (place%present) then
            if (.not. earlier(event%time, place%time(side))) return
         end if
         place%present = .true.
         place%contact = self%contacts(lane)%s
         place%kind(1)%s = self%kinds(event%kind)%s
         place%kind(2)%s = self%kinds(event%kind)%s
         place%time = event%time
      end associate
   end subroutine drop

   !> Whether a time is before another; what is no number is before nothing.
   pure logical function earlier(a, b)
      !> A time [s].
      real(wp), intent(in) :: a
      !> Another time [s].
      real(wp), intent(in) :: b

      earlier = .false.
      if (ieee_is_finite(a) .and. ieee_is_finite(b)) earlier = a < b
   end function earlier

end module contensou_compare_events
