!> Jacobian of the equations of motion, sparse, from the derivatives of the contact kernels.
!>
!> Columns are stored one after the other with their rows in ascending order (compressed columns).
!> The rows of a body depend on the body itself and on the bodies that it can touch; every column
!> of a body has the same rows, so that an entry is found without a search.
!>
!> A load depends on the pose through the contact point, its normal and its curvatures (their
!> variation comes from the geometry) and on the velocities through the kernels' own derivatives.
!> That of the force of the elastic energy through the curvatures, small against the normal force by
!> the approach over the radii, comes from differences.
module contensou_dynamics_jacobian
   use contensou_base_kinds, only : wp
   use contensou_base_rotations, only : norm_rate
   use contensou_base_vectors, only : cross
   use contensou_contact_geometry, only : contact_point_type, contact_variation_type, &
      pose_type, track_type, trouble_none
   use contensou_contact_normal, only : normal_type
   use contensou_contact_rolling, only : rolling_hysteresis
   use contensou_dynamics_scene, only : motion_fixed, motion_free, motion_prescribed, &
      moves_freely, turns_by_drive
   use contensou_dynamics_system, only : body_size, contact_type, relative_motion, &
      resolution_type, system_type
   implicit none(type, external)
   private

   public :: jacobian_type

   !> Rows of a body that its contacts act on: velocity and angular velocity.
   integer, parameter :: first_row = 8, acted_rows = 6

   !> Degrees of freedom of a pair: translation, rotation, velocity and angular velocity of A, then
   !> of B; all in the inertial frame.
   integer, parameter :: freedoms = 24

   !> What a contact gives: force on B, torque about the centres of mass of A and of B, power lost
   !> in friction and in damping.
   integer, parameter :: outcomes = 11

   !> Relative step of differences.
   real(wp), parameter :: step = 1.0e-5_wp

   !> Step of the differences of the force through the curvatures, over the approach.
   real(wp), parameter :: shape_step = 1.0e-3_wp

   !> Sparse Jacobian; one instance per thread.
   type :: jacobian_type
      !> Number of rows and columns.
      integer :: n = 0
      !> Index of the first entry of each column, and one beyond the last.
      integer, allocatable :: column_start(:)
      !> Row of each entry.
      integer, allocatable :: row(:)
      !> Value of each entry.
      real(wp), allocatable :: value(:)
      !> Offset of the rows of a body within a column of the other body, for each contact: rows of
      !> A in A, of A in B, of B in A, of B in B; -1 where there are none.
      integer, allocatable, private :: offset(:, :)
      !> Offset of a body's own rows within its columns.
      integer, allocatable, private :: own(:)
      !> Torque of all contacts on each body [N m], inertial frame.
      real(wp), allocatable, private :: torque(:, :)
      !> Force of all contacts on each body [N].
      real(wp), allocatable, private :: force(:, :)
   contains
      !> Lay out the entries for a system.
      procedure :: prepare
      !> Compute the entries.
      procedure :: evaluate
   end type jacobian_type

   !> Load of a contact and its derivatives.
   type :: linear_load_type
      !> Force on B [N].
      real(wp) :: force(3)
      !> Torques about the centres of mass of A and B [N m].
      real(wp) :: torque_a(3), torque_b(3)
      !> Derivatives of the outcomes by the degrees of freedom.
      real(wp) :: slopes(outcomes, freedoms)
   end type linear_load_type

