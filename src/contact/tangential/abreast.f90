!> Slip of shells side by side: as many at a time as a register of the machine holds.
!>
!> This file is compiled three times, for registers of two, of four and of eight numbers; that for
!> the machine is taken where it runs (`contensou_contact_tangential_registers`). So it uses little
!> of the library, and modules whose procedures are only called now and then.
!>
!> What a few steps do not find is left to `contensou_contact_tangential_slip`, which tells what is
!> sought, and why. Of arrays by edges the first column is that of the outer edges of the shells,
!> the second one that of the inner ones.
module contensou_contact_tangential_abreast
   use contensou_base_kinds, only : pi, wp
   use contensou_contact_tangential_circle_values, only : circle_degree => degree, &
      circle_parts => parts, circle_table => values
   use contensou_contact_tangential_ellipse, only : ellipse_type, round_bulge
   use contensou_contact_tangential_ellipse_pass, only : close_by_bends, close_enough, lanes, &
      least_pivot, least_power, n_values, pass_on_ellipses, smallest_force
   use contensou_contact_tangential_ellipse_pass_few, only : few => lanes, &
      pass_on_few => pass_on_ellipses, slide_few => slide_on_ellipse
   use contensou_contact_tangential_shell_data, only : shell_data_type
   implicit none(type, external)
   private

   public :: lay_out, slip_in_plane, slip_on_circles, slip_on_ellipses, slide_shells, &
      take_back, step_on_circles, within_limit, look_at_limit, abreast, narrow_load, short_slip, &
      surely_stuck

   !> Most shells side by side.
   integer, parameter :: abreast = 40

   !> Speeds below this, where they are of the size one, have no powers to divide by; they are those
   !> of an edge at the very centre, which bears nothing.
   real(wp), parameter :: least_speed = 1.0e-30_wp

   !> Slip in units of the trial for which a direction is sought where there is none.
   real(wp), parameter :: short_slip = 1.0e-3_wp

   !> Steps of shells side by side, and of those that slip in the plane.
   integer, parameter :: most_passes = 7, most_in_plane = 60

   !> Load of a shell below which powers of it leave the range of numbers.
   real(wp), parameter :: narrow_load = 1.0e-8_wp

   !> Distance of a slip from the direction of the step below which it turns as that does.
   real(wp), parameter :: near = 1.0e-2_wp

   !> Forces of trials above this, and stiffness beyond that or its inverse, are left to others.
   real(wp), parameter :: largest_trial = 1.0e15_wp, largest_stiffness = 1.0e30_wp

   !> Square of a component of a direction below which it is not known what bears it.
   real(wp), parameter :: least_square = 1.0e-8_wp

   !> By how much squares of what is borne may differ from those of pure sliding and spinning.
   real(wp), parameter :: alike = 100.0_wp

   !> Least derivative of the limit of a shell.
   real(wp), parameter :: least_slope = 0.1_wp

   !> F of `look_at_limit` below which a shell surely sticks.
   real(wp), parameter :: surely_stuck = 0.93_wp

