!> Jacobian of the equations of motion, sparse, from the derivatives of the contact kernels.
!>
!> Columns are stored one after the other with their rows in ascending order (compressed columns).
!> The rows of a body depend on the body itself and on the bodies that it can touch; every column
!> of a body has the same rows, so that an entry is found without a search.
!>
!> States of the parts of a contact are rows in the columns of its bodies, and columns with rows in
!> the accelerations of its bodies. There is no such Jacobian of a scene with rigid contacts and
!> states, see `is_available`.
!>
!> Rigid contacts: with z the accelerations at given normal forces N and g the second derivatives of
!> the gaps, dN = -(g_z z_N)^-1 (g_y + g_z z_y) dy, since g(y, z(y, N)) stays zero.
module contensou_dynamics_jacobian
   use contensou_base_kinds, only : wp
   use contensou_base_rotations, only : norm_rate
   use contensou_base_vectors, only : cross
   use contensou_contact_geometry, only : pose_type
   use contensou_contact_states, only : contact_states_type, most_numbers
   use contensou_dynamics_linear_load, only : freedoms, linear_load_type, linearize, &
      linearize_link, outcomes
   use contensou_dynamics_equations, only : system_type
   use contensou_dynamics_scene, only : motion_fixed, motion_free, motion_prescribed, &
      motion_rotor, moves_freely, turns_by_drive
   use contensou_dynamics_springs, only : spring_load_type
   use contensou_dynamics_state, only : body_size, quaternion_of, spin_of, velocity_of
   implicit none(type, external)
   private

   public :: jacobian_type, is_available

   !> Rows of a body that its contacts act on: velocity and angular velocity.
   integer, parameter :: first_row = 8, acted_rows = 6

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
      !> Index of the first of the bodies whose rows are in the columns of a body, and one beyond
      !> the last.
      integer, allocatable, private :: first_body(:)
      !> These bodies, in ascending order.
      integer, allocatable, private :: row_body(:)
      !> Offset of the first row of each within the columns.
      integer, allocatable, private :: offset(:)
      !> For each contact whose parts own states: offset of the first row of these within the
      !> columns of its body A, those of its body B and those of the states themselves.
      integer, allocatable, private :: state_offset(:, :)
      !> Torque of all contacts on each body [N m], inertial frame.
      real(wp), allocatable, private :: torque(:, :)
      !> Force of all contacts on each body [N].
      real(wp), allocatable, private :: force(:, :)
      !> With rigid contacts: time derivative of the state.
      real(wp), allocatable, private :: rate(:)
      !> Derivatives of the second derivative of the gap of each by the state.
      real(wp), allocatable, private :: gap_slopes(:, :)
      !> Derivatives of the normal forces of the rigid contacts by the second derivatives of the
      !> gaps.
      real(wp), allocatable, private :: inverse(:, :)
   contains
      procedure :: prepare
      procedure :: evaluate
   end type jacobian_type

