!> The right-hand side of a scene driven by explicit methods of libraries, and by a bare loop with
!> the pair of explicit8, to the first touch of a contact that is open at the beginning.
!>
!> All are held to the admissible errors of the executable and measured by the same clock.

!> explicit8 itself, with its events, without what the executable puts around it.
module library_explicit8_own
   use contensou_base_errors, only : error_type
   use contensou_base_kinds, only : wp
   use contensou_integrate_explicit8, only : explicit8_type
   use contensou_integrate_integrator, only : statistics_type
   use cost_problem, only : handle_type, outcome_type
   implicit none(type, external)
   private

   public :: integrate_own

contains

   !> Integrate to the touch.
   subroutine integrate_own(self, outcome, calls, message)
      !> The problem.
      type(handle_type), intent(inout), target :: self
      !> What comes of it.
      type(outcome_type), intent(out) :: outcome
      !> Calls of the right-hand side.
      integer, intent(out) :: calls
      !> Set when it fails.
      character(len=:), allocatable, intent(out) :: message
      type(explicit8_type) :: integrator
      type(statistics_type) :: counters
      type(error_type), allocatable :: error
      real(wp), allocatable :: y(:)
      integer, allocatable :: events(:)
      real(wp) :: start, finish

      y = self%y
      allocate(events(self%motion%n_events), source=0)
      call cpu_time(start)
      call integrator%start(self%motion, "explicit8", 0.0_wp, y, self%t_end, 0.0_wp, error)
      do while (outcome%t < self%t_end .and. events(self%contact) >= 0)
         call integrator%step(outcome%t, y, events, error)
         if (allocated(error)) exit
      end do
      call cpu_time(finish)
      outcome%cpu = finish - start
      outcome%touched = events(self%contact) < 0
      counters = integrator%statistics()
      outcome%steps = int(counters%steps)
      calls = int(counters%derivatives)
      call integrator%free()
      if (allocated(error)) message = error%message
   end subroutine integrate_own

end module library_explicit8_own

