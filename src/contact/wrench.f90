!> Friction wrench of a spot that slides and spins: the rungs of the Contensou-Erismann ladder.
!>
!> On the spot x^2/a^2 + y^2/b^2 <= 1 with the Hertz pressure s and the slip velocity
!> v_M = (v_x - w y, v_y + w x) the wrench on the body that slips is
!>    F = -f \int s v_M/|v_M| dA,    T = -f \int s r x v_M/|v_M| dA.
!> Every kernel here returns it in units of f N (force) and f N a (torque) as a function that is
!> homogeneous of degree zero in the sliding velocity (vx, vy) and the spin velocity W = a w, so
!> that pure sliding, pure spinning and everything between need no special case.
!> The wrench of v = W = 0 is zero. Outside the domain (NaN or infinite velocity) it is NaN.
!>
!> Sources: I. Kosenko, E. Aleksandrov, Proc. 7th Modelica Conference, Como 2009, 288-298 (the
!> simplified model); V. Ph. Zhuravlev, J. Appl. Math. Mech. 62 (1998) 705 (Pade models); the exact
!> integrals are reduced in docs/wrench.md.
module contensou_contact_wrench
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite, ieee_quiet_nan, ieee_value
   use contensou_base_kinds, only : wp
   use contensou_contact_spot, only : spot_shape_type
   use contensou_special_quadrature, only : w_16, w_4, w_8, x_16, x_4, x_8
   implicit none(type, external)
   private

   public :: wrench_kernel, wrench_coulomb, wrench_simplified, wrench_pade11, wrench_pade22
   public :: wrench_exact

   abstract interface
      !> Dimensionless friction wrench.
      pure subroutine wrench_kernel(shape, vx, vy, spin, delta, with_torque, fx, fy, torque)
         import :: spot_shape_type, wp
         implicit none(type, external)
         !> Shape of the spot.
         type(spot_shape_type), intent(in) :: shape
         !> Sliding velocity of the centre along the major axis [m/s].
         real(wp), intent(in) :: vx
         !> Sliding velocity of the centre along the minor axis [m/s].
         real(wp), intent(in) :: vy
         !> Spin velocity at the end of the major axis, W = a w [m/s], with the sign of w.
         real(wp), intent(in) :: spin
         !> Regularisation velocity [m/s], >= 0.
         real(wp), intent(in) :: delta
         !> Whether the torque is wanted; otherwise it is zero and costs nothing.
         logical, intent(in) :: with_torque
         !> Force along the major axis, in units of f N.
         real(wp), intent(out) :: fx
         !> Force along the minor axis, in units of f N.
         real(wp), intent(out) :: fy
         !> Torque about the normal, in units of f N a.
         real(wp), intent(out) :: torque
      end subroutine wrench_kernel
   end interface

   !> Velocities between these bounds can be squared and multiplied without rescaling.
   real(wp), parameter :: smallest_plain = 1.0e-60_wp, largest_plain = 1.0e60_wp

