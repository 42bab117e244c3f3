!> Pairs of surfaces that can touch, and why others cannot.
module contensou_contact_pairs
   use contensou_base_kinds, only : wp
   use contensou_base_rotations, only : to_inertial
   use contensou_base_text, only : to_text
   use contensou_base_vectors, only : cross
   use contensou_contact_catalogue, only : model_info_type
   use contensou_contact_geometry, only : contact_point_type, contact_variation_type, &
      geometry_type, pose_type, track_type
   use contensou_contact_surface, only : shape_cylinder, shape_ellipsoid, shape_plane, &
      shape_sphere, shape_torus, surface_text, surface_type
   use contensou_contact_surface_pair, only : new_surface_pair
   implicit none(type, external)
   private

   public :: geometry_models, new_geometry

   !> Ways to the closest points of a pair.
   character(len=*), parameter :: closed = "closed form", &
      searched = "search for the common normal of implicit surfaces"

   !> Sphere against plane, in either order.
   type, extends(geometry_type) :: sphere_plane_type
      !> Whether the sphere is surface A (then the normal is opposite to that of the plane).
      logical :: sphere_first
      !> Centre of the sphere in the frame of its body [m].
      real(wp) :: centre(3)
      !> Radius of the sphere [m].
      real(wp) :: radius
      !> Height of the plane above the centre of mass of its body along its normal [m].
      real(wp) :: height_of_plane
      !> Normal of the plane in the frame of its body.
      real(wp) :: normal(3)
      !> A tangent of the plane in the frame of its body: the spot is a circle and has no axis.
      real(wp) :: tangent(3)
   contains
      procedure :: gap => sphere_plane_gap
      procedure :: locate => sphere_plane_locate
      procedure :: vary => sphere_plane_vary
      procedure :: smallest_radius => sphere_plane_radius
   end type sphere_plane_type

