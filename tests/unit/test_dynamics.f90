!> Tests of rotations and of the equations of motion.
module test_dynamics
   use contensou_base_kinds, only : pi, wp
   use contensou_base_rotations, only : quaternion_from_axis_angle, quaternion_rate, &
      rotation_matrix, unit_quaternion
   use contensou_base_vectors, only : any_perpendicular, cross
   use contensou_contact_damping, only : damping_model_type, damping_models
   use contensou_contact_damping_coefficient, only : coefficient_damping_type
   use contensou_contact_friction, only : friction_model_type, friction_models
   use contensou_contact_geometry, only : pose_type
   use contensou_dynamics_assembly, only : contact_length
   use contensou_dynamics_scene, only : scene_type
   use contensou_dynamics_equations, only : system_type
   use contensou_dynamics_reports, only : begin_report, contact_report_type, energies, momenta, &
      report_contact
   use contensou_dynamics_state, only : position_of, quaternion_of, spin_of, velocity_of
   use contensou_integrate_motion, only : motion_type
   use test_harness, only : check, check_close, check_relative, random_type, worst_type
   use test_scenes, only : ball, damping_index, friction_index, random_touch, set_motion, two_bodies
   implicit none(type, external)
   private

   public :: run_dynamics_tests

contains

   !> Run all tests.
   subroutine run_dynamics_tests()
      call test_vectors()
      call test_rotations()
      call test_quaternion_rate()
      call test_free_top()
      call test_free_fall()
      call test_momenta()
      call test_energy()
      call test_layout()
      call test_too_deep()
      call test_report()
      call test_restitution()
      call test_contact_length()
   end subroutine run_dynamics_tests

   !> Vector product and perpendicular vectors.
   subroutine test_vectors()
      type(random_type) :: random
      type(worst_type) :: product, perpendicular, length
      real(wp) :: a(3), b(3), c(3)
      integer :: i

      do i = 1, 1000
         a = random%vector(3)
         b = random%vector(3)
         c = cross(a, b)
         call product%note(abs(dot_product(a, c)) + abs(dot_product(b, c)) + abs(norm2(c)**2 &
            + dot_product(a, b)**2 - norm2(a)**2*norm2(b)**2), i)
         if (modulo(i, 3) == 0) a(1 + modulo(i, 2)) = 0.0_wp
         c = any_perpendicular(a*10.0_wp**random%uniform(-50.0_wp, 50.0_wp))
         call perpendicular%note(abs(dot_product(a, c))/norm2(a), i)
         call length%note(abs(norm2(c) - 1.0_wp), i)
      end do
      call product%check_below(1.0e-14_wp, "vector product")
      call check_close(norm2(cross([1.0_wp, 0.0_wp, 0.0_wp], [0.0_wp, 1.0_wp, 0.0_wp]) &
         - [0.0_wp, 0.0_wp, 1.0_wp]), 0.0_wp, 0.0_wp, "vector product: right-handed")
      call perpendicular%check_below(1.0e-15_wp, "any_perpendicular: perpendicular")
      call length%check_below(1.0e-15_wp, "any_perpendicular: of unit length")
   end subroutine test_vectors

   !> Matrix and quaternion of a rotation.
   subroutine test_rotations()
      type(random_type) :: random
      type(worst_type) :: orthogonal, determinant, scaled, axis_kept, angle_kept, unit
      real(wp) :: q(4), r(3, 3), axis(3), angle, x(3), y(3)
      real(wp), parameter :: identity(3, 3) = reshape([1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, &
         0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [3, 3])
      integer :: i

      do i = 1, 2000
         q = random%vector(4)*abs(random%decades(-3.0_wp, 3.0_wp))
         r = rotation_matrix(q)
         call orthogonal%note(maxval(abs(matmul(r, transpose(r)) - identity)), i)
         call determinant%note(abs(dot_product(r(:, 1), cross(r(:, 2), r(:, 3))) - 1.0_wp), i)
         call scaled%note(maxval(abs(r - rotation_matrix(random%decades(-9.0_wp, 9.0_wp)*q))), i)
         call unit%note(abs(norm2(unit_quaternion(q)) - 1.0_wp) &
            + maxval(abs(rotation_matrix(unit_quaternion(q)) - r)), i)
         axis = random%vector(3)
         angle = random%uniform(-7.0_wp, 7.0_wp)
         r = rotation_matrix(quaternion_from_axis_angle(axis, angle))
         call axis_kept%note(maxval(abs(matmul(r, axis) - axis)), i)
         ! Rodrigues' formula.
         axis = axis/norm2(axis)
         x = random%vector(3)
         y = cos(angle)*x + sin(angle)*cross(axis, x) + (1.0_wp - cos(angle))*dot_product(axis, x) &
            *axis
         call angle_kept%note(maxval(abs(matmul(r, x) - y)), i)
      end do
      call orthogonal%check_below(4.0e-15_wp, "rotation matrix: orthogonal")
      call determinant%check_below(4.0e-15_wp, "rotation matrix: right-handed")
      call scaled%check_below(4.0e-15_wp, "rotation matrix: homogeneous of degree 0")
      call unit%check_below(4.0e-15_wp, "unit_quaternion: unit norm, the same rotation")
      call axis_kept%check_below(4.0e-15_wp, "quaternion_from_axis_angle: keeps the axis")
      call angle_kept%check_below(4.0e-15_wp, "quaternion_from_axis_angle: Rodrigues' formula")
   end subroutine test_rotations

   !> Rate of a quaternion: R' = R [w]x, whatever the norm; the norm is pulled to one.
   subroutine test_quaternion_rate()
      type(random_type) :: random
      type(worst_type) :: turning, pull
      real(wp) :: q(4), w(3), rate(4), numeric(3, 3), expected(3, 3), r(3, 3), e(3), norm
      real(wp), parameter :: h = 1.0e-5_wp
      integer :: i, j

      do i = 1, 1000
         q = random%vector(4)
         w = random%vector(3)
         rate = quaternion_rate(q, w)
         ! A step of a fixed fraction of the norm.
         norm = norm2(q)
         numeric = (rotation_matrix(q + h*norm*rate) - rotation_matrix(q - h*norm*rate)) &
            /(2.0_wp*h*norm)
         r = rotation_matrix(q)
         do j = 1, 3
            e = 0.0_wp
            e(j) = 1.0_wp
            expected(:, j) = matmul(r, cross(w, e))
         end do
         call turning%note(maxval(abs(numeric - expected))*norm, i)
         call pull%note(abs(dot_product(q, rate) - (1.0_wp - norm**2)*norm**2), i)
      end do
      call turning%check_below(1.0e-8_wp, "quaternion_rate: R' = R [w]x")
      call pull%check_below(5.0e-15_wp, "quaternion_rate: the norm is pulled to one, at 1/s")
   end subroutine test_quaternion_rate

   !> Integrate a system with Runge-Kutta's method.
   subroutine integrate(system, y, t, steps)
      type(system_type), intent(inout) :: system
      !> State.
      real(wp), intent(inout) :: y(:)
      !> Time to pass [s].
      real(wp), intent(in) :: t
      !> Number of steps.
      integer, intent(in) :: steps
      real(wp) :: h, k1(size(y)), k2(size(y)), k3(size(y)), k4(size(y))
      integer :: i

      h = t/steps
      do i = 1, steps
         call system%derivative(0.0_wp, y, k1)
         call system%derivative(0.0_wp, y + 0.5_wp*h*k1, k2)
         call system%derivative(0.0_wp, y + 0.5_wp*h*k2, k3)
         call system%derivative(0.0_wp, y + h*k3, k4)
         y = y + h/6.0_wp*(k1 + 2.0_wp*k2 + 2.0_wp*k3 + k4)
      end do
   end subroutine integrate

   !> A free symmetric top against its closed form: the angular velocity turns about the body axis,
   !> the body about its own axis and about the angular momentum.
   subroutine test_free_top()
      type(scene_type) :: scene
      type(motion_type) :: motion
      real(wp), allocatable :: y(:)
      real(wp) :: rate, w(3), expected(3, 3), momentum(3), start(3, 3)
      real(wp), parameter :: t = 1.3_wp, inertia_1 = 4.0e-3_wp, inertia_3 = 6.0e-3_wp
      real(wp), parameter :: spin(3) = [2.0_wp, -1.0_wp, 9.0_wp]
      real(wp), parameter :: axis(3) = [0.0_wp, 0.0_wp, 1.0_wp]

      call ball(scene, 1.0_wp)
      scene%bodies(1)%inertia = [inertia_1, inertia_1, inertia_3]
      scene%bodies(1)%spin = spin
      scene%bodies(1)%quaternion = unit_quaternion([0.3_wp, -0.5_wp, 0.4_wp, 0.7_wp])
      scene%bodies(1)%velocity = [0.1_wp, 0.2_wp, 0.3_wp]
      call set_motion(scene, motion, y)
      call integrate(motion%system, y, t, 4000)

      rate = (inertia_3 - inertia_1)/inertia_1*spin(3)
      w = [spin(1)*cos(rate*t) - spin(2)*sin(rate*t), spin(1)*sin(rate*t) + spin(2)*cos(rate*t), &
         spin(3)]
      call check_close(norm2(y(11:13) - w), 0.0_wp, 1.0e-9_wp, "free top: angular velocity")
      start = rotation_matrix(scene%bodies(1)%quaternion)
      momentum = matmul(start, scene%bodies(1)%inertia*spin)
      expected = matmul(matmul(rotation_matrix(quaternion_from_axis_angle(momentum, &
         norm2(momentum)/inertia_1*t)), start), rotation_matrix(quaternion_from_axis_angle(axis, &
         -rate*t)))
      call check_close(maxval(abs(rotation_matrix(y(4:7)) - expected)), 0.0_wp, 1.0e-9_wp, &
         "free top: attitude")
      call check_close(norm2(y(1:3) - scene%bodies(1)%position - t*scene%bodies(1)%velocity), &
         0.0_wp, 1.0e-12_wp, "free top: straight on without gravity")
      call check_close(norm2(y(4:7)), 1.0_wp, 1.0e-12_wp, "free top: norm of the quaternion")
   end subroutine test_free_top

   !> Free fall, and Euler's equations of an asymmetric body.
   subroutine test_free_fall()
      type(scene_type) :: scene
      type(motion_type) :: motion
      real(wp), allocatable :: y(:), rate(:)
      real(wp) :: expected(3), kinetic, potential

      call ball(scene, 1.0_wp)
      scene%gravity = [1.0_wp, -2.0_wp, -9.81_wp]
      scene%bodies(1)%inertia = [2.0e-5_wp, 3.0e-5_wp, 4.0e-5_wp]
      scene%bodies(1)%spin = [5.0_wp, 7.0_wp, 11.0_wp]
      scene%bodies(1)%velocity = [0.1_wp, 0.2_wp, 0.3_wp]
      call set_motion(scene, motion, y)
      allocate(rate(size(y)))
      call motion%system%derivative(0.0_wp, y, rate)
      expected = [(3.0_wp - 4.0_wp)/2.0_wp*77.0_wp, (4.0_wp - 2.0_wp)/3.0_wp*55.0_wp, &
         (2.0_wp - 3.0_wp)/4.0_wp*35.0_wp]
      call check_close(norm2(rate(11:13) - expected), 0.0_wp, 1.0e-13_wp, "Euler's equations")
      call check_close(norm2(rate(8:10) - scene%gravity), 0.0_wp, 1.0e-15_wp, "free fall")
      call check_close(norm2(rate(1:3) - y(8:10)), 0.0_wp, 0.0_wp, "rate of the position")
      call energies(motion%system, y, kinetic, potential)
      call check_relative(kinetic, 0.05_wp*0.14_wp + 0.5e-5_wp*(50.0_wp + 147.0_wp + 484.0_wp), &
         1.0e-14_wp, "kinetic energy")
      call check_relative(potential, 0.1_wp*9.81_wp*1.02_wp, 1.0e-14_wp, "potential energy")
   end subroutine test_free_fall

   !> Total force, and total torque about the origin, that the contacts exert.
   subroutine rates_of_momenta(scene, y, rate, linear, angular, size_of_torques)
      type(scene_type), intent(in) :: scene
      !> State.
      real(wp), intent(in) :: y(:)
      real(wp), intent(in) :: rate(:)
      !> Rate of the linear momentum.
      real(wp), intent(out) :: linear(3)
      !> Rate of the angular momentum about the origin.
      real(wp), intent(out) :: angular(3)
      !> Sum of the sizes of what adds up to it.
      real(wp), intent(out) :: size_of_torques
      real(wp) :: torque(3), orbital(3), w(3)
      integer :: i

      linear = 0.0_wp
      angular = 0.0_wp
      size_of_torques = 0.0_wp
      do i = 1, size(scene%bodies)
         associate (body => scene%bodies(i))
            w = spin_of(y, i)
            torque = matmul(rotation_matrix(quaternion_of(y, i)), body%inertia*spin_of(rate, i) &
               + cross(w, body%inertia*w))
            orbital = body%mass*cross(position_of(y, i), velocity_of(rate, i))
            linear = linear + body%mass*velocity_of(rate, i)
            angular = angular + orbital + torque
            size_of_torques = size_of_torques + norm2(orbital) + norm2(torque)
         end associate
      end do
   end subroutine rates_of_momenta

   !> A contact of two bodies changes neither momentum.
   subroutine test_momenta()
      type(scene_type) :: scene
      type(motion_type) :: motion
      type(random_type) :: random
      type(damping_model_type), allocatable :: damping(:)
      type(friction_model_type), allocatable :: friction(:)
      type(worst_type) :: force, torque, reported
      real(wp), allocatable :: y(:), rate(:)
      real(wp) :: linear(3), angular(3), size_of_torques, push, other(3), given(3)
      real(wp), parameter :: h = 1.0e-7_wp
      integer :: i, j, k

      damping = damping_models()
      friction = friction_models()
      do i = 1, size(damping)
         do j = 1, size(friction)
            call two_bodies(scene, i, j, modulo(i + j, 2) == 0)
            call set_motion(scene, motion, y)
            allocate(rate(size(y)))
            do k = 1, 50
               y = 0.0_wp
               call random_touch(scene, random, -random%uniform(1.0e-6_wp, 1.0e-4_wp), y)
               call motion%system%derivative(0.0_wp, y, rate)
               push = scene%bodies(1)%mass*norm2(rate(8:10))
               call rates_of_momenta(scene, y, rate, linear, angular, size_of_torques)
               ! Bodies that separate fast exert no force.
               if (push <= 0.0_wp) cycle
               call force%note(norm2(linear)/push, k)
               call torque%note(norm2(angular)/size_of_torques, k)
               call momenta(motion%system, y + h*rate, linear, angular)
               call momenta(motion%system, y - h*rate, other, given)
               call reported%note(norm2(angular - given)/(2.0_wp*h*size_of_torques), k)
            end do
            deallocate(rate)
         end do
      end do
      call force%check_below(1.0e-14_wp, "contacts keep the linear momentum")
      call torque%check_below(1.0e-13_wp, "contacts keep the angular momentum")
      call reported%check_below(1.0e-5_wp, "contacts keep the angular momentum that is reported")

      call two_bodies(scene, 1, 1, .true.)
      call set_motion(scene, motion, y)
      call random_touch(scene, random, 1.0_wp, y)
      call momenta(motion%system, y, linear, angular)
      given = 0.2_wp*y(8:10) + 0.5_wp*y(21:23)
      call check_close(norm2(linear - given), 0.0_wp, 1.0e-15_wp, "linear momentum")
      given = 0.2_wp*cross(y(1:3), y(8:10)) + 0.5_wp*cross(y(14:16), y(21:23)) &
         + matmul(rotation_matrix(y(4:7)), scene%bodies(1)%inertia*y(11:13)) &
         + matmul(rotation_matrix(y(17:20)), scene%bodies(2)%inertia*y(24:26))
      call check_close(norm2(angular - given), 0.0_wp, 1.0e-15_wp, "angular momentum")
   end subroutine test_momenta

   !> Kinetic, potential and elastic energy lose what friction and damping take, to rounding.
   subroutine test_energy()
      type(scene_type) :: scene
      type(motion_type) :: motion
      type(random_type) :: random
      type(damping_model_type), allocatable :: damping(:)
      type(friction_model_type), allocatable :: friction(:)
      type(worst_type) :: balance, loss
      real(wp), allocatable :: y(:), rate(:)
      real(wp) :: gap(1), gap_rate(1), terms(9)
      integer :: i, j, k, b
      logical :: drilling

      damping = damping_models()
      friction = friction_models()
      do i = 1, size(damping)
         do j = 1, size(friction)
            balance = worst_type()
            loss = worst_type()
            do k = 1, 100
               drilling = modulo(k, 3) > 0
               call two_bodies(scene, i, j, modulo(k, 2) == 0)
               call scene%contacts(1)%parameters%set("drilling", drilling)
               scene%gravity = [1.0_wp, 2.0_wp, -9.81_wp]
               ! Up to where damping would pull, and beyond.
               call scene%contacts(1)%parameters%set("damping_coefficient", 10.0_wp**modulo(k, 5))
               if (modulo(k, 4) == 0) call scene%contacts(1)%parameters%set( &
                  "regularization_velocity", 1.0_wp)
               call set_motion(scene, motion, y)
               y = 0.0_wp
               call random_touch(scene, random, -random%uniform(1.0e-7_wp, 1.0e-4_wp), y)
               allocate(rate(size(y)))
               call motion%system%derivative(0.0_wp, y, rate)
               call motion%system%gaps(y, gap)
               call motion%system%gap_rates(y, gap_rate)
               terms = 0.0_wp
               do b = 1, 2
                  terms(3*b - 2) = scene%bodies(b)%mass*dot_product(velocity_of(y, b), &
                     velocity_of(rate, b))
                  terms(3*b - 1) = dot_product(spin_of(y, b), scene%bodies(b)%inertia &
                     *spin_of(rate, b))
                  terms(3*b) = -scene%bodies(b)%mass*dot_product(scene%gravity, velocity_of(y, b))
               end do
               terms(7) = -motion%system%contacts(1)%law%normal%force(-gap(1))*gap_rate(1)
               if (j > 1) terms(8) = rate(motion%system%layout%friction)
               if (i > 1) terms(9) = rate(motion%system%layout%damping)
               call balance%note(abs(sum(terms))/sum(abs(terms)), k)
               call loss%note(-minval(terms(8:9)), k)
               deallocate(rate)
            end do
            call balance%check_below(1.0e-12_wp, trim(damping(i)%info%name) // ", " // &
               trim(friction(j)%info%name) // ": balance of power")
            call loss%check_below(0.0_wp, trim(damping(i)%info%name) // ", " // &
               trim(friction(j)%info%name) // ": friction and damping only take")
         end do
      end do
   end subroutine test_energy

   !> The works are part of the state only where there is friction or damping.
   subroutine test_layout()
      type(scene_type) :: scene
      type(motion_type) :: motion
      type(pose_type) :: pose
      real(wp), allocatable :: y(:)
      real(wp) :: q(4)

      call two_bodies(scene, 1, 1, .true.)
      scene%bodies(2)%quaternion = unit_quaternion([1.0_wp, 2.0_wp, 3.0_wp, 4.0_wp])
      scene%bodies(2)%position = [1.0_wp, 2.0_wp, 3.0_wp]
      scene%bodies(2)%velocity = [4.0_wp, 5.0_wp, 6.0_wp]
      scene%bodies(2)%spin = [7.0_wp, 8.0_wp, 9.0_wp]
      call set_motion(scene, motion, y)
      call check(motion%n == 26 .and. motion%system%layout%friction == 0 .and. &
         motion%system%layout%damping == 0, "state without friction and damping")
      call check(all(abs(y(14:26) - [1.0_wp, 2.0_wp, 3.0_wp, scene%bodies(2)%quaternion, 4.0_wp, &
         5.0_wp, 6.0_wp, 7.0_wp, 8.0_wp, 9.0_wp]) <= 0.0_wp), "initial state of the second body")
      y(17:20) = 3.0_wp*y(17:20)
      call motion%system%pose_of(y, 2, pose, q)
      call check_close(norm2(q - scene%bodies(2)%quaternion), 0.0_wp, 1.0e-15_wp, &
         "pose: unit quaternion")
      call check_close(norm2(pose%position - y(14:16)) + norm2(pose%velocity - y(21:23)) &
         + norm2(pose%spin - matmul(rotation_matrix(q), y(24:26))), 0.0_wp, 1.0e-14_wp, &
         "pose: position and motion")
      call two_bodies(scene, damping_index("viscous"), 1, .true.)
      call set_motion(scene, motion, y)
      call check(motion%n == 27 .and. motion%system%layout%friction == 0 .and. &
         motion%system%layout%damping == 27, "state with damping")
      call two_bodies(scene, 1, friction_index("coulomb"), .true.)
      call set_motion(scene, motion, y)
      call check(motion%n == 27 .and. motion%system%layout%friction == 27 .and. &
         motion%system%layout%damping == 0, "state with friction")
      call check(.not. motion%system%contacts(1)%law%friction%drilling, &
         "a model without torque has no drilling")
      call two_bodies(scene, damping_index("viscous"), friction_index("pade11"), .true.)
      call set_motion(scene, motion, y)
      call check(motion%n == 28 .and. size(y) == 28 .and. &
         motion%system%layout%friction == 27 .and. motion%system%layout%damping == 28, &
         "state with friction and damping")
   end subroutine test_layout

   !> An approach beyond the domain of the contact model.
   subroutine test_too_deep()
      type(scene_type) :: scene
      type(motion_type) :: motion
      type(random_type) :: random
      real(wp), allocatable :: y(:), rate(:)
      logical :: outside

      call two_bodies(scene, 1, 1, .true.)
      call set_motion(scene, motion, y)
      allocate(rate(size(y)))
      call random_touch(scene, random, -0.11_wp*1.5e-2_wp, y)
      call motion%system%derivative(0.0_wp, y, rate)
      call check(motion%system%too_deep == 1, "too deep: more than a tenth of the radius")
      call motion%derivative(0.0_wp, y, rate, outside)
      call check(.not. outside .and. norm2(rate(8:10)) > 0.0_wp, &
         "too deep: a step may look a little beyond")
      call random_touch(scene, random, -0.41_wp*1.5e-2_wp, y)
      call motion%derivative(0.0_wp, y, rate, outside)
      call check(outside .and. motion%system%too_deep == 1, "too deep: far outside the domain")
      call random_touch(scene, random, -0.09_wp*1.5e-2_wp, y)
      call motion%system%derivative(0.0_wp, y, rate)
      call check(motion%system%too_deep == 0, "too deep: less than a tenth of the radius")
      call motion%derivative(0.0_wp, y, rate, outside)
      call check(.not. outside, "too deep: inside the domain")
      call random_touch(scene, random, 1.0_wp, y)
      call motion%system%derivative(0.0_wp, y, rate)
      call check(motion%system%too_deep == 0 .and. norm2(rate(8:10)) <= 0.0_wp, &
         "no force on bodies that do not touch")
   end subroutine test_too_deep

   !> What an output row says of a contact.
   subroutine test_report()
      type(scene_type) :: scene
      type(motion_type) :: motion
      type(random_type) :: random
      type(contact_report_type) :: row
      real(wp), allocatable :: y(:)
      real(wp) :: gap(1), rate(1)

      call two_bodies(scene, 1, 1, .true.)
      call set_motion(scene, motion, y)
      call random_touch(scene, random, -1.0e-5_wp, y)
      call begin_report(motion%system, 0.0_wp, y)
      call report_contact(motion%system, 1, row)
      call motion%system%gaps(y, gap)
      call motion%system%gap_rates(y, rate)
      associate (normal => motion%system%contacts(1)%law%normal)
         call check_close(row%at%gap, gap(1), 0.0_wp, "report: gap")
         call check_close(row%load%normal_force, normal%force(-gap(1)), 0.0_wp, "report: force")
         call check_close(row%elastic_energy, normal%energy(-gap(1)), 0.0_wp, "report: energy")
         call check_relative(row%semi_axes(1), sqrt(1.5e-2_wp*1.0e-5_wp), 1.0e-9_wp, &
            "report: semi-axis")
         call check_close(row%semi_axes(2), row%semi_axes(1), 0.0_wp, "report: circular spot")
      end associate
      call check_close(dot_product(row%slip, row%at%normal), 0.0_wp, 1.0e-15_wp, &
         "report: the slip is tangential without friction too")
      call random_touch(scene, random, 1.0e-5_wp, y)
      call begin_report(motion%system, 0.0_wp, y)
      call report_contact(motion%system, 1, row)
      call check(row%at%gap > 0.0_wp .and. abs(row%load%normal_force) <= 0.0_wp .and. &
         norm2(row%semi_axes) <= 0.0_wp .and. abs(row%elastic_energy) <= 0.0_wp, &
         "report: an open contact")
   end subroutine test_report

   !> Restitution in a scene becomes the coefficient of the law.
   subroutine test_restitution()
      type(scene_type) :: scene
      type(motion_type) :: motion
      type(coefficient_damping_type) :: damping
      real(wp), allocatable :: y(:)

      call two_bodies(scene, damping_index("hunt_crossley"), 1, .true.)
      call set_motion(scene, motion, y)
      damping = damping_of(motion)
      call check_close(damping%coefficient, 0.4_wp, 0.0_wp, "hunt_crossley by coefficient")
      call check_close(damping%impact_number, 0.0_wp, 0.0_wp, "hunt_crossley: constant")
      call scene%contacts(1)%parameters%set("restitution", 0.5_wp)
      call scene%contacts(1)%parameters%set("impact_velocity", 2.0_wp)
      call set_motion(scene, motion, y)
      damping = damping_of(motion)
      call check_close(log((1.0_wp + 3.0_wp*damping%coefficient)/(1.0_wp &
         - 1.5_wp*damping%coefficient)), 4.5_wp*damping%coefficient, 1.0e-14_wp, &
         "hunt_crossley by restitution at a speed")
      call check_close(damping%impact_number, 0.0_wp, 0.0_wp, &
         "hunt_crossley: constant at a speed")
      call scene%contacts(1)%parameters%set("impact_velocity", 0.0_wp)
      call set_motion(scene, motion, y)
      damping = damping_of(motion)
      call check(damping%impact_number > 0.0_wp, "hunt_crossley by restitution of each impact")

      call two_bodies(scene, damping_index("tsuji"), 1, .true.)
      call set_motion(scene, motion, y)
      damping = damping_of(motion)
      call check_relative(damping%coefficient, 0.4_wp*sqrt(0.1_wp/0.7_wp), &
         1.0e-14_wp, "tsuji by coefficient, with the reduced mass")
      call scene%contacts(1)%parameters%set("restitution", exp(-pi))
      scene%surfaces(2)%body = 0
      call set_motion(scene, motion, y)
      damping = damping_of(motion)
      call check_relative(damping%coefficient, sqrt(2.5_wp)*sqrt(0.2_wp), &
         1.0e-14_wp, "tsuji by restitution, against the ground")
   end subroutine test_restitution

   !> Damping of the first contact.
   function damping_of(motion) result(damping)
      type(motion_type), intent(in) :: motion
      type(coefficient_damping_type) :: damping

      select type (law => motion%system%contacts(1)%law%damping)
      type is (coefficient_damping_type)
         damping = law
      end select
   end function damping_of

   !> Length scale of the contacts of a scene.
   subroutine test_contact_length()
      type(scene_type) :: scene
      type(motion_type) :: motion
      real(wp), allocatable :: y(:)
      real(wp) :: length

      call ball(scene, 1.0_wp)
      scene%gravity = [0.0_wp, 0.0_wp, -9.81_wp]
      call set_motion(scene, motion, y)
      associate (normal => motion%system%contacts(1)%law%normal)
         length = contact_length(scene, motion%system, 1.0_wp)
         call check_relative(normal%force(10.0_wp*length), 0.981_wp, 1.0e-13_wp, &
            "contact length: a tenth of what the weight overlaps")
         scene%gravity = 0.0_wp
         length = contact_length(scene, motion%system, 0.3_wp)
         call check_relative(normal%energy(10.0_wp*length), 0.05_wp*0.09_wp, 1.0e-13_wp, &
            "contact length: a tenth of what an impact overlaps")
      end associate
   end subroutine test_contact_length

end module test_dynamics
