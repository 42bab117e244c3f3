!> Rules of a comparison: which objects of a file are compared with which tolerance, or not at all.
!>
!> A rule is a line `PATTERN ATOL RTOL` or `PATTERN ignore`; the last one that matches wins, and
!> what none matches is compared exactly. Two numbers agree when
!> `|a - b| <= atol + rtol max(|a|, |b|)`. What the built-in rules leave out, such as the
!> provenance, is compared only when a rule names it in full: `* 0 1e-9` must not bring the host
!> name back.
!>
!> Patterns stand for paths: `*` for any characters, `/` included, `?` for one, `[a-z]` or `[!abc]`
!> for one of a set. A pattern with `@` stands for attributes, as in `/trajectory/time@units`; one
!> without stands for objects and all of their attributes.
module contensou_compare_rules
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite
   use contensou_base_diagnostics, only : diagnostics_type, origin_type, source_type
   use contensou_base_document, only : read_file
   use contensou_base_errors, only : error_type, fatal, status_usage
   use contensou_base_kinds, only : wp
   use contensou_base_misprints, only : explain_misprint
   use contensou_base_numbers, only : read_real, to_text
   use contensou_base_scanner, only : in_utf8
   use contensou_base_text, only : invalid_byte, invalid_byte_text, lower, quote, string_type
   implicit none(type, external)
   private

   public :: rules_type, verdict_type
   public :: built_in_rules, built_in_text, whole_run_text, read_rules, parse_rules, matches

   !> What the rules say about an object or attribute.
   type :: verdict_type
      !> Whether it is left out.
      logical :: ignore = .false.
      !> Absolute tolerance, in the unit of the values.
      real(wp) :: atol = 0.0_wp
      !> Relative tolerance.
      real(wp) :: rtol = 0.0_wp
   end type verdict_type

   !> A line of rules.
   type :: rule_type
      !> Pattern of paths.
      character(len=:), allocatable :: pattern
      type(verdict_type) :: verdict
      !> Whether it is a built-in one.
      logical :: built_in = .false.
      !> Whether it holds whatever others say.
      logical :: final = .false.
   end type rule_type

   !> Rules in their order.
   type :: rules_type
      private
      !> The rules, of which `n` are used.
      type(rule_type), allocatable :: rules(:)
      integer :: n = 0
   contains
      procedure :: verdict => find_verdict
      procedure :: count => count_rules
   end type rules_type

   !> Built-in rules.
   character(len=*), parameter :: built_in_text(*) = [character(len=40) :: &
      "/provenance             ignore", &
      "/provenance/*           ignore", &
      "/@created               ignore", &
      "/@git_commit            ignore", &
      "/@program_version       ignore", &
      "/input/command_line     ignore", &
      "*/cpu_*                 ignore", &
      "*/wall_*                ignore"]

   !> Built-in rules about what sums up a whole run, for when only a part of it is compared.
   character(len=*), parameter :: whole_run_text(*) = [character(len=40) :: &
      "/integrator/*           ignore", &
      "/summary/*              ignore"]