!> rk8pd of the GNU Scientific Library: the same pair of Prince and Dormand, with the library's
!> evolution and control of the step.
module library_explicit8_gsl
   use, intrinsic :: iso_c_binding, only : c_associated, c_double, c_f_pointer, c_funloc, &
      c_funptr, c_int, c_loc, c_long, c_null_funptr, c_null_ptr, c_ptr, c_size_t
   use contensou_base_kinds, only : wp
   use cost_problem, only : bracket_type, derivative, gap, handle_type, narrow, &
      outcome_type, resolved, trial
   implicit none(type, external)
   private

   public :: integrate_gsl

   !> `gsl_odeiv2_system`.
   type, bind(c) :: system_type
      !> Right-hand side.
      type(c_funptr) :: derivative
      type(c_funptr) :: jacobian
      !> Number of unknowns.
      integer(c_size_t) :: dimension
      !> What the right-hand side gets.
      type(c_ptr) :: parameters
   end type system_type

   !> `gsl_odeiv2_control_type`.
   type, bind(c) :: control_kind_type
      type(c_ptr) :: name
      !> Make a state.
      type(c_funptr) :: allocate
      !> Set its parameters.
      type(c_funptr) :: init
      !> Length of the next step from the error of the last.
      type(c_funptr) :: adjust
      !> Admissible error of one unknown, for other steppers.
      type(c_funptr) :: error_level
      !> Tell the control of a driver.
      type(c_funptr) :: set_driver
      !> Release the state.
      type(c_funptr) :: free
   end type control_kind_type

   !> `gsl_odeiv2_control`.
   type, bind(c) :: control_type
      !> Its procedures.
      type(c_ptr) :: kind
      type(c_ptr) :: state
   end type control_type

   !> `gsl_odeiv2_evolve`.
   type, bind(c) :: evolution_type
      !> Number of unknowns.
      integer(c_size_t) :: dimension
      !> State at the beginning of the step.
      type(c_ptr) :: y
      !> Error of the step.
      type(c_ptr) :: error
      !> Right-hand side at the beginning of the step.
      type(c_ptr) :: rate_in
      !> Right-hand side at its end.
      type(c_ptr) :: rate_out
      !> Length of the step.
      real(c_double) :: last_step
      !> Steps, also those that the control rejects.
      integer(c_long) :: count
      !> Steps that were rejected.
      integer(c_long) :: failed
      type(c_ptr) :: driver
   end type evolution_type

   !> Codes of the library.
   integer(c_int), parameter :: success = 0_c_int, failure = -1_c_int

   !> What the control did to the step.
   integer(c_int), parameter :: increased = 1_c_int, unchanged = 0_c_int, decreased = -1_c_int

   interface
      !> Make a stepper, as explicit8 does.
      function rk8pd_new(n) result(step) bind(c, name="contensou_rk8pd_new")
         import :: c_ptr, c_size_t
         implicit none(type, external)
         !> Number of unknowns.
         integer(c_size_t), intent(in), value :: n
         type(c_ptr) :: step
      end function rk8pd_new

      !> Take a step.
      function step_apply(step, t, h, y, error, rate_in, rate_out, system) result(code) &
         bind(c, name="gsl_odeiv2_step_apply")
         import :: c_double, c_int, c_ptr, system_type
         implicit none(type, external)
         !> The stepper.
         type(c_ptr), intent(in), value :: step
         !> Time [s].
         real(c_double), intent(in), value :: t
         !> Length of the step [s].
         real(c_double), intent(in), value :: h
         !> State.
         real(c_double), intent(inout) :: y(*)
         !> Error of the step.
         real(c_double), intent(out) :: error(*)
         !> Right-hand side at the beginning, or null.
         type(c_ptr), intent(in), value :: rate_in
         !> Right-hand side at the end, or null.
         type(c_ptr), intent(in), value :: rate_out
         !> The problem.
         type(system_type), intent(in) :: system
         integer(c_int) :: code
      end function step_apply

      !> Release a stepper.
      subroutine step_free(step) bind(c, name="gsl_odeiv2_step_free")
         import :: c_ptr
         implicit none(type, external)
         !> The stepper.
         type(c_ptr), intent(in), value :: step
      end subroutine step_free

      !> Make an evolution.
      function evolve_alloc(n) result(evolution) bind(c, name="gsl_odeiv2_evolve_alloc")
         import :: c_ptr, c_size_t
         implicit none(type, external)
         !> Number of unknowns.
         integer(c_size_t), intent(in), value :: n
         type(c_ptr) :: evolution
      end function evolve_alloc

      !> Take a step whose error is admissible.
      function evolve_apply(evolution, control, step, system, t, t_end, h, y) result(code) &
         bind(c, name="gsl_odeiv2_evolve_apply")
         import :: c_double, c_int, c_ptr, control_type, system_type
         implicit none(type, external)
         type(c_ptr), intent(in), value :: evolution
         type(control_type), intent(in) :: control
         !> The stepper.
         type(c_ptr), intent(in), value :: step
         !> The problem.
         type(system_type), intent(in) :: system
         !> Time [s].
         real(c_double), intent(inout) :: t
         !> End of time [s].
         real(c_double), intent(in), value :: t_end
         !> Length of the next step [s].
         real(c_double), intent(inout) :: h
         !> State.
         real(c_double), intent(inout) :: y(*)
         integer(c_int) :: code
      end function evolve_apply

      !> Release an evolution.
      subroutine evolve_free(evolution) bind(c, name="gsl_odeiv2_evolve_free")
         import :: c_ptr
         implicit none(type, external)
         type(c_ptr), intent(in), value :: evolution
      end subroutine evolve_free

      !> Let the library return codes instead of ending the program.
      function set_error_handler_off() result(handler) bind(c, name="gsl_set_error_handler_off")
         import :: c_funptr
         implicit none(type, external)
         type(c_funptr) :: handler
      end function set_error_handler_off
   end interface

