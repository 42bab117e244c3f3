!> Tests of Hertz's contact and of Vil'ke's force.
module test_hertz
   use, intrinsic :: ieee_arithmetic, only : ieee_is_nan, ieee_positive_inf, ieee_quiet_nan, &
      ieee_value
   use contensou_base_kinds, only : pi, wp
   use contensou_contact_hertz, only : hertz_approach, hertz_contact, &
      hertz_model_type, hertz_models, hertz_newton_with, hertz_shape, hertz_spot_type, &
      hertz_type, in_hertz_domain, new_hertz
   use contensou_contact_vilke, only : chord_c1, power_c1, vilke_exact, vilke_force, vilke_models, &
      vilke_stiffness
   use contensou_special_elliptic, only : complete_elliptic, complete_elliptic_bd, elliptic_agm
   use test_harness, only : check, check_close, check_relative, random_type, read_table, &
      table_type, worst_type
   implicit none(type, external)
   private

   public :: run_hertz_tests

   !> Error budget of the exact contact in units in the last place; the rounding of the reference
   !> values, half a unit, is included.
   !>
   !> With u half a unit at worst: t and 1/K 1.1 u, their argument g 1 u times at most 0.4. Then
   !> c1 = g t/(1 - t): 1 + 1.5 + 2 + 2 u; a, b: half of 1.5 + 3 u, and 1 u;
   !> N: 1.5 + 5 u and the error of a; p0: 1.5 + 3 u and the error of b.
   real(wp), parameter :: budget_c1 = 6.0_wp, budget_axis = 2.5_wp, budget_force = 6.0_wp, &
      budget_pressure = 4.0_wp

