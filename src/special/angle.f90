!> Angles of unit vectors of the first quadrant, and rotations by small angles, in a few additions
!> and multiplications: kernels that take one on each call spend more on those of the mathematical
!> library than on all else.
!>
!> The square of the smaller component chooses one of some directions, 16 to the octave, whose
!> angles are known; the sine of the rest is a difference of products, and at most 1/60. Errors:
!> 3e-16, in a small angle relative. As it is squares that choose, this does not wait for the roots
!> by which vectors are given length one.
module contensou_special_angle
   use contensou_base_kinds, only : i8, pi, wp
   implicit none(type, external)
   private

   public :: quadrant_angle, small_turn, largest_small

   !> Octaves of the square from 1/2 down, directions in each, and bits of a number behind those
   !> that tell the direction.
   integer, parameter :: octaves = 11, parts = 16, behind = digits(1.0_wp) - 1 - 4

   !> Number of directions next to an axis, the axis and the diagonal among them.
   integer, parameter :: n = octaves*parts + 2

   !> The bits of the square of the first one but the axis.
   integer(i8), parameter :: first = ishft(transfer(0.5_wp**(octaves + 1), 0_i8), -behind)

   integer :: octave, part

   !> Sines, cosines and angles of directions next to the x axis.
   real(wp), parameter :: squares(0:n - 1) = [0.0_wp, &
      ((0.5_wp**(octaves + 1 - octave)*(1.0_wp + (real(part, wp) + 0.5_wp)/real(parts, wp)), &
      part=0, parts - 1), octave=0, octaves - 1), 0.5_wp]
   real(wp), parameter :: sines(0:n - 1) = sqrt(squares), cosines(0:n - 1) = sqrt(1.0_wp - squares)
   real(wp), parameter :: angles(0:n - 1) = asin(sines)

   !> Of these, and of those next to the y axis.
   real(wp), parameter :: along(0:2*n - 1) = [cosines, sines]
   real(wp), parameter :: across(0:2*n - 1) = [sines, cosines]
   real(wp), parameter :: directions(0:2*n - 1) = [angles, 0.5_wp*pi - angles]

   !> Largest angle of a small turn.
   real(wp), parameter :: largest_small = 0.27_wp

contains

   !> Angle from the x axis to a unit vector of the first quadrant, from 0 to pi/2.
   elemental real(wp) function quadrant_angle(x, y, square) result(angle)
      !> Components, >= 0; x^2 + y^2 = 1 to rounding.
      real(wp), intent(in) :: x, y
      !> y^2 from 0 to 1, to some digits.
      real(wp), intent(in) :: square
      real(wp) :: t, t2
      integer :: j

      j = max(int(ishft(transfer(min(square, 1.0_wp - square), first), -behind) - first) + 1, 0) &
         + merge(n, 0, square > 0.5_wp)
      t = y*along(j) - x*across(j)
      t2 = t*t
      ! asin t.
      angle = directions(j) + (t + (t*t2)*((1.0_wp/6.0_wp + t2*(3.0_wp/40.0_wp)) &
         + (t2*t2)*(5.0_wp/112.0_wp + t2*(35.0_wp/1152.0_wp))))
   end function quadrant_angle

   !> Cosine and sine of an angle up to `largest_small`, to rounding.
   elemental subroutine small_turn(angle, cosine, sine)
      real(wp), intent(in) :: angle
      real(wp), intent(out) :: cosine, sine
      real(wp) :: square

      square = angle*angle
      cosine = 1.0_wp - square*(1.0_wp/2.0_wp - square*(1.0_wp/24.0_wp - square*(1.0_wp/720.0_wp &
         - square*(1.0_wp/40320.0_wp - square*(1.0_wp/3628800.0_wp &
         - square*(1.0_wp/479001600.0_wp))))))
      sine = angle*(1.0_wp - square*(1.0_wp/6.0_wp - square*(1.0_wp/120.0_wp &
         - square*(1.0_wp/5040.0_wp - square*(1.0_wp/362880.0_wp &
         - square*(1.0_wp/39916800.0_wp))))))
   end subroutine small_turn

end module contensou_special_angle
