!> Relative curvature of two surfaces at their closest points, and its variation.
!>
!> With the forms L_A, L_B of the two surfaces in one basis of tangents, the undeformed separation
!> is (1/2) x.(L_A + L_B) x, so that 2A and 2B are the eigenvalues of L_A + L_B.
module contensou_contact_relative
   use contensou_base_kinds, only : wp
   use contensou_contact_geometry, only : contact_point_type, contact_variation_type
   implicit none(type, external)
   private

   public :: contact_frame_type, set_curvatures, set_variation, joint_form

   !> Two surfaces at their closest points, inertial frame.
   type :: contact_frame_type
      !> Signed distance [m].
      real(wp) :: gap
      !> Contact point [m].
      real(wp) :: point(3)
      !> Common unit normal from A into B.
      real(wp) :: normal(3)
      !> Orthonormal tangents; tangent 2 is normal x tangent 1.
      real(wp) :: tangent(3, 2)
      !> Form of surface A: components 11, 12, 22 [1/m].
      real(wp) :: first(3)
      !> Form of surface B [1/m].
      real(wp) :: second(3)
      !> Where between the closest points the contact point lies: 0 on A, 1 on B.
      real(wp) :: share
   end type contact_frame_type

   !> Relative difference of the curvatures up to which a spot is a circle.
   real(wp), parameter :: circle = 16.0_wp*epsilon(1.0_wp)

