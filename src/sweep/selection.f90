!> Some of the cases of a sweep, as ranges such as "1:500,800", and the names of their files.
module contensou_sweep_selection
   use contensou_base_errors, only : error_type, fatal, status_usage
   use contensou_base_kinds, only : i8
   use contensou_base_numbers, only : counted, to_text
   use contensou_base_text, only : quote
   implicit none(type, external)
   private

   public :: selection_type, select_cases, parse_ranges, table_name, named

   !> Some of the cases of a sweep, as ranges in ascending order.
   type :: selection_type
      !> First and last case of each range, (2, ranges).
      integer(i8), allocatable :: ranges(:, :)
   contains
      procedure :: count => count_cases
      procedure :: case_at
      procedure :: position_of
      procedure :: text => selection_text
   end type selection_type

contains

   !> The cases that are asked for.
   subroutine select_cases(ranges, shard, n_cases, selection, error)
      !> Ranges such as "1:500,800"; blank for all cases.
      character(len=*), intent(in) :: ranges
      !> Which part of these, and of how many; 0 for all.
      integer, intent(in) :: shard(2)
      !> Number of cases of the sweep.
      integer(i8), intent(in) :: n_cases
      type(selection_type), intent(out) :: selection
      !> Set when there are none, or the ranges are wrong.
      type(error_type), allocatable, intent(out) :: error
      type(selection_type) :: whole
      character(len=:), allocatable :: wrong

      if (ranges == "") then
         allocate(whole%ranges(2, 1))
         whole%ranges(:, 1) = [1_i8, n_cases]
      else
         call parse_ranges(ranges, n_cases, whole, wrong)
         if (allocated(wrong)) then
            call fatal(error, "--cases needs ranges such as 1:500,800 of cases from 1 to " // &
               to_text(n_cases) // ", not " // quote(wrong), status_usage)
            return
         end if
      end if
      if (shard(2) == 0) then
         selection = whole
         return
      end if
      associate (n => whole%count(), k => int(shard(1), i8), m => shard(2))
         if (m > n) then
            call fatal(error, counted(n, "case") // " cannot be divided among " // &
               counted(int(m, i8), "shard"), status_usage)
            return
         end if
         call cut(whole, first_of(n, k - 1, m) + 1, first_of(n, k, m), selection)
      end associate

   contains

      !> Cases before the shard after the k-th one, without overflow.
      pure integer(i8) function first_of(n, k, m)
         !> Number of cases.
         integer(i8), intent(in) :: n
         !> Shards before.
         integer(i8), intent(in) :: k
         !> Number of shards.
         integer, intent(in) :: m

         first_of = (n/m)*k + min(k, mod(n, int(m, i8)))
      end function first_of

   end subroutine select_cases

   !> Understand ranges such as "1:500,800": they are put in ascending order and joined where they
   !> touch.
   pure subroutine parse_ranges(text, n_cases, selection, wrong)
      character(len=*), intent(in) :: text
      !> Number of cases of the sweep.
      integer(i8), intent(in) :: n_cases
      type(selection_type), intent(out) :: selection
      !> The first word that is no range of cases; not allocated if there is none.
      character(len=:), allocatable, intent(out) :: wrong
      integer(i8), allocatable :: ranges(:, :)
      integer(i8) :: bounds(2)
      integer :: start, comma, colon, n, i, j

      n = count([(text(i:i) == ",", i=1, len(text))]) + 1
      allocate(ranges(2, n))
      start = 1
      do i = 1, n
         comma = index(text(start:) // ",", ",") - 1
         associate (word => text(start:start + comma - 1))
            colon = index(word, ":")
            bounds(1) = case_number(word(:merge(colon - 1, len(word), colon > 0)))
            bounds(2) = case_number(word(colon + 1:))
            if (bounds(1) < 1 .or. bounds(2) < bounds(1) .or. bounds(2) > n_cases) then
               wrong = word
               return
            end if
         end associate
         start = start + comma + 1
         j = i - 1
         do while (j >= 1)
            if (ranges(1, j) <= bounds(1)) exit
            ranges(:, j + 1) = ranges(:, j)
            j = j - 1
         end do
         ranges(:, j + 1) = bounds
      end do
      j = 1
      do i = 2, n
         if (ranges(1, i) <= ranges(2, j) + 1) then
            ranges(2, j) = max(ranges(2, j), ranges(2, i))
         else
            j = j + 1
            ranges(:, j) = ranges(:, i)
         end if
      end do
      selection%ranges = ranges(:, :j)
   end subroutine parse_ranges

   !> A number of a case; -1 if it is none.
   pure integer(i8) function case_number(word)
      character(len=*), intent(in) :: word
      integer :: code

      case_number = -1
      if (len(word) == 0 .or. len(word) > 18) return
      if (verify(word, "0123456789") > 0) return
      read(word, *, iostat=code) case_number
      if (code /= 0) case_number = -1
   end function case_number

   !> The cases between two positions of a selection.
   pure subroutine cut(whole, first, last, part)
      type(selection_type), intent(in) :: whole
      !> First position.
      integer(i8), intent(in) :: first
      !> Last position.
      integer(i8), intent(in) :: last
      type(selection_type), intent(out) :: part
      integer(i8) :: before, low, high, ranges(2, size(whole%ranges, 2))
      integer :: i, n

      before = 0
      n = 0
      do i = 1, size(whole%ranges, 2)
         associate (r => whole%ranges(:, i))
            low = max(r(1), r(1) + first - 1 - before)
            high = min(r(2), r(1) + last - 1 - before)
            before = before + r(2) - r(1) + 1
            if (low > high) cycle
            n = n + 1
            ranges(:, n) = [low, high]
         end associate
      end do
      part%ranges = ranges(:, :n)
   end subroutine cut

   !> How many cases a selection has.
   pure integer(i8) function count_cases(self)
      class(selection_type), intent(in) :: self

      count_cases = sum(self%ranges(2, :) - self%ranges(1, :) + 1)
   end function count_cases

   !> Number of the case at a position.
   pure integer(i8) function case_at(self, position)
      class(selection_type), intent(in) :: self
      !> Position, from 1.
      integer(i8), intent(in) :: position
      integer(i8) :: left, length
      integer :: i

      left = position
      case_at = 0
      do i = 1, size(self%ranges, 2)
         length = self%ranges(2, i) - self%ranges(1, i) + 1
         if (left <= length) then
            case_at = self%ranges(1, i) + left - 1
            return
         end if
         left = left - length
      end do
   end function case_at

   !> Position of a case; 0 if it is not there.
   pure integer(i8) function position_of(self, number)
      class(selection_type), intent(in) :: self
      !> Number of the case.
      integer(i8), intent(in) :: number
      integer(i8) :: before
      integer :: i

      position_of = 0
      before = 0
      do i = 1, size(self%ranges, 2)
         associate (first => self%ranges(1, i), last => self%ranges(2, i))
            if (number >= first .and. number <= last) position_of = before + number - first + 1
            before = before + last - first + 1
         end associate
      end do
   end function position_of

   !> The ranges as a text such as "1:500,800".
   pure function selection_text(self) result(text)
      class(selection_type), intent(in) :: self
      character(len=:), allocatable :: text
      integer :: i

      text = ""
      do i = 1, size(self%ranges, 2)
         if (i > 1) text = text // ","
         text = text // to_text(self%ranges(1, i))
         if (self%ranges(2, i) > self%ranges(1, i)) text = text // ":" // &
            to_text(self%ranges(2, i))
      end do
   end function selection_text

   !> Name of the table of some cases.
   pure function table_name(output, selection, of_ranges, shard) result(name)
      !> Name of the table of the whole sweep.
      character(len=*), intent(in) :: output
      type(selection_type), intent(in) :: selection
      !> Whether the name tells the ranges of cases.
      logical, intent(in) :: of_ranges
      !> Which part of these, and of how many; 0 for all.
      integer, intent(in) :: shard(2)
      character(len=:), allocatable :: name

      name = output
      if (of_ranges) name = named(name, "_cases_" // to_text(selection%ranges(1, 1)) // "_to_" // &
         to_text(selection%ranges(2, size(selection%ranges, 2))))
      if (shard(2) > 0) name = named(name, "_shard_" // to_text(shard(1)) // "_of_" // &
         to_text(shard(2)))
   end function table_name

   !> A file name with some words before its suffix.
   pure function named(name, infix) result(text)
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: infix
      character(len=:), allocatable :: text
      integer :: dot

      dot = index(name, ".", back=.true.)
      if (dot <= index(name, "/", back=.true.) + 1) dot = len(name) + 1
      text = name(:dot - 1) // infix // name(dot:)
   end function named

end module contensou_sweep_selection
