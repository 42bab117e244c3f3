!> Brush: the simplified theory of strips.f90 with the exact bound f p of Hertz.
!>
!> Bristles of a strip obey
!>    V dt/dxi = g - lambda t,  |t| <= f p,  lambda >= 0,  lambda (|t| - f p) = 0.
!> With tau the linear wrench over f N their three flexibilities are blended into one, gamma =
!> tau^2/(tau^2 + 36), so that large creep slides as a rigid body does, and multiplied by a
!> correction fitted to solutions by boundary elements. What the torque of bristles lacks of that of
!> the linear theory, which is reciprocal, is added times 1/(1 + (pi tau/4)^2)^2.
!>
!> Where it sticks t is a quadratic along a strip, and it slips first at a root of a cubic. From
!> there on, with xi - xi_c = -l cos ph, steps that are even in ph have
!>    t = P(t + int g dy/V),  P(t) = t within the bound at their end, else cut to it:
!> stable for any V, with the direction of g for V = 0, and without a jump where it sticks again.
!> Their error is proportional to the step, and is taken off by steps of half the length. What the
!> quadrature misses of full sliding, times gamma, is added: at V = 0 the wrench is the exact one.
!>
!> Derivatives would have kinks where a step begins to slip or a node of the quadrature is where
!> nothing slides, and slopes without bound where a strip may slip first in either of two places. So
!> P is rounded, directions g/|g| are those of g/sqrt(|g|^2 + (0.1 V f p0/l0)^2), and the place of
!> the first slip is drawn from one root to the other.
!>
!> Each step waits for the one before it, for a root and a quotient. So all strips take it together:
!> loops over strips are innermost, without branches, and become vector operations.
module contensou_contact_creep_brush
   use contensou_base_kinds, only : pi, wp
   use contensou_contact_catalogue, only : model_info_type
   use contensou_contact_creep_bounds, only : confine
   use contensou_contact_creep_law, only : creep_model_type, creep_motion_type, creep_spot_type, &
      creep_type
   use contensou_contact_creep_strips, only : cut, flow_type, new_flow, strip_at, strip_type, &
      to_axes
   use contensou_contact_parameters, only : parameters_type
   use contensou_contact_wrench, only : slip_type, wrench_exact
   use contensou_special_angle, only : quadrant_angle, small_turn
   use contensou_special_quadrature, only : w_6, x_6
   use contensou_special_smooth_step, only : smooth_step
   implicit none(type, external)
   private

   public :: brush

   type, extends(creep_type) :: brush_type
   contains
      procedure :: kernel
   end type brush_type

   !> Number of strips, nodes where a strip sticks, and steps behind, which are halved once.
   integer, parameter :: n_strips = 12, n_stick = 6, n_slip = 12

   !> Nodes on (-1, 1) and weights over the strips, and over what sticks.
   real(wp), parameter :: x_strips(n_strips) = [-x_6, x_6], w_strips(n_strips) = [w_6, w_6]
   real(wp), parameter :: root_3 = 0.577350269189625764509148780501957_wp

   !> The strips side by side.
   type :: strips_type
      !> Half-lengths, places of the inlets along the flow and of the strips across it.
      real(wp), dimension(n_strips) :: l, front, eta
      !> What stretches the bristles, g = g0 + g1 y at the way y from the inlet.
      real(wp), dimension(n_strips) :: x0, y0
      real(wp) :: x1, y1
      !> f p in the middles, widths, and V > 0.
      real(wp), dimension(n_strips) :: bound, width
      real(wp) :: rolls
      !> Sums of t and its moment; of f p g/|g| and its moment.
      real(wp), dimension(n_strips, 3) :: tractions, sliding
   end type strips_type

   integer :: index

   !> Places of the strips across, in half-widths, their lengths in that of the middle one, and
   !> weights.
   real(wp), parameter :: places(n_strips) = [(sin(0.5_wp*pi*x_strips(index)), &
      index=1, n_strips)]
   real(wp), parameter :: shares(n_strips) = [(cos(0.5_wp*pi*x_strips(index)), &
      index=1, n_strips)]
   real(wp), parameter :: weights(n_strips) = 0.5_wp*pi*w_strips*shares

   !> How far from zero, over its range, a maximum of the cubic has no part in where steps begin.
   real(wp), parameter :: deep = 0.3_wp

   !> Part of its slope at the inlet below which the cubic is flat, and part of the square of its
   !> second coefficient at which maxima come and go.
   real(wp), parameter :: flat = 0.1_wp, at_birth = 0.2_wp

   !> Part of the bound within which a traction comes to it in a rounded corner.
   real(wp), parameter :: corner = 0.2_wp

   !> What stretches the bristles, over V f p0/l0, below which they have no direction of sliding.
   real(wp), parameter :: no_direction = 0.1_wp

   !> Square of the tau at which half of the flexibilities is blended.
   real(wp), parameter :: blend = 36.0_wp

   !> Over tau^2: how the linear torque fades, as the slope of F without spin.
   real(wp), parameter :: fade = (0.25_wp*pi)**2

   !> Parameters of the correction.
   real(wp), parameter :: q0 = 0.222_wp, q1 = 0.0258_wp, q2 = 0.0402_wp, q3 = 6.60_wp

   !> Linear force and torque over f N below which the correction is even in them: else derivatives
   !> would have kinks where there is no spin, or nothing but spin.
   real(wp), parameter :: rounding = 0.1_wp

   !> Below any g that is not zero: there is none to divide by.
   real(wp), parameter :: least = 1.0e-200_wp

   !> Largest tau in the correction: beyond, all slips.
   real(wp), parameter :: most = 50.0_wp

