!> `contensou sweep`: run the cases of a sweep, or a part of them, into one table.
!>
!> Rows go into a journal, FILE.part, as cases end, in any order; when there is one for each case
!> the table is made from it. Whatever ends the program, the next one goes on from the journal.
module contensou_drivers_sweep
   use contensou_sweep_crew, only : available_cores, hold_signals, run_crew, &
      stop_requested
   use contensou_base_errors, only : error_type, fatal, status_file, status_interrupted, &
      status_usage
   use contensou_base_kinds, only : i8, wp
   use contensou_base_numbers, only : counted
   use contensou_base_operating_system, only : file_exists, name_lock_type, remove_file, &
      wall_seconds, write_stdout
   use contensou_base_text, only : command_text, quote, string_type
   use contensou_drivers_command_line, only : command_line_type, command_type, option_type, &
      quiet_option, set_option, strict_option, takes_count
   use contensou_sweep_case, only : outline_of
   use contensou_drivers_report, only : heed_warnings
   use contensou_drivers_sweep_report, only : begin_progress, print_summary, shown_cases_type
   use contensou_sweep_selection, only : select_cases, selection_type, table_name
   use contensou_sweep_cases, only : check_output_paths, tally_type, write_table
   use contensou_sweep_trajectories, only : list_trajectories, trajectories_type, write_trajectories
   use contensou_sweep_plan, only : sweep_type
   use contensou_sweep_reader, only : read_sweep
   use contensou_sweep_table, only : case_complete, check_table, table_header_type
   use contensou_files_trajectory, only : part_suffix
   implicit none(type, external)
   private

   public :: sweep_command

   type(option_type), parameter :: options(*) = [ &
      option_type("SWEEP", "", "sweep file", needs="a sweep file"), &
      option_type("--jobs", "N", "threads; without it OMP_NUM_THREADS, SLURM_CPUS_PER_TASK or " // &
      "all cores", "-j", "a number of threads >= 1", takes_count), &
      option_type("--shard", "K/M", "only part K of M, into FILE_shard_K_of_M"), &
      option_type("--cases", "A:B,C", "only these cases, into FILE_cases_A_to_C", &
      needs="ranges such as 1:500,800"), &
      option_type("--output", "FILE", "table, instead of that of the sweep file", "-o", &
      "the name of a file"), &
      option_type("--force", "", "begin anew, replace existing files"), &
      quiet_option, set_option, strict_option]

   !> What the user asks for, in the words of the options; texts blank, numbers 0 for the default.
   type :: sweep_config_type
      character(len=:), allocatable :: sweep, cases, output
      type(string_type), allocatable :: overrides(:)
      !> Which shard, and of how many.
      integer :: shard(2) = 0
      integer :: jobs = 0
      logical :: force = .false., quiet = .false.
   end type sweep_config_type

   integer, parameter :: most_threads = 1024

   !> How long to wait for another process that writes the same table [s].
   real(wp), parameter :: patience = 10.0_wp

   character(len=*), parameter :: nl = new_line("a")

