!> What a document of groups, keys and values is made of, and how its lists grow.
module contensou_base_document_types
   use contensou_base_diagnostics, only : origin_type, source_type
   use contensou_base_expressions, only : constants_type
   use contensou_base_kinds, only : i8, wp
   use contensou_base_text, only : string_type
   implicit none(type, external)
   private

   public :: value_type, assignment_type, group_type, document_type
   public :: value_null, value_integer, value_real, value_logical, value_text, &
      value_expression
   public :: copy_values, move_assignment, move_group
   public :: resize_assignments, resize_groups, append_source, append_text, selection
   public :: remove_groups

   !> No value was given: nothing between two commas.
   integer, parameter :: value_null = 0

   integer, parameter :: value_integer = 1

   !> A real number, possibly infinite or not a number.
   integer, parameter :: value_real = 2

   integer, parameter :: value_logical = 3

   !> A text in quotes.
   integer, parameter :: value_text = 4

   !> An expression without quotes, whose text is that of the expression.
   integer, parameter :: value_expression = 5

   !> One of the values of a key, as it was written.
   type :: value_type
      !> What it is, one of the `value_*` parameters.
      integer :: kind = value_null
      !> The number, for integers too.
      real(wp) :: real = 0.0_wp
      integer(i8) :: integer = 0
      logical :: logical = .false.
      !> The text without its quotes, or an expression; not allocated for others.
      character(len=:), allocatable :: text
      type(origin_type) :: origin
   end type value_type

   !> A key and the values given to it.
   type :: assignment_type
      !> Key in lower case.
      character(len=:), allocatable :: key
      !> First subscript; 0 if there is no subscript.
      integer :: first = 0
      !> Last subscript; 0 if there is no subscript, -1 if the range is open.
      integer :: last = 0
      !> The values, repetitions expanded; size 0 if nothing follows the equals sign.
      type(value_type), allocatable :: values(:)
      type(origin_type) :: origin
   end type assignment_type

   !> A group as it is written: its assignments in order, nothing checked.
   type :: group_type
      !> Name in lower case.
      character(len=:), allocatable :: name
      !> Where `&name` stands.
      type(origin_type) :: origin
      integer :: n_assignments = 0
      !> The assignments, of size `n_assignments`.
      type(assignment_type), allocatable :: assignments(:)
      !> Whether the group was read without a mistake; if not, keys may be missing from it.
      logical :: complete = .true.
   contains
      procedure :: gives
   end type group_type

   !> What was read.
   type :: document_type
      !> Number of texts that origins refer to.
      integer :: n_sources = 0
      !> These texts, the first `n_sources` of them.
      type(source_type), allocatable :: sources(:)
      !> Bytes of the file that was read.
      character(len=:), allocatable :: bytes
      integer :: n_groups = 0
      !> The groups, of size `n_groups`.
      type(group_type), allocatable :: groups(:)
      !> Whether all was read without a mistake; if not, groups may be missing.
      logical :: complete = .true.
      !> Names of the constants that the file gives, in lower case.
      type(string_type), allocatable :: constant_names(:)
      !> These constants, as `contensou_base_constants` takes them from their groups.
      type(constants_type) :: constants
   end type document_type

