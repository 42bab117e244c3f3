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
