!> Groups `contacts`: one for the contacts between all pairs of two lists or patterns of surfaces.
module contensou_scene_pair_patterns
   use contensou_base_diagnostics, only : diagnostics_type, origin_type
   use contensou_base_document, only : document_type, group_type
   use contensou_base_document_types, only : append_text, move_group, resize_groups, selection
   use contensou_base_names, only : names_type
   use contensou_base_numbers, only : to_text
   use contensou_base_resolve, only : resolve
   use contensou_base_schema, only : schema_type
   use contensou_base_settings, only : group_settings_type, settings_type
   use contensou_base_patterns, only : matches_pattern
   use contensou_base_text, only : lower, nearest, quote, string_type
   use contensou_dynamics_scene, only : motion_names, moves_freely
   use contensou_scene_overrides, only : name_of, text_of
   implicit none(type, external)
   private

   public :: expand_pairs, pairs_group

   character(len=*), parameter :: pairs_group = "contacts"

   !> Keys of a group `contacts` that its contacts do not have.
   character(len=*), parameter :: own_keys(*) = [character(len=8) :: "name", "surfaces", "first", &
      "second"]

   !> Most contacts that the groups of a scene can stand for.
   integer, parameter :: most_contacts = 1000000

   !> The surfaces of a scene.
   type :: surfaces_type
      !> Names as written.
      type(string_type), allocatable :: names(:)
      !> Number of the body of each; 0 for the ground, -1 if it is not known.
      integer, allocatable :: body(:)
      !> Whether that body can move.
      logical, allocatable :: moves(:)
      !> Pairs that have a contact of their own.
      type(names_type) :: taken
      !> Pairs of groups `contacts` so far, by the line of their group.
      type(names_type) :: claimed
   end type surfaces_type

   !> Contacts in the making.
   type :: list_type
      integer :: n = 0
      !> The first and the second surface of each, the first `n` of them.
      integer, allocatable :: pairs(:, :)
   end type list_type

