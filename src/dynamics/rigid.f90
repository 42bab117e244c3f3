!> Rigid contacts: the contact as a constraint without compliance, whose normal force follows from
!> the equations of motion.
!>
!> With u the velocity of B against A at the contact point p and n the normal, the gap changes by
!> n.u and its second derivative is
!>    n.(a_B + alpha_B x r_B - a_A - alpha_A x r_A) + n'.u
!>       + n.(w_B x (p' - v_B) - w_A x (p' - v_A)),
!> r the arms from the centres of mass to p. It is linear in the wrench of the contact, and this in
!> the normal force N but for the size of the spot, a ~ N^(1/3) after Hertz.
!> A closed contact has the N at which the second derivative is -2 beta gap' - beta^2 gap: the last
!> two terms hold what rounding and the errors of the integration make of the gap (J. Baumgarte,
!> Comput. Methods Appl. Mech. Eng. 1 (1972) 1).
module contensou_dynamics_rigid
   use contensou_base_kinds, only : wp
   use contensou_base_vectors, only : cross
   use contensou_contact_geometry, only : contact_point_type, contact_variation_type, pose_type, &
      track_type
   use contensou_contact_law, only : contact_law_type
   use contensou_contact_rolling, only : rolling_hysteresis
   implicit none(type, external)
   private

   public :: link_type, set_link, set_load, response, solve_linear, turned_by

   !> A closed rigid contact at a state, inertial frame.
   type :: link_type
      !> Index of the contact.
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
   end type link_type

contains

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

   !> Kinematics of a closed contact; `at`, `body`, `inverse_mass` and `resolution` are set.
   pure subroutine set_link(self, law, track, a, b, inverse_inertia)
      !> The contact.
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
         self%tilt(:, 1) = turned_by(cross(self%arm(:, 1), n), inverse_inertia(:, 1), a)
         self%tilt(:, 2) = turned_by(cross(self%arm(:, 2), n), inverse_inertia(:, 2), b)
         velocity = b%velocity + cross(b%spin, self%arm(:, 2)) - a%velocity &
            - cross(a%spin, self%arm(:, 1))
         self%spin = b%spin - a%spin
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
   end subroutine set_link

   !> Wrench of a contact at a normal force, and its derivative.
   !>
   !> Below N = 0, where an integrator looks for lift-off, the wrench of a point goes on linearly.
   pure subroutine set_load(self, law, normal_force)
      !> The contact, its kinematics set.
      type(link_type), intent(inout) :: self
      type(contact_law_type), intent(in) :: law
      !> Normal force [N].
      real(wp), intent(in) :: normal_force
      real(wp) :: root, a, wrench(3), slopes(3, 5), torque(3)

      self%normal_force = normal_force
      self%wrench(1:3) = normal_force*self%at%normal
      self%wrench(4:6) = 0.0_wp
      self%slope(1:3) = self%at%normal
      self%slope(4:6) = 0.0_wp
      root = 0.0_wp
      if (normal_force > 0.0_wp) root = sqrt(law%normal%approach(normal_force))
      a = law%normal%axis_a*root
      if (allocated(law%friction)) then
         call law%friction%linearize(normal_force, law%normal%shape, a, self%motion(1), &
            self%motion(2), self%motion(3), self%resolution, wrench, slopes)
         if (normal_force > 0.0_wp) slopes(:, 1) = slopes(:, 1) &
            + slopes(:, 2)*(a/(3.0_wp*normal_force))
         self%wrench(1:3) = self%wrench(1:3) + wrench(1)*self%at%major + wrench(2)*self%minor
         self%wrench(4:6) = wrench(3)*self%at%normal
         self%slope(1:3) = self%slope(1:3) + slopes(1, 1)*self%at%major + slopes(2, 1)*self%minor
         self%slope(4:6) = slopes(3, 1)*self%at%normal
      end if
      if (.not. allocated(law%rolling)) return
      if (law%rolling%model /= rolling_hysteresis) then
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
   end subroutine set_load

   !> Second derivative of the gap of one contact by a wrench at another one, or at itself [m/s2].
   pure function response(self, other, wrench) result(acceleration)
      !> The contact.
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

   !> Solve a small system of linear equations by elimination with row pivots.
   pure subroutine solve_linear(n, matrix, right, singular)
      !> Number of unknowns.
      integer, intent(in) :: n
      !> The matrix; overwritten.
      real(wp), intent(inout) :: matrix(:, :)
      !> Right-hand side; the solution on return.
      real(wp), intent(inout) :: right(:)
      !> Whether the matrix is singular to rounding.
      logical, intent(out) :: singular
      real(wp) :: factor, held, largest
      integer :: i, j, k, pivot

      singular = .false.
      largest = maxval(abs(matrix(:n, :n)))
      do k = 1, n
         pivot = k - 1 + maxloc(abs(matrix(k:n, k)), dim=1)
         if (.not. abs(matrix(pivot, k)) > 64.0_wp*epsilon(largest)*n*largest) then
            singular = .true.
            return
         end if
         if (pivot /= k) then
            do j = k, n
               held = matrix(k, j)
               matrix(k, j) = matrix(pivot, j)
               matrix(pivot, j) = held
            end do
            held = right(k)
            right(k) = right(pivot)
            right(pivot) = held
         end if
         do i = k + 1, n
            factor = matrix(i, k)/matrix(k, k)
            do j = k + 1, n
               matrix(i, j) = matrix(i, j) - factor*matrix(k, j)
            end do
            right(i) = right(i) - factor*right(k)
         end do
      end do
      do k = n, 1, -1
         do j = k + 1, n
            right(k) = right(k) - matrix(k, j)*right(j)
         end do
         right(k) = right(k)/matrix(k, k)
      end do
   end subroutine solve_linear

end module contensou_dynamics_rigid
