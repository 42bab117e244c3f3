!> `contensou merge`: join the tables of the shards of a sweep.
module contensou_drivers_merge
   use contensou_base_errors, only : error_type, fatal, status_failed, status_file, &
      status_interrupted, status_usage
   use contensou_base_kinds, only : i8, wp
   use contensou_base_numbers, only : counted, to_text
   use contensou_base_operating_system, only : catch_signals, file_exists, lock_suffix, &
      longest_temporary, name_lock_type, signal_received, write_stderr, write_stdout
   use contensou_base_output_path, only : check_output_path
   use contensou_base_text, only : command_text, shorten, string_type
   use contensou_drivers_command_line, only : command_line_type, command_type, option_type, &
      quiet_option
   use contensou_sweep_merge, only : find_shards, join_tables, merge_type, plan_merge
   use contensou_sweep_plan, only : sweep_type
   use contensou_sweep_reader, only : is_scene_file, is_sweep_file, read_sweep
   use contensou_sweep_table, only : check_table, last_status, status_names
   implicit none(type, external)
   private

   public :: merge_command

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

   !> Bytes of a list of cases that a message shows.
   integer, parameter :: longest_list = 100000

   !> How long to wait for another process that writes the same table [s].
   real(wp), parameter :: patience = 60.0_wp

   character(len=*), parameter :: nl = new_line("a")