contains

   !> Rules that hold where the user gives none.
   subroutine built_in_rules(part_of_run, rules)
      !> Whether only a part of the run is compared.
      logical, intent(in) :: part_of_run
      type(rules_type), intent(out) :: rules
      type(error_type), allocatable :: error
      integer :: i

      do i = 1, size(built_in_text)
         call parse_rules("built-in rules", trim(built_in_text(i)), rules, error)
      end do
      if (part_of_run) then
         do i = 1, size(whole_run_text)
            call parse_rules("built-in rules", trim(whole_run_text(i)), rules, error)
            rules%rules(rules%n)%final = .true.
         end do
      end if
      rules%rules(:rules%n)%built_in = .true.
   end subroutine built_in_rules

   !> Append the rules of a file.
   subroutine read_rules(path, rules, error)
      !> The file.
      character(len=*), intent(in) :: path
      type(rules_type), intent(inout) :: rules
      !> Set when it cannot be read, or holds mistakes; it then tells all of them.
      type(error_type), allocatable, intent(out) :: error
      character(len=:), allocatable :: text

      call read_file(path, text, error)
      if (allocated(error)) return
      call parse_rules(path, text, rules, error)
   end subroutine read_rules

   !> Append the rules of a text.
   subroutine parse_rules(name, text, rules, error)
      !> What the text is called in messages.
      character(len=*), intent(in) :: name
      !> Lines of rules.
      character(len=*), intent(in) :: text
      !> Rules to append to; unchanged where there are mistakes.
      type(rules_type), intent(inout) :: rules
      !> Set when there are mistakes; it tells all of them.
      type(error_type), allocatable, intent(out) :: error
      type(source_type) :: sources(1)
      type(diagnostics_type) :: diagnostics
      type(rule_type) :: rule
      character(len=:), allocatable :: message
      integer :: i, first, last, n_lines
      logical :: found

      sources(1)%name = name
      n_lines = 1
      do i = 1, len(text)
         if (text(i:i) == new_line("a")) n_lines = n_lines + 1
      end do
      allocate(sources(1)%lines(n_lines))
      first = 1
      do i = 1, n_lines
         last = index(text(first:), new_line("a")) + first - 2
         if (last < first - 1) last = len(text)
         sources(1)%lines(i)%s = text(first:last)
         first = last + 2
      end do
      do i = 1, n_lines
         call parse_line(sources(1)%lines(i)%s, i, rule, found, diagnostics)
         if (found) call append(rules, rule)
      end do
      if (diagnostics%count() == 0) return
      message = diagnostics%render(sources) // to_text(diagnostics%count()) // " error"
      if (diagnostics%count() > 1) message = message // "s"
      call fatal(error, message // " in " // name // "; nothing was compared", status_usage)
   end subroutine parse_rules

   !> Understand a line.
   subroutine parse_line(line, number, rule, found, diagnostics)
      character(len=*), intent(in) :: line
      integer, intent(in) :: number
      type(rule_type), intent(out) :: rule
      !> Whether there is a rule, without mistake.
      logical, intent(out) :: found
      type(diagnostics_type), intent(inout) :: diagnostics
      character(len=*), parameter :: form = "PATTERN ATOL RTOL or PATTERN ignore"
      integer :: starts(4), ends(4), n, n_before
      real(wp) :: tolerances(2)
      character(len=:), allocatable :: message, expected
      integer :: i
      logical :: valid

      found = .false.
      i = invalid_byte(line)
      if (i > 0) then
         call diagnostics%add(origin_type(1, number, i, 1), invalid_byte_text(line(i:i)), in_utf8)
         return
      end if
      call split(line, starts, ends, n)
      if (n == 0) return
      n_before = diagnostics%count()
      rule%pattern = line(starts(1):ends(1))
      if (scan(rule%pattern(1:1), "/*?[") == 0) then
         call mistake(1, "no path begins with " // quote(rule%pattern(1:1)), &
            "a pattern that begins with / or *")
      else if (.not. sets_closed(rule%pattern)) then
         call mistake(1, "'[' without ']' in a pattern", "a set such as [a-z]; [[] stands for '['")
      end if
      if (n == 1) then
         call mistake(1, "a pattern without tolerances", form)
      else if (lower(line(starts(2):ends(2))) == "ignore") then
         rule%verdict%ignore = .true.
         if (n > 2) call mistake(3, "a word after 'ignore'", form)
      else
         do i = 1, 2
            if (i + 1 > n) then
               call mistake(2, "the relative tolerance is missing", form)
               exit
            end if
            call read_real(line(starts(i + 1):ends(i + 1)), tolerances(i), valid)
            if (valid) valid = ieee_is_finite(tolerances(i))
            if (valid) valid = tolerances(i) >= 0.0_wp
            if (.not. valid) then
               call explain_misprint(line(starts(i + 1):ends(i + 1)), message, expected)
               if (allocated(message)) then
                  call mistake(i + 1, message, expected)
               else if (i == 1) then
                  call mistake(2, quote(line(starts(2):ends(2))) // " is no absolute tolerance", &
                     "a number >= 0, or ignore")
               else
                  call mistake(3, quote(line(starts(3):ends(3))) // " is no relative tolerance", &
                     "a number >= 0")
               end if
               exit
            end if
         end do
         if (n > 3) call mistake(4, "a word too many", form // "; # begins a comment")
         if (diagnostics%count() == n_before) then
            rule%verdict%atol = tolerances(1)
            rule%verdict%rtol = tolerances(2)
         end if
      end if
      found = diagnostics%count() == n_before

   contains

      !> Note a mistake.
      subroutine mistake(word, message, expected)
         !> Number of the word where it is.
         integer, intent(in) :: word
         character(len=*), intent(in) :: message
         character(len=*), intent(in) :: expected

         call diagnostics%add(origin_type(1, number, starts(word), &
            ends(word) - starts(word) + 1), message, expected)
      end subroutine mistake

   end subroutine parse_line

   !> Words of a line; a comment begins with '#' where a word would.
   pure subroutine split(line, starts, ends, n)
      character(len=*), intent(in) :: line
      !> First characters of the first four words.
      integer, intent(out) :: starts(4)
      !> Last characters.
      integer, intent(out) :: ends(4)
      !> Number of words, at most 4.
      integer, intent(out) :: n
      character(len=*), parameter :: blanks = " " // achar(9) // achar(13)
      integer :: i

      starts = 1
      ends = 0
      n = 0
      i = 1
      do while (n < 4)
         do while (i <= len(line))
            if (scan(line(i:i), blanks) == 0) exit
            i = i + 1
         end do
         if (i > len(line)) return
         if (line(i:i) == "#") return
         n = n + 1
         starts(n) = i
         do while (i <= len(line))
            if (scan(line(i:i), blanks) > 0) exit
            i = i + 1
         end do
         ends(n) = i - 1
      end do
   end subroutine split

   !> Whether every set of a pattern has its end.
   pure logical function sets_closed(pattern)
      character(len=*), intent(in) :: pattern
      integer :: i, last

      sets_closed = .true.
      i = 1
      do while (i <= len(pattern) .and. sets_closed)
         last = i
         if (pattern(i:i) == "[") then
            last = set_end(pattern, i)
            sets_closed = last > 0
         end if
         i = last + 1
      end do
   end function sets_closed

   !> Where the set that begins at a place ends; 0 if it does not. A first ']' belongs to it.
   pure function set_end(pattern, first) result(last)
      character(len=*), intent(in) :: pattern
      !> Place of '['.
      integer, intent(in) :: first
      !> Place of ']'.
      integer :: last
      integer :: i

      last = 0
      i = first + 1
      if (i <= len(pattern)) then
         if (pattern(i:i) == "!") i = i + 1
      end if
      do i = i + 1, len(pattern)
         if (pattern(i:i) == "]") then
            last = i
            return
         end if
      end do
   end function set_end

   subroutine append(rules, rule)
      type(rules_type), intent(inout) :: rules
      type(rule_type), intent(in) :: rule
      type(rule_type), allocatable :: longer(:)
      integer :: i

      if (.not. allocated(rules%rules)) allocate(rules%rules(16))
      if (rules%n == size(rules%rules)) then
         allocate(longer(2*rules%n))
         do i = 1, rules%n
            longer(i)%verdict = rules%rules(i)%verdict
            longer(i)%built_in = rules%rules(i)%built_in
            longer(i)%final = rules%rules(i)%final
            call move_alloc(rules%rules(i)%pattern, longer(i)%pattern)
         end do
         call move_alloc(longer, rules%rules)
      end if
      rules%n = rules%n + 1
      rules%rules(rules%n)%pattern = rule%pattern
      rules%rules(rules%n)%verdict = rule%verdict
   end subroutine append

   !> Number of rules.
   pure function count_rules(self) result(n)
      class(rules_type), intent(in) :: self
      integer :: n

      n = self%n
   end function count_rules

   !> What the rules say about an object or attribute: the last one that matches.
   pure function find_verdict(self, path, attribute) result(verdict)
      class(rules_type), intent(in) :: self
      character(len=*), intent(in) :: path
      !> Name of its attribute; empty for the object itself.
      character(len=*), intent(in) :: attribute
      !> What they say; exact if none matches.
      type(verdict_type) :: verdict
      integer :: i
      logical :: found

      found = .false.
      do i = 1, self%n
         if (.not. self%rules(i)%final) cycle
         if (.not. stands_for(self%rules(i)%pattern, path, attribute)) cycle
         verdict = self%rules(i)%verdict
         return
      end do
      do i = self%n, 1, -1
         if (found .and. .not. self%rules(i)%built_in) cycle
         if (.not. stands_for(self%rules(i)%pattern, path, attribute)) cycle
         verdict = self%rules(i)%verdict
         found = .true.
         if (verdict%ignore .or. self%rules(i)%built_in) return
         ! A rule that names what it is about outdoes the built-in ones.
         if (scan(self%rules(i)%pattern, "*?[") == 0) return
      end do
   end function find_verdict

   !> Whether a pattern stands for an object or attribute.
   pure logical function stands_for(pattern, path, attribute)
      character(len=*), intent(in) :: pattern
      character(len=*), intent(in) :: path
      !> Name of its attribute; empty for the object itself.
      character(len=*), intent(in) :: attribute

      stands_for = matches(pattern, path)
      if (stands_for .or. attribute == "" .or. index(pattern, "@") == 0) return
      stands_for = matches(pattern, path // "@" // attribute)
   end function stands_for

   !> Whether a pattern stands for a text.
   pure logical function matches(pattern, text)
      character(len=*), intent(in) :: pattern
      character(len=*), intent(in) :: text
      ! Place after the last '*' met, and of the text that it has to go on with: only that one need
      ! be tried again, so the time is at most the product of the lengths.
      integer :: star, again, p, t, width

      p = 1
      t = 1
      star = 0
      again = 0
      do while (t <= len(text))
         width = 0
         if (p <= len(pattern)) then
            if (pattern(p:p) == "*") then
               star = p + 1
               again = t
               p = p + 1
               cycle
            end if
            call match_one(pattern, p, text(t:t), width)
         end if
         if (width > 0) then
            p = p + width
            t = t + 1
         else if (star > 0) then
            again = again + 1
            t = again
            p = star
         else
            matches = .false.
            return
         end if
      end do
      matches = verify(pattern(p:), "*") == 0
   end function matches

   !> Match one character.
   pure subroutine match_one(pattern, p, c, width)
      character(len=*), intent(in) :: pattern
      !> Place in it.
      integer, intent(in) :: p
      character(len=1), intent(in) :: c
      !> Characters of the pattern that stand for it, 0 if they do not.
      integer, intent(out) :: width
      integer :: i, last
      logical :: negated, inside

      width = 0
      select case (pattern(p:p))
      case ("?")
         width = 1
      case ("[")
         last = set_end(pattern, p)
         if (last == 0) return
         i = p + 1
         negated = pattern(i:i) == "!"
         if (negated) i = i + 1
         inside = .false.
         do while (i < last)
            if (i + 2 < last .and. pattern(min(i + 1, last):min(i + 1, last)) == "-") then
               inside = inside .or. (ichar(c) >= ichar(pattern(i:i)) .and. &
                  ichar(c) <= ichar(pattern(i + 2:i + 2)))
               i = i + 3
            else
               inside = inside .or. c == pattern(i:i)
               i = i + 1
            end if
         end do
         if (inside .neqv. negated) width = last - p + 1
      case default
         if (pattern(p:p) == c) width = 1
      end select
   end subroutine match_one

end module contensou_compare_rules
