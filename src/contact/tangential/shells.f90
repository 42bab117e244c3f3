!> Tangential elasticity of a Hertz spot with local slip and memory: nested shells, each with an
!> elastic displacement of its own and a limit that is convex in force and torque together.
!>
!> A shell between the places x1 < x2, in units of the major semi-axis a, has the share x2 - x1 of
!> the stiffness against shift and S(x2) - S(x1) of that against twist. It slips as the difference
!> of two Hertz spots does: with Phi(v, w) the friction potential of the spot for the friction
!> model of the contact, l(x) = (3/2)(x - x^3/3) the load within x and c(x) = l^(2/3),
!>    phi(v, w) = l2 Phi(v, c2 w) - l1 Phi(v, c1 w),
!> which is convex, as l Phi(v, c(l) w) has a second derivative that grows with l. The potentials of
!> all shells sum to Phi, so full sliding gives the wrench of the friction model for any number of
!> shells. Without twist the shells are the springs of the method of dimensionality reduction
!> (Jaeger 1995, Popov and Hess 2015): many shells follow Cattaneo, Mindlin and Deresiewicz for any
!> history. S(x) makes a pure twist that of Lubkin (1951) on the circle.
!>
!> A step is an elastic trial e, after which each shell slips by the p that solves
!>    K (e - p) in d phi(p):
!> the minimum of the convex phi(p) + (e - p).K(e - p)/2. Formulas, errors: docs/tangential.md.
module contensou_contact_tangential_shells
   use contensou_base_checkpoint, only : checkpoint_type
   use contensou_base_kinds, only : wp
   use contensou_contact_spot, only : spot_shape_type
   use contensou_contact_tangential_edges, only : edge_at, edge_type, power_of
   use contensou_contact_tangential_slip, only : slip_of_shell, sliding_force, stiffness_after
   use contensou_contact_tangential_spot, only : spring_spot_type
   implicit none(type, external)
   private

   public :: shells_type, single_spring, spring_spot_type, default_layers, most_layers, &
      shells_per_layer, make_room

   !> Layers if nothing else is said, and the most.
   integer, parameter :: default_layers = 10, most_layers = 128

   !> Shells in a layer, which slip one after the other.
   integer, parameter :: shells_per_layer = 3

   !> Share of the shells, as an inverse, that a spot keeps at least while it shrinks.
   integer, parameter :: fewest = 10

   !> Slip over the elastic displacement below which the stiffness after it is that of this one.
   real(wp), parameter :: shortest_slip = 1.0e-8_wp

   !> The shells of a contact, from the centre to the rim, with what they remember.
   type :: shells_type
      !> Number of shells when the spot has a size.
      integer :: most = 0
      !> Number of shells now, zero without a contact.
      integer :: n = 0
      !> Major semi-axis [m].
      real(wp) :: a = 0.0_wp
      !> k_x, k_y and k_T of the spot.
      real(wp) :: stiffness(3) = 0.0_wp
      !> Outer edges along the major axis [m], from 0 on, and what is within them.
      real(wp), allocatable :: edge(:)
      !> Their powers 2/3.
      real(wp), allocatable, private :: power(:)
      type(edge_type), allocatable :: within(:)
      !> Elastic displacements along the axes [m] and about the normal [rad] of the shells.
      real(wp), allocatable :: shift(:, :)
      !> Directions of their last slips, or zero: where the next slip is sought first.
      real(wp), allocatable :: direction(:, :)
      !> Which slipped in the last step.
      logical, allocatable :: slipped(:)
      !> The axis along and across which the displacements have their components, seen from the
      !> axes of the spot where `stiffness` was.
      real(wp) :: axis(2) = [1.0_wp, 0.0_wp]
      !> Room.
      real(wp), allocatable, private :: room(:, :)
   contains
      procedure :: begin
      procedure :: advance
      procedure :: resize
      procedure :: clear
      procedure :: turn
      procedure :: energy
      procedure :: take
      procedure :: turn_to
      procedure :: slide
      procedure :: settle
      procedure :: stuck_share
      procedure :: exchange
   end type shells_type

