!> The explicit Runge-Kutta pair RK8(7)13M of Prince and Dormand as the GNU Scientific Library takes
!> it (`rk8pd`), with a continuous extension of order 7, which the library does not have.
!>
!> Stages 1 to 13 make the step and its estimate of the local error; stage 14 is the right-hand side
!> at the end of the step, which is the first stage of the next one; stages 15 to 17 are for the
!> continuous extension alone.
!> P. J. Prince, J. R. Dormand, J. Comput. Appl. Math. 7 (1981) 67.
!>
!> With s the share of the step, the extension is the cubic through both ends with their
!> derivatives, and s^2 (1 - s)^2 times a cubic in s of each stage. The coefficients are the
!> smallest ones (least squares) that meet all conditions of order 7. Stages 15 to 17 are at states
!> of order 6, again with the smallest coefficients. Of the stages of a step alone there is such a
!> state only at (1 - 1/sqrt(7))/2 and (1 + 1/sqrt(7))/2 of it, the places of stages 15 and 16. Of
!> the places of stage 17 that is taken at which the conditions of order 8 are missed least.
module contensou_integrate_rk8pd
   use, intrinsic :: iso_c_binding, only : c_associated, c_double, c_f_pointer, c_funloc, &
      c_funptr, c_int, c_loc, c_null_ptr, c_ptr, c_size_t
   use contensou_base_kinds, only : i8, wp
   use contensou_integrate_problem, only : problem_type
   implicit none(type, external)
   private

   public :: rk8pd_type, begin_rk8pd, evaluate, take_step, extend, value_within, end_rk8pd

   !> Number of stages, those of the continuous extension included.
   integer, parameter :: stages = 17

   !> Last stage of a step, its end.
   integer, parameter, public :: last_stage = 14

   !> Stage 15, of stages 1, 6 to 14.
   real(wp), parameter :: a15(*) = [0.044363001767296704_wp, 0.050396633531244954_wp, &
      0.2211796223269007_wp, 0.005324746787651644_wp, -0.00902019004427452_wp, &
      -0.0025276394257183065_wp, 0.002603318728748653_wp, 0.005804310189204495_wp, &
      0.005488995178193602_wp, -0.012595035543861518_wp]

   !> Stage 16, of stages 1, 6 to 14.
   real(wp), parameter :: a16(*) = [0.043741949001009854_wp, 0.16064238298290887_wp, &
      0.2252311951813036_wp, 0.10234537893380165_wp, 0.07116447521453981_wp, &
      0.08439998332495849_wp, 0.0029206075498668773_wp, -0.03379436953403029_wp, &
      0.004429475857413932_wp, 0.02790115799284082_wp]

   !> Stage 17, of stages 1, 6 to 16.
   real(wp), parameter :: a17(*) = [0.04988171231741288_wp, 0.09304342441181529_wp, &
      0.19263832645059115_wp, 0.07771217010442578_wp, 0.056802406936251645_wp, &
      0.016429447355893353_wp, -0.015856888265969836_wp, 0.008296244021341461_wp, &
      -0.026706616979686695_wp, 0.026228405987859266_wp, 0.10343636097488257_wp, &
      0.018095006685183136_wp]

   !> Coefficient 4 of the continuous extension, of stages 1, 6 to 16.
   real(wp), parameter :: d4(*) = [-6.004411416005467_wp, 9.530594897568516_wp, &
      16.481977559845532_wp, 3.284434347446279_wp, 1.3815337789181696_wp, 6.183872776912579_wp, &
      1.8699564133339386_wp, -3.847820066588654_wp, 3.2865283752357377_wp, 0.4999999999999917_wp, &
      -22.506753059150686_wp, -10.159913607515938_wp]

   !> Coefficient 5 of the continuous extension, of stages 1, 6 to 17.
   real(wp), parameter :: d5(*) = [16.609866999897438_wp, -49.811890448449724_wp, &
      -63.558045467417806_wp, -8.981812006125988_wp, 1.837357502075172_wp, -51.47149962599191_wp, &
      -24.029104534849527_wp, 45.404465516573964_wp, -43.86970830608364_wp, 9.527777777777752_wp, &
      117.65840279352602_wp, 98.90949844104242_wp, -48.22530864197416_wp]

   !> Coefficient 6 of the continuous extension, of stages 1, 6 to 17.
   real(wp), parameter :: d6(*) = [-20.330300333583093_wp, 92.48065046726815_wp, &
      90.0867505262222_wp, 6.541238780265864_wp, -14.579069188090203_wp, 119.20189020932068_wp, &
      62.220242432745025_wp, -115.54043252271853_wp, 114.41902962857316_wp, &
      -25.472222222222154_wp, -197.3566242729483_wp, -256.34707943075637_wp, &
      144.67592592592356_wp]

   !> Coefficient 7 of the continuous extension, of stages 1, 6 to 17.
   real(wp), parameter :: d7(*) = [9.14169996518507_wp, -63.706576095405744_wp, &
      -44.24044695587744_wp, 1.9668090689602182_wp, 17.164431236939933_wp, -97.19511960127666_wp, &
      -54.096874178857774_wp, 99.52786459242338_wp, -99.85808432838986_wp, 25.277777777777718_wp, &
      112.36488814608947_wp, 190.1042476563804_wp, -96.4506172839487_wp]

   !> Largest difference of the continuous extension and the state of its last stage, over the
   !> tolerance: where friction sticks the stages amplify rounding, and the extension with them. In
   !> sound steps this is below 10, in those above 1e5.
   real(wp), parameter :: disagreement = 1.0e3_wp

   !> Times of stages 15 to 17, in steps.
   real(wp), parameter :: extension_time(15:stages) = [0.5_wp*(1.0_wp - 1.0_wp/sqrt(7.0_wp)), &
      0.5_wp*(1.0_wp + 1.0_wp/sqrt(7.0_wp)), 0.6_wp]

   !> What the right-hand side tells the library, which then gives the step up: `GSL_SUCCESS`,
   !> `GSL_EBADFUNC`.
   integer(c_int), parameter :: success = 0_c_int, bad_function = 9_c_int

   !> Steps of one problem.
   type :: rk8pd_type
      class(problem_type), pointer :: problem => null()
      !> Stepper of the library.
      type(c_ptr) :: stepper = c_null_ptr
      !> The right-hand side is never evaluated beyond this time [s].
      real(wp) :: t_last = huge(1.0_wp)
      !> Right-hand sides of the stages, (unknown, stage).
      real(wp), allocatable :: k(:, :)
      !> Estimate of the local error of each unknown.
      real(wp), allocatable :: error(:)
      !> Coefficients of the continuous extension.
      real(wp), allocatable, private :: dense(:, :)
      !> State of a stage.
      real(wp), allocatable, private :: z(:)
      !> Value of the continuous extension there.
      real(wp), allocatable, private :: value(:)
      !> Last stage evaluated.
      integer, private :: stage = 0
      !> Right-hand sides evaluated so far.
      integer(i8) :: derivatives = 0
   end type rk8pd_type

   interface
      !> Make a stepper; of rk8pd.c.
      function rk8pd_new(n) result(stepper) bind(c, name="contensou_rk8pd_new")
         import :: c_ptr, c_size_t
         implicit none(type, external)
         !> Number of unknowns.
         integer(c_size_t), intent(in), value :: n
         type(c_ptr) :: stepper
      end function rk8pd_new

      !> Take a step; of rk8pd.c.
      function rk8pd_step(stepper, t, h, y, error, rate, derivative, parameters) result(code) &
         bind(c, name="contensou_rk8pd_step")
         import :: c_double, c_funptr, c_int, c_ptr
         implicit none(type, external)
         type(c_ptr), intent(in), value :: stepper
         !> Time [s].
         real(c_double), intent(in), value :: t
         !> Length of the step [s].
         real(c_double), intent(in), value :: h
         !> State, from the beginning of the step to its end.
         real(c_double), intent(inout) :: y(*)
         !> Estimate of the local error.
         real(c_double), intent(out) :: error(*)
         !> Right-hand side at the beginning of the step.
         real(c_double), intent(in) :: rate(*)
         !> Right-hand side, as `stage_callback`.
         type(c_funptr), intent(in), value :: derivative
         !> What it gets.
         type(c_ptr), intent(in), value :: parameters
         integer(c_int) :: code
      end function rk8pd_step

      !> Release a stepper; of rk8pd.c.
      subroutine rk8pd_free(stepper) bind(c, name="contensou_rk8pd_free")
         import :: c_ptr
         implicit none(type, external)
         type(c_ptr), intent(in), value :: stepper
      end subroutine rk8pd_free
   end interface

