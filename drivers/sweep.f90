!> `contensou sweep`: run the cases of a sweep, or a part of them, into one table.
!>
!> Rows go into a journal, FILE.part, as cases end, in any order; when there is one for each case
!> the table is made from it. Whatever ends the program, the next one goes on from the journal.
module contensou_drivers_sweep
   use contensou_base_crew, only : available_cores, hold_signals, job_type, piece_done, &
      piece_stopped, run_crew, stop_requested
   use contensou_base_errors, only : error_type, fatal, status_failed, status_file, &
      status_interrupted, status_usage
   use contensou_base_journal, only : journal_message_length, journal_type
   use contensou_base_kinds, only : i8, wp
   use contensou_base_system, only : cpu_seconds, file_exists, folder_writable, is_folder, &
      is_locked, is_terminal, remove_file, terminal_width, wall_seconds, write_stderr, write_stdout
   use contensou_base_text, only : quote, string_type, to_text
   use contensou_drivers_command_line, only : command_text, command_type
   use contensou_drivers_report, only : number_text
   use contensou_drivers_resume, only : earlier_type, forget
   use contensou_drivers_run, only : run_scene
   use contensou_drivers_sweep_case, only : outline_of, outline_type, run_case
   use, intrinsic :: ieee_arithmetic, only : ieee_quiet_nan, ieee_value
   use contensou_io_scene_reader, only : read_scene, scene_file_type
   use contensou_io_sweep, only : sweep_type
   use contensou_io_sweep_reader, only : read_sweep
   use contensou_io_sweep_table, only : case_complete, case_crashed, case_failed, case_too_long, &
      read_table_header, status_names, sweep_table_type, table_header_type
   use contensou_io_trajectory, only : part_suffix
   implicit none(type, external)
   private

   public :: sweep_command, selection_type, select_cases

   !> Rows that go into the table at a time.
   integer, parameter :: rows_at_a_time = 4096

   !> Most threads.
   integer, parameter :: most_threads = 1024

   !> Wall time that a case may take whose trajectory is written, over its time limit.
   real(wp), parameter :: writing_allowance = 10.0_wp

   !> Value of errno for what the system says nothing more about.
   integer, parameter :: input_output_error = 5

   !> End of a line.
   character(len=*), parameter :: nl = new_line("a")

   !> Some of the cases of a sweep, as ranges in ascending order.
   type :: selection_type
      !> First and last case of each range, (2, ranges).
      integer(i8), allocatable :: ranges(:, :)
   contains
      !> How many cases there are.
      procedure :: count => count_cases
      !> Number of the case at a position.
      procedure :: case_at
      !> Position of a case; 0 if it is not there.
      procedure :: position_of
      !> The ranges as a text such as "1:500,800".
      procedure :: text => selection_text
   end type selection_type

   !> Progress on stderr.
   type :: progress_type
      !> Whether it is shown.
      logical :: show = .true.
      !> Whether stderr is a terminal.
      logical :: terminal = .false.
      !> Cases in all.
      integer(i8) :: total = 0
      !> Cases that were done before.
      integer(i8) :: before = 0
      !> Tenths that were told.
      integer :: tenths = 0
      !> Wall time at the beginning and of the last change of the bar [s].
      real(wp) :: start = 0.0_wp, last = 0.0_wp
   end type progress_type

   !> The cases as pieces of work for a crew.
   type, extends(job_type) :: cases_type
      !> The sweep.
      type(sweep_type), pointer :: sweep => null()
      !> Its cases.
      type(selection_type) :: selection
      !> Where its columns come from.
      type(outline_type) :: outline
      !> Where rows go.
      type(journal_type) :: journal
      !> Progress.
      type(progress_type) :: progress
   contains
      procedure :: work => work_case
      procedure :: done => done_case
      procedure :: lost => lost_case
      procedure :: look => look_cases
   end type cases_type

   !> Trajectories as pieces of work for a crew.
   type, extends(job_type) :: trajectories_type
      !> The sweep.
      type(sweep_type), pointer :: sweep => null()
      !> The cases.
      integer(i8), allocatable :: numbers(:)
      !> Names of their files.
      type(string_type), allocatable :: files(:)
   contains
      procedure :: work => work_trajectory
      procedure :: done => done_trajectory
      procedure :: lost => lost_trajectory
      procedure :: look => look_trajectories
   end type trajectories_type

   !> What the cases come to.
   type :: tally_type
      !> Cases by status.
      integer(i8) :: counts(0:size(status_names) - 1) = 0
      !> First case of each status; 0 for none.
      integer(i8) :: first(0:size(status_names) - 1) = 0
      !> Its message.
      type(string_type) :: message(0:size(status_names) - 1)
   end type tally_type

