!> Keys that groups of a scene or a sweep can have, and their defaults.
!>
!> What owns parameters, as a law of friction or a shape, says by rows of `key_type` which keys it
!> has and reads their values from the settings of its group. Nobody else knows them.
module contensou_base_schema
   use contensou_base_diagnostics, only : origin_type
   use contensou_base_document_types, only : value_logical, value_real, value_text, value_type
   use contensou_base_kinds, only : i8, wp
   use contensou_base_numbers, only : to_text
   use contensou_base_text, only : string_type, strings
   implicit none(type, external)
   private

   public :: key_type, key_list_type, group_spec_type, group_schema_type, schema_type, setting_type
   public :: kind_real, kind_text, kind_name, kind_choice, kind_reference, kind_logical, &
      kind_integer, kind_any, kind_file
   public :: admits, domain_text, is_number, most_values, any_number, new_schema, choice_names

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

   !> Largest number of words of a choice that are given as such.
   integer, parameter :: most_words = 8

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

   !> What a scene may say of one thing: kind, unit, domain, default, text.
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
      !> For a choice, what gives the names that it admits, or these names.
      procedure(choice_names), pointer, nopass :: choices => null()
      character(len=16) :: words(most_words) = ""
      !> For a reference, the group it refers to.
      character(len=12) :: target = ""
      !> What it means.
      character(len=400) :: doc = ""
   contains
      procedure :: names => names_of_key
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
      procedure :: has
   end type key_list_type

   !> A group that a file may have, with its keys.
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
      !> Position of the key at the place that `place_of` gives for its name or, where that is
      !> taken, the next; 0 for none.
      integer, allocatable :: places(:)
   contains
      procedure :: position
   end type group_schema_type

   !> The groups that a scene or a sweep can have.
   type :: schema_type
      type(group_schema_type), allocatable :: groups(:)
      !> What has these groups, for messages, as " in a sweep"; blank where that is plain.
      character(len=16) :: owner = ""
   contains
      procedure :: find => find_group
   end type schema_type

contains


   !> Add a key.
   subroutine put(self, group, name, kind, doc, values, unit, default, mandatory, above, least, &
      most, target, fewer, choices, words)
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
      !> What gives the names that a choice admits.
      procedure(choice_names), optional :: choices
      !> These names.
      character(len=*), intent(in), optional :: words(:)

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
         if (present(words)) key%words(:size(words)) = words
      end associate
   end subroutine put

   !> Add a key that is one of another list.
   subroutine append(self, key)
      class(key_list_type), intent(inout) :: self
      type(key_type), intent(in) :: key
      type(key_type), allocatable :: bigger(:)

      if (.not. allocated(self%keys)) allocate(self%keys(8))
      if (self%n == size(self%keys)) then
         allocate(bigger(2*self%n))
         bigger(:self%n) = self%keys
         call move_alloc(bigger, self%keys)
      end if
      self%n = self%n + 1
      self%keys(self%n) = key
   end subroutine append

   !> Whether a key is in a list.
   pure logical function has(self, name)
      class(key_list_type), intent(in) :: self
      character(len=*), intent(in) :: name
      integer :: i

      has = .false.
      do i = 1, self%n
         has = has .or. self%keys(i)%name == name
      end do
   end function has

   !> Names that a key admits; none if it is no choice.
   function names_of_key(self) result(names)
      class(key_type), intent(in) :: self
      type(string_type), allocatable :: names(:)

      if (associated(self%choices)) then
         names = self%choices()
      else if (self%kind /= kind_choice) then
         allocate(names(0))
      else
         names = strings(pack(self%words, self%words /= ""))
      end if
   end function names_of_key

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
               group%choices(k)%names = group%keys(k)%names()
               group%targets(k) = findloc(groups%name == group%keys(k)%target, .true., dim=1)
               group%defaults(k)%key = k
               call set_default(group%keys(k), group%choices(k)%names, group%defaults(k))
            end do
            call set_places(group)
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

   !> Position of a key in its group; 0 if the group does not have it.
   pure integer function position(self, name)
      class(group_schema_type), intent(in) :: self
      character(len=*), intent(in) :: name

      integer :: n, place

      position = 0
      n = len_trim(name)
      if (n == 0 .or. n > len(self%keys%name)) return
      place = place_of(name(:n), size(self%places))
      do
         position = self%places(place)
         if (position == 0) return
         associate (key => self%keys(position)%name)
            if (key(:n) == name(:n)) then
               if (n == len(key)) return
               if (key(n + 1:n + 1) == " ") return
            end if
         end associate
         place = 1 + modulo(place, size(self%places))
      end do
   end function position

   !> Set where to look for the keys of a group.
   pure subroutine set_places(group)
      type(group_schema_type), intent(inout) :: group
      integer :: k, n, place

      n = 1
      do while (n < 4*size(group%keys))
         n = 2*n
      end do
      allocate(group%places(n), source=0)
      do k = 1, size(group%keys)
         place = place_of(trim(group%keys(k)%name), n)
         do while (group%places(place) > 0)
            place = 1 + modulo(place, n)
         end do
         group%places(place) = k
      end do
   end subroutine set_places

   !> Where to look first for a key. Every case of a sweep asks some two hundred times: three
   !> letters and the length tell keys apart.
   pure integer function place_of(name, places)
      !> Its name, of at least one letter.
      character(len=*), intent(in) :: name
      !> Number of places, a power of two.
      integer, intent(in) :: places
      integer :: n

      n = len(name)
      place_of = 1 + iand(ichar(name(1:1)) + 5*ichar(name(n:n)) + 17*ichar(name(n/2 + 1:n/2 + 1)) &
         + 3*n, places - 1)
   end function place_of

end module contensou_base_schema
