!> Tests of the rules of a comparison, and of the matching of events.
module test_comparison
   use contensou_base_errors, only : error_type, status_usage
   use contensou_base_kinds, only : i8, wp
   use contensou_compare_events, only : event_matcher_type
   use contensou_compare_rules, only : built_in_rules, matches, parse_rules, read_rules, &
      rules_type, verdict_type
   use test_harness, only : check, check_close
   implicit none(type, external)
   private

   public :: run_comparison_tests

   !> Line end.
   character(len=1), parameter :: lf = achar(10)

contains

   !> Run all tests.
   subroutine run_comparison_tests(folder)
      !> Folder to write to.
      character(len=*), intent(in) :: folder

      call test_patterns()
      call test_last_wins()
      call test_built_in()
      call test_attributes()
      call test_mistakes()
      call test_many_rules()
      call test_file(folder)
      call test_equal_events()
      call test_shifted_events()
      call test_extra_events()
      call test_other_kind()
      call test_order_of_contacts()
   end subroutine run_comparison_tests

   !> Patterns and what they stand for.
   subroutine test_patterns()
      call check(matches("/a/b", "/a/b"), "pattern: itself")
      call check(.not. matches("/a/b", "/a/bc"), "pattern: no beginning")
      call check(.not. matches("/a/bc", "/a/b"), "pattern: no end")
      call check(matches("/a/*", "/a/b/c"), "pattern: * takes slashes")
      call check(matches("/a/*", "/a/"), "pattern: * takes nothing")
      call check(.not. matches("/a/*", "/a"), "pattern: a group is not its members")
      call check(matches("*/cpu_*", "/integrator/cpu_output"), "pattern: two stars")
      call check(matches("*ab*ab", "/abxabab"), "pattern: backtracking")
      call check(.not. matches("*ab*ab", "/abx"), "pattern: backtracking in vain")
      call check(matches("/a?c", "/a c"), "pattern: ? takes a blank")
      call check(.not. matches("/a?c", "/ac"), "pattern: ? takes one")
      call check(matches("/v[0-3]", "/v2"), "pattern: a range")
      call check(.not. matches("/v[0-3]", "/v4"), "pattern: outside of a range")
      call check(matches("/v[!0-3]", "/v4"), "pattern: not a range")
      call check(matches("/v[ab-]", "/v-"), "pattern: a dash at the end")
      call check(matches("/v[]]", "/v]"), "pattern: a bracket")
      call check(matches("/v[[]1", "/v[1"), "pattern: the other bracket")
      call check(matches("*", "/"), "pattern: all")
      call check(.not. matches("", "/"), "pattern: nothing")
   end subroutine test_patterns

   !> The last rule that matches wins, and exact is what none matches.
   subroutine test_last_wins()
      type(rules_type) :: rules
      type(error_type), allocatable :: error
      type(verdict_type) :: verdict

      call parse_rules("rules", "# all" // lf // "/t/* 1e-3 2.5d-2 # comment" // achar(13) // &
         lf // achar(9) // "/t/x" // achar(9) // "IGNORE" // lf // lf // "/t/xy 0 0", rules, error)
      call check(.not. allocated(error), "rules: read")
      call check(rules%count() == 3, "rules: three of them")
      verdict = rules%verdict("/t/z", "")
      call check_close(verdict%atol, 1.0e-3_wp, 0.0_wp, "rules: absolute tolerance")
      call check_close(verdict%rtol, 2.5e-2_wp, 0.0_wp, "rules: relative tolerance")
      call check(.not. verdict%ignore, "rules: not ignored")
      verdict = rules%verdict("/t/x", "")
      call check(verdict%ignore, "rules: ignored")
      verdict = rules%verdict("/t/xy", "")
      call check(.not. verdict%ignore .and. verdict%atol <= 0.0_wp, "rules: the last one wins")
      verdict = rules%verdict("/u", "")
      call check(.not. verdict%ignore .and. verdict%rtol <= 0.0_wp, "rules: exact by default")
   end subroutine test_last_wins

   !> Built-in rules, and what outdoes them.
   subroutine test_built_in()
      type(rules_type) :: rules
      type(error_type), allocatable :: error
      type(verdict_type) :: verdict

      call built_in_rules(.false., rules)
      verdict = rules%verdict("/provenance/host", "")
      call check(verdict%ignore, "built-in: provenance")
      verdict = rules%verdict("/", "created")
      call check(verdict%ignore, "built-in: an attribute of the root")
      verdict = rules%verdict("/", "status")
      call check(.not. verdict%ignore, "built-in: not another one")
      verdict = rules%verdict("/summary/steps", "")
      call check(.not. verdict%ignore, "built-in: the summary counts")
      call parse_rules("rules", "* 0 1" // lf // "/summary/cpu_s 0.1 0", rules, error)
      verdict = rules%verdict("/provenance/host", "")
      call check(verdict%ignore, "built-in: a pattern does not outdo it")
      verdict = rules%verdict("/summary/cpu_s", "")
      call check(.not. verdict%ignore .and. verdict%atol > 0.0_wp, "built-in: a name does")
      verdict = rules%verdict("/summary/steps", "")
      call check(verdict%rtol > 0.0_wp, "built-in: no hindrance elsewhere")
      call built_in_rules(.true., rules)
      call parse_rules("rules", "/summary/steps 0 1", rules, error)
      verdict = rules%verdict("/summary/steps", "")
      call check(verdict%ignore, "built-in: no summary of a part")
   end subroutine test_built_in

   !> Rules for attributes.
   subroutine test_attributes()
      type(rules_type) :: rules
      type(error_type), allocatable :: error
      type(verdict_type) :: verdict

      call parse_rules("rules", "/a ignore" // lf // "*@long_name ignore" // lf // "/a@units 0 0", &
         rules, error)
      verdict = rules%verdict("/a", "signal")
      call check(verdict%ignore, "attributes: those of an ignored object")
      verdict = rules%verdict("/a", "units")
      call check(.not. verdict%ignore, "attributes: one of them named")
      verdict = rules%verdict("/b", "long_name")
      call check(verdict%ignore, "attributes: one of all objects")
      verdict = rules%verdict("/b", "")
      call check(.not. verdict%ignore, "attributes: not the object")
   end subroutine test_attributes

   !> Mistakes are told with their place, all at once.
   subroutine test_mistakes()
      call mistake("/a", "r:1:1: error: a pattern without tolerances", "PATTERN ATOL RTOL")
      call mistake("/a 1", "r:1:4: error: the relative tolerance is missing", "PATTERN ATOL RTOL")
      call mistake(lf // "/a -1 0", "r:2:4: error: '-1' is no absolute tolerance", "a number >= 0")
      call mistake("/a 0 nan", "r:1:6: error: 'nan' is no relative tolerance", "a number >= 0")
      call mistake("/a inf 0", "r:1:4: error: 'inf' is no absolute tolerance", "a number >= 0")
      call mistake("/a ignored", "r:1:4: error: 'ignored' is no absolute tolerance", "or ignore")
      call mistake("/a 0 0 0", "r:1:8: error: a word too many", "PATTERN ATOL RTOL")
      call mistake("/a ignore 0", "r:1:11: error: a word after 'ignore'", "PATTERN ignore")
      call mistake("a 0 0", "r:1:1: error: no path begins with 'a'", "begins with / or *")
      call mistake("/[a 0 0", "r:1:1: error: '[' without ']'", "[a-z]")
      call mistake("/a" // lf // "/b", "2 errors in r; nothing was compared", "PATTERN")
   end subroutine test_mistakes

   !> Check the message about a mistake.
   subroutine mistake(text, message, expected)
      !> Rules.
      character(len=*), intent(in) :: text
      !> Part of the message.
      character(len=*), intent(in) :: message
      !> Part of what is said to be right.
      character(len=*), intent(in) :: expected

      type(rules_type) :: rules
      type(error_type), allocatable :: error
      integer :: place

      call parse_rules("r", text, rules, error)
      call check(allocated(error), "mistake: " // message)
      if (.not. allocated(error)) return
      call check(error%status == status_usage, "mistake: status")
      call check(index(error%message, message) > 0, "mistake: " // error%message)
      place = index(error%message, "expected: ")
      call check(place > 0, "mistake: what is expected")
      call check(index(error%message(max(place, 1):), expected) > 0, "mistake: expected " // &
         expected)
   end subroutine mistake

   !> More rules than fit at first.
   subroutine test_many_rules()
      type(rules_type) :: rules
      type(error_type), allocatable :: error
      type(verdict_type) :: verdict
      character(len=16) :: line
      integer :: i

      do i = 1, 200
         write (line, "('/v', i0, 1x, i0, ' 0')") i, i
         call parse_rules("rules", line, rules, error)
      end do
      call check(rules%count() == 200, "many rules: all are kept")
      verdict = rules%verdict("/v17", "")
      call check_close(verdict%atol, 17.0_wp, 0.0_wp, "many rules: one of the first")
      verdict = rules%verdict("/v200", "")
      call check_close(verdict%atol, 200.0_wp, 0.0_wp, "many rules: the last one")
   end subroutine test_many_rules

   !> Rules from a file, and a file that is not there.
   subroutine test_file(folder)
      !> Folder to write to.
      character(len=*), intent(in) :: folder

      type(rules_type) :: rules
      type(error_type), allocatable :: error
      integer :: unit

      open(newunit=unit, file=folder // "/rules", status="replace", action="write")
      write (unit, "(a)") "/a 0 1"
      close(unit)
      call read_rules(folder // "/rules", rules, error)
      call check(.not. allocated(error) .and. rules%count() == 1, "file of rules: read")
      call read_rules(folder // "/none", rules, error)
      call check(allocated(error), "file of rules: none there")
   end subroutine test_file

   !> Lists without a difference.
   subroutine test_equal_events()
      type(event_matcher_type) :: matcher
      integer :: i

      do i = 1, 1000
         call matcher%add(1, "a", merge("touch", "lift ", mod(i, 2) == 1), 1.0e-2_wp*i)
         call matcher%add(2, "a", merge("touch", "lift ", mod(i, 2) == 1), 1.0e-2_wp*i)
         if (mod(i, 64) == 0) call matcher%match()
      end do
      call matcher%finish()
      call check(.not. matcher%differ(), "equal events: no difference")
      call check(matcher%n_pairs == 1000_i8, "equal events: all matched")
      call check(matcher%n_shifted == 0_i8, "equal events: none has moved")
   end subroutine test_equal_events

   !> Lists that differ in time.
   subroutine test_shifted_events()
      type(event_matcher_type) :: matcher
      integer :: i

      matcher%atol = 5.0e-5_wp
      do i = 1, 100
         call matcher%add(1, "a", merge("touch", "lift ", mod(i, 2) == 1), 1.0_wp*i)
         call matcher%add(2, "a", merge("touch", "lift ", mod(i, 2) == 1), (1.0_wp + 1.0e-6_wp)*i)
      end do
      call matcher%finish()
      call check(matcher%n_pairs == 100_i8, "shifted events: all matched")
      call check_close(matcher%largest, 1.0e-4_wp, 1.0e-12_wp, "shifted events: largest shift")
      call check_close(matcher%at_largest%time(1), 100.0_wp, 0.0_wp, "shifted events: where")
      call check(matcher%n_beyond == 50_i8 .or. matcher%n_beyond == 51_i8, &
         "shifted events: those beyond the tolerance")
      call check_close(matcher%first_beyond%time(1), 50.5_wp, 1.0_wp, &
         "shifted events: the first beyond the tolerance")
   end subroutine test_shifted_events

   !> A pair of events that one list alone has.
   subroutine test_extra_events()
      type(event_matcher_type) :: matcher
      integer :: i, side

      do side = 1, 2
         matcher = event_matcher_type()
         do i = 1, 100
            call matcher%add(1, "a", merge("touch", "lift ", mod(i, 2) == 1), 1.0_wp*i)
            call matcher%add(2, "a", merge("touch", "lift ", mod(i, 2) == 1), 1.0_wp*i)
            if (i == 40) then
               call matcher%add(side, "a", "touch", 40.3_wp)
               call matcher%add(side, "a", "lift", 40.4_wp)
            end if
         end do
         call matcher%match()
         call matcher%finish()
         call check(matcher%n_pairs == 100_i8, "extra events: the others are matched")
         call check(matcher%n_shifted == 0_i8, "extra events: and have not moved")
         call check(matcher%n_only(side) == 2_i8, "extra events: two of them")
         call check(matcher%n_only(3 - side) == 0_i8, "extra events: none in the other list")
         call check_close(matcher%first_only(side)%time(side), 40.3_wp, 0.0_wp, &
            "extra events: the first of them")
      end do
   end subroutine test_extra_events

   !> An event of another kind.
   subroutine test_other_kind()
      type(event_matcher_type) :: matcher
      integer :: i

      do i = 1, 10
         call matcher%add(1, "a", "touch", 1.0_wp*i)
         call matcher%add(2, "a", merge("lift ", "touch", i == 4), 1.0_wp*i)
      end do
      call matcher%finish()
      call check(matcher%n_kind == 1_i8, "other kind: one of them")
      call check(matcher%n_pairs == 10_i8, "other kind: all matched")
      call check_close(matcher%first_kind%time(1), 4.0_wp, 0.0_wp, "other kind: where")
      call check(matcher%first_kind%kind(2)%s == "lift ", "other kind: which")
   end subroutine test_other_kind

   !> Events of different contacts are matched each for itself.
   subroutine test_order_of_contacts()
      type(event_matcher_type) :: matcher

      call matcher%add(1, "a", "touch", 1.0_wp)
      call matcher%add(1, "b", "touch", 1.0_wp)
      call matcher%add(2, "b", "touch", 1.0_wp)
      call matcher%add(2, "a", "touch", 1.0_wp)
      call matcher%add(2, "c", "touch", 2.0_wp)
      call matcher%finish()
      call check(matcher%n_pairs == 2_i8, "contacts: each for itself")
      call check(matcher%n_only(2) == 1_i8, "contacts: one has no partner")
      call check(matcher%first_only(2)%contact == "c", "contacts: which")
   end subroutine test_order_of_contacts

end module test_comparison
