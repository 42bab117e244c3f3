!> Tests of the friction wrench on elliptic spots: shape, reference values, limits, properties of
!> the potential, joints between the methods, derivatives, and where the approximations fail.
!>
!> Error budget of the exact wrench, in units of f N and f N a. The stated accuracy is 5e-15
!> absolute for 1e-3 <= k <= 1, 1e-12 down to k = 1e-6, 1e-12 relative in the torque for k >= 0.2,
!> and 1e-13 of the largest entry in the Jacobian. All terms of a sum are positive, so errors are
!> not amplified: the 15 operations on a term, each wrong by up to eps/2 = 1.1e-16, make 4e-16 if
!> they add like a random walk; the constants of the shape and the scaled state 2e-16; the rules
!> 2e-16. That makes 8e-16, and the bounds are twice that.
module test_wrench_ellipse
   use, intrinsic :: ieee_arithmetic, only : ieee_is_nan, ieee_negative_inf, ieee_positive_inf, &
      ieee_quiet_nan, ieee_value
   use contensou_base_kinds, only : pi, wp
   use contensou_contact_friction_ladder, only : rung_type
   use contensou_contact_friction_law, only : sliding_type
   use contensou_contact_spot, only : circular_shape, elliptic_shape, elliptic_shape_of_c1, &
      spot_shape_type
   use contensou_contact_wrench, only : slip_type, wrench_coulomb, wrench_exact, &
      wrench_exact_jacobian, wrench_exact_potential, wrench_jacobian_kernel, wrench_kernel, &
      wrench_pade11, wrench_pade22, wrench_simplified, wrench_simplified_jacobian
   use test_harness, only : check, check_close, check_relative, random_type, read_table, &
      table_type, worst_type
   implicit none(type, external)
   private

   public :: run_wrench_ellipse_tests

   !> Precision of the reference formulas, which cancel.
   integer, parameter :: qp = selected_real_kind(30)

   !> Number of random states for each property.
   integer, parameter :: n_states = 100000

   !> Number of nodes of a panel of the reference quadrature.
   integer, parameter :: n_nodes = 28

   !> Bound of the absolute error of the wrench, see the budget.
   real(wp), parameter :: wrench_bound = 1.6e-15_wp

   !> Bound of the error of the Jacobian relative to its largest entry.
   real(wp), parameter :: jacobian_bound = 2.0e-14_wp

   !> Ratios sqrt(l)/W where the direct rule changes, and where the panels of slender spots begin.
   real(wp), parameter :: direct_joints(5) = [8.0_wp, 2.25_wp, 1.15_wp, 0.45_wp, 0.25_wp]

   !> Ratios sqrt(l)/(k W) where the rule at the rim changes; the last is where it ends.
   real(wp), parameter :: rim_joints(3) = [0.22_wp, 0.5_wp, 1.0_wp]

   !> Ratios of the ends of a panel where its number of nodes or the number of panels changes.
   real(wp), parameter :: panel_joints(3) = [3.25_wp, 6.5_wp, 6.5_wp*3.25_wp]

   !> Axis ratios on which the joints are tested.
   real(wp), parameter :: ratios(14) = [1.0_wp, 0.999_wp, 0.9_wp, 0.7_wp, 0.5_wp, 0.3_wp, 0.24_wp, &
      0.1_wp, 0.05_wp, 0.03_wp, 1.0e-2_wp, 1.0e-3_wp, 1.0e-4_wp, 1.0e-6_wp]

