!> Harness of the unit tests: checks that count, suites that can be chosen, a scratch folder,
!> tables of reference values, random numbers that are the same on every machine.
!>
!> Only what fails is printed, unless all is asked for; the closing line is `N passed, N failed`.
module test_harness
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite, ieee_is_nan
   use, intrinsic :: iso_c_binding, only : c_associated, c_char, c_null_char, c_ptr
   use, intrinsic :: iso_fortran_env, only : compiler_options, output_unit
   use contensou_base_kinds, only : i8, wp
   use contensou_base_text, only : string_type
   implicit none(type, external)
   private

   public :: set_up, wants, is_checked, finish, check, check_close, check_relative
   public :: make_scratch_folder, remove_scratch_folder, shell_quote
   public :: table_type, read_table, random_type, worst_type

   !> Columns of numbers with names, from a CSV file with a header.
   type :: table_type
      !> Number of rows.
      integer :: rows = 0
      !> Names of the columns.
      type(string_type), allocatable, private :: names(:)
      !> Cells, one column after the other.
      type(string_type), allocatable, private :: cells(:, :)
   contains
      !> Numbers of a column.
      procedure :: column
   end type table_type

   !> Random numbers by two multiplicative congruential generators (L'Ecuyer 1988).
   type :: random_type
      private
      !> State of the first generator.
      integer(i8) :: first = 12345
      !> State of the second generator.
      integer(i8) :: second = 67890
   contains
      !> A number between two bounds.
      procedure, public :: uniform
      !> A number of random sign whose decimal logarithm is between two bounds.
      procedure, public :: decades
      !> A vector with components between -1 and 1.
      procedure, public :: vector
   end type random_type

   !> Largest excess of a quantity over many samples, and where it was.
   type :: worst_type
      !> Largest value.
      real(wp) :: value = -huge(1.0_wp)
      !> Sample that gave it.
      integer :: sample = 0
      !> Whether a value was not a number.
      logical :: is_nan = .false.
   contains
      !> Take note of a sample.
      procedure :: note
      !> Check that no value was above a bound.
      procedure :: check_below
   end type worst_type

   interface
      !> Make a folder with a name of its own.
      function mkdtemp(template) result(path) bind(c, name="mkdtemp")
         import :: c_char, c_ptr
         implicit none(type, external)
         !> Name that ends in XXXXXX and a zero byte; replaced by that of the folder.
         character(len=1, kind=c_char), intent(inout) :: template(*)
         type(c_ptr) :: path
      end function mkdtemp
   end interface

   !> Number of checks that passed.
   integer :: n_passed = 0

   !> Number of checks that failed.
   integer :: n_failed = 0

   !> Whether checks that pass are printed too.
   logical :: verbose = .false.

   !> Only suites whose name contains this are run.
   character(len=64) :: chosen = ""

   !> Suite that is running.
   character(len=64) :: suite = ""

contains

   !> Take the options of the command line: `-v`, and part of the name of a suite.
   subroutine set_up()
      character(len=64) :: argument
      integer :: i

      do i = 1, command_argument_count()
         call get_command_argument(i, argument)
         if (argument == "-v") then
            verbose = .true.
         else
            chosen = argument
         end if
      end do
   end subroutine set_up

   !> Whether a suite is to be run; the checks that follow belong to it.
   function wants(name)
      !> Name of the suite.
      character(len=*), intent(in) :: name
      logical :: wants

      wants = index(name, trim(chosen)) > 0
      if (wants) suite = name
      if (wants .and. verbose) write(output_unit, "(a)") "suite " // name
   end function wants

   !> Whether this is a build with run-time checks, which is far slower.
   logical function is_checked()
      is_checked = index(compiler_options(), "-fcheck=") > 0
   end function is_checked

   !> Print the closing line.
   subroutine finish(passed)
      !> Whether something was checked and nothing failed.
      logical, intent(out) :: passed

      write(output_unit, "(i0, a, i0, a)") n_passed, " passed, ", n_failed, " failed"
      passed = n_passed > 0 .and. n_failed == 0
   end subroutine finish

   !> Count a check.
   subroutine check(condition, name)
      !> Whether it passed.
      logical, intent(in) :: condition
      !> What was checked.
      character(len=*), intent(in) :: name

      if (condition) then
         n_passed = n_passed + 1
         if (verbose) write(output_unit, "(a)") "   ok     " // trim(suite) // ": " // name
      else
         n_failed = n_failed + 1
         write(output_unit, "(a)") "   FAILED " // trim(suite) // ": " // name
      end if
      flush(output_unit)
   end subroutine check

   !> Check a number against an expected one; what differs is printed.
   subroutine check_close(value, expected, tolerance, name)
      !> The number.
      real(wp), intent(in) :: value
      !> What it should be.
      real(wp), intent(in) :: expected
      !> Largest absolute difference.
      real(wp), intent(in) :: tolerance
      !> What was checked.
      character(len=*), intent(in) :: name
      logical :: good

      ! Comparisons with NaN raise an exception.
      good = ieee_is_finite(value) .and. ieee_is_finite(expected)
      if (good) good = abs(value - expected) <= tolerance
      call check(good, name)
      if (.not. good) write(output_unit, "(10x, 3(a, es23.16), a, es8.1)") "value", value, &
         ", expected", expected, ", tolerance", tolerance, ", difference ", &
         difference(value, expected)
   end subroutine check_close

   !> Check a number against an expected one to a relative tolerance.
   subroutine check_relative(value, expected, tolerance, name)
      !> The number.
      real(wp), intent(in) :: value
      !> What it should be.
      real(wp), intent(in) :: expected
      !> Largest difference, relative to `expected`.
      real(wp), intent(in) :: tolerance
      !> What was checked.
      character(len=*), intent(in) :: name

      call check_close(value, expected, tolerance*abs(expected), name)
   end subroutine check_relative

   !> Difference of two numbers for printing; NaN and infinity are left alone.
   pure function difference(value, expected) result(d)
      !> The number.
      real(wp), intent(in) :: value
      !> What it should be.
      real(wp), intent(in) :: expected
      real(wp) :: d

      d = value
      if (ieee_is_finite(value) .and. ieee_is_finite(expected)) d = value - expected
   end function difference

   !> Make a folder for files below `$TMPDIR` or /tmp.
   subroutine make_scratch_folder(folder)
      !> Its name.
      character(len=:), allocatable, intent(out) :: folder
      character(len=1024) :: parent
      character(len=1, kind=c_char), allocatable :: template(:)
      integer :: i, length

      call get_environment_variable("TMPDIR", parent, length)
      if (length == 0 .or. length > len(parent)) parent = "/tmp"
      folder = trim(parent) // "/contensou-unit-XXXXXX"
      allocate(template(len(folder) + 1))
      do i = 1, len(folder)
         template(i) = folder(i:i)
      end do
      template(size(template)) = c_null_char
      if (.not. c_associated(mkdtemp(template))) then
         write(output_unit, "(a)") "no folder can be made below " // trim(parent)
         stop 1, quiet=.true.
      end if
      do i = 1, len(folder)
         folder(i:i) = template(i)
      end do
   end subroutine make_scratch_folder

   !> Remove the folder for files and all that is in it.
   subroutine remove_scratch_folder(folder)
      !> Its name.
      character(len=*), intent(in) :: folder

      call execute_command_line("rm -rf -- " // shell_quote(folder))
   end subroutine remove_scratch_folder

   !> A text as one word of a shell command.
   pure function shell_quote(text) result(word)
      character(len=*), intent(in) :: text
      character(len=:), allocatable :: word
      integer :: i

      word = "'"
      do i = 1, len(text)
         if (text(i:i) == "'") then
            word = word // "'\''"
         else
            word = word // text(i:i)
         end if
      end do
      word = word // "'"
   end function shell_quote

   !> Read a CSV file of the folder of reference values.
   subroutine read_table(name, table)
      !> Name of the file without folder and ending.
      character(len=*), intent(in) :: name
      type(table_type), intent(out) :: table
      character(len=:), allocatable :: path
      character(len=2048) :: line
      integer :: unit, status, n_columns, rows, i
      logical :: exists

      path = "tests/reference/" // name // ".csv"
      inquire(file=path, exist=exists)
      call check(exists, path // " is found (the unit tests run in the root of the project)")
      if (.not. exists) then
         allocate(table%names(0), table%cells(0, 0))
         return
      end if
      open(newunit=unit, file=path, status="old", action="read")
      rows = -1
      do
         read(unit, "(a)", iostat=status) line
         if (status /= 0) exit
         rows = rows + 1
         if (rows == 0) n_columns = 1 + count([(line(i:i) == ",", i=1, len_trim(line))])
      end do
      rewind(unit)
      table%rows = max(rows, 0)
      allocate(table%names(n_columns), table%cells(rows, n_columns))
      read(unit, "(a)") line
      call split(line, table%names)
      do i = 1, rows
         read(unit, "(a)") line
         call split(line, table%cells(i, :))
      end do
      close(unit)
   end subroutine read_table

   !> Split a line at its commas.
   pure subroutine split(line, cells)
      character(len=*), intent(in) :: line
      type(string_type), intent(inout) :: cells(:)
      integer :: first, i, comma

      first = 1
      do i = 1, size(cells)
         comma = index(line(first:), ",")
         if (comma == 0) comma = len(line) - first + 2
         cells(i)%s = trim(line(first:first + comma - 2))
         first = min(first + comma, len(line) + 1)
      end do
   end subroutine split

   !> Numbers of a column; none if there is no such column.
   function column(self, name) result(numbers)
      class(table_type), intent(in) :: self
      !> Name of the column.
      character(len=*), intent(in) :: name
      real(wp), allocatable :: numbers(:)
      integer :: i, k

      allocate(numbers(self%rows))
      do k = 1, size(self%names)
         if (self%names(k)%s == name) exit
      end do
      call check(k <= size(self%names), "the column " // name // " is found")
      if (k > size(self%names)) then
         numbers = 0.0_wp
         return
      end if
      do i = 1, self%rows
         read(self%cells(i, k)%s, *) numbers(i)
      end do
   end function column

   !> A random number.
   function uniform(self, low, high) result(x)
      !> The generator.
      class(random_type), intent(inout) :: self
      !> Lower bound.
      real(wp), intent(in) :: low
      !> Upper bound.
      real(wp), intent(in) :: high
      real(wp) :: x
      integer(i8), parameter :: m_1 = 2147483563_i8, m_2 = 2147483399_i8

      self%first = modulo(40014_i8*self%first, m_1)
      self%second = modulo(40692_i8*self%second, m_2)
      x = real(modulo(self%first - self%second, m_1 - 1_i8), wp)/real(m_1 - 1_i8, wp)
      ! More digits from the second generator alone.
      x = x + real(self%second, wp)/(real(m_1, wp)*real(m_2, wp))
      x = low + min(x, 1.0_wp)*(high - low)
   end function uniform

   !> A random number of random sign.
   function decades(self, low, high) result(x)
      !> The generator.
      class(random_type), intent(inout) :: self
      !> Smallest decimal logarithm.
      real(wp), intent(in) :: low
      !> Largest decimal logarithm.
      real(wp), intent(in) :: high
      real(wp) :: x

      x = 10.0_wp**self%uniform(low, high)
      if (self%uniform(-1.0_wp, 1.0_wp) < 0.0_wp) x = -x
   end function decades

   !> A random vector.
   function vector(self, n) result(x)
      !> The generator.
      class(random_type), intent(inout) :: self
      !> Number of components.
      integer, intent(in) :: n
      real(wp) :: x(n)
      integer :: i

      do i = 1, n
         x(i) = self%uniform(-1.0_wp, 1.0_wp)
      end do
   end function vector

   !> Take note of a sample.
   subroutine note(self, value, sample)
      !> The record.
      class(worst_type), intent(inout) :: self
      !> Value of the sample.
      real(wp), intent(in) :: value
      !> Its number.
      integer, intent(in) :: sample

      if (self%is_nan) return
      if (ieee_is_nan(value)) then
         self%is_nan = .true.
         self%sample = sample
      else if (value > self%value) then
         self%value = value
         self%sample = sample
      end if
   end subroutine note

   !> Check that there were samples and that no value was above a bound.
   subroutine check_below(self, bound, name)
      !> The record.
      class(worst_type), intent(in) :: self
      real(wp), intent(in) :: bound
      !> What was checked.
      character(len=*), intent(in) :: name
      logical :: below

      below = .not. self%is_nan .and. self%sample > 0 .and. self%value <= bound
      call check(below, name)
      if (.not. below) write(output_unit, "(10x, a, es10.3, a, es10.3, a, i0, a, l1)") &
         "largest value", self%value, ", bound", bound, ", sample ", self%sample, &
         ", not a number ", self%is_nan
   end subroutine check_below

end module test_harness
