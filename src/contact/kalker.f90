!> Kalker's coefficients of the linear theory of rolling, in which nothing slips (J. Kalker, On the
!> rolling contact of two elastic bodies in the presence of dry friction, 1967): with the axes along
!> and across the rolling direction e, the normal being the third,
!>    Fx = -G a b (C11 xi + C12 eta + sqrt(a b) C13 phi)
!>    Fy = -G a b (C12 xi + C22 eta + sqrt(a b) C23 phi)
!>    T  = -G (a b)^(3/2) (-C13 xi - C23 eta + sqrt(a b) C33 phi)
!> Rolling along an axis of the spot has C12 = C13 = 0.
!>
!> From a table over ln(a/b), the direction and Poisson's ratio: cubic splines in the first two, so
!> that the coefficients have continuous curvature, and a polynomial in the third. The direction is
!> p = t/(1 + t) with t = sqrt(a/b) |tan chi|, which spreads directions near the major axis of
!> needles and takes no function of a library. scripts/generate_kalker.py makes it. Errors: 1e-5 for
!> a/b = 1/3 to 3 along the axes, 5e-4 of the largest coefficient of the kind to a/b = 1/20 and 20.
!> On more slender spots the coefficients of the end are stretched as the asymptotic ones are
!> (`stretch`).
!>
!> Most of the work are the sums over the ratio and Poisson's ratio. `kalker_by_direction` has them
!> for all directions, for spots whose shape does not change; who has them passes them on.
module contensou_contact_kalker
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite, ieee_quiet_nan, ieee_value
   use contensou_base_kinds, only : i8, pi, wp
   use contensou_contact_kalker_values, only : coefficients, n_directions, n_poissons, &
      n_ratios, ratio_step
   implicit none(type, external)
   private

   public :: kalker_matrix, kalker_six, kalker_by_direction, kalker_coefficients, least_ratio

   !> Ratio of the minor to the major axis where the table ends.
   real(wp), parameter :: least_ratio = exp(-ratio_step*real(n_ratios - 1, wp))

   real(wp), parameter :: least_root = sqrt(least_ratio)

   !> Ratio from which on a spot is no more slender: its powers would not be numbers.
   real(wp), parameter :: least_of_all = 1.0e-100_wp

   integer :: index

   !> Chebyshev points of Poisson's ratio.
   real(wp), parameter :: points(n_poissons) = [ &
      (0.25_wp - 0.25_wp*cos(pi*real(index, wp)/real(n_poissons - 1, wp)), &
      index=0, n_poissons - 1)]

   !> Weights of the polynomial through them: signs in turn, half at the ends.
   real(wp), parameter :: barycentric(n_poissons) = [ &
      (real(1 - 2*mod(index, 2), wp)*merge(0.5_wp, 1.0_wp, index == 0 .or. &
      index == n_poissons - 1), index=0, n_poissons - 1)]

   !> Bits of a place below one.
   integer, parameter :: fine = 20

   !> What is added to a place to round it to these: the last bits of the sum have the number of its
   !> cell, then these; where two cells meet, the one that begins. A conversion takes longer.
   real(wp), parameter :: to_fine = 1.5_wp*2.0_wp**(digits(1.0_wp) - 1 - fine)

   !> Cells of the direction.
   real(wp), parameter :: cells = real(n_directions - 1, wp)

