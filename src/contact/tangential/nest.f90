!> The nested shells of a contact with tangential elasticity: which there are, what is within their
!> edges, and how these and what the shells remember change with the size of the spot, its axes and
!> the material that goes through it. What slips is the matter of
!> `contensou_contact_tangential_shells`.
module contensou_contact_tangential_nest
   use contensou_base_checkpoint, only : checkpoint_type
   use contensou_base_kinds, only : wp
   use contensou_contact_tangential_edges, only : edge_at, edge_type, power_beside, power_of
   use contensou_contact_tangential_registers, only : kernels_type, side_by_side
   use contensou_contact_tangential_shell_data, only : block, shell_data_type
   use contensou_contact_tangential_spot, only : spring_spot_type
   implicit none(type, external)
   private

   public :: nest_type, make_room

   !> Share of the shells, as an inverse, that a spot keeps at least while it shrinks.
   integer, parameter :: fewest = 10

   !> Difference of two widths that are the same, as those of new shells are: of these the inner one
   !> counts, not the one whose rounding errors happen to be the smaller ones.
   real(wp), parameter :: even = 1.0e-9_wp

   !> A spot that goes on being sheared and twisted has two shells for so many, but not fewer than
   !> that: more do not bring it closer to the exact theory, and each costs. Eight of 36 fill wide
   !> registers twice. What is not joined by twos at least is not even.
   integer, parameter :: joined_to_two = 9, least_coupled = 8

   !> Force and torque, over f N and f N a: both above the first couple, until one is below the
   !> second while the other is above the third.
   real(wp), parameter :: coupling = 1.0e-2_wp, gone = 1.0e-3_wp, alone = 0.1_wp

   !> Way of shift and twist, over those at which all slides, after which shells are joined, and the
   !> change of size with which it begins anew: an impact keeps its shells.
   real(wp), parameter :: long_way = 8.0_wp, other_size = 0.1_wp

   !> Shells of the area by which a spot has grown in a step, at most.
   integer, parameter :: most_new = 6

   !> The shells of a contact, and how they change.
   type, extends(shell_data_type) :: nest_type
      !> What goes by the registers of the machine.
      type(kernels_type) :: kernels
   contains
      procedure :: within
      procedure :: resize
      procedure :: clear
      procedure :: turn
      procedure :: energy
      procedure :: copy
      procedure :: take
      procedure :: turn_to
      procedure :: settle
      procedure :: foresee
      procedure :: stuck_share
      procedure :: exchange
   end type nest_type

