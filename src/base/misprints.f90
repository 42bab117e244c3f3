!> What is likely meant by a word that is not a number: one with a unit, with a character that only
!> looks like that of a number, with a comma for the decimal point.
module contensou_base_misprints
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite
   use contensou_base_kinds, only : pi, wp
   use contensou_base_numbers, only : read_real, rounded, to_text
   use contensou_base_text, only : quote, shorten
   implicit none(type, external)
   private

   public :: explain_misprint, explain_lookalike, explain_unit, explain_comma

   !> A unit that people write.
   type :: unit_type
      character(len=7) :: name
      !> Its value in SI units.
      real(wp) :: factor
      character(len=6) :: si
   end type unit_type

   !> Units, those of SI with the factor 1.
   type(unit_type), parameter :: units(*) = [ &
      unit_type("m", 1.0_wp, "m"), unit_type("mm", 1.0e-3_wp, "m"), &
      unit_type("cm", 1.0e-2_wp, "m"), unit_type("um", 1.0e-6_wp, "m"), &
      unit_type("nm", 1.0e-9_wp, "m"), unit_type("km", 1.0e3_wp, "m"), &
      unit_type("in", 2.54e-2_wp, "m"), unit_type("kg", 1.0_wp, "kg"), &
      unit_type("g", 1.0e-3_wp, "kg"), unit_type("mg", 1.0e-6_wp, "kg"), &
      unit_type("t", 1.0e3_wp, "kg"), unit_type("s", 1.0_wp, "s"), &
      unit_type("sec", 1.0_wp, "s"), unit_type("ms", 1.0e-3_wp, "s"), &
      unit_type("us", 1.0e-6_wp, "s"), unit_type("min", 60.0_wp, "s"), &
      unit_type("h", 3600.0_wp, "s"), unit_type("N", 1.0_wp, "N"), &
      unit_type("mN", 1.0e-3_wp, "N"), unit_type("kN", 1.0e3_wp, "N"), &
      unit_type("MN", 1.0e6_wp, "N"), unit_type("J", 1.0_wp, "J"), &
      unit_type("Pa", 1.0_wp, "Pa"), unit_type("kPa", 1.0e3_wp, "Pa"), &
      unit_type("MPa", 1.0e6_wp, "Pa"), unit_type("GPa", 1.0e9_wp, "Pa"), &
      unit_type("bar", 1.0e5_wp, "Pa"), unit_type("N/m2", 1.0_wp, "Pa"), &
      unit_type("N/mm2", 1.0e6_wp, "Pa"), unit_type("rad", 1.0_wp, "rad"), &
      unit_type("deg", pi/180.0_wp, "rad"), unit_type("degree", pi/180.0_wp, "rad"), &
      unit_type("degrees", pi/180.0_wp, "rad"), unit_type("turn", 2.0_wp*pi, "rad"), &
      unit_type("turns", 2.0_wp*pi, "rad"), unit_type("rpm", pi/30.0_wp, "rad/s"), &
      unit_type("rad/s", 1.0_wp, "rad/s"), unit_type("m/s", 1.0_wp, "m/s"), &
      unit_type("mm/s", 1.0e-3_wp, "m/s"), unit_type("km/h", 1.0_wp/3.6_wp, "m/s"), &
      unit_type("m/s2", 1.0_wp, "m/s2"), unit_type("m/s^2", 1.0_wp, "m/s2"), &
      unit_type("ms-2", 1.0_wp, "m/s2"), unit_type("ms-1", 1.0_wp, "m/s"), &
      unit_type("rads-1", 1.0_wp, "rad/s"), unit_type("deg/s", pi/180.0_wp, "rad/s"), &
      unit_type("N/m^2", 1.0_wp, "Pa"), unit_type("N/mm^2", 1.0e6_wp, "Pa"), &
      unit_type("kN/mm2", 1.0e9_wp, "Pa"), unit_type("GN/m2", 1.0e9_wp, "Pa"), &
      unit_type("gram", 1.0e-3_wp, "kg"), unit_type("grams", 1.0e-3_wp, "kg"), &
      unit_type("kgm2", 1.0_wp, "kg m2"), unit_type("kgm^2", 1.0_wp, "kg m2"), &
      unit_type("kg/m3", 1.0_wp, "kg/m3"), unit_type("kg/m^3", 1.0_wp, "kg/m3"), &
      unit_type("g/cm3", 1.0e3_wp, "kg/m3"), unit_type("N/m", 1.0_wp, "N/m"), &
      unit_type("Nm", 1.0_wp, "N m"), unit_type("%", 1.0e-2_wp, "1"), &
      unit_type(char(194) // char(176), pi/180.0_wp, "rad"), &
      unit_type(char(194) // char(181) // "m", 1.0e-6_wp, "m"), &
      unit_type(char(206) // char(188) // "m", 1.0e-6_wp, "m"), &
      unit_type(char(194) // char(181) // "s", 1.0e-6_wp, "s")]

   !> A character that is taken for another one.
   type :: lookalike_type
      !> Its bytes in UTF-8.
      character(len=3) :: bytes
      character(len=24) :: name
      !> Its code point in hexadecimal digits.
      character(len=4) :: code
      !> What stands for it in a file.
      character(len=1) :: plain
   end type lookalike_type

   !> First two bytes of the characters U+2000 to U+203F, which most of these are.
   character(len=*), parameter :: general = char(226) // char(128)

   !> Characters from texts that were set by a word processor.
   type(lookalike_type), parameter :: lookalikes(*) = [ &
      lookalike_type(char(226) // char(136) // char(146), "Unicode minus", "2212", "-"), &
      lookalike_type(general // char(144), "Unicode hyphen", "2010", "-"), &
      lookalike_type(general // char(145), "no-break hyphen", "2011", "-"), &
      lookalike_type(general // char(146), "figure dash", "2012", "-"), &
      lookalike_type(general // char(147), "dash", "2013", "-"), &
      lookalike_type(general // char(148), "dash", "2014", "-"), &
      lookalike_type(char(239) // char(188) // char(141), "full-width minus", "FF0D", "-"), &
      lookalike_type(char(194) // char(160), "no-break space", "00A0", " "), &
      lookalike_type(general // char(175), "narrow no-break space", "202F", " "), &
      lookalike_type(general // char(135), "figure space", "2007", " "), &
      lookalike_type(general // char(137), "thin space", "2009", " "), &
      lookalike_type(general // char(130), "typographic space", "2002", " "), &
      lookalike_type(general // char(131), "typographic space", "2003", " "), &
      lookalike_type(general // char(139), "zero-width space", "200B", " "), &
      lookalike_type(general // char(168), "line separator", "2028", " "), &
      lookalike_type(char(227) // char(128) // char(128), "full-width space", "3000", " "), &
      lookalike_type(char(239) // char(187) // char(191), "byte order mark", "FEFF", " "), &
      lookalike_type(char(239) // char(188) // char(140), "full-width comma", "FF0C", ","), &
      lookalike_type(char(239) // char(188) // char(157), "full-width equals sign", "FF1D", "="), &
      lookalike_type(char(239) // char(188) // char(142), "full-width point", "FF0E", "."), &
      lookalike_type(char(239) // char(188) // char(144), "full-width digit", "FF10", "0"), &
      lookalike_type(char(239) // char(188) // char(145), "full-width digit", "FF11", "1"), &
      lookalike_type(char(239) // char(188) // char(146), "full-width digit", "FF12", "2"), &
      lookalike_type(char(239) // char(188) // char(147), "full-width digit", "FF13", "3"), &
      lookalike_type(char(239) // char(188) // char(148), "full-width digit", "FF14", "4"), &
      lookalike_type(char(239) // char(188) // char(149), "full-width digit", "FF15", "5"), &
      lookalike_type(char(239) // char(188) // char(150), "full-width digit", "FF16", "6"), &
      lookalike_type(char(239) // char(188) // char(151), "full-width digit", "FF17", "7"), &
      lookalike_type(char(239) // char(188) // char(152), "full-width digit", "FF18", "8"), &
      lookalike_type(char(239) // char(188) // char(153), "full-width digit", "FF19", "9"), &
      lookalike_type(char(217) // char(171), "decimal separator", "066B", "."), &
      lookalike_type(char(195) // char(151), "multiplication sign", "00D7", "*"), &
      lookalike_type(char(226) // char(136) // char(151), "multiplication sign", "2217", "*"), &
      lookalike_type(char(226) // char(139) // char(133), "multiplication dot", "22C5", "*"), &
      lookalike_type(char(194) // char(183), "multiplication dot", "00B7", "*")]

   character(len=*), parameter :: digits = "0123456789"

contains

   !> Say what is likely wrong with a word or a cell that should be a number.
   pure subroutine explain_misprint(word, message, expected)
      !> The word; it is none of the values that a file can have.
      character(len=*), intent(in) :: word
      !> What is wrong; not allocated if nobody knows.
      character(len=:), allocatable, intent(out) :: message
      !> What would be right; allocated with `message`.
      character(len=:), allocatable, intent(out) :: expected
      real(wp) :: x
      integer :: comma, n
      logical :: valid

      call explain_lookalike(word, message, expected)
      if (allocated(message)) return
      n = number_length(word)
      if (n > 0 .and. n < len_trim(word)) then
         call explain_unit(word(:n), trim(adjustl(word(n + 1:))), .true., message, expected)
         if (allocated(message)) return
      end if
      if (index(word, "^") > 1 .and. n > 0) then
         message = quote(shorten(word, 40)) // ": '^' is no operator"
         expected = "** for a power, as 2**3 or 10**(-2)"
         return
      end if
      comma = index(word, ",")
      if (comma < 2 .or. comma >= len(word)) return
      if (verify(word(comma + 1:comma + 1), digits) > 0) return
      call read_real(word(:comma - 1) // "." // word(comma + 1:), x, valid)
      if (.not. valid) return
      message = quote(word) // " has a decimal comma"
      expected = word(:comma - 1) // "." // word(comma + 1:)
   end subroutine explain_misprint

   !> Say which character in a word only looks like one that a file can have.
   pure subroutine explain_lookalike(word, message, expected)
      character(len=*), intent(in) :: word
      !> What is wrong; not allocated if there is none.
      character(len=:), allocatable, intent(out) :: message
      !> What would be right; allocated with `message`.
      character(len=:), allocatable, intent(out) :: expected
      character(len=:), allocatable :: behind, plain
      integer :: at, first, i, k, n

      first = 0
      k = 0
      do i = 1, size(lookalikes)
         at = index(word, trim(lookalikes(i)%bytes))
         if (at == 0 .or. (first > 0 .and. at > first)) cycle
         first = at
         k = i
      end do
      if (k == 0) return
      message = quote(shorten(word, 40)) // " has a " // trim(lookalikes(k)%name) // " (U+" // &
         lookalikes(k)%code // ")"
      plain = word
      do i = 1, size(lookalikes)
         n = len_trim(lookalikes(i)%bytes)
         do
            at = index(plain, lookalikes(i)%bytes(:n))
            if (at == 0) exit
            plain = plain(:at - 1) // lookalikes(i)%plain // plain(at + n:)
         end do
      end do
      plain = trim(adjustl(plain))
      n = number_length(plain)
      if (n > 0) call explain_unit(plain(:n), trim(plain(n + 1:)), .true., behind, expected)
      if (allocated(expected)) return
      expected = shorten(plain, 40)
      if (plain == "") then
         expected = "plain blanks"
      else if (lookalikes(k)%plain == " ") then
         expected = expected // ", with plain blanks"
      else if (lookalikes(k)%plain == "-") then
         expected = expected // ", with the minus of a keyboard"
      else
         expected = expected // ", with the '" // lookalikes(k)%plain // "' of a keyboard"
      end if
   end subroutine explain_lookalike

   !> Say that a unit does not go behind a number.
   pure subroutine explain_unit(number, word, sure, message, expected)
      !> The number, as it stands there.
      character(len=*), intent(in) :: number
      !> What stands behind it.
      character(len=*), intent(in) :: word
      !> Whether only what is known to be a unit is meant.
      logical, intent(in) :: sure
      !> What is wrong; not allocated if it is no unit.
      character(len=:), allocatable, intent(out) :: message
      !> What would be right; allocated with `message`.
      character(len=:), allocatable, intent(out) :: expected
      character(len=:), allocatable :: unit
      real(wp) :: x
      integer :: i
      logical :: valid

      unit = bare_unit(word)
      do i = 1, size(units)
         if (units(i)%name == unit) exit
      end do
      call read_real(number, x, valid)
      valid = valid .and. i <= size(units)
      if (valid) valid = ieee_is_finite(x)
      if (valid) then
         message = "'" // shorten(word, 40) // "' behind a number: values are plain numbers " // &
            "in SI units"
         expected = trim(adjustl(number))
         if (abs(units(i)%factor - 1.0_wp) > 0.0_wp) expected = &
            to_text(rounded(x*units(i)%factor, 12))
         if (units(i)%si == "rad") then
            expected = to_text(rounded(x*units(i)%factor*180.0_wp/pi, 12)) // &
               " deg, or the number in rad"
            if (abs(units(i)%factor - pi/180.0_wp) <= 0.0_wp) expected = &
               trim(adjustl(number)) // " deg, or the number in rad"
            if (abs(units(i)%factor - 1.0_wp) <= 0.0_wp) expected = trim(adjustl(number))
            return
         end if
         expected = expected // " without a unit"
         if (units(i)%si /= "1") expected = expected // ", which is in " // trim(units(i)%si)
      else if (.not. sure) then
         message = "'" // shorten(word, 40) // "' behind a number: values are plain numbers " // &
            "in SI units"
         expected = trim(adjustl(number)) // " alone, if that is what it is in the SI unit"
      end if
   end subroutine explain_unit

   !> Say that a comma stands between two values, not in a number.
   pure subroutine explain_comma(before, behind, width, expected)
      !> Number before the comma.
      real(wp), intent(in) :: before
      !> Number behind it.
      real(wp), intent(in) :: behind
      !> Number of its digits.
      integer, intent(in) :: width
      !> What would be right.
      character(len=:), allocatable, intent(out) :: expected
      character(len=:), allocatable :: whole, part

      whole = to_text(before)
      part = to_text(behind)
      whole = whole(:index(whole // ".", ".") - 1)
      part = part(:index(part // ".", ".") - 1)
      expected = whole // "." // repeat("0", max(width - len(part), 0)) // part
   end subroutine explain_comma

   !> A unit without brackets, blanks and dots.
   pure function bare_unit(word) result(unit)
      character(len=*), intent(in) :: word
      character(len=:), allocatable :: unit
      integer :: i

      unit = ""
      do i = 1, len(word)
         if (scan(word(i:i), " []().*_") == 0) unit = unit // word(i:i)
      end do
   end function bare_unit

   !> Length of the longest number that a word begins with; 0 for none.
   pure integer function number_length(word)
      character(len=*), intent(in) :: word
      real(wp) :: x
      logical :: valid

      number_length = verify(word // "_", digits // "+-.eEdD") - 1
      do while (number_length > 0)
         if (scan(word(number_length:number_length), digits // ".") > 0) then
            call read_real(word(:number_length), x, valid)
            if (valid) return
         end if
         number_length = number_length - 1
      end do
   end function number_length

end module contensou_base_misprints
