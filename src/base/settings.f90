!> Keys that a group of a scene can have, and the values that a user gave to them.
!>
!> What owns parameters, as a law of friction or a shape, says by rows of `key_type` which keys it
!> has and reads their values from the settings of its group. Nobody else knows them.
module contensou_base_settings
   use contensou_base_diagnostics, only : diagnostics_type, origin_type
   use contensou_base_kinds, only : wp
   use contensou_base_text, only : string_type, to_text
   implicit none(type, external)
   private

   public :: key_type, key_list_type, setting_type, group_settings_type
   public :: kind_real, kind_text, kind_name, kind_choice, kind_reference, kind_logical
   public :: admits, choice_names, domain_text, most_values

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

   !> Largest number of values of a key.
   integer, parameter :: most_values = 12

   abstract interface
      !> Names that a choice admits.
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
      !> Number of values.
      integer :: values = 1
      !> Whether fewer values will do.
      logical :: few = .false.
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
      !> For a reference, the group it refers to.
      character(len=12) :: target = ""
      !> For a choice, the names that it admits; not associated where the schema of the group knows.
      procedure(choice_names), pointer, nopass :: choices => null()
      !> What it means.
      character(len=400) :: doc = ""
   end type key_type

   !> Keys in the making of a table.
   type :: key_list_type
      !> Number of keys.
      integer :: n = 0
      !> The keys, the first `n` of them; to be allocated with room for all before the first.
      type(key_type), allocatable :: keys(:)
   contains
      !> Add a key.
      procedure :: put
   end type key_list_type

   type :: setting_type
      type(key_type) :: key
      !> Whether the scene gives it.
      logical :: given = .false.
      !> Whether it is likely given under a misspelt name.
      logical :: meant = .false.
      !> Whether it has a usable value, given or default.
      logical :: set = .false.
      !> Where the key stands, or the group if it is not given.
      type(origin_type) :: origin
      !> Where each value stands.
      type(origin_type) :: places(most_values)
      !> Number of values.
      integer :: n = 0
      !> Numbers.
      real(wp) :: real(most_values) = 0.0_wp
      type(string_type) :: text(most_values)
      logical :: logical = .false.
      !> Position of a choice in its table.
      integer :: choice = 0
      !> Positions of several choices.
      integer :: choices(most_values) = 0
   end type setting_type

   !> A group of the scene.
   type :: group_settings_type
      !> Index in `schema_groups`.
      integer :: group = 0
      !> Where it stands.
      type(origin_type) :: origin
      !> Whether it was read without a mistake of syntax.
      logical :: complete = .true.
      !> Its keys, all that the schema has for it.
      type(setting_type), allocatable :: settings(:)
   contains
      !> Position of a key in `settings`.
      procedure :: at
      !> Whether the user gave a key, rightly or not.
      procedure :: is_given
      !> Whether a key has a usable value, given or default.
      procedure :: is_set
      !> Number of values of a key.
      procedure :: count => count_values
      !> Number of a key.
      procedure :: number
      !> Three numbers of a key.
      procedure :: numbers
      !> Value of a key that is a whole number.
      procedure :: integer => whole_number
      !> Text of a key.
      procedure :: text
      !> Logical of a key.
      procedure :: flag
      !> Position of a choice in its table, 0 if there is none.
      procedure :: choice
      !> Where a key stands, or one of its values.
      procedure :: place
      !> Report a key that must be given and is not.
      procedure :: require
      !> Report a key that must not be given and is.
      procedure :: refuse
      !> Value of the key `name`, or blank.
      procedure :: label
   end type group_settings_type

