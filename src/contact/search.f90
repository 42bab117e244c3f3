!> Contact search on implicit surfaces: the points of two surfaces where they are closest, with a
!> common normal; overlapping surfaces too.
!>
!> Warm: Newton's method on the equations of the common normal, n_A + n_B = 0 and y - x parallel
!> to n_A, for the points x of A and y of B, from those of the last search, in the tangent planes
!> and then brought back onto the surfaces. Cold: one surface, the carrier, is sampled all over for
!> the smallest distance from the other one, whose distance function is known, the best samples
!> are refined by descent, and Newton's method finishes. A torus is swept by a sphere along a circle
!> and a cylinder along a line, so that these have to be sampled in one parameter only; an ellipsoid
!> is sampled all over.
!>
!> Two convex surfaces have one place of this kind. Others may have several: then the one with the
!> smallest distance is taken while the surfaces are apart. Where more than one may touch, all are
!> looked for once the surfaces are close, and each is followed by a track of its own.
!> The tracking of surfaces by their common normal follows I. Kosenko and E. Aleksandrov,
!> 7th Modelica Conference (2009) 288; the form of the equations here is reconstructed.
module contensou_contact_search
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite
   use contensou_base_kinds, only : pi, wp
   use contensou_base_vectors, only : any_tangent, cross
   use contensou_contact_geometry, only : place_closest, place_none, same_place, track_type
   use contensou_contact_relative, only : joint_form
   use contensou_contact_shapes_shape, only : angles, samples_line, shape_info_type
   use contensou_contact_surface, only : closest_point, form_at, normal_at, surface_type
   implicit none(type, external)
   private

   public :: search_type, set_search, carrier_rank, placing_type

   !> Two surfaces to be searched.
   type :: search_type
      !> Surfaces A and B; an array, as gfortran 12 frees only one of several such components when
      !> an extension of their type is freed.
      type(surface_type) :: surfaces(2)
      !> Indices of the carrier of the samples and of the other surface.
      integer :: carrier = 1, other = 2
      !> Whether there may be several places of a common normal.
      logical :: several = .false.
      !> Length of the order of the surfaces [m].
      real(wp) :: size = 0.0_wp
      !> Overlap beyond which a place is doubted: a common normal may lead through a rod to its far
      !> side [m].
      real(wp) :: narrow = 0.0_wp
      !> Whether the carrier is swept along a line, so that its samples have one parameter.
      logical :: line = .false.
      !> Semi-axes of a carrier whose samples have two parameters [m].
      real(wp) :: axes(3) = 0.0_wp
      !> Length of the order of the carrier [m], the largest number if it has no end.
      real(wp) :: far = 0.0_wp
   contains
      procedure :: find
      procedure :: find_places
   end type search_type

   !> Frame of surface B seen from surface A.
   type :: placing_type
      !> Rotation matrix, frame of B to frame of A.
      real(wp) :: rotation(3, 3)
      !> Origin of the frame of B in that of A [m].
      real(wp) :: origin(3)
   end type placing_type

   !> A place of a carrier: a sphere that sweeps it, or a point, which is one without a radius.
   type :: swept_type
      !> Its centre in the frame of the carrier [m].
      real(wp) :: centre(3)
      !> Its radius [m].
      real(wp) :: radius
   end type swept_type

   !> Most steps of Newton's method.
   integer, parameter :: most_steps = 20

   !> Most steps of a descent.
   integer, parameter :: most_descents = 60

   !> Samples of a carrier with two parameters.
   integer, parameter :: samples_area = 96

   !> Best samples that are refined.
   integer, parameter :: most_starts = 6

   !> Cosine of the angle up to which samples of two parameters belong to one place.
   real(wp), parameter :: nearby_area = 0.8_wp

   !> Rounding of a distance of samples in units of the size of the surfaces.
   real(wp), parameter :: tolerance = 1.0e-9_wp

   !> How much lower than the nearest sample a place may be, in units of the largest semi-axis: the
   !> nearest sample is at most 0.23 away on the unit sphere.
   real(wp), parameter :: depth_area = 0.05_wp

   !> How far from one look to the next a place may be found, over the size of the surfaces.
   real(wp), parameter :: longest_leash = 0.25_wp

   !> Intervals between two samples of a line where all places are looked for.
   integer, parameter :: finer = 6

   !> Places that are looked for with all of them.
   integer, parameter :: most_places = 24

   !> Cosine of the angle up to which samples of two parameters are neighbours.
   real(wp), parameter :: neighbours = 0.93_wp

   !> Steps along the valley of the distance about a place, and the length of the first one on the
   !> unit sphere and its growth.
   integer, parameter :: valley_steps = 11
   real(wp), parameter :: valley_step = 0.02_wp, valley_growth = 1.4_wp

   integer :: counter

   !> Sampled directions: heights, and the golden angle.
   real(wp), parameter :: heights(samples_area) = &
      [((2.0_wp*real(counter, wp) - 1.0_wp)/samples_area - 1.0_wp, counter=1, samples_area)]

   !> Angles of the sampled directions.
   real(wp), parameter :: turns(samples_area) = &
      [(real(counter, wp)*pi*(3.0_wp - sqrt(5.0_wp)), counter=1, samples_area)]

   !> Unit vectors, spread evenly over the sphere.
   real(wp), parameter :: directions(samples_area, 3) = reshape([ &
      sqrt(1.0_wp - heights**2)*cos(turns), sqrt(1.0_wp - heights**2)*sin(turns), heights], &
      [samples_area, 3])

