!> What is legal in a scene and hardly meant.
module contensou_scene_warnings
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite
   use contensou_base_diagnostics, only : diagnostics_type, origin_type
   use contensou_base_kinds, only : wp
   use contensou_base_numbers, only : number_text, to_text
   use contensou_base_schema, only : schema_type
   use contensou_base_settings, only : group_settings_type, settings_type
   use contensou_base_text, only : quote
   use contensou_contact_geometry, only : track_type
   use contensou_dynamics_assembly, only : initial_pose, reach_of, reduced_mass
   use contensou_dynamics_equations, only : system_type
   use contensou_dynamics_scene, only : body_spec_type, motion_free, motion_names, moves_freely, &
      scene_type
   implicit none(type, external)
   private

   public :: find_warnings

   !> Friction coefficient above which hardly any surfaces are.
   real(wp), parameter :: largest_friction = 2.0_wp

   !> Share of the speeds of a scene above which regularization changes what they do.
   real(wp), parameter :: largest_share = 0.1_wp

   !> Sizes of things and speeds of a scene.
   type :: scales_type
      !> Radius about the centre of mass of each body that holds its surfaces [m]; huge if one of
      !> them has no end or holds the others, 0 for none.
      real(wp), allocatable :: radius(:)
      !> Largest speed at the beginning, of a drive, or of the fall on a surface [m/s].
      real(wp) :: speed = 0.0_wp
      !> Whether a surface has a contact, and a body has a contact or a spring.
      logical, allocatable :: surface_touches(:), body_touches(:)
   end type scales_type

