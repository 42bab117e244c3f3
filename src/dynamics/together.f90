!> The impulses of an impact at several contacts at once.
!>
!> Two phases, each a complementarity problem for all contacts together (F. Pfeiffer, Ch. Glocker,
!> Multibody Dynamics with Unilateral Contacts, 1996, chapter 8). At the end of compression no gap
!> shrinks, and where one grows there is no impulse:
!>    u_C = u + G L_C,  0 <= u_C . n, 0 <= L_C . n, complementary at each contact.
!> Expansion gives back at least a share e of each impulse (Poisson), and more where a gap would
!> shrink otherwise:
!>    u_E = u_C + G L_E,  0 <= u_E . n, e L_C . n <= L_E . n, complementary at each contact.
!> The impulses of friction over the normal impulse are the wrench of the law of the contact at the
!> velocities at the end of the phase.
!>
!> Poisson's ratio alone can gain energy where restitutions differ or friction acts (Ch. Glocker, J.
!> Appl. Mech. 80 (2013) 050914). So the shares e are diminished by one factor, if need be, until
!> the normal impulses of the expansion work no more than the sum of e^2 times their works in the
!> compression: W. J. Stronge's ratio of energies (Proc. R. Soc. A 431 (1990) 169) for all contacts.
module contensou_dynamics_together
   use contensou_base_kinds, only : wp
   use contensou_base_vectors, only : cross
   use contensou_contact_geometry, only : trouble_none, trouble_squeezed, trouble_unsettled
   use contensou_dynamics_links, only : link_type, turned_by
   use contensou_dynamics_mechanism, only : contact_type, mechanism_type
   use contensou_dynamics_routh, only : impact_type, smallest_velocity, solve_stage
   use contensou_dynamics_scene, only : motion_free
   use contensou_special_complementarity, only : solve_complementarity
   implicit none(type, external)
   private

   public :: together_type, inverse_mass_between

   !> Compliance that makes the problem of the normal impulses definite, over the inverse mass at a
   !> contact; it is taken out again.
   real(wp), parameter :: compliance = 1.0e-6_wp

   !> Problems until that is done.
   integer, parameter :: most_problems = 60

   !> Sweeps over the contacts for the impulses of friction.
   integer, parameter :: most_sweeps = 5000

   !> Sweeps after which the impulses are extrapolated to where they creep: those of more supports
   !> than needed do so in steps that shrink by as little as 1e-4.
   integer, parameter :: sweeps_between = 30

   !> Least ratio of two changes in a row that is a creep.
   real(wp), parameter :: creep = 0.5_wp

   !> Iterations for the normal impulse of one contact.
   integer, parameter :: most_iterations = 60

   !> Change of a velocity that is none, over those of the impact.
   real(wp), parameter :: converged = 1.0e-13_wp

   !> Change of a velocity, over those of the impact, that rounding may keep up where friction
   !> sticks.
   real(wp), parameter :: settled = 1.0e-7_wp

   !> Rate at which a gap still shrinks that is none, over the velocities of the impact.
   real(wp), parameter :: negligible = 1.0e-9_wp

   !> Work that is none, over that of the compression.
   real(wp), parameter :: rounding = 1.0e-12_wp

   !> An impact at several contacts. Velocities and impulses are along the major and the minor axis
   !> of the spot, about and along the normal.
   type :: together_type
      !> Velocities [m/s, rad/s] before, after compression and after expansion.
      real(wp), allocatable :: before(:, :), between(:, :), after(:, :)
      !> Impulses of compression and expansion [N s, N m s].
      real(wp), allocatable :: compression(:, :), expansion(:, :)
      !> Inverse masses: velocity at contact i by an impulse at contact j.
      real(wp), allocatable, private :: inverse_mass(:, :, :, :)
      !> Square of the velocity below which friction is smoothed [m2/s2].
      real(wp), private :: resolution = 0.0_wp
      !> What velocities are measured against [m/s].
      real(wp), private :: speed = 0.0_wp
      !> Share of the impulses of compression that expansion gives back, over the restitution [-].
      real(wp) :: share = 1.0_wp
   contains
      procedure :: begin
      procedure :: compress
      procedure :: expand
      procedure :: effective_speed
      procedure :: friction_loss
      procedure, private :: work
      procedure, private :: solve_phase
      procedure, private :: solve_frictionless
      procedure, private :: rub
      procedure, private :: velocities
   end type together_type

