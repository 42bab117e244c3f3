!> `contensou check`: what a scene does and what that costs.
module contensou_drivers_check
   use contensou_base_errors, only : error_type, fatal, status_usage
   use contensou_base_kinds, only : i8, wp
   use contensou_base_numbers, only : number_text, to_text
   use contensou_base_operating_system, only : cpu_seconds, is_terminal, write_stdout
   use contensou_base_text, only : string_type, text_buffer_type
   use contensou_drivers_command_line, only : command_line_type, command_type, option_type, &
      set_option, strict_option
   use contensou_drivers_report, only : bodies_of, bodies_text, contacts_of, heed_warnings, &
      springs_of
   use contensou_drivers_sweep_check, only : check_sweep
   use contensou_integrate_memory, only : row_count
   use contensou_integrate_observer, only : observer_type
   use contensou_scene_reader, only : read_scene, scene_file_type
   use contensou_study_quantities, only : row_type
   use contensou_study_simulation, only : new_simulation, simulate, simulation_type
   use contensou_sweep_reader, only : is_sweep_file
   implicit none(type, external)
   private

   public :: check_command

   type(option_type), parameter :: options(*) = [ &
      option_type("SCENE", "", "namelist file of a scene or a sweep", needs="a scene"), &
      set_option, strict_option, &
      option_type("--expand", "", "print only the scene that is run, with all settings and " // &
      "every bearing expanded; it is legal and gives the same run")]

   !> What the user asks for, in the words of the options.
   type :: check_config_type
      character(len=:), allocatable :: scene
      type(string_type), allocatable :: overrides(:)
      logical :: expand = .false.
   end type check_config_type

   !> Observer that lets a march run for a given CPU time.
   type, extends(observer_type) :: stopwatch_type
      !> CPU time at which to stop [s].
      real(wp) :: deadline = 0.0_wp
   contains
      procedure :: after_step
   end type stopwatch_type

   !> Number of unknowns from which a Jacobian is not factorized for a trial: nothing stops it on
   !> the way, and it takes more than proportionally long.
   integer, parameter :: most_unknowns = 10000

   !> CPU time that `check` spends on a trial [s].
   real(wp), parameter :: trial_cpu = 0.2_wp

   character(len=*), parameter :: nl = new_line("a")

contains

   !> `contensou check` in the table of commands.
   function check_command() result(command)
      type(command_type) :: command

      command = command_type("check", "read a scene or sweep, report its effects and their cost", &
         options, "reads and resolves the scene, reports its effects and their cost, " // &
         "writes nothing", execute=check)
   end function check_command

   !> Read a scene or a sweep and report what it does and what that costs.
   subroutine check(line, error)
      type(command_line_type), intent(in) :: line
      !> Set when the scene has a mistake.
      type(error_type), allocatable, intent(out) :: error
      type(check_config_type) :: config
      type(scene_file_type) :: file
      type(text_buffer_type) :: text
      type(string_type), allocatable :: lines(:)
      integer :: i
      logical :: of_sweep

      config%scene = line%text("SCENE")
      config%overrides = line%texts("--set")
      config%expand = line%has("--expand")
      of_sweep = is_sweep_file(config%scene)
      if (of_sweep .and. config%expand) then
         call fatal(error, "--expand goes with a scene, not with a sweep", status_usage)
      else if (of_sweep) then
         call check_sweep(config%scene, config%overrides, line%has("--strict"), error)
      end if
      if (of_sweep) return
      call read_scene(config%scene, config%overrides, "", file, error)
      if (allocated(error)) return
      call heed_warnings(file, config%scene, line%has("--strict"), error)
      if (allocated(error)) return
      if (config%expand) then
         call write_stdout(file%resolved, error, as_is=.not. is_terminal(1))
         return
      end if
      associate (scene => file%scene, system => file%system)
         call text%add(config%scene // " is in order" // nl)
         if (scene%title /= "") call text%add("  " // scene%title // nl)
         call text%add("effects" // nl)
         if (norm2(scene%gravity) > 0.0_wp) call text%add("  gravity    " // &
            number_text(norm2(scene%gravity), 5) // " m/s2" // nl)
         call text%add("  bodies     " // bodies_text(scene) // nl)
         call bodies_of(scene, lines)
         do i = 1, size(lines)
            call text%add("  body       " // lines(i)%s // nl)
         end do
         call contacts_of(scene, lines)
         do i = 1, size(lines)
            call text%add("  contact    " // lines(i)%s // nl)
         end do
         if (size(scene%contacts) == 0) call text%add("  contact    none" // nl)
         call springs_of(scene, lines)
         do i = 1, size(lines)
            call text%add("  spring     " // lines(i)%s // nl)
         end do
         if (scene%together) call text%add("  impacts    simultaneous" // nl)
         call text%add("  unknowns   " // to_text(system%layout%n) // ": 13 for each body")
         if (system%layout%friction > 0) call text%add(", work of friction")
         if (system%layout%damping > 0) call text%add(", work of damping")
         if (system%layout%applied > 0) call text%add(", work supplied")
         call text%add(nl // "cost" // nl // cost_text(file))
         call text%add("settings" // nl // indented(file%resolved))
      end associate
      call write_stdout(text%text(), error)
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
      type(row_type) :: row
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
         do i = 1, n + 1
            call simulation%motion%derivative(0.0_wp, y, rate, outside)
         end do
         n = 2*n + 1
         elapsed = cpu_seconds() - start
         if (elapsed > 0.01_wp) exit
      end do
      text = text // "  right-hand side  " // number_text(elapsed/n*1.0e9_wp, 3) // &
         " ns in the initial state" // nl
      call row%prepare(simulation%motion%system, file%scene%output)
      associate (scene => file%scene, statistics => simulation%memory%statistics, &
         t => simulation%memory%t)
         stopwatch%deadline = cpu_seconds() + trial_cpu
         if (size(y) > most_unknowns .and. any(scene%integrator%method == &
            [character(len=9) :: "cvode_bdf", "auto"])) then
            text = text // "  trial            none: with " // to_text(size(y)) // &
               " unknowns its first Jacobian would be factorized for longer than that" // nl
         else if (.not. allocated(error)) then
            call simulate(simulation, stopwatch, error)
         end if
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
            scene%output%interval) + 1_i8) // " rows, " // number_text(1.0e-6_wp*row%bytes()* &
            (row_count(scene%t_end, scene%output%interval) + 1_i8), 2) // " MB" // nl
      end associate
   end function cost_text

   !> Stop when the time is over.
   subroutine after_step(self, t, stop_now, error)
      class(stopwatch_type), intent(inout) :: self
      real(wp), intent(in) :: t
      !> Whether the CPU time is spent.
      logical, intent(out) :: stop_now
      type(error_type), allocatable, intent(out) :: error

      stop_now = cpu_seconds() > self%deadline
   end subroutine after_step

   !> Text with each line indented.
   pure function indented(text) result(shifted)
      !> Text, its lines ended.
      character(len=*), intent(in) :: text
      character(len=:), allocatable :: shifted
      type(text_buffer_type) :: buffer
      integer :: start, length

      start = 1
      do while (start <= len(text))
         length = index(text(start:), nl)
         if (length == 0) length = len(text) - start + 1
         call buffer%add("  " // text(start:start + length - 1))
         start = start + length
      end do
      shifted = buffer%text()
   end function indented

end module contensou_drivers_check
