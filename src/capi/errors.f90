!> Errors as C programs get them; include/contensou.h documents them.
module contensou_capi_errors
   use, intrinsic :: iso_c_binding, only : c_associated, c_f_pointer, c_int, c_loc, c_null_ptr, &
      c_ptr
   use contensou_base_diagnostics, only : diagnostics_type, origin_type, source_type
   use contensou_base_errors, only : error_type
   use contensou_capi_table, only : address_of, drop_handle, lives, new_handle, of_error
   use contensou_capi_texts, only : c_text_type
   implicit none(type, external)
   private

   public :: contensou_error_message, contensou_error_status, contensou_error_free
   public :: contensou_error_mistakes, contensou_error_mistake
   public :: hand_over

   !> A mistake with its place.
   type :: placed_type
      type(origin_type) :: origin
      !> Name of the file or setting, what is wrong, and what would be right.
      type(c_text_type) :: source, message, expected
   end type placed_type

   !> What a handle of an error points to: its texts end with a null.
   type :: error_handle_type
      type(c_text_type) :: text
      !> Exit status that belongs to it.
      integer(c_int) :: status = 0
      !> Mistakes of a scene.
      type(placed_type), allocatable :: mistakes(:)
   end type error_handle_type

   !> A mistake as C sees it.
   type, bind(c) :: mistake_type
      type(c_ptr) :: source
      integer(c_int) :: line
      integer(c_int) :: column
      integer(c_int) :: length
      type(c_ptr) :: message
      type(c_ptr) :: expected
   end type mistake_type

contains

   !> Text of an error, ended by a zero byte; empty for none.
   function contensou_error_message(handle) result(text) bind(c)
      !> The error; null for none.
      type(c_ptr), intent(in), value :: handle
      type(c_ptr) :: text
      type(error_handle_type), pointer :: error
      type(c_text_type) :: nothing

      if (lives(handle, of_error)) then
         call c_f_pointer(address_of(handle, of_error), error)
         text = error%text%address()
      else
         text = nothing%address()
      end if
   end function contensou_error_message

   !> Exit status of a program that gives up because of an error; 0 for none.
   function contensou_error_status(handle) result(status) bind(c)
      !> The error; null for none.
      type(c_ptr), intent(in), value :: handle
      integer(c_int) :: status
      type(error_handle_type), pointer :: error

      status = 0
      if (.not. lives(handle, of_error)) return
      call c_f_pointer(address_of(handle, of_error), error)
      status = error%status
   end function contensou_error_status

   !> Number of mistakes of a scene that an error tells of.
   function contensou_error_mistakes(handle) result(n) bind(c)
      !> The error; null for none.
      type(c_ptr), intent(in), value :: handle
      integer(c_int) :: n
      type(error_handle_type), pointer :: error

      n = 0
      if (.not. lives(handle, of_error)) return
      call c_f_pointer(address_of(handle, of_error), error)
      if (allocated(error%mistakes)) n = size(error%mistakes)
   end function contensou_error_mistakes

   !> One of them; 0 if there is one.
   function contensou_error_mistake(handle, i, mistake) result(status) bind(c)
      !> The error; null for none.
      type(c_ptr), intent(in), value :: handle
      !> Its number, from 0.
      integer(c_int), intent(in), value :: i
      !> Where to put it.
      type(c_ptr), intent(in), value :: mistake
      integer(c_int) :: status
      type(error_handle_type), pointer :: error
      type(mistake_type), pointer :: out

      status = 1
      if (i < 0 .or. i >= contensou_error_mistakes(handle)) return
      if (.not. c_associated(mistake)) return
      call c_f_pointer(address_of(handle, of_error), error)
      call c_f_pointer(mistake, out)
      associate (placed => error%mistakes(i + 1))
         out%source = placed%source%address()
         out%line = placed%origin%line
         out%column = placed%origin%column
         out%length = placed%origin%length
         out%message = placed%message%address()
         out%expected = placed%expected%address()
      end associate
      status = 0
   end function contensou_error_mistake

   !> Release an error; null is admitted.
   subroutine contensou_error_free(handle) bind(c)
      type(c_ptr), intent(in), value :: handle
      type(error_handle_type), pointer :: error

      if (.not. lives(handle, of_error)) return
      call c_f_pointer(address_of(handle, of_error), error)
      call drop_handle(handle, of_error)
      deallocate(error)
   end subroutine contensou_error_free

   !> Put an error, or null, where C wants it.
   subroutine hand_over(error, place, diagnostics, sources)
      type(error_type), allocatable, intent(in) :: error
      !> Null if it is not wanted.
      type(c_ptr), intent(in), value :: place
      !> The mistakes that it tells of.
      type(diagnostics_type), intent(in), optional :: diagnostics
      !> The sources of these.
      type(source_type), intent(in), optional :: sources(:)
      type(error_handle_type), pointer :: handle
      type(c_ptr), pointer :: out
      integer :: i

      if (.not. c_associated(place)) return
      call c_f_pointer(place, out)
      out = c_null_ptr
      if (.not. allocated(error)) return
      allocate(handle)
      handle%status = int(error%status, c_int)
      call handle%text%set(error%message)
      if (present(diagnostics) .and. present(sources)) then
         allocate(handle%mistakes(diagnostics%kept()))
         do i = 1, size(handle%mistakes)
            associate (placed => handle%mistakes(i))
               placed%origin = diagnostics%origin(i)
               call placed%message%set(diagnostics%message(i))
               call placed%expected%set(diagnostics%expected(i))
               if (placed%origin%source < 1 .or. placed%origin%source > size(sources)) cycle
               call placed%source%set(sources(placed%origin%source)%name)
            end associate
         end do
      end if
      out = new_handle(c_loc(handle), of_error)
   end subroutine hand_over

end module contensou_capi_errors
