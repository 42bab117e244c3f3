!> C interface of the kernels on arrays; include/contensou.h documents it.
module contensou_capi_arrays
   use, intrinsic :: ieee_arithmetic, only : ieee_quiet_nan, ieee_value
   use, intrinsic :: iso_c_binding, only : c_associated, c_double, c_f_pointer, c_int, c_intptr_t, &
      c_null_ptr, c_ptr, c_ptrdiff_t
   use contensou_base_kinds, only : wp
   use contensou_capi_kernels, only : bad_argument, friction_handle_type, hertz, law_of, ok, &
      rub, vary_rub
   use contensou_contact_spot, only : elliptic_shape
   use contensou_contact_tangential_stiffness, only : tangential_stiffness
   use contensou_special_elliptic, only : complete_elliptic
   implicit none(type, external)
   private

   public :: contensou_elliptic_array, contensou_hertz_array, contensou_friction_wrench_array
   public :: contensou_friction_jacobian_array, contensou_tangential_stiffness_array
   public :: column_type, take_inputs, take_columns, row_of, put_at

   !> Numbers of an array of C.
   type :: column_type
      real(c_double), pointer :: x(:) => null()
      !> Place of the first one in `x`.
      integer(c_ptrdiff_t) :: first = 1
      !> Numbers from one element to the next.
      integer(c_ptrdiff_t) :: stride = 1
   end type column_type