contains

   !> Search of a pair of surfaces, one of them at least a carrier.
   subroutine set_search(self)
      !> Its surfaces are set.
      type(search_type), intent(inout) :: self
      type(shape_info_type) :: info_a, info_b, carried

      info_a = self%surfaces(1)%shape%info()
      info_b = self%surfaces(2)%shape%info()
      if (carrier_rank(self%surfaces(1)) < carrier_rank(self%surfaces(2))) self%carrier = 2
      self%other = 3 - self%carrier
      self%several = .not. (info_a%convex .and. info_b%convex) .or. self%surfaces(1)%inside &
         .or. self%surfaces(2)%inside
      self%size = max(self%surfaces(1)%shape%extent(), self%surfaces(2)%shape%extent())
      self%narrow = min(self%surfaces(1)%shape%smallest_radius(), &
         self%surfaces(2)%shape%smallest_radius())
      associate (carrier => self%surfaces(self%carrier)%shape)
         carried = carrier%info()
         self%line = carried%swept
         self%axes = carrier%axes()
         self%far = carrier%extent()
         if (.not. carried%bounded) self%far = 1.0e100_wp
      end associate
   end subroutine set_search

   !> How well a surface serves as a carrier; 0 for not at all.
   pure function carrier_rank(surface) result(rank)
      type(surface_type), intent(in) :: surface
      integer :: rank
      type(shape_info_type) :: info

      info = surface%shape%info()
      rank = merge(0, info%rank, surface%inside)
   end function carrier_rank

   !> Closest points of the surfaces, and their distance.
   pure subroutine find(self, placing, track, gap)
      class(search_type), intent(in) :: self
      type(placing_type), intent(in) :: placing
      !> Where the search begins, and what it finds; `lost` when it fails.
      type(track_type), intent(inout) :: track
      !> Signed distance [m]; when lost, a negative number without meaning.
      real(wp), intent(out) :: gap
      logical :: found

      if (track%place /= place_closest) then
         call follow(self, placing, track, gap)
         return
      end if
      if (track%known) then
         call polish(self, placing, track%first, track%second, track%normal, gap, found)
         if (found) found = .not. leads_through(self, placing, track%first, track%second, gap)
         if (found) then
            track%lost = .false.
            if (self%several .and. gap > 0.0_wp) then
               if (gap > track%elsewhere - moved(self, placing, track)) then
                  call look_elsewhere(self, placing, track, gap)
               end if
            end if
            return
         end if
      end if
      call find_cold(self, placing, track, gap)
   end subroutine find

   !> Distance at the place of a track that has one of its own, or has none.
   pure subroutine follow(self, placing, track, gap)
      type(search_type), intent(in) :: self
      type(placing_type), intent(in) :: placing
      !> Where the search begins, and what it finds; `away` when there is no such place any more,
      !> `lost` when it overlapped.
      type(track_type), intent(inout) :: track
      !> Signed distance [m]; without a place the size of the surfaces, negative when lost.
      real(wp), intent(out) :: gap
      real(wp) :: x(3), y(3), n(3)
      logical :: found

      track%lost = .false.
      track%away = .true.
      gap = self%size
      if (track%place == place_none) return
      x = track%first
      y = track%second
      n = track%normal
      call polish(self, placing, x, y, n, gap, found)
      if (found) found = may_be(x, y, gap)
      if (.not. found) then
         ! A trial of an integrator may have led away.
         x = track%anchor(:, 1)
         y = track%anchor(:, 2)
         call polish(self, placing, x, y, n, gap, found)
         if (found) found = may_be(x, y, gap)
      end if
      if (found) then
         track%first = x
         track%second = y
         track%normal = n
         track%overlaps = gap < 0.0_wp
         track%away = .false.
      else
         track%lost = track%overlaps .or. track%pinned
         gap = merge(-self%size, self%size, track%lost)
      end if

   contains

      !> Whether points may be those of the place: from one to another it has to go by way of both
      !> surfaces.
      pure logical function may_be(first, second, gap)
         !> Point of A, frame of A [m].
         real(wp), intent(in) :: first(3)
         !> Point of B, frame of B [m].
         real(wp), intent(in) :: second(3)
         !> Their distance [m].
         real(wp), intent(in) :: gap

         may_be = min(sum((first - track%anchor(:, 1))**2), &
            sum((second - track%anchor(:, 2))**2)) <= min(track%leash, longest_leash*self%size)**2
         if (may_be) may_be = .not. leads_through(self, placing, first, second, gap)
      end function may_be

   end subroutine follow

   !> Whether a common normal on which the surfaces overlap leads through one of them: its point on
   !> the carrier is outside of the other surface.
   pure logical function leads_through(self, placing, first, second, gap)
      type(search_type), intent(in) :: self
      type(placing_type), intent(in) :: placing
      !> Point of A, frame of A [m].
      real(wp), intent(in) :: first(3)
      !> Point of B, frame of B [m].
      real(wp), intent(in) :: second(3)
      !> Their distance [m].
      real(wp), intent(in) :: gap

      leads_through = gap < -self%narrow
      if (leads_through) leads_through = distance_of(self, placing, swept_type(merge(first, &
         second, self%carrier == 1), 0.0_wp)) > 0.0_wp
   end function leads_through

   !> Newton's method on the equations of the common normal.
   pure subroutine polish(self, placing, first, second, normal, gap, found)
      type(search_type), intent(in) :: self
      type(placing_type), intent(in) :: placing
      !> Point of A, frame of A [m]; unchanged when nothing is found.
      real(wp), intent(inout) :: first(3)
      !> Point of B, frame of B [m]; unchanged when nothing is found.
      real(wp), intent(inout) :: second(3)
      !> Normal of A out of its material, frame of A; unchanged when nothing is found.
      real(wp), intent(inout) :: normal(3)
      !> Signed distance [m].
      real(wp), intent(out) :: gap
      !> Whether it converged to a place where the distance is smallest.
      logical, intent(out) :: found
      real(wp) :: x(3), y(3), n(3), nb(3), mb(3), w(3), t(3, 2), tb(3, 2), la(3), lb(3)
      real(wp) :: r1(2), r2(2), v(2), xi_a(2), xi_b(2), m(2, 2), determinant, trace, length
      real(wp) :: residual, last, step, scale, x_last(3), y_last(3), move_a(3), move_b(3)
      logical :: closing
      integer :: i

      found = .false.
      x = first
      y = second
      last = huge(last)
      closing = .false.
      scale = 1.0_wp
      move_a = 0.0_wp
      move_b = 0.0_wp
      x_last = x
      y_last = y
      do i = 1, most_steps
         n = normal_at(self%surfaces(1), x)
         mb = normal_at(self%surfaces(2), y)
         nb = matmul(placing%rotation, mb)
         w = placing%origin + matmul(placing%rotation, y) - x
         gap = w(1)*n(1) + w(2)*n(2) + w(3)*n(3)
         if (closing) then
            first = x
            second = y
            normal = n
            found = ieee_is_finite(gap)
            return
         end if
         if (dot_product(n, nb) > -0.1_wp) return
         t(:, 1) = any_tangent(n)
         t(:, 2) = cross(n, t(:, 1))
         tb = matmul(transpose(placing%rotation), t)
         call form_at(self%surfaces(1), x, n, t, la)
         call form_at(self%surfaces(2), y, mb, tb, lb)
         r1(1) = dot_product(nb, t(:, 1))
         r1(2) = dot_product(nb, t(:, 2))
         r2(1) = dot_product(w, t(:, 1))
         r2(2) = dot_product(w, t(:, 2))
         length = 1.0_wp/(abs(la(1)) + abs(la(3)) + abs(lb(1)) + abs(lb(3)))
         residual = r1(1)**2 + r1(2)**2 + (r2(1)**2 + r2(2)**2)/self%size**2
         if (residual > last .and. residual > 1.0e-24_wp) then
            ! The step was too long: half of it.
            scale = 0.5_wp*scale
            if (scale < 0.01_wp) return
            x = self%surfaces(1)%shape%restore(x_last + scale*move_a)
            y = self%surfaces(2)%shape%restore(y_last + scale*move_b)
            cycle
         end if
         last = residual
         scale = 1.0_wp
         m = joint_form(la, lb, gap)
         determinant = m(1, 1)*m(2, 2) - m(1, 2)*m(2, 1)
         trace = m(1, 1) + m(2, 2)
         ! Elsewhere the distance is not smallest.
         if (.not. (determinant > 0.0_wp .and. trace > 0.0_wp)) return
         v(1) = lb(1)*r2(1) + lb(2)*r2(2) - r1(1)
         v(2) = lb(2)*r2(1) + lb(3)*r2(2) - r1(2)
         xi_a(1) = (m(2, 2)*v(1) - m(1, 2)*v(2))/determinant
         xi_a(2) = (m(1, 1)*v(2) - m(2, 1)*v(1))/determinant
         xi_b(1) = xi_a(1) + gap*(la(1)*xi_a(1) + la(2)*xi_a(2)) - r2(1)
         xi_b(2) = xi_a(2) + gap*(la(2)*xi_a(1) + la(3)*xi_a(2)) - r2(2)
         step = sqrt(xi_a(1)**2 + xi_a(2)**2 + xi_b(1)**2 + xi_b(2)**2)
         if (.not. step <= 1.0e3_wp*self%size) return
         x_last = x
         y_last = y
         move_a = xi_a(1)*t(:, 1) + xi_a(2)*t(:, 2)
         move_b = xi_b(1)*tb(:, 1) + xi_b(2)*tb(:, 2)
         x = self%surfaces(1)%shape%restore(x + move_a)
         y = self%surfaces(2)%shape%restore(y + move_b)
         ! The error after a step is of the order of its square over the radius of curvature.
         closing = step <= max(1.0e-8_wp*length, 4.0_wp*epsilon(step)*self%size)
      end do
   end subroutine polish

   !> How far any point of the carrier has moved against the other surface at most, since all of it
   !> was looked at [m]: distances have changed by no more.
   pure function moved(self, placing, track) result(length)
      type(search_type), intent(in) :: self
      type(placing_type), intent(in) :: placing
      !> Where it was.
      type(track_type), intent(in) :: track
      real(wp) :: length
      real(wp) :: turned(3, 3), shifted(3)

      if (self%carrier == 1) then
         ! Seen from B, that of A has the origin -origin.rotation.
         turned = transpose(placing%rotation - track%rotation)
         shifted = matmul(placing%origin, placing%rotation) - matmul(track%origin, track%rotation)
      else
         turned = placing%rotation - track%rotation
         shifted = placing%origin - track%origin
      end if
      length = sqrt(sum(shifted**2)) + self%far*sqrt(sum(turned**2))
   end function moved

   !> Leave a place for one that is closer, if there is any, and note how far all others are.
   pure subroutine look_elsewhere(self, placing, track, gap)
      type(search_type), intent(in) :: self
      type(placing_type), intent(in) :: placing
      type(track_type), intent(inout) :: track
      !> Its distance [m].
      real(wp), intent(inout) :: gap
      real(wp) :: value(samples_area), here(3), x(3), y(3), n(3), g, low, bound
      logical :: taken(samples_area), found
      integer :: i, k, count, start

      count = samples_of(self)
      do i = 1, count
         value(i) = distance_of(self, placing, sample_of(self, placing, i))
      end do
      ! Of the samples those are of interest that are near a lower place, and not near this one.
      value(count + 1:) = huge(gap)
      taken = .true.
      track%elsewhere = huge(gap)
      track%rotation = placing%rotation
      track%origin = placing%origin
      here = merge(track%first, track%second, self%carrier == 1)
      if (self%line) then
         do i = 1, count
            if (self%surfaces(self%carrier)%shape%alongside(here, i)) cycle
            track%elsewhere = min(track%elsewhere, value(i))
            low = lowest_between(value(:count), i)
            if (low >= value(i) .and. value(i) >= gap) cycle
            taken(i) = low >= gap
            track%elsewhere = min(track%elsewhere, low)
         end do
      else
         here = here/self%axes
         bound = gap + depth_area*maxval(self%axes)
         do i = 1, count
            if (sum(here*directions(i, :)) > nearby_area) cycle
            taken(i) = value(i) >= bound
            track%elsewhere = min(track%elsewhere, value(i) - (bound - gap))
         end do
      end if
      do start = 1, most_starts
         if (all(taken)) exit
         k = minloc(value, dim=1, mask=.not. taken)
         call refine(self, placing, k, x, y, n, g, low, found)
         call leave_out(self, k, value, taken)
         if (.not. found) cycle
         if (g >= gap - 1.0e-13_wp*self%size) cycle
         gap = g
         track%first = x
         track%second = y
         track%normal = n
         ! Not looked at from here.
         track%elsewhere = -huge(gap)
      end do
      ! Where a closer sample led to no place the surfaces have to be looked at as at first.
      if (minval(value(:count)) < gap - tolerance*self%size) then
         call find_cold(self, placing, track, gap)
      end if
   end subroutine look_elsewhere

   !> All places where the distance is smallest among those near by, and below a limit.
   pure subroutine find_places(self, placing, limit, places, gaps, n)
      class(search_type), intent(in) :: self
      type(placing_type), intent(in) :: placing
      !> The limit [m].
      real(wp), intent(in) :: limit
      !> Closest points and normals; as many as there is room for.
      type(track_type), intent(inout) :: places(:)
      !> Their gaps [m].
      real(wp), intent(out) :: gaps(:)
      !> Number of places.
      integer, intent(out) :: n
      integer :: i

      n = 0
      gaps = huge(gaps)
      if (self%line) then
         call find_on_line(self, placing, limit, places, gaps, n)
      else
         call find_on_area(self, placing, limit, places, gaps, n)
         i = 1
         do while (i <= n)
            call look_along_valley(self, placing, limit, places(i), places, gaps, n)
            i = i + 1
         end do
      end if
   end subroutine find_places

   !> All places below a limit on a carrier with one parameter.
   pure subroutine find_on_line(self, placing, limit, places, gaps, n)
      type(search_type), intent(in) :: self
      type(placing_type), intent(in) :: placing
      !> The limit [m].
      real(wp), intent(in) :: limit
      type(track_type), intent(inout) :: places(:)
      !> Their gaps [m].
      real(wp), intent(inout) :: gaps(:)
      integer, intent(inout) :: n
      integer, parameter :: count = samples_line*finer
      real(wp), parameter :: width = 2.0_wp*pi/count
      real(wp) :: value(samples_line), fine(0:count - 1), around(4), before, after, out(3), foot(3)
      real(wp) :: distance
      type(swept_type) :: p
      integer :: i, j, starts

      do i = 1, samples_line
         value(i) = distance_of(self, placing, sample_of(self, placing, i))
      end do
      fine = huge(fine)
      do i = 1, samples_line
         do j = 1, 4
            around(j) = value(modulo(i + j - 3, samples_line) + 1)
         end do
         fine((i - 1)*finer) = value(i)
         ! Only where the surfaces may be as close as that.
         if (2.0_wp*minval(around) - maxval(around) >= limit) cycle
         do j = 1, finer - 1
            fine((i - 1)*finer + j) = distance_of(self, placing, &
               on_line(self, placing, angles(i) + j*width, 0))
         end do
      end do
      starts = 0
      do i = 0, count - 1
         if (starts >= most_places) exit
         before = fine(modulo(i - 1, count))
         after = fine(modulo(i + 1, count))
         if (fine(i) > before .or. fine(i) > after .or. fine(i) >= huge(limit)) cycle
         ! Between samples that are too far away nothing was looked at.
         if (min(before, after) >= huge(limit)) cycle
         if (2.0_wp*fine(i) - min(before, after) >= limit) cycle
         starts = starts + 1
         p = lowest_about(self, placing, angles(1) + i*width, width)
         call add_place(self, placing, p, limit, places, gaps, n)
         if (.not. p%radius > 0.0_wp) cycle
         ! The sphere may touch on its far side, too, where it is held tightly.
         call closest_point(self%surfaces(self%other), carried(self, placing, p%centre), foot, &
            out, distance)
         if (self%carrier == 1) then
            out = matmul(placing%rotation, out)
         else
            out = matmul(out, placing%rotation)
         end if
         p = swept_type(p%centre + p%radius*out, 0.0_wp)
         if (distance_of(self, placing, p) < limit) call add_place(self, placing, p, limit, &
            places, gaps, n)
      end do
   end subroutine find_on_line

   !> All places below a limit on a carrier with two parameters.
   pure subroutine find_on_area(self, placing, limit, places, gaps, n)
      type(search_type), intent(in) :: self
      type(placing_type), intent(in) :: placing
      !> The limit [m].
      real(wp), intent(in) :: limit
      type(track_type), intent(inout) :: places(:)
      !> Their gaps [m].
      real(wp), intent(inout) :: gaps(:)
      integer, intent(inout) :: n
      real(wp) :: value(samples_area), near
      logical :: start(samples_area)
      integer :: i, j, k

      do i = 1, samples_area
         value(i) = distance_of(self, placing, sample_of(self, placing, i))
      end do
      near = limit + depth_of(self)
      do i = 1, samples_area
         start(i) = value(i) < near
         if (.not. start(i)) cycle
         do j = 1, samples_area
            if (value(j) >= value(i)) cycle
            start(i) = sum(directions(i, :)*directions(j, :)) < neighbours
            if (.not. start(i)) exit
         end do
      end do
      do i = 1, most_places
         k = minloc(value, dim=1, mask=start)
         if (k == 0) exit
         start(k) = .false.
         call add_place(self, placing, lowest_on_area(self, placing, &
            sample_of(self, placing, k)), limit, places, gaps, n)
      end do
   end subroutine find_on_area

   !> How much lower than the nearest sample of two parameters a place may be [m].
   pure real(wp) function depth_of(self)
      type(search_type), intent(in) :: self
      real(wp) :: a

      a = maxval(self%axes)
      depth_of = depth_area*a*(1.0_wp + a/self%surfaces(self%other)%shape%smallest_radius())
   end function depth_of

   !> Follow the valley of the distance from a place of an ellipsoid to both sides, along which it
   !> rises least, for others into which it falls again.
   pure subroutine look_along_valley(self, placing, limit, from, places, gaps, n)
      type(search_type), intent(in) :: self
      type(placing_type), intent(in) :: placing
      !> The limit [m].
      real(wp), intent(in) :: limit
      type(track_type), intent(in) :: from
      type(track_type), intent(inout) :: places(:)
      !> Their gaps [m].
      real(wp), intent(inout) :: gaps(:)
      integer, intent(inout) :: n
      real(wp) :: u(3), v(3), t(3, 2), along(3), value, slope(3), hesse(3), h(3), step, angle
      real(wp) :: image(3), across, width, highest
      integer :: side, i

      if (self%carrier == 1) then
         u = from%first/self%axes
      else
         u = from%second/self%axes
      end if
      u = u/sqrt(sum(u**2))
      t(:, 1) = any_tangent(u)
      t(:, 2) = cross(u, t(:, 1))
      call slopes(self, placing, self%axes*u, t, value, slope, hesse)
      image = self%axes*slope
      h = hesse - dot_product(image, u)*[1.0_wp, 0.0_wp, 1.0_wp]
      ! The direction of the smaller of the two second derivatives.
      angle = 0.5_wp*atan2(-2.0_wp*h(2), h(3) - h(1))
      along = cos(angle)*t(:, 1) + sin(angle)*t(:, 2)
      highest = max(limit, value) + depth_of(self)
      do side = -1, 1, 2
         v = u
         t(:, 1) = side*along
         width = valley_step
         do i = 1, valley_steps
            v = v + width*t(:, 1)
            v = v/sqrt(sum(v**2))
            t(:, 1) = t(:, 1) - dot_product(t(:, 1), v)*v
            t(:, 1) = t(:, 1)/sqrt(sum(t(:, 1)**2))
            t(:, 2) = cross(v, t(:, 1))
            call slopes(self, placing, self%axes*v, t, value, slope, hesse)
            if (value > highest) exit
            image = self%axes*slope
            if (dot_product(image, t(:, 1)) < 0.0_wp) then
               call add_place(self, placing, lowest_on_area(self, placing, &
                  swept_type(self%axes*v, 0.0_wp)), limit, places, gaps, n)
               exit
            end if
            ! Back to the bottom of the valley.
            across = hesse(3) - dot_product(image, v)
            if (across > 0.0_wp) then
               step = -dot_product(image, t(:, 2))/across
               v = v + min(max(step, -width), width)*t(:, 2)
               v = v/sqrt(sum(v**2))
            end if
            width = valley_growth*width
         end do
      end do
   end subroutine look_along_valley

   !> Add the closest points near a place of the carrier to those that are known.
   pure subroutine add_place(self, placing, p, limit, places, gaps, n)
      type(search_type), intent(in) :: self
      type(placing_type), intent(in) :: placing
      type(swept_type), intent(in) :: p
      !> The limit [m].
      real(wp), intent(in) :: limit
      type(track_type), intent(inout) :: places(:)
      !> Their gaps [m].
      real(wp), intent(inout) :: gaps(:)
      integer, intent(inout) :: n
      type(track_type) :: new
      real(wp) :: gap, low
      logical :: found
      integer :: i

      call finish(self, placing, p, new%first, new%second, new%normal, gap, low, found)
      if (.not. found .or. gap >= limit) return
      do i = 1, n
         if (same_place(new, places(i), self%size)) return
      end do
      if (n >= size(places)) return
      n = n + 1
      places(n) = new
      gaps(n) = gap
   end subroutine add_place

   !> Lower bound of a periodic function that is convex next to a sample that is smaller than its
   !> neighbours; the sample itself where it is not: where the straight lines through
   !> the samples before and behind meet.
   pure function lowest_between(value, i) result(low)
      !> Samples.
      real(wp), intent(in) :: value(:)
      !> Number of the sample.
      integer, intent(in) :: i
      real(wp) :: low
      real(wp) :: v(-2:2), down, up, s
      integer :: j

      do j = -2, 2
         v(j) = value(modulo(i + j - 1, size(value)) + 1)
      end do
      low = v(0)
      if (v(-1) < low .or. v(1) < low) return
      do j = -1, 1, 2
         ! From the sample on, and back from its neighbour.
         down = v(0) - v(-j)
         up = v(j) - v(2*j)
         if (down + up >= 0.0_wp) cycle
         s = min(max((v(j) + up - v(0))/(down + up), 0.0_wp), 1.0_wp)
         low = min(low, v(0) + down*s)
      end do
   end function lowest_between

   !> Number of samples of the carrier.
   pure function samples_of(self) result(n)
      type(search_type), intent(in) :: self
      integer :: n

      n = samples_area
      if (self%line) n = samples_line
   end function samples_of

   !> A sample of the carrier.
   pure function sample_of(self, placing, i) result(swept)
      type(search_type), intent(in) :: self
      type(placing_type), intent(in) :: placing
      !> Number of the sample.
      integer, intent(in) :: i
      type(swept_type) :: swept

      if (self%line) then
         swept = on_line(self, placing, angles(i), i)
      else
         swept = swept_type(self%axes*directions(i, :), 0.0_wp)
      end if
   end function sample_of

   !> Place of a carrier with one parameter.
   pure function on_line(self, placing, u, i) result(swept)
      type(search_type), intent(in) :: self
      type(placing_type), intent(in) :: placing
      !> Its parameter.
      real(wp), intent(in) :: u
      !> Number of the sample that it is; 0 for none.
      integer, intent(in) :: i
      type(swept_type) :: swept

      call self%surfaces(self%carrier)%shape%spine(u, i, reach(self, placing), swept%centre, &
         swept%radius)
   end function on_line

   !> Length of the order of where the other surface may be closest to the axis of a cylinder [m].
   pure function reach(self, placing) result(length)
      type(search_type), intent(in) :: self
      type(placing_type), intent(in) :: placing
      real(wp) :: length

      length = self%size + sqrt(sum(placing%origin**2))
   end function reach

   !> A point of the frame of the carrier in the frame of the other surface.
   pure function carried(self, placing, p) result(q)
      type(search_type), intent(in) :: self
      type(placing_type), intent(in) :: placing
      !> The point, frame of the carrier [m].
      real(wp), intent(in) :: p(3)
      real(wp) :: q(3)

      if (self%carrier == 1) then
         q = matmul(p - placing%origin, placing%rotation)
      else
         q = placing%origin + matmul(placing%rotation, p)
      end if
   end function carried

   !> Distance of the other surface from a place of the carrier.
   pure function distance_of(self, placing, swept) result(distance)
      type(search_type), intent(in) :: self
      type(placing_type), intent(in) :: placing
      type(swept_type), intent(in) :: swept
      real(wp) :: distance
      real(wp) :: foot(3), normal(3)

      call closest_point(self%surfaces(self%other), carried(self, placing, swept%centre), foot, &
         normal, distance)
      distance = distance - swept%radius
   end function distance_of

   !> Search without a point to begin with.
   pure subroutine find_cold(self, placing, track, gap)
      type(search_type), intent(in) :: self
      type(placing_type), intent(in) :: placing
      !> What is found; `lost` when the search fails.
      type(track_type), intent(inout) :: track
      !> Signed distance [m]; when lost, a negative number without meaning.
      real(wp), intent(out) :: gap
      real(wp) :: value(samples_area), best, lowest, g, low, x(3), y(3), n(3), x_low(3), y_low(3)
      real(wp) :: n_low(3)
      logical :: taken(samples_area), found
      integer :: i, k, count, start

      count = samples_of(self)
      taken = .false.
      taken(count + 1:) = .true.
      value = 0.0_wp
      do i = 1, count
         value(i) = distance_of(self, placing, sample_of(self, placing, i))
      end do
      gap = minval(value(:count))
      track%known = .false.
      track%elsewhere = -huge(best)
      best = huge(best)
      lowest = gap
      x_low = 0.0_wp
      y_low = 0.0_wp
      n_low = 0.0_wp
      do start = 1, most_starts
         if (all(taken)) exit
         k = minloc(value, dim=1, mask=.not. taken)
         call leave_out(self, k, value, taken)
         call refine(self, placing, k, x, y, n, g, low, found)
         if (low <= lowest + tolerance*self%size) then
            lowest = min(low, lowest)
            x_low = x
            y_low = y
            n_low = n
         end if
         if (found) found = .not. leads_through(self, placing, x, y, g)
         if (.not. found) cycle
         if (g >= best - 1.0e-13_wp*self%size) cycle
         best = g
         track%first = x
         track%second = y
         track%normal = n
         ! Two convex surfaces have no other place.
         if (.not. self%several .and. g > 0.0_wp) exit
      end do
      track%lost = .false.
      if (best <= lowest + tolerance*self%size) then
         gap = best
         track%known = .true.
         return
      end if
      ! Apart, many places are alike, as about a ring on an axis: any will do. Overlapping, one
      ! surface is far inside of the other, where the distance has no smooth minimum.
      track%lost = .not. (lowest > 0.0_wp .and. any(abs(n_low) > 0.0_wp))
      gap = lowest
      if (track%lost .and. gap > 0.0_wp) gap = -self%size
      track%first = x_low
      track%second = y_low
      track%normal = n_low
      if (track%lost) call look_at_apexes(self, placing, track, gap)
   end subroutine find_cold

   !> Whether a search was lost because an apex of one surface lies within the other.
   pure subroutine look_at_apexes(self, placing, track, gap)
      type(search_type), intent(in) :: self
      type(placing_type), intent(in) :: placing
      !> No longer lost if that is so.
      type(track_type), intent(inout) :: track
      !> The distance of the apex then [m].
      real(wp), intent(inout) :: gap
      real(wp) :: apex(3), seen(3), foot(3), normal(3), distance
      logical :: found
      integer :: i

      do i = 1, 2
         call self%surfaces(i)%shape%apex(apex, found)
         if (.not. found .or. self%surfaces(i)%inside) cycle
         if (i == 1) then
            seen = matmul(apex - placing%origin, placing%rotation)
         else
            seen = placing%origin + matmul(placing%rotation, apex)
         end if
         call closest_point(self%surfaces(3 - i), seen, foot, normal, distance)
         if (.not. distance <= 0.0_wp) cycle
         track%lost = .false.
         gap = distance
         track%first = merge(apex, foot, i == 1)
         track%second = merge(foot, apex, i == 1)
         track%normal = normal
         if (i == 1) track%normal = -matmul(placing%rotation, normal)
      end do
   end subroutine look_at_apexes

   !> Closest points near a sample.
   pure subroutine refine(self, placing, k, x, y, n, gap, low, found)
      type(search_type), intent(in) :: self
      type(placing_type), intent(in) :: placing
      !> Number of the sample.
      integer, intent(in) :: k
      !> Closest point of A, frame of A [m].
      real(wp), intent(out) :: x(3)
      !> Closest point of B, frame of B [m].
      real(wp), intent(out) :: y(3)
      !> Normal of A out of its material, frame of A.
      real(wp), intent(out) :: n(3)
      !> Signed distance [m].
      real(wp), intent(out) :: gap
      !> Smallest distance found near the sample, whether there are closest points or not [m]; the
      !> largest number where the normals point in one direction.
      real(wp), intent(out) :: low
      !> Whether they were found; if not, `x`, `y` and `n` belong to `low`.
      logical, intent(out) :: found
      type(swept_type) :: p

      if (self%line) then
         p = lowest_on_line(self, placing, angles(k))
      else
         p = lowest_on_area(self, placing, sample_of(self, placing, k))
      end if
      call finish(self, placing, p, x, y, n, gap, low, found)
   end subroutine refine

   !> Closest points near a place of the carrier.
   pure subroutine finish(self, placing, p, x, y, n, gap, low, found)
      type(search_type), intent(in) :: self
      type(placing_type), intent(in) :: placing
      type(swept_type), intent(in) :: p
      !> Closest point of A, frame of A [m].
      real(wp), intent(out) :: x(3)
      !> Closest point of B, frame of B [m].
      real(wp), intent(out) :: y(3)
      !> Normal of A out of its material, frame of A.
      real(wp), intent(out) :: n(3)
      !> Signed distance [m].
      real(wp), intent(out) :: gap
      !> As of `refine`.
      real(wp), intent(out) :: low
      !> Whether they were found; if not, `x`, `y` and `n` belong to `low`.
      logical, intent(out) :: found
      real(wp) :: q(3), foot(3), normal(3), distance

      q = carried(self, placing, p%centre)
      call closest_point(self%surfaces(self%other), q, foot, normal, distance)
      if (self%carrier == 1) then
         x = p%centre
         if (self%line) x = p%centre - p%radius*matmul(placing%rotation, normal)
         y = foot
      else
         y = p%centre
         if (self%line) y = p%centre - p%radius*matmul(normal, placing%rotation)
         x = foot
      end if
      low = distance - p%radius
      n = normal_at(self%surfaces(1), x)
      ! At an apex of A that of B counts.
      if (all(abs(n) <= 0.0_wp)) n = -matmul(placing%rotation, normal_at(self%surfaces(2), y))
      ! Normals in one direction: this is the far side of a surface, or one lies within the other.
      normal = normal_at(self%surfaces(2), y)
      normal = matmul(placing%rotation, normal)
      if (dot_product(n, normal) > 0.0_wp) low = huge(low)
      call polish(self, placing, x, y, n, gap, found)
   end subroutine finish

   !> Do not start again from a sample, nor from those uphill of it on a line, or near it.
   pure subroutine leave_out(self, sample, value, taken)
      type(search_type), intent(in) :: self
      integer, intent(in) :: sample
      !> Distances of all samples [m].
      real(wp), intent(in) :: value(:)
      !> Samples that are done.
      logical, intent(inout) :: taken(:)
      integer :: j, next, down

      if (self%line) then
         taken(sample) = .true.
         do down = -1, 1, 2
            j = sample
            do
               next = modulo(j + down - 1, samples_line) + 1
               if (value(next) < value(j) .or. next == sample) exit
               j = next
               taken(j) = .true.
            end do
         end do
      else
         do j = 1, samples_area
            if (sum(directions(j, :)*directions(sample, :)) > nearby_area) taken(j) = .true.
         end do
      end if
   end subroutine leave_out

   !> Place of a carrier with one parameter where the distance is smallest, near a sample.
   pure function lowest_on_line(self, placing, angle) result(p)
      type(search_type), intent(in) :: self
      type(placing_type), intent(in) :: placing
      !> Angle of the sample.
      real(wp), intent(in) :: angle
      type(swept_type) :: p
      real(wp) :: value, width, best, at_best
      integer :: i

      ! The best of finer samples first: there may be two minima side by side.
      width = 2.0_wp*pi/samples_line
      best = angle
      at_best = huge(at_best)
      do i = -finer, finer
         value = distance_of(self, placing, on_line(self, placing, angle + i*width/finer, 0))
         if (value >= at_best) cycle
         best = angle + i*width/finer
         at_best = value
      end do
      width = width/finer
      p = lowest_about(self, placing, best, width)
   end function lowest_on_line

   !> Place of a carrier with one parameter where the distance is smallest in an interval.
   pure function lowest_about(self, placing, angle, width) result(p)
      type(search_type), intent(in) :: self
      type(placing_type), intent(in) :: placing
      !> Middle of the interval.
      real(wp), intent(in) :: angle
      !> Half of its length.
      real(wp), intent(in) :: width
      type(swept_type) :: p
      real(wp), parameter :: golden = 0.6180339887498949_wp
      real(wp) :: low, high, left, right, at_left, at_right
      integer :: i

      low = angle - width
      high = angle + width
      left = high - golden*(high - low)
      right = low + golden*(high - low)
      at_left = distance_of(self, placing, point_at(left))
      at_right = distance_of(self, placing, point_at(right))
      do i = 1, 20
         if (at_left <= at_right) then
            high = right
            right = left
            at_right = at_left
            left = high - golden*(high - low)
            at_left = distance_of(self, placing, point_at(left))
         else
            low = left
            left = right
            at_left = at_right
            right = low + golden*(high - low)
            at_right = distance_of(self, placing, point_at(right))
         end if
      end do
      p = point_at(0.5_wp*(low + high))

   contains

      !> Place of the carrier.
      pure function point_at(u) result(swept)
         !> Its parameter.
         real(wp), intent(in) :: u
         type(swept_type) :: swept

         swept = on_line(self, placing, u, 0)
      end function point_at

   end function lowest_about

   !> Point of an ellipsoid or a sphere where the distance is smallest, near a sample: Newton's
   !> method in the unit sphere that an affine map makes of the ellipsoid, on the distance as a
   !> function of the point, each step downhill.
   pure function lowest_on_area(self, placing, sample) result(p)
      type(search_type), intent(in) :: self
      type(placing_type), intent(in) :: placing
      type(swept_type), intent(in) :: sample
      type(swept_type) :: p
      real(wp) :: u(3), t(3, 2), image(3), value, next, slope(3), hesse(3), g(2), h(3)
      real(wp) :: determinant, low, shift, step(2), length, trial(3)
      integer :: i, j

      u = sample%centre/self%axes
      u = u/sqrt(sum(u**2))
      t(:, 1) = any_tangent(u)
      t(:, 2) = cross(u, t(:, 1))
      call slopes(self, placing, self%axes*u, t, value, slope, hesse)
      do i = 1, most_descents
         image = self%axes*slope
         g = [dot_product(image, t(:, 1)), dot_product(image, t(:, 2))]
         h = hesse - dot_product(image, u)*[1.0_wp, 0.0_wp, 1.0_wp]
         low = 0.5_wp*(h(1) + h(3)) - sqrt((0.5_wp*(h(1) - h(3)))**2 + h(2)**2)
         ! Raised so that the step is downhill.
         shift = max(0.0_wp, 1.0e-3_wp*maxval(self%axes) - low)
         if (low > 0.0_wp) shift = 0.0_wp
         h(1) = h(1) + shift
         h(3) = h(3) + shift
         determinant = h(1)*h(3) - h(2)**2
         if (.not. determinant > 0.0_wp) exit
         step = -[h(3)*g(1) - h(2)*g(2), h(1)*g(2) - h(2)*g(1)]/determinant
         length = sqrt(sum(step**2))
         if (length < 1.0e-7_wp) exit
         if (length > 0.5_wp) step = step*(0.5_wp/length)
         do j = 1, 30
            trial = u + step(1)*t(:, 1) + step(2)*t(:, 2)
            trial = trial/sqrt(sum(trial**2))
            next = distance_of(self, placing, swept_type(self%axes*trial, 0.0_wp))
            if (next < value) exit
            step = 0.5_wp*step
         end do
         if (.not. next < value) exit
         u = trial
         t(:, 1) = any_tangent(u)
         t(:, 2) = cross(u, t(:, 1))
         call slopes(self, placing, self%axes*u, t, value, slope, hesse)
      end do
      p = swept_type(self%axes*u, 0.0_wp)
   end function lowest_on_area

   !> Distance with its gradient and, along the images of two tangents, its second derivatives.
   pure subroutine slopes(self, placing, point, tangent, distance, gradient, second)
      type(search_type), intent(in) :: self
      type(placing_type), intent(in) :: placing
      !> Point of the carrier [m].
      real(wp), intent(in) :: point(3)
      !> The tangents of the unit sphere.
      real(wp), intent(in) :: tangent(3, 2)
      !> Distance [m].
      real(wp), intent(out) :: distance
      !> Gradient in the frame of the carrier.
      real(wp), intent(out) :: gradient(3)
      !> Second derivatives 11, 12, 22.
      real(wp), intent(out) :: second(3)
      real(wp) :: foot(3), normal(3), basis(3, 2), form(3), turned(3, 2), v(2, 2), m(3), d

      associate (other => self%surfaces(self%other))
         call closest_point(other, carried(self, placing, point), foot, normal, distance)
         basis(:, 1) = any_tangent(normal)
         basis(:, 2) = cross(normal, basis(:, 1))
         call form_at(other, foot, normal, basis, form)
      end associate
      if (self%carrier == 1) then
         gradient = matmul(placing%rotation, normal)
         turned = matmul(placing%rotation, basis)
      else
         gradient = matmul(normal, placing%rotation)
         turned = matmul(transpose(placing%rotation), basis)
      end if
      ! Form of the parallel surface through the point, L (1 + d L)^-1.
      d = (1.0_wp + distance*form(1))*(1.0_wp + distance*form(3)) - (distance*form(2))**2
      m = form + distance*(form(1)*form(3) - form(2)**2)*[1.0_wp, 0.0_wp, 1.0_wp]
      if (abs(d) > 1.0e-10_wp) m = m/d
      v(:, 1) = matmul(self%axes*tangent(:, 1), turned)
      v(:, 2) = matmul(self%axes*tangent(:, 2), turned)
      second(1) = quadratic(m, v(:, 1), v(:, 1))
      second(2) = quadratic(m, v(:, 1), v(:, 2))
      second(3) = quadratic(m, v(:, 2), v(:, 2))
   end subroutine slopes

   !> a.L b, L a symmetric form.
   pure function quadratic(form, a, b) result(value_of)
      !> Components 11, 12, 22.
      real(wp), intent(in) :: form(3)
      !> First vector.
      real(wp), intent(in) :: a(2)
      !> Second vector.
      real(wp), intent(in) :: b(2)
      real(wp) :: value_of

      value_of = form(1)*a(1)*b(1) + form(2)*(a(1)*b(2) + a(2)*b(1)) + form(3)*a(2)*b(2)
   end function quadratic

end module contensou_contact_search
