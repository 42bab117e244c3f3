!> Keys that groups of a scene or a sweep can have, and the values that a user gave to them.
!>
!> What owns parameters, as a law of friction or a shape, says by rows of `key_type` which keys it
!> has and reads their values from the settings of its group. Nobody else knows them.
!>
!> The keys and their defaults are stored once, in a `schema_type`; for a group only what is given
!> in it. `group_settings_type` is a view on both.
module contensou_base_settings
   use contensou_base_diagnostics, only : diagnostics_type, origin_type
   use contensou_base_document_types, only : value_integer, value_logical, value_null, value_real, &
      value_text, value_type
   use contensou_base_kinds, only : i8, wp
   use contensou_base_text, only : quote, string_type, text_buffer_type, to_text
   implicit none(type, external)
   private

   public :: key_type, key_list_type, group_spec_type, group_schema_type, schema_type
   public :: setting_type, stored_group_type, settings_type, group_settings_type
   public :: kind_real, kind_text, kind_name, kind_choice, kind_reference, kind_logical, &
      kind_integer, kind_any, kind_file
   public :: admits, domain_text, is_number, most_values, any_number, new_schema, new_setting
   public :: choice_names

   !> Real numbers.
   integer, parameter :: kind_real = 1

   !> Any text.
   integer, parameter :: kind_text = 2

   !> The name of what the group describes.
   integer, parameter :: kind_name = 3

   !> One of the names in a table of the program.
   integer, parameter :: kind_choice = 4

   !> The name of something described elsewhere in the scene.
   integer, parameter :: kind_reference = 5

   integer, parameter :: kind_logical = 6

   !> Whole numbers.
   integer, parameter :: kind_integer = 7

   !> Numbers, texts or logicals.
   integer, parameter :: kind_any = 8

   !> The name of a file.
   integer, parameter :: kind_file = 9

   !> Largest number of values of a key that has a number of them.
   integer, parameter :: most_values = 12

   !> A key that takes any number of values has this number of values.
   integer, parameter :: any_number = 0

   !> Numbers of a domain beyond this are not shown: they are bounds of what can be stored.
   real(wp), parameter :: largest_shown = 2.0_wp**31

   abstract interface
      !> Names that a key of `kind_choice` admits.
      function choice_names() result(names)
         import :: string_type
         implicit none(type, external)
         type(string_type), allocatable :: names(:)
      end function choice_names
   end interface

   !> A key.
   type :: key_type
      !> Group it belongs to.
      character(len=12) :: group = ""
      character(len=28) :: name = ""
      !> What its values are, one of the `kind_*` codes.
      integer :: kind = kind_real
      !> Number of values, or `any_number`.
      integer :: values = 1
      !> Whether fewer values will do.
      logical :: fewer = .false.
      !> Whether it must be given.
      logical :: mandatory = .false.
      !> Default in namelist syntax; empty when there is none or it depends on the scene.
      character(len=64) :: default = ""
      character(len=12) :: unit = ""
      !> Smallest number.
      real(wp) :: low = -huge(1.0_wp)
      !> Largest number.
      real(wp) :: high = huge(1.0_wp)
      !> Whether `low` itself is excluded.
      logical :: above_low = .false.
      !> For a choice, the names that it admits.
      procedure(choice_names), pointer, nopass :: choices => null()
      !> For a reference, the group it refers to.
      character(len=12) :: target = ""
      !> What it means.
      character(len=400) :: doc = ""
   end type key_type

   !> Keys in the making of a table.
   type :: key_list_type
      !> Number of keys.
      integer :: n = 0
      !> The keys, the first `n` of them.
      type(key_type), allocatable :: keys(:)
   contains
      procedure :: put
      procedure :: append
   end type key_list_type

   !> A group.
   type :: group_spec_type
      character(len=12) :: name = ""
      !> Whether it may stand more than once.
      logical :: repeats = .false.
      !> Whether it must be there.
      logical :: mandatory = .false.
      !> What it describes.
      character(len=160) :: doc = ""
      !> Whether it is left out of the settings as a text when nothing in it is given.
      logical :: hidden = .false.
   end type group_spec_type

   !> What a group says about a key.
   type :: setting_type
      !> Position of the key among those of its group.
      integer :: key = 0
      !> Whether the user gave it, rightly or not.
      logical :: given = .false.
      !> Whether it is likely given under a misspelt name.
      logical :: misspelt = .false.
      !> Whether it has a usable value, given or default.
      logical :: set = .false.
      !> Where the key stands, or the group if it is not given.
      type(origin_type) :: origin
      !> Its values: those of the default where there are none. That of a choice has its name as
      !> text, and its position among the names as integer.
      type(value_type), allocatable :: values(:)
   end type setting_type

   !> Names that a key admits.
   type :: choices_type
      type(string_type), allocatable :: names(:)
   end type choices_type

   !> A group with its keys.
   type :: group_schema_type
      type(group_spec_type) :: spec
      type(key_type), allocatable :: keys(:)
      !> What each key is when it is not given.
      type(setting_type), allocatable :: defaults(:)
      !> For each key, the names that it admits; none if it is no choice.
      type(choices_type), allocatable :: choices(:)
      !> For each key, the position of the group that it refers to; 0 if it is no reference.
      integer, allocatable :: targets(:)
   end type group_schema_type

   !> The groups that a scene or a sweep can have.
   type :: schema_type
      type(group_schema_type), allocatable :: groups(:)
      !> What has these groups, for messages, as " in a sweep"; blank where that is plain.
      character(len=16) :: owner = ""
   contains
      procedure :: find => find_group
   end type schema_type

   !> What stands in a group.
   type :: stored_group_type
      !> Position of the group in the schema.
      integer :: kind = 0
      type(origin_type) :: origin
      !> Whether it was read without a mistake of syntax.
      logical :: complete = .true.
      !> Number of settings.
      integer :: n = 0
      !> What is given, the first `n` of them, and what is derived.
      type(setting_type), allocatable :: settings(:)
   end type stored_group_type

   !> The settings of a scene or a sweep.
   type :: settings_type
      !> The groups in the order of the file.
      type(stored_group_type), allocatable :: groups(:)
      !> For each group of the schema, whether some may be missing because of a mistake of syntax
      !> or because their name is misspelt.
      logical, allocatable :: lost(:)
   contains
      procedure :: group => view_group
      procedure :: text => settings_text
      procedure :: add_missing
   end type settings_type

   !> View on a group and its keys. It is of use as long as the settings and the schema it was made
   !> from are there and no group is added.
   type :: group_settings_type
      !> Position of the group in the schema.
      integer :: kind = 0
      type(origin_type) :: origin
      !> Whether it was read without a mistake of syntax.
      logical :: complete = .true.
      type(group_schema_type), pointer, private :: schema => null()
      type(stored_group_type), pointer, private :: stored => null()
   contains
      procedure :: group_name
      procedure :: label
      procedure :: named
      procedure :: key
      procedure :: target => target_of
      procedure :: target_kind
      procedure :: given_keys
      procedure :: is_given
      procedure :: is_misspelt
      procedure :: is_set
      procedure :: lacks
      procedure :: count => count_values
      procedure :: number
      procedure :: numbers
      procedure :: vector
      procedure :: integer => whole_number
      !> Whole number of a key, with eight bytes.
      procedure :: long_integer
      procedure :: text
      procedure :: flag
      procedure :: choice
      procedure :: choices
      procedure :: value
      procedure :: values => all_values
      procedure :: place
      procedure :: require
      procedure :: refuse
      procedure :: derive_number
      procedure :: derive_text
      procedure :: unset
      procedure, private :: locate
      procedure, private :: at
   end type group_settings_type

