!> A chord of a curved spot: the integral of the friction along it. The quadrature of the spot over
!> its chords is `contensou_contact_wrench_curved`; derivation, accuracy and cost:
!> docs/curved_spot.md.
!>
!> On a chord the integrand is analytic but for the zeros of a quadratic polynomial with complex
!> coefficients, which are known: a map of the chord keeps them away from the nodes. All nodes have
!> positive weights and the same for all components.
module contensou_contact_wrench_curved_chord
   use contensou_base_kinds, only : pi, wp
   use contensou_special_quadrature, only : w_4, w_6, w_8, x_4, x_6, x_8
   implicit none(type, external)
   private

   public :: field_type, n_all, n_wrench, add_chord, add_chord_of_eight, set_panel, solve

   !> Components along q and across it, drilling torque, moments by q along and across it; then the
   !> upper triangle of the derivatives, row by row.
   integer, parameter :: n_wrench = 5, n_all = 20

   !> Nodes that are summed side by side.
   integer, parameter :: lanes = 2

   !> Nodes on a panel of a chord at most.
   integer, parameter :: n_chord = 16

   !> Distance of a zero from a chord, over half of its length, below which the slip is a jump.
   real(wp), parameter :: sharp = 1.0e-9_wp

   !> Distance from which on nothing is done for it.
   real(wp), parameter :: distant = 0.8_wp

   !> Distance of a zero from the middle of a chord from which on its other half has its own nodes.
   real(wp), parameter :: off_centre = 0.5_wp

   !> Constant of the pressure: sigma dA = factor N sqrt(1 - u^2 - x^2) du dx.
   real(wp), parameter :: factor = 1.5_wp/pi

   integer :: j_
   !> Gauss-Chebyshev rules of the second kind, their weights halved.
   real(wp), parameter :: x_whole_4(4) = [(cos(pi*j_/5), j_=1, 4)]
   real(wp), parameter :: w_whole_4(4) = [(0.5_wp*pi/5*sin(pi*j_/5)**2, j_=1, 4)]
   real(wp), parameter :: x_whole_8(8) = [(cos(pi*j_/9), j_=1, 8)]
   real(wp), parameter :: w_whole_8(8) = [(0.5_wp*pi/9*sin(pi*j_/9)**2, j_=1, 8)]
   real(wp), parameter :: x_whole_12(12) = [(cos(pi*j_/13), j_=1, 12)]
   real(wp), parameter :: w_whole_12(12) = [(0.5_wp*pi/13*sin(pi*j_/13)**2, j_=1, 12)]
   real(wp), parameter :: x_whole_16(16) = [(cos(pi*j_/17), j_=1, 16)]
   real(wp), parameter :: w_whole_16(16) = [(0.5_wp*pi/17*sin(pi*j_/17)**2, j_=1, 16)]

   !> A chord in units of half of its length.
   type :: chord_type
      !> Square of half of its length, and its weight.
      real(wp) :: r2, weight
      !> Slip along q: g(1) + g(2) x + g(3) x^2, across it: p(1) + p(2) x.
      real(wp) :: g(3), p(2)
      !> Rise: z(1) + z(2) x^2.
      real(wp) :: z(2)
      !> Coordinates t(1) + t(2) x along q and s(1) + s(2) x across it.
      real(wp) :: t(2), s(2)
   end type chord_type

   !> Slip in coordinates of the unit disc, x along the chords and u across them; the rise has no
   !> term x u, and changes least along the chords.
   type :: field_type
      !> Slip across q: p(1) + p(2) u + p(3) x.
      real(wp) :: p(3)
      !> Slip along q: g(1) + g(2) u + g(3) x + g(4) u^2 + g(5) x^2.
      real(wp) :: g(5)
      !> Rise: z(1) u^2 + z(2) x^2.
      real(wp) :: z(2)
      !> Coordinates t = t(1) u + t(2) x along q and s = s(1) u + s(2) x across it, in units of the
      !> major semi-axis.
      real(wp) :: t(2), s(2)
      !> Bound of the error.
      real(wp) :: tolerance
      !> Least part of the null rules that counts as an error where the integrand is smooth.
      real(wp) :: smallest
      !> Squares of the distance of singularities, as the sum of the semi-axes of the ellipse around
      !> a chord, from which on 4, 8, 12 and 16 nodes do.
      real(wp) :: far(4)
      !> Number of nodes on a panel of a chord, the nodes and their weights on (-1, 1).
      integer :: n_panel
      real(wp) :: x_panel(n_chord), w_panel(n_chord)
      !> Largest ratio of the ends of a panel in the mapped variable.
      real(wp) :: span
      !> Whether the chords follow the slip, whether there are more of them until the error is below
      !> its bound, and whether they are flat.
      logical :: mapped, adaptive, slender
      logical :: with_jacobian
   end type field_type

