!> Two surfaces of any shape: closed forms for a sphere against anything, a plane against an
!> ellipsoid or a torus, and two cylinders; the search for all others.
!>
!> One of the two surfaces, the base, holds the point and the normal from which the contact is
!> built: the one that is not a sphere or a plane, else surface A.
module contensou_contact_surface_pair
   use contensou_base_kinds, only : wp
   use contensou_base_vectors, only : cross
   use contensou_contact_geometry, only : contact_point_type, contact_variation_type, &
      geometry_type, pose_type, track_type
   use contensou_contact_implicit_surface, only : closest_point, cubic_at, form_at, principal_at
   use contensou_contact_relative, only : meeting_type, set_curvatures, set_variation
   use contensou_contact_search, only : new_search, placing_type, search_type
   use contensou_contact_surface, only : shape_cylinder, shape_ellipsoid, shape_plane, &
      shape_sphere, shape_torus, smallest_curvature_radius, surface_type
   implicit none(type, external)
   private

   public :: surface_pair_type, new_surface_pair

   !> Ways to the closest points: distance from the centre of a sphere, support of a plane, distance
   !> of two axes, search.
   integer, parameter :: by_centre = 1, by_support = 2, by_axes = 3, by_search = 4

   !> Sine of the angle of two axes below which they are parallel.
   real(wp), parameter :: parallel = 1.0e-9_wp

   !> Smallest part of its radius that a convex surface keeps as a scale in a concave one.
   real(wp), parameter :: least_part = 0.01_wp

   !> Two surfaces.
   type, extends(geometry_type) :: surface_pair_type
      type(surface_type), private :: a
      type(surface_type), private :: b
      !> Way to the closest points.
      integer, private :: way = by_search
      !> Whether the base is surface A.
      logical, private :: base_first = .true.
      !> Where between the closest points the contact point lies: 0 on A, 1 on B.
      real(wp), private :: share = 0.5_wp
      !> Curvature A where it is constant [1/m].
      real(wp), private :: curvature_a = 0.0_wp
      !> Curvature B where it is constant [1/m].
      real(wp), private :: curvature_b = 0.0_wp
      !> Whether the major axis is the second tangent where the curvatures are constant.
      logical, private :: major_second = .false.
      type(search_type), private :: search
   contains
      procedure :: gap => pair_gap
      procedure :: locate => pair_locate
      procedure :: vary => pair_vary
      procedure :: smallest_radius => pair_radius
   end type surface_pair_type

