!> The constants of a document: taken from its groups &constants, computed in whatever order they
!> need, and what expressions that use them are worth.
module contensou_base_constants
   use contensou_base_diagnostics, only : diagnostics_type, origin_type
   use contensou_base_document, only : constants_group, document_type, value_expression, &
      value_integer, value_null, value_real, value_text, value_type
   use contensou_base_document_types, only : assignment_type, remove_groups
   use contensou_base_expressions, only : constant_bad, constant_known, constant_open, &
      constants_type, evaluate, fault_type, name_is_free
   use contensou_base_kinds, only : wp
   use contensou_base_misprints, only : explain_unit
   use contensou_base_numbers, only : read_real, to_text
   use contensou_base_text, only : lower, quote, text_buffer_type
   implicit none(type, external)
   private

   public :: take_constants, has_constants, expression_value, constants_text

contains

   !> Whether a document has groups of constants.
   pure logical function has_constants(document)
      type(document_type), intent(in) :: document
      integer :: i

      has_constants = .false.
      if (.not. allocated(document%constant_names)) return
      if (size(document%constant_names) == 0) return
      do i = 1, document%n_groups
         if (document%groups(i)%name == constants_group) has_constants = .true.
      end do
   end function has_constants

   !> Take the constants out of the groups of a document and compute them.
   subroutine take_constants(document, diagnostics)
      type(document_type), intent(inout) :: document
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: g, i

      if (.not. has_constants(document)) return
      do g = 1, document%n_groups
         if (document%groups(g)%name /= constants_group) cycle
         do i = 1, document%groups(g)%n_assignments
            call take_constant(document, document%groups(g)%assignments(i), diagnostics)
         end do
      end do
      call remove_groups(document, constants_group)
      do i = 1, document%constants%n
         call compute(document%constants, i, diagnostics)
      end do
   end subroutine take_constants

   !> Take a constant as it is written.
   subroutine take_constant(document, assignment, diagnostics)
      type(document_type), intent(inout) :: document
      !> Its name and value.
      type(assignment_type), intent(in) :: assignment
      type(diagnostics_type), intent(inout) :: diagnostics
      character(len=*), parameter :: right = "a number or an expression, as 2.5e-3 or 4/3*pi*r**3"
      character(len=:), allocatable :: name, text
      character(len=:), allocatable :: message, expected
      integer :: before, k

      name = assignment%key
      before = diagnostics%count()
      text = "0"
      k = document%constants%find(name)
      if (.not. name_is_free(name)) then
         call diagnostics%add(assignment%origin, quote(name) // " cannot be the name of a " // &
            "constant: it has a meaning of its own", "another name")
         return
      else if (k > 0) then
         call diagnostics%add(assignment%origin, "constant " // quote(name) // " given twice", &
            "one of the two; the first is in line " // &
            to_text(document%constants%items(k)%origin%line))
         return
      else if (assignment%first /= 0) then
         call diagnostics%add(assignment%origin, "constant " // quote(name) // &
            " has a subscript", "a name for each number")
      else if (size(assignment%values) == 0) then
         call diagnostics%add(assignment%origin, "constant " // quote(name) // " has no value", &
            right)
      else if (size(assignment%values) > 1) then
         associate (values => assignment%values)
            if (size(values) == 2 .and. any(values(1)%kind == [value_real, value_integer]) .and. &
               values(2)%kind == value_expression) call explain_unit(to_text(values(1)%real), &
               values(2)%text, .true., message, expected)
            if (.not. allocated(message)) then
               message = "constant " // quote(name) // " has " // to_text(size(values)) // " values"
               expected = one_value(values)
            end if
            call diagnostics%add(values(2)%origin, message, expected)
         end associate
      else
         associate (value => assignment%values(1))
            select case (value%kind)
            case (value_real, value_integer)
               text = written(document, value%origin, value%real)
               if (scan(text, "eEdD") == 0 .and. scan(text(2:), "+-") > 0) call diagnostics%add( &
                  value%origin, text // " is a number with an exponent in a namelist: " // &
                  to_text(value%real), to_text(value%real) // ", or the sum in quotes: " // &
                  quote(text))
               text = to_text(value%real)
               if (index(text, "n") + index(text, "N") > 0) call diagnostics%add(value%origin, &
                  "constant " // quote(name) // " must be finite", right)
            case (value_text, value_expression)
               text = value%text
            case default
               call diagnostics%add(value%origin, "constant " // quote(name) // &
                  " needs a number, this is a logical", right)
            end select
            if (value%kind == value_null) text = "0"
         end associate
      end if
      if (size(assignment%values) == 0) then
         call document%constants%add(name, text, assignment%origin)
      else
         call document%constants%add(name, text, assignment%values(1)%origin)
      end if
      if (diagnostics%count() > before) document%constants%items(document%constants%n)%state = &
         constant_bad
   end subroutine take_constant

   !> What would be right; a repeat count is told from a product.
   function one_value(values) result(expected)
      type(value_type), intent(in) :: values(:)
      character(len=:), allocatable :: expected

      expected = "one value"
      associate (first => values(1)%origin, second => values(2)%origin)
         if (first%line == second%line .and. first%column == second%column) expected = &
            "a product of two numbers in quotes: without them 2*3 stands for 3, 3"
      end associate
   end function one_value

   !> A number as it is written.
   function written(document, origin, x) result(shown)
      type(document_type), intent(in) :: document
      !> Where it is.
      type(origin_type), intent(in) :: origin
      !> Its value.
      real(wp), intent(in) :: x
      character(len=:), allocatable :: shown

      shown = to_text(x)
      if (origin%source < 1 .or. origin%source > document%n_sources) return
      if (origin%line < 1) return
      shown = document%sources(origin%source)%lines(origin%line)%s(origin%column: &
         origin%column + origin%length - 1)
   end function written

   !> Compute a constant, and before it those that it needs.
   subroutine compute(constants, first, diagnostics)
      type(constants_type), intent(inout) :: constants
      !> Its position.
      integer, intent(in) :: first
      type(diagnostics_type), intent(inout) :: diagnostics
      type(fault_type) :: fault
      character(len=:), allocatable :: circle
      integer :: stack(constants%n), i, k, n
      real(wp) :: x

      if (constants%items(first)%state /= constant_open) return
      n = 1
      stack(1) = first
      do while (n > 0)
         i = stack(n)
         call evaluate(constants%items(i)%text, constants, x, fault)
         if (fault%pending > 0) then
            k = findloc(stack(:n), fault%pending, dim=1)
            if (k == 0) then
               n = n + 1
               stack(n) = fault%pending
               cycle
            end if
            circle = ""
            do i = k, n
               circle = circle // constants%items(stack(i))%name // " -> "
               constants%items(stack(i))%state = constant_bad
            end do
            associate (item => constants%items(stack(k)))
               call diagnostics%add(item%origin, "constant " // quote(item%name) // &
                  " depends on itself: " // circle // item%name, "a value that does without it")
            end associate
            n = k - 1
            cycle
         end if
         constants%items(i)%state = constant_known
         constants%items(i)%value = x
         if (fault%found) then
            constants%items(i)%state = constant_bad
            if (fault%message /= "") call diagnostics%add(place_in(constants%items(i)%origin, &
               constants%items(i)%text, fault), fault%message, fault%expected)
         end if
         n = n - 1
      end do
   end subroutine compute

   !> Place of a mistake within an expression.
   pure function place_in(origin, text, fault) result(place)
      !> Place of the expression.
      type(origin_type), intent(in) :: origin
      !> The expression.
      character(len=*), intent(in) :: text
      type(fault_type), intent(in) :: fault
      type(origin_type) :: place

      place = origin
      if (origin%line < 1 .or. len(text) == 0) return
      ! Text in quotes takes two bytes more; with doubled quotes or a repeat count all is shown.
      if (origin%length == len(text) + 2) then
         place%column = origin%column + fault%column
      else if (origin%length == len(text)) then
         place%column = origin%column + fault%column - 1
      else
         return
      end if
      place%length = fault%length
   end function place_in

   !> Number that an expression is worth, or a text that stands for one.
   subroutine expression_value(value, constants, x, is_one, diagnostics, good)
      !> The expression, or a text.
      type(value_type), intent(in) :: value
      type(constants_type), intent(in) :: constants
      !> The number; 0 after a mistake.
      real(wp), intent(out) :: x
      !> Whether it is one at all; if not, nothing is reported.
      logical, intent(out) :: is_one
      type(diagnostics_type), intent(inout) :: diagnostics
      logical, intent(out) :: good
      type(fault_type) :: fault

      call evaluate(value%text, constants, x, fault)
      good = .not. fault%found
      is_one = .true.
      if (good .and. value%kind == value_text) is_one = .not. is_plain(value%text)
      if (good) return
      if (value%kind == value_text) is_one = looks_like_one(value%text, fault)
      if (.not. is_one .or. fault%message == "") return
      call diagnostics%add(place_in(value%origin, value%text, fault), fault%message, &
         fault%expected)
   end subroutine expression_value

   !> Whether a text is a plain number, which does without quotes.
   pure logical function is_plain(text)
      character(len=*), intent(in) :: text
      real(wp) :: x
      integer :: n

      call read_real(trim(adjustl(text)), x, is_plain)
      ! An exponent has its letter here: '2-1' is a difference.
      do n = 2, len(text)
         if (scan(text(n:n), "+-") == 0) cycle
         if (scan(text(n - 1:n - 1), "eEdD") == 0) is_plain = .false.
      end do
   end function is_plain

   !> Whether a text with a mistake was meant as an expression: it has an operator or a digit.
   pure logical function looks_like_one(text, fault)
      character(len=*), intent(in) :: text
      type(fault_type), intent(in) :: fault

      looks_like_one = scan(text, "*(") > 0
      if (.not. fault%of_form) looks_like_one = looks_like_one .or. scan(text, "+-/0123456789") > 0
   end function looks_like_one

   !> The constants with their values, as a namelist text; empty if there are none.
   function constants_text(constants) result(text)
      type(constants_type), intent(in) :: constants
      character(len=:), allocatable :: text
      type(text_buffer_type) :: buffer
      integer :: i

      if (constants%n > 0) then
         call buffer%add("&" // constants_group // new_line("a"))
         do i = 1, constants%n
            call buffer%add("   " // constants%items(i)%name // " = " // &
               to_text(constants%items(i)%value) // new_line("a"))
         end do
         call buffer%add("/" // new_line("a"))
      end if
      text = buffer%text()
   end function constants_text

end module contensou_base_constants
