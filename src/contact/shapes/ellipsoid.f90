!> Ellipsoid along the axes of its frame.
module contensou_contact_shapes_ellipsoid
   use contensou_base_attitude, only : read_attitude
   use contensou_base_diagnostics, only : diagnostics_type
   use contensou_base_kinds, only : wp
   use contensou_base_rotations, only : rotation_matrix
   use contensou_base_schema, only : key_list_type, kind_real
   use contensou_base_settings, only : group_settings_type
   use contensou_contact_shapes_shape, only : ellipsoidal_solid, solid_type, put_centre, &
      quadric_cubic, quadric_form, shape_info_type, shape_type
   implicit none(type, external)
   private

   public :: ellipsoid_type

   type, extends(shape_type) :: ellipsoid_type
      !> Along the axes of its frame [m].
      real(wp) :: semi_axes(3) = 1.0_wp
   contains
      procedure, nopass :: info
      procedure, nopass :: put_keys
      procedure :: read => read_ellipsoid
      procedure :: closest
      procedure :: normal
      procedure :: form
      procedure :: cubic
      procedure :: restore
      procedure :: smallest_radius
      procedure :: largest_radius
      procedure :: extent
      procedure :: support
      procedure :: axes
      procedure :: misfit
      procedure :: room
      procedure :: flattest_radius
      procedure :: solid
   end type ellipsoid_type

   !> Most iterations for the point closest to a given one. Newton's method takes 3 to 6 of them,
   !> more only for points deep inside.
   integer, parameter :: most_iterations = 100

