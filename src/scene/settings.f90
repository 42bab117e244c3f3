!> From a namelist document to checked settings: every key of every group with its value or
!> default, its origin, and every mistake reported.
module contensou_scene_settings
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite
   use contensou_base_diagnostics, only : diagnostics_type, origin_type
   use contensou_base_document, only : assignment_type, document_type, group_type, &
      parse_value_list, value_integer, value_logical, value_null, value_real, value_text, value_type
   use contensou_base_kinds, only : wp
   use contensou_base_settings, only : admits, domain_text, group_settings_type, key_type, &
      kind_choice, kind_logical, kind_name, kind_real, kind_reference, kind_text, most_values, &
      setting_type
   use contensou_base_text, only : join, lower, nearest, quote, string_type, strings, to_text
   use contensou_scene_schema, only : choices_of, group_spec_type, schema_groups, schema_keys
   implicit none(type, external)
   private

   public :: settings_type
   public :: path_type
   public :: resolve, apply_override, find_path, resolved_text, name_of, largest_number
   public :: expected_of, take_value, find_key, find_choice

   !> All groups.
   type :: settings_type
      !> The groups in the order of the file.
      type(group_settings_type), allocatable :: instances(:)
      !> For each group of the schema, whether some may be missing because of a mistake of syntax
      !> or because their name is misspelt.
      logical, allocatable :: lost(:)
   end type settings_type

   !> What a path such as `top.position(3)` stands for.
   type :: path_type
      !> Name of the group or of what it describes.
      character(len=:), allocatable :: object
      !> Name of the key.
      character(len=:), allocatable :: key
      !> Which of its values; 0 for all.
      integer :: element = 0
      !> Whether each group of the document is meant.
      logical, allocatable :: hit(:)
      !> Whether the document does not have the group, and it may be added.
      logical :: add_group = .false.
   end type path_type

   !> Bound of the magnitudes of numbers and of the inverses of those that are not zero, so that
   !> products of a few of them neither overflow nor vanish: SI values of this world are far within.
   real(wp), parameter :: largest_number = 1.0e40_wp

