!> The motion of a system of bodies as an initial value problem.
module contensou_integrate_motion
   use contensou_base_kinds, only : wp
   use contensou_base_operating_system, only : wall_seconds
   use contensou_base_rotations, only : to_body
   use contensou_base_vectors, only : cross
   use contensou_contact_geometry, only : contact_motion_type, pose_type
   use contensou_contact_states, only : against_angular_velocity, against_energy, against_length, &
      against_velocity, state_type
   use contensou_dynamics_assembly, only : contact_time, overlap_of_load => usual_overlap
   use contensou_dynamics_equations, only : system_type
   use contensou_dynamics_jacobian, only : is_available, jacobian_type
   use contensou_dynamics_reports, only : energies
   use contensou_dynamics_rests, only : sunk
   use contensou_dynamics_scene, only : scene_type
   use contensou_dynamics_state, only : at_position, at_quaternion, at_spin, at_velocity, body_size
   use contensou_integrate_problem, only : least_event, problem_type, way_columns_of
   use contensou_integrate_profile, only : profile_type
   implicit none(type, external)
   private

   public :: motion_type, scales_type, set_up_motion

   !> What the relative tolerance refers to, per kind of unknown.
   !>
   !> A position carries the information of a contact in its last digits (an overlap of 1e-7 m on a
   !> height of 1e-2 m), so its error is measured against a length of the contact, not against
   !> itself.
   type :: scales_type
      !> Relative tolerance [-].
      real(wp) :: rtol = 1.0e-8_wp
      !> That of the scene, and one whose errors leave the gaps of rigid contacts at what is zero.
      real(wp) :: asked = 1.0e-8_wp, coarsest = huge(1.0_wp)
      !> Positions: absolute, against this length [m].
      real(wp) :: length = 1.0e-7_wp
      !> Velocities: against the larger of this and the speed of the body [m/s].
      real(wp) :: velocity = 1.0e-2_wp
      !> Angular velocities: against the larger of this and the rate of the body [rad/s].
      real(wp) :: angular_velocity = 1.0_wp
      !> Quaternion: absolute, against this [-].
      real(wp) :: rotation = 1.0_wp
      !> Works: against the larger of this and the work [J].
      real(wp) :: energy = 1.0_wp
   contains
      procedure :: of_state
      procedure :: usual_overlap
   end type scales_type

   !> Velocity below which sliding is not resolved, over the admissible error of a velocity alone
   !> (the root of the number of unknowns times its weight). A third of it makes CVODE chatter.
   real(wp), parameter :: resolved = 8.0_wp

   !> Error of a gap of a rigid contact that the tolerance admits, over the overlap that ends a run.
   real(wp), parameter :: held = 0.3_wp

   !> Tolerance that is fine enough for any rigid contact.
   real(wp), parameter :: finest = 1.0e-9_wp

   !> Usual overlap of a contact over the length scale of the integration.
   real(wp), parameter :: overlap_over_length = 10.0_wp

   !> Gap that is as good as none, over the length scale of the integration.
   real(wp), parameter :: brink_over_length = 1.0e-6_wp

   !> Admissible error of what is of no account.
   real(wp), parameter :: of_no_account = 1.0e30_wp

   !> Admissible error of a gap that is integrated, over that of a position: a step of BDF that
   !> errs by as much as that at low order, after a kink of the tangential force, loses some 1e-9 of
   !> the energy of an impact. Finer ones feel the rounding of the forces.
   real(wp), parameter :: fine_way = 2.0e-3_wp

   !> The same of shifts and works, over what is admitted else: the energy is the work of forces
   !> that have kinks where shells begin to slip.
   real(wp), parameter :: fine_shift = 0.2_wp, fine_work = 0.3_wp

   !> Finest relative error that is admitted of how a body in flight tumbles.
   real(wp), parameter :: finest_flight = 1.0e-13_wp

   !> Place of the two shifts among the unknowns of a contact that remembers, after its axis.
   integer, parameter :: at_shifts = 3

   !> Speed of a gap below which more is admitted, over the scale of velocities.
   real(wp), parameter :: slow_way = 0.8_wp

   !> Motion of a system.
   type, extends(problem_type) :: motion_type
      type(system_type) :: system
      !> What the tolerance refers to.
      type(scales_type) :: scales
      type(jacobian_type) :: differential
      !> Shortest time that a contact takes [s]; 0 without contacts.
      real(wp) :: contact_time = 0.0_wp
      !> CPU time by effect.
      type(profile_type) :: profile
      !> Whether Jacobians are those of differences.
      logical :: differences = .false.
      !> Whether forces of rigid contacts were not found where events were looked for.
      logical :: unfound = .false.
      !> Contacts whose gaps are integrated as ways.
      integer, allocatable :: way(:)
      !> Rates of these at the last right-hand side [m/s].
      real(wp), allocatable :: way_rate(:)
      !> Speeds that the accelerations of these gaps make up over the overlaps, where a step was
      !> accepted last: an impact turns round at a rate of zero [m/s].
      real(wp), allocatable :: way_speed(:)
   contains
      procedure :: lay_out_jacobian
      procedure :: jacobian
      procedure :: derivative
      procedure :: events
      procedure :: admissible_error
      procedure :: way_rates
      procedure :: way_errors
      procedure :: flight_errors
      procedure :: way_columns
      procedure :: way_slopes
      procedure :: slowness
      procedure :: nominals
      procedure :: set_tolerance
      procedure, private :: admit_states
      procedure, private :: error_scales
   end type motion_type

