!> Friction wrench of a curved spot (Heathcote slip): exact Contensou-Erismann friction of the Hertz
!> pressure where points of the spot at different heights over its tangent plane slide against each
!> other though its centre rolls.
!>
!> The spot lies at the height z(r) = (1/2) r.L r over its tangent plane along the normal n, which
!> points from A into B, with L = (L_B - L_A)/2 the mean of the curvature forms of the two surfaces.
!> With q = w_t x n for the tangential part w_t of the angular velocity of B against A
!>    slip(r) = v + w n x r + z(r) q.
!> Force F, drilling torque T and the moment G by q are minus the derivatives of one potential,
!> Phi = f int sigma |slip| dA, by v, w and q; the tangential moment by w_t is M = n x G.
!> R. L. Heathcote, Proc. Inst. Automob. Eng. 15 (1920) 569; K. L. Johnson, Contact Mechanics,
!> 1985, section 8.5. Derivation, accuracy and cost: docs/curved_spot.md.
!>
!> Quadrature, in the coordinates of the unit disc: across q the slip is linear, along q quadratic.
!> On a chord the integrand is analytic but for the zeros of a quadratic polynomial with complex
!> coefficients, which are known: a map of the chord keeps them away from the nodes. Across the
!> chords there is a weak singularity where a point does not slip; on both sides of it Kronrod
!> rules are halved until their error is below the bound.
!>
!> All nodes have positive weights and the same for all components: the power that is lost,
!> -(F.v + T w + G.q), is a sum of positive terms, whatever the error.
!>
!> Near rest the wrench is regularised as the exact one: by W_e = sqrt(W^2 + d^2), d = k_x delta, in
!> Phi, which is even in W.
module contensou_contact_wrench_curved
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite, ieee_quiet_nan, ieee_value
   use contensou_base_kinds, only : pi, wp
   use contensou_contact_spot, only : spot_shape_type
   use contensou_contact_wrench_exact, only : wrench_exact, wrench_exact_jacobian
   use contensou_contact_wrench_scaling, only : slip_type
   use contensou_special_quadrature, only : w_12, w_8, x_12, x_8
   implicit none(type, external)
   private

   public :: coarsest, bend_type, wrench_curved, wrench_curved_jacobian

   !> How a spot is bent, and how fast that makes it slip.
   type :: bend_type
      !> Height of the spot over its tangent plane per square of the coordinates in units of the
      !> major semi-axis, a^2 L/2: components 11, 12, 22 along the major and the minor axis [m].
      real(wp) :: rise(3) = 0.0_wp
      !> q = w_t x n along the major and the minor axis [rad/s].
      real(wp) :: turning(2) = 0.0_wp
   end type bend_type

   !> Components along q and across it, drilling torque, moments by q along and across it; then the
   !> upper triangle of the derivatives, row by row.
   integer, parameter :: n_wrench = 5, n_all = 20

   !> Nodes on a panel of a chord.
   integer, parameter :: n_chord = 16

   !> Nodes and weights of the rule with 16 nodes on (-1, 1).
   real(wp), parameter :: x_chord(n_chord) = [-x_8, x_8], w_chord(n_chord) = [w_8, w_8]

   !> Nodes of the Kronrod rule with 15 nodes on (-1, 1), their weights, and those of the Gauss rule
   !> with 7 nodes, which are every other one. R. Piessens et al., QUADPACK (1983).
   integer, parameter :: n_outer = 15
   real(wp), parameter :: x_k(7) = [ &
      0.991455371120812639206854697526329_wp, 0.949107912342758524526189684047851_wp, &
      0.864864423359769072789712788640926_wp, 0.741531185599394439863864773280788_wp, &
      0.586087235467691130294144691693_wp, 0.405845151377397166906606412076961_wp, &
      0.207784955007898467600689403773245_wp]
   real(wp), parameter :: w_k(7) = [ &
      0.022935322010529224963732008058970_wp, 0.063092092629978553290700663189204_wp, &
      0.104790010322250183839876322541518_wp, 0.140653259715525918745189590510238_wp, &
      0.169004726639267902826583426598550_wp, 0.190350578064785409913256402421014_wp, &
      0.204432940075298892414161999234649_wp]
   real(wp), parameter :: w_g(3) = [ &
      0.129484966168869693270611432679082_wp, 0.279705391489276667901467771423780_wp, &
      0.381830050505118944950369775488975_wp]
   real(wp), parameter :: x_outer(n_outer) = [-x_k, 0.0_wp, x_k(7:1:-1)]
   real(wp), parameter :: w_outer(n_outer) = [w_k, 0.209482141084727828012999174891714_wp, &
      w_k(7:1:-1)]
   real(wp), parameter :: w_inner(n_outer) = [0.0_wp, w_g(1), 0.0_wp, w_g(2), 0.0_wp, w_g(3), &
      0.0_wp, 0.417959183673469387755102040816327_wp, 0.0_wp, w_g(3), 0.0_wp, w_g(2), 0.0_wp, &
      w_g(1), 0.0_wp]

   !> Smallest such distance.
   real(wp), parameter :: least_width = 1.0e-3_wp

   !> Halvings of a panel of chords at most.
   integer, parameter :: most_halvings = 24

   !> Ratio of the error of half a panel to that of the whole above which halving hardly helps.
   real(wp), parameter :: slow = 0.001_wp

   !> Ratio of the slip by curvature to the other one below which the spot is flat.
   real(wp), parameter :: flat = 1.0e-14_wp

   !> Distance of a zero from a chord, over half of its length, below which the slip is a jump.
   real(wp), parameter :: sharp = 1.0e-9_wp

   !> Distance from which on nothing is done for it.
   real(wp), parameter :: distant = 0.8_wp

   !> Distance of a zero from the middle of a chord from which on its other half has its own nodes.
   real(wp), parameter :: off_centre = 0.5_wp

   !> Ratio of the ends of a panel in the mapped variable.
   real(wp), parameter :: span = 16.0_wp

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

   !> Bound of the error from which on a product rule without refinement is taken.
   real(wp), parameter :: coarsest = 1.0e-3_wp

   !> Its nodes across the chords.
   real(wp), parameter :: x_product(24) = [-x_12, x_12], w_product(24) = [w_12, w_12]

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
      !> Squares of the distance of singularities, as the sum of the semi-axes of the ellipse around
      !> a chord, from which on 4, 8, 12 and 16 nodes do.
      real(wp) :: far(4)
      !> Whether the error is controlled.
      logical :: adaptive
      logical :: with_jacobian
   end type field_type

