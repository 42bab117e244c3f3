!> Tables of numbers as CSV with a header: read whole, with the place of every mistake; written by
!> way of a block, with 17 significant digits.
module contensou_drivers_table
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite, ieee_is_nan
   use, intrinsic :: iso_fortran_env, only : input_unit, iostat_end, iostat_eor
   use contensou_base_diagnostics, only : diagnostics_type, origin_type, source_type
   use contensou_base_errors, only : error_type, fatal, status_file
   use contensou_base_kinds, only : wp
   use contensou_base_misprints, only : explain_misprint
   use contensou_base_numbers, only : read_real, to_text
   use contensou_base_operating_system, only : check_readable, write_stdout
   use contensou_base_text, only : join, lower, quote, starts_with, string_type, strings
   implicit none(type, external)
   private

   public :: read_lines, read_table, has_column, printer_type, digits17

   !> Mark of UTF-8 at the beginning of a file.
   character(len=*), parameter :: byte_order_mark = char(239) // char(187) // char(191)

   !> Bytes that are written at a time.
   integer, parameter :: block_size = 65536

   !> Rows that are kept before the buffer grows.
   integer, parameter :: first_rows = 1024

   !> Writes lines to the standard output by way of a block.
   type :: printer_type
      private
      !> Lines that wait.
      character(len=block_size) :: block
      !> Bytes of it that are in use.
      integer :: filled = 0
   contains
      procedure, public :: put
      procedure, public :: flush => flush_block
   end type printer_type

