!> Two surfaces of any shape: closed forms for a sphere against anything, a plane against what has a
!> lowest point, and two cylinders; the search for all others.
!>
!> One of the two surfaces, the base, holds the point and the normal from which the contact is
!> built: the one that is not a sphere or a plane, else surface A.
module contensou_contact_surface_pair
   use contensou_base_kinds, only : wp
   use contensou_base_vectors, only : cross
   use contensou_contact_geometry, only : contact_point_type, contact_variation_type, &
      geometry_type, pose_type, track_type, unbounded
   use contensou_contact_relative, only : contact_frame_type, set_curvatures, set_variation
   use contensou_contact_search, only : placing_type, search_type, set_search
   use contensou_contact_shapes_shape, only : shape_info_type
   use contensou_contact_surface, only : closest_point, cubic_at, form_at, surface_type
   implicit none(type, external)
   private

   public :: new_ball_pair, new_support_pair, new_axes_pair, new_searched_pair

   !> Sine of the angle of two axes below which they are parallel.
   real(wp), parameter :: parallel = 1.0e-9_wp

   !> Smallest part of its radius that a convex surface keeps as a scale in a concave one.
   real(wp), parameter :: least_part = 0.01_wp

   !> Spots where no smaller number is known: more than that have to be told from a line.
   integer, parameter :: most_spots = 4

   !> Two surfaces where they are closest, in their own frames.
   type :: meeting_type
      !> Closest point of the base and of the other surface [m].
      real(wp) :: x(3)
      real(wp) :: y(3)
      !> Normal of the base, out of its material.
      real(wp) :: normal(3)
      !> Tangents of the base.
      real(wp) :: tangents(3, 2)
      !> Those in the frame of the other surface, if its form depends on them.
      real(wp) :: tangents_other(3, 2)
      !> Both, inertial frame.
      type(contact_frame_type) :: spot
   end type meeting_type

   !> Two surfaces.
   type, abstract, extends(geometry_type) :: surface_pair_type
      !> The surfaces, and how they are searched where no closed form is known.
      type(search_type) :: search
      !> Whether the base is surface A.
      logical :: base_first = .true.
      !> Where between the closest points the contact point lies: 0 on A, 1 on B.
      real(wp) :: share = 0.5_wp
      !> Whether the curvatures of the other surface are the same everywhere.
      logical :: even = .false.
      !> Whether they are so in all directions.
      logical :: isotropic = .false.
      !> Form of the other surface then [1/m].
      real(wp) :: form_other(3) = 0.0_wp
      !> Curvature A where it is constant [1/m].
      real(wp) :: curvature_a = 0.0_wp
      !> Curvature B where it is constant [1/m].
      real(wp) :: curvature_b = 0.0_wp
      !> Whether the major axis is the second tangent where the curvatures are constant.
      logical :: major_second = .false.
   contains
      procedure :: locate => pair_locate
      procedure :: vary => pair_vary
      procedure :: smallest_radius => pair_radius
      procedure :: mean_form => pair_mean_form
   end type surface_pair_type

   !> A ball on or in the base, by the distance of its centre.
   type, extends(surface_pair_type) :: ball_pair_type
      real(wp) :: radius = 0.0_wp
   contains
      procedure :: gap => ball_gap
   end type ball_pair_type

   !> The base on a plane, by its lowest point.
   type, extends(surface_pair_type) :: support_pair_type
   contains
      procedure :: gap => support_gap
   end type support_pair_type

   !> Two cylinders, by the distance of their axes.
   type, extends(surface_pair_type) :: axes_pair_type
      real(wp) :: radius_a = 0.0_wp
      real(wp) :: radius_b = 0.0_wp
   contains
      procedure :: gap => axes_gap
   end type axes_pair_type

   !> Any two surfaces.
   type, extends(surface_pair_type) :: searched_pair_type
   contains
      procedure :: gap => searched_gap
      procedure :: find_places => searched_places
   end type searched_pair_type

