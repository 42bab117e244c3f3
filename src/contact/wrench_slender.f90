!> Friction of a curved spot whose chords are flat: the rung `slender` of the quadrature of
!> `contensou_contact_wrench_curved`, for spots as of a ball in a groove.
!>
!> The rise changes least along the chords, in a slender spot by the share (L_22/L_11)(b/a)^2 of
!> what it is. With its mean along the chord in place of it the slip is a + b t there, with complex
!> a and b and t from -1 to 1, and the mean friction over the chord is a function of a/b alone, in
!> two variables, which is tabulated (scripts/generate_slender.py). What is left is one integral
!> across the chords. Accuracy and cost: docs/curved_spot.md.
!>
!> Across the chords the integrand is steep next to the zeros of a, over a distance that b tells; on
!> both sides of them Gauss nodes are placed in asinh of it.
module contensou_contact_wrench_slender
   use contensou_base_kinds, only : wp
   use contensou_contact_wrench_curved_chord, only : field_type, n_wrench, solve
   use contensou_contact_wrench_slender_values, only : n_s, n_u, splines
   use contensou_special_quadrature, only : w_4, x_4
   implicit none(type, external)
   private

   public :: wrench_slender

   !> Chords of a part of a spot, in two halves, and of all four parts.
   integer, parameter :: half_part = 4, most_chords = 8*half_part

   !> Mean of t^2 along a chord under the pressure.
   real(wp), parameter :: quarter = 0.25_wp

   !> Factor of the means along a chord: (3/(2 pi)) (pi/2).
   real(wp), parameter :: factor = 0.75_wp

   !> Distances over which the integrand across the chords may be steep.
   real(wp), parameter :: narrowest = 1.0e-2_wp, widest = 1.0_wp

   !> Distance of two zeros over that up to which they are one.
   real(wp), parameter :: one_place = 0.1_wp

   !> Least ratio of b to a.
   real(wp), parameter :: least_turn = 1.0e-8_wp

