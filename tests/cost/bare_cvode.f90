!> The right-hand side of a scene driven by bare CVODE: the same method, weights and bounds as the
!> executable, one step at a time to the end; no output, no events, nothing between the steps.
!> What the executable needs beyond this is its own.
module bare_cvode_problem
   use, intrinsic :: iso_c_binding, only : c_double, c_f_pointer, c_int, c_ptr
   use fsundials_nvector_mod, only : FN_VGetArrayPointer, N_Vector
   use contensou_base_kinds, only : wp
   use contensou_integrate_motion, only : motion_type
   implicit none(type, external)
   private

   public :: derivative, weights

contains

   !> Right-hand side.
   function derivative(t, vector_y, vector_rate, user_data) result(flag) bind(c)
      !> Time [s].
      real(c_double), intent(in), value :: t
      !> State.
      type(N_Vector), intent(inout) :: vector_y
      !> Its time derivative.
      type(N_Vector), intent(inout) :: vector_rate
      !> The motion.
      type(c_ptr), intent(in), value :: user_data
      integer(c_int) :: flag
      type(motion_type), pointer :: motion
      real(c_double), pointer :: y(:), rate(:)

      call c_f_pointer(user_data, motion)
      y => FN_VGetArrayPointer(vector_y)
      rate => FN_VGetArrayPointer(vector_rate)
      call motion%system%derivative(0.0_wp, y, rate)
      flag = merge(1_c_int, 0_c_int, motion%system%outside)
   end function derivative

   !> Error weights.
   function weights(vector_y, vector_weight, user_data) result(flag) bind(c)
      !> State.
      type(N_Vector), intent(inout) :: vector_y
      !> Weights, the inverse of the admissible errors.
      type(N_Vector), intent(inout) :: vector_weight
      !> The motion.
      type(c_ptr), intent(in), value :: user_data
      integer(c_int) :: flag
      type(motion_type), pointer :: motion
      real(c_double), pointer :: y(:), weight(:)

      call c_f_pointer(user_data, motion)
      y => FN_VGetArrayPointer(vector_y)
      weight => FN_VGetArrayPointer(vector_weight)
      call motion%admissible_error(y, weight)
      weight = 1.0_wp/weight
      flag = 0
   end function weights

end module bare_cvode_problem

!>    bare_cvode SCENE
!>
!> Prints the number of steps and the final height of the first body.
program bare_cvode
   use, intrinsic :: iso_c_binding, only : c_double, c_funloc, c_int, c_loc, c_long, c_null_ptr, &
      c_ptr
   use, intrinsic :: iso_fortran_env, only : error_unit, int64, output_unit
   use fcvode_mod, only : CV_ADAMS, CV_BDF, CV_ONE_STEP, FCVode, FCVodeCreate, FCVodeFree, &
      FCVodeGetNumSteps, FCVodeInit, FCVodeSetLinearSolver, FCVodeSetMaxConvFails, &
      FCVodeSetMaxErrTestFails, FCVodeSetMaxHnilWarns, FCVodeSetMaxStep, &
      FCVodeSetNonlinearSolver, FCVodeSetStopTime, FCVodeSetUserData, FCVodeWFtolerances
   use fnvector_serial_mod, only : FN_VMake_Serial
   use fsundials_context_mod, only : FSUNContext_Create, FSUNContext_Free
   use fsundials_linearsolver_mod, only : FSUNLinSolFree, SUNLinearSolver
   use fsundials_matrix_mod, only : FSUNMatDestroy, SUNMatrix
   use fsundials_nonlinearsolver_mod, only : FSUNNonlinSolFree, SUNNonlinearSolver
   use fsundials_nvector_mod, only : FN_VDestroy, N_Vector
   use fsunlinsol_dense_mod, only : FSUNLinSol_Dense
   use fsunmatrix_dense_mod, only : FSUNDenseMatrix
   use fsunnonlinsol_fixedpoint_mod, only : FSUNNonlinSol_FixedPoint
   use bare_cvode_problem, only : derivative, weights
   use contensou_base_errors, only : error_type
   use contensou_base_text, only : string_type
   use contensou_scene_reader, only : read_scene, scene_file_type
   use contensou_study_simulation, only : new_simulation, simulation_type
   implicit none(type, external)

   call simulate()