contains

   !> Integrate to the touch.
   !>
   !> `gsl_odeiv2_control_scaled_new` knows admissible errors a_i + b |y_i| with constant a_i and b;
   !> the executable's depend on the speed, not on each component of the velocity. So the control is
   !> one of ours, with the rule of the library's standard one.
   subroutine integrate_gsl(self, outcome, message)
      !> The problem.
      type(handle_type), intent(inout), target :: self
      !> What comes of it.
      type(outcome_type), intent(out) :: outcome
      !> Set when it fails.
      character(len=:), allocatable, intent(out) :: message
      type(system_type) :: system
      type(control_kind_type), target :: kind
      type(control_type) :: control
      type(evolution_type), pointer :: memory
      type(c_ptr) :: step, evolution
      type(c_funptr) :: handler
      type(bracket_type) :: bracket
      real(c_double), allocatable :: y(:), y_old(:), error(:)
      real(c_double) :: t, h, start, finish
      integer(c_size_t) :: n
      integer(c_int) :: code
      integer :: i

      n = size(self%y, kind=c_size_t)
      y = self%y
      allocate(y_old(n), error(n))
      handler = set_error_handler_off()
      system = system_type(c_funloc(gsl_derivative), c_null_funptr, n, c_loc(self))
      kind = control_kind_type(c_null_ptr, c_null_funptr, c_null_funptr, &
         c_funloc(gsl_adjust), c_null_funptr, c_null_funptr, c_null_funptr)
      control = control_type(c_loc(kind), c_loc(self))
      step = rk8pd_new(n)
      evolution = evolve_alloc(n)
      if (.not. (c_associated(step) .and. c_associated(evolution))) then
         message = "there is no memory for GSL"
         return
      end if

      call cpu_time(start)
      t = 0.0_wp
      h = 1.0e-6_wp
      bracket%gap = gap(self, y)
      do while (t < self%t_end)
         y_old = y
         outcome%t = t
         bracket%gap(1) = bracket%gap(2)
         code = evolve_apply(evolution, control, step, system, t, self%t_end, h, y)
         if (code /= success) exit
         bracket%gap(2) = gap(self, y)
         if (bracket%gap(2) <= 0.0_wp) exit
      end do
      outcome%touched = bracket%gap(2) <= 0.0_wp
      if (outcome%touched) then
         bracket%h = [0.0_wp, t - outcome%t]
         i = 0
         do while (.not. resolved(bracket, outcome%t) .and. i < 100)
            i = i + 1
            h = trial(bracket, i)
            y = y_old
            code = step_apply(step, outcome%t, h, y, error, c_null_ptr, c_null_ptr, system)
            if (code /= success) exit
            call narrow(bracket, h, gap(self, y))
         end do
         outcome%t = outcome%t + bracket%h(2)
      else
         outcome%t = t
      end if
      call cpu_time(finish)
      outcome%cpu = finish - start

      call c_f_pointer(evolution, memory)
      outcome%steps = int(memory%count - memory%failed)
      call evolve_free(evolution)
      call step_free(step)
      if (code /= success) message = "GSL cannot go on"
   end subroutine integrate_gsl

   !> Right-hand side for GSL.
   function gsl_derivative(t, y, rate, parameters) result(code) bind(c)
      !> Time [s].
      real(c_double), intent(in), value :: t
      !> State.
      type(c_ptr), intent(in), value :: y
      !> Its time derivative.
      type(c_ptr), intent(in), value :: rate
      !> The problem.
      type(c_ptr), intent(in), value :: parameters
      integer(c_int) :: code
      type(handle_type), pointer :: handle
      real(c_double), pointer, contiguous :: state(:), slope(:)
      logical :: outside

      call c_f_pointer(parameters, handle)
      call c_f_pointer(y, state, [handle%motion%n])
      call c_f_pointer(rate, slope, [handle%motion%n])
      call derivative(handle, t, state, slope, outside)
      ! After this code the library tries again with half of the step.
      code = merge(failure, success, outside)
   end function gsl_derivative

   !> Length of the next step: the rule of the library's standard control, which holds the largest
   !> error of all unknowns over the admissible one between 0.5 and 1.1.
   function gsl_adjust(state, n, order, y, error, rate, h) result(change) bind(c)
      !> The problem.
      type(c_ptr), intent(in), value :: state
      !> Number of unknowns.
      integer(c_size_t), intent(in), value :: n
      !> Order of the method.
      integer(c_int), intent(in), value :: order
      !> State.
      real(c_double), intent(in) :: y(n)
      !> Error of the step.
      real(c_double), intent(in) :: error(n)
      !> Right-hand side.
      type(c_ptr), intent(in), value :: rate
      !> Length of the step [s].
      real(c_double), intent(inout) :: h
      integer(c_int) :: change
      type(handle_type), pointer :: handle
      real(c_double) :: admissible(n)
      real(c_double) :: largest

      call c_f_pointer(state, handle)
      call handle%motion%admissible_error(y, admissible)
      largest = max(maxval(abs(error)/admissible), tiny(h))
      if (largest > 1.1_wp) then
         h = h*max(0.9_wp*largest**(-1.0_wp/order), 0.2_wp)
         change = decreased
      else if (largest < 0.5_wp) then
         h = h*min(max(0.9_wp*largest**(-1.0_wp/(order + 1)), 1.0_wp), 5.0_wp)
         change = increased
      else
         change = unchanged
      end if
   end function gsl_adjust

