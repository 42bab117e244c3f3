!> `contensou cost`: what the accuracy of a scene costs, over models, methods and tolerances.
module contensou_drivers_cost
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite
   use contensou_base_errors, only : error_type, fatal, status_failed, status_interrupted, &
      status_usage
   use contensou_base_kinds, only : wp
   use contensou_base_operating_system, only : catch_signals, remove_file, rename_file, &
      signal_received, write_stdout
   use contensou_base_text, only : number_text, quote, string_type, to_text
   use contensou_contact_friction, only : friction_model_type, friction_models
   use contensou_contact_normal, only : normal_hertz, normal_model_type, normal_models
   use contensou_drivers_bench, only : check_output, write_text
   use contensou_drivers_command_line, only : command_line_type, command_text, command_type, &
      option_type, quiet_option, takes_positive
   use contensou_drivers_progress, only : progress_type
   use contensou_dynamics_scene, only : cost_measures, cost_quantities, scene_type
   use contensou_study_work_precision, only : kinds, outcome_done, outcome_failed, outcome_slow, &
      outcome_stopped, reference_distance, reference_scales, reference_type, run_reference, &
      run_trial, trial_type
   use contensou_files_cost_table, only : cheapest, csv_text, judge_runs, kind_names, kind_units, &
      model_type, outcome_names, run_type, scaled_error, study_type, write_hdf5
   use contensou_files_hdf5_file, only : hdf5_file_type
   use contensou_scene_reader, only : read_scene, scene_file_type
   use contensou_files_trajectory, only : part_suffix
   implicit none(type, external)
   private

   public :: cost_command

   !> What `contensou cost` takes.
   type(option_type), parameter :: options(*) = [ &
      option_type("SCENE", "", "namelist file", needs="a scene"), &
      option_type("--error", "E", "name the cheapest choice with an error of at most E", &
      needs="a number > 0 [-]", takes=takes_positive), &
      option_type("--output", "FILE", "write an HDF5 file, for scripts/plot", "-o", &
      "the name of a file"), &
      option_type("--csv", "FILE", "write the table", needs="the name of a file"), &
      option_type("--force", "", "replace existing files"), &
      quiet_option, &
      option_type("--set", "PATH=VALUE", "replace a value, as in run: --set cost.rtol=1e-4,1e-6", &
      repeats=.true.)]

   !> What the user asks for, in the words of the options; texts blank for nothing.
   type :: cost_config_type
      character(len=:), allocatable :: scene, output, csv
      type(string_type), allocatable :: overrides(:)
      logical :: force = .false., quiet = .false.
      !> 0 if no choice is asked for.
      real(wp) :: largest_error = 0.0_wp
   end type cost_config_type

   !> Methods of a reference, in the order in which they are tried: two must come to the end. Where
   !> a body comes to rest explicit8 may not; then `auto` is a second method up to there.
   character(len=11), parameter :: reference_methods(*) = [character(len=11) :: &
      "explicit8", "cvode_bdf", "cvode_adams", "auto"]

   !> Share of the time in which `auto` must have gone by another method than the reference to be
   !> its check [-].
   real(wp), parameter :: least_difference = 0.5_wp

   !> CPU time that the first method of a reference may take [s], and each further one in those of
   !> the first one that came to the end.
   real(wp), parameter :: reference_cpu = 600.0_wp, reference_factor = 40.0_wp

   !> Where only one method comes to the end, it is checked by itself at a larger tolerance.
   real(wp), parameter :: looser = 10.0_wp

   !> A run is not given up before this CPU time [s].
   real(wp), parameter :: least_limit = 1.0_wp

   !> Runs shorter than this are repeated [s].
   real(wp), parameter :: short = 1.0_wp

   !> Name of the exact friction model.
   character(len=*), parameter :: exact_friction = "contensou_exact"

   !> End of a line.
   character(len=*), parameter :: nl = new_line("a")

