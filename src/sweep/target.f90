!> What a path such as `top.position(3)` of a sweep stands for in its base scene: found once, set
!> in each case without a look at the path.
module contensou_sweep_target
   use contensou_base_diagnostics, only : diagnostics_type, origin_type
   use contensou_base_document, only : value_logical, value_real, value_text, value_type
   use contensou_base_kinds, only : wp
   use contensou_base_settings, only : domain_text, key_type, kind_choice, kind_logical, &
      kind_name, kind_real, kind_reference, kind_text, setting_type
   use contensou_base_text, only : lower, nearest, quote, string_type, to_text
   use contensou_scene_bearing, only : concerns_bearings, has_bearings
   use contensou_scene_reader, only : loaded_scene_type
   use contensou_scene_schema, only : choices_of, group_spec_type, schema_groups, schema_keys
   use contensou_scene_settings, only : find_path, path_type, settings_type, take_value
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
      integer, allocatable :: instances(:)
      !> Position of the key in each of them.
      integer :: position = 0
      !> Whether a bearing has to be expanded again when it changes.
      logical :: expands = .false.
      !> Names that a reference may take.
      type(string_type), allocatable :: names(:)
   contains
      !> Whether the values are texts.
      procedure :: is_text
      !> Check a value.
      procedure :: check
      !> Give the key a value.
      procedure :: set
      !> Whether it has a value in common with another one.
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
      !> What it stands for.
      type(target_type), intent(out) :: target
      !> Whether it is in order.
      logical, intent(out) :: found
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics
      type(path_type) :: path
      type(key_type), allocatable :: keys(:), own(:)
      type(group_spec_type), allocatable :: groups(:)
      character(len=:), allocatable :: group
      logical :: given
      integer :: g, i, k

      target%path = lower(trim(adjustl(text)))
      if (has_bearings(scene%raw)) target%expands = concerns_bearings(scene%raw, target%path // "=")
      if (target%expands) then
         call find_path(scene%raw, target%path, origin, path, found, diagnostics)
      else
         call find_path(scene%document, target%path, origin, path, found, diagnostics)
      end if
      if (.not. found) return
      found = .false.
      group = path%object
      if (.not. path%add_group) then
         i = findloc(path%hit, .true., dim=1)
         if (target%expands) then
            group = scene%raw%groups(i)%name
         else
            group = scene%document%groups(i)%name
         end if
      end if
      keys = schema_keys()
      own = pack(keys, keys%group == group)
      k = findloc(own%name == path%key, .true., dim=1)
      if (k == 0) then
         k = nearest(path%key, own%name)
         if (k > 0) then
            call diagnostics%add(origin, "unknown key '" // path%key // "' in group &" // group, &
               path%object // "." // trim(own(k)%name))
         else
            call diagnostics%add(origin, "unknown key '" // path%key // "' in group &" // group, &
               "one of those that contensou help " // group // " lists")
         end if
         return
      end if
      target%key = own(k)
      target%position = k
      target%slot = max(path%element, 1)
      if (own(k)%kind == kind_name .or. own(k)%kind == kind_text .or. group == "cost") then
         call diagnostics%add(origin, "'" // target%path // &
            "' cannot vary: no motion depends on it")
         return
      end if
      if (group == "bearing" .and. (path%key == "ball_count" .or. path%key == "cage")) then
         call diagnostics%add(origin, "'" // target%path // &
            "' cannot vary: it changes which bodies there are")
         return
      end if
      if (path%element > own(k)%values) then
         call diagnostics%add(origin, "'" // path%key // "' has " // to_text(own(k)%values) // &
            trim(merge(" value ", " values", own(k)%values == 1)) // &
            ", the subscript is out of range", domain_text(own(k)))
         return
      end if
      if (path%element == 0 .and. own(k)%values > 1) then
         call diagnostics%add(origin, "'" // target%path // "' has " // to_text(own(k)%values) // &
            " values, a parameter is one", target%path // "(1), or another subscript")
         return
      end if

      if (target%expands) then
         allocate(target%instances(0))
      else if (path%add_group) then
         groups = schema_groups()
         g = findloc(groups%name == group, .true., dim=1)
         target%instances = [findloc(scene%settings%instances%group == g, .true., dim=1)]
      else
         ! The first groups of the settings are those of the document.
         target%instances = pack([(i, i=1, size(path%hit))], path%hit)
      end if
      if (own(k)%values > 1) then
         given = .true.
         do i = 1, size(target%instances)
            given = given .and. &
               scene%settings%instances(target%instances(i))%settings(k)%set
         end do
         if (.not. given) then
            call diagnostics%add(origin, "'" // target%path // "' is one of " // &
               to_text(own(k)%values) // " values, and the base scene does not give the others", &
               "all values of '" // path%key // "' in the base scene")
            return
         end if
      end if
      if (own(k)%kind == kind_reference) call collect_names(scene, target)
      found = .true.
   end subroutine find_target

   !> Names that a reference may take.
   subroutine collect_names(scene, target)
      !> The base scene.
      type(loaded_scene_type), intent(in) :: scene
      type(target_type), intent(inout) :: target
      integer :: i, n

      n = count([(scene%settings%instances(i)%settings(1)%key%group == target%key%target, &
         i=1, size(scene%settings%instances))])
      if (target%key%target == "body") n = n + 1
      allocate(target%names(n))
      n = 0
      do i = 1, size(scene%settings%instances)
         if (scene%settings%instances(i)%settings(1)%key%group /= target%key%target) cycle
         n = n + 1
         target%names(n)%s = scene%settings%instances(i)%label()
      end do
      if (n < size(target%names)) target%names(n + 1)%s = "ground"
   end subroutine collect_names

   !> Whether the values of a target are texts.
   pure function is_text(self)
      class(target_type), intent(in) :: self
      logical :: is_text

      is_text = self%key%kind /= kind_real
   end function is_text

   !> Check a value against the domain of the key.
   subroutine check(self, value, diagnostics, good)
      class(target_type), intent(in) :: self
      type(value_type), intent(in) :: value
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics
      !> Whether it is in order.
      logical, intent(out) :: good
      type(setting_type) :: setting
      integer :: i, near

      setting%key = self%key
      call take_value(value, setting, self%slot, trim(self%key%group), diagnostics, good)
      if (.not. good .or. .not. allocated(self%names)) return
      do i = 1, size(self%names)
         if (lower(self%names(i)%s) == lower(setting%text(self%slot)%s)) return
      end do
      good = .false.
      near = nearest(setting%text(self%slot)%s, self%names)
      if (near > 0) then
         call diagnostics%add(value%origin, "there is no " // trim(self%key%target) // " " // &
            quote(setting%text(self%slot)%s), quote(self%names(near)%s))
      else
         call diagnostics%add(value%origin, "there is no " // trim(self%key%target) // " " // &
            quote(setting%text(self%slot)%s), "the name of a group &" // trim(self%key%target))
      end if
   end subroutine check

   !> Give the key a value that was checked.
   subroutine set(self, value, settings)
      class(target_type), intent(in) :: self
      type(value_type), intent(in) :: value
      !> Settings of the base scene.
      type(settings_type), intent(inout) :: settings
      type(string_type), allocatable :: names(:)
      integer :: i, k

      do i = 1, size(self%instances)
         associate (setting => settings%instances(self%instances(i))%settings(self%position))
            setting%given = .true.
            setting%meant = .false.
            setting%set = .true.
            setting%n = self%key%values
            select case (self%key%kind)
            case (kind_real)
               setting%real(self%slot) = value%real
            case (kind_logical)
               setting%logical = value%logical
            case (kind_choice)
               names = choices_of(self%key)
               do k = 1, size(names)
                  if (names(k)%s /= lower(trim(adjustl(value%text)))) cycle
                  setting%text(self%slot)%s = names(k)%s
                  setting%choice = k
                  setting%choices(self%slot) = k
               end do
            case default
               setting%text(self%slot)%s = trim(adjustl(value%text))
            end select
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
         overlaps = any([(any(other%instances == self%instances(i)), i=1, size(self%instances))])
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
