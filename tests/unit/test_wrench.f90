!> Tests of the friction wrench: reference values, limits, closed forms, and the properties that
!> follow from its potential.
module test_wrench
   use, intrinsic :: ieee_arithmetic, only : ieee_is_nan, ieee_negative_inf, ieee_positive_inf, &
      ieee_quiet_nan, ieee_value
   use contensou_base_kinds, only : pi, wp
   use contensou_contact_friction, only : friction_model_type, friction_models
   use contensou_contact_friction_ladder, only : rung_type
   use contensou_contact_friction_law, only : sliding_type
   use contensou_contact_spot, only : circular_shape
   use contensou_contact_wrench, only : slip_type, wrench_coulomb, wrench_exact, wrench_kernel, &
      wrench_pade11, wrench_pade22, wrench_simplified
   use test_harness, only : check, check_close, check_relative, random_type, read_table, &
      table_type, worst_type
   implicit none(type, external)
   private

   public :: run_wrench_tests

   !> Precision of the closed forms, which cancel.
   integer, parameter :: qp = selected_real_kind(30)

   !> Slope of the force at rest.
   real(wp), parameter :: slope = 3.0_wp*pi/8.0_wp

   !> Torque of pure spinning.
   real(wp), parameter :: k_t = 3.0_wp*pi/16.0_wp

   !> Number of random states for each property.
   integer, parameter :: n_states = 100000

