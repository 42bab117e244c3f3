!> Paraboloid of revolution about the third axis of its frame: the solid is z >= rho^2/(2 R), with
!> the vertex at the origin, where both radii of curvature are R. Its inside is a dish.
module contensou_contact_shapes_paraboloid
   use contensou_base_attitude, only : read_frame
   use contensou_base_diagnostics, only : diagnostics_type
   use contensou_base_kinds, only : pi, wp
   use contensou_base_schema, only : key_list_type, kind_real
   use contensou_base_settings, only : group_settings_type
   use contensou_contact_shapes_shape, only : solid_type, put_centre, put_direction, &
      quadric_cubic, quadric_form, shape_info_type, shape_type
   implicit none(type, external)
   private

   public :: paraboloid_type

   type, extends(shape_type) :: paraboloid_type
      !> Radius of curvature at the vertex [m].
      real(wp) :: vertex_radius = 0.0_wp
   contains
      procedure, nopass :: info
      procedure, nopass :: put_keys
      procedure :: read => read_paraboloid
      procedure :: closest
      procedure :: normal
      procedure :: form
      procedure :: cubic
      procedure :: restore
      procedure :: smallest_radius => radius_of
      procedure :: extent => radius_of
      procedure :: support
      procedure :: spine
      procedure :: solid
   end type paraboloid_type

   !> Most iterations for the closest point; Newton's method takes 3 to 8.
   integer, parameter :: most_iterations = 100