end module library_explicit8_gsl

!> ERKStep of SUNDIALS' ARKODE with fused vector operations. It has no compiled right-hand-side or
!> stage kernels beyond these: the fused kernels of SUNDIALS are CVODE's alone.
module library_explicit8_sundials
   use, intrinsic :: iso_c_binding, only : c_associated, c_double, c_f_pointer, c_funloc, c_int, &
      c_loc, c_long, c_null_ptr, c_ptr
   use farkode_erkstep_mod, only : FERKStepCreate, FERKStepEvolve, FERKStepFree, &
      FERKStepGetLastStep, FERKStepGetNumSteps, FERKStepReset, FERKStepRootInit, &
      FERKStepSetErrFile, FERKStepSetInitStep, FERKStepSetMaxErrTestFails, &
      FERKStepSetMaxNumSteps, FERKStepSetNoInactiveRootWarn, FERKStepSetRootDirection, &
      FERKStepSetStopTime, FERKStepSetTable, FERKStepSetUserData, &
      FERKStepWFtolerances
   use farkode_mod, only : ARK_ONE_STEP, ARK_RHSFUNC_FAIL, ARK_ROOT_RETURN, &
      ARK_UNREC_RHSFUNC_ERR, ARKODE_FEHLBERG_13_7_8, FARKodeButcherTable_Create, &
      FARKodeButcherTable_Free, FARKodeButcherTable_LoadERK
   use fnvector_serial_mod, only : FN_VEnableFusedOps_Serial, FN_VMake_Serial
   use fsundials_context_mod, only : FSUNContext_Create, FSUNContext_Free
   use fsundials_nvector_mod, only : FN_VDestroy, FN_VGetArrayPointer, N_Vector
   use contensou_base_kinds, only : i8, wp
   use cost_bare_pair, only : local_error, set_stage, stage_time, stages, &
      step_stages
   use cost_problem, only : derivative, gap, handle_type, outcome_type
   implicit none(type, external)
   private

   public :: integrate_erkstep

   !> `ARKodeButcherTableMem`.
   type, bind(c) :: table_type
      !> Order of the method.
      integer(c_int) :: order
      integer(c_int) :: order_embedded
      !> Number of stages.
      integer(c_int) :: stages
      !> Rows of coefficients.
      type(c_ptr) :: a
      !> Times of the stages, in steps.
      type(c_ptr) :: c
      !> Weights of the method.
      type(c_ptr) :: b
      !> Weights of the embedded one.
      type(c_ptr) :: d
   end type table_type

   !> Attempts at a step that leaves the domain of the model.
   integer, parameter :: most_attempts = 60

