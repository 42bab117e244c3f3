!> C interface of the kernels on arrays; include/contensou.h documents it.
module contensou_capi_arrays
   use, intrinsic :: ieee_arithmetic, only : ieee_quiet_nan, ieee_value
   use, intrinsic :: iso_c_binding, only : c_associated, c_double, c_f_pointer, c_int, c_ptr, &
      c_ptrdiff_t
   use contensou_capi_kernels, only : bad_argument, contensou_friction_wrench, contensou_hertz, ok
   use contensou_special_elliptic, only : complete_elliptic
   implicit none(type, external)
   private

   public :: contensou_elliptic_array, contensou_hertz_array, contensou_friction_wrench_array

   !> Numbers of an array of C.
   type :: column_type
      real(c_double), pointer :: x(:) => null()
      !> Numbers from one element to the next.
      integer(c_ptrdiff_t) :: stride = 1
   end type column_type

   integer(c_ptrdiff_t), parameter :: side_by_side(4) = 1

contains

   !> Complete elliptic integrals.
   function contensou_elliptic_array(n, inputs, strides, outputs) result(status) bind(c)
      !> Numbers, >= 0.
      integer(c_ptrdiff_t), intent(in), value :: n
      !> Complement c1 = 1 - c of the parameter [-], in [0, 1].
      type(c_ptr), intent(in) :: inputs(1)
      integer(c_ptrdiff_t), intent(in) :: strides(1)
      !> K and E [-], side by side; NaN outside of the domain.
      type(c_ptr), intent(in) :: outputs(2)
      integer(c_int) :: status
      type(column_type) :: from(1), to(2)
      integer(c_ptrdiff_t) :: i

      call take(n, inputs, strides, from, status)
      if (status == ok) call take(n, outputs, side_by_side(:2), to, status)
      if (status /= ok) return
      do i = 0, n - 1
         call complete_elliptic(at(from(1), i), to(1)%x(i + 1), to(2)%x(i + 1))
      end do
   end function contensou_elliptic_array

   !> Hertz contacts.
   function contensou_hertz_array(n, inputs, strides, outputs) result(status) bind(c)
      !> Contacts, >= 0.
      integer(c_ptrdiff_t), intent(in), value :: n
      !> A [1/m], B [1/m], E* [Pa], d [m], as of `contensou_hertz`.
      type(c_ptr), intent(in) :: inputs(4)
      integer(c_ptrdiff_t), intent(in) :: strides(4)
      !> a [m], b [m], N [N], p0 [Pa], side by side; NaN outside of the domain.
      type(c_ptr), intent(in) :: outputs(4)
      integer(c_int) :: status
      type(column_type) :: from(4), to(4)
      real(c_double) :: nan
      integer(c_ptrdiff_t) :: i

      call take(n, inputs, strides, from, status)
      if (status == ok) call take(n, outputs, side_by_side, to, status)
      if (status /= ok) return
      nan = ieee_value(nan, ieee_quiet_nan)
      do i = 0, n - 1
         if (contensou_hertz(at(from(1), i), at(from(2), i), at(from(3), i), at(from(4), i), &
            to(1)%x(i + 1), to(2)%x(i + 1), to(3)%x(i + 1), to(4)%x(i + 1)) == ok) cycle
         to(1)%x(i + 1) = nan
         to(2)%x(i + 1) = nan
         to(3)%x(i + 1) = nan
         to(4)%x(i + 1) = nan
      end do
   end function contensou_hertz_array

   !> Friction wrenches of elliptic spots.
   function contensou_friction_wrench_array(handle, n, inputs, strides, wrenches) &
      result(status) bind(c)
      !> From `contensou_friction_new`.
      type(c_ptr), intent(in), value :: handle
      !> Spots, >= 0.
      integer(c_ptrdiff_t), intent(in), value :: n
      !> N [N], a [m], b [m], vx [m/s], vy [m/s], spin [rad/s], as of `contensou_friction_wrench`.
      type(c_ptr), intent(in) :: inputs(6)
      integer(c_ptrdiff_t), intent(in) :: strides(6)
      !> Of each spot Fx [N], Fy [N], Tz [N m]; NaN outside of the domain.
      type(c_ptr), intent(in), value :: wrenches
      integer(c_int) :: status
      type(column_type) :: from(6)
      real(c_double), pointer :: wrench(:, :)
      integer(c_ptrdiff_t) :: i

      status = bad_argument
      if (.not. c_associated(handle)) return
      if (n > 0 .and. .not. c_associated(wrenches)) return
      call take(n, inputs, strides, from, status)
      if (status /= ok .or. n == 0) return
      call c_f_pointer(wrenches, wrench, [3_c_ptrdiff_t, n])
      do i = 0, n - 1
         if (contensou_friction_wrench(handle, at(from(1), i), at(from(2), i), at(from(3), i), &
            at(from(4), i), at(from(5), i), at(from(6), i), wrench(:, i + 1)) == ok) cycle
         wrench(:, i + 1) = ieee_value(1.0_c_double, ieee_quiet_nan)
      end do
   end function contensou_friction_wrench_array

   !> Take arrays of n numbers.
   subroutine take(n, places, strides, columns, status)
      integer(c_ptrdiff_t), intent(in) :: n
      type(c_ptr), intent(in) :: places(:)
      !> 0 repeats one number.
      integer(c_ptrdiff_t), intent(in) :: strides(:)
      type(column_type), intent(out) :: columns(:)
      !> `bad_argument` if one is missing or strides go back.
      integer(c_int), intent(out) :: status
      integer :: k

      status = bad_argument
      if (n < 0 .or. any(strides < 0)) return
      if (n > 0) then
         do k = 1, size(places)
            if (.not. c_associated(places(k))) return
            call c_f_pointer(places(k), columns(k)%x, [1 + (n - 1)*strides(k)])
            columns(k)%stride = strides(k)
         end do
      end if
      status = ok
   end subroutine take

   !> Element i, from 0.
   pure function at(column, i) result(x)
      type(column_type), intent(in) :: column
      integer(c_ptrdiff_t), intent(in) :: i
      real(c_double) :: x

      x = column%x(1 + i*column%stride)
   end function at

end module contensou_capi_arrays
