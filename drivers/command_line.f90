!> Command lines: a table of options makes the parser, the usage and the suggestions.
!>
!> A command is a file of its own. It has a table of what it takes and a plain configuration type,
!> which it fills from the parsed line; `contensou_drivers_commands` lists the commands.
module contensou_drivers_command_line
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite
   use contensou_base_errors, only : error_type, fatal, status_usage
   use contensou_base_kinds, only : wp
   use contensou_base_misprints, only : explain_misprint
   use contensou_base_numbers, only : read_real, to_text
   use contensou_base_text, only : did_you_mean, invalid_byte, invalid_byte_text, quote, &
      starts_with, string_type
   implicit none(type, external)
   private

   public :: option_type, command_type, command_line_type, set_option, quiet_option, &
      strict_option
   public :: command_line_words, parse_command_line, usage_text
   public :: takes_text, takes_number, takes_non_negative, takes_positive, takes_count

   !> What is installed beside the program: `contensou-plot` and so on.
   character(len=*), parameter :: tools(*) = [character(len=6) :: "plot", "spot", "submit"]

   !> Any text; an empty one only if the option does not say what it needs.
   integer, parameter :: takes_text = 0

   !> A finite number.
   integer, parameter :: takes_number = 1

   !> A finite number >= 0.
   integer, parameter :: takes_non_negative = 2

   !> A finite number > 0.
   integer, parameter :: takes_positive = 3

   !> A whole number from 1 to 999999.
   integer, parameter :: takes_count = 4

   !> What a command takes: an option, whose name begins with `-`, or an operand.
   type :: option_type
      !> Name in full, such as `--output` or `SCENE`.
      character(len=16) :: name = ""
      !> Word for the value of an option, such as `FILE`; blank for a flag.
      character(len=12) :: value = ""
      !> What it is or does.
      character(len=200) :: text = ""
      !> Short name, such as `-o`; blank for none.
      character(len=2) :: short = ""
      !> What a value needs to be, such as "a time >= 0 [s]"; blank if an empty text will do. An
      !> operand that is needed says what the command needs, such as "a scene".
      character(len=40) :: needs = ""
      !> What kind of value it takes, one of the `takes_*` codes.
      integer :: takes = takes_text
      !> Whether it may be given many times; of others the last one counts.
      logical :: repeats = .false.
      !> Values that a shell proposes, separated by blanks; blank for names of files.
      character(len=120) :: choices = ""
   contains
      procedure :: is_option
      procedure :: is_flag
   end type option_type

   !> Option that replaces a value of a scene.
   type(option_type), parameter :: set_option = option_type("--set", "PATH=VALUE", &
      "replace a value: PATH is group.key, name.key or group.name.key", repeats=.true.)

   !> Option that keeps a command from showing its progress.
   type(option_type), parameter :: quiet_option = option_type("--quiet", "", &
      "print nothing unless something is wrong", "-q")

   !> Option that makes warnings errors.
   type(option_type), parameter :: strict_option = option_type("--strict", "", &
      "warnings are errors")

   !> What the parser, usage and completion know of a command.
   type :: command_type
      character(len=16) :: name = ""
      !> What it does, in a line.
      character(len=80) :: summary = ""
      !> What it takes: operands in their order, and options.
      type(option_type), allocatable :: options(:)
      !> What its usage says before the options, in place of the summary; may be left out.
      character(len=:), allocatable :: description
      !> What its usage says after them; may be left out.
      character(len=:), allocatable :: notes
      !> Option of the program that means this command, such as `--version`; blank for none.
      character(len=16) :: alias = ""
      !> Whether it ends in order when a signal asks it to; others end at once.
      logical :: heeds_signals = .false.
      !> Does it.
      procedure(execute_interface), pointer, nopass :: execute => null()
   end type command_type

   !> An option or operand as it was given.
   type :: given_type
      !> Index into the options of the command.
      integer :: option = 0
      !> Its value; empty for a flag.
      character(len=:), allocatable :: value
   end type given_type

   !> A parsed command line.
   type :: command_line_type
      !> The words after the name of the program.
      type(string_type), allocatable :: words(:)
      !> All commands of the program.
      type(command_type), allocatable :: commands(:)
      !> Which one of them is asked for.
      integer :: command = 0
      !> Usage, if it is asked for instead of the command; otherwise not allocated.
      character(len=:), allocatable :: usage
      type(given_type), allocatable, private :: given(:)
   contains
      procedure :: has
      procedure :: text => text_of
      procedure :: texts => texts_of
      procedure :: number => number_of
      procedure :: count => count_of
   end type command_line_type

   abstract interface
      !> Do what a command line asks for.
      subroutine execute_interface(line, error)
         import :: command_line_type, error_type
         implicit none(type, external)
         type(command_line_type), intent(in) :: line
         !> Set when it could not be done. A message that is empty is not shown: only the exit
         !> status counts.
         type(error_type), allocatable, intent(out) :: error
      end subroutine execute_interface
   end interface

   !> Largest width of a usage.
   integer, parameter :: width = 100

   character(len=*), parameter :: digits = "0123456789", nl = new_line("a")