contains

   !> What all pairs of surfaces hold.
   subroutine set_pair(self, a, b, base_first)
      class(surface_pair_type), intent(inout) :: self
      type(surface_type), intent(in) :: a
      type(surface_type), intent(in) :: b
      !> Whether the base is surface A.
      logical, intent(in) :: base_first
      real(wp) :: k_a(2), k_b(2)
      logical :: even_a, even_b

      self%search%surfaces(1) = a
      self%search%surfaces(2) = b
      self%base_first = base_first
      self%constant_curvatures = .false.
      call a%shape%constant_curvatures(even_a, k_a)
      call b%shape%constant_curvatures(even_b, k_b)
      if (is_flat(even_b, k_b)) self%share = 0.0_wp
      if (is_flat(even_a, k_a)) self%share = 1.0_wp
      self%even = merge(even_b, even_a, base_first)
      if (base_first) k_a = k_b
      self%isotropic = self%even .and. abs(k_a(1) - k_a(2)) <= 0.0_wp
      if (self%isotropic) then
         self%form_other = k_a(1)*[1.0_wp, 0.0_wp, 1.0_wp]
         if (merge(b%inside, a%inside, base_first)) self%form_other = -self%form_other
      end if
      self%into_hollow = max(meeting(a, b), meeting(b, a))

   contains

      !> Largest curvature of what meets a surface [1/m]; 0 if that is convex, or only its hull is
      !> met, as by a plane.
      pure real(wp) function meeting(hollow, other)
         type(surface_type), intent(in) :: hollow
         type(surface_type), intent(in) :: other
         type(shape_info_type) :: info

         meeting = 0.0_wp
         info = hollow%shape%info()
         if (.not. hollow%inside .and. (info%convex .or. self%share < 0.5_wp .or. &
            self%share > 0.5_wp)) return
         meeting = unbounded
         if (other%shape%smallest_radius() < huge(meeting)) meeting = &
            1.0_wp/other%shape%smallest_radius()
      end function meeting

      !> Whether a surface is a plane.
      pure logical function is_flat(even, k)
         !> Whether its curvatures are the same everywhere.
         logical, intent(in) :: even
         !> The curvatures [1/m].
         real(wp), intent(in) :: k(2)

         is_flat = even .and. all(abs(k) <= 0.0_wp)
      end function is_flat

   end subroutine set_pair

   !> A ball on or in a surface.
   subroutine new_ball_pair(a, b, ball_first, geometry)
      type(surface_type), intent(in) :: a, b
      !> Whether the ball is surface A.
      logical, intent(in) :: ball_first
      class(geometry_type), allocatable, intent(out) :: geometry
      type(ball_pair_type), allocatable :: self

      if (is_wedged(a, b) .or. is_wedged(b, a)) then
         call new_searched_pair(a, b, .true., geometry)
         return
      end if
      allocate(self)
      call set_pair(self, a, b, .not. ball_first)
      if (ball_first) then
         self%radius = a%shape%smallest_radius()
         call set_constants(b)
      else
         self%radius = b%shape%smallest_radius()
         call set_constants(a)
      end if
      call move_alloc(self, geometry)

   contains

      !> Whether a ball fits into a hollow, but not where that is narrowest: between two of its
      !> walls it touches twice.
      pure logical function is_wedged(ball, hollow)
         type(surface_type), intent(in) :: ball
         type(surface_type), intent(in) :: hollow

         is_wedged = hollow%inside
         if (is_wedged) is_wedged = ball%shape%smallest_radius() >= hollow%shape%narrowest()
      end function is_wedged

      !> Curvatures that never change.
      subroutine set_constants(base)
         type(surface_type), intent(in) :: base
         real(wp) :: k(2)

         call base%shape%constant_curvatures(self%constant_curvatures, k)
         if (.not. self%constant_curvatures) return
         if (base%inside) k = -k
         k = 1.0_wp/self%radius + k
         self%major_second = k(2) < k(1)
         self%curvature_a = 0.5_wp*minval(k)
         self%curvature_b = 0.5_wp*maxval(k)
      end subroutine set_constants

   end subroutine new_ball_pair

   !> A surface with a lowest point on a plane.
   subroutine new_support_pair(a, b, body_first, geometry)
      type(surface_type), intent(in) :: a, b
      !> Whether the plane is surface B.
      logical, intent(in) :: body_first
      class(geometry_type), allocatable, intent(out) :: geometry
      type(support_pair_type), allocatable :: self

      allocate(self)
      call set_pair(self, a, b, body_first)
      call move_alloc(self, geometry)
   end subroutine new_support_pair

   !> Two cylinders.
   subroutine new_axes_pair(a, b, first_is_a, geometry)
      type(surface_type), intent(in) :: a, b
      !> Of no importance.
      logical, intent(in) :: first_is_a
      class(geometry_type), allocatable, intent(out) :: geometry
      type(axes_pair_type), allocatable :: self

      allocate(self)
      call set_pair(self, a, b, .true.)
      self%radius_a = a%shape%smallest_radius()
      self%radius_b = b%shape%smallest_radius()
      call move_alloc(self, geometry)
   end subroutine new_axes_pair

   !> Two surfaces, one of them at least a carrier of a search.
   subroutine new_searched_pair(a, b, first_is_a, geometry)
      type(surface_type), intent(in) :: a, b
      !> Of no importance.
      logical, intent(in) :: first_is_a
      class(geometry_type), allocatable, intent(out) :: geometry
      type(searched_pair_type), allocatable :: self

      allocate(self)
      call set_pair(self, a, b, .true.)
      call set_search(self%search)
      self%searched = .true.
      self%most_spots = spots_of(a, b, self%search%several)
      self%ordering = self%search%carrier
      self%length = self%search%size
      call move_alloc(self, geometry)
   end subroutine new_searched_pair

   !> Signed distance of a ball and another surface [m].
   pure subroutine ball_gap(self, a, b, track, gap)
      class(ball_pair_type), intent(in) :: self
      type(pose_type), intent(in) :: a, b
      !> Receives the closest point.
      type(track_type), intent(inout) :: track
      real(wp), intent(out) :: gap
      real(wp) :: at_base(3)

      if (self%base_first) then
         at_base = seen(self%search%surfaces(1), a, self%search%surfaces(2)%centre, b)
         call closest_point(self%search%surfaces(1), at_base, track%first, track%normal, gap)
      else
         at_base = seen(self%search%surfaces(2), b, self%search%surfaces(1)%centre, a)
         call closest_point(self%search%surfaces(2), at_base, track%second, track%normal, gap)
      end if
      gap = gap - self%radius
      track%known = .true.
   end subroutine ball_gap

   !> Signed distance of a surface and a plane [m].
   pure subroutine support_gap(self, a, b, track, gap)
      class(support_pair_type), intent(in) :: self
      type(pose_type), intent(in) :: a, b
      !> Receives the closest point.
      type(track_type), intent(inout) :: track
      real(wp), intent(out) :: gap

      if (self%base_first) then
         call support_of(self%search%surfaces(1), self%search%surfaces(2), a, b, track%first, &
            track%normal, gap, track%known)
      else
         call support_of(self%search%surfaces(2), self%search%surfaces(1), b, a, track%second, &
            track%normal, gap, track%known)
      end if
      track%lost = .not. track%known
   end subroutine support_gap

   !> Signed distance of two surfaces by search [m].
   pure subroutine searched_gap(self, a, b, track, gap)
      class(searched_pair_type), intent(in) :: self
      type(pose_type), intent(in) :: a, b
      !> Where the search begins, and what it finds; `lost` when it fails.
      type(track_type), intent(inout) :: track
      real(wp), intent(out) :: gap

      call self%search%find(placing_of(self, a, b), track, gap)
   end subroutine searched_gap

   !> All places where the gap is smallest among those near by, and below a limit.
   pure subroutine searched_places(self, a, b, limit, places, gaps, n)
      class(searched_pair_type), intent(in) :: self
      type(pose_type), intent(in) :: a, b
      real(wp), intent(in) :: limit
      type(track_type), intent(inout) :: places(:)
      real(wp), intent(out) :: gaps(:)
      integer, intent(out) :: n

      call self%search%find_places(placing_of(self, a, b), limit, places, gaps, n)
   end subroutine searched_places

   !> Number of places where two searched surfaces may touch at the same time, from their shapes and
   !> sizes.
   !>
   !> Convex bodies have one. So has a convex body in a convex hollow if none of its radii of
   !> curvature is larger than any of the hollow: it rolls freely in there (W. Blaschke, Kreis und
   !> Kugel (1916), section 24). The distance of the points of a circle from a line has two
   !> smallest and two largest values at most, from a point one of each, and that of the points of
   !> an ellipse or an ellipsoid from a point no more than two largest ones.
   pure integer function spots_of(a, b, several)
      type(surface_type), intent(in) :: a
      type(surface_type), intent(in) :: b
      !> Whether they may have more than one.
      logical, intent(in) :: several

      if (.not. several) then
         spots_of = 1
      else if (a%inside) then
         spots_of = spots_in(b, a)
      else if (b%inside) then
         spots_of = spots_in(a, b)
      else
         spots_of = merge(2, most_spots, evenness(a) + evenness(b) > 0)
      end if

   contains

      !> Number for a body in a hollow.
      pure integer function spots_in(body, hollow)
         type(surface_type), intent(in) :: body
         type(surface_type), intent(in) :: hollow
         type(shape_info_type) :: info, other

         info = body%shape%info()
         other = hollow%shape%info()
         spots_in = merge(2, most_spots, evenness(hollow) + evenness(body) > 0)
         if (info%convex .and. other%convex .and. hollow%shape%narrowest() < huge(1.0_wp)) then
            if (body%shape%largest_radius() < hollow%shape%narrowest()) spots_in = 1
         else if (.not. info%convex .and. evenness(hollow) == 2) then
            spots_in = 1
         end if
      end function spots_in

      !> Whether the curvatures of a surface are the same everywhere (1), as of a cylinder, and in
      !> all directions (2), as of a sphere.
      pure integer function evenness(surface)
         type(surface_type), intent(in) :: surface
         logical :: even
         real(wp) :: k(2)

         call surface%shape%constant_curvatures(even, k)
         evenness = merge(1, 0, even)
         if (even .and. abs(k(1) - k(2)) <= 0.0_wp) evenness = 2
      end function evenness

   end function spots_of

   !> A point of one body in the frame of a surface of another [m].
   pure function seen(surface, pose, point, pose_of_point) result(p)
      type(surface_type), intent(in) :: surface
      !> Pose of its body.
      type(pose_type), intent(in) :: pose
      !> The point in the frame of its body [m].
      real(wp), intent(in) :: point(3)
      !> Pose of the body of the point.
      type(pose_type), intent(in) :: pose_of_point
      real(wp) :: p(3)
      real(wp) :: offset(3)

      offset = pose_of_point%position - pose%position + matmul(pose_of_point%rotation, point)
      p = matmul(offset, pose%rotation) - surface%centre
      p = matmul(p, surface%frame)
   end function seen

   !> Frame of surface B seen from surface A.
   pure function placing_of(self, a, b) result(placing)
      class(surface_pair_type), intent(in) :: self
      !> Pose of body A.
      type(pose_type), intent(in) :: a
      !> Pose of body B.
      type(pose_type), intent(in) :: b
      type(placing_type) :: placing
      real(wp) :: frame_a(3, 3), frame_b(3, 3)

      frame_a = matmul(a%rotation, self%search%surfaces(1)%frame)
      frame_b = matmul(b%rotation, self%search%surfaces(2)%frame)
      placing%rotation = matmul(transpose(frame_a), frame_b)
      placing%origin = seen(self%search%surfaces(1), a, self%search%surfaces(2)%centre, b)
   end function placing_of

   !> Lowest point of a surface above a plane.
   pure subroutine support_of(body, plane, pose, pose_of_plane, x, normal, gap, found)
      type(surface_type), intent(in) :: body
      type(surface_type), intent(in) :: plane
      !> Pose of the body of the former.
      type(pose_type), intent(in) :: pose
      !> Pose of the body of the plane.
      type(pose_type), intent(in) :: pose_of_plane
      !> Lowest point in the frame of the surface [m].
      real(wp), intent(out) :: x(3)
      real(wp), intent(out) :: normal(3)
      !> Its height above the plane [m].
      real(wp), intent(out) :: gap
      logical, intent(out) :: found
      real(wp) :: up(3), k(3), offset(3), height

      up = matmul(pose_of_plane%rotation, plane%frame(:, 3))
      offset = pose%position - pose_of_plane%position + matmul(pose%rotation, body%centre)
      height = dot_product(up, offset) - dot_product(plane%frame(:, 3), plane%centre)
      k = matmul(up, pose%rotation)
      k = matmul(k, body%frame)
      normal = -k
      call body%shape%support(k, height, x, gap, found)
   end subroutine support_of

   !> Distance of two cylinders.
   pure subroutine axes_gap(self, a, b, track, gap)
      class(axes_pair_type), intent(in) :: self
      type(pose_type), intent(in) :: a, b
      !> Receives the closest points.
      type(track_type), intent(inout) :: track
      real(wp), intent(out) :: gap
      type(placing_type) :: placing
      real(wp) :: n(3), sine, along_a, along_b, distance

      placing = placing_of(self, a, b)
      associate (w => placing%origin, z => placing%rotation(:, 3))
         n = [-z(2), z(1), 0.0_wp]
         sine = sqrt(z(1)**2 + z(2)**2)
         if (sine > parallel) then
            n = n/sine
            distance = n(1)*w(1) + n(2)*w(2)
            if (distance < 0.0_wp) n = -n
            distance = abs(distance)
            along_b = -(w(1)*z(1) + w(2)*z(2))/sine**2
            along_a = w(3) + along_b*z(3)
         else
            ! Any two opposite points are closest.
            distance = sqrt(w(1)**2 + w(2)**2)
            n = [1.0_wp, 0.0_wp, 0.0_wp]
            if (distance > 0.0_wp) n(1:2) = w(1:2)/distance
            along_b = -0.5_wp*w(3)*z(3)
            along_a = 0.5_wp*w(3)
         end if
         gap = distance - (self%radius_a + self%radius_b)
         track%normal = n
         track%first = self%radius_a*n
         track%first(3) = track%first(3) + along_a
         track%second = -self%radius_b*matmul(n, placing%rotation)
         track%second(3) = track%second(3) + along_b
      end associate
      track%known = .true.
   end subroutine axes_gap

   !> Contact point of the pair.
   pure subroutine pair_locate(self, a, b, track, gap, at)
      class(surface_pair_type), intent(in) :: self
      type(pose_type), intent(in) :: a, b
      type(track_type), intent(in) :: track
      !> Gap of these poses [m].
      real(wp), intent(in) :: gap
      type(contact_point_type), intent(out) :: at
      type(meeting_type) :: met

      call find_meeting(self, a, b, track, gap, .not. self%constant_curvatures, met)
      at%gap = gap
      at%point = met%spot%point
      at%normal = met%spot%normal
      if (self%constant_curvatures) then
         at%curvature_a = self%curvature_a
         at%curvature_b = self%curvature_b
         at%major = met%spot%tangent(:, merge(2, 1, self%major_second))
      else
         call set_curvatures(met%spot, at)
      end if
   end subroutine pair_locate

   !> Mean curvature of the two surfaces in the axes of the spot.
   pure subroutine pair_mean_form(self, a, b, track, at, form)
      class(surface_pair_type), intent(in) :: self
      type(pose_type), intent(in) :: a, b
      type(track_type), intent(in) :: track
      type(contact_point_type), intent(in) :: at
      real(wp), intent(out) :: form(3)
      type(meeting_type) :: met
      real(wp) :: c, s, l(3)

      call find_meeting(self, a, b, track, at%gap, .true., met)
      l = 0.5_wp*(met%spot%second - met%spot%first)
      c = dot_product(at%major, met%spot%tangent(:, 1))
      s = dot_product(at%major, met%spot%tangent(:, 2))
      form = [c*c*l(1) + 2.0_wp*c*s*l(2) + s*s*l(3), &
         c*s*(l(3) - l(1)) + (c*c - s*s)*l(2), &
         s*s*l(1) - 2.0_wp*c*s*l(2) + c*c*l(3)]
   end subroutine pair_mean_form

   !> The two surfaces at their closest points.
   pure subroutine find_meeting(self, a, b, track, gap, curved, met)
      class(surface_pair_type), intent(in) :: self
      !> Pose of body A.
      type(pose_type), intent(in) :: a
      !> Pose of body B.
      type(pose_type), intent(in) :: b
      !> The closest points, and the normal of the base.
      type(track_type), intent(in) :: track
      !> Gap [m].
      real(wp), intent(in) :: gap
      !> Whether the forms are wanted.
      logical, intent(in) :: curved
      type(meeting_type), intent(out) :: met

      met%normal = track%normal
      met%spot%gap = gap
      met%spot%share = self%share
      if (self%base_first) then
         met%x = track%first
         met%y = track%second
         call set_frame(self, self%search%surfaces(1), self%search%surfaces(2), a, b, curved, met)
      else
         met%x = track%second
         met%y = track%first
         call set_frame(self, self%search%surfaces(2), self%search%surfaces(1), b, a, curved, met)
      end if
   end subroutine find_meeting

   !> The two surfaces at their closest points, seen from the base.
   pure subroutine set_frame(self, base, other, pose, pose_of_other, curved, met)
      class(surface_pair_type), intent(in) :: self
      type(surface_type), intent(in) :: base
      type(surface_type), intent(in) :: other
      !> Pose of the body of the base.
      type(pose_type), intent(in) :: pose
      !> Pose of the other body.
      type(pose_type), intent(in) :: pose_of_other
      !> Whether the forms are wanted.
      logical, intent(in) :: curved
      !> The closest points and the normal of the base are set.
      type(meeting_type), intent(inout) :: met
      real(wp) :: frame(3, 3), frame_other(3, 3), n(3), m(3), lead, form_base(3), form_other(3)

      associate (spot => met%spot, t => met%tangents)
         frame = matmul(pose%rotation, base%frame)
         lead = self%share*spot%gap
         if (self%base_first) then
            n = met%normal
         else
            n = -met%normal
            lead = lead - spot%gap
         end if
         call base%shape%principal(met%x, met%normal, t(:, 1))
         t(:, 2) = cross(n, t(:, 1))
         spot%normal = matmul(frame, n)
         spot%tangent = matmul(frame, t)
         spot%point = pose%position + matmul(pose%rotation, base%centre)
         spot%point = spot%point + matmul(frame, met%x + lead*n)
         if (.not. curved) return
         call form_at(base, met%x, met%normal, t, form_base)
         if (self%isotropic) then
            form_other = self%form_other
         else
            frame_other = matmul(pose_of_other%rotation, other%frame)
            met%tangents_other = matmul(transpose(frame_other), spot%tangent)
            ! Out of the material of the other surface, in its frame.
            m = matmul(spot%normal, frame_other)
            if (self%base_first) m = -m
            call form_at(other, met%y, m, met%tangents_other, form_other)
         end if
         if (self%base_first) then
            spot%first = form_base
            spot%second = form_other
         else
            spot%first = form_other
            spot%second = form_base
         end if
      end associate
   end subroutine set_frame

   !> Variation of the contact.
   pure subroutine pair_vary(self, a, b, track, at, variation)
      class(surface_pair_type), intent(in) :: self
      type(pose_type), intent(in) :: a, b
      type(track_type), intent(in) :: track
      type(contact_point_type), intent(in) :: at
      type(contact_variation_type), intent(out) :: variation
      type(meeting_type) :: met
      real(wp) :: cubic_base(4), cubic_other(4), normal(3)

      call find_meeting(self, a, b, track, at%gap, .true., met)
      associate (base => self%search%surfaces(merge(1, 2, self%base_first)), &
         other => self%search%surfaces(merge(2, 1, self%base_first)))
         call cubic_at(base, met%x, met%normal, met%tangents, cubic_base)
         cubic_other = 0.0_wp
         if (.not. self%even) then
            if (self%base_first) then
               normal = matmul(met%spot%normal, b%rotation)
            else
               normal = matmul(met%spot%normal, a%rotation)
            end if
            normal = matmul(normal, other%frame)
            if (self%base_first) normal = -normal
            call cubic_at(other, met%y, normal, met%tangents_other, cubic_other)
         end if
      end associate
      if (self%base_first) then
         call set_variation(met%spot, cubic_base, cubic_other, variation)
      else
         call set_variation(met%spot, cubic_other, cubic_base, variation)
      end if
      if (self%constant_curvatures) then
         variation%curvature_a = 0.0_wp
         variation%curvature_b = 0.0_wp
      end if
   end subroutine pair_vary

   !> Scale of the overlaps that a pair admits [m].
   !>
   !> For surfaces that are both convex it is the smallest radius of curvature of either. A convex
   !> surface of radius r in a concave one of radius R has a spot that is larger, by
   !> sqrt(1/(1 - r/R)), at the same overlap: there the scale is r (1 - r/R), so that the largest
   !> spot is the same part of r. At least one hundredth of r is left, where the surfaces conform
   !> somewhere but not everywhere.
   pure function pair_radius(self) result(radius)
      class(surface_pair_type), intent(in) :: self
      real(wp) :: radius
      real(wp) :: radius_a, radius_b

      radius_a = self%search%surfaces(1)%shape%smallest_radius()
      radius_b = self%search%surfaces(2)%shape%smallest_radius()
      if (self%search%surfaces(1)%inside) then
         radius = radius_b*max(1.0_wp - radius_b/self%search%surfaces(1)%shape%narrowest(), &
            least_part)
      else if (self%search%surfaces(2)%inside) then
         radius = radius_a*max(1.0_wp - radius_a/self%search%surfaces(2)%shape%narrowest(), &
            least_part)
      else
         radius = min(radius_a, radius_b)
      end if
   end function pair_radius

end module contensou_contact_surface_pair
