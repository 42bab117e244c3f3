!> The parts of a contact whose models a scene names, with their tables: what reads, explains or
!> lists models goes through all parts here, and no part is listed elsewhere.
module contensou_contact_parts
   use contensou_base_diagnostics, only : diagnostics_type, origin_type
   use contensou_base_kinds, only : wp
   use contensou_base_schema, only : admits, choice_names, key_list_type, key_type, kind_choice, &
      kind_integer, kind_logical, kind_real
   use contensou_base_settings, only : group_settings_type
   use contensou_base_text, only : quote, string_type, strings
   use contensou_base_text_lock, only : lock_texts, unlock_texts
   use contensou_contact_catalogue, only : law_key_type, law_keys_type, model_info_type, &
      model_type, plain_unit
   use contensou_contact_curvature, only : curvature_model_type, curvature_models
   use contensou_contact_damping, only : damping_model_type, damping_models
   use contensou_contact_friction, only : friction_model_type, friction_models
   use contensou_contact_normal, only : normal_model_type, normal_models
   use contensou_contact_parameters, only : parameters_type
   use contensou_contact_rolling, only : rolling_model_type, rolling_models
   use contensou_contact_states, only : state_list_type
   use contensou_contact_tangential, only : tangential_model_type, tangential_models
   implicit none(type, external)
   private

   public :: part_type, contact_parts, shared_parts, n_parts, put_part_keys, read_models
   public :: normal_names, friction_names, part_states, owns_state

   !> Number of parts.
   integer, parameter :: n_parts = 6

   !> A part and the table of its models.
   type :: part_type
      !> Key of the group `contact` that names the model.
      character(len=10) :: name = ""
      !> What it is, in words.
      character(len=21) :: doc = ""
      !> The model that acts if none is named.
      character(len=8) :: default = ""
      type(model_type), allocatable :: models(:)
      !> The keys of each model.
      type(law_keys_type), allocatable :: keys(:)
   contains
      procedure :: described
      procedure :: words
   end type part_type

   !> The parts, made when they are first asked for: each case of a sweep reads by them.
   type(part_type), allocatable, target :: table(:)

