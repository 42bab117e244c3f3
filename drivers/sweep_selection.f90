!> Which cases of a sweep are run: what the user asks for as ranges, and the names of their files.
module contensou_drivers_sweep_selection
   use contensou_base_errors, only : error_type, fatal, status_usage
   use contensou_base_kinds, only : i8
   use contensou_base_text, only : quote, to_text
   use contensou_sweep_plan, only : sweep_type
   implicit none(type, external)
   private

   public :: selection_type, select_cases, table_name, named

   !> Some of the cases of a sweep, as ranges in ascending order.
   type :: selection_type
      !> First and last case of each range, (2, ranges).
      integer(i8), allocatable :: ranges(:, :)
   contains
      !> How many cases there are.
      procedure :: count => count_cases
      !> Number of the case at a position.
      procedure :: case_at
      !> Position of a case; 0 if it is not there.
      procedure :: position_of
      !> The ranges as a text such as "1:500,800".
      procedure :: text => selection_text
   end type selection_type

contains

   !> The cases that are asked for.
   subroutine select_cases(ranges, shard, sweep, selection, error)
      !> Ranges such as "1:500,800"; blank for all cases.
      character(len=*), intent(in) :: ranges
      !> Which part of these, and of how many; 0 for all.
      integer, intent(in) :: shard(2)
      type(sweep_type), intent(in) :: sweep
      !> Its cases.
      type(selection_type), intent(out) :: selection
      !> Set when there are none, or the ranges are wrong.
      type(error_type), allocatable, intent(out) :: error
      type(selection_type) :: all_of_them

      if (ranges == "") then
         allocate(all_of_them%ranges(2, 1))
         all_of_them%ranges(:, 1) = [1_i8, sweep%n_cases]
      else
         call parse_ranges(ranges, sweep%n_cases, all_of_them, error)
         if (allocated(error)) return
      end if
      if (shard(2) == 0) then
         selection = all_of_them
         return
      end if
      associate (n => all_of_them%count(), k => int(shard(1), i8), m => shard(2))
         if (m > n) then
            call fatal(error, "there are " // to_text(n) // " cases for " // to_text(m) // &
               " shards", status_usage)
            return
         end if
         call cut(all_of_them, first_of(n, k - 1, m) + 1, first_of(n, k, m), selection)
      end associate

   contains

      !> Cases before the shard after the k-th one, without overflow.
      pure function first_of(n, k, m) result(before)
         !> Number of cases.
         integer(i8), intent(in) :: n
         !> Shards before.
         integer(i8), intent(in) :: k
         !> Number of shards.
         integer, intent(in) :: m
         integer(i8) :: before

         before = (n/m)*k + min(k, mod(n, int(m, i8)))
      end function first_of

   end subroutine select_cases

   !> Understand ranges such as "1:500,800".
   subroutine parse_ranges(text, n, selection, error)
      character(len=*), intent(in) :: text
      !> Number of cases.
      integer(i8), intent(in) :: n
      !> The cases.
      type(selection_type), intent(out) :: selection
      !> Set when it cannot be understood.
      type(error_type), allocatable, intent(out) :: error
      integer(i8), allocatable :: ranges(:, :)
      integer(i8) :: bounds(2)
      integer :: start, comma, colon, count, i, j

      count = 1
      do i = 1, len(text)
         if (text(i:i) == ",") count = count + 1
      end do
      allocate(ranges(2, count))
      start = 1
      do i = 1, count
         comma = index(text(start:) // ",", ",") - 1
         associate (word => text(start:start + comma - 1))
            colon = index(word, ":")
            if (colon == 0) then
               bounds(1) = number(word)
               bounds(2) = bounds(1)
            else
               bounds(1) = number(word(:colon - 1))
               bounds(2) = number(word(colon + 1:))
            end if
            if (bounds(1) < 1 .or. bounds(2) < bounds(1) .or. bounds(2) > n) then
               call fatal(error, "--cases needs ranges such as 1:500,800 of cases from 1 to " // &
                  to_text(n) // ", not " // quote(word), status_usage)
               return
            end if
         end associate
         ranges(:, i) = bounds
         start = start + comma + 1
      end do
      ! In ascending order, joined where they touch.
      do i = 2, count
         bounds = ranges(:, i)
         j = i - 1
         do while (j >= 1)
            if (ranges(1, j) <= bounds(1)) exit
            ranges(:, j + 1) = ranges(:, j)
            j = j - 1
         end do
         ranges(:, j + 1) = bounds
      end do
      j = 1
      do i = 2, count
         if (ranges(1, i) <= ranges(2, j) + 1) then
            ranges(2, j) = max(ranges(2, j), ranges(2, i))
         else
            j = j + 1
            ranges(:, j) = ranges(:, i)
         end if
      end do
      allocate(selection%ranges(2, j))
      selection%ranges = ranges(:, :j)

   contains

      !> A number of a case; -1 if it is none.
      function number(digits) result(value)
         !> Its text.
         character(len=*), intent(in) :: digits
         integer(i8) :: value
         integer :: code

         value = -1
         if (len(digits) == 0 .or. len(digits) > 18) return
         if (verify(digits, "0123456789") > 0) return
         read(digits, *, iostat=code) value
         if (code /= 0) value = -1
      end function number

   end subroutine parse_ranges

   !> The cases between two positions of a selection.
   subroutine cut(whole, first, last, part)
      type(selection_type), intent(in) :: whole
      !> First position.
      integer(i8), intent(in) :: first
      !> Last position.
      integer(i8), intent(in) :: last
      !> What is between.
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
      allocate(part%ranges(2, n))
      part%ranges = ranges(:, :n)
   end subroutine cut

   !> How many cases a selection has.
   pure function count_cases(self) result(count)
      class(selection_type), intent(in) :: self
      integer(i8) :: count

      count = sum(self%ranges(2, :) - self%ranges(1, :) + 1)
   end function count_cases

   !> Number of the case at a position.
   pure function case_at(self, position) result(number)
      class(selection_type), intent(in) :: self
      !> Position, from 1.
      integer(i8), intent(in) :: position
      integer(i8) :: number
      integer(i8) :: left, length
      integer :: i

      left = position
      number = 0
      do i = 1, size(self%ranges, 2)
         length = self%ranges(2, i) - self%ranges(1, i) + 1
         if (left <= length) then
            number = self%ranges(1, i) + left - 1
            return
         end if
         left = left - length
      end do
   end function case_at

   !> Position of a case; 0 if it is not there.
   pure function position_of(self, number) result(position)
      class(selection_type), intent(in) :: self
      !> Number of the case.
      integer(i8), intent(in) :: number
      integer(i8) :: position
      integer(i8) :: before
      integer :: i

      position = 0
      before = 0
      do i = 1, size(self%ranges, 2)
         associate (first => self%ranges(1, i), last => self%ranges(2, i))
            if (number >= first .and. number <= last) position = before + number - first + 1
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

   !> Name of the table.
   function table_name(output, selection, of_ranges, shard) result(name)
      !> Name of the table of the whole sweep.
      character(len=*), intent(in) :: output
      !> The cases.
      type(selection_type), intent(in) :: selection
      !> Whether the name tells the ranges of cases.
      logical, intent(in) :: of_ranges
      !> Which part of these, and of how many; 0 for all.
      integer, intent(in) :: shard(2)
      character(len=:), allocatable :: name
      integer(i8) :: last

      name = output
      if (of_ranges) then
         last = selection%ranges(2, size(selection%ranges, 2))
         name = named(name, "_cases_" // to_text(selection%ranges(1, 1)) // "_to_" // &
            to_text(last))
      end if
      if (shard(2) > 0) name = named(name, "_shard_" // to_text(shard(1)) // "_of_" // &
         to_text(shard(2)))
   end function table_name

   !> A file name with some words before its suffix.
   pure function named(name, infix) result(text)
      character(len=*), intent(in) :: name
      !> The words.
      character(len=*), intent(in) :: infix
      character(len=:), allocatable :: text
      integer :: dot

      dot = index(name, ".", back=.true.)
      if (dot <= index(name, "/", back=.true.) + 1) dot = len(name) + 1
      text = name(:dot - 1) // infix // name(dot:)
   end function named

end module contensou_drivers_sweep_selection
