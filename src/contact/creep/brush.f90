!> Brush: strips along the flow of the material at any angle, with the exact bound f p of Hertz.
!>
!> In axes xi along c and eta across it the deflection of bristles gives the traction -t on body 1,
!>    V dt/dxi = g - lambda t,  |t| <= f p,  lambda >= 0,  lambda (|t| - f p) = 0,
!>    g = M u + w (-eta/L3 + xi/L13, xi/L3),
!> from t = 0 at the inlet on. M = (3 G/(8 l0)) (C11 C12; C12 C22), 1/L3 = 4 G C23 sqrt(ab)/ (pi
!> l0^2) and 1/L13, with C13, make the forces of small creep those of Kalker; l0 is the half-length
!> of the strip through the centre. With tau the linear wrench over f N they are blended into one
!> flexibility, gamma = tau^2/(tau^2 + 36), so that large creep slides as a rigid body does, and
!> multiplied by a correction fitted to solutions by boundary elements. What the torque of bristles
!> lacks of that of the linear theory, which is reciprocal, is added times 1/(1 + (pi tau/4)^2)^2.
!>
!> Where it sticks t is a quadratic along a strip, and it first slips at a root of a cubic. Where it
!> slips, for the rest of the strip, t = f p (cos th, sin th); with xi - xi_c = -l cos ph, V (f
!> p0/l0) dth/dph = g_eta cos th - g_xi sin th, by exponential midpoint steps, which are stable for
!> any V and tend to the direction of g for V = 0. What the quadrature misses of full sliding, times
!> gamma, is added: at V = 0 the wrench is the exact one.
module contensou_contact_creep_brush
   use contensou_base_kinds, only : pi, wp
   use contensou_contact_catalogue, only : model_info_type
   use contensou_contact_creep_law, only : creep_model_type, creep_motion_type, creep_spot_type, &
      creep_type
   use contensou_contact_kalker, only : kalker_matrix
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

   !> Number of strips, nodes where a strip sticks and steps where it slips.
   integer, parameter :: n_strips = 12, n_stick = 6, n_slip = 16

   !> Nodes on (-1, 1) and weights over the strips, and over what sticks.
   real(wp), parameter :: x_strips(n_strips) = [-x_6, x_6], w_strips(n_strips) = [w_6, w_6]
   real(wp), parameter :: root_3 = 0.577350269189625764509148780501957_wp

   !> Square of the tau at which half of the flexibilities is blended.
   real(wp), parameter :: blend = 36.0_wp

   !> Over tau^2: how the linear torque fades, as the slope of F without spin.
   real(wp), parameter :: fade = (0.25_wp*pi)**2

   !> Parameters of the correction.
   real(wp), parameter :: q0 = 0.222_wp, q1 = 0.0258_wp, q2 = 0.0402_wp, q3 = 6.60_wp

   !> Largest tau in the correction: beyond, all slips.
   real(wp), parameter :: most = 50.0_wp

   !> The deflection of a strip, g = g0 + g1 y at the way y from the inlet.
   type :: strip_type
      !> Half-length.
      real(wp) :: l
      !> Place of its centre along and across the flow.
      real(wp) :: xi, eta
      real(wp) :: g0(2), g1(2)
   end type strip_type

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
      type(strip_type) :: strip
      real(wp) :: rolls, ex, ey, u(2), m(2, 2), third(2), single, l0, h, slope, p0, gamma, factor
      real(wp) :: forces(2), moment, moves2, turns2, moves, turns, angle, root, weight
      real(wp) :: tractions(3), sliding(3), exact(3), c(3, 3), c_slope(3, 3), missing, power, root_k
      integer :: i

      call wrench_exact(spot%shape, slip_type(motion%x, motion%y, motion%spin), .true., exact)
      rolls = sqrt(motion%rx**2 + motion%ry**2)
      wrench = exact
      if (.not. rolls > 0.0_wp) return
      ex = motion%rx/rolls
      ey = motion%ry/rolls
      call kalker_matrix(spot%shape%k, spot%poisson, [-ex, -ey], c, c_slope)
      ! In the units a = 1, f N = 1, e0 = 1, in which G = f p0 and V = r.
      associate (k => spot%shape%k, ik2 => spot%shape%inverse_k2)
         p0 = 1.5_wp/(pi*k)
         root_k = sqrt(k)
         l0 = 1.0_wp/sqrt(ex*ex + ey*ey*ik2)
         h = k/l0
         slope = -ex*ey*(ik2 - 1.0_wp)*l0*l0
         u = [motion%x*ex + motion%y*ey, motion%y*ex - motion%x*ey]
         m = (3.0_wp*p0/(8.0_wp*l0))*reshape([c(1, 1), c(1, 2), c(1, 2), c(2, 2)], [2, 2])
         third = (4.0_wp*p0*root_k/(pi*l0*l0))*c(1:2, 3)
         forces = (8.0_wp/3.0_wp)*l0*k*matmul(m, u)
         moment = (8.0_wp/15.0_wp)*k*k*h*motion%spin*third(2)
         moves2 = forces(1)**2 + forces(2)**2
         forces = 0.25_wp*pi*l0*l0*k*motion%spin*third
         turns2 = forces(1)**2 + forces(2)**2 + 4.0_wp*moment**2/k
      end associate
      ! What the torque of bristles that all stick lacks of that of the linear theory.
      missing = 0.25_wp*pi*l0*l0*spot%shape%k*(m(2, 1)*u(1) + m(2, 2)*u(2)) + (8.0_wp/15.0_wp)*h* &
         spot%shape%k2*motion%spin*(third(2)*(1.0_wp + slope**2) - third(1)*slope) - (1.5_wp/pi)* &
         root_k*(c(1, 3)*u(1) + c(2, 3)*u(2) + root_k*c(3, 3)*motion%spin)
      gamma = moves2 + turns2
      if (.not. gamma > 0.0_wp) return
      gamma = gamma/(gamma + blend*rolls**2)
      moves = sqrt(moves2/(rolls**2 + moves2/most**2))
      turns = sqrt(turns2/(rolls**2 + turns2/most**2))
      factor = 1.0_wp - q0*moves/((1.0_wp + moves)*(1.0_wp + q3*turns)) &
         + moves**2*(q1 + q2*moves**2)/(1.0_wp + q3*turns)
      single = 0.5_wp*(m(1, 1) + m(2, 2))
      m = factor*(1.0_wp - gamma)*m
      m(1, 1) = m(1, 1) + factor*gamma*single
      m(2, 2) = m(2, 2) + factor*gamma*single
      third = factor*(1.0_wp - gamma)*third
      third(2) = third(2) + factor*gamma*single
      tractions = 0.0_wp
      sliding = 0.0_wp
      do i = 1, n_strips
         angle = 0.5_wp*pi*x_strips(i)
         root = cos(angle)
         strip%eta = h*sin(angle)
         strip%xi = slope*strip%eta
         strip%l = l0*root
         strip%g1 = motion%spin*third
         strip%g0 = matmul(m, u) + (strip%xi - strip%l)*strip%g1
         strip%g0(1) = strip%g0(1) - motion%spin*strip%eta*third(2)
         weight = 0.5_wp*pi*w_strips(i)*h*root
         call roll(strip, p0/l0, rolls, weight, tractions, sliding)
      end do
      ! -tractions, and what the quadrature misses of full sliding.
      tractions = gamma*sliding - tractions
      wrench = gamma*exact + [tractions(1)*ex - tractions(2)*ey, tractions(2)*ex + &
         tractions(1)*ey, tractions(3)]
      wrench(3) = wrench(3) + missing*rolls*(rolls/(rolls**2 + fade*(moves2 + turns2 + &
         4.0_wp*missing**2/spot%shape%k)))**2
      ! Three flexibilities may drive needles: what they would do is left out.
      power = wrench(1)*motion%x + wrench(2)*motion%y + wrench(3)*motion%spin
      if (power > 0.0_wp) wrench = wrench - power*(1.0_wp + 1.0e-10_wp)*[motion%x, motion%y, &
         motion%spin]/(motion%x**2 + motion%y**2 + motion%spin**2)
   end subroutine kernel

   !> Add the tractions of a strip, and those of full sliding.
   pure subroutine roll(strip, k, rolls, weight, tractions, sliding)
      type(strip_type), intent(in) :: strip
      !> f p0/l0.
      real(wp), intent(in) :: k
      !> Velocity of the material through the spot, > 0.
      real(wp), intent(in) :: rolls
      !> Width of the strip.
      real(wp), intent(in) :: weight
      !> Sums of t and its moment; of f p g/|g| and its moment.
      real(wp), intent(inout) :: tractions(3), sliding(3)
      real(wp) :: leaves, first, step, ph, y, t(2), g(2), g_size, unit(2), cosine, sine, half, share
      integer :: i

      leaves = first_slip(strip, k*rolls)
      ! What sticks: two nodes are exact for a cubic.
      do i = -1, 1, 2
         y = 0.5_wp*leaves*(1.0_wp + real(i, wp)*root_3)
         t = (y/rolls)*(strip%g0 + 0.5_wp*y*strip%g1)
         call add(0.5_wp*weight*leaves, y, t, tractions)
      end do
      first = acos(max(1.0_wp - leaves/strip%l, -1.0_wp))
      step = first/real(n_stick, wp)
      do i = 1, n_stick
         ph = step*(real(i, wp) - 0.5_wp)
         y = strip%l*(1.0_wp - cos(ph))
         g = strip%g0 + y*strip%g1
         g_size = norm2(g)
         if (g_size > 0.0_wp) call add(weight*step*k*(strip%l*sin(ph))**2, y, g/g_size, sliding)
      end do
      ! What slips.
      g = strip%g0 + 0.5_wp*leaves*strip%g1
      g_size = norm2(g)
      if (.not. g_size > 0.0_wp) return
      unit = g/g_size
      step = (pi - first)/real(n_slip, wp)
      do i = 1, n_slip
         ph = first + step*(real(i, wp) - 0.5_wp)
         y = strip%l*(1.0_wp - cos(ph))
         g = strip%g0 + y*strip%g1
         g_size = norm2(g)
         if (.not. g_size > 0.0_wp) cycle
         share = weight*step*k*(strip%l*sin(ph))**2
         half = 0.0_wp
         if (0.5_wp*g_size*step < 300.0_wp*k*rolls) half = exp(-0.5_wp*g_size*step/(k*rolls))
         g = g/g_size
         cosine = unit(1)*g(1) + unit(2)*g(2)
         sine = g(1)*unit(2) - g(2)*unit(1)
         ! The tangent of half the angle between t and g falls exponentially.
         sine = sine/max(1.0_wp + cosine, tiny(sine)**0.25_wp)
         unit = turned(g, half*sine)
         call add(share, y, unit, tractions)
         call add(share, y, g, sliding)
         unit = turned(g, half*half*sine)
      end do

   contains

      !> Add a traction and its moment.
      pure subroutine add(area, y, t, sums)
         real(wp), intent(in) :: area
         !> Way from the inlet.
         real(wp), intent(in) :: y
         real(wp), intent(in) :: t(2)
         real(wp), intent(inout) :: sums(3)

         sums(1:2) = sums(1:2) + area*t
         sums(3) = sums(3) + area*((strip%xi - strip%l + y)*t(2) - strip%eta*t(1))
      end subroutine add

   end subroutine roll

   !> A unit vector turned by an angle whose half has a given tangent.
   pure function turned(g, tangent) result(unit)
      real(wp), intent(in) :: g(2)
      real(wp), intent(in) :: tangent
      real(wp) :: unit(2)
      real(wp) :: scale, cosine, sine

      scale = 1.0_wp/(1.0_wp + tangent*tangent)
      cosine = (1.0_wp - tangent)*(1.0_wp + tangent)*scale
      sine = 2.0_wp*tangent*scale
      unit = [cosine*g(1) - sine*g(2), cosine*g(2) + sine*g(1)]
   end function turned

   !> Way from the inlet at which a strip slips first: the smallest root in (0, 2 l] of
   !> |g0 + g1 y/2|^2 y - k^2 (2 l - y), by Newton's method within bounds.
   pure real(wp) function first_slip(strip, k) result(y)
      type(strip_type), intent(in) :: strip
      !> f p0 V/l0.
      real(wp), intent(in) :: k
      real(wp) :: a0, a1, a2, a3, low, high, f, slope, turning, next
      integer :: i

      a3 = 0.25_wp*(strip%g1(1)**2 + strip%g1(2)**2)
      a2 = strip%g0(1)*strip%g1(1) + strip%g0(2)*strip%g1(2)
      a1 = strip%g0(1)**2 + strip%g0(2)**2 + k*k
      a0 = -2.0_wp*strip%l*k*k
      low = 0.0_wp
      high = 2.0_wp*strip%l
      ! A maximum of the cubic before its last root.
      turning = a2*a2 - 3.0_wp*a3*a1
      if (turning > 0.0_wp .and. a2 < 0.0_wp) then
         y = a1/(sqrt(turning) - a2)
         if (y < high) then
            if (a0 + y*(a1 + y*(a2 + y*a3)) >= 0.0_wp) then
               high = y
            else
               low = y
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
            if (y - f/slope > low .and. y - f/slope < high) next = y - f/slope
         end if
         if (abs(next - y) <= 4.0_wp*epsilon(y)*high) exit
         y = next
      end do
   end function first_slip

end module contensou_contact_creep_brush
