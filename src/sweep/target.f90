!> What a path such as `top.position(3)` of a sweep stands for in its base scene: found once, set
!> in each case without a look at the path.
module contensou_sweep_target
   use contensou_base_diagnostics, only : diagnostics_type, origin_type
   use contensou_base_document, only : constants_group, value_logical, value_real, value_text, &
      value_type
   use contensou_base_kinds, only : wp
   use contensou_base_numbers, only : to_text
   use contensou_base_resolve, only : expected_of, take_value
   use contensou_base_schema, only : is_number, key_type, kind_choice, kind_file, kind_name, &
      kind_reference, kind_text, schema_type
   use contensou_base_settings, only : group_settings_type, new_setting, settings_type
   use contensou_base_text, only : lower, nearest, quote, string_type
   use contensou_scene_defaults, only : defaults_group
   use contensou_scene_overrides, only : find_path, index_groups, index_type, &
      object_of_override, path_type
   use contensou_scene_reader, only : loaded_scene_type
   use contensou_scene_repeats, only : repeat_keys
   use contensou_scene_templates, only : concerns_templates, template_names
   implicit none(type, external)
   private

   public :: target_type, find_target, value_words

   !> What a path stands for.
   type :: target_type
      !> The path, in lower case.
      character(len=:), allocatable :: path
      type(key_type) :: key
      !> Which value of the key; 1 if it has one.
      integer :: slot = 1
      !> Groups of the base scene's settings that have it.
      integer, allocatable :: groups(:)
      !> Position of the key in each of them.
      integer :: position = 0
      !> Whether a bearing has to be expanded again when it changes.
      logical :: expands = .false.
      !> Names that a reference may take.
      type(string_type), allocatable :: names(:)
   contains
      procedure :: is_text
      procedure :: check
      procedure :: set
      procedure :: overlaps
   end type target_type

