!> Bodies and contacts at a state: what they are, where they are, and how the surfaces of a contact
!> lie and move against each other.
!>
!> All that asks for gap, contact point, curvatures or relative motion of a contact does so here:
!> `find_gap`, and where the surfaces overlap `locate`, `follow` and `relative_motion`, or the
!> kinematics of any contact at once by `observe`.
module contensou_dynamics_mechanism
   use, intrinsic :: ieee_arithmetic, only : ieee_is_nan
   use contensou_base_checkpoint, only : checkpoint_type
   use contensou_base_kinds, only : i8, wp
   use contensou_base_rotations, only : rotation_matrix, set_rotation, to_inertial, &
      unit_quaternion
   use contensou_base_vectors, only : cross
   use contensou_contact_geometry, only : contact_motion_type, contact_point_type, &
      contact_trouble, contact_variation_type, pose_type, rolling_velocity, track_type, &
      trouble_no_spot, trouble_none, unbounded
   use contensou_contact_law, only : along_axes, contact_law_type, contact_load_type
   use contensou_contact_states, only : contact_states_type, most_states, state_list_type
   use contensou_contact_tangential_memory, only : tangential_type
   use contensou_dynamics_scene, only : motion_free
   use contensou_dynamics_springs, only : spring_type
   use contensou_dynamics_state, only : at_position, at_quaternion, at_spin, at_velocity, &
      body_size, layout_type, position_of, quaternion_of, spin_of, velocity_of
   implicit none(type, external)
   private

   public :: mechanism_type, body_type, contact_type, gap_type, resolution_type
   public :: frame_spin, relative_motion, slip_velocity

   !> Inertia of a rigid body, and what drives it.
   type :: body_type
      !> One of the `motion_*` codes.
      integer :: motion = motion_free
      !> Mass [kg].
      real(wp) :: mass = 0.0_wp
      !> Principal moments of inertia [kg m2].
      real(wp) :: inertia(3) = 0.0_wp
      !> Whether a force or a torque is applied to a body that moves freely.
      logical :: loaded = .false.
      !> Whether it turns with the body.
      logical :: load_follows = .false.
      !> Force applied at the centre of mass [N].
      real(wp) :: force(3) = 0.0_wp
      !> Torque applied [N m].
      real(wp) :: torque(3) = 0.0_wp
      !> Duration of the ramp of a prescribed motion or rotation [s].
      real(wp) :: ramp = 0.0_wp
      !> Acceleration during the ramp [m/s2], inertial frame.
      real(wp) :: acceleration(3) = 0.0_wp
      !> Angular acceleration during the ramp [rad/s2], inertial frame; of a rotor body frame.
      real(wp) :: angular_acceleration(3) = 0.0_wp
      !> Whether another program accelerates a drive beside that: by so much [m/s2], [rad/s2],
      !> inertial frame.
      logical :: is_guided = .false.
      real(wp) :: guided(3) = 0.0_wp, guided_turning(3) = 0.0_wp
   end type body_type

   !> Two bodies and the law between them.
   type :: contact_type
      !> Body A; 0 is the ground.
      integer :: a = 0
      !> Body B; 0 is the ground.
      integer :: b = 0
      type(contact_law_type) :: law
      !> Which of the spots of the two surfaces it is, and how many there are; these follow one
      !> another.
      integer :: spot = 1, spots = 1
      !> Largest overlap at which its force was evaluated since this was set to zero [m].
      real(wp) :: felt = 0.0_wp
      !> States of its parts.
      type(contact_states_type) :: states
      !> Whether its load needs more than `evaluate` of the law: states of parts, or what rolls.
      logical :: evolves = .false.
      !> Tangential elasticity; unallocated for none.
      type(tangential_type), allocatable :: tangential
      !> Gap below which the shifts of such a contact follow the sliding already [m]: as good as
      !> zero, but more than rounding, so that their rates have no step where the surfaces touch.
      real(wp) :: brink = 0.0_wp
      !> Where the surfaces were closest last.
      type(track_type) :: track
      !> Whether the contact is rigid.
      logical :: rigid = .false.
      !> Whether a rigid contact is closed.
      logical :: closed = .false.
      !> Whether a rigid contact has opened and its gap is not yet distinct from zero.
      logical :: leaving = .false.
      !> Gap below which such a contact closes again [m]: just below that at which it opened. Pull
      !> at which a closed one lifts off [N]: just above that with which it began.
      real(wp) :: threshold = 0.0_wp
      !> Normal force of a closed rigid contact in the last right-hand side [N].
      real(wp) :: normal_force = 0.0_wp
      !> Restitution of a rigid contact [-], unless it depends on the speed.
      real(wp) :: restitution = 1.0_wp
      !> Hunt-Crossley coefficient alpha by which restitution depends on the speed [s/m]; 0 if it
      !> does not.
      real(wp) :: restitution_slope = 0.0_wp
      !> Largest coordinate of a body at which the contact is resolved [m].
      real(wp) :: largest_position = huge(1.0_wp)
      !> Radii about the centres of mass of A and B that hold their surfaces [m]; the largest number
      !> where a surface has no end.
      real(wp) :: reach(2) = huge(1.0_wp)
      !> Centres of the surfaces in the frames of their bodies [m].
      real(wp) :: centre(3, 2) = 0.0_wp
      !> Distances from these within which all normals of the surfaces pass [m], zero for spheres;
      !> the largest number where a surface has no end.
      real(wp) :: lever(2) = huge(1.0_wp)
   contains
      procedure :: find_gap
      procedure :: locate
      procedure :: follow
      procedure :: bend
      procedure :: curvatures_vary
      procedure :: deepest
      procedure :: shape_force
      procedure :: own
      procedure :: local_states
      procedure :: evolve
      procedure :: slide
      procedure :: set_rates
      procedure :: stored_energies
      procedure :: renew
      procedure :: exchange => exchange_contact
   end type contact_type

   !> Gap of a contact at an instant, and bounds of how it can go on.
   type :: gap_type
      !> Gap [m].
      real(wp) :: value = 0.0_wp
      !> Its rate [m/s].
      real(wp) :: rate = 0.0_wp
      !> Bound of the second derivative that the turning of the bodies makes [m/s2].
      real(wp) :: bend = 0.0_wp
      !> Where a surface is concave, bound of the rate from where it touches [m/s]; else 0. That of
      !> `fastest` holds wherever it touches, and is of no use where what turns has no end.
      real(wp) :: speed = 0.0_wp
      !> Bound of how strongly the gap bends down there, over the square of the speed [1/m]. Within
      !> half the inverse of that it cannot be more than twice as strong.
      real(wp) :: sharpness = 0.0_wp
   end type gap_type

   !> What an integrator resolves of the velocities at a contact.
   type :: resolution_type
      !> Relative resolution squared [-]; 0 if everything is resolved.
      real(wp) :: square = 0.0_wp
      !> Relative tolerance of the velocities after an impact [-].
      real(wp) :: tolerance = 1.0e-10_wp
      !> Square of the velocity below which it is absolute [m2/s2].
      real(wp) :: velocity = 0.0_wp
      !> Square of the angular velocity below which it is absolute [rad2/s2].
      real(wp) :: angular_velocity = 0.0_wp
   contains
      procedure :: of => resolution_of
   end type resolution_type

   !> Bodies and contacts, with what they remember of the last state.
   type :: mechanism_type
      !> Acceleration of gravity [m/s2].
      real(wp) :: gravity(3) = 0.0_wp
      !> Whether rigid contacts that touch at one instant impact at once, or one after the other.
      logical :: together = .false.
      !> Bodies, without the ground.
      type(body_type), allocatable :: bodies(:)
      type(contact_type), allocatable :: contacts(:)
      type(spring_type), allocatable :: springs(:)
      !> Which number of the state is where.
      type(layout_type) :: layout
      !> What an integrator resolves of the velocities at a contact.
      type(resolution_type) :: resolution
      !> Poses of the ground (0) and the bodies.
      type(pose_type), allocatable :: pose(:)
      !> How often they were set: where it is as before nothing was evaluated since.
      integer(i8) :: times_posed = 0
      !> Whether some gap is sought from where it was last.
      logical :: searches = .false.
      !> Whether there are contacts with several spots.
      logical :: several_spots = .false.
   contains
      procedure, non_overridable :: set_poses
      procedure, non_overridable :: set_states
      procedure :: pose_of
      procedure :: observe
      procedure :: gaps
      procedure :: gap_rates
      procedure :: gap_motion
      procedure :: fastest
   end type mechanism_type

