!> Geometry part of a contact: where two surfaces are closest, and how they curve there.
!>
!> Conventions: the normal points from A into B; the contact point is where the undeformed
!> surfaces are closest (on the curved one); the gap is negative when they overlap. A new pair of
!> surfaces is a new extension of `geometry_type` and a line in `new_geometry`.
module contensou_contact_geometry
   use contensou_base_kinds, only : wp
   use contensou_base_vectors, only : any_perpendicular
   use contensou_contact_catalogue, only : model_info_type
   implicit none(type, external)
   private

   public :: pose_type, surface_type, contact_point_type, geometry_type
   public :: shape_sphere, shape_plane, shape_names, geometry_models, new_geometry

   !> Position and motion of a body, inertial frame.
   type :: pose_type
      !> Centre of mass [m].
      real(wp) :: position(3) = 0.0_wp
      !> Rotation matrix, body to inertial.
      real(wp) :: rotation(3, 3) = reshape([1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, &
         0.0_wp, 0.0_wp, 1.0_wp], [3, 3])
      !> Velocity of the centre of mass [m/s].
      real(wp) :: velocity(3) = 0.0_wp
      !> Angular velocity [rad/s].
      real(wp) :: spin(3) = 0.0_wp
   end type pose_type

   !> Shapes of a surface.
   integer, parameter :: shape_sphere = 1, shape_plane = 2

   !> Their names in a scene, in the order of the codes.
   character(len=*), parameter :: shape_names(*) = [character(len=8) :: "sphere", "plane"]

   !> A surface in the frame of its body.
   type :: surface_type
      !> Shape, one of the `shape_*` codes.
      integer :: shape = shape_sphere
      !> Centre of a sphere, a point of a plane [m].
      real(wp) :: centre(3) = 0.0_wp
      !> Radius of a sphere [m].
      real(wp) :: radius = 0.0_wp
      !> Outward normal of a plane, unit length.
      real(wp) :: normal(3) = [0.0_wp, 0.0_wp, 1.0_wp]
   end type surface_type

   !> Geometry of a contact at an instant, inertial frame.
   type :: contact_point_type
      !> Signed distance of the undeformed surfaces, negative for overlap [m].
      real(wp) :: gap
      !> Contact point [m].
      real(wp) :: point(3)
      !> Unit normal from A into B.
      real(wp) :: normal(3)
      !> Unit tangent along the major axis of the spot.
      real(wp) :: major(3)
      !> Half of the smaller relative principal curvature [1/m].
      real(wp) :: curvature_a
      !> Half of the larger relative principal curvature [1/m].
      real(wp) :: curvature_b
   end type contact_point_type

   !> A pair of surfaces.
   type, abstract :: geometry_type
   contains
      !> Gap alone.
      procedure(gap_interface), deferred :: gap
      !> All of the contact point.
      procedure(locate_interface), deferred :: locate
      !> Smallest radius of curvature of the pair [m], the scale of admissible overlaps.
      procedure(radius_interface), deferred :: smallest_radius
   end type geometry_type

   abstract interface
      !> Signed distance of the surfaces [m].
      pure function gap_interface(self, a, b) result(gap)
         import :: geometry_type, pose_type, wp
         implicit none(type, external)
         !> The pair.
         class(geometry_type), intent(in) :: self
         !> Pose of body A.
         type(pose_type), intent(in) :: a
         !> Pose of body B.
         type(pose_type), intent(in) :: b
         real(wp) :: gap
      end function gap_interface

      !> Contact point, normal, curvatures.
      pure subroutine locate_interface(self, a, b, gap, at)
         import :: geometry_type, pose_type, contact_point_type, wp
         implicit none(type, external)
         !> The pair.
         class(geometry_type), intent(in) :: self
         !> Pose of body A.
         type(pose_type), intent(in) :: a
         !> Pose of body B.
         type(pose_type), intent(in) :: b
         !> Gap of these poses, from `gap` [m].
         real(wp), intent(in) :: gap
         !> The contact.
         type(contact_point_type), intent(out) :: at
      end subroutine locate_interface

      !> Smallest radius of curvature [m].
      pure function radius_interface(self) result(radius)
         import :: geometry_type, wp
         implicit none(type, external)
         !> The pair.
         class(geometry_type), intent(in) :: self
         real(wp) :: radius
      end function radius_interface
   end interface

   !> Sphere against plane, in either order.
   type, extends(geometry_type) :: sphere_plane_type
      !> Whether the sphere is surface A (then the normal is opposite to that of the plane).
      logical :: sphere_first
      !> Centre of the sphere in the frame of its body [m].
      real(wp) :: centre(3)
      !> Radius of the sphere [m].
      real(wp) :: radius
      !> Point of the plane in the frame of its body [m].
      real(wp) :: origin(3)
      !> Normal of the plane in the frame of its body.
      real(wp) :: normal(3)
      !> A tangent of the plane in the frame of its body: the spot is a circle and has no axis.
      real(wp) :: tangent(3)
   contains
      procedure :: gap => sphere_plane_gap
      procedure :: locate => sphere_plane_locate
      procedure :: smallest_radius => sphere_plane_radius
   end type sphere_plane_type

