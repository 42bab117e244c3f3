!> `contensou run`: simulate a scene and write its output file.
module contensou_drivers_run
   use contensou_base_errors, only : error_type, fatal, status_file, status_interrupted, &
      status_usage
   use contensou_base_kinds, only : wp
   use contensou_base_numbers, only : number_text
   use contensou_base_operating_system, only : catch_signals, check_writable, file_exists, &
      name_lock_type, signal_received, write_stderr
   use contensou_base_output_path, only : check_output_path
   use contensou_base_text, only : command_text, string_type
   use contensou_drivers_command_line, only : command_line_type, command_type, option_type, &
      quiet_option, set_option, strict_option, takes_non_negative
   use contensou_drivers_progress, only : progress_type
   use contensou_drivers_report, only : heed_warnings
   use contensou_drivers_run_summary, only : print_summary
   use contensou_files_earlier, only : check_output, companions, earlier_type, find_earlier
   use contensou_files_recorder, only : recorder_type
   use contensou_files_trajectory, only : part_suffix
   use contensou_scene_reader, only : read_scene, scene_file_type
   use contensou_study_simulation, only : new_simulation, simulate, simulation_options_type, &
      simulation_type
   use contensou_sweep_crew, only : crew_stopping
   implicit none(type, external)
   private

   public :: run_command

   type(option_type), parameter :: options(*) = [ &
      option_type("SCENE", "", "namelist file", needs="a scene"), &
      set_option, &
      option_type("--output", "FILE", "output file, instead of that of the scene", "-o", &
      "the name of a file"), &
      option_type("--force", "", "replace an existing output file"), &
      option_type("--resume", "", "continue an interrupted or killed run; begin it if there " // &
      "is none, do nothing if it is complete"), &
      option_type("--checkpoint", "S", "wall time between two checkpoints [s], default 5", &
      needs="a time >= 0 [s]", takes=takes_non_negative), &
      quiet_option, strict_option, &
      option_type("--profile", "", "tell the CPU time by effect")]

   !> What the user asks for, in the words of the options.
   type :: run_config_type
      character(len=:), allocatable :: scene, output
      type(string_type), allocatable :: overrides(:)
      logical :: force = .false., resume = .false., quiet = .false., profile = .false.
      real(wp) :: checkpoint = 5.0_wp
   end type run_config_type

   !> Observer that writes the output file, shows progress and heeds signals.
   type, extends(recorder_type) :: watch_type
      !> End of time [s].
      real(wp) :: t_end = 0.0_wp
      type(progress_type) :: progress
   contains
      procedure :: after_step
      procedure :: advise
      procedure :: warn
   end type watch_type

   !> How long to wait for another process that writes the same file, and for one that is to be gone
   !> on with [s].
   real(wp), parameter :: patience = 0.5_wp, resume_patience = 10.0_wp

