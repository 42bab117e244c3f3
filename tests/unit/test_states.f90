!> Tests of states that parts of contacts own, with parts made here: no shipped part has any.
module test_states
   use contensou_base_checkpoint, only : checkpoint_type
   use contensou_base_errors, only : error_type
   use contensou_base_kinds, only : wp
   use contensou_base_vectors, only : cross
   use contensou_contact_damping_law, only : damping_type
   use contensou_contact_friction_law, only : friction_type, sliding_type
   use contensou_contact_geometry, only : contact_motion_type
   use contensou_contact_normal, only : normal_rigid
   use contensou_contact_spot, only : spot_shape_type
   use contensou_contact_states, only : against_length, contact_states_type, state_list_type
   use contensou_contact_shapes_ellipsoid, only : ellipsoid_type
   use contensou_dynamics_jacobian, only : is_available
   use contensou_dynamics_mechanism, only : contact_type
   use contensou_dynamics_reports, only : begin_report, contact_report_type, report_contact
   use contensou_dynamics_scene, only : motion_fixed, motion_prescribed, motion_spindle, scene_type
   use contensou_dynamics_state, only : body_size
   use contensou_integrate_methods, only : integrator_methods
   use contensou_integrate_observer, only : event_touch, observer_type
   use contensou_integrate_march, only : begin_march
   use contensou_integrate_motion, only : motion_type, set_up_motion
   use contensou_study_quantity, only : moment_type
   use contensou_study_simulation, only : new_simulation, simulate, simulation_options_type, &
      simulation_type
   use test_harness, only : check, check_close, random_type, worst_type
   use test_jacobian, only : defect, set_layout
   use test_scenes, only : ball, friction_index, random_touch, set_motion, two_bodies
   implicit none(type, external)
   private

   public :: run_states_tests

   !> Bristles after P. R. Dahl, the stiffer the larger the normal force is: F = -sigma N z,
   !> z' = v - |v| sigma z/f.
   type, extends(friction_type) :: bristle_type
      !> Stiffness over the normal force, sigma [1/m].
      real(wp) :: stiffness = 2.0e4_wp
   contains
      procedure :: wrench => wrench_of_bristles
      procedure :: evolve => evolve_bristles
      procedure :: stored_energy => energy_of_bristles
   end type bristle_type

   !> A spring in series with a damper (Maxwell) beside the elastic force: s' = k d' - s/tau. It
   !> keeps the speed of the last touch, too.
   type, extends(damping_type) :: maxwell_type
      !> Stiffness k [N/m].
      real(wp) :: stiffness = 3.0e4_wp
      !> Time tau [s].
      real(wp) :: time = 1.0e-3_wp
   contains
      procedure :: force => force_of_maxwell
      procedure :: slopes => slopes_of_maxwell
      procedure :: evolve => evolve_maxwell
      procedure :: stored_energy => energy_of_maxwell
      procedure :: at_touch => touch_of_maxwell
      procedure :: after_lift => lift_of_maxwell
   end type maxwell_type

   !> Looks at the states in the rows, and at the energy.
   type, extends(observer_type) :: witness_type
      type(moment_type) :: at
      !> Energy at the beginning [J], and how far it was from that.
      real(wp) :: energy = 0.0_wp, residual = 0.0_wp
      !> Smallest increase of the work lost in friction and damping from row to row [J].
      real(wp) :: gain = huge(1.0_wp)
      !> Works lost in the last row [J].
      real(wp) :: lost(2) = 0.0_wp
      !> Largest energy stored in the states [J].
      real(wp) :: stored = 0.0_wp
      !> Largest share of a vector that is not in the tangent plane [m].
      real(wp) :: out_of_plane = 0.0_wp
      integer :: rows = 0, touches = 0, steps = 0
      !> Steps after which to stop.
      integer :: stop_after = huge(1)
      !> Whether states in the air, and at touch, were those that the part wants.
      logical :: air = .true., surface = .true.
   contains
      procedure :: sample
      procedure :: event
      procedure :: after_step
   end type witness_type

