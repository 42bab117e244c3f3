!> Values that `--set PATH=VALUE` gives to keys of a document, and what a path stands for.
!>
!> PATH is `group.key` (every group of that name; one is added if there is none and it does not
!> repeat), `name.key`, or `group.name.key` where a name alone would be ambiguous; `(3)` after the
!> key stands for the third of its values.
module contensou_scene_overrides
   use contensou_base_diagnostics, only : diagnostics_type, origin_type
   use contensou_base_document, only : assignment_type, constants_group, document_type, &
      group_type, parse_value_list, value_expression, value_integer, value_text, value_type
   use contensou_base_document_types, only : move_assignment, resize_assignments, resize_groups
   use contensou_base_misprints, only : explain_comma
   use contensou_base_names, only : names_type
   use contensou_base_numbers, only : to_text
   use contensou_base_schema, only : is_number, schema_type
   use contensou_base_text, only : join, lower, nearest, quote, string_type
   implicit none(type, external)
   private

   public :: path_type, index_type
   public :: apply_override, find_path, index_groups, name_of, text_of, object_of_override

   !> What a path such as `top.position(3)` stands for.
   type :: path_type
      !> Name of the group or of what it describes.
      character(len=:), allocatable :: object
      character(len=:), allocatable :: key
      !> Which of its values; 0 for all.
      integer :: element = 0
      !> The groups of the document that are meant, ascending.
      integer, allocatable :: groups(:)
      !> Whether the document does not have the group, and it may be added.
      logical :: add_group = .false.
   end type path_type

   !> Where the groups of a document are found by what a path calls them: `&body` for all groups of
   !> one kind, the name that a group gives itself, and `&body.name`.
   type :: index_type
      private
      !> Numbers of the chains below.
      type(names_type) :: names
      integer :: n_chains = 0, n_links = 0
      !> First and last link of a chain.
      integer, allocatable :: first(:), last(:)
      !> For each link a group of the document, and the next link; 0 for none.
      integer, allocatable :: group(:), next(:)
   contains
      procedure, private :: add => add_link
      procedure, private :: groups => groups_of
   end type index_type

