!> The explicit Runge-Kutta pair RK8(7)13M of Prince and Dormand as the GNU Scientific Library takes
!> it (`rk8pd`), with a continuous extension of order 7, which the library does not have.
!>
!> Stages 1 to 13 make the step and its estimate of the local error; stage 14 is the right-hand side
!> at the end of the step, which is the first stage of the next one; stages 15 to 18 are for the
!> continuous extension alone.
!> P. J. Prince, J. R. Dormand, J. Comput. Appl. Math. 7 (1981) 67.
!>
!> With s the share of the step, the extension is the cubic through both ends with their
!> derivatives, and s^2 (1 - s)^2 times a cubic in s of each stage. The coefficients are the
!> smallest ones (least squares) that meet all conditions of order 7. Stage 15 is at a state of
!> order 5, stages 16 to 18 at states of order 6, again with the smallest coefficients.
module contensou_integrate_rk8pd
   use, intrinsic :: iso_c_binding, only : c_associated, c_double, c_f_pointer, c_funloc, &
      c_funptr, c_int, c_loc, c_null_ptr, c_ptr, c_size_t
   use contensou_base_kinds, only : i8, wp
   use contensou_integrate_problem, only : problem_type
   implicit none(type, external)
   private

   public :: rk8pd_type, begin_rk8pd, evaluate, take_step, extend, value_within, end_rk8pd

   !> Number of stages, those of the continuous extension included.
   integer, parameter :: stages = 18

   !> Last stage of a step, its end.
   integer, parameter, public :: last_stage = 14

   !> Stage 15, of stages 1, 6 to 14.
   real(wp), parameter :: a15(*) = [4.3129628817729276e-2_wp, 0.11210351497509602_wp, &
      0.22992106535095133_wp, 4.2908927574396433e-2_wp, -9.6007583214806503e-3_wp, &
      -2.6482844085009647e-2_wp, 1.7099061300151024e-2_wp, -3.0261985372753734e-3_wp, &
      -3.0261985372787041e-3_wp, -3.0261985372796825e-3_wp]

   !> Stage 16, of stages 1, 6 to 15.
   real(wp), parameter :: a16(*) = [4.8280883560484024e-2_wp, 5.2025686712295488e-2_wp, &
      0.19565397716800276_wp, 1.8967780022043294e-2_wp, 4.8417758172695259e-3_wp, &
      -1.5180286980277309e-3_wp, -2.3136269869787618e-3_wp, 7.7111008987733216e-3_wp, &
      -3.057004835749061e-3_wp, -3.274356617646162e-3_wp, -6.7318187040466701e-2_wp]

   !> Stage 17, of stages 1, 6 to 16.
   real(wp), parameter :: a17(*) = [5.260826850764571e-2_wp, 5.6022553470348659e-2_wp, &
      0.15963580258464088_wp, 3.7296849829459459e-2_wp, 2.3303632789068576e-2_wp, &
      2.9387097502004619e-3_wp, -7.7493793985021625e-3_wp, 8.0556184190399074e-3_wp, &
      -1.2592377894926827e-2_wp, 8.797939246262548e-3_wp, 5.3415899125925474e-2_wp, &
      0.11826648357083731_wp]

   !> Stage 18, of stages 1, 6 to 17.
   real(wp), parameter :: a18(*) = [4.8072148726653226e-2_wp, 0.11254856089494052_wp, &
      0.19128753796741954_wp, 7.4254531926870981e-2_wp, 5.1047094675663582e-2_wp, &
      4.6902992486296931e-2_wp, -2.7211071696017857e-3_wp, -1.4173628643638268e-2_wp, &
      -4.6738737126369948e-3_wp, 2.0223448202567669e-2_wp, -1.0525098145327792e-2_wp, &
      6.6196715922637206e-2_wp, 7.1560676868155107e-2_wp]

   !> Coefficient 4 of the continuous extension, of stages 1, 6 to 14, 16 to 18.
   real(wp), parameter :: d4(*) = [-6.7571314525530815_wp, 12.263739423991613_wp, &
      24.83388012266146_wp, 5.548099130293327_wp, 3.2197646064874803_wp, 4.896365279384322_wp, &
      0.12308159788058258_wp, -0.8998219576780306_wp, -4.6574608335017247e-2_wp, &
      1.611995177818265_wp, -27.73333333332578_wp, -9.33220815750973_wp, -7.727855829115406_wp]

   !> Coefficient 5 of the continuous extension, of stages 1, 6 to 14, 16 to 18.
   real(wp), parameter :: d5(*) = [21.485754255712944_wp, -63.10061103777133_wp, &
      -114.79244215799561_wp, -23.852657452933972_wp, -11.341797117410918_wp, &
      -36.223036206272056_wp, -8.836831482520596_wp, 19.184516874255863_wp, &
      -15.119844717681358_wp, 0.8231464737912347_wp, 157.86666666672218_wp, 17.23619315518419_wp, &
      56.670942746919394_wp]

   !> Coefficient 6 of the continuous extension, of stages 1, 6 to 14, 16 to 18.
   real(wp), parameter :: d6(*) = [-30.072555303762552_wp, 112.67893628315662_wp, &
      188.5295537482361_wp, 36.62470662160901_wp, 13.662264724044965_wp, 78.62742415068105_wp, &
      26.162838420166917_wp, -52.68043809736224_wp, 46.441044202205696_wp, -5.879204340000362_wp, &
      -285.86666666689337_wp, 21.177308954393897_wp, -149.40521269647576_wp]

   !> Coefficient 7 of the continuous extension, of stages 1, 6 to 14, 16 to 18.
   real(wp), parameter :: d7(*) = [15.292055805866559_wp, -74.12102509890381_wp, &
      -105.06327572934279_wp, -17.204895010056717_wp, -1.4141627223088753_wp, &
      -67.76162949665179_wp, -29.1608933387102_wp, 55.85894030035997_wp, -52.92754898566882_wp, &
      12.074743821621961_wp, 170.66666666702648_wp, -29.884669479377568_wp, 123.64569326614559_wp]

   !> Times of stages 15 to 18, in steps.
   real(wp), parameter :: extension_time(15:stages) = [0.4_wp, 0.25_wp, 0.5_wp, 0.65_wp]

   !> What the right-hand side tells the library, which then gives the step up: `GSL_SUCCESS`,
   !> `GSL_EBADFUNC`.
   integer(c_int), parameter :: success = 0_c_int, bad_function = 9_c_int

   !> Steps of one problem.
   type :: rk8pd_type
      !> The problem.
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
         !> The stepper.
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
         !> The stepper.
         type(c_ptr), intent(in), value :: stepper
      end subroutine rk8pd_free
   end interface

