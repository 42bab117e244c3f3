!> `contensou check`, `contensou models`, `contensou help`: what the program knows, in words.
module contensou_drivers_inform
   use contensou_base_build, only : build_compiler, git_commit, program_version
   use contensou_base_errors, only : error_type, fatal, status_usage
   use contensou_base_kinds, only : i8, wp
   use contensou_base_operating_system, only : cpu_seconds, write_stdout
   use contensou_base_settings, only : domain_text, key_type, kind_choice, kind_logical, &
      kind_name, kind_real, kind_reference
   use contensou_base_text, only : join, lower, nearest, number_text, quote, string_type, to_text
   use contensou_contact_catalogue, only : model_info_type
   use contensou_contact_damping, only : damping_model_type, damping_models
   use contensou_contact_friction, only : friction_model_type, friction_models
   use contensou_contact_pairs, only : geometry_models
   use contensou_contact_hertz, only : hertz_model_type
   use contensou_contact_normal, only : normal_models
   use contensou_contact_rolling, only : rolling_models
   use contensou_contact_vilke, only : vilke_models
   use contensou_drivers_command_line, only : command_line_type, command_type, option_type, &
      set_option, usage_text
   use contensou_drivers_sweep_check, only : check_sweep
   use contensou_drivers_report, only : bodies_text, body_effects, contact_effects
   use contensou_integrate_cvode, only : sundials_version
   use contensou_integrate_march, only : observer_type, row_count
   use contensou_files_hdf5_file, only : hdf5_version
   use contensou_scene_reader, only : read_scene, scene_file_type
   use contensou_scene_schema, only : choices_of, group_spec_type, schema_groups, schema_keys
   use contensou_sweep_reader, only : is_sweep_file
   use contensou_sweep_schema, only : any_number, kind_any, kind_whole, sweep_domain, &
      sweep_groups, sweep_keys
   use contensou_special_gsl, only : gsl_version
   use contensou_study_simulation, only : new_simulation, simulate, simulation_type
   implicit none(type, external)
   private

   public :: check_command, models_command, help_command, version_command

   !> What `contensou check` takes.
   type(option_type), parameter :: check_options(*) = [ &
      option_type("SCENE", "", "namelist file of a scene or a sweep", needs="a scene"), &
      set_option, &
      option_type("--expand", "", "print only the scene that is run, with all settings and " // &
      "every bearing expanded; it is legal and gives the same run")]

   !> What `contensou models` takes.
   type(option_type), parameter :: models_options(*) = [ &
      option_type("NAME", "", "only this model")]

   !> What `contensou help` takes.
   type(option_type), parameter :: help_options(*) = [ &
      option_type("TOPIC", "", "GROUP or GROUP.KEY of a scene or a sweep, or a command")]

   !> What the user asks of `check`.
   type :: check_config_type
      !> Name of the scene or sweep.
      character(len=:), allocatable :: scene
      !> Settings that replace those of the scene.
      type(string_type), allocatable :: overrides(:)
      !> Whether to print the scene with all settings and patterns expanded, no more.
      logical :: expand = .false.
   end type check_config_type

   !> Observer that lets a march run for a given CPU time.
   type, extends(observer_type) :: stopwatch_type
      !> CPU time at which to stop [s].
      real(wp) :: deadline = 0.0_wp
   contains
      procedure :: after_step
   end type stopwatch_type

   !> CPU time that `check` spends on a trial [s].
   real(wp), parameter :: trial_cpu = 0.2_wp

   !> End of a line.
   character(len=*), parameter :: nl = new_line("a")

