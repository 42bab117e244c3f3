!> Expressions for numbers, as `4/3*pi*r**3*7850`, and the constants that they may name.
!>
!> The operators are those of Fortran with its precedence, `+ - * / **` and parentheses; all numbers
!> are reals, so that 4/3 is not 1. Names are constants of the file, those of the program (pi and
!> deg, pi/180) and functions. Nothing here raises an exception of the processor: what overflows
!> or is not defined is told.
module contensou_base_expressions
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite
   use contensou_base_diagnostics, only : origin_type
   use contensou_base_kinds, only : pi, wp
   use contensou_base_numbers, only : read_real, to_text
   use contensou_base_text, only : join, lower, nearest, quote, string_type, strings
   implicit none(type, external)
   private

   public :: constant_type, constants_type, fault_type
   public :: evaluate, is_expression, name_is_free

   !> States of a constant: not computed yet, computed, or with a mistake that is reported.
   integer, parameter, public :: constant_open = 0, constant_known = 1, constant_bad = 2

   !> A constant of a file.
   type :: constant_type
      !> Name in lower case.
      character(len=:), allocatable :: name
      !> The number or expression as written.
      character(len=:), allocatable :: text
      real(wp) :: value = 0.0_wp
      !> One of the `constant_*` codes.
      integer :: state = constant_open
      !> Where its value stands.
      type(origin_type) :: origin
   end type constant_type

   !> The constants of a file.
   type :: constants_type
      integer :: n = 0
      !> The constants, the first `n` of them.
      type(constant_type), allocatable :: items(:)
   contains
      procedure :: add
      procedure :: find
      procedure :: names
   end type constants_type

   !> What is wrong with an expression.
   type :: fault_type
      !> Whether something is.
      logical :: found = .false.
      character(len=:), allocatable :: message
      character(len=:), allocatable :: expected
      !> First character of the expression that is concerned.
      integer :: column = 1
      !> Number of characters.
      integer :: length = 1
      !> A constant that has to be computed first; 0 for none.
      integer :: pending = 0
      !> Whether the text has not the form of an expression.
      logical :: of_form = .false.
   end type fault_type

   !> State of the reading of an expression.
   type :: reader_type
      character(len=:), allocatable :: text
      !> Next character.
      integer :: at = 1
      !> Levels of parentheses and operators that are open.
      integer :: depth = 0
      !> Whether only the form is looked at.
      logical :: form_only = .false.
      !> Whether a number, and whether a name that is known was met.
      logical :: has_number = .false., has_known = .false.
      !> Number of operators met.
      integer :: n_operators = 0
      !> Whether a parenthesis was met.
      logical :: in_parentheses = .false.
      type(fault_type) :: fault
   end type reader_type

   !> Constants of the program.
   character(len=*), parameter :: own_names(*) = [character(len=3) :: "pi", "deg"]
   real(wp), parameter :: own_values(*) = [pi, pi/180.0_wp]

   !> Functions, and their numbers of arguments; 0 for two or more.
   character(len=*), parameter :: functions(*) = [character(len=5) :: "sqrt", "exp", "log", &
      "log10", "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", &
      "abs", "min", "max"]
   integer, parameter :: arguments(*) = [1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 2, 1, 1, 1, 1, 0, 0]

   !> Words that are values in a namelist, and so no names.
   character(len=*), parameter :: words(*) = [character(len=8) :: "t", "f", "true", "false", &
      "inf", "infinity", "nan"]

   character(len=*), parameter :: digits = "0123456789"
   character(len=*), parameter :: letters = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"

   !> Most levels of parentheses and operators.
   integer, parameter :: most_levels = 100

   !> Largest exponent that is taken as a number of factors.
   real(wp), parameter :: most_factors = 1024.0_wp