contains

   !> Pairs of surfaces that can touch.
   pure function geometry_models() result(models)
      type(model_info_type), allocatable :: models(:)

      allocate(models(1))
      models(1) = model_info_type("sphere, plane", &
         "sphere against plane, in either order; circular spot of relative radius R", &
         "surfaces", "closed form")
   end function geometry_models

   !> Geometry of a pair of surfaces; unallocated when the pair is not supported.
   subroutine new_geometry(a, b, geometry)
      !> Surface A.
      type(surface_type), intent(in) :: a
      !> Surface B.
      type(surface_type), intent(in) :: b
      !> The pair.
      class(geometry_type), allocatable, intent(out) :: geometry

      if (a%shape == shape_sphere .and. b%shape == shape_plane) then
         geometry = new_sphere_plane(a, b, sphere_first=.true.)
      else if (a%shape == shape_plane .and. b%shape == shape_sphere) then
         geometry = new_sphere_plane(b, a, sphere_first=.false.)
      end if
   end subroutine new_geometry

   !> Sphere against plane.
   pure function new_sphere_plane(sphere, plane, sphere_first) result(self)
      !> The sphere.
      type(surface_type), intent(in) :: sphere
      !> The plane.
      type(surface_type), intent(in) :: plane
      !> Whether the sphere is surface A.
      logical, intent(in) :: sphere_first
      type(sphere_plane_type) :: self

      self%sphere_first = sphere_first
      self%centre = sphere%centre
      self%radius = sphere%radius
      self%origin = plane%centre
      self%normal = plane%normal/norm2(plane%normal)
      self%tangent = any_perpendicular(self%normal)
   end function new_sphere_plane

   !> Signed distance of sphere and plane [m].
   pure function sphere_plane_gap(self, a, b) result(gap)
      !> The pair.
      class(sphere_plane_type), intent(in) :: self
      !> Pose of body A.
      type(pose_type), intent(in) :: a
      !> Pose of body B.
      type(pose_type), intent(in) :: b
      real(wp) :: gap

      if (self%sphere_first) then
         gap = height(self, a, b) - self%radius
      else
         gap = height(self, b, a) - self%radius
      end if
   end function sphere_plane_gap

   !> Height of the centre of the sphere above the plane [m].
   pure function height(self, sphere, plane) result(h)
      !> The pair.
      type(sphere_plane_type), intent(in) :: self
      !> Pose of the body of the sphere.
      type(pose_type), intent(in) :: sphere
      !> Pose of the body of the plane.
      type(pose_type), intent(in) :: plane
      real(wp) :: h
      real(wp) :: offset(3)

      offset = sphere%position - plane%position + matmul(sphere%rotation, self%centre)
      h = dot_product(matmul(plane%rotation, self%normal), offset) &
         - dot_product(self%normal, self%origin)
   end function height

   !> Contact point of sphere and plane.
   pure subroutine sphere_plane_locate(self, a, b, gap, at)
      !> The pair.
      class(sphere_plane_type), intent(in) :: self
      !> Pose of body A.
      type(pose_type), intent(in) :: a
      !> Pose of body B.
      type(pose_type), intent(in) :: b
      !> Gap of these poses [m].
      real(wp), intent(in) :: gap
      !> The contact.
      type(contact_point_type), intent(out) :: at

      at%gap = gap
      if (self%sphere_first) then
         at%normal = matmul(b%rotation, self%normal)
         at%major = matmul(b%rotation, self%tangent)
         at%point = a%position + matmul(a%rotation, self%centre) - self%radius*at%normal
         at%normal = -at%normal
      else
         at%normal = matmul(a%rotation, self%normal)
         at%major = matmul(a%rotation, self%tangent)
         at%point = b%position + matmul(b%rotation, self%centre) - self%radius*at%normal
      end if
      at%curvature_a = 0.5_wp/self%radius
      at%curvature_b = at%curvature_a
   end subroutine sphere_plane_locate

   !> Radius of the sphere [m].
   pure function sphere_plane_radius(self) result(radius)
      !> The pair.
      class(sphere_plane_type), intent(in) :: self
      real(wp) :: radius

      radius = self%radius
   end function sphere_plane_radius

end module contensou_contact_geometry
