!> Comparison of the values of two data sets or attributes, block by block.
!>
!> Blocks hold at most 262144 numbers, so memory does not grow with the data sets.
module contensou_compare_values
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite, ieee_is_nan
   use, intrinsic :: iso_c_binding, only : c_int8_t
   use contensou_base_errors, only : error_type
   use contensou_base_kinds, only : i8, wp
   use contensou_base_numbers, only : to_text
   use contensou_base_text, only : string_type
   use contensou_compare_rules, only : verdict_type
   use contensou_files_hdf5_reader, only : class_raw, class_real, class_text, class_unsigned, &
      hdf5_item_type, max_rank
   implicit none(type, external)
   private

   public :: subject_type, span_type, found_type, compare_values, integer_text, block_texts

   !> Two data sets or attributes of the same name.
   type :: subject_type
      !> Path of the data sets, or of the objects that have the attributes.
      character(len=:), allocatable :: path
      !> Name of the attributes; empty for data sets.
      character(len=:), allocatable :: attribute
      type(verdict_type) :: verdict
   end type subject_type

   !> What part of two runs is compared.
   type :: span_type
      !> Whether rows after a time are left out.
      logical :: is_cut = .false.
      !> That time [s].
      real(wp) :: until = 0.0_wp
   end type span_type

   !> What a comparison of values has found.
   type :: found_type
      !> Values compared.
      integer(i8) :: n = 0
      !> Those that differ at all.
      integer(i8) :: n_differ = 0
      !> Those that differ beyond the tolerance.
      integer(i8) :: n_beyond = 0
      !> Those of which one is not a number.
      integer(i8) :: n_nan = 0
      !> Largest absolute difference.
      real(wp) :: largest = 0.0_wp
      !> Largest relative difference.
      real(wp) :: relative = 0.0_wp
      !> Where the largest absolute difference is.
      integer(i8) :: at_largest(max_rank) = 0
      !> Where the largest relative difference is.
      integer(i8) :: at_relative(max_rank) = 0
      !> Where the first difference beyond the tolerance is.
      integer(i8) :: at_first(max_rank) = 0
      !> Values at the largest absolute difference.
      type(string_type) :: values_largest(2)
      !> Values at the largest relative difference.
      type(string_type) :: values_relative(2)
      !> Values at the first difference beyond the tolerance.
      type(string_type) :: values_first(2)
   end type found_type

   !> Values of a block, in the one list that goes with their kind.
   type :: block_type
      real(wp), allocatable :: reals(:)
      integer(i8), allocatable :: integers(:)
      type(string_type), allocatable :: texts(:)
      integer(c_int8_t), allocatable :: bytes(:)
   end type block_type

   !> Kinds of comparison.
   integer, parameter :: as_real = 1, as_integer = 2, as_text = 3, as_bytes = 4

   integer, parameter :: block_numbers = 262144

   integer, parameter :: block_texts = 64

   !> Bytes of a block of other values, and of the largest attribute.
   integer, parameter :: block_bytes = 4194304

