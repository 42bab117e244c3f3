!> What the kernels should give, in quadruple precision, for `contensou bench`.
!>
!> Other methods than those of the kernels: arithmetic-geometric mean for the elliptic integrals,
!> Newton's method on g = c1 D/B for Hertz's contact, and for the friction wrench Gauss-Legendre
!> panels over sqrt(s) of the integrals that stand in `contensou_contact_wrench_exact`.
module contensou_drivers_bench_reference
   use, intrinsic :: iso_fortran_env, only : real128
   use contensou_base_kinds, only : wp
   implicit none(type, external)
   private

   public :: qp, rule_type, new_rule
   public :: reference_elliptic, reference_hertz, reference_wrench

   !> Quadruple precision.
   integer, parameter :: qp = real128

   !> Circle constant [-].
   real(qp), parameter :: pi = 3.14159265358979323846264338327950288_qp

   !> Nodes of a panel.
   integer, parameter :: n_nodes = 24

   !> Gauss-Legendre rule on (0, 1).
   type :: rule_type
      real(qp) :: x(n_nodes) = 0.0_qp
      !> Weights.
      real(qp) :: w(n_nodes) = 0.0_qp
   end type rule_type

contains

   !> K, E, B, D, dK/dc, dE/dc.
   pure function reference_elliptic(c1) result(integrals)
      !> Complement c1 = 1 - c of the parameter, in (0, 1].
      real(qp), intent(in) :: c1
      real(qp) :: integrals(6)
      real(qp) :: a, g, z, mean, power, s, k, b, d

      g = sqrt(c1)
      ! z = c_n^2/c, from n = 1, where c_n is the half difference of the means.
      z = 0.25_qp*(1.0_qp - g)/(1.0_qp + g)
      a = 0.5_qp*(1.0_qp + g)
      g = sqrt(g)
      power = 1.0_qp
      s = 0.5_qp + z
      do while (power*z > 0.1_qp*epsilon(s))
         mean = 0.5_qp*(a + g)
         z = (0.25_qp*z/mean)**2*(1.0_qp - c1)
         g = sqrt(a*g)
         a = mean
         power = 2.0_qp*power
         s = s + power*z
      end do
      k = pi/(a + g)
      d = k*s
      b = k*(1.0_qp - s)
      integrals = [k, b + c1*d, b, d, 0.5_qp*b/c1, -0.5_qp*d]
   end function reference_elliptic

   !> c1, a, b, N, p0 of a contact.
   pure function reference_hertz(curvature_a, curvature_b, modulus, approach) result(contact)
      !> Half relative curvature A along the major axis [1/m], > 0.
      real(wp), intent(in) :: curvature_a
      !> Half relative curvature B along the minor axis [1/m], >= A.
      real(wp), intent(in) :: curvature_b
      !> Effective modulus E* [Pa], > 0.
      real(wp), intent(in) :: modulus
      !> Approach d [m], > 0.
      real(wp), intent(in) :: approach
      real(qp) :: contact(5)
      real(qp) :: g, c1, c, integrals(6), slope, step, d
      integer :: i

      g = real(curvature_a, qp)/real(curvature_b, qp)
      d = real(approach, qp)
      c1 = 2.0_qp*g/log(16.0_qp/g)
      if (g > 0.1_qp) c1 = g**(4.0_qp/3.0_qp)
      do i = 1, 50
         integrals = reference_elliptic(c1)
         c = 1.0_qp - c1
         associate (k => integrals(1), b => integrals(3), d => integrals(4))
            ! d log(c1 D/B)/d log(c1), with dD/dc = (B/c1 - D)/(2 c) and dB/dc = (D - B)/(2 c).
            slope = 0.75_qp
            if (c > 1.0e-12_qp) slope = 1.0_qp - c1/(2.0_qp*c)*((b/c1 - d)/d - (d - b)/b)
            step = -log(c1*d/(b*g))/slope
         end associate
         c1 = min(c1*exp(step), 1.0_qp)
         if (abs(step) < 1.0e-25_qp) exit
      end do
      integrals = reference_elliptic(c1)
      associate (k => integrals(1), t => integrals(3)/integrals(1), b => contact(3))
         contact(1) = c1
         contact(2) = sqrt((1.0_qp - t)*d/real(curvature_a, qp))
         contact(3) = sqrt(t*d/real(curvature_b, qp))
         contact(4) = 2.0_qp*pi/3.0_qp*real(modulus, qp)*contact(2)*d/k
         contact(5) = real(modulus, qp)*d/(k*b)
      end associate
   end function reference_hertz

   !> Gauss-Legendre rule, its nodes by Newton's method.
   pure function new_rule() result(rule)
      type(rule_type) :: rule
      real(qp) :: x, step, p, before, next, slope
      integer :: i, j, n

      do i = 1, n_nodes
         x = cos(pi*(real(i, qp) - 0.25_qp)/(real(n_nodes, qp) + 0.5_qp))
         do n = 1, 20
            before = 1.0_qp
            p = x
            do j = 2, n_nodes
               next = (real(2*j - 1, qp)*x*p - real(j - 1, qp)*before)/real(j, qp)
               before = p
               p = next
            end do
            slope = real(n_nodes, qp)*(before - x*p)/(1.0_qp - x*x)
            step = p/slope
            x = x - step
            if (abs(step) < 1.0e-25_qp) exit
         end do
         rule%x(i) = 0.5_qp*(1.0_qp + x)
         rule%w(i) = 1.0_qp/((1.0_qp - x*x)*slope*slope)
      end do
   end function new_rule

   !> F_x, F_y in units of f N, T in units of f N a, and derivatives by v_x, v_y and W = a w.
   subroutine reference_wrench(rule, k, vx, vy, spin, wrench, jacobian)
      !> Rule for a panel.
      type(rule_type), intent(in) :: rule
      !> Axis ratio b/a of the spot, in (0, 1].
      real(wp), intent(in) :: k
      !> Sliding velocity along the major axis [m/s].
      real(wp), intent(in) :: vx
      !> Sliding velocity along the minor axis [m/s].
      real(wp), intent(in) :: vy
      !> Spin velocity W = a w [m/s], not zero.
      real(wp), intent(in) :: spin
      !> Force and torque.
      real(qp), intent(out) :: wrench(3)
      !> Derivative of component i by velocity j [s/m].
      real(qp), intent(out) :: jacobian(3, 3)
      !> Integrals of U s/B, U s/A, s/B^2, s/(A B), s/A^2, and of the torque, each over D.
      real(qp) :: sums(6)
      real(qp) :: w, k2, ux, uy, lower, upper, x, ra, rb, sa, sb
      integer :: i

      w = abs(real(spin, qp))
      k2 = real(k, qp)**2
      ux = real(vx, qp)/w
      uy = real(vy, qp)/w
      lower = begin_of(ux, uy, k2)
      sums = 0.0_qp
      ! Panels over x = sqrt(s) up to 1, none longer than its distance from 0 or from +-i k; then
      ! one panel over 1/x.
      do while (lower < 1.0_qp)
         upper = min(lower + max(lower, real(k, qp)), 1.0_qp)
         do i = 1, n_nodes
            x = lower + (upper - lower)*rule%x(i)
            ra = 1.0_qp/(1.0_qp + x*x)
            rb = 1.0_qp/(k2 + x*x)
            call add(2.0_qp*(upper - lower)*rule%w(i)*sqrt(ra*rb), x*x*ra, x*x*rb)
         end do
         lower = upper
      end do
      upper = 1.0_qp/lower
      do i = 1, n_nodes
         x = upper*rule%x(i)
         sa = 1.0_qp/(1.0_qp + x*x)
         sb = 1.0_qp/(1.0_qp + k2*x*x)
         ra = x*x*sa
         rb = x*x*sb
         call add(2.0_qp*upper*rule%w(i)*sqrt(sa*sb), sa, sb)
      end do
      wrench(1) = -0.75_qp*ux*sums(1)
      wrench(2) = -0.75_qp*uy*sums(2)
      wrench(3) = -0.1875_qp*sums(6)
      ! U vanishes at l, so l is not differentiated; then degree zero and symmetry.
      jacobian(1, 1) = -0.75_qp*(sums(1) - 2.0_qp*ux*ux*sums(3))
      jacobian(1, 2) = 1.5_qp*ux*uy*sums(4)
      jacobian(2, 1) = jacobian(1, 2)
      jacobian(2, 2) = -0.75_qp*(sums(2) - 2.0_qp*uy*uy*sums(5))
      jacobian(1:2, 3) = -(ux*jacobian(1:2, 1) + uy*jacobian(1:2, 2))
      jacobian(3, 1:2) = jacobian(1:2, 3)
      jacobian(3, 3) = -(ux*jacobian(3, 1) + uy*jacobian(3, 2))
      jacobian = jacobian/w
      if (spin < 0.0_wp) then
         wrench(3) = -wrench(3)
         jacobian(1:2, 3) = -jacobian(1:2, 3)
         jacobian(3, 1:2) = -jacobian(3, 1:2)
      end if

   contains

      !> Add a node, whose 1/A and 1/B are `ra` and `rb`.
      subroutine add(measure, sa, sb)
         !> Weight times ds/D.
         real(qp), intent(in) :: measure
         !> s/A.
         real(qp), intent(in) :: sa
         !> s/B.
         real(qp), intent(in) :: sb
         real(qp) :: u

         u = 1.0_qp - uy*uy*ra - ux*ux*rb
         sums = sums + measure*[u*sb, u*sa, sb*rb, sb*ra, sa*ra, &
            k2*u*u*(ra + rb) + 4.0_qp*u*(ux*ux*sb*rb + k2*uy*uy*sa*ra)]
      end subroutine add

   end subroutine reference_wrench

   !> Root of the largest root l of uy^2/(1 + l) + ux^2/(k^2 + l) = 1, zero if the centre is inside.
   pure function begin_of(ux, uy, k2) result(lower)
      !> Centre about which the spot turns, in units of its major semi-axis.
      real(qp), intent(in) :: ux, uy
      !> Square of the axis ratio.
      real(qp), intent(in) :: k2
      real(qp) :: lower
      real(qp) :: s, root, product

      s = ux*ux + uy*uy - 1.0_qp - k2
      product = ux*ux + k2*uy*uy - k2
      lower = 0.0_qp
      if (product <= 0.0_qp) return
      root = sqrt(s*s + 4.0_qp*product)
      if (s >= 0.0_qp) then
         lower = sqrt(0.5_qp*(s + root))
      else
         lower = sqrt(2.0_qp*product/(root - s))
      end if
   end function begin_of

end module contensou_drivers_bench_reference