contains

   !> `contensou check` in the table of commands.
   function check_command() result(command)
      type(command_type) :: command

      command = command_type("check", "read a scene or sweep, report its effects and their cost", &
         check_options, "reads and resolves the scene, reports its effects and their cost, " // &
         "writes nothing", execute=check)
   end function check_command

   !> Read a scene or a sweep and report what it does and what that costs.
   subroutine check(line, error)
      type(command_line_type), intent(in) :: line
      !> Set when the scene has a mistake.
      type(error_type), allocatable, intent(out) :: error
      type(check_config_type) :: config
      type(scene_file_type) :: file
      character(len=:), allocatable :: text
      integer :: i, nb
      logical :: of_sweep

      config%scene = line%text("SCENE")
      config%overrides = line%texts("--set")
      config%expand = line%has("--expand")
      of_sweep = is_sweep_file(config%scene)
      if (of_sweep .and. config%expand) then
         call fatal(error, "--expand goes with a scene, not with a sweep", status_usage)
      else if (of_sweep) then
         call check_sweep(config%scene, config%overrides, error)
      end if
      if (of_sweep) return
      call read_scene(config%scene, config%overrides, "", file, error)
      if (allocated(error)) return
      if (config%expand) then
         call write_stdout(file%resolved, error)
         return
      end if
      associate (scene => file%scene, system => file%system)
         nb = size(scene%bodies)
         text = config%scene // " is in order" // nl
         if (scene%title /= "") text = text // "  " // scene%title // nl
         text = text // "effects" // nl
         if (norm2(scene%gravity) > 0.0_wp) text = text // "  gravity    " // &
            number_text(norm2(scene%gravity), 5) // " m/s2" // nl
         text = text // "  bodies     " // bodies_text(scene) // nl
         do i = 1, nb
            if (body_effects(scene%bodies(i)) /= "") text = text // "  body       " // &
               scene%bodies(i)%name // ": " // body_effects(scene%bodies(i)) // nl
         end do
         do i = 1, size(scene%contacts)
            text = text // "  contact    " // scene%contacts(i)%name // ": " // &
               contact_effects(scene, scene%contacts(i)) // nl
         end do
         if (size(scene%contacts) == 0) text = text // "  contact    none" // nl
         text = text // "  unknowns   " // to_text(system%layout%n) // ": 13 for each body"
         if (system%layout%friction > 0) text = text // ", work of friction"
         if (system%layout%damping > 0) text = text // ", work of damping"
         if (system%layout%applied > 0) text = text // ", work supplied"
         text = text // nl // "cost" // nl // cost_text(file)
         text = text // "settings" // nl // indented(file%resolved)
      end associate
      call write_stdout(text, error)
   end subroutine check

   !> Cost of a scene, measured.
   function cost_text(file) result(text)
      type(scene_file_type), intent(in) :: file
      character(len=:), allocatable :: text
      type(simulation_type) :: simulation
      type(stopwatch_type) :: stopwatch
      type(error_type), allocatable :: error
      real(wp), allocatable :: y(:), rate(:)
      real(wp) :: start, elapsed
      integer :: i, n
      logical :: outside

      text = ""
      call new_simulation(file, simulation, error)
      if (file%scene%integrator%method == "auto") text = "  auto             " // &
         simulation%reason() // nl
      y = simulation%state()
      allocate(rate(size(y)))
      n = 0
      start = cpu_seconds()
      do
         do i = 1, 1000
            call simulation%motion%derivative(0.0_wp, y, rate, outside)
         end do
         n = n + 1000
         elapsed = cpu_seconds() - start
         if (elapsed > 0.01_wp) exit
      end do
      text = text // "  right-hand side  " // number_text(elapsed/n*1.0e9_wp, 3) // &
         " ns in the initial state" // nl
      associate (scene => file%scene, statistics => simulation%memory%statistics, &
         t => simulation%memory%t)
         stopwatch%deadline = cpu_seconds() + trial_cpu
         if (.not. allocated(error)) call simulate(simulation, stopwatch, error)
         if (allocated(error)) then
            text = text // "  a trial failed at t = " // number_text(t, 6) // " s: " // &
               simulation%failure // nl
         else if (t > 0.0_wp) then
            text = text // "  trial            " // to_text(statistics%steps) // " steps and " // &
               to_text(statistics%derivatives) // " right-hand sides to t = " // &
               number_text(t, 4) // " s in " // number_text(simulation%cpu, 3) // " s of CPU" // nl
            text = text // "  whole run        about " // &
               number_text(simulation%cpu*scene%t_end/t, 2) // " s of CPU at this rate" // nl
         end if
         text = text // "  output           " // to_text(row_count(scene%t_end, &
            scene%output%interval) + 1_i8) // " rows, " // number_text(8.0e-6_wp*row_count( &
            scene%t_end, scene%output%interval)*(7 + 13*size(scene%bodies) + &
            13*size(scene%contacts)), 2) // " MB" // nl
      end associate
   end function cost_text

   !> Stop when the time is over.
   subroutine after_step(self, t, stop_now, error)
      class(stopwatch_type), intent(inout) :: self
      !> Time reached [s].
      real(wp), intent(in) :: t
      !> Whether the CPU time is spent.
      logical, intent(out) :: stop_now
      !> Never set.
      type(error_type), allocatable, intent(out) :: error

      stop_now = cpu_seconds() > self%deadline
   end subroutine after_step

   !> `contensou models` in the table of commands.
   function models_command() result(command)
      type(command_type) :: command

      command = command_type("models", "the models that a scene can name", models_options, &
         execute=list_models)
   end function models_command

   !> List the models.
   subroutine list_models(line, error)
      type(command_line_type), intent(in) :: line
      !> Set when there is no such model.
      type(error_type), allocatable, intent(out) :: error
      type(damping_model_type), allocatable :: damping(:)
      type(friction_model_type), allocatable :: friction(:)
      type(hertz_model_type), allocatable :: vilke(:)
      character(len=:), allocatable :: name, text
      character(len=24) :: names(64)
      integer :: near, n

      name = line%text("NAME")
      damping = damping_models()
      friction = friction_models()
      vilke = vilke_models()
      text = ""
      n = 0
      call list("surfaces (contact.surfaces)", geometry_models())
      call list("normal force (contact.normal)", normal_models())
      call list("damping (contact.damping)", damping%info)
      call list("spot of vilke (contact.ellipse)", vilke%info)
      call list("friction (contact.friction)", friction%info)
      call list("rolling resistance (contact.rolling)", rolling_models())
      if (text == "") then
         near = nearest(name, names(:n))
         if (near > 0) then
            call fatal(error, "there is no model " // quote(name) // &
               "; did you mean " // quote(trim(names(near))) // "?", status_usage)
         else
            call fatal(error, "there is no model " // quote(name) // &
               "; contensou models lists them", status_usage)
         end if
         return
      end if
      call write_stdout(text, error)

   contains

      !> Add a table, or the entry that is asked for.
      subroutine list(title, info)
         !> Title of the table.
         character(len=*), intent(in) :: title
         !> Its entries.
         type(model_info_type), intent(in) :: info(:)
         integer :: i
         logical :: first

         first = .true.
         do i = 1, size(info)
            n = n + 1
            names(n) = info(i)%name
            if (name /= "" .and. lower(name) /= info(i)%name) cycle
            if (first) text = text // title // nl
            first = .false.
            text = text // "  " // trim(info(i)%name) // nl
            text = text // "      " // trim(info(i)%summary) // nl
            if (info(i)%keys /= "") text = text // "      keys: " // trim(info(i)%keys) // nl
            if (info(i)%reference /= "") text = text // "      reference: " // &
               trim(info(i)%reference) // nl
         end do
      end subroutine list

   end subroutine list_models

   !> `contensou help` in the table of commands.
   function help_command() result(command)
      type(command_type) :: command

      command = command_type("help", "what a key of a scene or a sweep means", help_options, &
         execute=explain)
   end function help_command

   !> Explain a group or key of a scene or a sweep, or a command.
   subroutine explain(line, error)
      type(command_line_type), intent(in) :: line
      !> Set when there is no such group or key.
      type(error_type), allocatable, intent(out) :: error
      type(group_spec_type), allocatable :: groups(:)
      type(key_type), allocatable :: keys(:), own(:)
      character(len=:), allocatable :: topic, text, group, key
      integer :: c, g, k, dot

      topic = line%text("TOPIC")
      groups = [schema_groups(), sweep_groups()]
      c = findloc(line%commands%name == topic, .true., dim=1)
      ! What is a group, too, is explained as that.
      if (topic /= "" .and. c > 0 .and. all(groups%name /= topic)) then
         call write_stdout(usage_text(line%commands(c)) // nl, error)
         return
      end if
      keys = [schema_keys(), sweep_keys()]
      dot = index(topic, ".")
      if (dot == 0) dot = len(topic) + 1
      group = lower(topic(:dot - 1))
      key = lower(topic(min(dot + 1, len(topic) + 1):))
      if (group == "") then
         text = "A scene is a Fortran namelist file: groups &name key = value ... /, SI units." // &
            nl
         do g = 1, size(groups)
            if (groups(g)%name == "sweep") text = text // nl // &
               "A sweep is a file of its own, with these groups." // nl
            text = text // nl // group_text(groups(g))
            own = pack(keys, keys%group == groups(g)%name)
            do k = 1, size(own)
               text = text // "    " // own(k)%name // short_domain(own(k)) // nl
            end do
         end do
         text = text // nl // "contensou help GROUP.KEY tells more." // nl
         call write_stdout(text, error)
         return
      end if
      g = findloc(groups%name == group, .true., dim=1)
      if (g == 0) then
         g = nearest(group, groups%name)
         if (g > 0) then
            call fatal(error, "a scene or sweep has no group " // quote(group) // &
               "; did you mean " // &
               quote(trim(groups(g)%name)) // "?", status_usage)
         else
            call fatal(error, "a scene or sweep has no group " // quote(group) // &
               "; contensou help lists them", status_usage)
         end if
         return
      end if
      own = pack(keys, keys%group == group)
      if (key == "") then
         text = group_text(groups(g))
         do k = 1, size(own)
            text = text // nl // key_text(own(k))
         end do
         if (any(line%commands%name == group)) text = text // nl // "contensou " // group // &
            " --help tells about the command." // nl
      else
         k = findloc(own%name == key, .true., dim=1)
         if (k == 0) then
            k = nearest(key, own%name)
            if (k > 0) then
               call fatal(error, "group " // quote(group) // " has no key " // quote(key) // &
                  "; did you mean " // quote(trim(own(k)%name)) // "?", status_usage)
            else
               call fatal(error, "group " // quote(group) // " has no key " // quote(key) // &
                  "; contensou help " // group // " lists them", status_usage)
            end if
            return
         end if
         text = key_text(own(k))
      end if
      call write_stdout(text, error)
   end subroutine explain

   !> A group in a line.
   pure function group_text(group) result(text)
      type(group_spec_type), intent(in) :: group
      character(len=:), allocatable :: text

      text = "&" // trim(group%name) // ": " // trim(group%doc)
      if (group%repeats) text = text // "; repeats"
      if (.not. group%repeats .and. .not. group%mandatory) text = text // "; may be left out"
      text = text // nl
   end function group_text

   !> Values and unit of a key in a few words.
   function short_domain(key) result(text)
      type(key_type), intent(in) :: key
      character(len=:), allocatable :: text

      select case (key%kind)
      case (kind_whole, kind_any)
         text = sweep_domain(key)
      case (kind_real)
         text = domain_text(key)
      case (kind_choice)
         text = join(choices_of(key), " | ")
         if (text == "") text = sweep_domain(key)
      case (kind_logical)
         text = ".true. | .false."
      case (kind_reference)
         text = "name of a " // trim(key%target)
         if (key%values == 2) text = "names of two " // trim(key%target) // "s"
      case (kind_name)
         text = "a name"
      case default
         text = "a text"
         if (key%values == any_number) text = sweep_domain(key)
      end select
      if (key%mandatory) then
         text = text // ", mandatory"
      else if (key%default /= "") then
         text = text // ", default " // trim(key%default)
      end if
   end function short_domain

   !> All about a key.
   function key_text(key) result(text)
      type(key_type), intent(in) :: key
      character(len=:), allocatable :: text

      text = trim(key%group) // "." // trim(key%name) // nl // "    " // trim(key%doc) // nl // &
         "    " // short_domain(key) // nl
   end function key_text

   !> `contensou version` in the table of commands.
   function version_command() result(command)
      type(command_type) :: command

      command = command_type("version", "version of the program", [option_type ::], &
         alias="--version", execute=print_version)
   end function version_command

   !> Version of the program and of what it is built with.
   subroutine print_version(line, error)
      type(command_line_type), intent(in) :: line
      !> Set when the standard output cannot be written.
      type(error_type), allocatable, intent(out) :: error

      call write_stdout("contensou " // program_version // nl // &
         "commit " // git_commit() // nl // build_compiler // &
         ", SUNDIALS " // sundials_version() // ", HDF5 " // hdf5_version() // &
         ", GSL " // gsl_version() // nl, error)
   end subroutine print_version

   !> Text with each line indented.
   pure function indented(text) result(shifted)
      !> Text, its lines ended.
      character(len=*), intent(in) :: text
      character(len=:), allocatable :: shifted
      integer :: start, length

      shifted = ""
      start = 1
      do while (start <= len(text))
         length = index(text(start:), nl)
         if (length == 0) length = len(text) - start + 1
         shifted = shifted // "  " // text(start:start + length - 1)
         start = start + length
      end do
   end function indented

end module contensou_drivers_inform
