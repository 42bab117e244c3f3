!> Cylinder without ends about the third axis of its frame.
module contensou_contact_shapes_cylinder
   use contensou_base_attitude, only : read_frame
   use contensou_base_diagnostics, only : diagnostics_type
   use contensou_base_kinds, only : pi, wp
   use contensou_base_schema, only : key_list_type
   use contensou_base_settings, only : group_settings_type
   use contensou_contact_shapes_shape, only : solid_type, half_tangents, put_centre, &
      put_direction, put_radius, shape_info_type, shape_type, turning_form
   implicit none(type, external)
   private

   public :: cylinder_type

   type, extends(shape_type) :: cylinder_type
      real(wp) :: radius = 0.0_wp
   contains
      procedure, nopass :: info
      procedure, nopass :: put_keys
      procedure :: read => read_cylinder
      procedure :: closest
      procedure :: normal
      procedure :: form
      procedure :: principal
      procedure :: smallest_radius => radius_of
      procedure :: extent => radius_of
      procedure :: constant_curvatures
      procedure :: spine
      procedure :: room
      procedure :: solid
   end type cylinder_type

contains

   pure function info()
      type(shape_info_type) :: info

      info = shape_info_type("cylinder", "cylinders", "bore", "bore of radius", &
         "centre (any point of its axis), radius and direction", ", which has no ends,", &
         bounded=.false., rank=2, swept=.true., &
         on_plane="a cylinder on a plane touches along a line, not in a point")
   end function info

   subroutine put_keys(list)
      type(key_list_type), intent(inout) :: list

      call put_centre(list, "any point of the axis of a cylinder (which has no ends)")
      call put_radius(list, "a cylinder")
      call put_direction(list, "a cylinder")
   end subroutine put_keys

   subroutine read_cylinder(self, group, frame, diagnostics)
      class(cylinder_type), intent(inout) :: self
      type(group_settings_type), intent(in) :: group
      real(wp), intent(inout) :: frame(3, 3)
      type(diagnostics_type), intent(inout) :: diagnostics

      self%radius = group%number("radius")
      call read_frame(group, "direction", frame, diagnostics)
   end subroutine read_cylinder

   pure subroutine closest(self, p, x, normal, distance)
      class(cylinder_type), intent(in) :: self
      real(wp), intent(in) :: p(3)
      real(wp), intent(out) :: x(3), normal(3), distance
      real(wp) :: length

      length = sqrt(p(1)**2 + p(2)**2)
      normal = [1.0_wp, 0.0_wp, 0.0_wp]
      if (length > 0.0_wp) normal(1:2) = p(1:2)/length
      distance = length - self%radius
      x = self%radius*normal
      x(3) = p(3)
   end subroutine closest

   pure function normal(self, x)
      class(cylinder_type), intent(in) :: self
      real(wp), intent(in) :: x(3)
      real(wp) :: normal(3)

      normal = [x(1), x(2), 0.0_wp]
      normal = normal/sqrt(normal(1)**2 + normal(2)**2 + normal(3)**2)
   end function normal

   pure subroutine form(self, x, normal, t, values)
      class(cylinder_type), intent(in) :: self
      real(wp), intent(in) :: x(3), normal(3), t(3, 2)
      real(wp), intent(out) :: values(3)

      values = turning_form(normal(1)*t(2, :) - normal(2)*t(1, :))/self%radius
   end subroutine form

   pure subroutine principal(self, x, normal, tangent)
      class(cylinder_type), intent(in) :: self
      real(wp), intent(in) :: x(3), normal(3)
      real(wp), intent(out) :: tangent(3)

      tangent = [0.0_wp, 0.0_wp, 1.0_wp]
   end subroutine principal

   pure function radius_of(self) result(length)
      class(cylinder_type), intent(in) :: self
      real(wp) :: length

      length = self%radius
   end function radius_of

   pure subroutine constant_curvatures(self, constant, k)
      class(cylinder_type), intent(in) :: self
      logical, intent(out) :: constant
      real(wp), intent(out) :: k(2)

      constant = .true.
      k = [0.0_wp, 1.0_wp/self%radius]
   end subroutine constant_curvatures

   pure subroutine spine(self, u, sample, reach, centre, radius)
      class(cylinder_type), intent(in) :: self
      real(wp), intent(in) :: u
      integer, intent(in) :: sample
      real(wp), intent(in) :: reach
      real(wp), intent(out) :: centre(3), radius

      if (sample > 0) then
         centre = [0.0_wp, 0.0_wp, reach*half_tangents(sample)]
      else
         ! Short of the end of the axis, which lies at infinity.
         centre = [0.0_wp, 0.0_wp, reach*tan(0.5_wp*min(max(u, -3.14_wp), 3.14_wp))]
      end if
      radius = self%radius
   end subroutine spine

   pure function room(self)
      class(cylinder_type), intent(in) :: self
      real(wp) :: room(3)

      room = [self%radius, self%radius, huge(room)]
   end function room

   pure subroutine solid(self, part, length, body)
      class(cylinder_type), intent(in) :: self
      integer, intent(in) :: part
      real(wp), intent(in) :: length
      type(solid_type), intent(out) :: body

      body%cut = .true.
      body%volume = pi*self%radius**2*length
      body%gyration = 0.25_wp*self%radius**2 + length**2/12.0_wp
      body%gyration(3) = 0.5_wp*self%radius**2
   end subroutine solid

end module contensou_contact_shapes_cylinder
