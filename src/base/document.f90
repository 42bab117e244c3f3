!> Reader of the namelist syntax that keeps the place of everything it reads.
!>
!> The intrinsic namelist read says neither where a mistake is nor, mostly, which one; it stops
!> at the first, and leaves half-read values behind. This reader takes the same legal text,
!> `&name key = values, ... /`, knows nothing of the meaning of groups and keys, goes on after
!> a mistake, and tries to report each mistake once. It takes any sequence of bytes.
module contensou_base_document
   use contensou_base_diagnostics, only : diagnostics_type, origin_type, source_type
   use contensou_base_document_types, only : append_source, assignment_type, copy_values, &
      document_type, group_type, move_assignment, move_group, resize_assignments, resize_groups, &
      value_expression, value_integer, value_logical, value_null, value_real, value_text, value_type
   use contensou_base_errors, only : error_type, fatal, status_file, status_usage
   use contensou_base_kinds, only : i8
   use contensou_base_misprints, only : explain_lookalike
   use contensou_base_numbers, only : to_text
   use contensou_base_scanner, only : at_end, blanks, digits, foreign_comment, give_up, here, &
      is_key, is_name, key_ends, key_follows, letters, max_assignments, max_bytes, max_groups, &
      mistake, parse_continuation, parser_type, peek, peek_next, quotes, skip_blanks, skip_space, &
      split_lines, word_end, word_width
   use contensou_base_text, only : lower, shorten
   use contensou_base_value_reader, only : discard_values, parse_values, read_count
   implicit none(type, external)
   private

   public :: constants_group
   public :: value_type, assignment_type, group_type, document_type
   public :: value_null, value_integer, value_real, value_logical, value_text, value_expression
   public :: read_document, parse_document, parse_value_list, read_file

   !> Name of the groups that give constants.
   character(len=*), parameter :: constants_group = "constants"