contains

   !> Regularised Amontons-Coulomb law: force min(|v|/delta, 1) against v, no torque.
   pure subroutine wrench_coulomb(shape, vx, vy, spin, delta, with_torque, fx, fy, torque)
      !> Shape of the spot.
      type(spot_shape_type), intent(in) :: shape
      !> Sliding velocity of the centre along the major axis [m/s].
      real(wp), intent(in) :: vx
      !> Sliding velocity of the centre along the minor axis [m/s].
      real(wp), intent(in) :: vy
      !> Spin velocity W = a w [m/s], with the sign of w.
      real(wp), intent(in) :: spin
      !> Regularisation velocity [m/s], >= 0.
      real(wp), intent(in) :: delta
      !> Whether the torque is wanted.
      logical, intent(in) :: with_torque
      !> Force along the major axis, in units of f N.
      real(wp), intent(out) :: fx
      !> Force along the minor axis, in units of f N.
      real(wp), intent(out) :: fy
      !> Torque about the normal, in units of f N a.
      real(wp), intent(out) :: torque
      real(wp) :: x, y, w, d, v
      logical :: moving

      call prepare(vx, vy, spin, delta, x, y, w, d, moving, fx, fy, torque)
      if (.not. moving) return
      v = max(length(x, y), d)
      if (v <= 0.0_wp) return
      fx = -x/v
      fy = -y/v
   end subroutine wrench_coulomb

   !> The simplified Contensou model of Kosenko and Aleksandrov (2009).
   !>
   !> Force linear in u = v/(a |w|) up to u* = 1/k_x (1/k_y across), constant beyond; torque k_T up
   !> to T1/k_T, then T1/u, with T1 = (cos^2 psi + k^2 sin^2 psi)/5 for sliding in direction psi.
   !> Where u* a |w| < delta, the force is the regularised Coulomb law and the torque fades
   !> linearly to zero with w, so that the wrench is continuous.
   pure subroutine wrench_simplified(shape, vx, vy, spin, delta, with_torque, fx, fy, torque)
      !> Shape of the spot.
      type(spot_shape_type), intent(in) :: shape
      !> Sliding velocity of the centre along the major axis [m/s].
      real(wp), intent(in) :: vx
      !> Sliding velocity of the centre along the minor axis [m/s].
      real(wp), intent(in) :: vy
      !> Spin velocity W = a w [m/s], with the sign of w.
      real(wp), intent(in) :: spin
      !> Regularisation velocity [m/s], >= 0.
      real(wp), intent(in) :: delta
      !> Whether the torque is wanted.
      logical, intent(in) :: with_torque
      !> Force along the major axis, in units of f N.
      real(wp), intent(out) :: fx
      !> Force along the minor axis, in units of f N.
      real(wp), intent(out) :: fy
      !> Torque about the normal, in units of f N a.
      real(wp), intent(out) :: torque
      real(wp) :: x, y, w, d, v, t1, fade
      logical :: moving

      call prepare(vx, vy, spin, delta, x, y, w, d, moving, fx, fy, torque)
      if (.not. moving) return
      v = length(x, y)
      if (v > 0.0_wp) then
         fx = -x/max(v, w/shape%slope_x, d)
         fy = -y/max(v, w/shape%slope_y, d)
      end if
      if (.not. with_torque) return
      t1 = far_torque(shape, x, y, v)
      if (shape%torque*v <= t1*w) then
         torque = shape%torque
      else
         torque = t1*w/v
      end if
      fade = min(shape%slope_x, shape%slope_y)*d
      if (w < fade) torque = torque*w/fade
      torque = -sign(torque, spin)
   end subroutine wrench_simplified

   !> Pade approximation with one term at rest and one at infinity:
   !> F = k u/(1 + k u), T = k_T T1/(T1 + k_T u).
   pure subroutine wrench_pade11(shape, vx, vy, spin, delta, with_torque, fx, fy, torque)
      !> Shape of the spot.
      type(spot_shape_type), intent(in) :: shape
      !> Sliding velocity of the centre along the major axis [m/s].
      real(wp), intent(in) :: vx
      !> Sliding velocity of the centre along the minor axis [m/s].
      real(wp), intent(in) :: vy
      !> Spin velocity W = a w [m/s], with the sign of w.
      real(wp), intent(in) :: spin
      !> Regularisation velocity [m/s], >= 0.
      real(wp), intent(in) :: delta
      !> Whether the torque is wanted.
      logical, intent(in) :: with_torque
      !> Force along the major axis, in units of f N.
      real(wp), intent(out) :: fx
      !> Force along the minor axis, in units of f N.
      real(wp), intent(out) :: fy
      !> Torque about the normal, in units of f N a.
      real(wp), intent(out) :: torque
      real(wp) :: x, y, w, d, v, t1, we
      logical :: moving

      call prepare(vx, vy, spin, delta, x, y, w, d, moving, fx, fy, torque)
      if (.not. moving) return
      v = length(x, y)
      we = length(w, shape%slope_x*d)
      if (v > 0.0_wp) then
         fx = -x*(shape%slope_x/(we + shape%slope_x*v))
         fy = -y*(shape%slope_y/(we + shape%slope_y*v))
      end if
      if (.not. with_torque .or. w <= 0.0_wp) return
      t1 = far_torque(shape, x, y, v)
      torque = -sign(w*shape%torque*t1/(t1*we + shape%torque*v), spin)
   end subroutine wrench_pade11

   !> Pade approximation with two terms at rest and two at infinity:
   !> F = (k u + k^2 u^2)/(1 + k u + k^2 u^2), T = k_T (1 + m u)/(1 + m u + m^2 u^2), m = k_T/T1.
   !>
   !> At rest the second terms are zero (F is odd and T even in u), at infinity too.
   pure subroutine wrench_pade22(shape, vx, vy, spin, delta, with_torque, fx, fy, torque)
      !> Shape of the spot.
      type(spot_shape_type), intent(in) :: shape
      !> Sliding velocity of the centre along the major axis [m/s].
      real(wp), intent(in) :: vx
      !> Sliding velocity of the centre along the minor axis [m/s].
      real(wp), intent(in) :: vy
      !> Spin velocity W = a w [m/s], with the sign of w.
      real(wp), intent(in) :: spin
      !> Regularisation velocity [m/s], >= 0.
      real(wp), intent(in) :: delta
      !> Whether the torque is wanted.
      logical, intent(in) :: with_torque
      !> Force along the major axis, in units of f N.
      real(wp), intent(out) :: fx
      !> Force along the minor axis, in units of f N.
      real(wp), intent(out) :: fy
      !> Torque about the normal, in units of f N a.
      real(wp), intent(out) :: torque
      real(wp) :: x, y, w, d, v, t1, we
      logical :: moving

      call prepare(vx, vy, spin, delta, x, y, w, d, moving, fx, fy, torque)
      if (.not. moving) return
      v = length(x, y)
      we = length(w, shape%slope_x*d)
      if (v > 0.0_wp) then
         fx = -x*pade22_force(shape%slope_x, v, we)
         fy = -y*pade22_force(shape%slope_y, v, we)
      end if
      if (.not. with_torque .or. w <= 0.0_wp) return
      t1 = far_torque(shape, x, y, v)*we
      torque = shape%torque*v
      torque = shape%torque*t1*(t1 + torque)/(t1*t1 + t1*torque + torque*torque)
      torque = -sign(torque*(w/we), spin)
   end subroutine wrench_pade22

   !> The exact Contensou-Erismann wrench of the Hertz pressure.
   !>
   !> With the rotation centre inside the spot it is a cubic (force) and a quartic (torque)
   !> polynomial of u, outside an integral of a smooth even positive function, taken by
   !> Gauss-Legendre with 4, 8 or 16 nodes. Absolute accuracy 1e-15 for k > 0.5. Regularised by
   !> W_e = sqrt(W^2 + d^2), d = k_x delta: F(v, W_e) and T(v, W_e) W/W_e, still minus the gradient
   !> of a convex potential and with the slope 1/delta of the Coulomb law.
   pure subroutine wrench_exact(shape, vx, vy, spin, delta, with_torque, fx, fy, torque)
      !> Shape of the spot.
      type(spot_shape_type), intent(in) :: shape
      !> Sliding velocity of the centre along the major axis [m/s].
      real(wp), intent(in) :: vx
      !> Sliding velocity of the centre along the minor axis [m/s].
      real(wp), intent(in) :: vy
      !> Spin velocity W = a w [m/s], with the sign of w.
      real(wp), intent(in) :: spin
      !> Regularisation velocity [m/s], >= 0.
      real(wp), intent(in) :: delta
      !> Whether the torque is wanted.
      logical, intent(in) :: with_torque
      !> Force along the major axis, in units of f N.
      real(wp), intent(out) :: fx
      !> Force along the minor axis, in units of f N.
      real(wp), intent(out) :: fy
      !> Torque about the normal, in units of f N a.
      real(wp), intent(out) :: torque
      real(wp) :: x, y, w, d, we
      logical :: moving

      call prepare(vx, vy, spin, delta, x, y, w, d, moving, fx, fy, torque)
      if (.not. moving) return
      we = w
      if (d > 0.0_wp) we = length(w, shape%slope_x*d)
      if (x*x + shape%k2*y*y <= shape%k2*we*we) then
         if (we <= 0.0_wp) return
         call centre_inside(shape, x/we, y/we, with_torque, fx, fy, torque)
      else
         call centre_outside(shape, x, y, we, with_torque, fx, fy, torque)
      end if
      if (d > 0.0_wp .and. we > 0.0_wp) torque = torque*(w/we)
      torque = sign(1.0_wp, spin)*torque
   end subroutine wrench_exact

   !> Exact wrench for a positive spin with the rotation centre inside the spot.
   pure subroutine centre_inside(shape, ux, uy, with_torque, fx, fy, torque)
      !> Shape of the spot.
      type(spot_shape_type), intent(in) :: shape
      !> Sliding velocity along the major axis over the spin velocity.
      real(wp), intent(in) :: ux
      !> Sliding velocity along the minor axis over the spin velocity.
      real(wp), intent(in) :: uy
      !> Whether the torque is wanted.
      logical, intent(in) :: with_torque
      !> Force along the major axis, in units of f N.
      real(wp), intent(out) :: fx
      !> Force along the minor axis, in units of f N.
      real(wp), intent(out) :: fy
      !> Torque about the normal, in units of f N a.
      real(wp), intent(out) :: torque
      real(wp) :: p, q, u

      p = uy*uy
      q = ux*ux/shape%k2
      fx = -1.5_wp*ux*(shape%d_integral - shape%j11*p - shape%j20*q)
      fy = -1.5_wp*uy*(shape%b_integral - shape%j20*p - shape%k2*shape%j11*q)
      torque = 0.0_wp
      if (.not. with_torque) return
      u = 1.0_wp - p - q
      torque = -0.375_wp*(shape%e_integral*u*u &
         + 2.0_wp*u*(shape%k2*shape%d_integral*p + shape%b_integral*q) &
         + 3.0_wp*(shape%k2*shape%j20*p*p + 2.0_wp*shape%k2*shape%j11*p*q + shape%j20*q*q))
   end subroutine centre_inside

   !> Exact wrench for a spin >= 0 with the rotation centre outside the spot.
   pure subroutine centre_outside(shape, x, y, w, with_torque, fx, fy, torque)
      !> Shape of the spot.
      type(spot_shape_type), intent(in) :: shape
      !> Sliding velocity along the major axis.
      real(wp), intent(in) :: x
      !> Sliding velocity along the minor axis.
      real(wp), intent(in) :: y
      !> Spin velocity, >= 0.
      real(wp), intent(in) :: w
      !> Whether the torque is wanted.
      logical, intent(in) :: with_torque
      !> Force along the major axis, in units of f N.
      real(wp), intent(out) :: fx
      !> Force along the minor axis, in units of f N.
      real(wp), intent(out) :: fy
      !> Torque about the normal, in units of f N a.
      real(wp), intent(out) :: torque
      real(wp) :: s, excess, root, l, h, px, py, tau

      ! The largest root of x^2/(k^2 w^2 + l) + y^2/(w^2 + l) = 1: the ellipse through the rotation
      ! centre confocal with the spot.
      s = x*x + y*y - (1.0_wp + shape%k2)*w*w
      excess = max(x*x + shape%k2*(y*y - w*w), 0.0_wp)
      root = sqrt(s*s + 4.0_wp*w*w*excess)
      if (s >= 0.0_wp) then
         l = 0.5_wp*(s + root)
      else
         l = 2.0_wp*w*w*excess/(root - s)
      end if
      root = sqrt(l)
      h = 1.0_wp/(root + sqrt(l + w*w))
      px = x*h
      py = y*h
      tau = w*h
      if (root > 6.5_wp*w) then
         call outer_integrals(x_4, w_4, shape, px, py, tau, with_torque, fx, fy, torque)
      else if (root > 1.2_wp*w) then
         call outer_integrals(x_8, w_8, shape, px, py, tau, with_torque, fx, fy, torque)
      else
         call outer_integrals(x_16, w_16, shape, px, py, tau, with_torque, fx, fy, torque)
      end if
   end subroutine centre_outside

   !> The integrals of `centre_outside` over tau = tan(theta/2), scaled to (0, 1).
   pure subroutine outer_integrals(nodes, weights, shape, px, py, tau, with_torque, fx, fy, torque)
      !> Nodes in (0, 1).
      real(wp), intent(in) :: nodes(:)
      !> Weights.
      real(wp), intent(in) :: weights(:)
      !> Shape of the spot.
      type(spot_shape_type), intent(in) :: shape
      !> Scaled sliding velocity along the major axis.
      real(wp), intent(in) :: px
      !> Scaled sliding velocity along the minor axis.
      real(wp), intent(in) :: py
      !> Upper end of the integral.
      real(wp), intent(in) :: tau
      !> Whether the torque is wanted.
      logical, intent(in) :: with_torque
      !> Force along the major axis, in units of f N.
      real(wp), intent(out) :: fx
      !> Force along the minor axis, in units of f N.
      real(wp), intent(out) :: fy
      !> Torque about the normal, in units of f N a.
      real(wp), intent(out) :: torque
      real(wp) :: g, sx, sy, sine2, cosine2, delta2, u, weight, sum_x, sum_y, sum_t, t
      integer :: i

      sum_x = 0.0_wp
      sum_y = 0.0_wp
      sum_t = 0.0_wp
      do i = 1, size(nodes)
         t = tau*nodes(i)
         g = 2.0_wp/(1.0_wp + t*t)
         sx = (g*px*nodes(i))**2
         sy = (g*py*nodes(i))**2
         sine2 = (g*t)**2
         cosine2 = (g - 1.0_wp)**2
         delta2 = 1.0_wp/(1.0_wp - shape%c*sine2)
         u = 1.0_wp - sy - sx*delta2
         weight = weights(i)*g*sqrt(delta2)*u
         sum_x = sum_x + weight*cosine2*delta2
         sum_y = sum_y + weight*cosine2
         if (with_torque) sum_t = sum_t + weight*(shape%k2*u*sine2*(1.0_wp + delta2) &
            + 4.0_wp*cosine2*(sx*delta2*delta2 + shape%k2*sy))
      end do
      fx = -1.5_wp*px*sum_x
      fy = -1.5_wp*py*sum_y
      torque = -0.375_wp*tau*sum_t
   end subroutine outer_integrals

   !> Bring the arguments of a kernel into the range where squares are safe, and start with the
   !> wrench of rest, or NaN outside the domain.
   pure subroutine prepare(vx, vy, spin, delta, x, y, w, d, moving, fx, fy, torque)
      !> Sliding velocity along the major axis [m/s].
      real(wp), intent(in) :: vx
      !> Sliding velocity along the minor axis [m/s].
      real(wp), intent(in) :: vy
      !> Spin velocity [m/s].
      real(wp), intent(in) :: spin
      !> Regularisation velocity [m/s].
      real(wp), intent(in) :: delta
      !> `vx`, rescaled by a power of two.
      real(wp), intent(out) :: x
      !> `vy`, rescaled.
      real(wp), intent(out) :: y
      !> |`spin`|, rescaled.
      real(wp), intent(out) :: w
      !> `delta`, rescaled.
      real(wp), intent(out) :: d
      !> Whether there is anything left to compute.
      logical, intent(out) :: moving
      !> Zero or NaN.
      real(wp), intent(out) :: fx
      !> Zero or NaN.
      real(wp), intent(out) :: fy
      !> Zero or NaN.
      real(wp), intent(out) :: torque
      real(wp) :: largest
      integer :: shift

      fx = 0.0_wp
      fy = 0.0_wp
      torque = 0.0_wp
      x = vx
      y = vy
      w = abs(spin)
      d = delta
      ! Before any comparison: comparing a NaN raises an exception.
      moving = ieee_is_finite(x) .and. ieee_is_finite(y) .and. ieee_is_finite(w) .and. &
         ieee_is_finite(d)
      if (moving) moving = d >= 0.0_wp
      if (.not. moving) then
         fx = ieee_value(fx, ieee_quiet_nan)
         fy = fx
         torque = fx
         return
      end if
      largest = max(abs(x), abs(y), w)
      moving = largest > 0.0_wp
      if (largest >= smallest_plain .and. max(largest, d) <= largest_plain) return
      if (.not. moving) return
      shift = -exponent(max(largest, d))
      x = scale(x, shift)
      y = scale(y, shift)
      w = scale(w, shift)
      d = scale(d, shift)
   end subroutine prepare

   !> Length of a plane vector, also where the squares underflow.
   pure function length(x, y) result(r)
      !> First component.
      real(wp), intent(in) :: x
      !> Second component.
      real(wp), intent(in) :: y
      real(wp) :: r

      r = x*x + y*y
      if (r > 1.0e-280_wp) then
         r = sqrt(r)
      else
         r = hypot(x, y)
      end if
   end function length

   !> Coefficient T1 of the torque T1/u of fast sliding, (cos^2 psi + k^2 sin^2 psi)/5.
   pure function far_torque(shape, x, y, v) result(t1)
      !> Shape of the spot.
      type(spot_shape_type), intent(in) :: shape
      !> Sliding velocity along the major axis.
      real(wp), intent(in) :: x
      !> Sliding velocity along the minor axis.
      real(wp), intent(in) :: y
      !> Its length.
      real(wp), intent(in) :: v
      real(wp) :: t1

      t1 = 0.2_wp
      if (v > 0.0_wp .and. shape%k2 < 1.0_wp) t1 = 0.2_wp*((x/v)**2 + shape%k2*(y/v)**2)
   end function far_torque

   !> Force of the second Pade model over the velocity component.
   pure function pade22_force(slope, v, w) result(f)
      !> Slope of the force at rest.
      real(wp), intent(in) :: slope
      !> Sliding speed.
      real(wp), intent(in) :: v
      !> Spin velocity.
      real(wp), intent(in) :: w
      real(wp) :: f
      real(wp) :: kv

      kv = slope*v
      f = slope*(w + kv)/(w*w + w*kv + kv*kv)
   end function pade22_force

end module contensou_contact_wrench
