!> The file from which an interrupted run goes on: numbers and texts by name, bit for bit.
!>
!> A text file: a line that says what it is, a line for each item, and a line with the checksum of
!> all before. Reals stand as the 16 hexadecimal digits of their bits. It is replaced as a whole,
!> so that a run killed at any moment leaves the last one or the one before.
module contensou_files_checkpoint
   use contensou_base_document, only : read_file
   use contensou_base_errors, only : error_type, fatal, status_file
   use contensou_base_kinds, only : i8, wp
   use contensou_base_operating_system, only : checksum, save_file
   use contensou_base_text, only : quote, starts_with, to_text
   implicit none(type, external)
   private

   public :: checkpoint_type

   !> What the file is and the version of its form.
   character(len=*), parameter :: heading = "contensou-checkpoint 2"

   !> Item of reals.
   character(len=*), parameter :: kind_real = "real"

   !> Item of integers.
   character(len=*), parameter :: kind_integer = "integer"

   !> Item that is a text.
   character(len=*), parameter :: kind_text = "text"

   !> A checkpoint that is being made or read.
   type :: checkpoint_type
      !> Its lines so far, up to `length`.
      character(len=:), allocatable, private :: lines
      !> Used length of that.
      integer, private :: length = 0
   contains
      !> Begin an empty one.
      procedure :: begin
      !> Add an item.
      generic :: put => put_reals, put_integers, put_logicals, put_text
      !> Read an item.
      generic :: get => get_reals, get_integers, get_logicals, get_text
      !> Replace the file.
      procedure :: save
      !> Read the file.
      procedure :: load
      procedure, private :: put_reals, put_integers, put_logicals, put_text
      procedure, private :: get_reals, get_integers, get_logicals, get_text
   end type checkpoint_type

