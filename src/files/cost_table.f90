!> The results of `contensou cost` as a table: errors, Pareto front, CSV, HDF5. docs/cost.md
!> describes the columns.
module contensou_files_cost_table
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite, ieee_quiet_nan, ieee_value
   use contensou_base_errors, only : error_type
   use contensou_base_kinds, only : wp
   use contensou_base_numbers, only : to_text
   use contensou_base_text, only : pad, string_type
   use contensou_scene_cost, only : cost_measures, cost_quantities
   use contensou_study_cost, only : kind_names, kind_units, model_type, outcome_names, run_type, &
      study_type
   use contensou_study_work_precision, only : distance_type, kinds, measures, outcome_done
   use contensou_files_hdf5_file, only : hdf5_file_type
   use contensou_files_provenance, only : put_header, put_input
   implicit none(type, external)
   private

   public :: csv_text, write_hdf5, cost_filetype, cost_filetype_version

   !> What the file is, for programs that open it.
   character(len=*), parameter :: cost_filetype = "contensou-cost"

   !> Version of the format: the second number grows with additions, the first with changes.
   character(len=*), parameter :: cost_filetype_version = "1.2"

   !> A column of the table.
   type :: column_type
      character(len=40) :: name = ""
      character(len=8) :: units = ""
      character(len=96) :: about = ""
      !> Values, NaN for none.
      real(wp), allocatable :: values(:)
   end type column_type

