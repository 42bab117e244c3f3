!> Writing of HDF5 files in the manner of netCDF-4 and the CF conventions.
!>
!> Every data set carries `long_name` and, if it has a unit, `units` (UDUNITS text, "1" for pure
!> numbers), and has a dimension scale for each dimension. Scales and other objects are named by
!> their path in the file, such as "/trajectory/time". netCDF finds a scale only in the data set's
!> own group or one above it.
!>
!> Shapes and lists of scales are in the order of the file, outermost first, which is the reverse
!> of Fortran's: an array `a(xyz, body)` becomes the data set `(body, xyz)`.
!>
!> After a failure the file takes nothing but `abandon`, or `close`, which then abandons it and
!> reports the failure again. On the disk it is as last flushed, a full disk included, and so it is
!> if the process is killed or ends without either call. Only a kill during a flush, which takes
!> about a millisecond, can leave it unreadable; hence it belongs under a temporary name until it
!> is closed. A first flush after the set-up makes the file worth reading from the start.
module contensou_files_hdf5_file
   use, intrinsic :: iso_c_binding, only : c_associated, c_char, c_int, c_null_char, c_null_ptr, &
      c_ptr
   use contensou_base_errors, only : error_type, fatal, status_file
   use contensou_base_operating_system, only : text_from_c
   implicit none(type, external)
   private

   public :: hdf5_file_type, hdf5_series_type
   public :: series_real, series_integer, series_text, series_long, series_byte
   public :: hdf5_version

   !> Kind of a series of reals.
   integer, parameter :: series_real = 1

   !> Kind of a series of default integers.
   integer, parameter :: series_integer = 2

   !> Kind of a series of texts.
   integer, parameter :: series_text = 3

   !> Kind of a series of eight-byte integers.
   integer, parameter :: series_long = 4

   !> Kind of a series of one-byte integers.
   integer, parameter :: series_byte = 5

   !> Paths of no scales.
   character(len=1), parameter :: no_scales(0) = [character(len=1) ::]

   !> A data set that grows along its first dimension; valid until its file is closed.
   type :: hdf5_series_type
      private
      !> Address of what C keeps about it.
      type(c_ptr) :: handle = c_null_ptr
      !> Path in the file, for messages.
      character(len=:), allocatable :: path
   end type hdf5_series_type

   !> A file that is being written.
   type :: hdf5_file_type
      private
      !> Address of what C keeps about it; null when there is no open file.
      type(c_ptr) :: handle = c_null_ptr
   contains
      procedure :: create
      procedure :: is_open
      procedure :: flush => flush_file
      procedure :: sync => sync_file
      procedure :: bound_memory
      procedure :: close => close_file
      procedure :: close_as
      procedure :: abandon
      procedure :: create_group
      procedure :: put_attribute
      procedure :: put_attribute_values
      procedure :: put_labels
      procedure :: put_text
      procedure :: put_value
      procedure :: put_array
      procedure :: put_texts
      procedure :: create_series
      procedure :: append
   end type hdf5_file_type

   ! Functions of C. One that acts returns 0 on success, one that makes something null on failure.
   interface
      !> Create a file.
      type(c_ptr) function c_create(path) bind(c, name="contensou_hdf5_create")
         import :: c_char, c_ptr
         implicit none(type, external)
         !> Name of the file, null-terminated.
         character(kind=c_char), intent(in) :: path(*)
      end function c_create

      integer(c_int) function c_flush(file) bind(c, name="contensou_hdf5_flush")
         import :: c_int, c_ptr
         implicit none(type, external)
         type(c_ptr), value :: file
      end function c_flush

      !> Bring a flushed file to the disk.
      integer(c_int) function c_sync(file) bind(c, name="contensou_hdf5_sync")
         import :: c_int, c_ptr
         implicit none(type, external)
         type(c_ptr), value :: file
      end function c_sync

      !> Let metadata leave the memory before a flush.
      integer(c_int) function c_bound_memory(file) bind(c, name="contensou_hdf5_bound_memory")
         import :: c_int, c_ptr
         implicit none(type, external)
         type(c_ptr), value :: file
      end function c_bound_memory

      !> Close a file and free what belongs to it.
      integer(c_int) function c_close(file) bind(c, name="contensou_hdf5_close")
         import :: c_int, c_ptr
         implicit none(type, external)
         type(c_ptr), value :: file
      end function c_close

      !> Close a file, rename it while its lock is held, and free what belongs to it.
      integer(c_int) function c_close_as(file, name, replace) &
         bind(c, name="contensou_hdf5_close_as")
         import :: c_char, c_int, c_ptr
         implicit none(type, external)
         type(c_ptr), value :: file
         !> New name, null-terminated.
         character(kind=c_char), intent(in) :: name(*)
         !> Whether a file of the new name is replaced.
         integer(c_int), value :: replace
      end function c_close_as

      !> Give a file up and free what belongs to it.
      subroutine c_abandon(file) bind(c, name="contensou_hdf5_abandon")
         import :: c_ptr
         implicit none(type, external)
         type(c_ptr), value :: file
      end subroutine c_abandon

      integer(c_int) function c_create_group(file, path) bind(c, name="contensou_hdf5_create_group")
         import :: c_char, c_int, c_ptr
         implicit none(type, external)
         type(c_ptr), value :: file
         !> Path of the group, null-terminated.
         character(kind=c_char), intent(in) :: path(*)
      end function c_create_group

      !> Write an attribute.
      integer(c_int) function c_put_attribute(file, object, name, values) &
         bind(c, name="contensou_hdf5_put_attribute")
         import :: c_char, c_int, c_ptr
         implicit none(type, external)
         type(c_ptr), value :: file
         !> Path of the object, null-terminated.
         character(kind=c_char), intent(in) :: object(*)
         !> Name of the attribute, null-terminated.
         character(kind=c_char), intent(in) :: name(*)
         type(*), intent(in), contiguous :: values(..)
      end function c_put_attribute

      !> Write a data set of fixed size.
      function c_put_dataset(file, path, values, scales, is_scale, units, long_name) &
         result(code) bind(c, name="contensou_hdf5_put_dataset")
         import :: c_char, c_int, c_ptr
         implicit none(type, external)
         type(c_ptr), value :: file
         !> Path of the data set, null-terminated.
         character(kind=c_char), intent(in) :: path(*)
         type(*), intent(in), contiguous :: values(..)
         !> Paths of the scales, outermost first.
         character(kind=c_char, len=*), intent(in), contiguous :: scales(:)
         !> 1 if the data set is a scale itself.
         integer(c_int), value :: is_scale
         !> Units, null-terminated; empty for none.
         character(kind=c_char), intent(in) :: units(*)
         !> Description, null-terminated.
         character(kind=c_char), intent(in) :: long_name(*)
         !> 0 on success.
         integer(c_int) :: code
      end function c_put_dataset

      !> Create a data set that grows.
      function c_create_series(file, path, kind, extents, chunk_rows, compress, scales, is_scale, &
         units, long_name) result(series) bind(c, name="contensou_hdf5_create_series")
         import :: c_char, c_int, c_ptr
         implicit none(type, external)
         type(c_ptr), value :: file
         !> Path of the data set, null-terminated.
         character(kind=c_char), intent(in) :: path(*)
         !> One of the `series_*` parameters.
         integer(c_int), value :: kind
         !> Extents of the dimensions after the growing one, outermost first.
         integer(c_int), intent(in), contiguous :: extents(:)
         integer(c_int), value :: chunk_rows
         !> 1 to compress.
         integer(c_int), value :: compress
         !> Paths of the scales, outermost first.
         character(kind=c_char, len=*), intent(in), contiguous :: scales(:)
         !> 1 if the data set is a scale itself.
         integer(c_int), value :: is_scale
         !> Units, null-terminated; empty for none.
         character(kind=c_char), intent(in) :: units(*)
         !> Description, null-terminated.
         character(kind=c_char), intent(in) :: long_name(*)
         !> The series, or null.
         type(c_ptr) :: series
      end function c_create_series

      integer(c_int) function c_append(series, rows, values, path) &
         bind(c, name="contensou_hdf5_append")
         import :: c_char, c_int, c_ptr
         implicit none(type, external)
         type(c_ptr), value :: series
         integer(c_int), value :: rows
         type(*), intent(in), contiguous :: values(..)
         !> Path of the data set, null-terminated, for messages.
         character(kind=c_char), intent(in) :: path(*)
      end function c_append

      !> Reason of the last failure.
      type(c_ptr) function c_message() bind(c, name="contensou_hdf5_message")
         import :: c_ptr
         implicit none(type, external)
      end function c_message

      !> Version of the library.
      type(c_ptr) function c_version() bind(c, name="contensou_hdf5_version")
         import :: c_ptr
         implicit none(type, external)
      end function c_version
   end interface

