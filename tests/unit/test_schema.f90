!> Tests of the table of keys and of the settings made with it.
module test_schema
   use contensou_base_diagnostics, only : diagnostics_type, origin_type
   use contensou_base_document, only : document_type, parse_document
   use contensou_base_kinds, only : wp
   use contensou_base_numbers, only : read_real
   use contensou_base_resolve, only : resolve
   use contensou_base_schema, only : admits, domain_text, group_spec_type, is_number, key_type, &
      kind_choice, kind_file, kind_integer, kind_logical, kind_name, kind_real, kind_reference, &
      kind_text, most_values, schema_type
   use contensou_base_settings, only : group_settings_type, settings_type
   use contensou_base_text, only : string_type
   use contensou_scene_overrides, only : apply_override, index_groups, index_type
   use contensou_scene_schema, only : scene_schema, schema_groups, schema_keys
   use test_harness, only : check, check_close
   implicit none(type, external)
   private

   public :: run_schema_tests

   !> Line end.
   character(len=1), parameter :: lf = achar(10)

   !> The least that a scene needs.
   character(len=*), parameter :: least = "&scene t_end = 1 /" // lf // &
      "&body name = 'top', mass = 1, inertia = 1, 1, 1 /" // lf

   !> The groups and keys of a scene.
   type(schema_type), target :: schema