contains

   !> Row of the brush.
   function brush() result(model)
      type(creep_model_type) :: model

      model%info = model_info_type("brush", "bristles on strips along the flow, at any angle, " // &
         "with the pressure of Hertz as bound and Kalker's forces at small creep", "", &
         "J. J. Kalker, Vehicle System Dynamics 11 (1982) 1")
      model%create => new_brush
   end function brush

   !> Make the law.
   subroutine new_brush(parameters, creep)
      type(parameters_type), intent(in) :: parameters
      class(creep_type), allocatable, intent(out) :: creep

      allocate(brush_type :: creep)
   end subroutine new_brush

   !> Wrench of the brush.
   pure subroutine kernel(self, spot, motion, wrench)
      class(brush_type), intent(in) :: self
      type(creep_spot_type), intent(in) :: spot
      type(creep_motion_type), intent(in) :: motion
      !> Force along the major and the minor axis, torque about the normal.
      real(wp), intent(out) :: wrench(3)
      type(flow_type) :: flow
      real(wp) :: m(2, 2), single, forces(2), moment, moves2, turns2, moves, turns, factor, gamma
      real(wp) :: tractions(3), sliding(3), missing, fading

      call wrench_exact(spot%shape, slip_type(motion%x, motion%y, motion%spin), .true., wrench)
      if (.not. max(abs(motion%rx), abs(motion%ry)) > 0.0_wp) return
      flow = new_flow(spot, motion)
      associate (k => spot%shape%k, rolls => flow%rolls, l0 => flow%l0, h => flow%h, c => flow%c, &
         slope => flow%slope, root_k => flow%root_k, third => flow%third, u => flow%u, &
         spin => motion%spin)
         m = flow%m
         forces = (8.0_wp/3.0_wp)*l0*k*matmul(m, u)
         moment = (8.0_wp/15.0_wp)*k*k*h*spin*third(2)
         moves2 = forces(1)**2 + forces(2)**2
         forces = 0.25_wp*pi*l0*l0*k*spin*third
         turns2 = forces(1)**2 + forces(2)**2 + 4.0_wp*moment**2/k
         ! What the torque of bristles that all stick lacks of that of the linear theory.
         missing = 0.25_wp*pi*l0*l0*k*(m(2, 1)*u(1) + m(2, 2)*u(2)) + (8.0_wp/15.0_wp)*h*k*k*spin &
            *(third(2)*(1.0_wp + slope**2) - third(1)*slope) - (1.5_wp/pi)*root_k*(c(4)*u(1) &
            + c(5)*u(2) + root_k*c(6)*spin)
         gamma = moves2 + turns2
         if (.not. gamma > 0.0_wp) return
         gamma = gamma/(gamma + blend*rolls**2)
         moves = sqrt(moves2/(rolls**2 + moves2/most**2))
         turns = sqrt(turns2/(rolls**2 + turns2/most**2))
         fading = 1.0_wp + q3*(sqrt(turns**2 + rounding**2) - rounding)
         factor = 1.0_wp + moves**2*(q1 + q2*moves**2 - q0/((1.0_wp + moves) &
            *sqrt(moves**2 + rounding**2)))/fading
         single = factor*gamma*0.5_wp*(m(1, 1) + m(2, 2))
         m = factor*(1.0_wp - gamma)*m
         m(1, 1) = m(1, 1) + single
         m(2, 2) = m(2, 2) + single
         flow%m = m
         third = factor*(1.0_wp - gamma)*third
         third(2) = third(2) + single
         call roll(flow, spin, tractions, sliding)
         ! -tractions, and what the quadrature misses of full sliding.
         wrench = gamma*wrench + to_axes(flow, gamma*sliding - tractions)
         wrench(3) = wrench(3) + missing*rolls*(rolls/(rolls**2 + fade*(moves2 + turns2 &
            + 4.0_wp*missing**2/k)))**2
      end associate
      call confine(spot, motion, wrench)
   end subroutine kernel

   !> The tractions of all strips, and those of full sliding.
   pure subroutine roll(flow, spin, tractions, sliding)
      type(flow_type), intent(in) :: flow
      real(wp), intent(in) :: spin
      !> Sums of t and its moment; of f p g/|g| and its moment.
      real(wp), intent(out) :: tractions(3), sliding(3)
      type(strips_type) :: strips
      type(strip_type) :: strip
      real(wp), dimension(n_strips) :: leaves, along, across, angle, rest, c, s
      real(wp) :: k, small
      integer :: i

      k = flow%p0/flow%l0
      do i = 1, n_strips
         strip = strip_at(flow, spin, places(i), shares(i))
         leaves(i) = first_slip(strip, k*flow%rolls)
         strips%l(i) = strip%l
         strips%front(i) = strip%xi - strip%l
         strips%eta(i) = strip%eta
         strips%x0(i) = strip%g0(1)
         strips%y0(i) = strip%g0(2)
         strips%x1 = strip%g1(1)
         strips%y1 = strip%g1(2)
         along(i) = max(1.0_wp - leaves(i)/strip%l, -1.0_wp)
         small = (1.0_wp - along(i))*(1.0_wp + along(i))
         across(i) = sqrt(small)
         small = quadrant_angle(abs(along(i)), across(i), small)
         angle(i) = merge(small, pi - small, along(i) > 0.0_wp)
         rest(i) = merge(pi - small, small, along(i) > 0.0_wp)
      end do
      strips%bound = k*strips%l
      strips%rolls = flow%rolls
      strips%width = flow%h*weights
      strips%tractions = 0.0_wp
      strips%sliding = 0.0_wp
      ! What slips, or sticks again, with an error in proportion to the step.
      call small_turn(rest/real(2*n_slip, wp), c, s)
      call slip(strips, 2.0_wp*rest/real(2*n_slip, wp), leaves, along, across, c, s, 2*n_slip)
      call slip(strips, -rest/real(n_slip, wp), leaves, along, across, (c - s)*(c + s), &
         2.0_wp*c*s, n_slip)
      strips%tractions = strips%tractions/flow%rolls
      call small_turn(angle/real(2*n_stick, wp), c, s)
      call stick(strips, angle/real(n_stick, wp), leaves, c, s)
      tractions = sum(strips%tractions, 1)
      sliding = sum(strips%sliding, 1)
   end subroutine roll

   !> Add the tractions of what sticks, and those of full sliding there.
   pure subroutine stick(strips, step, leaves, half_c, half_s)
      type(strips_type), intent(inout) :: strips
      !> Steps of ph, and the way from the inlet up to where strips slip first.
      real(wp), intent(in) :: step(n_strips), leaves(n_strips)
      !> Cosine and sine of half a step.
      real(wp), intent(in) :: half_c(n_strips), half_s(n_strips)
      real(wp), dimension(n_strips) :: c, s
      real(wp) :: y, area, tx, ty, before, turn_c, turn_s, rest
      integer :: i, j

      rest = (no_direction*strips%rolls*strips%bound(1)/strips%l(1))**2
      ! Two nodes are exact for a cubic.
      do j = -1, 1, 2
         do i = 1, n_strips
            y = 0.5_wp*leaves(i)*(1.0_wp + real(j, wp)*root_3)
            area = 0.5_wp*strips%width(i)*leaves(i)*y/strips%rolls
            tx = area*(strips%x0(i) + 0.5_wp*y*strips%x1)
            ty = area*(strips%y0(i) + 0.5_wp*y*strips%y1)
            strips%tractions(i, 1) = strips%tractions(i, 1) + tx
            strips%tractions(i, 2) = strips%tractions(i, 2) + ty
            strips%tractions(i, 3) = strips%tractions(i, 3) + ((strips%front(i) + y)*ty &
               - strips%eta(i)*tx)
         end do
      end do
      c = half_c
      s = half_s
      do j = 1, n_stick
         do i = 1, n_strips
            y = strips%l(i)*(1.0_wp - c(i))
            tx = strips%x0(i) + y*strips%x1
            ty = strips%y0(i) + y*strips%y1
            area = strips%width(i)*step(i)*strips%l(i)*strips%bound(i)*s(i)*s(i) &
               /max(sqrt(tx*tx + ty*ty + rest), least)
            tx = area*tx
            ty = area*ty
            strips%sliding(i, 1) = strips%sliding(i, 1) + tx
            strips%sliding(i, 2) = strips%sliding(i, 2) + ty
            strips%sliding(i, 3) = strips%sliding(i, 3) + ((strips%front(i) + y)*ty &
               - strips%eta(i)*tx)
            turn_c = (half_c(i) - half_s(i))*(half_c(i) + half_s(i))
            turn_s = 2.0_wp*half_c(i)*half_s(i)
            before = c(i)
            c(i) = before*turn_c - s(i)*turn_s
            s(i) = s(i)*turn_c + before*turn_s
         end do
      end do
   end subroutine stick

   !> Add the tractions of strips from where they slip first, and those of full sliding there.
   pure subroutine slip(strips, step, leaves, along, across, turn_c, turn_s, n)
      type(strips_type), intent(inout) :: strips
      !> Steps of ph, times a weight.
      real(wp), intent(in) :: step(n_strips)
      !> Where that is: the way from the inlet, and cosine and sine of ph.
      real(wp), intent(in) :: leaves(n_strips), along(n_strips), across(n_strips)
      !> Cosine and sine of the steps.
      real(wp), intent(in) :: turn_c(n_strips), turn_s(n_strips)
      !> Number of steps.
      integer, intent(in) :: n
      real(wp), dimension(n_strips) :: c, s, y, x, z, width
      real(wp) :: way, bound, area, gx, gy, factor, before, place, rest
      integer :: i, j

      rest = (no_direction*strips%rolls*strips%bound(1)/strips%l(1))**2
      do i = 1, n_strips
         c(i) = along(i)
         s(i) = across(i)
         y(i) = leaves(i)
         ! V t.
         x(i) = leaves(i)*(strips%x0(i) + 0.5_wp*leaves(i)*strips%x1)
         z(i) = leaves(i)*(strips%y0(i) + 0.5_wp*leaves(i)*strips%y1)
         width(i) = strips%width(i)*step(i)*strips%l(i)
         area = 0.5_wp*width(i)*s(i)
         gx = strips%x0(i) + y(i)*strips%x1
         gy = strips%y0(i) + y(i)*strips%y1
         factor = area*strips%bound(i)*s(i)/max(sqrt(gx*gx + gy*gy + rest), least)
         place = strips%front(i) + y(i)
         strips%sliding(i, 1) = strips%sliding(i, 1) + factor*gx
         strips%sliding(i, 2) = strips%sliding(i, 2) + factor*gy
         strips%sliding(i, 3) = strips%sliding(i, 3) + factor*(place*gy - strips%eta(i)*gx)
         strips%tractions(i, 1) = strips%tractions(i, 1) + area*x(i)
         strips%tractions(i, 2) = strips%tractions(i, 2) + area*z(i)
         strips%tractions(i, 3) = strips%tractions(i, 3) + area*(place*z(i) - strips%eta(i)*x(i))
      end do
      do j = 1, n - 1
         do i = 1, n_strips
            before = c(i)
            c(i) = before*turn_c(i) - s(i)*turn_s(i)
            s(i) = s(i)*turn_c(i) + before*turn_s(i)
            way = strips%l(i)*(1.0_wp - c(i)) - y(i)
            gx = strips%x0(i) + (y(i) + 0.5_wp*way)*strips%x1
            gy = strips%y0(i) + (y(i) + 0.5_wp*way)*strips%y1
            y(i) = y(i) + way
            place = strips%front(i) + y(i)
            bound = strips%bound(i)*s(i)
            area = width(i)*s(i)
            factor = area*bound/max(sqrt(gx*gx + gy*gy + rest), least)
            strips%sliding(i, 1) = strips%sliding(i, 1) + factor*gx
            strips%sliding(i, 2) = strips%sliding(i, 2) + factor*gy
            strips%sliding(i, 3) = strips%sliding(i, 3) + factor*(place*gy - strips%eta(i)*gx)
            x(i) = x(i) + way*gx
            z(i) = z(i) + way*gy
            bound = max(bound*strips%rolls, least)
            factor = cut(max(sqrt(x(i)*x(i) + z(i)*z(i)), least)/bound, corner)
            x(i) = factor*x(i)
            z(i) = factor*z(i)
            strips%tractions(i, 1) = strips%tractions(i, 1) + area*x(i)
            strips%tractions(i, 2) = strips%tractions(i, 2) + area*z(i)
            strips%tractions(i, 3) = strips%tractions(i, 3) + area*(place*z(i) &
               - strips%eta(i)*x(i))
         end do
      end do
   end subroutine slip

   !> Way from the inlet up to where a strip surely sticks: the smallest root in (0, 2 l] of
   !> |g0 + g1 y/2|^2 y - k^2 (2 l - y). As that root jumps where a maximum of the cubic rises
   !> through zero, it is drawn to the one of the cubic raised by a part of its range, which has
   !> jumped before it is drawn to.
   pure real(wp) function first_slip(strip, k) result(y)
      type(strip_type), intent(in) :: strip
      !> f p0 V/l0.
      real(wp), intent(in) :: k
      real(wp) :: a(0:3), peak, turning, top, slope, drawn, inverse

      a(3) = 0.25_wp*(strip%g1(1)**2 + strip%g1(2)**2)
      a(2) = strip%g0(1)*strip%g1(1) + strip%g0(2)*strip%g1(2)
      a(1) = strip%g0(1)**2 + strip%g0(2)**2 + k*k
      a(0) = -2.0_wp*strip%l*k*k
      peak = 2.0_wp*strip%l
      drawn = 0.0_wp
      if (a(2) < 0.0_wp) then
         ! The maximum, or where the cubic is flattest.
         turning = a(2)*a(2) - 3.0_wp*a(3)*a(1)
         if (turning > 0.0_wp) then
            peak = a(1)/(sqrt(turning) - a(2))
         else
            peak = -a(2)/(3.0_wp*a(3))
         end if
         if (peak < 2.0_wp*strip%l) then
            ! How far from zero that is, and how steep, over the range of the cubic.
            slope = max(a(1) + peak*(2.0_wp*a(2) + 3.0_wp*peak*a(3)), 0.0_wp)
            top = a(0) + peak*(a(1) + peak*(a(2) + peak*a(3)))
            drawn = smooth_step(-abs((top - strip%l*slope*slope/(slope + flat*a(1))) &
               /min(a(0), -tiny(a))), [-deep, 0.0_wp])
            ! No more where the maximum leaves by the outlet; its place without the root, whose
            ! slope has no bound where maxima come and go.
            inverse = turning/max(sqrt(max(turning, 0.0_wp) + (at_birth*a(2))**2), least) - a(2)
            if (a(1) < 2.0_wp*strip%l*inverse) then
               drawn = drawn*smooth_step(2.0_wp - a(1)/(strip%l*inverse), [0.0_wp, deep])
            else
               drawn = 0.0_wp
            end if
         end if
         peak = min(peak, 2.0_wp*strip%l)
      end if
      y = root_of(a, peak, 2.0_wp*strip%l)
      if (.not. drawn > 0.0_wp) return
      a(0) = (1.0_wp - deep)*a(0)
      y = y - drawn*(y - root_of(a, peak, 2.0_wp*strip%l))
   end function first_slip

   !> Smallest root of a cubic that begins below zero, by Newton's method within bounds.
   pure real(wp) function root_of(a, peak, last) result(y)
      !> Its coefficients.
      real(wp), intent(in) :: a(0:3)
      !> Its maximum, or where it is flattest.
      real(wp), intent(in) :: peak
      !> Where it is not below zero any more.
      real(wp), intent(in) :: last
      real(wp) :: low, high, f, slope, next
      integer :: i

      low = 0.0_wp
      high = last
      if (peak < last) then
         if (a(0) + peak*(a(1) + peak*(a(2) + peak*a(3))) < 0.0_wp) then
            low = peak
         else
            high = peak
         end if
      end if
      y = min(max(-a(0)/a(1), low), high)
      do i = 1, 60
         f = a(0) + y*(a(1) + y*(a(2) + y*a(3)))
         if (f > 0.0_wp) then
            high = y
         else
            low = y
         end if
         slope = a(1) + y*(2.0_wp*a(2) + 3.0_wp*y*a(3))
         next = 0.5_wp*(low + high)
         if (abs(slope) > 0.0_wp) then
            ! Before the bounds: one of them is y by now.
            if (abs(f) <= 4.0_wp*epsilon(y)*y*abs(slope)) exit
            if (y - f/slope > low .and. y - f/slope < high) next = y - f/slope
         end if
         if (abs(next - y) <= 4.0_wp*epsilon(y)*y) exit
         y = next
      end do
   end function root_of

end module contensou_contact_creep_brush
