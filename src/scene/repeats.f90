!> Bodies with a `count`: many alike in a row, a grid, a ring or a triangle, with their surfaces.
module contensou_scene_repeats
   use contensou_base_diagnostics, only : diagnostics_type, origin_type
   use contensou_base_document, only : document_type, group_type, value_real
   use contensou_base_document_types, only : move_group, resize_groups, selection
   use contensou_base_kinds, only : i8, pi, wp
   use contensou_base_names, only : names_type
   use contensou_base_numbers, only : to_text
   use contensou_base_resolve, only : resolve
   use contensou_base_schema, only : schema_type
   use contensou_base_settings, only : group_settings_type, settings_type
   use contensou_base_text, only : lower, quote
   use contensou_scene_overrides, only : name_of, text_of
   implicit none(type, external)
   private

   public :: expand_repeats, arrangement_names, repeat_keys

   !> How bodies can be arranged.
   character(len=*), parameter :: arrangement_names(*) = [character(len=8) :: "row", "grid", &
      "ring", "triangle"]

   integer, parameter :: in_row = 1, in_grid = 2, in_ring = 3, in_triangle = 4

   !> The keys of a body that say how often it is there.
   character(len=*), parameter :: repeat_keys(*) = [character(len=11) :: "count", "spacing", &
      "ring_radius", "arrangement"]

   !> Most bodies that one group can stand for.
   integer(i8), parameter :: most_bodies = 100000_i8

   !> A body that stands for many.
   type :: repeat_type
      character(len=:), allocatable :: name
      !> Their places against the position of the group [m].
      real(wp), allocatable :: offsets(:, :)
      !> Position of the group [m].
      real(wp) :: position(3) = 0.0_wp
      type(origin_type) :: origin
   end type repeat_type