contains

   !> Lay out the entries for a system whose bodies and contacts are set.
   subroutine prepare(self, system)
      !> The Jacobian.
      class(jacobian_type), intent(inout) :: self
      !> The system.
      type(system_type), intent(in) :: system
      logical, allocatable :: coupled(:, :)
      integer :: nb, works, i, j, k, c, next, base

      nb = size(system%bodies)
      works = system%n - body_size*nb
      self%n = system%n
      ! Row body first: whose velocities depend on the state of which body.
      allocate(coupled(nb, nb), source=.false.)
      do i = 1, size(system%contacts)
         associate (a => system%contacts(i)%a, b => system%contacts(i)%b)
            if (a == 0 .or. b == 0) cycle
            coupled(a, b) = moves_freely(system%bodies(a)%motion) .and. &
               system%bodies(b)%motion /= motion_fixed
            coupled(b, a) = moves_freely(system%bodies(b)%motion) .and. &
               system%bodies(a)%motion /= motion_fixed
         end associate
      end do
      next = 0
      do j = 1, nb
         next = next + body_size*(body_size + acted_rows*count(coupled(:, j)) + works)
      end do
      next = next + works
      if (allocated(self%row)) deallocate(self%row, self%value, self%column_start, self%offset, &
         self%own, self%torque, self%force)
      allocate(self%row(next), self%value(next), self%column_start(self%n + 1))
      allocate(self%offset(4, size(system%contacts)), self%own(nb))
      allocate(self%torque(3, nb), self%force(3, nb))
      next = 0
      do j = 1, nb
         do c = 1, body_size
            base = next
            self%column_start(body_size*(j - 1) + c) = next + 1
            do i = 1, nb
               if (i == j) then
                  self%own(j) = next - base
                  self%row(next + 1:next + body_size) = [(body_size*(i - 1) + k, k=1, body_size)]
                  next = next + body_size
               else if (coupled(i, j)) then
                  self%row(next + 1:next + acted_rows) = &
                     [(body_size*(i - 1) + first_row - 1 + k, k=1, acted_rows)]
                  next = next + acted_rows
               end if
            end do
            self%row(next + 1:next + works) = [(body_size*nb + k, k=1, works)]
            next = next + works
         end do
      end do
      do k = 1, works
         ! The works act on nothing; the entry is there for the identity that a solver adds.
         self%column_start(body_size*nb + k) = next + 1
         next = next + 1
         self%row(next) = body_size*nb + k
      end do
      self%column_start(self%n + 1) = next + 1
      do i = 1, size(system%contacts)
         associate (a => system%contacts(i)%a, b => system%contacts(i)%b)
            self%offset(:, i) = [offset_of(a, a), offset_of(a, b), offset_of(b, a), offset_of(b, b)]
         end associate
      end do

   contains

      !> Offset of the acted rows of a body within the columns of a body; -1 if there are none.
      pure function offset_of(row_body, column_body) result(offset)
         !> Body of the rows.
         integer, intent(in) :: row_body
         !> Body of the columns.
         integer, intent(in) :: column_body
         integer :: offset
         integer :: m

         offset = -1
         if (row_body == 0 .or. column_body == 0) return
         if (row_body == column_body) then
            if (moves_freely(system%bodies(row_body)%motion)) then
               offset = self%own(row_body) + first_row - 1
            end if
            return
         end if
         if (.not. coupled(row_body, column_body)) return
         offset = 0
         do m = 1, row_body - 1
            if (m == column_body) then
               offset = offset + body_size
            else if (coupled(m, column_body)) then
               offset = offset + acted_rows
            end if
         end do
      end function offset_of

   end subroutine prepare

   !> Compute the entries at a state. Allocates nothing.
   subroutine evaluate(self, system, t, y)
      !> The Jacobian, prepared.
      class(jacobian_type), intent(inout) :: self
      !> The system; its workspace is changed.
      type(system_type), intent(inout) :: system
      !> Time [s].
      real(wp), intent(in) :: t
      !> State.
      real(wp), intent(in) :: y(:)
      type(linear_load_type) :: load
      logical :: closed
      integer :: i

      call system%set_poses(y)
      self%value = 0.0_wp
      self%torque = 0.0_wp
      self%force = 0.0_wp
      do i = 1, size(system%contacts)
         associate (contact => system%contacts(i))
            call linearize(contact, system%pose(contact%a), system%pose(contact%b), &
               system%resolution, load, closed)
            if (.not. closed) cycle
            call add_contact(self, system, i, load, y)
         end associate
      end do
      do i = 1, size(system%bodies)
         call add_body(self, system, i, t, y(body_size*(i - 1) + 1:body_size*i))
      end do
   end subroutine evaluate

   !> Add what a contact contributes.
   subroutine add_contact(self, system, index, load, y)
      !> The Jacobian.
      type(jacobian_type), intent(inout) :: self
      !> The system.
      type(system_type), intent(in) :: system
      !> Index of the contact.
      integer, intent(in) :: index
      !> Its load.
      type(linear_load_type), intent(in) :: load
      !> State.
      real(wp), intent(in) :: y(:)
      real(wp) :: columns(outcomes, body_size)
      integer :: side, column_body, offsets(2)

      associate (a => system%contacts(index)%a, b => system%contacts(index)%b)
         if (a > 0) then
            self%force(:, a) = self%force(:, a) - load%force
            self%torque(:, a) = self%torque(:, a) + load%torque_a
         end if
         if (b > 0) then
            self%force(:, b) = self%force(:, b) + load%force
            self%torque(:, b) = self%torque(:, b) + load%torque_b
         end if
         do side = 1, 2
            column_body = merge(a, b, side == 1)
            if (column_body == 0) cycle
            if (system%bodies(column_body)%motion == motion_fixed) cycle
            call to_state(load%slopes(:, 12*side - 11:12*side), system%pose(column_body), &
               y(body_size*(column_body - 1) + 4:body_size*(column_body - 1) + 7), columns)
            offsets = self%offset([side, 2 + side], index)
            if (offsets(1) >= 0) call add_rows(self, system, a, column_body, offsets(1), &
               -columns(1:3, :), columns(4:6, :))
            if (offsets(2) >= 0) call add_rows(self, system, b, column_body, offsets(2), &
               columns(1:3, :), columns(7:9, :))
            call add_work(self, column_body, system%friction_index, columns(10, :))
            call add_work(self, column_body, system%damping_index, columns(11, :))
            if (a > 0) call add_drive(self, system, a, column_body, -columns(1:3, :), &
               columns(4:6, :))
            if (b > 0) call add_drive(self, system, b, column_body, columns(1:3, :), &
               columns(7:9, :))
         end do
      end associate
   end subroutine add_contact

   !> From derivatives by translation, rotation, velocity and angular velocity in the inertial frame
   !> to derivatives by the state of a body.
   pure subroutine to_state(slopes, pose, q, columns)
      !> Derivatives by the twelve degrees of freedom of the body.
      real(wp), intent(in) :: slopes(:, :)
      !> Pose of the body.
      type(pose_type), intent(in) :: pose
      !> Quaternion of the body, of any norm.
      real(wp), intent(in) :: q(4)
      !> Derivatives by its state.
      real(wp), intent(out) :: columns(:, :)
      real(wp) :: turn(3, 4)
      integer :: i

      columns(:, 1:3) = slopes(:, 1:3)
      turn = rotation_of(q)
      do i = 1, 4
         ! The angular velocity is given in the body frame, and turns with it.
         columns(:, 3 + i) = matmul(slopes(:, 4:6), turn(:, i)) &
            + matmul(slopes(:, 10:12), cross(turn(:, i), pose%spin))
      end do
      columns(:, 8:10) = slopes(:, 7:9)
      columns(:, 11:13) = matmul(slopes(:, 10:12), pose%rotation)
   end subroutine to_state

   !> Rotation vector, inertial frame, per change of a quaternion: 2 vec(dq o q*)/|q|^2.
   pure function rotation_of(q) result(turn)
      !> Quaternion (w, x, y, z), of any norm.
      real(wp), intent(in) :: q(4)
      real(wp) :: turn(3, 4)

      turn(:, 1) = -q(2:4)
      turn(:, 2) = [q(1), q(4), -q(3)]
      turn(:, 3) = [-q(4), q(1), q(2)]
      turn(:, 4) = [q(3), -q(2), q(1)]
      turn = turn*(2.0_wp/dot_product(q, q))
   end function rotation_of

   !> Add to the acceleration of a body.
   pure subroutine add_rows(self, system, row_body, column_body, offset, force, torque)
      !> The Jacobian.
      type(jacobian_type), intent(inout) :: self
      !> The system.
      type(system_type), intent(in) :: system
      !> Body that is accelerated.
      integer, intent(in) :: row_body
      !> Body whose state varies.
      integer, intent(in) :: column_body
      !> Offset of the rows within the columns.
      integer, intent(in) :: offset
      !> Derivatives of the force [N].
      real(wp), intent(in) :: force(3, body_size)
      !> Derivatives of the torque about the centre of mass [N m], inertial frame.
      real(wp), intent(in) :: torque(3, body_size)
      real(wp) :: moment(3)
      integer :: c, k

      associate (body => system%bodies(row_body))
         do c = 1, body_size
            k = self%column_start(body_size*(column_body - 1) + c) + offset
            self%value(k:k + 2) = self%value(k:k + 2) + force(:, c)/body%mass
            if (turns_by_drive(body%motion)) cycle
            moment = matmul(torque(:, c), system%pose(row_body)%rotation)
            self%value(k + 3:k + 5) = self%value(k + 3:k + 5) + moment/body%inertia
         end do
      end associate
   end subroutine add_rows

   !> Add to the rate of a work.
   pure subroutine add_work(self, column_body, index, power)
      !> The Jacobian.
      type(jacobian_type), intent(inout) :: self
      !> Body whose state varies.
      integer, intent(in) :: column_body
      !> Index of the work in the state; 0 for none.
      integer, intent(in) :: index
      !> Derivatives of the power [W].
      real(wp), intent(in) :: power(body_size)
      integer :: c, k

      if (index == 0) return
      do c = 1, body_size
         ! The works are the last rows of a column.
         k = self%column_start(body_size*(column_body - 1) + c + 1) - 1 - (self%n - index)
         self%value(k) = self%value(k) + power(c)
      end do
   end subroutine add_work

   !> Add to the power that keeps a prescribed motion or rotation.
   pure subroutine add_drive(self, system, row_body, column_body, force, torque)
      !> The Jacobian.
      type(jacobian_type), intent(inout) :: self
      !> The system.
      type(system_type), intent(in) :: system
      !> Body that is acted upon.
      integer, intent(in) :: row_body
      !> Body whose state varies.
      integer, intent(in) :: column_body
      !> Derivatives of the force [N].
      real(wp), intent(in) :: force(3, body_size)
      !> Derivatives of the torque [N m].
      real(wp), intent(in) :: torque(3, body_size)

      if (.not. turns_by_drive(system%bodies(row_body)%motion)) return
      associate (pose => system%pose(row_body))
         call add_work(self, column_body, system%applied_index, -matmul(pose%spin, torque))
         if (system%bodies(row_body)%motion == motion_prescribed) then
            call add_work(self, column_body, system%applied_index, -matmul(pose%velocity, force))
         end if
      end associate
   end subroutine add_drive

   !> Add what a body contributes by itself, after its contacts.
   subroutine add_body(self, system, index, t, y)
      !> The Jacobian.
      type(jacobian_type), intent(inout) :: self
      !> The system.
      type(system_type), intent(in) :: system
      !> Index of the body.
      integer, intent(in) :: index
      !> Time [s].
      real(wp), intent(in) :: t
      !> State of the body.
      real(wp), intent(in) :: y(body_size)
      real(wp) :: block(body_size, body_size), power(body_size), turn(3, 4), torque(3), w(3)
      real(wp) :: momentum(3), force(3), e(3)
      integer :: i, k

      associate (body => system%bodies(index), pose => system%pose(index))
         if (body%motion == motion_fixed) return
         block = 0.0_wp
         power = 0.0_wp
         w = y(11:13)
         turn = rotation_of(y(4:7))
         do i = 1, 3
            block(i, 7 + i) = 1.0_wp
         end do
         call quaternion_block(y(4:7), w, block(4:7, 4:7), block(4:7, 11:13))
         if (moves_freely(body%motion)) then
            torque = self%torque(:, index)
            if (body%loaded) then
               force = body%force
               if (body%load_follows) then
                  force = matmul(pose%rotation, force)
                  do i = 1, 4
                     block(8:10, 3 + i) = cross(turn(:, i), force)/body%mass
                     power(3 + i) = dot_product(pose%velocity, cross(turn(:, i), force))
                  end do
                  ! A torque that turns with the body keeps its components and its power.
                  power(11:13) = body%torque
               else
                  torque = torque + body%torque
                  do i = 1, 4
                     power(3 + i) = dot_product(body%torque, cross(turn(:, i), pose%spin))
                  end do
                  power(11:13) = matmul(body%torque, pose%rotation)
               end if
               power(8:10) = force
            end if
         end if
         if (body%motion == motion_free) then
            do i = 1, 4
               block(11:13, 3 + i) = matmul(cross(torque, turn(:, i)), pose%rotation)/body%inertia
            end do
            momentum = body%inertia*w
            do i = 1, 3
               e = 0.0_wp
               e(i) = 1.0_wp
               block(11:13, 10 + i) = (cross(momentum, e) - cross(w, body%inertia*e))/body%inertia
            end do
         else
            if (t < body%ramp) then
               do i = 1, 4
                  block(11:13, 3 + i) = &
                     matmul(cross(body%angular_acceleration, turn(:, i)), pose%rotation)
               end do
            end if
            if (body%motion == motion_prescribed) power(8:10) = -self%force(:, index)
            do i = 1, 4
               power(3 + i) = power(3 + i) &
                  - dot_product(self%torque(:, index), cross(turn(:, i), pose%spin))
            end do
            power(11:13) = power(11:13) - matmul(self%torque(:, index), pose%rotation)
         end if
         do i = 1, body_size
            k = self%column_start(body_size*(index - 1) + i) + self%own(index)
            self%value(k:k + body_size - 1) = self%value(k:k + body_size - 1) + block(:, i)
         end do
      end associate
      call add_work(self, index, system%applied_index, power)
   end subroutine add_body

   !> Derivatives of the rate of a quaternion, see `quaternion_rate`.
   pure subroutine quaternion_block(q, w, by_q, by_w)
      !> Quaternion.
      real(wp), intent(in) :: q(4)
      !> Angular velocity, body frame [rad/s].
      real(wp), intent(in) :: w(3)
      !> By the quaternion.
      real(wp), intent(out) :: by_q(4, 4)
      !> By the angular velocity.
      real(wp), intent(out) :: by_w(4, 3)
      integer :: i

      by_q(:, 1) = [0.0_wp, w(1), w(2), w(3)]
      by_q(:, 2) = [-w(1), 0.0_wp, -w(3), w(2)]
      by_q(:, 3) = [-w(2), w(3), 0.0_wp, -w(1)]
      by_q(:, 4) = [-w(3), -w(2), w(1), 0.0_wp]
      by_q = 0.5_wp*by_q
      do i = 1, 4
         by_q(:, i) = by_q(:, i) - (2.0_wp*norm_rate*q(i))*q
         by_q(i, i) = by_q(i, i) + norm_rate*(1.0_wp - dot_product(q, q))
      end do
      by_w(:, 1) = 0.5_wp*[-q(2), q(1), q(4), -q(3)]
      by_w(:, 2) = 0.5_wp*[-q(3), -q(4), q(1), q(2)]
      by_w(:, 3) = 0.5_wp*[-q(4), q(3), -q(2), q(1)]
   end subroutine quaternion_block

   !> Load of a contact and its derivatives by the degrees of freedom of its bodies.
   subroutine linearize(contact, a, b, resolution, load, closed)
      !> The contact.
      type(contact_type), intent(inout) :: contact
      !> Pose of A.
      type(pose_type), intent(in) :: a
      !> Pose of B.
      type(pose_type), intent(in) :: b
      !> What is resolved of the velocities.
      type(resolution_type), intent(in) :: resolution
      !> The load; not set when open.
      type(linear_load_type), intent(out) :: load
      !> Whether the contact is closed.
      logical, intent(out) :: closed
      type(contact_point_type) :: at
      type(contact_variation_type) :: variation
      real(wp) :: gap, velocity(3), spin(3), minor(3), force(3), torque(3), rolling(3), shape(6)
      real(wp) :: values(4), slopes(4, 5), by_curvature(5, 2), elastic, rate, unresolved
      real(wp) :: arm_a(3), arm_b(3), e(3), by_twist(6, 6)
      integer :: k, trouble
      logical :: varies

      call contact%law%geometry%gap(a, b, contact%track, gap)
      closed = gap < 0.0_wp .and. .not. contact%track%lost
      if (.not. closed) return
      call contact%law%geometry%locate(a, b, contact%track, gap, at)
      varies = .not. contact%law%geometry%constant_curvatures
      if (varies) then
         call contact%follow(at, trouble)
         closed = trouble == trouble_none
         if (.not. closed) return
      end if
      call contact%law%geometry%vary(a, b, contact%track, at, variation)
      call relative_motion(a, b, at%point, velocity, spin)
      minor = cross(at%normal, at%major)
      rate = -dot_product(velocity, at%normal)
      unresolved = resolution%of(a, b, at%point)
      associate (law => contact%law)
         elastic = law%normal%force(-gap)
         call law%linearize(-gap, rate, dot_product(velocity, at%major), &
            dot_product(velocity, minor), dot_product(spin, at%normal), unresolved, values, slopes)
         by_curvature = 0.0_wp
         shape = 0.0_wp
         if (varies) then
            call differ_curvatures(contact, -gap, rate, dot_product(velocity, at%major), &
               dot_product(velocity, minor), dot_product(spin, at%normal), unresolved, &
               by_curvature)
            call contact%shape_force(a, b, at, shape)
            call differ_shape_force(contact, a, b, at, shape, by_twist)
         end if
         rolling = 0.0_wp
         if (allocated(law%rolling)) rolling = rolling_torque(values(1), at%normal, at%major, spin)
      end associate
      force = values(1)*at%normal + values(2)*at%major + values(3)*minor + shape(1:3)
      torque = values(4)*at%normal + rolling + shape(4:6)
      arm_a = at%point - a%position
      arm_b = at%point - b%position
      load%force = force
      load%torque_a = -torque - cross(arm_a, force)
      load%torque_b = torque + cross(arm_b, force)
      do k = 1, 3
         e = 0.0_wp
         e(k) = 1.0_wp
         call move(-e, [0.0_wp, 0.0_wp, 0.0_wp], e, [0.0_wp, 0.0_wp, 0.0_wp], e, &
            [0.0_wp, 0.0_wp, 0.0_wp], load%slopes(:, k))
         call move(-cross(e, arm_a), -e, cross(e, arm_a), e, [0.0_wp, 0.0_wp, 0.0_wp], &
            [0.0_wp, 0.0_wp, 0.0_wp], load%slopes(:, 3 + k))
         call speed_up(-e, [0.0_wp, 0.0_wp, 0.0_wp], load%slopes(:, 6 + k))
         call speed_up(-cross(e, arm_a), -e, load%slopes(:, 9 + k))
         call move(e, [0.0_wp, 0.0_wp, 0.0_wp], [0.0_wp, 0.0_wp, 0.0_wp], &
            [0.0_wp, 0.0_wp, 0.0_wp], [0.0_wp, 0.0_wp, 0.0_wp], e, load%slopes(:, 12 + k))
         call move(cross(e, arm_b), e, [0.0_wp, 0.0_wp, 0.0_wp], [0.0_wp, 0.0_wp, 0.0_wp], &
            [0.0_wp, 0.0_wp, 0.0_wp], [0.0_wp, 0.0_wp, 0.0_wp], load%slopes(:, 15 + k))
         call speed_up(e, [0.0_wp, 0.0_wp, 0.0_wp], load%slopes(:, 18 + k))
         call speed_up(cross(e, arm_b), e, load%slopes(:, 21 + k))
      end do

   contains

      !> Variation with the poses: a twist of B against A at the contact point, and a motion of both
      !> with A.
      subroutine move(shift, turn, carry, carry_turn, shift_a, shift_b, outcome)
         !> Translation of B against A at the contact point.
         real(wp), intent(in) :: shift(3)
         !> Rotation of B against A.
         real(wp), intent(in) :: turn(3)
         !> Translation of A at the contact point.
         real(wp), intent(in) :: carry(3)
         !> Rotation of A.
         real(wp), intent(in) :: carry_turn(3)
         !> Translation of the centre of mass of A.
         real(wp), intent(in) :: shift_a(3)
         !> Translation of the centre of mass of B.
         real(wp), intent(in) :: shift_b(3)
         !> Variation of the outcomes.
         real(wp), intent(out) :: outcome(outcomes)
         real(wp) :: twist(6), point(3), normal(3), major(3), d_shape(6)

         twist = [shift, turn]
         d_shape = 0.0_wp
         if (varies) then
            d_shape = matmul(by_twist, twist)
            d_shape(1:3) = d_shape(1:3) + cross(carry_turn, shape(1:3))
            d_shape(4:6) = d_shape(4:6) + cross(carry_turn, shape(4:6))
         end if
         point = matmul(variation%point, twist) + carry
         normal = matmul(variation%normal, twist)
         major = dot_product(variation%turn, twist)*minor &
            - dot_product(at%major, normal)*at%normal + cross(carry_turn, at%major)
         normal = normal + cross(carry_turn, at%normal)
         call vary_load(dot_product(at%normal, shift), &
            [dot_product(variation%curvature_a, twist), dot_product(variation%curvature_b, &
            twist)], &
            d_shape, normal, major, &
            cross(b%spin, point - shift_b) - cross(a%spin, point - shift_a), &
            [0.0_wp, 0.0_wp, 0.0_wp], point - shift_a, point - shift_b, outcome)
      end subroutine move

      !> Variation with the velocities.
      subroutine speed_up(faster, faster_spin, outcome)
         !> Velocity of B against A at the contact point.
         real(wp), intent(in) :: faster(3)
         !> Angular velocity of B against A.
         real(wp), intent(in) :: faster_spin(3)
         !> Variation of the outcomes.
         real(wp), intent(out) :: outcome(outcomes)
         real(wp), parameter :: none(3) = 0.0_wp

         call vary_load(0.0_wp, [0.0_wp, 0.0_wp], [none, none], none, none, faster, faster_spin, &
            none, none, outcome)
      end subroutine speed_up

      !> Variation of the load.
      subroutine vary_load(d_gap, d_curvatures, d_shape, d_normal, d_major, d_velocity, d_spin, &
         d_arm_a, d_arm_b, outcome)
         !> Of the gap.
         real(wp), intent(in) :: d_gap
         !> Of the curvatures A and B.
         real(wp), intent(in) :: d_curvatures(2)
         !> Of force and torque of the elastic energy through the curvatures.
         real(wp), intent(in) :: d_shape(6)
         !> Of the normal.
         real(wp), intent(in) :: d_normal(3)
         !> Of the major axis.
         real(wp), intent(in) :: d_major(3)
         !> Of the velocity of B against A at the contact point.
         real(wp), intent(in) :: d_velocity(3)
         !> Of the angular velocity of B against A.
         real(wp), intent(in) :: d_spin(3)
         !> Of the arm of A.
         real(wp), intent(in) :: d_arm_a(3)
         !> Of the arm of B.
         real(wp), intent(in) :: d_arm_b(3)
         !> Of the outcomes.
         real(wp), intent(out) :: outcome(outcomes)
         real(wp) :: d_minor(3), d_motion(5), d_values(4), d_force(3), d_torque(3), d_elastic
         real(wp) :: d_rolling(3)

         d_minor = cross(d_normal, at%major) + cross(at%normal, d_major)
         d_motion(1) = -d_gap
         d_motion(2) = -dot_product(d_velocity, at%normal) - dot_product(velocity, d_normal)
         d_motion(3) = dot_product(d_velocity, at%major) + dot_product(velocity, d_major)
         d_motion(4) = dot_product(d_velocity, minor) + dot_product(velocity, d_minor)
         d_motion(5) = dot_product(d_spin, at%normal) + dot_product(spin, d_normal)
         d_values = matmul(slopes, d_motion)
         d_elastic = 1.5_wp*elastic/at%gap*d_gap
         if (varies) then
            d_values = d_values + matmul(by_curvature(1:4, :), d_curvatures)
            d_elastic = d_elastic + dot_product(by_curvature(5, :), d_curvatures)
         end if
         d_force = d_values(1)*at%normal + values(1)*d_normal + d_values(2)*at%major &
            + values(2)*d_major + d_values(3)*minor + values(3)*d_minor
         d_torque = d_values(4)*at%normal + values(4)*d_normal
         if (varies) then
            d_force = d_force + d_shape(1:3)
            d_torque = d_torque + d_shape(4:6)
         end if
         d_rolling = 0.0_wp
         if (allocated(contact%law%rolling)) then
            d_rolling = vary_rolling(d_gap, d_values(1), d_normal, d_major, d_spin)
            d_torque = d_torque + d_rolling
         end if
         outcome(1:3) = d_force
         outcome(4:6) = -d_torque - cross(d_arm_a, force) - cross(arm_a, d_force)
         outcome(7:9) = d_torque + cross(d_arm_b, force) + cross(arm_b, d_force)
         outcome(10) = -(d_values(2)*dot_product(velocity, at%major) + values(2)*d_motion(3) &
            + d_values(3)*dot_product(velocity, minor) + values(3)*d_motion(4) &
            + d_values(4)*dot_product(spin, at%normal) + values(4)*d_motion(5)) &
            - dot_product(d_rolling, spin) - dot_product(rolling, d_spin)
         outcome(11) = (d_values(1) - d_elastic)*rate + (values(1) - elastic)*d_motion(2)
      end subroutine vary_load

      !> Torque of rolling resistance.
      pure function rolling_torque(normal_force, normal, major, relative) result(moment)
         !> Normal force [N].
         real(wp), intent(in) :: normal_force
         !> Normal.
         real(wp), intent(in) :: normal(3)
         !> Major axis.
         real(wp), intent(in) :: major(3)
         !> Angular velocity of B against A [rad/s].
         real(wp), intent(in) :: relative(3)
         real(wp) :: moment(3)

         associate (law => contact%law)
            moment = law%rolling%torque(normal_force, normal, major, &
               law%normal%axis_a*sqrt(-at%gap), law%normal%axis_b*sqrt(-at%gap), relative)
         end associate
      end function rolling_torque

      !> Variation of the torque of rolling resistance, by differences: it has no sharp scale but
      !> its regularisation.
      pure function vary_rolling(d_gap, d_load, d_normal, d_major, d_spin) result(d_moment)
         !> Of the gap.
         real(wp), intent(in) :: d_gap
         !> Of the normal force.
         real(wp), intent(in) :: d_load
         !> Of the normal.
         real(wp), intent(in) :: d_normal(3)
         !> Of the major axis.
         real(wp), intent(in) :: d_major(3)
         !> Of the angular velocity of B against A.
         real(wp), intent(in) :: d_spin(3)
         real(wp) :: d_moment(3)
         real(wp) :: h, scale

         d_moment = 0.0_wp
         if (values(1) > 0.0_wp) d_moment = rolling*(d_load/values(1))
         associate (law => contact%law)
            if (law%rolling%model == rolling_hysteresis) then
               d_moment = d_moment + rolling*(0.5_wp*d_gap/at%gap)
            end if
            scale = max(norm2(spin), law%rolling%regularization)
            h = norm2(d_normal) + norm2(d_major) + norm2(d_spin)/scale
            if (h <= 0.0_wp) return
            h = step*min(law%rolling%regularization/scale, 1.0_wp)/h
         end associate
         d_moment = d_moment + (rolling_torque(values(1), at%normal + h*d_normal, &
            at%major + h*d_major, spin + h*d_spin) - rolling_torque(values(1), at%normal &
            - h*d_normal, at%major - h*d_major, spin - h*d_spin))/(2.0_wp*h)
      end function vary_rolling

   end subroutine linearize

   !> Derivatives of the force of the elastic energy through the curvatures by a twist of B at the
   !> contact point, by differences: they need no more than two digits, as the force is smaller than
   !> the normal force by the approach over the radii.
   subroutine differ_shape_force(contact, a, b, at, force, by_twist)
      !> The contact; it is left as it was.
      type(contact_type), intent(inout) :: contact
      !> Pose of A.
      type(pose_type), intent(in) :: a
      !> Pose of B.
      type(pose_type), intent(in) :: b
      !> Where it touches.
      type(contact_point_type), intent(in) :: at
      !> Force and torque there.
      real(wp), intent(in) :: force(6)
      !> The derivatives.
      real(wp), intent(out) :: by_twist(6, 6)
      type(track_type) :: track
      type(normal_type) :: normal
      type(pose_type) :: moved
      type(contact_point_type) :: there
      real(wp) :: h, twist(6), gap, varied(6)
      integer :: i, k, trouble

      track = contact%track
      normal = contact%law%normal
      by_twist = 0.0_wp
      do i = 1, 6
         h = shape_step*abs(at%gap)
         if (i > 3) h = h*2.0_wp*at%curvature_b
         twist = 0.0_wp
         twist(i) = h
         moved = b
         moved%position = b%position + twist(1:3) + cross(twist(4:6), b%position - at%point)
         do k = 1, 3
            moved%rotation(:, k) = b%rotation(:, k) + cross(twist(4:6), b%rotation(:, k))
         end do
         call contact%law%geometry%gap(a, moved, contact%track, gap)
         call contact%law%geometry%locate(a, moved, contact%track, gap, there)
         call contact%follow(there, trouble)
         if (trouble == trouble_none) then
            call contact%shape_force(a, moved, there, varied)
            by_twist(:, i) = (varied - force)/h
         end if
         contact%track = track
         contact%law%normal = normal
      end do
   end subroutine differ_shape_force

   !> Derivatives of N, F_x, F_y, T and the elastic force by the curvatures A and B, by differences
   !> of the shape of the spot, which the wrench depends on smoothly.
   subroutine differ_curvatures(contact, approach, rate, vx, vy, w, resolution, by_curvature)
      !> The contact; its normal part is left as it was.
      type(contact_type), intent(inout) :: contact
      !> Approach [m].
      real(wp), intent(in) :: approach
      !> Its rate [m/s].
      real(wp), intent(in) :: rate
      !> Sliding velocity along the major axis [m/s].
      real(wp), intent(in) :: vx
      !> Sliding velocity along the minor axis [m/s].
      real(wp), intent(in) :: vy
      !> Spin [rad/s].
      real(wp), intent(in) :: w
      !> Square of the velocity below which sliding is not resolved [m2/s2].
      real(wp), intent(in) :: resolution
      !> The derivatives.
      real(wp), intent(out) :: by_curvature(5, 2)
      type(normal_type) :: normal
      real(wp) :: curvatures(2), varied(2), values(4), unused(4, 5), ends(2), results(5, 2)
      integer :: i, k

      normal = contact%law%normal
      curvatures = [normal%curvature_a, normal%curvature_b]
      do i = 1, 2
         do k = 1, 2
            varied = curvatures
            varied(i) = varied(i)*(1.0_wp + merge(step, -step, k == 1))
            ! A <= B: one-sided at the circle.
            if (varied(1) > varied(2)) varied = curvatures
            ends(k) = varied(i)
            call contact%law%normal%follow(varied(1), varied(2))
            call contact%law%linearize(approach, rate, vx, vy, w, resolution, values, unused)
            results(:, k) = [values, contact%law%normal%force(approach)]
         end do
         by_curvature(:, i) = 0.0_wp
         if (ends(1) > ends(2)) then
            by_curvature(:, i) = (results(:, 1) - results(:, 2))/(ends(1) - ends(2))
         end if
      end do
      contact%law%normal = normal
   end subroutine differ_curvatures

end module contensou_dynamics_jacobian
