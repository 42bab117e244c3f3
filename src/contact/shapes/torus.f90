!> Torus about the third axis of its frame; its inside is a raceway groove.
module contensou_contact_shapes_torus
   use contensou_base_attitude, only : read_frame
   use contensou_base_diagnostics, only : diagnostics_type
   use contensou_base_kinds, only : pi, wp
   use contensou_base_numbers, only : to_text
   use contensou_base_schema, only : key_list_type, kind_real
   use contensou_base_settings, only : group_settings_type
   use contensou_base_text, only : quote
   use contensou_base_vectors, only : cross
   use contensou_contact_shapes_shape, only : solid_type, cosines, put_centre, put_direction, &
      shape_info_type, shape_type, sines
   implicit none(type, external)
   private

   public :: torus_type

   type, extends(shape_type) :: torus_type
      !> Radius of the centre circle [m], larger than that of the tube.
      real(wp) :: major_radius = 0.0_wp
      !> Radius of the tube [m].
      real(wp) :: radius = 0.0_wp
   contains
      procedure, nopass :: info
      procedure, nopass :: put_keys
      procedure :: read => read_torus
      procedure :: closest
      procedure :: normal
      procedure :: form
      procedure :: cubic
      procedure :: principal
      procedure :: smallest_radius
      procedure :: extent
      procedure :: narrowest
      procedure :: support
      procedure :: spine
      procedure :: alongside
      procedure :: misfit
      procedure :: room
      procedure :: solid
   end type torus_type

   !> Cosine of the angle up to which samples belong to one place.
   real(wp), parameter :: nearby = 0.95_wp

