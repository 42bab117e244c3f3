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

   public :: slip_type, scaled_type, prepare, length, rescaled

   !> How a spot slides and spins.
   type :: slip_type
      !> Sliding velocity of the centre along the major axis [m/s].
      real(wp) :: x = 0.0_wp
      !> Sliding velocity of the centre along the minor axis [m/s].
      real(wp) :: y = 0.0_wp
      !> Spin velocity at the end of the major axis, W = a w [m/s], with the sign of w.
      real(wp) :: spin = 0.0_wp
      !> Regularisation velocity [m/s], >= 0.
      real(wp) :: delta = 0.0_wp
   end type slip_type

   !> Such a motion where squares are safe: the velocities times two to the power `shift`.
   type :: scaled_type
      !> Sliding velocity along the major and the minor axis.
      real(wp) :: x
      real(wp) :: y
      !> Absolute spin velocity.
      real(wp) :: w
      !> Regularisation velocity; zero outside the domain.
      real(wp) :: d
      integer :: shift
      !> Whether anything moves.
      logical :: moving
      !> What every component of the wrench begins with: that of rest, zero; NaN outside the domain.
      real(wp) :: rest
   end type scaled_type

   !> Velocities between these bounds are used as they are.
   real(wp), parameter :: smallest_plain = 1.0e-40_wp, largest_plain = 1.0e40_wp

   !> The bounds as bit patterns, which have the order of the (positive) numbers.
   integer(i8), parameter :: smallest_bits = transfer(smallest_plain, 0_i8)
   integer(i8), parameter :: largest_bits = transfer(largest_plain, 0_i8)

contains

   !> Take the motion of a spot if squares are safe with it; what is not `moving` is left to
   !> `prepare_extreme`. Two procedures, as only a small one is inlined in each kernel.
   pure subroutine prepare(shape, slip, scaled)
      type(spot_shape_type), intent(in) :: shape
      type(slip_type), intent(in) :: slip
      type(scaled_type), intent(out) :: scaled
      integer(i8) :: largest, regular

      scaled%x = slip%x
      scaled%y = slip%y
      scaled%w = abs(slip%spin)
      scaled%d = slip%delta
      scaled%shift = 0
      scaled%rest = 0.0_wp
      ! As integers: comparing a NaN raises an exception, and a NaN is larger than all numbers.
      largest = max(transfer(abs(slip%x), 0_i8), transfer(abs(slip%y), 0_i8), &
         transfer(scaled%w, 0_i8))
      regular = transfer(slip%delta, 0_i8)
      scaled%moving = largest >= smallest_bits .and. max(largest, regular) <= largest_bits .and. &
         regular >= 0_i8 .and. transfer(shape%k, 0_i8) <= largest_bits
      if (.not. scaled%moving) call prepare_extreme(shape, scaled)
   end subroutine prepare

   !> Bring another motion into the range of safe squares, and begin with the wrench of rest, or NaN
   !> outside the domain.
   pure subroutine prepare_extreme(shape, scaled)
      type(spot_shape_type), intent(in) :: shape
      type(scaled_type), intent(inout) :: scaled
      real(wp) :: largest

      associate (x => scaled%x, y => scaled%y, w => scaled%w, d => scaled%d, &
         moving => scaled%moving)
         moving = ieee_is_finite(x) .and. ieee_is_finite(y) .and. ieee_is_finite(w) .and. &
            ieee_is_finite(d) .and. ieee_is_finite(shape%k)
         if (moving) moving = d >= 0.0_wp
         if (.not. moving) then
            d = 0.0_wp
            scaled%rest = ieee_value(scaled%rest, ieee_quiet_nan)
            return
         end if
         largest = max(abs(x), abs(y), w)
         moving = largest > 0.0_wp
         largest = max(largest, d)
         if (largest <= 0.0_wp) return
         scaled%shift = -exponent(largest)
         x = scale(x, scaled%shift)
         y = scale(y, scaled%shift)
         w = scale(w, scaled%shift)
         d = scale(d, scaled%shift)
      end associate
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