contains

   !> Run all tests.
   subroutine run_hertz_tests()
      call test_table()
      call test_circle()
      call test_identities()
      call test_monotone()
      call test_continuity()
      call test_scaling()
      call test_domain()
      call test_small_approach()
      call test_set_up()
      call test_energy()
      call test_inverse()
      call test_models()
      call test_newton()
      call test_vilke()
      call test_vilke_spot()
   end subroutine run_hertz_tests

   !> Exact contact.
   subroutine exact(curvature_a, curvature_b, modulus, approach, result)
      !> Half relative curvature A [1/m].
      real(wp), intent(in) :: curvature_a
      !> Half relative curvature B [1/m].
      real(wp), intent(in) :: curvature_b
      !> Effective modulus [Pa].
      real(wp), intent(in) :: modulus
      !> Approach [m].
      real(wp), intent(in) :: approach
      !> The contact.
      type(hertz_spot_type), intent(out) :: result

      call hertz_contact(curvature_a, curvature_b, modulus, approach, result)
   end subroutine exact

   !> Difference in units in the last place of the expected number.
   pure function ulps(value, expected)
      !> The number.
      real(wp), intent(in) :: value
      !> What it should be, not zero.
      real(wp), intent(in) :: expected
      real(wp) :: ulps

      ulps = abs(value - expected)/spacing(expected)
   end function ulps

   !> A random contact with A/B down to a bound.
   subroutine draw(random, low, curvature_a, curvature_b, modulus, approach)
      !> The generator.
      type(random_type), intent(inout) :: random
      !> Decimal logarithm of the smallest A/B.
      real(wp), intent(in) :: low
      !> Half relative curvature A [1/m].
      real(wp), intent(out) :: curvature_a
      !> Half relative curvature B [1/m].
      real(wp), intent(out) :: curvature_b
      !> Effective modulus [Pa].
      real(wp), intent(out) :: modulus
      !> Approach [m].
      real(wp), intent(out) :: approach

      curvature_b = 10.0_wp**random%uniform(-2.0_wp, 5.0_wp)
      curvature_a = min(curvature_b*10.0_wp**random%uniform(low, 0.0_wp), curvature_b)
      modulus = 10.0_wp**random%uniform(5.0_wp, 12.0_wp)
      approach = 10.0_wp**random%uniform(-10.0_wp, -3.0_wp)
   end subroutine draw

   !> The table of reference values, within the error budget.
   subroutine test_table()
      type(table_type) :: table
      type(worst_type) :: c1, a, b, force, pressure, k_integral, e_integral, c
      type(hertz_spot_type) :: r
      real(wp), allocatable :: in(:, :), out(:, :)
      real(wp) :: g, s, t, inverse_k
      integer :: i

      call read_table("hertz", table)
      in = reshape([table%column("A"), table%column("B"), table%column("Estar"), &
         table%column("delta")], [table%rows, 4])
      out = reshape([table%column("c1"), table%column("a"), table%column("b"), table%column("N"), &
         table%column("p0"), table%column("K"), table%column("E"), table%column("c")], &
         [table%rows, 8])
      do i = 1, table%rows
         call exact(in(i, 1), in(i, 2), in(i, 3), in(i, 4), r)
         call c1%note(ulps(r%c1, out(i, 1)), i)
         call a%note(ulps(r%a, out(i, 2)), i)
         call b%note(ulps(r%b, out(i, 3)), i)
         call force%note(ulps(r%force, out(i, 4)), i)
         call pressure%note(ulps(r%pressure, out(i, 5)), i)
         call c%note(abs(1.0_wp - r%c1 - out(i, 8)), i)
         g = in(i, 1)/in(i, 2)
         call hertz_shape(g, s, t, inverse_k)
         call k_integral%note(ulps(1.0_wp/inverse_k, out(i, 6)), i)
         call e_integral%note(ulps(t*(1.0_wp + g)/inverse_k, out(i, 7)), i)
      end do
      call c1%check_below(budget_c1, "table: c1, ulp")
      call a%check_below(budget_axis, "table: a, ulp")
      call b%check_below(budget_axis, "table: b, ulp")
      call force%check_below(budget_force, "table: N, ulp")
      call pressure%check_below(budget_pressure, "table: p0, ulp")
      call c%check_below(5.0e-16_wp, "table: c, absolute")
      call k_integral%check_below(3.0_wp, "table: K from 1/K, ulp")
      call e_integral%check_below(5.0_wp, "table: E = K t (1 + g), ulp")
   end subroutine test_table

   !> Circle: c1 = 1 and a = b without any error; next to it c = (4/3) (1 - g).
   subroutine test_circle()
      type(random_type) :: random
      type(worst_type) :: shape, force, pressure, near
      type(hertz_spot_type) :: r
      real(wp) :: a, b, modulus, approach, c1, t, inverse_k, gap
      integer :: i

      do i = 1, 2000
         call draw(random, -1.0_wp, a, b, modulus, approach)
         call exact(b, b, modulus, approach, r)
         call shape%note(abs(r%c1 - 1.0_wp) + abs(r%a - r%b), i)
         call shape%note(ulps(r%a, sqrt(0.5_wp*approach/b)) - 1.0_wp, i)
         call force%note(ulps(r%force, (4.0_wp/3.0_wp)*modulus*sqrt(0.5_wp/b)*approach &
            *sqrt(approach)), i)
         call pressure%note(ulps(r%pressure, 1.5_wp*r%force/(pi*r%a**2)), i)
         gap = 10.0_wp**random%uniform(-9.0_wp, -3.0_wp)
         call hertz_shape(1.0_wp - gap, c1, t, inverse_k)
         gap = 1.0_wp - (1.0_wp - gap)
         call near%note(abs((1.0_wp - c1)/gap - 4.0_wp/3.0_wp) - gap - 1.0e-15_wp/gap, i)
      end do
      call shape%check_below(0.0_wp, "circle: c1 = 1, a = b = sqrt(R d)")
      call force%check_below(8.0_wp, "circle: N = (4/3) E* sqrt(R) d^(3/2), ulp")
      call pressure%check_below(8.0_wp, "circle: p0 = 3 N/(2 pi a^2), ulp")
      call near%check_below(0.0_wp, "circle: next to it c = (4/3) (1 - g)")
      call hertz_shape(1.0_wp, c1, t, inverse_k)
      call check_close(t, 0.5_wp, 0.0_wp, "circle: t = 1/2")
      call check_relative(inverse_k, 2.0_wp/pi, epsilon(1.0_wp), "circle: K = pi/2")
   end subroutine test_circle

   !> What the elliptic integrals of c1 give back, E = K t (1 + g), area times mean pressure.
   subroutine test_identities()
      type(random_type) :: random
      type(worst_type) :: equation, ratio, k_of, e_of, area, minor, leading
      type(hertz_spot_type) :: r
      real(wp) :: a, b, modulus, approach, g, c1, t, inverse_k, k, e, bb, d
      integer :: i

      do i = 1, 20000
         call draw(random, merge(-20.0_wp, -3.0_wp, modulo(i, 2) == 0), a, b, modulus, approach)
         call exact(a, b, modulus, approach, r)
         g = a/b
         call hertz_shape(g, c1, t, inverse_k)
         call complete_elliptic(c1, k, e)
         call complete_elliptic_bd(c1, bb, d)
         call equation%note(abs(c1*d/(bb*g) - 1.0_wp), i)
         call ratio%note(abs(bb/(t*k) - 1.0_wp), i)
         call k_of%note(abs(k*inverse_k - 1.0_wp), i)
         call e_of%note(abs(t*(1.0_wp + g)/(inverse_k*e) - 1.0_wp), i)
         call area%note(abs(2.0_wp/3.0_wp*pi*r%a*r%b*r%pressure/r%force - 1.0_wp), i)
         call minor%note(abs((r%b/r%a)**2/r%c1 - 1.0_wp), i)
         call leading%note(abs(c1 - r%c1), i)
      end do
      call equation%check_below(3.0e-15_wp, "identities: g = c1 D/B")
      call ratio%check_below(2.0e-15_wp, "identities: t = B/K")
      call k_of%check_below(2.0e-15_wp, "identities: K")
      call e_of%check_below(2.0e-15_wp, "identities: E = K t (1 + g)")
      call area%check_below(2.0e-15_wp, "identities: N = (2/3) pi a b p0")
      call minor%check_below(2.0e-15_wp, "identities: c1 = (b/a)^2")
      call leading%check_below(0.0_wp, "identities: hertz_shape and hertz_contact give the same c1")
   end subroutine test_identities

   !> t, 1/K and c1 grow with g all over the domain, also from segment to segment.
   subroutine test_monotone()
      integer, parameter :: n = 200000
      type(worst_type) :: t_falls, k_falls, c1_falls
      real(wp) :: g, c1, t, inverse_k, last(3)
      integer :: i

      last = 0.0_wp
      do i = 0, n
         ! Steps are at least a thousand units in the last place of t.
         if (modulo(i, 2) == 0) then
            g = exp(-177.0_wp*real(n - i, wp)/n)
         else
            g = exp(-177.0_wp*(real(n - i, wp) + 1.0e-4_wp)/n)
         end if
         call hertz_shape(min(g, 1.0_wp), c1, t, inverse_k)
         call t_falls%note(last(1) - t, i + 1)
         call k_falls%note(last(2) - inverse_k, i + 1)
         call c1_falls%note(last(3) - c1, i + 1)
         last = [t, inverse_k, c1]
      end do
      call t_falls%check_below(0.0_wp, "monotone: t(g)")
      call k_falls%check_below(0.0_wp, "monotone: 1/K(g)")
      call c1_falls%check_below(0.0_wp, "monotone: c1(g)")
      call check(max(t_falls%value, k_falls%value, c1_falls%value) < 0.0_wp, "monotone: strictly")
   end subroutine test_monotone

   !> Neighbouring numbers on both sides of each boundary between segments.
   subroutine test_continuity()
      type(worst_type) :: direct, logarithmic, method
      real(wp) :: g, c1, above(2), below(2), y
      integer :: i, part

      do i = -10, -1
         do part = 0, 15
            g = 2.0_wp**i*(1.0_wp + real(part, wp)/16.0_wp)
            call sides(g, nearest(g, -1.0_wp))
            if (i == -10 .and. part == 0) then
               call method%note(maxval(abs(above - below)/spacing(above)), 1)
            else
               call direct%note(maxval(abs(above - below)/spacing(above)), 11 + i)
            end if
         end do
      end do
      call sides(1.0_wp, nearest(1.0_wp, -1.0_wp))
      call direct%note(maxval(abs(above - below)/spacing(above)), 11)
      do i = 2, 7
         do part = 0, 15
            y = 2.0_wp**i*(1.0_wp + real(part, wp)/16.0_wp)
            if (y < 6.94_wp .or. y > 177.0_wp) cycle
            ! The boundary is where the rounded logarithm passes y.
            g = exp(-y)
            call sides(g*(1.0_wp + 4.0e-16_wp*y), g*(1.0_wp - 4.0e-16_wp*y))
            call logarithmic%note(maxval(abs(above - below)/spacing(above)), i)
         end do
      end do
      call direct%check_below(2.0_wp, "continuity: segments of g, ulp")
      call method%check_below(2.0_wp, "continuity: from g to log(g), ulp")
      ! 8e-16 y of g is 8e-16 y/(y + 4) of t.
      call logarithmic%check_below(9.0_wp, "continuity: segments of log(g), ulp")

   contains

      !> t and 1/K at two values of g.
      subroutine sides(g_above, g_below)
         !> The larger one.
         real(wp), intent(in) :: g_above
         !> The smaller one.
         real(wp), intent(in) :: g_below

         call hertz_shape(g_above, c1, above(1), above(2))
         call hertz_shape(g_below, c1, below(1), below(2))
      end subroutine sides

   end subroutine test_continuity

   !> Powers of two in the units change nothing but the exponents.
   subroutine test_scaling()
      type(random_type) :: random
      type(worst_type) :: scaled
      type(hertz_spot_type) :: r, s
      real(wp) :: a, b, modulus, approach, length, stress
      integer :: i

      do i = 1, 2000
         call draw(random, -12.0_wp, a, b, modulus, approach)
         length = 2.0_wp**(2*nint(random%uniform(-20.0_wp, 20.0_wp)))
         stress = 2.0_wp**nint(random%uniform(-60.0_wp, 60.0_wp))
         call exact(a, b, modulus, approach, r)
         call exact(a/length, b/length, modulus*stress, approach*length, s)
         call scaled%note(abs(s%c1 - r%c1) + abs(s%a/length - r%a) + abs(s%b/length - r%b) &
            + abs(s%force/(stress*length**2) - r%force) + abs(s%pressure/stress - r%pressure), i)
      end do
      call scaled%check_below(0.0_wp, "scaling: units by powers of two")
   end subroutine test_scaling

   !> NaN outside the domain, without an exception; no overflow at its corners.
   subroutine test_domain()
      real(wp), parameter :: bad(6) = [0.0_wp, -0.0_wp, -1.0_wp, 1.0e-45_wp, 4.0e38_wp, 1.0e300_wp]
      real(wp), parameter :: corner(2) = [2.0_wp**(-128), 2.0_wp**127]
      type(hertz_model_type), allocatable :: models(:)
      type(hertz_type) :: h
      type(hertz_spot_type) :: s
      real(wp) :: outside(8), x(4), g(5), c1, t, inverse_k
      integer :: i, k, m
      logical :: passed, finite

      outside(1:6) = bad
      outside(7) = ieee_value(t, ieee_quiet_nan)
      outside(8) = ieee_value(t, ieee_positive_inf)
      models = [hertz_models(), vilke_models()]
      do m = 1, size(models)
         passed = .true.
         do k = 1, 4
            do i = 1, size(outside)
               if (k == 4 .and. (i <= 2 .or. i == 4)) cycle
               x = [1.0_wp, 1.0_wp, 1.0_wp, 1.0_wp]
               x(k) = outside(i)
               passed = passed .and. .not. in_hertz_domain(x(1), x(2), x(3), x(4))
               call models(m)%kernel(x(1), x(2), x(3), x(4), s)
               passed = passed .and. ieee_is_nan(s%c1) .and. ieee_is_nan(s%a) &
                  .and. ieee_is_nan(s%b) .and. ieee_is_nan(s%force) .and. ieee_is_nan(s%pressure)
            end do
         end do
         call models(m)%kernel(1.0_wp + epsilon(1.0_wp), 1.0_wp, 1.0_wp, 1.0_wp, s)
         passed = passed .and. ieee_is_nan(s%c1) .and. ieee_is_nan(s%force)
         call check(passed, "domain: NaN outside, " // trim(models(m)%info%name))
      end do
      finite = .true.
      do i = 0, 15
         x = corner([1 + ibits(i, 0, 1), 1 + ibits(i, 1, 1), 1 + ibits(i, 2, 1), &
            1 + ibits(i, 3, 1)])
         if (x(1) > x(2)) cycle
         call hertz_contact(x(1), x(2), x(3), x(4), s)
         finite = finite .and. min(s%c1, s%a, s%b, s%force, s%pressure) >= tiny(c1) &
            .and. max(s%c1, s%a, s%b, s%force, s%pressure) <= huge(c1)
      end do
      call check(finite, "domain: positive and finite at its corners")
      passed = .true.
      g = [0.0_wp, -0.5_wp, 1.0_wp + epsilon(1.0_wp), 1.0e-78_wp, outside(7)]
      do i = 1, size(g)
         call hertz_shape(g(i), c1, t, inverse_k)
         passed = passed .and. ieee_is_nan(c1) .and. ieee_is_nan(t) .and. ieee_is_nan(inverse_k)
      end do
      h = new_hertz(2.0_wp, 1.0_wp, 1.0_wp)
      passed = passed .and. ieee_is_nan(h%stiffness) .and. ieee_is_nan(h%c1) &
         .and. ieee_is_nan(hertz_approach(2.0_wp, 1.0_wp, 1.0_wp, 1.0_wp)) &
         .and. ieee_is_nan(hertz_approach(1.0_wp, 1.0_wp, 1.0_wp, -1.0_wp)) &
         .and. ieee_is_nan(vilke_stiffness(2.0_wp, 1.0_wp, 1.0_wp))
      call check(passed, "domain: NaN outside, shape, set-up, inverse")
   end subroutine test_domain

   !> Approaches from the smallest number on, and zero.
   subroutine test_small_approach()
      type(worst_type) :: axes, force
      type(hertz_spot_type) :: r, one
      type(hertz_model_type), allocatable :: models(:)
      real(wp) :: d
      logical :: passed
      integer :: i

      call exact(3.0_wp, 70.0_wp, 1.0e10_wp, 1.0_wp, one)
      do i = -1022, 120
         d = 2.0_wp**i
         call exact(3.0_wp, 70.0_wp, 1.0e10_wp, d, r)
         call axes%note(abs(r%a/(one%a*sqrt(d)) - 1.0_wp) + abs(r%b/(one%b*sqrt(d)) - 1.0_wp) &
            + abs(r%pressure/(one%pressure*sqrt(d)) - 1.0_wp) + abs(r%c1 - one%c1), i + 1023)
         if (i > -600) call force%note(abs(r%force/(one%force*d*sqrt(d)) - 1.0_wp), i + 1023)
      end do
      call axes%check_below(2.0e-15_wp, "small approach: a, b, p0 as sqrt(d)")
      call force%check_below(2.0e-15_wp, "small approach: N as d^(3/2)")
      models = [hertz_models(), vilke_models()]
      passed = .true.
      do i = 1, size(models)
         call models(i)%kernel(3.0_wp, 5.0_wp, 1.0e10_wp, 0.0_wp, r)
         passed = passed .and. max(abs(r%a), abs(r%b), abs(r%force), abs(r%pressure)) <= 0.0_wp &
            .and. r%c1 > 0.4_wp .and. r%c1 < 0.6_wp
      end do
      call check(passed, "small approach: nothing but a shape at zero")
   end subroutine test_small_approach

   !> Contact with constant curvatures.
   subroutine test_set_up()
      type(random_type) :: random
      type(worst_type) :: c1, axes, force, pressure
      type(hertz_spot_type) :: r, s
      type(hertz_type) :: h
      real(wp) :: a, b, modulus, d
      integer :: i

      do i = 1, 20000
         call draw(random, -20.0_wp, a, b, modulus, d)
         call exact(a, b, modulus, d, r)
         h = new_hertz(a, b, modulus)
         call h%contact(d, s)
         call c1%note(abs(h%c1 - r%c1), i)
         call axes%note(max(ulps(s%a, r%a), ulps(s%b, r%b)), i)
         call force%note(max(ulps(s%force, r%force), ulps(h%force(d), r%force)), i)
         call pressure%note(ulps(s%pressure, r%pressure), i)
      end do
      call c1%check_below(0.0_wp, "set-up: the same c1")
      call axes%check_below(4.0_wp, "set-up: the same axes, ulp")
      call force%check_below(6.0_wp, "set-up: the same force, ulp")
      call pressure%check_below(6.0_wp, "set-up: the same pressure, ulp")
   end subroutine test_set_up

   !> The energy is the integral of the force.
   subroutine test_energy()
      !> Nodes of Gauss's rule with three nodes.
      real(wp), parameter :: x(3) = [0.112701665379258311_wp, 0.5_wp, 0.887298334620741689_wp]
      !> Its weights, times 18.
      real(wp), parameter :: w(3) = [5.0_wp, 8.0_wp, 5.0_wp]
      type(random_type) :: random
      type(worst_type) :: energy
      type(hertz_type) :: h
      real(wp) :: a, b, modulus, d, total
      integer :: i, k

      do i = 1, 2000
         call draw(random, -8.0_wp, a, b, modulus, d)
         h = new_hertz(a, b, modulus)
         ! With d s^2 for the approach the integrand is a polynomial.
         total = 0.0_wp
         do k = 1, 3
            total = total + w(k)/18.0_wp*2.0_wp*d*x(k)*h%force(d*x(k)**2)
         end do
         call energy%note(abs(h%energy(d)/total - 1.0_wp), i)
      end do
      call energy%check_below(3.0e-15_wp, "energy: integral of the force")
   end subroutine test_energy

   !> From force to approach.
   subroutine test_inverse()
      type(random_type) :: random
      type(worst_type) :: there_and_back, same, power
      type(hertz_type) :: h, unit
      real(wp) :: a, b, modulus, d, x
      integer :: i

      unit%stiffness = 1.0_wp
      do i = 1, 20000
         call draw(random, -20.0_wp, a, b, modulus, d)
         h = new_hertz(a, b, modulus)
         call there_and_back%note(ulps(h%approach(h%force(d)), d), i)
         call same%note(abs(hertz_approach(a, b, modulus, h%force(d))/d - 1.0_wp), i)
         ! Cubes of numbers with few digits are exact.
         x = real(nint(random%uniform(1.0_wp, 1.0e5_wp)), wp) &
            *2.0_wp**nint(random%uniform(-300.0_wp, 300.0_wp))
         call power%note(ulps(unit%approach(x**3), x**2), i)
      end do
      call there_and_back%check_below(5.0_wp, "inverse: there and back, ulp")
      call same%check_below(2.0e-15_wp, "inverse: without set-up")
      call power%check_below(1.0_wp, "inverse: x^(2/3), ulp")
      call check_close(h%approach(0.0_wp), 0.0_wp, 0.0_wp, "inverse: no force, no approach")
      call check_relative(unit%approach(tiny(x)/4096.0_wp), 2.0_wp**(-2.0_wp*1034.0_wp/3.0_wp), &
         1.0e-12_wp, "inverse: of a subnormal number")
   end subroutine test_inverse

   !> Each way to compute a contact: it can be called, and its error is what the page says.
   subroutine test_models()
      !> Names, and bounds of the relative errors of c1, a, b, N, p0 for A/B >= 0.01.
      character(len=*), parameter :: names(4) = [character(len=24) :: "tables", "newton", &
         "brewe_hamrock", "greenwood"]
      real(wp), parameter :: bounds(5, 4) = reshape([ &
         0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
         2.0e-15_wp, 1.0e-15_wp, 1.0e-15_wp, 2.0e-15_wp, 2.0e-15_wp, &
         0.13_wp, 0.065_wp, 0.025_wp, 0.09_wp, 0.006_wp, &
         0.30_wp, 0.02_wp, 0.17_wp, 0.31_wp, 0.17_wp], [5, 4])
      type(hertz_model_type), allocatable :: models(:)
      type(random_type) :: random
      type(worst_type) :: errors(5)
      type(hertz_spot_type) :: r, s
      real(wp) :: a, b, modulus, d
      character(len=*), parameter :: outputs(5) = [character(len=2) :: "c1", "a", "b", "N", "p0"]
      integer :: i, k, m

      models = hertz_models()
      call check(size(models) == size(names), "models: all of them")
      do m = 1, min(size(models), size(names))
         call check(models(m)%info%name == names(m) .and. models(m)%info%summary /= "" &
            .and. models(m)%info%keys /= "" .and. models(m)%info%reference /= "", &
            "models: description of " // trim(names(m)))
         errors = worst_type()
         do i = 1, 5000
            call draw(random, -2.0_wp, a, b, modulus, d)
            call exact(a, b, modulus, d, r)
            call models(m)%kernel(a, b, modulus, d, s)
            call errors(1)%note(abs(s%c1/r%c1 - 1.0_wp), i)
            call errors(2)%note(abs(s%a/r%a - 1.0_wp), i)
            call errors(3)%note(abs(s%b/r%b - 1.0_wp), i)
            call errors(4)%note(abs(s%force/r%force - 1.0_wp), i)
            call errors(5)%note(abs(s%pressure/r%pressure - 1.0_wp), i)
         end do
         do k = 1, 5
            call errors(k)%check_below(bounds(k, m), "models: error of " // trim(names(m)) &
               // ", " // trim(outputs(k)))
            if (m > 2) call check(errors(k)%value > 0.8_wp*bounds(k, m), &
               "models: and not much less, " // trim(names(m)) // ", " // trim(outputs(k)))
         end do
      end do
   end subroutine test_models

   !> Newton's method over the whole range, and with other elliptic integrals.
   subroutine test_newton()
      type(hertz_model_type), allocatable :: models(:)
      type(random_type) :: random
      type(worst_type) :: tables, agm
      type(hertz_spot_type) :: r, s
      real(wp) :: a, b, modulus, d
      integer :: i

      models = hertz_models()
      do i = 1, 5000
         call draw(random, merge(-70.0_wp, -20.0_wp, modulo(i, 2) == 0), a, b, modulus, d)
         if (a < 1.0e-38_wp) cycle
         if (modulo(i, 5) == 0) a = b*(1.0_wp - 10.0_wp**random%uniform(-16.0_wp, 0.0_wp))
         call exact(a, b, modulus, d, r)
         call models(2)%kernel(a, b, modulus, d, s)
         call tables%note(max(abs(s%c1/r%c1 - 1.0_wp), abs(s%a/r%a - 1.0_wp), &
            abs(s%b/r%b - 1.0_wp), abs(s%force/r%force - 1.0_wp), &
            abs(s%pressure/r%pressure - 1.0_wp)), i)
         if (a < 1.0e-3_wp*b) cycle
         call hertz_newton_with(elliptic_agm, a, b, modulus, d, s)
         call agm%note(max(abs(s%c1/r%c1 - 1.0_wp), abs(s%a/r%a - 1.0_wp), &
            abs(s%b/r%b - 1.0_wp), abs(s%force/r%force - 1.0_wp), &
            abs(s%pressure/r%pressure - 1.0_wp)), i)
      end do
      call tables%check_below(4.0e-15_wp, "newton: with tabulated integrals")
      call agm%check_below(1.0e-14_wp, "newton: with the arithmetic-geometric mean")
   end subroutine test_newton

   !> Vil'ke's force: Hertz's on the circle, softer the more slender the spot; its formulas for c.
   subroutine test_vilke()
      !> c, and by how many per cent of Vil'ke's force Hertz's is larger.
      real(wp), parameter :: known(2, 3) = reshape([0.687_wp, 1.6_wp, 0.9_wp, 6.0_wp, &
         0.95_wp, 11.0_wp], [2, 3])
      real(wp), parameter :: digits(3) = [0.05_wp, 0.5_wp, 0.5_wp]
      type(random_type) :: random
      type(worst_type) :: circle, stiffness, softer
      type(hertz_spot_type) :: r
      real(wp) :: a, b, modulus, d, bb, dd, g, last
      integer :: i

      do i = 1, 3
         call complete_elliptic_bd(1.0_wp - known(1, i), bb, dd)
         g = (1.0_wp - known(1, i))*dd/bb
         call exact(g, 1.0_wp, 1.0_wp, 1.0_wp, r)
         call check_close(100.0_wp*(r%force/vilke_force(g, 1.0_wp, 1.0_wp, 1.0_wp) - 1.0_wp), &
            known(2, i), digits(i), "vilke: softness")
         if (i == 1) call check_close(1.0_wp - chord_c1(g), 0.643_wp, 0.0005_wp, "vilke: chord")
         if (i == 1) call check_close(1.0_wp - power_c1(g), 0.688_wp, 0.0005_wp, "vilke: power")
      end do
      last = 1.0_wp + epsilon(last)
      do i = 1, 2000
         call draw(random, -8.0_wp, a, b, modulus, d)
         call exact(b, b, modulus, d, r)
         call circle%note(ulps(vilke_force(b, b, modulus, d), r%force), i)
         call stiffness%note(abs(vilke_stiffness(a, b, modulus)*d*sqrt(d) &
            /vilke_force(a, b, modulus, d) - 1.0_wp), i)
         g = 10.0_wp**(-0.005_wp*i)
         call exact(g, 1.0_wp, 1.0_wp, 1.0_wp, r)
         g = vilke_force(g, 1.0_wp, 1.0_wp, 1.0_wp)/r%force
         call softer%note(g - last, i)
         last = g
      end do
      call circle%check_below(8.0_wp, "vilke: Hertz's force on the circle, ulp")
      call stiffness%check_below(2.0e-15_wp, "vilke: stiffness")
      call softer%check_below(0.0_wp, "vilke: the softer the more slender")
   end subroutine test_vilke

   !> Spot of Vil'ke's models.
   subroutine test_vilke_spot()
      type(hertz_model_type), allocatable :: models(:)
      type(random_type) :: random
      type(worst_type) :: spot, volume, of_c1, force
      type(hertz_spot_type) :: r, s
      real(wp) :: a, b, modulus, d
      integer :: i, m

      models = vilke_models()
      call check(size(models) == 3 .and. models(1)%info%name == "chord" &
         .and. models(2)%info%name == "power" .and. models(3)%info%name == "exact", "vilke: models")
      do i = 1, 5000
         call draw(random, merge(-20.0_wp, -1.0_wp, modulo(i, 2) == 0), a, b, modulus, d)
         call exact(a, b, modulus, d, r)
         call vilke_exact(a, b, modulus, d, s)
         call spot%note(max(abs(s%a/r%a - 1.0_wp), abs(s%b/r%b - 1.0_wp)), i)
         do m = 1, size(models)
            call models(m)%kernel(a, b, modulus, d, s)
            call force%note(abs(s%force - vilke_force(a, b, modulus, d)), i)
            if (m == 1 .and. a < 0.0937_wp*b) cycle
            call volume%note(abs(2.0_wp/3.0_wp*pi*s%a*s%b*s%pressure/s%force - 1.0_wp), i)
            call of_c1%note(abs((s%b/s%a)**2/s%c1 - 1.0_wp), i)
         end do
      end do
      call spot%check_below(2.0e-15_wp, "vilke: Hertz's spot for the exact c1")
      call force%check_below(0.0_wp, "vilke: the same force for each formula")
      call volume%check_below(2.0e-15_wp, "vilke: N = (2/3) pi a b p0")
      call of_c1%check_below(2.0e-15_wp, "vilke: c1 = (b/a)^2")
      call models(1)%kernel(0.0936_wp, 1.0_wp, 1.0_wp, 1.0_wp, s)
      call check(ieee_is_nan(s%c1) .and. ieee_is_nan(s%a) .and. s%force > 0.0_wp, &
         "vilke: the chord ends")
      do m = 1, size(models)
         call models(m)%kernel(2.0_wp, 2.0_wp, 1.0_wp, 1.0_wp, s)
         call check_close(s%c1, 1.0_wp, 0.0_wp, "vilke: circle, " // trim(models(m)%info%name))
      end do
   end subroutine test_vilke_spot

end module test_hertz
