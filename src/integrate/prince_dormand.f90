!> The explicit Runge-Kutta pair RK8(7)13M of Prince and Dormand, with a continuous extension of
!> order 7.
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
module contensou_integrate_prince_dormand
   use contensou_base_kinds, only : wp
   implicit none(type, external)
   private

   public :: set_stage, local_error, set_dense, dense_value, stages, step_stages, stage_time

   !> Number of stages, those of the continuous extension included.
   integer, parameter :: stages = 18

   !> Number of stages of a step, its end included.
   integer, parameter :: step_stages = 14

   !> Stage 2, of stage 1.
   real(wp), parameter :: a2(*) = [1.0_wp/18.0_wp]

   !> Stage 3, of stages 1, 2.
   real(wp), parameter :: a3(*) = [1.0_wp/48.0_wp, 1.0_wp/16.0_wp]

   !> Stage 4, of stages 1, 3.
   real(wp), parameter :: a4(*) = [1.0_wp/32.0_wp, 3.0_wp/32.0_wp]

   !> Stage 5, of stages 1, 3, 4.
   real(wp), parameter :: a5(*) = [5.0_wp/16.0_wp, -75.0_wp/64.0_wp, 75.0_wp/64.0_wp]

   !> Stage 6, of stages 1, 4, 5.
   real(wp), parameter :: a6(*) = [3.0_wp/80.0_wp, 3.0_wp/16.0_wp, 3.0_wp/20.0_wp]

   !> Stage 7, of stages 1, 4 to 6.
   real(wp), parameter :: a7(*) = [29443841.0_wp/614563906.0_wp, 77736538.0_wp/692538347.0_wp, &
      -28693883.0_wp/1125000000.0_wp, 23124283.0_wp/1800000000.0_wp]

   !> Stage 8, of stages 1, 4 to 7.
   real(wp), parameter :: a8(*) = [16016141.0_wp/946692911.0_wp, 61564180.0_wp/158732637.0_wp, &
      22789713.0_wp/633445777.0_wp, 545815736.0_wp/2771057229.0_wp, &
      -180193667.0_wp/1043307555.0_wp]

   !> Stage 9, of stages 1, 4 to 8.
   real(wp), parameter :: a9(*) = [39632708.0_wp/573591083.0_wp, -433636366.0_wp/683701615.0_wp, &
      -421739975.0_wp/2616292301.0_wp, 100302831.0_wp/723423059.0_wp, &
      790204164.0_wp/839813087.0_wp, 800635310.0_wp/3783071287.0_wp]

   !> Stage 10, of stages 1, 4 to 9.
   real(wp), parameter :: a10(*) = [246121993.0_wp/1340847787.0_wp, &
      -37695042795.0_wp/15268766246.0_wp, -309121744.0_wp/1061227803.0_wp, &
      -12992083.0_wp/490766935.0_wp, 6005943493.0_wp/2108947869.0_wp, &
      393006217.0_wp/1396673457.0_wp, 123872331.0_wp/1001029789.0_wp]

   !> Stage 11, of stages 1, 4 to 10.
   real(wp), parameter :: a11(*) = [-1028468189.0_wp/846180014.0_wp, &
      8478235783.0_wp/508512852.0_wp, 1311729495.0_wp/1432422823.0_wp, &
      -10304129995.0_wp/1701304382.0_wp, -48777925059.0_wp/3047939560.0_wp, &
      15336726248.0_wp/1032824649.0_wp, -45442868181.0_wp/3398467696.0_wp, &
      3065993473.0_wp/597172653.0_wp]

   !> Stage 12, of stages 1, 4 to 11.
   real(wp), parameter :: a12(*) = [185892177.0_wp/718116043.0_wp, &
      -3185094517.0_wp/667107341.0_wp, -477755414.0_wp/1098053517.0_wp, &
      -703635378.0_wp/230739211.0_wp, 5731566787.0_wp/1027545527.0_wp, &
      5232866602.0_wp/850066563.0_wp, -4093664535.0_wp/808688257.0_wp, &
      3962137247.0_wp/1805957418.0_wp, 65686358.0_wp/487910083.0_wp]

   !> Stage 13, of stages 1, 4 to 11.
   real(wp), parameter :: a13(*) = [403863854.0_wp/491063109.0_wp, &
      -5068492393.0_wp/434740067.0_wp, -411421997.0_wp/543043805.0_wp, &
      652783627.0_wp/914296604.0_wp, 11173962825.0_wp/925320556.0_wp, &
      -13158990841.0_wp/6184727034.0_wp, 3936647629.0_wp/1978049680.0_wp, &
      -160528059.0_wp/685178525.0_wp, 248638103.0_wp/1413531060.0_wp]

   !> Solution of order 8, of stages 1, 6 to 13.
   real(wp), parameter :: b(*) = [14005451.0_wp/335480064.0_wp, -59238493.0_wp/1068277825.0_wp, &
      181606767.0_wp/758867731.0_wp, 561292985.0_wp/797845732.0_wp, &
      -1041891430.0_wp/1371343529.0_wp, 760417239.0_wp/1151165299.0_wp, &
      118820643.0_wp/751138087.0_wp, -528747749.0_wp/2220607170.0_wp, 1.0_wp/4.0_wp]

   !> Solution of order 7, of stages 1, 6 to 12.
   real(wp), parameter :: b7(*) = [13451932.0_wp/455176623.0_wp, -808719846.0_wp/976000145.0_wp, &
      1757004468.0_wp/5645159321.0_wp, 656045339.0_wp/265891186.0_wp, &
      -3867574721.0_wp/1518517206.0_wp, 465885868.0_wp/322736535.0_wp, &
      53011238.0_wp/667516719.0_wp, 2.0_wp/45.0_wp]

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

   !> Times of the stages, in steps.
   real(wp), parameter :: stage_time(stages) = [0.0_wp, 1.0_wp/18.0_wp, 1.0_wp/12.0_wp, &
      1.0_wp/8.0_wp, 5.0_wp/16.0_wp, 3.0_wp/8.0_wp, 59.0_wp/400.0_wp, 93.0_wp/200.0_wp, &
      5490023248.0_wp/9719169821.0_wp, 13.0_wp/20.0_wp, 1201146811.0_wp/1299019798.0_wp, 1.0_wp, &
      1.0_wp, 1.0_wp, 0.4_wp, 0.25_wp, 0.5_wp, 0.65_wp]

   !> Difference of both solutions, of the stages of `b`.
   real(wp), parameter :: e(*) = b - [b7, 0.0_wp]

