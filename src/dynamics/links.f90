!> Links: what a rigid contact is at a state, and what its load does.
!>
!> With u the velocity of B against A at the contact point p and n the normal, the gap changes by
!> n.u and its second derivative is
!>    n.(a_B + alpha_B x r_B - a_A - alpha_A x r_A) + n'.u
!>       + n.(w_B x (p' - v_B) - w_A x (p' - v_A)),
!> r the arms from the centres of mass to p. It is linear in the wrench of the contact, and this in
!> the normal force N but for the size of the spot, a ~ N^(1/3) after Hertz.
module contensou_dynamics_links
   use contensou_base_kinds, only : wp
   use contensou_base_vectors, only : cross
   use contensou_contact_creep_law, only : passing_type
   use contensou_contact_friction_law, only : sliding_type
   use contensou_contact_geometry, only : contact_motion_type, contact_point_type, &
      contact_variation_type, pose_type, rolling_velocity, search_trouble, track_type, trouble_none
   use contensou_contact_law, only : contact_law_type
   use contensou_contact_states, only : most_states
   use contensou_dynamics_mechanism, only : contact_type, mechanism_type, relative_motion
   use contensou_dynamics_scene, only : motion_free
   use contensou_dynamics_state, only : spin_of, velocity_of
   implicit none(type, external)
   private

   !> Relative step of differences by the normal force.
   real(wp), parameter :: step = 1.0e-6_wp

   public :: link_type, find_link, set_kinematics, set_load, set_state_rates, response, &
      normal_response, turned_by

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
      !> With tangential elasticity: velocity of the material through the spot along the axes [m/s].
      real(wp) :: carried(2) = 0.0_wp
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
         if (allocated(contact%tangential)) call find_carried(link, contact, a, b)
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
         ! What presses bodies together that fall alike comes from below.
         if (all(link%inverse_mass > 0.0_wp)) link%pace = link%pace &
            + norm2(mechanism%gravity)*2.0_wp*link%at%curvature_b
         link%stabilisation = 2.0_wp*sqrt(link%pace)*link%rate + link%pace*link%at%gap
      end associate
   end subroutine find_link

   !> Velocity of the material through the spot, without what only shears it.
   pure subroutine find_carried(self, contact, a, b)
      !> The contact, its kinematics set.
      type(link_type), intent(inout) :: self
      type(contact_type), intent(in) :: contact
      type(pose_type), intent(in) :: a
      type(pose_type), intent(in) :: b
      type(contact_variation_type) :: variation
      real(wp), parameter :: still(3) = 0.0_wp
      real(wp) :: carried(3)

      call contact%law%geometry%vary(a, b, contact%track, self%at, variation)
      carried = rolling_velocity(variation, still, self%spin)
      self%carried = [dot_product(carried, self%at%major), dot_product(carried, self%minor)]
   end subroutine find_carried

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
         self%tilt = 0.0_wp
         if (self%inverse_mass(1) > 0.0_wp) self%tilt(:, 1) = turned_by( &
            cross(self%arm(:, 1), n), inverse_inertia(:, 1), a)
         if (self%inverse_mass(2) > 0.0_wp) self%tilt(:, 2) = turned_by( &
            cross(self%arm(:, 2), n), inverse_inertia(:, 2), b)
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
      !> The same; what its tangential elasticity last evaluated is changed.
      type(contact_type), intent(inout) :: contact
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
            if (allocated(contact%tangential)) then
               call hold_at_states(self, contact, normal_force, wrench, slopes)
            else if (contact%states%n == 0) then
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
         if (allocated(contact%tangential)) call avoid_jam(self)
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

   !> Wrench of tangential elasticity, and its derivative by the normal force: none without a load.
   pure subroutine hold_at_states(self, contact, normal_force, wrench, slopes)
      !> The contact, its kinematics set.
      type(link_type), intent(in) :: self
      type(contact_type), intent(inout) :: contact
      !> Normal force [N].
      real(wp), intent(in) :: normal_force
      real(wp), intent(out) :: wrench(3)
      !> Only the derivative by the normal force is set, and that by the size, which is part of it.
      real(wp), intent(out) :: slopes(3, 5)
      real(wp) :: local(most_states), rates(most_states), more(3)

      wrench = 0.0_wp
      slopes = 0.0_wp
      if (.not. normal_force > 0.0_wp) return
      local = contact%local_states(self%at)
      associate (n => contact%states%n_local, law => contact%law)
         call contact%tangential%evolve(law%friction, law%normal%shape, rolls_of(self, contact, &
            normal_force*(1.0_wp + step)), local(:n), more, rates(:n))
         call contact%tangential%evolve(law%friction, law%normal%shape, rolls_of(self, contact, &
            normal_force), local(:n), wrench, rates(:n))
      end associate
      slopes(:, 1) = (more - wrench)/(step*normal_force)
   end subroutine hold_at_states

   !> What slips all over at a small normal force may stick at a larger one: where friction that
   !> grows with the force would press the bodies together, the force goes on without it.
   pure subroutine avoid_jam(self)
      type(link_type), intent(inout) :: self

      if (response(self, self, self%slope) > 0.0_wp) return
      self%slope(1:3) = self%at%normal
      self%slope(4:6) = 0.0_wp
   end subroutine avoid_jam

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

   !> The same, and what rolls through the spot.
   pure function rolls_of(self, contact, normal_force) result(rolls)
      type(link_type), intent(in) :: self
      type(contact_type), intent(in) :: contact
      !> Normal force [N].
      real(wp), intent(in) :: normal_force
      type(passing_type) :: rolls

      rolls = passing_type(slides_of(self, contact, normal_force), self%carried(1), self%carried(2))
   end function rolls_of

   !> Rates of the states of the parts of a closed contact, its normal force known.
   subroutine set_state_rates(self, contact, a, b)
      type(link_type), intent(in) :: self
      type(contact_type), intent(inout) :: contact
      type(pose_type), intent(in) :: a
      type(pose_type), intent(in) :: b
      type(contact_variation_type) :: variation
      real(wp) :: wrench(3), local(most_states), rates(most_states)

      local = contact%local_states(self%at)
      associate (n => contact%states%n_local)
         if (allocated(contact%tangential)) then
            call contact%tangential%evolve(contact%law%friction, contact%law%normal%shape, &
               rolls_of(self, contact, self%normal_force), local(:n), wrench, rates(:n))
         else
            call contact%law%friction%evolve(contact%law%normal%shape, &
               slides_of(self, contact, self%normal_force), local(:n), wrench, rates(:n))
         end if
         if (contact%states%tangent) call contact%law%geometry%vary(a, b, contact%track, self%at, &
            variation)
         call contact%set_rates(a, b, contact_motion_type(self%at, self%slip() &
            + self%rate*self%at%normal, self%spin), rates(:n), variation)
      end associate
   end subroutine set_state_rates

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

end module contensou_dynamics_links
