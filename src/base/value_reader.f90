!> Reader of the values that follow the equals sign of a key: numbers, logicals, texts, repeat
!> counts, and words that are none of these.
module contensou_base_value_reader
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite, ieee_is_nan
   use contensou_base_diagnostics, only : origin_type
   use contensou_base_document_types, only : value_expression, value_integer, value_logical, &
      value_real, value_text, value_type
   use contensou_base_expressions, only : is_expression
   use contensou_base_kinds, only : i8
   use contensou_base_misprints, only : explain_misprint, explain_unit
   use contensou_base_numbers, only : read_real, to_text
   use contensou_base_scanner, only : at_end, blanks, char_at, digits, foreign_comment, give_up, &
      here, is_key, is_key_at, is_name, letters, lose_line, max_characters, max_values, mistake, &
      newline, parse_continuation, parser_type, peek, peek_next, quotes, shown_character, &
      skip_space, word_end, word_width
   use contensou_base_text, only : lower, nearest, quote, shorten
   implicit none(type, external)
   private

   public :: parse_values, discard_values, read_count

   !> What is not a value.
   integer, parameter :: form_none = 0

   !> What is a value.
   integer, parameter :: form_value = 1

   !> What is a number too large for double precision.
   integer, parameter :: form_overflow = 2