contains

   !> Begin the steps of a problem.
   subroutine begin_rk8pd(self, problem)
      type(rk8pd_type), intent(inout) :: self
      !> The problem; must outlive them.
      class(problem_type), intent(in), target :: problem

      call end_rk8pd(self)
      self%problem => problem
      self%stepper = rk8pd_new(int(problem%n, c_size_t))
      associate (n => problem%n)
         allocate(self%k(n, stages), self%error(n), self%dense(n, 7), self%z(n), &
            self%value(n))
      end associate
   end subroutine begin_rk8pd

   !> Evaluate the right-hand side as that of a stage.
   subroutine evaluate(self, stage, t, y, outside)
      !> The steps; `k` of the stage is set.
      type(rk8pd_type), intent(inout) :: self
      integer, intent(in) :: stage
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(in), contiguous :: y(:)
      !> Whether the state is outside the domain of the model.
      logical, intent(out) :: outside

      self%stage = stage
      self%derivatives = self%derivatives + 1
      call self%problem%derivative(min(t, self%t_last), y, self%k(:, stage), outside)
   end subroutine evaluate

   !> Right-hand side for the library.
   function stage_callback(t, y, rate, parameters) result(code) bind(c, name="")
      !> Time [s].
      real(c_double), intent(in), value :: t
      real(c_double), intent(in) :: y(*)
      !> Its rate of change.
      real(c_double), intent(out) :: rate(*)
      !> The steps.
      type(c_ptr), intent(in), value :: parameters
      integer(c_int) :: code
      type(rk8pd_type), pointer :: self
      logical :: outside
      integer :: n

      call c_f_pointer(parameters, self)
      n = size(self%error)
      call evaluate(self, self%stage + 1, t, y(:n), outside)
      rate(:n) = self%k(:, self%stage)
      code = merge(bad_function, success, outside)
   end function stage_callback

   !> Evaluate stages 2 to 13 of a step, of which stage 1 is set.
   subroutine take_step(self, t, h, y, y_new, outside)
      !> The steps; `k` and `error` are set.
      type(rk8pd_type), intent(inout), target :: self
      !> Beginning of the step [s].
      real(wp), intent(in) :: t
      !> Its length [s].
      real(wp), intent(in) :: h
      !> State at its beginning.
      real(wp), intent(in) :: y(:)
      !> State at its end, of order 8.
      real(wp), intent(out) :: y_new(:)
      !> Whether a stage, the last one evaluated, is outside the domain of the model.
      logical, intent(out) :: outside
      integer(c_int) :: code

      self%stage = 1
      y_new = y
      code = rk8pd_step(self%stepper, t, h, y_new, self%error, self%k(:, 1), &
         c_funloc(stage_callback), c_loc(self))
      outside = code /= success
   end subroutine take_step

   !> Set the continuous extension of a step, of which stages 1 to 14 are set.
   subroutine extend(self, t, h, y, y_new, weight)
      type(rk8pd_type), intent(inout) :: self
      !> Beginning of the step [s].
      real(wp), intent(in) :: t
      !> Its length [s].
      real(wp), intent(in) :: h
      !> State at its beginning.
      real(wp), intent(in) :: y(:)
      !> State at its end.
      real(wp), intent(in) :: y_new(:)
      !> Inverse of the admissible error of each unknown; without it the extension is not checked.
      real(wp), intent(in), optional :: weight(:)
      real(wp) :: mismatch
      logical :: outside
      integer :: i, stage

      do stage = last_stage + 1, stages
         call set_stage(stage, size(y), h, y, self%k, self%z)
         call evaluate(self, stage, t + extension_time(stage)*h, self%z, outside)
         if (outside) exit
      end do
      call set_dense(size(y), h, y, y_new, self%k, self%dense)
      if (.not. outside .and. present(weight)) then
         call dense_value(size(y), extension_time(stages), y, self%dense, self%value)
         mismatch = 0.0_wp
         do i = 1, size(y)
            mismatch = mismatch + ((self%value(i) - self%z(i))*weight(i))**2
         end do
         outside = .not. sqrt(mismatch/size(y)) <= disagreement
      end if
      ! Without these stages there is the cubic through the ends.
      if (outside) self%dense(:, 4:) = 0.0_wp
   end subroutine extend

   !> State within a step, of which the continuous extension is set.
   subroutine value_within(self, s, y, z)
      type(rk8pd_type), intent(in) :: self
      !> Time since the beginning of the step over the step, 0 to 1.
      real(wp), intent(in) :: s
      !> State at the beginning of the step.
      real(wp), intent(in) :: y(:)
      !> The state.
      real(wp), intent(out) :: z(:)

      call dense_value(size(y), s, y, self%dense, z)
   end subroutine value_within

   !> Release everything.
   subroutine end_rk8pd(self)
      type(rk8pd_type), intent(inout) :: self

      if (c_associated(self%stepper)) call rk8pd_free(self%stepper)
      self%stepper = c_null_ptr
      nullify(self%problem)
      if (allocated(self%k)) deallocate(self%k, self%error, self%dense, self%z, &
         self%value)
      self%derivatives = 0
      self%t_last = huge(1.0_wp)
   end subroutine end_rk8pd

   !> State at which the right-hand side of a stage of the continuous extension is evaluated.
   pure subroutine set_stage(stage, n, h, y, k, z)
      integer, intent(in) :: stage
      !> Number of unknowns.
      integer, intent(in) :: n
      !> Step.
      real(wp), intent(in) :: h
      !> State at the beginning of the step.
      real(wp), intent(in) :: y(n)
      !> Right-hand sides of the stages, those before this one set.
      real(wp), intent(in) :: k(n, stages)
      !> The state.
      real(wp), intent(out) :: z(n)
      integer :: i

      select case (stage)
      case (15)
         do i = 1, n
            z(i) = y(i) + h*(a15(1)*k(i, 1) + a15(2)*k(i, 6) + a15(3)*k(i, 7) + a15(4)*k(i, 8) &
               + a15(5)*k(i, 9) + a15(6)*k(i, 10) + a15(7)*k(i, 11) + a15(8)*k(i, 12) &
               + a15(9)*k(i, 13) + a15(10)*k(i, 14))
         end do
      case (16)
         do i = 1, n
            z(i) = y(i) + h*(a16(1)*k(i, 1) + a16(2)*k(i, 6) + a16(3)*k(i, 7) + a16(4)*k(i, 8) &
               + a16(5)*k(i, 9) + a16(6)*k(i, 10) + a16(7)*k(i, 11) + a16(8)*k(i, 12) &
               + a16(9)*k(i, 13) + a16(10)*k(i, 14))
         end do
      case default
         do i = 1, n
            z(i) = y(i) + h*(a17(1)*k(i, 1) + a17(2)*k(i, 6) + a17(3)*k(i, 7) + a17(4)*k(i, 8) &
               + a17(5)*k(i, 9) + a17(6)*k(i, 10) + a17(7)*k(i, 11) + a17(8)*k(i, 12) &
               + a17(9)*k(i, 13) + a17(10)*k(i, 14) + a17(11)*k(i, 15) + a17(12)*k(i, 16))
         end do
      end select
   end subroutine set_stage

   !> Coefficients of the continuous extension.
   pure subroutine set_dense(n, h, y, y_new, k, dense)
      !> Number of unknowns.
      integer, intent(in) :: n
      !> Step.
      real(wp), intent(in) :: h
      !> State at the beginning of the step.
      real(wp), intent(in) :: y(n)
      !> State at its end.
      real(wp), intent(in) :: y_new(n)
      !> Right-hand sides of all stages.
      real(wp), intent(in) :: k(n, stages)
      !> The coefficients.
      real(wp), intent(out) :: dense(n, 7)
      integer :: i

      do i = 1, n
         dense(i, 1) = y_new(i) - y(i)
         dense(i, 2) = h*k(i, 1) - dense(i, 1)
         dense(i, 3) = dense(i, 1) - h*k(i, 14) - dense(i, 2)
         dense(i, 4) = h*(d4(1)*k(i, 1) + d4(2)*k(i, 6) + d4(3)*k(i, 7) + d4(4)*k(i, 8) &
            + d4(5)*k(i, 9) + d4(6)*k(i, 10) + d4(7)*k(i, 11) + d4(8)*k(i, 12) + d4(9)*k(i, 13) &
            + d4(10)*k(i, 14) + d4(11)*k(i, 15) + d4(12)*k(i, 16))
         dense(i, 5) = h*(d5(1)*k(i, 1) + d5(2)*k(i, 6) + d5(3)*k(i, 7) + d5(4)*k(i, 8) &
            + d5(5)*k(i, 9) + d5(6)*k(i, 10) + d5(7)*k(i, 11) + d5(8)*k(i, 12) + d5(9)*k(i, 13) &
            + d5(10)*k(i, 14) + d5(11)*k(i, 15) + d5(12)*k(i, 16) + d5(13)*k(i, 17))
         dense(i, 6) = h*(d6(1)*k(i, 1) + d6(2)*k(i, 6) + d6(3)*k(i, 7) + d6(4)*k(i, 8) &
            + d6(5)*k(i, 9) + d6(6)*k(i, 10) + d6(7)*k(i, 11) + d6(8)*k(i, 12) + d6(9)*k(i, 13) &
            + d6(10)*k(i, 14) + d6(11)*k(i, 15) + d6(12)*k(i, 16) + d6(13)*k(i, 17))
         dense(i, 7) = h*(d7(1)*k(i, 1) + d7(2)*k(i, 6) + d7(3)*k(i, 7) + d7(4)*k(i, 8) &
            + d7(5)*k(i, 9) + d7(6)*k(i, 10) + d7(7)*k(i, 11) + d7(8)*k(i, 12) + d7(9)*k(i, 13) &
            + d7(10)*k(i, 14) + d7(11)*k(i, 15) + d7(12)*k(i, 16) + d7(13)*k(i, 17))
      end do
   end subroutine set_dense

   !> State within a step.
   pure subroutine dense_value(n, s, y, dense, z)
      !> Number of unknowns.
      integer, intent(in) :: n
      !> Time since the beginning of the step over the step, 0 to 1.
      real(wp), intent(in) :: s
      !> State at the beginning of the step.
      real(wp), intent(in) :: y(n)
      !> Coefficients of `set_dense`.
      real(wp), intent(in) :: dense(n, 7)
      !> The state.
      real(wp), intent(out) :: z(n)
      real(wp) :: r, sr2
      integer :: i

      r = 1.0_wp - s
      sr2 = (s*r)**2
      do i = 1, n
         z(i) = y(i) + (s*(dense(i, 1) + r*(dense(i, 2) + s*dense(i, 3))) &
            + sr2*(dense(i, 4) + s*(dense(i, 5) + s*(dense(i, 6) + s*dense(i, 7)))))
      end do
   end subroutine dense_value

end module contensou_integrate_rk8pd