contains

   !> `contensou merge` in the table of commands.
   function merge_command() result(command)
      type(command_type) :: command

      command = command_type("merge", "join the tables of parts of a sweep", options, &
         heeds_signals=.true., execute=merge_tables)
   end function merge_command

   !> What a command line asks for.
   subroutine configure(line, config)
      type(command_line_type), intent(in) :: line
      type(merge_config_type), intent(out) :: config

      config%files = line%texts("FILE")
      config%overrides = line%texts("--set")
      config%output = line%text("--output")
      config%force = line%has("--force")
      config%partial = line%has("--partial")
      config%quiet = line%has("--quiet")
   end subroutine configure

   !> Join the tables of shards into one.
   subroutine merge_tables(line, error)
      type(command_line_type), intent(in) :: line
      !> Set when cases are missing or a file is in the way.
      type(error_type), allocatable, intent(out) :: error
      type(merge_config_type) :: config
      type(merge_type) :: plan
      type(name_lock_type) :: lock
      character(len=:), allocatable :: output, sweep_name, lack
      integer(i8) :: counts(0:last_status)
      logical :: complete, taken

      call configure(line, config)
      call catch_signals()
      complete = .false.
      output = config%output
      sweep_name = "SWEEP"
      if (size(config%files) == 1) then
         if (is_sweep_file(config%files(1)%s)) sweep_name = config%files(1)%s
      end if
      if (sweep_name /= "SWEEP") then
         call plan_sweep(config, plan, output, complete, error)
      else if (size(config%overrides) > 0) then
         call fatal(error, "--set goes with a sweep file, not with tables", status_usage)
      else if (output == "") then
         call fatal(error, "tables are joined into another one: merge needs -o TABLE", status_usage)
         call name_scene(config%files, error)
      else
         call check_names(output, config%force, config%files, error)
         if (allocated(error)) return
         call plan_merge(config%files, "", "", plan, error)
         if (allocated(error)) call name_scene(config%files, error)
         if (.not. allocated(error)) call check_output(output, config, all_cases(plan), plan, &
            complete, error)
      end if
      if (allocated(error) .or. complete) return
      lack = to_text(plan%missing%count()) // " of " // to_text(plan%header%n_cases) // &
         " cases are missing"
      if (plan%missing%count() > 0 .and. .not. (config%partial .and. plan%present%count() > 0)) then
         call fatal(error, lack // how_to_run(sweep_name, plan%missing%text()) // &
            "; --partial joins what there is", status_failed)
         return
      end if
      call lock%take(output, patience, taken, error)
      if (allocated(error)) return
      if (taken) then
         ! Another process may have written the table meanwhile.
         call check_output(output, config, plan%present%text(), plan, complete, error)
      else if (signal_received() == 0) then
         call fatal(error, "another process is writing " // output, status_file)
      end if
      if (.not. allocated(error) .and. .not. complete .and. signal_received() == 0) then
         if (config%quiet) then
            call join_tables(plan, output, config%force, command_text(line%words), tell_nothing, &
               counts, error)
         else
            call join_tables(plan, output, config%force, command_text(line%words), tell, counts, &
               error)
         end if
      end if
      call lock%leave()
      if (signal_received() /= 0 .and. .not. complete) then
         if (allocated(error)) deallocate(error)
         call fatal(error, "interrupted; nothing was written", status_interrupted)
         return
      end if
      if (.not. (allocated(error) .or. complete .or. config%quiet)) call print_summary(output, &
         size(plan%files), counts, error)
      if (.not. allocated(error) .and. plan%missing%count() > 0) call fatal(error, lack // &
         " in " // output // how_to_run(sweep_name, plan%missing%text()), status_failed)
   end subroutine merge_tables

   !> What runs the cases that are missing.
   function how_to_run(sweep_name, cases) result(text)
      !> Name of the sweep file.
      character(len=*), intent(in) :: sweep_name
      !> Those that are missing.
      character(len=*), intent(in) :: cases
      character(len=:), allocatable :: text

      text = nl // "  contensou sweep " // sweep_name // " --cases " // &
         shorten(cases, longest_list) // nl // "runs them"
   end function how_to_run

   !> Say so if one of the files is a scene, or is not there.
   subroutine name_scene(files, error)
      type(string_type), intent(in) :: files(:)
      !> What is wrong; replaced if one is.
      type(error_type), allocatable, intent(inout) :: error
      !> Files that are looked into: tables are large.
      integer, parameter :: most = 4
      integer :: i

      do i = 1, min(size(files), most)
         if (.not. file_exists(files(i)%s)) then
            call fatal(error, "cannot read " // files(i)%s // ": it does not exist", status_file)
            return
         end if
         if (.not. is_scene_file(files(i)%s)) cycle
         call fatal(error, files(i)%s // " is a scene: merge joins the tables of shards of a " // &
            "sweep, or takes the file of the sweep", status_usage)
         return
      end do
   end subroutine name_scene

   !> Plan how the shards of a sweep are joined.
   subroutine plan_sweep(config, plan, output, complete, error)
      type(merge_config_type), intent(in) :: config
      type(merge_type), intent(inout) :: plan
      !> Name of the table.
      character(len=:), allocatable, intent(inout) :: output
      !> Whether the table is there already.
      logical, intent(out) :: complete
      !> Set when the sweep has a mistake or a file is in the way.
      type(error_type), allocatable, intent(out) :: error
      type(sweep_type) :: sweep
      type(string_type), allocatable :: files(:)

      complete = .false.
      call read_sweep(config%files(1)%s, config%overrides, config%output, sweep, error)
      if (allocated(error)) return
      output = sweep%output
      plan%header%fingerprint = sweep%fingerprint
      plan%header%n_cases = sweep%n_cases
      plan%header%resolved = sweep%scene_resolved
      plan%header%settings = sweep%settings
      files = sweep%inputs()
      call check_names(output, config%force, files, error)
      if (.not. allocated(error)) call check_output(output, config, all_cases(plan), plan, &
         complete, error)
      if (allocated(error) .or. complete) return
      call find_shards(output, files)
      if (size(files) == 0) then
         call read_sweep(config%files(1)%s, config%overrides, "", sweep, error)
         if (allocated(error)) return
         call find_shards(sweep%output, files)
      end if
      call check_names(output, config%force, files, error)
      if (.not. allocated(error)) call plan_merge(files, sweep%fingerprint, &
         "remove it, or name the tables to join", plan, error)
   end subroutine plan_sweep

   !> See that the table can be written under its name.
   subroutine check_names(output, force, files, error)
      !> Name of the table.
      character(len=*), intent(in) :: output
      !> Whether it may replace an existing file.
      logical, intent(in) :: force
      !> Names of what is read.
      type(string_type), intent(in) :: files(:)
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: beside(*) = [character(len=24) :: lock_suffix, &
         longest_temporary]

      call check_output_path(output, "table", files, beside, force, error)
      if (allocated(error) .or. .not. force) return
      ! Tables do not tell which files their sweep was read from.
      if (is_scene_file(output) .or. is_sweep_file(output)) call fatal(error, "the table " // &
         output // " is a scene or a sweep, which is not replaced; -o FILE writes another one", &
         status_usage)
   end subroutine check_names

   !> The cases of a whole sweep as ranges.
   function all_cases(plan) result(ranges)
      !> What is joined; its header is set.
      type(merge_type), intent(in) :: plan
      character(len=:), allocatable :: ranges

      ranges = "1:" // to_text(plan%header%n_cases)
      if (plan%header%n_cases == 1) ranges = "1"
   end function all_cases

   !> See that the table can be written, and whether it is there already.
   subroutine check_output(output, config, cases, plan, complete, error)
      !> Name of the table.
      character(len=*), intent(in) :: output
      type(merge_config_type), intent(in) :: config
      !> Cases that it is to have, as ranges.
      character(len=*), intent(in) :: cases
      !> What is joined; its header is set.
      type(merge_type), intent(in) :: plan
      !> Whether the table is there and has these cases.
      logical, intent(out) :: complete
      type(error_type), allocatable, intent(out) :: error

      call check_table(output, config%force, plan%header, cases, complete, error)
      if (.not. complete .or. config%quiet) return
      if (cases == all_cases(plan)) then
         call write_stdout(output // " is complete, " // counted(plan%header%n_cases, &
            "case") // nl, error)
      else
         call write_stdout(output // " has these cases already" // nl, error)
      end if
   end subroutine check_output

   !> Tell on stderr how far the joining is.
   subroutine tell(done, total)
      !> Pieces that are joined, and their number.
      integer, intent(in) :: done, total

      call write_stderr("contensou: " // to_text(done) // " of " // to_text(total) // &
         " pieces" // nl)
   end subroutine tell

   !> Do not.
   subroutine tell_nothing(done, total)
      !> Pieces that are joined, and their number.
      integer, intent(in) :: done, total
   end subroutine tell_nothing

   !> Print what the table has.
   subroutine print_summary(output, n_files, counts, error)
      !> Name of the table.
      character(len=*), intent(in) :: output
      !> Number of tables that were joined.
      integer, intent(in) :: n_files
      !> Number of cases of each status.
      integer(i8), intent(in) :: counts(0:)
      !> Set when the standard output cannot be written.
      type(error_type), allocatable, intent(out) :: error
      character(len=:), allocatable :: text
      integer :: i

      text = "joined " // to_text(n_files) // trim(merge(" table ", " tables", n_files == 1)) // &
         nl // "  cases      " // to_text(sum(counts)) // ":"
      do i = 0, last_status
         if (counts(i) == 0) cycle
         if (text(len(text):) /= ":") text = text // ","
         text = text // " " // to_text(counts(i)) // " " // trim(status_names(i))
      end do
      call write_stdout(text // nl // "  table      " // output // nl, error)
   end subroutine print_summary

end module contensou_drivers_merge
