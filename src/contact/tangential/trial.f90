!> What all shells of a spot do in a step before any of them slips, side by side: what they remember
!> is turned and fades, their edges and stiffness become those of the spot, and they are moved.
!>
!> This file is compiled for each of the registers, see `contensou_contact_tangential_abreast`, so
!> that it uses little of the library. Loops go over full registers, behind the last shell as well.
module contensou_contact_tangential_trial
   use contensou_base_kinds, only : wp
   use contensou_contact_tangential_edges, only : look_within
   use contensou_contact_tangential_shell_data, only : block, shell_data_type
   implicit none(type, external)
   private

   public :: recall, stiffen, try_elastic

   !> What is divided by is not below this.
   real(wp), parameter :: least = 1.0e-300_wp

contains

   !> Be as other shells are, with components along the axes of a spot in the place of those along
   !> an axis, and some of the displacements let go.
   pure subroutine recall(self, others, axis, left, was)
      type(shell_data_type), intent(inout) :: self
      type(shell_data_type), intent(in) :: others
      !> The axis, seen from the axes of the spot, and what is left of displacements along and
      !> across it and about the normal, from 0 to 1.
      real(wp), intent(in) :: axis(2), left(3)
      !> The axis, seen from the axes along which the others have their stiffness; `axis` where
      !> nothing turns.
      real(wp), intent(in) :: was(2)

      call copy_edges(others%n, others%edge, others%power, others%load, others%size, &
         others%torsion, others%slipped, self%edge, self%power, self%load, self%size, &
         self%torsion, self%slipped)
      call turn_shells(others%n, ubound(others%shift, 1), axis, left, was, others%stiffness, &
         others%share, others%shift, others%uneven, others%direction, self%share, self%shift, &
         self%uneven, self%direction)
   end subroutine recall

   !> Copy what is known of edges, and which shells slipped.
   pure subroutine copy_edges(n, edge, power, load, size, torsion, slipped, new_edge, new_power, &
      new_load, new_size, new_torsion, new_slipped)
      integer, intent(in) :: n
      real(wp), intent(in), dimension(0:n + block) :: edge, power, load, size, torsion
      logical, intent(in) :: slipped(n + block)
      real(wp), intent(inout), dimension(0:n + block) :: new_edge, new_power, new_load, new_size, &
         new_torsion
      logical, intent(inout) :: new_slipped(n + block)
      integer :: first, j

      ! That of the centre is always zero.
      do first = 1, n, block
         do j = first, first + block - 1
            new_edge(j) = edge(j)
            new_power(j) = power(j)
            new_load(j) = load(j)
            new_size(j) = size(j)
            new_torsion(j) = torsion(j)
            new_slipped(j) = slipped(j)
         end do
      end do
   end subroutine copy_edges

   !> Copy stiffness, displacements and directions. Where the stiffness is not the same in all
   !> directions turning it over what is strained makes no energy.
   pure subroutine turn_shells(n, room, axis, left, was, stiffness, share, shift, uneven, &
      direction, new_share, new_shift, new_uneven, new_direction)
      !> Number of the shells, and of those for which there is room.
      integer, intent(in) :: n, room
      !> As for `recall`, and k_x, k_y of the spot.
      real(wp), intent(in) :: axis(2), left(3), was(2), stiffness(2)
      real(wp), intent(in), dimension(room, 3) :: share, shift, direction
      real(wp), intent(in) :: uneven(room)
      real(wp), intent(inout), dimension(room, 3) :: new_share, new_shift, new_direction
      real(wp), intent(inout) :: new_uneven(room)
      real(wp) :: x, y, new_x, new_y, before, after, part
      logical :: alike
      integer :: first, j

      alike = .not. (abs(stiffness(1) - stiffness(2)) > 0.0_wp .and. any(abs(axis - was) > 0.0_wp))
      do first = 1, n, block
         do j = first, first + block - 1
            new_share(j, 1) = share(j, 1)
            new_share(j, 2) = share(j, 2)
            new_share(j, 3) = share(j, 3)
            x = direction(j, 1)
            y = direction(j, 2)
            new_direction(j, 1) = axis(1)*x - axis(2)*y
            new_direction(j, 2) = axis(2)*x + axis(1)*y
            new_direction(j, 3) = direction(j, 3)
            x = shift(j, 1)*left(1)
            y = shift(j, 2)*left(2)
            new_shift(j, 1) = axis(1)*x - axis(2)*y
            new_shift(j, 2) = axis(2)*x + axis(1)*y
            new_shift(j, 3) = shift(j, 3)*left(3)
            new_uneven(j) = uneven(j)*(left(3)*left(3))
         end do
         if (alike) cycle
         do j = first, first + block - 1
            new_x = new_shift(j, 1)
            new_y = new_shift(j, 2)
            after = stiffness(1)*new_x*new_x + stiffness(2)*new_y*new_y
            x = shift(j, 1)*left(1)
            y = shift(j, 2)*left(2)
            new_x = was(1)*x - was(2)*y
            new_y = was(2)*x + was(1)*y
            before = stiffness(1)*new_x*new_x + stiffness(2)*new_y*new_y
            part = sqrt(min(before/max(after, least), 1.0_wp))
            new_shift(j, 1) = part*new_shift(j, 1)
            new_shift(j, 2) = part*new_shift(j, 2)
         end do
      end do
   end subroutine turn_shells

   !> Set what is within the edges of shells, and give these the stiffness that is theirs.
   pure subroutine stiffen(self)
      type(shell_data_type), intent(inout) :: self

      call set_edges(self%n, 1.0_wp/self%a, 1.0_wp/self%power(self%n), self%edge, self%power, &
         self%load, self%size, self%torsion)
      call stiffen_shells(self%n, ubound(self%shift, 1), self%stiffness, 1.0_wp/self%a, self%edge, &
         self%torsion, self%share, self%shift, self%uneven)
   end subroutine stiffen

   !> Set what is within edges.
   pure subroutine set_edges(n, inverse, per_power, edge, power, load, size, torsion)
      !> Number of the shells.
      integer, intent(in) :: n
      !> Inverse of the semi-axis [1/m], and of the power 2/3 of that.
      real(wp), intent(in) :: inverse, per_power
      !> Edges [m], from 0 on, and their powers.
      real(wp), intent(in), dimension(0:n + block) :: edge, power
      real(wp), intent(inout), dimension(0:n + block) :: load, size, torsion
      integer :: first, j

      do first = 1, n, block
         do j = first, first + block - 1
            call look_within(min(edge(j)*inverse, 1.0_wp), power(j)*per_power, load(j), size(j), &
               torsion(j))
         end do
      end do
      ! At the rim without rounding errors.
      load(n) = 1.0_wp
      size(n) = 1.0_wp
      torsion(n) = 1.0_wp
   end subroutine set_edges

   !> Give shells their stiffness: those that become stiffer keep their force, those that become
   !> softer their displacement. None of it makes energy.
   !>
   !> About the normal that of a shell is another one with another size of the spot. Where it has
   !> become stiffer its torque T is that of what was strained, with the energy T^2/(2 k) of the
   !> stiffness k of that, and stays until the shell is softer than that.
   pure subroutine stiffen_shells(n, room, stiffness, inverse, edge, torsion, share, shift, uneven)
      !> Number of the shells, and of those for which there is room.
      integer, intent(in) :: n, room
      !> k_x, k_y and k_T of the spot, and the inverse of its semi-axis [1/m].
      real(wp), intent(in) :: stiffness(3), inverse
      !> Edges [m], from 0 on, and the torsional stiffness within them.
      real(wp), intent(in), dimension(0:room) :: edge, torsion
      !> Stiffness and displacement.
      real(wp), intent(inout), dimension(room, 3) :: share, shift
      !> Energy of twist beyond that of an even one.
      real(wp), intent(inout) :: uneven(room)
      real(wp) :: now, before, flat, energy, strained, whole
      integer :: first, j

      do first = 1, n, block
         do j = first, first + block - 1
            now = stiffness(1)*((edge(j) - edge(j - 1))*inverse)
            ! A shell without stiffness bears nothing.
            before = max(share(j, 1), least)
            shift(j, 1) = shift(j, 1)*(before/max(now, before))
            share(j, 1) = now
            now = stiffness(2)*((edge(j) - edge(j - 1))*inverse)
            before = max(share(j, 2), least)
            shift(j, 2) = shift(j, 2)*(before/max(now, before))
            share(j, 2) = now
            ! Rounding errors are all there is where a shell is very narrow.
            now = stiffness(3)*max(torsion(j) - torsion(j - 1), 0.0_wp)
            before = max(share(j, 3), least)
            flat = 0.5_wp*before*shift(j, 3)*shift(j, 3)
            ! Not where it has been turned to the other side since.
            energy = flat + abs(uneven(j))*(0.5_wp + sign(0.5_wp, uneven(j)*shift(j, 3) - least))
            ! What is strained has flat/energy of the stiffness before.
            strained = flat*before
            whole = energy*now
            shift(j, 3) = shift(j, 3)*(energy*before/max(whole, strained, least))
            energy = max(energy - 0.5_wp*now*shift(j, 3)*shift(j, 3), 0.0_wp)
            uneven(j) = sign(energy*(0.5_wp + sign(0.5_wp, whole - strained)), shift(j, 3))
            share(j, 3) = now
         end do
      end do
   end subroutine stiffen_shells

   !> Elastic trials of shells, and by how much they are outside of what surely sticks. None has
   !> slipped in the step so far.
   pure subroutine try_elastic(self, new, step, limit, surely, arm)
      type(shell_data_type), intent(inout) :: self
      !> Number of the shells at the rim that are new.
      integer, intent(in) :: new
      !> Shift along the axes [m] and twist [rad].
      real(wp), intent(in) :: step(3)
      !> Limit of the spot [N] as far as the double cone of pure sliding and pure spinning is to be
      !> within it, and that of an ellipsoid; the torque of pure spinning over the limit [m].
      real(wp), intent(in) :: limit, surely, arm

      call begin_slips(self%n, ubound(self%shift, 1), self%slipped, self%slid, self%direction)
      call try_shells(self%n, ubound(self%shift, 1), new, step, self%turning, limit, surely, arm, &
         self%load, self%size, self%share, self%slid, self%shift, self%excess)
   end subroutine try_elastic

   !> No shell has slipped yet. Slip goes on inwards: there the direction is near that of the last
   !> shell that slips.
   pure subroutine begin_slips(n, room, slipped, slid, direction)
      !> Number of the shells, and of those for which there is room.
      integer, intent(in) :: n, room
      logical, intent(inout) :: slipped(room)
      real(wp), intent(inout) :: slid(room), direction(room, 3)
      integer :: first, j

      do first = 1, n, block
         do j = first, first + block - 1
            slid(j) = merge(1.0_wp, 0.0_wp, slipped(j))
         end do
      end do
      slipped(:n) = .false.
      do j = 1, n - 1
         if (slid(j + 1) - slid(j) > 0.5_wp) direction(j, :) = direction(j + 1, :)
      end do
   end subroutine begin_slips

   !> Elastic trials of shells.
   pure subroutine try_shells(n, room, new, step, turning, limit, surely, arm, load, size, share, &
      slid, shift, excess)
      !> Number of the shells, and of those for which there is room.
      integer, intent(in) :: n, room
      !> As for `try_elastic`.
      integer, intent(in) :: new
      real(wp), intent(in) :: step(3), turning(3), limit, surely, arm
      !> Load and size of what slips within the edges, from 0 on.
      real(wp), intent(in), dimension(0:room) :: load, size
      real(wp), intent(in) :: share(room, 3), slid(room)
      !> Elastic displacements.
      real(wp), intent(inout) :: shift(room, 3)
      !> Below zero where a shell surely sticks: its force is within the double cone or within the
      !> ellipsoid.
      real(wp), intent(inout) :: excess(room)
      real(wp) :: torque, bears, largest, spin, slide, part, per_new, outermost
      integer :: first, j

      per_new = 1.0_wp/max(real(new, wp), least)
      outermost = real(n, wp) + 0.5_wp
      do first = 1, n, block
         do j = first, first + block - 1
            ! Area that is new has come one by one.
            part = max(min((outermost - real(j, wp))*per_new, 1.0_wp), 0.0_wp)
            shift(j, 1) = shift(j, 1) + part*(step(1) + slid(j)*turning(1))
            shift(j, 2) = shift(j, 2) + part*(step(2) + slid(j)*turning(2))
            shift(j, 3) = shift(j, 3) + part*(step(3) + slid(j)*turning(3))
            bears = load(j) - load(j - 1)
            torque = arm*(load(j)*size(j) - load(j - 1)*size(j - 1))
            spin = abs(share(j, 3)*shift(j, 3))
            slide = (share(j, 1)*shift(j, 1))**2 + (share(j, 2)*shift(j, 2))**2
            largest = max((limit*torque - spin)*bears, 0.0_wp)
            slide = slide*torque*torque
            excess(j) = min(slide - largest*largest, &
               slide + bears*bears*(spin*spin - surely*surely*torque*torque))
         end do
      end do
   end subroutine try_shells

end module contensou_contact_tangential_trial