contains

   !> Add a line.
   subroutine put(self, line, error)
      class(printer_type), intent(inout) :: self
      character(len=*), intent(in) :: line
      !> Set when the standard output cannot be written.
      type(error_type), allocatable, intent(out) :: error

      if (self%filled + len(line) + 1 > block_size) then
         call self%flush(error)
         if (allocated(error)) return
      end if
      if (len(line) + 1 > block_size) then
         call write_stdout(line // new_line("a"), error)
      else
         self%block(self%filled + 1:self%filled + len(line) + 1) = line // new_line("a")
         self%filled = self%filled + len(line) + 1
      end if
   end subroutine put

   !> Write what waits.
   subroutine flush_block(self, error)
      class(printer_type), intent(inout) :: self
      !> Set when the standard output cannot be written.
      type(error_type), allocatable, intent(out) :: error

      call write_stdout(self%block(:self%filled), error)
      self%filled = 0
   end subroutine flush_block

   !> Whether the header of a table has a column.
   pure function has_column(table, name) result(has)
      type(source_type), intent(in) :: table
      !> Name of the column.
      character(len=*), intent(in) :: name
      logical :: has
      integer, allocatable :: header(:)
      integer :: c

      has = .false.
      if (size(table%lines) == 0) return
      header = field_starts(table%lines(1)%s)
      do c = 1, size(header) - 1
         has = has .or. trim(adjustl(table%lines(1)%s(header(c):header(c + 1) - 2))) == name
      end do
   end function has_column

   !> A number with 17 significant digits.
   pure function digits17(x) result(text)
      real(wp), intent(in) :: x
      character(len=:), allocatable :: text
      character(len=32) :: buffer

      ! Adding zero turns -0 into 0.
      write(buffer, "(es32.16e3)") x + 0.0_wp
      text = trim(adjustl(buffer))
   end function digits17

   !> Columns of a table by their names.
   subroutine read_table(table, names, values, lines, diagnostics)
      type(source_type), intent(in) :: table
      !> Names of the columns that are wanted.
      character(len=*), intent(in) :: names(:)
      !> Their values, (column, row).
      real(wp), allocatable, intent(out) :: values(:, :)
      !> Line of each row.
      integer, allocatable, intent(out) :: lines(:)
      type(diagnostics_type), intent(inout) :: diagnostics
      integer, allocatable :: starts(:), header(:)
      integer :: column(size(names)), i, c, n
      logical :: valid
      type(origin_type) :: place
      character(len=:), allocatable :: message, expected

      allocate(values(size(names), 0), lines(0))
      if (all([(len_trim(table%lines(i)%s) == 0, i=1, size(table%lines))])) then
         call diagnostics%add(origin_type(1, 0, 0, 1), "the table is empty", &
            "a header with " // join(strings(names), ","))
         return
      end if
      header = field_starts(table%lines(1)%s)
      call find_columns(table%lines(1)%s, header, names, column, diagnostics)
      if (diagnostics%count() > 0) return
      deallocate(values, lines)
      allocate(values(size(names), size(table%lines)), lines(size(table%lines)))
      n = 0
      do i = 2, size(table%lines)
         if (len_trim(table%lines(i)%s) == 0) cycle
         starts = field_starts(table%lines(i)%s)
         if (size(starts) /= size(header)) then
            call diagnostics%add(origin_type(1, i, 1, len(table%lines(i)%s)), to_text(size(starts) &
               - 1) // " values in a table of " // to_text(size(header) - 1) // " columns", &
               to_text(size(header) - 1) // " values separated by commas")
            cycle
         end if
         n = n + 1
         lines(n) = i
         do c = 1, size(names)
            call read_real(field(table%lines(i)%s, starts, column(c)), values(c, n), valid)
            place = origin_type(1, i, starts(column(c)), &
               max(starts(column(c) + 1) - starts(column(c)) - 1, 1))
            if (.not. valid) then
               call explain_misprint(field(table%lines(i)%s, starts, column(c)), message, expected)
               if (.not. allocated(message)) then
                  message = quote(field(table%lines(i)%s, starts, column(c))) // " is not a number"
                  expected = "a number"
               end if
               call diagnostics%add(place, message, trim(names(c)) // " = " // expected)
            else if (.not. (ieee_is_finite(values(c, n)) .or. ieee_is_nan(values(c, n)))) then
               call diagnostics%add(place, quote(field(table%lines(i)%s, starts, column(c))) // &
                  " is too large", trim(names(c)) // " = a finite number, below 1.8e308")
            end if
         end do
      end do
      values = values(:, :n)
      lines = lines(:n)
   end subroutine read_table

   !> The columns of a header that have given names.
   subroutine find_columns(line, header, names, column, diagnostics)
      !> The header.
      character(len=*), intent(in) :: line
      !> Starts of its fields.
      integer, intent(in) :: header(:)
      character(len=*), intent(in) :: names(:)
      !> Number of the column of each name.
      integer, intent(out) :: column(:)
      type(diagnostics_type), intent(inout) :: diagnostics
      type(origin_type) :: place
      character(len=:), allocatable :: missing
      integer :: c, i, near

      missing = ""
      place = origin_type(1, 1, 1, max(len(line), 1))
      do i = 1, size(names)
         column(i) = 0
         near = 0
         do c = 1, size(header) - 1
            if (field(line, header, c) == names(i)) then
               if (column(i) > 0) then
                  call diagnostics%add(place_of(c), "the header has the column " // &
                     trim(names(i)) // " twice", "a header with " // &
                     join(strings(names), ",") // ", each once")
               end if
               column(i) = c
            else if (lower(field(line, header, c)) == lower(trim(names(i)))) then
               near = c
            end if
         end do
         if (column(i) > 0) cycle
         if (near > 0 .and. missing == "") place = place_of(near)
         missing = missing // ", " // trim(names(i))
      end do
      if (missing /= "") call diagnostics%add(place, "the header has no column " // missing(3:), &
         "a header with " // join(strings(names), ","))

   contains

      !> Where a column of the header stands.
      pure function place_of(number) result(place)
         !> Number of the column.
         integer, intent(in) :: number
         type(origin_type) :: place

         place = origin_type(1, 1, header(number), header(number + 1) - header(number) - 1)
      end function place_of

   end subroutine find_columns

   !> A field without blanks around it.
   pure function field(line, starts, number) result(text)
      character(len=*), intent(in) :: line
      !> Starts of its fields.
      integer, intent(in) :: starts(:)
      !> Number of the field.
      integer, intent(in) :: number
      character(len=:), allocatable :: text

      text = trim(adjustl(line(starts(number):starts(number + 1) - 2)))
   end function field

   !> Columns where the fields of a line start, and where one after the last would.
   pure function field_starts(line) result(starts)
      character(len=*), intent(in) :: line
      integer, allocatable :: starts(:)
      integer :: i, n

      allocate(starts(2 + count([(line(i:i) == ",", i=1, len(line))])))
      starts(1) = 1
      n = 1
      do i = 1, len(line)
         if (line(i:i) /= ",") cycle
         n = n + 1
         starts(n) = i + 1
      end do
      starts(n + 1) = len(line) + 2
   end function field_starts

   !> Read all lines of a file or of the standard input.
   subroutine read_lines(path, table, error)
      !> Name of the file; blank or "-" for the standard input.
      character(len=*), intent(in) :: path
      type(source_type), intent(out) :: table
      type(error_type), allocatable, intent(out) :: error
      type(string_type), allocatable :: lines(:), longer(:)
      character(len=4096) :: chunk
      character(len=512) :: message
      character(len=:), allocatable :: line
      integer :: unit, status, n, length, i
      logical :: standard

      standard = path == "" .or. path == "-"
      unit = input_unit
      table%name = "standard input"
      if (.not. standard) then
         table%name = path
         call check_readable(path, error)
         if (allocated(error)) return
         open(newunit=unit, file=path, status="old", action="read", iostat=status, iomsg=message)
         if (status /= 0) then
            call fatal(error, path // " cannot be read: " // trim(message), status_file)
            return
         end if
      end if
      allocate(lines(first_rows))
      n = 0
      do
         line = ""
         do
            read(unit, "(a)", advance="no", size=length, iostat=status, iomsg=message) chunk
            if (length > 0 .and. status <= 0) line = line // chunk(:length)
            if (status /= 0) exit
         end do
         if (status == iostat_end .and. line == "") exit
         if (status /= iostat_eor .and. status /= iostat_end) then
            call fatal(error, "cannot read " // table%name // ": " // trim(message), status_file)
            exit
         end if
         if (n == size(lines)) then
            allocate(longer(2*n))
            do i = 1, n
               call move_alloc(lines(i)%s, longer(i)%s)
            end do
            call move_alloc(longer, lines)
         end if
         n = n + 1
         i = len(line)
         if (i > 0) then
            if (line(i:i) == achar(13)) i = i - 1
         end if
         lines(n)%s = line(:i)
         ! Spreadsheets put a byte order mark before the header.
         if (n == 1 .and. starts_with(lines(n)%s, byte_order_mark)) then
            lines(n)%s = line(len(byte_order_mark) + 1:i)
         end if
         if (status == iostat_end) exit
      end do
      if (.not. standard) close(unit)
      allocate(table%lines(n))
      do i = 1, n
         call move_alloc(lines(i)%s, table%lines(i)%s)
      end do
   end subroutine read_lines

end module contensou_drivers_table