contains

   !> Read a file.
   subroutine read_document(path, document, diagnostics, error)
      !> File to read.
      character(len=*), intent(in) :: path
      type(document_type), intent(out) :: document
      !> Mistakes in the text are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics
      !> Set if the file cannot be read or is not a text.
      type(error_type), allocatable, intent(out) :: error
      character(len=:), allocatable :: text, right

      call read_file(path, text, error)
      if (.not. allocated(error)) then
         if (scan(text, achar(0)) > 0) then
            right = ""
            if (index(text, char(255) // char(254)) == 1 .or. &
               index(text, char(254) // char(255)) == 1) right = ", as UTF-16 does; iconv " // &
               "-f utf-16 -t utf-8 OLD > NEW converts it"
            call fatal(error, path // " is not a text file: it contains zero bytes" // right, &
               status_usage)
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
      type(error_type), allocatable, intent(out) :: error
      integer, parameter :: chunk = 65536
      character(len=:), allocatable :: bigger
      character(len=1) :: c
      character(len=512) :: reason
      integer(i8) :: n_bytes
      integer :: n, stat, unit

      text = ""
      if (len_trim(path) == 0) then
         call fatal(error, "the name of the file to read is empty", status_usage)
         return
      end if
      reason = ""
      open(newunit=unit, file=path, access="stream", form="unformatted", status="old", &
         action="read", iostat=stat, iomsg=reason)
      if (stat /= 0) then
         call fatal(error, path // " cannot be read: " // plain_reason(reason), status_file)
         return
      end if

      inquire(unit=unit, size=n_bytes)
      if (n_bytes > max_bytes) then
         close(unit)
         call fatal(error, too_large(path), status_file)
         return
      end if
      if (n_bytes > 0) then
         deallocate(text)
         allocate(character(len=int(n_bytes)) :: text)
         read(unit, iostat=stat, iomsg=reason) text
      else
         ! Pipes have no size.
         deallocate(text)
         allocate(character(len=chunk) :: text)
         n = 0
         do
            read(unit, iostat=stat, iomsg=reason) c
            if (stat /= 0) exit
            if (n == max_bytes) then
               close(unit)
               call fatal(error, too_large(path), status_file)
               return
            end if
            if (n == len(text)) then
               allocate(character(len=2*n) :: bigger)
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
         call fatal(error, path // " cannot be read: " // plain_reason(reason), status_file)
      end if
      close(unit)
   end subroutine read_file

   !> Message for a file that is too large.
   pure function too_large(path) result(message)
      !> The file.
      character(len=*), intent(in) :: path
      character(len=:), allocatable :: message

      message = path // " is too large to be a scene: more than " // &
         to_text(max_bytes/1024/1024) // " MiB"
   end function too_large

   !> Reason of the operating system in plain words.
   pure function plain_reason(reason) result(plain)
      !> Message of the run-time library.
      character(len=*), intent(in) :: reason
      !> The reason in it.
      character(len=:), allocatable :: plain

      if (index(reason, "No such file") > 0) then
         plain = "it does not exist"
      else if (index(reason, "Is a directory") > 0) then
         plain = "it is a folder"
      else if (index(reason, "Not a directory") > 0) then
         plain = "a part of its path is not a folder"
      else if (index(reason, "Permission denied") > 0) then
         plain = "no permission"
      else
         plain = trim(reason)
      end if
   end function plain_reason

   !> Read a text.
   pure subroutine parse_document(name, text, document, diagnostics)
      !> Name of the text in messages.
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: text
      type(document_type), intent(out) :: document
      type(diagnostics_type), intent(inout) :: diagnostics
      type(parser_type) :: parser

      allocate(document%groups(0))
      parser%diagnostics = diagnostics
      call split_lines(parser, text)
      call name_constants(parser)
      parser%last_group = ""
      do
         call skip_space(parser)
         if (at_end(parser)) exit
         if (peek(parser) == "&") then
            call parse_ampersand(parser, document)
         else
            call parse_outside(parser, document)
         end if
      end do
      call resize_groups(document, document%n_groups)
      call move_alloc(parser%constants, document%constant_names)
      document%complete = parser%n_mistakes == 0
      allocate(document%sources(1))
      document%n_sources = 1
      document%sources(1)%name = name
      call move_alloc(parser%lines, document%sources(1)%lines)
      diagnostics = parser%diagnostics
   end subroutine parse_document

   !> Find the names of the constants of a file, so that they are known before they are used: read
   !> its groups &constants once beforehand.
   pure subroutine name_constants(parser)
      !> Parser at the beginning of the text.
      type(parser_type), intent(inout) :: parser
      type(document_type) :: found
      type(parser_type) :: ahead
      integer :: column, g, i, n

      allocate(parser%constants(0))
      do i = 1, size(parser%lines)
         if (index(parser%lines(i)%s, "&") == 0) cycle
         column = index(lower(parser%lines(i)%s), "&" // constants_group)
         if (column == 0) cycle
         if (scan(parser%lines(i)%s(:column), "!") > 0) cycle
         if (.not. allocated(found%groups)) then
            allocate(found%groups(0))
            ahead%lines = parser%lines
            ahead%quiet = .true.
            allocate(ahead%constants(0))
         end if
         ahead%line = i
         ahead%column = column + len(constants_group) + 1
         call parse_group(ahead, constants_group, origin_type(), 0, found)
      end do
      if (found%n_groups == 0) return
      deallocate(parser%constants)
      allocate(parser%constants(sum(found%groups(:found%n_groups)%n_assignments)))
      n = 0
      do g = 1, found%n_groups
         do i = 1, found%groups(g)%n_assignments
            n = n + 1
            parser%constants(n)%s = found%groups(g)%assignments(i)%key
         end do
      end do
   end subroutine name_constants

   !> Read a list of values that does not stand in a file, such as a setting from the command
   !> line.
   pure subroutine parse_value_list(name, text, values, document, diagnostics, bare_text)
      !> Name of the list in messages.
      character(len=*), intent(in) :: name
      !> The list as it would follow the equals sign.
      character(len=*), intent(in) :: text
      type(value_type), allocatable, intent(out) :: values(:)
      type(document_type), intent(inout) :: document
      type(diagnostics_type), intent(inout) :: diagnostics
      !> Whether texts between commas may go without quotes, because a shell removes them;
      !> default `.false.`.
      logical, intent(in), optional :: bare_text
      type(parser_type) :: parser
      type(source_type) :: source
      type(value_type), allocatable :: buffer(:)
      type(origin_type) :: origin
      integer :: n

      parser%source = document%n_sources + 1
      parser%list_only = .true.
      if (present(bare_text)) parser%bare_text = bare_text
      parser%diagnostics = diagnostics
      call split_lines(parser, text)
      if (allocated(document%constant_names)) then
         parser%constants = document%constant_names
      else
         allocate(parser%constants(0))
      end if
      allocate(buffer(4))
      call parse_values(parser, buffer, n)
      call skip_space(parser)
      if (.not. at_end(parser)) then
         origin = here(parser, 1)
         call mistake(parser, origin, "unexpected '" // peek(parser) // "'", &
            "values separated by commas")
      end if
      call copy_values(buffer, n, values)
      if (parser%n_mistakes > 0) document%complete = .false.

      source%name = name
      call move_alloc(parser%lines, source%lines)
      call append_source(document, source)
      diagnostics = parser%diagnostics
   end subroutine parse_value_list

   !> Read what begins with an ampersand outside any group.
   pure subroutine parse_ampersand(parser, document)
      type(parser_type), intent(inout) :: parser
      type(document_type), intent(inout) :: document
      character(len=:), allocatable :: name, shown
      type(origin_type) :: origin
      integer :: last, n_before

      n_before = parser%n_mistakes
      last = word_end(parser, parser%column + 1)
      origin = here(parser, last - parser%column + 1)
      name = parser%lines(parser%line)%s(parser%column + 1:last)
      parser%column = last + 1
      if (is_name(name)) then
         if (lower(name) == "end") then
            call mistake(parser, origin, "&end outside any group", "a group that it could end")
            return
         end if
      else if (len(name) == 0) then
         call mistake(parser, origin, "name of a group missing after '&'", &
            "'&' directly followed by a name, such as &body")
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
         call report_name("is not the name of a group", name, origin, parser)
         name = ""
      end if
      call parse_group(parser, lower(name), origin, n_before, document)
   end subroutine parse_ampersand

   !> Report text outside any group and find the next place to go on.
   pure subroutine parse_outside(parser, document)
      type(parser_type), intent(inout) :: parser
      type(document_type), intent(inout) :: document
      character(len=:), allocatable :: expected, message, word
      type(origin_type) :: origin
      integer :: last, n_before
      logical :: found

      n_before = parser%n_mistakes
      call foreign_comment(parser, found)
      if (found) then
         parser%line = parser%line + 1
         parser%column = 1
         return
      end if

      last = max(word_end(parser, parser%column), parser%column)
      origin = here(parser, last - parser%column + 1)
      word = parser%lines(parser%line)%s(parser%column:last)
      if (is_key(parser)) then
         expected = "'&' and the name of a group before the keys"
         call mistake(parser, origin, "key '" // shorten(word, word_width) // &
            "' outside any group", expected // closed_hint(parser))
         call parse_group(parser, "", origin, n_before, document)
         return
      end if

      if (is_name(word) .or. (is_name(word(2:)) .and. word(1:1) == "$")) then
         if (word(1:1) == "$") word = word(2:)
         if (key_follows(parser, last + 1)) then
            call mistake(parser, origin, "'&' missing before '" // &
               shorten(word, word_width) // "'", "&" // shorten(word, word_width))
            parser%column = last + 1
            call parse_group(parser, lower(word), origin, n_before, document)
            return
         end if
      end if

      call explain_lookalike(word, message, expected)
      if (.not. allocated(message)) then
         message = "'" // shorten(word, word_width) // "' outside any group"
         expected = "'&' and the name of a group, or '!' before a comment" // closed_hint(parser)
      end if
      call mistake(parser, origin, message, expected)
      parser%column = last + 1
      do
         call skip_space(parser)
         if (at_end(parser)) exit
         if (peek(parser) == "&" .and. scan(peek_next(parser), letters) > 0) exit
         parser%column = parser%column + 1
      end do
   end subroutine parse_outside

   !> Hint for text behind the end of a group in the same line.
   pure function closed_hint(parser) result(hint)
      type(parser_type), intent(in) :: parser
      !> The hint; may be empty.
      character(len=:), allocatable :: hint

      hint = ""
      if (parser%last_line == parser%line .and. len(parser%last_group) > 0) then
         hint = " ('/' ended &" // shorten(parser%last_group, word_width) // " in this line"
         if (size(parser%constants) > 0) hint = hint // "; one that divides has no blanks"
         hint = hint // ")"
      end if
   end function closed_hint

   !> Read the assignments of a group up to its end.
   pure subroutine parse_group(parser, name, origin, n_before, document)
      type(parser_type), intent(inout) :: parser
      !> Name in lower case; empty if what is read belongs to no known group.
      character(len=*), intent(in) :: name
      type(origin_type), intent(in) :: origin
      !> Number of mistakes before the group.
      integer, intent(in) :: n_before
      type(document_type), intent(inout) :: document
      type(group_type) :: group
      type(value_type), allocatable :: buffer(:)
      integer :: column, last, line
      logical :: closed, found

      allocate(buffer(4), group%assignments(4))
      parser%in_constants = name == constants_group
      parser%lost_end = .false.
      closed = .false.
      do
         call skip_space(parser)
         if (at_end(parser)) exit
         line = parser%line
         column = parser%column
         select case (peek(parser))
         case ("/")
            closed = .true.
            parser%column = parser%column + 1
            exit
         case ("&")
            last = word_end(parser, column + 1)
            if (lower(parser%lines(line)%s(column:last)) == "&end") then
               closed = .true.
               parser%column = last + 1
               exit
            end if
            if (scan(peek_next(parser), letters // digits // "_") > 0) exit
            call parse_continuation(parser)
         case ("=")
            call mistake(parser, here(parser, 1), "key missing before '='", "KEY = VALUE")
            parser%column = parser%column + 1
            call discard_values(parser, buffer)
         case (",", ";")
            call mistake(parser, here(parser, 1), "unexpected '" // &
               peek(parser) // "'", "KEY = VALUE, or '/' to end the group")
            do while (scan(peek(parser), ",;" // blanks) > 0)
               parser%column = parser%column + 1
            end do
         case default
            call foreign_comment(parser, found)
            if (.not. found) then
               last = word_end(parser, column)
               if (is_key(parser) .or. is_name(parser%lines(line)%s(column:last))) then
                  call parse_assignment(parser, group, buffer)
               else
                  last = max(last, column)
                  call mistake(parser, here(parser, last - column + 1), &
                     "value without a key", "KEY = VALUE")
                  call discard_values(parser, buffer)
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
         call report_open_group(parser, name, origin)
      end if
      if (len(name) == 0 .or. parser%stopped) return

      group%name = name
      group%origin = origin
      group%complete = parser%n_mistakes == n_before
      call append_group(parser, group, document)
   end subroutine parse_group

   !> Report a group that is not closed where the parser is.
   pure subroutine report_open_group(parser, name, origin)
      type(parser_type), intent(inout) :: parser
      character(len=*), intent(in) :: name
      type(origin_type), intent(in) :: origin
      character(len=:), allocatable :: before
      integer :: last

      if (at_end(parser)) then
         before = "the end of the file"
      else
         last = word_end(parser, parser%column + 1)
         before = shorten(parser%lines(parser%line)%s(parser%column:last), word_width) // &
            " in line " // to_text(parser%line)
      end if
      call mistake(parser, origin, "group &" // shorten(name, word_width) // &
         " is not closed", "'/' before " // before)
   end subroutine report_open_group

   !> Read a key, its equals sign and its values.
   pure subroutine parse_assignment(parser, group, buffer)
      type(parser_type), intent(inout) :: parser
      type(group_type), intent(inout) :: group
      type(value_type), allocatable, intent(inout) :: buffer(:)
      type(assignment_type) :: assignment
      character(len=:), allocatable :: word
      logical :: valid, was_quiet
      integer :: last, n

      last = max(word_end(parser, parser%column), parser%column)
      word = parser%lines(parser%line)%s(parser%column:last)
      assignment%origin = here(parser, last - parser%column + 1)
      parser%column = last + 1

      last = len(word)
      if (last > 1 .and. word(last:) == ":") then
         word = word(1:last - 1)
         parser%column = parser%column - 1
         assignment%origin%length = last - 1
      end if
      valid = is_name(word)
      if (.not. valid) then
         if (scan(word, "%") > 1) then
            call mistake(parser, assignment%origin, "key '" // &
               shorten(word, word_width) // "' has a component", &
               "a plain key, without '%'")
         else
            call report_name("is not a key", word, assignment%origin, parser)
         end if
      end if
      call skip_blanks(parser)
      if (peek(parser) == "(") then
         call parse_subscript(parser, assignment, valid)
         call skip_blanks(parser)
      end if
      if (peek(parser) == "%") then
         last = word_end(parser, parser%column)
         if (valid) then
            call mistake(parser, here(parser, last - parser%column + 1), &
               "key '" // shorten(word, word_width) // "' has a component", &
               "a plain key, without '%'")
         end if
         valid = .false.
         parser%column = last + 1
      end if

      was_quiet = parser%quiet
      if (peek(parser) == ":") then
         n = 1
         if (peek_next(parser) == "=") n = 2
         call mistake(parser, here(parser, n), &
            "'" // parser%lines(parser%line)%s(parser%column:parser%column + n - 1) // &
            "' after '" // shorten(word, word_width) // "'", "'='")
         parser%column = parser%column + n
      else if (key_ends(parser)) then
         call skip_space(parser)
         parser%column = parser%column + 1
      else
         if (valid) then
            call mistake(parser, assignment%origin, "'=' missing after '" // &
               shorten(word, word_width) // "'", &
               shorten(lower(word), word_width) // " = VALUE")
         end if
         ! Words that follow belong to this mistake.
         parser%quiet = .true.
      end if
      call parse_values(parser, buffer, n)
      parser%quiet = was_quiet .or. parser%stopped
      if (.not. valid .or. parser%stopped) return

      assignment%key = lower(word)
      call copy_values(buffer, n, assignment%values)
      call append_assignment(parser, group, assignment)
   end subroutine parse_assignment

   !> Report a word that cannot be a name.
   pure subroutine report_name(what, word, origin, parser)
      !> What it is not.
      character(len=*), intent(in) :: what
      character(len=*), intent(in) :: word
      type(origin_type), intent(in) :: origin
      type(parser_type), intent(inout) :: parser
      character(len=:), allocatable :: message, expected

      call explain_lookalike(word, message, expected)
      if (.not. allocated(message)) then
         message = "'" // shorten(word, word_width) // "' " // what
         expected = "letters, digits and underscores, a letter first"
      end if
      call mistake(parser, origin, message, expected)
   end subroutine report_name

   !> Read a subscript in parentheses.
   pure subroutine parse_subscript(parser, assignment, valid)
      !> State of the reading, at the opening parenthesis.
      type(parser_type), intent(inout) :: parser
      !> Assignment that gets the subscript.
      type(assignment_type), intent(inout) :: assignment
      !> Made false if the subscript is not valid.
      logical, intent(inout) :: valid
      character(len=*), parameter :: forms = "(N), (N:M), (N:), (:M) or (:) with N from 1"
      type(origin_type) :: origin
      integer :: colon, first, last, n
      logical :: good

      first = parser%column
      associate (line => parser%lines(parser%line))
         n = scan(line%s(first + 1:), ")(=!/&" // quotes)
         last = first + n
         good = n > 0
         if (good) good = line%s(last:last) == ")"
         if (.not. good) then
            if (valid) then
               call mistake(parser, here(parser, 1), "parenthesis is not closed", &
                  "')' after the subscript")
            end if
            valid = .false.
            parser%column = last
            if (n == 0) parser%column = len(line%s) + 1
            return
         end if
         origin = here(parser, n + 1)
         colon = index(line%s(first:last), ":")
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
            call mistake(parser, origin, &
               "bad subscript '" // shorten(line%s(first:last), word_width) // "'", forms)
         end if
      end associate
      valid = valid .and. good
      parser%column = last + 1
   end subroutine parse_subscript

   !> Read one bound of a subscript.
   pure subroutine read_subscript(s, default, bound)
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

   pure subroutine append_assignment(parser, group, assignment)
      type(parser_type), intent(inout) :: parser
      !> Group to append to; its list of assignments may be larger than their number.
      type(group_type), intent(inout) :: group
      !> The assignment; its key and values are moved.
      type(assignment_type), intent(inout) :: assignment

      if (parser%n_assignments == max_assignments) then
         call give_up(parser, assignment%origin, &
            "more than " // to_text(max_assignments) // " keys")
         return
      end if
      parser%n_assignments = parser%n_assignments + 1
      if (group%n_assignments == size(group%assignments)) then
         call resize_assignments(group, 2*group%n_assignments)
      end if
      group%n_assignments = group%n_assignments + 1
      call move_assignment(assignment, group%assignments(group%n_assignments))
   end subroutine append_assignment

   pure subroutine append_group(parser, group, document)
      type(parser_type), intent(inout) :: parser
      !> The group; its assignments are moved.
      type(group_type), intent(inout) :: group
      !> Document to append to; its list of groups may be larger than their number.
      type(document_type), intent(inout) :: document

      if (parser%n_groups == max_groups) then
         call give_up(parser, group%origin, "more than " // to_text(max_groups) // " groups")
         return
      end if
      parser%n_groups = parser%n_groups + 1
      call resize_assignments(group, group%n_assignments)
      if (document%n_groups == size(document%groups)) then
         call resize_groups(document, max(8, 2*document%n_groups))
      end if
      document%n_groups = document%n_groups + 1
      call move_group(group, document%groups(document%n_groups))
   end subroutine append_group

end module contensou_base_document
