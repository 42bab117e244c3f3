!> `contensou cost`: what the accuracy of a scene costs, over models, methods and tolerances.
module contensou_drivers_cost
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite
   use contensou_base_errors, only : error_type, fatal, status_failed, status_interrupted, &
      status_usage
   use contensou_base_kinds, only : wp
   use contensou_base_numbers, only : number_text, power_text, to_text
   use contensou_base_operating_system, only : catch_signals, remove_file, rename_file, &
      same_file, signal_received, temporary_name, write_stdout
   use contensou_base_text, only : command_text, right, string_type
   use contensou_drivers_command_line, only : command_line_type, command_type, option_type, &
      strict_option, takes_positive
   use contensou_drivers_output, only : check_output, write_text
   use contensou_drivers_progress, only : progress_type
   use contensou_files_cost_table, only : csv_text, write_hdf5
   use contensou_files_hdf5_file, only : hdf5_file_type
   use contensou_scene_cost, only : cost_measures, cost_quantities
   use contensou_drivers_report, only : heed_warnings
   use contensou_scene_reader, only : read_scene, scene_file_type
   use contensou_study_cost, only : cheapest, compute_references, compute_runs, judge_runs, &
      kind_names, kind_units, outcome_names, plan_models, run_type, study_type
   use contensou_study_work_precision, only : kinds, onlooker_type, outcome_done, reference_type
   implicit none(type, external)
   private

   public :: cost_command

   type(option_type), parameter :: options(*) = [ &
      option_type("SCENE", "", "namelist file", needs="a scene"), &
      option_type("--error", "E", "name the cheapest choice with an error of at most E", &
      needs="a number > 0 [-]", takes=takes_positive), &
      option_type("--output", "FILE", "write an HDF5 file, for scripts/plot", "-o", &
      "the name of a file"), &
      option_type("--csv", "FILE", "write the table", needs="the name of a file"), &
      option_type("--force", "", "replace existing files"), &
      option_type("--quiet", "", "print no progress and no table, only the answer to --error", &
      "-q"), strict_option, &
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

   !> Onlooker that shows progress and heeds signals.
   type, extends(onlooker_type) :: display_type
      type(progress_type) :: progress
   contains
      procedure :: stage
      procedure :: tell
      procedure :: stops
   end type display_type

   character(len=*), parameter :: nl = new_line("a")

contains

   !> `contensou cost` in the table of commands.
   function cost_command() result(command)
      type(command_type) :: command

      command = command_type("cost", "errors and CPU times over models, methods, tolerances", &
         options, "runs the scene over models, methods and tolerances, those of its group " // &
         "&cost, and reports errors against CPU time", heeds_signals=.true., execute=report_cost)
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
      if (config%quiet .and. config%csv == "" .and. config%output == "" .and. &
         config%largest_error <= 0.0_wp) call fatal(error, "-q prints no table, and nothing " // &
         "else is asked for; -o FILE or --csv FILE writes it", status_usage)
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
      type(display_type) :: display
      type(string_type) :: inputs(1)
      logical :: stopped

      call configure(line, config, error)
      if (allocated(error)) return
      call catch_signals()
      call read_scene(config%scene, config%overrides, "", file, error)
      if (allocated(error)) return
      call heed_warnings(file, config%scene, line%has("--strict"), error)
      if (allocated(error)) return
      inputs(1)%s = config%scene
      if (config%output /= "") call check_output(config%output, inputs, config%force, error)
      if (.not. allocated(error) .and. config%csv /= "") call check_output(config%csv, &
         inputs, config%force, error)
      if (.not. allocated(error) .and. config%csv /= "" .and. config%output /= "") then
         if (same_file(config%csv, config%output)) call fatal(error, &
            "-o and --csv name the same file", status_usage)
      end if
      if (allocated(error)) return
      study%scene = file%scene
      study%cost = file%cost
      call plan_models(study, error)
      if (allocated(error)) return
      call display%progress%begin(config%quiet, 0.0_wp)
      call compute_references(study, references, display, stopped)
      call display%progress%clear()
      if (.not. stopped) then
         call display%progress%begin(config%quiet, 0.0_wp)
         call compute_runs(study, references, display, stopped)
         call display%progress%clear()
      end if
      if (stopped) then
         call fatal(error, "interrupted; nothing was written", status_interrupted)
         return
      end if
      call judge_runs(study)
      ! Files first: a reader of the output that goes away does not cost the measurement.
      call write_files(study, file, config, command_text(line%words), error)
      if (allocated(error)) return
      if (.not. config%quiet) call write_stdout(report_text(study), error)
      if (allocated(error) .or. config%largest_error <= 0.0_wp) return
      call answer(study, config%largest_error, config%quiet, error)
   end subroutine report_cost

   !> A reference is begun.
   subroutine stage(self, text)
      class(display_type), intent(inout) :: self
      !> Which one.
      character(len=*), intent(in) :: text

      call self%progress%stage(text)
   end subroutine stage

   !> A run is begun.
   subroutine tell(self, share, run, runs, round, rounds)
      class(display_type), intent(inout) :: self
      !> Share of the runs that are done.
      real(wp), intent(in) :: share
      integer, intent(in) :: run
      integer, intent(in) :: runs
      integer, intent(in) :: round
      integer, intent(in) :: rounds

      if (self%progress%is_due(share)) call self%progress%tell(share, "run " // to_text(run) // &
         " of " // to_text(runs) // ", round " // to_text(round) // " of " // to_text(rounds))
   end subroutine tell

   !> Whether a signal came.
   logical function stops(self)
      class(display_type), intent(in) :: self

      stops = signal_received() /= 0
   end function stops

   !> Write the files that are asked for, each under a temporary name that it loses when all are
   !> complete.
   subroutine write_files(study, file, config, line, error)
      type(study_type), intent(in) :: study
      type(scene_file_type), intent(in) :: file
      type(cost_config_type), intent(in) :: config
      !> Command line.
      character(len=*), intent(in) :: line
      type(error_type), allocatable, intent(out) :: error
      type(hdf5_file_type) :: output
      type(error_type), allocatable :: ignored
      character(len=:), allocatable :: csv, h5
      logical :: ours

      ours = .false.
      csv = temporary_name(config%csv)
      h5 = temporary_name(config%output)
      if (config%csv /= "") call write_text(csv, csv_text(study), error)
      if (.not. allocated(error) .and. config%output /= "") then
         call write_hdf5(study, file%text, file%resolved, line, h5, output, error)
         ours = output%is_open()
         if (.not. allocated(error)) call output%close_as(config%output, config%force, error)
      end if
      if (.not. allocated(error) .and. config%csv /= "") call rename_file(csv, config%csv, error, &
         config%force)
      if (.not. allocated(error)) return
      call output%abandon()
      if (config%csv /= "") call remove_file(csv, ignored)
      if (ours) call remove_file(h5, ignored)
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
      associate (cost => study%cost)
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
      text = text // nl // runs_text(study, longest) // nl // errors_text(study, longest)
   end function report_text

   !> The table of the runs.
   function runs_text(study, longest) result(text)
      type(study_type), intent(in) :: study
      !> Width of the column of models.
      integer, intent(in) :: longest
      character(len=:), allocatable :: text
      integer :: i

      text = "runs" // nl // "  " // left("model", longest) // "  " // &
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

   end function runs_text

   !> The table of the errors against the exact model, by kind.
   function errors_text(study, longest) result(text)
      type(study_type), intent(in) :: study
      !> Width of the column of models.
      integer, intent(in) :: longest
      character(len=:), allocatable :: text
      integer :: i, k

      text = "errors against the exact model, " // &
         trim(cost_measures(study%cost%measure)) // nl // "  " // left("model", longest) // &
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
                  study%cost%measure, k)), 10)
            end do
            if (run%trial%total%same_events) then
               text = text // right(short_number(run%trial%total%events), 9)
            else
               text = text // right("differ", 9)
            end if
            text = text // right(short_number(run%trial%energy), 8) // nl
         end associate
      end do
   end function errors_text

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
   subroutine answer(study, largest, quiet, error)
      !> The study, judged.
      type(study_type), intent(in) :: study
      !> Largest scaled error [-].
      real(wp), intent(in) :: largest
      !> Whether nothing was printed before it.
      logical, intent(in) :: quiet
      !> Set when no run is accurate enough.
      type(error_type), allocatable, intent(out) :: error
      character(len=:), allocatable :: text
      real(wp) :: smallest
      integer :: best, i

      best = cheapest(study, largest)
      if (best > 0) then
         associate (run => study%runs(best))
            text = "cheapest for an error of " // to_text(largest) // ": " // &
               study%models(run%model)%name // ", " // trim(run%method) // " at rtol " // &
               to_text(run%rtol) // nl // "  error " // short_number(run%bound) // ", " // &
               number_text(run%trial%cpu, 3) // " s of CPU" // nl
         end associate
         if (.not. quiet) text = nl // text
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
      real(wp), intent(in) :: x
      character(len=:), allocatable :: text

      text = "-"
      if (ieee_is_finite(x)) text = power_text(x, 2)
   end function short_number

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

end module contensou_drivers_cost
