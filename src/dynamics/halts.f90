!> Bodies that come to rest where they touch.
!>
!> A body that rocks on several contacts and sticks to them loses a share of its speed at each
!> touch, and the touches follow each other ever faster: infinitely many until it rests. As slow
!> rebounds do not open a contact, this ends at a velocity that counts as slow: contacts that hang
!> together with one that touches, and move by less, are stopped along the normal, and across it
!> those with friction that move by less there, by the impulses
!>
!>     G p = -u ,
!>
!> u the velocities at the contacts and G the inverse masses between them. So what touches begins
!> to stick without a force, where an impact at one contact would make it slide at another. What
!> was closed and sticks keeps its velocities across the normal, and with them friction: without
!> it the decision which contacts close would be that for another load, and bodies would lift off
!> and touch again for ever, as fast as friction builds up. With more contacts than the bodies need
!> G is singular; a small compliance makes it regular, and the same equations take what it leaves.
!> Rolling and pivoting go on.
module contensou_dynamics_halts
   use contensou_base_kinds, only : wp
   use contensou_contact_geometry, only : trouble_none
   use contensou_dynamics_equations, only : system_type
   use contensou_dynamics_impact, only : add_impulses, find_links, join, slow
   use contensou_dynamics_links, only : link_type
   use contensou_dynamics_mechanism, only : contact_type, relative_motion
   use contensou_dynamics_together, only : inverse_mass_between
   use contensou_special_elimination, only : solve_linear
   implicit none(type, external)
   private

   public :: halt_slow

   !> Compliance over the inverse mass at a contact.
   real(wp), parameter :: compliance = 1.0e-8_wp

   !> Times the equations are solved.
   integer, parameter :: most_turns = 10

   !> Share of the velocities that is none.
   real(wp), parameter :: stopped = 1.0e-12_wp

   !> Velocities at a contact: along the major and the minor axis of the spot, along the normal.
   integer, parameter :: directions(3) = [1, 2, 4]