contains

   !> `contensou run` in the table of commands.
   function run_command() result(command)
      type(command_type) :: command

      command = command_type("run", "simulate a scene", options, heeds_signals=.true., execute=run)
   end function run_command

   !> What a command line asks for.
   subroutine configure(line, config, error)
      type(command_line_type), intent(in) :: line
      type(run_config_type), intent(out) :: config
      !> Set when options contradict each other.
      type(error_type), allocatable, intent(out) :: error

      config%scene = line%text("SCENE")
      config%overrides = line%texts("--set")
      config%output = line%text("--output")
      config%force = line%has("--force")
      config%resume = line%has("--resume")
      config%checkpoint = line%number("--checkpoint", config%checkpoint)
      config%quiet = line%has("--quiet")
      config%profile = line%has("--profile")
      if (config%resume .and. config%force) call fatal(error, &
         "--resume continues what there is, --force replaces it: only one of them can be meant", &
         status_usage)
   end subroutine configure

   !> Simulate a scene.
   subroutine run(line, error)
      type(command_line_type), intent(in) :: line
      !> Set when the run did not complete.
      type(error_type), allocatable, intent(out) :: error
      type(run_config_type) :: config
      type(scene_file_type) :: file
      type(name_lock_type) :: lock
      type(string_type) :: inputs(1)
      logical :: taken

      call configure(line, config, error)
      if (allocated(error)) return
      call catch_signals()
      call read_scene(config%scene, config%overrides, config%output, file, error)
      if (allocated(error)) return
      call heed_warnings(file, config%scene, line%has("--strict"), error)
      if (allocated(error)) return
      inputs(1)%s = config%scene
      associate (name => file%scene%output%file)
         call check_output_path(name, "output file", inputs, companions, config%force, error)
         if (allocated(error)) return
         ! A file that stays as it is needs no lock.
         taken = file_exists(name) .and. .not. config%force
         if (.not. taken) then
            call check_writable(name, "output file", error)
            if (allocated(error)) return
            call lock%take(name, merge(resume_patience, patience, config%resume), taken, error)
            if (allocated(error)) return
         end if
         if (taken) then
            call write_run(line, config, file, error)
         else if (signal_received() /= 0) then
            call fatal(error, "interrupted; nothing was written", status_interrupted)
         else
            call fatal(error, "another run is writing " // name // part_suffix, status_file)
         end if
         call lock%leave()
      end associate
   end subroutine run

   !> Simulate a scene, while no other run writes the same file.
   subroutine write_run(line, config, file, error)
      type(command_line_type), intent(in) :: line
      type(run_config_type), intent(in) :: config
      type(scene_file_type), intent(inout) :: file
      !> Set when the run did not complete.
      type(error_type), allocatable, intent(out) :: error
      type(simulation_type) :: simulation
      type(simulation_options_type) :: simulation_options
      type(earlier_type) :: earlier
      type(watch_type) :: watch
      type(error_type), allocatable :: ignored
      character(len=:), allocatable :: notice

      call check_output(file%scene%output%file, config%force, config%resume, notice, error)
      if (.not. config%quiet) call notify(notice)
      if (allocated(error)) return
      if (config%resume) then
         call find_earlier(file%scene%output%file, file%resolved, earlier, error)
         if (.not. config%quiet) call notify(earlier%notice)
         call notify(earlier%warning)
      end if
      if (allocated(error) .or. earlier%complete) return
      simulation_options%profile = config%profile
      call new_simulation(file, simulation, error, simulation_options)
      if (.not. allocated(error) .and. signal_received() /= 0) then
         if (earlier%resumable) then
            call fatal(error, "interrupted; nothing new was written" // &
               so_far(file%scene%output%file), status_interrupted)
         else
            call fatal(error, "interrupted; nothing was written", status_interrupted)
         end if
      end if
      if (allocated(error)) return
      watch%t_end = file%scene%t_end
      watch%output%flush_interval = config%checkpoint
      call watch%begin(file, simulation, command_text(line%words), config%force, earlier, error)
      if (allocated(error)) return
      call watch%progress%begin(config%quiet, min(simulation%time()/watch%t_end, 1.0_wp))
      if (earlier%resumable) call watch%progress%note("resuming at t = " // &
         number_text(simulation%time(), 8) // " s")
      call simulate(simulation, watch, error)
      call watch%progress%clear()
      call watch%finish(simulation, error)
      if (allocated(error)) return
      if (.not. simulation%stopped) then
         if (.not. config%quiet) call print_summary(file%scene, simulation, watch, error)
         return
      end if
      ! The terminal may be lost with all that could be said there.
      if (.not. config%quiet) call print_summary(file%scene, simulation, watch, ignored)
      call fatal(error, &
         "interrupted at t = " // number_text(simulation%time(), 8) // " s" // &
         so_far(file%scene%output%file), status_interrupted)
   end subroutine write_run

   !> What an interrupted run leaves, and how to go on.
   function so_far(name) result(text)
      !> Output file.
      character(len=*), intent(in) :: name
      character(len=:), allocatable :: text

      text = "; the rows so far are in " // name // part_suffix // ", --resume continues the run"
      if (file_exists(name)) text = text // " once " // name // " is moved away"
   end function so_far

   !> Tell the user.
   subroutine notify(lines)
      !> Whole lines.
      character(len=*), intent(in) :: lines
      integer :: first, last

      first = 1
      do while (first <= len(lines))
         last = first + index(lines(first:), new_line("a")) - 1
         call write_stderr("contensou: " // lines(first:last))
         first = last + 1
      end do
   end subroutine notify

   !> A step is done: signals and progress.
   subroutine after_step(self, t, stop_now, error)
      class(watch_type), intent(inout) :: self
      real(wp), intent(in) :: t
      logical, intent(out) :: stop_now
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: share

      call self%recorder_type%after_step(t, stop_now, error)
      stop_now = signal_received() /= 0 .or. crew_stopping()
      ! It has just looked at the clock.
      if (self%steps > 0) return
      share = min(t/self%t_end, 1.0_wp)
      if (self%progress%is_due(share)) call self%progress%tell(share, &
         "t = " // number_text(t, 4) // " s")
   end subroutine after_step

   !> The method has something to say: at once, and in the summary.
   subroutine advise(self, t, text)
      class(watch_type), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> What it says.
      character(len=*), intent(in) :: text

      call self%recorder_type%advise(t, text)
      call self%progress%note(self%advice)
   end subroutine advise

   !> What the user should know of the run: at once, and in the summary.
   subroutine warn(self, text)
      class(watch_type), intent(inout) :: self
      !> What it is.
      character(len=*), intent(in) :: text

      call self%recorder_type%warn(text)
      call self%progress%note("warning: " // text)
   end subroutine warn

end module contensou_drivers_run
