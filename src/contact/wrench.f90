!> Friction wrench of a spot that slides and spins: the rungs of the Contensou-Erismann ladder.
!>
!> On the spot x^2/a^2 + y^2/b^2 <= 1 with the Hertz pressure s and the slip velocity
!> v_M = (v_x - w y, v_y + w x) the wrench on the body that slips is
!>    F = -f \int s v_M/|v_M| dA,    T = -f \int s r x v_M/|v_M| dA.
!> Every kernel here returns it in units of f N (force) and f N a (torque) as a function that is
!> homogeneous of degree zero in the sliding velocity (vx, vy) and the spin velocity W = a w, so
!> that pure sliding, pure spinning and everything between need no special case.
!> The wrench of v = W = 0 is zero. Outside the domain (velocities that are not finite, a negative
!> regularisation velocity, a shape of NaN) it is NaN.
!>
!> Sources: I. Kosenko, E. Aleksandrov, Proc. 7th Modelica Conference, Como 2009, 288-298 (the
!> simplified model); V. Ph. Zhuravlev, J. Appl. Math. Mech. 62 (1998) 705 (Pade models). The exact
!> wrench is in `contensou_contact_wrench_exact`; all formulas are in docs/wrench.md.
module contensou_contact_wrench
   use contensou_base_kinds, only : wp
   use contensou_contact_spot, only : spot_shape_type
   use contensou_contact_wrench_exact, only : wrench_exact, wrench_exact_jacobian, &
      wrench_exact_potential
   use contensou_contact_wrench_scaling, only : length, prepare, rescaled, scaled_type, &
      slip_type
   implicit none(type, external)
   private

   public :: slip_type
   public :: wrench_kernel, wrench_coulomb, wrench_simplified, wrench_pade11, wrench_pade22
   public :: wrench_exact, wrench_exact_jacobian, wrench_exact_potential
   public :: wrench_jacobian_kernel, wrench_coulomb_jacobian, wrench_simplified_jacobian
   public :: wrench_pade11_jacobian, wrench_pade22_jacobian

   abstract interface
      !> Dimensionless friction wrench.
      pure subroutine wrench_kernel(shape, slip, with_torque, wrench)
         import :: slip_type, spot_shape_type, wp
         implicit none(type, external)
         type(spot_shape_type), intent(in) :: shape
         type(slip_type), intent(in) :: slip
         !> Whether the torque is wanted; otherwise it is zero and costs nothing.
         logical, intent(in) :: with_torque
         !> Force along the major and the minor axis, in units of f N, and torque, of f N a.
         real(wp), intent(out) :: wrench(3)
      end subroutine wrench_kernel

      !> Dimensionless friction wrench and its derivatives.
      pure subroutine wrench_jacobian_kernel(shape, slip, wrench, jacobian)
         import :: slip_type, spot_shape_type, wp
         implicit none(type, external)
         type(spot_shape_type), intent(in) :: shape
         type(slip_type), intent(in) :: slip
         !> Force along the major and the minor axis, in units of f N, and torque, of f N a.
         real(wp), intent(out) :: wrench(3)
         !> Derivative of component i by velocity j of (vx, vy, W), in the units of the wrench over
         !> m/s.
         real(wp), intent(out) :: jacobian(3, 3)
      end subroutine wrench_jacobian_kernel
   end interface

