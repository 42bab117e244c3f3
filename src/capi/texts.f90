!> Texts between C and Fortran.
module contensou_capi_texts
   use, intrinsic :: iso_c_binding, only : c_associated, c_char, c_f_pointer, c_int, c_loc, &
      c_null_char, c_ptr
   use contensou_base_text, only : string_type
   implicit none(type, external)
   private

   public :: c_text_type, get_text, get_texts

   !> A text as C has it.
   type :: c_text_type
      !> Ended by a zero byte.
      character(len=1, kind=c_char), allocatable :: bytes(:)
   contains
      procedure :: set
      procedure :: address
   end type c_text_type

   !> No text.
   character(len=1, kind=c_char), target :: nothing(1) = [c_null_char]

contains

   !> Take a text.
   subroutine set(self, text)
      class(c_text_type), intent(inout) :: self
      character(len=*), intent(in) :: text
      integer :: i

      if (allocated(self%bytes)) deallocate(self%bytes)
      allocate(self%bytes(len(text) + 1))
      do i = 1, len(text)
         self%bytes(i) = text(i:i)
      end do
      self%bytes(len(text) + 1) = c_null_char
   end subroutine set

   !> Its address, as long as it is not set anew; that of an empty text if it is not set.
   function address(self) result(place)
      class(c_text_type), intent(in), target :: self
      type(c_ptr) :: place

      place = c_loc(nothing)
      if (allocated(self%bytes)) place = c_loc(self%bytes)
   end function address

   !> A C string; null is an empty one.
   subroutine get_text(place, text)
      type(c_ptr), intent(in), value :: place
      character(len=:), allocatable, intent(out) :: text
      character(len=1, kind=c_char), pointer :: bytes(:)
      integer :: i, n

      n = 0
      if (c_associated(place)) then
         do
            call c_f_pointer(place, bytes, [n + 1])
            if (bytes(n + 1) == c_null_char) exit
            n = n + 1
         end do
      end if
      allocate(character(len=n) :: text)
      do i = 1, n
         text(i:i) = bytes(i)
      end do
   end subroutine get_text

   !> An array of C strings; null is an empty one.
   subroutine get_texts(place, n, list)
      type(c_ptr), intent(in), value :: place
      integer(c_int), intent(in) :: n
      type(string_type), allocatable, intent(out) :: list(:)
      type(c_ptr), pointer :: texts(:)
      integer :: i

      if (n <= 0 .or. .not. c_associated(place)) then
         allocate(list(0))
         return
      end if
      call c_f_pointer(place, texts, [n])
      allocate(list(n))
      do i = 1, n
         call get_text(texts(i), list(i)%s)
      end do
   end subroutine get_texts

end module contensou_capi_texts
