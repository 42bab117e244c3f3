!> From a document to settings: every group and key is checked against a schema, one by one, and
!> every mistake is reported. What keys mean together is for those who read them.
module contensou_base_resolve
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite
   use contensou_base_constants, only : expression_value
   use contensou_base_diagnostics, only : diagnostics_type, origin_type
   use contensou_base_document_types, only : assignment_type, document_type, group_type, &
      value_expression, value_integer, value_logical, value_null, value_real, value_text, value_type
   use contensou_base_expressions, only : constants_type
   use contensou_base_kinds, only : wp
   use contensou_base_misprints, only : explain_comma, explain_misprint, explain_unit
   use contensou_base_numbers, only : power_text, to_text
   use contensou_base_schema, only : admits, any_number, domain_text, group_schema_type, &
      is_number, key_type, kind_any, kind_choice, kind_file, kind_integer, kind_logical, &
      kind_name, kind_real, kind_reference, kind_text, schema_type, setting_type
   use contensou_base_settings, only : group_settings_type, new_setting, settings_type, &
      stored_group_type
   use contensou_base_text, only : join, lower, nearest, plural, quote, string_type, strings
   implicit none(type, external)
   private

   public :: resolve, refuse_other_kind, take_value, expected_of, largest_number

   !> Bound of the magnitudes of numbers and of the inverses of those that are not zero, so that
   !> products of a few of them neither overflow nor vanish: SI values of this world are far within.
   real(wp), parameter :: largest_number = 1.0e40_wp

