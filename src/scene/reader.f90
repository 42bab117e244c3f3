!> Reads a scene: document, settings, cross references; every mistake is reported at once.
module contensou_scene_reader
   use, intrinsic :: ieee_arithmetic, only : ieee_is_nan
   use contensou_base_attitude, only : read_attitude
   use contensou_base_diagnostics, only : diagnostics_type, origin_type
   use contensou_base_document, only : document_type, read_document
   use contensou_base_errors, only : error_type, fatal, status_usage
   use contensou_base_kinds, only : wp
   use contensou_base_rotations, only : rotation_matrix
   use contensou_base_settings, only : domain_text, group_settings_type
   use contensou_base_text, only : lower, nearest, quote, string_type, to_text
   use contensou_base_text_lock, only : lock_texts, unlock_texts
   use contensou_contact_damping, only : damping_model_type, damping_models
   use contensou_contact_geometry, only : contact_point_type, contact_trouble, geometry_type, &
      pose_type, track_type, trouble_lost, trouble_no_spot, trouble_none, trouble_text
   use contensou_contact_normal, only : normal_rigid
   use contensou_contact_pairs, only : geometry_models, new_geometry
   use contensou_contact_parts, only : contact_parts, n_parts, part_type, read_models
   use contensou_contact_surface, only : read_surface
   use contensou_dynamics_assembly, only : assemble, contact_length, initial_pose, &
      largest_relative_approach
   use contensou_dynamics_impact, only : touching_gap
   use contensou_dynamics_scene, only : body_spec_type, contact_spec_type, cost_spec_type, &
      frame_names, motion_fixed, motion_free, motion_names, motion_prescribed, motion_spindle, &
      moves_freely, scene_type, turns_by_drive
   use contensou_dynamics_equations, only : system_type
   use contensou_scene_bearing, only : concerns_bearings, expand_bearings, has_bearings
   use contensou_scene_schema, only : group_spec_type, schema_groups
   use contensou_scene_settings, only : apply_override, largest_number, resolve, resolved_text, &
      settings_type
   implicit none(type, external)
   private

   public :: read_scene, scene_file_type
   public :: load_scene, settle_scene, build_case, loaded_scene_type

   !> A scene with the texts it came from.
   type :: scene_file_type
      type(scene_type) :: scene
      !> Its equations of motion, as assembled when it was checked.
      type(system_type), allocatable :: system
      !> Text of the file as read.
      character(len=:), allocatable :: text
      !> All settings with defaults and overrides, as a namelist text.
      character(len=:), allocatable :: resolved
   end type scene_file_type

   !> A scene that others are made from by a change of some of its settings.
   type :: loaded_scene_type
      !> Name of the file.
      character(len=:), allocatable :: path
      !> The file as parsed.
      type(document_type) :: raw
      !> With overrides and the parts of bearings, and with the texts of the overrides as sources.
      type(document_type) :: document
      !> All groups with all keys, also those that may be left out: the groups of `document` first,
      !> in their order, if it has no mistake. Nothing is derived yet.
      type(settings_type) :: settings
      type(scene_file_type) :: file
   end type loaded_scene_type

   !> Largest number of output rows.
   real(wp), parameter :: max_rows = 1.0e9_wp

