!> Laws of creep: what is prepared for a spot that stays the same gives the wrench of one that is
!> met once; derivatives without load, and those of the linear theory; the table of the theory of
!> strips; and the angles that are taken without a library.
module test_creep
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite
   use contensou_base_kinds, only : pi, wp
   use contensou_contact_creep, only : creep_model_type, creep_models, creep_type
   use contensou_contact_creep_law, only : creep_motion_type, creep_spot, creep_spot_type, &
      n_arguments, passing_type, settled_spot
   use contensou_contact_creep_slip_path, only : follow_path
   use contensou_contact_friction_law, only : sliding_type
   use contensou_contact_kalker, only : kalker_matrix, least_ratio
   use contensou_contact_spot, only : elliptic_shape
   use contensou_special_angle, only : largest_small, quadrant_angle, small_turn
   use test_harness, only : check, check_close, random_type, worst_type
   implicit none(type, external)
   private

   public :: run_creep_tests

contains

   !> All tests of this suite.
   subroutine run_creep_tests()
      call test_angles()
      call test_settled_spots()
      call test_needles()
      call test_no_load()
      call test_linear_slopes()
      call test_strips()
      call test_slip_path()
   end subroutine run_creep_tests

   !> The path from full sliding comes to tractions that meet the conditions, with any influences:
   !> with those that are not positive, it turns back on its way.
   subroutine test_slip_path()
      integer, parameter :: n = 4
      real(wp), parameter :: rho = 0.5_wp, share = 1.0e4_wp
      type(random_type) :: random
      type(worst_type) :: worst
      real(wp) :: influence(2*n, 2*n), rigid(2*n), bound(n), p(2*n), q(2*n), speed(n)
      integer :: i, j, k, stuck, lost
      logical :: found

      stuck = 0
      lost = 0
      do k = 1, 300
         do j = 1, 2*n
            rigid(j) = 0.4_wp*random%uniform(-1.0_wp, 1.0_wp)
            do i = 1, 2*n
               influence(i, j) = random%uniform(-0.5_wp, 0.5_wp)
            end do
            influence(j, j) = 1.0_wp
         end do
         do i = 1, n
            bound(i) = random%uniform(0.3_wp, 1.0_wp)
         end do
         speed = hypot(rigid(:n), rigid(n + 1:))
         p = -[bound*rigid(:n)/speed, bound*rigid(n + 1:)/speed]
         call follow_path(influence, rigid, bound, rho, 1.0e-10_wp, share, p, found)
         if (.not. found) lost = lost + 1
         if (.not. found) cycle
         q = p - rho*(rigid + matmul(influence, p))
         speed = hypot(q(:n), q(n + 1:))
         stuck = stuck + count(speed <= bound)
         speed = min(1.0_wp, bound/speed)
         ! An element may be past its turn by a part of 1e-6.
         call worst%note(maxval(abs(p - [speed*q(:n), speed*q(n + 1:)])), k)
      end do
      call check(lost == 0, "the path comes to its end")
      call check(stuck > n .and. stuck < 300*n - n, "some elements stick, some slip")
      call worst%check_below(2.0e-6_wp, "tractions at the end of the path")
   end subroutine test_slip_path

   !> Angles of unit vectors, and rotations, against functions of the library.
   subroutine test_angles()
      integer, parameter :: n = 10000
      type(random_type) :: random
      type(worst_type) :: absolute, relative, turned
      real(wp) :: angle, c, s
      integer :: i

      do i = 1, n
         angle = 0.5_wp*pi*real(i, wp)/real(n, wp)
         s = sin(angle)
         c = cos(angle)
         call absolute%note(abs(quadrant_angle(c, s, s*s) - angle), i)
         call absolute%note(abs(quadrant_angle(s, c, c*c) - (0.5_wp*pi - angle)), i)
         angle = 10.0_wp**random%uniform(-150.0_wp, 0.0_wp)
         call relative%note(abs(quadrant_angle(cos(angle), sin(angle), sin(angle)**2)/angle &
            - 1.0_wp), i)
         angle = random%uniform(0.0_wp, largest_small)
         call small_turn(angle, c, s)
         call turned%note(max(abs(c - cos(angle)), abs(s - sin(angle))), i)
      end do
      call absolute%check_below(4.0_wp*epsilon(angle), "angles of unit vectors")
      call relative%check_below(4.0_wp*epsilon(angle), "small angles of unit vectors")
      call turned%check_below(epsilon(angle), "small rotations")
      call check_close(quadrant_angle(0.0_wp, 1.0_wp, 1.0_wp), 0.5_wp*pi, 0.0_wp, &
         "the angle of the y axis")
   end subroutine test_angles

   !> Kalker's coefficients beyond the table of ratios: they go on from its end, their slopes are
   !> those of differences, and what dissipates stays positive.
   subroutine test_needles()
      real(wp), parameter :: change = 1.0e-6_wp
      type(random_type) :: random
      type(worst_type) :: jump, rate
      real(wp), dimension(3, 3) :: here, there, slope, other, ahead, behind
      real(wp) :: poisson, angle, k
      integer :: i

      do i = 1, 200
         poisson = random%uniform(0.0_wp, 0.5_wp)
         ! Near the axis, and anywhere.
         angle = 0.5_wp*pi*10.0_wp**random%uniform(-3.0_wp, 0.0_wp)
         call kalker_matrix(least_ratio, poisson, [cos(angle), sin(angle)], here, slope)
         call kalker_matrix(least_ratio*(1.0_wp - change), poisson, [cos(angle), sin(angle)], &
            there, other)
         call jump%note(maxval(abs(there - here))/maxval(abs(here)), i)
         call jump%note(maxval(abs(other - slope))/maxval(abs(slope)), i)
         k = least_ratio*10.0_wp**random%uniform(-3.0_wp, 0.0_wp)
         call kalker_matrix(k, poisson, [cos(angle), sin(angle)], here, slope)
         associate (turn => change*min(angle, 0.5_wp*pi - angle))
            call kalker_matrix(k, poisson, [cos(angle + turn), sin(angle + turn)], ahead, other)
            call kalker_matrix(k, poisson, [cos(angle - turn), sin(angle - turn)], behind, other)
            call rate%note(maxval(abs((ahead - behind)/(2.0_wp*turn) - slope)) &
               /maxval(abs(slope)), i)
         end associate
         call kalker_matrix(10.0_wp**random%uniform(-300.0_wp, -1.0_wp), poisson, &
            [cos(angle), sin(angle)], there, other)
         call check(all(ieee_is_finite(there)) .and. all(ieee_is_finite(other)), &
            "Kalker's coefficients of any needle are numbers")
         call check(all([here(1, 1), here(2, 2), here(3, 3), here(1, 1)*here(2, 2) &
            - here(1, 2)**2] > 0.0_wp), "Kalker's coefficients of a needle dissipate")
      end do
      call jump%check_below(1.0e-5_wp, "Kalker's coefficients go on beyond the table")
      call rate%check_below(1.0e-6_wp, "slopes of Kalker's coefficients of a needle")
   end subroutine test_needles

   !> Wrenches of random spots, beyond the table of ratios too, rolling along axes and between them.
   subroutine test_settled_spots()
      type(creep_model_type), allocatable :: models(:)
      class(creep_type), allocatable :: law
      type(creep_spot_type) :: spot
      type(creep_motion_type) :: motion
      type(random_type) :: random
      type(worst_type) :: worst
      real(wp) :: one(3), other(3), e(3), v(3)
      integer :: i, j

      models = creep_models()
      do i = 1, size(models)
         ! As it takes 0.1 s, and nothing is prepared for it.
         if (models(i)%info%name == "boundary_elements") cycle
         worst = worst_type()
         call models(i)%make(law)
         do j = 1, 300
            spot = creep_spot(elliptic_shape(10.0_wp**random%uniform(-1.5_wp, 0.0_wp)), 0.3_wp, &
               8.0e10_wp, random%uniform(0.0_wp, 0.5_wp))
            e = random%vector(3)
            if (mod(j, 10) == 0) e(1) = 0.0_wp
            if (mod(j, 10) == 5) e(2) = 0.0_wp
            v = random%vector(3)*10.0_wp**random%uniform(-2.0_wp, 2.0_wp)
            motion = creep_motion_type(v(1), v(2), v(3), e(1), e(2))
            call law%kernel(spot, motion, one)
            call law%kernel(settled_spot(spot), motion, other)
            call worst%note(maxval(abs(one - other))/max(1.0_wp, maxval(abs(one))), j)
         end do
         call worst%check_below(2.0e-14_wp, "creep: a spot that stays the same, by " // &
            trim(models(i)%info%name))
      end do
   end subroutine test_settled_spots

   !> Where damping takes the load off a spot there is no wrench, and the first load meets full
   !> sliding. The linear theory, which does not depend on load, has no derivative by it.
   subroutine test_no_load()
      type(creep_model_type), allocatable :: models(:)
      class(creep_type), allocatable :: law
      type(creep_spot_type) :: spot
      type(passing_type) :: at, slides
      type(random_type) :: random
      type(worst_type) :: worst
      real(wp) :: force(3), slopes(3, n_arguments), by_load(3), v(5)
      integer :: i, j
      logical :: finite

      models = creep_models()
      do i = 1, size(models)
         worst = worst_type()
         finite = .true.
         call models(i)%make(law)
         do j = 1, 100
            spot = creep_spot(elliptic_shape(random%uniform(0.1_wp, 1.0_wp)), 0.3_wp, 8.0e10_wp, &
               0.3_wp)
            v = random%vector(5)
            at = passing_type(sliding_type(1.0_wp, 1.0e-3_wp, v(1), v(2), 1.0e3_wp*v(3)), v(4), &
               v(5))
            ! Without a spot, too.
            if (mod(j, 10) == 0) at%a = 0.0_wp
            by_load = 0.0_wp
            slides = at
            slides%cx = 0.0_wp
            slides%cy = 0.0_wp
            if (models(i)%info%name /= "linear") call law%wrench(spot, slides, by_load)
            at%load = 0.0_wp
            call law%linearize(spot, at, force, slopes)
            finite = finite .and. all(ieee_is_finite(force)) .and. all(ieee_is_finite(slopes))
            if (.not. finite) exit
            call worst%note(maxval(abs(force)), j)
            call worst%note(maxval(abs(slopes(:, 1) - by_load)*[1.0_wp, 1.0_wp, 1.0e3_wp]), j)
            call worst%note(maxval(abs(slopes(:, 2:))), j)
         end do
         call check(finite, "creep: derivatives without load are finite, by " // &
            trim(models(i)%info%name))
         call worst%check_below(1.0e-12_wp, "creep: derivatives without load, by " // &
            trim(models(i)%info%name))
      end do
   end subroutine test_no_load

   !> Derivatives of the linear theory against differences of its wrench, with creepages from far
   !> below to far above the scale of creepage, as where a load vanishes.
   subroutine test_linear_slopes()
      type(creep_model_type), allocatable :: models(:)
      class(creep_type), allocatable :: law
      type(creep_spot_type) :: spot
      type(passing_type) :: at
      type(random_type) :: random
      type(worst_type) :: worst
      real(wp), parameter :: step = 1.0e-5_wp, one(3) = 1.0_wp
      real(wp) :: force(3), slopes(3, n_arguments), x(n_arguments), shifted(n_arguments)
      real(wp) :: varied(3, 2), units(3), sizes(n_arguments)
      integer :: i, j, k

      models = creep_models()
      do i = 1, size(models)
         if (models(i)%info%name == "linear") call models(i)%make(law)
      end do
      do j = 1, 300
         spot = settled_spot(creep_spot(elliptic_shape(random%uniform(0.1_wp, 1.0_wp)), 0.3_wp, &
            8.0e10_wp, random%uniform(0.0_wp, 0.5_wp)))
         x(1) = 1.0e3_wp*10.0_wp**random%uniform(-15.0_wp, 3.0_wp)
         x(2) = 1.0e-3_wp
         do k = 3, n_arguments
            x(k) = random%uniform(-1.0_wp, 1.0_wp)
         end do
         x(5) = x(5)/x(2)
         at = passing_at(x)
         call law%linearize(spot, at, force, slopes)
         units = [1.0_wp, 1.0_wp, x(2)]*maxval(abs(force*[1.0_wp, 1.0_wp, 1.0_wp/x(2)]))
         sizes = [x(1), x(2), one(1:2)*norm2(x(3:4)), 1.0_wp/x(2), one(1:2)*norm2(x(6:7))]
         do i = 1, n_arguments
            do k = 1, 2
               shifted = x
               shifted(i) = x(i) + merge(step, -step, k == 1)*sizes(i)
               call law%wrench(spot, passing_at(shifted), varied(:, k))
            end do
            varied(:, 1) = (varied(:, 1) - varied(:, 2))/(2.0_wp*step)
            call worst%note(maxval(abs(slopes(:, i)*sizes(i) - varied(:, 1))/units), j)
         end do
      end do
      call worst%check_below(1.0e-7_wp, "creep: derivatives of the linear theory")

   contains

      !> What N, a, vx, vy, w, cx, cy stand for.
      pure function passing_at(values) result(there)
         real(wp), intent(in) :: values(n_arguments)
         type(passing_type) :: there

         there = passing_type(sliding_type(values(1), values(2), values(3), values(4), values(5)), &
            values(6), values(7))
      end function passing_at

   end subroutine test_linear_slopes

   !> The reduction by strips without spin against its formula, from its table and beyond; and the
   !> slope of it, which the lateral force of a little spin is multiplied by.
   subroutine test_strips()
      type(creep_model_type), allocatable :: models(:)
      class(creep_type), allocatable :: law, linear
      type(creep_spot_type) :: spot
      type(creep_motion_type) :: motion
      type(random_type) :: random
      type(worst_type) :: forces, sides
      real(wp), parameter :: little = 1.0e-9_wp
      real(wp) :: reduced(3), whole(3), angle, s, h
      integer :: i

      models = creep_models()
      do i = 1, size(models)
         if (models(i)%info%name == "strip") call models(i)%make(law)
         if (models(i)%info%name == "linear") call models(i)%make(linear)
      end do
      spot = settled_spot(creep_spot(elliptic_shape(0.4_wp), 0.3_wp, 8.0e10_wp, 0.3_wp))
      do i = 1, 3000
         ! The share of s that is below one half, next to one, above it, and next to nothing.
         select case (mod(i, 4))
         case (0)
            s = random%uniform(0.0_wp, 1.0_wp)
         case (1)
            s = 1.0_wp - 10.0_wp**random%uniform(-15.0_wp, -1.0_wp)
         case (2)
            s = random%uniform(1.0_wp, 3.0_wp)
         case default
            s = 10.0_wp**random%uniform(-100.0_wp, -1.0_wp)
         end select
         motion = creep_motion_type(1.0_wp, 0.0_wp, 0.0_wp, -1.0_wp, 0.0_wp)
         call linear%kernel(spot, motion, whole)
         motion%x = s*0.75_wp*pi/abs(whole(1))
         call law%kernel(spot, motion, reduced)
         h = sqrt((1.0_wp - min(s, 1.0_wp))*(1.0_wp + min(s, 1.0_wp)))
         ! acos s = atan2(h, s), which does not lose digits next to one.
         angle = atan2(h, min(s, 1.0_wp))
         if (s < 1.0_wp) then
            ! 2/3 - h + h^3/3, which cancels where s is small.
            call forces%note(abs(-reduced(1) - 1.5_wp*s*(angle + s**3*(2.0_wp + h) &
               /(3.0_wp*(1.0_wp + h)**2))), i)
         else
            call forces%note(abs(-reduced(1) - 1.0_wp), i)
         end if
         motion%spin = little*motion%x
         call linear%kernel(spot, motion, whole)
         call law%kernel(spot, motion, reduced)
         call sides%note(abs(reduced(2) - (2.0_wp/pi)*(angle - min(s, 1.0_wp)*h)*whole(2)) &
            /max(abs(whole(2)), tiny(s)), i)
      end do
      call forces%check_below(1.0e-15_wp, "creep: force of the theory of strips")
      call sides%check_below(1.0e-14_wp, "creep: slope of the theory of strips")
   end subroutine test_strips

end module test_creep
