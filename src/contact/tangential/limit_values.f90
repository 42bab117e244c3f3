!> Limits of shells of elliptic spots, about. Written by scripts/generate_limit.py, which explains
!> them.
module contensou_contact_tangential_limit_values
   use contensou_base_kinds, only : wp
   implicit none(type, external)
   private

   !> Coefficients of B, of x, y, x^2, x y, y^2, x^3, x^2 y, x y^2 and y^3, by powers of the axis
   !> ratio.
   real(wp), parameter, public :: bulges(0:2, 9) = reshape([ &
      -0.485_wp, 3.598_wp, -1.795_wp, &
      2.142_wp, -0.753_wp, -0.035_wp, &
      0.139_wp, -4.838_wp, 3.825_wp, &
      -1.097_wp, -1.439_wp, 0.154_wp, &
      -2.976_wp, 2.536_wp, -0.665_wp, &
      0.222_wp, 1.644_wp, -1.228_wp, &
      -0.284_wp, 3.177_wp, -0.264_wp, &
      0.689_wp, 5.691_wp, -3.696_wp, &
      6.220_wp, -8.224_wp, 2.820_wp], [3, 9])

end module contensou_contact_tangential_limit_values
