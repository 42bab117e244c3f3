!> Names of the groups of a scene, and what refers to them.
module contensou_scene_references
   use contensou_base_diagnostics, only : diagnostics_type
   use contensou_base_names, only : names_type
   use contensou_base_numbers, only : to_text
   use contensou_base_schema, only : schema_type
   use contensou_base_settings, only : group_settings_type, settings_type
   use contensou_base_text, only : lower, quote, string_type
   implicit none(type, external)
   private

   public :: references_type, collect_names

   !> The groups of one kind.
   type :: members_type
      !> Their positions in the settings by their names.
      type(names_type) :: names
      integer :: n = 0
      !> Whether the names of some could not be read.
      logical :: unreadable = .false.
   end type members_type

   !> Names of all groups.
   type :: references_type
      !> The groups of each kind of the schema.
      type(members_type), allocatable :: kinds(:)
      !> For each group, its number among those of its kind.
      integer, allocatable :: numbers(:)
      !> For each group, its label.
      type(string_type), allocatable :: labels(:)
   contains
      procedure :: find
      procedure :: count => count_members
   end type references_type

   character(len=*), parameter :: ground = "ground"

contains

   !> Collect the names of all groups. They must be unique among groups of one kind.
   subroutine collect_names(settings, schema, references, diagnostics)
      type(settings_type), intent(in), target :: settings
      type(schema_type), intent(in), target :: schema
      type(references_type), intent(out) :: references
      type(diagnostics_type), intent(inout) :: diagnostics
      type(group_settings_type) :: group, first
      integer :: i, known

      allocate(references%kinds(size(schema%groups)), references%numbers(size(settings%groups)), &
         references%labels(size(settings%groups)))
      references%kinds%unreadable = settings%lost
      do i = 1, size(settings%groups)
         group = settings%group(i, schema)
         references%labels(i)%s = group%label()
         associate (members => references%kinds(group%kind), name => references%labels(i)%s)
            members%n = members%n + 1
            references%numbers(i) = members%n
            if (name == "") members%unreadable = .true.
            if (name == "") cycle
            if (group%group_name() == "body" .and. lower(name) == ground) then
               call diagnostics%add(group%place("name", 1), &
                  "the name 'ground' is taken by the predeclared fixed body", "another name")
            end if
            known = members%names%find(name)
            if (known > 0) then
               first = settings%group(known, schema)
               associate (place => first%place("name", 1))
                  call diagnostics%add(group%place("name", 1), "there are two groups &" // &
                     trim(group%group_name()) // " with the name " // quote(name), &
                     "another name; the first is in line " // to_text(place%line))
               end associate
            end if
            call members%names%add(name, i)
         end associate
      end do
      ! The last candidate for a misspelt name is the predeclared body.
      i = schema%find("body")
      if (i > 0) call references%kinds(i)%names%add(ground, huge(i))
   end subroutine collect_names

   !> Index of what a reference names; 0 for the ground, or after a mistake.
   subroutine find(self, group, name, slot, index, diagnostics)
      class(references_type), intent(in) :: self
      type(group_settings_type), intent(in) :: group
      !> The key that refers.
      character(len=*), intent(in) :: name
      !> Which of its values.
      integer, intent(in) :: slot
      !> Number of the group among those of its kind.
      integer, intent(out) :: index
      type(diagnostics_type), intent(inout) :: diagnostics
      character(len=:), allocatable :: wanted, target, right
      integer :: at

      index = 0
      if (.not. group%is_set(name)) return
      target = group%target(name)
      wanted = group%text(name, slot)
      if (target == "body" .and. lower(wanted) == ground) return
      associate (members => self%kinds(group%target_kind(name)))
         at = members%names%find(wanted)
         if (at > 0) index = self%numbers(at)
         ! A name that could not be read may be the one.
         if (at > 0 .or. members%unreadable) return
         right = "the name of a group &" // target
         if (.not. diagnostics%is_full()) then
            at = members%names%nearest(wanted)
            if (at == huge(at)) then
               right = quote(ground)
            else if (at > 0) then
               right = quote(self%labels(at)%s)
            end if
            if (group%group_name() == "contact" .and. scan(wanted, "*?") > 0) then
               right = "the name of one surface; a group &contacts takes patterns"
            end if
         end if
         call diagnostics%add(group%place(name, slot), "there is no " // target // " " // &
            quote(wanted), right)
      end associate
   end subroutine find

   !> Number of groups of a kind.
   pure integer function count_members(self, kind)
      class(references_type), intent(in) :: self
      !> Position of the kind of group in the schema.
      integer, intent(in) :: kind

      count_members = self%kinds(kind)%n
   end function count_members

end module contensou_scene_references