contains

   !> Create a file, emptying one of that name; a file open so far is abandoned.
   subroutine create(self, path, error)
      class(hdf5_file_type), intent(inout) :: self
      character(len=*), intent(in) :: path
      !> Set when the file cannot be created, or another program is writing it.
      type(error_type), allocatable, intent(out) :: error

      call self%abandon()
      self%handle = c_create(c_text(path))
      if (.not. c_associated(self%handle)) call report(error)
   end subroutine create

   !> Whether a file is open.
   pure function is_open(self) result(answer)
      class(hdf5_file_type), intent(in) :: self
      !> False before `create` and after `close` or `abandon`.
      logical :: answer

      answer = c_associated(self%handle)
   end function is_open

   !> Hand everything written so far to the operating system: what a process killed later leaves.
   subroutine flush_file(self, error)
      class(hdf5_file_type), intent(inout) :: self
      type(error_type), allocatable, intent(out) :: error

      call require_open(self, error)
      if (allocated(error)) return
      call check(c_flush(self%handle), error)
   end subroutine flush_file

   !> Bring what was flushed to the disk: what a power failure leaves.
   subroutine sync_file(self, error)
      class(hdf5_file_type), intent(inout) :: self
      type(error_type), allocatable, intent(out) :: error

      call require_open(self, error)
      if (allocated(error)) return
      call check(c_sync(self%handle), error)
   end subroutine sync_file

   !> Let memory not grow with the file. A process killed later leaves nothing that can be read.
   subroutine bound_memory(self, error)
      class(hdf5_file_type), intent(inout) :: self
      type(error_type), allocatable, intent(out) :: error

      call require_open(self, error)
      if (allocated(error)) return
      call check(c_bound_memory(self%handle), error)
   end subroutine bound_memory

   !> Finish the file. Nothing is left open even if that fails.
   subroutine close_file(self, error)
      !> File to close; one that is not open stays so.
      class(hdf5_file_type), intent(inout) :: self
      !> Set when something could not be written, now or earlier.
      type(error_type), allocatable, intent(out) :: error

      if (.not. self%is_open()) return
      call check(c_close(self%handle), error)
      self%handle = c_null_ptr
   end subroutine close_file

   !> Finish the file and give it another name; no other program can take it in between.
   subroutine close_as(self, name, replace, error)
      class(hdf5_file_type), intent(inout) :: self
      !> New name of the file.
      character(len=*), intent(in) :: name
      !> Whether a file of that name is replaced.
      logical, intent(in) :: replace
      !> Set when something could not be written, now or earlier, or renamed.
      type(error_type), allocatable, intent(out) :: error

      if (.not. self%is_open()) return
      call check(c_close_as(self%handle, c_text(name), merge(1_c_int, 0_c_int, replace)), error)
      self%handle = c_null_ptr
   end subroutine close_as

   !> Give the file up: free everything, and leave it on the disk as it was last flushed.
   subroutine abandon(self)
      !> File to give up; one that is not open stays so.
      class(hdf5_file_type), intent(inout) :: self

      if (.not. self%is_open()) return
      call c_abandon(self%handle)
      self%handle = c_null_ptr
   end subroutine abandon

   !> Create a group, inside one that exists.
   subroutine create_group(self, path, error)
      class(hdf5_file_type), intent(inout) :: self
      character(len=*), intent(in) :: path
      type(error_type), allocatable, intent(out) :: error

      call require_open(self, error)
      if (allocated(error)) return
      call check(c_create_group(self%handle, c_text(path)), error)
   end subroutine create_group

   !> Create an attribute that is a text, or replace its value.
   subroutine put_attribute(self, object, name, value, error)
      class(hdf5_file_type), intent(inout) :: self
      !> Path of the group or data set; "/" for the file itself.
      character(len=*), intent(in) :: object
      character(len=*), intent(in) :: name
      !> The text; trailing blanks are left out.
      character(len=*), intent(in) :: value
      type(error_type), allocatable, intent(out) :: error

      call self%put_attribute_values(object, name, value, error)
   end subroutine put_attribute

   !> Create an attribute of numbers or texts, or replace its value.
   subroutine put_attribute_values(self, object, name, values, error)
      class(hdf5_file_type), intent(inout) :: self
      !> Path of the group or data set; "/" for the file itself.
      character(len=*), intent(in) :: object
      character(len=*), intent(in) :: name
      !> A number, or a list of numbers or texts. Not a single text, of which gfortran 12 forgets
      !> the length unless it is a variable.
      type(*), intent(in), contiguous, target :: values(..)
      type(error_type), allocatable, intent(out) :: error

      call require_open(self, error)
      if (.not. allocated(error)) call check(c_put_attribute(self%handle, c_text(object), &
         c_text(name), values), error)
   end subroutine put_attribute_values

   !> Write a list of labels as the scale of a dimension.
   subroutine put_labels(self, path, labels, long_name, error)
      class(hdf5_file_type), intent(inout) :: self
      character(len=*), intent(in) :: path
      !> The labels, each without trailing blanks.
      character(len=*), intent(in) :: labels(:)
      character(len=*), intent(in) :: long_name
      type(error_type), allocatable, intent(out) :: error

      call put_dataset(self, path, no_scales, .true., "", long_name, labels, error)
   end subroutine put_labels

   !> Write one text as it is.
   subroutine put_text(self, path, text, long_name, error)
      class(hdf5_file_type), intent(inout) :: self
      character(len=*), intent(in) :: path
      character(len=*), intent(in) :: text
      character(len=*), intent(in) :: long_name
      type(error_type), allocatable, intent(out) :: error

      call put_dataset(self, path, no_scales, .false., "", long_name, text, error)
   end subroutine put_text

   !> Write one number.
   subroutine put_value(self, path, value, units, long_name, error)
      class(hdf5_file_type), intent(inout) :: self
      character(len=*), intent(in) :: path
      type(*), intent(in), contiguous, target :: value(..)
      !> Its unit; empty for none.
      character(len=*), intent(in) :: units
      character(len=*), intent(in) :: long_name
      type(error_type), allocatable, intent(out) :: error

      call put_dataset(self, path, no_scales, .false., units, long_name, value, error)
   end subroutine put_value

   !> Write an array of numbers.
   subroutine put_array(self, path, array, dims, units, long_name, error)
      class(hdf5_file_type), intent(inout) :: self
      character(len=*), intent(in) :: path
      !> The numbers; the last Fortran index becomes the first dimension. Not texts: see
      !> `put_dataset`.
      type(*), intent(in), contiguous, target :: array(..)
      !> Paths of the scales, outermost first.
      character(len=*), intent(in) :: dims(:)
      !> Their units; empty for none.
      character(len=*), intent(in) :: units
      character(len=*), intent(in) :: long_name
      type(error_type), allocatable, intent(out) :: error

      call put_dataset(self, path, dims, .false., units, long_name, array, error)
   end subroutine put_array

   !> Write an array of texts, each without trailing blanks.
   subroutine put_texts(self, path, array, dims, long_name, error)
      class(hdf5_file_type), intent(inout) :: self
      character(len=*), intent(in) :: path
      !> The texts; the last Fortran index becomes the first dimension.
      character(len=*), intent(in), contiguous :: array(..)
      !> Paths of the scales, outermost first.
      character(len=*), intent(in) :: dims(:)
      character(len=*), intent(in) :: long_name
      type(error_type), allocatable, intent(out) :: error

      call put_dataset(self, path, dims, .false., "", long_name, array, error)
   end subroutine put_texts

   !> Write a data set of any kind. The values stand behind all texts: gfortran 12 passes the length
   !> of texts among them, which it does not expect, and takes it for that of the next one.
   subroutine put_dataset(self, path, dims, is_scale, units, long_name, values, error)
      type(hdf5_file_type), intent(in) :: self
      character(len=*), intent(in) :: path
      !> Paths of the scales, outermost first.
      character(len=*), intent(in) :: dims(:)
      !> Whether it is a scale itself.
      logical, intent(in) :: is_scale
      !> Units; empty for none.
      character(len=*), intent(in) :: units
      character(len=*), intent(in) :: long_name
      type(*), intent(in), contiguous, target :: values(..)
      type(error_type), allocatable, intent(out) :: error

      call require_open(self, error)
      if (.not. allocated(error)) call check(c_put_dataset(self%handle, c_text(path), values, &
         dims, merge(1, 0, is_scale), c_text(units), c_text(long_name)), error)
   end subroutine put_dataset

   !> Create a data set that grows along its first dimension, with no rows as yet.
   subroutine create_series(self, path, extents, dims, is_scale, chunk_rows, units, long_name, &
      kind, series, error, compressed)
      class(hdf5_file_type), intent(inout) :: self
      character(len=*), intent(in) :: path
      !> Extents of the dimensions after the growing one, outermost first; none for one value a row.
      integer, intent(in) :: extents(:)
      !> Paths of the scales, that of the growing dimension first; none for a scale.
      character(len=*), intent(in) :: dims(:)
      !> Whether the series itself is the scale of its growing dimension.
      logical, intent(in) :: is_scale
      !> Rows in a chunk, the unit of storage. Long rows make it less, as a chunk is 4 MiB at most.
      integer, intent(in) :: chunk_rows
      !> Units; empty for none.
      character(len=*), intent(in) :: units
      character(len=*), intent(in) :: long_name
      !> One of the `series_*` parameters.
      integer, intent(in) :: kind
      !> The series, for `append`.
      type(hdf5_series_type), intent(out) :: series
      type(error_type), allocatable, intent(out) :: error
      !> Whether chunks are compressed, which pays where they are written whole; default `.false.`.
      logical, intent(in), optional :: compressed
      integer(c_int) :: compress

      call require_open(self, error)
      if (allocated(error)) return
      compress = 0
      if (present(compressed)) compress = merge(1_c_int, 0_c_int, compressed)
      series%path = trim(path)
      series%handle = c_create_series(self%handle, c_text(path), kind, extents, chunk_rows, &
         compress, dims, merge(1, 0, is_scale), c_text(units), c_text(long_name))
      if (.not. c_associated(series%handle)) call report(error)
   end subroutine create_series

   !> Append rows of numbers, or of texts without trailing blanks.
   subroutine append(self, series, n_rows, buffer, error)
      class(hdf5_file_type), intent(inout) :: self
      type(hdf5_series_type), intent(in) :: series
      !> Number of rows; the buffer may hold more.
      integer, intent(in) :: n_rows
      !> Values of any shape whose last index, or only one, counts the rows.
      type(*), intent(in), contiguous, target :: buffer(..)
      type(error_type), allocatable, intent(out) :: error

      call require_open(self, error)
      if (allocated(error)) return
      if (.not. c_associated(series%handle)) then
         call fatal(error, "rows appended to a series that was never created", status_file)
      else
         call check(c_append(series%handle, n_rows, buffer, c_text(series%path)), error)
      end if
   end subroutine append

   !> Version of the HDF5 library in use.
   function hdf5_version() result(text)
      !> Such as "1.10.8".
      character(len=:), allocatable :: text

      text = text_from_c(c_version())
   end function hdf5_version

   !> Check that there is a file to write to.
   subroutine require_open(self, error)
      class(hdf5_file_type), intent(in) :: self
      !> Set when it is not open.
      type(error_type), allocatable, intent(out) :: error

      if (.not. self%is_open()) call fatal(error, "no output file is open", status_file)
   end subroutine require_open

   !> Turn C's answer into an error.
   subroutine check(code, error)
      !> 0 on success.
      integer(c_int), intent(in) :: code
      !> Set otherwise.
      type(error_type), allocatable, intent(out) :: error

      if (code /= 0) call report(error)
   end subroutine check

   !> Set the error that C has just met.
   subroutine report(error)
      type(error_type), allocatable, intent(out) :: error

      call fatal(error, text_from_c(c_message()), status_file)
   end subroutine report

   !> A text as C takes it, without trailing blanks.
   pure function c_text(text) result(copy)
      !> Text to pass.
      character(len=*), intent(in) :: text
      !> The text and a null character.
      character(kind=c_char, len=:), allocatable :: copy

      copy = trim(text) // c_null_char
   end function c_text

end module contensou_files_hdf5_file