contains

   !> Run all tests.
   subroutine run_schema_tests()
      call scene_schema(schema)
      call test_groups()
      call test_keys()
      call test_defaults()
      call test_domain()
      call test_resolve()
      call test_values()
      call test_mistakes()
      call test_ranges()
      call test_resolved_text()
      call test_overrides()
      call test_wrong_overrides()
   end subroutine run_schema_tests

   !> Groups are documented, their names are unique.
   subroutine test_groups()
      type(group_spec_type), allocatable :: groups(:)
      type(key_type), allocatable :: keys(:)
      integer :: i

      groups = schema_groups()
      keys = schema_keys()
      do i = 1, size(groups)
         call check(groups(i)%doc /= "", trim(groups(i)%name) // ": documented")
         call check(count(groups%name == groups(i)%name) == 1, trim(groups(i)%name) // ": once")
         call check(any(keys%group == groups(i)%name), trim(groups(i)%name) // ": has keys")
         call check(any(keys%group == groups(i)%name .and. keys%kind == kind_name) .eqv. &
            groups(i)%repeats, trim(groups(i)%name) // ": has a name if it repeats")
      end do
   end subroutine test_groups

   !> Keys are documented, their names unique, their choices and targets there.
   subroutine test_keys()
      type(group_spec_type), allocatable :: groups(:)
      type(key_type), allocatable :: keys(:)
      type(string_type), allocatable :: choices(:)
      character(len=:), allocatable :: name
      integer :: i, k, same
      logical :: full

      groups = schema_groups()
      keys = schema_keys()
      call check(size(keys) > 30, "the schema has keys")
      do i = 1, size(keys)
         associate (key => keys(i))
            name = trim(key%group) // "." // trim(key%name)
            call check(key%doc /= "", name // ": documented")
            call check(key%doc(len(key%doc):) == "", name // ": documentation not cut off")
            call check(key%name(len(key%name):) == "", name // ": name not cut off")
            call check(any(groups%name == key%group), name // ": its group is known")
            same = count(keys%group == key%group .and. keys%name == key%name)
            call check(same == 1, name // ": once")
            call check(any(key%kind == [kind_real, kind_text, kind_name, kind_choice, &
               kind_reference, kind_logical, kind_integer, kind_file]), name // ": kind")
            call check(key%values >= 1 .and. key%values <= most_values, &
               name // ": number of values")
            call check((key%unit /= "") .eqv. is_number(key), name // ": a unit for numbers")
            call check(.not. (key%mandatory .and. key%default /= ""), name // &
               ": mandatory, or with a default")
            choices = key%names()
            call check(size(choices) > 0 .eqv. key%kind == kind_choice, name // ": choices")
            full = .true.
            do k = 1, size(choices)
               full = full .and. len(choices(k)%s) > 0
            end do
            call check(full, name // ": no choice is blank")
            call check((key%target /= "") .eqv. key%kind == kind_reference, name // ": target")
            if (key%kind == kind_reference) call check(any(groups%name == key%target), name // &
               ": its target is a group")
            if (is_number(key)) call check(len(domain_text(key)) > 8, name // ": domain")
         end associate
      end do
   end subroutine test_keys

   !> Defaults can be read and are admitted.
   subroutine test_defaults()
      type(key_type), allocatable :: keys(:)
      type(string_type), allocatable :: choices(:)
      character(len=:), allocatable :: name, rest
      real(wp) :: x
      integer :: i, k, n, comma
      logical :: valid, good

      keys = schema_keys()
      do i = 1, size(keys)
         associate (key => keys(i))
            if (key%default == "") cycle
            name = trim(key%group) // "." // trim(key%name)
            rest = trim(key%default)
            select case (key%kind)
            case (kind_real, kind_integer)
               good = .true.
               do n = 1, key%values
                  ! A key of few values has any number of them.
                  if (key%fewer .and. n > 1 .and. rest == "") exit
                  comma = index(rest // ",", ",")
                  call read_real(trim(adjustl(rest(:comma - 1))), x, valid)
                  good = good .and. valid
                  if (valid) good = good .and. admits(key, x)
                  rest = rest(min(comma + 1, len(rest) + 1):)
               end do
               call check(good .and. rest == "", name // ": default")
            case (kind_logical)
               call check(rest == ".true." .or. rest == ".false.", name // ": default")
            case (kind_choice)
               choices = key%names()
               do n = 1, key%values
                  if (key%fewer .and. n > 1 .and. rest == "") exit
                  comma = index(rest // ",", ",")
                  good = .false.
                  do k = 1, size(choices)
                     good = good .or. adjustl(rest(:comma - 1)) == "'" // choices(k)%s // "'"
                  end do
                  if (.not. good) exit
                  rest = rest(min(comma + 1, len(rest) + 1):)
               end do
               call check(good, name // ": default is a choice")
            case default
               call check(rest(1:1) == "'" .and. rest(len(rest):) == "'" .and. len(rest) >= 2, &
                  name // ": default in quotes")
            end select
         end associate
      end do
   end subroutine test_defaults

   !> Bounds of numbers, and their words.
   subroutine test_domain()
      type(key_type) :: key

      key%kind = kind_real
      key%unit = "kg"
      call check(admits(key, -1.0e300_wp) .and. domain_text(key) == "a number [kg]", &
         "domain: any number")
      key%low = 0.0_wp
      call check(admits(key, 0.0_wp) .and. .not. admits(key, -1.0e-300_wp) .and. &
         domain_text(key) == "a number >= 0.0 [kg]", "domain: from")
      key%above_low = .true.
      call check(.not. admits(key, 0.0_wp) .and. admits(key, 1.0e-300_wp) .and. &
         domain_text(key) == "a number > 0.0 [kg]", "domain: above")
      key%high = 0.5_wp
      call check(admits(key, 0.5_wp) .and. .not. admits(key, 0.6_wp) .and. &
         domain_text(key) == "a number > 0.0 and <= 0.5 [kg]", "domain: above and up to")
      key%values = 3
      key%unit = "1"
      call check(domain_text(key) == "3 numbers > 0.0 and <= 0.5 [-]", "domain: three numbers")
   end subroutine test_domain

   !> Parse and resolve a text.
   subroutine decode(text, settings, diagnostics)
      character(len=*), intent(in) :: text
      type(settings_type), intent(out), target :: settings
      !> Its mistakes.
      type(diagnostics_type), intent(out) :: diagnostics
      type(document_type) :: document

      call parse_document("scene.nml", text, document, diagnostics)
      call resolve(document, schema, settings, diagnostics)
   end subroutine decode

   !> A text without a mistake.
   subroutine test_resolve()
      type(settings_type), target :: settings
      type(diagnostics_type) :: diagnostics
      type(group_settings_type) :: scene, body
      type(origin_type) :: key, value

      call decode(least, settings, diagnostics)
      call check(diagnostics%count() == 0 .and. size(settings%groups) == 2, "the least scene")
      scene = settings%group(1, schema)
      body = settings%group(2, schema)
      call check(body%label() == "top" .and. scene%label() == "", "names of groups")
      call check_close(scene%number("t_end"), 1.0_wp, 0.0_wp, "a number that is given")
      key = scene%place("t_end")
      value = scene%place("t_end", 1)
      call check(scene%is_given("t_end") .and. scene%is_set("t_end") .and. &
         key%line == 1 .and. key%column == 8 .and. value%column == 16, "where it stands")
      call check(.not. scene%is_given("gravity") .and. scene%is_set("gravity") .and. &
         norm2(scene%numbers("gravity")) <= 0.0_wp, "a default")
      call check(.not. body%is_given("axis") .and. .not. body%is_set("axis"), &
         "neither given nor default")
   end subroutine test_resolve

   !> Values in all the ways they can be given.
   subroutine test_values()
      type(settings_type), target :: settings
      type(diagnostics_type) :: diagnostics
      type(group_settings_type) :: contact, body

      call decode(least // "&contact name = ' A b ', surfaces = 'x', 'y', drilling = F" // lf // &
         "friction = 'PADE22', normal = 'Hertz' /" // lf // &
         "&body name = 'b', mass = 2, inertia(2) = 5, inertia(1) = 4, inertia(3:3) = 6" // lf // &
         "position = 3*1.5, velocity(1:2) = 7, 8, velocity(3) = 9 /", settings, diagnostics)
      call check(diagnostics%count() == 0, "values: no mistake")
      if (diagnostics%count() > 0) return
      contact = settings%group(3, schema)
      body = settings%group(4, schema)
      call check(contact%label() == "A b", "values: name without blanks around it")
      call check(.not. contact%flag("drilling"), "values: logical")
      call check(contact%text("friction") == "pade22" .and. contact%choice("normal") == 1, &
         "values: choice in any case")
      call check(contact%text("surfaces", 2) == "y", "values: references")
      call check(norm2(body%numbers("inertia") - [4.0_wp, 5.0_wp, 6.0_wp]) <= 0.0_wp, &
         "values: by subscript")
      call check(norm2(body%numbers("position") - 1.5_wp) <= 0.0_wp, "values: repeated")
      call check(norm2(body%numbers("velocity") - [7.0_wp, 8.0_wp, 9.0_wp]) <= 0.0_wp, &
         "values: by sections")
   end subroutine test_values

   !> Check that a text has exactly one mistake.
   subroutine expect(text, message, expected, line, name)
      character(len=*), intent(in) :: text
      !> Part of what is wrong.
      character(len=*), intent(in) :: message
      !> Part of what would be right.
      character(len=*), intent(in) :: expected
      integer, intent(in) :: line
      !> What is checked.
      character(len=*), intent(in) :: name
      type(settings_type), target :: settings
      type(diagnostics_type) :: diagnostics

      call decode(text, settings, diagnostics)
      call check_mistake(diagnostics, message, expected, line, name)
   end subroutine expect

   !> Check that there is exactly one mistake.
   subroutine check_mistake(diagnostics, message, expected, line, name)
      !> The mistakes.
      type(diagnostics_type), intent(in) :: diagnostics
      !> Part of what is wrong.
      character(len=*), intent(in) :: message
      !> Part of what would be right.
      character(len=*), intent(in) :: expected
      !> Its line; -1 for any.
      integer, intent(in) :: line
      !> What is checked.
      character(len=*), intent(in) :: name
      character(len=:), allocatable :: says

      says = name // ": one mistake"
      if (diagnostics%count() > 0) then
         says = says // ", " // diagnostics%message(1) // "; expected " // diagnostics%expected(1)
      end if
      call check(diagnostics%count() == 1, says)
      if (diagnostics%count() == 0) return
      call check(index(diagnostics%message(1), message) > 0, says // " (message)")
      call check(index(diagnostics%expected(1), expected) > 0, says // " (expected)")
      associate (origin => diagnostics%origin(1))
         call check(origin%line == line .or. line < 0, says // " (line)")
      end associate
   end subroutine check_mistake

   !> Mistakes of groups, keys and kinds.
   subroutine test_mistakes()
      type(settings_type), target :: settings
      type(diagnostics_type) :: diagnostics

      call expect(least // "&materal name = 'a' /", "unknown group &materal", "&material", 3, &
         "unknown group")
      call expect(least // "&xyz a = 1 /", "unknown group &xyz", "one of &scene, &material", 3, &
         "unknown group without a near one")
      call expect(least // "&integrator rtoll = 1e-6 /", &
         "unknown key 'rtoll' in group &integrator", "rtol", 3, "unknown key")
      call expect(least // "&integrator qqqqqqqqq = 1e-6 /", "unknown key 'qqqqqqqqq'", &
         "one of method, rtol", 3, "unknown key without a near one")
      call expect(least // "&material name = 'b', young = 1 /", &
         "'poisson' is missing in group &material 'b'", &
         "poisson = a number > -1.0 and <= 0.5 [-]", &
         3, "missing key")
      call expect("&scene t_end = 1 /", "there is no group &body", "&body", 0, "missing group")
      call expect(least // "&scene t_end = 2 /", "group &scene given twice", "in line 1", 3, &
         "group given twice")
      call expect(least // "&output interval = 1," // lf // "interval = 2 /", &
         "'interval' given twice", "in line 3", 4, "key given twice")
      call expect(least // "&body name = 'b', mass = 1, inertia = 1, 1, 1, inertia(2) = 1 /", &
         "'inertia' given twice", "in line 3", 3, "value given twice")
      call expect(least // "&body name = 'b', mass = 1, inertia(4) = 1 /", &
         "the subscript is out of range", "3 numbers", 3, "subscript beyond the end")
      call expect(least // "&output interval(1) = 1 /", "the subscript is out of range", "", 3, &
         "subscript of a single value")
      call expect(least // "&body name = 'b', mass = 1, inertia(1:4) = 1, 1, 1 /", &
         "the subscript is out of range", "3 numbers", 3, "section beyond the end")
      call expect(least // "&body name = 'b', mass = 1, inertia = 1, 1, 1, 1 /", &
         "too many values for 'inertia'", "3 numbers", 3, "too many values")
      call expect(least // "&body name = 'b', mass = 1, inertia = 1, 1 /", &
         "'inertia' has 2 of 3 values", "3 numbers", 3, "too few values")
      call expect(least // "&body name = 'b', mass = 1, inertia = 1, , 1 /", &
         "a value of 'inertia' is missing", "3 numbers", 3, "value left out")
      call expect(least // "&output interval = /", "no value for 'interval'", "a number", 3, &
         "no value")
      call expect(least // "&output interval = 'x' /", &
         "'interval' needs a number, this is a text", "a number > 0.0 [s]", 3, "text for a number")
      call expect(least // "&output interval = .true. /", &
         "'interval' needs a number, this is a logical", "a number", 3, "logical for a number")
      call expect(least // "&output file = 3 /", &
         "'file' needs a text in quotes, this is a number", "the name of a file", 3, &
         "number for a text")
      call expect(least // "&integrator method = 'cvode_dbf' /", "unknown method 'cvode_dbf'", &
         "'cvode_bdf'; possible are cvode_bdf, cvode_adams, explicit8, auto", 3, "unknown choice")
      call expect(least // "&integrator method = 'zzzzzzzzzz' /", "unknown method 'zzzzzzzzzz'", &
         "one of cvode_bdf, cvode_adams, explicit8, auto", 3, "unknown choice without a near one")
      call expect(least // "&integrator method = '' /", "'method' is empty", "one of", 3, &
         "empty choice")
      call expect(least // "&material name = ' ', young = 1, poisson = 0 /", "'name' is empty", &
         "a name in quotes", 3, "empty name")
      call expect(least // "&contact name = 'c', surfaces = 'a', 'b', drilling = 1 /", &
         "'drilling' needs a logical, this is a number", ".true. or .false.", 3, &
         "number for a logical")
      call expect(least // "&contact name = 'c', surfaces = 'a' /", &
         "'surfaces' has 1 of 2 values", "the names of two surfaces", 3, "one reference for two")

      call decode("&scen t_end = 1 /" // lf // "&material nam = 'x', young = 'y' /", &
         settings, diagnostics)
      ! Group, key, kind, the missing poisson and body; not what is meant by the misspelt ones.
      call check(diagnostics%count() == 5, "all mistakes are reported at once")
   end subroutine test_mistakes

   !> Numbers out of their range.
   subroutine test_ranges()
      type(settings_type), target :: settings
      type(diagnostics_type) :: diagnostics

      call expect(least // "&body name = 'b', mass = 0, inertia = 1, 1, 1 /", &
         "'mass' is out of range", "a number > 0.0 [kg]", 3, "mass zero")
      call expect(least // "&body name = 'b', mass = -1, inertia = 1, 1, 1 /", &
         "'mass' is out of range", "a number > 0.0 [kg]", 3, "mass negative")
      call expect(least // "&body name = 'b', mass = 1, inertia = 1, -1, 1 /", &
         "'inertia' is out of range", "3 numbers > 0.0 [kg m2]", 3, "inertia negative")
      call expect(least // "&body name = 'b', mass = NaN, inertia = 1, 1, 1 /", &
         "'mass' must be finite", "a number > 0.0 [kg]", 3, "NaN")
      call expect(least // "&body name = 'b', mass = Inf, inertia = 1, 1, 1 /", &
         "'mass' must be finite", "a number > 0.0 [kg]", 3, "infinity")
      call expect(least // "&material name = 'm', young = 1, poisson = 0.51 /", &
         "'poisson' is out of range", "> -1.0 and <= 0.5 [-]", 3, "Poisson's ratio too large")
      call expect(least // "&material name = 'm', young = 1, poisson = -1 /", &
         "'poisson' is out of range", "> -1.0 and <= 0.5 [-]", 3, "Poisson's ratio too small")
      call expect(least // "&integrator rtol = 1e-15 /", "'rtol' is out of range", &
         ">= 1.0e-14 and <= 0.1 [-]", 3, "tolerance too small")
      call expect(least // "&integrator rtol = 0.2 /", "'rtol' is out of range", &
         ">= 1.0e-14 and <= 0.1 [-]", 3, "tolerance too large")
      call expect(least // "&contact name = 'c', surfaces = 'a', 'b', restitution = 1.1 /", &
         "'restitution' is out of range", ">= 0.0 and <= 1.0 [-]", 3, "restitution too large")
      call decode(least // "&material name = 'm', young = 1, poisson = 0.5 /" // lf // &
         "&integrator rtol = 1.0d-14 /", settings, diagnostics)
      call check(diagnostics%count() == 0, "ranges: the bounds themselves")
   end subroutine test_ranges

   !> The settings as text are a scene with the same settings.
   subroutine test_resolved_text()
      type(settings_type) :: settings, again
      type(diagnostics_type) :: diagnostics
      character(len=:), allocatable :: text

      call decode(least // "&surface name = 'it''s', body = 'top', shape = 'SPHERE', radius = 0.1" &
         // " material = 'm' /" // lf // "&output interval = 1.0e-3 /", settings, diagnostics)
      text = settings%text(schema)
      call check(index(text, "gravity = 0.0, 0.0, 0.0") > 0, "resolved text: defaults")
      call check(index(text, "name = 'it''s'") > 0, "resolved text: quotes")
      call check(index(text, "shape = 'sphere'") > 0, "resolved text: choices")
      call check(index(text, "axis") == 0, "resolved text: nothing that is not set")
      call decode(text, again, diagnostics)
      call check(diagnostics%count() == 0, "resolved text: can be read")
      call check(again%text(schema) == text, "resolved text: the same again")
   end subroutine test_resolved_text

   !> A scene for overrides: names that are ambiguous, no group integrator.
   pure function scene_text() result(text)
      character(len=:), allocatable :: text

      text = least // "&material name = 'wood', young = 1, poisson = 0.1 /" // lf // &
         "&material name = 'Steel', young = 2, poisson = 0.2 /" // lf // &
         "&surface name = 'top', body = 'top', shape = 'sphere', radius = 1, material = 'wood' /" &
         // lf // "&output interval = 0.5 /"
   end function scene_text

   !> Apply overrides to that scene.
   subroutine override(settings, diagnostics, first, second)
      type(settings_type), intent(out), target :: settings
      !> The mistakes.
      type(diagnostics_type), intent(out) :: diagnostics
      !> An override.
      character(len=*), intent(in) :: first
      !> Another one.
      character(len=*), intent(in), optional :: second
      type(document_type) :: document
      type(index_type) :: index_of

      call parse_document("scene.nml", scene_text(), document, diagnostics)
      call index_groups(document, schema, index_of)
      call apply_override(document, schema, index_of, first, diagnostics)
      if (present(second)) call apply_override(document, schema, index_of, second, diagnostics)
      call resolve(document, schema, settings, diagnostics)
   end subroutine override

   !> A number of a setting.
   function number(settings, instance, key, slot) result(x)
      type(settings_type), intent(in), target :: settings
      !> Number of the group.
      integer, intent(in) :: instance
      character(len=*), intent(in) :: key
      !> Which of its values.
      integer, intent(in) :: slot
      real(wp) :: x
      real(wp), allocatable :: values(:)
      type(group_settings_type) :: group

      x = -1.0_wp
      if (.not. allocated(settings%groups)) return
      if (instance > size(settings%groups)) return
      group = settings%group(instance, schema)
      values = group%vector(key, slot)
      x = values(slot)
   end function number

   !> Values from the command line.
   subroutine test_overrides()
      type(settings_type), target :: settings
      type(group_settings_type) :: group
      type(diagnostics_type) :: diagnostics

      call override(settings, diagnostics, "scene.t_end=2.5")
      call check(diagnostics%count() == 0, "override: group.key")
      call check_close(number(settings, 1, "t_end", 1), 2.5_wp, 0.0_wp, &
         "override: group.key, value")
      call override(settings, diagnostics, " Scene.T_end = 2.5")
      call check_close(number(settings, 1, "t_end", 1), 2.5_wp, 0.0_wp, "override: any case")
      call override(settings, diagnostics, "scene.gravity=0, 0, -9.81")
      call check(diagnostics%count() == 0, "override: several values")
      call check_close(number(settings, 1, "gravity", 3), -9.81_wp, 0.0_wp, &
         "override: several values, the last")
      call override(settings, diagnostics, "material.young=7")
      call check(diagnostics%count() == 0, "override: every group of that name")
      call check_close(number(settings, 3, "young", 1), 7.0_wp, 0.0_wp, &
         "override: the first of them")
      call check_close(number(settings, 4, "young", 1), 7.0_wp, 0.0_wp, "override: the second")
      call override(settings, diagnostics, "steel.young=7")
      call check(diagnostics%count() == 0, "override: name.key")
      call check_close(number(settings, 3, "young", 1), 1.0_wp, 0.0_wp, &
         "override: name.key, the other one")
      call check_close(number(settings, 4, "young", 1), 7.0_wp, 0.0_wp, "override: name.key, value")
      call override(settings, diagnostics, "top.mass=3")
      call check(diagnostics%count() == 0, "override: a name that the key makes unambiguous")
      call check_close(number(settings, 2, "mass", 1), 3.0_wp, 0.0_wp, "override: its value")
      call override(settings, diagnostics, "surface.top.radius=3")
      call check(diagnostics%count() == 0, "override: group.name.key")
      call check_close(number(settings, 5, "radius", 1), 3.0_wp, 0.0_wp, "override: its value too")
      call override(settings, diagnostics, "integrator.rtol=1e-6", "integrator.max_step=1e-3")
      call check(diagnostics%count() == 0, "override: a group that is missing")
      call check_close(number(settings, 7, "rtol", 1), 1.0e-6_wp, 0.0_wp, "override: is added")
      call check_close(number(settings, 7, "max_step", 1), 1.0e-3_wp, 0.0_wp, "override: once")
      call override(settings, diagnostics, "scene.t_end=2", "scene.t_end=3")
      call check(diagnostics%count() == 0, "override: twice")
      call check_close(number(settings, 1, "t_end", 1), 3.0_wp, 0.0_wp, "override: the last counts")
      call override(settings, diagnostics, "output.file=my run.h5")
      call check(diagnostics%count() == 0, "override: a text without quotes")
      group = settings%group(6, schema)
      call check(group%text("file") == "my run.h5", "override: its words")
   end subroutine test_overrides

   !> Mistakes in values from the command line.
   subroutine test_wrong_overrides()
      call refuse("top.name='x'", "ambiguous", "body.top.name surface.top.name", "ambiguous name")
      call refuse("steal.young=1", "no group or name 'steal'", "steel.young", "unknown name")
      call refuse("qqqqqqqq.young=1", "no group or name 'qqqqqqqq'", "the name of a group", &
         "unknown name without a near one")
      call refuse("contact.friction=none", "the scene has no group &contact", "", &
         "group that repeats and is missing")
      call refuse("scene.t_ende=1", "unknown key 't_ende'", "t_end", "unknown key")
      call refuse("wood.yung=1", "unknown key 'yung'", "young", "unknown key of a name")
      call refuse("scene.t_end", "'=' is missing", "group.key=value", "no equals sign")
      call refuse("t_end=1", "does not say what to set", "group.key", "no group")
      call refuse("=1", "does not say what to set", "group.key", "nothing before the equals sign")
      call refuse("scene.=1", "does not say what to set", "group.key", "no key")
      call refuse("scene.t_end=", "no value for 't_end'", "a number", "no value")
      call refuse("scene.t_end=soon", "needs a number", "a number", "text for a number")
      call refuse("scene.t_end=-1", "out of range", "a number > 0.0 [s]", "out of range")
      call refuse("scene.t_end=1,2", "too many values", "a number", "too many values")
      call refuse("integrator.method=euler", "unknown method", "cvode_bdf", "unknown choice")

   contains

      !> Check that an override is one mistake.
      subroutine refuse(text, message, expected, name)
         !> The override.
         character(len=*), intent(in) :: text
         !> Part of what is wrong.
         character(len=*), intent(in) :: message
         !> Part of what would be right.
         character(len=*), intent(in) :: expected
         !> What is checked.
         character(len=*), intent(in) :: name
         type(settings_type), target :: settings
         type(diagnostics_type) :: diagnostics

         call override(settings, diagnostics, text)
         call check_mistake(diagnostics, message, expected, -1, "override: " // name)
      end subroutine refuse

   end subroutine test_wrong_overrides

end module test_schema
