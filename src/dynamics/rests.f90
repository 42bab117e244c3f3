!> Which rigid contacts are closed, decided for all that touch together, and what must hold.
!>
!> At an event the impacts (module `contensou_dynamics_impact`) come first. Then the normal forces
!> of the contacts at rest and the second derivatives of their gaps solve a complementarity problem
!> (F. Pfeiffer, Ch. Glocker, Multibody Dynamics with Unilateral Contacts, 1996; D. E. Stewart,
!> SIAM Rev. 42 (2000) 3), and the equations of motion confirm the solution.
module contensou_dynamics_rests
   use contensou_base_kinds, only : wp
   use contensou_contact_geometry, only : trouble_apart, trouble_drives, trouble_jammed, &
      trouble_none, trouble_sunk
   use contensou_dynamics_equations, only : system_type
   use contensou_dynamics_halts, only : halt_slow
   use contensou_dynamics_impact, only : find_links, find_pressing_acceleration, resolve_impacts, &
      rest, slow_rate, slowest_rebound, stop_closed_gaps
   use contensou_dynamics_links, only : find_link, link_type, normal_response, response, set_load
   use contensou_dynamics_mechanism, only : contact_type
   use contensou_special_complementarity, only : solve_complementarity
   use contensou_special_elimination, only : independent_rows
   implicit none(type, external)
   private

   public :: resolve_contacts, open_contact, lower_threshold, agree, check_contacts, touching_gap, &
      set_thresholds, sunk

   !> Gap of closed surfaces over the smallest radius: what a rigid contact does not distinguish
   !> from touching.
   real(wp), parameter :: touching = 1.0e-9_wp

   !> How much lower than where it opened a gap closes again, over that [-]: above rounding, so that
   !> no contact closes by the rounding of its opening.
   real(wp), parameter :: margin = 1.0e-3_wp

   !> How far below a gap that only seemed to close the next threshold is at most, over the same.
   real(wp), parameter :: lowered = 100.0_wp

   !> Times that contacts are brought to rest and others approach by that, at one instant.
   integer, parameter :: most_passes = 1000

   !> Linear problems that are solved for the normal forces of contacts that close together.
   integer, parameter :: most_problems = 30

   !> Compliance that makes these problems definite, over the inverse mass at a contact.
   real(wp), parameter :: compliance = 1.0e-9_wp

   !> Share of the accelerations of a motion that is rounding.
   real(wp), parameter :: negligible = 1.0e-9_wp

   !> Rate of a gap that is rounding, over `velocity_scale`.
   real(wp), parameter :: rounding = 1.0e-15_wp

   !> Overlap of a rigid contact that ends a run, over the smallest radius.
   real(wp), parameter :: sunk = 1.0e-6_wp

   !> Least square of the rate at which an error of a gap decays that tells how far it goes [1/s2].
   real(wp), parameter :: slowest_pace = 1.0_wp

   !> Pull of a rigid contact that is none, over the inverse mass times accelerations of the motion;
   !> the same for the power that friction supplies.
   real(wp), parameter :: unfelt = 1.0e-6_wp

   !> Normal force that is as good as zero where it begins, over the same.
   real(wp), parameter :: felt = 1.0e-9_wp

