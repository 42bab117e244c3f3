!> The results of a comparison as lines of text: a table of objects that differ, and messages about
!> what could not be compared.
module contensou_compare_listing
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite
   use contensou_base_kinds, only : i8, wp
   use contensou_base_numbers, only : power_text, to_text
   use contensou_base_text, only : right
   use contensou_compare_places, only : printable
   implicit none(type, external)
   private

   public :: comparison_output_type, listing_type, count_of, brief, numbers_text, side_names

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
         class(comparison_output_type), intent(inout) :: self
         character(len=*), intent(in) :: text
      end subroutine take_text
   end interface

   !> A listing that is being written.
   type :: listing_type
      !> Where it goes.
      class(comparison_output_type), pointer :: output => null()
      !> Messages about what could not be compared.
      integer :: n_trouble = 0
      !> Whether the head of the table is written.
      logical :: has_head = .false.
      !> The last of these messages.
      character(len=:), allocatable, private :: last_trouble
   contains
      procedure :: trouble
      procedure :: row
      procedure :: detail
   end type listing_type

   !> The names of the files in the results.
   character(len=1), parameter :: side_names(2) = ["A", "B"]

   !> Messages about trouble that are written.
   integer, parameter :: max_trouble = 50

   !> Width of the column of names.
   integer, parameter :: name_width = 34

   !> Lines of differences that belong to a data set are indented.
   character(len=*), parameter :: indent = "   "

contains

   !> Note that something could not be compared.
   subroutine trouble(self, message)
      class(listing_type), intent(inout) :: self
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
   end subroutine trouble

   !> Write a line about an object, under the head of the table.
   subroutine row(self, path, text)
      class(listing_type), intent(inout) :: self
      !> Path of the object, or of the object and its attribute.
      character(len=*), intent(in) :: path
      !> What is said of it; empty for nothing as yet.
      character(len=*), intent(in) :: text
      character(len=:), allocatable :: name

      if (.not. self%has_head) call self%output%line(column("", name_width) // &
         "     max |A - B|   relative    beyond        of")
      self%has_head = .true.
      name = printable(path)
      if (len(name) > name_width .and. text /= "") then
         call self%output%line(name)
         name = ""
      end if
      if (text == "") then
         call self%output%line(name)
      else
         call self%output%line(column(name, name_width) // "  " // text)
      end if
   end subroutine row

   !> Write a line that goes on about an object.
   subroutine detail(self, label, text)
      class(listing_type), intent(inout) :: self
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

   !> A number of things.
   pure function count_of(n, thing) result(text)
      integer, intent(in) :: n
      !> One of them.
      character(len=*), intent(in) :: thing
      !> Such as "2 data sets".
      character(len=:), allocatable :: text

      text = to_text(n) // " " // thing
      if (n /= 1) text = text // "s"
   end function count_of

   !> A difference in four digits.
   pure function brief(x) result(text)
      !> Difference, not negative.
      real(wp), intent(in) :: x
      character(len=:), allocatable :: text

      text = power_text(x, 4)
      if (.not. ieee_is_finite(x)) return
      if (x <= 0.0_wp) text = "0"
   end function brief

   !> The columns of numbers of the table.
   pure function numbers_text(largest, relative, n_beyond, n) result(text)
      !> Largest absolute difference, as text.
      character(len=*), intent(in) :: largest
      !> Largest relative difference, as text.
      character(len=*), intent(in) :: relative
      !> Values beyond the tolerance.
      integer(i8), intent(in) :: n_beyond
      !> Values compared.
      integer(i8), intent(in) :: n
      character(len=:), allocatable :: text

      text = right(largest, 14) // right(relative, 11) // right(to_text(n_beyond), 10) // &
         right(to_text(n), 10)
   end function numbers_text

end module contensou_compare_listing