contains

   !> Whether a group gives a key a value.
   pure logical function gives(self, key)
      class(group_type), intent(in) :: self
      !> In lower case.
      character(len=*), intent(in) :: key
      integer :: i

      gives = .false.
      do i = 1, self%n_assignments
         gives = gives .or. self%assignments(i)%key == key
      end do
   end function gives

   pure subroutine copy_values(buffer, n, values)
      type(value_type), intent(in) :: buffer(:)
      !> Number of values in it.
      integer, intent(in) :: n
      type(value_type), allocatable, intent(out) :: values(:)
      integer :: i

      allocate(values(n))
      do i = 1, n
         values(i) = buffer(i)
      end do
   end subroutine copy_values

   !> Change the size of a group's list of assignments.
   pure subroutine resize_assignments(group, n)
      type(group_type), intent(inout) :: group
      !> Size, not below the number of assignments.
      integer, intent(in) :: n
      type(assignment_type), allocatable :: resized(:)
      integer :: i

      allocate(resized(n))
      do i = 1, group%n_assignments
         call move_assignment(group%assignments(i), resized(i))
      end do
      call move_alloc(resized, group%assignments)
   end subroutine resize_assignments

   !> Move an assignment without copying its values.
   pure subroutine move_assignment(from, to)
      !> Assignment that is emptied.
      type(assignment_type), intent(inout) :: from
      !> Assignment that is filled.
      type(assignment_type), intent(inout) :: to

      to%first = from%first
      to%last = from%last
      to%origin = from%origin
      call move_alloc(from%key, to%key)
      call move_alloc(from%values, to%values)
   end subroutine move_assignment

   !> Change the size of a document's list of groups.
   pure subroutine resize_groups(document, n)
      type(document_type), intent(inout) :: document
      !> Size, not below the number of groups.
      integer, intent(in) :: n
      type(group_type), allocatable :: resized(:)
      integer :: i

      allocate(resized(n))
      do i = 1, document%n_groups
         call move_group(document%groups(i), resized(i))
      end do
      call move_alloc(resized, document%groups)
   end subroutine resize_groups

   !> Move a group without copying its assignments.
   pure subroutine move_group(from, to)
      !> Group that is emptied.
      type(group_type), intent(inout) :: from
      !> Group that is filled.
      type(group_type), intent(inout) :: to

      to%origin = from%origin
      to%n_assignments = from%n_assignments
      to%complete = from%complete
      call move_alloc(from%name, to%name)
      call move_alloc(from%assignments, to%assignments)
   end subroutine move_group

   !> Remove the groups of one name.
   pure subroutine remove_groups(document, name)
      type(document_type), intent(inout) :: document
      character(len=*), intent(in) :: name
      integer :: g, n

      n = 0
      do g = 1, document%n_groups
         if (document%groups(g)%name == name) cycle
         n = n + 1
         if (n < g) call move_group(document%groups(g), document%groups(n))
      end do
      document%n_groups = n
      call resize_groups(document, n)
   end subroutine remove_groups

   !> Append a key with one text, or two, to a group.
   pure subroutine append_text(group, key, text, origin, second)
      type(group_type), intent(inout) :: group
      character(len=*), intent(in) :: key
      character(len=*), intent(in) :: text
      !> Where it comes from.
      type(origin_type), intent(in) :: origin
      !> Another text.
      character(len=*), intent(in), optional :: second
      integer :: n

      n = group%n_assignments + 1
      call resize_assignments(group, n)
      group%n_assignments = n
      associate (assignment => group%assignments(n))
         assignment%key = key
         assignment%origin = origin
         allocate(assignment%values(merge(2, 1, present(second))))
         assignment%values%kind = value_text
         assignment%values%origin = origin
         assignment%values(1)%text = text
         if (present(second)) assignment%values(2)%text = second
      end associate
   end subroutine append_text

   !> The groups of one name of a document, with its constants. With a key, those that give it.
   pure function selection(document, name, key) result(part)
      type(document_type), intent(in) :: document
      !> Name of the groups.
      character(len=*), intent(in) :: name
      character(len=*), intent(in), optional :: key
      type(document_type) :: part
      logical :: chosen(document%n_groups)
      integer :: i, k, n

      do i = 1, document%n_groups
         associate (group => document%groups(i))
            chosen(i) = group%name == name
            if (.not. chosen(i) .or. .not. present(key)) cycle
            chosen(i) = .false.
            do k = 1, group%n_assignments
               chosen(i) = chosen(i) .or. group%assignments(k)%key == key
            end do
         end associate
      end do
      allocate(part%groups(count(chosen)))
      n = 0
      do i = 1, document%n_groups
         if (.not. chosen(i)) cycle
         n = n + 1
         part%groups(n) = document%groups(i)
      end do
      part%n_groups = n
      part%constants = document%constants
      ! The other groups are not missing.
      part%complete = .false.
   end function selection

   !> Append a source without copying the lines of any.
   pure subroutine append_source(document, source)
      !> Document to append to; it may have no list of sources yet.
      type(document_type), intent(inout) :: document
      !> The source; it is emptied.
      type(source_type), intent(inout) :: source
      type(source_type), allocatable :: bigger(:)
      integer :: i

      if (.not. allocated(document%sources)) allocate(document%sources(1))
      if (document%n_sources == size(document%sources)) then
         allocate(bigger(max(1, 2*document%n_sources)))
         do i = 1, document%n_sources
            call move_alloc(document%sources(i)%name, bigger(i)%name)
            call move_alloc(document%sources(i)%lines, bigger(i)%lines)
         end do
         call move_alloc(bigger, document%sources)
      end if
      document%n_sources = document%n_sources + 1
      call move_alloc(source%name, document%sources(document%n_sources)%name)
      call move_alloc(source%lines, document%sources(document%n_sources)%lines)
   end subroutine append_source

end module contensou_base_document_types
