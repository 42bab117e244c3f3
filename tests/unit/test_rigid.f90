!> Rigid contacts: the constraint against differences of the motion, normal forces and impacts
!> against hand formulas.
module test_rigid
   use contensou_base_errors, only : error_type
   use contensou_base_kinds, only : wp
   use contensou_contact_damping_coefficient, only : hunt_crossley_number, hunt_crossley_restitution
   use contensou_contact_geometry, only : trouble_none
   use contensou_contact_normal, only : normal_rigid
   use contensou_contact_shapes_ellipsoid, only : ellipsoid_type
   use contensou_dynamics_reports, only : begin_report, contact_report_type, energies, momenta, &
      report_contact
   use contensou_dynamics_rests, only : resolve_contacts
   use contensou_dynamics_scene, only : scene_type
   use contensou_integrate_motion, only : motion_type
   use contensou_special_complementarity, only : solve_complementarity
   use contensou_special_elimination, only : factorize_with_pivots, independent_rows, &
      solve_linear, solve_with_pivots
   use contensou_study_quantity, only : moment_type
   use test_harness, only : check, check_close, check_relative, random_type, worst_type
   use test_scenes, only : ball, friction_index, random_touch, rolling_index, set_motion, two_bodies
   implicit none(type, external)
   private

   public :: run_rigid_tests