contains

   !> Wrench of a curved spot.
   pure subroutine wrench_curved(shape, slip, bend, tolerance, wrench, moment)
      type(spot_shape_type), intent(in) :: shape
      type(slip_type), intent(in) :: slip
      type(bend_type), intent(in) :: bend
      !> Bound of the error, in units of f N, > 0.
      real(wp), intent(in) :: tolerance
      !> Force along the major and the minor axis, in units of f N, and torque, of f N a.
      real(wp), intent(out) :: wrench(3)
      !> Moment G by q along the major and the minor axis, in units of f N m.
      real(wp), intent(out) :: moment(2)
      real(wp) :: unused(5, 5)

      call evaluate(shape, slip, bend, tolerance, .false., wrench, moment, unused)
   end subroutine wrench_curved

   !> Wrench of a curved spot and its derivatives.
   !>
   !> At rest without regularisation there is no derivative; wrench and Jacobian are then zero.
   pure subroutine wrench_curved_jacobian(shape, slip, bend, tolerance, wrench, moment, jacobian)
      type(spot_shape_type), intent(in) :: shape
      type(slip_type), intent(in) :: slip
      type(bend_type), intent(in) :: bend
      !> Bound of the error of the wrench, in units of f N, > 0.
      real(wp), intent(in) :: tolerance
      !> Force along the major and the minor axis, in units of f N, and torque, of f N a.
      real(wp), intent(out) :: wrench(3)
      !> Moment G by q along the major and the minor axis, in units of f N m.
      real(wp), intent(out) :: moment(2)
      !> Derivative of component i of (F_x, F_y, T, G_x, G_y) by j of (v_x, v_y, W, q_x, q_y).
      real(wp), intent(out) :: jacobian(5, 5)

      call evaluate(shape, slip, bend, tolerance, .true., wrench, moment, jacobian)
   end subroutine wrench_curved_jacobian

   !> Wrench, and derivatives if they are asked for.
   pure subroutine evaluate(shape, slip, bend, tolerance, with_jacobian, wrench, moment, jacobian)
      type(spot_shape_type), intent(in) :: shape
      type(slip_type), intent(in) :: slip
      type(bend_type), intent(in) :: bend
      real(wp), intent(in) :: tolerance
      logical, intent(in) :: with_jacobian
      real(wp), intent(out) :: wrench(3)
      real(wp), intent(out) :: moment(2)
      real(wp), intent(out) :: jacobian(5, 5)
      type(field_type) :: field
      real(wp) :: rise, largest, v(2), w, d, we, q(2), q_length, axis(2), sums(n_all), ratio
      real(wp) :: slopes(3, 3)
      logical :: valid

      jacobian = 0.0_wp
      rise = maxval(abs(bend%rise))
      valid = ieee_is_finite(shape%k) .and. ieee_is_finite(rise) .and. &
         all(ieee_is_finite(bend%turning)) .and. ieee_is_finite(slip%x) .and. &
         ieee_is_finite(slip%y) .and. ieee_is_finite(slip%spin) .and. &
         ieee_is_finite(slip%delta) .and. ieee_is_finite(tolerance)
      if (valid) valid = slip%delta >= 0.0_wp .and. tolerance > 0.0_wp
      if (.not. valid) then
         wrench = ieee_value(rise, ieee_quiet_nan)
         moment = wrench(1)
         jacobian = wrench(1)
         return
      end if
      wrench = 0.0_wp
      moment = 0.0_wp
      q = rise*bend%turning
      d = shape%slope_x*slip%delta
      largest = max(abs(slip%x), abs(slip%y), abs(slip%spin), maxval(abs(q)), d)
      ! Below that squares vanish, as at rest.
      if (.not. largest > 1.0e-280_wp) return
      v = [slip%x, slip%y]/largest
      w = slip%spin/largest
      q = q/largest
      d = d/largest
      we = abs(w)
      if (d > 0.0_wp) we = sqrt(w*w + d*d)
      if (rise > 0.0_wp) then
         q_length = sqrt(dot_product(q, q))
         axis = [0.0_wp, 1.0_wp]
         if (q_length > 0.0_wp) axis = q/q_length
         field%tolerance = tolerance
         field%adaptive = tolerance < coarsest
         field%with_jacobian = with_jacobian
         field%far = (10.0_wp/tolerance)**(1.0_wp/[4, 8, 12, 16])
         call set_field(shape, v, we, q_length, axis, bend%rise/rise, field)
         call integrate(field, sums)
         ! From the axes along q and across it to those of the spot.
         wrench(1:2) = from_axis(sums(1:2))
         wrench(3) = sums(3)
         moment = rise*from_axis(sums(4:5))
         if (with_jacobian) call unpack_jacobian(sums(6:), axis, rise, largest, jacobian)
         ratio = 1.0_wp
         if (d > 0.0_wp .or. w < 0.0_wp) ratio = w/we
         if (with_jacobian) then
            ! By W_e, which is even in W.
            jacobian(3, 3) = jacobian(3, 3)*ratio**2
            if (d > 0.0_wp) jacobian(3, 3) = jacobian(3, 3) + wrench(3)/(we*largest)*(d/we)**2
            jacobian(3, [1, 2, 4, 5]) = jacobian(3, [1, 2, 4, 5])*ratio
            jacobian([1, 2, 4, 5], 3) = jacobian([1, 2, 4, 5], 3)*ratio
         end if
         wrench(3) = wrench(3)*ratio
         if (q_length > flat*max(maxval(abs(v)), we)) return
      end if
      if (with_jacobian) then
         call wrench_exact_jacobian(shape, slip, wrench, slopes)
         jacobian(1:3, 1:3) = slopes
      else
         call wrench_exact(shape, slip, .true., wrench)
      end if

   contains

      !> A vector along q and across it, along the axes of the spot.
      pure function from_axis(x) result(y)
         real(wp), intent(in) :: x(2)
         real(wp) :: y(2)

         y = [axis(1)*x(1) - axis(2)*x(2), axis(2)*x(1) + axis(1)*x(2)]
      end function from_axis

   end subroutine evaluate

   !> Jacobian from its upper triangle along q and across it.
   pure subroutine unpack_jacobian(triangle, axis, rise, largest, jacobian)
      real(wp), intent(in) :: triangle(15)
      !> Direction of q.
      real(wp), intent(in) :: axis(2)
      !> Unit of the rise [m], and of the velocities [m/s].
      real(wp), intent(in) :: rise, largest
      real(wp), intent(out) :: jacobian(5, 5)
      real(wp) :: turn(5, 5), full(5, 5)
      integer :: i, j, k

      k = 0
      do i = 1, 5
         do j = i, 5
            k = k + 1
            full(i, j) = triangle(k)/largest
            full(j, i) = full(i, j)
         end do
      end do
      turn = 0.0_wp
      turn(1:2, 1) = axis
      turn(1:2, 2) = [-axis(2), axis(1)]
      turn(3, 3) = 1.0_wp
      turn(4:5, 4:5) = rise*turn(1:2, 1:2)
      jacobian = matmul(turn, matmul(full, transpose(turn)))
   end subroutine unpack_jacobian

   !> Slip in the coordinates of the unit disc.
   pure subroutine set_field(shape, v, w, q_length, axis, rise, field)
      type(spot_shape_type), intent(in) :: shape
      !> Sliding velocity, spin velocity, and q times the unit of the rise.
      real(wp), intent(in) :: v(2), w, q_length
      !> Direction of q.
      real(wp), intent(in) :: axis(2)
      !> Rise over its unit.
      real(wp), intent(in) :: rise(3)
      type(field_type), intent(inout) :: field
      real(wp) :: form(3), mean, half, radius, c, s

      ! The rise on the disc, and its principal axes: u along that of the larger eigenvalue.
      form = rise*[1.0_wp, shape%k, shape%k2]
      mean = 0.5_wp*(form(1) + form(3))
      half = 0.5_wp*(form(1) - form(3))
      if (mean < 0.0_wp) half = -half
      radius = sqrt(half**2 + form(2)**2)
      c = 1.0_wp
      s = 0.0_wp
      if (radius > 0.0_wp) then
         c = sqrt(0.5_wp*max(1.0_wp + half/radius, 0.0_wp))
         s = sqrt(0.5_wp*max(1.0_wp - half/radius, 0.0_wp))
         if (form(2)*mean < 0.0_wp) s = -s
      end if
      field%z = mean + [radius, -radius]
      if (mean < 0.0_wp) field%z = mean + [-radius, radius]
      field%t = [axis(1)*c + shape%k*axis(2)*s, -axis(1)*s + shape%k*axis(2)*c]
      field%s = [-axis(2)*c + shape%k*axis(1)*s, axis(2)*s + shape%k*axis(1)*c]
      field%p = [axis(1)*v(2) - axis(2)*v(1), w*field%t]
      field%g = [dot_product(axis, v), -w*field%s, q_length*field%z]
   end subroutine set_field

   !> Wrench along q and across it, and derivatives, over the disc.
   pure subroutine integrate(field, sums)
      type(field_type), intent(in) :: field
      real(wp), intent(out) :: sums(n_all)
      type(chord_type) :: chord
      real(wp) :: found(2), width(2), middle
      integer :: n

      sums = 0.0_wp
      if (.not. field%adaptive) then
         do n = 1, size(x_product)
            call set_chord(field, x_product(n), chord)
            chord%weight = 2.0_wp*factor*chord%r2*w_product(n)
            call add_whole(field, chord, 8, x_whole_8, w_whole_8, sums)
         end do
         return
      end if
      call find_points(field, found, width, n)
      if (n == 0) then
         call add_chords(field, -1.0_wp, 1.0_wp, 0.0_wp, sums)
         return
      end if
      call add_chords(field, found(1), -1.0_wp, width(1), sums)
      if (n == 2) then
         middle = 0.5_wp*(found(1) + found(2))
         call add_chords(field, found(1), middle, width(1), sums)
         call add_chords(field, found(2), middle, width(2), sums)
      end if
      call add_chords(field, found(n), 1.0_wp, width(n), sums)
   end subroutine integrate

   !> Coordinates u where the integrand over the chords has a singularity or is close to one, in
   !> ascending order.
   !>
   !> Nothing slips across q on a line, and on it nothing at all slips in two points at most. Where
   !> these are not in the disc, what matters is where the slip along q vanishes at the end of the
   !> chords that is next to the line.
   pure subroutine find_points(field, found, width, n)
      type(field_type), intent(in) :: field
      !> Over what distance from there on it is steep.
      real(wp), intent(out) :: found(2), width(2)
      integer, intent(out) :: n
      real(wp) :: foot(2), along(2), length, a(2), b(2), c, points(2, 2), u, x, slope
      integer :: i, m

      n = 0
      found = 0.0_wp
      x = 0.0_wp
      associate (p => field%p, g => field%g)
         length = p(2)*p(2) + p(3)*p(3)
         if (length > 1.0e-12_wp*p(1)*p(1) .and. length > 1.0e-300_wp) then
            foot = -p(1)*p(2:3)/length
            along = [-p(3), p(2)]/sqrt(length)
            a = [g(1) + (g(2) + g(4)*foot(1))*foot(1) + (g(3) + g(5)*foot(2))*foot(2), 0.0_wp]
            b = [(g(2) + 2.0_wp*g(4)*foot(1))*along(1) &
               + (g(3) + 2.0_wp*g(5)*foot(2))*along(2), 0.0_wp]
            c = g(4)*along(1)**2 + g(5)*along(2)**2
            call solve(a, b, c, points, m)
            do i = 1, m
               u = foot(1) + points(1, i)*along(1)
               x = foot(2) + points(1, i)*along(2)
               if (u*u + x*x < 1.0_wp) then
                  n = n + 1
                  found(n) = u
               end if
            end do
            x = foot(2)
            if (abs(p(2)) > abs(p(3))*2.0_wp) x = 0.0_wp
         end if
         if (n == 0) then
            x = max(min(x, 0.7_wp), -0.7_wp)
            a = [g(1) + (g(3) + g(5)*x)*x, p(1) + p(3)*x]
            b = [g(2), p(2)]
            call solve(a, b, g(4), points, m)
            do i = 1, m
               if (abs(points(1, i)) < 1.0_wp .and. abs(points(2, i)) < 0.5_wp) then
                  n = n + 1
                  found(n) = points(1, i)
               end if
            end do
         end if
      end associate
      do i = 1, n
         associate (p => field%p, g => field%g)
            slope = max(abs(g(2) + 2.0_wp*g(4)*found(i)), least_width)
            width(i) = sqrt((1.0_wp - found(i))*(1.0_wp + found(i)))*(abs(p(3)) + abs(g(3)) &
               + abs(g(5)))/slope
         end associate
         width(i) = min(max(5.0_wp*width(i), least_width), 1.0_wp)
      end do
      if (n == 2 .and. found(1) > found(2)) then
         found = found(2:1:-1)
         width = width(2:1:-1)
      end if
   end subroutine find_points

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

   !> Add the integral over chords from u = low to high, with nodes that are dense at the ends.
   pure subroutine add_chords(field, low, high, width, sums)
      type(field_type), intent(in) :: field
      real(wp), intent(in) :: low, high, width
      real(wp), intent(inout) :: sums(n_all)
      real(wp) :: ends(most_halvings + 1), parents(most_halvings + 1), from, half, s, c, u
      real(wp) :: stretch, weight, error, length
      real(wp) :: fine(n_all), coarse(n_wrench), before(n_wrench)
      integer :: n, i, k, last

      last = merge(n_all, n_wrench, field%with_jacobian)
      length = high - low
      if (.not. abs(length) > 0.0_wp) return
      stretch = 0.0_wp
      if (width > 0.0_wp) stretch = asinh(abs(length)/width)
      n = 1
      from = 0.0_wp
      ends(1) = 1.0_wp
      parents(1) = huge(error)
      do while (n > 0)
         half = 0.5_wp*(ends(n) - from)
         fine(:last) = 0.0_wp
         coarse = 0.0_wp
         do i = 1, n_outer
            s = from + half*(1.0_wp + x_outer(i))
            u = low + length*s
            weight = abs(length)*half
            if (width > 0.0_wp) then
               c = exp(stretch*s*s)
               u = low + sign(0.5_wp*width*(c - 1.0_wp/c), length)
               weight = half*stretch*s*width*(c + 1.0_wp/c)
            end if
            before = fine(:n_wrench)
            call add_chord(field, u, weight*w_outer(i), fine)
            coarse = coarse + (w_inner(i)/w_outer(i))*(fine(:n_wrench) - before)
         end do
         error = maxval(abs(fine(:n_wrench) - coarse))
         ! The rule with more nodes is better by far, but where halving does not help.
         if (error < slow*parents(n)) error = error*sqrt(error)
         if (error > 0.2_wp*field%tolerance .and. n <= most_halvings) then
            parents(n) = maxval(abs(fine(:n_wrench) - coarse))
            n = n + 1
            ends(n) = from + half
            parents(n) = parents(n - 1)
         else
            do k = 1, last
               sums(k) = sums(k) + fine(k)
            end do
            from = ends(n)
            n = n - 1
         end if
      end do
   end subroutine add_chords

   !> A chord.
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

   !> Add a chord.
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
      root = span
      do while (ratio > root)
         panels = panels + 1
         root = root*span
      end do
      if (panels > 1) ratio = ratio**(1.0_wp/panels)
      root = sqrt(ratio)
      slope = (root - 1.0_wp)/(root + 1.0_wp)
      centre = y(1)*root
      do k = 1, panels
         ! tau = top/bottom at y = centre (1 + v)/(1 - v), v = slope x.
         do i = 1, n_chord
            v = slope*x_chord(i)
            bottom(i) = (1.0_wp - v)*(1.0_wp + v)
            u = centre*(1.0_wp + v)**2
            z = (1.0_wp - v)**2/centre
            top(i) = zero(1)*bottom(i) + 0.5_wp*zero(2)*(u - z)
            measure(i) = zero(2)*slope*w_chord(i)*(u + z)
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
      do i = 1, n_chord
         top(i) = low + half*(1.0_wp + x_chord(i))
         bottom(i) = 1.0_wp
         measure(i) = half*w_chord(i)
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

      do i = 1, n_chord
         inverse = 1.0_wp/(bottom(i)*bottom(i) + top(i)*top(i))
         x(i) = 2.0_wp*top(i)*bottom(i)*inverse
         weight(i) = measure(i)*((bottom(i) - top(i))*(bottom(i) + top(i)))**2*inverse**3
      end do
      call add_nodes(field, chord, n_chord, x, weight, sums)
   end subroutine add_mapped

   !> Add nodes of a chord.
   pure subroutine add_nodes(field, chord, n, x, weights, sums)
      type(field_type), intent(in) :: field
      type(chord_type), intent(in) :: chord
      !> Number of nodes, even.
      integer, intent(in) :: n
      !> Nodes and weights; there is room for more.
      real(wp), intent(in) :: x(n_chord), weights(n_chord)
      real(wp), intent(inout) :: sums(n_all)
      real(wp), dimension(n_chord) :: along, across, s, t, z, inverse
      real(wp) :: pair(2, n_wrench), w
      integer :: i, j, k

      do i = 1, n
         along(i) = chord%g(1) + (chord%g(2) + chord%g(3)*x(i))*x(i)
         across(i) = chord%p(1) + chord%p(2)*x(i)
         s(i) = chord%s(1) + chord%s(2)*x(i)
         t(i) = chord%t(1) + chord%t(2)*x(i)
         z(i) = chord%z(1) + chord%z(2)*x(i)*x(i)
         ! Nothing acts where nothing slips.
         inverse(i) = -1.0_wp/sqrt(along(i)*along(i) + across(i)*across(i) + tiny(along))
      end do
      if (field%with_jacobian) then
         do i = 1, n
            call add_slopes(chord%weight*weights(i)*inverse(i)**3, along(i), across(i), s(i), &
               t(i), z(i), sums)
         end do
      end if
      pair = 0.0_wp
      do i = 1, n, 2
         do k = 1, 2
            j = i + k - 1
            w = inverse(j)*weights(j)
            along(j) = along(j)*w
            across(j) = across(j)*w
            pair(k, 1) = pair(k, 1) + along(j)
            pair(k, 2) = pair(k, 2) + across(j)
            pair(k, 3) = pair(k, 3) + (t(j)*across(j) - s(j)*along(j))
            pair(k, 4) = pair(k, 4) + z(j)*along(j)
            pair(k, 5) = pair(k, 5) + z(j)*across(j)
         end do
      end do
      do k = 1, n_wrench
         sums(k) = sums(k) + chord%weight*(pair(1, k) + pair(2, k))
      end do
   end subroutine add_nodes

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

end module contensou_contact_wrench_curved