contains

   !> Begin an empty one.
   subroutine begin(self)
      class(checkpoint_type), intent(inout) :: self

      self%length = 0
      if (.not. allocated(self%lines)) allocate(character(len=4096) :: self%lines)
      call add(self, heading // new_line("a"))
   end subroutine begin

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

   !> Add reals.
   subroutine put_reals(self, name, values)
      class(checkpoint_type), intent(inout) :: self
      !> Name of the item, without blanks.
      character(len=*), intent(in) :: name
      real(wp), intent(in) :: values(:)
      character(len=16) :: digits
      integer :: i

      call add(self, kind_real // " " // name // " " // to_text(size(values)))
      do i = 1, size(values)
         write(digits, "(z16.16)") transfer(values(i), 0_i8)
         call add(self, " " // digits)
      end do
      call add(self, new_line("a"))
   end subroutine put_reals

   !> Add integers.
   subroutine put_integers(self, name, values)
      class(checkpoint_type), intent(inout) :: self
      !> Name of the item, without blanks.
      character(len=*), intent(in) :: name
      integer(i8), intent(in) :: values(:)
      integer :: i

      call add(self, kind_integer // " " // name // " " // to_text(size(values)))
      do i = 1, size(values)
         call add(self, " " // to_text(values(i)))
      end do
      call add(self, new_line("a"))
   end subroutine put_integers

   !> Add truth values.
   subroutine put_logicals(self, name, values)
      class(checkpoint_type), intent(inout) :: self
      !> Name of the item, without blanks.
      character(len=*), intent(in) :: name
      logical, intent(in) :: values(:)

      call self%put_integers(name, merge(1_i8, 0_i8, values))
   end subroutine put_logicals

   !> Add a text of one line.
   subroutine put_text(self, name, value)
      class(checkpoint_type), intent(inout) :: self
      !> Name of the item, without blanks.
      character(len=*), intent(in) :: name
      !> The text.
      character(len=*), intent(in) :: value

      call add(self, kind_text // " " // name // " " // to_text(len(value)) // " " // value // &
         new_line("a"))
   end subroutine put_text

   !> Find an item; the place of its first value.
   subroutine find(self, kind, name, first, last, count, error)
      class(checkpoint_type), intent(in) :: self
      !> Kind of the item.
      character(len=*), intent(in) :: kind
      character(len=*), intent(in) :: name
      !> Where its values begin in the lines.
      integer, intent(out) :: first
      !> Where they end.
      integer, intent(out) :: last
      !> Their number.
      integer, intent(out) :: count
      !> Set when there is no such item.
      type(error_type), allocatable, intent(out) :: error
      character(len=:), allocatable :: start
      integer :: place, blank, stat

      count = 0
      last = 0
      first = 1
      start = new_line("a") // kind // " " // name // " "
      place = index(self%lines(:self%length), start)
      if (place > 0) then
         first = place + len(start)
         last = first + index(self%lines(first:self%length), new_line("a")) - 2
         blank = scan(self%lines(first:last) // " ", " ")
         read(self%lines(first:first + blank - 2), *, iostat=stat) count
         first = first + blank
         if (stat == 0) return
      end if
      call fatal(error, "there is no " // quote(name) // " in it", status_file)
   end subroutine find

   !> Read reals.
   subroutine get_reals(self, name, values, error)
      class(checkpoint_type), intent(in) :: self
      !> Name of the item.
      character(len=*), intent(in) :: name
      real(wp), intent(inout) :: values(:)
      !> Set when there is no such item, or one of another size.
      type(error_type), allocatable, intent(out) :: error
      integer(i8) :: bits
      integer :: first, last, count, i, stat

      call find(self, kind_real, name, first, last, count, error)
      if (.not. allocated(error)) call see_size(name, count, size(values), error)
      if (allocated(error)) return
      do i = 1, count
         read(self%lines(first + 17*(i - 1):min(first + 17*i - 2, last)), "(z16)", iostat=stat) bits
         if (stat /= 0) call fatal(error, quote(name) // " cannot be read", status_file)
         if (allocated(error)) return
         values(i) = transfer(bits, 1.0_wp)
      end do
   end subroutine get_reals

   !> Read integers.
   subroutine get_integers(self, name, values, error)
      class(checkpoint_type), intent(in) :: self
      !> Name of the item.
      character(len=*), intent(in) :: name
      integer(i8), intent(inout) :: values(:)
      !> Set when there is no such item, or one of another size.
      type(error_type), allocatable, intent(out) :: error
      integer :: first, last, count, stat

      call find(self, kind_integer, name, first, last, count, error)
      if (.not. allocated(error)) call see_size(name, count, size(values), error)
      if (allocated(error) .or. count == 0) return
      read(self%lines(first:last), *, iostat=stat) values
      if (stat /= 0) call fatal(error, quote(name) // " cannot be read", status_file)
   end subroutine get_integers

   !> Read truth values.
   subroutine get_logicals(self, name, values, error)
      class(checkpoint_type), intent(in) :: self
      !> Name of the item.
      character(len=*), intent(in) :: name
      logical, intent(inout) :: values(:)
      !> Set when there is no such item, or one of another size.
      type(error_type), allocatable, intent(out) :: error
      integer(i8) :: numbers(size(values))

      call self%get_integers(name, numbers, error)
      if (.not. allocated(error)) values = numbers /= 0
   end subroutine get_logicals

   !> Read a text.
   subroutine get_text(self, name, value, error)
      class(checkpoint_type), intent(in) :: self
      !> Name of the item.
      character(len=*), intent(in) :: name
      !> The text.
      character(len=:), allocatable, intent(out) :: value
      !> Set when there is no such item.
      type(error_type), allocatable, intent(out) :: error
      integer :: first, last, count

      value = ""
      call find(self, kind_text, name, first, last, count, error)
      if (.not. allocated(error)) value = self%lines(first:last)
   end subroutine get_text

   !> See that an item has the size that is expected.
   subroutine see_size(name, count, expected, error)
      !> Name of the item.
      character(len=*), intent(in) :: name
      !> Number of its values.
      integer, intent(in) :: count
      !> Number that is expected.
      integer, intent(in) :: expected
      !> Set when they differ.
      type(error_type), allocatable, intent(out) :: error

      if (count /= expected) call fatal(error, quote(name) // " has " // to_text(count) // &
         " values in it, not " // to_text(expected), status_file)
   end subroutine see_size

   !> Replace the file.
   subroutine save(self, path, error)
      class(checkpoint_type), intent(inout) :: self
      !> Name of the file.
      character(len=*), intent(in) :: path
      !> Set when the file is as it was before.
      type(error_type), allocatable, intent(out) :: error

      call add(self, checksum_line(self%lines(:self%length)))
      call save_file(path, self%lines(:self%length), error)
   end subroutine save

   !> Read the file.
   subroutine load(self, path, error)
      class(checkpoint_type), intent(inout) :: self
      !> Name of the file.
      character(len=*), intent(in) :: path
      !> Set when it cannot be read, or is damaged.
      type(error_type), allocatable, intent(out) :: error
      character(len=:), allocatable :: last
      integer :: place

      if (allocated(self%lines)) deallocate(self%lines)
      call read_file(path, self%lines, error)
      if (allocated(error)) return
      self%length = len(self%lines)
      if (.not. starts_with(self%lines, heading // new_line("a"))) then
         call fatal(error, path // " is no checkpoint of this version of the program", status_file)
         return
      end if
      last = checksum_line("")
      place = self%length - len(last)
      if (place > 0) then
         if (self%lines(place + 1:) == checksum_line(self%lines(:place))) return
      end if
      call fatal(error, path // " is damaged", status_file)
   end subroutine load

   !> The last line of a file.
   function checksum_line(lines) result(line)
      !> All lines before.
      character(len=*), intent(in) :: lines
      character(len=:), allocatable :: line
      character(len=16) :: digits

      write(digits, "(z16.16)") checksum(0_i8, lines)
      line = "checksum " // digits // new_line("a")
   end function checksum_line

end module contensou_files_checkpoint