contains

   pure function info()
      type(shape_info_type) :: info

      info = shape_info_type("torus", "tori", "raceway groove", "groove of radius", &
         "centre, major_radius, minor_radius and direction", convex=.false., rank=6, &
         swept=.true., remark="lying flat it conforms")
   end function info

   subroutine put_keys(list)
      type(key_list_type), intent(inout) :: list

      call put_centre(list, "centre of the shape")
      call list%put("surface", "major_radius", kind_real, unit="m", above=0.0_wp, &
         mandatory=.true., doc="radius of the centre circle of |a torus|, larger than minor_radius")
      call list%put("surface", "minor_radius", kind_real, unit="m", above=0.0_wp, &
         mandatory=.true., doc="radius of the tube of |a torus|")
      call put_direction(list, "a torus")
   end subroutine put_keys

   subroutine read_torus(self, group, frame, diagnostics)
      class(torus_type), intent(inout) :: self
      type(group_settings_type), intent(in) :: group
      real(wp), intent(inout) :: frame(3, 3)
      type(diagnostics_type), intent(inout) :: diagnostics

      self%radius = group%number("minor_radius")
      self%major_radius = group%number("major_radius")
      call read_frame(group, "direction", frame, diagnostics)
      if (.not. (group%is_set("minor_radius") .and. group%is_set("major_radius"))) return
      if (self%radius >= self%major_radius) call diagnostics%add(group%place("minor_radius", 1), &
         "the torus " // quote(group%label()) // " intersects itself", &
         "minor_radius < major_radius, here " // to_text(self%major_radius) // " [m]")
   end subroutine read_torus

   pure subroutine closest(self, p, x, normal, distance)
      class(torus_type), intent(in) :: self
      real(wp), intent(in) :: p(3)
      real(wp), intent(out) :: x(3), normal(3), distance
      real(wp) :: rho, across, centre(3), length

      rho = sqrt(p(1)**2 + p(2)**2)
      centre = [1.0_wp, 0.0_wp, 0.0_wp]
      if (rho > 0.0_wp) centre(1:2) = p(1:2)/rho
      across = rho - self%major_radius
      length = sqrt(across**2 + p(3)**2)
      normal = centre
      if (length > 0.0_wp) then
         normal(1:2) = across/length*centre(1:2)
         normal(3) = p(3)/length
      end if
      distance = length - self%radius
      x = self%major_radius*centre + self%radius*normal
   end subroutine closest

   pure function normal(self, x)
      class(torus_type), intent(in) :: self
      real(wp), intent(in) :: x(3)
      real(wp) :: normal(3)
      real(wp) :: rho

      rho = sqrt(x(1)**2 + x(2)**2)
      normal(1:2) = (rho - self%major_radius)/rho*x(1:2)
      normal(3) = x(3)
      normal = normal/sqrt(normal(1)**2 + normal(2)**2 + normal(3)**2)
   end function normal

   pure subroutine form(self, x, normal, t, values)
      class(torus_type), intent(in) :: self
      real(wp), intent(in) :: x(3), normal(3), t(3, 2)
      real(wp), intent(out) :: values(3)
      real(wp) :: around(2), rho, tube, ring

      ! Written out, as bearings spend much of their time here.
      rho = sqrt(x(1)**2 + x(2)**2)
      around = (x(1)*t(2, :) - x(2)*t(1, :))/rho
      tube = 1.0_wp/self%radius
      ring = (rho - self%major_radius)*tube/rho
      values = tube*[1.0_wp, 0.0_wp, 1.0_wp] &
         + (ring - tube)*[around(1)**2, around(1)*around(2), around(2)**2]
   end subroutine form

   !> The curvature around the axis, cos(phi)/rho, changes along the tube.
   pure subroutine cubic(self, x, normal, t, values)
      class(torus_type), intent(in) :: self
      real(wp), intent(in) :: x(3), normal(3), t(3, 2)
      real(wp), intent(out) :: values(4)
      real(wp) :: rho, e_ring(3), e_tube(3), c(2), f(2), k

      rho = sqrt(x(1)**2 + x(2)**2)
      e_ring = [-x(2)/rho, x(1)/rho, 0.0_wp]
      e_tube = cross(e_ring, normal)
      e_tube = -e_tube
      c = matmul(e_ring, t)
      f = matmul(e_tube, t)
      k = -self%major_radius/self%radius*normal(3)/rho**2
      values(1) = 3.0_wp*k*c(1)**2*f(1)
      values(2) = k*(c(1)**2*f(2) + 2.0_wp*c(1)*c(2)*f(1))
      values(3) = k*(c(2)**2*f(1) + 2.0_wp*c(1)*c(2)*f(2))
      values(4) = 3.0_wp*k*c(2)**2*f(2)
   end subroutine cubic

   pure subroutine principal(self, x, normal, tangent)
      class(torus_type), intent(in) :: self
      real(wp), intent(in) :: x(3), normal(3)
      real(wp), intent(out) :: tangent(3)
      real(wp) :: rho

      rho = sqrt(x(1)**2 + x(2)**2)
      tangent(1) = -x(2)/rho
      tangent(2) = x(1)/rho
      tangent(3) = 0.0_wp
   end subroutine principal

   pure function smallest_radius(self) result(length)
      class(torus_type), intent(in) :: self
      real(wp) :: length

      length = min(self%radius, self%major_radius - self%radius)
   end function smallest_radius

   pure function extent(self) result(length)
      class(torus_type), intent(in) :: self
      real(wp) :: length

      length = self%radius + self%major_radius
   end function extent

   pure function narrowest(self) result(radius)
      class(torus_type), intent(in) :: self
      real(wp) :: radius

      radius = self%radius
   end function narrowest

   pure subroutine support(self, up, height, x, gap, found)
      class(torus_type), intent(in) :: self
      real(wp), intent(in) :: up(3), height
      real(wp), intent(out) :: x(3), gap
      logical, intent(out) :: found
      real(wp) :: across

      across = sqrt(up(1)**2 + up(2)**2)
      x = -self%radius*up
      if (across > 0.0_wp) then
         x(1:2) = x(1:2) - self%major_radius/across*up(1:2)
      else
         x(1) = x(1) - self%major_radius
      end if
      gap = height - self%major_radius*across - self%radius
      found = .true.
   end subroutine support

   pure subroutine spine(self, u, sample, reach, centre, radius)
      class(torus_type), intent(in) :: self
      real(wp), intent(in) :: u
      integer, intent(in) :: sample
      real(wp), intent(in) :: reach
      real(wp), intent(out) :: centre(3), radius

      if (sample > 0) then
         centre = self%major_radius*[cosines(sample), sines(sample), 0.0_wp]
      else
         centre = self%major_radius*[cos(u), sin(u), 0.0_wp]
      end if
      radius = self%radius
   end subroutine spine

   pure function alongside(self, x, sample)
      class(torus_type), intent(in) :: self
      real(wp), intent(in) :: x(3)
      integer, intent(in) :: sample
      logical :: alongside
      real(wp) :: here(2)

      here = x(1:2)/sqrt(x(1)**2 + x(2)**2)
      alongside = here(1)*cosines(sample) + here(2)*sines(sample) > nearby
   end function alongside

   !> In a groove its tube has to have room, in other hollows all of it.
   pure function misfit(self, hollow) result(text)
      class(torus_type), intent(in) :: self
      class(shape_type), intent(in) :: hollow
      character(len=:), allocatable :: text
      real(wp) :: rooms(3)

      select type (hollow)
      class is (torus_type)
         text = hollow%too_wide("a torus with a tube of radius", self%radius, hollow%radius)
      class default
         rooms = hollow%room()
         if (all(rooms >= huge(rooms))) rooms = hollow%flattest_radius()
         text = hollow%too_wide("a torus of outer radius", self%extent(), rooms(2))
      end select
   end function misfit

   pure function room(self)
      class(torus_type), intent(in) :: self
      real(wp) :: room(3)

      room = [self%radius, self%radius, huge(room)]
   end function room

   pure subroutine solid(self, part, length, body)
      class(torus_type), intent(in) :: self
      integer, intent(in) :: part
      real(wp), intent(in) :: length
      type(solid_type), intent(out) :: body

      body%volume = 2.0_wp*pi**2*self%major_radius*self%radius**2
      body%gyration = 0.5_wp*self%major_radius**2 + 0.625_wp*self%radius**2
      body%gyration(3) = self%major_radius**2 + 0.75_wp*self%radius**2
   end subroutine solid

end module contensou_contact_shapes_torus
