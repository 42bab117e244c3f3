!> From a sweep file to a sweep: its base scene, parameters, table of cases and results, with all
!> mistakes reported at once.
module contensou_sweep_reader
   use contensou_base_build, only : program_version
   use contensou_base_constants, only : expression_value, take_constants
   use contensou_base_diagnostics, only : diagnostics_type, origin_type, source_type
   use contensou_base_document, only : constants_group, document_type, read_document, value_real, &
      value_text, value_type
   use contensou_base_document_types, only : append_source
   use contensou_base_errors, only : error_type, fatal, status_usage
   use contensou_base_expressions, only : constants_type
   use contensou_base_kinds, only : i8, wp
   use contensou_base_numbers, only : to_text
   use contensou_base_resolve, only : expected_of, refuse_other_kind, resolve
   use contensou_base_schema, only : key_type, kind_integer, schema_type
   use contensou_base_settings, only : group_settings_type, settings_type
   use contensou_base_text, only : join, lower, quote, starts_with, string_type
   use contensou_scene_reader, only : load_scene, loaded_scene_type, mistakes_text
   use contensou_scene_overrides, only : apply_override, index_groups, index_type
   use contensou_sweep_plan, only : parameter_column_type, sweep_type
   use contensou_sweep_points, only : logical_of, points_column_type
   use contensou_sweep_results, only : check_column, read_results
   use contensou_sweep_sampling, only : hash_text, hash_values, sampling_file, sampling_grid, &
      sampling_latin, sampling_names, sampling_sobol, sobol_bits, sobol_most_dimensions
   use contensou_sweep_schema, only : most_cases, sweep_schema, vary_linear, vary_list, vary_log, &
      vary_names
   use contensou_sweep_target, only : find_target, target_type, value_words
   implicit none(type, external)
   private

   public :: read_sweep, is_sweep_file, is_scene_file

