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
