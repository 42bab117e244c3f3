!> C interface of tangential elasticity with memory; include/contensou.h documents it.
module contensou_capi_tangential
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite, ieee_quiet_nan, ieee_value
   use, intrinsic :: iso_c_binding, only : c_double, c_f_pointer, c_int, c_loc, c_null_ptr, &
      c_ptr, c_ptrdiff_t
   use contensou_base_kinds, only : wp
   use contensou_capi_arrays, only : column_type, put_at, row_of, take_columns, take_inputs
   use contensou_capi_kernels, only : bad_argument, ok
   use contensou_capi_table, only : address_of, drop_handle, lives, new_handle, of_tangential
   use contensou_contact_spot, only : circular_shape, elliptic_shape
   use contensou_contact_tangential_shells, only : most_layers, shells_type, single_spring, &
      spring_spot_type
   implicit none(type, external)
   private

   public :: contensou_tangential_new, contensou_tangential_advance_array, contensou_tangential_free

   !> A spot with what it remembers.
   type :: tangential_handle_type
      type(shells_type) :: shells
      !> Shear modulus [Pa] and Poisson's ratio of both bodies together.
      real(wp) :: modulus = 0.0_wp, poisson = 0.0_wp
   end type tangential_handle_type

contains

   !> A spot that remembers nothing yet; null if an argument is outside its domain.
   function contensou_tangential_new(modulus, poisson, layers) result(handle) bind(c)
      !> Shear modulus G of both bodies together [Pa], > 0.
      real(c_double), intent(in), value :: modulus
      !> Poisson's ratio of both together, from -1 to 1/2.
      real(c_double), intent(in), value :: poisson
      !> Layers, from 1 to 128; 0 for one spring, -1 for as many as a scene has unless told.
      integer(c_int), intent(in), value :: layers
      type(c_ptr) :: handle
      type(tangential_handle_type), pointer :: self

      handle = c_null_ptr
      if (.not. (ieee_is_finite(modulus) .and. ieee_is_finite(poisson))) return
      if (modulus <= 0.0_c_double .or. poisson < -1.0_c_double .or. poisson > 0.5_c_double) return
      if (layers < -1 .or. layers > most_layers) return
      allocate(self)
      self%modulus = modulus
      self%poisson = poisson
      if (layers > 0) then
         call self%shells%begin(int(layers))
      else if (layers < 0) then
         call self%shells%begin()
      else
         self%shells = single_spring()
      end if
      handle = new_handle(c_loc(self), of_tangential)
   end function contensou_tangential_new

   !> Steps of a spot, one after the other.
   function contensou_tangential_advance_array(handle, n, inputs, strides, outputs) &
      result(status) bind(c)
      !> From `contensou_tangential_new`.
      type(c_ptr), intent(in), value :: handle
      !> Steps, >= 0.
      integer(c_ptrdiff_t), intent(in), value :: n
      !> Limit f N [N], a [m], b [m], shift along x and y [m], twist [rad].
      type(c_ptr), intent(in), value :: inputs
      type(c_ptr), intent(in), value :: strides
      !> Fx, Fy [N], Tz [N m], stored and lost energy [J], side by side; NaN outside of the domain.
      type(c_ptr), intent(in), value :: outputs
      integer(c_int) :: status
      type(tangential_handle_type), pointer :: self
      type(column_type) :: from(6), to(5)
      real(wp) :: y(5)
      integer(c_ptrdiff_t) :: i

      status = bad_argument
      if (.not. lives(handle, of_tangential)) return
      call take_inputs(n, inputs, strides, from, status)
      if (status == ok) call take_columns(n, outputs, c_null_ptr, to, status)
      if (status /= ok) return
      call c_f_pointer(address_of(handle, of_tangential), self)
      do i = 0, n - 1
         call step(self, row_of(from, i), y)
         call put_at(to, i, y)
      end do
   end function contensou_tangential_advance_array

   !> A step. One outside of the domain gives NaN and is not remembered.
   subroutine step(self, x, y)
      type(tangential_handle_type), intent(inout) :: self
      !> f N, a, b, shift along x and y, twist.
      real(wp), intent(in) :: x(6)
      !> Fx, Fy, Tz, stored and lost energy.
      real(wp), intent(out) :: y(5)
      type(spring_spot_type) :: spot
      real(wp) :: wrench(3), stored, lost

      y = ieee_value(1.0_wp, ieee_quiet_nan)
      if (.not. all(ieee_is_finite(x))) return
      if (x(1) < 0.0_wp) return
      ! A spot without load is none, and forgets.
      spot = spring_spot_type(circular_shape, 0.0_wp, 0.0_wp, [0.0_wp, 0.0_wp, 0.0_wp])
      if (x(1) > 0.0_wp) then
         if (x(3) <= 0.0_wp .or. x(3) > x(2)) return
         spot%a = x(2)
         spot%limit = x(1)
         if (x(3) < x(2)) spot%shape = elliptic_shape(x(3)/x(2))
         if (.not. ieee_is_finite(spot%shape%k)) return
         call spot%stiffen(self%modulus, self%poisson)
      end if
      call self%shells%advance(spot, x(4:6), wrench, stored, lost)
      y = [wrench, stored, lost]
   end subroutine step

   !> Release a spot; null is admitted.
   subroutine contensou_tangential_free(handle) bind(c)
      !> From `contensou_tangential_new`.
      type(c_ptr), intent(in), value :: handle
      type(tangential_handle_type), pointer :: self

      if (.not. lives(handle, of_tangential)) return
      call c_f_pointer(address_of(handle, of_tangential), self)
      call drop_handle(handle, of_tangential)
      deallocate(self)
   end subroutine contensou_tangential_free

end module contensou_capi_tangential