contains

   !> Integrate to the touch, which the library's own search for roots finds on its interpolant.
   subroutine integrate_erkstep(self, own_pair, mended, outcome, message)
      !> The problem.
      type(handle_type), intent(inout), target :: self
      !> Whether the pair is that of explicit8, or the library's one of order 8: Fehlberg's.
      logical, intent(in) :: own_pair
      !> Whether the table is mended.
      logical, intent(in) :: mended
      !> What comes of it.
      type(outcome_type), intent(out) :: outcome
      !> Set when it fails.
      character(len=:), allocatable, intent(out) :: message
      type(c_ptr) :: context, memory, table
      type(N_Vector), pointer :: vector
      real(c_double), allocatable, target :: y(:), y_old(:)
      real(c_double) :: t(1), h(1), start, finish
      integer(c_long) :: steps(1)
      integer(c_int) :: flag, falling(1)
      integer :: attempts

      y = self%y
      y_old = y
      flag = FSUNContext_Create(c_null_ptr, context)
      vector => FN_VMake_Serial(size(y, kind=i8), y, context)
      ! The library's vectors are made after this one, and are like it.
      flag = min(flag, FN_VEnableFusedOps_Serial(vector, 1_c_int))
      memory = FERKStepCreate(c_funloc(erkstep_derivative), 0.0_c_double, vector, context)
      if (flag /= 0 .or. .not. c_associated(memory)) then
         message = "ERKStep could not be set up"
         return
      end if
      if (own_pair) then
         table = pair()
      else
         table = FARKodeButcherTable_LoadERK(ARKODE_FEHLBERG_13_7_8)
      end if
      if (mended) call mend(table)
      flag = min(flag, FERKStepSetTable(memory, table))
      falling = -1
      flag = min(flag, FERKStepSetUserData(memory, c_loc(self)))
      flag = min(flag, FERKStepWFtolerances(memory, c_funloc(erkstep_weights)))
      flag = min(flag, FERKStepRootInit(memory, 1_c_int, c_funloc(erkstep_gap)))
      flag = min(flag, FERKStepSetRootDirection(memory, falling))
      flag = min(flag, FERKStepSetNoInactiveRootWarn(memory))
      flag = min(flag, FERKStepSetMaxErrTestFails(memory, 60_c_int))
      flag = min(flag, FERKStepSetMaxNumSteps(memory, -1_c_long))
      flag = min(flag, FERKStepSetStopTime(memory, self%t_end))
      flag = min(flag, FERKStepSetErrFile(memory, c_null_ptr))
      if (flag < 0) message = "ERKStep could not be set up"

      call cpu_time(start)
      t = 0.0_wp
      attempts = 0
      do while (flag >= 0 .and. t(1) < self%t_end .and. flag /= ARK_ROOT_RETURN)
         outcome%t = t(1)
         y_old = y
         flag = FERKStepEvolve(memory, self%t_end, vector, t, ARK_ONE_STEP)
         if (flag >= 0) then
            attempts = 0
         else if ((flag == ARK_UNREC_RHSFUNC_ERR .or. flag == ARK_RHSFUNC_FAIL) &
            .and. attempts < most_attempts) then
            ! ERKStep gives up where CVODE takes a shorter step.
            attempts = attempts + 1
            flag = FERKStepGetLastStep(memory, h)
            if (h(1) <= 0.0_wp) h = 1.0e-6_wp
            t = outcome%t
            y = y_old
            flag = min(flag, FERKStepReset(memory, t(1), vector))
            flag = min(flag, FERKStepSetStopTime(memory, self%t_end))
            flag = min(flag, FERKStepSetInitStep(memory, h(1)*0.25_wp**attempts))
         end if
      end do
      call cpu_time(finish)
      outcome%cpu = finish - start
      outcome%touched = flag == ARK_ROOT_RETURN
      outcome%t = t(1)
      if (flag < 0) message = "ERKStep cannot go on"
      flag = FERKStepGetNumSteps(memory, steps)
      outcome%steps = int(steps(1))
      call FERKStepFree(memory)
      call FARKodeButcherTable_Free(table)
      call FN_VDestroy(vector)
      flag = FSUNContext_Free(context)
   end subroutine integrate_erkstep

   !> Let the right-hand side be evaluated where a step ends.
   !>
   !> SUNDIALS before 6.7 takes the last stage for the end of the step where its time is that of the
   !> end, although here its state is another one: the next step would begin with a right-hand side
   !> that is not its own. A time that is off by more than ERKStep's 1e-10 helps.
   subroutine mend(table)
      type(c_ptr), intent(in) :: table
      type(table_type), pointer :: content
      real(c_double), pointer :: c(:)

      call c_f_pointer(table, content)
      call c_f_pointer(content%c, c, [content%stages])
      c(content%stages) = c(content%stages) - 1.0e-9_wp
   end subroutine mend

   !> The table of the pair of explicit8, found by what its procedures make of unit vectors.
   function pair() result(table)
      type(c_ptr) :: table
      integer, parameter :: s = step_stages - 1
      real(wp) :: k(1, stages), z(1), a(s, s), b(s), error(s), c(s), flat(s*s), embedded(s)
      integer :: i, j

      a = 0.0_wp
      do j = 1, s
         k = 0.0_wp
         k(1, j) = 1.0_wp
         do i = j + 1, s
            call set_stage(i, 1, 1.0_wp, [0.0_wp], k, z)
            a(j, i) = z(1)
         end do
         call set_stage(step_stages, 1, 1.0_wp, [0.0_wp], k, z)
         b(j) = z(1)
         ! The estimate has no sign; that of the last stage, b alone, is positive.
         k(1, s) = k(1, s) + 1.0e3_wp
         error(j) = local_error(1, 1.0_wp, [1.0_wp], k)
      end do
      k = 0.0_wp
      k(1, s) = 1.0e3_wp
      error = error - local_error(1, 1.0_wp, [1.0_wp], k)
      ! As variables, since the interface does not say that they are only read.
      c = stage_time(:s)
      flat = reshape(a, [s*s])
      embedded = b - error
      table = FARKodeButcherTable_Create(int(s, c_int), 8_c_int, 7_c_int, c, flat, b, embedded)
   end function pair

   !> Right-hand side for ERKStep.
   function erkstep_derivative(t, vector_y, vector_rate, user_data) result(flag) bind(c)
      !> Time [s].
      real(c_double), intent(in), value :: t
      !> State.
      type(N_Vector), intent(inout) :: vector_y
      !> Its time derivative.
      type(N_Vector), intent(inout) :: vector_rate
      !> The problem.
      type(c_ptr), intent(in), value :: user_data
      integer(c_int) :: flag
      type(handle_type), pointer :: handle
      real(c_double), pointer :: y(:), rate(:)
      logical :: outside

      call c_f_pointer(user_data, handle)
      y => FN_VGetArrayPointer(vector_y)
      rate => FN_VGetArrayPointer(vector_rate)
      call derivative(handle, t, y, rate, outside)
      flag = merge(1_c_int, 0_c_int, outside)
   end function erkstep_derivative

   !> Gap for ERKStep.
   function erkstep_gap(t, vector_y, g, user_data) result(flag) bind(c)
      !> Time [s].
      real(c_double), intent(in), value :: t
      !> State.
      type(N_Vector), intent(inout) :: vector_y
      !> The gap [m].
      real(c_double), intent(out) :: g(1)
      !> The problem.
      type(c_ptr), intent(in), value :: user_data
      integer(c_int) :: flag
      type(handle_type), pointer :: handle
      real(c_double), pointer :: y(:)

      call c_f_pointer(user_data, handle)
      y => FN_VGetArrayPointer(vector_y)
      g = gap(handle, y)
      flag = 0
   end function erkstep_gap

   !> Error weights for ERKStep.
   function erkstep_weights(vector_y, vector_weight, user_data) result(flag) bind(c)
      !> State.
      type(N_Vector), intent(inout) :: vector_y
      !> Weights, the inverse of the admissible errors.
      type(N_Vector), intent(inout) :: vector_weight
      !> The problem.
      type(c_ptr), intent(in), value :: user_data
      integer(c_int) :: flag
      type(handle_type), pointer :: handle
      real(c_double), pointer :: y(:), weight(:)

      call c_f_pointer(user_data, handle)
      y => FN_VGetArrayPointer(vector_y)
      weight => FN_VGetArrayPointer(vector_weight)
      call handle%motion%admissible_error(y, weight)
      weight = 1.0_wp/weight
      flag = 0
   end function erkstep_weights

