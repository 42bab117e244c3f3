!> Comparison of two HDF5 files, in words of the physics: which data sets and attributes differ, by
!> how much, where most and where first, in terms of the scales of their dimensions (time, body,
!> component, contact, case).
!>
!> The results go to a `comparison_output_type` line by line as they are found.
module contensou_compare_comparison
   use contensou_base_errors, only : error_type
   use contensou_base_kinds, only : i8
   use contensou_base_numbers, only : to_text
   use contensou_base_text, only : string_type
   use contensou_compare_event_lists, only : compare_events, event_parts
   use contensou_compare_items, only : compare_items, outcome_type
   use contensou_compare_listing, only : comparison_output_type, count_of, listing_type, side_names
   use contensou_compare_places, only : printable
   use contensou_compare_rules, only : rules_type, verdict_type
   use contensou_compare_values, only : span_type, subject_type
   use contensou_compare_visits, only : visits_type
   use contensou_files_hdf5_reader, only : hdf5_entry_type, hdf5_reader_type, link_hard, &
      object_dataset, object_group, object_type
   implicit none(type, external)
   private

   public :: comparison_type, comparison_output_type

   !> A comparison: what is asked for, and the count of what was found.
   type :: comparison_type
      type(rules_type) :: rules
      !> What part of the runs is compared.
      type(span_type) :: span
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
      type(hdf5_reader_type), private :: readers(2)
      !> The results, and the count of what could not be compared.
      type(listing_type) :: listing
      !> Links seen so far.
      integer, private :: n_links = 0
      !> Whether to give up.
      logical, private :: stopped = .false.
      !> Whether the events are compared as such.
      logical, private :: has_events = .false.
      !> Groups that were visited.
      type(visits_type), private :: visits
      !> Whether times of rows differ.
      logical, private :: times_differ = .false.
   contains
      procedure :: run
      procedure :: different
   end type comparison_type

   !> Groups on the way to the one that is being looked at.
   type :: way_type
      integer :: depth = 0
      !> Their addresses in the two files.
      integer(i8) :: addresses(2, 100) = 0
   end type way_type

   !> Links that are looked at.
   integer, parameter :: max_links = 300000

   !> Paths of one group that are followed: groups that hold each other can have any number of them.
   integer, parameter :: max_paths = 16

   !> Attributes by which HDF5 ties scales to dimensions: addresses, which mean nothing elsewhere.
   character(len=*), parameter :: scale_links(2) = [character(len=14) :: "DIMENSION_LIST", &
      "REFERENCE_LIST"]

