!> Surfaces of bodies: their shapes, and where they sit on their body.
!>
!> A surface is the boundary of a solid of the named shape. With `inside` the material is outside
!> of that solid: a socket, a bore, a groove, touched from within.
module contensou_contact_surface
   use contensou_base_kinds, only : wp
   implicit none(type, external)
   private

   public :: surface_type, shape_names, shape_has, shape_needs, shape_keys, shape_hints
   public :: surface_text
   public :: shape_sphere, shape_plane, shape_cylinder, shape_ellipsoid, shape_torus
   public :: side_names, smallest_curvature_radius, extent

   !> Shapes of a surface.
   integer, parameter :: shape_sphere = 1, shape_plane = 2, shape_cylinder = 3, &
      shape_ellipsoid = 4, shape_torus = 5

   !> Their names in a scene, in the order of the codes.
   character(len=*), parameter :: shape_names(*) = [character(len=9) :: "sphere", "plane", &
      "cylinder", "ellipsoid", "torus"]

   !> Keys of a scene that a shape must have, in the order of the codes, each between blanks.
   character(len=*), parameter :: needed_keys(*) = [character(len=30) :: " radius ", " ", &
      " radius ", " semi_axes ", " major_radius minor_radius "]

   !> Keys of a scene that a shape may have besides.
   character(len=*), parameter :: further_keys(*) = [character(len=30) :: " side ", " normal ", &
      " direction side ", " axis angle quaternion side ", " direction side "]

   !> Keys of a scene that not all shapes have.
   character(len=*), parameter :: shape_keys(*) = [character(len=12) :: "radius", "normal", &
      "direction", "semi_axes", "axis", "angle", "quaternion", "major_radius", "minor_radius", &
      "side"]

   !> What describes a shape, in the order of the codes.
   character(len=*), parameter :: shape_hints(*) = [character(len=72) :: "centre and radius", &
      "centre (any point of it) and normal", &
      "centre (any point of its axis), radius and direction", &
      "centre, semi_axes, and axis and angle or quaternion", &
      "centre, major_radius, minor_radius and direction"]

   !> Sides of a surface that can be touched.
   character(len=*), parameter :: side_names(*) = [character(len=7) :: "outside", "inside"]

   !> A surface in the frame of its body.
   type :: surface_type
      !> Shape, one of the `shape_*` codes.
      integer :: shape = shape_sphere
      !> Whether it is touched from the inside of its shape.
      logical :: inside = .false.
      !> Centre, or a point of a plane, or of the axis of a cylinder [m].
      real(wp) :: centre(3) = 0.0_wp
      !> Rotation matrix, frame of the surface to frame of the body; its third column is the outward
      !> normal of a plane and the axis of what has an axis of revolution.
      real(wp) :: frame(3, 3) = reshape([1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, &
         0.0_wp, 0.0_wp, 1.0_wp], [3, 3])
      !> Radius of a sphere, of a cylinder, of the tube of a torus [m].
      real(wp) :: radius = 0.0_wp
      !> Radius of the centre circle of a torus [m], larger than that of the tube.
      real(wp) :: major_radius = 0.0_wp
      !> Semi-axes of an ellipsoid along the axes of its frame [m].
      real(wp) :: semi_axes(3) = 0.0_wp
   end type surface_type

contains

   !> Whether a shape has a key.
   pure function shape_has(shape, key) result(has)
      !> Shape code.
      integer, intent(in) :: shape
      !> Name of the key.
      character(len=*), intent(in) :: key
      logical :: has

      has = shape_needs(shape, key) .or. index(further_keys(shape), " " // key // " ") > 0
   end function shape_has

   !> Whether a shape cannot do without a key.
   pure function shape_needs(shape, key) result(needs)
      !> Shape code.
      integer, intent(in) :: shape
      !> Name of the key.
      character(len=*), intent(in) :: key
      logical :: needs

      needs = index(needed_keys(shape), " " // key // " ") > 0
   end function shape_needs

   !> A surface in words, as "a sphere" or "the inside of a torus".
   pure function surface_text(surface) result(text)
      type(surface_type), intent(in) :: surface
      character(len=:), allocatable :: text

      text = "a " // trim(shape_names(surface%shape))
      if (surface%shape == shape_ellipsoid) text = "an " // trim(shape_names(surface%shape))
      if (surface%inside) text = "the inside of " // text
   end function surface_text

   !> Smallest radius of curvature of a surface, over all of it and without regard to sign [m];
   !> the largest number for a plane.
   pure function smallest_curvature_radius(surface) result(radius)
      type(surface_type), intent(in) :: surface
      real(wp) :: radius

      select case (surface%shape)
      case (shape_plane)
         radius = huge(radius)
      case (shape_ellipsoid)
         radius = minval(surface%semi_axes)**2/maxval(surface%semi_axes)
      case (shape_torus)
         radius = min(surface%radius, surface%major_radius - surface%radius)
      case default
         radius = surface%radius
      end select
   end function smallest_curvature_radius

   !> Length of the order of a surface [m]; zero for a plane.
   pure function extent(surface) result(length)
      type(surface_type), intent(in) :: surface
      real(wp) :: length

      length = max(surface%radius + surface%major_radius, maxval(surface%semi_axes))
   end function extent

end module contensou_contact_surface
