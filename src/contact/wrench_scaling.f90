!> Arguments and results of the friction kernels over the whole range of velocities.
!>
!> The wrench is homogeneous of degree zero in the velocities. Where their squares and products
!> could over- or underflow they are rescaled by a power of two, which changes no digit.
module contensou_contact_wrench_scaling
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite, ieee_quiet_nan, ieee_value
   use contensou_base_kinds, only : i8, wp
   use contensou_contact_spot, only : spot_shape_type
   implicit none(type, external)
   private

   public :: prepare, prepare_extreme, length, rescaled

   !> Velocities between these bounds are used as they are.
   real(wp), parameter :: smallest_plain = 1.0e-40_wp, largest_plain = 1.0e40_wp

   !> The bounds as bit patterns, which have the order of the (positive) numbers.
   integer(i8), parameter :: smallest_bits = transfer(smallest_plain, 0_i8)
   integer(i8), parameter :: largest_bits = transfer(largest_plain, 0_i8)

contains

   !> Take the arguments of a kernel if squares are safe with them; what is not `moving` is left to
   !> `prepare_extreme`. Two procedures, as only a small one is inlined in each kernel.
   pure subroutine prepare(shape, vx, vy, spin, delta, x, y, w, d, shift, moving, rest)
      type(spot_shape_type), intent(in) :: shape
      !> Sliding velocity along the major axis [m/s].
      real(wp), intent(in) :: vx
      !> Sliding velocity along the minor axis [m/s].
      real(wp), intent(in) :: vy
      !> Spin velocity [m/s].
      real(wp), intent(in) :: spin
      !> Regularisation velocity [m/s].
      real(wp), intent(in) :: delta
      !> `vx`.
      real(wp), intent(out) :: x
      !> `vy`.
      real(wp), intent(out) :: y
      !> |`spin`|.
      real(wp), intent(out) :: w
      !> `delta`.
      real(wp), intent(out) :: d
      !> Power of two of the scale: none.
      integer, intent(out) :: shift
      !> Whether squares are safe.
      logical, intent(out) :: moving
      !> What every component of the wrench begins with: that of rest, zero.
      real(wp), intent(out) :: rest
      integer(i8) :: largest, regular

      x = vx
      y = vy
      w = abs(spin)
      d = delta
      shift = 0
      rest = 0.0_wp
      ! As integers: comparing a NaN raises an exception, and a NaN is larger than all numbers.
      largest = max(transfer(abs(vx), 0_i8), transfer(abs(vy), 0_i8), transfer(w, 0_i8))
      regular = transfer(d, 0_i8)
      moving = largest >= smallest_bits .and. max(largest, regular) <= largest_bits .and. &
         regular >= 0_i8 .and. transfer(shape%k, 0_i8) <= largest_bits
   end subroutine prepare

   !> Bring other arguments into the range of safe squares, and begin with the wrench of rest,
   !> or NaN outside the domain.
   pure subroutine prepare_extreme(shape, x, y, w, d, shift, moving, rest)
      type(spot_shape_type), intent(in) :: shape
      !> Sliding velocity along the major axis, rescaled by two to the power `shift` on return.
      real(wp), intent(inout) :: x
      !> Sliding velocity along the minor axis, rescaled.
      real(wp), intent(inout) :: y
      !> Absolute spin velocity, rescaled.
      real(wp), intent(inout) :: w
      !> Regularisation velocity, rescaled; zero outside the domain.
      real(wp), intent(inout) :: d
      !> Power of two of the scale.
      integer, intent(out) :: shift
      !> Whether there is anything left to compute.
      logical, intent(out) :: moving
      !> Zero; NaN outside the domain.
      real(wp), intent(inout) :: rest
      real(wp) :: largest

      shift = 0
      moving = ieee_is_finite(x) .and. ieee_is_finite(y) .and. ieee_is_finite(w) .and. &
         ieee_is_finite(d) .and. ieee_is_finite(shape%k)
      if (moving) moving = d >= 0.0_wp
      if (.not. moving) then
         d = 0.0_wp
         rest = ieee_value(rest, ieee_quiet_nan)
         return
      end if
      largest = max(abs(x), abs(y), w)
      moving = largest > 0.0_wp
      largest = max(largest, d)
      if (largest <= 0.0_wp) return
      shift = -exponent(largest)
      x = scale(x, shift)
      y = scale(y, shift)
      w = scale(w, shift)
      d = scale(d, shift)
   end subroutine prepare_extreme

   !> Length of a plane vector, also where the squares underflow.
   pure function length(x, y) result(r)
      !> First component.
      real(wp), intent(in) :: x
      !> Second component.
      real(wp), intent(in) :: y
      real(wp) :: r

      r = x*x + y*y
      if (r > 1.0e-280_wp) then
         r = sqrt(r)
      else
         r = hypot(x, y)
      end if
   end function length

   !> A number times a power of two; the largest number there is instead of an overflow.
   elemental function rescaled(x, shift) result(r)
      !> The number.
      real(wp), intent(in) :: x
      !> The power.
      integer, intent(in) :: shift
      real(wp) :: r

      if (exponent(x) + shift <= maxexponent(x) .or. abs(x) <= 0.0_wp) then
         r = scale(x, shift)
      else
         r = sign(huge(x), x)
      end if
   end function rescaled

end module contensou_contact_wrench_scaling