contains

   !> Compare values block by block.
   subroutine compare_values(items, subject, extents, found, error)
      type(hdf5_item_type), intent(in) :: items(2)
      type(subject_type), intent(in) :: subject
      !> Extents to compare.
      integer(i8), intent(in) :: extents(max_rank)
      type(found_type), intent(inout) :: found
      !> Set when the values cannot be read.
      type(error_type), allocatable, intent(out) :: error
      type(block_type) :: blocks(2)
      integer(i8) :: tile(max_rank), start(max_rank), count(max_rank), place(max_rank), at(3)
      integer :: rank, kind, d, n, side
      logical :: had_first, unsigned

      rank = items(1)%rank
      unsigned = items(1)%class == class_unsigned
      if (any(extents(:rank) == 0_i8)) return
      kind = kind_of(items)
      call choose_tile(items(1), extents, rank, values_in_block(items(1), kind), tile)
      if (subject%attribute /= "") then
         ! Attributes are read whole; their parts cannot be read, and their lengths differ anyway.
         if (any(items(1)%extents(:rank) /= items(2)%extents(:rank))) return
         tile = extents
      end if
      if (product(real(tile(:rank), wp))*max(8.0_wp, real(items(1)%size, wp)) > &
         16.0_wp*block_bytes) then
         error = error_type(subject%path // ": a value or attribute of more than 64 MiB " // &
            "cannot be compared")
         return
      end if
      start = 0
      do
         count = 1
         count(:rank) = min(tile(:rank), extents(:rank) - start(:rank))
         n = int(product(count(:rank)))
         do side = 1, 2
            call read_block(items(side), kind, start, count, n, blocks(side), error)
            if (allocated(error)) return
         end do
         at = 0
         had_first = found%n_beyond > 0
         found%n = found%n + n
         select case (kind)
         case (as_real)
            call compare_reals(blocks(1)%reals, blocks(2)%reals, n, subject%verdict, found, at)
         case (as_integer)
            call compare_integers(blocks(1)%integers, blocks(2)%integers, n, &
               unsigned, subject%verdict, found, at)
         case (as_text)
            call compare_texts(blocks(1)%texts, blocks(2)%texts, n, subject%path, found, at)
         case default
            call compare_bytes(blocks(1)%bytes, blocks(2)%bytes, n, int(items(1)%size), found, at)
         end select
         if (at(1) > 0_i8) then
            found%at_largest = place_of(at(1), start, count, rank)
            call show_values(blocks, kind, unsigned, at(1), found%values_largest)
         end if
         if (at(2) > 0_i8) then
            found%at_relative = place_of(at(2), start, count, rank)
            call show_values(blocks, kind, unsigned, at(2), found%values_relative)
         end if
         if (at(3) > 0_i8) then
            ! Blocks may come in any order of indices.
            place = place_of(at(3), start, count, rank)
            if (.not. had_first .or. .not. precedes(found%at_first(:rank), place(:rank))) then
               found%at_first = place
               call show_values(blocks, kind, unsigned, at(3), found%values_first)
            end if
         end if
         ! Next block, the last dimension first.
         do d = rank, 1, -1
            start(d) = start(d) + tile(d)
            if (start(d) < extents(d)) exit
            start(d) = 0
         end do
         if (d < 1) exit
      end do
   end subroutine compare_values

   !> Indices of a value of a block, from 0.
   pure function place_of(i, start, count, rank) result(place)
      !> Number of the value in the block.
      integer(i8), intent(in) :: i
      !> Where the block begins, and its extents.
      integer(i8), intent(in) :: start(max_rank), count(max_rank)
      integer, intent(in) :: rank
      integer(i8) :: place(max_rank)
      integer(i8) :: rest
      integer :: m

      rest = i - 1
      place = 0
      do m = rank, 1, -1
         place(m) = start(m) + mod(rest, count(m))
         rest = rest/count(m)
      end do
   end function place_of

   !> The two values at a place, as texts; bytes are not shown.
   subroutine show_values(blocks, kind, unsigned, i, values)
      type(block_type), intent(in) :: blocks(2)
      !> One of the `as_*` codes.
      integer, intent(in) :: kind
      !> Whether integers have no sign.
      logical, intent(in) :: unsigned
      !> Number of the value in the block.
      integer(i8), intent(in) :: i
      type(string_type), intent(inout) :: values(2)
      integer :: side

      do side = 1, 2
         select case (kind)
         case (as_real)
            values(side)%s = to_text(blocks(side)%reals(i))
         case (as_integer)
            values(side)%s = integer_text(blocks(side)%integers(i), unsigned)
         case (as_text)
            values(side)%s = blocks(side)%texts(i)%s
         case default
            continue
         end select
      end do
   end subroutine show_values

   !> Whether a place comes before another one in the order of the indices.
   pure logical function precedes(place, other)
      integer(i8), intent(in) :: place(:), other(:)
      integer :: m

      precedes = .false.
      do m = 1, size(place)
         if (place(m) == other(m)) cycle
         precedes = place(m) < other(m)
         return
      end do
   end function precedes

   !> How the values of two items are compared, one of the `as_*` codes.
   pure integer function kind_of(items)
      type(hdf5_item_type), intent(in) :: items(2)

      if (items(1)%class == class_text) then
         kind_of = as_text
      else if (items(1)%class == class_raw) then
         kind_of = as_bytes
      else if (items(1)%class == items(2)%class .and. items(1)%class /= class_real) then
         kind_of = as_integer
      else
         kind_of = as_real
      end if
   end function kind_of

   !> Largest number of values of a block.
   pure integer(i8) function values_in_block(item, kind)
      type(hdf5_item_type), intent(in) :: item
      !> One of the `as_*` codes.
      integer, intent(in) :: kind

      values_in_block = block_numbers
      if (kind == as_text) values_in_block = block_texts
      if (kind == as_bytes) values_in_block = max(1_i8, block_bytes/item%size)
   end function values_in_block

   !> Read a block of values.
   subroutine read_block(item, kind, start, count, n, block, error)
      type(hdf5_item_type), intent(in) :: item
      !> One of the `as_*` codes.
      integer, intent(in) :: kind
      !> First indices, and numbers of indices.
      integer(i8), intent(in) :: start(:), count(:)
      !> Number of values; the first block is the largest.
      integer, intent(in) :: n
      type(block_type), intent(inout) :: block
      type(error_type), allocatable, intent(out) :: error

      select case (kind)
      case (as_real)
         if (.not. allocated(block%reals)) allocate(block%reals(n))
         call item%read(start, count, block%reals, error)
      case (as_integer)
         if (.not. allocated(block%integers)) allocate(block%integers(n))
         call item%read(start, count, block%integers, error)
      case (as_text)
         call item%read_texts(start, count, n, block%texts, error)
      case default
         if (.not. allocated(block%bytes)) allocate(block%bytes(n*int(item%size)))
         call item%read(start, count, block%bytes, error)
      end select
   end subroutine read_block

   !> Choose the extents of blocks: multiples of those of the chunks where there are any, so that no
   !> chunk is read twice.
   pure subroutine choose_tile(item, extents, rank, limit, tile)
      type(hdf5_item_type), intent(in) :: item
      !> Extents to read.
      integer(i8), intent(in) :: extents(max_rank)
      !> Number of dimensions.
      integer, intent(in) :: rank
      !> Values in a block.
      integer(i8), intent(in) :: limit
      !> Extents of a block.
      integer(i8), intent(out) :: tile(max_rank)
      real(wp) :: values
      integer :: d

      tile = 1
      tile(:rank) = min(max(item%chunk(:rank), 1_i8), extents(:rank))
      do d = 1, rank
         values = product(real(tile(:rank), wp))
         if (values <= real(limit, wp)) exit
         tile(d) = max(1_i8, int(real(tile(d), wp)*real(limit, wp)/values, i8))
      end do
      do d = rank, 1, -1
         values = product(real(tile(:rank), wp))
         tile(d) = int(min(real(extents(d), wp), &
            real(tile(d), wp)*max(1.0_wp, aint(real(limit, wp)/values))), i8)
         tile(d) = min(tile(d), extents(d))
         if (tile(d) < extents(d)) exit
      end do
   end subroutine choose_tile

   !> Decimal text of an integer.
   pure function integer_text(k, is_unsigned) result(text)
      integer(i8), intent(in) :: k
      !> Whether its bits are those of an unsigned one.
      logical, intent(in) :: is_unsigned
      character(len=:), allocatable :: text
      integer(i8) :: half

      text = to_text(k)
      if (k >= 0 .or. .not. is_unsigned) return
      half = shiftr(k, 1)
      text = to_text(half/5_i8) // to_text(2*mod(half, 5_i8) + iand(k, 1_i8))
   end function integer_text

   !> Two NaN are equal; one NaN differs beyond any tolerance.
   subroutine compare_reals(a, b, n, verdict, found, at)
      !> Values of the two files.
      real(wp), intent(in) :: a(:), b(:)
      integer, intent(in) :: n
      !> Tolerances.
      type(verdict_type), intent(in) :: verdict
      type(found_type), intent(inout) :: found
      !> Numbers of the values that are the new largest, relatively largest and first; or 0.
      integer(i8), intent(inout) :: at(3)
      real(wp), parameter :: half = 0.5_wp*huge(1.0_wp)
      real(wp) :: x, y, difference, relative, larger, bound
      integer :: i

      do i = 1, n
         x = a(i)
         y = b(i)
         if (transfer(x, 0_i8) == transfer(y, 0_i8)) cycle
         if (.not. (ieee_is_finite(x) .and. ieee_is_finite(y))) then
            if (ieee_is_nan(x) .and. ieee_is_nan(y)) cycle
            found%n_differ = found%n_differ + 1
            found%n_beyond = found%n_beyond + 1
            if (at(3) == 0_i8) at(3) = i
            if (ieee_is_nan(x) .or. ieee_is_nan(y)) then
               found%n_nan = found%n_nan + 1
               if (.not. ieee_is_nan(found%largest)) at(1) = i
               found%largest = merge(x, y, ieee_is_nan(x))
               found%relative = found%largest
            else if (ieee_is_finite(found%largest)) then
               at(1) = i
               found%largest = abs(merge(y, x, ieee_is_finite(x)))
               found%relative = found%largest
            end if
            cycle
         end if
         larger = max(abs(x), abs(y))
         if (larger < half) then
            difference = abs(x - y)
         else
            difference = abs(0.5_wp*x - 0.5_wp*y)
            difference = 2.0_wp*min(difference, half)
         end if
         ! Zeros of different sign are equal.
         if (difference <= 0.0_wp) cycle
         found%n_differ = found%n_differ + 1
         relative = difference/larger
         if (ieee_is_finite(found%largest)) then
            if (difference > found%largest) then
               found%largest = difference
               at(1) = i
            end if
            if (relative > found%relative) then
               found%relative = relative
               at(2) = i
            end if
         end if
         bound = verdict%atol
         if (difference <= bound) cycle
         if (verdict%rtol >= 1.0_wp) then
            if (larger > half/verdict%rtol - bound) cycle
         end if
         if (difference <= bound + verdict%rtol*larger) cycle
         found%n_beyond = found%n_beyond + 1
         if (at(3) == 0_i8) at(3) = i
      end do
   end subroutine compare_reals

   !> Numbers of one sign are subtracted as integers, so that neighbours differ.
   subroutine compare_integers(a, b, n, is_unsigned, verdict, found, at)
      !> Values of the two files.
      integer(i8), intent(in) :: a(:), b(:)
      integer, intent(in) :: n
      !> Whether they are unsigned.
      logical, intent(in) :: is_unsigned
      !> Tolerances.
      type(verdict_type), intent(in) :: verdict
      type(found_type), intent(inout) :: found
      !> Numbers of the values that are the new largest, relatively largest and first; or 0.
      integer(i8), intent(inout) :: at(3)
      real(wp), parameter :: wrap = 18446744073709551616.0_wp
      real(wp) :: x, y, difference, relative
      integer :: i

      do i = 1, n
         if (a(i) == b(i)) cycle
         x = real(a(i), wp)
         y = real(b(i), wp)
         if (is_unsigned .and. a(i) < 0_i8) x = x + wrap
         if (is_unsigned .and. b(i) < 0_i8) y = y + wrap
         if ((a(i) < 0_i8) .eqv. (b(i) < 0_i8)) then
            difference = abs(real(a(i) - b(i), wp))
         else
            difference = abs(x - y)
         end if
         found%n_differ = found%n_differ + 1
         relative = difference/max(abs(x), abs(y))
         if (difference > found%largest) then
            found%largest = difference
            at(1) = i
         end if
         if (relative > found%relative) then
            found%relative = relative
            at(2) = i
         end if
         if (difference <= verdict%atol) cycle
         if (relative <= verdict%rtol) cycle
         if (verdict%rtol < 1.0_wp .and. verdict%atol < 1.0e300_wp) then
            if (difference <= verdict%atol + verdict%rtol*max(abs(x), abs(y))) cycle
         end if
         found%n_beyond = found%n_beyond + 1
         if (at(3) == 0_i8) at(3) = i
      end do
   end subroutine compare_integers

   !> Compare texts; tolerances do not apply.
   subroutine compare_texts(a, b, n, path, found, at)
      !> Values of the first file.
      type(string_type), intent(in) :: a(:)
      !> Values of the second file.
      type(string_type), intent(in) :: b(:)
      integer, intent(in) :: n
      character(len=*), intent(in) :: path
      type(found_type), intent(inout) :: found
      !> Numbers of the values that are the new largest, relatively largest and first; or 0.
      integer(i8), intent(inout) :: at(3)
      integer :: i

      do i = 1, n
         if (len(a(i)%s) == len(b(i)%s)) then
            if (a(i)%s == b(i)%s) cycle
         end if
         if (path == "/input/resolved") then
            if (without_output_file(a(i)%s) == without_output_file(b(i)%s)) cycle
         end if
         found%n_differ = found%n_differ + 1
         found%n_beyond = found%n_beyond + 1
         if (at(3) == 0_i8) at(3) = i
      end do
   end subroutine compare_texts

   !> Settings without the name of the output file: it says where a result is, not what.
   pure function without_output_file(text) result(rest)
      !> Settings as a scene.
      character(len=*), intent(in) :: text
      !> The same without the line.
      character(len=:), allocatable :: rest
      character(len=*), parameter :: key = new_line("a") // "   file = "
      integer :: group, line, last

      rest = text
      group = index(text, new_line("a") // "&output" // new_line("a"), back=.true.)
      if (group == 0) return
      line = index(text(group:), key)
      if (line == 0) return
      line = group + line - 1
      last = index(text(line + 1:), new_line("a"))
      if (last == 0) return
      rest = text(:line) // text(line + 1 + last:)
   end function without_output_file

   !> Compare values byte for byte.
   subroutine compare_bytes(a, b, n, size, found, at)
      !> Values of the two files.
      integer(c_int8_t), intent(in) :: a(:), b(:)
      integer, intent(in) :: n
      !> Bytes of a value.
      integer, intent(in) :: size
      type(found_type), intent(inout) :: found
      !> Numbers of the values that are the new largest, relatively largest and first; or 0.
      integer(i8), intent(inout) :: at(3)
      integer :: i

      do i = 1, n
         if (all(a((i - 1)*size + 1:i*size) == b((i - 1)*size + 1:i*size))) cycle
         found%n_differ = found%n_differ + 1
         found%n_beyond = found%n_beyond + 1
         if (at(3) == 0_i8) at(3) = i
      end do
   end subroutine compare_bytes

end module contensou_compare_values
