!> Springs: derivatives against differences, and loads against the energy that they come from.
module test_springs
   use contensou_base_kinds, only : pi, wp
   use contensou_base_rotations, only : quaternion_from_axis_angle, rotation_matrix
   use contensou_base_vectors, only : cross
   use contensou_contact_geometry, only : pose_type
   use contensou_dynamics_springs, only : spring_axial, spring_bushing, spring_load_type, &
      spring_type
   use test_harness, only : check, check_close
   implicit none(type, external)
   private

   public :: run_spring_tests

   !> Step of the differences.
   real(wp), parameter :: step = 1.0e-5_wp

contains

   !> Run all of them.
   subroutine run_spring_tests()
      type(spring_type) :: bushing, axial
      type(pose_type) :: a, b
      real(wp), parameter :: turns(*) = [1.0e-9_wp, 1.0e-3_wp, 0.3_wp, 0.51_wp, 1.6_wp, 3.0_wp]
      integer :: i

      a = new_pose([0.1_wp, -0.2_wp, 0.3_wp], [1.0_wp, 2.0_wp, -1.0_wp], 0.7_wp)
      a%velocity = [0.3_wp, 0.1_wp, -0.2_wp]
      a%spin = [2.0_wp, -1.0_wp, 0.5_wp]
      bushing%kind = spring_bushing
      bushing%a = 1
      bushing%b = 2
      bushing%point = reshape([0.02_wp, 0.05_wp, -0.01_wp, 0.03_wp, 0.0_wp, 0.04_wp], [3, 2])
      bushing%axes = rotation_matrix(quaternion_from_axis_angle([1.0_wp, 0.5_wp, 0.0_wp], 0.4_wp))
      bushing%relaxed = rotation_matrix(quaternion_from_axis_angle([0.0_wp, 1.0_wp, 1.0_wp], &
         0.2_wp))
      bushing%stiffness = [100.0_wp, 200.0_wp, 50.0_wp]
      bushing%damping = [1.0_wp, 2.0_wp, 3.0_wp]
      bushing%turning_stiffness = [5.0_wp, 2.0_wp, 3.0_wp]
      bushing%turning_damping = [0.1_wp, 0.2_wp, 0.3_wp]
      bushing%preload = [1.0_wp, -2.0_wp, 3.0_wp]
      axial = bushing
      axial%kind = spring_axial
      axial%length = 0.2_wp
      do i = 1, size(turns)
         b = new_pose([0.2_wp, 0.0_wp, 0.25_wp], [1.0_wp, -1.0_wp, 0.4_wp], turns(i))
         ! Its relaxed attitude, turned by the angle.
         b%rotation = matmul(matmul(a%rotation, b%rotation), bushing%relaxed)
         b%velocity = [-0.4_wp, 0.2_wp, 0.1_wp]
         b%spin = [1.0_wp, 1.5_wp, -2.0_wp]
         call test_slopes(bushing, a, b, "a bushing")
         call test_slopes(axial, a, b, "a spring between two points")
         call test_energy(bushing, a, b, "a bushing")
         call test_energy(axial, a, b, "a spring between two points")
      end do
      call test_half_turn(bushing, a)
      call test_coincident(axial)
   end subroutine run_spring_tests

   !> A pose at rest.
   function new_pose(position, axis, angle) result(pose)
      real(wp), intent(in) :: position(3)
      real(wp), intent(in) :: axis(3)
      real(wp), intent(in) :: angle
      type(pose_type) :: pose

      pose%position = position
      pose%rotation = rotation_matrix(quaternion_from_axis_angle(axis, angle))
   end function new_pose

   !> A pose moved along one of its twelve degrees of freedom.
   function moved(pose, freedom, by) result(other)
      type(pose_type), intent(in) :: pose
      integer, intent(in) :: freedom
      real(wp), intent(in) :: by
      type(pose_type) :: other
      real(wp) :: e(3)

      other = pose
      e = 0.0_wp
      e(modulo(freedom - 1, 3) + 1) = 1.0_wp
      select case ((freedom - 1)/3)
      case (0)
         other%position = pose%position + by*e
      case (1)
         other%rotation = matmul(rotation_matrix(quaternion_from_axis_angle(e, by)), pose%rotation)
      case (2)
         other%velocity = pose%velocity + by*e
      case default
         other%spin = pose%spin + by*e
      end select
   end function moved

   !> Force, torques and lost power, in the order of the slopes.
   function outcome(spring, a, b) result(values)
      type(spring_type), intent(in) :: spring
      type(pose_type), intent(in) :: a
      type(pose_type), intent(in) :: b
      real(wp) :: values(11)
      type(spring_load_type) :: found

      call spring%load(a, b, found)
      values(1:3) = found%force
      values(4:6) = -found%torque - cross(found%arm_a, found%force)
      values(7:9) = found%torque + cross(found%arm_b, found%force)
      values(10) = 0.0_wp
      values(11) = found%power
   end function outcome

   !> Derivatives against central differences.
   subroutine test_slopes(spring, a, b, name)
      type(spring_type), intent(in) :: spring
      type(pose_type), intent(in) :: a
      type(pose_type), intent(in) :: b
      character(len=*), intent(in) :: name
      type(spring_load_type) :: found
      real(wp) :: slopes(11, 24), difference(11), scale
      integer :: k

      call spring%vary(a, b, found, slopes)
      scale = maxval(abs(slopes))
      do k = 1, 24
         if (k <= 12) then
            difference = outcome(spring, moved(a, k, step), b) &
               - outcome(spring, moved(a, k, -step), b)
         else
            difference = outcome(spring, a, moved(b, k - 12, step)) &
               - outcome(spring, a, moved(b, k - 12, -step))
         end if
         difference = difference/(2.0_wp*step)
         call check_close(maxval(abs(slopes(:, k) - difference)), 0.0_wp, 1.0e-8_wp*scale, &
            "springs: derivatives of " // name)
      end do
   end subroutine test_slopes

   !> Without damping the loads are the slopes of the energy, and the powers of the loads are what
   !> the energy loses.
   subroutine test_energy(spring, a, b, name)
      type(spring_type), intent(in) :: spring
      type(pose_type), intent(in) :: a
      type(pose_type), intent(in) :: b
      character(len=*), intent(in) :: name
      type(spring_type) :: elastic
      type(spring_load_type) :: more, less
      real(wp) :: values(11), slope(12), rate, power
      integer :: k

      elastic = spring
      elastic%damping = 0.0_wp
      elastic%turning_damping = 0.0_wp
      values = outcome(elastic, a, b)
      do k = 1, 6
         call elastic%load(moved(a, k, step), b, more)
         call elastic%load(moved(a, k, -step), b, less)
         slope(k) = (more%energy - less%energy)/(2.0_wp*step)
         call elastic%load(a, moved(b, k, step), more)
         call elastic%load(a, moved(b, k, -step), less)
         slope(6 + k) = (more%energy - less%energy)/(2.0_wp*step)
      end do
      call check_close(maxval(abs(slope(7:9) + values(1:3))), 0.0_wp, 1.0e-7_wp, &
         "springs: force of " // name // " from its energy")
      call check_close(maxval(abs(slope(1:3) - values(1:3))), 0.0_wp, 1.0e-7_wp, &
         "springs: counter force of " // name // " from its energy")
      call check_close(maxval(abs(slope(4:6) + values(4:6))), 0.0_wp, 1.0e-7_wp, &
         "springs: torque of " // name // " on A from its energy")
      call check_close(maxval(abs(slope(10:12) + values(7:9))), 0.0_wp, 1.0e-7_wp, &
         "springs: torque of " // name // " on B from its energy")
      ! With damping the powers on both bodies are those of the energy and of what is lost.
      values = outcome(spring, a, b)
      rate = dot_product(slope(1:3), a%velocity) + dot_product(slope(4:6), a%spin) &
         + dot_product(slope(7:9), b%velocity) + dot_product(slope(10:12), b%spin)
      power = dot_product(values(1:3), b%velocity - a%velocity) &
         + dot_product(values(4:6), a%spin) + dot_product(values(7:9), b%spin)
      call check(values(11) > 0.0_wp, "springs: damping of " // name // " loses energy")
      call check_close(power + rate + values(11), 0.0_wp, 1.0e-7_wp, &
         "springs: power of " // name)
   end subroutine test_energy

   !> Close to half a turn the twist still is the whole angle, on either side.
   subroutine test_half_turn(spring, a)
      type(spring_type), intent(in) :: spring
      type(pose_type), intent(in) :: a
      type(spring_type) :: simple
      type(pose_type) :: b
      type(spring_load_type) :: found
      real(wp) :: angle
      integer :: i

      simple = spring
      simple%stiffness = 0.0_wp
      simple%preload = 0.0_wp
      simple%turning_stiffness = 2.0_wp
      do i = -1, 1, 2
         angle = pi + i*1.0e-9_wp
         b = a
         b%rotation = matmul(matmul(a%rotation, rotation_matrix(quaternion_from_axis_angle( &
            [-3.0_wp, 1.0_wp, -2.0_wp], angle))), simple%relaxed)
         call simple%load(a, b, found)
         call check_close(found%energy, (pi - 1.0e-9_wp)**2, 1.0e-7_wp, "springs: half a turn")
      end do
   end subroutine test_half_turn

   !> A spring between two points that coincide pulls nowhere.
   subroutine test_coincident(spring)
      type(spring_type), intent(in) :: spring
      type(spring_type) :: other
      type(pose_type) :: a
      type(spring_load_type) :: found

      other = spring
      other%point = 0.0_wp
      a = new_pose([0.0_wp, 0.0_wp, 0.0_wp], [0.0_wp, 0.0_wp, 1.0_wp], 0.0_wp)
      call other%load(a, a, found)
      call check(maxval(abs(found%force)) <= 0.0_wp, "springs: two points at one place")
   end subroutine test_coincident

end module test_springs