contains

   !> Compare two files.
   subroutine run(self, paths, output, error)
      class(comparison_type), intent(inout) :: self
      !> Names of the files.
      type(string_type), intent(in) :: paths(2)
      !> Where the results go.
      class(comparison_output_type), intent(inout), target :: output
      !> Set when a file cannot be opened.
      type(error_type), allocatable, intent(out) :: error
      type(way_type) :: way
      integer :: side

      self%listing%output => output
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
      self%listing%output => null()
   end subroutine run

   !> Whether the files differ.
   pure logical function different(self)
      class(comparison_type), intent(in) :: self

      different = self%n_different + self%n_different_attributes + self%n_missing > 0
   end function different

   !> The last line.
   subroutine summarize(self)
      class(comparison_type), intent(inout) :: self
      character(len=:), allocatable :: text

      if (self%listing%has_head) call self%listing%output%line("")
      if (self%different()) then
         text = "different: " // count_of(self%n_different, "data set")
         if (self%n_different_attributes > 0) text = text // ", " // &
            count_of(self%n_different_attributes, "attribute")
         if (self%n_missing > 0) text = text // ", " // to_text(self%n_missing) // &
            " in one file only"
         text = text // "; " // to_text(self%n_datasets) // " compared"
      else if (self%listing%n_trouble > 0) then
         text = "no difference in what could be compared: " // &
            count_of(self%n_datasets, "data set") // ", " // &
            count_of(self%n_attributes, "attribute")
      else
         text = "same: " // count_of(self%n_datasets, "data set") // ", " // &
            count_of(self%n_attributes, "attribute")
      end if
      if (self%n_within > 0) text = text // ", " // to_text(self%n_within) // " within tolerance"
      text = text // ", " // to_text(self%n_ignored) // " ignored"
      call self%listing%output%line(text)
   end subroutine summarize

   !> Compare what two groups hold.
   recursive subroutine compare_groups(self, path, way)
      class(comparison_type), intent(inout) :: self
      !> Path of the groups.
      character(len=*), intent(in) :: path
      !> Groups on the way to them.
      type(way_type), intent(inout) :: way
      type(hdf5_entry_type), allocatable :: a(:), b(:)
      type(outcome_type) :: outcome
      integer :: i, j, order

      call compare_attributes(self, path)
      call enter_group(self, path, [.true., .true.], way, order)
      if (order /= 0) return
      call list_members(self, path, [.true., .true.], a, b, order)
      if (order == 0) then
         if (path == "/events") then
            call compare_events(self%readers, self%listing, self%rules, self%span, outcome, &
               self%has_events)
            call count_outcome(self, outcome)
         end if
         i = 1
         j = 1
         do while (i <= size(a) .or. j <= size(b))
            if (self%stopped .or. self%listing%output%broken) exit
            order = next_of(a, b, i, j)
            self%n_links = self%n_links + 1
            if (self%n_links > max_links) then
               call self%listing%trouble("more than " // to_text(max_links) // &
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
      addresses = 0
      do side = 1, 2
         if (.not. sides(side)) cycle
         call self%readers(side)%object(path, kind, addresses(side), error)
         if (allocated(error)) then
            call self%listing%trouble(error%message)
            return
         end if
      end do
      do i = 1, way%depth
         if (all(way%addresses(:, i) == addresses .or. .not. sides)) return
      end do
      if (self%visits%visit(addresses) > max_paths) then
         call self%listing%trouble("groups with more than " // to_text(max_paths) // &
            " paths are not compared under all of them")
         return
      end if
      if (way%depth == size(way%addresses, 2)) then
         call self%listing%trouble("groups nested more than " // &
            to_text(size(way%addresses, 2)) // " deep are not compared: " // path)
         return
      end if
      way%depth = way%depth + 1
      way%addresses(:, way%depth) = addresses
      code = 0
   end subroutine enter_group

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
      call self%listing%trouble(error%message)
   end subroutine list_members

   !> Path of a member of a group.
   pure function joined(path, name) result(whole)
      character(len=*), intent(in) :: path
      !> Name of the member.
      character(len=*), intent(in) :: name
      !> The path.
      character(len=:), allocatable :: whole

      whole = path // "/" // name
      if (path == "/") whole = "/" // name
   end function joined

   !> Which of two sorted lists has the next name: negative for the first, 0 for both.
   pure integer function next_of(a, b, i, j)
      !> First list.
      type(hdf5_entry_type), intent(in) :: a(:)
      !> Second list.
      type(hdf5_entry_type), intent(in) :: b(:)
      !> Place in the first.
      integer, intent(in) :: i
      !> Place in the second.
      integer, intent(in) :: j
      integer :: k

      if (i > size(a)) then
         next_of = 1
         return
      else if (j > size(b)) then
         next_of = -1
         return
      end if
      ! Not by Fortran's comparison, for which trailing blanks do not count.
      associate (x => a(i)%name, y => b(j)%name)
         do k = 1, min(len(x), len(y))
            next_of = ichar(x(k:k)) - ichar(y(k:k))
            if (next_of /= 0) return
         end do
         next_of = len(x) - len(y)
      end associate
   end function next_of

   !> Compare what two links of the same name lead to.
   recursive subroutine compare_links(self, path, link_a, link_b, way)
      class(comparison_type), intent(inout) :: self
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
               call self%listing%trouble(error%message)
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
         call self%listing%row(path, printable(words(1)%s // " in A, " // words(2)%s // " in B"))
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
            call self%listing%trouble(error%message)
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
         call self%listing%row(path, "only in " // side_names(side) // ": a group of " // &
            count_of(n_compared, "data set"))
      else if (verdict%ignore) then
         self%n_ignored = self%n_ignored + 1
      else
         self%n_missing = self%n_missing + 1
         call self%listing%row(path, "only in " // side_names(side))
      end if
   end subroutine note_missing

   !> Count what a group that one file alone has holds.
   recursive subroutine count_members(self, side, path, way, n_compared, n_ignored)
      class(comparison_type), intent(inout) :: self
      !> The file, 1 or 2.
      integer, intent(in) :: side
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
               call self%listing%trouble(error%message)
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
         call self%listing%trouble(error%message)
         return
      end if
      i = 1
      j = 1
      do while (i <= size(a) .or. j <= size(b))
         if (self%listing%output%broken) exit
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
      character(len=*), intent(in) :: path
      character(len=*), intent(in) :: name
      type(verdict_type) :: verdict

      if (any(name == scale_links)) return
      verdict = self%rules%verdict(path, name)
      if (verdict%ignore) then
         self%n_ignored = self%n_ignored + 1
      else
         self%n_different_attributes = self%n_different_attributes + 1
         call self%listing%row(path // "@" // name, "only in " // side_names(side))
      end if
   end subroutine note_missing_attribute

   !> Compare two attributes.
   subroutine compare_attribute(self, path, name)
      class(comparison_type), intent(inout) :: self
      !> Path of their objects.
      character(len=*), intent(in) :: path
      character(len=*), intent(in) :: name
      type(verdict_type) :: verdict
      type(outcome_type) :: outcome

      if (any(name == scale_links)) return
      verdict = self%rules%verdict(path, name)
      if (verdict%ignore) then
         self%n_ignored = self%n_ignored + 1
         return
      end if
      self%n_attributes = self%n_attributes + 1
      call compare_items(self%readers, self%listing, subject_type(path, name, verdict), self%span, &
         outcome)
      if (outcome%is_different) self%n_different_attributes = self%n_different_attributes + 1
   end subroutine compare_attribute

   !> Count how data sets, or the events, compare.
   subroutine count_outcome(self, outcome)
      class(comparison_type), intent(inout) :: self
      type(outcome_type), intent(in) :: outcome

      if (outcome%is_different) self%n_different = self%n_different + 1
      if (outcome%is_within) self%n_within = self%n_within + 1
      self%times_differ = self%times_differ .or. outcome%times_differ
   end subroutine count_outcome

   !> Compare two data sets and their attributes.
   subroutine compare_datasets(self, path, verdict)
      class(comparison_type), intent(inout) :: self
      character(len=*), intent(in) :: path
      type(verdict_type), intent(in) :: verdict
      type(outcome_type) :: outcome

      self%n_datasets = self%n_datasets + 1
      if (.not. (self%has_events .and. any(path == event_parts))) then
         call compare_items(self%readers, self%listing, subject_type(path, "", verdict), &
            self%span, outcome)
         call count_outcome(self, outcome)
      end if
      call compare_attributes(self, path)
   end subroutine compare_datasets

end module contensou_compare_comparison
