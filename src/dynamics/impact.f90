!> Impacts of rigid contacts.
!>
!> An impact is instantaneous and at one contact; several that touch at once are taken one after
!> the other, the fastest approach first, until none approaches, or by choice at once (module
!> `contensou_dynamics_together`). With friction `routh` integrates the impulses of one. E. J.
!> Routh, Dynamics of a System of Rigid Bodies (1905); J. B. Keller, J. Appl. Mech. 53 (1986) 1. The
!> spot has the mean size of that of Hertz's impact, sqrt(d) weighted with the force: 0.8955 of the
!> largest one. Compression ends where the approach does; restitution where it has given back e^2 of
!> the work of compression (W. J. Stronge, Proc. R. Soc. A 431 (1990) 169), so that no impact gains
!> energy. Without a coupling of friction and normal velocity the rebound is e times the approach.
module contensou_dynamics_impact
   use contensou_base_kinds, only : wp
   use contensou_base_vectors, only : cross
   use contensou_contact_damping_coefficient, only : hunt_crossley_restitution
   use contensou_contact_geometry, only : trouble_endless, trouble_none
   use contensou_dynamics_equations, only : system_type
   use contensou_dynamics_links, only : find_link, link_type, response
   use contensou_dynamics_mechanism, only : contact_type
   use contensou_dynamics_reports, only : energies
   use contensou_dynamics_routh, only : impact_type, integrate_impact
   use contensou_dynamics_scene, only : motion_free, motion_prescribed
   use contensou_dynamics_state, only : add_to_motion
   use contensou_dynamics_together, only : inverse_mass_between, together_type
   implicit none(type, external)
   private

   public :: resolve_impacts, stop_closed_gaps, find_links, find_pressing_acceleration, &
      slowest_rebound, join, add_impulses, rest, slow, slow_rate

   !> Impacts at one instant after which a scene is given up.
   integer, parameter :: most_impacts = 10000

   !> Turns in which several contacts are brought to rest.
   integer, parameter :: most_turns = 1000

   !> Share of `velocity_scale` below which a rebound closes the contact.
   real(wp), parameter :: slow = 1.0e-3_wp

   !> Share of that which counts as rest.
   real(wp), parameter :: rest = 1.0e-3_wp

   !> Rate of a gap that counts as rest, over `velocity_scale`.
   real(wp), parameter :: slow_rate = rest*slow

