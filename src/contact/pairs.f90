!> Pairs of surfaces that can touch.
module contensou_contact_pairs
   use contensou_base_kinds, only : wp
   use contensou_base_vectors, only : cross
   use contensou_contact_catalogue, only : model_info_type
   use contensou_contact_geometry, only : contact_point_type, contact_variation_type, &
      geometry_type, pose_type, track_type
   use contensou_contact_surface, only : shape_plane, shape_sphere, surface_type
   implicit none(type, external)
   private

   public :: geometry_models, new_geometry

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
      procedure :: vary => sphere_plane_vary
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
      self%normal = plane%frame(:, 3)
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
      !> Not needed.
      type(track_type), intent(inout) :: track
      !> Gap [m].
      real(wp), intent(out) :: gap

      track%known = .true.
      if (self%sphere_first) then
         gap = height(self, a, b) - self%radius
      else
         gap = height(self, b, a) - self%radius
      end if
   end subroutine sphere_plane_gap

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
   pure subroutine sphere_plane_locate(self, a, b, track, gap, at)
      !> The pair.
      class(sphere_plane_type), intent(in) :: self
      !> Pose of body A.
      type(pose_type), intent(in) :: a
      !> Pose of body B.
      type(pose_type), intent(in) :: b
      !> Not needed.
      type(track_type), intent(in) :: track
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
      !> The contact.
      type(contact_point_type), intent(in) :: at
      !> Its variation.
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
