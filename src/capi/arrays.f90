!> C interface of the kernels on arrays; include/contensou.h documents it.
module contensou_capi_arrays
   use, intrinsic :: ieee_arithmetic, only : ieee_quiet_nan, ieee_value
   use, intrinsic :: iso_c_binding, only : c_associated, c_double, c_f_pointer, c_int, c_intptr_t, &
      c_null_ptr, c_ptr, c_ptrdiff_t
   use contensou_base_kinds, only : wp
   use contensou_capi_kernels, only : bad_argument, friction_handle_type, law_of, ok, rub, &
      vary_rub
   use contensou_contact_hertz, only : hertz_contact, hertz_spot_type
   use contensou_contact_spot, only : elliptic_shape
   use contensou_contact_tangential_stiffness, only : tangential_stiffness
   use contensou_special_elliptic, only : complete_elliptic
   implicit none(type, external)
   private

   public :: contensou_elliptic_array, contensou_hertz_array, contensou_friction_wrench_array
   public :: contensou_friction_jacobian_array, contensou_tangential_stiffness_array
   public :: column_type, take_inputs, take_columns, row_of, put_at

   !> Numbers of an array of C.
   !>
   !> Where an element costs little, a loop takes them as explicit-shape arrays: from here their
   !> descriptors are loaded anew for each element.
   type :: column_type
      real(c_double), pointer, contiguous :: x(:) => null()
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

      call take_inputs(n, inputs, strides, from, status)
      if (status == ok) call take_columns(n, outputs, c_null_ptr, to, status)
      if (status /= ok .or. n == 0) return
      call integrate_all(n, from, from(1)%x, to(1)%x, to(2)%x)
   end function contensou_elliptic_array

   !> Complete elliptic integrals, one after the other.
   pure subroutine integrate_all(n, from, complements, k, e)
      integer(c_ptrdiff_t), intent(in) :: n
      !> Where the input lies.
      type(column_type), intent(in) :: from(1)
      real(c_double), intent(in) :: complements(*)
      real(c_double), intent(out) :: k(n), e(n)
      real(wp) :: complement
      integer(c_ptrdiff_t) :: first, stride, i

      first = from(1)%first
      stride = from(1)%stride
      do i = 0, n - 1
         ! A copy: the output may be where the input is.
         complement = complements(first + i*stride)
         call complete_elliptic(complement, k(i + 1), e(i + 1))
      end do
   end subroutine integrate_all

   !> Hertz contacts.
   function contensou_hertz_array(n, inputs, strides, outputs) result(status) bind(c)
      !> Contacts, >= 0.
      integer(c_ptrdiff_t), intent(in), value :: n
      !> A [1/m], B [1/m], E* [Pa], d [m], as of `contensou_hertz`.
      type(c_ptr), intent(in), value :: inputs
      type(c_ptr), intent(in), value :: strides
      !> a [m], b [m], N [N], p0 [Pa], side by side; NaN outside of the domain.
      type(c_ptr), intent(in), value :: outputs
      integer(c_int) :: status
      type(column_type) :: from(4), to(4)

      call take_inputs(n, inputs, strides, from, status)
      if (status == ok) call take_columns(n, outputs, c_null_ptr, to, status)
      if (status /= ok .or. n == 0) return
      call touch_all(n, from, from(1)%x, from(2)%x, from(3)%x, from(4)%x, &
         to(1)%x, to(2)%x, to(3)%x, to(4)%x)
   end function contensou_hertz_array

   !> Hertz contacts, one after the other.
   pure subroutine touch_all(n, from, curvature_a, curvature_b, modulus, approach, &
      a, b, force, pressure)
      integer(c_ptrdiff_t), intent(in) :: n
      !> Where the inputs lie.
      type(column_type), intent(in) :: from(4)
      real(c_double), intent(in) :: curvature_a(*), curvature_b(*), modulus(*), approach(*)
      real(c_double), intent(out) :: a(n), b(n), force(n), pressure(n)
      type(hertz_spot_type) :: spot
      integer(c_ptrdiff_t) :: first(4), stride(4), i

      first = from%first
      stride = from%stride
      do i = 0, n - 1
         call hertz_contact(curvature_a(first(1) + i*stride(1)), &
            curvature_b(first(2) + i*stride(2)), modulus(first(3) + i*stride(3)), &
            approach(first(4) + i*stride(4)), spot)
         a(i + 1) = spot%a
         b(i + 1) = spot%b
         force(i + 1) = spot%force
         pressure(i + 1) = spot%pressure
      end do
   end subroutine touch_all

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
      integer(c_int) :: status
      type(friction_handle_type), pointer :: friction
      type(column_type) :: from(6)
      real(c_double), pointer, contiguous :: wrench(:, :)

      status = bad_argument
      friction => law_of(handle)
      if (.not. associated(friction)) return
      if (n > 0 .and. .not. c_associated(wrenches)) return
      call take_inputs(n, inputs, strides, from, status)
      if (status /= ok .or. n == 0) return
      call c_f_pointer(wrenches, wrench, [3_c_ptrdiff_t, n])
      call rub_all(friction, n, from, from(1)%x, from(2)%x, from(3)%x, &
         from(4)%x, from(5)%x, from(6)%x, wrench)
   end function contensou_friction_wrench_array

   !> Friction wrenches, one after the other.
   subroutine rub_all(friction, n, from, load, a, b, vx, vy, spin, wrench)
      type(friction_handle_type), intent(in) :: friction
      integer(c_ptrdiff_t), intent(in) :: n
      !> Where the inputs lie.
      type(column_type), intent(in) :: from(6)
      real(c_double), intent(in) :: load(*), a(*), b(*), vx(*), vy(*), spin(*)
      real(c_double), intent(out) :: wrench(3, n)
      integer(c_int) :: is_there
      integer(c_ptrdiff_t) :: at(6), stride(6), i

      at = from%first
      stride = from%stride
      do i = 1, n
         call rub(friction, [load(at(1)), a(at(2)), b(at(3)), vx(at(4)), vy(at(5)), spin(at(6))], &
            wrench(:, i), is_there)
         if (is_there /= ok) wrench(:, i) = ieee_value(1.0_c_double, ieee_quiet_nan)
         at = at + stride
      end do
   end subroutine rub_all

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

      call take_inputs(n, inputs, strides, from, status)
      if (status == ok) call take_columns(n, outputs, c_null_ptr, to, status)
      if (status /= ok .or. n == 0) return
      call stiffen_all(n, from, from(1)%x, from(2)%x, from(3)%x, from(4)%x, &
         to(1)%x, to(2)%x, to(3)%x)
   end function contensou_tangential_stiffness_array

   !> Stiffness of spots, one after the other.
   pure subroutine stiffen_all(n, from, major, minor, modulus, poisson, kx, ky, kt)
      integer(c_ptrdiff_t), intent(in) :: n
      !> Where the inputs lie.
      type(column_type), intent(in) :: from(4)
      real(c_double), intent(in) :: major(*), minor(*), modulus(*), poisson(*)
      real(c_double), intent(out) :: kx(n), ky(n), kt(n)
      real(wp) :: stiffness(3), a, b
      integer(c_ptrdiff_t) :: first(4), stride(4), i

      first = from%first
      stride = from%stride
      do i = 0, n - 1
         a = major(first(1) + i*stride(1))
         b = minor(first(2) + i*stride(2))
         if (b > 0.0_wp .and. b <= a) then
            call tangential_stiffness(elliptic_shape(b/a), a, modulus(first(3) + i*stride(3)), &
               poisson(first(4) + i*stride(4)), stiffness)
         else
            stiffness = ieee_value(1.0_wp, ieee_quiet_nan)
         end if
         kx(i + 1) = stiffness(1)
         ky(i + 1) = stiffness(2)
         kt(i + 1) = stiffness(3)
      end do
   end subroutine stiffen_all

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
