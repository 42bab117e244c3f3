!> Rolling contact of two elastic half-spaces with friction, by boundary elements (J. Kalker,
!> Three-Dimensional Elastic Bodies in Rolling Contact, 1990, chapter 4; the discretisation is that
!> of E. Vollebregt's CONTACT): constant tractions on rectangles, their displacements after Cerruti
!> in closed form, slip over the distance rolled in one step, and in every element either no slip or
!> a traction at its bound f p against the slip.
!>
!> Units: lengths in sqrt(a b), tractions in f p0, displacements in sqrt(a b) f p0/G, creepages in
!> e0 = f p0/G, forces in f N, torques in f N sqrt(a b). Rolling is along +x; the spot may lie
!> obliquely. Its chords along x have their middles on a line y -> shear y; the rows of elements are
!> shifted along, so that in the indices every spot is the same disc, and the influence of an
!> element on another depends on their differences alone.
!>
!> The slip is s = w + B p for the tractions p of all elements, w being that of rigid bodies. The
!> conditions are those of
!>    p = P(p - rho s),  P(q) = q within the bound g, else g q/|q|,
!> for any rho > 0, and Newton's method for this equation, its linear systems by GMRES, finds the
!> parts that stick in some six steps from anywhere for rho = 0.3/B(0): a larger rho runs into
!> cycles.
module contensou_contact_creep_half_space
   use contensou_base_kinds, only : pi, wp
   use contensou_contact_creep_slip_path, only : follow_path
   implicit none(type, external)
   private

   public :: lattice_type, influence_type, spot_lattice, contact_influence, rolling_influence
   public :: solve_tractions, displace, resultant, refine

   !> Elements of a spot.
   type :: lattice_type
      !> Elements across the spot, along x and along y.
      integer :: n
      !> Sides of an element.
      real(wp) :: dx, dy
      !> Shift of the middle of a chord along x per y.
      real(wp) :: shear
      !> First and last element of the rows; none if the first is behind the last.
      integer, allocatable :: first(:), last(:)
      !> Centres of the elements.
      real(wp), allocatable :: x(:, :), y(:, :)
      !> Bound of the traction, zero outside of the spot; its resultant is one.
      real(wp), allocatable :: bound(:, :)
   end type lattice_type

   !> Influence of the traction of an element on the displacement or the slip of another, by the
   !> differences of their indices, target less source.
   type :: influence_type
      real(wp), allocatable :: xx(:, :), xy(:, :), yy(:, :)
   end type influence_type

   !> Where a step of Newton's method for p = P(p - rho s) begins.
   type :: newton_type
      real(wp) :: rho
      !> Part of an element's slip that its traction does not follow; zero: it sticks.
      real(wp), allocatable :: beta(:, :)
      !> Direction of the traction of an element that slips.
      real(wp), allocatable :: ex(:, :), ey(:, :)
   end type newton_type

   !> Shares of the slip from which solutions are followed, tried in turn, and the first parts of
   !> the way on a logarithmic scale.
   real(wp), parameter :: first_shares(8) = [1.0_wp/64.0_wp, 64.0_wp, 1.0_wp/64.0_wp, 64.0_wp, &
      1.0_wp/64.0_wp, 64.0_wp, 8.0_wp, 1.0_wp/8.0_wp]
   real(wp), parameter :: first_parts(8) = [1.0_wp, 1.0_wp, 0.25_wp, 0.25_wp, 0.06_wp, 0.06_wp, &
      0.6_wp, 0.6_wp]/6.0_wp

   !> Part below which a solution is not followed farther.
   real(wp), parameter :: least_part = 2.0e-5_wp

   !> Most elements whose path from full sliding is followed: 24 across.
   integer, parameter :: most_on_path = 460

   !> Mean slip, and least share of it, from where this path is followed.
   real(wp), parameter :: sliding_slip = 1.0e3_wp, least_path = 8.0_wp

   !> Parts 1/B(0) that rho may be, tried in turn.
   real(wp), parameter :: rho_parts(3) = [0.3_wp, 0.1_wp, 0.03_wp]

   !> Most steps of Newton's method, and of GMRES in each.
   integer, parameter :: most_steps = 40, most_vectors = 400

   !> Relative residual of a linear system.
   real(wp), parameter :: linear_tolerance = 1.0e-3_wp

   !> Resultant of the pressure of Hertz over p0 a b.
   real(wp), parameter :: hertz_load = 2.0_wp*pi/3.0_wp

contains

   !> The elements of a spot.
   pure function spot_lattice(n, half_length, shear) result(lattice)
      !> Elements across, >= 2.
      integer, intent(in) :: n
      !> Half the chord through the centre, along x; half the width across is its inverse.
      real(wp), intent(in) :: half_length
      !> Shift of the middle of a chord along x per y.
      real(wp), intent(in) :: shear
      type(lattice_type) :: lattice
      real(wp) :: half_width, u, v
      integer :: i, j

      half_width = 1.0_wp/half_length
      lattice%n = n
      lattice%dx = 2.0_wp*half_length/real(n, wp)
      lattice%dy = 2.0_wp*half_width/real(n, wp)
      lattice%shear = shear
      allocate(lattice%first(n), source=n + 1)
      allocate(lattice%last(n), source=0)
      allocate(lattice%x(n, n), lattice%y(n, n), lattice%bound(n, n), source=0.0_wp)
      do j = 1, n
         v = real(2*j - 1 - n, wp)/real(n, wp)
         do i = 1, n
            u = real(2*i - 1 - n, wp)/real(n, wp)
            lattice%y(i, j) = half_width*v
            lattice%x(i, j) = half_length*u + shear*half_width*v
            if (u*u + v*v < 1.0_wp) then
               lattice%first(j) = min(lattice%first(j), i)
               lattice%last(j) = i
               lattice%bound(i, j) = sqrt(1.0_wp - u*u - v*v)
            end if
         end do
      end do
      lattice%bound = lattice%bound*(hertz_load/(sum(lattice%bound)*lattice%dx*lattice%dy))
   end function spot_lattice

   !> Influence on the displacement, of tractions that have moved along by some elements since.
   pure function contact_influence(lattice, poisson, moved) result(influence)
      type(lattice_type), intent(in) :: lattice
      !> Poisson's ratio of both bodies together.
      real(wp), intent(in) :: poisson
      !> Distance that the material has passed the spot along -x since, in elements.
      real(wp), intent(in) :: moved
      type(influence_type) :: influence
      real(wp) :: along, across, xx, yy, xy
      integer :: i, j, m

      m = lattice%n - 1
      allocate(influence%xx(-m:m, -m:m), influence%xy(-m:m, -m:m), influence%yy(-m:m, -m:m))
      do j = -m, m
         across = lattice%dy*real(j, wp)
         do i = -m, m
            along = lattice%dx*(real(i, wp) + moved) + lattice%shear*across
            call integrate(along, across, 0.5_wp*lattice%dx, 0.5_wp*lattice%dy, xx, yy, xy)
            influence%xx(i, j) = (xx + (1.0_wp - poisson)*yy)/pi
            influence%yy(i, j) = (yy + (1.0_wp - poisson)*xx)/pi
            influence%xy(i, j) = poisson*xy/pi
         end do
      end do
   end function contact_influence

   !> Influence on the slip of steady rolling, over the length of one element and divided by it.
   pure function rolling_influence(lattice, poisson) result(influence)
      type(lattice_type), intent(in) :: lattice
      !> Poisson's ratio of both bodies together.
      real(wp), intent(in) :: poisson
      type(influence_type) :: influence
      type(influence_type) :: before

      influence = contact_influence(lattice, poisson, 0.0_wp)
      before = contact_influence(lattice, poisson, 1.0_wp)
      influence%xx = (influence%xx - before%xx)/lattice%dx
      influence%xy = (influence%xy - before%xy)/lattice%dx
      influence%yy = (influence%yy - before%yy)/lattice%dx
   end function rolling_influence

   !> Integrals of x^2/R^3, y^2/R^3 and x y/R^3 over a rectangle about the origin, R from a point.
   pure subroutine integrate(x, y, half_x, half_y, xx, yy, xy)
      real(wp), intent(in) :: x, y
      !> Half the sides.
      real(wp), intent(in) :: half_x, half_y
      real(wp), intent(out) :: xx, yy, xy
      real(wp) :: x1, x2, y1, y2

      x1 = x - half_x
      x2 = x + half_x
      y1 = y - half_y
      y2 = y + half_y
      xx = primitive(y2, x2) - primitive(y2, x1) - primitive(y1, x2) + primitive(y1, x1)
      yy = primitive(x2, y2) - primitive(x2, y1) - primitive(x1, y2) + primitive(x1, y1)
      xy = hypot(x2, y1) - hypot(x2, y2) + hypot(x1, y2) - hypot(x1, y1)
   end subroutine integrate

   !> s ln(t + sqrt(s^2 + t^2)), zero for s = 0.
   pure real(wp) function primitive(s, t)
      real(wp), intent(in) :: s, t

      primitive = 0.0_wp
      if (abs(s) > tiny(s)) primitive = s*(asinh(t/abs(s)) + log(abs(s)))
   end function primitive

   !> Tractions of a step: those that stick without slip, and those at their bound against the slip.
   pure subroutine solve_tractions(lattice, influence, rigid_x, rigid_y, bounded, tolerance, &
      px, py, residual)
      type(lattice_type), intent(in) :: lattice
      !> Influence on the slip.
      type(influence_type), intent(in) :: influence
      !> Slip without tractions.
      real(wp), intent(in) :: rigid_x(:, :), rigid_y(:, :)
      !> Whether the tractions have the bound; without it everything sticks.
      logical, intent(in) :: bounded
      !> Largest error of a traction, of its equation with rho.
      real(wp), intent(in) :: tolerance
      !> Tractions: a guess, zero outside of the spot, then the solution.
      real(wp), intent(inout) :: px(:, :), py(:, :)
      !> Error that is left, above the tolerance if the solution was not found.
      real(wp), intent(out) :: residual
      integer :: i

      call solve_from(lattice, influence, rigid_x, rigid_y, bounded, tolerance, px, py, residual)
      if (.not. bounded) return
      do i = 1, size(first_shares)
         if (residual <= tolerance) return
         call follow_slip(lattice, influence, rigid_x, rigid_y, tolerance, first_shares(i), &
            first_parts(i), px, py, residual)
      end do
      if (residual <= tolerance .or. count(lattice%bound > 0.0_wp) > most_on_path) return
      call follow_from_sliding(lattice, influence, rigid_x, rigid_y, tolerance, px, py, residual)
   end subroutine solve_tractions

   !> The same, bounded, along the path of solutions from full sliding: the last resort, as its full
   !> matrices are solved at every turn of an element.
   pure subroutine follow_from_sliding(lattice, influence, rigid_x, rigid_y, tolerance, px, py, &
      residual)
      type(lattice_type), intent(in) :: lattice
      type(influence_type), intent(in) :: influence
      !> Slip without tractions.
      real(wp), intent(in) :: rigid_x(:, :), rigid_y(:, :)
      real(wp), intent(in) :: tolerance
      !> Tractions.
      real(wp), intent(out) :: px(:, :), py(:, :)
      !> Error that is left, above the tolerance if the solution was not found.
      real(wp), intent(out) :: residual
      real(wp), dimension(lattice%n, lattice%n) :: slip
      real(wp), allocatable :: matrix(:, :), p(:), bound(:)
      integer, allocatable :: place(:, :)
      real(wp) :: share
      integer :: i, j, n
      logical :: found, within(lattice%n, lattice%n)

      within = lattice%bound > 0.0_wp
      bound = pack(lattice%bound, within)
      n = size(bound)
      ! Full sliding, at a slip where it is.
      slip = max(hypot(rigid_x, rigid_y), tiny(share))
      share = max(least_path, sliding_slip*sqrt(real(n, wp)/sum(slip**2, mask=within)))
      px = -lattice%bound*rigid_x/slip
      py = -lattice%bound*rigid_y/slip
      call solve_from(lattice, influence, share*rigid_x, share*rigid_y, .true., tolerance, px, py, &
         residual)
      if (residual > tolerance) return

      allocate(place(2, n), matrix(2*n, 2*n))
      place(1, :) = pack(spread([(i, i=1, lattice%n)], 2, lattice%n), within)
      place(2, :) = pack(spread([(j, j=1, lattice%n)], 1, lattice%n), within)
      do j = 1, n
         do i = 1, n
            associate (dx => place(1, i) - place(1, j), dy => place(2, i) - place(2, j))
               matrix(i, j) = influence%xx(dx, dy)
               matrix(i, n + j) = influence%xy(dx, dy)
               matrix(n + i, j) = influence%xy(dx, dy)
               matrix(n + i, n + j) = influence%yy(dx, dy)
            end associate
         end do
      end do
      p = [pack(px, within), pack(py, within)]
      call follow_path(matrix, [pack(rigid_x, within), pack(rigid_y, within)], bound, &
         rho_parts(1)/influence%xx(0, 0), 0.1_wp*tolerance, share, p, found)
      px = unpack(p(:n), within, 0.0_wp)
      py = unpack(p(n + 1:), within, 0.0_wp)
      if (found) then
         call solve_from(lattice, influence, rigid_x, rigid_y, .true., tolerance, px, py, residual)
      else
         residual = huge(residual)
      end if
   end subroutine follow_from_sliding

   !> The same, bounded, by way of slips that are smaller or larger by a factor that tends to one:
   !> on needles that roll nearly along their axis there are several solutions, and hardly any guess
   !> is near one.
   pure subroutine follow_slip(lattice, influence, rigid_x, rigid_y, tolerance, first_share, &
      first_part, px, py, residual)
      type(lattice_type), intent(in) :: lattice
      type(influence_type), intent(in) :: influence
      !> Slip without tractions.
      real(wp), intent(in) :: rigid_x(:, :), rigid_y(:, :)
      real(wp), intent(in) :: tolerance
      !> The first of these factors, and the first part of the way from there.
      real(wp), intent(in) :: first_share, first_part
      !> Tractions.
      real(wp), intent(out) :: px(:, :), py(:, :)
      !> Error that is left, above the tolerance if the solution was not found.
      real(wp), intent(out) :: residual
      real(wp), dimension(lattice%n, lattice%n) :: known_x, known_y
      real(wp) :: known, now, part, share

      known_x = 0.0_wp
      known_y = 0.0_wp
      known = 1.0_wp
      now = 1.0_wp
      part = first_part
      do
         share = first_share**now
         px = known_x
         py = known_y
         call solve_from(lattice, influence, share*rigid_x, share*rigid_y, .true., tolerance, px, &
            py, residual)
         if (residual <= tolerance) then
            if (now <= 0.0_wp) return
            known = now
            known_x = px
            known_y = py
            part = 1.5_wp*part
         else
            part = 0.5_wp*part
            ! Here solutions end.
            if (part < least_part) return
         end if
         now = max(known - part, 0.0_wp)
      end do
   end subroutine follow_slip

   !> The same from the guess, with the parts that rho may be in turn.
   pure subroutine solve_from(lattice, influence, rigid_x, rigid_y, bounded, tolerance, px, py, &
      residual)
      type(lattice_type), intent(in) :: lattice
      type(influence_type), intent(in) :: influence
      real(wp), intent(in) :: rigid_x(:, :), rigid_y(:, :)
      logical, intent(in) :: bounded
      real(wp), intent(in) :: tolerance
      real(wp), intent(inout) :: px(:, :), py(:, :)
      real(wp), intent(out) :: residual
      integer :: i

      residual = huge(residual)
      do i = 1, size(rho_parts)
         call iterate(lattice, influence, rho_parts(i)/influence%xx(0, 0), rigid_x, rigid_y, &
            bounded, tolerance, px, py, residual)
         if (residual <= tolerance) return
      end do
   end subroutine solve_from

   !> Newton's method for p = P(p - rho s).
   pure subroutine iterate(lattice, influence, rho, rigid_x, rigid_y, bounded, tolerance, px, py, &
      residual)
      type(lattice_type), intent(in) :: lattice
      type(influence_type), intent(in) :: influence
      real(wp), intent(in) :: rho
      real(wp), intent(in) :: rigid_x(:, :), rigid_y(:, :)
      logical, intent(in) :: bounded
      real(wp), intent(in) :: tolerance
      real(wp), intent(inout) :: px(:, :), py(:, :)
      real(wp), intent(out) :: residual
      type(newton_type) :: newton
      real(wp), dimension(lattice%n, lattice%n) :: sx, sy, fx, fy
      real(wp) :: qx, qy, q
      integer :: i, j, step

      fx = 0.0_wp
      fy = 0.0_wp
      newton%rho = rho
      allocate(newton%beta(lattice%n, lattice%n))
      allocate(newton%ex, newton%ey, source=fx)
      do step = 0, most_steps
         call displace(lattice, influence, px, py, sx, sy)
         residual = 0.0_wp
         newton%beta = 0.0_wp
         do j = 1, lattice%n
            do i = lattice%first(j), lattice%last(j)
               sx(i, j) = sx(i, j) + rigid_x(i, j)
               sy(i, j) = sy(i, j) + rigid_y(i, j)
               qx = px(i, j) - rho*sx(i, j)
               qy = py(i, j) - rho*sy(i, j)
               q = hypot(qx, qy)
               fx(i, j) = rho*sx(i, j)
               fy(i, j) = rho*sy(i, j)
               if (bounded .and. q > lattice%bound(i, j)) then
                  newton%ex(i, j) = qx/q
                  newton%ey(i, j) = qy/q
                  newton%beta(i, j) = lattice%bound(i, j)/q
                  fx(i, j) = px(i, j) - lattice%bound(i, j)*newton%ex(i, j)
                  fy(i, j) = py(i, j) - lattice%bound(i, j)*newton%ey(i, j)
               end if
               residual = max(residual, abs(fx(i, j)), abs(fy(i, j)))
            end do
         end do
         if (residual <= tolerance .or. step == most_steps) exit
         call correct(lattice, influence, newton, fx, fy, px, py)
         if (bounded) call confine(lattice, px, py)
      end do
   end subroutine iterate

   !> Cut tractions beyond their bound.
   pure subroutine confine(lattice, px, py)
      type(lattice_type), intent(in) :: lattice
      real(wp), intent(inout) :: px(:, :), py(:, :)
      real(wp) :: p
      integer :: i, j

      do j = 1, lattice%n
         do i = lattice%first(j), lattice%last(j)
            p = hypot(px(i, j), py(i, j))
            if (p > lattice%bound(i, j)) then
               px(i, j) = px(i, j)*(lattice%bound(i, j)/p)
               py(i, j) = py(i, j)*(lattice%bound(i, j)/p)
            end if
         end do
      end do
   end subroutine confine

   !> Add the solution of the linear system of a step of Newton's method, J d = -f, by GMRES.
   pure subroutine correct(lattice, influence, newton, fx, fy, px, py)
      type(lattice_type), intent(in) :: lattice
      type(influence_type), intent(in) :: influence
      type(newton_type), intent(in) :: newton
      !> Residual; destroyed.
      real(wp), intent(inout) :: fx(:, :), fy(:, :)
      real(wp), intent(inout) :: px(:, :), py(:, :)
      real(wp), allocatable :: basis(:, :, :, :), hessenberg(:, :)
      real(wp) :: cosine(most_vectors), sine(most_vectors), right(most_vectors + 1)
      real(wp) :: y(most_vectors), start, norm, turned
      integer :: k, l

      allocate(basis(lattice%n, lattice%n, 2, most_vectors + 1))
      allocate(hessenberg(most_vectors + 1, most_vectors))
      call precondition(lattice, influence, newton, fx, fy)
      start = sqrt(sum(fx**2) + sum(fy**2))
      if (start <= 0.0_wp) return
      basis(:, :, 1, 1) = -fx/start
      basis(:, :, 2, 1) = -fy/start
      right = 0.0_wp
      right(1) = start
      do k = 1, most_vectors
         call apply_jacobian(lattice, influence, newton, basis(:, :, 1, k), basis(:, :, 2, k), &
            fx, fy)
         call precondition(lattice, influence, newton, fx, fy)
         do l = 1, k
            hessenberg(l, k) = sum(fx*basis(:, :, 1, l)) + sum(fy*basis(:, :, 2, l))
            fx = fx - hessenberg(l, k)*basis(:, :, 1, l)
            fy = fy - hessenberg(l, k)*basis(:, :, 2, l)
         end do
         norm = sqrt(sum(fx**2) + sum(fy**2))
         if (norm > 0.0_wp) then
            basis(:, :, 1, k + 1) = fx/norm
            basis(:, :, 2, k + 1) = fy/norm
         end if
         do l = 1, k - 1
            turned = cosine(l)*hessenberg(l, k) + sine(l)*hessenberg(l + 1, k)
            hessenberg(l + 1, k) = cosine(l)*hessenberg(l + 1, k) - sine(l)*hessenberg(l, k)
            hessenberg(l, k) = turned
         end do
         turned = hypot(hessenberg(k, k), norm)
         cosine(k) = hessenberg(k, k)/turned
         sine(k) = norm/turned
         hessenberg(k, k) = turned
         right(k + 1) = -sine(k)*right(k)
         right(k) = cosine(k)*right(k)
         if (abs(right(k + 1)) <= linear_tolerance*start .or. k == most_vectors) exit
      end do
      do l = k, 1, -1
         y(l) = (right(l) - dot_product(hessenberg(l, l + 1:k), y(l + 1:k)))/hessenberg(l, l)
      end do
      do l = 1, k
         px = px + y(l)*basis(:, :, 1, l)
         py = py + y(l)*basis(:, :, 2, l)
      end do
   end subroutine correct

   !> Derivative of the residual along a direction.
   pure subroutine apply_jacobian(lattice, influence, newton, dx, dy, rx, ry)
      type(lattice_type), intent(in) :: lattice
      type(influence_type), intent(in) :: influence
      type(newton_type), intent(in) :: newton
      !> Direction.
      real(wp), intent(in) :: dx(:, :), dy(:, :)
      real(wp), intent(out) :: rx(:, :), ry(:, :)
      real(wp) :: turn
      integer :: i, j

      call displace(lattice, influence, dx, dy, rx, ry)
      associate (rho => newton%rho, beta => newton%beta, ex => newton%ex, ey => newton%ey)
         do j = 1, lattice%n
            do i = lattice%first(j), lattice%last(j)
               if (beta(i, j) > 0.0_wp) then
                  turn = beta(i, j)*(ex(i, j)*(dy(i, j) - rho*ry(i, j)) &
                     - ey(i, j)*(dx(i, j) - rho*rx(i, j)))
                  rx(i, j) = dx(i, j) + turn*ey(i, j)
                  ry(i, j) = dy(i, j) - turn*ex(i, j)
               else
                  rx(i, j) = rho*rx(i, j)
                  ry(i, j) = rho*ry(i, j)
               end if
            end do
         end do
      end associate
   end subroutine apply_jacobian

   !> Multiply by the inverse of what the Jacobian has on the diagonal, two by two.
   pure subroutine precondition(lattice, influence, newton, rx, ry)
      type(lattice_type), intent(in) :: lattice
      type(influence_type), intent(in) :: influence
      type(newton_type), intent(in) :: newton
      real(wp), intent(inout) :: rx(:, :), ry(:, :)
      real(wp) :: own_x, own_y, xx, xy, yx, yy, x
      integer :: i, j

      own_x = newton%rho*influence%xx(0, 0)
      own_y = newton%rho*influence%yy(0, 0)
      associate (beta => newton%beta, ex => newton%ex, ey => newton%ey)
         do j = 1, lattice%n
            do i = lattice%first(j), lattice%last(j)
               if (beta(i, j) > 0.0_wp) then
                  xx = 1.0_wp - beta(i, j)*ey(i, j)**2*(1.0_wp - own_x)
                  xy = beta(i, j)*ex(i, j)*ey(i, j)*(1.0_wp - own_y)
                  yx = beta(i, j)*ex(i, j)*ey(i, j)*(1.0_wp - own_x)
                  yy = 1.0_wp - beta(i, j)*ex(i, j)**2*(1.0_wp - own_y)
                  x = (yy*rx(i, j) - xy*ry(i, j))/(xx*yy - xy*yx)
                  ry(i, j) = (xx*ry(i, j) - yx*rx(i, j))/(xx*yy - xy*yx)
                  rx(i, j) = x
               else
                  rx(i, j) = rx(i, j)/own_x
                  ry(i, j) = ry(i, j)/own_y
               end if
            end do
         end do
      end associate
   end subroutine precondition

   !> Displacement or slip by tractions.
   pure subroutine displace(lattice, influence, px, py, ux, uy)
      type(lattice_type), intent(in) :: lattice
      type(influence_type), intent(in) :: influence
      real(wp), intent(in) :: px(:, :), py(:, :)
      real(wp), intent(out) :: ux(:, :), uy(:, :)
      real(wp) :: row_x(lattice%n), row_y(lattice%n), x, y
      integer :: i, j, k, l

      do j = 1, lattice%n
         row_x = 0.0_wp
         row_y = 0.0_wp
         do l = 1, lattice%n
            do k = lattice%first(l), lattice%last(l)
               x = px(k, l)
               y = py(k, l)
               do i = lattice%first(j), lattice%last(j)
                  row_x(i) = row_x(i) + influence%xx(i - k, j - l)*x + influence%xy(i - k, j - l)*y
                  row_y(i) = row_y(i) + influence%xy(i - k, j - l)*x + influence%yy(i - k, j - l)*y
               end do
            end do
         end do
         ux(:, j) = row_x
         uy(:, j) = row_y
      end do
   end subroutine displace

   !> Force and torque of tractions.
   pure function resultant(lattice, px, py) result(wrench)
      type(lattice_type), intent(in) :: lattice
      real(wp), intent(in) :: px(:, :), py(:, :)
      real(wp) :: wrench(3)

      wrench = (lattice%dx*lattice%dy/hertz_load)*[sum(px), sum(py), &
         sum(lattice%x*py - lattice%y*px)]
   end function resultant

   !> Tractions of a finer lattice from those of a coarser one.
   pure subroutine refine(coarse, fine, values, refined)
      type(lattice_type), intent(in) :: coarse, fine
      real(wp), intent(in) :: values(:, :)
      real(wp), intent(out) :: refined(:, :)
      integer :: i, j

      refined = 0.0_wp
      do j = 1, fine%n
         do i = fine%first(j), fine%last(j)
            refined(i, j) = values(1 + ((2*i - 1)*coarse%n)/(2*fine%n), &
               1 + ((2*j - 1)*coarse%n)/(2*fine%n))
         end do
      end do
   end subroutine refine

end module contensou_contact_creep_half_space