contains

   !> Eigenvalues of a symmetric matrix of order two, and the eigenvector of the smaller.
   pure subroutine principal_of(form, low, high, c, s)
      !> Components 11, 12, 22.
      real(wp), intent(in) :: form(3)
      !> Smaller eigenvalue.
      real(wp), intent(out) :: low
      !> Larger eigenvalue.
      real(wp), intent(out) :: high
      !> First component of the eigenvector of the smaller one.
      real(wp), intent(out) :: c
      !> Second component.
      real(wp), intent(out) :: s
      real(wp) :: mean, half, radius

      mean = 0.5_wp*(form(1) + form(3))
      half = 0.5_wp*(form(1) - form(3))
      radius = sqrt(half**2 + form(2)**2)
      if (radius <= circle*abs(mean)) then
         low = mean
         high = mean
         c = 1.0_wp
         s = 0.0_wp
         return
      end if
      low = mean - radius
      high = mean + radius
      ! Half of the angle whose cosine is -half/radius and whose sine is -form(2)/radius.
      if (half <= 0.0_wp) then
         c = sqrt(0.5_wp*(1.0_wp - half/radius))
         s = -0.5_wp*form(2)/(radius*c)
      else
         s = sqrt(0.5_wp*(1.0_wp + half/radius))
         c = -0.5_wp*form(2)/(radius*s)
      end if
   end subroutine principal_of

   !> Matrix L_A + L_B + g L_B L_A of the shift of closest points, see `set_variation`.
   pure function joint_form(a, b, gap) result(m)
      !> Forms of the two surfaces: components 11, 12, 22 [1/m].
      real(wp), intent(in) :: a(3), b(3)
      !> Their distance [m].
      real(wp), intent(in) :: gap
      real(wp) :: m(2, 2)

      m(1, 1) = a(1) + b(1) + gap*(b(1)*a(1) + b(2)*a(2))
      m(1, 2) = a(2) + b(2) + gap*(b(1)*a(2) + b(2)*a(3))
      m(2, 1) = a(2) + b(2) + gap*(b(2)*a(1) + b(3)*a(2))
      m(2, 2) = a(3) + b(3) + gap*(b(2)*a(2) + b(3)*a(3))
   end function joint_form

   !> Curvatures A, B and the major axis.
   pure subroutine set_curvatures(frame, at)
      type(contact_frame_type), intent(in) :: frame
      type(contact_point_type), intent(inout) :: at
      real(wp) :: low, high, c, s

      call principal_of(frame%first + frame%second, low, high, c, s)
      at%curvature_a = 0.5_wp*low
      at%curvature_b = 0.5_wp*high
      at%major = c*frame%tangent(:, 1) + s*frame%tangent(:, 2)
   end subroutine set_curvatures

   !> First-order response to a twist of B, A at rest.
   !>
   !> Let the point of B at the contact point move by u and B turn by theta. The closest points
   !> shift on their surfaces by xi_A and xi_B; with the normal dn = L_A xi_A and the offset e of
   !> the closest point of B from the contact point along the normal,
   !> (L_A + L_B + g L_B L_A) xi_A = theta x n + L_B (u + e theta x n) in the tangent plane and
   !> xi_B = (1 + g L_A) xi_A - u - e theta x n. The form changes by the cubic forms along the
   !> shifts and by the turn of B about the normal.
   pure subroutine set_variation(frame, cubic_a, cubic_b, variation)
      type(contact_frame_type), intent(in) :: frame
      !> Derivative of the form of A: components 111, 112, 122, 222 [1/m2].
      real(wp), intent(in) :: cubic_a(4)
      !> Derivative of the form of B [1/m2].
      real(wp), intent(in) :: cubic_b(4)
      type(contact_variation_type), intent(out) :: variation
      real(wp) :: m(2, 2), inverse(2, 2), determinant, low, high, c, s, offset, turned(2), moved(2)
      real(wp) :: right(2), xi_a(2), xi_b(2), tilt(2), form(3), change(3), about, along, lead
      real(wp) :: d_low, d_high, d_mixed
      integer :: j

      associate (g => frame%gap, la => frame%first, lb => frame%second, &
         t => frame%tangent, n => frame%normal)
         form = la + lb
         call principal_of(form, low, high, c, s)
         m = joint_form(la, lb, g)
         determinant = m(1, 1)*m(2, 2) - m(1, 2)*m(2, 1)
         inverse(1, 1) = m(2, 2)/determinant
         inverse(1, 2) = -m(1, 2)/determinant
         inverse(2, 1) = -m(2, 1)/determinant
         inverse(2, 2) = m(1, 1)/determinant
         offset = (1.0_wp - frame%share)*g
         do j = 1, 6
            if (j <= 3) then
               turned = 0.0_wp
               moved = t(j, :)
               about = 0.0_wp
               along = n(j)
               right = 0.0_wp
            else
               turned = [t(j - 3, 2), -t(j - 3, 1)]
               moved = offset*turned
               about = n(j - 3)
               along = 0.0_wp
               right = turned
            end if
            right = right + apply(lb, moved)
            xi_a(1) = inverse(1, 1)*right(1) + inverse(1, 2)*right(2)
            xi_a(2) = inverse(2, 1)*right(1) + inverse(2, 2)*right(2)
            tilt = apply(la, xi_a)
            xi_b = xi_a + g*tilt - moved
            variation%normal(:, j) = tilt(1)*t(:, 1) + tilt(2)*t(:, 2)
            moved = xi_a + frame%share*g*tilt
            lead = frame%share*along
            variation%point(:, j) = moved(1)*t(:, 1) + moved(2)*t(:, 2) + lead*n
            change(1) = cubic_a(1)*xi_a(1) + cubic_a(2)*xi_a(2) + cubic_b(1)*xi_b(1) &
               + cubic_b(2)*xi_b(2) - 2.0_wp*about*lb(2)
            change(2) = cubic_a(2)*xi_a(1) + cubic_a(3)*xi_a(2) + cubic_b(2)*xi_b(1) &
               + cubic_b(3)*xi_b(2) + about*(lb(1) - lb(3))
            change(3) = cubic_a(3)*xi_a(1) + cubic_a(4)*xi_a(2) + cubic_b(3)*xi_b(1) &
               + cubic_b(4)*xi_b(2) + 2.0_wp*about*lb(2)
            if (high > low) then
               d_low = c**2*change(1) + 2.0_wp*c*s*change(2) + s**2*change(3)
               d_high = s**2*change(1) - 2.0_wp*c*s*change(2) + c**2*change(3)
               d_mixed = (c**2 - s**2)*change(2) + c*s*(change(3) - change(1))
               variation%turn(j) = d_mixed/(low - high)
            else
               ! The spot is a circle: its axes are fixed to A.
               d_low = 0.5_wp*(change(1) + change(3))
               d_high = d_low
               variation%turn(j) = 0.0_wp
            end if
            variation%curvature_a(j) = 0.5_wp*d_low
            variation%curvature_b(j) = 0.5_wp*d_high
         end do
      end associate

   contains

      !> Product of a form and a tangent vector.
      pure function apply(l, v) result(w)
         !> Components 11, 12, 22.
         real(wp), intent(in) :: l(3)
         !> The vector.
         real(wp), intent(in) :: v(2)
         real(wp) :: w(2)

         w(1) = l(1)*v(1) + l(2)*v(2)
         w(2) = l(2)*v(1) + l(3)*v(2)
      end function apply

   end subroutine set_variation

end module contensou_contact_relative
