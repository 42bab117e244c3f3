!> The table of a sweep in HDF5, written and read by blocks of rows: docs/sweeps.md describes its
!> format.
!>
!> Rows wait until a chunk is full, so that each chunk is compressed and written once. Memory does
!> not grow with the number of rows.
module contensou_sweep_table
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite
   use, intrinsic :: iso_c_binding, only : c_int8_t
   use contensou_base_errors, only : error_type, fatal, status_file, status_usage
   use contensou_base_kinds, only : i8, wp
   use contensou_base_numbers, only : to_text
   use contensou_base_operating_system, only : check_writable, file_exists, remove_dead_lock, &
      remove_file, sweep_up, temporary_name
   use contensou_base_output_path, only : what_helps
   use contensou_base_text, only : join, pad, string_type, strings
   use contensou_files_earlier, only : settings_difference
   use contensou_files_hdf5_file, only : hdf5_file_type, hdf5_series_type, series_byte, &
      series_long, series_real, series_text
   use contensou_files_hdf5_reader, only : class_integer, class_real, class_text, &
      hdf5_entry_type, &
      hdf5_item_type, hdf5_reader_type, probe
   use contensou_files_provenance, only : put_header, put_provenance
   use contensou_sweep_plan, only : sweep_type
   implicit none(type, external)
   private

   public :: sweep_table_type, table_reader_type, table_header_type, check_table, &
      read_table_header, sweep_difference
   public :: case_complete, case_failed, case_invalid, case_too_long, case_crashed, last_status, &
      status_names
   public :: sweep_filetype, sweep_filetype_version

   !> What the file is, for programs that open it.
   character(len=*), parameter :: sweep_filetype = "contensou-sweep"

   !> Version of the format: the second number grows with additions, the first with changes.
   character(len=*), parameter :: sweep_filetype_version = "1.2"

   !> The case was computed to its end.
   integer, parameter :: case_complete = 0

   !> The run of the case failed.
   integer, parameter :: case_failed = 1

   !> The case has no valid scene.
   integer, parameter :: case_invalid = 2

   !> The case was given up at the time limit.
   integer, parameter :: case_too_long = 3

   !> The program crashed in the case.
   integer, parameter :: case_crashed = 4

   !> Last of these.
   integer, parameter :: last_status = case_crashed

   !> Words for the status of a case, from 0.
   character(len=*), parameter :: status_names(0:last_status) = [character(len=13) :: &
      "complete", "failed", "invalid_scene", "time_limit", "crashed"]

   !> What stands for a count that is not known; readers that follow CF make it NaN.
   integer(i8), parameter :: no_count = -1_i8

   integer, parameter :: chunk_rows = 8192

   !> Bytes of padded texts that are handed over at a time.
   integer, parameter :: text_bytes = 4*1024*1024

   !> What a complete table says about itself.
   type :: table_header_type
      !> Fingerprint of its sweep.
      character(len=16) :: fingerprint = ""
      !> Number of cases of the whole sweep.
      integer(i8) :: n_cases = 0
      !> Number of rows of this table.
      integer(i8) :: n_rows = 0
      !> Its cases, as ranges such as "1:500,800".
      character(len=:), allocatable :: cases
      !> The base scene and the sweep with all settings; a table may lack the latter.
      character(len=:), allocatable :: resolved, settings
   end type table_header_type

   !> A column with the rows that wait.
   type :: column_type
      character(len=:), allocatable :: path
      character(len=:), allocatable :: name
      !> Units; empty for none.
      character(len=:), allocatable :: units
      character(len=:), allocatable :: long_name
      !> `series_real`, `series_long` or `series_text`.
      integer :: kind = series_real
      !> Numbers that wait.
      real(wp), allocatable :: reals(:)
      !> Integers that wait.
      integer(i8), allocatable :: longs(:)
      !> Texts that wait.
      type(string_type), allocatable :: texts(:)
      !> The data set that is written.
      type(hdf5_series_type) :: series
      !> The data set that is read.
      type(hdf5_item_type) :: item
   end type column_type

   !> Texts that a table carries.
   type :: origins_type
      !> The sweep file.
      character(len=:), allocatable :: sweep
      !> The file of the base scene.
      character(len=:), allocatable :: scene
      !> The base scene with all settings.
      character(len=:), allocatable :: resolved
      !> The sweep with all settings that its rows depend on.
      character(len=:), allocatable :: settings
      !> Title of the base scene.
      character(len=:), allocatable :: title
   end type origins_type

   !> A table that is being read.
   type :: table_reader_type
      !> What it says about itself.
      type(table_header_type) :: header
      character(len=:), allocatable :: path
      !> Texts that it carries.
      type(origins_type), private :: origins
      type(hdf5_reader_type), private :: reader
      !> Columns of parameters, then of results.
      type(column_type), allocatable, private :: columns(:)
      !> How many of them are parameters.
      integer, private :: n_parameters = 0
      !> Number, status and message of the cases.
      type(hdf5_item_type), private :: number, status, message
   contains
      procedure :: open => open_reader
      procedure :: close => close_reader
      procedure :: numbers
      procedure :: difference
   end type table_reader_type

   !> A table that is being written.
   type :: sweep_table_type
      !> Name of the complete file.
      character(len=:), allocatable :: name
      !> Whether it may replace an existing file.
      logical :: replace = .false.
      !> Number of cases of each status so far.
      integer(i8) :: counts(0:last_status) = 0
      type(hdf5_file_type), private :: file
      !> Columns of parameters, then of results.
      type(column_type), allocatable, private :: columns(:)
      !> How many of them are parameters.
      integer, private :: n_parameters = 0
      !> Data sets of number, status and message.
      type(hdf5_series_type), private :: number, status, message
      !> Numbers of the cases that wait.
      integer(i8), allocatable, private :: numbers(:)
      !> Their status.
      integer(c_int8_t), allocatable, private :: statuses(:)
      type(string_type), allocatable, private :: messages(:)
      !> How many wait.
      integer, private :: waiting = 0
   contains
      procedure :: open => open_table
      procedure :: open_like
      procedure :: append
      procedure :: append_from
      procedure :: finish
      procedure :: abandon
   end type sweep_table_type