contains

   pure function info()
      type(shape_info_type) :: info

      info = shape_info_type("ellipsoid", "ellipsoids", "hollow", "hollow of", &
         "centre, semi_axes, and axis and angle or quaternion", rank=5, &
         way="closed form but for one root")
   end function info

   subroutine put_keys(list)
      type(key_list_type), intent(inout) :: list

      call put_centre(list, "centre of the shape")
      call list%put("surface", "semi_axes", kind_real, values=3, unit="m", above=0.0_wp, &
         mandatory=.true., doc="semi-axes of |an ellipsoid| along its axes, which are those of " &
         // "the body if they are not turned")
      call list%put("surface", "axis", kind_real, values=3, unit="1", &
         doc="axis of the rotation from the axes of the body to those of |an ellipsoid|, of any " &
         // "length; goes with angle")
      call list%put("surface", "angle", kind_real, unit="rad", &
         doc="angle of the rotation of |an ellipsoid| about axis")
      call list%put("surface", "quaternion", kind_real, values=4, unit="1", &
         doc="attitude (w, x, y, z) of |an ellipsoid|, from its axes to those of the body, of " &
         // "any norm; instead of axis and angle")
   end subroutine put_keys

   subroutine read_ellipsoid(self, group, frame, diagnostics)
      class(ellipsoid_type), intent(inout) :: self
      type(group_settings_type), intent(in) :: group
      real(wp), intent(inout) :: frame(3, 3)
      type(diagnostics_type), intent(inout) :: diagnostics
      real(wp) :: quaternion(4)

      self%semi_axes = group%numbers("semi_axes")
      quaternion = 0.0_wp
      call read_attitude(group, quaternion, diagnostics)
      if (any(abs(quaternion) > 0.0_wp)) frame = rotation_matrix(quaternion)
   end subroutine read_ellipsoid

   !> x_i = a_i^2 p_i/(t + a_i^2), where t is the largest root of
   !> s(t) = sum (a_i p_i/(t + a_i^2))^2 = 1. Newton's method on 1/sqrt(s), which is
   !> nearly linear and concave, climbs to it from any lower bound.
   pure subroutine closest(self, p, x, normal, distance)
      class(ellipsoid_type), intent(in) :: self
      real(wp), intent(in) :: p(3)
      real(wp), intent(out) :: x(3), normal(3), distance
      real(wp) :: square(3), q(3), y(3), t, s, slope, step, length, floor_t
      integer :: i, k

      associate (semi_axes => self%semi_axes)
         square = semi_axes**2
         q = semi_axes*p
         length = sqrt(q(1)**2 + q(2)**2 + q(3)**2)
         ! At the root no term of s is above one, nor is s with the largest denominator in all
         ! terms.
         t = max(maxval(abs(q) - square), length - maxval(square))
         k = minloc(square, dim=1)
         floor_t = -square(k)*(1.0_wp - 4.0_wp*epsilon(t))
         t = max(t, floor_t)
         do i = 1, most_iterations
            y = q/(t + square)
            s = y(1)**2 + y(2)**2 + y(3)**2
            ! Where even the lower bound is too high, the point lies on a plane of symmetry between
            ! two closest points.
            if (s < 1.0_wp) exit
            slope = y(1)**2/(t + square(1)) + y(2)**2/(t + square(2)) + y(3)**2/(t + square(3))
            step = s*(sqrt(s) - 1.0_wp)/slope
            t = t + step
            if (abs(step) <= 1.0e-9_wp*abs(t + square(k))) exit
         end do
         x = square*p/(t + square)
         y = p/(t + square)
         if (t <= floor_t) then
            s = (x(1)/semi_axes(1))**2 + (x(2)/semi_axes(2))**2 + (x(3)/semi_axes(3))**2 &
               - (x(k)/semi_axes(k))**2
            x(k) = sign(semi_axes(k)*sqrt(max(1.0_wp - s, 0.0_wp)), p(k))
            y = x/square
         end if
         length = sqrt(y(1)**2 + y(2)**2 + y(3)**2)
         normal = y/length
         distance = t*length
      end associate
   end subroutine closest

   pure function normal(self, x)
      class(ellipsoid_type), intent(in) :: self
      real(wp), intent(in) :: x(3)
      real(wp) :: normal(3)

      normal = x/self%semi_axes**2
      normal = normal/sqrt(normal(1)**2 + normal(2)**2 + normal(3)**2)
   end function normal

   pure subroutine form(self, x, normal, t, values)
      class(ellipsoid_type), intent(in) :: self
      real(wp), intent(in) :: x(3), normal(3), t(3, 2)
      real(wp), intent(out) :: values(3)
      real(wp) :: d(3), e(3)

      d = 1.0_wp/self%semi_axes**2
      e = x*d
      values = quadric_form(d, sqrt(e(1)**2 + e(2)**2 + e(3)**2), t)
   end subroutine form

   pure subroutine cubic(self, x, normal, t, values)
      class(ellipsoid_type), intent(in) :: self
      real(wp), intent(in) :: x(3), normal(3), t(3, 2)
      real(wp), intent(out) :: values(4)
      real(wp) :: d(3), e(3)

      d = 1.0_wp/self%semi_axes**2
      e = x*d
      values = quadric_cubic(d, sqrt(e(1)**2 + e(2)**2 + e(3)**2), normal, t)
   end subroutine cubic

   pure function restore(self, p) result(x)
      class(ellipsoid_type), intent(in) :: self
      real(wp), intent(in) :: p(3)
      real(wp) :: x(3)

      x = p/sqrt(sum((p/self%semi_axes)**2))
   end function restore

   pure function smallest_radius(self) result(length)
      class(ellipsoid_type), intent(in) :: self
      real(wp) :: length

      length = minval(self%semi_axes)**2/maxval(self%semi_axes)
   end function smallest_radius

   pure function largest_radius(self) result(radius)
      class(ellipsoid_type), intent(in) :: self
      real(wp) :: radius

      radius = maxval(self%semi_axes)**2/minval(self%semi_axes)
   end function largest_radius

   pure function extent(self) result(length)
      class(ellipsoid_type), intent(in) :: self
      real(wp) :: length

      length = maxval(self%semi_axes)
   end function extent

   pure subroutine support(self, up, height, x, gap, found)
      class(ellipsoid_type), intent(in) :: self
      real(wp), intent(in) :: up(3), height
      real(wp), intent(out) :: x(3), gap
      logical, intent(out) :: found
      real(wp) :: across

      across = sqrt(sum((self%semi_axes*up)**2))
      x = -self%semi_axes**2*up/across
      gap = height - across
      found = .true.
   end subroutine support

   pure function axes(self)
      class(ellipsoid_type), intent(in) :: self
      real(wp) :: axes(3)

      axes = self%semi_axes
   end function axes

   !> Where a hollow is open on all sides the radii of curvature at the ends of the longest axis
   !> count, else the widths.
   pure function misfit(self, hollow) result(text)
      class(ellipsoid_type), intent(in) :: self
      class(shape_type), intent(in) :: hollow
      character(len=:), allocatable :: text
      real(wp) :: widths(3), rooms(3)
      integer :: k

      widths = self%room()
      rooms = hollow%room()
      if (all(rooms >= huge(rooms))) then
         text = hollow%too_wide("an ellipsoid with ends of radius", widths(2)**2/widths(3), &
            hollow%flattest_radius())
         return
      end if
      k = maxloc(widths/rooms, dim=1)
      text = hollow%too_wide("an ellipsoid with a semi-axis of", widths(k), rooms(k))
   end function misfit

   !> The semi-axes in ascending order.
   pure function room(self)
      class(ellipsoid_type), intent(in) :: self
      real(wp) :: room(3)

      associate (a => self%semi_axes)
         room = [minval(a), max(min(a(1), a(2)), min(max(a(1), a(2)), a(3))), maxval(a)]
      end associate
   end function room

   pure function flattest_radius(self) result(radius)
      class(ellipsoid_type), intent(in) :: self
      real(wp) :: radius
      real(wp) :: rooms(3)

      rooms = self%room()
      radius = rooms(2)**2/rooms(1)
   end function flattest_radius

   pure subroutine solid(self, part, length, body)
      class(ellipsoid_type), intent(in) :: self
      integer, intent(in) :: part
      real(wp), intent(in) :: length
      type(solid_type), intent(out) :: body

      call ellipsoidal_solid(self%semi_axes, part, body)
   end subroutine solid

end module contensou_contact_shapes_ellipsoid
