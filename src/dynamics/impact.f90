!> Impacts of rigid contacts, and which of them stay closed.
!>
!> An impact is instantaneous and at one contact; several that touch at once are taken one after
!> the other, the fastest approach first, until none approaches. With friction `routh` integrates
!> the impulses. E. J. Routh, Dynamics of a System of Rigid Bodies (1905); J. B. Keller, J.
!> Appl. Mech. 53 (1986) 1. The spot has the mean size of that of Hertz's impact, sqrt(d) weighted
!> with the force: 0.8955 of the largest one. Compression ends where the approach does; restitution
!> where it has given back e^2 of the work of compression (W. J. Stronge, Proc. R. Soc. A 431
!> (1990) 169), so that no impact gains energy. Without a coupling of friction and normal velocity
!> the rebound is e times the approach.
module contensou_dynamics_impact
   use contensou_base_kinds, only : wp
   use contensou_base_vectors, only : cross
   use contensou_contact_damping_coefficient, only : hunt_crossley_restitution
   use contensou_contact_geometry, only : trouble_jammed, trouble_none
   use contensou_dynamics_constraints, only : find_link, link_type, response, turned_by
   use contensou_dynamics_equations, only : system_type
   use contensou_dynamics_mechanism, only : contact_type
   use contensou_dynamics_reports, only : energies
   use contensou_dynamics_routh, only : impact_type, integrate_impact
   use contensou_dynamics_scene, only : motion_free, motion_prescribed
   use contensou_dynamics_state, only : add_to_motion
   implicit none(type, external)
   private

   public :: resolve_impacts, open_contact, touching_gap

   !> Gap of closed surfaces over the smallest radius: what a rigid contact does not distinguish
   !> from touching.
   real(wp), parameter :: touching = 1.0e-9_wp

   !> How much lower than where it opened a gap closes again, over that [-]: above rounding, so that
   !> no contact closes by the rounding of its opening.
   real(wp), parameter :: margin = 1.0e-3_wp

   !> Mean over the impulse of the root of the approach in Hertz's impact, over the largest one:
   !> B(6/5, 1/2)/2.
   real(wp), parameter :: mean_root = 0.89552_wp

   !> Impacts at one instant after which a scene is given up.
   integer, parameter :: most_impacts = 10000

   !> Turns in which several contacts are brought to rest.
   integer, parameter :: most_turns = 1000

   !> Share of `velocity_scale` below which a rebound closes the contact.
   real(wp), parameter :: slow = 1.0e-3_wp

   !> Share of that which counts as rest.
   real(wp), parameter :: rest = 1.0e-3_wp

