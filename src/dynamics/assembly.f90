!> From the description of a scene to the equations of motion.
module contensou_dynamics_assembly
   use, intrinsic :: ieee_arithmetic, only : ieee_is_nan
   use contensou_base_kinds, only : pi, wp
   use contensou_base_rotations, only : rotation_matrix
   use contensou_base_text_lock, only : lock_texts, unlock_texts
   use contensou_contact_curvature, only : curvature_model_type, curvature_models
   use contensou_contact_damping, only : damping_model_type, damping_models
   use contensou_contact_friction, only : friction_model_type, friction_models
   use contensou_contact_geometry, only : contact_point_type, contact_trouble, &
      pose_type, track_type, trouble_none
   use contensou_contact_hertz, only : effective_modulus
   use contensou_contact_normal, only : normal_model_type, normal_models
   use contensou_contact_pairs, only : new_geometry
   use contensou_contact_parameters, only : parameters_type, surroundings_type
   use contensou_contact_rolling, only : rolling_model_type, rolling_models
   use contensou_contact_shapes_shape, only : shape_info_type, shape_type
   use contensou_contact_states, only : state_list_type
   use contensou_contact_tangential, only : tangential_model_type, tangential_models
   use contensou_dynamics_equations, only : system_type
   use contensou_dynamics_mechanism, only : body_type, contact_type
   use contensou_dynamics_scene, only : body_spec_type, contact_spec_type, motion_rotor, &
      moves_freely, scene_type, surface_spec_type, turns_by_drive
   use contensou_dynamics_spots, only : assign_spots
   use contensou_dynamics_state, only : put_body
   implicit none(type, external)
   private

   public :: assemble, initial_state, initial_pose, contact_length, contact_time, reach_of, &
      reduced_mass, largest_relative_approach, place_spots, usual_overlap

   !> Largest approach over the smallest radius of curvature: beyond it the half-space theory of
   !> Hertz has no meaning.
   real(wp), parameter :: largest_relative_approach = 0.1_wp

   !> The tables of the parts.
   type :: tables_type
      type(normal_model_type), allocatable :: normal(:)
      type(damping_model_type), allocatable :: damping(:)
      type(friction_model_type), allocatable :: friction(:)
      type(rolling_model_type), allocatable :: rolling(:)
      type(tangential_model_type), allocatable :: tangential(:)
      type(curvature_model_type), allocatable :: curvature(:)
   end type tables_type

   !> These tables, made when they are first asked for: each case of a sweep is assembled by them.
   type(tables_type), allocatable, target :: shared

