!> Surfaces of bodies: their shapes, and where they sit on their body.
module contensou_contact_surface
   use contensou_base_kinds, only : wp
   implicit none(type, external)
   private

   public :: surface_type, shape_sphere, shape_plane, shape_names

   !> Shapes of a surface.
   integer, parameter :: shape_sphere = 1, shape_plane = 2

   !> Their names in a scene, in the order of the codes.
   character(len=*), parameter :: shape_names(*) = [character(len=8) :: "sphere", "plane"]

   !> A surface in the frame of its body.
   type :: surface_type
      !> Shape, one of the `shape_*` codes.
      integer :: shape = shape_sphere
      !> Centre, or a point of a plane [m].
      real(wp) :: centre(3) = 0.0_wp
      !> Rotation matrix, frame of the surface to frame of the body; its third column is the outward
      !> normal of a plane and the axis of what has an axis of revolution.
      real(wp) :: frame(3, 3) = reshape([1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, &
         0.0_wp, 0.0_wp, 1.0_wp], [3, 3])
      !> Radius of a sphere [m].
      real(wp) :: radius = 0.0_wp
   end type surface_type

end module contensou_contact_surface