contains

   !> Largest gap of a rigid contact that counts as zero [m].
   pure function touching_gap(contact) result(gap)
      type(contact_type), intent(in) :: contact
      real(wp) :: gap

      gap = touching*contact%law%geometry%smallest_radius()
   end function touching_gap

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

   !> Take the impacts of contacts that touch, and decide which of them are closed from here on.
   subroutine resolve_impacts(system, t, y, candidate, velocity_scale, index, trouble)
      !> The system; `closed` and `leaving` of the candidates are set.
      type(system_type), intent(inout) :: system
      !> Time [s].
      real(wp), intent(in) :: t
      !> State; an impact changes velocities and works.
      real(wp), intent(inout) :: y(:)
      !> Rigid contacts whose gaps are zero.
      logical, intent(in) :: candidate(:)
      !> Velocity that the tolerance refers to [m/s].
      real(wp), intent(in) :: velocity_scale
      !> Contact in trouble; 0 for none.
      integer, intent(out) :: index
      !> One of the `trouble_*` codes.
      integer, intent(out) :: trouble
      real(wp) :: rate(size(candidate)), y_rate(size(y)), press(size(candidate)), slowest, e, still
      type(link_type) :: link
      logical :: resting(size(candidate))
      integer :: i, k

      trouble = trouble_none
      index = 0
      still = rest*slow*velocity_scale
      do k = 1, most_impacts
         call system%gap_rates(y, rate)
         i = minloc(rate, dim=1, mask=candidate)
         if (rate(i) >= -still) exit
         where (candidate) system%contacts%closed = .false.
         call find_pressing_acceleration(system, t, y, i, y_rate, link, press(i), trouble)
         if (trouble /= trouble_none) exit
         slowest = slowest_rebound(system%contacts(i), link, press(i), velocity_scale)
         e = restitution_at(system%contacts(i), -rate(i))
         ! Where nothing presses the bodies together, the slowest rebound is one.
         if (press(i) > 0.0_wp .and. -e*rate(i) < slowest) e = 0.0_wp
         call take_impact(system, y, i, link, e, trouble)
         if (trouble /= trouble_none) exit
      end do
      if (trouble == trouble_none .and. k > most_impacts) trouble = trouble_jammed
      if (trouble /= trouble_none) then
         index = i
         return
      end if
      resting = candidate .and. rate <= still
      if (any(candidate .and. .not. resting)) then
         call keep_slow(system, t, y, candidate, velocity_scale, rate, resting, index, trouble)
         if (trouble /= trouble_none) return
      end if
      call choose_loaded_contacts(system, t, y, resting, y_rate, index, trouble)
      if (trouble /= trouble_none) return
      call stop_closed_gaps(system, y, rest*still)
      do i = 1, size(candidate)
         if (.not. candidate(i)) cycle
         system%contacts(i)%leaving = .false.
         if (.not. system%contacts(i)%closed) call open_contact(system, i)
      end do
   end subroutine resolve_impacts

   !> Contacts that impacts at others open, slower than a rebound may be, stay closed: a body that
   !> rocks between two of them comes to rest on both after a finite number of impacts.
   subroutine keep_slow(system, t, y, candidate, velocity_scale, rate, resting, index, trouble)
      type(system_type), intent(inout) :: system
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)
      !> Rigid contacts whose gaps are zero.
      logical, intent(in) :: candidate(:)
      !> Velocity that the tolerance refers to [m/s].
      real(wp), intent(in) :: velocity_scale
      !> Rates of the gaps [m/s].
      real(wp), intent(in) :: rate(:)
      !> Contacts at rest; those that stay closed are added.
      logical, intent(inout) :: resting(:)
      !> Contact in trouble; unchanged if none is.
      integer, intent(inout) :: index
      !> One of the `trouble_*` codes.
      integer, intent(out) :: trouble
      type(link_type) :: link
      real(wp) :: y_rate(size(y)), press
      integer :: i

      trouble = trouble_none
      where (candidate) system%contacts%closed = .false.
      do i = 1, size(candidate)
         if (.not. candidate(i) .or. resting(i)) cycle
         call find_pressing_acceleration(system, t, y, i, y_rate, link, press, trouble)
         if (trouble /= trouble_none) then
            index = i
            return
         end if
         resting(i) = press > 0.0_wp .and. &
            rate(i) < slowest_rebound(system%contacts(i), link, press, velocity_scale)
      end do
   end subroutine keep_slow

   !> Open a rigid contact at the poses that are set.
   subroutine open_contact(system, index)
      type(system_type), intent(inout) :: system
      integer, intent(in) :: index
      real(wp) :: gap

      associate (contact => system%contacts(index))
         call contact%find_gap(system%pose(contact%a), system%pose(contact%b), gap)
         contact%closed = .false.
         contact%leaving = .true.
         contact%threshold = min(gap, 0.0_wp) - margin*touching_gap(contact)
      end associate
   end subroutine open_contact

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

   !> Which of the contacts at rest carry a load: without those that would have to pull.
   subroutine choose_loaded_contacts(system, t, y, resting, y_rate, index, trouble)
      type(system_type), intent(inout) :: system
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)
      !> Contacts whose gap and its rate are zero.
      logical, intent(in) :: resting(:)
      !> Room for a right-hand side.
      real(wp), intent(out) :: y_rate(:)
      !> Contact in trouble; unchanged if none is.
      integer, intent(inout) :: index
      !> One of the `trouble_*` codes.
      integer, intent(out) :: trouble
      type(link_type) :: link
      real(wp) :: least
      integer :: i, k, worst
      logical :: closed(size(resting))

      trouble = trouble_none
      closed = resting
      do k = 1, 4*size(resting) + 4
         where (resting) system%contacts%closed = closed
         where (closed) system%contacts%normal_force = 0.0_wp
         call system%derivative(t, y, y_rate)
         if (system%outside) then
            index = system%trouble
            trouble = system%trouble_code
            return
         end if
         worst = 0
         least = 0.0_wp
         do i = 1, size(resting)
            if (.not. closed(i)) cycle
            if (system%contacts(i)%normal_force > least) cycle
            worst = i
            least = system%contacts(i)%normal_force
         end do
         if (worst > 0) then
            closed(worst) = .false.
            cycle
         end if
         ! One that was dropped may be needed after another one was.
         do i = 1, size(resting)
            if (.not. resting(i) .or. closed(i)) cycle
            call find_link(system%mechanism_type, i, y_rate, link, trouble)
            if (trouble /= trouble_none) then
               index = i
               return
            end if
            if (link%free < least) then
               worst = i
               least = link%free
            end if
         end do
         if (worst == 0 .or. .not. any(closed)) return
         closed(worst) = .true.
      end do
      index = worst
      trouble = trouble_jammed
   end subroutine choose_loaded_contacts

   !> Take what is left of the rates of the closed gaps after impacts in turn.
   subroutine stop_closed_gaps(system, y, limit)
      !> The system; its links are those of the state.
      type(system_type), intent(inout) :: system
      !> State; velocities and the work of damping change a little.
      real(wp), intent(inout) :: y(:)
      !> Rate that is none [m/s].
      real(wp), intent(in) :: limit
      type(impact_type) :: impact
      real(wp) :: rate(size(system%contacts)), kinetic(2), potential, supplied
      integer :: i, j, k

      if (system%constraints%n_links == 0) return
      call energies(system, y, kinetic(1), potential)
      supplied = 0.0_wp
      do k = 1, most_turns
         do i = 1, system%constraints%n_links
            call system%gap_rates(y, rate)
            associate (link => system%constraints%links(i))
               impact = impact_type()
               call prepare_impact(system, link, impact)
               impact%impulse(4) = -rate(link%contact)/impact%inverse_mass(4, 4)
               do j = 1, 2
                  if (link%body(j) > 0) call apply_impulse(system, link, impact%impulse, j, y, &
                     supplied)
               end do
            end associate
         end do
         call system%gap_rates(y, rate)
         associate (n => system%constraints%n_links, links => system%constraints%links)
            if (maxval(abs(rate(links(:n)%contact))) <= limit) exit
         end associate
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
            impact%a = mean_root*law%normal%axis_a &
               *(1.25_wp*speed**2/(c*law%normal%stiffness))**0.2_wp
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
      real(wp) :: force(3, 4), torque(3, 4), turned(3, 4)
      integer :: i, j, k

      impact%before(1:3) = link%motion
      impact%before(4) = link%rate
      force(:, 1) = link%at%major
      force(:, 2) = link%minor
      force(:, 3) = 0.0_wp
      force(:, 4) = link%at%normal
      do k = 1, 2
         if (link%body(k) == 0) cycle
         associate (body => system%bodies(link%body(k)))
            if (body%motion /= motion_free) cycle
            do i = 1, 4
               torque(:, i) = cross(link%arm(:, k), force(:, i))
               if (i == 3) torque(:, i) = link%at%normal
               turned(:, i) = turned_by(torque(:, i), 1.0_wp/body%inertia, &
                  system%pose(link%body(k)))
            end do
            do i = 1, 4
               do j = 1, 4
                  impact%inverse_mass(i, j) = impact%inverse_mass(i, j) &
                     + dot_product(force(:, i), force(:, j))/body%mass &
                     + dot_product(torque(:, i), turned(:, j))
               end do
            end do
         end associate
      end do
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
