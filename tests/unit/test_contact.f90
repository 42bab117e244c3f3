!> Tests of the parts of a contact: normal force, damping, geometry, law, tables of models.
module test_contact
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite, ieee_is_nan
   use contensou_base_kinds, only : pi, wp
   use contensou_base_rotations, only : rotation_matrix
   use contensou_base_schema, only : key_type
   use contensou_base_text, only : string_type
   use contensou_base_vectors, only : cross, frame_along
   use contensou_contact_catalogue, only : model_info_type
   use contensou_contact_damping, only : damping_model_type, damping_models
   use contensou_contact_damping_coefficient, only : coefficient_damping_type, &
      hunt_crossley_number, tsuji_factor
   use contensou_contact_friction, only : friction_model_type, friction_models
   use contensou_contact_friction_ladder, only : rung_type
   use contensou_contact_geometry, only : contact_motion_type, contact_point_type, geometry_type, &
      pose_type, track_type
   use contensou_contact_hertz, only : effective_modulus
   use contensou_contact_law, only : contact_law_type, contact_load_type
   use contensou_contact_normal, only : normal_model_type, normal_models, normal_type
   use contensou_contact_normal_law, only : new_normal
   use contensou_contact_pairs, only : geometry_models, new_geometry
   use contensou_contact_spot, only : circular_shape
   use contensou_contact_shapes_plane, only : plane_type
   use contensou_contact_shapes_sphere, only : sphere_type
   use contensou_contact_surface, only : surface_type
   use contensou_contact_wrench, only : slip_type, wrench_exact
   use contensou_dynamics_scene, only : scene_type
   use contensou_integrate_motion, only : motion_type
   use contensou_scene_schema, only : schema_keys
   use contensou_dynamics_mechanism, only : slip_velocity
   use contensou_special_quadrature, only : w_16, w_4, w_8, x_16, x_4, x_8
   use test_harness, only : check, check_close, check_relative, random_type, read_table, &
      table_type, worst_type
   use test_scenes, only : damping_index, friction_index, random_touch, set_motion, two_bodies
   implicit none(type, external)
   private

   public :: run_contact_tests, new_damping, rebound, impact_coefficient

   !> Mass of the ball of an impact [kg].
   real(wp), parameter :: impact_mass = 0.1_wp

   !> Stiffness of its contact [N/m^(3/2)].
   real(wp), parameter :: impact_stiffness = 1.0e9_wp

   !> Square root of their product, the unit of Tsuji's coefficient.
   real(wp), parameter :: impact_coefficient = sqrt(impact_mass)

   !> Precision of the defining equation of a restitution, which cancels.
   integer, parameter :: qp = selected_real_kind(30)

