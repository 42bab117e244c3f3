!> What the accuracy of a scene costs: models, their references, runs over methods and tolerances,
!> and which of these are worth their time. docs/cost.md describes it.
module contensou_study_cost
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite, ieee_quiet_nan, ieee_value
   use contensou_base_errors, only : error_type, fatal, status_usage
   use contensou_base_kinds, only : wp
   use contensou_base_numbers, only : number_text, to_text
   use contensou_base_text, only : quote
   use contensou_contact_creep, only : creep_model_type, creep_models, default_creep
   use contensou_contact_curvature, only : curvature_model_type, curvature_models, spot_curved, &
      spot_flat, spot_slender
   use contensou_contact_friction, only : friction_model_type, friction_models
   use contensou_contact_normal, only : normal_hertz, normal_model_type, normal_models
   use contensou_contact_tangential, only : tangential_model_type, tangential_models
   use contensou_contact_tangential_law, only : creep_key
   use contensou_contact_tangential_shells, only : most_layers
   use contensou_dynamics_scene, only : scene_type
   use contensou_scene_contacts, only : creeps, remembers, without_stick
   use contensou_scene_cost, only : cost_quantities, cost_spec_type
   use contensou_study_work_precision, only : distance_type, kinds, onlooker_type, outcome_done, &
      outcome_failed, outcome_slow, outcome_stopped, reference_distance, reference_scales, &
      reference_type, run_reference, run_trial, trial_type
   implicit none(type, external)
   private

   public :: study_type, model_type, run_type
   public :: plan_models, compute_references, compute_runs, judge_runs, cheapest
   public :: outcome_names, kind_names, kind_units

   !> Names of the kinds of errors and of what else is scaled.
   character(len=*), parameter :: kind_names(kinds) = cost_quantities(:kinds)

   !> Their units.
   character(len=*), parameter :: kind_units(kinds) = [character(len=7) :: "m", "rad", "m s-1", &
      "rad s-1"]

   !> Names of the outcomes, in the order of the codes.
   character(len=*), parameter :: outcome_names(*) = [character(len=8) :: &
      "done", "failed", "too_slow", "stopped"]

   !> A model of the ladder.
   type :: model_type
      character(len=:), allocatable :: name
      !> Whether it is run, and not only a reference.
      logical :: runs = .true.
      !> The scene with this model.
      type(scene_type) :: scene
      !> Method of the reference, and of its check.
      character(len=11) :: method = "", check = ""
      !> Share of the time in which the check went by explicit8 [-].
      real(wp) :: check_explicit_share = 0.0_wp
      !> Relative tolerances of these [-].
      real(wp) :: rtol(2) = 0.0_wp
      !> CPU time of the reference [s].
      real(wp) :: cpu = 0.0_wp
      !> Distance of the reference and its check.
      type(distance_type) :: agreement
      !> Distance to the reference of the exact model: the error of the model.
      type(distance_type) :: modelling
      !> Scaled distance of the reference and its check; NaN if their events differ and count [-].
      real(wp) :: agreement_error = 0.0_wp
      !> Scaled error of the model; NaN if the events differ and count [-].
      real(wp) :: modelling_error = 0.0_wp
      !> Why there is no reference; not allocated if there is one.
      character(len=:), allocatable :: problem
   end type model_type

   !> A model with a method and a tolerance: CPU time and errors.
   type :: run_type
      integer :: model = 0
      character(len=11) :: method = ""
      !> Relative tolerance [-].
      real(wp) :: rtol = 0.0_wp
      type(trial_type) :: trial
      !> Scaled error against the reference of the own model; NaN if there is none [-].
      real(wp) :: numerical = 0.0_wp
      !> Scaled error against the reference of the exact model; NaN if there is none [-].
      real(wp) :: error = 0.0_wp
      !> The larger one of that and of what the references resolve [-].
      real(wp) :: bound = 0.0_wp
      !> Whether the references resolve the numerical error, and the error.
      logical :: resolved(2) = .false.
      !> Whether no run is both cheaper and more accurate.
      logical :: pareto = .false.
   end type run_type

   !> Everything.
   type :: study_type
      !> Scene as read; its rows are the samples at which trajectories are compared.
      type(scene_type) :: scene
      type(cost_spec_type) :: cost
      !> Models; the first one is the exact one.
      type(model_type), allocatable :: models(:)
      type(run_type), allocatable :: runs(:)
      !> What the errors of the quantities are divided by, in the order of `cost_quantities`.
      real(wp) :: scales(size(cost_quantities)) = 1.0_wp
   end type study_type

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

   !> Law of creep that is the theory itself.
   character(len=*), parameter :: exact_creep = "boundary_elements"

