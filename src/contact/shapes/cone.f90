!> Cone about the third axis of its frame, from its apex at the origin into the solid; it has no
!> end. Its inside is a funnel.
!>
!> The apex has neither a normal nor curvatures: `normal` is zero there and `form` so large that
!> a contact at the apex is told from all others.
module contensou_contact_shapes_cone
   use contensou_base_attitude, only : read_frame
   use contensou_base_diagnostics, only : diagnostics_type
   use contensou_base_kinds, only : pi, wp
   use contensou_base_schema, only : key_list_type, kind_real
   use contensou_base_settings, only : group_settings_type
   use contensou_base_text, only : quote
   use contensou_base_vectors, only : any_tangent
   use contensou_contact_shapes_shape, only : solid_type, apex_curvature, put_centre, &
      put_direction, shape_info_type, shape_type, turning_cubic, turning_form
   implicit none(type, external)
   private

   public :: cone_type

   type, extends(shape_type) :: cone_type
      !> Angle between axis and surface [rad], below pi/2.
      real(wp) :: half_angle = 0.25_wp*pi
   contains
      procedure, nopass :: info
      procedure, nopass :: put_keys
      procedure :: read => read_cone
      procedure :: closest
      procedure :: normal
      procedure :: form
      procedure :: cubic
      procedure :: principal
      procedure :: apex
      procedure :: solid
   end type cone_type

contains

   pure function info()
      type(shape_info_type) :: info

      info = shape_info_type("cone", "cones", "funnel", "funnel of radius", &
         "centre (its apex), half_angle and direction", ", which has no end,", bounded=.false., &
         widens=.true., on_plane="a cone on a plane touches along a line or at its apex, not in " &
         // "a point with a curvature")
   end function info

   subroutine put_keys(list)
      type(key_list_type), intent(inout) :: list

      call put_centre(list, "the apex of a cone (which has no end)")
      call list%put("surface", "half_angle", kind_real, unit="rad", above=0.0_wp, &
         mandatory=.true., doc="angle between the axis of |a cone| and its surface, below pi/2")
      call put_direction(list, "a cone (from its apex into it)")
   end subroutine put_keys

   subroutine read_cone(self, group, frame, diagnostics)
      class(cone_type), intent(inout) :: self
      type(group_settings_type), intent(in) :: group
      real(wp), intent(inout) :: frame(3, 3)
      type(diagnostics_type), intent(inout) :: diagnostics

      self%half_angle = group%number("half_angle")
      call read_frame(group, "direction", frame, diagnostics)
      if (group%is_set("half_angle") .and. self%half_angle >= 0.5_wp*pi) call diagnostics%add( &
         group%place("half_angle", 1), "the cone " // quote(group%label()) // " is too wide", &
         "half_angle < pi/2, 1.5707963 rad")
   end subroutine read_cone

   pure subroutine closest(self, p, x, normal, distance)
      class(cone_type), intent(in) :: self
      real(wp), intent(in) :: p(3)
      real(wp), intent(out) :: x(3), normal(3), distance
      real(wp) :: rho, around(2), s, c, along

      rho = sqrt(p(1)**2 + p(2)**2)
      around = [1.0_wp, 0.0_wp]
      if (rho > 0.0_wp) around = p(1:2)/rho
      s = sin(self%half_angle)
      c = cos(self%half_angle)
      along = rho*s + p(3)*c
      if (along > 0.0_wp) then
         x = along*[s*around(1), s*around(2), c]
         normal = [c*around(1), c*around(2), -s]
         distance = rho*c - p(3)*s
      else
         x = 0.0_wp
         distance = sqrt(p(1)**2 + p(2)**2 + p(3)**2)
         normal = [0.0_wp, 0.0_wp, -1.0_wp]
         if (distance > 0.0_wp) normal = p/distance
      end if
   end subroutine closest

   pure function normal(self, x)
      class(cone_type), intent(in) :: self
      real(wp), intent(in) :: x(3)
      real(wp) :: normal(3)
      real(wp) :: rho

      rho = sqrt(x(1)**2 + x(2)**2)
      normal = 0.0_wp
      if (.not. rho > 0.0_wp) return
      normal(1:2) = cos(self%half_angle)/rho*x(1:2)
      normal(3) = -sin(self%half_angle)
   end function normal

   pure subroutine form(self, x, normal, t, values)
      class(cone_type), intent(in) :: self
      real(wp), intent(in) :: x(3), normal(3), t(3, 2)
      real(wp), intent(out) :: values(3)
      real(wp) :: rho

      rho = sqrt(x(1)**2 + x(2)**2)
      if (rho > 0.0_wp) then
         values = cos(self%half_angle)/rho*turning_form((x(1)*t(2, :) - x(2)*t(1, :))/rho)
      else
         values = apex_curvature*[1.0_wp, 0.0_wp, 1.0_wp]
      end if
   end subroutine form

   !> The curvature around the axis, cos(half_angle)/rho, changes along the generators.
   pure subroutine cubic(self, x, normal, t, values)
      class(cone_type), intent(in) :: self
      real(wp), intent(in) :: x(3), normal(3), t(3, 2)
      real(wp), intent(out) :: values(4)
      real(wp) :: rho, s, c

      rho = sqrt(x(1)**2 + x(2)**2)
      s = sin(self%half_angle)
      c = cos(self%half_angle)
      values = 0.0_wp
      if (rho > 0.0_wp) values = turning_cubic(-s*c/rho**2, &
         matmul([-x(2)/rho, x(1)/rho, 0.0_wp], t), matmul([s*x(1)/rho, s*x(2)/rho, c], t))
   end subroutine cubic

   !> Along the generator.
   pure subroutine principal(self, x, normal, tangent)
      class(cone_type), intent(in) :: self
      real(wp), intent(in) :: x(3), normal(3)
      real(wp), intent(out) :: tangent(3)
      real(wp) :: rho

      rho = sqrt(x(1)**2 + x(2)**2)
      if (rho > 0.0_wp) then
         tangent(1:2) = sin(self%half_angle)/rho*x(1:2)
         tangent(3) = cos(self%half_angle)
      else
         tangent = any_tangent(normal)
      end if
   end subroutine principal

   pure subroutine apex(self, x, found)
      class(cone_type), intent(in) :: self
      real(wp), intent(out) :: x(3)
      logical, intent(out) :: found

      x = 0.0_wp
      found = .true.
   end subroutine apex

   pure subroutine solid(self, part, length, body)
      class(cone_type), intent(in) :: self
      integer, intent(in) :: part
      real(wp), intent(in) :: length
      type(solid_type), intent(out) :: body
      real(wp) :: radius

      body%cut = .true.
      radius = length*tan(self%half_angle)
      body%volume = pi/3.0_wp*radius**2*length
      body%centre(3) = 0.75_wp*length
      body%gyration = 0.15_wp*radius**2 + 0.0375_wp*length**2
      body%gyration(3) = 0.3_wp*radius**2
   end subroutine solid

end module contensou_contact_shapes_cone