contains

   !> Put contacts in the place of every group `contacts`.
   subroutine expand_pairs(document, schema, diagnostics)
      !> The document; it is no longer complete when a group has a mistake.
      type(document_type), intent(inout) :: document
      type(schema_type), intent(in), target :: schema
      type(diagnostics_type), intent(inout) :: diagnostics
      type(settings_type), target :: settings
      type(diagnostics_type) :: found
      type(surfaces_type) :: surfaces
      type(document_type) :: part, expanded
      type(list_type), allocatable :: lists(:)
      integer :: before, g, i, k, n

      part = selection(document, pairs_group)
      if (part%n_groups == 0) return
      before = diagnostics%count()
      ! A group with a mistake is left as it is, and the mistake is found when all are read.
      call resolve(part, schema, settings, found)
      if (found%count() > 0) document%complete = .false.
      if (.not. document%complete) return
      call collect(document, surfaces)
      allocate(lists(size(settings%groups)))
      n = document%n_groups
      do i = 1, size(lists)
         call find_pairs(settings%group(i, schema), surfaces, lists(i), diagnostics)
         n = n - 1 + lists(i)%n
      end do
      if (diagnostics%count() > before) then
         document%complete = .false.
         return
      end if
      allocate(expanded%groups(n))
      n = 0
      g = 0
      do i = 1, document%n_groups
         if (document%groups(i)%name /= pairs_group) then
            n = n + 1
            call move_group(document%groups(i), expanded%groups(n))
            cycle
         end if
         g = g + 1
         do k = 1, lists(g)%n
            n = n + 1
            call make_contact(document%groups(i), surfaces%names(lists(g)%pairs(1, k))%s, &
               surfaces%names(lists(g)%pairs(2, k))%s, expanded%groups(n))
         end do
      end do
      call move_alloc(expanded%groups, document%groups)
      document%n_groups = n
      call resize_groups(document, n)
   end subroutine expand_pairs

   !> Collect the surfaces of a document, and the pairs that have contacts of their own.
   subroutine collect(document, surfaces)
      type(document_type), intent(in) :: document
      type(surfaces_type), intent(out) :: surfaces
      type(names_type) :: bodies
      character(len=:), allocatable :: motion
      logical, allocatable :: moves(:)
      integer :: i, k, n

      n = document%n_groups
      allocate(moves(n), source=.false.)
      do i = 1, n
         if (document%groups(i)%name /= "body") cycle
         call bodies%add(name_of(document%groups(i)), i)
         motion = text_of(document%groups(i), "motion")
         moves(i) = motion == ""
         do k = 1, size(motion_names)
            if (motion_names(k) == motion) moves(i) = moves_freely(k)
         end do
      end do
      n = count([(document%groups(i)%name == "surface", i=1, document%n_groups)])
      allocate(surfaces%names(n), surfaces%body(n), surfaces%moves(n))
      n = 0
      do i = 1, document%n_groups
         associate (group => document%groups(i))
            select case (group%name)
            case ("surface")
               n = n + 1
               surfaces%names(n)%s = name_of(group)
               surfaces%body(n) = bodies%find(text_of(group, "body"))
               if (surfaces%body(n) == 0 .and. text_of(group, "body") /= "ground") then
                  surfaces%body(n) = -i
               end if
               surfaces%moves(n) = surfaces%body(n) < 0
               if (surfaces%body(n) > 0) surfaces%moves(n) = moves(surfaces%body(n))
            case ("contact")
               call surfaces%taken%add(pair_name(text_of(group, "surfaces", 1), &
                  text_of(group, "surfaces", 2)), i)
            case default
               continue
            end select
         end associate
      end do
   end subroutine collect

   !> Name of a pair, whichever is first.
   pure function pair_name(a, b) result(name)
      character(len=*), intent(in) :: a, b
      character(len=:), allocatable :: name

      if (llt(a, b)) then
         name = a // achar(0) // b
      else
         name = b // achar(0) // a
      end if
   end function pair_name

   !> Pairs of surfaces that a group `contacts` means, each once.
   subroutine find_pairs(group, surfaces, list, diagnostics)
      type(group_settings_type), intent(in) :: group
      type(surfaces_type), intent(inout) :: surfaces
      type(list_type), intent(out) :: list
      type(diagnostics_type), intent(inout) :: diagnostics
      logical, dimension(size(surfaces%names)) :: in_first, in_second
      integer, allocatable :: a(:), b(:)
      character(len=:), allocatable :: pair
      integer :: before, i, j, line

      before = diagnostics%count()
      allocate(list%pairs(2, 0))
      in_first = .false.
      in_second = .false.
      if (group%is_given("surfaces")) then
         call group%refuse("first", "the surfaces are given twice", &
            "either surfaces = 'A', 'B', or first and second", diagnostics)
         call group%refuse("second", "the surfaces are given twice", &
            "either surfaces = 'A', 'B', or first and second", diagnostics)
         call choose("surfaces", 1, in_first)
         call choose("surfaces", 2, in_second)
      else if (group%is_given("first") .or. group%is_given("second")) then
         call group%require("first", group%origin, "'first' is missing in group &contacts", &
            "first = names or patterns of surfaces", diagnostics)
         call group%require("second", group%origin, "'second' is missing in group &contacts", &
            "second = names or patterns of surfaces", diagnostics)
         do i = 1, group%count("first")
            call choose("first", i, in_first)
         end do
         do i = 1, group%count("second")
            call choose("second", i, in_second)
         end do
      else
         call diagnostics%add(group%origin, "'surfaces' is missing in group &contacts", &
            "surfaces = two names or patterns in quotes, or first and second, lists of them")
      end if
      if (diagnostics%count() > before) return
      a = pack([(i, i=1, size(in_first))], in_first)
      b = pack([(i, i=1, size(in_second))], in_second)
      deallocate(list%pairs)
      allocate(list%pairs(2, 16))
      do i = 1, size(a)
         do j = 1, size(b)
            if (surfaces%body(a(i)) == surfaces%body(b(j))) cycle
            if (.not. (surfaces%moves(a(i)) .or. surfaces%moves(b(j)))) cycle
            ! Of a pair that both lists have either way round the first one counts.
            if (in_first(b(j)) .and. in_second(a(i)) .and. a(i) > b(j)) cycle
            pair = pair_name(lower(surfaces%names(a(i))%s), lower(surfaces%names(b(j))%s))
            if (surfaces%taken%find(pair) > 0) cycle
            line = surfaces%claimed%find(pair)
            if (line > 0) then
               call diagnostics%add(group%origin, "surfaces " // quote(surfaces%names(a(i))%s) // &
                  " and " // quote(surfaces%names(b(j))%s) // " are a pair of the group " // &
                  "&contacts in line " // to_text(line) // ", too: their forces would add up", &
                  "each pair in one group; a group &contact of its own for a pair that differs")
               return
            end if
            call surfaces%claimed%add(pair, max(group%origin%line, 1))
            if (list%n == most_contacts) then
               call diagnostics%add(group%origin, "the group stands for more than " // &
                  to_text(most_contacts) // " contacts", "narrower patterns")
               return
            end if
            call append(list, [a(i), b(j)])
         end do
      end do
      if (list%n == 0) call diagnostics%add(group%origin, "group &contacts stands for no " // &
         "contact: its pairs are of one body, cannot move, or have contacts of their own", &
         "surfaces of two bodies, one of which can move")

   contains

      !> Choose the surfaces that a name or pattern of the group stands for.
      subroutine choose(key, slot, chosen)
         character(len=*), intent(in) :: key
         !> Which of its values.
         integer, intent(in) :: slot
         logical, intent(inout) :: chosen(:)
         character(len=:), allocatable :: pattern, right
         logical :: found
         integer :: near, s

         pattern = lower(group%text(key, slot))
         if (pattern == "") return
         found = .false.
         do s = 1, size(chosen)
            if (.not. matches_pattern(pattern, lower(surfaces%names(s)%s))) cycle
            chosen(s) = .true.
            found = .true.
         end do
         if (found) return
         right = "the name of a group &surface, or a pattern of names, with * for any characters"
         near = nearest(pattern, surfaces%names)
         if (near > 0) right = quote(surfaces%names(near)%s)
         if (scan(pattern, "*?") > 0) then
            call diagnostics%add(group%place(key, slot), "no surface matches " // &
               quote(group%text(key, slot)), right)
         else
            call diagnostics%add(group%place(key, slot), "there is no surface " // &
               quote(group%text(key, slot)), right)
         end if
      end subroutine choose

   end subroutine find_pairs

   subroutine append(list, pair)
      type(list_type), intent(inout) :: list
      integer, intent(in) :: pair(2)
      integer, allocatable :: bigger(:, :)

      if (list%n == size(list%pairs, 2)) then
         allocate(bigger(2, 2*list%n))
         bigger(:, :list%n) = list%pairs
         call move_alloc(bigger, list%pairs)
      end if
      list%n = list%n + 1
      list%pairs(:, list%n) = pair
   end subroutine append

   !> A contact of a pair.
   subroutine make_contact(group, first, second, contact)
      !> The group that stands for it.
      type(group_type), intent(in) :: group
      !> Names of its surfaces.
      character(len=*), intent(in) :: first, second
      type(group_type), intent(inout) :: contact
      character(len=:), allocatable :: name
      type(origin_type) :: place
      integer :: i, n

      contact%name = "contact"
      contact%origin = group%origin
      contact%complete = group%complete
      allocate(contact%assignments(group%n_assignments + 2))
      name = first // "_" // second
      place = group%origin
      n = 0
      do i = 1, group%n_assignments
         associate (given => group%assignments(i))
            if (given%key == "name") name = trim(adjustl(given%values(1)%text)) // "_" // name
            if (any(given%key == [character(len=8) :: "surfaces", "first"])) place = given%origin
            if (any(own_keys == given%key)) cycle
            n = n + 1
            contact%assignments(n) = given
         end associate
      end do
      contact%n_assignments = n
      call append_text(contact, "name", name, place)
      call append_text(contact, "surfaces", first, place, second)
   end subroutine make_contact

end module contensou_scene_pair_patterns