contains

   !> Write what a contact remembers to a checkpoint or read it back.
   subroutine exchange_contact(self, checkpoint)
      class(contact_type), intent(inout) :: self
      type(checkpoint_type), intent(inout) :: checkpoint

      call self%track%exchange(checkpoint)
      call checkpoint%exchange("closed", self%closed)
      call checkpoint%exchange("leaving", self%leaving)
      call checkpoint%exchange("threshold", self%threshold)
      call checkpoint%exchange("normal_force", self%normal_force)
      if (allocated(self%law%damping)) call self%law%damping%exchange(checkpoint)
      if (allocated(self%tangential)) call self%tangential%exchange(checkpoint)
   end subroutine exchange_contact

   !> Gap of a contact.
   subroutine find_gap(self, a, b, gap)
      !> The contact; its track is changed, and says whether the search has failed.
      class(contact_type), intent(inout) :: self
      type(pose_type), intent(in) :: a
      type(pose_type), intent(in) :: b
      !> Gap, negative for overlap [m].
      real(wp), intent(out) :: gap

      call self%law%geometry%gap(a, b, self%track, gap)
   end subroutine find_gap

   !> Contact point, normal and curvatures.
   subroutine locate(self, a, b, gap, at)
      class(contact_type), intent(in) :: self
      type(pose_type), intent(in) :: a
      type(pose_type), intent(in) :: b
      !> Gap of these poses [m].
      real(wp), intent(in) :: gap
      type(contact_point_type), intent(out) :: at

      call self%law%geometry%locate(a, b, self%track, gap, at)
   end subroutine locate

   !> Let the normal part follow the curvatures if they vary; trouble where there is no spot.
   subroutine follow(self, at, trouble)
      class(contact_type), intent(inout) :: self
      !> Where it touches.
      type(contact_point_type), intent(in) :: at
      !> One of the `trouble_*` codes.
      integer, intent(out) :: trouble

      trouble = trouble_none
      if (self%law%geometry%constant_curvatures) return
      trouble = contact_trouble(self%track, at)
      if (trouble /= trouble_none) return
      call self%law%normal%follow(at%curvature_a, at%curvature_b)
      if (ieee_is_nan(self%law%normal%axis_a)) trouble = trouble_no_spot
      if (allocated(self%law%steady)) call self%law%steady%follow(self%law%normal%shape, .false.)
   end subroutine follow

   !> Let a curved spot have the curvature of the surfaces where they touch.
   subroutine bend(self, a, b, at)
      !> The contact; its gap was just found, its spot is curved.
      class(contact_type), intent(inout) :: self
      type(pose_type), intent(in) :: a
      type(pose_type), intent(in) :: b
      !> Where it touches.
      type(contact_point_type), intent(in) :: at

      call self%law%geometry%mean_form(a, b, self%track, at, self%law%curved%form)
   end subroutine bend

   !> Largest approach that Hertz's theory admits where the surfaces touch [m]. Where curvatures
   !> vary it goes by the largest relative curvature there, which for two convex surfaces is at
   !> least the larger one of them; nowhere is it less than that of the smallest radius of the
   !> pair.
   real(wp) function deepest(self, a, b, gap)
      !> The contact; its gap was just found.
      class(contact_type), intent(inout) :: self
      type(pose_type), intent(in) :: a
      type(pose_type), intent(in) :: b
      real(wp), intent(in) :: gap
      type(contact_point_type) :: at

      deepest = self%law%largest_approach
      associate (geometry => self%law%geometry)
         if (geometry%constant_curvatures .or. geometry%into_hollow > 0.0_wp) return
         if (-gap <= deepest .or. self%track%lost) return
         call self%locate(a, b, gap, at)
         if (.not. at%curvature_b > 0.0_wp) return
         deepest = deepest*max(1.0_wp, 0.5_wp/(at%curvature_b*geometry%smallest_radius()))
      end associate
   end function deepest

   !> Whether the elastic energy depends on the pose through the curvatures, too.
   elemental logical function curvatures_vary(self)
      class(contact_type), intent(in) :: self

      curvatures_vary = .not. (self%rigid .or. self%law%geometry%constant_curvatures)
   end function curvatures_vary

   !> Force and torque on B about the contact point by which the elastic energy resists a change of
   !> the curvatures [N, N m].
   subroutine shape_force(self, a, b, at, force)
      !> The contact; its normal part has followed.
      class(contact_type), intent(in) :: self
      type(pose_type), intent(in) :: a
      type(pose_type), intent(in) :: b
      !> Where it touches, closed.
      type(contact_point_type), intent(in) :: at
      !> Force (1:3) and torque (4:6), inertial frame.
      real(wp), intent(out) :: force(6)
      type(contact_variation_type) :: variation
      real(wp) :: force_a, force_b

      call self%law%geometry%vary(a, b, self%track, at, variation)
      call self%law%normal%curvature_forces(-at%gap, force_a, force_b)
      force = force_a*variation%curvature_a + force_b*variation%curvature_b
   end subroutine shape_force

   !> Take the states of its parts.
   subroutine own(self, damping, friction)
      class(contact_type), intent(inout) :: self
      type(state_list_type), intent(in) :: damping
      type(state_list_type), intent(in) :: friction

      call self%states%own(damping, friction)
      self%law%n_damping = self%states%n_damping
   end subroutine own

   !> States of the parts as these see them.
   pure function local_states(self, at) result(local)
      class(contact_type), intent(in) :: self
      !> Where it touches.
      type(contact_point_type), intent(in) :: at
      real(wp) :: local(most_states)

      if (self%states%n == 0) then
         local = 0.0_wp
         return
      end if
      call self%states%gather(self%states%values, at%major, cross(at%normal, at%major), local)
   end function local_states

   !> Load of a closed contact at the states of its parts, and the rates of these.
   subroutine evolve(self, a, b, now, resolution, load)
      !> The contact; its normal part has followed, the rates are set.
      class(contact_type), intent(inout) :: self
      type(pose_type), intent(in) :: a
      type(pose_type), intent(in) :: b
      !> Where it touches, its gap < 0, and how it moves.
      type(contact_motion_type), intent(in) :: now
      !> Square of the velocity below which sliding is not resolved [m2/s2].
      real(wp), intent(in) :: resolution
      type(contact_load_type), intent(out) :: load
      type(contact_variation_type) :: variation
      real(wp), parameter :: still(3) = 0.0_wp
      real(wp) :: local(most_states), rates(most_states)

      local = self%local_states(now%at)
      if (self%states%tangent .or. allocated(self%law%steady)) call self%law%geometry%vary(a, b, &
         self%track, now%at, variation)
      associate (n => self%states%n_local)
         if (allocated(self%tangential)) then
            ! What only shears the spot, to and fro, carries nothing out of it.
            call self%law%hold(now, rolling_velocity(variation, still, now%spin), local(:n), &
               self%tangential, load, rates(:n))
         else if (allocated(self%law%steady)) then
            call self%law%roll(now, rolling_velocity(variation, now%velocity, now%spin), &
               resolution, local(:n), load, rates(:n))
         else
            call self%law%evolve(now, resolution, local(:n), load, rates(:n))
         end if
         if (n > 0) call self%set_rates(a, b, now, rates(:n), variation)
      end associate
   end subroutine evolve

   !> Rates of the states where surfaces with tangential elasticity are about to touch.
   subroutine slide(self, a, b, gap)
      !> The contact, compliant; the rates of its states are set.
      class(contact_type), intent(inout) :: self
      type(pose_type), intent(in) :: a
      type(pose_type), intent(in) :: b
      !> Its gap [m].
      real(wp), intent(in) :: gap
      type(contact_motion_type) :: now
      type(contact_variation_type) :: variation
      real(wp) :: local(most_states), rates(most_states), minor(3), carried(3)
      integer :: trouble

      call self%locate(a, b, gap, now%at)
      if (.not. self%law%geometry%constant_curvatures) then
         call self%follow(now%at, trouble)
         ! It is told of at the touch.
         if (trouble /= trouble_none) return
      end if
      call relative_motion(a, b, now%at%point, now%velocity, now%spin)
      call self%law%geometry%vary(a, b, self%track, now%at, variation)
      local = self%local_states(now%at)
      associate (n => self%states%n_local, nd => self%states%n_damping)
         rates = 0.0_wp
         minor = cross(now%at%normal, now%at%major)
         carried = rolling_velocity(variation, [0.0_wp, 0.0_wp, 0.0_wp], now%spin)
         rates(nd + 1:n) = self%tangential%free_rates(self%law%normal%shape, along_axes(now, &
            minor), [dot_product(carried, now%at%major), dot_product(carried, minor)], &
            local(nd + 1:n))
         call self%set_rates(a, b, now, rates(:n), variation)
      end associate
   end subroutine slide

   !> Rates of the states in the inertial frame, from those that the parts give.
   subroutine set_rates(self, a, b, now, rates, variation)
      class(contact_type), intent(inout) :: self
      type(pose_type), intent(in) :: a
      type(pose_type), intent(in) :: b
      !> Where it touches and how it moves.
      type(contact_motion_type), intent(in) :: now
      !> Rates along the axes of the spot.
      real(wp), intent(in) :: rates(:)
      !> Variation of where it touches; needed where there are vectors among the states.
      type(contact_variation_type), intent(in) :: variation

      associate (states => self%states, at => now%at)
         states%rates = 0.0_wp
         call states%scatter(rates, at%major, cross(at%normal, at%major), states%rates)
         if (states%tangent) call states%turn(states%values, &
            frame_spin(a, b, now, variation), states%rates)
      end associate
   end subroutine set_rates

   !> Angular velocity of the frame in which the vectors among the states are constant [rad/s]: it
   !> follows the normal, and turns about it by the mean of the two bodies.
   pure function frame_spin(a, b, now, variation) result(rate)
      type(pose_type), intent(in) :: a
      type(pose_type), intent(in) :: b
      !> Where it touches and how it moves.
      type(contact_motion_type), intent(in) :: now
      !> Variation of where it touches.
      type(contact_variation_type), intent(in) :: variation
      real(wp) :: rate(3)
      real(wp) :: normal_rate(3)

      associate (normal => now%at%normal)
         normal_rate = matmul(variation%normal, [now%velocity, now%spin])
         normal_rate = normal_rate + cross(a%spin, normal)
         rate = cross(normal, normal_rate) + 0.5_wp*dot_product(a%spin + b%spin, normal)*normal
      end associate
   end function frame_spin

   !> Energies stored in the states of damping and of friction.
   pure subroutine stored_energies(self, at, approach, motion, load, damping, friction)
      class(contact_type), intent(in) :: self
      !> Where it touches.
      type(contact_point_type), intent(in) :: at
      !> Approach [m], > 0.
      real(wp), intent(in) :: approach
      !> Sliding velocity along the axes of the spot [m/s], spin [rad/s].
      real(wp), intent(in) :: motion(3)
      !> Normal force [N].
      real(wp), intent(in) :: load
      !> [J].
      real(wp), intent(out) :: damping
      !> [J].
      real(wp), intent(out) :: friction
      real(wp) :: local(most_states)

      damping = 0.0_wp
      friction = 0.0_wp
      local = self%local_states(at)
      associate (law => self%law, nd => self%states%n_damping, n => self%states%n_local)
         if (nd > 0) damping = law%damping%stored_energy(law%normal%force(approach), approach, &
            local(:nd))
         if (n > nd .and. .not. allocated(self%tangential)) friction = &
            law%friction%stored_energy(law%normal%shape, law%sliding(load, approach, motion, &
            0.0_wp), local(nd + 1:n))
      end associate
   end subroutine stored_energies

   !> Set the states of the parts at touch, or after lift-off.
   subroutine renew(self, now, closed, y)
      class(contact_type), intent(inout) :: self
      type(contact_motion_type), intent(in) :: now
      !> Whether the contact is closed.
      logical, intent(in) :: closed
      !> State, in which they are set.
      real(wp), intent(inout) :: y(:)
      real(wp) :: local(most_states), speed

      if (self%states%n == 0) return
      if (allocated(self%tangential)) call self%tangential%forget()
      local = 0.0_wp
      speed = -now%gap_rate()
      associate (states => self%states, law => self%law, nd => self%states%n_damping, &
         n => self%states%n_local, first => self%states%first)
         if (closed) then
            if (nd > 0) call law%damping%at_touch(speed, local(:nd))
         else
            if (nd > 0) call law%damping%after_lift(local(:nd))
         end if
         if (allocated(self%tangential)) then
            ! The axis may be any tangent.
            local(nd + 1) = 1.0_wp
         else if (n > nd .and. closed) then
            call law%friction%at_touch(speed, local(nd + 1:n))
         else if (n > nd) then
            call law%friction%after_lift(local(nd + 1:n))
         end if
         y(first:first + states%n - 1) = 0.0_wp
         call states%scatter(local(:n), now%at%major, cross(now%at%normal, now%at%major), &
            y(first:first + states%n - 1))
      end associate
   end subroutine renew

   !> Velocity of B against A at a point, and angular velocity of B against A.
   pure subroutine relative_motion(a, b, point, velocity, spin)
      type(pose_type), intent(in) :: a
      type(pose_type), intent(in) :: b
      !> Point [m].
      real(wp), intent(in) :: point(3)
      !> Velocity [m/s].
      real(wp), intent(out) :: velocity(3)
      !> Angular velocity [rad/s].
      real(wp), intent(out) :: spin(3)

      if (b%ground) then
         velocity = 0.0_wp
         spin = 0.0_wp
      else
         velocity = b%velocity + cross(b%spin, point - b%position)
         spin = b%spin
      end if
      if (.not. a%ground) then
         velocity = velocity - a%velocity - cross(a%spin, point - a%position)
         spin = spin - a%spin
      end if
   end subroutine relative_motion

   !> Slip: the part of the velocity of B against A in the tangent plane [m/s].
   pure function slip_velocity(velocity, normal) result(slip)
      !> Velocity of B against A at the contact point [m/s].
      real(wp), intent(in) :: velocity(3)
      !> Unit normal.
      real(wp), intent(in) :: normal(3)
      real(wp) :: slip(3)

      slip = velocity - dot_product(velocity, normal)*normal
   end function slip_velocity

   !> Square of the velocity below which sliding at a contact is not resolved [m2/s2]: that of the
   !> velocities and angular velocities of the two bodies together.
   pure function resolution_of(self, a, b, point) result(square)
      class(resolution_type), intent(in) :: self
      type(pose_type), intent(in) :: a
      type(pose_type), intent(in) :: b
      !> Contact point [m].
      real(wp), intent(in) :: point(3)
      real(wp) :: square

      square = 0.0_wp
      if (self%square <= 0.0_wp) return
      square = self%square*(share(self, a, point) + share(self, b, point))
   end function resolution_of

   !> Share of a body in that.
   pure real(wp) function share(self, pose, point)
      class(resolution_type), intent(in) :: self
      type(pose_type), intent(in) :: pose
      !> Contact point [m].
      real(wp), intent(in) :: point(3)
      real(wp) :: x, y, z, v, w

      x = point(1) - pose%position(1)
      y = point(2) - pose%position(2)
      z = point(3) - pose%position(3)
      v = self%velocity
      w = self%angular_velocity
      ! The ground rests.
      if (.not. pose%ground) then
         v = max(v, pose%velocity(1)**2 + pose%velocity(2)**2 + pose%velocity(3)**2)
         w = max(w, pose%spin(1)**2 + pose%spin(2)**2 + pose%spin(3)**2)
      end if
      share = v + w*(x*x + y*y + z*z)
   end function share

   !> Poses of all bodies.
   subroutine set_poses(self, y)
      class(mechanism_type), intent(inout) :: self
      !> State, that of a body in a column.
      real(wp), intent(in) :: y(body_size, self%layout%bodies)
      integer :: i

      self%times_posed = self%times_posed + 1
      do i = 1, size(self%bodies)
         associate (pose => self%pose(i))
            pose%position = y(at_position:at_position + 2, i)
            call set_rotation(y(at_quaternion:at_quaternion + 3, i), pose%rotation)
            pose%velocity = y(at_velocity:at_velocity + 2, i)
            pose%spin = to_inertial(pose%rotation, y(at_spin:at_spin + 2, i))
         end associate
      end do
   end subroutine set_poses

   !> States of the parts of all contacts; their rates are zero until a closed contact has others.
   subroutine set_states(self, y)
      class(mechanism_type), intent(inout) :: self
      real(wp), intent(in) :: y(self%layout%n)
      integer :: i

      do i = 1, size(self%contacts)
         associate (states => self%contacts(i)%states)
            if (states%n == 0) cycle
            states%values = y(states%first:states%first + states%n - 1)
            states%rates = 0.0_wp
         end associate
      end do
   end subroutine set_states

   !> Pose of a body, and its unit quaternion.
   subroutine pose_of(self, y, body, pose, quaternion)
      class(mechanism_type), intent(in) :: self
      real(wp), intent(in) :: y(:)
      !> Index of the body, 1 to the number of bodies.
      integer, intent(in) :: body
      type(pose_type), intent(out) :: pose
      !> Unit quaternion (w, x, y, z), body to inertial.
      real(wp), intent(out) :: quaternion(4)

      quaternion = unit_quaternion(quaternion_of(y, body))
      pose%position = position_of(y, body)
      pose%rotation = rotation_matrix(quaternion)
      pose%velocity = velocity_of(y, body)
      pose%spin = matmul(pose%rotation, spin_of(y, body))
   end subroutine pose_of

   !> Where a contact is and how it moves at the poses that are set, whether open or closed.
   subroutine observe(self, index, now)
      !> The mechanism; the track of the contact is changed, and says whether the search has failed.
      class(mechanism_type), intent(inout) :: self
      integer, intent(in) :: index
      type(contact_motion_type), intent(out) :: now
      real(wp) :: gap

      associate (contact => self%contacts(index), a => self%pose(self%contacts(index)%a), &
         b => self%pose(self%contacts(index)%b))
         call contact%find_gap(a, b, gap)
         if (contact%track%away) then
            now = contact_motion_type(contact_point_type(gap, [0.0_wp, 0.0_wp, 0.0_wp], &
               [0.0_wp, 0.0_wp, 0.0_wp], [0.0_wp, 0.0_wp, 0.0_wp], 0.0_wp, 0.0_wp), &
               [0.0_wp, 0.0_wp, 0.0_wp], [0.0_wp, 0.0_wp, 0.0_wp])
            return
         end if
         call contact%locate(a, b, gap, now%at)
         call relative_motion(a, b, now%at%point, now%velocity, now%spin)
      end associate
   end subroutine observe

   !> Gaps of all contacts [m].
   subroutine gaps(self, y, gap, posed)
      !> The mechanism; its workspace is changed.
      class(mechanism_type), intent(inout) :: self
      real(wp), intent(in) :: y(self%layout%n)
      !> Gap of each contact, negative for overlap [m].
      real(wp), intent(out) :: gap(:)
      !> Whether the poses are set already; not given, they are not.
      logical, intent(in), optional :: posed
      logical :: set
      integer :: i

      set = .false.
      if (present(posed)) set = posed
      if (.not. set) call self%set_poses(y)
      do i = 1, size(self%contacts)
         associate (contact => self%contacts(i))
            call contact%find_gap(self%pose(contact%a), self%pose(contact%b), gap(i))
         end associate
      end do
   end subroutine gaps

   !> Rates of all gaps [m/s].
   subroutine gap_rates(self, y, rate)
      !> The mechanism; its workspace is changed.
      class(mechanism_type), intent(inout) :: self
      real(wp), intent(in) :: y(self%layout%n)
      !> Rate of each gap, negative for approach [m/s].
      real(wp), intent(out) :: rate(:)
      type(contact_motion_type) :: now
      integer :: i

      call self%set_poses(y)
      do i = 1, size(self%contacts)
         call self%observe(i, now)
         rate(i) = now%gap_rate()
      end do
   end subroutine gap_rates

   !> Gap of a contact and how it changes at the poses that are set.
   subroutine gap_motion(self, index, gap)
      !> The mechanism; the track of the contact is changed.
      class(mechanism_type), intent(inout) :: self
      integer, intent(in) :: index
      type(gap_type), intent(out) :: gap
      type(contact_motion_type) :: now
      real(wp) :: k, s

      call self%observe(index, now)
      gap%value = now%at%gap
      gap%rate = now%gap_rate()
      k = self%contacts(index)%law%geometry%into_hollow
      associate (a => self%contacts(index)%a, b => self%contacts(index)%b)
         if (a > 0) call add_turning(self%pose(a))
         if (b > 0) call add_turning(self%pose(b))
         if (.not. k > 0.0_wp) return
         gap%speed = gap%speed + norm2(self%pose(a)%velocity - self%pose(b)%velocity)
      end associate
      ! The smallest relative curvature where what meets the hollow is larger by the gap.
      s = max(gap%value, 0.0_wp)
      s = 2.0_wp*now%at%curvature_a - s*k/(1.0_wp + s*k)*k
      gap%sharpness = k*unbounded
      if (s > k/unbounded) gap%sharpness = k*k/s

   contains

      !> Add what the turning of a body makes. The point that touches is as far from its centre of
      !> mass all the way, within a factor of two.
      subroutine add_turning(pose)
         type(pose_type), intent(in) :: pose
         real(wp) :: arm(3), length

         arm = now%at%point - pose%position
         length = 2.0_wp*sqrt(dot_product(arm, arm))
         gap%bend = gap%bend + dot_product(pose%spin, pose%spin)*length
         if (k > 0.0_wp) gap%speed = gap%speed + norm2(pose%spin)*length
      end subroutine add_turning

   end subroutine gap_motion

   !> Bound of how fast the gap of a contact changes, wherever its surfaces are nearest, up to a
   !> time away from a state [m/s]; far too large where a surface without an end turns.
   !>
   !> A surface turns about its centre, which moves with its body. Euler's equations let the angular
   !> velocity change by its square times the time at most; forces are for the caller to mind.
   pure real(wp) function fastest(self, index, y, time)
      class(mechanism_type), intent(in) :: self
      integer, intent(in) :: index
      !> State, that of a body in a column.
      real(wp), intent(in) :: y(body_size, self%layout%bodies)
      !> The time [s], >= 0.
      real(wp), intent(in) :: time
      real(wp) :: velocity(3)

      associate (contact => self%contacts(index))
         velocity = 0.0_wp
         fastest = 0.0_wp
         if (contact%a > 0) then
            velocity = y(at_velocity:at_velocity + 2, contact%a)
            fastest = turning(y(at_spin:at_spin + 2, contact%a), 1)
         end if
         if (contact%b > 0) then
            velocity = velocity - y(at_velocity:at_velocity + 2, contact%b)
            fastest = fastest + turning(y(at_spin:at_spin + 2, contact%b), 2)
         end if
      end associate
      fastest = fastest + sqrt(dot_product(velocity, velocity))

   contains

      !> What the turning of a body makes of it [m/s].
      pure real(wp) function turning(spin, side)
         !> Its angular velocity, body frame [rad/s].
         real(wp), intent(in) :: spin(3)
         !> 1 for body A, 2 for body B.
         integer, intent(in) :: side
         real(wp) :: square, x, y, z

         associate (c => self%contacts(index)%centre(:, side))
            square = dot_product(spin, spin)
            x = spin(2)*c(3) - spin(3)*c(2)
            y = spin(3)*c(1) - spin(1)*c(3)
            z = spin(1)*c(2) - spin(2)*c(1)
            turning = min(self%contacts(index)%lever(side), unbounded)*sqrt(square) &
               + sqrt(x*x + y*y + z*z) + square*time*sqrt(dot_product(c, c))
         end associate
      end function turning

   end function fastest

end module contensou_dynamics_mechanism