contains

   !> Run all of them.
   subroutine run_rigid_tests()
      call test_elimination()
      call test_complementarity()
      call test_independent_rows()
      call test_restitution()
      call test_constraint()
      call test_tilted_body()
      call test_no_forces()
      call test_impacts()
   end subroutine run_rigid_tests

   !> Elimination with pivots.
   subroutine test_elimination()
      real(wp) :: matrix(3, 3), right(3)
      logical :: singular

      matrix = reshape([0.0_wp, 1.0_wp, 4.0_wp, 2.0_wp, 1.0_wp, -1.0_wp, 3.0_wp, -2.0_wp, 5.0_wp], &
         [3, 3])
      right = matmul(matrix, [1.0_wp, -2.0_wp, 3.0_wp])
      call solve_linear(3, matrix, right, singular)
      call check(.not. singular, "a regular matrix")
      call check_close(maxval(abs(right - [1.0_wp, -2.0_wp, 3.0_wp])), 0.0_wp, 1.0e-14_wp, &
         "solution with pivots")
      matrix = reshape([1.0_wp, 1.0_wp, 1.0_wp, 1.0_wp, 0.0_wp, -1.0_wp, 2.0_wp, 1.0_wp, 0.0_wp], &
         [3, 3])
      call solve_linear(3, matrix, right, singular)
      call check(singular, "a singular matrix is seen")
      call test_two_unknowns()
      call test_factors()
   end subroutine test_elimination

   !> Factors with pivots solve for several right-hand sides, and know the sign of the determinant.
   subroutine test_factors()
      integer, parameter :: n = 6
      type(random_type) :: random
      type(worst_type) :: worst
      real(wp) :: matrix(n, n), factors(n, n), solution(n), right(n)
      integer :: pivots(n), handed, first_handed, i, j, k

      do k = 1, 100
         do j = 1, n
            do i = 1, n
               matrix(i, j) = random%uniform(-1.0_wp, 1.0_wp)
            end do
         end do
         matrix(1, 1) = 0.0_wp
         factors = matrix
         call factorize_with_pivots(n, factors, pivots, first_handed)
         do j = 1, 2
            do i = 1, n
               solution(i) = random%uniform(-1.0_wp, 1.0_wp)
            end do
            right = matmul(matrix, solution)
            call solve_with_pivots(n, factors, pivots, right)
            call worst%note(maxval(abs(right - solution)), k)
         end do
         ! Two rows exchanged.
         factors = matrix
         factors([2, 5], :) = matrix([5, 2], :)
         call factorize_with_pivots(n, factors, pivots, handed)
         call check(abs(handed) == 1 .and. handed == -first_handed, "the determinant's sign turns")
      end do
      call worst%check_below(1.0e-11_wp, "solution with factors")
      matrix = 0.0_wp
      do i = 1, n
         matrix(i, i) = real(i, wp)
      end do
      matrix(3, 3) = -3.0_wp
      call factorize_with_pivots(n, matrix, pivots, handed)
      call check(handed == -1, "a negative determinant")
      matrix = 1.0_wp
      call factorize_with_pivots(n, matrix, pivots, handed)
      call check(handed == 0, "no determinant")
   end subroutine test_factors

   !> Two unknowns have steps of their own, with the same digits as those for more.
   subroutine test_two_unknowns()
      type(random_type) :: random
      real(wp) :: matrix(2, 2), right(2), more(2, 2), same(2), largest
      logical :: singular, seen, regular
      integer :: i, j, k

      largest = 0.0_wp
      regular = .true.
      do i = 1, 200
         do j = 1, 2
            do k = 1, 2
               matrix(k, j) = random%uniform(-1.0_wp, 1.0_wp)
            end do
            right(j) = random%uniform(-1.0_wp, 1.0_wp)
         end do
         more = matrix
         same = right
         call solve_linear(2, matrix, right, singular)
         ! A least pivot that is none takes the way of more unknowns.
         call solve_linear(2, more, same, seen, 0.0_wp)
         regular = regular .and. .not. (singular .or. seen)
         largest = max(largest, maxval(abs(right - same)))
      end do
      call check(regular, "two unknowns, regular matrices")
      call check(largest <= 0.0_wp, "two unknowns as more")
      matrix = reshape([1.0_wp, 2.0_wp, 3.0_wp, 6.0_wp], [2, 2])
      call solve_linear(2, matrix, right, singular)
      call check(singular, "two equations that are one")
      matrix = reshape([0.0_wp, 0.0_wp, 1.0_wp, 2.0_wp], [2, 2])
      call solve_linear(2, matrix, right, singular)
      call check(singular, "two unknowns, one of them in no equation")
   end subroutine test_two_unknowns

   !> Complementarity problems with one solution, with many, and with none.
   subroutine test_complementarity()
      integer, parameter :: n = 6
      type(random_type) :: random
      type(worst_type) :: worst, worst_many
      real(wp) :: matrix(n, n), factor(n, n), q(n), z(n), w(n)
      logical :: solved, all_solved
      integer :: i, j, k, rank

      all_solved = .true.
      do i = 1, 500
         ! Positive definite and not symmetric; of rank 3 and symmetric in every other case.
         rank = merge(n, 3, mod(i, 2) == 0)
         factor = 0.0_wp
         do j = 1, n
            do k = 1, rank
               factor(j, k) = random%uniform(-1.0_wp, 1.0_wp)
            end do
            factor(j, :) = factor(j, :)/norm2(factor(j, :))
         end do
         matrix = matmul(factor, transpose(factor))
         do j = 1, n
            q(j) = random%uniform(-1.0_wp, 0.5_wp)
            z(j) = random%uniform(0.0_wp, 1.0_wp)
         end do
         if (rank == n) then
            do j = 2, n
               matrix(j - 1, j) = matrix(j - 1, j) + 0.3_wp
               matrix(j, j - 1) = matrix(j, j - 1) - 0.3_wp
            end do
         else
            ! One that has a solution, and ties.
            q = -matmul(matrix, z)
            q(n) = q(n - 1)
            matrix(n, :) = matrix(n - 1, :)
            matrix(:, n) = matrix(:, n - 1)
            matrix(n, n) = 1.0_wp
         end if
         do j = 1, n
            matrix(j, j) = matrix(j, j) + 1.0e-9_wp
         end do
         call solve_complementarity(matrix, q, z, solved)
         all_solved = all_solved .and. solved
         w = matmul(matrix, z) + q
         call worst%note(max(-minval(w), -minval(z)), i)
         call worst_many%note(maxval(abs(w*z))/(1.0_wp + maxval(z)), i)
      end do
      call check(all_solved, "complementarity problems with a solution")
      call worst%check_below(1.0e-7_wp, "complementarity: no sign is wrong")
      call worst_many%check_below(1.0e-7_wp, "complementarity: one of each pair is zero")
      call solve_complementarity(reshape([-1.0_wp], [1, 1]), [-1.0_wp], z(:1), solved)
      call check(.not. solved, "a complementarity problem without a solution")
      call solve_complementarity(reshape([-1.0_wp], [1, 1]), [1.0_wp], z(:1), solved)
      call check(solved .and. abs(z(1)) <= 0.0_wp, "a complementarity problem that zero solves")
   end subroutine test_complementarity

   !> Four corners of a table have three independent gaps.
   subroutine test_independent_rows()
      real(wp), parameter :: x(4) = [-1.0_wp, -1.0_wp, 1.0_wp, 1.0_wp]
      real(wp), parameter :: y(4) = [-1.0_wp, 1.0_wp, -1.0_wp, 1.0_wp]
      real(wp) :: matrix(4, 4), factor(4, 4)
      integer :: i, j, rank

      do j = 1, 4
         do i = 1, 4
            matrix(i, j) = (1.0_wp + x(i)*x(j) + y(i)*y(j))/3.0_wp
         end do
      end do
      call independent_rows(4, matrix, factor, rank)
      call check(rank == 3, "independent gaps of a table")
      call check_close(maxval(abs(matmul(factor(:, :3), transpose(factor(:, :3))) - matrix)), &
         0.0_wp, 1.0e-14_wp, "their span")
      call independent_rows(3, matrix, factor, rank)
      call check(rank == 3, "independent gaps of a stool")
   end subroutine test_independent_rows

   !> Restitution at a Hunt-Crossley number is the inverse of the number of a restitution.
   subroutine test_restitution()
      type(worst_type) :: worst
      real(wp) :: e
      integer :: i

      do i = 1, 99
         e = 0.01_wp*i
         call worst%note(abs(hunt_crossley_restitution(hunt_crossley_number(e))/e - 1.0_wp), i)
      end do
      call worst%check_below(1.0e-11_wp, "restitution of the number of a restitution")
      call check_close(hunt_crossley_restitution(0.0_wp), 1.0_wp, 0.0_wp, "no damping, e = 1")
      call check_close(hunt_crossley_restitution(1.0e-6_wp), 1.0_wp - 2.0e-6_wp/3.0_wp, &
         1.0e-11_wp, "e = 1 - 2 D/3 for slow impacts")
      call check_relative(hunt_crossley_restitution(1.0e6_wp), 1.0e-6_wp, 1.0e-3_wp, &
         "e = 1/D for fast impacts")
   end subroutine test_restitution

   !> The second derivative of the gap, from differences of its rate along the motion, is what the
   !> stabilisation asks for, whatever the surfaces, friction and rolling resistance.
   subroutine test_constraint()
      character(len=20), parameter :: frictions(4) = [character(len=20) :: "none", &
         "contensou_simplified", "pade22", "contensou_exact"]
      real(wp), parameter :: h = 2.0e-6_wp
      type(scene_type) :: scene
      type(motion_type) :: motion
      type(random_type) :: random
      type(worst_type) :: worst, worst_power
      real(wp), allocatable :: y(:), forward(:), backward(:), rate(:)
      real(wp) :: before(1), after(1), target, kinetic(3), potential
      integer :: i, kind

      do i = 1, 200
         kind = mod(i, 4) + 1
         call two_bodies(scene, 1, friction_index(trim(frictions(kind))), mod(i, 3) == 0)
         scene%contacts(1)%normal = normal_rigid
         if (mod(i, 5) < 3) then
            ! By assignment gfortran 12 would write a larger type into the room of the smaller.
            deallocate(scene%surfaces(1)%surface%shape)
            allocate(scene%surfaces(1)%surface%shape, &
               source=ellipsoid_type([0.02_wp, 0.015_wp, 0.012_wp]))
         end if
         if (mod(i, 7) == 0) call roll(rolling_index("constant"))
         if (mod(i, 7) == 1) call roll(rolling_index("hysteresis"))
         call set_motion(scene, motion, y)
         if (.not. allocated(rate)) allocate(rate(0))
         call random_touch(scene, random, 1.0e-4_wp*(random%uniform(-1.0_wp, 1.0_wp)), y)
         motion%system%contacts(1)%closed = .true.
         deallocate(rate)
         allocate(rate(size(y)))
         call motion%system%derivative(0.0_wp, y, rate)
         if (motion%system%outside) cycle
         target = -motion%system%constraints%links(1)%stabilisation
         forward = y
         call advance(motion, forward, h)
         backward = y
         call advance(motion, backward, -h)
         call motion%system%gap_rates(forward, after)
         call motion%system%gap_rates(backward, before)
         call worst%note(abs((after(1) - before(1))/(2.0_wp*h) - target) &
            /(1.0_wp + abs(motion%system%constraints%links(1)%free)), i)
         ! The energy changes by the friction and by what holds the gap.
         call energies(motion%system, forward, kinetic(1), potential)
         call energies(motion%system, backward, kinetic(2), potential)
         call motion%system%derivative(0.0_wp, y, rate)
         associate (link => motion%system%constraints%links(1))
            kinetic(3) = link%normal_force*link%rate
         end associate
         if (motion%system%layout%friction > 0) kinetic(3) = kinetic(3) &
            - rate(motion%system%layout%friction)
         call worst_power%note(abs((kinetic(1) - kinetic(2))/(2.0_wp*h) - kinetic(3)) &
            /(1.0_wp + abs(kinetic(3))), i)
      end do
      call check(worst%sample > 0, "constraints were met")
      call worst%check_below(1.0e-4_wp, "second derivative of the gap of a closed contact")
      call worst_power%check_below(1.0e-4_wp, "power of a closed contact")

   contains

      !> Add rolling resistance.
      subroutine roll(model)
         integer, intent(in) :: model

         scene%contacts(1)%rolling = model
         call scene%contacts(1)%parameters%set("rolling_coefficient", merge(1.0e-4_wp, 0.5_wp, &
            model == rolling_index("constant")))
         call scene%contacts(1)%parameters%set("rolling_regularization", 1.0e-2_wp)
      end subroutine roll

   end subroutine test_constraint

   !> A step of the classical Runge-Kutta method.
   subroutine advance(motion, y, h)
      type(motion_type), intent(inout) :: motion
      !> State.
      real(wp), intent(inout) :: y(:)
      !> Step [s].
      real(wp), intent(in) :: h
      real(wp) :: k(size(y), 4)

      call motion%system%derivative(0.0_wp, y, k(:, 1))
      call motion%system%derivative(0.0_wp, y + 0.5_wp*h*k(:, 1), k(:, 2))
      call motion%system%derivative(0.0_wp, y + 0.5_wp*h*k(:, 2), k(:, 3))
      call motion%system%derivative(0.0_wp, y + h*k(:, 3), k(:, 4))
      y = y + h/6.0_wp*(k(:, 1) + 2.0_wp*k(:, 2) + 2.0_wp*k(:, 3) + k(:, 4))
   end subroutine advance

   !> A body on an eccentric sphere, turning in a plane: z = r + l cos(theta), A theta'' = N l sin,
   !> so N = m (g - l cos theta'^2)/(1 + m l^2 sin^2/A); with friction -f N along x at the bottom
   !> A theta'' = N (l sin + f (r + l cos)) where it slides forwards.
   subroutine test_tilted_body()
      real(wp), parameter :: l = 0.008_wp, r = 0.02_wp, theta = 0.7_wp, omega = 6.0_wp, f = 0.3_wp
      real(wp), parameter :: mass = 0.1_wp, inertia = 1.6e-5_wp, g = 9.81_wp
      type(scene_type) :: scene
      type(motion_type) :: motion
      type(contact_report_type) :: row
      real(wp), allocatable :: y(:)
      real(wp) :: expected
      integer :: with

      do with = 0, 1
         call ball(scene, 0.0_wp)
         scene%gravity = [0.0_wp, 0.0_wp, -g]
         scene%surfaces(1)%surface%centre = [0.0_wp, 0.0_wp, -l]
         scene%bodies(1)%position = [0.0_wp, 0.0_wp, r + l*cos(theta)]
         scene%bodies(1)%quaternion = [cos(0.5_wp*theta), 0.0_wp, sin(0.5_wp*theta), 0.0_wp]
         scene%bodies(1)%spin = [0.0_wp, omega, 0.0_wp]
         ! Fast enough that the spot slides as a point does.
         scene%bodies(1)%velocity = [2.0_wp, 0.0_wp, -l*sin(theta)*omega]
         scene%contacts(1)%normal = normal_rigid
         if (with == 1) then
            scene%contacts(1)%friction = friction_index("contensou_exact")
            call scene%contacts(1)%parameters%set("friction_coefficient", f)
         end if
         call set_motion(scene, motion, y)
         motion%system%contacts(1)%closed = .true.
         call begin_report(motion%system, 0.0_wp, y)
         call report_contact(motion%system, 1, row)
         ! Friction pulls back at the bottom, a torque that tips the top forwards.
         expected = mass*(g - l*cos(theta)*omega**2)/(1.0_wp + mass*l*sin(theta)/inertia &
            *(l*sin(theta) + with*f*(r + l*cos(theta))))
         call check_relative(row%load%normal_force, expected, 1.0e-12_wp, &
            "normal force on a tilted body")
         call check_relative(row%load%friction_force(1), -with*f*expected, 1.0e-12_wp, &
            "its friction")
         call check_close(row%elastic_energy, 0.0_wp, 0.0_wp, "no elastic energy")
         call check_relative(row%semi_axes(1), sqrt(r*(expected/(4.0_wp/3.0_wp*2.1e11_wp &
            /(2.0_wp*(1.0_wp - 0.09_wp))*sqrt(r)))**(2.0_wp/3.0_wp)), 1.0e-12_wp, &
            "spot of Hertz at the normal force")
      end do
   end subroutine test_tilted_body

   !> Where friction leaves no normal force, nothing is told of a state, nor taken for an event.
   subroutine test_no_forces()
      real(wp), parameter :: l = 0.008_wp, r = 0.02_wp, theta = 0.7_wp, speed = 2.0_wp
      type(scene_type) :: scene
      type(motion_type) :: motion
      type(moment_type) :: moment
      type(error_type), allocatable :: error
      real(wp), allocatable :: y(:)
      real(wp) :: g(1)
      integer :: side

      do side = -1, 1, 2
         call ball(scene, 0.0_wp)
         scene%gravity = [0.0_wp, 0.0_wp, -9.81_wp]
         scene%surfaces(1)%surface%centre = [0.0_wp, 0.0_wp, -l]
         ! At the floor the scene would be refused.
         scene%bodies(1)%position = [0.0_wp, 0.0_wp, 2.0_wp*r]
         scene%bodies(1)%quaternion = [cos(0.5_wp*theta), 0.0_wp, sin(0.5_wp*theta), 0.0_wp]
         scene%bodies(1)%velocity = [side*speed, 0.0_wp, 0.0_wp]
         scene%contacts(1)%normal = normal_rigid
         scene%contacts(1)%friction = friction_index("contensou_exact")
         call scene%contacts(1)%parameters%set("friction_coefficient", 3.0_wp)
         call set_motion(scene, motion, y)
         y(3) = r + l*cos(theta)
         motion%system%contacts(1)%closed = .true.
         call moment%look(motion%system, 0.0_wp, y, error)
         call motion%events(0.0_wp, y, g)
         call check(allocated(error) .eqv. side < 0, "a row where there is no normal force")
         call check(motion%unfound .eqv. side < 0, "events where there is no normal force")
         motion%unfound = .false.
      end do
   end subroutine test_no_forces

   !> Impacts of two free bodies: momenta stay, no work is negative, the balance closes, nothing
   !> approaches afterwards.
   subroutine test_impacts()
      type(scene_type) :: scene
      type(motion_type) :: motion
      type(random_type) :: random
      type(worst_type) :: balance, momentum, damping, friction, approach, newton
      real(wp), allocatable :: y(:)
      real(wp) :: linear(3, 2), angular(3, 2), kinetic(2), potential, rate(1), later(1)
      integer :: i, index, trouble, solved
      logical :: rubs

      solved = 0
      do i = 1, 400
         rubs = mod(i, 4) > 0
         call two_bodies(scene, 1, friction_index(merge("contensou_exact", "none           ", &
            rubs)), mod(i, 3) == 0)
         scene%contacts(1)%normal = normal_rigid
         call scene%contacts(1)%parameters%set("regularization_velocity", 0.0_wp)
         call scene%contacts(1)%parameters%set("friction_coefficient", 0.1_wp*mod(i, 11))
         call scene%contacts(1)%parameters%set("restitution", 0.1_wp*mod(i, 10))
         call set_motion(scene, motion, y)
         call random_touch(scene, random, 0.0_wp, y)
         y(27:) = 0.0_wp
         call motion%system%gap_rates(y, rate)
         if (rate(1) >= 0.0_wp) cycle
         call momenta(motion%system, y, linear(:, 1), angular(:, 1))
         call energies(motion%system, y, kinetic(1), potential)
         call resolve_contacts(motion%system, 0.0_wp, y, [.true.], 1.0e-2_wp, index, trouble)
         if (trouble /= trouble_none) cycle
         solved = solved + 1
         call motion%system%gap_rates(y, later)
         call momenta(motion%system, y, linear(:, 2), angular(:, 2))
         call energies(motion%system, y, kinetic(2), potential)
         call momentum%note(maxval(abs(linear(:, 2) - linear(:, 1))), i)
         call momentum%note(maxval(abs(angular(:, 2) - angular(:, 1))), i)
         call balance%note(abs(kinetic(2) + sum(y(27:)) - kinetic(1))/kinetic(1), i)
         call damping%note(-y(motion%system%layout%damping), i)
         if (rubs) call friction%note(-y(motion%system%layout%friction)/kinetic(1), i)
         call approach%note(-later(1)/abs(rate(1)), i)
         if (.not. rubs) call newton%note(abs(later(1)/rate(1)  &
            + scene%contacts(1)%parameters%number("restitution")), i)
      end do
      call check(solved > 150, "impacts were solved")
      call balance%check_below(1.0e-14_wp, "energy balance of an impact")
      call momentum%check_below(1.0e-15_wp, "momenta in an impact")
      call damping%check_below(0.0_wp, "an impact gains no energy along the normal")
      call friction%check_below(1.0e-14_wp, "an impact gains no energy in friction")
      call approach%check_below(1.0e-12_wp, "nothing approaches after an impact")
      call newton%check_below(1.0e-12_wp, "restitution of an impact without friction")
   end subroutine test_impacts

end module test_rigid
