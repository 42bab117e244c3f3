!> `contensou merge`: join the tables of the shards of a sweep.
module contensou_drivers_merge
   use contensou_base_errors, only : error_type, fatal, status_failed, status_file, status_usage
   use contensou_base_kinds, only : i8
   use contensou_base_operating_system, only : file_exists, folder_writable, is_folder, &
      list_folder, write_stderr, write_stdout
   use contensou_base_text, only : shorten, starts_with, string_type, to_text
   use contensou_drivers_command_line, only : command_line_type, command_text, command_type, &
      option_type, quiet_option
   use contensou_sweep_plan, only : sweep_type
   use contensou_sweep_reader, only : is_sweep_file, read_sweep
   use contensou_sweep_table, only : last_status, read_table_header, status_names, &
      sweep_table_type, table_header_type, table_reader_type
   implicit none(type, external)
   private

   public :: merge_command

   !> What `contensou merge` takes.
   type(option_type), parameter :: options(*) = [ &
      option_type("FILE", "", "tables of shards, or a sweep file, which means all of its shards", &
      needs="a file", repeats=.true.), &
      option_type("--output", "TABLE", "table; that of the sweep file if not given", "-o", &
      "the name of a file"), &
      option_type("--force", "", "replace an existing table"), &
      option_type("--partial", "", "also if cases are missing"), &
      quiet_option, &
      option_type("--set", "PATH=VALUE", "as it was given to sweep, with a sweep file", &
      repeats=.true.)]

   !> What the user asks for, in the words of the options.
   type :: merge_config_type
      type(string_type), allocatable :: files(:), overrides(:)
      character(len=:), allocatable :: output
      logical :: force = .false., partial = .false., quiet = .false.
   end type merge_config_type

   !> Neighbouring cases in neighbouring rows of a table.
   type :: segment_type
      !> Which table.
      integer :: file = 0
      !> First case.
      integer(i8) :: first = 0
      !> Last case.
      integer(i8) :: last = 0
      !> Row of the first one, from 1.
      integer(i8) :: row = 0
   end type segment_type

   character(len=*), parameter :: digits = "0123456789"

   !> Bytes of a list of cases that a message shows.
   integer, parameter :: longest_list = 100000

   !> End of a line.
   character(len=*), parameter :: nl = new_line("a")

