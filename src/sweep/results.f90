!> What a sweep keeps of each case: the columns of the results of its table.
module contensou_sweep_results
   use contensou_base_diagnostics, only : diagnostics_type, origin_type
   use contensou_base_numbers, only : to_text
   use contensou_base_settings, only : group_settings_type
   use contensou_base_text, only : join, lower, nearest, quote, string_type, strings
   use contensou_contact_parts, only : owns_state
   use contensou_dynamics_scene, only : scene_type, turns_by_drive
   use contensou_scene_contacts, only : remembers
   use contensou_study_quantities, only : final_quantities, row_quantities
   use contensou_study_quantity, only : if_driven, if_memory, if_springs, if_states, &
      quantity_type
   use contensou_study_summary, only : summary_quantities, summary_stop
   use contensou_study_case, only : event_names, source_event, source_state, source_summary, &
      source_value
   use contensou_sweep_plan, only : result_column_type, sweep_type
   use contensou_sweep_schema, only : keep_names
   implicit none(type, external)
   private

   public :: check_column, read_results

   !> Descriptions of what is kept of the events of a contact.
   character(len=*), parameter :: event_docs(*) = [character(len=26) :: "time of the first touch", &
      "time of the last touch", "time of the first lift-off", "time of the last lift-off", &
      "touch events", "lift-off events"]

