!> Reads a scene with the intrinsic namelist input, and prints each key of each group with its
!> values, or "-" where the scene gives none: an independent reading of the same text.
!>
!>    read_namelist FILE
!>
!> Lines: `GROUP INDEX KEY -`, or `GROUP INDEX KEY VALUE...` with texts in quotes.
program read_namelist
   use, intrinsic :: iso_fortran_env, only : iostat_end
   implicit none(type, external)

   !> Precision of the numbers.
   integer, parameter :: wp = kind(1.0d0)

   !> What a key holds before it is read.
   real(wp), parameter :: no_number = -huge(1.0_wp)
   character(len=*), parameter :: no_text = "?"

   character(len=1024) :: path
   integer :: unit, status, length

   call get_command_argument(1, path, length, status)
   if (status /= 0 .or. length == 0) then
      print "(a)", "usage: read_namelist FILE"
      stop 2, quiet=.true.
   end if
   open(newunit=unit, file=trim(path), status="old", action="read")
   call read_scene()
   call read_material()
   call read_body()
   call read_surface()
   call read_contact()
   call read_integrator()
   call read_output()
   call read_bearing()
   call read_stop()
   call read_spring()
   close(unit)

contains

   !> Every group `scene`.
   subroutine read_scene()
      character(len=256) :: title, impacts
      real(wp) :: gravity(3), t_end
      integer :: n
      namelist /scene/ title, gravity, t_end, impacts

      rewind(unit)
      n = 0
      do
         title = no_text
         gravity = no_number
         t_end = no_number
         impacts = no_text
         read(unit, nml=scene, iostat=status)
         if (status == iostat_end) exit
         call count_group("scene", status, n)
         call put_texts("scene", n, "title", [title])
         call put_numbers("scene", n, "gravity", gravity)
         call put_numbers("scene", n, "t_end", [t_end])
         call put_texts("scene", n, "impacts", [impacts])
      end do
   end subroutine read_scene

   !> Every group `material`.
   subroutine read_material()
      character(len=256) :: name
      real(wp) :: young, poisson
      integer :: n
      namelist /material/ name, young, poisson

      rewind(unit)
      n = 0
      do
         name = no_text
         young = no_number
         poisson = no_number
         read(unit, nml=material, iostat=status)
         if (status == iostat_end) exit
         call count_group("material", status, n)
         call put_texts("material", n, "name", [name])
         call put_numbers("material", n, "young", [young])
         call put_numbers("material", n, "poisson", [poisson])
      end do
   end subroutine read_material

   !> Every group `body`.
   subroutine read_body()
      character(len=256) :: name
      real(wp) :: mass, inertia(3), radius_of_gyration(3), density, solid_length
      character(len=256) :: solid, solid_part, arrangement, place
      real(wp) :: count(3), spacing(3), ring_radius
      real(wp) :: position(3), axis(3), angle, quaternion(4), velocity(3), &
         spin(3), angular_velocity(3)
      character(len=256) :: motion, applied_frame
      real(wp) :: final_velocity(3), final_angular_velocity(3), ramp_duration, applied_force(3), &
         applied_torque(3), held_along(3)
      integer :: n
      namelist /body/ radius_of_gyration, density, solid, solid_length, solid_part, &
         count, spacing, ring_radius, arrangement, place
      namelist /body/ name, motion, mass, inertia, position, axis, angle, quaternion, velocity, &
         spin, angular_velocity, final_velocity, final_angular_velocity, ramp_duration, &
         applied_force, applied_torque, applied_frame, held_along

      rewind(unit)
      n = 0
      do
         name = no_text
         mass = no_number
         inertia = no_number
         radius_of_gyration = no_number
         density = no_number
         solid = no_text
         solid_length = no_number
         solid_part = no_text
         count = no_number
         spacing = no_number
         ring_radius = no_number
         arrangement = no_text
         place = no_text
         position = no_number
         axis = no_number
         angle = no_number
         quaternion = no_number
         velocity = no_number
         spin = no_number
         angular_velocity = no_number
         motion = no_text
         applied_frame = no_text
         held_along = no_number
         final_velocity = no_number
         final_angular_velocity = no_number
         ramp_duration = no_number
         applied_force = no_number
         applied_torque = no_number
         read(unit, nml=body, iostat=status)
         if (status == iostat_end) exit
         call count_group("body", status, n)
         call put_texts("body", n, "name", [name])
         call put_numbers("body", n, "mass", [mass])
         call put_numbers("body", n, "inertia", inertia)
         call put_numbers("body", n, "radius_of_gyration", radius_of_gyration)
         call put_numbers("body", n, "density", [density])
         call put_texts("body", n, "solid", [solid])
         call put_numbers("body", n, "solid_length", [solid_length])
         call put_texts("body", n, "solid_part", [solid_part])
         call put_texts("body", n, "place", [place])
         call put_numbers("body", n, "count", count)
         call put_numbers("body", n, "spacing", spacing)
         call put_numbers("body", n, "ring_radius", [ring_radius])
         call put_texts("body", n, "arrangement", [arrangement])
         call put_numbers("body", n, "position", position)
         call put_numbers("body", n, "axis", axis)
         call put_numbers("body", n, "angle", [angle])
         call put_numbers("body", n, "quaternion", quaternion)
         call put_numbers("body", n, "velocity", velocity)
         call put_numbers("body", n, "spin", spin)
         call put_numbers("body", n, "angular_velocity", angular_velocity)
         call put_texts("body", n, "motion", [motion])
         call put_texts("body", n, "applied_frame", [applied_frame])
         call put_numbers("body", n, "held_along", held_along)
         call put_numbers("body", n, "final_velocity", final_velocity)
         call put_numbers("body", n, "final_angular_velocity", final_angular_velocity)
         call put_numbers("body", n, "ramp_duration", [ramp_duration])
         call put_numbers("body", n, "applied_force", applied_force)
         call put_numbers("body", n, "applied_torque", applied_torque)
      end do
   end subroutine read_body

   !> Every group `surface`.
   subroutine read_surface()
      character(len=256) :: name, body, shape, side, material
      real(wp) :: centre(3), radius, normal(3), direction(3), semi_axes(3), axis(3), angle, &
         quaternion(4), major_radius, minor_radius, vertex_radius, half_angle
      integer :: n
      namelist /surface/ name, body, shape, centre, radius, normal, direction, semi_axes, axis, &
         angle, quaternion, major_radius, minor_radius, vertex_radius, half_angle, side, material

      rewind(unit)
      n = 0
      do
         name = no_text
         body = no_text
         shape = no_text
         side = no_text
         material = no_text
         centre = no_number
         radius = no_number
         normal = no_number
         direction = no_number
         semi_axes = no_number
         axis = no_number
         angle = no_number
         quaternion = no_number
         major_radius = no_number
         minor_radius = no_number
         vertex_radius = no_number
         half_angle = no_number
         read(unit, nml=surface, iostat=status)
         if (status == iostat_end) exit
         call count_group("surface", status, n)
         call put_texts("surface", n, "name", [name])
         call put_texts("surface", n, "body", [body])
         call put_texts("surface", n, "shape", [shape])
         call put_numbers("surface", n, "centre", centre)
         call put_numbers("surface", n, "radius", [radius])
         call put_numbers("surface", n, "normal", normal)
         call put_numbers("surface", n, "direction", direction)
         call put_numbers("surface", n, "semi_axes", semi_axes)
         call put_numbers("surface", n, "axis", axis)
         call put_numbers("surface", n, "angle", [angle])
         call put_numbers("surface", n, "quaternion", quaternion)
         call put_numbers("surface", n, "major_radius", [major_radius])
         call put_numbers("surface", n, "minor_radius", [minor_radius])
         call put_numbers("surface", n, "vertex_radius", [vertex_radius])
         call put_numbers("surface", n, "half_angle", [half_angle])
         call put_texts("surface", n, "side", [side])
         call put_texts("surface", n, "material", [material])
      end do
   end subroutine read_surface

   !> Every group `contact`.
   subroutine read_contact()
      character(len=256) :: name, surfaces(2), normal, ellipse, damping, friction, rolling, &
         tangential, creep, spot
      real(wp) :: rolling_coefficient, rolling_regularization, layers, spot_error
      real(wp) :: damping_coefficient, restitution, impact_velocity, friction_coefficient, &
         regularization_velocity
      logical :: drilling
      integer :: n
      namelist /contact/ name, surfaces, normal, ellipse, damping, damping_coefficient, &
         restitution, impact_velocity, friction, friction_coefficient, &
         regularization_velocity, drilling, rolling, rolling_coefficient, rolling_regularization, &
         tangential, layers, creep, spot, spot_error

      rewind(unit)
      n = 0
      do
         name = no_text
         surfaces = no_text
         normal = no_text
         damping = no_text
         friction = no_text
         damping_coefficient = no_number
         restitution = no_number
         impact_velocity = no_number
         friction_coefficient = no_number
         regularization_velocity = no_number
         ellipse = no_text
         rolling = no_text
         tangential = no_text
         creep = no_text
         spot = no_text
         spot_error = no_number
         layers = no_number
         rolling_coefficient = no_number
         rolling_regularization = no_number
         ! A logical has no third value: the default.
         drilling = .true.
         read(unit, nml=contact, iostat=status)
         if (status == iostat_end) exit
         call count_group("contact", status, n)
         call put_texts("contact", n, "name", [name])
         call put_texts("contact", n, "surfaces", surfaces)
         call put_texts("contact", n, "normal", [normal])
         call put_texts("contact", n, "damping", [damping])
         call put_numbers("contact", n, "damping_coefficient", [damping_coefficient])
         call put_numbers("contact", n, "restitution", [restitution])
         call put_numbers("contact", n, "impact_velocity", [impact_velocity])
         call put_texts("contact", n, "friction", [friction])
         call put_numbers("contact", n, "friction_coefficient", [friction_coefficient])
         call put_numbers("contact", n, "regularization_velocity", [regularization_velocity])
         call put_texts("contact", n, "ellipse", [ellipse])
         call put_texts("contact", n, "rolling", [rolling])
         call put_texts("contact", n, "tangential", [tangential])
         call put_texts("contact", n, "creep", [creep])
         call put_texts("contact", n, "spot", [spot])
         call put_numbers("contact", n, "spot_error", [spot_error])
         call put_numbers("contact", n, "layers", [layers])
         call put_numbers("contact", n, "rolling_coefficient", [rolling_coefficient])
         call put_numbers("contact", n, "rolling_regularization", [rolling_regularization])
         print "(a, i0, a)", "contact ", n, " drilling " // merge(".true. ", ".false.", drilling)
      end do
   end subroutine read_contact

   !> Every group `integrator`.
   subroutine read_integrator()
      character(len=256) :: method, jacobian
      real(wp) :: rtol, length_scale, velocity_scale, angular_velocity_scale, max_step, &
         jacobian_steps
      integer :: n
      namelist /integrator/ method, jacobian, rtol, length_scale, velocity_scale, &
         angular_velocity_scale, max_step, jacobian_steps

      rewind(unit)
      n = 0
      do
         method = no_text
         jacobian = no_text
         rtol = no_number
         length_scale = no_number
         velocity_scale = no_number
         angular_velocity_scale = no_number
         max_step = no_number
         jacobian_steps = no_number
         read(unit, nml=integrator, iostat=status)
         if (status == iostat_end) exit
         call count_group("integrator", status, n)
         call put_texts("integrator", n, "method", [method])
         call put_texts("integrator", n, "jacobian", [jacobian])
         call put_numbers("integrator", n, "rtol", [rtol])
         call put_numbers("integrator", n, "length_scale", [length_scale])
         call put_numbers("integrator", n, "velocity_scale", [velocity_scale])
         call put_numbers("integrator", n, "angular_velocity_scale", [angular_velocity_scale])
         call put_numbers("integrator", n, "max_step", [max_step])
         call put_numbers("integrator", n, "jacobian_steps", [jacobian_steps])
      end do
   end subroutine read_integrator

   !> Every group `output`.
   subroutine read_output()
      character(len=256) :: file
      real(wp) :: interval
      logical :: contact_geometry, rolling
      integer :: n
      namelist /output/ file, interval, contact_geometry, rolling

      rewind(unit)
      n = 0
      do
         file = no_text
         interval = no_number
         contact_geometry = .true.
         rolling = .false.
         read(unit, nml=output, iostat=status)
         if (status == iostat_end) exit
         call count_group("output", status, n)
         call put_texts("output", n, "file", [file])
         call put_numbers("output", n, "interval", [interval])
         if (.not. contact_geometry) print "(a, i0, a)", "output ", n, &
            " contact_geometry .false."
         if (rolling) print "(a, i0, a)", "output ", n, " rolling .true."
      end do
   end subroutine read_output

   !> Every group `bearing`.
   subroutine read_bearing()
      character(len=256) :: ring_motion, inner_body, outer_body
      real(wp) :: ring_inertia(2), moment_load(3), contact_angle, preload
      character(len=256) :: name, material, ball_material, initial_state, loaded_ring, &
         cage_material, normal, ellipse, damping, friction, rolling, tangential, &
         creep, spot
      real(wp) :: ball_count, ball_diameter, pitch_diameter, inner_groove_ratio, &
         inner_groove_radius, outer_groove_ratio, outer_groove_radius, clearance, &
         ball_density, inner_speed, outer_speed, ramp_duration, ring_mass, axial_load, &
         radial_load, cage_mass, pocket_clearance, cage_friction_coefficient, &
         damping_coefficient, restitution, impact_velocity, friction_coefficient, &
         regularization_velocity, rolling_coefficient, rolling_regularization, centre(3), &
         axis(3), radial_direction(3), layers, spot_error
      logical :: cage, drilling, four_point
      integer :: n
      namelist /bearing/ ring_motion, inner_body, outer_body, ring_inertia, moment_load, &
         contact_angle, four_point, preload
      namelist /bearing/ name, ball_count, ball_diameter, pitch_diameter, &
         inner_groove_ratio, inner_groove_radius, outer_groove_ratio, outer_groove_radius, &
         clearance, centre, axis, material, ball_material, ball_density, inner_speed, &
         outer_speed, initial_state, ramp_duration, loaded_ring, ring_mass, axial_load, &
         radial_load, radial_direction, cage, cage_mass, cage_material, pocket_clearance, &
         cage_friction_coefficient, normal, ellipse, damping, damping_coefficient, &
         restitution, impact_velocity, friction, friction_coefficient, &
         regularization_velocity, drilling, rolling, rolling_coefficient, &
         rolling_regularization, tangential, layers, creep, spot, spot_error

      rewind(unit)
      n = 0
      do
         name = no_text
         ball_count = no_number
         ball_diameter = no_number
         pitch_diameter = no_number
         inner_groove_ratio = no_number
         inner_groove_radius = no_number
         outer_groove_ratio = no_number
         outer_groove_radius = no_number
         clearance = no_number
         centre = no_number
         axis = no_number
         material = no_text
         ball_material = no_text
         ball_density = no_number
         inner_speed = no_number
         outer_speed = no_number
         initial_state = no_text
         ramp_duration = no_number
         loaded_ring = no_text
         ring_mass = no_number
         ring_motion = no_text
         inner_body = no_text
         outer_body = no_text
         ring_inertia = no_number
         moment_load = no_number
         contact_angle = no_number
         preload = no_number
         axial_load = no_number
         radial_load = no_number
         radial_direction = no_number
         cage = .false.
         four_point = .false.
         cage_mass = no_number
         cage_material = no_text
         pocket_clearance = no_number
         cage_friction_coefficient = no_number
         normal = no_text
         ellipse = no_text
         damping = no_text
         damping_coefficient = no_number
         restitution = no_number
         impact_velocity = no_number
         friction = no_text
         friction_coefficient = no_number
         regularization_velocity = no_number
         drilling = .true.
         rolling = no_text
         tangential = no_text
         creep = no_text
         spot = no_text
         spot_error = no_number
         layers = no_number
         rolling_coefficient = no_number
         rolling_regularization = no_number
         read(unit, nml=bearing, iostat=status)
         if (status == iostat_end) exit
         call count_group("bearing", status, n)
         call put_texts("bearing", n, "name", [name])
         call put_numbers("bearing", n, "ball_count", [ball_count])
         call put_numbers("bearing", n, "ball_diameter", [ball_diameter])
         call put_numbers("bearing", n, "pitch_diameter", [pitch_diameter])
         call put_numbers("bearing", n, "inner_groove_ratio", [inner_groove_ratio])
         call put_numbers("bearing", n, "inner_groove_radius", [inner_groove_radius])
         call put_numbers("bearing", n, "outer_groove_ratio", [outer_groove_ratio])
         call put_numbers("bearing", n, "outer_groove_radius", [outer_groove_radius])
         call put_numbers("bearing", n, "clearance", [clearance])
         call put_numbers("bearing", n, "centre", centre)
         call put_numbers("bearing", n, "axis", axis)
         call put_texts("bearing", n, "material", [material])
         call put_texts("bearing", n, "ball_material", [ball_material])
         call put_numbers("bearing", n, "ball_density", [ball_density])
         call put_numbers("bearing", n, "inner_speed", [inner_speed])
         call put_numbers("bearing", n, "outer_speed", [outer_speed])
         call put_texts("bearing", n, "initial_state", [initial_state])
         call put_numbers("bearing", n, "ramp_duration", [ramp_duration])
         call put_texts("bearing", n, "loaded_ring", [loaded_ring])
         call put_numbers("bearing", n, "ring_mass", [ring_mass])
         call put_texts("bearing", n, "ring_motion", [ring_motion])
         call put_numbers("bearing", n, "ring_inertia", ring_inertia)
         call put_numbers("bearing", n, "moment_load", moment_load)
         call put_texts("bearing", n, "inner_body", [inner_body])
         call put_texts("bearing", n, "outer_body", [outer_body])
         call put_numbers("bearing", n, "contact_angle", [contact_angle])
         call put_numbers("bearing", n, "preload", [preload])
         call put_numbers("bearing", n, "axial_load", [axial_load])
         call put_numbers("bearing", n, "radial_load", [radial_load])
         call put_numbers("bearing", n, "radial_direction", radial_direction)
         print "(a, i0, a)", "bearing ", n, " cage " // merge(".true. ", ".false.", cage)
         print "(a, i0, a)", "bearing ", n, &
            " four_point " // merge(".true. ", ".false.", four_point)
         call put_numbers("bearing", n, "cage_mass", [cage_mass])
         call put_texts("bearing", n, "cage_material", [cage_material])
         call put_numbers("bearing", n, "pocket_clearance", [pocket_clearance])
         call put_numbers("bearing", n, "cage_friction_coefficient", [cage_friction_coefficient])
         call put_texts("bearing", n, "normal", [normal])
         call put_texts("bearing", n, "ellipse", [ellipse])
         call put_texts("bearing", n, "damping", [damping])
         call put_numbers("bearing", n, "damping_coefficient", [damping_coefficient])
         call put_numbers("bearing", n, "restitution", [restitution])
         call put_numbers("bearing", n, "impact_velocity", [impact_velocity])
         call put_texts("bearing", n, "friction", [friction])
         call put_numbers("bearing", n, "friction_coefficient", [friction_coefficient])
         call put_numbers("bearing", n, "regularization_velocity", [regularization_velocity])
         print "(a, i0, a)", "bearing ", n, " drilling " // merge(".true. ", ".false.", drilling)
         call put_texts("bearing", n, "rolling", [rolling])
         call put_texts("bearing", n, "tangential", [tangential])
         call put_texts("bearing", n, "creep", [creep])
         call put_texts("bearing", n, "spot", [spot])
         call put_numbers("bearing", n, "spot_error", [spot_error])
         call put_numbers("bearing", n, "layers", [layers])
         call put_numbers("bearing", n, "rolling_coefficient", [rolling_coefficient])
         call put_numbers("bearing", n, "rolling_regularization", [rolling_regularization])
      end do
   end subroutine read_bearing

   !> Every group `stop`.
   subroutine read_stop()
      character(len=256) :: name, when, body, contact, crossing
      real(wp) :: kinetic_energy, duration, angle, axis(3), speed, angular_velocity, position, &
         direction(3)
      integer :: n
      namelist /stop/ name, when, body, contact, kinetic_energy, duration, angle, axis, speed, &
         angular_velocity, position, direction, crossing

      rewind(unit)
      n = 0
      do
         name = no_text
         when = no_text
         body = no_text
         contact = no_text
         kinetic_energy = no_number
         duration = no_number
         angle = no_number
         axis = no_number
         speed = no_number
         angular_velocity = no_number
         position = no_number
         direction = no_number
         crossing = no_text
         read(unit, nml=stop, iostat=status)
         if (status == iostat_end) exit
         call count_group("stop", status, n)
         call put_texts("stop", n, "name", [name])
         call put_texts("stop", n, "when", [when])
         call put_texts("stop", n, "body", [body])
         call put_texts("stop", n, "contact", [contact])
         call put_numbers("stop", n, "kinetic_energy", [kinetic_energy])
         call put_numbers("stop", n, "duration", [duration])
         call put_numbers("stop", n, "angle", [angle])
         call put_numbers("stop", n, "axis", axis)
         call put_numbers("stop", n, "speed", [speed])
         call put_numbers("stop", n, "angular_velocity", [angular_velocity])
         call put_numbers("stop", n, "position", [position])
         call put_numbers("stop", n, "direction", direction)
         call put_texts("stop", n, "crossing", [crossing])
      end do
   end subroutine read_stop

   !> Every group `spring`.
   subroutine read_spring()
      character(len=256) :: name, bodies(2), kind
      real(wp), dimension(3) :: first_point, second_point, axis, stiffness, damping, &
         rotational_stiffness, rotational_damping, preload
      real(wp) :: angle, quaternion(4), length, relaxed_quaternion(4)
      integer :: n
      namelist /spring/ name, bodies, kind, first_point, second_point, axis, angle, quaternion, &
         stiffness, damping, rotational_stiffness, rotational_damping, preload, length, &
         relaxed_quaternion

      rewind(unit)
      n = 0
      do
         name = no_text
         bodies = no_text
         kind = no_text
         first_point = no_number
         second_point = no_number
         axis = no_number
         angle = no_number
         quaternion = no_number
         stiffness = no_number
         damping = no_number
         rotational_stiffness = no_number
         rotational_damping = no_number
         preload = no_number
         length = no_number
         relaxed_quaternion = no_number
         read(unit, nml=spring, iostat=status)
         if (status == iostat_end) exit
         call count_group("spring", status, n)
         call put_texts("spring", n, "name", [name])
         call put_texts("spring", n, "bodies", bodies)
         call put_texts("spring", n, "kind", [kind])
         call put_numbers("spring", n, "first_point", first_point)
         call put_numbers("spring", n, "second_point", second_point)
         call put_numbers("spring", n, "axis", axis)
         call put_numbers("spring", n, "angle", [angle])
         call put_numbers("spring", n, "quaternion", quaternion)
         call put_numbers("spring", n, "stiffness", stiffness)
         call put_numbers("spring", n, "damping", damping)
         call put_numbers("spring", n, "rotational_stiffness", rotational_stiffness)
         call put_numbers("spring", n, "rotational_damping", rotational_damping)
         call put_numbers("spring", n, "preload", preload)
         call put_numbers("spring", n, "length", [length])
         call put_numbers("spring", n, "relaxed_quaternion", relaxed_quaternion)
      end do
   end subroutine read_spring

   !> Count a group that was read; a mistake in it stops.
   subroutine count_group(group, state, n)
      !> Name of the group.
      character(len=*), intent(in) :: group
      !> What reading it returned.
      integer, intent(in) :: state
      !> Number of groups of this name so far.
      integer, intent(inout) :: n

      n = n + 1
      if (state == 0) return
      print "(a, i0, a)", "group " // group // " ", n, " cannot be read"
      stop 1, quiet=.true.
   end subroutine count_group

   !> Print the numbers of a key.
   subroutine put_numbers(group, n, key, values)
      !> Name of the group.
      character(len=*), intent(in) :: group
      !> Which of that name.
      integer, intent(in) :: n
      !> Name of the key.
      character(len=*), intent(in) :: key
      real(wp), intent(in) :: values(:)

      if (all(values <= no_number)) then
         print "(a, i0, a)", group // " ", n, " " // key // " -"
      else
         print "(a, i0, a, *(1x, es24.16e3))", group // " ", n, " " // key, values
      end if
   end subroutine put_numbers

   !> Print the texts of a key.
   subroutine put_texts(group, n, key, values)
      !> Name of the group.
      character(len=*), intent(in) :: group
      !> Which of that name.
      integer, intent(in) :: n
      !> Name of the key.
      character(len=*), intent(in) :: key
      character(len=*), intent(in) :: values(:)
      integer :: i

      if (all(values == no_text)) then
         print "(a, i0, a)", group // " ", n, " " // key // " -"
      else
         print "(a, i0, a, *(a))", group // " ", n, " " // key, &
            (" '" // trim(values(i)) // "'", i=1, size(values))
      end if
   end subroutine put_texts

end program read_namelist
