!> A place that moves over the lines of a text in namelist syntax: what stands there, what comes
!> next, and how mistakes found there are told.
module contensou_base_scanner
   use contensou_base_diagnostics, only : diagnostics_type, origin_type
   use contensou_base_numbers, only : to_text
   use contensou_base_text, only : invalid_byte, invalid_byte_text, starts_with, string_type
   implicit none(type, external)
   private

   public :: parser_type
   public :: max_bytes, max_groups, max_assignments, max_values, max_characters, word_width
   public :: newline, blanks, quotes, digits, letters
   public :: split_lines, at_end, here, peek, peek_next, char_at, shown_character
   public :: skip_blanks, skip_space, word_end, is_name, is_key, is_key_at, key_follows, key_ends
   public :: mistake, give_up, lose_line, foreign_comment, parse_continuation, in_utf8

   !> State of the reading of one source.
   type :: parser_type
      !> Lines of the source.
      type(string_type), allocatable :: lines(:)
      !> Index of the source in the document.
      integer :: source = 1
      !> Line of the next character.
      integer :: line = 1
      !> Column of the next character; beyond the end of the line stands the line end.
      integer :: column = 1
      !> Mistakes so far.
      type(diagnostics_type) :: diagnostics
      !> Whether a list of values is read, not a file.
      logical :: list_only = .false.
      !> Whether texts in that list may go without quotes.
      logical :: bare_text = .false.
      !> Whether mistakes follow from one that is reported already.
      logical :: quiet = .false.
      !> Whether a part of a line was skipped that may have held the end of the group.
      logical :: lost_end = .false.
      !> Whether reading was given up because the source is too large.
      logical :: stopped = .false.
      !> Number of mistakes, reported or not.
      integer :: n_mistakes = 0
      !> Number of groups read.
      integer :: n_groups = 0
      !> Number of assignments read.
      integer :: n_assignments = 0
      !> Number of values read.
      integer :: n_values = 0
      !> Number of characters in these values.
      integer :: n_characters = 0
      !> Names of the constants of the file, in lower case.
      type(string_type), allocatable :: constants(:)
      !> Whether the group that is read gives constants.
      logical :: in_constants = .false.
      !> Name of the group that ended last.
      character(len=:), allocatable :: last_group
      !> Line in which it ended.
      integer :: last_line = 0
   end type parser_type

   !> Largest file that is read [bytes].
   integer, parameter :: max_bytes = 16*1024*1024

   !> Largest number of lines in a source.
   integer, parameter :: max_lines = 1000000

   !> Largest number of groups in a source.
   integer, parameter :: max_groups = 100000

   !> Largest number of assignments in a source.
   integer, parameter :: max_assignments = 1000000

   !> Largest number of values in a source, largest repeat count, and largest subscript.
   integer, parameter :: max_values = 1000000

   !> Largest number of characters in all values of a source.
   integer, parameter :: max_characters = 2*max_bytes

   !> Number of bytes of a word that a message shows.
   integer, parameter :: word_width = 40

   !> What is right where a byte is not UTF-8.
   character(len=*), parameter :: in_utf8 = &
      "text in UTF-8; iconv -f latin1 -t utf-8 OLD > NEW converts a file from Latin-1"

   !> Line end.
   character(len=1), parameter :: newline = achar(10)

   !> Characters that count as a blank: blank, tab, vertical tab, form feed, carriage return.
   character(len=*), parameter :: blanks = " " // achar(9) // achar(11) // achar(12) // achar(13)

   !> Both quotes.
   character(len=*), parameter :: quotes = '''"'

   !> Decimal digits.
   character(len=*), parameter :: digits = "0123456789"

   !> Letters that names are made of.
   character(len=*), parameter :: letters = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"

   !> Characters that end a word.
   character(len=*), parameter :: stops = blanks // quotes // ",;/!=&()"

contains

   !> Cut a text into lines; a byte order mark and carriage returns at line ends are dropped.
   pure subroutine split_lines(parser, text)
      !> Parser that gets the lines.
      type(parser_type), intent(inout) :: parser
      character(len=*), intent(in) :: text
      character(len=*), parameter :: byte_order_mark = char(239) // char(187) // char(191)
      integer :: first, i, last, n, start

      start = 1
      if (starts_with(text, byte_order_mark)) start = len(byte_order_mark) + 1
      n = 1
      do i = start, len(text)
         if (text(i:i) == newline .and. i < len(text)) n = n + 1
      end do
      if (n > max_lines) then
         call mistake(parser, origin_type(source=parser%source, length=0), &
            "more than " // to_text(max_lines) // " lines")
         parser%stopped = .true.
         parser%quiet = .true.
         n = 0
      end if
      allocate(parser%lines(n))
      first = start
      do i = 1, n
         last = index(text(first:), newline)
         if (last == 0) then
            last = len(text)
         else
            last = first + last - 2
         end if
         start = last + 2
         if (last >= first) then
            if (text(last:last) == achar(13)) last = last - 1
         end if
         parser%lines(i)%s = text(first:last)
         first = start
      end do
      call check_bytes(parser)
   end subroutine split_lines

   !> Refuse lines that are not UTF-8: the first byte is reported, and nothing else is read.
   pure subroutine check_bytes(parser)
      type(parser_type), intent(inout) :: parser
      integer :: i, bad

      do i = 1, size(parser%lines)
         bad = invalid_byte(parser%lines(i)%s)
         if (bad == 0) cycle
         call mistake(parser, origin_type(source=parser%source, line=i, column=bad, length=1), &
            invalid_byte_text(parser%lines(i)%s(bad:bad)), in_utf8)
         parser%stopped = .true.
         parser%quiet = .true.
         parser%line = size(parser%lines) + 1
         return
      end do
   end subroutine check_bytes

   !> Whether all was read.
   pure logical function at_end(parser)
      type(parser_type), intent(in) :: parser

      at_end = parser%line > size(parser%lines)
   end function at_end

   !> Place of the next character.
   pure function here(parser, length) result(origin)
      type(parser_type), intent(in) :: parser
      !> Number of bytes that the place takes.
      integer, intent(in) :: length
      type(origin_type) :: origin

      origin = origin_type(source=parser%source, line=parser%line, column=parser%column, &
         length=length)
   end function here

   !> The next character; a line end at the end of each line.
   pure function peek(parser) result(c)
      type(parser_type), intent(in) :: parser
      character(len=1) :: c

      c = char_at(parser%lines, parser%line, parser%column)
   end function peek

   !> The character after the next.
   pure function peek_next(parser) result(c)
      type(parser_type), intent(in) :: parser
      character(len=1) :: c

      c = char_at(parser%lines, parser%line, parser%column + 1)
   end function peek_next

   !> The character at a place; a line end beyond the end of a line or of the text.
   pure function char_at(lines, line, column) result(c)
      !> Lines of the text.
      type(string_type), intent(in) :: lines(:)
      !> Line of the character.
      integer, intent(in) :: line
      integer, intent(in) :: column
      character(len=1) :: c

      c = newline
      if (line > size(lines)) return
      if (column > len(lines(line)%s)) return
      c = lines(line)%s(column:column)
   end function char_at

   !> The next character as a message shows it, with all its bytes.
   pure function shown_character(parser) result(shown)
      type(parser_type), intent(in) :: parser
      character(len=:), allocatable :: shown
      integer :: last

      last = parser%column
      do while (iand(ichar(char_at(parser%lines, parser%line, last + 1)), 192) == 128)
         last = last + 1
      end do
      shown = parser%lines(parser%line)%s(parser%column:last)
   end function shown_character

   !> Skip blanks within the line.
   pure subroutine skip_blanks(parser)
      type(parser_type), intent(inout) :: parser

      do while (scan(peek(parser), blanks) > 0)
         parser%column = parser%column + 1
      end do
   end subroutine skip_blanks

   !> Skip blanks, line ends and comments.
   pure subroutine skip_space(parser)
      type(parser_type), intent(inout) :: parser

      call skip_over(parser%lines, parser%line, parser%column)
   end subroutine skip_space

   !> Move a place over blanks, line ends and comments.
   pure subroutine skip_over(lines, line, column)
      !> Lines of the text.
      type(string_type), intent(in) :: lines(:)
      !> Line of the place.
      integer, intent(inout) :: line
      !> Column of the place.
      integer, intent(inout) :: column
      integer :: n

      do while (line <= size(lines))
         if (column <= len(lines(line)%s)) then
            n = verify(lines(line)%s(column:), blanks)
            if (n > 0) then
               column = column + n - 1
               if (lines(line)%s(column:column) /= "!") return
            end if
         end if
         line = line + 1
         column = 1
      end do
   end subroutine skip_over

   !> Last column of the word that begins at a column; the column before it if there is none.
   pure function word_end(parser, column) result(last)
      type(parser_type), intent(in) :: parser
      !> Column in the present line.
      integer, intent(in) :: column
      !> Last column.
      integer :: last

      last = column - 1
      if (parser%line > size(parser%lines)) return
      last = word_end_at(parser%lines(parser%line)%s, column)
   end function word_end

   !> Last column of the word that begins at a column; the column before it if there is none.
   pure function word_end_at(line, column) result(last)
      character(len=*), intent(in) :: line
      integer, intent(in) :: column
      !> Last column.
      integer :: last
      integer :: n

      n = scan(line(column:), stops)
      last = len(line)
      if (n > 0) last = column + n - 2
      if (column > len(line)) last = column - 1
   end function word_end_at

   !> Whether a word is a legal name.
   pure logical function is_name(word)
      !> Word to look at.
      character(len=*), intent(in) :: word

      is_name = .false.
      if (len(word) == 0) return
      is_name = scan(word(1:1), letters) == 1 .and. verify(word, letters // digits // "_") == 0
   end function is_name

   !> Whether a key and its equals sign come next.
   pure logical function is_key(parser)
      type(parser_type), intent(in) :: parser

      is_key = is_key_at(parser%lines, parser%line, parser%column)
   end function is_key

   !> Whether a key and its equals sign stand at a place.
   !>
   !> Any word counts as key here: whether it is a good one is checked when it is read. Between
   !> the two may stand a subscript, and a colon may stand for the equals sign.
   pure logical function is_key_at(lines, line, column)
      !> Lines of the text.
      type(string_type), intent(in) :: lines(:)
      !> Line of the place.
      integer, intent(in) :: line
      !> Column of the place.
      integer, intent(in) :: column
      character(len=1) :: c
      integer :: c_last, c_line, last, n

      is_key_at = .false.
      if (line > size(lines)) return
      last = word_end_at(lines(line)%s, column)
      if (last < column) return
      if (lines(line)%s(last:last) == ":" .and. is_name(lines(line)%s(column:last - 1))) then
         is_key_at = scan(char_at(lines, line, last + 1), blanks // newline // "=") > 0
         return
      end if

      c_line = line
      c_last = last + 1
      call skip_over(lines, c_line, c_last)
      c = char_at(lines, c_line, c_last)
      ! What ends with an operator is no key but an expression.
      if (c == "(" .and. scan(lines(line)%s(last:last), "*+-") > 0) return
      if (c == "(" .and. c_line == line) then
         n = scan(lines(line)%s(c_last + 1:), ")(=!/&" // quotes)
         if (n == 0) return
         c = lines(line)%s(c_last + n:c_last + n)
         c_last = c_last + n
         if (c == "=") then
            ! The parenthesis is not closed, which is reported when the subscript is read.
            is_key_at = .true.
            return
         end if
         if (c /= ")") return
         c_last = c_last + 1
         call skip_over(lines, c_line, c_last)
         c = char_at(lines, c_line, c_last)
         if (c == "%") then
            is_key_at = .true.
            return
         end if
      end if
      is_key_at = c == "="
      if (c == ":") is_key_at = char_at(lines, c_line, c_last + 1) == "="
   end function is_key_at

   !> Whether a key and its equals sign follow a column.
   pure logical function key_follows(parser, column)
      type(parser_type), intent(in) :: parser
      !> Column in the present line.
      integer, intent(in) :: column
      integer :: c, line

      line = parser%line
      c = column
      call skip_over(parser%lines, line, c)
      key_follows = is_key_at(parser%lines, line, c)
   end function key_follows

   !> Whether an equals sign follows, possibly after blanks, line ends and comments.
   pure logical function key_ends(parser)
      type(parser_type), intent(in) :: parser
      integer :: column, line

      line = parser%line
      column = parser%column
      call skip_over(parser%lines, line, column)
      key_ends = char_at(parser%lines, line, column) == "="
   end function key_ends

   !> Report a mistake, unless it follows from another.
   pure subroutine mistake(parser, origin, message, expected)
      type(parser_type), intent(inout) :: parser
      type(origin_type), intent(in) :: origin
      character(len=*), intent(in) :: message
      character(len=*), intent(in), optional :: expected

      parser%n_mistakes = parser%n_mistakes + 1
      if (.not. parser%quiet) call parser%diagnostics%add(origin, message, expected)
   end subroutine mistake

   !> Report that there is too much of something and give up reading.
   pure subroutine give_up(parser, origin, message)
      type(parser_type), intent(inout) :: parser
      type(origin_type), intent(in) :: origin
      !> What there is too much of.
      character(len=*), intent(in) :: message

      parser%quiet = parser%stopped
      call mistake(parser, origin, message, "less of it in one file")
      parser%stopped = .true.
      parser%quiet = .true.
      parser%line = size(parser%lines) + 1
      parser%column = 1
   end subroutine give_up

   !> Skip the rest of a line in which it is no longer clear what is text and what is not.
   !>
   !> If the line ends with a slash, that is taken for the end of the group.
   pure subroutine lose_line(parser)
      type(parser_type), intent(inout) :: parser
      integer :: comment, first, last

      first = parser%column
      associate (line => parser%lines(parser%line))
         comment = scan(line%s(first:), "!")
         last = len(line%s)
         if (comment > 0) last = first + comment - 2
         last = first - 1 + verify(line%s(first:last), blanks, back=.true.)
         parser%column = len(line%s) + 1
         if (last >= first) then
            if (line%s(last:last) == "/" .and. .not. parser%list_only) then
               parser%column = last
               return
            end if
         end if
         if (scan(line%s(first:), "/") > 0) parser%lost_end = .true.
      end associate
   end subroutine lose_line

   !> Report a comment in the manner of other languages and skip it.
   pure subroutine foreign_comment(parser, found)
      type(parser_type), intent(inout) :: parser
      !> Whether there was one.
      logical, intent(out) :: found

      found = peek(parser) == "#"
      if (.not. found) return
      call mistake(parser, here(parser, 1), "'#' does not begin a comment", "'!'")
      call lose_line(parser)
   end subroutine foreign_comment

   !> Report an ampersand that begins no group.
   pure subroutine parse_continuation(parser)
      type(parser_type), intent(inout) :: parser

      call mistake(parser, here(parser, 1), "unexpected '&'", &
         "nothing here: values go on in the next line by themselves")
      parser%column = parser%column + 1
   end subroutine parse_continuation

end module contensou_base_scanner
