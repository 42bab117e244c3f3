!> The values that a user gave to the keys of the groups of a scene or a sweep.
!>
!> The keys and their defaults are stored once, in a `schema_type`; for a group only what is given
!> in it. `group_settings_type` is a view on both.
module contensou_base_settings
   use contensou_base_diagnostics, only : diagnostics_type, origin_type
   use contensou_base_document_types, only : value_integer, value_logical, value_real, value_text, &
      value_type
   use contensou_base_kinds, only : i8, wp
   use contensou_base_numbers, only : to_text
   use contensou_base_schema, only : group_schema_type, key_type, kind_name, schema_type, &
      setting_type
   use contensou_base_text, only : quote, string_type, text_buffer_type
   implicit none(type, external)
   private

   public :: stored_group_type, settings_type, group_settings_type, new_setting

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
      procedure :: derive_numbers
      procedure :: derive_text
      procedure :: unset
   end type group_settings_type

contains

   !> Position of the setting of a key in a stored group; one with the values of the default is
   !> added if there is none.
   pure subroutine new_setting(stored, schema, key, position)
      type(stored_group_type), intent(inout) :: stored
      type(group_schema_type), intent(in) :: schema
      !> Position of the key among them.
      integer, intent(in) :: key
      !> Position in `stored%settings`.
      integer, intent(out) :: position
      type(setting_type), allocatable :: bigger(:)
      integer :: n

      do position = 1, stored%n
         if (stored%settings(position)%key == key) return
      end do
      if (.not. allocated(stored%settings)) allocate(stored%settings(4))
      if (stored%n == size(stored%settings)) then
         allocate(bigger(2*stored%n))
         bigger(:stored%n) = stored%settings
         call move_alloc(bigger, stored%settings)
      end if
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

   !> What is in force for a key: what the group has, or the default, which stands nowhere.
   function setting_of(group, name) result(setting)
      class(group_settings_type), intent(in) :: group
      character(len=*), intent(in) :: name
      type(setting_type), pointer :: setting
      integer :: k, s

      k = group%schema%position(name)
      if (k == 0) error stop "a key is asked for that the schema does not have"
      do s = 1, group%stored%n
         setting => group%stored%settings(s)
         if (setting%key == k) return
      end do
      setting => group%schema%defaults(k)
   end function setting_of

   !> Name of the group, as "body".
   pure function group_name(self) result(name)
      class(group_settings_type), intent(in) :: self
      character(len=len(self%schema%spec%name)) :: name

      name = self%schema%spec%name
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

   !> What the schema says of a key.
   function key(self, name)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name
      type(key_type) :: key
      type(setting_type), pointer :: setting

      setting => setting_of(self, name)
      key = self%schema%keys(setting%key)
   end function key

   !> Name of the group that a key refers to.
   function target_of(self, name) result(target)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name
      character(len=:), allocatable :: target
      type(setting_type), pointer :: setting

      setting => setting_of(self, name)
      target = trim(self%schema%keys(setting%key)%target)
   end function target_of

   !> Position in the schema of the group that a key refers to.
   integer function target_kind(self, name)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name
      type(setting_type), pointer :: setting

      setting => setting_of(self, name)
      target_kind = self%schema%targets(setting%key)
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
   logical function is_given(self, name)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name
      type(setting_type), pointer :: setting

      setting => setting_of(self, name)
      is_given = setting%given
   end function is_given

   !> Whether a key is likely given under a misspelt name.
   logical function is_misspelt(self, name)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name
      type(setting_type), pointer :: setting

      setting => setting_of(self, name)
      is_misspelt = setting%misspelt
   end function is_misspelt

   !> Whether a key has a usable value, given or default.
   logical function is_set(self, name)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name
      type(setting_type), pointer :: setting

      setting => setting_of(self, name)
      is_set = setting%set
   end function is_set

   !> Whether a key is not given, nor under a misspelt name or in a part that could not be read.
   logical function lacks(self, name)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name

      lacks = self%complete .and. .not. (self%is_given(name) .or. self%is_misspelt(name))
   end function lacks

   !> Number of values of a key.
   integer function count_values(self, name)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name
      type(setting_type), pointer :: setting

      setting => setting_of(self, name)
      count_values = size(setting%values)
   end function count_values

   !> Value of a key as it is; null if it has none.
   function value(self, name, i)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name
      !> Which of its values, the first if not given.
      integer, intent(in), optional :: i
      type(value_type) :: value
      type(setting_type), pointer :: setting
      integer :: slot

      slot = 1
      if (present(i)) slot = i
      setting => setting_of(self, name)
      if (slot <= size(setting%values)) value = setting%values(slot)
      value%origin = self%place(name, slot)
   end function value

   !> All values of a key as they are.
   function all_values(self, name) result(values)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name
      type(value_type), allocatable :: values(:)
      type(setting_type), pointer :: setting

      setting => setting_of(self, name)
      values = setting%values
   end function all_values

   !> Number of a key; zero if it has none.
   real(wp) function number(self, name)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name
      real(wp) :: x(1)

      x = self%vector(name, 1)
      number = x(1)
   end function number

   !> Three numbers of a key.
   function numbers(self, name)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name
      real(wp) :: numbers(3)

      numbers = self%vector(name, 3)
   end function numbers

   !> Numbers of a key; zero where it has none.
   function vector(self, name, n)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name
      !> How many.
      integer, intent(in) :: n
      real(wp) :: vector(n)
      type(setting_type), pointer :: setting
      integer :: m

      setting => setting_of(self, name)
      m = min(n, size(setting%values))
      vector(:m) = setting%values(:m)%real
      vector(m + 1:) = 0.0_wp
   end function vector

   !> Whole number of a key; zero if it has none.
   integer function whole_number(self, name)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name

      whole_number = nint(self%number(name))
   end function whole_number

   !> Whole number of a key, with eight bytes; zero if it has none.
   integer(i8) function long_integer(self, name)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name

      long_integer = nint(self%number(name), i8)
   end function long_integer

   !> Text of a key; blank if it has none.
   function text(self, name, i)
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
   logical function flag(self, name)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name
      type(value_type) :: value

      value = self%value(name)
      flag = value%logical
   end function flag

   !> Position of a choice in its table; 0 if none is made, or one that there is not.
   integer function choice(self, name)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name
      type(setting_type), pointer :: setting

      setting => setting_of(self, name)
      choice = 0
      if (size(setting%values) > 0) choice = int(setting%values(1)%integer)
   end function choice

   !> Positions of the choices of a key; 0 for one that there is not.
   function choices(self, name) result(list)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name
      integer, allocatable :: list(:)
      type(setting_type), pointer :: setting

      setting => setting_of(self, name)
      list = int(setting%values%integer)
   end function choices

   !> Where a key stands, or the group if it is not given.
   function place(self, name, i)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name
      !> Which of its values; the key itself if not given.
      integer, intent(in), optional :: i
      type(origin_type) :: place
      type(setting_type), pointer :: setting

      setting => setting_of(self, name)
      place = setting%origin
      if (present(i)) then
         if (i <= size(setting%values)) place = setting%values(i)%origin
      end if
      if (place%source == 0) place = self%origin
   end function place

   !> Report a key that must be given and is not, nor under a misspelt name.
   subroutine require(self, name, where, message, expected, diagnostics)
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
   subroutine refuse(self, name, message, expected, diagnostics)
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

      call new_setting(self%stored, self%schema, self%schema%position(name), s)
      associate (setting => self%stored%settings(s))
         setting%set = .true.
         setting%values(1)%kind = value_real
         setting%values(1)%real = x
      end associate
   end subroutine derive_number

   !> Give a key numbers that are derived from others.
   subroutine derive_numbers(self, name, x)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name
      real(wp), intent(in) :: x(:)
      integer :: s

      call new_setting(self%stored, self%schema, self%schema%position(name), s)
      associate (setting => self%stored%settings(s))
         setting%set = .true.
         if (size(setting%values) /= size(x)) then
            deallocate(setting%values)
            allocate(setting%values(size(x)))
         end if
         setting%values%kind = value_real
         setting%values%real = x
      end associate
   end subroutine derive_numbers

   !> Give a key a text that is derived from others.
   subroutine derive_text(self, name, text)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: text
      integer :: s

      call new_setting(self%stored, self%schema, self%schema%position(name), s)
      associate (setting => self%stored%settings(s))
         setting%set = .true.
         setting%values(1)%kind = value_text
         setting%values(1)%text = text
      end associate
   end subroutine derive_text

   !> Take a key for one without a value, as where another one takes its place.
   subroutine unset(self, name)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name
      integer :: s

      call new_setting(self%stored, self%schema, self%schema%position(name), s)
      self%stored%settings(s)%set = .false.
   end subroutine unset

end module contensou_base_settings
