!> Geometry of all pairs of surfaces: closed forms against the search, curvatures against
!> differences of the separation, variations against differences, all against a brute search.
module test_geometry
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite
   use contensou_base_kinds, only : pi, wp
   use contensou_base_rotations, only : quaternion_from_axis_angle, rotation_matrix
   use contensou_base_vectors, only : any_perpendicular, cross, frame_along
   use contensou_contact_geometry, only : contact_point_type, contact_trouble, &
      contact_variation_type, geometry_type, pose_type, track_type, trouble_conforming, &
      trouble_apex, trouble_none, trouble_text
   use contensou_contact_pairs, only : new_geometry
   use contensou_contact_shapes_cone, only : cone_type
   use contensou_contact_shapes_cylinder, only : cylinder_type
   use contensou_contact_shapes_ellipsoid, only : ellipsoid_type
   use contensou_contact_shapes_paraboloid, only : paraboloid_type
   use contensou_contact_shapes_plane, only : plane_type
   use contensou_contact_shapes_sphere, only : sphere_type
   use contensou_contact_shapes_torus, only : torus_type
   use contensou_contact_surface, only : surface_type
   use contensou_contact_surface_pair, only : new_searched_pair
   use test_harness, only : check, check_close, random_type, worst_type
   implicit none(type, external)
   private

   public :: run_geometry_tests

   !> Kinds of pairs; the first of them have closed forms.
   character(len=*), parameter :: kinds(*) = [character(len=24) :: "sphere plane", &
      "sphere sphere", "sphere socket", "sphere cylinder", "sphere bore", "sphere ellipsoid", &
      "sphere hollow", "sphere torus", "sphere groove", "sphere paraboloid", "sphere dish", &
      "sphere cone", "sphere funnel", "ellipsoid plane", "torus plane", "paraboloid plane", &
      "cylinder cylinder", "ellipsoid ellipsoid", "ellipsoid hollow", "ellipsoid cylinder", &
      "ellipsoid bore", "ellipsoid socket", "ellipsoid torus", "ellipsoid groove", &
      "ellipsoid paraboloid", "ellipsoid dish", "ellipsoid cone", "ellipsoid funnel", &
      "torus cylinder", "torus bore", "torus socket", "torus torus", "torus groove", &
      "torus hollow", "torus paraboloid", "torus dish", "torus cone", "torus funnel", &
      "paraboloid cylinder", "paraboloid paraboloid", "paraboloid cone", "paraboloid funnel", &
      "cone cylinder"]

   !> Number of kinds with a closed form.
   integer, parameter :: closed_kinds = 17

