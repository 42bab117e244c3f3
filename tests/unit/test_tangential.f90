!> Tests of tangential elasticity: stiffness, nested shells against closed forms, full sliding,
!> energy, directions, and the oblique impact of a sphere.
module test_tangential
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite, ieee_is_nan, ieee_quiet_nan, ieee_value
   use contensou_base_kinds, only : pi, wp
   use contensou_contact_creep_law, only : passing_type
   use contensou_contact_friction_ladder, only : rung_type
   use contensou_contact_spot, only : circular_shape, elliptic_shape, spot_shape_type
   use contensou_contact_tangential_memory, only : n_states, tangential_type
   use contensou_contact_tangential_oblique, only : oblique_impact
   use contensou_contact_tangential_abreast, only : abreast, slip_in_plane, slip_on_circles, &
      look_at_limit, slide_shells, slip_on_ellipses, surely_stuck
   use contensou_contact_tangential_edges, only : edge_at, power_of
   use contensou_contact_tangential_ellipse, only : ellipse_type, least_ratio
   use contensou_contact_tangential_ellipse_pass, only : lanes, n_values, slide_on_ellipse
   use contensou_contact_tangential_ellipse_pass_few, only : few => lanes, &
      slide_few => slide_on_ellipse
   use contensou_contact_tangential_ellipse_pass_few_wide, only : &
      wide_slide_few => slide_on_ellipse
   use contensou_contact_tangential_ellipse_pass_few_widest, only : &
      widest_slide_few => slide_on_ellipse
   use contensou_contact_tangential_ellipse_pass_wide, only : &
      wide_slide_on_ellipse => slide_on_ellipse
   use contensou_contact_tangential_ellipse_pass_widest, only : &
      widest_slide_on_ellipse => slide_on_ellipse
   use contensou_contact_tangential_ellipse_values, only : bands, parts
   use contensou_contact_tangential_registers, only : kernels_type, numbers_of_register, &
      side_by_side
   use contensou_contact_tangential_shells, only : default_layers, inner_ellipsoid, shells_type, &
      single_spring, spring_spot_type
   use contensou_contact_tangential_slip, only : shared_type, shell_type, sliding_force
   use contensou_contact_tangential_stiffness, only : tangential_stiffness
   use contensou_contact_wrench, only : wrench_jacobian_kernel, wrench_pade11_jacobian, &
      wrench_pade22_jacobian, wrench_simplified_jacobian
   use contensou_contact_wrench_exact, only : wrench_exact, wrench_exact_bends, &
      wrench_exact_jacobian
   use contensou_contact_wrench_scaling, only : slip_type
   use test_harness, only : check, check_close, check_relative, random_type, worst_type
   implicit none(type, external)
   private

   public :: run_tangential_tests

   !> Steel, in SI units.
   real(wp), parameter :: modulus = 8.0e10_wp, poisson = 0.3_wp

   !> Major semi-axis [m] and limit of the friction force [N] of most spots.
   real(wp), parameter :: a = 1.0e-3_wp, limit = 0.6_wp

   !> Axis ratios of most spots.
   real(wp), parameter :: ratios(4) = [1.0_wp, 0.5_wp, 0.05_wp, 1.0e-3_wp]

