!> A step of shells of an elliptic spot side by side.
!>
!> This file is compiled for `lanes` shells, the number of loops' rounds, and again for half of
!> them, so that nothing of a loop is left over for one at a time; and both for all registers, see
!> `contensou_contact_tangential_abreast`. So it uses little of the library, and modules whose
!> procedures are only called now and then.
!>
!> On ellipses the exact wrench in units f N and f N a is, with W = a w, A = W^2 + s,
!> B = k^2 W^2 + s, S = sqrt(s)/sqrt(A B), c = 1 - k^2, rho^2 the s of the ellipse through the
!> centre of rotation confocal with the spot, or zero where that is inside, and integrals over s
!> from rho^2 to infinity:
!>    J_bb = int S/B^2 = R_bb + (2/3) s S/B^2,         J_ab = int S/(A B) = R_ab + (2/3) s S/(A B),
!>    J_aa = int S/A^2 = k^2 J_bb + (2/3) c s S/(A B) = R_aa + (2/3) s S/A^2,
!>    E_a = 3 J_aa + k^2 J_ab,   E_b = J_ab + 3 k^2 J_bb,
!>    r_a = (v_y^2 R_aa + v_x^2 R_ab)/W^2,   r_b = (v_x^2 R_bb + v_y^2 R_ab)/W^2,
!>    F_x = -(3/4) v_x [W^2 (E_b - r_b) + (4/3) s S/B],   F_y with E_a, r_a and A,
!>    T = (3/16) W [2 (v_y^2 E_a + v_x^2 E_b) - 3 (v_y^2 r_a + v_x^2 r_b) - W^2 (E_a + k^2 E_b)
!>        - 2 s S (1/A + k^2/B)],   dF_x/dW = (3/4) v_x W (E_b - 3 r_b).
!> Integration by parts takes them out of those of `contensou_contact_wrench_exact`, with
!> v_y^2/A + v_x^2/B = 1 where rho > 0. R/W^2 is finite for all rho, and nothing cancels for large
!> rho. R_bb and R_ab come from the table of `contensou_contact_tangential_ellipse`.
module contensou_contact_tangential_ellipse_pass
   use contensou_base_kinds, only : wp
   use contensou_contact_tangential_ellipse, only : ellipse_type, last_pair
   use contensou_contact_tangential_ellipse_values, only : first, lengths, parts, &
      values, width
   implicit none(type, external)
   private

   public :: pass_on_ellipses, slide_on_ellipse, lanes, n_values, close_by_bends, close_enough, &
      close_to_limit, least_pivot, least_power, least_spin, longest_step, smallest_force

   !> Shells side by side, and their edges: the outer ones, then the inner ones.
   integer, parameter :: lanes = 8, edges = 2*lanes

   !> What an edge of an ellipse bears: the force (3); its derivatives 11, 12, 22, 13, 23, 33; and
   !> the second derivatives of F_x by xx, xy, yy, and of F_y by yy.
   integer, parameter :: n_values = 13

   !> A step of the direction of slip below this size is the last one: the next one is its square.
   real(wp), parameter :: close_enough = 3.0e-7_wp

   !> The same of a step that takes the second derivatives of the force: the next one is its cube.
   real(wp), parameter :: close_by_bends = 1.0e-4_wp

   !> The same where a shell sticks.
   real(wp), parameter :: close_to_limit = 1.0e-6_wp

   !> What a force may be off where this is estimated, in units of f N.
   real(wp), parameter :: smallest_force = 1.0e-12_wp

   !> Share of spinning in a direction above which the second derivatives are taken: those by it are
   !> divided by it.
   real(wp), parameter :: least_spin = 1.0e-3_wp

   !> What is divided by is not below this where it may be a power of a speed.
   real(wp), parameter :: least_power = 1.0e-200_wp

   !> Sizes of an edge below this are those of one at the very centre, which bears nothing.
   real(wp), parameter :: least_size = 1.0e-20_wp

   !> Least pivot of a step.
   real(wp), parameter :: least_pivot = 1.0e-100_wp

   !> Where nothing slips, the most by which the force of sliding is more than that of the trial.
   real(wp), parameter :: most_part = 1.0e8_wp

   !> Longest step of a direction.
   real(wp), parameter :: longest_step = 0.5_wp