contains

   !> Coefficients for any ratio of the axes, rolling in any direction.
   pure function kalker_coefficients(ratio, poisson, chi) result(c)
      !> a/b, a along the axis from where chi is counted; > 0.
      real(wp), intent(in) :: ratio
      !> Poisson's ratio, from 0 to 1/2.
      real(wp), intent(in) :: poisson
      !> Angle from that axis to the rolling direction [rad].
      real(wp), intent(in) :: chi
      !> C11, C12, C22, C13, C23, C33; NaN outside of the domain.
      real(wp) :: c(6)
      real(wp) :: matrix(3, 3), slope(3, 3), e(2)
      logical :: valid

      c = ieee_value(c, ieee_quiet_nan)
      valid = ieee_is_finite(ratio) .and. ieee_is_finite(poisson) .and. ieee_is_finite(chi)
      if (valid) valid = ratio > 0.0_wp .and. poisson >= 0.0_wp .and. poisson <= 0.5_wp
      if (.not. valid) return
      e = [cos(chi), sin(chi)]
      ! Exactly along the axes the small component is rounding.
      where (abs(e) < 4.0_wp*epsilon(e)) e = 0.0_wp
      if (ratio < 1.0_wp) then
         call kalker_matrix(ratio, poisson, [e(2), -e(1)], matrix, slope)
      else
         call kalker_matrix(1.0_wp/ratio, poisson, e, matrix, slope)
      end if
      c = [matrix(1, 1), matrix(1, 2), matrix(2, 2), matrix(1, 3), matrix(2, 3), matrix(3, 3)]
   end function kalker_coefficients

   !> The matrix of the coefficients, and its derivative by the angle of the rolling direction.
   pure subroutine kalker_matrix(k, poisson, e, matrix, slope, by_direction)
      !> Ratio of the minor to the major axis, in (0, 1].
      real(wp), intent(in) :: k
      !> Poisson's ratio, from 0 to 1/2.
      real(wp), intent(in) :: poisson
      !> Rolling direction along the major and the minor axis, of length one.
      real(wp), intent(in) :: e(2)
      !> C of F/(G a b) = -C (xi, eta, sqrt(a b) phi).
      real(wp), intent(out) :: matrix(3, 3)
      real(wp), intent(out) :: slope(3, 3)
      !> What `kalker_by_direction` has for these ratios.
      real(wp), intent(in), optional :: by_direction(6, 0:3, 0:n_directions - 1)
      real(wp) :: columns(6, 4), weights(4), rate(4)
      real(wp), dimension(6) :: c, c_rate, growth, growth_rate
      real(wp) :: place, x, along, across, root, mirror
      integer :: j, sector

      root = sqrt(sqrt(k))
      along = abs(e(1))*root
      across = abs(e(2))/root
      mirror = sign(1.0_wp, e(1))*sign(1.0_wp, e(2))
      place = cells*(across/(along + across))
      sector = min(int(place), n_directions - 2)
      x = place - real(sector, wp)
      if (present(by_direction)) then
         columns = by_direction(:, :, sector)
         weights = [1.0_wp, x, x*x, x**3]
         rate = [0.0_wp, 1.0_wp, 2.0_wp*x, 3.0_wp*x*x]
      else
         call sum_columns(k, poisson, sector - 1, columns)
         weights = spline_weights(x)/6.0_wp
         rate = [-(1.0_wp - x)**2, x*(3.0_wp*x - 4.0_wp), 1.0_wp + x*(2.0_wp - 3.0_wp*x), &
            x*x]/2.0_wp
      end if
      rate = rate*(cells/(along + across)**2)
      c = 0.0_wp
      c_rate = 0.0_wp
      do j = 1, 4
         c = c + weights(j)*columns(:, j)
         c_rate = c_rate + rate(j)*columns(:, j)
      end do
      if (k < least_ratio) then
         call stretch(k, poisson, abs(e), growth, growth_rate)
         c_rate = growth*(c_rate + growth_rate*c)
         c = growth*c
      end if
      ! In the mirror the coefficients are even or odd functions of the angle.
      c([2, 4]) = mirror*c([2, 4])
      c_rate([1, 3, 5, 6]) = mirror*c_rate([1, 3, 5, 6])
      if (min(abs(e(1)), abs(e(2))) <= 0.0_wp) then
         c([2, 4]) = 0.0_wp
         c_rate([1, 3, 5, 6]) = 0.0_wp
      end if
      matrix = full(c)
      slope = full(c_rate)
   end subroutine kalker_matrix

   !> The coefficients alone, C11, C12, C22, C13, C23, C33, of a spot whose splines are known,
   !> without functions of a library; those of `kalker_matrix` to rounding.
   pure subroutine kalker_six(by_direction, poisson, root_k, ex, ey, c11, c12, c22, c13, c23, c33)
      !> What `kalker_by_direction` has.
      real(wp), intent(in) :: by_direction(6, 0:3, 0:n_directions - 1)
      !> Poisson's ratio, from 0 to 1/2.
      real(wp), intent(in) :: poisson
      !> Root of the ratio of the minor to the major axis, in (0, 1].
      real(wp), intent(in) :: root_k
      !> Rolling direction along the major and the minor axis, >= 0; the square of its length is
      !> normal. Between the other axes C12 and C13 have the other sign.
      real(wp), intent(in) :: ex, ey
      real(wp), intent(out) :: c11, c12, c22, c13, c23, c33
      real(wp) :: place, rounded, x, x2
      real(wp), dimension(6) :: c, growth, growth_rate
      integer(i8) :: j

      place = cells*(ey/(root_k*ex + ey))
      rounded = place + to_fine
      j = iand(shiftr(transfer(rounded, 0_i8), fine), 255_i8)
      x = place - (transfer(iand(transfer(rounded, 0_i8), -2_i8**fine), 0.0_wp) - to_fine)
      x2 = x*x
      c = (by_direction(:, 0, j) + x*by_direction(:, 1, j)) &
         + x2*(by_direction(:, 2, j) + x*by_direction(:, 3, j))
      if (root_k < least_root) then
         call stretch(root_k**2, poisson, [ex, ey]/sqrt(ex**2 + ey**2), growth, growth_rate)
         c = growth*c
      end if
      ! Not returned as an array, which the caller would share with others: these are computed in
      ! pairs, and taken from the registers.
      c11 = c(1)
      c12 = c(2)
      c22 = c(3)
      c13 = c(4)
      c23 = c(5)
      c33 = c(6)
   end subroutine kalker_six

   !> What the coefficients of a spot more slender than the table has are over those of its end.
   !>
   !> Along and across they grow as the asymptotic ones do (J. Kalker, Three-dimensional elastic
   !> bodies in rolling contact, 1990, table E3). In between, at t = sqrt(a/b) |tan chi| = 1, strips
   !> across the spot act by themselves, passed at the sine of the angle: C11 and C22 grow with
   !> (a/b)^(1/2), C33 with (a/b)^(3/2), C23 and C13 nearly with a/b (as they do in the table to
   !> 20). The logarithm of what they grow by is a parabola through the three in the excess of
   !> ln(l/w), the ratio of half-length to half-width, over that at the end at the same t, which is
   !> -1, 0 and 1 there in units of the ratio's. Against boundary elements: docs/rolling.md.
   pure subroutine stretch(slender, poisson, e, growth, growth_rate)
      !> Ratio of the minor to the major axis, below that of the end.
      real(wp), intent(in) :: slender
      real(wp), intent(in) :: poisson
      !> Rolling direction along the major and the minor axis, >= 0, of length one.
      real(wp), intent(in) :: e(2)
      !> Of C11, C12, C22, C13, C23, C33, and the derivatives of its logarithm by the angle.
      real(wp), intent(out) :: growth(6), growth_rate(6)
      !> Powers of a/b with which they grow in between.
      real(wp), parameter :: between(6) = [0.5_wp, 0.5_wp, 0.5_wp, 0.6_wp, 0.9_wp, 1.5_wp]
      real(wp), dimension(6) :: along, across, middle, bend, tilt
      real(wp) :: k, ratio, more, rate, x2, y2, square, above, below

      k = max(slender, least_of_all)
      ratio = log(least_ratio/k)
      along = asymptotic_along(k, poisson)/asymptotic_along(least_ratio, poisson)
      along = log(along)
      across = asymptotic_across(k, poisson)/asymptotic_across(least_ratio, poisson)
      across = log(across)
      middle = between*ratio
      x2 = e(1)**2
      y2 = e(2)**2
      square = k**2*x2 + y2
      above = k*x2 + least_ratio*y2
      below = least_ratio*k*x2 + y2
      more = (log(k/square) - log(above/below))/ratio
      rate = 2.0_wp*e(1)*e(2)*((k**2 - 1.0_wp)/square - (least_ratio - k)/above &
         + (1.0_wp - least_ratio*k)/below)/ratio
      tilt = 0.5_wp*(along - across)
      bend = 0.5_wp*(along + across) - middle
      growth = exp(middle + more*(tilt + more*bend))
      growth_rate = (tilt + 2.0_wp*more*bend)*rate
   end subroutine stretch

   !> Coefficients of a slender spot that rolls along its major axis, asymptotically; those that
   !> vanish there grow as their neighbours.
   pure function asymptotic_along(k, poisson) result(c)
      real(wp), intent(in) :: k, poisson
      real(wp) :: c(6)
      real(wp) :: large, other, rigid

      large = log(16.0_wp/k**2)
      rigid = (1.0_wp - poisson)*large
      other = 3.0_wp - log(4.0_wp)
      c(1) = 2.0_wp*pi/((large - 2.0_wp*poisson)*k)*(1.0_wp + other/(large - 2.0_wp*poisson))
      c(3) = 2.0_wp*pi/(k*(rigid + 2.0_wp*poisson)) &
         *(1.0_wp + (1.0_wp - poisson)*other/(rigid + 2.0_wp*poisson))
      c(2) = sqrt(c(1)*c(3))
      c(5) = 2.0_wp*pi/(3.0_wp*k*sqrt(k)*(rigid - 2.0_wp + 4.0_wp*poisson))
      c(4) = c(5)
      c(6) = 0.25_wp*pi*(1.0_wp - poisson*(large - 2.0_wp)/(rigid - 2.0_wp + 4.0_wp*poisson))
   end function asymptotic_along

   !> The same across the major axis.
   pure function asymptotic_across(k, poisson) result(c)
      real(wp), intent(in) :: k, poisson
      real(wp) :: c(6)

      c(1:3) = 0.25_wp*pi**2*[1.0_wp/(1.0_wp - poisson), 1.0_wp/sqrt(1.0_wp - poisson), 1.0_wp]
      c(5) = pi*sqrt(k)/(3.0_wp*(1.0_wp - poisson)) &
         *(1.0_wp + poisson*(0.5_wp*log(16.0_wp/k**2) + log(4.0_wp) - 5.0_wp))
      c(4) = c(5)
      c(6) = pi**2/(16.0_wp*(1.0_wp - poisson)*k)
   end function asymptotic_across

   !> Powers of the splines in the direction, for one ratio of the axes and one of Poisson.
   pure function kalker_by_direction(k, poisson) result(powers)
      !> Ratio of the minor to the major axis, in (0, 1].
      real(wp), intent(in) :: k
      !> Poisson's ratio, from 0 to 1/2.
      real(wp), intent(in) :: poisson
      real(wp) :: powers(6, 0:3, 0:n_directions - 1)
      real(wp) :: columns(6, -1:n_directions)
      integer :: j

      call sum_columns(k, poisson, -1, columns)
      do j = 0, n_directions - 1
         powers(:, 0, j) = ((columns(:, j - 1) + columns(:, j + 1)) + 4.0_wp*columns(:, j))/6.0_wp
         powers(:, 1, j) = (columns(:, j + 1) - columns(:, j - 1))/2.0_wp
         powers(:, 2, j) = ((columns(:, j - 1) + columns(:, j + 1)) - 2.0_wp*columns(:, j))/2.0_wp
         powers(:, 3, j) = 0.0_wp
         if (j < n_directions - 1) powers(:, 3, j) = ((columns(:, j + 2) - columns(:, j - 1)) &
            + 3.0_wp*(columns(:, j) - columns(:, j + 1)))/6.0_wp
      end do
      ! Along the axes they vanish but for rounding.
      powers([2, 4], 0, 0) = 0.0_wp
      powers([2, 4], 0, n_directions - 1) = 0.0_wp
   end function kalker_by_direction

   !> Some of them.
   pure subroutine sum_columns(k, poisson, first, columns)
      real(wp), intent(in) :: k
      real(wp), intent(in) :: poisson
      !> Where in the table of directions they begin.
      integer, intent(in) :: first
      real(wp), intent(out) :: columns(:, :)
      real(wp) :: by_ratio(4), by_poisson(n_poissons), weight, column(6), place
      integer :: i, j, m, cell

      place = -log(max(k, least_ratio))/ratio_step
      cell = min(int(place), n_ratios - 2)
      by_ratio = spline_weights(place - real(cell, wp))/6.0_wp
      by_poisson = poisson_weights(poisson)
      do j = 1, size(columns, 2)
         column = 0.0_wp
         do i = 1, 4
            do m = 1, n_poissons
               weight = by_ratio(i)*by_poisson(m)
               column = column + weight*coefficients(:, m, first + j - 1, cell + i - 2)
            end do
         end do
         columns(:, j) = column
      end do
   end subroutine sum_columns

   !> The matrix of the six coefficients.
   pure function full(c) result(matrix)
      real(wp), intent(in) :: c(6)
      real(wp) :: matrix(3, 3)

      matrix = reshape([c(1), c(2), -c(4), c(2), c(3), -c(5), c(4), c(5), c(6)], [3, 3])
   end function full

   !> Weights of the four splines of a cell, times six.
   pure function spline_weights(x) result(weights)
      !> Place in the cell, from 0 to 1.
      real(wp), intent(in) :: x
      real(wp) :: weights(4)

      weights = [(1.0_wp - x)**3, 4.0_wp + x*x*(3.0_wp*x - 6.0_wp), &
         1.0_wp + 3.0_wp*x*(1.0_wp + x*(1.0_wp - x)), x**3]
   end function spline_weights

   !> Weights of the points of Poisson's ratio.
   pure function poisson_weights(poisson) result(weights)
      real(wp), intent(in) :: poisson
      real(wp) :: weights(n_poissons)
      integer :: i

      i = minloc(abs(poisson - points), dim=1)
      weights = 0.0_wp
      if (abs(poisson - points(i)) <= epsilon(poisson)) then
         weights(i) = 1.0_wp
      else
         weights = barycentric/(poisson - points)
         weights = weights/sum(weights)
      end if
   end function poisson_weights

end module contensou_contact_kalker