contains

   !> The tables of the parts, the same for all. Thread-safe.
   function shared_tables() result(tables)
      type(tables_type), pointer :: tables
      type(tables_type), allocatable :: made

      call lock_texts()
      if (.not. allocated(shared)) then
         allocate(made)
         made%normal = normal_models()
         made%damping = damping_models()
         made%friction = friction_models()
         made%rolling = rolling_models()
         made%tangential = tangential_models()
         made%curvature = curvature_models()
         call move_alloc(made, shared)
      end if
      tables => shared
      call unlock_texts()
   end function shared_tables

   !> Equations of motion of a checked scene.
   subroutine assemble(scene, system)
      !> The scene; its pairs of surfaces are supported.
      type(scene_type), intent(in) :: scene
      type(system_type), intent(out) :: system
      type(tables_type), pointer :: tables
      integer :: i, j, index, trouble

      tables => shared_tables()
      system%gravity = scene%gravity
      system%together = scene%together
      allocate(system%bodies(size(scene%bodies)), system%contacts(size(scene%contacts)))
      do i = 1, size(scene%bodies)
         call set_body(scene%bodies(i), system%bodies(i))
      end do
      do i = 1, size(scene%contacts)
         associate (spec => scene%contacts(i), contact => system%contacts(i))
            contact%spot = spec%spot
            contact%spots = spec%spots
            call set_law(scene, spec, tables, contact)
            contact%largest_position = largest_position(scene, contact)
            do j = 1, 2
               associate (owner => scene%surfaces(spec%surfaces(j)))
                  contact%reach(j) = reach_of(owner)
                  contact%centre(:, j) = owner%surface%centre
                  contact%lever(j) = lever_of(owner%surface%shape)
               end associate
            end do
         end associate
      end do
      allocate(system%springs(0))
      if (allocated(scene%springs)) system%springs = scene%springs%spring_type
      call system%prepare()
      system%searches = any([(system%contacts(i)%law%geometry%searched, i=1, &
         size(system%contacts))])
      system%several_spots = any(system%contacts%spots > 1)
      if (system%several_spots) call place_spots(scene, system, index, trouble)
   end subroutine assemble

   !> Give the spots of contacts that have several their places at the beginning.
   subroutine place_spots(scene, system, index, trouble)
      type(scene_type), intent(in) :: scene
      type(system_type), intent(inout) :: system
      !> Contact that touches in more places; 0 for none.
      integer, intent(out) :: index
      !> Why it cannot, one of the `trouble_*` codes.
      integer, intent(out) :: trouble
      integer :: i

      do i = 1, size(scene%bodies)
         system%pose(i) = initial_pose(scene, i)
      end do
      call assign_spots(system, spread(.false., 1, size(system%contacts)), index, trouble)
   end subroutine place_spots

   !> Mass, inertia and motion of a body of the scene.
   pure subroutine set_body(spec, body)
      type(body_spec_type), intent(in) :: spec
      type(body_type), intent(inout) :: body

      body%motion = spec%motion
      body%mass = spec%mass
      body%inertia = spec%inertia
      if (moves_freely(spec%motion)) then
         body%force = spec%applied_force
         body%torque = spec%applied_torque
         body%load_follows = spec%load_follows
         body%loaded = any(abs([body%force, body%torque]) > 0.0_wp)
      end if
      if (turns_by_drive(spec%motion) .and. spec%ramp_duration > 0.0_wp) then
         body%ramp = spec%ramp_duration
         body%acceleration = (spec%final_velocity - spec%velocity)/spec%ramp_duration
         body%angular_acceleration = (spec%final_angular_velocity &
            - matmul(rotation_matrix(spec%quaternion), spec%spin))/spec%ramp_duration
         ! About its own axis, which tilts.
         if (spec%motion == motion_rotor) body%angular_acceleration = &
            matmul(body%angular_acceleration, rotation_matrix(spec%quaternion))
      end if
   end subroutine set_body

   !> The parts of a contact.
   subroutine set_law(scene, spec, tables, contact)
      type(scene_type), intent(in) :: scene
      type(contact_spec_type), intent(in) :: spec
      type(tables_type), intent(in) :: tables
      type(contact_type), intent(inout) :: contact
      type(surroundings_type) :: around
      type(parameters_type) :: values

      associate (a => scene%surfaces(spec%surfaces(1)), b => scene%surfaces(spec%surfaces(2)), &
         law => contact%law, normal => tables%normal(spec%normal), &
         damping => tables%damping(spec%damping), friction => tables%friction(spec%friction), &
         rolling => tables%rolling(spec%rolling), &
         tangential => tables%tangential(spec%tangential))
         contact%a = a%body
         contact%b = b%body
         call new_geometry(a%surface, b%surface, law%geometry)
         law%largest_approach = largest_relative_approach*law%geometry%smallest_radius()
         around%young = scene%materials([a%material, b%material])%young
         around%poisson = scene%materials([a%material, b%material])%poisson
         around%modulus = effective_modulus(around%young(1), around%poisson(1), around%young(2), &
            around%poisson(2))
         around%curvatures = initial_curvatures(scene, contact)
         around%mass = reduced_mass(scene, a%body, b%body)
         around%with_shape = friction%acts
         call normal%create(normal%completed(spec%parameters), around, law%normal)
         contact%rigid = normal%rigid
         if (contact%rigid) then
            if (associated(damping%restitute)) call damping%restitute(spec%parameters, &
               contact%restitution, contact%restitution_slope)
         else if (damping%acts) then
            values = damping%completed(spec%parameters)
            call damping%create(values, around, law%damping)
         end if
         if (friction%acts) then
            values = friction%completed(spec%parameters)
            call friction%create(values, around, law%friction)
         end if
         associate (curvature => tables%curvature(spec%curvature))
            ! Statics are without friction.
            if (curvature%acts .and. allocated(law%friction)) then
               allocate(law%curved)
               call curvature%create(curvature%completed(spec%parameters), law%friction, law%curved)
            end if
         end associate
         if (rolling%acts) then
            values = rolling%completed(spec%parameters)
            call rolling%create(values, around, law%rolling)
         end if
         if (tangential%steady) then
            allocate(law%steady)
            call tangential%create_steady(tangential%completed(spec%parameters), around, &
               law%friction, law%steady)
            call law%steady%follow(law%normal%shape, law%geometry%constant_curvatures)
         end if
         if (tangential%acts .and. .not. tangential%steady) then
            allocate(contact%tangential)
            call tangential%create(tangential%completed(spec%parameters), around, law%friction, &
               contact%tangential)
            call own_states(damping, tangential%states(spec%parameters), contact)
         else if (associated(damping%put_states) .or. associated(friction%put_states)) then
            call own_states(damping, friction%states(), contact)
         end if
      end associate
   end subroutine set_law

   !> The states of the parts of a contact; without compliance there is no damping.
   subroutine own_states(damping, of_friction, contact)
      type(damping_model_type), intent(in) :: damping
      !> States of friction, or of tangential elasticity.
      type(state_list_type), intent(in) :: of_friction
      type(contact_type), intent(inout) :: contact
      type(state_list_type) :: of_damping

      if (.not. contact%rigid) of_damping = damping%states()
      call contact%own(of_damping, of_friction)
   end subroutine own_states

   !> Half relative curvatures A and B of a pair at the beginning [1/m]; where it has no point of
   !> contact then, those of a sphere of its smallest radius.
   function initial_curvatures(scene, contact) result(curvatures)
      type(scene_type), intent(in) :: scene
      !> The contact; its track is left as it was.
      type(contact_type), intent(inout) :: contact
      real(wp) :: curvatures(2)
      type(pose_type) :: a, b
      type(track_type) :: track
      type(contact_point_type) :: at
      real(wp) :: gap

      curvatures = 0.5_wp/contact%law%geometry%smallest_radius()
      a = initial_pose(scene, contact%a)
      b = initial_pose(scene, contact%b)
      track = contact%track
      call contact%find_gap(a, b, gap)
      if (.not. contact%track%lost) then
         call contact%locate(a, b, gap, at)
         if (contact_trouble(contact%track, at) == trouble_none) then
            curvatures = [at%curvature_a, at%curvature_b]
         end if
      end if
      contact%track = track
   end function initial_curvatures

   !> Pose of a body at the beginning.
   pure function initial_pose(scene, body) result(pose)
      type(scene_type), intent(in) :: scene
      !> Index of the body; 0 for the ground.
      integer, intent(in) :: body
      type(pose_type) :: pose

      if (body == 0) return
      pose%position = scene%bodies(body)%position
      pose%rotation = rotation_matrix(scene%bodies(body)%quaternion)
      pose%velocity = scene%bodies(body)%velocity
      pose%spin = matmul(pose%rotation, scene%bodies(body)%spin)
   end function initial_pose

   !> Reduced mass of two bodies [kg]; that of the other one if one does not yield: the ground, a
   !> body that is fixed or whose motion is prescribed.
   pure function reduced_mass(scene, a, b) result(mass)
      type(scene_type), intent(in) :: scene
      !> First body, 0 for the ground.
      integer, intent(in) :: a
      !> Second body, 0 for the ground.
      integer, intent(in) :: b
      real(wp) :: mass

      mass = 1.0_wp/(inverse(a) + inverse(b))

   contains

      !> Inverse mass of a body [1/kg].
      pure real(wp) function inverse(body)
         integer, intent(in) :: body

         inverse = 0.0_wp
         if (body == 0) return
         if (moves_freely(scene%bodies(body)%motion)) inverse = 1.0_wp/scene%bodies(body)%mass
      end function inverse

   end function reduced_mass

   !> State at the beginning.
   pure function initial_state(scene, n) result(y)
      type(scene_type), intent(in) :: scene
      !> Length of the state.
      integer, intent(in) :: n
      real(wp) :: y(n)
      integer :: i

      y = 0.0_wp
      do i = 1, size(scene%bodies)
         associate (body => scene%bodies(i))
            call put_body(y, i, body%position, body%quaternion, body%velocity, body%spin)
         end associate
      end do
   end function initial_state

   !> Length scale of the contacts of a scene [m]: a tenth of the smallest overlap under gravity,
   !> or without gravity of that of an impact at a given speed; 1e-6 m without contacts.
   !>
   !> A tenth, because a lightly damped contact rings for thousands of periods, and the phase of
   !> the ringing at the next touch decides what follows.
   pure function contact_length(scene, system, speed) result(length)
      type(scene_type), intent(in) :: scene
      type(system_type), intent(in) :: system
      !> Speed of the impact [m/s], > 0.
      real(wp), intent(in) :: speed
      real(wp) :: length
      integer :: i

      length = huge(length)
      do i = 1, size(system%contacts)
         if (system%contacts(i)%rigid) then
            ! There is no overlap to resolve; the length is that of the surfaces.
            length = min(length, system%contacts(i)%law%geometry%smallest_radius())
         else
            length = min(length, usual_overlap(scene, system%contacts(i), speed))
         end if
      end do
      length = 0.1_wp*length
      if (size(system%contacts) == 0) length = 1.0e-6_wp
   end function contact_length

   !> Overlap of a contact of compliance under gravity, or without gravity that of an impact at a
   !> given speed [m].
   pure function usual_overlap(scene, contact, speed) result(overlap)
      type(scene_type), intent(in) :: scene
      type(contact_type), intent(in) :: contact
      !> Speed of the impact [m/s], > 0.
      real(wp), intent(in) :: speed
      real(wp) :: overlap
      real(wp) :: mass, g

      overlap = huge(overlap)
      g = norm2(scene%gravity)
      associate (stiffness => contact%law%normal%stiffness)
         ! Such a contact is refused by the reader.
         if (ieee_is_nan(stiffness)) return
         mass = reduced_mass(scene, contact%a, contact%b)
         if (g > 0.0_wp) then
            overlap = (mass*g/stiffness)**(2.0_wp/3.0_wp)
         else
            overlap = (1.25_wp*mass*speed**2/stiffness)**0.4_wp
         end if
      end associate
   end function usual_overlap

   !> Distance from the centre of a shape within which all its normals pass [m]; the largest number
   !> where it has no end. What is convex is swept by a sphere of the smallest radius of curvature,
   !> whose centre its normals pass through (W. Blaschke, Kreis und Kugel (1916)).
   pure function lever_of(shape) result(lever)
      class(shape_type), intent(in) :: shape
      real(wp) :: lever
      type(shape_info_type) :: info

      lever = huge(lever)
      info = shape%info()
      if (info%bounded .and. shape%smallest_radius() <= shape%extent()) then
         lever = shape%extent() - shape%smallest_radius()
      end if
   end function lever_of

   !> Radius about the centre of mass of a body that holds a surface of it [m]; the largest number
   !> where the surface has no end.
   pure function reach_of(spec) result(radius)
      type(surface_spec_type), intent(in) :: spec
      real(wp) :: radius
      type(shape_info_type) :: info

      radius = huge(radius)
      info = spec%surface%shape%info()
      if (info%bounded) radius = norm2(spec%surface%centre) &
         + max(spec%surface%shape%extent(), spec%surface%shape%smallest_radius())
   end function reach_of

   !> Largest coordinate of a body at which its contact is resolved [m]: there the rounding of a
   !> position is one part in 640 of the usual overlap, without compliance four parts in 1e9 of the
   !> smallest radius.
   pure function largest_position(scene, contact) result(position)
      type(scene_type), intent(in) :: scene
      type(contact_type), intent(in) :: contact
      real(wp) :: position

      if (contact%rigid) then
         position = 4.0e-9_wp*contact%law%geometry%smallest_radius()/epsilon(position)
      else
         position = min(usual_overlap(scene, contact, scene%integrator%velocity_scale), &
            1.0e100_wp)/(640.0_wp*epsilon(position))
      end if
   end function largest_position

   !> Shortest time that a contact of a scene takes [s]: that of an elastic impact at a given speed,
   !> 3.218 (m^2/(k_n^2 v))^(1/5), or 2 pi sqrt(m/k) of the spring of a contact under gravity where
   !> that is shorter; 0 without contacts. H. Hertz, J. reine angew. Math. 92 (1881) 156.
   pure function contact_time(scene, system, speed) result(time)
      type(scene_type), intent(in) :: scene
      type(system_type), intent(in) :: system
      !> Speed of the impact [m/s], > 0.
      real(wp), intent(in) :: speed
      real(wp) :: time
      real(wp) :: mass, g, stiffness
      integer :: i

      g = norm2(scene%gravity)
      time = huge(time)
      do i = 1, size(system%contacts)
         mass = reduced_mass(scene, system%contacts(i)%a, system%contacts(i)%b)
         stiffness = system%contacts(i)%law%normal%stiffness
         time = min(time, 3.218_wp*(mass**2/(stiffness**2*speed))**0.2_wp)
         if (g > 0.0_wp) time = min(time, 2.0_wp*pi*sqrt(mass/(1.5_wp*stiffness)) &
            /(mass*g/stiffness)**(1.0_wp/6.0_wp))
      end do
      if (size(system%contacts) == 0) time = 0.0_wp
   end function contact_time

end module contensou_dynamics_assembly
