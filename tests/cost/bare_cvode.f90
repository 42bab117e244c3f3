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
