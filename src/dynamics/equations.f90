!> The equations of motion of bodies with contacts.
!>
!> Newton-Euler: m v' = m g + F, I w' = T - w x (I w) about the principal axes.
!>
!> Where the curvatures of a pair change with its pose, the elastic energy U(d, A, B) of a contact
!> acts on the pose through them, too: the generalised forces -dU/dA and -dU/dB are part of the
!> load, so that the contact conserves energy. They are smaller than the normal force by the
!> approach over the radii.
!>
!> Rigid contacts come last: their normal forces follow from the accelerations that all the rest
!> gives.
module contensou_dynamics_equations
   use, intrinsic :: ieee_arithmetic, only : ieee_is_nan
   use contensou_base_kinds, only : wp
   use contensou_base_rotations, only : quaternion_rate, to_body, to_inertial
   use contensou_base_vectors, only : cross
   use contensou_contact_geometry, only : contact_motion_type, search_trouble, trouble_none, &
      trouble_still
   use contensou_contact_law, only : contact_load_type
   use contensou_dynamics_constraints, only : constraints_type
   use contensou_dynamics_mechanism, only : body_type, contact_type, mechanism_type, &
      relative_motion
   use contensou_dynamics_scene, only : motion_fixed, motion_free, motion_prescribed, &
      motion_rotor, motion_spindle, moves_freely, turns_by_drive
   use contensou_dynamics_springs, only : spring_load_type
   use contensou_dynamics_state, only : at_position, at_quaternion, at_spin, at_velocity, body_size
   implicit none(type, external)
   private

   public :: system_type, add_contacts, add_springs

   !> Multiple of the largest approach up to which a right-hand side is evaluated.
   real(wp), parameter :: far_beyond = 4.0_wp

   !> Unknowns beyond this (in SI units) are those of a trial state that ran away.
   real(wp), parameter :: runaway = 1.0e50_wp

   !> What acts on a body.
   type :: body_load_type
      !> Force [N], inertial frame.
      real(wp) :: force(3) = 0.0_wp
      !> Torque about the centre of mass [N m], inertial frame.
      real(wp) :: torque(3) = 0.0_wp
   end type body_load_type

   !> The equations of motion, with the space they need; one instance per thread.
   type, extends(mechanism_type) :: system_type
      !> Contact whose approach was beyond what Hertz's theory admits in the last call of
      !> `derivative`; 0 for none.
      integer :: too_deep = 0
      !> Contact whose geometry failed in the last call of `derivative`, for the reason in its
      !> track; 0 for none.
      integer :: trouble = 0
      !> What failed there, one of the `trouble_*` codes.
      integer :: trouble_code = trouble_none
      !> Whether it was so far beyond, as in a step that is too large, that nothing was evaluated.
      !> Up to that an integrator comes to the limit in a step and not in ever smaller ones.
      logical :: outside = .false.
      !> End of a ramp of a drive to which that very time still belongs, as an integration goes up
      !> to it [s]; negative for none.
      real(wp) :: corner = -1.0_wp
      type(constraints_type) :: constraints
      !> Whether contacts remember what is not part of the state.
      logical :: remembers = .false.
      !> What acts on the bodies, and their weights.
      type(body_load_type), allocatable :: load(:)
      type(body_load_type), allocatable, private :: weight(:)
      !> Room for a right-hand side that is evaluated for the sake of the normal forces.
      real(wp), allocatable, private :: scratch(:)
      logical, private :: has_springs = .false.
      !> Whether there are rigid contacts or states of parts.
      logical, private :: has_more = .false.
   contains
      procedure :: prepare
      procedure :: derivative
      procedure :: static_loads
      procedure :: contact_load
      procedure :: constraint_forces
      procedure :: evaluate_memory
      procedure, private, non_overridable :: complete
      procedure :: next_corner
      procedure, private, non_overridable :: ramps
   end type system_type