contains

   !> All tests of this suite.
   subroutine run_geometry_tests()
      integer :: kind

      do kind = 1, size(kinds)
         call test_points(kind)
         call test_hessian(kind)
         call test_variation(kind)
         if (kind <= closed_kinds) call test_search(kind)
         call test_brute(kind)
         call test_tracking(kind)
      end do
      call test_degenerate()
      call test_conforming()
      call test_refusals()
      call test_scale()
   end subroutine run_geometry_tests

   !> Two surfaces of a kind, of random sizes, places on their bodies and order.
   subroutine draw(kind, random, a, b)
      integer, intent(in) :: kind
      !> Source of random numbers.
      type(random_type), intent(inout) :: random
      type(surface_type), intent(out) :: a
      type(surface_type), intent(out) :: b
      character(len=24) :: first, second
      integer :: blank

      blank = index(kinds(kind), " ")
      first = kinds(kind)(:blank - 1)
      second = kinds(kind)(blank + 1:)
      call draw_one(second, 1.0_wp, random, b)
      call draw_one(first, merge(0.25_wp*scale_of(b), 1.0_wp, b%inside), random, a)
      if (random%uniform(0.0_wp, 1.0_wp) < 0.5_wp) call swap(a, b)
   end subroutine draw

   !> Exchange two surfaces.
   subroutine swap(a, b)
      !> One.
      type(surface_type), intent(inout) :: a
      !> The other.
      type(surface_type), intent(inout) :: b
      type(surface_type) :: c

      c = a
      a = b
      b = c
   end subroutine swap

   !> A surface of random size and place.
   subroutine draw_one(name, scale, random, surface)
      !> Its shape.
      character(len=*), intent(in) :: name
      !> Length of the order of its size; what is to lie in a hollow is smaller than three times it.
      real(wp), intent(in) :: scale
      !> Source of random numbers.
      type(random_type), intent(inout) :: random
      type(surface_type), intent(out) :: surface
      real(wp) :: radius, semi_axes(3)
      integer :: i

      surface%centre = random%vector(3)
      surface%frame = rotation_matrix(random%vector(4))
      radius = scale*random%uniform(0.5_wp, 1.5_wp)
      select case (name)
      case ("sphere", "socket")
         surface%shape = sphere_type(radius)
      case ("plane")
         surface%shape = plane_type()
      case ("cylinder", "bore")
         surface%shape = cylinder_type(radius)
      case ("ellipsoid", "hollow")
         do i = 1, 3
            semi_axes(i) = scale*random%uniform(0.5_wp, 2.0_wp)
         end do
         surface%shape = ellipsoid_type(semi_axes)
      case ("paraboloid", "dish")
         surface%shape = paraboloid_type(radius)
      case ("cone", "funnel")
         surface%shape = cone_type(random%uniform(0.3_wp, 1.1_wp))
      case default
         if (name == "torus" .and. scale < 1.0_wp) radius = 0.5_wp*radius
         surface%shape = torus_type(radius*random%uniform(1.2_wp, 3.0_wp), radius)
      end select
      select case (name)
      case ("socket", "bore", "hollow", "groove", "dish", "funnel")
         surface%inside = .true.
      case default
         surface%inside = .false.
      end select
   end subroutine draw_one

   !> Bodies at random poses with a given gap between two surfaces.
   subroutine place(a, b, geometry, gap, random, pose_a, pose_b, track, at)
      type(surface_type), intent(in) :: a
      type(surface_type), intent(in) :: b
      !> The pair.
      class(geometry_type), intent(in) :: geometry
      !> The gap [m].
      real(wp), intent(in) :: gap
      !> Source of random numbers.
      type(random_type), intent(inout) :: random
      !> Pose of body A.
      type(pose_type), intent(out) :: pose_a
      !> Pose of body B.
      type(pose_type), intent(out) :: pose_b
      !> What the search remembers.
      type(track_type), intent(out) :: track
      type(contact_point_type), intent(out) :: at
      real(wp) :: found, centre_a(3), centre_b(3), offset(3)
      integer :: i

      do i = 1, 200
         pose_a%position = random%vector(3)
         pose_a%rotation = rotation_matrix(random%vector(4))
         pose_b%rotation = rotation_matrix(random%vector(4))
         if (is_endless(a) .and. b%inside .or. a%inside .and. is_endless(b)) then
            pose_b%rotation = rotation_matrix([1.0_wp, 0.1_wp, 0.1_wp, 0.1_wp]*random%vector(4))
            pose_b%rotation = matmul(matmul(matmul(pose_a%rotation, a%frame), pose_b%rotation), &
               transpose(b%frame))
         end if
         centre_a = pose_a%position + matmul(pose_a%rotation, a%centre)
         centre_b = matmul(pose_b%rotation, b%centre)
         if (a%inside) then
            offset = matmul(pose_a%rotation, matmul(a%frame, start_in(a)))
         else if (b%inside) then
            offset = -matmul(pose_b%rotation, matmul(b%frame, start_in(b)))
         else
            offset = 4.0_wp*random%vector(3)
         end if
         pose_b%position = centre_a - centre_b + offset
         track = track_type()
         call geometry%gap(pose_a, pose_b, track, found)
         if (track%lost) cycle
         call geometry%locate(pose_a, pose_b, track, found, at)
         pose_b%position = pose_b%position + (gap - found)*at%normal
         track = track_type()
         call geometry%gap(pose_a, pose_b, track, found)
         if (track%lost) cycle
         call geometry%locate(pose_a, pose_b, track, found, at)
         if (.not. at%curvature_a > 0.02_wp*at%curvature_b) cycle
         ! Neither near an apex nor far away, nor nearly along a generator.
         if (at%curvature_b*min(scale_of(a), scale_of(b)) > 2.0_wp) cycle
         if (norm2(at%point - centre_a) > 10.0_wp) cycle
         if (a%is_outside_of("paraboloid") .or. b%is_outside_of("paraboloid")) then
            if (.not. at%curvature_a > 0.05_wp*at%curvature_b) cycle
         end if
         if (abs(found - gap) <= 1.0e-9_wp) return
      end do
      call check(.false., "a place is found for " // a%words() // " and " // b%words())

   contains

      !> Whether a surface is the outside of what opens along its axis.
      logical function is_endless(surface)
         type(surface_type), intent(in) :: surface

         is_endless = surface%is_outside_of("paraboloid")
      end function is_endless

      !> A place within a hollow.
      function start_in(surface) result(p)
         !> The hollow.
         type(surface_type), intent(in) :: surface
         real(wp) :: p(3)
         real(wp) :: angle

         p = 0.3_wp*scale_of(surface)*random%vector(3)
         angle = random%uniform(0.0_wp, 2.0_wp*pi)
         select type (shape => surface%shape)
         type is (torus_type)
            p = p + shape%major_radius*[cos(angle), sin(angle), 0.0_wp]
         type is (paraboloid_type)
            p(3) = p(3) + 1.2_wp*shape%vertex_radius
         type is (cone_type)
            p(3) = p(3) + 1.0_wp/sin(shape%half_angle)
         class default
            ! Its origin is in the middle.
         end select
      end function start_in

   end subroutine place

   !> Value of an implicit function, zero on the surface and positive outside of its shape, and its
   !> gradient: independent of those of the program.
   subroutine implicit(surface, pose, point, value, gradient)
      type(surface_type), intent(in) :: surface
      !> Pose of its body.
      type(pose_type), intent(in) :: pose
      !> Point, inertial frame [m].
      real(wp), intent(in) :: point(3)
      real(wp), intent(out) :: value
      !> The gradient, inertial frame.
      real(wp), intent(out) :: gradient(3)
      real(wp) :: p(3), g(3), rho

      p = matmul(transpose(surface%frame), matmul(transpose(pose%rotation), &
         point - pose%position) - surface%centre)
      select type (shape => surface%shape)
      type is (plane_type)
         value = p(3)
         g = [0.0_wp, 0.0_wp, 1.0_wp]
      type is (sphere_type)
         value = sum(p**2)/shape%radius**2 - 1.0_wp
         g = 2.0_wp*p/shape%radius**2
      type is (cylinder_type)
         value = sum(p(1:2)**2)/shape%radius**2 - 1.0_wp
         g = 2.0_wp*[p(1), p(2), 0.0_wp]/shape%radius**2
      type is (ellipsoid_type)
         value = sum((p/shape%semi_axes)**2) - 1.0_wp
         g = 2.0_wp*p/shape%semi_axes**2
      type is (torus_type)
         rho = hypot(p(1), p(2))
         value = ((rho - shape%major_radius)**2 + p(3)**2)/shape%radius**2 - 1.0_wp
         g(1:2) = 2.0_wp*(rho - shape%major_radius)*p(1:2)/rho/shape%radius**2
         g(3) = 2.0_wp*p(3)/shape%radius**2
      type is (paraboloid_type)
         value = sum(p(1:2)**2)/shape%vertex_radius - 2.0_wp*p(3)
         g = 2.0_wp*[p(1), p(2), -shape%vertex_radius]/shape%vertex_radius
      type is (cone_type)
         rho = hypot(p(1), p(2))
         value = rho - tan(shape%half_angle)*p(3)
         g = [p(1)/rho, p(2)/rho, -tan(shape%half_angle)]
      class default
         error stop "a shape without a test"
      end select
      gradient = matmul(pose%rotation, matmul(surface%frame, g))
   end subroutine implicit

   !> A small gap of either sign for a sample.
   function small_gap(random, a, b) result(gap)
      !> Source of random numbers.
      type(random_type), intent(inout) :: random
      type(surface_type), intent(in) :: a
      type(surface_type), intent(in) :: b
      real(wp) :: gap

      gap = 0.02_wp*random%uniform(-1.0_wp, 1.0_wp)*min(scale_of(a), scale_of(b))
   end function small_gap

   !> A length of a surface: of a hollow its radius of curvature where it is narrowest.
   function scale_of(surface) result(length)
      type(surface_type), intent(in) :: surface
      real(wp) :: length

      select type (shape => surface%shape)
      type is (plane_type)
         length = 1.0_wp
      type is (sphere_type)
         length = shape%radius
      type is (cylinder_type)
         length = shape%radius
      type is (ellipsoid_type)
         length = minval(shape%semi_axes)**2/maxval(shape%semi_axes)
      type is (torus_type)
         length = shape%radius
      type is (paraboloid_type)
         length = shape%vertex_radius
      type is (cone_type)
         length = 1.0_wp
      class default
         error stop "a shape without a test"
      end select
   end function scale_of

   !> Whether a surface is a plane.
   logical function is_plane(surface)
      type(surface_type), intent(in) :: surface

      is_plane = surface%is_outside_of("plane")
   end function is_plane

   !> The closest points lie on the surfaces, with a common normal that points from A into B, and
   !> the contact point lies midway or on the curved surface.
   subroutine test_points(kind)
      integer, intent(in) :: kind
      type(random_type) :: random
      type(surface_type) :: a, b
      class(geometry_type), allocatable :: geometry
      type(pose_type) :: pose_a, pose_b
      type(track_type) :: track
      type(contact_point_type) :: at
      type(worst_type) :: on_a, on_b, normal_a, normal_b, frame
      real(wp) :: share, value, gradient(3)
      integer :: i

      do i = 1, 300
         call draw(kind, random, a, b)
         call new_geometry(a, b, geometry)
         call place(a, b, geometry, small_gap(random, a, b), random, pose_a, pose_b, track, at)
         share = 0.5_wp
         if (is_plane(a)) share = 1.0_wp
         if (is_plane(b)) share = 0.0_wp
         call implicit(a, pose_a, at%point - share*at%gap*at%normal, value, gradient)
         call on_a%note(abs(value)/norm2(gradient), i)
         call normal_a%note(norm2(at%normal - merge(-1.0_wp, 1.0_wp, a%inside)*gradient &
            /norm2(gradient)), i)
         call implicit(b, pose_b, at%point + (1.0_wp - share)*at%gap*at%normal, value, gradient)
         call on_b%note(abs(value)/norm2(gradient), i)
         call normal_b%note(norm2(at%normal + merge(-1.0_wp, 1.0_wp, b%inside)*gradient &
            /norm2(gradient)), i)
         call frame%note(max(abs(norm2(at%normal) - 1.0_wp), abs(norm2(at%major) - 1.0_wp), &
            abs(dot_product(at%normal, at%major))), i)
      end do
      call on_a%check_below(2.0e-14_wp, trim(kinds(kind)) // ": the point of A is on A")
      call on_b%check_below(2.0e-14_wp, trim(kinds(kind)) // ": the point of B is on B")
      call normal_a%check_below(2.0e-13_wp, trim(kinds(kind)) // ": normal out of A")
      call normal_b%check_below(2.0e-13_wp, trim(kinds(kind)) // ": normal into B")
      call frame%check_below(4.0e-15_wp, trim(kinds(kind)) // ": unit vectors")
   end subroutine test_points

   !> Curvatures and major axis against second differences of the separation of the undeformed
   !> surfaces over the tangent plane.
   subroutine test_hessian(kind)
      integer, intent(in) :: kind
      type(random_type) :: random
      type(surface_type) :: a, b
      class(geometry_type), allocatable :: geometry
      type(pose_type) :: pose_a, pose_b
      type(track_type) :: track
      type(contact_point_type) :: at
      type(worst_type) :: worst_a, worst_b, worst_axis, worst_gap
      real(wp) :: h, minor(3), xx, yy, mixed
      integer :: i

      do i = 1, 200
         call draw(kind, random, a, b)
         call new_geometry(a, b, geometry)
         call place(a, b, geometry, small_gap(random, a, b), random, pose_a, pose_b, track, at)
         minor = cross(at%normal, at%major)
         h = 8.0e-3_wp*min(scale_of(a), scale_of(b))
         xx = second_difference(at%major)
         yy = second_difference(minor)
         mixed = second_difference((at%major + minor)/sqrt(2.0_wp)) - 0.5_wp*(xx + yy)
         call worst_a%note(abs(0.5_wp*xx/at%curvature_a - 1.0_wp), i)
         call worst_b%note(abs(0.5_wp*yy/at%curvature_b - 1.0_wp), i)
         ! In the axes of the spot the mixed derivative vanishes, on a circle in any axes.
         call worst_axis%note(abs(mixed)/(2.0_wp*at%curvature_b), i)
         call worst_gap%note(abs(separation([0.0_wp, 0.0_wp, 0.0_wp]) - at%gap), i)
      end do
      call worst_a%check_below(1.0e-7_wp, trim(kinds(kind)) // ": A is the curvature of the gap")
      call worst_b%check_below(1.0e-7_wp, trim(kinds(kind)) // ": B is the curvature of the gap")
      call worst_axis%check_below(1.0e-7_wp, trim(kinds(kind)) // ": the major axis is principal")
      call worst_gap%check_below(5.0e-14_wp, trim(kinds(kind)) // ": the gap is the separation")

   contains

      !> Second derivative of the separation along a tangent.
      function second_difference(tangent) result(d)
         real(wp), intent(in) :: tangent(3)
         real(wp) :: d

         real(wp), parameter :: weight(-3:3) = [2.0_wp, -27.0_wp, 270.0_wp, -490.0_wp, 270.0_wp, &
            -27.0_wp, 2.0_wp]/180.0_wp
         integer :: k

         d = 0.0_wp
         do k = -3, 3
            d = d + weight(k)*separation(k*h*tangent)
         end do
         d = d/h**2
      end function second_difference

      !> Distance of the surfaces along the normal above a point of the tangent plane.
      function separation(offset) result(d)
         !> The point, seen from the contact point.
         real(wp), intent(in) :: offset(3)
         real(wp) :: d

         d = level(b, pose_b, offset) - level(a, pose_a, offset)
      end function separation

      !> Height of a surface over the tangent plane.
      function level(surface, pose, offset) result(z)
         type(surface_type), intent(in) :: surface
         !> Pose of its body.
         type(pose_type), intent(in) :: pose
         !> The point, seen from the contact point.
         real(wp), intent(in) :: offset(3)
         real(wp) :: z
         real(wp) :: value, gradient(3)
         integer :: k

         z = 0.0_wp
         do k = 1, 12
            call implicit(surface, pose, at%point + offset + z*at%normal, value, gradient)
            z = z - value/dot_product(gradient, at%normal)
         end do
      end function level

   end subroutine test_hessian

   !> Variation against differences of the contact.
   subroutine test_variation(kind)
      integer, intent(in) :: kind
      type(random_type) :: random
      type(surface_type) :: a, b
      class(geometry_type), allocatable :: geometry
      type(pose_type) :: pose_a, pose_b
      type(track_type) :: track
      type(contact_point_type) :: at, near(4)
      type(contact_variation_type) :: variation
      type(worst_type) :: point, normal, turn, curvature_a, curvature_b
      real(wp) :: h, length, minor(3), scale, turned, angle(4)
      integer :: i, j, k

      do i = 1, 100
         call draw(kind, random, a, b)
         call new_geometry(a, b, geometry)
         call place(a, b, geometry, small_gap(random, a, b), random, pose_a, pose_b, track, at)
         call geometry%vary(pose_a, pose_b, track, at, variation)
         minor = cross(at%normal, at%major)
         ! Lengths in units of the smaller radius, curvatures of the larger curvature.
         length = min(scale_of(a), scale_of(b))
         do j = 1, 6
            h = 1.0e-4_wp
            scale = 1.0_wp
            if (j <= 3) h = h*length
            if (j <= 3) scale = length
            do k = 1, 4
               call moved(j, merge(k - 3, k - 2, k <= 2)*h, near(k))
            end do
            call point%note(maxval(abs(variation%point(:, j) - difference3(near(1)%point, &
               near(2)%point, near(3)%point, near(4)%point)))*scale/length, i)
            call normal%note(maxval(abs(variation%normal(:, j) - difference3(near(1)%normal, &
               near(2)%normal, near(3)%normal, near(4)%normal)))*scale, i)
            call curvature_a%note(abs(variation%curvature_a(j) - difference(near%curvature_a)) &
               *scale*length, i)
            call curvature_b%note(abs(variation%curvature_b(j) - difference(near%curvature_b)) &
               *scale*length, i)
            if (at%curvature_b - at%curvature_a < 0.05_wp*at%curvature_b) cycle
            do k = 1, 4
               if (dot_product(near(k)%major, at%major) < 0.0_wp) near(k)%major = -near(k)%major
               angle(k) = dot_product(near(k)%major, minor)
            end do
            turned = difference(angle)
            call turn%note(abs(variation%turn(j) - turned)*scale, i)
         end do
      end do
      call point%check_below(1.0e-7_wp, trim(kinds(kind)) // ": variation of the point")
      call normal%check_below(1.0e-7_wp, trim(kinds(kind)) // ": variation of the normal")
      call curvature_a%check_below(1.0e-7_wp, trim(kinds(kind)) // ": variation of A")
      call curvature_b%check_below(1.0e-7_wp, trim(kinds(kind)) // ": variation of B")
      if (turn%sample > 0) call turn%check_below(1.0e-6_wp, trim(kinds(kind)) // &
         ": variation of the axis")

   contains

      !> The contact after a twist of B about the contact point.
      subroutine moved(component, amount, contact)
         !> Component of the twist.
         integer, intent(in) :: component
         !> Its size [m or rad].
         real(wp), intent(in) :: amount
         type(contact_point_type), intent(out) :: contact
         type(pose_type) :: pose
         type(track_type) :: copy
         real(wp) :: e(3), rotation(3, 3), found

         e = 0.0_wp
         pose = pose_b
         if (component <= 3) then
            e(component) = amount
            pose%position = pose%position + e
         else
            e(component - 3) = 1.0_wp
            rotation = rotation_matrix(quaternion_from_axis_angle(e, amount))
            pose%rotation = matmul(rotation, pose%rotation)
            pose%position = at%point + matmul(rotation, pose%position - at%point)
         end if
         copy = track
         call geometry%gap(pose_a, pose, copy, found)
         call geometry%locate(pose_a, pose, copy, found, contact)
      end subroutine moved

      !> Derivative from values at -2h, -h, h, 2h.
      pure function difference(values) result(d)
         real(wp), intent(in) :: values(4)
         real(wp) :: d

         d = (values(1) - 8.0_wp*values(2) + 8.0_wp*values(3) - values(4))/(12.0_wp*h)
      end function difference

      !> Derivative of a vector.
      pure function difference3(v1, v2, v3, v4) result(d)
         !> Vector at -2h.
         real(wp), intent(in) :: v1(3)
         !> Vector at -h.
         real(wp), intent(in) :: v2(3)
         !> Vector at h.
         real(wp), intent(in) :: v3(3)
         !> Vector at 2h.
         real(wp), intent(in) :: v4(3)
         real(wp) :: d(3)

         d = (v1 - 8.0_wp*v2 + 8.0_wp*v3 - v4)/(12.0_wp*h)
      end function difference3

   end subroutine test_variation

   !> The search against closed forms, near contact and far from it.
   subroutine test_search(kind)
      integer, intent(in) :: kind
      type(random_type) :: random
      type(surface_type) :: a, b
      class(geometry_type), allocatable :: geometry
      class(geometry_type), allocatable :: searched
      type(pose_type) :: pose_a, pose_b
      type(track_type) :: track, other
      type(contact_point_type) :: at, found
      type(worst_type) :: gap, point, normal, curvature, lost
      real(wp) :: distance, target
      integer :: i

      do i = 1, 2000
         call draw(kind, random, a, b)
         call new_geometry(a, b, geometry)
         call new_searched_pair(a, b, .true., searched)
         target = small_gap(random, a, b)
         if (modulo(i, 4) == 0) target = 20.0_wp*abs(target)
         call place(a, b, geometry, target, random, pose_a, pose_b, track, at)
         other = track_type()
         call searched%gap(pose_a, pose_b, other, distance)
         call searched%locate(pose_a, pose_b, other, distance, found)
         call lost%note(merge(1.0_wp, 0.0_wp, other%lost), i)
         call gap%note(abs(distance - at%gap), i)
         call point%note(norm2(found%point - at%point), i)
         call normal%note(norm2(found%normal - at%normal), i)
         call curvature%note(max(abs(found%curvature_a - at%curvature_a), &
            abs(found%curvature_b - at%curvature_b))/at%curvature_b, i)
      end do
      call lost%check_below(0.0_wp, trim(kinds(kind)) // ": the search is never lost")
      call gap%check_below(2.0e-14_wp, trim(kinds(kind)) // ": searched gap")
      call point%check_below(1.0e-12_wp, trim(kinds(kind)) // ": searched point")
      call normal%check_below(1.0e-12_wp, trim(kinds(kind)) // ": searched normal")
      call curvature%check_below(1.0e-12_wp, trim(kinds(kind)) // ": searched curvatures")
   end subroutine test_search

   !> No pair of points of the surfaces is closer than the gap of open surfaces, and a descent over
   !> pairs of points comes close to it.
   subroutine test_brute(kind)
      integer, intent(in) :: kind
      type(random_type) :: random
      type(surface_type) :: a, b
      class(geometry_type), allocatable :: geometry
      type(pose_type) :: pose_a, pose_b
      type(track_type) :: track
      type(contact_point_type) :: at
      type(worst_type) :: below, above
      real(wp) :: target, best, u(4), trial(4), d, width, scale
      integer :: i, j, start

      do i = 1, 12
         call draw(kind, random, a, b)
         call new_geometry(a, b, geometry)
         scale = min(scale_of(a), scale_of(b))
         target = scale*random%uniform(0.02_wp, 0.3_wp)
         call place(a, b, geometry, target, random, pose_a, pose_b, track, at)
         best = huge(best)
         do start = 1, 6
            u = random_parameters()
            d = apart(u)
            do j = 1, 300
               trial = random_parameters()
               if (apart(trial) >= d) cycle
               u = trial
               d = apart(u)
            end do
            call descend()
            best = min(best, d)
         end do
         call below%note((at%gap - best)/scale, i)
         call above%note((best - at%gap)/scale, i)
      end do
      call below%check_below(1.0e-12_wp, trim(kinds(kind)) // ": no two points are closer")
      call above%check_below(1.0e-3_wp, trim(kinds(kind)) // ": two points are as close")

   contains

      !> Descent by trial steps along the parameters, and along what several of them did together.
      subroutine descend()
         real(wp) :: last(4), before
         integer :: k, l, round

         width = 0.3_wp
         do round = 1, 4000
            if (width < 1.0e-5_wp) exit
            last = u
            before = d
            do k = 1, 4
               do l = -1, 1, 2
                  trial = u
                  trial(k) = trial(k) + l*width
                  if (apart(trial) >= d) cycle
                  u = trial
                  d = apart(u)
               end do
            end do
            ! The valley along a generator is narrow.
            if (index(kinds(kind), "funnel") > 0) then
               do k = 1, 20
                  trial = u + width*random%vector(4)
                  if (apart(trial) >= d) cycle
                  u = trial
                  d = apart(u)
               end do
            end if
            if (d >= before) then
               width = 0.5_wp*width
               cycle
            end if
            do k = 1, 30
               trial = 2.0_wp*u - last
               if (apart(trial) >= d) exit
               last = u
               u = trial
               d = apart(u)
            end do
         end do
      end subroutine descend

      !> Parameters of a point of each surface.
      function random_parameters() result(v)
         real(wp) :: v(4)

         v = pi*random%vector(4)
      end function random_parameters

      !> Distance of two points of the surfaces.
      function apart(v) result(length)
         !> Their parameters.
         real(wp), intent(in) :: v(4)
         real(wp) :: length

         length = norm2(point_of(a, pose_a, v(1:2)) - point_of(b, pose_b, v(3:4)))
      end function apart

      !> Point of a surface.
      function point_of(surface, pose, v) result(p)
         type(surface_type), intent(in) :: surface
         !> Pose of its body.
         type(pose_type), intent(in) :: pose
         !> Its parameters.
         real(wp), intent(in) :: v(2)
         real(wp) :: p(3)
         real(wp) :: q(3), ball(3)

         ball = [cos(v(1))*cos(v(2)), sin(v(1))*cos(v(2)), sin(v(2))]
         select type (shape => surface%shape)
         type is (plane_type)
            q = [4.0_wp*v(1), 4.0_wp*v(2), 0.0_wp]
         type is (sphere_type)
            q = shape%radius*ball
         type is (cylinder_type)
            q = [shape%radius*cos(v(1)), shape%radius*sin(v(1)), 4.0_wp*v(2)]
         type is (ellipsoid_type)
            q = shape%semi_axes*ball
         type is (torus_type)
            q = (shape%major_radius + shape%radius*cos(v(2)))*[cos(v(1)), sin(v(1)), 0.0_wp]
            q(3) = shape%radius*sin(v(2))
         type is (paraboloid_type)
            q = [2.0_wp*v(2)*cos(v(1)), 2.0_wp*v(2)*sin(v(1)), 2.0_wp*v(2)**2/shape%vertex_radius]
         type is (cone_type)
            q = 4.0_wp*abs(v(2))*sin(shape%half_angle)*[cos(v(1)), sin(v(1)), 0.0_wp]
            q(3) = 4.0_wp*abs(v(2))*cos(shape%half_angle)
         class default
            error stop "a shape without a test"
         end select
         p = pose%position + matmul(pose%rotation, surface%centre + matmul(surface%frame, q))
      end function point_of

   end subroutine test_brute

   !> A motion followed from step to step gives what searches from nothing give, as long as the
   !> surfaces are apart or convex, and the major axis turns without jumps.
   subroutine test_tracking(kind)
      integer, intent(in) :: kind
      type(random_type) :: random
      type(surface_type) :: a, b
      class(geometry_type), allocatable :: geometry
      type(pose_type) :: pose_a, pose_b
      type(track_type) :: track, fresh
      type(contact_point_type) :: at, last
      type(worst_type) :: gap, lost, jump
      real(wp) :: scale, found, cold, axis(3), turn(3, 3), drift(3)
      integer :: i, j
      logical :: convex, endless

      do i = 1, 20
         call draw(kind, random, a, b)
         call new_geometry(a, b, geometry)
         convex = .not. (a%inside .or. b%inside .or. a%is_outside_of("torus") .or. &
            b%is_outside_of("torus"))
         endless = index(kinds(kind), "paraboloid") + index(kinds(kind), "cone") + &
            index(kinds(kind), "dish") + index(kinds(kind), "funnel") > 0
         scale = min(scale_of(a), scale_of(b))
         call place(a, b, geometry, 0.01_wp*scale, random, pose_a, pose_b, track, at)
         axis = random%vector(3)
         turn = rotation_matrix(quaternion_from_axis_angle(axis, 0.01_wp))
         drift = 0.01_wp*scale*random%vector(3)
         do j = 1, 200
            last = at
            pose_b%rotation = matmul(turn, pose_b%rotation)
            pose_b%position = at%point + matmul(turn, pose_b%position - at%point) + drift
            call geometry%gap(pose_a, pose_b, track, found)
            call geometry%locate(pose_a, pose_b, track, found, at)
            pose_b%position = pose_b%position &
               + (0.01_wp*scale*cos(0.1_wp*j) - found)*at%normal
            call geometry%gap(pose_a, pose_b, track, found)
            call geometry%locate(pose_a, pose_b, track, found, at)
            ! Far out or near an apex.
            if (endless .and. .not. (at%curvature_a > 0.05_wp*at%curvature_b .and. &
               at%curvature_b*scale < 2.0_wp)) exit
            call lost%note(merge(1.0_wp, 0.0_wp, track%lost), i)
            fresh = track_type()
            call geometry%gap(pose_a, pose_b, fresh, cold)
            if (convex .or. found > 0.0_wp) then
               call gap%note(abs(found - cold)/scale, i)
            else
               call gap%note((cold - found)/scale, i)
            end if
            ! Where the contact has jumped to another place nothing can be said.
            if (norm2(at%point - last%point) > 0.1_wp*scale) cycle
            if (at%curvature_b - at%curvature_a < 0.3_wp*at%curvature_b) cycle
            call jump%note(1.0_wp - abs(dot_product(at%major, last%major)), i)
            ! Surfaces that come to conform are no longer a contact.
            if (.not. at%curvature_a > 0.02_wp*at%curvature_b) exit
         end do
      end do
      call lost%check_below(0.0_wp, trim(kinds(kind)) // ": a motion is never lost")
      call gap%check_below(5.0e-14_wp, trim(kinds(kind)) // ": followed and searched anew")
      if (jump%sample > 0) call jump%check_below(0.1_wp, trim(kinds(kind)) // &
         ": the major axis does not jump")
   end subroutine test_tracking

   !> Poses without a unique normal give a finite gap, at most a lost search, and never a NaN.
   subroutine test_degenerate()
      type(surface_type) :: ball, socket, bore, groove, egg, rod, ring, pip, cone, dish, plane
      type(pose_type) :: rest

      ball%shape = sphere_type(0.5_wp)
      socket%shape = sphere_type(2.0_wp)
      socket%inside = .true.
      bore%shape = cylinder_type(2.0_wp)
      bore%inside = .true.
      groove%shape = torus_type(3.0_wp, 0.75_wp)
      groove%inside = .true.
      egg%shape = ellipsoid_type([1.0_wp, 2.0_wp, 3.0_wp])
      rod%shape = cylinder_type(1.0_wp)
      ring%shape = torus_type(3.0_wp, 0.25_wp)
      call expect(ball, socket, 1.5_wp, "ball at the centre of a socket")
      call expect(ball, ball, -1.0_wp, "balls at one place")
      call expect(ball, bore, 1.5_wp, "ball on the axis of a bore")
      call expect(ball, rod, -1.5_wp, "ball on the axis of a cylinder")
      call expect(ball, ring, 2.25_wp, "ball at the centre of a ring")
      call expect(ball, egg, -1.5_wp, "ball at the centre of an ellipsoid")
      call expect(rod, rod, -2.0_wp, "cylinders at one place")
      ball%centre = [3.0_wp, 0.0_wp, 0.0_wp]
      call expect(ball, groove, 0.25_wp, "ball at the centre of a groove")
      call expect(ball, ring, -0.75_wp, "ball at the centre of a tube")
      egg%centre = [0.0_wp, 0.0_wp, 5.5_wp]
      call expect(egg, ring, norm2([1.0_wp, 1.0_wp]), "ellipsoid above a ring", any_value=.true.)
      egg%centre = 0.0_wp
      call expect(egg, egg, 0.0_wp, "ellipsoids at one place", any_value=.true., lost=.true.)
      call expect(egg, rod, 0.0_wp, "ellipsoid on the axis of a cylinder", any_value=.true., &
         lost=.true.)
      call expect(ring, ring, 0.0_wp, "rings at one place", any_value=.true., lost=.true.)
      pip%shape = ellipsoid_type([0.1_wp, 0.2_wp, 0.3_wp])
      pip%centre = 0.2_wp
      call expect(egg, pip, 0.0_wp, "ellipsoid within an ellipsoid", any_value=.true., lost=.true.)
      call expect(pip, egg, 0.0_wp, "ellipsoid around an ellipsoid", any_value=.true.)
      call expect(ring, rod, 1.75_wp, "ring about a cylinder")
      cone%shape = cone_type(pi/6.0_wp)
      dish%shape = paraboloid_type(2.0_wp)
      dish%inside = .true.
      ball%centre = [0.0_wp, 0.0_wp, 2.0_wp]
      call expect(ball, dish, 1.5_wp, "ball at the centre of curvature of a dish")
      call expect(ball, cone, -1.5_wp, "ball on the axis of a cone")
      ball%centre = [0.0_wp, 0.0_wp, -2.0_wp]
      call expect(ball, cone, 1.5_wp, "ball before an apex")
      ball%centre = 0.0_wp
      call expect(ball, cone, -0.5_wp, "ball around an apex")
      egg%centre = [0.0_wp, 0.0_wp, -3.5_wp]
      call expect(cone, egg, 0.5_wp, "ellipsoid before an apex", tolerance=1.0e-9_wp)
      call expect(egg, cone, 0.5_wp, "apex behind an ellipsoid", tolerance=1.0e-9_wp)
      rod%centre = [0.0_wp, 0.0_wp, -1.5_wp]
      rod%frame = frame_along([0.0_wp, 1.0_wp, 0.0_wp])
      call expect(cone, rod, 0.5_wp, "cylinder before an apex", tolerance=1.0e-9_wp)
      rod%frame = frame_along([0.0_wp, 0.0_wp, 1.0_wp])
      call expect(cone, rod, 0.0_wp, "cylinder along a cone", any_value=.true.)
      dish%inside = .false.
      call expect(dish, rod, 0.0_wp, "cylinder along a paraboloid", any_value=.true., lost=.true.)
      plane%shape = plane_type()
      call expect(plane, dish, 0.0_wp, "paraboloid on its vertex")
      plane%frame = frame_along([0.0_wp, 0.0_wp, -1.0_wp])
      call expect(plane, dish, 0.0_wp, "paraboloid into a plane", any_value=.true., lost=.true.)

   contains

      !> Check the gap of two surfaces at rest.
      subroutine expect(a, b, value, name, any_value, lost, tolerance)
         type(surface_type), intent(in) :: a
         type(surface_type), intent(in) :: b
         !> Its value [m].
         real(wp), intent(in) :: value
         !> What is checked.
         character(len=*), intent(in) :: name
         !> Whether any finite value will do.
         logical, intent(in), optional :: any_value
         !> Whether the search must be lost, with a negative gap.
         logical, intent(in), optional :: lost
         !> Of the gap where there is no common normal to search for [m].
         real(wp), intent(in), optional :: tolerance
         class(geometry_type), allocatable :: geometry
         type(track_type) :: track
         type(contact_point_type) :: at
         real(wp) :: gap, bound

         bound = 1.0e-14_wp
         if (present(tolerance)) bound = tolerance
         call new_geometry(a, b, geometry)
         call geometry%gap(rest, rest, track, gap)
         if (.not. track%lost) then
            call geometry%locate(rest, rest, track, gap, at)
            call check_close(norm2(at%normal), 1.0_wp, 1.0e-14_wp, name // ": normal")
            call check(all(ieee_is_finite(at%point)) .and. all(ieee_is_finite(at%major)), &
               name // ": point and axis")
         end if
         if (present(any_value)) then
            call check(ieee_is_finite(gap), name // ": gap")
            if (present(lost)) call check((track%lost .eqv. lost) .and. gap <= 0.0_wp, &
               name // ": lost")
         else
            call check(.not. track%lost, name // ": found")
            call check_close(gap, value, bound, name // ": gap")
         end if
      end subroutine expect

   end subroutine test_degenerate

   !> Conforming surfaces are reported where they overlap, others are not.
   subroutine test_conforming()
      type(surface_type) :: plane, rod, ring, ball, hollow, funnel, cone, egg
      type(pose_type) :: rest, other

      plane%shape = plane_type()
      rod%shape = cylinder_type(1.0_wp)
      ring%shape = torus_type(3.0_wp, 0.25_wp)
      ball%shape = sphere_type(1.0_wp)
      hollow%shape = ellipsoid_type([4.0_wp, 4.0_wp, 1.2_wp])
      hollow%inside = .true.
      other%position = [1.99_wp, 0.0_wp, 0.0_wp]
      call expect(rod, rod, trouble_conforming, "parallel cylinders")
      other%rotation = rotation_matrix(quaternion_from_axis_angle([1.0_wp, 0.0_wp, 0.0_wp], 0.5_wp))
      call expect(rod, rod, trouble_none, "crossed cylinders")
      other%rotation = rest%rotation
      other%position = [0.0_wp, 0.0_wp, 0.24_wp]
      call expect(plane, ring, trouble_conforming, "a ring that lies flat")
      other%rotation = frame_along([1.0_wp, 0.0_wp, 0.0_wp])
      other%position = [0.0_wp, 0.0_wp, 3.24_wp]
      call expect(plane, ring, trouble_none, "a ring that stands")
      other%rotation = rest%rotation
      other%position = [0.0_wp, 0.0_wp, -0.21_wp]
      call expect(hollow, ball, trouble_none, "a ball at the bottom of a hollow")
      funnel%shape = cone_type(pi/6.0_wp)
      funnel%inside = .true.
      other%position = [0.0_wp, 0.0_wp, 1.99_wp]
      call expect(funnel, ball, trouble_conforming, "a ball in the middle of a funnel")
      other%position = [0.3_wp, 0.0_wp, 2.4_wp]
      call expect(funnel, ball, trouble_none, "a ball on the side of a funnel")
      cone%shape = cone_type(pi/6.0_wp)
      other%position = [0.01_wp, 0.0_wp, -0.99_wp]
      call expect(cone, ball, trouble_apex, "a ball on an apex")
      egg%shape = ellipsoid_type([1.1_wp, 1.2_wp, 1.0_wp])
      call expect(cone, egg, trouble_apex, "an ellipsoid on an apex")
      rod%frame = frame_along([0.0_wp, 1.0_wp, 0.0_wp])
      call expect(cone, rod, trouble_apex, "a cylinder on an apex")
      other%position = [1.1_wp, 0.0_wp, 0.1_wp]
      call expect(cone, ball, trouble_none, "a ball on the side of a cone")
      call check(trouble_text(trouble_apex) == "the apex of the cone touches, where its " // &
         "surface has no curvature", "an apex in words")
      call check(trouble_text(trouble_conforming) == "the surfaces conform: they touch along " // &
         "a line or an area, not in a point", "conforming surfaces in words")

   contains

      !> Check what is wrong with a contact.
      subroutine expect(a, b, trouble, name)
         type(surface_type), intent(in) :: a
         type(surface_type), intent(in) :: b
         !> What should be wrong.
         integer, intent(in) :: trouble
         !> What is checked.
         character(len=*), intent(in) :: name
         class(geometry_type), allocatable :: geometry
         type(track_type) :: track
         type(contact_point_type) :: at
         real(wp) :: gap

         call new_geometry(a, b, geometry)
         call geometry%gap(rest, other, track, gap)
         call geometry%locate(rest, other, track, gap, at)
         call check(gap < 0.0_wp, name // ": overlap")
         call check(contact_trouble(track, at) == trouble, name // ": trouble")
      end subroutine expect

   end subroutine test_conforming

   !> Pairs that are refused, with the reason.
   subroutine test_refusals()
      type(surface_type) :: plane, ball, rod, socket, bore, groove, egg, hollow, ring, dish, &
         funnel, bowl, cone

      plane%shape = plane_type()
      ball%shape = sphere_type(0.02_wp)
      rod%shape = cylinder_type(0.001_wp)
      socket%shape = sphere_type(0.01_wp)
      socket%inside = .true.
      bore%shape = cylinder_type(0.02_wp)
      bore%inside = .true.
      groove%shape = torus_type(0.1_wp, 0.01_wp)
      groove%inside = .true.
      egg%shape = ellipsoid_type([0.04_wp, 0.01_wp, 0.03_wp])
      hollow = egg
      hollow%inside = .true.
      ring%shape = torus_type(0.03_wp, 0.02_wp)
      call refused(plane, plane, "two planes never touch in a point")
      call refused(plane, rod, "a cylinder on a plane touches along a line, not in a point")
      call refused(rod, plane, "a cylinder on a plane touches along a line, not in a point")
      call refused(socket, plane, "a plane does not touch the inside of a sphere in a point")
      call refused(socket, bore, "the inside of a sphere and the inside of a cylinder are " // &
         "both concave and never touch")
      call refused(rod, bore, "a cylinder, which has no ends, does not touch the inside of a " // &
         "cylinder in a point")
      call refused(ball, socket, "a sphere of radius 0.02 m does not fit into the hollow of " // &
         "radius 0.01 m of a sphere: conforming contact")
      call refused(bore, ball, "a sphere of radius 0.02 m does not fit into the bore of " // &
         "radius 0.02 m of a cylinder: conforming contact")
      call refused(ball, groove, "a sphere of radius 0.02 m does not fit into the groove of " // &
         "radius 0.01 m of a torus: conforming contact")
      call refused(egg, groove, "an ellipsoid with a semi-axis of 0.03 m does not fit into " // &
         "the groove of radius 0.01 m of a torus: conforming contact")
      call refused(egg, socket, "an ellipsoid with a semi-axis of 0.04 m does not fit into " // &
         "the hollow of radius 0.01 m of a sphere: conforming contact")
      call refused(egg, hollow, "an ellipsoid with a semi-axis of 0.01 m does not fit into " // &
         "the hollow of 0.01 m of an ellipsoid: conforming contact")
      call refused(ring, bore, "a torus of outer radius 0.05 m does not fit into the bore of " // &
         "radius 0.02 m of a cylinder: conforming contact")
      call refused(groove, ring, "a torus with a tube of radius 0.02 m does not fit into the " // &
         "groove of radius 0.01 m of a torus: conforming contact")
      dish%shape = paraboloid_type(0.02_wp)
      dish%inside = .true.
      funnel%shape = cone_type(0.5_wp)
      funnel%inside = .true.
      bowl = dish
      bowl%inside = .false.
      cone = funnel
      cone%inside = .false.
      call refused(ball, dish, "a sphere of radius 0.02 m does not fit into the dish with a " // &
         "vertex radius of 0.02 m of a paraboloid: conforming contact")
      call refused(dish, egg, "an ellipsoid with ends of radius 0.0225 m does not fit into " // &
         "the dish with a vertex radius of 0.02 m of a paraboloid: conforming contact")
      call refused(ring, dish, "a torus of outer radius 0.05 m does not fit into the dish " // &
         "with a vertex radius of 0.02 m of a paraboloid: conforming contact")
      call refused(cone, plane, "a cone on a plane touches along a line or at its apex, not " // &
         "in a point with a curvature")
      call refused(cone, cone, "a cone and a cone have no radius to compare an overlap with")
      call refused(cone, funnel, "a cone, which has no end, does not touch the inside of a " // &
         "cone in a point")
      call refused(dish, bowl, "a paraboloid, which has no end, does not touch the inside of " // &
         "a paraboloid in a point")
      call refused(dish, funnel, "the inside of a paraboloid and the inside of a cone are " // &
         "both concave and never touch")
      ball%shape = sphere_type(0.1_wp)
      call refused(ball, hollow, "a sphere of radius 0.1 m does not fit into the hollow of " // &
         "0.09 m of an ellipsoid: conforming contact")

   contains

      !> Check that a pair is refused.
      subroutine refused(a, b, reason)
         type(surface_type), intent(in) :: a
         type(surface_type), intent(in) :: b
         character(len=*), intent(in) :: reason
         class(geometry_type), allocatable :: geometry
         character(len=:), allocatable :: problem

         call new_geometry(a, b, geometry, problem)
         call check(.not. allocated(geometry) .and. allocated(problem), "refused: " // reason)
         if (.not. allocated(problem)) return
         call check(problem == reason, "in the words: " // reason // ", found: " // problem)
      end subroutine refused

   end subroutine test_refusals

   !> Scale of the overlaps.
   subroutine test_scale()
      type(surface_type) :: plane, ball, groove, egg, ring, socket, cone, dish

      plane%shape = plane_type()
      ball%shape = sphere_type(0.5_wp)
      groove%shape = torus_type(4.0_wp, 0.625_wp)
      groove%inside = .true.
      egg%shape = ellipsoid_type([1.0_wp, 2.0_wp, 1.5_wp])
      ring%shape = torus_type(1.0_wp, 0.75_wp)
      socket%shape = sphere_type(1.0_wp)
      socket%inside = .true.
      call expect(plane, ball, 0.5_wp, "plane and ball")
      call expect(ball, ball, 0.5_wp, "two balls")
      call expect(groove, ball, 0.1_wp, "ball in a groove")
      call expect(ball, socket, 0.25_wp, "ball in a socket")
      call expect(egg, plane, 0.5_wp, "ellipsoid")
      call expect(egg, ring, 0.25_wp, "ring with a narrow hole")
      cone%shape = cone_type(0.5_wp)
      dish%shape = paraboloid_type(0.25_wp)
      call expect(ball, cone, 0.5_wp, "ball on a cone")
      call expect(dish, cone, 0.25_wp, "paraboloid on a cone")
      cone%inside = .true.
      call expect(cone, ball, 0.5_wp, "ball in a funnel")
      dish%shape = paraboloid_type(1.0_wp)
      dish%inside = .true.
      call expect(dish, ball, 0.25_wp, "ball in a dish")

   contains

      !> Check the scale of a pair.
      subroutine expect(a, b, scale, name)
         type(surface_type), intent(in) :: a
         type(surface_type), intent(in) :: b
         !> The scale [m].
         real(wp), intent(in) :: scale
         !> What is checked.
         character(len=*), intent(in) :: name
         class(geometry_type), allocatable :: geometry

         call new_geometry(a, b, geometry)
         call check_close(geometry%smallest_radius(), scale, 1.0e-15_wp, "scale: " // name)
      end subroutine expect

   end subroutine test_scale

end module test_geometry