contains

   !> Begin without a contact.
   pure subroutine begin(self, layers)
      class(shells_type), intent(inout) :: self
      !> Number of layers, 1 to 128; 10 if not given.
      integer, intent(in), optional :: layers
      integer :: number

      number = default_layers
      if (present(layers)) number = layers
      call self%clear()
      call make_room(self, shells_per_layer*number)
   end subroutine begin

   !> One spring with the stiffness of the whole spot, as granular codes have it.
   pure function single_spring() result(shells)
      type(shells_type) :: shells

      call make_room(shells, 1)
   end function single_spring

   !> Make room for shells, and for two more, by which a spot has grown.
   pure subroutine make_room(shells, number)
      class(shells_type), intent(inout) :: shells
      integer, intent(in) :: number

      if (allocated(shells%edge)) deallocate(shells%edge, shells%power, shells%within, &
         shells%shift, shells%direction, shells%slipped, shells%room)
      shells%most = number
      allocate(shells%edge(0:number + 2), source=0.0_wp)
      allocate(shells%power(0:number + 2), source=0.0_wp)
      allocate(shells%within(0:number + 2))
      allocate(shells%shift(3, number + 2), source=0.0_wp)
      allocate(shells%direction(3, number + 2), source=0.0_wp)
      allocate(shells%slipped(number + 2), source=.false.)
      allocate(shells%room(3, number + 2), source=0.0_wp)
   end subroutine make_room

   !> Forget all.
   pure subroutine clear(self)
      class(shells_type), intent(inout) :: self

      self%n = 0
      self%a = 0.0_wp
      self%stiffness = 0.0_wp
      if (allocated(self%direction)) self%direction = 0.0_wp
   end subroutine clear

   !> Name the axes anew where the major and the minor axis change their places: what is remembered
   !> is turned by a right angle, forth or back.
   pure subroutine turn(self, forth)
      class(shells_type), intent(inout) :: self
      !> Whether the new x axis is the old y axis, else the new y axis is the old x axis.
      logical, intent(in) :: forth
      real(wp) :: sense, x
      integer :: j

      sense = merge(1.0_wp, -1.0_wp, forth)
      do j = 1, self%n
         x = self%shift(1, j)
         self%shift(1, j) = sense*self%shift(2, j)
         self%shift(2, j) = -sense*x
      end do
      self%direction = 0.0_wp
   end subroutine turn

   !> Move the bodies by a step at the load of the spot.
   pure subroutine advance(self, spot, step, wrench, stored, lost, settled, slopes)
      class(shells_type), intent(inout) :: self
      type(spring_spot_type), intent(in) :: spot
      !> Shift of body 1 against body 2 along the axes [m] and twist [rad].
      real(wp), intent(in) :: step(3)
      !> Force along the axes [N] and torque [N m] on body 1.
      real(wp), intent(out) :: wrench(3)
      !> Elastic energy after the step [J].
      real(wp), intent(out) :: stored
      !> Work of the slip in the step and what a smaller spot has let go [J], >= 0.
      real(wp), intent(out) :: lost
      !> Whether shells are merged and divided so that their number stays, unless that is left to
      !> `settle`: without it the wrench is a continuous function of spot and step.
      logical, intent(in), optional :: settled
      !> Derivatives of the wrench by the step, and by the limit at constant size.
      real(wp), intent(out), optional :: slopes(3, 4)
      real(wp) :: stiffness(3), trial(3), force(3), bearing(3), work, units(3), part
      logical :: slips
      integer :: j, before

      wrench = 0.0_wp
      if (present(slopes)) slopes = 0.0_wp
      before = self%n
      call self%resize(spot, lost, settled)
      stored = 0.0_wp
      if (self%n == 0) return
      ! New area has come to the spot half-way on the average.
      part = 1.0_wp
      if (present(settled) .and. before > 0 .and. self%n > before) then
         self%shift(:, self%n) = -0.5_wp*step
         part = 0.5_wp
      end if
      if (.not. spot%limit > 0.0_wp) then
         lost = lost + self%energy()
         self%shift(:, :self%n) = 0.0_wp
         return
      end if
      ! Units of f N and of lengths.
      units = spot%limit*[1.0_wp, 1.0_wp, spot%a]
      do j = self%n, 1, -1
         call take_share(self, j, stiffness)
         trial = self%shift(:, j) + step
         force = stiffness*trial
         bearing = force/units
         if (j < self%n .and. all(abs(self%direction(:, j)) <= 0.0_wp)) self%direction(:, j) = &
            self%direction(:, j + 1)
         call slip_of_shell(spot%shape, self%within(j - 1), self%within(j), spot%rung, &
            stiffness*(spot%limit/units**2), trial*(units/spot%limit), bearing, &
            self%direction(:, j), slips, work)
         self%slipped(j) = slips
         if (present(slopes)) call add_slopes(self, j, spot, stiffness, units, trial, bearing, &
            part, slopes)
         part = 1.0_wp
         if (slips) then
            force = bearing*units
            trial = force/max(stiffness, tiny(stiffness))
            lost = lost + spot%limit*work
         end if
         self%shift(:, j) = trial
         wrench = wrench - force
         stored = stored + 0.5_wp*dot_product(force, trial)
      end do
   end subroutine advance

   !> Add what a shell contributes to the derivatives of the wrench.
   pure subroutine add_slopes(self, j, spot, stiffness, units, trial, bearing, part, slopes)
      class(shells_type), intent(in) :: self
      !> The shell.
      integer, intent(in) :: j
      type(spring_spot_type), intent(in) :: spot
      !> Its stiffness, and units of force and torque.
      real(wp), intent(in) :: stiffness(3), units(3)
      !> Elastic displacement of the trial.
      real(wp), intent(in) :: trial(3)
      !> Force of the shell in its units.
      real(wp), intent(in) :: bearing(3)
      !> Part of the step that the trial has.
      real(wp), intent(in) :: part
      real(wp), intent(inout) :: slopes(3, 4)
      real(wp) :: k(3), slip(3), length, by_trial(3, 3), by_limit(3)
      integer :: i

      if (.not. self%slipped(j)) then
         do i = 1, 3
            slopes(i, i) = slopes(i, i) - part*stiffness(i)
         end do
         return
      end if
      k = stiffness*(spot%limit/units**2)
      if (.not. minval(k) > 0.0_wp) return
      ! So narrow that it bears nothing, where nothing has moved.
      if (.not. any(abs(self%direction(:, j)) > 0.0_wp)) return
      slip = trial*(units/spot%limit) - bearing/k
      length = max(norm2(slip), shortest_slip*norm2(bearing/k))
      call stiffness_after(spot%shape, self%within(j - 1), self%within(j), spot%rung, k, &
         self%direction(:, j), length, by_trial, by_limit)
      do i = 1, 3
         slopes(:, i) = slopes(:, i) - part*by_trial(:, i)*units*units(i)/spot%limit
      end do
      slopes(:, 4) = slopes(:, 4) - by_limit*units/spot%limit
   end subroutine add_slopes

   !> Elastic energy [J].
   pure function energy(self) result(stored)
      class(shells_type), intent(in) :: self
      real(wp) :: stored, stiffness(3)
      integer :: j

      stored = 0.0_wp
      do j = 1, self%n
         call take_share(self, j, stiffness)
         stored = stored + 0.5_wp*dot_product(stiffness, self%shift(:, j)**2)
      end do
   end function energy

   !> Stiffness of a shell.
   pure subroutine take_share(self, j, stiffness)
      class(shells_type), intent(in) :: self
      !> The shell.
      integer, intent(in) :: j
      real(wp), intent(out) :: stiffness(3)

      stiffness(1:2) = self%stiffness(1:2)*((self%edge(j) - self%edge(j - 1))/self%a)
      ! Rounding errors are all there is where a shell is very narrow.
      stiffness(3) = self%stiffness(3)*max(self%within(j)%torsion - self%within(j - 1)%torsion, &
         0.0_wp)
   end subroutine take_share

   !> Set what is within the edges.
   pure subroutine set_within(self)
      class(shells_type), intent(inout) :: self
      real(wp) :: inverse, power
      integer :: j

      inverse = 1.0_wp/self%a
      power = power_of(inverse)
      self%within(0) = edge_type(0.0_wp, 0.0_wp, 0.0_wp)
      do j = 1, self%n - 1
         self%within(j) = edge_at(self%edge(j)*inverse, self%power(j)*power)
      end do
      self%within(self%n) = edge_at(1.0_wp, 1.0_wp)
   end subroutine set_within

   !> Bring the shells to the size and stiffness of a spot: new area is not strained, lost area lets
   !> go what it held, and shells that become stiffer keep their force. None of it makes energy.
   pure subroutine resize(self, spot, lost, settled)
      class(shells_type), intent(inout) :: self
      type(spring_spot_type), intent(in) :: spot
      !> Energy that is let go [J].
      real(wp), intent(out) :: lost
      !> Whether the number of shells is kept, unless that is left to `settle`.
      logical, intent(in), optional :: settled
      real(wp) :: before, now(3)
      logical :: settles
      integer :: j, i

      settles = .true.
      if (present(settled)) settles = settled

      lost = 0.0_wp
      if (.not. spot%a > 0.0_wp) then
         lost = self%energy()
         call self%clear()
         return
      end if
      if (self%n == 0) then
         self%n = self%most
         self%a = spot%a
         self%stiffness = spot%stiffness
         do j = 0, self%n
            self%edge(j) = spot%a*place(real(j, wp)/real(self%n, wp))
         end do
         self%power(:self%n) = power_of(self%edge(:self%n))
         call set_within(self)
         self%shift(:, :self%n) = 0.0_wp
         return
      end if
      ! As it was: bits that agree.
      if (abs(spot%a - self%a) <= 0.0_wp .and. &
         all(abs(spot%stiffness - self%stiffness) <= 0.0_wp)) then
         if (settles) then
            do while (self%n < self%most)
               call split_widest(self)
            end do
         end if
         return
      end if
      before = self%energy()
      if (spot%a < self%a) then
         do while (self%n > 1 .and. self%edge(self%n - 1) >= spot%a)
            self%n = self%n - 1
         end do
         self%edge(self%n) = spot%a
         self%power(self%n) = power_of(spot%a)
         self%within(self%n) = edge_at(spot%a/self%a, power_of(spot%a/self%a))
      end if
      do j = 1, self%n
         call take_share(self, j, self%room(:, j))
      end do
      if (spot%a > self%a) then
         self%n = self%n + 1
         self%edge(self%n) = spot%a
         self%power(self%n) = power_of(spot%a)
         self%shift(:, self%n) = 0.0_wp
         self%direction(:, self%n) = 0.0_wp
         self%room(:, self%n) = 0.0_wp
      end if
      self%a = spot%a
      self%stiffness = spot%stiffness
      call set_within(self)
      do j = 1, self%n
         call take_share(self, j, now)
         do i = 1, 3
            if (now(i) > self%room(i, j)) self%shift(i, j) = self%shift(i, j) &
               *(self%room(i, j)/now(i))
         end do
      end do
      if (settles) call self%settle()
      lost = max(before - self%energy(), 0.0_wp)
   end subroutine resize

   !> Merge or divide shells so that their number stays.
   pure subroutine settle(self)
      class(shells_type), intent(inout) :: self

      if (self%n == 0) return
      do while (self%n > self%most)
         call merge_narrowest(self)
      end do
      ! The halves of a shell that slides are not both at their limits: as late as will do.
      do while (fewest*self%n < self%most)
         call split_widest(self)
      end do
   end subroutine settle

   !> Be as others are, with components along the axes of a spot in the place of those along an
   !> axis, and some of the displacements let go. Where the stiffness is not the same in all
   !> directions turning it over what is strained makes no energy.
   pure subroutine take(self, others, axis, left)
      class(shells_type), intent(inout) :: self
      class(shells_type), intent(in) :: others
      !> The axis, seen from those of the spot.
      real(wp), intent(in) :: axis(2)
      !> What is left of the displacements along the axes and about the normal, from 0 to 1.
      real(wp), intent(in) :: left(3)
      real(wp) :: q(3), before, after
      integer :: j

      self%n = others%n
      self%a = others%a
      self%stiffness = others%stiffness
      self%axis = [1.0_wp, 0.0_wp]
      if (self%n == 0) return
      self%edge(:self%n) = others%edge(:self%n)
      self%edge(0) = 0.0_wp
      do j = 0, self%n
         self%power(j) = others%power(j)
         self%within(j) = others%within(j)
      end do
      do j = 1, self%n
         q = others%shift(:, j)*left
         self%shift(1:2, j) = turned(axis, q(1:2))
         self%shift(3, j) = q(3)
         self%slipped(j) = .false.
      end do
      do j = 1, self%n
         self%direction(1:2, j) = turned(axis, others%direction(1:2, j))
         self%direction(3, j) = others%direction(3, j)
      end do
      associate (k => self%stiffness)
         if (.not. abs(k(1) - k(2)) > 0.0_wp) return
         do j = 1, self%n
            q(1:2) = turned(others%axis, others%shift(1:2, j))*left(1:2)
            before = k(1)*q(1)**2 + k(2)*q(2)**2
            after = k(1)*self%shift(1, j)**2 + k(2)*self%shift(2, j)**2
            if (after > before) self%shift(1:2, j) = self%shift(1:2, j)*sqrt(before/after)
         end do
      end associate
   end subroutine take

   !> Components along the axes of a spot of a vector that has them along an axis and across it.
   pure function turned(axis, q)
      real(wp), intent(in) :: axis(2), q(2)
      real(wp) :: turned(2)

      turned = [axis(1)*q(1) - axis(2)*q(2), axis(2)*q(1) + axis(1)*q(2)]
   end function turned

   !> Have components along an axis and across it in the place of those along the axes of the spot.
   pure subroutine turn_to(self, axis)
      class(shells_type), intent(inout) :: self
      !> The axis, seen from those of the spot.
      real(wp), intent(in) :: axis(2)
      integer :: j

      do j = 1, self%n
         self%shift(1:2, j) = turned([axis(1), -axis(2)], self%shift(1:2, j))
         self%direction(1:2, j) = turned([axis(1), -axis(2)], self%direction(1:2, j))
      end do
      self%axis = axis
   end subroutine turn_to

   !> Bear what sliding gives.
   pure subroutine slide(self, spot, velocity, share)
      class(shells_type), intent(inout) :: self
      type(spring_spot_type), intent(in) :: spot
      !> Sliding velocity along the axes [m/s] and spin [rad/s].
      real(wp), intent(in) :: velocity(3)
      !> Share of that, the rest is as it was.
      real(wp), intent(in) :: share
      real(wp) :: u(3), force(3), stiffness(3), hessian(3, 3), size
      integer :: j

      u = velocity*[1.0_wp, 1.0_wp, spot%a]
      size = sqrt(dot_product(u, u))
      if (.not. size > 0.0_wp) return
      u = u/size
      do j = 1, self%n
         call take_share(self, j, stiffness)
         call sliding_force(spot%shape, self%within(j - 1), self%within(j), spot%rung, u, force, &
            hessian)
         force = force*spot%limit*[1.0_wp, 1.0_wp, spot%a]
         self%shift(:, j) = (1.0_wp - share)*self%shift(:, j) + share*force/max(stiffness, &
            tiny(stiffness))
         self%direction(:, j) = u
         self%slipped(j) = .true.
      end do
   end subroutine slide

   !> Share of the area whose shells have not slipped in the last step.
   pure real(wp) function stuck_share(self) result(share)
      class(shells_type), intent(in) :: self
      integer :: j

      share = 0.0_wp
      do j = 1, self%n
         if (.not. self%slipped(j)) share = share + self%edge(j)**2 - self%edge(j - 1)**2
      end do
      if (self%n > 0) share = min(share/self%edge(self%n)**2, 1.0_wp)
   end function stuck_share

   !> Write all to a checkpoint or read it back.
   subroutine exchange(self, checkpoint)
      class(shells_type), intent(inout) :: self
      type(checkpoint_type), intent(inout) :: checkpoint
      integer :: j

      call checkpoint%exchange("shells", self%n)
      call checkpoint%exchange("shells_a", self%a)
      call checkpoint%exchange("shells_stiffness", self%stiffness)
      call checkpoint%exchange("shells_axis", self%axis)
      call checkpoint%exchange("shells_edge", self%edge(0:self%n))
      do j = 1, self%n
         call checkpoint%exchange("shells_shift", self%shift(:, j))
         call checkpoint%exchange("shells_direction", self%direction(:, j))
      end do
      if (self%n == 0) return
      self%power(:self%n) = power_of(self%edge(:self%n))
      call set_within(self)
   end subroutine exchange

   !> Place x of a share of the shells: those at the rim, which slip first, are the narrowest. The
   !> error of the force by shift is then the same everywhere.
   elemental function place(share) result(x)
      !> From 0 to 1.
      real(wp), intent(in) :: share
      real(wp) :: x

      x = share**(2.0_wp/3.0_wp)
   end function place

   !> The inverse of `place`, in any unit.
   elemental function share_of(x) result(share)
      real(wp), intent(in) :: x
      real(wp) :: share

      share = x*sqrt(x)
   end function share_of

   !> Join the two neighbours that are the narrowest together; their forces are kept.
   pure subroutine merge_narrowest(self)
      class(shells_type), intent(inout) :: self
      real(wp) :: width, least, first(3), second(3), total(3)
      integer :: j, at

      if (self%n < 2) return
      at = 1
      least = huge(least)
      do j = 1, self%n - 1
         width = share_of(self%edge(j + 1)) - share_of(self%edge(j - 1))
         if (width < least) then
            least = width
            at = j
         end if
      end do
      call take_share(self, at, first)
      call take_share(self, at + 1, second)
      total = max(first + second, tiny(total))
      self%shift(:, at) = (first*self%shift(:, at) + second*self%shift(:, at + 1))/total
      do j = at + 1, self%n - 1
         self%shift(:, j) = self%shift(:, j + 1)
         self%direction(:, j) = self%direction(:, j + 1)
      end do
      do j = at, self%n - 1
         self%edge(j) = self%edge(j + 1)
         self%power(j) = self%power(j + 1)
         self%within(j) = self%within(j + 1)
      end do
      self%n = self%n - 1
   end subroutine merge_narrowest

   !> Divide the widest shell into two that hold what it held.
   pure subroutine split_widest(self)
      class(shells_type), intent(inout) :: self
      real(wp) :: width, most
      integer :: j, at

      at = 1
      most = -1.0_wp
      do j = 1, self%n
         width = share_of(self%edge(j)) - share_of(self%edge(j - 1))
         if (width > most) then
            most = width
            at = j
         end if
      end do
      do j = self%n, at, -1
         self%shift(:, j + 1) = self%shift(:, j)
         self%direction(:, j + 1) = self%direction(:, j)
         self%edge(j + 1) = self%edge(j)
         self%power(j + 1) = self%power(j)
         self%within(j + 1) = self%within(j)
      end do
      self%edge(at) = place(0.5_wp*(share_of(self%edge(at - 1)) + share_of(self%edge(at + 1))))
      self%power(at) = power_of(self%edge(at))
      self%within(at) = edge_at(self%edge(at)/self%a, power_of(self%edge(at)/self%a))
      self%n = self%n + 1
   end subroutine split_widest

end module contensou_contact_tangential_shells
