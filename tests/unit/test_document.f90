!> Tests of the text tools, of the report of mistakes, and of the reader of namelist syntax.
module test_document
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite, ieee_is_nan
   use contensou_base_diagnostics, only : diagnostics_type, origin_type, source_type
   use contensou_base_document, only : document_type, parse_document, parse_value_list, &
      read_document, value_expression, value_integer, value_logical, value_null, value_real, &
      value_text, value_type
   use contensou_base_errors, only : error_type, status_file, status_usage
   use contensou_base_expressions, only : constant_known, constants_type, evaluate, fault_type
   use contensou_base_kinds, only : i8, wp
   use contensou_base_numbers, only : read_real, to_text
   use contensou_base_text, only : edit_distance, join, lower, nearest, quote, shorten, &
      starts_with, string_type, strings
   implicit none(type, external)
   private

   public :: run_document_tests

   abstract interface
      !> Count a test as passed or failed.
      subroutine check_interface(condition, name)
         implicit none(type, external)
         !> Whether the test passed.
         logical, intent(in) :: condition
         !> What was tested.
         character(len=*), intent(in) :: name
      end subroutine check_interface
   end interface

   !> Line end.
   character(len=1), parameter :: lf = achar(10)

   !> Carriage return.
   character(len=1), parameter :: cr = achar(13)

   !> Horizontal tab.
   character(len=1), parameter :: tab = achar(9)

   !> U+00FC in UTF-8.
   character(len=2), parameter :: umlaut = char(195) // char(188)