contains

   !> `contensou sweep` in the table of commands.
   function sweep_command() result(command)
      type(command_type) :: command

      command = command_type("sweep", "run a scene over parameters, many cases at a time", &
         options, "runs a scene over its parameters, as a sweep file says, into one table", &
         "a sweep that was stopped goes on when it is started again; exit status 75 if a " // &
         "signal stopped it", heeds_signals=.true., execute=run_sweep)
   end function sweep_command

   !> What a command line asks for.
   subroutine configure(line, config, error)
      type(command_line_type), intent(in) :: line
      type(sweep_config_type), intent(out) :: config
      !> Set when there is no such shard.
      type(error_type), allocatable, intent(out) :: error

      config%sweep = line%text("SWEEP")
      config%overrides = line%texts("--set")
      config%jobs = line%count("--jobs")
      config%cases = line%text("--cases")
      config%output = line%text("--output")
      config%force = line%has("--force")
      config%quiet = line%has("--quiet")
      if (line%has("--shard")) call read_shard(line%text("--shard"), config%shard, error)
   end subroutine configure

   !> Understand which shard of how many.
   subroutine read_shard(text, shard, error)
      !> Such as "1/4".
      character(len=*), intent(in) :: text
      integer, intent(out) :: shard(2)
      !> Set when it cannot be understood.
      type(error_type), allocatable, intent(out) :: error
      integer :: slash
      logical :: valid

      shard = 0
      slash = index(text, "/")
      valid = slash > 1 .and. slash < len(text) .and. slash <= 9 .and. len(text) - slash <= 8
      if (valid) valid = verify(text(:slash - 1), "0123456789") == 0 .and. &
         verify(text(slash + 1:), "0123456789") == 0
      if (valid) then
         read(text(:slash - 1), *) shard(1)
         read(text(slash + 1:), *) shard(2)
         valid = shard(1) >= 1 .and. shard(1) <= shard(2)
      end if
      if (.not. valid) call fatal(error, "--shard needs K/M with 1 <= K <= M, not " // &
         quote(text), status_usage)
   end subroutine read_shard

   subroutine run_sweep(line, error)
      type(command_line_type), intent(in) :: line
      !> Set when it did not come to its end.
      type(error_type), allocatable, intent(out) :: error
      type(sweep_config_type) :: config
      type(sweep_type), target :: sweep
      type(shown_cases_type), target :: cases
      type(name_lock_type) :: lock
      character(len=:), allocatable :: name
      logical :: complete, taken

      call configure(line, config, error)
      if (allocated(error)) return
      call hold_signals()
      call read_sweep(config%sweep, config%overrides, config%output, sweep, error)
      if (allocated(error)) return
      call heed_warnings(sweep%base%file, sweep%scene_path, line%has("--strict"), error)
      if (allocated(error)) return
      call select_cases(config%cases, config%shard, sweep%n_cases, cases%selection, error)
      if (allocated(error)) return
      name = table_name(sweep%output, cases%selection, config%cases /= "" .and. &
         config%output == "", config%shard)
      call check_output_paths(name, sweep, cases%selection, config%force, error)
      if (allocated(error)) return
      call check_output(name, config, sweep, cases%selection, .false., complete, error)
      if (allocated(error) .or. complete) return
      call lock%take(name, patience, taken, error)
      if (allocated(error)) return
      ! Another process may have written the table meanwhile.
      if (taken) call check_output(name, config, sweep, cases%selection, .true., complete, error)
      if (.not. (allocated(error) .or. complete)) then
         if (stop_requested()) then
            call fatal(error, "interrupted; nothing was written", status_interrupted)
         else if (taken) then
            call write_sweep(line, config, sweep, name, cases, error)
         else
            call fatal(error, "another process is writing " // name // part_suffix, status_file)
         end if
      end if
      call lock%leave()
   end subroutine run_sweep

   !> Run the cases of a sweep, while no other process writes the same table.
   subroutine write_sweep(line, config, sweep, name, cases, error)
      type(command_line_type), intent(in) :: line
      type(sweep_config_type), intent(in) :: config
      type(sweep_type), intent(inout), target :: sweep
      !> Name of the table.
      character(len=*), intent(in) :: name
      !> The cases; they are selected.
      type(shown_cases_type), intent(inout), target :: cases
      !> Set when it did not come to its end.
      type(error_type), allocatable, intent(out) :: error
      type(trajectories_type) :: trajectories
      type(tally_type) :: tally
      type(error_type), allocatable :: trouble
      real(wp) :: wall
      integer(i8) :: left
      integer :: threads
      logical :: complete, again, stopped

      wall = wall_seconds()
      again = file_exists(name // part_suffix)
      call list_trajectories(sweep, cases%selection, again .or. config%force, config%force, &
         trajectories, error)
      if (allocated(error)) return
      cases%sweep => sweep
      cases%outline = outline_of(sweep)
      call cases%journal%open(name // part_suffix, sweep%fingerprint // " " // &
         cases%selection%text(), cases%selection%count(), size(sweep%results), config%force, &
         again, error)
      if (allocated(error)) return
      threads = thread_count(config%jobs)
      call begin_progress(cases, again, config%quiet, threads, left)
      stopped = .false.
      if (left > 0) then
         call run_crew(cases, cases%selection%count(), int(min(int(threads, i8), left)), &
            sweep%time_limit, stopped, error)
      end if
      call cases%progress%clear()
      if (allocated(error)) then
         if (error%status == status_file) error%message = "cannot write " // name // &
            part_suffix // ": " // error%message
      end if
      if (.not. allocated(error) .and. .not. stopped) then
         call write_trajectories(trajectories, cases, stopped, error)
      end if
      if (.not. allocated(error) .and. .not. stopped) then
         call write_table(name, config%force, cases, command_text(line%words), tally, &
            stopped, error)
         if (allocated(error) .and. .not. config%force) then
            ! As when merge was there first.
            call check_output(name, config, sweep, cases%selection, .true., complete, trouble)
            if (complete) deallocate(error)
            if (complete) call cases%journal%close()
            if (complete) return
         end if
      end if
      if (stopped .and. .not. allocated(error)) call stop_here(name, cases, error)
      if (.not. allocated(error)) call remove_file(name // part_suffix, error)
      call cases%journal%close()
      if (allocated(error)) return
      if (config%quiet .and. sum(tally%counts) == tally%counts(case_complete)) return
      call print_summary(name, sweep, tally, trajectories, threads, wall_seconds() - wall, error)
   end subroutine write_sweep

   !> Number of threads: as asked for, as the environment says, or one per core.
   function thread_count(jobs) result(threads)
      !> What the user asks for; 0 for nothing.
      integer, intent(in) :: jobs
      integer :: threads

      threads = jobs
      if (threads < 1) threads = from_environment("OMP_NUM_THREADS")
      if (threads < 1) threads = from_environment("SLURM_CPUS_PER_TASK")
      if (threads < 1) threads = int(available_cores())
      threads = min(threads, most_threads)

   contains

      !> A positive number from the environment, the first of a list; 0 without one.
      integer function from_environment(variable)
         character(len=*), intent(in) :: variable
         character(len=64) :: value
         integer :: length, code, last

         from_environment = 0
         call get_environment_variable(variable, value, length, code)
         if (code /= 0 .or. length < 1) return
         value = adjustl(value)
         last = verify(value, "0123456789") - 1
         if (last < 1 .or. last > 6) return
         if (scan(value(last + 1:last + 1), " ,") /= 1) return
         read(value(:last), *) from_environment
      end function from_environment

   end function thread_count

   !> See that the table can be written, and whether it is there already.
   subroutine check_output(name, config, sweep, selection, locked, complete, error)
      character(len=*), intent(in) :: name
      type(sweep_config_type), intent(in) :: config
      type(sweep_type), intent(in) :: sweep
      type(selection_type), intent(in) :: selection
      !> Whether no other process can write it.
      logical, intent(in) :: locked
      !> Whether the table is complete.
      logical, intent(out) :: complete
      !> Set when the sweep must not begin.
      type(error_type), allocatable, intent(out) :: error
      type(table_header_type) :: wanted

      ! Not a structure constructor: gfortran 12 frees its components twice.
      wanted%fingerprint = sweep%fingerprint
      wanted%resolved = sweep%scene_resolved
      wanted%settings = sweep%settings
      call check_table(name, config%force, wanted, selection%text(), complete, error)
      if (.not. complete) return
      ! Left by a program that was killed at its very end.
      if (.not. locked .and. file_exists(name // part_suffix)) then
         complete = .false.
         return
      end if
      call remove_file(name // part_suffix, error)
      if (.not. (allocated(error) .or. config%quiet)) call write_stdout(name // &
         " is complete, " // &
         counted(selection%count(), "case") // nl, error)
   end subroutine check_output

   !> A signal came: say where the rows are.
   subroutine stop_here(name, cases, error)
      character(len=*), intent(in) :: name
      type(shown_cases_type), intent(in) :: cases
      !> What is said.
      type(error_type), allocatable, intent(out) :: error

      call cases%journal%sync(error)
      if (.not. allocated(error)) call fatal(error, "interrupted; the rows so far are in " // &
         name // part_suffix // ", the same command goes on from there", status_interrupted)
   end subroutine stop_here

end module contensou_drivers_sweep
