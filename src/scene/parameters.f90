!> The numbers of a scene that can be set, each with the name that it has after `--set`.
module contensou_scene_parameters
   use contensou_base_document, only : constants_group
   use contensou_base_kinds, only : wp
   use contensou_base_names, only : names_type
   use contensou_base_numbers, only : to_text
   use contensou_base_schema, only : key_type, kind_integer, kind_real, schema_type
   use contensou_base_settings, only : group_settings_type, settings_type
   use contensou_base_text, only : lower, string_type
   use contensou_scene_reader, only : loaded_scene_type
   implicit none(type, external)
   private

   public :: parameter_type, list_parameters

   !> A number of a scene.
   type :: parameter_type
      !> As after `--set`: `top.spin(3)`.
      character(len=:), allocatable :: name
      !> Its key, with unit, domain and meaning.
      type(key_type) :: key
      !> Its value, given, by default or derived.
      real(wp) :: value = 0.0_wp
      !> Whether the scene gives it.
      logical :: given = .false.
   end type parameter_type

contains

   !> The numbers of a scene that have a value.
   subroutine list_parameters(loaded, parameters)
      !> The scene, without mistakes.
      type(loaded_scene_type), intent(in), target :: loaded
      type(parameter_type), allocatable, intent(out) :: parameters(:)
      type(string_type) :: objects(size(loaded%complete%groups))
      integer :: i, k, n, pass, v

      call name_groups(loaded%complete, loaded%schema, objects)
      n = 0
      do pass = 1, 2
         if (pass == 2) allocate(parameters(n))
         n = 0
         do i = 1, size(loaded%complete%groups)
            associate (group => loaded%schema%groups(loaded%complete%groups(i)%kind))
               if (group%spec%hidden .or. group%spec%name == constants_group) cycle
               if (objects(i)%s == "") cycle
               do k = 1, size(group%keys)
                  if (all(group%keys(k)%kind /= [kind_real, kind_integer])) cycle
                  call add_key(k)
               end do
            end associate
         end do
      end do

   contains

      !> Add the values of a key.
      subroutine add_key(k)
         !> Its position among the keys of the group.
         integer, intent(in) :: k
         integer :: s

         associate (stored => loaded%complete%groups(i), &
            group => loaded%schema%groups(loaded%complete%groups(i)%kind))
            do s = 1, stored%n
               if (stored%settings(s)%key == k) exit
            end do
            if (s > stored%n) then
               if (.not. group%defaults(k)%set) return
               do v = 1, size(group%defaults(k)%values)
                  call add(group%keys(k), v, group%defaults(k)%values(v)%real, .false.)
               end do
            else if (stored%settings(s)%set) then
               do v = 1, size(stored%settings(s)%values)
                  call add(group%keys(k), v, stored%settings(s)%values(v)%real, &
                     stored%settings(s)%given)
               end do
            end if
         end associate
      end subroutine add_key

      !> Add a number.
      subroutine add(key, slot, value, given)
         type(key_type), intent(in) :: key
         !> Which value of the key.
         integer, intent(in) :: slot
         real(wp), intent(in) :: value
         logical, intent(in) :: given

         n = n + 1
         if (pass == 1) return
         associate (parameter => parameters(n))
            parameter%name = objects(i)%s // "." // trim(key%name)
            if (key%values /= 1) parameter%name = parameter%name // "(" // to_text(slot) // ")"
            parameter%key = key
            parameter%value = value
            parameter%given = given
         end associate
      end subroutine add

   end subroutine list_parameters

   !> For each group what stands before the key in the names of its numbers; blank where nothing
   !> does.
   subroutine name_groups(settings, schema, objects)
      type(settings_type), intent(in), target :: settings
      type(schema_type), intent(in), target :: schema
      type(string_type), intent(out) :: objects(:)
      type(group_settings_type) :: group
      type(names_type) :: names
      integer :: numbers(size(objects)), shared(size(objects)), i, n

      n = 0
      shared = 0
      do i = 1, size(objects)
         group = settings%group(i, schema)
         objects(i)%s = lower(group%label())
         if (objects(i)%s == "") cycle
         numbers(i) = names%find(objects(i)%s)
         if (numbers(i) == 0) then
            n = n + 1
            numbers(i) = n
            call names%add(objects(i)%s, n)
         end if
         shared(numbers(i)) = shared(numbers(i)) + 1
      end do
      do i = 1, size(objects)
         associate (spec => schema%groups(settings%groups(i)%kind)%spec)
            if (objects(i)%s == "") then
               if (.not. spec%repeats) objects(i)%s = trim(spec%name)
            else if (shared(numbers(i)) > 1 .or. schema%find(objects(i)%s) > 0) then
               objects(i)%s = trim(spec%name) // "." // objects(i)%s
            end if
         end associate
      end do
   end subroutine name_groups

end module contensou_scene_parameters