contains

   pure function info()
      type(shape_info_type) :: info

      info = shape_info_type("paraboloid", "paraboloids", "dish", "dish with a vertex radius of", &
         "centre (its vertex), vertex_radius and direction", ", which has no end,", &
         bounded=.false., slender=.true., rank=3, swept=.true., way="closed form but for one root")
   end function info

   subroutine put_keys(list)
      type(key_list_type), intent(inout) :: list

      call put_centre(list, "the vertex of a paraboloid")
      call list%put("surface", "vertex_radius", kind_real, unit="m", above=0.0_wp, &
         mandatory=.true., doc="radius of curvature R of |a paraboloid| at its vertex: its " // &
         "points are rho^2/(2 R) along its axis, rho from it")
      call put_direction(list, "a paraboloid (from its vertex into it)")
   end subroutine put_keys

   subroutine read_paraboloid(self, group, frame, diagnostics)
      class(paraboloid_type), intent(inout) :: self
      type(group_settings_type), intent(in) :: group
      real(wp), intent(inout) :: frame(3, 3)
      type(diagnostics_type), intent(inout) :: diagnostics

      self%vertex_radius = group%number("vertex_radius")
      call read_frame(group, "direction", frame, diagnostics)
   end subroutine read_paraboloid

   !> The distance rho of the closest point from the axis is the largest root of
   !> rho^3 + 2 R (R - p_3) rho = 2 R^2 q, q that of the given point. Newton's method descends to it
   !> from any upper bound.
   pure subroutine closest(self, p, x, normal, distance)
      class(paraboloid_type), intent(in) :: self
      real(wp), intent(in) :: p(3)
      real(wp), intent(out) :: x(3), normal(3), distance
      real(wp) :: q, along(2), a, c, rho, step
      integer :: i

      associate (r => self%vertex_radius)
         q = sqrt(p(1)**2 + p(2)**2)
         along = [1.0_wp, 0.0_wp]
         if (q > 0.0_wp) along = p(1:2)/q
         a = 2.0_wp*r*(r - p(3))
         c = 2.0_wp*r**2*q
         rho = c**(1.0_wp/3.0_wp)
         if (a < 0.0_wp) rho = rho + sqrt(-a)
         if (a*rho > c) rho = c/a
         do i = 1, most_iterations
            if (.not. rho > 0.0_wp) exit
            step = (rho*(rho**2 + a) - c)/(3.0_wp*rho**2 + a)
            rho = rho - step
            if (abs(step) <= 1.0e-9_wp*rho) exit
         end do
         x(1:2) = rho*along
         x(3) = 0.5_wp*rho**2/r
         normal(1:2) = rho*along
         normal(3) = -r
         normal = normal/sqrt(rho**2 + r**2)
         distance = normal(1)*(p(1) - x(1)) + normal(2)*(p(2) - x(2)) + normal(3)*(p(3) - x(3))
      end associate
   end subroutine closest

   pure function normal(self, x)
      class(paraboloid_type), intent(in) :: self
      real(wp), intent(in) :: x(3)
      real(wp) :: normal(3)

      normal = [x(1), x(2), -self%vertex_radius]
      normal = normal/sqrt(normal(1)**2 + normal(2)**2 + normal(3)**2)
   end function normal

   pure subroutine form(self, x, normal, t, values)
      class(paraboloid_type), intent(in) :: self
      real(wp), intent(in) :: x(3), normal(3), t(3, 2)
      real(wp), intent(out) :: values(3)

      values = quadric_form([1.0_wp, 1.0_wp, 0.0_wp], gradient(self, x), t)
   end subroutine form

   pure subroutine cubic(self, x, normal, t, values)
      class(paraboloid_type), intent(in) :: self
      real(wp), intent(in) :: x(3), normal(3), t(3, 2)
      real(wp), intent(out) :: values(4)

      values = quadric_cubic([1.0_wp, 1.0_wp, 0.0_wp], gradient(self, x), normal, t)
   end subroutine cubic

   !> Norm of the gradient of rho^2/2 - R z [m].
   pure function gradient(self, x)
      class(paraboloid_type), intent(in) :: self
      !> Point of the surface [m].
      real(wp), intent(in) :: x(3)
      real(wp) :: gradient

      gradient = sqrt(x(1)**2 + x(2)**2 + self%vertex_radius**2)
   end function gradient

   pure function restore(self, p) result(x)
      class(paraboloid_type), intent(in) :: self
      real(wp), intent(in) :: p(3)
      real(wp) :: x(3)

      x = [p(1), p(2), 0.5_wp*(p(1)**2 + p(2)**2)/self%vertex_radius]
   end function restore

   pure function radius_of(self) result(length)
      class(paraboloid_type), intent(in) :: self
      real(wp) :: length

      length = self%vertex_radius
   end function radius_of

   !> There is one unless the paraboloid opens towards the plane.
   pure subroutine support(self, up, height, x, gap, found)
      class(paraboloid_type), intent(in) :: self
      real(wp), intent(in) :: up(3), height
      real(wp), intent(out) :: x(3), gap
      logical, intent(out) :: found
      real(wp) :: slope(2)

      x = 0.0_wp
      gap = -self%vertex_radius
      ! Where the lowest point is as far as 1e6 radii there is none.
      found = up(3) > 1.0e-6_wp
      if (.not. found) return
      slope = up(1:2)/up(3)
      x(1:2) = -self%vertex_radius*slope
      x(3) = 0.5_wp*self%vertex_radius*(slope(1)**2 + slope(2)**2)
      gap = height - x(3)*up(3)
   end subroutine support

   !> Its axis from the centre of curvature of the vertex on, there and back.
   pure subroutine spine(self, u, sample, reach, centre, radius)
      class(paraboloid_type), intent(in) :: self
      real(wp), intent(in) :: u
      integer, intent(in) :: sample
      real(wp), intent(in) :: reach
      real(wp), intent(out) :: centre(3), radius
      real(wp) :: z

      z = reach*tan(0.5_wp*min(max(u, -3.14_wp), 3.14_wp))**2
      centre = [0.0_wp, 0.0_wp, self%vertex_radius + z]
      radius = sqrt(self%vertex_radius*(self%vertex_radius + 2.0_wp*z))
   end subroutine spine

   pure subroutine solid(self, part, length, body)
      class(paraboloid_type), intent(in) :: self
      integer, intent(in) :: part
      real(wp), intent(in) :: length
      type(solid_type), intent(out) :: body
      real(wp) :: square

      body%cut = .true.
      ! The radius of its rim, squared.
      square = 2.0_wp*self%vertex_radius*length
      body%volume = 0.5_wp*pi*square*length
      body%centre(3) = 2.0_wp/3.0_wp*length
      body%gyration = square/6.0_wp + length**2/18.0_wp
      body%gyration(3) = square/3.0_wp
   end subroutine solid

end module contensou_contact_shapes_paraboloid