contains

   !> Find what a path stands for.
   subroutine find_target(scene, text, origin, target, found, diagnostics)
      !> The base scene, without mistakes.
      type(loaded_scene_type), intent(in) :: scene
      !> The path.
      character(len=*), intent(in) :: text
      !> Where it stands, for messages.
      type(origin_type), intent(in) :: origin
      type(target_type), intent(out) :: target
      !> Whether it is in order.
      logical, intent(out) :: found
      type(diagnostics_type), intent(inout) :: diagnostics
      type(path_type) :: path
      type(index_type) :: index_of
      character(len=:), allocatable :: group
      integer :: g, k

      target%path = lower(trim(adjustl(text)))
      if (allocated(scene%raw%groups)) then
         target%expands = concerns_templates(template_names(scene%raw), target%path // "=")
      else
         target%expands = object_of_override(target%path // "=") == defaults_group
      end if
      if (target%expands .and. allocated(scene%raw%groups)) then
         call index_groups(scene%raw, scene%schema, index_of)
         call find_path(scene%raw, scene%schema, index_of, target%path, origin, path, found, &
            diagnostics)
      else
         call index_groups(scene%document, scene%schema, index_of)
         call find_path(scene%document, scene%schema, index_of, target%path, origin, path, found, &
            diagnostics)
      end if
      if (.not. found) return
      found = .false.
      group = path%object
      if (.not. path%add_group) then
         if (target%expands) then
            group = scene%raw%groups(path%groups(1))%name
         else
            group = scene%document%groups(path%groups(1))%name
         end if
      end if
      if (group == constants_group) then
         target%key%group = constants_group
         target%key%name = path%key
         allocate(target%groups(0))
         found = path%element == 0
         if (.not. found) call diagnostics%add(origin, "a constant has no subscript", &
            constants_group // "." // path%key)
         return
      end if
      g = scene%schema%find(group)
      associate (keys => scene%schema%groups(g)%keys)
         k = scene%schema%groups(g)%position(path%key)
         if (k == 0) then
            k = nearest(path%key, keys%name)
            if (k > 0) then
               call diagnostics%add(origin, "unknown key '" // path%key // "' in group &" // &
                  group, path%object // "." // trim(keys(k)%name))
            else
               call diagnostics%add(origin, "unknown key '" // path%key // "' in group &" // &
                  group, "one of those that contensou help " // group // " lists")
            end if
            return
         end if
         target%key = keys(k)
      end associate
      target%position = k
      target%slot = max(path%element, 1)
      call check_key(target, group, path, origin, diagnostics, found)
      if (.not. found) return
      if (target%expands) then
         allocate(target%groups(0))
      else if (path%add_group) then
         target%groups = [findloc(scene%settings%groups%kind, g, dim=1)]
      else
         ! The first groups of the settings are those of the document.
         target%groups = path%groups
      end if
      call check_others(scene, target, origin, diagnostics, found)
      if (found .and. target%key%kind == kind_reference) call collect_names(scene, target)
   end subroutine find_target

   !> Whether a key can vary.
   subroutine check_key(target, group, path, origin, diagnostics, good)
      type(target_type), intent(in) :: target
      character(len=*), intent(in) :: group
      type(path_type), intent(in) :: path
      !> Where it stands, for messages.
      type(origin_type), intent(in) :: origin
      type(diagnostics_type), intent(inout) :: diagnostics
      logical, intent(out) :: good

      good = .false.
      associate (key => target%key)
         if (any(key%kind == [kind_name, kind_text, kind_file]) .or. group == "cost") then
            call diagnostics%add(origin, "'" // target%path // &
               "' cannot vary: no motion depends on it")
         else if (group == "bearing" .and. any(path%key == [character(len=10) :: "ball_count", &
            "cage"])) then
            call diagnostics%add(origin, "'" // target%path // &
               "' cannot vary: it changes which bodies there are")
         else if (group == "body" .and. any(repeat_keys == path%key)) then
            call diagnostics%add(origin, "'" // target%path // &
               "' cannot vary: it changes which bodies there are")
         else if (path%element > key%values) then
            call diagnostics%add(origin, "'" // path%key // "' has " // to_text(key%values) // &
               trim(merge(" value ", " values", key%values == 1)) // &
               ", the subscript is out of range", expected_of(key))
         else if (path%element == 0 .and. key%values > 1) then
            call diagnostics%add(origin, "'" // target%path // "' has " // to_text(key%values) // &
               " values, a parameter is one", target%path // "(1), or another subscript")
         else
            good = .true.
         end if
      end associate
   end subroutine check_key

   !> Whether the other values of a key are there.
   subroutine check_others(scene, target, origin, diagnostics, good)
      type(loaded_scene_type), intent(in), target :: scene
      type(target_type), intent(in) :: target
      !> Where it stands, for messages.
      type(origin_type), intent(in) :: origin
      type(diagnostics_type), intent(inout) :: diagnostics
      logical, intent(out) :: good
      type(group_settings_type) :: group
      integer :: i

      good = .true.
      if (target%key%values == 1) return
      do i = 1, size(target%groups)
         group = scene%settings%group(target%groups(i), scene%schema)
         good = good .and. group%is_set(target%key%name)
      end do
      if (.not. good) call diagnostics%add(origin, "'" // target%path // "' is one of " // &
         to_text(target%key%values) // " values, and the base scene does not give the others", &
         "all values of '" // trim(target%key%name) // "' in the base scene")
   end subroutine check_others

   !> Names that a reference may take.
   subroutine collect_names(scene, target)
      !> The base scene.
      type(loaded_scene_type), intent(in), target :: scene
      type(target_type), intent(inout) :: target
      type(group_settings_type) :: group
      integer :: i, kind, n

      kind = scene%schema%find(target%key%target)
      n = count(scene%settings%groups%kind == kind)
      allocate(target%names(n + merge(1, 0, target%key%target == "body")))
      n = 0
      do i = 1, size(scene%settings%groups)
         if (scene%settings%groups(i)%kind /= kind) cycle
         n = n + 1
         group = scene%settings%group(i, scene%schema)
         target%names(n)%s = group%label()
      end do
      if (n < size(target%names)) target%names(n + 1)%s = "ground"
   end subroutine collect_names

   !> Whether the values of a target are texts.
   pure function is_text(self)
      class(target_type), intent(in) :: self
      logical :: is_text

      is_text = .not. is_number(self%key)
   end function is_text

   !> Take a value that the key may have.
   subroutine take(self, value, taken, diagnostics, good)
      class(target_type), intent(in) :: self
      type(value_type), intent(in) :: value
      !> The value as settings have it.
      type(value_type), intent(inout) :: taken
      type(diagnostics_type), intent(inout) :: diagnostics
      logical, intent(out) :: good
      type(string_type) :: none(0)

      if (self%key%kind == kind_choice) then
         call take_value(value, self%key, self%key%names(), taken, diagnostics, good)
      else
         call take_value(value, self%key, none, taken, diagnostics, good)
      end if
   end subroutine take

   !> Check a value against the domain of the key.
   subroutine check(self, value, diagnostics, good)
      class(target_type), intent(in) :: self
      type(value_type), intent(in) :: value
      type(diagnostics_type), intent(inout) :: diagnostics
      !> Whether it is in order.
      logical, intent(out) :: good
      type(value_type) :: taken
      character(len=:), allocatable :: right
      integer :: i, near

      call take(self, value, taken, diagnostics, good)
      if (.not. good .or. .not. allocated(self%names)) return
      do i = 1, size(self%names)
         if (lower(self%names(i)%s) == lower(taken%text)) return
      end do
      good = .false.
      right = "the name of a group &" // trim(self%key%target)
      near = nearest(taken%text, self%names)
      if (near > 0) right = quote(self%names(near)%s)
      call diagnostics%add(value%origin, "there is no " // trim(self%key%target) // " " // &
         quote(taken%text), right)
   end subroutine check

   !> Give the key a value that was checked.
   subroutine set(self, value, schema, settings)
      class(target_type), intent(in) :: self
      type(value_type), intent(in) :: value
      type(schema_type), intent(in) :: schema
      !> Settings of the base scene.
      type(settings_type), intent(inout) :: settings
      type(diagnostics_type) :: ignored
      integer :: i, s
      logical :: good

      do i = 1, size(self%groups)
         associate (stored => settings%groups(self%groups(i)))
            call new_setting(stored, schema%groups(stored%kind), self%position, s)
            stored%settings(s)%given = .true.
            stored%settings(s)%misspelt = .false.
            stored%settings(s)%set = .true.
            call take(self, value, stored%settings(s)%values(self%slot), ignored, good)
         end associate
      end do
   end subroutine set

   !> Whether two targets have a value in common.
   pure function overlaps(self, other)
      class(target_type), intent(in) :: self
      !> Another target.
      class(target_type), intent(in) :: other
      logical :: overlaps
      integer :: i

      overlaps = self%key%group == other%key%group .and. self%key%name == other%key%name .and. &
         self%slot == other%slot
      if (.not. overlaps) return
      if (self%expands .or. other%expands) then
         overlaps = object_of(self) == object_of(other) .or. &
            object_of(self) == self%key%group .or. object_of(other) == other%key%group
      else
         overlaps = any([(any(other%groups == self%groups(i)), i=1, size(self%groups))])
      end if
   end function overlaps

   !> Name in the path of a target: what stands before the key, without the name of a group.
   pure function object_of(target) result(object)
      type(target_type), intent(in) :: target
      character(len=:), allocatable :: object

      object = target%path(:index(target%path, ".", back=.true.) - 1)
      object = object(index(object, ".") + 1:)
   end function object_of

   !> A value as `--set` takes it.
   pure function value_words(value) result(text)
      type(value_type), intent(in) :: value
      character(len=:), allocatable :: text

      select case (value%kind)
      case (value_text)
         text = quote(value%text)
      case (value_logical)
         text = to_text(value%logical)
      case default
         text = to_text(value%real)
      end select
   end function value_words

end module contensou_sweep_target
