!> Reader of the namelist syntax that keeps the place of everything it reads.
!>
!> The intrinsic namelist read says neither where a mistake is nor, mostly, which one; it stops
!> at the first, and leaves half-read values behind. This reader takes the same legal text,
!> `&name key = values, ... /`, knows nothing of the meaning of groups and keys, goes on after
!> a mistake, and tries to report each mistake once. It takes any sequence of bytes.
module contensou_base_document
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite, ieee_is_nan
   use contensou_base_diagnostics, only : diagnostics_type, origin_type, source_type
   use contensou_base_errors, only : error_type, fatal, status_file, status_usage
   use contensou_base_kinds, only : i8, wp
   use contensou_base_text, only : lower, quote, read_real, shorten, starts_with, string_type, &
      & to_text
   implicit none(type, external)
   private

   public :: value_type, assignment_type, group_type, document_type
   public :: value_null, value_integer, value_real, value_logical, value_text
   public :: read_document, parse_document, parse_value_list, read_file

   !> No value was given: nothing between two commas.
   integer, parameter :: value_null = 0

   !> An integer.
   integer, parameter :: value_integer = 1

   !> A real number, possibly infinite or not a number.
   integer, parameter :: value_real = 2

   !> A logical.
   integer, parameter :: value_logical = 3

   !> A text in quotes.
   integer, parameter :: value_text = 4

   !> One value.
   type :: value_type
      !> What it is, one of the `value_*` parameters.
      integer :: kind = value_null
      !> The number, for integers too.
      real(wp) :: real = 0.0_wp
      !> The integer.
      integer(i8) :: integer = 0
      !> The logical.
      logical :: logical = .false.
      !> The text without its quotes; allocated for texts only.
      character(len=:), allocatable :: text
      !> Where it stands.
      type(origin_type) :: origin
   end type value_type

   !> A key and the values given to it.
   type :: assignment_type
      !> Key in lower case.
      character(len=:), allocatable :: key
      !> First subscript; 0 if there is no subscript.
      integer :: first = 0
      !> Last subscript; 0 if there is no subscript, -1 if the range is open.
      integer :: last = 0
      !> The values, repetitions expanded; size 0 if nothing follows the equals sign.
      type(value_type), allocatable :: values(:)
      !> Where the key stands.
      type(origin_type) :: origin
   end type assignment_type

   !> A group.
   type :: group_type
      !> Name in lower case.
      character(len=:), allocatable :: name
      !> Where `&name` stands.
      type(origin_type) :: origin
      !> Number of assignments.
      integer :: n_assignments = 0
      !> The assignments, of size `n_assignments`.
      type(assignment_type), allocatable :: assignments(:)
      !> Whether the group was read without a mistake; if not, keys may be missing from it.
      logical :: complete = .true.
   end type group_type

   !> What was read.
   type :: document_type
      !> Texts that origins refer to.
      type(source_type), allocatable :: sources(:)
      !> Bytes of the file that was read.
      character(len=:), allocatable :: bytes
      !> Number of groups.
      integer :: n_groups = 0
      !> The groups, of size `n_groups`.
      type(group_type), allocatable :: groups(:)
      !> Whether all was read without a mistake; if not, groups may be missing.
      logical :: complete = .true.
   end type document_type

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
      !> Name of the group that ended last.
      character(len=:), allocatable :: last_group
      !> Line in which it ended.
      integer :: last_line = 0
   end type parser_type

   !> Largest file that is read [bytes].
   integer, parameter :: max_bytes = 16 * 1024 * 1024

   !> Largest number of lines in a source.
   integer, parameter :: max_lines = 1000000

   !> Largest number of groups in a source.
   integer, parameter :: max_groups = 100000

   !> Largest number of assignments in a source.
   integer, parameter :: max_assignments = 1000000

   !> Largest number of values in a source, largest repeat count, and largest subscript.
   integer, parameter :: max_values = 1000000

   !> Largest number of characters in all values of a source.
   integer, parameter :: max_characters = 2 * max_bytes

   !> Number of bytes of a word that a message shows.
   integer, parameter :: word_width = 40

   !> What is not a value.
   integer, parameter :: form_none = 0

   !> What is a value.
   integer, parameter :: form_value = 1

   !> What is a number too large for double precision.
   integer, parameter :: form_overflow = 2

   !> Line end.
   character(len=1), parameter :: newline = achar(10)

   !> Characters that count as a blank: blank, tab, vertical tab, form feed, carriage return.
   character(len=*), parameter :: blanks = ' ' // achar(9) // achar(11) // achar(12) // achar(13)

   !> Both quotes.
   character(len=*), parameter :: quotes = '''"'

   !> Decimal digits.
   character(len=*), parameter :: digits = '0123456789'

   !> Letters that names are made of.
   character(len=*), parameter :: letters = &
      & 'abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ'

   !> Characters that end a word.
   character(len=*), parameter :: stops = blanks // quotes // ',;/!=&()'

contains

   !> Read a file.
   subroutine read_document(path, document, diagnostics, error)
      !> File to read.
      character(len=*), intent(in) :: path
      !> What was read.
      type(document_type), intent(out) :: document
      !> Mistakes in the text are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics
      !> Set if the file cannot be read or is not a text.
      type(error_type), allocatable, intent(out) :: error

      character(len=:), allocatable :: text

      call read_file(path, text, error)
      if (.not. allocated(error)) then
         if (scan(text, achar(0)) > 0) then
            call fatal(error, path // ' is not a text file: it contains zero bytes', status_usage)
         end if
      end if
      if (allocated(error)) then
         allocate(document%sources(0), document%groups(0))
         return
      end if
      call parse_document(path, text, document, diagnostics)
      call move_alloc(text, document%bytes)
   end subroutine read_document

   !> Read the bytes of a file.
   subroutine read_file(path, text, error)
      !> File to read.
      character(len=*), intent(in) :: path
      !> Its bytes.
      character(len=:), allocatable, intent(out) :: text
      !> Set if the file cannot be read.
      type(error_type), allocatable, intent(out) :: error

      integer, parameter :: chunk = 65536
      character(len=:), allocatable :: bigger
      character(len=1) :: c
      character(len=512) :: reason
      integer(i8) :: n_bytes
      integer :: n, stat, unit

      text = ''
      if (len_trim(path) == 0) then
         call fatal(error, 'the name of the file to read is empty', status_usage)
         return
      end if
      reason = ''
      open(newunit=unit, file=path, access='stream', form='unformatted', status='old', &
         & action='read', iostat=stat, iomsg=reason)
      if (stat /= 0) then
         call fatal(error, path // ' cannot be read: ' // plain_reason(reason), status_file)
         return
      end if

      inquire (unit=unit, size=n_bytes)
      if (n_bytes > max_bytes) then
         close(unit)
         call fatal(error, too_large(path), status_file)
         return
      end if
      if (n_bytes > 0) then
         deallocate(text)
         allocate(character(len=int(n_bytes)) :: text)
         read (unit, iostat=stat, iomsg=reason) text
      else
         ! Pipes have no size.
         deallocate(text)
         allocate(character(len=chunk) :: text)
         n = 0
         do
            read (unit, iostat=stat, iomsg=reason) c
            if (stat /= 0) exit
            if (n == max_bytes) then
               close(unit)
               call fatal(error, too_large(path), status_file)
               return
            end if
            if (n == len(text)) then
               allocate(character(len=2 * n) :: bigger)
               bigger(1:n) = text
               call move_alloc(bigger, text)
            end if
            n = n + 1
            text(n:n) = c
         end do
         text = text(1:n)
         if (is_iostat_end(stat)) stat = 0
      end if
      if (stat /= 0) then
         call fatal(error, path // ' cannot be read: ' // plain_reason(reason), status_file)
      end if
      close(unit)
   end subroutine read_file

   !> Message for a file that is too large.
   pure function too_large(path) result(message)
      !> The file.
      character(len=*), intent(in) :: path
      !> The message.
      character(len=:), allocatable :: message

      message = path // ' is too large to be a scene: more than ' // &
         & to_text(max_bytes / 1024 / 1024) // ' MiB'
   end function too_large

   !> Reason of the operating system in plain words.
   pure function plain_reason(reason) result(plain)
      !> Message of the run-time library.
      character(len=*), intent(in) :: reason
      !> The reason in it.
      character(len=:), allocatable :: plain

      if (index(reason, 'No such file') > 0) then
         plain = 'it does not exist'
      else if (index(reason, 'Is a directory') > 0) then
         plain = 'it is a folder'
      else if (index(reason, 'Not a directory') > 0) then
         plain = 'a part of its path is not a folder'
      else if (index(reason, 'Permission denied') > 0) then
         plain = 'no permission'
      else
         plain = trim(reason)
      end if
   end function plain_reason

   !> Read a text.
   pure subroutine parse_document(name, text, document, diagnostics)
      !> Name of the text in messages.
      character(len=*), intent(in) :: name
      !> The text.
      character(len=*), intent(in) :: text
      !> What was read.
      type(document_type), intent(out) :: document
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics

      type(parser_type) :: parser

      allocate(document%groups(0))
      call split_lines(parser, text, diagnostics)
      parser%last_group = ''
      do
         call skip_space(parser)
         if (at_end(parser)) exit
         if (peek(parser) == '&') then
            call parse_ampersand(parser, document, diagnostics)
         else
            call parse_outside(parser, document, diagnostics)
         end if
      end do
      call resize_groups(document, document%n_groups)
      document%complete = parser%n_mistakes == 0
      allocate(document%sources(1))
      document%sources(1)%name = name
      call move_alloc(parser%lines, document%sources(1)%lines)
   end subroutine parse_document

   !> Read a list of values that does not stand in a file, such as a setting from the command
   !> line.
   pure subroutine parse_value_list(name, text, values, document, diagnostics, bare_text)
      !> Name of the list in messages.
      character(len=*), intent(in) :: name
      !> The list as it would follow the equals sign.
      character(len=*), intent(in) :: text
      !> The values.
      type(value_type), allocatable, intent(out) :: values(:)
      !> Document to whose sources the list is appended.
      type(document_type), intent(inout) :: document
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics
      !> Whether texts between commas may go without quotes, because a shell removes them;
      !> default `.false.`.
      logical, intent(in), optional :: bare_text

      type(parser_type) :: parser
      type(source_type), allocatable :: sources(:)
      type(value_type), allocatable :: buffer(:)
      type(origin_type) :: origin
      integer :: i, n, n_sources

      n_sources = 0
      if (allocated(document%sources)) n_sources = size(document%sources)
      parser%source = n_sources + 1
      parser%list_only = .true.
      if (present(bare_text)) parser%bare_text = bare_text
      call split_lines(parser, text, diagnostics)
      allocate(buffer(4))
      call parse_values(parser, buffer, n, diagnostics)
      call skip_space(parser)
      if (.not. at_end(parser)) then
         origin = here(parser, 1)
         call mistake(parser, diagnostics, origin, 'unexpected ''' // peek(parser) // '''', &
            & 'values separated by commas')
      end if
      call copy_values(buffer, n, values)
      if (parser%n_mistakes > 0) document%complete = .false.

      allocate(sources(n_sources + 1))
      do i = 1, n_sources
         call move_alloc(document%sources(i)%name, sources(i)%name)
         call move_alloc(document%sources(i)%lines, sources(i)%lines)
      end do
      sources(n_sources + 1)%name = name
      call move_alloc(parser%lines, sources(n_sources + 1)%lines)
      call move_alloc(sources, document%sources)
   end subroutine parse_value_list

   !> Cut a text into lines; a byte order mark and carriage returns at line ends are dropped.
   pure subroutine split_lines(parser, text, diagnostics)
      !> Parser that gets the lines.
      type(parser_type), intent(inout) :: parser
      !> The text.
      character(len=*), intent(in) :: text
      !> Too many lines are reported here.
      type(diagnostics_type), intent(inout) :: diagnostics

      character(len=*), parameter :: byte_order_mark = char(239) // char(187) // char(191)
      integer :: first, i, last, n, start

      start = 1
      if (starts_with(text, byte_order_mark)) start = len(byte_order_mark) + 1
      n = 1
      do i = start, len(text)
         if (text(i:i) == newline .and. i < len(text)) n = n + 1
      end do
      if (n > max_lines) then
         call mistake(parser, diagnostics, origin_type(source=parser%source, length=0), &
            & 'more than ' // to_text(max_lines) // ' lines')
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
   end subroutine split_lines

   !> Read what begins with an ampersand outside any group.
   pure subroutine parse_ampersand(parser, document, diagnostics)
      !> State of the reading.
      type(parser_type), intent(inout) :: parser
      !> Document to append a group to.
      type(document_type), intent(inout) :: document
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics

      character(len=:), allocatable :: name, shown
      type(origin_type) :: origin
      integer :: last, n_before

      n_before = parser%n_mistakes
      last = word_end(parser, parser%column + 1)
      origin = here(parser, last - parser%column + 1)
      name = parser%lines(parser%line)%s(parser%column + 1:last)
      parser%column = last + 1
      if (is_name(name)) then
         if (lower(name) == 'end') then
            call mistake(parser, diagnostics, origin, '&end outside any group', &
               & 'a group that it could end')
            return
         end if
      else if (len(name) == 0) then
         call mistake(parser, diagnostics, origin, 'name of a group missing after ''&''', &
            & '''&'' directly followed by a name, such as &body')
         call skip_space(parser)
         last = word_end(parser, parser%column)
         if (.not. at_end(parser)) then
            shown = parser%lines(parser%line)%s(parser%column:last)
            ! A blank too much is read over, but a key is not taken for a name.
            if (is_name(shown) .and. .not. is_key(parser)) then
               name = shown
               parser%column = last + 1
            end if
         end if
      else
         call mistake(parser, diagnostics, origin, '''' // shorten(name, word_width) // &
            & ''' is not the name of a group', &
            & 'letters, digits and underscores, a letter first')
         name = ''
      end if
      call parse_group(parser, lower(name), origin, n_before, document, diagnostics)
   end subroutine parse_ampersand

   !> Report text outside any group and find the next place to go on.
   pure subroutine parse_outside(parser, document, diagnostics)
      !> State of the reading.
      type(parser_type), intent(inout) :: parser
      !> Document to append a group to.
      type(document_type), intent(inout) :: document
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics

      character(len=:), allocatable :: expected, word
      type(origin_type) :: origin
      integer :: last, n_before
      logical :: found

      n_before = parser%n_mistakes
      call foreign_comment(parser, diagnostics, found)
      if (found) then
         parser%line = parser%line + 1
         parser%column = 1
         return
      end if

      last = max(word_end(parser, parser%column), parser%column)
      origin = here(parser, last - parser%column + 1)
      word = parser%lines(parser%line)%s(parser%column:last)
      if (is_key(parser)) then
         expected = '''&'' and the name of a group before the keys'
         call mistake(parser, diagnostics, origin, 'key ''' // shorten(word, word_width) // &
            & ''' outside any group', expected // closed_hint(parser))
         call parse_group(parser, '', origin, n_before, document, diagnostics)
         return
      end if

      if (is_name(word) .or. (is_name(word(2:)) .and. word(1:1) == '$')) then
         if (word(1:1) == '$') word = word(2:)
         if (key_follows(parser, last + 1)) then
            call mistake(parser, diagnostics, origin, '''&'' missing before ''' // &
               & shorten(word, word_width) // '''', '&' // shorten(word, word_width))
            parser%column = last + 1
            call parse_group(parser, lower(word), origin, n_before, document, diagnostics)
            return
         end if
      end if

      call mistake(parser, diagnostics, origin, '''' // shorten(word, word_width) // &
         & ''' outside any group', &
         & '''&'' and the name of a group, or ''!'' before a comment' // closed_hint(parser))
      parser%column = last + 1
      do
         call skip_space(parser)
         if (at_end(parser)) exit
         if (peek(parser) == '&' .and. scan(peek_next(parser), letters) > 0) exit
         parser%column = parser%column + 1
      end do
   end subroutine parse_outside

   !> Hint for text behind the end of a group in the same line.
   pure function closed_hint(parser) result(hint)
      !> State of the reading.
      type(parser_type), intent(in) :: parser
      !> The hint; may be empty.
      character(len=:), allocatable :: hint

      hint = ''
      if (parser%last_line == parser%line .and. len(parser%last_group) > 0) then
         hint = ' (''/'' ended &' // shorten(parser%last_group, word_width) // &
            & ' in this line)'
      end if
   end function closed_hint

   !> Whether a key and its equals sign follow a column.
   pure function key_follows(parser, column) result(follows)
      !> State of the reading.
      type(parser_type), intent(in) :: parser
      !> Column in the present line.
      integer, intent(in) :: column
      !> The answer.
      logical :: follows

      integer :: c, line

      line = parser%line
      c = column
      call skip_over(parser%lines, line, c)
      follows = is_key_at(parser%lines, line, c)
   end function key_follows

   !> Read the assignments of a group up to its end.
   pure subroutine parse_group(parser, name, origin, n_before, document, diagnostics)
      !> State of the reading.
      type(parser_type), intent(inout) :: parser
      !> Name in lower case; empty if what is read belongs to no known group.
      character(len=*), intent(in) :: name
      !> Where the group begins.
      type(origin_type), intent(in) :: origin
      !> Number of mistakes before the group.
      integer, intent(in) :: n_before
      !> Document to append the group to.
      type(document_type), intent(inout) :: document
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics

      type(group_type) :: group
      type(value_type), allocatable :: buffer(:)
      character(len=:), allocatable :: before
      integer :: column, last, line
      logical :: closed, found

      allocate(buffer(4), group%assignments(4))
      parser%lost_end = .false.
      closed = .false.
      do
         call skip_space(parser)
         if (at_end(parser)) exit
         line = parser%line
         column = parser%column
         select case (peek(parser))
         case ('/')
            closed = .true.
            parser%column = parser%column + 1
            exit
         case ('&')
            last = word_end(parser, column + 1)
            if (lower(parser%lines(line)%s(column:last)) == '&end') then
               closed = .true.
               parser%column = last + 1
               exit
            end if
            if (scan(peek_next(parser), letters // digits // '_') > 0) exit
            call parse_continuation(parser, diagnostics)
         case ('=')
            call mistake(parser, diagnostics, here(parser, 1), 'key missing before ''=''', &
               & 'KEY = VALUE')
            parser%column = parser%column + 1
            call discard_values(parser, buffer, diagnostics)
         case (',', ';')
            call mistake(parser, diagnostics, here(parser, 1), 'unexpected ''' // &
               & peek(parser) // '''', 'KEY = VALUE, or ''/'' to end the group')
            do while (scan(peek(parser), ',;' // blanks) > 0)
               parser%column = parser%column + 1
            end do
         case default
            call foreign_comment(parser, diagnostics, found)
            if (.not. found) then
               last = word_end(parser, column)
               if (is_key(parser) .or. is_name(parser%lines(line)%s(column:last))) then
                  call parse_assignment(parser, group, buffer, diagnostics)
               else
                  last = max(last, column)
                  call mistake(parser, diagnostics, here(parser, last - column + 1), &
                     & 'value without a key', 'KEY = VALUE')
                  call discard_values(parser, buffer, diagnostics)
               end if
            end if
         end select
         ! Whatever was met: never read the same place twice.
         if (parser%line == line .and. parser%column == column) parser%column = column + 1
      end do

      if (closed) then
         parser%last_group = name
         parser%last_line = parser%line
      else if (len(name) > 0 .and. .not. parser%lost_end) then
         if (at_end(parser)) then
            before = 'the end of the file'
         else
            last = word_end(parser, parser%column + 1)
            before = shorten(parser%lines(parser%line)%s(parser%column:last), word_width) // &
               & ' in line ' // to_text(parser%line)
         end if
         call mistake(parser, diagnostics, origin, 'group &' // shorten(name, word_width) // &
            & ' is not closed', '''/'' before ' // before)
      end if
      if (len(name) == 0 .or. parser%stopped) return

      group%name = name
      group%origin = origin
      group%complete = parser%n_mistakes == n_before
      call append_group(parser, group, document, diagnostics)
   end subroutine parse_group

   !> Report an ampersand that begins no group.
   pure subroutine parse_continuation(parser, diagnostics)
      !> State of the reading.
      type(parser_type), intent(inout) :: parser
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics

      call mistake(parser, diagnostics, here(parser, 1), 'unexpected ''&''', &
         & 'nothing here: values go on in the next line by themselves')
      parser%column = parser%column + 1
   end subroutine parse_continuation

   !> Report a comment in the manner of other languages and skip it.
   pure subroutine foreign_comment(parser, diagnostics, found)
      !> State of the reading.
      type(parser_type), intent(inout) :: parser
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics
      !> Whether there was one.
      logical, intent(out) :: found

      found = peek(parser) == '#'
      if (.not. found) return
      call mistake(parser, diagnostics, here(parser, 1), '''#'' does not begin a comment', '''!''')
      call lose_line(parser)
   end subroutine foreign_comment

   !> Read a key, its equals sign and its values.
   pure subroutine parse_assignment(parser, group, buffer, diagnostics)
      !> State of the reading.
      type(parser_type), intent(inout) :: parser
      !> Group to append to.
      type(group_type), intent(inout) :: group
      !> Room for values.
      type(value_type), allocatable, intent(inout) :: buffer(:)
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics

      type(assignment_type) :: assignment
      character(len=:), allocatable :: word
      logical :: valid, was_quiet
      integer :: last, n

      last = max(word_end(parser, parser%column), parser%column)
      word = parser%lines(parser%line)%s(parser%column:last)
      assignment%origin = here(parser, last - parser%column + 1)
      parser%column = last + 1

      last = len(word)
      if (last > 1 .and. word(last:) == ':') then
         word = word(1:last - 1)
         parser%column = parser%column - 1
         assignment%origin%length = last - 1
      end if
      valid = is_name(word)
      if (.not. valid) then
         if (scan(word, '%') > 1) then
            call mistake(parser, diagnostics, assignment%origin, 'key ''' // &
               & shorten(word, word_width) // ''' has a component', &
               & 'a plain key, without ''%''')
         else
            call mistake(parser, diagnostics, assignment%origin, '''' // &
               & shorten(word, word_width) // ''' is not a key', &
               & 'letters, digits and underscores, a letter first')
         end if
      end if
      call skip_blanks(parser)
      if (peek(parser) == '(') then
         call parse_subscript(parser, assignment, valid, diagnostics)
         call skip_blanks(parser)
      end if
      if (peek(parser) == '%') then
         last = word_end(parser, parser%column)
         if (valid) then
            call mistake(parser, diagnostics, here(parser, last - parser%column + 1), &
               & 'key ''' // shorten(word, word_width) // ''' has a component', &
               & 'a plain key, without ''%''')
         end if
         valid = .false.
         parser%column = last + 1
      end if

      was_quiet = parser%quiet
      if (peek(parser) == ':') then
         n = 1
         if (peek_next(parser) == '=') n = 2
         call mistake(parser, diagnostics, here(parser, n), &
            & '''' // parser%lines(parser%line)%s(parser%column:parser%column + n - 1) // &
            & ''' after ''' // shorten(word, word_width) // '''', '''=''')
         parser%column = parser%column + n
      else if (key_ends(parser)) then
         call skip_space(parser)
         parser%column = parser%column + 1
      else
         if (valid) then
            call mistake(parser, diagnostics, assignment%origin, '''='' missing after ''' // &
               & shorten(word, word_width) // '''', &
               & shorten(lower(word), word_width) // ' = VALUE')
         end if
         ! Words that follow belong to this mistake.
         parser%quiet = .true.
      end if
      call parse_values(parser, buffer, n, diagnostics)
      parser%quiet = was_quiet .or. parser%stopped
      if (.not. valid .or. parser%stopped) return

      assignment%key = lower(word)
      call copy_values(buffer, n, assignment%values)
      call append_assignment(parser, group, assignment, diagnostics)
   end subroutine parse_assignment

   !> Whether an equals sign follows, possibly after blanks, line ends and comments.
   pure function key_ends(parser) result(ends)
      !> State of the reading.
      type(parser_type), intent(in) :: parser
      !> The answer.
      logical :: ends

      integer :: column, line

      line = parser%line
      column = parser%column
      call skip_over(parser%lines, line, column)
      ends = char_at(parser%lines, line, column) == '='
   end function key_ends

   !> Read a subscript in parentheses.
   pure subroutine parse_subscript(parser, assignment, valid, diagnostics)
      !> State of the reading, at the opening parenthesis.
      type(parser_type), intent(inout) :: parser
      !> Assignment that gets the subscript.
      type(assignment_type), intent(inout) :: assignment
      !> Made false if the subscript is not valid.
      logical, intent(inout) :: valid
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics

      character(len=*), parameter :: forms = '(N), (N:M), (N:), (:M) or (:) with N from 1'
      type(origin_type) :: origin
      integer :: colon, first, last, n
      logical :: good

      first = parser%column
      associate (line => parser%lines(parser%line))
         n = scan(line%s(first + 1:), ')(=!/&' // quotes)
         last = first + n
         good = n > 0
         if (good) good = line%s(last:last) == ')'
         if (.not. good) then
            if (valid) then
               call mistake(parser, diagnostics, here(parser, 1), 'parenthesis is not closed', &
                  & ''')'' after the subscript')
            end if
            valid = .false.
            parser%column = last
            if (n == 0) parser%column = len(line%s) + 1
            return
         end if
         origin = here(parser, n + 1)
         colon = index(line%s(first:last), ':')
         if (colon == 0) then
            call read_subscript(line%s(first + 1:last - 1), 0, assignment%first)
            assignment%last = assignment%first
         else
            colon = first + colon - 1
            call read_subscript(line%s(first + 1:colon - 1), 1, assignment%first)
            call read_subscript(line%s(colon + 1:last - 1), -1, assignment%last)
         end if
         good = assignment%first > 0 .and. assignment%last /= 0
         if (good .and. assignment%last > 0) good = assignment%last >= assignment%first
         if (valid .and. .not. good) then
            call mistake(parser, diagnostics, origin, &
               & 'bad subscript ''' // shorten(line%s(first:last), word_width) // '''', forms)
         end if
      end associate
      valid = valid .and. good
      parser%column = last + 1
   end subroutine parse_subscript

   !> Read one bound of a subscript.
   pure subroutine read_subscript(s, default, bound)
      !> Text of the bound.
      character(len=*), intent(in) :: s
      !> Bound if there is no text.
      integer, intent(in) :: default
      !> The bound; 0 if the text is not a number from 1.
      integer, intent(out) :: bound

      character(len=:), allocatable :: number

      number = trim(adjustl(s))
      bound = default
      if (verify(number, blanks) == 0) return
      bound = read_count(number)
   end subroutine read_subscript

   !> Positive integer of a text.
   pure function read_count(s) result(n)
      !> The text.
      character(len=*), intent(in) :: s
      !> The integer; 0 if the text is none or it is larger than `max_values`.
      integer :: n

      integer :: i

      n = 0
      if (verify(s, digits) > 0) return
      do i = 1, len(s)
         n = 10 * n + iachar(s(i:i)) - iachar('0')
         if (n > max_values) then
            n = 0
            return
         end if
      end do
   end function read_count

   !> Read values that belong to a mistake reported already.
   pure subroutine discard_values(parser, buffer, diagnostics)
      !> State of the reading.
      type(parser_type), intent(inout) :: parser
      !> Room for values.
      type(value_type), allocatable, intent(inout) :: buffer(:)
      !> Where too many values are reported.
      type(diagnostics_type), intent(inout) :: diagnostics

      logical :: was_quiet
      integer :: n

      was_quiet = parser%quiet
      parser%quiet = .true.
      do
         call parse_values(parser, buffer, n, diagnostics)
         if (at_end(parser) .or. peek(parser) /= '=') exit
         parser%column = parser%column + 1
      end do
      parser%quiet = was_quiet .or. parser%stopped
   end subroutine discard_values

   !> Read values up to the next key, the end of the group, or an equals sign.
   pure subroutine parse_values(parser, buffer, n, diagnostics)
      !> State of the reading.
      type(parser_type), intent(inout) :: parser
      !> The values; its size is at least `n`.
      type(value_type), allocatable, intent(inout) :: buffer(:)
      !> Number of values.
      integer, intent(out) :: n
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics

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
         case (',', ';')
            if (peek(parser) == ';') then
               call mistake(parser, diagnostics, here(parser, 1), &
                  & ''';'' does not separate values', 'a comma or a blank')
            end if
            if (.not. has_value) then
               missing%origin = here(parser, 1)
               call append_value(parser, missing, 1, buffer, n, diagnostics)
            end if
            has_value = .false.
            after_comma = .true.
            parser%column = parser%column + 1
            cycle
         case ('/')
            if (parser%bare_text) then
               call parse_token(parser, buffer, n, after_comma, found, diagnostics)
            else if (.not. after_comma .and. .not. has_value &
               & .and. scan(peek_next(parser), letters // digits // '._~') > 0) then
               call report_word(parser, diagnostics)
            else
               exit
            end if
         case ('&')
            if (scan(peek_next(parser), letters // digits // '_') > 0) exit
            call parse_continuation(parser, diagnostics)
            cycle
         case ('=')
            if (has_value .or. after_comma .or. parser%list_only) exit
            call mistake(parser, diagnostics, here(parser, 1), 'second ''=''', 'one ''=''')
            parser%column = parser%column + 1
            cycle
         case ('''', '"')
            call parse_text(parser, 1, column, buffer, n, diagnostics)
         case default
            if (.not. parser%bare_text) then
               if (is_key(parser)) exit
            end if
            call foreign_comment(parser, diagnostics, found)
            if (found) cycle
            call parse_token(parser, buffer, n, after_comma, found, diagnostics)
            if (.not. found) exit
         end select
         has_value = .true.
         if (parser%line == line .and. parser%column == column) parser%column = column + 1
      end do
   end subroutine parse_values

   !> Read a value that is not in quotes, or report what stands in its place.
   pure subroutine parse_token(parser, buffer, n, after_comma, found, diagnostics)
      !> State of the reading.
      type(parser_type), intent(inout) :: parser
      !> The values read so far.
      type(value_type), allocatable, intent(inout) :: buffer(:)
      !> Number of values.
      integer, intent(inout) :: n
      !> Whether a comma went before.
      logical, intent(in) :: after_comma
      !> False if this is a key without equals sign, which is left for others to read.
      logical, intent(out) :: found
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics

      type(value_type) :: value
      character(len=:), allocatable :: word
      integer :: count, first, form, last, star, start

      found = .true.
      first = parser%column
      last = word_end(parser, first)
      word = parser%lines(parser%line)%s(first:last)

      if (parser%bare_text) then
         call value_of(word, value, form)
         if (form == form_none .and. may_be_bare(parser)) then
            call parse_bare_text(parser, buffer, n, diagnostics)
            return
         end if
      end if
      if (len(word) == 0) then
         call report_parenthesis(parser, diagnostics)
         return
      end if

      ! A repeat count.
      count = 1
      start = first
      star = verify(word, digits)
      if (star > 1) then
         if (word(star:star) == '*') then
            start = first + star
            count = read_count(word(1:star - 1))
            if (count == 0) then
               call mistake(parser, diagnostics, here(parser, star), 'bad repeat count ''' // &
                  & shorten(word(1:star - 1), word_width) // '''', &
                  & 'a number from 1 to ' // to_text(max_values))
            end if
            word = word(star + 1:)
            if (len(word) == 0) then
               parser%column = start
               if (scan(peek(parser), quotes) > 0) then
                  call parse_text(parser, count, first, buffer, n, diagnostics)
               else
                  parser%column = first
                  value%origin = here(parser, start - first)
                  parser%column = start
                  call append_value(parser, value, count, buffer, n, diagnostics)
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
         if (scan(peek(parser), quotes // '(') > 0) then
            call mistake(parser, diagnostics, here(parser, 1), 'unexpected ''' // &
               & peek(parser) // ''' after ''' // shorten(word, word_width) // '''', &
               & 'a comma or a blank between values')
            call lose_line(parser)
         end if
         call append_value(parser, value, count, buffer, n, diagnostics)
      case (form_overflow)
         parser%column = start
         call mistake(parser, diagnostics, here(parser, last - start + 1), '''' // &
            & shorten(word, word_width) // ''' is too large for double precision', &
            & 'a magnitude below 1.8e308')
         parser%column = last + 1
      case default
         if (start == first .and. .not. parser%list_only .and. (n > 0 .or. after_comma)) then
            if (is_name(word) .and. value_follows(parser, last + 1)) then
               found = .false.
               return
            end if
         end if
         parser%column = start
         call report_word(parser, diagnostics)
      end select
   end subroutine parse_token

   !> Extend the last column of `nan` by a bracket directly behind it.
   pure subroutine extend_nan(parser, last)
      !> State of the reading.
      type(parser_type), intent(in) :: parser
      !> Last column of the word.
      integer, intent(inout) :: last

      integer :: n

      associate (line => parser%lines(parser%line))
         if (char_at(parser%lines, parser%line, last + 1) /= '(') return
         n = verify(line%s(last + 2:), letters // digits // '_')
         if (n == 0) return
         if (line%s(last + 1 + n:last + 1 + n) == ')') last = last + 1 + n
      end associate
   end subroutine extend_nan

   !> Whether a number, or a text in quotes, follows in the line with no comma before it.
   pure function value_follows(parser, column) result(follows)
      !> State of the reading.
      type(parser_type), intent(in) :: parser
      !> Column from which on to look.
      integer, intent(in) :: column
      !> The answer.
      logical :: follows

      integer :: n

      follows = .false.
      associate (line => parser%lines(parser%line))
         n = verify(line%s(column:), blanks)
         if (n < 2) return
         follows = scan(line%s(column + n - 1:column + n - 1), digits // quotes // '+-.') > 0
      end associate
   end function value_follows

   !> Whether a value without quotes may be meant as a text.
   pure function may_be_bare(parser) result(may)
      !> State of the reading.
      type(parser_type), intent(in) :: parser
      !> The answer.
      logical :: may

      ! What begins like a number shall be one, so that a misprint in it is found.
      may = scan(peek(parser), digits // '+-') == 0
      if (peek(parser) == '.') may = scan(peek_next(parser), digits) == 0
   end function may_be_bare

   !> Read a text without quotes up to the next comma.
   pure subroutine parse_bare_text(parser, buffer, n, diagnostics)
      !> State of the reading.
      type(parser_type), intent(inout) :: parser
      !> The values read so far.
      type(value_type), allocatable, intent(inout) :: buffer(:)
      !> Number of values.
      integer, intent(inout) :: n
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics

      type(value_type) :: value
      integer :: first, last

      first = parser%column
      associate (line => parser%lines(parser%line))
         last = scan(line%s(first:), ',')
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
      call append_value(parser, value, 1, buffer, n, diagnostics)
   end subroutine parse_bare_text

   !> Read a text in quotes.
   pure subroutine parse_text(parser, count, start, buffer, n, diagnostics)
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
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics

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
         call mistake(parser, diagnostics, here(parser, 1), 'text is not closed in its line', &
            & 'a closing ' // delimiter)
         call lose_line(parser)
         return
      end if

      parser%column = i + 1
      if (scan(peek(parser), blanks // ',;/!&' // newline) == 0) then
         if (peek(parser) /= '=' .or. .not. parser%quiet) then
            call mistake(parser, diagnostics, here(parser, 1), &
               & 'text is directly followed by ''' // shown_character(parser) // '''', &
               & 'a comma or a blank; a quote inside a text is written twice')
            call lose_line(parser)
            return
         end if
      end if

      value%kind = value_text
      value%origin = origin_type(source=parser%source, line=parser%line, column=start, &
         & length=i - start + 1)
      call unquote(parser%lines(parser%line)%s(first + 1:i - 1), delimiter, n_double, value%text)
      call append_value(parser, value, count, buffer, n, diagnostics)
   end subroutine parse_text

   !> Text with doubled quotes made single.
   pure subroutine unquote(s, delimiter, n_double, text)
      !> What stands between the quotes.
      character(len=*), intent(in) :: s
      !> The kind of quote.
      character(len=1), intent(in) :: delimiter
      !> Number of doubled quotes.
      integer, intent(in) :: n_double
      !> The text.
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
      !> The word.
      character(len=*), intent(in) :: word
      !> Its value, without origin.
      type(value_type), intent(out) :: value
      !> Whether it is a value, one of the `form_*` parameters.
      integer, intent(out) :: form

      logical :: fits, valid

      form = form_none
      if (len(word) == 0) return
      if (len(word) <= len('.false.')) then
         select case (lower(word))
         case ('t', '.t', '.t.', 'true', '.true', '.true.')
            form = form_value
            value%kind = value_logical
            value%logical = .true.
            return
         case ('f', '.f', '.f.', 'false', '.false', '.false.')
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
      if (verify(word(1:1), '+-' // digits) == 0 .and. verify(word(2:), digits) == 0) then
         call read_integer(word, value%integer, fits)
         if (fits) value%kind = value_integer
      end if
      if (ieee_is_nan(value%real)) return
      if (.not. ieee_is_finite(value%real) .and. scan(word, digits) > 0) form = form_overflow
   end subroutine value_of

   !> Integer of a text of digits with an optional sign.
   pure subroutine read_integer(s, x, fits)
      !> The text.
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
         digit = iachar(s(i:i)) - iachar('0')
         if (x > (huge(x) - digit) / 10) then
            x = 0
            fits = .false.
            return
         end if
         x = 10 * x + digit
      end do
      if (s(1:1) == '-') x = -x
   end subroutine read_integer

   !> Report a word that is not a value and skip it, with the words that belong to it.
   pure subroutine report_word(parser, diagnostics)
      !> State of the reading, at the word.
      type(parser_type), intent(inout) :: parser
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics

      character(len=:), allocatable :: expected, message, word
      type(origin_type) :: origin
      type(value_type) :: value
      integer :: column, first, form, last, next
      logical :: loses

      first = parser%column
      last = max(word_end(parser, first), first)
      if (peek(parser) == '/') last = max(word_end(parser, first + 1), first)
      loses = .false.
      associate (line => parser%lines(parser%line))
         do
            column = last + 1
            select case (char_at(parser%lines, parser%line, column))
            case ('/')
               ! A slash inside a word belongs to a path and does not end the group.
               if (scan(char_at(parser%lines, parser%line, column + 1), &
                  & blanks // newline // '!&,') > 0) exit
               last = max(word_end(parser, column + 1), column)
            case ('(', ')')
               last = max(word_end(parser, column + 1), column)
            case ('''', '"')
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

      if (scan(word(1:1), digits) > 0 .or. &
         & (scan(word(1:1), '+-.') > 0 .and. scan(word, digits) > 0 .and. &
         & verify(word, '+-.' // digits // 'eEdD') == 0)) then
         message = '''' // shorten(word, word_width) // ''' is not a number'
         expected = 'a number such as 2, 0.5 or 1.0e-3, or a text in quotes'
      else if (word(1:1) == '.' .and. scan(char_at(parser%lines, parser%line, first + 1), &
         & 'tTfF') > 0 .and. scan(word, '/') == 0) then
         message = '''' // shorten(word, word_width) // ''' is not a logical'
         expected = '.true. or .false.'
      else if (is_curly(word)) then
         message = 'typographic quotes around a text'
         expected = 'straight quotes, '' or "'
         loses = .true.
      else if (any(lower(word) == [character(len=3) :: 'yes', 'no', 'on', 'off'])) then
         message = '''' // word // ''' is not a logical'
         expected = '.true. or .false.'
      else if (scan(word(1:1), letters // '_./~') > 0 .or. ichar(word(1:1)) > 127) then
         message = 'text ''' // shorten(word, word_width) // ''' needs quotes'
         expected = quote(shorten(word, word_width))
      else
         message = '''' // shorten(word, word_width) // ''' is not a value'
         expected = 'a number, .true., .false., or a text in quotes'
      end if
      origin = here(parser, last - first + 1)
      call mistake(parser, diagnostics, origin, message, expected)
      parser%column = last + 1
      if (loses) call lose_line(parser)
   end subroutine report_word

   !> Whether a word begins with a quote from a word processor (U+2018 to U+201F).
   pure function is_curly(word) result(curly)
      !> Word to look at.
      character(len=*), intent(in) :: word
      !> The answer.
      logical :: curly

      curly = .false.
      if (len(word) < 3) return
      curly = word(1:2) == char(226) // char(128) .and. &
         & ichar(word(3:3)) >= 152 .and. ichar(word(3:3)) <= 159
   end function is_curly

   !> Report a parenthesis in the place of a value and skip to its end.
   pure subroutine report_parenthesis(parser, diagnostics)
      !> State of the reading, at the parenthesis.
      type(parser_type), intent(inout) :: parser
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics

      type(origin_type) :: origin
      integer :: n

      associate (line => parser%lines(parser%line))
         n = 1
         if (peek(parser) == '(') then
            n = scan(line%s(parser%column + 1:), ')(=!/&' // quotes)
            if (n == 0) then
               n = 1
            else if (line%s(parser%column + n:parser%column + n) == ')') then
               n = n + 1
            else
               n = 1
            end if
         end if
         origin = here(parser, n)
         call mistake(parser, diagnostics, origin, 'unexpected ''' // &
            & shorten(line%s(origin%column:origin%column + n - 1), word_width) // '''', &
            & 'values without parentheses')
      end associate
      parser%column = parser%column + n
   end subroutine report_parenthesis

   !> Skip the rest of a line in which it is no longer clear what is text and what is not.
   !>
   !> If the line ends with a slash, that is taken for the end of the group.
   pure subroutine lose_line(parser)
      !> State of the reading.
      type(parser_type), intent(inout) :: parser

      integer :: comment, first, last

      first = parser%column
      associate (line => parser%lines(parser%line))
         comment = scan(line%s(first:), '!')
         last = len(line%s)
         if (comment > 0) last = first + comment - 2
         last = first - 1 + verify(line%s(first:last), blanks, back=.true.)
         parser%column = len(line%s) + 1
         if (last >= first) then
            if (line%s(last:last) == '/' .and. .not. parser%list_only) then
               parser%column = last
               return
            end if
         end if
         if (scan(line%s(first:), '/') > 0) parser%lost_end = .true.
      end associate
   end subroutine lose_line

   !> Report a mistake, unless it follows from another.
   pure subroutine mistake(parser, diagnostics, origin, message, expected)
      !> State of the reading.
      type(parser_type), intent(inout) :: parser
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics
      !> Where the mistake is.
      type(origin_type), intent(in) :: origin
      !> What is wrong.
      character(len=*), intent(in) :: message
      !> What would be right.
      character(len=*), intent(in), optional :: expected

      parser%n_mistakes = parser%n_mistakes + 1
      if (.not. parser%quiet) call diagnostics%add(origin, message, expected)
   end subroutine mistake

   !> Report that there is too much of something and give up reading.
   pure subroutine give_up(parser, diagnostics, origin, message)
      !> State of the reading.
      type(parser_type), intent(inout) :: parser
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics
      !> Where it becomes too much.
      type(origin_type), intent(in) :: origin
      !> What there is too much of.
      character(len=*), intent(in) :: message

      parser%quiet = parser%stopped
      call mistake(parser, diagnostics, origin, message, 'less of it in one file')
      parser%stopped = .true.
      parser%quiet = .true.
      parser%line = size(parser%lines) + 1
      parser%column = 1
   end subroutine give_up

   !> Append a value.
   pure subroutine append_value(parser, value, count, buffer, n, diagnostics)
      !> State of the reading.
      type(parser_type), intent(inout) :: parser
      !> The value.
      type(value_type), intent(in) :: value
      !> Number of times to append it.
      integer, intent(in) :: count
      !> Values to append to.
      type(value_type), allocatable, intent(inout) :: buffer(:)
      !> Number of values.
      integer, intent(inout) :: n
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics

      type(value_type), allocatable :: bigger(:)
      integer :: i, length

      if (parser%stopped .or. count == 0) return
      length = 0
      if (allocated(value%text)) length = len(value%text)
      if (count > max_values - parser%n_values) then
         call give_up(parser, diagnostics, value%origin, &
            & 'more than ' // to_text(max_values) // ' values')
         return
      end if
      if (int(count, i8) * length > max_characters - parser%n_characters) then
         call give_up(parser, diagnostics, value%origin, &
            & 'more than ' // to_text(max_characters) // ' characters of text')
         return
      end if
      parser%n_values = parser%n_values + count
      parser%n_characters = parser%n_characters + count * length

      if (n + count > size(buffer)) then
         allocate(bigger(max(n + count, 2 * size(buffer))))
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

   !> Copy the values of a buffer.
   pure subroutine copy_values(buffer, n, values)
      !> The buffer.
      type(value_type), intent(in) :: buffer(:)
      !> Number of values in it.
      integer, intent(in) :: n
      !> The values.
      type(value_type), allocatable, intent(out) :: values(:)

      integer :: i

      allocate(values(n))
      do i = 1, n
         values(i) = buffer(i)
      end do
   end subroutine copy_values

   !> Append an assignment.
   pure subroutine append_assignment(parser, group, assignment, diagnostics)
      !> State of the reading.
      type(parser_type), intent(inout) :: parser
      !> Group to append to; its list of assignments may be larger than their number.
      type(group_type), intent(inout) :: group
      !> The assignment; its key and values are moved.
      type(assignment_type), intent(inout) :: assignment
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics

      if (parser%n_assignments == max_assignments) then
         call give_up(parser, diagnostics, assignment%origin, &
            & 'more than ' // to_text(max_assignments) // ' keys')
         return
      end if
      parser%n_assignments = parser%n_assignments + 1
      if (group%n_assignments == size(group%assignments)) then
         call resize_assignments(group, 2 * group%n_assignments)
      end if
      group%n_assignments = group%n_assignments + 1
      call move_assignment(assignment, group%assignments(group%n_assignments))
   end subroutine append_assignment

   !> Change the size of a group's list of assignments.
   pure subroutine resize_assignments(group, n)
      !> The group.
      type(group_type), intent(inout) :: group
      !> Size, not below the number of assignments.
      integer, intent(in) :: n

      type(assignment_type), allocatable :: resized(:)
      integer :: i

      allocate(resized(n))
      do i = 1, group%n_assignments
         call move_assignment(group%assignments(i), resized(i))
      end do
      call move_alloc(resized, group%assignments)
   end subroutine resize_assignments

   !> Move an assignment without copying its values.
   pure subroutine move_assignment(from, to)
      !> Assignment that is emptied.
      type(assignment_type), intent(inout) :: from
      !> Assignment that is filled.
      type(assignment_type), intent(inout) :: to

      to%first = from%first
      to%last = from%last
      to%origin = from%origin
      call move_alloc(from%key, to%key)
      call move_alloc(from%values, to%values)
   end subroutine move_assignment

   !> Append a group.
   pure subroutine append_group(parser, group, document, diagnostics)
      !> State of the reading.
      type(parser_type), intent(inout) :: parser
      !> The group; its assignments are moved.
      type(group_type), intent(inout) :: group
      !> Document to append to; its list of groups may be larger than their number.
      type(document_type), intent(inout) :: document
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics

      if (parser%n_groups == max_groups) then
         call give_up(parser, diagnostics, group%origin, &
            & 'more than ' // to_text(max_groups) // ' groups')
         return
      end if
      parser%n_groups = parser%n_groups + 1
      call resize_assignments(group, group%n_assignments)
      if (document%n_groups == size(document%groups)) then
         call resize_groups(document, max(8, 2 * document%n_groups))
      end if
      document%n_groups = document%n_groups + 1
      call move_group(group, document%groups(document%n_groups))
   end subroutine append_group

   !> Change the size of a document's list of groups.
   pure subroutine resize_groups(document, n)
      !> The document.
      type(document_type), intent(inout) :: document
      !> Size, not below the number of groups.
      integer, intent(in) :: n

      type(group_type), allocatable :: resized(:)
      integer :: i

      allocate(resized(n))
      do i = 1, document%n_groups
         call move_group(document%groups(i), resized(i))
      end do
      call move_alloc(resized, document%groups)
   end subroutine resize_groups

   !> Move a group without copying its assignments.
   pure subroutine move_group(from, to)
      !> Group that is emptied.
      type(group_type), intent(inout) :: from
      !> Group that is filled.
      type(group_type), intent(inout) :: to

      to%origin = from%origin
      to%n_assignments = from%n_assignments
      to%complete = from%complete
      call move_alloc(from%name, to%name)
      call move_alloc(from%assignments, to%assignments)
   end subroutine move_group

   !> Place of the next character.
   pure function here(parser, length) result(origin)
      !> State of the reading.
      type(parser_type), intent(in) :: parser
      !> Number of bytes that the place takes.
      integer, intent(in) :: length
      !> The place.
      type(origin_type) :: origin

      origin = origin_type(source=parser%source, line=parser%line, column=parser%column, &
         & length=length)
   end function here

   !> Whether all was read.
   pure function at_end(parser) result(at)
      !> State of the reading.
      type(parser_type), intent(in) :: parser
      !> The answer.
      logical :: at

      at = parser%line > size(parser%lines)
   end function at_end

   !> The next character; a line end at the end of each line.
   pure function peek(parser) result(c)
      !> State of the reading.
      type(parser_type), intent(in) :: parser
      !> The character.
      character(len=1) :: c

      c = char_at(parser%lines, parser%line, parser%column)
   end function peek

   !> The character after the next.
   pure function peek_next(parser) result(c)
      !> State of the reading.
      type(parser_type), intent(in) :: parser
      !> The character.
      character(len=1) :: c

      c = char_at(parser%lines, parser%line, parser%column + 1)
   end function peek_next

   !> The character at a place; a line end beyond the end of a line or of the text.
   pure function char_at(lines, line, column) result(c)
      !> Lines of the text.
      type(string_type), intent(in) :: lines(:)
      !> Line of the character.
      integer, intent(in) :: line
      !> Its column.
      integer, intent(in) :: column
      !> The character.
      character(len=1) :: c

      c = newline
      if (line > size(lines)) return
      if (column > len(lines(line)%s)) return
      c = lines(line)%s(column:column)
   end function char_at

   !> Skip blanks within the line.
   pure subroutine skip_blanks(parser)
      !> State of the reading.
      type(parser_type), intent(inout) :: parser

      do while (scan(peek(parser), blanks) > 0)
         parser%column = parser%column + 1
      end do
   end subroutine skip_blanks

   !> Skip blanks, line ends and comments.
   pure subroutine skip_space(parser)
      !> State of the reading.
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
               if (lines(line)%s(column:column) /= '!') return
            end if
         end if
         line = line + 1
         column = 1
      end do
   end subroutine skip_over

   !> Last column of the word that begins at a column; the column before it if there is none.
   pure function word_end(parser, column) result(last)
      !> State of the reading.
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
      !> The line.
      character(len=*), intent(in) :: line
      !> The column.
      integer, intent(in) :: column
      !> Last column.
      integer :: last

      integer :: n

      n = scan(line(column:), stops)
      last = len(line)
      if (n > 0) last = column + n - 2
      if (column > len(line)) last = column - 1
   end function word_end_at

   !> Whether a key and its equals sign come next.
   pure function is_key(parser) result(is)
      !> State of the reading.
      type(parser_type), intent(in) :: parser
      !> The answer.
      logical :: is

      is = is_key_at(parser%lines, parser%line, parser%column)
   end function is_key

   !> Whether a key and its equals sign stand at a place.
   !>
   !> Any word counts as key here: whether it is a good one is checked when it is read. Between
   !> the two may stand a subscript, and a colon may stand for the equals sign.
   pure function is_key_at(lines, line, column) result(is)
      !> Lines of the text.
      type(string_type), intent(in) :: lines(:)
      !> Line of the place.
      integer, intent(in) :: line
      !> Column of the place.
      integer, intent(in) :: column
      !> The answer.
      logical :: is

      character(len=1) :: c
      integer :: c_last, c_line, last, n

      is = .false.
      if (line > size(lines)) return
      last = word_end_at(lines(line)%s, column)
      if (last < column) return
      if (lines(line)%s(last:last) == ':' .and. is_name(lines(line)%s(column:last - 1))) then
         is = scan(char_at(lines, line, last + 1), blanks // newline // '=') > 0
         return
      end if

      c_line = line
      c_last = last + 1
      call skip_over(lines, c_line, c_last)
      c = char_at(lines, c_line, c_last)
      if (c == '(' .and. c_line == line) then
         n = scan(lines(line)%s(c_last + 1:), ')(=!/&' // quotes)
         if (n == 0) return
         c = lines(line)%s(c_last + n:c_last + n)
         c_last = c_last + n
         if (c == '=') then
            ! The parenthesis is not closed, which is reported when the subscript is read.
            is = .true.
            return
         end if
         if (c /= ')') return
         c_last = c_last + 1
         call skip_over(lines, c_line, c_last)
         c = char_at(lines, c_line, c_last)
         if (c == '%') then
            is = .true.
            return
         end if
      end if
      is = c == '='
      if (c == ':') is = char_at(lines, c_line, c_last + 1) == '='
   end function is_key_at

   !> Whether a word is a legal name.
   pure function is_name(word) result(is)
      !> Word to look at.
      character(len=*), intent(in) :: word
      !> The answer.
      logical :: is

      is = .false.
      if (len(word) == 0) return
      is = scan(word(1:1), letters) == 1 .and. verify(word, letters // digits // '_') == 0
   end function is_name

   !> The next character as a message shows it, with all its bytes.
   pure function shown_character(parser) result(shown)
      !> State of the reading.
      type(parser_type), intent(in) :: parser
      !> The character.
      character(len=:), allocatable :: shown

      integer :: last

      last = parser%column
      do while (iand(ichar(char_at(parser%lines, parser%line, last + 1)), 192) == 128)
         last = last + 1
      end do
      shown = parser%lines(parser%line)%s(parser%column:last)
   end function shown_character

end module contensou_base_document
