!> CVODE of SUNDIALS, stepped one step at a time. The only module that names SUNDIALS.
!>
!> `cvode_bdf`: variable-order BDF with a Newton iteration, whose matrix is dense for few unknowns
!> and sparse for many and comes from the problem's Jacobian if it has one; `cvode_adams`:
!> variable-order Adams-Moulton with a fixed-point iteration. The ways of a problem are unknowns
!> beside its own, in the error test and in the iteration.
!> A. C. Hindmarsh et al., ACM Trans. Math. Software 31 (2005) 363.
module contensou_integrate_cvode
   use, intrinsic :: iso_c_binding, only : c_associated, c_char, c_double, c_f_pointer, c_funloc, &
      c_int, c_int64_t, c_loc, c_long, c_null_char, c_null_ptr, c_ptr
   use fcvode_mod, only : CV_ADAMS, CV_BDF, CV_CONV_FAILURE, CV_ERR_FAILURE, CV_FIRST_RHSFUNC_ERR, &
      CV_LSETUP_FAIL, CV_ONE_STEP, CV_REPTD_RHSFUNC_ERR, CV_ROOT_RETURN, CV_TOO_MUCH_ACC, &
      CV_TSTOP_RETURN, CV_UNREC_RHSFUNC_ERR, FCVode, FCVodeCreate, FCVodeFree, &
      FCVodeGetCurrentOrder, FCVodeGetCurrentStep, FCVodeGetCurrentTime, FCVodeGetDky, &
      FCVodeGetErrWeights, FCVodeGetEstLocalErrors, FCVodeGetIntegratorStats, &
      FCVodeGetLastLinFlag, FCVodeGetLastStep, FCVodeGetNonlinSolvStats, FCVodeGetNumJacEvals, &
      FCVodeGetNumLinRhsEvals, FCVodeGetNumSteps, FCVodeGetRootInfo, FCVodeInit, FCVodeReInit, &
      FCVodeRootInit, FCVodeSetErrFile, FCVodeSetInitStep, &
      FCVodeSetJacEvalFrequency, FCVodeSetJacFn, FCVodeSetLinearSolver, &
      FCVodeSetLSetupFrequency, FCVodeSetMaxConvFails, FCVodeSetMaxErrTestFails, &
      FCVodeSetMaxHnilWarns, FCVodeSetMaxOrd, FCVodeSetMaxStep, FCVodeSetNoInactiveRootWarn, &
      FCVodeSetNonlinearSolver, FCVodeSetStabLimDet, FCVodeSetStopTime, FCVodeSetUserData, &
      FCVodeWFtolerances
   use fnvector_serial_mod, only : FN_VEnableFusedOps_Serial, FN_VMake_Serial
   use fsundials_context_mod, only : FSUNContext_Create, FSUNContext_Free
   use fsundials_linearsolver_mod, only : FSUNLinSolFree, SUNLinearSolver
   use fsundials_matrix_mod, only : FSUNMatDestroy, SUNMatrix
   use fsundials_nonlinearsolver_mod, only : FSUNNonlinSolFree, SUNNonlinearSolver
   use fsundials_nvector_mod, only : FN_VDestroy, FN_VGetArrayPointer, N_Vector
   use fsunlinsol_dense_mod, only : FSUNLinSol_Dense
   use fsunlinsol_klu_mod, only : FSUNLinSol_KLU, FSUNLinSol_KLUReInit, &
      FSUNLinSol_KLUSetOrdering
   use fsunmatrix_dense_mod, only : FSUNDenseMatrix, FSUNDenseMatrix_Data
   use fsunmatrix_sparse_mod, only : CSC_MAT, FSUNSparseMatrix, FSUNSparseMatrix_Data, &
      FSUNSparseMatrix_IndexPointers, FSUNSparseMatrix_IndexValues
   use fsunnonlinsol_fixedpoint_mod, only : FSUNNonlinSol_FixedPoint
   use contensou_base_errors, only : error_type, fatal, status_failed
   use contensou_base_kinds, only : i8, wp
   use contensou_base_numbers, only : to_text
   use contensou_integrate_integrator, only : graded, integrator_type, statistics_type
   use contensou_integrate_problem, only : least_event, problem_type, way_columns_of
   use contensou_integrate_step, only : zero_gap
   implicit none(type, external)
   private

   public :: cvode_type, sundials_version

   !> Ordering of KLU for matrices of nearly symmetric structure, as a body with many neighbours
   !> makes them: AMD; the default, COLAMD, fills the matrix of a ring with ten balls.
   integer(c_int), parameter :: minimum_degree = 0_c_int

   !> How to factorize next: with pivots of its own.
   integer(c_int), parameter :: other_pivots = 2_c_int

   !> What is admitted of how bodies in flight tumble, over what is else, where contacts remember:
   !> keeps the energy of random ellipsoids to 1e-8 at rtol 1e-8.
   real(wp), parameter :: part_in_flight = 1.0e-3_wp

   !> What the callbacks get to see.
   type :: handle_type
      class(problem_type), pointer :: problem => null()
      !> Whether the matrix of the Newton iteration is sparse.
      logical :: sparse = .false.
      !> Unknowns of the problem, and these with the ways that are integrated along.
      integer :: n = 0, n_all = 0
      !> Entries of the Jacobian of the problem.
      real(wp), allocatable :: entries(:)
      !> Entries of the whole matrix.
      real(wp), allocatable :: all_entries(:)
      !> Layout of the matrix, as that of a problem, and the places in it of the entries of the
      !> Jacobian of the problem and of those of the ways, 0 for none.
      integer, allocatable :: column_start(:), row(:), place(:), way_place(:, :)
      !> Memory of CVODE.
      type(c_ptr) :: memory = c_null_ptr
      !> Solver of a sparse matrix.
      type(SUNLinearSolver), pointer :: sparse_solver => null()
      !> Whether the time at which CVODE is to stop only shortens the step that begins.
      logical :: grading = .false.
      !> Time at which it is to stop else [s].
      real(wp) :: stop = 0.0_wp
      !> Whether the event functions are asked for where an integration begins.
      logical :: beginning = .false.
   end type handle_type

   !> Steps between two factorizations where the Jacobian is as old: CVODE's own choice.
   integer, parameter :: factorization_steps = 20

   !> SUNDIALS' true.
   integer(c_int), parameter :: sun_true = 1_c_int

   !> Number of unknowns from which on the matrix is sparse.
   integer, parameter :: sparse_from = 60

   !> Largest order of the BDF methods.
   integer(c_int), parameter :: largest_order = 5_c_int

   !> Largest of those that are stable for each decaying oscillation, whatever the step.
   integer(c_int), parameter :: stable_order = 2_c_int

   !> Largest order of Adams's method where a problem has ways: their tolerance is so small that
   !> what is left of differences of a higher order is rounding.
   integer(c_int), parameter :: order_with_ways = 4_c_int

   !> Steps without an event before `stable_order` is tried first.
   integer, parameter :: first_patience = 2000

   !> Steps before it is tried again after many trials in vain; a trial takes some 150 of them.
   integer, parameter :: largest_patience = 4000

   !> Steps over which the pace is taken.
   integer, parameter :: pace_steps = 200

   !> Steps of a trial before its pace is taken: a method that starts anew begins with short ones.
   integer, parameter :: trial_steps = 200

   !> The same where contacts stick elastically, at most: what rings is damped the faster, the
   !> longer the steps are that it allows.
   integer, parameter :: trial_steps_ringing = 1500

   !> Steps over which those of such a trial must grow, and by how much.
   integer, parameter :: growth_steps = 240
   real(wp), parameter :: growth = 1.1_wp

   !> Steps before such a trial is made again after many in vain.
   integer, parameter :: largest_patience_ringing = 32000

   !> Steps of a trial after which those must be half as long as before it.
   integer, parameter :: early_steps = 60

   !> By how much longer the steps must be for `stable_order` to be kept: they are short where the
   !> solution changes, and there a higher order is the better one.
   real(wp), parameter :: gain = 3.0_wp

   !> Steps without a path of account after which lengths need not be graded: CVODE sees less well
   !> what limits its stability, and that a step could be longer, where they are.
   integer, parameter :: soon = 1000

   !> Failures of one step in a row before CVODE gives up, and before it begins anew where lengths
   !> are graded.
   integer, parameter :: most_failures = 60, failures_at_order = 3

   !> A step that fails is shortened as by CVODE: by the root of its error times this, by the least
   !> and most of it, and by the least when it fails again.
   real(wp), parameter :: bias = 6.0_wp, least_decrease = 0.9_wp, most_decrease = 0.1_wp, &
      least_decrease_again = 0.2_wp

   !> Growth of a step, and by powers of two more: errors by which CVODE lets it grow are far below
   !> the tolerance and rounding in part.
   real(wp), parameter :: growth_once = 1.5_wp, edge_of_growth = 1.0e-3_wp

   !> Trials of a first step.
   integer, parameter :: most_guesses = 4

   !> Share of the step whose second-order term is of the size of the tolerance: it may begin at a
   !> touch, where forces are not smooth.
   real(wp), parameter :: first_share = 0.05_wp

   !> One integration.
   type, extends(integrator_type) :: cvode_type
      private
      !> Memory of CVODE.
      type(c_ptr) :: memory = c_null_ptr
      !> SUNDIALS context, one per integration.
      type(c_ptr) :: context = c_null_ptr
      type(handle_type), pointer :: handle => null()
      real(c_double), pointer, contiguous :: y(:) => null()
      !> Space for interpolation.
      real(c_double), pointer, contiguous :: y_between(:) => null()
      !> Vector of `y`.
      type(N_Vector), pointer :: vector => null()
      !> Vector of `y_between`.
      type(N_Vector), pointer :: vector_between => null()
      !> Matrix of the Newton iteration.
      type(SUNMatrix), pointer :: matrix => null()
      type(SUNLinearSolver), pointer :: linear_solver => null()
      !> Fixed-point iteration.
      type(SUNNonlinearSolver), pointer :: fixed_point => null()
      !> Counters of earlier starts.
      type(statistics_type) :: before
      !> End of time [s].
      real(wp) :: t_end = 0.0_wp
      !> Steps in a row that did not advance time.
      integer :: standstill = 0
      !> Whether the order is variable up to 5 and 2 may be tried.
      logical :: bdf = .false.
      !> Whether the order is limited to `stable_order`.
      logical :: limited = .false.
      !> Whether the Jacobian is renewed in each step.
      logical :: renews = .false.
      !> Whether the limit is to be changed before the next step.
      logical :: change = .false.
      !> Whether the next step's length is not told, as an event was met within the last step.
      logical :: untold = .false.
      !> Length of the step that is tried, where lengths are graded [s].
      real(wp) :: tried = 0.0_wp
      !> Whether it failed, whether CVODE returns then, and whether it is the first one of all.
      logical :: failed = .false., fails_at_once = .false., beginning = .false.
      !> Steps before it.
      integer(c_long) :: steps_before = 0
      !> Steps since the last event or change of the limit.
      integer :: since = 0
      !> Steps without an event before the next trial.
      integer :: patience = first_patience
      !> Time from which on the pace is taken [s].
      real(wp) :: t_pace = 0.0_wp
      !> Length of the steps of a trial where contacts stick elastically, when last looked at [s].
      real(wp) :: pace_of_trial = 0.0_wp
      !> Mean step before the trial [s].
      real(wp) :: pace = 0.0_wp
   contains
      procedure, public :: start
      procedure, public :: step
      procedure, public :: interpolate
      procedure, public :: interpolate_rate
      procedure, public :: restart
      procedure, public :: bound_step
      procedure, public :: statistics
      procedure, public :: free
   end type cvode_type

   interface
      !> Version as text; not among the Fortran modules of SUNDIALS.
      function get_version(text, length) result(flag) bind(c, name="SUNDIALSGetVersion")
         import :: c_char, c_int
         implicit none(type, external)
         !> The text, ended by a zero byte.
         character(len=1, kind=c_char), intent(out) :: text(*)
         !> Bytes of it.
         integer(c_int), intent(in), value :: length
         integer(c_int) :: flag
      end function get_version
   end interface