contains

   !> Numbers of the table.
   function columns_of(study) result(columns)
      type(study_type), intent(in) :: study
      type(column_type), allocatable :: columns(:)
      character(len=40) :: name
      integer :: n, i, k, m

      allocate(columns(14 + 2*kinds*measures))
      n = 0
      associate (runs => study%runs)
         call put("rtol", "1", "relative tolerance", runs%rtol)
         call put("cpu", "s", "least CPU time", runs%trial%cpu)
         call put("steps", "1", "steps", real(runs%trial%statistics%steps, wp))
         call put("right_hand_sides", "1", "evaluations of the right-hand side", &
            real(runs%trial%statistics%derivatives, wp))
         call put("jacobians", "1", "Jacobians", real(runs%trial%statistics%jacobians, wp))
         call put("events", "1", "touches and lift-offs", real(runs%trial%n_events, wp))
         call put("error", "1", "scaled error against the exact model", runs%error)
         call put("error_numerical", "1", "scaled error against the same model", runs%numerical)
         call put("error_bound", "1", &
            "the larger one of error and of what the references resolve", runs%bound)
         call put("pareto", "1", "1 if no run is both cheaper and more accurate", &
            merge(1.0_wp, 0.0_wp, runs%pareto))
         do k = 1, kinds
            do m = 1, measures
               name = "error_" // trim(kind_names(k)) // "_" // trim(cost_measures(m))
               call put(name, trim(kind_units(k)), "error of " // trim(kind_names(k)) // ", " // &
                  trim(cost_measures(m)) // ", against the exact model", &
                  [(runs(i)%trial%total%value(m, k), i=1, size(runs))])
               name = "numerical_" // trim(kind_names(k)) // "_" // trim(cost_measures(m))
               call put(name, trim(kind_units(k)), "error of " // trim(kind_names(k)) // ", " // &
                  trim(cost_measures(m)) // ", against the same model", &
                  [(runs(i)%trial%own%value(m, k), i=1, size(runs))])
            end do
         end do
         call put("error_events", "s", &
            "largest shift of an event against the exact model; none if the events differ", &
            [(shift(runs(i)%trial%total), i=1, size(runs))])
         call put("numerical_events", "s", &
            "largest shift of an event against the same model; none if the events differ", &
            [(shift(runs(i)%trial%own), i=1, size(runs))])
         call put("energy_residual", "J", "largest residual of the energy balance", &
            runs%trial%energy)
         call put("resolved", "1", "1 if the references resolve the error", &
            [(merge(1.0_wp, 0.0_wp, runs(i)%resolved(2)), i=1, size(runs))])
         ! What a run that did not come to its end says of the motion is no error.
         do i = 1, size(runs)
            do k = 1, n
               if (runs(i)%trial%outcome == outcome_done) cycle
               if (index(columns(k)%name, "error") == 1 .or. index(columns(k)%name, &
                  "numerical") == 1 .or. columns(k)%name == "energy_residual") then
                  columns(k)%values(i) = ieee_value(1.0_wp, ieee_quiet_nan)
               end if
            end do
         end do
      end associate

   contains

      !> Add a column.
      subroutine put(column_name, units, about, values)
         character(len=*), intent(in) :: column_name
         character(len=*), intent(in) :: units
         character(len=*), intent(in) :: about
         real(wp), intent(in) :: values(:)

         n = n + 1
         columns(n)%name = column_name
         columns(n)%units = units
         columns(n)%about = about
         columns(n)%values = values
      end subroutine put

   end function columns_of

   !> Shift of the events, NaN if they differ [s].
   pure real(wp) function shift(distance)
      type(distance_type), intent(in) :: distance

      shift = distance%events
      if (.not. distance%same_events) shift = ieee_value(shift, ieee_quiet_nan)
   end function shift

   !> The table as CSV: a header, then a row for each run; empty cells for what there is not.
   function csv_text(study) result(text)
      type(study_type), intent(in) :: study
      character(len=:), allocatable :: text
      type(column_type), allocatable :: columns(:)
      integer :: i, k

      columns = columns_of(study)
      text = "model,method,status"
      do k = 1, size(columns)
         text = text // "," // trim(columns(k)%name)
      end do
      text = text // ",message" // new_line("a")
      do i = 1, size(study%runs)
         associate (run => study%runs(i))
            text = text // study%models(run%model)%name // "," // trim(run%method) // "," // &
               trim(outcome_names(run%trial%outcome))
            do k = 1, size(columns)
               text = text // ","
               if (ieee_is_finite(columns(k)%values(i))) text = text // &
                  to_text(columns(k)%values(i))
            end do
            text = text // "," // cell(run%trial%message) // new_line("a")
         end associate
      end do
   end function csv_text

   !> A text as a cell: in quotes, without line feeds.
   pure function cell(words) result(text)
      character(len=*), intent(in) :: words
      character(len=:), allocatable :: text
      integer :: i

      text = ""
      if (words == "") return
      text = '"'
      do i = 1, len(words)
         if (words(i:i) == new_line("a")) then
            text = text // "; "
         else if (words(i:i) == '"') then
            text = text // '""'
         else
            text = text // words(i:i)
         end if
      end do
      text = text // '"'
   end function cell

   !> Write everything.
   subroutine write_hdf5(study, namelist, resolved, command_line, name, file, error)
      type(study_type), intent(in) :: study
      !> Text of the scene file.
      character(len=*), intent(in) :: namelist
      character(len=*), intent(in) :: resolved
      character(len=*), intent(in) :: command_line
      character(len=*), intent(in) :: name
      !> The file, left open.
      type(hdf5_file_type), intent(inout) :: file
      type(error_type), allocatable, intent(out) :: error
      character(len=8), parameter :: units(*) = [character(len=8) :: kind_units, "s", "J"]
      character(len=*), parameter :: scale(1) = ["/quantity/name"]

      call file%create(name, error)
      if (allocated(error)) return
      call put_header(file, cost_filetype, cost_filetype_version, "complete", error, &
         study%scene%title)
      call file%put_attribute("/", "measure", trim(cost_measures(study%cost%measure)), error)
      call file%put_attribute("/", "NX_class", "NXroot", error)
      call file%put_attribute("/", "default", "run", error)
      call put_input(file, namelist, resolved, command_line, error)
      call file%create_group("/quantity", error)
      call file%put_labels("/quantity/name", cost_quantities, "quantity", error)
      call file%put_array("/quantity/scale", study%scales, scale, "1", &
         "what its errors are divided by, in its unit", error)
      call file%put_texts("/quantity/unit", units, scale, "unit", error)
      call file%put_array("/quantity/counts", merge(1, 0, study%cost%counts), scale, "1", &
         "1 if it counts for the error", error)
      call put_models(study, file, error)
      call put_runs(study, file, error)
      ! A failure is kept by the file, so that this last call sees the first one.
      call file%flush(error)
   end subroutine write_hdf5

   !> The models with their references.
   subroutine put_models(study, file, error)
      type(study_type), intent(in) :: study
      type(hdf5_file_type), intent(inout) :: file
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: scale(1) = ["/model/name"]
      type(string_type) :: models(size(study%models))
      character(len=:), allocatable :: names(:)
      integer :: i, j, k, n

      n = size(study%models)
      do i = 1, n
         models(i)%s = study%models(i)%name
      end do
      call pad(models, names)
      call file%create_group("/model", error)
      call file%put_labels("/model/name", names, "model; the first one is the exact one", error)
      call file%put_texts("/model/reference_method", (study%models%method), scale, &
         "method of the reference", error)
      call file%put_texts("/model/check_method", (study%models%check), scale, &
         "method that checks the reference", error)
      call put("reference_rtol", [(study%models(i)%rtol(1), i=1, n)], "1", &
         "relative tolerance of the reference")
      call put("check_rtol", [(study%models(i)%rtol(2), i=1, n)], "1", &
         "relative tolerance of its check")
      call put("check_explicit_share", study%models%check_explicit_share, "1", &
         "share of the time in which the check went by explicit8")
      call put("reference_cpu", study%models%cpu, "s", "CPU time of the reference")
      call put("agreement", study%models%agreement_error, "1", &
         "scaled distance of the reference and its check")
      call put("error", study%models%modelling_error, "1", &
         "scaled error of the model: distance of its reference to that of the exact one")
      do k = 1, kinds
         do i = 1, measures
            call put("error_" // trim(kind_names(k)) // "_" // trim(cost_measures(i)), &
               [(study%models(j)%modelling%value(i, k), j=1, n)], trim(kind_units(k)), &
               "error of the model")
            call put("agreement_" // trim(kind_names(k)) // "_" // trim(cost_measures(i)), &
               [(study%models(j)%agreement%value(i, k), j=1, n)], trim(kind_units(k)), &
               "distance of the reference and its check")
         end do
      end do

   contains

      !> A number of each model.
      subroutine put(name, values, units, long_name)
         character(len=*), intent(in) :: name
         real(wp), intent(in) :: values(:)
         character(len=*), intent(in) :: units
         character(len=*), intent(in) :: long_name

         call file%put_array("/model/" // name, values, scale, units, long_name, error)
      end subroutine put

   end subroutine put_models

   subroutine put_runs(study, file, error)
      type(study_type), intent(in) :: study
      type(hdf5_file_type), intent(inout) :: file
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: scale(1) = ["/run/label"]
      type(string_type), dimension(size(study%runs)) :: labels, models, messages
      character(len=:), allocatable :: padded(:)
      type(column_type), allocatable :: columns(:)
      integer :: i

      do i = 1, size(study%runs)
         associate (run => study%runs(i))
            models(i)%s = study%models(run%model)%name
            messages(i)%s = run%trial%message
            labels(i)%s = models(i)%s // " " // trim(run%method) // " " // to_text(run%rtol)
         end associate
      end do
      call file%create_group("/run", error)
      call pad(labels, padded)
      call file%put_labels("/run/label", padded, "run", error)
      call pad(models, padded)
      call file%put_texts("/run/model", padded, scale, "model", error)
      call file%put_texts("/run/method", (study%runs%method), scale, "method", error)
      call file%put_texts("/run/status", outcome_names(study%runs%trial%outcome), scale, &
         "how it ended", error)
      call pad(messages, padded)
      call file%put_texts("/run/message", padded, scale, "why it failed", error)
      columns = columns_of(study)
      do i = 1, size(columns)
         call file%put_array("/run/" // trim(columns(i)%name), columns(i)%values, scale, &
            trim(columns(i)%units), trim(columns(i)%about), error)
      end do
   end subroutine put_runs

end module contensou_files_cost_table