contains

   !> Nodes on a panel of a chord. The singularities are on an ellipse around the panel whose
   !> semi-axes have a sum of 3.2, where panels are wide 2.2, or more, if the slip has no other
   !> zero near: an error of 3.2**(-2 n).
   pure subroutine set_panel(tolerance, field)
      real(wp), intent(in) :: tolerance
      type(field_type), intent(inout) :: field

      field%span = merge(16.0_wp, 64.0_wp, field%adaptive)
      if (tolerance >= 1.0e-5_wp) then
         field%n_panel = 8
         field%x_panel(:8) = [-x_4, x_4]
         field%w_panel(:8) = [w_4, w_4]
      else if (tolerance >= 1.0e-7_wp) then
         field%n_panel = 12
         field%x_panel(:12) = [-x_6, x_6]
         field%w_panel(:12) = [w_6, w_6]
      else
         field%n_panel = 16
         field%x_panel = [-x_8, x_8]
         field%w_panel = [w_8, w_8]
      end if
   end subroutine set_panel

   !> Zeros of a + b x + c x^2 for complex a and b.
   pure subroutine solve(a, b, c, x, n)
      !> Real and imaginary parts.
      real(wp), intent(in) :: a(2), b(2)
      real(wp), intent(in) :: c
      !> Real and imaginary parts of each.
      real(wp), intent(out) :: x(2, 2)
      !> Their number; those far away do not count.
      integer, intent(out) :: n
      real(wp) :: re, im, norm

      call complex_root(b(1)*b(1) - b(2)*b(2) - 4.0_wp*a(1)*c, 2.0_wp*b(1)*b(2) - 4.0_wp*a(2)*c, &
         re, im)
      if (re*b(1) + im*b(2) < 0.0_wp) then
         re = -re
         im = -im
      end if
      re = -0.5_wp*(b(1) + re)
      im = -0.5_wp*(b(2) + im)
      norm = re*re + im*im
      n = 0
      if (.not. norm > 1.0e-200_wp) return
      n = 1
      x(:, 1) = [a(1)*re + a(2)*im, a(2)*re - a(1)*im]/norm
      if (.not. norm < 1.0e6_wp*c*c) return
      n = 2
      x(:, 2) = [re, im]/c
   end subroutine solve

   !> Where a chord lies, and the slip along it.
   pure subroutine set_chord(field, u, chord)
      type(field_type), intent(in) :: field
      real(wp), intent(in) :: u
      type(chord_type), intent(out) :: chord
      real(wp) :: r

      chord%r2 = (1.0_wp - u)*(1.0_wp + u)
      r = sqrt(chord%r2)
      chord%g = [field%g(1) + (field%g(2) + field%g(4)*u)*u, field%g(3)*r, field%g(5)*chord%r2]
      chord%p = [field%p(1) + field%p(2)*u, field%p(3)*r]
      chord%z = [field%z(1)*u*u, field%z(2)*chord%r2]
      chord%t = [field%t(1)*u, field%t(2)*r]
      chord%s = [field%s(1)*u, field%s(2)*r]
   end subroutine set_chord

   !> Add the integrals along a chord to the sums.
   pure subroutine add_chord(field, u, weight, sums)
      type(field_type), intent(in) :: field
      real(wp), intent(in) :: u
      !> Weight of the chord, du.
      real(wp), intent(in) :: weight
      real(wp), intent(inout) :: sums(n_all)
      type(chord_type) :: chord
      real(wp) :: a(2), b(2), c, zero(2, 2), tau(2, 2), far, middle
      integer :: n, k

      call set_chord(field, u, chord)
      if (.not. chord%r2 > 0.0_wp) return
      chord%weight = 2.0_wp*factor*chord%r2*weight
      ! Zeros of a + b x + c x^2, the slip along q and i times that across it.
      a = [chord%g(1), chord%p(1)]
      b = [chord%g(2), chord%p(2)]
      c = chord%g(3)
      call solve(a, b, c, zero, n)
      do k = 1, n
         call to_tau(zero(1, k), zero(2, k), tau(:, k))
      end do
      far = huge(far)
      do k = 1, n
         far = min(far, ((1.0_wp + tau(2, k))**2 + tau(1, k)**2) &
            /max((1.0_wp - tau(2, k))**2 + tau(1, k)**2, 1.0e-30_wp))
      end do
      if (far >= field%far(4)) then
         if (far >= field%far(1)) then
            call add_whole(field, chord, 4, x_whole_4, w_whole_4, sums)
         else if (far >= field%far(2)) then
            call add_whole(field, chord, 8, x_whole_8, w_whole_8, sums)
         else if (far >= field%far(3)) then
            call add_whole(field, chord, 12, x_whole_12, w_whole_12, sums)
         else
            call add_whole(field, chord, 16, x_whole_16, w_whole_16, sums)
         end if
      else if (n == 2) then
         if (tau(1, 1) > tau(1, 2)) tau = tau(:, [2, 1])
         if (tau(1, 2) - tau(1, 1) < 0.5_wp*max(tau(2, 1), tau(2, 2))) then
            ! The lower one also keeps away what is above it.
            if (tau(2, 2) < tau(2, 1)) tau(:, 1) = tau(:, 2)
            call add_wing(field, chord, -1.0_wp, 1.0_wp, tau(:, 1), sums)
         else
            middle = 0.5_wp*(tau(1, 1) + tau(1, 2))
            call add_wing(field, chord, -1.0_wp, middle, tau(:, 1), sums)
            call add_wing(field, chord, middle, 1.0_wp, tau(:, 2), sums)
         end if
      else
         call add_wing(field, chord, -1.0_wp, 1.0_wp, tau(:, 1), sums)
      end if
   end subroutine add_chord

   !> Add a chord with 8 nodes wherever the slip vanishes.
   pure subroutine add_chord_of_eight(field, u, weight, sums)
      type(field_type), intent(in) :: field
      real(wp), intent(in) :: u
      !> Weight of the chord, du.
      real(wp), intent(in) :: weight
      real(wp), intent(inout) :: sums(n_all)
      type(chord_type) :: chord

      call set_chord(field, u, chord)
      chord%weight = 2.0_wp*factor*chord%r2*weight
      call add_whole(field, chord, 8, x_whole_8, w_whole_8, sums)
   end subroutine add_chord_of_eight

   !> Square root of a complex number, its real part >= 0.
   pure subroutine complex_root(x, y, re, im)
      real(wp), intent(in) :: x, y
      real(wp), intent(out) :: re, im
      real(wp) :: s

      s = sqrt(0.5_wp*(sqrt(x*x + y*y) + abs(x)))
      re = s
      im = 0.0_wp
      if (s > 0.0_wp) im = 0.5_wp*y/s
      if (x < 0.0_wp) then
         re = abs(im)
         im = sign(s, y)
      end if
   end subroutine complex_root

   !> tan(phi/2) where sin(phi) = re + i im: the one in the unit circle, above the axis.
   pure subroutine to_tau(re, im, tau)
      real(wp), intent(in) :: re, im
      real(wp), intent(out) :: tau(2)
      real(wp) :: c, s, norm

      call complex_root((1.0_wp - re)*(1.0_wp + re) + im*im, -2.0_wp*re*im, c, s)
      c = 1.0_wp + c
      norm = 1.0_wp/(c*c + s*s)
      tau(1) = (re*c + im*s)*norm
      tau(2) = abs((im*c - re*s)*norm)
   end subroutine to_tau

   !> Add a whole chord where the slip is smooth.
   pure subroutine add_whole(field, chord, n, x, w, sums)
      type(field_type), intent(in) :: field
      type(chord_type), intent(in) :: chord
      integer, intent(in) :: n
      !> Nodes and weights.
      real(wp), intent(in) :: x(n), w(n)
      real(wp), intent(inout) :: sums(n_all)
      real(wp) :: nodes(n_chord), weights(n_chord)

      nodes(:n) = x
      weights(:n) = w
      call add_nodes(field, chord, n, nodes, weights, sums)
   end subroutine add_whole

   !> Add a part of a chord, from tau = low to high, with zeros of the slip at zero(1) +- i zero(2).
   pure subroutine add_wing(field, chord, low, high, zero, sums)
      type(field_type), intent(in) :: field
      type(chord_type), intent(in) :: chord
      real(wp), intent(in) :: low, high
      real(wp), intent(in) :: zero(2)
      real(wp), intent(inout) :: sums(n_all)

      if (.not. high > low) return
      ! The map would bring the poles of x at tau = +-i closer to what is far from the zeros.
      if (zero(1) > off_centre .and. low < 0.0_wp .and. high > 0.0_wp) then
         call add_plain(field, chord, low, 0.0_wp, sums)
         call add_mapped_wing(field, chord, 0.0_wp, high, zero, sums)
      else if (zero(1) < -off_centre .and. low < 0.0_wp .and. high > 0.0_wp) then
         call add_mapped_wing(field, chord, low, 0.0_wp, zero, sums)
         call add_plain(field, chord, 0.0_wp, high, sums)
      else
         call add_mapped_wing(field, chord, low, high, zero, sums)
      end if
   end subroutine add_wing

   !> Add a part of a chord with nodes that are dense near the zeros; x = 2 tau/(1 + tau^2).
   pure subroutine add_mapped_wing(field, chord, low, high, zero, sums)
      type(field_type), intent(in) :: field
      type(chord_type), intent(in) :: chord
      real(wp), intent(in) :: low, high
      real(wp), intent(in) :: zero(2)
      real(wp), intent(inout) :: sums(n_all)
      real(wp) :: z, y(2), ratio, root, slope, centre, middle
      real(wp) :: top(n_chord), bottom(n_chord), measure(n_chord), u, v
      integer :: panels, i, k

      if (zero(2) >= distant) then
         call add_plain(field, chord, low, high, sums)
         return
      end if
      if (zero(2) < sharp) then
         middle = max(low, min(high, zero(1)))
         call add_plain(field, chord, low, middle, sums)
         call add_plain(field, chord, middle, high, sums)
         return
      end if
      ! tau = zero(1) + zero(2) (y - 1/y)/2.
      do k = 1, 2
         z = (merge(low, high, k == 1) - zero(1))/zero(2)
         y(k) = abs(z) + sqrt(z*z + 1.0_wp)
         if (z < 0.0_wp) y(k) = 1.0_wp/y(k)
      end do
      ratio = y(2)/y(1)
      panels = 1
      root = field%span
      do while (ratio > root)
         panels = panels + 1
         root = root*field%span
      end do
      if (panels > 1) ratio = ratio**(1.0_wp/panels)
      root = sqrt(ratio)
      slope = (root - 1.0_wp)/(root + 1.0_wp)
      centre = y(1)*root
      do k = 1, panels
         ! tau = top/bottom at y = centre (1 + v)/(1 - v), v = slope x.
         do i = 1, field%n_panel
            v = slope*field%x_panel(i)
            bottom(i) = (1.0_wp - v)*(1.0_wp + v)
            u = centre*(1.0_wp + v)**2
            z = (1.0_wp - v)**2/centre
            top(i) = zero(1)*bottom(i) + 0.5_wp*zero(2)*(u - z)
            measure(i) = zero(2)*slope*field%w_panel(i)*(u + z)
         end do
         call add_mapped(field, chord, top, bottom, measure, sums)
         centre = centre*ratio
      end do
   end subroutine add_mapped_wing

   !> Add a part of a chord where the slip is smooth.
   pure subroutine add_plain(field, chord, low, high, sums)
      type(field_type), intent(in) :: field
      type(chord_type), intent(in) :: chord
      real(wp), intent(in) :: low, high
      real(wp), intent(inout) :: sums(n_all)
      real(wp) :: half, top(n_chord), bottom(n_chord), measure(n_chord)
      integer :: i

      half = 0.5_wp*(high - low)
      if (.not. half > 0.0_wp) return
      do i = 1, field%n_panel
         top(i) = low + half*(1.0_wp + field%x_panel(i))
         bottom(i) = 1.0_wp
         measure(i) = half*field%w_panel(i)
      end do
      call add_mapped(field, chord, top, bottom, measure, sums)
   end subroutine add_plain

   !> Add nodes tau = top/bottom of a chord.
   pure subroutine add_mapped(field, chord, top, bottom, measure, sums)
      type(field_type), intent(in) :: field
      type(chord_type), intent(in) :: chord
      !> Numerators and denominators, and dtau times the squares of these.
      real(wp), dimension(n_chord), intent(in) :: top, bottom, measure
      real(wp), intent(inout) :: sums(n_all)
      real(wp), dimension(n_chord) :: x, weight
      real(wp) :: inverse
      integer :: i

      do i = 1, field%n_panel
         inverse = 1.0_wp/(bottom(i)*bottom(i) + top(i)*top(i))
         x(i) = 2.0_wp*top(i)*bottom(i)*inverse
         weight(i) = measure(i)*((bottom(i) - top(i))*(bottom(i) + top(i)))**2*inverse**3
      end do
      call add_nodes(field, chord, field%n_panel, x, weight, sums)
   end subroutine add_mapped

   !> Add what the nodes of a chord contribute to the sums.
   pure subroutine add_nodes(field, chord, n, x, weights, sums)
      type(field_type), intent(in) :: field
      type(chord_type), intent(in) :: chord
      !> Number of nodes, a multiple of the lanes.
      integer, intent(in) :: n
      !> Nodes and weights; there is room for more.
      real(wp), intent(in) :: x(n_chord), weights(n_chord)
      real(wp), intent(inout) :: sums(n_all)
      !> Sums of the parts along q and across it times 1, x and x^2.
      real(wp) :: parts(lanes, 6), along, across, w, y, m(6)
      integer :: i, k

      if (field%with_jacobian) call add_node_slopes(chord, n, x, weights, sums)
      parts = 0.0_wp
      do i = 0, n - lanes, lanes
         do k = 1, lanes
            y = x(i + k)
            along = chord%g(1) + (chord%g(2) + chord%g(3)*y)*y
            across = chord%p(1) + chord%p(2)*y
            ! Nothing acts where nothing slips.
            w = weights(i + k)/sqrt(along*along + across*across + tiny(along))
            along = along*w
            across = across*w
            parts(k, 1) = parts(k, 1) + along
            parts(k, 2) = parts(k, 2) + across
            along = along*y
            across = across*y
            parts(k, 3) = parts(k, 3) + along
            parts(k, 4) = parts(k, 4) + across
            parts(k, 5) = parts(k, 5) + along*y
            parts(k, 6) = parts(k, 6) + across*y
         end do
      end do
      do k = 1, 6
         m(k) = -chord%weight*(parts(1, k) + parts(2, k))
      end do
      associate (t => chord%t, s => chord%s, z => chord%z)
         sums(1) = sums(1) + m(1)
         sums(2) = sums(2) + m(2)
         sums(3) = sums(3) + ((t(1)*m(2) + t(2)*m(4)) - (s(1)*m(1) + s(2)*m(3)))
         sums(4) = sums(4) + (z(1)*m(1) + z(2)*m(5))
         sums(5) = sums(5) + (z(1)*m(2) + z(2)*m(6))
      end associate
   end subroutine add_nodes

   !> Add the derivatives at the nodes of a chord.
   pure subroutine add_node_slopes(chord, n, x, weights, sums)
      type(chord_type), intent(in) :: chord
      integer, intent(in) :: n
      !> Nodes and weights; there is room for more.
      real(wp), intent(in) :: x(n_chord), weights(n_chord)
      real(wp), intent(inout) :: sums(n_all)
      real(wp) :: along, across, inverse
      integer :: i

      do i = 1, n
         along = chord%g(1) + (chord%g(2) + chord%g(3)*x(i))*x(i)
         across = chord%p(1) + chord%p(2)*x(i)
         inverse = -1.0_wp/sqrt(along*along + across*across + tiny(along))
         call add_slopes(chord%weight*weights(i)*inverse**3, along, across, &
            chord%s(1) + chord%s(2)*x(i), chord%t(1) + chord%t(2)*x(i), &
            chord%z(1) + chord%z(2)*x(i)*x(i), sums)
      end do
   end subroutine add_node_slopes

   !> Add the derivatives at a node.
   pure subroutine add_slopes(weight, along, across, s, t, z, sums)
      !> Minus the weight over the cube of the slip.
      real(wp), intent(in) :: weight
      !> Slip along q and across it, coordinates, rise.
      real(wp), intent(in) :: along, across, s, t, z
      real(wp), intent(inout) :: sums(n_all)
      real(wp) :: d(5), f
      integer :: j, k, m

      ! The change of the slip across itself by that of each velocity.
      d = [across, -along, -s*across - t*along, z*across, -z*along]
      m = n_wrench
      do j = 1, 5
         f = weight*d(j)
         do k = j, 5
            m = m + 1
            sums(m) = sums(m) + f*d(k)
         end do
      end do
   end subroutine add_slopes

end module contensou_contact_wrench_curved_chord