contains

   !> The parts, in the order of the documentation, in one table for all. Thread-safe.
   function shared_parts() result(parts)
      type(part_type), pointer :: parts(:)
      type(part_type), allocatable :: made(:)

      call lock_texts()
      if (.not. allocated(table)) then
         made = contact_parts()
         call move_alloc(made, table)
      end if
      parts => table
      call unlock_texts()
   end function shared_parts

   !> The parts, in the order of the documentation.
   function contact_parts() result(parts)
      type(part_type), allocatable :: parts(:)
      integer :: i, j

      allocate(parts(n_parts))
      parts%name = [character(len=10) :: "normal", "damping", "friction", "rolling", "tangential", &
         "spot"]
      parts%doc = [character(len=21) :: "normal force", "damping", "friction", &
         "rolling resistance", "tangential elasticity", "curvature of the spot"]
      parts%default = [character(len=8) :: "hertz", "none", "none", "none", "none", "flat"]
      do i = 1, n_parts
         parts(i)%models = models_of(parts(i)%name)
         allocate(parts(i)%keys(size(parts(i)%models)))
         do j = 1, size(parts(i)%models)
            ! Into its place: a function result is copied, which took longer than to fill a list.
            associate (model => parts(i)%models(j))
               if (associated(model%put_keys)) call model%put_keys(parts(i)%keys(j))
            end associate
         end do
      end do
   end function contact_parts

   !> The states of all models that have some, in the order of the documentation. Thread-safe.
   function part_states() result(lists)
      type(state_list_type), allocatable :: lists(:)
      type(part_type), pointer :: parts(:)
      integer :: i, j, n

      parts => shared_parts()
      n = 0
      do i = 1, n_parts
         do j = 1, size(parts(i)%models)
            if (associated(parts(i)%models(j)%put_states)) n = n + 1
         end do
      end do
      allocate(lists(n))
      n = 0
      do i = 1, n_parts
         do j = 1, size(parts(i)%models)
            if (.not. associated(parts(i)%models(j)%put_states)) cycle
            n = n + 1
            lists(n) = parts(i)%models(j)%states()
         end do
      end do
   end function part_states

   !> Whether a contact has a state of some name. Thread-safe.
   logical function owns_state(choice, parameters, name)
      !> Position of the model of each part in its table.
      integer, intent(in) :: choice(n_parts)
      !> Values of the keys of the contact.
      type(parameters_type), intent(in) :: parameters
      character(len=*), intent(in) :: name
      type(part_type), pointer :: parts(:)
      type(state_list_type) :: list
      integer :: i

      parts => shared_parts()
      owns_state = .false.
      do i = 1, n_parts
         list = parts(i)%models(choice(i))%states(parameters)
         owns_state = owns_state .or. any(list%items(:list%n)%name == name)
      end do
   end function owns_state

   !> What a user reads about the models of a part, their keys included.
   function described(self) result(info)
      class(part_type), intent(in) :: self
      type(model_info_type), allocatable :: info(:)
      integer :: i

      allocate(info(size(self%models)))
      do i = 1, size(info)
         info(i) = self%models(i)%described()
      end do
   end function described

   !> What a contact pays for in this part, after a comma: the model and the choices among its keys;
   !> blank if it does nothing.
   function words(self, choice, parameters) result(text)
      class(part_type), intent(in) :: self
      !> Position of the model in the table.
      integer, intent(in) :: choice
      !> Values of the keys.
      type(parameters_type), intent(in) :: parameters
      character(len=:), allocatable :: text
      type(string_type), allocatable :: names(:)
      character(len=:), allocatable :: states
      integer :: k

      text = ""
      if (.not. self%models(choice)%acts) return
      text = ", "
      if (self%name == "rolling") text = text // "rolling resistance "
      if (self%name == "tangential" .and. associated(self%models(choice)%put_states)) then
         text = text // "tangential elasticity "
      end if
      text = text // trim(self%models(choice)%info%name)
      if (self%name == "spot") text = text // " spot"
      do k = 1, self%keys(choice)%n
         associate (item => self%keys(choice)%keys(k))
            if (item%idle) cycle
            select case (item%key%name)
            case ("drilling")
               text = text // trim(merge(" with   ", " without", parameters%flag("drilling"))) // &
                  " drilling torque"
            case default
               if (item%key%kind /= kind_choice) cycle
               if (item%otherwise == "" .and. .not. parameters%has(trim(item%key%name))) cycle
               text = text // " with the "
               if (parameters%has(trim(item%key%name))) then
                  names = item%key%names()
                  text = text // names(nint(parameters%number(trim(item%key%name))))%s
               else
                  text = text // trim(item%otherwise)
               end if
               text = text // " " // trim(item%key%name)
            end select
         end associate
      end do
      if (self%name == "friction" .and. parameters%number("regularization_velocity") > 0.0_wp) then
         text = text // ", regularised"
      end if
      states = self%models(choice)%states_text(parameters)
      if (states /= "") text = text // ", integrating " // states
   end function words

   !> Table of the models of a part; empty if there is no such part.
   function models_of(part) result(models)
      !> Its key in the group `contact`.
      character(len=*), intent(in) :: part
      type(model_type), allocatable :: models(:)
      type(normal_model_type), allocatable :: normal(:)
      type(damping_model_type), allocatable :: damping(:)
      type(friction_model_type), allocatable :: friction(:)
      type(rolling_model_type), allocatable :: rolling(:)
      type(tangential_model_type), allocatable :: tangential(:)
      type(curvature_model_type), allocatable :: curvature(:)

      select case (part)
      case ("normal")
         normal = normal_models()
         models = normal%model_type
      case ("damping")
         damping = damping_models()
         models = damping%model_type
      case ("friction")
         friction = friction_models()
         models = friction%model_type
      case ("rolling")
         rolling = rolling_models()
         models = rolling%model_type
      case ("tangential")
         tangential = tangential_models()
         models = tangential%model_type
      case ("spot")
         curvature = curvature_models()
         models = curvature%model_type
      case default
         allocate(models(0))
      end select
   end function models_of

   !> Names of the models of a part; none if there is no such part.
   function model_names(part) result(names)
      !> Its key in the group `contact`.
      character(len=*), intent(in) :: part
      type(string_type), allocatable :: names(:)
      type(model_type), allocatable :: models(:)

      models = models_of(part)
      names = strings(models%info%name)
   end function model_names

   function normal_names() result(names)
      type(string_type), allocatable :: names(:)

      names = model_names("normal")
   end function normal_names

   function damping_names() result(names)
      type(string_type), allocatable :: names(:)

      names = model_names("damping")
   end function damping_names

   function friction_names() result(names)
      type(string_type), allocatable :: names(:)

      names = model_names("friction")
   end function friction_names

   function rolling_names() result(names)
      type(string_type), allocatable :: names(:)

      names = model_names("rolling")
   end function rolling_names

   function tangential_names() result(names)
      type(string_type), allocatable :: names(:)

      names = model_names("tangential")
   end function tangential_names

   function curvature_names() result(names)
      type(string_type), allocatable :: names(:)

      names = model_names("spot")
   end function curvature_names

   !> Add the keys of all parts to the group `contact`: for each part the choice of its model, then
   !> the keys of its models. A key that several parts have stands with the last of them.
   subroutine put_part_keys(list)
      type(key_list_type), intent(inout) :: list
      type(part_type), pointer :: parts(:)
      integer :: i, j, k, first

      parts => shared_parts()
      do i = 1, n_parts
         call list%put("contact", trim(parts(i)%name), kind_choice, &
            default=quote(trim(parts(i)%default)), doc=model_doc(parts(i)))
         list%keys(list%n)%choices => names_of(parts(i)%name)
         first = list%n
         do j = 1, size(parts(i)%models)
            do k = 1, parts(i)%keys(j)%n
               associate (name => parts(i)%keys(j)%keys(k)%key%name)
                  if (any(list%keys(first:list%n)%name == name)) cycle
                  if (any(places_of(parts(i + 1:), trim(name)) > 0)) cycle
                  call list%append(merged_key(parts(:i), trim(name)))
               end associate
            end do
         end do
      end do
   end subroutine put_part_keys

   !> Names of the models of a part. (As a component gfortran would free the pointer.)
   function names_of(part) result(names)
      !> Its key in the group `contact`.
      character(len=*), intent(in) :: part
      procedure(choice_names), pointer :: names

      select case (part)
      case ("normal")
         names => normal_names
      case ("damping")
         names => damping_names
      case ("friction")
         names => friction_names
      case ("rolling")
         names => rolling_names
      case ("tangential")
         names => tangential_names
      case default
         names => curvature_names
      end select
   end function names_of

   !> What the choice of a model means.
   function model_doc(part) result(text)
      type(part_type), intent(in) :: part
      character(len=:), allocatable :: text

      text = trim(part%doc)
      if (part%name == "damping") text = text // " of the normal force"
      if (part%name == "friction") text = text // " model"
   end function model_doc

   !> Position of a key among those of each model of some parts, one after the other.
   pure function places_of(parts, name) result(places)
      type(part_type), intent(in) :: parts(:)
      character(len=*), intent(in) :: name
      integer, allocatable :: places(:)
      integer :: i, j, n

      allocate(places(sum([(size(parts(i)%keys), i=1, size(parts))])))
      n = 0
      do i = 1, size(parts)
         do j = 1, size(parts(i)%keys)
            n = n + 1
            places(n) = parts(i)%keys(j)%at(name)
         end do
      end do
   end function places_of

   !> A key of the schema, from the keys of that name of all models: whatever one of them admits.
   function merged_key(parts, name) result(key)
      type(part_type), intent(in) :: parts(:)
      character(len=*), intent(in) :: name
      type(key_type) :: key
      type(law_key_type), allocatable :: items(:)
      character(len=24), allocatable :: owners(:)
      character(len=:), allocatable :: doc, part
      logical, allocatable :: needs(:)
      logical :: alike, same_unit
      integer :: i, j, k, n, acting

      n = count(places_of(parts, name) > 0)
      allocate(items(n), owners(n))
      n = 0
      acting = 0
      do i = 1, size(parts)
         if (all(places_of(parts(i:i), name) == 0)) cycle
         acting = acting + count(parts(i)%models%acts)
         do j = 1, size(parts(i)%models)
            k = parts(i)%keys(j)%at(name)
            if (k == 0) cycle
            n = n + 1
            items(n) = parts(i)%keys(j)%keys(k)
            owners(n) = parts(i)%models(j)%info%name
         end do
      end do
      key = items(1)%key
      alike = all(items%key%doc == key%doc)
      same_unit = all(items%key%unit == key%unit)
      doc = trim(key%doc)
      if (.not. alike) doc = ""
      if (alike .and. .not. same_unit) doc = doc // ": "
      do i = 1, n
         associate (item => items(i)%key)
            if (item%low < key%low) key%above_low = item%above_low
            if (.not. item%low > key%low .and. .not. item%low < key%low) then
               key%above_low = key%above_low .and. item%above_low
            end if
            key%low = min(key%low, item%low)
            key%high = max(key%high, item%high)
            if (key%default == "") key%default = item%default
            if (.not. same_unit) key%unit = "model"
            if (alike .and. same_unit) cycle
            if (i > 1) doc = doc // trim(merge(", ", "; ", alike)) // " "
            doc = doc // trim(owners(i))
            if (.not. alike) doc = doc // ": " // trim(item%doc)
            if (.not. same_unit) doc = doc // " " // &
               trim(adjustl(trim(items(i)%symbol) // " [" // plain_unit(item%unit) // "]"))
         end associate
      end do
      part = trim(parts(size(parts))%name)
      needs = items%key%mandatory .and. all(items%instead == "")
      if (count(needs) == acting) then
         doc = doc // "; mandatory with " // part
      else if (any(needs)) then
         doc = doc // "; mandatory with " // part // " = " // listed(pack(owners, needs))
      else if (alike .and. n < acting) then
         doc = doc // "; goes with " // part // " = " // listed(owners)
      end if
      key%mandatory = .false.
      key%doc = doc
   end function merged_key

   !> Names in quotes, "'a', 'b' or 'c'".
   pure function listed(names) result(text)
      character(len=*), intent(in) :: names(:)
      character(len=:), allocatable :: text
      integer :: i

      text = ""
      do i = 1, size(names)
         if (i > 1) text = text // trim(merge(" or", ",  ", i == size(names))) // " "
         text = text // quote(trim(names(i)))
      end do
   end function listed

   !> Read which models a contact has, and the values of their keys.
   subroutine read_models(settings, parts, choice, parameters, diagnostics)
      !> The group `contact`.
      type(group_settings_type), intent(in) :: settings
      !> From `contact_parts`.
      type(part_type), intent(in) :: parts(:)
      !> Position of the model of each part in its table.
      integer, intent(out) :: choice(n_parts)
      !> Values of all keys that have one.
      type(parameters_type), intent(inout) :: parameters
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i, j, k

      do i = 1, n_parts
         choice(i) = max(settings%choice(trim(parts(i)%name)), 1)
      end do
      do i = 1, n_parts
         call check_needs(settings, parts(i), choice(i), diagnostics)
         do j = 1, size(parts(i)%models)
            do k = 1, parts(i)%keys(j)%n
               associate (item => parts(i)%keys(j)%keys(k))
                  if (parameters%has(item%key%name)) cycle
                  call take(item%key%name, item%key%kind)
                  if (settings%is_given(item%key%name)) then
                     call check_use(settings, parts, choice, trim(item%key%name), diagnostics)
                  else
                     call drop_default(item%key%name)
                  end if
               end associate
            end do
         end do
      end do
      parameters%complete = .true.

   contains

      !> Take the value of a key; one that has none is noted as a mistake elsewhere, or absent.
      subroutine take(name, kind)
         character(len=*), intent(in) :: name
         integer, intent(in) :: kind

         if (.not. settings%is_set(name)) return
         select case (kind)
         case (kind_logical)
            call parameters%set(name, settings%flag(name))
         case (kind_choice)
            call parameters%set(name, real(settings%choice(name), wp))
         case (kind_integer)
            call parameters%set(name, real(settings%integer(name), wp))
         case default
            call parameters%set(name, settings%numbers(name))
         end select
      end subroutine take

      !> Drop the default of a key that no model of an acting part has: in the resolved text it
      !> would be refused.
      subroutine drop_default(name)
         character(len=*), intent(in) :: name
         integer, allocatable :: places(:)
         integer :: n

         if (.not. settings%is_set(name)) return
         do n = 1, n_parts
            places = places_of(parts(n:n), name)
            if (all(places == 0)) cycle
            if (places(choice(n)) > 0 .or. .not. parts(n)%models(choice(n))%acts) return
         end do
         call settings%unset(name)
      end subroutine drop_default

   end subroutine read_models

   !> Report what a model needs and a contact does not give, gives twice or out of range.
   subroutine check_needs(settings, part, choice, diagnostics)
      type(group_settings_type), intent(in) :: settings
      type(part_type), intent(in) :: part
      !> Position of the model in the table.
      integer, intent(in) :: choice
      type(diagnostics_type), intent(inout) :: diagnostics
      type(origin_type) :: here
      character(len=:), allocatable :: what, name, other, wanted
      integer :: i, j

      what = trim(part%name) // " " // quote(trim(part%models(choice)%info%name))
      here = settings%place(trim(part%name))
      do i = 1, part%keys(choice)%n
         associate (item => part%keys(choice)%keys(i))
            if (item%idle) cycle
            name = trim(item%key%name)
            other = trim(item%instead)
            j = part%keys(choice)%at(other)
            if (settings%is_given(name)) then
               call check_range(item)
               if (j > 0 .and. j < i) then
                  if (settings%is_given(other)) call diagnostics%add(settings%place(name), &
                     "the " // trim(part%name) // " is given twice", &
                     "either " // other // " or " // name)
               end if
            else if (item%key%mandatory .and. j > i) then
               if (settings%lacks(name) .and. settings%lacks(other)) call diagnostics%add(here, &
                  what // " needs its coefficient", part%models(choice)%keys_text())
            else if (item%key%mandatory .and. j == 0) then
               if (stands_in(name)) cycle
               wanted = item%wanted()
               if (item%symbol /= "" .or. any(part%keys(choice)%keys%symbol /= "")) then
                  wanted = wanted // "; keys: " // part%models(choice)%keys_text()
               end if
               call settings%require(name, here, what // " needs '" // name // "'", wanted, &
                  diagnostics)
            end if
         end associate
      end do

   contains

      !> Whether a key is given that stands in the place of another one in some model of the part.
      logical function stands_in(name)
         character(len=*), intent(in) :: name
         integer :: m, k

         stands_in = .false.
         do m = 1, size(part%keys)
            do k = 1, part%keys(m)%n
               if (part%keys(m)%keys(k)%instead == name) stands_in = stands_in .or. &
                  settings%is_given(trim(part%keys(m)%keys(k)%key%name))
            end do
         end do
      end function stands_in

      !> Report a number that this model does not admit, though another one may.
      subroutine check_range(item)
         type(law_key_type), intent(in) :: item
         character(len=:), allocatable :: text

         if (item%key%kind /= kind_real .or. .not. settings%is_set(name)) return
         if (admits(item%key, settings%number(name))) return
         text = "' is out of range for "
         if (item%key%above_low .and. abs(item%key%low) <= 0.0_wp) text = "' must be positive for "
         call diagnostics%add(settings%place(name, 1), "'" // name // text // &
            quote(trim(part%models(choice)%info%name)), item%wanted_value())
      end subroutine check_range

   end subroutine check_needs

   !> Report a key that is given and that no model of the contact has; where a part is switched off
   !> by name, its keys may stay.
   subroutine check_use(settings, parts, choice, name, diagnostics)
      type(group_settings_type), intent(in) :: settings
      type(part_type), intent(in) :: parts(:)
      !> Positions of the models in their tables.
      integer, intent(in) :: choice(:)
      !> The key.
      character(len=*), intent(in) :: name
      type(diagnostics_type), intent(inout) :: diagnostics
      character(len=:), allocatable :: goes, with, instead
      integer, allocatable :: places(:)
      integer :: i, j, k

      do i = 1, n_parts
         places = places_of(parts(i:i), name)
         if (all(places == 0)) cycle
         k = places(choice(i))
         if (k > 0) then
            with = trim(parts(i)%keys(choice(i))%keys(k)%with)
            if (with == "") return
            if (settings%is_given(with)) return
         end if
         associate (part => parts(i))
            if (.not. part%models(choice(i))%acts .and. settings%is_given(trim(part%name))) return
            goes = trim(part%name) // " = " // &
               listed(pack(part%models%info%name, places > 0))
            if (count(places > 0) == count(part%models%acts)) goes = trim(part%name) // &
               " = the name of a " // trim(merge("law  ", "model", part%name == "damping"))
            j = findloc(places > 0, .true., dim=1)
            with = trim(part%keys(j)%keys(places(j))%with)
            instead = trim(part%keys(j)%keys(places(j))%instead)
         end associate
      end do
      associate (part => parts(last_with(name)))
         i = last_with(name)
         if (.not. part%models(choice(i))%acts) then
            call diagnostics%add(settings%place(name), "'" // name // "' without '" // &
               trim(part%name) // "'", goes)
         else if (part%keys(choice(i))%at(instead) > 0 .and. &
            part%keys(choice(i))%at(name) == 0) then
            call diagnostics%add(settings%place(name), trim(part%name) // " " // &
               quote(trim(part%models(choice(i))%info%name)) // " has no formula for a " // name, &
               instead)
         else
            if (with /= "") goes = goes // " and " // with
            call diagnostics%add(settings%place(name), "'" // name // "' has no meaning here", &
               "it goes with " // goes)
         end if
      end associate

   contains

      !> The last part that has a key.
      pure integer function last_with(name)
         character(len=*), intent(in) :: name

         do last_with = n_parts, 2, -1
            if (any(places_of(parts(last_with:last_with), name) > 0)) return
         end do
      end function last_with

   end subroutine check_use

end module contensou_contact_parts
