!> The file from which an interrupted run goes on: numbers and texts by name, bit for bit.
!>
!> What is to be kept is listed once: a procedure that calls `exchange` for each component writes
!> them after `begin` and reads them back after `load`. A failure is kept: nothing more is
!> exchanged after it, and `result` tells it.
!>
!> A text file: a line that says what it is, a line for each item, and a line with the checksum of
!> all before. Reals stand as the 16 hexadecimal digits of their bits. It is replaced as a whole,
!> so that a run killed at any moment leaves the last one or the one before.
module contensou_base_checkpoint
   use, intrinsic :: iso_c_binding, only : c_f_pointer, c_loc
   use contensou_base_document, only : read_file
   use contensou_base_errors, only : error_type, fatal, status_file
   use contensou_base_kinds, only : i8, wp
   use contensou_base_numbers, only : to_text
   use contensou_base_operating_system, only : checksum, save_file
   use contensou_base_text, only : quote, starts_with
   implicit none(type, external)
   private

   public :: checkpoint_type, checkpoint_heading

   !> What the file is and the version of its form.
   character(len=*), parameter :: checkpoint_heading = "contensou-checkpoint 6"

   character(len=*), parameter :: kind_real = "real"

   character(len=*), parameter :: kind_integer = "integer"

   character(len=*), parameter :: kind_text = "text"

   !> A checkpoint that is being made or read.
   type :: checkpoint_type
      private
      !> Its lines so far, up to `length`.
      character(len=:), allocatable :: lines
      !> Used length of that.
      integer :: length = 0
      !> Where the next item is expected when reading.
      integer :: next = 1
      !> Whether `exchange` reads.
      logical :: reading = .false.
      !> The first failure.
      type(error_type), allocatable :: failure
   contains
      procedure :: begin
      procedure :: load
      procedure :: is_reading
      procedure :: holds
      !> Write or read an item: reals, integers or truth values of any shape, or a text of one line.
      generic :: exchange => exchange_reals, exchange_longs, exchange_integers, &
         exchange_logicals, exchange_text
      procedure :: exchange_allocatable
      procedure :: result => result_of
      procedure :: save
      procedure :: to_memory
      procedure :: from_memory
      procedure, private :: exchange_reals, exchange_longs, exchange_integers, exchange_logicals
      procedure, private :: exchange_text
   end type checkpoint_type

