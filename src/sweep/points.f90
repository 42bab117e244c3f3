!> The table of cases of a sweep with `sampling = 'file'`: CSV with a header, or HDF5 with a
!> one-dimensional data set for each parameter.
module contensou_sweep_points
   use contensou_base_diagnostics, only : diagnostics_type, origin_type, source_type
   use contensou_base_constants, only : expression_value
   use contensou_base_document, only : value_logical, value_null, value_real, value_text, value_type
   use contensou_base_errors, only : error_type, fatal, status_file, status_usage
   use contensou_base_expressions, only : constants_type
   use contensou_base_kinds, only : i8, wp
   use contensou_base_numbers, only : read_real, to_text
   use contensou_base_operating_system, only : check_readable, first_bytes
   use contensou_base_scanner, only : in_utf8
   use contensou_base_schema, only : kind_logical
   use contensou_base_text, only : invalid_byte, invalid_byte_text, lower, quote, starts_with, &
      string_type, valid_utf8
   use contensou_files_hdf5_reader, only : class_integer, class_real, class_text, class_unsigned, &
      hdf5_entry_type, hdf5_item_type, hdf5_reader_type, max_rank, object_dataset, object_group, &
      probe
   use contensou_sweep_target, only : target_type
   implicit none(type, external)
   private

   public :: points_type, points_column_type, logical_of

   !> A column that is read.
   type :: points_column_type
      type(target_type), allocatable :: targets(:)
      !> Texts that stand in it; a value of the column is a position in this list.
      type(string_type), allocatable :: words(:)
   end type points_column_type

   !> A table of cases.
   type :: points_type
      character(len=:), allocatable :: path
      !> Names of the columns.
      type(string_type), allocatable :: names(:)
      !> Where they stand; the source is not set.
      type(origin_type), allocatable :: places(:)
      !> First line, for messages about names.
      character(len=:), allocatable :: header
      !> Values, (column, row): numbers, or positions in the words of the column.
      real(wp), allocatable :: values(:, :)
      !> Number of rows.
      integer(i8) :: n = 0
      !> Whether the file is HDF5.
      logical, private :: is_hdf5 = .false.
      !> Path of the group with the columns.
      character(len=:), allocatable, private :: folder
      integer, private :: header_line = 0
   contains
      procedure :: open
      procedure :: read => read_values
      procedure :: header_source
   end type points_type

   !> Largest length of a line.
   integer, parameter :: longest_line = 1000000

   !> Number of mistakes after which reading ends.
   integer, parameter :: enough_mistakes = 60

   !> Rows of HDF5 that are read at a time.
   integer(i8), parameter :: block_rows = 65536_i8

   !> Mark of UTF-8 at the beginning of a file.
   character(len=*), parameter :: byte_order_mark = char(239) // char(187) // char(191)

   !> First bytes of an HDF5 file.
   character(len=*), parameter :: signature = char(137) // "HDF"

