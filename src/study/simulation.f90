!> A simulation: a scene, assembled, with a method chosen, and how far it has come.
!>
!>    call new_simulation(scene, simulation, error)
!>    call simulate(simulation, observer, error)
!>
!> The observer sees rows, events and steps, and may stop the simulation after a step; another call
!> of `simulate` goes on from there. All that belongs to a simulation is in it: simulations in
!> several threads do not know of each other, and nothing is printed. Errors come back with their
!> text.
module contensou_study_simulation
   use contensou_base_checkpoint, only : checkpoint_type
   use contensou_base_errors, only : error_type, fatal, status_failed, status_usage
   use contensou_base_kinds, only : wp
   use contensou_base_numbers, only : number_text, to_text
   use contensou_base_operating_system, only : cpu_seconds
   use contensou_base_text, only : quote
   use contensou_base_text_lock, only : lock_texts, unlock_texts
   use contensou_contact_friction, only : friction_model_type, friction_models
   use contensou_contact_geometry, only : trouble_conforming, trouble_text
   use contensou_contact_tangential, only : tangential_model_type, tangential_models
   use contensou_dynamics_assembly, only : assemble, contact_length, initial_state
   use contensou_dynamics_scene, only : scene_type
   use contensou_dynamics_equations, only : system_type
   use contensou_dynamics_reports, only : contact_report_type, report_contact
   use contensou_integrate_choice, only : choice_text, choice_type
   use contensou_integrate_memory, only : memory_type, plan_type
   use contensou_integrate_methods, only : integrator_methods
   use contensou_integrate_observer, only : observer_type
   use contensou_integrate_march, only : begin_march, march
   use contensou_integrate_motion, only : motion_type, set_up_motion
   use contensou_scene_reader, only : scene_file_type
   implicit none(type, external)
   private

   public :: simulation_type, simulation_options_type, new_simulation, simulate, fail

   !> What may differ from the scene; what is not set is as the scene says.
   type :: simulation_options_type
      !> One of `integrator_methods`.
      character(len=:), allocatable :: method
      !> Relative tolerance [-].
      real(wp), allocatable :: rtol
      !> End of time [s].
      real(wp), allocatable :: t_end
      !> Interval of the rows [s].
      real(wp), allocatable :: interval
      !> Largest step [s], 0 for no bound.
      real(wp), allocatable :: max_step
      !> Whether the CPU time is taken by effect.
      logical :: profile = .false.
      !> Whether it goes to the end of time, whatever the conditions to stop say.
      logical :: to_the_end = .false.
      !> Whether compliant contacts are left to no other method that may take over.
      logical :: one_method = .false.
   end type simulation_options_type

   !> A scene, its equations of motion, and where they have come to.
   type :: simulation_type
      !> The scene, options applied.
      type(scene_type) :: scene
      !> Its equations of motion as an initial value problem.
      type(motion_type) :: motion
      type(plan_type) :: plan
      !> What `auto` began with, and on which figures; only the method if it was given.
      type(choice_type) :: choice
      !> Time, state, counters, and what else is needed to go on.
      type(memory_type) :: memory
      !> Whether an observer stopped it before its end.
      logical :: stopped = .false.
      !> Why it failed, without where; not allocated if it did not.
      character(len=:), allocatable :: failure
      !> CPU time of `simulate` so far [s].
      real(wp) :: cpu = 0.0_wp
      !> Whether the CPU time is taken by effect.
      logical, private :: profile = .false.
   contains
      procedure :: time
      procedure :: state
      procedure :: reason
      procedure :: exchange
   end type simulation_type

   !> Make a simulation of a scene at its beginning.
   interface new_simulation
      module procedure new_simulation_of_scene
      module procedure new_simulation_of_file
   end interface new_simulation