contains

   !> Set sizes and scales of a motion whose system is assembled.
   subroutine set_up_motion(motion, scene, y)
      type(motion_type), intent(inout) :: motion
      type(scene_type), intent(in) :: scene
      !> Initial state.
      real(wp), intent(in) :: y(:)
      real(wp) :: kinetic, potential, usual
      integer :: i

      motion%n = motion%system%layout%n
      motion%n_events = size(motion%system%contacts)
      if (allocated(motion%row)) deallocate(motion%column_start, motion%row)
      motion%differences = scene%integrator%differences
      motion%jacobian_steps = scene%integrator%jacobian_steps
      motion%remembers = motion%system%remembers
      motion%settles = motion%remembers
      do i = 1, size(motion%system%contacts)
         associate (contact => motion%system%contacts(i))
            if (.not. allocated(contact%tangential)) cycle
            if (allocated(contact%tangential%carry)) motion%settles = .false.
         end associate
      end do
      motion%way = pack([(i, i=1, motion%n_events)], [(allocated(motion%system%contacts(i) &
         %tangential) .and. .not. motion%system%contacts(i)%rigid, i=1, motion%n_events)])
      motion%n_ways = size(motion%way)
      motion%way_rate = [(0.0_wp, i=1, motion%n_ways)]
      motion%way_speed = motion%way_rate
      associate (s => motion%scales)
         s%asked = scene%integrator%rtol
         s%coarsest = huge(s%coarsest)
         if (motion%system%constraints%n_rigid > 0) s%coarsest = coarsest_tolerance( &
            motion%system, y)
         s%length = scene%integrator%length_scale
         s%velocity = scene%integrator%velocity_scale
         s%angular_velocity = scene%integrator%angular_velocity_scale
         call energies(motion%system, y, kinetic, potential)
         call motion%set_tolerance(scene%integrator%method /= "explicit8", 0)
         motion%system%resolution%velocity = s%velocity**2
         motion%system%resolution%angular_velocity = s%angular_velocity**2
         motion%contact_time = contact_time(scene, motion%system, s%velocity)
         do i = 1, size(motion%system%contacts)
            associate (contact => motion%system%contacts(i))
               if (.not. allocated(contact%tangential)) cycle
               usual = s%usual_overlap()
               ! The length scale of what does not yield is that of its surfaces.
               if (contact%rigid) usual = overlap_of_load(scene, contact, s%velocity)
               contact%tangential%reference = contact%tangential%coefficient &
                  *contact%law%normal%force(usual)
               if (contact%rigid) cycle
               contact%brink = brink_over_length*s%length
               motion%rounding = contact%brink
            end associate
         end do
         motion%turns = motion%system%contacts%rigid
         s%energy = kinetic
         do i = 1, size(motion%system%bodies)
            s%energy = s%energy + 0.5_wp*motion%system%bodies(i)%mass*s%velocity**2
         end do
      end associate
      if (motion%system%layout%states > 0) call set_state_scales(motion)
   end subroutine set_up_motion

   !> Set the relative tolerance, and the velocity below which sliding is not resolved.
   subroutine set_tolerance(self, multistep, tightened)
      class(motion_type), intent(inout) :: self
      !> Whether a multistep method may integrate, whose errors add up.
      logical, intent(in) :: multistep
      !> How many times rigid contacts have been found to drift.
      integer, intent(in) :: tightened
      real(wp) :: share

      associate (s => self%scales)
         s%rtol = s%asked
         if (self%system%constraints%n_rigid > 0) then
            share = merge(0.1_wp, 1.0_wp, multistep)
            ! No ringing holds the steps of a rigid scene below what the tolerance admits.
            s%rtol = max(share*s%asked, min(s%asked, 1.0e-13_wp))
            s%rtol = min(s%rtol, max(share*s%coarsest, finest))
            if (tightened > 0) s%rtol = max(s%rtol*0.1_wp**tightened, min(s%rtol, 1.0e-13_wp))
         end if
         self%system%resolution%square = self%n*(resolved*s%rtol)**2
         self%system%resolution%tolerance = s%rtol
      end associate
   end subroutine set_tolerance

   !> Tolerance whose errors of the attitudes leave the gaps of rigid contacts at what is zero.
   real(wp) function coarsest_tolerance(system, y) result(rtol)
      type(system_type), intent(inout) :: system
      !> Initial state.
      real(wp), intent(in) :: y(:)
      type(contact_motion_type) :: now
      real(wp) :: arm
      integer :: i

      rtol = huge(rtol)
      call system%set_poses(y)
      do i = 1, size(system%contacts)
         if (.not. system%contacts(i)%rigid) cycle
         call system%observe(i, now)
         associate (contact => system%contacts(i), radius => &
            system%contacts(i)%law%geometry%smallest_radius())
            arm = radius
            if (contact%a > 0) arm = max(arm, norm2(now%at%point - system%pose(contact%a)%position))
            if (contact%b > 0) arm = max(arm, norm2(now%at%point - system%pose(contact%b)%position))
            rtol = min(rtol, held*sunk*radius/arm)
         end associate
      end do
   end function coarsest_tolerance

   !> Right-hand side.
   subroutine derivative(self, t, y, rate, outside)
      class(motion_type), intent(inout) :: self
      !> Time [s] .
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(self%n)
      !> Its time derivative.
      real(wp), intent(out) :: rate(self%n)
      !> Whether an approach is far outside the domain of the contact model.
      logical, intent(out) :: outside

      real(wp) :: start
      logical :: timed

      timed = .false.
      if (self%profile%active) call self%profile%right_hand_side%count_call(timed)
      if (timed) start = wall_seconds()
      call self%system%derivative(t, y, rate)
      outside = self%system%outside
      if (timed .and. .not. outside) call self%profile%take(self%system, wall_seconds() - start)
   end subroutine derivative

   !> Lay out the Jacobian, unless that is done: explicit methods need none.
   subroutine lay_out_jacobian(self)
      class(motion_type), intent(inout) :: self

      if (self%differences .or. allocated(self%row) .or. .not. is_available(self%system)) return
      call self%differential%prepare(self%system)
      ! Not by assignment, before which gfortran looks at the bounds of what is not allocated.
      allocate(self%column_start, source=self%differential%column_start)
      allocate(self%row, source=self%differential%row)
   end subroutine lay_out_jacobian

   !> Jacobian of the right-hand side.
   subroutine jacobian(self, t, y, value)
      class(motion_type), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)
      !> Entries, in the order of `row`.
      real(wp), intent(out) :: value(:)

      real(wp) :: start
      logical :: timed

      timed = .false.
      if (self%profile%active) call self%profile%jacobian%count_call(timed)
      if (timed) start = wall_seconds()
      call self%differential%evaluate(self%system, t, y)
      if (timed) call self%profile%jacobian%add(wall_seconds() - start - self%profile%overhead)
      value = self%differential%value
   end subroutine jacobian

   !> Gaps of the contacts: zero at touch and lift-off; of closed rigid contacts the normal forces,
   !> reversed, so that these, too, rise through zero at lift-off.
   subroutine events(self, t, y, g)
      class(motion_type), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)
      !> Gaps [m], reversed normal forces [N].
      real(wp), intent(out) :: g(:)

      real(wp) :: start
      logical :: timed

      timed = .false.
      if (self%profile%active) call self%profile%events%count_call(timed)
      if (timed) start = wall_seconds()
      call self%system%gaps(y, g, self%at_last)
      if (self%system%constraints%n_rigid > 0) call rigid_events()
      if (timed) call self%profile%events%add(wall_seconds() - start - self%profile%overhead)
      ! A gap is a difference of larger numbers and can stay exactly zero over a short time, which
      ! CVODE refuses as two roots in one place.
      where (abs(g) <= 0.0_wp) g = least_event

   contains

      !> Event functions of rigid contacts.
      subroutine rigid_events()
         integer :: i

         call self%system%constraint_forces(t, y)
         if (self%system%outside) self%unfound = .true.
         do i = 1, size(g)
            associate (contact => self%system%contacts(i))
               if (contact%closed) then
                  if (.not. self%system%outside) g(i) = -contact%normal_force &
                     - self%system%constraints%pull - contact%threshold
                  if (self%system%outside .or. abs(g(i)) <= 0.0_wp) g(i) = -least_event
               else if (contact%leaving) then
                  g(i) = g(i) - contact%threshold
               end if
            end associate
         end do
      end subroutine rigid_events

   end subroutine events

   !> Admissible local error of each unknown. Shifts begin where surfaces touch: what a step through
   !> that makes of them before it is cut there is of no account.
   subroutine admissible_error(self, y, size_of_error)
      class(motion_type), intent(in) :: self
      real(wp), intent(in) :: y(:)
      !> Admissible error.
      real(wp), intent(out) :: size_of_error(:)
      integer :: i

      call self%error_scales(y, size_of_error)
      if (.not. self%remembers) return
      do i = 1, size(self%system%contacts)
         associate (contact => self%system%contacts(i))
            if (.not. allocated(contact%tangential)) cycle
            if (contact%rigid .or. contact%tangential%is_loaded()) cycle
            ! After those of damping, which are numbers.
            associate (states => contact%states)
               size_of_error(states%first + states%n_damping:states%first + states%n - 1) &
                  = of_no_account
            end associate
         end associate
      end do
   end subroutine admissible_error

   !> Rates of the gaps of the compliant contacts that remember, as long as they touch; also where
   !> they have parted within the step, so that these have no jump there.
   subroutine way_rates(self, rates)
      class(motion_type), intent(inout) :: self
      !> [m/s].
      real(wp), intent(out) :: rates(:)
      type(contact_motion_type) :: now
      logical :: touches
      integer :: i

      do i = 1, size(rates)
         call self%system%observe(self%way(i), now)
         associate (contact => self%system%contacts(self%way(i)))
            rates(i) = 0.0_wp
            touches = contact%tangential%is_loaded() .or. now%at%gap < contact%brink
            if (touches) rates(i) = now%gap_rate()
         end associate
      end do
      self%way_rate = rates
   end subroutine way_rates

   !> Admissible local errors of the ways: finer than those of positions where a gap changes as in
   !> an impact, of no account where it hardly does, as what rings at rest takes no such steps.
   !> Those of shifts and works are finer as well.
   subroutine way_errors(self, of_unknowns, size_of_error)
      class(motion_type), intent(in) :: self
      !> As `admissible_error` tells them.
      real(wp), intent(inout) :: of_unknowns(:)
      !> [m], > 0.
      real(wp), intent(out) :: size_of_error(:)
      real(wp) :: slowness, work
      integer :: i

      size_of_error = of_no_account
      work = 1.0_wp
      do i = 1, size(size_of_error)
         associate (contact => self%system%contacts(self%way(i)))
            if (.not. contact%tangential%is_loaded()) cycle
            slowness = self%slowness(i)
            size_of_error(i) = fine_way*slowness*self%scales%rtol*self%scales%length
            work = min(work, fine_work*slowness)
            associate (k => contact%states%first + contact%states%n_damping + at_shifts)
               of_unknowns(k:k + 1) = min(1.0_wp, fine_shift*slowness)*of_unknowns(k:k + 1)
            end associate
         end associate
      end do
      associate (layout => self%system%layout)
         i = body_size*layout%bodies + layout%states + 1
         of_unknowns(i:) = work*of_unknowns(i:)
      end associate
   end subroutine way_errors

   !> Finer admissible local errors of the angular velocities of bodies in flight between impacts of
   !> contacts that remember: so short a flight is begun at low order, with few and long steps.
   pure subroutine flight_errors(self, part, of_unknowns, open)
      class(motion_type), intent(in) :: self
      !> What is admitted, over what is else.
      real(wp), intent(in) :: part
      !> As `admissible_error` tells them.
      real(wp), intent(inout) :: of_unknowns(:)
      !> For each contact, whether its gap is above zero, where that is known.
      logical, intent(in), optional :: open(:)
      logical :: flies(0:self%system%layout%bodies), touches
      real(wp) :: factor
      integer :: i, k

      if (.not. self%remembers) return
      flies = .false.
      do i = 1, size(self%system%contacts)
         associate (contact => self%system%contacts(i))
            if (allocated(contact%tangential)) flies([contact%a, contact%b]) = .true.
         end associate
      end do
      do i = 1, size(self%system%contacts)
         associate (contact => self%system%contacts(i))
            ! Of compliant contacts without memory it is not known whether they are open.
            touches = contact%closed .or. .not. (contact%rigid .or. allocated(contact%tangential))
            if (allocated(contact%tangential)) touches = touches .or. contact%tangential%is_loaded()
            if (present(open)) touches = touches .or. .not. open(i)
            if (touches) flies([contact%a, contact%b]) = .false.
         end associate
      end do
      factor = min(1.0_wp, max(part, finest_flight/self%scales%rtol))
      do i = 1, self%system%layout%bodies
         if (.not. flies(i)) cycle
         k = body_size*(i - 1) + at_spin
         of_unknowns(k:k + 2) = factor*of_unknowns(k:k + 2)
      end do
   end subroutine flight_errors

   !> How much more is admitted of a contact whose gap changes more slowly than in an impact, >= 1.
   pure real(wp) function slowness(self, i)
      class(motion_type), intent(in) :: self
      !> Index of its way.
      integer, intent(in) :: i

      slowness = slow_way*self%scales%velocity/max(abs(self%way_rate(i)), self%way_speed(i), &
         tiny(slowness))
      slowness = min(max(1.0_wp, slowness), of_no_account**0.25_wp)**4
   end function slowness

   !> Unknowns on which the rate of a way depends: velocities of two bodies.
   subroutine way_columns(self, way, columns)
      class(motion_type), intent(in) :: self
      integer, intent(in) :: way
      !> Their indices, 0 for none.
      integer, intent(out) :: columns(way_columns_of)
      integer :: i

      columns = 0
      associate (contact => self%system%contacts(self%way(way)))
         ! Velocity and angular velocity follow one another.
         if (contact%a > 0) columns(:6) = body_size*(contact%a - 1) + at_velocity + [(i, i=0, 5)]
         if (contact%b > 0) columns(7:) = body_size*(contact%b - 1) + at_velocity + [(i, i=0, 5)]
      end associate
   end subroutine way_columns

   !> Derivatives of the rate of a way, where the right-hand side was evaluated last.
   subroutine way_slopes(self, way, slopes)
      class(motion_type), intent(inout) :: self
      integer, intent(in) :: way
      !> By the unknowns that `way_columns` names.
      real(wp), intent(out) :: slopes(way_columns_of)
      type(contact_motion_type) :: now

      call self%system%observe(self%way(way), now)
      slopes = 0.0_wp
      associate (contact => self%system%contacts(self%way(way)), pose => self%system%pose, &
         at => now%at)
         if (.not. contact%tangential%is_loaded() .and. at%gap >= contact%brink) return
         slopes(1:3) = -at%normal
         slopes(7:9) = at%normal
         if (contact%a > 0) slopes(4:6) = lever(pose(contact%a), -at%normal)
         if (contact%b > 0) slopes(10:12) = lever(pose(contact%b), at%normal)
      end associate

   contains

      !> Derivative of the velocity of a point along a direction by the angular velocity.
      pure function lever(pose, direction)
         type(pose_type), intent(in) :: pose
         real(wp), intent(in) :: direction(3)
         real(wp) :: lever(3)

         lever = to_body(pose%rotation, cross(now%at%point - pose%position, direction))
      end function lever

   end subroutine way_slopes

   !> Admissible local error of each unknown, whether it is of account or not.
   subroutine error_scales(self, y, size_of_error)
      class(motion_type), intent(in) :: self
      real(wp), intent(in) :: y(:)
      !> Admissible error.
      real(wp), intent(out) :: size_of_error(:)
      integer :: i, k

      associate (s => self%scales)
         do i = 1, size(self%system%bodies)
            k = body_size*(i - 1)
            call admit(y(k + 1:k + body_size), size_of_error(k + 1:k + body_size))
         end do
         if (self%system%layout%states > 0) call self%admit_states(y, size_of_error)
         do k = body_size*self%system%layout%bodies + self%system%layout%states + 1, self%n
            size_of_error(k) = s%rtol*max(s%energy, abs(y(k)))
         end do
      end associate

   contains

      !> Admissible errors of a body.
      subroutine admit(y, size_of_error)
         !> Its state.
         real(wp), intent(in) :: y(body_size)
         real(wp), intent(out) :: size_of_error(body_size)

         associate (s => self%scales)
            ! No finer than the rounding of the position itself.
            size_of_error(at_position:at_position + 2) = max(s%rtol*s%length, &
               64.0_wp*epsilon(s%rtol)*abs(y(at_position:at_position + 2)))
            if (self%remembers) size_of_error(at_position:at_position + 2) = max(s%rtol*s%length, &
               64.0_wp*epsilon(s%rtol)*norm2(y(at_position:at_position + 2)))
            size_of_error(at_quaternion:at_quaternion + 3) = s%rtol*s%rotation
            size_of_error(at_velocity:at_velocity + 2) = s%rtol*max(s%velocity, &
               norm2(y(at_velocity:at_velocity + 2)))
            size_of_error(at_spin:at_spin + 2) = s%rtol*max(s%angular_velocity, &
               norm2(y(at_spin:at_spin + 2)))
         end associate
      end subroutine admit

   end subroutine error_scales

   !> What is usual of each unknown: methods of other programs measure its error against its size
   !> and that. Of a position it is the size of a body; the length scale, which is a part of an
   !> overlap, would ask for more digits than such methods hold. Of an energy it is that of the
   !> motion at the beginning, or what lifting the bodies by their size takes.
   subroutine nominals(self, values)
      class(motion_type), intent(inout) :: self
      !> Larger than zero.
      real(wp), intent(out) :: values(:)
      type(scales_type) :: own
      real(wp) :: at_rest(size(values)), radius, smallest, lift
      integer :: i

      smallest = huge(smallest)
      lift = 0.0_wp
      do i = 1, size(self%system%bodies)
         associate (body => self%system%bodies(i))
            if (.not. body%mass > 0.0_wp) cycle
            radius = sqrt(maxval(body%inertia)/body%mass)
            smallest = min(smallest, radius)
            lift = lift + body%mass*norm2(self%system%gravity)*radius
         end associate
      end do
      own = self%scales
      self%scales%rtol = 1.0_wp
      if (smallest < huge(smallest)) self%scales%length = max(smallest, own%length)
      self%scales%energy = max(own%energy, lift)
      at_rest = 0.0_wp
      call self%error_scales(at_rest, values)
      self%scales = own
      where (.not. values > 0.0_wp) values = 1.0_wp
   end subroutine nominals

   !> Admissible local errors of the states of parts: those of a vector against its length.
   subroutine admit_states(self, y, size_of_error)
      class(motion_type), intent(in) :: self
      !> State.
      real(wp), intent(in) :: y(:)
      !> Admissible error.
      real(wp), intent(inout) :: size_of_error(:)
      integer :: i, j, k, n

      do i = 1, size(self%system%contacts)
         associate (states => self%system%contacts(i)%states)
            if (states%n == 0) cycle
            k = states%first
            do j = 1, size(states%items)
               n = merge(3, 1, states%items(j)%tangent)
               size_of_error(k:k + n - 1) = self%scales%rtol*self%scales%of_state(states%items(j))
               size_of_error(k:k + n - 1) = max(size_of_error(k), norm2(y(k:k + n - 1)) &
                  *merge(64.0_wp*epsilon(y), self%scales%rtol, states%items(j)%absolute))
               k = k + n
            end do
         end associate
      end do
   end subroutine admit_states

   !> Overlap of a contact that is usual [m].
   pure real(wp) function usual_overlap(self)
      class(scales_type), intent(in) :: self

      usual_overlap = overlap_over_length*self%length
   end function usual_overlap

   !> Value of a state against which its error counts as soon as the state is smaller.
   pure function of_state(self, item) result(scale)
      class(scales_type), intent(in) :: self
      type(state_type), intent(in) :: item
      real(wp) :: scale

      select case (item%against)
      case (against_length)
         scale = self%length
      case (against_velocity)
         scale = self%velocity
      case (against_angular_velocity)
         scale = self%angular_velocity
      case (against_energy)
         scale = self%energy
      case default
         scale = 1.0_wp
      end select
      scale = scale*item%scale
   end function of_state

   !> Tell the contacts against what differences of their states are small.
   subroutine set_state_scales(motion)
      class(motion_type), intent(inout) :: motion
      integer :: i, j, k, n

      do i = 1, size(motion%system%contacts)
         associate (states => motion%system%contacts(i)%states)
            if (states%n == 0) cycle
            k = 0
            do j = 1, size(states%items)
               n = merge(2, 1, states%items(j)%tangent)
               states%scales(k + 1:k + n) = motion%scales%of_state(states%items(j))
               k = k + n
            end do
         end associate
      end do
   end subroutine set_state_scales

end module contensou_integrate_motion
