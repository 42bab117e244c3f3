!> What rolls: the velocity of the material through the spot, against cases known in closed form.
module test_rolling
   use contensou_base_kinds, only : wp
   use contensou_base_vectors, only : cross
   use contensou_contact_geometry, only : contact_point_type, contact_variation_type, &
      geometry_type, pose_type, rolling_velocity, track_type
   use contensou_contact_pairs, only : new_geometry
   use contensou_contact_shapes_cone, only : cone_type
   use contensou_contact_shapes_cylinder, only : cylinder_type
   use contensou_contact_shapes_ellipsoid, only : ellipsoid_type
   use contensou_contact_shapes_plane, only : plane_type
   use contensou_contact_shapes_shape, only : shape_type
   use contensou_contact_shapes_sphere, only : sphere_type
   use contensou_contact_shapes_torus, only : torus_type
   use contensou_contact_surface, only : surface_type
   use test_harness, only : check_close
   implicit none(type, external)
   private

   public :: run_rolling_tests

   !> Frames whose third axis, that of a shape, is along x, y or z.
   real(wp), parameter :: along_x(3, 3) = reshape([0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
      1.0_wp, 1.0_wp, 0.0_wp, 0.0_wp], [3, 3])
   real(wp), parameter :: along_y(3, 3) = reshape([0.0_wp, 0.0_wp, 1.0_wp, 1.0_wp, 0.0_wp, &
      0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp], [3, 3])
   real(wp), parameter :: along_z(3, 3) = reshape([1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, &
      0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [3, 3])

   !> Overlap of the pairs [m]: it changes the rolling velocity by about its ratio to the radii.
   real(wp), parameter :: overlap = 1.0e-13_wp

contains

   !> All tests of this suite.
   subroutine run_rolling_tests()
      call test_on_plane()
      call test_spheres()
      call test_ball_in_groove()
      call test_barrel()
      call test_roller_in_ring()
      call test_wheel_on_rail()
   end subroutine run_rolling_tests

   !> A surface.
   function surface_of(shape, frame, inside) result(surface)
      class(shape_type), intent(in) :: shape
      real(wp), intent(in) :: frame(3, 3)
      logical, intent(in) :: inside
      type(surface_type) :: surface

      surface%shape = shape
      surface%frame = frame
      surface%inside = inside
   end function surface_of

   !> Check the rolling velocity of B on A, and in the other order.
   subroutine check_rolling(a, b, pose_a, pose_b, expected, what)
      type(surface_type), intent(in) :: a
      type(surface_type), intent(in) :: b
      type(pose_type), intent(in) :: pose_a
      type(pose_type), intent(in) :: pose_b
      !> What the velocity of the material through the spot is [m/s].
      real(wp), intent(in) :: expected(3)
      character(len=*), intent(in) :: what

      call check_order(a, b, pose_a, pose_b, what)
      call check_order(b, a, pose_b, pose_a, what // ", reversed")

   contains

      !> Check it in one order.
      subroutine check_order(first, second, pose, other, name)
         type(surface_type), intent(in) :: first
         type(surface_type), intent(in) :: second
         !> Pose of the first.
         type(pose_type), intent(in) :: pose
         !> Pose of the second.
         type(pose_type), intent(in) :: other
         character(len=*), intent(in) :: name
         class(geometry_type), allocatable :: geometry
         type(track_type) :: track
         type(contact_point_type) :: at
         type(contact_variation_type) :: variation
         real(wp) :: gap, velocity(3), rolling(3)

         call new_geometry(first, second, geometry)
         call geometry%gap(pose, other, track, gap)
         call check_close(gap, -overlap, 2.0e-15_wp, name // ": overlap")
         call geometry%locate(pose, other, track, gap, at)
         call geometry%vary(pose, other, track, at, variation)
         velocity = other%velocity + cross(other%spin, at%point - other%position) &
            - pose%velocity - cross(pose%spin, at%point - pose%position)
         rolling = rolling_velocity(variation, velocity, other%spin - pose%spin)
         rolling = rolling - dot_product(rolling, at%normal)*at%normal
         call check_close(norm2(rolling - expected), 0.0_wp, 1.0e-9_wp*max(1.0_wp, &
            norm2(expected)), name // ": rolling velocity")
      end subroutine check_order

   end subroutine check_rolling

   !> A ball on a plane that moves, with slip and spin: the spot goes with the centre.
   subroutine test_on_plane()
      real(wp), parameter :: r = 0.2_wp
      type(pose_type) :: plane, ball

      plane%velocity = [0.3_wp, -0.1_wp, 0.0_wp]
      ball%position = [0.4_wp, 0.5_wp, r - overlap]
      ball%velocity = [1.7_wp, 0.6_wp, 0.0_wp]
      ball%spin = [2.0_wp, 5.0_wp, 7.0_wp]
      call check_rolling(surface_of(plane_type(), along_z, .false.), surface_of(sphere_type(r), &
         along_z, .false.), plane, ball, -0.5_wp*[ball%velocity(1) - plane%velocity(1) &
         + r*ball%spin(2), ball%velocity(2) - plane%velocity(2) - r*ball%spin(1), 0.0_wp], &
         "ball on plane")
   end subroutine test_on_plane

   !> Two spheres that roll on each other like gears: the spot is at rest.
   subroutine test_spheres()
      real(wp), parameter :: r1 = 0.3_wp, r2 = 0.1_wp, w = 4.0_wp
      type(pose_type) :: first, second

      first%spin = [0.0_wp, 0.0_wp, w]
      second%spin = [0.0_wp, 0.0_wp, -w*r1/r2]
      second%position = [r1 + r2 - overlap, 0.0_wp, 0.0_wp]
      call check_rolling(surface_of(sphere_type(r1), along_z, .false.), &
         surface_of(sphere_type(r2), along_z, .false.), first, second, [0.0_wp, w*r1, 0.0_wp], &
         "two spheres")
      ! The second runs around the first, which is at rest.
      first%spin = 0.0_wp
      second%spin = [0.0_wp, 0.0_wp, w]
      second%velocity = [0.0_wp, w*r2, 0.0_wp]
      call check_rolling(surface_of(sphere_type(r1), along_z, .false.), &
         surface_of(sphere_type(r2), along_z, .false.), first, second, &
         [0.0_wp, -w*r2*r1/(r1 + r2), 0.0_wp], "sphere around sphere")
   end subroutine test_spheres

   !> A ball in the groove of an outer ring: along the groove the ring turns about it; across, the
   !> spot runs up faster than the ball by r/(r - R).
   subroutine test_ball_in_groove()
      real(wp), parameter :: ring_radius = 0.05_wp, tube = 0.0104_wp, r = 0.01_wp, w = 30.0_wp
      type(pose_type) :: ring, ball
      type(surface_type) :: groove

      groove = surface_of(torus_type(ring_radius, tube), along_z, .true.)
      ball%position = [ring_radius + tube - r + overlap, 0.0_wp, 0.0_wp]
      ring%spin = [0.0_wp, 0.0_wp, w]
      ball%spin = [0.0_wp, 0.0_wp, w*(ring_radius + tube)/r]
      call check_rolling(groove, surface_of(sphere_type(r), along_z, .false.), ring, ball, &
         [0.0_wp, w*(ring_radius + tube), 0.0_wp], "ball along a groove")
      ring%spin = 0.0_wp
      ball%spin = [0.0_wp, w, 0.0_wp]
      ball%velocity = [0.0_wp, 0.0_wp, w*r]
      call check_rolling(groove, surface_of(sphere_type(r), along_z, .false.), ring, ball, &
         [0.0_wp, 0.0_wp, -w*r*tube/(tube - r)], "ball across a groove")
   end subroutine test_ball_in_groove

   !> A barrel on a plane, almost a cylinder: the line does not matter.
   subroutine test_barrel()
      real(wp), parameter :: r = 0.1_wp, w = 3.0_wp
      type(pose_type) :: plane, barrel

      barrel%position = [0.0_wp, 0.0_wp, r - overlap]
      barrel%velocity = [w*r, 0.0_wp, 0.0_wp]
      barrel%spin = [0.0_wp, w, 0.0_wp]
      call check_rolling(surface_of(plane_type(), along_z, .false.), surface_of(ellipsoid_type( &
         [r, 1.0e3_wp*r, r]), along_z, .false.), plane, barrel, [-w*r, 0.0_wp, 0.0_wp], "barrel")
   end subroutine test_barrel

   !> A roller with a convex rim, a torus, in the groove of a ring at rest.
   subroutine test_roller_in_ring()
      real(wp), parameter :: major = 0.05_wp, tube = 0.02_wp, own = 0.006_wp, minor = 0.015_wp
      real(wp), parameter :: speed = 2.0_wp
      type(pose_type) :: ring, roller
      real(wp) :: r, orbit

      r = 0.5_wp*own + minor
      orbit = major + tube - r + overlap
      ! The rim is the outer half of a torus that is thicker than its hole is wide.
      roller%position = [orbit, 0.0_wp, 0.0_wp]
      roller%velocity = [0.0_wp, speed, 0.0_wp]
      roller%spin = [0.0_wp, 0.0_wp, -speed/r]
      call check_rolling(surface_of(torus_type(major, tube), along_z, .true.), &
         surface_of(torus_type(r - 0.4_wp*minor, 0.4_wp*minor), along_z, .false.), ring, roller, &
         [0.0_wp, -speed*(major + tube)/orbit, 0.0_wp], "torus in torus")
   end subroutine test_roller_in_ring

   !> A conical wheel on a cylindrical rail: the middle of the travel and the turning where they
   !> touch.
   subroutine test_wheel_on_rail()
      real(wp), parameter :: slope = 0.05_wp, r0 = 0.46_wp, head = 0.3_wp
      real(wp), parameter :: speed = 20.0_wp, w = 44.0_wp
      type(pose_type) :: rail, wheel
      type(surface_type) :: cone
      real(wp) :: angle, normal(3)

      angle = atan(slope)
      cone = surface_of(cone_type(angle), along_y, .false.)
      ! The apex is at the origin of the wheel; the rail touches from below where the radius is r0.
      normal = [0.0_wp, sin(angle), cos(angle)]
      rail%position = [0.0_wp, r0/slope, -r0] - (head - overlap)*normal
      wheel%velocity = [speed, 0.0_wp, 0.0_wp]
      wheel%spin = [0.0_wp, w, 0.0_wp]
      call check_rolling(surface_of(cylinder_type(head), along_x, .false.), cone, rail, wheel, &
         [-0.5_wp*(speed + w*r0), 0.0_wp, 0.0_wp], "wheel on rail")
   end subroutine test_wheel_on_rail

end module test_rolling