contains

   !> Run all tests.
   subroutine run_wrench_ellipse_tests()
      call test_shape()
      call test_shape_domain()
      call test_reference()
      call test_reference_jacobian()
      call test_quadrature()
      call test_quadrature_jacobian()
      call test_dimensional()
      call test_circle()
      call test_pure_motions()
      call test_expansions()
      call test_needle()
      call test_homogeneity()
      call test_parities()
      call test_potential()
      call test_limit_surface()
      call test_jacobian_structure()
      call test_jacobian_integral()
      call test_regularisation()
      call test_rim()
      call test_joints()
      call test_coulomb()
      call test_simplified()
      call test_simplified_jacobian()
      call test_approximations()
      call test_without_torque()
      call test_extremes()
      call test_outside_domain()
   end subroutine run_wrench_ellipse_tests

   !> Wrench as a vector (Fx, Fy, T) of the velocity (vx, vy, W).
   function wrench_of(kernel, shape, v, delta) result(w)
      !> The rung.
      procedure(wrench_kernel) :: kernel
      type(spot_shape_type), intent(in) :: shape
      !> Velocity (vx, vy, W).
      real(wp), intent(in) :: v(3)
      !> Regularisation velocity.
      real(wp), intent(in) :: delta
      real(wp) :: w(3)

      call kernel(shape, slip_type(v(1), v(2), v(3), delta), .true., w)
   end function wrench_of

   !> Exact wrench without regularisation.
   function exact(shape, v) result(w)
      type(spot_shape_type), intent(in) :: shape
      !> Velocity (vx, vy, W).
      real(wp), intent(in) :: v(3)
      real(wp) :: w(3)

      w = wrench_of(wrench_exact, shape, v, 0.0_wp)
   end function exact

   !> Potential of the exact wrench.
   function potential(shape, v, delta) result(phi)
      type(spot_shape_type), intent(in) :: shape
      !> Velocity (vx, vy, W).
      real(wp), intent(in) :: v(3)
      !> Regularisation velocity.
      real(wp), intent(in) :: delta
      real(wp) :: phi

      phi = wrench_exact_potential(shape, slip_type(v(1), v(2), v(3), delta))
   end function potential

   !> A random axis ratio from 1e-6 to 1, in part close to 1.
   function random_ratio(random) result(k)
      !> The generator.
      class(random_type), intent(inout) :: random
      real(wp) :: k

      k = random%uniform(-6.6_wp, 0.6_wp)
      if (k < -6.0_wp) then
         k = 1.0_wp - 10.0_wp**(2.0_wp*(k + 6.0_wp)*8.0_wp - 1.0_wp)
      else if (k > 0.3_wp) then
         k = 1.0_wp
      else
         k = 10.0_wp**min(k, 0.0_wp)
      end if
   end function random_ratio

   !> A random velocity: of any kind, near the rim of the spot, on an ellipse confocal with the
   !> spot, or in the direction of an axis.
   function random_velocity(random, shape) result(v)
      !> The generator.
      class(random_type), intent(inout) :: random
      type(spot_shape_type), intent(in) :: shape
      real(wp) :: v(3)
      real(wp) :: kind, psi, rho
      integer :: i

      kind = random%uniform(0.0_wp, 1.0_wp)
      if (kind < 0.35_wp) then
         do i = 1, 3
            v(i) = random%decades(-6.0_wp, 6.0_wp)
         end do
         if (kind < 0.05_wp) v(1) = 0.0_wp
         if (kind > 0.05_wp .and. kind < 0.1_wp) v(2) = 0.0_wp
         if (kind > 0.1_wp .and. kind < 0.12_wp) v(3) = 0.0_wp
         return
      end if
      psi = random%uniform(0.0_wp, 2.0_wp*pi)
      if (kind < 0.5_wp) then
         v = velocity_at(shape, 0.0_wp, psi)
         v(1:2) = v(1:2)*(1.0_wp + random%decades(-13.0_wp, -0.5_wp))
      else
         rho = abs(random%decades(-7.0_wp, 1.5_wp))
         v = velocity_at(shape, rho, psi)
      end if
      v = v*random%decades(-1.0_wp, 1.0_wp)
   end function random_velocity

   !> Velocity with the rotation centre on an ellipse confocal with the spot.
   pure function velocity_at(shape, rho, psi) result(v)
      type(spot_shape_type), intent(in) :: shape
      !> Ratio sqrt(l)/W; zero is the rim.
      real(wp), intent(in) :: rho
      !> Position on the ellipse.
      real(wp), intent(in) :: psi
      real(wp) :: v(3)

      v = [sqrt(shape%k2 + rho**2)*cos(psi), sqrt(1.0_wp + rho**2)*sin(psi), 1.0_wp]
   end function velocity_at

   !> Complete integrals and moments in quadruple precision by the arithmetic-geometric mean.
   pure subroutine reference_shape(c1, values)
      !> Complementary parameter.
      real(wp), intent(in) :: c1
      !> B, D, j11, j20.
      real(wp), intent(out) :: values(4)
      real(qp) :: a, g, c, s, next, big_k, big_e, b, d
      integer :: i

      a = 1.0_qp
      g = sqrt(real(c1, qp))
      c = 1.0_qp - real(c1, qp)
      s = 0.5_qp*c
      do i = 1, 14
         next = 0.5_qp*(a + g)
         s = s + 2.0_qp**(i - 1)*(0.5_qp*(a - g))**2
         g = sqrt(a*g)
         a = next
      end do
      big_k = acos(-1.0_qp)/(2.0_qp*a)
      big_e = big_k*(1.0_qp - s)
      d = (big_k - big_e)/c
      b = (big_e - real(c1, qp)*big_k)/c
      values = real([b, d, (d - b)/c, (b - real(c1, qp)*d)/(3.0_qp*c)], wp)
   end subroutine reference_shape

   !> Constants of the shape.
   subroutine test_shape()
      type(spot_shape_type) :: shape, other
      type(random_type) :: random
      type(worst_type) :: integrals, moments, same, near
      real(wp) :: k, expected(4)
      integer :: i

      do i = 1, 20000
         if (modulo(i, 2) == 0) then
            k = 10.0_wp**random%uniform(-20.0_wp, 0.0_wp)
         else
            k = 1.0_wp - 10.0_wp**random%uniform(-7.0_wp, -0.1_wp)
         end if
         shape = elliptic_shape(k)
         call reference_shape(shape%k2, expected)
         call integrals%note(max(abs(shape%b_integral/expected(1) - 1.0_wp), &
            abs(shape%d_integral/expected(2) - 1.0_wp)), i)
         call moments%note(max(abs(shape%j11/expected(3) - 1.0_wp), &
            abs(shape%j20/expected(4) - 1.0_wp)), i)
         other = elliptic_shape_of_c1(shape%k2)
         call same%note(max(abs(other%k/k - 1.0_wp), abs(other%j11/shape%j11 - 1.0_wp), &
            abs(other%b_integral - shape%b_integral), abs(other%j02/shape%j02 - 1.0_wp)), i)
      end do
      call integrals%check_below(8.0e-16_wp, "B and D of a shape")
      call moments%check_below(2.0e-15_wp, "j11 and j20 of a shape")
      call same%check_below(1.0e-15_wp, "the same shape from k and from c1")

      shape = elliptic_shape(1.0_wp)
      call check(maxval(abs(numbers(shape) - numbers(circular_shape))) <= 2.0e-16_wp, &
         "elliptic_shape(1) is the circle")
      do i = 10, 160
         k = 1.0_wp - 10.0_wp**(-0.1_wp*i)
         shape = elliptic_shape(k)
         call near%note(maxval(abs(numbers(shape) - numbers(circular_shape)))/(1.0_wp - k &
            + 1.0e-16_wp), i)
      end do
      call near%check_below(10.0_wp, "continuous towards the circle")
      shape = elliptic_shape(0.3_wp)
      call check_relative(shape%slope_x, 1.5_wp*shape%d_integral, 1.0e-16_wp, "k_x = (3/2) D")
      call check_relative(shape%slope_y, 1.5_wp*shape%b_integral, 1.0e-16_wp, "k_y = (3/2) B")
      call check_relative(shape%torque, 0.375_wp*(shape%b_integral + 0.09_wp*shape%d_integral), &
         3.0e-16_wp, "k_T = (3/8) E")
      call check_relative(shape%c, 0.91_wp, 3.0e-16_wp, "c = 1 - k^2")
   end subroutine test_shape

   !> The constants of a shape as a list.
   pure function numbers(shape) result(list)
      type(spot_shape_type), intent(in) :: shape
      real(wp) :: list(13)

      list = [shape%k, shape%k2, shape%inverse_k2, shape%c, shape%slope_x, shape%slope_y, &
         shape%torque, shape%b_integral, shape%d_integral, shape%e_integral, shape%j11, &
         shape%j20, shape%j02]
   end function numbers

   !> Outside their domain all constants are NaN.
   subroutine test_shape_domain()
      real(wp) :: bad(6)
      integer :: i

      bad = [0.0_wp, -0.5_wp, 1.0_wp + 1.0e-15_wp, ieee_value(1.0_wp, ieee_quiet_nan), &
         ieee_value(1.0_wp, ieee_positive_inf), ieee_value(1.0_wp, ieee_negative_inf)]
      do i = 1, size(bad)
         call check(all(ieee_is_nan(numbers(elliptic_shape(bad(i))))), "no shape of this k")
         call check(all(ieee_is_nan(numbers(elliptic_shape_of_c1(bad(i))))), "no shape of this c1")
      end do
   end subroutine test_shape_domain

   !> All rows of the table.
   subroutine test_reference()
      type(table_type) :: table
      real(wp), allocatable :: k(:), ux(:), uy(:), spins(:), fx(:), fy(:), tz(:)
      real(wp) :: w(3), expected(3), other(3), jacobian(3, 3)
      type(spot_shape_type) :: shape
      type(worst_type) :: force, torque, relative, reversed, with_jacobian, dissipated
      integer :: i

      call read_table("wrench", table)
      k = table%column("k")
      ux = table%column("ux")
      uy = table%column("uy")
      spins = table%column("wflag")
      fx = table%column("Fx")
      fy = table%column("Fy")
      tz = table%column("Tz")
      call check(table%rows >= 300 .and. minval(k) <= 1.0e-3_wp, "the table has slender spots")
      do i = 1, table%rows
         shape = elliptic_shape(k(i))
         expected = [fx(i), fy(i), tz(i)]
         w = exact(shape, [ux(i), uy(i), spins(i)])
         call force%note(maxval(abs(w(1:2) - expected(1:2))), i)
         call torque%note(abs(w(3) - tz(i)), i)
         if (k(i) >= 0.2_wp .and. spins(i) > 0.0_wp) call relative%note(abs(w(3)/tz(i) - 1.0_wp), i)
         other = exact(shape, [-ux(i), -uy(i), -spins(i)])
         call reversed%note(maxval(abs(w + other)), i)
         call wrench_exact_jacobian(shape, slip_type(ux(i), uy(i), spins(i)), other, jacobian)
         call with_jacobian%note(maxval(abs(w - other)), i)
         call dissipated%note(abs(potential(shape, [ux(i), uy(i), spins(i)], 0.0_wp) &
            + dot_product(expected, [ux(i), uy(i), spins(i)]))/norm2([ux(i), uy(i), spins(i)]), i)
      end do
      call force%check_below(wrench_bound, "force of the table")
      call torque%check_below(wrench_bound, "torque of the table")
      call relative%check_below(2.0e-14_wp, "torque of the table, relative, k >= 0.2")
      call reversed%check_below(0.0_wp, "table with the motion reversed")
      call with_jacobian%check_below(2.0e-16_wp, "wrench that comes with the Jacobian")
      call dissipated%check_below(wrench_bound, "potential of the table")
   end subroutine test_reference

   !> Values and derivatives of the table of derivatives.
   subroutine test_reference_jacobian()
      type(table_type) :: table
      real(wp), allocatable :: k(:), columns(:, :)
      real(wp) :: w(3), jacobian(3, 3), given(3, 3)
      type(spot_shape_type) :: shape
      type(worst_type) :: values, derivatives
      character(len=*), parameter :: names(12) = [character(len=6) :: "vx", "vy", "W", "Fx", "Fy", &
         "Tz", "dFxdvx", "dFxdvy", "dFydvy", "dFxdW", "dFydW", "dTdW"]
      integer :: i

      call read_table("wrench_jacobian", table)
      k = table%column("k")
      allocate(columns(table%rows, size(names)))
      do i = 1, size(names)
         columns(:, i) = table%column(trim(names(i)))
      end do
      do i = 1, table%rows
         shape = elliptic_shape(k(i))
         call wrench_exact_jacobian(shape, &
            slip_type(columns(i, 1), columns(i, 2), columns(i, 3)), w, jacobian)
         call values%note(maxval(abs(w - columns(i, 4:6))), i)
         given(1, :) = columns(i, [7, 8, 10])
         given(2, :) = columns(i, [8, 9, 11])
         given(3, :) = columns(i, [10, 11, 12])
         call derivatives%note(maxval(abs(jacobian - given))/maxval(abs(given)), i)
      end do
      call check(table%rows >= 30, "the table of derivatives has its rows")
      call values%check_below(wrench_bound, "wrench of the table of derivatives")
      call derivatives%check_below(jacobian_bound, "derivatives of the table")
   end subroutine test_reference_jacobian

   !> The wrench at random states against adaptive panels in quadruple precision.
   subroutine test_quadrature()
      type(spot_shape_type) :: shape
      type(random_type) :: random
      type(worst_type) :: force, torque, relative
      real(wp) :: v(3), w(3)
      real(qp) :: nodes(n_nodes), weights(n_nodes), expected(3)
      integer :: i

      call gauss_rule(nodes, weights)
      do i = 1, 3000
         shape = elliptic_shape(random_ratio(random))
         v = random_velocity(random, shape)
         if (.not. abs(v(3)) > 0.0_wp) cycle
         w = exact(shape, v)
         call quadrature(shape%k, real(v, qp), nodes, weights, expected)
         call force%note(real(maxval(abs(w(1:2) - expected(1:2))), wp), i)
         call torque%note(real(abs(w(3) - expected(3)), wp), i)
         if (shape%k >= 0.2_wp) call relative%note(real(abs(w(3)/expected(3) - 1.0_qp), wp), i)
      end do
      call force%check_below(wrench_bound, "force by quadrature")
      call torque%check_below(wrench_bound, "torque by quadrature")
      call relative%check_below(2.0e-14_wp, "torque by quadrature, relative, k >= 0.2")
   end subroutine test_quadrature

   !> The Jacobian at random states against differences in quadruple precision.
   subroutine test_quadrature_jacobian()
      type(spot_shape_type) :: shape
      type(random_type) :: random
      type(worst_type) :: worst
      real(wp) :: v(3), w(3), jacobian(3, 3)
      real(qp) :: nodes(n_nodes), weights(n_nodes), expected(3, 3), above(3), below(3), e(3), h
      integer :: i, j

      call gauss_rule(nodes, weights)
      do i = 1, 400
         shape = elliptic_shape(random_ratio(random))
         v = random_velocity(random, shape)
         if (.not. abs(v(3)) > 0.0_wp) cycle
         call wrench_exact_jacobian(shape, slip_type(v(1), v(2), v(3)), w, jacobian)
         h = 1.0e-10_qp*shape%k*norm2(v)
         do j = 1, 3
            e = 0.0_qp
            e(j) = h
            call quadrature(shape%k, v + e, nodes, weights, above)
            call quadrature(shape%k, v - e, nodes, weights, below)
            expected(:, j) = 0.5_qp*(above - below)/h
         end do
         call worst%note(real(maxval(abs(jacobian - expected))/maxval(abs(expected)), wp), i)
      end do
      call worst%check_below(jacobian_bound, "Jacobian by quadrature")
   end subroutine test_quadrature_jacobian

   !> Gauss-Legendre rule on (-1, 1) in quadruple precision, by Newton's method.
   pure subroutine gauss_rule(nodes, weights)
      real(qp), intent(out) :: nodes(n_nodes)
      real(qp), intent(out) :: weights(n_nodes)
      real(qp) :: x, p, before, next, slope
      integer :: i, j, k

      do i = 1, n_nodes
         x = cos(acos(-1.0_qp)*(i - 0.25_qp)/(n_nodes + 0.5_qp))
         do k = 1, 8
            before = 1.0_qp
            p = x
            do j = 2, n_nodes
               next = ((2*j - 1)*x*p - (j - 1)*before)/j
               before = p
               p = next
            end do
            slope = n_nodes*(x*p - before)/(x*x - 1.0_qp)
            x = x - p/slope
         end do
         nodes(i) = x
         weights(i) = 2.0_qp/((1.0_qp - x*x)*slope**2)
      end do
   end subroutine gauss_rule

   !> The integrals over s = W^2 r^2 by panels that double, and by 1/r from r = 3 on.
   subroutine quadrature(k, v, nodes, weights, w)
      !> Axis ratio.
      real(wp), intent(in) :: k
      !> Velocity (vx, vy, W) with W not zero.
      real(qp), intent(in) :: v(3)
      !> Nodes of a rule on (-1, 1).
      real(qp), intent(in) :: nodes(n_nodes)
      real(qp), intent(in) :: weights(n_nodes)
      !> The wrench.
      real(qp), intent(out) :: w(3)
      real(qp) :: x2, y2, k2, outside, s, r, step, sums(3)
      integer :: i

      x2 = (v(1)/v(3))**2
      y2 = (v(2)/v(3))**2
      k2 = real(k, qp)**2
      outside = x2 + k2*(y2 - 1.0_qp)
      r = 0.0_qp
      if (outside > 0.0_qp) then
         s = x2 + y2 - 1.0_qp - k2
         r = sqrt(s*s + 4.0_qp*outside)
         if (s >= 0.0_qp) then
            r = sqrt(0.5_qp*(s + r))
         else
            r = sqrt(2.0_qp*outside/(r - s))
         end if
      end if
      sums = 0.0_qp
      do while (r < 3.0_qp)
         step = max(r, real(k, qp))
         do i = 1, n_nodes
            call add(r + 0.5_qp*step*(1.0_qp + nodes(i)), 0.5_qp*step*weights(i))
         end do
         r = r + step
      end do
      do i = 1, n_nodes
         s = 0.5_qp*(1.0_qp + nodes(i))/r
         call add(1.0_qp/s, 0.5_qp*weights(i)/(r*s*s))
      end do
      w = [-0.75_qp*v(1)/abs(v(3))*sums(1), -0.75_qp*v(2)/abs(v(3))*sums(2), &
         -0.1875_qp*sign(1.0_qp, v(3))*sums(3)]

   contains

      !> Add the integrands at a node.
      subroutine add(r, weight)
         !> The node.
         real(qp), intent(in) :: r
         real(qp), intent(in) :: weight
         real(qp) :: a, b, u, m

         a = 1.0_qp/(1.0_qp + r*r)
         b = 1.0_qp/(k2 + r*r)
         u = 1.0_qp - y2*a - x2*b
         m = 2.0_qp*weight*sqrt(a*b)*u
         sums(1) = sums(1) + m*r*r*b
         sums(2) = sums(2) + m*r*r*a
         sums(3) = sums(3) + m*(k2*u*(a + b) + 4.0_qp*r*r*(x2*b*b + k2*y2*a*a))
      end subroutine add

   end subroutine quadrature

   !> Wrench in SI units.
   subroutine test_dimensional()
      type(table_type) :: table
      type(rung_type) :: friction
      type(spot_shape_type) :: shape
      real(wp), allocatable :: load(:), a(:), b(:), f(:), vx(:), vy(:), w(:), fx(:), fy(:), tz(:)
      real(wp) :: r(3)
      type(worst_type) :: force, torque
      integer :: i

      call read_table("wrench_dimensional", table)
      load = table%column("N")
      a = table%column("a")
      b = table%column("b")
      f = table%column("f")
      vx = table%column("vx")
      vy = table%column("vy")
      w = table%column("w")
      fx = table%column("Fx")
      fy = table%column("Fy")
      tz = table%column("Tz")
      friction%kernel => wrench_exact
      do i = 1, table%rows
         friction%coefficient = f(i)
         shape = elliptic_shape(b(i)/a(i))
         call friction%wrench(shape, sliding_type(load(i), a(i), vx(i), vy(i), w(i)), r)
         call force%note(max(abs(r(1) - fx(i)), abs(r(2) - fy(i)))/(f(i)*load(i)), i)
         call torque%note(abs(r(3) - tz(i))/(f(i)*load(i)*a(i)), i)
      end do
      call force%check_below(2.0_wp*wrench_bound, "force of the table in SI units")
      call torque%check_below(2.0_wp*wrench_bound, "torque of the table in SI units")
   end subroutine test_dimensional

   !> The circle is the limit of the ellipse, and has no preferred direction.
   subroutine test_circle()
      type(spot_shape_type) :: shape
      type(random_type) :: random
      type(worst_type) :: limit, turned
      real(wp) :: v(3), w(3), other(3), gap, psi, jacobian(3, 3), turn(3, 3), expected(3, 3)
      integer :: i

      do i = 1, 20000
         v = random_velocity(random, circular_shape)
         w = exact(circular_shape, v)
         gap = 10.0_wp**random%uniform(-15.0_wp, -3.0_wp)
         shape = elliptic_shape(1.0_wp - gap)
         call limit%note(maxval(abs(exact(shape, v) - w))/(gap + 1.0e-15_wp), i)
         psi = random%uniform(0.0_wp, 2.0_wp*pi)
         turn = reshape([cos(psi), sin(psi), 0.0_wp, -sin(psi), cos(psi), 0.0_wp, 0.0_wp, 0.0_wp, &
            1.0_wp], [3, 3])
         call wrench_exact_jacobian(circular_shape, slip_type(v(1), v(2), v(3)), w, expected)
         v = matmul(turn, v)
         call wrench_exact_jacobian(circular_shape, slip_type(v(1), v(2), v(3)), other, jacobian)
         expected = matmul(turn, matmul(expected, transpose(turn)))
         call turned%note(max(maxval(abs(other - matmul(turn, w))), &
            maxval(abs(jacobian - expected))/maxval(abs(expected))), i)
      end do
      call limit%check_below(3.0_wp, "an ellipse close to a circle, first order in 1 - k")
      call turned%check_below(1.0e-14_wp, "wrench and Jacobian of the circle in all directions")
   end subroutine test_circle

   !> Pure spin, pure sliding and rest for all rungs and shapes.
   subroutine test_pure_motions()
      procedure(wrench_kernel), pointer :: kernel
      type(spot_shape_type) :: shape
      type(random_type) :: random
      type(worst_type) :: spinning, sliding, rest, slip_jacobian, spin_jacobian
      real(wp) :: w(3), v(3), jacobian(3, 3), expected(3, 3), e(2)
      character(len=*), parameter :: names(5) = [character(len=20) :: "coulomb", &
         "contensou_simplified", "pade11", "pade22", "contensou_exact"]
      integer :: i, j

      do i = 1, size(names)
         select case (i)
         case (1)
            kernel => wrench_coulomb
         case (2)
            kernel => wrench_simplified
         case (3)
            kernel => wrench_pade11
         case (4)
            kernel => wrench_pade22
         case default
            kernel => wrench_exact
         end select
         spinning = worst_type()
         sliding = worst_type()
         rest = worst_type()
         do j = 1, 2000
            shape = elliptic_shape(random_ratio(random))
            v = [0.0_wp, 0.0_wp, random%decades(-300.0_wp, 300.0_wp)]
            w = wrench_of(kernel, shape, v, 0.0_wp)
            call spinning%note(maxval(abs(w + [0.0_wp, 0.0_wp, merge(0.0_wp, &
               sign(shape%torque, v(3)), i == 1)])), j)
            e = random%vector(2)
            e = e/norm2(e)
            w = wrench_of(kernel, shape, [e, 0.0_wp]*abs(random%decades(-300.0_wp, 300.0_wp)), &
               0.0_wp)
            call sliding%note(maxval(abs(w + [e, 0.0_wp])), j)
            w = wrench_of(kernel, shape, [0.0_wp, 0.0_wp, 0.0_wp], merge(0.0_wp, &
               abs(random%decades(-300.0_wp, 300.0_wp)), modulo(j, 2) == 0))
            call rest%note(maxval(abs(w)), j)
         end do
         call spinning%check_below(1.2e-16_wp, trim(names(i)) // ": pure spin")
         call sliding%check_below(1.0e-15_wp, trim(names(i)) // ": pure sliding")
         call rest%check_below(0.0_wp, trim(names(i)) // ": rest")
      end do

      do j = 1, 2000
         shape = elliptic_shape(random_ratio(random))
         call wrench_exact_jacobian(shape, slip_type(0.0_wp, 0.0_wp, -2.0_wp), w, jacobian)
         expected = 0.0_wp
         expected(1, 1) = -0.5_wp*shape%slope_x
         expected(2, 2) = -0.5_wp*shape%slope_y
         call spin_jacobian%note(maxval(abs(jacobian - expected))/abs(expected(1, 1)), j)
         e = random%vector(2)
         e = e/norm2(e)
         call wrench_exact_jacobian(shape, slip_type(4.0_wp*e(1), 4.0_wp*e(2), 0.0_wp), w, jacobian)
         expected(1, 1) = -0.25_wp*e(2)**2
         expected(2, 2) = -0.25_wp*e(1)**2
         expected(1, 2) = 0.25_wp*e(1)*e(2)
         expected(2, 1) = expected(1, 2)
         expected(3, 3) = -0.05_wp*(e(1)**2 + shape%k2*e(2)**2)
         call slip_jacobian%note(maxval(abs(jacobian - expected))/0.25_wp, j)
      end do
      call spin_jacobian%check_below(5.0e-16_wp, "Jacobian of pure spin: the slopes k_x, k_y")
      call slip_jacobian%check_below(5.0e-15_wp, "Jacobian of pure sliding")
   end subroutine test_pure_motions

   !> The first terms at small and at large u.
   subroutine test_expansions()
      type(spot_shape_type) :: shape
      type(random_type) :: random
      type(worst_type) :: rest, along, across, far_torque
      real(wp) :: w(3), u, psi, g, perpendicular
      integer :: i

      do i = 1, 5000
         shape = elliptic_shape(10.0_wp**random%uniform(-6.0_wp, 0.0_wp))
         psi = random%uniform(0.0_wp, 2.0_wp*pi)
         u = 1.0e-5_wp*shape%k
         w = exact(shape, [u*cos(psi), u*sin(psi), 1.0_wp])
         call rest%note(maxval(abs([w(1)/u + shape%slope_x*cos(psi), w(2)/u &
            + shape%slope_y*sin(psi), w(3) + shape%torque])), i)
         u = 1.0e3_wp
         w = exact(shape, [u*cos(psi), u*sin(psi), 1.0_wp])
         g = cos(psi)**2 + shape%k2*sin(psi)**2
         call along%note(abs((1.0_wp + w(1)*cos(psi) + w(2)*sin(psi))*u**2 - 0.1_wp*g), i)
         perpendicular = w(2)*cos(psi) - w(1)*sin(psi)
         call across%note(abs(abs(perpendicular)*u**2 - 0.1_wp*shape%c*abs(sin(2.0_wp*psi))), i)
         call far_torque%note(abs(w(3)*u + 0.2_wp*g), i)
      end do
      call rest%check_below(1.0e-8_wp, "slopes at rest k_x, k_y, torque k_T")
      call along%check_below(1.0e-6_wp, "fast sliding: 1 - g/(10 u^2) along v")
      call across%check_below(1.0e-6_wp, "fast sliding: c |sin 2 psi|/(10 u^2) across v")
      call far_torque%check_below(1.0e-6_wp, "fast sliding: torque g/(5 u)")
   end subroutine test_expansions

   !> A needle: the limit k to 0 is a line with the pressure (3/4)(1 - x^2), in closed form.
   subroutine test_needle()
      type(spot_shape_type) :: shape
      type(random_type) :: random
      type(worst_type) :: limit, slender
      real(wp) :: ux, uy, expected(3)
      integer :: i

      shape = elliptic_shape(1.0e-20_wp)
      do i = 1, 5000
         ux = random%decades(-8.0_wp, 2.0_wp)
         uy = random%uniform(-3.0_wp, 3.0_wp)
         if (modulo(i, 7) == 0) uy = sign(1.0_wp, uy) + random%decades(-12.0_wp, -1.0_wp)
         if (modulo(i, 11) == 0) uy = 0.0_wp
         expected = needle(ux, uy)
         call limit%note(maxval(abs(exact(shape, [ux, uy, 1.0_wp]) - expected)), i)
         call slender%note(maxval(abs(exact(elliptic_shape(1.0e-6_wp), [ux, uy, 1.0_wp]) &
            - expected))/min(1.0_wp, 1.0e-12_wp/ux**2 + 1.0e-12_wp), i)
      end do
      call limit%check_below(2.0_wp*wrench_bound, "needle of k = 1e-20")
      call slender%check_below(3.0_wp, "needle of k = 1e-6, second order in k/u_x")
   end subroutine test_needle

   !> Wrench on a line of length 2 with the pressure (3/4)(1 - x^2) and unit spin.
   pure function needle(ux, uy) result(w)
      !> Sliding velocity along the line, not zero.
      real(wp), intent(in) :: ux
      !> Sliding velocity across it.
      real(wp), intent(in) :: uy
      real(wp) :: w(3)
      real(qp) :: x, y, m(0:4), r, s
      integer :: i

      ! Moments of 1/sqrt(x^2 + r^2) between r = y - 1 and y + 1.
      x = real(ux, qp)
      y = real(uy, qp)
      m = 0.0_qp
      do i = -1, 1, 2
         r = y + i
         s = sqrt(x*x + r*r)
         m(0) = m(0) + i*asinh(r/abs(x))
         m(1) = m(1) + i*s
         m(2) = m(2) + i*0.5_qp*(r*s - x*x*asinh(r/abs(x)))
         m(3) = m(3) + i*(s**3/3.0_qp - x*x*s)
         m(4) = m(4) + i*(0.25_qp*r**3*s - 0.375_qp*x*x*(r*s - x*x*asinh(r/abs(x))))
      end do
      w = real(-0.75_qp*[x*((1.0_qp - y*y)*m(0) + 2.0_qp*y*m(1) - m(2)), &
         (1.0_qp - y*y)*m(1) + 2.0_qp*y*m(2) - m(3), &
         (1.0_qp - y*y)*(m(2) - y*m(1)) + 2.0_qp*y*(m(3) - y*m(2)) - (m(4) - y*m(3))], wp)
   end function needle

   !> The wrench depends on the ratio of the velocities only; by a power of two to the last bit.
   subroutine test_homogeneity()
      type(spot_shape_type) :: shape
      type(random_type) :: random
      type(worst_type) :: binary, decimal, regularised, derivatives, energy
      real(wp) :: v(3), w(3), other(3), jacobian(3, 3), scaled(3, 3), factor, delta, phi
      integer :: i, power

      do i = 1, n_states
         shape = elliptic_shape(random_ratio(random))
         v = random_velocity(random, shape)
         delta = abs(random%decades(-6.0_wp, 6.0_wp))
         power = nint(random%uniform(-960.0_wp, 960.0_wp))
         w = exact(shape, v)
         call binary%note(maxval(abs(exact(shape, scale(v, power)) - w)), i)
         call regularised%note(maxval(abs(wrench_of(wrench_exact, shape, scale(v, power), &
            scale(delta, power)) - wrench_of(wrench_exact, shape, v, delta))), i)
         factor = abs(random%decades(-292.0_wp, 292.0_wp))
         call decimal%note(maxval(abs(exact(shape, factor*v) - w)), i)
         call wrench_exact_jacobian(shape, slip_type(v(1), v(2), v(3), delta), w, jacobian)
         call wrench_exact_jacobian(shape, slip_type(scale(v(1), power), scale(v(2), power), &
            scale(v(3), power), scale(delta, power)), other, scaled)
         call derivatives%note(max(maxval(abs(other - w)), maxval(abs(scale(scaled, power) &
            - jacobian))/maxval(abs(jacobian))), i)
         phi = potential(shape, v, delta)
         call energy%note(abs(scale(potential(shape, scale(v, power), scale(delta, power)), &
            -power) - phi)/phi, i)
      end do
      call binary%check_below(0.0_wp, "degree 0 from 1e-300 to 1e300, powers of two")
      call regularised%check_below(0.0_wp, "degree 0 with delta, powers of two")
      call decimal%check_below(3.0e-15_wp, "degree 0 from 1e-300 to 1e300")
      call derivatives%check_below(1.0e-16_wp, "degree -1 of the Jacobian")
      call energy%check_below(3.0e-16_wp, "degree 1 of the potential")
   end subroutine test_homogeneity

   !> Mirror images, to the last bit, and with them the parities in v and in w.
   subroutine test_parities()
      type(spot_shape_type) :: shape
      type(random_type) :: random
      type(worst_type) :: values, derivatives
      real(wp) :: v(3), w(3), other(3), jacobian(3, 3), mirrored(3, 3), s(3), delta
      integer :: i, j

      do i = 1, n_states
         shape = elliptic_shape(random_ratio(random))
         v = random_velocity(random, shape)
         delta = merge(0.0_wp, abs(random%decades(-6.0_wp, 6.0_wp)), modulo(i, 2) == 0)
         call wrench_exact_jacobian(shape, slip_type(v(1), v(2), v(3), delta), w, jacobian)
         s = [merge(1.0_wp, -1.0_wp, modulo(i, 4) < 2), merge(1.0_wp, -1.0_wp, modulo(i, 8) < 4), &
            merge(1.0_wp, -1.0_wp, modulo(i, 16) < 8)]
         call wrench_exact_jacobian(shape, slip_type(s(1)*v(1), s(2)*v(2), s(3)*v(3), delta), &
            other, mirrored)
         call values%note(maxval(abs(other - s*w)), i)
         do j = 1, 3
            mirrored(:, j) = s*s(j)*mirrored(:, j)
         end do
         call derivatives%note(maxval(abs(mirrored - jacobian)), i)
      end do
      call values%check_below(0.0_wp, "parities of the wrench")
      call derivatives%check_below(0.0_wp, "parities of the Jacobian")
   end subroutine test_parities

   !> Dissipation, the bounds of force and torque, and that the potential is the power.
   subroutine test_potential()
      type(spot_shape_type) :: shape
      type(random_type) :: random
      type(worst_type) :: dissipated, force, torque, power, sense
      real(wp) :: v(3), w(3), phi
      integer :: i

      do i = 1, n_states
         shape = elliptic_shape(random_ratio(random))
         v = random_velocity(random, shape)
         w = exact(shape, v)
         phi = potential(shape, v, 0.0_wp)
         call dissipated%note(dot_product(w, v)/norm2(v), i)
         call sense%note(w(3)*sign(1.0_wp, v(3)), i)
         call force%note(norm2(w(1:2)) - 1.0_wp, i)
         call torque%note(abs(w(3))/shape%torque - 1.0_wp, i)
         call power%note(abs(phi + dot_product(w, v))/phi, i)
      end do
      call dissipated%check_below(-1.0e-8_wp, "F.v + T w < 0")
      call sense%check_below(1.0e-16_wp, "T w <= 0")
      call force%check_below(1.0e-15_wp, "|F| <= 1")
      call torque%check_below(1.0e-15_wp, "|T| <= k_T")
      call power%check_below(1.0e-15_wp, "the potential is the dissipated power")
   end subroutine test_potential

   !> Monotone, and inside the limit surface: the potential is convex.
   subroutine test_limit_surface()
      type(spot_shape_type) :: shape
      type(random_type) :: random
      type(worst_type) :: monotone, surface, regular_monotone, regular_convex
      real(wp) :: v(3), other(3), w(3), w_other(3), phi, delta
      integer :: i

      do i = 1, n_states
         shape = elliptic_shape(random_ratio(random))
         v = random_velocity(random, shape)
         if (modulo(i, 2) == 0) then
            other = random_velocity(random, shape)
         else
            other = v + norm2(v)*random%vector(3)*10.0_wp**random%uniform(-8.0_wp, 0.0_wp)
         end if
         w = exact(shape, v)
         w_other = exact(shape, other)
         call monotone%note(dot_product(w - w_other, (v - other)/norm2(v - other)), i)
         phi = potential(shape, other, 0.0_wp)
         call surface%note(-dot_product(w, other)/phi - 1.0_wp, i)

         delta = abs(random%decades(-6.0_wp, 6.0_wp))
         w = wrench_of(wrench_exact, shape, v, delta)
         w_other = wrench_of(wrench_exact, shape, other, delta)
         call regular_monotone%note(dot_product(w - w_other, (v - other)/norm2(v - other)), i)
         phi = potential(shape, other, delta) - potential(shape, v, delta)
         call regular_convex%note((-dot_product(w, other - v) - phi)/(norm2(v) + norm2(other) &
            + shape%slope_x*delta), i)
      end do
      call monotone%check_below(3.0e-15_wp, "monotone")
      call surface%check_below(3.0e-15_wp, "inside the limit surface")
      call regular_monotone%check_below(3.0e-15_wp, "monotone with delta")
      call regular_convex%check_below(3.0e-15_wp, "convex with delta")
   end subroutine test_limit_surface

   !> The Jacobian is symmetric, negative semidefinite, and zero in the direction of the velocity.
   subroutine test_jacobian_structure()
      type(spot_shape_type) :: shape
      type(random_type) :: random
      type(worst_type) :: symmetric, kernel_direction, positive, regular_positive, minor
      real(wp) :: v(3), w(3), jacobian(3, 3), e(3), largest, delta
      integer :: i, j, l

      do i = 1, n_states
         shape = elliptic_shape(random_ratio(random))
         v = random_velocity(random, shape)
         call wrench_exact_jacobian(shape, slip_type(v(1), v(2), v(3)), w, jacobian)
         largest = maxval(abs(jacobian))
         jacobian = jacobian/largest
         call symmetric%note(maxval(abs(jacobian - transpose(jacobian))), i)
         call kernel_direction%note(maxval(abs(matmul(jacobian, v)))/norm2(v), i)
         e = random%vector(3)
         call positive%note(dot_product(e, matmul(jacobian, e)), i)
         do j = 1, 3
            l = modulo(j, 3) + 1
            call minor%note(jacobian(j, l)**2 - jacobian(j, j)*jacobian(l, l), i)
         end do
         delta = abs(random%decades(-6.0_wp, 6.0_wp))
         call wrench_exact_jacobian(shape, slip_type(v(1), v(2), v(3), delta), w, jacobian)
         call regular_positive%note(dot_product(e, matmul(jacobian, e))/maxval(abs(jacobian)), i)
      end do
      call symmetric%check_below(0.0_wp, "Jacobian symmetric")
      call kernel_direction%check_below(jacobian_bound, "J V = 0")
      call positive%check_below(jacobian_bound, "Jacobian negative semidefinite")
      call minor%check_below(jacobian_bound, "minors of the Jacobian not negative")
      call regular_positive%check_below(jacobian_bound, "Jacobian negative semidefinite with delta")
   end subroutine test_jacobian_structure

   !> The integral of the Jacobian over a short way is the change of the wrench, and that of the
   !> wrench the change of the potential.
   subroutine test_jacobian_integral()
      type(spot_shape_type) :: shape
      type(random_type) :: random
      type(worst_type) :: values, energy
      real(wp) :: v(3), step(3), w(3), jacobian(3, 3), change(3), delta, phi, length
      real(wp), parameter :: nodes(4) = [-0.8611363115940525752_wp, -0.3399810435848562648_wp, &
         0.3399810435848562648_wp, 0.8611363115940525752_wp]
      real(wp), parameter :: weights(4) = [0.3478548451374538574_wp, 0.6521451548625461426_wp, &
         0.6521451548625461426_wp, 0.3478548451374538574_wp]
      integer :: i, j

      do i = 1, n_states
         shape = elliptic_shape(random_ratio(random))
         v = random_velocity(random, shape)
         ! The scale of the wrench is k^2 at the ends of a slender spot, and d near rest.
         shape = elliptic_shape(max(shape%k, 1.0e-3_wp))
         delta = merge(0.0_wp, norm2(v)*10.0_wp**random%uniform(-6.0_wp, 2.0_wp), modulo(i, 2) == 0)
         length = 1.0e-4_wp*shape%k2*norm2(v)
         if (delta > 0.0_wp) length = min(length, 1.0e-2_wp*delta)
         step = 0.5_wp*length*random%vector(3)
         change = wrench_of(wrench_exact, shape, v + step, delta) &
            - wrench_of(wrench_exact, shape, v - step, delta)
         phi = potential(shape, v + step, delta) - potential(shape, v - step, delta)
         do j = 1, size(nodes)
            call wrench_exact_jacobian(shape, slip_type(v(1) + nodes(j)*step(1), &
               v(2) + nodes(j)*step(2), v(3) + nodes(j)*step(3), delta), w, jacobian)
            change = change - weights(j)*matmul(jacobian, step)
            phi = phi + weights(j)*dot_product(w, step)
         end do
         call values%note(maxval(abs(change))/(length*maxval(abs(jacobian)) + 1.0e-8_wp), i)
         call energy%note(abs(phi)/(norm2(v) + delta*shape%slope_x), i)
      end do
      call values%check_below(1.0e-6_wp, "integral of the Jacobian")
      call energy%check_below(3.0e-15_wp, "integral of the wrench")
   end subroutine test_jacobian_integral

   !> The regularised wrench: formula, slope and potential at rest, and the limit of small delta.
   subroutine test_regularisation()
      type(spot_shape_type) :: shape
      type(random_type) :: random
      type(worst_type) :: formula, limit, at_rest, small_potential, small_wrench
      real(wp) :: v(3), w(3), plain(3), jacobian(3, 3), expected(3, 3), delta, we, phi
      integer :: i, j

      do i = 1, n_states
         shape = elliptic_shape(random_ratio(random))
         v = random_velocity(random, shape)
         delta = norm2(v)*10.0_wp**random%uniform(-6.0_wp, 2.0_wp)
         w = wrench_of(wrench_exact, shape, v, delta)
         we = sqrt(v(3)**2 + (shape%slope_x*delta)**2)
         plain = exact(shape, [v(1), v(2), we])
         plain(3) = plain(3)*(v(3)/we)
         call formula%note(maxval(abs(w - plain)), i)
         plain = exact(shape, v)
         w = wrench_of(wrench_exact, shape, v, 1.0e-30_wp*norm2(v))
         call limit%note(maxval(abs(w - plain)), i)

         ! At rest: minus the inverse slopes, also far below delta.
         call wrench_exact_jacobian(shape, slip_type(0.0_wp, 0.0_wp, 0.0_wp, delta), w, jacobian)
         expected = 0.0_wp
         expected(1, 1) = -1.0_wp/delta
         expected(2, 2) = -shape%slope_y/(shape%slope_x*delta)
         expected(3, 3) = -shape%torque/(shape%slope_x*delta)
         call at_rest%note(max(maxval(abs(w)), maxval(abs(jacobian - expected))*delta), i)
         v = v/norm2(v)*delta*shape%k*10.0_wp**random%uniform(-200.0_wp, -8.0_wp)
         w = wrench_of(wrench_exact, shape, v, delta)
         call small_wrench%note(maxval(abs(w - matmul(expected, v)))/maxval(abs(w)), i)
         phi = 0.0_wp
         do j = 1, 3
            phi = phi - 0.5_wp*(expected(j, j)*v(j))*v(j)
         end do
         if (phi > 1.0e-290_wp) then
            call small_potential%note(abs(potential(shape, v, delta)/phi - 1.0_wp), i)
         end if
      end do
      call formula%check_below(3.0e-15_wp, "F(v, W_e) and T(v, W_e) W/W_e")
      call limit%check_below(1.0e-15_wp, "small delta: not regularised")
      call at_rest%check_below(1.0e-15_wp, "at rest: slopes 1, k_y/k_x, k_T/k_x over delta")
      call small_wrench%check_below(3.0e-15_wp, "far below delta linear")
      call small_potential%check_below(3.0e-15_wp, "potential far below delta quadratic")
   end subroutine test_regularisation

   !> Two derivatives are continuous across the rim; the third is not.
   subroutine test_rim()
      type(spot_shape_type) :: shape
      type(worst_type) :: values, first, second
      real(wp) :: psi, rim(3), outward(3), far(3, 3), near(3, 3), at(3, 3), inner(3, 3), w(3), h
      real(wp) :: change(2)
      integer :: i, j, l

      do i = 1, size(ratios)
         shape = elliptic_shape(ratios(i))
         do j = 0, 160
            psi = 0.01_wp*j
            rim = velocity_at(shape, 0.0_wp, psi)
            ! Along the normal of the rim by fractions of the small semi-axis.
            outward = [cos(psi), shape%k*sin(psi), 0.0_wp]
            outward = outward/norm2(outward)*shape%k
            if (shape%k < 0.1_wp .and. abs(cos(psi)) < 10.0_wp*shape%k) outward = outward*shape%k
            h = 1.0e-12_wp
            call values%note(maxval(abs(exact(shape, rim + h*outward) &
               - exact(shape, rim - h*outward))), j + 1)
            do l = 1, 2
               h = merge(1.0e-4_wp, 1.0e-6_wp, l == 1)
               call wrench_exact_jacobian(shape, slip_type(rim(1), rim(2), rim(3)), w, at)
               call derivative_at(rim + h*outward, near)
               call derivative_at(rim + 2.0_wp*h*outward, far)
               call derivative_at(rim - h*outward, inner)
               change(l) = norm2(outward)*maxval(abs((far - near) - (at - inner)))/(norm2(at)*h)
               if (l == 2) call first%note(maxval(abs(near - inner))/norm2(at), j + 1)
            end do
            call second%note(change(2)/(change(1) + 1.0e-2_wp), j + 1)
         end do
      end do
      call values%check_below(3.0e-11_wp, "wrench continuous across the rim")
      call first%check_below(3.0e-5_wp, "first derivatives continuous across the rim")
      call second%check_below(0.2_wp, "second derivatives continuous across the rim")

   contains

      !> Jacobian at a velocity.
      subroutine derivative_at(v, jacobian)
         !> The velocity.
         real(wp), intent(in) :: v(3)
         real(wp), intent(out) :: jacobian(3, 3)
         real(wp) :: wrench(3)

         call wrench_exact_jacobian(shape, slip_type(v(1), v(2), v(3)), wrench, jacobian)
      end subroutine derivative_at

   end subroutine test_rim

   !> No jump where the method changes: at the rim, between the rules, between the panels.
   subroutine test_joints()
      type(spot_shape_type) :: shape
      real(wp) :: rho(size(direct_joints) + size(rim_joints) + size(panel_joints) + 1)
      type(worst_type) :: values, derivatives, energy
      real(wp) :: psi, below(3), above(3), w(3, 2), jacobian(3, 3, 2), phi(2), step
      integer :: i, j, l

      step = 32.0_wp*epsilon(step)
      do i = 1, size(ratios)
         shape = elliptic_shape(ratios(i))
         rho = [direct_joints, rim_joints*shape%k, tail_start()/panel_joints, 0.0_wp]
         do j = 1, size(rho)
            do l = 0, 100
               psi = 0.0157079632679489662_wp*l
               if (rho(j) > 0.0_wp) then
                  below = velocity_at(shape, rho(j)*(1.0_wp - step), psi)
                  above = velocity_at(shape, rho(j)*(1.0_wp + step), psi)
               else
                  above = velocity_at(shape, 0.0_wp, psi)
                  below = [above(1:2)*(1.0_wp - step), 1.0_wp]
                  above(1:2) = above(1:2)*(1.0_wp + step)
               end if
               call wrench_exact_jacobian(shape, slip_type(below(1), below(2), below(3)), &
                  w(:, 1), jacobian(:, :, 1))
               call wrench_exact_jacobian(shape, slip_type(above(1), above(2), above(3)), &
                  w(:, 2), jacobian(:, :, 2))
               phi = [potential(shape, below, 0.0_wp), potential(shape, above, 0.0_wp)]
               ! What the derivatives account for is no jump.
               w(:, 2) = w(:, 2) - matmul(jacobian(:, :, 1), above - below)
               phi(2) = phi(2) + dot_product(w(:, 1), above - below)
               call values%note(maxval(abs(w(:, 2) - w(:, 1))), j)
               call energy%note(abs(phi(2) - phi(1))/phi(1), j)
               ! Derivatives at the rim have a test of their own.
               if (rho(j) <= 0.0_wp) cycle
               call derivatives%note(maxval(abs(jacobian(:, :, 2) - jacobian(:, :, 1))) &
                  /maxval(abs(jacobian)), j)
            end do
         end do
      end do
      call values%check_below(2.0_wp*wrench_bound, "no jump of the wrench between the methods")
      call derivatives%check_below(4.0e-14_wp, "no jump of the Jacobian between the methods")
      call energy%check_below(3.0e-15_wp, "no jump of the potential between the methods")

   contains

      !> Ratio where the panels begin.
      pure function tail_start() result(rho_0)
         real(wp) :: rho_0

         rho_0 = direct_joints(size(direct_joints))
      end function tail_start

   end subroutine test_joints

   !> The Coulomb law does not know the shape.
   subroutine test_coulomb()
      type(spot_shape_type) :: shape
      type(random_type) :: random
      type(worst_type) :: worst
      real(wp) :: v(3), delta
      integer :: i

      do i = 1, 10000
         shape = elliptic_shape(random_ratio(random))
         v = random_velocity(random, shape)
         delta = abs(random%decades(-6.0_wp, 6.0_wp))
         call worst%note(maxval(abs(wrench_of(wrench_coulomb, shape, v, delta) &
            - wrench_of(wrench_coulomb, circular_shape, v, delta))), i)
      end do
      call worst%check_below(0.0_wp, "coulomb: the same on all shapes")
   end subroutine test_coulomb

   !> The simplified model by its definition, and that it becomes the Coulomb law.
   subroutine test_simplified()
      type(spot_shape_type) :: shape
      type(random_type) :: random
      type(worst_type) :: force, torque, coulomb, continuous
      real(wp) :: u, psi, w(3), expected(3), t1, v(3), delta
      integer :: i

      do i = 1, 20000
         shape = elliptic_shape(random_ratio(random))
         u = abs(random%decades(-6.0_wp, 6.0_wp))
         psi = random%uniform(0.0_wp, 2.0_wp*pi)
         v = [u*cos(psi), u*sin(psi), 1.0_wp]
         w = wrench_of(wrench_simplified, shape, v, 0.0_wp)
         t1 = 0.2_wp*(cos(psi)**2 + shape%k2*sin(psi)**2)
         expected = [-cos(psi)*min(1.0_wp, shape%slope_x*u), -sin(psi)*min(1.0_wp, &
            shape%slope_y*u), -min(shape%torque, t1/u)]
         call force%note(maxval(abs(w(1:2) - expected(1:2))), i)
         call torque%note(abs(w(3) - expected(3)), i)
         delta = 1.1_wp*max(1.0_wp/shape%slope_x, 1.0_wp/shape%slope_y)
         w = wrench_of(wrench_simplified, shape, v, delta)
         expected = wrench_of(wrench_coulomb, shape, v, delta)
         call coulomb%note(maxval(abs(w(1:2) - expected(1:2))), i)
         w = wrench_of(wrench_simplified, shape, v, (1.0_wp - 1.0e-14_wp)/shape%slope_x) &
            - wrench_of(wrench_simplified, shape, v, (1.0_wp + 1.0e-14_wp)/shape%slope_x)
         call continuous%note(maxval(abs(w)), i)
      end do
      call force%check_below(1.0e-15_wp, "simplified: force linear up to 1/k, then constant")
      call torque%check_below(1.0e-15_wp, "simplified: torque k_T up to T1/k_T, then T1/u")
      call coulomb%check_below(1.0e-15_wp, "simplified: the Coulomb force above all u* W")
      call continuous%check_below(1.0e-13_wp, "simplified: continuous in delta")
   end subroutine test_simplified

   !> Jacobian of the simplified model by differences, away from its kinks.
   subroutine test_simplified_jacobian()
      type(spot_shape_type) :: shape
      type(random_type) :: random
      type(worst_type) :: values, scaled
      real(wp) :: v(3), e(3), w(3), above(3), below(3), jacobian(3, 3), other(3, 3), delta, h
      integer :: i, j, n_wrong

      n_wrong = 0
      do i = 1, n_states
         shape = elliptic_shape(random_ratio(random))
         do j = 1, 3
            v(j) = random%decades(-2.0_wp, 2.0_wp)
         end do
         delta = merge(0.0_wp, abs(random%decades(-2.0_wp, 2.0_wp)), modulo(i, 2) == 0)
         call wrench_simplified_jacobian(shape, slip_type(v(1), v(2), v(3), delta), w, jacobian)
         call values%note(maxval(abs(w - wrench_of(wrench_simplified, shape, v, delta))), i)
         do j = 1, 3
            e = 0.0_wp
            h = 1.0e-5_wp*abs(v(j))
            e(j) = h
            above = wrench_of(wrench_simplified, shape, v + e, delta)
            below = wrench_of(wrench_simplified, shape, v - e, delta)
            above = h*jacobian(:, j) - 0.5_wp*(above - below)
            if (maxval(abs(above)) > 1.0e-14_wp) n_wrong = n_wrong + 1
         end do
         call wrench_simplified_jacobian(shape, slip_type(scale(v(1), 900), scale(v(2), 900), &
            scale(v(3), 900), scale(delta, 900)), w, other)
         call scaled%note(maxval(abs(scale(other, 900) - jacobian))/maxval(abs(jacobian)), i)
      end do
      call values%check_below(3.0e-16_wp, "simplified: wrench that comes with the Jacobian")
      call scaled%check_below(1.0e-15_wp, "simplified: degree -1 of the Jacobian")
      call check(n_wrong < n_states/2000, "simplified: Jacobian by differences, but for kinks")

      shape = elliptic_shape(0.4_wp)
      call wrench_simplified_jacobian(shape, slip_type(0.0_wp, 0.0_wp, 0.0_wp, 0.5_wp), w, jacobian)
      call check_close(jacobian(1, 1), -2.0_wp, 1.0e-15_wp, "simplified: slope 1/delta at rest")
      call check_close(jacobian(2, 2), -2.0_wp, 1.0e-15_wp, "simplified: slope 1/delta at rest, y")
      call check_close(jacobian(3, 3), -2.0_wp*shape%torque/min(shape%slope_x, shape%slope_y), &
         1.0e-15_wp, "simplified: torque slope at rest")
   end subroutine test_simplified_jacobian

   !> Where the approximations fail; the numbers are those of the manual.
   subroutine test_approximations()
      type(spot_shape_type) :: shape
      real(wp) :: u, w(3), approximate(3), worst(3)
      integer :: i

      shape = elliptic_shape_of_c1(1.0_wp - 0.687_wp)
      worst = 0.0_wp
      do i = -2000, 2000
         u = 10.0_wp**(1.0e-3_wp*i)
         w = exact(shape, [0.0_wp, u, 1.0_wp])
         approximate = wrench_of(wrench_simplified, shape, [0.0_wp, u, 1.0_wp], 0.0_wp)
         worst(1) = min(worst(1), approximate(3)/w(3) - 1.0_wp)
         approximate = wrench_of(wrench_pade22, shape, [0.0_wp, u, 1.0_wp], 0.0_wp)
         worst(2) = min(worst(2), approximate(3)/w(3) - 1.0_wp)
         approximate = wrench_of(wrench_pade11, shape, [0.0_wp, u, 1.0_wp], 0.0_wp)
         worst(3) = min(worst(3), approximate(3)/w(3) - 1.0_wp)
      end do
      call check_close(worst(1), -0.613_wp, 1.0e-3_wp, "simplified: torque along the minor axis")
      call check_close(worst(2), -0.631_wp, 1.0e-3_wp, "pade22: torque along the minor axis")
      call check_close(worst(3), -0.692_wp, 1.0e-3_wp, "pade11: torque along the minor axis")
      call check_close(excess(circular_shape, wrench_simplified), 0.117_wp, 2.0e-3_wp, &
         "simplified: outside the limit surface of the circle")
      call check_close(excess(elliptic_shape(0.3_wp), wrench_simplified), 0.392_wp, 2.0e-3_wp, &
         "simplified: outside the limit surface at k = 0.3")
      call check(excess(circular_shape, wrench_exact) < 1.0e-15_wp, "exact: on the limit surface")
      call check(excess(elliptic_shape(0.3_wp), wrench_exact) < 1.0e-15_wp, &
         "exact: on the limit surface at k = 0.3")
   end subroutine test_approximations

   !> How far a model leaves the limit surface, for sliding along the major axis with spin: the
   !> largest of -w(V).V'/Phi(V') - 1.
   function excess(shape, kernel) result(largest)
      type(spot_shape_type), intent(in) :: shape
      !> The rung.
      procedure(wrench_kernel) :: kernel
      real(wp) :: largest
      integer, parameter :: n = 400
      real(wp) :: w(3), v(3, n), phi(n), u
      integer :: i

      do i = 1, n
         u = 10.0_wp**((i - n/2)*0.01_wp)
         v(:, i) = [u, 0.0_wp, 1.0_wp]
         phi(i) = potential(shape, v(:, i), 0.0_wp)
      end do
      largest = -1.0_wp
      do i = 1, n
         w = wrench_of(kernel, shape, v(:, i), 0.0_wp)
         largest = max(largest, maxval(-matmul(w, v)/phi - 1.0_wp))
      end do
   end function excess

   !> Without torque the force is the same to the last bit, and the torque is zero.
   subroutine test_without_torque()
      type(spot_shape_type) :: shape
      type(random_type) :: random
      type(worst_type) :: worst
      real(wp) :: v(3), w(3), without(3), delta
      integer :: i

      do i = 1, n_states
         shape = elliptic_shape(random_ratio(random))
         v = random_velocity(random, shape)
         delta = merge(0.0_wp, abs(random%decades(-6.0_wp, 6.0_wp)), modulo(i, 2) == 0)
         w = wrench_of(wrench_exact, shape, v, delta)
         call wrench_exact(shape, slip_type(v(1), v(2), v(3), delta), .false., without)
         call worst%note(maxval(abs(without - [w(1), w(2), 0.0_wp])), i)
      end do
      call worst%check_below(0.0_wp, "exact: without torque the same force")
   end subroutine test_without_torque

   !> Velocities of very different size, and derivatives at the ends of the range.
   subroutine test_extremes()
      type(spot_shape_type) :: shape
      type(random_type) :: random
      type(worst_type) :: bounds, dissipated, diagonal, needles
      procedure(wrench_kernel), pointer :: kernel
      real(wp) :: v(3), w(3), jacobian(3, 3), phi, delta
      integer :: i, j

      do i = 1, n_states
         shape = elliptic_shape(random_ratio(random))
         do j = 1, 3
            v(j) = random%decades(-300.0_wp, 300.0_wp)
         end do
         delta = merge(0.0_wp, abs(random%decades(-300.0_wp, 300.0_wp)), modulo(i, 2) == 0)
         select case (modulo(i, 5))
         case (0)
            kernel => wrench_coulomb
         case (1)
            kernel => wrench_simplified
         case (2)
            kernel => wrench_pade11
         case (3)
            kernel => wrench_pade22
         case default
            kernel => wrench_exact
         end select
         w = wrench_of(kernel, shape, v, delta)
         call bounds%note(max(maxval(abs(w(1:2))), abs(w(3))/shape%torque) - 1.0_wp, i)
         call wrench_exact_jacobian(shape, slip_type(v(1), v(2), v(3), delta), w, jacobian)
         phi = potential(shape, v, delta)
         call bounds%note(max(maxval(abs(w(1:2))), abs(w(3))/shape%torque) - 1.0_wp, i)
         call dissipated%note(-phi, i)
         call diagonal%note(maxval([(jacobian(j, j), j=1, 3)])/maxval(abs(jacobian)), i)
         call wrench_simplified_jacobian(shape, slip_type(v(1), v(2), v(3), delta), w, jacobian)
         call bounds%note(max(maxval(abs(w(1:2))), abs(w(3))/shape%torque) - 1.0_wp, i)
         ! Beyond the stated range of shapes.
         shape = elliptic_shape(10.0_wp**random%uniform(-60.0_wp, -6.0_wp))
         call wrench_exact_jacobian(shape, slip_type(v(1), v(2), v(3), delta), w, jacobian)
         call needles%note(max(maxval(abs(w(1:2))), abs(w(3))/shape%torque) - 1.0_wp, i)
      end do
      call bounds%check_below(1.0e-15_wp, "|F| <= 1 and |T| <= k_T, each velocity 1e-300 to 1e300")
      call dissipated%check_below(0.0_wp, "the potential is positive, 1e-300 to 1e300")
      call diagonal%check_below(jacobian_bound, "the Jacobian is not positive, 1e-300 to 1e300")
      call needles%check_below(3.0e-15_wp, "|F| <= 1 and |T| <= k_T for k down to 1e-60")

      call wrench_exact_jacobian(circular_shape, slip_type(tiny(1.0_wp)/4.0_wp, 0.0_wp, 0.0_wp), &
         w, jacobian)
      call check_close(w(1), -1.0_wp, 1.0e-15_wp, "subnormal velocity")
      call check(jacobian(2, 2) <= -0.5_wp*huge(1.0_wp), "largest number instead of an overflow")
      call wrench_exact_jacobian(circular_shape, slip_type(0.0_wp, 0.0_wp, 0.0_wp), w, jacobian)
      call check(maxval(abs(w)) <= 0.0_wp .and. maxval(abs(jacobian)) <= 0.0_wp, &
         "rest without regularisation: zero")
      call check(abs(potential(circular_shape, [0.0_wp, 0.0_wp, 0.0_wp], 1.0_wp)) <= 0.0_wp, &
         "no potential at rest")
   end subroutine test_extremes

   !> NaN, infinite velocities, a negative delta and shapes of NaN give NaN without an exception.
   subroutine test_outside_domain()
      procedure(wrench_jacobian_kernel), pointer :: kernel
      type(spot_shape_type) :: shape
      real(wp) :: bad(4), a(4), w(3), jacobian(3, 3), phi
      logical :: good
      integer :: i, j, l

      bad = [ieee_value(1.0_wp, ieee_quiet_nan), ieee_value(1.0_wp, ieee_positive_inf), &
         ieee_value(1.0_wp, ieee_negative_inf), -1.0_wp]
      do l = 1, 2
         kernel => wrench_exact_jacobian
         if (l == 2) kernel => wrench_simplified_jacobian
         good = .true.
         do i = 1, size(bad)
            do j = 1, 4
               if (i == 4 .and. j < 4) cycle
               a = [1.0_wp, 2.0_wp, 3.0_wp, 0.1_wp]
               a(j) = bad(i)
               call kernel(elliptic_shape(0.3_wp), slip_type(a(1), a(2), a(3), a(4)), w, jacobian)
               phi = wrench_exact_potential(elliptic_shape(0.3_wp), &
                  slip_type(a(1), a(2), a(3), a(4)))
               good = good .and. all(ieee_is_nan(w)) .and. all(ieee_is_nan(jacobian)) &
                  .and. ieee_is_nan(phi)
            end do
         end do
         call check(good, "velocities outside the domain give NaN")
         shape = elliptic_shape(-1.0_wp)
         call kernel(shape, slip_type(1.0_wp, 2.0_wp, 3.0_wp, 0.1_wp), w, jacobian)
         call check(all(ieee_is_nan(w)) .and. all(ieee_is_nan(jacobian)), &
            "a shape of NaN gives NaN")
         call kernel(shape, slip_type(0.0_wp, 0.0_wp, 0.0_wp), w, jacobian)
         call check(all(ieee_is_nan(w)), "a shape of NaN gives NaN at rest")
      end do
      shape = elliptic_shape(2.0_wp)
      call wrench_exact(shape, slip_type(1.0_wp, 2.0_wp, 3.0_wp), .true., w)
      call check(all(ieee_is_nan(w)), "exact: a shape of NaN gives NaN")
      call wrench_pade22(shape, slip_type(1.0_wp, 2.0_wp, 3.0_wp), .true., w)
      call check(all(ieee_is_nan(w)), "pade22: a shape of NaN gives NaN")
   end subroutine test_outside_domain

end module test_wrench_ellipse
