!> Numbers to text and back.
module contensou_base_numbers
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite, ieee_is_nan
   use contensou_base_kinds, only : i8, wp
   use contensou_base_text, only : lower
   implicit none(type, external)
   private

   public :: to_text, counted, number_text, fixed_text, power_text, rounded, read_real

   !> Text of a number or a logical, without surrounding blanks.
   interface to_text
      module procedure :: integer_to_text
      module procedure :: long_integer_to_text
      module procedure :: logical_to_text
      module procedure :: real_to_text
   end interface to_text

   !> Significant decimal digits beyond which only "zero or not" matters for rounding to double.
   integer, parameter :: max_digits = 800

   !> Bit pattern of positive infinity; made from bits because arithmetic would trap.
   integer(i8), parameter :: infinity_bits = int(z"7FF0000000000000", i8)

   !> Bit pattern of a quiet NaN.
   integer(i8), parameter :: nan_bits = int(z"7FF8000000000000", i8)

contains

   !> A number with a given count of significant digits, without superfluous blanks.
   pure function number_text(x, digits) result(text)
      real(wp), intent(in) :: x
      !> Significant digits, 1 to 17.
      integer, intent(in) :: digits
      character(len=:), allocatable :: text
      integer :: before

      before = 0
      if (abs(x) > 0.0_wp) before = floor(log10(abs(x))) + 1
      if (before < -2 .or. before > 6) then
         text = power_text(x, max(digits, 2))
      else
         text = fixed_text(x, max(digits - before, 0))
      end if
   end function number_text

   !> A number with a given count of digits behind the decimal point, without it for none.
   pure function fixed_text(x, decimals) result(text)
      real(wp), intent(in) :: x
      integer, intent(in) :: decimals
      character(len=:), allocatable :: text
      character(len=32) :: buffer, form

      write(form, "(a, i0, a)") "(f32.", decimals, ")"
      write(buffer, form) x
      text = trim(adjustl(buffer))
      if (text(len(text):) == ".") text = text(:len(text) - 1)
   end function fixed_text

   !> A number with a given count of significant digits as a multiple of a power of ten.
   pure function power_text(x, digits) result(text)
      real(wp), intent(in) :: x
      !> Significant digits, 2 to 17.
      integer, intent(in) :: digits
      character(len=:), allocatable :: text
      character(len=32) :: buffer, form
      integer :: e

      ! Two digits of the exponent, three where it takes them.
      e = 2
      if (ieee_is_finite(x)) then
         if (abs(x) >= 9.0e99_wp .or. (abs(x) > 0.0_wp .and. abs(x) < 1.0e-99_wp)) e = 3
      end if
      write(form, "(a, i0, a, i0, a)") "(es32.", digits - 1, "e", e, ")"
      write(buffer, form) x
      text = trim(adjustl(buffer))
   end function power_text

   !> A number rounded to some significant digits: five thousandths come out as 0.005.
   pure real(wp) function rounded(x, digits)
      real(wp), intent(in) :: x
      !> Significant digits, 2 to 17.
      integer, intent(in) :: digits
      logical :: valid

      call read_real(power_text(x, digits), rounded, valid)
   end function rounded

   !> A number of things: "1 case", "2 cases".
   pure function counted(n, thing, things) result(text)
      integer(i8), intent(in) :: n
      !> One of them.
      character(len=*), intent(in) :: thing
      !> Many of them, if that is not `thing` with an s.
      character(len=*), intent(in), optional :: things
      character(len=:), allocatable :: text

      text = to_text(n) // " " // thing
      if (n == 1_i8) return
      text = text // "s"
      if (present(things)) text = to_text(n) // " " // things
   end function counted

   !> Decimal text of an integer.
   pure function integer_to_text(x) result(s)
      !> Number to write.
      integer, intent(in) :: x
      character(len=:), allocatable :: s

      s = long_integer_to_text(int(x, i8))
   end function integer_to_text

   !> Decimal text of an eight-byte integer.
   pure function long_integer_to_text(x) result(s)
      !> Number to write.
      integer(i8), intent(in) :: x
      character(len=:), allocatable :: s
      character(len=24) :: buffer

      write(buffer, "(i0)") x
      s = trim(buffer)
   end function long_integer_to_text

   !> Fortran text of a logical: `.true.` or `.false.`.
   pure function logical_to_text(x) result(s)
      !> Value to write.
      logical, intent(in) :: x
      character(len=:), allocatable :: s

      if (x) then
         s = ".true."
      else
         s = ".false."
      end if
   end function logical_to_text

   !> Shortest decimal text that reads back to the same double.
   !>
   !> Moderate numbers are written as `0.3` or `180.0`, others as `6.0e-3`; there is always a
   !> decimal point. Numbers that are not finite become `NaN`, `Infinity`, `-Infinity`.
   pure function real_to_text(x) result(s)
      !> Number to write.
      real(wp), intent(in) :: x
      character(len=:), allocatable :: s
      character(len=*), parameter :: zeros = "000000"
      integer, parameter :: lowest_fixed = -2, highest_fixed = 5
      real(wp), parameter :: coarse = 1.0e-290_wp
      character(len=40) :: buffer
      character(len=16) :: form
      character(len=:), allocatable :: digits, sign_text
      real(wp) :: back
      integer :: decimals, e, exponent, n
      logical :: valid

      ! A comparison with a NaN would trap in a build that traps invalid operations.
      if (ieee_is_nan(x)) then
         s = "NaN"
         return
      end if

      sign_text = ""
      if (sign(1.0_wp, x) < 0.0_wp) sign_text = "-"
      if (.not. ieee_is_finite(x)) then
         s = sign_text // "Infinity"
         return
      end if

      ! A decimal of up to 15 digits is that of no other, more exact double; the zeros at its end
      ! are dropped below. Where doubles are coarser than that, fewer digits may do.
      decimals = 14
      if (abs(x) < coarse) decimals = 0
      do decimals = decimals, 16
         write(form, "(a,i0,a)") "(es40.", decimals, "e4)"
         write(buffer, form) abs(x)
         buffer = adjustl(buffer)
         call read_real(trim(buffer), back, valid)
         if (transfer(back, 0_i8) == transfer(abs(x), 0_i8)) exit
      end do

      e = scan(buffer, "E")
      read(buffer(e + 1:), *) exponent
      digits = buffer(1:1) // buffer(3:e - 1)
      n = max(verify(digits, "0", back=.true.), 1)
      digits = digits(1:n)
      if (exponent < lowest_fixed .or. exponent > highest_fixed) then
         if (n == 1) digits = digits // "0"
         s = digits(1:1) // "." // digits(2:) // "e" // integer_to_text(exponent)
      else if (exponent < 0) then
         s = "0." // zeros(1:-exponent - 1) // digits
      else
         if (n < exponent + 2) digits = digits // zeros(1:exponent + 2 - n)
         s = digits(1:exponent + 1) // "." // digits(exponent + 2:)
      end if
      s = sign_text // s
   end function real_to_text

   !> Double nearest to a decimal number in any form that Fortran reads.
   !>
   !> Forms: `1`, `+1.5`, `.5`, `5.`, `1e5`, `1.0d-3`, `1.5-3`, and in any case `inf`, `infinity`,
   !> `nan`, `nan(...)`. A number beyond the largest double becomes infinity. The conversion
   !> raises neither overflow nor invalid, so it is safe in builds that trap them.
   pure subroutine read_real(s, x, valid)
      !> Text of the number, without blanks.
      character(len=*), intent(in) :: s
      !> The number; a quiet NaN if the text is none.
      real(wp), intent(out) :: x
      !> Whether the text is a number.
      logical, intent(out) :: valid
      character(len=max_digits) :: digits
      integer(i8) :: exponent, scaling
      integer :: i, n_digits, n_read
      logical :: beyond_point, negative, remainder

      valid = .false.
      x = transfer(nan_bits, 1.0_wp)

      i = 1
      negative = .false.
      if (len(s) > 0) then
         negative = s(1:1) == "-"
         if (scan(s(1:1), "+-") == 1) i = 2
      end if
      if (is_special(s(i:))) then
         valid = .true.
         if (scan(s(i:i), "iI") == 1) x = signed(transfer(infinity_bits, 1.0_wp), negative)
         return
      end if

      ! The number is 0.DIGITS * 10**scaling.
      n_digits = 0
      n_read = 0
      scaling = 0
      beyond_point = .false.
      remainder = .false.
      do i = i, len(s)
         if (s(i:i) == ".") then
            if (beyond_point) return
            beyond_point = .true.
         else if (is_digit(s(i:i))) then
            n_read = n_read + 1
            if (n_digits == 0 .and. s(i:i) == "0") then
               if (beyond_point) scaling = scaling - 1
               cycle
            end if
            if (.not. beyond_point) scaling = scaling + 1
            if (n_digits < max_digits - 1) then
               n_digits = n_digits + 1
               digits(n_digits:n_digits) = s(i:i)
            else
               remainder = remainder .or. s(i:i) /= "0"
            end if
         else
            exit
         end if
      end do
      if (n_read == 0) return

      exponent = 0
      valid = .true.
      if (i <= len(s)) call read_exponent(s(i:), exponent, valid)
      if (.not. valid) return

      if (remainder) then
         n_digits = max_digits
         digits(n_digits:) = "1"
      end if
      x = signed(decimal_value(digits(:n_digits), scaling + exponent), negative)
   end subroutine read_real

   !> Exponent of a number in text, with its letter or without.
   pure subroutine read_exponent(s, exponent, valid)
      character(len=*), intent(in) :: s
      integer(i8), intent(out) :: exponent
      logical, intent(out) :: valid
      integer(i8), parameter :: max_exponent = 1000000000_i8
      integer :: first, i

      exponent = 0
      first = 1 + scan(s(1:1), "eEdD")
      valid = first > 1 .or. scan(s(1:1), "+-") == 1
      if (first <= len(s)) first = first + scan(s(first:first), "+-")
      valid = valid .and. first <= len(s)
      do i = first, len(s)
         valid = valid .and. is_digit(s(i:i))
         if (.not. valid) return
         exponent = min(10*exponent + iachar(s(i:i)) - iachar("0"), max_exponent)
      end do
      if (s(first - 1:first - 1) == "-") exponent = -exponent
   end subroutine read_exponent

   !> Double nearest to 0.DIGITS * 10**scaling.
   pure real(wp) function decimal_value(digits, scaling) result(x)
      character(len=*), intent(in) :: digits
      integer(i8), intent(in) :: scaling
      !> Leading digits of the midpoint between the largest double and 2**1024.
      character(len=*), parameter :: ceiling_digits = "179769313486231580793728971405"
      integer, parameter :: ceiling_scale = 309, floor_scale = -400
      character(len=len(digits) + 32) :: buffer
      character(len=len(ceiling_digits)) :: leading
      integer(i8) :: whole
      integer :: i
      real(wp), parameter :: powers_of_ten(0:22) = [(10.0_wp**i, i=0, 22)]

      x = 0.0_wp
      if (len(digits) == 0 .or. scaling < floor_scale) return
      ! Both the digits and the power of ten are exact, so that their product is rounded once.
      if (len(digits) <= 15 .and. abs(scaling - len(digits)) <= ubound(powers_of_ten, 1)) then
         whole = 0
         do i = 1, len(digits)
            whole = 10*whole + (iachar(digits(i:i)) - iachar("0"))
         end do
         if (scaling >= len(digits)) then
            x = real(whole, wp)*powers_of_ten(int(scaling) - len(digits))
         else
            x = real(whole, wp)/powers_of_ten(len(digits) - int(scaling))
         end if
         return
      end if
      leading = digits
      do i = len(digits) + 1, len(leading)
         leading(i:i) = "0"
      end do
      if (scaling > ceiling_scale &
         .or. (scaling == ceiling_scale .and. leading >= ceiling_digits)) then
         x = transfer(infinity_bits, 1.0_wp)
         return
      end if
      write(buffer, "(3a,i0)") "0.", digits, "e", scaling
      read(buffer, *) x
   end function decimal_value

   !> Whether a text without sign is one of the forms of infinity and NaN.
   pure logical function is_special(s)
      character(len=*), intent(in) :: s
      character(len=*), parameter :: allowed = &
         "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_"

      is_special = .false.
      select case (len(s))
      case (:2)
         continue
      case (3)
         is_special = lower(s) == "inf" .or. lower(s) == "nan"
      case (4)
         continue
      case default
         if (len(s) == 8) is_special = lower(s) == "infinity"
         if (lower(s(1:4)) == "nan(" .and. s(len(s):) == ")") then
            is_special = verify(s(5:len(s) - 1), allowed) == 0
         end if
      end select
   end function is_special

   !> Magnitude with a sign; also for zero and infinity.
   pure function signed(magnitude, negative) result(x)
      !> Number without sign.
      real(wp), intent(in) :: magnitude
      !> Whether the result is negative.
      logical, intent(in) :: negative
      !> Number with sign.
      real(wp) :: x

      x = magnitude
      if (negative) x = sign(magnitude, -1.0_wp)
   end function signed

   !> Whether a character is a decimal digit.
   pure logical function is_digit(c)
      !> Character to look at.
      character(len=1), intent(in) :: c

      is_digit = c >= "0" .and. c <= "9"
   end function is_digit

end module contensou_base_numbers