contains

   !> Lay out the entries for a system whose bodies and contacts are set; the effort is linear in
   !> their numbers and in that of the entries.
   subroutine prepare(self, system)
      class(jacobian_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      integer :: nb, works, j, k, c, m, next, base, entries
      integer, allocatable :: owners(:), of_body(:)

      nb = system%layout%bodies
      works = system%layout%works()
      self%n = system%layout%n
      if (allocated(self%row)) deallocate(self%row, self%value, self%column_start, &
         self%first_body, self%row_body, self%offset, self%state_offset, self%torque, self%force, &
         self%rate)
      call couple_bodies(system, self%first_body, self%row_body)
      call find_owners(self, system, of_body, owners)
      entries = body_size*(nb*(body_size - acted_rows + works) + acted_rows*size(self%row_body)) &
         + works
      do k = 1, size(owners)
         entries = entries + body_size*system%contacts(owners(k))%states%n
      end do
      do k = 1, size(self%state_offset, 2)
         associate (contact => system%contacts(k), n => system%contacts(k)%states%n)
            entries = entries + n*(n + works + acted_rows*count([is_acted_on(system, contact%a), &
               is_acted_on(system, contact%b)]))
         end associate
      end do
      allocate(self%row(entries), self%value(entries), self%column_start(self%n + 1))
      allocate(self%offset(size(self%row_body)), self%torque(3, nb), self%force(3, nb))
      allocate(self%rate(merge(self%n, 0, system%constraints%n_rigid > 0)))
      call reserve(self, 0)
      next = 0
      do j = 1, nb
         do c = 1, body_size
            base = next
            self%column_start(body_size*(j - 1) + c) = next + 1
            do m = self%first_body(j), self%first_body(j + 1) - 1
               associate (i => self%row_body(m))
                  self%offset(m) = next - base
                  if (i == j) then
                     self%row(next + 1:next + body_size) = [(body_size*(i - 1) + k, k=1, body_size)]
                     next = next + body_size
                  else
                     self%row(next + 1:next + acted_rows) = &
                        [(body_size*(i - 1) + first_row - 1 + k, k=1, acted_rows)]
                     next = next + acted_rows
                  end if
               end associate
            end do
            do k = of_body(j), of_body(j + 1) - 1
               associate (contact => system%contacts(owners(k)))
                  if (contact%a == j) self%state_offset(1, owners(k)) = next - base
                  if (contact%b == j) self%state_offset(2, owners(k)) = next - base
                  call add_state_rows(contact%states)
               end associate
            end do
            call add_works()
         end do
      end do
      do k = 1, size(self%state_offset, 2)
         associate (contact => system%contacts(k))
            do c = 1, contact%states%n
               self%column_start(contact%states%first + c - 1) = next + 1
               base = next
               call add_acted_rows(min(contact%a, contact%b))
               call add_acted_rows(max(contact%a, contact%b))
               self%state_offset(3, k) = next - base
               call add_state_rows(contact%states)
               call add_works()
            end do
         end associate
      end do
      do k = 1, works
         ! The works act on nothing; the entry is there for the identity that a solver adds.
         self%column_start(self%n - works + k) = next + 1
         next = next + 1
         self%row(next) = self%n - works + k
      end do
      self%column_start(self%n + 1) = next + 1

   contains

      !> Add the rows of the works to a column.
      subroutine add_works()
         integer :: i

         self%row(next + 1:next + works) = [(self%n - works + i, i=1, works)]
         next = next + works
      end subroutine add_works

      !> Add the rows of the states of a contact to a column.
      subroutine add_state_rows(states)
         type(contact_states_type), intent(in) :: states
         integer :: i

         self%row(next + 1:next + states%n) = [(states%first + i, i=0, states%n - 1)]
         next = next + states%n
      end subroutine add_state_rows

      !> Add the rows of a body that a contact acts on.
      subroutine add_acted_rows(body)
         integer, intent(in) :: body
         integer :: i

         if (.not. is_acted_on(system, body)) return
         self%row(next + 1:next + acted_rows) = &
            [(body_size*(body - 1) + first_row - 1 + i, i=1, acted_rows)]
         next = next + acted_rows
      end subroutine add_acted_rows

   end subroutine prepare

   !> Whether there is a Jacobian for a system: states of parts and normal forces of rigid contacts
   !> that depend on each other are left to differences.
   pure logical function is_available(system)
      type(system_type), intent(in) :: system

      is_available = system%layout%states == 0 .or. system%constraints%n_rigid == 0
   end function is_available

   !> Whether contacts accelerate a body.
   pure logical function is_acted_on(system, body)
      type(system_type), intent(in) :: system
      !> Its index; 0 for the ground.
      integer, intent(in) :: body

      is_acted_on = .false.
      if (body > 0) is_acted_on = moves_freely(system%bodies(body)%motion)
   end function is_acted_on

   !> Contacts with states, body by body in ascending order.
   subroutine find_owners(self, system, of_body, owners)
      type(jacobian_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      !> Index of the first contact of each body, and one beyond the last.
      integer, allocatable, intent(out) :: of_body(:)
      integer, allocatable, intent(out) :: owners(:)
      integer :: place(system%layout%bodies), i

      allocate(self%state_offset(3, merge(size(system%contacts), 0, system%layout%states > 0)))
      allocate(of_body(system%layout%bodies + 1), source=0)
      do i = 1, size(self%state_offset, 2)
         associate (contact => system%contacts(i))
            if (contact%states%n == 0) cycle
            if (contact%a > 0) of_body(contact%a) = of_body(contact%a) + 1
            if (contact%b > 0) of_body(contact%b) = of_body(contact%b) + 1
         end associate
      end do
      allocate(owners(sum(of_body)))
      of_body(size(of_body)) = size(owners) + 1
      do i = size(of_body) - 1, 1, -1
         of_body(i) = of_body(i + 1) - of_body(i)
      end do
      place = of_body(:size(place))
      do i = 1, size(self%state_offset, 2)
         associate (contact => system%contacts(i))
            if (contact%states%n == 0) cycle
            if (contact%a > 0) call add(contact%a)
            if (contact%b > 0) call add(contact%b)
         end associate
      end do

   contains

      !> Add the contact to a body.
      subroutine add(body)
         integer, intent(in) :: body

         owners(place(body)) = i
         place(body) = place(body) + 1
      end subroutine add

   end subroutine find_owners

   !> Make room for a number of closed rigid contacts.
   subroutine reserve(self, n)
      type(jacobian_type), intent(inout) :: self
      integer, intent(in) :: n

      if (allocated(self%gap_slopes)) deallocate(self%gap_slopes, self%inverse)
      allocate(self%gap_slopes(self%n, n), self%inverse(n, n))
   end subroutine reserve

   !> Where the accelerations of a body stand in the columns of another one: offset of the first of
   !> them, -1 if they do not depend on its state.
   pure function place_of(self, row_body, column_body) result(place)
      type(jacobian_type), intent(in) :: self
      !> Body that is acted upon.
      integer, intent(in) :: row_body
      !> Body whose state varies.
      integer, intent(in) :: column_body
      integer :: place
      integer :: low, high, middle

      low = self%first_body(column_body)
      high = self%first_body(column_body + 1)
      do while (high - low > 1)
         middle = (low + high)/2
         if (self%row_body(middle) > row_body) then
            high = middle
         else
            low = middle
         end if
      end do
      place = -1
      if (self%row_body(low) /= row_body) return
      place = self%offset(low)
      if (row_body == column_body) place = place + first_row - 1
   end function place_of

   !> Which bodies have accelerations that depend on the state of which body: on its own and on
   !> those of the bodies that touch it, and what rigid contacts couple beyond that.
   subroutine couple_bodies(system, first, row_body)
      type(system_type), intent(in) :: system
      !> Index of the first body of each column, and one beyond the last.
      integer, allocatable, intent(out) :: first(:)
      !> The bodies of the columns, in ascending order within each.
      integer, allocatable, intent(out) :: row_body(:)
      integer, allocatable :: pairs(:, :), by_row(:, :)
      integer :: n, i

      allocate(pairs(2, size(system%bodies) + 2*(size(system%contacts) + size(system%springs))))
      n = 0
      do i = 1, size(system%bodies)
         call add_pair(i, i)
      end do
      do i = 1, size(system%contacts)
         call add_joined(system%contacts(i)%a, system%contacts(i)%b)
      end do
      do i = 1, size(system%springs)
         call add_joined(system%springs(i)%a, system%springs(i)%b)
      end do
      if (system%constraints%n_rigid > 0) call couple_joined(system, pairs, n)
      call sort_pairs(pairs(:, :n), 1, size(system%bodies), by_row)
      call sort_pairs(by_row, 2, size(system%bodies), pairs)
      allocate(first(size(system%bodies) + 1), source=0)
      allocate(row_body(size(pairs, 2)))
      n = 0
      do i = 1, size(pairs, 2)
         if (i > 1) then
            if (all(pairs(:, i) == pairs(:, i - 1))) cycle
         end if
         n = n + 1
         row_body(n) = pairs(1, i)
         if (first(pairs(2, i)) == 0) first(pairs(2, i)) = n
      end do
      row_body = row_body(:n)
      first(size(first)) = n + 1

   contains

      !> Add the pairs of two bodies that a contact or a spring joins.
      subroutine add_joined(a, b)
         !> The bodies; 0 is the ground.
         integer, intent(in) :: a
         integer, intent(in) :: b

         if (a == 0 .or. b == 0 .or. a == b) return
         if (moves_freely(system%bodies(a)%motion) .and. &
            system%bodies(b)%motion /= motion_fixed) call add_pair(a, b)
         if (moves_freely(system%bodies(b)%motion) .and. &
            system%bodies(a)%motion /= motion_fixed) call add_pair(b, a)
      end subroutine add_joined

      !> Add a pair: the row body, the column body.
      subroutine add_pair(row, column)
         integer, intent(in) :: row
         integer, intent(in) :: column

         n = n + 1
         pairs(:, n) = [row, column]
      end subroutine add_pair

   end subroutine couple_bodies

   !> Sort pairs of bodies by one of the two, those that are equal in the order in which they were.
   subroutine sort_pairs(pairs, by, bodies, sorted)
      integer, intent(in) :: pairs(:, :)
      !> Which of the two, 1 or 2.
      integer, intent(in) :: by
      integer, intent(in) :: bodies
      integer, allocatable, intent(out) :: sorted(:, :)
      integer :: next(bodies + 1), i

      next = 0
      do i = 1, size(pairs, 2)
         next(pairs(by, i) + 1) = next(pairs(by, i) + 1) + 1
      end do
      do i = 2, bodies
         next(i) = next(i) + next(i - 1)
      end do
      allocate(sorted(2, size(pairs, 2)))
      do i = 1, size(pairs, 2)
         associate (body => pairs(by, i))
            next(body) = next(body) + 1
            sorted(:, next(body)) = pairs(:, i)
         end associate
      end do
   end subroutine sort_pairs

   !> Couple what rigid contacts couple: the normal force on a body depends on all that accelerates
   !> it, and so do those on the bodies that such contacts join to it.
   subroutine couple_joined(system, pairs, n)
      type(system_type), intent(in) :: system
      !> Which body (first) has accelerations that depend on the state of which body (second).
      integer, allocatable, intent(inout) :: pairs(:, :)
      integer, intent(inout) :: n
      integer :: parent(system%layout%bodies), members(system%layout%bodies)
      integer :: reached(system%layout%bodies), seen(system%layout%bodies)
      integer, allocatable :: of_cluster(:, :), sorted(:, :), larger(:, :)
      integer :: i, j, k, m, next, clustered

      parent = [(i, i=1, size(parent))]
      do i = 1, size(system%contacts)
         associate (contact => system%contacts(i))
            if (.not. contact%rigid .or. contact%a == 0 .or. contact%b == 0) cycle
            if (.not. moves_freely(system%bodies(contact%a)%motion)) cycle
            if (.not. moves_freely(system%bodies(contact%b)%motion)) cycle
            parent(root_of(contact%b)) = root_of(contact%a)
         end associate
      end do
      ! What is coupled to the bodies of a cluster, by clusters.
      clustered = n
      allocate(of_cluster(2, n))
      do i = 1, n
         of_cluster(:, i) = [root_of(pairs(1, i)), pairs(2, i)]
      end do
      call sort_pairs(of_cluster, 1, size(parent), sorted)
      seen = 0
      next = 1
      do i = 1, size(parent)
         if (root_of(i) /= i) cycle
         do while (next <= clustered)
            if (sorted(1, next) >= i) exit
            next = next + 1
         end do
         ! The bodies of the cluster are among these: each is coupled to itself.
         k = 0
         m = 0
         do while (next <= clustered)
            if (sorted(1, next) /= i) exit
            j = sorted(2, next)
            next = next + 1
            if (seen(j) == i) cycle
            seen(j) = i
            k = k + 1
            reached(k) = j
            if (root_of(j) /= i) cycle
            m = m + 1
            members(m) = j
         end do
         if (m < 2) cycle
         if (n + k*m > size(pairs, 2)) then
            allocate(larger(2, 2*(n + k*m)))
            larger(:, :n) = pairs(:, :n)
            call move_alloc(larger, pairs)
         end if
         do j = 1, m
            pairs(1, n + 1:n + k) = members(j)
            pairs(2, n + 1:n + k) = reached(:k)
            n = n + k
         end do
      end do

   contains

      !> The body that stands for the cluster of a body.
      integer function root_of(body) result(root)
         integer, intent(in) :: body

         root = body
         do while (parent(root) /= root)
            parent(root) = parent(parent(root))
            root = parent(root)
         end do
      end function root_of

   end subroutine couple_joined

   !> Compute the entries at a state; all are zero where there is no right-hand side. Allocates
   !> nothing.
   subroutine evaluate(self, system, t, y)
      class(jacobian_type), intent(inout) :: self
      !> The system; its workspace is changed.
      type(system_type), intent(inout) :: system
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)
      type(linear_load_type) :: load
      logical :: closed
      type(spring_load_type) :: found
      integer :: i

      self%value = 0.0_wp
      self%torque = 0.0_wp
      self%force = 0.0_wp
      if (system%constraints%n_rigid > 0) then
         call system%derivative(t, y, self%rate)
         if (system%outside) return
      else
         call system%set_poses(y)
         if (system%layout%states > 0) call system%set_states(y)
      end if
      do i = 1, size(system%contacts)
         associate (contact => system%contacts(i))
            if (contact%rigid) cycle
            call linearize(contact, system%pose(contact%a), system%pose(contact%b), &
               system%resolution, load, closed)
            if (.not. closed) cycle
            call add_contact(self, system, i, load, y)
         end associate
      end do
      do i = 1, size(system%springs)
         associate (a => system%springs(i)%a, b => system%springs(i)%b)
            call system%springs(i)%vary(system%pose(a), system%pose(b), found, &
               load%slopes(:, :freedoms))
            load%force = found%force
            load%torque_a = -found%torque - cross(found%arm_a, found%force)
            load%torque_b = found%torque + cross(found%arm_b, found%force)
            call add_pair_load(self, system, a, b, load, y)
         end associate
      end do
      if (system%constraints%n_links > size(self%inverse, 1)) then
         call reserve(self, size(system%constraints%links))
      end if
      do i = 1, system%constraints%n_links
         associate (link => system%constraints%links(i))
            call linearize_link(system%contacts(link%contact), link, system%pose(link%body(1)), &
               system%pose(link%body(2)), accelerations(self, system, link%body), load)
            call add_contact(self, system, link%contact, load, y)
            call keep_gap_slopes(self, system, i, load, y)
         end associate
      end do
      do i = 1, size(system%bodies)
         call add_body(self, system, i, t, y)
      end do
      if (system%constraints%n_links > 0) call add_normal_forces(self, system)
   end subroutine evaluate

   !> Accelerations of the centres of mass (1:3) and angular accelerations (4:6) of two bodies,
   !> inertial frame [m/s2, rad/s2].
   pure function accelerations(self, system, body) result(acceleration)
      type(jacobian_type), intent(in) :: self
      type(system_type), intent(in) :: system
      !> The bodies; 0 is the ground.
      integer, intent(in) :: body(2)
      real(wp) :: acceleration(6, 2)
      integer :: i

      acceleration = 0.0_wp
      do i = 1, 2
         if (body(i) == 0) cycle
         acceleration(1:3, i) = velocity_of(self%rate, body(i))
         acceleration(4:6, i) = matmul(system%pose(body(i))%rotation, spin_of(self%rate, body(i)))
      end do
   end function accelerations

   !> Add what a contact contributes at a given normal force.
   subroutine add_contact(self, system, index, load, y)
      type(jacobian_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      integer, intent(in) :: index
      type(linear_load_type), intent(in) :: load
      real(wp), intent(in) :: y(:)

      call add_pair_load(self, system, system%contacts(index)%a, system%contacts(index)%b, load, y)
      if (system%contacts(index)%states%n > 0) call add_states(self, system, index, load, y)
   end subroutine add_contact

   !> Add what acts between two bodies.
   subroutine add_pair_load(self, system, a, b, load, y)
      type(jacobian_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      !> The bodies; 0 is the ground.
      integer, intent(in) :: a
      integer, intent(in) :: b
      type(linear_load_type), intent(in) :: load
      real(wp), intent(in) :: y(:)
      real(wp) :: columns(outcomes, body_size)
      integer :: side, column_body, before

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
            quaternion_of(y, column_body), columns)
         before = body_size*(column_body - 1)
         if (a > 0) call add_rows(self, system, a, before, place_of(self, a, column_body), &
            -columns(1:3, :), columns(4:6, :))
         if (b > 0) call add_rows(self, system, b, before, place_of(self, b, column_body), &
            columns(1:3, :), columns(7:9, :))
         call add_work(self, before, system%layout%friction, columns(10, :))
         call add_work(self, before, system%layout%damping, columns(11, :))
      end do
   end subroutine add_pair_load

   !> Add the rates of the states of a contact, and what the states do.
   subroutine add_states(self, system, index, load, y)
      type(jacobian_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      integer, intent(in) :: index
      type(linear_load_type), intent(in) :: load
      real(wp), intent(in) :: y(:)
      real(wp) :: columns(most_numbers, body_size)
      integer :: side, c, k, place(2)

      associate (contact => system%contacts(index), n => system%contacts(index)%states%n, &
         before => system%contacts(index)%states%first - 1)
         do side = 1, 2
            associate (body => merge(contact%a, contact%b, side == 1))
               if (body == 0) cycle
               if (system%bodies(body)%motion == motion_fixed) cycle
               call to_state(load%rate_slopes(:n, 12*side - 11:12*side), system%pose(body), &
                  quaternion_of(y, body), columns(:n, :))
               do c = 1, body_size
                  k = self%column_start(body_size*(body - 1) + c) + self%state_offset(side, index)
                  self%value(k:k + n - 1) = self%value(k:k + n - 1) + columns(:n, c)
               end do
            end associate
         end do
         ! The accelerations of both bodies come first, in ascending order.
         place = 0
         if (contact%a > contact%b .and. is_acted_on(system, contact%b)) place(1) = acted_rows
         if (contact%b > contact%a .and. is_acted_on(system, contact%a)) place(2) = acted_rows
         do c = 1, n
            k = self%column_start(before + c) + self%state_offset(3, index)
            self%value(k:k + n - 1) = load%rate_slopes(:n, freedoms + c)
         end do
         associate (slopes => load%slopes(:, freedoms + 1:freedoms + n))
            if (contact%a > 0) call add_rows(self, system, contact%a, before, place(1), &
               -slopes(1:3, :), slopes(4:6, :))
            if (contact%b > 0) call add_rows(self, system, contact%b, before, place(2), &
               slopes(1:3, :), slopes(7:9, :))
            call add_work(self, before, system%layout%friction, slopes(10, :))
            call add_work(self, before, system%layout%damping, slopes(11, :))
         end associate
      end associate
   end subroutine add_states

   !> Keep the derivatives of the second derivative of the gap of a rigid contact by the state, at
   !> given accelerations.
   subroutine keep_gap_slopes(self, system, index, load, y)
      type(jacobian_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      !> Index of the link.
      integer, intent(in) :: index
      !> Load of the contact.
      type(linear_load_type), intent(in) :: load
      real(wp), intent(in) :: y(:)
      real(wp) :: columns(1, body_size)
      integer :: side, k

      self%gap_slopes(:, index) = 0.0_wp
      do side = 1, 2
         associate (body => system%constraints%links(index)%body(side))
            if (body == 0) cycle
            if (system%bodies(body)%motion == motion_fixed) cycle
            k = body_size*(body - 1)
            call to_state(load%gap_slopes(:, 12*side - 11:12*side), system%pose(body), &
               quaternion_of(y, body), columns)
            self%gap_slopes(k + 1:k + body_size, index) = columns(1, :)
         end associate
      end do
   end subroutine keep_gap_slopes

   !> Add what the normal forces of rigid contacts contribute, as they vary with the state.
   subroutine add_normal_forces(self, system)
      type(jacobian_type), intent(inout) :: self
      !> The system; its links are those of the state.
      type(system_type), intent(inout) :: system
      real(wp) :: moment(3, 2), lever(3), change(body_size)
      real(wp) :: force(3, body_size), torque(3, body_size)
      integer :: n, i, j, c, k, m, side, row, place

      n = system%constraints%n_links
      ! The response of the gap by all that accelerates the bodies of its contact.
      do i = 1, n
         associate (link => system%constraints%links(i))
            do side = 1, 2
               row = link%body(side)
               if (row == 0) cycle
               lever = matmul(cross(link%arm(:, side), link%at%normal), system%pose(row)%rotation)
               do j = 1, size(system%bodies)
                  place = place_of(self, row, j)
                  if (place < 0) cycle
                  do c = 1, body_size
                     m = body_size*(j - 1) + c
                     k = self%column_start(m) + place
                     self%gap_slopes(m, i) = self%gap_slopes(m, i) + merge(-1.0_wp, 1.0_wp, &
                        side == 1)*(dot_product(link%at%normal, self%value(k:k + 2)) &
                        + dot_product(lever, self%value(k + 3:k + 5)))
                  end do
               end do
            end do
         end associate
      end do
      call system%constraints%invert(self%inverse)
      do i = 1, n
         associate (link => system%constraints%links(i))
            do side = 1, 2
               moment(:, side) = cross(link%arm(:, side), link%slope(1:3)) + link%slope(4:6)
            end do
            do j = 1, size(system%bodies)
               k = body_size*(j - 1)
               change = 0.0_wp
               do m = 1, n
                  change = change - self%inverse(i, m)*self%gap_slopes(k + 1:k + body_size, m)
               end do
               if (.not. any(abs(change) > 0.0_wp)) cycle
               do side = 1, 2
                  row = link%body(side)
                  if (row == 0) cycle
                  do c = 1, body_size
                     force(:, c) = change(c)*link%slope(1:3)
                     torque(:, c) = change(c)*moment(:, side)
                  end do
                  if (side == 1) then
                     call add_rows(self, system, row, k, place_of(self, row, j), -force, -torque)
                  else
                     call add_rows(self, system, row, k, place_of(self, row, j), force, torque)
                  end if
               end do
               call add_work(self, k, system%layout%friction, -change*(dot_product( &
                  link%slope(1:3), link%slip()) &
                  + dot_product(link%slope(4:6), link%spin)))
            end do
         end associate
      end do
   end subroutine add_normal_forces

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

   !> Add a load to the acceleration of a body, or to the power that keeps its motion.
   pure subroutine add_rows(self, system, row_body, before, place, force, torque)
      type(jacobian_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      !> Body that is acted upon.
      integer, intent(in) :: row_body
      !> Index of the column before those of what varies.
      integer, intent(in) :: before
      !> Offset of the accelerations of the body in these columns, -1 if they are not there.
      integer, intent(in) :: place
      !> Derivatives of the force [N].
      real(wp), intent(in) :: force(:, :)
      !> Derivatives of the torque about the centre of mass [N m], inertial frame.
      real(wp), intent(in) :: torque(:, :)
      real(wp) :: moment(3), spin(3)
      integer :: c, k

      associate (body => system%bodies(row_body), pose => system%pose(row_body))
         if (moves_freely(body%motion) .and. place >= 0) then
            do c = 1, size(force, 2)
               k = self%column_start(before + c) + place
               self%value(k:k + 2) = self%value(k:k + 2) + force(:, c)/body%mass
               if (turns_by_drive(body%motion) .and. body%motion /= motion_rotor) cycle
               moment = matmul(torque(:, c), pose%rotation)
               if (body%motion == motion_rotor) moment(3) = 0.0_wp
               self%value(k + 3:k + 5) = self%value(k + 3:k + 5) + moment/body%inertia
            end do
         end if
         if (.not. turns_by_drive(body%motion)) return
         spin = pose%spin
         if (body%motion == motion_rotor) spin = dot_product(spin, pose%rotation(:, 3)) &
            *pose%rotation(:, 3)
         do c = 1, size(torque, 2)
            call add_work(self, before + c - 1, system%layout%applied, &
               [-dot_product(spin, torque(:, c))])
            if (body%motion == motion_prescribed) call add_work(self, before + c - 1, &
               system%layout%applied, [-dot_product(pose%velocity, force(:, c))])
         end do
      end associate
   end subroutine add_rows

   !> Add to the rate of a work.
   pure subroutine add_work(self, before, index, power)
      type(jacobian_type), intent(inout) :: self
      !> Index of the column before those of what varies.
      integer, intent(in) :: before
      !> Index of the work in the state; 0 for none.
      integer, intent(in) :: index
      !> Derivatives of the power [W].
      real(wp), intent(in) :: power(:)
      integer :: c, k

      if (index == 0) return
      do c = 1, size(power)
         ! The works are the last rows of a column.
         k = self%column_start(before + c + 1) - 1 - (self%n - index)
         self%value(k) = self%value(k) + power(c)
      end do
   end subroutine add_work

   !> Add what a body contributes by itself, after its contacts.
   subroutine add_body(self, system, index, t, y)
      type(jacobian_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      integer, intent(in) :: index
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)
      real(wp) :: block(body_size, body_size), power(body_size), turn(3, 4), torque(3), w(3), q(4)
      real(wp) :: momentum(3), force(3), e(3)
      integer :: i, k, own

      associate (body => system%bodies(index), pose => system%pose(index))
         if (body%motion == motion_fixed) return
         block = 0.0_wp
         power = 0.0_wp
         q = quaternion_of(y, index)
         w = spin_of(y, index)
         turn = rotation_of(q)
         do i = 1, 3
            block(i, 7 + i) = 1.0_wp
         end do
         call quaternion_block(q, w, block(4:7, 4:7), block(4:7, 11:13))
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
         if (body%motion == motion_free .or. body%motion == motion_rotor) then
            do i = 1, 4
               block(11:13, 3 + i) = matmul(cross(torque, turn(:, i)), pose%rotation)/body%inertia
            end do
            momentum = body%inertia*w
            do i = 1, 3
               e = 0.0_wp
               e(i) = 1.0_wp
               block(11:13, 10 + i) = (cross(momentum, e) - cross(w, body%inertia*e))/body%inertia
            end do
            if (body%motion == motion_rotor) then
               block(13, :) = 0.0_wp
               associate (axis => pose%rotation(:, 3))
                  do i = 1, 4
                     power(3 + i) = power(3 + i) - w(3)*dot_product(torque, cross(turn(:, i), axis))
                  end do
                  power(13) = power(13) - dot_product(torque, axis)
                  if (body%load_follows) power(13) = power(13) - body%torque(3)
               end associate
            end if
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
         own = place_of(self, index, index) - (first_row - 1)
         do i = 1, body_size
            k = self%column_start(body_size*(index - 1) + i) + own
            self%value(k:k + body_size - 1) = self%value(k:k + body_size - 1) + block(:, i)
         end do
      end associate
      call add_work(self, body_size*(index - 1), system%layout%applied, power)
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

end module contensou_dynamics_jacobian