contains

   !> `contensou cost` in the table of commands.
   function cost_command() result(command)
      type(command_type) :: command

      command = command_type("cost", "errors and CPU times over models, methods, tolerances", &
         options, "runs the scene over models, methods and tolerances, those of its group " // &
         "&cost, and reports errors against CPU time", execute=report_cost)
   end function cost_command

   !> What a command line asks for.
   subroutine configure(line, config, error)
      type(command_line_type), intent(in) :: line
      type(cost_config_type), intent(out) :: config
      !> Set when options contradict each other.
      type(error_type), allocatable, intent(out) :: error

      config%scene = line%text("SCENE")
      config%overrides = line%texts("--set")
      config%output = line%text("--output")
      config%csv = line%text("--csv")
      config%force = line%has("--force")
      config%quiet = line%has("--quiet")
      config%largest_error = line%number("--error", config%largest_error)
      if (config%csv /= "" .and. config%csv == config%output) call fatal(error, &
         "-o and --csv name the same file", status_usage)
   end subroutine configure

   !> Run everything, print, and write files if they are asked for.
   subroutine report_cost(line, error)
      type(command_line_type), intent(in) :: line
      !> Set when there is a mistake, a file cannot be written, no run is accurate enough, or a
      !> signal came.
      type(error_type), allocatable, intent(out) :: error
      type(cost_config_type) :: config
      type(scene_file_type) :: file
      type(study_type) :: study
      type(reference_type), allocatable :: references(:)
      logical :: stopped

      call configure(line, config, error)
      if (allocated(error)) return
      call read_scene(config%scene, config%overrides, "", file, error)
      if (allocated(error)) return
      if (config%output /= "") call check_output(config%output, config%force, error)
      if (.not. allocated(error) .and. config%csv /= "") call check_output(config%csv, &
         config%force, error)
      if (allocated(error)) return
      call catch_signals()
      study%scene = file%scene
      call plan_models(study, error)
      if (allocated(error)) return
      call compute_references(study, references, config%quiet, stopped)
      if (.not. stopped) call compute_runs(study, references, config%quiet, stopped)
      if (stopped) then
         call fatal(error, "interrupted; nothing was written", status_interrupted)
         return
      end if
      call judge_runs(study)
      ! Files first: a reader of the output that goes away does not cost the measurement.
      call write_files(study, file, config, command_text(line%words), error)
      if (allocated(error)) return
      call write_stdout(report_text(study), error)
      if (allocated(error) .or. config%largest_error <= 0.0_wp) return
      call answer(study, config%largest_error, error)
   end subroutine report_cost

   !> The models that are compared, the exact one first.
   subroutine plan_models(study, error)
      !> The study; its scene is set.
      type(study_type), intent(inout) :: study
      !> Set when a model does not fit the scene.
      type(error_type), allocatable, intent(out) :: error
      type(friction_model_type), allocatable :: table(:)
      type(model_type), allocatable :: models(:)
      integer, allocatable :: friction(:), normal(:)
      character(len=:), allocatable :: problem
      integer :: i, j, n, exact, exact_normal

      table = friction_models()
      exact = findloc(table%info%name, exact_friction, dim=1)
      associate (scene => study%scene, cost => study%scene%cost)
         friction = cost%friction
         if (all([(.not. table(scene%contacts(i)%friction)%acts, &
            i=1, size(scene%contacts))])) then
            if (size(friction) > 0) then
               call fatal(error, "cost.friction: no contact of the scene has friction", &
                  status_usage)
               return
            end if
            friction = [0]
            exact = 0
         else if (size(friction) == 0) then
            friction = [exact]
            do i = size(table), 1, -1
               if (i == exact .or. .not. table(i)%acts) cycle
               if (table(i)%uses("drilling") .or. &
                  any(scene%contacts%friction == i)) friction = [friction, i]
            end do
         end if
         do i = 1, size(friction)
            if (friction(i) == 0) cycle
            do j = 1, size(scene%contacts)
               if (.not. table(scene%contacts(j)%friction)%acts) cycle
               problem = table(friction(i))%misfit(scene%contacts(j)%parameters)
               if (problem == "") cycle
               call fatal(error, "cost.friction: " // trim(table(friction(i))%info%name) // &
                  " in contact " // quote(scene%contacts(j)%name) // " " // problem, status_usage)
               return
            end do
         end do
         normal = cost%normal
         exact_normal = normal_hertz
         if (size(normal) == 0) then
            normal = [0]
            exact_normal = 0
         end if
         allocate(models(size(friction)*size(normal) + 1))
         models(1) = new_model(scene, exact, exact_normal)
         models(1)%runs = .false.
         n = 1
         do j = 1, size(normal)
            do i = 1, size(friction)
               if (friction(i) == exact .and. normal(j) == exact_normal) then
                  models(1)%runs = .true.
               else
                  n = n + 1
                  models(n) = new_model(scene, friction(i), normal(j))
               end if
            end do
         end do
      end associate
      allocate(study%models(n))
      do i = 1, n
         study%models(i) = models(i)
      end do
   end subroutine plan_models

   !> A model: the scene with other parts.
   function new_model(scene, friction, normal) result(model)
      type(scene_type), intent(in) :: scene
      !> Friction, index into `friction_models`; 0 for that of each contact.
      integer, intent(in) :: friction
      !> Normal force, index into `normal_models`; 0 for that of each contact.
      integer, intent(in) :: normal
      type(model_type) :: model
      type(friction_model_type), allocatable :: table(:)
      type(normal_model_type), allocatable :: normals(:)
      integer :: i

      table = friction_models()
      normals = normal_models()
      model%scene = scene
      model%name = "scene"
      if (friction > 0) model%name = trim(table(friction)%info%name)
      if (normal > 0 .and. friction > 0) then
         model%name = model%name // "+" // trim(normals(normal)%info%name)
      else if (normal > 0) then
         model%name = trim(normals(normal)%info%name)
      end if
      do i = 1, size(scene%contacts)
         associate (contact => model%scene%contacts(i))
            if (friction > 0 .and. table(contact%friction)%acts) then
               contact%friction = friction
            end if
            if (normal > 0) contact%normal = normal
         end associate
      end do
   end function new_model

   !> Reference of each model, checked by a second method.
   subroutine compute_references(study, references, quiet, stopped)
      type(study_type), intent(inout) :: study
      !> The references, one for each model.
      type(reference_type), allocatable, intent(out) :: references(:)
      !> Whether progress is not shown.
      logical, intent(in) :: quiet
      !> Whether a signal came.
      logical, intent(out) :: stopped
      type(progress_type) :: progress
      type(reference_type), allocatable :: checks(:)
      real(wp) :: rtol
      integer :: i

      rtol = study%scene%cost%reference_rtol
      stopped = .false.
      call progress%begin(quiet, 0.0_wp)
      allocate(references(size(study%models)), checks(size(study%models)))
      do i = 1, size(study%models)
         call progress%stage("reference " // to_text(i) // " of " // &
            to_text(size(study%models)) // ", " // study%models(i)%name)
         call one_reference(study%models(i), rtol, references(i), checks(i), stopped)
         if (stopped) exit
      end do
      call progress%clear()
      if (stopped) return
      if (references(1)%known) study%scales = reference_scales(references(1), study%scene)
      do i = 1, size(study%models)
         associate (model => study%models(i))
            if (allocated(model%problem)) cycle
            model%agreement = reference_distance(references(i), checks(i), study%scene)
            model%agreement_error = scaled_error(study, model%agreement, 0.0_wp)
            if (.not. references(1)%known) cycle
            model%modelling = reference_distance(references(i), references(1), study%scene)
            model%modelling_error = scaled_error(study, model%modelling, 0.0_wp)
         end associate
      end do
   end subroutine compute_references

   !> Reference of a model and its check.
   subroutine one_reference(model, rtol, reference, check, stopped)
      type(model_type), intent(inout) :: model
      !> Relative tolerance [-].
      real(wp), intent(in) :: rtol
      type(reference_type), intent(out) :: reference
      type(reference_type), intent(out) :: check
      !> Whether a signal came.
      logical, intent(out) :: stopped
      type(reference_type) :: candidate
      type(trial_type) :: trial
      character(len=:), allocatable :: reasons
      real(wp) :: limit
      integer :: i

      reasons = ""
      limit = reference_cpu
      do i = 1, size(reference_methods)
         trial = trial_type()
         call run_reference(model%scene, trim(reference_methods(i)), rtol, limit, candidate, trial)
         stopped = trial%outcome == outcome_stopped
         if (stopped) return
         if (.not. candidate%known) then
            reasons = reasons // "; " // trim(reference_methods(i)) // ": " // trial%message
            if (trial%outcome == outcome_slow) reasons = reasons // "too slow"
         else if (.not. reference%known) then
            reference = candidate
            model%cpu = trial%cpu
            limit = max(least_limit, reference_factor*trial%cpu)
         else if (candidate%method /= "auto" .or. &
            abs(candidate%explicit_share - reference%explicit_share) >= least_difference) then
            check = candidate
            exit
         end if
      end do
      if (.not. reference%known) then
         model%problem = reasons(3:)
         return
      end if
      if (.not. check%known) then
         trial = trial_type()
         call run_reference(model%scene, trim(reference%method), looser*rtol, limit, check, trial)
         stopped = trial%outcome == outcome_stopped
         if (stopped) return
         if (.not. check%known) then
            model%problem = "no second solution to check the reference" // reasons
            return
         end if
      end if
      model%method = reference%method
      model%check = check%method
      model%check_explicit_share = check%explicit_share
      model%rtol = [reference%rtol, check%rtol]
   end subroutine one_reference

   !> All runs, interleaved: each round runs what is short once more.
   subroutine compute_runs(study, references, quiet, stopped)
      type(study_type), intent(inout) :: study
      type(reference_type), intent(in), target :: references(:)
      !> Whether progress is not shown.
      logical, intent(in) :: quiet
      !> Whether a signal came.
      logical, intent(out) :: stopped
      type(progress_type) :: progress
      real(wp) :: share
      integer :: i, j, k, n, round

      associate (cost => study%scene%cost, models => study%models)
         allocate(study%runs(count(models%runs)*size(cost%methods)*size(cost%rtol)))
         n = 0
         do i = 1, size(models)
            if (.not. models(i)%runs) cycle
            do j = 1, size(cost%methods)
               do k = 1, size(cost%rtol)
                  n = n + 1
                  study%runs(n)%model = i
                  study%runs(n)%method = cost%methods(j)
                  study%runs(n)%rtol = cost%rtol(k)
               end do
            end do
         end do
         stopped = .false.
         call progress%begin(quiet, 0.0_wp)
         do round = 1, cost%repeats
            do i = 1, n
               share = real((round - 1)*n + i - 1, wp)/real(n*cost%repeats, wp)
               if (progress%is_due(share)) call progress%tell(share, "run " // to_text(i) // &
                  " of " // to_text(n) // ", round " // to_text(round) // " of " // &
                  to_text(cost%repeats))
               call one_run(study%runs(i), models(study%runs(i)%model), round, &
                  references(study%runs(i)%model), references(1))
               stopped = study%runs(i)%trial%outcome == outcome_stopped .or. &
                  signal_received() /= 0
               if (stopped) exit
            end do
            if (stopped) exit
         end do
      end associate
      call progress%clear()
   end subroutine compute_runs

   !> One run of a round.
   subroutine one_run(run, model, round, own, exact)
      type(run_type), intent(inout) :: run
      type(model_type), intent(in) :: model
      !> Number of the round.
      integer, intent(in) :: round
      !> Reference of the model.
      type(reference_type), intent(in), target :: own
      !> Reference of the exact model.
      type(reference_type), intent(in), target :: exact

      if (allocated(model%problem)) then
         run%trial%outcome = outcome_failed
         run%trial%message = "there is no reference for this model"
         run%trial%cpu = 0.0_wp
         return
      end if
      if (round > 1) then
         if (run%trial%outcome /= outcome_done .or. run%trial%cpu > short) return
      end if
      call run_trial(model%scene, trim(run%method), run%rtol, &
         max(least_limit, model%scene%cost%cpu_limit*model%cpu), own, exact, run%trial)
      if (run%trial%outcome == outcome_slow) run%trial%message = "given up after " // &
         number_text(run%trial%cpu, 3) // " s of CPU"
   end subroutine one_run

   !> Write the files that are asked for, each under a temporary name that it loses when all are
   !> complete.
   subroutine write_files(study, file, config, line, error)
      type(study_type), intent(in) :: study
      type(scene_file_type), intent(in) :: file
      type(cost_config_type), intent(in) :: config
      !> Command line.
      character(len=*), intent(in) :: line
      !> Set on failure.
      type(error_type), allocatable, intent(out) :: error
      type(hdf5_file_type) :: output
      type(error_type), allocatable :: ignored
      logical :: ours

      ours = .false.
      if (config%csv /= "") call write_text(config%csv // part_suffix, csv_text(study), error)
      if (.not. allocated(error) .and. config%output /= "") then
         call write_hdf5(study, file%text, file%resolved, line, config%output // part_suffix, &
            output, error)
         ours = output%is_open()
         if (.not. allocated(error)) call output%close_as(config%output, config%force, error)
      end if
      if (.not. allocated(error) .and. config%csv /= "") call rename_file(config%csv // &
         part_suffix, config%csv, error)
      if (.not. allocated(error)) return
      call output%abandon()
      if (config%csv /= "") call remove_file(config%csv // part_suffix, ignored)
      if (ours) call remove_file(config%output // part_suffix, ignored)
   end subroutine write_files

   !> Everything in words.
   function report_text(study) result(text)
      !> The study, judged.
      type(study_type), intent(in) :: study
      character(len=:), allocatable :: text
      integer :: i, k, longest

      text = ""
      if (study%scene%title /= "") text = study%scene%title // nl
      longest = 5
      do i = 1, size(study%models)
         longest = max(longest, len(study%models(i)%name))
      end do
      associate (cost => study%scene%cost)
         text = text // "error: largest of"
         do k = 1, size(cost_quantities)
            if (.not. cost%counts(k)) cycle
            text = text // " " // trim(cost_quantities(k)) // "/" // &
               number_text(study%scales(k), 3) // " " // trim(unit_of(k)) // ","
         end do
         text = text(:len(text) - 1) // nl // "measure: " // trim(cost_measures(cost%measure)) // nl
      end associate
      text = text // nl // "references" // nl
      do i = 1, size(study%models)
         text = text // "  " // left(study%models(i)%name, longest) // "  " // &
            reference_words(study, i) // nl
      end do
      text = text // nl // "runs" // nl // "  " // left("model", longest) // "  " // &
         left("method", 11) // right("rtol", 8) // right("CPU/s", 9) // right("rhs", 10) // &
         right("steps", 9) // right("numerical", 10) // right("error", 9) // right("events", 8) // &
         nl
      do i = 1, size(study%runs)
         associate (run => study%runs(i))
            text = text // mark(run) // left(study%models(run%model)%name, longest) // "  " // &
               left(trim(run%method), 11) // right(short_number(run%rtol), 8)
            if (run%trial%outcome /= outcome_done) then
               text = text // "  " // trim(outcome_names(run%trial%outcome)) // ": " // &
                  first_line(run%trial%message) // nl
               cycle
            end if
            text = text // right(number_text(run%trial%cpu, 3), 9) // &
               right(to_text(run%trial%statistics%derivatives), 10) // &
               right(to_text(run%trial%statistics%steps), 9) // &
               right(less(.not. run%resolved(1)) // short_number(run%numerical), 10) // &
               right(less(.not. run%resolved(2)) // short_number(run%error), 9) // &
               right(to_text(run%trial%n_events) // trim(merge("  ", " !", &
               run%trial%own%same_events)), 8) // nl
         end associate
      end do
      text = text // "*: Pareto front; ~: no larger than the references resolve; !: other " // &
         "events than the reference" // nl
      text = text // nl // "errors against the exact model, " // &
         trim(cost_measures(study%scene%cost%measure)) // nl // "  " // left("model", longest) // &
         "  " // left("method", 11) // right("rtol", 8)
      do k = 1, kinds
         text = text // right(trim(short_kinds(k)) // "/" // trim(short_units(k)), 10)
      end do
      text = text // right("events/s", 9) // right("E/J", 8) // nl
      do i = 1, size(study%runs)
         associate (run => study%runs(i))
            if (run%trial%outcome /= outcome_done) cycle
            text = text // "  " // left(study%models(run%model)%name, longest) // "  " // &
               left(trim(run%method), 11) // right(short_number(run%rtol), 8)
            do k = 1, kinds
               text = text // right(short_number(run%trial%total%value( &
                  study%scene%cost%measure, k)), 10)
            end do
            if (run%trial%total%same_events) then
               text = text // right(short_number(run%trial%total%events), 9)
            else
               text = text // right("differ", 9)
            end if
            text = text // right(short_number(run%trial%energy), 8) // nl
         end associate
      end do

   contains

      !> Sign of a run on the Pareto front.
      pure function mark(run) result(sign)
         type(run_type), intent(in) :: run
         character(len=2) :: sign

         sign = merge("* ", "  ", run%pareto)
      end function mark

      !> Sign of an error that is not resolved.
      pure function less(unresolved) result(sign)
         !> Whether it is not.
         logical, intent(in) :: unresolved
         character(len=:), allocatable :: sign

         sign = trim(merge("~", " ", unresolved))
      end function less

   end function report_text

   !> Names of the kinds of errors, as headings.
   pure function short_kinds(k) result(name)
      !> Index of the kind.
      integer, intent(in) :: k
      character(len=8) :: name

      name = kind_names(k)(:len(name))
      if (kind_names(k) == "position") name = "x"
      if (kind_names(k) == "velocity") name = "v"
      if (kind_names(k) == "angular_velocity") name = "w"
   end function short_kinds

   !> Their units, as headings.
   pure function short_units(k) result(unit)
      !> Index of the kind.
      integer, intent(in) :: k
      character(len=7) :: unit

      unit = kind_units(k)
      if (unit == "m s-1") unit = "(m/s)"
      if (unit == "rad s-1") unit = "(rad/s)"
   end function short_units

   !> Unit of a quantity.
   pure function unit_of(k) result(unit)
      !> Index of the quantity.
      integer, intent(in) :: k
      character(len=7) :: unit
      character(len=7), parameter :: others(2) = [character(len=7) :: "s", "J"]

      if (k <= kinds) then
         unit = kind_units(k)
      else
         unit = others(k - kinds)
      end if
   end function unit_of

   !> What is known about the reference of a model.
   function reference_words(study, i) result(text)
      type(study_type), intent(in) :: study
      !> Index of the model.
      integer, intent(in) :: i
      character(len=:), allocatable :: text

      associate (model => study%models(i))
         if (allocated(model%problem)) then
            text = "none: " // first_line(model%problem)
            return
         end if
         text = trim(model%method) // " at " // to_text(model%rtol(1)) // "; " // &
            trim(model%check)
         if (model%check == "auto") text = text // ", explicit8 for " // &
            to_text(nint(100.0_wp*model%check_explicit_share)) // " % of the time,"
         if (model%rtol(2) > model%rtol(1)) text = text // " at " // to_text(model%rtol(2))
         if (ieee_is_finite(model%agreement_error)) then
            text = text // " agrees to " // short_number(model%agreement_error)
         else
            text = text // " finds other events"
         end if
         if (i == 1) return
         if (ieee_is_finite(model%modelling_error)) then
            text = text // "; model error " // short_number(model%modelling_error)
         else
            text = text // "; model error: other events"
         end if
      end associate
   end function reference_words

   !> Name the cheapest choice for an error.
   subroutine answer(study, largest, error)
      !> The study, judged.
      type(study_type), intent(in) :: study
      !> Largest scaled error [-].
      real(wp), intent(in) :: largest
      !> Set when no run is accurate enough.
      type(error_type), allocatable, intent(out) :: error
      character(len=:), allocatable :: text
      real(wp) :: smallest
      integer :: best, i

      best = cheapest(study, largest)
      if (best > 0) then
         associate (run => study%runs(best))
            text = nl // "cheapest for an error of " // to_text(largest) // ": " // &
               study%models(run%model)%name // ", " // trim(run%method) // " at rtol " // &
               to_text(run%rtol) // nl // "  error " // short_number(run%bound) // ", " // &
               number_text(run%trial%cpu, 3) // " s of CPU" // nl
         end associate
         call write_stdout(text, error)
         return
      end if
      smallest = huge(smallest)
      do i = 1, size(study%runs)
         if (ieee_is_finite(study%runs(i)%bound)) smallest = min(smallest, study%runs(i)%bound)
      end do
      if (smallest >= huge(smallest)) then
         text = "the errors of no run are known"
      else
         text = "no run has an error of " // to_text(largest) // " or less; the smallest is " // &
            short_number(smallest)
      end if
      associate (exact => study%models(1))
         if (allocated(exact%problem)) then
            text = text // "; there is no reference"
         else if (.not. ieee_is_finite(exact%agreement_error)) then
            text = text // "; the two references have different events"
         else if (exact%agreement_error > largest) then
            text = text // "; the two references agree to " // &
               short_number(exact%agreement_error) // " only, errors below that are unresolved: " &
               // "cost.reference_rtol is to be smaller"
         end if
      end associate
      call fatal(error, text, status_failed)
   end subroutine answer

   !> A number in two digits, as 1.2e-5.
   pure function short_number(x) result(text)
      !> The number.
      real(wp), intent(in) :: x
      character(len=:), allocatable :: text
      character(len=16) :: digits

      if (.not. ieee_is_finite(x)) then
         text = "-"
         return
      end if
      write(digits, "(es9.1e2)") x
      text = trim(adjustl(digits))
   end function short_number

   !> First line of a text.
   pure function first_line(text) result(line)
      character(len=*), intent(in) :: text
      character(len=:), allocatable :: line
      integer :: i

      i = index(text, nl)
      if (i == 0) i = len(text) + 1
      line = text(:i - 1)
   end function first_line

   !> A text with blanks after it.
   pure function left(text, width) result(cell)
      character(len=*), intent(in) :: text
      integer, intent(in) :: width
      character(len=:), allocatable :: cell

      cell = text // repeat(" ", max(0, width - len(text)))
   end function left

   !> A text with blanks before it, at least one.
   pure function right(text, width) result(cell)
      character(len=*), intent(in) :: text
      integer, intent(in) :: width
      character(len=:), allocatable :: cell

      cell = repeat(" ", max(1, width - len(text))) // text
   end function right

end module contensou_drivers_cost