contains

   !> Run all tests.
   subroutine run_document_tests(check, folder)
      !> Called once for each test.
      procedure(check_interface) :: check
      !> Folder to write to.
      character(len=*), intent(in) :: folder

      call test_text(check)
      call test_real_text(check)
      call test_nearest(check)
      call test_render(check)
      call test_long_lines(check)
      call test_syntax(check)
      call test_values(check)
      call test_expressions(check)
      call test_subscripts(check)
      call test_line_ends(check)
      call test_mistakes(check)
      call test_group_mistakes(check)
      call test_recovery(check)
      call test_limits(check)
      call test_value_list(check)
      call test_files(check, folder // '/test_document.tmp')
      call test_mutations(check)
   end subroutine run_document_tests

   !> Case, quoting, joining.
   subroutine test_text(check)
      !> Called once for each test.
      procedure(check_interface) :: check

      type(string_type) :: list(3)

      list(1)%s = 'a'
      list(2)%s = ''
      list(3)%s = 'bc'
      call check(lower('AbZ' // umlaut // '9') == 'abz' // umlaut // '9', 'lower: ASCII only')
      call check(to_text(-42) == '-42', 'to_text: integer')
      call check(to_text(huge(0_i8)) == '9223372036854775807', 'to_text: long integer')
      call check(to_text(.true.) == '.true.' .and. to_text(.false.) == '.false.', &
         & 'to_text: logical')
      call check(join(list, ', ') == 'a, , bc', 'join: with an empty text')
      call check(join(list(1:0), ', ') == '', 'join: of nothing')
      call check(join(strings(['a ', 'bc', ' d']), ', ') == 'a, bc,  d', &
         & 'strings: without blanks at the end')
      call check(quote('it''s') == '''it''''s''', 'quote: doubles quotes')
      call check(quote('') == '''''', 'quote: empty text')
      call check(starts_with('scene', 'sc') .and. .not. starts_with('s', 'sc'), 'starts_with')
      call check(starts_with('scene', ''), 'starts_with: empty beginning')
      call check(shorten('abcdefgh', 8) == 'abcdefgh', 'shorten: short enough')
      call check(shorten('abcdefghi', 8) == 'abcde...', 'shorten: too long')
      call check(shorten('abcd' // umlaut // 'efgh', 8) == 'abcd...', &
         & 'shorten: does not cut a character')
   end subroutine test_text

   !> Real numbers to text and back.
   subroutine test_real_text(check)
      !> Called once for each test.
      procedure(check_interface) :: check

      real(wp) :: x, y
      integer(i8) :: state
      integer :: i, n_bad, scale
      logical :: valid

      call check(to_text(0.3_wp) == '0.3', 'to_text: 0.3')
      call check(to_text(1.0e-8_wp) == '1.0e-8', 'to_text: 1.0e-8')
      call check(to_text(9.81_wp) == '9.81', 'to_text: 9.81')
      call check(to_text(6.0e-3_wp) == '6.0e-3', 'to_text: 6.0e-3')
      call check(to_text(180.0_wp) == '180.0', 'to_text: 180.0')
      call check(to_text(-9.1e9_wp) == '-9.1e9', 'to_text: -9.1e9')
      call check(to_text(0.0120149875041659_wp) == '0.0120149875041659', &
         & 'to_text: many digits below one')
      call check(to_text(123456.75_wp) == '123456.75', 'to_text: largest fixed exponent')
      call check(to_text(1.0e6_wp) == '1.0e6', 'to_text: smallest large exponent')
      call check(to_text(0.0_wp) == '0.0' .and. to_text(-0.0_wp) == '-0.0', 'to_text: zeros')
      call check(to_text(tiny(x)) == '2.2250738585072014e-308', 'to_text: tiny')
      call check(to_text(huge(x)) == '1.7976931348623157e308', 'to_text: huge')

      call read_real('NaN', x, valid)
      call check(valid .and. ieee_is_nan(x) .and. to_text(x) == 'NaN', 'to_text: NaN')
      call read_real('-infinity', x, valid)
      call check(valid .and. to_text(x) == '-Infinity', 'to_text: -Infinity')
      call read_real('+INF', x, valid)
      call check(valid .and. to_text(x) == 'Infinity', 'to_text: Infinity')

      n_bad = 0
      state = 7
      do i = 1, 2000
         call advance(state)
         scale = int(modulo(state, 600_i8)) - 300
         call advance(state)
         x = real(state, wp) / 1.0e9_wp * 10.0_wp**scale
         call read_real(to_text(x), y, valid)
         if (.not. valid .or. transfer(x, 0_i8) /= transfer(y, 0_i8)) n_bad = n_bad + 1
         if (scan(to_text(x), '.e') == 0) n_bad = n_bad + 1
      end do
      call check(n_bad == 0, 'to_text: 2000 random numbers read back unchanged')

      call read_real('1.7976931348623158079e308', x, valid)
      call check(valid .and. ieee_is_finite(x), 'read_real: rounds down to the largest double')
      call read_real('1.7976931348623159e308', x, valid)
      call check(valid .and. .not. ieee_is_finite(x), 'read_real: rounds up to infinity')
      call read_real('0.' // repeat('0', 400) // '25e401', x, valid)
      call check(valid .and. abs(x - 2.5_wp) < epsilon(x), 'read_real: digits and exponent cancel')
      call read_real('1' // repeat('0', 5000) // 'e-5000', x, valid)
      call check(valid .and. abs(x - 1.0_wp) < epsilon(x), 'read_real: more digits than kept')
      call read_real('9007199254740993' // repeat('0', 900) // '1e-901', x, valid)
      call check(valid .and. nint(x, i8) == 9007199254740994_i8, &
         & 'read_real: a digit far behind decides rounding')
      call read_real('1e99999999999999999999', x, valid)
      call check(valid .and. .not. ieee_is_finite(x), 'read_real: absurd exponent')
      call read_real('-1e-99999999999999999999', x, valid)
      call check(valid .and. to_text(x) == '-0.0', 'read_real: absurd negative exponent')
      call check(.not. any([is_real(''), is_real('.'), is_real('+'), is_real('e5'), &
         & is_real('1e'), is_real('1e+'), is_real('1.0.0'), is_real('1f'), is_real('0x1'), &
         & is_real('in'), is_real('nan('), is_real('nan(%)'), is_real('1 '), is_real('--1')]), &
         & 'read_real: what is no number')
   end subroutine test_real_text

   !> Whether a text is a real number.
   pure function is_real(s) result(is)
      !> The text.
      character(len=*), intent(in) :: s
      !> The answer.
      logical :: is

      real(wp) :: x

      call read_real(s, x, is)
   end function is_real

   !> Edit distance and nearest words.
   subroutine test_nearest(check)
      !> Called once for each test.
      procedure(check_interface) :: check

      character(len=*), parameter :: keys(*) = [character(len=24) :: &
         & 'name', 'mass', 'inertia', 'friction', 'friction_coefficient', 'angular_velocity']
      type(string_type) :: list(2)

      list(1)%s = 'sphere'
      list(2)%s = 'plane'
      call check(edit_distance('', 'abc') == 3 .and. edit_distance('abc', '') == 3, &
         & 'edit_distance: empty text')
      call check(edit_distance('kitten', 'sitting') == 3, 'edit_distance: substitution')
      call check(edit_distance('mass', 'amss') == 1, 'edit_distance: swap')
      call check(edit_distance('ca', 'abc') == 3, 'edit_distance: optimal string alignment')
      call check(nearest('mas', keys) == 2, 'nearest: missing letter')
      call check(nearest('MASS', keys) == 2, 'nearest: case does not matter')
      call check(nearest('frictoin', keys) == 4, 'nearest: swapped letters')
      call check(nearest('fric', keys) == 4, 'nearest: beginning of a candidate')
      call check(nearest('velocity', keys) == 6, 'nearest: part of a candidate')
      call check(nearest('colour', keys) == 0, 'nearest: nothing near')
      call check(nearest('x', keys) == 0 .and. nearest('', keys) == 0, &
         & 'nearest: too short to be near')
      call check(nearest('spehre', list) == 1, 'nearest: list of texts')
   end subroutine test_nearest

   !> The form in which mistakes are shown.
   subroutine test_render(check)
      !> Called once for each test.
      procedure(check_interface) :: check

      type(diagnostics_type) :: diagnostics, many
      type(source_type) :: sources(2)
      character(len=:), allocatable :: text
      integer :: i

      sources(1)%name = 'scene.nml'
      allocate(sources(1)%lines(5), sources(2)%lines(1))
      sources(1)%lines(1)%s = tab // 'a' // tab // 'b ' // umlaut // ' cc'
      sources(1)%lines(2)%s = 'x' // achar(1) // char(255) // ' y'
      sources(1)%lines(3)%s = ''
      sources(1)%lines(4)%s = 'end'
      sources(1)%lines(5)%s = '&body name = ''top'', mas = 6.0e-3'
      sources(2)%name = '--set integrator.rtol=x'
      sources(2)%lines(1)%s = 'x'

      call check(diagnostics%render(sources) == '', 'render: nothing')
      call diagnostics%add(origin_type(1, 5, 21, 3), 'unknown key ''mas'' in group &body', 'mass')
      call check(diagnostics%render(sources) == &
         & 'scene.nml:5:21: error: unknown key ''mas'' in group &body' // lf // &
         & '    5 | &body name = ''top'', mas = 6.0e-3' // lf // &
         & '      |                     ^~~' // lf // &
         & '  expected: mass' // lf, 'render: place, line, caret and what is expected')

      call diagnostics%add(origin_type(2, 1, 1, 1), 'second source')
      call diagnostics%add(origin_type(1, 2, 5, 1), 'fifth byte')
      call diagnostics%add(origin_type(1, 2, 1, 4), 'first byte')
      call diagnostics%add(origin_type(1, 0, 0, 1), 'no line')
      call diagnostics%add(origin_type(1, 1, 9, 2), 'behind tabs and UTF-8')
      call diagnostics%add(origin_type(1, 4, 4, 1), 'behind the end')
      call diagnostics%add(origin_type(), 'no source')
      text = diagnostics%render(sources)
      call check(diagnostics%count() == 8, 'count: of all mistakes')
      call check(starts_with(text, 'error: no source' // lf // 'scene.nml: error: no line' // lf), &
         & 'render: without source and without line')
      call check(index(text, 'scene.nml:1:8: error: behind tabs and UTF-8' // lf // &
         & '    1 | ' // tab // 'a' // tab // 'b ' // umlaut // ' cc' // lf // &
         & '      | ' // tab // ' ' // tab // '    ^~' // lf) > 0, &
         & 'render: tabs are kept, characters are counted')
      call check(index(text, '    2 | x?? y' // lf // '      | ^~~~' // lf) > 0, &
         & 'render: bytes that cannot be printed')
      call check(index(text, 'scene.nml:4:4: error: behind the end' // lf // &
         & '    4 | end' // lf // '      |    ^' // lf) > 0, 'render: caret behind the line')
      call check(index(text, '--set integrator.rtol=x:1:1: error: second') > 0, &
         & 'render: setting from the command line')
      call check(index(text, 'first byte') < index(text, 'fifth byte') &
         & .and. index(text, 'fifth byte') < index(text, 'behind the end') &
         & .and. index(text, 'unknown key') < index(text, 'second source'), 'render: sorted')
      call check(diagnostics%kept() == 8 .and. diagnostics%message(1) == &
         & 'unknown key ''mas'' in group &body' .and. diagnostics%expected(1) == 'mass' &
         & .and. diagnostics%expected(2) == '', 'diagnostics: one by one')

      do i = 1, 101
         call many%add(origin_type(1, 4, 1, 1), 'again ' // to_text(i))
      end do
      call many%add(origin_type(1, 4, 1, 1), 'again 101')
      call check(many%count() == 101, 'diagnostics: the same mistake at the same place once')
      call check(ends_with(many%render(sources), '... and 1 more error' // lf), &
         & 'render: one more than is shown')
      do i = 1, 3000
         call many%add(origin_type(1, 4, 1, 1), 'again ' // to_text(i))
      end do
      call check(many%count() == 3101 .and. &
         & ends_with(many%render(sources), '... and 3001 more errors' // lf), &
         & 'render: at most 100 are shown')
   end subroutine test_render

   !> Lines that are too long to be shown.
   subroutine test_long_lines(check)
      !> Called once for each test.
      procedure(check_interface) :: check

      type(source_type) :: sources(1)
      integer :: column, n_bad

      sources(1)%name = 's'
      allocate(sources(1)%lines(1))
      sources(1)%lines(1)%s = repeat('a', 100)
      call check(index(rendered(sources, 100), '| ' // repeat('a', 100) // lf) > 0, &
         & 'render: a line of 100 characters is shown whole')
      sources(1)%lines(1)%s = repeat('a', 101)
      call check(index(rendered(sources, 1), '| ' // repeat('a', 100) // '...' // lf) > 0, &
         & 'render: a longer line is cut on the right')
      call check(index(rendered(sources, 101), '| ...' // repeat('a', 100) // lf) > 0, &
         & 'render: a longer line is cut on the left')
      sources(1)%lines(1)%s = repeat(umlaut, 500)
      call check(index(rendered(sources, 501), '| ...' // repeat(umlaut, 100) // '...') > 0, &
         & 'render: a long line is cut on both sides')

      n_bad = 0
      sources(1)%lines(1)%s = repeat('abcdefghi' // umlaut, 30)
      do column = 1, len(sources(1)%lines(1)%s), 11
         if (marked(rendered(sources, column)) /= 'a') n_bad = n_bad + 1
         if (marked(rendered(sources, column + 8)) /= 'i') n_bad = n_bad + 1
      end do
      call check(n_bad == 0, 'render: the caret of a cut line stands below its character')
   end subroutine test_long_lines

   !> Text of one mistake in the first line.
   pure function rendered(sources, column) result(text)
      !> Source with one line.
      type(source_type), intent(in) :: sources(:)
      !> Column of the mistake.
      integer, intent(in) :: column
      character(len=:), allocatable :: text

      type(diagnostics_type) :: diagnostics

      call diagnostics%add(origin_type(1, 1, column, 1), 'x')
      text = diagnostics%render(sources)
   end function rendered

   !> ASCII character above the caret.
   pure function marked(text) result(c)
      !> Text of one mistake.
      character(len=*), intent(in) :: text
      character(len=1) :: c

      integer :: first, i, n

      first = index(text, lf) + 1
      n = index(text(first + index(text(first:), lf):), '^')
      do i = first, len(text)
         if (iand(ichar(text(i:i)), 192) /= 128) n = n - 1
         if (n == 0) exit
      end do
      c = text(i:i)
   end function marked

   !> Whether a text ends with another.
   pure function ends_with(s, tail) result(does)
      !> The text.
      character(len=*), intent(in) :: s
      !> The end.
      character(len=*), intent(in) :: tail
      !> The answer.
      logical :: does

      does = .false.
      if (len(s) >= len(tail)) does = s(len(s) - len(tail) + 1:) == tail
   end function ends_with

   !> Groups, keys, comments.
   subroutine test_syntax(check)
      !> Called once for each test.
      procedure(check_interface) :: check

      type(document_type) :: d
      type(diagnostics_type) :: g

      call parse(sample(), d, g)
      call check(g%count() == 0 .and. d%complete, 'sample scene: no mistakes')
      call check(size(d%groups) == 7 .and. d%n_groups == 7, 'sample scene: number of groups')
      call check(d%groups(2)%name == 'material' .and. d%groups(2)%complete, 'group: name')
      call check(same(d%groups(3)%origin, 4, 1, 5), 'group: origin')
      call check(size(d%groups(3)%assignments) == 8 .and. d%groups(3)%n_assignments == 8, &
         & 'group: number of assignments')
      call check(d%groups(3)%assignments(3)%key == 'inertia', 'key: in lower case')
      call check(same(d%groups(3)%assignments(3)%origin, 4, 36, 7), 'key: origin')
      call check(size(d%groups(3)%assignments(3)%values) == 3, 'values: several')
      call check(same(d%groups(3)%assignments(4)%values(3)%origin, 5, 29, 18), 'value: origin')
      call check(d%groups(4)%assignments(2)%values(2)%text == 'top', 'values: several texts')
      call check(same(d%groups(4)%assignments(2)%values(2)%origin, 7, 42, 5), 'text: origin')
      call check(d%sources(1)%name == 'scene.nml' .and. &
         & d%sources(1)%lines(7)%s(42:46) == '''top''', 'document: keeps the lines')

      call parse('', d, g)
      call check(g%count() == 0 .and. size(d%groups) == 0, 'empty file')
      call parse('! only' // lf // '  ! comments &x y = 1 /', d, g)
      call check(g%count() == 0 .and. size(d%groups) == 0, 'only comments')
      call parse('&a/ &b / &C x = 1 &end &d &END', d, g)
      call check(g%count() == 0 .and. size(d%groups) == 4, 'empty groups, &end, several in a line')
      call check(d%groups(3)%name == 'c', 'group: name in lower case')
      call parse('&a x=1,y=2 z=3,,' // lf // 'w' // lf // '! c' // lf // '=' // lf // '4 /', d, g)
      call check(g%count() == 0 .and. size(d%groups(1)%assignments) == 4, &
         & 'several assignments in a line, one over several lines')
      call parse('&a x = 1! one' // lf // '! y = 2 /' // lf // ', 2 /! end', d, g)
      call check(g%count() == 0 .and. size(d%groups(1)%assignments(1)%values) == 2, &
         & 'comments between values')
      call parse('&a x = ''a ! b'' ! c ''' // lf // ' /', d, g)
      call check(g%count() == 0 .and. d%groups(1)%assignments(1)%values(1)%text == 'a ! b', &
         & 'exclamation mark inside a text')
      call parse('&a t = 1, f = 2 inf=3 nan = 4, t = t f=F /', d, g)
      call check(g%count() == 0 .and. size(d%groups(1)%assignments) == 6, &
         & 'T, F, inf and nan before an equals sign are keys')
      call parse('&a x = /', d, g)
      call check(g%count() == 0 .and. size(d%groups(1)%assignments(1)%values) == 0, &
         & 'nothing after the equals sign')
      call parse('&a title = "' // umlaut // '" ! ' // umlaut // lf // '/', d, g)
      call check(g%count() == 0 .and. d%groups(1)%assignments(1)%values(1)%text == umlaut, &
         & 'UTF-8 in texts and comments')
   end subroutine test_syntax

   !> All forms of values.
   subroutine test_values(check)
      !> Called once for each test.
      procedure(check_interface) :: check

      type(document_type) :: d
      type(diagnostics_type) :: g
      integer :: i, k

      call parse('&a x = 7 -7 +7 007, 9223372036854775807 -9223372036854775807 /', d, g)
      associate (v => d%groups(1)%assignments(1)%values)
         call check(g%count() == 0 .and. all(v%kind == value_integer), 'integers: kind')
         call check(all(v%integer == [7_i8, -7_i8, 7_i8, 7_i8, huge(0_i8), -huge(0_i8)]), &
            & 'integers: value')
         call check(all(near(v(1:4)%real, [7.0_wp, -7.0_wp, 7.0_wp, 7.0_wp])), &
            & 'integers: value as real')
      end associate

      call parse('&a x = 1.0d-3 1E5 .5 5. +1.5 1.5-3 1.5D+2 1e-400 9223372036854775808 -.5e1/', &
         & d, g)
      associate (v => d%groups(1)%assignments(1)%values)
         call check(g%count() == 0 .and. all(v%kind == value_real), 'reals: kind')
         call check(all(near(v%real, [1.0e-3_wp, 1.0e5_wp, 0.5_wp, 5.0_wp, 1.5_wp, 1.5e-3_wp, &
            & 150.0_wp, 0.0_wp, 9223372036854775808.0_wp, -5.0_wp])), 'reals: value')
      end associate

      call parse('&a x = inf -Infinity +INF nan NaN(12ab) -nan() /', d, g)
      associate (v => d%groups(1)%assignments(1)%values)
         call check(g%count() == 0 .and. size(v) == 6 .and. all(v%kind == value_real), &
            & 'infinity and NaN: kind')
         call check(.not. any(ieee_is_finite(v%real)) .and. &
            & all(ieee_is_nan(v%real) .eqv. [.false., .false., .false., .true., .true., .true.]), &
            & 'infinity and NaN: value')
         call check(v(5)%origin%length == 9, 'NaN: origin')
      end associate

      call parse('&a x = .true. .TRUE .t. .T t true, .false. .f F False /', d, g)
      associate (v => d%groups(1)%assignments(1)%values)
         call check(g%count() == 0 .and. all(v%kind == value_logical), 'logicals: kind')
         call check(all(v%logical .eqv. [(i <= 6, i = 1, 10)]), 'logicals: value')
      end associate

      call parse('&a x = ''it''''s'' "say ""no""" '''' ''"'' "''" ''&a / ! ='' /', d, g)
      associate (v => d%groups(1)%assignments(1)%values)
         call check(g%count() == 0 .and. all(v%kind == value_text), 'texts: kind')
         call check(v(1)%text == 'it''s' .and. v(2)%text == 'say "no"', 'texts: doubled quotes')
         call check(len(v(3)%text) == 0, 'texts: empty')
         call check(v(4)%text == '"' .and. v(5)%text == '''', 'texts: the other quote')
         call check(v(6)%text == '&a / ! =', 'texts: special characters')
      end associate

      call parse('&a x = 3*0.5, 2*''ab'' 2*.true. 3* 1*nan /', d, g)
      associate (v => d%groups(1)%assignments(1)%values)
         call check(g%count() == 0 .and. size(v) == 11, 'repeat counts: number of values')
         call check(v(3)%kind == value_real .and. v(5)%text == 'ab' .and. v(7)%logical &
            & .and. all(v(8:10)%kind == value_null), 'repeat counts: values')
         call check(same(v(2)%origin, 1, 8, 5) .and. same(v(4)%origin, 1, 15, 6) .and. &
            & same(v(10)%origin, 1, 31, 2), 'repeat counts: origin')
      end associate

      call parse('&a x = , 1,, 2,' // lf // ', 3,, y = 1 /', d, g)
      associate (v => d%groups(1)%assignments(1)%values)
         call check(g%count() == 0 .and. size(v) == 7, 'null values: number of values')
         call check(all(v%kind == [value_null, value_integer, value_null, value_integer, &
            & value_null, value_integer, value_null]), 'null values: kind')
      end associate

      ! Expressions, which end where a value does.
      call parse('&a x = 2**3, 1/2 3*0.5 2*0.5*4 (1+ 2)/3 2 - 1 -1 2*deg 2*t/ &b y = 1.5-3/', d, g)
      call check(g%count() == 0 .and. d%n_groups == 2, 'expressions: groups')
      associate (v => d%groups(1)%assignments(1)%values)
         call check(size(v) == 12, 'expressions: number')
         call check(all([(v(k)%kind, k=1, 12)] == [value_expression, value_expression, &
            & value_real, value_real, value_real, value_expression, value_expression, &
            & value_expression, value_integer, value_expression, value_logical, value_logical]), &
            & 'expressions: kinds')
         call check(v(1)%text == '2**3' .and. v(2)%text == '1/2' .and. v(6)%text == '2*0.5*4' &
            & .and. v(7)%text == '(1+ 2)/3' .and. v(8)%text == '2 - 1' .and. &
            & v(10)%text == '2*deg', 'expressions: texts')
         call check(same(v(7)%origin, 1, 32, 8), 'expressions: place')
      end associate
      associate (v => d%groups(2)%assignments(1)%values)
         call check(v(1)%kind == value_real .and. abs(v(1)%real - 1.5e-3_wp) <= 0.0_wp, &
            & 'expressions: an exponent without letter stays one')
      end associate
      call parse('&a x = 30 deg, -9e1  Deg - 2 deg 1 degree = 2, 4.5 deg/', d, g)
      associate (v => d%groups(1)%assignments(1)%values)
         call check(size(v) == 3, 'degrees: number')
         call check(v(1)%text == '30 deg' .and. v(2)%text == '-9e1  Deg - 2 deg' .and. &
            & v(3)%kind == value_integer, 'degrees: texts')
      end associate
      call check(d%groups(1)%n_assignments == 2 .and. &
         & d%groups(1)%assignments(2)%values(2)%text == '4.5 deg', 'degrees: at the end')
      call parse('&a x = m, 2*m, m /' // lf // '&constants m = 1/2, k = m+1 /', d, g)
      call check(g%count() == 0 .and. size(d%constant_names) == 2, 'constants: known before')
   end subroutine test_values

   !> Values of expressions, and what is wrong with them.
   subroutine test_expressions(check)
      !> Called once for each test.
      procedure(check_interface) :: check

      type(constants_type) :: constants
      integer :: k

      call constants%add('r', '0.01', origin_type())
      constants%items(1)%value = 0.01_wp
      constants%items(1)%state = constant_known
      call worth('4/3*pi*r**3*7850', 4.0_wp/3.0_wp*3.14159265358979324_wp*1.0e-6_wp*7850.0_wp)
      call worth('-2**2', -4.0_wp)
      call worth('2**3**2/128', 4.0_wp)
      call worth('2**-1 + 2*-3', -5.5_wp)
      call worth('1-2-3*(4-6)', 5.0_wp)
      call worth('8/4/2', 1.0_wp)
      call worth('30 deg', 0.523598775598298873_wp)
      call worth('180 deg - 30*DEG - 150 deg', 0.0_wp)
      call worth('sqrt(16)*max(1, 3, 2) + Atan2(0, 1) - abs(-2)', 10.0_wp)
      call worth('cos(0)+sin(0)+tan(0)+asin(0)+acos(1)+atan(0)+exp(0)+log(1)+log10(100)', 4.0_wp)
      call worth('sinh(0)+cosh(0)+tanh(0)+min(2, 1)', 2.0_wp)
      call worth('1.5d3*1.e-3 + .5', 2.0_wp)
      call worth('1-2', -1.0_wp)
      call worth('0**0', 1.0_wp)
      call worth('2**0.5*2**0.5', 2.0_wp)
      call wrong('1/0', 2, 'division by zero')
      call wrong('1/(r-r)', 2, 'division by zero')
      call wrong('0**-1', 2, 'division by zero')
      call wrong('(0-8)**(1/3)', 6, 'no power of a fraction')
      call wrong('1e300*1e300', 6, 'too large')
      call wrong('1e308+1e308', 6, 'too large')
      call wrong('1e300/1e-300', 6, 'too large')
      call wrong('10**400', 3, 'too large')
      call wrong('exp(1000)', 1, 'too large')
      call wrong('cosh(1000)', 1, 'too large')
      call wrong('1e999', 1, 'too large')
      call wrong('2*q', 3, 'no constant ''q''')
      call wrong('2*sine(r)', 3, 'no function ''sine''')
      call wrong('sin(1, 2)', 1, 'has 2 arguments')
      call wrong('min(1)', 1, 'has 1 argument')
      call wrong('sqrt(-1)', 1, 'not defined')
      call wrong('log(0)', 1, 'not defined')
      call wrong('asin(2)', 1, 'not defined')
      call wrong('atan2(0, 0)', 1, 'not defined')
      call wrong('2*(r+1', 6, ''')'' is missing')
      call wrong('2*r)', 4, ''')'' without')
      call wrong('2*', 2, 'not complete')
      call wrong('2 3', 3, 'unexpected ''3''')
      call wrong('2..3', 1, 'not a number')
      call wrong('2x', 1, 'not a number')
      call wrong('', 1, 'not complete')
      call wrong(repeat('(', 5000) // '1', 100, 'too many levels')
      call wrong('2' // repeat('**2', 5000), 200, 'too many exponents')

   contains

      !> An expression is worth a number.
      subroutine worth(text, x)
         character(len=*), intent(in) :: text
         real(wp), intent(in) :: x
         type(fault_type) :: fault
         real(wp) :: value

         call evaluate(text, constants, value, fault)
         call check(.not. fault%found .and. abs(value - x) <= 4.0_wp*epsilon(x)*abs(x) + &
            & 1.0e-30_wp, 'expression: ' // text)
      end subroutine worth

      !> An expression has a mistake near a column.
      subroutine wrong(text, column, message)
         character(len=*), intent(in) :: text
         integer, intent(in) :: column
         character(len=*), intent(in) :: message
         type(fault_type) :: fault
         real(wp) :: value

         call evaluate(text, constants, value, fault)
         k = 0
         if (fault%found) k = index(fault%message, message)
         call check(k > 0 .and. abs(value) <= 0.0_wp .and. (fault%column == column .or. &
            & column >= 100), 'expression: mistake in ' // shorten(text, 40))
      end subroutine wrong

   end subroutine test_expressions

   !> Whether two numbers agree to rounding.
   elemental function near(a, b) result(is)
      !> First number.
      real(wp), intent(in) :: a
      !> Second number.
      real(wp), intent(in) :: b
      !> The answer.
      logical :: is

      is = abs(a - b) <= epsilon(a) * abs(b)
   end function near

   !> Subscripts of keys.
   subroutine test_subscripts(check)
      !> Called once for each test.
      procedure(check_interface) :: check

      type(document_type) :: d
      type(diagnostics_type) :: g

      call parse('&a p=1 p(2)=1 p(1:3) = 3*0 p(:)=1, p (2:) = 1 p( : 3 )=1 /', d, g)
      associate (a => d%groups(1)%assignments)
         call check(g%count() == 0 .and. size(a) == 6, 'subscripts: after values')
         call check(all(a%first == [0, 2, 1, 1, 2, 1]), 'subscripts: first')
         call check(all(a%last == [0, 2, 3, -1, -1, 3]), 'subscripts: last')
      end associate
      call expect(check, '&a p(0) = 1 /', 1, 5, 'bad subscript', 'subscript: zero')
      call expect(check, '&a p(x) = 1 /', 1, 5, 'bad subscript', 'subscript: a word')
      call expect(check, '&a p(1,2) = 1 /', 1, 5, 'bad subscript', 'subscript: two dimensions')
      call expect(check, '&a p(3:1) = 1 /', 1, 5, 'bad subscript', 'subscript: backwards')
      call expect(check, '&a p(1:3:2) = 1 /', 1, 5, 'bad subscript', 'subscript: stride')
      call expect(check, '&a p() = 1 /', 1, 5, 'bad subscript', 'subscript: empty')
      call expect(check, '&a p(99999999999) = 1 /', 1, 5, 'bad subscript', 'subscript: too large')
      call expect(check, '&a p(1 = 1, q = 2 /', 1, 5, 'not closed', 'subscript: not closed')
      call expect(check, '&a a%b = 1 /', 1, 4, 'component', 'key: of a derived type')
      call expect(check, '&a x = 1, a(1)%b = 1 /', 1, 15, 'component', &
         & 'key: of an element of a derived type')
   end subroutine test_subscripts

   !> Line ends and marks at the beginning.
   subroutine test_line_ends(check)
      !> Called once for each test.
      procedure(check_interface) :: check

      character(len=*), parameter :: mark = char(239) // char(187) // char(191)
      type(document_type) :: d
      type(diagnostics_type) :: g

      call parse('&a x = 1' // cr // lf // 'y = ''b''' // cr // lf // '/' // cr // lf, d, g)
      call check(g%count() == 0 .and. size(d%groups(1)%assignments) == 2, 'CRLF')
      call check(d%sources(1)%lines(2)%s == 'y = ''b''' .and. size(d%sources(1)%lines) == 3, &
         & 'CRLF: not part of the lines')
      call parse('&a x = 1 /' // lf // '&b y = 2' // lf // '/', d, g)
      call check(g%count() == 0 .and. size(d%groups) == 2, 'no newline at the end')
      call parse(tab // '&a' // tab // 'x' // tab // '=' // tab // '1' // tab // '/', d, g)
      call check(g%count() == 0 .and. same(d%groups(1)%origin, 1, 2, 2), 'tabs')
      call parse(mark // '&a x = 1 /', d, g)
      call check(g%count() == 0 .and. same(d%groups(1)%origin, 1, 1, 2), 'byte order mark')
   end subroutine test_line_ends

   !> Mistakes in keys and values.
   subroutine test_mistakes(check)
      !> Called once for each test.
      procedure(check_interface) :: check

      call expect(check, '&a x 1, y = 2 /', 1, 4, '''='' missing', 'equals sign missing: first key')
      call expect(check, '&a y = 2, x 1 /', 1, 11, '''='' missing', &
         & 'equals sign missing: later key')
      call expect(check, '&a x ''b'' /', 1, 4, '''='' missing', 'equals sign missing: text')
      call expect(check, '&a = 3, y = 2 /', 1, 4, 'key missing', 'key missing')
      call expect(check, '&a x = 1, = 3 /', 1, 11, 'key missing', 'key missing after a value')
      call expect(check, '&a 3, 4, y = 2 /', 1, 4, 'value without a key', 'value without a key')
      call expect(check, '&a ''x'' = 3, y = 2 /', 1, 4, 'value without a key', 'key in quotes')
      call expect(check, '&a x == 3 /', 1, 7, 'second ''=''', 'doubled equals sign')
      call expect(check, '&a x: 3, y = 2 /', 1, 5, ''':'' after', 'colon for an equals sign')
      call expect(check, '&a y = 2, x := 3 /', 1, 13, ''':='' after', 'assignment sign')
      call expect(check, '&a my-key = 3 /', 1, 4, 'is not a key', 'key with a hyphen')
      call expect(check, '&a x = 1, 2nd = 3 /', 1, 11, 'is not a key', 'key with a digit first')
      call expect(check, '&a , x = 3 /', 1, 4, 'unexpected '',''', 'comma before the first key')
      call expect(check, '&a x = ''b, y = 2 /', 1, 8, 'not closed', 'quote is not closed')
      call expect(check, '&a x = ''b' // lf // 'y = 2 /', 1, 8, 'not closed', &
         & 'quote is not closed before the line end')
      call expect(check, '&a x = 2*"b ! c' // lf // '/', 1, 10, 'not closed', &
         & 'quote is not closed after a repeat count')
      call expect(check, '&a x = ''b''c, y = ''d'' /', 1, 11, 'directly followed by ''c''', &
         & 'text directly followed by a word')
      call expect(check, '&a x = ''b, y = ''c'', z = ''d'' /', 1, 17, 'directly followed by', &
         & 'quote is not closed before another text')
      call expect(check, '&a x = wood, y = 2 /', 1, 8, 'text ''wood'' needs quotes', 'bare word')
      call expect(check, '&a x = oak wood, y = 2 /', 1, 8, 'text ''oak wood'' needs quotes', &
         & 'two bare words')
      call expect(check, '&a x = out/a.h5 /', 1, 8, 'text ''out/a.h5'' needs quotes', 'bare path')
      call expect(check, '&a x = /tmp/a.h5, y = 2 /', 1, 8, 'text ''/tmp/a.h5''', &
         & 'bare absolute path')
      call expect(check, '&a x = don''t /', 1, 8, 'needs quotes', 'bare word with an apostrophe')
      call expect(check, '&a x = 1; y = 2 /', 1, 9, ''';''', 'semicolon')
      call expect(check, '&a x = 1.0.0, y = 2 /', 1, 8, 'not a number', 'number with two points')
      call expect(check, '&a x = 12abc /', 1, 8, 'not a number', 'number with letters')
      call expect(check, '&a x = 1e /', 1, 8, 'not a number', 'number without exponent')
      call expect(check, '&a x = -+3 /', 1, 8, 'not a number', 'number with two signs')
      call expect(check, '&a x = 1e400 /', 1, 8, 'too large for double', 'number too large')
      call expect(check, '&a x = 2*-1e309, y = 2 /', 1, 10, 'too large for double', &
         & 'repeated number too large')
      call expect(check, '&a x = .tru. /', 1, 8, 'not a logical', 'misspelt logical')
      call expect(check, '&a x = 0*1 /', 1, 8, 'repeat count', 'repeat count zero')
      call expect(check, '&a x = 1000001*1 /', 1, 8, 'repeat count', 'repeat count too large')
      call expect(check, '&a x = 99999999999999999999* /', 1, 8, 'repeat count', &
         & 'repeat count beyond integers')
      call expect(check, '&a x = (1, 2) /', 1, 8, 'unexpected ''(1, 2)''', 'complex number')
      call expect(check, '&a x = 1 # one' // lf // '/', 1, 10, '''#''', 'foreign comment')
      call expect(check, '&a x = 1, &' // lf // '2 /', 1, 11, 'unexpected ''&''', &
         & 'continuation mark')
      call expect(check, '&a x = ' // char(226) // char(128) // char(156) // 'b" /', 1, 8, &
         & 'typographic', 'typographic quotes')
      call expect(check, '&a x = } /', 1, 8, 'not a value', 'strange character')
      call expect(check, '&a x = 1' // achar(0) // ' /', 1, 8, 'not a number', 'zero byte')
   end subroutine test_mistakes

   !> Mistakes in groups.
   subroutine test_group_mistakes(check)
      !> Called once for each test.
      procedure(check_interface) :: check

      call expect(check, 'body x = 1 /' // lf // '&b y = 1 /', 1, 1, '''&'' missing', &
         & 'ampersand missing')
      call expect(check, '$body x = 1 /', 1, 1, '''&'' missing', 'dollar for ampersand')
      call expect(check, 'A scene, don''t / touch' // lf // '&b y = 1 /', 1, 1, &
         & 'outside any group', 'prose outside any group')
      call expect(check, '&a x = 1 /2, y = 3 /' // lf // '&b y = 1 /', 1, 11, 'outside any group', &
         & 'quotient with a blank')
      call expect(check, '&a x = 1 / / &b y = 1 /', 1, 12, 'outside any group', 'doubled slash')
      call expect(check, 'x = 1, y = 2 /' // lf // '&b y = 1 /', 1, 1, 'key ''x'' outside', &
         & 'keys outside any group')
      call expect(check, '&end &b y = 1 /', 1, 1, '&end outside', '&end outside any group')
      call expect(check, '# scene' // lf // '&b y = 1 /', 1, 1, '''#''', &
         & 'foreign comment outside any group')
      call expect(check, '&a x = 1' // lf // '&b y = 1 /', 1, 1, 'group &a is not closed', &
         & 'slash missing before the next group')
      call expect(check, '&b y = 1 /' // lf // ' &a x = 1' // lf, 2, 2, 'group &a is not closed', &
         & 'slash missing before the end of the file')
      call expect(check, '&a', 1, 1, 'group &a is not closed', 'only a name')
      call expect(check, '& a x = 1 /', 1, 1, 'name of a group', 'blank before the name')
      call expect(check, '& x = 1 /', 1, 1, 'name of a group', 'no name')
      call expect(check, '&my-body x = 1 /', 1, 1, 'not the name of a group', 'hyphen in the name')
      call expect(check, '&1a x = 1 /', 1, 1, 'not the name of a group', 'digit first in the name')
   end subroutine test_group_mistakes

   !> Going on after mistakes.
   subroutine test_recovery(check)
      !> Called once for each test.
      procedure(check_interface) :: check

      type(document_type) :: d
      type(diagnostics_type) :: g

      call parse('&a x = 1.0.0, y = wood, z = 1e999; 4' // lf // &
         & '&b p(0) = 1, q = 3' // lf // '/' // lf // 'c r = ''a' // lf // '/ &d s = 5 /', d, g)
      call check(g%count() == 8, 'all mistakes are reported at once')
      call check(size(d%groups) == 4 .and. .not. d%complete, 'groups after mistakes are read')
      call check(all(d%groups%complete .eqv. [.false., .false., .false., .true.]), &
         & 'groups with mistakes are marked')
      call check(d%groups(2)%assignments(1)%key == 'q' .and. &
         & d%groups(4)%assignments(1)%values(1)%integer == 5, 'keys after mistakes are read')
      call check(ends_with(g%expected(5), '''/'' before &b in line 2') .or. &
         & ends_with(g%expected(4), '''/'' before &b in line 2') .or. &
         & ends_with(g%expected(6), '''/'' before &b in line 2'), &
         & 'missing slash: says where it is missed')
      call parse('&a x = wood' // lf // '/', d, g)
      call check(g%expected(1) == '''wood''', 'bare word: expected with quotes')
   end subroutine test_recovery

   !> What is too much.
   subroutine test_limits(check)
      !> Called once for each test.
      procedure(check_interface) :: check

      type(document_type) :: d
      type(diagnostics_type) :: g

      call parse('&a x = 1000000*0 /', d, g)
      call check(g%count() == 0 .and. size(d%groups(1)%assignments(1)%values) == 1000000, &
         & 'a million values')
      call expect(check, '&a x = 1000000*0, 1 /', 1, 19, 'more than 1000000 values', &
         & 'more than a million values')
      call expect(check, '&a x = 1000000*''' // repeat('x', 100) // ''' /', 1, 8, &
         & 'characters of text', 'too much text by repetition')
      call expect(check, repeat(lf, 1000001), 0, 0, 'more than 1000000 lines', 'too many lines')
      call parse('&a x = ' // repeat('1', 400) // ', y = ' // repeat('b', 100000) // ' /', d, g)
      call check(g%count() == 2 .and. len(g%render(d%sources)) < 1000, 'messages stay short')
   end subroutine test_limits

   !> Values from the command line.
   subroutine test_value_list(check)
      !> Called once for each test.
      procedure(check_interface) :: check

      character(len=*), parameter :: name = '--set a.x=...'
      type(document_type) :: d
      type(diagnostics_type) :: g, g_bad, g_bare
      type(value_type), allocatable :: v(:)

      call parse('&a x = 1 /', d, g)
      call parse_value_list(name, '0, 2*0.5,''b''', v, d, g)
      call check(g%count() == 0 .and. size(v) == 4 .and. d%complete, 'value list: values')
      call check(size(d%sources) == 2 .and. d%sources(2)%name == name .and. &
         & d%sources(2)%lines(1)%s == '0, 2*0.5,''b''', 'value list: new source')
      call check(v(4)%origin%source == 2 .and. same(v(4)%origin, 1, 10, 3), 'value list: origin')
      call check(d%sources(1)%name == 'scene.nml', 'value list: sources are kept')
      call parse_value_list(name, '', v, d, g)
      call check(g%count() == 0 .and. size(v) == 0, 'value list: empty')

      call parse_value_list(name, '1/2', v, d, g)
      call check(g%count() == 0 .and. size(v) == 1 .and. v(1)%kind == value_expression &
         & .and. v(1)%text == '1/2', 'value list: quotient')
      call parse_value_list(name, '/', v, d, g_bad)
      call check(g_bad%count() == 1 .and. .not. d%complete, 'value list: slash')
      call parse_value_list(name, '1, b = 3', v, d, g_bad)
      call check(g_bad%count() == 2, 'value list: second key')
      call parse_value_list(name, '&b', v, d, g_bad)
      call check(g_bad%count() == 3, 'value list: group')
      call parse_value_list(name, '''b', v, d, g_bad)
      call check(g_bad%count() == 4, 'value list: quote is not closed')
      call parse_value_list(name, 'wood', v, d, g_bad)
      call check(g_bad%count() == 5, 'value list: bare word')
      call check(index(g_bad%render(d%sources), name // ':1:1: error: text ''wood''') > 0, &
         & 'value list: mistakes show the setting')

      call parse_value_list(name, 'oak wood , /tmp/a b.h5,''c'', 1e-9, true', v, d, g_bare, &
         & bare_text=.true.)
      call check(g_bare%count() == 0 .and. size(v) == 5, 'value list: bare texts are allowed')
      if (size(v) == 5) then
         call check(v(1)%text == 'oak wood' .and. v(2)%text == '/tmp/a b.h5' .and. &
            & v(3)%text == 'c' .and. v(4)%kind == value_real .and. v(5)%kind == value_logical, &
            & 'value list: bare texts among other values')
      end if
      call parse_value_list(name, '1e-9x', v, d, g_bare, bare_text=.true.)
      call check(g_bare%count() == 1, 'value list: a bad number is not a bare text')
   end subroutine test_value_list

   !> Reading files.
   subroutine test_files(check, path)
      !> Called once for each test.
      procedure(check_interface) :: check
      !> File to write.
      character(len=*), intent(in) :: path

      type(document_type) :: d
      type(diagnostics_type) :: g
      type(error_type), allocatable :: error

      call write_file(path, sample())
      call read_document(path, d, g, error)
      call check(.not. allocated(error) .and. g%count() == 0 .and. size(d%groups) == 7, &
         & 'file: read')
      call write_file(path, '')
      call read_document(path, d, g, error)
      call check(.not. allocated(error) .and. size(d%groups) == 0, 'file: empty')
      call write_file(path, '&a x = 1 /' // achar(0))
      call read_document(path, d, g, error)
      call check(fails(error, status_usage, 'not a text file'), 'file: with zero bytes')
      call write_file(path, repeat(' ', 16 * 1024 * 1024 + 1))
      call read_document(path, d, g, error)
      call check(fails(error, status_file, 'more than 16 MiB'), 'file: too large')
      call write_file(path, repeat('!', 16 * 1024 * 1024))
      call read_document(path, d, g, error)
      call check(.not. allocated(error) .and. g%count() == 0, 'file: of the largest size')
      call read_document(path // '/x', d, g, error)
      call check(fails(error, status_file, 'is not a folder'), 'file: in a file')
      call delete_file(path)
      call read_document(path, d, g, error)
      call check(fails(error, status_file, path // ' cannot be read: it does not exist'), &
         & 'file: does not exist')
      call read_document('.', d, g, error)
      call check(fails(error, status_file, 'it is a folder'), 'file: is a folder')
      call read_document('', d, g, error)
      call check(allocated(error), 'file: empty name')
   end subroutine test_files

   !> Whether an error is the expected one.
   pure function fails(error, status, part) result(does)
      !> Error to look at.
      type(error_type), allocatable, intent(in) :: error
      integer, intent(in) :: status
      !> Part of its message.
      character(len=*), intent(in) :: part
      !> The answer.
      logical :: does

      does = .false.
      if (.not. allocated(error)) return
      does = error%status == status .and. index(error%message, part) > 0
   end function fails

   !> Write a file.
   subroutine write_file(path, text)
      !> File to write.
      character(len=*), intent(in) :: path
      !> Its bytes.
      character(len=*), intent(in) :: text

      integer :: unit

      open(newunit=unit, file=path, access='stream', form='unformatted', status='replace', &
         & action='write')
      write (unit) text
      close(unit)
   end subroutine write_file

   !> Delete a file.
   subroutine delete_file(path)
      !> File to delete.
      character(len=*), intent(in) :: path

      integer :: unit

      open(newunit=unit, file=path, status='old', action='readwrite')
      close(unit, status='delete')
   end subroutine delete_file

   !> No mutation of a scene breaks the reader or leads it out of the text.
   subroutine test_mutations(check)
      !> Called once for each test.
      procedure(check_interface) :: check

      integer, parameter :: n_mutations = 20000
      type(document_type) :: d
      type(diagnostics_type) :: g
      type(value_type), allocatable :: v(:)
      character(len=:), allocatable :: text
      integer(i8) :: state
      integer :: i, n_bad, n_silent

      n_bad = 0
      n_silent = 0
      state = 20240229
      do i = 1, n_mutations
         call mutate(sample(), state, text)
         call parse(text, d, g)
         if (modulo(i, 10) == 0) then
            call parse_value_list('x', text, v, d, g, bare_text=modulo(i, 20) == 0)
            if (.not. all_inside(v, d%sources)) n_bad = n_bad + 1
         end if
         if (.not. is_sound(d, g)) n_bad = n_bad + 1
         if (d%complete .neqv. g%count() == 0) n_silent = n_silent + 1
         if (modulo(i, 50) == 0) text = g%render(d%sources)
      end do
      call check(n_bad == 0, 'mutations: all origins are inside the text')
      call check(n_silent == 0, 'mutations: a document is incomplete exactly if that is reported')
   end subroutine test_mutations

   !> Whether a document is consistent and all its origins are inside its sources.
   pure function is_sound(d, g) result(sound)
      type(document_type), intent(in) :: d
      !> Mistakes found in it.
      type(diagnostics_type), intent(in) :: g
      !> The answer.
      logical :: sound

      integer :: i, j

      sound = size(d%groups) == d%n_groups
      do i = 1, size(d%groups)
         sound = sound .and. is_inside(d%groups(i)%origin, d%sources)
         sound = sound .and. size(d%groups(i)%assignments) == d%groups(i)%n_assignments
         do j = 1, size(d%groups(i)%assignments)
            associate (a => d%groups(i)%assignments(j))
               sound = sound .and. len(a%key) > 0 .and. is_inside(a%origin, d%sources)
               sound = sound .and. all_inside(a%values, d%sources)
            end associate
         end do
      end do
      do i = 1, g%kept()
         sound = sound .and. is_inside(g%origin(i), d%sources) .and. len(g%message(i)) > 0
      end do
   end function is_sound

   !> Whether the origins of all values are inside the lines of their sources.
   pure function all_inside(values, sources) result(inside)
      type(value_type), intent(in) :: values(:)
      type(source_type), intent(in) :: sources(:)
      !> The answer.
      logical :: inside

      integer :: i

      inside = .true.
      do i = 1, size(values)
         inside = inside .and. is_inside(values(i)%origin, sources)
      end do
   end function all_inside

   !> Whether an origin is inside a line of its source.
   pure function is_inside(origin, sources) result(inside)
      type(origin_type), intent(in) :: origin
      type(source_type), intent(in) :: sources(:)
      !> The answer.
      logical :: inside

      inside = .false.
      if (origin%source < 1 .or. origin%source > size(sources)) return
      if (origin%line < 1 .or. origin%line > size(sources(origin%source)%lines)) return
      if (origin%column < 1 .or. origin%length < 1) return
      associate (line => sources(origin%source)%lines(origin%line))
         inside = origin%column + origin%length - 1 <= len(line%s)
      end associate
   end function is_inside

   !> Change a text at some random places.
   subroutine mutate(original, state, text)
      !> Text to change.
      character(len=*), intent(in) :: original
      !> State of the random numbers.
      integer(i8), intent(inout) :: state
      !> The changed text.
      character(len=:), allocatable, intent(out) :: text

      character(len=*), parameter :: special = '&/=,;''"!()*%:.+-# TF019endi' // lf // tab // cr
      character(len=1) :: c
      integer :: first, i, k, last, n

      text = original
      n = draw(state, 5)
      do i = 1, n
         if (len(text) < 2) exit
         first = draw(state, len(text))
         last = min(len(text), first + draw(state, 20))
         k = draw(state, len(special))
         c = special(k:k)
         select case (draw(state, 6))
         case (1)
            text = text(1:first - 1) // text(first + 1:)
         case (2)
            text = text(1:first) // c // text(first + 1:)
         case (3)
            text(first:first) = c
         case (4)
            text = text(1:last) // text(first:)
         case (5)
            text = text(1:first) // text(last:)
         case default
            text(first:first) = char(draw(state, 256) - 1)
         end select
      end do
      if (draw(state, 10) == 1) text = text(1:draw(state, len(text)))
   end subroutine mutate

   !> Random integer from 1 to a bound.
   function draw(state, bound) result(n)
      !> State of the random numbers.
      integer(i8), intent(inout) :: state
      !> Largest number.
      integer, intent(in) :: bound
      !> The number.
      integer :: n

      call advance(state)
      n = 1 + int(modulo(state / 1024, int(max(bound, 1), i8)))
   end function draw

   !> Next state of a linear congruential generator modulo 2**32.
   subroutine advance(state)
      !> State of the random numbers.
      integer(i8), intent(inout) :: state

      state = modulo(1664525_i8 * state + 1013904223_i8, 4294967296_i8)
   end subroutine advance

   !> Parse a text with a fresh list of mistakes.
   subroutine parse(text, d, g)
      character(len=*), intent(in) :: text
      !> What was read.
      type(document_type), intent(out) :: d
      !> Mistakes found.
      type(diagnostics_type), intent(out) :: g

      call parse_document('scene.nml', text, d, g)
   end subroutine parse

   !> Check that a text has exactly one mistake, its place, and a part of its message.
   subroutine expect(check, text, line, column, part, name)
      !> Called once.
      procedure(check_interface) :: check
      character(len=*), intent(in) :: text
      !> Line of the mistake.
      integer, intent(in) :: line
      !> Column of the mistake.
      integer, intent(in) :: column
      !> Part of the message.
      character(len=*), intent(in) :: part
      !> Name of the test.
      character(len=*), intent(in) :: name

      type(document_type) :: d
      type(diagnostics_type) :: g
      type(origin_type) :: origin
      logical :: good

      call parse(text, d, g)
      good = g%count() == 1 .and. .not. d%complete
      if (good) then
         origin = g%origin(1)
         good = origin%line == line .and. origin%column == column .and. &
            & index(g%message(1), part) > 0
      end if
      call check(good, 'one mistake: ' // name)
   end subroutine expect

   !> Whether an origin has a place and a length.
   pure function same(origin, line, column, length) result(is)
      type(origin_type), intent(in) :: origin
      integer, intent(in) :: line
      integer, intent(in) :: column
      integer, intent(in) :: length
      !> The answer.
      logical :: is

      is = origin%line == line .and. origin%column == column .and. origin%length == length
   end function same

   !> A scene without mistakes.
   pure function sample() result(text)
      character(len=:), allocatable :: text

      text = '! A small scene' // lf // &
         & '&scene title = ''Tippe-Top'', gravity = 0, 0, -9.81, t_end = 8.0 /' // lf // &
         & '&material name = "wo''od", young = 9.1d9, poisson = .3 /' // lf // &
         & '&body name = ''top'', mass = 6.0e-3, INERTIA = 2*8.0e-7, 7.0e-7,' // lf // &
         & '   position = 0, 0,         0.0120149875041659, axis(1:3) = 0, 1, 0' // lf // &
         & '   angle = 1.0-1, spin = 3*0.0 movable = .true. / ! rad/s' // lf // &
         & '&contact name = ''c'', surfaces = ''it''''s'', ''top'', drilling = F, n=, /' // lf // &
         & '&integrator method = ''cvode_bdf'', rtol = 1e-8 &end' // lf // &
         & '&output file = ''a.h5'', interval = 1.0e-3 /' // lf // &
         & '&empty' // lf // '/' // lf
   end function sample

end module test_document
