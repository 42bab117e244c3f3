!> Sliding of elliptic spots that are not needles, by a table, and the slip of their shells, side by
!> side.
!>
!> The exact wrench in units f N and f N a, with W = a w, A = W^2 + s, B = k^2 W^2 + s,
!> S = sqrt(s)/sqrt(A B), c = 1 - k^2, rho^2 the s of the ellipse through the centre of rotation
!> confocal with the spot, or zero where that is inside, and integrals over s from rho^2 to
!> infinity:
!>    J_bb = int S/B^2 = R_bb + (2/3) s S/B^2,         J_ab = int S/(A B) = R_ab + (2/3) s S/(A B),
!>    J_aa = int S/A^2 = k^2 J_bb + (2/3) c s S/(A B) = R_aa + (2/3) s S/A^2,
!>    E_a = 3 J_aa + k^2 J_ab,   E_b = J_ab + 3 k^2 J_bb,
!>    r_a = (v_y^2 R_aa + v_x^2 R_ab)/W^2,   r_b = (v_x^2 R_bb + v_y^2 R_ab)/W^2,
!>    F_x = -(3/4) v_x [W^2 (E_b - r_b) + (4/3) s S/B],   F_y with E_a, r_a and A,
!>    T = (3/16) W [2 (v_y^2 E_a + v_x^2 E_b) - 3 (v_y^2 r_a + v_x^2 r_b) - W^2 (E_a + k^2 E_b)
!>        - 2 s S (1/A + k^2/B)],   dF_x/dW = (3/4) v_x W (E_b - 3 r_b).
!> Integration by parts takes them out of those of `contensou_contact_wrench_exact`, with
!> v_y^2/A + v_x^2/B = 1 where rho > 0. R/W^2 is finite for all rho, and nothing cancels for large
!> rho. Two functions remain: R_bb B^2 and R_ab A B times (sqrt(k) W + rho)/W^2 are analytic in
!> x = rho/(sqrt(k) W + rho). They are tabulated by k (scripts/generate_ellipse.py), and a part of
!> the table is made for the k of a spot where it is needed first.
module contensou_contact_tangential_ellipse
   use contensou_base_kinds, only : wp
   use contensou_contact_spot, only : spot_shape_type
   use contensou_contact_tangential_ellipse_values, only : band_degree, bands, degree, first, &
      least_ratio, parts, powers, values
   use contensou_contact_tangential_slip, only : abreast, close_by_bends, close_enough, &
      close_to_limit, least_pivot, least_spin, longest_step, most_passes, short_slip, &
      smallest_force, within_limit
   implicit none(type, external)
   private

   public :: ellipse_type, least_ratio, slip_on_ellipses

   !> What a spot keeps of the table.
   type :: ellipse_type
      private
      !> Axis ratio for which it is made, and its root.
      real(wp) :: k = 0.0_wp, root_k = 0.0_wp
      !> Part of the interval of ln k, and the place there, from -1 to 1.
      integer :: band = 0
      real(wp) :: place = 0.0_wp
      !> Which parts are made.
      logical :: made(0:parts - 1) = .false.
      !> The two functions by powers of x.
      real(wp) :: table(2, 0:degree, 0:parts - 1) = 0.0_wp
   contains
      procedure :: slide
   end type ellipse_type

   !> Length of a part of the interval of ln k.
   real(wp), parameter :: band_width = -log(least_ratio)/real(bands, wp)

   !> Sizes of an edge below this are those of one at the very centre, which bears nothing.
   real(wp), parameter :: least_size = 1.0e-20_wp

   !> Forces of trials above this, and stiffness beyond it or its inverse, are left to others.
   real(wp), parameter :: largest_trial = 1.0e30_wp

   !> Square of a component of a direction below which it is not known what bears it.
   real(wp), parameter :: least_square = 1.0e-8_wp

   !> By how much squares of what is borne may differ from those of pure sliding and spinning.
   real(wp), parameter :: alike = 100.0_wp

   !> Bend of the limit of a shell, for the first direction.
   real(wp), parameter :: bend = 0.4_wp

   !> Speeds and their powers below this are none.
   real(wp), parameter :: least_speed = 1.0e-200_wp

   !> What edges bear: the force (3); its derivatives 11, 12, 22, 13, 23, 33; and the second
   !> derivatives of F_x by xx, xy, yy, and of F_y by yy.
   integer, parameter :: n_values = 13

