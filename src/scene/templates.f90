!> What stands for other groups of a scene or gives them values: constants, defaults, bodies with a
!> `count`, bearings and contacts of patterns. It is worked out in the document, before keys are
!> looked at, so that what comes of it is read, checked and set as if it had been written.
module contensou_scene_templates
   use contensou_base_constants, only : has_constants, take_constants
   use contensou_base_diagnostics, only : diagnostics_type
   use contensou_base_document, only : constants_group, document_type, group_type
   use contensou_base_names, only : names_type
   use contensou_base_schema, only : schema_type
   use contensou_base_text, only : lower, string_type
   use contensou_scene_bearing, only : bearing_group, expand_bearings
   use contensou_scene_defaults, only : apply_defaults, defaults_group
   use contensou_scene_overrides, only : apply_override, index_groups, index_type, name_of, &
      object_of_override, text_of
   use contensou_scene_pair_patterns, only : expand_pairs, pairs_group
   use contensou_scene_repeats, only : expand_repeats, repeat_keys
   implicit none(type, external)
   private

   public :: has_templates, template_names, concerns_templates, expand_templates

contains

   !> Whether there is something to work out.
   pure logical function has_templates(document, overrides)
      type(document_type), intent(in) :: document
      !> Texts of the `--set` options.
      type(string_type), intent(in) :: overrides(:)
      integer :: i

      has_templates = has_constants(document)
      do i = 1, document%n_groups
         has_templates = has_templates .or. is_template(document%groups(i))
      end do
      do i = 1, size(overrides)
         has_templates = has_templates .or. repeats(overrides(i)%s) .or. &
            object_of_override(overrides(i)%s) == defaults_group
      end do
   end function has_templates

   !> Whether a group is worked out.
   pure logical function is_template(group)
      type(group_type), intent(in) :: group

      select case (group%name)
      case (bearing_group, constants_group, defaults_group, pairs_group)
         is_template = .true.
      case ("body")
         is_template = group%gives("count")
      case default
         is_template = .false.
      end select
   end function is_template

   !> Whether `--set PATH=VALUE` says how often a body is there.
   pure logical function repeats(override)
      !> Text after `--set`.
      character(len=*), intent(in) :: override
      character(len=:), allocatable :: path
      integer :: i

      path = lower(trim(adjustl(override(:max(index(override, "=") - 1, 0)))))
      i = index(path, "(")
      if (i > 0) path = path(:i - 1)
      repeats = any(repeat_keys == path(index(path, ".", back=.true.) + 1:)) .and. &
         index(path, "parameter.") == 0
   end function repeats

   !> Names of what other groups are made from, materials among them.
   pure function template_names(document) result(names)
      type(document_type), intent(in) :: document
      type(names_type) :: names
      type(names_type) :: bodies
      character(len=:), allocatable :: name
      integer :: i

      do i = 1, document%n_groups
         if (document%groups(i)%name /= "body") cycle
         if (is_template(document%groups(i))) call bodies%add(name_of(document%groups(i)), i)
      end do
      call names%add("material", 1)
      ! The group may be one that is set only.
      call names%add(defaults_group, 1)
      do i = 1, document%n_groups
         associate (group => document%groups(i))
            if (group%name == "surface") then
               if (bodies%find(text_of(group, "body")) == 0) cycle
            else if (.not. (is_template(group) .or. group%name == "material")) then
               cycle
            end if
            ! All bodies or surfaces are those that come of the templates, too.
            if (all(group%name /= [character(len=7) :: "body", "surface"])) call &
               names%add(group%name, 1)
            name = name_of(group)
            if (name == "") cycle
            call names%add(name, 1)
            call names%add(group%name // "." // name, 1)
         end associate
      end do
   end function template_names

   !> Whether `--set PATH=VALUE` changes what other groups are made from. All else is to be set
   !> when they are there, so that it finds them, too.
   pure logical function concerns_templates(names, override)
      !> From `template_names`.
      type(names_type), intent(in) :: names
      !> Text after `--set`.
      character(len=*), intent(in) :: override

      concerns_templates = names%find(object_of_override(override)) > 0 .or. repeats(override)
   end function concerns_templates

   !> Apply overrides and work everything out: first what concerns the templates, then the rest,
   !> which may concern what came of them.
   subroutine expand_templates(document, schema, overrides, diagnostics)
      !> The document; it is no longer complete when something could not be worked out.
      type(document_type), intent(inout) :: document
      type(schema_type), intent(in), target :: schema
      !> Texts of the `--set` options.
      type(string_type), intent(in) :: overrides(:)
      type(diagnostics_type), intent(inout) :: diagnostics
      type(index_type) :: index_of
      type(names_type) :: names
      type(diagnostics_type) :: ignored
      logical :: first(size(overrides))
      integer :: i

      names = template_names(document)
      call index_groups(document, schema, index_of)
      do i = 1, size(overrides)
         first(i) = concerns_templates(names, overrides(i)%s)
         if (.not. first(i)) cycle
         call apply_override(document, schema, index_of, overrides(i)%s, diagnostics)
      end do
      call take_constants(document, diagnostics)
      if (any([(document%groups(i)%name == defaults_group, i=1, document%n_groups)])) then
         call index_groups(document, schema, index_of)
         ! What is set for a group decides on what it has a use for; what comes of the templates is
         ! not there yet.
         do i = 1, size(overrides)
            if (.not. first(i)) call apply_override(document, schema, index_of, overrides(i)%s, &
               ignored)
         end do
         call apply_defaults(document, schema, diagnostics)
      end if
      call expand_repeats(document, schema, diagnostics)
      call expand_bearings(document, schema, diagnostics)
      call expand_pairs(document, schema, diagnostics)
      if (.not. document%complete) return
      ! What would have come of something that was left out is not unknown.
      if (size(overrides) == 0) return
      call index_groups(document, schema, index_of)
      do i = 1, size(overrides)
         if (.not. first(i) .and. document%complete) call apply_override(document, schema, &
            index_of, overrides(i)%s, diagnostics)
      end do
   end subroutine expand_templates

end module contensou_scene_templates
