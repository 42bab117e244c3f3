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
module contensou_contact_creep_brush
   use contensou_base_kinds, only : pi, wp
   use contensou_contact_catalogue, only : model_info_type
   use contensou_contact_creep_bounds, only : confine
   use contensou_contact_creep_law, only : creep_model_type, creep_motion_type, creep_spot_type, &
      creep_type
   use contensou_contact_creep_strips, only : flow_type, new_flow, strip_at, strip_type, to_axes
   use contensou_contact_parameters, only : parameters_type
   use contensou_contact_wrench, only : slip_type, wrench_exact
   use contensou_special_quadrature, only : w_6, x_6
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

   integer :: index

   !> Places of the strips across, in half-widths, their lengths in that of the middle one, and
   !> weights.
   real(wp), parameter :: places(n_strips) = [(sin(0.5_wp*pi*x_strips(index)), &
      index=1, n_strips)]
   real(wp), parameter :: shares(n_strips) = [(cos(0.5_wp*pi*x_strips(index)), &
      index=1, n_strips)]
   real(wp), parameter :: weights(n_strips) = 0.5_wp*pi*w_strips*shares

   !> How deep below zero, over its range, a maximum of the cubic has no part in where steps begin.
   real(wp), parameter :: deep = 0.3_wp

   !> Square of the tau at which half of the flexibilities is blended.
   real(wp), parameter :: blend = 36.0_wp

   !> Over tau^2: how the linear torque fades, as the slope of F without spin.
   real(wp), parameter :: fade = (0.25_wp*pi)**2

   !> Parameters of the correction.
   real(wp), parameter :: q0 = 0.222_wp, q1 = 0.0258_wp, q2 = 0.0402_wp, q3 = 6.60_wp

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
      real(wp) :: tractions(3), sliding(3), missing
      integer :: i

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
            *(third(2)*(1.0_wp + slope**2) - third(1)*slope) - (1.5_wp/pi)*root_k*(c(1, 3)*u(1) &
            + c(2, 3)*u(2) + root_k*c(3, 3)*spin)
         gamma = moves2 + turns2
         if (.not. gamma > 0.0_wp) return
         gamma = gamma/(gamma + blend*rolls**2)
         moves = sqrt(moves2/(rolls**2 + moves2/most**2))
         turns = sqrt(turns2/(rolls**2 + turns2/most**2))
         factor = 1.0_wp - q0*moves/((1.0_wp + moves)*(1.0_wp + q3*turns)) &
            + moves**2*(q1 + q2*moves**2)/(1.0_wp + q3*turns)
         single = factor*gamma*0.5_wp*(m(1, 1) + m(2, 2))
         m = factor*(1.0_wp - gamma)*m
         m(1, 1) = m(1, 1) + single
         m(2, 2) = m(2, 2) + single
         flow%m = m
         third = factor*(1.0_wp - gamma)*third
         third(2) = third(2) + single
         tractions = 0.0_wp
         sliding = 0.0_wp
         do i = 1, n_strips
            call roll(strip_at(flow, spin, places(i), shares(i)), flow%p0/l0, rolls, &
               h*weights(i), tractions, sliding)
         end do
         ! -tractions, and what the quadrature misses of full sliding.
         wrench = gamma*wrench + to_axes(flow, gamma*sliding - tractions)
         wrench(3) = wrench(3) + missing*rolls*(rolls/(rolls**2 + fade*(moves2 + turns2 &
            + 4.0_wp*missing**2/k)))**2
      end associate
      call confine(spot, motion, wrench)
   end subroutine kernel

   !> Add the tractions of a strip, and those of full sliding.
   pure subroutine roll(strip, k, rolls, weight, tractions, sliding)
      type(strip_type), intent(in) :: strip
      !> f p0/l0, V > 0, and the width of the strip.
      real(wp), intent(in) :: k, rolls, weight
      !> Sums of t and its moment; of f p g/|g| and its moment.
      real(wp), intent(inout) :: tractions(3), sliding(3)
      real(wp) :: leaves, y, angle, step, ph(2), half(2), t(2), g(2), size2
      integer :: i

      leaves = first_slip(strip, k*rolls)
      ! What sticks: two nodes are exact for a cubic.
      do i = -1, 1, 2
         y = 0.5_wp*leaves*(1.0_wp + real(i, wp)*root_3)
         t = strip%g0 + 0.5_wp*y*strip%g1
         call add(strip, 0.5_wp*weight*leaves*y/rolls, y, t, tractions)
      end do
      ph(1) = max(1.0_wp - leaves/strip%l, -1.0_wp)
      ph(2) = sqrt((1.0_wp - ph(1))*(1.0_wp + ph(1)))
      angle = atan2(ph(2), ph(1))
      step = angle/real(n_stick, wp)
      half = [cos(0.5_wp*step), sin(0.5_wp*step)]
      ph = [1.0_wp, 0.0_wp]
      do i = 1, n_stick
         ph = later(ph, half)
         y = strip%l*(1.0_wp - ph(1))
         g = strip%g0 + y*strip%g1
         size2 = g(1)**2 + g(2)**2
         if (size2 > 0.0_wp) call add(strip, weight*step*k*(strip%l*ph(2))**2/sqrt(size2), y, g, &
            sliding)
         ph = later(ph, half)
      end do
      ! What slips, or sticks again, with an error in proportion to the step.
      call slip(strip, k, rolls, -weight, leaves, angle, n_slip, tractions, sliding)
      call slip(strip, k, rolls, 2.0_wp*weight, leaves, angle, 2*n_slip, tractions, sliding)
   end subroutine roll

   !> Add the tractions of a strip from where it slips first.
   pure subroutine slip(strip, k, rolls, weight, leaves, first, n, tractions, sliding)
      type(strip_type), intent(in) :: strip
      !> f p0/l0, V, and the width of the strip.
      real(wp), intent(in) :: k, rolls, weight
      !> Where that is: the way from the inlet, and ph.
      real(wp), intent(in) :: leaves, first
      !> Number of steps.
      integer, intent(in) :: n
      !> Sums of t and its moment; of f p g/|g| and its moment.
      real(wp), intent(inout) :: tractions(3), sliding(3)
      real(wp) :: step, y, way, bound, area, size2, turn(2), ph(2), t(2), g(2)
      integer :: i

      step = (pi - first)/real(n, wp)
      turn = [cos(step), sin(step)]
      ph = [cos(first), sin(first)]
      y = leaves
      ! V t.
      t = leaves*(strip%g0 + 0.5_wp*leaves*strip%g1)
      area = 0.5_wp*weight*step*strip%l*ph(2)
      call add(strip, area/rolls, y, t, tractions)
      g = strip%g0 + y*strip%g1
      size2 = g(1)**2 + g(2)**2
      if (size2 > 0.0_wp) call add(strip, area*k*strip%l*ph(2)/sqrt(size2), y, g, sliding)
      do i = 1, n - 1
         ph = later(ph, turn)
         way = strip%l*(1.0_wp - ph(1)) - y
         g = strip%g0 + (y + 0.5_wp*way)*strip%g1
         y = y + way
         t = t + way*g
         bound = k*strip%l*ph(2)
         area = weight*step*strip%l*ph(2)
         size2 = g(1)**2 + g(2)**2
         if (size2 > 0.0_wp) call add(strip, area*bound/sqrt(size2), y, g, sliding)
         size2 = t(1)**2 + t(2)**2
         bound = bound*rolls
         if (size2 > bound**2) t = (bound/sqrt(size2))*t
         call add(strip, area/rolls, y, t, tractions)
      end do
   end subroutine slip

   !> Cosine and sine of the sum of two angles.
   pure function later(ph, turn) result(sum_of)
      real(wp), intent(in) :: ph(2), turn(2)
      real(wp) :: sum_of(2)

      sum_of = [ph(1)*turn(1) - ph(2)*turn(2), ph(2)*turn(1) + ph(1)*turn(2)]
   end function later

   !> Add a traction and its moment.
   pure subroutine add(strip, area, y, t, sums)
      type(strip_type), intent(in) :: strip
      real(wp), intent(in) :: area
      !> Way from the inlet.
      real(wp), intent(in) :: y
      real(wp), intent(in) :: t(2)
      real(wp), intent(inout) :: sums(3)

      sums(1) = sums(1) + area*t(1)
      sums(2) = sums(2) + area*t(2)
      sums(3) = sums(3) + area*((strip%xi - strip%l + y)*t(2) - strip%eta*t(1))
   end subroutine add

   !> Way from the inlet up to where a strip surely sticks: the smallest root in (0, 2 l] of
   !> |g0 + g1 y/2|^2 y - k^2 (2 l - y), by Newton's method within bounds. As that root jumps where
   !> a maximum of the cubic rises through zero, it is drawn to a maximum before it that is near
   !> zero.
   pure real(wp) function first_slip(strip, k) result(y)
      type(strip_type), intent(in) :: strip
      !> f p0 V/l0.
      real(wp), intent(in) :: k
      real(wp) :: a0, a1, a2, a3, low, high, f, slope, turning, next, peak, depth
      integer :: i

      a3 = 0.25_wp*(strip%g1(1)**2 + strip%g1(2)**2)
      a2 = strip%g0(1)*strip%g1(1) + strip%g0(2)*strip%g1(2)
      a1 = strip%g0(1)**2 + strip%g0(2)**2 + k*k
      a0 = -2.0_wp*strip%l*k*k
      low = 0.0_wp
      high = 2.0_wp*strip%l
      ! The maximum, or where the cubic is flattest; and how far below zero and how steep, over its
      ! range.
      peak = high
      depth = 1.0_wp
      if (a2 < 0.0_wp) then
         turning = a2*a2 - 3.0_wp*a3*a1
         if (turning > 0.0_wp) then
            peak = a1/(sqrt(turning) - a2)
         else
            peak = -a2/(3.0_wp*a3)
         end if
         if (peak < high) then
            f = a0 + peak*(a1 + peak*(a2 + peak*a3))
            if (f >= 0.0_wp) then
               high = peak
            else
               low = peak
               depth = (f - strip%l*max(a1 + peak*(2.0_wp*a2 + 3.0_wp*peak*a3), 0.0_wp)) &
                  /min(a0, -tiny(a0))
            end if
         end if
      end if
      y = min(max(-a0/a1, low), high)
      do i = 1, 60
         f = a0 + y*(a1 + y*(a2 + y*a3))
         if (f > 0.0_wp) then
            high = y
         else
            low = y
         end if
         slope = a1 + y*(2.0_wp*a2 + 3.0_wp*y*a3)
         next = 0.5_wp*(low + high)
         if (abs(slope) > 0.0_wp) then
            ! Before the bounds: one of them is y by now.
            if (abs(f) <= 4.0_wp*epsilon(y)*y*abs(slope)) exit
            if (y - f/slope > low .and. y - f/slope < high) next = y - f/slope
         end if
         if (abs(next - y) <= 4.0_wp*epsilon(y)*y) exit
         y = next
      end do
      if (peak < y) y = y - (y - peak)*max(1.0_wp - depth/deep, 0.0_wp)**2
   end function first_slip

end module contensou_contact_creep_brush