contains

   !> Run a sweep.
   subroutine sweep_command(command, words, error)
      !> What the user asks for.
      type(command_type), intent(in) :: command
      !> Words of the command line.
      type(string_type), intent(in) :: words(:)
      !> Set when it did not come to its end.
      type(error_type), allocatable, intent(out) :: error
      type(sweep_type), target :: sweep
      type(cases_type), target :: cases
      type(trajectories_type) :: trajectories
      type(tally_type) :: tally
      character(len=:), allocatable :: name
      real(wp) :: wall
      integer(i8) :: left
      integer :: threads
      logical :: complete, again, stopped

      call hold_signals()
      wall = wall_seconds()
      call read_sweep(command%subject, command%overrides, command%output, sweep, error)
      if (allocated(error)) return
      call select_cases(command, sweep, cases%selection, error)
      if (allocated(error)) return
      name = table_name(command, sweep, cases%selection)
      call check_table(name, sweep, cases%selection, command, complete, error)
      if (allocated(error) .or. complete) return
      again = file_exists(name // part_suffix)
      call list_trajectories(sweep, cases%selection, again .or. command%force, command%force, &
         trajectories, error)
      if (allocated(error)) return
      cases%sweep => sweep
      cases%outline = outline_of(sweep)
      call cases%journal%open(name // part_suffix, sweep%fingerprint // " " // &
         cases%selection%text(), cases%selection%count(), size(sweep%results), command%force, &
         again, error)
      if (allocated(error)) return
      threads = thread_count(command)
      call begin_progress(cases, again, command%quiet, threads, left)
      stopped = .false.
      if (left > 0) then
         call run_crew(cases, cases%selection%count(), int(min(int(threads, i8), left)), &
            sweep%time_limit, stopped, error)
      end if
      call clear_bar(cases%progress)
      if (allocated(error)) then
         if (error%status == status_file) error%message = "cannot write " // name // &
            part_suffix // ": " // error%message
      end if
      if (.not. allocated(error) .and. .not. stopped) then
         call write_trajectories(trajectories, cases, stopped, error)
      end if
      if (.not. allocated(error) .and. .not. stopped) then
         call write_table(name, cases, command, words, tally, stopped, error)
      end if
      if (stopped .and. .not. allocated(error)) call stop_here(name, cases, error)
      call cases%journal%close()
      if (allocated(error)) return
      call remove_file(name // part_suffix, error)
      if (allocated(error)) return
      call print_summary(name, sweep, tally, trajectories, threads, wall_seconds() - wall, error)
   end subroutine sweep_command

   !> Number of threads: as asked for, as the environment says, or one per core.
   function thread_count(command) result(threads)
      !> What the user asks for.
      type(command_type), intent(in) :: command
      integer :: threads

      threads = command%jobs
      if (threads < 1) threads = from_environment("OMP_NUM_THREADS")
      if (threads < 1) threads = from_environment("SLURM_CPUS_PER_TASK")
      if (threads < 1) threads = int(available_cores())
      threads = min(threads, most_threads)

   contains

      !> A positive number from the environment, the first of a list; 0 without one.
      function from_environment(variable) result(number)
         !> Name of the variable.
         character(len=*), intent(in) :: variable
         integer :: number
         character(len=64) :: value
         integer :: length, code, last

         number = 0
         call get_environment_variable(variable, value, length, code)
         if (code /= 0 .or. length < 1) return
         value = adjustl(value)
         last = verify(value, "0123456789") - 1
         if (last < 1 .or. last > 6) return
         if (scan(value(last + 1:last + 1), " ,") /= 1) return
         read(value(:last), *) number
      end function from_environment

   end function thread_count

   !> The cases that are asked for.
   subroutine select_cases(command, sweep, selection, error)
      !> What the user asks for.
      type(command_type), intent(in) :: command
      !> The sweep.
      type(sweep_type), intent(in) :: sweep
      !> Its cases.
      type(selection_type), intent(out) :: selection
      !> Set when there are none, or the ranges are wrong.
      type(error_type), allocatable, intent(out) :: error
      type(selection_type) :: all_of_them

      if (command%cases == "") then
         allocate(all_of_them%ranges(2, 1))
         all_of_them%ranges(:, 1) = [1_i8, sweep%n_cases]
      else
         call parse_ranges(command%cases, sweep%n_cases, all_of_them, error)
         if (allocated(error)) return
      end if
      if (command%shards == 0) then
         selection = all_of_them
         return
      end if
      associate (n => all_of_them%count(), k => int(command%shard, i8), m => command%shards)
         if (m > n) then
            call fatal(error, "there are " // to_text(n) // " cases for " // to_text(m) // &
               " shards", status_usage)
            return
         end if
         call cut(all_of_them, first_of(n, k - 1, m) + 1, first_of(n, k, m), selection)
      end associate

   contains

      !> Cases before the shard after the k-th one, without overflow.
      pure function first_of(n, k, m) result(before)
         !> Number of cases.
         integer(i8), intent(in) :: n
         !> Shards before.
         integer(i8), intent(in) :: k
         !> Number of shards.
         integer, intent(in) :: m
         integer(i8) :: before

         before = (n/m)*k + min(k, mod(n, int(m, i8)))
      end function first_of

   end subroutine select_cases

   !> Understand ranges such as "1:500,800".
   subroutine parse_ranges(text, n, selection, error)
      !> The text.
      character(len=*), intent(in) :: text
      !> Number of cases.
      integer(i8), intent(in) :: n
      !> The cases.
      type(selection_type), intent(out) :: selection
      !> Set when it cannot be understood.
      type(error_type), allocatable, intent(out) :: error
      integer(i8), allocatable :: ranges(:, :)
      integer(i8) :: bounds(2)
      integer :: start, comma, colon, count, i, j

      count = 1
      do i = 1, len(text)
         if (text(i:i) == ",") count = count + 1
      end do
      allocate(ranges(2, count))
      start = 1
      do i = 1, count
         comma = index(text(start:) // ",", ",") - 1
         associate (word => text(start:start + comma - 1))
            colon = index(word, ":")
            if (colon == 0) then
               bounds(1) = number(word)
               bounds(2) = bounds(1)
            else
               bounds(1) = number(word(:colon - 1))
               bounds(2) = number(word(colon + 1:))
            end if
            if (bounds(1) < 1 .or. bounds(2) < bounds(1) .or. bounds(2) > n) then
               call fatal(error, "--cases needs ranges such as 1:500,800 of cases from 1 to " // &
                  to_text(n) // ", not " // quote(word), status_usage)
               return
            end if
         end associate
         ranges(:, i) = bounds
         start = start + comma + 1
      end do
      ! In ascending order, joined where they touch.
      do i = 2, count
         bounds = ranges(:, i)
         j = i - 1
         do while (j >= 1)
            if (ranges(1, j) <= bounds(1)) exit
            ranges(:, j + 1) = ranges(:, j)
            j = j - 1
         end do
         ranges(:, j + 1) = bounds
      end do
      j = 1
      do i = 2, count
         if (ranges(1, i) <= ranges(2, j) + 1) then
            ranges(2, j) = max(ranges(2, j), ranges(2, i))
         else
            j = j + 1
            ranges(:, j) = ranges(:, i)
         end if
      end do
      allocate(selection%ranges(2, j))
      selection%ranges = ranges(:, :j)

   contains

      !> A number of a case; -1 if it is none.
      function number(digits) result(value)
         !> Its text.
         character(len=*), intent(in) :: digits
         integer(i8) :: value
         integer :: code

         value = -1
         if (len(digits) == 0 .or. len(digits) > 18) return
         if (verify(digits, "0123456789") > 0) return
         read(digits, *, iostat=code) value
         if (code /= 0) value = -1
      end function number

   end subroutine parse_ranges

   !> The cases between two positions of a selection.
   subroutine cut(whole, first, last, part)
      !> The selection.
      type(selection_type), intent(in) :: whole
      !> First position.
      integer(i8), intent(in) :: first
      !> Last position.
      integer(i8), intent(in) :: last
      !> What is between.
      type(selection_type), intent(out) :: part
      integer(i8) :: before, low, high, ranges(2, size(whole%ranges, 2))
      integer :: i, n

      before = 0
      n = 0
      do i = 1, size(whole%ranges, 2)
         associate (r => whole%ranges(:, i))
            low = max(r(1), r(1) + first - 1 - before)
            high = min(r(2), r(1) + last - 1 - before)
            before = before + r(2) - r(1) + 1
            if (low > high) cycle
            n = n + 1
            ranges(:, n) = [low, high]
         end associate
      end do
      allocate(part%ranges(2, n))
      part%ranges = ranges(:, :n)
   end subroutine cut

   !> How many cases a selection has.
   pure function count_cases(self) result(count)
      !> The selection.
      class(selection_type), intent(in) :: self
      integer(i8) :: count

      count = sum(self%ranges(2, :) - self%ranges(1, :) + 1)
   end function count_cases

   !> Number of the case at a position.
   pure function case_at(self, position) result(number)
      !> The selection.
      class(selection_type), intent(in) :: self
      !> Position, from 1.
      integer(i8), intent(in) :: position
      integer(i8) :: number
      integer(i8) :: left, length
      integer :: i

      left = position
      number = 0
      do i = 1, size(self%ranges, 2)
         length = self%ranges(2, i) - self%ranges(1, i) + 1
         if (left <= length) then
            number = self%ranges(1, i) + left - 1
            return
         end if
         left = left - length
      end do
   end function case_at

   !> Position of a case; 0 if it is not there.
   pure function position_of(self, number) result(position)
      !> The selection.
      class(selection_type), intent(in) :: self
      !> Number of the case.
      integer(i8), intent(in) :: number
      integer(i8) :: position
      integer(i8) :: before
      integer :: i

      position = 0
      before = 0
      do i = 1, size(self%ranges, 2)
         associate (first => self%ranges(1, i), last => self%ranges(2, i))
            if (number >= first .and. number <= last) position = before + number - first + 1
            before = before + last - first + 1
         end associate
      end do
   end function position_of

   !> The ranges as a text such as "1:500,800".
   pure function selection_text(self) result(text)
      !> The selection.
      class(selection_type), intent(in) :: self
      character(len=:), allocatable :: text
      integer :: i

      text = ""
      do i = 1, size(self%ranges, 2)
         if (i > 1) text = text // ","
         text = text // to_text(self%ranges(1, i))
         if (self%ranges(2, i) > self%ranges(1, i)) text = text // ":" // &
            to_text(self%ranges(2, i))
      end do
   end function selection_text

   !> A file name with some words before its suffix.
   pure function named(name, infix) result(text)
      !> The name.
      character(len=*), intent(in) :: name
      !> The words.
      character(len=*), intent(in) :: infix
      character(len=:), allocatable :: text
      integer :: dot

      dot = index(name, ".", back=.true.)
      if (dot <= index(name, "/", back=.true.) + 1) dot = len(name) + 1
      text = name(:dot - 1) // infix // name(dot:)
   end function named

   !> Name of the table.
   function table_name(command, sweep, selection) result(name)
      !> What the user asks for.
      type(command_type), intent(in) :: command
      !> The sweep.
      type(sweep_type), intent(in) :: sweep
      !> The cases.
      type(selection_type), intent(in) :: selection
      character(len=:), allocatable :: name
      integer(i8) :: last

      name = sweep%output
      if (command%cases /= "" .and. command%output == "") then
         last = selection%ranges(2, size(selection%ranges, 2))
         name = named(name, "_cases_" // to_text(selection%ranges(1, 1)) // "_to_" // &
            to_text(last))
      end if
      if (command%shards > 0) name = named(name, "_shard_" // to_text(command%shard) // "_of_" // &
         to_text(command%shards))
   end function table_name

   !> See that the table can be written, and whether it is there already.
   subroutine check_table(name, sweep, selection, command, complete, error)
      !> Name of the table.
      character(len=*), intent(in) :: name
      !> The sweep.
      type(sweep_type), intent(in) :: sweep
      !> The cases.
      type(selection_type), intent(in) :: selection
      !> What the user asks for.
      type(command_type), intent(in) :: command
      !> Whether the table is complete.
      logical, intent(out) :: complete
      !> Set when the sweep must not begin.
      type(error_type), allocatable, intent(out) :: error
      type(table_header_type) :: header
      logical :: is

      complete = .false.
      is = is_folder(name)
      if (is) then
         call fatal(error, "the table " // name // " is a folder", status_file)
         return
      end if
      is = folder_writable(name)
      if (.not. is) then
         call fatal(error, "cannot write " // name // ": its folder does not exist or is not " // &
            "writable", status_file)
         return
      end if
      is = file_exists(name)
      if (.not. is .or. command%force) return
      call read_table_header(name, header, error)
      if (allocated(error)) then
         error%message = name // " exists and is not a table of this sweep; --force replaces " // &
            "it, -o FILE writes another one" // nl // "  " // error%message
         error%status = status_file
      else if (header%fingerprint /= sweep%fingerprint .or. header%cases /= selection%text()) then
         call fatal(error, name // " exists and is of another sweep or other cases; --force " // &
            "replaces it, -o FILE writes another one", status_file)
      else
         complete = .true.
         ! Left by a program that was killed at its very end.
         is = file_exists(name // part_suffix)
         if (is) is = .not. is_locked(name // part_suffix)
         if (is) call remove_file(name // part_suffix, error)
         if (.not. allocated(error)) call write_stdout(name // " is complete, " // &
            to_text(header%n_rows) // " cases" // nl, error)
      end if
   end subroutine check_table

   !> What was done before, and the first words.
   subroutine begin_progress(cases, again, quiet, threads, left)
      !> The cases.
      type(cases_type), intent(inout) :: cases
      !> Whether the journal was there.
      logical, intent(in) :: again
      !> Whether to be silent.
      logical, intent(in) :: quiet
      !> Number of threads.
      integer, intent(in) :: threads
      !> Cases to do.
      integer(i8), intent(out) :: left
      integer(i8) :: i

      associate (p => cases%progress)
         p%show = .not. quiet
         p%terminal = is_terminal(2)
         p%total = cases%selection%count()
         if (again) then
            do i = 1, p%total
               if (cases%journal%has(i)) p%before = p%before + 1
            end do
         end if
         left = p%total - p%before
         p%tenths = int(10*p%before/p%total)
         p%start = wall_seconds()
         p%last = p%start
         if (.not. p%show) return
         if (again) then
            call write_stderr("contensou: going on with " // to_text(left) // " of " // &
               to_text(p%total) // " cases on " // threads_text(threads) // nl)
         else
            call write_stderr("contensou: " // to_text(p%total) // " cases on " // &
               threads_text(threads) // nl)
         end if
      end associate
   end subroutine begin_progress

   !> A number of threads in words.
   pure function threads_text(threads) result(text)
      !> The number.
      integer, intent(in) :: threads
      character(len=:), allocatable :: text

      text = to_text(threads) // " threads"
      if (threads == 1) text = "1 thread"
   end function threads_text

   !> Run a case in a thread of the worker.
   subroutine work_case(self, thread, piece, code)
      !> The cases.
      class(cases_type), intent(in) :: self
      !> Number of the thread.
      integer, intent(in) :: thread
      !> Position of the case.
      integer(i8), intent(in) :: piece
      !> `piece_done`, `piece_stopped` or a value of errno.
      integer, intent(out) :: code
      real(wp) :: results(size(self%sweep%results))
      character(len=:), allocatable :: message
      integer(i8) :: number
      integer :: status
      logical :: stopped

      number = self%selection%case_at(piece)
      call run_case(self%sweep, self%outline, number, thread, results, status, message, stopped)
      code = piece_stopped
      if (.not. stopped) call self%journal%write(piece, number, status, results, message, code)
   end subroutine work_case

   !> Whether the row of a case is in the journal.
   function done_case(self, piece) result(answer)
      !> The cases.
      class(cases_type), intent(in) :: self
      !> Position of the case.
      integer(i8), intent(in) :: piece
      logical :: answer

      answer = self%journal%has(piece)
   end function done_case

   !> Write the row of a case that never ended.
   subroutine lost_case(self, piece, late, reason, code)
      !> The cases.
      class(cases_type), intent(inout) :: self
      !> Position of the case.
      integer(i8), intent(in) :: piece
      !> Whether it did not end in time.
      logical, intent(in) :: late
      !> How its process died.
      character(len=*), intent(in) :: reason
      !> 0, or a value of errno.
      integer, intent(out) :: code
      real(wp) :: results(size(self%sweep%results))

      results = ieee_value(results, ieee_quiet_nan)
      if (late) then
         call self%journal%write(piece, self%selection%case_at(piece), case_too_long, results, &
            "given up without an answer after " // number_text(self%sweep%time_limit, 4) // &
            " s of wall time", code)
      else
         call self%journal%write(piece, self%selection%case_at(piece), case_crashed, results, &
            "the program crashed: " // reason, code)
      end if
   end subroutine lost_case

   !> Show how far the sweep is.
   subroutine look_cases(self, finished)
      !> The cases.
      class(cases_type), intent(inout) :: self
      !> Cases that were run by now.
      integer(i8), intent(in) :: finished
      integer, parameter :: widest = 40
      real(wp) :: now, share
      integer :: filled, width
      character(len=:), allocatable :: words

      associate (p => self%progress)
         if (.not. p%show .or. finished == 0) return
         share = min(real(p%before + finished, wp)/real(p%total, wp), 1.0_wp)
         now = wall_seconds()
         words = to_text(p%before + finished) // " of " // to_text(p%total) // " cases, " // &
            time_left() // " left"
         if (p%terminal) then
            if (now - p%last < 0.1_wp) return
            p%last = now
            width = max(min(widest, terminal_width() - len(words) - 11), 0)
            filled = int(share*width)
            call write_stderr(achar(13) // achar(27) // "[K[" // repeat("#", filled) // &
               repeat(" ", width - filled) // "] " // to_text(int(100.0_wp*share)) // " %, " // &
               words)
         else if (int(10.0_wp*share) > p%tenths) then
            p%tenths = int(10.0_wp*share)
            call write_stderr("contensou: " // to_text(10*p%tenths) // " %, " // words // nl)
         end if
      end associate

   contains

      !> Estimated wall time to the end.
      function time_left() result(text)
         character(len=:), allocatable :: text
         integer(i8) :: seconds

         associate (p => self%progress)
            seconds = nint(min((now - p%start)*real(p%total - p%before - finished, wp) &
               /real(finished, wp), 1.0e9_wp), i8)
         end associate
         text = to_text(seconds) // " s"
         if (seconds >= 120) text = to_text(seconds/60) // " min"
         if (seconds >= 7200) text = to_text(seconds/3600) // " h " // &
            to_text(mod(seconds, 3600_i8)/60) // " min"
      end function time_left

   end subroutine look_cases

   !> Remove the bar from the terminal.
   subroutine clear_bar(progress)
      !> The progress.
      type(progress_type), intent(in) :: progress

      if (progress%show .and. progress%terminal) call write_stderr(achar(13) // achar(27) // "[K")
   end subroutine clear_bar

   !> A signal came: say where the rows are.
   subroutine stop_here(name, cases, error)
      !> Name of the table.
      character(len=*), intent(in) :: name
      !> The cases.
      type(cases_type), intent(in) :: cases
      !> What is said.
      type(error_type), allocatable, intent(out) :: error

      call cases%journal%sync(error)
      if (.not. allocated(error)) call fatal(error, "interrupted; the rows so far are in " // &
         name // part_suffix // ", the same command goes on from there", status_interrupted)
   end subroutine stop_here

   !> The trajectories that are wanted of these cases.
   subroutine list_trajectories(sweep, selection, may_exist, force, list, error)
      !> The sweep.
      type(sweep_type), intent(in), target :: sweep
      !> The cases.
      type(selection_type), intent(in) :: selection
      !> Whether files that exist are no reason not to begin.
      logical, intent(in) :: may_exist
      !> Whether to remove these.
      logical, intent(in) :: force
      !> The trajectories.
      type(trajectories_type), intent(inout) :: list
      !> Set when a file is in the way.
      type(error_type), allocatable, intent(out) :: error
      integer :: i, n
      logical :: is

      n = 0
      do i = 1, size(sweep%trajectories)
         if (selection%position_of(sweep%trajectories(i)) > 0) n = n + 1
      end do
      allocate(list%numbers(n), list%files(n))
      list%sweep => sweep
      n = 0
      do i = 1, size(sweep%trajectories)
         if (selection%position_of(sweep%trajectories(i)) == 0) cycle
         n = n + 1
         list%numbers(n) = sweep%trajectories(i)
         list%files(n)%s = named(sweep%output, "_case_" // to_text(list%numbers(n)))
         is = file_exists(list%files(n)%s)
         if (is .and. .not. may_exist) then
            call fatal(error, list%files(n)%s // " exists; --force replaces it, -o FILE writes " &
               // "others", status_file)
            return
         end if
         if (is .and. force) call remove_file(list%files(n)%s, error)
         if (allocated(error)) return
      end do
   end subroutine list_trajectories

   !> Write the trajectories that are not there, one at a time.
   subroutine write_trajectories(list, cases, stopped, error)
      !> The trajectories.
      type(trajectories_type), intent(inout) :: list
      !> The cases.
      type(cases_type), intent(in) :: cases
      !> Whether a signal came.
      logical, intent(out) :: stopped
      !> Set when the work cannot go on.
      type(error_type), allocatable, intent(out) :: error
      type(trajectories_type) :: wanted
      real(wp) :: results(size(cases%sweep%results))
      character(len=journal_message_length) :: message
      integer(i8) :: number
      integer :: i, n, status, length
      logical :: found, runs(size(list%numbers))

      stopped = .false.
      if (size(list%numbers) == 0) return
      do i = 1, size(list%numbers)
         call cases%journal%read(cases%selection%position_of(list%numbers(i)), found, number, &
            status, results, message, length, error)
         if (allocated(error)) return
         ! A case that never ended has none; one that failed leaves its rows in a .part file.
         runs(i) = found .and. any(status == [case_complete, case_failed])
      end do
      allocate(wanted%numbers(count(runs)), wanted%files(count(runs)))
      wanted%sweep => list%sweep
      n = 0
      do i = 1, size(list%numbers)
         if (.not. runs(i)) cycle
         n = n + 1
         wanted%numbers(n) = list%numbers(i)
         wanted%files(n)%s = list%files(i)%s
      end do
      call run_crew(wanted, int(n, i8), 1, writing_allowance*min(cases%sweep%time_limit, &
         huge(1.0_wp)/writing_allowance), stopped, error)
      if (allocated(error)) error%message = "cannot write the trajectories " // &
         named(cases%sweep%output, "_case_N") // ": " // error%message
   end subroutine write_trajectories

   !> Run a case as `contensou run` does, in a process of its own.
   subroutine work_trajectory(self, thread, piece, code)
      !> The trajectories.
      class(trajectories_type), intent(in) :: self
      !> Number of the thread.
      integer, intent(in) :: thread
      !> Which one.
      integer(i8), intent(in) :: piece
      !> `piece_done`, `piece_stopped` or a value of errno.
      integer, intent(out) :: code
      type(scene_file_type) :: file
      type(string_type), allocatable :: overrides(:), words(:)
      type(error_type), allocatable :: error, remove_error
      type(earlier_type) :: nothing
      integer :: i, n

      code = piece_done
      associate (sweep => self%sweep, name => self%files(piece)%s)
         call sweep%overrides_of(self%numbers(piece), overrides)
         call read_scene(sweep%scene_path, overrides, name, file, error)
         if (allocated(error)) return
         n = size(overrides)
         allocate(words(2*n + 4))
         words(1)%s = "run"
         words(2)%s = sweep%scene_path
         do i = 1, n
            words(2*i + 1)%s = "--set"
            words(2*i + 2)%s = overrides(i)%s
         end do
         words(2*n + 3)%s = "-o"
         words(2*n + 4)%s = name
         call run_scene(file, command_text(words), .false., .true., .false., .false., &
            huge(1.0_wp), nothing, error)
         if (.not. allocated(error)) return
         if (error%status == status_interrupted) then
            call remove_file(name // part_suffix, remove_error)
            call forget(name, .true., remove_error)
            code = piece_stopped
         else if (error%status == status_file) then
            code = input_output_error
         end if
      end associate
   end subroutine work_trajectory

   !> Whether a trajectory is there.
   function done_trajectory(self, piece) result(answer)
      !> The trajectories.
      class(trajectories_type), intent(in) :: self
      !> Which one.
      integer(i8), intent(in) :: piece
      logical :: answer

      answer = file_exists(self%files(piece)%s)
   end function done_trajectory

   !> A trajectory that cannot be written is not there.
   subroutine lost_trajectory(self, piece, late, reason, code)
      !> The trajectories.
      class(trajectories_type), intent(inout) :: self
      !> Which one.
      integer(i8), intent(in) :: piece
      !> Whether it did not end in time.
      logical, intent(in) :: late
      !> How its process died.
      character(len=*), intent(in) :: reason
      !> 0.
      integer, intent(out) :: code

      code = 0
   end subroutine lost_trajectory

   !> Nothing is shown of trajectories.
   subroutine look_trajectories(self, finished)
      !> The trajectories.
      class(trajectories_type), intent(inout) :: self
      !> Trajectories that were written by now.
      integer(i8), intent(in) :: finished
   end subroutine look_trajectories

   !> Make the table from the journal.
   subroutine write_table(name, cases, command, words, tally, stopped, error)
      !> Name of the table.
      character(len=*), intent(in) :: name
      !> The cases, all done.
      type(cases_type), intent(in) :: cases
      !> What the user asks for.
      type(command_type), intent(in) :: command
      !> Words of the command line.
      type(string_type), intent(in) :: words(:)
      !> What they come to.
      type(tally_type), intent(out) :: tally
      !> Whether a signal came.
      logical, intent(out) :: stopped
      !> Set when it cannot be written.
      type(error_type), allocatable, intent(out) :: error
      type(sweep_table_type) :: table
      type(error_type), allocatable :: append_error
      type(string_type), allocatable :: messages(:)
      character(len=journal_message_length) :: message
      real(wp), allocatable :: results(:, :)
      integer(i8), allocatable :: numbers(:)
      integer, allocatable :: status(:)
      integer(i8) :: position
      integer :: n, length
      logical :: found

      stopped = .false.
      allocate(numbers(rows_at_a_time), status(rows_at_a_time), messages(rows_at_a_time))
      allocate(results(size(cases%sweep%results), rows_at_a_time))
      call table%open(name, command%force, cases%sweep, cases%selection%text(), &
         command_text(words), error)
      if (allocated(error)) return
      n = 0
      do position = 1, cases%selection%count()
         n = n + 1
         call cases%journal%read(position, found, numbers(n), status(n), results(:, n), message, &
            length, error)
         if (.not. allocated(error) .and. .not. found) call fatal(error, "the row of case " // &
            to_text(cases%selection%case_at(position)) // " is missing in " // name // &
            part_suffix // "; the same command runs it again", status_failed)
         if (allocated(error)) exit
         messages(n)%s = message(:length)
         call count_case(tally, numbers(n), status(n), messages(n)%s)
         if (n < rows_at_a_time .and. position < cases%selection%count()) cycle
         call table%append(cases%sweep, numbers(:n), status(:n), messages(:n), results(:, :n), &
            append_error)
         n = 0
         if (position < cases%selection%count()) stopped = stop_requested()
         if (stopped .or. allocated(append_error)) exit
      end do
      if (allocated(append_error)) call move_alloc(append_error, error)
      if (stopped .or. allocated(error)) then
         call table%abandon()
      else
         call table%finish(error)
      end if
   end subroutine write_table

   !> Count a case.
   subroutine count_case(tally, number, status, message)
      !> The tally.
      type(tally_type), intent(inout) :: tally
      !> Number of the case.
      integer(i8), intent(in) :: number
      !> Its status.
      integer, intent(in) :: status
      !> Its message.
      character(len=*), intent(in) :: message

      tally%counts(status) = tally%counts(status) + 1
      if (tally%first(status) > 0) return
      tally%first(status) = number
      tally%message(status)%s = message
   end subroutine count_case

   !> Print what the sweep came to.
   subroutine print_summary(name, sweep, tally, trajectories, threads, wall, error)
      !> Name of the table.
      character(len=*), intent(in) :: name
      !> The sweep.
      type(sweep_type), intent(in) :: sweep
      !> The tally.
      type(tally_type), intent(in) :: tally
      !> The trajectories.
      type(trajectories_type), intent(in) :: trajectories
      !> Number of threads.
      integer, intent(in) :: threads
      !> Wall time [s].
      real(wp), intent(in) :: wall
      !> Set when the standard output cannot be written.
      type(error_type), allocatable, intent(out) :: error
      type(string_type), allocatable :: overrides(:), words(:)
      character(len=:), allocatable :: text
      integer :: i, j, shown
      logical :: is

      text = "sweep of " // sweep%scene_path // nl // "  cases      " // &
         to_text(sum(tally%counts)) // ": " // to_text(tally%counts(case_complete)) // " complete"
      do i = 1, ubound(tally%counts, 1)
         if (tally%counts(i) > 0) text = text // ", " // to_text(tally%counts(i)) // " " // &
            words_of(i)
      end do
      text = text // nl
      shown = 0
      do i = 1, ubound(tally%counts, 1)
         if (tally%counts(i) == 0) cycle
         if (shown == 0) shown = i
         text = text // "  " // words_of(i) // repeat(" ", max(11 - len(words_of(i)), 1)) // &
            "first case " // to_text(tally%first(i)) // ": " // indented(tally%message(i)%s) // nl
      end do
      if (shown > 0) then
         call sweep%overrides_of(tally%first(shown), overrides)
         allocate(words(2*size(overrides) + 2))
         words(1)%s = "run"
         words(2)%s = sweep%scene_path
         do j = 1, size(overrides)
            words(2*j + 1)%s = "--set"
            words(2*j + 2)%s = overrides(j)%s
         end do
         text = text // "  to see     /status and /message in " // name // "; case " // &
            to_text(tally%first(shown)) // " alone is" // nl // "             " // &
            command_text(words) // nl
      end if
      do i = 1, size(trajectories%numbers)
         is = file_exists(trajectories%files(i)%s)
         if (is) then
            text = text // "  trajectory " // trajectories%files(i)%s // nl
         else
            text = text // "  trajectory of case " // to_text(trajectories%numbers(i)) // &
               ": none, the case did not complete" // nl
         end if
      end do
      text = text // "  work       " // number_text(wall, 3) // " s wall on " // &
         threads_text(threads) // nl // "  table      " // name // nl
      call write_stdout(text, error)

   contains

      !> A status in words.
      pure function words_of(status) result(name_of_it)
         !> The status.
         integer, intent(in) :: status
         character(len=:), allocatable :: name_of_it
         integer :: k

         name_of_it = trim(status_names(status))
         do k = 1, len(name_of_it)
            if (name_of_it(k:k) == "_") name_of_it(k:k) = " "
         end do
      end function words_of

      !> A message, its lines after the first one indented as far as it is.
      pure function indented(message) result(lines)
         !> The message.
         character(len=*), intent(in) :: message
         character(len=:), allocatable :: lines
         integer :: k

         lines = ""
         do k = 1, len(message)
            lines = lines // message(k:k)
            if (message(k:k) == nl) lines = lines // repeat(" ", 13)
         end do
      end function indented

   end subroutine print_summary

end module contensou_drivers_sweep