contains

   !> Begin the steps of a problem.
   subroutine begin_rk8pd(self, problem)
      !> The steps.
      type(rk8pd_type), intent(inout) :: self
      !> The problem; must outlive them.
      class(problem_type), intent(in), target :: problem

      call end_rk8pd(self)
      self%problem => problem
      self%stepper = rk8pd_new(int(problem%n, c_size_t))
      associate (n => problem%n)
         allocate(self%k(n, stages), self%error(n), self%dense(n, 7), self%z(n))
      end associate
   end subroutine begin_rk8pd

   !> Evaluate the right-hand side as that of a stage.
   subroutine evaluate(self, stage, t, y, outside)
      !> The steps; `k` of the stage is set.
      type(rk8pd_type), intent(inout) :: self
      !> The stage.
      integer, intent(in) :: stage
      !> Time [s].
      real(wp), intent(in) :: t
      !> State.
      real(wp), intent(in) :: y(:)
      !> Whether the state is outside the domain of the model.
      logical, intent(out) :: outside

      self%stage = stage
      self%derivatives = self%derivatives + 1
      call self%problem%derivative(min(t, self%t_last), y, self%k(:, stage), outside)
   end subroutine evaluate

   !> Right-hand side for the library.
   function stage_callback(t, y, rate, parameters) result(code) bind(c)
      !> Time [s].
      real(c_double), intent(in), value :: t
      !> State.
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
   subroutine extend(self, t, h, y, y_new)
      !> The steps.
      type(rk8pd_type), intent(inout) :: self
      !> Beginning of the step [s].
      real(wp), intent(in) :: t
      !> Its length [s].
      real(wp), intent(in) :: h
      !> State at its beginning.
      real(wp), intent(in) :: y(:)
      !> State at its end.
      real(wp), intent(in) :: y_new(:)
      logical :: outside
      integer :: stage

      do stage = last_stage + 1, stages
         call set_stage(stage, size(y), h, y, self%k, self%z)
         call evaluate(self, stage, t + extension_time(stage)*h, self%z, outside)
         if (outside) exit
      end do
      call set_dense(size(y), h, y, y_new, self%k, self%dense)
      ! Without these stages there is the cubic through the ends.
      if (outside) self%dense(:, 4:) = 0.0_wp
   end subroutine extend

   !> State within a step, of which the continuous extension is set.
   subroutine value_within(self, s, y, z)
      !> The steps.
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
      !> The steps.
      type(rk8pd_type), intent(inout) :: self

      if (c_associated(self%stepper)) call rk8pd_free(self%stepper)
      self%stepper = c_null_ptr
      nullify(self%problem)
      if (allocated(self%k)) deallocate(self%k, self%error, self%dense, self%z)
      self%derivatives = 0
      self%t_last = huge(1.0_wp)
   end subroutine end_rk8pd

   !> State at which the right-hand side of a stage of the continuous extension is evaluated.
   pure subroutine set_stage(stage, n, h, y, k, z)
      !> The stage, 15 to 18.
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
               + a16(9)*k(i, 13) + a16(10)*k(i, 14) + a16(11)*k(i, 15))
         end do
      case (17)
         do i = 1, n
            z(i) = y(i) + h*(a17(1)*k(i, 1) + a17(2)*k(i, 6) + a17(3)*k(i, 7) + a17(4)*k(i, 8) &
               + a17(5)*k(i, 9) + a17(6)*k(i, 10) + a17(7)*k(i, 11) + a17(8)*k(i, 12) &
               + a17(9)*k(i, 13) + a17(10)*k(i, 14) + a17(11)*k(i, 15) + a17(12)*k(i, 16))
         end do
      case default
         do i = 1, n
            z(i) = y(i) + h*(a18(1)*k(i, 1) + a18(2)*k(i, 6) + a18(3)*k(i, 7) + a18(4)*k(i, 8) &
               + a18(5)*k(i, 9) + a18(6)*k(i, 10) + a18(7)*k(i, 11) + a18(8)*k(i, 12) &
               + a18(9)*k(i, 13) + a18(10)*k(i, 14) + a18(11)*k(i, 15) + a18(12)*k(i, 16) &
               + a18(13)*k(i, 17))
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
            + d4(10)*k(i, 14) + d4(11)*k(i, 16) + d4(12)*k(i, 17) + d4(13)*k(i, 18))
         dense(i, 5) = h*(d5(1)*k(i, 1) + d5(2)*k(i, 6) + d5(3)*k(i, 7) + d5(4)*k(i, 8) &
            + d5(5)*k(i, 9) + d5(6)*k(i, 10) + d5(7)*k(i, 11) + d5(8)*k(i, 12) + d5(9)*k(i, 13) &
            + d5(10)*k(i, 14) + d5(11)*k(i, 16) + d5(12)*k(i, 17) + d5(13)*k(i, 18))
         dense(i, 6) = h*(d6(1)*k(i, 1) + d6(2)*k(i, 6) + d6(3)*k(i, 7) + d6(4)*k(i, 8) &
            + d6(5)*k(i, 9) + d6(6)*k(i, 10) + d6(7)*k(i, 11) + d6(8)*k(i, 12) + d6(9)*k(i, 13) &
            + d6(10)*k(i, 14) + d6(11)*k(i, 16) + d6(12)*k(i, 17) + d6(13)*k(i, 18))
         dense(i, 7) = h*(d7(1)*k(i, 1) + d7(2)*k(i, 6) + d7(3)*k(i, 7) + d7(4)*k(i, 8) &
            + d7(5)*k(i, 9) + d7(6)*k(i, 10) + d7(7)*k(i, 11) + d7(8)*k(i, 12) + d7(9)*k(i, 13) &
            + d7(10)*k(i, 14) + d7(11)*k(i, 16) + d7(12)*k(i, 17) + d7(13)*k(i, 18))
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