contains

   !> Regularised Amontons-Coulomb law: force min(|v|/delta, 1) against v, no torque.
   pure subroutine wrench_coulomb(shape, slip, with_torque, wrench)
      type(spot_shape_type), intent(in) :: shape
      type(slip_type), intent(in) :: slip
      logical, intent(in) :: with_torque
      real(wp), intent(out) :: wrench(3)
      real(wp) :: v
      type(scaled_type) :: s

      call prepare(shape, slip, s)
      wrench = s%rest
      if (.not. s%moving) return
      v = max(length(s%x, s%y), s%d)
      if (v <= 0.0_wp) return
      wrench(1) = -s%x/v
      wrench(2) = -s%y/v
   end subroutine wrench_coulomb

   !> The simplified Contensou model of Kosenko and Aleksandrov (2009).
   !>
   !> Force linear in u = v/(a |w|) up to u* = 1/k_x (1/k_y across), constant beyond; torque k_T up
   !> to T1/k_T, then T1/u, with T1 = (cos^2 psi + k^2 sin^2 psi)/5 for sliding in direction psi.
   !> Where u* a |w| < delta, the force is the regularised Coulomb law and the torque fades
   !> linearly to zero with w, so that the wrench is continuous.
   pure subroutine wrench_simplified(shape, slip, with_torque, wrench)
      type(spot_shape_type), intent(in) :: shape
      type(slip_type), intent(in) :: slip
      logical, intent(in) :: with_torque
      real(wp), intent(out) :: wrench(3)
      real(wp) :: v, t1, fade
      type(scaled_type) :: s

      call prepare(shape, slip, s)
      wrench = s%rest
      if (.not. s%moving) return
      v = length(s%x, s%y)
      if (v > 0.0_wp) then
         wrench(1) = -s%x/max(v, s%w/shape%slope_x, s%d)
         wrench(2) = -s%y/max(v, s%w/shape%slope_y, s%d)
      end if
      if (.not. with_torque) return
      t1 = far_torque(shape, s%x, s%y, v)
      if (shape%torque*v <= t1*s%w) then
         wrench(3) = shape%torque
      else
         wrench(3) = t1*s%w/v
      end if
      fade = min(shape%slope_x, shape%slope_y)*s%d
      if (s%w < fade) wrench(3) = wrench(3)*s%w/fade
      wrench(3) = -sign(wrench(3), slip%spin)
   end subroutine wrench_simplified

   !> The simplified model and its derivatives; at a kink those of the side that the model is on.
   !>
   !> The Jacobian is not symmetric: the model has no potential. At rest without regularisation
   !> there is no derivative; wrench and Jacobian are then zero. Entries that would overflow are the
   !> largest number of the kind.
   pure subroutine wrench_simplified_jacobian(shape, slip, wrench, jacobian)
      type(spot_shape_type), intent(in) :: shape
      type(slip_type), intent(in) :: slip
      real(wp), intent(out) :: wrench(3), jacobian(3, 3)
      real(wp) :: v, t1, fade, ratio, sense, torque, slopes(3)
      type(scaled_type) :: s

      call prepare(shape, slip, s)
      wrench = s%rest
      jacobian = s%rest
      if (.not. s%moving .and. .not. s%d > 0.0_wp) return
      sense = sign(1.0_wp, slip%spin)
      v = length(s%x, s%y)
      call simplified_force(s%x, s%y, v, s%w, s%d, shape%slope_x, wrench(1), slopes)
      jacobian(1, :) = [slopes(1), slopes(2), sense*slopes(3)]
      call simplified_force(s%y, s%x, v, s%w, s%d, shape%slope_y, wrench(2), slopes)
      jacobian(2, :) = [slopes(2), slopes(1), sense*slopes(3)]

      fade = min(shape%slope_x, shape%slope_y)*s%d
      ratio = 1.0_wp
      if (s%w < fade) ratio = s%w/fade
      t1 = far_torque(shape, s%x, s%y, v)
      if (shape%torque*v <= t1*s%w .or. .not. v > 0.0_wp) then
         torque = shape%torque
         slopes = 0.0_wp
      else
         ! The ratio over v, also where its inverse overflows.
         slopes(3) = 1.0_wp
         if (s%w < fade) slopes(3) = s%w
         slopes(3) = slopes(3)/v
         if (s%w < fade) slopes(3) = slopes(3)/fade
         slopes(1) = (s%w/v)*(s%x/v)*(0.4_wp - 3.0_wp*t1)*slopes(3)
         slopes(2) = (s%w/v)*(s%y/v)*(0.4_wp*shape%k2 - 3.0_wp*t1)*slopes(3)
         slopes(3) = t1*slopes(3)
         torque = t1*(s%w/v)
      end if
      if (s%w < fade) slopes(3) = slopes(3) + torque/fade
      torque = torque*ratio
      wrench(3) = -sign(torque, slip%spin)
      jacobian(3, :) = [-sense*slopes(1), -sense*slopes(2), -slopes(3)]
      if (s%shift /= 0) jacobian = rescaled(jacobian, s%shift)
   end subroutine wrench_simplified_jacobian

   !> A component of the force of the simplified model, for a spin >= 0, and its derivatives.
   pure subroutine simplified_force(along, across, v, w, d, slope, force, slopes)
      !> Sliding velocity in the direction of the component.
      real(wp), intent(in) :: along
      !> The other sliding velocity.
      real(wp), intent(in) :: across
      !> Sliding speed.
      real(wp), intent(in) :: v
      !> Spin velocity.
      real(wp), intent(in) :: w
      !> Regularisation velocity.
      real(wp), intent(in) :: d
      !> Slope of the force at rest.
      real(wp), intent(in) :: slope
      real(wp), intent(out) :: force
      !> Derivatives by `along`, `across` and `w`.
      real(wp), intent(out) :: slopes(3)

      slopes = 0.0_wp
      if (v >= max(w/slope, d)) then
         force = -along/v
         slopes(1) = -(across/v)**2/v
         slopes(2) = (along/v)*(across/v)/v
      else if (w >= d*slope) then
         slopes(1) = -slope/w
         force = slopes(1)*along
         slopes(3) = -force/w
      else
         slopes(1) = -1.0_wp/d
         force = slopes(1)*along
      end if
   end subroutine simplified_force

   !> Pade approximation with one term at rest and one at infinity:
   !> F = k u/(1 + k u), T = k_T T1/(T1 + k_T u).
   pure subroutine wrench_pade11(shape, slip, with_torque, wrench)
      type(spot_shape_type), intent(in) :: shape
      type(slip_type), intent(in) :: slip
      logical, intent(in) :: with_torque
      real(wp), intent(out) :: wrench(3)
      real(wp) :: v, t1, we
      type(scaled_type) :: s

      call prepare(shape, slip, s)
      wrench = s%rest
      if (.not. s%moving) return
      v = length(s%x, s%y)
      we = length(s%w, shape%slope_x*s%d)
      if (v > 0.0_wp) then
         wrench(1) = -s%x*(shape%slope_x/(we + shape%slope_x*v))
         wrench(2) = -s%y*(shape%slope_y/(we + shape%slope_y*v))
      end if
      if (.not. with_torque .or. s%w <= 0.0_wp) return
      t1 = far_torque(shape, s%x, s%y, v)
      wrench(3) = -sign(s%w*shape%torque*t1/(t1*we + shape%torque*v), slip%spin)
   end subroutine wrench_pade11

   !> Pade approximation with two terms at rest and two at infinity:
   !> F = (k u + k^2 u^2)/(1 + k u + k^2 u^2), T = k_T (1 + m u)/(1 + m u + m^2 u^2), m = k_T/T1.
   !>
   !> At rest the second terms are zero (F is odd and T even in u), at infinity too.
   pure subroutine wrench_pade22(shape, slip, with_torque, wrench)
      type(spot_shape_type), intent(in) :: shape
      type(slip_type), intent(in) :: slip
      logical, intent(in) :: with_torque
      real(wp), intent(out) :: wrench(3)
      real(wp) :: v, t1, we
      type(scaled_type) :: s

      call prepare(shape, slip, s)
      wrench = s%rest
      if (.not. s%moving) return
      v = length(s%x, s%y)
      we = length(s%w, shape%slope_x*s%d)
      if (v > 0.0_wp) then
         wrench(1) = -s%x*pade22_force(shape%slope_x, v, we)
         wrench(2) = -s%y*pade22_force(shape%slope_y, v, we)
      end if
      if (.not. with_torque .or. s%w <= 0.0_wp) return
      t1 = far_torque(shape, s%x, s%y, v)*we
      wrench(3) = shape%torque*v
      wrench(3) = shape%torque*t1*(t1 + wrench(3))/(t1*t1 + t1*wrench(3) + wrench(3)*wrench(3))
      wrench(3) = -sign(wrench(3)*(s%w/we), slip%spin)
   end subroutine wrench_pade22

   !> Coefficient T1 of the torque T1/u of fast sliding, (cos^2 psi + k^2 sin^2 psi)/5.
   pure function far_torque(shape, x, y, v) result(t1)
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

   !> Regularised Amontons-Coulomb law and its derivatives; zero at rest without regularisation.
   pure subroutine wrench_coulomb_jacobian(shape, slip, wrench, jacobian)
      type(spot_shape_type), intent(in) :: shape
      type(slip_type), intent(in) :: slip
      real(wp), intent(out) :: wrench(3), jacobian(3, 3)
      real(wp) :: v
      type(scaled_type) :: s

      call prepare(shape, slip, s)
      wrench = s%rest
      jacobian = s%rest
      if (.not. s%moving .and. .not. s%d > 0.0_wp) return
      v = length(s%x, s%y)
      if (v > s%d) then
         wrench(1:2) = [-s%x/v, -s%y/v]
         jacobian(1, 1) = -(s%y/v)**2/v
         jacobian(1, 2) = (s%x/v)*(s%y/v)/v
         jacobian(2, 1) = jacobian(1, 2)
         jacobian(2, 2) = -(s%x/v)**2/v
      else if (s%d > 0.0_wp) then
         wrench(1:2) = [-s%x/s%d, -s%y/s%d]
         jacobian(1, 1) = -1.0_wp/s%d
         jacobian(2, 2) = -1.0_wp/s%d
      end if
      if (s%shift /= 0) jacobian = rescaled(jacobian, s%shift)
   end subroutine wrench_coulomb_jacobian

   !> The first Pade model and its derivatives; zero at rest without regularisation.
   pure subroutine wrench_pade11_jacobian(shape, slip, wrench, jacobian)
      type(spot_shape_type), intent(in) :: shape
      type(slip_type), intent(in) :: slip
      real(wp), intent(out) :: wrench(3), jacobian(3, 3)
      real(wp) :: v, t1, we, den, t1_slopes(2), slope(2), g(2, 3), ratio
      type(scaled_type) :: s

      call prepare(shape, slip, s)
      wrench = s%rest
      jacobian = s%rest
      if (.not. s%moving .and. .not. s%d > 0.0_wp) return
      v = length(s%x, s%y)
      we = length(s%w, shape%slope_x*s%d)
      slope = [shape%slope_x, shape%slope_y]
      g(:, 1) = slope/(we + slope*v)
      g(:, 2) = -slope**2/(we + slope*v)**2
      g(:, 3) = -slope/(we + slope*v)**2
      call pade_forces(slip, s, v, we, g, wrench, jacobian)

      ratio = 1.0_wp
      if (we > 0.0_wp) ratio = s%w/we
      call far_torque_slopes(shape, s%x, s%y, v, t1, t1_slopes)
      den = t1*we + shape%torque*v
      wrench(3) = -sign(s%w*(shape%torque*t1/den), slip%spin)
      ! By v through the direction and the speed, and by w.
      jacobian(3, 1:2) = shape%torque*wrench(3)/den*v/t1*t1_slopes
      if (v > 0.0_wp) jacobian(3, 1:2) = jacobian(3, 1:2) &
         - shape%torque*wrench(3)/den*[s%x, s%y]/v
      jacobian(3, 3) = -shape%torque*t1/den*(1.0_wp - t1*s%w*ratio/den)
      if (s%shift /= 0) jacobian = rescaled(jacobian, s%shift)
   end subroutine wrench_pade11_jacobian

   !> The second Pade model and its derivatives; zero at rest without regularisation.
   pure subroutine wrench_pade22_jacobian(shape, slip, wrench, jacobian)
      type(spot_shape_type), intent(in) :: shape
      type(slip_type), intent(in) :: slip
      real(wp), intent(out) :: wrench(3), jacobian(3, 3)
      real(wp) :: v, t1, we, t1_slopes(2), slope(2), kv(2), q(2), g(2, 3), p, m, r, &
         ratio, by_p, by_m
      type(scaled_type) :: s

      call prepare(shape, slip, s)
      wrench = s%rest
      jacobian = s%rest
      if (.not. s%moving .and. .not. s%d > 0.0_wp) return
      v = length(s%x, s%y)
      we = length(s%w, shape%slope_x*s%d)
      slope = [shape%slope_x, shape%slope_y]
      kv = slope*v
      q = we*we + we*kv + kv*kv
      g(:, 1) = slope*(we + kv)/q
      g(:, 2) = slope**2*(q - (we + kv)*(we + 2.0_wp*kv))/q/q
      g(:, 3) = slope*(q - (we + kv)*(2.0_wp*we + kv))/q/q
      call pade_forces(slip, s, v, we, g, wrench, jacobian)

      call far_torque_slopes(shape, s%x, s%y, v, t1, t1_slopes)
      ratio = 1.0_wp
      if (we > 0.0_wp) ratio = s%w/we
      p = t1*we
      m = shape%torque*v
      r = p*p + p*m + m*m
      wrench(3) = -sign(shape%torque*ratio*p*(p + m)/r, slip%spin)
      by_p = -sign(shape%torque*ratio*m*m*(2.0_wp*p + m)/r/r, slip%spin)
      by_m = sign(shape%torque*ratio*p*m*(2.0_wp*p + m)/r/r, slip%spin)
      jacobian(3, 1:2) = by_p*we*t1_slopes
      if (v > 0.0_wp) jacobian(3, 1:2) = jacobian(3, 1:2) + by_m*shape%torque*[s%x, s%y]/v
      jacobian(3, 3) = sign(1.0_wp, slip%spin)*by_p*t1*ratio
      ! By w at a given W_e; (1 - ratio^2)/W_e without regularisation is zero.
      if (s%d > 0.0_wp) jacobian(3, 3) = jacobian(3, 3) - shape%torque*p*(p + m)/r &
         *(shape%slope_x*s%d/we)**2/we
      if (s%shift /= 0) jacobian = rescaled(jacobian, s%shift)
   end subroutine wrench_pade22_jacobian

   !> Forces -(x, y) g(v, W_e) of a Pade model and their derivatives.
   pure subroutine pade_forces(slip, s, v, we, g, wrench, jacobian)
      type(slip_type), intent(in) :: slip
      type(scaled_type), intent(in) :: s
      !> Sliding speed.
      real(wp), intent(in) :: v
      !> Regularised spin velocity.
      real(wp), intent(in) :: we
      !> g along the two axes, with its derivatives by the speed and by `we`.
      real(wp), intent(in) :: g(2, 3)
      !> Forces; the torque is left as it is.
      real(wp), intent(inout) :: wrench(3)
      !> Their derivatives.
      real(wp), intent(inout) :: jacobian(3, 3)
      real(wp) :: along(2), ratio

      ratio = 1.0_wp
      if (we > 0.0_wp) ratio = s%w/we
      along = 0.0_wp
      if (v > 0.0_wp) along = [s%x, s%y]/v
      wrench(1:2) = -[s%x, s%y]*g(:, 1)
      jacobian(1, 1:2) = -s%x*g(1, 2)*along
      jacobian(2, 1:2) = -s%y*g(2, 2)*along
      jacobian(1, 1) = jacobian(1, 1) - g(1, 1)
      jacobian(2, 2) = jacobian(2, 2) - g(2, 1)
      jacobian(1:2, 3) = -[s%x, s%y]*g(:, 3)*ratio*sign(1.0_wp, slip%spin)
   end subroutine pade_forces

   !> Coefficient T1 of the torque of fast sliding, and its derivatives by the sliding velocity.
   pure subroutine far_torque_slopes(shape, x, y, v, t1, slopes)
      type(spot_shape_type), intent(in) :: shape
      !> Sliding velocity along the major axis.
      real(wp), intent(in) :: x
      !> Sliding velocity along the minor axis.
      real(wp), intent(in) :: y
      !> Its length.
      real(wp), intent(in) :: v
      !> The coefficient.
      real(wp), intent(out) :: t1
      !> Its derivatives; zero at v = 0, where they are multiplied with v.
      real(wp), intent(out) :: slopes(2)

      t1 = far_torque(shape, x, y, v)
      slopes = 0.0_wp
      if (v > 0.0_wp .and. shape%k2 < 1.0_wp) slopes = [(x/v)*(0.4_wp - 2.0_wp*t1), &
         (y/v)*(0.4_wp*shape%k2 - 2.0_wp*t1)]/v
   end subroutine far_torque_slopes

end module contensou_contact_wrench
