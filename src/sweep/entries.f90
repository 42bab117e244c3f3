!> The groups of a sweep file as they stand in it: every key with its values, checked one by one,
!> and settings of the command line in their place. What they mean together is for the reader.
module contensou_sweep_entries
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite
   use contensou_base_diagnostics, only : diagnostics_type, origin_type
   use contensou_base_document, only : assignment_type, document_type, group_type, &
      parse_value_list, value_integer, value_null, value_real, value_text, value_type
   use contensou_base_kinds, only : wp
   use contensou_base_settings, only : admits, key_type, kind_choice, kind_real
   use contensou_base_text, only : lower, nearest, starts_with, string_type, to_text
   use contensou_scene_schema, only : group_spec_type
   use contensou_scene_settings, only : find_choice, find_key
   use contensou_sweep_schema, only : any_number, kind_any, kind_whole, sweep_choices, &
      sweep_domain, sweep_groups, sweep_keys
   implicit none(type, external)
   private

   public :: entries_type, entry_type, choice_of
   public :: concerns_sweep, override_sweep, resolve_document

   !> A key of a sweep file with its values.
   type :: entry_type
      type(key_type) :: key
      !> Whether it is given.
      logical :: given = .false.
      !> Whether it is likely given under a misspelt name.
      logical :: meant = .false.
      !> Whether it has usable values.
      logical :: good = .false.
      !> Where the key stands, or its group if it is not given.
      type(origin_type) :: origin
      type(value_type), allocatable :: values(:)
   end type entry_type

   !> A group of a sweep file.
   type :: entries_type
      !> Name of the group.
      character(len=:), allocatable :: group
      !> Where it stands.
      type(origin_type) :: origin
      !> Whether it was read without a mistake of syntax.
      logical :: complete = .true.
      !> Its keys, all that there are.
      type(entry_type), allocatable :: keys(:)
   contains
      !> Position of a key.
      procedure :: at => position_of
      !> First value of a key as a number.
      procedure :: number => number_of
      !> First value of a key as a text.
      procedure :: text => text_of
   end type entries_type

