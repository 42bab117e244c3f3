!> `contensou run`: simulate a scene and write its output file.
module contensou_drivers_run
   use contensou_sweep_crew, only : crew_stopping
   use contensou_base_errors, only : error_type, fatal, status_file, status_interrupted, &
      status_usage
   use contensou_base_kinds, only : pi, wp
   use contensou_base_operating_system, only : catch_signals, file_exists, &
      folder_writable, is_folder, is_locked, remove_file, signal_received, write_stderr, &
      write_stdout
   use contensou_base_text, only : number_text, quote, string_type, to_text
   use contensou_contact_geometry, only : pose_type
   use contensou_drivers_command_line, only : command_line_type, command_text, command_type, &
      option_type, quiet_option, set_option, takes_non_negative
   use contensou_drivers_progress, only : progress_type
   use contensou_drivers_report, only : body_effects, contact_effects
   use contensou_drivers_resume, only : checkpoint_suffix, earlier_type, exchange_program, &
      find_earlier, forget, is_resumable, old_suffix, put_aside
   use contensou_dynamics_assembly, only : initial_state
   use contensou_dynamics_scene, only : scene_type
   use contensou_integrate_march, only : event_touch, memory_type, observer_type
   use contensou_integrate_motion, only : motion_type
   use contensou_integrate_profile, only : profile_names
   use contensou_base_build, only : git_commit, program_version
   use contensou_base_checkpoint, only : checkpoint_type
   use contensou_files_hdf5_file, only : hdf5_readable_status
   use contensou_scene_reader, only : read_scene, scene_file_type
   use contensou_files_trajectory, only : part_suffix, trajectory_type
   use contensou_study_simulation, only : new_simulation, simulate, simulation_options_type, &
      simulation_type
   implicit none(type, external)
   private

   public :: run_command, run_scene

   !> What `contensou run` takes.
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
      quiet_option, &
      option_type("--profile", "", "tell the CPU time by effect")]

   !> What the user asks for, in the words of the options.
   type :: run_config_type
      character(len=:), allocatable :: scene, output
      type(string_type), allocatable :: overrides(:)
      logical :: force = .false., resume = .false., quiet = .false., profile = .false.
      real(wp) :: checkpoint = 5.0_wp
   end type run_config_type

   !> Observer that writes the output file and shows progress.
   type, extends(observer_type) :: recorder_type
      !> The output file.
      type(trajectory_type) :: output
      !> End of time [s].
      real(wp) :: t_end = 0.0_wp
      type(progress_type) :: progress
      !> Steps since the clocks were looked at.
      integer :: steps = 0
      !> Time of the first touch [s], and its contact; 0 for none.
      real(wp) :: first_touch = 0.0_wp
      !> Contact of the first touch; 0 for none.
      integer :: first_contact = 0
      !> What the method had to say.
      character(len=:), allocatable :: advice
      !> Number of changes of the method.
      integer :: changes = 0
      !> The first change in words.
      character(len=:), allocatable :: first_change
      !> From where the run can go on.
      type(checkpoint_type) :: checkpoint
   contains
      procedure :: keep
      procedure :: exchange
      procedure :: sample
      procedure :: event
      procedure :: after_step
      procedure :: advise
      procedure :: change_method
   end type recorder_type

   !> Steps between two looks at the clocks.
   integer, parameter :: steps_between = 64