contains

   !> A pair of surfaces that can touch in a point.
   pure function new_surface_pair(a, b, search) result(self)
      type(surface_type), intent(in) :: a
      type(surface_type), intent(in) :: b
      !> Whether to search even where there is a closed form; for comparisons.
      logical, intent(in), optional :: search
      type(surface_pair_type) :: self
      logical :: ball_a, ball_b
      real(wp) :: low, high, ball, other

      self%a = a
      self%b = b
      if (b%shape == shape_plane) self%share = 0.0_wp
      if (a%shape == shape_plane) self%share = 1.0_wp
      self%search = new_search(a, b)
      ball_a = a%shape == shape_sphere .and. .not. a%inside
      ball_b = b%shape == shape_sphere .and. .not. b%inside
      if (ball_a .or. ball_b) then
         self%way = by_centre
         ! Of two spheres the second is the base unless it is the ball in a socket.
         self%base_first = .not. ball_a
      else if (a%shape == shape_plane .or. b%shape == shape_plane) then
         self%way = by_support
         self%base_first = b%shape == shape_plane
      else if (a%shape == shape_cylinder .and. b%shape == shape_cylinder) then
         self%way = by_axes
      end if
      self%constant_curvatures = .false.
      if (self%way == by_centre) then
         ball = 1.0_wp/merge(b%radius, a%radius, self%base_first)
         associate (base_shape => merge(a%shape, b%shape, self%base_first), &
            base_radius => merge(a%radius, b%radius, self%base_first), &
            base_inside => merge(a%inside, b%inside, self%base_first))
            select case (base_shape)
            case (shape_plane)
               self%constant_curvatures = .true.
               low = ball
               high = ball
            case (shape_sphere, shape_cylinder)
               self%constant_curvatures = .true.
               other = ball + merge(-1.0_wp, 1.0_wp, base_inside)/base_radius
               if (base_shape == shape_sphere) ball = other
               low = min(ball, other)
               high = max(ball, other)
               self%major_second = base_shape == shape_cylinder .and. base_inside
            case default
               low = 0.0_wp
               high = 0.0_wp
            end select
         end associate
         self%curvature_a = 0.5_wp*low
         self%curvature_b = 0.5_wp*high
      end if
      if (present(search)) then
         if (search) then
            self%way = by_search
            self%base_first = .true.
            self%constant_curvatures = .false.
         end if
      end if
   end function new_surface_pair

   !> Signed distance of the surfaces [m].
   pure subroutine pair_gap(self, a, b, track, gap)
      class(surface_pair_type), intent(in) :: self
      !> Pose of body A.
      type(pose_type), intent(in) :: a
      !> Pose of body B.
      type(pose_type), intent(in) :: b
      !> Where a search begins, and what it found; `lost` when it failed.
      type(track_type), intent(inout) :: track
      !> Gap [m].
      real(wp), intent(out) :: gap
      real(wp) :: at_base(3)

      select case (self%way)
      case (by_centre)
         if (self%base_first) then
            at_base = seen(self%a, a, self%b%centre, b)
            call closest_point(self%a, at_base, track%first, track%normal, gap)
            gap = gap - self%b%radius
         else
            at_base = seen(self%b, b, self%a%centre, a)
            call closest_point(self%b, at_base, track%second, track%normal, gap)
            gap = gap - self%a%radius
         end if
         track%known = .true.
      case (by_support)
         if (self%base_first) then
            call support_of(self%a, self%b, a, b, track%first, track%normal, gap)
         else
            call support_of(self%b, self%a, b, a, track%second, track%normal, gap)
         end if
         track%known = .true.
      case (by_axes)
         call axes_gap(self, placing_of(self, a, b), track, gap)
         track%known = .true.
      case default
         call self%search%find(placing_of(self, a, b), track, gap)
      end select
   end subroutine pair_gap

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

      frame_a = matmul(a%rotation, self%a%frame)
      frame_b = matmul(b%rotation, self%b%frame)
      placing%rotation = matmul(transpose(frame_a), frame_b)
      placing%origin = seen(self%a, a, self%b%centre, b)
   end function placing_of

   !> Lowest point of an ellipsoid or a torus above a plane.
   pure subroutine support_of(body, plane, pose, pose_of_plane, x, normal, gap)
      !> The ellipsoid or torus.
      type(surface_type), intent(in) :: body
      type(surface_type), intent(in) :: plane
      !> Pose of the body of the former.
      type(pose_type), intent(in) :: pose
      !> Pose of the body of the plane.
      type(pose_type), intent(in) :: pose_of_plane
      !> Lowest point in the frame of the surface [m].
      real(wp), intent(out) :: x(3)
      !> Normal there.
      real(wp), intent(out) :: normal(3)
      !> Its height above the plane [m].
      real(wp), intent(out) :: gap
      real(wp) :: up(3), k(3), offset(3), across, height

      up = matmul(pose_of_plane%rotation, plane%frame(:, 3))
      offset = pose%position - pose_of_plane%position + matmul(pose%rotation, body%centre)
      height = dot_product(up, offset) - dot_product(plane%frame(:, 3), plane%centre)
      k = matmul(up, pose%rotation)
      k = matmul(k, body%frame)
      normal = -k
      if (body%shape == shape_torus) then
         across = sqrt(k(1)**2 + k(2)**2)
         x = -body%radius*k
         if (across > 0.0_wp) then
            x(1:2) = x(1:2) - body%major_radius/across*k(1:2)
         else
            x(1) = x(1) - body%major_radius
         end if
         gap = height - body%major_radius*across - body%radius
      else
         across = sqrt(sum((body%semi_axes*k)**2))
         x = -body%semi_axes**2*k/across
         gap = height - across
      end if
   end subroutine support_of

   !> Distance of two cylinders.
   pure subroutine axes_gap(self, placing, track, gap)
      class(surface_pair_type), intent(in) :: self
      !> Frame of B seen from A.
      type(placing_type), intent(in) :: placing
      !> Its closest points are set.
      type(track_type), intent(inout) :: track
      !> Gap [m].
      real(wp), intent(out) :: gap
      real(wp) :: n(3), sine, along_a, along_b, distance

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
         gap = distance - (self%a%radius + self%b%radius)
         track%normal = n
         track%first = self%a%radius*n
         track%first(3) = track%first(3) + along_a
         track%second = -self%b%radius*matmul(n, placing%rotation)
         track%second(3) = track%second(3) + along_b
      end associate
   end subroutine axes_gap

   !> Contact point of the pair.
   pure subroutine pair_locate(self, a, b, track, gap, at)
      class(surface_pair_type), intent(in) :: self
      !> Pose of body A.
      type(pose_type), intent(in) :: a
      !> Pose of body B.
      type(pose_type), intent(in) :: b
      !> As `gap` left it.
      type(track_type), intent(in) :: track
      !> Gap of these poses [m].
      real(wp), intent(in) :: gap
      type(contact_point_type), intent(out) :: at
      type(meeting_type) :: meeting
      real(wp) :: t(3, 2)

      at%gap = gap
      if (self%base_first) then
         call meet(self, self%a, self%b, a, b, track%first, track%second, track%normal, gap, &
            .not. self%constant_curvatures, meeting, at%point, t)
      else
         call meet(self, self%b, self%a, b, a, track%second, track%first, track%normal, gap, &
            .not. self%constant_curvatures, meeting, at%point, t)
      end if
      at%normal = meeting%normal
      if (self%constant_curvatures) then
         at%curvature_a = self%curvature_a
         at%curvature_b = self%curvature_b
         at%major = meeting%tangent(:, merge(2, 1, self%major_second))
      else
         call set_curvatures(meeting, at)
      end if
   end subroutine pair_locate

   !> The two surfaces at their closest points, seen from the base.
   pure subroutine meet(self, base, other, pose, pose_of_other, x, y, normal, gap, curved, &
      meeting, point, t_other)
      class(surface_pair_type), intent(in) :: self
      type(surface_type), intent(in) :: base
      type(surface_type), intent(in) :: other
      !> Pose of the body of the base.
      type(pose_type), intent(in) :: pose
      !> Pose of the other body.
      type(pose_type), intent(in) :: pose_of_other
      !> Closest point of the base in its frame [m].
      real(wp), intent(in) :: x(3)
      !> Closest point of the other surface in its frame [m]; not used for a sphere or a plane.
      real(wp), intent(in) :: y(3)
      !> Normal of the base, in its frame.
      real(wp), intent(in) :: normal(3)
      !> Gap [m].
      real(wp), intent(in) :: gap
      !> Whether the forms are wanted.
      logical, intent(in) :: curved
      !> The surfaces where they meet.
      type(meeting_type), intent(out) :: meeting
      !> Contact point, inertial frame [m].
      real(wp), intent(out) :: point(3)
      !> The tangents in the frame of the other surface, if `curved` and it is no ball or plane.
      real(wp), intent(out) :: t_other(3, 2)
      real(wp) :: frame(3, 3), t(3, 2), n(3), lead, form_base(3), form_other(3), frame_other(3, 3)

      frame = matmul(pose%rotation, base%frame)
      meeting%gap = gap
      meeting%share = self%share
      n = normal
      if (.not. self%base_first) n = -normal
      t(:, 1) = principal_at(base, x, normal)
      t(:, 2) = cross(n, t(:, 1))
      meeting%normal = matmul(frame, n)
      meeting%tangent = matmul(frame, t)
      lead = self%share*gap
      if (.not. self%base_first) lead = lead - gap
      point = pose%position + matmul(pose%rotation, base%centre)
      point = point + matmul(frame, x + lead*n)
      t_other = 0.0_wp
      meeting%first = 0.0_wp
      meeting%second = 0.0_wp
      if (.not. curved) return
      form_base = form_at(base, x, normal, t)
      if (other%shape == shape_sphere .and. .not. other%inside) then
         form_other = [1.0_wp, 0.0_wp, 1.0_wp]/other%radius
      else if (other%shape == shape_plane) then
         form_other = 0.0_wp
      else
         frame_other = matmul(pose_of_other%rotation, other%frame)
         t_other = matmul(transpose(frame_other), meeting%tangent)
         form_other = form_at(other, y, other_normal(), t_other)
      end if
      if (self%base_first) then
         meeting%first = form_base
         meeting%second = form_other
      else
         meeting%first = form_other
         meeting%second = form_base
      end if

   contains

      !> Normal of the other surface, out of its material, in its frame.
      pure function other_normal() result(m)
         real(wp) :: m(3)

         m = matmul(meeting%normal, frame_other)
         if (self%base_first) m = -m
      end function other_normal

   end subroutine meet

   !> Variation of the contact.
   pure subroutine pair_vary(self, a, b, track, at, variation)
      class(surface_pair_type), intent(in) :: self
      !> Pose of body A.
      type(pose_type), intent(in) :: a
      !> Pose of body B.
      type(pose_type), intent(in) :: b
      !> As `gap` left it.
      type(track_type), intent(in) :: track
      type(contact_point_type), intent(in) :: at
      type(contact_variation_type), intent(out) :: variation
      type(meeting_type) :: meeting
      real(wp) :: t_other(3, 2), point(3), cubic_base(4), cubic_other(4)

      if (self%base_first) then
         call meet(self, self%a, self%b, a, b, track%first, track%second, track%normal, at%gap, &
            .true., meeting, point, t_other)
         call cubics(self%a, self%b, b, track%first, track%second, cubic_base, cubic_other)
         call set_variation(meeting, cubic_base, cubic_other, variation)
      else
         call meet(self, self%b, self%a, b, a, track%second, track%first, track%normal, at%gap, &
            .true., meeting, point, t_other)
         call cubics(self%b, self%a, a, track%second, track%first, cubic_base, cubic_other)
         call set_variation(meeting, cubic_other, cubic_base, variation)
      end if
      if (self%constant_curvatures) then
         variation%curvature_a = 0.0_wp
         variation%curvature_b = 0.0_wp
      end if

   contains

      !> Derivatives of the forms of the two surfaces.
      pure subroutine cubics(base, other, pose_of_other, x, y, cubic_base, cubic_other)
         type(surface_type), intent(in) :: base
         type(surface_type), intent(in) :: other
         !> Pose of its body.
         type(pose_type), intent(in) :: pose_of_other
         !> Closest point of the base [m].
         real(wp), intent(in) :: x(3)
         !> Closest point of the other surface [m].
         real(wp), intent(in) :: y(3)
         real(wp), intent(out) :: cubic_base(4)
         !> That of the other surface.
         real(wp), intent(out) :: cubic_other(4)
         real(wp) :: t_base(3, 2), n_base(3), n_other(3)

         n_base = track%normal
         t_base(:, 1) = principal_at(base, x, n_base)
         t_base(:, 2) = cross(merge(n_base, -n_base, self%base_first), t_base(:, 1))
         cubic_base = cubic_at(base, x, n_base, t_base)
         cubic_other = 0.0_wp
         if (other%shape /= shape_ellipsoid .and. other%shape /= shape_torus) return
         n_other = matmul(meeting%normal, pose_of_other%rotation)
         n_other = matmul(n_other, other%frame)
         if (self%base_first) n_other = -n_other
         cubic_other = cubic_at(other, y, n_other, t_other)
      end subroutine cubics

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

      radius_a = smallest_curvature_radius(self%a)
      radius_b = smallest_curvature_radius(self%b)
      if (self%a%inside) then
         radius = radius_b*max(1.0_wp - radius_b/radius_of_hollow(self%a), least_part)
      else if (self%b%inside) then
         radius = radius_a*max(1.0_wp - radius_a/radius_of_hollow(self%b), least_part)
      else
         radius = min(radius_a, radius_b)
      end if
   end function pair_radius

   !> Radius of curvature of a hollow where it is narrowest [m].
   pure function radius_of_hollow(surface) result(radius)
      type(surface_type), intent(in) :: surface
      real(wp) :: radius

      radius = surface%radius
      if (surface%shape == shape_ellipsoid) radius = smallest_curvature_radius(surface)
   end function radius_of_hollow

end module contensou_contact_surface_pair
