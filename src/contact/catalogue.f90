!> What a user can read about a model that can be named in a scene, and the keys that it has.
!>
!> Each part of a contact keeps one table of its models. The table serves construction, the schema
!> of the scene and the checks of its keys, the "expected one of" of messages, `contensou models`,
!> and the test that constructs each entry.
module contensou_contact_catalogue
   use contensou_base_kinds, only : wp
   use contensou_base_schema, only : admits, choice_names, domain_text, key_type, kind_choice, &
      kind_logical, kind_real
   use contensou_contact_parameters, only : parameters_type
   use contensou_contact_states, only : state_list_type
   implicit none(type, external)
   private

   public :: model_info_type, model_type, law_key_type, law_keys_type, plain_unit

   !> Description of a model; texts are padded with blanks.
   type :: model_info_type
      !> Name in a scene.
      character(len=24) :: name = ""
      !> One line: what it is, with its formula.
      character(len=160) :: summary = ""
      !> What it uses beside its own keys, with units, separated by commas.
      character(len=240) :: keys = ""
      !> Where the formula comes from.
      character(len=120) :: reference = ""
      !> Names and units of its states, separated by commas.
      character(len=160) :: states = ""
   end type model_info_type

   !> A key of the group `contact` as a model has it.
   type :: law_key_type
      !> What the schema says of it; `mandatory` holds if the model is chosen.
      type(key_type) :: key
      !> Its symbol in the formula of the model; blank for none.
      character(len=12) :: symbol = ""
      !> Key that may be given in its place; blank for none.
      character(len=28) :: instead = ""
      !> Key without which it has no meaning; blank for none.
      character(len=28) :: with = ""
      !> A value, for messages; blank for none.
      character(len=12) :: example = ""
      !> What holds if it is not given and has no default; blank for nothing.
      character(len=12) :: otherwise = ""
      !> Whether it may be given without an effect.
      logical :: idle = .false.
   contains
      procedure :: text => law_key_text
      procedure :: wanted
      procedure :: wanted_value
   end type law_key_type

   !> The keys of a model.
   type :: law_keys_type
      integer :: n = 0
      !> The first `n` of them.
      type(law_key_type) :: keys(12)
   contains
      procedure :: put => put_law_key
      procedure :: at => key_place
   end type law_keys_type

   !> A row in the table of a part, which the tables of the parts extend.
   type :: model_type
      type(model_info_type) :: info
      !> Whether it does anything; .false. for `none`.
      logical :: acts = .true.
      !> Adds its keys; not associated if it has none.
      procedure(key_writer), pointer, nopass :: put_keys => null()
      !> Adds its states; not associated if it has none.
      procedure(state_writer), pointer, nopass :: put_states => null()
      !> Adds those that it has only where a key is given, and that key.
      procedure(state_writer), pointer, nopass :: put_more_states => null()
      character(len=12) :: more_with = ""
   contains
      procedure :: keys => keys_of
      procedure :: states => states_of
      procedure :: uses
      procedure :: keys_text
      procedure :: states_text
      procedure :: described => described_model
      procedure :: misfit
      procedure :: completed
   end type model_type

   abstract interface
      !> Add the keys of a model.
      subroutine key_writer(list)
         import :: law_keys_type
         implicit none(type, external)
         type(law_keys_type), intent(inout) :: list
      end subroutine key_writer

      !> Add the states of a model.
      subroutine state_writer(list)
         import :: state_list_type
         implicit none(type, external)
         type(state_list_type), intent(inout) :: list
      end subroutine state_writer
   end interface

