!> C interface of the quantities of a simulation; include/contensou.h documents it.
module contensou_capi_quantities
   use, intrinsic :: iso_c_binding, only : c_associated, c_f_pointer, c_int, c_ptr
   use contensou_base_errors, only : error_type, fatal, status_usage
   use contensou_base_numbers, only : to_text
   use contensou_base_text, only : quote
   use contensou_base_text_lock, only : lock_texts, unlock_texts
   use contensou_capi_handles, only : handle_type, no_simulation, status_of
   use contensou_capi_kernels, only : bad_argument, ok, put
   use contensou_capi_table, only : address_of, lives, of_simulation
   use contensou_capi_texts, only : get_text
   use contensou_study_quantity, only : of_none
   implicit none(type, external)
   private

   public :: contensou_simulation_quantities, contensou_simulation_quantity
   public :: contensou_simulation_values

   !> A quantity as C sees it.
   type, bind(c) :: c_quantity_type
      type(c_ptr) :: name
      type(c_ptr) :: units
      type(c_ptr) :: description
      integer(c_int) :: size
      integer(c_int) :: rank
      integer(c_int) :: shape(2)
      type(c_ptr) :: dims(2)
   end type c_quantity_type

contains

   !> Number of quantities.
   function contensou_simulation_quantities(handle) result(n) bind(c)
      type(c_ptr), intent(in), value :: handle
      integer(c_int) :: n
      type(handle_type), pointer :: self

      n = 0
      if (.not. lives(handle, of_simulation)) return
      call c_f_pointer(address_of(handle, of_simulation), self)
      n = size(self%quantities)
   end function contensou_simulation_quantities

   !> Name, unit and extents of a quantity.
   function contensou_simulation_quantity(handle, i, quantity) result(status) bind(c)
      type(c_ptr), intent(in), value :: handle
      !> Its number, from 0.
      integer(c_int), intent(in), value :: i
      !> Where to put it.
      type(c_ptr), intent(in), value :: quantity
      integer(c_int) :: status
      type(handle_type), pointer :: self
      type(c_quantity_type), pointer :: out

      status = bad_argument
      if (i < 0 .or. i >= contensou_simulation_quantities(handle)) return
      if (.not. c_associated(quantity)) return
      call c_f_pointer(address_of(handle, of_simulation), self)
      call c_f_pointer(quantity, out)
      associate (texts => self%quantities(i + 1), row => self%course%guide%row)
         out%name = texts%name%address()
         out%units = texts%units%address()
         out%description = texts%description%address()
         out%dims = [texts%dims(1)%address(), texts%dims(2)%address()]
         associate (width => row%width(texts%row), &
            components => row%quantities(texts%row)%components)
            out%size = width
            out%shape = [width/components, components]
            out%rank = 2
            if (components == 1) out%rank = 1
            if (row%quantities(texts%row)%of == of_none) out%rank = 0
         end associate
      end associate
      status = ok
   end function contensou_simulation_quantity

   !> Values of a quantity at the present.
   function contensou_simulation_values(handle, name, values, n, error_out) result(status) bind(c)
      type(c_ptr), intent(in), value :: handle
      type(c_ptr), intent(in), value :: name
      !> Where to put them.
      type(c_ptr), intent(in), value :: values
      !> Their number.
      integer(c_int), intent(in), value :: n
      !> Where to put an error; null if it is not wanted.
      type(c_ptr), intent(in), value :: error_out
      integer(c_int) :: status
      type(handle_type), pointer :: self
      type(error_type), allocatable :: error
      character(len=:), allocatable :: text

      if (.not. lives(handle, of_simulation)) then
         call fatal(error, no_simulation, status_usage)
      else
         call c_f_pointer(address_of(handle, of_simulation), self)
         call get_text(name, text)
         call take_values(self, text, values, int(n), error)
      end if
      status = status_of(error, error_out)
   end function contensou_simulation_values

   !> Put the values of a quantity at a place.
   subroutine take_values(self, name, place, n, error)
      type(handle_type), intent(inout), target :: self
      !> Name of the quantity.
      character(len=*), intent(in) :: name
      type(c_ptr), intent(in), value :: place
      !> Their number as the caller has it.
      integer, intent(in) :: n
      type(error_type), allocatable, intent(out) :: error
      integer :: i

      associate (row => self%course%guide%row)
         do i = 1, size(row%quantities)
            if (row%has(i) .and. row%quantities(i)%name == name) exit
         end do
         if (i <= size(row%quantities)) then
            if (n == row%width(i) .and. c_associated(place)) then
               call self%course%take_values(error)
               if (.not. allocated(error)) call put( &
                  row%values(row%start(i) + 1:row%start(i) + row%width(i)), place)
               return
            end if
         end if
         call lock_texts()
         if (i > size(row%quantities)) then
            call fatal(error, "there is no quantity " // quote(name) // " in this scene", &
               status_usage)
         else if (n /= row%width(i)) then
            call fatal(error, quote(name) // " has " // to_text(row%width(i)) // &
               " values, not " // to_text(n), status_usage)
         else
            call fatal(error, "there is nowhere to put the values", status_usage)
         end if
         call unlock_texts()
      end associate
   end subroutine take_values

end module contensou_capi_quantities
