!> Tests of the Jacobians: of the kernels, and of the equations of motion as a whole.
module test_jacobian
   use contensou_base_kinds, only : pi, wp
   use contensou_base_rotations, only : rotation_matrix
   use contensou_contact_creep_law, only : creep_motion_type, creep_spot_type, creep_type
   use contensou_contact_damping, only : damping_model_type, damping_models
   use contensou_contact_friction, only : friction_model_type, friction_models
   use contensou_contact_friction_law, only : sliding_type
   use contensou_contact_geometry, only : contact_motion_type
   use contensou_contact_normal, only : normal_hertz, normal_rigid
   use contensou_contact_rolling_lever, only : lever_type
   use contensou_contact_spot, only : elliptic_shape, spot_shape_type
   use contensou_contact_shapes_ellipsoid, only : ellipsoid_type
   use contensou_contact_shapes_sphere, only : sphere_type
   use contensou_contact_shapes_torus, only : torus_type
   use contensou_contact_wrench, only : slip_type
   use contensou_dynamics_scene, only : motion_fixed, motion_free, motion_prescribed, &
      motion_spindle, moves_freely, scene_type
   use contensou_dynamics_reports, only : begin_report, contact_report_type, report_contact
   use contensou_integrate_motion, only : motion_type
   use test_harness, only : check, random_type, worst_type
   use test_scenes, only : damping_index, friction_index, random_touch, rolling_index, set_motion, &
      tangential_index, two_bodies
   implicit none(type, external)
   private

   public :: run_jacobian_tests, defect, set_layout

   !> A law of creep that is smooth and depends on all that one may.
   type, extends(creep_type) :: smooth_creep_type
   contains
      procedure :: kernel => smooth_kernel
   end type smooth_creep_type

