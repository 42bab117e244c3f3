!> A group `bearing` stands for the bodies, surfaces and contacts of a ball bearing.
!> Its mechanics are those of `contensou_dynamics_bearing`.
module contensou_scene_bearing
   use contensou_base_attitude, only : read_attitude
   use contensou_base_diagnostics, only : diagnostics_type, origin_type
   use contensou_base_document, only : document_type, group_type, value_real, value_text
   use contensou_base_document_types, only : move_group, resize_groups, selection
   use contensou_base_kinds, only : pi, wp
   use contensou_base_rotations, only : rotation_matrix, unit_quaternion
   use contensou_base_numbers, only : to_text
   use contensou_base_resolve, only : resolve
   use contensou_base_schema, only : key_type, schema_type
   use contensou_base_settings, only : group_settings_type, settings_type
   use contensou_base_text, only : lower
   use contensou_base_vectors, only : cross, unit_vector
   use contensou_contact_hertz, only : effective_modulus
   use contensou_contact_normal, only : normal_model_type, normal_models, normal_type
   use contensou_contact_parameters, only : parameters_type, surroundings_type
   use contensou_dynamics_bearing, only : ball_bearing_type, bearing_state_type, largest_angle
   use contensou_scene_schema, only : ring_motions
   implicit none(type, external)
   private

   public :: expand_bearings, bearing_group

   character(len=*), parameter :: bearing_group = "bearing"

   !> How a ring moves that can tilt; the first one does not.
   integer, parameter :: ring_spindle = 1, ring_free = 3

   !> Largest cosine between the axis and a direction across it.
   real(wp), parameter :: askew = 1.0e-6_wp

   !> Overlap of balls that just touch, over their radius.
   real(wp), parameter :: touch = 1.0e-11_wp

   !> Names of the arcs of a groove in those of surfaces and contacts: one arc, or the two by the
   !> side of the groove on which balls touch them, along the axis and against it.
   character(len=*), parameter :: single(1) = [""], double(2) = ["_upper", "_lower"]

   !> What a group `bearing` says, in numbers.
   type, extends(ball_bearing_type) :: bearing_type
      character(len=:), allocatable :: name
      !> Angular velocities of the rings: inner, outer [rad/s].
      real(wp) :: speed(2) = 0.0_wp
      !> Which ring is loaded: 1 inner, 2 outer.
      integer :: loaded = 1
      !> Whether that ring is free to move.
      logical :: free = .false.
      !> How it moves then, and its moments of inertia across and about the axis [kg m2].
      integer :: motion = ring_spindle
      real(wp) :: inertia(2) = 0.0_wp
      !> Torque on it [N m].
      real(wp) :: moment(3) = 0.0_wp
      !> Whether bodies of the scene carry the grooves: inner, outer; their positions and attitudes.
      logical :: carried(2) = .false.
      real(wp) :: origin(3, 2) = 0.0_wp, attitude(3, 3, 2) = 0.0_wp
      !> Contact angle without load and play [rad]; 0 where the clearance is given.
      real(wp) :: angle = 0.0_wp
      !> Axial force with which a bearing of that angle begins without an axial load [N].
      real(wp) :: preload = 0.0_wp
      !> Loads [N].
      real(wp) :: axial = 0.0_wp, radial = 0.0_wp
      !> Direction of the radial load, unit vector.
      real(wp) :: towards(3) = 0.0_wp
      !> Whether balls and cage begin rolling.
      logical :: rolling = .false.
      !> Whether there is a cage.
      logical :: cage = .false.
      !> Diameter of a pocket less that of a ball [m].
      real(wp) :: pocket = 0.0_wp
      !> Centre [m].
      real(wp) :: centre(3) = 0.0_wp
      !> Attitude of the bearing: turns the z axis into its axis.
      real(wp) :: quaternion(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      !> Its axes: towards ball 1, across, along the axis.
      real(wp) :: frame(3, 3) = 0.0_wp
      !> How rings and balls lie at the beginning.
      type(bearing_state_type) :: state
   end type bearing_type

contains

   !> Put bodies, surfaces and contacts in the place of every group `bearing`. What they say stands
   !> where the key of the bearing stands that it comes from, or else where its group begins.
   subroutine expand_bearings(document, schema, diagnostics)
      !> The document; a bearing with a mistake is left out, and the document is no longer complete.
      type(document_type), intent(inout) :: document
      type(schema_type), intent(in), target :: schema
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics
      type(settings_type), target :: bearings, materials, bodies
      type(group_settings_type), allocatable :: matter(:), carriers(:)
      type(diagnostics_type) :: ignored
      type(group_type), allocatable :: parts(:)
      type(document_type) :: expanded
      type(bearing_type) :: bearing
      integer :: i, k, n, b
      logical :: good

      if (.not. any([(document%groups(i)%name == bearing_group, i=1, document%n_groups)])) return
      call resolve(selection(document, "material"), schema, materials, ignored)
      matter = [(materials%group(i, schema), i=1, size(materials%groups))]
      call resolve(selection(document, "body"), schema, bodies, ignored)
      carriers = [(bodies%group(i, schema), i=1, size(bodies%groups))]
      call resolve(selection(document, bearing_group), schema, bearings, diagnostics)
      n = document%n_groups
      do i = 1, size(bearings%groups)
         n = n + size_of(bearings%group(i, schema))
      end do
      allocate(expanded%groups(n))
      n = 0
      b = 0
      do i = 1, document%n_groups
         if (document%groups(i)%name /= bearing_group) then
            n = n + 1
            call move_group(document%groups(i), expanded%groups(n))
            cycle
         end if
         b = b + 1
         associate (group => bearings%group(b, schema))
            call read_bearing(group, schema%groups(group%kind)%keys, matter, carriers, bearing, &
               diagnostics, good)
            if (.not. good) then
               document%complete = .false.
               cycle
            end if
            allocate(parts(size_of(group)))
            call make_parts(group, schema, bearing, parts, k)
         end associate
         do k = 1, k
            n = n + 1
            call move_group(parts(k), expanded%groups(n))
         end do
         deallocate(parts)
      end do
      expanded%n_groups = n
      call resize_groups(expanded, n)
      call move_alloc(expanded%groups, document%groups)
      document%n_groups = n
   end subroutine expand_bearings

   !> Largest number of groups that a bearing stands for.
   integer function size_of(group)
      type(group_settings_type), intent(in) :: group

      size_of = 7 + 8*max(group%integer("ball_count"), 1)
   end function size_of

   !> Read and check a bearing.
   subroutine read_bearing(instance, keys, materials, carriers, bearing, diagnostics, good)
      !> Group `bearing`.
      type(group_settings_type), intent(in) :: instance
      !> The keys of the group.
      type(key_type), intent(in) :: keys(:)
      !> The materials of the scene.
      type(group_settings_type), intent(in) :: materials(:)
      !> The bodies of the scene.
      type(group_settings_type), intent(in) :: carriers(:)
      type(bearing_type), intent(out) :: bearing
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics
      !> Whether it is in order.
      logical, intent(out) :: good
      integer :: before, i

      before = diagnostics%count()
      good = instance%complete
      do i = 1, size(keys)
         associate (name => keys(i)%name)
            ! A value that is out of order is reported already.
            if (instance%is_given(name) .and. .not. instance%is_set(name) .or. &
               instance%is_misspelt(name)) good = .false.
            if (keys(i)%mandatory .and. .not. instance%is_set(name)) good = .false.
         end associate
      end do
      if (.not. good) return
      bearing%name = instance%label()
      bearing%r = 0.5_wp*instance%number("ball_diameter")
      bearing%pitch = 0.5_wp*instance%number("pitch_diameter")
      bearing%balls = instance%integer("ball_count")
      bearing%clearance = instance%number("clearance")
      bearing%speed = [instance%number("inner_speed"), instance%number("outer_speed")]
      bearing%centre = instance%numbers("centre")
      bearing%rolling = instance%choice("initial_state") == 2
      bearing%loaded = max(instance%choice("loaded_ring"), 1)
      bearing%free = instance%is_given("ring_mass")
      bearing%axial = instance%number("axial_load")
      bearing%radial = instance%number("radial_load")
      bearing%cage = instance%flag("cage")
      bearing%pocket = instance%number("pocket_clearance")
      bearing%motion = max(instance%choice("ring_motion"), ring_spindle)
      if (has("ring_inertia")) bearing%inertia = instance%vector("ring_inertia", 2)
      bearing%moment = instance%numbers("moment_load")
      if (has("preload")) bearing%preload = instance%number("preload")
      call read_grooves(instance, bearing, diagnostics)
      call read_angle(instance, bearing, diagnostics)
      call read_carriers(instance, carriers, bearing, diagnostics)
      call read_axes(instance, bearing, diagnostics)
      call check_together()
      good = diagnostics%count() == before
      if (.not. good) return
      call check_room(instance, bearing, diagnostics)
      good = diagnostics%count() == before
      if (.not. good) return
      call set_initial_state(instance, materials, bearing, diagnostics)
      good = diagnostics%count() == before

   contains

      !> Report a mistake at a key.
      subroutine wrong(key, message, expected)
         character(len=*), intent(in) :: key
         !> What is wrong.
         character(len=*), intent(in) :: message
         !> What would be right.
         character(len=*), intent(in) :: expected

         call diagnostics%add(place_of(instance, key), message, expected)
      end subroutine wrong

      !> Whether a key is given.
      logical function has(key)
         character(len=*), intent(in) :: key

         has = instance%is_given(key)
      end function has

      !> Keys that need or exclude each other.
      subroutine check_together()
         character(len=*), parameter :: loads(*) = [character(len=11) :: "axial_load", &
            "radial_load"]
         character(len=*), parameter :: of_cage(*) = [character(len=25) :: "cage_mass", &
            "pocket_clearance", "cage_material", "cage_friction_coefficient"]
         integer :: k

         do k = 1, size(loads)
            if (abs(instance%number(trim(loads(k)))) > 0.0_wp .and. .not. has("ring_mass")) call &
               wrong(trim(loads(k)), "'" // trim(loads(k)) // "' without 'ring_mass'", &
               "ring_mass = the mass of the loaded ring [kg]")
         end do
         if (has("preload") .and. .not. abs(bearing%angle) > 0.0_wp) call wrong("preload", &
            "'preload' without 'contact_angle'", "contact_angle = an angle [rad], or axial_load")
         if (has("preload") .and. has("ring_mass")) call wrong("preload", &
            "'preload' beside 'ring_mass'", "axial_load = the load of the ring [N]")
         if (has("ring_motion") .and. .not. has("ring_mass")) call wrong("ring_motion", &
            "'ring_motion' without 'ring_mass'", "ring_mass = the mass of the loaded ring [kg]")
         if (bearing%motion == ring_spindle) then
            if (has("ring_inertia")) call wrong("ring_inertia", "'ring_inertia' of a ring " // &
               "that does not tilt", "ring_motion = 'rotor' or 'free'")
            if (has("moment_load")) call wrong("moment_load", "'moment_load' on a ring that " // &
               "does not tilt", "ring_motion = 'rotor' or 'free'")
         else if (.not. has("ring_inertia")) then
            call wrong("ring_motion", "a ring that tilts needs 'ring_inertia'", &
               "ring_inertia = two numbers > 0, across the axis and about it [kg m2]")
         end if
         if (bearing%carried(bearing%loaded) .and. has("ring_mass")) call wrong("ring_mass", &
            "'ring_mass' has no meaning where a body of the scene carries the groove", &
            "loads and mass of that body")
         if (has("loaded_ring") .and. .not. has("ring_mass")) call wrong("loaded_ring", &
            "'loaded_ring' without 'ring_mass'", "ring_mass = the mass of that ring [kg]")
         if (has("radial_direction") .and. abs(bearing%radial) <= 0.0_wp) call &
            wrong("radial_direction", "'radial_direction' without 'radial_load'", &
            "radial_load = a force [N]")
         if (bearing%rolling .and. has("ramp_duration")) call wrong("ramp_duration", &
            "'ramp_duration' has no meaning for a bearing that begins rolling", &
            "initial_state = 'rest', or no ramp_duration")
         if (has("ramp_duration") .and. all(abs(bearing%speed) <= 0.0_wp)) call &
            wrong("ramp_duration", "'ramp_duration' without a speed", "inner_speed or outer_speed")
         do k = 1, size(of_cage)
            if (has(trim(of_cage(k))) .and. .not. bearing%cage) call wrong(trim(of_cage(k)), &
               "'" // trim(of_cage(k)) // "' without 'cage'", "cage = .true.")
            if (bearing%cage .and. k <= 2 .and. .not. has(trim(of_cage(k)))) call wrong("cage", &
               "a cage needs '" // trim(of_cage(k)) // "'", trim(of_cage(k)) // &
               " = a number > 0" // trim(merge(" [kg]", " [m] ", k == 1)))
         end do
         if (has("cage_friction_coefficient") .and. .not. has("friction")) call &
            wrong("cage_friction_coefficient", "'cage_friction_coefficient' without 'friction'", &
            "friction = the name of a model")
      end subroutine check_together

   end subroutine read_bearing

   !> Contact angle in place of the clearance.
   subroutine read_angle(instance, bearing, diagnostics)
      !> Group `bearing`.
      type(group_settings_type), intent(in) :: instance
      !> The bearing, its grooves known; its clearance is set.
      type(bearing_type), intent(inout) :: bearing
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics

      if (instance%flag("four_point")) then
         bearing%lean = instance%number("contact_angle")
         if (.not. bearing%lean > 0.0_wp) call diagnostics%add(place_of(instance, &
            trim(merge("contact_angle", "four_point   ", instance%is_given("contact_angle")))), &
            "'four_point' needs the contact angle of unloaded balls", &
            "contact_angle > 0 [rad], as 0.61")
         return
      end if
      if (.not. instance%is_given("contact_angle")) return
      call instance%refuse("clearance", "'clearance' beside 'contact_angle', from which it " // &
         "follows", "either clearance or contact_angle", diagnostics)
      bearing%angle = instance%number("contact_angle")
      bearing%clearance = bearing%clearance_at(bearing%angle)
      if (bearing%axial*bearing%angle*merge(1.0_wp, -1.0_wp, bearing%loaded == 1) < 0.0_wp) call &
         diagnostics%add(place_of(instance, "axial_load"), &
         "'axial_load' pulls the rings apart, against 'contact_angle'", &
         "axial_load in the sense in which the contact angle carries")
   end subroutine read_angle

   !> Bodies of the scene that carry the grooves.
   subroutine read_carriers(instance, carriers, bearing, diagnostics)
      !> Group `bearing`.
      type(group_settings_type), intent(in) :: instance
      !> The bodies of the scene.
      type(group_settings_type), intent(in) :: carriers(:)
      type(bearing_type), intent(inout) :: bearing
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics
      character(len=*), parameter :: keys(2) = ["inner_body", "outer_body"], &
         unknown(*) = [character(len=7) :: "density", "place", "count"]
      real(wp) :: quaternion(4)
      character(len=:), allocatable :: wanted
      type(diagnostics_type) :: ignored
      integer :: k, i, j

      do k = 1, 2
         bearing%attitude(:, :, k) = rotation_matrix([1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp])
         bearing%carried(k) = instance%is_set(keys(k))
         if (.not. bearing%carried(k)) cycle
         wanted = lower(instance%text(keys(k)))
         ! A body that is not there is reported where a groove refers to it.
         do i = 1, size(carriers)
            associate (body => carriers(i))
               if (lower(body%label()) /= wanted) cycle
               quaternion = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
               call read_attitude(body, quaternion, ignored)
               bearing%attitude(:, :, k) = rotation_matrix(quaternion)
               bearing%origin(:, k) = body%numbers("position")
               do j = 1, size(unknown)
                  if (body%is_given(trim(unknown(j)))) call diagnostics%add(place_of(instance, &
                     keys(k)), "'" // trim(unknown(j)) // "' of body '" // body%label() // &
                     "' leaves open where it is", "a body with mass, inertia and position")
               end do
            end associate
         end do
      end do
   end subroutine read_carriers

   !> Radii of the grooves.
   subroutine read_grooves(instance, bearing, diagnostics)
      !> Group `bearing`.
      type(group_settings_type), intent(in) :: instance
      !> The bearing; the radii of its grooves are set.
      type(bearing_type), intent(inout) :: bearing
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics
      character(len=*), parameter :: rings(2) = ["inner", "outer"]
      character(len=:), allocatable :: radius_key, ratio_key
      integer :: k

      do k = 1, 2
         radius_key = rings(k) // "_groove_radius"
         ratio_key = rings(k) // "_groove_ratio"
         if (instance%is_given(radius_key) .and. instance%is_given(ratio_key)) then
            call instance%refuse(radius_key, "the groove of the " // rings(k) // &
               " ring is given twice", "either " // ratio_key // " or " // radius_key, diagnostics)
         else if (instance%is_given(ratio_key)) then
            bearing%groove(k) = 2.0_wp*bearing%r*instance%number(ratio_key)
         else if (instance%is_given(radius_key)) then
            bearing%groove(k) = instance%number(radius_key)
            if (bearing%groove(k) <= bearing%r) call diagnostics%add( &
               instance%place(radius_key, 1), &
               "the groove of the " // rings(k) // " ring conforms to a ball", &
               radius_key // " > " // to_text(bearing%r) // " [m], the radius of a ball")
         else
            call diagnostics%add(instance%origin, "'" // ratio_key // &
               "' is missing in group &bearing '" // bearing%name // "'", ratio_key // &
               " = a number > 0.5 [-], or " // radius_key // " [m]")
         end if
      end do
   end subroutine read_grooves

   !> Axis and radial direction.
   subroutine read_axes(instance, bearing, diagnostics)
      !> Group `bearing`.
      type(group_settings_type), intent(in) :: instance
      !> The bearing; its attitude is set.
      type(bearing_type), intent(inout) :: bearing
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics
      real(wp) :: n(3)

      n = instance%numbers("axis")
      if (all(abs(n) <= 0.0_wp)) then
         call diagnostics%add(place_of(instance, "axis"), "'axis' is a zero vector", &
            "an axis of any length but zero")
         return
      end if
      n = unit_vector(n)
      if (n(3) > -0.5_wp) then
         ! Half way from the z axis.
         bearing%quaternion = unit_quaternion([1.0_wp + n(3), -n(2), n(1), 0.0_wp])
      else
         ! The same after half a turn about the x axis.
         bearing%quaternion = unit_quaternion([-n(2), 1.0_wp - n(3), 0.0_wp, n(1)])
      end if
      bearing%frame = rotation_matrix(bearing%quaternion)
      bearing%frame(:, 3) = n
      bearing%towards = bearing%frame(:, 1)
      if (.not. instance%is_set("radial_direction")) return
      bearing%towards = instance%numbers("radial_direction")
      if (all(abs(bearing%towards) <= 0.0_wp)) then
         call diagnostics%add(place_of(instance, "radial_direction"), &
            "'radial_direction' is a zero vector", "a direction of any length but zero")
         return
      end if
      bearing%towards = unit_vector(bearing%towards)
      if (abs(dot_product(bearing%towards, n)) > askew) call diagnostics%add( &
         place_of(instance, "radial_direction"), &
         "'radial_direction' is not perpendicular to the axis", "a direction across 'axis'")
   end subroutine read_axes

   !> Whether the parts find room.
   subroutine check_room(instance, bearing, diagnostics)
      !> Group `bearing`.
      type(group_settings_type), intent(in) :: instance
      type(bearing_type), intent(in) :: bearing
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics
      real(wp) :: wanted, ring(2), least(2)

      wanted = 2.0_wp*bearing%r + bearing%pocket
      ring = bearing%centre_circles()
      least = bearing%least_pitch()
      if (bearing%ball_distance() <= wanted) then
         call diagnostics%add(place_of(instance, "ball_count"), &
            "the balls do not find room on the pitch circle", "pitch_diameter > " // &
            to_text(wanted/sin(pi/bearing%balls)) // " [m]" // at_most(bearing%most_balls(wanted)))
      end if
      if (ring(1) <= bearing%groove(1)) call diagnostics%add(place_of(instance, &
         "pitch_diameter"), "there is no room for the inner ring", "pitch_diameter > " // &
         to_text(least(1)) // " [m]")
      if (ring(2) <= bearing%groove(2)) call diagnostics%add(place_of(instance, &
         "pitch_diameter"), "the groove of the outer ring reaches beyond the axis", &
         "pitch_diameter > " // to_text(least(2)) // " [m]")
      if (bearing%clearance >= bearing%largest_clearance()) call diagnostics%add( &
         place_of(instance, "clearance"), "with this clearance a ball can leave its groove", &
         "clearance < " // to_text(bearing%largest_clearance()) // &
         " [m], from the radii of the grooves")

   contains

      !> Number of balls that would find room.
      pure function at_most(most) result(text)
         !> The number.
         integer, intent(in) :: most
         character(len=:), allocatable :: text

         text = ""
         if (most >= 3) text = ", or at most " // to_text(most) // " balls"
      end function at_most

   end subroutine check_room

   !> Contact angle and approaches at the beginning: in equilibrium with the axial load, no overlap
   !> beyond that.
   subroutine set_initial_state(instance, materials, bearing, diagnostics)
      !> Group `bearing`.
      type(group_settings_type), intent(in) :: instance
      !> The materials of the scene.
      type(group_settings_type), intent(in) :: materials(:)
      !> The bearing; its state is set.
      type(bearing_type), intent(inout) :: bearing
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics
      type(normal_type) :: normal
      real(wp) :: largest_load, modulus, load
      logical :: reversed

      load = merge(bearing%preload, abs(bearing%axial), bearing%preload > 0.0_wp)
      if (load > 0.0_wp .or. bearing%clearance < 0.0_wp) then
         modulus = contact_modulus(instance, materials)
         ! A material that is missing is reported by who refers to it.
         if (modulus <= 0.0_wp) return
         normal = normal_of(instance, modulus, bearing%r)
      end if
      ! The load on the inner ring along its displacement, whichever ring is loaded.
      call bearing%find_equilibrium(normal, load, bearing%state, largest_load)
      if (largest_load >= 0.0_wp) call diagnostics%add(place_of(instance, &
         trim(merge("preload   ", "axial_load", bearing%preload > 0.0_wp))), &
         "the bearing does not carry this axial load", "at most " // to_text(largest_load) // &
         " [N]: the contact angle would go beyond " // to_text(largest_angle) // " rad")
      reversed = (bearing%axial < 0.0_wp) .neqv. (bearing%loaded == 2)
      if (bearing%preload > 0.0_wp) then
         reversed = bearing%angle < 0.0_wp
      else if (abs(bearing%angle) > 0.0_wp .and. .not. abs(bearing%axial) > 0.0_wp) then
         ! Just without play: an overlap beyond the rounding of places, so that not each of them
         ! makes a touch and a lift.
         bearing%state = bearing_state_type(angle=bearing%angle, approach=spread(touch*bearing%r, &
            1, 2), shift=bearing%gap()*tan(bearing%angle) + 2.0_wp*touch*bearing%r &
            /sin(bearing%angle))
         return
      end if
      if (reversed) then
         bearing%state%angle = -bearing%state%angle
         bearing%state%shift = -bearing%state%shift
      end if
   end subroutine set_initial_state

   !> Effective modulus of a ball on a ring [Pa]; 0 if a material is not there.
   function contact_modulus(instance, materials) result(modulus)
      !> Group `bearing`.
      type(group_settings_type), intent(in) :: instance
      !> The materials of the scene.
      type(group_settings_type), intent(in) :: materials(:)
      real(wp) :: modulus
      real(wp) :: young(2), poisson(2)
      character(len=:), allocatable :: wanted
      integer :: i, k

      young = 0.0_wp
      poisson = 0.0_wp
      modulus = 0.0_wp
      do k = 1, 2
         wanted = material_of(instance, trim(merge("material     ", "ball_material", k == 1)))
         wanted = lower(wanted)
         do i = 1, size(materials)
            associate (material => materials(i))
               if (lower(material%label()) /= wanted) cycle
               if (.not. material%is_set("young")) cycle
               if (.not. material%is_set("poisson")) cycle
               young(k) = material%number("young")
               poisson(k) = material%number("poisson")
            end associate
         end do
      end do
      if (all(young > 0.0_wp)) modulus = effective_modulus(young(1), poisson(1), young(2), &
         poisson(2))
   end function contact_modulus

   !> Normal part of a ball on a ring, for curvatures to follow.
   function normal_of(instance, modulus, radius) result(normal)
      !> Group `bearing`.
      type(group_settings_type), intent(in) :: instance
      !> Effective modulus [Pa].
      real(wp), intent(in) :: modulus
      !> Radius of the ball [m].
      real(wp), intent(in) :: radius
      type(normal_type) :: normal
      type(normal_model_type), allocatable :: models(:)
      type(parameters_type) :: parameters
      type(surroundings_type) :: around
      integer :: i

      models = normal_models()
      if (instance%choice("ellipse") > 0) then
         call parameters%set("ellipse", real(instance%choice("ellipse"), wp))
      end if
      around%modulus = modulus
      around%curvatures = 0.5_wp/radius
      around%with_shape = .false.
      i = max(instance%choice("normal"), 1)
      call models(i)%create(parameters, around, normal)
   end function normal_of

   !> The bodies, surfaces and contacts.
   subroutine make_parts(instance, schema, bearing, parts, n)
      !> Group `bearing`.
      type(group_settings_type), intent(in) :: instance
      type(schema_type), intent(in) :: schema
      type(bearing_type), intent(in) :: bearing
      type(group_type), intent(inout) :: parts(:)
      !> How many.
      integer, intent(out) :: n
      character(len=*), parameter :: rings(2) = ["inner", "outer"]
      character(len=:), allocatable :: ball, ball_matter
      real(wp) :: centre(2), ring(2), plane(2), e(3), around(3), u(3), place(3)
      real(wp) :: mass, turn, orbit, ball_spin, direction(3), load, offset(2), along
      character(len=:), allocatable :: arcs(:)
      integer :: i, k, a

      n = 0
      arcs = single
      if (bearing%lean > 0.0_wp) arcs = double
      offset = bearing%arc_offset()
      ring = bearing%centre_circles()
      centre = bearing%ball_centre(bearing%state%angle, bearing%state%approach)
      if (bearing%state%centred) then
         centre = [bearing%pitch, 0.0_wp]
      else if (bearing%lean > 0.0_wp) then
         ! The arc of the outer ring that holds it has its centre on the other side.
         centre(2) = centre(2) - sign(1.0_wp, bearing%state%angle)*offset(2)
      end if
      ! Planes of the grooves, along the axis from the centre: the loaded ring is the displaced one.
      plane = merge([bearing%state%shift, 0.0_wp], [0.0_wp, -bearing%state%shift], &
         bearing%loaded == 1)
      centre(2) = centre(2) + plane(2)
      call bearing%rolling_speeds(bearing%state, bearing%speed, orbit, ball_spin)

      do k = 1, 2
         place = bearing%centre + plane(k)*bearing%frame(:, 3)
         ! Loads on a ring that tilts act in the plane of the balls.
         if (tilts(k)) place = bearing%centre + centre(2)*bearing%frame(:, 3)
         if (.not. bearing%carried(k)) then
            call open_group("body", rings(k))
            call put_numbers("position", place, "centre")
            call put_ring_motion(k)
         end if
         do a = 1, size(arcs)
            call make_groove()
         end do
      end do

      mass = instance%number("ball_density")*4.0_wp/3.0_wp*pi*bearing%r**3
      ball_matter = trim(merge("ball_material", "material     ", &
         instance%is_given("ball_material")))
      do i = 1, bearing%balls
         ball = "ball_" // to_text(i)
         turn = 2.0_wp*pi*(i - 1)/bearing%balls
         e = cos(turn)*bearing%frame(:, 1) + sin(turn)*bearing%frame(:, 2)
         around = cos(turn)*bearing%frame(:, 2) - sin(turn)*bearing%frame(:, 1)
         place = bearing%centre + centre(1)*e + centre(2)*bearing%frame(:, 3)
         call open_group("body", ball)
         call put_numbers("mass", [mass], "ball_density")
         call put_numbers("inertia", spread(0.4_wp*mass*bearing%r**2, 1, 3), "ball_density")
         call put_numbers("position", place, "pitch_diameter")
         call put_numbers("held_along", around, "pitch_diameter")
         if (bearing%rolling) then
            ! From the outer to the inner contact.
            u = -cos(bearing%state%angle)*e - sin(bearing%state%angle)*bearing%frame(:, 3)
            direction = cross(u, around)
            call put_numbers("velocity", orbit*centre(1)*around, "initial_state")
            call put_numbers("angular_velocity", ball_spin*direction, "initial_state")
         end if
         call open_group("surface", ball)
         call put_name("body", ball, "name")
         call put_text("shape", "sphere", "name")
         call put_numbers("radius", [bearing%r], "ball_diameter")
         call put_text("material", material_of(instance, ball_matter), ball_matter)
      end do
      do k = 1, 2
         do a = 1, size(arcs)
            do i = 1, bearing%balls
               call open_group("contact", rings(k) // trim(arcs(a)) // "_" // to_text(i))
               call put_surfaces(rings(k) // trim(arcs(a)) // "_groove", "ball_" // to_text(i))
               call put_laws("")
            end do
         end do
      end do
      if (bearing%cage) call make_cage()

   contains

      !> The surface of arc a of ring k.
      subroutine make_groove()

         call open_group("surface", rings(k) // trim(arcs(a)) // "_groove")
         ! An arc that touches balls on its upper side has its centre below.
         along = 0.0_wp
         if (size(arcs) > 1) along = merge(-offset(k), offset(k), a == 1)
         if (bearing%carried(k)) then
            call put_text("body", instance%text(rings(k) // "_body"), rings(k) // "_body")
            place = bearing%centre + (plane(k) + along)*bearing%frame(:, 3)
            place = matmul(place - bearing%origin(:, k), bearing%attitude(:, :, k))
            call put_numbers("centre", place, "centre")
         else
            call put_name("body", rings(k), "name")
            if (tilts(k)) then
               along = plane(k) - centre(2) + along
               if (abs(along) > 0.0_wp) call put_numbers("centre", [0.0_wp, 0.0_wp, along], &
                  "centre")
            else if (abs(along) > 0.0_wp) then
               call put_numbers("centre", along*bearing%frame(:, 3), "contact_angle")
            end if
         end if
         call put_text("shape", "torus", "name")
         call put_text("side", "inside", "name")
         if (.not. tilts(k)) call put_numbers("direction", matmul(bearing%frame(:, 3), &
            bearing%attitude(:, :, k)), "axis")
         call put_numbers("major_radius", [ring(k)], "pitch_diameter")
         call put_numbers("minor_radius", [bearing%groove(k)], rings(k) // "_groove_" // &
            trim(merge("ratio ", "radius", &
            instance%is_given(rings(k) // "_groove_ratio"))))
         call put_text("material", material_of(instance, "material"), "material")
      end subroutine make_groove

      !> Begin a group.
      subroutine open_group(kind, name)
         !> What it describes.
         character(len=*), intent(in) :: kind
         !> Name of the part.
         character(len=*), intent(in) :: name

         n = n + 1
         parts(n)%name = kind
         parts(n)%origin = instance%origin
         allocate(parts(n)%assignments(24))
         call put_name("name", name, "name")
      end subroutine open_group

      !> Begin an assignment.
      subroutine next(key, origin_key, size_of_values)
         character(len=*), intent(in) :: key
         !> Key of the bearing that it comes from.
         character(len=*), intent(in) :: origin_key
         !> Number of values.
         integer, intent(in) :: size_of_values
         integer :: m

         m = parts(n)%n_assignments + 1
         parts(n)%n_assignments = m
         parts(n)%assignments(m)%key = key
         parts(n)%assignments(m)%origin = place_of(instance, origin_key)
         allocate(parts(n)%assignments(m)%values(size_of_values))
         parts(n)%assignments(m)%values(:)%origin = place_of(instance, origin_key)
      end subroutine next

      !> Give numbers.
      subroutine put_numbers(key, values, origin_key)
         character(len=*), intent(in) :: key
         real(wp), intent(in) :: values(:)
         !> Key of the bearing that they come from.
         character(len=*), intent(in) :: origin_key

         call next(key, origin_key, size(values))
         associate (assignment => parts(n)%assignments(parts(n)%n_assignments))
            assignment%values%kind = value_real
            ! No negative zeros.
            assignment%values%real = values + 0.0_wp
         end associate
      end subroutine put_numbers

      !> Give a text.
      subroutine put_text(key, text, origin_key)
         character(len=*), intent(in) :: key
         !> Its value.
         character(len=*), intent(in) :: text
         !> Key of the bearing that it comes from.
         character(len=*), intent(in) :: origin_key

         call next(key, origin_key, 1)
         associate (value => parts(n)%assignments(parts(n)%n_assignments)%values(1))
            value%kind = value_text
            value%text = text
         end associate
      end subroutine put_text

      !> Give the name of a part.
      subroutine put_name(key, name, origin_key)
         character(len=*), intent(in) :: key
         !> Name of the part.
         character(len=*), intent(in) :: name
         !> Key of the bearing that it comes from.
         character(len=*), intent(in) :: origin_key

         call put_text(key, bearing%name // "_" // name, origin_key)
      end subroutine put_name

      !> Give the two surfaces of a contact.
      subroutine put_surfaces(first, second)
         !> Names of the surfaces A and B.
         character(len=*), intent(in) :: first, second

         call next("surfaces", "name", 2)
         associate (values => parts(n)%assignments(parts(n)%n_assignments)%values)
            values%kind = value_text
            values(1)%text = bearing%name // "_" // first
            values(2)%text = bearing%name // "_" // second
         end associate
      end subroutine put_surfaces

      !> How a ring moves, and its loads.
      subroutine put_ring_motion(k)
         !> 1 for the inner, 2 for the outer ring.
         integer, intent(in) :: k
         character(len=:), allocatable :: speed_key

         speed_key = rings(k) // "_speed"
         if (bearing%free .and. bearing%loaded == k) then
            call put_text("motion", trim(ring_motions(bearing%motion)), trim(merge("ring_motion", &
               "ring_mass  ", bearing%motion /= ring_spindle)))
            call put_numbers("mass", [instance%number("ring_mass")], "ring_mass")
            if (tilts(k)) then
               call put_numbers("inertia", bearing%inertia([1, 1, 2]), "ring_inertia")
               if (bearing%quaternion(1) < 1.0_wp) call put_numbers("quaternion", &
                  bearing%quaternion, "axis")
               if (any(abs(bearing%moment) > 0.0_wp)) call put_numbers("applied_torque", &
                  bearing%moment, "moment_load")
            end if
            load = norm2([bearing%axial, bearing%radial])
            if (load > 0.0_wp) call put_numbers("applied_force", &
               bearing%axial*bearing%frame(:, 3) + bearing%radial*bearing%towards, &
               trim(merge("axial_load ", "radial_load", abs(bearing%axial) > 0.0_wp)))
         else
            call put_text("motion", "prescribed", "name")
         end if
         if (abs(bearing%speed(k)) <= 0.0_wp) return
         if (instance%is_given("ramp_duration") .and. .not. turns_freely(k)) then
            call put_numbers("final_angular_velocity", bearing%speed(k)*bearing%frame(:, 3), &
               speed_key)
            call put_numbers("ramp_duration", [instance%number("ramp_duration")], "ramp_duration")
         else
            call put_numbers("angular_velocity", bearing%speed(k)*bearing%frame(:, 3), speed_key)
         end if
      end subroutine put_ring_motion

      !> Whether a ring tilts: then its third axis is that of the bearing.
      pure logical function tilts(k)
         !> 1 for the inner, 2 for the outer ring.
         integer, intent(in) :: k

         tilts = bearing%free .and. bearing%loaded == k .and. bearing%motion /= ring_spindle
      end function tilts

      !> Whether nothing prescribes the rotation of a ring.
      pure logical function turns_freely(k)
         !> 1 for the inner, 2 for the outer ring.
         integer, intent(in) :: k

         turns_freely = tilts(k) .and. bearing%motion == ring_free
      end function turns_freely

      !> The cage: a thin ring through the centres of the balls.
      subroutine make_cage()
         real(wp) :: mass_of_cage
         integer :: j

         mass_of_cage = instance%number("cage_mass")
         call open_group("body", "cage")
         call put_numbers("mass", [mass_of_cage], "cage_mass")
         call put_numbers("inertia", mass_of_cage*centre(1)**2*[0.5_wp, 0.5_wp, 1.0_wp], &
            "cage_mass")
         call put_numbers("position", bearing%centre + centre(2)*bearing%frame(:, 3), "centre")
         if (bearing%quaternion(1) < 1.0_wp) call put_numbers("quaternion", bearing%quaternion, &
            "axis")
         if (bearing%rolling) call put_numbers("angular_velocity", orbit*bearing%frame(:, 3), &
            "initial_state")
         do j = 1, bearing%balls
            turn = 2.0_wp*pi*(j - 1)/bearing%balls
            call open_group("surface", "pocket_" // to_text(j))
            call put_name("body", "cage", "name")
            call put_text("shape", "cylinder", "name")
            call put_text("side", "inside", "name")
            call put_numbers("direction", [cos(turn), sin(turn), 0.0_wp], "cage")
            call put_numbers("radius", [bearing%r + 0.5_wp*bearing%pocket], "pocket_clearance")
            call put_text("material", material_of(instance, "cage_material"), "cage_material")
         end do
         do j = 1, bearing%balls
            call open_group("contact", "pocket_" // to_text(j))
            call put_surfaces("pocket_" // to_text(j), "ball_" // to_text(j))
            call put_laws("cage_friction_coefficient")
         end do
      end subroutine make_cage

      !> The laws of a contact, as the bearing gives them.
      subroutine put_laws(friction_key)
         !> Key that takes the place of friction_coefficient if it is given; blank for none.
         character(len=*), intent(in) :: friction_key
         integer :: m

         associate (keys => schema%groups(schema%find("contact"))%keys)
            do m = 1, size(keys)
               if (any(keys(m)%name == [character(len=28) :: "name", "surfaces"])) cycle
               if (instance%is_given(keys(m)%name)) call copy(trim(keys(m)%name))
            end do
         end associate
         if (friction_key == "") return
         if (.not. instance%is_given(friction_key)) return
         do m = 1, parts(n)%n_assignments
            if (parts(n)%assignments(m)%key /= "friction_coefficient") cycle
            parts(n)%assignments(m)%values(1)%real = instance%number(friction_key)
            return
         end do
         call put_numbers("friction_coefficient", [instance%number(friction_key)], friction_key)
      end subroutine put_laws

      !> Take a key as the bearing gives it.
      subroutine copy(key)
         character(len=*), intent(in) :: key
         integer :: v

         call next(key, key, instance%count(key))
         associate (assignment => parts(n)%assignments(parts(n)%n_assignments))
            do v = 1, size(assignment%values)
               assignment%values(v) = instance%value(key, v)
            end do
            assignment%values%origin = place_of(instance, key)
            assignment%origin = instance%place(key)
         end associate
      end subroutine copy

   end subroutine make_parts

   !> Material of a part: its own, or that of the rings.
   function material_of(instance, key) result(name)
      !> Group `bearing`.
      type(group_settings_type), intent(in) :: instance
      !> Key of the material.
      character(len=*), intent(in) :: key
      character(len=:), allocatable :: name

      name = instance%text("material")
      if (instance%is_set(key)) name = instance%text(key)
   end function material_of

   !> Where a key of a bearing has its value, or where the group begins.
   function place_of(instance, key) result(place)
      !> Group `bearing`.
      type(group_settings_type), intent(in) :: instance
      character(len=*), intent(in) :: key
      type(origin_type) :: place

      place = instance%place(key, 1)
   end function place_of

end module contensou_scene_bearing
