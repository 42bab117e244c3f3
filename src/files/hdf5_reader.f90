!> Reading of any HDF5 file, piece by piece: what a group holds, what a data set or attribute is,
!> and blocks of its values.
!>
!> Memory is bounded whatever the file says, by the size of the blocks that the caller asks for and
!> by the limits in hdf5_reader.c, where HDF5 is called. A file that claims far more values than it
!> has bytes is refused. HDF5 itself may crash over a damaged file: see contensou_base_guard.
!>
!> Dimensions, starts and counts are in the order of the file, outermost first, indices from 0.
module contensou_files_hdf5_reader
   use, intrinsic :: iso_c_binding, only : c_associated, c_char, c_int, c_int64_t, &
      c_null_char, c_null_ptr, c_ptr
   use contensou_base_errors, only : error_type, fatal, status_file
   use contensou_base_guard, only : finish_guard, start_guard, wait_for_worker
   use contensou_base_kinds, only : i8, wp
   use contensou_base_operating_system, only : text_from_c, write_stderr
   use contensou_base_text, only : string_type
   implicit none(type, external)
   private

   public :: hdf5_reader_type, hdf5_item_type, hdf5_entry_type, readable_status, guarded_status
   public :: probe
   public :: class_real, class_integer, class_unsigned, class_text, class_raw, class_other
   public :: link_hard, link_soft, link_other
   public :: object_group, object_dataset, object_type, object_other
   public :: max_rank

   !> Floating-point numbers, read as doubles.
   integer, parameter :: class_real = 1

   !> Integers and enumerators, read as eight-byte integers.
   integer, parameter :: class_integer = 2

   !> Unsigned integers, read as the bits of an eight-byte integer.
   integer, parameter :: class_unsigned = 3

   !> Texts, of fixed or variable length.
   integer, parameter :: class_text = 4

   !> Values that are compared byte for byte: compound, opaque, bit field, array.
   integer, parameter :: class_raw = 5

   !> Values that are addresses: references and sequences.
   integer, parameter :: class_other = 6

   !> Link to an object.
   integer, parameter :: link_hard = 1

   !> Link to a path of the same file.
   integer, parameter :: link_soft = 2

   !> Link to another file.
   integer, parameter :: link_other = 3

   integer, parameter :: object_group = 1

   !> A data set.
   integer, parameter :: object_dataset = 2

   !> A named data type.
   integer, parameter :: object_type = 3

   !> Anything else.
   integer, parameter :: object_other = 4

   !> Largest number of dimensions.
   integer, parameter :: max_rank = 32

   !> Memory for looking at a file that may be damaged [bytes].
   real(wp), parameter :: memory_limit = 1.0737e9_wp

   !> Groups within groups that are looked at.
   integer, parameter :: deepest = 4

   !> A name in a group, or of an attribute.
   type :: hdf5_entry_type
      character(len=:), allocatable :: name
      !> What kind of link it is, one of the `link_*` parameters.
      integer :: link = link_hard
   end type hdf5_entry_type

   !> A file that is being read.
   type :: hdf5_reader_type
      private
      !> Address of what C keeps about it; null when there is no open file.
      type(c_ptr) :: handle = c_null_ptr
   contains
      procedure :: open => open_reader
      procedure :: close => close_reader
      procedure :: list
      procedure :: object
      procedure :: link_value
      procedure :: open_item
      procedure :: read_text
   end type hdf5_reader_type

   !> A data set or attribute that is being read.
   type :: hdf5_item_type
      !> One of the `class_*` parameters.
      integer :: class = class_other
      !> Size of a value in the file [bytes].
      integer(i8) :: size = 0_i8
      !> Number of dimensions.
      integer :: rank = 0
      !> Whether there are no values at all (null data space).
      logical :: is_null = .false.
      integer(i8) :: extents(max_rank) = 0_i8
      !> Extents of a chunk; 0 if the values are stored in one piece.
      integer(i8) :: chunk(max_rank) = 0_i8
      !> Name of a scale.
      character(len=:), allocatable :: name
      !> Address of what C keeps about it.
      type(c_ptr), private :: handle = c_null_ptr
   contains
      procedure :: close => close_item
      procedure :: is_open => item_is_open
      procedure :: type_text
      procedure :: same_type
      procedure :: read => read_values
      procedure :: read_texts
      procedure :: open_scale
      procedure :: dimension_name
      procedure :: units
   end type hdf5_item_type

   ! Functions of C. One that acts returns 0 on success, one that makes something null on failure.
   interface
      !> Open a file.
      type(c_ptr) function c_open_reader(path, lenient) bind(c, name="contensou_hdf5_open_reader")
         import :: c_char, c_int, c_ptr
         implicit none(type, external)
         !> Name of the file, null-terminated.
         character(kind=c_char), intent(in) :: path(*)
         !> 1 to read chunks whose checksums are wrong.
         integer(c_int), value :: lenient
      end function c_open_reader

      !> What the seal of a file says: 0 none, 1 good, 2 damaged.
      integer(c_int) function c_check_seal(path) bind(c, name="contensou_hdf5_check_seal")
         import :: c_char, c_int
         implicit none(type, external)
         !> Name of the file, null-terminated.
         character(kind=c_char), intent(in) :: path(*)
      end function c_check_seal

      !> Close a file.
      subroutine c_close_reader(reader) bind(c, name="contensou_hdf5_close_reader")
         import :: c_ptr
         implicit none(type, external)
         !> The file.
         type(c_ptr), value :: reader
      end subroutine c_close_reader

      !> List a group or the attributes of an object.
      type(c_ptr) function c_list(reader, object, attributes) bind(c, name="contensou_hdf5_list")
         import :: c_char, c_int, c_ptr
         implicit none(type, external)
         !> The file.
         type(c_ptr), value :: reader
         !> Path of the object, null-terminated.
         character(kind=c_char), intent(in) :: object(*)
         !> 1 for its attributes, 0 for its links.
         integer(c_int), value :: attributes
      end function c_list

      !> Number of names.
      integer(c_int) function c_listed_count(names) bind(c, name="contensou_hdf5_listed_count")
         import :: c_int, c_ptr
         implicit none(type, external)
         type(c_ptr), value :: names
      end function c_listed_count

      function c_listed(names, i, link) result(text) bind(c, name="contensou_hdf5_listed")
         import :: c_int, c_ptr
         implicit none(type, external)
         type(c_ptr), value :: names
         !> Index, from 0.
         integer(c_int), value :: i
         !> Kind of the link.
         integer(c_int), intent(out) :: link
         !> Null-terminated name.
         type(c_ptr) :: text
      end function c_listed

      subroutine c_free_list(names) bind(c, name="contensou_hdf5_free_list")
         import :: c_ptr
         implicit none(type, external)
         type(c_ptr), value :: names
      end subroutine c_free_list

      !> What a path leads to.
      function c_object(reader, path, address) result(kind) bind(c, name="contensou_hdf5_object")
         import :: c_char, c_int, c_int64_t, c_ptr
         implicit none(type, external)
         !> The file.
         type(c_ptr), value :: reader
         !> Path, null-terminated.
         character(kind=c_char), intent(in) :: path(*)
         !> What tells the object from others of the file.
         integer(c_int64_t), intent(inout) :: address
         !> Kind of the object, 0 on failure.
         integer(c_int) :: kind
      end function c_object

      !> Where a link leads.
      type(c_ptr) function c_link_value(reader, path) bind(c, name="contensou_hdf5_link_value")
         import :: c_char, c_ptr
         implicit none(type, external)
         !> The file.
         type(c_ptr), value :: reader
         !> Path of the link, null-terminated.
         character(kind=c_char), intent(in) :: path(*)
      end function c_link_value

      !> Open a data set or attribute.
      type(c_ptr) function c_open_item(reader, object, attribute) &
         bind(c, name="contensou_hdf5_open_item")
         import :: c_char, c_ptr
         implicit none(type, external)
         !> The file.
         type(c_ptr), value :: reader
         !> Path of the object, null-terminated.
         character(kind=c_char), intent(in) :: object(*)
         !> Name of the attribute, null-terminated; empty for the data set itself.
         character(kind=c_char), intent(in) :: attribute(*)
      end function c_open_item

      type(c_ptr) function c_open_scale(item, dimension) bind(c, name="contensou_hdf5_open_scale")
         import :: c_int, c_ptr
         implicit none(type, external)
         !> The data set.
         type(c_ptr), value :: item
         !> Dimension, from 0.
         integer(c_int), value :: dimension
      end function c_open_scale

      !> Label of a dimension.
      type(c_ptr) function c_dimension_name(item, dimension) &
         bind(c, name="contensou_hdf5_dimension_name")
         import :: c_int, c_ptr
         implicit none(type, external)
         !> The data set.
         type(c_ptr), value :: item
         !> Dimension, from 0.
         integer(c_int), value :: dimension
      end function c_dimension_name

      subroutine c_close_item(item) bind(c, name="contensou_hdf5_close_item")
         import :: c_ptr
         implicit none(type, external)
         type(c_ptr), value :: item
      end subroutine c_close_item

      !> Type and extents of an item.
      function c_describe(item, size, rank, extents, chunk, is_null) result(class) &
         bind(c, name="contensou_hdf5_describe")
         import :: c_int, c_int64_t, c_ptr
         implicit none(type, external)
         type(c_ptr), value :: item
         !> Bytes of a value.
         integer(c_int64_t), intent(out) :: size
         !> Number of dimensions.
         integer(c_int), intent(out) :: rank
         integer(c_int64_t), intent(inout) :: extents(*)
         !> Extents of a chunk.
         integer(c_int64_t), intent(inout) :: chunk(*)
         !> 1 if there are no values.
         integer(c_int), intent(out) :: is_null
         !> Class of the values.
         integer(c_int) :: class
      end function c_describe

      !> Words for a type.
      type(c_ptr) function c_type_text(item) bind(c, name="contensou_hdf5_type_text")
         import :: c_ptr
         implicit none(type, external)
         type(c_ptr), value :: item
      end function c_type_text

      !> Whether two types are the same.
      function c_same_type(a, b) result(same) bind(c, name="contensou_hdf5_same_type")
         import :: c_int, c_ptr
         implicit none(type, external)
         !> An item.
         type(c_ptr), value :: a
         !> Another item.
         type(c_ptr), value :: b
         !> 1 if they are.
         integer(c_int) :: same
      end function c_same_type

      !> Read a block of numbers or bytes.
      integer(c_int) function c_read(item, start, count, buffer) &
         bind(c, name="contensou_hdf5_read")
         import :: c_int, c_int64_t, c_ptr
         implicit none(type, external)
         type(c_ptr), value :: item
         !> First indices.
         integer(c_int64_t), intent(in) :: start(*)
         !> Numbers of indices.
         integer(c_int64_t), intent(in) :: count(*)
         type(*), intent(inout), contiguous :: buffer(..)
      end function c_read

      !> Read a block of texts.
      integer(c_int) function c_read_texts(item, start, count) &
         bind(c, name="contensou_hdf5_read_texts")
         import :: c_int, c_int64_t, c_ptr
         implicit none(type, external)
         type(c_ptr), value :: item
         !> First indices.
         integer(c_int64_t), intent(in) :: start(*)
         !> Numbers of indices.
         integer(c_int64_t), intent(in) :: count(*)
      end function c_read_texts

      !> A text that was read.
      type(c_ptr) function c_text_of(item, i) bind(c, name="contensou_hdf5_text")
         import :: c_int64_t, c_ptr
         implicit none(type, external)
         type(c_ptr), value :: item
         !> Index in the block, from 0.
         integer(c_int64_t), value :: i
      end function c_text_of

      type(c_ptr) function c_scale_name(item) bind(c, name="contensou_hdf5_item_name")
         import :: c_ptr
         implicit none(type, external)
         type(c_ptr), value :: item
      end function c_scale_name

      !> Units of a data set.
      type(c_ptr) function c_units(item) bind(c, name="contensou_hdf5_units")
         import :: c_ptr
         implicit none(type, external)
         !> The data set.
         type(c_ptr), value :: item
      end function c_units

      !> Reason of the last failure.
      type(c_ptr) function c_message() bind(c, name="contensou_hdf5_message")
         import :: c_ptr
         implicit none(type, external)
      end function c_message
   end interface

