!> Exact Contensou-Erismann wrench of the Hertz pressure on an elliptic spot, with its Jacobian and
!> its potential.
!>
!> In units f N and f N a, with W = a w, A = W^2 + s, B = k^2 W^2 + s, D = sqrt(s A B),
!> P = v_y^2/A, Q = v_x^2/B, U = 1 - P - Q, and l the largest root of U(s) = 0, or zero if the
!> rotation centre is inside the spot, integrals over s from l to infinity:
!>    F_x = -(3/4) v_x int U s/(B D),    F_y = -(3/4) v_y int U s/(A D),
!>    T = -(3/16) W int [k^2 W^2 U^2 (1/A + 1/B) + 4 U s (Q/B + k^2 P/A)]/D.
!> All integrands are positive and U vanishes at l, so the Jacobian is taken under the integral. For
!> l = 0 the integrals are complete and the force is a cubic, the torque a quartic polynomial of
!> u = v/W. In all other cases the integral is a sum of Gauss-Legendre rules, see
!> `centre_outside`. Derivation, accuracy and cost: docs/wrench.md.
!>
!> Near rest the wrench is regularised by W_e = sqrt(W^2 + d^2), d = k_x delta: F(v, W_e) and
!> T(v, W_e) W/W_e, which is minus the gradient of the convex potential Phi(v, W_e) and has the
!> slope 1/delta of the Coulomb law along the major axis.
module contensou_contact_wrench_exact
   use contensou_base_kinds, only : wp
   use contensou_contact_spot, only : spot_shape_type
   use contensou_contact_wrench_scaling, only : length, prepare, rescaled, scaled_type, &
      slip_type
   use contensou_special_quadrature, only : w_12, w_16, w_4, w_6, w_8, x_12, x_16, &
      x_4, x_6, x_8
   implicit none(type, external)
   private

   public :: wrench_exact, wrench_exact_bends, wrench_exact_jacobian, wrench_exact_potential

   !> Largest number of nodes of a rule.
   integer, parameter :: max_nodes = 16

   !> Nodes of a rule. What belongs to 1/A and 1/B is in the scale of the velocities.
   type :: nodes_type
      !> Number of nodes, even.
      integer :: n
      !> Weight times ds/D.
      real(wp) :: measure(max_nodes)
      real(wp) :: a(max_nodes)
      real(wp) :: b(max_nodes)
      !> s/A.
      real(wp) :: sa(max_nodes)
      !> s/B.
      real(wp) :: sb(max_nodes)
   end type nodes_type

   !> Number of sums over the nodes: those of F_x, F_y and T; s/B^2, s/(A B) and s/A^2 for the
   !> derivatives by the sliding velocity; and the derivatives by W of the integrals of F_x, F_y.
   integer, parameter :: force_sums = 2, wrench_sums = 3, sliding_sums = 6, all_sums = 8

   !> From these ratios sqrt(l)/W on the direct rule has 4, 6, 8, 12 nodes; below, 16.
   real(wp), parameter :: far_4 = 8.0_wp, far_6 = 2.25_wp, far_8 = 1.15_wp, far_12 = 0.45_wp

   !> Up to these ratios sqrt(l)/(k W) the rule at the rim has 4, 6 nodes; above, 8.
   real(wp), parameter :: near_4 = 0.22_wp, near_6 = 0.5_wp

   !> From this ratio sqrt(l)/W on the direct rule resolves a spot of any slenderness.
   real(wp), parameter :: tail_start = 0.25_wp

   !> Ratios of the ends of a panel that 12 and 16 nodes resolve.
   real(wp), parameter :: span_12 = 3.25_wp, span_16 = 6.5_wp

   !> Nodes of the full rules with 12 and 16 nodes on (-1, 1), and their weights.
   real(wp), parameter :: full_x_12(12) = [-x_6, x_6], full_w_12(12) = [w_6, w_6]
   real(wp), parameter :: full_x_16(16) = [-x_8, x_8], full_w_16(16) = [w_8, w_8]

   !> Upper end of t = tan(theta/2) for the direct rule that begins at `tail_start`.
   real(wp), parameter :: tail_tau = sqrt(1.0_wp + tail_start**2) - tail_start

   !> dtheta/dt at the nodes of this rule.
   real(wp), parameter :: tail_slope(16) = 2.0_wp/(1.0_wp + (tail_tau*x_16)**2)

   !> sin^2 theta and cos^2 theta of these nodes.
   real(wp), parameter :: tail_sine2(16) = (tail_slope*tail_tau*x_16)**2
   real(wp), parameter :: tail_cosine2(16) = (tail_slope - 1.0_wp)**2

   !> Their weights, times 2 dtheta.
   real(wp), parameter :: tail_weight(16) = 2.0_wp*tail_tau*w_16*tail_slope

