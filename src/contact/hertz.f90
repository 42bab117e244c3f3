!> Hertz contact of elastic bodies whose spot is a circle.
!>
!> Undeformed gap h = A (x^2 + y^2), relative radius R = 1/(2A):
!> N = (4/3) E* sqrt(R) d^(3/2), a = sqrt(R d), p0 = 3 N/(2 pi a^2).
!> H. Hertz, J. reine angew. Math. 92 (1881) 156; K. L. Johnson, Contact Mechanics, 1985, ch. 4.
module contensou_contact_hertz
   use contensou_base_kinds, only : wp
   implicit none(type, external)
   private

   public :: effective_modulus, hertz_circle_stiffness

contains

   !> Effective modulus of two materials [Pa], 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2.
   pure function effective_modulus(young_a, poisson_a, young_b, poisson_b) result(modulus)
      !> Young's modulus of the first material [Pa], > 0.
      real(wp), intent(in) :: young_a
      !> Poisson's ratio of the first material, in (-1, 0.5].
      real(wp), intent(in) :: poisson_a
      !> Young's modulus of the second material [Pa], > 0.
      real(wp), intent(in) :: young_b
      !> Poisson's ratio of the second material, in (-1, 0.5].
      real(wp), intent(in) :: poisson_b
      real(wp) :: modulus

      modulus = 1.0_wp/((1.0_wp - poisson_a**2)/young_a + (1.0_wp - poisson_b**2)/young_b)
   end function effective_modulus

   !> Stiffness k_n of N = k_n d^(3/2) on a circular spot [N/m^(3/2)].
   pure function hertz_circle_stiffness(modulus, radius) result(stiffness)
      !> Effective modulus E* [Pa], > 0.
      real(wp), intent(in) :: modulus
      !> Relative radius of curvature R [m], > 0.
      real(wp), intent(in) :: radius
      real(wp) :: stiffness

      stiffness = (4.0_wp/3.0_wp)*modulus*sqrt(radius)
   end function hertz_circle_stiffness

end module contensou_contact_hertz
