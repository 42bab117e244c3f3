!> Rigid bodies with contacts: the equations of motion.
!>
!> State of a body, 13 numbers: centre of mass r (inertial), quaternion q (w, x, y, z; body to
!> inertial; its norm carries no meaning), velocity v (inertial), angular velocity (body frame).
!> After the bodies come, only if the scene has the effect, the work lost in friction, the work lost
!> in damping and the work supplied by applied loads and drives, so that a run closes its own energy
!> balance.
!> Newton-Euler: m v' = m g + F, I w' = T - w x (I w) about the principal axes.
!>
!> Where the curvatures of a pair change with its pose, the elastic energy U(d, A, B) of a contact
!> acts on the pose through them, too: the generalised forces -dU/dA and -dU/dB are part of the
!> load, so that the contact conserves energy. They are smaller than the normal force by the
!> approach over the radii.
!>
!> Rigid contacts come last: their normal forces follow from the accelerations that all the rest
!> gives.
module contensou_dynamics_system
   use, intrinsic :: ieee_arithmetic, only : ieee_is_nan
   use contensou_base_checkpoint, only : checkpoint_type
   use contensou_base_kinds, only : wp
   use contensou_base_rotations, only : quaternion_rate, rotation_matrix, to_body, to_inertial, &
      unit_quaternion
   use contensou_base_vectors, only : cross
   use contensou_contact_geometry, only : contact_point_type, &
      contact_variation_type, contact_trouble, pose_type, track_type, trouble_lost, &
      trouble_jammed, trouble_no_spot, trouble_none, trouble_redundant
   use contensou_contact_law, only : contact_law_type, contact_load_type
   use contensou_dynamics_rigid, only : link_type, response, set_link, set_load, solve_linear, &
      turned_by
   use contensou_dynamics_scene, only : motion_fixed, motion_free, motion_prescribed, &
      motion_spindle, moves_freely, turns_by_drive
   implicit none(type, external)
   private

   public :: system_type, body_type, contact_type, contact_report_type, body_size
   public :: relative_motion, resolution_type

   !> Numbers of state per body.
   integer, parameter :: body_size = 13

   !> Multiple of the largest approach up to which a right-hand side is evaluated.
   real(wp), parameter :: far_beyond = 4.0_wp

   !> Unknowns beyond this (in SI units) are those of a trial state that ran away.
   real(wp), parameter :: runaway = 1.0e50_wp
   !> Iterations for the normal forces of rigid contacts, which converge quadratically.
   integer, parameter :: most_iterations = 50

   !> Relative change of a normal force whose square is below rounding.
   real(wp), parameter :: converged = 3.0e-9_wp

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
      !> Angular acceleration during the ramp [rad/s2], inertial frame.
      real(wp) :: angular_acceleration(3) = 0.0_wp
   end type body_type

   !> Two bodies and the law between them.
   type :: contact_type
      !> Body A; 0 is the ground.
      integer :: a = 0
      !> Body B; 0 is the ground.
      integer :: b = 0
      type(contact_law_type) :: law
      !> Where the surfaces were closest last.
      type(track_type) :: track
      !> Whether the contact is rigid.
      logical :: rigid = .false.
      !> Whether a rigid contact is closed.
      logical :: closed = .false.
      !> Whether a rigid contact has opened and its gap is not yet distinct from zero.
      logical :: leaving = .false.
      !> Gap below which such a contact closes again [m]: just below that at which it opened.
      real(wp) :: threshold = 0.0_wp
      !> Normal force of a closed rigid contact in the last right-hand side [N].
      real(wp) :: normal_force = 0.0_wp
      !> Restitution of a rigid contact [-], unless it depends on the speed.
      real(wp) :: restitution = 1.0_wp
      !> Hunt-Crossley coefficient alpha by which restitution depends on the speed [s/m]; 0 if it
      !> does not.
      real(wp) :: restitution_slope = 0.0_wp
   contains
      !> Let the normal part follow the curvatures.
      procedure :: follow
      !> Force of the elastic energy through the curvatures.
      procedure :: shape_force
      procedure :: exchange => exchange_contact
   end type contact_type

   !> What an integrator resolves of the velocities at a contact.
   type :: resolution_type
      !> Relative resolution squared [-]; 0 if everything is resolved.
      real(wp) :: square = 0.0_wp
      !> Square of the velocity below which it is absolute [m2/s2].
      real(wp) :: velocity = 0.0_wp
      !> Square of the angular velocity below which it is absolute [rad2/s2].
      real(wp) :: angular_velocity = 0.0_wp
   contains
      !> Square of the velocity below which sliding is not resolved.
      procedure :: of => resolution_of
   end type resolution_type

   !> What an output row says of a contact.
   type :: contact_report_type
      !> Geometry.
      type(contact_point_type) :: at
      !> Load, zero when open.
      type(contact_load_type) :: load
      !> Semi-axes of the spot [m], zero when open.
      real(wp) :: semi_axes(2) = 0.0_wp
      !> Elastic energy [J].
      real(wp) :: elastic_energy = 0.0_wp
   end type contact_report_type

   !> What acts on a body.
   type :: body_load_type
      !> Force [N], inertial frame.
      real(wp) :: force(3) = 0.0_wp
      !> Torque about the centre of mass [N m], inertial frame.
      real(wp) :: torque(3) = 0.0_wp
   end type body_load_type

   !> The equations of motion, with the space they need; one instance per thread.
   type :: system_type
      !> Acceleration of gravity [m/s2].
      real(wp) :: gravity(3) = 0.0_wp
      !> Bodies, without the ground.
      type(body_type), allocatable :: bodies(:)
      type(contact_type), allocatable :: contacts(:)
      !> Length of the state.
      integer :: n = 0
      !> Index of the work of friction in the state; 0 without friction.
      integer :: friction_index = 0
      !> Index of the work of damping in the state; 0 without damping.
      integer :: damping_index = 0
      !> Index of the work of applied loads and drives in the state; 0 without them.
      integer :: applied_index = 0
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
      !> What an integrator resolves of the velocities at a contact.
      type(resolution_type) :: resolution
      !> Number of rigid contacts.
      integer :: n_rigid = 0
      !> Number of rigid contacts that were closed in the last right-hand side.
      integer :: n_links = 0
      !> These contacts.
      type(link_type), allocatable :: links(:)
      !> Equations for their normal forces.
      real(wp), allocatable, private :: matrix(:, :), right(:)
      !> Room for a right-hand side that is evaluated for the sake of the normal forces.
      real(wp), allocatable, private :: scratch(:)
      !> Whether there is gravity.
      logical, private :: has_gravity = .false.
      !> Poses of the ground (0) and the bodies.
      type(pose_type), allocatable :: pose(:)
      !> What acts on the bodies.
      type(body_load_type), allocatable, private :: load(:)
   contains
      !> Poses of all bodies at a state.
      procedure :: set_poses
      !> Make ready after bodies and contacts are set.
      procedure :: prepare
      !> Time derivative of the state.
      procedure :: derivative
      !> Gaps of all contacts.
      procedure :: gaps
      !> Normal forces of the closed rigid contacts.
      procedure :: constraint_forces
      !> What the closed rigid contacts do; bound, as inlining it would slow all scenes down.
      procedure, private :: constrain
      !> Kinematics of a rigid contact.
      procedure :: make_link
      !> Rates of all gaps.
      procedure :: gap_rates
      !> When the next ramp of a drive ends.
      procedure :: next_corner
      procedure, private :: ramps
      !> Pose of a body.
      procedure :: pose_of
      !> Report on a contact.
      procedure :: report
      !> Forces and torques of the drives.
      procedure :: drives
      !> Kinetic and potential energy.
      procedure :: energies
      !> Linear momentum, and angular momentum about the origin.
      procedure :: momenta
   end type system_type