contains

   !> Run all tests.
   subroutine run_tangential_tests()
      call test_stiffness()
      call test_stiffness_domain()
      call test_history()
      call test_first_slope()
      call test_twist()
      call test_full_sliding()
      call test_convex()
      call test_balance()
      call test_cycles()
      call test_directions()
      call test_twist_at_the_limit()
      call test_joined()
      call test_limits()
      call test_load()
      call test_extremes()
      call test_spring()
      call test_oblique()
      call test_oblique_sliding()
      call test_tangent()
      call test_narrow_rim()
      call test_narrow_rim_that_slips()
      call test_rungs()
      call test_table()
      call test_wide(4)
      call test_wide(8)
      call test_turned()
      call test_rolling_slip()
      call test_turning_slip()
      call test_histories(4)
      call test_histories(8)
      call test_border()
      call test_inner_ellipsoid()
      call test_limit()
   end subroutine run_tangential_tests

   !> A spot of steel.
   function spot_of(ratio, size, limit, poisson) result(spot)
      !> Axis ratio.
      real(wp), intent(in) :: ratio
      !> Major semi-axis.
      real(wp), intent(in) :: size
      real(wp), intent(in) :: limit, poisson
      type(spring_spot_type) :: spot

      spot%shape = circular_shape
      if (ratio < 1.0_wp) spot%shape = elliptic_shape(ratio)
      spot%a = size
      spot%limit = limit
      call tangential_stiffness(spot%shape, size, modulus, poisson, spot%stiffness)
   end function spot_of

   !> Shift along x at which a spot slides, without twist.
   function sliding_shift(spot) result(shift)
      type(spring_spot_type), intent(in) :: spot
      real(wp) :: shift

      shift = 1.5_wp*spot%limit/spot%stiffness(1)
   end function sliding_shift

   !> Closed form of the circle, and values of a spectral solver for ellipses.
   subroutine test_stiffness()
      !> a/b, nu, k_x and k_y in G sqrt(a b), k_T in G (a b)^(3/2).
      real(wp), parameter :: table(5, 8) = reshape([ &
         1.5_wp, 0.2_wp, 2.220280024_wp, 2.270431424_wp, 2.862375382_wp, &
         1.5_wp, 0.45_wp, 2.533263038_wp, 2.685550088_wp, 2.907686835_wp, &
         2.0_wp, 0.0_wp, 2.060213634_wp, 2.060213634_wp, 3.176107704_wp, &
         2.0_wp, 0.5_wp, 2.600360491_wp, 2.911057566_wp, 3.433689389_wp, &
         5.0_wp, 0.3_wp, 2.577410521_wp, 2.924740336_wp, 7.162339951_wp, &
         10.0_wp, 0.45_wp, 3.056212919_wp, 4.009734547_wp, 17.31442056_wp, &
         30.0_wp, 0.3_wp, 3.833115365_wp, 4.71245508_wp, 58.39262625_wp, &
         100.0_wp, 0.2_wp, 5.42436299_wp, 6.291708619_wp, 249.7982172_wp], [5, 8])
      real(wp), parameter :: values(5) = [-1.0_wp, 0.0_wp, 0.2_wp, 0.3_wp, 0.5_wp]
      real(wp) :: k(3)
      type(worst_type) :: worst
      integer :: i

      do i = 1, size(values)
         call tangential_stiffness(circular_shape, a, modulus, values(i), k)
         call check_relative(k(1), 4.0_wp*modulus*a/(2.0_wp - values(i)), 1.0e-15_wp, &
            "shift of a circle")
         call check_relative(k(3), 8.0_wp/3.0_wp*modulus*a**3, 1.0e-15_wp, "twist of a circle")
      end do
      do i = 1, size(table, 2)
         associate (row => table(:, i))
            call tangential_stiffness(elliptic_shape(1.0_wp/row(1)), sqrt(row(1)), 1.0_wp, &
               row(2), k)
            call worst%note(maxval(abs(k/row(3:5) - 1.0_wp)), i)
         end associate
      end do
      call worst%check_below(5.0e-10_wp, "stiffness of ellipses")
   end subroutine test_stiffness

   !> Outside the domain all is NaN.
   subroutine test_stiffness_domain()
      real(wp) :: k(3), nan
      logical :: is_nan(3, 4)

      nan = ieee_value(nan, ieee_quiet_nan)
      call tangential_stiffness(circular_shape, -a, modulus, poisson, k)
      is_nan(:, 1) = ieee_is_nan(k)
      call tangential_stiffness(circular_shape, a, nan, poisson, k)
      is_nan(:, 2) = ieee_is_nan(k)
      call tangential_stiffness(circular_shape, a, modulus, 0.6_wp, k)
      is_nan(:, 3) = ieee_is_nan(k)
      call tangential_stiffness(elliptic_shape(2.0_wp), a, modulus, poisson, k)
      is_nan(:, 4) = ieee_is_nan(k)
      call check(all(is_nan), "stiffness outside the domain")
   end subroutine test_stiffness_domain

   !> Loading, reversal and reloading along x without twist: springs at 20000 places of the method
   !> of dimensionality reduction.
   subroutine test_history()
      integer, parameter :: n = 20000, layers(2) = [default_layers, 128]
      real(wp), parameter :: bars(2) = [1.0e-3_wp, 1.0e-5_wp]
      real(wp), parameter :: targets(8) = [0.8_wp, -0.6_wp, 0.5_wp, -0.3_wp, 0.9_wp, -1.2_wp, &
         0.1_wp, 0.7_wp]
      real(wp) :: q(n), bound(n), from, x, wrench(3), stored, lost, unit
      type(spring_spot_type) :: spot
      type(shells_type) :: shells
      type(worst_type) :: worst
      integer :: i, j, k, l

      do l = 1, size(layers)
         do k = 1, 2
            spot = spot_of(ratios(k), a, limit, poisson)
            shells = shells_of(layers(l))
            unit = sliding_shift(spot)
            bound = [(unit*(1.0_wp - ((real(i, wp) - 0.5_wp)/n)**2), i=1, n)]
            q = 0.0_wp
            from = 0.0_wp
            worst = worst_type()
            do i = 1, size(targets)
               do j = 1, 16
                  x = (targets(i) - from)/16.0_wp*unit
                  q = max(-bound, min(bound, q + x))
                  call shells%advance(spot, [x, 0.0_wp, 0.0_wp], wrench, stored, lost)
                  call worst%note(abs(wrench(1) + spot%stiffness(1)*sum(q)/n)/limit, i)
               end do
               from = targets(i)
            end do
            call worst%check_below(bars(l), "Cattaneo, Mindlin and Jaeger")
         end do
      end do
   end subroutine test_history

   !> Small steps meet the whole stiffness, in each direction.
   subroutine test_first_slope()
      type(spring_spot_type) :: spot
      type(shells_type) :: shells
      type(worst_type) :: worst
      real(wp) :: wrench(3), step(3), stored, lost
      integer :: i, k

      do k = 1, size(ratios)
         spot = spot_of(ratios(k), a, limit, poisson)
         do i = 1, 3
            shells = shells_of(default_layers)
            step = 0.0_wp
            step(i) = 1.0e-6_wp*limit*merge(a, 1.0_wp, i == 3)/spot%stiffness(i)
            call shells%advance(spot, step, wrench, stored, lost)
            call worst%note(maxval(abs(wrench + spot%stiffness*step)) &
               /(spot%stiffness(i)*step(i)), i)
            call worst%note(lost, i)
            call worst%note(abs(stored/(0.5_wp*spot%stiffness(i)*step(i)**2) - 1.0_wp), i)
         end do
      end do
      call worst%check_below(1.0e-14_wp, "small steps are elastic")
   end subroutine test_first_slope

   !> Pure twist of a circle against Lubkin's solution: with the radius c0 of what sticks,
   !> m = 1 - c0^2, the twist is K(m) - E(m) in units of f p0/G, and dT is k_T c0^3 of its change.
   subroutine test_twist()
      integer, parameter :: n = 40000
      type(spring_spot_type) :: spot
      type(shells_type) :: shells
      type(worst_type) :: worst
      real(wp) :: wrench(3), stored, lost, unit, torque, before, after, c, old
      integer :: i

      spot = spot_of(1.0_wp, a, limit, poisson)
      shells = shells_of(60)
      unit = 1.5_wp*limit/(pi*a**2)/modulus
      torque = 0.0_wp
      before = 0.0_wp
      old = 1.0_wp
      do i = 1, n - 1
         c = 1.0_wp - real(i, wp)/n
         after = twist_of(c)
         torque = torque + 0.5_wp*(c**3 + old**3)*(after - before)*unit*spot%stiffness(3)
         if (modulo(i, 500) == 0) then
            shells = shells_of(60)
            call shells%advance(spot, [0.0_wp, 0.0_wp, after*unit], wrench, stored, lost)
            call worst%note(abs(wrench(3) + torque)/(limit*a), i)
         end if
         before = after
         old = c
      end do
      call worst%check_below(2.0e-4_wp, "pure twist is Lubkin's")
   end subroutine test_twist

   !> K(m) - E(m), m = 1 - c^2, by the arithmetic-geometric mean.
   function twist_of(c) result(twist)
      real(wp), intent(in) :: c
      real(wp) :: twist, x, y, z, part, power
      integer :: i

      x = 1.0_wp
      y = c
      part = 0.5_wp*(1.0_wp - c*c)
      power = 1.0_wp
      do i = 1, 30
         z = 0.5_wp*(x - y)
         part = part + power*z*z
         power = 2.0_wp*power
         z = sqrt(x*y)
         x = 0.5_wp*(x + y)
         y = z
      end do
      twist = pi/(2.0_wp*x)*part
   end function twist_of

   !> Whatever went before, sliding on gives the wrench of sliding.
   subroutine test_full_sliding()
      type(spring_spot_type) :: spot
      type(shells_type) :: shells
      type(random_type) :: random
      type(worst_type) :: worst
      real(wp) :: wrench(3), expected(3), step(3), stored, lost
      integer :: i, j, k

      do k = 1, size(ratios)
         spot = spot_of(ratios(k), a, limit, poisson)
         do i = 1, 60
            shells = shells_of(1 + modulo(i, 12))
            step = random%vector(3)*sliding_shift(spot)/[1.0_wp, 1.0_wp, a]
            call shells%advance(spot, step, wrench, stored, lost)
            step = [random%decades(-2.0_wp, 1.0_wp), random%decades(-2.0_wp, 1.0_wp), &
               random%decades(-2.0_wp, 1.0_wp)/a]*1.0e3_wp*sliding_shift(spot)
            do j = 1, 20
               call shells%advance(spot, step, wrench, stored, lost)
            end do
            call wrench_exact(spot%shape, slip_type(step(1), step(2), a*step(3)), .true., expected)
            call worst%note(maxval(abs(wrench/(limit*[1.0_wp, 1.0_wp, a]) - expected)), i)
         end do
      end do
      call worst%check_below(1.0e-12_wp, "full sliding")
   end subroutine test_full_sliding

   !> The force of sliding of a shell is monotone, as its potential is convex.
   subroutine test_convex()
      type(spot_shape_type) :: shape
      type(random_type) :: random
      type(worst_type) :: worst
      real(wp) :: u(3), v(3), f(3), g(3), inner, outer
      integer :: i, k

      do k = 1, size(ratios)
         shape = elliptic_shape(ratios(k))
         do i = 1, 20000
            inner = random%uniform(0.0_wp, 1.0_wp)
            outer = inner + (1.0_wp - inner)*random%uniform(0.01_wp, 1.0_wp)
            u = [random%decades(-3.0_wp, 0.0_wp), random%decades(-3.0_wp, 0.0_wp), &
               random%decades(-2.0_wp, 1.0_wp)]
            v = u + random%decades(-3.0_wp, 0.0_wp)*random%vector(3)
            call force_of_sliding(shape, inner, outer, u, f)
            call force_of_sliding(shape, inner, outer, v, g)
            call worst%note(-dot_product(f - g, u - v)/norm2(u - v), i)
            call worst%note(-dot_product(f, u)/norm2(u), i)
         end do
      end do
      call worst%check_below(2.0e-14_wp, "potentials of the shells are convex")
   end subroutine test_convex

   !> In each step of any history, of spots that keep their shape or not, the work of the wrench
   !> after it is at least what is stored and lost, nothing lost is negative, and no force is above
   !> its limit.
   subroutine test_balance()
      type(spring_spot_type) :: spot
      type(shells_type) :: shells
      type(random_type) :: random
      type(worst_type) :: over, negative, force
      real(wp) :: wrench(3), step(3), stored, before, lost, unit, load, ratio
      integer :: i, j, k

      do k = 1, size(ratios)
         do i = 1, 40
            shells = shells_of(1 + modulo(i, 8))
            before = 0.0_wp
            ratio = ratios(k)
            do j = 1, 100
               load = random%uniform(0.01_wp, 2.0_wp)
               if (modulo(i, 3) == 0) load = 1.0_wp
               if (modulo(i, 5) == 0) ratio = ratios(k)*random%uniform(0.5_wp, 1.0_wp)
               spot = spot_of(ratio, a*load**(1.0_wp/3.0_wp), limit*load, 0.1_wp*modulo(i, 6))
               unit = sliding_shift(spot)
               step = random%decades(-3.0_wp, 0.5_wp)*random%vector(3)*unit/[1.0_wp, 1.0_wp, a]
               if (modulo(i, 4) == 0) step(3) = 0.0_wp
               call shells%advance(spot, step, wrench, stored, lost)
               call over%note((stored - before + lost + dot_product(wrench, step))/(limit*unit), j)
               call negative%note(-min(stored, lost)/(limit*unit), j)
               call force%note(norm2(wrench(1:2))/spot%limit - 1.0_wp, j)
               call force%note(abs(wrench(3))/(spot%limit*spot%a*spot%shape%torque) - 1.0_wp, j)
               before = stored
            end do
         end do
      end do
      call over%check_below(1.0e-13_wp, "no step makes energy")
      call negative%check_below(0.0_wp, "energies are not negative")
      call force%check_below(1.0e-12_wp, "within the limits")
   end subroutine test_balance

   !> In 100000 closed cycles of load, shift and twist the contact returns no more than it took:
   !> what it takes in a cycle is not below the change of what it stores. Sides of a cycle in four
   !> steps, with the work of the mean of the wrenches before and after.
   subroutine test_cycles()
      integer, parameter :: corners = 3, pieces = 4, cycles = 5
      real(wp) :: wrench(3), old(3), place(4, corners), at(4), step(4), stored, begin, lost, &
         taken, unit
      type(spring_spot_type) :: spot
      type(shells_type) :: shells
      type(random_type) :: random
      type(worst_type) :: worst
      integer :: i, j, k, cycle

      unit = sliding_shift(spot_of(1.0_wp, a, limit, poisson))
      do i = 1, 20000
         do j = 1, corners
            place(1:3, j) = 0.5_wp*random%vector(3)*unit/[1.0_wp, 1.0_wp, a]
            place(4, j) = random%uniform(0.3_wp, 1.5_wp)
         end do
         shells = shells_of(1)
         at = place(:, corners)
         spot = spot_of(1.0_wp, a*at(4), limit*at(4)**3, poisson)
         call shells%advance(spot, [0.0_wp, 0.0_wp, 0.0_wp], old, begin, lost)
         do cycle = 1, cycles
            taken = 0.0_wp
            do j = 1, corners
               step = (place(:, j) - at)/pieces
               do k = 1, pieces
                  at = at + step
                  spot%a = a*at(4)
                  spot%limit = limit*at(4)**3
                  call tangential_stiffness(spot%shape, spot%a, modulus, poisson, spot%stiffness)
                  call shells%advance(spot, step(1:3), wrench, stored, lost)
                  taken = taken - 0.5_wp*dot_product(wrench + old, step(1:3))
                  old = wrench
               end do
               at = place(:, j)
            end do
            call worst%note((stored - begin - taken)/(limit*unit), i)
            begin = stored
         end do
      end do
      call worst%check_below(0.0_wp, "closed cycles return nothing")
   end subroutine test_cycles

   !> Mirrored and turned steps give mirrored and turned wrenches.
   subroutine test_directions()
      type(spring_spot_type) :: spot
      type(shells_type) :: shells, turned
      type(random_type) :: random
      type(worst_type) :: worst
      real(wp) :: wrench(3), other(3), step(3), stored, lost, stored_2, lost_2, c, s, turn(3, 3)
      integer :: i, j

      do i = 1, 40
         shells = shells_of(4)
         turned = shells
         spot = spot_of(1.0_wp, a, limit, poisson)
         c = random%uniform(0.0_wp, 2.0_wp*pi)
         s = sin(c)
         c = cos(c)
         turn = reshape([c, s, 0.0_wp, -s, c, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [3, 3])
         if (modulo(i, 2) == 0) then
            spot = spot_of(0.3_wp, a, limit, poisson)
            turn = reshape([1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, -1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
               -1.0_wp], [3, 3])
         end if
         do j = 1, 20
            step = random%vector(3)*sliding_shift(spot)/[1.0_wp, 1.0_wp, a]
            call shells%advance(spot, step, wrench, stored, lost)
            call turned%advance(spot, matmul(turn, step), other, stored_2, lost_2)
            call worst%note(maxval(abs(matmul(turn, wrench) - other)/[1.0_wp, 1.0_wp, a])/limit, i)
            call worst%note(abs(stored - stored_2)/(limit*sliding_shift(spot)), i)
         end do
      end do
      call worst%check_below(1.0e-11_wp, "turned and mirrored")
      wrench(1:2) = shells%shift(2, 1:2)
      call shells%turn(.true.)
      call check_close(shells%shift(2, 1), wrench(2), 0.0_wp, "axes named anew")
      call shells%turn(.false.)
      call check(all(abs(shells%shift(2, 1:2) - wrench(1:2)) <= 0.0_wp), "and back")
   end subroutine test_directions

   !> Shells that are at their very limit in the plane slip when they are twisted as others do that
   !> remember no direction.
   subroutine test_twist_at_the_limit()
      real(wp), parameter :: ratios(*) = [1.0_wp, 0.99_wp, 0.6_wp, 0.2_wp, 0.05_wp]
      type(spring_spot_type) :: spot
      type(shells_type) :: shells, others
      type(worst_type) :: worst
      real(wp) :: wrench(3), other(3), shift
      integer :: i, j

      do i = 1, size(ratios)
         do j = 1, 2
            shells = shells_of(default_layers)
            spot = spot_of(ratios(i), a, limit, poisson)
            shift = sliding_shift(spot)
            ! Some of them have slipped forth, and back.
            call shells%advance(spot, [0.9_wp, 0.0_wp, 0.0_wp]*shift, wrench)
            if (j > 1) call shells%advance(spot, [-0.8_wp, 0.0_wp, 0.0_wp]*shift, wrench)
            others = shells
            others%direction = 0.0_wp
            call shells%advance(spot, [0.0_wp, 0.0_wp, 2.0_wp/a]*shift, wrench)
            call others%advance(spot, [0.0_wp, 0.0_wp, 2.0_wp/a]*shift, other)
            call worst%note(maxval(abs(wrench - other)/[1.0_wp, 1.0_wp, a])/limit, i)
         end do
      end do
      call worst%check_below(1.0e-11_wp, "twist at the limit of shift")
   end subroutine test_twist_at_the_limit

   !> A spot that goes on being both sheared and twisted has a quarter of its shells at last, which
   !> bear what all of them have borne; one that is only sheared or only twisted keeps them, and so
   !> does one whose size changes.
   subroutine test_joined()
      !> Of shift along the axes and twist; what is at most a step of a way of 8.
      real(wp), parameter :: motions(3, 4) = reshape([0.5_wp, 0.2_wp, 0.5_wp, 0.5_wp, 0.2_wp, &
         0.0_wp, 0.0_wp, 0.0_wp, 0.5_wp, 0.5_wp, 0.2_wp, 0.5_wp], [3, 4])
      real(wp), parameter :: nothing(3) = 0.0_wp
      type(spring_spot_type) :: spot
      type(shells_type) :: shells
      type(worst_type) :: force, energy
      real(wp) :: wrench(3), after(3), before, stored, lost, shift, sense
      integer :: i, j, k, n

      do i = 1, 2
         do k = 1, size(motions, 2)
            shells = shells_of(default_layers)
            sense = 1.0_wp
            do j = 1, 40
               spot = spot_of(merge(1.0_wp, 0.5_wp, i == 1), a, limit, poisson)
               if (k == 4 .and. modulo(j, 4) < 2) spot = spot_of(merge(1.0_wp, 0.5_wp, i == 1), &
                  0.8_wp*a, 0.512_wp*limit, poisson)
               shift = sliding_shift(spot)
               call shells%advance(spot, sense*motions(:, k)*shift/[1.0_wp, 1.0_wp, a], wrench, &
                  before)
               sense = -sense
               n = shells%n
               if (k == 1 .and. j == 4) call check(n == 3*default_layers, "shells at first")
               call shells%advance(spot, nothing, after, stored, lost)
               call force%note(maxval(abs(after - wrench)/[1.0_wp, 1.0_wp, a])/limit, j)
               call energy%note(abs(before - stored - lost)/before, j)
            end do
            if (k == 1) then
               call check(shells%n == 8, "shells of shear and twist")
               ! Those that are joined are fours and fives.
               associate (widths => shells%edge(1:8)**1.5_wp - shells%edge(0:7)**1.5_wp)
                  call check(maxval(widths) < 1.251_wp*minval(widths), "evenness of joined shells")
               end associate
            else
               call check(shells%n > 2*default_layers, "shells that are not joined")
            end if
         end do
      end do
      do i = 1, 8
         shells = shells_of(i)
         spot = spot_of(0.5_wp, a, limit, poisson)
         sense = 1.0_wp
         do j = 1, 40
            call shells%advance(spot, sense*motions(:, 1)*sliding_shift(spot)/[1.0_wp, 1.0_wp, a], &
               wrench)
            sense = -sense
         end do
         ! Those that are joined are as even as their edges allow.
         n = shells%n
         call check(n == merge(8, 3*i, 3*i >= 16), "shells of few layers")
         associate (widths => shells%edge(1:n)**1.5_wp - shells%edge(0:n - 1)**1.5_wp)
            call check(maxval(widths) < 1.51_wp*minval(widths), "evenness of few layers")
         end associate
      end do
      call force%check_below(1.0e-11_wp, "what is joined keeps its force")
      call energy%check_below(1.0e-11_wp, "energy that joined shells let go")
   end subroutine test_joined

   !> No shell bears more than its limit in any direction, whether it is found to stick or to slip,
   !> and the force does not depend on where the slip is sought first.
   subroutine test_limits()
      type(spring_spot_type) :: spot
      type(shells_type) :: shells, blind
      type(random_type) :: random
      type(worst_type) :: over, alike
      real(wp) :: wrench(3), other(3), step(3), units(3), u(3), f(3), force(3), stored, lost
      integer :: i, j, k, l, steps

      do k = 1, size(ratios)
         spot = spot_of(ratios(k), a, limit, poisson)
         units = limit*[1.0_wp, 1.0_wp, a]
         do i = 1, 30
            shells = shells_of(3)
            blind = shells
            do j = 1, 8
               ! Some turns in one step, some in several.
               step = random%vector(3)*sliding_shift(spot)/[1.0_wp, 1.0_wp, a]
               steps = merge(1, 5, modulo(j, 2) == 0)
               do l = 1, steps
                  blind%direction = 0.0_wp
                  call shells%advance(spot, step/steps, wrench, stored, lost)
                  call blind%advance(spot, step/steps, other, stored, lost)
                  call alike%note(maxval(abs(wrench - other)/units), i)
               end do
            end do
            do j = 1, shells%n
               f = shells%share(j, :)*shells%shift(j, :)/units
               do l = 1, 40
                  u = random%vector(3)*[1.0_wp, 1.0_wp, random%decades(-1.0_wp, 1.0_wp)]
                  u = u/norm2(u)
                  call force_of_sliding(spot%shape, shells%edge(j - 1)/a, shells%edge(j)/a, u, &
                     force)
                  call over%note(dot_product(f - force, u), j)
               end do
            end do
         end do
      end do
      call over%check_below(1.0e-14_wp, "no shell bears more than its limit")
      call alike%check_below(1.0e-11_wp, "whatever the slip is sought from")
   end subroutine test_limits

   !> A growing spot keeps its force and a shrinking one lets go; without load nothing stays.
   subroutine test_load()
      type(spring_spot_type) :: small, large
      type(shells_type) :: shells
      real(wp) :: first(3), wrench(3), stored, lost, before
      integer :: k

      do k = 1, 2
         small = spot_of(ratios(k), 0.5_wp*a, limit, poisson)
         large = spot_of(ratios(k), a, 8.0_wp*limit, poisson)
         shells = shells_of(default_layers)
         call shells%advance(small, [0.3_wp, 0.1_wp, 0.2_wp/a]*sliding_shift(small), first, &
            before, lost)
         call shells%advance(large, [0.0_wp, 0.0_wp, 0.0_wp], wrench, stored, lost)
         call check(maxval(abs(wrench - first)/[1.0_wp, 1.0_wp, a]) < 1.0e-12_wp*limit, &
            "more load keeps the force")
         call check_close(stored + lost, before, 1.0e-13_wp*before, &
            "and loses what it does not keep")
         call shells%advance(small, [0.0_wp, 0.0_wp, 0.0_wp], wrench, stored, lost)
         call check(stored <= before, "less load lets go")
         call shells%advance(spring_spot_type(circular_shape, 0.0_wp, 0.0_wp, &
            [0.0_wp, 0.0_wp, 0.0_wp]), [a, a, 1.0_wp], wrench, before, lost)
         call check_close(lost, stored, 1.0e-14_wp*stored, "no load: all is lost")
         call check(all(abs(wrench) <= 0.0_wp) .and. before <= 0.0_wp, "no load, no force")
         call shells%advance(large, [0.0_wp, 0.0_wp, 0.0_wp], wrench, stored, lost)
         call check(all(abs(wrench) <= 0.0_wp) .and. lost <= 0.0_wp, "nothing is remembered")
      end do
   end subroutine test_load

   !> No friction, much friction, a twist and back, an incompressible material, one layer.
   subroutine test_extremes()
      type(spring_spot_type) :: spot
      type(shells_type) :: shells
      real(wp) :: wrench(3), stored, lost, theta
      integer :: k

      spot = spot_of(1.0e-3_wp, a, 0.0_wp, 0.5_wp)
      shells = shells_of(1)
      call shells%advance(spot, [a, a, 1.0_wp], wrench, stored, lost)
      call check(all(abs(wrench) <= 0.0_wp) .and. stored <= 0.0_wp .and. lost <= 0.0_wp, &
         "no friction")
      spot%limit = 5.0_wp
      theta = 0.05_wp*spot%limit*a/spot%stiffness(3)
      call shells%advance(spot, [0.0_wp, 0.0_wp, theta], wrench, stored, lost)
      call shells%advance(spot, [0.0_wp, 0.0_wp, -theta], wrench, stored, lost)
      call check(abs(wrench(3)) < 0.05_wp*spot%limit*a .and. lost >= 0.0_wp, "twist and back")
      spot%limit = 0.0_wp
      call shells%advance(spot, [0.0_wp, 0.0_wp, theta], wrench, stored, lost)
      call check(shells%energy() <= 0.0_wp, "friction that ends")
      do k = 60, 300, 20
         spot%limit = 10.0_wp**(-k)
         shells = shells_of(default_layers)
         call shells%advance(spot, [a, 0.5_wp*a, 0.1_wp], wrench, stored, lost)
         call check(hypot(wrench(1), wrench(2)) <= 1.001_wp*spot%limit .and. lost >= 0.0_wp, &
            "friction that is next to none")
      end do
   end subroutine test_extremes

   !> One spring sticks up to the limit.
   subroutine test_spring()
      type(spring_spot_type) :: spot
      type(shells_type) :: shells
      real(wp) :: wrench(3), stored, lost, unit

      spot = spot_of(1.0_wp, a, limit, poisson)
      shells = single_spring()
      unit = limit/spot%stiffness(1)
      call shells%advance(spot, [0.99_wp*unit, 0.0_wp, 0.0_wp], wrench, stored, lost)
      call check_relative(wrench(1), -0.99_wp*limit, 1.0e-14_wp, "spring below its limit")
      call shells%advance(spot, [unit, 0.0_wp, 0.0_wp], wrench, stored, lost)
      call check_relative(wrench(1), -limit, 1.0e-14_wp, "spring at its limit")
      call check_relative(lost, 0.99_wp*limit*unit, 1.0e-14_wp, "work of its slip")
   end subroutine test_spring

   !> Impacts of a sphere against springs at thousands of places.
   subroutine test_oblique()
      !> nu, psi before and after.
      real(wp), parameter :: table(3, 12) = reshape([ &
         0.3_wp, 0.1_wp, 0.0206_wp, 0.3_wp, 0.75_wp, 0.0140_wp, 0.3_wp, 1.25_wp, -0.2191_wp, &
         0.3_wp, 2.0_wp, -0.8372_wp, 0.3_wp, 4.0_wp, -1.4367_wp, 0.0_wp, 0.3_wp, 0.1098_wp, &
         0.0_wp, 1.25_wp, 0.2449_wp, 0.0_wp, 3.0_wp, -1.0375_wp, 0.0_wp, 5.0_wp, -1.5235_wp, &
         0.5_wp, 0.3_wp, -0.0644_wp, 0.5_wp, 1.25_wp, -0.6356_wp, 0.5_wp, 3.0_wp, -1.3710_wp], &
         [3, 12])
      type(worst_type) :: default, twice
      integer :: i

      do i = 1, size(table, 2)
         associate (row => table(:, i))
            call default%note(abs(oblique_impact(shells_of(default_layers), row(1), row(2)) &
               - row(3)), i)
            call twice%note(abs(oblique_impact(shells_of(2*default_layers), row(1), row(2)) &
               - row(3)), i)
         end associate
      end do
      call default%check_below(2.0e-3_wp, "oblique impacts")
      call twice%check_below(1.0e-3_wp, "oblique impacts with twice the layers")
      call check(ieee_is_nan(oblique_impact(shells_of(1), 0.6_wp, 1.0_wp)), &
         "no impact of a material that cannot be")
   end subroutine test_oblique

   !> A sphere that slides throughout loses the same amount whatever its velocity.
   subroutine test_oblique_sliding()
      real(wp), parameter :: values(3) = [0.0_wp, 0.3_wp, 0.5_wp]
      real(wp) :: chi
      integer :: i

      do i = 1, size(values)
         chi = 7.0_wp*(1.0_wp - values(i))/(2.0_wp*(2.0_wp - values(i)))
         call check_close(oblique_impact(shells_of(default_layers), values(i), 4.0_wp*chi), &
            0.0_wp, 1.0e-4_wp, "sliding throughout")
         call check_close(oblique_impact(shells_of(default_layers), values(i), &
            4.0_wp*chi - 0.75_wp), -0.75_wp, 2.0e-5_wp, "sliding throughout, slowly at last")
      end do
   end subroutine test_oblique_sliding

   !> The derivatives of a contact in a run by load and states, stuck and slipping in part, are
   !> those of its wrench.
   subroutine test_tangent()
      type(rung_type) :: friction
      type(tangential_type) :: contact
      type(passing_type) :: rolls, there
      type(worst_type) :: worst
      type(random_type) :: random
      type(spring_spot_type) :: spot
      real(wp) :: states(n_states), steps(0:n_states), change(0:n_states), wrench(3), &
         rates(n_states), slopes(3 + n_states, 5 + n_states), ahead(3), behind(3), unit(3), h, &
         scale(3)
      integer :: i, j, k

      friction%coefficient = 0.3_wp
      friction%kernel => wrench_exact
      friction%jacobian => wrench_exact_jacobian
      contact%coefficient = friction%coefficient
      contact%modulus = modulus
      contact%poisson = poisson
      do k = 1, 3
         spot = spot_of(ratios(k), a, limit, poisson)
         unit = sliding_shift(spot)/[1.0_wp, 1.0_wp, a]
         scale = limit*[1.0_wp, 1.0_wp, a]
         do i = 1, 12
            call contact%begin(9)
            call contact%forget()
            rolls = passing_type(limit/friction%coefficient, a, 1.0e-3_wp, 2.0e-3_wp, 0.5_wp, &
               0.0_wp, 1.0e-3_wp, 2.0e-3_wp)
            states = [0.6_wp, 0.8_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
            call contact%evolve(friction, spot%shape, rolls, states, wrench, rates)
            call contact%keep()
            states(3:5) = random%decades(-2.0_wp, 0.0_wp)*unit*random%vector(3)
            states(6) = 0.3_wp*a
            call contact%vary(friction, spot%shape, rolls, states, wrench, rates, slopes)
            steps = 1.0e-6_wp*[rolls%load, 1.0_wp, 1.0_wp, unit, a]
            do j = 0, n_states
               h = steps(j)
               change = 0.0_wp
               change(j) = h
               there = rolls
               there%load = there%load + change(0)
               call contact%evolve(friction, spot%shape, there, states + change(1:), &
                  ahead, rates)
               there%load = rolls%load - change(0)
               call contact%evolve(friction, spot%shape, there, states - change(1:), &
                  behind, rates)
               call worst%note(maxval(abs((ahead - behind)/(2.0_wp*h) &
                  - slopes(:3, merge(1, 5 + j, j == 0)))/scale)*h*1.0e6_wp, j)
            end do
         end do
      end do
      call worst%check_below(1.0e-5_wp, "derivatives of a contact that sticks and slips")
   end subroutine test_tangent

   !> Derivatives of a contact at rest whose spot grows by as little as rounding errors: its new rim
   !> bears nothing and has slipped nowhere.
   subroutine test_narrow_rim()
      type(tangential_type) :: contact
      type(rung_type) :: friction
      type(passing_type) :: rolls
      real(wp) :: wrench(3), rates(n_states), slopes(3 + n_states, 5 + n_states)
      real(wp), parameter :: states(n_states) = [1.0_wp, 0.0_wp, 0.0_wp, &
         0.0_wp, 0.0_wp, 0.0_wp]
      integer :: i

      friction%coefficient = 0.3_wp
      friction%kernel => wrench_exact
      friction%jacobian => wrench_exact_jacobian
      contact%coefficient = friction%coefficient
      contact%modulus = modulus
      contact%poisson = poisson
      do i = 20, 52
         call contact%begin(30)
         call contact%forget()
         rolls = passing_type(limit/friction%coefficient, a)
         call contact%evolve(friction, circular_shape, rolls, states, wrench, rates)
         call contact%keep()
         rolls%a = a*(1.0_wp + 0.5_wp**i)
         call contact%vary(friction, circular_shape, rolls, states, wrench, rates, slopes)
         call check(all(ieee_is_finite(slopes)), "a rim that nothing has moved: derivatives")
      end do
   end subroutine test_narrow_rim

   !> A new rim so narrow that its derivatives are rounding errors, and that slips: the stiffness of
   !> the spot is not negative, nor above that where all sticks.
   subroutine test_narrow_rim_that_slips()
      type(shells_type) :: shells, grown
      type(spring_spot_type) :: spot, larger
      type(random_type) :: random
      type(worst_type) :: worst
      real(wp) :: wrench(3), slopes(3, 4), part(3), unit(3), u(3)
      integer :: i, j, k

      do k = 1, 2
         spot = spot_of(ratios(k), a, limit, poisson)
         unit = sliding_shift(spot)/[1.0_wp, 1.0_wp, a]
         call shells%begin()
         call shells%advance(spot, 0.1_wp*unit*random%vector(3), wrench)
         do i = 20, 52
            do j = 1, 100
               larger = spot_of(ratios(k), a*(1.0_wp + 0.5_wp**i), limit*(1.0_wp + 3.0_wp &
                  *0.5_wp**i), poisson)
               grown = shells
               call grown%advance(larger, random%decades(-10.0_wp, -3.0_wp)*unit &
                  *random%vector(3), wrench, settled=.false., slopes=slopes)
               u = random%vector(3)
               part = matmul(slopes(:, :3), u/sqrt(larger%stiffness)) &
                  /sqrt(larger%stiffness)
               call worst%note(max(dot_product(part, u)/dot_product(u, u), norm2(part)/norm2(u) &
                  - 1.0_wp), i)
            end do
         end do
      end do
      call worst%check_below(1.0e-6_wp, "stiffness of a spot whose narrow rim slips")
   end subroutine test_narrow_rim_that_slips

   !> Shells with the limit of other friction models: full sliding is that of the model, and pure
   !> shift and pure twist are those of the exact wrench; the wrench does not jump, but with
   !> `pade11`, whose limit is not convex.
   subroutine test_rungs()
      type(spring_spot_type) :: spot
      type(shells_type) :: shells, exact
      type(random_type) :: random
      type(worst_type) :: worst, alike, jumps
      procedure(wrench_jacobian_kernel), pointer :: rung
      real(wp) :: wrench(3), other(3), stored, lost, u(3), unit(3), expected(3), slopes(3, 3), &
         step(3), least
      integer :: model, i, j, k

      least = 0.0_wp
      do model = 1, 3
         rung => wrench_pade11_jacobian
         if (model == 2) rung => wrench_pade22_jacobian
         if (model == 3) rung => wrench_simplified_jacobian
         do i = 1, 2
            spot%shape = circular_shape
            if (i == 2) spot%shape = elliptic_shape(0.5_wp)
            spot%a = a
            spot%limit = limit
            call spot%stiffen(modulus, poisson)
            unit = limit/spot%stiffness*[1.0_wp, 1.0_wp, a]
            spot%rung => rung
            do j = 1, 20
               u = random%vector(3)
               u = u/norm2(u)
               shells = shells_of(4)
               do k = 1, 5
                  step = 1.0e5_wp*u*unit(1)/[1.0_wp, 1.0_wp, a]
                  call shells%advance(spot, step, wrench, stored, lost)
               end do
               call rung(spot%shape, slip_type(u(1), u(2), u(3)), expected, slopes)
               call worst%note(maxval(abs(wrench/(limit*[1.0_wp, 1.0_wp, a]) - expected)), j)
               if (model > 1) call note_jumps(spot, shells, random%vector(3)*unit, jumps, least)
            end do
            ! To and fro without twist, and the twist alone.
            exact = shells_of(4)
            shells = shells_of(4)
            do j = 1, 40
               step = 0.0_wp
               step(merge(3, 1, j > 20)) = 1.0_wp
               if (j == 21) then
                  call exact%clear()
                  call shells%clear()
               end if
               step = step*unit*random%uniform(-1.0_wp, 1.0_wp)
               call shells%advance(spot, step, wrench, stored, lost)
               spot%rung => null()
               call exact%advance(spot, step, other, stored, lost)
               spot%rung => rung
               call alike%note(maxval(abs(wrench - other)/(limit*[1.0_wp, 1.0_wp, a])), j)
            end do
         end do
      end do
      call worst%check_below(1.0e-4_wp, "rungs: full sliding with spinning")
      call alike%check_below(1.0e-9_wp, "rungs: shift or twist alone")
      call jumps%check_below(3.0_wp, "rungs: steepness over that of the springs")
      call check(least >= 0.0_wp, "rungs: no slip gives work")
   end subroutine test_rungs

   !> The largest change of the wrench between two steps that are nearly the same, over that of
   !> what is elastic, and the least work of a slip.
   subroutine note_jumps(spot, shells, far, jumps, least)
      type(spring_spot_type), intent(in) :: spot
      !> What is moved.
      type(shells_type), intent(in) :: shells
      !> The longest step.
      real(wp), intent(in) :: far(3)
      type(worst_type), intent(inout) :: jumps
      !> Work of the slip [J].
      real(wp), intent(inout) :: least
      integer, parameter :: n = 200
      type(shells_type) :: moved
      real(wp) :: wrench(3), last(3), lost, stored
      integer :: i

      do i = 0, n
         moved = shells
         call moved%advance(spot, far*(real(i, wp)/real(n, wp)), wrench, stored, lost)
         least = min(least, lost)
         if (i > 0) call jumps%note(maxval(abs(wrench - last)/[1.0_wp, 1.0_wp, spot%a]) &
            /maxval(abs(spot%stiffness*far)/[1.0_wp, 1.0_wp, spot%a])*real(n, wp), i)
         last = wrench
      end do
   end subroutine note_jumps

   !> The table of sliding on ellipses against the exact wrench: the whole range of axis ratios,
   !> both sides of the borders of parts, and centres of rotation from inside the spot to infinity.
   subroutine test_table()
      integer, parameter :: n_ratios = 9
      type(random_type) :: random
      type(worst_type) :: force, torque, slope, bend
      type(ellipse_type) :: table
      type(spot_shape_type) :: shape
      real(wp) :: ratio, border, x, rho, angle
      integer :: i, j

      border = least_ratio**(1.0_wp/real(bands, wp))
      do i = 1, 4*n_ratios
         select case (i)
         case (1)
            ratio = least_ratio
         case (2)
            ratio = border*(1.0_wp - 1.0e-15_wp)
         case (3)
            ratio = border*(1.0_wp + 1.0e-15_wp)
         case (4)
            ratio = 1.0_wp
         case (5)
            ratio = 1.0_wp - 1.0e-12_wp
         case default
            ratio = 10.0_wp**random%uniform(log10(least_ratio), 0.0_wp)
         end select
         shape = elliptic_shape(ratio)
         do j = 1, 2000
            x = random%uniform(0.0_wp, 1.0_wp)
            ! At the borders, near the rim, and far away.
            if (modulo(j, 4) == 0) x = real(modulo(j, parts), wp)/parts &
               + random%uniform(-1.0e-14_wp, 1.0e-14_wp)
            if (modulo(j, 4) == 1) x = 10.0_wp**random%uniform(-12.0_wp, 0.0_wp)
            if (modulo(j, 8) == 3) x = 1.0_wp - 10.0_wp**random%uniform(-12.0_wp, 0.0_wp)
            x = min(max(x, 0.0_wp), 1.0_wp)
            rho = sqrt(ratio)*x
            angle = random%uniform(-pi, pi)
            if (modulo(j, 16) == 0) angle = 0.5_wp*pi*real(modulo(j, 7) - 3, wp)
            ! The scale is 1 - x, so that x = 1 has no spin.
            call note_both([cos(angle)*sqrt((ratio*(1.0_wp - x))**2 + rho**2), &
               sin(angle)*sqrt((1.0_wp - x)**2 + rho**2), sign(1.0_wp - x, angle)])
            ! Inside.
            call note_both([x*ratio*cos(angle), x*sin(angle), sign(1.0_wp, angle)])
         end do
      end do
      call force%check_below(4.0e-15_wp, "table of ellipses: force")
      call torque%check_below(4.0e-15_wp, "table of ellipses: torque")
      call slope%check_below(2.0e-14_wp, "table of ellipses: derivatives")
      call bend%check_below(4.0e-14_wp, "table of ellipses: second derivatives")

   contains

      !> Compare what edges bear, every second one of half the size and a load of 1/4: of many and
      !> of few shells, with wide registers and without.
      subroutine note_both(v)
         !> Sliding velocity along the axes, and W.
         real(wp), intent(in) :: v(3)
         real(wp) :: load(2*lanes), size(2*lanes), u(2*lanes, 3), bears(2*lanes, n_values), &
            few_u(2*few, 3), few_bears(2*few, n_values)
         integer :: k

         do k = 1, 2*lanes
            load(k) = 0.25_wp**(1 - modulo(k, 2))
            size(k) = 0.5_wp**(1 - modulo(k, 2))
            u(k, :) = v/norm2(v)
         end do
         few_u = u(:2*few, :)
         call table%set_ratio(shape%k, shape%k2, shape%c)
         call slide_on_ellipse(table, load, size, u, bears)
         call note_sliding([1, 2*lanes], .true., load, size, u, bears)
         call slide_few(table, load(:2*few), size(:2*few), few_u, few_bears)
         call note_sliding([1, 2*few], .true., load(:2*few), size(:2*few), few_u, few_bears)
         if (numbers_of_register() < 4) return
         call wide_slide_on_ellipse(table, load, size, u, bears)
         call note_sliding([2*lanes - 1, 2*lanes], .false., load, size, u, bears)
         call wide_slide_few(table, load(:2*few), size(:2*few), few_u, few_bears)
         call note_sliding([2, 2*few - 1], .false., load(:2*few), size(:2*few), few_u, few_bears)
         if (numbers_of_register() < 8) return
         call widest_slide_on_ellipse(table, load, size, u, bears)
         call note_sliding([lanes, lanes + 1], .false., load, size, u, bears)
         call widest_slide_few(table, load(:2*few), size(:2*few), few_u, few_bears)
         call note_sliding([few, few + 1], .false., load(:2*few), size(:2*few), few_u, few_bears)
      end subroutine note_both

      !> Compare what some edges bear.
      subroutine note_sliding(edges, rounds_alike, load, size, u, bears)
         integer, intent(in) :: edges(:)
         !> Whether rounding tells as the exact wrench does how far outside of the spot the centre
         !> of rotation is: the second derivatives go with the root of that.
         logical, intent(in) :: rounds_alike
         real(wp), intent(in) :: load(:), size(:), u(:, :), bears(:, :)
         real(wp) :: wrench(3), jacobian(3, 3), bends(4), expected(6), scale(6), w, &
            outside
         integer :: i_edge, k

         do i_edge = 1, ubound(edges, 1)
            k = edges(i_edge)
            w = size(k)*u(k, 3)
            call wrench_exact_bends(shape, u(k, 1), u(k, 2), w, wrench, jacobian, bends)
            call force%note(maxval(abs(bears(k, 1:2) + load(k)*wrench(1:2)))/load(k), i)
            call torque%note(abs(bears(k, 3) + load(k)*size(k)*wrench(3))/(load(k)*size(k)), i)
            ! Of the size one, as W dF_x/dW is, and over the speed.
            expected = [jacobian(1, 1), jacobian(1, 2), jacobian(2, 2), jacobian(1, 3), &
               jacobian(2, 3), jacobian(3, 3)]
            scale = load(k)*[1.0_wp, 1.0_wp, 1.0_wp, size(k), size(k), size(k)**2]
            expected = bears(k, 4:9)/scale + expected
            expected = expected*[1.0_wp, 1.0_wp, 1.0_wp, w, w, w*w]
            call slope%note(maxval(abs(expected))*max(norm2(u(k, 1:2)), abs(w)), i)
            outside = 1.0_wp
            if (.not. rounds_alike) then
               outside = (u(k, 1)/ratio)**2 + u(k, 2)**2
               outside = sqrt(abs(outside - w*w)/max(outside, w*w))
            end if
            call bend%note(outside*maxval(abs(bears(k, 10:13) + load(k)*bends)) &
               /(load(k)*max(maxval(abs(bends)), tiny(w))), i)
         end do
      end subroutine note_sliding
   end subroutine test_table

   !> Slip of shells side by side with wide registers and without: the same but for rounding.
   subroutine test_wide(numbers)
      !> That a register holds.
      integer, intent(in) :: numbers
      type(random_type) :: random
      type(worst_type) :: plane, circle, ellipse
      type(ellipse_type) :: table, wide_table
      type(kernels_type) :: wide
      type(spot_shape_type) :: shape
      real(wp), dimension(lanes, 3) :: stiffness, trial, held, u, wide_u, force, wide_force, &
         elastic, wide_elastic
      real(wp), dimension(lanes, 2) :: load, size, pair, shift, two, wide_two, way, wide_way
      real(wp), dimension(lanes) :: bears, length, wide_length, asked_for, done, wide_done
      real(wp), dimension(abreast, 2) :: springs, shifts, forces, wide_forces, ways, wide_ways
      real(wp), dimension(abreast) :: loads, work, wide_work
      logical, dimension(lanes) :: found, wide_found
      real(wp) :: away(3), x
      integer :: i, j, l, n, asked, unasked, slipped, unlike

      if (numbers_of_register() < numbers) return
      wide = side_by_side(numbers)
      asked = 0
      unasked = 0
      slipped = 0
      unlike = 0
      do i = 1, 400
         ! As many as there may be, fewer, and so few that half of the registers are enough.
         n = lanes - 3*modulo(i/8, 3)
         asked = asked + n
         shape = elliptic_shape(10.0_wp**random%uniform(-0.9_wp, 0.0_wp))
         do j = 1, lanes
            do l = 1, 2
               x = real(lanes + 2 - j - l, wp)/lanes
               load(j, l) = x*(1.5_wp - 0.5_wp*x*x)
               size(j, l) = load(j, l)**(2.0_wp/3.0_wp)
            end do
            stiffness(j, :) = [0.7_wp, 0.9_wp, 0.4_wp]/lanes*random%uniform(0.9_wp, 1.1_wp)
            trial(j, :) = random%vector(3)*random%uniform(0.5_wp, 3.0_wp)*(load(j, 1) - load(j, 2))
            ! Stiff against a small limit, and one out of all proportion.
            if (modulo(i, 8) == 0) stiffness(j, :) = 1.0e18_wp*stiffness(j, :)
            if (modulo(i, 8) == 1 .and. j == 2) trial(j, :) = 1.0e20_wp*trial(j, :)
            u(j, :) = random%vector(3)
            u(j, :) = u(j, :)/norm2(u(j, :))
         end do
         held = 0.0_wp
         bears = load(:, 1) - load(:, 2)
         wide_u = u
         call table%set_ratio(shape%k, shape%k2, shape%c)
         call wide_table%set_ratio(shape%k, shape%k2, shape%c)
         asked_for = 0.0_wp
         asked_for(:n) = 1.0_wp
         call slip_on_ellipses(table, shape%torque, asked_for, load, size, stiffness, trial, held, &
            .false., u, force, elastic, length, done, found)
         call wide%slip_on_ellipses(wide_table, shape%torque, asked_for, load, size, stiffness, &
            trial, held, .false., wide_u, wide_force, wide_elastic, wide_length, wide_done, &
            wide_found)
         unasked = unasked + count(found(n + 1:)) + count(wide_found(n + 1:))
         if (modulo(i, 8) == 1) then
            call check(.not. (found(2) .or. wide_found(2)), "a shell that is left to others")
            trial(2, :) = 1.0e-20_wp*trial(2, :)
         end if
         do j = 1, n
            if (.not. (found(j) .and. wide_found(j))) cycle
            if (length(j) > 0.0_wp .neqv. wide_length(j) > 0.0_wp) unlike = unlike + 1
            if (.not. length(j) > 0.0_wp) cycle
            slipped = slipped + 1
            call ellipse%note(maxval(abs(force(j, :) - wide_force(j, :)))/bears(j), i)
            away = trial(j, :)/stiffness(j, :)
            call ellipse%note(norm2(elastic(j, :)*stiffness(j, :) - force(j, :))/bears(j), i)
            call ellipse%note(abs(done(j) - wide_done(j))/(bears(j)*norm2(away)), i)
            ! What is lost is the work of the force along the slip.
            call ellipse%note(abs(done(j) - dot_product(force(j, :), away - elastic(j, :))) &
               /(bears(j)*norm2(away)), i)
         end do
         ! On a circle.
         pair(:n, 1) = stiffness(:n, 1)
         pair(:n, 2) = stiffness(:n, 3)
         shift(:n, 1) = hypot(trial(:n, 1), trial(:n, 2))
         shift(:n, 2) = abs(trial(:n, 3))
         way(:n, 1) = shift(:n, 1)/hypot(shift(:n, 1), shift(:n, 2))
         way(:n, 2) = shift(:n, 2)/hypot(shift(:n, 1), shift(:n, 2))
         wide_way = way
         call slip_on_circles(shape%torque, n, load, size, pair, shift, held(:, :2), .false., &
            way, two, found)
         call wide%slip_on_circles(shape%torque, n, load, size, pair, shift, held(:, :2), &
            .false., wide_way, wide_two, wide_found)
         do j = 1, n
            if (.not. (found(j) .and. wide_found(j))) cycle
            slipped = slipped + 1
            call circle%note(maxval(abs(two(j, :) - wide_two(j, :)))/bears(j), i)
         end do
         ! In the plane, where all are beyond their limits.
         do j = 1, n
            loads(j) = bears(j)
            springs(j, :) = stiffness(j, 1:2)
            forces(j, :) = trial(j, 1:2)*(1.0_wp + 2.0_wp*bears(j)/norm2(trial(j, 1:2)))
            shifts(j, :) = forces(j, :)/springs(j, :)
         end do
         wide_forces = forces
         call slip_in_plane(n, loads, springs, shifts, forces, ways, work)
         call wide%slip_in_plane(n, loads, springs, shifts, wide_forces, wide_ways, wide_work)
         do j = 1, n
            call plane%note(maxval(abs([forces(j, :) - wide_forces(j, :), (work(j) &
               - wide_work(j))/norm2(shifts(j, :))]))/bears(j), i)
         end do
      end do
      call check(slipped > asked, "shells that slip by wide registers")
      call check(unasked == 0, "shells that are not asked for, by wide registers")
      call check(unlike == 0, "whether a shell slips, by wide registers")
      call plane%check_below(1.0e-14_wp, "slip in the plane by wide registers")
      call circle%check_below(1.0e-11_wp, "slip on a circle by wide registers")
      call ellipse%check_below(1.0e-11_wp, "slip on an ellipse by wide registers")
   end subroutine test_wide

   !> What is strained keeps its energy at most where an ellipse turns over it.
   subroutine test_turned()
      type(random_type) :: random
      type(worst_type) :: worst
      type(shells_type) :: past, now
      type(spring_spot_type) :: spot
      real(wp) :: wrench(3), step(3), axes(2, 2), angle, along, across, before, after
      integer :: i, j

      do i = 1, 100
         call past%begin()
         call now%begin()
         spot = spot_of(random%uniform(0.05_wp, 0.9_wp), a, limit, poisson)
         step = random%vector(3)*1.0e-3_wp*spot%limit/(spot%stiffness*[1.0_wp, 1.0_wp, 1.0_wp/a])
         call past%advance(spot, step, wrench)
         do j = 1, 2
            angle = random%uniform(-pi, pi)
            axes(:, j) = [cos(angle), sin(angle)]
         end do
         ! Components along an axis, which is seen in another direction then.
         call past%turn_to(axes(:, 1))
         call now%take(past, axes(:, 2), [1.0_wp, 1.0_wp, 1.0_wp])
         angle = atan2(axes(2, 2), axes(1, 2)) - atan2(axes(2, 1), axes(1, 1))
         along = cos(angle)*step(1) - sin(angle)*step(2)
         across = sin(angle)*step(1) + cos(angle)*step(2)
         before = spot%stiffness(1)*step(1)**2 + spot%stiffness(2)*step(2)**2
         after = spot%stiffness(1)*along**2 + spot%stiffness(2)*across**2
         after = 0.5_wp*(min(before, after) + spot%stiffness(3)*step(3)**2)
         call worst%note(abs(now%energy() - after)/after, i)
      end do
      call worst%check_below(1.0e-12_wp, "energy of what is strained where an ellipse turns")
   end subroutine test_turned

   !> What slides and spins as it rolls bears the same for any length of its steps: the slip in a
   !> step fades as what is strained does.
   subroutine test_rolling_slip()
      type(random_type) :: random
      type(worst_type) :: worst
      type(tangential_type) :: contact
      type(rung_type) :: friction
      type(passing_type) :: rolls
      type(spring_spot_type) :: spot
      real(wp) :: states(n_states), wrench(3, 2), rates(n_states), move(3), way
      integer :: i, j, k, last

      friction%coefficient = 0.3_wp
      friction%kernel => wrench_exact
      friction%jacobian => wrench_exact_jacobian
      contact%coefficient = friction%coefficient
      contact%modulus = modulus
      contact%poisson = poisson
      do k = 1, 3
         spot = spot_of(ratios(k), a, limit, poisson)
         rolls = passing_type(limit/friction%coefficient, a)
         do i = 1, 10
            move = random%vector(3)*random%uniform(0.3_wp, 1.0_wp)*sliding_shift(spot) &
               /[1.0_wp, 1.0_wp, a]
            way = random%uniform(0.02_wp, 0.2_wp)*a
            do j = 1, 2
               call contact%begin(9)
               call contact%forget()
               states = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
               ! Steps, and steps of a third.
               do last = 1, 200*(2*j - 1)
                  call contact%evolve(friction, spot%shape, rolls, states, wrench(:, j), rates)
                  call contact%keep()
                  states(3:5) = states(3:5) + move/(2*j - 1)
                  states(6) = states(6) + way/(2*j - 1)
               end do
            end do
            call worst%note(maxval(abs(wrench(:, 2) - wrench(:, 1))/(limit*[1.0_wp, 1.0_wp, a])), i)
         end do
      end do
      call worst%check_below(1.0e-9_wp, "steady sliding and rolling in steps of any length")
   end subroutine test_rolling_slip

   !> What slides in a direction that turns bears the same for any length of its steps, but for the
   !> square of the turn in a step.
   subroutine test_turning_slip()
      real(wp), parameter :: turn = 0.01_wp
      type(random_type) :: random
      type(worst_type) :: worst
      type(tangential_type) :: contact
      type(rung_type) :: friction
      type(passing_type) :: rolls
      type(spring_spot_type) :: spot
      real(wp) :: states(n_states), wrench(3, 2), rates(n_states), speed, spin, angle
      integer :: i, j, k, last, parts

      friction%coefficient = 0.3_wp
      friction%kernel => wrench_exact
      friction%jacobian => wrench_exact_jacobian
      contact%coefficient = friction%coefficient
      contact%modulus = modulus
      contact%poisson = poisson
      do k = 1, 3
         spot = spot_of(ratios(k), a, limit, poisson)
         do i = 1, 10
            ! Within the way after which sliding takes over.
            speed = random%uniform(0.2_wp, 0.25_wp)*sliding_shift(spot)
            spin = random%uniform(0.0_wp, 1.0_wp)*speed/a
            do j = 1, 2
               parts = merge(8, 1, j == 2)
               call contact%begin(9)
               call contact%forget()
               states = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
               do last = 0, 40*parts
                  angle = turn*real(last, wp)/real(parts, wp)
                  rolls = passing_type(limit/friction%coefficient, a, speed*cos(angle), &
                     speed*sin(angle), spin)
                  states(3) = speed*sin(angle)/turn
                  states(4) = speed*(1.0_wp - cos(angle))/turn
                  states(5) = spin*angle/turn
                  call contact%evolve(friction, spot%shape, rolls, states, wrench(:, j), rates)
                  call contact%keep()
               end do
            end do
            call worst%note(maxval(abs(wrench(:, 2) - wrench(:, 1))/(limit*[1.0_wp, 1.0_wp, a])), i)
         end do
      end do
      call worst%check_below(turn**2, "sliding in a direction that turns, in steps of any length")
   end subroutine test_turning_slip

   !> Histories with wide registers and without: the same but for rounding.
   subroutine test_histories(numbers)
      !> That a register holds.
      integer, intent(in) :: numbers
      integer, parameter :: steps = 60
      type(random_type) :: random
      type(worst_type) :: worst
      type(shells_type) :: past(2), now(2)
      type(spring_spot_type) :: spot
      real(wp) :: wrench(3, 2), step(3), turn, axis(2), left(3), ratio, largest
      integer :: i, j, k

      if (numbers_of_register() < numbers) return
      do i = 1, 60
         do k = 1, 2
            call past(k)%begin()
            call now(k)%begin()
            past(k)%kernels = side_by_side(merge(numbers, 2, k == 2))
            now(k)%kernels = past(k)%kernels
         end do
         ratio = merge(1.0_wp, random%uniform(0.05_wp, 1.0_wp), modulo(i, 3) == 0)
         step = random%vector(3)*random%uniform(0.0_wp, 0.4_wp)
         if (modulo(i, 4) == 0) step(3) = 0.0_wp
         turn = 0.0_wp
         do j = 1, steps
            largest = 1.0_wp + 0.5_wp*sin(random%uniform(0.1_wp, 0.3_wp)*j)
            spot = spot_of(ratio, a*largest, limit*largest**3, poisson)
            if (modulo(j, 20) == 0) step = -step
            turn = turn + random%uniform(-0.3_wp, 0.3_wp)
            axis = [cos(turn), sin(turn)]
            left = [1.0_wp, 1.0_wp, 1.0_wp]*random%uniform(0.9_wp, 1.0_wp)
            left(1) = left(2)
            do k = 1, 2
               call now(k)%take(past(k), axis, left)
               call now(k)%advance(spot, step*spot%limit/(spot%stiffness*[1.0_wp, 1.0_wp, &
                  1.0_wp/spot%a]), wrench(:, k), settled=.false.)
               call now(k)%turn_to(axis)
               call now(k)%settle(spot)
               call past(k)%copy(now(k))
               call past(k)%foresee(0.1_wp*spot%a)
            end do
            call worst%note(maxval(abs(wrench(:, 2) - wrench(:, 1))*[1.0_wp, 1.0_wp, &
               1.0_wp/spot%a])/spot%limit, i)
         end do
      end do
      call worst%check_below(1.0e-12_wp, "histories by wide registers")
   end subroutine test_histories

   !> What is a little more than the force of sliding in some direction slips, what is a little less
   !> sticks, wherever the search begins: sliding forces are the border of a convex set.
   subroutine test_border()
      real(wp), parameter :: little = 0.01_wp
      type(random_type) :: random
      type(ellipse_type) :: table
      type(spot_shape_type) :: shape
      real(wp), dimension(lanes, 3) :: stiffness, border, trial, held, u, force, elastic
      real(wp), dimension(lanes, 2) :: load, size
      real(wp), dimension(lanes) :: length, asked_for, done
      real(wp) :: direction(3), x
      logical, dimension(lanes) :: found, beyond
      integer :: i, j, l, n, known, asked, wrong

      held = 0.0_wp
      asked = 0
      known = 0
      wrong = 0
      do i = 1, 1000
         n = lanes - 3*modulo(i, 3)
         shape = elliptic_shape(10.0_wp**random%uniform(-0.9_wp, 0.0_wp))
         call table%set_ratio(shape%k, shape%k2, shape%c)
         do j = 1, lanes
            do l = 1, 2
               x = real(lanes + 2 - j - l, wp)/lanes
               load(j, l) = x*(1.5_wp - 0.5_wp*x*x)
               size(j, l) = load(j, l)**(2.0_wp/3.0_wp)
            end do
            stiffness(j, :) = [0.7_wp, 0.9_wp, 0.4_wp]/lanes*random%uniform(0.9_wp, 1.1_wp)
            u(j, :) = random%vector(3)
            u(j, :) = u(j, :)/norm2(u(j, :))
         end do
         direction = random%vector(3)
         direction = direction/norm2(direction)
         call slide_shells(table, lanes, [load(lanes, 2), load(lanes:1:-1, 1)], &
            [size(lanes, 2), size(lanes:1:-1, 1)], direction, border)
         border = border(lanes:1:-1, :)
         do j = 1, lanes
            beyond(j) = random%uniform(0.0_wp, 1.0_wp) > 0.5_wp
            trial(j, :) = border(j, :)*(1.0_wp + merge(little, -little, beyond(j)))
         end do
         asked_for = 0.0_wp
         asked_for(:n) = 1.0_wp
         call slip_on_ellipses(table, shape%torque, asked_for, load, size, stiffness, trial, held, &
            .false., u, force, elastic, length, done, found)
         asked = asked + n
         known = known + count(found(:n))
         wrong = wrong + count(found(:n) .and. (length(:n) > 0.0_wp .neqv. beyond(:n)))
      end do
      call check(20*known > 19*asked, "nearly all shells near the border are found")
      call check(wrong == 0, "whether a shell near the border slips")
   end subroutine test_border

   !> An ellipsoid is within the limit of a shell if no direction of sliding has a smaller potential
   !> than the ellipsoid.
   subroutine test_inner_ellipsoid()
      real(wp), parameter :: ratios(*) = [1.0_wp, 0.7_wp, 0.5_wp, 0.3_wp, 0.15_wp, 0.05_wp, &
         1.0e-3_wp]
      real(wp), parameter :: edges(2, 5) = reshape([0.0_wp, 1.0_wp, 0.0_wp, 0.3_wp, 0.5_wp, &
         0.8_wp, 0.6_wp, 0.601_wp, 0.95_wp, 0.999_wp], [2, 5])
      integer, parameter :: ways = 6, spins = 40
      type(spot_shape_type) :: shape
      real(wp) :: u(3), force(3), slides, turns, angle, part, share, least
      integer :: i, j, l, m

      do i = 1, size(ratios)
         shape = elliptic_shape(ratios(i))
         least = huge(least)
         do j = 1, size(edges, 2)
            call force_of_sliding(shape, edges(1, j), edges(2, j), [1.0_wp, 0.0_wp, 0.0_wp], force)
            slides = norm2(force)
            call force_of_sliding(shape, edges(1, j), edges(2, j), [0.0_wp, 0.0_wp, 1.0_wp], force)
            turns = norm2(force)
            do l = 0, ways
               angle = 0.5_wp*pi*real(l, wp)/ways
               do m = 0, spins
                  part = 0.5_wp*pi*real(m, wp)/spins
                  u = [cos(part)/slides*[cos(angle), sin(angle)], sin(part)/turns]
                  call force_of_sliding(shape, edges(1, j), edges(2, j), u, force)
                  least = min(least, dot_product(force, u))
               end do
            end do
         end do
         share = least/inner_ellipsoid(ratios(i))
         call check(share >= 1.0_wp, "an ellipsoid within the limits of shells")
         call check(share < 1.02_wp, "an ellipsoid that is not much smaller than it may be")
      end do
   end subroutine test_inner_ellipsoid

   !> What is so far within the limit of a shell, about, that it surely sticks: the force of no
   !> direction of sliding is.
   subroutine test_limit()
      real(wp), parameter :: ratios(*) = [1.0_wp, 0.8_wp, 0.5_wp, 0.3_wp, 0.15_wp, least_ratio]
      real(wp), parameter :: edges(2, 6) = reshape([0.0_wp, 1.0_wp, 0.0_wp, 0.1_wp, 0.1_wp, &
         0.3_wp, 0.6_wp, 0.601_wp, 0.875_wp, 1.0_wp, 0.99_wp, 1.0_wp], [2, 6])
      integer, parameter :: ways = 18, spins = 60
      type(spot_shape_type) :: shape
      type(ellipse_type) :: table
      real(wp) :: u(3), force(3), slides, turns, angle, part, limit, slopes(3), off, least, &
         least_of_all
      integer :: i, j, l, m, known

      least_of_all = huge(least)
      do i = 1, size(ratios)
         shape = elliptic_shape(ratios(i))
         call table%set_ratio(shape%k, shape%k2, shape%c)
         least = huge(least)
         off = 0.0_wp
         known = 0
         do j = 1, size(edges, 2)
            call force_of_sliding(shape, edges(1, j), edges(2, j), [1.0_wp, 0.0_wp, 0.0_wp], force)
            slides = norm2(force)
            call force_of_sliding(shape, edges(1, j), edges(2, j), [0.0_wp, 0.0_wp, 1.0_wp], force)
            turns = norm2(force)
            do l = 0, ways
               angle = 0.5_wp*pi*real(l, wp)/ways
               do m = 0, spins
                  part = 0.5_wp*pi*real(m, wp)/spins
                  u = [cos(part)/slides*[cos(angle), sin(angle)], sin(part)/turns]
                  call force_of_sliding(shape, edges(1, j), edges(2, j), u, force)
                  force = force/[slides, slides, turns]
                  call look_at_limit(table%bulge, force(1)**2, force(2)**2, force(3)**2, limit, &
                     slopes(1), slopes(2), slopes(3))
                  least = min(least, limit)
                  if (edges(1, j) <= 0.0_wp) cycle
                  ! The direction that the gradient tells.
                  slopes = slopes*force/[slides, slides, turns]
                  off = off + norm2(slopes/norm2(slopes) - u/norm2(u))
                  known = known + 1
               end do
            end do
         end do
         call check(least > surely_stuck, "what surely sticks is within the limits of shells")
         call check(off < merge(0.012_wp, 0.04_wp, ratios(i) >= 0.5_wp)*known, &
            "the direction of a slip is about that of the gradient of a limit")
         least_of_all = min(least_of_all, least)
      end do
      call check(least_of_all < surely_stuck + 0.02_wp, "what surely sticks is not much less")
   end subroutine test_limit

   !> Shells without a contact.
   pure function shells_of(layers) result(shells)
      !> Number of layers, >= 1.
      integer, intent(in) :: layers
      type(shells_type) :: shells

      call shells%begin(layers)
   end function shells_of

   !> Force that a shell between two places bears when it slides, in units of f N and f N a.
   pure subroutine force_of_sliding(shape, inner, outer, u, force)
      type(spot_shape_type), intent(in) :: shape
      !> The places in units of the semi-axis.
      real(wp), intent(in) :: inner, outer
      !> Shift along the axes, and twist times the semi-axis.
      real(wp), intent(in) :: u(3)
      real(wp), intent(out) :: force(3)
      type(shell_type) :: shell
      type(shared_type) :: shared
      real(wp) :: hessian(3, 3)

      shell%shape = shape
      shell%inner = edge_at(inner, power_of(inner))
      shell%outer = edge_at(outer, power_of(outer))
      call sliding_force(shell, u, shared, force, hessian)
   end subroutine force_of_sliding

end module test_tangential