contains

   !> Add a constant; its name is one that `name_is_free` admits.
   pure subroutine add(self, name, text, origin)
      class(constants_type), intent(inout) :: self
      character(len=*), intent(in) :: name
      !> The number or expression as written.
      character(len=*), intent(in) :: text
      !> Where it stands.
      type(origin_type), intent(in) :: origin
      type(constant_type), allocatable :: bigger(:)
      integer :: i

      if (.not. allocated(self%items)) allocate(self%items(8))
      if (self%n == size(self%items)) then
         allocate(bigger(2*self%n))
         do i = 1, self%n
            bigger(i) = self%items(i)
         end do
         call move_alloc(bigger, self%items)
      end if
      self%n = self%n + 1
      self%items(self%n)%name = lower(name)
      self%items(self%n)%text = text
      self%items(self%n)%origin = origin
   end subroutine add

   !> Position of a constant; 0 if there is none of that name.
   pure integer function find(self, name)
      class(constants_type), intent(in) :: self
      !> Its name in lower case.
      character(len=*), intent(in) :: name

      do find = 1, self%n
         if (self%items(find)%name == name) return
      end do
      find = 0
   end function find

   !> Names that an expression may use, without the functions.
   pure function names(self)
      class(constants_type), intent(in) :: self
      type(string_type), allocatable :: names(:)
      integer :: i

      allocate(names(self%n + size(own_names)))
      do i = 1, self%n
         names(i)%s = self%items(i)%name
      end do
      do i = 1, size(own_names)
         names(self%n + i)%s = trim(own_names(i))
      end do
   end function names

   !> Whether a name may be given to a constant.
   pure logical function name_is_free(name)
      !> The name in lower case.
      character(len=*), intent(in) :: name

      name_is_free = .not. (any(own_names == name) .or. any(functions == name) .or. &
         any(words == name))
   end function name_is_free

   !> Whether a text without quotes is meant as an expression: it has the form of one, and a number
   !> with an operator or a name that is known is in it. With a parenthesis and an operator before
   !> it, it is meant as one even if its form is wrong.
   pure logical function is_expression(text, known)
      character(len=*), intent(in) :: text
      !> Names of the constants of the file, in lower case.
      type(string_type), intent(in) :: known(:)
      type(constants_type) :: constants
      type(reader_type) :: reader
      real(wp) :: value
      integer :: i

      do i = 1, size(known)
         call constants%add(known(i)%s, "0", origin_type())
      end do
      reader%form_only = .true.
      call read_all(reader, text, constants, value)
      if (reader%fault%found) then
         is_expression = reader%in_parentheses .and. (reader%has_known .or. reader%n_operators > 0)
      else
         is_expression = reader%has_known .or. (reader%has_number .and. &
            (reader%n_operators > 0 .or. reader%in_parentheses))
      end if
   end function is_expression

   !> Value of an expression.
   pure subroutine evaluate(text, constants, value, fault)
      character(len=*), intent(in) :: text
      !> Constants that it may name.
      type(constants_type), intent(in) :: constants
      !> Its value; 0 after a mistake.
      real(wp), intent(out) :: value
      type(fault_type), intent(out) :: fault
      type(reader_type) :: reader, form

      ! What has not the form of an expression is not said to have unknown names as well.
      form%form_only = .true.
      call read_all(form, text, constants, value)
      if (form%fault%found) then
         fault = form%fault
         fault%of_form = .true.
         value = 0.0_wp
         return
      end if
      call read_all(reader, text, constants, value)
      fault = reader%fault
      if (fault%found .or. fault%pending > 0) value = 0.0_wp
   end subroutine evaluate

   !> Read an expression to its end.
   pure subroutine read_all(reader, text, constants, value)
      type(reader_type), intent(inout) :: reader
      character(len=*), intent(in) :: text
      type(constants_type), intent(in) :: constants
      real(wp), intent(out) :: value
      character(len=1) :: c

      reader%text = text
      call read_sum(reader, constants, value)
      if (stopped(reader)) return
      call look(reader, c)
      if (c == " ") return
      if (c == ")") then
         call stop_at(reader, reader%at, 1, "')' without '('", "as many '(' as ')'")
      else
         call stop_at(reader, reader%at, 1, "unexpected '" // c // &
            "' in an expression", "an operator, one of + - * / **")
      end if
   end subroutine read_all

   !> Terms with plus and minus between them, with a sign before the first.
   pure recursive subroutine read_sum(reader, constants, value)
      type(reader_type), intent(inout) :: reader
      type(constants_type), intent(in) :: constants
      real(wp), intent(out) :: value
      character(len=1) :: operator
      real(wp) :: term
      integer :: at

      value = 0.0_wp
      reader%depth = reader%depth + 1
      if (reader%depth > most_levels) then
         call stop_at(reader, reader%at, 1, "too many levels of parentheses", "at most " // &
            to_text(most_levels))
         return
      end if
      call read_product(reader, constants, value)
      do
         if (stopped(reader)) exit
         call look(reader, operator)
         if (operator /= "+" .and. operator /= "-") exit
         at = reader%at
         reader%at = at + 1
         reader%n_operators = reader%n_operators + 1
         call read_product(reader, constants, term)
         if (stopped(reader)) exit
         if (operator == "-") term = -term
         if (.not. reader%form_only) call add_up(reader, at, term, value)
      end do
      reader%depth = reader%depth - 1
   end subroutine read_sum

   !> Add a term to a sum.
   pure subroutine add_up(reader, at, term, value)
      type(reader_type), intent(inout) :: reader
      !> Where the operator stands.
      integer, intent(in) :: at
      real(wp), intent(in) :: term
      real(wp), intent(inout) :: value

      if (value > 0.0_wp .and. term > 0.0_wp .and. abs(term) > huge(term) - abs(value) .or. &
         value < 0.0_wp .and. term < 0.0_wp .and. abs(term) > huge(term) - abs(value)) then
         call overflow(reader, at)
      else
         value = value + term
      end if
   end subroutine add_up

   !> Factors with times and divided by between them, and perhaps a sign before the first.
   pure recursive subroutine read_product(reader, constants, value)
      type(reader_type), intent(inout) :: reader
      type(constants_type), intent(in) :: constants
      real(wp), intent(out) :: value
      character(len=1) :: operator
      real(wp) :: factor
      logical :: negative, minus
      integer :: at

      value = 0.0_wp
      call read_sign(reader, negative)
      call read_power(reader, constants, value)
      do
         if (stopped(reader)) return
         call look(reader, operator)
         if (operator /= "*" .and. operator /= "/") exit
         at = reader%at
         reader%at = at + 1
         reader%n_operators = reader%n_operators + 1
         call read_sign(reader, minus)
         negative = negative .neqv. minus
         call read_power(reader, constants, factor)
         if (stopped(reader)) return
         if (reader%form_only) cycle
         if (operator == "*") then
            call multiply(reader, at, factor, value)
         else
            call divide(reader, at, factor, value)
         end if
      end do
      if (negative) value = -value
   end subroutine read_product

   !> A sign, if there is one.
   pure subroutine read_sign(reader, negative)
      type(reader_type), intent(inout) :: reader
      !> Whether it is a minus.
      logical, intent(out) :: negative
      character(len=1) :: sign

      call look(reader, sign)
      negative = sign == "-"
      if (negative .or. sign == "+") reader%at = reader%at + 1
   end subroutine read_sign

   !> Multiply a product by a factor.
   pure subroutine multiply(reader, at, factor, value)
      type(reader_type), intent(inout) :: reader
      !> Where the operator stands.
      integer, intent(in) :: at
      real(wp), intent(in) :: factor
      real(wp), intent(inout) :: value

      if (abs(value) > 1.0_wp .and. abs(factor) > 1.0_wp) then
         if (abs(factor) > huge(value)/abs(value)) then
            call overflow(reader, at)
            return
         end if
      end if
      value = value*factor
   end subroutine multiply

   !> Divide a product.
   pure subroutine divide(reader, at, divisor, value)
      type(reader_type), intent(inout) :: reader
      !> Where the operator stands.
      integer, intent(in) :: at
      real(wp), intent(in) :: divisor
      real(wp), intent(inout) :: value

      if (abs(divisor) <= 0.0_wp) then
         call stop_at(reader, at, 1, "division by zero", "a divisor other than zero")
         return
      end if
      if (abs(divisor) < 1.0_wp) then
         if (abs(value) > huge(value)*abs(divisor)) then
            call overflow(reader, at)
            return
         end if
      end if
      value = value/divisor
   end subroutine divide

   !> An operand, perhaps with an exponent, which binds from the right and before a sign.
   pure recursive subroutine read_power(reader, constants, value)
      type(reader_type), intent(inout) :: reader
      type(constants_type), intent(in) :: constants
      real(wp), intent(out) :: value
      real(wp) :: exponent
      character(len=1) :: c
      logical :: negative
      integer :: at

      call read_operand(reader, constants, value)
      if (stopped(reader)) return
      call look(reader, c)
      if (c /= "*") return
      if (reader%at == len(reader%text)) return
      if (reader%text(reader%at:reader%at + 1) /= "**") return
      at = reader%at
      reader%at = at + 2
      reader%n_operators = reader%n_operators + 1
      call read_sign(reader, negative)
      reader%depth = reader%depth + 1
      if (reader%depth > most_levels) then
         call stop_at(reader, at, 2, "too many exponents of exponents", "at most " // &
            to_text(most_levels))
         return
      end if
      call read_power(reader, constants, exponent)
      reader%depth = reader%depth - 1
      if (stopped(reader) .or. reader%form_only) return
      if (negative) exponent = -exponent
      call raise(reader, at, exponent, value)
   end subroutine read_power

   !> Raise a number to a power.
   pure subroutine raise(reader, at, exponent, value)
      type(reader_type), intent(inout) :: reader
      !> Where the operator stands.
      integer, intent(in) :: at
      real(wp), intent(in) :: exponent
      real(wp), intent(inout) :: value
      logical :: whole

      whole = abs(exponent) <= most_factors
      if (whole) whole = abs(exponent - anint(exponent)) <= 0.0_wp
      if (abs(value) <= 0.0_wp .and. exponent <= 0.0_wp) then
         if (exponent < 0.0_wp) call stop_at(reader, at, 2, "division by zero", &
            "a base other than zero, or an exponent > 0")
         value = 1.0_wp
      else if (value < 0.0_wp .and. .not. whole) then
         call stop_at(reader, at, 2, "a negative number has no power of a fraction", &
            "a base >= 0, or a whole exponent")
      else if (abs(value) > 0.0_wp) then
         if (exponent*log(abs(value)) > log(huge(value))) then
            call overflow(reader, at)
         else if (exponent*log(abs(value)) < log(tiny(value))) then
            value = 0.0_wp
         else if (whole) then
            value = value**nint(exponent)
         else
            value = value**exponent
         end if
      end if
   end subroutine raise

   !> A number, a name, a function or an expression in parentheses.
   pure recursive subroutine read_operand(reader, constants, value)
      type(reader_type), intent(inout) :: reader
      type(constants_type), intent(in) :: constants
      real(wp), intent(out) :: value
      character(len=1) :: c

      value = 0.0_wp
      call look(reader, c)
      if (c == "(") then
         reader%at = reader%at + 1
         reader%in_parentheses = .true.
         call read_sum(reader, constants, value)
         if (.not. stopped(reader)) call close_parenthesis(reader)
      else if (scan(c, digits // ".") > 0) then
         call read_number(reader, value)
      else if (scan(c, letters) > 0) then
         call read_name(reader, constants, value)
      else if (reader%at > len(reader%text)) then
         call stop_at(reader, max(len(reader%text), 1), 1, "the expression is not complete", &
            "a number, a name or '(' after it")
      else
         call stop_at(reader, reader%at, 1, "unexpected '" // c // "' in an expression", &
            "a number, a name or '('")
      end if
   end subroutine read_operand

   !> The end of a parenthesis.
   pure subroutine close_parenthesis(reader)
      type(reader_type), intent(inout) :: reader
      character(len=1) :: c

      call look(reader, c)
      if (c == ")") then
         reader%at = reader%at + 1
      else
         call stop_at(reader, min(reader%at, len(reader%text)), 1, "')' is missing", &
            "as many ')' as '('")
      end if
   end subroutine close_parenthesis

   !> A number, perhaps in degrees.
   pure subroutine read_number(reader, value)
      type(reader_type), intent(inout) :: reader
      real(wp), intent(out) :: value
      character(len=1) :: c
      integer :: first, last, n
      logical :: valid

      first = reader%at
      associate (text => reader%text)
         last = first
         do while (last <= len(text))
            if (scan(text(last:last), digits // ".") == 0) exit
            last = last + 1
         end do
         if (last < len(text)) then
            if (scan(text(last:last), "eEdD") > 0) then
               n = last + 1
               if (scan(text(n:n), "+-") > 0) n = n + 1
               if (n <= len(text)) then
                  if (scan(text(n:n), digits) > 0) then
                     do while (n <= len(text))
                        if (scan(text(n:n), digits) == 0) exit
                        n = n + 1
                     end do
                     last = n
                  end if
               end if
            end if
         end if
         last = last - 1
         call read_real(text(first:last), value, valid)
         if (valid .and. last < len(text)) valid = &
            scan(text(last + 1:last + 1), letters // digits // "_.") == 0
         if (.not. valid) then
            do while (last < len(text))
               if (scan(text(last + 1:last + 1), letters // digits // "_.") == 0) exit
               last = last + 1
            end do
            call stop_at(reader, first, last - first + 1, quote(text(first:last)) // &
               " is not a number", "a number such as 2, 0.5 or 1.0e-3")
            value = 0.0_wp
            return
         end if
         reader%at = last + 1
         reader%has_number = .true.
         if (.not. ieee_is_finite(value)) then
            call stop_at(reader, first, last - first + 1, quote(text(first:last)) // &
               " is too large for double precision", "a magnitude below 1.8e308")
            value = 0.0_wp
            return
         end if
         ! The unit of an angle: '30 deg'.
         first = reader%at
         call look(reader, c)
         if (scan(c, "dD") == 0) return
         last = name_end(reader)
         if (first == reader%at .or. lower(text(reader%at:last)) /= "deg") return
         reader%at = last + 1
         reader%n_operators = reader%n_operators + 1
         reader%has_known = .true.
         if (.not. reader%form_only) value = value*own_values(2)
      end associate
   end subroutine read_number

   !> Last character of the name that comes next.
   pure integer function name_end(reader)
      type(reader_type), intent(in) :: reader
      integer :: n

      n = verify(reader%text(reader%at:), letters // digits // "_")
      name_end = len(reader%text)
      if (n > 0) name_end = reader%at + n - 2
   end function name_end

   !> A constant, or a function and its arguments.
   pure recursive subroutine read_name(reader, constants, value)
      type(reader_type), intent(inout) :: reader
      type(constants_type), intent(in) :: constants
      real(wp), intent(out) :: value
      character(len=:), allocatable :: name
      character(len=1) :: c
      integer :: first, k

      value = 0.0_wp
      first = reader%at
      k = name_end(reader)
      name = lower(reader%text(first:k))
      reader%at = k + 1
      call look(reader, c)
      if (c == "(") then
         call read_function(reader, constants, name, first, value)
         return
      end if
      k = findloc(own_names == name, .true., dim=1)
      if (k > 0) then
         value = own_values(k)
         reader%has_known = .true.
         return
      end if
      k = constants%find(name)
      if (k == 0) then
         if (.not. reader%form_only) call unknown(reader, name)
         return
      end if
      reader%has_known = .true.
      if (reader%form_only) return
      select case (constants%items(k)%state)
      case (constant_known)
         value = constants%items(k)%value
      case (constant_open)
         reader%fault%pending = k
      case default
         ! Reported where it stands; whatever uses it has no value.
         reader%fault%found = .true.
         reader%fault%message = ""
         reader%fault%expected = ""
      end select

   contains

      !> Say that there is no such constant.
      pure subroutine unknown(reader, name)
         type(reader_type), intent(inout) :: reader
         character(len=*), intent(in) :: name
         type(string_type), allocatable :: names(:)
         character(len=:), allocatable :: right
         integer :: near

         names = constants%names()
         near = nearest(name, names)
         if (near > 0) then
            right = names(near)%s
         else if (any(functions == name)) then
            right = name // "(...)"
         else if (constants%n == 0) then
            right = "one of " // join(names, ", ") // ", or a group &constants with " // name
         else
            right = "one of " // join(names, ", ")
         end if
         if (len(right) > 300) right = "the name of one in the group &constants"
         if (is_per_second(reader%text(:first - 1), name)) then
            call stop_at(reader, first, len(name), "'deg/" // name // "': there are no units " // &
               "of time", "deg alone, which is in rad/s where that is the unit")
            return
         end if
         call stop_at(reader, first, len(name), "there is no constant " // quote(name), right)
      end subroutine unknown

   end subroutine read_name

   !> Whether a name is that of a second below a number of degrees.
   pure logical function is_per_second(before, name)
      !> What stands before it.
      character(len=*), intent(in) :: before
      character(len=*), intent(in) :: name
      integer :: n

      is_per_second = .false.
      n = len_trim(before)
      if (n < 4 .or. all(name /= [character(len=6) :: "s", "sec", "second"])) return
      if (before(n:n) /= "/") return
      n = len_trim(before(:n - 1))
      is_per_second = lower(before(max(n - 2, 1):n)) == "deg"
   end function is_per_second

   !> The arguments of a function, and its value.
   pure recursive subroutine read_function(reader, constants, name, first, value)
      type(reader_type), intent(inout) :: reader
      type(constants_type), intent(in) :: constants
      character(len=*), intent(in) :: name
      !> Where the name begins.
      integer, intent(in) :: first
      real(wp), intent(out) :: value
      integer, parameter :: most = 16
      real(wp) :: x(most)
      character(len=1) :: c
      integer :: k, n, near

      value = 0.0_wp
      k = findloc(functions == name, .true., dim=1)
      if (k == 0) then
         near = nearest(name, strings(functions))
         if (near > 0) then
            call stop_at(reader, first, len(name), "there is no function " // quote(name), &
               trim(functions(near)))
         else
            call stop_at(reader, first, len(name), "there is no function " // quote(name), &
               "one of " // join(strings(functions), ", ") // "; '*' for a product")
         end if
         return
      end if
      reader%in_parentheses = .true.
      reader%has_known = .true.
      n = 0
      do
         reader%at = reader%at + 1
         if (n == most) then
            call stop_at(reader, reader%at - 1, 1, "too many arguments of " // quote(name), &
               "at most " // to_text(most))
            return
         end if
         n = n + 1
         call read_sum(reader, constants, x(n))
         if (stopped(reader)) return
         call look(reader, c)
         if (c /= ",") exit
      end do
      call close_parenthesis(reader)
      if (stopped(reader)) return
      if (arguments(k) > 0 .and. n /= arguments(k) .or. n < 1 .or. &
         arguments(k) == 0 .and. n < 2) then
         call stop_at(reader, first, len(name), quote(name) // " has " // to_text(n) // &
            trim(merge(" argument ", " arguments", n == 1)), expected_arguments(arguments(k)))
         return
      end if
      if (.not. reader%form_only) call apply(reader, trim(functions(k)), first, x(:n), value)
   end subroutine read_function

   !> How many arguments a function takes, in words.
   pure function expected_arguments(n) result(text)
      !> Number of them; 0 for two or more.
      integer, intent(in) :: n
      character(len=:), allocatable :: text

      text = "two or more"
      if (n == 1) text = "one"
      if (n == 2) text = "two"
   end function expected_arguments

   !> Value of a function.
   pure subroutine apply(reader, name, first, x, value)
      type(reader_type), intent(inout) :: reader
      character(len=*), intent(in) :: name
      !> Where the name begins.
      integer, intent(in) :: first
      !> Its arguments.
      real(wp), intent(in) :: x(:)
      real(wp), intent(out) :: value

      value = 0.0_wp
      select case (name)
      case ("sqrt")
         call require(reader, .not. (x(1) < 0.0_wp), ">= 0")
         if (stopped(reader)) return
         value = sqrt(x(1))
      case ("exp")
         if (x(1) > log(huge(value))) then
            call overflow(reader, first)
         else if (x(1) > log(tiny(value))) then
            value = exp(x(1))
         end if
      case ("log")
         call require(reader, .not. (x(1) <= 0.0_wp), "> 0")
         if (stopped(reader)) return
         value = log(x(1))
      case ("log10")
         call require(reader, .not. (x(1) <= 0.0_wp), "> 0")
         if (stopped(reader)) return
         value = log10(x(1))
      case ("sin")
         value = sin(x(1))
      case ("cos")
         value = cos(x(1))
      case ("tan")
         value = tan(x(1))
      case ("asin")
         call require(reader, .not. (abs(x(1)) > 1.0_wp), "from -1 to 1")
         if (stopped(reader)) return
         value = asin(x(1))
      case ("acos")
         call require(reader, .not. (abs(x(1)) > 1.0_wp), "from -1 to 1")
         if (stopped(reader)) return
         value = acos(x(1))
      case ("atan")
         value = atan(x(1))
      case ("atan2")
         call require(reader, any(abs(x) > 0.0_wp), "that are not both 0")
         if (stopped(reader)) return
         value = atan2(x(1), x(2))
      case ("sinh", "cosh")
         if (abs(x(1)) > log(huge(value))) then
            call overflow(reader, first)
         else if (name == "sinh") then
            value = sinh(x(1))
         else
            value = cosh(x(1))
         end if
      case ("tanh")
         value = tanh(x(1))
      case ("abs")
         value = abs(x(1))
      case ("min")
         value = minval(x)
      case default
         value = maxval(x)
      end select

   contains

      !> Report an argument that the function is not defined for.
      pure subroutine require(reader, is_so, domain)
         type(reader_type), intent(inout) :: reader
         logical, intent(in) :: is_so
         character(len=*), intent(in) :: domain

         if (.not. is_so) call stop_at(reader, first, len(name), quote(name) // &
            " is not defined for " // to_text(x(1)), trim(merge("arguments  ", "an argument", &
            size(x) > 1)) // " " // domain)
      end subroutine require

   end subroutine apply

   !> Report a number that is too large.
   pure subroutine overflow(reader, at)
      type(reader_type), intent(inout) :: reader
      integer, intent(in) :: at

      call stop_at(reader, at, 1, "the result is too large for double precision", &
         "a magnitude below 1.8e308")
   end subroutine overflow

   !> Report a mistake; the first one counts.
   pure subroutine stop_at(reader, column, length, message, expected)
      type(reader_type), intent(inout) :: reader
      integer, intent(in) :: column
      integer, intent(in) :: length
      character(len=*), intent(in) :: message
      character(len=*), intent(in) :: expected

      if (stopped(reader)) return
      reader%fault%found = .true.
      reader%fault%column = column
      reader%fault%length = length
      reader%fault%message = message
      reader%fault%expected = expected
   end subroutine stop_at

   !> Whether there is nothing more to read.
   pure logical function stopped(reader)
      type(reader_type), intent(in) :: reader

      stopped = reader%fault%found .or. reader%fault%pending > 0
   end function stopped

   !> Skip blanks and look at what comes next.
   pure subroutine look(reader, c)
      type(reader_type), intent(inout) :: reader
      !> The next character; a blank at the end.
      character(len=1), intent(out) :: c

      do while (reader%at <= len(reader%text))
         c = reader%text(reader%at:reader%at)
         if (scan(c, " " // achar(9)) == 0) return
         reader%at = reader%at + 1
      end do
      c = " "
   end subroutine look

end module contensou_base_expressions