contains

   !> Lay out the state and the workspace.
   subroutine prepare(self)
      class(system_type), intent(inout) :: self
      integer :: i, nb

      nb = size(self%bodies)
      self%has_gravity = norm2(self%gravity) > 0.0_wp
      self%n = body_size*nb
      self%friction_index = 0
      self%damping_index = 0
      self%applied_index = 0
      if (any([(allocated(self%contacts(i)%law%friction) .or. &
         allocated(self%contacts(i)%law%rolling), i=1, size(self%contacts))])) then
         self%n = self%n + 1
         self%friction_index = self%n
      end if
      self%n_rigid = count(self%contacts%rigid)
      if (any([(allocated(self%contacts(i)%law%damping), i=1, size(self%contacts))]) .or. &
         self%n_rigid > 0) then
         self%n = self%n + 1
         self%damping_index = self%n
      end if
      if (any([(self%bodies(i)%loaded .or. turns_by_drive(self%bodies(i)%motion), i=1, nb)])) then
         self%n = self%n + 1
         self%applied_index = self%n
      end if
      if (allocated(self%pose)) deallocate(self%pose, self%load)
      allocate(self%pose(0:nb), self%load(nb))
      self%pose(0)%ground = .true.
      if (allocated(self%links)) deallocate(self%links, self%matrix, self%right, self%scratch)
      allocate(self%links(self%n_rigid), self%matrix(self%n_rigid, self%n_rigid))
      allocate(self%right(self%n_rigid), self%scratch(self%n))
   end subroutine prepare

   !> Write what a contact remembers to a checkpoint or read it back.
   subroutine exchange_contact(self, checkpoint)
      class(contact_type), intent(inout) :: self
      type(checkpoint_type), intent(inout) :: checkpoint

      call self%track%exchange(checkpoint)
      call checkpoint%exchange("closed", self%closed)
      call checkpoint%exchange("leaving", self%leaving)
      call checkpoint%exchange("threshold", self%threshold)
      call checkpoint%exchange("normal_force", self%normal_force)
      if (allocated(self%law%damping)) call checkpoint%exchange("damping", &
         self%law%damping%coefficient)
   end subroutine exchange_contact

   !> Time derivative of the state. Allocates nothing.
   subroutine derivative(self, t, y, rate)
      !> The system; its workspace is changed, `too_deep`, `trouble` and `outside`.
      class(system_type), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> State.
      real(wp), intent(in) :: y(self%n)
      !> Its time derivative; not set when `outside`.
      real(wp), intent(out) :: rate(self%n)
      integer :: i, k
      real(wp) :: friction_power, damping_power

      self%too_deep = 0
      ! The stage of a step that is far too long can be anywhere, also where its squares overflow.
      ! Counted, as that is done for several at a time.
      self%outside = count(abs(y) < runaway) < self%n
      if (self%outside) return
      call self%set_poses(y)
      do i = 1, size(self%bodies)
         self%load(i) = body_load_type()
      end do
      if (self%has_gravity) then
         do i = 1, size(self%bodies)
            if (moves_freely(self%bodies(i)%motion)) then
               self%load(i)%force = self%bodies(i)%mass*self%gravity
            end if
         end do
      end if
      friction_power = 0.0_wp
      damping_power = 0.0_wp
      do i = 1, size(self%contacts)
         if (self%contacts(i)%rigid) cycle
         call add_contact(self, self%contacts(i), i, friction_power, damping_power)
         if (self%outside) return
      end do
      if (self%applied_index > 0) then
         rate(self%applied_index) = 0.0_wp
         call apply_loads(self, rate(self%applied_index))
      end if
      do i = 1, size(self%bodies)
         k = body_size*(i - 1)
         call accelerate(self, i, t, y(k + 1:k + body_size), rate(k + 1:k + body_size))
      end do
      if (self%n_rigid > 0) then
         call self%constrain(rate, friction_power)
         if (self%outside) return
      end if
      if (self%friction_index > 0) rate(self%friction_index) = friction_power
      if (self%damping_index > 0) rate(self%damping_index) = damping_power
   end subroutine derivative

   !> Add what the closed rigid contacts do to the accelerations.
   subroutine constrain(self, rate, friction_power)
      class(system_type), intent(inout) :: self
      !> Time derivative of the state, without rigid contacts on entry.
      real(wp), intent(inout) :: rate(:)
      !> Power lost in friction so far [W].
      real(wp), intent(inout) :: friction_power
      real(wp) :: moment(3)
      integer :: i, j, trouble

      self%n_links = 0
      do i = 1, size(self%contacts)
         if (.not. self%contacts(i)%closed) cycle
         self%n_links = self%n_links + 1
         call self%make_link(i, rate, self%links(self%n_links), trouble)
         if (trouble /= trouble_none) exit
         ! A step that is far too large.
         self%outside = abs(self%links(self%n_links)%at%gap) > &
            self%contacts(i)%law%largest_approach
         if (self%outside) return
      end do
      if (self%n_links == 0) return
      i = min(i, size(self%contacts))
      if (trouble == trouble_none) call find_forces(self, i, trouble)
      if (trouble /= trouble_none) then
         self%outside = .true.
         self%trouble = i
         self%trouble_code = trouble
         return
      end if
      do i = 1, self%n_links
         associate (link => self%links(i))
            self%contacts(link%contact)%normal_force = link%normal_force
            friction_power = friction_power - dot_product(link%wrench(1:3), &
               link%motion(1)*link%at%major + link%motion(2)*link%minor) &
               - dot_product(link%wrench(4:6), link%spin)
            do j = 1, 2
               if (link%body(j) == 0) cycle
               moment = cross(link%arm(:, j), link%wrench(1:3)) + link%wrench(4:6)
               if (j == 1) moment = -moment
               call push(self, link%body(j), merge(-1.0_wp, 1.0_wp, j == 1)*link%wrench(1:3), &
                  moment, rate)
            end do
         end associate
      end do
   end subroutine constrain

   !> Accelerate a body by the load of a rigid contact.
   subroutine push(self, index, force, torque, rate)
      class(system_type), intent(in) :: self
      !> Index of the body.
      integer, intent(in) :: index
      !> Force [N].
      real(wp), intent(in) :: force(3)
      !> Torque about the centre of mass [N m], inertial frame.
      real(wp), intent(in) :: torque(3)
      !> Time derivative of the state.
      real(wp), intent(inout) :: rate(:)
      real(wp) :: moment(3)
      integer :: k

      k = body_size*(index - 1)
      associate (body => self%bodies(index), pose => self%pose(index))
         if (body%motion == motion_free) then
            rate(k + 8:k + 10) = rate(k + 8:k + 10) + force/body%mass
            moment = matmul(torque, pose%rotation)
            rate(k + 11:k + 13) = rate(k + 11:k + 13) + moment/body%inertia
         else if (body%motion == motion_prescribed) then
            rate(self%applied_index) = rate(self%applied_index) &
               - dot_product(force, pose%velocity) - dot_product(torque, pose%spin)
         end if
      end associate
   end subroutine push

   !> Kinematics of a rigid contact at the poses that are set, closed or not.
   subroutine make_link(self, index, rate, link, trouble)
      !> The system; its track is changed.
      class(system_type), intent(inout) :: self
      !> Index of the contact.
      integer, intent(in) :: index
      !> Time derivative of the state without rigid contacts.
      real(wp), intent(in) :: rate(:)
      !> The contact.
      type(link_type), intent(inout) :: link
      !> One of the `trouble_*` codes.
      integer, intent(out) :: trouble
      real(wp) :: inverse_inertia(3, 2), spin_rate(3), turned(3)
      integer :: j, k

      trouble = trouble_none
      associate (contact => self%contacts(index), a => self%pose(self%contacts(index)%a), &
         b => self%pose(self%contacts(index)%b))
         link%contact = index
         link%body(1) = contact%a
         link%body(2) = contact%b
         call contact%law%geometry%gap(a, b, contact%track, link%at%gap)
         if (contact%track%lost) then
            trouble = trouble_lost
            return
         end if
         call contact%law%geometry%locate(a, b, contact%track, link%at%gap, link%at)
         if (.not. contact%law%geometry%constant_curvatures) then
            call contact%follow(link%at, trouble)
            if (trouble /= trouble_none) return
         end if
         link%inverse_mass = 0.0_wp
         inverse_inertia = 0.0_wp
         do j = 1, 2
            if (link%body(j) == 0) cycle
            associate (body => self%bodies(link%body(j)))
               if (body%motion /= motion_free) cycle
               link%inverse_mass(j) = 1.0_wp/body%mass
               inverse_inertia(:, j) = 1.0_wp/body%inertia
            end associate
         end do
         link%resolution = self%resolution%of(a, b, link%at%point)
         call set_link(link, contact%law, contact%track, a, b, inverse_inertia)
         link%free = link%bias
         do j = 1, 2
            if (link%body(j) == 0) cycle
            k = body_size*(link%body(j) - 1)
            ! Copies: gfortran takes memory for the product with a part of an assumed-shape array.
            spin_rate = rate(k + 11:k + 13)
            turned = matmul(self%pose(link%body(j))%rotation, spin_rate)
            spin_rate = rate(k + 8:k + 10) + cross(turned, link%arm(:, j))
            link%free = link%free + merge(-1.0_wp, 1.0_wp, j == 1) &
               *dot_product(link%at%normal, spin_rate)
         end do
         ! The gap returns within about a radian of the motion, which steps resolve anyway.
         link%pace = dot_product(a%spin, a%spin) + dot_product(b%spin, b%spin) &
            + (link%motion(1)**2 + link%motion(2)**2)*(2.0_wp*link%at%curvature_b)**2 &
            + abs(link%free)*2.0_wp*link%at%curvature_b
         link%stabilisation = 2.0_wp*sqrt(link%pace)*link%rate + link%pace*link%at%gap
      end associate
   end subroutine make_link

   !> Normal forces of the closed rigid contacts by Newton's method.
   subroutine find_forces(self, index, trouble)
      !> The system; its links are set.
      class(system_type), intent(inout) :: self
      !> Index of the contact that is in trouble, if one is.
      integer, intent(inout) :: index
      !> One of the `trouble_*` codes.
      integer, intent(out) :: trouble
      real(wp) :: change, largest
      integer :: i, j, k, n
      logical :: singular

      trouble = trouble_none
      n = self%n_links
      do i = 1, n
         associate (link => self%links(i))
            ! The last force is a guess.
            link%normal_force = self%contacts(link%contact)%normal_force
            if (.not. link%normal_force > 0.0_wp) then
               link%slope = 0.0_wp
               link%slope(1:3) = link%at%normal
               link%normal_force = max(-link%free/response(link, link, link%slope), 0.0_wp)
            end if
         end associate
      end do
      do k = 1, most_iterations
         do i = 1, n
            call set_load(self%links(i), self%contacts(self%links(i)%contact)%law, &
               self%links(i)%normal_force)
         end do
         do i = 1, n
            self%right(i) = -self%links(i)%free - self%links(i)%stabilisation
            do j = 1, n
               self%matrix(i, j) = response(self%links(i), self%links(j), self%links(j)%slope)
               self%right(i) = self%right(i) &
                  - response(self%links(i), self%links(j), self%links(j)%wrench)
            end do
            if (.not. self%matrix(i, i) > 0.0_wp) then
               ! A larger normal force would press the bodies together.
               index = self%links(i)%contact
               trouble = trouble_jammed
               return
            end if
         end do
         call solve_linear(n, self%matrix, self%right, singular)
         if (singular) then
            index = self%links(n)%contact
            trouble = trouble_redundant
            return
         end if
         change = 0.0_wp
         largest = 0.0_wp
         do i = 1, n
            associate (link => self%links(i))
               link%normal_force = link%normal_force + self%right(i)
               link%wrench = link%wrench + self%right(i)*link%slope
               change = max(change, abs(self%right(i)))
               largest = max(largest, abs(link%normal_force))
            end associate
         end do
         if (change <= converged*largest .or. largest <= 0.0_wp) return
      end do
      index = self%links(n)%contact
      trouble = trouble_jammed
   end subroutine find_forces

   !> Normal forces of the closed rigid contacts at a state, in their components `normal_force`.
   subroutine constraint_forces(self, t, y)
      !> The system; as after a right-hand side, which is only evaluated if one is closed.
      class(system_type), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> State.
      real(wp), intent(in) :: y(:)

      self%n_links = 0
      self%outside = .false.
      if (any(self%contacts%closed)) call self%derivative(t, y, self%scratch)
   end subroutine constraint_forces

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
         end associate
      end do
   end subroutine apply_loads

   !> Time derivative of the state of a body.
   subroutine accelerate(self, index, t, y, rate)
      type(system_type), intent(in) :: self
      !> Index of the body.
      integer, intent(in) :: index
      !> Time [s].
      real(wp), intent(in) :: t
      !> State of the body.
      real(wp), intent(in) :: y(body_size)
      !> Its time derivative.
      real(wp), intent(out) :: rate(body_size)
      real(wp) :: w(3), moment(3)

      associate (body => self%bodies(index))
         if (body%motion == motion_fixed) then
            rate = 0.0_wp
            return
         end if
         w = y(11:13)
         rate(1:3) = y(8:10)
         rate(4:7) = quaternion_rate(y(4:7), w)
         if (moves_freely(body%motion)) then
            rate(8:10) = self%load(index)%force/body%mass
         else if (self%ramps(body, t)) then
            rate(8:10) = body%acceleration
         else
            rate(8:10) = 0.0_wp
         end if
         if (body%motion == motion_free) then
            ! In two statements: gfortran takes memory for the sum of a product and a function.
            moment = to_body(self%pose(index)%rotation, self%load(index)%torque)
            rate(11:13) = (moment - cross(w, body%inertia*w))/body%inertia
         else if (self%ramps(body, t)) then
            rate(11:13) = matmul(body%angular_acceleration, self%pose(index)%rotation)
         else
            rate(11:13) = 0.0_wp
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
      type(contact_point_type) :: at
      type(contact_load_type) :: load
      real(wp) :: gap, force(3), torque(3), velocity(3), spin(3), shape_force(6)
      integer :: trouble

      associate (a => self%pose(contact%a), b => self%pose(contact%b))
         call contact%law%geometry%gap(a, b, contact%track, gap)
         if (contact%track%lost) then
            self%outside = .true.
            self%trouble = index
            self%trouble_code = trouble_lost
            return
         end if
         if (gap >= 0.0_wp) return
         if (-gap > contact%law%largest_approach) then
            self%too_deep = index
            self%outside = -gap > far_beyond*contact%law%largest_approach
            if (self%outside) return
         end if
         call contact%law%geometry%locate(a, b, contact%track, gap, at)
         if (.not. contact%law%geometry%constant_curvatures) then
            call contact%follow(at, trouble)
            if (trouble /= trouble_none) then
               self%outside = .true.
               self%trouble = index
               self%trouble_code = trouble
               return
            end if
         end if
         call relative_motion(a, b, at%point, velocity, spin)
         call contact%law%evaluate(at, velocity, spin, self%resolution%of(a, b, at%point), load)
         force = load%normal_force*at%normal
         torque = 0.0_wp
         if (allocated(contact%law%friction)) then
            force = force + load%friction_force
            torque = load%friction_torque*at%normal
            friction_power = friction_power + load%friction_power
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
   end subroutine add_contact

   !> Square of the velocity below which sliding at a contact is not resolved [m2/s2]: that of the
   !> velocities and angular velocities of the two bodies together.
   pure function resolution_of(self, a, b, point) result(square)
      !> What is resolved.
      class(resolution_type), intent(in) :: self
      type(pose_type), intent(in) :: a
      type(pose_type), intent(in) :: b
      !> Contact point [m].
      real(wp), intent(in) :: point(3)
      real(wp) :: square

      square = 0.0_wp
      if (self%square <= 0.0_wp) return
      square = self%square*(share(a) + share(b))

   contains

      !> Share of a body.
      pure function share(pose) result(s)
         type(pose_type), intent(in) :: pose
         real(wp) :: s
         real(wp) :: arm(3)

         arm = point - pose%position
         s = max(self%velocity, dot_product(pose%velocity, pose%velocity)) &
            + max(self%angular_velocity, dot_product(pose%spin, pose%spin))*dot_product(arm, arm)
      end function share

   end function resolution_of

   !> Let the normal part follow the curvatures; trouble where there is no spot.
   subroutine follow(self, at, trouble)
      class(contact_type), intent(inout) :: self
      !> Where it touches.
      type(contact_point_type), intent(in) :: at
      !> One of the `trouble_*` codes.
      integer, intent(out) :: trouble

      trouble = contact_trouble(self%track, at)
      if (trouble /= trouble_none) return
      call self%law%normal%follow(at%curvature_a, at%curvature_b)
      if (ieee_is_nan(self%law%normal%axis_a)) trouble = trouble_no_spot
   end subroutine follow

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

   !> Poses of all bodies.
   subroutine set_poses(self, y)
      class(system_type), intent(inout) :: self
      !> State.
      real(wp), intent(in) :: y(self%n)
      integer :: i, k

      do i = 1, size(self%bodies)
         k = body_size*(i - 1)
         self%pose(i)%position = y(k + 1:k + 3)
         self%pose(i)%rotation = rotation_matrix(y(k + 4:k + 7))
         self%pose(i)%velocity = y(k + 8:k + 10)
         self%pose(i)%spin = to_inertial(self%pose(i)%rotation, y(k + 11:k + 13))
      end do
   end subroutine set_poses

   !> Gaps of all contacts [m].
   subroutine gaps(self, y, gap)
      !> The system; its workspace is changed.
      class(system_type), intent(inout) :: self
      !> State.
      real(wp), intent(in) :: y(self%n)
      !> Gap of each contact, negative for overlap [m].
      real(wp), intent(out) :: gap(:)
      integer :: i

      call self%set_poses(y)
      do i = 1, size(self%contacts)
         associate (c => self%contacts(i))
            call c%law%geometry%gap(self%pose(c%a), self%pose(c%b), c%track, gap(i))
         end associate
      end do
   end subroutine gaps

   !> Rates of all gaps [m/s].
   subroutine gap_rates(self, y, rate)
      !> The system; its workspace is changed.
      class(system_type), intent(inout) :: self
      !> State.
      real(wp), intent(in) :: y(self%n)
      !> Rate of each gap, negative for approach [m/s].
      real(wp), intent(out) :: rate(:)
      type(contact_point_type) :: at
      real(wp) :: velocity(3), spin(3), gap
      integer :: i

      call self%set_poses(y)
      do i = 1, size(self%contacts)
         associate (a => self%pose(self%contacts(i)%a), b => self%pose(self%contacts(i)%b), &
            contact => self%contacts(i))
            call contact%law%geometry%gap(a, b, contact%track, gap)
            call contact%law%geometry%locate(a, b, contact%track, gap, at)
            call relative_motion(a, b, at%point, velocity, spin)
            rate(i) = dot_product(velocity, at%normal)
         end associate
      end do
   end subroutine gap_rates

   !> Pose of a body, and its unit quaternion.
   subroutine pose_of(self, y, body, pose, quaternion)
      class(system_type), intent(in) :: self
      !> State.
      real(wp), intent(in) :: y(:)
      !> Index of the body, 1 to the number of bodies.
      integer, intent(in) :: body
      type(pose_type), intent(out) :: pose
      !> Unit quaternion (w, x, y, z), body to inertial.
      real(wp), intent(out) :: quaternion(4)
      integer :: k

      k = body_size*(body - 1)
      quaternion = unit_quaternion(y(k + 4:k + 7))
      pose%position = y(k + 1:k + 3)
      pose%rotation = rotation_matrix(quaternion)
      pose%velocity = y(k + 8:k + 10)
      pose%spin = matmul(pose%rotation, y(k + 11:k + 13))
   end subroutine pose_of

   !> All that an output row says of a contact.
   subroutine report(self, y, index, row, t)
      !> The system; its workspace is changed.
      class(system_type), intent(inout) :: self
      !> State.
      real(wp), intent(in) :: y(:)
      !> Index of the contact.
      integer, intent(in) :: index
      type(contact_report_type), intent(out) :: row
      !> Time [s], for rigid contacts against a body whose motion is prescribed; 0 if not given.
      real(wp), intent(in), optional :: t
      real(wp) :: velocity(3), spin(3), gap, now
      integer :: trouble

      call self%set_poses(y)
      associate (c => self%contacts(index))
         associate (a => self%pose(c%a), b => self%pose(c%b), law => c%law)
            call law%geometry%gap(a, b, c%track, gap)
            call law%geometry%locate(a, b, c%track, gap, row%at)
            if (c%rigid) then
               now = 0.0_wp
               if (present(t)) now = t
               if (c%closed .and. .not. c%track%lost) call report_rigid(self, now, y, index, row)
               return
            end if
            if (gap >= 0.0_wp .or. c%track%lost) return
            if (.not. law%geometry%constant_curvatures) then
               call c%follow(row%at, trouble)
               if (trouble /= trouble_none) return
            end if
            call relative_motion(a, b, row%at%point, velocity, spin)
            call law%evaluate(row%at, velocity, spin, self%resolution%of(a, b, row%at%point), &
               row%load)
            row%load%slip = velocity - dot_product(velocity, row%at%normal)*row%at%normal
            row%load%spin = dot_product(spin, row%at%normal)
            row%semi_axes(1) = law%normal%major_axis(-gap)
            row%semi_axes(2) = law%normal%shape%k*row%semi_axes(1)
            row%elastic_energy = law%normal%energy(-gap)
         end associate
      end associate
   end subroutine report

   !> What the drives supply against the contacts: the force on a body whose motion is prescribed,
   !> the torque about the centre of mass of any body whose rotation is prescribed; zero for others.
   !> The inertia of the driven bodies is not counted.
   subroutine drives(self, t, y, force, torque)
      !> The system; its workspace is changed.
      class(system_type), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> State.
      real(wp), intent(in) :: y(:)
      !> Force on each body [N], inertial frame.
      real(wp), intent(out) :: force(:, :)
      !> Torque on each body [N m], inertial frame.
      real(wp), intent(out) :: torque(:, :)
      real(wp) :: friction_power, damping_power, moment(3), sense
      integer :: i, j

      call self%constraint_forces(t, y)
      call self%set_poses(y)
      do i = 1, size(self%bodies)
         self%load(i) = body_load_type()
      end do
      friction_power = 0.0_wp
      damping_power = 0.0_wp
      self%outside = .false.
      do i = 1, size(self%contacts)
         if (self%contacts(i)%rigid) cycle
         call add_contact(self, self%contacts(i), i, friction_power, damping_power)
         if (self%outside) exit
      end do
      do i = 1, self%n_links
         associate (link => self%links(i))
            do j = 1, 2
               if (link%body(j) == 0) cycle
               sense = merge(-1.0_wp, 1.0_wp, j == 1)
               moment = cross(link%arm(:, j), link%wrench(1:3)) + link%wrench(4:6)
               associate (load => self%load(link%body(j)))
                  load%force = load%force + sense*link%wrench(1:3)
                  load%torque = load%torque + sense*moment
               end associate
            end do
         end associate
      end do
      force = 0.0_wp
      torque = 0.0_wp
      do i = 1, size(self%bodies)
         if (self%bodies(i)%motion == motion_prescribed) force(:, i) = -self%load(i)%force
         if (turns_by_drive(self%bodies(i)%motion)) torque(:, i) = -self%load(i)%torque
      end do
   end subroutine drives
   !> Report on a closed rigid contact.
   subroutine report_rigid(self, t, y, index, row)
      !> The system; its workspace is changed.
      class(system_type), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> State.
      real(wp), intent(in) :: y(:)
      !> Index of the contact.
      integer, intent(in) :: index
      type(contact_report_type), intent(inout) :: row
      real(wp) :: slip(3), torque(3)
      integer :: i

      call self%constraint_forces(t, y)
      if (self%outside) return
      do i = 1, self%n_links
         if (self%links(i)%contact /= index) cycle
         associate (link => self%links(i), law => self%contacts(index)%law)
            slip = link%motion(1)*link%at%major + link%motion(2)*link%minor
            ! A row at lift-off may be late by the resolution of time.
            row%load%normal_force = max(link%normal_force, 0.0_wp)
            row%load%friction_force = link%wrench(1:3) - link%normal_force*link%at%normal
            row%load%friction_torque = dot_product(link%wrench(4:6), link%at%normal)
            torque = link%wrench(4:6) - row%load%friction_torque*link%at%normal
            row%load%rolling_torque = torque
            row%load%slip = slip
            row%load%spin = link%motion(3)
            row%load%friction_power = -dot_product(link%wrench(1:3), slip) &
               - dot_product(link%wrench(4:6), link%spin)
            row%semi_axes(1) = law%normal%major_axis( &
               law%normal%approach(row%load%normal_force))
            row%semi_axes(2) = law%normal%shape%k*row%semi_axes(1)
         end associate
      end do
   end subroutine report_rigid

   !> Kinetic energy, and potential energy of gravity relative to the origin, of the free bodies
   !> and of the translation of those that only turn by a drive [J].
   pure subroutine energies(self, y, kinetic, potential)
      class(system_type), intent(in) :: self
      !> State.
      real(wp), intent(in) :: y(:)
      !> Kinetic energy [J].
      real(wp), intent(out) :: kinetic
      !> Potential energy [J].
      real(wp), intent(out) :: potential
      integer :: i, k

      kinetic = 0.0_wp
      potential = 0.0_wp
      do i = 1, size(self%bodies)
         k = body_size*(i - 1)
         if (.not. moves_freely(self%bodies(i)%motion)) cycle
         associate (body => self%bodies(i), v => y(k + 8:k + 10), w => y(k + 11:k + 13))
            kinetic = kinetic + 0.5_wp*body%mass*dot_product(v, v)
            if (body%motion == motion_free) kinetic = kinetic &
               + 0.5_wp*dot_product(body%inertia*w, w)
            potential = potential - body%mass*dot_product(self%gravity, y(k + 1:k + 3))
         end associate
      end do
   end subroutine energies

   !> Linear momentum [kg m/s] and angular momentum about the origin [kg m2/s].
   pure subroutine momenta(self, y, linear, angular)
      class(system_type), intent(in) :: self
      !> State.
      real(wp), intent(in) :: y(:)
      !> Linear momentum [kg m/s].
      real(wp), intent(out) :: linear(3)
      !> Angular momentum about the origin [kg m2/s].
      real(wp), intent(out) :: angular(3)
      integer :: i, k

      linear = 0.0_wp
      angular = 0.0_wp
      do i = 1, size(self%bodies)
         k = body_size*(i - 1)
         associate (body => self%bodies(i))
            linear = linear + body%mass*y(k + 8:k + 10)
            angular = angular + body%mass*cross(y(k + 1:k + 3), y(k + 8:k + 10)) &
               + matmul(rotation_matrix(y(k + 4:k + 7)), body%inertia*y(k + 11:k + 13))
         end associate
      end do
   end subroutine momenta

end module contensou_dynamics_system