contains

   !> Largest gap of a rigid contact that counts as zero [m].
   pure function touching_gap(contact) result(gap)
      type(contact_type), intent(in) :: contact
      real(wp) :: gap

      gap = touching*contact%law%geometry%smallest_radius()
   end function touching_gap

   !> Take the impacts of contacts that touch, and decide which of them are closed from here on.
   subroutine resolve_contacts(system, t, y, candidate, velocity_scale, index, trouble)
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
      type(link_type), allocatable :: links(:)
      real(wp) :: rate(size(candidate)), carried(size(candidate)), still, left
      logical :: resting(size(candidate)), active(size(candidate))
      integer :: i, k, pass

      trouble = trouble_none
      index = 0
      still = slow_rate*velocity_scale
      call system%gap_rates(y, rate)
      call halt_slow(system, t, y, candidate, rate, velocity_scale, index, trouble)
      if (trouble /= trouble_none) return
      call find_carried(system, t, y, candidate .and. rate <= still, carried)
      do pass = 1, most_passes
         call resolve_impacts(system, t, y, candidate, carried, velocity_scale, rate, index, &
            trouble)
         if (trouble /= trouble_none) return
         resting = candidate .and. rate <= still
         if (any(candidate .and. .not. resting)) then
            call keep_slow(system, t, y, candidate, velocity_scale, rate, resting, index, trouble)
            if (trouble /= trouble_none) return
         end if
         do k = 1, size(candidate) + 2
            call find_active_contacts(system, t, y, resting, links, active, index, trouble)
            if (trouble /= trouble_none) return
            left = largest_rate(links, active)
            if (left <= still) then
               call close_active_contacts(system, t, y, resting, links, active, index, trouble)
               if (trouble /= trouble_none) return
               left = largest_rate(links, active)
            end if
            call stop_closed_gaps(system, y, links, active, rest*still)
            ! What is left of a rate decides with friction on the forces: they are sought again.
            if (left <= still) exit
         end do
         ! What creeps up without a force would touch again and again.
         call system%gap_rates(y, rate)
         if (any(resting .and. .not. active .and. rate < 0.0_wp)) call stop_closed_gaps(system, &
            y, links, active .or. (resting .and. rate < 0.0_wp), rounding*velocity_scale)
         ! Others may approach by that, or have come to rest.
         call system%gap_rates(y, rate)
         if (all((rate >= -still .and. (resting .or. rate > still)) .or. .not. candidate .or. &
            system%contacts%closed)) exit
      end do
      if (pass > most_passes) then
         index = minloc(rate, dim=1, mask=candidate)
         trouble = trouble_jammed
         return
      end if
      do i = 1, size(candidate)
         if (.not. candidate(i)) cycle
         system%contacts(i)%leaving = .false.
         if (.not. system%contacts(i)%closed) call open_contact(system, i)
      end do
   end subroutine resolve_contacts

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
      real(wp) :: y_rate(size(y)), press, carried(size(candidate))
      logical :: slow_ones(size(candidate)), dropped
      integer :: i

      trouble = trouble_none
      where (candidate) system%contacts%closed = .false.
      slow_ones = candidate
      do
         call find_carried(system, t, y, slow_ones, carried)
         dropped = .false.
         do i = 1, size(candidate)
            if (.not. slow_ones(i) .or. resting(i)) cycle
            call find_pressing_acceleration(system, t, y, i, y_rate, link, press, trouble)
            if (trouble /= trouble_none) then
               index = i
               return
            end if
            press = max(press, carried(i))
            if (press > 0.0_wp .and. &
               rate(i) < slowest_rebound(system%contacts(i), link, press, velocity_scale)) cycle
            slow_ones(i) = .false.
            dropped = .true.
         end do
         if (.not. dropped) exit
      end do
      resting = slow_ones
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

   !> Let the gap of a contact that has opened come lower before it closes again: what an
   !> interpolant makes of it goes on within the step, so that it would be found below each
   !> threshold anew.
   subroutine lower_threshold(system, index)
      !> The system, its poses set.
      type(system_type), intent(inout) :: system
      integer, intent(in) :: index
      real(wp) :: gap

      associate (contact => system%contacts(index))
         call contact%find_gap(system%pose(contact%a), system%pose(contact%b), gap)
         contact%threshold = min(gap, 0.0_wp) - min(max(-gap, margin*touching_gap(contact)), &
            lowered*touching_gap(contact))
      end associate
   end subroutine lower_threshold

   !> Which of the contacts at rest are closed: those whose forces solve the complementarity problem
   !> of normal forces and second derivatives of the gaps, and those whose gap these hold.
   subroutine find_active_contacts(system, t, y, resting, links, active, index, trouble)
      !> The system; `closed` of the contacts at rest is set.
      type(system_type), intent(inout) :: system
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)
      !> Contacts whose gap and its rate are zero.
      logical, intent(in) :: resting(:)
      !> These, with their forces.
      type(link_type), allocatable, intent(inout) :: links(:)
      !> Those that are to be closed.
      logical, intent(out) :: active(:)
      !> Contact in trouble; unchanged if none is.
      integer, intent(inout) :: index
      !> One of the `trouble_*` codes.
      integer, intent(out) :: trouble

      active = .false.
      call find_links(system, t, y, resting, links, index, trouble)
      if (trouble /= trouble_none .or. .not. any(resting)) return
      call solve_contact_forces(system, links, index, trouble)
      if (trouble /= trouble_none) return
      active(links%contact) = links%normal_force > 0.0_wp
      call add_held(system, links, active)
   end subroutine find_active_contacts

   !> Accelerations by which contacts would be pressed together if all of them were at rest; zero
   !> where none is needed, or none can be found.
   subroutine find_carried(system, t, y, chosen, carried)
      type(system_type), intent(inout) :: system
      !> Time [s].
      real(wp), intent(in) :: t
      !> State.
      real(wp), intent(in) :: y(:)
      !> Which contacts.
      logical, intent(in) :: chosen(:)
      !> The accelerations [m/s2].
      real(wp), intent(out) :: carried(:)
      type(link_type), allocatable :: links(:)
      logical :: closed(size(chosen))
      integer :: i, index, trouble

      carried = 0.0_wp
      if (count(chosen) < 2) return
      closed = system%contacts%closed
      call find_links(system, t, y, chosen, links, index, trouble)
      if (trouble == trouble_none) call solve_contact_forces(system, links, index, trouble)
      if (trouble == trouble_none) then
         do i = 1, size(links)
            carried(links(i)%contact) = links(i)%normal_force*normal_response(links(i), links(i))
         end do
      end if
      where (chosen) system%contacts%closed = closed
   end subroutine find_carried

   !> Close contacts at rest. The equations of motion, with the loads that compliance shares, have
   !> the last word on which: contacts change one by one, in the end by the least index, by which
   !> pivots come to an end (K. G. Murty, Linear Algebra and its Applications 7 (1973) 241).
   subroutine close_active_contacts(system, t, y, resting, links, active, index, trouble)
      type(system_type), intent(inout) :: system
      !> Time [s].
      real(wp), intent(in) :: t
      !> State.
      real(wp), intent(in) :: y(:)
      !> Contacts whose gap and its rate are zero.
      logical, intent(in) :: resting(:)
      !> These.
      type(link_type), intent(inout) :: links(:)
      !> Those that are to be closed, and in the end are.
      logical, intent(inout) :: active(:)
      !> Contact in trouble; unchanged if none is.
      integer, intent(inout) :: index
      !> One of the `trouble_*` codes.
      integer, intent(out) :: trouble
      real(wp) :: y_rate(size(y)), least
      integer :: i, k, worst

      trouble = trouble_none
      do k = 1, 4*size(resting) + 4
         where (resting) system%contacts%closed = active
         where (active) system%contacts%normal_force = 0.0_wp
         call system%derivative(t, y, y_rate)
         if (system%outside) then
            index = system%trouble
            trouble = system%trouble_code
            return
         end if
         if (.not. any(active)) return
         worst = 0
         least = -system%constraints%pull
         do i = 1, size(resting)
            if (.not. active(i) .or. system%contacts(i)%normal_force > least) cycle
            worst = i
            if (k > 2*size(resting)) exit
            least = system%contacts(i)%normal_force
         end do
         if (worst > 0) then
            active(worst) = .false.
            cycle
         end if
         least = 0.0_wp
         do i = 1, size(links)
            associate (link => links(i))
               if (active(link%contact)) cycle
               call find_link(system%mechanism_type, link%contact, y_rate, link, trouble)
               if (trouble /= trouble_none) then
                  index = link%contact
                  return
               end if
               if (link%free + negligible*largest_acceleration(system, link) >= least) cycle
               worst = link%contact
               if (k > 2*size(resting)) exit
               least = link%free
            end associate
         end do
         if (worst == 0) return
         active(worst) = .true.
      end do
      index = worst
      trouble = trouble_jammed
   end subroutine close_active_contacts

   !> Largest rate of the gap of an active contact [m/s].
   pure function largest_rate(links, active) result(rate)
      type(link_type), intent(in) :: links(:)
      logical, intent(in) :: active(:)
      real(wp) :: rate

      rate = 0.0_wp
      if (size(links) > 0) rate = maxval(abs(links%rate), mask=active(links%contact))
      rate = max(rate, 0.0_wp)
   end function largest_rate

   !> Normal forces of contacts at rest by a sequence of linear complementarity problems, as the
   !> spot and with it friction vary with the normal force.
   subroutine solve_contact_forces(system, links, index, trouble)
      type(system_type), intent(inout) :: system
      !> Kinematics of the contacts, no rigid one closed; their loads are set.
      type(link_type), intent(inout) :: links(:)
      !> Contact in trouble; unchanged if none is.
      integer, intent(inout) :: index
      !> One of the `trouble_*` codes.
      integer, intent(out) :: trouble
      real(wp) :: matrix(size(links), size(links)), q(size(links)), force(size(links))
      real(wp) :: scale(size(links)), change
      integer :: i, j, k
      logical :: solved

      trouble = trouble_none
      do i = 1, size(links)
         scale(i) = 1.0_wp/sqrt(normal_response(links(i), links(i)))
      end do
      force = 0.0_wp
      do k = 1, most_problems
         do i = 1, size(links)
            call set_load(links(i), system%contacts(links(i)%contact), force(i))
         end do
         do i = 1, size(links)
            q(i) = links(i)%free
            do j = 1, size(links)
               matrix(i, j) = response(links(i), links(j), links(j)%slope)
               q(i) = q(i) + response(links(i), links(j), links(j)%wrench) - matrix(i, j)*force(j)
               matrix(i, j) = scale(i)*matrix(i, j)*scale(j)
            end do
            q(i) = scale(i)*q(i)
            if (.not. matrix(i, i) > 0.0_wp) then
               ! A larger normal force would press the bodies together.
               index = links(i)%contact
               trouble = trouble_jammed
               return
            end if
            matrix(i, i) = matrix(i, i) + compliance
         end do
         call solve_complementarity(matrix, q, force, solved)
         if (.not. solved) then
            index = links(minloc(q, dim=1))%contact
            trouble = trouble_jammed
            return
         end if
         force = scale*force
         change = maxval(abs(force - links%normal_force))
         links%normal_force = force
         if (change <= 1.0e-9_wp*maxval(force)) return
      end do
   end subroutine solve_contact_forces

   !> Contacts without a force whose gaps depend on those of the contacts with one: these hold them,
   !> and compliance may load them.
   subroutine add_held(system, links, active)
      type(system_type), intent(in) :: system
      !> Kinematics of the contacts at rest, with their loads.
      type(link_type), intent(in) :: links(:)
      !> Contacts with a force; those that they hold are added.
      logical, intent(inout) :: active(:)
      real(wp) :: matrix(size(links), size(links)), factor(size(links), size(links)), acceleration
      integer :: order(size(links)), i, j, n, rank, more

      n = 0
      do i = 1, size(links)
         if (.not. active(links(i)%contact)) cycle
         n = n + 1
         order(n) = i
      end do
      if (n == 0 .or. n == size(links)) return
      do i = 1, size(links)
         if (active(links(i)%contact)) cycle
         acceleration = links(i)%free
         do j = 1, n
            associate (other => links(order(j)))
               acceleration = acceleration + response(links(i), other, other%wrench)
            end associate
         end do
         if (acceleration > negligible*largest_acceleration(system, links(i))) cycle
         order(n + 1) = i
         call fill(n)
         call independent_rows(n, matrix, factor, rank)
         call fill(n + 1)
         call independent_rows(n + 1, matrix, factor, more)
         active(links(i)%contact) = more == rank
      end do

   contains

      !> Responses of the first contacts in the order, with a unit diagonal.
      subroutine fill(number)
         integer, intent(in) :: number
         integer :: k, m

         do k = 1, number
            do m = 1, number
               matrix(k, m) = normal_response(links(order(k)), links(order(m)))/sqrt( &
                  normal_response(links(order(k)), links(order(k))) &
                  *normal_response(links(order(m)), links(order(m))))
            end do
         end do
      end subroutine fill

   end subroutine add_held

   !> Whether the closed contacts push, and no open one that touches closes, as they are.
   logical function agree(system, t, y, near, velocity_scale)
      type(system_type), intent(inout) :: system
      !> Time [s].
      real(wp), intent(in) :: t
      !> State.
      real(wp), intent(in) :: y(:)
      !> Open rigid contacts whose gaps are zero.
      logical, intent(in) :: near(:)
      !> Velocity that the tolerance refers to [m/s].
      real(wp), intent(in) :: velocity_scale
      type(link_type) :: link
      real(wp) :: y_rate(size(y)), force(size(near))
      integer :: i, trouble

      force = system%contacts%normal_force
      call system%derivative(t, y, y_rate)
      agree = .not. system%outside
      if (.not. agree) return
      do i = 1, system%constraints%n_links
         associate (now => system%constraints%links(i))
            agree = agree .and. now%normal_force >= min(-system%constraints%pull, &
               -unfelt*largest_force(system, now))
         end associate
      end do
      do i = 1, size(near)
         if (.not. near(i)) cycle
         call find_link(system%mechanism_type, i, y_rate, link, trouble)
         if (trouble /= trouble_none .or. link%rate > slow_rate*velocity_scale) cycle
         agree = agree .and. link%free >= -unfelt*largest_acceleration(system, link)
      end do
      ! Guesses for the next ones.
      system%contacts%normal_force = force
   end function agree

   !> Let the normal force of a closed contact that is as good as zero lift it off as soon as it
   !> falls from there: on the far side of zero from the beginning, its fall would go unseen.
   subroutine set_thresholds(system, t, y)
      type(system_type), intent(inout) :: system
      !> Time [s].
      real(wp), intent(in) :: t
      !> State.
      real(wp), intent(in) :: y(:)
      real(wp) :: y_rate(size(y)), force(size(system%contacts)), least
      integer :: i

      where (system%contacts%closed) system%contacts%threshold = 0.0_wp
      force = system%contacts%normal_force
      call system%derivative(t, y, y_rate)
      if (system%outside) return
      do i = 1, system%constraints%n_links
         associate (link => system%constraints%links(i))
            least = felt*largest_force(system, link)
            if (link%normal_force + system%constraints%pull >= least) cycle
            system%contacts(link%contact)%threshold = 2.0_wp*least &
               + max(-link%normal_force - system%constraints%pull, 0.0_wp)
         end associate
      end do
      ! Guesses for the next ones.
      system%contacts%normal_force = force
   end subroutine set_thresholds

   !> Whether rigid contacts hold at the end of a step: open ones above zero, closed ones at it and
   !> without a pull, friction without a gain. The forces are those of the last right-hand side.
   subroutine check_contacts(system, gap, missed, pulls, drift, index, trouble)
      type(system_type), intent(in) :: system
      !> Gaps; only those of open contacts are looked at [m].
      real(wp), intent(in) :: gap(:)
      !> Open contacts below zero.
      logical, intent(out) :: missed(:)
      !> Closed contacts that pull.
      logical, intent(out) :: pulls(:)
      !> Largest overlap of a closed contact, as far as its rate takes it, over that which ends a
      !> run [-].
      real(wp), intent(out) :: drift
      !> Contact that has sunk in, is closed and apart, or whose friction drives; 0 for none.
      integer, intent(out) :: index
      !> One of the `trouble_*` codes.
      integer, intent(out) :: trouble
      real(wp) :: gain, loss
      integer :: i

      index = 0
      trouble = trouble_none
      missed = .false.
      pulls = .false.
      drift = 0.0_wp
      do i = 1, size(system%contacts)
         associate (contact => system%contacts(i))
            if (contact%closed .or. .not. contact%rigid .or. gap(i) >= 0.0_wp) cycle
            missed(i) = .not. contact%leaving
            if (contact%leaving) missed(i) = gap(i) < contact%threshold
            if (overlap(contact, gap(i)) > 1.0_wp) then
               index = i
               trouble = trouble_sunk
            end if
         end associate
      end do
      do i = 1, system%constraints%n_links
         associate (link => system%constraints%links(i))
            if (.not. system%contacts(link%contact)%closed) cycle
            if (abs(overlap(system%contacts(link%contact), link%at%gap)) > 1.0_wp) then
               index = link%contact
               trouble = merge(trouble_sunk, trouble_apart, link%at%gap < 0.0_wp)
            end if
            if (link%at%gap < 0.0_wp) then
               ! As far as its rate takes it before it is held.
               drift = max(drift, overlap(system%contacts(link%contact), link%at%gap &
                  + min(link%rate, 0.0_wp)/sqrt(max(link%pace, slowest_pace))))
            end if
            if (link%normal_force < -system%constraints%pull) then
               pulls(link%contact) = link%normal_force < -unfelt*largest_force(system, link)
            else if (link%normal_force > 0.0_wp .and. &
               system%contacts(link%contact)%states%n == 0) then
               ! A law with states may give back what it has stored.
               gain = dot_product(link%wrench(1:3), link%slip())
               loss = dot_product(link%wrench(4:6), link%spin)
               if (gain + loss <= unfelt*(norm2(link%wrench(1:3))*norm2(link%slip()) &
                  + norm2(link%wrench(4:6))*norm2(link%spin))) cycle
               index = link%contact
               trouble = trouble_drives
               return
            end if
         end associate
      end do

   contains

      !> An overlap over that which ends a run [-].
      pure real(wp) function overlap(contact, gap)
         type(contact_type), intent(in) :: contact
         !> The gap [m].
         real(wp), intent(in) :: gap

         overlap = -gap/(sunk*contact%law%geometry%smallest_radius())
      end function overlap

   end subroutine check_contacts

   !> What the normal force of a contact is to be compared with [N].
   pure function largest_force(system, link) result(force)
      type(system_type), intent(in) :: system
      type(link_type), intent(in) :: link
      real(wp) :: force

      force = largest_acceleration(system, link)/normal_response(link, link)
   end function largest_force

   !> What the second derivative of a gap is to be compared with: gravity, and what the motion of
   !> the bodies and their other loads make [m/s2].
   pure function largest_acceleration(system, link) result(acceleration)
      type(system_type), intent(in) :: system
      type(link_type), intent(in) :: link
      real(wp) :: acceleration

      acceleration = norm2(system%gravity)
      if (link%at%curvature_b > 0.0_wp) then
         acceleration = acceleration + 0.5_wp*link%pace/link%at%curvature_b
      else
         acceleration = acceleration + abs(link%free)
      end if
   end function largest_acceleration

end module contensou_dynamics_rests