contains

   !> Pairs of surfaces that can touch.
   pure function geometry_models() result(models)
      type(model_info_type), allocatable :: models(:)

      allocate(models(13))
      models(1) = pair("sphere, plane", &
         "sphere against plane, in either order; circular spot of relative radius R", closed)
      models(2) = pair("sphere, sphere", &
         "two spheres, one of them perhaps a socket; circular spot", closed)
      models(3) = pair("sphere, cylinder", "sphere on a cylinder or in a bore", closed)
      models(4) = pair("sphere, ellipsoid", "sphere on an ellipsoid or in the hollow of one", &
         "closed form but for one root")
      models(5) = pair("sphere, torus", &
         "sphere on a torus or in a raceway groove, the inside of one", closed)
      models(6) = pair("ellipsoid, plane", "ellipsoid against plane", closed)
      models(7) = pair("torus, plane", "torus against plane; lying flat it conforms", closed)
      models(8) = pair("cylinder, cylinder", &
         "two cylinders at an angle; parallel they conform", closed)
      models(9) = pair("ellipsoid, ellipsoid", &
         "two ellipsoids, one of them perhaps a hollow", searched)
      models(10) = pair("ellipsoid, cylinder", "ellipsoid on a cylinder or in a bore", searched)
      models(11) = pair("ellipsoid, torus", "ellipsoid on a torus or in a raceway groove", searched)
      models(12) = pair("torus, cylinder", "torus on a cylinder or in a bore", searched)
      models(13) = pair("torus, torus", "two tori, one of them perhaps a groove", searched)

   contains

      !> A row of the table.
      pure function pair(name, summary, way) result(row)
         !> Names of the shapes.
         character(len=*), intent(in) :: name
         !> What it is.
         character(len=*), intent(in) :: summary
         !> How the closest points are found.
         character(len=*), intent(in) :: way
         type(model_info_type) :: row

         row = model_info_type(name, summary, "surfaces", way)
      end function pair

   end function geometry_models

   !> Geometry of a pair of surfaces; unallocated when the pair cannot touch in a point.
   subroutine new_geometry(a, b, geometry, problem)
      type(surface_type), intent(in) :: a
      type(surface_type), intent(in) :: b
      !> The pair.
      class(geometry_type), allocatable, intent(out) :: geometry
      !> Why the pair is refused; unallocated when it is not.
      character(len=:), allocatable, intent(out), optional :: problem
      character(len=:), allocatable :: reason

      reason = refusal(a, b)
      if (reason /= "") then
         if (present(problem)) problem = reason
      else if (is_ball(a) .and. b%shape == shape_plane) then
         geometry = new_sphere_plane(a, b, sphere_first=.true.)
      else if (a%shape == shape_plane .and. is_ball(b)) then
         geometry = new_sphere_plane(b, a, sphere_first=.false.)
      else
         geometry = new_surface_pair(a, b)
      end if
   end subroutine new_geometry

   !> Whether a surface is the outside of a sphere.
   pure function is_ball(surface) result(ball)
      type(surface_type), intent(in) :: surface
      logical :: ball

      ball = surface%shape == shape_sphere .and. .not. surface%inside
   end function is_ball

   !> Why two surfaces cannot touch in a point; empty when they can.
   pure function refusal(a, b) result(text)
      type(surface_type), intent(in) :: a
      type(surface_type), intent(in) :: b
      character(len=:), allocatable :: text

      text = ""
      if (a%inside .and. b%inside) then
         text = surface_text(a) // " and " // surface_text(b) // " are both concave and never touch"
      else if (a%inside) then
         text = misfit(b, a)
      else if (b%inside) then
         text = misfit(a, b)
      else if (a%shape == shape_plane .and. b%shape == shape_plane) then
         text = "two planes never touch in a point"
      else if (min(a%shape, b%shape) == shape_plane .and. &
         max(a%shape, b%shape) == shape_cylinder) then
         text = "a cylinder on a plane touches along a line, not in a point"
      end if
   end function refusal

   !> Why a surface cannot touch a hollow in a point; empty when it can.
   !>
   !> It has to fit in, and its curvature has to be the stronger one at one place at least.
   pure function misfit(body, hollow) result(text)
      type(surface_type), intent(in) :: body
      type(surface_type), intent(in) :: hollow
      character(len=:), allocatable :: text
      real(wp) :: width, room, body_axes(3), hollow_axes(3)
      character(len=:), allocatable :: body_text, hollow_text

      text = ""
      select case (body%shape)
      case (shape_plane)
         text = "a plane does not touch " // surface_text(hollow) // " in a point"
         return
      case (shape_cylinder)
         text = "a cylinder, which has no ends, does not touch " // surface_text(hollow) // &
            " in a point"
         return
      case default
         body_axes = sorted(body%semi_axes)
         hollow_axes = sorted(hollow%semi_axes)
      end select

      ! What has to be smaller than what: of a ball in the hollow of an ellipsoid the radius than
      ! the smaller radius of curvature where the hollow is flattest, of other bodies their width.
      select case (body%shape)
      case (shape_sphere)
         width = body%radius
         body_text = "a sphere of radius " // to_text(width) // " m"
         room = hollow%radius
         if (hollow%shape == shape_ellipsoid) room = hollow_axes(2)**2/hollow_axes(1)
      case (shape_ellipsoid)
         width = body_axes(2)
         room = hollow%radius
         if (hollow%shape == shape_sphere) width = body_axes(3)
         if (hollow%shape == shape_ellipsoid) then
            width = body_axes(maxloc(body_axes/hollow_axes, dim=1))
            room = hollow_axes(maxloc(body_axes/hollow_axes, dim=1))
         end if
         body_text = "an ellipsoid with a semi-axis of " // to_text(width) // " m"
      case default
         width = body%major_radius + body%radius
         room = hollow%radius
         body_text = "a torus of outer radius " // to_text(width) // " m"
         if (hollow%shape == shape_torus) then
            width = body%radius
            body_text = "a torus with a tube of radius " // to_text(width) // " m"
         end if
         if (hollow%shape == shape_ellipsoid) room = hollow_axes(2)
      end select
      if (width < room) return
      select case (hollow%shape)
      case (shape_ellipsoid)
         hollow_text = "the hollow of " // to_text(room) // " m of an ellipsoid"
      case (shape_torus)
         hollow_text = "the groove of radius " // to_text(room) // " m of a torus"
      case (shape_cylinder)
         hollow_text = "the bore of radius " // to_text(room) // " m of a cylinder"
      case default
         hollow_text = "the hollow of radius " // to_text(room) // " m of a sphere"
      end select
      text = body_text // " does not fit into " // hollow_text // ": conforming contact"
   end function misfit

   !> Three numbers in ascending order.
   pure function sorted(x) result(y)
      !> The numbers.
      real(wp), intent(in) :: x(3)
      real(wp) :: y(3)

      y(1) = minval(x)
      y(3) = maxval(x)
      y(2) = max(min(x(1), x(2)), min(max(x(1), x(2)), x(3)))
   end function sorted

   !> Sphere against plane.
   pure function new_sphere_plane(sphere, plane, sphere_first) result(self)
      type(surface_type), intent(in) :: sphere
      type(surface_type), intent(in) :: plane
      !> Whether the sphere is surface A.
      logical, intent(in) :: sphere_first
      type(sphere_plane_type) :: self

      self%sphere_first = sphere_first
      self%centre = sphere%centre
      self%radius = sphere%radius
      self%normal = plane%frame(:, 3)
      self%height_of_plane = dot_product(self%normal, plane%centre)
      self%tangent = plane%frame(:, 1)
   end function new_sphere_plane

   !> Signed distance of sphere and plane [m].
   pure subroutine sphere_plane_gap(self, a, b, track, gap)
      !> The pair.
      class(sphere_plane_type), intent(in) :: self
      !> Pose of body A.
      type(pose_type), intent(in) :: a
      !> Pose of body B.
      type(pose_type), intent(in) :: b
      !> Receives what `locate` needs of these poses, in the inertial frame: `normal` of the plane
      !> and, as `first`, the centre of the sphere from the centre of mass of its body.
      type(track_type), intent(inout) :: track
      !> Gap [m].
      real(wp), intent(out) :: gap

      track%known = .true.
      if (self%sphere_first) then
         call set_height(self, a, b, track, gap)
      else
         call set_height(self, b, a, track, gap)
      end if
      gap = gap - self%radius
   end subroutine sphere_plane_gap

   !> Height of the centre of the sphere above the plane [m].
   pure subroutine set_height(self, sphere, plane, track, height)
      !> The pair.
      type(sphere_plane_type), intent(in) :: self
      !> Pose of the body of the sphere.
      type(pose_type), intent(in) :: sphere
      !> Pose of the body of the plane.
      type(pose_type), intent(in) :: plane
      !> Receives `normal` and `first`.
      type(track_type), intent(inout) :: track
      !> The height [m].
      real(wp), intent(out) :: height
      real(wp) :: offset(3)

      track%first = to_inertial(sphere%rotation, self%centre)
      if (plane%ground) then
         track%normal = self%normal
         offset = sphere%position + track%first
      else
         track%normal = to_inertial(plane%rotation, self%normal)
         offset = sphere%position - plane%position + track%first
      end if
      height = dot_product(track%normal, offset) - self%height_of_plane
   end subroutine set_height

   !> Contact point of sphere and plane.
   pure subroutine sphere_plane_locate(self, a, b, track, gap, at)
      !> The pair.
      class(sphere_plane_type), intent(in) :: self
      !> Pose of body A.
      type(pose_type), intent(in) :: a
      !> Pose of body B.
      type(pose_type), intent(in) :: b
      !> As `gap` left it.
      type(track_type), intent(in) :: track
      !> Gap of these poses [m].
      real(wp), intent(in) :: gap
      type(contact_point_type), intent(out) :: at

      at%gap = gap
      if (self%sphere_first) then
         at%point = a%position + track%first - self%radius*track%normal
         at%normal = -track%normal
         at%major = tangent_of(b)
      else
         at%point = b%position + track%first - self%radius*track%normal
         at%normal = track%normal
         at%major = tangent_of(a)
      end if
      at%curvature_a = 0.5_wp/self%radius
      at%curvature_b = at%curvature_a

   contains

      !> Tangent of the plane in the inertial frame.
      pure function tangent_of(plane) result(tangent)
         !> Pose of its body.
         type(pose_type), intent(in) :: plane
         real(wp) :: tangent(3)

         tangent = self%tangent
         if (.not. plane%ground) tangent = to_inertial(plane%rotation, self%tangent)
      end function tangent_of

   end subroutine sphere_plane_locate

   !> Variation of the contact of sphere and plane.
   pure subroutine sphere_plane_vary(self, a, b, track, at, variation)
      !> The pair.
      class(sphere_plane_type), intent(in) :: self
      !> Pose of body A.
      type(pose_type), intent(in) :: a
      !> Pose of body B.
      type(pose_type), intent(in) :: b
      !> Not needed.
      type(track_type), intent(in) :: track
      type(contact_point_type), intent(in) :: at
      type(contact_variation_type), intent(out) :: variation
      real(wp) :: lever(3)
      integer :: i

      variation = contact_variation_type(0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp)
      if (self%sphere_first) then
         ! The plane turns about a sphere at rest.
         do i = 1, 3
            variation%normal(:, 3 + i) = cross(unit(i), at%normal)
         end do
         variation%point(:, 4:6) = self%radius*variation%normal(:, 4:6)
         variation%turn(4:6) = at%normal
      else
         ! The contact point moves as the centre of the sphere does.
         lever = self%radius*at%normal
         do i = 1, 3
            variation%point(i, i) = 1.0_wp
            variation%point(:, 3 + i) = cross(unit(i), lever)
         end do
      end if

   contains

      !> Unit vector along an axis.
      pure function unit(axis) result(e)
         !> Number of the axis.
         integer, intent(in) :: axis
         real(wp) :: e(3)

         e = 0.0_wp
         e(axis) = 1.0_wp
      end function unit

   end subroutine sphere_plane_vary

   !> Radius of the sphere [m].
   pure function sphere_plane_radius(self) result(radius)
      !> The pair.
      class(sphere_plane_type), intent(in) :: self
      real(wp) :: radius

      radius = self%radius
   end function sphere_plane_radius

end module contensou_contact_pairs