contains

   !> Run all tests of this module.
   subroutine run_states_tests(folder)
      !> Folder for files.
      character(len=*), intent(in) :: folder

      call test_axes()
      call test_rates()
      call test_jacobian_of_states()
      call test_rigid()
      call test_bounces()
      call test_bristles()
      call test_restore(folder)
   end subroutine run_states_tests

   !> Friction of steady sliding: Coulomb's.
   pure subroutine wrench_of_bristles(self, shape, at, wrench)
      class(bristle_type), intent(in) :: self
      type(spot_shape_type), intent(in) :: shape
      type(sliding_type), intent(in) :: at
      real(wp), intent(out) :: wrench(3)
      real(wp) :: speed

      speed = max(hypot(at%vx, at%vy), sqrt(at%resolution), tiny(speed))
      wrench = -self%coefficient*at%load/speed*[at%vx, at%vy, 0.0_wp]
   end subroutine wrench_of_bristles

   !> Force of the bristles, and how they bend.
   pure subroutine evolve_bristles(self, shape, at, states, wrench, rates)
      class(bristle_type), intent(in) :: self
      type(spot_shape_type), intent(in) :: shape
      type(sliding_type), intent(in) :: at
      real(wp), intent(in) :: states(:)
      real(wp), intent(out) :: wrench(3)
      real(wp), intent(out) :: rates(:)
      real(wp) :: slip(2)

      slip = [at%vx, at%vy]
      wrench(1:2) = -self%stiffness*at%load*states
      wrench(3) = 0.0_wp
      rates = slip - norm2(slip)*self%stiffness/self%coefficient*states
   end subroutine evolve_bristles

   pure real(wp) function energy_of_bristles(self, shape, at, states) result(energy)
      class(bristle_type), intent(in) :: self
      type(spot_shape_type), intent(in) :: shape
      type(sliding_type), intent(in) :: at
      real(wp), intent(in) :: states(:)

      energy = 0.5_wp*self%stiffness*at%load*dot_product(states, states)
   end function energy_of_bristles

   pure function force_of_maxwell(self, elastic, approach, rate) result(f)
      class(maxwell_type), intent(in) :: self
      real(wp), intent(in) :: elastic
      real(wp), intent(in) :: approach
      real(wp), intent(in) :: rate
      real(wp) :: f

      f = self%stiffness*self%time*rate
   end function force_of_maxwell

   pure function slopes_of_maxwell(self, elastic, approach, rate) result(slopes)
      class(maxwell_type), intent(in) :: self
      real(wp), intent(in) :: elastic
      real(wp), intent(in) :: approach
      real(wp), intent(in) :: rate
      real(wp) :: slopes(3)

      slopes = [0.0_wp, 0.0_wp, self%stiffness*self%time]
   end function slopes_of_maxwell

   pure subroutine evolve_maxwell(self, elastic, approach, rate, states, f, rates)
      class(maxwell_type), intent(in) :: self
      real(wp), intent(in) :: elastic
      real(wp), intent(in) :: approach
      real(wp), intent(in) :: rate
      real(wp), intent(in) :: states(:)
      real(wp), intent(out) :: f
      real(wp), intent(out) :: rates(:)

      f = states(1)
      rates(1) = self%stiffness*rate - states(1)/self%time
      rates(2) = 0.0_wp
   end subroutine evolve_maxwell

   pure real(wp) function energy_of_maxwell(self, elastic, approach, states) result(energy)
      class(maxwell_type), intent(in) :: self
      real(wp), intent(in) :: elastic
      real(wp), intent(in) :: approach
      real(wp), intent(in) :: states(:)

      energy = 0.5_wp*states(1)**2/self%stiffness
   end function energy_of_maxwell

   pure subroutine touch_of_maxwell(self, speed, states)
      class(maxwell_type), intent(in) :: self
      real(wp), intent(in) :: speed
      real(wp), intent(out) :: states(:)

      states = [0.0_wp, speed]
   end subroutine touch_of_maxwell

   pure subroutine lift_of_maxwell(self, states)
      class(maxwell_type), intent(in) :: self
      real(wp), intent(out) :: states(:)

      states = [0.0_wp, -1.0_wp]
   end subroutine lift_of_maxwell

   !> Give the first contact of a system bristles, and a Maxwell spring if wanted, in place of what
   !> it has.
   subroutine replace_parts(contact, with_damping)
      type(contact_type), intent(inout) :: contact
      logical, intent(in) :: with_damping
      type(state_list_type) :: damping, friction

      if (allocated(contact%law%damping)) deallocate(contact%law%damping)
      if (allocated(contact%law%friction)) deallocate(contact%law%friction)
      contact%states = contact_states_type()
      allocate(contact%law%friction, source=bristle_type(coefficient=0.3_wp))
      call friction%put("bristles", "m", "deflection", 1.0_wp, against_length, tangent=.true.)
      if (with_damping) then
         allocate(contact%law%damping, source=maxwell_type())
         call damping%put("spring", "N", "force of the spring", 1.0_wp)
         call damping%put("speed", "m s-1", "speed at touch", 1.0_wp)
      end if
      call contact%own(damping, friction)
   end subroutine replace_parts

   !> Replace the parts of a motion.
   subroutine replace_in_motion(motion, scene, y, with_damping)
      type(motion_type), intent(inout) :: motion
      type(scene_type), intent(in) :: scene
      !> State; what follows the bodies is zero.
      real(wp), allocatable, intent(inout) :: y(:)
      logical, intent(in) :: with_damping
      real(wp), allocatable :: longer(:)

      call replace_parts(motion%system%contacts(1), with_damping)
      call motion%system%prepare()
      allocate(longer(motion%system%layout%n), source=0.0_wp)
      associate (n => body_size*motion%system%layout%bodies)
         longer(:n) = y(:n)
      end associate
      call move_alloc(longer, y)
      call set_up_motion(motion, scene, y)
   end subroutine replace_in_motion

   !> Numbers along the axes of a spot and back.
   subroutine test_axes()
      type(contact_states_type) :: states
      type(state_list_type) :: damping, friction
      type(random_type) :: random
      real(wp) :: major(3), normal(3), minor(3), local(4), values(5)

      call damping%put("one", "1", "", 1.0_wp)
      call friction%put("two", "m", "", 1.0_wp, tangent=.true.)
      call friction%put("three", "1", "", 1.0_wp)
      call states%own(damping, friction)
      call check(states%n == 5 .and. states%n_local == 4 .and. states%n_damping == 1, &
         "states: numbers of a scene and of the parts")
      states%first = 14
      call check(states%place("one") == 13 .and. states%place("two") == 14 .and. &
         states%place("three") == 17 .and. states%place("four") == -1, "states: places")
      normal = random%vector(3)
      normal = normal/norm2(normal)
      major = cross(normal, random%vector(3))
      major = major/norm2(major)
      minor = cross(normal, major)
      values = 0.0_wp
      call states%scatter([1.0_wp, 2.0_wp, 3.0_wp, 4.0_wp], major, minor, values)
      call check_close(values(1) + values(5), 5.0_wp, 1.0e-15_wp, "states: numbers have no axes")
      call check_close(dot_product(values(2:4), normal), 0.0_wp, 1.0e-15_wp, &
         "states: a vector is in the tangent plane")
      call states%gather(values, major, minor, local)
      call check_close(maxval(abs(local - [1.0_wp, 2.0_wp, 3.0_wp, 4.0_wp])), 0.0_wp, 1.0e-15_wp, &
         "states: there and back")
   end subroutine test_axes

   !> Rates in the state of a scene: open, turning as one body, sliding.
   subroutine test_rates()
      type(random_type) :: random
      type(scene_type) :: scene
      type(motion_type) :: motion
      type(contact_report_type) :: row
      type(contact_motion_type) :: now
      type(worst_type) :: turning, sliding, force
      real(wp), allocatable :: y(:), rate(:)
      real(wp) :: spin(3), z(3), expected(3)
      integer :: i, k

      do i = 1, 200
         call two_bodies(scene, 1, friction_index("coulomb"), modulo(i, 2) == 0)
         if (modulo(i, 3) == 0) then
            deallocate(scene%surfaces(1)%surface%shape)
            allocate(scene%surfaces(1)%surface%shape, &
               source=ellipsoid_type([0.02_wp, 0.015_wp, 0.012_wp]))
         end if
         call set_motion(scene, motion, y)
         call replace_in_motion(motion, scene, y, .true.)
         if (i == 1) call check(motion%system%layout%states == 5 .and. motion%n == 33 .and. &
            motion%system%layout%friction == 32, "states: between the bodies and the works")
         if (allocated(rate)) deallocate(rate)
         allocate(rate(motion%n))
         call random_touch(scene, random, -1.0e-5_wp, y)
         call begin_report(motion%system, 0.0_wp, y)
         call report_contact(motion%system, 1, row)
         if (.not. row%load%normal_force > 0.0_wp) cycle
         z = 1.0e-6_wp*cross(row%at%normal, random%vector(3))
         y(27) = 2.0_wp
         y(29:31) = z
         call motion%system%derivative(0.0_wp, y, rate)
         call report_contact(motion%system, 1, row)
         call motion%system%observe(1, now)
         call force%note(norm2(row%load%friction_force &
            + 2.0e4_wp*row%load%normal_force*z)/(0.02_wp*row%load%normal_force), i)
         call sliding%note(abs(rate(27) + 2.0_wp/1.0e-3_wp + 3.0e4_wp*now%gap_rate())/3.0e4_wp, i)
         ! Both bodies turn as one: the vector turns with them.
         spin = 20.0_wp*random%vector(3)
         do k = 0, 13, 13
            y(k + 11:k + 13) = matmul(spin, motion%system%pose(1 + k/13)%rotation)
         end do
         y(8:10) = 0.0_wp
         y(21:23) = cross(spin, y(14:16) - y(1:3))
         call motion%system%derivative(0.0_wp, y, rate)
         expected = cross(spin, z)
         call turning%note(norm2(rate(29:31) - expected)/norm2(expected), i)
      end do
      call force%check_below(1.0e-12_wp, "states: force of bristles")
      call sliding%check_below(1.0e-12_wp, "states: rate of a spring")
      call turning%check_below(1.0e-9_wp, "states: vectors turn with bodies that move as one")
      call random_touch(scene, random, 1.0e-5_wp, y)
      call motion%system%derivative(0.0_wp, y, rate)
      call check(all(abs(rate(27:31)) <= 0.0_wp), "states: constant while a contact is open")
   end subroutine test_rates

   !> The Jacobian with the states, of free, driven and fixed bodies, against differences.
   subroutine test_jacobian_of_states()
      type(random_type) :: random
      type(scene_type) :: scene
      type(motion_type) :: motion
      type(worst_type) :: worst(3)
      type(contact_report_type) :: row
      real(wp), allocatable :: y(:), scale(:)
      real(wp) :: approach
      integer :: i, k, kind

      do i = 1, 160
         kind = 1 + modulo(i, 3)
         call two_bodies(scene, 1, friction_index("coulomb"), &
            kind == 2 .or. (kind == 3 .and. modulo(i, 4) < 2))
         if (kind == 3) then
            deallocate(scene%surfaces(1)%surface%shape)
            allocate(scene%surfaces(1)%surface%shape, &
               source=ellipsoid_type([0.02_wp, 0.015_wp, 0.012_wp]))
         end if
         if (modulo(i, 8) == 1) scene%bodies(1)%motion = motion_prescribed
         if (modulo(i, 8) == 2) scene%bodies(2)%motion = motion_fixed
         if (modulo(i, 8) == 3) scene%bodies(1)%motion = motion_spindle
         call set_motion(scene, motion, y)
         call replace_in_motion(motion, scene, y, modulo(i, 5) > 0)
         call set_layout(motion)
         motion%system%resolution%square = 0.0_wp
         approach = 10.0_wp**random%uniform(-6.0_wp, -4.0_wp)
         call random_touch(scene, random, -approach, y)
         ! Not by the distance of the spheres' centres: the surfaces themselves overlap.
         do k = 1, 20
            call begin_report(motion%system, 0.0_wp, y)
            call report_contact(motion%system, 1, row)
            y(1:3) = y(1:3) + merge(-1.0_wp, 1.0_wp, motion%system%contacts(1)%b == 1) &
               *(row%at%gap + approach)*row%at%normal
         end do
         associate (states => motion%system%contacts(1)%states)
            states%scales = 1.0e-3_wp
            k = states%place("bristles")
            y(k + 1:k + 3) = 0.3_wp/2.0e4_wp*cross(row%at%normal, random%vector(3))
            if (states%place("spring") > 0) y(27) = random%uniform(0.0_wp, 1.0_wp)
         end associate
         call begin_report(motion%system, 0.0_wp, y)
         call report_contact(motion%system, 1, row)
         if (row%at%gap > -0.5_wp*approach .or. .not. row%load%normal_force > 0.0_wp) cycle
         scale = y
         do k = 0, 13, 13
            scale(k + 1:k + 3) = 0.1_wp*approach
            scale(k + 4:k + 7) = 0.1_wp*approach
            scale(k + 8:k + 10) = 0.01_wp
            scale(k + 11:k + 13) = 0.3_wp
         end do
         scale(27:) = 1.0e-6_wp
         if (motion%system%bodies(2)%motion == motion_fixed) scale(14:26) = 0.0_wp
         call worst(kind)%note(min(defect(motion, 0.5_wp, y, scale, 5.0e-2_wp), &
            defect(motion, 0.5_wp, y, scale, 5.0e-3_wp)), i)
      end do
      ! Only where the normal keeps to body A the frame of the vectors turns as in the Jacobian.
      call worst(1)%check_below(1.0e-6_wp, "states: Jacobian, plane under a sphere")
      call worst(2)%check_below(2.0e-3_wp, "states: Jacobian, sphere on a plane")
      call worst(3)%check_below(2.0e-3_wp, "states: Jacobian, curvatures that vary")
   end subroutine test_jacobian_of_states

   !> Bristles of a rigid contact: its force, the rates, no analytic Jacobian.
   subroutine test_rigid()
      type(scene_type) :: scene
      type(simulation_type) :: simulation
      type(witness_type) :: witness
      type(error_type), allocatable :: error
      type(contact_report_type) :: row
      real(wp), allocatable :: rate(:), y(:)
      real(wp) :: slip

      call rolling_ball(scene, simulation, .true., 0.1_wp, "explicit8")
      allocate(rate(simulation%motion%n))
      y = simulation%state()
      y(14:16) = [3.0e-6_wp, 0.0_wp, 0.0_wp]
      call simulation%motion%system%derivative(0.0_wp, y, rate)
      call begin_report(simulation%motion%system, 0.0_wp, y)
      call report_contact(simulation%motion%system, 1, row)
      call check_close(row%load%normal_force, 0.981_wp, 1.0e-9_wp, "states, rigid: normal force")
      call check_close(rate(8), -2.0e4_wp*9.81_wp*3.0e-6_wp, 1.0e-9_wp, &
         "states, rigid: bristles slow a ball down")
      slip = 0.1_wp
      call check_close(rate(14), slip - slip*2.0e4_wp/0.3_wp*3.0e-6_wp, 1.0e-9_wp, &
         "states, rigid: rate")
      call check(.not. is_available(simulation%motion%system), &
         "states, rigid: the Jacobian is left to differences")
      call simulate(simulation, witness, error)
      call check(.not. allocated(error), "states, rigid: a run")
      call check_close(witness%residual, 0.0_wp, 1.0e-9_wp, "states, rigid: energy balance")
      call check(witness%stored > 1.0e-7_wp .and. witness%gain > -1.0e-12_wp, &
         "states, rigid: what is stored is not lost")
   end subroutine test_rigid

   !> A ball of 0.1 kg on the ground that slides at first, with bristles in its contact.
   subroutine rolling_ball(scene, simulation, rigid, speed, method, height)
      type(scene_type), intent(out) :: scene
      type(simulation_type), intent(out) :: simulation
      logical, intent(in) :: rigid
      !> Speed at the beginning [m/s].
      real(wp), intent(in) :: speed
      character(len=*), intent(in) :: method
      !> Height from which it falls, with a Maxwell spring [m]; it rests on the ground if not given.
      real(wp), intent(in), optional :: height
      type(simulation_options_type) :: options
      type(error_type), allocatable :: error
      real(wp) :: depth

      call ball(scene, 0.0_wp)
      scene%gravity = [0.0_wp, 0.0_wp, -9.81_wp]
      scene%materials%young = 1.0e8_wp
      scene%contacts(1)%friction = friction_index("coulomb")
      call scene%contacts(1)%parameters%set("friction_coefficient", 0.3_wp)
      call scene%contacts(1)%parameters%set("regularization_velocity", 1.0e-3_wp)
      if (rigid) scene%contacts(1)%normal = normal_rigid
      scene%bodies(1)%velocity = [speed, 0.0_wp, 0.0_wp]
      scene%t_end = 0.2_wp
      if (present(height)) scene%bodies(1)%position(3) = scene%bodies(1)%position(3) + height
      options%method = method
      options%interval = 1.0e-3_wp
      call new_simulation(scene, simulation, error, options)
      if (allocated(error)) error stop "a scene of the tests cannot be simulated"
      associate (motion => simulation%motion, memory => simulation%memory)
         if (.not. rigid .and. .not. present(height)) then
            depth = motion%system%contacts(1)%law%normal%approach(0.981_wp)
            memory%y(3) = memory%y(3) - depth
         end if
         call replace_in_motion(motion, simulation%scene, memory%y, present(height))
         call begin_march(motion, method, memory, simulation%choice, error)
         if (allocated(error)) error stop "a scene of the tests cannot be begun"
      end associate
   end subroutine rolling_ball

   !> Values at touch and after lift-off, by all methods.
   subroutine test_bounces()
      type(scene_type) :: scene
      type(simulation_type) :: simulation
      type(witness_type) :: witness
      type(error_type), allocatable :: error
      real(wp) :: final(3, size(integrator_methods))
      integer :: i

      do i = 1, size(integrator_methods)
         witness = witness_type()
         call rolling_ball(scene, simulation, .false., 0.05_wp, trim(integrator_methods(i)), &
            2.0e-3_wp)
         call simulate(simulation, witness, error)
         call check(.not. allocated(error), "states: bounces by " // integrator_methods(i))
         call check(witness%touches > 2, "states: several bounces")
         call check(witness%air, "states: values after lift-off")
         call check(witness%surface, "states: values at touch")
         call check_close(witness%residual, 0.0_wp, 1.0e-8_wp, "states: energy of bounces")
         final(:, i) = simulation%memory%y(1:3)
         if (i > 1) call check_close(norm2(final(:, i) - final(:, 1)), 0.0_wp, 1.0e-6_wp, &
            "states: bounces by " // integrator_methods(i) // " as by the first method")
      end do
   end subroutine test_bounces

   !> A ball that slides and then rolls on bristles, in closed form: while it slides, F = f N once
   !> the bristles are bent. Jacobians of either kind.
   subroutine test_bristles()
      type(scene_type) :: scene
      type(simulation_type) :: simulation
      type(witness_type) :: witness
      type(error_type), allocatable :: error
      real(wp) :: final(2)
      integer :: i

      do i = 1, 2
         witness = witness_type()
         call rolling_ball(scene, simulation, .false., 0.1_wp, "cvode_bdf")
         simulation%motion%differences = i == 2
         call simulate(simulation, witness, error)
         call check(.not. allocated(error), "states: a ball on bristles")
         final(i) = simulation%memory%y(8)
         call check_close(witness%residual, 0.0_wp, 1.0e-9_wp, "states: energy on bristles")
         call check(witness%stored > 1.0e-7_wp .and. witness%gain > -1.0e-11_wp, &
            "states: what bristles store is not lost")
         call check(witness%out_of_plane < 1.0e-18_wp, "states: bristles stay in the plane")
      end do
      ! At the end it rolls: m v + I w/r = m v_0.
      call check_close(final(1), 0.1_wp/(1.0_wp + 1.6e-5_wp/(0.1_wp*0.02_wp**2)), 2.0e-4_wp, &
         "states: the ball rolls at the end")
      call check_close(final(2), final(1), 1.0e-7_wp, "states: either Jacobian")
   end subroutine test_bristles

   !> A simulation that goes on from a checkpoint goes on as one that was stopped, bit for bit.
   subroutine test_restore(folder)
      character(len=*), intent(in) :: folder
      type(scene_type) :: scene
      type(simulation_type) :: stopped, restored
      type(checkpoint_type) :: checkpoint
      type(witness_type) :: witness
      type(error_type), allocatable :: error

      call rolling_ball(scene, stopped, .false., 0.05_wp, "cvode_bdf", 2.0e-3_wp)
      witness%stop_after = 300
      call simulate(stopped, witness, error)
      call checkpoint%begin()
      call stopped%exchange(checkpoint)
      call checkpoint%save(folder // "/states.checkpoint", error)
      call check(.not. allocated(error), "states: a checkpoint")
      call rolling_ball(scene, restored, .false., 0.05_wp, "cvode_bdf", 2.0e-3_wp)
      call checkpoint%load(folder // "/states.checkpoint", error)
      call restored%exchange(checkpoint)
      call check(all(abs(restored%memory%y - stopped%memory%y) <= 0.0_wp), "states: restored")
      witness = witness_type()
      call simulate(stopped, witness, error)
      call simulate(restored, witness, error)
      call check(all(abs(restored%memory%y - stopped%memory%y) <= 0.0_wp) .and. &
         any(abs(restored%memory%y(14:18)) > 0.0_wp), "states: as one that was stopped")
   end subroutine test_restore

   !> A row is due.
   subroutine sample(self, motion, t, y, error)
      class(witness_type), intent(inout) :: self
      class(motion_type), intent(inout) :: motion
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)
      type(error_type), allocatable, intent(out) :: error
      integer :: place

      call self%at%look(motion%system, t, y, error)
      if (allocated(error)) return
      associate (contact => self%at%contact(1), states => motion%system%contacts(1)%states)
         if (self%rows == 0) then
            self%energy = self%at%balance()
         else
            self%gain = min(self%gain, self%at%work_friction - self%lost(1), &
               self%at%work_damping - self%lost(2))
         end if
         self%rows = self%rows + 1
         self%residual = max(self%residual, abs(self%at%balance() - self%energy))
         self%lost = [self%at%work_friction, self%at%work_damping]
         self%stored = max(self%stored, contact%stored_friction)
         place = states%place("bristles")
         self%out_of_plane = max(self%out_of_plane, abs(dot_product(y(place + 1:place + 3), &
            contact%at%normal)))
         place = states%place("speed")
         if (place < 0 .or. abs(contact%at%gap) < 1.0e-9_wp) return
         if (contact%at%gap > 0.0_wp) then
            ! At lift-off a gap may be negative by its rounding for a moment.
            self%air = self%air .and. abs(y(place + 1) + 1.0_wp) < 1.0e-12_wp .and. &
               all(abs(y(place + 2:place + 4)) < 1.0e-15_wp)
         else
            self%surface = self%surface .and. y(place + 1) > 1.0e-3_wp
            if (self%touches == 1) self%surface = self%surface .and. &
               abs(y(place + 1) - sqrt(2.0_wp*9.81_wp*2.0e-3_wp)) < 1.0e-7_wp
         end if
      end associate
   end subroutine sample

   !> A contact touched or lifted off.
   subroutine event(self, t, kind, contact, error)
      class(witness_type), intent(inout) :: self
      real(wp), intent(in) :: t
      integer, intent(in) :: kind
      integer, intent(in) :: contact
      type(error_type), allocatable, intent(out) :: error

      if (kind == event_touch) self%touches = self%touches + 1
   end subroutine event

   !> A step is done.
   subroutine after_step(self, t, stop_now, error)
      class(witness_type), intent(inout) :: self
      real(wp), intent(in) :: t
      logical, intent(out) :: stop_now
      type(error_type), allocatable, intent(out) :: error

      self%steps = self%steps + 1
      stop_now = self%steps >= self%stop_after
   end subroutine after_step

end module test_states
