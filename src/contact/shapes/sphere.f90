!> Sphere.
module contensou_contact_shapes_sphere
   use contensou_base_diagnostics, only : diagnostics_type
   use contensou_base_kinds, only : wp
   use contensou_base_schema, only : key_list_type
   use contensou_base_settings, only : group_settings_type
   use contensou_contact_shapes_shape, only : ellipsoidal_solid, solid_type, put_centre, &
      put_radius, shape_info_type, shape_type
   implicit none(type, external)
   private

   public :: sphere_type

   type, extends(shape_type) :: sphere_type
      real(wp) :: radius = 0.0_wp
   contains
      procedure, nopass :: info
      procedure, nopass :: put_keys
      procedure :: read => read_sphere
      procedure :: closest
      procedure :: normal
      procedure :: form
      procedure :: smallest_radius => radius_of
      procedure :: largest_radius => radius_of
      procedure :: extent => radius_of
      procedure :: constant_curvatures
      procedure :: axes
      procedure :: misfit
      procedure :: room
      procedure :: solid
   end type sphere_type

contains

   pure function info()
      type(shape_info_type) :: info

      info = shape_info_type("sphere", "spheres", "socket", "hollow of radius", &
         "centre and radius", rank=4)
   end function info

   subroutine put_keys(list)
      type(key_list_type), intent(inout) :: list

      call put_centre(list, "centre of the shape")
      call put_radius(list, "a sphere")
   end subroutine put_keys

   subroutine read_sphere(self, group, frame, diagnostics)
      class(sphere_type), intent(inout) :: self
      type(group_settings_type), intent(in) :: group
      real(wp), intent(inout) :: frame(3, 3)
      type(diagnostics_type), intent(inout) :: diagnostics

      self%radius = group%number("radius")
   end subroutine read_sphere

   pure subroutine closest(self, p, x, normal, distance)
      class(sphere_type), intent(in) :: self
      real(wp), intent(in) :: p(3)
      real(wp), intent(out) :: x(3), normal(3), distance
      real(wp) :: length

      length = sqrt(p(1)**2 + p(2)**2 + p(3)**2)
      normal = [0.0_wp, 0.0_wp, 1.0_wp]
      if (length > 0.0_wp) normal = p/length
      distance = length - self%radius
      x = self%radius*normal
   end subroutine closest

   pure function normal(self, x)
      class(sphere_type), intent(in) :: self
      real(wp), intent(in) :: x(3)
      real(wp) :: normal(3)

      normal = x/sqrt(x(1)**2 + x(2)**2 + x(3)**2)
   end function normal

   pure subroutine form(self, x, normal, t, values)
      class(sphere_type), intent(in) :: self
      real(wp), intent(in) :: x(3), normal(3), t(3, 2)
      real(wp), intent(out) :: values(3)

      values = [1.0_wp, 0.0_wp, 1.0_wp]/self%radius
   end subroutine form

   pure function radius_of(self) result(length)
      class(sphere_type), intent(in) :: self
      real(wp) :: length

      length = self%radius
   end function radius_of

   pure subroutine constant_curvatures(self, constant, k)
      class(sphere_type), intent(in) :: self
      logical, intent(out) :: constant
      real(wp), intent(out) :: k(2)

      constant = .true.
      k = 1.0_wp/self%radius
   end subroutine constant_curvatures

   pure function axes(self)
      class(sphere_type), intent(in) :: self
      real(wp) :: axes(3)

      axes = self%radius
   end function axes

   pure function misfit(self, hollow) result(text)
      class(sphere_type), intent(in) :: self
      class(shape_type), intent(in) :: hollow
      character(len=:), allocatable :: text

      text = hollow%too_wide("a sphere of radius", self%radius, hollow%flattest_radius())
   end function misfit

   pure function room(self)
      class(sphere_type), intent(in) :: self
      real(wp) :: room(3)

      room = self%radius
   end function room

   pure subroutine solid(self, part, length, body)
      class(sphere_type), intent(in) :: self
      integer, intent(in) :: part
      real(wp), intent(in) :: length
      type(solid_type), intent(out) :: body

      call ellipsoidal_solid([1.0_wp, 1.0_wp, 1.0_wp]*self%radius, part, body)
   end subroutine solid

end module contensou_contact_shapes_sphere
