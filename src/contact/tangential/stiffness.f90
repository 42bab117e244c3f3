!> Tangential and torsional stiffness of an elliptic Hertz spot on which nothing slips.
!>
!> With the semi-axes a >= b, k = b/a, the integrals B, D and the moments j11, j20 of the spot for
!> the parameter c = 1 - k^2,
!>    k_x = pi G a/[(1 - nu) B + D],   k_y = pi G a/[B + (1 - nu) D]
!> along the major and the minor axis (R. Mindlin, J. Appl. Mech. 16 (1949) 259). Torsion: tractions
!> (-alpha y, beta x)/sqrt(1 - r^2) turn the spot rigidly, which determines alpha and beta;
!>    k_T = (pi/3) G a^3 (p + k^2 r - 2 k^2 q)/(p r - k^2 q^2),
!>    p = (1 - nu) B + 3 nu j20,   q = nu j11,   r = (1 - nu) D + 3 nu j20.
!> Circle: 4 G a/(2 - nu) and (8/3) G a^3. For two bodies 1/G = (1/G1 + 1/G2)/2 and nu/G =
!> (nu1/G1 + nu2/G2)/2. Derivation, accuracy: docs/tangential.md.
module contensou_contact_tangential_stiffness
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite, ieee_quiet_nan, ieee_value
   use contensou_base_kinds, only : pi, wp
   use contensou_contact_spot, only : spot_shape_type
   implicit none(type, external)
   private

   public :: tangential_stiffness

contains

   !> Stiffness of a spot.
   pure subroutine tangential_stiffness(shape, a, modulus, poisson, stiffness)
      type(spot_shape_type), intent(in) :: shape
      !> Major semi-axis [m], >= 0.
      real(wp), intent(in) :: a
      !> Shear modulus G of both bodies together [Pa], >= 0.
      real(wp), intent(in) :: modulus
      !> Poisson's ratio of both together, from -1 to 1/2.
      real(wp), intent(in) :: poisson
      !> k_x, k_y [N/m] and k_T [N m]; NaN outside the domain.
      real(wp), intent(out) :: stiffness(3)
      real(wp) :: p, q, r, rest
      logical :: valid

      valid = ieee_is_finite(a) .and. ieee_is_finite(modulus) .and. ieee_is_finite(poisson) .and. &
         ieee_is_finite(shape%k)
      if (valid) valid = a >= 0.0_wp .and. modulus >= 0.0_wp .and. poisson >= -1.0_wp .and. &
         poisson <= 0.5_wp
      if (.not. valid) then
         stiffness = ieee_value(a, ieee_quiet_nan)
         return
      end if
      rest = 1.0_wp - poisson
      stiffness(1) = pi*modulus*a/(rest*shape%b_integral + shape%d_integral)
      stiffness(2) = pi*modulus*a/(shape%b_integral + rest*shape%d_integral)
      p = rest*shape%b_integral + 3.0_wp*poisson*shape%j20
      q = poisson*shape%j11
      r = rest*shape%d_integral + 3.0_wp*poisson*shape%j20
      stiffness(3) = (pi/3.0_wp)*modulus*a**3*(p + shape%k2*(r - 2.0_wp*q))/(p*r - shape%k2*q*q)
   end subroutine tangential_stiffness

end module contensou_contact_tangential_stiffness