contains

   !> Begin an empty one, to be written.
   subroutine begin(self)
      class(checkpoint_type), intent(inout) :: self

      self%length = 0
      self%reading = .false.
      if (allocated(self%failure)) deallocate(self%failure)
      if (.not. allocated(self%lines)) allocate(character(len=4096) :: self%lines)
      call add(self, checkpoint_heading // new_line("a"))
   end subroutine begin

   !> Whether `exchange` reads.
   pure logical function is_reading(self)
      class(checkpoint_type), intent(in) :: self

      is_reading = self%reading
   end function is_reading

   !> Whether there is an integer of this name.
   pure logical function holds(self, name)
      class(checkpoint_type), intent(in) :: self
      character(len=*), intent(in) :: name

      holds = index(self%lines(:self%length), new_line("a") // kind_integer // " " // name // &
         " ") > 0
   end function holds

   !> The first failure of `exchange`, if any.
   subroutine result_of(self, error)
      class(checkpoint_type), intent(in) :: self
      !> Set when an item is not there, or is of another size.
      type(error_type), allocatable, intent(out) :: error

      if (allocated(self%failure)) error = self%failure
   end subroutine result_of

   !> Write or read reals.
   subroutine exchange_reals(self, name, values)
      class(checkpoint_type), intent(inout) :: self
      !> Name of the item, without blanks.
      character(len=*), intent(in) :: name
      real(wp), intent(inout), contiguous, target :: values(..)
      real(wp), pointer :: flat(:)
      character(len=:), allocatable :: text
      integer(i8) :: bits(size(values))
      integer :: stat

      call c_f_pointer(c_loc(values), flat, [size(values)])
      if (self%reading) then
         call take(self, kind_real, name, size(values), text)
         if (allocated(self%failure)) return
         read(text, "(*(z16, 1x))", iostat=stat) bits
         if (stat /= 0) call fail(self, quote(name) // " cannot be read")
         if (stat == 0) flat = transfer(bits, flat)
      else
         bits = transfer(flat, bits)
         allocate(character(len=17*size(bits)) :: text)
         if (size(bits) > 0) write(text, "(*(z16.16, :, 1x))") bits
         call add_item(self, kind_real, name, size(values), text)
      end if
   end subroutine exchange_reals

   !> Write or read integers of eight bytes.
   subroutine exchange_longs(self, name, values)
      class(checkpoint_type), intent(inout) :: self
      !> Name of the item, without blanks.
      character(len=*), intent(in) :: name
      integer(i8), intent(inout), contiguous, target :: values(..)
      integer(i8), pointer :: flat(:)
      character(len=:), allocatable :: text
      integer :: stat

      call c_f_pointer(c_loc(values), flat, [size(values)])
      if (self%reading) then
         call take(self, kind_integer, name, size(values), text)
         if (allocated(self%failure) .or. size(values) == 0) return
         read(text, *, iostat=stat) flat
         if (stat /= 0) call fail(self, quote(name) // " cannot be read")
      else
         allocate(character(len=21*size(values)) :: text)
         if (size(values) > 0) write(text, "(*(i0, :, 1x))") flat
         call add_item(self, kind_integer, name, size(values), text)
      end if
   end subroutine exchange_longs

   !> Write or read integers.
   subroutine exchange_integers(self, name, values)
      class(checkpoint_type), intent(inout) :: self
      !> Name of the item, without blanks.
      character(len=*), intent(in) :: name
      integer, intent(inout), contiguous, target :: values(..)
      integer, pointer :: flat(:)
      integer(i8) :: longs(size(values))

      call c_f_pointer(c_loc(values), flat, [size(values)])
      longs = flat
      call self%exchange_longs(name, longs)
      flat = int(longs)
   end subroutine exchange_integers

   !> Write or read truth values.
   subroutine exchange_logicals(self, name, values)
      class(checkpoint_type), intent(inout) :: self
      !> Name of the item, without blanks.
      character(len=*), intent(in) :: name
      logical, intent(inout), contiguous, target :: values(..)
      logical, pointer :: flat(:)
      integer(i8) :: longs(size(values))

      call c_f_pointer(c_loc(values), flat, [size(values)])
      longs = 0_i8
      if (.not. self%is_reading()) longs = merge(1_i8, 0_i8, flat)
      call self%exchange_longs(name, longs)
      flat = longs /= 0
   end subroutine exchange_logicals

   !> Write or read a text of one line, trailing blanks aside.
   subroutine exchange_text(self, name, value)
      class(checkpoint_type), intent(inout) :: self
      !> Name of the item, without blanks.
      character(len=*), intent(in) :: name
      !> The text; one that is read must fit into it.
      character(len=*), intent(inout) :: value
      character(len=:), allocatable :: text

      if (self%reading) then
         call take(self, kind_text, name, -1, text)
         if (allocated(self%failure)) return
         if (len(text) > len(value)) call fail(self, quote(name) // " is too long")
         value = text
      else
         call add_item(self, kind_text, name, 1, trim(value))
      end if
   end subroutine exchange_text

   !> Write or read a text of one line that may not be allocated.
   subroutine exchange_allocatable(self, name, value)
      class(checkpoint_type), intent(inout) :: self
      !> Name of the item, without blanks.
      character(len=*), intent(in) :: name
      character(len=:), allocatable, intent(inout) :: value
      logical :: there

      there = allocated(value)
      call self%exchange(name // "_set", there)
      if (allocated(self%failure) .or. .not. there) return
      if (self%reading) then
         call take(self, kind_text, name, -1, value)
      else
         call add_item(self, kind_text, name, 1, value)
      end if
   end subroutine exchange_allocatable

   !> Add some text.
   subroutine add(self, text)
      class(checkpoint_type), intent(inout) :: self
      character(len=*), intent(in) :: text
      character(len=:), allocatable :: longer

      if (self%length + len(text) > len(self%lines)) then
         allocate(character(len=2*(self%length + len(text))) :: longer)
         longer(:self%length) = self%lines(:self%length)
         call move_alloc(longer, self%lines)
      end if
      self%lines(self%length + 1:self%length + len(text)) = text
      self%length = self%length + len(text)
   end subroutine add

   !> Add the line of an item.
   subroutine add_item(self, kind, name, count, values)
      class(checkpoint_type), intent(inout) :: self
      character(len=*), intent(in) :: kind
      character(len=*), intent(in) :: name
      !> Number of values.
      integer, intent(in) :: count
      !> The values in words.
      character(len=*), intent(in) :: values

      call add(self, kind // " " // name // " " // to_text(count) // " " // trim(values) // &
         new_line("a"))
   end subroutine add_item

   !> Take the values of an item out of its line.
   subroutine take(self, kind, name, expected, values)
      class(checkpoint_type), intent(inout) :: self
      character(len=*), intent(in) :: kind
      character(len=*), intent(in) :: name
      !> Number of values that there must be; -1 for any.
      integer, intent(in) :: expected
      !> The values in words.
      character(len=:), allocatable, intent(out) :: values
      character(len=:), allocatable :: start
      integer :: first, last, blank, count, stat

      values = ""
      if (allocated(self%failure)) return
      start = kind // " " // name // " "
      if (.not. starts_with(self%lines(self%next:self%length), start)) then
         ! Not the next one.
         self%next = index(self%lines(:self%length), new_line("a") // start) + 1
         if (self%next == 1) then
            call fail(self, "there is no " // quote(name) // " in it")
            return
         end if
      end if
      first = self%next + len(start)
      last = first + index(self%lines(first:self%length), new_line("a")) - 2
      self%next = last + 2
      blank = scan(self%lines(first:last), " ")
      read(self%lines(first:first + blank - 2), *, iostat=stat) count
      if (stat /= 0 .or. blank == 0) then
         call fail(self, quote(name) // " cannot be read")
      else if (expected >= 0 .and. count /= expected) then
         call fail(self, quote(name) // " has " // to_text(count) // " values in it, not " // &
            to_text(expected))
      else
         values = self%lines(first + blank:last)
      end if
   end subroutine take

   !> Keep the first failure.
   subroutine fail(self, message)
      class(checkpoint_type), intent(inout) :: self
      character(len=*), intent(in) :: message

      if (.not. allocated(self%failure)) call fatal(self%failure, message, status_file)
   end subroutine fail

   !> Replace the file.
   subroutine save(self, path, error)
      class(checkpoint_type), intent(inout) :: self
      character(len=*), intent(in) :: path
      !> Set when the file is as it was before.
      type(error_type), allocatable, intent(out) :: error

      call add(self, checksum_line(self%lines(:self%length)))
      call save_file(path, self%lines(:self%length), error)
   end subroutine save

   !> The file as a text.
   subroutine to_memory(self, text)
      class(checkpoint_type), intent(inout) :: self
      character(len=:), allocatable, intent(out) :: text

      call add(self, checksum_line(self%lines(:self%length)))
      text = self%lines(:self%length)
   end subroutine to_memory

   !> Read the file.
   subroutine load(self, path, error)
      class(checkpoint_type), intent(inout) :: self
      character(len=*), intent(in) :: path
      !> Set when it cannot be read, or is damaged.
      type(error_type), allocatable, intent(out) :: error
      character(len=:), allocatable :: text

      call read_file(path, text, error)
      if (.not. allocated(error)) call self%from_memory(path, text, error)
   end subroutine load

   !> Take the file as a text.
   subroutine from_memory(self, path, text, error)
      class(checkpoint_type), intent(inout) :: self
      !> What it is called in messages.
      character(len=*), intent(in) :: path
      character(len=*), intent(in) :: text
      !> Set when it is damaged.
      type(error_type), allocatable, intent(out) :: error
      character(len=:), allocatable :: last
      integer :: place

      self%lines = text
      if (allocated(self%failure)) deallocate(self%failure)
      self%length = len(self%lines)
      self%reading = .true.
      self%next = len(checkpoint_heading) + 2
      if (.not. starts_with(self%lines, checkpoint_heading // new_line("a"))) then
         call fatal(error, path // " is damaged, or no checkpoint of this version of the " // &
            "program", status_file)
         return
      end if
      last = checksum_line("")
      place = self%length - len(last)
      if (place > 0) then
         if (self%lines(place + 1:) == checksum_line(self%lines(:place))) return
      end if
      call fatal(error, path // " is damaged", status_file)
   end subroutine from_memory

   !> The last line of a file.
   function checksum_line(lines) result(line)
      !> All lines before.
      character(len=*), intent(in) :: lines
      character(len=:), allocatable :: line
      character(len=16) :: digits

      write(digits, "(z16.16)") checksum(0_i8, lines)
      line = "checksum " // digits // new_line("a")
   end function checksum_line

end module contensou_base_checkpoint
