!> A group `defaults` gives keys to surfaces and contacts that do not give them themselves: to those
!> that have a use for them. Parts of bearings have keys of their own and take nothing from it.
module contensou_scene_defaults
   use contensou_base_diagnostics, only : diagnostics_type
   use contensou_base_document, only : document_type, group_type
   use contensou_base_document_types, only : remove_groups, resize_assignments, selection
   use contensou_base_resolve, only : resolve
   use contensou_base_schema, only : key_list_type, schema_type
   use contensou_base_settings, only : settings_type
   use contensou_base_text, only : quote
   use contensou_contact_parts, only : n_parts, part_type, shared_parts
   use contensou_contact_shapes_table, only : shape_list_type, shared_shapes
   use contensou_scene_overrides, only : text_of
   implicit none(type, external)
   private

   public :: apply_defaults, defaults_group

   character(len=*), parameter :: defaults_group = "defaults"

contains

   !> Give the keys of `defaults` to the groups that have a use for them.
   subroutine apply_defaults(document, schema, diagnostics)
      type(document_type), intent(inout) :: document
      type(schema_type), intent(in), target :: schema
      type(diagnostics_type), intent(inout) :: diagnostics
      type(settings_type) :: ignored
      type(shape_list_type), pointer :: shapes
      type(part_type), pointer :: parts(:)
      type(group_type) :: defaults
      logical, allocatable :: used(:)
      logical :: wrong
      integer :: before, d, g, i

      do d = 1, document%n_groups
         if (document%groups(d)%name == defaults_group) exit
      end do
      if (d > document%n_groups) return
      before = diagnostics%count()
      call resolve(selection(document, defaults_group), schema, ignored, diagnostics)
      wrong = diagnostics%count() > before
      defaults = document%groups(d)
      if (wrong) call keep_right_ones(document, schema, defaults)
      call remove_groups(document, defaults_group)
      shapes => shared_shapes()
      parts => shared_parts()
      allocate(used(defaults%n_assignments), source=.false.)
      do g = 1, document%n_groups
         select case (document%groups(g)%name)
         case ("surface")
            call give_surface(document%groups(g), defaults, shapes, used)
         case ("contact", "contacts")
            call give_contact(document%groups(g), defaults, parts, used)
         case default
            cycle
         end select
         ! What a mistake in the defaults leaves out is not missing.
         if (wrong) document%groups(g)%complete = .false.
      end do
      if (wrong) return
      do i = 1, size(used)
         if (.not. used(i)) call diagnostics%add(defaults%assignments(i)%origin, &
            "no surface or contact takes " // quote(defaults%assignments(i)%key) // &
            " from &" // defaults_group, "a key that one of them has a use for and does not give")
      end do
   end subroutine apply_defaults

   !> Leave out what has a mistake.
   subroutine keep_right_ones(document, schema, defaults)
      !> The document, of which `defaults` is a group.
      type(document_type), intent(in) :: document
      type(schema_type), intent(in), target :: schema
      type(group_type), intent(inout) :: defaults
      type(document_type) :: part
      type(settings_type) :: ignored
      type(diagnostics_type) :: found
      integer :: k, n

      part = selection(document, defaults_group)
      part%n_groups = 1
      part%groups(1)%n_assignments = 1
      n = 0
      do k = 1, defaults%n_assignments
         part%groups(1)%assignments(1) = defaults%assignments(k)
         found = diagnostics_type()
         call resolve(part, schema, ignored, found)
         if (found%count() > 0) cycle
         n = n + 1
         if (n < k) defaults%assignments(n) = defaults%assignments(k)
      end do
      defaults%n_assignments = n
   end subroutine keep_right_ones

   !> Give a surface what its shape has a use for.
   subroutine give_surface(group, defaults, shapes, used)
      type(group_type), intent(inout) :: group
      type(group_type), intent(in) :: defaults
      type(shape_list_type), intent(in) :: shapes
      !> For each default, whether something has a use for it.
      logical, intent(inout) :: used(:)
      character(len=:), allocatable :: shape
      integer :: k, s

      shape = text_in(group, defaults, "shape")
      do s = 1, shapes%n
         if (shapes%items(s)%info%name == shape) exit
      end do
      do k = 1, defaults%n_assignments
         associate (key => defaults%assignments(k)%key)
            select case (key)
            case ("normal")
               ! That of a contact.
               continue
            case ("shape", "material")
               call give(group, defaults, k, used)
            case ("side")
               if (s > shapes%n) cycle
               if (shapes%items(s)%info%hollow /= "") call give(group, defaults, k, used)
            case default
               if (s > shapes%n) cycle
               if (shapes%items(s)%keys%has(key)) call give(group, defaults, k, used)
            end select
         end associate
      end do
   end subroutine give_surface

   !> Give a contact what its models have a use for.
   subroutine give_contact(group, defaults, parts, used)
      type(group_type), intent(inout) :: group
      type(group_type), intent(in) :: defaults
      type(part_type), intent(in) :: parts(:)
      !> For each default, whether something has a use for it.
      logical, intent(inout) :: used(:)
      character(len=:), allocatable :: with, instead
      integer :: at, choice, i, k

      do k = 1, defaults%n_assignments
         associate (key => defaults%assignments(k)%key)
            if (any(parts%name == key)) then
               call give(group, defaults, k, used)
               cycle
            end if
            do i = 1, n_parts
               choice = model_of(group, defaults, parts(i))
               at = parts(i)%keys(choice)%at(key)
               ! The keys of what is turned off by name may stay where they are, as in a contact.
               if (at == 0) then
                  used(k) = used(k) .or. (.not. parts(i)%models(choice)%acts .and. &
                     text_in(group, defaults, trim(parts(i)%name)) /= "" .and. &
                     goes_with(parts(i), key))
                  cycle
               end if
               with = trim(parts(i)%keys(choice)%keys(at)%with)
               instead = trim(parts(i)%keys(choice)%keys(at)%instead)
               if (with /= "") then
                  if (.not. (group%gives(with) .or. defaults%gives(with))) cycle
               end if
               used(k) = .true.
               if (instead /= "") then
                  if (group%gives(instead)) cycle
               end if
               call give(group, defaults, k, used)
               exit
            end do
         end associate
      end do
   end subroutine give_contact

   !> Whether a key goes with any model of a part of a contact.
   pure logical function goes_with(part, key)
      type(part_type), intent(in) :: part
      character(len=*), intent(in) :: key
      integer :: i

      goes_with = .false.
      do i = 1, size(part%models)
         goes_with = goes_with .or. part%keys(i)%at(key) > 0
      end do
   end function goes_with

   !> Position of the model of a part of a contact in its table.
   pure integer function model_of(group, defaults, part)
      type(group_type), intent(in) :: group, defaults
      type(part_type), intent(in) :: part
      character(len=:), allocatable :: name

      name = text_in(group, defaults, trim(part%name))
      do model_of = 1, size(part%models)
         if (part%models(model_of)%info%name == name) return
      end do
      model_of = 1
   end function model_of

   !> Give a group one of the defaults, unless it has the key.
   subroutine give(group, defaults, k, used)
      type(group_type), intent(inout) :: group
      type(group_type), intent(in) :: defaults
      !> Which default.
      integer, intent(in) :: k
      !> For each default, whether something has a use for it.
      logical, intent(inout) :: used(:)
      integer :: n

      used(k) = .true.
      if (group%gives(defaults%assignments(k)%key)) return
      n = group%n_assignments + 1
      call resize_assignments(group, n)
      group%n_assignments = n
      group%assignments(n) = defaults%assignments(k)
   end subroutine give

   !> Text of a key in a group, or else in the defaults, in lower case; blank if there is none.
   pure function text_in(group, defaults, key) result(text)
      type(group_type), intent(in) :: group, defaults
      character(len=*), intent(in) :: key
      character(len=:), allocatable :: text

      if (group%gives(key)) then
         text = text_of(group, key)
      else
         text = text_of(defaults, key)
      end if
   end function text_in

end module contensou_scene_defaults
