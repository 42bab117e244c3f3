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
!> rules, with more nodes for a smaller bound, are halved until their error is below it.
!>
!> All nodes have positive weights and the same for all components: the power that is lost,
!> -(F.v + T w + G.q), is a sum of positive terms, whatever the error.
!>
!> Near rest the wrench is regularised as the exact one: by W_e = sqrt(W^2 + d^2), d = k_x delta, in
!> Phi, which is even in W.
module contensou_contact_wrench_curved
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite, ieee_quiet_nan, ieee_value
   use contensou_base_kinds, only : wp
   use contensou_contact_spot, only : spot_shape_type
   use contensou_contact_wrench_curved_chord, only : add_chord, add_chord_of_eight, field_type, &
      n_all, n_wrench, set_panel, solve
   use contensou_contact_wrench_exact, only : wrench_exact, wrench_exact_jacobian
   use contensou_contact_wrench_scaling, only : slip_type
   use contensou_contact_wrench_slender, only : wrench_slender
   use contensou_special_kronrod, only : kronrod_15, kronrod_21, kronrod_31, kronrod_type
   use contensou_special_quadrature, only : w_12, w_4, x_12, x_4
   implicit none(type, external)
   private

   public :: coarsest, mapped_only, slender_only, bend_type, wrench_curved, wrench_curved_jacobian
   public :: friction_wrench

   !> How a spot is bent, and how fast that makes it slip.
   type :: bend_type
      !> Height of the spot over its tangent plane per square of the coordinates in units of the
      !> major semi-axis, a^2 L/2: components 11, 12, 22 along the major and the minor axis [m].
      real(wp) :: rise(3) = 0.0_wp
      !> q = w_t x n along the major and the minor axis [rad/s].
      real(wp) :: turning(2) = 0.0_wp
   end type bend_type

   !> Exact wrench of a flat or a curved spot, and with its derivatives.
   interface friction_wrench
      procedure :: wrench_exact, wrench_exact_jacobian
      procedure :: wrench_curved, wrench_curved_jacobian
   end interface friction_wrench

   !> Smallest distance over which the integrand across the chords is steep, and smallest slope
   !> that it is taken from.
   real(wp), parameter :: least_width = 1.0e-4_wp

   !> Halvings of a panel of chords at most.
   integer, parameter :: most_halvings = 24

   !> Ratio of the null rules of high degree to that of half the degree above which the integrand
   !> over a panel is not smooth.
   real(wp), parameter :: slow = 0.007_wp

   !> Ratio of the slip by curvature to the other one below which the spot is flat.
   real(wp), parameter :: flat = 1.0e-14_wp

   !> Bounds of the error from which on nothing is refined: eight chords a part, placed as for the
   !> smaller bounds; eight that are flat, for slender spots; and a product rule that takes no
   !> account of where the slip vanishes.
   real(wp), parameter :: mapped_only = 1.0e-3_wp, slender_only = 3.0e-3_wp, coarsest = 1.0e-2_wp

   !> Bound of the error on the chords of the former.
   real(wp), parameter :: mapped_chord = 1.0e-4_wp

   !> Its nodes across the chords.
   real(wp), parameter :: x_product(24) = [-x_12, x_12], w_product(24) = [w_12, w_12]

   !> The nodes across the chords of a part where nothing is refined.
   real(wp), parameter :: x_mapped(8) = [-x_4, x_4], w_mapped(8) = [w_4, w_4]

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
         field%smallest = merge(tolerance**0.3_wp, 0.1_wp, tolerance < 1.0e-9_wp)
         field%mapped = tolerance < coarsest
         field%slender = field%mapped .and. tolerance >= slender_only
         field%adaptive = tolerance < mapped_only
         field%with_jacobian = with_jacobian
         if (with_jacobian .or. .not. field%slender) field%far = (10.0_wp/merge(tolerance, &
            mapped_chord, field%adaptive))**(1.0_wp/[4, 8, 12, 16])
         call set_panel(tolerance, field)
         call set_field(shape, v, we, q_length, axis, bend%rise/rise, field)
         if (tolerance < 1.0e-7_wp) then
            call integrate(field, kronrod_31, sums)
         else if (tolerance < 1.0e-5_wp) then
            call integrate(field, kronrod_21, sums)
         else if (with_jacobian .or. .not. field%slender) then
            call integrate(field, kronrod_15, sums)
         end if
         ! The derivatives are steeper: flat chords have none that fit.
         if (field%slender) call wrench_slender(field, sums(:n_wrench))
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
   pure subroutine integrate(field, rule, sums)
      type(field_type), intent(in) :: field
      !> Across the chords.
      type(kronrod_type), intent(in) :: rule
      real(wp), intent(out) :: sums(n_all)
      real(wp) :: found(2), width(2), middle
      integer :: n

      sums = 0.0_wp
      if (.not. field%mapped) then
         do n = 1, size(x_product)
            call add_chord_of_eight(field, x_product(n), w_product(n), sums)
         end do
         return
      end if
      call find_points(field, found, width, n)
      if (n == 0) then
         call add_chords(field, rule, -1.0_wp, 1.0_wp, 0.0_wp, sums)
         return
      end if
      call add_chords(field, rule, found(1), -1.0_wp, width(1), sums)
      if (n == 2) then
         middle = 0.5_wp*(found(1) + found(2))
         call add_chords(field, rule, found(1), middle, width(1), sums)
         call add_chords(field, rule, found(2), middle, width(2), sums)
      end if
      call add_chords(field, rule, found(n), 1.0_wp, width(n), sums)
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
               + 0.1_wp*abs(g(5)))/slope
         end associate
         width(i) = min(max(5.0_wp*width(i), least_width), 1.0_wp)
      end do
      if (n == 2 .and. found(1) > found(2)) then
         found = found(2:1:-1)
         width = width(2:1:-1)
      end if
   end subroutine find_points

   !> Add the integral over chords from u = low to high, with nodes that are dense at `low`.
   pure subroutine add_chords(field, rule, low, high, width, sums)
      type(field_type), intent(in) :: field
      type(kronrod_type), intent(in) :: rule
      real(wp), intent(in) :: low, high, width
      real(wp), intent(inout) :: sums(n_all)
      real(wp) :: ends(most_halvings + 1), from, half, u
      real(wp) :: stretch, weight, error, length
      real(wp) :: fine(n_all), one(n_all), faults(3, n_wrench)
      integer :: n, i, k, last

      last = merge(n_all, n_wrench, field%with_jacobian)
      length = high - low
      if (.not. abs(length) > 0.0_wp) return
      stretch = 0.0_wp
      if (width > 0.0_wp) stretch = asinh(abs(length)/width)
      if (.not. field%adaptive) then
         do i = 1, size(x_mapped)
            call place(0.5_wp*(1.0_wp + x_mapped(i)), 0.5_wp, u, weight)
            call add_chord(field, u, weight*w_mapped(i), sums)
         end do
         return
      end if
      n = 1
      from = 0.0_wp
      ends(1) = 1.0_wp
      do while (n > 0)
         half = 0.5_wp*(ends(n) - from)
         fine(:last) = 0.0_wp
         faults = 0.0_wp
         do i = 1, rule%n
            call place(from + half*(1.0_wp + rule%x(i)), half, u, weight)
            one(:last) = 0.0_wp
            call add_chord(field, u, weight, one)
            do k = 1, last
               fine(k) = fine(k) + rule%w(i)*one(k)
            end do
            do k = 1, n_wrench
               faults(:, k) = faults(:, k) + rule%faults(:, i)*one(k)
            end do
         end do
         ! Two null rules: one alone is small by chance now and then.
         error = sqrt(maxval(faults(1, :)**2 + faults(2, :)**2))
         ! Where the integrand is smooth the rule is better by far, but a small part need not be.
         if (error < slow*maxval(abs(faults(3, :)))) then
            error = error*max(sqrt(error), field%smallest)
         end if
         if (error > 0.2_wp*field%tolerance .and. n <= most_halvings) then
            n = n + 1
            ends(n) = from + half
         else
            do k = 1, last
               sums(k) = sums(k) + fine(k)
            end do
            from = ends(n)
            n = n - 1
         end if
      end do

   contains

      !> A chord, by where it is between `low` (0) and `high` (1).
      pure subroutine place(s, step, u, weight)
         !> Its place and the weight of that.
         real(wp), intent(in) :: s, step
         !> Its coordinate and weight.
         real(wp), intent(out) :: u, weight
         real(wp) :: c

         u = low + length*s
         weight = abs(length)*step
         if (width > 0.0_wp) then
            c = exp(stretch*s*s)
            u = low + sign(0.5_wp*width*(c - 1.0_wp/c), length)
            weight = step*stretch*s*width*(c + 1.0_wp/c)
         end if
      end subroutine place

   end subroutine add_chords

end module contensou_contact_wrench_curved