contains

   !> The models that are compared, the exact one first.
   subroutine plan_models(study, error)
      !> The study; its scene is set.
      type(study_type), intent(inout) :: study
      !> Set when a model does not fit the scene.
      type(error_type), allocatable, intent(out) :: error
      type(friction_model_type), allocatable :: table(:)
      type(model_type), allocatable :: models(:)
      integer, allocatable :: friction(:), normal(:)
      logical :: remembering
      integer :: i, j, n, exact, exact_normal

      table = friction_models()
      exact = findloc(table%info%name, exact_friction, dim=1)
      associate (scene => study%scene, cost => study%cost)
         scene%output%interval = scene%t_end/cost%samples
         remembering = any([(remembers(scene%contacts(i)%tangential), i=1, size(scene%contacts))])
         if (cost%layers_given .and. .not. remembering) then
            call fatal(error, "cost.layers: no contact of the scene has tangential elasticity " // &
               "with memory", status_usage)
            return
         end if
         if (size(cost%creep) > 0) call check_creep(study, error)
         if (allocated(error)) return
         call plan_friction(study, table, exact, friction, error)
         if (allocated(error)) return
         normal = cost%normal
         exact_normal = normal_hertz
         if (size(normal) == 0) then
            normal = [0]
            exact_normal = 0
         end if
         if (size(cost%creep) > 0) then
            call plan_creep(study, exact, exact_normal, normal)
            return
         end if
         if (remembering) then
            call plan_layers(study, exact, exact_normal, normal)
            return
         end if
         allocate(models(size(friction)*size(normal) + 3))
         models(1) = new_model(scene, exact, exact_normal)
         models(1)%runs = .false.
         n = 1
         do j = 1, size(normal)
            do i = 1, size(friction)
               if (friction(i) == exact .and. normal(j) == exact_normal) then
                  models(1)%runs = .true.
               else
                  n = n + 1
                  models(n) = new_model(scene, friction(i), normal(j), &
                     merge(spot_curved, spot_flat, friction(i) == exact))
               end if
            end do
         end do
         if (any(scene%contacts%curvature /= spot_flat) .and. size(cost%friction) == 0) then
            ! What the curvature of the spots costs and changes.
            models(n + 1) = new_model(scene, exact, exact_normal, spot_slender)
            models(n + 2) = new_model(scene, exact, exact_normal, spot_flat)
            n = n + 2
         end if
      end associate
      allocate(study%models(n))
      do i = 1, n
         study%models(i) = models(i)
      end do
   end subroutine plan_models

   !> Friction of the models: those that the scene asks for, or all that fit.
   subroutine plan_friction(study, table, exact, friction, error)
      type(study_type), intent(in) :: study
      type(friction_model_type), intent(in) :: table(:)
      !> Position of the exact one in the table; 0 where no contact has friction.
      integer, intent(inout) :: exact
      !> Positions in the table; 0 for none.
      integer, allocatable, intent(out) :: friction(:)
      !> Set when one does not fit the scene.
      type(error_type), allocatable, intent(out) :: error
      character(len=:), allocatable :: problem
      integer :: i, j

      associate (scene => study%scene)
         friction = study%cost%friction
         if (all([(.not. table(scene%contacts(i)%friction)%acts, &
            i=1, size(scene%contacts))])) then
            if (size(friction) > 0) then
               call fatal(error, "cost.friction: no contact of the scene has friction", &
                  status_usage)
               return
            end if
            friction = [0]
            exact = 0
         else if (any(scene%contacts%tangential > 1)) then
            ! What sticks has the limit of the exact wrench, and no other.
            if (any(friction /= exact)) then
               call fatal(error, "cost.friction: contacts with tangential elasticity or " // &
                  "rolling have contensou_exact", status_usage)
               return
            end if
            friction = [exact]
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
      end associate
   end subroutine plan_friction

   !> Models of a scene whose contacts remember: numbers of layers, the most of them first.
   subroutine plan_layers(study, friction, exact_normal, normal)
      type(study_type), intent(inout) :: study
      !> The exact friction model, and the exact model of the normal force.
      integer, intent(in) :: friction, exact_normal
      !> Those of the normal force.
      integer, intent(in) :: normal(:)
      integer :: i, j, n

      associate (scene => study%scene, layers => study%cost%layers)
         n = size(layers)*size(normal) + 1
         if (any(layers == most_layers) .and. any(normal == exact_normal)) n = n - 1
         allocate(study%models(n))
         study%models(1) = new_model(scene, friction, exact_normal)
         call set_layers(study%models(1), most_layers)
         study%models(1)%runs = .false.
         n = 1
         do j = 1, size(normal)
            do i = 1, size(layers)
               if (layers(i) == most_layers .and. normal(j) == exact_normal) then
                  study%models(1)%runs = .true.
                  cycle
               end if
               n = n + 1
               study%models(n) = new_model(scene, friction, normal(j))
               call set_layers(study%models(n), layers(i))
            end do
         end do
      end associate
   end subroutine plan_layers

   !> Report laws of creep that the scene has no use for.
   subroutine check_creep(study, error)
      type(study_type), intent(in) :: study
      type(error_type), allocatable, intent(out) :: error
      type(creep_model_type), allocatable :: table(:)
      integer :: i

      table = creep_models()
      associate (contacts => study%scene%contacts, cost => study%cost)
         if (.not. any([(creeps(contacts(i)), i=1, size(contacts))])) then
            call fatal(error, "cost.creep: no contact of the scene has a law of creep", &
               status_usage)
         else if (cost%layers_given) then
            call fatal(error, "cost.layers: laws of creep are compared, not numbers of layers", &
               status_usage)
         else if (any(table(cost%creep)%info%name == without_stick) .and. &
            any([(creeps(contacts(i)) .and. remembers(contacts(i)%tangential), &
            i=1, size(contacts))])) then
            call fatal(error, "cost.creep: nothing sticks with creep = " // quote(without_stick) &
               // ", so that nothing is left to remember", status_usage)
         end if
      end associate
   end subroutine check_creep

   !> Models of a scene whose contacts roll: laws of creep, the most accurate one first.
   subroutine plan_creep(study, friction, exact_normal, normal)
      type(study_type), intent(inout) :: study
      !> The exact friction model, and the exact model of the normal force.
      integer, intent(in) :: friction, exact_normal
      !> Those of the normal force.
      integer, intent(in) :: normal(:)
      type(creep_model_type), allocatable :: table(:)
      integer :: i, j, n, exact

      table = creep_models()
      associate (scene => study%scene, creep => study%cost%creep)
         exact = findloc(table%info%name == exact_creep, .true., dim=1)
         if (all(creep /= exact)) exact = findloc(table%info%name == default_creep, .true., dim=1)
         n = size(creep)*size(normal) + 1
         if (any(creep == exact) .and. any(normal == exact_normal)) n = n - 1
         allocate(study%models(n))
         study%models(1) = new_model(scene, friction, exact_normal)
         call set_creep(study%models(1), table, exact)
         study%models(1)%runs = .false.
         n = 1
         do j = 1, size(normal)
            do i = 1, size(creep)
               if (creep(i) == exact .and. normal(j) == exact_normal) then
                  study%models(1)%runs = .true.
                  cycle
               end if
               n = n + 1
               study%models(n) = new_model(scene, friction, normal(j))
               call set_creep(study%models(n), table, creep(i))
            end do
         end do
      end associate
   end subroutine plan_creep

   !> Give the contacts of a model that roll a law of creep.
   subroutine set_creep(model, table, law)
      type(model_type), intent(inout) :: model
      type(creep_model_type), intent(in) :: table(:)
      !> Its position in the table.
      integer, intent(in) :: law
      integer :: i

      model%name = model%name // "+" // trim(table(law)%info%name)
      do i = 1, size(model%scene%contacts)
         associate (contact => model%scene%contacts(i))
            if (creeps(contact)) call contact%parameters%set(creep_key, real(law, wp))
         end associate
      end do
   end subroutine set_creep

   !> Give the contacts of a model that remember a number of layers.
   subroutine set_layers(model, layers)
      type(model_type), intent(inout) :: model
      !> The number; 0 for one spring.
      integer, intent(in) :: layers
      type(tangential_model_type), allocatable :: table(:)
      character(len=7) :: kind
      integer :: i

      table = tangential_models()
      kind = merge("spring ", "elastic", layers == 0)
      model%name = model%name // "+" // trim(kind)
      if (layers > 0) model%name = model%name // "_" // to_text(layers)
      do i = 1, size(model%scene%contacts)
         associate (contact => model%scene%contacts(i))
            if (.not. remembers(contact%tangential)) cycle
            contact%tangential = findloc(table%info%name, kind, dim=1)
            if (layers > 0) call contact%parameters%set("layers", real(layers, wp))
         end associate
      end do
   end subroutine set_layers

   !> A model: the scene with other parts.
   function new_model(scene, friction, normal, spot) result(model)
      type(scene_type), intent(in) :: scene
      !> Friction, index into `friction_models`; 0 for that of each contact.
      integer, intent(in) :: friction
      !> Normal force, index into `normal_models`; 0 for that of each contact.
      integer, intent(in) :: normal
      !> What curved spots become, index into `curvature_models`; curved by default, within the
      !> scene's bound or that of a scene without one. Other laws of friction have flat ones alone.
      integer, intent(in), optional :: spot
      type(model_type) :: model
      type(friction_model_type), allocatable :: table(:)
      type(normal_model_type), allocatable :: normals(:)
      type(curvature_model_type), allocatable :: spots(:)
      integer :: i, curvature

      table = friction_models()
      normals = normal_models()
      spots = curvature_models()
      model%scene = scene
      model%name = "scene"
      if (friction > 0) model%name = trim(table(friction)%info%name)
      if (normal > 0 .and. friction > 0) then
         model%name = model%name // "+" // trim(normals(normal)%info%name)
      else if (normal > 0) then
         model%name = trim(normals(normal)%info%name)
      end if
      curvature = spot_curved
      if (present(spot)) curvature = spot
      if (curvature /= spot_curved .and. any(scene%contacts%curvature /= spot_flat)) then
         model%name = model%name // "+" // trim(spots(curvature)%info%name)
      end if
      do i = 1, size(scene%contacts)
         associate (contact => model%scene%contacts(i))
            if (friction > 0 .and. table(contact%friction)%acts) then
               contact%friction = friction
            end if
            if (normal > 0) contact%normal = normal
            if (contact%curvature /= spot_flat) contact%curvature = curvature
         end associate
      end do
   end function new_model

   !> Reference of each model, checked by a second method.
   subroutine compute_references(study, references, onlooker, stopped)
      type(study_type), intent(inout) :: study
      !> The references, one for each model.
      type(reference_type), allocatable, intent(out) :: references(:)
      class(onlooker_type), intent(inout), target :: onlooker
      !> Whether a signal came.
      logical, intent(out) :: stopped
      type(reference_type), allocatable :: checks(:)
      real(wp) :: rtol
      integer :: i

      rtol = study%cost%reference_rtol
      stopped = .false.
      allocate(references(size(study%models)), checks(size(study%models)))
      do i = 1, size(study%models)
         call onlooker%stage("reference " // to_text(i) // " of " // &
            to_text(size(study%models)) // ", " // study%models(i)%name)
         call one_reference(study%models(i), rtol, onlooker, references(i), checks(i), stopped)
         if (stopped) exit
      end do
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
   subroutine one_reference(model, rtol, onlooker, reference, check, stopped)
      type(model_type), intent(inout) :: model
      !> Relative tolerance [-].
      real(wp), intent(in) :: rtol
      class(onlooker_type), intent(inout), target :: onlooker
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
         call run_reference(model%scene, trim(reference_methods(i)), rtol, limit, onlooker, &
            candidate, trial)
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
         call run_reference(model%scene, trim(reference%method), looser*rtol, limit, onlooker, &
            check, trial)
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
   subroutine compute_runs(study, references, onlooker, stopped)
      type(study_type), intent(inout) :: study
      type(reference_type), intent(in), target :: references(:)
      class(onlooker_type), intent(inout), target :: onlooker
      !> Whether a signal came.
      logical, intent(out) :: stopped
      real(wp) :: share
      integer :: i, j, k, n, round

      associate (cost => study%cost, models => study%models)
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
         do round = 1, cost%repeats
            do i = 1, n
               share = real((round - 1)*n + i - 1, wp)/real(n*cost%repeats, wp)
               call onlooker%tell(share, i, n, round, cost%repeats)
               call one_run(study%runs(i), models(study%runs(i)%model), cost%cpu_limit, round, &
                  references(study%runs(i)%model), references(1), onlooker)
               stopped = study%runs(i)%trial%outcome == outcome_stopped .or. onlooker%stops()
               if (stopped) exit
            end do
            if (stopped) exit
         end do
      end associate
   end subroutine compute_runs

   subroutine one_run(run, model, cpu_limit, round, own, exact, onlooker)
      type(run_type), intent(inout) :: run
      type(model_type), intent(in) :: model
      !> Longest run, in CPU times of the reference [-].
      real(wp), intent(in) :: cpu_limit
      integer, intent(in) :: round
      !> Reference of the model.
      type(reference_type), intent(in), target :: own
      !> Reference of the exact model.
      type(reference_type), intent(in), target :: exact
      class(onlooker_type), intent(inout), target :: onlooker

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
         max(least_limit, cpu_limit*model%cpu), own, exact, onlooker, run%trial)
      if (run%trial%outcome == outcome_slow) run%trial%message = "given up after " // &
         number_text(run%trial%cpu, 3) // " s of CPU"
   end subroutine one_run

   !> The one error of a motion: the largest of the scaled errors of the quantities that count; NaN
   !> if the events count and differ.
   pure function scaled_error(study, distance, energy) result(error)
      type(study_type), intent(in) :: study
      !> Distance of the motion to its reference.
      type(distance_type), intent(in) :: distance
      !> Residual of its energy balance [J].
      real(wp), intent(in) :: energy
      real(wp) :: error
      integer :: k

      error = 0.0_wp
      associate (cost => study%cost, scales => study%scales)
         do k = 1, kinds
            if (cost%counts(k)) error = max(error, distance%value(cost%measure, k)/scales(k))
         end do
         if (cost%counts(kinds + 1)) error = max(error, distance%events/scales(kinds + 1))
         if (cost%counts(kinds + 2)) error = max(error, energy/scales(kinds + 2))
         if (cost%counts(kinds + 1) .and. .not. distance%same_events) error = &
            ieee_value(error, ieee_quiet_nan)
      end associate
   end function scaled_error

   !> Errors of all runs, and the Pareto front.
   subroutine judge_runs(study)
      !> The study; models and runs are complete.
      type(study_type), intent(inout) :: study
      logical :: known(size(study%runs))
      integer :: i, j

      do i = 1, size(study%runs)
         associate (run => study%runs(i), model => study%models(study%runs(i)%model), &
            exact => study%models(1))
            run%numerical = ieee_value(run%numerical, ieee_quiet_nan)
            run%error = run%numerical
            run%bound = run%numerical
            run%resolved = .false.
            run%pareto = .false.
            known(i) = .false.
            if (run%trial%outcome /= outcome_done .or. allocated(model%problem)) cycle
            run%numerical = scaled_error(study, run%trial%own, run%trial%energy)
            if (ieee_is_finite(run%numerical) .and. ieee_is_finite(model%agreement_error)) then
               run%resolved(1) = run%numerical > model%agreement_error
            end if
            if (allocated(exact%problem)) cycle
            run%error = scaled_error(study, run%trial%total, run%trial%energy)
            ! References that do not agree on the events resolve nothing.
            if (.not. ieee_is_finite(run%error) .or. &
               .not. ieee_is_finite(exact%agreement_error)) then
               cycle
            end if
            run%resolved(2) = run%error > exact%agreement_error
            run%bound = max(run%error, exact%agreement_error)
            known(i) = .true.
         end associate
      end do
      do i = 1, size(study%runs)
         if (.not. known(i)) cycle
         associate (run => study%runs(i))
            run%pareto = .true.
            do j = 1, size(study%runs)
               if (j == i .or. .not. known(j)) cycle
               associate (other => study%runs(j))
                  if (other%trial%cpu <= run%trial%cpu .and. other%bound <= run%bound .and. &
                     (other%trial%cpu < run%trial%cpu .or. other%bound < run%bound .or. j < i)) then
                     run%pareto = .false.
                  end if
               end associate
            end do
         end associate
      end do
   end subroutine judge_runs

   !> The cheapest run whose error is within a bound; 0 for none.
   pure integer function cheapest(study, largest)
      !> The study, judged.
      type(study_type), intent(in) :: study
      !> Largest scaled error [-].
      real(wp), intent(in) :: largest
      integer :: i

      cheapest = 0
      do i = 1, size(study%runs)
         if (.not. ieee_is_finite(study%runs(i)%bound)) cycle
         if (study%runs(i)%bound > largest) cycle
         if (cheapest > 0) then
            if (study%runs(i)%trial%cpu >= study%runs(cheapest)%trial%cpu) cycle
         end if
         cheapest = i
      end do
   end function cheapest

end module contensou_study_cost
