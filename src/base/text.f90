!> Small tools for text: case, numbers to text and back, quoting, and the nearest known word.
module contensou_base_text
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite, ieee_is_nan
   use contensou_base_kinds, only : i8, wp
   implicit none(type, external)
   private

   public :: string_type, text_buffer_type
   public :: lower, number_text, to_text, read_real, quote, pad, strings, join, shorten, starts_with
   public :: edit_distance, nearest, did_you_mean, command_text

   !> A text of its own length, for lists of texts.
   type :: string_type
      character(len=:), allocatable :: s
   end type string_type

   !> A long text in the making; it grows by doubling.
   type :: text_buffer_type
      private
      !> The text so far and room for more.
      character(len=:), allocatable :: bytes
      !> Length of the text.
      integer :: n = 0
   contains
      procedure :: add => add_text
      procedure :: text => buffered_text
   end type text_buffer_type

   !> Text of a number or a logical, without surrounding blanks.
   interface to_text
      module procedure :: integer_to_text
      module procedure :: long_integer_to_text
      module procedure :: logical_to_text
      module procedure :: real_to_text
   end interface to_text

   !> Index of the candidate nearest to a word, 0 if none is near.
   interface nearest
      module procedure :: nearest_character
      module procedure :: nearest_string
   end interface nearest

   !> Shortest word that may match as a part of a candidate.
   integer, parameter :: shortest_part = 3

   !> Significant decimal digits beyond which only "zero or not" matters for rounding to double.
   integer, parameter :: max_digits = 800

   !> Bit pattern of positive infinity; made from bits because arithmetic would trap.
   integer(i8), parameter :: infinity_bits = int(z"7FF0000000000000", i8)

   !> Bit pattern of a quiet NaN.
   integer(i8), parameter :: nan_bits = int(z"7FF8000000000000", i8)