contains

   !> Complete elliptic integrals.
   function contensou_elliptic_array(n, inputs, strides, outputs) result(status) bind(c)
      !> Numbers, >= 0.
      integer(c_ptrdiff_t), intent(in), value :: n
      !> Complement c1 = 1 - c of the parameter [-], in [0, 1].
      type(c_ptr), intent(in), value :: inputs
      type(c_ptr), intent(in), value :: strides
      !> K and E [-], side by side; NaN outside of the domain.
      type(c_ptr), intent(in), value :: outputs
      integer(c_int) :: status
      type(column_type) :: from(1), to(2)
      integer(c_ptrdiff_t) :: i

      call take_inputs(n, inputs, strides, from, status)
      if (status == ok) call take_columns(n, outputs, c_null_ptr, to, status)
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
      type(c_ptr), intent(in), value :: inputs
      type(c_ptr), intent(in), value :: strides
      !> a [m], b [m], N [N], p0 [Pa], side by side; NaN outside of the domain.
      type(c_ptr), intent(in), value :: outputs
      integer(c_int) :: status, is_there
      type(column_type) :: from(4), to(4)
      real(wp) :: spot(4)
      integer(c_ptrdiff_t) :: i

      call take_inputs(n, inputs, strides, from, status)
      if (status == ok) call take_columns(n, outputs, c_null_ptr, to, status)
      if (status /= ok) return
      do i = 0, n - 1
         call hertz(at(from(1), i), at(from(2), i), at(from(3), i), at(from(4), i), spot, is_there)
         if (is_there /= ok) spot = ieee_value(1.0_wp, ieee_quiet_nan)
         call put_at(to, i, spot)
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
      type(c_ptr), intent(in), value :: inputs
      type(c_ptr), intent(in), value :: strides
      !> Of each spot Fx [N], Fy [N], Tz [N m]; NaN outside of the domain.
      type(c_ptr), intent(in), value :: wrenches
      integer(c_int) :: status, is_there
      type(friction_handle_type), pointer :: friction
      type(column_type) :: from(6)
      real(c_double), pointer :: wrench(:, :)
      integer(c_ptrdiff_t) :: i

      status = bad_argument
      friction => law_of(handle)
      if (.not. associated(friction)) return
      if (n > 0 .and. .not. c_associated(wrenches)) return
      call take_inputs(n, inputs, strides, from, status)
      if (status /= ok .or. n == 0) return
      call c_f_pointer(wrenches, wrench, [3_c_ptrdiff_t, n])
      do i = 0, n - 1
         call rub(friction, row_of(from, i), wrench(:, i + 1), is_there)
         if (is_there /= ok) wrench(:, i + 1) = ieee_value(1.0_c_double, ieee_quiet_nan)
      end do
   end function contensou_friction_wrench_array

   !> Friction wrenches of elliptic spots, and their derivatives.
   function contensou_friction_jacobian_array(handle, n, inputs, strides, wrenches, slopes) &
      result(status) bind(c)
      !> From `contensou_friction_new`.
      type(c_ptr), intent(in), value :: handle
      !> Spots, >= 0.
      integer(c_ptrdiff_t), intent(in), value :: n
      !> As of `contensou_friction_wrench_array`.
      type(c_ptr), intent(in), value :: inputs
      type(c_ptr), intent(in), value :: strides
      type(c_ptr), intent(in), value :: wrenches
      !> Of each spot 3 rows of 5 numbers; NaN outside of the domain.
      type(c_ptr), intent(in), value :: slopes
      integer(c_int) :: status, is_there
      type(friction_handle_type), pointer :: friction
      type(column_type) :: from(6)
      real(c_double), pointer :: wrench(:, :), slope(:, :, :)
      real(wp) :: by_column(3, 5)
      integer(c_ptrdiff_t) :: i

      status = bad_argument
      friction => law_of(handle)
      if (.not. associated(friction)) return
      if (n > 0 .and. .not. (c_associated(wrenches) .and. c_associated(slopes))) return
      call take_inputs(n, inputs, strides, from, status)
      if (status /= ok .or. n == 0) return
      call c_f_pointer(wrenches, wrench, [3_c_ptrdiff_t, n])
      call c_f_pointer(slopes, slope, [5_c_ptrdiff_t, 3_c_ptrdiff_t, n])
      do i = 0, n - 1
         call vary_rub(friction, row_of(from, i), wrench(:, i + 1), by_column, is_there)
         slope(:, :, i + 1) = transpose(by_column)
         if (is_there == ok) cycle
         wrench(:, i + 1) = ieee_value(1.0_c_double, ieee_quiet_nan)
         slope(:, :, i + 1) = ieee_value(1.0_c_double, ieee_quiet_nan)
      end do
   end function contensou_friction_jacobian_array

   !> Tangential and torsional stiffness of spots on which nothing slips.
   function contensou_tangential_stiffness_array(n, inputs, strides, outputs) result(status) bind(c)
      !> Spots, >= 0.
      integer(c_ptrdiff_t), intent(in), value :: n
      !> a [m], b [m], G [Pa], nu [-].
      type(c_ptr), intent(in), value :: inputs
      type(c_ptr), intent(in), value :: strides
      !> k_x, k_y [N/m], k_T [N m], side by side; NaN outside of the domain.
      type(c_ptr), intent(in), value :: outputs
      integer(c_int) :: status
      type(column_type) :: from(4), to(3)
      real(wp) :: stiffness(3), a, b
      integer(c_ptrdiff_t) :: i

      call take_inputs(n, inputs, strides, from, status)
      if (status == ok) call take_columns(n, outputs, c_null_ptr, to, status)
      if (status /= ok) return
      do i = 0, n - 1
         a = at(from(1), i)
         b = at(from(2), i)
         stiffness = ieee_value(1.0_wp, ieee_quiet_nan)
         if (b > 0.0_wp .and. b <= a) call tangential_stiffness(elliptic_shape(b/a), a, &
            at(from(3), i), at(from(4), i), stiffness)
         call put_at(to, i, stiffness)
      end do
   end function contensou_tangential_stiffness_array

   !> Take arrays of n numbers that are there, with their strides.
   subroutine take_inputs(n, places, strides, columns, status)
      integer(c_ptrdiff_t), intent(in) :: n
      !> Addresses, as many as there are columns.
      type(c_ptr), intent(in), value :: places
      type(c_ptr), intent(in), value :: strides
      type(column_type), intent(out) :: columns(:)
      integer(c_int), intent(out) :: status

      status = bad_argument
      if (n > 0 .and. .not. c_associated(strides)) return
      call take_columns(n, places, strides, columns, status)
   end subroutine take_inputs

   !> Take arrays of n numbers.
   subroutine take_columns(n, places, strides, columns, status)
      integer(c_ptrdiff_t), intent(in) :: n
      !> Addresses, as many as there are columns.
      type(c_ptr), intent(in), value :: places
      !> From element to element, 0 repeats one and a negative one goes back; null for side by side.
      type(c_ptr), intent(in), value :: strides
      type(column_type), intent(out) :: columns(:)
      !> `bad_argument` if one is missing.
      integer(c_int), intent(out) :: status
      type(c_ptr), pointer :: list(:)
      integer(c_ptrdiff_t), pointer :: steps(:)
      integer(c_ptrdiff_t) :: reach
      integer :: k

      status = bad_argument
      if (n < 0) return
      if (n > 0) then
         if (.not. c_associated(places)) return
         call c_f_pointer(places, list, [size(columns)])
         if (c_associated(strides)) call c_f_pointer(strides, steps, [size(columns)])
         do k = 1, size(columns)
            if (.not. c_associated(list(k))) return
            if (c_associated(strides)) columns(k)%stride = steps(k)
            reach = (n - 1)*columns(k)%stride
            columns(k)%first = 1 + max(-reach, 0_c_ptrdiff_t)
            call c_f_pointer(lowest(list(k), min(reach, 0_c_ptrdiff_t)), columns(k)%x, &
               [1 + abs(reach)])
         end do
      end if
      status = ok
   end subroutine take_columns

   !> Where an array begins in memory.
   pure function lowest(place, offset) result(address)
      !> Its first element.
      type(c_ptr), intent(in) :: place
      !> Numbers from there to the beginning.
      integer(c_ptrdiff_t), intent(in) :: offset
      type(c_ptr) :: address

      address = transfer(transfer(place, 0_c_intptr_t) + offset*(storage_size(1.0_c_double)/8), &
         c_null_ptr)
   end function lowest

   !> Element i, from 0.
   pure function at(column, i) result(x)
      type(column_type), intent(in) :: column
      integer(c_ptrdiff_t), intent(in) :: i
      real(c_double) :: x

      x = column%x(column%first + i*column%stride)
   end function at

   !> Element i, from 0, of six arrays.
   pure function row_of(columns, i) result(x)
      type(column_type), intent(in) :: columns(6)
      integer(c_ptrdiff_t), intent(in) :: i
      real(c_double) :: x(6)
      integer :: k

      do k = 1, 6
         x(k) = at(columns(k), i)
      end do
   end function row_of

   !> Set element i, from 0, of arrays.
   subroutine put_at(columns, i, x)
      type(column_type), intent(in) :: columns(:)
      integer(c_ptrdiff_t), intent(in) :: i
      !> A number for each of them.
      real(wp), intent(in) :: x(:)
      integer :: k

      do k = 1, size(x)
         columns(k)%x(i + 1) = x(k)
      end do
   end subroutine put_at

end module contensou_capi_arrays
