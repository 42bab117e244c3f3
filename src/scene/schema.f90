!> The groups and keys of a scene: one table, from which the reader checks, `contensou help`
!> documents, and the resolved scene in an output file is written.
module contensou_scene_schema
   use contensou_base_document, only : constants_group
   use contensou_base_kinds, only : wp
   use contensou_base_schema, only : group_spec_type, key_list_type, key_type, kind_choice, &
      kind_file, kind_integer, kind_logical, kind_name, kind_real, kind_reference, kind_text, &
      most_values, new_schema, schema_type
   use contensou_base_text, only : string_type, strings
   use contensou_contact_parts, only : put_part_keys
   use contensou_contact_shapes_table, only : put_shape_keys, shape_names
   use contensou_dynamics_scene, only : frame_names, impact_names, motion_names, solid_parts
   use contensou_integrate_methods, only : integrator_methods, jacobian_kinds
   use contensou_scene_cost, only : put_cost_keys
   use contensou_scene_placing, only : place_names
   use contensou_scene_repeats, only : arrangement_names
   use contensou_scene_springs, only : put_spring_keys
   use contensou_scene_stops, only : put_stop_keys
   implicit none(type, external)
   private

   public :: scene_schema, schema_groups, schema_keys, constants_group_spec, put_constant_keys
   public :: ring_motions

   !> How a bearing can begin.
   character(len=*), parameter :: start_names(*) = [character(len=7) :: "rest", "rolling"]

   !> The rings of a bearing.
   character(len=*), parameter :: ring_names(*) = [character(len=5) :: "inner", "outer"]

   !> How its loaded ring can move.
   character(len=*), parameter :: ring_motions(*) = [character(len=7) :: "spindle", "rotor", "free"]