contains

   !> Whether a file has a group `sweep` and no group `scene`; false for one that cannot be read.
   logical function is_sweep_file(path)
      character(len=*), intent(in) :: path
      type(document_type) :: document
      type(schema_type) :: schema
      type(diagnostics_type) :: ignored
      type(error_type), allocatable :: error
      integer :: i

      call read_document(path, document, ignored, error)
      is_sweep_file = .false.
      if (allocated(error)) return
      call sweep_schema(schema)
      do i = 1, document%n_groups
         if (document%groups(i)%name == "scene") then
            is_sweep_file = .false.
            return
         end if
         is_sweep_file = is_sweep_file .or. (schema%find(document%groups(i)%name) > 0 .and. &
            document%groups(i)%name /= constants_group)
      end do
   end function is_sweep_file

   !> Whether a file is a namelist with a group `scene`; false for one that cannot be read, and for
   !> a table that holds the text of its scene.
   logical function is_scene_file(path)
      character(len=*), intent(in) :: path
      type(document_type) :: document
      type(diagnostics_type) :: ignored
      type(error_type), allocatable :: error
      integer :: i

      is_scene_file = .false.
      call read_document(path, document, ignored, error)
      if (allocated(error)) return
      do i = 1, document%n_groups
         is_scene_file = is_scene_file .or. document%groups(i)%name == "scene"
      end do
      is_scene_file = is_scene_file .and. ignored%count() == 0
   end function is_scene_file

   !> Whether the text of a `--set` option is about the sweep, not its scene.
   pure logical function concerns_sweep(override)
      !> Text after `--set`.
      character(len=*), intent(in) :: override

      concerns_sweep = starts_with(lower(adjustl(override)), "sweep.")
   end function concerns_sweep

   !> Read a sweep file and its base scene; all mistakes are reported at once.
   subroutine read_sweep(path, overrides, output, sweep, error)
      !> Name of the sweep file.
      character(len=*), intent(in) :: path
      !> Texts of the `--set` options: settings of the scene for all cases, or `sweep.KEY`.
      type(string_type), intent(in) :: overrides(:)
      !> Name of the table from the command line; blank for that of the sweep file.
      character(len=*), intent(in) :: output
      type(sweep_type), intent(out) :: sweep
      !> Set with all mistakes found; nothing of `sweep` is to be used then.
      type(error_type), allocatable, intent(out) :: error
      type(document_type) :: document
      type(diagnostics_type) :: diagnostics, in_scene
      type(group_settings_type), allocatable :: groups(:)
      type(source_type), allocatable :: scene_sources(:)
      type(schema_type), target :: schema
      type(settings_type), target :: settings
      type(index_type) :: index_of
      logical :: refused, scene_good
      integer :: i, head

      call read_document(path, document, diagnostics, error)
      if (allocated(error)) return
      call refuse_other_kind(document, "sweep", "scene", "this is a scene, not a sweep", &
         "contensou run " // path // ", or a file with a group &sweep whose key 'scene' names it", &
         diagnostics, refused)
      if (refused) then
         call fatal(error, mistakes_text(diagnostics, document, path), status_usage)
         return
      end if
      sweep%path = path
      sweep%text = document%bytes
      call sweep_schema(schema)
      call index_groups(document, schema, index_of)
      do i = 1, size(overrides)
         if (concerns_sweep(overrides(i)%s)) call apply_override(document, schema, index_of, &
            overrides(i)%s, diagnostics)
      end do
      call take_constants(document, diagnostics)
      call resolve(document, schema, settings, diagnostics)
      allocate(groups(size(settings%groups)))
      head = 0
      do i = 1, size(groups)
         groups(i) = settings%group(i, schema)
         if (groups(i)%group_name() == "sweep") head = i
      end do
      allocate(sweep%trajectories(0), sweep%parameters(0), sweep%results(0))
      if (head > 0) then
         associate (main => groups(head))
            call read_output(main, path, output, sweep, diagnostics)
            call read_base(main, overrides, sweep, scene_good, diagnostics, in_scene, scene_sources)
            sweep%sampling = max(1, main%choice("sampling"))
            if (sweep%sampling == sampling_file) then
               call check_keys(main, groups, sweep%sampling, diagnostics)
               if (scene_good) call read_table(main, groups, sweep, document, diagnostics)
            else
               call check_keys(main, groups, sweep%sampling, diagnostics)
               call read_parameters(main, groups, document%constants, sweep, scene_good, &
                  diagnostics)
            end if
            if (scene_good) then
               call check_parameters(main, groups, sweep, diagnostics)
               call read_results(main, groups, sweep, diagnostics)
               call check_columns(main, groups, sweep, diagnostics)
            end if
            call read_trajectories(main, sweep, diagnostics)
            if (main%number("time_limit") > 0.0_wp) sweep%time_limit = main%number("time_limit")
         end associate
      end if
      if (.not. allocated(scene_sources)) allocate(scene_sources(0))
      call report_all(path, diagnostics, in_scene, document%sources, scene_sources, error)
      if (allocated(error)) return
      sweep%settings = decisive(settings%text(schema))
      call set_fingerprint(sweep)
   end subroutine read_sweep

   !> Make an error of the mistakes in the sweep and in its scene, if there are some.
   subroutine report_all(path, diagnostics, in_scene, sources, scene_sources, error)
      !> Name of the sweep file.
      character(len=*), intent(in) :: path
      !> Mistakes in the sweep and in its scene.
      type(diagnostics_type), intent(in) :: diagnostics, in_scene
      !> Texts that these are in.
      type(source_type), intent(in) :: sources(:)
      type(source_type), intent(in) :: scene_sources(:)
      type(error_type), allocatable, intent(out) :: error
      character(len=:), allocatable :: text, count_text
      integer :: n

      n = diagnostics%count() + in_scene%count()
      if (n == 0) return
      text = diagnostics%render(sources)
      if (in_scene%count() > 0) text = text // in_scene%render(scene_sources)
      count_text = to_text(n) // " errors"
      if (n == 1) count_text = "1 error"
      call fatal(error, text // count_text // " in " // path // "; nothing was run", &
         status_usage)
   end subroutine report_all

   !> Name of the table.
   subroutine read_output(main, path, output, sweep, diagnostics)
      !> Group `sweep`.
      type(group_settings_type), intent(in) :: main
      !> Name of the sweep file.
      character(len=*), intent(in) :: path
      !> Name of the table from the command line; blank for none.
      character(len=*), intent(in) :: output
      type(sweep_type), intent(inout) :: sweep
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: slash, dot

      sweep%output = main%text("output")
      if (output /= "") sweep%output = output
      if (sweep%output == "") then
         slash = index(path, "/", back=.true.)
         dot = index(path, ".", back=.true.)
         if (dot <= slash + 1) dot = len(path) + 1
         sweep%output = path(slash + 1:dot - 1) // ".h5"
      end if
      if (sweep%output == path) call diagnostics%add(main%place("output"), &
         "the table would replace the sweep file", "output = 'NAME.h5'")
   end subroutine read_output

   !> Read the base scene with the settings for all cases.
   subroutine read_base(main, overrides, sweep, good, diagnostics, in_scene, scene_sources)
      !> Group `sweep`.
      type(group_settings_type), intent(in) :: main
      !> Texts of the `--set` options.
      type(string_type), intent(in) :: overrides(:)
      type(sweep_type), intent(inout) :: sweep
      !> Whether there is a scene to look paths up in.
      logical, intent(out) :: good
      !> Mistakes of the sweep file are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics
      !> Mistakes of the scene.
      type(diagnostics_type), intent(inout) :: in_scene
      type(source_type), allocatable, intent(out) :: scene_sources(:)
      type(diagnostics_type) :: found
      type(error_type), allocatable :: error
      type(origin_type) :: origin
      integer :: i, k, n, n_set
      logical :: ours

      good = .false.
      allocate(scene_sources(0))
      n_set = 0
      if (main%is_set("set")) n_set = main%count("set")
      allocate(sweep%overrides(n_set + count([(.not. concerns_sweep(overrides(i)%s), &
         i=1, size(overrides))])))
      do i = 1, n_set
         sweep%overrides(i)%s = main%text("set", i)
      end do
      n = n_set
      do i = 1, size(overrides)
         if (concerns_sweep(overrides(i)%s)) cycle
         n = n + 1
         sweep%overrides(n)%s = overrides(i)%s
      end do
      if (.not. main%is_set("scene")) return
      sweep%scene_path = beside(sweep%path, main%text("scene"))
      call load_scene(sweep%scene_path, sweep%overrides, sweep%base, found, error)
      if (allocated(error)) then
         call diagnostics%add(main%place("scene", 1), error%message, "the file of a scene")
         return
      end if
      do i = 1, found%kept()
         origin = found%origin(i)
         ours = .false.
         do k = 1, n_set
            if (origin%source < 1) exit
            ours = sweep%base%document%sources(origin%source)%name == "--set " // &
               sweep%overrides(k)%s
            if (ours) exit
         end do
         if (ours) then
            call diagnostics%add(main%place("set", k), "in " // quote(sweep%overrides(k)%s) // &
               ": " // found%message(i), found%expected(i))
         else
            call in_scene%add(origin, found%message(i), found%expected(i))
         end if
      end do
      good = found%count() == 0
      scene_sources = sweep%base%document%sources
      if (.not. good .and. size(sweep%overrides) > 0) then
         ! Without the settings, so that mistakes in paths are found, too.
         found = diagnostics_type()
         call load_scene(sweep%scene_path, sweep%overrides(:0), sweep%base, found, error)
         good = found%count() == 0 .and. .not. allocated(error)
      end if
      if (.not. good) return
      sweep%scene = sweep%base%file%scene
      sweep%scene_text = sweep%base%file%text
      sweep%scene_resolved = sweep%base%file%resolved
   end subroutine read_base

   !> Name of a file that is given relative to the folder of another one.
   pure function beside(path, name) result(whole)
      !> The other file.
      character(len=*), intent(in) :: path
      !> Name as given.
      character(len=*), intent(in) :: name
      character(len=:), allocatable :: whole

      whole = name
      if (.not. starts_with(name, "/")) whole = path(:index(path, "/", back=.true.)) // name
   end function beside

   !> Keys that go with some samplings only.
   subroutine check_keys(main, groups, sampling, diagnostics)
      !> Group `sweep`.
      type(group_settings_type), intent(in) :: main
      type(group_settings_type), intent(in) :: groups(:)
      integer, intent(in) :: sampling
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i

      if (main%is_given("sampling") .and. .not. main%is_set("sampling")) return
      if (all(sampling /= [sampling_latin, sampling_sobol])) then
         call refuse(main, "cases", "the number of cases follows from the parameters")
         call refuse(main, "seed", "there is nothing at random")
      else
         call main%require("cases", main%origin, "'cases' is missing for sampling = '" // &
            trim(sampling_names(sampling)) // "'", "cases = a whole number >= 1", diagnostics)
      end if
      if (sampling /= sampling_file) then
         call refuse(main, "table", "sampling = 'file'")
      else
         call main%require("table", main%origin, "'table' is missing for sampling = 'file'", &
            "table = 'FILE'", diagnostics)
      end if
      do i = 1, size(groups)
         if (groups(i)%group_name() /= "parameter") cycle
         if (sampling /= sampling_grid) call refuse(groups(i), "count", &
            "the number of cases is given in another way")
         if (sampling == sampling_file) then
            call refuse(groups(i), "vary", "the values are those of the table")
            call refuse(groups(i), "values", "the values are those of the table")
            call refuse(groups(i), "first", "the values are those of the table")
            call refuse(groups(i), "last", "the values are those of the table")
         end if
      end do

   contains

      !> A key that has no meaning for the sampling.
      subroutine refuse(group, name, expected)
         type(group_settings_type), intent(in) :: group
         !> The key.
         character(len=*), intent(in) :: name
         character(len=*), intent(in) :: expected

         call group%refuse(name, "'" // name // "' has no meaning for sampling = '" // &
            trim(sampling_names(sampling)) // "'", expected, diagnostics)
      end subroutine refuse

   end subroutine check_keys

   !> Read the parameters of a grid, a Latin hypercube or a Sobol sequence.
   subroutine read_parameters(main, groups, constants, sweep, scene_good, diagnostics)
      !> Group `sweep`.
      type(group_settings_type), intent(in) :: main
      type(group_settings_type), intent(in) :: groups(:)
      !> Constants of the sweep file.
      type(constants_type), intent(in) :: constants
      type(sweep_type), intent(inout) :: sweep
      !> Whether the base scene is in order, so that paths can be looked up.
      logical, intent(in) :: scene_good
      type(diagnostics_type), intent(inout) :: diagnostics
      real(wp) :: product
      integer :: i, n, before
      logical :: shifted

      before = diagnostics%count()
      n = count([(groups(i)%group_name() == "parameter", i=1, size(groups))])
      if (n == 0) then
         if (main%complete .and. before == 0) call diagnostics%add(main%origin, &
            "there is no group &parameter", "&parameter name = 'PATH', ... /: what varies")
         return
      end if
      deallocate(sweep%parameters)
      allocate(sweep%parameters(n))
      n = 0
      do i = 1, size(groups)
         if (groups(i)%group_name() /= "parameter") cycle
         n = n + 1
         associate (parameter => sweep%parameters(n))
            call name_column(groups(i), parameter, diagnostics)
            call find_targets(groups(i), sweep%base, scene_good, parameter, diagnostics)
            call read_range(groups(i), sweep%sampling, constants, parameter, diagnostics)
         end associate
      end do
      if (sweep%sampling == sampling_grid) then
         product = 1.0_wp
         do i = 1, n
            product = product*real(sweep%parameters(i)%count, wp)
         end do
         if (product > most_cases) then
            call diagnostics%add(main%origin, "the grid has " // to_text(product) // " cases", &
               "at most " // to_text(int(most_cases, i8)) // " cases")
         else
            sweep%n_cases = nint(product, i8)
         end if
         return
      end if
      sweep%n_cases = main%long_integer("cases")
      sweep%sampler%sampling = sweep%sampling
      sweep%sampler%n = sweep%n_cases
      sweep%sampler%seed = main%long_integer("seed")
      shifted = main%is_set("seed")
      if (.not. shifted) sweep%sampler%seed = 1
      if (sweep%sampling == sampling_sobol) then
         if (n > sobol_most_dimensions) then
            call diagnostics%add(main%place("sampling"), &
               "a Sobol sequence has at most " // to_text(sobol_most_dimensions) // &
               " parameters, here are " // to_text(n), "sampling = 'latin_hypercube'")
            return
         end if
         if (sweep%n_cases >= shiftl(1_i8, sobol_bits)) then
            call diagnostics%add(main%place("cases"), &
               "a Sobol sequence has less than 2^" // to_text(sobol_bits) // " points", &
               "sampling = 'latin_hypercube', or fewer cases")
            return
         end if
      end if
      if (diagnostics%count() > before .or. sweep%n_cases < 1) return
      call sweep%sampler%begin(n, shifted)
   end subroutine read_parameters

   !> Name the column of a parameter in the table: as it is said, or else as what it sets.
   subroutine name_column(group, parameter, diagnostics)
      !> Group `parameter`.
      type(group_settings_type), intent(in) :: group
      type(parameter_column_type), intent(inout) :: parameter
      type(diagnostics_type), intent(inout) :: diagnostics

      parameter%name = group%text("column")
      if (parameter%name == "") then
         parameter%name = lower(group%text("name"))
      else
         call check_column(parameter%name, group%place("column", 1), &
            diagnostics)
      end if
      allocate(parameter%list(0))
      parameter%units = ""
      parameter%long_name = ""
   end subroutine name_column

   !> Find what the paths of a parameter stand for.
   subroutine find_targets(group, base, scene_good, parameter, diagnostics)
      !> Group `parameter`.
      type(group_settings_type), intent(in) :: group
      type(loaded_scene_type), intent(in) :: base
      !> Whether it is in order.
      logical, intent(in) :: scene_good
      type(parameter_column_type), intent(inout) :: parameter
      type(diagnostics_type), intent(inout) :: diagnostics
      type(target_type), allocatable :: targets(:)
      integer :: i
      logical :: found, all_found

      allocate(parameter%targets(0), parameter%paths(0))
      if (.not. group%is_set("name") .or. .not. scene_good) return
      allocate(targets(group%count("name")))
      all_found = .true.
      do i = 1, size(targets)
         call find_target(base, group%text("name", i), group%place("name", i), targets(i), &
            found, diagnostics)
         all_found = all_found .and. found
      end do
      if (.not. all_found) return
      do i = 2, size(targets)
         if (targets(i)%is_text() .neqv. targets(1)%is_text()) then
            call diagnostics%add(group%place("name", i), "'" // targets(i)%path // &
               "' cannot have the same value as '" // targets(1)%path // &
               "': one is a number, the other a text", "a group &parameter for each")
            return
         else if (targets(i)%key%unit /= targets(1)%key%unit) then
            call diagnostics%add(group%place("name", i), "'" // targets(i)%path // &
               "' cannot have the same value as '" // targets(1)%path // "': their units are " &
               // unit_words(targets(i)%key) // " and " // unit_words(targets(1)%key), &
               "a group &parameter for each")
            return
         end if
      end do
      call take_targets(parameter, targets)
   end subroutine find_targets

   pure function unit_words(key) result(text)
      type(key_type), intent(in) :: key
      character(len=:), allocatable :: text

      text = trim(key%unit)
      if (text == "1" .or. text == "") text = "-"
      if (text == "model") text = "those of the law"
   end function unit_words

   !> Give a parameter what takes its values.
   subroutine take_targets(parameter, targets)
      type(parameter_column_type), intent(inout) :: parameter
      type(target_type), intent(in) :: targets(:)
      integer :: i

      parameter%targets = targets
      if (allocated(parameter%paths)) deallocate(parameter%paths)
      allocate(parameter%paths(size(targets)))
      do i = 1, size(targets)
         parameter%paths(i)%s = targets(i)%path
      end do
      parameter%is_text = targets(1)%is_text()
      parameter%is_whole = any(targets%key%kind == kind_integer)
      parameter%units = trim(targets(1)%key%unit)
      if (parameter%units == "model") parameter%units = ""
      parameter%long_name = join(parameter%paths, ", ")
   end subroutine take_targets

   !> How a parameter varies.
   subroutine read_range(group, sampling, constants, parameter, diagnostics)
      !> Group `parameter`.
      type(group_settings_type), intent(in) :: group
      integer, intent(in) :: sampling
      !> Constants of the sweep file.
      type(constants_type), intent(in) :: constants
      type(parameter_column_type), intent(inout) :: parameter
      type(diagnostics_type), intent(inout) :: diagnostics
      character(len=*), parameter :: of_range(*) = [character(len=5) :: "first", "last", "count"]
      integer :: i

      parameter%vary = group%choice("vary")
      if (parameter%vary == 0) then
         if (group%is_given("vary")) return
         parameter%vary = vary_linear
         if (group%is_given("values") .or. group%is_misspelt("values")) parameter%vary = vary_list
      end if
      if (parameter%vary == vary_list) then
         do i = 1, size(of_range)
            if (sampling == sampling_grid .or. i < 3) call group%refuse(trim(of_range(i)), &
               "'" // trim(of_range(i)) // "' has no meaning for a list", &
               "vary = 'linear' or 'log', or values alone", diagnostics)
         end do
         call group%require("values", group%place("vary"), &
            "'values' is missing for vary = 'list'", "values = V1, V2, ...", diagnostics)
         if (.not. group%is_set("values")) return
         parameter%list = group%values("values")
         if (size(parameter%targets) > 0 .and. .not. parameter%is_text) call compute_values( &
            parameter%list, constants, diagnostics)
         parameter%count = size(parameter%list)
         call check_values(parameter, parameter%list, diagnostics)
         return
      end if
      if (group%is_given("values")) then
         call group%refuse("values", "'values' has no meaning for vary = '" // &
            trim(vary_names(parameter%vary)) // "'", "vary = 'list', or first and last", &
            diagnostics)
         return
      end if
      if (size(parameter%targets) > 0 .and. parameter%is_text) then
         call diagnostics%add(group%place("name", 1), &
            "the values of '" // parameter%paths(1)%s // "' are no numbers", &
            "values = V1, V2, ...")
         return
      end if
      call need(group, "first", parameter, diagnostics)
      call need(group, "last", parameter, diagnostics)
      if (sampling == sampling_grid) call need(group, "count", parameter, diagnostics)
      if (group%is_set("count")) parameter%count = group%long_integer("count")
      if (.not. group%is_set("first") .or. .not. group%is_set("last")) return
      parameter%first = group%number("first")
      parameter%last = group%number("last")
      call check_end(group, "first", parameter, diagnostics)
      call check_end(group, "last", parameter, diagnostics)
      if (abs(parameter%last - parameter%first) <= 0.0_wp) then
         if (sampling /= sampling_grid .or. parameter%count > 1) call diagnostics%add( &
            group%place("last", 1), "'last' is the same as 'first'", "two numbers")
      else if (group%is_set("count") .and. sampling == sampling_grid .and. &
         parameter%count == 1) then
         call diagnostics%add(group%place("count", 1), &
            "one value cannot be both 'first' and 'last'", "count >= 2, or values = V")
      else if (parameter%is_whole .and. .not. steps_are_whole(sampling, parameter)) then
         call diagnostics%add(group%place("first", 1), "'" // parameter%paths(1)%s // &
            "' is a whole number, and what is between 'first' and 'last' is not", &
            "values = V1, V2, ...")
      end if
   end subroutine read_range

   !> Whether all values of a range between whole numbers are whole.
   pure logical function steps_are_whole(sampling, parameter)
      integer, intent(in) :: sampling
      type(parameter_column_type), intent(in) :: parameter

      steps_are_whole = sampling == sampling_grid .and. parameter%vary == vary_linear .and. &
         parameter%count > 1
      if (steps_are_whole) steps_are_whole = abs(modulo(parameter%last - parameter%first, &
         real(parameter%count - 1, wp))) <= 0.0_wp
   end function steps_are_whole

   !> Texts that stand for numbers are computed.
   subroutine compute_values(list, constants, diagnostics)
      type(value_type), intent(inout) :: list(:)
      !> Constants of the sweep file.
      type(constants_type), intent(in) :: constants
      type(diagnostics_type), intent(inout) :: diagnostics
      real(wp) :: x
      logical :: good, is_one
      integer :: k

      do k = 1, size(list)
         if (list(k)%kind /= value_text) cycle
         call expression_value(list(k), constants, x, is_one, diagnostics, good)
         if (.not. is_one) cycle
         list(k)%kind = value_real
         list(k)%real = x
      end do
   end subroutine compute_values

   !> A key that has to be there.
   subroutine need(group, name, parameter, diagnostics)
      !> Group `parameter`.
      type(group_settings_type), intent(in) :: group
      !> The key.
      character(len=*), intent(in) :: name
      type(parameter_column_type), intent(in) :: parameter
      type(diagnostics_type), intent(inout) :: diagnostics

      call group%require(name, group%origin, "'" // name // &
         "' is missing in group &parameter " // quote(parameter%name), &
         name // " = " // expected_of(group%key(name)), diagnostics)
   end subroutine need

   !> Check an end of the range; what no key takes is not said to have no logarithm, too.
   subroutine check_end(group, name, parameter, diagnostics)
      !> Group `parameter`.
      type(group_settings_type), intent(in) :: group
      !> Its key.
      character(len=*), intent(in) :: name
      type(parameter_column_type), intent(in) :: parameter
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: before

      before = diagnostics%count()
      call check_values(parameter, group%values(name), diagnostics)
      if (diagnostics%count() > before .or. parameter%vary /= vary_log) return
      if (group%number(name) <= 0.0_wp) call diagnostics%add(group%place(name, 1), "'" // &
         name // "' must be positive for vary = 'log'", "a number > 0")
   end subroutine check_end

   !> Check values against the domains of all keys that take them; texts become what the key wants.
   subroutine check_values(parameter, values, diagnostics)
      type(parameter_column_type), intent(in) :: parameter
      type(value_type), intent(in) :: values(:)
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i, k
      logical :: good

      do i = 1, size(values)
         do k = 1, size(parameter%targets)
            call parameter%targets(k)%check(values(i), diagnostics, good)
            if (.not. good) exit
         end do
      end do
   end subroutine check_values

   !> Read the table of cases.
   subroutine read_table(main, groups, sweep, document, diagnostics)
      !> Group `sweep`.
      type(group_settings_type), intent(in) :: main
      type(group_settings_type), intent(in) :: groups(:)
      type(sweep_type), intent(inout) :: sweep
      !> The table is added to its sources.
      type(document_type), intent(inout) :: document
      type(diagnostics_type), intent(inout) :: diagnostics
      type(points_column_type), allocatable :: columns(:)
      type(error_type), allocatable :: error
      type(source_type) :: lines
      type(target_type), allocatable :: target(:)
      integer :: i, g, n, n_found
      logical :: found, used(size(groups))

      if (.not. main%is_set("table")) return
      call sweep%points%open(beside(sweep%path, main%text("table")), error)
      if (allocated(error)) then
         call diagnostics%add(main%place("table", 1), error%message, &
            "a CSV or HDF5 file with a column for each parameter")
         return
      end if
      n = size(sweep%points%names)
      deallocate(sweep%parameters)
      allocate(sweep%parameters(n), columns(n))
      lines = sweep%points%header_source()
      call append_source(document, lines)
      sweep%points%places%source = document%n_sources
      used = .false.
      n_found = 0
      do i = 1, n
         associate (parameter => sweep%parameters(i), name => sweep%points%names(i)%s, &
            place => sweep%points%places(i))
            parameter%name = name
            allocate(parameter%list(0), parameter%targets(0), parameter%paths(0))
            parameter%units = ""
            g = group_of(groups, name)
            if (g > 0) then
               used(g) = .true.
               deallocate(parameter%targets, parameter%paths, parameter%list)
               call name_column(groups(g), parameter, diagnostics)
               call find_targets(groups(g), sweep%base, .true., parameter, diagnostics)
            else
               if (name == "") then
                  call diagnostics%add(place, "a column has no name", "the path of a parameter")
                  cycle
               end if
               if (allocated(target)) deallocate(target)
               allocate(target(1))
               call find_target(sweep%base, name, place, target(1), found, diagnostics)
               if (found) call take_targets(parameter, target)
            end if
            if (size(parameter%targets) == 0) cycle
            n_found = n_found + 1
            columns(i)%targets = parameter%targets
         end associate
      end do
      do g = 1, size(groups)
         if (groups(g)%group_name() /= "parameter" .or. used(g)) cycle
         call diagnostics%add(groups(g)%origin, "the table has no column for this parameter", &
            "a column " // quote(group_name(groups(g))) // " in " // sweep%points%path)
      end do
      if (n_found < n) return
      call sweep%points%read(columns, document%constants, document%n_sources, lines, diagnostics, &
         error)
      document%sources(document%n_sources) = lines
      if (allocated(error)) then
         call diagnostics%add(main%place("table", 1), error%message)
         return
      end if
      sweep%n_cases = sweep%points%n
      do i = 1, n
         sweep%parameters(i)%count = sweep%n_cases
         call take_words(columns(i)%words, sweep%parameters(i)%list)
      end do
   end subroutine read_table

   !> Values of a column from its words.
   subroutine take_words(words, list)
      type(string_type), intent(in) :: words(:)
      type(value_type), allocatable, intent(out) :: list(:)
      integer :: i

      allocate(list(size(words)))
      do i = 1, size(list)
         list(i)%kind = value_text
         list(i)%text = words(i)%s
         if (starts_with(list(i)%text, ".")) call logical_of(list(i)%text, list(i))
      end do
   end subroutine take_words

   !> Group `parameter` that names a column of the table; 0 for none.
   integer function group_of(groups, name)
      type(group_settings_type), intent(in) :: groups(:)
      !> Name of the column.
      character(len=*), intent(in) :: name
      integer :: k

      do group_of = 1, size(groups)
         if (groups(group_of)%group_name() /= "parameter") cycle
         if (groups(group_of)%text("column") == name) return
         if (.not. groups(group_of)%is_set("name")) cycle
         do k = 1, groups(group_of)%count("name")
            if (lower(groups(group_of)%text("name", k)) == lower(name)) return
         end do
      end do
      group_of = 0
   end function group_of

   !> Name of the column that a group wants.
   function group_name(group) result(name)
      type(group_settings_type), intent(in) :: group
      character(len=:), allocatable :: name

      name = group%text("column")
      if (name == "") name = group%text("name")
   end function group_name

   !> Parameters must not share a path or a column, nor vary what is set for all cases.
   subroutine check_parameters(main, groups, sweep, diagnostics)
      !> Group `sweep`.
      type(group_settings_type), intent(in) :: main
      type(group_settings_type), intent(in) :: groups(:)
      type(sweep_type), intent(inout) :: sweep
      type(diagnostics_type), intent(inout) :: diagnostics
      type(diagnostics_type) :: ignored
      type(target_type) :: other
      type(origin_type) :: origin
      integer :: i, j, k, l, n_set, equals, before
      logical :: found

      do i = 1, size(sweep%parameters)
         if (.not. allocated(sweep%parameters(i)%targets)) cycle
         do j = 1, i
            if (.not. allocated(sweep%parameters(j)%targets)) cycle
            before = diagnostics%count()
            do k = 1, size(sweep%parameters(i)%targets)
               do l = 1, merge(k - 1, size(sweep%parameters(j)%targets), i == j)
                  associate (a => sweep%parameters(i)%targets(k), &
                     b => sweep%parameters(j)%targets(l))
                     if (.not. a%overlaps(b)) cycle
                     if (a%path == b%path) then
                        call diagnostics%add(place_of(main, groups, sweep, i, k), "'" // a%path // &
                           "' is given by two parameters", "each path once")
                     else
                        call diagnostics%add(place_of(main, groups, sweep, i, k), "'" // a%path // &
                           "' sets what another parameter sets as '" // b%path // "'", &
                           "each setting once")
                     end if
                  end associate
               end do
            end do
            if (j < i .and. diagnostics%count() == before .and. &
               sweep%parameters(j)%name == sweep%parameters(i)%name) call diagnostics%add( &
               place_of(main, groups, sweep, i, 0), "two parameters have the column " // &
               quote(sweep%parameters(i)%name), "column = 'another name'")
         end do
         sweep%expands = sweep%expands .or. any(sweep%parameters(i)%targets%expands)
      end do
      ! A scene without templates is as it was read, but for what is set anyway.
      if (sweep%expands .and. .not. allocated(sweep%base%raw%groups)) then
         sweep%base%raw = sweep%base%document
      end if

      n_set = 0
      if (main%is_set("set")) n_set = main%count("set")
      do i = 1, size(sweep%overrides)
         equals = index(sweep%overrides(i)%s, "=")
         call find_target(sweep%base, sweep%overrides(i)%s(:equals - 1), origin_type(), other, &
            found, ignored)
         if (.not. found) cycle
         do j = 1, size(sweep%parameters)
            do k = 1, size(sweep%parameters(j)%targets)
               if (.not. other%overlaps(sweep%parameters(j)%targets(k))) cycle
               origin = place_of(main, groups, sweep, j, k)
               if (i <= n_set) origin = main%place("set", i)
               call diagnostics%add(origin, "'" // other%path // &
                  "' is set for all cases, and a parameter varies it", "one of the two")
            end do
         end do
      end do

   end subroutine check_parameters

   !> Where a path of a parameter stands; the name of its column for path 0.
   function place_of(main, groups, sweep, p, path) result(place)
      !> Group `sweep`.
      type(group_settings_type), intent(in) :: main
      type(group_settings_type), intent(in) :: groups(:)
      type(sweep_type), intent(in) :: sweep
      !> The parameter.
      integer, intent(in) :: p
      !> Which of its paths.
      integer, intent(in) :: path
      type(origin_type) :: place
      integer :: g, n

      place = main%origin
      if (sweep%sampling == sampling_file) then
         place = sweep%points%places(p)
         return
      end if
      n = 0
      do g = 1, size(groups)
         if (groups(g)%group_name() /= "parameter") cycle
         n = n + 1
         if (n < p) cycle
         place = groups(g)%origin
         if (groups(g)%is_set("name")) place = groups(g)%place("name", max(path, 1))
         if (path == 0 .and. groups(g)%is_set("column")) place = groups(g)%place("column", 1)
         return
      end do
   end function place_of

   !> Parameters must not share a column with a result.
   subroutine check_columns(main, groups, sweep, diagnostics)
      !> Group `sweep`.
      type(group_settings_type), intent(in) :: main
      type(group_settings_type), intent(in) :: groups(:)
      type(sweep_type), intent(in) :: sweep
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i, j

      do i = 1, size(sweep%results)
         do j = 1, size(sweep%parameters)
            if (sweep%parameters(j)%name == sweep%results(i)%name) call diagnostics%add( &
               place_of(main, groups, sweep, j, 0), "a parameter and a result have the column " // &
               quote(sweep%results(i)%name), "column = 'another name' for the parameter")
         end do
      end do
   end subroutine check_columns

   !> Cases of which the whole output file is kept.
   subroutine read_trajectories(main, sweep, diagnostics)
      !> Group `sweep`.
      type(group_settings_type), intent(in) :: main
      type(sweep_type), intent(inout) :: sweep
      type(diagnostics_type), intent(inout) :: diagnostics
      integer(i8), allocatable :: list(:)
      integer(i8) :: last
      integer :: i

      if (.not. main%is_set("trajectories")) return
      list = nint(main%vector("trajectories", main%count("trajectories")), i8)
      do i = 1, size(list)
         if (sweep%n_cases > 0 .and. list(i) > sweep%n_cases) call &
            diagnostics%add(main%place("trajectories", i), "there is no case " // &
            to_text(list(i)), "1 to " // to_text(sweep%n_cases))
      end do
      deallocate(sweep%trajectories)
      allocate(sweep%trajectories(0))
      last = 0
      do
         if (.not. any(list > last)) exit
         last = minval(list, mask=list > last)
         sweep%trajectories = [sweep%trajectories, last]
      end do
   end subroutine read_trajectories

   !> The settings of a sweep that its rows depend on.
   function decisive(settings) result(text)
      !> All settings, a line for each.
      character(len=*), intent(in) :: settings
      character(len=:), allocatable :: text, line
      character(len=*), parameter :: others(*) = [character(len=12) :: "scene", "output", "set", &
         "trajectories"]
      integer :: first, last

      text = ""
      first = 1
      do while (first <= len(settings))
         last = first + index(settings(first:), new_line("a")) - 1
         line = adjustl(settings(first:last))
         if (all(others /= line(:index(line // " = ", " = ") - 1))) text = text // &
            settings(first:last)
         first = last + 1
      end do
   end function decisive

   !> What tells this sweep from others.
   subroutine set_fingerprint(sweep)
      type(sweep_type), intent(inout) :: sweep
      character(len=:), allocatable :: text
      character(len=*), parameter :: nl = new_line("a")
      integer(i8) :: hash
      integer :: i, k

      text = program_version // nl // sweep%scene_resolved // nl // &
         trim(sampling_names(sweep%sampling)) // nl // to_text(sweep%n_cases) // nl // &
         to_text(sweep%sampler%seed) // nl // to_text(sweep%time_limit) // nl
      if (allocated(sweep%sampler%shift)) text = text // to_text(any(sweep%sampler%shift > 0.0_wp))
      do i = 1, size(sweep%parameters)
         associate (parameter => sweep%parameters(i))
            text = text // parameter%name // nl // parameter%long_name // nl // &
               to_text(parameter%vary) // nl // to_text(parameter%first) // nl // &
               to_text(parameter%last) // nl // to_text(parameter%count) // nl
            do k = 1, size(parameter%list)
               text = text // value_words(parameter%list(k)) // nl
            end do
         end associate
      end do
      do i = 1, size(sweep%results)
         associate (result => sweep%results(i))
            text = text // result%name // nl // result%long_name // nl // &
               to_text(result%source) // nl // to_text(result%quantity) // nl // &
               to_text(result%time) // nl
         end associate
      end do
      hash = hash_text(text)
      if (allocated(sweep%points%values)) hash = hash_values(hash, &
         sweep%points%values(:, :sweep%n_cases))
      write(sweep%fingerprint, "(z16.16)") hash
   end subroutine set_fingerprint

end module contensou_sweep_reader
