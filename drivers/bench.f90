!> `contensou bench kernels`: error and cost of every way to compute every kernel.
module contensou_drivers_bench
   use contensou_base_build, only : build_compiler, git_commit, program_version
   use contensou_base_errors, only : error_type, fatal, status_file, status_usage
   use contensou_base_kinds, only : wp
   use contensou_base_numbers, only : to_text
   use contensou_base_operating_system, only : is_terminal, remove_file, rename_file, &
      temporary_name, write_stdout
   use contensou_base_text, only : did_you_mean, lower, quote, string_type
   use contensou_drivers_bench_baselines, only : boost_version
   use contensou_drivers_bench_errors, only : check_errors
   use contensou_drivers_bench_report, only : bars_text, csv_text, table_text, write_hdf5
   use contensou_drivers_bench_suite, only : new_suite, suite_type
   use contensou_drivers_bench_times, only : measure_times
   use contensou_drivers_command_line, only : command_line_type, command_type, option_type
   use contensou_drivers_output, only : check_output, write_text
   use contensou_drivers_progress, only : progress_type
   use contensou_files_hdf5_file, only : hdf5_file_type
   implicit none(type, external)
   private

   public :: bench_command

   type(option_type), parameter :: options(*) = [ &
      option_type("kernels", "", "what is measured", needs="a benchmark"), &
      option_type("--output", "NAME", "write NAME.csv and NAME.h5", "-o", "the name of a file"), &
      option_type("--force", "", "replace existing files"), &
      option_type("--quick", "", "2 s, fewer arguments: rough times")]

   !> What the user asks for, in the words of the options.
   type :: bench_config_type
      !> The name is that of the output files without their ending; blank for none.
      character(len=:), allocatable :: benchmark, name
      logical :: force = .false., quick = .false.
   end type bench_config_type

   !> Things that can be measured.
   character(len=*), parameter :: benchmarks(1) = ["kernels"]

   !> Time of the rounds, and that with `--quick` [s].
   real(wp), parameter :: full_time = 6.0_wp, quick_time = 0.8_wp

   character(len=*), parameter :: nl = new_line("a")

contains

   !> `contensou bench` in the table of commands.
   function bench_command() result(command)
      type(command_type) :: command

      command = command_type("bench", "measure error and cost of the kernels", options, &
         "measures error and cost of every way to compute every kernel, in 8 s", execute=bench)
   end function bench_command

   !> Measure, print, and write files if they are asked for.
   subroutine bench(line, error)
      type(command_line_type), intent(in) :: line
      !> Set when there is a mistake or a file cannot be written.
      type(error_type), allocatable, intent(out) :: error
      type(suite_type) :: suite
      type(bench_config_type) :: config
      type(string_type) :: none(0)
      character(len=:), allocatable :: text
      integer :: rounds
      type(progress_type) :: progress

      config%benchmark = line%text("kernels")
      config%name = base_name(line%text("--output"))
      config%force = line%has("--force")
      config%quick = line%has("--quick")
      if (.not. any(benchmarks == lower(config%benchmark))) then
         call fatal(error, "unknown benchmark " // quote(config%benchmark) // &
            did_you_mean(config%benchmark, benchmarks, "possible is kernels"), status_usage)
         return
      end if
      if (config%name /= "") then
         call check_output(config%name // ".csv", none, config%force, error)
         if (.not. allocated(error)) call check_output(config%name // ".h5", none, config%force, &
            error)
         if (allocated(error)) return
      end if
      call progress%begin(.not. is_terminal(2), 0.0_wp)
      call progress%stage("measuring for about " // trim(merge("2", "8", config%quick)) // " s")
      call new_suite(suite)
      call check_errors(suite, config%quick)
      call measure_times(suite, merge(quick_time, full_time, config%quick), rounds)
      call progress%clear()

      text = "contensou " // program_version // ", commit " // git_commit() // ", " // &
         build_compiler // nl
      if (boost_version() > 0) then
         text = text // "with Boost.Math " // to_text(int(boost_version())/100000) // "." // &
            to_text(mod(int(boost_version())/100, 1000))
      else
         text = text // "without Boost.Math"
      end if
      text = text // "; times are the least of " // to_text(rounds) // " interleaved rounds" // nl
      text = text // table_text(suite) // nl // bars_text(suite)
      ! Files first: a reader of the output that goes away does not cost the measurement.
      if (config%name /= "") call write_files(suite, config%name, rounds, config%force, error)
      if (.not. allocated(error)) call write_stdout(text, error)
   end subroutine bench

   !> A name without the ending .csv or .h5.
   pure function base_name(output) result(name)
      !> What the user gave.
      character(len=*), intent(in) :: output
      character(len=:), allocatable :: name

      name = output
      if (len(name) > 4) then
         if (name(len(name) - 3:) == ".csv") name = name(:len(name) - 4)
      end if
      if (len(name) > 3) then
         if (name(len(name) - 2:) == ".h5") name = name(:len(name) - 3)
      end if
   end function base_name

   !> Write NAME.csv and NAME.h5, each under a temporary name that it loses when both are complete.
   subroutine write_files(suite, name, rounds, force, error)
      type(suite_type), intent(in) :: suite
      !> Name without ending.
      character(len=*), intent(in) :: name
      !> Number of rounds of the measurement.
      integer, intent(in) :: rounds
      !> Whether existing files are replaced.
      logical, intent(in) :: force
      type(error_type), allocatable, intent(out) :: error
      type(hdf5_file_type) :: file
      type(error_type), allocatable :: ignored
      character(len=:), allocatable :: csv, h5
      logical :: ours

      ours = .false.
      csv = temporary_name(name // ".csv")
      h5 = temporary_name(name // ".h5")
      call write_text(csv, csv_text(suite), error)
      if (.not. allocated(error)) call write_hdf5(suite, h5, rounds, file, error)
      ours = file%is_open()
      if (.not. allocated(error)) call file%close_as(name // ".h5", force, error)
      if (.not. allocated(error)) call rename_file(csv, name // ".csv", error, force)
      if (allocated(error)) then
         call file%abandon()
         call remove_file(csv, ignored)
         if (ours) call remove_file(h5, ignored)
      end if
   end subroutine write_files

end module contensou_drivers_bench