contains

   !> Add a key.
   subroutine put(self, group, name, kind, doc, values, unit, default, mandatory, above, least, &
      most, target, fewer, choices)
      class(key_list_type), intent(inout) :: self
      character(len=*), intent(in) :: group
      character(len=*), intent(in) :: name
      !> What its values are.
      integer, intent(in) :: kind
      !> What it means.
      character(len=*), intent(in) :: doc
      integer, intent(in), optional :: values
      character(len=*), intent(in), optional :: unit
      !> Default in namelist syntax.
      character(len=*), intent(in), optional :: default
      !> Whether it must be given.
      logical, intent(in), optional :: mandatory
      !> Numbers are larger than this.
      real(wp), intent(in), optional :: above
      !> Numbers are at least this.
      real(wp), intent(in), optional :: least
      !> Numbers are at most this.
      real(wp), intent(in), optional :: most
      !> Group that a reference refers to.
      character(len=*), intent(in), optional :: target
      !> Whether fewer values will do.
      logical, intent(in), optional :: fewer
      !> Names that a choice admits.
      procedure(choice_names), optional :: choices

      call self%append(key_type())
      associate (key => self%keys(self%n))
         key%group = group
         key%name = name
         key%kind = kind
         key%doc = doc
         if (present(values)) key%values = values
         if (present(unit)) key%unit = unit
         if (present(default)) key%default = default
         if (present(mandatory)) key%mandatory = mandatory
         if (present(above)) key%low = above
         key%above_low = present(above)
         if (present(least)) key%low = least
         if (present(most)) key%high = most
         if (present(target)) key%target = target
         if (present(fewer)) key%fewer = fewer
         if (present(choices)) key%choices => choices
      end associate
   end subroutine put

   !> Add a key that is one of another list.
   subroutine append(self, key)
      class(key_list_type), intent(inout) :: self
      type(key_type), intent(in) :: key
      type(key_type), allocatable :: bigger(:)

      if (.not. allocated(self%keys)) allocate(self%keys(32))
      if (self%n == size(self%keys)) then
         allocate(bigger(2*self%n))
         bigger(:self%n) = self%keys
         call move_alloc(bigger, self%keys)
      end if
      self%n = self%n + 1
      self%keys(self%n) = key
   end subroutine append

   !> Whether the values of a key are numbers.
   elemental logical function is_number(key)
      type(key_type), intent(in) :: key

      is_number = key%kind == kind_real .or. key%kind == kind_integer
   end function is_number

   !> Whether a finite number is in the domain of a key.
   pure logical function admits(key, x)
      type(key_type), intent(in) :: key
      real(wp), intent(in) :: x

      admits = x >= key%low .and. x <= key%high
      if (key%above_low) admits = admits .and. x > key%low
   end function admits

   !> Domain and unit of the numbers of a key in words, as "a number > 0 [kg]".
   pure function domain_text(key) result(text)
      type(key_type), intent(in) :: key
      character(len=:), allocatable :: text
      character(len=:), allocatable :: noun, relation

      noun = "number"
      if (key%kind == kind_integer) noun = "whole number"
      text = "a " // noun
      if (key%values > 1) text = to_text(key%values) // " " // noun // "s"
      if (key%fewer) text = "up to " // text
      relation = " >= "
      if (key%above_low) relation = " > "
      if (key%low > -huge(key%low)) text = text // relation // shown(key%low)
      if (key%high < huge(key%high) .and. .not. (key%kind == kind_integer .and. &
         key%high > largest_shown)) then
         if (key%low > -huge(key%low)) text = text // " and"
         text = text // " <= " // shown(key%high)
      end if
      if (key%unit == "model") then
         text = text // " [unit of the law]"
      else if (key%unit == "1" .and. key%kind == kind_real) then
         text = text // " [-]"
      else if (key%unit /= "1" .and. key%unit /= "") then
         text = text // " [" // trim(key%unit) // "]"
      end if
      if (key%values == any_number) text = text // ", any number of them"

   contains

      !> A bound.
      pure function shown(x) result(digits)
         real(wp), intent(in) :: x
         character(len=:), allocatable :: digits

         if (key%kind == kind_integer) then
            digits = to_text(nint(x, i8))
         else
            digits = to_text(x)
         end if
      end function shown

   end function domain_text

   !> A schema from its groups and the keys of all of them, in the order of the documentation.
   subroutine new_schema(groups, keys, schema, owner)
      type(group_spec_type), intent(in) :: groups(:)
      type(key_type), intent(in) :: keys(:)
      type(schema_type), intent(out) :: schema
      !> What has these groups, for messages.
      character(len=*), intent(in), optional :: owner
      integer :: g, k

      if (present(owner)) schema%owner = owner
      allocate(schema%groups(size(groups)))
      do g = 1, size(groups)
         associate (group => schema%groups(g))
            group%spec = groups(g)
            group%keys = pack(keys, keys%group == groups(g)%name)
            allocate(group%defaults(size(group%keys)), group%choices(size(group%keys)), &
               group%targets(size(group%keys)))
            do k = 1, size(group%keys)
               if (associated(group%keys(k)%choices)) then
                  group%choices(k)%names = group%keys(k)%choices()
               else
                  allocate(group%choices(k)%names(0))
               end if
               group%targets(k) = findloc(groups%name == group%keys(k)%target, .true., dim=1)
               group%defaults(k)%key = k
               call set_default(group%keys(k), group%choices(k)%names, group%defaults(k))
            end do
         end associate
      end do
   end subroutine new_schema

   !> Give a key its default, if it has one.
   subroutine set_default(key, names, setting)
      type(key_type), intent(in) :: key
      !> Names that it admits, for a choice.
      type(string_type), intent(in) :: names(:)
      type(setting_type), intent(inout) :: setting
      character(len=:), allocatable :: text
      real(wp) :: numbers(most_values)
      integer :: i, k, first, last, n

      text = trim(key%default)
      setting%set = text /= ""
      n = key%values
      if (key%fewer .or. n == any_number) then
         n = 0
         if (setting%set) n = count([(text(i:i) == ",", i=1, len(text))]) + 1
      end if
      allocate(setting%values(n))
      if (.not. setting%set) return
      select case (key%kind)
      case (kind_real, kind_integer)
         read(text, *) numbers(:n)
         setting%values%kind = value_real
         setting%values%real = numbers(:n)
      case (kind_logical)
         setting%values%kind = value_logical
         setting%values%logical = text == ".true."
      case default
         last = 0
         do k = 1, n
            first = last + index(text(last + 1:), "'") + 1
            last = first + index(text(first:), "'") - 1
            setting%values(k)%kind = value_text
            setting%values(k)%text = text(first:last - 1)
            do i = 1, size(names)
               if (names(i)%s == setting%values(k)%text) setting%values(k)%integer = i
            end do
         end do
      end select
   end subroutine set_default

   !> Position of a group in a schema; 0 if it does not have it.
   pure integer function find_group(self, name)
      class(schema_type), intent(in) :: self
      character(len=*), intent(in) :: name

      do find_group = 1, size(self%groups)
         if (self%groups(find_group)%spec%name == name) return
      end do
      find_group = 0
   end function find_group

   !> Position of the setting of a key in a stored group; one with the values of the default is
   !> added if there is none.
   pure subroutine new_setting(stored, schema, key, position)
      type(stored_group_type), intent(inout) :: stored
      type(group_schema_type), intent(in) :: schema
      !> Position of the key among them.
      integer, intent(in) :: key
      !> Position in `stored%settings`.
      integer, intent(out) :: position
      integer :: n

      do position = 1, stored%n
         if (stored%settings(position)%key == key) return
      end do
      if (.not. allocated(stored%settings)) allocate(stored%settings(4))
      if (stored%n == size(stored%settings)) call resize_settings(stored, 2*stored%n)
      stored%n = stored%n + 1
      position = stored%n
      associate (setting => stored%settings(position), default => schema%defaults(key))
         setting%key = key
         setting%set = default%set
         setting%origin = stored%origin
         allocate(setting%values(max(size(default%values), schema%keys(key)%values)))
         n = size(default%values)
         setting%values(:n) = default%values
         setting%values%origin = stored%origin
      end associate
   end subroutine new_setting

   !> Change the room for settings.
   pure subroutine resize_settings(stored, n)
      type(stored_group_type), intent(inout) :: stored
      !> Number of settings, not below that of those there are.
      integer, intent(in) :: n
      type(setting_type), allocatable :: resized(:)
      integer :: i

      allocate(resized(n))
      do i = 1, stored%n
         resized(i)%key = stored%settings(i)%key
         resized(i)%given = stored%settings(i)%given
         resized(i)%misspelt = stored%settings(i)%misspelt
         resized(i)%set = stored%settings(i)%set
         resized(i)%origin = stored%settings(i)%origin
         call move_alloc(stored%settings(i)%values, resized(i)%values)
      end do
      call move_alloc(resized, stored%settings)
   end subroutine resize_settings

   !> A group with its keys.
   function view_group(self, i, schema) result(group)
      class(settings_type), intent(in), target :: self
      !> Position of the group.
      integer, intent(in) :: i
      type(schema_type), intent(in), target :: schema
      type(group_settings_type) :: group

      group%kind = self%groups(i)%kind
      group%origin = self%groups(i)%origin
      group%complete = self%groups(i)%complete
      group%stored => self%groups(i)
      group%schema => schema%groups(self%groups(i)%kind)
   end function view_group

   !> The settings as a namelist text: every key that has a value, defaults included.
   function settings_text(self, schema) result(text)
      class(settings_type), intent(in) :: self
      type(schema_type), intent(in) :: schema
      character(len=:), allocatable :: text
      type(text_buffer_type) :: buffer
      integer :: i, k, s

      do i = 1, size(self%groups)
         associate (stored => self%groups(i), group => schema%groups(self%groups(i)%kind))
            if (group%spec%hidden .and. stored%n == 0) cycle
            call buffer%add("&" // trim(group%spec%name) // new_line("a"))
            do k = 1, size(group%keys)
               do s = 1, stored%n
                  if (stored%settings(s)%key == k) exit
               end do
               if (s <= stored%n) then
                  call add_setting(stored%settings(s))
               else
                  call add_setting(group%defaults(k))
               end if
            end do
            call buffer%add("/" // new_line("a"))
         end associate
      end do
      text = buffer%text()

   contains

      !> Add a key and its values.
      subroutine add_setting(setting)
         type(setting_type), intent(in) :: setting
         integer :: v

         if (.not. setting%set) return
         associate (key => schema%groups(self%groups(i)%kind)%keys(setting%key))
            call buffer%add("   " // trim(key%name) // " = ")
            do v = 1, size(setting%values)
               if (v > 1) call buffer%add(", ")
               associate (value => setting%values(v))
                  select case (value%kind)
                  case (value_real, value_integer)
                     call buffer%add(to_text(value%real))
                  case (value_logical)
                     call buffer%add(to_text(value%logical))
                  case default
                     call buffer%add(quote(value%text))
                  end select
               end associate
            end do
            call buffer%add(new_line("a"))
         end associate
      end subroutine add_setting

   end function settings_text

   !> Add the groups that may be left out and do not repeat, with their defaults.
   subroutine add_missing(self, schema)
      class(settings_type), intent(inout) :: self
      type(schema_type), intent(in) :: schema
      type(stored_group_type), allocatable :: groups(:)
      logical :: missing(size(schema%groups))
      integer :: g, i, n

      missing = .not. (schema%groups%spec%repeats .or. schema%groups%spec%mandatory)
      do i = 1, size(self%groups)
         missing(self%groups(i)%kind) = .false.
      end do
      n = size(self%groups)
      allocate(groups(n + count(missing)))
      do i = 1, n
         groups(i)%kind = self%groups(i)%kind
         groups(i)%origin = self%groups(i)%origin
         groups(i)%complete = self%groups(i)%complete
         groups(i)%n = self%groups(i)%n
         call move_alloc(self%groups(i)%settings, groups(i)%settings)
      end do
      do g = 1, size(missing)
         if (.not. missing(g)) cycle
         n = n + 1
         groups(n)%kind = g
         groups(n)%origin = origin_type(1, 0, 0, 1)
      end do
      call move_alloc(groups, self%groups)
   end subroutine add_missing

   !> Position of a key among those of a group; the key must exist.
   pure integer function at(self, name)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name

      do at = 1, size(self%schema%keys)
         if (self%schema%keys(at)%name == name) return
      end do
      error stop "a key is asked for that the schema does not have"
   end function at

   !> Where a key has its values: position of its setting if the group has one, and that among the
   !> keys.
   pure subroutine locate(self, name, s, k)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name
      !> Position among the settings of the group; 0 if the default is in force.
      integer, intent(out) :: s
      !> Position among the keys.
      integer, intent(out) :: k

      k = self%at(name)
      do s = 1, self%stored%n
         if (self%stored%settings(s)%key == k) return
      end do
      s = 0
   end subroutine locate

   !> Name of the group, as "body".
   pure function group_name(self) result(name)
      class(group_settings_type), intent(in) :: self
      character(len=:), allocatable :: name

      name = trim(self%schema%spec%name)
   end function group_name

   !> Value of the key `name` of a group; blank if it has none.
   pure function label(self) result(name)
      class(group_settings_type), intent(in) :: self
      character(len=:), allocatable :: name
      integer :: s

      name = ""
      do s = 1, self%stored%n
         associate (setting => self%stored%settings(s))
            if (self%schema%keys(setting%key)%kind == kind_name .and. setting%set) then
               name = setting%values(1)%text
            end if
         end associate
      end do
   end function label

   !> " 'label'" for messages; nothing if the group has no name.
   pure function named(self) result(text)
      class(group_settings_type), intent(in) :: self
      character(len=:), allocatable :: text

      text = self%label()
      if (text /= "") text = " " // quote(text)
   end function named

   !> A key.
   pure function key(self, name)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name
      type(key_type) :: key

      key = self%schema%keys(self%at(name))
   end function key

   !> Name of the group that a key refers to.
   pure function target_of(self, name) result(target)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name
      character(len=:), allocatable :: target

      target = trim(self%schema%keys(self%at(name))%target)
   end function target_of

   !> Position in the schema of the group that a key refers to.
   pure integer function target_kind(self, name)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name

      target_kind = self%schema%targets(self%at(name))
   end function target_kind

   !> Names of the keys that the user gave, rightly or not.
   pure function given_keys(self) result(names)
      class(group_settings_type), intent(in) :: self
      type(string_type), allocatable :: names(:)
      integer :: n, s

      associate (settings => self%stored%settings, n_all => self%stored%n)
         allocate(names(count([(settings(s)%given, s=1, n_all)])))
         n = 0
         do s = 1, n_all
            if (.not. settings(s)%given) cycle
            n = n + 1
            names(n)%s = trim(self%schema%keys(settings(s)%key)%name)
         end do
      end associate
   end function given_keys

   !> Whether the user gave a key, rightly or not.
   pure logical function is_given(self, name)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name
      integer :: s, k

      call self%locate(name, s, k)
      is_given = .false.
      if (s > 0) is_given = self%stored%settings(s)%given
   end function is_given

   !> Whether a key is likely given under a misspelt name.
   pure logical function is_misspelt(self, name)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name
      integer :: s, k

      call self%locate(name, s, k)
      is_misspelt = .false.
      if (s > 0) is_misspelt = self%stored%settings(s)%misspelt
   end function is_misspelt

   !> Whether a key has a usable value, given or default.
   pure logical function is_set(self, name)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name
      integer :: s, k

      call self%locate(name, s, k)
      if (s > 0) then
         is_set = self%stored%settings(s)%set
      else
         is_set = self%schema%defaults(k)%set
      end if
   end function is_set

   !> Whether a key is not given, nor under a misspelt name or in a part that could not be read.
   pure logical function lacks(self, name)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name

      lacks = self%complete .and. .not. (self%is_given(name) .or. self%is_misspelt(name))
   end function lacks

   !> Number of values of a key.
   pure integer function count_values(self, name)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name
      integer :: s, k

      call self%locate(name, s, k)
      if (s > 0) then
         count_values = size(self%stored%settings(s)%values)
      else
         count_values = size(self%schema%defaults(k)%values)
      end if
   end function count_values

   !> Value of a key as it is; null if it has none.
   pure function value(self, name, i)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name
      !> Which of its values, the first if not given.
      integer, intent(in), optional :: i
      type(value_type) :: value
      integer :: s, k, slot

      slot = 1
      if (present(i)) slot = i
      call self%locate(name, s, k)
      if (s > 0) then
         if (slot <= size(self%stored%settings(s)%values)) then
            value = self%stored%settings(s)%values(slot)
         end if
      else
         if (slot <= size(self%schema%defaults(k)%values)) then
            value = self%schema%defaults(k)%values(slot)
         end if
         value%origin = self%origin
      end if
   end function value

   !> All values of a key as they are.
   pure function all_values(self, name) result(values)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name
      type(value_type), allocatable :: values(:)
      integer :: s, k

      call self%locate(name, s, k)
      if (s > 0) then
         values = self%stored%settings(s)%values
      else
         values = self%schema%defaults(k)%values
      end if
   end function all_values

   !> Number of a key; zero if it has none.
   pure real(wp) function number(self, name)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name
      real(wp) :: x(1)

      x = self%vector(name, 1)
      number = x(1)
   end function number

   !> Three numbers of a key.
   pure function numbers(self, name)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name
      real(wp) :: numbers(3)

      numbers = self%vector(name, 3)
   end function numbers

   !> Numbers of a key; zero where it has none.
   pure function vector(self, name, n)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name
      !> How many.
      integer, intent(in) :: n
      real(wp) :: vector(n)
      integer :: s, k, m

      call self%locate(name, s, k)
      vector = 0.0_wp
      if (s > 0) then
         m = min(n, size(self%stored%settings(s)%values))
         vector(:m) = self%stored%settings(s)%values(:m)%real
      else
         m = min(n, size(self%schema%defaults(k)%values))
         vector(:m) = self%schema%defaults(k)%values(:m)%real
      end if
   end function vector

   !> Whole number of a key; zero if it has none.
   pure integer function whole_number(self, name)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name

      whole_number = nint(self%number(name))
   end function whole_number

   !> Whole number of a key, with eight bytes; zero if it has none.
   pure integer(i8) function long_integer(self, name)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name

      long_integer = nint(self%number(name), i8)
   end function long_integer

   !> Text of a key; blank if it has none.
   pure function text(self, name, i)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name
      !> Which of its values, the first if not given.
      integer, intent(in), optional :: i
      character(len=:), allocatable :: text
      type(value_type) :: value

      value = self%value(name, i)
      text = ""
      if (allocated(value%text)) text = value%text
   end function text

   !> Logical of a key; false if it has none.
   pure logical function flag(self, name)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name
      type(value_type) :: value

      value = self%value(name)
      flag = value%logical
   end function flag

   !> Position of a choice in its table; 0 if none is made, or one that there is not.
   pure integer function choice(self, name)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name
      integer, allocatable :: all(:)

      choice = 0
      all = self%choices(name)
      if (size(all) > 0) choice = all(1)
   end function choice

   !> Positions of the choices of a key; 0 for one that there is not.
   pure function choices(self, name) result(list)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name
      integer, allocatable :: list(:)
      integer :: s, k

      call self%locate(name, s, k)
      if (s > 0) then
         list = int(self%stored%settings(s)%values%integer)
      else
         list = int(self%schema%defaults(k)%values%integer)
      end if
   end function choices

   !> Where a key stands, or the group if it is not given.
   pure function place(self, name, i)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name
      !> Which of its values; the key itself if not given.
      integer, intent(in), optional :: i
      type(origin_type) :: place
      integer :: s, k

      call self%locate(name, s, k)
      place = self%origin
      if (s == 0) return
      place = self%stored%settings(s)%origin
      if (.not. present(i)) return
      if (i <= size(self%stored%settings(s)%values)) then
         place = self%stored%settings(s)%values(i)%origin
      end if
   end function place

   !> Report a key that must be given and is not, nor under a misspelt name.
   pure subroutine require(self, name, where, message, expected, diagnostics)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name
      !> Where to say so, as the place of the key that needs it.
      type(origin_type), intent(in) :: where
      character(len=*), intent(in) :: message
      character(len=*), intent(in) :: expected
      type(diagnostics_type), intent(inout) :: diagnostics

      if (self%lacks(name)) call diagnostics%add(where, message, expected)
   end subroutine require

   !> Report a key that must not be given and is.
   pure subroutine refuse(self, name, message, expected, diagnostics)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: message
      character(len=*), intent(in) :: expected
      type(diagnostics_type), intent(inout) :: diagnostics

      if (self%is_given(name)) call diagnostics%add(self%place(name), message, expected)
   end subroutine refuse

   !> Give a key a number that is derived from others.
   subroutine derive_number(self, name, x)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name
      real(wp), intent(in) :: x
      integer :: s

      call new_setting(self%stored, self%schema, self%at(name), s)
      self%stored%settings(s)%set = .true.
      self%stored%settings(s)%values(1)%kind = value_real
      self%stored%settings(s)%values(1)%real = x
   end subroutine derive_number

   !> Give a key a text that is derived from others.
   subroutine derive_text(self, name, text)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: text
      integer :: s

      call new_setting(self%stored, self%schema, self%at(name), s)
      self%stored%settings(s)%set = .true.
      self%stored%settings(s)%values(1)%kind = value_text
      self%stored%settings(s)%values(1)%text = text
   end subroutine derive_text

   !> Take a key for one without a value, as where another one takes its place.
   subroutine unset(self, name)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name
      integer :: s

      call new_setting(self%stored, self%schema, self%at(name), s)
      self%stored%settings(s)%set = .false.
   end subroutine unset

end module contensou_base_settings
