!> Rigid contacts: the contact as a constraint without compliance, whose normal force follows from
!> the equations of motion.
!>
!> With u the velocity of B against A at the contact point p and n the normal, the gap changes by
!> n.u and its second derivative is
!>    n.(a_B + alpha_B x r_B - a_A - alpha_A x r_A) + n'.u
!>       + n.(w_B x (p' - v_B) - w_A x (p' - v_A)),
!> r the arms from the centres of mass to p. It is linear in the wrench of the contact, and this in
!> the normal force N but for the size of the spot, a ~ N^(1/3) after Hertz.
!> A closed contact has the N at which the second derivative is -2 beta gap' - beta^2 gap: the last
!> two terms hold what rounding and the errors of the integration make of the gap (J. Baumgarte,
!> Comput. Methods Appl. Mech. Eng. 1 (1972) 1).
!>
!> Bodies on more supports than they need: the equations leave the forces open, and these are what
!> the compliance of the contacts makes them, in the limit of a large stiffness. The bodies yield by
!> d = J x, J the rows of the gaps, x small displacements, and each contact answers by the force N =
!> k d^(3/2) of Hertz, so that as many numbers are sought as rows of J are independent, from as many
!> equations. Contacts that this unloads (d < 0) stay closed while the others hold their gap.
module contensou_dynamics_constraints
   use contensou_base_kinds, only : wp
   use contensou_base_vectors, only : cross
   use contensou_contact_friction_law, only : sliding_type
   use contensou_contact_geometry, only : contact_point_type, contact_variation_type, pose_type, &
      search_trouble, track_type, trouble_jammed, trouble_none, trouble_redundant
   use contensou_contact_law, only : contact_law_type
   use contensou_contact_states, only : most_states
   use contensou_dynamics_mechanism, only : contact_type, mechanism_type, relative_motion
   use contensou_dynamics_scene, only : motion_free, motion_prescribed
   use contensou_dynamics_state, only : add_to_motion, spin_of, velocity_of
   implicit none(type, external)
   private

   public :: constraints_type, link_type, find_link, set_kinematics, response, turned_by
   public :: solve_linear, set_load, normal_response, independent_rows

   !> Iterations for the normal forces, which converge quadratically.
   integer, parameter :: most_iterations = 50

   !> Relative change of a normal force whose square is below rounding.
   real(wp), parameter :: converged = 3.0e-9_wp

   !> Relative error of a normal force that rounding makes anyway.
   real(wp), parameter :: rounding = 4.0_wp*epsilon(1.0_wp)

   !> As `converged`, for forces that compliance shares, whose equations are worse conditioned.
   real(wp), parameter :: converged_shared = 1.0e-7_wp

   !> Closed contacts for which there is room from the start, if there are so many rigid ones.
   integer, parameter :: first_room = 64

   !> Square of the distance of a row of a unit length from those before it, below which it counts
   !> as dependent on them.
   real(wp), parameter :: dependent = 1.0e-9_wp

   !> Least pivot over the largest response of three or more contacts whose forces are determined.
   real(wp), parameter :: least_pivot = 1.0e-11_wp

   !> Stiffness of a contact that is unloaded while others hold its gap, over that under a load: the
   !> equations stay regular.
   real(wp), parameter :: slack = 1.0e-8_wp

   !> Pull of such a contact, over the mean load, that is no lift-off.
   real(wp), parameter :: slack_pull = 1.0e-6_wp

   !> A closed rigid contact at a state, inertial frame.
   type :: link_type
      integer :: contact = 0
      !> Bodies A and B; 0 is the ground.
      integer :: body(2) = 0
      !> Geometry.
      type(contact_point_type) :: at
      !> Unit tangent along the minor axis of the spot.
      real(wp) :: minor(3) = 0.0_wp
      !> From the centres of mass of A and B to the contact point [m].
      real(wp) :: arm(3, 2) = 0.0_wp
      !> Inverse masses [1/kg]; 0 for a body that does not yield.
      real(wp) :: inverse_mass(2) = 0.0_wp
      !> Angular acceleration by a unit normal force on the body [1/(kg m)].
      real(wp) :: tilt(3, 2) = 0.0_wp
      !> Sliding along the major and the minor axis [m/s], spin about the normal [rad/s].
      real(wp) :: motion(3) = 0.0_wp
      !> Angular velocity of B against A [rad/s].
      real(wp) :: spin(3) = 0.0_wp
      !> Square of the velocity below which sliding is not resolved [m2/s2].
      real(wp) :: resolution = 0.0_wp
      !> Rate of the gap [m/s].
      real(wp) :: rate = 0.0_wp
      !> Second derivative of the gap that no acceleration makes [m/s2].
      real(wp) :: bias = 0.0_wp
      !> Second derivative of the gap without rigid contacts [m/s2].
      real(wp) :: free = 0.0_wp
      !> Square of the rate beta at which an error of the gap decays [1/s2].
      real(wp) :: pace = 0.0_wp
      !> Stabilisation 2 beta gap' + beta^2 gap [m/s2].
      real(wp) :: stabilisation = 0.0_wp
      !> Normal force [N].
      real(wp) :: normal_force = 0.0_wp
      !> Force (1:3) and torque (4:6) on B at the contact point [N, N m].
      real(wp) :: wrench(6) = 0.0_wp
      !> Their derivatives by the normal force [-, m].
      real(wp) :: slope(6) = 0.0_wp
   contains
      procedure :: slip
      procedure :: load_on
   end type link_type

   !> A contact that shares a load, and a displacement.
   type :: share_type
      !> Scale that makes the row of its gap a unit one [kg^(1/2)].
      real(wp) :: scale = 0.0_wp
      !> Its displacement over that under the mean load, by that of its unit row.
      real(wp) :: lever = 0.0_wp
      !> Square of the length that a column of the basis had.
      real(wp) :: square = 0.0_wp
      !> Displacement along that column, and its last change.
      real(wp) :: u = 0.0_wp, step = 0.0_wp
   end type share_type

   !> The rigid contacts of a mechanism.
   type :: constraints_type
      !> Number of rigid contacts.
      integer :: n_rigid = 0
      !> Number of those that were closed in the last right-hand side.
      integer :: n_links = 0
      !> These contacts, with room for more.
      type(link_type), allocatable :: links(:)
      !> Pull that is no lift-off [N]: zero where the forces are determined without the compliance
      !> of the contacts.
      real(wp) :: pull = 0.0_wp
      !> Equations for their normal forces.
      real(wp), allocatable, private :: matrix(:, :), right(:)
      !> Number of independent gaps where the forces are not determined; 0 where they are.
      integer, private :: rank = 0
      !> Mean load there [N].
      real(wp), private :: load = 0.0_wp
      type(share_type), allocatable, private :: shared(:)
      !> Unit columns that span the unit rows of the gaps, what projects on them, derivatives of the
      !> normal forces by displacements along them, and equations for these.
      real(wp), allocatable, private :: basis(:, :), projector(:, :), yielding(:, :), reduced(:, :)
   contains
      procedure :: prepare
      procedure :: apply
      !> Derivatives of the normal forces by the accelerations of the gaps.
      procedure :: invert
      procedure, private :: reserve
      procedure, private :: find_forces
      procedure, private :: share_load
   end type constraints_type

