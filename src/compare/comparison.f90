!> Comparison of two HDF5 files, in words of the physics: which data sets and attributes differ, by
!> how much, where most and where first, in terms of the scales of their dimensions (time, body,
!> component, contact, case).
!>
!> The results go to a `comparison_output_type` line by line as they are found.
module contensou_compare_comparison
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite, ieee_is_nan
   use contensou_base_errors, only : error_type
   use contensou_base_kinds, only : i8, wp
   use contensou_base_text, only : shorten, string_type, to_text
   use contensou_compare_events, only : event_matcher_type, event_note_type
   use contensou_compare_places, only : place_text, printable, time_text
   use contensou_compare_rules, only : rules_type, verdict_type
   use contensou_compare_values, only : block_texts, compare_values, found_type
   use contensou_files_hdf5_reader, only : class_integer, class_other, class_raw, class_real, &
      class_text, class_unsigned, hdf5_entry_type, hdf5_item_type, hdf5_reader_type, link_hard, &
      max_rank, object_dataset, object_group, object_type
   implicit none(type, external)
   private

   public :: comparison_type, comparison_output_type

   !> Where the results go.
   type, abstract :: comparison_output_type
      !> Whether nothing can be written any more; the comparison then ends.
      logical :: broken = .false.
   contains
      !> Take a line of results.
      procedure(take_text), deferred :: line
      !> Take a message about what could not be compared.
      procedure(take_text), deferred :: trouble
   end type comparison_output_type

   abstract interface
      !> Take a text without line end.
      subroutine take_text(self, text)
         import :: comparison_output_type
         implicit none(type, external)
         !> Where it goes.
         class(comparison_output_type), intent(inout) :: self
         character(len=*), intent(in) :: text
      end subroutine take_text
   end interface

   !> A comparison: what is asked for, and the count of what was found.
   type :: comparison_type
      type(rules_type) :: rules
      !> Whether rows after a time are left out.
      logical :: has_until = .false.
      !> That time [s].
      real(wp) :: until = 0.0_wp
      !> Data sets that were compared.
      integer :: n_datasets = 0
      !> Attributes that were compared.
      integer :: n_attributes = 0
      !> Objects and attributes that the rules leave out.
      integer :: n_ignored = 0
      !> Data sets that differ but agree within their tolerance.
      integer :: n_within = 0
      !> Data sets that differ.
      integer :: n_different = 0
      !> Attributes that differ.
      integer :: n_different_attributes = 0
      !> Objects that one file alone has, or that are of another nature.
      integer :: n_missing = 0
      !> What could not be compared.
      integer :: n_trouble = 0
      !> The two files.
      type(hdf5_reader_type), private :: readers(2)
      !> Where the results go.
      class(comparison_output_type), pointer, private :: output => null()
      !> Links seen so far.
      integer, private :: n_links = 0
      !> Whether to give up.
      logical, private :: stopped = .false.
      !> Whether the head of the table is written.
      logical, private :: has_head = .false.
      !> Whether the events are compared as such.
      logical, private :: has_events = .false.
      !> Pairs of groups and the number of visits to them, as a hash table.
      integer(i8), allocatable, private :: visits(:, :)
      !> Number of such pairs.
      integer, private :: n_visited = 0
      !> The last message about what could not be compared.
      character(len=:), allocatable, private :: last_trouble
      !> Whether times of rows differ.
      logical, private :: times_differ = .false.
   contains
      !> Compare two files.
      procedure :: run
      !> Whether they differ.
      procedure :: different
   end type comparison_type

   !> Groups on the way to the one that is being looked at.
   type :: way_type
      !> Their number.
      integer :: depth = 0
      !> Their addresses in the two files.
      integer(i8) :: addresses(2, 100) = 0_i8
   end type way_type

   !> Links that are looked at.
   integer, parameter :: max_links = 300000

   !> Paths of one group that are followed: groups that hold each other can have any number of them.
   integer, parameter :: max_paths = 16

   !> Messages about trouble that are written.
   integer, parameter :: max_trouble = 50

   !> Lines of differences that belong to a data set are indented.
   character(len=*), parameter :: indent = "   "

   !> The names of the files in the results.
   character(len=1), parameter :: side_names(2) = ["A", "B"]

   !> Attributes by which HDF5 ties scales to dimensions: addresses, which mean nothing elsewhere.
   character(len=*), parameter :: scale_links(2) = [character(len=14) :: "DIMENSION_LIST", &
      "REFERENCE_LIST"]

   !> Data sets that are compared as events.
   character(len=*), parameter :: event_parts(3) = [character(len=15) :: "/events/time", &
      "/events/kind", "/events/contact"]