contains

   !> Add a key of the group `contact`.
   subroutine put_law_key(self, name, kind, doc, unit, default, mandatory, above, least, most, &
      symbol, instead, with, example, otherwise, idle, choices)
      class(law_keys_type), intent(inout) :: self
      character(len=*), intent(in) :: name
      !> What its value is, one of the `kind_*` codes.
      integer, intent(in) :: kind
      !> What it means.
      character(len=*), intent(in) :: doc
      character(len=*), intent(in), optional :: unit
      !> Default in namelist syntax.
      character(len=*), intent(in), optional :: default
      !> Whether it must be given, or what may stand in its place.
      logical, intent(in), optional :: mandatory
      !> Numbers are larger than this.
      real(wp), intent(in), optional :: above
      !> Numbers are at least this.
      real(wp), intent(in), optional :: least
      !> Numbers are at most this.
      real(wp), intent(in), optional :: most
      !> Symbol in the formula of the model.
      character(len=*), intent(in), optional :: symbol
      !> Key that may be given in its place.
      character(len=*), intent(in), optional :: instead
      !> Key without which it has no meaning.
      character(len=*), intent(in), optional :: with
      !> A value, for messages.
      character(len=*), intent(in), optional :: example
      !> What holds if it is not given and has no default.
      character(len=*), intent(in), optional :: otherwise
      !> Whether it may be given without an effect.
      logical, intent(in), optional :: idle
      !> Names that a choice admits.
      procedure(choice_names), optional :: choices

      self%n = self%n + 1
      associate (item => self%keys(self%n))
         item = law_key_type()
         item%key%group = "contact"
         item%key%name = name
         item%key%kind = kind
         item%key%doc = doc
         if (present(unit)) item%key%unit = unit
         if (present(default)) item%key%default = default
         if (present(mandatory)) item%key%mandatory = mandatory
         if (present(above)) item%key%low = above
         item%key%above_low = present(above)
         if (present(least)) item%key%low = least
         if (present(most)) item%key%high = most
         if (present(choices)) item%key%choices => choices
         if (present(symbol)) item%symbol = symbol
         if (present(instead)) item%instead = instead
         if (present(with)) item%with = with
         if (present(example)) item%example = example
         if (present(otherwise)) item%otherwise = otherwise
         if (present(idle)) item%idle = idle
      end associate
   end subroutine put_law_key

   !> Position of a key; 0 if it is not among them.
   pure integer function key_place(self, name)
      class(law_keys_type), intent(in) :: self
      character(len=*), intent(in) :: name

      do key_place = self%n, 1, -1
         if (self%keys(key_place)%key%name == name) return
      end do
   end function key_place

   !> The keys of a model.
   function keys_of(self) result(list)
      class(model_type), intent(in) :: self
      type(law_keys_type) :: list

      if (associated(self%put_keys)) call self%put_keys(list)
   end function keys_of

   !> The states of a model.
   function states_of(self, parameters) result(list)
      class(model_type), intent(in) :: self
      !> Values of its keys; without them, all states that it can have.
      type(parameters_type), intent(in), optional :: parameters
      type(state_list_type) :: list

      if (associated(self%put_states)) call self%put_states(list)
      if (.not. associated(self%put_more_states)) return
      if (present(parameters)) then
         if (.not. parameters%has(trim(self%more_with))) return
      end if
      call self%put_more_states(list)
   end function states_of

   !> Whether a model has a key, and with an effect.
   logical function uses(self, name)
      class(model_type), intent(in) :: self
      character(len=*), intent(in) :: name
      type(law_keys_type) :: list
      integer :: i

      list = self%keys()
      i = list%at(name)
      uses = .false.
      if (i > 0) uses = .not. list%keys(i)%idle
   end function uses

   !> What a user reads of the keys of a model: names, units and defaults, separated by commas.
   function keys_text(self) result(text)
      class(model_type), intent(in) :: self
      character(len=:), allocatable :: text
      type(law_keys_type) :: list
      integer :: i

      list = self%keys()
      text = trim(self%info%keys)
      do i = 1, list%n
         associate (item => list%keys(i))
            if (item%idle) cycle
            if (item%instead /= "" .and. list%at(trim(item%instead)) < i &
               .and. list%at(trim(item%instead)) > 0) then
               text = text // ", or "
            else if (text /= "") then
               text = text // ", "
            end if
            text = text // item%text()
            if (item%key%default /= "") then
               text = text // " (default " // trim(item%key%default) // ")"
            else if (item%otherwise /= "") then
               text = text // " (" // trim(item%otherwise) // ")"
            else if (item%with /= "") then
               text = text // " (with " // trim(item%with) // ")"
            else if (.not. item%key%mandatory) then
               text = text // " (optional)"
            end if
         end associate
      end do
   end function keys_text

   !> What a user reads of the states of a model: names and units, separated by commas.
   function states_text(self, parameters) result(text)
      class(model_type), intent(in) :: self
      !> Values of its keys; without them, of all states that it can have.
      type(parameters_type), intent(in), optional :: parameters
      character(len=:), allocatable :: text
      type(state_list_type) :: list
      integer :: i

      text = ""
      if (.not. associated(self%put_states)) return
      list = self%states(parameters)
      do i = 1, list%n
         associate (item => list%items(i))
            if (i > 1) text = text // ", "
            text = text // trim(item%name) // " [" // plain_unit(item%units) // "]"
         end associate
      end do
   end function states_text

   !> What a user reads about a model, its keys and states included.
   function described_model(self) result(info)
      class(model_type), intent(in) :: self
      type(model_info_type) :: info

      info = self%info
      info%keys = self%keys_text()
      info%states = self%states_text()
   end function described_model

   !> Name, symbol and unit of a key, as "damping_coefficient alpha [s/m]".
   pure function law_key_text(self) result(text)
      class(law_key_type), intent(in) :: self
      character(len=:), allocatable :: text

      text = trim(self%key%name)
      if (self%symbol /= "") text = text // " " // trim(self%symbol)
      if (self%key%unit /= "") text = text // " [" // plain_unit(self%key%unit) // "]"
   end function law_key_text

   !> What is right for a key, as "name = a number > 0 [kg], as 1.0e-3".
   pure function wanted(self) result(text)
      class(law_key_type), intent(in) :: self
      character(len=:), allocatable :: text

      text = trim(self%key%name) // " = " // self%wanted_value()
   end function wanted

   !> What is right for the value of a key.
   pure function wanted_value(self) result(text)
      class(law_key_type), intent(in) :: self
      character(len=:), allocatable :: text
      integer :: i

      select case (self%key%kind)
      case (kind_real)
         text = domain_text(self%key)
      case (kind_logical)
         text = ".true. or .false."
      case default
         text = "a name in quotes"
      end select
      ! Whole numbers as people write them.
      do
         i = index(text // " ", ".0 ")
         if (i == 0) exit
         text = text(:i - 1) // text(i + 2:)
      end do
      if (self%example /= "") text = text // ", as " // trim(self%example)
   end function wanted_value

   !> What is missing or wrong among the values of the keys of a model, as "needs a
   !> regularization_velocity > 0"; blank if nothing is.
   function misfit(self, parameters) result(text)
      class(model_type), intent(in) :: self
      type(parameters_type), intent(in) :: parameters
      character(len=:), allocatable :: text
      type(law_keys_type) :: list
      integer :: i

      text = ""
      list = self%keys()
      do i = 1, list%n
         associate (item => list%keys(i))
            if (item%idle .or. item%key%kind == kind_choice) cycle
            if (parameters%has(item%key%name)) then
               if (admits(item%key, parameters%number(item%key%name))) cycle
            else
               if (.not. item%key%mandatory) cycle
               if (item%instead /= "") then
                  if (parameters%has(item%instead)) cycle
               end if
            end if
            text = "needs " // item%wanted()
            return
         end associate
      end do
   end function misfit

   !> Values of the keys of a model, those that have none with their defaults.
   function completed(self, parameters) result(values)
      class(model_type), intent(in) :: self
      type(parameters_type), intent(in) :: parameters
      type(parameters_type) :: values
      type(law_keys_type) :: list
      real(wp) :: x
      integer :: i

      values = parameters
      if (parameters%complete) return
      list = self%keys()
      do i = 1, list%n
         associate (key => list%keys(i)%key)
            if (key%default == "" .or. parameters%has(key%name)) cycle
            if (key%kind == kind_logical) then
               call values%set(trim(key%name), key%default == ".true.")
            else if (key%kind == kind_real) then
               read(key%default, *) x
               call values%set(trim(key%name), x)
            end if
         end associate
      end do
   end function completed

   !> A unit as people write it: "m/s" for "m s-1", "-" for "1".
   pure function plain_unit(unit) result(text)
      character(len=*), intent(in) :: unit
      character(len=:), allocatable :: text
      character(len=:), allocatable :: rest, word, below
      integer :: i

      text = ""
      below = ""
      rest = trim(unit)
      do while (rest /= "")
         i = index(rest // " ", " ")
         word = rest(:i - 1)
         rest = trim(adjustl(rest(i:)))
         i = index(word, "-")
         if (i > 0) then
            if (word(i + 1:) == "1") then
               below = below // " " // word(:i - 1)
            else
               below = below // " " // word(:i - 1) // word(i + 1:)
            end if
         else
            text = text // " " // word
         end if
      end do
      text = trim(adjustl(text))
      if (text == "1" .and. below == "") text = "-"
      if (text == "") text = "1"
      if (below /= "") text = text // "/" // trim(adjustl(below))
   end function plain_unit

end module contensou_contact_catalogue
