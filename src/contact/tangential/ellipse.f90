!> Table of sliding on elliptic spots that are not needles.
!>
!> With the names of `contensou_contact_tangential_abreast`: R_bb B^2 and R_ab A B times
!> (sqrt(k) W + rho)/W^2 are analytic in x = rho/(sqrt(k) W + rho). They are tabulated by k
!> (scripts/generate_ellipse.py), and a part of the table is made for the k of a spot where it is
!> needed first, by `contensou_contact_tangential_ellipse_pass`.
module contensou_contact_tangential_ellipse
   use contensou_base_kinds, only : wp
   use contensou_contact_tangential_ellipse_values, only : bands, degree, least_ratio, parts
   use contensou_contact_tangential_limit_values, only : bulges
   implicit none(type, external)
   private

   public :: ellipse_type, least_ratio, last_pair, round_bulge

   !> The last pair of an even and an odd power of a polynomial, the first one is zero.
   integer, parameter :: last_pair = shiftr(degree, 1)

   !> That of a circle.
   real(wp), parameter :: round_bulge(9) = bulges(0, :) + bulges(1, :) + bulges(2, :)

   !> What a spot keeps of the table.
   type :: ellipse_type
      !> Axis ratio for which it is made, its square, one less that, and its root.
      real(wp) :: k = 0.0_wp, k2 = 0.0_wp, c = 0.0_wp, root_k = 0.0_wp
      !> Part of the interval of ln k, and the place there, from -1 to 1.
      integer :: band = 0
      real(wp) :: place = 0.0_wp
      !> Coefficients of the limits of its shells, as of `bulges`.
      real(wp) :: bulge(9) = 0.0_wp
      !> Which parts are made.
      logical :: made(0:parts - 1) = .false.
      !> The two functions: even powers of x of both, then the odd ones.
      real(wp) :: table(4, 0:last_pair, 0:parts - 1) = 0.0_wp
   contains
      procedure :: set_ratio
   end type ellipse_type

   !> Length of a part of the interval of ln k.
   real(wp), parameter :: band_width = -log(least_ratio)/real(bands, wp)

contains

   !> Set the axis ratio, unless it is that of the call before.
   pure subroutine set_ratio(self, k, k2, c)
      class(ellipse_type), intent(inout) :: self
      !> Axis ratio, not below the least one, its square, and one less that.
      real(wp), intent(in) :: k, k2, c
      real(wp) :: place

      if (abs(self%k - k) <= 0.0_wp) return
      self%k = k
      self%k2 = k2
      self%c = c
      self%root_k = sqrt(k)
      place = -log(k)*(1.0_wp/band_width)
      self%band = min(int(place), bands - 1)
      self%place = 1.0_wp - 2.0_wp*(place - real(self%band, wp))
      self%bulge = bulges(0, :) + k*(bulges(1, :) + k*bulges(2, :))
      self%made = .false.
   end subroutine set_ratio

end module contensou_contact_tangential_ellipse