contains

   !> Stop the slow contacts that hang together with one that touches, if some of them stick.
   subroutine halt_slow(system, t, y, candidate, rate, velocity_scale, index, trouble)
      !> The system; slow contacts are open on return if one of them touches.
      type(system_type), intent(inout) :: system
      !> Time [s].
      real(wp), intent(in) :: t
      !> State; velocities and works change.
      real(wp), intent(inout) :: y(:)
      !> Rigid contacts whose gaps are zero.
      logical, intent(in) :: candidate(:)
      !> Rates of the gaps [m/s].
      real(wp), intent(inout) :: rate(:)
      !> Velocity that the tolerance refers to [m/s].
      real(wp), intent(in) :: velocity_scale
      !> Contact in trouble; unchanged if none is.
      integer, intent(inout) :: index
      !> One of the `trouble_*` codes.
      integer, intent(out) :: trouble
      type(link_type), allocatable :: links(:)
      logical :: slow_ones(size(candidate)), touches(size(candidate)), joined(size(candidate))
      logical :: sticks(size(candidate)), was_closed(size(candidate))
      real(wp) :: limit
      integer :: i, k

      trouble = trouble_none
      limit = slow*velocity_scale
      slow_ones = candidate .and. abs(rate) <= limit
      ! What touches is open until now.
      touches = slow_ones .and. .not. system%contacts%closed .and. rate < 0.0_wp
      if (.not. any(touches) .or. count(slow_ones) < 2) return
      do i = 1, size(candidate)
         sticks(i) = rubs(system%contacts(i))
      end do
      was_closed = system%contacts%closed
      if (.not. any(sticks .and. slow_ones)) return
      call find_links(system, t, y, slow_ones, links, index, trouble)
      if (trouble /= trouble_none) return
      sticks = sticks .and. slow_ones
      do k = 1, size(links)
         associate (slides => links(k)%motion(1:2), number => links(k)%contact)
            sticks(number) = sticks(number) .and. norm2(slides) <= limit
         end associate
      end do
      do i = 1, size(candidate)
         if (.not. touches(i)) cycle
         call join(system, slow_ones, i, joined)
         touches = touches .and. .not. joined
         if (count(joined) > 1 .and. any(joined .and. sticks)) call stop_contacts(system, &
            pack(links, joined(links%contact)), sticks, was_closed, y)
      end do
      call system%gap_rates(y, rate)
   end subroutine halt_slow

   !> Whether a contact has friction that keeps nothing.
   pure logical function rubs(contact)
      type(contact_type), intent(in) :: contact

      rubs = allocated(contact%law%friction) .and. contact%states%n == 0
   end function rubs

   !> Impulses that take the velocities at contacts, or keep them.
   subroutine stop_contacts(system, links, sticks, was_closed, y)
      type(system_type), intent(inout) :: system
      !> Kinematics of the contacts.
      type(link_type), intent(in) :: links(:)
      !> For each contact of the system whether it is stopped across the normal, too.
      logical, intent(in) :: sticks(:)
      !> Whether it was closed: what sticks there goes on as it does.
      logical, intent(in) :: was_closed(:)
      !> State; velocities and works change.
      real(wp), intent(inout) :: y(:)
      real(wp) :: matrix(3*size(links), 3*size(links)), factor(3*size(links), 3*size(links))
      real(wp) :: right(3*size(links)), kept(3*size(links)), impulse(4, size(links))
      real(wp) :: mutual(4, 4), first
      integer :: i, j, k, n
      logical :: stops(3*size(links)), singular

      n = 3*size(links)
      do i = 1, size(links)
         do j = 1, size(links)
            mutual = 0.0_wp
            call inverse_mass_between(system%mechanism_type, links(i), links(j), mutual)
            matrix(3*i - 2:3*i, 3*j - 2:3*j) = mutual(directions, directions)
         end do
      end do
      stops = .true.
      do i = 1, size(links)
         stops(3*i - 2:3*i - 1) = sticks(links(i)%contact)
      end do
      do k = 1, n
         matrix(k, k) = matrix(k, k)*(1.0_wp + compliance)
         if (stops(k)) cycle
         matrix(k, :) = 0.0_wp
         matrix(:, k) = 0.0_wp
         matrix(k, k) = 1.0_wp
      end do
      call find_velocities(system, links, y, kept)
      do i = 1, size(links)
         if (.not. was_closed(links(i)%contact)) kept(3*i - 2:3*i - 1) = 0.0_wp
         kept(3*i) = 0.0_wp
      end do
      first = 0.0_wp
      do k = 1, most_turns
         call find_velocities(system, links, y, right)
         right = merge(right - kept, 0.0_wp, stops)
         first = max(first, norm2(right))
         if (norm2(right) <= stopped*first) exit
         factor = matrix
         right = -right
         call solve_linear(n, factor, right, singular)
         if (singular) exit
         impulse = 0.0_wp
         impulse(directions, :) = reshape(right, [3, size(links)])
         call add_impulses(system, links, impulse, huge(first), y)
      end do
   end subroutine stop_contacts

   !> Velocities at contacts.
   subroutine find_velocities(system, links, y, velocity)
      !> The system; its poses become those of the state.
      type(system_type), intent(inout) :: system
      !> Kinematics of the contacts.
      type(link_type), intent(in) :: links(:)
      real(wp), intent(in) :: y(:)
      !> Along the axes of the spot and the normal of each [m/s].
      real(wp), intent(out) :: velocity(:)
      real(wp) :: u(3), spin(3)
      integer :: i

      call system%set_poses(y)
      do i = 1, size(links)
         associate (link => links(i))
            call relative_motion(system%pose(link%body(1)), system%pose(link%body(2)), &
               link%at%point, u, spin)
            velocity(3*i - 2:3*i) = [dot_product(u, link%at%major), dot_product(u, link%minor), &
               dot_product(u, link%at%normal)]
         end associate
      end do
   end subroutine find_velocities

end module contensou_dynamics_halts