contains

   !> Replace or add values in a document, from `--set PATH=VALUE`.
   !>
   !> PATH is `group.key` (every group of that name; one is added if there is none and it does not
   !> repeat), `name.key`, or `group.name.key` where a name alone would be ambiguous; `(3)` after
   !> the key stands for the third of its values.
   subroutine apply_override(document, override, diagnostics)
      !> Document to change.
      type(document_type), intent(inout) :: document
      !> Text after `--set`.
      character(len=*), intent(in) :: override
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics
      type(value_type), allocatable :: values(:)
      type(path_type) :: path
      character(len=:), allocatable :: source_name
      type(origin_type) :: origin
      integer :: equals, i, n_before
      logical :: found

      source_name = "--set " // override
      equals = index(override, "=")
      n_before = diagnostics%count()
      if (equals == 0) then
         call parse_value_list(source_name, override, values, document, diagnostics, .true.)
         origin = origin_type(size(document%sources), 0, 0, 1)
         if (diagnostics%count() == n_before) call diagnostics%add(origin, &
            "'=' is missing", "--set group.key=value or --set name.key=value")
         return
      end if
      call parse_value_list(source_name, override(equals + 1:), values, document, diagnostics, &
         .true.)
      origin = origin_type(size(document%sources), 0, 0, 1)
      if (diagnostics%count() > n_before) return
      do i = 1, size(document%sources)
         if (document%sources(i)%name == source_name) origin%source = i
      end do
      call find_path(document, override(:equals - 1), origin, path, found, diagnostics)
      if (.not. found) return
      if (path%add_group) call add_group(document, path%object, origin)
      if (path%element > 0 .and. size(values) /= 1) then
         call diagnostics%add(origin, "'" // path%key // "(" // &
            to_text(path%element) // ")' is one value", "one value")
         return
      end if
      do i = 1, document%n_groups
         if (i > size(path%hit)) then
            call set_key(document%groups(i), path%key, path%element, values, origin)
         else if (path%hit(i)) then
            call set_key(document%groups(i), path%key, path%element, values, origin)
         end if
      end do
   end subroutine apply_override

   !> Find what a path stands for, as `apply_override` takes it.
   subroutine find_path(document, text, origin, path, found, diagnostics)
      !> Document to look into.
      type(document_type), intent(in) :: document
      !> The path.
      character(len=*), intent(in) :: text
      !> Where it stands, for messages.
      type(origin_type), intent(in) :: origin
      !> What it stands for.
      type(path_type), intent(out) :: path
      !> Whether there is such a group.
      logical, intent(out) :: found
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics
      type(key_type), allocatable :: keys(:)
      type(group_spec_type), allocatable :: groups(:)
      type(string_type), allocatable :: names(:)
      character(len=:), allocatable :: whole, names_found
      logical :: any_group
      integer :: dot, i, first_dot

      found = .false.
      whole = lower(trim(adjustl(text)))
      call split_element(whole, path%element)
      dot = index(whole, ".", back=.true.)
      if (dot <= 1 .or. dot == len(whole) .or. path%element < 0) then
         call diagnostics%add(origin, "'" // lower(trim(adjustl(text))) // &
            "' does not say what to set", "group.key or name.key, as integrator.rtol")
         return
      end if
      path%object = whole(:dot - 1)
      path%key = whole(dot + 1:)
      keys = schema_keys()
      groups = schema_groups()

      allocate(path%hit(document%n_groups), source=.false.)
      associate (hit => path%hit, object => path%object, key => path%key)
         any_group = any(groups%name == object)
         names_found = ""
         if (any_group) then
            do i = 1, document%n_groups
               hit(i) = document%groups(i)%name == object
            end do
            path%add_group = .not. any(hit) .and. any(groups%name == object .and. &
               .not. groups%repeats)
         else
            first_dot = index(object, ".")
            do i = 1, document%n_groups
               hit(i) = name_of(document%groups(i)) == object
               if (first_dot > 0) hit(i) = hit(i) .or. (document%groups(i)%name == &
                  object(:first_dot - 1) .and. name_of(document%groups(i)) == &
                  object(first_dot + 1:))
               if (hit(i)) hit(i) = any(keys%group == document%groups(i)%name .and. &
                  keys%name == key) .or. .not. any(keys%name == key)
               if (hit(i)) names_found = names_found // " " // trim(document%groups(i)%name) // &
                  "." // object // "." // key
            end do
            if (count(hit) > 1) then
               call diagnostics%add(origin, "'" // whole // "' is ambiguous", &
                  "one of" // names_found)
               return
            end if
         end if
         found = any(hit) .or. path%add_group
         if (found) return
         allocate(names(size(groups) + document%n_groups))
         do i = 1, size(groups)
            names(i)%s = trim(groups(i)%name)
         end do
         do i = 1, document%n_groups
            names(size(groups) + i)%s = name_of(document%groups(i))
         end do
         i = nearest(object, names)
         if (any_group) then
            call diagnostics%add(origin, "the scene has no group &" // object)
         else if (i > 0) then
            call diagnostics%add(origin, "the scene has no group or name '" // object // "'" // &
               " with a key '" // key // "'", names(i)%s // "." // key)
         else
            call diagnostics%add(origin, "the scene has no group or name '" // object // "'", &
               "the name of a group, or of a body, surface, material or contact")
         end if
      end associate
   end subroutine find_path

   !> Take the subscript of an element from the end of a path.
   pure subroutine split_element(path, element)
      !> The path; the subscript is removed.
      character(len=:), allocatable, intent(inout) :: path
      !> The subscript; 0 if there is none, -1 if it is none.
      integer, intent(out) :: element
      integer :: open, stat

      element = 0
      open = index(path, "(")
      if (open == 0) return
      element = -1
      if (path(len(path):) /= ")" .or. len(path) - open < 2 .or. len(path) - open > 4) return
      if (verify(path(open + 1:len(path) - 1), "0123456789") > 0) return
      read(path(open + 1:len(path) - 1), *, iostat=stat) element
      if (stat /= 0 .or. element == 0) element = -1
      path = trim(path(:open - 1))
   end subroutine split_element

   !> Name that a group of a document gives itself, in lower case; blank if none.
   pure function name_of(group) result(name)
      type(group_type), intent(in) :: group
      character(len=:), allocatable :: name
      integer :: i

      name = ""
      do i = 1, group%n_assignments
         if (group%assignments(i)%key /= "name") cycle
         if (size(group%assignments(i)%values) /= 1) cycle
         if (group%assignments(i)%values(1)%kind == value_text) then
            name = lower(trim(group%assignments(i)%values(1)%text))
         end if
      end do
   end function name_of

   !> Add an empty group to a document.
   subroutine add_group(document, name, origin)
      type(document_type), intent(inout) :: document
      !> Name of the group.
      character(len=*), intent(in) :: name
      !> Where it comes from.
      type(origin_type), intent(in) :: origin
      type(group_type), allocatable :: groups(:)
      integer :: i

      allocate(groups(document%n_groups + 1))
      do i = 1, document%n_groups
         groups(i) = document%groups(i)
      end do
      groups(i)%name = name
      groups(i)%origin = origin
      allocate(groups(i)%assignments(0))
      call move_alloc(groups, document%groups)
      document%n_groups = document%n_groups + 1
   end subroutine add_group

   !> Give a key of a group new values, in place of all that it had, or one of its values a new one.
   recursive subroutine set_key(group, key, element, values, origin)
      type(group_type), intent(inout) :: group
      character(len=*), intent(in) :: key
      !> Which value is set; 0 for all.
      integer, intent(in) :: element
      type(value_type), intent(in) :: values(:)
      !> Where they come from.
      type(origin_type), intent(in) :: origin
      type(assignment_type), allocatable :: kept(:)
      integer :: i, n, slot

      if (element > 0) then
         ! What the others would be if they are not given.
         if (.not. any([(group%assignments(i)%key == key, i=1, group%n_assignments)])) call &
            set_default_of(group, key, origin)
         do i = 1, group%n_assignments
            associate (assignment => group%assignments(i))
               if (assignment%key /= key) cycle
               slot = element - max(assignment%first, 1) + 1
               if (slot < 1 .or. slot > size(assignment%values)) cycle
               assignment%values(slot) = values(1)
               return
            end associate
         end do
      end if
      allocate(kept(group%n_assignments + 1))
      n = 0
      do i = 1, group%n_assignments
         if (group%assignments(i)%key == key .and. element == 0) cycle
         n = n + 1
         kept(n) = group%assignments(i)
      end do
      n = n + 1
      kept(n)%key = key
      kept(n)%first = element
      kept(n)%last = element
      kept(n)%values = values
      kept(n)%origin = origin
      deallocate(group%assignments)
      allocate(group%assignments(n))
      do i = 1, n
         group%assignments(i) = kept(i)
      end do
      group%n_assignments = n
   end subroutine set_key

   !> Give a key of a group its default numbers, so that one of them can be set.
   recursive subroutine set_default_of(group, key, origin)
      type(group_type), intent(inout) :: group
      character(len=*), intent(in) :: key
      !> Where they come from.
      type(origin_type), intent(in) :: origin
      type(key_type), allocatable :: keys(:)
      type(setting_type) :: setting
      type(value_type), allocatable :: values(:)
      integer :: i, k

      keys = schema_keys()
      k = findloc(keys%group == group%name .and. keys%name == key, .true., dim=1)
      if (k == 0) return
      if (keys(k)%kind /= kind_real .or. keys(k)%default == "" .or. keys(k)%values == 1) return
      setting%key = keys(k)
      call set_default(setting)
      allocate(values(setting%n))
      do i = 1, setting%n
         values(i)%kind = value_real
         values(i)%real = setting%real(i)
         values(i)%origin = origin
      end do
      call set_key(group, key, 0, values, origin)
   end subroutine set_default_of

   !> Check all groups and keys of a document against the schema.
   subroutine resolve(document, settings, diagnostics)
      type(document_type), intent(in) :: document
      !> All groups with all their keys.
      type(settings_type), intent(out) :: settings
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics
      type(group_spec_type), allocatable :: groups(:)
      type(key_type), allocatable :: keys(:)
      type(group_settings_type), allocatable :: instances(:)
      integer, allocatable :: first(:)
      integer :: i, g, n, near

      groups = schema_groups()
      keys = schema_keys()
      allocate(instances(document%n_groups))
      allocate(first(size(groups)), source=0)
      allocate(settings%lost(size(groups)), source=.not. document%complete)
      n = 0
      do i = 1, document%n_groups
         associate (group => document%groups(i))
            g = findloc(groups%name == group%name, .true., dim=1)
            if (g == 0) then
               near = nearest(group%name, groups%name)
               if (near > 0) then
                  settings%lost(near) = .true.
                  call diagnostics%add(group%origin, "unknown group &" // group%name, &
                     "&" // trim(groups(near)%name))
               else
                  call diagnostics%add(group%origin, "unknown group &" // group%name, &
                     "one of &" // join(strings(groups%name), ", &"))
               end if
               cycle
            end if
            if (first(g) > 0 .and. .not. groups(g)%repeats) then
               call diagnostics%add(group%origin, "group &" // group%name // " given twice", &
                  "one group &" // group%name // "; the first is in line " // &
                  to_text(document%groups(first(g))%origin%line))
               cycle
            end if
            if (first(g) == 0) first(g) = i
            n = n + 1
            instances(n)%group = g
            instances(n)%origin = group%origin
            instances(n)%complete = group%complete
            call resolve_group(group, keys, instances(n), diagnostics)
         end associate
      end do
      allocate(settings%instances(n))
      do i = 1, n
         settings%instances(i) = instances(i)
      end do
      do g = 1, size(groups)
         if (first(g) > 0 .or. settings%lost(g) .or. .not. groups(g)%mandatory) cycle
         call diagnostics%add(origin_type(1, 0, 0, 1), "there is no group &" // &
            trim(groups(g)%name), "&" // trim(groups(g)%name) // ": " // trim(groups(g)%doc))
      end do
   end subroutine resolve

   !> Check the keys of a group.
   subroutine resolve_group(group, keys, instance, diagnostics)
      !> The group as read.
      type(group_type), intent(in) :: group
      !> All keys of the schema.
      type(key_type), intent(in) :: keys(:)
      !> The group with all its keys.
      type(group_settings_type), intent(inout) :: instance
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics
      type(key_type), allocatable :: own(:)
      integer, allocatable :: first_given(:, :)
      integer :: i, k, near

      own = pack(keys, keys%group == group%name)
      allocate(instance%settings(size(own)), first_given(most_values, size(own)))
      first_given = 0
      do k = 1, size(own)
         instance%settings(k)%key = own(k)
         instance%settings(k)%origin = group%origin
         instance%settings(k)%places = group%origin
         call set_default(instance%settings(k))
      end do
      do i = 1, group%n_assignments
         associate (assignment => group%assignments(i))
            call find_key(assignment, group%name, own%name, k, near, diagnostics)
            if (near > 0) instance%settings(near)%meant = .true.
            if (k == 0) cycle
            call take_assignment(assignment, instance%settings(k), first_given(:, k), &
               group%name, group%complete, diagnostics)
         end associate
      end do
      do k = 1, size(own)
         associate (setting => instance%settings(k))
            if (setting%given) then
               setting%n = own(k)%values
               if (own(k)%few) setting%n = max(1, findloc(first_given(:, k) /= 0, .true., dim=1, &
                  back=.true.))
               setting%set = all(first_given(:setting%n, k) > 0)
               if (any(first_given(:setting%n, k) == 0)) call diagnostics%add( &
                  setting%origin, "'" // trim(own(k)%name) // "' has " // &
                  to_text(count(first_given(:, k) /= 0)) // " of " // to_text(setting%n) // &
                  " values", expected_of(own(k)))
            else if (own(k)%mandatory .and. group%complete .and. &
               .not. setting%meant) then
               call diagnostics%add(group%origin, "'" // trim(own(k)%name) // &
                  "' is missing in group &" // trim(group%name) // named(instance), &
                  trim(own(k)%name) // " = " // expected_of(own(k)))
            end if
         end associate
      end do
   end subroutine resolve_group

   !> Find the key of an assignment among those of its group; one that is unknown is reported.
   subroutine find_key(assignment, group, names, position, near, diagnostics)
      type(assignment_type), intent(in) :: assignment
      !> Name of the group.
      character(len=*), intent(in) :: group
      !> Names of the keys of the group.
      character(len=*), intent(in) :: names(:)
      !> Position of the key in `names`; 0 if it is unknown.
      integer, intent(out) :: position
      !> For an unknown key, position of the one that is likely meant; 0 for none.
      integer, intent(out) :: near
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics

      near = 0
      position = findloc(names == assignment%key, .true., dim=1)
      if (position > 0) return
      near = nearest(assignment%key, names)
      if (near > 0) then
         call diagnostics%add(assignment%origin, "unknown key '" // assignment%key // &
            "' in group &" // group, trim(names(near)))
      else
         call diagnostics%add(assignment%origin, "unknown key '" // assignment%key // &
            "' in group &" // group, "one of " // join(strings(names), ", "))
      end if
   end subroutine find_key

   !> " 'name'" for messages, if the group has a name.
   pure function named(instance) result(text)
      !> The group.
      type(group_settings_type), intent(in) :: instance
      character(len=:), allocatable :: text

      text = instance%label()
      if (text /= "") text = " " // quote(text)
   end function named

   !> Give a key its default, if it has one.
   subroutine set_default(setting)
      !> The key.
      type(setting_type), intent(inout) :: setting
      integer :: i, k, first, last
      type(string_type), allocatable :: names(:)
      character(len=:), allocatable :: text

      do i = 1, most_values
         setting%text(i)%s = ""
      end do
      setting%n = setting%key%values
      if (setting%key%default == "") return
      text = trim(setting%key%default)
      setting%set = .true.
      if (setting%key%few) setting%n = count([(text(i:i) == ",", i=1, len(text))]) + 1
      select case (setting%key%kind)
      case (kind_real)
         read(text, *) setting%real(:setting%n)
      case (kind_logical)
         setting%logical = text == ".true."
      case default
         names = choices_of(setting%key)
         last = 0
         do k = 1, setting%n
            first = last + index(text(last + 1:), "'") + 1
            last = first + index(text(first:), "'") - 1
            setting%text(k)%s = text(first:last - 1)
            do i = 1, size(names)
               if (names(i)%s == setting%text(k)%s) setting%choices(k) = i
            end do
         end do
         setting%choice = setting%choices(1)
      end select
   end subroutine set_default

   !> Take the values of an assignment.
   subroutine take_assignment(assignment, setting, first_given, group, complete, diagnostics)
      type(assignment_type), intent(in) :: assignment
      !> The key.
      type(setting_type), intent(inout) :: setting
      !> For each value, the line it was first given in; -1 after a mistake, 0 if not given.
      integer, intent(inout) :: first_given(:)
      !> Name of the group.
      character(len=*), intent(in) :: group
      !> Whether the group was read without a mistake of syntax.
      logical, intent(in) :: complete
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: low, high, i, slot
      logical :: good

      associate (key => setting%key)
         low = max(assignment%first, 1)
         high = key%values
         if (assignment%first > 0 .and. assignment%last >= 0) high = assignment%last
         if (key%values == 1 .and. assignment%first /= 0 .or. high > key%values .or. &
            low > key%values) then
            call diagnostics%add(assignment%origin, "'" // trim(key%name) // "' has " // &
               to_text(key%values) // trim(merge(" value ", " values", key%values == 1)) // &
               ", the subscript is out of range", expected_of(key))
            setting%given = .true.
            first_given = -1
            return
         end if
         if (.not. setting%given) setting%origin = assignment%origin
         if (size(assignment%values) > high - low + 1) then
            call diagnostics%add(assignment%values(high - low + 2)%origin, "too many values for '" &
               // trim(key%name) // "' in group &" // group, expected_of(key))
            setting%given = .true.
            first_given = -1
            return
         end if
         if (size(assignment%values) == 0) then
            ! In a group with a mistake of syntax that mistake took the value.
            if (complete) call diagnostics%add(assignment%origin, "no value for '" // &
               trim(key%name) // "' in group &" // group, expected_of(key))
            setting%given = .true.
            first_given = -1
            return
         end if
         if (any(first_given(low:low + size(assignment%values) - 1) /= 0)) then
            call diagnostics%add(assignment%origin, "'" // trim(key%name) // &
               "' given twice in group &" // group, "one of the two; the first is in line " // &
               to_text(maxval(abs(first_given(low:high)))))
            return
         end if
         setting%given = .true.
         do i = 1, size(assignment%values)
            slot = low + i - 1
            setting%places(slot) = assignment%values(i)%origin
            call take_value(assignment%values(i), setting, slot, group, diagnostics, good)
            first_given(slot) = -1
            if (good) first_given(slot) = max(assignment%origin%line, 1)
         end do
      end associate
   end subroutine take_assignment

   !> Take one value.
   subroutine take_value(value, setting, slot, group, diagnostics, good)
      type(value_type), intent(in) :: value
      !> The key.
      type(setting_type), intent(inout) :: setting
      !> Which of its values.
      integer, intent(in) :: slot
      !> Name of the group.
      character(len=*), intent(in) :: group
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics
      !> Whether the value is in order.
      logical, intent(out) :: good
      type(string_type), allocatable :: names(:)

      good = .false.
      associate (key => setting%key)
         if (value%kind == value_null) then
            call wrong("a value of '" // trim(key%name) // "' is missing in group &" // group)
            return
         end if
         select case (key%kind)
         case (kind_real)
            if (value%kind /= value_integer .and. value%kind /= value_real) then
               call wrong("'" // trim(key%name) // "' needs a number, this is a " // &
                  kind_word(value))
               return
            end if
            if (.not. ieee_is_finite(value%real)) then
               call wrong("'" // trim(key%name) // "' must be finite")
               return
            end if
            if (abs(value%real) > largest_number .or. (abs(value%real) > 0.0_wp .and. &
               abs(value%real) < 1.0_wp/largest_number)) then
               call wrong("'" // trim(key%name) // "' is beyond what can be computed with")
               return
            end if
            if (.not. admits(key, value%real)) then
               call wrong("'" // trim(key%name) // "' is out of range")
               return
            end if
            setting%real(slot) = value%real
         case (kind_logical)
            if (value%kind /= value_logical) then
               call wrong("'" // trim(key%name) // "' needs a logical, this is a " // &
                  kind_word(value))
               return
            end if
            setting%logical = value%logical
         case default
            if (value%kind /= value_text) then
               call wrong("'" // trim(key%name) // "' needs a text in quotes, this is a " // &
                  kind_word(value))
               return
            end if
            setting%text(slot)%s = trim(adjustl(value%text))
            if (key%kind /= kind_text .and. setting%text(slot)%s == "") then
               call wrong("'" // trim(key%name) // "' is empty")
               return
            end if
            if (key%kind == kind_choice) then
               names = choices_of(key)
               call find_choice(setting%text(slot)%s, names, trim(key%name), value%origin, &
                  setting%choice, diagnostics)
               if (setting%choice == 0) return
               setting%choices(slot) = setting%choice
               setting%text(slot)%s = names(setting%choice)%s
            end if
         end select
      end associate
      good = .true.

   contains

      !> Report a mistake in this value.
      subroutine wrong(message)
         !> What is wrong.
         character(len=*), intent(in) :: message

         call diagnostics%add(value%origin, message, expected_of(setting%key))
      end subroutine wrong

   end subroutine take_value

   !> Find a choice among the names of its key; one that is unknown is reported.
   subroutine find_choice(text, names, key, origin, choice, diagnostics)
      !> The choice, in upper or lower case.
      character(len=*), intent(in) :: text
      !> The names that the key admits.
      type(string_type), intent(in) :: names(:)
      !> Name of the key.
      character(len=*), intent(in) :: key
      !> Where the choice stands.
      type(origin_type), intent(in) :: origin
      !> Its position in `names`; 0 if it is unknown.
      integer, intent(out) :: choice
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: near

      do choice = 1, size(names)
         if (names(choice)%s == lower(text)) return
      end do
      choice = 0
      near = nearest(lower(text), names)
      if (near > 0) then
         call diagnostics%add(origin, "unknown " // key // " " // quote(text), &
            quote(names(near)%s) // "; possible are " // join(names, ", "))
      else
         call diagnostics%add(origin, "unknown " // key // " " // quote(text), &
            "one of " // join(names, ", "))
      end if
   end subroutine find_choice

   !> A kind of value in words.
   pure function kind_word(value) result(word)
      type(value_type), intent(in) :: value
      character(len=:), allocatable :: word

      select case (value%kind)
      case (value_logical)
         word = "logical"
      case (value_text)
         word = "text"
      case default
         word = "number"
      end select
   end function kind_word

   !> What a key wants, in words.
   function expected_of(key) result(text)
      type(key_type), intent(in) :: key
      character(len=:), allocatable :: text

      select case (key%kind)
      case (kind_real)
         text = domain_text(key)
      case (kind_logical)
         text = ".true. or .false."
      case (kind_choice)
         text = "one of " // join(choices_of(key), ", ") // ", in quotes"
         if (key%few) text = "up to " // to_text(key%values) // " of" // text(7:)
      case (kind_reference)
         text = "the name of a " // trim(key%target) // " in quotes"
         if (key%values == 2) text = "the names of two " // trim(key%target) // "s in quotes"
      case (kind_name)
         text = "a name in quotes"
      case default
         text = "a text in quotes"
      end select
   end function expected_of

   !> The settings as a namelist text: every key that has a value, defaults included.
   function resolved_text(settings) result(text)
      type(settings_type), intent(in) :: settings
      character(len=:), allocatable :: text
      type(group_spec_type), allocatable :: groups(:)
      integer :: i, k, v

      groups = schema_groups()
      text = ""
      do i = 1, size(settings%instances)
         ! What no run looks at.
         if (groups(settings%instances(i)%group)%name == "cost" .and. &
            .not. any(settings%instances(i)%settings%given)) cycle
         text = text // "&" // trim(groups(settings%instances(i)%group)%name) // new_line("a")
         do k = 1, size(settings%instances(i)%settings)
            associate (setting => settings%instances(i)%settings(k))
               if (.not. setting%set) cycle
               text = text // "   " // trim(setting%key%name) // " = "
               do v = 1, setting%n
                  if (v > 1) text = text // ", "
                  select case (setting%key%kind)
                  case (kind_real)
                     text = text // to_text(setting%real(v))
                  case (kind_logical)
                     text = text // trim(merge(".true. ", ".false.", setting%logical))
                  case default
                     text = text // quote(setting%text(v)%s)
                  end select
               end do
               text = text // new_line("a")
            end associate
         end do
         text = text // "/" // new_line("a")
      end do
   end function resolved_text

end module contensou_scene_settings