contains

   !> The groups of a scene with their keys.
   subroutine scene_schema(schema)
      type(schema_type), intent(out) :: schema

      call new_schema(schema_groups(), schema_keys(), schema)
   end subroutine scene_schema

   !> The groups of a scene, in the order of the documentation.
   pure function schema_groups() result(groups)
      type(group_spec_type), allocatable :: groups(:)

      allocate(groups(14))
      groups(1) = group_spec_type("scene", .false., .true., "what the whole scene shares")
      groups(2) = group_spec_type("material", .true., .false., "an isotropic elastic material")
      groups(3) = group_spec_type("body", .true., .true., &
         "a rigid body and its initial state; the body 'ground' is predeclared and at rest")
      groups(4) = group_spec_type("surface", .true., .false., &
         "a surface fixed to a body, given in the frame of that body")
      groups(5) = group_spec_type("contact", .true., .false., &
         "two surfaces that can touch, and the models that act between them")
      groups(14) = group_spec_type("spring", .true., .false., &
         "a linear spring with damping between two bodies: a bushing, or between two points")
      groups(6) = group_spec_type("integrator", .false., .false., "how time is integrated")
      groups(7) = group_spec_type("output", .false., .false., "what is written")
      groups(8) = group_spec_type("bearing", .true., .false., &
         "a ball bearing, which stands for its bodies, surfaces and contacts: NAME_inner, " // &
         "NAME_outer, NAME_ball_1, ..., see check --expand")
      groups(9) = constants_group_spec()
      groups(10) = group_spec_type("defaults", .false., .false., "values of keys for all " // &
         "surfaces and contacts that have a use for them and do not give them", hidden=.true.)
      groups(11) = group_spec_type("contacts", .true., .false., &
         "one group for the contacts of all pairs of two patterns or lists of surfaces, each " // &
         "called A_B after its surfaces")
      groups(12) = group_spec_type("stop", .true., .false., &
         "a condition that ends a run before scene.t_end, with exit status 0")
      groups(13) = group_spec_type("cost", .false., .false., &
         "what contensou cost runs and compares; other commands only check it", hidden=.true.)
   end function schema_groups

   !> The group of constants, which has the keys that a file gives it.
   pure function constants_group_spec() result(spec)
      type(group_spec_type) :: spec

      spec = group_spec_type(constants_group, .false., .false., "names for numbers, to be " // &
         "used in all values: r = 0.01, m = 4/3*pi*r**3*7850, then mass = 2*m", hidden=.true.)
   end function constants_group_spec

   !> The keys of all groups, in the order of the documentation.
   function schema_keys() result(keys)
      type(key_type), allocatable :: keys(:)
      type(key_list_type) :: list

      call list%put("scene", "title", kind_text, default="''", &
         doc="title of the scene, for pictures and reports")
      call list%put("scene", "gravity", kind_real, values=3, unit="m s-2", default="0, 0, 0", &
         doc="acceleration of gravity in the inertial frame; not named, there is none")
      call list%put("scene", "t_end", kind_real, unit="s", mandatory=.true., above=0.0_wp, &
         doc="end of the simulated time, which starts at 0")
      call list%put("scene", "impacts", kind_choice, words=impact_names, &
         doc="impacts of rigid contacts that touch at one instant: one after the other, the " // &
         "fastest approach first, or all at once, by complementarity problems of compression " // &
         "and expansion; 'sequential' if not given")

      call list%put("material", "name", kind_name, mandatory=.true., doc="name of the material")
      call list%put("material", "young", kind_real, unit="Pa", mandatory=.true., above=0.0_wp, &
         doc="Young's modulus E")
      call list%put("material", "poisson", kind_real, unit="1", mandatory=.true., above=-1.0_wp, &
         most=0.5_wp, doc="Poisson's ratio nu")

      call put_body_keys(list)

      call list%put("surface", "name", kind_name, mandatory=.true., doc="name of the surface")
      call list%put("surface", "body", kind_reference, mandatory=.true., target="body", &
         doc="body that carries the surface, or 'ground'")
      call list%put("surface", "shape", kind_choice, choices=shape_names, mandatory=.true., &
         doc="shape of the surface")
      call put_shape_keys(list)
      call list%put("surface", "material", kind_reference, mandatory=.true., target="material", &
         doc="material of the surface")

      call list%put("contact", "name", kind_name, mandatory=.true., doc="name of the contact; " // &
         "where its surfaces can touch at several places, name[1], name[2] and so on in the output")
      call list%put("contact", "surfaces", kind_reference, values=2, mandatory=.true., &
         target="surface", doc="the surfaces A and B; normals point from A into B, forces are " // &
         "reported as they act on the body of B")
      call put_part_keys(list)
      call put_pair_keys(list)
      call put_default_keys(list)

      call put_integrator_keys(list)

      call list%put("output", "file", kind_file, &
         doc="name of the HDF5 file; not given, the name of the scene file with .h5, in the " // &
         "current folder")
      call list%put("output", "interval", kind_real, unit="s", above=0.0_wp, &
         doc="time between rows; not given, t_end/1000")
      call list%put("output", "contact_geometry", kind_logical, doc="whether rows hold " // &
         "contact points, normals and the directions of spots, 72 bytes a contact, from which " // &
         "forces and spots can be drawn; .true. if not given")
      call list%put("output", "rolling", kind_logical, doc="whether rows hold rolling " // &
         "velocities and creepages, 48 bytes a contact; not given, where a contact has " // &
         "tangential = 'rolling' or a law of creep")

      call put_bearing_keys(list)
      call put_constant_keys(list)
      call put_stop_keys(list)
      call put_spring_keys(list)
      call put_cost_keys(list)
      allocate(keys, source=list%keys(:list%n))
   end function schema_keys

   !> What a group of constants says.
   subroutine put_constant_keys(list)
      type(key_list_type), intent(inout) :: list

      call list%put(constants_group, "name", kind_real, unit="1", &
         doc="any name of letters, digits and _ that has no meaning yet, for a number or an " // &
         "expression of + - * / **, (), constants, pi, deg (pi/180, so that an angle may be " // &
         "30*deg or 30 deg), sqrt, exp, log, log10, sin, cos, tan, asin, acos, atan, atan2, " // &
         "sinh, cosh, tanh, abs, min, max; all numbers are reals, 4/3 is not 1")
   end subroutine put_constant_keys

   subroutine put_body_keys(list)
      type(key_list_type), intent(inout) :: list

      call list%put("body", "name", kind_name, mandatory=.true., &
         doc="name of the body; 'ground' is taken")
      call list%put("body", "motion", kind_choice, words=motion_names, default="'free'", &
         doc="how the body moves: free, fixed, prescribed (with its initial velocities, or a " // &
         "ramp from them to the final ones), spindle (it turns as prescribed and does not " // &
         "tilt, its centre of mass moves freely), or rotor (it turns as prescribed about its " // &
         "third axis, and moves and tilts freely)")
      call list%put("body", "mass", kind_real, unit="kg", above=0.0_wp, &
         doc="mass; mandatory for a free body, a spindle and a rotor, without meaning for others")
      call list%put("body", "inertia", kind_real, values=3, unit="kg m2", &
         above=0.0_wp, doc="principal moments of inertia about the centre of mass, along the " // &
         "body axes; none may exceed the sum of the other two; mandatory for a free body " // &
         "and a rotor, without meaning for others")
      call list%put("body", "radius_of_gyration", kind_real, values=3, fewer=.true., unit="m", &
         above=0.0_wp, doc="radii of gyration along the body axes, or one for all: inertia is " // &
         "mass times their squares; instead of inertia")
      call list%put("body", "density", kind_real, unit="kg m-3", above=0.0_wp, &
         doc="density of a solid body, bounded by its surface: gives mass and inertia, and " // &
         "makes position that of its centre of mass; the coordinates of its surfaces may then " // &
         "have any origin; instead of mass and inertia")
      call list%put("body", "solid", kind_reference, target="surface", &
         doc="surface of the body that bounds the solid; not given, its only one; with mass " // &
         "in place of density, inertia is that of such a solid")
      call list%put("body", "solid_length", kind_real, unit="m", above=0.0_wp, &
         doc="length of the solid in a cylinder, about its centre, or height of the one in a " // &
         "cone or paraboloid, from its apex or vertex")
      call list%put("body", "solid_part", kind_choice, words=solid_parts, &
         doc="part of a sphere or ellipsoid that the solid is: all of it ('whole', if not " // &
         "given), or the half below or above its centre, along its third axis")
      call list%put("body", "place", kind_choice, words=place_names, &
         doc="moves the body along gravity from its position: touch, until it just touches; " // &
         "rest, until the normal forces of its contacts carry it; not given, it stays")
      call list%put("body", "held_along", kind_real, values=3, unit="1", &
         doc="direction, inertial frame, in which contensou equilibrium and place = 'rest' do " // &
         "not move the body, as the cage of a bearing holds its balls; runs do not heed it")
      call list%put("body", "count", kind_integer, values=3, fewer=.true., unit="1", &
         least=1.0_wp, most=1.0e5_wp, doc="how many of this body there are, with its surfaces: " &
         // "NAME_1, NAME_2, ...; one number for a row, a ring or the rows of a triangle, up to " &
         // "three for a grid along x, y and z, of which the first runs fastest")
      call list%put("body", "spacing", kind_real, values=3, fewer=.true., unit="m", &
         doc="from one body to the next: the step of a row (x, y, z), the distances of a grid " // &
         "along x, y and z, the distance of neighbours in a ring or triangle")
      call list%put("body", "ring_radius", kind_real, unit="m", above=0.0_wp, &
         doc="radius of a ring of bodies about position, in the plane of x and y, the first " // &
         "towards x; in place of spacing")
      call list%put("body", "arrangement", kind_choice, words=arrangement_names, &
         doc="how the bodies are arranged: row and grid from the first at position; ring about " &
         // "it; triangle of rows of 1, 2, 3, ... along x from the first at position; not " // &
         "given, it follows from count and ring_radius")
      call list%put("body", "position", kind_real, values=3, unit="m", default="0, 0, 0", &
         doc="initial centre of mass in the inertial frame")
      call list%put("body", "axis", kind_real, values=3, unit="1", &
         doc="axis of the initial rotation from the inertial to the body axes, of any length; " // &
         "goes with angle")
      call list%put("body", "angle", kind_real, unit="rad", &
         doc="angle of the initial rotation about axis")
      call list%put("body", "quaternion", kind_real, values=4, unit="1", &
         doc="initial attitude (w, x, y, z), body to inertial frame, of any norm but zero, " // &
         "its components up to 1e40; instead of axis and angle")
      call list%put("body", "velocity", kind_real, values=3, unit="m s-1", default="0, 0, 0", &
         doc="initial velocity of the centre of mass in the inertial frame")
      call list%put("body", "spin", kind_real, values=3, unit="rad s-1", default="0, 0, 0", &
         doc="initial angular velocity in body axes")
      call list%put("body", "angular_velocity", kind_real, values=3, unit="rad s-1", &
         doc="initial angular velocity in the inertial frame; instead of spin")
      call list%put("body", "final_velocity", kind_real, values=3, unit="m s-1", &
         doc="velocity of a prescribed motion after ramp_duration; not given, it stays")
      call list%put("body", "final_angular_velocity", kind_real, values=3, unit="rad s-1", &
         doc="angular velocity of a prescribed motion after ramp_duration, " // &
         "inertial frame; not " // &
         "given, it stays")
      call list%put("body", "ramp_duration", kind_real, unit="s", above=0.0_wp, &
         doc="time in which a prescribed motion goes linearly from its initial to its final " // &
         "velocities")
      call list%put("body", "applied_force", kind_real, values=3, unit="N", &
         doc="constant force at the centre of mass of a free body, a spindle or a rotor")
      call list%put("body", "applied_torque", kind_real, values=3, unit="N m", &
         doc="constant torque on a free body or a rotor")
      call list%put("body", "applied_frame", kind_choice, words=frame_names, &
         doc="frame in which applied_force and applied_torque are constant; " // &
         "'inertial' if not given")
   end subroutine put_body_keys

   subroutine put_integrator_keys(list)
      type(key_list_type), intent(inout) :: list

      call list%put("integrator", "method", kind_choice, words=integrator_methods, &
         default="'cvode_bdf'", &
         doc="method: cvode_bdf, implicit, for any problem; cvode_adams, a multistep method, " // &
         "and explicit8, of order 8, for problems that are not stiff; explicit8 is the " // &
         "fastest one with light damping, and says when a contact is too stiff for it; auto, " // &
         "explicit8 or cvode_bdf, whichever takes the longer steps, changed during the run")
      call list%put("integrator", "rtol", kind_real, unit="1", default="1.0e-8", least=1.0e-14_wp, &
         most=1.0e-1_wp, doc="relative tolerance of a step, against the scales below")
      call list%put("integrator", "length_scale", kind_real, unit="m", above=0.0_wp, &
         doc="positions are held to rtol times this length; not given, it is a tenth of " // &
         "the smallest overlap under gravity, or without gravity in an impact at " // &
         "velocity_scale, and for a rigid contact of the smallest radius")
      call list%put("integrator", "velocity_scale", kind_real, unit="m s-1", above=0.0_wp, &
         default="1.0e-2", &
         doc="velocities are held to rtol times the larger of this and the speed")
      call list%put("integrator", "angular_velocity_scale", kind_real, unit="rad s-1", &
         above=0.0_wp, &
         default="1.0", &
         doc="angular velocities are held to rtol times the larger of this and the rate")
      call list%put("integrator", "max_step", kind_real, unit="s", above=0.0_wp, &
         doc="largest step; not given, there is no bound")
      call list%put("integrator", "jacobian", kind_choice, words=jacobian_kinds, &
         default="'analytic'", &
         doc="Jacobian of cvode_bdf, also where auto chooses it: analytic, or by differences " // &
         "of the right-hand side, one for each unknown, which shows what the analytic one saves")
      call list%put("integrator", "jacobian_steps", kind_integer, unit="1", least=1.0_wp, &
         most=1.0e9_wp, default="10", doc="steps after which cvode_bdf renews the Jacobian, " // &
         "of either kind, and factorizes; CVODE by itself takes 51, and factorizes after 20")
   end subroutine put_integrator_keys

   !> The keys of a bearing, with those of the laws of its contacts.
   subroutine put_bearing_keys(list)
      type(key_list_type), intent(inout) :: list
      character(len=*), parameter :: b = "bearing"

      call list%put(b, "name", kind_name, mandatory=.true., &
         doc="name of the bearing, with which the names of its parts begin")
      call list%put(b, "ball_count", kind_integer, unit="1", mandatory=.true., least=3.0_wp, &
         most=1000.0_wp, doc="number of balls, evenly spaced on the pitch circle")
      call list%put(b, "ball_diameter", kind_real, unit="m", mandatory=.true., above=0.0_wp, &
         doc="diameter of the balls")
      call list%put(b, "pitch_diameter", kind_real, unit="m", mandatory=.true., above=0.0_wp, &
         doc="diameter of the circle of the centres of the balls, midway between the raceways")
      call list%put(b, "inner_groove_ratio", kind_real, unit="1", above=0.5_wp, &
         doc="radius of the groove of the inner ring over the diameter of a ball; this or " // &
         "inner_groove_radius")
      call list%put(b, "inner_groove_radius", kind_real, unit="m", above=0.0_wp, &
         doc="radius of the groove of the inner ring")
      call list%put(b, "outer_groove_ratio", kind_real, unit="1", above=0.5_wp, &
         doc="radius of the groove of the outer ring over the diameter of a ball; this or " // &
         "outer_groove_radius")
      call list%put(b, "outer_groove_radius", kind_real, unit="m", above=0.0_wp, &
         doc="radius of the groove of the outer ring")
      call list%put(b, "clearance", kind_real, unit="m", default="0.0", &
         doc="diametral clearance: diameter of the outer raceway less that of the inner " // &
         "one and two balls; negative for an interference")
      call list%put(b, "centre", kind_real, values=3, unit="m", default="0, 0, 0", &
         doc="centre of the bearing, inertial frame")
      call list%put(b, "axis", kind_real, values=3, unit="1", default="0, 0, 1", &
         doc="axis of the bearing, of any length, inertial frame; speeds and axial_load " // &
         "are positive along it")
      call list%put(b, "material", kind_reference, mandatory=.true., target="material", &
         doc="material of the rings, and of what has none of its own")
      call list%put(b, "ball_material", kind_reference, target="material", &
         doc="material of the balls; that of the rings if not given")
      call list%put(b, "ball_density", kind_real, unit="kg m-3", mandatory=.true., &
         above=0.0_wp, &
         doc="density of the balls")
      call list%put(b, "inner_speed", kind_real, unit="rad s-1", default="0.0", &
         doc="angular velocity of the inner ring about the axis")
      call list%put(b, "outer_speed", kind_real, unit="rad s-1", default="0.0", &
         doc="angular velocity of the outer ring about the axis")
      call list%put(b, "initial_state", kind_choice, words=start_names, default="'rest'", &
         doc="what balls and cage do at first: rest, or rolling with the epicyclic speeds")
      call list%put(b, "ramp_duration", kind_real, unit="s", above=0.0_wp, &
         doc="time in which the rings come from rest to their speeds; not given, they have " // &
         "them from the beginning")
      call list%put(b, "loaded_ring", kind_choice, words=ring_names, &
         doc="ring that carries the loads and can be displaced, 'inner' if not given; " // &
         "goes with ring_mass")
      call list%put(b, "ring_mass", kind_real, unit="kg", above=0.0_wp, &
         doc="mass of the loaded ring and what it carries; not given, the ring is not " // &
         "displaced; mandatory with a load")
      call list%put(b, "ring_motion", kind_choice, words=ring_motions, &
         doc="how the loaded ring moves, as motion of a body: spindle, which does not tilt " // &
         "and is meant if not given; rotor, which tilts; free, which also turns freely")
      call list%put(b, "ring_inertia", kind_real, values=2, unit="kg m2", above=0.0_wp, &
         doc="moments of inertia of the loaded ring and what it carries, across the axis and " // &
         "about it; mandatory for a ring that tilts")
      call list%put(b, "moment_load", kind_real, values=3, unit="N m", &
         doc="torque on a loaded ring that tilts, inertial frame, constant")
      call list%put(b, "inner_body", kind_reference, target="body", &
         doc="body of the scene that carries the inner groove, such as a shaft with several " // &
         "bearings; not given, the bearing has an inner ring of its own")
      call list%put(b, "outer_body", kind_reference, target="body", &
         doc="body of the scene that carries the outer groove, such as a housing or 'ground'; " // &
         "not given, the bearing has an outer ring of its own")
      call list%put(b, "contact_angle", kind_real, unit="rad", most=1.2_wp, least=-1.2_wp, &
         doc="contact angle of an unloaded bearing without play, positive where the inner " // &
         "ring is displaced along the axis; in place of clearance, which follows: the grooves " // &
         "begin that far apart along the axis")
      call list%put(b, "four_point", kind_logical, default=".false.", &
         doc="whether both grooves have two arcs each, which unloaded balls touch at " // &
         "contact_angle; clearance is then given beside it")
      call list%put(b, "preload", kind_real, unit="N", above=0.0_wp, &
         doc="axial force with which a bearing with contact_angle begins, against another " // &
         "one on the same shaft; without it the balls just touch")
      call list%put(b, "axial_load", kind_real, unit="N", default="0.0", &
         doc="load on the loaded ring along the axis; the bearing begins in equilibrium with it")
      call list%put(b, "radial_load", kind_real, unit="N", default="0.0", &
         doc="load on the loaded ring along radial_direction, which acts from the beginning")
      call list%put(b, "radial_direction", kind_real, values=3, unit="1", &
         doc="direction of radial_load, across the axis, of any length; towards ball 1 if " // &
         "not given")
      call list%put(b, "cage", kind_logical, default=".false.", &
         doc="whether there is a cage: a thin ring with a round pocket for each ball, " // &
         "which guide it")
      call list%put(b, "cage_mass", kind_real, unit="kg", above=0.0_wp, &
         doc="mass of the cage; mandatory with a cage")
      call list%put(b, "cage_material", kind_reference, target="material", &
         doc="material of the cage; that of the rings if not given")
      call list%put(b, "pocket_clearance", kind_real, unit="m", above=0.0_wp, &
         doc="diameter of a pocket less that of a ball; mandatory with a cage")
      call list%put(b, "cage_friction_coefficient", kind_real, unit="1", least=0.0_wp, &
         doc="friction coefficient in the pockets; friction_coefficient if not given")
      call copy_keys(list, "contact", b)
   end subroutine put_bearing_keys

   !> The keys of contacts between all pairs: those of a contact, but for its name and surfaces.
   subroutine put_pair_keys(list)
      type(key_list_type), intent(inout) :: list

      call list%put("contacts", "name", kind_name, &
         doc="beginning of the names of the contacts, NAME_A_B; not given, they are A_B")
      call list%put("contacts", "surfaces", kind_text, values=2, &
         doc="two names or patterns of surfaces, in which * stands for any characters and ? " // &
         "for one: all pairs of a surface of the first and one of the second, each once, but " // &
         "for those of one body, of bodies that cannot move, and with a group &contact of their " &
         // "own")
      call list%put("contacts", "first", kind_text, values=most_values, fewer=.true., &
         doc="names and patterns of the first surfaces of the pairs; in place of surfaces")
      call list%put("contacts", "second", kind_text, values=most_values, fewer=.true., &
         doc="names and patterns of the second surfaces of the pairs; goes with first")
      call copy_keys(list, "contact", "contacts")
   end subroutine put_pair_keys

   !> The keys of the defaults: those of contacts and surfaces, but for where a surface is;
   !> `normal` is that of a contact.
   subroutine put_default_keys(list)
      type(key_list_type), intent(inout) :: list

      call copy_keys(list, "contact", "defaults")
      call copy_keys(list, "surface", "defaults")
   end subroutine put_default_keys

   !> Add the keys of a group to another one, but for those it has and those that say which group
   !> it is, or where.
   subroutine copy_keys(list, from, to)
      type(key_list_type), intent(inout) :: list
      character(len=*), intent(in) :: from, to
      character(len=*), parameter :: of_one(*) = [character(len=28) :: "name", "surfaces", &
         "body", "centre", "direction", "axis", "angle", "quaternion"]
      type(key_type) :: key
      character(len=len(key%group)) :: source, goal
      integer :: before, i, k

      source = from
      goal = to
      before = list%n
      keys: do i = 1, before
         if (list%keys(i)%group /= source) cycle keys
         if (any(list%keys(i)%name == of_one)) cycle keys
         key = list%keys(i)
         do k = 1, list%n
            if (list%keys(k)%group /= goal) cycle
            if (list%keys(k)%name == key%name) cycle keys
         end do
         key%group = to
         if (to == "defaults") then
            key%mandatory = .false.
            key%default = ""
         end if
         call list%append(key)
      end do keys
   end subroutine copy_keys

end module contensou_scene_schema
