!> Tests of the complete elliptic integrals: reference values, a bulk comparison in quadruple
!> precision, identities, limits, continuity across the intervals of the tables, the other rungs.
!>
!> Error budget, in units in the last place: 1.6, and 2.0 by the parameter, whose complement is
!> rounded. Promised are 2.5 for K, E, B and D, and 3 for the derivatives.
module test_elliptic
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite, ieee_is_nan, ieee_negative_inf, &
      ieee_positive_inf, ieee_quiet_nan, ieee_value
   use contensou_base_kinds, only : pi, wp
   use contensou_special_elliptic, only : complete_elliptic, complete_elliptic_all, &
      complete_elliptic_all_of_c, complete_elliptic_bd, complete_elliptic_bd_of_c, &
      complete_elliptic_of_c, elliptic_b, elliptic_b_of_c, elliptic_d, elliptic_d_of_c, &
      elliptic_de_dc, elliptic_de_dc_of_c, elliptic_dk_dc, elliptic_dk_dc_of_c, elliptic_e, &
      elliptic_e_of_c, elliptic_k, elliptic_k_of_c, elliptic_model_type, elliptic_models
   use test_harness, only : check, check_close, check_relative, random_type, read_table, &
      table_type, worst_type
   implicit none(type, external)
   private

   public :: run_elliptic_tests

   !> Precision of the comparison.
   integer, parameter :: qp = selected_real_kind(30)

   !> Circle constant in that precision.
   real(qp), parameter :: pi_qp = acos(-1.0_qp)

   !> Names of the integrals, in the order of all arrays of six here.
   character(len=*), parameter :: names(6) = [character(len=5) :: "K", "E", "B", "D", "dK/dc", &
      "dE/dc"]

   !> Largest error of a value by the complement [ulp].
   real(wp), parameter :: budget = 1.6_wp

   !> Largest error of a value by the parameter [ulp].
   real(wp), parameter :: budget_of_c = 2.0_wp

