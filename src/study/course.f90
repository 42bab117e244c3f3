!> A simulation that is brought forward from time to time, and changed on its way: what other
!> programs do with one.
!>
!>    call course%begin(file, error)
!>    call course%advance(t, error)
!>
!> Where it has come is its present: any time, also one within a step of the method, which then
!> goes on from there as if it had not been asked. So the bits of rows and events do not depend on
!> the times at which it is looked at. What changes the motion or keeps it (`set_down`) ends the
!> step at the present; the method is started anew there.
module contensou_study_course
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite
   use contensou_base_checkpoint, only : checkpoint_type
   use contensou_base_errors, only : error_type, fatal, status_usage
   use contensou_base_kinds, only : i8, wp
   use contensou_base_numbers, only : to_text
   use contensou_base_operating_system, only : checksum
   use contensou_base_text_lock, only : lock_texts, unlock_texts
   use contensou_dynamics_jacobian, only : is_available, jacobian_type
   use contensou_dynamics_scene, only : motion_free, moves_freely, turns_by_drive
   use contensou_dynamics_spots, only : assign_spots
   use contensou_dynamics_state, only : quaternion_of
   use contensou_integrate_march, only : adopt_state, close_march, go_on, open_march
   use contensou_integrate_history, only : doubt_of_host
   use contensou_integrate_host, only : host_events, host_step
   use contensou_integrate_motion, only : motion_type
   use contensou_integrate_observer, only : event_touch, observer_type
   use contensou_integrate_step, only : keep_workspace, kept_type, march_type, restore_workspace
   use contensou_scene_reader, only : scene_file_type
   use contensou_study_quantities, only : row_type
   use contensou_study_simulation, only : fail, new_simulation, simulation_options_type, &
      simulation_type
   use contensou_study_summary, only : summary_type
   implicit none(type, external)
   private

   public :: course_type, listener_type

   !> Relative step of the differences of a Jacobian.
   real(wp), parameter :: difference = 1.0e-7_wp

   !> Who hears of rows and events; this one does not listen.
   type :: listener_type
   contains
      procedure :: hear_row
      procedure :: hear_event
   end type listener_type

   !> Who looks on: takes the values of rows, and the state at the present.
   type, extends(observer_type) :: guide_type
      class(listener_type), pointer :: listener => null()
      !> Values of the last row or of the present.
      type(row_type) :: row
      type(summary_type) :: summary
      !> The present.
      real(wp) :: t = 0.0_wp
      real(wp), allocatable :: y(:)
      !> Whether the values of `row` are those of the present.
      logical :: known = .false.
      !> Whether the listener asked to stop.
      logical :: asked = .false.
      !> Whether events end an advance.
      logical :: heeds_events = .false.
      !> Events in this advance.
      integer :: events = 0
   contains
      procedure :: sample
      procedure :: at_wait
      procedure :: event
      procedure :: after_step
   end type guide_type

   !> A simulation with its present. Its address must not change while it is used.
   type :: course_type
      type(simulation_type) :: simulation
      type(guide_type) :: guide
      type(march_type), private :: march
      !> Whether the march is open.
      logical, private :: open = .false.
      !> Whether anything was done since the beginning.
      logical :: begun = .false.
      !> Whether an advance is under way.
      logical :: busy = .false.
      !> Checksum of the settings of its scene.
      integer(i8), private :: scene_sum = 0
      !> Why it cannot go on; not allocated if it can.
      type(error_type), allocatable, private :: failure
      type(jacobian_type), private :: differential
      logical, private :: laid_out = .false.
      !> Time of the last step that another program has accepted [s].
      real(wp), private :: t_host = 0.0_wp
      !> Rates of the gaps then [m/s].
      real(wp), allocatable, private :: rate_host(:)
   contains
      procedure :: begin
      procedure :: release
      procedure :: advance
      procedure :: has_ended
      procedure :: take_values
      procedure :: set_down
      procedure :: set_state
      procedure :: set_load
      procedure :: set_drive
      procedure :: check_state
      procedure :: derivative
      procedure :: indicators
      procedure :: memory_indicator
      procedure :: nominals
      procedure :: remembers
      procedure :: jacobian
      procedure :: contact_load
      procedure :: put_host
      procedure :: complete_host_step
      procedure :: update_host
      procedure :: exchange
   end type course_type