contains

   !> Whether this is an option, not an operand.
   elemental function is_option(self)
      class(option_type), intent(in) :: self
      logical :: is_option

      is_option = self%name(1:1) == "-"
   end function is_option

   !> Whether this is an option without a value.
   elemental function is_flag(self)
      class(option_type), intent(in) :: self
      logical :: is_flag

      is_flag = self%is_option() .and. self%value == ""
   end function is_flag

   !> The words of the command line after the program's name.
   function command_line_words() result(words)
      type(string_type), allocatable :: words(:)
      integer :: i, length

      allocate(words(command_argument_count()))
      do i = 1, size(words)
         call get_command_argument(i, length=length)
         allocate(character(len=length) :: words(i)%s)
         call get_command_argument(i, words(i)%s)
      end do
   end function command_line_words

   !> Understand a command line.
   subroutine parse_command_line(words, commands, line, error)
      !> Words after the program's name.
      type(string_type), intent(in) :: words(:)
      !> Commands of the program.
      type(command_type), intent(in) :: commands(:)
      type(command_line_type), intent(out) :: line
      !> Set when it cannot be understood.
      type(error_type), allocatable, intent(out) :: error
      character(len=:), allocatable :: text
      integer :: i, k

      line%words = words
      line%commands = commands
      allocate(line%given(0))
      ! The words are kept in files, as UTF-8.
      do i = 1, size(words)
         k = invalid_byte(words(i)%s)
         if (k == 0) cycle
         call fatal(error, "word " // to_text(i) // " of the command line, byte " // to_text(k) // &
            ": " // invalid_byte_text(words(i)%s(k:k)) // "; names and values are to be UTF-8", &
            status_usage)
         return
      end do
      if (size(words) == 0) then
         call fatal(error, "no command is given" // nl // program_usage(commands), status_usage)
         return
      end if
      associate (word => words(1)%s)
         if (word == "--help" .or. word == "-h") then
            line%usage = program_usage(commands)
            return
         end if
         line%command = findloc(commands%name == word, .true., dim=1)
         if (line%command == 0 .and. starts_with(word, "--")) line%command = &
            findloc(commands%alias == word, .true., dim=1)
         if (line%command == 0 .and. word == "-V") line%command = &
            findloc(commands%name == "version", .true., dim=1)
         if (line%command == 0 .or. word == "") then
            text = did_you_mean(word, commands%name, "")
            if (any(tools == word)) then
               text = "; contensou-" // word // " is a program of its own"
            else if (text == "; ") then
               text = nl // program_usage(commands)
            end if
            call fatal(error, "unknown command " // quote(word) // text, status_usage)
            return
         end if
      end associate
      do i = 2, size(words)
         if (words(i)%s /= "--help" .and. words(i)%s /= "-h") cycle
         line%usage = usage_text(commands(line%command))
         return
      end do
      call parse_words(commands(line%command), line, error)
   end subroutine parse_command_line

   !> Understand the words after the name of a command.
   subroutine parse_words(command, line, error)
      type(command_type), intent(in) :: command
      !> The line; what is given is set.
      type(command_line_type), intent(inout) :: line
      !> Set when they cannot be understood.
      type(error_type), allocatable, intent(out) :: error
      type(option_type), allocatable :: operands(:)
      character(len=:), allocatable :: name, value, why, expected
      integer :: i, k, n_operands
      logical :: only_operands, attached

      operands = pack(command%options, .not. command%options%is_option())
      n_operands = 0
      only_operands = .false.
      i = 1
      do while (i < size(line%words))
         i = i + 1
         associate (word => line%words(i)%s)
            if (only_operands .or. .not. starts_with(word, "-") .or. word == "-") then
               n_operands = n_operands + 1
               k = min(n_operands, size(operands))
               if (k > 0) then
                  if (k < n_operands .and. .not. operands(k)%repeats) k = 0
               end if
               if (k == 0) then
                  call fatal(error, "unexpected word " // quote(word) // nl // &
                     usage_text(command), status_usage)
                  return
               end if
               call give(line, findloc(command%options%name == operands(k)%name, .true., dim=1), &
                  word)
               cycle
            else if (word == "--") then
               only_operands = .true.
               cycle
            end if
            call split(command%options, word, k, name, value, attached)
            if (k == 0) then
               call unknown_option(command, word, error)
               return
            end if
            if (.not. command%options(k)%is_flag() .and. .not. attached) then
               if (i == size(line%words)) then
                  call fatal(error, word // " needs a value" // nl // usage_text(command), &
                     status_usage)
                  return
               end if
               i = i + 1
               value = line%words(i)%s
            end if
         end associate
         if (.not. fits(command%options(k), value)) then
            name = name // " needs " // trim(command%options(k)%needs)
            if (command%options(k)%takes /= takes_text) name = name // ", not " // quote(value)
            if (all(command%options(k)%takes /= [takes_text, takes_count])) then
               call explain_misprint(value, why, expected)
               if (allocated(why)) name = name // ": " // why // ", expected " // expected
            end if
            call fatal(error, name, status_usage)
            return
         end if
         call give(line, k, value)
      end do
      if (n_operands >= size(operands)) return
      if (operands(n_operands + 1)%needs /= "") call fatal(error, trim(command%name) // &
         " needs " // trim(operands(n_operands + 1)%needs) // nl // usage_text(command), &
         status_usage)
   end subroutine parse_words

   !> Find the option that a word names.
   pure subroutine split(options, word, found, name, value, attached)
      type(option_type), intent(in) :: options(:)
      character(len=*), intent(in) :: word
      !> Index of the option; 0 if there is none.
      integer, intent(out) :: found
      !> Its name as it was written.
      character(len=:), allocatable, intent(out) :: name
      !> Its value, if that is a part of the word.
      character(len=:), allocatable, intent(out) :: value
      logical, intent(out) :: attached
      integer :: equals

      name = word
      value = ""
      equals = 0
      if (starts_with(word, "--")) equals = index(word, "=")
      if (equals > 0) then
         name = word(:equals - 1)
         value = word(equals + 1:)
      end if
      attached = equals > 0
      found = findloc(options%is_option() .and. (options%name == name .or. &
         options%short == name), .true., dim=1)
      if (found == 0 .and. len(word) > 2) then
         ! As in -j4.
         found = findloc(options%takes == takes_count .and. options%short == word(:2), .true., &
            dim=1)
         if (found == 0) return
         attached = .true.
         name = word(:2)
         value = word(3:)
      end if
      if (found == 0) return
      if (attached .and. options(found)%is_flag()) found = 0
   end subroutine split

   !> Whether an option takes a value.
   pure function fits(option, value)
      type(option_type), intent(in) :: option
      character(len=*), intent(in) :: value
      logical :: fits
      real(wp) :: x

      select case (option%takes)
      case (takes_text)
         fits = value /= "" .or. option%needs == "" .or. option%is_flag()
      case (takes_count)
         fits = verify(value, digits) == 0 .and. len(value) >= 1 .and. len(value) <= 6
         if (fits) fits = verify(value, "0") > 0
      case default
         call read_real(value, x, fits)
         if (fits) fits = ieee_is_finite(x)
         if (fits .and. option%takes == takes_non_negative) fits = x >= 0.0_wp
         if (fits .and. option%takes == takes_positive) fits = x > 0.0_wp
      end select
   end function fits

   !> Report an unknown option, with the nearest one of those that the command has.
   subroutine unknown_option(command, word, error)
      type(command_type), intent(in) :: command
      character(len=*), intent(in) :: word
      type(error_type), allocatable, intent(out) :: error
      character(len=:), allocatable :: text

      text = did_you_mean(word, pack(command%options%name, command%options%is_option()), "")
      if (text == "; ") text = nl // usage_text(command)
      call fatal(error, "unknown option " // quote(word) // text, status_usage)
   end subroutine unknown_option

   !> Add what is given.
   subroutine give(line, option, value)
      type(command_line_type), intent(inout) :: line
      integer, intent(in) :: option
      character(len=*), intent(in) :: value
      type(given_type), allocatable :: longer(:)
      integer :: n

      n = size(line%given)
      allocate(longer(n + 1))
      longer(:n) = line%given
      longer(n + 1)%option = option
      longer(n + 1)%value = value
      call move_alloc(longer, line%given)
   end subroutine give

   !> Whether an option or operand is given.
   pure function has(self, name)
      class(command_line_type), intent(in) :: self
      !> Its name in full.
      character(len=*), intent(in) :: name
      logical :: has

      has = any(self%given%option == &
         findloc(self%commands(self%command)%options%name == name, .true., dim=1))
   end function has

   !> Value of an option or operand; empty if it is not given.
   pure function text_of(self, name) result(text)
      class(command_line_type), intent(in) :: self
      !> Its name in full.
      character(len=*), intent(in) :: name
      character(len=:), allocatable :: text
      integer :: i, option

      text = ""
      option = findloc(self%commands(self%command)%options%name == name, .true., dim=1)
      do i = 1, size(self%given)
         if (self%given(i)%option == option) text = self%given(i)%value
      end do
   end function text_of

   !> All values of an option or operand.
   pure function texts_of(self, name) result(texts)
      class(command_line_type), intent(in) :: self
      !> Its name in full.
      character(len=*), intent(in) :: name
      type(string_type), allocatable :: texts(:)
      integer :: i, n, option

      option = findloc(self%commands(self%command)%options%name == name, .true., dim=1)
      allocate(texts(count(self%given%option == option)))
      n = 0
      do i = 1, size(self%given)
         if (self%given(i)%option /= option) cycle
         n = n + 1
         texts(n)%s = self%given(i)%value
      end do
   end function texts_of

   !> Number that an option gives.
   pure real(wp) function number_of(self, name, default)
      class(command_line_type), intent(in) :: self
      !> Its name in full.
      character(len=*), intent(in) :: name
      !> Number without the option.
      real(wp), intent(in) :: default
      character(len=:), allocatable :: text
      logical :: valid

      number_of = default
      if (.not. self%has(name)) return
      text = self%text(name)
      call read_real(text, number_of, valid)
   end function number_of

   !> Whole number that an option gives; 0 without it.
   pure integer function count_of(self, name)
      class(command_line_type), intent(in) :: self
      !> Its name in full.
      character(len=*), intent(in) :: name
      character(len=:), allocatable :: text

      count_of = 0
      text = self%text(name)
      if (text /= "") read(text, *) count_of
   end function count_of

   !> What `contensou --help` prints.
   function program_usage(commands) result(text)
      type(command_type), intent(in) :: commands(:)
      character(len=:), allocatable :: text
      type(string_type) :: headings(size(commands)), texts(size(commands))
      integer :: i, k

      do i = 1, size(commands)
         headings(i)%s = trim(commands(i)%name)
         if (commands(i)%alias /= "") headings(i)%s = trim(commands(i)%alias)
         do k = 1, size(commands(i)%options)
            if (.not. commands(i)%options(k)%is_option()) headings(i)%s = headings(i)%s // " " // &
               short_form(commands(i)%options(k))
         end do
         texts(i)%s = trim(commands(i)%summary)
      end do
      text = "usage: contensou COMMAND ..." // nl // table_text(headings, texts) // &
         "contensou COMMAND --help tells more" // nl // &
         "programs of their own: contensou-" // trim(tools(1))
      do i = 2, size(tools)
         text = text // ", contensou-" // trim(tools(i))
      end do
   end function program_usage

   !> What `contensou COMMAND --help` prints.
   function usage_text(command) result(text)
      type(command_type), intent(in) :: command
      character(len=:), allocatable :: text
      character(len=:), allocatable :: form
      type(string_type) :: headings(size(command%options)), texts(size(command%options))
      integer :: i, column

      text = "usage: contensou " // trim(command%name)
      column = len(text)
      do i = 1, size(command%options)
         form = short_form(command%options(i))
         associate (option => command%options(i))
            headings(i)%s = trim(option%name)
            if (option%is_option()) then
               if (option%short /= "") headings(i)%s = option%short // ", " // headings(i)%s
               if (.not. option%is_flag()) headings(i)%s = headings(i)%s // " " // &
                  trim(option%value)
            end if
            texts(i)%s = trim(option%text)
            if (len(text) - index(text, nl, back=.true.) + 1 + len(form) > width) text = text // &
               nl // repeat(" ", column)
            text = text // " " // form
         end associate
      end do
      text = text // nl
      if (allocated(command%description)) then
         text = text // paragraph(command%description, 2)
      else
         text = text // "  " // trim(command%summary) // nl
      end if
      text = text // table_text(headings, texts)
      if (allocated(command%notes)) text = text // paragraph(command%notes, 2)
      text = text(:len(text) - 1)
   end function usage_text

   !> An option or operand in the first line of a usage, such as `[-o FILE]`.
   pure function short_form(option) result(text)
      type(option_type), intent(in) :: option
      character(len=:), allocatable :: text

      text = trim(option%name)
      if (option%short /= "") text = trim(option%short)
      if (option%is_option() .and. .not. option%is_flag()) text = text // " " // trim(option%value)
      if (option%is_option() .or. option%needs == "") text = "[" // text // "]"
      if (option%repeats) text = text // "..."
   end function short_form

   !> Texts beside their headings, in lines.
   pure function table_text(headings, texts) result(text)
      type(string_type), intent(in) :: headings(:), texts(:)
      character(len=:), allocatable :: text
      character(len=:), allocatable :: lines
      integer :: i, column

      column = 0
      do i = 1, size(headings)
         column = max(column, len(headings(i)%s) + 4)
      end do
      text = ""
      do i = 1, size(headings)
         lines = paragraph(texts(i)%s, column)
         text = text // "  " // headings(i)%s // lines(len(headings(i)%s) + 3:)
      end do
   end function table_text

   !> The lines of a text, indented and broken where they are too wide.
   pure function paragraph(text, indent) result(lines)
      character(len=*), intent(in) :: text
      !> Blanks before each line.
      integer, intent(in) :: indent
      character(len=:), allocatable :: lines
      integer :: start, length, stop

      lines = ""
      start = 1
      do while (start <= len(text))
         length = index(text(start:) // nl, nl) - 1
         stop = start + length + 1
         if (length > width - indent) then
            length = index(text(start:start + width - indent), " ", back=.true.) - 1
            stop = start + length + 1
         end if
         lines = lines // repeat(" ", indent) // text(start:start + length - 1) // nl
         start = stop
      end do
   end function paragraph

end module contensou_drivers_command_line