contains

   !> Find the groups of a document by their names.
   subroutine index_groups(document, schema, index)
      type(document_type), intent(in) :: document
      !> Its groups; each that does not repeat may be added later.
      type(schema_type), intent(in) :: schema
      type(index_type), intent(out) :: index
      integer :: i, n

      n = 3*(document%n_groups + size(schema%groups))
      allocate(index%first(n), index%last(n), index%group(n), index%next(n))
      do i = 1, document%n_groups
         call index_group(document%groups(i), i, index)
      end do
   end subroutine index_groups

   !> Add a group to an index.
   subroutine index_group(group, position, index)
      type(group_type), intent(in) :: group
      !> Its position in the document.
      integer, intent(in) :: position
      type(index_type), intent(inout) :: index
      character(len=:), allocatable :: name

      name = name_of(group)
      call index%add("&" // group%name, position)
      if (name == "") return
      call index%add(name, position)
      call index%add("&" // group%name // "." // name, position)
   end subroutine index_group

   !> Add a link at the end of a chain.
   subroutine add_link(self, name, group)
      class(index_type), intent(inout) :: self
      !> Name of the chain.
      character(len=*), intent(in) :: name
      integer, intent(in) :: group
      integer :: chain

      self%n_links = self%n_links + 1
      self%group(self%n_links) = group
      self%next(self%n_links) = 0
      chain = self%names%find(name)
      if (chain == 0) then
         self%n_chains = self%n_chains + 1
         chain = self%n_chains
         call self%names%add(name, chain)
         self%first(chain) = self%n_links
      else
         self%next(self%last(chain)) = self%n_links
      end if
      self%last(chain) = self%n_links
   end subroutine add_link

   !> The groups of a chain.
   pure function groups_of(self, name) result(groups)
      class(index_type), intent(in) :: self
      !> Name of the chain.
      character(len=*), intent(in) :: name
      integer, allocatable :: groups(:)
      integer :: chain, link, n, pass

      chain = self%names%find(name)
      do pass = 1, 2
         n = 0
         link = 0
         if (chain > 0) link = self%first(chain)
         do while (link > 0)
            n = n + 1
            if (pass == 2) groups(n) = self%group(link)
            link = self%next(link)
         end do
         if (pass == 1) allocate(groups(n))
      end do
   end function groups_of

   !> Replace or add values in a document, from `--set PATH=VALUE`.
   subroutine apply_override(document, schema, index_of, override, diagnostics)
      type(document_type), intent(inout) :: document
      type(schema_type), intent(in) :: schema
      !> Index of the groups of the document.
      type(index_type), intent(inout) :: index_of
      !> Text after `--set`.
      character(len=*), intent(in) :: override
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
      call parse_value_list(source_name, override(equals + 1:), values, document, diagnostics, &
         .true.)
      origin = origin_type(document%n_sources, 0, 0, 1)
      if (diagnostics%count() > n_before) return
      if (equals == 0) then
         call diagnostics%add(origin, "'=' is missing", &
            "--set group.key=value or --set name.key=value")
         return
      end if
      call find_path(document, schema, index_of, override(:equals - 1), origin, path, found, &
         diagnostics)
      if (.not. found) return
      if (path%element > 0 .and. size(values) /= 1) then
         call diagnostics%add(origin, "'" // path%key // "(" // &
            to_text(path%element) // ")' is one value", one_value(values))
         return
      end if
      if (path%add_group) then
         call add_group(document, path%object, origin)
         call index_group(document%groups(document%n_groups), document%n_groups, index_of)
         path%groups = [document%n_groups]
      end if
      if (.not. takes_numbers(path, document, schema)) then
         ! 'run-2' is no difference where a text is wanted.
         where (values%kind == value_expression) values%kind = value_text
      end if
      do i = 1, size(path%groups)
         call set_key(document%groups(path%groups(i)), schema, path%key, path%element, values, &
            origin)
      end do
   end subroutine apply_override

   !> What an element expects where several values stand: two may be a number with a decimal comma.
   pure function one_value(values) result(expected)
      type(value_type), intent(in) :: values(:)
      character(len=:), allocatable :: expected, number

      expected = "one value"
      if (size(values) /= 2) return
      if (any(values%kind /= value_integer)) return
      call explain_comma(values(1)%real, values(2)%real, values(2)%origin%length, number)
      expected = "one value; a decimal point in " // number // ", if that is meant"
   end function one_value

   !> Whether the key of a path takes numbers; so it is said of one that is not known.
   pure logical function takes_numbers(path, document, schema)
      type(path_type), intent(in) :: path
      type(document_type), intent(in) :: document
      type(schema_type), intent(in) :: schema
      integer :: g, k

      takes_numbers = .true.
      if (size(path%groups) == 0) return
      g = schema%find(document%groups(path%groups(1))%name)
      if (g == 0) return
      k = schema%groups(g)%position(path%key)
      if (k > 0) takes_numbers = is_number(schema%groups(g)%keys(k))
   end function takes_numbers

   !> What stands before the key in the path of an override, in lower case.
   pure function object_of_override(override) result(object)
      !> Text after `--set`.
      character(len=*), intent(in) :: override
      character(len=:), allocatable :: object

      object = lower(trim(adjustl(override(:max(index(override, "=") - 1, 0)))))
      object = object(:max(index(object, ".", back=.true.) - 1, 0))
   end function object_of_override

   !> Find what a path stands for, as `apply_override` takes it.
   subroutine find_path(document, schema, index_of, text, origin, path, found, diagnostics)
      type(document_type), intent(in) :: document
      type(schema_type), intent(in) :: schema
      !> Index of the groups of the document.
      type(index_type), intent(in) :: index_of
      !> The path.
      character(len=*), intent(in) :: text
      !> Where it stands, for messages.
      type(origin_type), intent(in) :: origin
      type(path_type), intent(out) :: path
      !> Whether there is such a group.
      logical, intent(out) :: found
      type(diagnostics_type), intent(inout) :: diagnostics
      character(len=:), allocatable :: whole
      integer :: dot, g, k

      found = .false.
      whole = lower(trim(adjustl(text)))
      call split_element(whole, path%element)
      dot = index(whole, ".", back=.true.)
      if (dot <= 1 .or. dot == len(whole) .or. path%element < 0) then
         call diagnostics%add(origin, "'" // lower(trim(adjustl(text))) // &
            "' does not say what to set", "group.key or name.key, as " // &
            example_of(document, schema, whole))
         return
      end if
      path%object = whole(:dot - 1)
      path%key = whole(dot + 1:)
      g = schema%find(path%object)
      if (g > 0) then
         path%groups = index_of%groups("&" // path%object)
         if (path%object == constants_group) path%groups = pack(path%groups, &
            [(document%groups(path%groups(k))%gives(path%key), k=1, size(path%groups))])
         path%add_group = size(path%groups) == 0 .and. .not. (schema%groups(g)%spec%repeats .or. &
            path%object == constants_group)
      else
         path%groups = named_groups(document, schema, index_of, path%object, path%key)
         if (size(path%groups) > 1) then
            if (.not. any([(has_key(g), g=1, size(path%groups))])) then
               call report_key(document, schema, path, origin, diagnostics)
            else
               call diagnostics%add(origin, "'" // whole // "' is ambiguous", "one of" // &
                  all_names())
            end if
            return
         end if
      end if
      found = size(path%groups) > 0 .or. path%add_group
      if (.not. found) call report_path(document, schema, path, origin, diagnostics)

   contains

      !> Whether a group that the path may mean has its key.
      logical function has_key(i)
         !> Index in the path.
         integer, intent(in) :: i
         integer :: kind

         kind = schema%find(document%groups(path%groups(i))%name)
         has_key = kind > 0
         if (has_key) has_key = schema%groups(kind)%position(path%key) > 0
      end function has_key

      !> Paths without ambiguity.
      function all_names() result(names)
         character(len=:), allocatable :: names
         integer :: i

         names = ""
         do i = 1, size(path%groups)
            names = names // " " // document%groups(path%groups(i))%name // "." // path%object // &
               "." // path%key
         end do
      end function all_names

   end subroutine find_path

   !> The groups that a name stands for before a key: those that have the key, if any group has it.
   function named_groups(document, schema, index_of, object, key) result(groups)
      type(document_type), intent(in) :: document
      type(schema_type), intent(in) :: schema
      !> Index of the groups of the document.
      type(index_type), intent(in) :: index_of
      !> The name, perhaps with that of its group before it.
      character(len=*), intent(in) :: object
      character(len=*), intent(in) :: key
      integer, allocatable :: groups(:)
      integer, allocatable :: more(:)
      logical, allocatable :: has(:)
      integer :: i

      groups = index_of%groups(object)
      if (index(object, ".") > 0) then
         more = index_of%groups("&" // object)
         groups = [groups, pack(more, [(all(groups /= more(i)), i=1, size(more))])]
      end if
      if (.not. any([(schema%groups(i)%position(key) > 0, i=1, size(schema%groups))])) return
      allocate(has(size(groups)))
      do i = 1, size(groups)
         has(i) = .false.
         associate (g => schema%find(document%groups(groups(i))%name))
            if (g > 0) has(i) = schema%groups(g)%position(key) > 0
         end associate
      end do
      groups = pack(groups, has)
   end function named_groups

   !> Report a key that none of the groups has which a path may mean.
   subroutine report_key(document, schema, path, origin, diagnostics)
      type(document_type), intent(in) :: document
      type(schema_type), intent(in) :: schema
      !> The path, with more than one group.
      type(path_type), intent(in) :: path
      type(origin_type), intent(in) :: origin
      type(diagnostics_type), intent(inout) :: diagnostics
      type(string_type), allocatable :: keys(:)
      character(len=:), allocatable :: kinds, right
      integer :: i, k, n, near

      n = 0
      do i = 1, size(path%groups)
         n = n + size(schema%groups(group(i))%keys)
      end do
      allocate(keys(n))
      n = 0
      kinds = ""
      do i = 1, size(path%groups)
         associate (kind => schema%groups(group(i)))
            do k = 1, size(kind%keys)
               if (any([(keys(near)%s == kind%keys(k)%name, near=1, n)])) cycle
               n = n + 1
               keys(n)%s = trim(kind%keys(k)%name)
            end do
         end associate
         if (kinds /= "") kinds = kinds // " and "
         kinds = kinds // "&" // document%groups(path%groups(i))%name
      end do
      right = "one of " // join(keys(:n), ", ")
      near = nearest(path%key, keys(:n))
      if (near > 0) then
         right = ""
         do i = 1, size(path%groups)
            if (schema%groups(group(i))%position(keys(near)%s) == 0) cycle
            if (right /= "") right = right // " or "
            right = right // document%groups(path%groups(i))%name // "." // path%object // "." // &
               keys(near)%s
         end do
      end if
      call diagnostics%add(origin, "unknown key '" // path%key // "' of '" // path%object // &
         "', " // kinds, right)

   contains

      !> What a group of the path is in the schema.
      integer function group(i)
         !> Index in the path.
         integer, intent(in) :: i

         group = schema%find(document%groups(path%groups(i))%name)
      end function group

   end subroutine report_key

   !> Report a path that stands for nothing.
   subroutine report_path(document, schema, path, origin, diagnostics)
      type(document_type), intent(in) :: document
      type(schema_type), intent(in) :: schema
      type(path_type), intent(in) :: path
      type(origin_type), intent(in) :: origin
      type(diagnostics_type), intent(inout) :: diagnostics
      type(string_type), allocatable :: names(:)
      logical, allocatable :: has(:)
      integer :: g, i, n

      if (path%object == constants_group .and. allocated(document%constant_names)) then
         if (size(document%constant_names) > 0) then
            i = nearest(path%key, document%constant_names)
            if (i > 0) then
               call diagnostics%add(origin, "there is no constant " // quote(path%key), &
                  constants_group // "." // document%constant_names(i)%s)
            else
               call diagnostics%add(origin, "there is no constant " // quote(path%key), &
                  "one of " // join(document%constant_names, ", "))
            end if
            return
         end if
      end if
      if (schema%find(path%object) > 0) then
         call diagnostics%add(origin, "the scene has no group &" // path%object, &
            "a group &" // path%object // " in the scene")
         return
      end if
      n = size(schema%groups)
      allocate(names(n + document%n_groups), has(n + document%n_groups))
      do i = 1, n
         names(i)%s = trim(schema%groups(i)%spec%name)
         has(i) = schema%groups(i)%position(path%key) > 0
      end do
      do i = 1, document%n_groups
         names(n + i)%s = name_of(document%groups(i))
         g = schema%find(document%groups(i)%name)
         has(n + i) = .false.
         if (g > 0) has(n + i) = schema%groups(g)%position(path%key) > 0
      end do
      ! What does not have the key is not meant, unless the key is mistyped, too.
      if (any(has)) names = pack(names, has)
      i = nearest(path%object, names)
      if (i > 0) then
         call diagnostics%add(origin, "the scene has no group or name '" // path%object // "'" // &
            " with a key '" // path%key // "'", names(i)%s // "." // path%key)
      else if (any(has(:n))) then
         call diagnostics%add(origin, "the scene has no group or name '" // path%object // "'" // &
            " with a key '" // path%key // "'", "the name of a group with that key: " // &
            example_of(document, schema, path%key))
      else
         call diagnostics%add(origin, "the scene has no group or name '" // path%object // "'", &
            "the name of a group, or of a body, surface, material or contact")
      end if
   end subroutine report_path

   !> A path to a key of the scene; some other path if no group of the scene has it.
   function example_of(document, schema, key) result(path)
      type(document_type), intent(in) :: document
      type(schema_type), intent(in) :: schema
      !> What is given.
      character(len=*), intent(in) :: key
      character(len=:), allocatable :: path
      integer :: g, i

      path = "integrator.rtol"
      do g = 1, size(schema%groups)
         if (schema%groups(g)%position(key) == 0) cycle
         do i = 1, document%n_groups
            if (document%groups(i)%name /= schema%groups(g)%spec%name) cycle
            path = trim(schema%groups(g)%spec%name)
            if (schema%groups(g)%spec%repeats .and. name_of(document%groups(i)) /= "") path = &
               name_of(document%groups(i))
            path = path // "." // key
            return
         end do
      end do
   end function example_of

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

      name = text_of(group, "name")
   end function name_of

   !> A text that a group of a document gives a key, in lower case; blank if none.
   pure function text_of(group, key, slot) result(text)
      type(group_type), intent(in) :: group
      character(len=*), intent(in) :: key
      !> Which of two values; the only one if not given.
      integer, intent(in), optional :: slot
      character(len=:), allocatable :: text
      integer :: i, k

      text = ""
      k = 1
      if (present(slot)) k = slot
      do i = 1, group%n_assignments
         if (group%assignments(i)%key /= key) cycle
         if (size(group%assignments(i)%values) < k) cycle
         if (size(group%assignments(i)%values) > 1 .and. .not. present(slot)) cycle
         if (group%assignments(i)%values(k)%kind == value_text) then
            text = lower(trim(adjustl(group%assignments(i)%values(k)%text)))
         end if
      end do
   end function text_of

   !> Add an empty group to a document.
   subroutine add_group(document, name, origin)
      type(document_type), intent(inout) :: document
      character(len=*), intent(in) :: name
      type(origin_type), intent(in) :: origin

      call resize_groups(document, document%n_groups + 1)
      document%n_groups = document%n_groups + 1
      associate (group => document%groups(document%n_groups))
         group%name = name
         group%origin = origin
         allocate(group%assignments(0))
      end associate
   end subroutine add_group

   !> Give a key of a group new values, in place of all that it had, or one of its values a new one.
   recursive subroutine set_key(group, schema, key, element, values, origin)
      type(group_type), intent(inout) :: group
      type(schema_type), intent(in) :: schema
      character(len=*), intent(in) :: key
      !> Which value is set; 0 for all.
      integer, intent(in) :: element
      type(value_type), intent(in) :: values(:)
      type(origin_type), intent(in) :: origin
      integer :: i, n, slot

      if (element > 0) then
         ! What the others would be if they are not given.
         if (.not. group%gives(key)) call &
            set_default_of(group, schema, key, origin)
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
      n = 0
      do i = 1, group%n_assignments
         if (group%assignments(i)%key == key .and. element == 0) cycle
         n = n + 1
         if (n < i) call move_assignment(group%assignments(i), group%assignments(n))
      end do
      group%n_assignments = n
      call resize_assignments(group, n + 1)
      group%n_assignments = n + 1
      associate (assignment => group%assignments(n + 1))
         assignment%key = key
         assignment%first = element
         assignment%last = element
         assignment%values = values
         assignment%origin = origin
      end associate
   end subroutine set_key

   !> Give a key of a group its default numbers, so that one of them can be set.
   recursive subroutine set_default_of(group, schema, key, origin)
      type(group_type), intent(inout) :: group
      type(schema_type), intent(in) :: schema
      character(len=*), intent(in) :: key
      type(origin_type), intent(in) :: origin
      type(value_type), allocatable :: values(:)
      integer :: g, k

      g = schema%find(group%name)
      if (g == 0) return
      k = schema%groups(g)%position(key)
      if (k == 0) return
      associate (of_key => schema%groups(g)%keys(k), default => schema%groups(g)%defaults(k))
         if (.not. is_number(of_key) .or. .not. default%set .or. of_key%values == 1) return
         values = default%values
      end associate
      values%origin = origin
      call set_key(group, schema, key, 0, values, origin)
   end subroutine set_default_of

end module contensou_scene_overrides