contains

   !> Columns of the results.
   subroutine read_results(main, groups, sweep, diagnostics)
      !> Group `sweep`.
      type(group_settings_type), intent(in) :: main
      type(group_settings_type), intent(in) :: groups(:)
      type(sweep_type), intent(inout) :: sweep
      type(diagnostics_type), intent(inout) :: diagnostics
      type(result_column_type), allocatable :: columns(:)
      logical :: keep_summary(size(summary_quantities)), keep_events(size(event_names))
      logical, allocatable :: keep_state(:)
      type(quantity_type), allocatable :: finals(:)
      integer :: i, n, n_values

      finals = final_quantities()
      allocate(keep_state(size(finals)))
      call read_keep(main, keep_summary, keep_events, keep_state, diagnostics)
      n_values = count([(groups(i)%group_name() == "value", i=1, size(groups))])
      allocate(columns(size(summary_quantities) + size(sweep%scene%contacts)*size(event_names) + &
         size(sweep%scene%bodies)*sum(finals%components) + n_values))
      n = 0
      call put_summary(sweep%scene, keep_summary, columns, n)
      call put_events(sweep%scene, keep_events, columns, n)
      do i = 1, size(sweep%scene%bodies)
         call put_states(sweep%scene%bodies(i)%name, i, finals, keep_state, columns, n)
      end do
      call check_names(columns(:n), sweep%scene, main, diagnostics)
      do i = 1, size(groups)
         if (groups(i)%group_name() /= "value") cycle
         n = n + 1
         call read_value(groups(i), sweep, columns(n), diagnostics)
      end do
      deallocate(sweep%results)
      allocate(sweep%results(n))
      do i = 1, n
         sweep%results(i) = columns(i)
      end do
      call check_value_names(groups, sweep%results, diagnostics)
      if (n == 0 .and. diagnostics%count() == 0) call diagnostics%add( &
         main%place("keep"), "nothing is kept of the cases", &
         "keep = 'summary', or a group &value")
   end subroutine read_results

   !> Columns of the summary of a run.
   subroutine put_summary(scene, keep, columns, n)
      type(scene_type), intent(in) :: scene
      !> For each of `summary_quantities`, whether it is kept.
      logical, intent(in) :: keep(:)
      type(result_column_type), intent(inout) :: columns(:)
      !> Number of columns so far.
      integer, intent(inout) :: n
      integer :: k

      do k = 1, size(summary_quantities)
         if (.not. keep(k)) cycle
         if (k == summary_stop .and. size(scene%stops) == 0) cycle
         associate (q => summary_quantities(k))
            call put(columns, n, q%name, q%units, trim(q%long_name), q%is_integer)
            if (k == summary_stop) columns(n)%long_name = columns(n)%long_name // &
               names_of_stops(scene)
         end associate
         columns(n)%source = source_summary
         columns(n)%quantity = k
      end do
   end subroutine put_summary

   !> Columns of the events of all contacts.
   subroutine put_events(scene, keep, columns, n)
      type(scene_type), intent(in) :: scene
      !> For each of `event_names`, whether it is kept.
      logical, intent(in) :: keep(:)
      type(result_column_type), intent(inout) :: columns(:)
      !> Number of columns so far.
      integer, intent(inout) :: n
      integer :: i, k

      do i = 1, size(scene%contacts)
         do k = 1, size(event_names)
            if (.not. keep(k)) cycle
            associate (contact => scene%contacts(i)%name)
               call put(columns, n, trim(event_names(k)) // "_" // column_word(contact), &
                  merge("1", "s", k > 4), trim(event_docs(k)) // " of " // contact, k > 4)
            end associate
            columns(n)%source = source_event
            columns(n)%quantity = k
            columns(n)%index = i
         end do
      end do
   end subroutine put_events

   !> Columns of the final state of a body.
   subroutine put_states(name, body, finals, keep, columns, n)
      character(len=*), intent(in) :: name
      !> Its number.
      integer, intent(in) :: body
      type(quantity_type), intent(in) :: finals(:)
      !> For each of `finals`, whether it is kept.
      logical, intent(in) :: keep(:)
      type(result_column_type), intent(inout) :: columns(:)
      !> Number of columns so far.
      integer, intent(inout) :: n
      character(len=1) :: letter
      integer :: j, k

      do k = 1, size(finals)
         if (.not. keep(k)) cycle
         do j = 1, finals(k)%components
            letter = component_word(finals(k)%components, j)
            call put(columns, n, trim(finals(k)%name) // "_" // column_word(name) // "_" // &
               letter, finals(k)%units, trim(finals(k)%long_name) // " of " // name // ", " // &
               letter, .false.)
            columns(n)%source = source_state
            columns(n)%quantity = k
            columns(n)%index = body
            columns(n)%component = j
         end do
      end do
   end subroutine put_states

   !> Begin the next column. (A structure constructor would leak its texts.)
   subroutine put(columns, n, name, units, long_name, is_integer)
      type(result_column_type), intent(inout) :: columns(:)
      !> Number of columns so far.
      integer, intent(inout) :: n
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: units
      character(len=*), intent(in) :: long_name
      !> Whether it is a count.
      logical, intent(in) :: is_integer

      n = n + 1
      columns(n)%name = trim(name)
      columns(n)%units = trim(units)
      columns(n)%long_name = long_name
      columns(n)%is_integer = is_integer
   end subroutine put

   !> Names of the conditions that end a run, with their numbers.
   function names_of_stops(scene) result(names)
      type(scene_type), intent(in) :: scene
      character(len=:), allocatable :: names
      integer :: stop

      names = ""
      do stop = 1, size(scene%stops)
         names = names // ", " // to_text(stop) // " for " // scene%stops(stop)%name
      end do
   end function names_of_stops

   !> Contacts and bodies whose columns would have the same name; the first pair is told.
   subroutine check_names(named, scene, main, diagnostics)
      type(result_column_type), intent(in) :: named(:)
      type(scene_type), intent(in) :: scene
      !> Group `sweep`.
      type(group_settings_type), intent(in) :: main
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: a, b

      do b = 2, size(named)
         do a = 1, b - 1
            if (named(a)%name /= named(b)%name) cycle
            call diagnostics%add(main%place("keep"), owner(named(a), scene) // " and " // &
               owner(named(b), scene) // " would have the same column " // quote(named(b)%name), &
               "another name for one of them, which differs by more than '/' and '_'")
            return
         end do
      end do
   end subroutine check_names

   !> What a column is of.
   function owner(column, scene) result(words)
      type(result_column_type), intent(in) :: column
      type(scene_type), intent(in) :: scene
      character(len=:), allocatable :: words

      if (column%source == source_event) then
         words = "contact " // quote(scene%contacts(column%index)%name)
      else
         words = "body " // quote(scene%bodies(column%index)%name)
      end if
   end function owner

   !> See that values at a time that have a name of their own have it alone.
   subroutine check_value_names(groups, columns, diagnostics)
      type(group_settings_type), intent(in) :: groups(:)
      type(result_column_type), intent(in) :: columns(:)
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i, j, k

      k = 0
      do i = 1, size(columns)
         if (columns(i)%source /= source_value) cycle
         do k = k + 1, size(groups)
            if (groups(k)%group_name() == "value") exit
         end do
         if (.not. groups(k)%is_set("name")) cycle
         if (any([(columns(j)%name == columns(i)%name, j=1, i - 1)])) call diagnostics%add( &
            groups(k)%place("name", 1), &
            "two results have the name " // quote(columns(i)%name), "another name")
      end do
   end subroutine check_value_names

   !> Which results are kept, beside values at a time.
   subroutine read_keep(main, keep_summary, keep_events, keep_state, diagnostics)
      !> Group `sweep`.
      type(group_settings_type), intent(in) :: main
      !> For each of `summary_quantities`, `event_names` and `final_quantities`, whether it is kept.
      logical, intent(out) :: keep_summary(:), keep_events(:), keep_state(:)
      type(diagnostics_type), intent(inout) :: diagnostics
      type(string_type), allocatable :: known(:)
      type(quantity_type), allocatable :: finals(:)
      character(len=:), allocatable :: word, right
      integer :: i, k

      keep_summary = .false.
      keep_events = .false.
      keep_state = .false.
      if (.not. main%is_set("keep")) return
      finals = final_quantities()
      known = strings([character(len=len(finals%name)) :: keep_names, summary_quantities%name, &
         event_names, finals%name])
      do i = 1, main%count("keep")
         word = lower(main%text("keep", i))
         keep_summary = keep_summary .or. word == "summary" .or. summary_quantities%name == word
         keep_events = keep_events .or. word == "events" .or. event_names == word
         keep_state = keep_state .or. word == "final_state" .or. finals%name == word
         if (any([(known(k)%s == word, k=1, size(known))])) cycle
         if (word == "cpu_s") then
            call diagnostics%add(main%place("keep", i), &
               "CPU time is not the same twice and cannot be kept")
            cycle
         end if
         right = "one of " // join(known, ", ")
         k = nearest(word, known)
         if (k > 0) right = quote(known(k)%s)
         call diagnostics%add(main%place("keep", i), "unknown result " // quote(word), right)
      end do
   end subroutine read_keep

   !> A part of the name of a column.
   pure function column_word(name) result(word)
      !> Name of a body or contact.
      character(len=*), intent(in) :: name
      character(len=:), allocatable :: word
      integer :: i

      word = name
      do i = 1, len(word)
         if (word(i:i) == "/") word(i:i) = "_"
      end do
   end function column_word

   !> Name of a component.
   pure function component_word(n, component) result(word)
      !> Number of components: 3 for a vector, 4 for a quaternion.
      integer, intent(in) :: n
      !> Which one.
      integer, intent(in) :: component
      character(len=1) :: word
      character(len=*), parameter :: letters = "wxyz"

      word = letters(component + 4 - n:component + 4 - n)
   end function component_word

   !> A value of the trajectory at a time.
   subroutine read_value(group, sweep, column, diagnostics)
      !> Group `value`.
      type(group_settings_type), intent(in) :: group
      !> The sweep, with its base scene.
      type(sweep_type), intent(in) :: sweep
      type(result_column_type), intent(out) :: column
      type(diagnostics_type), intent(inout) :: diagnostics
      type(quantity_type) :: quantity
      type(quantity_type), allocatable :: quantities(:)
      integer :: i, near, components
      logical :: varies

      column%source = source_value
      column%name = group%text("name")
      if (group%is_set("name")) call check_column(column%name, &
         group%place("name", 1), diagnostics)
      column%time = group%number("time")
      varies = .false.
      do i = 1, size(sweep%parameters)
         varies = varies .or. any([(sweep%parameters(i)%paths(near)%s == "scene.t_end", &
            near=1, size(sweep%parameters(i)%paths))])
      end do
      if (column%time > sweep%scene%t_end .and. .not. varies) call diagnostics%add( &
         group%place("time", 1), "'time' is beyond the end of the runs", &
         "at most scene.t_end, " // to_text(sweep%scene%t_end) // " [s]")
      column%quantity = group%choice("dataset")
      column%units = ""
      column%long_name = ""
      if (column%quantity == 0) return
      ! The first quantity of a row is the time, which is no choice.
      column%quantity = column%quantity + 1
      quantities = row_quantities()
      quantity = quantities(column%quantity)
      components = quantity%components
      column%units = trim(quantity%units)
      column%long_name = trim(quantity%name)
      if (quantity%there == if_driven .and. &
         .not. any(turns_by_drive(sweep%scene%bodies%motion))) call diagnostics%add( &
         group%place("dataset", 1), "no body of the scene is driven", &
         "a body with another motion")
      if (quantity%there == if_memory .and. .not. any([(remembers(sweep%scene%contacts(i) &
         %tangential), i=1, size(sweep%scene%contacts))])) call diagnostics%add( &
         group%place("dataset", 1), &
         "no contact of the scene has tangential elasticity", "tangential = 'elastic'")
      if (quantity%there == if_springs .and. size(sweep%scene%springs) == 0) call diagnostics%add( &
         group%place("dataset", 1), "the scene has no springs", "a group &spring")
      if (quantity%there == if_states) then
         if (.not. any([(owns_state([sweep%scene%contacts(i)%normal, &
            sweep%scene%contacts(i)%damping, sweep%scene%contacts(i)%friction, &
            sweep%scene%contacts(i)%rolling, sweep%scene%contacts(i)%tangential, &
            sweep%scene%contacts(i)%curvature], sweep%scene%contacts(i)%parameters, &
            quantity%name), &
            i=1, size(sweep%scene%contacts))])) call diagnostics%add( &
            group%place("dataset", 1), "no contact of the scene has such a state", &
            "a contact with a law that has it")
      end if
      if (group%is_set("component")) column%component = group%integer("component")
      if (components == 1) then
         call group%refuse("component", "'component' has no meaning for " // &
            trim(quantity%name) // ", which is a scalar", "no component", diagnostics)
      else
         call group%require("component", group%origin, "'component' is missing for " // &
            trim(quantity%name), "component = 1 to " // to_text(components), diagnostics)
         if (column%component > components) call diagnostics%add(group%place("component", 1), &
            "'component' is out of range", "1 to " // to_text(components))
      end if
      call read_owner(group, sweep, quantity, column, diagnostics)
      if (components > 1) column%long_name = column%long_name // ", component " // &
         to_text(column%component)
      column%long_name = column%long_name // ", at " // to_text(column%time) // " s"
   end subroutine read_value

   !> Body, contact or spring that a value belongs to.
   subroutine read_owner(group, sweep, quantity, column, diagnostics)
      !> Group `value`.
      type(group_settings_type), intent(in) :: group
      !> The sweep, with its base scene.
      type(sweep_type), intent(in) :: sweep
      type(quantity_type), intent(in) :: quantity
      type(result_column_type), intent(inout) :: column
      type(diagnostics_type), intent(inout) :: diagnostics
      type(string_type), allocatable :: names(:)
      character(len=:), allocatable :: kind, wanted, right
      integer :: i, near

      select case (quantity%owner())
      case ("")
         call group%refuse("of", "'of' has no meaning for " // trim(quantity%name) // &
            ", which belongs to the whole scene", "no of", diagnostics)
         return
      case ("body")
         kind = "body"
         allocate(names(size(sweep%scene%bodies)))
         do i = 1, size(names)
            names(i)%s = sweep%scene%bodies(i)%name
         end do
      case ("spring")
         kind = "spring"
         allocate(names(0))
         if (allocated(sweep%scene%springs)) then
            deallocate(names)
            allocate(names(size(sweep%scene%springs)))
         end if
         do i = 1, size(names)
            names(i)%s = sweep%scene%springs(i)%name
         end do
      case default
         kind = "contact"
         allocate(names(size(sweep%scene%contacts)))
         do i = 1, size(names)
            names(i)%s = sweep%scene%contacts(i)%name
         end do
      end select
      if (group%is_set("of")) then
         wanted = group%text("of")
         do i = 1, size(names)
            if (lower(names(i)%s) == lower(wanted)) column%index = i
         end do
         if (column%index == 0) then
            right = "one of " // join(names, ", ")
            near = nearest(wanted, names)
            if (near > 0) right = quote(names(near)%s)
            call diagnostics%add(group%place("of", 1), "there is no " // kind // " " // &
               quote(wanted), right)
         end if
      else if (.not. group%is_given("of") .and. size(names) == 1) then
         column%index = 1
      else
         call group%require("of", group%origin, "'of' is missing for " // trim(quantity%name), &
            "of = the name of a " // kind, diagnostics)
      end if
      if (column%index > 0) column%long_name = column%long_name // " of " // &
         names(column%index)%s
   end subroutine read_owner

   !> A name of a column has to be one of a data set, too.
   subroutine check_column(name, origin, diagnostics)
      character(len=*), intent(in) :: name
      type(origin_type), intent(in) :: origin
      type(diagnostics_type), intent(inout) :: diagnostics

      if (index(name, "/") > 0 .or. name == "." .or. name == "..") then
         call diagnostics%add(origin, quote(name) // " cannot be the name of a column", &
            "a name without '/'")
      else if (any(name == [character(len=7) :: "case", "status", "message"])) then
         call diagnostics%add(origin, quote(name) // " cannot be the name of a column", &
            "another name: each table has a column " // name)
      end if
   end subroutine check_column

end module contensou_sweep_results