end module library_explicit8_sundials

!>    library_explicit8 SCENE METHOD RTOL CONTACT [SETTING...]
!>
!> METHOD is
!>    gsl_rk8pd        GSL's stepper with its evolution
!>    erkstep          ERKStep with its table of order 8
!>    erkstep_mended   the same without a defect of SUNDIALS before 6.7
!>    erkstep_pair     ERKStep with the pair of explicit8 as a table, without that defect
!>    bare             the pair of explicit8 in a bare loop
!>    explicit8        explicit8 with its events
!>
!> CONTACT names a contact that is open at the beginning; a SETTING is what `contensou run` takes
!> after --set. Prints the time of the first touch and `touch`, or the end of time and `end`;
!> then steps, calls of the right-hand side, and the CPU time of the loop.
program library_explicit8
   use, intrinsic :: iso_fortran_env, only : error_unit, output_unit
   use contensou_base_errors, only : error_type
   use contensou_base_text, only : string_type
   use contensou_scene_reader, only : read_scene, scene_file_type
   use contensou_study_simulation, only : new_simulation, simulation_type
   use cost_bare_loop, only : integrate_bare
   use library_explicit8_gsl, only : integrate_gsl
   use library_explicit8_own, only : integrate_own
   use cost_problem, only : gap, handle_type, outcome_type
   use library_explicit8_sundials, only : integrate_erkstep
   implicit none(type, external)

   call simulate()