contains

   !> `contensou run` in the table of commands.
   function run_command() result(command)
      type(command_type) :: command

      command = command_type("run", "simulate a scene", options, execute=run)
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
      type(earlier_type) :: earlier

      call configure(line, config, error)
      if (allocated(error)) return
      call read_scene(config%scene, config%overrides, config%output, file, error)
      if (allocated(error)) return
      call check_output(file%scene%output%file, config%force, config%resume, config%quiet, error)
      if (allocated(error)) return
      if (config%resume) call find_earlier(file%scene%output%file, file%resolved, &
         config%quiet, earlier, error)
      if (allocated(error) .or. earlier%complete) return
      call catch_signals()
      call run_scene(file, command_text(line%words), config%force, config%quiet, config%profile, &
         .true., config%checkpoint, earlier, error)
   end subroutine run

   !> Simulate a scene and write its output file.
   subroutine run_scene(file, command_line, force, quiet, profile, tell, checkpoint_interval, &
      earlier, error)
      !> The scene, its output file checked.
      type(scene_file_type), intent(in) :: file
      !> Command line, for the output file.
      character(len=*), intent(in) :: command_line
      !> Whether an existing output file is replaced.
      logical, intent(in) :: force
      !> Whether neither progress nor notices are shown.
      logical, intent(in) :: quiet
      !> Whether the CPU time is told by effect.
      logical, intent(in) :: profile
      !> Whether to print what the run comes down to.
      logical, intent(in) :: tell
      !> Wall time between two checkpoints [s].
      real(wp), intent(in) :: checkpoint_interval
      !> What an earlier life of the run left, to be continued.
      type(earlier_type), intent(inout) :: earlier
      !> Set when the run did not complete.
      type(error_type), allocatable, intent(out) :: error
      type(simulation_type) :: simulation
      type(simulation_options_type) :: options
      type(recorder_type) :: recorder
      type(error_type), allocatable :: write_error

      options%profile = profile
      call new_simulation(file, simulation, error, options)
      if (allocated(error)) return
      recorder%t_end = file%scene%t_end
      call recorder%progress%begin(quiet, 0.0_wp)
      recorder%output%flush_interval = checkpoint_interval
      if (earlier%resumable) call put_aside(file%scene%output%file, earlier, error)
      if (allocated(error)) return
      call recorder%output%open(file%scene%output%file, force, file%scene, &
         simulation%motion%system, file%text, file%resolved, command_line, error)
      if (allocated(error) .and. .not. recorder%output%is_open()) return
      if (.not. allocated(error)) call go_on(recorder, earlier, simulation, quiet, error)
      if (.not. earlier%resumable) call recorder%output%use_method(0.0_wp, &
         trim(simulation%choice%method), simulation%reason())
      if (.not. allocated(error)) call simulate(simulation, recorder, error)
      if (profile) recorder%output%cpu_by_effect = simulation%motion%profile%result( &
         simulation%cpu, recorder%output%cpu_output)
      call recorder%progress%clear()
      if (allocated(error)) then
         if (error%status == status_file) then
            call recorder%output%abandon()
            call discard_unreadable(file%scene%output%file, error)
            return
         end if
         call finish("failed", write_error)
         if (.not. allocated(write_error)) call forget(file%scene%output%file, .true., write_error)
         if (allocated(write_error)) then
            error%message = error%message // new_line("a") // write_error%message
         else
            error%message = error%message // new_line("a") // "the rows so far are in " // &
               file%scene%output%file // part_suffix
         end if
         return
      end if
      call finish(trim(merge("interrupted", "complete   ", simulation%stopped)), error)
      if (allocated(error)) then
         call recorder%output%abandon()
         call discard_unreadable(file%scene%output%file, error)
         return
      end if
      if (.not. simulation%stopped) call forget(file%scene%output%file, .true., error)
      if (allocated(error)) return
      if (tell) call print_summary(file%scene, simulation, recorder, error)
      if (allocated(error)) return
      if (simulation%stopped) call fatal(error, "interrupted at t = " // &
         number_text(simulation%time(), 8) // " s; the rows so far are in " // &
         file%scene%output%file // part_suffix // ", --resume continues the run", &
         status_interrupted)

   contains

      !> Close the output file.
      subroutine finish(status, error)
         !> How the run ended.
         character(len=*), intent(in) :: status
         !> Set when the file cannot be written.
         type(error_type), allocatable, intent(out) :: error

         call recorder%output%finish(simulation%motion%system, simulation%memory%y, &
            simulation%memory%statistics, status, error)
      end subroutine finish

   end subroutine run_scene

   !> Take up an earlier life, if there is one, and remove what is left of others.
   subroutine go_on(recorder, earlier, simulation, quiet, error)
      !> The recorder, its file open.
      type(recorder_type), intent(inout) :: recorder
      !> The earlier life.
      type(earlier_type), intent(inout) :: earlier
      !> The simulation, which gets its memory back.
      type(simulation_type), intent(inout) :: simulation
      !> Whether notices are suppressed.
      logical, intent(in) :: quiet
      !> Set when a file cannot be read or written.
      type(error_type), allocatable, intent(out) :: error

      if (earlier%resumable) then
         call recorder%output%restore(earlier%source, earlier%checkpoint, error)
         call simulation%exchange(earlier%checkpoint)
         call recorder%exchange(earlier%checkpoint)
         if (.not. allocated(error)) call earlier%checkpoint%result(error)
         if (allocated(error)) then
            error%status = status_file
            error%message = error%message // new_line("a") // "the rows written before are in " // &
               earlier%source
            return
         end if
         call recorder%progress%begin(quiet, min(simulation%time()/recorder%t_end, &
            1.0_wp))
         call recorder%progress%note("resuming at t = " // number_text(simulation%time(), 8) // &
            " s")
      end if
      call forget(recorder%output%name, .not. earlier%resumable, error)
   end subroutine go_on

   !> Bring the rows to the disk, and then from where the run can go on.
   subroutine keep(self, motion, memory, error)
      class(recorder_type), intent(inout) :: self
      class(motion_type), intent(inout) :: motion
      !> What the march remembers.
      type(memory_type), intent(inout) :: memory
      !> Set when a file cannot be written.
      type(error_type), allocatable, intent(out) :: error
      character(len=64) :: version, commit

      self%keep_due = .false.
      call self%output%flush(error)
      if (allocated(error)) return
      version = program_version
      commit = git_commit()
      call self%checkpoint%begin()
      call exchange_program(self%checkpoint, version, commit)
      call self%output%exchange(self%checkpoint)
      call memory%exchange(motion, self%checkpoint)
      call self%exchange(self%checkpoint)
      call self%checkpoint%save(self%output%name // checkpoint_suffix, error)
   end subroutine keep

   !> Write to a checkpoint what the summary of a run tells besides, or read it back.
   subroutine exchange(self, checkpoint)
      class(recorder_type), intent(inout) :: self
      type(checkpoint_type), intent(inout) :: checkpoint

      call checkpoint%exchange("first_contact", self%first_contact)
      call checkpoint%exchange("first_touch", self%first_touch)
      call checkpoint%exchange("changes", self%changes)
      call checkpoint%exchange_allocatable("advice", self%advice)
      call checkpoint%exchange_allocatable("first_change", self%first_change)
   end subroutine exchange

   !> See that the output file can be written and that nothing is lost by it.
   subroutine check_output(name, force, resume, quiet, error)
      !> Name of the output file.
      character(len=*), intent(in) :: name
      !> Whether it may replace an existing one.
      logical, intent(in) :: force
      !> Whether an earlier run is continued, whatever there is of it.
      logical, intent(in) :: resume
      !> Whether notices are suppressed.
      logical, intent(in) :: quiet
      !> Set when the run must not begin.
      type(error_type), allocatable, intent(out) :: error
      type(error_type), allocatable :: unreadable
      character(len=:), allocatable :: part, status
      logical :: is

      part = name // part_suffix
      is = is_folder(name)
      if (is) then
         call fatal(error, "the output file " // name // " is a folder", status_file)
         return
      end if
      is = file_exists(name)
      if (is .and. resume) return
      if (is .and. .not. force) then
         call fatal(error, name // " exists; --force replaces it, -o FILE writes another one", &
            status_file)
         return
      end if
      is = folder_writable(name)
      if (.not. is) then
         call fatal(error, "cannot write " // name // ": its folder does not exist or is not " // &
            "writable", status_file)
         return
      end if
      if (resume) return
      is = file_exists(part)
      if (.not. is) part = name // old_suffix
      is = file_exists(part)
      if (.not. is) return
      is = is_locked(part)
      if (is) then
         call fatal(error, "another run is writing " // part, status_file)
         return
      end if
      if (force) return
      call hdf5_readable_status(part, status, unreadable)
      if (allocated(unreadable)) status = ""
      is = is_resumable(name)
      if (is .and. status /= "failed") then
         if (status /= "interrupted") status = "killed"
         call fatal(error, part // " holds the rows of a run that was " // status // &
            "; --resume continues it, --force replaces it, -o FILE writes another one", status_file)
      else if (status == "interrupted" .or. status == "failed") then
         call fatal(error, part // " holds the rows of a run that was " // status // &
            "; --force replaces it, -o FILE writes another one", status_file)
      else if (.not. quiet) then
         call write_stderr("contensou: replacing " // part // ", left by a run that was killed" // &
            new_line("a"))
      end if
   end subroutine check_output

   !> After a failure to write: keep the partial file if its rows can be read, otherwise remove it.
   subroutine discard_unreadable(name, error)
      !> Name of the output file.
      character(len=*), intent(in) :: name
      !> The failure; its message is completed.
      type(error_type), allocatable, intent(inout) :: error
      type(error_type), allocatable :: unreadable
      character(len=:), allocatable :: status
      logical :: is

      is = file_exists(name // part_suffix)
      if (.not. is) return
      call hdf5_readable_status(name // part_suffix, status, unreadable)
      if (.not. allocated(unreadable)) then
         error%message = error%message // new_line("a") // "the rows written before are in " // &
            name // part_suffix
      else
         call remove_file(name // part_suffix, unreadable)
      end if
   end subroutine discard_unreadable

   !> A row is due.
   subroutine sample(self, motion, t, y, error)
      class(recorder_type), intent(inout) :: self
      class(motion_type), intent(inout) :: motion
      !> Time [s].
      real(wp), intent(in) :: t
      !> State.
      real(wp), intent(in) :: y(:)
      !> Set when the file cannot be written.
      type(error_type), allocatable, intent(out) :: error

      call self%output%row(motion%system, t, y, error)
   end subroutine sample

   !> A contact touched or lifted off.
   subroutine event(self, t, kind, contact, error)
      class(recorder_type), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> `event_touch` or `event_lift`.
      integer, intent(in) :: kind
      !> Index of the contact.
      integer, intent(in) :: contact
      !> Set when the file cannot be written.
      type(error_type), allocatable, intent(out) :: error

      if (kind == event_touch .and. self%first_contact == 0) then
         self%first_touch = t
         self%first_contact = contact
      end if
      call self%output%event(t, kind, contact, error)
   end subroutine event

   !> A step is done: signals, progress, flushing.
   subroutine after_step(self, t, stop_now, error)
      class(recorder_type), intent(inout) :: self
      !> Time reached [s].
      real(wp), intent(in) :: t
      !> Whether to stop here.
      logical, intent(out) :: stop_now
      !> Set when the file cannot be written.
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: share

      stop_now = signal_received() /= 0 .or. crew_stopping()
      self%steps = self%steps + 1
      if (self%steps < steps_between) return
      self%steps = 0
      share = min(t/self%t_end, 1.0_wp)
      if (self%progress%is_due(share)) call self%progress%tell(share, &
         "t = " // number_text(t, 4) // " s")
      self%keep_due = self%output%flush_is_due()
   end subroutine after_step

   !> The method has something to say: at once, and in the summary.
   subroutine advise(self, t, text)
      class(recorder_type), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> What it says.
      character(len=*), intent(in) :: text

      self%advice = "since t = " // number_text(t, 4) // " s " // text
      call self%progress%note(self%advice)
   end subroutine advise

   !> `auto` goes on with another method.
   subroutine change_method(self, t, method, reason)
      class(recorder_type), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> The method from here on.
      character(len=*), intent(in) :: method
      !> Why.
      character(len=*), intent(in) :: reason

      call self%output%use_method(t, method)
      self%changes = self%changes + 1
      if (self%changes == 1) self%first_change = method // " since t = " // number_text(t, 4) // &
         " s, because " // reason
   end subroutine change_method

   !> Print what the run comes down to.
   subroutine print_summary(scene, simulation, recorder, error)
      type(scene_type), intent(in) :: scene
      !> At its end, or where it was interrupted.
      type(simulation_type), intent(in) :: simulation
      type(recorder_type), intent(in) :: recorder
      !> Set when the standard output cannot be written.
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: y_start(simulation%motion%n), seconds(2)
      character(len=:), allocatable :: text
      integer :: i

      text = ""
      y_start = initial_state(scene, simulation%motion%n)
      seconds = recorder%output%elapsed()
      if (scene%title /= "") call line(scene%title)
      associate (s => recorder%output%summary, system => simulation%motion%system, &
         y => simulation%memory%y, statistics => simulation%memory%statistics)
         call line("  simulated  " // number_text(s%time, 8) // " s with " // &
            scene%integrator%method // " at rtol " // to_text(scene%integrator%rtol))
         if (allocated(recorder%output%choice)) call line("  auto       " // &
            recorder%output%choice)
         if (recorder%changes > 0) call line("  auto       " // recorder%first_change)
         if (recorder%changes > 1) call line("  auto       " // to_text(recorder%changes) // &
            " changes of the method in all")
         if (norm2(scene%gravity) > 0.0_wp) call line("  effects    gravity")
         do i = 1, size(scene%bodies)
            if (body_effects(scene%bodies(i)) /= "") call line("  effects    " // &
               scene%bodies(i)%name // ": " // body_effects(scene%bodies(i)))
         end do
         do i = 1, size(scene%contacts)
            call line("  effects    " // scene%contacts(i)%name // ": " // &
               contact_effects(scene, scene%contacts(i)))
         end do
         do i = 1, size(scene%bodies)
            call line("  body       " // scene%bodies(i)%name // ": axis " // tilt(y_start, i) // &
               " -> " // tilt(y, i) // " deg from vertical, spin about it " // &
               number_text(y_start(13*i), 5) // " -> " // number_text(y(13*i), 5) // " rad/s")
         end do
         if (recorder%first_contact > 0) then
            call line("  events     " // to_text(s%touches) // " touches, " // to_text(s%lifts) // &
               " lift-offs; first touch " // number_text(recorder%first_touch, 10) // " s, " // &
               scene%contacts(recorder%first_contact)%name)
         else
            call line("  events     " // to_text(s%touches) // " touches, " // to_text(s%lifts) // &
               " lift-offs")
         end if
         call line("  energy     " // number_text(s%initial_energy, 6) // " J at the start" // &
            lost(system%layout%friction, s%work_friction, "friction") // &
            lost(system%layout%damping, s%work_damping, &
            "damping") // supplied() // "; balance closed to " // &
            number_text(s%relative_error, 2))
         call line("  work       " // to_text(statistics%steps) // " steps, " // &
            to_text(statistics%derivatives) // " right-hand sides, " // &
            to_text(statistics%jacobians) // " Jacobians; " // number_text(seconds(2), 3) // &
            " s CPU, " // number_text(seconds(1), 3) // " s wall")
         if (allocated(recorder%output%cpu_by_effect)) call shares()
         if (allocated(recorder%advice)) call line("  advice     " // recorder%advice)
         if (simulation%stopped) then
            call line("  output     " // scene%output%file // part_suffix // " (interrupted), " // &
               to_text(s%rows) // " rows")
         else
            call line("  output     " // scene%output%file // ", " // to_text(s%rows) // " rows")
         end if
      end associate
      call write_stdout(text, error)

   contains

      !> Shares of the CPU time.
      subroutine shares()
         character(len=32) :: digits
         integer :: k

         associate (seconds => recorder%output%cpu_by_effect)
            call line("  CPU time   by effect, sampled")
            do k = 1, size(seconds)
               write(digits, "(f6.1, a, es9.2, a)") 100.0_wp*seconds(k) &
                  /max(sum(seconds), tiny(1.0_wp)), " %", seconds(k), " s"
               call line("    " // profile_names(k) // trim(digits))
            end do
         end associate
      end subroutine shares

      !> Energy that loads and drives supplied.
      function supplied() result(words)
         character(len=:), allocatable :: words

         words = ""
         if (simulation%motion%system%layout%applied > 0) words = ", " // &
            number_text(recorder%output%summary%work_applied, 5) // " J supplied"
      end function supplied

      !> Add a line.
      subroutine line(words)
         !> The line.
         character(len=*), intent(in) :: words

         text = text // words // new_line("a")
      end subroutine line

      !> Energy lost in an effect, if the run has the effect.
      function lost(index, work, effect) result(words)
         !> Index of the work in the state; 0 if the run does not have the effect.
         integer, intent(in) :: index
         !> Work [J].
         real(wp), intent(in) :: work
         !> Name of the effect.
         character(len=*), intent(in) :: effect
         character(len=:), allocatable :: words

         words = ""
         if (index > 0) words = ", " // number_text(work, 5) // " J lost in " // effect
      end function lost

      !> Angle between the z axis of a body and the vertical [deg].
      function tilt(state, body) result(angle)
         real(wp), intent(in) :: state(:)
         integer, intent(in) :: body
         character(len=:), allocatable :: angle
         type(pose_type) :: pose
         real(wp) :: quaternion(4)

         call simulation%motion%system%pose_of(state, body, pose, quaternion)
         associate (axis => pose%rotation(:, 3))
            angle = number_text(atan2(hypot(axis(1), axis(2)), axis(3))*180.0_wp/pi, 5)
         end associate
      end function tilt

   end subroutine print_summary

end module contensou_drivers_run