contains

   !> A row; nobody listens unless this is overridden.
   subroutine hear_row(self, t, y, stop_now)
      class(listener_type), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)
      !> Whether the advance is to end here.
      logical, intent(out) :: stop_now

      stop_now = .false.
   end subroutine hear_row

   !> A touch or a lift-off; nobody listens unless this is overridden.
   subroutine hear_event(self, t, kind, contact, stop_now)
      class(listener_type), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> `event_touch` or `event_lift`.
      integer, intent(in) :: kind
      integer, intent(in) :: contact
      !> Whether the advance is to end after this step.
      logical, intent(out) :: stop_now

      stop_now = .false.
   end subroutine hear_event

   !> Put a simulation of a scene at its beginning.
   subroutine begin(self, file, error, options)
      class(course_type), intent(inout) :: self
      !> The scene, unchanged since it was read.
      type(scene_file_type), intent(in) :: file
      !> Set when an option is wrong, or rigid contacts cannot be settled.
      type(error_type), allocatable, intent(out) :: error
      type(simulation_options_type), intent(in), optional :: options

      call self%release()
      self%begun = .false.
      self%laid_out = .false.
      if (allocated(self%failure)) deallocate(self%failure)
      call new_simulation(file, self%simulation, error, options)
      if (allocated(error)) return
      self%t_host = 0.0_wp
      if (allocated(self%rate_host)) deallocate(self%rate_host)
      allocate(self%rate_host(self%simulation%motion%n_events), source=0.0_wp)
      self%scene_sum = checksum(0_i8, file%resolved)
      self%guide%summary = summary_type()
      call self%guide%row%prepare(self%simulation%motion%system, &
         self%simulation%scene%output)
      call look_at_memory(self)
   end subroutine begin

   !> Release the method; the present stays.
   subroutine release(self)
      class(course_type), intent(inout) :: self

      if (self%open) call close_march(self%march)
      self%open = .false.
   end subroutine release

   !> Let the present be where the march is.
   subroutine look_at_memory(self)
      class(course_type), intent(inout) :: self

      self%guide%t = self%simulation%memory%t
      self%guide%y = self%simulation%memory%y
      self%guide%known = .false.
   end subroutine look_at_memory

   !> Go on to a time, or to where the listener, an event or a condition of the scene ends it.
   subroutine advance(self, t, error, to_events)
      class(course_type), intent(inout), target :: self
      !> Time, not before the present [s]; beyond the end of the scene it goes on.
      real(wp), intent(in) :: t
      !> Set when the integration failed.
      type(error_type), allocatable, intent(out) :: error
      !> Whether it ends at an event.
      logical, intent(in), optional :: to_events

      if (allocated(self%failure)) then
         error = self%failure
         return
      end if
      call check_time(self, t, error)
      if (allocated(error)) return
      if (t > self%simulation%plan%t_end .and. .not. self%has_ended()) call extend(self, t)
      associate (simulation => self%simulation, guide => self%guide)
         guide%asked = .false.
         guide%events = 0
         guide%heeds_events = .false.
         if (present(to_events)) guide%heeds_events = to_events
         guide%wait = t
         if (simulation%memory%row > 0 .and. t <= guide%t) return
         self%busy = .true.
         if (.not. self%open) then
            call open_march(self%march, simulation%motion, simulation%plan, simulation%memory, &
               guide, error)
            self%open = .true.
         end if
         if (.not. allocated(error)) call go_on(self%march, simulation%stopped, error)
         self%begun = .true.
         self%busy = .false.
         if (.not. self%march%inside .or. allocated(error)) call look_at_memory(self)
         if (.not. allocated(error)) return
      end associate
      call self%release()
      call lock_texts()
      call fail(self%simulation, error)
      allocate(self%failure, source=error)
      call unlock_texts()
   end subroutine advance

   !> Whether a time can be gone to.
   subroutine check_time(self, t, error)
      class(course_type), intent(in) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> Set when it cannot.
      type(error_type), allocatable, intent(out) :: error

      if (.not. ieee_is_finite(t)) then
         call fatal(error, "the time to go to is no number", status_usage)
      else if (t < self%guide%t) then
         call fatal(error, "the time to go to is before the present", status_usage)
      end if
   end subroutine check_time

   !> Let the scene end later.
   subroutine extend(self, t)
      class(course_type), intent(inout) :: self
      !> Time of its end [s].
      real(wp), intent(in) :: t

      call self%set_down()
      associate (plan => self%simulation%plan, row => self%simulation%memory%row)
         plan%t_end = t
         if (row > 0) row = floor(self%guide%t/plan%interval, i8) + 1_i8
      end associate
   end subroutine extend

   !> Whether a condition of the scene, as one of `&stop`, has ended it.
   pure logical function has_ended(self)
      class(course_type), intent(in) :: self

      has_ended = self%simulation%memory%stops%ended_by > 0
   end function has_ended

   !> Take the values of all quantities at the present.
   subroutine take_values(self, error)
      class(course_type), intent(inout), target :: self
      !> Set where the forces of rigid contacts are not found.
      type(error_type), allocatable, intent(out) :: error
      type(kept_type) :: kept
      type(summary_type) :: first

      if (self%guide%known) return
      associate (guide => self%guide, motion => self%simulation%motion)
         call keep_workspace(motion, kept)
         first = guide%summary
         if (first%rows == 0) then
            ! The present is the beginning, against which energies are balanced.
            call first%add_row(guide%row, motion%system, guide%t, guide%y, error)
         else
            call first%look(guide%row, motion%system, guide%t, guide%y, error)
         end if
         call restore_workspace(motion, kept)
         guide%known = .not. allocated(error)
      end associate
   end subroutine take_values

   !> End the step under way at the present, so that the motion can be changed or kept there.
   subroutine set_down(self)
      class(course_type), intent(inout) :: self
      integer :: index, trouble

      if (.not. self%open) return
      associate (memory => self%simulation%memory, system => self%simulation%motion%system)
         if (self%march%inside) then
            memory%t = self%guide%t
            memory%y = self%guide%y
            if (system%several_spots) then
               call system%set_poses(memory%y)
               call assign_spots(system, memory%closed, index, trouble)
            end if
            if (allocated(memory%stops%since)) then
               where (memory%stops%since > memory%t) memory%stops%since = -1.0_wp
            end if
         end if
      end associate
      call self%release()
   end subroutine set_down

   !> Set the state at the present, as at a beginning: contacts are closed where surfaces overlap.
   !> The residual of the energy balance stays what it is.
   subroutine set_state(self, y, error)
      class(course_type), intent(inout), target :: self
      real(wp), intent(in) :: y(:)
      !> Set when the state is none, or rigid contacts cannot be settled.
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: residual

      call check_state(self, y, error)
      if (allocated(error)) return
      call self%set_down()
      residual = 0.0_wp
      if (self%guide%summary%rows > 0 .and. .not. allocated(self%failure)) then
         call self%take_values(error)
         if (allocated(error)) return
         residual = self%guide%row%at%energy_error
      end if
      if (allocated(self%failure)) deallocate(self%failure)
      self%simulation%memory%y = y
      call adopt_state(self%simulation%motion, self%simulation%memory, error)
      call look_at_memory(self)
      if (allocated(error) .or. self%guide%summary%rows == 0) return
      call self%take_values(error)
      if (allocated(error)) return
      self%guide%summary%initial_energy = self%guide%row%at%balance() - residual
      self%guide%known = .false.
   end subroutine set_state

   !> Whether numbers can be a state.
   subroutine check_state(self, y, error)
      class(course_type), intent(in) :: self
      real(wp), intent(in) :: y(:)
      !> Set when they cannot.
      type(error_type), allocatable, intent(out) :: error
      integer :: i

      if (size(y) /= self%simulation%motion%n) then
         call lock_texts()
         call fatal(error, "the state has " // to_text(self%simulation%motion%n) // &
            " numbers, not " // to_text(size(y)), status_usage)
         call unlock_texts()
      else if (.not. all(ieee_is_finite(y))) then
         call fatal(error, "a number of the state is infinite or not a number", status_usage)
      else
         do i = 1, self%simulation%motion%system%layout%bodies
            if (norm2(quaternion_of(y, i)) > 0.0_wp) cycle
            call fatal(error, "a quaternion of the state is zero", status_usage)
            return
         end do
      end if
   end subroutine check_state

   !> Let a force and a torque act on a body that moves freely, in place of those it had, from the
   !> present on. The state gets the work that they supply, unless it has it.
   subroutine set_load(self, body, force, torque, error)
      class(course_type), intent(inout), target :: self
      integer, intent(in) :: body
      !> Force at the centre of mass [N], in the frame that the scene names.
      real(wp), intent(in) :: force(3)
      !> Torque [N m].
      real(wp), intent(in) :: torque(3)
      !> Set when the body does not move freely, or a number is none.
      type(error_type), allocatable, intent(out) :: error

      if (.not. all(ieee_is_finite([force, torque]))) then
         call fatal(error, "a load is infinite or not a number", status_usage)
      else if (self%simulation%motion%system%bodies(body)%motion /= motion_free) then
         call fatal(error, "a load acts on a body that moves freely only", status_usage)
      end if
      if (allocated(error)) return
      associate (spec => self%simulation%motion%system%bodies(body))
         if (spec%loaded .and. all(abs(force - spec%force) <= 0.0_wp) .and. &
            all(abs(torque - spec%torque) <= 0.0_wp)) return
         call self%set_down()
         spec%loaded = .true.
         spec%force = force
         spec%torque = torque
      end associate
      call lay_out(self)
   end subroutine set_load

   !> Let the drive of a body accelerate it beside what the scene says, from the present on.
   subroutine set_drive(self, body, acceleration, angular_acceleration, error)
      class(course_type), intent(inout), target :: self
      integer, intent(in) :: body
      !> Acceleration of a prescribed motion [m/s2].
      real(wp), intent(in) :: acceleration(3)
      !> Angular acceleration of a prescribed rotation [rad/s2], inertial frame.
      real(wp), intent(in) :: angular_acceleration(3)
      !> Set when the body has no drive, or a number is none.
      type(error_type), allocatable, intent(out) :: error

      associate (spec => self%simulation%motion%system%bodies(body))
         if (.not. all(ieee_is_finite([acceleration, angular_acceleration]))) then
            call fatal(error, "an acceleration is infinite or not a number", status_usage)
         else if (.not. turns_by_drive(spec%motion)) then
            call fatal(error, "only a body whose motion or rotation is prescribed has a drive", &
               status_usage)
         else if (moves_freely(spec%motion) .and. norm2(acceleration) > 0.0_wp) then
            call fatal(error, "the drive of a spindle turns it and does not move it", status_usage)
         end if
         if (allocated(error)) return
         if (all(abs(acceleration - spec%guided) <= 0.0_wp) .and. &
            all(abs(angular_acceleration - spec%guided_turning) <= 0.0_wp)) return
         call self%set_down()
         spec%is_guided = .true.
         spec%guided = acceleration
         spec%guided_turning = angular_acceleration
      end associate
      self%begun = .true.
   end subroutine set_drive

   !> Lay the state out again if loads have made it longer: by their work, which is its last number.
   subroutine lay_out(self)
      class(course_type), intent(inout) :: self

      self%begun = .true.
      associate (motion => self%simulation%motion, memory => self%simulation%memory)
         if (motion%system%layout%applied > 0) return
         call motion%system%prepare()
         motion%n = motion%system%layout%n
         if (allocated(motion%row)) deallocate(motion%column_start, motion%row)
         memory%y = [memory%y, 0.0_wp]
      end associate
      self%laid_out = .false.
      call look_at_memory(self)
   end subroutine lay_out

   !> Time derivative of a state.
   subroutine derivative(self, t, y, rate, error)
      class(course_type), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)
      real(wp), intent(out) :: rate(:)
      !> Set when the state is none, or outside of the domain of the model.
      type(error_type), allocatable, intent(out) :: error
      type(kept_type) :: kept
      logical :: outside

      rate = 0.0_wp
      call check_state(self, y, error)
      if (allocated(error)) return
      associate (motion => self%simulation%motion)
         call keep_workspace(motion, kept)
         call motion%derivative(t, y, rate, outside)
         call restore_workspace(motion, kept)
      end associate
      if (.not. outside) return
      rate = 0.0_wp
      call fatal(error, "the state is outside of the domain of the model")
   end subroutine derivative

   !> Functions of a state that are zero where a contact touches or lifts off, one for each: gaps
   !> [m], of closed rigid contacts the normal force, reversed [N].
   subroutine indicators(self, t, y, values, error)
      class(course_type), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)
      real(wp), intent(out) :: values(:)
      !> Set when the state is none.
      type(error_type), allocatable, intent(out) :: error
      type(kept_type) :: kept

      values = 0.0_wp
      call check_state(self, y, error)
      if (allocated(error)) return
      associate (motion => self%simulation%motion)
         call keep_workspace(motion, kept)
         call motion%events(t, y, values)
         call restore_workspace(motion, kept)
         motion%unfound = .false.
      end associate
   end subroutine indicators

   !> What is usual of each number of the state.
   subroutine nominals(self, values)
      class(course_type), intent(inout) :: self
      real(wp), intent(out) :: values(:)

      call self%simulation%motion%nominals(values)
   end subroutine nominals

   !> Whether contacts have tangential elasticity.
   pure logical function remembers(self)
      class(course_type), intent(in) :: self

      remembers = self%simulation%motion%system%remembers
   end function remembers

   !> A function of a state that another program integrates, which is zero where contacts with
   !> tangential elasticity have to remember an accepted step.
   subroutine memory_indicator(self, t, y, value, error)
      class(course_type), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)
      !> -1 where nothing is remembered.
      real(wp), intent(out) :: value
      !> Set when the state is none.
      type(error_type), allocatable, intent(out) :: error
      type(kept_type) :: kept

      value = -1.0_wp
      call check_state(self, y, error)
      if (allocated(error) .or. .not. self%remembers()) return
      associate (motion => self%simulation%motion)
         call keep_workspace(motion, kept)
         call doubt_of_host(motion, self%t_host, self%rate_host, t, y, value)
         call restore_workspace(motion, kept)
      end associate
   end subroutine memory_indicator

   !> Derivatives of the right-hand side by the state.
   subroutine jacobian(self, t, y, slopes, error)
      class(course_type), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)
      !> Derivative of rate i by unknown j.
      real(wp), intent(out) :: slopes(:, :)
      !> Set when the state is none, or outside of the domain of the model.
      type(error_type), allocatable, intent(out) :: error
      type(kept_type) :: kept
      real(wp) :: rate(size(y)), shifted(size(y)), other(size(y)), admissible(size(y)), step
      integer :: i, j

      slopes = 0.0_wp
      call self%derivative(t, y, rate, error)
      if (allocated(error)) return
      associate (motion => self%simulation%motion)
         if (is_available(motion%system)) then
            if (.not. self%laid_out) call self%differential%prepare(motion%system)
            self%laid_out = .true.
            call keep_workspace(motion, kept)
            call self%differential%evaluate(motion%system, t, y)
            call restore_workspace(motion, kept)
            associate (d => self%differential)
               do j = 1, motion%n
                  do i = d%column_start(j), d%column_start(j + 1) - 1
                     slopes(d%row(i), j) = d%value(i)
                  end do
               end do
            end associate
            return
         end if
         call motion%admissible_error(y, admissible)
         do j = 1, motion%n
            step = max(difference*abs(y(j)), admissible(j))
            shifted = y
            shifted(j) = y(j) + step
            call self%derivative(t, shifted, other, error)
            if (allocated(error)) return
            slopes(:, j) = (other - rate)/(shifted(j) - y(j))
         end do
      end associate
   end subroutine jacobian

   !> What a contact does to its bodies at a state, as a function of the state alone.
   subroutine contact_load(self, contact, y, force, torque, error)
      class(course_type), intent(inout) :: self
      integer, intent(in) :: contact
      real(wp), intent(in) :: y(:)
      !> Force on body B [N], inertial frame; that on A is its reverse.
      real(wp), intent(out) :: force(3)
      !> Torques on A and on B about their centres of mass, of the ground about the origin [N m].
      real(wp), intent(out) :: torque(3, 2)
      !> Set when the contact is none of this kind, or the state is none or outside of the domain of
      !> the model.
      type(error_type), allocatable, intent(out) :: error
      type(kept_type) :: kept
      logical :: outside

      force = 0.0_wp
      torque = 0.0_wp
      call check_state(self, y, error)
      if (allocated(error)) return
      associate (motion => self%simulation%motion)
         if (motion%system%contacts(contact)%rigid) then
            call fatal(error, "a rigid contact has no force that follows from a state", &
               status_usage)
         else if (allocated(motion%system%contacts(contact)%tangential)) then
            call fatal(error, "the force of a contact with tangential elasticity follows from " &
               // "its history, not from a state alone", status_usage)
         end if
         if (allocated(error)) return
         call keep_workspace(motion, kept)
         call motion%system%contact_load(contact, y, force, torque)
         outside = motion%system%outside
         call restore_workspace(motion, kept)
      end associate
      if (.not. outside) return
      force = 0.0_wp
      torque = 0.0_wp
      call fatal(error, "the state is outside of the domain of the model")
   end subroutine contact_load

   !> Let the present be where another program has integrated to; contacts stay as they are.
   subroutine put_host(self, t, y, error)
      class(course_type), intent(inout), target :: self
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)
      !> Set when the state is none.
      type(error_type), allocatable, intent(out) :: error

      call check_state(self, y, error)
      if (allocated(error)) return
      call self%release()
      self%begun = .true.
      self%simulation%memory%t = t
      self%simulation%memory%y = y
      call look_at_memory(self)
   end subroutine put_host

   !> Another program has accepted a step to the present: contacts remember it.
   subroutine complete_host_step(self)
      class(course_type), intent(inout), target :: self
      type(march_type) :: march

      call hold(self, march)
      call host_step(march)
      call note_host_step(self)
   end subroutine complete_host_step

   !> Note the time of a step that another program has accepted, and how gaps change there.
   subroutine note_host_step(self)
      class(course_type), intent(inout) :: self

      self%t_host = self%simulation%memory%t
      if (self%remembers()) call self%simulation%motion%system%gap_rates( &
         self%simulation%memory%y, self%rate_host)
   end subroutine note_host_step

   !> Take the events at the present for another program that integrates: which contacts are closed,
   !> impacts of rigid ones, states of parts.
   subroutine update_host(self, changed, error)
      class(course_type), intent(inout), target :: self
      !> Whether the state is another one.
      logical, intent(out) :: changed
      !> Set when impacts cannot be resolved.
      type(error_type), allocatable, intent(out) :: error
      type(march_type) :: march

      changed = .false.
      call hold(self, march)
      associate (guide => self%guide, memory => self%simulation%memory)
         ! Energies are balanced against the beginning.
         if (guide%summary%rows == 0) then
            call guide%summary%add_row(guide%row, march%motion%system, memory%t, memory%y, error)
            call note_host_step(self)
         end if
      end associate
      if (allocated(error)) return
      call host_events(march, changed, error)
      call look_at_memory(self)
   end subroutine update_host

   !> A march of which another program does the integration.
   subroutine hold(self, march)
      class(course_type), intent(inout), target :: self
      type(march_type), intent(out) :: march

      call self%release()
      self%begun = .true.
      march%motion => self%simulation%motion
      march%memory => self%simulation%memory
      march%observer => self%guide
      march%plan = self%simulation%plan
   end subroutine hold

   !> Write where it is to a checkpoint, or read it back: then it is one of the same scene. The step
   !> under way ends at the present, so that it and what is read go on with the same bits.
   subroutine exchange(self, checkpoint, error)
      class(course_type), intent(inout), target :: self
      type(checkpoint_type), intent(inout) :: checkpoint
      !> Set when it has failed, or what is read belongs to another scene.
      type(error_type), allocatable, intent(out) :: error
      integer(i8) :: scene
      logical :: loaded
      integer :: i

      if (checkpoint%is_reading()) then
         call self%release()
         if (allocated(self%failure)) deallocate(self%failure)
      else if (allocated(self%failure)) then
         call fatal(error, "a simulation that failed cannot be kept", status_usage)
         return
      end if
      call self%set_down()
      scene = self%scene_sum
      call checkpoint%exchange("scene", scene)
      call checkpoint%result(error)
      if (.not. allocated(error) .and. scene /= self%scene_sum) call fatal(error, &
         "what was kept belongs to another scene, or one with other settings", status_usage)
      if (allocated(error)) return
      associate (simulation => self%simulation, bodies => self%simulation%motion%system%bodies, &
         memory => self%simulation%memory, guide => self%guide)
         do i = 1, size(bodies)
            call checkpoint%exchange("loaded", bodies(i)%loaded)
            call checkpoint%exchange("force", bodies(i)%force)
            call checkpoint%exchange("torque", bodies(i)%torque)
            call checkpoint%exchange("guided", bodies(i)%guided)
            call checkpoint%exchange("guided_turning", bodies(i)%guided_turning)
            bodies(i)%is_guided = norm2([bodies(i)%guided, bodies(i)%guided_turning]) > 0.0_wp
         end do
         loaded = simulation%motion%system%layout%applied > 0
         call checkpoint%exchange("supplied", loaded)
         if (loaded) call lay_out(self)
         if (.not. allocated(memory%closed)) allocate( &
            memory%closed(simulation%motion%n_events), source=.false.)
         if (.not. allocated(memory%undecided)) allocate( &
            memory%undecided(simulation%motion%n_events), source=.false.)
         call simulation%exchange(checkpoint)
         call guide%summary%exchange(checkpoint)
         call checkpoint%exchange("end", simulation%plan%t_end)
         call checkpoint%exchange("begun", self%begun)
         call checkpoint%exchange("host", self%t_host)
         call checkpoint%exchange("host_rate", self%rate_host)
      end associate
      call checkpoint%result(error)
      call look_at_memory(self)
   end subroutine exchange

   !> A row is due.
   subroutine sample(self, motion, t, y, error)
      class(guide_type), intent(inout) :: self
      class(motion_type), intent(inout) :: motion
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)
      type(error_type), allocatable, intent(out) :: error

      call self%summary%add_row(self%row, motion%system, t, y, error)
      if (allocated(error)) return
      self%t = t
      self%y = y
      self%known = .true.
      if (associated(self%listener)) call self%listener%hear_row(t, y, self%asked)
      if (self%asked) self%wait = t
   end subroutine sample

   !> The state where the march waits.
   subroutine at_wait(self, motion, t, y, error)
      class(guide_type), intent(inout) :: self
      class(motion_type), intent(inout) :: motion
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)
      type(error_type), allocatable, intent(out) :: error

      self%t = t
      self%y = y
      call self%summary%look(self%row, motion%system, t, y, error)
      self%known = .not. allocated(error)
   end subroutine at_wait

   !> A contact touched or lifted off.
   subroutine event(self, t, kind, contact, error)
      class(guide_type), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      integer, intent(in) :: kind
      integer, intent(in) :: contact
      type(error_type), allocatable, intent(out) :: error
      logical :: stop_now

      call self%summary%add_event(kind == event_touch)
      self%events = self%events + 1
      if (.not. associated(self%listener)) return
      call self%listener%hear_event(t, kind, contact, stop_now)
      self%asked = self%asked .or. stop_now
   end subroutine event

   !> A step is done.
   subroutine after_step(self, t, stop_now, error)
      class(guide_type), intent(inout) :: self
      !> Time reached [s].
      real(wp), intent(in) :: t
      logical, intent(out) :: stop_now
      type(error_type), allocatable, intent(out) :: error

      stop_now = self%asked .or. t >= self%wait .or. (self%heeds_events .and. self%events > 0)
   end subroutine after_step

end module contensou_study_course