contains

   !> Whether the text of a `--set` option is about the sweep, not its scene.
   pure function concerns_sweep(override) result(concerns)
      !> Text after `--set`.
      character(len=*), intent(in) :: override
      logical :: concerns

      concerns = starts_with(lower(adjustl(override)), "sweep.")
   end function concerns_sweep

   !> Replace or add values in the group `sweep` of a document, from `--set sweep.KEY=VALUE`.
   subroutine override_sweep(document, override, diagnostics)
      !> Document to change.
      type(document_type), intent(inout) :: document
      !> Text after `--set`.
      character(len=*), intent(in) :: override
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics
      type(value_type), allocatable :: values(:)
      type(assignment_type), allocatable :: kept(:)
      character(len=:), allocatable :: key
      integer :: equals, g, i, n, before

      equals = index(override, "=")
      before = diagnostics%count()
      call parse_value_list("--set " // override, override(equals + 1:), values, document, &
         diagnostics, .true.)
      if (diagnostics%count() > before) return
      if (equals == 0) then
         call diagnostics%add(origin_type(size(document%sources), 0, 0, 1), "'=' is missing", &
            "--set sweep.key=value")
         return
      end if
      key = lower(trim(adjustl(override(:equals - 1))))
      key = key(len("sweep.") + 1:)
      do g = 1, document%n_groups
         associate (group => document%groups(g))
            if (group%name /= "sweep") cycle
            allocate(kept(group%n_assignments + 1))
            n = 0
            do i = 1, group%n_assignments
               if (group%assignments(i)%key == key) cycle
               n = n + 1
               kept(n) = group%assignments(i)
            end do
            n = n + 1
            kept(n)%key = key
            kept(n)%values = values
            kept(n)%origin = origin_type(size(document%sources), 0, 0, 1)
            deallocate(group%assignments)
            allocate(group%assignments(n))
            do i = 1, n
               group%assignments(i) = kept(i)
            end do
            group%n_assignments = n
            return
         end associate
      end do
   end subroutine override_sweep

   !> Check all groups and keys of a document.
   subroutine resolve_document(document, groups, head, diagnostics)
      type(document_type), intent(in) :: document
      !> The groups that are known.
      type(entries_type), allocatable, intent(out) :: groups(:)
      !> Position of the group `sweep`; 0 if there is none.
      integer, intent(out) :: head
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics
      type(group_spec_type), allocatable :: specs(:)
      type(key_type), allocatable :: keys(:)
      type(entries_type), allocatable :: all(:)
      integer :: i, n, near
      logical :: lost

      specs = sweep_groups()
      keys = sweep_keys()
      allocate(all(document%n_groups))
      n = 0
      head = 0
      lost = .not. document%complete
      do i = 1, document%n_groups
         associate (group => document%groups(i))
            if (.not. any(specs%name == group%name)) then
               near = nearest(group%name, specs%name)
               if (near > 0) then
                  lost = .true.
                  call diagnostics%add(group%origin, "unknown group &" // group%name, &
                     "&" // trim(specs(near)%name))
               else
                  call diagnostics%add(group%origin, "unknown group &" // group%name // &
                     " in a sweep", "one of &sweep, &parameter, &value")
               end if
               cycle
            end if
            if (group%name == "sweep" .and. head > 0) then
               call diagnostics%add(group%origin, "group &sweep given twice", &
                  "one group &sweep; the first is in line " // to_text(all(head)%origin%line))
               cycle
            end if
            n = n + 1
            if (group%name == "sweep") head = n
            call resolve_group(group, keys, all(n), diagnostics)
         end associate
      end do
      allocate(groups(n))
      do i = 1, n
         groups(i) = all(i)
      end do
      if (head == 0 .and. .not. lost) call diagnostics%add(origin_type(1, 0, 0, 1), &
         "there is no group &sweep", "&sweep scene = 'FILE' /: " // trim(specs(1)%doc))
   end subroutine resolve_document

   !> Check the keys of a group.
   subroutine resolve_group(group, keys, entries, diagnostics)
      !> The group as read.
      type(group_type), intent(in) :: group
      !> All keys of sweep files.
      type(key_type), intent(in) :: keys(:)
      !> The group with all its keys.
      type(entries_type), intent(inout) :: entries
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics
      type(key_type), allocatable :: own(:)
      integer :: i, k, near

      own = pack(keys, keys%group == group%name)
      entries%group = group%name
      entries%origin = group%origin
      entries%complete = group%complete
      allocate(entries%keys(size(own)))
      do k = 1, size(own)
         entries%keys(k)%key = own(k)
         entries%keys(k)%origin = group%origin
         allocate(entries%keys(k)%values(0))
      end do
      do i = 1, group%n_assignments
         associate (assignment => group%assignments(i))
            call find_key(assignment, group%name, own%name, k, near, diagnostics)
            if (near > 0) entries%keys(near)%meant = .true.
            if (k == 0) cycle
            associate (entry => entries%keys(k))
               if (entry%given) then
                  call diagnostics%add(assignment%origin, "'" // trim(own(k)%name) // &
                     "' given twice in group &" // group%name, "one of the two; the first is in " &
                     // "line " // to_text(entry%origin%line))
                  entry%good = .false.
                  cycle
               end if
               entry%given = .true.
               entry%origin = assignment%origin
               call take_values(assignment, group%complete, entry, diagnostics)
            end associate
         end associate
      end do
      do k = 1, size(own)
         associate (entry => entries%keys(k))
            if (own(k)%mandatory .and. .not. entry%given .and. .not. entry%meant .and. &
               group%complete) call diagnostics%add(group%origin, "'" // trim(own(k)%name) // &
               "' is missing in group &" // group%name, trim(own(k)%name) // " = " // &
               sweep_domain(own(k)))
         end associate
      end do
   end subroutine resolve_group

   !> Check the values of a key.
   subroutine take_values(assignment, complete, entry, diagnostics)
      type(assignment_type), intent(in) :: assignment
      !> Whether its group was read without a mistake of syntax.
      logical, intent(in) :: complete
      !> The key.
      type(entry_type), intent(inout) :: entry
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics
      character(len=:), allocatable :: name
      integer :: i
      logical :: good

      name = "'" // trim(entry%key%name) // "'"
      if (assignment%first > 0) then
         call diagnostics%add(assignment%origin, name // " takes no subscript", &
            trim(entry%key%name) // " = " // sweep_domain(entry%key))
         return
      end if
      if (size(assignment%values) == 0) then
         if (complete) call diagnostics%add(assignment%origin, "no value for " // name // &
            " in group &" // trim(entry%key%group), sweep_domain(entry%key))
         return
      end if
      if (entry%key%values /= any_number .and. size(assignment%values) > entry%key%values) then
         call diagnostics%add(assignment%values(2)%origin, "too many values for " // name // &
            " in group &" // trim(entry%key%group), "one value, " // sweep_domain(entry%key))
         return
      end if
      entry%values = assignment%values
      entry%good = .true.
      do i = 1, size(entry%values)
         call take_value(entry%key, entry%values(i), good, diagnostics)
         entry%good = entry%good .and. good
      end do
   end subroutine take_values

   !> Check a value of a key.
   subroutine take_value(key, value, good, diagnostics)
      type(key_type), intent(in) :: key
      !> The value; texts are put in order.
      type(value_type), intent(inout) :: value
      !> Whether it is in order.
      logical, intent(out) :: good
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics
      type(string_type), allocatable :: names(:)
      character(len=:), allocatable :: name
      integer :: choice

      good = .false.
      name = "'" // trim(key%name) // "'"
      if (value%kind == value_null) then
         call diagnostics%add(value%origin, "a value of " // name // " is missing in group &" // &
            trim(key%group), sweep_domain(key))
         return
      end if
      if (value%kind == value_text) value%text = trim(adjustl(value%text))
      select case (key%kind)
      case (kind_real, kind_whole)
         if (value%kind /= value_integer .and. value%kind /= value_real) then
            call wrong(" needs a number")
         else if (.not. ieee_is_finite(value%real)) then
            call wrong(" must be finite")
         else if (.not. admits(key, value%real)) then
            call wrong(" is out of range")
         else if (key%kind == kind_whole .and. abs(value%real - anint(value%real)) > 0.0_wp) then
            call wrong(" must be whole")
         else
            good = .true.
         end if
      case (kind_any)
         if (value%kind == value_real .or. value%kind == value_integer) then
            if (ieee_is_finite(value%real)) then
               value%kind = value_real
               good = .true.
            else
               call wrong(" must be finite")
            end if
         else
            good = .true.
         end if
      case default
         if (value%kind /= value_text) then
            call wrong(" needs a text in quotes")
            return
         end if
         if (value%text == "") then
            call wrong(" is empty")
            return
         end if
         good = .true.
         if (key%kind /= kind_choice) return
         names = sweep_choices(key)
         call find_choice(value%text, names, trim(key%name), value%origin, choice, diagnostics)
         good = choice > 0
         if (good) value%integer = choice
      end select

   contains

      !> Report a mistake in this value.
      subroutine wrong(what)
         !> What is wrong with it.
         character(len=*), intent(in) :: what

         call diagnostics%add(value%origin, name // what, sweep_domain(key))
      end subroutine wrong

   end subroutine take_value

   !> Position of a key of a group; the key must exist.
   pure function position_of(self, name) result(i)
      !> The group.
      class(entries_type), intent(in) :: self
      !> Name of the key.
      character(len=*), intent(in) :: name
      integer :: i

      do i = 1, size(self%keys)
         if (self%keys(i)%key%name == name) return
      end do
      error stop "a key is asked for that a sweep file does not have"
   end function position_of

   !> First value of a key as a number; 0 if it has no usable one.
   pure function number_of(self, name) result(x)
      !> The group.
      class(entries_type), intent(in) :: self
      !> Name of the key.
      character(len=*), intent(in) :: name
      real(wp) :: x

      x = 0.0_wp
      associate (entry => self%keys(self%at(name)))
         if (entry%good) x = entry%values(1)%real
      end associate
   end function number_of

   !> First value of a key as a text; blank if it has no usable one.
   pure function text_of(self, name) result(text)
      !> The group.
      class(entries_type), intent(in) :: self
      !> Name of the key.
      character(len=*), intent(in) :: name
      character(len=:), allocatable :: text

      text = ""
      associate (entry => self%keys(self%at(name)))
         if (entry%good) text = entry%values(1)%text
      end associate
   end function text_of

   !> Position of a choice among the names of its key; 0 if there is no usable one.
   pure function choice_of(entries, name) result(choice)
      !> The group.
      type(entries_type), intent(in) :: entries
      !> Name of the key.
      character(len=*), intent(in) :: name
      integer :: choice

      choice = 0
      associate (entry => entries%keys(entries%at(name)))
         if (entry%good) choice = int(entry%values(1)%integer)
      end associate
   end function choice_of

end module contensou_sweep_entries
