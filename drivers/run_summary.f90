!> What `contensou run` prints at the end: effects, bodies, events, energies, work.
module contensou_drivers_run_summary
   use contensou_base_errors, only : error_type
   use contensou_base_kinds, only : i8, pi, wp
   use contensou_base_numbers, only : counted, number_text, to_text
   use contensou_base_operating_system, only : write_stdout
   use contensou_base_text, only : string_type, text_buffer_type
   use contensou_contact_geometry, only : pose_type
   use contensou_drivers_report, only : bodies_of, contacts_of, in_series, names_in_short, &
      springs_of, stop_words
   use contensou_dynamics_assembly, only : initial_state
   use contensou_dynamics_equations, only : system_type
   use contensou_dynamics_scene, only : motion_fixed, scene_type
   use contensou_dynamics_state, only : position_of, spin_of, velocity_of
   use contensou_files_recorder, only : recorder_type
   use contensou_files_trajectory, only : part_suffix
   use contensou_integrate_profile, only : profile_names
   use contensou_study_simulation, only : simulation_type
   implicit none(type, external)
   private

   public :: print_summary

   character(len=*), parameter :: nl = new_line("a")

contains

   !> Print what the run comes down to.
   subroutine print_summary(scene, simulation, recorder, error)
      type(scene_type), intent(in) :: scene
      !> At its end, or where it was interrupted.
      type(simulation_type), intent(in) :: simulation
      class(recorder_type), intent(in) :: recorder
      !> Set when the standard output cannot be written.
      type(error_type), allocatable, intent(out) :: error
      type(text_buffer_type) :: text
      real(wp) :: seconds(2)

      seconds = recorder%output%elapsed()
      if (scene%title /= "") call text%add(scene%title // nl)
      associate (s => recorder%output%summary, layout => simulation%motion%system%layout, &
         statistics => simulation%memory%statistics)
         call add_line(text, "simulated", number_text(s%time, 8) // " s with " // &
            scene%integrator%method // " at rtol " // to_text(scene%integrator%rtol))
         if (simulation%memory%stops%ended_by > 0) call add_line(text, "stopped", &
            stop_words(scene, scene%stops(simulation%memory%stops%ended_by), &
            simulation%memory%stops%contact))
         if (allocated(recorder%output%choice)) call add_line(text, "auto", recorder%output%choice)
         if (recorder%changes > 0) call add_line(text, merge("auto  ", "method", &
            scene%integrator%method == "auto"), recorder%first_change)
         if (recorder%changes > 1) call add_line(text, "auto", to_text(recorder%changes) // &
            " changes of the method in all")
         call add_effects(scene, text)
         call add_bodies(scene, simulation, text)
         if (recorder%first_contact > 0) then
            call add_line(text, "events", events(s%touches, s%lifts) // "; first touch " // &
               number_text(recorder%first_touch, 10) // " s, " // &
               scene%contacts(recorder%first_contact)%name)
         else
            call add_line(text, "events", events(s%touches, s%lifts))
         end if
         call add_line(text, "energy", number_text(s%initial_energy, 6) // " J at the start" // &
            energy(layout%friction, s%work_friction, "lost in friction") // &
            energy(layout%damping, s%work_damping, "lost in damping") // &
            energy(layout%applied, s%work_applied, "supplied") // &
            "; balance closed to " // number_text(s%relative_error, 2))
         call add_line(text, "work", counted(statistics%steps, "step") // ", " // &
            counted(statistics%derivatives, "right-hand side") // ", " // &
            counted(statistics%jacobians, "Jacobian") // "; " // number_text(seconds(2), 3) // &
            " s CPU, " // number_text(seconds(1), 3) // " s wall")
         if (allocated(recorder%output%cpu_by_effect)) call add_shares( &
            recorder%output%cpu_by_effect, text)
         if (allocated(recorder%advice)) call add_line(text, "advice", recorder%advice)
         if (allocated(recorder%output%warning)) call add_line(text, "warning", &
            recorder%output%warning)
         if (simulation%stopped) then
            call add_line(text, "output", scene%output%file // part_suffix // &
               " (interrupted), " // counted(s%rows, "row"))
         else
            call add_line(text, "output", scene%output%file // ", " // counted(s%rows, "row"))
         end if
      end associate
      call write_stdout(text%text(), error)
   end subroutine print_summary

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
      real(wp) :: y_start(simulation%motion%n), before(3), after(3)
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
         associate (y => simulation%memory%y, system => simulation%motion%system)
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
                  three(turning(system, y_start, i)) // " -> " // &
                  three(turning(system, y, i)) // " rad/s")
               cycle
            end if
            before = spin_of(y_start, i)
            after = spin_of(y, i)
            call add_line(text, "", names(i)%s // ": axis " // tilt(system, y_start, i) // &
               " -> " // tilt(system, y, i) // " deg from vertical, spin about it " // &
               number_text(before(3), 5) // " -> " // number_text(after(3), 5) // " rad/s")
         end associate
      end do
   end subroutine add_bodies

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
      integer :: k

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

   !> Angular velocity of a body in the inertial frame [rad/s].
   function turning(system, state, i) result(rate)
      type(system_type), intent(in) :: system
      real(wp), intent(in) :: state(:)
      !> Number of the body.
      integer, intent(in) :: i
      real(wp) :: rate(3)
      type(pose_type) :: pose
      real(wp) :: quaternion(4)

      call system%pose_of(state, i, pose, quaternion)
      rate = matmul(pose%rotation, spin_of(state, i))
   end function turning

   !> Angle between the z axis of a body and the vertical [deg].
   function tilt(system, state, i) result(angle)
      type(system_type), intent(in) :: system
      real(wp), intent(in) :: state(:)
      !> Number of the body.
      integer, intent(in) :: i
      character(len=:), allocatable :: angle
      type(pose_type) :: pose
      real(wp) :: quaternion(4)

      call system%pose_of(state, i, pose, quaternion)
      associate (axis => pose%rotation(:, 3))
         angle = number_text(atan2(hypot(axis(1), axis(2)), axis(3))*180.0_wp/pi, 5)
      end associate
   end function tilt

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

end module contensou_drivers_run_summary