contains

   !> From the scene to the touch.
   subroutine simulate()
      type(scene_file_type) :: file
      type(simulation_type) :: simulation
      type(handle_type), target :: handle
      type(outcome_type) :: outcome
      type(error_type), allocatable :: error
      type(string_type), allocatable :: settings(:)
      character(len=:), allocatable :: method, contact, message
      integer :: i

      if (command_argument_count() < 4) call give_up("SCENE METHOD RTOL CONTACT [SETTING...]", 2)
      allocate(settings(command_argument_count() - 2))
      do i = 5, command_argument_count()
         settings(i - 4)%s = argument(i)
      end do
      settings(size(settings) - 1)%s = "integrator.method=explicit8"
      settings(size(settings))%s = "integrator.rtol=" // argument(3)
      call read_scene(argument(1), settings, "", file, error)
      if (.not. allocated(error)) call new_simulation(file, simulation, error)
      if (allocated(error)) call give_up(error%message, 2)
      method = argument(2)
      contact = argument(4)
      handle%motion = simulation%motion
      handle%y = simulation%state()
      handle%t_end = file%scene%t_end
      allocate(handle%gaps(size(file%scene%contacts)))
      do i = 1, size(file%scene%contacts)
         if (file%scene%contacts(i)%name == contact) handle%contact = i
      end do
      if (handle%contact == 0) call give_up("there is no contact " // contact, 2)
      if (gap(handle, handle%y) <= 0.0) call give_up(contact // " is closed at the beginning", 2)

      select case (method)
      case ("bare")
         call integrate_bare(handle, outcome)
      case ("explicit8")
         call integrate_own(handle, outcome, handle%calls, message)
      case ("gsl_rk8pd")
         call integrate_gsl(handle, outcome, message)
      case ("erkstep", "erkstep_mended", "erkstep_pair")
         call integrate_erkstep(handle, method == "erkstep_pair", method /= "erkstep", outcome, &
            message)
      case default
         call give_up("there is no method " // method, 2)
      end select
      if (allocated(message)) call give_up(message, 1)
      write(output_unit, "(es23.16, 1x, a, 2(1x, i0), es13.6)") outcome%t, &
         trim(merge("touch", "end  ", outcome%touched)), outcome%steps, handle%calls, outcome%cpu
   end subroutine simulate

   !> An argument of the command line.
   function argument(number) result(text)
      integer, intent(in) :: number
      character(len=:), allocatable :: text
      integer :: length

      call get_command_argument(number, length=length)
      allocate(character(len=length) :: text)
      call get_command_argument(number, text)
   end function argument

   !> End with a message.
   subroutine give_up(message, status)
      character(len=*), intent(in) :: message
      !> Exit status.
      integer, intent(in) :: status

      write(error_unit, "(a)") "error: " // message
      stop status, quiet=.true.
   end subroutine give_up

end program library_explicit8