contains

   !> Refuse a scene where a sweep is wanted, and a sweep in place of a scene: one mistake, and not
   !> one for each of its groups.
   subroutine refuse_other_kind(document, wanted, other, message, expected, diagnostics, refused)
      type(document_type), intent(in) :: document
      !> Group that what is wanted has.
      character(len=*), intent(in) :: wanted
      !> Group that the other kind has.
      character(len=*), intent(in) :: other
      character(len=*), intent(in) :: message
      !> What would be right.
      character(len=*), intent(in) :: expected
      type(diagnostics_type), intent(inout) :: diagnostics
      logical, intent(out) :: refused
      integer :: i, found

      found = 0
      refused = .false.
      do i = 1, document%n_groups
         if (document%groups(i)%name == wanted) return
         if (found == 0 .and. document%groups(i)%name == other) found = i
      end do
      refused = found > 0
      if (refused) call diagnostics%add(document%groups(found)%origin, message, expected)
   end subroutine refuse_other_kind

   !> Check all groups and keys of a document against a schema.
   subroutine resolve(document, schema, settings, diagnostics)
      type(document_type), intent(in) :: document
      type(schema_type), intent(in), target :: schema
      !> What stands in the document.
      type(settings_type), intent(out), target :: settings
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: first(size(schema%groups)), kinds(document%n_groups)
      integer :: i, g, n

      first = 0
      kinds = 0
      allocate(settings%lost(size(schema%groups)), source=.not. document%complete)
      do i = 1, document%n_groups
         associate (group => document%groups(i))
            g = schema%find(group%name)
            if (g == 0) then
               call report_unknown(group)
               cycle
            end if
            if (first(g) > 0 .and. .not. schema%groups(g)%spec%repeats) then
               call diagnostics%add(group%origin, "group &" // group%name // " given twice", &
                  "one group &" // group%name // "; the first is in line " // &
                  to_text(document%groups(first(g))%origin%line))
               cycle
            end if
            if (first(g) == 0) first(g) = i
            kinds(i) = g
         end associate
      end do
      allocate(settings%groups(count(kinds > 0)))
      n = 0
      do i = 1, document%n_groups
         if (kinds(i) == 0) cycle
         n = n + 1
         settings%groups(n)%kind = kinds(i)
         call resolve_group(document%groups(i), schema, kinds(i), document%constants, &
            settings%groups(n), diagnostics)
         call check_complete(settings%group(n, schema), schema%groups(kinds(i)), diagnostics)
      end do
      do g = 1, size(schema%groups)
         associate (spec => schema%groups(g)%spec)
            if (first(g) > 0 .or. settings%lost(g) .or. .not. spec%mandatory) cycle
            call diagnostics%add(origin_type(1, 0, 0, 1), "there is no group &" // &
               trim(spec%name), "&" // trim(spec%name) // ": " // trim(spec%doc))
         end associate
      end do

   contains

      !> Report a group that the schema does not have.
      subroutine report_unknown(group)
         type(group_type), intent(in) :: group
         type(string_type) :: names(size(schema%groups))
         integer :: near

         do near = 1, size(names)
            names(near)%s = trim(schema%groups(near)%spec%name)
         end do
         near = nearest(group%name, names)
         if (near > 0) then
            settings%lost(near) = .true.
            call diagnostics%add(group%origin, "unknown group &" // group%name, &
               "&" // names(near)%s)
         else
            call diagnostics%add(group%origin, "unknown group &" // group%name // &
               trim(schema%owner), "one of &" // join(names, ", &"))
         end if
      end subroutine report_unknown

   end subroutine resolve

   !> Check the keys of a group.
   subroutine resolve_group(group, whole, kind, constants, stored, diagnostics)
      type(group_type), intent(in) :: group
      !> All groups.
      type(schema_type), intent(in) :: whole
      !> Which of them it is.
      integer, intent(in) :: kind
      !> Constants that its values may name.
      type(constants_type), intent(in) :: constants
      !> What is given in it.
      type(stored_group_type), intent(inout) :: stored
      type(diagnostics_type), intent(inout) :: diagnostics
      ! For each value of a setting, the line it was first given in; -1 after a mistake, 0 if it is
      ! not given.
      type :: lines_type
         integer, allocatable :: first(:)
      end type lines_type
      type(lines_type) :: given(group%n_assignments)
      integer :: i, k, s
      logical :: misspelt

      stored%origin = group%origin
      stored%complete = group%complete
      if (group%n_assignments > 0) allocate(stored%settings(group%n_assignments))
      associate (schema => whole%groups(kind))
         do i = 1, group%n_assignments
            associate (assignment => group%assignments(i))
               call find_key(assignment, whole, kind, k, misspelt, diagnostics)
               if (k == 0) cycle
               call new_setting(stored, schema, k, s)
               if (misspelt) then
                  stored%settings(s)%misspelt = .true.
                  cycle
               end if
               if (.not. allocated(given(s)%first)) allocate(given(s)%first(max(1, &
                  schema%keys(k)%values)), source=0)
               call take_assignment(assignment, schema%keys(k), schema%choices(k)%names, &
                  constants, stored%settings(s), given(s)%first, group%complete, diagnostics)
            end associate
         end do
         do s = 1, stored%n
            associate (setting => stored%settings(s), key => schema%keys(stored%settings(s)%key))
               if (.not. setting%given) cycle
               call check_given(key, given(s)%first, group%complete, setting, diagnostics)
            end associate
         end do
      end associate
   end subroutine resolve_group

   !> Whether all values of a key that is given are there and in order.
   subroutine check_given(key, first, complete, setting, diagnostics)
      type(key_type), intent(in) :: key
      !> For each value, the line it was given in; -1 after a mistake, 0 if it is not given.
      integer, intent(in) :: first(:)
      !> Whether the group was read without a mistake of syntax, which may have taken a value.
      logical, intent(in) :: complete
      type(setting_type), intent(inout) :: setting
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: n

      n = size(first)
      if (key%fewer) then
         n = max(1, findloc(first /= 0, .true., dim=1, back=.true.))
         if (size(setting%values) > n) setting%values = setting%values(:n)
      end if
      setting%set = all(first(:n) > 0)
      if (complete .and. any(first(:n) == 0)) call diagnostics%add(setting%origin, &
         "'" // trim(key%name) // "' has " // to_text(count(first /= 0)) // " of " // &
         to_text(n) // " values", expected_of(key))
   end subroutine check_given

   !> Whether a group has all keys that it must have.
   subroutine check_complete(group, schema, diagnostics)
      type(group_settings_type), intent(in) :: group
      type(group_schema_type), intent(in) :: schema
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: k

      do k = 1, size(schema%keys)
         associate (key => schema%keys(k))
            if (.not. key%mandatory) cycle
            if (group%lacks(key%name)) call diagnostics%add(group%origin, "'" // trim(key%name) // &
               "' is missing in group &" // trim(key%group) // group%named(), &
               trim(key%name) // " = " // expected_of(key))
         end associate
      end do
   end subroutine check_complete

   !> Find the key of an assignment among those of its group; one that is unknown is reported.
   subroutine find_key(assignment, schema, kind, position, misspelt, diagnostics)
      type(assignment_type), intent(in) :: assignment
      !> All groups.
      type(schema_type), intent(in) :: schema
      !> Which of them it stands in.
      integer, intent(in) :: kind
      !> Position of the key, or of the one that is likely meant; 0 if it is unknown.
      integer, intent(out) :: position
      !> Whether it is unknown and another one is likely meant.
      logical, intent(out) :: misspelt
      type(diagnostics_type), intent(inout) :: diagnostics

      type(string_type), allocatable :: keys(:)
      character(len=:), allocatable :: expected, owners, right
      integer :: k

      misspelt = .false.
      associate (group => schema%groups(kind))
         position = group%position(assignment%key)
         if (position > 0) return
         position = nearest(assignment%key, group%keys%name)
         misspelt = position > 0
         right = assignment%key
         owners = groups_with(schema, right)
         if (owners == "" .and. .not. misspelt) then
            call schema_keys(schema, keys)
            k = nearest(assignment%key, keys)
            if (k > 0) right = keys(k)%s
            owners = groups_with(schema, right)
         end if
         if (misspelt) then
            expected = trim(group%keys(position)%name)
         else if (owners == "") then
            expected = "one of " // join(strings(group%keys%name), ", ")
         end if
         if (owners /= "") then
            owners = "'" // right // "' in " // owners
            if (misspelt) owners = owners // ", or " // expected
            expected = owners
         end if
         call diagnostics%add(assignment%origin, "unknown key '" // assignment%key // &
            "' in group &" // trim(group%spec%name), expected)
      end associate
   end subroutine find_key

   !> The groups that have a key, as "&body or &surface"; empty if none has it.
   function groups_with(schema, key) result(text)
      type(schema_type), intent(in) :: schema
      character(len=*), intent(in) :: key
      character(len=:), allocatable :: text
      integer :: g

      text = ""
      do g = 1, size(schema%groups)
         if (schema%groups(g)%position(key) == 0) cycle
         if (text /= "") text = text // " or "
         text = text // "&" // trim(schema%groups(g)%spec%name)
      end do
   end function groups_with

   !> Names of the keys of all groups.
   subroutine schema_keys(schema, keys)
      type(schema_type), intent(in) :: schema
      type(string_type), allocatable, intent(out) :: keys(:)
      integer :: g, k, n

      n = 0
      do g = 1, size(schema%groups)
         n = n + size(schema%groups(g)%keys)
      end do
      allocate(keys(n))
      n = 0
      do g = 1, size(schema%groups)
         do k = 1, size(schema%groups(g)%keys)
            n = n + 1
            keys(n)%s = trim(schema%groups(g)%keys(k)%name)
         end do
      end do
   end subroutine schema_keys

   !> Take the values of an assignment.
   subroutine take_assignment(assignment, key, names, constants, setting, first, complete, &
      diagnostics)
      type(assignment_type), intent(in) :: assignment
      type(key_type), intent(in) :: key
      !> Names that the key admits, if it is a choice.
      type(string_type), intent(in) :: names(:)
      type(constants_type), intent(in) :: constants
      type(setting_type), intent(inout) :: setting
      !> For each value, the line it was first given in; -1 after a mistake, 0 if it is not given.
      integer, allocatable, intent(inout) :: first(:)
      !> Whether the group was read without a mistake of syntax.
      logical, intent(in) :: complete
      type(diagnostics_type), intent(inout) :: diagnostics
      character(len=:), allocatable :: message, right
      integer :: low, high, i, slot
      logical :: good

      low = max(assignment%first, 1)
      high = key%values
      if (high == any_number) high = max(size(assignment%values), 1)
      if (assignment%first > 0 .and. assignment%last >= 0) high = assignment%last
      if (key%values == any_number) then
         if (assignment%first /= 0) then
            call wrong(assignment%origin, "'" // trim(key%name) // "' takes no subscript")
            return
         end if
      else if (key%values == 1 .and. assignment%first /= 0 .or. high > key%values .or. &
         low > key%values) then
         call wrong(assignment%origin, "'" // trim(key%name) // "' has " // to_text(key%values) // &
            trim(merge(" value ", " values", key%values == 1)) // &
            ", the subscript is out of range")
         return
      end if
      if (size(assignment%values) > high - low + 1) then
         call explain_too_many(assignment, key, message, right)
         call diagnostics%add(assignment%values(high - low + 2)%origin, message, right)
         call lose()
         return
      end if
      if (size(assignment%values) == 0) then
         ! In a group with a mistake of syntax that mistake took the value.
         if (complete) call wrong(assignment%origin, "no value for '" // trim(key%name) // &
            "' in group &" // trim(key%group))
         call lose()
         return
      end if
      if (key%values == any_number .and. all(first == 0)) then
         deallocate(first, setting%values)
         allocate(first(high), source=0)
         allocate(setting%values(high))
      end if
      if (any(first(low:min(low + size(assignment%values) - 1, size(first))) /= 0)) then
         call diagnostics%add(assignment%origin, "'" // trim(key%name) // &
            "' given twice in group &" // trim(key%group), &
            "one of the two; the first is in line " // &
            to_text(maxval(abs(first(low:min(high, size(first)))))))
         return
      end if
      if (.not. setting%given) setting%origin = assignment%origin
      setting%given = .true.
      do i = 1, size(assignment%values)
         slot = low + i - 1
         call take_value(assignment%values(i), key, names, setting%values(slot), diagnostics, &
            good, constants)
         first(slot) = -1
         if (good) first(slot) = max(assignment%origin%line, 1)
      end do

   contains

      !> Report a mistake that leaves the key without values.
      subroutine wrong(origin, message)
         type(origin_type), intent(in) :: origin
         character(len=*), intent(in) :: message

         call diagnostics%add(origin, message, expected_of(key))
         call lose()
      end subroutine wrong

      !> Take the key for one that is given wrongly.
      subroutine lose()
         if (.not. setting%given) setting%origin = assignment%origin
         setting%given = .true.
         first = -1
      end subroutine lose

   end subroutine take_assignment

   !> Say of too many values what is wrong: often a comma is meant for a decimal point, or a unit
   !> stands in quotes.
   subroutine explain_too_many(assignment, key, words, right)
      type(assignment_type), intent(in) :: assignment
      type(key_type), intent(in) :: key
      !> What is wrong, and what would be right.
      character(len=:), allocatable, intent(out) :: words, right
      character(len=:), allocatable :: message, plain
      integer :: k, first_pair, pair

      words = "too many values for '" // trim(key%name) // "' in group &" // trim(key%group)
      right = expected_of(key)
      first_pair = 0
      pair = 0
      associate (values => assignment%values)
         do k = 1, merge(size(values) - 1, 0, is_number(key))
            if (values(k)%kind == value_real .or. values(k)%kind == value_integer) then
               if (values(k + 1)%kind == value_text) then
                  call explain_unit(to_text(values(k)%real), values(k + 1)%text, .true., &
                     message, plain)
                  if (.not. allocated(message)) cycle
                  words = words // ": " // message
                  right = plain
                  pair = 0
                  first_pair = 0
                  exit
               end if
            end if
            if (values(k)%kind /= value_integer .or. .not. any(values(k + 1)%kind == &
               [value_integer, value_real])) cycle
            associate (a => values(k)%origin, b => values(k + 1)%origin)
               if (a%line /= b%line .or. b%column /= a%column + a%length + 1) cycle
            end associate
            if (first_pair == 0) first_pair = k
            ! 0,0 is less likely meant for one number than 9,81.
            if (pair == 0 .and. values(k + 1)%real > 0.0_wp) pair = k
         end do
         if (pair == 0) pair = first_pair
         if (pair > 0) then
            message = "its place"
            if (values(pair + 1)%kind == value_integer) call explain_comma(values(pair)%real, &
               values(pair + 1)%real, values(pair + 1)%origin%length, message)
            words = words // ": a comma separates values"
            right = right // "; a decimal point in " // message // ", if that is meant"
         end if
      end associate
   end subroutine explain_too_many

   !> Check a value against the kind and the domain of its key.
   subroutine take_value(value, key, names, taken, diagnostics, good, constants)
      type(value_type), intent(in) :: value
      type(key_type), intent(in) :: key
      !> Names that the key admits, if it is a choice.
      type(string_type), intent(in) :: names(:)
      !> The value in order; what it was before, but for its place, after a mistake.
      type(value_type), intent(inout) :: taken
      type(diagnostics_type), intent(inout) :: diagnostics
      !> Whether the value is in order.
      logical, intent(out) :: good
      !> Constants that the value may name; without them it is no expression.
      type(constants_type), intent(in), optional :: constants
      type(value_type) :: number
      logical :: is_number_now

      good = .false.
      taken%origin = value%origin
      if (value%kind == value_null) then
         call wrong(value, key, "a value of '" // trim(key%name) // "' is missing in group &" // &
            trim(key%group), diagnostics)
         return
      end if
      select case (key%kind)
      case (kind_real, kind_integer)
         if (value%kind == value_text .or. value%kind == value_expression) then
            call compute(value, key, number, is_number_now, diagnostics, good, constants)
            if (is_number_now .and. good) call take_number(number, key, taken, diagnostics, good)
         else
            call take_number(value, key, taken, diagnostics, good)
         end if
      case (kind_logical)
         if (value%kind /= value_logical) then
            call wrong(value, key, "'" // trim(key%name) // "' needs a logical, this is a " // &
               kind_word(value), diagnostics)
            return
         end if
         taken = value
         good = .true.
      case (kind_any)
         if (value%kind == value_expression) then
            call compute(value, key, number, is_number_now, diagnostics, good, constants)
            taken = number
            return
         end if
         if (value%kind == value_real .or. value%kind == value_integer) then
            if (.not. ieee_is_finite(value%real)) then
               call wrong(value, key, "'" // trim(key%name) // "' must be finite", diagnostics)
               return
            end if
         end if
         taken = value
         if (value%kind == value_integer) taken%kind = value_real
         if (value%kind == value_text) taken%text = trim(adjustl(value%text))
         good = .true.
      case default
         call take_text(value, key, names, taken, diagnostics, good)
      end select
   end subroutine take_value

   !> Report a mistake in a value.
   subroutine wrong(value, key, message, diagnostics)
      type(value_type), intent(in) :: value
      type(key_type), intent(in) :: key
      character(len=*), intent(in) :: message
      type(diagnostics_type), intent(inout) :: diagnostics

      call diagnostics%add(value%origin, message, expected_of(key))
   end subroutine wrong

   !> Compute an expression.
   subroutine compute(value, key, number, is_one, diagnostics, good, constants)
      type(value_type), intent(in) :: value
      type(key_type), intent(in) :: key
      !> What it comes to, as a real.
      type(value_type), intent(out) :: number
      !> Whether it is one; what is not is reported as what it is.
      logical, intent(out) :: is_one
      type(diagnostics_type), intent(inout) :: diagnostics
      !> Whether it is one without a mistake.
      logical, intent(out) :: good
      !> Constants that it may name; without them nothing is an expression.
      type(constants_type), intent(in), optional :: constants
      character(len=:), allocatable :: message, right

      is_one = .false.
      good = .false.
      number%kind = value_real
      number%origin = value%origin
      if (present(constants)) call expression_value(value, constants, number%real, is_one, &
         diagnostics, good)
      if (is_one .and. good .and. key%unit /= "" .and. key%unit /= "model" .and. &
         index(key%unit, "rad") == 0) then
         if (is_in_degrees(value%text)) then
            good = .false.
            call wrong(value, key, "'deg' behind a number: '" // trim(key%name) // &
               "' is no angle", diagnostics)
         end if
      end if
      if (is_one) return
      good = .false.
      call explain_misprint(value%text, message, right)
      if (allocated(message)) then
         call diagnostics%add(value%origin, "'" // trim(key%name) // "' needs a number: " // &
            message, right)
      else
         call wrong(value, key, "'" // trim(key%name) // "' needs a number, this is a " // &
            kind_word(value), diagnostics)
      end if
   end subroutine compute

   !> A number: finite, in the domain of its key, whole if that is so.
   subroutine take_number(value, key, taken, diagnostics, good)
      type(value_type), intent(in) :: value
      type(key_type), intent(in) :: key
      !> The number in order; what it was before after a mistake.
      type(value_type), intent(inout) :: taken
      type(diagnostics_type), intent(inout) :: diagnostics
      logical, intent(out) :: good

      good = .false.
      if (value%kind /= value_integer .and. value%kind /= value_real) then
         call wrong(value, key, "'" // trim(key%name) // "' needs a number, this is a " // &
            kind_word(value), diagnostics)
      else if (.not. ieee_is_finite(value%real)) then
         call wrong(value, key, "'" // trim(key%name) // "' must be finite", diagnostics)
      else if (abs(value%real) > largest_number .or. (abs(value%real) > 0.0_wp .and. &
         abs(value%real) < 1.0_wp/largest_number)) then
         call wrong(value, key, "'" // trim(key%name) // "' is beyond what can be computed " // &
            "with, magnitudes from " // power_text(1.0_wp/largest_number, 2) // " to " // &
            power_text(largest_number, 2), diagnostics)
      else if (.not. admits(key, value%real)) then
         call wrong(value, key, "'" // trim(key%name) // "' is out of range", diagnostics)
      else if (key%kind == kind_integer .and. abs(value%real - anint(value%real)) > 0.0_wp) then
         call wrong(value, key, "'" // trim(key%name) // "' must be whole", diagnostics)
      else
         taken%kind = value_real
         taken%real = value%real
         good = .true.
      end if
   end subroutine take_number

   !> Take a text, or find a choice among the names of its key.
   subroutine take_text(value, key, names, taken, diagnostics, good)
      type(value_type), intent(in) :: value
      type(key_type), intent(in) :: key
      !> Names that the key admits, if it is a choice.
      type(string_type), intent(in) :: names(:)
      !> The text, or the choice with its number.
      type(value_type), intent(inout) :: taken
      type(diagnostics_type), intent(inout) :: diagnostics
      logical, intent(out) :: good
      integer :: choice

      good = .false.
      if (value%kind /= value_text) then
         call wrong(value, key, "'" // trim(key%name) // "' needs a text in quotes, this is a " // &
            kind_word(value), diagnostics)
         return
      end if
      taken%kind = value_text
      taken%text = trim(adjustl(value%text))
      taken%integer = 0
      ! A text may be empty where that is what it is by default.
      if (taken%text == "" .and. .not. (key%kind == kind_text .and. key%default == "''")) then
         call wrong(value, key, "'" // trim(key%name) // "' is empty", diagnostics)
         return
      end if
      if (key%kind == kind_choice) then
         call find_choice(taken%text, names, trim(key%name), value%origin, choice, diagnostics)
         if (choice == 0) return
         taken%integer = choice
         taken%text = names(choice)%s
      end if
      good = .true.
   end subroutine take_text

   !> Whether an expression is a number with the unit of an angle.
   pure logical function is_in_degrees(text)
      character(len=*), intent(in) :: text
      integer :: n

      n = len_trim(text) - 3
      is_in_degrees = .false.
      if (n < 2) return
      is_in_degrees = lower(text(n + 1:n + 3)) == "deg" .and. text(n:n) == " " .and. &
         verify(text(:n), "0123456789.+-eEdD ") == 0
   end function is_in_degrees

   !> Find a choice among the names of its key; one that is unknown is reported.
   subroutine find_choice(text, names, key, origin, choice, diagnostics)
      !> The choice, in upper or lower case.
      character(len=*), intent(in) :: text
      !> The names that the key admits.
      type(string_type), intent(in) :: names(:)
      character(len=*), intent(in) :: key
      type(origin_type), intent(in) :: origin
      !> Its position in `names`; 0 if it is unknown.
      integer, intent(out) :: choice
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
      case (value_expression)
         word = "number"
      case default
         word = "number"
      end select
   end function kind_word

   !> What a key wants, in words.
   function expected_of(key) result(text)
      type(key_type), intent(in) :: key
      character(len=:), allocatable :: text

      select case (key%kind)
      case (kind_real, kind_integer)
         text = domain_text(key)
      case (kind_logical)
         text = ".true. or .false."
      case (kind_any)
         text = "numbers, texts in quotes or logicals"
      case (kind_choice)
         text = "one of " // join(key%names(), ", ") // ", in quotes"
         if (key%fewer) text = "up to " // to_text(key%values) // " of" // text(7:)
      case (kind_reference)
         text = "the name of a " // trim(key%target) // " in quotes"
         if (key%values == 2) text = "the names of two " // plural(key%target) // " in quotes"
      case (kind_name)
         text = "a name in quotes"
      case (kind_file)
         text = "the name of a file in quotes"
      case default
         text = "a text in quotes"
         if (key%values == any_number) text = text // ", any number of them"
      end select
   end function expected_of

end module contensou_base_resolve
