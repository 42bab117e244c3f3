!> Sphere against plane in closed form, the most frequent pair: without the general geometry of two
!> surfaces.
module contensou_contact_sphere_plane
   use contensou_base_kinds, only : wp
   use contensou_base_rotations, only : to_inertial
   use contensou_base_vectors, only : cross
   use contensou_contact_geometry, only : contact_point_type, contact_variation_type, &
      geometry_type, pose_type, track_type
   use contensou_contact_surface, only : surface_type
   implicit none(type, external)
   private

   public :: new_sphere_plane

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
      procedure :: mean_form => sphere_plane_mean_form
   end type sphere_plane_type

contains

   !> Sphere against plane.
   subroutine new_sphere_plane(a, b, sphere_first, geometry)
      type(surface_type), intent(in) :: a
      type(surface_type), intent(in) :: b
      !> Whether the sphere is surface A.
      logical, intent(in) :: sphere_first
      class(geometry_type), allocatable, intent(out) :: geometry
      type(sphere_plane_type), allocatable :: self

      allocate(self)
      self%sphere_first = sphere_first
      if (sphere_first) then
         call set(a, b)
      else
         call set(b, a)
      end if
      call move_alloc(self, geometry)

   contains

      !> Take over what is needed of the two.
      subroutine set(sphere, plane)
         type(surface_type), intent(in) :: sphere
         type(surface_type), intent(in) :: plane

         self%centre = sphere%centre
         self%radius = sphere%shape%smallest_radius()
         self%normal = plane%frame(:, 3)
         self%height_of_plane = dot_product(self%normal, plane%centre)
         self%tangent = plane%frame(:, 1)
      end subroutine set

   end subroutine new_sphere_plane

   !> Signed distance of sphere and plane [m].
   pure subroutine sphere_plane_gap(self, a, b, track, gap)
      class(sphere_plane_type), intent(in) :: self
      type(pose_type), intent(in) :: a, b
      !> Receives what `locate` needs of these poses, in the inertial frame: `normal` of the plane
      !> and, as `first`, the centre of the sphere from the centre of mass of its body.
      type(track_type), intent(inout) :: track
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
      class(sphere_plane_type), intent(in) :: self
      type(pose_type), intent(in) :: a, b
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
      class(sphere_plane_type), intent(in) :: self
      type(pose_type), intent(in) :: a, b
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
         integer, intent(in) :: axis
         real(wp) :: e(3)

         e = 0.0_wp
         e(axis) = 1.0_wp
      end function unit

   end subroutine sphere_plane_vary

   !> Radius of the sphere [m].
   pure function sphere_plane_radius(self) result(radius)
      class(sphere_plane_type), intent(in) :: self
      real(wp) :: radius

      radius = self%radius
   end function sphere_plane_radius

   !> Mean curvature of sphere and plane.
   pure subroutine sphere_plane_mean_form(self, a, b, track, at, form)
      class(sphere_plane_type), intent(in) :: self
      type(pose_type), intent(in) :: a, b
      type(track_type), intent(in) :: track
      type(contact_point_type), intent(in) :: at
      real(wp), intent(out) :: form(3)

      form = merge(-0.5_wp, 0.5_wp, self%sphere_first)/self%radius*[1.0_wp, 0.0_wp, 1.0_wp]
   end subroutine sphere_plane_mean_form

end module contensou_contact_sphere_plane