contains

   !> Coefficient of restitution of a rigid contact at a speed.
   pure function restitution_at(contact, speed) result(e)
      type(contact_type), intent(in) :: contact
      !> Speed of approach [m/s], >= 0.
      real(wp), intent(in) :: speed
      real(wp) :: e

      e = contact%restitution
      if (contact%restitution_slope > 0.0_wp) then
         e = hunt_crossley_restitution(1.5_wp*contact%restitution_slope*speed)
      end if
   end function restitution_at

   !> Impacts of contacts that touch, until none approaches: one after the other, or those of bodies
   !> that hang together at once.
   subroutine resolve_impacts(system, t, y, candidate, carried, velocity_scale, rate, index, &
      trouble)
      type(system_type), intent(inout) :: system
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(inout) :: y(:)
      !> Rigid contacts whose gaps are zero.
      logical, intent(in) :: candidate(:)
      !> Accelerations that press them together while others are closed [m/s2].
      real(wp), intent(in) :: carried(:)
      !> Velocity that the tolerance refers to [m/s].
      real(wp), intent(in) :: velocity_scale
      !> Rates of the gaps after the impacts [m/s].
      real(wp), intent(out) :: rate(:)
      !> Contact in trouble; unchanged if none is.
      integer, intent(inout) :: index
      !> One of the `trouble_*` codes.
      integer, intent(out) :: trouble
      type(link_type) :: link
      real(wp) :: y_rate(size(y)), press, slowest, e
      logical :: joined(size(candidate))
      integer :: i, k

      trouble = trouble_none
      do k = 1, most_impacts
         call system%gap_rates(y, rate)
         i = minloc(rate, dim=1, mask=candidate)
         if (rate(i) >= -slow_rate*velocity_scale) return
         where (candidate) system%contacts%closed = .false.
         if (system%together) then
            call join(system, candidate, i, joined)
            if (count(joined) > 1) then
               call take_impacts(system, t, y, joined, carried, velocity_scale, index, trouble)
               if (trouble /= trouble_none) return
               cycle
            end if
         end if
         call find_pressing_acceleration(system, t, y, i, y_rate, link, press, trouble)
         if (trouble /= trouble_none) exit
         press = max(press, carried(i))
         slowest = slowest_rebound(system%contacts(i), link, press, velocity_scale)
         e = restitution_at(system%contacts(i), -rate(i))
         ! Where nothing presses the bodies together, the slowest rebound is one.
         if (press > 0.0_wp .and. -e*rate(i) < slowest) e = 0.0_wp
         call take_impact(system, y, i, link, e, trouble)
         if (trouble /= trouble_none) exit
      end do
      if (trouble == trouble_none) trouble = trouble_endless
      index = i
   end subroutine resolve_impacts

   !> Contacts that an impact at one of them reaches through the bodies that yield.
   subroutine join(system, candidate, first, joined)
      type(system_type), intent(in) :: system
      !> Rigid contacts whose gaps are zero.
      logical, intent(in) :: candidate(:)
      !> Where the impact is.
      integer, intent(in) :: first
      !> Those that it reaches, itself included.
      logical, intent(out) :: joined(:)
      logical :: moved(0:size(system%bodies)), more
      integer :: i

      joined = .false.
      joined(first) = .true.
      moved = .false.
      do
         more = .false.
         do i = 1, size(candidate)
            if (.not. candidate(i)) cycle
            associate (contact => system%contacts(i))
               if (.not. joined(i)) then
                  joined(i) = moved(contact%a) .or. moved(contact%b)
                  if (.not. joined(i)) cycle
               end if
               call move(contact%a)
               call move(contact%b)
            end associate
         end do
         if (.not. more) return
      end do

   contains

      !> A body yields to an impulse.
      subroutine move(body)
         !> Its index; 0 for the ground.
         integer, intent(in) :: body

         if (body == 0) return
         if (moved(body) .or. system%bodies(body)%motion /= motion_free) return
         moved(body) = .true.
         more = .true.
      end subroutine move

   end subroutine join

   !> Impacts of several contacts at once.
   subroutine take_impacts(system, t, y, joined, carried, velocity_scale, index, trouble)
      type(system_type), intent(inout) :: system
      !> Time [s].
      real(wp), intent(in) :: t
      !> State; velocities and works change.
      real(wp), intent(inout) :: y(:)
      !> These contacts.
      logical, intent(in) :: joined(:)
      !> Accelerations that press them together while others are closed [m/s2].
      real(wp), intent(in) :: carried(:)
      !> Velocity that the tolerance refers to [m/s].
      real(wp), intent(in) :: velocity_scale
      !> Contact in trouble; unchanged if none is.
      integer, intent(inout) :: index
      !> One of the `trouble_*` codes.
      integer, intent(out) :: trouble
      type(link_type), allocatable :: links(:)
      type(together_type) :: impact
      real(wp) :: e(count(joined)), press, rubbed
      integer :: i

      call find_links(system, t, y, joined, links, index, trouble)
      if (trouble /= trouble_none) return
      call impact%begin(system%mechanism_type, links, system%resolution%tolerance)
      call impact%compress(system%contacts, links, trouble)
      if (trouble == trouble_none) then
         do i = 1, size(links)
            associate (contact => system%contacts(links(i)%contact), &
               speed => impact%effective_speed(i))
               e(i) = restitution_at(contact, speed)
               press = max(-links(i)%free, carried(links(i)%contact))
               ! As with one contact: what would not open it is no rebound.
               if (press > 0.0_wp .and. e(i)*speed < slowest_rebound(contact, links(i), press, &
                  velocity_scale)) e(i) = 0.0_wp
            end associate
         end do
         call impact%expand(system%contacts, links, e, trouble)
      end if
      if (trouble /= trouble_none) then
         index = links(minloc(links%rate, dim=1))%contact
         return
      end if
      rubbed = impact%friction_loss()
      call add_impulses(system, links, impact%compression + impact%expansion, rubbed, y)
   end subroutine take_impacts

   !> Give bodies the impulses of contacts, and the works what they take.
   subroutine add_impulses(system, links, impulse, rubbed, y)
      type(system_type), intent(in) :: system
      !> Kinematics of the contacts.
      type(link_type), intent(in) :: links(:)
      !> Impulses along major and minor axis, about and along the normal [N s, N m s].
      real(wp), intent(in) :: impulse(:, :)
      !> Energy that friction takes at most [J].
      real(wp), intent(in) :: rubbed
      !> State; velocities and works change.
      real(wp), intent(inout) :: y(:)
      real(wp) :: kinetic(2), potential, supplied, loss, friction
      integer :: i, j

      call energies(system, y, kinetic(1), potential)
      supplied = 0.0_wp
      do i = 1, size(links)
         do j = 1, 2
            if (links(i)%body(j) > 0) call apply_impulse(system, links(i), impulse(:, i), j, y, &
               supplied)
         end do
      end do
      call energies(system, y, kinetic(2), potential)
      associate (layout => system%layout)
         loss = kinetic(1) - kinetic(2) + supplied
         friction = 0.0_wp
         if (layout%friction > 0) then
            friction = max(min(rubbed, loss), 0.0_wp)
            y(layout%friction) = y(layout%friction) + friction
         end if
         y(layout%damping) = y(layout%damping) + loss - friction
         if (layout%applied > 0) y(layout%applied) = y(layout%applied) + supplied
      end associate
   end subroutine add_impulses

   !> Acceleration by which a contact is pressed together while no candidate is closed [m/s2].
   subroutine find_pressing_acceleration(system, t, y, index, y_rate, link, press, trouble)
      !> The system; no candidate is closed.
      type(system_type), intent(inout) :: system
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)
      integer, intent(in) :: index
      !> Room for a right-hand side.
      real(wp), intent(out) :: y_rate(:)
      !> Kinematics of the contact.
      type(link_type), intent(inout) :: link
      !> The acceleration.
      real(wp), intent(out) :: press
      !> One of the `trouble_*` codes.
      integer, intent(out) :: trouble

      press = 0.0_wp
      call system%derivative(t, y, y_rate)
      trouble = system%trouble_code
      if (system%outside) return
      call find_link(system%mechanism_type, index, y_rate, link, trouble)
      press = -link%free
   end subroutine find_pressing_acceleration

   !> Slowest rebound [m/s]: the flight that follows a slower one is lower than the overlap that
   !> the elastic bodies have at rest, and would not open the contact.
   pure function slowest_rebound(contact, link, press, velocity_scale) result(speed)
      type(contact_type), intent(in) :: contact
      type(link_type), intent(in) :: link
      !> Acceleration that presses the bodies together [m/s2].
      real(wp), intent(in) :: press
      !> Velocity that the tolerance refers to [m/s].
      real(wp), intent(in) :: velocity_scale
      real(wp) :: speed
      real(wp) :: unit(6)

      speed = slow*velocity_scale
      if (press <= 0.0_wp) return
      unit = 0.0_wp
      unit(1:3) = link%at%normal
      speed = max(speed, sqrt(2.0_wp*press*contact%law%normal%approach( &
         press/response(link, link, unit))))
   end function slowest_rebound

   !> Kinematics of contacts while none of them is closed.
   subroutine find_links(system, t, y, chosen, links, index, trouble)
      !> The system; the contacts are open on return.
      type(system_type), intent(inout) :: system
      !> Time [s].
      real(wp), intent(in) :: t
      !> State.
      real(wp), intent(in) :: y(:)
      !> Which contacts.
      logical, intent(in) :: chosen(:)
      !> These.
      type(link_type), allocatable, intent(inout) :: links(:)
      !> Contact in trouble; unchanged if none is.
      integer, intent(inout) :: index
      !> One of the `trouble_*` codes.
      integer, intent(out) :: trouble
      real(wp) :: y_rate(size(y))
      integer :: i, k

      trouble = trouble_none
      if (allocated(links)) deallocate(links)
      allocate(links(count(chosen)))
      where (chosen) system%contacts%closed = .false.
      if (.not. any(chosen)) return
      call system%derivative(t, y, y_rate)
      if (system%outside) then
         index = system%trouble
         trouble = system%trouble_code
         return
      end if
      k = 0
      do i = 1, size(chosen)
         if (.not. chosen(i)) cycle
         k = k + 1
         call find_link(system%mechanism_type, i, y_rate, links(k), trouble)
         if (trouble /= trouble_none) then
            index = i
            return
         end if
      end do
   end subroutine find_links

   !> Take what is left of the rates of the closed gaps after impacts in turn.
   subroutine stop_closed_gaps(system, y, links, active, limit)
      !> The system at the poses of the state.
      type(system_type), intent(inout) :: system
      !> State; velocities and the work of damping change a little.
      real(wp), intent(inout) :: y(:)
      !> Kinematics of contacts.
      type(link_type), intent(in) :: links(:)
      !> Those whose gaps are to stop.
      logical, intent(in) :: active(:)
      !> Rate that is none [m/s].
      real(wp), intent(in) :: limit
      type(impact_type) :: impact
      real(wp) :: rate(size(system%contacts)), kinetic(2), potential, supplied
      integer :: i, j, k

      if (.not. any(active)) return
      call energies(system, y, kinetic(1), potential)
      supplied = 0.0_wp
      call system%gap_rates(y, rate)
      do k = 1, most_turns
         do i = 1, size(links)
            if (.not. active(links(i)%contact)) cycle
            impact = impact_type()
            call prepare_impact(system, links(i), impact)
            impact%impulse(4) = -rate(links(i)%contact)/impact%inverse_mass(4, 4)
            do j = 1, 2
               if (links(i)%body(j) > 0) call apply_impulse(system, links(i), impact%impulse, j, &
                  y, supplied)
            end do
            call system%gap_rates(y, rate)
         end do
         if (maxval(abs(rate), mask=active) <= limit) exit
      end do
      call energies(system, y, kinetic(2), potential)
      y(system%layout%damping) = y(system%layout%damping) + kinetic(1) - kinetic(2) + supplied
      if (system%layout%applied > 0) y(system%layout%applied) = y(system%layout%applied) + supplied
   end subroutine stop_closed_gaps

   !> An impact at one contact.
   subroutine take_impact(system, y, index, link, e, trouble)
      !> The system; its poses are those of the state.
      type(system_type), intent(in) :: system
      !> State; velocities and works change.
      real(wp), intent(inout) :: y(:)
      integer, intent(in) :: index
      type(link_type), intent(in) :: link
      !> Coefficient of restitution.
      real(wp), intent(in) :: e
      !> One of the `trouble_*` codes.
      integer, intent(out) :: trouble
      type(impact_type) :: impact
      real(wp) :: supplied, kinetic(2), potential, normal_loss, loss
      integer :: j

      trouble = trouble_none
      associate (law => system%contacts(index)%law)
         call prepare_impact(system, link, impact)
         associate (c => impact%inverse_mass(4, 4), speed => impact%before(4))
            impact%a = law%normal%spot_of_impact(c, speed)
            if (allocated(law%friction)) then
               call integrate_impact(impact, law, e, system%resolution%tolerance, trouble)
               if (trouble /= trouble_none) return
            else
               impact%impulse(4) = -(1.0_wp + e)*speed/c
            end if
         end associate
         call energies(system, y, kinetic(1), potential)
         supplied = 0.0_wp
         do j = 1, 2
            if (link%body(j) > 0) call apply_impulse(system, link, impact%impulse, j, y, supplied)
         end do
         call energies(system, y, kinetic(2), potential)
         loss = kinetic(1) - kinetic(2) + supplied
         normal_loss = loss
         if (allocated(law%friction)) then
            ! The work of friction is what tangential and spinning motion take; the rest is damping.
            normal_loss = min(impact%normal_loss, loss)
            y(system%layout%friction) = y(system%layout%friction) + loss - normal_loss
         end if
         y(system%layout%damping) = y(system%layout%damping) + normal_loss
         if (system%layout%applied > 0) then
            y(system%layout%applied) = y(system%layout%applied) + supplied
         end if
      end associate
   end subroutine take_impact

   !> Inverse mass and velocities at a contact.
   pure subroutine prepare_impact(system, link, impact)
      type(system_type), intent(in) :: system
      !> Kinematics of the contact.
      type(link_type), intent(in) :: link
      type(impact_type), intent(inout) :: impact

      impact%before(1:3) = link%motion
      impact%before(4) = link%rate
      call inverse_mass_between(system%mechanism_type, link, link, impact%inverse_mass)
   end subroutine prepare_impact

   !> Give a body its share of the impulse.
   pure subroutine apply_impulse(system, link, impulse, side, y, supplied)
      type(system_type), intent(in) :: system
      !> Kinematics of the contact.
      type(link_type), intent(in) :: link
      !> Impulse along major axis, minor axis [N s], about [N m s] and along the normal [N s].
      real(wp), intent(in) :: impulse(4)
      !> 1 for body A, 2 for body B.
      integer, intent(in) :: side
      real(wp), intent(inout) :: y(:)
      !> Energy that a prescribed motion supplies [J], added to.
      real(wp), intent(inout) :: supplied
      real(wp) :: force(3), torque(3), moment(3)

      force = impulse(1)*link%at%major + impulse(2)*link%minor + impulse(4)*link%at%normal
      torque = cross(link%arm(:, side), force) + impulse(3)*link%at%normal
      if (side == 1) then
         force = -force
         torque = -torque
      end if
      associate (body => system%bodies(link%body(side)), pose => system%pose(link%body(side)))
         if (body%motion == motion_free) then
            moment = matmul(torque, pose%rotation)
            call add_to_motion(y, link%body(side), force/body%mass, moment/body%inertia)
         else if (body%motion == motion_prescribed) then
            supplied = supplied - dot_product(force, pose%velocity) - dot_product(torque, pose%spin)
         end if
      end associate
   end subroutine apply_impulse

end module contensou_dynamics_impact