contains

   !> Run all tests.
   subroutine run_wrench_tests()
      call test_reference()
      call test_reference_jacobian()
      call test_dimensional()
      call test_table()
      call test_limits()
      call test_closed_form()
      call test_joints()
      call test_homogeneity()
      call test_parities()
      call test_potential()
      call test_monotone()
      call test_jacobian()
      call test_regularisation()
      call test_regularised_monotone()
      call test_coulomb()
      call test_simplified()
      call test_pade()
      call test_without_torque()
      call test_outside_domain()
   end subroutine run_wrench_tests

   !> Wrench on a circular spot as a vector (Fx, Fy, T) of the velocity (vx, vy, W).
   function wrench_of(kernel, v, delta) result(w)
      !> The rung.
      procedure(wrench_kernel) :: kernel
      !> Velocity (vx, vy, W).
      real(wp), intent(in) :: v(3)
      !> Regularisation velocity; zero if not given.
      real(wp), intent(in), optional :: delta
      real(wp) :: w(3)

      if (present(delta)) then
         call kernel(circular_shape, slip_type(v(1), v(2), v(3), delta), .true., w)
      else
         call kernel(circular_shape, slip_type(v(1), v(2), v(3)), .true., w)
      end if
   end function wrench_of

   !> Exact wrench without regularisation.
   function exact(v) result(w)
      !> Velocity (vx, vy, W).
      real(wp), intent(in) :: v(3)
      real(wp) :: w(3)

      w = wrench_of(wrench_exact, v)
   end function exact

   !> Rows of the table with a circular spot.
   subroutine test_reference()
      type(table_type) :: table
      real(wp), allocatable :: k(:), ux(:), uy(:), spins(:), fx(:), fy(:), tz(:)
      real(wp) :: w(3)
      type(worst_type) :: force, torque, reversed
      integer :: i

      call read_table("wrench", table)
      k = table%column("k")
      ux = table%column("ux")
      uy = table%column("uy")
      spins = table%column("wflag")
      fx = table%column("Fx")
      fy = table%column("Fy")
      tz = table%column("Tz")
      do i = 1, table%rows
         if (k(i) < 1.0_wp) cycle
         w = exact([ux(i), uy(i), spins(i)])
         call force%note(max(abs(w(1) - fx(i)), abs(w(2) - fy(i))), i)
         call torque%note(abs(w(3) - tz(i)), i)
         if (spins(i) <= 0.0_wp) cycle
         w = exact([-ux(i), -uy(i), -spins(i)])
         call reversed%note(maxval(abs(w + [fx(i), fy(i), tz(i)])), i)
      end do
      call force%check_below(2.0e-15_wp, "force of the table")
      call torque%check_below(2.0e-15_wp, "torque of the table")
      call reversed%check_below(2.0e-15_wp, "table with the motion reversed")
      call check(count(k >= 1.0_wp) >= 30, "the table has rows with a circular spot")
   end subroutine test_reference

   !> Values and derivatives of the table of derivatives.
   subroutine test_reference_jacobian()
      type(table_type) :: table
      real(wp), allocatable :: k(:), columns(:, :)
      real(wp) :: v(3), w(3), jacobian(3, 3), given(3, 3), scale
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
         if (k(i) < 1.0_wp) cycle
         v = columns(i, 1:3)
         w = exact(v)
         call values%note(maxval(abs(w - columns(i, 4:6))), i)
         given(1, :) = columns(i, [7, 8, 10])
         given(2, :) = columns(i, [8, 9, 11])
         given(3, :) = columns(i, [10, 11, 12])
         scale = norm2(v)
         call differentiate(v, 1.0e-5_wp*scale, jacobian)
         call derivatives%note(scale*maxval(abs(jacobian - given)), i)
      end do
      call values%check_below(2.0e-15_wp, "wrench of the table of derivatives")
      call derivatives%check_below(1.0e-7_wp, "derivatives of the table")
   end subroutine test_reference_jacobian

   !> Jacobian of the exact wrench by differences of fourth order.
   subroutine differentiate(v, h, jacobian)
      !> Velocity.
      real(wp), intent(in) :: v(3)
      !> Step.
      real(wp), intent(in) :: h
      !> Derivative of component i with respect to velocity j at (i, j).
      real(wp), intent(out) :: jacobian(3, 3)
      real(wp) :: e(3)
      integer :: j

      do j = 1, 3
         e = 0.0_wp
         e(j) = h
         jacobian(:, j) = (8.0_wp*(exact(v + e) - exact(v - e)) &
            - (exact(v + 2.0_wp*e) - exact(v - 2.0_wp*e)))/(12.0_wp*h)
      end do
   end subroutine differentiate

   !> Wrench in SI units.
   subroutine test_dimensional()
      type(table_type) :: table
      type(rung_type) :: friction
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
         if (b(i) < a(i)) cycle
         friction%coefficient = f(i)
         call friction%wrench(circular_shape, sliding_type(load(i), a(i), vx(i), vy(i), w(i)), r)
         call force%note(max(abs(r(1) - fx(i)), abs(r(2) - fy(i)))/(f(i)*load(i)), i)
         call torque%note(abs(r(3) - tz(i))/(f(i)*load(i)*a(i)), i)
      end do
      call force%check_below(2.0e-15_wp, "force of the table in SI units")
      call torque%check_below(2.0e-15_wp, "torque of the table in SI units")

      friction%drilling = .false.
      call friction%wrench(circular_shape, &
         sliding_type(2.0_wp, 1.0e-3_wp, 1.0_wp, 1.0_wp, 1.0e3_wp), r)
      call check(abs(r(3)) <= 0.0_wp .and. r(1) < 0.0_wp, "no torque in SI units without drilling")
   end subroutine test_dimensional

   !> The names of the table belong to their rungs.
   subroutine test_table()
      call check_rung("coulomb", wrench_coulomb)
      call check_rung("contensou_simplified", wrench_simplified)
      call check_rung("pade11", wrench_pade11)
      call check_rung("pade22", wrench_pade22)
      call check_rung("contensou_exact", wrench_exact)

   contains

      !> Check that a name stands for a rung.
      subroutine check_rung(name, kernel)
         character(len=*), intent(in) :: name
         !> The rung.
         procedure(wrench_kernel) :: kernel
         type(friction_model_type), allocatable :: models(:)
         logical :: same
         integer :: i

         models = friction_models()
         same = .false.
         do i = 1, size(models)
            if (models(i)%info%name == name) same = associated(models(i)%kernel, kernel)
         end do
         call check(same, name // ": its rung in the table")
      end subroutine check_rung

   end subroutine test_table

   !> Pure spin, pure sliding and rest for all rungs.
   subroutine test_limits()
      type(friction_model_type), allocatable :: models(:)
      character(len=:), allocatable :: name
      real(wp) :: w(3), direction(2), expected
      type(random_type) :: random
      type(worst_type) :: spinning, sliding, rest
      integer :: i, j

      models = friction_models()
      do i = 1, size(models)
         if (.not. associated(models(i)%kernel)) cycle
         name = trim(models(i)%info%name)
         spinning = worst_type()
         sliding = worst_type()
         rest = worst_type()
         expected = merge(-k_t, 0.0_wp, models(i)%uses("drilling"))
         do j = 1, 200
            w = wrench_of(models(i)%kernel, [0.0_wp, 0.0_wp, random%decades(-300.0_wp, 300.0_wp)])
            call spinning%note(maxval(abs(abs(w) - [0.0_wp, 0.0_wp, abs(expected)])), j)
            direction = random%vector(2)
            w = wrench_of(models(i)%kernel, [direction, 0.0_wp]*random%decades(-300.0_wp, 300.0_wp))
            call sliding%note(max(abs(norm2(w(:2)) - 1.0_wp), abs(w(3))), j)
            w = wrench_of(models(i)%kernel, [0.0_wp, 0.0_wp, 0.0_wp], merge(0.0_wp, &
               abs(random%decades(-300.0_wp, 300.0_wp)), j == 1))
            call rest%note(maxval(abs(w)), j)
         end do
         call spinning%check_below(epsilon(1.0_wp), name // ": pure spin, no force and torque k_T")
         call sliding%check_below(1.0e-15_wp, name // ": pure sliding, unit force and no torque")
         call rest%check_below(0.0_wp, name // ": rest")

         w = wrench_of(models(i)%kernel, [0.0_wp, 0.0_wp, 2.0_wp])
         call check_close(w(3), expected, 2.0e-16_wp, name // ": torque against a positive spin")
         w = wrench_of(models(i)%kernel, [0.0_wp, 0.0_wp, -2.0_wp])
         call check_close(w(3), -expected, 2.0e-16_wp, name // ": torque against a negative spin")
         w = wrench_of(models(i)%kernel, [3.0_wp, -4.0_wp, 0.0_wp])
         call check_close(w(1), -0.6_wp, 1.0e-15_wp, name // ": sliding force against v, x")
         call check_close(w(2), 0.8_wp, 1.0e-15_wp, name // ": sliding force against v, y")
      end do
      call check_relative(circular_shape%slope_x, slope, 1.0e-15_wp, "slope of the circle")
      call check_relative(circular_shape%torque, k_t, 1.0e-15_wp, "k_T of the circle")
   end subroutine test_limits

   !> Force and torque of the circle for u >= 1 in closed form.
   pure subroutine closed_form(u, force, torque)
      !> Sliding velocity over spin velocity, >= 1.
      real(wp), intent(in) :: u
      !> Force in units of f N.
      real(wp), intent(out) :: force
      !> Torque in units of f N a.
      real(wp), intent(out) :: torque
      real(qp) :: x, s, q

      x = real(u, qp)
      s = asin(1.0_qp/x)
      q = sqrt((x - 1.0_qp)*(x + 1.0_qp))
      force = real(-0.75_qp*((x - x**3/4)*s + q*(2 + x**2)/(4*x)), wp)
      torque = real(-0.375_qp*((1 - x**2 + 3*x**4/8)*s + 0.375_qp*q*(2 - x**2)), wp)
   end subroutine closed_form

   !> The closed forms of the circle.
   subroutine test_closed_form()
      type(random_type) :: random
      type(worst_type) :: force, torque, across
      real(wp) :: u, psi, expected_force, expected_torque, w(3)
      integer :: i

      do i = 1, 3000
         u = 1.0_wp + (i - 1)*1.0e-3_wp
         if (i > 2100) u = abs(random%decades(0.4_wp, 3.0_wp))
         call closed_form(u, expected_force, expected_torque)
         w = exact([u, 0.0_wp, 1.0_wp])
         call force%note(abs(w(1) - expected_force), i)
         call torque%note(abs(w(3) - expected_torque), i)
         psi = random%uniform(0.0_wp, 2.0_wp*pi)
         w = exact([u*cos(psi), u*sin(psi), 1.0_wp])
         call across%note(maxval(abs(w - [expected_force*cos(psi), expected_force*sin(psi), &
            expected_torque])), i)
      end do
      call force%check_below(2.0e-15_wp, "force in closed form, 1 <= u < 1000")
      call torque%check_below(2.0e-15_wp, "torque in closed form, 1 <= u < 1000")
      call across%check_below(3.0e-15_wp, "closed form in all directions")
   end subroutine test_closed_form

   !> No jump at the rim of the spot, nor where the number of nodes changes.
   subroutine test_joints()
      type(worst_type) :: jump
      real(wp) :: u, psi, below(3), above(3), joints(3), direction(2)
      character(len=*), parameter :: names(3) = [character(len=16) :: "the rim", "8 nodes", &
         "4 nodes"]
      integer :: i, j

      joints = [1.0_wp, sqrt(1.0_wp + 1.2_wp**2), sqrt(1.0_wp + 6.5_wp**2)]
      do j = 1, size(joints)
         jump = worst_type()
         do i = 0, 100
            psi = 0.0628_wp*i
            direction = [cos(psi), sin(psi)]
            u = joints(j)*(1.0_wp - 8.0_wp*epsilon(u))
            below = exact([u*direction, 1.0_wp])
            u = joints(j)*(1.0_wp + 8.0_wp*epsilon(u))
            above = exact([u*direction, 1.0_wp])
            call jump%note(maxval(abs(above - below)), i + 1)
         end do
         call jump%check_below(5.0e-15_wp, "no jump at " // trim(names(j)))
      end do
   end subroutine test_joints

   !> The wrench depends on the ratio of the velocities only.
   subroutine test_homogeneity()
      type(friction_model_type), allocatable :: models(:)
      type(random_type) :: random
      type(worst_type) :: plain, regularised
      real(wp) :: v(3), delta, factor
      integer :: i, j

      models = friction_models()
      do i = 1, size(models)
         if (.not. associated(models(i)%kernel)) cycle
         plain = worst_type()
         regularised = worst_type()
         do j = 1, 20000
            v = random_velocity(random, -2.0_wp, 2.0_wp)
            delta = abs(random%decades(-2.0_wp, 2.0_wp))
            factor = abs(random%decades(-300.0_wp, 300.0_wp))
            call plain%note(maxval(abs(wrench_of(models(i)%kernel, factor*v) &
               - wrench_of(models(i)%kernel, v))), j)
            call regularised%note(maxval(abs(wrench_of(models(i)%kernel, factor*v, factor*delta) &
               - wrench_of(models(i)%kernel, v, delta))), j)
         end do
         call plain%check_below(3.0e-15_wp, trim(models(i)%info%name) // &
            ": homogeneous of degree 0 from 1e-300 to 1e300")
         call regularised%check_below(3.0e-15_wp, trim(models(i)%info%name) // &
            ": homogeneous of degree 0 with delta from 1e-300 to 1e300")
      end do
   end subroutine test_homogeneity

   !> Random velocity with components of random sign and magnitude.
   function random_velocity(random, low, high) result(v)
      !> The generator.
      class(random_type), intent(inout) :: random
      !> Smallest decimal logarithm of a component.
      real(wp), intent(in) :: low
      !> Largest decimal logarithm of a component.
      real(wp), intent(in) :: high
      real(wp) :: v(3)
      integer :: i

      do i = 1, 3
         v(i) = random%decades(low, high)
      end do
   end function random_velocity

   !> Force odd in v and even in w, torque even in v and odd in w, mirror images.
   subroutine test_parities()
      type(friction_model_type), allocatable :: models(:)
      type(random_type) :: random
      type(worst_type) :: worst
      procedure(wrench_kernel), pointer :: kernel
      real(wp) :: v(3), w(3), delta
      integer :: i, j

      models = friction_models()
      do i = 1, size(models)
         if (.not. associated(models(i)%kernel)) cycle
         kernel => models(i)%kernel
         worst = worst_type()
         do j = 1, 5000
            v = random_velocity(random, -6.0_wp, 6.0_wp)
            delta = merge(0.0_wp, abs(random%decades(-3.0_wp, 3.0_wp)), modulo(j, 2) == 0)
            w = wrench_of(kernel, v, delta)
            call worst%note(maxval(abs(w*[-1, -1, 1] - wrench_of(kernel, v*[-1, -1, 1], delta))), j)
            call worst%note(maxval(abs(w*[1, 1, -1] - wrench_of(kernel, v*[1, 1, -1], delta))), j)
            call worst%note(maxval(abs(w*[-1, 1, 1] - wrench_of(kernel, v*[-1, 1, 1], delta))), j)
            call worst%note(maxval(abs(w*[1, -1, 1] - wrench_of(kernel, v*[1, -1, 1], delta))), j)
         end do
         call worst%check_below(0.0_wp, trim(models(i)%info%name) // ": parities, to the last bit")
      end do
   end subroutine test_parities

   !> The exact wrench is minus the gradient of a convex potential Phi = -(F.v + T w), homogeneous
   !> of degree 1: bounds of Phi and of the wrench, and no wrench outside the limit surface.
   subroutine test_potential()
      type(random_type) :: random
      type(worst_type) :: dissipation, low, high, force, torque, surface
      real(wp) :: v(3), w(3), other(3), speed, phi, phi_other
      integer :: i

      do i = 1, n_states
         v = random_velocity(random, -12.0_wp, 12.0_wp)
         w = exact(v)
         speed = norm2(v(:2))
         phi = -dot_product(w, v)
         call dissipation%note(-phi, i)
         ! Phi is at least that of sliding alone and of spinning alone, at most their sum.
         call low%note(max(speed, k_t*abs(v(3)))/phi, i)
         call high%note(phi/(speed + k_t*abs(v(3))), i)
         call force%note(norm2(w(:2)), i)
         call torque%note(abs(w(3)), i)
         other = random_velocity(random, -3.0_wp, 3.0_wp)
         other(3) = other(3)*abs(v(3)/speed)
         phi_other = -dot_product(exact(other), other)
         call surface%note((-dot_product(w, other) - phi_other)/norm2(other), i)
      end do
      call dissipation%check_below(0.0_wp, "exact: friction dissipates")
      call low%check_below(1.0_wp + 2.0e-15_wp, "exact: dissipates at least what one motion does")
      call high%check_below(1.0_wp + 2.0e-15_wp, "exact: dissipates at most what both motions do")
      call force%check_below(1.0_wp + 1.0e-15_wp, "exact: |F| <= 1")
      call torque%check_below(k_t*(1.0_wp + 1.0e-15_wp), "exact: |T| <= k_T")
      call surface%check_below(4.0e-15_wp, "exact: inside the limit surface")
   end subroutine test_potential

   !> (w1 - w2).(V1 - V2) <= 0 for the exact model.
   subroutine test_monotone()
      type(random_type) :: random
      type(worst_type) :: far, near
      real(wp) :: v(3), other(3)
      integer :: i

      do i = 1, n_states
         v = random_velocity(random, -4.0_wp, 4.0_wp)
         other = random_velocity(random, -4.0_wp, 4.0_wp)
         call far%note(product_of_differences(v, other, 0.0_wp), i)
         v = random_velocity(random, -1.5_wp, 1.5_wp)
         other = v + norm2(v)*random%vector(3)*abs(random%decades(-6.0_wp, 0.0_wp))
         call near%note(product_of_differences(v, other, 0.0_wp), i)
      end do
      call far%check_below(4.0e-15_wp, "exact: monotone")
      call near%check_below(4.0e-15_wp, "exact: monotone for states that are close")
   end subroutine test_monotone

   !> (w1 - w2).(V1 - V2)/|V1 - V2| of the exact model.
   function product_of_differences(v, other, delta) result(p)
      !> First velocity.
      real(wp), intent(in) :: v(3)
      !> Second velocity.
      real(wp), intent(in) :: other(3)
      !> Regularisation velocity.
      real(wp), intent(in) :: delta
      real(wp) :: p

      p = dot_product(wrench_of(wrench_exact, v, delta) - wrench_of(wrench_exact, other, delta), &
         v - other)/norm2(v - other)
   end function product_of_differences

   !> The Jacobian of the exact wrench is symmetric and negative semidefinite, and J V = 0.
   subroutine test_jacobian()
      type(random_type) :: random
      type(worst_type) :: asymmetry, along, growth
      real(wp) :: v(3), j(3, 3), x(3)
      integer :: i

      do i = 1, 20000
         v = random_velocity(random, -1.5_wp, 1.5_wp)
         v = v/norm2(v)
         call differentiate(v, 1.0e-5_wp*norm2(v(:2)), j)
         call asymmetry%note(maxval(abs(j - transpose(j))), i)
         call along%note(maxval(abs(matmul(j, v))), i)
         x = random%vector(3)
         call growth%note(dot_product(x, matmul(j, x)), i)
      end do
      call asymmetry%check_below(3.0e-7_wp, "exact: symmetric Jacobian")
      call along%check_below(3.0e-7_wp, "exact: J V = 0")
      call growth%check_below(3.0e-7_wp, "exact: negative semidefinite Jacobian")
   end subroutine test_jacobian

   !> With delta the wrench of every rung is continuous through rest, with the slopes of the
   !> regularised Coulomb law and of the fading torque.
   subroutine test_regularisation()
      type(friction_model_type), allocatable :: models(:)
      procedure(wrench_kernel), pointer :: kernel
      character(len=:), allocatable :: name
      type(random_type) :: random
      type(worst_type) :: steepness, slope_worst, bound
      real(wp), parameter :: delta = 1.0e-3_wp
      real(wp) :: v(3), other(3), w(3), expected
      integer :: i, j

      models = friction_models()
      do i = 1, size(models)
         if (.not. associated(models(i)%kernel)) cycle
         kernel => models(i)%kernel
         name = trim(models(i)%info%name)
         steepness = worst_type()
         slope_worst = worst_type()
         bound = worst_type()
         do j = 1, 20000
            v = 3.0_wp*delta*random%vector(3)
            if (modulo(j, 2) == 0) v = v*abs(random%decades(-6.0_wp, 0.0_wp))
            other = v + norm2(v)*random%vector(3)
            if (modulo(j, 3) == 0) other = -v
            call steepness%note(norm2(wrench_of(kernel, v, delta) - wrench_of(kernel, other, &
               delta))*delta/norm2(v - other), j)
            w = wrench_of(kernel, v, delta)
            call bound%note(max(norm2(w(:2)), abs(w(3))/k_t), j)

            ! Near rest: sliding alone, or with a spin that is smaller still.
            v(1:2) = delta*random%vector(2)*abs(random%decades(-250.0_wp, -9.0_wp))
            v(3) = maxval(abs(v(:2)))*random%uniform(-1.0_wp, 1.0_wp)
            if (modulo(j, 2) == 0) v(3) = 0.0_wp
            w = wrench_of(kernel, v, delta)
            call slope_worst%note(maxval(abs(w(:2) + v(:2)/delta))*delta/maxval(abs(v(:2))), j)
         end do
         call steepness%check_below(4.0_wp, name // ": continuous through rest with delta")
         call bound%check_below(1.0_wp + 1.0e-15_wp, name // ": bounded with delta")
         call slope_worst%check_below(1.0e-8_wp, name // ": slope 1/delta at rest")

         expected = merge(-k_t/(slope*delta), 0.0_wp, models(i)%uses("drilling"))
         w = wrench_of(kernel, [0.0_wp, 0.0_wp, 1.0e-10_wp*delta], delta)
         call check_close(w(3)/(1.0e-10_wp*delta), expected, 1.0e-8_wp*abs(expected), &
            name // ": torque fades with slope k_T/(k_x delta)")
         w = wrench_of(kernel, [1.0e-300_wp, 0.0_wp, 1.0_wp], 1.0e-3_wp)
         call check(w(1) < 0.0_wp, name // ": a tiny slip is not lost")
         w = wrench_of(kernel, [1.0e3_wp*delta, 0.0_wp, 0.0_wp], delta)
         call check(w(1) < -0.998_wp, name // ": delta does not matter in fast sliding")
      end do
   end subroutine test_regularisation

   !> The regularised exact wrench is monotone too.
   subroutine test_regularised_monotone()
      type(random_type) :: random
      type(worst_type) :: worst, dissipation
      real(wp) :: v(3), other(3), delta
      integer :: i

      do i = 1, n_states
         delta = abs(random%decades(-2.0_wp, 2.0_wp))
         v = random_velocity(random, -3.0_wp, 3.0_wp)
         other = random_velocity(random, -3.0_wp, 3.0_wp)
         if (modulo(i, 2) == 0) other = v + norm2(v)*random%vector(3)
         call worst%note(product_of_differences(v, other, delta), i)
         call dissipation%note(dot_product(wrench_of(wrench_exact, v, delta), v), i)
      end do
      call worst%check_below(4.0e-15_wp, "exact: monotone with delta")
      call dissipation%check_below(0.0_wp, "exact: friction with delta dissipates")
   end subroutine test_regularised_monotone

   !> The regularised Coulomb law.
   subroutine test_coulomb()
      real(wp) :: w(3)

      w = wrench_of(wrench_coulomb, [3.0e-4_wp, 4.0e-4_wp, 7.0_wp], 1.0e-3_wp)
      call check_close(w(1), -0.3_wp, 1.0e-15_wp, "coulomb: linear below delta, x")
      call check_close(w(2), -0.4_wp, 1.0e-15_wp, "coulomb: linear below delta, y")
      call check_close(w(3), 0.0_wp, 0.0_wp, "coulomb: no torque")
      w = wrench_of(wrench_coulomb, [3.0_wp, 4.0_wp, 7.0_wp], 1.0e-3_wp)
      call check_close(w(1), -0.6_wp, 1.0e-15_wp, "coulomb: full force above delta, x")
      call check_close(w(2), -0.8_wp, 1.0e-15_wp, "coulomb: full force above delta, y")
      w = wrench_of(wrench_coulomb, [0.0_wp, 1.0e-3_wp, 0.0_wp], 1.0e-3_wp)
      call check_close(w(2), -1.0_wp, 0.0_wp, "coulomb: full force at delta")
   end subroutine test_coulomb

   !> The piecewise linear model.
   subroutine test_simplified()
      type(random_type) :: random
      type(worst_type) :: low, high, shelf, tail, same, fading
      real(wp) :: u, psi, direction(2), w(3), v(3), reference(3), delta
      integer :: i

      do i = 1, 5000
         psi = random%uniform(0.0_wp, 2.0_wp*pi)
         direction = [cos(psi), sin(psi)]
         u = random%uniform(0.0_wp, 1.0_wp)/slope
         w = wrench_of(wrench_simplified, [u*direction, 1.0_wp])
         call low%note(maxval(abs(w(:2) + slope*u*direction)), i)
         u = abs(random%decades(0.0_wp, 6.0_wp))/slope
         w = wrench_of(wrench_simplified, [u*direction, -1.0_wp])
         call high%note(maxval(abs(w(:2) + direction)), i)
         u = 0.2_wp/k_t*random%uniform(0.0_wp, 0.999999_wp)
         w = wrench_of(wrench_simplified, [u*direction, 1.0_wp])
         call shelf%note(abs(w(3) + k_t), i)
         u = 0.2_wp/k_t*abs(random%decades(0.0_wp, 6.0_wp))
         w = wrench_of(wrench_simplified, [u*direction, -1.0_wp])
         call tail%note(abs(w(3)*u - 0.2_wp), i)

         ! All u* a |w| below delta.
         delta = abs(random%decades(-3.0_wp, 0.0_wp))
         v(1:2) = delta*direction*abs(random%decades(-3.0_wp, 3.0_wp))
         v(3) = slope*delta*random%uniform(-1.0_wp, 1.0_wp)
         w = wrench_of(wrench_simplified, v, delta)
         reference = wrench_of(wrench_coulomb, v, delta)
         call same%note(maxval(abs(w(:2) - reference(:2))), i)
         reference = wrench_of(wrench_simplified, v)
         call fading%note(abs(w(3) - reference(3)*abs(v(3))/(slope*delta)), i)
      end do
      call low%check_below(4.0e-16_wp, "simplified: force linear up to 1/k_x")
      call high%check_below(4.0e-16_wp, "simplified: force constant beyond 1/k_x")
      call shelf%check_below(0.0_wp, "simplified: torque k_T up to T1/k_T")
      call tail%check_below(1.0e-15_wp, "simplified: torque T1/u beyond T1/k_T")
      call same%check_below(0.0_wp, "simplified: Coulomb's force where u* a|w| < delta")
      call fading%check_below(4.0e-16_wp, "simplified: torque fades where u* a|w| < delta")
      ! Just above, delta is without effect on a slow slip.
      v = [1.0e-5_wp, 2.0e-5_wp, 1.001_wp*slope*1.0e-3_wp]
      w = wrench_of(wrench_simplified, v, 1.0e-3_wp)
      reference = wrench_of(wrench_simplified, v)
      call check(all(abs(w - reference) <= 0.0_wp), &
         "simplified: delta without effect where u* a|w| > delta")
   end subroutine test_simplified

   !> The Pade models.
   subroutine test_pade()
      type(worst_type) :: force_11, torque_11, force_22, torque_22, rest_11, rest_22, far_11, far_22
      real(wp) :: u, ku, mu, w(3), small, far(3)
      integer :: i

      do i = -120, 120
         u = 10.0_wp**(0.05_wp*i)
         ku = slope*u
         mu = k_t*u/0.2_wp
         w = wrench_of(wrench_pade11, [0.0_wp, u, 1.0_wp])
         call force_11%note(abs(w(2) + ku/(1.0_wp + ku)), i + 121)
         call torque_11%note(abs(w(3) + k_t/(1.0_wp + mu)), i + 121)
         w = wrench_of(wrench_pade22, [0.0_wp, u, 1.0_wp])
         call force_22%note(abs(w(2) + (ku + ku**2)/(1.0_wp + ku + ku**2)), i + 121)
         call torque_22%note(abs(w(3) + k_t*(1.0_wp + mu)/(1.0_wp + mu + mu**2)), i + 121)

         ! Slopes at rest and limits at infinity, with the order of what remains.
         if (i > -40) cycle
         small = u
         w = wrench_of(wrench_pade11, [small, 0.0_wp, 1.0_wp])
         call rest_11%note(abs(w(1)/small + slope)/small, i + 121)
         call rest_11%note(abs(w(3) + k_t)/small, i + 121)
         w = wrench_of(wrench_pade22, [small, 0.0_wp, 1.0_wp])
         call rest_22%note((abs(w(1)/small + slope) - 4.0e-16_wp)/small**2, i + 121)
         call rest_22%note((abs(w(3) + k_t) - 4.0e-16_wp)/small**2, i + 121)
         w = wrench_of(wrench_pade11, [1.0_wp, 0.0_wp, small])
         call far_11%note(abs(w(1) + 1.0_wp)/small, i + 121)
         call far_11%note(abs(w(3)/small + 0.2_wp)/small, i + 121)
         w = wrench_of(wrench_pade22, [1.0_wp, 0.0_wp, small])
         call far_22%note((abs(w(1) + 1.0_wp) - 4.0e-16_wp)/small**2, i + 121)
         call far_22%note((abs(w(3)/small + 0.2_wp) - 4.0e-16_wp)/small**2, i + 121)
      end do
      call force_11%check_below(4.0e-16_wp, "pade11: force k u/(1 + k u)")
      call torque_11%check_below(4.0e-16_wp, "pade11: torque k_T T1/(T1 + k_T u)")
      call force_22%check_below(6.0e-16_wp, "pade22: force")
      call torque_22%check_below(6.0e-16_wp, "pade22: torque")
      call rest_11%check_below(2.0_wp, "pade11: slope at rest, next term of first order")
      call rest_22%check_below(6.0_wp, "pade22: slope at rest, next term of second order")
      call far_11%check_below(1.0_wp, "pade11: limit at infinity, next term of first order")
      call far_22%check_below(1.0_wp, "pade22: limit at infinity, next term of second order")

      ! The second terms against the exact model: 1 - F and T u - T1 of the order 1/u^2.
      small = 1.0e-3_wp
      far = exact([1.0_wp, 0.0_wp, small])
      call check_close((far(1) + 1.0_wp)/small**2, 0.1_wp, 1.0e-6_wp, "exact: F = 1 - 1/(10 u^2)")
      call check_close(far(3)/small, -0.2_wp, 1.0e-6_wp, "exact: T = 1/(5 u)")
      far = exact([small, 0.0_wp, 1.0_wp])
      call check_close(far(1)/small, -slope, 1.0e-6_wp, "exact: slope at rest")
   end subroutine test_pade

   !> Without torque the force is the same to the last bit, and the torque is zero.
   subroutine test_without_torque()
      type(friction_model_type), allocatable :: models(:)
      type(random_type) :: random
      type(worst_type) :: worst
      real(wp) :: v(3), w(3), without(3), delta
      integer :: i, j

      models = friction_models()
      do i = 1, size(models)
         if (.not. associated(models(i)%kernel)) cycle
         worst = worst_type()
         do j = 1, 5000
            v = random_velocity(random, -8.0_wp, 8.0_wp)
            delta = merge(0.0_wp, abs(random%decades(-3.0_wp, 3.0_wp)), modulo(j, 2) == 0)
            w = wrench_of(models(i)%kernel, v, delta)
            call models(i)%kernel(circular_shape, slip_type(v(1), v(2), v(3), delta), .false., &
               without)
            call worst%note(maxval(abs(without - [w(1), w(2), 0.0_wp])), j)
         end do
         call worst%check_below(0.0_wp, trim(models(i)%info%name) // &
            ": without torque the same force")
      end do
   end subroutine test_without_torque

   !> NaN, infinite velocities and a negative delta give NaN without an exception.
   subroutine test_outside_domain()
      type(friction_model_type), allocatable :: models(:)
      type(rung_type) :: friction
      real(wp) :: bad(3), arguments(4), w(3)
      logical :: good(3)
      character(len=*), parameter :: names(3) = [character(len=10) :: "NaN", "infinity", &
         "-infinity"]
      integer :: i, j, k
      logical :: all_good

      bad = [ieee_value(1.0_wp, ieee_quiet_nan), ieee_value(1.0_wp, ieee_positive_inf), &
         ieee_value(1.0_wp, ieee_negative_inf)]
      models = friction_models()
      do i = 1, size(models)
         if (.not. associated(models(i)%kernel)) cycle
         do k = 1, size(bad)
            all_good = .true.
            do j = 1, 4
               arguments = [1.0_wp, 2.0_wp, 3.0_wp, 0.1_wp]
               arguments(j) = bad(k)
               call models(i)%kernel(circular_shape, slip_type(arguments(1), arguments(2), &
                  arguments(3), arguments(4)), .true., w)
               good = ieee_is_nan(w)
               all_good = all_good .and. all(good)
               call models(i)%kernel(circular_shape, slip_type(arguments(1), arguments(2), &
                  arguments(3), arguments(4)), .false., w)
               good = ieee_is_nan(w)
               all_good = all_good .and. all(good)
            end do
            call check(all_good, trim(models(i)%info%name) // ": " // trim(names(k)) // &
               " gives NaN in all outputs")
         end do
         w = wrench_of(models(i)%kernel, [1.0_wp, 2.0_wp, 3.0_wp], -0.1_wp)
         good = ieee_is_nan(w)
         call check(all(good), trim(models(i)%info%name) // ": a negative delta gives NaN")
      end do
      friction%kernel => wrench_pade11
      friction%coefficient = 0.3_wp
      call friction%wrench(circular_shape, sliding_type(1.0_wp, 1.0_wp, bad(1), 0.0_wp, 1.0_wp), w)
      good = ieee_is_nan(w)
      call check(all(good), "NaN in SI units")
   end subroutine test_outside_domain

end module test_wrench