contains

   !> Slip of B against A at the contact [m/s].
   pure function slip(self)
      class(link_type), intent(in) :: self
      real(wp) :: slip(3)

      slip = self%motion(1)*self%at%major + self%motion(2)*self%minor
   end function slip

   !> Force and torque of the contact on one of its bodies, inertial frame.
   pure subroutine load_on(self, side, force, torque)
      class(link_type), intent(in) :: self
      !> 1 for body A, 2 for body B.
      integer, intent(in) :: side
      !> Force [N].
      real(wp), intent(out) :: force(3)
      !> Torque about the centre of mass [N m].
      real(wp), intent(out) :: torque(3)

      force = self%wrench(1:3)
      torque = cross(self%arm(:, side), force) + self%wrench(4:6)
      if (side == 2) return
      force = -force
      torque = -torque
   end subroutine load_on

   !> Make room for the contacts of a mechanism, none of them closed yet.
   subroutine prepare(self, mechanism)
      class(constraints_type), intent(inout) :: self
      type(mechanism_type), intent(in) :: mechanism

      self%n_rigid = count(mechanism%contacts%rigid)
      self%n_links = 0
      call self%reserve(min(self%n_rigid, first_room))
   end subroutine prepare

   !> Make room for a number of closed contacts; what was known of others is lost.
   subroutine reserve(self, n)
      class(constraints_type), intent(inout) :: self
      integer, intent(in) :: n

      if (allocated(self%links)) deallocate(self%links, self%matrix, self%right, self%shared, &
         self%basis, self%projector, self%yielding, self%reduced)
      allocate(self%links(n), self%matrix(n, n), self%right(n), self%shared(n), self%basis(n, n), &
         self%projector(n, n), self%yielding(n, n), self%reduced(n, n))
   end subroutine reserve

   !> Add what the closed rigid contacts do to the accelerations.
   subroutine apply(self, mechanism, rate, friction_power, index, trouble, outside)
      class(constraints_type), intent(inout) :: self
      !> The mechanism at the poses that are set; the normal forces of its contacts are kept there.
      type(mechanism_type), intent(inout) :: mechanism
      !> Time derivative of the state, without rigid contacts on entry.
      real(wp), intent(inout) :: rate(:)
      !> Power lost in friction so far [W].
      real(wp), intent(inout) :: friction_power
      !> Contact in trouble; unchanged if none is.
      integer, intent(inout) :: index
      !> One of the `trouble_*` codes; unchanged if no contact is in trouble.
      integer, intent(inout) :: trouble
      !> Whether there are no accelerations: trouble, or a gap of a step that is far too large.
      logical, intent(out) :: outside
      integer :: i, j, n, failure

      outside = .false.
      self%n_links = 0
      n = count(mechanism%contacts%closed)
      if (n == 0) return
      ! Contacts close at impacts; elsewhere there is room.
      if (n > size(self%links)) call self%reserve(min(2*n, self%n_rigid))
      failure = trouble_none
      do i = 1, size(mechanism%contacts)
         if (.not. mechanism%contacts(i)%closed) cycle
         self%n_links = self%n_links + 1
         call find_link(mechanism, i, rate, self%links(self%n_links), failure)
         if (failure /= trouble_none) exit
         outside = abs(self%links(self%n_links)%at%gap) > &
            mechanism%contacts(i)%law%largest_approach
         if (outside) return
      end do
      if (failure == trouble_none) call self%find_forces(mechanism, i, failure)
      outside = failure /= trouble_none
      if (outside) then
         index = i
         trouble = failure
         return
      end if
      do i = 1, self%n_links
         associate (link => self%links(i))
            mechanism%contacts(link%contact)%normal_force = link%normal_force
            friction_power = friction_power - dot_product(link%wrench(1:3), link%slip()) &
               - dot_product(link%wrench(4:6), link%spin)
            do j = 1, 2
               if (link%body(j) > 0) call accelerate(mechanism, link, j, rate)
            end do
            if (mechanism%contacts(link%contact)%states%n > 0) call set_state_rates(link, &
               mechanism%contacts(link%contact), mechanism%pose(link%body(1)), &
               mechanism%pose(link%body(2)))
         end associate
      end do
   end subroutine apply

   !> Accelerate a body by the load of a closed contact.
   subroutine accelerate(mechanism, link, side, rate)
      type(mechanism_type), intent(in) :: mechanism
      type(link_type), intent(in) :: link
      !> 1 for body A, 2 for body B.
      integer, intent(in) :: side
      !> Time derivative of the state.
      real(wp), intent(inout) :: rate(:)
      real(wp) :: force(3), torque(3), moment(3)

      call link%load_on(side, force, torque)
      associate (body => mechanism%bodies(link%body(side)), &
         pose => mechanism%pose(link%body(side)), power => mechanism%layout%applied)
         if (body%motion == motion_free) then
            moment = matmul(torque, pose%rotation)
            call add_to_motion(rate, link%body(side), force/body%mass, moment/body%inertia)
         else if (body%motion == motion_prescribed) then
            rate(power) = rate(power) - dot_product(force, pose%velocity) &
               - dot_product(torque, pose%spin)
         end if
      end associate
   end subroutine accelerate

   !> Kinematics of a rigid contact at the poses that are set, closed or not.
   subroutine find_link(mechanism, index, rate, link, trouble)
      !> The mechanism; the track of the contact is changed, and its normal part.
      type(mechanism_type), intent(inout) :: mechanism
      integer, intent(in) :: index
      !> Time derivative of the state without rigid contacts.
      real(wp), intent(in) :: rate(:)
      type(link_type), intent(inout) :: link
      !> One of the `trouble_*` codes.
      integer, intent(out) :: trouble
      real(wp) :: inverse_inertia(3, 2), acceleration(3), turned(3), gap
      integer :: j

      trouble = trouble_none
      associate (contact => mechanism%contacts(index), &
         a => mechanism%pose(mechanism%contacts(index)%a), &
         b => mechanism%pose(mechanism%contacts(index)%b))
         link%contact = index
         link%body(1) = contact%a
         link%body(2) = contact%b
         call contact%find_gap(a, b, gap)
         if (contact%track%lost) then
            trouble = search_trouble(contact%track)
            return
         end if
         call contact%locate(a, b, gap, link%at)
         call contact%follow(link%at, trouble)
         if (trouble /= trouble_none) return
         link%inverse_mass = 0.0_wp
         inverse_inertia = 0.0_wp
         do j = 1, 2
            if (link%body(j) == 0) cycle
            associate (body => mechanism%bodies(link%body(j)))
               if (body%motion /= motion_free) cycle
               link%inverse_mass(j) = 1.0_wp/body%mass
               inverse_inertia(:, j) = 1.0_wp/body%inertia
            end associate
         end do
         link%resolution = mechanism%resolution%of(a, b, link%at%point)
         call set_kinematics(link, contact%law, contact%track, a, b, inverse_inertia)
         link%free = link%bias
         do j = 1, 2
            if (link%body(j) == 0) cycle
            ! Copies: gfortran takes memory for the product with a part of an assumed-shape array.
            acceleration = spin_of(rate, link%body(j))
            turned = matmul(mechanism%pose(link%body(j))%rotation, acceleration)
            acceleration = velocity_of(rate, link%body(j)) + cross(turned, link%arm(:, j))
            link%free = link%free + merge(-1.0_wp, 1.0_wp, j == 1) &
               *dot_product(link%at%normal, acceleration)
         end do
         ! The gap returns within about a radian of the motion, which steps resolve anyway.
         link%pace = dot_product(a%spin, a%spin) + dot_product(b%spin, b%spin) &
            + (link%motion(1)**2 + link%motion(2)**2)*(2.0_wp*link%at%curvature_b)**2 &
            + abs(link%free)*2.0_wp*link%at%curvature_b
         link%stabilisation = 2.0_wp*sqrt(link%pace)*link%rate + link%pace*link%at%gap
      end associate
   end subroutine find_link

   !> Normal forces of the closed rigid contacts by Newton's method.
   subroutine find_forces(self, mechanism, index, trouble)
      !> The constraints; their links are set.
      class(constraints_type), intent(inout) :: self
      type(mechanism_type), intent(in) :: mechanism
      !> Index of the contact that is in trouble, if one is.
      integer, intent(inout) :: index
      !> One of the `trouble_*` codes.
      integer, intent(out) :: trouble
      real(wp) :: change, largest, defect
      integer :: i, j, k, n
      logical :: singular

      trouble = trouble_none
      n = self%n_links
      self%rank = 0
      self%pull = 0.0_wp
      do i = 1, n
         associate (link => self%links(i))
            ! The last force is a guess.
            link%normal_force = mechanism%contacts(link%contact)%normal_force
            if (.not. link%normal_force > 0.0_wp) then
               link%slope = 0.0_wp
               link%slope(1:3) = link%at%normal
               link%normal_force = max(-link%free/response(link, link, link%slope), 0.0_wp)
            end if
         end associate
      end do
      do k = 1, most_iterations
         do i = 1, n
            call set_load(self%links(i), mechanism%contacts(self%links(i)%contact), &
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
         if (n == 1) defect = proportionality_defect(self%links(1), self%matrix(1, 1), &
            self%right(1))
         if (n < 3) then
            call solve_linear(n, self%matrix, self%right, singular)
         else
            call solve_linear(n, self%matrix, self%right, singular, least_pivot)
         end if
         if (singular) exit
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
         if (n == 1) then
            if (0.5_wp*defect*change**2 <= rounding*largest**3) return
         end if
      end do
      if (n > 1) then
         call self%share_load(mechanism, index, trouble)
      else
         index = self%links(n)%contact
         trouble = trouble_jammed
      end if
   end subroutine find_forces

   !> How far the load of a contact is from being proportional to its normal force [N]: half of it
   !> times the square of a relative change of this force is the error that a step of Newton's
   !> method leaves.
   pure function proportionality_defect(link, answer, missing) result(defect)
      !> The contact, its load set.
      type(link_type), intent(in) :: link
      !> Second derivative of the gap by the normal force [1/kg].
      real(wp), intent(in) :: answer
      !> What the second derivative of the gap lacks [m/s2].
      real(wp), intent(in) :: missing
      real(wp) :: defect

      defect = abs(link%normal_force + (missing + link%free + link%stabilisation)/answer)
   end function proportionality_defect

   !> Normal forces of closed contacts that are more than the bodies need, by Newton's method.
   subroutine share_load(self, mechanism, index, trouble)
      !> The constraints; their links are set.
      class(constraints_type), intent(inout) :: self
      !> The mechanism; its contacts have the last normal forces.
      type(mechanism_type), intent(in) :: mechanism
      !> Index of the contact that is in trouble, if one is.
      integer, intent(inout) :: index
      !> One of the `trouble_*` codes.
      integer, intent(out) :: trouble
      real(wp) :: residual, last, change, largest
      integer :: i, k, n, r, halvings
      logical :: singular, shortened

      trouble = trouble_none
      n = self%n_links
      call set_up_sharing(self, mechanism)
      r = self%rank
      call first_displacements(self, mechanism)
      last = huge(last)
      halvings = 0
      associate (shared => self%shared, right => self%right)
         do k = 1, most_iterations
            call yield_to(self, mechanism)
            call project_residual(self)
            residual = norm2(right(:r))
            if (residual > last .and. halvings < 8) then
               ! Too far: half of the step.
               halvings = halvings + 1
               shared(:r)%step = 0.5_wp*shared(:r)%step
               shared(:r)%u = shared(:r)%u - shared(:r)%step
               cycle
            end if
            halvings = 0
            last = residual
            call reduce(self)
            call solve_linear(r, self%reduced, right, singular)
            if (singular) exit
            call shorten(self, shortened)
            shared(:r)%step = right(:r)
            shared(:r)%u = shared(:r)%u + shared(:r)%step
            change = 0.0_wp
            largest = self%pull
            do i = 1, n
               associate (link => self%links(i))
                  ! To first order, as with forces that are determined.
                  right(i) = dot_product(self%yielding(i, :r), shared(:r)%step)
                  link%normal_force = link%normal_force + right(i)
                  link%wrench = link%wrench + right(i)*link%slope
                  change = max(change, abs(right(i)))
                  largest = max(largest, abs(link%normal_force))
               end associate
            end do
            if (change <= converged_shared*largest .and. .not. shortened) return
         end do
      end associate
      index = self%links(n)%contact
      trouble = merge(trouble_redundant, trouble_jammed, r < n)
   end subroutine share_load

   !> Scales, independent rows and compliances of the closed contacts.
   subroutine set_up_sharing(self, mechanism)
      class(constraints_type), intent(inout) :: self
      type(mechanism_type), intent(in) :: mechanism
      real(wp) :: pace
      integer :: i, j, n

      n = self%n_links
      pace = maxval(self%links(:n)%pace)
      associate (shared => self%shared)
         self%load = 0.0_wp
         do i = 1, n
            associate (link => self%links(i))
               shared(i)%scale = 1.0_wp/sqrt(normal_response(link, link))
               self%load = self%load + (link%free*shared(i)%scale**2)**2
               ! One pace for all: what holds the gaps depends as the gaps do.
               link%stabilisation = 2.0_wp*sqrt(pace)*link%rate + pace*link%at%gap
            end associate
         end do
         self%load = max(sqrt(self%load/n), tiny(pace)**0.25_wp)
         self%pull = slack_pull*self%load
         do j = 1, n
            do i = 1, n
               self%matrix(i, j) = shared(i)%scale*shared(j)%scale &
                  *normal_response(self%links(i), self%links(j))
            end do
         end do
         call independent_rows(n, self%matrix, self%basis, self%rank)
         call set_up_projector(self)
         do i = 1, n
            associate (law => mechanism%contacts(self%links(i)%contact)%law)
               shared(i)%lever = 1.0_wp/(shared(i)%scale*law%normal%approach(self%load))
            end associate
         end do
         shared(:n)%lever = shared(:n)%lever/maxval(shared(:n)%lever)
      end associate
   end subroutine set_up_sharing

   !> Unit columns for the basis, and what turns accelerations of the gaps into forces along them:
   !> of the responses B B^T of unit rows it makes B^T.
   subroutine set_up_projector(self)
      class(constraints_type), intent(inout) :: self
      integer :: i, j, r
      logical :: singular

      r = self%rank
      do j = 1, r
         associate (column => self%basis(:self%n_links, j), square => self%shared(j)%square)
            square = dot_product(column, column)
            column = column/sqrt(square)
         end associate
      end do
      do i = 1, self%n_links
         do j = 1, r
            self%reduced(:r, j) = matmul(self%basis(:self%n_links, j), &
               self%basis(:self%n_links, :r))
            self%right(j) = self%basis(i, j)
         end do
         call solve_linear(r, self%reduced, self%right, singular)
         self%projector(:r, i) = self%right(:r)/self%shared(:r)%square
      end do
   end subroutine set_up_projector

   !> Displacements that come next to those of the last normal forces, or of equal ones.
   subroutine first_displacements(self, mechanism)
      class(constraints_type), intent(inout) :: self
      type(mechanism_type), intent(in) :: mechanism
      real(wp) :: x
      integer :: i, j, n, r
      logical :: known

      n = self%n_links
      r = self%rank
      known = .false.
      do i = 1, n
         known = known .or. mechanism%contacts(self%links(i)%contact)%normal_force > 0.0_wp
      end do
      self%shared(:r)%u = 0.0_wp
      do i = 1, n
         x = 1.0_wp
         if (known) x = (max(mechanism%contacts(self%links(i)%contact)%normal_force, 0.0_wp) &
            /self%load)**(2.0_wp/3.0_wp)
         x = x/self%shared(i)%lever
         do j = 1, r
            self%shared(j)%u = self%shared(j)%u + self%shared(j)%square*self%projector(j, i)*x
         end do
      end do
   end subroutine first_displacements

   !> Shorten a change of the displacements, in `right`, that would overload a contact: one without
   !> a load, as when it closes, has no stiffness, and may be far from its place.
   subroutine shorten(self, shortened)
      class(constraints_type), intent(inout) :: self
      logical, intent(out) :: shortened
      real(wp) :: largest, share, x, change
      integer :: i, r

      r = self%rank
      largest = 1.0_wp
      do i = 1, self%n_links
         largest = max(largest, self%shared(i)%lever*dot_product(self%basis(i, :r), &
            self%shared(:r)%u))
      end do
      share = 1.0_wp
      do i = 1, self%n_links
         associate (row => self%basis(i, :r), lever => self%shared(i)%lever)
            x = lever*dot_product(row, self%shared(:r)%u)
            change = lever*dot_product(row, self%right(:r))
            if (share*change > largest - min(x, 0.0_wp)) share = (largest - min(x, 0.0_wp))/change
         end associate
      end do
      shortened = share < 1.0_wp
      if (shortened) self%right(:r) = self%right(:r)*share
   end subroutine shorten

   !> Loads of the contacts at displacements.
   subroutine yield_to(self, mechanism)
      class(constraints_type), intent(inout) :: self
      type(mechanism_type), intent(in) :: mechanism
      real(wp) :: x, root
      integer :: i, r

      r = self%rank
      do i = 1, self%n_links
         x = self%shared(i)%lever*dot_product(self%basis(i, :r), self%shared(:r)%u)
         root = sqrt(max(x, 0.0_wp))
         self%yielding(i, :r) = self%load*self%shared(i)%lever*(1.5_wp*root + slack) &
            *self%basis(i, :r)
         call set_load(self%links(i), mechanism%contacts(self%links(i)%contact), &
            self%load*(root**3 + slack*x))
      end do
   end subroutine yield_to

   !> What the accelerations of the gaps lack, in the span of the independent rows.
   subroutine project_residual(self)
      class(constraints_type), intent(inout) :: self
      real(wp) :: missing
      integer :: i, j

      self%right(:self%rank) = 0.0_wp
      do i = 1, self%n_links
         missing = -self%links(i)%free - self%links(i)%stabilisation
         do j = 1, self%n_links
            missing = missing - response(self%links(i), self%links(j), self%links(j)%wrench)
         end do
         missing = missing*self%shared(i)%scale
         do j = 1, self%rank
            self%right(j) = self%right(j) + self%projector(j, i)*missing
         end do
      end do
   end subroutine project_residual

   !> Equations for a change of the displacements.
   subroutine reduce(self)
      class(constraints_type), intent(inout) :: self
      real(wp) :: answer
      integer :: i, j, k, r

      r = self%rank
      self%reduced(:r, :r) = 0.0_wp
      do i = 1, self%n_links
         do j = 1, self%n_links
            answer = self%shared(i)%scale &
               *response(self%links(i), self%links(j), self%links(j)%slope)
            do k = 1, r
               self%reduced(:r, k) = self%reduced(:r, k) &
                  + (answer*self%yielding(j, k))*self%projector(:r, i)
            end do
         end do
      end do
   end subroutine reduce

   !> Derivatives of the normal forces by the second derivatives of the gaps that they make, after
   !> `apply`: the inverse of the responses where the forces are determined.
   subroutine invert(self, inverse)
      class(constraints_type), intent(inout) :: self
      real(wp), intent(out) :: inverse(:, :)
      integer :: i, j, k, n
      logical :: singular

      n = self%n_links
      do i = 1, n
         if (self%rank > 0) then
            call reduce(self)
            self%right(:self%rank) = self%shared(i)%scale*self%projector(:self%rank, i)
            call solve_linear(self%rank, self%reduced, self%right, singular)
            do j = 1, n
               inverse(j, i) = dot_product(self%yielding(j, :self%rank), self%right(:self%rank))
            end do
         else
            do j = 1, n
               do k = 1, n
                  self%matrix(k, j) = response(self%links(k), self%links(j), self%links(j)%slope)
               end do
            end do
            inverse(:n, i) = 0.0_wp
            inverse(i, i) = 1.0_wp
            call solve_linear(n, self%matrix, inverse(:, i), singular)
         end if
      end do
   end subroutine invert

   !> Rows of a symmetric positive semidefinite matrix with a unit diagonal that are independent, by
   !> Cholesky's method with pivots: the columns of a factor that spans them.
   pure subroutine independent_rows(n, matrix, factor, rank)
      !> Number of rows.
      integer, intent(in) :: n
      real(wp), intent(in) :: matrix(:, :)
      !> The factor, n rows and as many columns as the rank.
      real(wp), intent(inout) :: factor(:, :)
      !> Number of independent rows.
      integer, intent(out) :: rank
      real(wp) :: left, most
      integer :: i, j, pivot

      rank = 0
      do
         pivot = 0
         most = dependent
         do i = 1, n
            left = matrix(i, i)
            do j = 1, rank
               left = left - factor(i, j)**2
            end do
            if (left <= most) cycle
            pivot = i
            most = left
         end do
         if (pivot == 0 .or. rank == n) return
         do i = 1, n
            left = matrix(i, pivot)
            do j = 1, rank
               left = left - factor(i, j)*factor(pivot, j)
            end do
            factor(i, rank + 1) = left/sqrt(most)
         end do
         rank = rank + 1
      end do
   end subroutine independent_rows

   !> Second derivative of the gap of one contact by a unit normal force at another one [1/kg].
   pure function normal_response(self, other) result(acceleration)
      !> The contact.
      type(link_type), intent(in) :: self
      !> Where the force acts.
      type(link_type), intent(in) :: other
      real(wp) :: acceleration
      real(wp) :: unit(6)

      unit(1:3) = other%at%normal
      unit(4:6) = 0.0_wp
      acceleration = response(self, other, unit)
   end function normal_response

   !> Angular acceleration of a body by a torque, without gyroscopic terms [rad/s2].
   pure function turned_by(torque, inverse_inertia, pose) result(rate)
      !> Torque about the centre of mass [N m], inertial frame.
      real(wp), intent(in) :: torque(3)
      !> Inverse principal moments of inertia [1/(kg m2)]; 0 for a body that does not yield.
      real(wp), intent(in) :: inverse_inertia(3)
      !> Pose of the body.
      type(pose_type), intent(in) :: pose
      real(wp) :: rate(3)
      real(wp) :: moment(3)

      moment = matmul(torque, pose%rotation)
      moment = inverse_inertia*moment
      rate = matmul(pose%rotation, moment)
   end function turned_by

   !> Kinematics of a closed contact; `at`, `body`, `inverse_mass` and `resolution` are set.
   pure subroutine set_kinematics(self, law, track, a, b, inverse_inertia)
      type(link_type), intent(inout) :: self
      type(contact_law_type), intent(in) :: law
      !> Where the surfaces are closest.
      type(track_type), intent(in) :: track
      type(pose_type), intent(in) :: a
      type(pose_type), intent(in) :: b
      !> Inverse principal moments of inertia of A and B [1/(kg m2)].
      real(wp), intent(in) :: inverse_inertia(3, 2)
      type(contact_variation_type) :: variation
      real(wp) :: velocity(3), twist(6), point_rate(3), normal_rate(3)

      associate (n => self%at%normal)
         self%minor = cross(n, self%at%major)
         self%arm(:, 1) = self%at%point - a%position
         self%arm(:, 2) = self%at%point - b%position
         self%tilt(:, 1) = turned_by(cross(self%arm(:, 1), n), inverse_inertia(:, 1), a)
         self%tilt(:, 2) = turned_by(cross(self%arm(:, 2), n), inverse_inertia(:, 2), b)
         call relative_motion(a, b, self%at%point, velocity, self%spin)
         self%motion = [dot_product(velocity, self%at%major), dot_product(velocity, self%minor), &
            dot_product(self%spin, n)]
         self%rate = dot_product(velocity, n)
         call law%geometry%vary(a, b, track, self%at, variation)
         twist(1:3) = velocity
         twist(4:6) = self%spin
         point_rate = matmul(variation%point, twist)
         point_rate = point_rate + a%velocity + cross(a%spin, self%arm(:, 1))
         normal_rate = matmul(variation%normal, twist)
         normal_rate = normal_rate + cross(a%spin, n)
         self%bias = dot_product(normal_rate, velocity) &
            + dot_product(n, cross(b%spin, point_rate - b%velocity)) &
            - dot_product(n, cross(a%spin, point_rate - a%velocity))
      end associate
   end subroutine set_kinematics

   !> Wrench of a contact at a normal force, and its derivative.
   !>
   !> Below N = 0, where an integrator looks for lift-off, the wrench of a point goes on linearly.
   pure subroutine set_load(self, contact, normal_force)
      !> The contact, its kinematics set.
      type(link_type), intent(inout) :: self
      type(contact_type), intent(in) :: contact
      !> Normal force [N].
      real(wp), intent(in) :: normal_force
      real(wp) :: root, a, wrench(3), slopes(3, 5), torque(3)

      associate (law => contact%law)
         self%normal_force = normal_force
         self%wrench(1:3) = normal_force*self%at%normal
         self%wrench(4:6) = 0.0_wp
         self%slope(1:3) = self%at%normal
         self%slope(4:6) = 0.0_wp
         root = 0.0_wp
         if (normal_force > 0.0_wp) root = sqrt(law%normal%approach(normal_force))
         a = law%normal%axis_a*root
         if (allocated(law%friction)) then
            if (contact%states%n == 0) then
               call law%friction%linearize(law%normal%shape, sliding_type(normal_force, a, &
                  self%motion(1), self%motion(2), self%motion(3), self%resolution), wrench, &
                  slopes)
            else
               call load_at_states(self, contact, normal_force, wrench, slopes)
            end if
            if (normal_force > 0.0_wp) slopes(:, 1) = slopes(:, 1) &
               + slopes(:, 2)*(a/(3.0_wp*normal_force))
            self%wrench(1:3) = self%wrench(1:3) + wrench(1)*self%at%major + wrench(2)*self%minor
            self%wrench(4:6) = wrench(3)*self%at%normal
            self%slope(1:3) = self%slope(1:3) + slopes(1, 1)*self%at%major + slopes(2, 1)*self%minor
            self%slope(4:6) = slopes(3, 1)*self%at%normal
         end if
         if (.not. allocated(law%rolling)) return
         if (.not. law%rolling%follows_spot) then
            torque = law%rolling%torque(1.0_wp, self%at%normal, self%at%major, a, &
               law%normal%axis_b*root, self%spin)
            self%slope(4:6) = self%slope(4:6) + torque
            self%wrench(4:6) = self%wrench(4:6) + normal_force*torque
         else if (normal_force > 0.0_wp) then
            ! The lever arm follows the spot.
            torque = law%rolling%torque(normal_force, self%at%normal, self%at%major, a, &
               law%normal%axis_b*root, self%spin)
            self%wrench(4:6) = self%wrench(4:6) + torque
            self%slope(4:6) = self%slope(4:6) + (4.0_wp/(3.0_wp*normal_force))*torque
         end if
      end associate
   end subroutine set_load

   !> Friction wrench of a contact at the states of its parts, and its derivatives by normal force
   !> and size of the spot. Below N = 0 it goes on linearly.
   pure subroutine load_at_states(self, contact, normal_force, wrench, slopes)
      !> The contact, its kinematics set.
      type(link_type), intent(in) :: self
      type(contact_type), intent(in) :: contact
      !> Normal force [N].
      real(wp), intent(in) :: normal_force
      real(wp), intent(out) :: wrench(3)
      !> Only the derivatives by these two are set.
      real(wp), intent(out) :: slopes(3, 5)
      real(wp) :: local(most_states), rates(most_states)
      real(wp) :: all_slopes(3 + most_states, 5 + most_states)

      local = contact%local_states(self%at)
      associate (n => contact%states%n_local)
         call contact%law%friction%vary(contact%law%normal%shape, &
            slides_of(self, contact, normal_force), local(:n), contact%states%scales, wrench, &
            rates(:n), all_slopes(:3 + n, :5 + n))
      end associate
      slopes = all_slopes(:3, :5)
      wrench = wrench + min(normal_force, 0.0_wp)*slopes(:, 1)
   end subroutine load_at_states

   !> What slides at a closed contact.
   pure function slides_of(self, contact, normal_force) result(slides)
      type(link_type), intent(in) :: self
      type(contact_type), intent(in) :: contact
      !> Normal force [N].
      real(wp), intent(in) :: normal_force
      type(sliding_type) :: slides
      real(wp) :: approach

      approach = 0.0_wp
      if (normal_force > 0.0_wp) approach = contact%law%normal%approach(normal_force)
      slides = contact%law%sliding(max(normal_force, 0.0_wp), approach, self%motion, &
         self%resolution)
   end function slides_of

   !> Rates of the states of the parts of a closed contact, its normal force known.
   subroutine set_state_rates(self, contact, a, b)
      type(link_type), intent(in) :: self
      type(contact_type), intent(inout) :: contact
      type(pose_type), intent(in) :: a
      type(pose_type), intent(in) :: b
      real(wp) :: wrench(3), local(most_states), rates(most_states)

      local = contact%local_states(self%at)
      associate (n => contact%states%n_local)
         call contact%law%friction%evolve(contact%law%normal%shape, &
            slides_of(self, contact, self%normal_force), local(:n), wrench, rates(:n))
         call contact%set_rates(a, b, self%at, self%slip() + self%rate*self%at%normal, self%spin, &
            rates(:n))
      end associate
   end subroutine set_state_rates

   !> Second derivative of the gap of one contact by a wrench at another one, or at itself [m/s2].
   pure function response(self, other, wrench) result(acceleration)
      type(link_type), intent(in) :: self
      !> Where the wrench acts.
      type(link_type), intent(in) :: other
      !> Force (1:3) and torque (4:6) on body B there [N, N m].
      real(wp), intent(in) :: wrench(6)
      real(wp) :: acceleration
      real(wp) :: part
      integer :: i, j

      acceleration = 0.0_wp
      do i = 1, 2
         if (self%body(i) == 0) cycle
         do j = 1, 2
            if (other%body(j) /= self%body(i)) cycle
            part = self%inverse_mass(i)*dot_product(self%at%normal, wrench(1:3)) &
               + dot_product(self%tilt(:, i), cross(other%arm(:, j), wrench(1:3)) + wrench(4:6))
            if (i == j) then
               acceleration = acceleration + part
            else
               acceleration = acceleration - part
            end if
         end do
      end do
   end function response

   !> Solve a small system of linear equations by elimination with row pivots.
   pure subroutine solve_linear(n, matrix, right, singular, least)
      !> Number of unknowns.
      integer, intent(in) :: n
      !> The matrix; overwritten.
      real(wp), intent(inout) :: matrix(:, :)
      !> Right-hand side; the solution on return.
      real(wp), intent(inout) :: right(:)
      !> Whether the matrix is singular to rounding.
      logical, intent(out) :: singular
      !> Least pivot over the largest element, if larger than that.
      real(wp), intent(in), optional :: least
      real(wp) :: factor, held, smallest
      integer :: i, j, k, pivot

      if (n == 1) then
         ! By far the most frequent case.
         smallest = abs(matrix(1, 1))
         singular = .not. smallest > 64.0_wp*epsilon(smallest)*smallest
         if (.not. singular) right(1) = right(1)/matrix(1, 1)
         return
      end if
      singular = .false.
      smallest = 64.0_wp*epsilon(smallest)*n*maxval(abs(matrix(:n, :n)))
      if (present(least)) smallest = max(smallest, least*maxval(abs(matrix(:n, :n))))
      do k = 1, n
         pivot = k - 1 + maxloc(abs(matrix(k:n, k)), dim=1)
         if (.not. abs(matrix(pivot, k)) > smallest) then
            singular = .true.
            return
         end if
         if (pivot /= k) then
            do j = k, n
               held = matrix(k, j)
               matrix(k, j) = matrix(pivot, j)
               matrix(pivot, j) = held
            end do
            held = right(k)
            right(k) = right(pivot)
            right(pivot) = held
         end if
         do i = k + 1, n
            factor = matrix(i, k)/matrix(k, k)
            do j = k + 1, n
               matrix(i, j) = matrix(i, j) - factor*matrix(k, j)
            end do
            right(i) = right(i) - factor*right(k)
         end do
      end do
      do k = n, 1, -1
         do j = k + 1, n
            right(k) = right(k) - matrix(k, j)*right(j)
         end do
         right(k) = right(k)/matrix(k, k)
      end do
   end subroutine solve_linear

end module contensou_dynamics_constraints