contains

   !> `contensou merge` in the table of commands.
   function merge_command() result(command)
      type(command_type) :: command

      command = command_type("merge", "join the tables of parts of a sweep", options, &
         execute=merge_tables)
   end function merge_command

   !> Join the tables of shards into one.
   subroutine merge_tables(line, error)
      type(command_line_type), intent(in) :: line
      !> Set when cases are missing or a file is in the way.
      type(error_type), allocatable, intent(out) :: error
      type(string_type), allocatable :: files(:)
      type(segment_type), allocatable :: segments(:), plan(:)
      type(table_header_type) :: header
      type(sweep_type) :: sweep
      character(len=:), allocatable :: output, fingerprint, name, present_cases, missing_cases
      integer(i8) :: missing
      type(merge_config_type) :: config
      logical :: of_sweep, done

      config%files = line%texts("FILE")
      config%overrides = line%texts("--set")
      config%output = line%text("--output")
      config%force = line%has("--force")
      config%partial = line%has("--partial")
      config%quiet = line%has("--quiet")
      output = config%output
      fingerprint = ""
      name = "SWEEP"
      of_sweep = .false.
      if (size(config%files) == 1) of_sweep = is_sweep_file(config%files(1)%s)
      if (of_sweep) name = config%files(1)%s
      if (of_sweep) then
         call read_sweep(config%files(1)%s, config%overrides, config%output, sweep, error)
         if (allocated(error)) return
         output = sweep%output
         fingerprint = sweep%fingerprint
         header%n_cases = sweep%n_cases
      else
         if (size(config%overrides) > 0) then
            call fatal(error, "--set goes with a sweep file, not with tables", status_usage)
         else if (output == "") then
            call fatal(error, "merge needs -o TABLE", status_usage)
         end if
         if (allocated(error)) return
         files = config%files
      end if
      if (of_sweep) then
         call check_output(output, config%force, fingerprint, done, error)
         if (allocated(error) .or. done) return
         call find_shards(output, files)
         if (size(files) == 0) then
            call read_sweep(config%files(1)%s, config%overrides, "", sweep, error)
            if (allocated(error)) return
            call find_shards(sweep%output, files)
         end if
      end if
      call read_headers(files, fingerprint, of_sweep, header, segments, error)
      if (allocated(error)) return
      if (.not. of_sweep) then
         call check_output(output, config%force, header%fingerprint, done, error)
         if (allocated(error) .or. done) return
      end if
      call make_plan(segments, header%n_cases, plan, present_cases, missing_cases, missing)
      if (missing > 0 .and. .not. (config%partial .and. size(plan) > 0)) then
         call fatal(error, to_text(missing) // " of " // to_text(header%n_cases) // &
            " cases are missing" // nl // "  contensou sweep " // name // " --cases " // &
            shorten(missing_cases, longest_list) // nl // "runs them; --partial joins what " // &
            "there is", status_failed)
         return
      end if
      call join_tables(config, line%words, files, plan, output, present_cases, error)
      if (allocated(error)) return
      if (missing > 0) call fatal(error, to_text(missing) // " of " // to_text(header%n_cases) // &
         " cases are missing in " // output // nl // "  contensou sweep " // name // &
         " --cases " // shorten(missing_cases, longest_list) // nl // "runs them", status_failed)
   end subroutine merge_tables

   !> See that the table can be written, and whether it is there already.
   subroutine check_output(output, force, fingerprint, done, error)
      !> Name of the table.
      character(len=*), intent(in) :: output
      !> Whether it may replace an existing file.
      logical, intent(in) :: force
      !> What tells its sweep from others.
      character(len=*), intent(in) :: fingerprint
      !> Whether the table is there and has all cases.
      logical, intent(out) :: done
      !> Set when it cannot be written.
      type(error_type), allocatable, intent(out) :: error
      type(table_header_type) :: header
      logical :: is

      done = .false.
      is = is_folder(output)
      if (is) then
         call fatal(error, "the table " // output // " is a folder", status_file)
         return
      end if
      is = folder_writable(output)
      if (.not. is) then
         call fatal(error, "cannot write " // output // ": its folder does not exist or is not " &
            // "writable", status_file)
         return
      end if
      is = file_exists(output)
      if (.not. is .or. force) return
      call read_table_header(output, header, error)
      if (allocated(error)) then
         call fatal(error, output // " exists and is not the table of a sweep; --force " // &
            "replaces it, -o FILE writes another one", status_file)
      else if (header%fingerprint /= fingerprint) then
         call fatal(error, output // " exists and is of another sweep; --force replaces it, " // &
            "-o FILE writes another one", status_file)
      else if (header%n_rows < header%n_cases) then
         call fatal(error, output // " exists and has " // to_text(header%n_rows) // " of " // &
            to_text(header%n_cases) // " cases; --force replaces it", status_file)
      else
         done = .true.
         call write_stdout(output // " is complete, " // to_text(header%n_rows) // " cases" // nl, &
            error)
      end if
   end subroutine check_output

   !> Find the tables of the shards of a sweep.
   subroutine find_shards(output, files)
      !> Name of the table of the whole sweep.
      character(len=*), intent(in) :: output
      !> Names of what is found.
      type(string_type), allocatable, intent(out) :: files(:)
      type(string_type), allocatable :: names(:)
      character(len=:), allocatable :: folder, stem, suffix
      integer :: slash, dot, i, n
      logical, allocatable :: wanted(:)

      slash = index(output, "/", back=.true.)
      dot = index(output, ".", back=.true.)
      if (dot <= slash + 1) dot = len(output) + 1
      folder = output(:slash)
      stem = output(slash + 1:dot - 1)
      suffix = output(dot:)
      if (folder == "") then
         call list_folder(".", names)
      else
         call list_folder(folder, names)
      end if
      allocate(wanted(size(names)))
      do i = 1, size(names)
         associate (name => names(i)%s)
            wanted(i) = starts_with(name, stem // "_") .and. len(name) > len(stem) + len(suffix)
            if (wanted(i)) wanted(i) = name(len(name) - len(suffix) + 1:) == suffix
            if (wanted(i)) wanted(i) = is_part(name(len(stem) + 1:len(name) - len(suffix)))
         end associate
      end do
      allocate(files(count(wanted)))
      n = 0
      do i = 1, size(names)
         if (.not. wanted(i)) cycle
         n = n + 1
         files(n)%s = folder // names(i)%s
      end do
   end subroutine find_shards

   !> Whether a text is what the name of a part has after that of the whole: `_shard_1_of_4`,
   !> `_cases_1_to_9`, or both.
   function is_part(text)
      character(len=*), intent(in) :: text
      logical :: is_part
      character(len=:), allocatable :: rest

      rest = text
      if (starts_with(rest, "_cases_")) call take("_cases_", "_to_")
      if (starts_with(rest, "_shard_")) call take("_shard_", "_of_")
      is_part = rest == "" .and. text /= ""

   contains

      !> Take a word, a number, another word and another number away.
      subroutine take(before, between)
         !> First word.
         character(len=*), intent(in) :: before
         !> Second word.
         character(len=*), intent(in) :: between
         integer :: n

         rest = rest(len(before) + 1:)
         n = verify(rest // "_", digits) - 1
         if (n < 1) return
         rest = rest(n + 1:)
         if (.not. starts_with(rest, between)) return
         rest = rest(len(between) + 1:)
         n = verify(rest // "_", digits) - 1
         if (n < 1) rest = "?"
         rest = rest(n + 1:)
      end subroutine take

   end function is_part

   !> Read what the tables say about themselves.
   subroutine read_headers(files, fingerprint, of_sweep, header, segments, error)
      !> Their names.
      type(string_type), intent(in) :: files(:)
      !> Fingerprint that they must have; empty for that of the first one.
      character(len=*), intent(in) :: fingerprint
      !> Whether they were looked for, and are not named by the user.
      logical, intent(in) :: of_sweep
      !> What they share.
      type(table_header_type), intent(inout) :: header
      !> The cases in them.
      type(segment_type), allocatable, intent(out) :: segments(:)
      !> Set when they do not belong together.
      type(error_type), allocatable, intent(out) :: error
      type(table_reader_type) :: first, reader
      type(segment_type), allocatable :: more(:), longer(:)
      character(len=:), allocatable :: why
      integer :: i

      allocate(segments(0))
      do i = 1, size(files)
         if (i == 1) then
            call first%open(files(1)%s, error)
            if (allocated(error)) return
            reader = first
            header%n_cases = first%header%n_cases
            header%fingerprint = first%header%fingerprint
            why = ""
         else
            call reader%open(files(i)%s, error)
            if (allocated(error)) exit
            why = reader%difference(first)
         end if
         if (fingerprint /= "" .and. reader%header%fingerprint /= fingerprint) then
            call fatal(error, files(i)%s // " is of another sweep, or of this one before it " // &
               "was changed; " // trim(merge("remove it, or name the tables to join", &
               "                                     ", of_sweep)), status_usage)
         else if (why /= "") then
            call fatal(error, files(1)%s // " and " // files(i)%s // " cannot be joined: " // why, &
               status_usage)
         else
            call cut_ranges(reader%header%cases, i, reader%header%n_rows, more, error)
            if (allocated(error)) error%message = files(i)%s // " is damaged: " // error%message
         end if
         if (i > 1) call reader%close()
         if (allocated(error)) exit
         allocate(longer(size(segments) + size(more)))
         longer(:size(segments)) = segments
         longer(size(segments) + 1:) = more
         call move_alloc(longer, segments)
      end do
      if (size(files) > 0) call first%close()
   end subroutine read_headers

   !> The cases of a table.
   subroutine cut_ranges(text, file, n_rows, segments, error)
      !> Ranges such as "1:500,800".
      character(len=*), intent(in) :: text
      !> Number of the table.
      integer, intent(in) :: file
      integer(i8), intent(in) :: n_rows
      !> The cases.
      type(segment_type), allocatable, intent(out) :: segments(:)
      !> Set when there are more or fewer cases than rows.
      type(error_type), allocatable, intent(out) :: error
      integer(i8) :: row
      integer :: i, n, start, length, colon, stat

      n = count([(text(i:i) == ",", i=1, len(text))]) + 1
      allocate(segments(n))
      start = 1
      row = 1
      stat = 1
      do i = 1, n
         length = index(text(start:) // ",", ",") - 1
         associate (word => text(start:start + length - 1), segment => segments(i))
            if (verify(word, digits // ":") > 0 .or. length == 0) exit
            colon = index(word // ":", ":")
            read(word(:colon - 1), *, iostat=stat) segment%first
            if (stat /= 0) exit
            segment%last = segment%first
            if (colon < length) read(word(colon + 1:), *, iostat=stat) segment%last
            if (stat /= 0) exit
            segment%file = file
            segment%row = row
            row = row + segment%last - segment%first + 1
         end associate
         start = start + length + 1
      end do
      if (stat /= 0 .or. row /= n_rows + 1) call fatal(error, "it has " // to_text(n_rows) // &
         " rows for the cases " // shorten(text, 60), status_usage)
   end subroutine cut_ranges

   !> Which rows of which tables stand one after the other, each case once.
   subroutine make_plan(segments, n_cases, plan, present_cases, missing_cases, missing)
      !> The cases of all tables.
      type(segment_type), intent(inout) :: segments(:)
      !> Number of cases of the sweep.
      integer(i8), intent(in) :: n_cases
      !> The rows in the order of their cases.
      type(segment_type), allocatable, intent(out) :: plan(:)
      !> The cases that are there, as ranges.
      character(len=:), allocatable, intent(out) :: present_cases
      !> The cases that are not.
      character(len=:), allocatable, intent(out) :: missing_cases
      !> How many are not.
      integer(i8), intent(out) :: missing
      type(segment_type), allocatable :: longer(:)
      integer(i8) :: next, begin
      integer :: i, n

      call sort(segments)
      allocate(plan(max(1, size(segments))))
      present_cases = ""
      missing_cases = ""
      missing = 0
      n = 0
      next = 1
      begin = 1
      do i = 1, size(segments)
         associate (segment => segments(i))
            if (segment%last < next) cycle
            if (segment%first > next) then
               if (next > begin) call add(present_cases, begin, next - 1)
               call add(missing_cases, next, segment%first - 1)
               missing = missing + segment%first - next
               next = segment%first
               begin = next
            end if
            n = n + 1
            plan(n) = segment
            plan(n)%row = segment%row + next - segment%first
            plan(n)%first = next
            next = segment%last + 1
         end associate
      end do
      if (next > begin) call add(present_cases, begin, next - 1)
      if (next <= n_cases) then
         call add(missing_cases, next, n_cases)
         missing = missing + n_cases - next + 1
      end if
      allocate(longer(n))
      longer = plan(:n)
      call move_alloc(longer, plan)

   contains

      !> Add a range to a list.
      pure subroutine add(list, a, b)
         character(len=:), allocatable, intent(inout) :: list
         !> First case.
         integer(i8), intent(in) :: a
         !> Last case.
         integer(i8), intent(in) :: b

         if (list /= "") list = list // ","
         list = list // to_text(a)
         if (b > a) list = list // ":" // to_text(b)
      end subroutine add

   end subroutine make_plan

   !> Put segments in the order of their first cases.
   recursive subroutine sort(segments)
      type(segment_type), intent(inout) :: segments(:)
      type(segment_type) :: sorted(size(segments))
      integer :: half, i, j, k

      if (size(segments) < 2) return
      half = size(segments)/2
      call sort(segments(:half))
      call sort(segments(half + 1:))
      i = 1
      j = half + 1
      do k = 1, size(segments)
         if (j > size(segments)) then
            sorted(k) = segments(i)
            i = i + 1
         else if (i > half) then
            sorted(k) = segments(j)
            j = j + 1
         else if (segments(i)%first <= segments(j)%first) then
            sorted(k) = segments(i)
            i = i + 1
         else
            sorted(k) = segments(j)
            j = j + 1
         end if
      end do
      segments = sorted
   end subroutine sort

   !> Write the table.
   subroutine join_tables(config, words, files, plan, output, cases, error)
      type(merge_config_type), intent(in) :: config
      !> Words of the command line.
      type(string_type), intent(in) :: words(:)
      !> Names of the tables.
      type(string_type), intent(in) :: files(:)
      !> Which rows stand one after the other.
      type(segment_type), intent(in) :: plan(:)
      !> Name of the table.
      character(len=*), intent(in) :: output
      !> Its cases, as ranges.
      character(len=*), intent(in) :: cases
      !> Set when a file cannot be read or written.
      type(error_type), allocatable, intent(out) :: error
      type(table_reader_type) :: reader
      type(sweep_table_type) :: table
      character(len=:), allocatable :: text
      integer :: i, opened

      opened = 0
      do i = 1, size(plan)
         if (plan(i)%file /= opened) then
            if (opened > 0) call reader%close()
            opened = 0
            call reader%open(files(plan(i)%file)%s, error)
            if (allocated(error)) exit
            opened = plan(i)%file
         end if
         if (i == 1) call table%open_like(output, config%force, reader, cases, &
            command_text(words), error)
         if (.not. allocated(error)) call table%append_from(reader, plan(i)%row, plan(i)%row + &
            plan(i)%last - plan(i)%first, error)
         if (allocated(error)) exit
         if (.not. config%quiet .and. mod(i, 100) == 0) call write_stderr("contensou: " // &
            to_text(i) // " of " // to_text(size(plan)) // " pieces" // nl)
      end do
      if (opened > 0) call reader%close()
      if (allocated(error)) then
         call table%abandon()
         return
      end if
      call table%finish(error)
      if (allocated(error)) return
      text = "joined " // to_text(size(files)) // trim(merge(" table ", " tables", &
         size(files) == 1)) // nl // "  cases      " // to_text(sum(table%counts)) // ":"
      do i = 0, last_status
         if (table%counts(i) == 0) cycle
         if (text(len(text):) /= ":") text = text // ","
         text = text // " " // to_text(table%counts(i)) // " " // trim(status_names(i))
      end do
      call write_stdout(text // nl // "  table      " // output // nl, error)
   end subroutine join_tables

end module contensou_drivers_merge
