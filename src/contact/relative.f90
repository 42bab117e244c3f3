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
      real(wp) :: m(2, 2), inverse(2, 2), determinant, low, high, c, s, offset, form(3)
      ! Of the six twists, written by components so that they are computed side by side.
      real(wp), dimension(6) :: turned_1, turned_2, moved_1, moved_2, about, along, right_1, right_2
      real(wp), dimension(6) :: xi_a1, xi_a2, xi_b1, xi_b2, tilt_1, tilt_2, d_11, d_12, d_22
      integer :: i

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
         do i = 1, 3
            turned_1(i) = 0.0_wp
            turned_2(i) = 0.0_wp
            turned_1(3 + i) = t(i, 2)
            turned_2(3 + i) = -t(i, 1)
            moved_1(i) = t(i, 1)
            moved_2(i) = t(i, 2)
            moved_1(3 + i) = offset*turned_1(3 + i)
            moved_2(3 + i) = offset*turned_2(3 + i)
            about(i) = 0.0_wp
            along(i) = n(i)
            about(3 + i) = n(i)
            along(3 + i) = 0.0_wp
         end do
         right_1 = turned_1 + (lb(1)*moved_1 + lb(2)*moved_2)
         right_2 = turned_2 + (lb(2)*moved_1 + lb(3)*moved_2)
         xi_a1 = inverse(1, 1)*right_1 + inverse(1, 2)*right_2
         xi_a2 = inverse(2, 1)*right_1 + inverse(2, 2)*right_2
         tilt_1 = la(1)*xi_a1 + la(2)*xi_a2
         tilt_2 = la(2)*xi_a1 + la(3)*xi_a2
         xi_b1 = xi_a1 + g*tilt_1 - moved_1
         xi_b2 = xi_a2 + g*tilt_2 - moved_2
         moved_1 = xi_a1 + frame%share*g*tilt_1
         moved_2 = xi_a2 + frame%share*g*tilt_2
         along = frame%share*along
         do i = 1, 3
            variation%normal(i, :) = tilt_1*t(i, 1) + tilt_2*t(i, 2)
            variation%point(i, :) = moved_1*t(i, 1) + moved_2*t(i, 2) + along*n(i)
         end do
         d_11 = cubic_a(1)*xi_a1 + cubic_a(2)*xi_a2 + cubic_b(1)*xi_b1 + cubic_b(2)*xi_b2 &
            - 2.0_wp*about*lb(2)
         d_12 = cubic_a(2)*xi_a1 + cubic_a(3)*xi_a2 + cubic_b(2)*xi_b1 + cubic_b(3)*xi_b2 &
            + about*(lb(1) - lb(3))
         d_22 = cubic_a(3)*xi_a1 + cubic_a(4)*xi_a2 + cubic_b(3)*xi_b1 + cubic_b(4)*xi_b2 &
            + 2.0_wp*about*lb(2)
         if (high > low) then
            variation%turn = ((c**2 - s**2)*d_12 + c*s*(d_22 - d_11))/(low - high)
            variation%curvature_a = 0.5_wp*(c**2*d_11 + 2.0_wp*c*s*d_12 + s**2*d_22)
            variation%curvature_b = 0.5_wp*(s**2*d_11 - 2.0_wp*c*s*d_12 + c**2*d_22)
         else
            ! The spot is a circle: its axes are fixed to A.
            variation%turn = 0.0_wp
            variation%curvature_a = 0.25_wp*(d_11 + d_22)
            variation%curvature_b = variation%curvature_a
         end if
      end associate
   end subroutine set_variation

end module contensou_contact_relative
