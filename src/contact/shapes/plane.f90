!> Plane: the solid is the half-space below, in its frame z < 0.
module contensou_contact_shapes_plane
   use contensou_base_attitude, only : read_frame
   use contensou_base_diagnostics, only : diagnostics_type
   use contensou_base_kinds, only : wp
   use contensou_base_schema, only : key_list_type, kind_real
   use contensou_base_settings, only : group_settings_type
   use contensou_contact_shapes_shape, only : put_centre, shape_info_type, shape_type
   implicit none(type, external)
   private

   public :: plane_type

   type, extends(shape_type) :: plane_type
   contains
      procedure, nopass :: info
      procedure, nopass :: put_keys
      procedure :: read => read_plane
      procedure :: closest
      procedure :: normal
      procedure :: form
      procedure :: principal
      procedure :: constant_curvatures
   end type plane_type

contains

   pure function info()
      type(shape_info_type) :: info

      info = shape_info_type("plane", "planes", hint="centre (any point of it) and normal", &
         bounded=.false., on_plane="two planes never touch in a point")
   end function info

   subroutine put_keys(list)
      type(key_list_type), intent(inout) :: list

      call put_centre(list, "any point of a plane")
      call list%put("surface", "normal", kind_real, values=3, unit="1", doc="outward normal of " &
         // "|a plane| in the frame of the body, of any length; 0, 0, 1 if not given")
   end subroutine put_keys

   subroutine read_plane(self, group, frame, diagnostics)
      class(plane_type), intent(inout) :: self
      type(group_settings_type), intent(in) :: group
      real(wp), intent(inout) :: frame(3, 3)
      type(diagnostics_type), intent(inout) :: diagnostics

      call read_frame(group, "normal", frame, diagnostics)
   end subroutine read_plane

   pure subroutine closest(self, p, x, normal, distance)
      class(plane_type), intent(in) :: self
      real(wp), intent(in) :: p(3)
      real(wp), intent(out) :: x(3), normal(3), distance

      normal = [0.0_wp, 0.0_wp, 1.0_wp]
      distance = p(3)
      x = [p(1), p(2), 0.0_wp]
   end subroutine closest

   pure function normal(self, x)
      class(plane_type), intent(in) :: self
      real(wp), intent(in) :: x(3)
      real(wp) :: normal(3)

      normal = [0.0_wp, 0.0_wp, 1.0_wp]
   end function normal

   pure subroutine form(self, x, normal, t, values)
      class(plane_type), intent(in) :: self
      real(wp), intent(in) :: x(3), normal(3), t(3, 2)
      real(wp), intent(out) :: values(3)

      values = 0.0_wp
   end subroutine form

   pure subroutine principal(self, x, normal, tangent)
      class(plane_type), intent(in) :: self
      real(wp), intent(in) :: x(3), normal(3)
      real(wp), intent(out) :: tangent(3)

      tangent = [1.0_wp, 0.0_wp, 0.0_wp]
   end subroutine principal

   pure subroutine constant_curvatures(self, constant, k)
      class(plane_type), intent(in) :: self
      logical, intent(out) :: constant
      real(wp), intent(out) :: k(2)

      constant = .true.
      k = 0.0_wp
   end subroutine constant_curvatures

end module contensou_contact_shapes_plane
