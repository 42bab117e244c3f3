!> Handles that C programs hold: numbers that stand for objects, for none once they are released.
module contensou_capi_table
   use, intrinsic :: iso_c_binding, only : c_associated, c_int, c_ptr
   implicit none(type, external)
   private

   public :: of_error, of_simulation, of_snapshot, of_friction, of_tangential
   public :: address_of, drop_handle, lives, new_handle

   !> Kinds of handles.
   integer(c_int), parameter :: of_error = 1, of_simulation = 2, of_snapshot = 3, &
      of_friction = 4, of_tangential = 5

   interface
      !> A handle for an object.
      function new_handle(address, kind) result(handle) bind(c, name="contensou_handle_new")
         import :: c_int, c_ptr
         implicit none(type, external)
         type(c_ptr), intent(in), value :: address
         integer(c_int), intent(in), value :: kind
         type(c_ptr) :: handle
      end function new_handle

      !> The object of a handle; null if it is none of this kind, or was released.
      function address_of(handle, kind) result(address) bind(c, name="contensou_handle_address")
         import :: c_int, c_ptr
         implicit none(type, external)
         type(c_ptr), intent(in), value :: handle
         integer(c_int), intent(in), value :: kind
         type(c_ptr) :: address
      end function address_of

      !> Release a handle; its object stays.
      subroutine drop_handle(handle, kind) bind(c, name="contensou_handle_drop")
         import :: c_int, c_ptr
         implicit none(type, external)
         type(c_ptr), intent(in), value :: handle
         integer(c_int), intent(in), value :: kind
      end subroutine drop_handle
   end interface

contains

   !> Whether a handle stands for an object.
   logical function lives(handle, kind)
      type(c_ptr), intent(in) :: handle
      integer(c_int), intent(in) :: kind

      lives = c_associated(address_of(handle, kind))
   end function lives

end module contensou_capi_table
