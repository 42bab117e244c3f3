!> Rigid contacts: the contact as a constraint without compliance, whose normal force follows from
!> the equations of motion.
!>
!> A closed contact has the N at which the second derivative of its gap (module
!> `contensou_dynamics_links`) is -2 beta gap' - beta^2 gap: the last two terms hold what rounding
!> and the errors of the integration make of the gap (J. Baumgarte, Comput. Methods Appl. Mech. Eng.
!> 1 (1972) 1).
!>
!> Bodies on more supports than they need: the equations leave the forces open, and these are what
!> the compliance of the contacts makes them, in the limit of a large stiffness. The bodies yield by
!> d = J x, J the rows of the gaps, x small displacements, and each contact answers by the force N =
!> k d^(3/2) of Hertz, so that as many numbers are sought as rows of J are independent, from as many
!> equations. Contacts that this unloads (d < 0) stay closed while the others hold their gap.
module contensou_dynamics_constraints
   use contensou_base_kinds, only : wp
   use contensou_contact_geometry, only : trouble_jammed, trouble_none, trouble_redundant
   use contensou_dynamics_links, only : find_link, link_type, normal_response, response, &
      set_load, set_state_rates
   use contensou_dynamics_mechanism, only : mechanism_type
   use contensou_dynamics_scene, only : motion_free, motion_prescribed
   use contensou_dynamics_state, only : add_to_motion
   use contensou_special_elimination, only : independent_rows, solve_linear
   implicit none(type, external)
   private

   public :: constraints_type

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

   !> Least pivot over the largest response of three or more contacts whose forces are determined.
   real(wp), parameter :: least_pivot = 1.0e-11_wp

   !> Stiffness of a contact that is unloaded while others hold its gap, over that under a load: the
   !> equations stay regular.
   real(wp), parameter :: slack = 1.0e-8_wp

   !> Pull of such a contact, over the mean load, that is no lift-off.
   real(wp), parameter :: slack_pull = 1.0e-6_wp

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

   !> Normal forces of the closed rigid contacts by Newton's method.
   subroutine find_forces(self, mechanism, index, trouble)
      !> The constraints; their links are set.
      class(constraints_type), intent(inout) :: self
      type(mechanism_type), intent(inout) :: mechanism
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
         if (n > 1) cycle
         ! What is remembered may stick at the guess and slip at the force: no first order tells.
         if (allocated(mechanism%contacts(self%links(1)%contact)%tangential)) cycle
         if (0.5_wp*defect*change**2 <= rounding*largest**3) return
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
      type(mechanism_type), intent(inout) :: mechanism
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
            call shorten(self, mechanism, shortened)
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
   !> a load, as when it closes, has no stiffness, and may be far from its place. One that remembers
   !> may have its root at the smallest load: from without a load it goes to the load that the
   !> change asks for, and not beyond.
   subroutine shorten(self, mechanism, shortened)
      class(constraints_type), intent(inout) :: self
      type(mechanism_type), intent(in) :: mechanism
      logical, intent(out) :: shortened
      real(wp) :: largest, share, x, change, sought
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
            if (.not. allocated(mechanism%contacts(self%links(i)%contact)%tangential)) cycle
            if (x >= 0.0_wp) cycle
            sought = slack*x + dot_product(self%yielding(i, :r), self%right(:r))/self%load
            sought = max(sought, 0.0_wp)**(2.0_wp/3.0_wp)
            if (share*change > sought - x) share = (sought - x)/change
         end associate
      end do
      shortened = share < 1.0_wp
      if (shortened) self%right(:r) = self%right(:r)*share
   end subroutine shorten

   !> Loads of the contacts at displacements.
   subroutine yield_to(self, mechanism)
      class(constraints_type), intent(inout) :: self
      type(mechanism_type), intent(inout) :: mechanism
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

end module contensou_dynamics_constraints