contains

   !> Run the tests.
   subroutine run_jacobian_tests()
      call test_kernels()
      call test_damping_slopes()
      call test_two_bodies()
      call test_oblique_rolling()
      call test_steady_rolling()
      call test_rigid_contacts()
      call test_near_rest()
      call test_pattern()
   end subroutine run_jacobian_tests

   !> Jacobians of all friction kernels against differences, away from kinks.
   subroutine test_kernels()
      type(random_type) :: random
      type(friction_model_type), allocatable :: models(:)
      type(spot_shape_type) :: shape
      type(worst_type) :: worst, same
      real(wp) :: v(3), delta, wrench(3), jacobian(3, 3), differences(3, 3), plain(3), speed
      integer :: i, j, k

      models = friction_models()
      do k = 2, size(models)
         worst = worst_type()
         same = worst_type()
         do i = 1, 3000
            shape = elliptic_shape(10.0_wp**random%uniform(-2.0_wp, 0.0_wp))
            v = random%vector(3)*10.0_wp**random%uniform(-3.0_wp, 3.0_wp)
            v(3) = v(3)*10.0_wp**random%uniform(-3.0_wp, 3.0_wp)
            speed = norm2(v)
            delta = speed*merge(0.0_wp, 10.0_wp**random%uniform(-3.0_wp, 1.0_wp), modulo(i, 3) == 0)
            call models(k)%jacobian(shape, slip_type(v(1), v(2), v(3), delta), wrench, jacobian)
            call models(k)%kernel(shape, slip_type(v(1), v(2), v(3), delta), .true., plain)
            call same%note(maxval(abs(wrench - plain)), i)
            if (.not. smooth(models(k)%info%name, shape, v, delta)) cycle
            do j = 1, 3
               call differ(k, shape, v, delta, j, 1.0e-4_wp*min(speed, maxval(abs(v))), &
                  differences(:, j))
            end do
            call worst%note(maxval(abs(jacobian - differences))/maxval(abs(differences)), i)
         end do
         call worst%check_below(2.0e-6_wp, models(k)%info%name // ": Jacobian against differences")
         call same%check_below(2.0e-15_wp, models(k)%info%name // ": the wrench with the Jacobian")
      end do

   contains

      !> Fourth-order difference of a kernel.
      subroutine differ(model, shape, v, delta, component, h, column)
         !> Number of the model.
         integer, intent(in) :: model
         type(spot_shape_type), intent(in) :: shape
         !> Velocities.
         real(wp), intent(in) :: v(3)
         !> Regularisation.
         real(wp), intent(in) :: delta
         !> Which velocity varies.
         integer, intent(in) :: component
         !> By how much.
         real(wp), intent(in) :: h
         !> Derivatives.
         real(wp), intent(out) :: column(3)
         real(wp) :: x(3), f(3, -2:2)
         integer :: m

         do m = -2, 2
            x = v
            x(component) = x(component) + m*h
            call models(model)%kernel(shape, slip_type(x(1), x(2), x(3), delta), .true., f(:, m))
         end do
         column = (8.0_wp*(f(:, 1) - f(:, -1)) - (f(:, 2) - f(:, -2)))/(12.0_wp*h)
      end subroutine differ

      !> Whether a state is away from the kinks of a model and from the scale of its spin.
      function smooth(name, shape, v, delta) result(is)
         !> The model.
         character(len=*), intent(in) :: name
         type(spot_shape_type), intent(in) :: shape
         !> Velocities.
         real(wp), intent(in) :: v(3)
         !> Regularisation.
         real(wp), intent(in) :: delta
         logical :: is
         real(wp) :: s, w, edges(6), t1

         s = hypot(v(1), v(2))
         w = abs(v(3))
         is = min(w, s) > 0.03_wp*max(w, s)
         t1 = 0.2_wp*(v(1)**2 + shape%k2*v(2)**2)/s**2
         edges = huge(s)
         if (name == "coulomb") edges(1) = delta
         if (name == "contensou_simplified") then
            edges(:4) = [delta, w/shape%slope_x, w/shape%slope_y, t1*w/shape%torque]
            ! Where the spin is below the regularisation, the torque fades.
            if (delta > 0.0_wp) edges(5:) = s*w/(delta*[shape%slope_x, shape%slope_y])
         end if
         is = is .and. all(abs(s - edges) > 0.02_wp*s)
         ! A slender spot spinning about a rim point changes over a fraction of its width.
         if (shape%k < 0.1_wp) is = is .and. abs(v(1)) > 0.1_wp*abs(v(2))
      end function smooth

   end subroutine test_kernels

   !> Derivatives of the damping laws.
   subroutine test_damping_slopes()
      type(random_type) :: random
      type(damping_model_type), allocatable :: models(:)
      type(worst_type) :: worst
      real(wp) :: x(3), h(3), slopes(3), ahead(3), behind(3), coefficient
      integer :: i, j, k

      models = damping_models()
      do k = 2, size(models)
         worst = worst_type()
         do i = 1, 1000
            x = [10.0_wp**random%uniform(-3.0_wp, 3.0_wp), 10.0_wp**random%uniform(-9.0_wp, &
               -3.0_wp), &
               random%uniform(-1.0_wp, 1.0_wp)]
            coefficient = 10.0_wp**random%uniform(-2.0_wp, 2.0_wp)
            slopes = models(k)%slopes(x(1), x(2), x(3), coefficient)
            do j = 1, 3
               h = 0.0_wp
               h(j) = 1.0e-5_wp*abs(x(j))
               ahead = x + h
               behind = x - h
               call worst%note(abs((models(k)%kernel(ahead(1), ahead(2), ahead(3), coefficient) &
                  - models(k)%kernel(behind(1), behind(2), behind(3), coefficient))/(2.0_wp*h(j)) &
                  - slopes(j))*abs(x(j))/(abs(models(k)%kernel(x(1), x(2), x(3), coefficient)) &
                  + tiny(x)), i)
            end do
         end do
         call worst%check_below(1.0e-9_wp, models(k)%info%name // ": derivatives")
      end do
   end subroutine test_damping_slopes

   !> Dense Jacobian of a motion.
   subroutine dense(motion, t, y, matrix)
      type(motion_type), intent(inout) :: motion
      !> Time [s].
      real(wp), intent(in) :: t
      !> State.
      real(wp), intent(in) :: y(:)
      real(wp), intent(out) :: matrix(:, :)
      real(wp) :: value(size(motion%row))
      integer :: i, j

      call motion%jacobian(t, y, value)
      matrix = 0.0_wp
      do j = 1, motion%n
         do i = motion%column_start(j), motion%column_start(j + 1) - 1
            matrix(motion%row(i), j) = matrix(motion%row(i), j) + value(i)
         end do
      end do
   end subroutine dense

   !> Largest difference of a Jacobian from differences of the right-hand side, each row against its
   !> largest term when every unknown moves by its scale.
   function defect(motion, t, y, scale, reach) result(worst)
      type(motion_type), intent(inout) :: motion
      !> Time [s].
      real(wp), intent(in) :: t
      !> State.
      real(wp), intent(in) :: y(:)
      !> Size of the variation of each unknown.
      real(wp), intent(in) :: scale(:)
      !> Share of it that the differences step over [-].
      real(wp), intent(in) :: reach
      real(wp) :: worst
      real(wp) :: matrix(size(y), size(y)), differences(size(y), size(y)), f(size(y), 4), x(size(y))
      real(wp), parameter :: share(4) = [-2.0_wp, -1.0_wp, 1.0_wp, 2.0_wp]
      integer :: i, j, k

      call dense(motion, t, y, matrix)
      do j = 1, size(y)
         do k = 1, 4
            x = y
            x(j) = x(j) + share(k)*reach*scale(j)
            call motion%system%derivative(t, x, f(:, k))
         end do
         differences(:, j) = (8.0_wp*(f(:, 3) - f(:, 2)) - (f(:, 4) - f(:, 1)))/(12.0_wp*reach)
         matrix(:, j) = matrix(:, j)*scale(j)
      end do
      worst = 0.0_wp
      do i = 1, size(y)
         if (maxval(abs(differences(i, :))) <= 0.0_wp .and. maxval(abs(matrix(i, &
            :))) <= 0.0_wp) cycle
         worst = max(worst, maxval(abs(matrix(i, :) - differences(i, :))) &
            /max(maxval(abs(differences(i, :))), maxval(abs(matrix(i, :)))))
      end do
   end function defect

   !> All parts of the equations of motion, both orders of the surfaces, driven and loaded bodies.
   subroutine test_two_bodies()
      type(random_type) :: random
      type(scene_type) :: scene
      type(motion_type) :: motion
      type(damping_model_type), allocatable :: dampings(:)
      type(friction_model_type), allocatable :: frictions(:)
      type(worst_type) :: worst
      real(wp), allocatable :: y(:), start(:), scale(:)
      real(wp) :: approach
      integer :: i, d, f, k

      dampings = damping_models()
      frictions = friction_models()
      do d = 1, size(dampings)
         do f = 1, size(frictions)
            worst = worst_type()
            do i = 1, 40
               call two_bodies(scene, d, f, modulo(i, 2) == 0)
               call set_motion(scene, motion, start)
               motion%system%resolution%square = 0.0_wp
               associate (law => motion%system%contacts(1)%law, bodies => motion%system%bodies)
                  if (modulo(i, 3) == 1) then
                     allocate(law%rolling, source=lever_type(follows_spot=i > 20, &
                        coefficient=merge(1.0e-3_wp, 0.2_wp, i > 20), &
                        regularization=merge(0.1_wp, 1.0e3_wp, modulo(i, 2) == 0)))
                  end if
                  if (modulo(i, 4) == 1) bodies(1)%motion = motion_prescribed
                  if (modulo(i, 4) == 2) bodies(2)%motion = motion_fixed
                  if (modulo(i, 8) == 3) bodies(1)%motion = motion_spindle
                  if (modulo(i, 8) == 7) bodies(2)%motion = motion_spindle
                  bodies(1)%ramp = merge(1.0_wp, 0.0_wp, modulo(i, 8) < 4)
                  bodies(1)%acceleration = random%vector(3)
                  bodies(1)%angular_acceleration = random%vector(3)
                  bodies(2)%loaded = moves_freely(bodies(2)%motion) .and. i > 10
                  bodies(2)%load_follows = i > 25
                  bodies(2)%force = random%vector(3)
                  ! A drive takes the torque on a spindle.
                  if (bodies(2)%motion == motion_free) bodies(2)%torque = 0.01_wp*random%vector(3)
                  bodies(2)%ramp = bodies(1)%ramp
                  bodies(2)%angular_acceleration = random%vector(3)
               end associate
               call motion%system%prepare()
               call set_layout(motion)
               y = [(0.0_wp, k=1, motion%n)]
               approach = 10.0_wp**random%uniform(-6.0_wp, -4.0_wp)
               call random_touch(scene, random, -approach, y)
               scale = y
               do k = 0, 13, 13
                  scale(k + 1:k + 3) = 0.1_wp*approach
                  scale(k + 4:k + 7) = 0.1_wp*approach
                  scale(k + 8:k + 10) = 0.01_wp
                  scale(k + 11:k + 13) = 0.3_wp
               end do
               scale(27:) = 1.0_wp
               ! What is fixed does not vary.
               if (motion%system%bodies(2)%motion == motion_fixed) scale(14:26) = 0.0_wp
               ! The shorter differences are noisier, the longer ones may step over a kink.
               call worst%note(min(defect(motion, 0.5_wp, y, scale, 5.0e-2_wp), &
                  defect(motion, 0.5_wp, y, scale, 5.0e-3_wp)), i)
            end do
            call worst%check_below(1.0e-6_wp, "equations of motion: Jacobian with " // &
               dampings(d)%info%name // " and " // frictions(f)%info%name)
         end do
      end do
   end subroutine test_two_bodies

   !> Jacobian in steady rolling: the velocity of the material through the spot varies with the pose
   !> and with all velocities.
   subroutine test_steady_rolling()
      character(len=*), parameter :: pairs(*) = [character(len=9) :: "sphere", "ellipsoid", "torus"]
      type(random_type) :: random
      type(scene_type) :: scene
      type(motion_type) :: motion
      type(worst_type) :: worst
      real(wp), allocatable :: y(:), scale(:)
      integer :: i, k, pair

      do pair = 1, size(pairs)
         worst = worst_type()
         do i = 1, 40
            call two_bodies(scene, damping_index("hunt_crossley"), &
               friction_index("contensou_exact"), modulo(i, 2) == 0)
            call scene%contacts(1)%parameters%set("regularization_velocity", 0.0_wp)
            scene%contacts(1)%tangential = tangential_index("rolling")
            if (pair > 1) deallocate(scene%surfaces(1)%surface%shape)
            if (pair == 2) allocate(scene%surfaces(1)%surface%shape, &
               source=ellipsoid_type([0.02_wp, 0.015_wp, 0.004_wp]))
            if (pair == 3) allocate(scene%surfaces(1)%surface%shape, &
               source=torus_type(0.02_wp, 0.005_wp))
            call set_motion(scene, motion, y)
            ! Sliding as fast as the material times the scale of creepage, and what is not resolved.
            motion%system%resolution%square = merge(0.0_wp, 1.0e-2_wp, i < 25)
            associate (law => motion%system%contacts(1)%law)
               deallocate(law%steady%creep)
               allocate(smooth_creep_type :: law%steady%creep)
               call law%steady%begin(0.3_wp, merge(1.0e7_wp, 1.0e6_wp, modulo(i, 3) == 0), 0.3_wp)
            end associate
            call random_touch(scene, random, -1.0e-5_wp, y)
            scale = y
            scale = 1.0_wp
            do k = 0, 13, 13
               scale(k + 1:k + 7) = 1.0e-6_wp
               scale(k + 8:k + 10) = 0.01_wp
               scale(k + 11:k + 13) = 0.1_wp
            end do
            call worst%note(min(defect(motion, 0.5_wp, y, scale, 5.0e-2_wp), &
               defect(motion, 0.5_wp, y, scale, 5.0e-3_wp)), i)
         end do
         call worst%check_below(1.0e-6_wp, "steady rolling: Jacobian of a " // &
            trim(pairs(pair)) // " on a plane")
      end do
   end subroutine test_steady_rolling

   !> Wrench that falls with the velocity of the material, coupled in all components.
   pure subroutine smooth_kernel(self, spot, motion, wrench)
      class(smooth_creep_type), intent(in) :: self
      type(creep_spot_type), intent(in) :: spot
      type(creep_motion_type), intent(in) :: motion
      real(wp), intent(out) :: wrench(3)
      real(wp) :: size

      associate (m => motion)
         size = sqrt(m%x**2 + m%y**2 + spot%shape%k*m%spin**2 + 4.0_wp*m%rx**2 + m%ry**2)
         wrench(1) = -(m%x + 0.1_wp*m%ry*m%spin/size)/size
         wrench(2) = -(m%y - 0.1_wp*m%rx*m%spin/size)/size
         wrench(3) = -0.5_wp*(m%spin + 0.1_wp*(m%rx*m%y - m%ry*m%x)/size)/size
      end associate
   end subroutine smooth_kernel

   !> Rolling resistance that follows an elliptic spot, rolling in any direction: it takes the
   !> elastic work of the leading half of the spot, by quadrature; and the Jacobian where the
   !> curvatures vary, with compliance and without.
   subroutine test_oblique_rolling()
      integer, parameter :: rings = 40, rays = 400
      type(random_type) :: random
      type(scene_type) :: scene
      type(motion_type) :: motion
      type(worst_type) :: worst, oblique(2)
      type(contact_report_type) :: row
      type(lever_type) :: lever
      real(wp), allocatable :: y(:), scale(:), rate(:)
      real(wp) :: a, b, load, spin(3), work, radius, angle, x(2), approach
      integer :: i, j, k, kind

      lever%coefficient = 0.7_wp
      lever%regularization = 1.0e-9_wp
      lever%follows_spot = .true.
      do i = 1, 50
         a = 1.0e-3_wp
         b = a*10.0_wp**random%uniform(-2.0_wp, 0.0_wp)
         load = random%uniform(1.0_wp, 10.0_wp)
         spin = random%vector(3)
         if (modulo(i, 5) == 0) spin(1) = 0.0_wp
         work = 0.0_wp
         do j = 1, rings
            do k = 1, rays
               angle = (k - 0.5_wp)*2.0_wp*pi/rays
               radius = sin((j - 0.5_wp)*0.5_wp*pi/rings)
               x = radius*[a*cos(angle), b*sin(angle)]
               ! Pressure over the mean one is (3/2) sqrt(1 - r^2); dr = sqrt(1 - r^2) dt.
               work = work + max(spin(1)*x(2) - spin(2)*x(1), 0.0_wp) &
                  *1.5_wp*(1.0_wp - radius**2)*radius
            end do
         end do
         work = load*work/pi*(0.5_wp*pi/rings)*(2.0_wp*pi/rays)
         associate (moment => lever%torque(load, [0.0_wp, 0.0_wp, 1.0_wp], &
            [1.0_wp, 0.0_wp, 0.0_wp], a, b, spin))
            call worst%note(abs(dot_product(moment, spin)/(0.7_wp*work) + 1.0_wp), i)
         end associate
      end do
      call worst%check_below(1.0e-3_wp, &
         "hysteresis takes its share of the elastic work of the leading half")
      do i = 1, 60
         kind = 1 + modulo(i, 2)
         call two_bodies(scene, 1, friction_index("contensou_exact"), modulo(i, 4) < 2)
         deallocate(scene%surfaces(1)%surface%shape)
         allocate(scene%surfaces(1)%surface%shape, &
            source=ellipsoid_type([0.02_wp, 0.015_wp, 0.004_wp]))
         scene%contacts(1)%rolling = rolling_index("hysteresis")
         call scene%contacts(1)%parameters%set("rolling_coefficient", 1.0_wp)
         call scene%contacts(1)%parameters%set("rolling_regularization", 0.1_wp)
         if (kind == 2) scene%contacts(1)%normal = normal_rigid
         call set_motion(scene, motion, y)
         motion%system%resolution%square = 0.0_wp
         approach = merge(1.0e-5_wp, 0.0_wp, kind == 1)
         call random_touch(scene, random, -approach, y)
         if (kind == 2) then
            do k = 1, 20
               call begin_report(motion%system, 0.0_wp, y)
               call report_contact(motion%system, 1, row)
               y(1:3) = y(1:3) + merge(-1.0_wp, 1.0_wp, scene%contacts(1)%surfaces(2) == 1) &
                  *row%at%gap*row%at%normal
            end do
            motion%system%contacts%closed = .true.
            if (.not. allocated(rate)) allocate(rate(1))
            call stop_gap(motion, 1, 1, y, rate)
            call motion%system%constraint_forces(0.5_wp, y)
            if (motion%system%outside) cycle
         end if
         scale = y
         scale = 1.0_wp
         do k = 0, 13, 13
            scale(k + 1:k + 7) = 1.0e-6_wp
            scale(k + 8:k + 10) = 0.01_wp
            scale(k + 11:k + 13) = 0.1_wp
         end do
         call oblique(kind)%note(min(defect(motion, 0.5_wp, y, scale, 5.0e-2_wp), &
            defect(motion, 0.5_wp, y, scale, 5.0e-3_wp)), i)
      end do
      call oblique(1)%check_below(1.0e-6_wp, "hysteresis, varying curvatures: Jacobian")
      call oblique(2)%check_below(1.0e-6_wp, "hysteresis, rigid, varying curvatures: Jacobian")
   end subroutine test_oblique_rolling

   !> Rigid contacts of several surfaces, beside others, of driven and loaded bodies, which
   !> move as the constraints ask for, as they do in a run.
   subroutine test_rigid_contacts()
      integer, parameter :: samples = 240
      type(random_type) :: random
      type(scene_type) :: scene
      type(motion_type) :: motion
      type(friction_model_type), allocatable :: frictions(:)
      type(worst_type) :: worst(3)
      type(contact_report_type) :: row
      real(wp), allocatable :: y(:), rate(:), scale(:)
      character(len=*), parameter :: kinds(3) = [character(len=24) :: "one contact", &
         "beside one of compliance", "two contacts"]
      real(wp) :: e(3)
      integer :: i, kind, f, k, checked(3)

      frictions = friction_models()
      checked = 0
      do i = 1, samples
         kind = 1 + modulo(i, 3)
         f = 1 + modulo(i/3, size(frictions))
         call two_bodies(scene, 1 + modulo(i, 2), f, modulo(i, 4) < 2)
         scene%contacts(1)%normal = normal_rigid
         scene%contacts(1)%damping = 1
         if (modulo(i, 5) < 3) then
            ! By assignment gfortran 12 would write a larger type into the room of the smaller.
            deallocate(scene%surfaces(1)%surface%shape)
            allocate(scene%surfaces(1)%surface%shape, &
               source=ellipsoid_type([0.02_wp, 0.015_wp, 0.012_wp]))
         end if
         if (modulo(i, 5) == 4) then
            scene%contacts(1)%rolling = rolling_index(trim(merge("constant  ", "hysteresis", &
               modulo(i, 2) == 0)))
            call scene%contacts(1)%parameters%set("rolling_coefficient", 1.0e-2_wp)
            call scene%contacts(1)%parameters%set("rolling_regularization", 10.0_wp)
         end if
         if (modulo(i, 8) == 1) scene%bodies(1)%motion = motion_prescribed
         ! What does not yield has no contact with the ground.
         if (modulo(i, 8) == 2 .and. kind == 1) scene%bodies(2)%motion = motion_prescribed
         if (modulo(i, 8) == 5 .and. kind == 1) scene%bodies(2)%motion = motion_fixed
         call set_motion(scene, motion, y)
         call random_touch(scene, random, 0.0_wp, y)
         ! Not by the distance of the spheres' centres: the surfaces themselves touch.
         do k = 1, 20
            call begin_report(motion%system, 0.0_wp, y)
            call report_contact(motion%system, 1, row)
            e = row%at%gap*row%at%normal
            if (scene%contacts(1)%surfaces(2) == 1) e = -e
            y(1:3) = y(1:3) + e
         end do
         if (abs(row%at%gap) > 1.0e-12_wp) cycle
         if (kind > 1) call add_support(scene, kind == 3, y, random)
         scale = y(:26)
         call set_motion(scene, motion, y)
         y(:26) = scale
         y(27:) = 0.0_wp
         associate (bodies => motion%system%bodies)
            do k = 1, 2
               bodies(k)%acceleration = random%vector(3)
               bodies(k)%angular_acceleration = random%vector(3)
               bodies(k)%ramp = merge(1.0_wp, 0.0_wp, i > samples/2)
            end do
            bodies(2)%loaded = bodies(2)%motion == motion_free
            bodies(2)%load_follows = modulo(i, 3) == 0
            bodies(2)%force = random%vector(3)
            bodies(2)%torque = 0.01_wp*random%vector(3)
         end associate
         call motion%system%prepare()
         call set_layout(motion)
         if (size(y) /= motion%n) y = [y(:26), [(0.0_wp, k=27, motion%n)]]
         motion%system%resolution%square = 0.0_wp
         motion%system%contacts%closed = motion%system%contacts%rigid
         if (allocated(rate)) deallocate(rate)
         allocate(rate(size(motion%system%contacts)))
         ! From the ground upwards, none spoils another one.
         if (kind == 3) call stop_gap(motion, 2, 14, y, rate)
         call stop_gap(motion, 1, 1, y, rate)
         if (allocated(scale)) deallocate(scale)
         allocate(scale(size(y)), source=1.0_wp)
         do k = 0, 13, 13
            scale(k + 1:k + 3) = 1.0e-6_wp
            scale(k + 4:k + 7) = 1.0e-6_wp
            scale(k + 8:k + 10) = 0.01_wp
            scale(k + 11:k + 13) = 0.3_wp
         end do
         if (motion%system%bodies(2)%motion == motion_fixed) scale(14:26) = 0.0_wp
         call motion%system%constraint_forces(0.5_wp, y)
         if (motion%system%outside) cycle
         checked(kind) = checked(kind) + 1
         ! Longer differences have errors where something slides slowly.
         call worst(kind)%note(min(defect(motion, 0.5_wp, y, scale, 2.0e-2_wp), &
            defect(motion, 0.5_wp, y, scale, 2.0e-3_wp)), i)
      end do
      do kind = 1, 3
         call check(checked(kind) > samples/5, "rigid contacts, " // trim(kinds(kind)) // &
            ": states are found")
         call worst(kind)%check_below(1.0e-6_wp, "rigid contacts, " // trim(kinds(kind)) // &
            ": Jacobian")
      end do
   end subroutine test_rigid_contacts

   !> Add a sphere to the second body that touches one of the ground.
   subroutine add_support(scene, rigid, y, random)
      !> The scene, of two bodies.
      type(scene_type), intent(inout) :: scene
      !> Whether the contact is rigid.
      logical, intent(in) :: rigid
      !> State of the bodies.
      real(wp), intent(in) :: y(:)
      !> The generator.
      type(random_type), intent(inout) :: random
      real(wp), parameter :: centre(3) = [3.0e-3_wp, 4.0e-3_wp, -2.0e-3_wp]
      type(scene_type) :: wider
      real(wp) :: direction(3)

      direction = random%vector(3)
      direction = direction/norm2(direction)
      wider = scene
      deallocate(wider%surfaces, wider%contacts)
      allocate(wider%surfaces(4), wider%contacts(2))
      wider%surfaces(1:2) = scene%surfaces
      wider%surfaces(3) = scene%surfaces(1)
      wider%surfaces(3)%body = 2
      wider%surfaces(3)%surface%shape = sphere_type(0.012_wp)
      wider%surfaces(3)%surface%centre = centre
      wider%surfaces(4) = wider%surfaces(3)
      wider%surfaces(4)%body = 0
      wider%surfaces(4)%surface%centre = y(14:16) + matmul(rotation_matrix(y(17:20)), centre) &
         + (0.024_wp - merge(0.0_wp, 1.0e-5_wp, rigid))*direction
      wider%contacts(1) = scene%contacts(1)
      wider%contacts(2) = scene%contacts(1)
      wider%contacts(2)%surfaces = [4, 3]
      if (.not. rigid) wider%contacts(2)%normal = normal_hertz
      wider%contacts(2)%rolling = 1
      scene = wider
   end subroutine add_support

   !> Change the velocity of a body so that a gap stays as it is.
   subroutine stop_gap(motion, contact, first, y, rate)
      type(motion_type), intent(inout) :: motion
      integer, intent(in) :: contact
      !> Index of the state of a body of it.
      integer, intent(in) :: first
      !> State.
      real(wp), intent(inout) :: y(:)
      !> Rates of the gaps [m/s].
      real(wp), intent(inout) :: rate(:)
      type(contact_motion_type) :: now
      real(wp) :: normal(3)

      associate (c => motion%system%contacts(contact))
         call motion%system%gap_rates(y, rate)
         call motion%system%observe(contact, now)
         normal = merge(-1.0_wp, 1.0_wp, 13*(c%a - 1) + 1 == first)*now%at%normal
         y(first + 7:first + 9) = y(first + 7:first + 9) - rate(contact)*normal
      end associate
   end subroutine stop_gap

   !> Lay out a Jacobian anew.
   subroutine set_layout(motion)
      !> The motion, its system prepared.
      type(motion_type), intent(inout) :: motion

      motion%n = motion%system%layout%n
      call motion%differential%prepare(motion%system)
      motion%column_start = motion%differential%column_start
      motion%row = motion%differential%row
   end subroutine set_layout

   !> Near rest, where what is not resolved regularises the friction.
   subroutine test_near_rest()
      type(random_type) :: random
      type(friction_model_type), allocatable :: models(:)
      type(worst_type) :: worst, far
      type(scene_type) :: scene
      type(motion_type) :: motion
      real(wp), allocatable :: y(:)
      real(wp) :: v(3), wrench(3), slopes(3, 5), f(3, -2:2), r2, x(3), h, plain(3)
      integer :: i, j, m

      call two_bodies(scene, 1, friction_index("contensou_exact"), .true.)
      call set_motion(scene, motion, y)
      call check(motion%system%resolution%square > 0.0_wp, "a motion knows what is resolved")
      models = friction_models()
      associate (part => motion%system%contacts(1)%law%friction, &
         shape => motion%system%contacts(1)%law%normal%shape)
         r2 = 1.0e-14_wp
         do i = 1, 300
            v = random%vector(3)*1.0e-7_wp*10.0_wp**random%uniform(-2.0_wp, 1.5_wp)
            call part%linearize(shape, sliding_type(3.0_wp, 1.0_wp, v(1), v(2), v(3), r2), &
               wrench, slopes)
            do j = 1, 3
               h = 1.0e-3_wp*norm2(v)
               do m = -2, 2
                  x = v
                  x(j) = x(j) + m*h
                  call part%wrench(shape, sliding_type(3.0_wp, 1.0_wp, x(1), x(2), x(3), r2), &
                     f(:, m))
               end do
               call worst%note(maxval(abs((8.0_wp*(f(:, 1) - f(:, -1)) - (f(:, 2) - f(:, -2))) &
                  /(12.0_wp*h) - slopes(:, 2 + j)))/maxval(abs(slopes(:, 3:))), i)
            end do
            v = 1.0e-5_wp*v/norm2(v)
            call part%wrench(shape, sliding_type(3.0_wp, 1.0_wp, v(1), v(2), v(3), r2), wrench)
            call part%wrench(shape, sliding_type(3.0_wp, 1.0_wp, v(1), v(2), v(3)), plain)
            call far%note(maxval(abs(wrench - plain)), i)
         end do
      end associate
      call worst%check_below(1.0e-6_wp, "near rest: Jacobian against differences")
      call far%check_below(1.0e-14_wp, &
         "a hundred times what is resolved from rest: the exact wrench")
   end subroutine test_near_rest

   !> Entries of a column are in ascending order and on the diagonal, too.
   subroutine test_pattern()
      type(scene_type) :: scene
      type(motion_type) :: motion
      real(wp), allocatable :: y(:)
      integer :: j
      logical :: ascending, diagonal

      call two_bodies(scene, 2, 3, .true.)
      call set_motion(scene, motion, y)
      ascending = .true.
      diagonal = .true.
      do j = 1, motion%n
         associate (rows => motion%row(motion%column_start(j):motion%column_start(j + 1) - 1))
            ascending = ascending .and. all(rows(2:) > rows(:size(rows) - 1))
            diagonal = diagonal .and. any(rows == j)
         end associate
      end do
      call check(ascending, "layout of the Jacobian: rows in ascending order")
      call check(diagonal, "layout of the Jacobian: the diagonal is there")
   end subroutine test_pattern

end module test_jacobian