contains

   !> Lay out the state and the workspace.
   subroutine prepare(self)
      class(system_type), intent(inout) :: self
      logical :: rubs, damps, supplied
      integer :: i, nb, states

      nb = size(self%bodies)
      rubs = .false.
      damps = any(self%contacts%rigid)
      do i = 1, size(self%contacts)
         associate (law => self%contacts(i)%law)
            rubs = rubs .or. allocated(law%friction) .or. allocated(law%rolling)
            damps = damps .or. allocated(law%damping)
         end associate
      end do
      if (.not. allocated(self%springs)) allocate(self%springs(0))
      self%has_springs = size(self%springs) > 0
      do i = 1, size(self%springs)
         damps = damps .or. self%springs(i)%damps()
      end do
      supplied = .false.
      do i = 1, nb
         supplied = supplied .or. self%bodies(i)%loaded .or. turns_by_drive(self%bodies(i)%motion)
      end do
      states = 0
      do i = 1, size(self%contacts)
         self%contacts(i)%states%first = body_size*nb + states + 1
         states = states + self%contacts(i)%states%n
         self%contacts(i)%evolves = self%contacts(i)%states%n > 0 &
            .or. allocated(self%contacts(i)%law%steady)
      end do
      call self%layout%lay_out(nb, states, rubs, damps, supplied)
      if (allocated(self%pose)) deallocate(self%pose, self%load, self%weight, self%scratch)
      allocate(self%pose(0:nb), self%load(nb), self%weight(nb), self%scratch(self%layout%n))
      if (norm2(self%gravity) > 0.0_wp) then
         do i = 1, nb
            if (moves_freely(self%bodies(i)%motion)) self%weight(i)%force = &
               self%bodies(i)%mass*self%gravity
         end do
      end if
      self%pose(0)%ground = .true.
      call self%constraints%prepare(self%mechanism_type)
      self%remembers = any([(allocated(self%contacts(i)%tangential), i=1, &
         size(self%contacts))])
      self%has_more = self%constraints%n_rigid > 0 .or. states > 0
   end subroutine prepare

   !> Time derivative of the state. Allocates nothing.
   subroutine derivative(self, t, y, rate)
      !> The system; its workspace is changed, `too_deep`, `trouble` and `outside`.
      class(system_type), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(self%layout%n)
      !> Its time derivative; not set when `outside`.
      real(wp), intent(out) :: rate(self%layout%n)
      integer :: i, k
      real(wp) :: friction_power, damping_power, applied_power

      self%too_deep = 0
      ! The stage of a step that is far too long can be anywhere, also where its squares overflow.
      ! Counted, as that is done for several at a time.
      self%outside = count(abs(y) < runaway) < self%layout%n
      if (self%outside) return
      call self%set_poses(y)
      if (self%layout%states > 0) call self%set_states(y)
      friction_power = 0.0_wp
      damping_power = 0.0_wp
      call gather_loads(self, friction_power, damping_power, applied_power)
      if (self%outside) return
      if (self%layout%applied > 0) rate(self%layout%applied) = applied_power
      do i = 1, size(self%bodies)
         k = body_size*(i - 1)
         call accelerate(self, i, t, y(k + 1:k + body_size), rate(k + 1:k + body_size))
      end do
      if (self%has_more) then
         call self%complete(rate, friction_power)
         if (self%outside) return
      end if
      if (self%layout%friction > 0) rate(self%layout%friction) = friction_power
      if (self%layout%damping > 0) rate(self%layout%damping) = damping_power
   end subroutine derivative

   !> Loads of a system at the poses that are set, its states of parts set too; `outside` if a
   !> contact is out of bounds.
   subroutine gather_loads(self, friction_power, damping_power, applied_power)
      type(system_type), intent(inout) :: self
      !> Power lost in friction [W], added to.
      real(wp), intent(inout) :: friction_power
      !> Power lost in damping [W], added to.
      real(wp), intent(inout) :: damping_power
      !> Power that loads and drives supply [W].
      real(wp), intent(out) :: applied_power
      integer :: i

      do i = 1, size(self%bodies)
         self%load(i) = self%weight(i)
      end do
      applied_power = 0.0_wp
      call add_contacts(self, friction_power, damping_power)
      if (self%outside) return
      if (self%has_springs) call add_springs(self, damping_power)
      if (self%layout%applied > 0) call apply_loads(self, applied_power)
   end subroutine gather_loads

   !> Loads of a system without states of parts at the poses that are set, in `load`; `outside` if a
   !> contact is out of bounds.
   subroutine static_loads(self)
      class(system_type), intent(inout) :: self
      real(wp) :: friction_power, damping_power, applied_power

      self%too_deep = 0
      self%outside = .false.
      friction_power = 0.0_wp
      damping_power = 0.0_wp
      call gather_loads(self, friction_power, damping_power, applied_power)
   end subroutine static_loads

   !> What a compliant contact alone does to its bodies at a state; `outside` if it is out of
   !> bounds.
   subroutine contact_load(self, index, y, force, torque)
      class(system_type), intent(inout) :: self
      integer, intent(in) :: index
      real(wp), intent(in) :: y(:)
      !> Force on body B [N], inertial frame; that on A is its reverse.
      real(wp), intent(out) :: force(3)
      !> Torques on A and on B about their centres of mass, of the ground about the origin [N m].
      real(wp), intent(out) :: torque(3, 2)
      real(wp) :: friction_power, damping_power

      friction_power = 0.0_wp
      damping_power = 0.0_wp
      self%too_deep = 0
      self%outside = .false.
      call self%set_poses(y)
      if (self%layout%states > 0) call self%set_states(y)
      associate (a => self%contacts(index)%a, b => self%contacts(index)%b)
         if (a > 0) self%load(a) = body_load_type()
         if (b > 0) self%load(b) = body_load_type()
         call add_contact(self, self%contacts(index), index, friction_power, damping_power)
         if (b > 0) then
            force = self%load(b)%force
            torque(:, 2) = self%load(b)%torque
            torque(:, 1) = -torque(:, 2) - cross(self%pose(b)%position, force)
         else
            force = -self%load(a)%force
         end if
         if (a > 0) torque(:, 1) = self%load(a)%torque
         if (b == 0) torque(:, 2) = -torque(:, 1) + cross(self%pose(a)%position, force)
      end associate
   end subroutine contact_load

   !> Add what the closed rigid contacts do to the accelerations, and the rates of the states of
   !> parts, which are constant while a contact is open.
   subroutine complete(self, rate, friction_power)
      class(system_type), intent(inout) :: self
      !> Time derivative of the state, without rigid contacts on entry.
      real(wp), intent(inout) :: rate(:)
      !> Power lost in friction so far [W].
      real(wp), intent(inout) :: friction_power
      integer :: i

      if (self%constraints%n_rigid > 0) call self%constraints%apply(self%mechanism_type, rate, &
         friction_power, self%trouble, self%trouble_code, self%outside)
      if (self%outside .or. self%layout%states == 0) return
      do i = 1, size(self%contacts)
         associate (states => self%contacts(i)%states)
            if (states%n > 0) rate(states%first:states%first + states%n - 1) = states%rates
         end associate
      end do
   end subroutine complete

   !> Normal forces of the closed rigid contacts at a state, in their components `normal_force`.
   subroutine constraint_forces(self, t, y)
      !> The system; as after a right-hand side, which is only evaluated if one is closed.
      class(system_type), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)

      self%constraints%n_links = 0
      self%outside = .false.
      if (any(self%contacts%closed)) call self%derivative(t, y, self%scratch)
   end subroutine constraint_forces

   !> Let the contacts with tangential elasticity evaluate a state, which they may then remember;
   !> where it is the last one again their shells are not moved again.
   subroutine evaluate_memory(self, t, y)
      !> The system; its workspace is changed.
      class(system_type), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)
      type(contact_motion_type) :: now
      type(contact_load_type) :: load
      integer :: i, trouble

      ! The loads of rigid contacts follow from the accelerations.
      if (self%constraints%n_rigid > 0) call self%constraint_forces(t, y)
      call self%set_poses(y)
      call self%set_states(y)
      do i = 1, size(self%contacts)
         associate (contact => self%contacts(i), a => self%pose(self%contacts(i)%a), &
            b => self%pose(self%contacts(i)%b))
            if (.not. allocated(contact%tangential)) cycle
            if (contact%rigid) then
               if (.not. contact%closed) call contact%tangential%part()
               cycle
            end if
            call self%observe(i, now)
            trouble = trouble_none
            if (now%at%gap < 0.0_wp) call contact%follow(now%at, trouble)
            if (now%at%gap < 0.0_wp .and. trouble == trouble_none) then
               contact%tangential%may_be_same = .true.
               call contact%evolve(a, b, now, 0.0_wp, load)
               contact%tangential%may_be_same = .false.
            else
               call contact%tangential%part()
            end if
         end associate
      end do
   end subroutine evaluate_memory

   !> Add the loads of all compliant contacts to the bodies; `outside` if one is out of bounds.
   subroutine add_contacts(self, friction_power, damping_power)
      !> The system at the poses that are set.
      type(system_type), intent(inout) :: self
      !> Power lost in friction [W], added to.
      real(wp), intent(inout) :: friction_power
      !> Power lost in damping [W], added to.
      real(wp), intent(inout) :: damping_power
      integer :: i

      do i = 1, size(self%contacts)
         if (self%contacts(i)%rigid) cycle
         call add_contact(self, self%contacts(i), i, friction_power, damping_power)
         if (self%outside) return
      end do
   end subroutine add_contacts

   !> Add the loads of all springs to the bodies.
   subroutine add_springs(self, damping_power)
      !> The system at the poses that are set.
      type(system_type), intent(inout) :: self
      !> Power lost in damping [W], added to.
      real(wp), intent(inout) :: damping_power
      type(spring_load_type) :: found
      integer :: i

      do i = 1, size(self%springs)
         associate (spring => self%springs(i))
            call spring%load(self%pose(spring%a), self%pose(spring%b), found)
            damping_power = damping_power + found%power
            if (spring%a > 0) then
               associate (load => self%load(spring%a))
                  load%force = load%force - found%force
                  load%torque = load%torque - found%torque - cross(found%arm_a, found%force)
               end associate
            end if
            if (spring%b > 0) then
               associate (load => self%load(spring%b))
                  load%force = load%force + found%force
                  load%torque = load%torque + found%torque + cross(found%arm_b, found%force)
               end associate
            end if
         end associate
      end do
   end subroutine add_springs

   !> Add the applied loads to the bodies; power supplied by them and by the drives.
   subroutine apply_loads(self, power)
      !> The system; forces and torques hold those of the contacts.
      type(system_type), intent(inout) :: self
      !> Power [W], increased by what is supplied.
      real(wp), intent(inout) :: power
      real(wp) :: force(3), torque(3)
      integer :: i

      do i = 1, size(self%bodies)
         associate (body => self%bodies(i), pose => self%pose(i))
            if (body%motion == motion_prescribed) then
               ! What keeps the motion against the contacts; its own inertia is not counted.
               power = power - dot_product(self%load(i)%force, pose%velocity) &
                  - dot_product(self%load(i)%torque, pose%spin)
            else if (body%motion == motion_spindle) then
               power = power - dot_product(self%load(i)%torque, pose%spin)
            end if
            if (body%loaded) then
               force = body%force
               torque = body%torque
               if (body%load_follows) then
                  force = matmul(pose%rotation, force)
                  torque = matmul(pose%rotation, torque)
               end if
               self%load(i)%force = self%load(i)%force + force
               self%load(i)%torque = self%load(i)%torque + torque
               power = power + dot_product(force, pose%velocity) + dot_product(torque, pose%spin)
            end if
            if (body%motion == motion_rotor) then
               ! What keeps it turning about its axis.
               power = power - dot_product(self%load(i)%torque, pose%rotation(:, 3)) &
                  *dot_product(pose%spin, pose%rotation(:, 3))
            end if
         end associate
      end do
   end subroutine apply_loads

   !> Time derivative of the state of a body.
   subroutine accelerate(self, index, t, y, rate)
      type(system_type), intent(in) :: self
      integer, intent(in) :: index
      !> Time [s].
      real(wp), intent(in) :: t
      !> State of the body.
      real(wp), intent(in) :: y(body_size)
      !> Its time derivative.
      real(wp), intent(out) :: rate(body_size)
      real(wp) :: w(3), moment(3)

      associate (body => self%bodies(index), acceleration => rate(at_velocity:at_velocity + 2), &
         turning => rate(at_spin:at_spin + 2))
         if (body%motion == motion_fixed) then
            rate = 0.0_wp
            return
         end if
         w = y(at_spin:at_spin + 2)
         rate(at_position:at_position + 2) = y(at_velocity:at_velocity + 2)
         rate(at_quaternion:at_quaternion + 3) = quaternion_rate( &
            y(at_quaternion:at_quaternion + 3), w)
         if (moves_freely(body%motion)) then
            acceleration = self%load(index)%force/body%mass
         else if (self%ramps(body, t)) then
            acceleration = body%acceleration
         else
            acceleration = 0.0_wp
         end if
         if (body%motion == motion_free .or. body%motion == motion_rotor) then
            ! In two statements: gfortran takes memory for the sum of a product and a function.
            moment = to_body(self%pose(index)%rotation, self%load(index)%torque)
            turning = (moment - cross(w, body%inertia*w))/body%inertia
            if (body%motion == motion_rotor) turning(3) = merge(body%angular_acceleration(3), &
               0.0_wp, self%ramps(body, t))
         else if (self%ramps(body, t)) then
            turning = matmul(body%angular_acceleration, self%pose(index)%rotation)
         else
            turning = 0.0_wp
         end if
         if (body%is_guided) then
            if (.not. moves_freely(body%motion)) acceleration = acceleration + body%guided
            turning = turning + to_body(self%pose(index)%rotation, body%guided_turning)
         end if
      end associate
   end subroutine accelerate

   !> Whether the drive of a body is on its ramp.
   pure logical function ramps(self, body, t)
      class(system_type), intent(in) :: self
      type(body_type), intent(in) :: body
      !> Time [s].
      real(wp), intent(in) :: t

      ramps = t < body%ramp .or. (t <= self%corner .and. self%corner <= body%ramp)
   end function ramps

   !> The first time after another at which the ramp of a drive ends [s]; huge for none.
   pure function next_corner(self, t) result(corner)
      class(system_type), intent(in) :: self
      !> The other time [s].
      real(wp), intent(in) :: t
      real(wp) :: corner

      corner = minval(self%bodies%ramp, mask=self%bodies%ramp > t)
   end function next_corner

   !> Add the load of a contact to its bodies.
   subroutine add_contact(self, contact, index, friction_power, damping_power)
      type(system_type), intent(inout) :: self
      type(contact_type), intent(inout) :: contact
      integer, intent(in) :: index
      !> Power lost in friction so far [W].
      real(wp), intent(inout) :: friction_power
      !> Power lost in damping so far [W].
      real(wp), intent(inout) :: damping_power
      real(wp) :: gap

      call contact%find_gap(self%pose(contact%a), self%pose(contact%b), gap)
      if (contact%track%lost) then
         call leave_domain(self, index, search_trouble(contact%track))
      else if (gap < 0.0_wp) then
         call add_closed(self, contact, index, gap, friction_power, damping_power)
      else if (gap < contact%brink) then
         call contact%slide(self%pose(contact%a), self%pose(contact%b), gap)
      end if
   end subroutine add_contact

   !> Note that a contact is out of the domain of its model.
   pure subroutine leave_domain(self, index, code)
      type(system_type), intent(inout) :: self
      !> The contact, and why.
      integer, intent(in) :: index, code

      self%outside = .true.
      self%trouble = index
      self%trouble_code = code
   end subroutine leave_domain

   !> Add the load of a closed contact. Apart, as its variables begin with values that an open one
   !> would pay for.
   subroutine add_closed(self, contact, index, gap, friction_power, damping_power)
      type(system_type), intent(inout) :: self
      type(contact_type), intent(inout) :: contact
      integer, intent(in) :: index
      !> Its gap [m], < 0.
      real(wp), intent(in) :: gap
      !> Power lost in friction so far [W].
      real(wp), intent(inout) :: friction_power
      !> Power lost in damping so far [W].
      real(wp), intent(inout) :: damping_power
      type(contact_motion_type) :: now
      type(contact_load_type) :: load
      real(wp) :: deepest, force(3), torque(3), resolution
      real(wp) :: shape_force(6)
      integer :: trouble

      associate (a => self%pose(contact%a), b => self%pose(contact%b), at => now%at)
         contact%felt = max(contact%felt, -gap)
         if (-gap > contact%law%largest_approach) then
            deepest = contact%deepest(a, b, gap)
            if (-gap > deepest) self%too_deep = index
            self%outside = -gap > far_beyond*deepest
            if (self%outside) return
         end if
         call contact%locate(a, b, gap, at)
         if (.not. contact%law%geometry%constant_curvatures) then
            call contact%follow(at, trouble)
            if (trouble /= trouble_none) then
               call leave_domain(self, index, trouble)
               return
            end if
         end if
         if (allocated(contact%law%curved)) call contact%bend(a, b, at)
         call relative_motion(a, b, at%point, now%velocity, now%spin)
         resolution = self%resolution%of(a, b, at%point)
         if (contact%evolves) then
            call contact%evolve(a, b, now, resolution, load)
            if (allocated(contact%law%steady) .and. ieee_is_nan(load%friction_force(1))) then
               call leave_domain(self, index, trouble_still)
               return
            end if
         else
            call contact%law%evaluate(now, resolution, load)
         end if
         force = load%normal_force*at%normal
         torque = 0.0_wp
         if (allocated(contact%law%friction)) then
            force = force + load%friction_force
            torque = load%friction_torque*at%normal
            friction_power = friction_power + load%friction_power
            if (allocated(contact%law%curved)) torque = torque + load%curvature_moment
         end if
         if (allocated(contact%law%rolling)) then
            torque = torque + load%rolling_torque
            if (.not. allocated(contact%law%friction)) then
               friction_power = friction_power + load%friction_power
            end if
         end if
         if (.not. contact%law%geometry%constant_curvatures) then
            call contact%shape_force(a, b, at, shape_force)
            force = force + shape_force(1:3)
            torque = torque + shape_force(4:6)
         end if
         damping_power = damping_power + load%damping_power
         if (contact%a > 0) then
            self%load(contact%a)%force = self%load(contact%a)%force - force
            self%load(contact%a)%torque = self%load(contact%a)%torque - torque &
               - cross(at%point - a%position, force)
         end if
         if (contact%b > 0) then
            self%load(contact%b)%force = self%load(contact%b)%force + force
            self%load(contact%b)%torque = self%load(contact%b)%torque + torque &
               + cross(at%point - b%position, force)
         end if
      end associate
   end subroutine add_closed

end module contensou_dynamics_equations