contains

   !> The exact wrench.
   pure subroutine wrench_exact(shape, slip, with_torque, wrench)
      type(spot_shape_type), intent(in) :: shape
      type(slip_type), intent(in) :: slip
      logical, intent(in) :: with_torque
      real(wp), intent(out) :: wrench(3)
      real(wp) :: we, excess
      type(scaled_type) :: s

      call prepare(shape, slip, s)
      wrench = s%rest
      if (.not. s%moving) return
      we = s%w
      if (s%d > 0.0_wp) we = length(s%w, shape%slope_x*s%d)
      excess = s%x*s%x + shape%k2*((abs(s%y) - we)*(abs(s%y) + we))
      if (excess <= 0.0_wp) then
         call centre_inside(shape, s%x/we, s%y/we, with_torque, wrench(1), wrench(2), wrench(3))
         if (with_torque) wrench(3) = sign(1.0_wp, slip%spin)*wrench(3)*(s%w/we)
      else
         call centre_outside(shape, s, we, excess, with_torque, wrench)
         if (with_torque) wrench(3) = sign(s%w, slip%spin)*wrench(3)
      end if
   end subroutine wrench_exact

   !> The exact wrench and its derivatives.
   !>
   !> At rest without regularisation there is no derivative; wrench and Jacobian are then zero.
   !> Entries that would overflow are the largest number of the kind.
   pure subroutine wrench_exact_jacobian(shape, slip, wrench, jacobian)
      type(spot_shape_type), intent(in) :: shape
      type(slip_type), intent(in) :: slip
      real(wp), intent(out) :: wrench(3), jacobian(3, 3)
      real(wp) :: we, excess, torque_rate, ratio, inverse, ux, uy
      type(scaled_type) :: s

      call prepare(shape, slip, s)
      if (.not. s%moving .and. .not. s%d > 0.0_wp) then
         wrench = s%rest
         jacobian = s%rest
         return
      end if
      we = s%w
      if (s%d > 0.0_wp) we = length(s%w, shape%slope_x*s%d)
      excess = s%x*s%x + shape%k2*((abs(s%y) - we)*(abs(s%y) + we))
      if (excess <= 0.0_wp) then
         ! One division for all.
         inverse = 1.0_wp/we
         ux = s%x*inverse
         uy = s%y*inverse
         call centre_inside(shape, ux, uy, .true., wrench(1), wrench(2), wrench(3))
         call sliding_inside(shape, ux, uy, inverse, jacobian)
         call complete(ux, uy, jacobian)
         torque_rate = wrench(3)*inverse
      else
         call centre_outside(shape, s, we, excess, .true., wrench, jacobian)
         torque_rate = wrench(3)
      end if
      ratio = sign(1.0_wp, slip%spin)
      if (s%d > 0.0_wp) ratio = sign(s%w/we, slip%spin)
      wrench(3) = sign(s%w, slip%spin)*torque_rate
      jacobian(1:2, 3) = jacobian(1:2, 3)*ratio
      jacobian(3, 1:2) = jacobian(1:2, 3)
      if (s%d > 0.0_wp) then
         jacobian(3, 3) = jacobian(3, 3)*ratio**2 + torque_rate*(shape%slope_x*s%d/we)**2
      end if
      if (s%shift /= 0) jacobian = rescaled(jacobian, s%shift)
   end subroutine wrench_exact_jacobian

   !> The exact wrench of a motion of the size of one, not regularised, its derivatives, and the
   !> second derivatives of the force by the sliding velocity: F_x by xx, xy, yy, and F_y by yy.
   !>
   !> U vanishes at l, so the integrals of the Jacobian have them but for what their lower end adds.
   !> Those by W and of the torque follow from J V = 0.
   pure subroutine wrench_exact_bends(shape, x, y, w, wrench, jacobian, bends)
      type(spot_shape_type), intent(in) :: shape
      !> Sliding velocity along the axes, and W with its sign.
      real(wp), intent(in) :: x, y, w
      real(wp), intent(out) :: wrench(3), jacobian(3, 3), bends(4)
      real(wp) :: spin, excess, inverse, ux, uy
      type(scaled_type) :: s

      spin = abs(w)
      excess = x*x + shape%k2*((abs(y) - spin)*(abs(y) + spin))
      if (excess <= 0.0_wp) then
         inverse = 1.0_wp/spin
         ux = x*inverse
         uy = y*inverse
         call centre_inside(shape, ux, uy, .true., wrench(1), wrench(2), wrench(3))
         call sliding_inside(shape, ux, uy, inverse, jacobian)
         call complete(ux, uy, jacobian)
         call finish_bends(2.0_wp*[shape%j02, shape%j11, shape%j20], ux, uy, inverse, 1.0_wp, &
            1.0_wp, 0.0_wp, bends)
      else
         s%x = x
         s%y = y
         call centre_outside(shape, s, spin, excess, .true., wrench, jacobian, bends)
         wrench(3) = spin*wrench(3)
      end if
      if (w < 0.0_wp) then
         wrench(3) = -wrench(3)
         jacobian(1:2, 3) = -jacobian(1:2, 3)
         jacobian(3, 1:2) = -jacobian(3, 1:2)
      end if
   end subroutine wrench_exact_bends

   !> Dissipation potential Phi of the exact wrench: (F, T) = -grad Phi(vx, vy, W), zero at rest.
   !>
   !> Without regularisation it is the power -(F.v + T W). With it, Phi(v, W_e) - k_T d.
   pure function wrench_exact_potential(shape, slip) result(potential)
      type(spot_shape_type), intent(in) :: shape
      type(slip_type), intent(in) :: slip
      !> The potential, in units of f N m/s.
      real(wp) :: potential
      real(wp) :: d, we, excess, wrench(3), ux2, uy2
      type(scaled_type) :: s

      call prepare(shape, slip, s)
      potential = s%rest
      if (.not. s%moving) return
      d = shape%slope_x*s%d
      we = s%w
      if (d > 0.0_wp) we = length(s%w, d)
      excess = s%x*s%x + shape%k2*((abs(s%y) - we)*(abs(s%y) + we))
      if (excess <= 0.0_wp) then
         ux2 = (s%x/we)**2
         uy2 = (s%y/we)**2
         potential = shape%torque*s%w*(s%w/(we + d)) + 0.75_wp*we*( &
            ux2*(shape%d_integral - shape%j11*uy2 - 0.5_wp*shape%j02*ux2) &
            + uy2*(shape%b_integral - 0.5_wp*shape%j20*uy2))
      else
         call centre_outside(shape, s, we, excess, .true., wrench)
         potential = -(s%x*wrench(1) + s%y*wrench(2)) - we*we*wrench(3) - shape%torque*d
      end if
      if (s%shift /= 0) potential = rescaled(potential, -s%shift)
   end function wrench_exact_potential

   !> Wrench for a positive spin with the rotation centre inside the spot; near it, outside, this is
   !> the complete part of the integral.
   pure subroutine centre_inside(shape, ux, uy, with_torque, fx, fy, torque)
      type(spot_shape_type), intent(in) :: shape
      !> Sliding velocity along the major axis over the spin velocity.
      real(wp), intent(in) :: ux
      !> Sliding velocity along the minor axis over the spin velocity.
      real(wp), intent(in) :: uy
      !> Whether the torque is wanted.
      logical, intent(in) :: with_torque
      !> Force along the major and the minor axis, in units of f N.
      real(wp), intent(out) :: fx, fy
      !> Torque about the normal, in units of f N a.
      real(wp), intent(out) :: torque
      real(wp) :: ux2, p, q, u

      p = uy*uy
      ux2 = ux*ux
      fx = -1.5_wp*ux*(shape%d_integral - shape%j11*p - shape%j02*ux2)
      fy = -1.5_wp*uy*(shape%b_integral - shape%j20*p - shape%j11*ux2)
      torque = 0.0_wp
      if (.not. with_torque) return
      q = ux2*shape%inverse_k2
      u = 1.0_wp - p - q
      torque = -0.375_wp*(u*(shape%e_integral*u &
         + 2.0_wp*(shape%k2*shape%d_integral*p + shape%b_integral*q)) &
         + 3.0_wp*(shape%k2*p*(shape%j20*p + 2.0_wp*shape%j11*q) + shape%j20*q*q))
   end subroutine centre_inside

   !> Derivatives by the sliding velocity of the force of `centre_inside`.
   pure subroutine sliding_inside(shape, ux, uy, scale, jacobian)
      type(spot_shape_type), intent(in) :: shape
      !> Sliding velocity along the major axis over the spin velocity.
      real(wp), intent(in) :: ux
      !> Sliding velocity along the minor axis over the spin velocity.
      real(wp), intent(in) :: uy
      !> Inverse of the spin velocity.
      real(wp), intent(in) :: scale
      !> The Jacobian; its last row and column are left alone.
      real(wp), intent(inout) :: jacobian(3, 3)
      real(wp) :: ux2, uy2

      ux2 = ux*ux
      uy2 = uy*uy
      jacobian(1, 1) = -1.5_wp*scale*(shape%d_integral - shape%j11*uy2 - 3.0_wp*shape%j02*ux2)
      jacobian(2, 2) = -1.5_wp*scale*(shape%b_integral - 3.0_wp*shape%j20*uy2 - shape%j11*ux2)
      jacobian(1, 2) = 3.0_wp*scale*shape%j11*ux*uy
      jacobian(2, 1) = jacobian(1, 2)
   end subroutine sliding_inside

   !> Wrench, and Jacobian if it is asked for, for a spin >= 0 with the rotation centre outside the
   !> spot, by one of three sums, all of whose terms are positive. With rho = sqrt(l)/W:
   !>
   !> - rho > k and rho > 1/4: s = W^2 cot^2 theta, t = tan(theta/2) from 0 to 1/(rho +
   !>   sqrt(1 + rho^2)); the integrand is even in t, its singularities are t = +-i and those where
   !>   cot theta = +-i k;
   !> - rho <= k: the complete integrals minus those from 0 to l with s = (k W tan theta)^2 and
   !>   t = tan(theta/2), even as well;
   !> - between (slender spots near the rim): the first rule from rho = 1/4 on, and below panels in
   !>   rho with a fractional linear map that keeps the singularities +-i k away.
   pure subroutine centre_outside(shape, slip, w, excess, with_torque, wrench, jacobian, bends)
      type(spot_shape_type), intent(in) :: shape
      !> Its sliding velocity x, y.
      type(scaled_type), intent(in) :: slip
      !> Regularised spin velocity, >= 0.
      real(wp), intent(in) :: w
      !> x^2 + k^2 (y^2 - w^2), > 0.
      real(wp), intent(in) :: excess
      !> Whether the torque is wanted; it must be if the Jacobian is.
      logical, intent(in) :: with_torque
      !> Force along the major and the minor axis, in units of f N, and torque over
      !> the spin velocity.
      real(wp), intent(out) :: wrench(3)
      !> Derivatives.
      real(wp), intent(out), optional :: jacobian(3, 3)
      !> As of `wrench_exact_bends`.
      real(wp), intent(out), optional :: bends(4)
      real(wp) :: s, root, l, h, px, py, tau, sums(all_sums), near_rim(3), inside(3, 3)
      type(nodes_type) :: nodes
      integer :: n_sums
      logical :: with_jacobian

      with_jacobian = present(jacobian)
      n_sums = merge(wrench_sums, force_sums, with_torque)
      if (with_jacobian) n_sums = sliding_sums
      sums = 0.0_wp
      ! The largest root of x^2/(k^2 w^2 + l) + y^2/(w^2 + l) = 1: the ellipse through the rotation
      ! centre confocal with the spot.
      s = slip%x*slip%x + (abs(slip%y) - w)*(abs(slip%y) + w) - shape%k2*w*w
      root = sqrt(s*s + 4.0_wp*w*w*excess)
      if (s >= 0.0_wp) then
         l = 0.5_wp*(s + root)
      else
         l = 2.0_wp*w*w*excess/(root - s)
      end if
      root = sqrt(l)
      if (root > tail_start*w .and. root > shape%k*w) then
         h = 1.0_wp/(root + sqrt(l + w*w))
         px = slip%x*h
         py = slip%y*h
         tau = w*h
         call direct_nodes(shape%k2, tau, root, w, nodes)
         ! Where W is small compared with v, J V = 0 does not give the derivatives by W.
         if (with_jacobian .and. root > far_8*w) n_sums = all_sums
         call add(nodes, shape%k2, px*px, py*py, tau*tau, n_sums, sums)
         call finish_wrench(sums, px, py, h, wrench)
         if (.not. with_jacobian) return
         call finish_sliding(sums, px, py, h, jacobian)
         if (present(bends)) then
            s = root*h
            l = s*s
            call finish_bends(sums(4:6), px, py, h, l + tau*tau, l + shape%k2*tau*tau, s, bends)
         end if
         if (n_sums < all_sums) then
            call complete(slip%x/w, slip%y/w, jacobian)
            return
         end if
         jacobian(1, 3) = -0.75_wp*h*px*tau*sums(7)
         jacobian(2, 3) = -0.75_wp*h*py*tau*sums(8)
         jacobian(3, 3) = 0.75_wp*h*(px*px*sums(7) + py*py*sums(8))
         jacobian(3, 1) = jacobian(1, 3)
         jacobian(3, 2) = jacobian(2, 3)
         return
      end if

      h = 1.0_wp/w
      px = slip%x*h
      py = slip%y*h
      root = root*h
      if (root <= shape%k) then
         call rim_nodes(shape, root, nodes)
         call add(nodes, shape%k2, px*px, py*py, 1.0_wp, n_sums, sums)
         call finish_wrench(sums, px, py, h, near_rim)
         call centre_inside(shape, px, py, with_torque, wrench(1), wrench(2), wrench(3))
         wrench(1:2) = wrench(1:2) - near_rim(1:2)
         wrench(3) = wrench(3)*h - near_rim(3)
      else
         call tail_nodes(shape%k2, nodes)
         call add(nodes, shape%k2, px*px, py*py, 1.0_wp, n_sums, sums)
         s = tail_start
         do while (s > root)
            l = s
            s = max(root, l*(1.0_wp/span_16))
            call panel_nodes(shape%k2, s, l, nodes)
            call add(nodes, shape%k2, px*px, py*py, 1.0_wp, n_sums, sums)
         end do
         call finish_wrench(sums, px, py, h, wrench)
      end if
      if (.not. with_jacobian) return
      call finish_sliding(sums, px, py, h, jacobian)
      if (root <= shape%k) then
         call sliding_inside(shape, px, py, h, inside)
         jacobian(1:2, 1:2) = inside(1:2, 1:2) - jacobian(1:2, 1:2)
         if (present(bends)) sums(4:6) = 2.0_wp*[shape%j02, shape%j11, shape%j20] - sums(4:6)
      end if
      if (present(bends)) call finish_bends(sums(4:6), px, py, h, 1.0_wp + root*root, &
         shape%k2 + root*root, root, bends)
      call complete(px, py, jacobian)
   end subroutine centre_outside

   !> Nodes of the direct rule.
   pure subroutine direct_nodes(k2, tau, root, w, nodes)
      !> Square of the axis ratio.
      real(wp), intent(in) :: k2
      !> Upper end of the integral over t.
      real(wp), intent(in) :: tau
      !> Square root of l.
      real(wp), intent(in) :: root
      !> Spin velocity.
      real(wp), intent(in) :: w
      type(nodes_type), intent(out) :: nodes

      if (root > far_4*w) then
         call fill_direct(4, x_4, w_4, k2, tau, nodes)
      else if (root > far_6*w) then
         call fill_direct(6, x_6, w_6, k2, tau, nodes)
      else if (root > far_8*w) then
         call fill_direct(8, x_8, w_8, k2, tau, nodes)
      else if (root > far_12*w) then
         call fill_direct(12, x_12, w_12, k2, tau, nodes)
      else
         call fill_direct(16, x_16, w_16, k2, tau, nodes)
      end if
   end subroutine direct_nodes

   !> Nodes of the direct rule with a given rule.
   pure subroutine fill_direct(n, x, weights, k2, tau, nodes)
      !> Number of nodes.
      integer, intent(in) :: n
      !> Positive nodes of a Gauss-Legendre rule.
      real(wp), intent(in) :: x(n)
      real(wp), intent(in) :: weights(n)
      !> Square of the axis ratio.
      real(wp), intent(in) :: k2
      !> Upper end of the integral over t.
      real(wp), intent(in) :: tau
      type(nodes_type), intent(out) :: nodes
      real(wp) :: x2, t2, e2, n2, r2, q, f
      integer :: i

      nodes%n = n
      do i = 1, n
         x2 = 4.0_wp*x(i)*x(i)
         t2 = tau*tau*x2
         e2 = (1.0_wp + 0.25_wp*t2)**2
         n2 = (1.0_wp - 0.25_wp*t2)**2
         r2 = n2 + k2*t2
         q = 1.0_wp/(e2*sqrt(r2))
         f = e2*q*q
         nodes%measure(i) = 4.0_wp*weights(i)*(q*e2)
         nodes%a(i) = x2*(f*r2)
         nodes%b(i) = x2*(f*e2)
         nodes%sa(i) = n2*(f*r2)
         nodes%sb(i) = n2*(f*e2)
      end do
   end subroutine fill_direct

   !> Nodes of the rule from the rim to l.
   pure subroutine rim_nodes(shape, root, nodes)
      type(spot_shape_type), intent(in) :: shape
      !> Square root of l over the spin velocity, at most k.
      real(wp), intent(in) :: root
      type(nodes_type), intent(out) :: nodes
      real(wp) :: tangent, tau

      tangent = root/shape%k
      tau = tangent/(1.0_wp + sqrt(1.0_wp + tangent*tangent))
      if (tangent <= near_4) then
         call fill_rim(4, x_4, w_4, shape, tau, nodes)
      else if (tangent <= near_6) then
         call fill_rim(6, x_6, w_6, shape, tau, nodes)
      else
         call fill_rim(8, x_8, w_8, shape, tau, nodes)
      end if
   end subroutine rim_nodes

   !> Nodes of the rule from the rim to l with a given rule.
   pure subroutine fill_rim(n, x, weights, shape, tau, nodes)
      !> Number of nodes.
      integer, intent(in) :: n
      !> Positive nodes of a Gauss-Legendre rule.
      real(wp), intent(in) :: x(n)
      real(wp), intent(in) :: weights(n)
      type(spot_shape_type), intent(in) :: shape
      !> Upper end of the integral over t.
      real(wp), intent(in) :: tau
      type(nodes_type), intent(out) :: nodes
      real(wp) :: t2, e2, n2, r2, q, f
      integer :: i

      nodes%n = n
      do i = 1, n
         t2 = 4.0_wp*(tau*x(i))**2
         e2 = (1.0_wp + 0.25_wp*t2)**2
         n2 = (1.0_wp - 0.25_wp*t2)**2
         r2 = n2 + shape%k2*t2
         q = 1.0_wp/(e2*sqrt(r2))
         f = e2*q*q
         nodes%measure(i) = 4.0_wp*tau*weights(i)*(q*e2)
         nodes%a(i) = n2*(f*e2)
         nodes%b(i) = shape%inverse_k2*n2*(f*r2)
         nodes%sa(i) = shape%k2*t2*(f*e2)
         nodes%sb(i) = t2*(f*r2)
      end do
   end subroutine fill_rim

   !> Nodes of the direct rule that begins at sqrt(l)/W = `tail_start`, for a unit spin velocity.
   pure subroutine tail_nodes(k2, nodes)
      !> Square of the axis ratio.
      real(wp), intent(in) :: k2
      type(nodes_type), intent(out) :: nodes
      real(wp) :: f
      integer :: i

      nodes%n = size(tail_sine2)
      do i = 1, size(tail_sine2)
         f = 1.0_wp/sqrt(tail_cosine2(i) + k2*tail_sine2(i))
         nodes%measure(i) = tail_weight(i)*f
         f = f*f
         nodes%a(i) = tail_sine2(i)
         nodes%b(i) = tail_sine2(i)*f
         nodes%sa(i) = tail_cosine2(i)
         nodes%sb(i) = tail_cosine2(i)*f
      end do
   end subroutine tail_nodes

   !> Nodes of a panel in rho = sqrt(s)/W from `low` to `high`, for a unit spin velocity.
   pure subroutine panel_nodes(k2, low, high, nodes)
      !> Square of the axis ratio.
      real(wp), intent(in) :: k2
      !> Lower end, > 0.
      real(wp), intent(in) :: low
      !> Upper end.
      real(wp), intent(in) :: high
      type(nodes_type), intent(out) :: nodes
      real(wp) :: root_low, root_high, slope

      root_low = sqrt(low)
      root_high = sqrt(high)
      slope = (root_high - root_low)/(root_high + root_low)
      if (high <= span_12*low) then
         call fill_panel(12, full_x_12, full_w_12, k2, low*high, root_low*root_high*slope, slope, &
            nodes)
      else
         call fill_panel(16, full_x_16, full_w_16, k2, low*high, root_low*root_high*slope, slope, &
            nodes)
      end if
   end subroutine panel_nodes

   !> Nodes of a panel with a given rule.
   pure subroutine fill_panel(n, x, weights, k2, centre2, factor, slope, nodes)
      !> Number of nodes.
      integer, intent(in) :: n
      !> Nodes of a Gauss-Legendre rule on (-1, 1).
      real(wp), intent(in) :: x(n)
      real(wp), intent(in) :: weights(n)
      !> Square of the axis ratio.
      real(wp), intent(in) :: k2
      !> Square of rho at the centre of the map.
      real(wp), intent(in) :: centre2
      !> rho at the centre times `slope`.
      real(wp), intent(in) :: factor
      !> Slope of the fractional linear map rho = centre (1 + slope x)/(1 - slope x).
      real(wp), intent(in) :: slope
      type(nodes_type), intent(out) :: nodes
      real(wp) :: r2, m2, a, b, q
      integer :: i

      nodes%n = n
      do i = 1, n
         r2 = centre2*(1.0_wp + slope*x(i))**2
         m2 = (1.0_wp - slope*x(i))**2
         a = m2 + r2
         b = k2*m2 + r2
         q = 1.0_wp/sqrt(a*b)
         nodes%measure(i) = 4.0_wp*factor*weights(i)*q
         q = q*q
         nodes%a(i) = m2*b*q
         nodes%b(i) = m2*a*q
         nodes%sa(i) = r2*b*q
         nodes%sb(i) = r2*a*q
      end do
   end subroutine fill_panel

   !> Add the sums over the nodes of a rule.
   pure subroutine add(nodes, k2, px2, py2, tau2, n_sums, sums)
      type(nodes_type), intent(in) :: nodes
      !> Square of the axis ratio.
      real(wp), intent(in) :: k2
      !> Square of the scaled sliding velocity along the major axis.
      real(wp), intent(in) :: px2
      !> Square of the scaled sliding velocity along the minor axis.
      real(wp), intent(in) :: py2
      !> Square of the scaled spin velocity.
      real(wp), intent(in) :: tau2
      !> Number of sums that are wanted.
      integer, intent(in) :: n_sums
      real(wp), intent(inout) :: sums(n_sums)
      real(wp) :: terms(max_nodes, all_sums), p, q, u, g
      integer :: i

      associate (n => nodes%n, m => nodes%measure, a => nodes%a, b => nodes%b, sa => nodes%sa, &
         sb => nodes%sb)
         if (n_sums == force_sums) then
            do i = 1, n
               g = m(i)*(1.0_wp - py2*a(i) - px2*b(i))
               terms(i, 1) = g*sb(i)
               terms(i, 2) = g*sa(i)
            end do
         else
            do i = 1, n
               p = py2*a(i)
               q = px2*b(i)
               u = 1.0_wp - p - q
               g = m(i)*u
               terms(i, 1) = g*sb(i)
               terms(i, 2) = g*sa(i)
               terms(i, 3) = g*(k2*tau2*u*(a(i) + b(i)) + 4.0_wp*(q*sb(i) + k2*p*sa(i)))
            end do
         end if
         if (n_sums == sliding_sums) then
            do i = 1, n
               terms(i, 4) = m(i)*sb(i)*b(i)
               terms(i, 5) = m(i)*sb(i)*a(i)
               terms(i, 6) = m(i)*sa(i)*a(i)
            end do
         else if (n_sums == all_sums) then
            do i = 1, n
               p = py2*a(i)
               q = px2*b(i)
               u = 1.0_wp - p - q
               g = 2.0_wp*(p*a(i) + k2*q*b(i))
               terms(i, 4) = m(i)*sb(i)*b(i)
               terms(i, 5) = m(i)*sb(i)*a(i)
               terms(i, 6) = m(i)*sa(i)*a(i)
               terms(i, 7) = m(i)*sb(i)*(g - u*(a(i) + 3.0_wp*k2*b(i)))
               terms(i, 8) = m(i)*sa(i)*(g - u*(3.0_wp*a(i) + k2*b(i)))
            end do
         end if
         call add_terms(n, n_sums, terms, sums)
      end associate
   end subroutine add

   !> Add up the terms of each sum, the odd and the even ones apart (two at a time in a register).
   pure subroutine add_terms(n, n_sums, terms, sums)
      !> Number of terms, even.
      integer, intent(in) :: n
      integer, intent(in) :: n_sums
      real(wp), intent(in) :: terms(max_nodes, n_sums)
      real(wp), intent(inout) :: sums(n_sums)
      real(wp) :: pair(2)
      integer :: i, j

      do j = 1, n_sums
         pair = 0.0_wp
         do i = 1, n, 2
            pair = pair + terms(i:i + 1, j)
         end do
         sums(j) = sums(j) + (pair(1) + pair(2))
      end do
   end subroutine add_terms

   !> The sums over the nodes, brought to the units of the wrench.
   pure subroutine finish_wrench(sums, px, py, scale, wrench)
      real(wp), intent(in) :: sums(wrench_sums)
      !> Scaled sliding velocity along the major axis.
      real(wp), intent(in) :: px
      !> Scaled sliding velocity along the minor axis.
      real(wp), intent(in) :: py
      !> Scale of the velocities.
      real(wp), intent(in) :: scale
      !> Force along the major and the minor axis, in units of f N, and torque over
      !> the spin velocity.
      real(wp), intent(out) :: wrench(3)

      wrench(1) = -0.75_wp*px*sums(1)
      wrench(2) = -0.75_wp*py*sums(2)
      wrench(3) = -0.1875_wp*scale*sums(3)
   end subroutine finish_wrench

   !> Derivatives of the force by the sliding velocity from the sums.
   pure subroutine finish_sliding(sums, px, py, scale, jacobian)
      real(wp), intent(in) :: sums(sliding_sums)
      !> Scaled sliding velocity along the major axis.
      real(wp), intent(in) :: px
      !> Scaled sliding velocity along the minor axis.
      real(wp), intent(in) :: py
      !> Scale of the velocities.
      real(wp), intent(in) :: scale
      !> The Jacobian; its last row and column are left alone.
      real(wp), intent(inout) :: jacobian(3, 3)

      jacobian(1, 1) = scale*(1.5_wp*px*px*sums(4) - 0.75_wp*sums(1))
      jacobian(2, 2) = scale*(1.5_wp*py*py*sums(6) - 0.75_wp*sums(2))
      jacobian(1, 2) = scale*1.5_wp*px*py*sums(5)
      jacobian(2, 1) = jacobian(1, 2)
   end subroutine finish_sliding

   !> Second derivatives of the force by the sliding velocity.
   pure subroutine finish_bends(sums, px, py, scale, a, b, root, bends)
      !> Integrals of s/B^2, s/(A B) and s/A^2.
      real(wp), intent(in) :: sums(3)
      !> Scaled sliding velocity along the axes.
      real(wp), intent(in) :: px, py
      !> Scale of the velocities.
      real(wp), intent(in) :: scale
      !> A, B and sqrt(s) at the lower end of the integrals.
      real(wp), intent(in) :: a, b, root
      real(wp), intent(out) :: bends(4)
      real(wp) :: x, y, ends, rate

      rate = scale*scale
      bends(1) = 4.5_wp*px*sums(1)
      bends(2) = 1.5_wp*py*sums(2)
      bends(3) = 1.5_wp*px*sums(2)
      bends(4) = 4.5_wp*py*sums(3)
      if (root > 0.0_wp) then
         ! l changes by -U_v/U_s.
         x = px/b
         y = py/a
         ends = 3.0_wp*root/(sqrt(a*b)*(x*x + y*y))
         bends(1) = bends(1) - ends*x*x*x
         bends(2) = bends(2) - ends*x*x*y
         bends(3) = bends(3) - ends*x*y*y
         bends(4) = bends(4) - ends*y*y*y
      end if
      bends = rate*bends
   end subroutine finish_bends

   !> Last row and column of the Jacobian from J V = 0, for a spin velocity that is not small.
   pure subroutine complete(ux, uy, jacobian)
      !> Sliding velocity along the major axis over the spin velocity.
      real(wp), intent(in) :: ux
      !> Sliding velocity along the minor axis over the spin velocity.
      real(wp), intent(in) :: uy
      real(wp), intent(inout) :: jacobian(3, 3)

      jacobian(1, 3) = -(jacobian(1, 1)*ux + jacobian(1, 2)*uy)
      jacobian(2, 3) = -(jacobian(2, 1)*ux + jacobian(2, 2)*uy)
      jacobian(3, 3) = -(jacobian(1, 3)*ux + jacobian(2, 3)*uy)
      jacobian(3, 1) = jacobian(1, 3)
      jacobian(3, 2) = jacobian(2, 3)
   end subroutine complete

end module contensou_contact_wrench_exact