contains

   !> Make a simulation of a scene.
   subroutine new_simulation_of_scene(scene, simulation, error, options)
      !> The scene, as a reader leaves it, or made in memory.
      type(scene_type), intent(in) :: scene
      !> The simulation, at the beginning of its time.
      type(simulation_type), intent(out) :: simulation
      !> Set when an option is wrong, or rigid contacts cannot be settled.
      type(error_type), allocatable, intent(out) :: error
      type(simulation_options_type), intent(in), optional :: options

      call lock_texts()
      call apply_options(scene, simulation, error, options)
      if (.not. allocated(error)) then
         call assemble(simulation%scene, simulation%motion%system)
         call begin(simulation, error)
      end if
      call unlock_texts()
   end subroutine new_simulation_of_scene

   !> Make a simulation of a scene that was read, with what the reader has assembled.
   subroutine new_simulation_of_file(file, simulation, error, options)
      !> The scene, unchanged since it was read.
      type(scene_file_type), intent(in) :: file
      !> The simulation, at the beginning of its time.
      type(simulation_type), intent(out) :: simulation
      !> Set when an option is wrong, or rigid contacts cannot be settled.
      type(error_type), allocatable, intent(out) :: error
      type(simulation_options_type), intent(in), optional :: options

      call lock_texts()
      call apply_options(file%scene, simulation, error, options)
      if (.not. allocated(error)) then
         simulation%motion%system = file%system
         call begin(simulation, error)
      end if
      call unlock_texts()
   end subroutine new_simulation_of_file

   !> Take over a scene with options.
   subroutine apply_options(scene, simulation, error, options)
      type(scene_type), intent(in) :: scene
      type(simulation_type), intent(inout) :: simulation
      !> Set when an option is wrong.
      type(error_type), allocatable, intent(out) :: error
      type(simulation_options_type), intent(in), optional :: options

      simulation%scene = scene
      associate (own => simulation%scene, plan => simulation%plan)
         if (present(options)) then
            if (allocated(options%method)) own%integrator%method = options%method
            if (allocated(options%rtol)) own%integrator%rtol = options%rtol
            if (allocated(options%t_end)) own%t_end = options%t_end
            if (allocated(options%interval)) own%output%interval = options%interval
            if (allocated(options%max_step)) own%integrator%max_step = options%max_step
            simulation%profile = options%profile
            plan%one_method = options%one_method
            if (options%to_the_end .and. allocated(own%stops)) deallocate(own%stops)
         end if
         if (own%output%interval <= 0.0_wp) own%output%interval = 1.0e-3_wp*own%t_end
         if (all(integrator_methods /= own%integrator%method)) then
            call fatal(error, "there is no method " // quote(own%integrator%method), status_usage)
         else if (.not. own%integrator%rtol > 0.0_wp) then
            call fatal(error, "the relative tolerance must be > 0", status_usage)
         else if (.not. own%t_end > 0.0_wp) then
            call fatal(error, "the end of time must be > 0", status_usage)
         else if (.not. own%integrator%max_step >= 0.0_wp) then
            call fatal(error, "the largest step must be >= 0", status_usage)
         end if
         if (allocated(error)) return
         plan%method = own%integrator%method
         plan%t_end = own%t_end
         plan%interval = own%output%interval
         plan%max_step = own%integrator%max_step
         if (.not. allocated(own%stops)) return
         if (size(own%stops) == 0) return
         plan%stops = own%stops
         allocate(simulation%memory%stops%since(size(own%stops)), source=-1.0_wp)
      end associate
   end subroutine apply_options

   !> Put a simulation whose system is assembled at the beginning of its time.
   subroutine begin(simulation, error)
      type(simulation_type), intent(inout) :: simulation
      !> Set when rigid contacts cannot be settled.
      type(error_type), allocatable, intent(out) :: error

      associate (scene => simulation%scene, motion => simulation%motion, &
         memory => simulation%memory)
         associate (least => scene%integrator)
            if (least%length_scale <= 0.0_wp) least%length_scale = &
               contact_length(scene, motion%system, least%velocity_scale)
         end associate
         memory%y = initial_state(scene, motion%system%layout%n)
         call set_up_motion(motion, scene, memory%y)
         call begin_march(motion, simulation%plan%method, memory, simulation%choice, error)
      end associate
      if (allocated(error)) call fail(simulation, error)
   end subroutine begin

   !> Simulate to the end, or until the observer stops it; goes on where it was stopped.
   subroutine simulate(simulation, observer, error)
      type(simulation_type), intent(inout), target :: simulation
      class(observer_type), intent(inout) :: observer
      !> Set when the integration or the observer failed.
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: start

      if (simulation%profile .and. .not. simulation%motion%profile%active) then
         call simulation%motion%profile%begin()
      end if
      start = cpu_seconds()
      call march(simulation%motion, simulation%plan, simulation%memory, observer, &
         simulation%stopped, error)
      simulation%cpu = simulation%cpu + (cpu_seconds() - start)
      if (.not. allocated(error)) return
      call lock_texts()
      call fail(simulation, error)
      call unlock_texts()
   end subroutine simulate

   !> Keep why a simulation failed, and tell more.
   subroutine fail(simulation, error)
      type(simulation_type), intent(inout) :: simulation
      !> The failure; its message is completed unless it is one of a file.
      type(error_type), intent(inout) :: error

      simulation%failure = error%message
      if (error%status == status_failed) error%message = failure_text(simulation%scene, &
         simulation%memory%switch%method, simulation%motion%system, simulation%memory%y, &
         simulation%memory%t, error%message)
   end subroutine fail

   !> Write what is needed to go on to a checkpoint, or read it back: then the simulation is a new
   !> one of the same scene, with the same options.
   subroutine exchange(self, checkpoint)
      class(simulation_type), intent(inout) :: self
      type(checkpoint_type), intent(inout) :: checkpoint

      call self%memory%exchange(self%motion, checkpoint)
   end subroutine exchange

   !> Time reached [s].
   pure function time(self) result(t)
      class(simulation_type), intent(in) :: self
      real(wp) :: t

      t = self%memory%t
   end function time

   !> State there.
   pure function state(self) result(y)
      class(simulation_type), intent(in) :: self
      real(wp) :: y(self%motion%n)

      y = self%memory%y
   end function state

   !> Why `auto` chose the method it began with.
   function reason(self) result(text)
      class(simulation_type), intent(in) :: self
      character(len=:), allocatable :: text
      integer :: contact

      text = ""
      if (self%plan%method /= "auto") return
      contact = self%choice%contact
      call lock_texts()
      if (contact > 0) then
         text = choice_text(self%choice, name_of(self%scene, contact))
      else
         text = choice_text(self%choice, "")
      end if
      call unlock_texts()
   end function reason

   !> Name of a contact; its number if the scene was made in memory without names.
   function name_of(scene, contact) result(name)
      type(scene_type), intent(in) :: scene
      integer, intent(in) :: contact
      character(len=:), allocatable :: name

      name = to_text(contact)
      if (allocated(scene%contacts(contact)%name)) name = scene%contacts(contact)%name
   end function name_of

   !> Names of its two surfaces.
   function surfaces_of(scene, contact) result(names)
      type(scene_type), intent(in) :: scene
      integer, intent(in) :: contact
      character(len=:), allocatable :: names
      integer :: side

      names = ""
      do side = 1, 2
         associate (index => scene%contacts(contact)%surfaces(side))
            if (side == 2) names = names // " and "
            if (allocated(scene%surfaces(index)%name)) then
               names = names // quote(scene%surfaces(index)%name)
            else
               names = names // to_text(index)
            end if
         end associate
      end do
   end function surfaces_of

   !> What went wrong in an integration, where, and what may help.
   function failure_text(scene, method, system, y, t, reason) result(text)
      type(scene_type), intent(in) :: scene
      !> That which failed: not that of the scene where another one has taken over.
      character(len=*), intent(in) :: method
      type(system_type), intent(inout) :: system
      !> Last state.
      real(wp), intent(in) :: y(:)
      !> Time of it [s].
      real(wp), intent(in) :: t
      !> What the integrator says.
      character(len=*), intent(in) :: reason
      character(len=:), allocatable :: text
      real(wp) :: gap(size(system%contacts)), rate(size(system%contacts)), deepest
      integer :: i, deep

      deep = system%too_deep
      text = "the run failed at t = " // number_text(t, 10) // " s: " // reason
      if (size(gap) > 0) then
         call system%gaps(y, gap)
         call system%gap_rates(y, rate)
      end if
      do i = 1, size(gap)
         if (system%contacts(i)%track%away) cycle
         text = text // new_line("a") // "  contact " // quote(name_of(scene, i)) // ": gap " // &
            number_text(gap(i), 4) // " m, changing at " // number_text(rate(i), 4) // " m/s"
      end do
      if (system%trouble > 0) then
         text = text // new_line("a") // "  contact " // &
            quote(name_of(scene, system%trouble)) // ", surfaces " // &
            surfaces_of(scene, system%trouble) // ": " // trouble_text(system%trouble_code)
         if (system%trouble_code == trouble_conforming) text = text // "; where that is the " // &
            "end, as of a coin that comes to lie flat, &stop when = 'conforming' makes it one"
         if (deep == 0) return
      end if
      if (deep > 0) then
         ! A trial of the integrator may have been too deep, too.
         associate (contact => system%contacts(deep))
            deepest = contact%deepest(system%pose(contact%a), system%pose(contact%b), gap(deep))
         end associate
         if (-gap(deep) < 0.5_wp*deepest) deep = 0
      end if
      if (deep > 0) then
         text = text // new_line("a") // "  contact " // quote(name_of(scene, deep)) // &
            " is pressed deeper than " // &
            number_text(deepest, 3) // " m, a tenth of " // &
            "its radius, beyond Hertz's theory: a stiffer material, a slower " // &
            "impact or a smaller mass keeps it inside"
      else
         do i = 1, size(gap)
            if (gap(i) < 0.0_wp .and. .not. system%contacts(i)%rigid) call add_long_spot(system, &
               y, name_of(scene, i), i, text)
         end do
         if (method /= "cvode_bdf") text = text // new_line("a") // &
            "  friction that sticks and strong damping are stiff: integrator.method = " // &
            "'cvode_bdf' takes them in large steps"
         if (system%remembers) then
            text = text // new_line("a") // "  a larger integrator.rtol may help"
            if (method /= "explicit8") text = text // &
               ", and so may integrator.method = 'explicit8'"
         else if (smoothable(scene)) then
            text = text // new_line("a") // "  a larger integrator.rtol or a larger " // &
               "regularization_velocity may help"
         else
            text = text // new_line("a") // "  a larger integrator.rtol may help"
         end if
      end if
   end function failure_text

   !> Whether a contact of a scene may have a regularization_velocity.
   logical function smoothable(scene)
      type(scene_type), intent(in) :: scene
      type(friction_model_type), allocatable :: frictions(:)
      type(tangential_model_type), allocatable :: tangentials(:)
      integer :: i

      frictions = friction_models()
      tangentials = tangential_models()
      smoothable = .false.
      do i = 1, size(scene%contacts)
         associate (contact => scene%contacts(i))
            if (tangentials(contact%tangential)%acts) cycle
            if (frictions(contact%friction)%uses("regularization_velocity")) smoothable = .true.
         end associate
      end do
   end function smoothable

   !> Say of a spot that is far longer than wide that the surfaces come to conform.
   subroutine add_long_spot(system, y, name, contact, text)
      type(system_type), intent(inout) :: system
      !> Last state.
      real(wp), intent(in) :: y(:)
      character(len=*), intent(in) :: name
      integer, intent(in) :: contact
      character(len=:), allocatable, intent(inout) :: text
      type(contact_report_type) :: row
      real(wp), parameter :: long = 30.0_wp

      call system%set_poses(y)
      call report_contact(system, contact, row)
      if (.not. row%semi_axes(1) > long*row%semi_axes(2)) return
      text = text // new_line("a") // "  contact " // quote(name) // ": its spot is " // &
         number_text(row%semi_axes(1)/max(row%semi_axes(2), tiny(long)), 2) // " times longer " &
         // "than wide: the surfaces come to conform, where Hertz's theory ends"
   end subroutine add_long_spot

end module contensou_study_simulation
