!> `contensou run`: simulate a scene and write its output file.
module contensou_drivers_run
   use contensou_base_errors, only : error_type, fatal, status_file, status_interrupted, &
      status_usage
   use contensou_base_kinds, only : i8, pi, wp
   use contensou_base_numbers, only : counted, number_text, to_text
   use contensou_base_operating_system, only : catch_signals, check_writable, file_exists, &
      name_lock_type, signal_received, write_stderr, write_stdout
   use contensou_base_output_path, only : check_output_path
   use contensou_base_text, only : command_text, string_type, text_buffer_type
   use contensou_contact_geometry, only : pose_type
   use contensou_drivers_command_line, only : command_line_type, command_type, option_type, &
      quiet_option, set_option, strict_option, takes_non_negative
   use contensou_drivers_progress, only : progress_type
   use contensou_drivers_report, only : bodies_of, contacts_of, heed_warnings, in_series, &
      names_in_short, springs_of, stop_words
   use contensou_dynamics_assembly, only : initial_state
   use contensou_dynamics_scene, only : motion_fixed, scene_type
   use contensou_dynamics_state, only : position_of, spin_of, velocity_of
   use contensou_files_earlier, only : check_output, companions, earlier_type, find_earlier
   use contensou_files_recorder, only : recorder_type
   use contensou_files_trajectory, only : part_suffix
   use contensou_integrate_profile, only : profile_names
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

   character(len=*), parameter :: nl = new_line("a")

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

   !> Print what the run comes down to.
   subroutine print_summary(scene, simulation, recorder, error)
      type(scene_type), intent(in) :: scene
      !> At its end, or where it was interrupted.
      type(simulation_type), intent(in) :: simulation
      type(watch_type), intent(in) :: recorder
      !> Set when the standard output cannot be written.
      type(error_type), allocatable, intent(out) :: error
      type(text_buffer_type) :: text
      real(wp) :: seconds(2)

      seconds = recorder%output%elapsed()
      if (scene%title /= "") call text%add(scene%title // nl)
      associate (s => recorder%output%summary, layout => simulation%motion%system%layout, &
         statistics => simulation%memory%statistics)
         call line("simulated", number_text(s%time, 8) // " s with " // &
            scene%integrator%method // " at rtol " // to_text(scene%integrator%rtol))
         if (simulation%memory%stops%ended_by > 0) call line("stopped", &
            stop_words(scene, scene%stops(simulation%memory%stops%ended_by), &
            simulation%memory%stops%contact))
         if (allocated(recorder%output%choice)) call line("auto", recorder%output%choice)
         if (recorder%changes > 0) call line(merge("auto  ", "method", &
            scene%integrator%method == "auto"), recorder%first_change)
         if (recorder%changes > 1) call line("auto", to_text(recorder%changes) // &
            " changes of the method in all")
         call add_effects(scene, text)
         call add_bodies(scene, simulation, text)
         if (recorder%first_contact > 0) then
            call line("events", events(s%touches, s%lifts) // "; first touch " // &
               number_text(recorder%first_touch, 10) // " s, " // &
               scene%contacts(recorder%first_contact)%name)
         else
            call line("events", events(s%touches, s%lifts))
         end if
         call line("energy", number_text(s%initial_energy, 6) // " J at the start" // &
            energy(layout%friction, s%work_friction, "lost in friction") // &
            energy(layout%damping, s%work_damping, "lost in damping") // &
            energy(layout%applied, s%work_applied, "supplied") // &
            "; balance closed to " // number_text(s%relative_error, 2))
         call line("work", counted(statistics%steps, "step") // ", " // &
            counted(statistics%derivatives, "right-hand side") // ", " // &
            counted(statistics%jacobians, "Jacobian") // "; " // number_text(seconds(2), 3) // &
            " s CPU, " // number_text(seconds(1), 3) // " s wall")
         if (allocated(recorder%output%cpu_by_effect)) call add_shares( &
            recorder%output%cpu_by_effect, text)
         if (allocated(recorder%advice)) call line("advice", recorder%advice)
         if (allocated(recorder%output%warning)) call line("warning", recorder%output%warning)
         if (simulation%stopped) then
            call line("output", scene%output%file // part_suffix // " (interrupted), " // &
               counted(s%rows, "row"))
         else
            call line("output", scene%output%file // ", " // counted(s%rows, "row"))
         end if
      end associate
      call write_stdout(text%text(), error)

   contains

      !> Add a line.
      subroutine line(word, words)
         !> What it is about.
         character(len=*), intent(in) :: word
         character(len=*), intent(in) :: words

         call add_line(text, word, words)
      end subroutine line

      !> Events in words.
      function events(touches, lifts) result(words)
         integer(i8), intent(in) :: touches
         !> Lift-offs.
         integer(i8), intent(in) :: lifts
         character(len=:), allocatable :: words

         words = counted(touches, "touch", "touches") // ", " // counted(lifts, "lift-off")
      end function events

      !> Energy that an effect takes or supplies, if the run has the effect.
      function energy(index, work, what) result(words)
         !> Index of the work in the state; 0 if the run does not have the effect.
         integer, intent(in) :: index
         !> Work [J].
         real(wp), intent(in) :: work
         character(len=*), intent(in) :: what
         character(len=:), allocatable :: words

         words = ""
         if (index > 0) words = ", " // number_text(work, 5) // " J " // what
      end function energy

   end subroutine print_summary

   !> Add a line of the summary.
   subroutine add_line(text, word, words)
      type(text_buffer_type), intent(inout) :: text
      !> What it is about.
      character(len=*), intent(in) :: word
      character(len=*), intent(in) :: words
      character(len=11) :: column

      column = word
      call text%add("  " // column // words // nl)
   end subroutine add_line

   !> Add what acts on bodies and in contacts.
   subroutine add_effects(scene, text)
      type(scene_type), intent(in) :: scene
      type(text_buffer_type), intent(inout) :: text
      type(string_type), allocatable :: lines(:)
      integer :: i

      if (norm2(scene%gravity) > 0.0_wp) call add_line(text, "effects", "gravity")
      call bodies_of(scene, lines)
      do i = 1, size(lines)
         call add_line(text, "effects", lines(i)%s)
      end do
      call contacts_of(scene, lines)
      do i = 1, size(lines)
         call add_line(text, "effects", lines(i)%s)
      end do
      call springs_of(scene, lines)
      do i = 1, size(lines)
         call add_line(text, "spring", lines(i)%s)
      end do
      if (scene%together) call add_line(text, "effects", "simultaneous impacts")
   end subroutine add_effects

   !> Add where the bodies came to, and how they turned: for those of a long series whose names
   !> differ in a number only the bounds of that.
   subroutine add_bodies(scene, simulation, text)
      type(scene_type), intent(in) :: scene
      type(simulation_type), intent(in) :: simulation
      type(text_buffer_type), intent(inout) :: text
      integer, parameter :: series = 4, most = 12
      type(string_type) :: names(size(scene%bodies))
      real(wp) :: y_start(simulation%motion%n)
      logical :: left(size(names)), alike(size(names)), many
      integer :: i, k

      y_start = initial_state(scene, simulation%motion%n)
      do i = 1, size(names)
         names(i)%s = scene%bodies(i)%name
      end do
      left = .true.
      many = size(names) > most
      do i = 1, size(names)
         if (.not. left(i)) cycle
         do k = 1, size(names)
            alike(k) = left(k) .and. (k == i .or. in_series(names(k)%s, names(i)%s))
         end do
         if (count(alike) < series) alike = [(k == i, k=1, size(names))]
         left = left .and. .not. alike
         associate (y => simulation%memory%y)
            if (count(alike) > 1) then
               call add_line(text, "bodies", names_in_short(names, alike) // ": " // &
                  bounds(y, alike))
               cycle
            end if
            if (scene%bodies(i)%motion == motion_fixed) cycle
            call add_line(text, "body", names(i)%s // ": at " // three(position_of(y, i)) // &
               " m, velocity " // three(velocity_of(y, i)) // " m/s")
            if (many) cycle
            if (is_round(scene%bodies(i)%inertia)) then
               call add_line(text, "", names(i)%s // ": angular velocity " // &
                  three(turning(y_start)) // " -> " // three(turning(y)) // " rad/s")
               cycle
            end if
            call add_line(text, "", names(i)%s // ": axis " // tilt(y_start) // &
               " -> " // tilt(y) // " deg from vertical, spin about it " // &
               number_text(y_start(13*i), 5) // " -> " // number_text(y(13*i), 5) // " rad/s")
         end associate
      end do

   contains

      !> Bounds of where some bodies are and how fast.
      function bounds(y, chosen) result(words)
         real(wp), intent(in) :: y(:)
         !> Which bodies.
         logical, intent(in) :: chosen(:)
         character(len=:), allocatable :: words
         real(wp) :: low(5), high(5), value(5)
         integer :: body, component

         low = huge(low)
         high = -huge(high)
         do body = 1, size(chosen)
            if (.not. chosen(body)) cycle
            value = [position_of(y, body), norm2(velocity_of(y, body)), norm2(spin_of(y, body))]
            low = min(low, value)
            high = max(high, value)
         end do
         words = "x"
         do component = 1, 5
            if (component > 1 .and. component < 4) words = words // ", " // &
               "xyz"(component:component)
            if (component == 4) words = words // " m, speed"
            if (component == 5) words = words // " m/s, turning at"
            words = words // " " // number_text(low(component), 4) // " to " // &
               number_text(high(component), 4)
         end do
         words = words // " rad/s"
      end function bounds

      !> Three numbers in brackets.
      function three(x) result(words)
         real(wp), intent(in) :: x(3)
         character(len=:), allocatable :: words
         real(wp) :: shown(3)

         ! What rounding leaves of a zero is none.
         shown = merge(x, 0.0_wp, abs(x) > 1.0e-14_wp*norm2(x))
         words = "("
         do k = 1, 3
            if (k > 1) words = words // ", "
            if (abs(shown(k)) > 0.0_wp) then
               words = words // number_text(shown(k), 6)
            else
               words = words // "0"
            end if
         end do
         words = words // ")"
      end function three

      !> Whether no axis of a body differs from others.
      pure logical function is_round(inertia)
         !> Principal moments [kg m2].
         real(wp), intent(in) :: inertia(3)

         is_round = maxval(inertia) - minval(inertia) <= 1.0e-12_wp*maxval(inertia)
      end function is_round

      !> Angular velocity of the body in the inertial frame [rad/s].
      function turning(state) result(rate)
         real(wp), intent(in) :: state(:)
         real(wp) :: rate(3)
         type(pose_type) :: pose
         real(wp) :: quaternion(4)

         call simulation%motion%system%pose_of(state, i, pose, quaternion)
         rate = matmul(pose%rotation, spin_of(state, i))
      end function turning

      !> Angle between the z axis of the body and the vertical [deg].
      function tilt(state) result(angle)
         real(wp), intent(in) :: state(:)
         character(len=:), allocatable :: angle
         type(pose_type) :: pose
         real(wp) :: quaternion(4)

         call simulation%motion%system%pose_of(state, i, pose, quaternion)
         associate (axis => pose%rotation(:, 3))
            angle = number_text(atan2(hypot(axis(1), axis(2)), axis(3))*180.0_wp/pi, 5)
         end associate
      end function tilt

   end subroutine add_bodies

   !> Add the shares of the CPU time.
   subroutine add_shares(seconds, text)
      !> CPU time by effect [s].
      real(wp), intent(in) :: seconds(:)
      type(text_buffer_type), intent(inout) :: text
      character(len=32) :: digits
      integer :: i

      call add_line(text, "CPU time", "by effect, sampled")
      do i = 1, size(seconds)
         write(digits, "(f6.1, a, es9.2, a)") 100.0_wp*seconds(i) &
            /max(sum(seconds), tiny(1.0_wp)), " %", seconds(i), " s"
         call text%add("    " // profile_names(i) // trim(digits) // nl)
      end do
   end subroutine add_shares

end module contensou_drivers_run
