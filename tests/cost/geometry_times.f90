!> Times of the geometry of pairs of surfaces that move a little between calls: the table of
!> docs/geometry.md. A benchmark, not a test.
!>
!>     geometry_times
!>
!> Prints for each pair the times in ns of the gap, of the rest of the contact point, of its
!> variation, and of a gap of which nothing is known.
program geometry_times
   use, intrinsic :: iso_fortran_env, only : output_unit
   use contensou_base_kinds, only : i8, wp
   use contensou_base_rotations, only : quaternion_from_axis_angle, rotation_matrix
   use contensou_contact_geometry, only : contact_point_type, contact_variation_type, &
      geometry_type, pose_type, track_type
   use contensou_contact_pairs, only : new_geometry
   use contensou_contact_shapes_cone, only : cone_type
   use contensou_contact_shapes_cylinder, only : cylinder_type
   use contensou_contact_shapes_ellipsoid, only : ellipsoid_type
   use contensou_contact_shapes_paraboloid, only : paraboloid_type
   use contensou_contact_shapes_plane, only : plane_type
   use contensou_contact_shapes_sphere, only : sphere_type
   use contensou_contact_shapes_torus, only : torus_type
   use contensou_contact_surface, only : surface_type
   implicit none(type, external)

   character(len=*), parameter :: pairs(2, 22) = reshape([character(len=10) :: &
      "sphere", "plane", "sphere", "sphere", "sphere", "bore", "sphere", "torus", &
      "sphere", "groove", "sphere", "ellipsoid", "sphere", "paraboloid", "sphere", "dish", &
      "sphere", "cone", "sphere", "funnel", "ellipsoid", "plane", "torus", "plane", &
      "paraboloid", "plane", "cylinder", "cylinder", "ellipsoid", "ellipsoid", &
      "ellipsoid", "bore", "ellipsoid", "groove", "ellipsoid", "dish", "ellipsoid", "funnel", &
      "torus", "cylinder", "torus", "dish", "torus", "funnel"], [2, 22])

   !> Poses of B, a small motion there and back, and repetitions of which the fastest counts.
   integer, parameter :: n_poses = 200, repetitions = 400

   integer :: i

   write(output_unit, "(a)") "pair                     gap  locate    vary  gap, nothing known"
   do i = 1, size(pairs, 2)
      call measure(trim(pairs(1, i)), trim(pairs(2, i)))
   end do

contains

   !> Measure a pair.
   subroutine measure(first, second)
      character(len=*), intent(in) :: first, second
      type(surface_type) :: a, b
      class(geometry_type), allocatable :: geometry
      type(pose_type) :: rest, pose(n_poses)
      type(track_type) :: track, fresh
      type(contact_point_type) :: at
      type(contact_variation_type) :: variation
      real(wp) :: gap, best(4), sum
      integer(i8) :: t(5), rate
      integer :: j, k

      call make(first, b)
      call make(second, a)
      if (a%inside) b%centre = 0.0_wp
      call new_geometry(a, b, geometry)
      ! A tilted body, a little apart.
      pose(1)%rotation = rotation_matrix(quaternion_from_axis_angle([1.0_wp, 0.3_wp, 0.2_wp], &
         0.3_wp))
      pose(1)%position = [0.1_wp, 0.05_wp, 3.0_wp]
      if (second == "bore") pose(1)%position = [0.3_wp, 0.1_wp, 0.0_wp]
      if (second == "groove") pose(1)%position = [3.2_wp, 0.1_wp, 0.1_wp]
      call geometry%gap(rest, pose(1), track, gap)
      call geometry%locate(rest, pose(1), track, gap, at)
      pose(1)%position = pose(1)%position + (0.02_wp - gap)*at%normal
      do j = 2, n_poses
         pose(j) = pose(1)
         pose(j)%position = pose(1)%position &
            + 1.0e-3_wp*sin(0.0314159_wp*j)*[1.0_wp, 0.5_wp, 0.2_wp]
         pose(j)%rotation = matmul(rotation_matrix(quaternion_from_axis_angle([0.1_wp, 0.2_wp, &
            1.0_wp], 1.0e-3_wp*sin(0.0314159_wp*j))), pose(1)%rotation)
      end do
      best = huge(best)
      sum = 0.0_wp
      do k = 1, repetitions
         call system_clock(t(1), rate)
         do j = 1, n_poses
            call geometry%gap(rest, pose(j), track, gap)
            sum = sum + gap
         end do
         call system_clock(t(2))
         do j = 1, n_poses
            call geometry%locate(rest, pose(j), track, gap, at)
            sum = sum + at%curvature_a
         end do
         call system_clock(t(3))
         do j = 1, n_poses
            call geometry%vary(rest, pose(j), track, at, variation)
            sum = sum + variation%curvature_a(1)
         end do
         call system_clock(t(4))
         if (mod(k, 20) == 1) then
            do j = 1, n_poses
               fresh = track_type()
               call geometry%gap(rest, pose(j), fresh, gap)
               sum = sum + gap
            end do
         end if
         call system_clock(t(5))
         best(:3) = min(best(:3), real(t(2:4) - t(1:3), wp))
         if (mod(k, 20) == 1) best(4) = min(best(4), real(t(5) - t(4), wp))
      end do
      best = best/rate/n_poses*1.0e9_wp
      ! What is not used need not be computed.
      if (.not. sum < huge(sum)) error stop "a gap is not finite"
      write(output_unit, "(a20, 3f8.0, f10.0)") first // ", " // second // repeat(" ", 20), best
   end subroutine measure

   !> A surface of a size of about 1 m, 0.3 m for what goes into another.
   subroutine make(name, surface)
      character(len=*), intent(in) :: name
      type(surface_type), intent(out) :: surface

      surface%inside = .false.
      select case (name)
      case ("sphere")
         surface%shape = sphere_type(0.3_wp)
      case ("plane")
         surface%shape = plane_type()
      case ("cylinder")
         surface%shape = cylinder_type(0.4_wp)
      case ("bore")
         surface%shape = cylinder_type(1.0_wp)
      case ("ellipsoid")
         surface%shape = ellipsoid_type([0.2_wp, 0.25_wp, 0.35_wp])
      case ("torus")
         surface%shape = torus_type(0.3_wp, 0.1_wp)
      case ("groove")
         surface%shape = torus_type(3.0_wp, 0.6_wp)
      case ("paraboloid")
         surface%shape = paraboloid_type(0.5_wp)
      case ("dish")
         surface%shape = paraboloid_type(2.0_wp)
      case ("cone", "funnel")
         surface%shape = cone_type(0.8_wp)
      case default
         error stop "no such shape"
      end select
      surface%inside = name == "bore" .or. name == "groove" .or. name == "dish" .or. &
         name == "funnel"
   end subroutine make

end program geometry_times