contains

   !> Forces of sliding of what is within edges, and their derivatives: to some 1e-15 and 1e-14.
   pure subroutine slide(self, shape, n, load, size, u, bears)
      class(ellipse_type), intent(inout) :: self
      !> Axis ratio not below the least one. The table is made where it is not that of the call
      !> before.
      type(spot_shape_type), intent(in) :: shape
      !> Number of edges.
      integer, intent(in) :: n
      real(wp), intent(in) :: load(2*abreast), size(2*abreast)
      !> Sliding velocity along the axes and spin times the semi-axis, of the size one.
      real(wp), intent(in) :: u(2*abreast, 3)
      real(wp), intent(inout) :: bears(2*abreast, n_values)
      real(wp), dimension(2*abreast) :: rho, h, q, x
      real(wp) :: found(2, 2*abreast)
      real(wp) :: k2, c, root_k, w, w2, ux, uy, ux2, uy2, excess, s, root, far, l, total, a, b, &
         ab, inverse, per_a, per_b, end, ends, end_a, end_b, jaa, jab, jbb, raa, rab, rbb, ea, eb, &
         ra, rb, force_a, force_b, rest_a, rest_b, weight, arm
      integer :: i

      if (abs(self%k - shape%k) > 0.0_wp) call set_ratio(self, shape%k)
      k2 = shape%k2
      c = shape%c
      root_k = self%root_k
      do i = 1, n
         w = max(size(i), least_size)*abs(u(i, 3))
         w2 = w*w
         ux2 = u(i, 1)**2
         excess = max(ux2 + k2*((abs(u(i, 2)) - w)*(abs(u(i, 2)) + w)), 0.0_wp)
         s = ux2 + (abs(u(i, 2)) - w)*(abs(u(i, 2)) + w) - k2*w2
         root = sqrt(s*s + 4.0_wp*w2*excess)
         total = root + abs(s)
         far = 0.5_wp + sign(0.5_wp, s)
         l = far*0.5_wp*total + (1.0_wp - far)*2.0_wp*w2*excess/max(total, least_speed)
         rho(i) = sqrt(l)
         total = max(root_k*w + rho(i), least_size)
         ab = max((w2 + l)*(k2*w2 + l), least_speed)
         inverse = 1.0_wp/(total*ab)
         h(i) = ab*inverse
         q(i) = total*inverse
         x(i) = rho(i)*h(i)
      end do
      call look_up(self, n, x, found)
      do i = 1, n
         ux = u(i, 1)
         uy = u(i, 2)
         w = max(size(i), least_size)*u(i, 3)
         weight = 0.75_wp*load(i)
         arm = weight*size(i)
         ux2 = ux*ux
         uy2 = uy*uy
         w2 = w*w
         l = rho(i)*rho(i)
         a = w2 + l
         b = k2*w2 + l
         per_a = b*q(i)
         per_b = a*q(i)
         end = rho(i)*sqrt(q(i))
         ends = (2.0_wp/3.0_wp)*l*end
         end_a = ends*per_a
         end_b = ends*per_b
         rbb = found(1, i)*h(i)*per_b*per_b
         rab = found(2, i)*h(i)*q(i)
         jbb = w2*rbb + end_b*per_b
         jab = w2*rab + end_b*per_a
         jaa = k2*jbb + c*ends*q(i)
         raa = k2*rbb + c*ends*(l + k2*(l + 2.0_wp*w2))*q(i)*q(i)
         ea = 3.0_wp*jaa + k2*jab
         eb = jab + 3.0_wp*k2*jbb
         ra = uy2*raa + ux2*rab
         rb = ux2*rbb + uy2*rab
         force_a = weight*(w2*(ea - ra) + 2.0_wp*end_a)
         force_b = weight*(w2*(eb - rb) + 2.0_wp*end_b)
         rest_a = arm*(ea - 3.0_wp*ra)
         rest_b = arm*(eb - 3.0_wp*rb)
         bears(i, 1) = ux*force_b
         bears(i, 2) = uy*force_a
         bears(i, 3) = 0.25_wp*arm*w*(w2*(ea + k2*eb) + 3.0_wp*(end_a + k2*end_b) &
            + 3.0_wp*(uy2*ra + ux2*rb) - 2.0_wp*(uy2*ea + ux2*eb))
         jbb = 2.0_wp*weight*jbb
         jab = 2.0_wp*weight*jab
         jaa = 2.0_wp*weight*jaa
         bears(i, 4) = force_b - ux2*jbb
         bears(i, 5) = -ux*uy*jab
         bears(i, 6) = force_a - uy2*jaa
         bears(i, 7) = -ux*w*rest_b
         bears(i, 8) = -uy*w*rest_a
         bears(i, 9) = size(i)*(ux2*rest_b + uy2*rest_a)
         ! rho changes where U = 0.
         per_b = ux*per_b
         per_a = uy*per_a
         end = 4.0_wp*weight*end/max(per_a*per_a + per_b*per_b, least_speed)
         bears(i, 10) = end*per_b*per_b*per_b - 3.0_wp*ux*jbb
         bears(i, 11) = end*per_b*per_b*per_a - uy*jab
         bears(i, 12) = end*per_b*per_a*per_a - ux*jab
         bears(i, 13) = end*per_a*per_a*per_a - 3.0_wp*uy*jaa
      end do
   end subroutine slide

   !> The two functions of the table.
   pure subroutine look_up(self, n, x, found)
      class(ellipse_type), intent(inout) :: self
      integer, intent(in) :: n
      !> From 0 to 1.
      real(wp), intent(in) :: x(2*abreast)
      real(wp), intent(inout) :: found(2, 2*abreast)
      real(wp) :: place, both(2)
      integer :: i, j, part

      do i = 1, n
         place = x(i)*parts
         part = max(min(int(place), parts - 1), 0)
         if (.not. self%made(part)) call make_part(self, part)
         place = 2.0_wp*(place - real(part, wp)) - 1.0_wp
         both = self%table(:, degree, part)
         do j = degree - 1, 0, -1
            both = both*place + self%table(:, j, part)
         end do
         found(:, i) = both
      end do
   end subroutine look_up

   !> Set the axis ratio.
   pure subroutine set_ratio(self, k)
      class(ellipse_type), intent(inout) :: self
      !> Not below the least one.
      real(wp), intent(in) :: k
      real(wp) :: place

      self%k = k
      self%root_k = sqrt(k)
      place = -log(k)*(1.0_wp/band_width)
      self%band = min(int(place), bands - 1)
      self%place = 1.0_wp - 2.0_wp*(place - real(self%band, wp))
      self%made = .false.
   end subroutine set_ratio

   !> Make a part of the table for the axis ratio.
   pure subroutine make_part(self, part)
      class(ellipse_type), intent(inout) :: self
      integer, intent(in) :: part
      real(wp) :: rows(2, 0:degree), place
      integer :: i, j, at, number

      rows = 0.0_wp
      place = self%place
      at = first(part, self%band)
      do j = band_degree, 0, -1
         number = powers(j, part, self%band)
         do i = 0, number - 1
            rows(1, i) = rows(1, i)*place + values(1, at + i)
            rows(2, i) = rows(2, i)*place + values(2, at + i)
         end do
         at = at + number
      end do
      self%table(:, :, part) = rows
      self%made(part) = .true.
   end subroutine make_part

   !> Slip of shells side by side. What a few steps do not find is left to others.
   pure subroutine slip_on_ellipses(ellipse, shape, n, load, size, stiffness, trial, held, &
      steady, u, force, found, slips)
      type(ellipse_type), intent(inout) :: ellipse
      type(spot_shape_type), intent(in) :: shape
      !> Number of shells.
      integer, intent(in) :: n
      !> Of the outer and of the inner edges.
      real(wp), intent(in) :: load(2, abreast), size(2, abreast)
      !> In units of f N and of a length, and the force of the trial.
      real(wp), intent(in) :: stiffness(abreast, 3), trial(abreast, 3)
      !> Force before the step where a shell slipped in the step before, or zero.
      real(wp), intent(in) :: held(abreast, 3)
      !> Whether all go on to slip as they did.
      logical, intent(in) :: steady
      !> Direction in the step before, of the size one or zero; that of the slip or where the shell
      !> bears the most before it slips.
      real(wp), intent(inout) :: u(abreast, 3)
      !> Force of sliding.
      real(wp), intent(inout) :: force(abreast, 3)
      !> Whether it is known what a shell does, and whether it slips.
      logical, intent(inout) :: found(abreast), slips(abreast)
      real(wp), dimension(abreast, 3) :: k, g, b, v, new, f
      real(wp), dimension(2, abreast) :: loads, sizes
      real(wp) :: length(abreast), off(abreast), short(abreast), torque
      integer :: at(abreast), i, j, m, pass

      found(:n) = .false.
      m = 0
      do i = 1, n
         ! Powers of what is out of all proportion would leave the range of numbers.
         if (max(abs(trial(i, 1)), abs(trial(i, 2)), abs(trial(i, 3))) > largest_trial) cycle
         if (max(stiffness(i, 1), stiffness(i, 2), stiffness(i, 3)) > largest_trial) cycle
         if (min(stiffness(i, 1), stiffness(i, 2), stiffness(i, 3)) < 1.0_wp/largest_trial) cycle
         if (max(abs(held(i, 1)), abs(held(i, 2)), abs(held(i, 3))) > largest_trial) cycle
         m = m + 1
         at(m) = i
         loads(:, m) = load(:, i)
         sizes(:, m) = size(:, i)
         k(m, :) = stiffness(i, :)
         g(m, :) = trial(i, :)
         b(m, :) = held(i, :)
         v(m, :) = u(i, :)
         short(m) = short_slip*sqrt((g(m, 1)/k(m, 1))**2 + (g(m, 2)/k(m, 2))**2 &
            + (g(m, 3)/k(m, 3))**2)
      end do
      if (m == 0) return
      if (.not. steady) call foresee(shape, m, loads, sizes, k, g, b, v)
      do pass = 1, most_passes
         call step_on_ellipses(ellipse, shape, m, loads, sizes, k, g, short, v, length, off, &
            new, f)
         j = 0
         do i = 1, m
            if (length(i) <= 0.0_wp .and. off(i) > 0.0_wp) then
               torque = shape%torque*(loads(1, i)*sizes(1, i) - loads(2, i)*sizes(2, i))
               if (within_limit(loads(1, i) - loads(2, i), torque, g(i, :), f(i, :))) then
                  off(i) = 0.0_wp
                  new(i, :) = v(i, :)
               end if
            end if
            if (off(i) <= 0.0_wp) then
               found(at(i)) = .true.
               slips(at(i)) = length(i) > 0.0_wp
               u(at(i), :) = new(i, :)
               force(at(i), :) = f(i, :)
            else
               j = j + 1
               at(j) = at(i)
               loads(:, j) = loads(:, i)
               sizes(:, j) = sizes(:, i)
               k(j, :) = k(i, :)
               g(j, :) = g(i, :)
               short(j) = short(i)
               v(j, :) = new(i, :)
            end if
         end do
         m = j
         if (m == 0) exit
      end do
   end subroutine slip_on_ellipses

   !> First directions of the slips of shells, by limits that are ellipsoids about.
   !>
   !> The force of sliding along u is A u/phi, phi^2 = u.A u, A diagonal. What slipped in the step
   !> before bore b = A u/phi, phi = b.u: with L = A/phi it slips along p_i = g_i/(L_i + mu K_i)
   !> now, and p.L p = phi leaves one unknown, for which Newton takes a step. Pure sliding and pure
   !> spinning tell A of others. A is not constant: with r the share of spinning in u.A u by these
   !> two it is as 1 - bend r^2 in the plane, and as 1 - bend (1 - r)^2 about the normal.
   pure subroutine foresee(shape, n, load, size, stiffness, trial, held, u)
      type(spot_shape_type), intent(in) :: shape
      !> Number of shells.
      integer, intent(in) :: n
      !> Of the outer and of the inner edges.
      real(wp), intent(in) :: load(2, abreast), size(2, abreast)
      !> Stiffness, and the force of the trial and that before the step, as of `slip_on_ellipses`.
      real(wp), intent(in) :: stiffness(abreast, 3), trial(abreast, 3), held(abreast, 3)
      !> Direction in the step before, of the size one or zero; then that of this step.
      real(wp), intent(inout) :: u(abreast, 3)
      real(wp) :: plane, spin, k1, k2, k3, g1, g2, g3, b1, b2, b3, u1, u2, u3, borne, known, &
         rest, l1, l2, l3, arm, share, c1, c3, q1, q2, q3, mu, p1, p2, p3, square, slope, along
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
         plane = (load(1, i) - load(2, i))**2
         spin = (shape%torque*(load(1, i)*size(1, i) - load(2, i)*size(2, i)))**2
         borne = b1*u1 + b2*u2 + b3*u3
         square = plane*(u1*u1 + u2*u2) + spin*u3*u3
         ! Not where the load has changed by far.
         known = 0.5_wp + sign(0.5_wp, min(borne - least_pivot, alike*square - borne*borne, &
            alike*borne*borne - square))
         borne = known*borne + (1.0_wp - known)
         rest = least_square/borne
         l1 = (known*max(b1*u1, 0.0_wp) + rest*plane)/(known*u1*u1 + least_square)
         l2 = (known*max(b2*u2, 0.0_wp) + rest*plane)/(known*u2*u2 + least_square)
         l3 = (known*max(b3*u3, 0.0_wp) + rest*spin)/(known*u3*u3 + least_square)
         mu = known*max(((g1 - b1)*u1 + (g2 - b2)*u2 + (g3 - b3)*u3)/max(k1*u1*u1 + k2*u2*u2 &
            + k3*u3*u3, least_pivot), 0.0_wp)
         ! Of others p is the direction of a short slip.
         arm = spin/plane
         p1 = known*u1 + (1.0_wp - known)*g1/plane
         p2 = known*u2 + (1.0_wp - known)*g2/plane
         p3 = known*u3 + (1.0_wp - known)*g3/spin
         share = arm*p3*p3
         share = share/max(p1*p1 + p2*p2 + share, least_speed)
         c1 = 1.0_wp - bend*share*share
         c3 = 1.0_wp - bend*(1.0_wp - share)**2
         q1 = known + (1.0_wp - known)*c1
         q3 = known + (1.0_wp - known)*c3
         l1 = l1*q1
         l2 = l2*q1
         l3 = l3*q3
         q1 = 1.0_wp/(l1 + mu*k1)
         q2 = 1.0_wp/(l2 + mu*k2)
         q3 = 1.0_wp/(l3 + mu*k3)
         p1 = g1*q1
         p2 = g2*q2
         p3 = g3*q3
         share = arm*p3*p3
         share = share/max(p1*p1 + p2*p2 + share, least_speed)
         p1 = l1*p1*p1
         p2 = l2*p2*p2
         p3 = l3*p3*p3
         square = p1 + p2 + p3
         slope = p1*k1*q1 + p2*k2*q2 + p3*k3*q3
         mu = max(mu + square*(sqrt(square/borne) - 1.0_wp)/max(slope, least_speed), 0.0_wp)
         c1 = (1.0_wp - bend*share*share)/c1
         c3 = (1.0_wp - bend*(1.0_wp - share)**2)/c3
         p1 = g1/(l1*c1 + mu*k1)
         p2 = g2/(l2*c1 + mu*k2)
         p3 = g3/(l3*c3 + mu*k3)
         along = 1.0_wp/sqrt(max(p1*p1 + p2*p2 + p3*p3, least_speed))
         u(i, 1) = p1*along
         u(i, 2) = p2*along
         u(i, 3) = p3*along
      end do
   end subroutine foresee

   !> Steps of the directions u of the slips of shells, as those of `slip_on_ellipse`.
   pure subroutine step_on_ellipses(ellipse, shape, n, load, size, stiffness, trial, short, u, &
      length, off, new, force)
      type(ellipse_type), intent(inout) :: ellipse
      type(spot_shape_type), intent(in) :: shape
      !> Number of shells.
      integer, intent(in) :: n
      !> Of the outer and of the inner edges.
      real(wp), intent(in) :: load(2, abreast), size(2, abreast)
      !> Stiffness, and the force of the trial.
      real(wp), intent(in) :: stiffness(abreast, 3), trial(abreast, 3)
      !> A short slip.
      real(wp), intent(in) :: short(abreast)
      !> Directions, of the size one.
      real(wp), intent(in) :: u(abreast, 3)
      !> Length of the slip, > 0 if a shell slips.
      real(wp), intent(inout) :: length(abreast)
      !> Not above zero where the step is the last one.
      real(wp), intent(inout) :: off(abreast)
      !> The direction after it, and the force there.
      real(wp), intent(inout) :: new(abreast, 3), force(abreast, 3)
      real(wp) :: bears(2, abreast, n_values), all_u(2, abreast, 3), f1, f2, f3, h11, h12, h22, &
         h13, h23, h33, b1, b2, b3, b4, k1, k2, k3, g1, g2, g3, u1, u2, u3, part, spring, slip, &
         r1, r2, r3, a11, a21, a31, a22, a32, a33, l21, l31, l32, p1, p2, p3, m1, m2, m3, x, y, &
         share, inverse, c1, c2, c3, bent, first_size, more_size, good, slips, fine, square, &
         tolerance, along, borne, stiff, radius
      integer :: i

      do i = 1, n
         all_u(:, i, 1) = u(i, 1)
         all_u(:, i, 2) = u(i, 2)
         all_u(:, i, 3) = u(i, 3)
      end do
      call ellipse%slide(shape, 2*n, load, size, all_u, bears)
      do i = 1, n
         k1 = stiffness(i, 1)
         k2 = stiffness(i, 2)
         k3 = stiffness(i, 3)
         g1 = trial(i, 1)
         g2 = trial(i, 2)
         g3 = trial(i, 3)
         u1 = u(i, 1)
         u2 = u(i, 2)
         u3 = u(i, 3)
         f1 = bears(1, i, 1) - bears(2, i, 1)
         f2 = bears(1, i, 2) - bears(2, i, 2)
         f3 = bears(1, i, 3) - bears(2, i, 3)
         h11 = bears(1, i, 4) - bears(2, i, 4)
         h12 = bears(1, i, 5) - bears(2, i, 5)
         h22 = bears(1, i, 6) - bears(2, i, 6)
         h13 = bears(1, i, 7) - bears(2, i, 7)
         h23 = bears(1, i, 8) - bears(2, i, 8)
         h33 = bears(1, i, 9) - bears(2, i, 9)
         b1 = bears(1, i, 10) - bears(2, i, 10)
         b2 = bears(1, i, 11) - bears(2, i, 11)
         b3 = bears(1, i, 12) - bears(2, i, 12)
         b4 = bears(1, i, 13) - bears(2, i, 13)
         along = g1*u1 + g2*u2 + g3*u3
         borne = max(f1*u1 + f2*u2 + f3*u3, least_pivot)
         stiff = k1*u1*u1 + k2*u2*u2 + k3*u3*u3
         inverse = 1.0_wp/(borne*stiff)
         slip = (along - borne)*borne*inverse
         length(i) = slip
         ! Where nothing slips what is sought is the direction whose force is along the trial.
         slips = merge(1.0_wp, 0.0_wp, slip > 0.0_wp)
         part = slips + (1.0_wp - slips)*max(along*stiff*inverse, 0.0_wp)
         slip = max(slip, 0.0_wp)
         spring = slip + (1.0_wp - slips)*short(i)
         r1 = g1 - part*f1 - slip*k1*u1
         r2 = g2 - part*f2 - slip*k2*u2
         r3 = g3 - part*f3 - slip*k3*u3
         ! (H + s K) p = r by squares.
         a11 = 1.0_wp/max(part*h11 + spring*k1, spring*k1, least_pivot)
         a21 = part*h12
         a31 = part*h13
         l21 = a21*a11
         l31 = a31*a11
         a22 = part*h22 + spring*k2
         a22 = 1.0_wp/max(a22 - l21*a21, epsilon(a22)*a22, spring*k2, least_pivot)
         a32 = part*h23 - l31*a21
         l32 = a32*a22
         a33 = part*h33 + spring*k3
         a33 = 1.0_wp/max(a33 - l31*a31 - l32*a32, epsilon(a33)*a33, spring*k3, least_pivot)
         p2 = r2 - l21*r1
         p3 = (r3 - l31*r1 - l32*p2)*a33
         p2 = p2*a22 - l32*p3
         p1 = r1*a11 - l21*p2 - l31*p3
         first_size = max(abs(p1), abs(p2), abs(p3))
         ! What the second derivatives add; a step along u changes nothing.
         inverse = 1.0_wp/sign(max(abs(u3), least_spin), u3)
         share = p3*inverse
         x = p1 - share*u1
         y = p2 - share*u2
         c1 = b1*x*x + 2.0_wp*b2*x*y + b3*y*y
         c2 = b2*x*x + 2.0_wp*b3*x*y + b4*y*y
         m1 = h11*x + h12*y
         m2 = h12*x + h22*y
         m3 = h13*x + h23*y
         c3 = -(m1*x + m2*y + c1*u1 + c2*u2)*inverse
         c1 = c1 - 2.0_wp*share*m1
         c2 = c2 - 2.0_wp*share*m2
         c3 = c3 - 2.0_wp*share*m3
         m2 = c2 - l21*c1
         m3 = (c3 - l31*c1 - l32*m2)*a33
         m2 = m2*a22 - l32*m3
         m1 = c1*a11 - l21*m2 - l31*m3
         more_size = 0.5_wp*max(abs(m1), abs(m2), abs(m3))
         good = slips*(0.5_wp + sign(0.5_wp, min(abs(u3) - least_spin, 0.5_wp*first_size &
            - more_size)))
         p1 = p1 - 0.5_wp*good*m1
         p2 = p2 - 0.5_wp*good*m2
         p3 = p3 - 0.5_wp*good*m3
         ! The force after the step; where nothing slips that at the direction itself.
         c1 = 0.5_wp*good*c1
         c2 = 0.5_wp*good*c2
         c3 = 0.5_wp*good*c3
         m1 = h11*p1 + h12*p2 + h13*p3
         m2 = h12*p1 + h22*p2 + h23*p3
         m3 = h13*p1 + h23*p2 + h33*p3
         force(i, 1) = f1 + slips*(m1 + c1)
         force(i, 2) = f2 + slips*(m2 + c2)
         force(i, 3) = f3 + slips*(m3 + c3)
         ! Across the direction, back to the size one: by the tangent of the angle.
         along = p1*u1 + p2*u2 + p3*u3
         radius = max(1.0_wp + good*along, 0.5_wp)
         p1 = p1 - along*u1
         p2 = p2 - along*u2
         p3 = p3 - along*u3
         square = p1*p1 + p2*p2 + p3*p3
         ! Each order is to the next one as that was to it.
         fine = good*(0.5_wp + sign(0.5_wp, smallest_force*first_size - more_size*more_size))
         tolerance = close_enough + fine*(close_by_bends - close_enough)
         tolerance = (tolerance + (1.0_wp - slips)*(close_to_limit - tolerance))*radius
         bent = c1*c1 + c2*c2 + c3*c3
         off(i) = max(square - tolerance*tolerance, &
            slips*(bent*bent - smallest_force*smallest_force*(m1*m1 + m2*m2 + m3*m3)))
         radius = max(radius, (1.0_wp/longest_step)*sqrt(square))
         inverse = 1.0_wp/sqrt(square + radius*radius)
         new(i, 1) = (radius*u1 + p1)*inverse
         new(i, 2) = (radius*u2 + p2)*inverse
         new(i, 3) = (radius*u3 + p3)*inverse
      end do
   end subroutine step_on_ellipses

end module contensou_contact_tangential_ellipse
