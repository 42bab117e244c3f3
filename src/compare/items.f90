!> Comparison of two data sets or attributes: types, shapes, values, and where they differ.
module contensou_compare_items
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite, ieee_is_nan
   use contensou_base_errors, only : error_type
   use contensou_base_kinds, only : i8, wp
   use contensou_base_numbers, only : to_text
   use contensou_base_text, only : shorten, string_type
   use contensou_compare_listing, only : brief, count_of, listing_type, numbers_text, side_names
   use contensou_compare_places, only : place_text, printable
   use contensou_compare_values, only : compare_values, found_type, span_type, subject_type
   use contensou_files_hdf5_reader, only : class_integer, class_other, class_raw, class_real, &
      class_text, class_unsigned, hdf5_item_type, hdf5_reader_type, max_rank
   implicit none(type, external)
   private

   public :: compare_items, outcome_type

   !> What a comparison of two data sets or attributes comes to.
   type :: outcome_type
      !> Whether they differ.
      logical :: is_different = .false.
      !> Whether they differ within the tolerance only.
      logical :: is_within = .false.
      !> Whether they are times of rows that differ.
      logical :: times_differ = .false.
   end type outcome_type

contains

   !> Compare two data sets or attributes.
   subroutine compare_items(readers, listing, subject, span, outcome)
      type(hdf5_reader_type), intent(inout) :: readers(2)
      !> Where the results go.
      type(listing_type), intent(inout) :: listing
      type(subject_type), intent(in) :: subject
      type(span_type), intent(in) :: span
      type(outcome_type), intent(out) :: outcome
      type(hdf5_item_type) :: items(2)
      type(error_type), allocatable :: error
      type(found_type) :: found
      type(string_type) :: remarks(3)
      character(len=:), allocatable :: name, text
      integer(i8) :: extents(max_rank)
      integer :: side, i
      logical :: comparable

      name = subject%path
      if (subject%attribute /= "") name = name // "@" // subject%attribute
      do side = 1, 2
         call readers(side)%open_item(subject%path, subject%attribute, items(side), error)
         if (allocated(error)) exit
      end do
      if (.not. allocated(error)) then
         call compare_shapes(items, span, extents, remarks, comparable)
         do i = 1, 3
            outcome%is_different = outcome%is_different .or. allocated(remarks(i)%s)
         end do
         if (comparable) then
            if (any([items(1)%class, items(2)%class] == class_other)) then
               call listing%trouble(name // ": " // items(1)%type_text() // &
                  " cannot be compared; a rule can ignore them")
            else
               call compare_values(items, subject, extents, found, error)
            end if
         end if
      end if
      if (allocated(error)) call listing%trouble(error%message)
      outcome%is_within = found%n_differ > 0 .and. found%n_beyond == 0 .and. .not. &
         outcome%is_different
      outcome%is_different = outcome%is_different .or. found%n_beyond > 0
      if (outcome%is_different .or. outcome%is_within) then
         if (found%n_differ > 0) then
            if (any([items(1)%class, items(2)%class] == class_text) .or. &
               any([items(1)%class, items(2)%class] == class_raw)) then
               text = numbers_text("-", "-", found%n_beyond, found%n)
            else
               text = numbers_text(brief(found%largest), brief(found%relative), found%n_beyond, &
                  found%n)
            end if
            call listing%row(name, text)
         else
            call listing%row(name, merge("        differs", "               ", &
               outcome%is_different))
         end if
         do i = 1, 3
            if (allocated(remarks(i)%s)) call listing%detail("", remarks(i)%s)
         end do
         if (found%n_differ > 0) call describe_places(listing, items, subject, found)
         if (found%n_beyond > 0 .and. items(1)%rank == 1 .and. len(name) >= 5) then
            outcome%times_differ = name(len(name) - 4:) == "/time"
         end if
      end if
      do side = 1, 2
         call items(side)%close()
      end do
   end subroutine compare_items

   !> Compare types and shapes.
   subroutine compare_shapes(items, span, extents, remarks, comparable)
      type(hdf5_item_type), intent(in) :: items(2)
      type(span_type), intent(in) :: span
      !> Extents of the part that both have.
      integer(i8), intent(out) :: extents(max_rank)
      !> Differences: of type, of number of dimensions, of extents.
      type(string_type), intent(out) :: remarks(3)
      !> Whether the values can be compared.
      logical, intent(out) :: comparable
      character(len=:), allocatable :: words(:)
      integer(i8) :: sizes(2, max_rank)
      integer :: side, d
      logical :: numeric(2)

      extents = 1
      do side = 1, 2
         numeric(side) = any(items(side)%class == [class_real, class_integer, class_unsigned])
      end do
      comparable = all(numeric)
      if (.not. comparable) comparable = items(1)%class == items(2)%class
      if (items(1)%class == class_raw .and. items(2)%class == class_raw) comparable = &
         items(1)%same_type(items(2))
      allocate(character(len=96) :: words(2))
      words(1) = items(1)%type_text()
      words(2) = items(2)%type_text()
      if (words(1) /= words(2)) then
         remarks(1)%s = trim(words(1)) // " in A, " // trim(words(2)) // " in B"
      else if (.not. comparable) then
         remarks(1)%s = trim(words(1)) // " of another make in A than in B"
      end if
      if (items(1)%rank /= items(2)%rank .or. (items(1)%is_null .neqv. items(2)%is_null)) then
         remarks(2)%s = rank_text(items(1)) // " in A, " // rank_text(items(2)) // " in B"
         comparable = .false.
         return
      end if
      if (items(1)%is_null) comparable = .false.
      do side = 1, 2
         sizes(side, :) = items(side)%extents
         if (span%is_cut .and. items(side)%rank > 0) call rows_until(items(side), span%until, &
            sizes(side, 1))
      end do
      do d = 1, items(1)%rank
         extents(d) = minval(sizes(:, d))
         if (sizes(1, d) == sizes(2, d)) cycle
         if (allocated(remarks(3)%s)) then
            remarks(3)%s = remarks(3)%s // "; "
         else
            remarks(3)%s = ""
         end if
         remarks(3)%s = remarks(3)%s // length_text(items(1), d, sizes(1, d)) // " in A, " // &
            length_text(items(2), d, sizes(2, d)) // " in B"
      end do
      if (allocated(remarks(3)%s) .and. comparable) remarks(3)%s = remarks(3)%s // &
         "; the common part is compared"
   end subroutine compare_shapes

   !> Words for a number of dimensions.
   pure function rank_text(item) result(text)
      type(hdf5_item_type), intent(in) :: item
      !> Such as "2 dimensions".
      character(len=:), allocatable :: text

      if (item%is_null) then
         text = "no value"
      else if (item%rank == 0) then
         text = "a single value"
      else
         text = count_of(item%rank, "dimension")
      end if
   end function rank_text

   !> Words for a length.
   function length_text(item, d, length) result(text)
      type(hdf5_item_type), intent(in) :: item
      !> Dimension, from 1.
      integer, intent(in) :: d
      integer(i8), intent(in) :: length
      !> Such as "2001 times".
      character(len=:), allocatable :: text
      type(hdf5_item_type) :: scale

      text = to_text(length) // " values"
      if (item%rank > 1) text = to_text(length) // " in dimension " // to_text(d)
      call item%open_scale(d - 1, scale)
      if (scale%is_open() .and. scale%name == "time") then
         text = to_text(length) // " times"
      else if (scale%is_open() .and. scale%name /= "") then
         text = to_text(length) // " along " // printable(scale%name)
      end if
      call scale%close()
   end function length_text

   !> Number of rows up to a time; all where rows are not those of a time.
   subroutine rows_until(item, until, n)
      type(hdf5_item_type), intent(in) :: item
      !> The time [s].
      real(wp), intent(in) :: until
      !> All rows; on return those up to the time.
      integer(i8), intent(inout) :: n
      type(hdf5_item_type) :: scale
      type(error_type), allocatable :: error
      integer(i8) :: low, high, middle
      real(wp) :: time(1)
      logical :: later

      call item%open_scale(0, scale)
      if (scale%is_open()) then
         if (scale%name == "time" .and. scale%class == class_real) then
            ! Times grow: the first one after `until` is found by halving.
            low = 0
            high = min(n, scale%extents(1))
            do while (low < high)
               middle = low + (high - low)/2
               call scale%read([middle], [1_i8], time, error)
               if (allocated(error)) exit
               later = ieee_is_nan(time(1))
               if (.not. later) later = time(1) > until
               if (later) then
                  high = middle
               else
                  low = middle + 1
               end if
            end do
            if (.not. allocated(error)) n = low
         end if
      end if
      call scale%close()
   end subroutine rows_until

   !> Say where the differences are.
   subroutine describe_places(listing, items, subject, found)
      type(listing_type), intent(inout) :: listing
      type(hdf5_item_type), intent(in) :: items(2)
      type(subject_type), intent(in) :: subject
      type(found_type), intent(in) :: found
      character(len=:), allocatable :: units

      if (found%n_nan > 0) call listing%detail("NaN", to_text(found%n_nan) // &
         " not a number in one file only")
      if (items(1)%class == class_text) then
         call say("first", found%at_first, found%values_first)
         return
      else if (items(1)%class == class_raw) then
         call listing%detail("first", place_text(items(1), subject%path, found%at_first))
         return
      end if
      units = ""
      if (subject%attribute == "") units = items(1)%units()
      if (units == "1") units = ""
      if (units /= "") units = " " // printable(units)
      call say("largest", found%at_largest, found%values_largest)
      if (ieee_is_finite(found%relative) .and. any(found%at_relative /= found%at_largest)) then
         call say("relative", found%at_relative, found%values_relative)
      end if
      if (found%n_beyond > 0 .and. any(found%at_first /= found%at_largest)) then
         call say("first", found%at_first, found%values_first)
      else if (found%n_beyond > 0 .and. found%n > 1) then
         call listing%detail("first", "the same")
      end if

   contains

      !> Say where something is, and which values are there.
      subroutine say(label, place, values)
         character(len=*), intent(in) :: label
         !> Indices.
         integer(i8), intent(in) :: place(max_rank)
         !> The two values.
         type(string_type), intent(in) :: values(2)
         character(len=:), allocatable :: where_text
         character(len=9) :: head

         where_text = place_text(items(1), subject%path, place)
         head = label
         if (where_text /= "") then
            call listing%detail(head, where_text)
            head = ""
         end if
         if (items(1)%class == class_text) then
            call say_texts(listing, head, values)
         else if (len(values(1)%s) + len(values(2)%s) + 2*len(units) < 66) then
            call listing%detail(head, values(1)%s // units // " in A, " // values(2)%s // units // &
               " in B")
         else
            call listing%detail(head, values(1)%s // units // " in A")
            call listing%detail("", values(2)%s // units // " in B")
         end if
      end subroutine say

   end subroutine describe_places

   !> Show two texts that differ; of texts with lines the first line that does.
   subroutine say_texts(listing, label, values)
      type(listing_type), intent(inout) :: listing
      !> Word that begins the line.
      character(len=*), intent(in) :: label
      !> The two texts.
      type(string_type), intent(in) :: values(2)
      character(len=*), parameter :: nl = new_line("a")
      type(string_type) :: lines(2)
      character(len=:), allocatable :: prefix
      integer :: first(2), last(2), line, side

      first = 1
      line = 0
      do
         line = line + 1
         do side = 1, 2
            last(side) = index(values(side)%s(first(side):), nl)
            if (last(side) == 0) then
               last(side) = len(values(side)%s)
            else
               last(side) = first(side) + last(side) - 2
            end if
            lines(side)%s = values(side)%s(first(side):last(side))
         end do
         if (len(lines(1)%s) /= len(lines(2)%s)) exit
         if (lines(1)%s /= lines(2)%s) exit
         first = last + 2
         if (first(1) > len(values(1)%s) .or. first(2) > len(values(2)%s)) exit
      end do
      prefix = ""
      if (index(values(1)%s, nl) > 0 .or. index(values(2)%s, nl) > 0) prefix = "line " // &
         to_text(line) // " "
      do side = 1, 2
         if (first(side) > len(values(side)%s) + 1) lines(side)%s = ""
         call listing%detail(merge(label, repeat(" ", len(label)), side == 1), prefix // &
            "'" // shorten(printable(lines(side)%s), 60) // "' in " // side_names(side))
      end do
   end subroutine say_texts

end module contensou_compare_items
