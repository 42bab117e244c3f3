!> `contensou sweep`: run the cases of a sweep, or a part of them, into one table.
!>
!> Rows go into a journal, FILE.part, as cases end, in any order; when there is one for each case
!> the table is made from it. Whatever ends the program, the next one goes on from the journal.
module contensou_drivers_sweep
   use contensou_sweep_crew, only : available_cores, hold_signals, run_crew
   use contensou_base_errors, only : error_type, fatal, status_file, status_interrupted
   use contensou_base_kinds, only : i8, wp
   use contensou_base_operating_system, only : file_exists, folder_writable, is_folder, is_locked, &
      remove_file, wall_seconds, write_stdout
   use contensou_base_text, only : string_type, to_text
   use contensou_drivers_command_line, only : command_type
   use contensou_drivers_sweep_case, only : outline_of
   use contensou_drivers_sweep_cases, only : begin_progress, cases_type
   use contensou_drivers_sweep_selection, only : select_cases, selection_type, table_name
   use contensou_drivers_sweep_summary, only : print_summary, tally_type, write_table
   use contensou_drivers_sweep_trajectories, only : list_trajectories, trajectories_type, &
      write_trajectories
   use contensou_sweep_plan, only : sweep_type
   use contensou_sweep_reader, only : read_sweep
   use contensou_sweep_table, only : read_table_header, table_header_type
   use contensou_files_trajectory, only : part_suffix
   implicit none(type, external)
   private

   public :: sweep_command

   integer, parameter :: most_threads = 1024

   !> End of a line.
   character(len=*), parameter :: nl = new_line("a")

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
      call cases%progress%clear()
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

   !> See that the table can be written, and whether it is there already.
   subroutine check_table(name, sweep, selection, command, complete, error)
      !> Name of the table.
      character(len=*), intent(in) :: name
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

   !> A signal came: say where the rows are.
   subroutine stop_here(name, cases, error)
      !> Name of the table.
      character(len=*), intent(in) :: name
      type(cases_type), intent(in) :: cases
      !> What is said.
      type(error_type), allocatable, intent(out) :: error

      call cases%journal%sync(error)
      if (.not. allocated(error)) call fatal(error, "interrupted; the rows so far are in " // &
         name // part_suffix // ", the same command goes on from there", status_interrupted)
   end subroutine stop_here

end module contensou_drivers_sweep