contains

   !> Put many bodies with their surfaces in the place of every body with a `count`: NAME_1, NAME_2
   !> and so on.
   subroutine expand_repeats(document, schema, diagnostics)
      !> The document; it is no longer complete when a body has a mistake.
      type(document_type), intent(inout) :: document
      type(schema_type), intent(in), target :: schema
      type(diagnostics_type), intent(inout) :: diagnostics
      type(settings_type), target :: bodies
      type(diagnostics_type) :: found
      type(repeat_type), allocatable :: repeats(:)
      type(document_type) :: part, expanded
      type(names_type) :: names
      integer :: before, i, k, n, r

      part = selection(document, "body", "count")
      if (part%n_groups == 0) return
      before = diagnostics%count()
      ! A body with a mistake is left as it is, and the mistake is found when all bodies are read.
      call resolve(part, schema, bodies, found)
      if (found%count() > 0) document%complete = .false.
      if (.not. document%complete) return
      allocate(repeats(size(bodies%groups)))
      do i = 1, size(repeats)
         call read_repeat(bodies%group(i, schema), repeats(i), diagnostics)
         if (repeats(i)%name /= "") call names%add(repeats(i)%name, i)
      end do
      if (diagnostics%count() > before) then
         document%complete = .false.
         return
      end if
      n = 0
      do i = 1, document%n_groups
         r = repeat_of(document%groups(i))
         if (r == 0) n = n + 1
         if (r > 0) n = n + size(repeats(r)%offsets, 2)
      end do
      allocate(expanded%groups(n))
      n = 0
      do i = 1, document%n_groups
         r = repeat_of(document%groups(i))
         if (r == 0) then
            n = n + 1
            call move_group(document%groups(i), expanded%groups(n))
            cycle
         end if
         do k = 1, size(repeats(r)%offsets, 2)
            n = n + 1
            call copy(document%groups(i), repeats(r), k, expanded%groups(n))
         end do
      end do
      call move_alloc(expanded%groups, document%groups)
      document%n_groups = n
      call resize_groups(document, n)

   contains

      !> Number of the repeated body that a group is or is a surface of; 0 for none.
      integer function repeat_of(group)
         type(group_type), intent(in) :: group

         repeat_of = 0
         select case (group%name)
         case ("body")
            repeat_of = names%find(name_of(group))
         case ("surface")
            repeat_of = names%find(text_of(group, "body"))
         case default
            continue
         end select
      end function repeat_of

   end subroutine expand_repeats

   !> One of the bodies, or of their surfaces.
   subroutine copy(group, repeat, k, one)
      !> The group that stands for all.
      type(group_type), intent(in) :: group
      type(repeat_type), intent(in) :: repeat
      !> Which one.
      integer, intent(in) :: k
      type(group_type), intent(inout) :: one
      character(len=:), allocatable :: name
      integer :: i, n

      one%name = group%name
      one%origin = group%origin
      one%complete = group%complete
      allocate(one%assignments(group%n_assignments + 1))
      n = 0
      do i = 1, group%n_assignments
         associate (given => group%assignments(i))
            if (group%name == "body") then
               if (any(repeat_keys == given%key) .or. given%key == "position") cycle
            end if
            n = n + 1
            one%assignments(n) = given
            if (size(given%values) /= 1) cycle
            if (.not. (given%key == "name" .or. group%name == "surface" .and. &
               given%key == "body")) cycle
            if (.not. allocated(given%values(1)%text)) cycle
            name = trim(adjustl(given%values(1)%text)) // "_" // to_text(k)
            one%assignments(n)%values(1)%text = name
         end associate
      end do
      one%n_assignments = n
      if (group%name /= "body") return
      n = n + 1
      one%n_assignments = n
      associate (assignment => one%assignments(n))
         assignment%key = "position"
         assignment%origin = repeat%origin
         allocate(assignment%values(3))
         assignment%values%kind = value_real
         assignment%values%real = repeat%position + repeat%offsets(:, k)
         assignment%values%origin = repeat%origin
      end associate
   end subroutine copy

   !> Read how many bodies there are and where.
   subroutine read_repeat(group, repeat, diagnostics)
      type(group_settings_type), intent(in) :: group
      type(repeat_type), intent(out) :: repeat
      type(diagnostics_type), intent(inout) :: diagnostics
      real(wp) :: spacing(3), numbers(3), radius
      integer :: counts(3), arrangement, before, k, n
      integer(i8) :: all_of_them
      logical :: good

      repeat%name = lower(group%label())
      allocate(repeat%offsets(3, 0))
      before = diagnostics%count()
      repeat%position = group%numbers("position")
      repeat%origin = group%place("position")
      if (.not. group%is_set("count")) return
      n = group%count("count")
      counts = 1
      numbers = group%numbers("count")
      counts(:n) = nint(numbers(:n))
      arrangement = group%choice("arrangement")
      if (arrangement == 0) then
         arrangement = in_row
         if (n > 1) arrangement = in_grid
         if (group%is_given("ring_radius")) arrangement = in_ring
      end if
      if (arrangement /= in_grid .and. n > 1) call diagnostics%add(group%place("count", 2), &
         "'count' has one value for arrangement = " // &
         quote(trim(arrangement_names(arrangement))), "a whole number, or arrangement = 'grid'")
      if (arrangement /= in_ring) call group%refuse("ring_radius", &
         "'ring_radius' has no meaning for arrangement = " // &
         quote(trim(arrangement_names(arrangement))), "spacing, or arrangement = 'ring'", &
         diagnostics)
      all_of_them = product(int(counts, i8))
      if (arrangement == in_triangle) all_of_them = int(counts(1), i8)*(counts(1) + 1)/2
      if (all_of_them > most_bodies) call diagnostics%add(group%place("count", 1), &
         "the group stands for " // to_text(all_of_them) // " bodies", "at most " // &
         to_text(most_bodies))
      spacing = group%numbers("spacing")
      if (arrangement == in_ring) then
         if (group%is_given("spacing") .and. group%is_given("ring_radius")) then
            call group%refuse("spacing", "the size of the ring is given twice", &
               "either ring_radius or spacing", diagnostics)
         else if (.not. group%is_given("spacing")) then
            call group%require("ring_radius", group%place("count"), "a ring needs its radius", &
               "ring_radius = a number > 0.0 [m], or spacing", diagnostics)
         end if
      else if (all_of_them > 1) then
         call group%require("spacing", group%place("count"), "'count' needs 'spacing'", &
            spacing_words(arrangement), diagnostics)
      end if
      if (group%is_set("spacing")) then
         k = group%count("spacing")
         select case (arrangement)
         case (in_row)
            good = counts(1) == 1 .or. any(abs(spacing) > 0.0_wp)
         case (in_grid)
            good = k == n .and. all(counts == 1 .or. abs(spacing) > 0.0_wp)
         case default
            good = k == 1 .and. spacing(1) > 0.0_wp
         end select
         if (.not. good) call diagnostics%add(group%place("spacing", 1), &
            "'spacing' is not what " // quote(trim(arrangement_names(arrangement))) // " needs", &
            spacing_words(arrangement))
      end if
      if (diagnostics%count() > before) return
      deallocate(repeat%offsets)
      allocate(repeat%offsets(3, all_of_them), source=0.0_wp)
      radius = group%number("ring_radius")
      if (arrangement == in_ring .and. .not. group%is_set("ring_radius")) radius = &
         spacing(1)/(2.0_wp*sin(pi/max(counts(1), 2)))
      call set_offsets(arrangement, counts, spacing, radius, repeat%offsets)
   end subroutine read_repeat

   !> Where the bodies of an arrangement are.
   pure subroutine set_offsets(arrangement, counts, spacing, radius, offsets)
      integer, intent(in) :: arrangement
      !> Number of bodies along each axis.
      integer, intent(in) :: counts(3)
      !> Distance along each axis [m].
      real(wp), intent(in) :: spacing(3)
      !> Radius of a ring [m].
      real(wp), intent(in) :: radius
      !> Offset of each body from the first or from the centre of the ring [m], (3, bodies); zero
      !> before.
      real(wp), intent(inout) :: offsets(:, :)
      integer :: i, k, row

      k = 1
      row = 0
      do i = 0, size(offsets, 2) - 1
         associate (offset => offsets(:, i + 1))
            select case (arrangement)
            case (in_row)
               offset = i*spacing
            case (in_grid)
               offset = spacing*[mod(i, counts(1)), mod(i/counts(1), counts(2)), &
                  i/(counts(1)*counts(2))]
            case (in_ring)
               offset(1:2) = radius*[cos(2.0_wp*pi*i/counts(1)), sin(2.0_wp*pi*i/counts(1))]
            case default
               ! Rows of 1, 2, 3, ... bodies along the first axis; k counts those of the row.
               offset(1) = 0.5_wp*sqrt(3.0_wp)*row*spacing(1)
               offset(2) = (k - 1 - 0.5_wp*row)*spacing(1)
               k = k + 1
               if (k > row + 1) then
                  row = row + 1
                  k = 1
               end if
            end select
         end associate
      end do
   end subroutine set_offsets

   !> What `spacing` has to be.
   pure function spacing_words(arrangement) result(text)
      integer, intent(in) :: arrangement
      character(len=:), allocatable :: text

      select case (arrangement)
      case (in_row)
         text = "spacing = the step from one body to the next, up to 3 numbers, not all 0 [m]"
      case (in_grid)
         text = "spacing = the distances along x, y and z, one for each count, not 0 [m]"
      case default
         text = "spacing = the distance of neighbours, a number > 0.0 [m]"
      end select
   end function spacing_words

end module contensou_scene_repeats
