!> Reads a scene: document, settings, cross references; every mistake is reported at once.
module contensou_scene_reader
   use contensou_base_constants, only : constants_text
   use contensou_base_diagnostics, only : diagnostics_type, origin_type
   use contensou_base_document, only : constants_group, document_type, parse_document, &
      read_document
   use contensou_base_errors, only : error_type, fatal, status_usage
   use contensou_base_numbers, only : to_text
   use contensou_base_kinds, only : wp
   use contensou_base_resolve, only : refuse_other_kind, resolve
   use contensou_base_rotations, only : rotation_matrix
   use contensou_base_schema, only : schema_type
   use contensou_base_settings, only : group_settings_type, settings_type
   use contensou_base_text, only : string_type
   use contensou_base_text_lock, only : lock_texts, unlock_texts
   use contensou_contact_parts, only : part_type, shared_parts
   use contensou_contact_surface, only : read_surface
   use contensou_dynamics_assembly, only : assemble
   use contensou_dynamics_equations, only : system_type
   use contensou_dynamics_scene, only : scene_type
   use contensou_scene_bodies, only : build_body
   use contensou_scene_checks, only : check_contacts, check_impacts, check_overlaps, &
      check_positions, check_rows, fill_in
   use contensou_scene_contacts, only : add_spots, build_contact, creeps
   use contensou_scene_controls, only : build_integrator, build_output, build_scene
   use contensou_scene_cost, only : build_cost, cost_spec_type
   use contensou_scene_defaults, only : defaults_group
   use contensou_scene_overrides, only : apply_override, index_groups, index_type
   use contensou_scene_pair_patterns, only : pairs_group
   use contensou_scene_placing, only : place_bodies
   use contensou_scene_references, only : collect_names, references_type
   use contensou_scene_schema, only : scene_schema
   use contensou_scene_solids, only : weigh_bodies
   use contensou_scene_springs, only : build_spring, complete_springs, spring_group
   use contensou_scene_stops, only : build_stop, complete_stops
   use contensou_scene_templates, only : expand_templates, has_templates
   use contensou_scene_warnings, only : find_warnings
   implicit none(type, external)
   private

   public :: read_scene, scene_file_type, moved_scene_text
   public :: load_scene, mistakes_text, resolve_scene, build_case, loaded_scene_type

   !> A scene with the texts it came from.
   type :: scene_file_type
      type(scene_type) :: scene
      !> What `contensou cost` runs.
      type(cost_spec_type) :: cost
      !> Its equations of motion, as assembled when it was checked.
      type(system_type), allocatable :: system
      !> Text of the file as read.
      character(len=:), allocatable :: text
      !> All settings with defaults and overrides, as a namelist text.
      character(len=:), allocatable :: resolved
      !> What is legal in it and hardly meant, ready to be shown; empty for nothing.
      character(len=:), allocatable :: warnings
      !> Number of these warnings.
      integer :: n_warnings = 0
   end type scene_file_type

   !> A scene that others are made from by a change of some of its settings.
   type :: loaded_scene_type
      character(len=:), allocatable :: path
      !> The groups and keys that there are.
      type(schema_type) :: schema
      !> The file as parsed, if something in it stands for other groups or gives them values.
      type(document_type) :: raw
      !> With overrides and the parts of templates, and with the texts of the overrides as sources.
      type(document_type) :: document
      !> All groups, also those that may be left out: the groups of `document` first, in their
      !> order, if it has no mistake. Nothing is derived yet.
      type(settings_type) :: settings
      !> The same with what is derived.
      type(settings_type) :: complete
      type(scene_file_type) :: file
   end type loaded_scene_type

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
      type(document_type) :: document
      type(diagnostics_type) :: diagnostics

      call lock_texts()
      call read_document(path, document, diagnostics, error)
      if (.not. allocated(error)) call read_parsed(path, document, overrides, output_file, file, &
         diagnostics, error)
      call unlock_texts()
   end subroutine read_scene

   !> Text of a scene whose bodies begin elsewhere, with all settings. Thread-safe.
   subroutine moved_scene_text(path, overrides, moved, text, error)
      !> Name of the scene file.
      character(len=*), intent(in) :: path
      !> Texts of the `--set` options.
      type(string_type), intent(in) :: overrides(:)
      !> The scene as read, but for positions and attitudes of its bodies.
      type(scene_type), intent(in) :: moved
      character(len=:), allocatable, intent(out) :: text
      !> Set when the file cannot be read any more.
      type(error_type), allocatable, intent(out) :: error
      type(loaded_scene_type), target :: loaded
      type(diagnostics_type) :: diagnostics
      type(settings_type), target :: settings
      type(scene_type) :: scene
      type(cost_spec_type) :: cost
      type(system_type), allocatable :: system
      type(references_type) :: references
      type(group_settings_type) :: group
      integer :: i, n

      call lock_texts()
      call load_scene(path, overrides, loaded, diagnostics, error)
      if (.not. allocated(error) .and. diagnostics%count() > 0) call fatal(error, path // &
         " has changed since it was read", status_usage)
      if (.not. allocated(error)) then
         settings = loaded%settings
         call build(settings, loaded%schema, path, "", scene, cost, system, diagnostics)
         call collect_names(settings, loaded%schema, references, diagnostics)
         do i = 1, size(settings%groups)
            group = settings%group(i, loaded%schema)
            if (group%group_name() /= "body") cycle
            n = references%numbers(i)
            associate (body => moved%bodies(n), before => scene%bodies(n))
               if (any(abs(body%position - before%position) > 0.0_wp)) call &
                  group%derive_numbers("position", body%position)
               if (all(abs(body%quaternion - before%quaternion) <= 0.0_wp)) cycle
               if (group%is_set("axis")) call group%unset("axis")
               if (group%is_set("angle")) call group%unset("angle")
               call group%derive_numbers("quaternion", body%quaternion)
               ! The same in the inertial frame, whatever the axes of the body.
               if (group%is_set("angular_velocity")) cycle
               if (any(abs(body%spin) > 0.0_wp)) call group%derive_numbers("spin", matmul( &
                  matmul(rotation_matrix(before%quaternion), before%spin), &
                  rotation_matrix(body%quaternion)))
            end associate
         end do
         text = constants_text(loaded%document%constants) // settings%text(loaded%schema)
      end if
      call unlock_texts()
   end subroutine moved_scene_text

   !> Make a scene of a document.
   subroutine read_parsed(path, document, overrides, output_file, file, diagnostics, error)
      !> Name of the scene file.
      character(len=*), intent(in) :: path
      !> The file as parsed; it is changed.
      type(document_type), intent(inout) :: document
      !> Texts of the `--set` options.
      type(string_type), intent(in) :: overrides(:)
      !> Name of the output file from the command line; blank for that of the scene.
      character(len=*), intent(in) :: output_file
      type(scene_file_type), intent(inout) :: file
      !> Mistakes so far.
      type(diagnostics_type), intent(inout) :: diagnostics
      !> Set with all mistakes found; nothing of `file` is to be used then.
      type(error_type), allocatable, intent(out) :: error
      type(schema_type), target :: schema
      type(settings_type), target :: settings
      logical :: refused

      call refuse_sweep(document, path, diagnostics, refused)
      if (.not. refused) then
         call scene_schema(schema)
         call resolve_scene(document, schema, overrides, settings, diagnostics)
         call build(settings, schema, path, output_file, file%scene, file%cost, file%system, &
            diagnostics)
      end if
      if (diagnostics%count() > 0) then
         call fatal(error, mistakes_text(diagnostics, document, path), status_usage)
         return
      end if
      call move_alloc(document%bytes, file%text)
      file%resolved = constants_text(document%constants) // settings%text(schema)
      call keep_warnings(settings, schema, document, file)
   end subroutine read_parsed

   !> Refuse the file of a sweep.
   subroutine refuse_sweep(document, path, diagnostics, refused)
      type(document_type), intent(in) :: document
      !> Its name.
      character(len=*), intent(in) :: path
      type(diagnostics_type), intent(inout) :: diagnostics
      logical, intent(out) :: refused

      call refuse_other_kind(document, "scene", "sweep", "this is a sweep, not a scene", &
         "contensou sweep " // path // ", or the scene that its key 'scene' names", &
         diagnostics, refused)
   end subroutine refuse_sweep

   !> All mistakes of a scene in words.
   function mistakes_text(diagnostics, document, path) result(text)
      type(diagnostics_type), intent(in) :: diagnostics
      !> The scene as parsed.
      type(document_type), intent(in) :: document
      !> Name of the scene file.
      character(len=*), intent(in) :: path
      character(len=:), allocatable :: text
      character(len=:), allocatable :: count_text

      count_text = to_text(diagnostics%count()) // " errors"
      if (diagnostics%count() == 1) count_text = "1 error"
      text = diagnostics%render(document%sources) // count_text // " in " // path // &
         "; nothing was run"
   end function mistakes_text

   !> Read a scene file or a text, apply overrides, check everything, and keep what other scenes can
   !> be made from.
   subroutine load_scene(path, overrides, loaded, diagnostics, error, text)
      !> Name of the scene file, or of the text in messages.
      character(len=*), intent(in) :: path
      !> Texts of the `--set` options.
      type(string_type), intent(in) :: overrides(:)
      !> The scene; of use only if there are no mistakes.
      type(loaded_scene_type), intent(out), target :: loaded
      !> Mistakes are appended here; their sources are those of `loaded%document`.
      type(diagnostics_type), intent(inout) :: diagnostics
      type(error_type), allocatable, intent(out) :: error
      !> The text, in place of a file.
      character(len=*), intent(in), optional :: text
      logical :: refused

      loaded%path = path
      if (present(text)) then
         call parse_document(path, text, loaded%document, diagnostics)
         loaded%file%text = text
      else
         call read_document(path, loaded%document, diagnostics, error)
         if (allocated(error)) return
         loaded%file%text = loaded%document%bytes
      end if
      call refuse_sweep(loaded%document, path, diagnostics, refused)
      if (refused) return
      if (has_templates(loaded%document, overrides)) loaded%raw = loaded%document
      call scene_schema(loaded%schema)
      call resolve_scene(loaded%document, loaded%schema, overrides, loaded%settings, diagnostics)
      loaded%complete = loaded%settings
      call build(loaded%complete, loaded%schema, path, "", loaded%file%scene, loaded%file%cost, &
         loaded%file%system, diagnostics)
      if (diagnostics%count() > 0) return
      loaded%file%resolved = constants_text(loaded%document%constants) // &
         loaded%complete%text(loaded%schema)
      call keep_warnings(loaded%complete, loaded%schema, loaded%document, loaded%file)
   end subroutine load_scene

   !> Look for what is legal in a scene and hardly meant.
   subroutine keep_warnings(settings, schema, document, file)
      type(settings_type), intent(in), target :: settings
      type(schema_type), intent(in), target :: schema
      !> The sources of the settings.
      type(document_type), intent(in) :: document
      type(scene_file_type), intent(inout) :: file
      type(diagnostics_type) :: warnings

      call find_warnings(settings, schema, file%scene, file%system, warnings)
      file%warnings = warnings%render(document%sources, "warning")
      file%n_warnings = warnings%count()
   end subroutine keep_warnings

   !> Apply overrides to a scene as parsed and check each of its settings.
   subroutine resolve_scene(document, schema, overrides, settings, diagnostics)
      !> The file as parsed; it gets overrides and the parts of templates.
      type(document_type), intent(inout) :: document
      type(schema_type), intent(in), target :: schema
      !> Texts of the `--set` options.
      type(string_type), intent(in) :: overrides(:)
      type(settings_type), intent(out) :: settings
      type(diagnostics_type), intent(inout) :: diagnostics
      type(index_type) :: index_of
      integer :: i

      if (has_templates(document, overrides)) then
         call expand_templates(document, schema, overrides, diagnostics)
      else if (size(overrides) > 0) then
         call index_groups(document, schema, index_of)
         do i = 1, size(overrides)
            call apply_override(document, schema, index_of, overrides(i)%s, diagnostics)
         end do
      end if
      call resolve(document, schema, settings, diagnostics)
      call settings%add_missing(schema)
   end subroutine resolve_scene

   !> Build a scene from settings in which values were changed. Thread-safe.
   subroutine build_case(settings, schema, path, file, diagnostics)
      !> The settings, as `resolve_scene` makes them; derived values are filled in.
      type(settings_type), intent(inout), target :: settings
      type(schema_type), intent(in), target :: schema
      !> Name of the scene file.
      character(len=*), intent(in) :: path
      !> The scene; its texts are not set.
      type(scene_file_type), intent(out) :: file
      type(diagnostics_type), intent(inout) :: diagnostics

      call build(settings, schema, path, "", file%scene, file%cost, file%system, diagnostics)
   end subroutine build_case

   !> Build the scene from its settings; references and everything that concerns several keys are
   !> checked here.
   subroutine build(settings, schema, path, output_file, scene, cost, system, diagnostics)
      !> The settings; derived values are filled in.
      type(settings_type), intent(inout), target :: settings
      type(schema_type), intent(in), target :: schema
      !> Name of the scene file.
      character(len=*), intent(in) :: path
      !> Name of the output file from the command line; blank for that of the scene.
      character(len=*), intent(in) :: output_file
      type(scene_type), intent(out) :: scene
      type(cost_spec_type), intent(out) :: cost
      !> Its equations of motion; not allocated after a mistake.
      type(system_type), allocatable, intent(out) :: system
      type(diagnostics_type), intent(inout) :: diagnostics
      type(references_type) :: references
      type(part_type), pointer :: parts(:)
      type(group_settings_type) :: group
      type(origin_type), allocatable :: places(:), body_places(:), stop_places(:)
      type(origin_type) :: interval_place, impacts_place
      logical :: told
      integer :: i, n

      told = .false.
      call collect_names(settings, schema, references, diagnostics)
      allocate(scene%materials(references%count(schema%find("material"))))
      allocate(scene%bodies(references%count(schema%find("body"))))
      allocate(scene%surfaces(references%count(schema%find("surface"))))
      allocate(scene%contacts(references%count(schema%find("contact"))))
      allocate(scene%springs(references%count(schema%find(spring_group))))
      allocate(scene%stops(references%count(schema%find("stop"))))
      allocate(places(size(scene%contacts)), body_places(size(scene%bodies)), &
         stop_places(size(scene%stops)))
      interval_place = origin_type(1, 0, 0, 1)
      impacts_place = interval_place
      parts => shared_parts()
      do i = 1, size(settings%groups)
         group = settings%group(i, schema)
         n = references%numbers(i)
         select case (group%group_name())
         case ("scene")
            call build_scene(group, scene)
            impacts_place = group%place("impacts", 1)
         case ("material")
            associate (material => scene%materials(n))
               material%name = group%label()
               material%young = group%number("young")
               material%poisson = group%number("poisson")
            end associate
         case ("body")
            call build_body(group, scene%bodies(n), diagnostics)
            body_places(n) = group%place("position", maxloc(abs(scene%bodies(n)%position), dim=1))
         case ("surface")
            associate (surface => scene%surfaces(n))
               surface%name = group%label()
               call references%find(group, "body", 1, surface%body, diagnostics)
               call references%find(group, "material", 1, surface%material, diagnostics)
               call read_surface(group, surface%surface, surface%sizes, diagnostics)
            end associate
         case ("contact")
            call build_contact(group, references, parts, scene%contacts(n), diagnostics)
            places(n) = group%place("surfaces")
         case (spring_group)
            call build_spring(group, references, scene%springs(n), diagnostics)
         case ("stop")
            call build_stop(group, references, scene%stops(n), diagnostics)
            stop_places(n) = group%place("when", 1)
         case ("integrator")
            call build_integrator(group, scene%integrator)
         case ("output")
            call build_output(group, path, output_file, scene)
            told = group%is_given("rolling")
            interval_place = group%place("interval", 1)
         case (constants_group, defaults_group, pairs_group)
            ! Taken from the document before its keys were looked at, if they had no mistake.
            continue
         case ("cost")
            call build_cost(group, cost, diagnostics)
         case default
            error stop "the schema has a group that no scene is built from"
         end select
      end do
      call weigh_bodies(settings, schema, references, scene, diagnostics)
      if (diagnostics%count() > 0) return
      if (.not. told) scene%output%rolling = any([(creeps(scene%contacts(i)), &
         i=1, size(scene%contacts))])
      call check_contacts(scene, places, diagnostics)
      call check_impacts(scene, impacts_place, diagnostics)
      call check_rows(scene, interval_place, diagnostics)
      call complete_springs(settings, schema, references, scene, diagnostics)
      call complete_stops(scene, stop_places, diagnostics)
      if (diagnostics%count() > 0) return
      call add_spots(scene, places, diagnostics)
      if (diagnostics%count() > 0) return
      allocate(system)
      call assemble(scene, system)
      call place_bodies(settings, schema, references, scene, system, diagnostics)
      if (diagnostics%count() > 0) return
      call fill_in(settings, schema, scene, system)
      call check_positions(scene, system, body_places, diagnostics)
      if (diagnostics%count() > 0) return
      call check_overlaps(scene, system, places, diagnostics)
   end subroutine build

end module contensou_scene_reader