contains

   !> Run all tests.
   subroutine run_elliptic_tests()
      call test_reference()
      call test_bulk()
      call test_edges()
      call test_of_c()
      call test_legendre()
      call test_derivatives()
      call test_landen()
      call test_continuity()
      call test_monotone()
      call test_circle()
      call test_limits()
      call test_outside_domain()
      call test_forms()
      call test_models()
   end subroutine run_elliptic_tests

   !> All integrals by the complement.
   function all_of(c1) result(values)
      !> Complement.
      real(wp), intent(in) :: c1
      real(wp) :: values(6)

      call complete_elliptic_all(c1, values(1), values(2), values(3), values(4), values(5), &
         values(6))
   end function all_of

   !> All integrals by the parameter.
   function all_of_c(c) result(values)
      !> Parameter.
      real(wp), intent(in) :: c
      real(wp) :: values(6)

      call complete_elliptic_all_of_c(c, values(1), values(2), values(3), values(4), values(5), &
         values(6))
   end function all_of_c

   !> All integrals in quadruple precision, by the arithmetic-geometric mean.
   function exact(c1) result(values)
      !> Complement, > 0.
      real(qp), intent(in) :: c1
      real(qp) :: values(6)
      real(qp) :: a, g, z, mean, power, s, k

      g = sqrt(c1)
      z = (1.0_qp - g)/(4.0_qp*(1.0_qp + g))
      a = (1.0_qp + g)/2.0_qp
      g = sqrt(g)
      power = 1.0_qp
      s = 0.5_qp + z
      do while (power*z > 0.01_qp*epsilon(s))
         mean = (a + g)/2.0_qp
         z = (z/(4.0_qp*mean))**2*(1.0_qp - c1)
         g = sqrt(a*g)
         a = mean
         power = 2.0_qp*power
         s = s + power*z
      end do
      k = pi_qp/(a + g)
      values(3) = k*(1.0_qp - s)
      values(4) = k*s
      values(1) = k
      values(2) = values(3) + c1*values(4)
      values(5) = values(3)/(2.0_qp*c1)
      values(6) = -values(4)/2.0_qp
   end function exact

   !> Errors in units in the last place of the expected values.
   function ulps(values, expected) result(errors)
      real(wp), intent(in) :: values(6)
      !> What they should be.
      real(qp), intent(in) :: expected(6)
      real(wp) :: errors(6)

      errors = real(abs(values - expected)/spacing(real(abs(expected), wp)), wp)
   end function ulps

   !> Take note of the errors of all integrals.
   subroutine note_all(worst, errors, sample)
      !> The records.
      type(worst_type), intent(inout) :: worst(6)
      real(wp), intent(in) :: errors(6)
      !> Number of the sample.
      integer, intent(in) :: sample
      integer :: i

      do i = 1, 6
         call worst(i)%note(errors(i), sample)
      end do
   end subroutine note_all

   !> Check the errors of all integrals.
   subroutine check_all(worst, bound, name)
      !> The records.
      type(worst_type), intent(in) :: worst(6)
      !> Largest error.
      real(wp), intent(in) :: bound
      !> What was checked.
      character(len=*), intent(in) :: name
      integer :: i

      do i = 1, 6
         call worst(i)%check_below(bound, trim(names(i)) // " " // name)
      end do
   end subroutine check_all

   !> Values of the table. Below c = 1/2 its exact number is c, above it is c1. The table is read to
   !> half a unit in the last place.
   subroutine test_reference()
      type(table_type) :: table
      real(wp), allocatable :: c(:), c1(:), expected(:, :)
      type(worst_type) :: by_c(6), by_c1(6)
      character(len=*), parameter :: columns(6) = [character(len=4) :: "K", "E", "B", "D", "dKdc", &
         "dEdc"]
      integer :: i

      call read_table("elliptic", table)
      c = table%column("c")
      c1 = table%column("c1")
      allocate(expected(table%rows, 6))
      do i = 1, 6
         expected(:, i) = table%column(trim(columns(i)))
      end do
      do i = 1, table%rows
         if (c(i) < 0.5_wp) then
            call note_all(by_c, ulps(all_of_c(c(i)), real(expected(i, :), qp)), i)
         else
            call note_all(by_c1, ulps(all_of(c1(i)), real(expected(i, :), qp)), i)
         end if
      end do
      call check_all(by_c, budget_of_c + 0.5_wp, "of the table by c")
      call check_all(by_c1, budget + 0.5_wp, "of the table by c1")
      call check(table%rows >= 100, "the table of elliptic integrals has rows")
   end subroutine test_reference

   !> Random complements over the whole range, and near the circle.
   subroutine test_bulk()
      type(random_type) :: random
      type(worst_type) :: wide(6), usual(6), near(6)
      real(wp) :: c1
      integer :: i

      do i = 1, 40000
         c1 = 10.0_wp**random%uniform(-300.0_wp, 0.0_wp)
         call note_all(wide, ulps(all_of(c1), exact(real(c1, qp))), i)
         c1 = 10.0_wp**random%uniform(-19.0_wp, 0.0_wp)
         call note_all(wide, ulps(all_of(c1), exact(real(c1, qp))), i)
         c1 = random%uniform(1.0e-6_wp, 1.0_wp)
         call note_all(usual, ulps(all_of(c1), exact(real(c1, qp))), i)
         c1 = 1.0_wp - 10.0_wp**random%uniform(-16.0_wp, -1.0_wp)
         call note_all(near, ulps(all_of(c1), exact(real(c1, qp))), i)
      end do
      call check_all(wide, budget, "for c1 from 1e-300 to 1")
      call check_all(usual, budget, "for c1 evenly from 0 to 1")
      call check_all(near, budget, "near the circle")
   end subroutine test_bulk

   !> Boundaries and quarters of the intervals of the tables, and their neighbours.
   subroutine test_edges()
      type(worst_type) :: worst(6)
      real(wp) :: edge, c1
      integer :: i, j, k

      do i = -66, -1
         do j = 0, 31
            edge = scale(1.0_wp + j/32.0_wp, i)
            do k = -2, 2
               c1 = edge + k*spacing(edge)
               call note_all(worst, ulps(all_of(c1), exact(real(c1, qp))), -i)
            end do
         end do
      end do
      call check_all(worst, budget, "at the edges of the intervals")
   end subroutine test_edges

   !> By the parameter.
   subroutine test_of_c()
      type(random_type) :: random
      type(worst_type) :: worst(6)
      real(wp) :: c
      integer :: i

      do i = 1, 10000
         c = random%uniform(0.0_wp, 1.0_wp)
         call note_all(worst, ulps(all_of_c(c), exact(1.0_qp - real(c, qp))), i)
         c = 10.0_wp**random%uniform(-20.0_wp, 0.0_wp)
         if (c > 0.999_wp) cycle
         call note_all(worst, ulps(all_of_c(c), exact(1.0_qp - real(c, qp))), i)
      end do
      call check_all(worst, budget_of_c, "by c")
   end subroutine test_of_c

   !> Legendre's relation E K' + E' K - K K' = pi/2; E' - K' = -c1 D' keeps it from cancelling.
   subroutine test_legendre()
      type(random_type) :: random
      type(worst_type) :: worst
      real(wp) :: c1, k, e, k_other, b_other, d_other
      integer :: i

      do i = 1, 20000
         ! Both c1 and 1 - c1 are exact.
         c1 = scale(anint(scale(random%uniform(0.0_wp, 1.0_wp), 50)), -50)
         if (mod(i, 2) == 0) c1 = scale(anint(scale(c1**8, 52)), -52)
         if (c1 < 1.0e-15_wp .or. c1 > 1.0_wp - 1.0e-15_wp) cycle
         call complete_elliptic(c1, k, e)
         call complete_elliptic_bd(1.0_wp - c1, b_other, d_other)
         k_other = b_other + d_other
         ! One of the products may be as large as K.
         call worst%note(abs(e*k_other - c1*k*d_other - 0.5_wp*pi)/(e*k_other), i)
      end do
      call worst%check_below(4.0_wp*epsilon(pi), "Legendre's relation")
   end subroutine test_legendre

   !> The derivatives K' and E' against K and E: 2 c c1 dK/dc = E - c1 K and 2 c dE/dc = E - K, and
   !> against differences of K and E themselves.
   subroutine test_derivatives()
      type(random_type) :: random
      type(worst_type) :: of_k, of_e, slope_k, slope_e
      real(wp) :: c, c1, k, e, b, d, dk, de, h, k_side(-2:2), e_side(-2:2)
      integer :: i, j

      do i = 1, 20000
         c1 = scale(anint(scale(random%uniform(0.0_wp, 1.0_wp), 50)), -50)
         if (mod(i, 2) == 0) c1 = c1**6
         if (c1 < 1.0e-30_wp .or. c1 > 1.0_wp - 1.0e-6_wp) cycle
         c = 1.0_wp - c1
         call complete_elliptic_all(c1, k, e, b, d, dk, de)
         ! E and c1 K, E and K cancel for small c: their rounding is what remains.
         call of_k%note(abs(2.0_wp*c*c1*dk - (e - c1*k))/e, i)
         call of_e%note(abs(2.0_wp*c*de - (e - k))/k, i)
         ! E changes with c1: over a short step the rounding of E is what remains.
         h = 1.0e-3_wp*min(c1, c)
         do j = -2, 2
            call complete_elliptic(c1 - j*h, k_side(j), e_side(j))
         end do
         call slope_k%note(abs((8.0_wp*(k_side(1) - k_side(-1)) - (k_side(2) - k_side(-2))) &
            /(12.0_wp*h*dk) - 1.0_wp)*min(1.0_wp, c), i)
         call slope_e%note(abs((8.0_wp*(e_side(1) - e_side(-1)) - (e_side(2) - e_side(-2))) &
            /(12.0_wp*h*de) - 1.0_wp)*min(c1, c), i)
      end do
      call of_k%check_below(4.0_wp*epsilon(c), "K' from K and E")
      call of_e%check_below(4.0_wp*epsilon(c), "E' from K and E")
      call slope_k%check_below(1.0e-9_wp, "K' is the slope of K")
      call slope_e%check_below(1.0e-12_wp, "E' is the slope of E")
   end subroutine test_derivatives

   !> Landen's transformation, K(c) = (1 + k1) K(k1^2) and E(c) = (2 E(k1^2) - (1 - k1^2) K(k1^2))
   !> /(1 + k1), k1 = (1 - sqrt(c1))/(1 + sqrt(c1)): the integrals at two distant places.
   subroutine test_landen()
      type(random_type) :: random
      type(worst_type) :: of_k, of_e
      real(wp) :: root, k1, other, k, e, k_other, e_other
      integer :: i

      do i = 1, 20000
         root = 10.0_wp**random%uniform(-12.0_wp, 0.0_wp)
         k1 = (1.0_wp - root)/(1.0_wp + root)
         ! 1 - k1^2 without cancellation.
         other = 4.0_wp*root/(1.0_wp + root)**2
         call complete_elliptic(root**2, k, e)
         call complete_elliptic(min(other, 1.0_wp), k_other, e_other)
         call of_k%note(abs((1.0_wp + k1)*k_other/k - 1.0_wp), i)
         call of_e%note(abs((2.0_wp*e_other - other*k_other)/(1.0_wp + k1)/e - 1.0_wp), i)
      end do
      call of_k%check_below(8.0_wp*epsilon(k), "Landen's transformation of K")
      call of_e%check_below(8.0_wp*epsilon(k), "Landen's transformation of E")
   end subroutine test_landen

   !> From one interval to the next, and to the logarithm, values change by rounding alone.
   subroutine test_continuity()
      type(worst_type) :: worst(6)
      real(wp) :: c1, low(6), high(6)
      integer :: i, j

      do i = -75, -1
         do j = 0, 63
            call compare(scale(1.0_wp + j/64.0_wp, i), -i)
         end do
      end do
      do i = -1010, -80, 10
         call compare(scale(1.0_wp, i), -i)
      end do
      call check_all(worst, 3.5_wp, "is continuous across the intervals")
      ! The limits at both ends of the range are met.
      low = all_of(1.0_wp)
      c1 = 1.0_wp - 0.5_wp*epsilon(c1)
      high = all_of(c1)
      call check(all(abs(high - low) <= 2.0_wp*spacing(low)), "the circle is met")

   contains

      !> Note the differences across a boundary.
      subroutine compare(boundary, sample)
         real(wp), intent(in) :: boundary
         !> Number of the sample.
         integer, intent(in) :: sample

         low = all_of(boundary)
         high = all_of(nearest(boundary, 1.0_wp))
         call note_all(worst, abs(high - low)/spacing(low), sample)
      end subroutine compare

   end subroutine test_continuity

   !> K, D and dK/dc fall with c1, E and dE/dc grow; so does B downwards, within rounding.
   subroutine test_monotone()
      type(random_type) :: random
      type(worst_type) :: worst(6)
      real(wp) :: c1, low(6), high(6)
      real(wp), parameter :: direction(6) = [-1.0_wp, 1.0_wp, -1.0_wp, -1.0_wp, -1.0_wp, 1.0_wp]
      integer :: i

      do i = 1, 50000
         if (mod(i, 2) == 0) then
            c1 = random%uniform(1.0e-3_wp, 0.999_wp)
         else
            c1 = 10.0_wp**random%uniform(-299.0_wp, -0.01_wp)
         end if
         low = all_of(c1)
         high = all_of(c1*(1.0_wp + 1.0e-12_wp))
         call note_all(worst, (low - high)*direction/spacing(low), i)
      end do
      call worst(1)%check_below(-1.0_wp, "K falls with c1")
      call worst(2)%check_below(1.0_wp, "E grows with c1")
      call worst(3)%check_below(1.0_wp, "B falls with c1")
      call worst(4)%check_below(-1.0_wp, "D falls with c1")
      call worst(5)%check_below(-1.0_wp, "dK/dc falls with c1")
      call worst(6)%check_below(-1.0_wp, "dE/dc grows with c1")
   end subroutine test_monotone

   !> On the circle values are exact.
   subroutine test_circle()
      real(wp), parameter :: expected(6) = pi*[0.5_wp, 0.5_wp, 0.25_wp, 0.25_wp, 0.125_wp, &
         -0.125_wp]
      integer :: i

      do i = 1, 6
         call check_values(all_of(1.0_wp), "c1 = 1")
         call check_values(all_of_c(0.0_wp), "c = 0")
         call check_values(all_of_c(-0.0_wp), "c = -0")
         call check_values(all_of_c(1.0e-300_wp), "c = 1e-300")
      end do

   contains

      !> Check one of the values.
      subroutine check_values(values, name)
         real(wp), intent(in) :: values(6)
         !> Where.
         character(len=*), intent(in) :: name

         call check_close(values(i), expected(i), 0.0_wp, trim(names(i)) // " at " // name)
      end subroutine check_values

   end subroutine test_circle

   !> c1 = 0, and numbers so small that dK/dc has no double.
   subroutine test_limits()
      real(wp) :: c1

      call check_limit(all_of(0.0_wp), "c1 = 0")
      call check_limit(all_of(-0.0_wp), "c1 = -0")
      call check_limit(all_of_c(1.0_wp), "c = 1")
      c1 = tiny(c1)*epsilon(c1)
      call check_relative(elliptic_k(c1), log(4.0_wp) - 0.5_wp*log(c1), 1.0e-15_wp, &
         "K of the smallest number")
      call check_infinite(elliptic_dk_dc(c1), 1.0_wp, "dK/dc of the smallest number")
      call check_relative(elliptic_dk_dc(tiny(c1)), 0.5_wp/tiny(c1), 1.0e-15_wp, &
         "dK/dc of the smallest normal number")
      call check_relative(elliptic_d(1.0e-305_wp), log(4.0_wp) - 1.0_wp - 0.5_wp*log(1.0e-305_wp), &
         1.0e-15_wp, "D below the tables")

   contains

      !> Check the values at c1 = 0.
      subroutine check_limit(values, name)
         real(wp), intent(in) :: values(6)
         !> Where.
         character(len=*), intent(in) :: name

         call check_infinite(values(1), 1.0_wp, "K at " // name)
         call check_close(values(2), 1.0_wp, 0.0_wp, "E at " // name)
         call check_close(values(3), 1.0_wp, 0.0_wp, "B at " // name)
         call check_infinite(values(4), 1.0_wp, "D at " // name)
         call check_infinite(values(5), 1.0_wp, "dK/dc at " // name)
         call check_infinite(values(6), -1.0_wp, "dE/dc at " // name)
      end subroutine check_limit

      !> Check that a value is infinite.
      subroutine check_infinite(value, direction, name)
         real(wp), intent(in) :: value
         !> Its sign.
         real(wp), intent(in) :: direction
         !> What was checked.
         character(len=*), intent(in) :: name
         logical :: infinite

         infinite = .not. ieee_is_finite(value) .and. .not. ieee_is_nan(value)
         if (infinite) infinite = sign(1.0_wp, value)*direction > 0.0_wp
         call check(infinite, name)
      end subroutine check_infinite

   end subroutine test_limits

   !> Outside the domain nothing is a number, whatever the rung.
   subroutine test_outside_domain()
      type(elliptic_model_type), allocatable :: models(:)
      real(wp) :: arguments(8), values(6)
      integer :: i, j

      arguments = [-1.0e-300_wp, -1.0e-20_wp, -1.0_wp, 1.0_wp + epsilon(1.0_wp), 3.0_wp, &
         ieee_value(1.0_wp, ieee_quiet_nan), ieee_value(1.0_wp, ieee_positive_inf), &
         ieee_value(1.0_wp, ieee_negative_inf)]
      models = elliptic_models()
      do i = 1, size(arguments)
         call check(all(ieee_is_nan(all_of(arguments(i)))), "c1 outside the domain")
         call check(all(ieee_is_nan(all_of_c(arguments(i)))), "c outside the domain")
         do j = 1, size(models)
            if (.not. associated(models(j)%kernel)) cycle
            call models(j)%kernel(arguments(i), values(1), values(2), values(3), values(4), &
               values(5), values(6))
            call check(all(ieee_is_nan(values)), trim(models(j)%name) // " outside the domain")
         end do
      end do
   end subroutine test_outside_domain

   !> Functions, subroutines and array forms give the same numbers.
   subroutine test_forms()
      real(wp) :: c1(7), c(7), r(7, 6), s(7, 6)
      integer :: i

      c1 = [1.0_wp, 0.75_wp, 0.3_wp, 1.0e-3_wp, 1.0e-12_wp, 1.0e-40_wp, 1.0e-300_wp]
      c = 1.0_wp - c1
      do i = 1, 7
         r(i, :) = all_of(c1(i))
      end do
      call complete_elliptic_all(c1, s(:, 1), s(:, 2), s(:, 3), s(:, 4), s(:, 5), s(:, 6))
      call check_same("the array form")
      call complete_elliptic(c1, s(:, 1), s(:, 2))
      call complete_elliptic_bd(c1, s(:, 3), s(:, 4))
      call check_same("the forms for two integrals")
      s(:, 1) = elliptic_k(c1)
      s(:, 2) = elliptic_e(c1)
      s(:, 3) = elliptic_b(c1)
      s(:, 4) = elliptic_d(c1)
      s(:, 5) = elliptic_dk_dc(c1)
      s(:, 6) = elliptic_de_dc(c1)
      call check_same("the functions")
      do i = 1, 5
         r(i, :) = all_of(1.0_wp - c(i))
      end do
      call complete_elliptic_all_of_c(c, s(:, 1), s(:, 2), s(:, 3), s(:, 4), s(:, 5), s(:, 6))
      call check_same("the array form by c")
      call complete_elliptic_of_c(c, s(:, 1), s(:, 2))
      call complete_elliptic_bd_of_c(c, s(:, 3), s(:, 4))
      call check_same("the forms for two integrals by c")
      s(:, 1) = elliptic_k_of_c(c)
      s(:, 2) = elliptic_e_of_c(c)
      s(:, 3) = elliptic_b_of_c(c)
      s(:, 4) = elliptic_d_of_c(c)
      s(:, 5) = elliptic_dk_dc_of_c(c)
      s(:, 6) = elliptic_de_dc_of_c(c)
      call check_same("the functions by c")

   contains

      !> Compare with what the scalar form gave; the last two parameters round to 1.
      subroutine check_same(name)
         !> Which form.
         character(len=*), intent(in) :: name
         integer :: n

         n = merge(5, 7, index(name, "by c") > 0)
         call check(all(abs(s(:n, :) - r(:n, :)) <= 0.0_wp), name // " gives the same")
      end subroutine check_same

   end subroutine test_forms

   !> Each rung is as good as its description says.
   subroutine test_models()
      type(elliptic_model_type), allocatable :: models(:)
      type(random_type) :: random
      type(worst_type) :: usual, k_agm, b_agm, early, claimed
      real(wp) :: c1, r(6), s(6)
      integer :: i, j

      models = elliptic_models()
      call check(size(models) == 4, "there are four rungs")
      do j = 1, size(models)
         call check(count(models%name == models(j)%name) == 1, "names of rungs differ")
         call check(len_trim(models(j)%summary) > 0 .and. len_trim(models(j)%reference) > 0, &
            trim(models(j)%name) // " is described")
         usual = worst_type()
         do i = 1, 1000
            ! Where all of them are good: away from the circle and from slender ellipses.
            c1 = random%uniform(0.2_wp, 0.8_wp)
            r = all_of(c1)
            call models(j)%kernel(c1, s(1), s(2), s(3), s(4), s(5), s(6))
            call usual%note(maxval(abs(s - r)/abs(r)), i)
         end do
         call usual%check_below(2.0e-14_wp, trim(models(j)%name) // " for c from 0.2 to 0.8")
      end do
      do i = 1, 5000
         c1 = 10.0_wp**random%uniform(-300.0_wp, 0.0_wp)
         r = all_of(c1)
         call run("agm")
         call k_agm%note(maxval(abs(s([1, 4]) - r([1, 4]))/spacing(r([1, 4]))), i)
         call b_agm%note(abs(s(3) - r(3))/(r(1)*epsilon(r)), i)
         c1 = random%uniform(1.0_wp - 0.842_wp, 1.0_wp)
         r = all_of(c1)
         call run("theta")
         call early%note(abs(s(1)/r(1) - 1.0_wp), i)
         c1 = random%uniform(1.0_wp - 0.9956_wp, 1.0_wp)
         r = all_of(c1)
         call run("theta")
         call claimed%note(abs(s(1)/r(1) - 1.0_wp), i)
      end do
      call k_agm%check_below(9.0_wp, "K and D of agm, in units in the last place")
      call b_agm%check_below(4.0_wp, "B of agm loses as K grows")
      call early%check_below(2.0e-15_wp, "theta up to c = 0.842")
      call claimed%check_below(2.0_wp**(-21), "theta up to c = 0.9956")
      c1 = 1.0e-10_wp
      r = all_of(c1)
      call run("theta")
      call check_close(s(1)/r(1), 0.78_wp, 0.01_wp, "theta is 22 % wrong at 1 - 1e-10")

   contains

      !> Run a rung.
      subroutine run(name)
         character(len=*), intent(in) :: name
         integer :: i_model

         i_model = findloc(models%name, name, 1)
         call models(i_model)%kernel(c1, s(1), s(2), s(3), s(4), s(5), s(6))
      end subroutine run

   end subroutine test_models

end module test_elliptic