contains

   !> Version of SUNDIALS that is linked.
   function sundials_version() result(text)
      character(len=:), allocatable :: text
      character(len=32, kind=c_char) :: buffer
      integer :: last

      buffer = ""
      if (get_version(buffer, len(buffer)) /= 0) buffer = "unknown"
      last = index(buffer, c_null_char) - 1
      if (last < 0) last = len_trim(buffer)
      text = buffer(:last)
   end function sundials_version

   !> Begin an integration.
   subroutine start(self, problem, method, t, y, t_end, max_step, error)
      class(cvode_type), intent(inout) :: self
      !> The problem; must outlive the integration.
      class(problem_type), intent(in), target :: problem
      !> `cvode_bdf` or `cvode_adams`.
      character(len=*), intent(in) :: method
      !> Initial time [s].
      real(wp), intent(in) :: t
      !> Initial state.
      real(wp), intent(in) :: y(:)
      !> The right-hand side is never evaluated beyond this time [s].
      real(wp), intent(in) :: t_end
      !> Largest step [s]; 0 for no bound.
      real(wp), intent(in) :: max_step
      !> Set when CVODE cannot be set up.
      type(error_type), allocatable, intent(out) :: error
      integer(c_int) :: flag
      integer :: n

      call self%free()
      n = problem%n + problem%n_ways
      allocate(self%handle)
      self%handle%problem => problem
      self%handle%n = problem%n
      self%handle%n_all = n
      self%t_end = t_end
      self%bdf = method /= "cvode_adams"
      self%free_interpolation = .true.
      allocate(self%y(n), self%y_between(n))
      self%y(:problem%n) = y
      self%y(problem%n + 1:) = 0.0_wp
      flag = FSUNContext_Create(c_null_ptr, self%context)
      self%vector => FN_VMake_Serial(int(n, i8), self%y, self%context)
      self%vector_between => FN_VMake_Serial(int(n, i8), self%y_between, self%context)
      ! CVODE's own vectors are made after this one: a step combines up to six of them in one pass.
      flag = min(flag, FN_VEnableFusedOps_Serial(self%vector, sun_true))
      self%memory = FCVodeCreate(merge(CV_ADAMS, CV_BDF, method == "cvode_adams"), self%context)
      if (flag /= 0 .or. .not. c_associated(self%memory)) then
         call fatal(error, "CVODE could not be set up", status_failed)
         return
      end if
      self%handle%memory = self%memory
      flag = FCVodeSetErrFile(self%memory, c_null_ptr)
      flag = min(flag, FCVodeInit(self%memory, c_funloc(derivative_callback), t, self%vector))
      flag = min(flag, FCVodeSetUserData(self%memory, c_loc(self%handle)))
      flag = min(flag, FCVodeWFtolerances(self%memory, c_funloc(weights_callback)))
      if (method == "cvode_adams") then
         self%fixed_point => FSUNNonlinSol_FixedPoint(self%vector, 0, self%context)
         flag = min(flag, FCVodeSetNonlinearSolver(self%memory, self%fixed_point))
      else
         call self%handle%problem%lay_out_jacobian()
         self%handle%sparse = allocated(problem%row) .and. n >= sparse_from
         if (allocated(problem%row)) call lay_out_matrix(self%handle)
         if (self%handle%sparse) then
            self%matrix => FSUNSparseMatrix(int(n, i8), int(n, i8), &
               size(self%handle%row, kind=i8), CSC_MAT, self%context)
            self%linear_solver => FSUNLinSol_KLU(self%vector, self%matrix, self%context)
            flag = min(flag, FSUNLinSol_KLUSetOrdering(self%linear_solver, minimum_degree))
            self%handle%sparse_solver => self%linear_solver
         else
            self%matrix => FSUNDenseMatrix(int(n, i8), int(n, i8), self%context)
            self%linear_solver => FSUNLinSol_Dense(self%vector, self%matrix, self%context)
         end if
         flag = min(flag, FCVodeSetLinearSolver(self%memory, self%linear_solver, self%matrix))
         if (allocated(problem%row)) then
            allocate(self%handle%entries(size(problem%row)))
            allocate(self%handle%all_entries(size(self%handle%row)))
            flag = min(flag, FCVodeSetJacFn(self%memory, c_funloc(jacobian_callback)))
         end if
         flag = min(flag, renew_jacobian(self, problem%jacobian_steps))
      end if
      if (.not. self%bdf .and. problem%n_ways > 0) flag = min(flag, FCVodeSetMaxOrd(self%memory, &
         order_with_ways))
      if (problem%n_events > 0) flag = min(flag, FCVodeRootInit(self%memory, &
         int(problem%n_events, c_int), c_funloc(events_callback)))
      if (self%bdf .and. problem%remembers) flag = min(flag, FCVodeSetStabLimDet(self%memory, &
         sun_true))
      flag = min(flag, FCVodeSetNoInactiveRootWarn(self%memory))
      flag = min(flag, FCVodeSetMaxHnilWarns(self%memory, -1_c_int))
      ! From free flight into a stiff contact the step shrinks by many orders of magnitude.
      flag = min(flag, FCVodeSetMaxErrTestFails(self%memory, int(most_failures, c_int)))
      flag = min(flag, FCVodeSetMaxConvFails(self%memory, int(most_failures, c_int)))
      flag = min(flag, FCVodeSetStopTime(self%memory, min(t_end, self%t_stop)))
      call self%bound_step(max_step)
      if (problem%remembers) then
         flag = min(flag, begin_graded(self, t, y))
         self%handle%beginning = .true.
         self%beginning = .true.
      end if
      if (flag < 0) call fatal(error, "CVODE could not be set up", status_failed)
   end subroutine start

   !> Let a Jacobian last for some steps.
   integer(c_int) function renew_jacobian(self, steps) result(flag)
      class(cvode_type), intent(in) :: self
      integer, intent(in) :: steps

      ! It is renewed at factorizations only.
      flag = FCVodeSetJacEvalFrequency(self%memory, int(steps, c_long))
      flag = min(flag, FCVodeSetLSetupFrequency(self%memory, &
         int(min(steps, factorization_steps), c_long)))
   end function renew_jacobian

   !> Advance by one step, or to the next event within it.
   subroutine step(self, t, y, events, error)
      class(cvode_type), intent(inout) :: self
      !> Time reached [s].
      real(wp), intent(inout) :: t
      real(wp), intent(out) :: y(:)
      !> For each event function: 1 it rose through zero here, -1 it fell, 0 no event.
      integer, intent(out) :: events(:)
      !> Set when the integration cannot go on; its message says why in CVODE's terms.
      type(error_type), allocatable, intent(out) :: error
      integer(c_int) :: flag
      integer(c_long) :: steps(1)
      real(c_double) :: reached(1)

      events = 0
      if (self%change) then
         self%change = .false.
         self%limited = .not. self%limited
         y = self%y(:self%handle%n)
         call self%restart(t, y, error)
         if (allocated(error)) return
      end if
      if (associated(self%matrix) .and. (self%steep .neqv. self%renews)) then
         self%renews = self%steep
         flag = renew_jacobian(self, merge(1, self%handle%problem%jacobian_steps, self%renews))
      end if
      if (self%handle%problem%remembers) then
         flag = grade(self)
         flag = FCVodeGetNumSteps(self%memory, steps)
         self%steps_before = steps(1)
      end if
      reached = t
      flag = FCVode(self%memory, self%t_end, self%vector, reached, CV_ONE_STEP)
      if (self%fails_at_once) call try_again(self, t, reached, flag)
      y = self%y(:self%handle%n)
      if (self%handle%problem%remembers .and. flag >= 0) then
         if (FCVodeGetNumSteps(self%memory, steps) >= 0) then
            if (steps(1) /= self%steps_before) self%untold = flag == CV_ROOT_RETURN
         end if
         self%beginning = .false.
      end if
      if (flag == CV_ROOT_RETURN) flag = take_roots(self%memory, events)
      if (flag >= 0) then
         ! A spacing is two calls of the library, and no larger than this.
         if (reached(1) - t > 16.0_wp*max(epsilon(t)*abs(t), tiny(t)) .or. any(events /= 0)) then
            self%standstill = 0
         else
            self%standstill = merge(0, self%standstill + 1, reached(1) - t > 16.0_wp*spacing(t))
         end if
         if (self%standstill > 1000) call fatal(error, &
            "the step size fell below the resolution of time", status_failed)
         t = reached(1)
         associate (problem => self%handle%problem)
            if (self%bdf .and. (problem%settles .or. .not. problem%remembers)) call watch_order( &
               self, t, any(events /= 0))
         end associate
      else
         call fatal(error, trim(reason(flag)), status_failed)
      end if
   end subroutine step

   !> Take a step that failed again, in graded lengths: those that CVODE finds depend on what its
   !> estimates are rounded by, and so on the directions of the axes.
   subroutine try_again(self, t, reached, flag)
      class(cvode_type), intent(inout) :: self
      !> Time at which the step begins [s].
      real(wp), intent(in) :: t
      !> Time reached [s].
      real(c_double), intent(inout) :: reached(1)
      !> What CVODE returned.
      integer(c_int), intent(inout) :: flag
      type(error_type), allocatable :: error
      integer(c_long) :: steps(1)
      real(wp) :: y(self%handle%n), shorter
      integer :: failures

      self%failed = flag == CV_ERR_FAILURE
      do failures = 1, most_failures - 1
         if (flag /= CV_ERR_FAILURE) return
         shorter = graded(self%tried*decrease(self, failures))
         if (failures == failures_at_order) then
            ! With the lowest order, as CVODE comes to.
            y = self%y(:self%handle%n)
            call self%restart(t, y, error)
            if (allocated(error)) return
            self%failed = .true.
         end if
         self%tried = shorter
         flag = FCVodeGetNumSteps(self%memory, steps)
         if (steps(1) > 0) then
            self%handle%grading = .true.
            flag = FCVodeSetStopTime(self%memory, min(self%handle%stop, t + shorter))
         else
            flag = FCVodeSetInitStep(self%memory, shorter)
            self%handle%beginning = self%beginning
         end if
         flag = FCVode(self%memory, self%t_end, self%vector, reached, CV_ONE_STEP)
      end do
   end subroutine try_again

   !> By what a step that failed is shortened, as CVODE does it.
   real(wp) function decrease(self, failures)
      class(cvode_type), intent(inout) :: self
      !> Failures of it in a row.
      integer, intent(in) :: failures
      real(wp) :: weight(size(self%y))
      integer(c_int) :: flag, order(1)

      decrease = most_decrease
      if (failures >= failures_at_order) return
      flag = FCVodeGetErrWeights(self%memory, self%vector_between)
      weight = self%y_between
      flag = min(flag, FCVodeGetEstLocalErrors(self%memory, self%vector_between), &
         FCVodeGetCurrentOrder(self%memory, order))
      if (flag < 0) return
      decrease = (bias*rms(self%y_between*weight))**(-1.0_wp/real(order(1) + 1, wp))
      decrease = max(most_decrease, min(decrease, merge(least_decrease, least_decrease_again, &
         failures == 1)))
   end function decrease

   !> Which event functions are zero at a root. Apart, as the room that it takes is allocated, which
   !> other steps would pay for.
   integer(c_int) function take_roots(memory, events) result(flag)
      !> Memory of CVODE.
      type(c_ptr), intent(in) :: memory
      !> For each event function: 1 it rose through zero here, -1 it fell, 0 no event.
      integer, intent(out) :: events(:)
      integer(c_int) :: found(size(events))

      flag = FCVodeGetRootInfo(memory, found)
      events = int(found)
   end function take_roots

   !> Decide which orders are used from the next step on.
   !>
   !> BDF of orders 3 to 5 is not stable for oscillations that hardly decay, as of a body at rest on
   !> a lightly damped contact: the order stays high and the steps short because the error of the
   !> higher orders, which rings, looks small. Whether order 2 takes longer steps is tried after a
   !> while without events; it is kept while it does. CVODE's own detection, used for what sticks
   !> elastically, misses some of these; it is left alone where such a contact rolls with creep.
   subroutine watch_order(self, t, event)
      class(cvode_type), intent(inout) :: self
      !> Time reached [s].
      real(wp), intent(in) :: t
      logical, intent(in) :: event
      real(wp) :: pace
      integer :: trial

      trial = merge(trial_steps_ringing, trial_steps, self%handle%problem%remembers)
      self%since = self%since + 1
      self%steps_of_trial = max(self%steps_of_trial - 1, 0)
      if (event) then
         self%change = self%limited
         self%since = 0
         self%patience = first_patience
      else if (.not. self%limited) then
         if (self%since == self%patience - pace_steps) self%t_pace = t
         if (self%since < self%patience) return
         self%pace = (t - self%t_pace)/pace_steps
         self%change = self%pace > 0.0_wp
         self%since = 0
         self%steps_of_trial = trial + pace_steps
      else if (self%since == early_steps) then
         self%t_pace = t
         self%pace_of_trial = 0.0_wp
      else if (self%handle%problem%remembers .and. self%since < trial) then
         if (mod(self%since - early_steps, growth_steps) /= 0) return
         pace = (t - self%t_pace)/growth_steps
         self%t_pace = t
         ! What moves as the accuracy wants, or rings without decay, does so at a steady pace.
         if (pace < min(growth*self%pace_of_trial, gain*self%pace)) call give_up()
         self%pace_of_trial = pace
      else if (self%since == 2*early_steps .and. &
         t - self%t_pace < 0.5_wp*early_steps*self%pace) then
         ! An oscillation that does not decay: each step at a low order adds to it.
         call give_up()
      else if (self%since == trial) then
         self%t_pace = t
      else if (self%since == trial + pace_steps) then
         ! Looked at again and again.
         self%since = trial
         if ((t - self%t_pace)/pace_steps < gain*self%pace) call give_up()
         self%t_pace = t
      end if

   contains

      !> Back to all orders, and a longer time until the next trial.
      subroutine give_up()
         self%change = .true.
         self%since = 0
         self%patience = min(2*self%patience, merge(largest_patience_ringing, &
            largest_patience, self%handle%problem%remembers))
         self%steps_of_trial = trial
      end subroutine give_up

   end subroutine watch_order

   !> State at a time within the last step.
   subroutine interpolate(self, t, y)
      class(cvode_type), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(out) :: y(:)
      integer(c_int) :: flag

      flag = FCVodeGetDky(self%memory, t, 0_c_int, self%vector_between)
      y = self%y_between(:self%handle%n)
      if (flag < 0) y = self%y(:self%handle%n)
   end subroutine interpolate

   !> Time derivative of the state within the last step.
   subroutine interpolate_rate(self, t, rate, known)
      class(cvode_type), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> The derivative; only set if it is known.
      real(wp), intent(inout) :: rate(:)
      !> Whether it is known.
      logical, intent(out) :: known

      known = .false.
      if (.not. self%bdf) return
      known = FCVodeGetDky(self%memory, t, 1_c_int, self%vector_between) >= 0
      if (known) rate = self%y_between(:self%handle%n)
   end subroutine interpolate_rate

   !> Begin anew at a state after the right-hand side has changed.
   subroutine restart(self, t, y, error)
      class(cvode_type), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)
      !> Set when CVODE refuses.
      type(error_type), allocatable, intent(out) :: error
      integer(c_int) :: flag

      self%before = self%statistics()
      self%untold = .false.
      self%failed = .false.
      self%steps_before = -1
      self%y(:self%handle%n) = y
      self%y(self%handle%n + 1:) = 0.0_wp
      flag = 0
      if (self%bdf) flag = FCVodeSetMaxOrd(self%memory, merge(stable_order, largest_order, &
         self%limited))
      flag = min(flag, FCVodeReInit(self%memory, t, self%vector))
      flag = min(flag, FCVodeSetStopTime(self%memory, min(self%t_end, &
         self%t_stop)))
      if (self%handle%problem%remembers) flag = min(flag, begin_graded(self, t, y))
      if (flag < 0) call fatal(error, "CVODE could not be started again", status_failed)
   end subroutine restart

   !> Set the first step, graded: CVODE's own depends on the directions of the axes. It is a
   !> share of that whose second-order term is of the size of the tolerance, sought as CVODE does.
   integer(c_int) function begin_graded(self, t, y) result(flag)
      class(cvode_type), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)
      real(wp), dimension(size(y)) :: weight, rate, rate_there
      real(wp) :: span, shortest, longest, h, h_new, bend
      logical :: outside
      integer :: i

      flag = 0
      associate (problem => self%handle%problem)
         span = min(self%t_end, self%t_stop) - t
         call problem%derivative(t, y, rate, outside)
         self%before%derivatives = self%before%derivatives + 1
         if (outside .or. .not. span > 0.0_wp) return
         ! The first error weights need them.
         if (size(self%y) > size(y)) call problem%way_rates(self%y_between(size(y) + 1:))
         call problem%admissible_error(y, weight)
         weight = 1.0_wp/weight
         shortest = 100.0_wp*max(spacing(t), epsilon(span)*span)
         longest = 0.1_wp*span
         longest = min(longest, (0.1_wp*rms(y*weight) + 1.0_wp)/max(rms(rate*weight), tiny(h)))
         longest = max(longest, shortest)
         h = sqrt(shortest*longest)
         do i = 1, most_guesses
            call problem%derivative(t + h, y + h*rate, rate_there, outside)
            self%before%derivatives = self%before%derivatives + 1
            if (outside) then
               h = max(0.2_wp*h, shortest)
               cycle
            end if
            bend = rms((rate_there - rate)*weight)/h
            h_new = sqrt(h*longest)
            if (bend*longest**2 > 2.0_wp) h_new = sqrt(2.0_wp/bend)
            if (h_new > 0.5_wp*h .and. h_new < 2.0_wp*h) exit
            h = min(max(h_new, shortest), longest)
         end do
      end associate
      self%tried = graded(min(max(first_share*h, shortest), longest))
      flag = FCVodeSetInitStep(self%memory, self%tried)
   end function begin_graded

   !> Root of the mean of the squares.
   pure real(wp) function rms(values)
      real(wp), intent(in) :: values(:)

      rms = sqrt(dot_product(values, values)/size(values))
   end function rms

   !> Let the next step be graded: CVODE shortens it to end at a given time. When it has done so the
   !> error weights are asked for, and the time is taken back: having stopped at one CVODE would not
   !> tell the length of the step after it.
   integer(c_int) function grade(self) result(flag)
      class(cvode_type), intent(inout) :: self
      real(c_double) :: h(1), t(1), last(1)
      integer(c_long) :: steps(1)
      real(wp) :: stop, longest

      associate (handle => self%handle)
         handle%stop = min(self%t_end, self%t_stop)
         handle%grading = .false.
         stop = handle%stop
         flag = min(FCVodeGetCurrentStep(self%memory, h), FCVodeGetCurrentTime(self%memory, t), &
            FCVodeGetNumSteps(self%memory, steps), FCVodeGetLastStep(self%memory, last))
         ! One that is not told is no longer than the last one.
         if (self%untold) h = last
         self%failed = self%failed .and. self%impact
         if (self%impact .neqv. self%fails_at_once) then
            ! In an impact a step that fails is taken again here, in graded lengths.
            self%fails_at_once = self%impact
            flag = min(flag, FCVodeSetMaxErrTestFails(self%memory, int(merge(1, most_failures, &
               self%impact), c_int)))
            ! From norms that hardly change there rounding decides whether a limit of stability is
            ! found, which lowers the order and shortens the step.
            if (self%bdf) flag = min(flag, FCVodeSetStabLimDet(self%memory, merge(0_c_int, &
               sun_true, self%impact)))
         end if
         if (flag >= 0 .and. steps(1) > 0) then
            longest = self%reach
            if (self%failed) then
               longest = min(longest, self%tried)
            else if (self%impact .and. h(1) > growth_once*last(1)) then
               longest = min(longest, last(1)*growth_once*2.0_wp**floor(edge_of_growth + &
                  log(h(1)/(growth_once*last(1)))/log(2.0_wp)))
            end if
            self%tried = min(h(1), stop - t(1))
            if (self%steps_of_no_path < soon .or. longest < h(1)) then
               self%tried = graded(min(h(1), longest))
               ! What differs by rounding is graded.
               handle%grading = self%untold .or. h(1) > self%tried*(1.0_wp + 1.0e-9_wp)
               if (handle%grading) stop = min(stop, t(1) + self%tried)
            end if
         end if
         flag = FCVodeSetStopTime(self%memory, stop)
      end associate
   end function grade

   subroutine bound_step(self, max_step)
      class(cvode_type), intent(inout) :: self
      !> Largest step [s]; 0 for no bound.
      real(wp), intent(in) :: max_step
      integer(c_int) :: flag

      flag = FCVodeSetMaxStep(self%memory, max_step)
      if (flag < 0) flag = FCVodeSetMaxStep(self%memory, 0.0_wp)
   end subroutine bound_step

   !> Counters so far.
   function statistics(self) result(s)
      class(cvode_type), intent(in) :: self
      type(statistics_type) :: s
      integer(c_long) :: steps(1), derivatives(1), setups(1), failures(1), iterations(1)
      integer(c_long) :: convergence(1), jacobians(1), linear(1)
      integer(c_int) :: last_order(1), current_order(1), flag
      real(c_double) :: first_step(1), last_step(1), current_step(1), current_time(1)

      s = self%before
      if (.not. c_associated(self%memory)) return
      flag = FCVodeGetIntegratorStats(self%memory, steps, derivatives, setups, failures, &
         last_order, current_order, first_step, last_step, current_step, current_time)
      if (flag < 0) return
      flag = FCVodeGetNonlinSolvStats(self%memory, iterations, convergence)
      jacobians = 0
      linear = 0
      if (associated(self%matrix)) then
         flag = FCVodeGetNumJacEvals(self%memory, jacobians)
         flag = FCVodeGetNumLinRhsEvals(self%memory, linear)
      end if
      s%steps = s%steps + steps(1)
      s%derivatives = s%derivatives + derivatives(1) + linear(1)
      s%jacobians = s%jacobians + jacobians(1)
      s%error_test_failures = s%error_test_failures + failures(1)
      s%convergence_failures = s%convergence_failures + convergence(1)
      s%last_step = last_step(1)
   end function statistics

   !> Release everything.
   subroutine free(self)
      class(cvode_type), intent(inout) :: self
      integer(c_int) :: flag

      if (c_associated(self%memory)) call FCVodeFree(self%memory)
      if (associated(self%linear_solver)) flag = FSUNLinSolFree(self%linear_solver)
      if (associated(self%matrix)) call FSUNMatDestroy(self%matrix)
      if (associated(self%fixed_point)) flag = FSUNNonlinSolFree(self%fixed_point)
      if (associated(self%vector)) call FN_VDestroy(self%vector)
      if (associated(self%vector_between)) call FN_VDestroy(self%vector_between)
      if (c_associated(self%context)) flag = FSUNContext_Free(self%context)
      if (associated(self%handle)) deallocate(self%handle)
      if (associated(self%y)) deallocate(self%y, self%y_between)
      self%memory = c_null_ptr
      self%context = c_null_ptr
      nullify(self%linear_solver, self%matrix, self%fixed_point, self%vector, self%vector_between)
      self%before = statistics_type()
      self%standstill = 0
      self%limited = .false.
      self%untold = .false.
      self%fails_at_once = .false.
      self%renews = .false.
      self%change = .false.
      self%since = 0
      self%patience = first_patience
   end subroutine free

   !> A return flag of CVODE in words; of a fixed length, as threads fail at the same time.
   pure function reason(flag) result(words)
      !> Return flag.
      integer(c_int), intent(in) :: flag
      character(len=80) :: words

      select case (flag)
      case (CV_TOO_MUCH_ACC)
         words = "the tolerance is below what double precision can resolve"
      case (CV_ERR_FAILURE)
         words = "the local error stays above the tolerance however small the step"
      case (CV_CONV_FAILURE, CV_LSETUP_FAIL)
         words = "the nonlinear iteration does not converge however small the step"
      case (CV_FIRST_RHSFUNC_ERR)
         words = "the state it starts from is outside the domain of the model"
      case (CV_REPTD_RHSFUNC_ERR, CV_UNREC_RHSFUNC_ERR)
         words = "the motion leaves the domain of the model"
      case default
         words = "CVODE gave up with flag " // to_text(int(flag))
      end select
   end function reason

   !> Right-hand side for CVODE.
   function derivative_callback(t, vector_y, vector_rate, user_data) result(flag) bind(c, name="")
      !> Time [s].
      real(c_double), intent(in), value :: t
      type(N_Vector), intent(inout) :: vector_y
      type(N_Vector), intent(inout) :: vector_rate
      !> The handle.
      type(c_ptr), intent(in), value :: user_data
      integer(c_int) :: flag
      type(handle_type), pointer :: handle
      real(c_double), pointer, contiguous :: y(:), rate(:)
      logical :: outside

      call c_f_pointer(user_data, handle)
      call take_values(vector_y, handle%n_all, y)
      call take_values(vector_rate, handle%n_all, rate)
      call handle%problem%derivative(t, y(:handle%n), rate(:handle%n), outside)
      if (handle%n_all > handle%n .and. .not. outside) call handle%problem%way_rates( &
         rate(handle%n + 1:))
      flag = merge(1_c_int, 0_c_int, outside)
   end function derivative_callback

   !> Values of a vector, which are known to be contiguous.
   subroutine take_values(vector, n, values)
      type(N_Vector), intent(inout) :: vector
      integer, intent(in) :: n
      real(c_double), pointer, contiguous, intent(out) :: values(:)
      real(c_double), pointer :: found(:)

      found => FN_VGetArrayPointer(vector)
      call c_f_pointer(c_loc(found(1)), values, [n])
   end subroutine take_values

   !> Jacobian for CVODE.
   function jacobian_callback(t, vector_y, vector_rate, matrix, user_data, work_1, work_2, work_3) &
      result(flag) bind(c, name="")
      !> Time [s].
      real(c_double), intent(in), value :: t
      type(N_Vector), intent(inout) :: vector_y
      type(N_Vector), intent(inout) :: vector_rate
      !> The Jacobian.
      type(SUNMatrix), intent(inout) :: matrix
      !> The handle.
      type(c_ptr), intent(in), value :: user_data
      !> Work space.
      type(N_Vector), intent(inout) :: work_1
      !> Work space.
      type(N_Vector), intent(inout) :: work_2
      !> Work space.
      type(N_Vector), intent(inout) :: work_3
      integer(c_int) :: flag
      type(handle_type), pointer :: handle
      real(c_double), pointer :: y(:), first(:), dense(:, :), sparse(:)
      integer(c_int64_t), pointer :: first_index(:), starts(:), rows(:)
      integer(c_long) :: last(1)
      integer :: i, j

      call c_f_pointer(user_data, handle)
      y => FN_VGetArrayPointer(vector_y)
      if (handle%sparse) then
         first => FSUNSparseMatrix_Data(matrix)
         call c_f_pointer(c_loc(first(1)), sparse, [size(handle%row)])
         call find_entries(handle, t, y(:handle%n), sparse)
         first_index => FSUNSparseMatrix_IndexPointers(matrix)
         call c_f_pointer(c_loc(first_index(1)), starts, [handle%n_all + 1])
         starts = handle%column_start - 1
         first_index => FSUNSparseMatrix_IndexValues(matrix)
         call c_f_pointer(c_loc(first_index(1)), rows, [size(handle%row)])
         rows = handle%row - 1
         ! KLU keeps the order of the pivots, and where one of them is zero now, as after a trial
         ! that was far too long, it fails each time.
         flag = FCVodeGetLastLinFlag(handle%memory, last)
         if (last(1) /= 0) flag = FSUNLinSol_KLUReInit(handle%sparse_solver, matrix, &
            size(handle%row, kind=i8), other_pivots)
      else
         call find_entries(handle, t, y(:handle%n), handle%all_entries)
         first => FSUNDenseMatrix_Data(matrix)
         call c_f_pointer(c_loc(first(1)), dense, [handle%n_all, handle%n_all])
         dense = 0.0_wp
         do j = 1, handle%n_all
            do i = handle%column_start(j), handle%column_start(j + 1) - 1
               dense(handle%row(i), j) = handle%all_entries(i)
            end do
         end do
      end if
      flag = 0
   end function jacobian_callback

   !> Entries of the matrix.
   subroutine find_entries(handle, t, y, entries)
      type(handle_type), intent(inout) :: handle
      !> Time [s].
      real(wp), intent(in) :: t
      !> Unknowns of the problem.
      real(wp), intent(in) :: y(:)
      !> In the order of `row` of the handle.
      real(wp), intent(out) :: entries(:)
      real(wp) :: slopes(way_columns_of)
      integer :: i, k

      if (handle%n_all == handle%n) then
         call handle%problem%jacobian(t, y, entries)
         return
      end if
      call handle%problem%jacobian(t, y, handle%entries)
      entries = 0.0_wp
      entries(handle%place) = handle%entries
      do k = 1, handle%n_all - handle%n
         call handle%problem%way_slopes(k, slopes)
         do i = 1, size(slopes)
            if (handle%way_place(i, k) > 0) entries(handle%way_place(i, k)) = slopes(i)
         end do
      end do
   end subroutine find_entries

   !> Lay out the matrix: the Jacobian of the problem and the rows of the ways.
   subroutine lay_out_matrix(handle)
      type(handle_type), intent(inout) :: handle
      integer :: columns(way_columns_of, handle%n_all - handle%n)
      integer :: i, j, k, next

      associate (problem => handle%problem, n => handle%n, ways => handle%n_all - handle%n)
         do k = 1, ways
            call problem%way_columns(k, columns(:, k))
         end do
         allocate(handle%column_start(handle%n_all + 1), handle%place(size(problem%row)), &
            handle%way_place(way_columns_of, ways), source=0)
         allocate(handle%row(size(problem%row) + count(columns > 0) + ways))
         next = 0
         do j = 1, n
            handle%column_start(j) = next + 1
            do i = problem%column_start(j), problem%column_start(j + 1) - 1
               next = next + 1
               handle%row(next) = problem%row(i)
               handle%place(i) = next
            end do
            do k = 1, ways
               i = findloc(columns(:, k), j, dim=1)
               if (i == 0) cycle
               next = next + 1
               handle%row(next) = n + k
               handle%way_place(i, k) = next
            end do
         end do
         do k = 1, ways
            ! The ways act on nothing; the entry is there for the identity that a solver adds.
            next = next + 1
            handle%column_start(n + k) = next
            handle%row(next) = n + k
         end do
         handle%column_start(handle%n_all + 1) = next + 1
      end associate
   end subroutine lay_out_matrix

   !> Event functions for CVODE.
   function events_callback(t, vector_y, g, user_data) result(flag) bind(c, name="")
      !> Time [s].
      real(c_double), intent(in), value :: t
      type(N_Vector), intent(inout) :: vector_y
      !> Where to put the values of the event functions.
      type(c_ptr), intent(in), value :: g
      !> The handle.
      type(c_ptr), intent(in), value :: user_data
      integer(c_int) :: flag
      type(handle_type), pointer :: handle
      real(c_double), pointer :: y(:), values(:)

      call c_f_pointer(user_data, handle)
      y => FN_VGetArrayPointer(vector_y)
      call c_f_pointer(g, values, [handle%problem%n_events])
      call handle%problem%events(t, y(:handle%n), values)
      ! Whether a gap that is zero to rounding is a touch is not left to its sign.
      if (handle%beginning) then
         associate (problem => handle%problem)
            where (abs(values) <= min(problem%rounding, zero_gap(y(:handle%n)))) values = 0.0_wp
            if (allocated(problem%side)) where (abs(values) <= 0.0_wp) values = &
               real(problem%side, wp)*least_event
         end associate
      end if
      handle%beginning = .false.
      flag = 0
   end function events_callback

   !> Error weights for CVODE.
   function weights_callback(vector_y, vector_weight, user_data) result(flag) bind(c, name="")
      type(N_Vector), intent(inout) :: vector_y
      !> Weights, the inverse of the admissible errors.
      type(N_Vector), intent(inout) :: vector_weight
      !> The handle.
      type(c_ptr), intent(in), value :: user_data
      integer(c_int) :: flag
      type(handle_type), pointer :: handle
      real(c_double), pointer :: y(:), weight(:)

      call c_f_pointer(user_data, handle)
      y => FN_VGetArrayPointer(vector_y)
      weight => FN_VGetArrayPointer(vector_weight)
      call handle%problem%admissible_error(y(:handle%n), weight(:handle%n))
      call handle%problem%flight_errors(part_in_flight, weight(:handle%n))
      if (handle%n_all > handle%n) call handle%problem%way_errors(weight(:handle%n), &
         weight(handle%n + 1:))
      weight = 1.0_wp/weight
      flag = 0
      if (handle%grading) flag = FCVodeSetStopTime(handle%memory, handle%stop)
      handle%grading = .false.
   end function weights_callback

end module contensou_integrate_cvode