contains

   !> Add a key.
   subroutine put(self, group, name, kind, doc, values, unit, default, mandatory, above, least, &
      most, target, few, choices)
      class(key_list_type), intent(inout) :: self
      character(len=*), intent(in) :: group
      character(len=*), intent(in) :: name
      !> What its values are.
      integer, intent(in) :: kind
      !> What it means.
      character(len=*), intent(in) :: doc
      !> Number of values.
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
      logical, intent(in), optional :: few
      !> Names that a choice admits.
      procedure(choice_names), optional :: choices

      self%n = self%n + 1
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
         if (present(few)) key%few = few
         if (present(choices)) key%choices => choices
      end associate
   end subroutine put

   !> Whether a finite number is in the domain of a key.
   pure function admits(key, x) result(ok)
      type(key_type), intent(in) :: key
      !> The number.
      real(wp), intent(in) :: x
      logical :: ok

      ok = x >= key%low .and. x <= key%high
      if (key%above_low) ok = ok .and. x > key%low
   end function admits

   !> Domain and unit of the numbers of a key in words, as "a number > 0 [kg]".
   pure function domain_text(key) result(text)
      type(key_type), intent(in) :: key
      character(len=:), allocatable :: text

      text = "a number"
      if (key%values > 1) text = to_text(key%values) // " numbers"
      if (key%few) text = "up to " // text
      if (key%low > -huge(key%low)) then
         text = text // trim(merge(" > ", " >=", key%above_low)) // " " // to_text(key%low)
      end if
      if (key%high < huge(key%high)) then
         if (key%low > -huge(key%low)) text = text // " and"
         text = text // " <= " // to_text(key%high)
      end if
      if (key%unit == "model") then
         text = text // " [unit of the law]"
      else if (key%unit == "1") then
         text = text // " [-]"
      else if (key%unit /= "") then
         text = text // " [" // trim(key%unit) // "]"
      end if
   end function domain_text

   !> Position of a key in the settings of a group; the key must exist.
   pure function at(self, name) result(i)
      !> The group.
      class(group_settings_type), intent(in) :: self
      !> Name of the key.
      character(len=*), intent(in) :: name
      integer :: i

      do i = 1, size(self%settings)
         if (self%settings(i)%key%name == name) return
      end do
      error stop "a key is asked for that the schema does not have"
   end function at

   !> Number of a key; zero if it has none.
   pure function number(self, name) result(x)
      !> The group.
      class(group_settings_type), intent(in) :: self
      !> The key.
      character(len=*), intent(in) :: name
      real(wp) :: x

      x = self%settings(self%at(name))%real(1)
   end function number

   !> Three numbers of a key.
   pure function numbers(self, name) result(x)
      !> The group.
      class(group_settings_type), intent(in) :: self
      !> The key.
      character(len=*), intent(in) :: name
      real(wp) :: x(3)

      x = self%settings(self%at(name))%real(:3)
   end function numbers

   !> Value of the key `name` of a group; blank if it has none.
   pure function label(self) result(name)
      !> The group.
      class(group_settings_type), intent(in) :: self
      character(len=:), allocatable :: name
      integer :: i

      name = ""
      do i = 1, size(self%settings)
         if (self%settings(i)%key%kind == kind_name .and. self%settings(i)%set) then
            name = self%settings(i)%text(1)%s
         end if
      end do
   end function label

   !> Whether the user gave a key, rightly or not.
   pure logical function is_given(self, name)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name

      is_given = self%settings(self%at(name))%given
   end function is_given

   !> Whether a key has a usable value, given or default.
   pure logical function is_set(self, name)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name

      is_set = self%settings(self%at(name))%set
   end function is_set

   !> Number of values of a key.
   pure integer function count_values(self, name)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name

      count_values = self%settings(self%at(name))%n
   end function count_values

   !> Value of a key that is a whole number.
   pure integer function whole_number(self, name)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name

      whole_number = nint(self%number(name))
   end function whole_number

   !> Text of a key; blank if it has none.
   pure function text(self, name, i)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name
      !> Which of its values, the first if not given.
      integer, intent(in), optional :: i
      character(len=:), allocatable :: text
      integer :: k

      k = 1
      if (present(i)) k = i
      text = self%settings(self%at(name))%text(k)%s
   end function text

   !> Logical of a key.
   pure logical function flag(self, name)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name

      flag = self%settings(self%at(name))%logical
   end function flag

   !> Position of a choice in its table; 0 if none is made, or one that there is not.
   pure integer function choice(self, name)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name

      choice = self%settings(self%at(name))%choice
   end function choice

   !> Where a key stands, or the group if it is not given.
   pure function place(self, name, i)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name
      !> Which of its values; the key itself if not given.
      integer, intent(in), optional :: i
      type(origin_type) :: place

      associate (setting => self%settings(self%at(name)))
         place = setting%origin
         if (present(i)) place = setting%places(i)
      end associate
   end function place

   !> Report a key that must be given and is not, nor under a misspelt name.
   pure subroutine require(self, name, where, message, expected, diagnostics)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name
      !> Where to say so, as the place of the key that needs it.
      type(origin_type), intent(in) :: where
      character(len=*), intent(in) :: message
      !> What would be right.
      character(len=*), intent(in) :: expected
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics

      associate (setting => self%settings(self%at(name)))
         if (setting%given .or. setting%meant .or. .not. self%complete) return
         call diagnostics%add(where, message, expected)
      end associate
   end subroutine require

   !> Report a key that must not be given and is.
   pure subroutine refuse(self, name, message, expected, diagnostics)
      class(group_settings_type), intent(in) :: self
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: message
      !> What would be right.
      character(len=*), intent(in) :: expected
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics

      associate (setting => self%settings(self%at(name)))
         if (setting%given) call diagnostics%add(setting%origin, message, expected)
      end associate
   end subroutine refuse

end module contensou_base_settings