contains

   !> Read a scene file, apply overrides, check everything. Thread-safe.
   subroutine read_scene(path, overrides, output_file, file, error)
      !> Name of the scene file.
      character(len=*), intent(in) :: path
      !> Texts of the `--set` options.
      type(string_type), intent(in) :: overrides(:)
      !> Name of the output file from the command line; blank for that of the scene.
      character(len=*), intent(in) :: output_file
      type(scene_file_type), intent(out) :: file
      !> Set with all mistakes found; nothing of `file` is to be used then.
      type(error_type), allocatable, intent(out) :: error
      type(loaded_scene_type) :: loaded
      type(diagnostics_type) :: diagnostics
      character(len=:), allocatable :: count_text

      call lock_texts()
      call load_scene(path, overrides, output_file, loaded, diagnostics, error)
      if (.not. allocated(error) .and. diagnostics%count() > 0) then
         count_text = to_text(diagnostics%count()) // " errors"
         if (diagnostics%count() == 1) count_text = "1 error"
         call fatal(error, diagnostics%render(loaded%document%sources) // count_text // " in " // &
            path // "; nothing was run", status_usage)
      end if
      if (.not. allocated(error)) file = loaded%file
      call unlock_texts()
   end subroutine read_scene

   !> Read a scene file, apply overrides, check everything, and keep what other scenes can be made
   !> from.
   subroutine load_scene(path, overrides, output_file, loaded, diagnostics, error)
      !> Name of the scene file.
      character(len=*), intent(in) :: path
      !> Texts of the `--set` options.
      type(string_type), intent(in) :: overrides(:)
      !> Name of the output file from the command line; blank for that of the scene.
      character(len=*), intent(in) :: output_file
      !> The scene; of use only if there are no mistakes.
      type(loaded_scene_type), intent(out) :: loaded
      !> Mistakes are appended here; their sources are those of `loaded%document`.
      type(diagnostics_type), intent(inout) :: diagnostics
      !> Set if the file cannot be read.
      type(error_type), allocatable, intent(out) :: error
      type(settings_type) :: settings

      loaded%path = path
      call read_document(path, loaded%raw, diagnostics, error)
      if (allocated(error)) return
      loaded%file%text = loaded%raw%bytes
      call settle_scene(loaded%raw, overrides, loaded%document, loaded%settings, diagnostics)
      settings = loaded%settings
      call build(settings, path, output_file, loaded%file%scene, loaded%file%system, diagnostics)
      if (diagnostics%count() == 0) loaded%file%resolved = resolved_text(settings)
   end subroutine load_scene

   !> Apply overrides to a scene as parsed and check each of its settings.
   subroutine settle_scene(raw, overrides, document, settings, diagnostics)
      !> The file as parsed.
      type(document_type), intent(in) :: raw
      !> Texts of the `--set` options.
      type(string_type), intent(in) :: overrides(:)
      !> With overrides and the parts of bearings.
      type(document_type), intent(out) :: document
      !> All groups with all keys.
      type(settings_type), intent(out) :: settings
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i

      document = raw
      if (has_bearings(document)) then
         call expand(document, overrides, diagnostics)
      else
         do i = 1, size(overrides)
            call apply_override(document, overrides(i)%s, diagnostics)
         end do
      end if
      call resolve(document, settings, diagnostics)
      call add_missing(settings)
   end subroutine settle_scene

   !> Build a scene from settings in which values were changed. Thread-safe.
   subroutine build_case(settings, path, file, diagnostics)
      !> The settings, as `settle_scene` makes them; derived values are filled in.
      type(settings_type), intent(inout) :: settings
      !> Name of the scene file.
      character(len=*), intent(in) :: path
      !> The scene; its texts are not set.
      type(scene_file_type), intent(out) :: file
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics

      call build(settings, path, "", file%scene, file%system, diagnostics)
   end subroutine build_case

   !> Apply overrides and expand bearings: first what the bearings are made from, then the rest,
   !> which may concern their parts.
   subroutine expand(document, overrides, diagnostics)
      type(document_type), intent(inout) :: document
      !> Texts of the `--set` options.
      type(string_type), intent(in) :: overrides(:)
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics
      logical :: first(size(overrides))
      integer :: i

      do i = 1, size(overrides)
         first(i) = concerns_bearings(document, overrides(i)%s)
         if (first(i)) call apply_override(document, overrides(i)%s, diagnostics)
      end do
      call expand_bearings(document, diagnostics)
      ! The parts of a bearing that was left out are not unknown.
      do i = 1, size(overrides)
         if (.not. first(i) .and. document%complete) call apply_override(document, &
            overrides(i)%s, diagnostics)
      end do
   end subroutine expand

   !> Build the scene from its settings; references and everything that concerns several keys are
   !> checked here.
   subroutine build(settings, path, output_file, scene, system, diagnostics)
      !> The settings; derived values are filled in.
      type(settings_type), intent(inout) :: settings
      !> Name of the scene file.
      character(len=*), intent(in) :: path
      !> Name of the output file from the command line; blank for that of the scene.
      character(len=*), intent(in) :: output_file
      type(scene_type), intent(out) :: scene
      !> Its equations of motion; not allocated after a mistake.
      type(system_type), allocatable, intent(out) :: system
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics
      type(group_spec_type), allocatable :: groups(:)
      type(part_type), allocatable :: parts(:)
      integer, allocatable :: n(:)
      integer :: i

      parts = contact_parts()
      groups = schema_groups()
      allocate(n(size(groups)))
      n = [(count(settings%instances%group == i), i=1, size(n))]
      allocate(scene%materials(n(2)), scene%bodies(n(3)))
      allocate(scene%surfaces(n(4)), scene%contacts(n(5)))
      call check_names(settings, groups, diagnostics)
      n = 0
      do i = 1, size(settings%instances)
         associate (instance => settings%instances(i))
            n(instance%group) = n(instance%group) + 1
            select case (groups(instance%group)%name)
            case ("scene")
               call build_scene(instance, scene)
            case ("material")
               associate (material => scene%materials(n(2)))
                  material%name = instance%label()
                  material%young = instance%number("young")
                  material%poisson = instance%number("poisson")
               end associate
            case ("body")
               call build_body(instance, scene%bodies(n(3)), diagnostics)
            case ("surface")
               call build_surface(settings, instance, scene, n(4), diagnostics)
            case ("contact")
               call build_contact(settings, instance, parts, scene%contacts(n(5)), diagnostics)
            case ("integrator")
               call build_integrator(instance, scene, diagnostics)
            case ("output")
               call build_output(instance, path, output_file, scene, diagnostics)
            case ("cost")
               call build_cost(instance, scene%cost, diagnostics)
            case default
               error stop "the schema has a group that no scene is built from"
            end select
         end associate
      end do
      if (diagnostics%count() > 0) return
      call check_contacts(settings, scene, diagnostics)
      if (diagnostics%count() > 0) return
      allocate(system)
      call assemble(scene, system)
      call fill_in(settings, scene, system)
      call check_overlaps(settings, scene, system, diagnostics)
   end subroutine build

   !> Add the groups that may be left out, with their defaults.
   subroutine add_missing(settings)
      type(settings_type), intent(inout) :: settings
      type(document_type) :: document
      type(settings_type) :: extra
      type(diagnostics_type) :: ignored
      type(group_spec_type), allocatable :: groups(:)
      type(group_settings_type), allocatable :: all(:)
      integer :: g, i, n, last

      groups = schema_groups()
      last = size(settings%instances)
      allocate(document%groups(size(groups)))
      n = 0
      do g = 1, size(groups)
         if (groups(g)%repeats .or. groups(g)%mandatory) cycle
         if (any(settings%instances%group == g)) cycle
         n = n + 1
         document%groups(n)%name = trim(groups(g)%name)
         document%groups(n)%origin = origin_type(1, 0, 0, 1)
         allocate(document%groups(n)%assignments(0))
      end do
      document%n_groups = n
      document%complete = .false.
      call resolve(document, extra, ignored)
      allocate(all(last + n))
      do i = 1, last
         all(i) = settings%instances(i)
      end do
      do i = 1, n
         all(last + i) = extra%instances(i)
      end do
      call move_alloc(all, settings%instances)
   end subroutine add_missing

   !> Names must be unique among groups of one kind.
   subroutine check_names(settings, groups, diagnostics)
      type(settings_type), intent(in) :: settings
      !> Groups of the schema.
      type(group_spec_type), intent(in) :: groups(:)
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i, j
      character(len=:), allocatable :: name

      do i = 1, size(settings%instances)
         associate (instance => settings%instances(i))
            name = lower(instance%label())
            if (name == "") cycle
            if (groups(instance%group)%name == "body" .and. name == "ground") then
               call diagnostics%add(instance%settings(instance%at("name"))%places(1), &
                  "the name 'ground' is taken by the predeclared fixed body", "another name")
            end if
            do j = 1, i - 1
               if (settings%instances(j)%group /= instance%group) cycle
               if (lower(settings%instances(j)%label()) /= name) cycle
               call diagnostics%add(instance%settings(instance%at("name"))%places(1), &
                  "there are two groups &" // trim(groups(instance%group)%name) // &
                  " with the name " // quote(instance%label()), &
                  "another name; the first is in line " // &
                  to_text(settings%instances(j)%settings(instance%at("name"))%places(1)%line))
               exit
            end do
         end associate
      end do
   end subroutine check_names

   !> Values of the group `scene`.
   subroutine build_scene(instance, scene)
      !> The group.
      type(group_settings_type), intent(in) :: instance
      type(scene_type), intent(inout) :: scene

      scene%title = instance%settings(instance%at("title"))%text(1)%s
      scene%gravity = instance%numbers("gravity")
      scene%t_end = instance%number("t_end")
   end subroutine build_scene

   !> A body.
   subroutine build_body(instance, body, diagnostics)
      !> The group.
      type(group_settings_type), intent(inout) :: instance
      type(body_spec_type), intent(inout) :: body
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics
      real(wp) :: rotation(3, 3)

      body%name = instance%label()
      body%mass = instance%number("mass")
      body%inertia = instance%numbers("inertia")
      body%position = instance%numbers("position")
      body%velocity = instance%numbers("velocity")
      associate (inertia => instance%settings(instance%at("inertia")))
         if (inertia%set) then
            ! A thin disc is allowed to miss equality by rounding.
            if (2.0_wp*maxval(body%inertia) > sum(body%inertia)*(1.0_wp + 1.0e-12_wp)) then
               call diagnostics%add(inertia%places(maxloc(body%inertia, dim=1)), &
                  "the inertia of " // quote(body%name) // " violates the triangle inequality", &
                  "no principal moment larger than the sum of the other two, here at most " // &
                  to_text(sum(body%inertia, mask=[1, 2, 3] /= maxloc(body%inertia, dim=1))))
            end if
         end if
      end associate
      call read_attitude(instance, body%quaternion, diagnostics)
      associate (spin => instance%settings(instance%at("spin")), &
         omega => instance%settings(instance%at("angular_velocity")))
         if (spin%given .and. omega%given) call diagnostics%add(omega%origin, &
            "the angular velocity is given twice", &
            "either spin (body axes) or angular_velocity (inertial frame)")
         body%spin = spin%real(:3)
         rotation = rotation_matrix(body%quaternion)
         if (omega%set) then
            body%spin = matmul(omega%real(:3), rotation)
            ! The default of the other is not in force; the resolved text would have both.
            spin%set = .false.
         end if
      end associate
      call build_drive(instance, body, diagnostics)
   end subroutine build_body

   !> How a body moves, and what is applied to it.
   subroutine build_drive(instance, body, diagnostics)
      !> The group.
      type(group_settings_type), intent(inout) :: instance
      !> The body; its initial state is set.
      type(body_spec_type), intent(inout) :: body
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics
      character(len=*), parameter :: only_driven(*) = [character(len=22) :: &
         "final_angular_velocity", "ramp_duration"]
      character(len=*), parameter :: only_moving(*) = [character(len=22) :: &
         "applied_force", "applied_frame"]
      character(len=*), parameter :: not_fixed(*) = [character(len=22) :: &
         "velocity", "spin", "angular_velocity"]
      character(len=*), parameter :: inertial(*) = [character(len=22) :: "mass", "inertia"]
      integer :: i

      body%motion = max(instance%settings(instance%at("motion"))%choice, 1)
      body%final_velocity = body%velocity
      body%final_angular_velocity = matmul(rotation_matrix(body%quaternion), body%spin)
      if (body%motion /= motion_prescribed) call refuse("final_velocity", &
         "motion = 'prescribed', or no final_velocity")
      do i = 1, size(only_driven)
         if (.not. turns_by_drive(body%motion)) call refuse(only_driven(i), &
            "motion = 'prescribed', or no " // trim(only_driven(i)))
      end do
      do i = 1, size(only_moving)
         if (.not. moves_freely(body%motion)) call refuse(only_moving(i), &
            "no applied load: nothing can move this body otherwise")
      end do
      if (body%motion /= motion_free) call refuse("applied_torque", &
         "no applied load: nothing can move this body otherwise")
      do i = 1, size(not_fixed)
         associate (setting => instance%settings(instance%at(trim(not_fixed(i)))))
            ! Zeros are in order.
            if (body%motion == motion_fixed .and. any(abs(setting%real(:3)) > 0.0_wp)) call &
               refuse( &
               not_fixed(i), "motion = 'prescribed', which keeps the initial velocities")
         end associate
      end do
      do i = 1, size(inertial)
         associate (setting => instance%settings(instance%at(trim(inertial(i)))))
            ! The inertia of a body that a drive turns has no say.
            if ((body%motion == motion_free .or. moves_freely(body%motion) .and. i == 1) .and. &
               .not. setting%given .and. .not. setting%meant .and. instance%complete) call &
               diagnostics%add(instance%origin, "'" // trim(inertial(i)) // &
               "' is missing in group &body" // named(instance), &
               trim(inertial(i)) // " = " // domain_text(setting%key))
         end associate
      end do
      associate (velocity => instance%settings(instance%at("final_velocity")), &
         omega => instance%settings(instance%at("final_angular_velocity")), &
         duration => instance%settings(instance%at("ramp_duration")))
         if (velocity%set) body%final_velocity = velocity%real(:3)
         if (omega%set) body%final_angular_velocity = omega%real(:3)
         body%ramp_duration = duration%real(1)
         if (turns_by_drive(body%motion)) then
            if ((velocity%given .or. omega%given) .and. .not. (duration%given .or. &
               duration%meant)) then
               if (velocity%given) call diagnostics%add(velocity%origin, &
                  "'final_velocity' without 'ramp_duration'", "ramp_duration = a number > 0 [s]")
               if (omega%given) call diagnostics%add(omega%origin, &
                  "'final_angular_velocity' without 'ramp_duration'", &
                  "ramp_duration = a number > 0 [s]")
            else if (duration%given .and. .not. (velocity%given .or. omega%given)) then
               call diagnostics%add(duration%origin, "'ramp_duration' without a final velocity", &
                  "final_velocity or final_angular_velocity")
            end if
         end if
      end associate
      body%applied_force = instance%numbers("applied_force")
      body%applied_torque = instance%numbers("applied_torque")
      associate (frame => instance%settings(instance%at("applied_frame")))
         body%load_follows = .false.
         if (frame%choice > 0) body%load_follows = frame_names(frame%choice) == "body"
      end associate

   contains

      !> A key that has no meaning for this motion.
      subroutine refuse(name, expected)
         !> The key.
         character(len=*), intent(in) :: name
         !> What would be right.
         character(len=*), intent(in) :: expected

         associate (setting => instance%settings(instance%at(trim(name))))
            if (setting%given) call diagnostics%add(setting%origin, "'" // trim(name) // &
               "' has no meaning for a body whose motion is '" // &
               trim(motion_names(body%motion)) // "'", expected)
         end associate
      end subroutine refuse

   end subroutine build_drive

   !> Name of a group for a message, as " 'top'", or nothing.
   function named(instance) result(text)
      !> The group.
      type(group_settings_type), intent(in) :: instance
      character(len=:), allocatable :: text

      text = ""
      if (instance%label() /= "") text = " " // quote(instance%label())
   end function named

   !> A surface.
   subroutine build_surface(settings, instance, scene, index, diagnostics)
      !> All settings.
      type(settings_type), intent(in) :: settings
      !> The group.
      type(group_settings_type), intent(in) :: instance
      type(scene_type), intent(inout) :: scene
      !> Number of the surface.
      integer, intent(in) :: index
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics

      associate (spec => scene%surfaces(index))
         spec%name = instance%label()
         call refer(settings, instance, "body", 1, spec%body, diagnostics)
         call refer(settings, instance, "material", 1, spec%material, diagnostics)
         call read_surface(instance, spec%surface, diagnostics)
      end associate
   end subroutine build_surface

   !> A contact.
   subroutine build_contact(settings, instance, parts, contact, diagnostics)
      !> All settings.
      type(settings_type), intent(in) :: settings
      !> The group.
      type(group_settings_type), intent(in) :: instance
      !> The parts of a contact.
      type(part_type), intent(in) :: parts(:)
      type(contact_spec_type), intent(inout) :: contact
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics
      type(damping_model_type), allocatable :: dampings(:)
      integer :: choice(n_parts)

      contact%name = instance%label()
      call refer(settings, instance, "surfaces", 1, contact%surfaces(1), diagnostics)
      call refer(settings, instance, "surfaces", 2, contact%surfaces(2), diagnostics)
      call read_models(instance, parts, choice, contact%parameters, diagnostics)
      contact%normal = choice(1)
      contact%damping = choice(2)
      contact%friction = choice(3)
      contact%rolling = choice(4)
      if (contact%normal /= normal_rigid) return
      dampings = damping_models()
      associate (damping => dampings(contact%damping))
         if (.not. associated(damping%restitute)) call diagnostics%add( &
            instance%place("damping", 1), "damping " // quote(trim(damping%info%name)) // &
            " has no meaning for a rigid contact", &
            "restitution without damping, or damping = 'hunt_crossley'")
      end associate
   end subroutine build_contact

   !> Values of the group `integrator`.
   subroutine build_integrator(instance, scene, diagnostics)
      !> The group.
      type(group_settings_type), intent(in) :: instance
      type(scene_type), intent(inout) :: scene
      !> Mistakes so far.
      type(diagnostics_type), intent(inout) :: diagnostics

      scene%integrator%method = instance%settings(instance%at("method"))%text(1)%s
      scene%integrator%differences = &
         instance%settings(instance%at("jacobian"))%text(1)%s == "differences"
      scene%integrator%rtol = instance%number("rtol")
      scene%integrator%length_scale = instance%number("length_scale")
      scene%integrator%velocity_scale = instance%number("velocity_scale")
      scene%integrator%angular_velocity_scale = instance%number("angular_velocity_scale")
      scene%integrator%max_step = instance%number("max_step")
      associate (steps => instance%settings(instance%at("jacobian_steps")))
         scene%integrator%jacobian_steps = nint(steps%real(1))
         if (abs(steps%real(1) - scene%integrator%jacobian_steps) > 0.0_wp) call diagnostics%add( &
            steps%origin, "'jacobian_steps' is not a whole number", "as 10")
      end associate
   end subroutine build_integrator

   !> Values of the group `output`.
   subroutine build_output(instance, path, output_file, scene, diagnostics)
      !> The group.
      type(group_settings_type), intent(inout) :: instance
      !> Name of the scene file.
      character(len=*), intent(in) :: path
      !> Name of the output file from the command line; blank for that of the scene.
      character(len=*), intent(in) :: output_file
      type(scene_type), intent(inout) :: scene
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: slash, dot

      associate (file => instance%settings(instance%at("file")))
         if (output_file /= "") then
            file%text(1)%s = output_file
         else if (.not. file%given) then
            slash = index(path, "/", back=.true.)
            dot = index(path, ".", back=.true.)
            if (dot <= slash + 1) dot = len(path) + 1
            file%text(1)%s = path(slash + 1:dot - 1) // ".h5"
         else if (file%set .and. file%text(1)%s == "") then
            call diagnostics%add(file%places(1), "'file' is empty", "the name of a file")
         end if
         file%set = .true.
         scene%output%file = file%text(1)%s
      end associate
      scene%output%interval = instance%number("interval")
   end subroutine build_output

   !> Values of the group `cost`.
   subroutine build_cost(instance, cost, diagnostics)
      !> The group.
      type(group_settings_type), intent(in) :: instance
      !> What is run.
      type(cost_spec_type), intent(inout) :: cost
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i

      cost%friction = choices("friction")
      cost%normal = choices("normal")
      associate (methods => instance%settings(instance%at("methods")), &
         rtol => instance%settings(instance%at("rtol")), &
         quantities => choices("quantities"))
         allocate(cost%methods(methods%n))
         do i = 1, methods%n
            if (methods%set) cost%methods(i) = methods%text(i)%s
         end do
         call refuse_doubles("methods", methods%choices(:methods%n))
         call refuse_doubles("friction", cost%friction)
         call refuse_doubles("normal", cost%normal)
         cost%rtol = rtol%real(:rtol%n)
         cost%counts(quantities) = .true.
         cost%reference_rtol = instance%number("reference_rtol")
         if (rtol%set .and. cost%reference_rtol >= minval(cost%rtol)) call diagnostics%add( &
            instance%settings(instance%at("reference_rtol"))%places(1), &
            "the reference is not tighter than what it is compared with", &
            "reference_rtol < " // to_text(minval(cost%rtol)) // ", the smallest of rtol")
      end associate
      cost%measure = max(1, instance%settings(instance%at("measure"))%choice)
      cost%samples = whole("samples")
      cost%repeats = whole("repeats")
      cost%cpu_limit = instance%number("cpu_limit")

   contains

      !> Positions of the choices of a key; none if it has no usable value.
      pure function choices(name) result(list)
         !> The key.
         character(len=*), intent(in) :: name
         integer, allocatable :: list(:)

         associate (setting => instance%settings(instance%at(name)))
            allocate(list(0))
            if (setting%set) list = setting%choices(:setting%n)
         end associate
      end function choices

      !> A number that must be whole.
      integer function whole(name)
         !> The key.
         character(len=*), intent(in) :: name
         real(wp) :: x

         x = instance%number(name)
         whole = nint(x)
         if (abs(x - whole) > 0.0_wp) call diagnostics%add( &
            instance%settings(instance%at(name))%places(1), "'" // name // "' must be whole", &
            "a whole number")
      end function whole

      !> Nothing is compared with itself.
      subroutine refuse_doubles(name, list)
         !> The key.
         character(len=*), intent(in) :: name
         !> Its choices; 0 after a mistake.
         integer, intent(in) :: list(:)
         integer :: j

         associate (setting => instance%settings(instance%at(name)))
            do j = 2, size(list)
               if (list(j) > 0 .and. any(list(:j - 1) == list(j))) call diagnostics%add( &
                  setting%places(j), quote(setting%text(j)%s) // " stands twice in '" // name // &
                  "'", "each choice once")
            end do
         end associate
      end subroutine refuse_doubles

   end subroutine build_cost

   !> Contacts need two different bodies and a pair of shapes that is supported.
   subroutine check_contacts(settings, scene, diagnostics)
      type(settings_type), intent(in) :: settings
      type(scene_type), intent(in) :: scene
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics
      class(geometry_type), allocatable :: geometry
      character(len=:), allocatable :: problem
      type(origin_type) :: place
      integer :: i

      do i = 1, size(scene%contacts)
         place = contact_place(settings, i)
         associate (a => scene%surfaces(scene%contacts(i)%surfaces(1)), &
            b => scene%surfaces(scene%contacts(i)%surfaces(2)))
            if (a%body == b%body) then
               call diagnostics%add(place, "surfaces " // quote(a%name) // " and " // &
                  quote(b%name) // " of contact " // quote(scene%contacts(i)%name) // &
                  " belong to the same body", "surfaces of two bodies")
               cycle
            end if
            if (.not. moves(a%body) .and. .not. moves(b%body)) then
               call diagnostics%add(place, "contact " // quote(scene%contacts(i)%name) // &
                  ": neither of its bodies is free", "a body whose motion is 'free'")
               cycle
            end if
            if (scene%contacts(i)%normal == normal_rigid .and. (spins(a%body) .or. &
               spins(b%body))) then
               call diagnostics%add(place, "contact " // quote(scene%contacts(i)%name) // &
                  ": a rigid contact cannot carry a body whose motion is 'spindle'", &
                  "normal = 'hertz' or 'vilke'")
               cycle
            end if
            call new_geometry(a%surface, b%surface, geometry, problem)
            if (.not. allocated(geometry)) call diagnostics%add(place, "surfaces " // &
               quote(a%name) // " and " // quote(b%name) // " of contact " // &
               quote(scene%contacts(i)%name) // ": " // problem, &
               "surfaces that touch in a point, of one of the pairs (" // pairs() // ")")
         end associate
      end do
      if (scene%output%interval > 0.0_wp .and. scene%t_end > max_rows*scene%output%interval) then
         call diagnostics%add(interval_place(settings), "the output would have more than " // &
            to_text(nint(max_rows)) // " rows", "a larger output.interval")
      end if

   contains

      !> Whether a body is a spindle.
      pure logical function spins(body)
         !> Index of the body; 0 for the ground.
         integer, intent(in) :: body

         spins = .false.
         if (body > 0) spins = scene%bodies(body)%motion == motion_spindle
      end function spins

      !> Whether a body yields to a contact.
      pure logical function moves(body)
         !> Index of the body; 0 for the ground.
         integer, intent(in) :: body

         moves = .false.
         if (body > 0) moves = moves_freely(scene%bodies(body)%motion)
      end function moves

      !> Supported pairs.
      function pairs() result(text)
         character(len=:), allocatable :: text
         integer :: k

         associate (models => geometry_models())
            text = trim(models(1)%name)
            do k = 2, size(models)
               text = text // "; " // trim(models(k)%name)
            end do
         end associate
      end function pairs

   end subroutine check_contacts

   !> Where the interval of the output is given.
   pure function interval_place(settings) result(place)
      type(settings_type), intent(in) :: settings
      type(origin_type) :: place
      integer :: i

      place = origin_type(1, 0, 0, 1)
      do i = 1, size(settings%instances)
         if (settings%instances(i)%settings(1)%key%group /= "output") cycle
         place = settings%instances(i)%settings(settings%instances(i)%at("interval"))%places(1)
      end do
   end function interval_place

   !> Where the surfaces of a contact are named.
   pure function contact_place(settings, contact) result(place)
      type(settings_type), intent(in) :: settings
      !> Number of the contact.
      integer, intent(in) :: contact
      type(origin_type) :: place
      integer :: i, n

      n = 0
      place = origin_type()
      do i = 1, size(settings%instances)
         if (settings%instances(i)%settings(1)%key%group /= "contact") cycle
         n = n + 1
         if (n == contact) place = &
            settings%instances(i)%settings(settings%instances(i)%at("surfaces"))%origin
      end do
   end function contact_place

   !> Derive the settings that depend on the scene.
   subroutine fill_in(settings, scene, system)
      type(settings_type), intent(inout) :: settings
      type(scene_type), intent(inout) :: scene
      !> Its equations of motion.
      type(system_type), intent(in) :: system
      integer :: i

      if (scene%output%interval <= 0.0_wp) scene%output%interval = 1.0e-3_wp*scene%t_end
      if (scene%integrator%length_scale <= 0.0_wp) scene%integrator%length_scale = &
         contact_length(scene, system, scene%integrator%velocity_scale)
      ! What is derived is a number that a scene may give.
      scene%output%interval = max(scene%output%interval, 1.0_wp/largest_number)
      scene%integrator%length_scale = min(max(scene%integrator%length_scale, &
         1.0_wp/largest_number), largest_number)
      do i = 1, size(settings%instances)
         associate (instance => settings%instances(i))
            select case (instance%settings(1)%key%group)
            case ("output")
               call derive(instance, "interval", scene%output%interval)
            case ("integrator")
               call derive(instance, "length_scale", scene%integrator%length_scale)
            case default
               ! Nothing in the other groups is derived.
            end select
         end associate
      end do

   contains

      !> Record a derived number.
      subroutine derive(instance, name, x)
         !> The group.
         type(group_settings_type), intent(inout) :: instance
         !> The key.
         character(len=*), intent(in) :: name
         !> The number.
         real(wp), intent(in) :: x

         associate (setting => instance%settings(instance%at(name)))
            setting%set = .true.
            setting%real(1) = x
         end associate
      end subroutine derive

   end subroutine fill_in

   !> Surfaces that overlap too much or conform at the beginning.
   subroutine check_overlaps(settings, scene, system, diagnostics)
      type(settings_type), intent(in) :: settings
      type(scene_type), intent(in) :: scene
      !> Its equations of motion.
      type(system_type), intent(in) :: system
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics
      type(pose_type) :: pose(0:size(scene%bodies))
      type(track_type) :: track
      type(contact_point_type) :: at
      real(wp) :: gap
      integer :: i, trouble

      do i = 0, size(scene%bodies)
         pose(i) = initial_pose(scene, i)
      end do
      do i = 1, size(system%contacts)
         associate (contact => system%contacts(i))
            if (ieee_is_nan(contact%law%normal%stiffness)) then
               call diagnostics%add(contact_place(settings, i), "the stiffness of contact " // &
                  quote(scene%contacts(i)%name) // " is beyond what can be computed with", &
                  "radii and moduli that are neither so small nor so large")
               cycle
            end if
            ! It never has one, so that this need not wait for the surfaces to touch.
            if (contact%law%geometry%constant_curvatures .and. &
               ieee_is_nan(contact%law%normal%axis_a)) then
               call add_trouble(i, trouble_no_spot)
               cycle
            end if
            track = contact%track
            call contact%law%geometry%gap(pose(contact%a), pose(contact%b), track, gap)
            if (contact%rigid .and. -gap > touching_gap(contact)) then
               call diagnostics%add( &
                  contact_place(settings, i), "the surfaces of the rigid contact " // &
                  quote(scene%contacts(i)%name) // " overlap by " // short(-gap) // &
                  " m at the beginning", "a position with a gap of zero, to " // &
                  short(touching_gap(contact)) // " m, or a positive one")
               cycle
            end if
            if (-gap > contact%law%largest_approach) then
               call diagnostics%add( &
                  contact_place(settings, i), "the surfaces of contact " // &
                  quote(scene%contacts(i)%name) // " overlap by " // short(-gap) // &
                  " m at the beginning", "at most " // short(contact%law%largest_approach) // &
                  " m, " // short(largest_relative_approach) // &
                  " of the smallest radius of curvature" // less_in_hollow(scene%contacts(i)))
               cycle
            end if
            trouble = trouble_none
            if (track%lost) then
               trouble = trouble_lost
            else if (gap < 0.0_wp) then
               call contact%law%geometry%locate(pose(contact%a), pose(contact%b), track, gap, at)
               trouble = contact_trouble(track, at)
               if (trouble == trouble_none .and. ieee_is_nan(contact%law%normal%axis_a)) then
                  trouble = trouble_no_spot
               end if
            end if
            if (trouble /= trouble_none) call add_trouble(i, trouble)
         end associate
      end do

   contains

      !> Say why two surfaces cannot touch.
      subroutine add_trouble(index, trouble)
         !> Index of the contact.
         integer, intent(in) :: index
         !> One of the `trouble_*` codes.
         integer, intent(in) :: trouble
         character(len=:), allocatable :: right

         right = "surfaces that are closest in one point"
         if (trouble == trouble_no_spot) right = &
            "one of these two, or curvatures that differ less"
         associate (spec => scene%contacts(index))
            call diagnostics%add(contact_place(settings, index), "surfaces " // &
               quote(scene%surfaces(spec%surfaces(1))%name) // " and " // &
               quote(scene%surfaces(spec%surfaces(2))%name) // " of contact " // &
               quote(spec%name) // " at the beginning: " // trouble_text(trouble), right)
         end associate
      end subroutine add_trouble

      !> What reduces that bound.
      pure function less_in_hollow(contact) result(text)
         type(contact_spec_type), intent(in) :: contact
         character(len=:), allocatable :: text

         text = ""
         if (any(scene%surfaces(contact%surfaces)%surface%inside)) text = &
            ", less in a concave surface"
      end function less_in_hollow

      !> A number with four digits.
      function short(x) result(text)
         !> The number.
         real(wp), intent(in) :: x
         character(len=:), allocatable :: text
         character(len=16) :: digits

         write(digits, "(es10.3)") x
         text = trim(adjustl(digits))
         if (x >= 1.0e-2_wp .and. x < 1.0e3_wp) text = to_text(x)
      end function short

   end subroutine check_overlaps

   !> Index of what a reference names; 0 for the ground, or after a mistake.
   subroutine refer(settings, instance, key, slot, index, diagnostics)
      !> All settings.
      type(settings_type), intent(in) :: settings
      !> The group that refers.
      type(group_settings_type), intent(in) :: instance
      !> The key that refers.
      character(len=*), intent(in) :: key
      !> Which of its values.
      integer, intent(in) :: slot
      !> Number of the group among those of its kind.
      integer, intent(out) :: index
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics
      type(string_type), allocatable :: names(:)
      type(group_spec_type), allocatable :: groups(:)
      character(len=:), allocatable :: wanted, target
      integer :: i, n, near

      index = 0
      groups = schema_groups()
      associate (setting => instance%settings(instance%at(key)))
         if (.not. setting%set) return
         target = trim(setting%key%target)
         wanted = lower(setting%text(slot)%s)
         if (target == "body" .and. wanted == "ground") return
         allocate(names(count_of(settings, target) + 1))
         ! The last candidate is the predeclared body.
         names(size(names))%s = trim(merge("ground", "      ", target == "body"))
         n = 0
         do i = 1, size(settings%instances)
            if (settings%instances(i)%settings(1)%key%group /= target) cycle
            n = n + 1
            names(n)%s = settings%instances(i)%label()
            ! A name that could not be read may be the one.
            if (names(n)%s == "") return
            if (lower(names(n)%s) == wanted) index = n
         end do
         if (index > 0 .or. any(settings%lost .and. groups%name == target)) return
         near = nearest(wanted, names)
         if (near > 0) then
            call diagnostics%add(setting%places(slot), "there is no " // target // " " // &
               quote(setting%text(slot)%s), quote(names(near)%s))
         else
            call diagnostics%add(setting%places(slot), "there is no " // target // " " // &
               quote(setting%text(slot)%s), "the name of a group &" // target)
         end if
      end associate
   end subroutine refer

   !> Number of groups of a kind.
   pure function count_of(settings, group) result(n)
      !> All settings.
      type(settings_type), intent(in) :: settings
      !> Name of the group.
      character(len=*), intent(in) :: group
      integer :: n
      integer :: i

      n = 0
      do i = 1, size(settings%instances)
         if (settings%instances(i)%settings(1)%key%group == group) n = n + 1
      end do
   end function count_of

end module contensou_scene_reader
