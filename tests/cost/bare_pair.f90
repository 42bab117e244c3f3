!> The explicit Runge-Kutta pair RK8(7)13M of Prince and Dormand, as the compiler makes it: the
!> yardstick of what a library adds, and of whether it takes the same pair.
!>
!> P. J. Prince, J. R. Dormand, J. Comput. Appl. Math. 7 (1981) 67.
module cost_bare_pair
   use contensou_base_kinds, only : wp
   implicit none(type, external)
   private

   public :: set_stage, local_error, stages, step_stages, stage_time

   !> Number of stages.
   integer, parameter :: stages = 13

   !> Number of the stage that is the end of the step.
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

   !> Times of the stages, in steps.
   real(wp), parameter :: stage_time(stages) = [0.0_wp, 1.0_wp/18.0_wp, 1.0_wp/12.0_wp, &
      1.0_wp/8.0_wp, 5.0_wp/16.0_wp, 3.0_wp/8.0_wp, 59.0_wp/400.0_wp, 93.0_wp/200.0_wp, &
      5490023248.0_wp/9719169821.0_wp, 13.0_wp/20.0_wp, 1201146811.0_wp/1299019798.0_wp, 1.0_wp, &
      1.0_wp]

   !> Difference of both solutions, of the stages of `b`.
   real(wp), parameter :: e(*) = b - [b7, 0.0_wp]

contains

   !> State at which the right-hand side of a stage is evaluated; that of stage 14 is the solution.
   pure subroutine set_stage(stage, n, h, y, k, z)
      !> The stage, 2 to 14.
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
      case default
         do i = 1, n
            z(i) = y(i) + h*(b(1)*k(i, 1) + b(2)*k(i, 6) + b(3)*k(i, 7) + b(4)*k(i, 8) &
               + b(5)*k(i, 9) + b(6)*k(i, 10) + b(7)*k(i, 11) + b(8)*k(i, 12) + b(9)*k(i, 13))
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

end module cost_bare_pair