contains

   !> Wrench along q and across it.
   pure subroutine wrench_slender(field, sums)
      type(field_type), intent(in) :: field
      real(wp), intent(out) :: sums(n_wrench)
      real(wp) :: u(most_chords), weight(most_chords)
      integer :: n

      call place_chords(field, u, weight, n)
      sums = 0.0_wp
      call add_slender(field, u, weight, n, sums)
   end subroutine wrench_slender

   !> Places and weights of the chords.
   pure subroutine place_chords(field, u, weight, n)
      type(field_type), intent(in) :: field
      real(wp), intent(out) :: u(most_chords), weight(most_chords)
      !> Their number.
      integer, intent(out) :: n
      real(wp) :: a(2), b(2), c, zero(2, 2), place(2), width(2), spin, slope
      integer :: zeros, i

      ! The slip in the middle of the chords, along q and across it, is a + b u + c u^2.
      a = [field%g(1) + quarter*field%g(5), field%p(1)]
      b = [field%g(2), field%p(2)]
      c = field%g(4) - quarter*field%g(5)
      spin = sqrt(field%g(3)**2 + field%p(3)**2)
      call solve(a, b, c, zero, zeros)
      do i = 1, zeros
         place(i) = min(max(zero(1, i), -1.0_wp), 1.0_wp)
         slope = sqrt((b(1) + 2.0_wp*c*zero(1, i))**2 + (b(2) + 2.0_wp*c*zero(2, i))**2)
         width(i) = abs(zero(2, i)) + abs(zero(1, i) - place(i)) &
            + spin*sqrt((1.0_wp - place(i))*(1.0_wp + place(i)))/max(slope, tiny(slope))
         width(i) = min(max(width(i), narrowest), widest)
      end do
      if (zeros == 0) then
         zeros = 1
         place(1) = 0.0_wp
         width(1) = widest
      else if (zeros == 2) then
         if (abs(place(1) - place(2)) < one_place*max(width(1), width(2))) then
            zeros = 1
            if (width(2) < width(1)) then
               place(1) = place(2)
               width(1) = width(2)
            end if
         else if (place(1) > place(2)) then
            place = place(2:1:-1)
            width = width(2:1:-1)
         end if
      end if
      n = 0
      call add_part(place(1), -1.0_wp, width(1), u, weight, n)
      if (zeros == 2) then
         call add_part(place(1), 0.5_wp*(place(1) + place(2)), width(1), u, weight, n)
         call add_part(place(2), 0.5_wp*(place(1) + place(2)), width(2), u, weight, n)
      end if
      call add_part(place(zeros), 1.0_wp, width(zeros), u, weight, n)
   end subroutine place_chords

   !> Chords from a zero to the end of a part, u = from +- over sinh(s).
   pure subroutine add_part(from, to, over, u, weight, n)
      real(wp), intent(in) :: from, to, over
      real(wp), intent(inout) :: u(most_chords), weight(most_chords)
      integer, intent(inout) :: n
      real(wp) :: last, stretch, near(half_part), far(half_part), step
      integer :: k

      step = abs(to - from)/over
      if (.not. step > 0.0_wp) return
      last = step + sqrt(step*step + 1.0_wp)
      stretch = log(last)
      near = exp(0.5_wp*stretch*(1.0_wp - x_4))
      ! The other half of the nodes lies as far from the end.
      far = last/near
      step = 0.5_wp*over
      do k = 1, half_part
         u(n + k) = from + sign(step*(near(k) - 1.0_wp/near(k)), to - from)
         weight(n + k) = 0.5_wp*step*stretch*w_4(k)*(near(k) + 1.0_wp/near(k))
         u(n + half_part + k) = from + sign(step*(far(k) - 1.0_wp/far(k)), to - from)
         weight(n + half_part + k) = 0.5_wp*step*stretch*w_4(k)*(far(k) + 1.0_wp/far(k))
      end do
      n = n + 2*half_part
   end subroutine add_part

   !> Add the wrench of chords along q and across it.
   pure subroutine add_slender(field, u, weight, n, sums)
      type(field_type), intent(in) :: field
      !> Places and weights of the chords, and their number.
      real(wp), intent(in) :: u(most_chords), weight(most_chords)
      integer, intent(in) :: n
      real(wp), intent(inout) :: sums(n_wrench)
      real(wp), dimension(most_chords) :: r, rise, eta, inverse, cosine, sine, place
      real(wp) :: spin, turn(2), along, across, b, xi, away, towards
      real(wp) :: means(4), m(4), load, side, t, s
      integer :: i

      spin = sqrt(field%g(3)**2 + field%p(3)**2)
      ! Direction of b, along q and across it.
      turn = [1.0_wp, 0.0_wp]
      if (spin > 0.0_wp) turn = [field%g(3), field%p(3)]/spin
      do i = 1, n
         r(i) = sqrt((1.0_wp - u(i))*(1.0_wp + u(i)))
         along = field%g(1) + (field%g(2) + field%g(4)*u(i))*u(i) + quarter*field%g(5)*r(i)**2
         across = field%p(1) + field%p(2)*u(i)
         b = 1.0_wp/max(spin*r(i), least_turn*(abs(along) + abs(across)), tiny(spin))
         xi = (along*turn(1) + across*turn(2))*b
         eta(i) = (across*turn(1) - along*turn(2))*b
         away = sqrt((xi + 1.0_wp)**2 + eta(i)**2)
         towards = sqrt((xi - 1.0_wp)**2 + eta(i)**2)
         b = max(0.5_wp*(away + towards), 1.0_wp)
         inverse(i) = 1.0_wp/b
         cosine(i) = xi*inverse(i)
         sine(i) = sqrt(max((1.0_wp - cosine(i))*(1.0_wp + cosine(i)), 0.0_wp))
         place(i) = sqrt(sqrt((b - 1.0_wp)*inverse(i)))
         rise(i) = field%z(1)*u(i)**2 + quarter*field%z(2)*r(i)**2
      end do
      do i = 1, n
         call look_up(place(i), sine(i), means)
         load = -factor*r(i)**2*weight(i)
         along = load*cosine(i)*means(1)
         side = sign(1.0_wp, eta(i))
         across = load*side*sine(i)*means(2)
         m(1) = along*turn(1) - across*turn(2)
         m(2) = along*turn(2) + across*turn(1)
         load = load*inverse(i)*r(i)
         along = load*means(3)
         across = load*side*cosine(i)*sine(i)*means(4)
         m(3) = along*turn(1) - across*turn(2)
         m(4) = along*turn(2) + across*turn(1)
         t = field%t(1)*u(i)
         s = field%s(1)*u(i)
         sums(1) = sums(1) + m(1)
         sums(2) = sums(2) + m(2)
         sums(3) = sums(3) + ((t*m(2) + field%t(2)*m(4)) - (s*m(1) + field%s(2)*m(3)))
         sums(4) = sums(4) + rise(i)*m(1)
         sums(5) = sums(5) + rise(i)*m(2)
      end do
   end subroutine add_slender

   !> Means over a chord, as they are tabulated.
   pure subroutine look_up(u, s, means)
      !> Coordinates, from 0 to 1.
      real(wp), intent(in) :: u, s
      real(wp), intent(out) :: means(4)
      real(wp) :: by_u(3), by_s(3), rows(4, 3), x
      integer :: i, j, k

      x = u*n_u
      i = min(int(x), n_u - 1)
      by_u = basis(x - i)
      x = s*n_s
      j = min(int(x), n_s - 1)
      by_s = basis(x - j)
      do k = 1, 3
         rows(:, k) = by_u(1)*splines(:, j + k, i + 1) + by_u(2)*splines(:, j + k, i + 2) &
            + by_u(3)*splines(:, j + k, i + 3)
      end do
      means = by_s(1)*rows(:, 1) + by_s(2)*rows(:, 2) + by_s(3)*rows(:, 3)
   end subroutine look_up

   !> The splines of degree 2 that are not zero on an interval.
   pure function basis(t) result(values)
      !> Place in the interval, from 0 to 1.
      real(wp), intent(in) :: t
      real(wp) :: values(3)

      values(1) = 0.5_wp*(1.0_wp - t)**2
      values(3) = 0.5_wp*t*t
      values(2) = 1.0_wp - values(1) - values(3)
   end function basis

end module contensou_contact_wrench_slender