contains

   !> A step of all shells side by side, and what is known after it.
   pure subroutine pass_on_ellipses(ellipse, torque, load, size, stiffness, trial, short, v, &
      unknown, u, force, length)
      type(ellipse_type), intent(inout) :: ellipse
      !> As of `slip_on_ellipses`.
      real(wp), intent(in) :: torque, load(lanes, 2), size(lanes, 2), stiffness(lanes, 3), &
         trial(lanes, 3)
      !> A short slip.
      real(wp), intent(in) :: short(lanes)
      !> Directions, of the size one.
      real(wp), intent(inout) :: v(lanes, 3)
      !> One where it is not known what a shell does, else zero.
      real(wp), intent(inout) :: unknown(lanes)
      !> As of `slip_on_ellipses`, of those of which it is known now.
      real(wp), intent(inout) :: u(lanes, 3), force(lanes, 3), length(lanes)
      real(wp) :: slip(lanes), off(lanes), new(lanes, 3), f(lanes, 3), sticks(lanes), ends(lanes)
      integer :: i

      call step_on_ellipses(ellipse, load, size, stiffness, trial, short, v, slip, off, new, &
         f)
      sticks = 0.0_wp
      ! In most passes all slip.
      if (any(slip <= 0.0_wp .and. unknown > 0.5_wp)) call find_stuck(torque, load, size, trial, &
         f, slip, sticks)
      do i = 1, lanes
         ends(i) = 0.5_wp - sign(0.5_wp, off(i))
         ends(i) = max(sticks(i), ends(i))*unknown(i)
         unknown(i) = unknown(i) - ends(i)
      end do
      do i = 1, lanes
         ! Where it sticks the direction stays.
         if (sticks(i) < 0.5_wp) then
            v(i, 1) = new(i, 1)
            v(i, 2) = new(i, 2)
            v(i, 3) = new(i, 3)
         end if
      end do
      do i = 1, lanes
         if (ends(i) > 0.5_wp) then
            length(i) = slip(i)
            u(i, 1) = v(i, 1)
            u(i, 2) = v(i, 2)
            u(i, 3) = v(i, 3)
            force(i, 1) = f(i, 1)
            force(i, 2) = f(i, 2)
            force(i, 3) = f(i, 3)
         end if
      end do
   end subroutine pass_on_ellipses

   !> Which of the shells that do not slip surely stick.
   pure subroutine find_stuck(torque, load, size, trial, force, slip, sticks)
      !> As of `pass_on_ellipses`.
      real(wp), intent(in) :: torque, load(lanes, 2), size(lanes, 2), trial(lanes, 3)
      !> Force of sliding in the direction at hand, and the length of the slip.
      real(wp), intent(in) :: force(lanes, 3), slip(lanes)
      !> One where a shell sticks, else zero.
      real(wp), intent(inout) :: sticks(lanes)
      real(wp) :: bears, arm, g1, g2, g3, f1, f2, f3, plane, across, spin, about, part, share, rest
      integer :: i

      do i = 1, lanes
         ! As `within_limit`.
         bears = load(i, 1) - load(i, 2)
         arm = torque*(load(i, 1)*size(i, 1) - load(i, 2)*size(i, 2))
         g1 = trial(i, 1)
         g2 = trial(i, 2)
         g3 = trial(i, 3)
         f1 = force(i, 1)
         f2 = force(i, 2)
         f3 = force(i, 3)
         plane = f1*f1 + f2*f2
         spin = f3*f3
         across = g1*f1 + g2*f2
         about = g3*f3
         ! The part of f that leaves the least. A half and a sign are a condition without a branch.
         share = 0.5_wp + sign(0.5_wp, about)
         part = 0.5_wp + sign(0.5_wp, spin - abs(about))
         share = share + part*(about/max(spin, least_power) - share)
         part = 0.5_wp + sign(0.5_wp, plane*arm*arm - spin*bears*bears)
         share = share + part*(across/max(plane, least_power) - share)
         share = min(max(share, 0.0_wp), 1.0_wp)
         g1 = g1 - share*f1
         g2 = g2 - share*f2
         g3 = g3 - share*f3
         rest = sqrt(g1*g1 + g2*g2)*arm + abs(g3)*bears - (1.0_wp - share)*bears*arm
         ! One condition at a time, for the wide registers.
         sticks(i) = 0.5_wp - sign(0.5_wp, max(slip(i), rest))
      end do
   end subroutine find_stuck

   !> Steps of the directions u of the slips of shells: Newton's method with the second derivatives
   !> of the force, as `slip_on_ellipse` takes them.
   pure subroutine step_on_ellipses(ellipse, load, size, stiffness, trial, short, u, &
      length, off, new, force)
      type(ellipse_type), intent(inout) :: ellipse
      !> Within the outer and the inner edges.
      real(wp), intent(in) :: load(lanes, 2), size(lanes, 2)
      !> Stiffness, and the force of the trial.
      real(wp), intent(in) :: stiffness(lanes, 3), trial(lanes, 3)
      !> A short slip.
      real(wp), intent(in) :: short(lanes)
      !> Directions, of the size one.
      real(wp), intent(in) :: u(lanes, 3)
      !> Length of the slip, > 0 if a shell slips.
      real(wp), intent(inout) :: length(lanes)
      !> Not above zero where the step is the last one.
      real(wp), intent(inout) :: off(lanes)
      !> The direction after it, and the force there.
      real(wp), intent(inout) :: new(lanes, 3), force(lanes, 3)
      real(wp) :: bears(edges, n_values), twice(edges, 3), f1, f2, f3, h11, h12, h22, &
         h13, h23, h33, b1, b2, b3, b4, k1, k2, k3, g1, g2, g3, u1, u2, u3, part, spring, slip, &
         r1, r2, r3, a11, a21, a31, a22, a32, a33, q11, q21, q31, q22, q32, q33, per, w1, w2, w3, &
         beta, p1, p2, p3, m1, m2, m3, x, y, share, inverse, c1, c2, c3, bent, first_size, &
         more_size, good, slips, fine, z, per_along, square, tolerance, along, borne, stiff, radius
      integer :: i, l

      do l = 1, 3
         do i = 1, lanes
            twice(i, l) = u(i, l)
            twice(lanes + i, l) = u(i, l)
         end do
      end do
      call slide_on_ellipse(ellipse, load, size, twice, bears)
      do i = 1, lanes
         k1 = stiffness(i, 1)
         k2 = stiffness(i, 2)
         k3 = stiffness(i, 3)
         g1 = trial(i, 1)
         g2 = trial(i, 2)
         g3 = trial(i, 3)
         u1 = u(i, 1)
         u2 = u(i, 2)
         u3 = u(i, 3)
         f1 = bears(i, 1) - bears(lanes + i, 1)
         f2 = bears(i, 2) - bears(lanes + i, 2)
         f3 = bears(i, 3) - bears(lanes + i, 3)
         h11 = bears(i, 4) - bears(lanes + i, 4)
         h12 = bears(i, 5) - bears(lanes + i, 5)
         h22 = bears(i, 6) - bears(lanes + i, 6)
         h13 = bears(i, 7) - bears(lanes + i, 7)
         h23 = bears(i, 8) - bears(lanes + i, 8)
         h33 = bears(i, 9) - bears(lanes + i, 9)
         b1 = bears(i, 10) - bears(lanes + i, 10)
         b2 = bears(i, 11) - bears(lanes + i, 11)
         b3 = bears(i, 12) - bears(lanes + i, 12)
         b4 = bears(i, 13) - bears(lanes + i, 13)
         along = g1*u1 + g2*u2 + g3*u3
         stiff = k1*u1*u1 + k2*u2*u2 + k3*u3*u3
         borne = max(f1*u1 + f2*u2 + f3*u3, least_pivot)
         ! Quotients of what is known before the forces are.
         slip = (along - borne)*(1.0_wp/stiff)
         per_along = 1.0_wp/max(along, least_pivot)
         part = min(borne*per_along, most_part)
         length(i) = slip
         ! Where nothing slips what is sought is the direction whose force is along the trial.
         slips = 0.5_wp - sign(0.5_wp, borne - along)
         part = slips + (1.0_wp - slips)*part
         slip = slips*slip
         spring = slip + (1.0_wp - slips)*part*short(i)
         r1 = part*g1 - f1 - slip*k1*u1
         r2 = part*g2 - f2 - slip*k2*u2
         r3 = part*g3 - f3 - slip*k3*u3
         ! (H + s K) p = r, with H u = 0 and u.r = 0, so that u.K p = 0: p is as well the solution
         ! with beta (K u) (K u)^T added to the matrix, which is regular then for any s.
         w1 = k1*u1
         w2 = k2*u2
         w3 = k3*u3
         beta = (h11 + h22 + h33)/max(w1*w1 + w2*w2 + w3*w3, least_pivot)
         a11 = h11 + spring*k1 + beta*w1*w1
         a22 = h22 + spring*k2 + beta*w2*w2
         a33 = h33 + spring*k3 + beta*w3*w3
         a21 = h12 + beta*w1*w2
         a31 = h13 + beta*w1*w3
         a32 = h23 + beta*w2*w3
         q11 = a22*a33 - a32*a32
         q21 = a31*a32 - a21*a33
         q31 = a21*a32 - a31*a22
         q22 = a11*a33 - a31*a31
         q32 = a21*a31 - a11*a32
         q33 = a11*a22 - a21*a21
         per = 1.0_wp/max(a11*q11 + a21*q21 + a31*q31, least_power)
         p1 = (q11*r1 + q21*r2 + q31*r3)*per
         p2 = (q21*r1 + q22*r2 + q32*r3)*per
         p3 = (q31*r1 + q32*r2 + q33*r3)*per
         first_size = max(abs(p1), abs(p2), abs(p3))
         ! What the second derivatives add; a step along u changes nothing. By the same matrix, but
         ! for its part along u.
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
         ! Where nothing slips the size of the force is free, not the length of the slip.
         along = c1*u1 + c2*u2 + c3*u3
         share = (1.0_wp - slips)*along*per_along
         part = slips*along*beta/max(spring*(spring + beta*stiff), least_power)
         x = c1 - share*g1
         y = c2 - share*g2
         z = c3 - share*g3
         m1 = (q11*x + q21*y + q31*z)*per + part*u1
         m2 = (q21*x + q22*y + q32*z)*per + part*u2
         m3 = (q31*x + q32*y + q33*z)*per + part*u3
         more_size = 0.5_wp*max(abs(m1), abs(m2), abs(m3))
         good = 0.5_wp + sign(0.5_wp, min(abs(u3) - least_spin, 0.5_wp*first_size - more_size))
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
         fine = good*(0.5_wp + sign(0.5_wp, smallest_force*first_size - borne*more_size*more_size))
         tolerance = close_enough + fine*(close_by_bends - close_enough)
         tolerance = (tolerance + (1.0_wp - slips)*(close_to_limit - tolerance))*radius
         bent = c1*c1 + c2*c2 + c3*c3
         off(i) = max(square - tolerance*tolerance, &
            slips*(bent*bent - smallest_force*smallest_force*(m1*m1 + m2*m2 + m3*m3)))
         radius = max(radius, (1.0_wp/longest_step)*max(abs(p1), abs(p2), abs(p3)))
         inverse = 1.0_wp/sqrt(square + radius*radius)
         new(i, 1) = (radius*u1 + p1)*inverse
         new(i, 2) = (radius*u2 + p2)*inverse
         new(i, 3) = (radius*u3 + p3)*inverse
      end do
   end subroutine step_on_ellipses

   !> Forces of sliding of what is within edges of an ellipse, and their derivatives: to some 1e-15
   !> and 1e-14.
   pure subroutine slide_on_ellipse(ellipse, load, size, u, bears)
      type(ellipse_type), intent(inout) :: ellipse
      real(wp), intent(in) :: load(edges), size(edges)
      !> Sliding velocity along the axes and spin times the semi-axis, of the size one.
      real(wp), intent(in) :: u(edges, 3)
      real(wp), intent(inout) :: bears(edges, n_values)
      real(wp), dimension(edges) :: rho, h, q, x, place
      real(wp) :: found(4, edges)
      real(wp) :: k2, c, root_k, w, w2, ux, uy, ux2, uy2, excess, s, root, far, l, total, a, b, &
         ab, inverse, per_a, per_b, end, ends, end_a, end_b, jaa, jab, jbb, raa, rab, rbb, ea, eb, &
         ra, rb, force_a, force_b, rest_a, rest_b, weight, arm
      integer :: i

      k2 = ellipse%k2
      c = ellipse%c
      root_k = ellipse%root_k
      do i = 1, edges
         w = max(size(i), least_size)*abs(u(i, 3))
         w2 = w*w
         ux2 = u(i, 1)**2
         excess = max(ux2 + k2*((abs(u(i, 2)) - w)*(abs(u(i, 2)) + w)), 0.0_wp)
         s = ux2 + (abs(u(i, 2)) - w)*(abs(u(i, 2)) + w) - k2*w2
         root = sqrt(s*s + 4.0_wp*w2*excess)
         total = root + abs(s)
         far = 0.5_wp + sign(0.5_wp, s)
         l = far*0.5_wp*total + (1.0_wp - far)*2.0_wp*w2*excess/max(total, least_power)
         rho(i) = sqrt(l)
         total = max(root_k*w + rho(i), least_size)
         ab = max((w2 + l)*(k2*w2 + l), least_power)
         inverse = 1.0_wp/(total*ab)
         h(i) = ab*inverse
         q(i) = total*inverse
         x(i) = rho(i)*h(i)
      end do
      call look_up(ellipse, x, place, found)
      do i = 1, edges
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
         rbb = (found(1, i) + place(i)*found(3, i))*h(i)*per_b*per_b
         rab = (found(2, i) + place(i)*found(4, i))*h(i)*q(i)
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
         end = 4.0_wp*weight*end/max(per_a*per_a + per_b*per_b, least_power)
         bears(i, 10) = end*per_b*per_b*per_b - 3.0_wp*ux*jbb
         bears(i, 11) = end*per_b*per_b*per_a - uy*jab
         bears(i, 12) = end*per_b*per_a*per_a - ux*jab
         bears(i, 13) = end*per_a*per_a*per_a - 3.0_wp*uy*jaa
      end do
   end subroutine slide_on_ellipse

   !> The two functions of the table: their even and their odd powers.
   pure subroutine look_up(ellipse, x, place, found)
      type(ellipse_type), intent(inout) :: ellipse
      !> From 0 to 1.
      real(wp), intent(in) :: x(edges)
      !> Place in the part of the table.
      real(wp), intent(inout) :: place(edges)
      real(wp), intent(inout) :: found(4, edges)
      real(wp) :: square, both(4)
      integer :: part(edges), i, j

      do i = 1, edges
         part(i) = max(min(int(x(i)*parts), parts - 1), 0)
         place(i) = 2.0_wp*(x(i)*parts - real(part(i), wp)) - 1.0_wp
      end do
      do i = 1, edges
         if (.not. ellipse%made(part(i))) call make_part(ellipse, part(i))
         square = place(i)*place(i)
         both = ellipse%table(:, last_pair, part(i))
         do j = last_pair - 1, 0, -1
            both = both*square + ellipse%table(:, j, part(i))
         end do
         found(:, i) = both
      end do
   end subroutine look_up

   !> Make a part of the table for the axis ratio.
   pure subroutine make_part(ellipse, part)
      type(ellipse_type), intent(inout) :: ellipse
      integer, intent(in) :: part
      real(wp) :: even(width), odd(width), square
      integer :: i, j, at

      square = ellipse%place**2
      at = first(part, ellipse%band)
      do i = 0, ubound(lengths, 1)
         even = 0.0_wp
         odd = 0.0_wp
         do j = at, at + lengths(i, part, ellipse%band) - 2, 2
            odd = odd*square + values(:, j)
            even = even*square + values(:, j + 1)
         end do
         at = at + lengths(i, part, ellipse%band)
         ! Even and odd powers of x follow one another there as well.
         call put_group(even, odd, ellipse%place, ellipse%table(1, 2*i, part))
      end do
      ellipse%made(part) = .true.
   end subroutine make_part

   !> Put a group of powers where it belongs.
   pure subroutine put_group(even, odd, place, table)
      !> Even and odd powers of the place in the interval of ln k.
      real(wp), intent(in) :: even(width), odd(width), place
      real(wp), intent(inout) :: table(width)

      table = even + place*odd
   end subroutine put_group

end module contensou_contact_tangential_ellipse_pass