contains

   !> Slip of shells that slip along the plane only, side by side: the force has the size of the
   !> load, and the slip, along the force, is mu times it, so the force is along g/(1 + mu K).
   !>
   !> With v = g/|g|, m = v.K v, d = (K1 - K2)/m and t = d mu m/(1 + mu m) it is along
   !> s = (v1 (1 - t v1^2), v2 (1 + t v2^2)). With t = d (1 - y load/|g|) what is sought is the y
   !> near one where y |s| = (1 - t v1^2) (1 + t v2^2). The squares of both sides are polynomials,
   !> steps Halley's, from the y to the third order of d on. (K1/K2 is from
   !> 1/2 to 2.)
   pure subroutine slip_in_plane(n, load, stiffness, trial, force, direction, work)
      !> Number of shells.
      integer, intent(in) :: n
      real(wp), intent(in) :: load(abreast), stiffness(abreast, 2)
      !> Elastic displacement of the trial.
      real(wp), intent(in) :: trial(abreast, 2)
      !> Force of the trial on entry, larger than the load; of sliding on return.
      real(wp), intent(inout) :: force(abreast, 2)
      real(wp), intent(inout) :: direction(abreast, 2), work(abreast)
      real(wp) :: ratio(abreast), apart(abreast), y(abreast), inverse, w1, w2, t, more, both, &
         rest, rate, square, product, slope1, slope2, excess, slope, curve, step, largest
      integer :: i, j

      do j = 1, n
         inverse = 1.0_wp/sqrt(force(j, 1)**2 + force(j, 2)**2)
         ratio(j) = load(j)*inverse
         direction(j, 1) = force(j, 1)*inverse
         direction(j, 2) = force(j, 2)*inverse
         w1 = direction(j, 1)**2
         w2 = direction(j, 2)**2
         apart(j) = (stiffness(j, 1) - stiffness(j, 2))/(w1*stiffness(j, 1) + w2*stiffness(j, 2))
         t = apart(j)*(1.0_wp - ratio(j))
         y(j) = 1.0_wp - w1*w2*t*t*(1.5_wp - 2.0_wp*t*(w2 - w1))
      end do
      if (any(abs(apart(:n)) > 0.0_wp)) then
         do i = 1, most_in_plane
            largest = 0.0_wp
            do j = 1, n
               w1 = direction(j, 1)**2
               w2 = direction(j, 2)**2
               more = w2 - w1
               both = w1*w2
               rest = 1.0_wp - 3.0_wp*both
               rate = ratio(j)*apart(j)
               t = apart(j) - rate*y(j)
               ! |s|^2 and the product, and their derivatives by -y.
               square = 1.0_wp + t*(2.0_wp*more + t*rest)
               product = 1.0_wp + t*(more - t*both)
               slope1 = 2.0_wp*rate*(more + t*rest)
               slope2 = rate*(more - 2.0_wp*t*both)
               excess = y(j)*y(j)*square - product*product
               slope = 2.0_wp*(y(j)*square + product*slope2) - y(j)*y(j)*slope1
               curve = square - 2.0_wp*y(j)*slope1 + rate*rate*(y(j)*y(j)*rest &
                  + 2.0_wp*product*both) - slope2*slope2
               step = excess*slope/(slope*slope - excess*curve)
               y(j) = y(j) - step
               largest = max(largest, abs(step))
            end do
            if (largest < close_by_bends) exit
         end do
         do j = 1, n
            t = apart(j)*(1.0_wp - ratio(j)*y(j))
            direction(j, 1) = direction(j, 1)*(1.0_wp - t*direction(j, 1)**2)
            direction(j, 2) = direction(j, 2)*(1.0_wp + t*direction(j, 2)**2)
            inverse = 1.0_wp/sqrt(direction(j, 1)**2 + direction(j, 2)**2)
            direction(j, 1) = direction(j, 1)*inverse
            direction(j, 2) = direction(j, 2)*inverse
         end do
      end if
      do j = 1, n
         force(j, 1) = load(j)*direction(j, 1)
         force(j, 2) = load(j)*direction(j, 2)
         ! Not below zero by rounding.
         work(j) = max((trial(j, 1) - force(j, 1)/stiffness(j, 1))*force(j, 1) &
            + (trial(j, 2) - force(j, 2)/stiffness(j, 2))*force(j, 2), 0.0_wp)
      end do
   end subroutine slip_in_plane

   !> Slip of shells of a circular spot.
   pure subroutine slip_on_circles(torque, n, load, size, stiffness, trial, held, steady, u, &
      force, found)
      !> Of pure spinning of the spot, in units of f N a.
      real(wp), intent(in) :: torque
      !> Number of shells.
      integer, intent(in) :: n
      !> Within the outer and the inner edges.
      real(wp), intent(in) :: load(lanes, 2), size(lanes, 2)
      !> Against shift and twist, and the force of the trial, > 0.
      real(wp), intent(in) :: stiffness(lanes, 2), trial(lanes, 2)
      !> Force before the step where a shell slipped in the step before, or zero.
      real(wp), intent(in) :: held(lanes, 2)
      !> Whether all of these are those of the step before.
      logical, intent(in) :: steady
      !> Sliding and spinning where they are sought first, > 0, of the size one; those of the slip.
      real(wp), intent(inout) :: u(lanes, 2)
      !> Force of sliding; that of the trial where it is not found.
      real(wp), intent(inout) :: force(lanes, 2)
      logical, intent(inout) :: found(lanes)
      real(wp), dimension(lanes, 2) :: loads, sizes, k, g, v, new, f
      real(wp), dimension(lanes, 3) :: springs, trials, bears, along
      real(wp) :: off(lanes), usual(lanes), sticks(lanes)
      integer :: at(lanes), i, j, l, m, pass

      do l = 1, 2
         do i = 1, n
            loads(i, l) = load(i, l)
            sizes(i, l) = size(i, l)
            k(i, l) = stiffness(i, l)
            g(i, l) = trial(i, l)
            v(i, l) = u(i, l)
            force(i, l) = trial(i, l)
         end do
      end do
      do i = 1, n
         at(i) = i
         found(i) = .false.
      end do
      m = n
      if (.not. steady) then
         do i = 1, n
            springs(i, 1) = k(i, 1)
            springs(i, 2) = k(i, 1)
            springs(i, 3) = k(i, 2)
            trials(i, 1) = g(i, 1)
            trials(i, 2) = 0.0_wp
            trials(i, 3) = g(i, 2)
            bears(i, 1) = held(i, 1)
            bears(i, 2) = 0.0_wp
            bears(i, 3) = held(i, 2)
            along(i, 1) = v(i, 1)
            along(i, 2) = 0.0_wp
            along(i, 3) = v(i, 2)
         end do
         call mask_unusual(n, springs, trials, bears, usual)
         do i = 1, n
            ! Of a narrow shell the direction stays.
            usual(i) = merge(usual(i), 0.0_wp, load(i, 1) - load(i, 2) >= narrow_load)
            loads(i, 1) = merge(load(i, 1), 1.0_wp, usual(i) > 0.5_wp)
            loads(i, 2) = merge(load(i, 2), 0.0_wp, usual(i) > 0.5_wp)
            sizes(i, 1) = merge(size(i, 1), 1.0_wp, usual(i) > 0.5_wp)
            sizes(i, 2) = merge(size(i, 2), 0.0_wp, usual(i) > 0.5_wp)
         end do
         call foresee(n, torque, round_bulge, loads, sizes, springs, trials, bears, along, sticks)
         m = 0
         do i = 1, n
            v(i, 1) = merge(along(i, 1), v(i, 1), usual(i) > 0.5_wp)
            v(i, 2) = merge(along(i, 3), v(i, 2), usual(i) > 0.5_wp)
            found(i) = sticks(i)*usual(i) > 0.5_wp
            if (found(i)) then
               u(i, 1) = v(i, 1)
               u(i, 2) = v(i, 2)
               cycle
            end if
            m = m + 1
            at(m) = i
            do l = 1, 2
               v(m, l) = v(i, l)
               loads(m, l) = load(i, l)
               sizes(m, l) = size(i, l)
               k(m, l) = k(i, l)
               g(m, l) = g(i, l)
            end do
         end do
      end if
      do pass = 1, most_passes
         call step_on_circles(m, loads, sizes, k, g, v, off, new, f)
         j = 0
         do i = 1, m
            if (off(i) <= 1.0_wp) then
               found(at(i)) = .true.
               u(at(i), 1) = new(i, 1)
               u(at(i), 2) = new(i, 2)
               force(at(i), 1) = f(i, 1)
               force(at(i), 2) = f(i, 2)
            else if (min(new(i, 1), new(i, 2)) > 0.0_wp) then
               j = j + 1
               v(j, 1) = new(i, 1)
               v(j, 2) = new(i, 2)
               if (j == i) cycle
               at(j) = at(i)
               do l = 1, 2
                  loads(j, l) = loads(i, l)
                  sizes(j, l) = sizes(i, l)
                  k(j, l) = k(i, l)
                  g(j, l) = g(i, l)
               end do
            end if
         end do
         m = j
         if (m == 0) exit
      end do
   end subroutine slip_on_circles

   !> Steps of the directions u of the slips of shells of a circular spot. With
   !>    r = (g1 - f1) k2 u2 - (g2 - f2) k1 u1,
   !> zero where g - f is along K u, they are Householder's of the fourth order.
   pure subroutine step_on_circles(n, load, size, stiffness, trial, u, off, new, force)
      !> Number of shells.
      integer, intent(in) :: n
      !> Within the outer and the inner edges.
      real(wp), intent(in) :: load(lanes, 2), size(lanes, 2)
      !> Against shift and twist, and the force of the trial.
      real(wp), intent(in) :: stiffness(lanes, 2), trial(lanes, 2)
      !> Sliding and spinning, >= 0, of the size one.
      real(wp), intent(in) :: u(lanes, 2)
      !> What the force may be off after the step, over what it may be.
      real(wp), intent(inout) :: off(lanes)
      !> The direction after it, and the force there.
      real(wp), intent(inout) :: new(lanes, 2), force(lanes, 2)
      real(wp) :: k1, k2, g1, g2, u1, u2, h, h1, h2, r, bent, slope, inverse, spread, twisted, &
         curve, rate, second, third, square, along, across, half, reach, step, good, &
         f1, f2, edges(lanes, 5, 2)
      integer :: i

      call slide_on_circle(n, load(:, 1), size(:, 1), u, edges(:, :, 1))
      call slide_on_circle(n, load(:, 2), size(:, 2), u, edges(:, :, 2))
      do i = 1, n
         k1 = stiffness(i, 1)
         k2 = stiffness(i, 2)
         u1 = u(i, 1)
         u2 = u(i, 2)
         f1 = edges(i, 1, 1) - edges(i, 1, 2)
         f2 = edges(i, 2, 1) - edges(i, 2, 2)
         h = edges(i, 3, 1) - edges(i, 3, 2)
         h1 = edges(i, 4, 1) - edges(i, 4, 2)
         h2 = edges(i, 5, 1) - edges(i, 5, 2)
         g1 = trial(i, 1) - f1
         g2 = trial(i, 2) - f2
         r = g1*k2*u2 - g2*k1*u1
         bent = k2*u2*u2 + k1*u1*u1
         slope = h*bent + g1*k2*u1 + g2*k1*u2
         inverse = 1.0_wp/max(slope, abs(r), least_pivot)
         step = -r*inverse
         ! What the second and the third order of r are to the first.
         spread = k2 - k1
         twisted = u1*u2*spread
         curve = 0.5_wp*step*(h1*bent + 3.0_wp*h*twisted - r)*inverse
         rate = step*step*((h2*bent + 5.0_wp*h1*twisted + 3.0_wp*h*spread*(u1*u1 - u2*u2)) &
            *inverse - 1.0_wp)*(1.0_wp/6.0_wp)
         ! Where that is not small a step is Newton's, of one at most.
         good = 0.5_wp + sign(0.5_wp, min(slope - abs(r), 0.5_wp - 2.0_wp*abs(curve) - abs(rate)))
         curve = good*curve
         rate = good*rate
         off(i) = 5.0_wp*h*abs(step*curve)*(curve*curve + abs(rate))
         step = step*(1.0_wp + curve)/(1.0_wp + (2.0_wp*curve + rate))
         square = step*step
         second = 0.5_wp*h1*square
         third = (1.0_wp/6.0_wp)*h2*square*step
         ! The next order of the force, by the distance to where the centre of rotation is on an
         ! edge, about.
         reach = min(abs(u1 - size(i, 1)*u2), abs(u1 - size(i, 2)*u2))
         off(i) = off(i)*reach*reach + (abs(third)*max(reach, abs(step)) + abs(second*step)) &
            *abs(step)
         off(i) = off(i)/max(smallest_force*reach*reach, least_pivot)
         off(i) = off(i)*(0.5_wp + sign(0.5_wp, abs(step) - close_enough)) + 2.0_wp*(1.0_wp - good)
         ! The force turns with the angle, and so does its change.
         across = step*h*(1.0_wp - (1.0_wp/6.0_wp)*square) + second + third
         along = 0.5_wp*square*h*(1.0_wp - (1.0_wp/12.0_wp)*square) &
            + step*((2.0_wp/3.0_wp)*second + 0.75_wp*third)
         force(i, 1) = f1 - across*u2 - along*u1
         force(i, 2) = f2 + across*u1 - along*u2
         ! By the tangent of half the angle.
         half = 0.5_wp*step*(1.0_wp + square*((1.0_wp/12.0_wp) + (1.0_wp/120.0_wp)*square))
         inverse = 1.0_wp/(1.0_wp + half*half)
         along = (1.0_wp - half*half)*inverse
         across = 2.0_wp*half*inverse
         new(i, 1) = u1*along - u2*across
         new(i, 2) = u2*along + u1*across
      end do
   end subroutine step_on_circles

   !> Forces and torques of sliding of what is within edges of a circular spot, the second
   !> derivative h of the potential across the direction, by which they change along that, and two
   !> derivatives of h by the angle.
   pure subroutine slide_on_circle(n, load, size, u, values)
      !> Number of edges, those within which the centre of rotation is come first for the most.
      integer, intent(in) :: n
      real(wp), intent(in) :: load(lanes), size(lanes)
      !> Sliding and spinning, >= 0, of the size one.
      real(wp), intent(in) :: u(lanes, 2)
      real(wp), intent(inout) :: values(lanes, 5)
      integer :: i, last

      do last = n, 1, -1
         if (size(last)*u(last, 2) >= u(last, 1)) exit
      end do
      call turn_inside(last, load, size, u, values)
      call turn_outside(last + 1, n, load, size, u, values)
      do i = 1, last
         if (size(i)*u(i, 2) < u(i, 1)) call turn_outside(i, i, load, size, u, values)
      end do
   end subroutine slide_on_circle

   !> The same with the centre of rotation inside: polynomials of v/W.
   pure subroutine turn_inside(n, load, size, u, values)
      integer, intent(in) :: n
      real(wp), intent(in) :: load(lanes), size(lanes), u(lanes, 2)
      real(wp), intent(inout) :: values(lanes, 5)
      real(wp) :: x, y, inverse, around, full, slope, bent, h, h1
      integer :: i

      do i = 1, n
         ! What is outside is not used.
         inverse = 1.0_wp/max(size(i)*u(i, 2), u(i, 1), least_speed)
         x = u(i, 1)*inverse
         y = x*x
         full = (3.0_wp*pi/8.0_wp)*load(i)
         around = size(i)*inverse*inverse
         slope = 3.0_wp*size(i)*x
         values(i, 1) = full*x*(1.0_wp - 0.25_wp*y)
         values(i, 2) = 0.5_wp*full*size(i)*(1.0_wp - y*(1.0_wp - 0.375_wp*y))
         bent = full*size(i)*inverse*around
         h = bent*(1.0_wp - 0.75_wp*y)
         bent = 1.5_wp*bent*around
         h1 = bent*x - slope*h
         values(i, 3) = h
         values(i, 4) = h1
         values(i, 5) = 3.0_wp*size(i)*around*h - slope*h1 - bent*((5.0_wp/3.0_wp)*slope*x + around)
      end do
   end subroutine turn_inside

   !> The same with the centre of rotation outside. With G of scripts/generate_circle.py, G'' is
   !> that of a hypergeometric function.
   pure subroutine turn_outside(from, to, load, size, u, values)
      integer, intent(in) :: from, to
      real(wp), intent(in) :: load(lanes), size(lanes), u(lanes, 2)
      real(wp), intent(inout) :: values(lanes, 5)
      real(wp), dimension(lanes) :: root, g, slope
      real(wp) :: x, y, inverse, tau, rest, bent, p, h, h1, h2, both(2)
      integer :: i, j, k

      do i = from, to
         tau = size(i)*u(i, 2)/max(u(i, 1), least_speed)
         root(i) = sqrt(max(1.0_wp - tau*tau, epsilon(tau)))
      end do
      do i = from, to
         j = int(root(i)*circle_parts + 0.5_wp)
         x = root(i) - real(j, wp)*(1.0_wp/circle_parts)
         both = circle_table(:, circle_degree, j)
         do k = circle_degree - 1, 0, -1
            both = both*x + circle_table(:, k, j)
         end do
         g(i) = both(1)
         slope(i) = both(2)
      end do
      do i = from, to
         inverse = 1.0_wp/max(u(i, 1), least_speed)
         p = u(i, 2)*inverse
         tau = size(i)*p
         y = tau*tau
         rest = max(1.0_wp - y, epsilon(y))
         bent = y*rest*slope(i)
         values(i, 1) = load(i)*((1.0_wp - 0.4_wp*y)*g(i) + 0.4_wp*bent)
         values(i, 2) = (0.2_wp*load(i)*size(i))*tau*((1.0_wp - 0.25_wp*y)*g(i) + 0.5_wp*bent)
         x = size(i)*inverse
         h = (0.2_wp*load(i)*inverse)*x*x
         x = x*inverse
         h2 = h*x*x*(3.0_wp*g(i) - (12.0_wp - 10.0_wp*y)*slope(i))/rest
         h1 = 2.0_wp*h*x*tau*slope(i)
         h = h*g(i)
         values(i, 3) = h
         values(i, 4) = h1 + 3.0_wp*p*h
         values(i, 5) = h2 + 8.0_wp*p*h1 + (3.0_wp + 12.0_wp*p*p)*h
      end do
   end subroutine turn_outside

   !> Slip of shells of an elliptic spot.
   pure subroutine slip_on_ellipses(ellipse, torque, asked, load, size, stiffness, trial, held, &
      steady, u, force, elastic, length, work, found)
      type(ellipse_type), intent(inout) :: ellipse
      !> Of pure spinning of the spot, in units of f N a.
      real(wp), intent(in) :: torque
      !> One for a shell that is asked for, else zero. The others must be shells as well, with
      !> directions.
      real(wp), intent(in) :: asked(lanes)
      !> Within the outer and the inner edges.
      real(wp), intent(in) :: load(lanes, 2), size(lanes, 2)
      !> In units of f N and of a length, and the force of the trial.
      real(wp), intent(in) :: stiffness(lanes, 3), trial(lanes, 3)
      !> Force before the step where a shell slipped in the step before, or zero.
      real(wp), intent(in) :: held(lanes, 3)
      !> Whether all go on to slip, about in the directions they come with.
      logical, intent(in) :: steady
      !> Direction in the step before, of the size one or zero, or where all go on the one in which
      !> it is sought first, of any size; then that of the slip or where the shell bears the most.
      real(wp), intent(inout) :: u(lanes, 3)
      !> Force of sliding, and that over the stiffness.
      real(wp), intent(inout), dimension(lanes, 3) :: force, elastic
      !> Length of the slip, > 0 if a shell slips, and its work.
      real(wp), intent(inout), dimension(lanes) :: length, work
      !> Whether it is known what a shell does.
      logical, intent(inout) :: found(lanes)
      real(wp), dimension(lanes, 3) :: k, g, b, v
      real(wp), dimension(lanes) :: short, unknown, usual, sticks
      real(wp), dimension(few, 3) :: some_k, some_g, some_v, some_u, some_force
      real(wp), dimension(few, 2) :: some_load, some_size
      real(wp), dimension(few) :: some_short, some_unknown, some_length
      real(wp) :: inverse
      integer :: at(few), i, j, l, m, pass

      do l = 1, 3
         do i = 1, lanes
            k(i, l) = stiffness(i, l)
            g(i, l) = trial(i, l)
            b(i, l) = held(i, l)
            v(i, l) = u(i, l)
            force(i, l) = 0.0_wp
         end do
      end do
      call mask_unusual(lanes, k, g, b, usual)
      do i = 1, lanes
         short(i) = k(i, 1)*k(i, 2)*k(i, 3)
         short(i) = (short_slip/short(i))*sqrt((g(i, 1)*k(i, 2)*k(i, 3))**2 &
            + (g(i, 2)*k(i, 1)*k(i, 3))**2 + (g(i, 3)*k(i, 1)*k(i, 2))**2)
         unknown(i) = asked(i)
         usual(i) = usual(i)*asked(i)
      end do
      if (steady) then
         do i = 1, lanes
            inverse = 1.0_wp/sqrt(v(i, 1)**2 + v(i, 2)**2 + v(i, 3)**2)
            v(i, 1) = v(i, 1)*inverse
            v(i, 2) = v(i, 2)*inverse
            v(i, 3) = v(i, 3)*inverse
         end do
      else
         call foresee(lanes, torque, ellipse%bulge, load, size, k, g, b, v, sticks)
         do i = 1, lanes
            unknown(i) = unknown(i)*(1.0_wp - sticks(i))
            length(i) = 0.0_wp
            u(i, 1) = v(i, 1)
            u(i, 2) = v(i, 2)
            u(i, 3) = v(i, 3)
         end do
      end if
      m = int(sum(unknown) + 0.5_wp)
      pass = 0
      do while (m > few .and. pass < most_passes)
         call pass_on_ellipses(ellipse, torque, load, size, k, g, short, v, unknown, u, force, &
            length)
         m = int(sum(unknown) + 0.5_wp)
         pass = pass + 1
      end do
      if (m > 0 .and. m <= few .and. pass < most_passes) then
         j = 0
         do i = 1, lanes
            if (unknown(i) < 0.5_wp) cycle
            j = j + 1
            at(j) = i
         end do
         at(m + 1:) = at(m)
         do j = 1, few
            i = at(j)
            some_short(j) = short(i)
            some_unknown(j) = merge(1.0_wp, 0.0_wp, j <= m)
            do l = 1, 2
               some_load(j, l) = load(i, l)
               some_size(j, l) = size(i, l)
            end do
            do l = 1, 3
               some_k(j, l) = k(i, l)
               some_g(j, l) = g(i, l)
               some_v(j, l) = v(i, l)
               some_u(j, l) = u(i, l)
               some_force(j, l) = 0.0_wp
            end do
         end do
         do while (pass < most_passes)
            call pass_on_few(ellipse, torque, some_load, some_size, some_k, some_g, &
               some_short, some_v, some_unknown, some_u, some_force, some_length)
            if (.not. any(some_unknown > 0.5_wp)) exit
            pass = pass + 1
         end do
         do j = 1, m
            i = at(j)
            unknown(i) = some_unknown(j)
            length(i) = some_length(j)
            do l = 1, 3
               u(i, l) = some_u(j, l)
               force(i, l) = some_force(j, l)
            end do
         end do
      end if
      do i = 1, lanes
         found(i) = usual(i) - unknown(i) > 0.5_wp
         inverse = 1.0_wp/(k(i, 1)*k(i, 2)*k(i, 3))
         elastic(i, 1) = force(i, 1)*(k(i, 2)*k(i, 3)*inverse)
         elastic(i, 2) = force(i, 2)*(k(i, 1)*k(i, 3)*inverse)
         elastic(i, 3) = force(i, 3)*(k(i, 1)*k(i, 2)*inverse)
         work(i) = (force(i, 1)*u(i, 1) + force(i, 2)*u(i, 2) + force(i, 3)*u(i, 3)) &
            *((g(i, 1) - force(i, 1))*u(i, 1) + (g(i, 2) - force(i, 2))*u(i, 2) &
            + (g(i, 3) - force(i, 3))*u(i, 3)) &
            /max(k(i, 1)*u(i, 1)**2 + k(i, 2)*u(i, 2)**2 + k(i, 3)*u(i, 3)**2, least_pivot)
      end do
   end subroutine slip_on_ellipses

   !> Shells of an elliptic spot side by side, those that are twisted and may slip. In the place of
   !> the rest there are others.
   pure subroutine lay_out(shells, inside, n, limit, step, along, turn, asked, load, size, &
      stiffness, trial, held, steady, u)
      type(shell_data_type), intent(in) :: shells
      !> Number of the shells inside of them, and of them, up to `lanes`.
      integer, intent(in) :: inside, n
      !> Limit of the spot [N].
      real(wp), intent(in) :: limit
      !> Step of shift and of twist times the semi-axis [m], its direction, and by how much this is
      !> another one than in the step before.
      real(wp), intent(in), dimension(3) :: step, along, turn
      !> As of `slip_on_ellipses`.
      real(wp), intent(inout) :: asked(lanes), load(lanes, 2), size(lanes, 2)
      real(wp), intent(inout), dimension(lanes, 3) :: stiffness, trial, held
      !> Whether all go on to slip as the steps go, if they slipped so; whether they do.
      logical, intent(inout) :: steady
      real(wp), intent(inout) :: u(lanes, 3)
      real(wp) :: part, rest, a, lever, per_limit, per_area, was, last, off(lanes)
      integer :: i, j

      a = shells%a
      per_limit = 1.0_wp/limit
      per_area = per_limit/(a*a)*shells%fading
      ! The force of the trial is that of the stiffness itself.
      lever = a/shells%fading
      last = real(n, wp)
      do i = 1, lanes
         j = inside + i
         ! Powers of what is very narrow leave the range of numbers.
         rest = min(shells%share(j, 1), shells%share(j, 2), shells%share(j, 3)) - least_pivot
         rest = min(rest, shells%load(j) - shells%load(j - 1) - narrow_load, last - real(i, wp))
         rest = min(rest, shells%excess(j), abs(shells%shift(j, 3)) - least_power)
         part = 0.5_wp + sign(0.5_wp, rest)
         rest = 1.0_wp - part
         asked(i) = part
         load(i, 1) = part*shells%load(j) + rest
         load(i, 2) = part*shells%load(j - 1)
         size(i, 1) = part*shells%size(j) + rest
         size(i, 2) = part*shells%size(j - 1)
         stiffness(i, 1) = part*(shells%share(j, 1)*per_limit) + rest
         stiffness(i, 2) = part*(shells%share(j, 2)*per_limit) + rest
         stiffness(i, 3) = part*(shells%share(j, 3)*per_area) + rest
         trial(i, 1) = stiffness(i, 1)*(part*shells%shift(j, 1) + rest)
         trial(i, 2) = stiffness(i, 2)*(part*shells%shift(j, 2) + rest)
         trial(i, 3) = stiffness(i, 3)*((part*shells%shift(j, 3) + rest)*lever)
         u(i, 1) = part*shells%direction(j, 1) + rest
         u(i, 2) = part*shells%direction(j, 2)
         u(i, 3) = part*shells%direction(j, 3)
      end do
      do i = 1, lanes
         was = shells%slid(inside + i)
         held(i, 1) = was*(trial(i, 1) - stiffness(i, 1)*step(1))
         held(i, 2) = was*(trial(i, 2) - stiffness(i, 2)*step(2))
         held(i, 3) = was*(trial(i, 3) - stiffness(i, 3)*step(3))
         off(i) = max(abs(u(i, 1) - along(1)), abs(u(i, 2) - along(2)), abs(u(i, 3) - along(3)))
         off(i) = asked(i)*(off(i) + (1.0_wp - was))
      end do
      steady = steady .and. .not. any(off > near)
      if (.not. steady) return
      do i = 1, lanes
         u(i, 1) = u(i, 1) + turn(1)
         u(i, 2) = u(i, 2) + turn(2)
         u(i, 3) = u(i, 3) + turn(3)
      end do
   end subroutine lay_out

   !> Note the slips of the shells that `lay_out` laid out.
   pure subroutine take_back(shells, inside, u, elastic, length, done, found, work)
      type(shell_data_type), intent(inout) :: shells
      !> Number of the shells inside of them.
      integer, intent(in) :: inside
      !> As of `slip_on_ellipses`.
      real(wp), intent(in), dimension(lanes, 3) :: u, elastic
      real(wp), intent(in), dimension(lanes) :: length, done
      logical, intent(in) :: found(lanes)
      !> Work of the slips over the limit, added to.
      real(wp), intent(inout) :: work
      real(wp) :: known(lanes), slips(lanes), total
      integer :: i

      do i = 1, lanes
         known(i) = merge(1.0_wp, 0.0_wp, found(i))
         slips(i) = known(i)*(0.5_wp + sign(0.5_wp, length(i) - least_pivot))
      end do
      call note_slips(ubound(shells%shift, 1), inside, shells%fading/shells%a, u, elastic, known, &
         slips, shells%excess, shells%slipped, shells%shift, shells%direction)
      total = 0.0_wp
      do i = 1, lanes
         total = total + slips(i)*done(i)
      end do
      work = work + total
   end subroutine take_back

   !> The same, of their numbers.
   pure subroutine note_slips(room, inside, per_size, u, elastic, known, slips, excess, slipped, &
      shift, direction)
      !> Shells for which there is room, and those inside.
      integer, intent(in) :: room, inside
      !> What is left of slip about the normal, over the semi-axis [1/m].
      real(wp), intent(in) :: per_size
      !> As of `slip_on_ellipses`.
      real(wp), intent(in) :: u(lanes, 3), elastic(lanes, 3)
      !> One where it is known what a shell does, and where it slips, else zero.
      real(wp), intent(in) :: known(lanes), slips(lanes)
      !> As of `shell_data_type`.
      real(wp), intent(inout) :: excess(room)
      logical, intent(inout) :: slipped(room)
      real(wp), intent(inout), dimension(room, 3) :: shift, direction
      integer :: i, j

      do i = 1, lanes
         j = inside + i
         excess(j) = (1.0_wp - known(i))*excess(j) - known(i)
         direction(j, 1) = (1.0_wp - known(i))*direction(j, 1) + known(i)*u(i, 1)
         direction(j, 2) = (1.0_wp - known(i))*direction(j, 2) + known(i)*u(i, 2)
         direction(j, 3) = (1.0_wp - known(i))*direction(j, 3) + known(i)*u(i, 3)
         shift(j, 1) = (1.0_wp - slips(i))*shift(j, 1) + slips(i)*elastic(i, 1)
         shift(j, 2) = (1.0_wp - slips(i))*shift(j, 2) + slips(i)*elastic(i, 2)
         shift(j, 3) = (1.0_wp - slips(i))*shift(j, 3) + slips(i)*(elastic(i, 3)*per_size)
      end do
      do i = 1, lanes
         slipped(inside + i) = slipped(inside + i) .or. slips(i) > 0.5_wp
      end do
   end subroutine note_slips

   !> Forces of shells of an elliptic spot that slide in the same direction.
   pure subroutine slide_shells(ellipse, n, load, size, u, force)
      type(ellipse_type), intent(inout) :: ellipse
      !> Number of shells, up to `lanes`.
      integer, intent(in) :: n
      !> Within their edges, from the inner edge of the first one on.
      real(wp), intent(in) :: load(0:n), size(0:n)
      !> Direction, of the size one.
      real(wp), intent(in) :: u(3)
      real(wp), intent(inout) :: force(lanes, 3)
      real(wp), dimension(2*few) :: loads, sizes
      real(wp) :: directions(2*few, 3), bears(2*few, n_values)
      integer :: i, j, l

      do l = 1, 3
         do i = 1, 2*few
            directions(i, l) = u(l)
         end do
      end do
      do j = 0, n - 1, 2*few - 1
         do i = 1, 2*few
            loads(i) = load(min(j + i - 1, n))
            sizes(i) = size(min(j + i - 1, n))
         end do
         call slide_few(ellipse, loads, sizes, directions, bears)
         do i = 1, min(2*few - 1, n - j)
            force(j + i, 1) = bears(i + 1, 1) - bears(i, 1)
            force(j + i, 2) = bears(i + 1, 2) - bears(i, 2)
            force(j + i, 3) = bears(i + 1, 3) - bears(i, 3)
         end do
      end do
   end subroutine slide_shells

   !> Put others in the place of shells that are out of all proportion, powers of which would leave
   !> the range of numbers.
   pure subroutine mask_unusual(n, stiffness, trial, held, usual)
      !> Number of shells.
      integer, value :: n
      !> As of `slip_on_ellipses`.
      real(wp), intent(inout), dimension(lanes, 3) :: stiffness, trial, held
      !> One where they are left as they are, else zero.
      real(wp), intent(inout) :: usual(lanes)
      real(wp) :: largest, least, most
      integer :: i, l

      do i = 1, n
         largest = max(abs(trial(i, 1)), abs(trial(i, 2)), abs(trial(i, 3)), abs(held(i, 1)), &
            abs(held(i, 2)), abs(held(i, 3)))
         most = max(stiffness(i, 1), stiffness(i, 2), stiffness(i, 3))
         least = min(stiffness(i, 1), stiffness(i, 2), stiffness(i, 3))
         usual(i) = 0.5_wp + sign(0.5_wp, min(largest_trial - largest, largest_stiffness - most, &
            least - 1.0_wp/largest_stiffness))
      end do
      if (sum(usual(:n)) > n - 0.5_wp) return
      do l = 1, 3
         do i = 1, n
            stiffness(i, l) = merge(stiffness(i, l), 1.0_wp, usual(i) > 0.5_wp)
            trial(i, l) = merge(trial(i, l), 1.0_wp, usual(i) > 0.5_wp)
            held(i, l) = merge(held(i, l), 0.0_wp, usual(i) > 0.5_wp)
         end do
      end do
   end subroutine mask_unusual

   !> First directions of the slips of shells, and which of them surely stick.
   !>
   !> The limit of a shell is about F = 1 (`look_at_limit`), and slip is along the gradient of F.
   !> With G the derivatives of F by the squares of the components, which are one for an ellipsoid,
   !> the force of sliding along u is L u/phi, phi^2 = u.L u, and L_i G_i is nearly constant.
   !>
   !> What slipped in the step before bore b = L u/phi, phi = b.u, which gives L; with that it slips
   !> along p_i = g_i/(L_i + mu K_i) now, and p.L p = phi leaves one unknown, for which Newton takes
   !> a step. Others have the L of their trial, and stick where F is below what it is at any limit.
   !> G where they slip to changes L once more.
   pure subroutine foresee(n, torque, bulge, load, size, stiffness, trial, held, u, sticks)
      !> Number of shells.
      integer, value :: n
      !> Of pure spinning of the spot.
      real(wp), intent(in) :: torque
      !> As of `look_at_limit`.
      real(wp), intent(in) :: bulge(9)
      !> Within the outer and the inner edges.
      real(wp), intent(in) :: load(lanes, 2), size(lanes, 2)
      !> Stiffness, and the force of the trial and that before the step, as of `slip_on_ellipses`.
      real(wp), intent(in) :: stiffness(lanes, 3), trial(lanes, 3), held(lanes, 3)
      !> Direction in the step before, of the size one or zero; then that of this step.
      real(wp), intent(inout) :: u(lanes, 3)
      !> One where a shell surely sticks, else zero.
      real(wp), intent(inout) :: sticks(lanes)
      real(wp) :: plane, spin, k1, k2, k3, g1, g2, g3, b1, b2, b3, u1, u2, u3, borne, known, &
         other, rest, l1, l2, l3, q1, q2, q3, mu, p1, p2, p3, square, slope, along, limit, &
         before1, before2, before3, now1, now2, now3
      integer :: i

      do i = 1, n
         k1 = stiffness(i, 1)
         k2 = stiffness(i, 2)
         k3 = stiffness(i, 3)
         g1 = trial(i, 1)
         g2 = trial(i, 2)
         g3 = trial(i, 3)
         b1 = held(i, 1)
         b2 = held(i, 2)
         b3 = held(i, 3)
         u1 = u(i, 1)
         u2 = u(i, 2)
         u3 = u(i, 3)
         plane = (load(i, 1) - load(i, 2))**2
         spin = (torque*(load(i, 1)*size(i, 1) - load(i, 2)*size(i, 2)))**2
         borne = b1*u1 + b2*u2 + b3*u3
         square = plane*(u1*u1 + u2*u2) + spin*u3*u3
         ! Not where the load has changed by far.
         known = 0.5_wp + sign(0.5_wp, min(borne - least_pivot, alike*square - borne*borne, &
            alike*borne*borne - square))
         other = 1.0_wp - known
         borne = known*borne + other
         mu = known*max(((g1 - b1)*u1 + (g2 - b2)*u2 + (g3 - b3)*u3)/max(k1*u1*u1 + k2*u2*u2 &
            + k3*u3*u3, least_pivot), 0.0_wp)
         ! Squares over those of pure sliding and spinning, times both of these.
         call look_at_limit(bulge, (known*b1*b1 + other*g1*g1)*spin, &
            (known*b2*b2 + other*g2*g2)*spin, (known*b3*b3 + other*g3*g3)*plane, limit, before1, &
            before2, before3)
         sticks(i) = other*(0.5_wp + sign(0.5_wp, surely_stuck*plane*spin - limit))
         rest = known*(least_square/borne) + other
         ! One quotient for three.
         p1 = known*(u1*u1 + least_square) + other*before1
         p2 = known*(u2*u2 + least_square) + other*before2
         p3 = known*(u3*u3 + least_square) + other*before3
         along = 1.0_wp/(p1*p2*p3)
         l1 = (known*max(b1*u1, 0.0_wp) + rest*plane)*(p2*p3*along)
         l2 = (known*max(b2*u2, 0.0_wp) + rest*plane)*(p1*p3*along)
         l3 = (known*max(b3*u3, 0.0_wp) + rest*spin)*(p1*p2*along)
         p1 = l1 + mu*k1
         p2 = l2 + mu*k2
         p3 = l3 + mu*k3
         along = 1.0_wp/(p1*p2*p3)
         q1 = p2*p3*along
         q2 = p1*p3*along
         q3 = p1*p2*along
         p1 = l1*(g1*q1)**2
         p2 = l2*(g2*q2)**2
         p3 = l3*(g3*q3)**2
         square = p1 + p2 + p3
         slope = p1*k1*q1 + p2*k2*q2 + p3*k3*q3
         mu = max(mu + square*(sqrt(square/borne) - 1.0_wp)/max(slope, least_power), 0.0_wp)
         ! Of what follows only ratios count. The force after the slip is along L p.
         q1 = l1 + mu*k1
         q2 = l2 + mu*k2
         q3 = l3 + mu*k3
         p1 = l1*g1*q2*q3
         p2 = l2*g2*q1*q3
         p3 = l3*g3*q1*q2
         call look_at_limit(bulge, p1*p1*spin, p2*p2*spin, p3*p3*plane, limit, now1, now2, now3)
         q1 = l1*before1 + mu*k1*now1
         q2 = l2*before2 + mu*k2*now2
         q3 = l3*before3 + mu*k3*now3
         p1 = g1*now1*q2*q3
         p2 = g2*now2*q1*q3
         p3 = g3*now3*q1*q2
         along = 1.0_wp/sqrt(max(p1*p1 + p2*p2 + p3*p3, least_power))
         u(i, 1) = p1*along
         u(i, 2) = p2*along
         u(i, 3) = p3*along
      end do
   end subroutine foresee

   !> The limit of a shell of an ellipse, about: with x, y and z the squares of the components of a
   !> force over those of pure sliding and pure spinning, s their sum, it is
   !>    F = s + z B(x/s, y/s) = 1,
   !> B a polynomial that does not depend on the shell (scripts/generate_limit.py). F is 0.939 at
   !> least at any limit.
   pure subroutine look_at_limit(bulge, x, y, z, limit, by_x, by_y, by_z)
      !> Coefficients of B, as of `bulges`.
      real(wp), intent(in) :: bulge(9)
      !> >= 0, all in a unit of their own.
      real(wp), intent(in) :: x, y, z
      !> F in that unit, and its derivatives by x, y and z.
      real(wp), intent(out) :: limit, by_x, by_y, by_z
      real(wp) :: s, inverse, p, q, r, b, b_x, b_y, along

      s = max(x + y + z, least_power)
      inverse = 1.0_wp/s
      p = x*inverse
      q = y*inverse
      r = z*inverse
      b = p*(bulge(1) + p*(bulge(3) + p*bulge(6))) + q*(bulge(2) + q*(bulge(5) + q*bulge(9))) &
         + p*q*(bulge(4) + p*bulge(7) + q*bulge(8))
      b_x = bulge(1) + p*(2.0_wp*bulge(3) + 3.0_wp*p*bulge(6)) &
         + q*(bulge(4) + 2.0_wp*p*bulge(7) + q*bulge(8))
      b_y = bulge(2) + q*(2.0_wp*bulge(5) + 3.0_wp*q*bulge(9)) &
         + p*(bulge(4) + p*bulge(7) + 2.0_wp*q*bulge(8))
      along = p*b_x + q*b_y
      limit = s*(1.0_wp + r*b)
      ! On needles the gradient of this F may turn back.
      by_x = max(1.0_wp + r*(b_x - along), least_slope)
      by_y = max(1.0_wp + r*(b_y - along), least_slope)
      by_z = max(1.0_wp + b - r*along, least_slope)
   end subroutine look_at_limit

   !> Whether a force is surely within the limit of a shell: between one of sliding and the double
   !> cone of pure sliding and pure spinning.
   pure logical function within_limit(load, torque, force, f)
      !> Force of pure sliding and torque of pure spinning.
      real(wp), intent(in) :: load, torque
      real(wp), intent(in) :: force(3)
      !> That of sliding in a direction.
      real(wp), intent(in) :: f(3)
      real(wp) :: rest(3), size, share

      ! The part of f that leaves the least.
      size = sqrt(f(1)**2 + f(2)**2)
      if (size*torque > abs(f(3))*load) then
         share = (force(1)*f(1) + force(2)*f(2))/size**2
      else if (abs(force(3)) < abs(f(3))) then
         share = force(3)/f(3)
      else
         share = merge(1.0_wp, 0.0_wp, min(force(3)*sign(1.0_wp, f(3)), abs(f(3))) > 0.0_wp)
      end if
      share = min(max(share, 0.0_wp), 1.0_wp)
      rest = force - share*f
      size = sqrt(rest(1)**2 + rest(2)**2)
      within_limit = size*torque + abs(rest(3))*load <= (1.0_wp - share)*load*torque
   end function within_limit

end module contensou_contact_tangential_abreast