contains

   !> Inverse masses and velocities of an impact.
   subroutine begin(self, mechanism, links, tolerance)
      class(together_type), intent(out) :: self
      type(mechanism_type), intent(in) :: mechanism
      !> Kinematics of the contacts.
      type(link_type), intent(in) :: links(:)
      !> Relative tolerance of velocities [-].
      real(wp), intent(in) :: tolerance
      integer :: i, j, n

      n = size(links)
      allocate(self%before(4, n), self%between(4, n), self%after(4, n), self%compression(4, n), &
         self%expansion(4, n), self%inverse_mass(4, 4, n, n))
      do i = 1, n
         self%before(1:3, i) = links(i)%motion
         self%before(4, i) = links(i)%rate
         self%speed = max(self%speed, norm2(self%before([1, 2, 4], i)))
         do j = 1, n
            self%inverse_mass(:, :, i, j) = 0.0_wp
            call inverse_mass_between(mechanism, links(i), links(j), self%inverse_mass(:, :, i, j))
         end do
      end do
      self%resolution = (max(tolerance, smallest_velocity)*self%speed)**2
   end subroutine begin

   !> Impulses up to the end of the compression.
   subroutine compress(self, contacts, links, trouble)
      class(together_type), intent(inout) :: self
      !> All contacts of the mechanism.
      type(contact_type), intent(in) :: contacts(:)
      type(link_type), intent(in) :: links(:)
      !> One of the `trouble_*` codes.
      integer, intent(out) :: trouble
      real(wp) :: least(size(links))

      least = 0.0_wp
      call self%solve_phase(contacts, links, self%before, least, self%compression, self%between, &
         trouble)
   end subroutine compress

   !> Impulses of the expansion.
   subroutine expand(self, contacts, links, e, trouble)
      class(together_type), intent(inout) :: self
      !> All contacts of the mechanism.
      type(contact_type), intent(in) :: contacts(:)
      type(link_type), intent(in) :: links(:)
      !> Restitution of each contact.
      real(wp), intent(in) :: e(:)
      !> One of the `trouble_*` codes.
      integer, intent(out) :: trouble
      real(wp) :: compressed(size(links)), limit, low, high, f_low, f_high
      integer :: k

      compressed = -self%work(self%before, self%between, self%compression)
      limit = sum(e**2*compressed)
      limit = max(min(limit, maxval(e)**2*sum(compressed)), 0.0_wp)
      high = 1.0_wp
      f_high = excess(high)
      if (trouble /= trouble_none .or. f_high <= rounding*sum(abs(compressed))) return
      ! Without a share nothing expands.
      low = 0.0_wp
      f_low = -limit
      do k = 1, 200
         if (f_low >= -rounding*sum(abs(compressed))) exit
         associate (middle => merge((f_high*low - f_low*high)/(f_high - f_low), &
            0.5_wp*(low + high), mod(k, 3) /= 0))
            if (middle <= low .or. middle >= high) exit
            call narrow(middle)
         end associate
         if (trouble /= trouble_none) return
      end do
      f_low = excess(low)

   contains

      !> Take a share as one of the ends of the interval.
      subroutine narrow(share)
         real(wp), intent(in) :: share
         real(wp) :: f

         f = excess(share)
         if (f <= 0.0_wp) then
            low = share
            f_low = f
         else
            high = share
            f_high = f
         end if
      end subroutine narrow

      !> Work of the expansion above its limit, at a share [J].
      real(wp) function excess(share)
         real(wp), intent(in) :: share

         self%share = share
         call self%solve_phase(contacts, links, self%between, &
            share*e*self%compression(4, :), self%expansion, self%after, trouble)
         excess = sum(self%work(self%between, self%after, self%expansion)) - limit
      end function excess

   end subroutine expand

   !> Work of the normal impulse of each contact in a phase [J]: velocities vary linearly in it.
   pure function work(self, first, last, impulse)
      class(together_type), intent(in) :: self
      !> Velocities at its beginning and its end.
      real(wp), intent(in) :: first(:, :), last(:, :)
      real(wp), intent(in) :: impulse(:, :)
      real(wp) :: work(size(self%before, 2))

      work = 0.5_wp*impulse(4, :)*(first(4, :) + last(4, :))
   end function work

   !> Energy that friction takes in both phases [J]: velocities vary linearly in them.
   pure real(wp) function friction_loss(self)
      class(together_type), intent(in) :: self

      friction_loss = -0.5_wp*sum(self%compression(1:3, :)*(self%before(1:3, :) &
         + self%between(1:3, :))) - 0.5_wp*sum(self%expansion(1:3, :)*(self%between(1:3, :) &
         + self%after(1:3, :)))
   end function friction_loss

   !> Speed of approach of a contact, on which its restitution may depend [m/s]: where it does not
   !> approach, that of an impact of its own with the same impulse of compression.
   pure real(wp) function effective_speed(self, i)
      class(together_type), intent(in) :: self
      integer, intent(in) :: i

      effective_speed = -self%before(4, i)
      if (effective_speed <= negligible*self%speed) effective_speed = self%compression(4, i) &
         *self%inverse_mass(4, 4, i, i)
   end function effective_speed

   !> Impulses of compression or of restitution, all contacts at once.
   subroutine solve_phase(self, contacts, links, start, least, impulse, velocity, trouble)
      class(together_type), intent(inout) :: self
      !> All contacts of the mechanism.
      type(contact_type), intent(in) :: contacts(:)
      type(link_type), intent(in) :: links(:)
      !> Velocities at its beginning.
      real(wp), intent(in) :: start(:, :)
      !> Least normal impulses [N s].
      real(wp), intent(in) :: least(:)
      real(wp), intent(out) :: impulse(:, :)
      !> Velocities at its end.
      real(wp), intent(out) :: velocity(:, :)
      !> One of the `trouble_*` codes.
      integer, intent(out) :: trouble
      real(wp) :: old(4, size(links)), older(4, size(links)), last(4), change, ratio
      logical :: rubs(size(links)), solved
      integer :: i, j, k

      call self%solve_frictionless(start, least, impulse, trouble)
      call self%velocities(start, impulse, velocity)
      if (trouble /= trouble_none) return
      do i = 1, size(links)
         rubs(i) = allocated(contacts(links(i)%contact)%law%friction)
      end do
      if (.not. any(rubs)) return
      ! One contact after the other, at the impulses of the others, until nothing changes.
      old = impulse
      do k = 1, most_sweeps
         change = 0.0_wp
         older = old
         old = impulse
         do i = 1, size(links)
            last = impulse(:, i)
            velocity(:, i) = start(:, i)
            do j = 1, size(links)
               if (j /= i) velocity(:, i) = velocity(:, i) + matmul(self%inverse_mass(:, :, i, j), &
                  impulse(:, j))
            end do
            if (rubs(i)) then
               call self%rub(contacts(links(i)%contact), i, velocity(:, i), least(i), &
                  impulse(:, i), solved)
               if (.not. solved) then
                  trouble = trouble_unsettled
                  return
               end if
            else
               impulse(4, i) = max(least(i), -velocity(4, i)/self%inverse_mass(4, 4, i, i))
            end if
            last = matmul(self%inverse_mass(:, :, i, i), impulse(:, i) - last)
            change = max(change, maxval(abs(last([1, 2, 4]))))
         end do
         if (change <= converged*self%speed) exit
         if (mod(k, sweeps_between) > 0) cycle
         ratio = sum((impulse - old)*(old - older))/max(sum((old - older)**2), tiny(ratio))
         if (.not. (ratio > creep .and. ratio < 1.0_wp)) cycle
         impulse = impulse + ratio/(1.0_wp - ratio)*(impulse - old)
         impulse(4, :) = max(impulse(4, :), least)
      end do
      if (k > most_sweeps .and. change > settled*self%speed) trouble = trouble_unsettled
      call self%velocities(start, impulse, velocity)
   end subroutine solve_phase

   !> Normal impulses of a phase without friction. What is added to make the problem definite is
   !> taken out by the solution before: proximal points.
   subroutine solve_frictionless(self, start, least, impulse, trouble)
      class(together_type), intent(in) :: self
      !> Velocities at its beginning.
      real(wp), intent(in) :: start(:, :)
      !> Least normal impulses [N s].
      real(wp), intent(in) :: least(:)
      real(wp), intent(out) :: impulse(:, :)
      !> One of the `trouble_*` codes.
      integer, intent(out) :: trouble
      real(wp) :: matrix(size(least), size(least)), scale(size(least)), q(size(least))
      real(wp) :: z(size(least)), last(size(least)), velocity(4, size(least))
      integer :: i, j, k, n
      logical :: solved

      trouble = trouble_none
      n = size(least)
      do i = 1, n
         scale(i) = 1.0_wp/sqrt(self%inverse_mass(4, 4, i, i))
      end do
      do j = 1, n
         do i = 1, n
            matrix(i, j) = scale(i)*self%inverse_mass(4, 4, i, j)*scale(j)
         end do
         matrix(j, j) = matrix(j, j) + compliance
      end do
      impulse = 0.0_wp
      impulse(4, :) = least
      call self%velocities(start, impulse, velocity)
      q = scale*velocity(4, :)
      z = 0.0_wp
      do k = 1, most_problems
         last = z
         call solve_complementarity(matrix, q - compliance*last, z, solved)
         if (.not. solved) exit
         if (maxval(abs(z - last)) <= 4.0_wp*epsilon(z)*maxval(abs(z))) exit
      end do
      impulse(4, :) = least + scale*z
      call self%velocities(start, impulse, velocity)
      ! Where bodies that do not yield press others together there is no solution.
      if (.not. solved .or. any(velocity(4, :) < -negligible*self%speed)) trouble = trouble_squeezed
   end subroutine solve_frictionless

   !> Impulse of one contact with friction at those of the others.
   subroutine rub(self, contact, i, start, least, impulse, solved)
      class(together_type), intent(in) :: self
      type(contact_type), intent(in) :: contact
      !> Its number in the impact.
      integer, intent(in) :: i
      !> Its velocities without its impulse.
      real(wp), intent(in) :: start(4)
      !> Least normal impulse [N s].
      real(wp), intent(in) :: least
      !> The impulse; a guess on entry.
      real(wp), intent(inout) :: impulse(4)
      logical, intent(out) :: solved
      type(impact_type) :: impact
      real(wp) :: low, high, normal, last, rate, rate_last, slope, next
      integer :: k

      impact%inverse_mass = self%inverse_mass(:, :, i, i)
      impact%before = start
      impact%resolution = self%resolution
      associate (law => contact%law, c => impact%inverse_mass(4, 4))
         impact%a = law%normal%spot_of_impact(c, c*max(self%compression(4, i), impulse(4)))
         normal = max(impulse(4), least)
         low = least
         high = huge(high)
         slope = c
         last = 0.0_wp
         rate_last = 0.0_wp
         do k = 1, most_iterations
            call try(normal, rate)
            if (.not. solved) return
            if (rate >= 0.0_wp .and. normal <= least) exit
            if (abs(rate) <= 0.1_wp*converged*self%speed) exit
            if (rate < 0.0_wp) then
               low = normal
            else
               high = normal
            end if
            if (k > 1 .and. abs(normal - last) > 0.0_wp) slope = (rate - rate_last)/(normal - last)
            if (.not. slope > 0.01_wp*c) slope = 0.01_wp*c
            last = normal
            rate_last = rate
            next = normal - rate/slope
            if (next >= high) next = 0.5_wp*(low + high)
            if (next <= low) next = merge(least, 0.5_wp*(low + min(high, 2.0_wp*normal)), &
               low <= least)
            if (abs(next - normal) <= 0.0_wp) exit
            normal = next
         end do
         solved = k <= most_iterations .or. abs(rate) <= negligible*self%speed
      end associate

   contains

      !> Impulse of friction at a normal impulse, and the rate of the gap after it [m/s].
      subroutine try(normal, rate)
         real(wp), intent(in) :: normal
         real(wp), intent(out) :: rate
         real(wp) :: wrench(3)

         wrench = 0.0_wp
         solved = .true.
         impact%impulse = [0.0_wp, 0.0_wp, 0.0_wp, normal]
         if (normal > 0.0_wp) call solve_stage(impact, contact%law, normal, wrench, &
            solved, .true.)
         impulse(1:3) = normal*wrench
         impulse(4) = normal
         rate = start(4) + dot_product(impact%inverse_mass(4, :), impulse)
      end subroutine try

   end subroutine rub

   !> Velocities after impulses.
   pure subroutine velocities(self, start, impulse, velocity)
      class(together_type), intent(in) :: self
      real(wp), intent(in) :: start(:, :)
      real(wp), intent(in) :: impulse(:, :)
      real(wp), intent(out) :: velocity(:, :)
      integer :: i, j

      do i = 1, size(start, 2)
         velocity(:, i) = start(:, i)
         do j = 1, size(start, 2)
            velocity(:, i) = velocity(:, i) + matmul(self%inverse_mass(:, :, i, j), impulse(:, j))
         end do
      end do
   end subroutine velocities

   !> Velocities at a contact, along major and minor axis, about and along the normal, by unit
   !> impulses at another one or at itself, added to a matrix.
   pure subroutine inverse_mass_between(mechanism, one, other, inverse_mass)
      type(mechanism_type), intent(in) :: mechanism
      !> Kinematics of the contact.
      type(link_type), intent(in) :: one
      !> Where the impulses act.
      type(link_type), intent(in) :: other
      real(wp), intent(inout) :: inverse_mass(4, 4)
      real(wp) :: force(3, 4, 2), torque(3, 4, 2), turned(3), sense
      integer :: i, j, k, m

      call set_axes(one, force(:, :, 1))
      call set_axes(other, force(:, :, 2))
      do k = 1, 2
         if (one%body(k) == 0) cycle
         associate (body => mechanism%bodies(one%body(k)))
            if (body%motion /= motion_free) cycle
            call set_torques(one, k, force(:, :, 1), torque(:, :, 1))
            do m = 1, 2
               if (other%body(m) /= one%body(k)) cycle
               sense = merge(1.0_wp, -1.0_wp, k == m)
               call set_torques(other, m, force(:, :, 2), torque(:, :, 2))
               do j = 1, 4
                  turned = turned_by(torque(:, j, 2), 1.0_wp/body%inertia, &
                     mechanism%pose(one%body(k)))
                  do i = 1, 4
                     inverse_mass(i, j) = inverse_mass(i, j) &
                        + sense*dot_product(force(:, i, 1), force(:, j, 2))/body%mass &
                        + sense*dot_product(torque(:, i, 1), turned)
                  end do
               end do
            end do
         end associate
      end do

   contains

      !> Directions of the forces.
      pure subroutine set_axes(link, force)
         type(link_type), intent(in) :: link
         real(wp), intent(out) :: force(3, 4)

         force(:, 1) = link%at%major
         force(:, 2) = link%minor
         force(:, 3) = 0.0_wp
         force(:, 4) = link%at%normal
      end subroutine set_axes

      !> Torques of unit impulses about the centre of mass of a body.
      pure subroutine set_torques(link, side, force, torque)
         type(link_type), intent(in) :: link
         !> 1 for body A, 2 for body B.
         integer, intent(in) :: side
         real(wp), intent(in) :: force(3, 4)
         real(wp), intent(out) :: torque(3, 4)
         integer :: i

         do i = 1, 4
            torque(:, i) = cross(link%arm(:, side), force(:, i))
            if (i == 3) torque(:, i) = link%at%normal
         end do
      end subroutine set_torques

   end subroutine inverse_mass_between

end module contensou_dynamics_together