contains

   !> Find the columns of a table.
   subroutine open(self, path, error)
      class(points_type), intent(inout) :: self
      character(len=*), intent(in) :: path
      !> Set when it cannot be read or is no table.
      type(error_type), allocatable, intent(out) :: error
      character(len=:), allocatable :: line
      integer :: unit, stat, number, number_of_byte

      self%path = path
      call check_readable(path, error)
      if (allocated(error)) return
      self%is_hdf5 = first_bytes(path, len(signature)) == signature
      if (self%is_hdf5) then
         call list_columns(self, error)
         return
      end if
      open(newunit=unit, file=path, form="formatted", status="old", action="read", iostat=stat)
      if (stat /= 0) then
         call fatal(error, path // " cannot be read", status_file)
         return
      end if
      number = 0
      do
         call next_line(unit, line, number, stat)
         if (stat /= 0) exit
         if (number == 1 .and. starts_with(line, byte_order_mark)) line = line(4:)
         if (line /= "") exit
      end do
      close(unit)
      if (stat /= 0) then
         call fatal(error, path // " is empty: it needs a header with the paths of parameters", &
            status_usage)
         return
      end if
      number_of_byte = invalid_byte(line)
      if (number_of_byte > 0) then
         call fatal(error, path // ", line " // to_text(number) // ", byte " // &
            to_text(number_of_byte) // ": " // &
            invalid_byte_text(line(number_of_byte:number_of_byte)), status_usage)
         return
      end if
      self%header = line
      self%header_line = number
      call split(line, self%names, self%places)
      self%places%line = number
   end subroutine open

   !> The header as a source of messages.
   function header_source(self) result(lines)
      class(points_type), intent(in) :: self
      type(source_type) :: lines

      lines%name = self%path
      if (self%header_line > 0) call keep_line(lines, self%header_line, self%header)
   end function header_source

   !> Find the columns of an HDF5 file.
   subroutine list_columns(self, error)
      class(points_type), intent(inout) :: self
      !> Set when it has none.
      type(error_type), allocatable, intent(out) :: error
      type(hdf5_reader_type) :: reader
      type(hdf5_item_type) :: item
      type(hdf5_entry_type), allocatable :: entries(:), attributes(:)
      logical, allocatable :: wanted(:)
      integer(i8) :: address, length
      integer :: i, k, kind, n

      self%header = ""
      self%folder = "/"
      call probe(self%path, error)
      if (.not. allocated(error)) call reader%open(self%path, error)
      if (allocated(error)) return
      call reader%list("/", .false., entries, error)
      if (.not. allocated(error)) then
         do i = 1, size(entries)
            if (entries(i)%name /= "parameters") cycle
            call reader%object("/parameters", kind, address, error)
            if (.not. allocated(error) .and. kind == object_group) self%folder = "/parameters/"
         end do
      end if
      if (.not. allocated(error)) call reader%list(self%folder, .false., entries, error)
      if (allocated(error)) then
         call reader%close()
         return
      end if
      allocate(wanted(size(entries)), source=.false.)
      length = -1
      do i = 1, size(entries)
         call reader%object(self%folder // entries(i)%name, kind, address, error)
         if (allocated(error)) exit
         if (kind /= object_dataset) cycle
         call reader%list(self%folder // entries(i)%name, .true., attributes, error)
         if (allocated(error)) exit
         ! A scale that only numbers the rows.
         if (any([(attributes(k)%name == "CLASS", k=1, size(attributes))])) cycle
         call reader%open_item(self%folder // entries(i)%name, "", item, error)
         if (allocated(error)) exit
         wanted(i) = item%rank == 1 .and. .not. item%is_null
         k = invalid_byte(entries(i)%name)
         if (wanted(i) .and. k > 0) call fatal(error, self%path // ", name " // &
            valid_utf8(entries(i)%name) // ", byte " // to_text(k) // ": " // &
            invalid_byte_text(entries(i)%name(k:k)), status_usage)
         if (wanted(i)) then
            if (length >= 0 .and. item%extents(1) /= length) call fatal(error, self%path // &
               ": the columns are not equally long: " // entries(i)%name // " has " // &
               to_text(item%extents(1)) // " values, others have " // to_text(length), status_usage)
            length = item%extents(1)
         end if
         call item%close()
         if (allocated(error)) exit
      end do
      call reader%close()
      if (allocated(error)) return
      n = count(wanted)
      if (n == 0) then
         call fatal(error, self%path // " has no one-dimensional datasets in " // self%folder // &
            ", one for each parameter", status_usage)
         return
      end if
      self%n = length
      allocate(self%names(n), self%places(n))
      n = 0
      do i = 1, size(entries)
         if (.not. wanted(i)) cycle
         n = n + 1
         self%names(n)%s = entries(i)%name
      end do
   end subroutine list_columns

   !> Read the values of all columns and check each.
   subroutine read_values(self, columns, constants, source, lines, diagnostics, error)
      class(points_type), intent(inout) :: self
      !> What takes them, in the order of the columns.
      type(points_column_type), intent(inout) :: columns(:)
      !> Constants that expressions may name.
      type(constants_type), intent(in) :: constants
      !> Number that the table has as a source of mistakes.
      integer, intent(in) :: source
      !> Lines with mistakes, for messages; the others are not allocated.
      type(source_type), intent(out) :: lines
      type(diagnostics_type), intent(inout) :: diagnostics
      type(error_type), allocatable, intent(out) :: error
      integer :: i, before

      before = diagnostics%count()
      do i = 1, size(columns)
         allocate(columns(i)%words(0))
      end do
      lines = self%header_source()
      if (self%is_hdf5) then
         call read_hdf5(self, columns, constants, source, diagnostics, error)
      else
         call read_csv(self, columns, constants, source, lines, diagnostics, error)
      end if
      if (allocated(error)) return
      if (self%n == 0 .and. diagnostics%count() == before) call fatal(error, &
         self%path // " has no rows: a sweep has at least one case", status_usage)
   end subroutine read_values

   subroutine read_csv(self, columns, constants, source, lines, diagnostics, error)
      type(points_type), intent(inout) :: self
      type(points_column_type), intent(inout) :: columns(:)
      !> Constants that expressions may name.
      type(constants_type), intent(in) :: constants
      integer, intent(in) :: source
      !> Lines with mistakes.
      type(source_type), intent(inout) :: lines
      type(diagnostics_type), intent(inout) :: diagnostics
      type(error_type), allocatable, intent(out) :: error
      type(string_type), allocatable :: cells(:)
      type(origin_type), allocatable :: places(:)
      type(value_type) :: value
      real(wp), allocatable :: larger(:, :)
      character(len=:), allocatable :: line
      integer :: unit, stat, number, i, before
      logical :: good

      open(newunit=unit, file=self%path, form="formatted", status="old", action="read", iostat=stat)
      if (stat /= 0) then
         call fatal(error, self%path // " cannot be read", status_file)
         return
      end if
      before = diagnostics%count()
      allocate(self%values(size(columns), 1024))
      self%n = 0
      number = 0
      do
         call next_line(unit, line, number, stat)
         if (stat /= 0) exit
         if (number <= self%header_line .or. line == "") cycle
         if (diagnostics%count() - before >= enough_mistakes) exit
         i = invalid_byte(line)
         if (i > 0) then
            call diagnostics%add(origin_type(source, number, i, 1), invalid_byte_text(line(i:i)), &
               in_utf8)
            call keep_line(lines, number, line)
            cycle
         end if
         call split(line, cells, places)
         places%source = source
         places%line = number
         if (size(cells) /= size(columns)) then
            call diagnostics%add(places(size(cells)), to_text(size(cells)) // &
               trim(merge(" value ", " values", size(cells) == 1)) // " in a table with " // &
               to_text(size(columns)) // trim(merge(" column ", " columns", size(columns) == 1)), &
               "as many values as the header has names")
            call keep_line(lines, number, line)
            cycle
         end if
         if (self%n == size(self%values, 2)) then
            allocate(larger(size(columns), 2*self%n))
            larger(:, :self%n) = self%values
            call move_alloc(larger, self%values)
         end if
         self%n = self%n + 1
         do i = 1, size(columns)
            value%origin = places(i)
            call understand(cells(i)%s, columns(i), constants, value, diagnostics, good)
            if (good) call take(columns(i), value, self%values(i, self%n), diagnostics, good)
            if (.not. good) call keep_line(lines, number, line)
         end do
      end do
      close(unit)
      if (stat > 0) call fatal(error, self%path // " cannot be read beyond line " // &
         to_text(number), status_file)
   end subroutine read_csv

   subroutine read_hdf5(self, columns, constants, source, diagnostics, error)
      type(points_type), intent(inout) :: self
      type(points_column_type), intent(inout) :: columns(:)
      !> Constants that expressions may name.
      type(constants_type), intent(in) :: constants
      integer, intent(in) :: source
      type(diagnostics_type), intent(inout) :: diagnostics
      type(error_type), allocatable, intent(out) :: error
      type(hdf5_reader_type) :: reader
      type(hdf5_item_type) :: item
      type(diagnostics_type) :: found
      type(string_type), allocatable :: texts(:)
      type(value_type) :: value
      real(wp), allocatable :: reals(:)
      integer(i8) :: row
      integer :: i, k, n, bad
      logical :: good

      call reader%open(self%path, error)
      if (allocated(error)) return
      allocate(self%values(size(columns), self%n), reals(min(self%n, block_rows)))
      do i = 1, size(columns)
         call reader%open_item(self%folder // self%names(i)%s, "", item, error)
         if (allocated(error)) exit
         row = 0
         do while (row < self%n)
            n = int(min(block_rows, self%n - row))
            select case (item%class)
            case (class_real, class_integer, class_unsigned)
               call item%read([row], [int(n, i8)], reals(:n), error)
            case (class_text)
               call item%read_texts([row], [int(n, i8)], n, texts, error)
            case default
               call fatal(error, self%path // ": " // self%names(i)%s // &
                  " holds neither numbers nor texts", status_usage)
            end select
            if (allocated(error)) exit
            do k = 1, n
               value = value_type()
               found = diagnostics_type()
               good = .true.
               value%origin = origin_type(source, 0, 0, 1)
               if (item%class == class_text) then
                  bad = invalid_byte(texts(k)%s)
                  if (bad > 0) then
                     call diagnostics%add(value%origin, "row " // to_text(row + k) // " of " // &
                        self%names(i)%s // ", byte " // to_text(bad) // ": " // &
                        invalid_byte_text(texts(k)%s(bad:bad)), in_utf8)
                     cycle
                  end if
                  call understand(texts(k)%s, columns(i), constants, value, found, good)
               else
                  value%kind = value_real
                  value%real = reals(k)
               end if
               if (good) call take(columns(i), value, self%values(i, row + k), found, good)
               if (good .or. found%count() == 0) cycle
               call diagnostics%add(value%origin, "row " // to_text(row + k) // " of " // &
                  self%names(i)%s // ": " // found%message(1), found%expected(1))
               if (diagnostics%count() >= enough_mistakes) exit
            end do
            row = row + n
            if (diagnostics%count() >= enough_mistakes) exit
         end do
         call item%close()
         if (allocated(error)) exit
      end do
      call reader%close()
   end subroutine read_hdf5

   !> What a cell says: a number where one is wanted and there is one, else a text.
   subroutine understand(cell, column, constants, value, diagnostics, good)
      character(len=*), intent(in) :: cell
      type(points_column_type), intent(in) :: column
      !> Constants that expressions may name.
      type(constants_type), intent(in) :: constants
      !> What it says; its origin is kept.
      type(value_type), intent(inout) :: value
      type(diagnostics_type), intent(inout) :: diagnostics
      !> False after a mistake in an expression.
      logical, intent(out) :: good
      real(wp) :: x
      logical :: is_one, valid

      good = .true.
      value%kind = value_null
      if (cell == "") return
      if (column%targets(1)%is_text()) then
         value%kind = value_text
         value%text = cell
         if (column%targets(1)%key%kind == kind_logical) call logical_of(cell, value)
         return
      end if
      call read_real(cell, value%real, valid)
      value%kind = value_real
      if (valid) return
      value%kind = value_text
      value%text = cell
      call expression_value(value, constants, x, is_one, diagnostics, good)
      if (is_one) then
         value%kind = value_real
         value%real = x
      else
         good = .true.
      end if
   end subroutine understand

   !> A logical in one of the forms that Fortran reads, if a text is one.
   subroutine logical_of(text, value)
      character(len=*), intent(in) :: text
      !> Its value; unchanged if it is no logical.
      type(value_type), intent(inout) :: value

      select case (lower(text))
      case (".true.", "true", "t", ".t.")
         value%kind = value_logical
         value%logical = .true.
      case (".false.", "false", "f", ".f.")
         value%kind = value_logical
         value%logical = .false.
      case default
         continue
      end select
   end subroutine logical_of

   !> Check a value and keep it.
   subroutine take(column, value, kept, diagnostics, good)
      !> Its column; a new text is added to its words.
      type(points_column_type), intent(inout) :: column
      type(value_type), intent(in) :: value
      !> The number, or the position of the text.
      real(wp), intent(out) :: kept
      type(diagnostics_type), intent(inout) :: diagnostics
      !> Whether it is in order.
      logical, intent(out) :: good
      type(string_type), allocatable :: longer(:)
      character(len=:), allocatable :: word
      integer :: i

      kept = 0.0_wp
      do i = 1, size(column%targets)
         call column%targets(i)%check(value, diagnostics, good)
         if (.not. good) return
      end do
      if (value%kind == value_real) then
         kept = value%real
         return
      end if
      if (value%kind == value_logical) then
         word = to_text(value%logical)
      else
         word = value%text
      end if
      do i = 1, size(column%words)
         if (column%words(i)%s == word) exit
      end do
      kept = real(i, wp)
      if (i <= size(column%words)) return
      allocate(longer(i))
      longer(:i - 1) = column%words
      longer(i)%s = word
      call move_alloc(longer, column%words)
   end subroutine take

   !> Keep a line with a mistake for its message.
   subroutine keep_line(lines, number, line)
      !> Lines with mistakes.
      type(source_type), intent(inout) :: lines
      !> Number of the line.
      integer, intent(in) :: number
      character(len=*), intent(in) :: line
      type(string_type), allocatable :: more(:)
      integer :: i

      if (.not. allocated(lines%lines)) allocate(lines%lines(0))
      if (size(lines%lines) < number) then
         allocate(more(number))
         do i = 1, size(lines%lines)
            call move_alloc(lines%lines(i)%s, more(i)%s)
         end do
         call move_alloc(more, lines%lines)
      end if
      lines%lines(number)%s = line
   end subroutine keep_line

   !> Next line of a file, without its end.
   subroutine next_line(unit, line, number, stat)
      !> The file.
      integer, intent(in) :: unit
      character(len=:), allocatable, intent(out) :: line
      !> Number of the line; the one before on entry.
      integer, intent(inout) :: number
      !> Not zero when there is no line: negative at the end, positive after a failure.
      integer, intent(out) :: stat
      character(len=1024) :: piece
      integer :: n

      line = ""
      do
         read(unit, "(a)", advance="no", size=n, iostat=stat) piece
         line = line // piece(:n)
         if (stat /= 0) exit
         if (len(line) > longest_line) then
            stat = 1
            return
         end if
      end do
      if (is_iostat_end(stat) .and. line == "") return
      if (stat > 0) return
      stat = 0
      number = number + 1
      if (len(line) == 0) return
      if (line(len(line):) == achar(13)) line = line(:len(line) - 1)
   end subroutine next_line

   !> Cut a line into cells at its commas; quotes around a cell are removed.
   subroutine split(line, cells, places)
      character(len=*), intent(in) :: line
      !> The cells, without blanks around them.
      type(string_type), allocatable, intent(out) :: cells(:)
      !> Where they stand in the line.
      type(origin_type), allocatable, intent(out) :: places(:)
      integer :: n, i, start, first, last
      character(len=1) :: within

      do i = 1, 2
         n = 0
         start = 1
         do
            within = " "
            do last = start, len(line)
               if (within /= " ") then
                  if (line(last:last) == within) within = " "
               else if (scan(line(last:last), "'""") > 0) then
                  within = line(last:last)
               else if (line(last:last) == ",") then
                  exit
               end if
            end do
            n = n + 1
            if (i == 2) then
               first = start - 1 + verify(line(start:last - 1) // "x", " " // achar(9))
               places(n)%column = first
               cells(n)%s = trim(adjustl(line(first:last - 1)))
               places(n)%length = max(len(cells(n)%s), 1)
               if (len(cells(n)%s) >= 2) then
                  if (scan(cells(n)%s(1:1), "'""") > 0 .and. cells(n)%s(1:1) == &
                     cells(n)%s(len(cells(n)%s):)) cells(n)%s = &
                     cells(n)%s(2:len(cells(n)%s) - 1)
               end if
            end if
            if (last > len(line)) exit
            start = last + 1
         end do
         if (i == 1) allocate(cells(n), places(n))
      end do
   end subroutine split

end module contensou_sweep_points