contains

   !> Open a file for reading.
   subroutine open_reader(self, path, error, lenient)
      class(hdf5_reader_type), intent(inout) :: self
      character(len=*), intent(in) :: path
      !> Set when it cannot be read, is damaged or no HDF5 file, or is being written.
      type(error_type), allocatable, intent(out) :: error
      !> Whether values are read whose checksums are wrong, because the caller has others; default
      !> `.false.`.
      logical, intent(in), optional :: lenient
      integer(c_int) :: how

      how = 0
      if (present(lenient)) how = merge(1_c_int, 0_c_int, lenient)
      self%handle = c_open_reader(trim(path) // c_null_char, how)
      if (.not. c_associated(self%handle)) call report(error)
   end subroutine open_reader

   !> Close a file; its items must be closed before.
   subroutine close_reader(self)
      !> File to close; one that is not open stays so.
      class(hdf5_reader_type), intent(inout) :: self

      if (c_associated(self%handle)) call c_close_reader(self%handle)
      self%handle = c_null_ptr
   end subroutine close_reader

   !> Names in a group, or of the attributes of an object, in the order of their bytes.
   subroutine list(self, path, attributes, entries, error)
      class(hdf5_reader_type), intent(in) :: self
      character(len=*), intent(in) :: path
      !> Whether attributes are listed, not links.
      logical, intent(in) :: attributes
      type(hdf5_entry_type), allocatable, intent(out) :: entries(:)
      type(error_type), allocatable, intent(out) :: error
      type(c_ptr) :: names
      integer(c_int) :: i, kind

      names = c_list(self%handle, path // c_null_char, merge(1_c_int, 0_c_int, attributes))
      if (.not. c_associated(names)) then
         allocate(entries(0))
         call report(error)
         return
      end if
      allocate(entries(c_listed_count(names)))
      do i = 1, size(entries)
         entries(i)%name = text_from_c(c_listed(names, i - 1_c_int, kind))
         entries(i)%link = int(kind)
      end do
      call c_free_list(names)
   end subroutine list

   !> What a path leads to.
   subroutine object(self, path, kind, address, error)
      class(hdf5_reader_type), intent(in) :: self
      character(len=*), intent(in) :: path
      !> One of the `object_*` parameters.
      integer, intent(out) :: kind
      !> What tells the object from others of the file.
      integer(i8), intent(out) :: address
      type(error_type), allocatable, intent(out) :: error

      address = 0_i8
      kind = int(c_object(self%handle, path // c_null_char, address))
      if (kind == 0) call report(error)
   end subroutine object

   !> Where a link leads that is not followed.
   subroutine link_value(self, path, text, error)
      class(hdf5_reader_type), intent(in) :: self
      character(len=*), intent(in) :: path
      !> Where it leads.
      character(len=:), allocatable, intent(out) :: text
      type(error_type), allocatable, intent(out) :: error
      type(c_ptr) :: pointer

      text = ""
      pointer = c_link_value(self%handle, path // c_null_char)
      if (c_associated(pointer)) then
         text = text_from_c(pointer)
      else
         call report(error)
      end if
   end subroutine link_value

   !> Open a data set or an attribute.
   subroutine open_item(self, path, attribute, item, error)
      class(hdf5_reader_type), intent(in) :: self
      character(len=*), intent(in) :: path
      !> Name of its attribute; empty for the data set itself.
      character(len=*), intent(in) :: attribute
      type(hdf5_item_type), intent(out) :: item
      type(error_type), allocatable, intent(out) :: error

      item%handle = c_open_item(self%handle, path // c_null_char, attribute // c_null_char)
      if (c_associated(item%handle)) then
         call describe(item)
      else
         call report(error)
      end if
   end subroutine open_item

   !> Read a text: a data set or an attribute.
   subroutine read_text(self, path, attribute, text, error)
      class(hdf5_reader_type), intent(in) :: self
      character(len=*), intent(in) :: path
      !> Name of its attribute; empty for the data set itself.
      character(len=*), intent(in) :: attribute
      !> The text; empty after an error.
      character(len=:), allocatable, intent(out) :: text
      !> Set when there is none.
      type(error_type), allocatable, intent(out) :: error
      type(hdf5_item_type) :: item
      type(string_type), allocatable :: texts(:)

      text = ""
      call self%open_item(path, attribute, item, error)
      if (allocated(error)) return
      if (item%class /= class_text .or. item%rank > 1 .or. item%is_null .or. &
         (item%rank == 1 .and. item%extents(1) < 1)) then
         call fatal(error, path // " " // attribute // " is not a text", status_file)
      else
         call item%read_texts([0_i8], [1_i8], 1, texts, error)
         if (.not. allocated(error)) text = texts(1)%s
      end if
      call item%close()
   end subroutine read_text

   !> Status that the file of an earlier run carries, its root attribute `status`.
   subroutine readable_status(path, status_text, error)
      character(len=*), intent(in) :: path
      character(len=:), allocatable, intent(out) :: status_text
      !> Set when the file is no readable HDF5 file, has no status, or is being written.
      type(error_type), allocatable, intent(out) :: error
      type(hdf5_reader_type) :: reader

      status_text = ""
      call reader%open(path, error)
      if (.not. allocated(error)) call reader%read_text("/", "status", status_text, error)
      call reader%close()
   end subroutine readable_status

   !> The same for a file that may be damaged by anything, in a process of its own.
   subroutine guarded_status(path, status_text, error)
      character(len=*), intent(in) :: path
      character(len=:), allocatable, intent(out) :: status_text
      !> Set when the file is no readable HDF5 file, has no status, or is being written.
      type(error_type), allocatable, intent(out) :: error
      character(len=:), allocatable :: place, reason
      logical :: is_worker, finished, inside
      integer :: code

      call start_guard(memory_limit, is_worker, error)
      status_text = ""
      if (allocated(error)) return
      if (is_worker) then
         call readable_status(path, status_text, error)
         if (allocated(error)) status_text = error%message
         call write_stderr(status_text)
         call finish_guard(merge(1, 0, allocated(error)))
      end if
      call wait_for_worker(finished, code, inside, place, reason, status_text)
      if (finished .and. code == 0) return
      if (.not. finished) status_text = crash_text(path, reason)
      call fatal(error, status_text, status_file)
      status_text = ""
   end subroutine guarded_status

   !> See that HDF5 survives the reading of a file, in a process of its own. A file with a good seal
   !> is known to be as it was written, and is not read.
   subroutine probe(path, error)
      character(len=*), intent(in) :: path
      !> Set when HDF5 crashed or did not come to an end. All else that is wrong with the file is
      !> found when it is read.
      type(error_type), allocatable, intent(out) :: error
      type(hdf5_reader_type) :: reader
      type(error_type), allocatable :: ignored
      character(len=:), allocatable :: place, reason, output
      logical :: is_worker, finished, inside
      integer :: code

      if (c_check_seal(trim(path) // c_null_char) /= 0) return
      call start_guard(memory_limit, is_worker, error)
      if (allocated(error)) return
      if (is_worker) then
         call reader%open(path, ignored)
         if (.not. allocated(ignored)) then
            call read_all(reader, "/", 1)
            call reader%close()
         end if
         call finish_guard(0)
      end if
      call wait_for_worker(finished, code, inside, place, reason, output)
      if (.not. finished) call fatal(error, crash_text(path, reason), status_file)
   end subroutine probe

   !> Message about a file over which HDF5 has crashed.
   pure function crash_text(path, reason) result(text)
      character(len=*), intent(in) :: path
      !> How the process that read it ended.
      character(len=*), intent(in) :: reason
      character(len=:), allocatable :: text

      text = "cannot read " // path // ": it is damaged, the HDF5 library failed (" // reason // ")"
   end function crash_text

   !> Read what a group holds, as far as it can be read.
   recursive subroutine read_all(reader, group, depth)
      type(hdf5_reader_type), intent(in) :: reader
      !> Its path, with a slash at the end.
      character(len=*), intent(in) :: group
      !> How deep it is.
      integer, intent(in) :: depth
      type(hdf5_entry_type), allocatable :: entries(:)
      type(error_type), allocatable :: error
      integer(i8) :: address
      integer :: i, kind

      call read_attributes(reader, group)
      call reader%list(group, .false., entries, error)
      if (allocated(error)) return
      do i = 1, size(entries)
         if (entries(i)%link == link_other) cycle
         call reader%object(group // entries(i)%name, kind, address, error)
         if (allocated(error)) cycle
         if (kind == object_group .and. depth < deepest) then
            call read_all(reader, group // entries(i)%name // "/", depth + 1)
         else if (kind == object_dataset) then
            call read_attributes(reader, group // entries(i)%name)
            call read_item(reader, group // entries(i)%name, "")
         end if
      end do
   end subroutine read_all

   !> Read the attributes of an object.
   subroutine read_attributes(reader, path)
      type(hdf5_reader_type), intent(in) :: reader
      character(len=*), intent(in) :: path
      type(hdf5_entry_type), allocatable :: entries(:)
      type(error_type), allocatable :: error
      integer :: i

      call reader%list(path, .true., entries, error)
      if (allocated(error)) return
      do i = 1, size(entries)
         call read_item(reader, path, entries(i)%name)
      end do
   end subroutine read_attributes

   !> Read a data set or an attribute in blocks of rows.
   subroutine read_item(reader, path, attribute)
      type(hdf5_reader_type), intent(in) :: reader
      character(len=*), intent(in) :: path
      !> Name of the attribute; empty for the data set.
      character(len=*), intent(in) :: attribute
      integer(i8), parameter :: most = 65536_i8
      type(hdf5_item_type) :: item
      type(hdf5_item_type) :: scale
      type(error_type), allocatable :: error
      type(string_type), allocatable :: texts(:)
      integer(i8), allocatable :: values(:)
      integer(i8) :: start(max_rank), count(max_rank), rows, width, done

      call reader%open_item(path, attribute, item, error)
      if (allocated(error)) return
      rows = 1
      if (item%rank > 0) rows = item%extents(1)
      width = 1
      if (item%rank > 1) width = product(min(item%extents(2:item%rank), most))
      if (attribute == "" .and. item%rank > 0) then
         call item%open_scale(0, scale)
         call scale%close()
      end if
      start = 0
      count = item%extents
      done = 0
      do while (done < rows .and. width > 0 .and. width <= most .and. .not. item%is_null)
         count(1) = min(rows - done, max(most/width, 1_i8))
         if (attribute /= "") count(1) = rows
         if (count(1)*width > 16*most) exit
         start(1) = done
         select case (item%class)
         case (class_text)
            call item%read_texts(start, count, int(count(1)*width), texts, error)
         case (class_real, class_integer, class_unsigned)
            allocate(values(count(1)*width))
            call item%read(start, count, values, error)
            deallocate(values)
         case default
            exit
         end select
         if (allocated(error)) exit
         done = done + count(1)
      end do
      call item%close()
   end subroutine read_item

   !> Take over what C knows about an item.
   subroutine describe(item)
      class(hdf5_item_type), intent(inout) :: item
      integer(c_int) :: rank, is_null

      item%class = int(c_describe(item%handle, item%size, rank, item%extents, item%chunk, is_null))
      item%rank = int(rank)
      item%is_null = is_null /= 0
   end subroutine describe

   subroutine close_item(self)
      !> Item to close; one that is not open stays so.
      class(hdf5_item_type), intent(inout) :: self

      if (c_associated(self%handle)) call c_close_item(self%handle)
      self%handle = c_null_ptr
   end subroutine close_item

   !> Whether an item is open.
   pure logical function item_is_open(self)
      class(hdf5_item_type), intent(in) :: self

      item_is_open = c_associated(self%handle)
   end function item_is_open

   !> Words for the type of an item's values.
   function type_text(self) result(text)
      class(hdf5_item_type), intent(in) :: self
      !> Such as "64-bit reals".
      character(len=:), allocatable :: text

      text = text_from_c(c_type_text(self%handle))
   end function type_text

   !> Whether the values of two items are of the same type, bit for bit.
   logical function same_type(self, other)
      class(hdf5_item_type), intent(in) :: self
      !> Another item.
      class(hdf5_item_type), intent(in) :: other

      same_type = c_same_type(self%handle, other%handle) /= 0
   end function same_type

   !> Read a block of values: numbers into reals, integers into integers, which for unsigned ones
   !> are their bits, and values of class `class_raw` into bytes.
   subroutine read_values(self, start, count, buffer, error)
      class(hdf5_item_type), intent(in) :: self
      !> First indices; not used for attributes, which are read whole.
      integer(i8), intent(in) :: start(:)
      !> Numbers of indices.
      integer(i8), intent(in) :: count(:)
      !> Room for the values: eight-byte reals or integers, or bytes.
      type(*), intent(inout), contiguous, target :: buffer(..)
      type(error_type), allocatable, intent(out) :: error

      if (c_read(self%handle, start, count, buffer) /= 0) call report(error)
   end subroutine read_values

   !> Read a block of texts.
   subroutine read_texts(self, start, count, n, texts, error)
      class(hdf5_item_type), intent(in) :: self
      !> First indices; not used for attributes, which are read whole.
      integer(i8), intent(in) :: start(:)
      !> Numbers of indices.
      integer(i8), intent(in) :: count(:)
      !> Number of texts in the block.
      integer, intent(in) :: n
      type(string_type), allocatable, intent(inout) :: texts(:)
      type(error_type), allocatable, intent(out) :: error
      integer :: i

      if (c_read_texts(self%handle, start, count) /= 0) then
         call report(error)
         return
      end if
      if (allocated(texts)) then
         if (size(texts) < n) deallocate(texts)
      end if
      if (.not. allocated(texts)) allocate(texts(n))
      do i = 1, n
         texts(i)%s = text_from_c(c_text_of(self%handle, int(i - 1, c_int64_t)))
      end do
   end subroutine read_texts

   !> Open the scale of a dimension; a scale is its own. Without one the result is not open.
   subroutine open_scale(self, dimension, scale)
      !> The data set.
      class(hdf5_item_type), intent(in) :: self
      !> Dimension, from 0.
      integer, intent(in) :: dimension
      type(hdf5_item_type), intent(out) :: scale

      scale%handle = c_open_scale(self%handle, int(dimension, c_int))
      scale%name = ""
      if (.not. c_associated(scale%handle)) return
      call describe(scale)
      scale%name = text_from_c(c_scale_name(scale%handle))
   end subroutine open_scale

   !> Label of a dimension.
   function dimension_name(self, dimension) result(text)
      !> The data set.
      class(hdf5_item_type), intent(in) :: self
      !> Dimension, from 0.
      integer, intent(in) :: dimension
      !> The label; empty if there is none.
      character(len=:), allocatable :: text

      text = text_from_c(c_dimension_name(self%handle, int(dimension, c_int)))
   end function dimension_name

   !> Units of a data set.
   function units(self) result(text)
      !> The data set.
      class(hdf5_item_type), intent(in) :: self
      !> Its attribute `units`; empty if it has none.
      character(len=:), allocatable :: text

      text = text_from_c(c_units(self%handle))
   end function units

   !> Set the error that C has just met.
   subroutine report(error)
      type(error_type), allocatable, intent(out) :: error

      call fatal(error, text_from_c(c_message()), status_file)
   end subroutine report

end module contensou_files_hdf5_reader
