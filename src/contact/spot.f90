!> Shape of the contact spot, an ellipse x^2/a^2 + y^2/b^2 <= 1 with b <= a, and the constants that
!> the friction kernels need of it.
!>
!> B and D are the complete elliptic integrals B = (E - c1 K)/c, D = (K - E)/c of the parameter
!> c = 1 - (b/a)^2; on a circle both are pi/4.
module contensou_contact_spot
   use contensou_base_kinds, only : wp, pi
   implicit none(type, external)
   private

   public :: spot_shape_type, circular_shape

   !> Constants of an elliptic spot; all of them dimensionless.
   type :: spot_shape_type
      !> Axis ratio k = b/a, in (0, 1].
      real(wp) :: k
      !> k^2, the complementary parameter c1.
      real(wp) :: k2
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

   !> The circle.
   type(spot_shape_type), parameter :: circular_shape = spot_shape_type( &
      k=1.0_wp, k2=1.0_wp, c=0.0_wp, &
      slope_x=3.0_wp*pi/8.0_wp, slope_y=3.0_wp*pi/8.0_wp, torque=3.0_wp*pi/16.0_wp, &
      b_integral=pi/4.0_wp, d_integral=pi/4.0_wp, e_integral=pi/2.0_wp, &
      j11=pi/16.0_wp, j20=pi/16.0_wp, j02=pi/16.0_wp)

end module contensou_contact_spot