contains

   !> Compare two files.
   subroutine run(self, paths, output, error)
      !> What is asked for, and the counts.
      class(comparison_type), intent(inout) :: self
      !> Names of the files.
      type(string_type), intent(in) :: paths(2)
      !> Where the results go.
      class(comparison_output_type), intent(inout), target :: output
      !> Set when a file cannot be opened.
      type(error_type), allocatable, intent(out) :: error

      type(way_type) :: way
      integer :: side

      self%output => output
      do side = 1, 2
         call self%readers(side)%open(paths(side)%s, error)
         if (allocated(error)) exit
      end do
      if (.not. allocated(error)) then
         call compare_groups(self, "/", way)
         if (self%times_differ) call output%line( &
            "note: the times of A and B differ; rows are compared by their number")
         call summarize(self)
      end if
      do side = 1, 2
         call self%readers(side)%close()
      end do
      self%output => null()
   end subroutine run

   !> Whether the files differ.
   pure function different(self) result(answer)
      class(comparison_type), intent(in) :: self
      logical :: answer

      answer = self%n_different + self%n_different_attributes + self%n_missing > 0
   end function different

   !> The last line.
   subroutine summarize(self)
      class(comparison_type), intent(inout) :: self

      character(len=:), allocatable :: text

      if (self%has_head) call self%output%line("")
      if (self%different()) then
         text = "different: " // count_of(self%n_different, "data set")
         if (self%n_different_attributes > 0) text = text // ", " // &
            count_of(self%n_different_attributes, "attribute")
         if (self%n_missing > 0) text = text // ", " // to_text(self%n_missing) // &
            " in one file only"
         text = text // "; " // to_text(self%n_datasets) // " compared"
      else if (self%n_trouble > 0) then
         text = "no difference in what could be compared: " // &
            count_of(self%n_datasets, "data set") // ", " // &
            count_of(self%n_attributes, "attribute")
      else
         text = "same: " // count_of(self%n_datasets, "data set") // ", " // &
            count_of(self%n_attributes, "attribute")
      end if
      if (self%n_within > 0) text = text // ", " // to_text(self%n_within) // " within tolerance"
      text = text // ", " // to_text(self%n_ignored) // " ignored"
      call self%output%line(text)
   end subroutine summarize

   !> A number of things.
   pure function count_of(n, thing) result(text)
      !> The number.
      integer, intent(in) :: n
      !> One of them.
      character(len=*), intent(in) :: thing
      !> Such as "2 data sets".
      character(len=:), allocatable :: text

      text = to_text(n) // " " // thing
      if (n /= 1) text = text // "s"
   end function count_of

   !> Note that something could not be compared.
   subroutine note_trouble(self, message)
      class(comparison_type), intent(inout) :: self
      !> What and why.
      character(len=*), intent(in) :: message

      if (allocated(self%last_trouble)) then
         ! What cannot be opened is met again when its attributes are listed.
         if (self%last_trouble == message) return
      end if
      self%last_trouble = message
      self%n_trouble = self%n_trouble + 1
      if (self%n_trouble < max_trouble) call self%output%trouble(printable(message))
      if (self%n_trouble == max_trouble) call self%output%trouble( &
         printable(message) // new_line("a") // "... more of this kind is not shown")
   end subroutine note_trouble

   !> Write a line about an object, under the head of the table.
   subroutine row(self, path, text)
      class(comparison_type), intent(inout) :: self
      !> Path of the object, or of the object and its attribute.
      character(len=*), intent(in) :: path
      !> What is said of it; empty for nothing as yet.
      character(len=*), intent(in) :: text

      character(len=:), allocatable :: name

      if (.not. self%has_head) call self%output%line(column("", 34) // &
         "     max |A - B|   relative    beyond        of")
      self%has_head = .true.
      name = printable(path)
      if (len(name) > 34 .and. text /= "") then
         call self%output%line(name)
         name = ""
      end if
      if (text == "") then
         call self%output%line(name)
      else
         call self%output%line(column(name, 34) // "  " // text)
      end if
   end subroutine row

   !> Write a line that goes on about an object.
   subroutine detail(self, label, text)
      class(comparison_type), intent(inout) :: self
      !> What it is about, in a word; blank to go on.
      character(len=*), intent(in) :: label
      !> What is said.
      character(len=*), intent(in) :: text

      call self%output%line(indent // column(label, 9) // text)
   end subroutine detail

   !> A text in a column.
   pure function column(text, width) result(padded)
      character(len=*), intent(in) :: text
      !> Number of characters.
      integer, intent(in) :: width
      !> The text, filled up with blanks.
      character(len=:), allocatable :: padded

      padded = text // repeat(" ", max(0, width - len(text)))
   end function column

   !> A difference in four digits.
   pure function brief(x) result(text)
      !> Difference, not negative.
      real(wp), intent(in) :: x
      character(len=:), allocatable :: text

      character(len=16) :: buffer

      if (ieee_is_nan(x)) then
         text = "NaN"
      else if (.not. ieee_is_finite(x)) then
         text = "Infinity"
      else if (x <= 0.0_wp) then
         text = "0"
      else if (x >= 1.0e-99_wp .and. x < 9.0e99_wp) then
         write (buffer, "(es10.3e2)") x
         text = trim(adjustl(buffer))
      else
         write (buffer, "(es11.3e3)") x
         text = trim(adjustl(buffer))
      end if
   end function brief

   !> The columns of numbers of the table.
   pure function numbers(largest, relative, n_beyond, n) result(text)
      !> Largest absolute difference, as text.
      character(len=*), intent(in) :: largest
      !> Largest relative difference, as text.
      character(len=*), intent(in) :: relative
      !> Values beyond the tolerance.
      integer(i8), intent(in) :: n_beyond
      !> Values compared.
      integer(i8), intent(in) :: n
      !> The columns.
      character(len=:), allocatable :: text

      text = right(largest, 14) // right(relative, 11) // right(to_text(n_beyond), 10) // &
         right(to_text(n), 10)
   end function numbers

   !> A text at the right of a column.
   pure function right(text, width) result(padded)
      character(len=*), intent(in) :: text
      !> Number of characters.
      integer, intent(in) :: width
      !> The text after blanks, one at least.
      character(len=:), allocatable :: padded

      padded = repeat(" ", max(1, width - len(text))) // text
   end function right

   !> Compare what two groups hold.
   recursive subroutine compare_groups(self, path, way)
      class(comparison_type), intent(inout) :: self
      !> Path of the groups.
      character(len=*), intent(in) :: path
      !> Groups on the way to them.
      type(way_type), intent(inout) :: way

      type(hdf5_entry_type), allocatable :: a(:), b(:)
      integer :: i, j, order

      call compare_attributes(self, path)
      call enter_group(self, path, [.true., .true.], way, order)
      if (order /= 0) return
      call list_members(self, path, [.true., .true.], a, b, order)
      if (order == 0) then
         if (path == "/events") call compare_events(self)
         i = 1
         j = 1
         do while (i <= size(a) .or. j <= size(b))
            if (self%stopped .or. self%output%broken) exit
            order = next_of(a, b, i, j)
            self%n_links = self%n_links + 1
            if (self%n_links > max_links) then
               call note_trouble(self, "more than " // to_text(max_links) // &
                  " objects: the rest is not compared")
               self%stopped = .true.
               exit
            end if
            if (order == 0) then
               call compare_links(self, joined(path, a(i)%name), a(i)%link, b(j)%link, way)
            else if (order < 0) then
               call note_missing(self, 1, joined(path, a(i)%name), a(i)%link, way)
            else
               call note_missing(self, 2, joined(path, b(j)%name), b(j)%link, way)
            end if
            if (order <= 0) i = i + 1
            if (order >= 0) j = j + 1
         end do
      end if
      way%depth = way%depth - 1
   end subroutine compare_groups

   !> Go into a group, unless the way has led through it before or is too long.
   subroutine enter_group(self, path, sides, way, code)
      class(comparison_type), intent(inout) :: self
      !> Path of the group.
      character(len=*), intent(in) :: path
      !> In which files.
      logical, intent(in) :: sides(2)
      !> Way; longer by one if `code` is 0.
      type(way_type), intent(inout) :: way
      !> 0 if the group was entered.
      integer, intent(out) :: code

      type(error_type), allocatable :: error
      integer(i8) :: addresses(2)
      integer :: i, kind, side

      code = 1
      addresses = 0_i8
      do side = 1, 2
         if (.not. sides(side)) cycle
         call self%readers(side)%object(path, kind, addresses(side), error)
         if (allocated(error)) then
            call note_trouble(self, error%message)
            return
         end if
      end do
      do i = 1, way%depth
         if (all(way%addresses(:, i) == addresses .or. .not. sides)) return
      end do
      if (visits_of(self, addresses) > max_paths) then
         call note_trouble(self, "groups with more than " // to_text(max_paths) // &
            " paths are not compared under all of them")
         return
      end if
      if (way%depth == size(way%addresses, 2)) then
         call note_trouble(self, "groups nested more than " // &
            to_text(size(way%addresses, 2)) // " deep are not compared: " // path)
         return
      end if
      way%depth = way%depth + 1
      way%addresses(:, way%depth) = addresses
      code = 0
   end subroutine enter_group

   !> Count a visit to a pair of groups.
   function visits_of(self, addresses) result(n)
      class(comparison_type), intent(inout) :: self
      !> Addresses of the groups.
      integer(i8), intent(in) :: addresses(2)
      !> Number of visits so far, this one included.
      integer :: n

      integer(i8), allocatable :: table(:, :), longer(:, :)
      integer :: i, k

      if (.not. allocated(self%visits)) then
         allocate(self%visits(3, 0:63))
         self%visits = 0_i8
      end if
      if (2*self%n_visited > size(self%visits, 2)) then
         allocate(longer(3, 0:2*size(self%visits, 2) - 1))
         longer = 0_i8
         call move_alloc(self%visits, table)
         do i = 0, ubound(table, 2)
            if (table(3, i) == 0_i8) cycle
            k = slot_of(longer, table(:2, i))
            longer(:, k) = table(:, i)
         end do
         call move_alloc(longer, self%visits)
      end if
      k = slot_of(self%visits, addresses)
      if (self%visits(3, k) == 0_i8) self%n_visited = self%n_visited + 1
      self%visits(:2, k) = addresses
      self%visits(3, k) = self%visits(3, k) + 1_i8
      n = int(self%visits(3, k))
   end function visits_of

   !> Place of a pair of addresses in a table, by open addressing.
   pure function slot_of(table, addresses) result(k)
      !> Addresses and counts; a power of two of them, some of which are free.
      integer(i8), intent(in) :: table(:, 0:)
      !> The pair.
      integer(i8), intent(in) :: addresses(2)
      !> Its place, or a free one.
      integer :: k

      k = int(iand(ieor(ieor(addresses(1), shiftr(addresses(1), 7)), &
         ieor(shiftl(addresses(2), 3), shiftr(addresses(2), 11))), &
         int(size(table, 2) - 1, i8)))
      do while (table(3, k) /= 0_i8)
         if (all(table(:2, k) == addresses)) exit
         k = modulo(k + 1, size(table, 2))
      end do
   end function slot_of

   !> List what two groups hold.
   subroutine list_members(self, path, sides, a, b, code)
      class(comparison_type), intent(inout) :: self
      !> Path of the groups.
      character(len=*), intent(in) :: path
      !> In which files.
      logical, intent(in) :: sides(2)
      !> Members in the first file.
      type(hdf5_entry_type), allocatable, intent(out) :: a(:)
      !> Members in the second file.
      type(hdf5_entry_type), allocatable, intent(out) :: b(:)
      !> 0 on success.
      integer, intent(out) :: code

      type(error_type), allocatable :: error

      code = 0
      if (sides(1)) call self%readers(1)%list(path, .false., a, error)
      if (.not. allocated(error) .and. sides(2)) call self%readers(2)%list(path, .false., b, error)
      if (.not. allocated(error)) return
      code = 1
      call note_trouble(self, error%message)
   end subroutine list_members

   !> Path of a member of a group.
   pure function joined(path, name) result(whole)
      !> Path of the group.
      character(len=*), intent(in) :: path
      !> Name of the member.
      character(len=*), intent(in) :: name
      !> The path.
      character(len=:), allocatable :: whole

      whole = path // "/" // name
      if (path == "/") whole = "/" // name
   end function joined

   !> Which of two sorted lists has the next name: negative for the first, 0 for both.
   pure function next_of(a, b, i, j) result(order)
      !> First list.
      type(hdf5_entry_type), intent(in) :: a(:)
      !> Second list.
      type(hdf5_entry_type), intent(in) :: b(:)
      !> Place in the first.
      integer, intent(in) :: i
      !> Place in the second.
      integer, intent(in) :: j
      !> The answer.
      integer :: order

      integer :: k

      if (i > size(a)) then
         order = 1
         return
      else if (j > size(b)) then
         order = -1
         return
      end if
      ! Not by Fortran's comparison, for which trailing blanks do not count.
      associate (x => a(i)%name, y => b(j)%name)
         do k = 1, min(len(x), len(y))
            order = ichar(x(k:k)) - ichar(y(k:k))
            if (order /= 0) return
         end do
         order = len(x) - len(y)
      end associate
   end function next_of

   !> Compare what two links of the same name lead to.
   recursive subroutine compare_links(self, path, link_a, link_b, way)
      class(comparison_type), intent(inout) :: self
      !> Their path.
      character(len=*), intent(in) :: path
      !> Kind of the link in the first file.
      integer, intent(in) :: link_a
      !> Kind of the link in the second file.
      integer, intent(in) :: link_b
      !> Groups on the way.
      type(way_type), intent(inout) :: way

      type(error_type), allocatable :: error
      type(string_type) :: words(2)
      type(verdict_type) :: verdict
      character(len=:), allocatable :: target
      integer(i8) :: address
      integer :: links(2), kinds(2), side

      links = [link_a, link_b]
      kinds = 0
      verdict = self%rules%verdict(path, "")
      do side = 1, 2
         if (links(side) == link_hard) then
            call self%readers(side)%object(path, kinds(side), address, error)
            words(side)%s = kind_text(kinds(side))
         else
            call self%readers(side)%link_value(path, target, error)
            if (.not. allocated(error)) words(side)%s = "a link to " // target
         end if
         if (allocated(error)) then
            if (verdict%ignore) then
               self%n_ignored = self%n_ignored + 1
            else
               call note_trouble(self, error%message)
            end if
            return
         end if
      end do
      if (all(kinds == object_group)) then
         call compare_groups(self, path, way)
      else if (verdict%ignore) then
         self%n_ignored = self%n_ignored + 1
      else if (words(1)%s /= words(2)%s) then
         self%n_missing = self%n_missing + 1
         call row(self, path, printable(words(1)%s // " in A, " // words(2)%s // " in B"))
      else if (all(kinds == object_dataset)) then
         call compare_datasets(self, path, verdict)
      else if (all(kinds == object_type)) then
         call compare_attributes(self, path)
      end if
   end subroutine compare_links

   !> What an object is.
   pure function kind_text(kind) result(text)
      !> One of the `object_*` parameters.
      integer, intent(in) :: kind
      !> Its name.
      character(len=:), allocatable :: text

      select case (kind)
      case (object_group)
         text = "a group"
      case (object_dataset)
         text = "a data set"
      case (object_type)
         text = "a data type"
      case default
         text = "an object of unknown kind"
      end select
   end function kind_text

   !> Note an object that one file alone has.
   subroutine note_missing(self, side, path, link, way)
      class(comparison_type), intent(inout) :: self
      !> The file that has it, 1 or 2.
      integer, intent(in) :: side
      character(len=*), intent(in) :: path
      !> Kind of the link.
      integer, intent(in) :: link
      !> Groups on the way.
      type(way_type), intent(inout) :: way

      type(error_type), allocatable :: error
      type(verdict_type) :: verdict
      integer(i8) :: address
      integer :: kind, n_compared, n_ignored

      verdict = self%rules%verdict(path, "")
      kind = object_dataset
      if (link == link_hard) call self%readers(side)%object(path, kind, address, error)
      if (allocated(error)) then
         if (verdict%ignore) then
            self%n_ignored = self%n_ignored + 1
         else
            call note_trouble(self, error%message)
         end if
         return
      end if
      if (kind == object_group) then
         n_compared = 0
         n_ignored = 0
         call count_members(self, side, path, way, n_compared, n_ignored)
         self%n_ignored = self%n_ignored + n_ignored
         if (n_compared == 0 .and. (n_ignored > 0 .or. verdict%ignore)) return
         self%n_missing = self%n_missing + 1
         call row(self, path, "only in " // side_names(side) // ": a group of " // &
            count_of(n_compared, "data set"))
      else if (verdict%ignore) then
         self%n_ignored = self%n_ignored + 1
      else
         self%n_missing = self%n_missing + 1
         call row(self, path, "only in " // side_names(side))
      end if
   end subroutine note_missing

   !> Count what a group that one file alone has holds.
   recursive subroutine count_members(self, side, path, way, n_compared, n_ignored)
      class(comparison_type), intent(inout) :: self
      !> The file, 1 or 2.
      integer, intent(in) :: side
      !> Path of the group.
      character(len=*), intent(in) :: path
      !> Groups on the way.
      type(way_type), intent(inout) :: way
      !> Grows by the number of objects that would be compared.
      integer, intent(inout) :: n_compared
      !> Grows by the number of objects that the rules leave out.
      integer, intent(inout) :: n_ignored

      type(hdf5_entry_type), allocatable :: entries(:), others(:)
      type(error_type), allocatable :: error
      type(verdict_type) :: verdict
      integer(i8) :: address
      integer :: i, code, kind
      logical :: sides(2)

      sides = [side == 1, side == 2]
      call enter_group(self, path, sides, way, code)
      if (code /= 0) return
      if (side == 1) call list_members(self, path, sides, entries, others, code)
      if (side == 2) call list_members(self, path, sides, others, entries, code)
      if (code == 0) then
         do i = 1, size(entries)
            self%n_links = self%n_links + 1
            if (self%n_links > max_links) exit
            kind = object_dataset
            if (entries(i)%link == link_hard) call self%readers(side)%object( &
               joined(path, entries(i)%name), kind, address, error)
            if (allocated(error)) then
               call note_trouble(self, error%message)
            else if (kind == object_group) then
               call count_members(self, side, joined(path, entries(i)%name), way, n_compared, &
                  n_ignored)
            else
               verdict = self%rules%verdict(joined(path, entries(i)%name), "")
               if (verdict%ignore) then
                  n_ignored = n_ignored + 1
               else
                  n_compared = n_compared + 1
               end if
            end if
         end do
      end if
      way%depth = way%depth - 1
   end subroutine count_members

   !> Compare the attributes of two objects.
   subroutine compare_attributes(self, path)
      class(comparison_type), intent(inout) :: self
      !> Path of the objects.
      character(len=*), intent(in) :: path

      type(hdf5_entry_type), allocatable :: a(:), b(:)
      type(error_type), allocatable :: error
      integer :: i, j, order

      call self%readers(1)%list(path, .true., a, error)
      if (.not. allocated(error)) call self%readers(2)%list(path, .true., b, error)
      if (allocated(error)) then
         call note_trouble(self, error%message)
         return
      end if
      i = 1
      j = 1
      do while (i <= size(a) .or. j <= size(b))
         if (self%output%broken) exit
         order = next_of(a, b, i, j)
         if (order == 0) then
            call compare_attribute(self, path, a(i)%name)
         else if (order < 0) then
            call note_missing_attribute(self, 1, path, a(i)%name)
         else
            call note_missing_attribute(self, 2, path, b(j)%name)
         end if
         if (order <= 0) i = i + 1
         if (order >= 0) j = j + 1
      end do
   end subroutine compare_attributes

   !> Note an attribute that one file alone has.
   subroutine note_missing_attribute(self, side, path, name)
      class(comparison_type), intent(inout) :: self
      !> The file that has it, 1 or 2.
      integer, intent(in) :: side
      !> Path of its object.
      character(len=*), intent(in) :: path
      character(len=*), intent(in) :: name

      type(verdict_type) :: verdict

      if (any(name == scale_links)) return
      verdict = self%rules%verdict(path, name)
      if (verdict%ignore) then
         self%n_ignored = self%n_ignored + 1
      else
         self%n_different_attributes = self%n_different_attributes + 1
         call row(self, path // "@" // name, "only in " // side_names(side))
      end if
   end subroutine note_missing_attribute

   !> Compare two attributes.
   subroutine compare_attribute(self, path, name)
      class(comparison_type), intent(inout) :: self
      !> Path of their objects.
      character(len=*), intent(in) :: path
      !> Their name.
      character(len=*), intent(in) :: name

      type(verdict_type) :: verdict
      logical :: is_different, is_within

      if (any(name == scale_links)) return
      verdict = self%rules%verdict(path, name)
      if (verdict%ignore) then
         self%n_ignored = self%n_ignored + 1
         return
      end if
      self%n_attributes = self%n_attributes + 1
      call compare_items(self, path, name, verdict, is_different, is_within)
      if (is_different) self%n_different_attributes = self%n_different_attributes + 1
   end subroutine compare_attribute

   !> Compare two data sets and their attributes.
   subroutine compare_datasets(self, path, verdict)
      class(comparison_type), intent(inout) :: self
      !> Their path.
      character(len=*), intent(in) :: path
      !> What the rules say.
      type(verdict_type), intent(in) :: verdict

      logical :: is_different, is_within

      self%n_datasets = self%n_datasets + 1
      if (.not. (self%has_events .and. any(path == event_parts))) then
         call compare_items(self, path, "", verdict, is_different, is_within)
         if (is_different) self%n_different = self%n_different + 1
         if (is_within) self%n_within = self%n_within + 1
      end if
      call compare_attributes(self, path)
   end subroutine compare_datasets

   !> Compare two data sets or attributes.
   subroutine compare_items(self, path, attribute, verdict, is_different, is_within)
      class(comparison_type), intent(inout) :: self
      !> Path of the data sets, or of the objects that have the attributes.
      character(len=*), intent(in) :: path
      !> Name of the attributes; empty for data sets.
      character(len=*), intent(in) :: attribute
      !> What the rules say.
      type(verdict_type), intent(in) :: verdict
      !> Whether they differ.
      logical, intent(out) :: is_different
      !> Whether they differ within the tolerance.
      logical, intent(out) :: is_within

      type(hdf5_item_type) :: items(2)
      type(error_type), allocatable :: error
      type(found_type) :: found
      type(string_type) :: remarks(3)
      character(len=:), allocatable :: name, text
      integer(i8) :: extents(max_rank)
      integer :: side, i
      logical :: comparable

      is_different = .false.
      is_within = .false.
      name = path
      if (attribute /= "") name = path // "@" // attribute
      do side = 1, 2
         call self%readers(side)%open_item(path, attribute, items(side), error)
         if (allocated(error)) exit
      end do
      if (.not. allocated(error)) then
         call compare_shapes(self, items, extents, remarks, comparable)
         do i = 1, 3
            is_different = is_different .or. allocated(remarks(i)%s)
         end do
         if (comparable) then
            if (any([items(1)%class, items(2)%class] == class_other)) then
               call note_trouble(self, name // ": " // items(1)%type_text() // &
                  " cannot be compared; a rule can ignore them")
            else
               call compare_values(items, path, attribute /= "", extents, verdict, found, error)
            end if
         end if
      end if
      if (allocated(error)) call note_trouble(self, error%message)
      is_within = found%n_differ > 0_i8 .and. found%n_beyond == 0_i8 .and. .not. is_different
      is_different = is_different .or. found%n_beyond > 0_i8
      if (is_different .or. is_within) then
         if (found%n_differ > 0_i8) then
            if (any([items(1)%class, items(2)%class] == class_text) .or. &
               any([items(1)%class, items(2)%class] == class_raw)) then
               text = numbers("-", "-", found%n_beyond, found%n)
            else
               text = numbers(brief(found%largest), brief(found%relative), found%n_beyond, found%n)
            end if
            call row(self, name, text)
         else
            call row(self, name, merge("        differs", "               ", is_different))
         end if
         do i = 1, 3
            if (allocated(remarks(i)%s)) call detail(self, "", remarks(i)%s)
         end do
         if (found%n_differ > 0_i8) call describe_places(self, items, path, attribute, found)
         if (attribute == "" .and. found%n_beyond > 0_i8 .and. len(path) >= 5) then
            if (path(len(path) - 4:) == "/time" .and. items(1)%rank == 1) then
               self%times_differ = .true.
            end if
         end if
      end if
      do side = 1, 2
         call items(side)%close()
      end do
   end subroutine compare_items

   !> Compare types and shapes.
   subroutine compare_shapes(self, items, extents, remarks, comparable)
      class(comparison_type), intent(in) :: self
      !> The two items.
      type(hdf5_item_type), intent(in) :: items(2)
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

      extents = 1_i8
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
         if (self%has_until .and. items(side)%rank > 0) call rows_until(items(side), self%until, &
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
      integer(i8) :: low, high, middle, one(max_rank), at(max_rank)
      real(wp) :: time(1)
      logical :: later

      call item%open_scale(0, scale)
      if (scale%is_open()) then
         if (scale%name == "time" .and. scale%class == class_real) then
            ! Times grow: the first one after `until` is found by halving.
            one = 1_i8
            at = 0_i8
            low = 0_i8
            high = min(n, scale%extents(1))
            do while (low < high)
               middle = low + (high - low)/2_i8
               at(1) = middle
               call scale%read_reals(at, one, time, error)
               if (allocated(error)) exit
               later = ieee_is_nan(time(1))
               if (.not. later) later = time(1) > until
               if (later) then
                  high = middle
               else
                  low = middle + 1_i8
               end if
            end do
            if (.not. allocated(error)) n = low
         end if
      end if
      call scale%close()
   end subroutine rows_until

   !> Say where the differences are.
   subroutine describe_places(self, items, path, attribute, found)
      class(comparison_type), intent(inout) :: self
      !> The two items.
      type(hdf5_item_type), intent(in) :: items(2)
      !> Path of the data sets, or of the objects that have the attributes.
      character(len=*), intent(in) :: path
      !> Name of the attributes; empty for data sets.
      character(len=*), intent(in) :: attribute
      !> What was found.
      type(found_type), intent(in) :: found

      character(len=:), allocatable :: units

      if (found%n_nan > 0_i8) call detail(self, "NaN", to_text(found%n_nan) // &
         " not a number in one file only")
      if (items(1)%class == class_text) then
         call say("first", found%at_first, found%values_first)
         return
      else if (items(1)%class == class_raw) then
         call detail(self, "first", place_text(items(1), path, found%at_first))
         return
      end if
      units = ""
      if (attribute == "") units = items(1)%units()
      if (units == "1") units = ""
      if (units /= "") units = " " // printable(units)
      call say("largest", found%at_largest, found%values_largest)
      if (ieee_is_finite(found%relative) .and. any(found%at_relative /= found%at_largest)) then
         call say("relative", found%at_relative, found%values_relative)
      end if
      if (found%n_beyond > 0_i8 .and. any(found%at_first /= found%at_largest)) then
         call say("first", found%at_first, found%values_first)
      else if (found%n_beyond > 0_i8 .and. found%n > 1_i8) then
         call detail(self, "first", "the same")
      end if

   contains

      !> Say where something is, and which values are there.
      subroutine say(label, place, values)
         !> What it is.
         character(len=*), intent(in) :: label
         !> Indices.
         integer(i8), intent(in) :: place(max_rank)
         !> The two values.
         type(string_type), intent(in) :: values(2)

         character(len=:), allocatable :: where_text
         character(len=9) :: head

         where_text = place_text(items(1), path, place)
         head = label
         if (where_text /= "") then
            call detail(self, head, where_text)
            head = ""
         end if
         if (items(1)%class == class_text) then
            call say_texts(self, head, values)
         else if (len(values(1)%s) + len(values(2)%s) + 2*len(units) < 66) then
            call detail(self, head, values(1)%s // units // " in A, " // values(2)%s // units // &
               " in B")
         else
            call detail(self, head, values(1)%s // units // " in A")
            call detail(self, "", values(2)%s // units // " in B")
         end if
      end subroutine say

   end subroutine describe_places

   !> Show two texts that differ; of texts with lines the first line that does.
   subroutine say_texts(self, label, values)
      class(comparison_type), intent(inout) :: self
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
         call detail(self, merge(label, repeat(" ", len(label)), side == 1), prefix // &
            "'" // shorten(printable(lines(side)%s), 60) // "' in " // side_names(side))
      end do
   end subroutine say_texts

   !> Compare the events as events, if both files have them in the form of a run.
   subroutine compare_events(self)
      class(comparison_type), intent(inout) :: self

      type(hdf5_item_type) :: items(3, 2)
      type(event_matcher_type) :: matcher
      type(error_type), allocatable :: error
      type(verdict_type) :: verdicts(3)
      integer(i8) :: done(2)
      integer :: i, side
      logical :: usable

      do i = 1, 3
         verdicts(i) = self%rules%verdict(trim(event_parts(i)), "")
      end do
      usable = .not. all(verdicts%ignore)
      do side = 1, 2
         do i = 1, 3
            if (.not. usable) cycle
            call self%readers(side)%open_item(trim(event_parts(i)), "", items(i, side), error)
            usable = .not. allocated(error)
            if (.not. usable) cycle
            usable = items(i, side)%rank == 1 .and. items(i, side)%class == &
               merge(class_real, class_text, i == 1) .and. &
               items(i, side)%extents(1) == items(1, side)%extents(1) .and. &
               items(i, side)%size == items(i, 1)%size
         end do
      end do
      if (usable) then
         self%has_events = .true.
         matcher%atol = verdicts(1)%atol
         matcher%rtol = verdicts(1)%rtol
         done = 0_i8
         do while (any(done < items(1, :)%extents(1)))
            do side = 1, 2
               call push_events(self, items(:, side), side, verdicts%ignore, matcher, done(side), &
                  error)
               if (allocated(error)) exit
            end do
            if (allocated(error)) exit
            call matcher%match()
         end do
         if (allocated(error)) then
            call note_trouble(self, error%message)
         else
            call matcher%finish()
            call report_events(self, matcher)
         end if
      end if
      do side = 1, 2
         do i = 1, 3
            call items(i, side)%close()
         end do
      end do
   end subroutine compare_events

   !> Hand a block of events to the matcher.
   subroutine push_events(self, items, side, ignore, matcher, done, error)
      class(comparison_type), intent(in) :: self
      !> Times, kinds and contacts.
      type(hdf5_item_type), intent(in) :: items(3)
      !> File, 1 or 2.
      integer, intent(in) :: side
      !> Which of the three the rules leave out.
      logical, intent(in) :: ignore(3)
      type(event_matcher_type), intent(inout) :: matcher
      !> Events handed over so far.
      integer(i8), intent(inout) :: done
      !> Set when they cannot be read.
      type(error_type), allocatable, intent(out) :: error

      type(string_type), allocatable :: kinds(:), contacts(:)
      real(wp) :: times(block_texts)
      integer(i8) :: start(max_rank), count(max_rank)
      integer :: i, n
      logical :: later

      n = int(min(int(block_texts, i8), items(1)%extents(1) - done))
      if (n == 0) return
      start = 0_i8
      count = 1_i8
      start(1) = done
      count(1) = n
      call items(1)%read_reals(start, count, times, error)
      if (.not. allocated(error)) call items(2)%read_texts(start, count, n, kinds, error)
      if (.not. allocated(error)) call items(3)%read_texts(start, count, n, contacts, error)
      if (allocated(error)) return
      done = done + n
      do i = 1, n
         if (self%has_until .and. .not. ieee_is_nan(times(i))) then
            later = times(i) > self%until
            if (later) cycle
         end if
         if (ignore(1)) times(i) = 0.0_wp
         if (ignore(2)) kinds(i)%s = "event"
         if (ignore(3)) contacts(i)%s = ""
         call matcher%push(side, contacts(i)%s, kinds(i)%s, times(i))
      end do
   end subroutine push_events

   !> Report how the events differ.
   subroutine report_events(self, matcher)
      class(comparison_type), intent(inout) :: self
      !> The matcher at its end.
      type(event_matcher_type), intent(in) :: matcher

      integer :: side

      if (matcher%differ()) then
         self%n_different = self%n_different + 1
      else if (matcher%n_shifted > 0_i8) then
         self%n_within = self%n_within + 1
      else
         return
      end if
      if (matcher%n_shifted > 0_i8) then
         call row(self, "/events", numbers(brief(matcher%largest), brief(matcher%relative), &
            matcher%n_beyond, matcher%n_pairs))
      else
         call row(self, "/events", "        differs")
      end if
      if (matcher%n(1) /= matcher%n(2)) call detail(self, "count", to_text(matcher%n(1)) // &
         " events in A, " // to_text(matcher%n(2)) // " in B")
      do side = 1, 2
         if (matcher%n_only(side) > 0_i8) call detail(self, "missing", &
            to_text(matcher%n_only(side)) // " only in " // side_names(side) // ", first " // &
            event_text(matcher%first_only(side), side))
      end do
      if (matcher%n_kind > 0_i8) call detail(self, "kind", to_text(matcher%n_kind) // &
         " of another kind, first " // event_text(matcher%first_kind, 1) // " in A, " // &
         printable(matcher%first_kind%kind(2)%s) // " in B")
      if (matcher%at_largest%present) call say("shift", matcher%at_largest)
      if (matcher%first_beyond%present) call say("first", matcher%first_beyond)

   contains

      !> Say how an event has moved.
      subroutine say(label, note)
         !> What it is.
         character(len=*), intent(in) :: label
         type(event_note_type), intent(in) :: note

         call detail(self, label, event_text(note, 1))
         call detail(self, "", to_text(note%time(1)) // " s in A, " // to_text(note%time(2)) // &
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

end module contensou_compare_comparison