contains

   !> From the scene to the end of its time.
   subroutine simulate()
      type(scene_file_type) :: file
      type(simulation_type), target :: simulation
      type(error_type), allocatable :: error
      type(string_type) :: overrides(0)
      type(c_ptr) :: context, memory
      type(N_Vector), pointer :: vector
      type(SUNMatrix), pointer :: matrix
      type(SUNLinearSolver), pointer :: linear_solver
      type(SUNNonlinearSolver), pointer :: fixed_point
      real(c_double), allocatable, target :: y(:)
      character(len=:), allocatable :: path
      real(c_double) :: reached(1)
      integer(c_long) :: steps(1)
      integer(c_int) :: flag
      integer(int64) :: n
      integer :: length
      logical :: adams

      call get_command_argument(1, length=length)
      allocate(character(len=length) :: path)
      call get_command_argument(1, path)
      call read_scene(path, overrides, "", file, error)
      if (.not. allocated(error)) call new_simulation(file, simulation, error)
      if (allocated(error)) then
         write(error_unit, "(a)") error%message
         stop 2, quiet=.true.
      end if
      y = simulation%state()
      n = size(y, kind=int64)
      adams = file%scene%integrator%method == "cvode_adams"

      flag = FSUNContext_Create(c_null_ptr, context)
      vector => FN_VMake_Serial(n, y, context)
      memory = FCVodeCreate(merge(CV_ADAMS, CV_BDF, adams), context)
      flag = min(flag, FCVodeInit(memory, c_funloc(derivative), 0.0_c_double, vector))
      flag = min(flag, FCVodeSetUserData(memory, c_loc(simulation%motion)))
      flag = min(flag, FCVodeWFtolerances(memory, c_funloc(weights)))
      if (adams) then
         fixed_point => FSUNNonlinSol_FixedPoint(vector, 0, context)
         flag = min(flag, FCVodeSetNonlinearSolver(memory, fixed_point))
      else
         matrix => FSUNDenseMatrix(n, n, context)
         linear_solver => FSUNLinSol_Dense(vector, matrix, context)
         flag = min(flag, FCVodeSetLinearSolver(memory, linear_solver, matrix))
      end if
      flag = min(flag, FCVodeSetMaxHnilWarns(memory, -1_c_int))
      flag = min(flag, FCVodeSetMaxErrTestFails(memory, 60_c_int))
      flag = min(flag, FCVodeSetMaxConvFails(memory, 60_c_int))
      flag = min(flag, FCVodeSetStopTime(memory, file%scene%t_end))
      if (file%scene%integrator%max_step > 0.0_c_double) then
         flag = min(flag, FCVodeSetMaxStep(memory, file%scene%integrator%max_step))
      end if
      reached = 0.0_c_double
      do while (flag >= 0 .and. reached(1) < file%scene%t_end)
         flag = FCVode(memory, file%scene%t_end, vector, reached, CV_ONE_STEP)
      end do
      if (flag < 0) then
         write(error_unit, "(a, i0)") "CVODE ended with flag ", flag
         stop 1, quiet=.true.
      end if
      flag = FCVodeGetNumSteps(memory, steps)
      write(output_unit, "(i0, es25.16)") steps(1), y(3)

      call FCVodeFree(memory)
      if (adams) then
         flag = FSUNNonlinSolFree(fixed_point)
      else
         flag = FSUNLinSolFree(linear_solver)
         call FSUNMatDestroy(matrix)
      end if
      call FN_VDestroy(vector)
      flag = FSUNContext_Free(context)
   end subroutine simulate

end program bare_cvode