contains

   !> Look through a scene that is in order.
   subroutine find_warnings(settings, schema, scene, system, warnings)
      type(settings_type), intent(in), target :: settings
      type(schema_type), intent(in), target :: schema
      type(scene_type), intent(in) :: scene
      !> Its equations of motion; left as they were.
      type(system_type), intent(inout) :: system
      type(diagnostics_type), intent(inout) :: warnings
      type(group_settings_type) :: group
      type(scales_type) :: scales
      integer :: i, bodies, surfaces, contact

      call find_scales(scene, system, scales)
      bodies = 0
      surfaces = 0
      contact = 0
      do i = 1, size(settings%groups)
         group = settings%group(i, schema)
         select case (group%group_name())
         case ("body")
            bodies = bodies + 1
            call look_at_body(group, scene, bodies, scales, warnings)
         case ("surface")
            surfaces = surfaces + 1
            if (.not. scales%surface_touches(surfaces)) call warn_of_surface(group, &
               scene%surfaces(surfaces)%name, warnings)
         case ("contact")
            ! The first of its spots.
            if (contact > 0) contact = contact + scene%contacts(contact)%spots
            contact = max(contact, 1)
            call look_at_friction(group, scales%speed, warnings)
            call look_at_damping(group, scene, system, contact, warnings)
         case default
            continue
         end select
      end do
   end subroutine find_warnings

   !> Sizes and speeds.
   subroutine find_scales(scene, system, scales)
      type(scene_type), intent(in) :: scene
      !> Its equations of motion; left as they were.
      type(system_type), intent(inout) :: system
      type(scales_type), intent(out) :: scales
      type(track_type) :: track
      real(wp) :: g, gap, load, reach
      integer :: i, k

      allocate(scales%surface_touches(size(scene%surfaces)), source=.false.)
      allocate(scales%body_touches(size(scene%bodies)), source=.false.)
      do i = 1, size(scene%contacts)
         associate (pair => scene%contacts(i)%surfaces)
            scales%surface_touches(pair) = .true.
            do k = 1, 2
               associate (body => scene%surfaces(pair(k))%body)
                  if (body > 0) scales%body_touches(body) = .true.
               end associate
            end do
         end associate
      end do
      if (allocated(scene%springs)) then
         do i = 1, size(scene%springs)
            if (scene%springs(i)%a > 0) scales%body_touches(scene%springs(i)%a) = .true.
            if (scene%springs(i)%b > 0) scales%body_touches(scene%springs(i)%b) = .true.
         end do
      end if
      g = norm2(scene%gravity)
      allocate(scales%radius(size(scene%bodies)), source=0.0_wp)
      do i = 1, size(scene%surfaces)
         associate (surface => scene%surfaces(i))
            if (surface%body == 0) cycle
            reach = reach_of(surface)
            if (surface%surface%inside) reach = huge(reach)
            scales%radius(surface%body) = max(scales%radius(surface%body), reach)
         end associate
      end do
      load = g
      do i = 1, size(scene%bodies)
         associate (body => scene%bodies(i), radius => scales%radius(i))
            reach = 0.0_wp
            if (radius < huge(radius)) reach = radius
            scales%speed = max(scales%speed, norm2(body%velocity), norm2(body%final_velocity), &
               reach*norm2(body%spin), reach*norm2(body%final_angular_velocity))
            if (body%mass > 0.0_wp) load = max(load, g + norm2(body%applied_force)/body%mass)
         end associate
      end do
      do i = 1, size(system%contacts)
         associate (contact => system%contacts(i))
            track = contact%track
            call contact%find_gap(initial_pose(scene, contact%a), &
               initial_pose(scene, contact%b), gap)
            if (.not. contact%track%lost .and. ieee_is_finite(gap)) scales%speed = max( &
               scales%speed, min(sqrt(2.0_wp*g*max(gap, 0.0_wp)), g*scene%t_end))
            contact%track = track
         end associate
      end do
      ! All that a body can gain that begins at rest.
      if (scales%speed <= 0.0_wp) scales%speed = load*scene%t_end
   end subroutine find_scales

   !> A body that nothing acts on, or whose moments of inertia are too large for its size.
   subroutine look_at_body(group, scene, index, scales, warnings)
      type(group_settings_type), intent(in) :: group
      type(scene_type), intent(in) :: scene
      !> Which body.
      integer, intent(in) :: index
      type(scales_type), intent(in) :: scales
      type(diagnostics_type), intent(inout) :: warnings
      real(wp) :: largest
      integer :: i

      associate (body => scene%bodies(index), radius => scales%radius(index), &
         touches => scales%body_touches(index))
         if (.not. moves_freely(body%motion)) then
            if (.not. touches) call warnings%add(group%place("name", 1), "body " // &
               quote(body%name) // ", whose motion is '" // trim(motion_names(body%motion)) // &
               "', has no contact and acts on nothing", "a contact of one of its surfaces, or " // &
               "no such body")
            return
         end if
         if (.not. (touches .or. norm2(scene%gravity) > 0.0_wp .or. is_loaded(body))) call &
            warnings%add(group%place("name", 1), "nothing acts on body " // quote(body%name) // &
            ": it has no contact, no load, and there is no gravity", &
            "scene.gravity, a contact of one of its surfaces, or a load")
         if (body%motion /= motion_free .or. radius <= 0.0_wp .or. radius >= huge(radius)) return
         largest = body%mass*radius**2
         i = maxloc(body%inertia, dim=1)
         if (body%inertia(i) > largest*(1.0_wp + 1.0e-9_wp)) call warnings%add( &
            group%place("inertia", i), "the moment of inertia of body " // quote(body%name) // &
            " of " // number_text(body%inertia(i), 4) // " kg m2 is impossible for its size", &
            "at most " // number_text(largest, 4) // " kg m2 with " // &
            number_text(body%mass, 4) // " kg within the " // number_text(radius, 4) // &
            " m that its surfaces reach from its centre of mass; a solid ball has 0.4 of that")
      end associate

   contains

      !> Whether there is a load on a body.
      pure logical function is_loaded(body)
         type(body_spec_type), intent(in) :: body

         is_loaded = any(abs(body%applied_force) > 0.0_wp) .or. &
            any(abs(body%applied_torque) > 0.0_wp)
      end function is_loaded

   end subroutine look_at_body

   !> A surface in no contact.
   subroutine warn_of_surface(group, name, warnings)
      type(group_settings_type), intent(in) :: group
      character(len=*), intent(in) :: name
      type(diagnostics_type), intent(inout) :: warnings

      call warnings%add(group%place("name", 1), "surface " // quote(name) // &
         " is in no contact, nothing can touch it", "&contact surfaces = " // quote(name) // &
         ", ... /, or no such surface")
   end subroutine warn_of_surface

   !> Friction that is too strong or too much regularized.
   subroutine look_at_friction(group, speed, warnings)
      type(group_settings_type), intent(in) :: group
      !> Speed of the scene [m/s].
      real(wp), intent(in) :: speed
      type(diagnostics_type), intent(inout) :: warnings
      real(wp) :: value

      value = group%number("friction_coefficient")
      if (value > largest_friction) call warn(group%place("friction_coefficient", 1), &
         "a friction coefficient of " // to_text(value) // " is larger than that of any usual " // &
         "surfaces", "friction_coefficient of 0 to " // to_text(largest_friction), warnings)
      value = group%number("regularization_velocity")
      ! Of what begins at rest under loads, the speeds are not known.
      if (speed > 0.0_wp .and. value > largest_share*speed) call warn( &
         group%place("regularization_velocity", 1), &
         "a regularization_velocity of " // to_text(value) // " m/s is not small against the " // &
         "speeds of the scene, about " // number_text(speed, 3) // " m/s: friction is too weak" // &
         " where surfaces slide more slowly", "regularization_velocity of at most " // &
         number_text(largest_share*speed, 3) // " m/s, and better a hundredth of that", warnings)
   end subroutine look_at_friction

   !> Damping that leaves nothing of an oscillation.
   subroutine look_at_damping(group, scene, system, index, warnings)
      type(group_settings_type), intent(in) :: group
      type(scene_type), intent(in) :: scene
      type(system_type), intent(in) :: system
      !> Which contact.
      integer, intent(in) :: index
      type(diagnostics_type), intent(inout) :: warnings
      real(wp) :: ratio, mass, g, force, depth

      if (.not. group%is_given("damping_coefficient")) return
      associate (contact => system%contacts(index))
         if (contact%rigid .or. .not. allocated(contact%law%damping)) return
         mass = reduced_mass(scene, contact%a, contact%b)
         g = norm2(scene%gravity)
         ! At the overlap under gravity, or without it of a slow elastic impact.
         if (g > 0.0_wp) then
            depth = (mass*g/contact%law%normal%stiffness)**(2.0_wp/3.0_wp)
         else
            depth = (1.25_wp*mass*scene%integrator%velocity_scale**2 &
               /contact%law%normal%stiffness)**0.4_wp
         end if
         force = contact%law%normal%stiffness*depth*sqrt(depth)
         associate (slopes => contact%law%damping%slopes(force, depth, 0.0_wp))
            ratio = 0.5_wp*slopes(3)/sqrt(mass*1.5_wp*force/depth)
         end associate
      end associate
      if (ratio > 1.0_wp) call warn(group%place("damping_coefficient", 1), "contact " // &
         quote(scene%contacts(index)%name) // " is overdamped: its damping is " // &
         number_text(ratio, 3) // " times the critical one", "damping_coefficient of at most " // &
         number_text(group%number("damping_coefficient")/ratio, 3), warnings)
   end subroutine look_at_damping

   !> Add a warning, unless there is one at its place: one group may stand for many contacts.
   subroutine warn(origin, message, expected, warnings)
      type(origin_type), intent(in) :: origin
      character(len=*), intent(in) :: message
      character(len=*), intent(in) :: expected
      type(diagnostics_type), intent(inout) :: warnings
      type(origin_type) :: other
      integer :: i

      do i = 1, warnings%kept()
         other = warnings%origin(i)
         if (other%source == origin%source .and. other%line == origin%line .and. &
            other%column == origin%column .and. origin%line > 0) return
      end do
      call warnings%add(origin, message, expected)
   end subroutine warn

end module contensou_scene_warnings