contains

   !> Append a text to a buffer.
   pure subroutine add_text(self, text)
      class(text_buffer_type), intent(inout) :: self
      character(len=*), intent(in) :: text
      character(len=:), allocatable :: bigger

      if (.not. allocated(self%bytes)) allocate(character(len=256) :: self%bytes)
      if (self%n + len(text) > len(self%bytes)) then
         allocate(character(len=2*(self%n + len(text))) :: bigger)
         bigger(:self%n) = self%bytes(:self%n)
         call move_alloc(bigger, self%bytes)
      end if
      self%bytes(self%n + 1:self%n + len(text)) = text
      self%n = self%n + len(text)
   end subroutine add_text

   !> Text of a buffer so far.
   pure function buffered_text(self) result(text)
      class(text_buffer_type), intent(in) :: self
      character(len=:), allocatable :: text

      text = ""
      if (self%n > 0) text = self%bytes(:self%n)
   end function buffered_text

   !> Text with the ASCII letters in lower case; other bytes are kept.
   pure function lower(s) result(t)
      character(len=*), intent(in) :: s
      character(len=len(s)) :: t
      integer :: i

      do i = 1, len(s)
         if (s(i:i) >= "A" .and. s(i:i) <= "Z") then
            t(i:i) = achar(iachar(s(i:i)) + 32)
         else
            t(i:i) = s(i:i)
         end if
      end do
   end function lower

   !> A number with a given count of significant digits, without superfluous blanks.
   pure function number_text(x, digits) result(text)
      real(wp), intent(in) :: x
      !> Significant digits, 1 to 17.
      integer, intent(in) :: digits
      character(len=:), allocatable :: text
      character(len=32) :: buffer, form
      integer :: before

      before = 0
      if (abs(x) > 0.0_wp) before = floor(log10(abs(x))) + 1
      if (before < -2 .or. before > 6) then
         write(form, "('(es32.', i0, ')')") max(digits - 1, 1)
      else
         write(form, "('(f32.', i0, ')')") max(digits - before, 0)
      end if
      write(buffer, form) x
      text = trim(adjustl(buffer))
      if (text(len(text):) == ".") text = text(:len(text) - 1)
   end function number_text

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
      !> Leading digits of the midpoint between the largest double and 2**1024.
      character(len=*), parameter :: ceiling_digits = "179769313486231580793728971405"
      integer, parameter :: ceiling_scale = 309, floor_scale = -400
      integer(i8), parameter :: max_exponent = 1000000000_i8
      character(len=max_digits) :: digits
      character(len=max_digits + 32) :: buffer
      character(len=len(ceiling_digits)) :: leading
      integer(i8) :: exponent, scaling, read_digits
      integer :: i, n_digits, n_read, stat
      logical :: beyond_point, negative, negative_exponent, remainder
      real(wp), parameter :: powers_of_ten(0:22) = [(10.0_wp**i, i=0, 22)]

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
      if (i <= len(s)) then
         if (scan(s(i:i), "eEdD") == 1) then
            i = i + 1
         else if (scan(s(i:i), "+-") == 0) then
            return
         end if
         if (i > len(s)) return
         negative_exponent = s(i:i) == "-"
         if (scan(s(i:i), "+-") == 1) i = i + 1
         if (i > len(s)) return
         do i = i, len(s)
            if (.not. is_digit(s(i:i))) return
            exponent = min(10*exponent + iachar(s(i:i)) - iachar("0"), max_exponent)
         end do
         if (negative_exponent) exponent = -exponent
      end if
      valid = .true.

      scaling = scaling + exponent
      if (remainder) then
         n_digits = max_digits
         digits(n_digits:) = "1"
      end if
      if (n_digits == 0 .or. scaling < floor_scale) then
         x = signed(0.0_wp, negative)
         return
      end if
      ! Both the digits and the power of ten are exact, so that their product is rounded once.
      if (n_digits <= 15 .and. abs(scaling - n_digits) <= ubound(powers_of_ten, 1)) then
         read_digits = 0
         do i = 1, n_digits
            read_digits = 10*read_digits + (iachar(digits(i:i)) - iachar("0"))
         end do
         if (scaling >= n_digits) then
            x = signed(real(read_digits, wp)*powers_of_ten(int(scaling) - n_digits), negative)
         else
            x = signed(real(read_digits, wp)/powers_of_ten(n_digits - int(scaling)), negative)
         end if
         return
      end if
      leading = repeat("0", len(leading))
      leading(1:min(n_digits, len(leading))) = digits(1:min(n_digits, len(leading)))
      if (scaling > ceiling_scale &
         .or. (scaling == ceiling_scale .and. leading >= ceiling_digits)) then
         x = signed(transfer(infinity_bits, 1.0_wp), negative)
         return
      end if
      ! Only the part that is used: the rest of a long record costs more than the number.
      write(buffer(:n_digits + 16), "(3a,i0)") "0.", digits(1:n_digits), "e", scaling
      read(buffer(:n_digits + 16), *, iostat=stat) x
      if (stat /= 0) then
         valid = .false.
         x = transfer(nan_bits, 1.0_wp)
         return
      end if
      x = signed(x, negative)
   end subroutine read_real

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

   !> Fortran character literal of a text, with quotes in it doubled.
   pure function quote(s) result(t)
      character(len=*), intent(in) :: s
      character(len=:), allocatable :: t
      integer :: i, n

      n = 2 + len(s)
      do i = 1, len(s)
         if (s(i:i) == "'") n = n + 1
      end do
      allocate(character(len=n) :: t)
      t(1:1) = "'"
      n = 1
      do i = 1, len(s)
         n = n + 1
         t(n:n) = s(i:i)
         if (s(i:i) == "'") then
            n = n + 1
            t(n:n) = "'"
         end if
      end do
      t(n + 1:) = "'"
   end function quote

   !> Texts of their own length from texts padded with blanks.
   pure function strings(padded) result(names)
      !> Padded texts.
      character(len=*), intent(in) :: padded(:)
      type(string_type), allocatable :: names(:)
      integer :: i

      allocate(names(size(padded)))
      do i = 1, size(padded)
         names(i)%s = trim(padded(i))
      end do
   end function strings

   !> Texts as an array of one length, that of the longest one and at least one.
   pure subroutine pad(texts, padded)
      type(string_type), intent(in) :: texts(:)
      character(len=:), allocatable, intent(out) :: padded(:)
      integer :: i, longest

      longest = 1
      do i = 1, size(texts)
         longest = max(longest, len(texts(i)%s))
      end do
      allocate(character(len=longest) :: padded(size(texts)))
      do i = 1, size(texts)
         padded(i) = texts(i)%s
      end do
   end subroutine pad

   !> Texts of a list one after the other with a separator between them.
   pure function join(list, separator) result(t)
      !> Texts to join; one that is not allocated counts as empty.
      type(string_type), intent(in) :: list(:)
      !> Text between two of them.
      character(len=*), intent(in) :: separator
      character(len=:), allocatable :: t
      integer :: i

      t = ""
      do i = 1, size(list)
         if (i > 1) t = t // separator
         if (allocated(list(i)%s)) t = t // list(i)%s
      end do
   end function join

   !> Text cut to a number of bytes and ended by `...` if it is longer; never cuts a character.
   pure function shorten(s, width) result(t)
      character(len=*), intent(in) :: s
      !> Largest number of bytes of the result, at least 3.
      integer, intent(in) :: width
      character(len=:), allocatable :: t
      integer :: last

      if (len(s) <= width) then
         t = s
         return
      end if
      ! Bytes 128 to 191 continue a character of UTF-8.
      last = max(width - 3, 0)
      do while (last > 0)
         if (iand(ichar(s(last + 1:last + 1)), 192) /= 128) exit
         last = last - 1
      end do
      t = s(1:last) // "..."
   end function shorten

   !> Whether a text begins with another.
   pure logical function starts_with(s, prefix)
      character(len=*), intent(in) :: s
      !> Beginning to look for.
      character(len=*), intent(in) :: prefix

      starts_with = .false.
      if (len(s) >= len(prefix)) starts_with = s(1:len(prefix)) == prefix
   end function starts_with

   !> A command line of the program as one text.
   pure function command_text(words) result(text)
      !> Its words after the name of the program.
      type(string_type), intent(in) :: words(:)
      character(len=:), allocatable :: text
      integer :: i

      text = "contensou"
      do i = 1, size(words)
         if (verify(words(i)%s, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ" // &
            "0123456789-_./=,+:@%") > 0 .or. words(i)%s == "") then
            text = text // " " // quote(words(i)%s)
         else
            text = text // " " // words(i)%s
         end if
      end do
   end function command_text

   !> Damerau-Levenshtein distance of two texts (optimal string alignment): the number of
   !> insertions, deletions, substitutions and swaps of neighbours that turn one into the other.
   pure integer function edit_distance(a, b, most)
      character(len=*), intent(in) :: a
      character(len=*), intent(in) :: b
      !> Any number above this will do for a larger distance; not given, there is no such bound.
      integer, intent(in), optional :: most
      ! Rows i - 2, i - 1 and i of the table of distances between beginnings of the texts; only
      ! what lies within `limit` of the diagonal can be so small.
      integer :: rows(0:len(b), 0:2)
      integer :: before, cost, current, i, j, limit, previous

      limit = max(len(a), len(b))
      if (present(most)) limit = min(limit, most)
      edit_distance = limit + 1
      if (abs(len(a) - len(b)) > limit) return
      rows = limit + 1
      rows(:, 0) = [(j, j=0, len(b))]
      do i = 1, len(a)
         current = mod(i, 3)
         previous = mod(i + 2, 3)
         before = mod(i + 1, 3)
         rows(:, current) = limit + 1
         if (i <= limit) rows(0, current) = i
         do j = max(1, i - limit), min(len(b), i + limit)
            cost = 1
            if (a(i:i) == b(j:j)) cost = 0
            edit_distance = min(rows(j, previous) + 1, rows(j - 1, current) + 1, &
               rows(j - 1, previous) + cost)
            if (i > 1 .and. j > 1) then
               if (a(i:i) == b(j - 1:j - 1) .and. a(i - 1:i - 1) == b(j:j)) then
                  edit_distance = min(edit_distance, rows(j - 2, before) + 1)
               end if
            end if
            rows(j, current) = edit_distance
         end do
         edit_distance = limit + 1
         if (minval(rows(:, current)) > limit .and. minval(rows(:, previous)) > limit) return
      end do
      edit_distance = rows(len(b), mod(len(a), 3))
   end function edit_distance

   !> End of a message about an unknown word: `; did you mean 'x'?` if a candidate is near.
   pure function did_you_mean(word, candidates, otherwise) result(text)
      !> Word as the user wrote it.
      character(len=*), intent(in) :: word
      !> Known words; trailing blanks do not count.
      character(len=*), intent(in) :: candidates(:)
      !> What follows the semicolon if none is near.
      character(len=*), intent(in) :: otherwise
      character(len=:), allocatable :: text
      integer :: i

      i = nearest(word, candidates)
      text = "; " // otherwise
      if (i > 0) text = "; did you mean " // quote(trim(candidates(i))) // "?"
   end function did_you_mean

   !> Index of the candidate nearest to a word, 0 if none is near.
   pure function nearest_character(word, candidates) result(best)
      !> Word as the user wrote it; case does not matter.
      character(len=*), intent(in) :: word
      !> Known words; trailing blanks do not count.
      character(len=*), intent(in) :: candidates(:)
      !> Index of the nearest candidate or 0.
      integer :: best
      type(string_type), allocatable :: list(:)
      integer :: i

      allocate(list(size(candidates)))
      do i = 1, size(candidates)
         list(i)%s = trim(candidates(i))
      end do
      best = nearest_string(word, list)
   end function nearest_character

   !> Index of the candidate nearest to a word, 0 if none is near.
   !>
   !> Near means an edit distance of at most a third of the word's length (but 1 is always
   !> allowed); failing that, a candidate that begins with the word, then one that contains it.
   pure function nearest_string(word, candidates) result(best)
      !> Word as the user wrote it; case does not matter.
      character(len=*), intent(in) :: word
      !> Known words.
      type(string_type), intent(in) :: candidates(:)
      !> Index of the nearest candidate or 0.
      integer :: best
      integer :: containing, i, shortest, starting

      best = 0
      starting = 0
      containing = 0
      shortest = min(max(1, len_trim(word)/3) + 1, len_trim(word))
      do i = 1, size(candidates)
         if (allocated(candidates(i)%s)) call consider(lower(trim(word)), &
            lower(candidates(i)%s), i, shortest, best, starting, containing)
      end do
      if (best == 0) best = starting
      if (best == 0) best = containing
   end function nearest_string

   !> Consider a candidate for the nearest word.
   pure subroutine consider(sought, candidate, index_of_it, shortest, best, starting, containing)
      !> The word and the candidate, in lower case.
      character(len=*), intent(in) :: sought, candidate
      !> Index of the candidate.
      integer, intent(in) :: index_of_it
      !> Smallest edit distance so far; only smaller ones count.
      integer, intent(inout) :: shortest
      !> Index of the candidate that has it; 0 for none.
      integer, intent(inout) :: best
      !> Index of the first candidate that begins with the word, and that contains it; 0 for none.
      integer, intent(inout) :: starting, containing
      integer :: distance

      distance = edit_distance(sought, candidate, shortest - 1)
      if (distance < shortest) then
         shortest = distance
         best = index_of_it
      end if
      if (len(sought) < shortest_part) return
      if (starting == 0 .and. starts_with(candidate, sought)) starting = index_of_it
      if (containing == 0 .and. index(candidate, sought) > 0) containing = index_of_it
   end subroutine consider

end module contensou_base_text