contains

   !> Run all tests.
   subroutine run_contact_tests()
      call test_quadrature()
      call test_hertz()
      call test_modulus()
      call test_damping_laws()
      call test_hunt_crossley_number()
      call test_hunt_crossley_impact()
      call test_tsuji_impact()
      call test_begin_impact()
      call test_sphere_plane()
      call test_pairs()
      call test_gap_rate()
      call test_order()
      call test_law()
      call test_tables()
   end subroutine run_contact_tests

   !> The rules are exact for the monomials they should be exact for.
   subroutine test_quadrature()
      type(worst_type) :: worst_4, worst_8, worst_16
      integer :: n

      do n = 0, 62, 2
         if (n <= 14) call worst_4%note(abs(sum(w_4*x_4**n) - 1.0_wp/(n + 1)), n + 1)
         if (n <= 30) call worst_8%note(abs(sum(w_8*x_8**n) - 1.0_wp/(n + 1)), n + 1)
         call worst_16%note(abs(sum(w_16*x_16**n) - 1.0_wp/(n + 1)), n + 1)
      end do
      call worst_4%check_below(5.0e-16_wp, "quadrature: 4 nodes")
      call worst_8%check_below(5.0e-16_wp, "quadrature: 8 nodes")
      call worst_16%check_below(5.0e-16_wp, "quadrature: 16 nodes")
   end subroutine test_quadrature

   !> Rows of the table with a circular spot; the energy is the integral of the force.
   subroutine test_hertz()
      type(table_type) :: table
      real(wp), allocatable :: a(:), b(:), modulus(:), approach(:), axis(:), load(:), pressure(:)
      type(normal_type) :: normal
      type(worst_type) :: force, major, peak, energy
      real(wp) :: n, x
      integer :: i, rows

      call read_table("hertz", table)
      a = table%column("A")
      b = table%column("B")
      modulus = table%column("Estar")
      approach = table%column("delta")
      axis = table%column("a")
      load = table%column("N")
      pressure = table%column("p0")
      rows = 0
      do i = 1, table%rows
         if (a(i) < b(i)) cycle
         rows = rows + 1
         normal = new_normal(modulus(i), a(i), a(i))
         n = normal%force(approach(i))
         x = normal%major_axis(approach(i))
         call force%note(abs(n/load(i) - 1.0_wp), i)
         call major%note(abs(x/axis(i) - 1.0_wp), i)
         call peak%note(abs(1.5_wp*n/(pi*x**2)/pressure(i) - 1.0_wp), i)
         ! With d = s^2 the integrand is a polynomial.
         x = sqrt(approach(i))
         n = 0.0_wp
         call add_energy()
         call energy%note(abs(normal%energy(approach(i))/n - 1.0_wp), i)
      end do
      call check(rows >= 5, "hertz: the table has rows with a circular spot")
      call force%check_below(1.0e-15_wp, "hertz: force of the table")
      call major%check_below(1.0e-15_wp, "hertz: semi-axis of the table")
      call peak%check_below(2.0e-15_wp, "hertz: largest pressure of the table")
      call energy%check_below(2.0e-15_wp, "hertz: the energy is the integral of the force")
      normal = new_normal(1.0e11_wp, 50.0_wp, 50.0_wp)
      call check_close(normal%force(0.0_wp), 0.0_wp, 0.0_wp, "hertz: no force without approach")
      call check_close(normal%energy(0.0_wp), 0.0_wp, 0.0_wp, "hertz: no energy without approach")
      call check_relative(normal%stiffness, (4.0_wp/3.0_wp)*1.0e11_wp*sqrt(0.01_wp), &
         1.0e-15_wp, "hertz: stiffness by radius")

   contains

      !> Add up the energy of this row in `n`.
      subroutine add_energy()
         integer :: k

         do k = 1, size(x_8)
            n = n + x*w_8(k)*2.0_wp*x*x_8(k)*normal%force((x*x_8(k))**2)
         end do
      end subroutine add_energy

   end subroutine test_hertz

   !> Effective modulus.
   subroutine test_modulus()
      call check_relative(effective_modulus(9.1e9_wp, 0.3_wp, 9.1e9_wp, 0.3_wp), 5.0e9_wp, &
         1.0e-15_wp, "modulus: two like materials")
      call check_relative(effective_modulus(1.0e9_wp, 0.0_wp, 3.0e9_wp, 0.5_wp), 0.8e9_wp, &
         1.0e-15_wp, "modulus: two materials")
      call check_relative(effective_modulus(1.0e9_wp, 0.0_wp, 3.0e9_wp, 0.5_wp), &
         effective_modulus(3.0e9_wp, 0.5_wp, 1.0e9_wp, 0.0_wp), 1.0e-15_wp, "modulus: symmetric")
      call check_relative(effective_modulus(1.0e9_wp, 0.5_wp, 1.0e300_wp, 0.3_wp), &
         1.0e9_wp/0.75_wp, 1.0e-15_wp, "modulus: against a rigid body")
   end subroutine test_modulus

   !> Formulas of the damping laws; they never pull.
   subroutine test_damping_laws()
      type(damping_model_type), allocatable :: models(:)
      type(coefficient_damping_type) :: damping
      type(random_type) :: random
      type(worst_type) :: formula, pull
      character(len=:), allocatable :: name
      real(wp) :: elastic, approach, rate, expected, f
      integer :: i, j

      models = damping_models()
      do i = 1, size(models)
         name = trim(models(i)%info%name)
         if (.not. associated(models(i)%kernel)) cycle
         damping%kernel => models(i)%kernel
         formula = worst_type()
         pull = worst_type()
         do j = 1, 10000
            damping%coefficient = abs(random%decades(-2.0_wp, 3.0_wp))
            elastic = abs(random%decades(-3.0_wp, 3.0_wp))
            approach = abs(random%decades(-9.0_wp, -3.0_wp))
            rate = random%decades(-4.0_wp, 2.0_wp)
            select case (name)
            case ("hunt_crossley")
               expected = elastic*(1.0_wp + 1.5_wp*damping%coefficient*rate)
            case ("viscous")
               expected = elastic + damping%coefficient*approach*rate
            case ("tsuji")
               expected = elastic + damping%coefficient*sqrt(elastic/approach)*rate
            case default
               expected = -1.0_wp
            end select
            f = damping%total(elastic, approach, rate)
            call formula%note(abs(f - max(expected, 0.0_wp))/max(elastic, abs(expected)), j)
            call pull%note(-f, j)
         end do
         call formula%check_below(2.0e-15_wp, name // ": formula")
         call pull%check_below(0.0_wp, name // ": never pulls")
         call check_close(damping%total(1.0_wp, 1.0e-3_wp, -1.0e9_wp), 0.0_wp, 0.0_wp, &
            name // ": no force when the bodies separate fast")
         call check_close(damping%total(1.0_wp, 1.0e-3_wp, 0.0_wp), 1.0_wp, 0.0_wp, &
            name // ": the elastic force at rest")
      end do
   end subroutine test_damping_laws

   !> The number D of a restitution: its defining equation holds for a restitution that differs from
   !> the given one by rounding.
   subroutine test_hunt_crossley_number()
      type(worst_type) :: below, above, order
      real(wp) :: e, d, before
      integer :: i, n

      n = 0
      before = huge(before)
      do i = 0, 360
         if (i < 100) then
            e = 10.0_wp**(-6.0_wp + 0.05_wp*i)
         else if (i < 120) then
            e = 0.1_wp + 0.04_wp*(i - 100)
         else
            e = 1.0_wp - 10.0_wp**(-0.05_wp*(i - 120))
         end if
         if (e <= 0.0_wp) cycle
         if (i == 360) e = 1.0_wp - 1.0e-12_wp
         d = hunt_crossley_number(e)
         n = n + 1
         call below%note(merge(0.0_wp, 1.0_wp, excess(e, -256.0_wp*epsilon(e), d) <= 0.0_qp), n)
         call above%note(merge(0.0_wp, 1.0_wp, excess(e, 256.0_wp*epsilon(e), d) >= 0.0_qp), n)
         call order%note(merge(0.0_wp, 1.0_wp, d > 0.0_wp .and. d <= 1.0_wp/e), n)
      end do
      call below%check_below(0.0_wp, "hunt_crossley_number: not below its equation")
      call above%check_below(0.0_wp, "hunt_crossley_number: not above its equation")
      call order%check_below(0.0_wp, "hunt_crossley_number: 0 < D <= 1/e")
      call check_close(hunt_crossley_number(1.0_wp), 0.0_wp, 0.0_wp, "hunt_crossley_number: e = 1")
      call check_relative(hunt_crossley_number(1.0e-6_wp), 1.0e6_wp, 1.0e-15_wp, &
         "hunt_crossley_number: 1/e for small e")
      call check(ieee_is_nan(hunt_crossley_number(0.0_wp)), "hunt_crossley_number: NaN for e = 0")
      call check(ieee_is_nan(hunt_crossley_number(-0.5_wp)), "hunt_crossley_number: NaN for e < 0")
      call check(ieee_is_nan(hunt_crossley_number(1.5_wp)), "hunt_crossley_number: NaN for e > 1")

   contains

      !> ln((1 + D)/(1 - e D)) - (1 + e) D at e (1 + shift), over D^2; huge where 1 - e D <= 0.
      pure function excess(restitution, shift, number) result(f)
         !> Coefficient of restitution.
         real(wp), intent(in) :: restitution
         !> Relative shift of it.
         real(wp), intent(in) :: shift
         !> Number D.
         real(wp), intent(in) :: number
         real(qp) :: f
         real(qp) :: x, y
         integer :: k

         x = real(restitution, qp)*(1.0_qp + shift)
         y = real(number, qp)
         if (y < 1.0e-2_qp) then
            f = 0.0_qp
            do k = 30, 2, -1
               f = f*y + (x**k - (-1.0_qp)**k)/k
            end do
         else if (1.0_qp - x*y > 0.0_qp) then
            f = (log(1.0_qp + y) - log(1.0_qp - x*y) - (1.0_qp + x)*y)/y**2
         else
            f = huge(f)
         end if
      end function excess

   end subroutine test_hunt_crossley_number

   !> A damping law by name.
   function new_damping(name) result(damping)
      !> The law.
      character(len=*), intent(in) :: name
      type(coefficient_damping_type) :: damping
      type(damping_model_type), allocatable :: models(:)

      models = damping_models()
      damping%kernel => models(damping_index(name))%kernel
   end function new_damping

   !> Speed of rebound over speed of impact, by integrating an impact with Runge-Kutta's method
   !> until the approach is zero again.
   function rebound(damping, speed, clamped) result(e)
      !> The law.
      type(coefficient_damping_type), intent(in) :: damping
      !> Speed of impact [m/s].
      real(wp), intent(in) :: speed
      !> Whether the force is kept from pulling.
      logical, intent(in) :: clamped
      real(wp) :: e
      real(wp) :: h, y(2), before(2), k1(2), k2(2), k3(2), k4(2)
      integer :: i

      ! Some 10000 steps of an elastic impact.
      h = 3.0e-4_wp*(impact_mass**2/(impact_stiffness**2*speed))**0.2_wp
      y = [0.0_wp, speed]
      do i = 1, 1000000
         before = y
         k1 = rate(y)
         k2 = rate(y + 0.5_wp*h*k1)
         k3 = rate(y + 0.5_wp*h*k2)
         k4 = rate(y + h*k3)
         y = y + h/6.0_wp*(k1 + 2.0_wp*k2 + 2.0_wp*k3 + k4)
         if (y(1) <= 0.0_wp) exit
      end do
      e = -(before(2) + (y(2) - before(2))*before(1)/(before(1) - y(1)))/speed

   contains

      !> Rates of approach and of its rate.
      function rate(state) result(r)
         !> Approach and its rate.
         real(wp), intent(in) :: state(2)
         real(wp) :: r(2)
         real(wp) :: d, elastic, force

         d = max(state(1), 0.0_wp)
         elastic = impact_stiffness*d*sqrt(d)
         if (clamped) then
            force = damping%total(elastic, d, state(2))
         else
            force = elastic + damping%kernel(elastic, d, state(2), damping%coefficient)
         end if
         r = [state(2), -force/impact_mass]
      end function rate

   end function rebound

   !> Restitution of the Hunt-Crossley law by integrating the impact.
   subroutine test_hunt_crossley_impact()
      type(coefficient_damping_type) :: damping
      real(wp), parameter :: e(*) = [0.05_wp, 0.2_wp, 0.5_wp, 0.8_wp, 0.95_wp, 0.999_wp, 1.0_wp]
      real(wp) :: speed
      character(len=8) :: label
      integer :: i

      damping = new_damping("hunt_crossley")
      do i = 1, size(e)
         speed = 0.1_wp*i
         damping%coefficient = hunt_crossley_number(e(i))/(1.5_wp*speed)
         write(label, "(f5.3)") e(i)
         call check_close(rebound(damping, speed, .true.), e(i), 1.0e-5_wp, &
            "hunt_crossley: an impact has the restitution " // trim(label))
      end do
   end subroutine test_hunt_crossley_impact

   !> Restitution of Tsuji's law by integrating the impact; its formula is that of the law that may
   !> pull at the end.
   subroutine test_tsuji_impact()
      type(coefficient_damping_type) :: damping
      real(wp), parameter :: e(*) = [0.1_wp, 0.3_wp, 0.5_wp, 0.8_wp, 0.95_wp, 1.0_wp]
      character(len=8) :: label
      integer :: i

      damping = new_damping("tsuji")
      do i = 1, size(e)
         damping%coefficient = tsuji_factor(e(i))*impact_coefficient
         write(label, "(f5.3)") e(i)
         call check_close(rebound(damping, 0.2_wp*i, .false.), e(i), 1.0e-3_wp, &
            "tsuji: an impact has the restitution " // trim(label))
         call check(rebound(damping, 0.2_wp*i, .true.) >= e(i) - 1.0e-5_wp, &
            "tsuji: without pulling it is not smaller than " // trim(label))
      end do
      call check_close(tsuji_factor(1.0_wp), 0.0_wp, 0.0_wp, "tsuji_factor: e = 1")
      call check_relative(tsuji_factor(exp(-pi)), sqrt(2.5_wp), 1.0e-15_wp, "tsuji_factor: formula")
   end subroutine test_tsuji_impact

   !> The coefficient that follows the speed of each impact.
   subroutine test_begin_impact()
      type(coefficient_damping_type) :: damping
      logical :: changed

      damping%coefficient = 7.0_wp
      call damping%begin_impact(2.0_wp, changed)
      call check_close(damping%coefficient, 7.0_wp, 0.0_wp, "begin_impact: a constant coefficient")
      damping%impact_number = 0.6_wp
      call damping%begin_impact(2.0_wp, changed)
      call check_relative(damping%coefficient, 0.2_wp, 1.0e-15_wp, "begin_impact: D/(1.5 v0)")
      call damping%begin_impact(1.0e-9_wp, changed)
      call check_relative(damping%coefficient, 400.0_wp, 1.0e-15_wp, "begin_impact: slowest impact")
      call damping%begin_impact(-1.0_wp, changed)
      call check_relative(damping%coefficient, 400.0_wp, 1.0e-15_wp, &
         "begin_impact: bodies that separate")
   end subroutine test_begin_impact

   !> A random pose.
   function random_pose(random) result(pose)
      !> The generator.
      type(random_type), intent(inout) :: random
      type(pose_type) :: pose

      pose%position = random%vector(3)
      pose%rotation = rotation_matrix(random%vector(4))
      pose%velocity = random%vector(3)
      pose%spin = random%vector(3)
   end function random_pose

   !> Sphere against plane in both orders, both bodies moved and turned.
   subroutine test_sphere_plane()
      type(random_type) :: random
      type(surface_type) :: sphere, plane
      type(pose_type) :: pose_s, pose_p
      type(contact_point_type) :: at(2)
      class(geometry_type), allocatable :: first, second
      type(worst_type) :: gap, on_sphere, deepest, normal, unit, tangent, both, curvature
      type(track_type) :: track
      real(wp) :: n(3), centre(3), radius, expected, distance(2)
      integer :: i, k

      plane%shape = plane_type()
      do i = 1, 2000
         sphere%centre = random%vector(3)
         radius = random%uniform(0.1_wp, 2.0_wp)
         sphere%shape = sphere_type(radius)
         plane%centre = random%vector(3)
         plane%frame = frame_along(random%vector(3))
         call new_geometry(sphere, plane, first)
         call new_geometry(plane, sphere, second)
         pose_s = random_pose(random)
         pose_p = random_pose(random)
         call first%gap(pose_s, pose_p, track, distance(1))
         call first%locate(pose_s, pose_p, track, distance(1), at(1))
         call second%gap(pose_p, pose_s, track, distance(2))
         call second%locate(pose_p, pose_s, track, distance(2), at(2))
         n = matmul(pose_p%rotation, plane%frame(:, 3))
         centre = pose_s%position + matmul(pose_s%rotation, sphere%centre)
         expected = dot_product(n, centre - pose_p%position - matmul(pose_p%rotation, &
            plane%centre)) - radius
         do k = 1, 2
            call gap%note(abs(at(k)%gap - expected), i)
            call on_sphere%note(abs(norm2(at(k)%point - centre) - radius), i)
            ! The point of the sphere that is closest to the plane.
            call deepest%note(abs(dot_product(n, at(k)%point - pose_p%position &
               - matmul(pose_p%rotation, plane%centre)) - expected), i)
            call unit%note(max(abs(norm2(at(k)%normal) - 1.0_wp), abs(norm2(at(k)%major) &
               - 1.0_wp)), i)
            call tangent%note(abs(dot_product(at(k)%normal, at(k)%major)), i)
            call curvature%note(abs(at(k)%curvature_a*2.0_wp*radius - 1.0_wp) &
               + abs(at(k)%curvature_b - at(k)%curvature_a), i)
         end do
         ! From A into B: into the plane with the sphere first, out of it with the plane first.
         call normal%note(norm2(at(1)%normal + n), i)
         call normal%note(norm2(at(2)%normal - n), i)
         call both%note(norm2(at(1)%point - at(2)%point), i)
         call both%note(abs(first%smallest_radius() - radius) &
            + abs(second%smallest_radius() - radius), i)
      end do
      call gap%check_below(2.0e-14_wp, "sphere, plane: gap")
      call on_sphere%check_below(2.0e-14_wp, "sphere, plane: the point is on the sphere")
      call deepest%check_below(2.0e-14_wp, "sphere, plane: the point is the deepest one")
      call normal%check_below(2.0e-15_wp, "sphere, plane: normal from A into B")
      call unit%check_below(2.0e-15_wp, "sphere, plane: normal and tangent of unit length")
      call tangent%check_below(2.0e-15_wp, "sphere, plane: tangent perpendicular to the normal")
      call both%check_below(0.0_wp, "sphere, plane: one point in both orders")
      call curvature%check_below(1.0e-15_wp, "sphere, plane: curvatures")
   end subroutine test_sphere_plane

   !> Which pairs of shapes there are.
   subroutine test_pairs()
      type(surface_type) :: sphere, plane
      class(geometry_type), allocatable :: geometry

      sphere%shape = sphere_type(1.0_wp)
      plane%shape = plane_type()
      call new_geometry(sphere, plane, geometry)
      call check(allocated(geometry), "a sphere and a plane are a pair")
      call new_geometry(plane, plane, geometry)
      call check(.not. allocated(geometry), "two planes are no pair")
   end subroutine test_pairs

   !> Rate of the gap against differences, both bodies moving.
   subroutine test_gap_rate()
      type(random_type) :: random
      type(scene_type) :: scene
      type(motion_type) :: motion
      type(worst_type) :: worst
      real(wp), allocatable :: y(:), rate(:)
      real(wp) :: ahead(1), behind(1), gap_rate(1)
      real(wp), parameter :: h = 1.0e-6_wp
      integer :: i

      do i = 1, 400
         call two_bodies(scene, 1, 1, modulo(i, 2) == 0)
         call set_motion(scene, motion, y)
         call random_touch(scene, random, random%uniform(-1.0e-4_wp, 1.0e-2_wp), y)
         allocate(rate(size(y)))
         call motion%system%derivative(0.0_wp, y, rate)
         call motion%system%gap_rates(y, gap_rate)
         call motion%system%gaps(y + h*rate, ahead)
         call motion%system%gaps(y - h*rate, behind)
         call worst%note(abs((ahead(1) - behind(1))/(2.0_wp*h) - gap_rate(1)), i)
         deallocate(rate)
      end do
      call worst%check_below(1.0e-8_wp, "the rate of the gap is that of the gap")
   end subroutine test_gap_rate

   !> Which surface is called A does not matter for the motion; the load on B is reversed.
   subroutine test_order()
      type(random_type) :: random
      type(scene_type) :: scenes(2)
      type(motion_type) :: motions(2)
      real(wp), allocatable :: y(:), rate(:, :)
      type(worst_type) :: worst
      type(contact_law_type) :: law
      type(contact_point_type) :: at
      type(contact_load_type) :: load(2)
      class(geometry_type), allocatable :: geometry
      type(surface_type) :: sphere, plane
      real(wp) :: velocity(3), spin(3)
      integer :: i

      do i = 1, 300
         call two_bodies(scenes(1), damping_index("viscous"), friction_index("contensou_exact"), &
            .true.)
         scenes(2) = scenes(1)
         scenes(2)%contacts(1)%surfaces = [2, 1]
         call set_motion(scenes(1), motions(1), y)
         call set_motion(scenes(2), motions(2), y)
         y = 0.0_wp
         call random_touch(scenes(1), random, -random%uniform(1.0e-6_wp, 1.0e-4_wp), y)
         allocate(rate(size(y), 2))
         call motions(1)%system%derivative(0.0_wp, y, rate(:, 1))
         call motions(2)%system%derivative(0.0_wp, y, rate(:, 2))
         call worst%note(maxval(abs(rate(:, 1) - rate(:, 2))/(1.0_wp + abs(rate(:, 1)))), i)
         deallocate(rate)
      end do
      call worst%check_below(1.0e-11_wp, "the order of the surfaces does not matter")

      sphere%shape = sphere_type(0.01_wp)
      plane%shape = plane_type()
      call new_geometry(sphere, plane, geometry)
      call new_geometry(sphere, plane, law%geometry)
      law%normal = new_normal(1.0e10_wp, 50.0_wp, 50.0_wp)
      allocate(law%friction, source=rung_type(coefficient=0.3_wp, kernel=wrench_exact))
      at = contact_point_type(gap=-1.0e-5_wp, point=0.0_wp, normal=[0.0_wp, 0.0_wp, 1.0_wp], &
         major=[1.0_wp, 0.0_wp, 0.0_wp], curvature_a=50.0_wp, curvature_b=50.0_wp)
      velocity = [0.01_wp, -0.02_wp, 0.1_wp]
      spin = [3.0_wp, 5.0_wp, 60.0_wp]
      call law%evaluate(contact_motion_type(at, velocity, spin), 0.0_wp, load(1))
      at%normal = -at%normal
      call law%evaluate(contact_motion_type(at, -velocity, -spin), 0.0_wp, load(2))
      call check_close(norm2(load(1)%friction_force + load(2)%friction_force), 0.0_wp, &
         1.0e-15_wp*load(1)%normal_force, "order: the friction force is reversed")
      call check_close(load(2)%friction_torque, load(1)%friction_torque, &
         1.0e-15_wp*abs(load(1)%friction_torque), "order: the torque about the normal is the same")
      call check_close(norm2(slip_velocity(velocity, -at%normal) &
         + slip_velocity(-velocity, at%normal)), 0.0_wp, 1.0e-17_wp, "order: the slip is reversed")
      call check_relative(load(2)%friction_power, load(1)%friction_power, 1.0e-14_wp, &
         "order: the power is the same")
   end subroutine test_order

   !> Load of a contact law from its parts.
   subroutine test_law()
      type(contact_law_type) :: law
      type(contact_point_type) :: at
      type(contact_load_type) :: load
      type(damping_model_type), allocatable :: damping(:)
      real(wp) :: elastic, r(3), a
      real(wp), parameter :: velocity(3) = [0.02_wp, 0.01_wp, -0.05_wp]
      real(wp), parameter :: spin(3) = [1.0_wp, 2.0_wp, -30.0_wp]

      law%normal = new_normal(1.0e10_wp, 50.0_wp, 50.0_wp)
      at = contact_point_type(gap=-2.0e-5_wp, point=0.0_wp, normal=[0.0_wp, 0.0_wp, 1.0_wp], &
         major=[0.0_wp, 1.0_wp, 0.0_wp], curvature_a=50.0_wp, curvature_b=50.0_wp)
      elastic = law%normal%force(2.0e-5_wp)
      call law%evaluate(contact_motion_type(at, velocity, spin), 0.0_wp, load)
      call check_close(load%normal_force, elastic, 0.0_wp, "law: the elastic force alone")
      call check(all(abs(load%friction_force) <= 0.0_wp) .and. load%damping_power <= 0.0_wp .and. &
         load%friction_power <= 0.0_wp, "law: no friction and no damping")

      damping = damping_models()
      allocate(law%damping, source=coefficient_damping_type(coefficient=2.0_wp, &
         kernel=damping(damping_index("hunt_crossley"))%kernel))
      call law%evaluate(contact_motion_type(at, velocity, spin), 0.0_wp, load)
      call check_relative(load%normal_force, elastic*1.15_wp, 1.0e-15_wp, "law: with damping")
      call check_relative(load%damping_power, elastic*0.15_wp*0.05_wp, 1.0e-14_wp, &
         "law: power of damping")

      allocate(law%friction, source=rung_type(coefficient=0.4_wp, kernel=wrench_exact))
      call law%evaluate(contact_motion_type(at, velocity, spin), 0.0_wp, load)
      a = law%normal%major_axis(2.0e-5_wp)
      ! The major axis is y, so the minor one is normal x major = -x.
      call wrench_exact(circular_shape, slip_type(0.01_wp, -0.02_wp, -30.0_wp*a), .true., r)
      associate (limit => 0.4_wp*load%normal_force)
         call check_relative(load%friction_force(2), limit*r(1), 1.0e-15_wp, "law: friction along")
         call check_relative(load%friction_force(1), -limit*r(2), 1.0e-15_wp, &
            "law: friction across")
         call check_close(load%friction_force(3), 0.0_wp, 0.0_wp, "law: friction is tangential")
         call check_relative(load%friction_torque, limit*a*r(3), 1.0e-15_wp, "law: torque")
      end associate
      call check_close(norm2(slip_velocity(velocity, at%normal) - [0.02_wp, 0.01_wp, 0.0_wp]), &
         0.0_wp, 1.0e-17_wp, "law: slip")
      call check_relative(-(load%friction_power + dot_product(load%friction_force, velocity)) &
         /load%friction_torque, -30.0_wp, 1.0e-13_wp, "law: spin")
      call check_relative(load%friction_power, -dot_product(load%friction_force, velocity) &
         - load%friction_torque*spin(3), 1.0e-14_wp, "law: power of friction")
   end subroutine test_law

   !> Each entry of each table can be named in a scene, constructed and evaluated.
   subroutine test_tables()
      type(damping_model_type), allocatable :: damping(:)
      type(friction_model_type), allocatable :: friction(:)
      type(normal_model_type), allocatable :: normals(:)
      type(scene_type) :: scene
      type(motion_type) :: motion
      type(random_type) :: random
      type(model_info_type), allocatable :: pairs(:)
      real(wp), allocatable :: y(:), rate(:)
      character(len=:), allocatable :: name
      integer :: i, j

      damping = damping_models()
      friction = friction_models()
      normals = normal_models()
      call test_table(normals%info, "contact", "normal")
      call test_table(damping%info, "contact", "damping")
      call test_table(friction%info, "contact", "friction")
      pairs = geometry_models()
      call check(size(pairs) > 0 .and. all(pairs%name /= "") .and. all(pairs%summary /= ""), &
         "the table of pairs is filled in")
      call check(.not. associated(damping(1)%kernel) .and. damping(1)%info%name == "none", &
         "the first damping law is none")
      call check(.not. associated(friction(1)%kernel) .and. friction(1)%info%name == "none", &
         "the first friction model is none")
      do i = 1, size(damping)
         name = trim(damping(i)%info%name)
         call check(associated(damping(i)%kernel) .neqv. name == "none", name // ": has a law")
         call check(damping(i)%uses("damping_coefficient") .neqv. name == "none", &
            name // ": has a coefficient")
         do j = 1, size(friction)
            call two_bodies(scene, i, j, .true.)
            call set_motion(scene, motion, y)
            call random_touch(scene, random, -1.0e-5_wp, y)
            allocate(rate(size(y)))
            call motion%system%derivative(0.0_wp, y, rate)
            call check(all(ieee_is_finite(rate)), name // ", " // trim(friction(j)%info%name) // &
               ": a contact can be evaluated")
            y(8:13) = 0.0_wp
            y(21:26) = 0.0_wp
            call motion%system%derivative(0.0_wp, y, rate)
            call check(all(ieee_is_finite(rate)) .and. norm2(rate(8:10)) > 0.0_wp, name // ", " &
               // trim(friction(j)%info%name) // ": a contact at rest has a force")
            call check(allocated(motion%system%contacts(1)%law%damping) .eqv. i > 1, name // &
               ": is part of the law unless it is none")
            call check(allocated(motion%system%contacts(1)%law%friction) .eqv. j > 1, &
               trim(friction(j)%info%name) // ": is part of the law unless it is none")
            deallocate(rate)
         end do
      end do
      do j = 1, size(friction)
         name = trim(friction(j)%info%name)
         call check(associated(friction(j)%kernel) .neqv. name == "none", name // ": has a rung")
      end do
   end subroutine test_tables

   !> Names of a table are unique, and the schema admits them in the order of the table.
   subroutine test_table(models, group, key)
      !> The table.
      type(model_info_type), intent(in) :: models(:)
      !> Group of the scene.
      character(len=*), intent(in) :: group
      !> Key that takes the names.
      character(len=*), intent(in) :: key
      type(key_type), allocatable :: keys(:)
      type(string_type), allocatable :: choices(:)
      logical :: same
      integer :: i

      keys = schema_keys()
      same = .false.
      do i = 1, size(keys)
         if (keys(i)%group /= group .or. keys(i)%name /= key) cycle
         choices = keys(i)%names()
         same = size(choices) == size(models)
      end do
      call check(same, key // ": the schema has as many choices as the table")
      if (.not. same) return
      do i = 1, size(models)
         call check(choices(i)%s == models(i)%name, key // ": the schema admits " // &
            trim(models(i)%name))
         call check(count(models%name == models(i)%name) == 1, key // ": one " // &
            trim(models(i)%name))
         call check(models(i)%summary /= "", key // ": summary of " // trim(models(i)%name))
      end do
   end subroutine test_table

end module test_contact