contains

   !> State at which the right-hand side of a stage is evaluated; that of stage 14 is the solution.
   pure subroutine set_stage(stage, n, h, y, k, z)
      !> The stage, 2 to 18.
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
      case (2)
         do i = 1, n
            z(i) = y(i) + h*a2(1)*k(i, 1)
         end do
      case (3)
         do i = 1, n
            z(i) = y(i) + h*(a3(1)*k(i, 1) + a3(2)*k(i, 2))
         end do
      case (4)
         do i = 1, n
            z(i) = y(i) + h*(a4(1)*k(i, 1) + a4(2)*k(i, 3))
         end do
      case (5)
         do i = 1, n
            z(i) = y(i) + h*(a5(1)*k(i, 1) + a5(2)*k(i, 3) + a5(3)*k(i, 4))
         end do
      case (6)
         do i = 1, n
            z(i) = y(i) + h*(a6(1)*k(i, 1) + a6(2)*k(i, 4) + a6(3)*k(i, 5))
         end do
      case (7)
         do i = 1, n
            z(i) = y(i) + h*(a7(1)*k(i, 1) + a7(2)*k(i, 4) + a7(3)*k(i, 5) + a7(4)*k(i, 6))
         end do
      case (8)
         do i = 1, n
            z(i) = y(i) + h*(a8(1)*k(i, 1) + a8(2)*k(i, 4) + a8(3)*k(i, 5) + a8(4)*k(i, 6) &
               + a8(5)*k(i, 7))
         end do
      case (9)
         do i = 1, n
            z(i) = y(i) + h*(a9(1)*k(i, 1) + a9(2)*k(i, 4) + a9(3)*k(i, 5) + a9(4)*k(i, 6) &
               + a9(5)*k(i, 7) + a9(6)*k(i, 8))
         end do
      case (10)
         do i = 1, n
            z(i) = y(i) + h*(a10(1)*k(i, 1) + a10(2)*k(i, 4) + a10(3)*k(i, 5) + a10(4)*k(i, 6) &
               + a10(5)*k(i, 7) + a10(6)*k(i, 8) + a10(7)*k(i, 9))
         end do
      case (11)
         do i = 1, n
            z(i) = y(i) + h*(a11(1)*k(i, 1) + a11(2)*k(i, 4) + a11(3)*k(i, 5) + a11(4)*k(i, 6) &
               + a11(5)*k(i, 7) + a11(6)*k(i, 8) + a11(7)*k(i, 9) + a11(8)*k(i, 10))
         end do
      case (12)
         do i = 1, n
            z(i) = y(i) + h*(a12(1)*k(i, 1) + a12(2)*k(i, 4) + a12(3)*k(i, 5) + a12(4)*k(i, 6) &
               + a12(5)*k(i, 7) + a12(6)*k(i, 8) + a12(7)*k(i, 9) + a12(8)*k(i, 10) &
               + a12(9)*k(i, 11))
         end do
      case (13)
         do i = 1, n
            z(i) = y(i) + h*(a13(1)*k(i, 1) + a13(2)*k(i, 4) + a13(3)*k(i, 5) + a13(4)*k(i, 6) &
               + a13(5)*k(i, 7) + a13(6)*k(i, 8) + a13(7)*k(i, 9) + a13(8)*k(i, 10) &
               + a13(9)*k(i, 11))
         end do
      case (14)
         do i = 1, n
            z(i) = y(i) + h*(b(1)*k(i, 1) + b(2)*k(i, 6) + b(3)*k(i, 7) + b(4)*k(i, 8) &
               + b(5)*k(i, 9) + b(6)*k(i, 10) + b(7)*k(i, 11) + b(8)*k(i, 12) + b(9)*k(i, 13))
         end do
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

   !> Estimate of the local error, 1 at the tolerance: the root of the mean of the squares of the
   !> errors over the admissible ones. It is proportional to the eighth power of the step.
   pure function local_error(n, h, weight, k) result(error)
      !> Number of unknowns.
      integer, intent(in) :: n
      !> Step.
      real(wp), intent(in) :: h
      !> Inverse of the admissible error of each unknown.
      real(wp), intent(in) :: weight(n)
      !> Right-hand sides of stages 1 to 13.
      real(wp), intent(in) :: k(n, stages)
      real(wp) :: error
      real(wp) :: e7, total
      integer :: i

      total = 0.0_wp
      do i = 1, n
         e7 = e(1)*k(i, 1) + e(2)*k(i, 6) + e(3)*k(i, 7) + e(4)*k(i, 8) + e(5)*k(i, 9) &
            + e(6)*k(i, 10) + e(7)*k(i, 11) + e(8)*k(i, 12) + e(9)*k(i, 13)
         total = total + (weight(i)*e7)**2
      end do
      error = abs(h)*sqrt(total/n)
   end function local_error

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

end module contensou_integrate_prince_dormand
