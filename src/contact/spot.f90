!> Shape of the contact spot, an ellipse x^2/a^2 + y^2/b^2 <= 1 with b <= a, and the constants that
!> the friction kernels need of it.
!>
!> B and D are the complete elliptic integrals B = (E - c1 K)/c, D = (K - E)/c of the parameter
!> c = 1 - (b/a)^2; on a circle both are pi/4. The moments j11 = (D - B)/c and
!> j20 = (B - k^2 D)/(3 c) cancel near the circle; there the Fourier series of
!> 1/sqrt(cos^2 + k^2 sin^2) gives, with h = ((1 - k)/(1 + k))^2,
!>    j11 = pi S(h)/(1 + k)^3,   S(h) = sum_j b_j b_(j+1) h^j,   b_j = (1/2)_j/j!,
!>    j20 = (B + D - (1 + k^2) j11)/6.
module contensou_contact_spot
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite, ieee_quiet_nan, ieee_value
   use contensou_base_kinds, only : wp, pi
   use contensou_special_elliptic, only : complete_elliptic_bd
   implicit none(type, external)
   private

   public :: spot_shape_type, circular_shape, elliptic_shape, elliptic_shape_of_c1

   !> Constants of an elliptic spot; all of them dimensionless.
   type :: spot_shape_type
      !> Axis ratio k = b/a, in (0, 1].
      real(wp) :: k
      !> k^2, the complementary parameter c1.
      real(wp) :: k2
      real(wp) :: inverse_k2
      !> Parameter c = 1 - k^2.
      real(wp) :: c
      !> Slope of the force along the major axis at rest, k_x = (3/2) D.
      real(wp) :: slope_x
      !> Slope of the force along the minor axis at rest, k_y = (3/2) B.
      real(wp) :: slope_y
      !> Torque of pure spinning, k_T = (3/8) E.
      real(wp) :: torque
      !> Complete elliptic integral B.
      real(wp) :: b_integral
      !> Complete elliptic integral D.
      real(wp) :: d_integral
      !> Complete elliptic integral of the second kind, E = B + k^2 D.
      real(wp) :: e_integral
      !> Moment (D - B)/c.
      real(wp) :: j11
      !> Moment (B - k^2 D)/(3 c).
      real(wp) :: j20
      !> Moment j20/k^2.
      real(wp) :: j02
   end type spot_shape_type

   !> Makes a shape from the ratio of its axes.
   interface spot_shape_type
      procedure :: elliptic_shape
   end interface spot_shape_type

   !> The circle.
   type(spot_shape_type), parameter :: circular_shape = spot_shape_type( &
      k=1.0_wp, k2=1.0_wp, inverse_k2=1.0_wp, c=0.0_wp, &
      slope_x=3.0_wp*pi/8.0_wp, slope_y=3.0_wp*pi/8.0_wp, torque=3.0_wp*pi/16.0_wp, &
      b_integral=pi/4.0_wp, d_integral=pi/4.0_wp, e_integral=pi/2.0_wp, &
      j11=pi/16.0_wp, j20=pi/16.0_wp, j02=pi/16.0_wp)

   !> Smallest axis ratio whose square and inverse square are safe in the kernels.
   real(wp), parameter :: smallest_ratio = 1.0e-60_wp

   !> The series S(h) is used up to this h, where its first neglected term is 3e-18.
   real(wp), parameter :: largest_h = 0.05_wp

   !> Coefficients b_j b_(j+1) of the series S(h).
   real(wp), parameter :: series(0:11) = [ &
      0.5_wp, 0.1875_wp, 0.1171875_wp, 0.08544921875_wp, &
      0.067291259765625_wp, 0.055515289306640625_wp, 0.047254085540771484375_wp, &
      0.04113636910915374755859_wp, 0.03642282681539654731750_wp, &
      0.03267936961492523550987_wp, 0.02963424653717083856463_wp, &
      0.02710860052548014209606_wp]

contains

   !> Shape of an ellipse with a given ratio of its axes.
   pure function elliptic_shape(k) result(shape)
      !> Axis ratio k = b/a, from 1e-60 to 1; otherwise all constants are NaN.
      real(wp), intent(in) :: k
      type(spot_shape_type) :: shape

      call fill(shape, k, k*k)
   end function elliptic_shape

   !> Shape of an ellipse with a given complementary parameter.
   pure function elliptic_shape_of_c1(c1) result(shape)
      !> Complementary parameter c1 = (b/a)^2, from 1e-120 to 1; otherwise all constants are NaN.
      real(wp), intent(in) :: c1
      type(spot_shape_type) :: shape
      logical :: valid

      ! Before any comparison: comparing a NaN raises an exception, as does a negative root.
      valid = ieee_is_finite(c1)
      if (valid) valid = c1 >= 0.0_wp
      if (valid) then
         call fill(shape, sqrt(c1), c1)
      else
         call fill(shape, 0.0_wp, 0.0_wp)
      end if
   end function elliptic_shape_of_c1

   !> Fill in the constants of a shape.
   pure subroutine fill(shape, k, k2)
      type(spot_shape_type), intent(out) :: shape
      !> Axis ratio.
      real(wp), intent(in) :: k
      !> Its square.
      real(wp), intent(in) :: k2
      real(wp) :: b, d, h, s, nan
      integer :: j
      logical :: valid

      valid = ieee_is_finite(k)
      if (valid) valid = k >= smallest_ratio .and. k <= 1.0_wp
      if (.not. valid) then
         nan = ieee_value(k, ieee_quiet_nan)
         shape = spot_shape_type(nan, nan, nan, nan, nan, nan, nan, nan, nan, nan, nan, nan, nan)
         return
      end if
      call complete_elliptic_bd(k2, b, d)
      shape%k = k
      shape%k2 = k2
      shape%inverse_k2 = 1.0_wp/k2
      shape%c = (1.0_wp - k)*(1.0_wp + k)
      shape%slope_x = 1.5_wp*d
      shape%slope_y = 1.5_wp*b
      shape%b_integral = b
      shape%d_integral = d
      shape%e_integral = b + k2*d
      shape%torque = 0.375_wp*shape%e_integral
      h = ((1.0_wp - k)/(1.0_wp + k))**2
      if (h <= largest_h) then
         s = series(11)
         do j = 10, 0, -1
            s = series(j) + h*s
         end do
         shape%j11 = pi*s/(1.0_wp + k)**3
         shape%j20 = ((b + d) - (1.0_wp + k2)*shape%j11)/6.0_wp
      else
         shape%j11 = (d - b)/shape%c
         shape%j20 = (b - k2*d)/(3.0_wp*shape%c)
      end if
      shape%j02 = shape%j20*shape%inverse_k2
   end subroutine fill

end module contensou_contact_spot