contains

   !> Read values up to the next key, the end of the group, or an equals sign.
   pure subroutine parse_values(parser, buffer, n)
      type(parser_type), intent(inout) :: parser
      !> The values; its size is at least `n`.
      type(value_type), allocatable, intent(inout) :: buffer(:)
      !> Number of values.
      integer, intent(out) :: n
      type(value_type) :: missing
      logical :: after_comma, found, has_value
      integer :: column, line

      n = 0
      has_value = .false.
      after_comma = .false.
      do
         call skip_space(parser)
         if (at_end(parser)) exit
         line = parser%line
         column = parser%column
         select case (peek(parser))
         case (",", ";")
            if (peek(parser) == ";") then
               call mistake(parser, here(parser, 1), &
                  "';' does not separate values", "a comma or a blank")
            end if
            if (.not. has_value) then
               missing%origin = here(parser, 1)
               call append_value(parser, missing, 1, buffer, n)
            end if
            has_value = .false.
            after_comma = .true.
            parser%column = parser%column + 1
            cycle
         case ("/")
            if (parser%bare_text) then
               call parse_token(parser, buffer, n, has_value, after_comma, found)
            else if (.not. after_comma .and. .not. has_value &
               .and. scan(peek_next(parser), letters // digits // "._~") > 0) then
               call report_word(parser, "")
            else
               exit
            end if
         case ("&")
            if (scan(peek_next(parser), letters // digits // "_") > 0) exit
            call parse_continuation(parser)
            cycle
         case ("=")
            if (has_value .or. after_comma .or. parser%list_only) exit
            call mistake(parser, here(parser, 1), "second '='", "one '='")
            parser%column = parser%column + 1
            cycle
         case ("'", '"')
            call parse_text(parser, 1, column, buffer, n)
         case default
            if (.not. parser%bare_text) then
               if (is_key(parser)) exit
            end if
            call foreign_comment(parser, found)
            if (found) cycle
            call parse_token(parser, buffer, n, has_value, after_comma, found)
            if (.not. found) exit
         end select
         has_value = .true.
         if (parser%line == line .and. parser%column == column) parser%column = column + 1
      end do
   end subroutine parse_values

   !> Read values that belong to a mistake reported already.
   pure subroutine discard_values(parser, buffer)
      type(parser_type), intent(inout) :: parser
      type(value_type), allocatable, intent(inout) :: buffer(:)
      logical :: was_quiet
      integer :: n

      was_quiet = parser%quiet
      parser%quiet = .true.
      do
         call parse_values(parser, buffer, n)
         if (at_end(parser) .or. peek(parser) /= "=") exit
         parser%column = parser%column + 1
      end do
      parser%quiet = was_quiet .or. parser%stopped
   end subroutine discard_values

   !> Read a value that is not in quotes, or report what stands in its place.
   pure subroutine parse_token(parser, buffer, n, after_value, after_comma, found)
      type(parser_type), intent(inout) :: parser
      !> The values read so far.
      type(value_type), allocatable, intent(inout) :: buffer(:)
      !> Number of values.
      integer, intent(inout) :: n
      !> Whether a value went before, with no comma behind it.
      logical, intent(in) :: after_value
      !> Whether a comma went before.
      logical, intent(in) :: after_comma
      !> False if this is a key without equals sign, which is left for others to read.
      logical, intent(out) :: found
      type(value_type) :: value
      character(len=:), allocatable :: word, number
      integer :: count, first, form, last, star, start

      found = .true.
      first = parser%column
      last = word_end(parser, first)
      word = parser%lines(parser%line)%s(first:last)
      call parse_expression(parser, last, buffer, n, found)
      if (found) return
      found = .true.

      number = ""
      ! A unit is no text of its own.
      if (after_value .and. n > 0 .and. len(word) > 0) number = number_before(parser, buffer(n))
      if (parser%bare_text .and. number == "") then
         call value_of(word, value, form)
         if (form == form_none .and. may_be_bare(parser)) then
            call parse_bare_text(parser, buffer, n)
            return
         end if
      end if
      if (len(word) == 0) then
         call report_parenthesis(parser)
         return
      end if

      ! A repeat count.
      count = 1
      start = first
      star = verify(word, digits)
      if (star > 1) then
         if (word(star:star) == "*") then
            start = first + star
            count = read_count(word(1:star - 1))
            if (count == 0) then
               call mistake(parser, here(parser, star), "bad repeat count '" // &
                  shorten(word(1:star - 1), word_width) // "'", &
                  "a number from 1 to " // to_text(max_values))
            end if
            word = word(star + 1:)
            if (len(word) == 0) then
               parser%column = start
               if (scan(peek(parser), quotes) > 0) then
                  call parse_text(parser, count, first, buffer, n)
               else
                  parser%column = first
                  value%origin = here(parser, start - first)
                  parser%column = start
                  call append_value(parser, value, count, buffer, n)
               end if
               return
            end if
         end if
      end if

      call value_of(word, value, form)
      if (form == form_value .and. ieee_is_nan(value%real)) call extend_nan(parser, last)
      select case (form)
      case (form_value)
         value%origin = here(parser, last - first + 1)
         parser%column = last + 1
         if (scan(peek(parser), quotes // "(") > 0) then
            call mistake(parser, here(parser, 1), "unexpected '" // &
               peek(parser) // "' after '" // shorten(word, word_width) // "'", &
               "a comma or a blank between values")
            call lose_line(parser)
         end if
         call append_value(parser, value, count, buffer, n)
      case (form_overflow)
         parser%column = start
         call mistake(parser, here(parser, last - start + 1), "'" // &
            shorten(word, word_width) // "' is too large for double precision", &
            "a magnitude below 1.8e308")
         parser%column = last + 1
      case default
         if (start == first .and. .not. parser%list_only .and. (n > 0 .or. after_comma)) then
            if (is_name(word) .and. value_follows(parser, last + 1)) then
               found = .false.
               return
            end if
         end if
         parser%column = start
         call report_word(parser, number)
      end select
   end subroutine parse_token

   !> Read an expression without quotes, such as `2*m`, `30 deg` or `(r+1)/2`: what is neither a
   !> value nor one with a repeat count. It has no blanks but in parentheses, on both sides of
   !> + - * ** and between a number and its unit; a slash that is directly followed by an operand
   !> divides.
   pure subroutine parse_expression(parser, last, buffer, n, found)
      type(parser_type), intent(inout) :: parser
      !> Last column of the word that comes next.
      integer, intent(in) :: last
      !> The values read so far.
      type(value_type), allocatable, intent(inout) :: buffer(:)
      !> Number of values.
      integer, intent(inout) :: n
      !> Whether there is one; if not, nothing is read.
      logical, intent(out) :: found
      type(value_type) :: value
      integer :: end, first, form, star
      logical :: longer

      found = .false.
      first = parser%column
      longer = goes_on(parser, last)
      associate (word => parser%lines(parser%line)%s(first:last))
         if (.not. longer) then
            call value_of(word, value, form)
            if (form /= form_none) return
            star = verify(word, digits)
            if (star > 1) then
               if (word(star:star) == "*") then
                  if (star == len(word)) return
                  call value_of(word(star + 1:), value, form)
                  if (form /= form_none) return
               end if
            end if
         end if
      end associate
      end = expression_end(parser, first)
      if (end < first) return
      associate (text => parser%lines(parser%line)%s(first:end))
         found = is_expression(text, parser%constants)
         if (.not. found .and. parser%in_constants) found = is_name(text)
         if (found .and. parser%bare_text) found = .not. (may_be_bare(parser) .and. &
            goes_on_as_text(parser, end))
         if (.not. found) return
         value%kind = value_expression
         value%text = text
      end associate
      value%origin = here(parser, end - first + 1)
      parser%column = end + 1
      call append_value(parser, value, 1, buffer, n)
   end subroutine parse_expression

   !> Whether an expression goes on behind a column that ends a word.
   pure logical function goes_on(parser, column)
      type(parser_type), intent(in) :: parser
      integer, intent(in) :: column
      integer :: next

      next = column + 1
      select case (char_at(parser%lines, parser%line, next))
      case ("/")
         goes_on = divides(parser, next)
      case ("(")
         goes_on = .true.
      case (" ")
         goes_on = operator_follows(parser, next) > 0 .or. unit_follows(parser, next) > 0
      case default
         goes_on = .false.
      end select
   end function goes_on

   !> Whether a slash divides and does not end the group: an operand directly follows it, and
   !> something directly goes before it.
   pure logical function divides(parser, column)
      type(parser_type), intent(in) :: parser
      !> Where the slash stands.
      integer, intent(in) :: column

      divides = scan(char_at(parser%lines, parser%line, column + 1), letters // digits // ".(") > 0
      if (divides .and. column > 1) divides = scan(char_at(parser%lines, parser%line, column - 1), &
         blanks) == 0
   end function divides

   !> Column behind an operator that has blanks on both sides; 0 if there is none.
   pure integer function operator_follows(parser, column) result(next)
      type(parser_type), intent(in) :: parser
      !> Where the blanks begin.
      integer, intent(in) :: column
      integer :: k

      next = 0
      associate (line => parser%lines(parser%line)%s)
         k = verify(line(column:), blanks)
         if (k < 2) return
         k = column + k - 1
         if (scan(line(k:k), "+-*") == 0) return
         if (k + 2 <= len(line)) then
            if (line(k:k + 1) == "**") k = k + 1
         end if
         if (scan(char_at(parser%lines, parser%line, k + 1), blanks) > 0) next = k + 1
      end associate
   end function operator_follows

   !> Column behind the unit of an angle that blanks divide from its number; 0 if there is none.
   pure integer function unit_follows(parser, column) result(next)
      type(parser_type), intent(in) :: parser
      !> Where the blanks begin.
      integer, intent(in) :: column
      character(len=*), parameter :: unit = "deg"
      integer :: first, k

      next = 0
      associate (line => parser%lines(parser%line)%s)
         if (column < 2) return
         first = verify(line(:column - 1), letters // digits // "_.", back=.true.) + 1
         if (scan(line(first:first), digits // ".") == 0) return
         k = verify(line(column:), blanks)
         if (k < 2) return
         k = column + k - 1
         if (k + len(unit) - 1 > len(line)) return
         if (lower(line(k:k + len(unit) - 1)) /= unit) return
         k = k + len(unit)
         if (scan(char_at(parser%lines, parser%line, k), letters // digits // "_.(=") == 0) next = k
      end associate
   end function unit_follows

   !> Whether more than blanks follows before the next comma.
   pure logical function goes_on_as_text(parser, column)
      type(parser_type), intent(in) :: parser
      !> Last column before it.
      integer, intent(in) :: column
      integer :: n

      associate (line => parser%lines(parser%line)%s)
         n = verify(line(column + 1:), blanks)
         goes_on_as_text = n > 0
         if (n > 0) goes_on_as_text = line(column + n:column + n) /= ","
      end associate
   end function goes_on_as_text

   !> Last column of what may be an expression; the column before it if there is nothing.
   pure integer function expression_end(parser, first) result(last)
      type(parser_type), intent(in) :: parser
      integer, intent(in) :: first
      integer :: column, depth, next

      last = first - 1
      depth = 0
      column = first
      associate (line => parser%lines(parser%line)%s)
         do while (column <= len(line))
            select case (line(column:column))
            case ("(")
               depth = depth + 1
            case (")")
               depth = depth - 1
               if (depth < 0) return
            case (",")
               if (depth == 0) return
            case ("/")
               if (depth == 0 .and. .not. parser%list_only) then
                  if (.not. divides(parser, column)) return
               end if
            case ("'", '"', ";", "!", "=", "&")
               return
            case (" ", achar(9), achar(13))
               if (depth == 0) then
                  next = unit_follows(parser, column)
                  if (next > 0) then
                     last = next - 1
                     column = next
                     cycle
                  end if
                  next = operator_follows(parser, column)
                  if (next == 0) return
                  next = next + verify(line(next:) // ".", blanks) - 1
                  column = next - 1
               end if
            case default
               continue
            end select
            if (scan(line(column:column), blanks) == 0) last = column
            column = column + 1
         end do
         ! A parenthesis that is not closed does not hold the end of the group.
         if (last < max(first, 2) .or. depth == 0) return
         if (line(last:last) == "/" .and. scan(line(last - 1:last - 1), blanks) > 0) then
            last = first - 1 + len_trim(line(first:last - 1))
         end if
      end associate
   end function expression_end

   !> The number before the next word in the same line, as it stands there; empty if there is none.
   pure function number_before(parser, value) result(number)
      type(parser_type), intent(in) :: parser
      !> The value before that word.
      type(value_type), intent(in) :: value
      character(len=:), allocatable :: number

      number = ""
      if (value%kind /= value_integer .and. value%kind /= value_real) return
      associate (origin => value%origin)
         if (origin%line /= parser%line .or. origin%source /= parser%source) return
         number = parser%lines(origin%line)%s(origin%column:origin%column + origin%length - 1)
      end associate
   end function number_before

   !> Extend the last column of `nan` by a bracket directly behind it.
   pure subroutine extend_nan(parser, last)
      type(parser_type), intent(in) :: parser
      !> Last column of the word.
      integer, intent(inout) :: last
      integer :: n

      associate (line => parser%lines(parser%line))
         if (char_at(parser%lines, parser%line, last + 1) /= "(") return
         n = verify(line%s(last + 2:), letters // digits // "_")
         if (n == 0) return
         if (line%s(last + 1 + n:last + 1 + n) == ")") last = last + 1 + n
      end associate
   end subroutine extend_nan

   !> Whether a number, or a text in quotes, follows in the line with no comma before it.
   pure logical function value_follows(parser, column)
      type(parser_type), intent(in) :: parser
      !> Column from which on to look.
      integer, intent(in) :: column
      integer :: n

      value_follows = .false.
      associate (line => parser%lines(parser%line))
         n = verify(line%s(column:), blanks)
         if (n < 2) return
         value_follows = scan(line%s(column + n - 1:column + n - 1), digits // quotes // "+-.") > 0
      end associate
   end function value_follows

   !> Whether a value without quotes may be meant as a text.
   pure logical function may_be_bare(parser)
      type(parser_type), intent(in) :: parser

      ! What begins like a number shall be one, so that a misprint in it is found.
      may_be_bare = scan(peek(parser), digits // "+-") == 0
      if (peek(parser) == ".") may_be_bare = scan(peek_next(parser), digits) == 0
   end function may_be_bare

   !> Read a text without quotes up to the next comma.
   pure subroutine parse_bare_text(parser, buffer, n)
      type(parser_type), intent(inout) :: parser
      !> The values read so far.
      type(value_type), allocatable, intent(inout) :: buffer(:)
      !> Number of values.
      integer, intent(inout) :: n
      type(value_type) :: value
      integer :: first, last

      first = parser%column
      associate (line => parser%lines(parser%line))
         last = scan(line%s(first:), ",")
         if (last == 0) then
            last = len(line%s)
         else
            last = first + last - 2
         end if
         last = first - 1 + verify(line%s(first:last), blanks, back=.true.)
         value%kind = value_text
         value%text = line%s(first:last)
      end associate
      value%origin = here(parser, last - first + 1)
      parser%column = last + 1
      call append_value(parser, value, 1, buffer, n)
   end subroutine parse_bare_text

   !> Read a text in quotes.
   pure subroutine parse_text(parser, count, start, buffer, n)
      !> State of the reading, at the opening quote.
      type(parser_type), intent(inout) :: parser
      !> Number of times that the value stands for.
      integer, intent(in) :: count
      !> Column at which the value begins; before the quote if there is a repeat count.
      integer, intent(in) :: start
      !> The values read so far.
      type(value_type), allocatable, intent(inout) :: buffer(:)
      !> Number of values.
      integer, intent(inout) :: n
      type(value_type) :: value
      character(len=1) :: delimiter
      integer :: first, i, length, n_double

      first = parser%column
      delimiter = peek(parser)
      n_double = 0
      associate (line => parser%lines(parser%line))
         length = len(line%s)
         i = first + 1
         do while (i <= length)
            if (line%s(i:i) == delimiter) then
               if (i == length) exit
               if (line%s(i + 1:i + 1) /= delimiter) exit
               n_double = n_double + 1
               i = i + 1
            end if
            i = i + 1
         end do
      end associate
      if (i > length) then
         call mistake(parser, here(parser, 1), "text is not closed in its line", &
            "a closing " // delimiter)
         call lose_line(parser)
         return
      end if

      parser%column = i + 1
      if (scan(peek(parser), blanks // ",;/!&" // newline) == 0) then
         if (peek(parser) /= "=" .or. .not. parser%quiet) then
            call mistake(parser, here(parser, 1), &
               "text is directly followed by '" // shown_character(parser) // "'", &
               "a comma or a blank; a quote inside a text is written twice")
            call lose_line(parser)
            return
         end if
      end if

      value%kind = value_text
      value%origin = origin_type(source=parser%source, line=parser%line, column=start, &
         length=i - start + 1)
      call unquote(parser%lines(parser%line)%s(first + 1:i - 1), delimiter, n_double, value%text)
      call append_value(parser, value, count, buffer, n)
   end subroutine parse_text

   !> Text with doubled quotes made single.
   pure subroutine unquote(s, delimiter, n_double, text)
      !> What stands between the quotes.
      character(len=*), intent(in) :: s
      !> The kind of quote.
      character(len=1), intent(in) :: delimiter
      !> Number of doubled quotes.
      integer, intent(in) :: n_double
      character(len=:), allocatable, intent(out) :: text
      integer :: i, n

      allocate(character(len=len(s) - n_double) :: text)
      i = 1
      do n = 1, len(text)
         text(n:n) = s(i:i)
         if (s(i:i) == delimiter) i = i + 1
         i = i + 1
      end do
   end subroutine unquote

   !> Value of a word without quotes.
   pure subroutine value_of(word, value, form)
      character(len=*), intent(in) :: word
      !> Its value, without origin.
      type(value_type), intent(out) :: value
      !> Whether it is a value, one of the `form_*` parameters.
      integer, intent(out) :: form
      logical :: fits, valid

      form = form_none
      if (len(word) == 0) return
      if (len(word) <= len(".false.")) then
         select case (lower(word))
         case ("t", ".t", ".t.", "true", ".true", ".true.")
            form = form_value
            value%kind = value_logical
            value%logical = .true.
            return
         case ("f", ".f", ".f.", "false", ".false", ".false.")
            form = form_value
            value%kind = value_logical
            value%logical = .false.
            return
         case default
            continue
         end select
      end if

      call read_real(word, value%real, valid)
      if (.not. valid) return
      form = form_value
      value%kind = value_real
      if (verify(word(1:1), "+-" // digits) == 0 .and. verify(word(2:), digits) == 0) then
         call read_integer(word, value%integer, fits)
         if (fits) value%kind = value_integer
      end if
      if (ieee_is_nan(value%real)) return
      if (.not. ieee_is_finite(value%real) .and. scan(word, digits) > 0) form = form_overflow
   end subroutine value_of

   !> Integer of a text of digits with an optional sign.
   pure subroutine read_integer(s, x, fits)
      character(len=*), intent(in) :: s
      !> The integer; 0 if it does not fit.
      integer(i8), intent(out) :: x
      !> Whether it fits into eight bytes.
      logical, intent(out) :: fits
      integer(i8) :: digit
      integer :: i

      x = 0
      fits = .true.
      do i = 1, len(s)
         if (scan(s(i:i), digits) == 0) cycle
         digit = iachar(s(i:i)) - iachar("0")
         if (x > (huge(x) - digit)/10) then
            x = 0
            fits = .false.
            return
         end if
         x = 10*x + digit
      end do
      if (s(1:1) == "-") x = -x
   end subroutine read_integer

   !> Positive integer of a text.
   pure function read_count(s) result(n)
      character(len=*), intent(in) :: s
      !> The integer; 0 if the text is none or it is larger than `max_values`.
      integer :: n
      integer :: i

      n = 0
      if (verify(s, digits) > 0) return
      do i = 1, len(s)
         n = 10*n + iachar(s(i:i)) - iachar("0")
         if (n > max_values) then
            n = 0
            return
         end if
      end do
   end function read_count

   !> Put a value behind those that were read, as often as its repeat count says.
   pure subroutine append_value(parser, value, count, buffer, n)
      type(parser_type), intent(inout) :: parser
      type(value_type), intent(in) :: value
      !> Number of times to append it.
      integer, intent(in) :: count
      type(value_type), allocatable, intent(inout) :: buffer(:)
      !> Number of values.
      integer, intent(inout) :: n
      type(value_type), allocatable :: bigger(:)
      integer :: i, length

      if (parser%stopped .or. count == 0) return
      length = 0
      if (allocated(value%text)) length = len(value%text)
      if (count > max_values - parser%n_values) then
         call give_up(parser, value%origin, "more than " // to_text(max_values) // " values")
         return
      end if
      if (int(count, i8)*length > max_characters - parser%n_characters) then
         call give_up(parser, value%origin, &
            "more than " // to_text(max_characters) // " characters of text")
         return
      end if
      parser%n_values = parser%n_values + count
      parser%n_characters = parser%n_characters + count*length

      if (n + count > size(buffer)) then
         allocate(bigger(max(n + count, 2*size(buffer))))
         do i = 1, n
            bigger(i)%kind = buffer(i)%kind
            bigger(i)%real = buffer(i)%real
            bigger(i)%integer = buffer(i)%integer
            bigger(i)%logical = buffer(i)%logical
            bigger(i)%origin = buffer(i)%origin
            call move_alloc(buffer(i)%text, bigger(i)%text)
         end do
         call move_alloc(bigger, buffer)
      end if
      do i = n + 1, n + count
         buffer(i) = value
      end do
      n = n + count
   end subroutine append_value

   !> Report a word that is not a value and skip it, with the words that belong to it.
   pure subroutine report_word(parser, number)
      !> State of the reading, at the word.
      type(parser_type), intent(inout) :: parser
      !> The number directly before it; empty if there is none.
      character(len=*), intent(in) :: number
      character(len=:), allocatable :: expected, message, word
      type(origin_type) :: origin
      type(value_type) :: value
      integer :: column, first, form, last, near, next
      logical :: loses

      first = parser%column
      last = max(word_end(parser, first), first)
      if (peek(parser) == "/") last = max(word_end(parser, first + 1), first)
      loses = .false.
      associate (line => parser%lines(parser%line))
         do
            column = last + 1
            select case (char_at(parser%lines, parser%line, column))
            case ("/")
               ! A slash inside a word belongs to a path and does not end the group.
               if (scan(char_at(parser%lines, parser%line, column + 1), &
                  blanks // newline // "!&,") > 0) exit
               last = max(word_end(parser, column + 1), column)
            case ("(", ")")
               last = max(word_end(parser, column + 1), column)
            case ("'", '"')
               loses = .true.
               exit
            case default
               next = verify(line%s(column:), blanks)
               if (next < 2) exit
               next = column + next - 1
               if (scan(line%s(next:next), letters) == 0) exit
               if (is_key_at(parser%lines, parser%line, next)) exit
               call value_of(line%s(next:word_end(parser, next)), value, form)
               if (form /= form_none) exit
               last = word_end(parser, next)
            end select
         end do
         word = line%s(first:last)
      end associate

      call explain_misprint(word, message, expected)
      if (.not. allocated(message) .and. number /= "") call explain_unit(number, word, .false., &
         message, expected)
      if (allocated(message)) then
         continue
      else if (scan(word(1:1), digits) > 0 .or. &
         (scan(word(1:1), "+-.") > 0 .and. scan(word, digits) > 0 .and. &
         verify(word, "+-." // digits // "eEdD") == 0)) then
         message = "'" // shorten(word, word_width) // "' is not a number"
         expected = "a number such as 2, 0.5 or 1.0e-3, or a text in quotes"
      else if (word(1:1) == "." .and. scan(char_at(parser%lines, parser%line, first + 1), &
         "tTfF") > 0 .and. scan(word, "/") == 0) then
         message = "'" // shorten(word, word_width) // "' is not a logical"
         expected = ".true. or .false."
      else if (is_curly(word)) then
         message = "typographic quotes around a text"
         expected = 'straight quotes, '' or "'
         loses = .true.
      else if (any(lower(word) == [character(len=3) :: "yes", "no", "on", "off"])) then
         message = "'" // word // "' is not a logical"
         expected = ".true. or .false."
      else if (scan(word(1:1), letters // "_./~") > 0 .or. ichar(word(1:1)) > 127) then
         message = "text '" // shorten(word, word_width) // "' needs quotes"
         expected = quote(shorten(word, word_width))
         near = 0
         if (is_name(word)) near = nearest(word, parser%constants)
         if (near > 0) expected = expected // ", or the constant " // parser%constants(near)%s
      else
         message = "'" // shorten(word, word_width) // "' is not a value"
         expected = "a number, .true., .false., or a text in quotes"
      end if
      origin = here(parser, last - first + 1)
      call mistake(parser, origin, message, expected)
      parser%column = last + 1
      if (loses) call lose_line(parser)
   end subroutine report_word

   !> Whether a word begins with a quote from a word processor (U+2018 to U+201F), or with another
   !> character that is taken for one.
   pure logical function is_curly(word)
      !> Word to look at.
      character(len=*), intent(in) :: word

      is_curly = .false.
      if (len(word) < 2) return
      ! Accents and quotes of other languages, too.
      if (word(1:1) == char(194)) is_curly = scan(word(2:2), char(171) // char(187) // &
         char(180)) > 0
      if (word(1:1) == "`") is_curly = .true.
      if (is_curly .or. len(word) < 3) return
      is_curly = word(1:2) == char(226) // char(128) .and. &
         ichar(word(3:3)) >= 152 .and. ichar(word(3:3)) <= 159
   end function is_curly

   !> Report a parenthesis in the place of a value and skip to its end.
   pure subroutine report_parenthesis(parser)
      !> State of the reading, at the parenthesis.
      type(parser_type), intent(inout) :: parser
      type(origin_type) :: origin
      integer :: n

      associate (line => parser%lines(parser%line))
         n = 1
         if (peek(parser) == "(") then
            n = scan(line%s(parser%column + 1:), ")(=!/&" // quotes)
            if (n == 0) then
               n = 1
            else if (line%s(parser%column + n:parser%column + n) == ")") then
               n = n + 1
            else
               n = 1
            end if
         end if
         origin = here(parser, n)
         call mistake(parser, origin, "unexpected '" // &
            shorten(line%s(origin%column:origin%column + n - 1), word_width) // "'", &
            "values without parentheses")
      end associate
      parser%column = parser%column + n
   end subroutine report_parenthesis

end module contensou_base_value_reader