contains

   !> Create the table of a sweep with everything but its rows.
   subroutine open_table(self, name, replace, sweep, cases, command_line, error)
      class(sweep_table_type), intent(inout) :: self
      !> Name of the complete file.
      character(len=*), intent(in) :: name
      !> Whether it may replace an existing file.
      logical, intent(in) :: replace
      type(sweep_type), intent(in) :: sweep
      !> The cases it is to hold, as ranges such as "1:500,800"; each ascending.
      character(len=*), intent(in) :: cases
      character(len=*), intent(in) :: command_line
      type(error_type), allocatable, intent(out) :: error
      type(origins_type) :: origins
      type(table_header_type) :: header
      integer :: i, n

      n = size(sweep%parameters)
      self%n_parameters = n
      if (allocated(self%columns)) deallocate(self%columns)
      allocate(self%columns(n + size(sweep%results)))
      do i = 1, n
         associate (column => self%columns(i), parameter => sweep%parameters(i))
            column%name = parameter%name
            column%units = parameter%units
            column%long_name = parameter%long_name
            if (parameter%is_text) column%kind = series_text
         end associate
      end do
      do i = 1, size(sweep%results)
         associate (column => self%columns(n + i), result => sweep%results(i))
            column%name = result%name
            column%units = result%units
            column%long_name = result%long_name
            if (result%is_integer) column%kind = series_long
         end associate
      end do
      origins%sweep = sweep%text
      origins%scene = sweep%scene_text
      origins%resolved = sweep%scene_resolved
      origins%settings = sweep%settings
      origins%title = sweep%scene%title
      header%fingerprint = sweep%fingerprint
      header%n_cases = sweep%n_cases
      header%cases = cases
      call create(self, name, replace, header, origins, command_line, error)
   end subroutine open_table

   !> Create a table with the columns and texts of another one.
   subroutine open_like(self, name, replace, other, cases, command_line, error)
      class(sweep_table_type), intent(inout) :: self
      !> Name of the complete file.
      character(len=*), intent(in) :: name
      !> Whether it may replace an existing file.
      logical, intent(in) :: replace
      type(table_reader_type), intent(in) :: other
      !> The cases it is to hold.
      character(len=*), intent(in) :: cases
      character(len=*), intent(in) :: command_line
      type(error_type), allocatable, intent(out) :: error
      type(table_header_type) :: header
      integer :: i

      self%n_parameters = other%n_parameters
      if (allocated(self%columns)) deallocate(self%columns)
      allocate(self%columns(size(other%columns)))
      do i = 1, size(self%columns)
         self%columns(i)%name = other%columns(i)%name
         self%columns(i)%units = other%columns(i)%units
         self%columns(i)%long_name = other%columns(i)%long_name
         self%columns(i)%kind = other%columns(i)%kind
      end do
      header%fingerprint = other%header%fingerprint
      header%n_cases = other%header%n_cases
      header%cases = cases
      call create(self, name, replace, header, other%origins, command_line, error)
   end subroutine open_like

   !> Create the file.
   subroutine create(self, name, replace, header, origins, command_line, error)
      !> The table; its columns have names, units and kinds.
      type(sweep_table_type), intent(inout) :: self
      !> Name of the complete file.
      character(len=*), intent(in) :: name
      !> Whether it may replace an existing file.
      logical, intent(in) :: replace
      !> What it says about itself.
      type(table_header_type), intent(in) :: header
      !> Texts that it carries.
      type(origins_type), intent(in) :: origins
      character(len=*), intent(in) :: command_line
      type(error_type), allocatable, intent(out) :: error
      integer :: i

      self%name = name
      self%replace = replace
      self%waiting = 0
      self%counts = 0
      associate (f => self%file)
         call sweep_up(name)
         call f%create(temporary_name(name), error)
         if (allocated(error)) return
         call f%bound_memory(error)
         call put_header(f, sweep_filetype, sweep_filetype_version, "running", error, origins%title)
         call f%put_attribute("/", "fingerprint", header%fingerprint, error)
         call f%put_attribute_values("/", "case_count", header%n_cases, error)
         call f%put_attribute("/", "cases", header%cases, error)
         call f%create_group("/input", error)
         call f%put_text("/input/sweep", origins%sweep, "text of the sweep file", error)
         call f%put_text("/input/scene", origins%scene, "text of the file of the base scene", error)
         call f%put_text("/input/resolved", origins%resolved, &
            "base scene, all settings with defaults", error)
         if (allocated(origins%settings)) call f%put_text("/input/settings", origins%settings, &
            "sweep, all settings that the rows depend on", error)
         call f%put_text("/input/command_line", command_line, "command line", error)
         call put_provenance(f, error)
         call put_series("/case", "1", "number of the case", series_long, self%number)
         call put_series("/status", "", "what became of the case", series_byte, self%status)
         call f%put_attribute_values("/status", "flag_values", [(int(i, c_int8_t), &
            i=0, last_status)], error)
         call f%put_attribute("/status", "flag_meanings", join(strings(status_names), " "), error)
         call put_series("/message", "", "why the case is not complete", series_text, self%message)
         call f%create_group("/parameters", error)
         call f%create_group("/results", error)
         call put_order("/parameters", self%columns(:self%n_parameters))
         call put_order("/results", self%columns(self%n_parameters + 1:))
         do i = 1, size(self%columns)
            associate (column => self%columns(i))
               column%path = "/results/" // column%name
               if (i <= self%n_parameters) column%path = "/parameters/" // column%name
               call put_series(column%path, column%units, column%long_name, column%kind, &
                  column%series)
               if (column%kind == series_long) call f%put_attribute_values( &
                  column%path, "_FillValue", no_count, error)
               select case (column%kind)
               case (series_long)
                  allocate(column%longs(chunk_rows))
               case (series_text)
                  allocate(column%texts(chunk_rows))
               case default
                  allocate(column%reals(chunk_rows))
               end select
            end associate
         end do
         if (.not. allocated(self%numbers)) allocate(self%numbers(chunk_rows), &
            self%statuses(chunk_rows), self%messages(chunk_rows))
         ! A failure is kept by the file, so that this last call sees the first one.
         call f%flush(error)
      end associate

   contains

      !> Note the order of the columns, which a group does not keep for all readers.
      subroutine put_order(group, columns)
         character(len=*), intent(in) :: group
         type(column_type), intent(in) :: columns(:)
         type(string_type) :: names(size(columns))
         character(len=:), allocatable :: padded(:)
         integer :: k

         do k = 1, size(columns)
            names(k)%s = columns(k)%name
         end do
         call pad(names, padded)
         if (size(names) > 0) call self%file%put_attribute_values(group, "columns", padded, error)
      end subroutine put_order

      !> Create a series of rows; `/case` is the scale of all.
      subroutine put_series(path, units, long_name, kind, series)
         character(len=*), intent(in) :: path
         character(len=*), intent(in) :: units
         character(len=*), intent(in) :: long_name
         !> One of the `series_*` codes.
         integer, intent(in) :: kind
         type(hdf5_series_type), intent(out) :: series
         character(len=*), parameter :: scale(1) = ["/case"]
         logical :: is_scale

         is_scale = path == scale(1)
         call self%file%create_series(path, [integer ::], scale(:merge(0, 1, is_scale)), is_scale, &
            chunk_rows, units, long_name, kind, series, error, compressed=.true.)
      end subroutine put_series

   end subroutine create

   !> Append rows; the parameters are computed from the numbers of the cases. Best some thousands
   !> at a time.
   subroutine append(self, sweep, cases, status, messages, results, error)
      class(sweep_table_type), intent(inout) :: self
      type(sweep_type), intent(in) :: sweep
      !> Numbers of the cases, ascending.
      integer(i8), intent(in) :: cases(:)
      !> Status of each, one of the `case_*` codes.
      integer, intent(in) :: status(:)
      !> Message of each; empty for a complete case.
      type(string_type), intent(in) :: messages(:)
      !> Results, (column, row); what is not known is NaN.
      real(wp), intent(in) :: results(:, :)
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: values(size(sweep%parameters))
      type(string_type) :: words(size(sweep%parameters))
      integer :: i, k, n

      n = self%n_parameters
      do i = 1, size(cases)
         self%waiting = self%waiting + 1
         associate (row => self%waiting)
            self%numbers(row) = cases(i)
            self%statuses(row) = int(status(i), c_int8_t)
            self%messages(row)%s = messages(i)%s
            call sweep%parameters_of(cases(i), values, words)
            do k = 1, n
               if (self%columns(k)%kind == series_text) then
                  self%columns(k)%texts(row)%s = words(k)%s
               else
                  self%columns(k)%reals(row) = values(k)
               end if
            end do
            do k = 1, size(results, 1)
               if (self%columns(n + k)%kind /= series_long) then
                  self%columns(n + k)%reals(row) = results(k, i)
               else if (ieee_is_finite(results(k, i))) then
                  self%columns(n + k)%longs(row) = nint(results(k, i), i8)
               else
                  self%columns(n + k)%longs(row) = no_count
               end if
            end do
         end associate
         if (self%waiting < chunk_rows) cycle
         call write_waiting(self, error)
         if (allocated(error)) return
      end do
   end subroutine append

   !> Append rows of another table with the same columns.
   subroutine append_from(self, other, first, last, error)
      class(sweep_table_type), intent(inout) :: self
      type(table_reader_type), intent(in) :: other
      !> First row, from 1.
      integer(i8), intent(in) :: first
      !> Last row.
      integer(i8), intent(in) :: last
      !> Set when a file cannot be read or written.
      type(error_type), allocatable, intent(out) :: error
      integer(i8) :: start(1), count(1), longs(chunk_rows), row
      integer :: i, n
      type(string_type), allocatable :: texts(:)

      row = first
      do while (row <= last)
         n = int(min(last - row + 1, int(chunk_rows - self%waiting, i8)))
         start = row - 1
         count = n
         associate (a => self%waiting + 1, b => self%waiting + n)
            call other%number%read(start, count, self%numbers(a:b), error)
            if (.not. allocated(error)) call other%status%read(start, count, longs(:n), &
               error)
            if (.not. allocated(error)) call other%message%read_texts(start, count, n, texts, error)
            if (allocated(error)) return
            self%statuses(a:b) = int(longs(:n), c_int8_t)
            self%messages(a:b) = texts(:n)
            do i = 1, size(self%columns)
               associate (column => self%columns(i), item => other%columns(i)%item)
                  select case (column%kind)
                  case (series_long)
                     call item%read(start, count, column%longs(a:b), error)
                  case (series_text)
                     call item%read_texts(start, count, n, texts, error)
                     if (.not. allocated(error)) column%texts(a:b) = texts(:n)
                  case default
                     call item%read(start, count, column%reals(a:b), error)
                  end select
               end associate
               if (allocated(error)) return
            end do
         end associate
         self%waiting = self%waiting + n
         row = row + n
         if (self%waiting < chunk_rows) cycle
         call write_waiting(self, error)
         if (allocated(error)) return
      end do
   end subroutine append_from

   !> Write the rows that wait.
   subroutine write_waiting(self, error)
      class(sweep_table_type), intent(inout) :: self
      type(error_type), allocatable, intent(out) :: error
      integer :: i, n

      n = self%waiting
      self%waiting = 0
      if (n == 0) return
      do i = 0, last_status
         self%counts(i) = self%counts(i) + count(self%statuses(:n) == i)
      end do
      call self%file%append(self%number, n, self%numbers, error)
      if (allocated(error)) return
      call self%file%append(self%status, n, self%statuses, error)
      if (allocated(error)) return
      call write_texts(self%file, self%message, self%messages(:n), error)
      if (allocated(error)) return
      do i = 1, size(self%columns)
         associate (column => self%columns(i))
            select case (column%kind)
            case (series_long)
               call self%file%append(column%series, n, column%longs, error)
            case (series_text)
               call write_texts(self%file, column%series, column%texts(:n), error)
            case default
               call self%file%append(column%series, n, column%reals, error)
            end select
         end associate
         if (allocated(error)) return
      end do
   end subroutine write_waiting

   !> Append texts to a series, in pieces whose padded length is bounded.
   subroutine write_texts(file, series, texts, error)
      type(hdf5_file_type), intent(inout) :: file
      type(hdf5_series_type), intent(in) :: series
      type(string_type), intent(in) :: texts(:)
      type(error_type), allocatable, intent(out) :: error
      character(len=:), allocatable :: padded(:)
      integer :: i, first, last, longest

      longest = 1
      do i = 1, size(texts)
         longest = max(longest, len(texts(i)%s))
      end do
      allocate(character(len=longest) :: padded(max(1, min(size(texts), text_bytes/longest))))
      first = 1
      do while (first <= size(texts))
         last = min(first + size(padded) - 1, size(texts))
         do i = first, last
            padded(i - first + 1) = texts(i)%s
         end do
         call file%append(series, last - first + 1, padded, error)
         if (allocated(error)) return
         first = last + 1
      end do
   end subroutine write_texts

   !> Close the table and give it its final name.
   subroutine finish(self, error)
      class(sweep_table_type), intent(inout) :: self
      type(error_type), allocatable, intent(out) :: error

      call write_waiting(self, error)
      if (.not. allocated(error)) call self%file%put_attribute("/", "status", "complete", error)
      if (.not. allocated(error)) call self%file%close_as(self%name, self%replace, error)
      if (allocated(error)) call self%abandon()
   end subroutine finish

   !> Give up and remove what there is.
   subroutine abandon(self)
      class(sweep_table_type), intent(inout) :: self
      type(error_type), allocatable :: ignored

      if (.not. allocated(self%name)) return
      call remove_file(temporary_name(self%name), ignored)
      call self%file%abandon()
   end subroutine abandon

   !> See that a table can be written, and whether it is there already; a lock that a killed process
   !> left beside a complete one goes.
   subroutine check_table(path, replace, wanted, cases, complete, error)
      character(len=*), intent(in) :: path
      !> Whether an existing file may be replaced.
      logical, intent(in) :: replace
      !> Fingerprint and settings of its sweep.
      type(table_header_type), intent(in) :: wanted
      !> Its cases, as ranges such as "1:500,800".
      character(len=*), intent(in) :: cases
      !> Whether there is a table with these cases of this sweep, which is not to be replaced.
      logical, intent(out) :: complete
      !> Set when it must not be written.
      type(error_type), allocatable, intent(out) :: error
      type(table_header_type) :: header
      character(len=:), allocatable :: wrong
      logical :: is

      complete = .false.
      call check_writable(path, "table", error)
      if (allocated(error)) return
      is = file_exists(path)
      if (.not. is .or. replace) return
      call read_table_header(path, header, error)
      if (allocated(error)) then
         wrong = " exists and is not the table of a sweep"
         if (index(error%message, "damaged") > 0) wrong = " exists and is damaged"
         error%message = path // wrong // what_helps(path) // new_line("a") // "  " // &
            error%message
         error%status = status_file
      else if (header%fingerprint /= wanted%fingerprint) then
         call fatal(error, path // " exists and is of another sweep: " // &
            sweep_difference(header, wanted) // what_helps(path), status_file)
      else if (header%cases /= cases) then
         call fatal(error, path // " exists and has other cases, " // to_text(header%n_rows) // &
            " of " // to_text(header%n_cases) // what_helps(path), status_file)
      else
         complete = .true.
         call remove_dead_lock(path)
      end if
   end subroutine check_table

   !> What tells a sweep from another one, in words.
   function sweep_difference(before, now) result(words)
      !> The sweep of a table.
      type(table_header_type), intent(in) :: before
      !> Another sweep.
      type(table_header_type), intent(in) :: now
      character(len=:), allocatable :: words

      words = ""
      if (allocated(before%resolved) .and. allocated(now%resolved)) words = settings_difference( &
         before%resolved, now%resolved)
      if (words == "" .and. allocated(before%settings) .and. allocated(now%settings)) words = &
         settings_difference(before%settings, now%settings)
      if (words == "") words = "their settings are the same, their tables of cases or the " // &
         "versions of the program are not"
   end function sweep_difference

   !> What a complete table says about itself.
   subroutine read_table_header(path, header, error)
      character(len=*), intent(in) :: path
      type(table_header_type), intent(out) :: header
      !> Set when it is not the table of a sweep, or cannot be read.
      type(error_type), allocatable, intent(out) :: error
      type(table_reader_type) :: reader

      call reader%open(path, error)
      if (allocated(error)) return
      header = reader%header
      call reader%close()
   end subroutine read_table_header

   !> Open a table for reading.
   subroutine open_reader(self, path, error)
      class(table_reader_type), intent(inout) :: self
      character(len=*), intent(in) :: path
      !> Set when it is not the complete table of a sweep, or cannot be read.
      type(error_type), allocatable, intent(out) :: error
      type(hdf5_item_type) :: closed
      character(len=:), allocatable :: text
      type(error_type), allocatable :: absent

      self%path = path
      self%n_parameters = 0
      ! What a copy of another reader brings with it is not its own.
      if (allocated(self%columns)) deallocate(self%columns)
      self%number = closed
      self%status = closed
      self%message = closed
      call probe(path, error)
      if (.not. allocated(error)) call self%reader%open(path, error)
      if (allocated(error)) return
      text = text_of("/", "filetype")
      if (allocated(error)) then
         call fatal(error, path // " is not the table of a sweep, or is damaged", status_usage)
         call self%reader%close()
         return
      else if (text /= sweep_filetype) then
         call fatal(error, path // " is not the table of a sweep", status_usage)
         call self%reader%close()
         return
      end if
      if (text_of("/", "status") /= "complete") then
         call fatal(error, path // " is not complete", status_usage)
         call self%reader%close()
         return
      end if
      text = text_of("/", "filetype_version")
      if (index(text, "1.") /= 1) then
         call fatal(error, path // " has version " // text // " of the format, this program " // &
            "reads version " // sweep_filetype_version, status_usage)
         call self%reader%close()
         return
      end if
      self%header%fingerprint = text_of("/", "fingerprint")
      self%header%cases = text_of("/", "cases")
      self%origins%title = text_of("/", "title")
      if (.not. allocated(error)) call read_count(self%header%n_cases)
      self%origins%sweep = text_of("/input/sweep", "")
      self%origins%scene = text_of("/input/scene", "")
      self%origins%resolved = text_of("/input/resolved", "")
      if (.not. allocated(error)) call self%reader%read_text("/input/settings", "", text, absent)
      if (.not. allocated(absent)) self%origins%settings = text
      self%header%resolved = self%origins%resolved
      if (allocated(self%origins%settings)) self%header%settings = self%origins%settings
      if (.not. allocated(error)) call self%reader%open_item("/case", "", self%number, error)
      if (.not. allocated(error)) call self%reader%open_item("/status", "", self%status, error)
      if (.not. allocated(error)) call self%reader%open_item("/message", "", self%message, error)
      if (.not. allocated(error)) call open_columns(self, error)
      if (.not. allocated(error)) call check_columns(self, error)
      if (allocated(error)) then
         error%message = path // " is damaged: " // error%message
         call self%close()
         return
      end if
      self%header%n_rows = self%number%extents(1)

   contains

      !> A text: an attribute, or a data set if no attribute is named.
      function text_of(object, name) result(value)
         character(len=*), intent(in) :: object
         character(len=*), intent(in) :: name
         character(len=:), allocatable :: value

         value = ""
         if (.not. allocated(error)) call self%reader%read_text(object, name, value, error)
      end function text_of

      !> The number of cases of the sweep.
      subroutine read_count(n)
         integer(i8), intent(out) :: n
         type(hdf5_item_type) :: item
         integer(i8) :: buffer(1)

         n = 0
         call self%reader%open_item("/", "case_count", item, error)
         if (allocated(error)) return
         buffer = 0
         if (item%class /= class_integer .or. product(item%extents(:item%rank)) /= 1 .or. &
            item%is_null) then
            call fatal(error, "case_count is not a number", status_file)
         else
            call item%read([0_i8], [1_i8], buffer, error)
         end if
         call item%close()
         n = buffer(1)
      end subroutine read_count

   end subroutine open_reader

   !> All columns of a table have a value for each case, of the kind that they are to have.
   subroutine check_columns(self, error)
      class(table_reader_type), intent(in) :: self
      type(error_type), allocatable, intent(out) :: error
      integer :: i
      logical :: good

      good = is_column(self%number) .and. is_column(self%status) .and. is_column(self%message)
      good = good .and. self%number%class == class_integer .and. &
         self%status%class == class_integer .and. self%message%class == class_text
      do i = 1, size(self%columns)
         good = good .and. is_column(self%columns(i)%item) .and. any(self%columns(i)%item%class == &
            [class_integer, class_real, class_text])
      end do
      if (.not. good) call fatal(error, "its columns are not equally long, or no columns", &
         status_file)

   contains

      !> Whether a data set is a column of this table.
      pure logical function is_column(item)
         type(hdf5_item_type), intent(in) :: item

         is_column = item%rank == 1 .and. .not. item%is_null .and. &
            item%extents(1) == self%number%extents(1)
      end function is_column

   end subroutine check_columns

   !> Open the columns of a table.
   subroutine open_columns(self, error)
      class(table_reader_type), intent(inout) :: self
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: groups(2) = [character(len=11) :: "/parameters", "/results"]
      type(string_type), allocatable :: names(:)
      type(column_type), allocatable :: columns(:)
      integer :: g, i, n

      if (allocated(self%columns)) deallocate(self%columns)
      allocate(self%columns(0))
      do g = 1, 2
         call list_names(self%reader, trim(groups(g)), names, error)
         if (allocated(error)) return
         n = size(self%columns)
         allocate(columns(n + size(names)))
         columns(:n) = self%columns
         do i = 1, size(names)
            associate (column => columns(n + i))
               column%name = names(i)%s
               column%path = trim(groups(g)) // "/" // names(i)%s
               call self%reader%open_item(column%path, "", column%item, error)
               if (.not. allocated(error)) call self%reader%read_text(column%path, &
                  "long_name", column%long_name, error)
               if (allocated(error)) exit
               column%units = column%item%units()
               if (column%item%class == class_integer) column%kind = series_long
               if (column%item%class == class_text) column%kind = series_text
            end associate
         end do
         call move_alloc(columns, self%columns)
         if (allocated(error)) return
         if (g == 1) self%n_parameters = size(names)
      end do
   end subroutine open_columns

   !> Names of the columns in a group, in their order.
   subroutine list_names(reader, group, names, error)
      type(hdf5_reader_type), intent(in) :: reader
      character(len=*), intent(in) :: group
      type(string_type), allocatable, intent(out) :: names(:)
      type(error_type), allocatable, intent(out) :: error
      type(hdf5_entry_type), allocatable :: attributes(:)
      type(hdf5_item_type) :: item
      integer :: i

      call reader%list(group, .true., attributes, error)
      if (allocated(error)) return
      if (.not. any([(attributes(i)%name == "columns", i=1, size(attributes))])) then
         allocate(names(0))
         return
      end if
      call reader%open_item(group, "columns", item, error)
      if (allocated(error)) return
      if (item%class /= class_text .or. item%rank /= 1 .or. item%is_null) then
         call fatal(error, "the list of its columns is no list of names", status_file)
      else
         call item%read_texts([0_i8], item%extents(:1), int(item%extents(1)), names, error)
      end if
      call item%close()
   end subroutine list_names

   !> Close a table.
   subroutine close_reader(self)
      class(table_reader_type), intent(inout) :: self
      integer :: i

      if (allocated(self%columns)) then
         do i = 1, size(self%columns)
            call self%columns(i)%item%close()
         end do
      end if
      call self%number%close()
      call self%status%close()
      call self%message%close()
      call self%reader%close()
   end subroutine close_reader

   !> Numbers of the cases in some rows.
   subroutine numbers(self, first, cases, error)
      class(table_reader_type), intent(in) :: self
      !> First row, from 1.
      integer(i8), intent(in) :: first
      !> Numbers of the cases from there on.
      integer(i8), intent(inout), contiguous :: cases(:)
      type(error_type), allocatable, intent(out) :: error

      call self%number%read([first - 1], [size(cases, kind=i8)], cases, error)
   end subroutine numbers

   !> Why rows of two tables cannot stand in one; empty if they can.
   function difference(self, other) result(why)
      class(table_reader_type), intent(in) :: self
      !> Another table.
      class(table_reader_type), intent(in) :: other
      character(len=:), allocatable :: why
      integer :: i
      logical :: same

      why = ""
      same = size(self%columns) == size(other%columns) .and. &
         self%n_parameters == other%n_parameters
      if (same) then
         do i = 1, size(self%columns)
            same = same .and. self%columns(i)%path == other%columns(i)%path .and. &
               self%columns(i)%kind == other%columns(i)%kind
         end do
      end if
      if (.not. same) then
         why = "they have other columns"
      else if (self%header%n_cases /= other%header%n_cases) then
         why = "they are of sweeps with " // to_text(self%header%n_cases) // " and " // &
            to_text(other%header%n_cases) // " cases"
      else if (self%header%fingerprint /= other%header%fingerprint) then
         why = "they are of different sweeps: " // sweep_difference(other%header, self%header)
      end if
   end function difference

end module contensou_sweep_table