contains

   !> Make room for shells, and for those by which a spot has grown.
   pure subroutine make_room(shells, number)
      class(nest_type), intent(inout) :: shells
      integer, intent(in) :: number
      integer :: n

      if (allocated(shells%edge)) deallocate(shells%edge, shells%power, shells%load, shells%size, &
         shells%torsion, shells%shift, shells%uneven, shells%direction, shells%slipped, &
         shells%slid, shells%share, shells%excess)
      shells%most = number
      shells%aim = number
      ! A step is also taken in two. And full registers, wherever they begin.
      n = number + 2*most_new + block
      shells%kernels = side_by_side()
      allocate(shells%edge(0:n), source=0.0_wp)
      allocate(shells%power(0:n), source=0.0_wp)
      allocate(shells%load(0:n), source=0.0_wp)
      allocate(shells%size(0:n), source=0.0_wp)
      allocate(shells%torsion(0:n), source=0.0_wp)
      allocate(shells%shift(n, 3), source=0.0_wp)
      allocate(shells%uneven(n), source=0.0_wp)
      allocate(shells%direction(n, 3), source=0.0_wp)
      allocate(shells%slipped(n), source=.false.)
      allocate(shells%slid(n), source=0.0_wp)
      allocate(shells%share(n, 3), source=0.0_wp)
      allocate(shells%excess(n), source=0.0_wp)
   end subroutine make_room

   !> Forget all.
   pure subroutine clear(self)
      class(nest_type), intent(inout) :: self

      self%n = 0
      self%aim = self%most
      self%way = 0.0_wp
      self%size_of_way = 0.0_wp
      self%a = 0.0_wp
      self%stiffness = 0.0_wp
      self%new = most_new
      self%went = 0.0_wp
      if (allocated(self%direction)) self%direction = 0.0_wp
   end subroutine clear

   !> Name the axes anew where the major and the minor axis change their places: what is remembered
   !> is turned by a right angle, forth or back, with the stiffness against which it is strained.
   pure subroutine turn(self, forth)
      class(nest_type), intent(inout) :: self
      !> Whether the new x axis is the old y axis, else the new y axis is the old x axis.
      logical, intent(in) :: forth
      real(wp) :: sense, x
      integer :: j

      sense = merge(1.0_wp, -1.0_wp, forth)
      do j = 1, self%n
         x = self%shift(j, 1)
         self%shift(j, 1) = sense*self%shift(j, 2)
         self%shift(j, 2) = -sense*x
         self%share(j, 1:2) = self%share(j, [2, 1])
      end do
      self%stiffness(1:2) = self%stiffness([2, 1])
      self%direction = 0.0_wp
      self%went = 0.0_wp
   end subroutine turn

   !> Elastic energy [J].
   pure function energy(self) result(stored)
      class(nest_type), intent(in) :: self
      real(wp) :: stored
      integer :: j

      stored = 0.0_wp
      do j = 1, self%n
         stored = stored + (self%share(j, 1)*self%shift(j, 1)**2 &
            + self%share(j, 2)*self%shift(j, 2)**2 + self%share(j, 3)*self%shift(j, 3)**2 &
            + 2.0_wp*abs(self%uneven(j)))
      end do
      stored = 0.5_wp*stored
   end function energy

   !> What is within the outer edge of a shell; of none, at the centre, nothing.
   pure type(edge_type) function within(self, j)
      class(nest_type), intent(in) :: self
      !> The shell, or 0.
      integer, intent(in) :: j

      within = edge_type(self%load(j), self%size(j), self%torsion(j))
   end function within

   !> Set what is within the outer edge of a shell.
   pure subroutine set_edge(self, j, within)
      class(nest_type), intent(inout) :: self
      integer, intent(in) :: j
      type(edge_type), intent(in) :: within

      self%load(j) = within%load
      self%size(j) = within%size
      self%torsion(j) = within%torsion
   end subroutine set_edge

   !> Stiffness of a shell: its share of that of the whole spot.
   pure subroutine share_of_shell(self, j, stiffness)
      class(nest_type), intent(in) :: self
      !> The shell.
      integer, intent(in) :: j
      real(wp), intent(out) :: stiffness(3)

      stiffness(1:2) = self%stiffness(1:2)*((self%edge(j) - self%edge(j - 1))/self%a)
      ! Rounding errors are all there is where a shell is very narrow.
      stiffness(3) = self%stiffness(3)*max(self%torsion(j) - self%torsion(j - 1), 0.0_wp)
   end subroutine share_of_shell

   !> Bring the shells to the size and stiffness of a spot: new area is not strained, lost area lets
   !> go what it held, and shells that become stiffer keep their force. None of it makes energy.
   pure subroutine resize(self, spot, lost, settled, new)
      class(nest_type), intent(inout) :: self
      type(spring_spot_type), intent(in) :: spot
      !> Energy that is let go [J].
      real(wp), intent(out), optional :: lost
      !> Whether the number of shells is kept, unless that is left to `settle`.
      logical, intent(in), optional :: settled
      !> Number of those at the rim that are new, if they are left to `settle`.
      integer, intent(out), optional :: new
      type(edge_type) :: rim
      real(wp) :: before, now(3), whole(3), power
      logical :: settles
      integer :: j, grown

      settles = .true.
      if (present(settled)) settles = settled
      if (present(new)) new = 0
      if (present(lost)) lost = 0.0_wp
      if (.not. spot%a > 0.0_wp) then
         if (present(lost)) lost = self%energy()
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
         self%share(:self%n, :) = 0.0_wp
         self%shift(:self%n, :) = 0.0_wp
         self%uneven(:self%n) = 0.0_wp
         call self%kernels%stiffen(self%shell_data_type)
         self%slipped(:self%n) = .false.
         return
      end if
      ! As it was: bits that agree.
      if (abs(spot%a - self%a) <= 0.0_wp .and. &
         all(abs(spot%stiffness - self%stiffness) <= 0.0_wp)) then
         if (.not. settles) return
         call set_aim(self, spot)
         do while (self%n < self%aim)
            call split_widest(self)
         end do
         if (self%n == self%aim) return
         if (present(lost)) before = self%energy()
         call self%settle(spot)
         if (present(lost)) lost = max(before - self%energy(), 0.0_wp)
         return
      end if
      if (present(lost)) before = self%energy()
      if (spot%a < self%a) then
         power = power_beside(spot%a, self%edge(self%n), self%power(self%n))
         rim = edge_at(spot%a/self%a, power/self%power(self%n))
         do while (self%n > 1 .and. self%edge(self%n - 1) >= spot%a)
            self%n = self%n - 1
         end do
         whole = self%share(self%n, :)
         self%edge(self%n) = spot%a
         self%power(self%n) = power
         self%torsion(self%n) = rim%torsion
         call share_of_shell(self, self%n, now)
         ! At a rim that slips the area that is lost bears nothing at last. Else its twist is the
         ! matter of `stiffen`, as that of all shells that become softer.
         if (self%slipped(self%n) .and. minval(now) > 0.0_wp) then
            self%shift(self%n, :) = self%shift(self%n, :)*sqrt(whole/now)
            self%share(self%n, 3) = now(3)
         end if
         self%share(self%n, 1:2) = now(1:2)
      end if
      if (spot%a > self%a) then
         grown = merge(1, self%new, settles)
         if (present(new) .and. .not. settles) new = grown
         do j = 1, grown
            self%n = self%n + 1
            self%edge(self%n) = self%a + (spot%a - self%a)*(real(j, wp)/real(grown, wp))
            if (j == grown) self%edge(self%n) = spot%a
            self%power(self%n) = power_beside(self%edge(self%n), self%edge(self%n - 1), &
               self%power(self%n - 1))
            self%shift(self%n, :) = 0.0_wp
            self%uneven(self%n) = 0.0_wp
            self%direction(self%n, :) = 0.0_wp
            self%slipped(self%n) = .false.
            self%share(self%n, :) = 0.0_wp
         end do
      end if
      self%a = spot%a
      self%stiffness = spot%stiffness
      call self%kernels%stiffen(self%shell_data_type)
      if (settles) call self%settle(spot)
      if (present(lost)) lost = max(before - self%energy(), 0.0_wp)
   end subroutine resize

   !> Merge or divide shells so that their number is the one aimed at.
   pure subroutine settle(self, spot)
      class(nest_type), intent(inout) :: self
      type(spring_spot_type), intent(in) :: spot

      if (self%n == 0) return
      call set_aim(self, spot)
      if (self%n >= 2*self%aim) call join(self)
      do while (self%n > self%aim)
         call merge_narrowest(self)
      end do
      ! The halves of a shell that slides are not both at their limits: as late as will do.
      do while (fewest*self%n < self%most)
         call split_widest(self)
      end do
   end subroutine settle

   !> Aim at fewer shells where the spot is both sheared and twisted, by the exact wrench, and has
   !> long been moved with about the same size.
   pure subroutine set_aim(self, spot)
      class(nest_type), intent(inout) :: self
      type(spring_spot_type), intent(in) :: spot
      real(wp) :: sheared, twisted, unit
      integer :: j

      if (associated(spot%rung)) return
      if (abs(self%a - self%size_of_way) > other_size*self%size_of_way) then
         self%way = 0.0_wp
         self%size_of_way = self%a
         self%aim = self%most
      end if
      if (self%way < long_way) return
      ! Squares of what the spot would bear as a whole with these energies.
      sheared = 0.0_wp
      twisted = 0.0_wp
      do j = 1, self%n
         sheared = sheared + (self%share(j, 1)*self%shift(j, 1)**2 &
            + self%share(j, 2)*self%shift(j, 2)**2)
         twisted = twisted + self%share(j, 3)*self%shift(j, 3)**2
      end do
      sheared = sheared*self%stiffness(1)
      twisted = twisted*self%stiffness(3)/self%a**2
      unit = spot%limit**2
      if (min(sheared, twisted) > coupling**2*unit) then
         self%aim = self%most
         if (self%most >= 2*least_coupled) self%aim = max(2*self%most/joined_to_two, least_coupled)
      else if (min(sheared, twisted) < gone**2*unit .and. max(sheared, twisted) &
         > alone**2*unit) then
         self%aim = self%most
      end if
   end subroutine set_aim

   !> Be as others are.
   pure subroutine copy(self, others)
      class(nest_type), intent(inout) :: self
      class(nest_type), intent(in) :: others

      call copy_nest(self, others, [1.0_wp, 0.0_wp], [1.0_wp, 1.0_wp, 1.0_wp], [1.0_wp, 0.0_wp])
      self%axis = others%axis
   end subroutine copy

   !> Be as others are, with components along the axes of a spot in the place of those along an
   !> axis, and some of the displacements let go.
   pure subroutine take(self, others, axis, left)
      class(nest_type), intent(inout) :: self
      class(nest_type), intent(in) :: others
      !> The axis, seen from those of the spot.
      real(wp), intent(in) :: axis(2)
      !> What is left of the displacements along the axes and about the normal, from 0 to 1.
      real(wp), intent(in) :: left(3)

      call copy_nest(self, others, axis, left, others%axis)
   end subroutine take

   !> Be as others are, with displacements and directions as they are recalled.
   pure subroutine copy_nest(self, others, axis, left, was)
      class(nest_type), intent(inout) :: self
      class(nest_type), intent(in) :: others
      !> As for `take`.
      real(wp), intent(in) :: axis(2), left(3)
      !> The axis that others have, unless it stays.
      real(wp), intent(in) :: was(2)

      self%n = others%n
      self%aim = others%aim
      self%way = others%way
      self%size_of_way = others%size_of_way
      self%a = others%a
      self%new = others%new
      self%stiffness = others%stiffness
      self%fading = 1.0_wp
      self%turning = 0.0_wp
      self%axis = [1.0_wp, 0.0_wp]
      self%went = [turned(axis, others%went(1:2)), others%went(3)]
      if (self%n > 0) call self%kernels%recall(self%shell_data_type, others%shell_data_type, axis, &
         left, was)
   end subroutine copy_nest

   !> Components along the axes of a spot of a vector that has them along an axis and across it.
   pure function turned(axis, q)
      real(wp), intent(in) :: axis(2), q(2)
      real(wp) :: turned(2)

      turned = [axis(1)*q(1) - axis(2)*q(2), axis(2)*q(1) + axis(1)*q(2)]
   end function turned

   !> Have components along an axis and across it in the place of those along the axes of the spot.
   pure subroutine turn_to(self, axis)
      class(nest_type), intent(inout) :: self
      !> The axis, seen from those of the spot.
      real(wp), intent(in) :: axis(2)
      integer :: j

      do j = 1, self%n
         self%shift(j, 1:2) = turned([axis(1), -axis(2)], self%shift(j, 1:2))
         self%direction(j, 1:2) = turned([axis(1), -axis(2)], self%direction(j, 1:2))
      end do
      self%went(1:2) = turned([axis(1), -axis(2)], self%went(1:2))
      self%axis = axis
   end subroutine turn_to

   !> Share of the area whose shells have not slipped in the last step.
   pure real(wp) function stuck_share(self) result(share)
      class(nest_type), intent(in) :: self
      integer :: j

      share = 0.0_wp
      do j = 1, self%n
         if (.not. self%slipped(j)) share = share + self%edge(j)**2 - self%edge(j - 1)**2
      end do
      if (self%n > 0) share = min(share/self%edge(self%n)**2, 1.0_wp)
   end function stuck_share

   !> Write all to a checkpoint or read it back.
   subroutine exchange(self, checkpoint)
      class(nest_type), intent(inout) :: self
      type(checkpoint_type), intent(inout) :: checkpoint
      real(wp) :: within(3)
      integer :: j

      call checkpoint%exchange("shells", self%n)
      call checkpoint%exchange("shells_aim", self%aim)
      call checkpoint%exchange("shells_way", self%way)
      call checkpoint%exchange("shells_size_of_way", self%size_of_way)
      call checkpoint%exchange("shells_new", self%new)
      call checkpoint%exchange("shells_a", self%a)
      call checkpoint%exchange("shells_stiffness", self%stiffness)
      call checkpoint%exchange("shells_axis", self%axis)
      call checkpoint%exchange("shells_went", self%went)
      call checkpoint%exchange("shells_slipped", self%slipped(:self%n))
      ! All, as what follows from the edges had its rounding errors when these were set.
      do j = 0, self%n
         call checkpoint%exchange("shells_edge", self%edge(j:j))
         call checkpoint%exchange("shells_power", self%power(j:j))
         within = [self%load(j), self%size(j), self%torsion(j)]
         call checkpoint%exchange("shells_within", within)
         call set_edge(self, j, edge_type(within(1), within(2), within(3)))
         if (j == 0) cycle
         call checkpoint%exchange("shells_shift", self%shift(j, :))
         call checkpoint%exchange("shells_uneven", self%uneven(j:j))
         call checkpoint%exchange("shells_direction", self%direction(j, :))
         call checkpoint%exchange("shells_share", self%share(j, :))
      end do
   end subroutine exchange

   !> Foresee by how much the spot may grow in the next step: as it changed in the last one.
   pure subroutine foresee(self, change)
      class(nest_type), intent(inout) :: self
      !> Change of the major semi-axis [m].
      real(wp), intent(in) :: change

      self%new = most_new
      if (self%n == 0) return
      ! In widths of a shell at the rim of a spot whose shells are all new.
      self%new = min(1 + int(min(1.5_wp*self%aim*abs(change)/self%a, real(most_new, wp))), &
         most_new)
   end subroutine foresee

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
      class(nest_type), intent(inout) :: self
      real(wp) :: width, least
      integer :: j, at

      if (self%n < 2) return
      at = 1
      least = huge(least)
      do j = 1, self%n - 1
         width = share_of(self%edge(j + 1)) - share_of(self%edge(j - 1))
         if (width < (1.0_wp - even)*least) then
            least = width
            at = j
         end if
      end do
      call merge_at(self, at)
   end subroutine merge_narrowest

   !> Merge many shells to as many as are aimed at: of their edges those stay that divide the spot
   !> the most evenly.
   pure subroutine join(self)
      class(nest_type), intent(inout) :: self
      real(wp) :: off, least, width
      logical :: stays(self%n)
      integer :: i, j, at

      width = share_of(self%edge(self%n))/real(self%aim, wp)
      stays = .false.
      do i = 1, self%aim - 1
         least = huge(least)
         at = 1
         do j = 1, self%n - 1
            off = abs(share_of(self%edge(j)) - real(i, wp)*width)
            ! Of two as far away the inner one, whatever rounding says.
            if (off < least - even*width) then
               least = off
               at = j
            end if
         end do
         stays(at) = .true.
      end do
      do j = self%n - 1, 1, -1
         if (.not. stays(j)) call merge_at(self, j)
      end do
   end subroutine join

   !> Merge a shell with the one outside of it. Of twist the energy is kept as well.
   pure subroutine merge_at(self, at)
      class(nest_type), intent(inout) :: self
      integer, intent(in) :: at
      real(wp) :: total(3), uneven
      integer :: j

      total = max(self%share(at, :) + self%share(at + 1, :), tiny(total))
      uneven = abs(self%uneven(at)) + abs(self%uneven(at + 1)) + 0.5_wp*self%share(at, 3) &
         *(self%share(at + 1, 3)/total(3))*(self%shift(at, 3) - self%shift(at + 1, 3))**2
      self%shift(at, :) = (self%share(at, :)*self%shift(at, :) &
         + self%share(at + 1, :)*self%shift(at + 1, :))/total
      self%uneven(at) = sign(uneven, self%shift(at, 3))
      self%slipped(at) = self%slipped(at) .and. self%slipped(at + 1)
      do j = at + 1, self%n - 1
         self%shift(j, :) = self%shift(j + 1, :)
         self%uneven(j) = self%uneven(j + 1)
         self%direction(j, :) = self%direction(j + 1, :)
         self%slipped(j) = self%slipped(j + 1)
         self%share(j, :) = self%share(j + 1, :)
      end do
      do j = at, self%n - 1
         self%edge(j) = self%edge(j + 1)
         self%power(j) = self%power(j + 1)
         call set_edge(self, j, self%within(j + 1))
      end do
      self%n = self%n - 1
      call share_of_shell(self, at, total)
      self%share(at, :) = total
   end subroutine merge_at

   !> Divide the widest shell into two that hold what it held.
   pure subroutine split_widest(self)
      class(nest_type), intent(inout) :: self
      real(wp) :: width, most, share(3)
      integer :: j, at

      at = 1
      most = -1.0_wp
      do j = 1, self%n
         width = share_of(self%edge(j)) - share_of(self%edge(j - 1))
         if (width > (1.0_wp + even)*most) then
            most = width
            at = j
         end if
      end do
      do j = self%n, at, -1
         self%shift(j + 1, :) = self%shift(j, :)
         self%uneven(j + 1) = self%uneven(j)
         self%direction(j + 1, :) = self%direction(j, :)
         self%slipped(j + 1) = self%slipped(j)
         self%share(j + 1, :) = self%share(j, :)
         self%edge(j + 1) = self%edge(j)
         self%power(j + 1) = self%power(j)
         call set_edge(self, j + 1, self%within(j))
      end do
      self%edge(at) = place(0.5_wp*(share_of(self%edge(at - 1)) + share_of(self%edge(at + 1))))
      self%power(at) = power_of(self%edge(at))
      call set_edge(self, at, edge_at(self%edge(at)/self%a, power_of(self%edge(at)/self%a)))
      self%n = self%n + 1
      do j = at, at + 1
         call share_of_shell(self, j, share)
         self%share(j, :) = share
      end do
      self%uneven(at:at + 1) = self%uneven(at)*self%share(at:at + 1, 3) &
         /max(sum(self%share(at:at + 1, 3)), tiny(share))
   end subroutine split_widest

end module contensou_contact_tangential_nest
