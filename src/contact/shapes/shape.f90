!> The shape of a surface: all that is asked of one, in its own frame.
!>
!> A shape is the boundary of a solid, with the normal out of it; `contact/surface` places it on a
!> body and turns its material outwards where it is a hollow. A new shape is a file with an
!> extension of `shape_type` and a row in `contact/shapes/table`.
!>
!> Conventions: the form is that of the derivative of the normal, dm = L xi, so that a convex
!> surface has a positive one. For an implicit surface F = 0 with G = |grad F|, normal
!> m = grad F/G and form h(u, v) = F''(u, v)/G the derivative of the form along the surface is
!> C(u, v, w) = (F'''(u, v, w) - h(u, v) F''(m, w) - h(v, w) F''(m, u) - h(w, u) F''(m, v))/G,
!> symmetric in its three arguments (Codazzi).
module contensou_contact_shapes_shape
   use contensou_base_diagnostics, only : diagnostics_type
   use contensou_base_kinds, only : pi, wp
   use contensou_base_numbers, only : to_text
   use contensou_base_schema, only : key_list_type, kind_real
   use contensou_base_settings, only : group_settings_type
   use contensou_base_vectors, only : any_tangent
   implicit none(type, external)
   private

   public :: shape_type, shape_info_type, put_centre, put_radius, put_direction
   public :: solid_type, ellipsoidal_solid
   public :: turning_form, turning_cubic, quadric_form, quadric_cubic
   public :: samples_line, angles, cosines, sines, half_tangents, apex_curvature

   !> What does not depend on the size of a shape.
   type :: shape_info_type
      !> Name in a scene.
      character(len=16) :: name = ""
      character(len=16) :: plural = ""
      !> What it is called when touched from within; blank where that cannot be.
      character(len=16) :: hollow = ""
      !> What of a hollow its room is, as "bore of radius".
      character(len=32) :: room = ""
      !> What describes it in a scene.
      character(len=80) :: hint = ""
      !> That it has no ends, as ", which has no ends,".
      character(len=24) :: endless = ""
      !> Whether it ends in all directions.
      logical :: bounded = .true.
      !> Whether its solid is convex.
      logical :: convex = .true.
      !> Whether a hollow of this shape widens in proportion to its depth.
      logical :: widens = .false.
      !> Whether what has no end has room in such a hollow.
      logical :: slender = .false.
      !> How well it carries the samples of a search, 0 for not at all.
      integer :: rank = 0
      !> Whether spheres sweep it along a line, so that samples have one parameter.
      logical :: swept = .false.
      !> How its point closest to the centre of a sphere is found.
      character(len=32) :: way = "closed form"
      !> Why it does not touch a plane in a point; blank if it has a lowest point.
      character(len=96) :: on_plane = ""
      !> What is to be known of it on a plane.
      character(len=32) :: remark = ""
   end type shape_info_type

   !> A homogeneous solid.
   type :: solid_type
      !> Volume [m3]; 0 if the shape bounds none.
      real(wp) :: volume = 0.0_wp
      !> Centre of mass, frame of the shape [m].
      real(wp) :: centre(3) = 0.0_wp
      !> Squares of the radii of gyration about the centre of mass, axes of the shape [m2].
      real(wp) :: gyration(3) = 0.0_wp
      !> Whether it needs a length.
      logical :: cut = .false.
      !> Whether it has halves.
      logical :: has_halves = .false.
   end type solid_type

   !> A shape in its own frame.
   type, abstract :: shape_type
   contains
      procedure(info_interface), deferred, nopass :: info
      procedure(keys_interface), deferred, nopass :: put_keys
      procedure(read_interface), deferred :: read
      procedure(closest_interface), deferred :: closest
      procedure(normal_interface), deferred :: normal
      procedure(form_interface), deferred :: form
      procedure :: smallest_radius
      procedure :: largest_radius
      procedure :: extent
      procedure :: cubic
      procedure :: principal
      procedure :: restore
      procedure :: constant_curvatures
      procedure :: narrowest
      procedure :: support
      procedure :: spine
      procedure :: alongside
      procedure :: axes
      procedure :: apex
      procedure :: misfit
      procedure :: room
      procedure :: flattest_radius
      procedure :: solid
      !> "a sphere".
      procedure, non_overridable :: words
      procedure, non_overridable :: too_wide
   end type shape_type

   abstract interface
      pure function info_interface() result(info)
         import :: shape_info_type
         implicit none(type, external)
         type(shape_info_type) :: info
      end function info_interface

      !> The keys of &surface that it has: a text in bars is about this shape and joined to those of
      !> other shapes with the key. A mandatory key is one that this shape must have.
      subroutine keys_interface(list)
         import :: key_list_type
         implicit none(type, external)
         type(key_list_type), intent(inout) :: list
      end subroutine keys_interface

      !> Take its values from the settings of a surface.
      subroutine read_interface(self, group, frame, diagnostics)
         import :: shape_type, group_settings_type, diagnostics_type, wp
         implicit none(type, external)
         class(shape_type), intent(inout) :: self
         type(group_settings_type), intent(in) :: group
         !> Rotation matrix, frame of the shape to frame of the body.
         real(wp), intent(inout) :: frame(3, 3)
         type(diagnostics_type), intent(inout) :: diagnostics
      end subroutine read_interface

      !> Point of the surface closest to a given point. Where several points are closest, as for
      !> the centre of a sphere, one of them is taken.
      pure subroutine closest_interface(self, p, x, normal, distance)
         import :: shape_type, wp
         implicit none(type, external)
         class(shape_type), intent(in) :: self
         !> Given point [m].
         real(wp), intent(in) :: p(3)
         !> Closest point of the surface [m].
         real(wp), intent(out) :: x(3)
         !> Normal there, out of the solid.
         real(wp), intent(out) :: normal(3)
         !> Distance, negative within the solid [m].
         real(wp), intent(out) :: distance
      end subroutine closest_interface

      !> Normal at a point of the surface, out of the solid; zero at an apex.
      pure function normal_interface(self, x) result(normal)
         import :: shape_type, wp
         implicit none(type, external)
         class(shape_type), intent(in) :: self
         !> Point of the surface [m].
         real(wp), intent(in) :: x(3)
         real(wp) :: normal(3)
      end function normal_interface

      !> Second fundamental form: components 11, 12, 22 in an orthonormal basis of tangents [1/m].
      pure subroutine form_interface(self, x, normal, t, values)
         import :: shape_type, wp
         implicit none(type, external)
         class(shape_type), intent(in) :: self
         !> Point of the surface [m].
         real(wp), intent(in) :: x(3)
         !> Normal there, or its opposite.
         real(wp), intent(in) :: normal(3)
         !> The two tangents.
         real(wp), intent(in) :: t(3, 2)
         real(wp), intent(out) :: values(3)
      end subroutine form_interface
   end interface

   !> Curvature of an apex, for those who have to tell it from others [1/m].
   real(wp), parameter :: apex_curvature = 1.0e100_wp

   !> Samples of a line that sweeps a shape.
   integer, parameter :: samples_line = 48

   integer :: counter

   !> Evenly around the circle [rad].
   real(wp), parameter :: angles(samples_line) = &
      [((real(counter, wp) - 0.5_wp)*2.0_wp*pi/samples_line - pi, counter=1, samples_line)]

   !> Their cosines and sines.
   real(wp), parameter :: cosines(samples_line) = cos(angles), sines(samples_line) = sin(angles)

   !> Tangents of half of them.
   real(wp), parameter :: half_tangents(samples_line) = tan(0.5_wp*angles)

contains

   !> The key of what is called the centre.
   subroutine put_centre(list, what)
      type(key_list_type), intent(inout) :: list
      !> What it is of this shape.
      character(len=*), intent(in) :: what

      call list%put("surface", "centre", kind_real, values=3, unit="m", default="0, 0, 0", &
         doc="|" // what // "|, in the frame of the body")
   end subroutine put_centre

   !> The key of a radius that a shape must have.
   subroutine put_radius(list, of)
      type(key_list_type), intent(inout) :: list
      !> What has it.
      character(len=*), intent(in) :: of

      call list%put("surface", "radius", kind_real, unit="m", above=0.0_wp, mandatory=.true., &
         doc="radius of |" // of // "|")
   end subroutine put_radius

   !> The key of an axis of revolution.
   subroutine put_direction(list, of)
      type(key_list_type), intent(inout) :: list
      !> What has it.
      character(len=*), intent(in) :: of

      call list%put("surface", "direction", kind_real, values=3, unit="1", doc="axis of |" // of &
         // "|, in the frame of the body, of any length; 0, 0, 1 if not given")
   end subroutine put_direction

   !> Derivative of the second fundamental form along the surface: components 111, 112, 122, 222
   !> [1/m2].
   pure subroutine cubic(self, x, normal, t, values)
      class(shape_type), intent(in) :: self
      !> Point of the surface [m].
      real(wp), intent(in) :: x(3)
      !> Normal there, out of the solid.
      real(wp), intent(in) :: normal(3)
      !> The two tangents.
      real(wp), intent(in) :: t(3, 2)
      real(wp), intent(out) :: values(4)

      values = 0.0_wp
   end subroutine cubic

   !> A principal direction at a point of a surface; any tangent where none is known beforehand.
   pure subroutine principal(self, x, normal, tangent)
      class(shape_type), intent(in) :: self
      !> Point of the surface [m].
      real(wp), intent(in) :: x(3)
      !> Normal there, or its opposite.
      real(wp), intent(in) :: normal(3)
      !> Unit vector.
      real(wp), intent(out) :: tangent(3)

      tangent = any_tangent(normal)
   end subroutine principal

   !> A point near a surface brought back onto it.
   pure function restore(self, p) result(x)
      class(shape_type), intent(in) :: self
      !> The point [m].
      real(wp), intent(in) :: p(3)
      real(wp) :: x(3)
      real(wp) :: normal(3), distance

      call self%closest(p, x, normal, distance)
   end function restore

   !> Principal curvatures along `principal` and across it that are the same everywhere.
   pure subroutine constant_curvatures(self, constant, k)
      class(shape_type), intent(in) :: self
      !> Whether they are the same everywhere.
      logical, intent(out) :: constant
      !> The two curvatures [1/m].
      real(wp), intent(out) :: k(2)

      constant = .false.
      k = 0.0_wp
   end subroutine constant_curvatures

   !> Smallest radius of curvature over all of the shape, without regard to sign [m]; the largest
   !> number where there is none.
   pure function smallest_radius(self) result(radius)
      class(shape_type), intent(in) :: self
      real(wp) :: radius

      radius = huge(radius)
   end function smallest_radius

   !> Largest radius of curvature over all of a convex shape [m].
   pure function largest_radius(self) result(radius)
      class(shape_type), intent(in) :: self
      real(wp) :: radius

      radius = huge(radius)
   end function largest_radius

   !> Length of the order of the shape [m], zero where there is none.
   pure function extent(self) result(length)
      class(shape_type), intent(in) :: self
      real(wp) :: length

      length = 0.0_wp
   end function extent

   !> Radius of curvature of a hollow where it is narrowest [m].
   pure function narrowest(self) result(radius)
      class(shape_type), intent(in) :: self
      real(wp) :: radius

      radius = self%smallest_radius()
   end function narrowest

   !> Lowest point above a plane.
   pure subroutine support(self, up, height, x, gap, found)
      class(shape_type), intent(in) :: self
      !> Normal of the plane.
      real(wp), intent(in) :: up(3)
      !> Height of the origin above the plane [m].
      real(wp), intent(in) :: height
      !> The lowest point [m].
      real(wp), intent(out) :: x(3)
      !> Its height above the plane [m].
      real(wp), intent(out) :: gap
      logical, intent(out) :: found

      x = 0.0_wp
      gap = height
      found = .false.
   end subroutine support

   !> A sphere of those that sweep a shape along a line.
   pure subroutine spine(self, u, sample, reach, centre, radius)
      class(shape_type), intent(in) :: self
      !> Parameter of the line, -pi to pi.
      real(wp), intent(in) :: u
      !> Number of the sampled angle that it is; 0 for none.
      integer, intent(in) :: sample
      !> Length of the order of where the other surface may be closest to an endless shape [m].
      real(wp), intent(in) :: reach
      !> Centre of the sphere [m].
      real(wp), intent(out) :: centre(3)
      !> Its radius [m].
      real(wp), intent(out) :: radius

      centre = 0.0_wp
      radius = 0.0_wp
   end subroutine spine

   !> Whether a point of the surface lies where a sample of its line is.
   pure function alongside(self, x, sample)
      class(shape_type), intent(in) :: self
      !> The point [m].
      real(wp), intent(in) :: x(3)
      integer, intent(in) :: sample
      logical :: alongside

      alongside = .false.
   end function alongside

   !> Semi-axes of the ellipsoid that a shape is [m].
   pure function axes(self)
      class(shape_type), intent(in) :: self
      real(wp) :: axes(3)

      axes = 0.0_wp
   end function axes

   !> The point of a shape without a normal.
   pure subroutine apex(self, x, found)
      class(shape_type), intent(in) :: self
      !> The point [m].
      real(wp), intent(out) :: x(3)
      logical, intent(out) :: found

      x = 0.0_wp
      found = .false.
   end subroutine apex

   !> Why a shape does not touch a hollow in a point; empty when it can.
   !>
   !> It has to fit in, and its curvature has to be the stronger one at one place at least.
   pure function misfit(self, hollow) result(text)
      class(shape_type), intent(in) :: self
      class(shape_type), intent(in) :: hollow
      character(len=:), allocatable :: text
      type(shape_info_type) :: info, other

      info = self%info()
      other = hollow%info()
      text = ""
      if (info%slender .and. other%widens) return
      text = self%words() // trim(info%endless) // " does not touch the inside of " // &
         hollow%words() // " in a point"
   end function misfit

   !> Halves of the widths of a hollow in ascending order [m], the largest number where it is open.
   pure function room(self)
      class(shape_type), intent(in) :: self
      real(wp) :: room(3)

      room = huge(room)
   end function room

   !> The smaller radius of curvature of a hollow where it is flattest [m].
   pure function flattest_radius(self) result(radius)
      class(shape_type), intent(in) :: self
      real(wp) :: radius

      radius = self%narrowest()
   end function flattest_radius

   !> The solid that a shape bounds; none if it has no ends.
   pure subroutine solid(self, part, length, body)
      class(shape_type), intent(in) :: self
      !> 0 for all of it, -1 or 1 for the half below or above its centre along its third axis.
      integer, intent(in) :: part
      !> Length or height of what has no ends by itself [m].
      real(wp), intent(in) :: length
      type(solid_type), intent(out) :: body

      body = solid_type()
   end subroutine solid

   !> The solid of an ellipsoid, or half of it.
   pure subroutine ellipsoidal_solid(axes, part, body)
      !> Semi-axes [m].
      real(wp), intent(in) :: axes(3)
      !> As for `solid`.
      integer, intent(in) :: part
      type(solid_type), intent(out) :: body
      real(wp) :: square(3)

      square = axes**2
      body%has_halves = .true.
      body%volume = 4.0_wp/3.0_wp*pi*axes(1)*axes(2)*axes(3)
      body%gyration = 0.2_wp*[square(2) + square(3), square(1) + square(3), square(1) + square(2)]
      if (part == 0) return
      body%volume = 0.5_wp*body%volume
      body%centre(3) = part*0.375_wp*axes(3)
      body%gyration(1:2) = body%gyration(1:2) - body%centre(3)**2
   end subroutine ellipsoidal_solid

   !> A shape in words, as "a sphere".
   pure function words(self) result(text)
      class(shape_type), intent(in) :: self
      character(len=:), allocatable :: text
      type(shape_info_type) :: info

      info = self%info()
      text = "a " // trim(info%name)
      if (scan(info%name(1:1), "aeiou") > 0) text = "an " // trim(info%name)
   end function words

   !> That a body does not fit into a hollow; empty when it does.
   pure function too_wide(self, what, width, room) result(text)
      class(shape_type), intent(in) :: self
      !> The body up to its width, as "a sphere of radius".
      character(len=*), intent(in) :: what
      !> The width [m].
      real(wp), intent(in) :: width
      !> What there is room for [m].
      real(wp), intent(in) :: room
      character(len=:), allocatable :: text
      type(shape_info_type) :: info

      text = ""
      if (width < room) return
      info = self%info()
      text = what // " " // to_text(width) // " m does not fit into the " // trim(info%room) // &
         " " // to_text(room) // " m of " // self%words() // ": conforming contact"
   end function too_wide

   !> Form of a curvature along one tangent only.
   pure function turning_form(c) result(form)
      !> Components of the direction of that curvature.
      real(wp), intent(in) :: c(2)
      real(wp) :: form(3)

      form = [c(1)**2, c(1)*c(2), c(2)**2]
   end function turning_form

   !> Derivative of a form whose curvature along one tangent changes along the other.
   pure function turning_cubic(k, c, f) result(cubic)
      !> The change of the curvature [1/m2].
      real(wp), intent(in) :: k
      !> Components of the direction of the curvature.
      real(wp), intent(in) :: c(2)
      !> Components of the direction of its change.
      real(wp), intent(in) :: f(2)
      real(wp) :: cubic(4)

      cubic(1) = 3.0_wp*k*c(1)**2*f(1)
      cubic(2) = k*(c(1)**2*f(2) + 2.0_wp*c(1)*c(2)*f(1))
      cubic(3) = k*(c(2)**2*f(1) + 2.0_wp*c(1)*c(2)*f(2))
      cubic(4) = 3.0_wp*k*c(2)**2*f(2)
   end function turning_cubic

   !> Form of a surface F = 0 whose second derivatives are constant and without mixed ones.
   pure function quadric_form(d, gradient, t) result(form)
      !> Second derivatives along the axes [1/m2].
      real(wp), intent(in) :: d(3)
      !> Norm of the gradient of F [1/m].
      real(wp), intent(in) :: gradient
      !> The two tangents.
      real(wp), intent(in) :: t(3, 2)
      real(wp) :: form(3)

      form = [sum(t(:, 1)**2*d), sum(t(:, 1)*t(:, 2)*d), sum(t(:, 2)**2*d)]/gradient
   end function quadric_form

   !> Its derivative.
   pure function quadric_cubic(d, gradient, normal, t) result(cubic)
      !> Second derivatives along the axes [1/m2].
      real(wp), intent(in) :: d(3)
      !> Norm of the gradient of F [1/m].
      real(wp), intent(in) :: gradient
      !> Normal along the gradient.
      real(wp), intent(in) :: normal(3)
      !> The two tangents.
      real(wp), intent(in) :: t(3, 2)
      real(wp) :: cubic(4)
      real(wp) :: h(3), f(2)

      h = quadric_form(d, gradient, t)
      f = matmul(normal*d, t)
      cubic(1) = -3.0_wp*h(1)*f(1)/gradient
      cubic(2) = -(h(1)*f(2) + 2.0_wp*h(2)*f(1))/gradient
      cubic(3) = -(h(3)*f(1) + 2.0_wp*h(2)*f(2))/gradient
      cubic(4) = -3.0_wp*h(3)*f(2)/gradient
   end function quadric_cubic

end module contensou_contact_shapes_shape
