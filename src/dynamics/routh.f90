!> The impulses of an impact with friction at one contact.
!>
!> With the normal impulse P as the independent variable the sliding velocities, the spin and the
!> rate of the gap q follow dq/dP = C (w(q), 1), C the inverse mass seen at the contact, w the
!> friction wrench over the normal force of the contact's own law. Compression ends where the
!> approach does, restitution where it has given back e^2 of the work of compression.
!>
!> The equations are stiff as soon as friction sticks. They are integrated by the L-stable,
!> stiffly accurate method of order 4 with an embedded one of order 3 of E. Hairer, G. Wanner,
!> Solving Ordinary Differential Equations II, 2nd ed. (1996), table IV.6.5, its steps controlled by
!> the tolerance of the run. Below the smallest velocity that the tolerance admits friction is
!> smoothed.
module contensou_dynamics_routh
   use contensou_base_kinds, only : wp
   use contensou_contact_friction_law, only : sliding_type
   use contensou_contact_geometry, only : trouble_jammed, trouble_none
   use contensou_contact_law, only : contact_law_type
   use contensou_special_elimination, only : solve_linear
   implicit none(type, external)
   private

   public :: impact_type, integrate_impact, solve_stage, smallest_velocity

   !> An impact in the making.
   type :: impact_type
      !> Inverse mass at the contact: major, minor [1/kg], spin [1/(kg m)], normal.
      real(wp) :: inverse_mass(4, 4) = 0.0_wp
      !> Velocities before: sliding along the axes [m/s], spin [rad/s], rate of the gap [m/s].
      real(wp) :: before(4) = 0.0_wp
      !> Impulse so far [N s, N m s].
      real(wp) :: impulse(4) = 0.0_wp
      !> Major semi-axis of the spot [m].
      real(wp) :: a = 0.0_wp
      !> Square of the velocity below which friction is smoothed [m2/s2].
      real(wp) :: resolution = 0.0_wp
      !> Work of the normal impulse in this phase so far [J].
      real(wp) :: work = 0.0_wp
      !> Energy that the normal impulse takes [J].
      real(wp) :: normal_loss = 0.0_wp
   end type impact_type

   !> What an error of a step is measured against: velocities and work of an impact.
   type :: measure_type
      !> Sliding velocities and rate of the gap [m/s].
      real(wp) :: velocity
      !> Spin [rad/s].
      real(wp) :: spin
      !> Work [J].
      real(wp) :: work
   end type measure_type

   !> Steps of the compression at least.
   integer, parameter :: least_steps = 4

   !> Steps after which an impact is given up.
   integer, parameter :: most_steps = 100000

   !> Step below which it is given up, over the largest one.
   real(wp), parameter :: smallest_step = 1.0e-17_wp

   !> Share of the tolerance that a step may take of it.
   real(wp), parameter :: of_step = 0.1_wp

   !> Smallest tolerance of a step: what rounding leaves.
   real(wp), parameter :: smallest_tolerance = 1.0e-14_wp

   !> Smallest velocity below which friction is smoothed, over that of the impact: sharper kinks are
   !> beyond what rounding solves.
   real(wp), parameter :: smallest_velocity = 1.0e-10_wp

   !> Stages of the method.
   integer, parameter :: stages = 5

   !> Diagonal of the method.
   real(wp), parameter :: gamma = 0.25_wp

   !> The other coefficients, those of stage s in column s; the last one has the weights.
   real(wp), parameter :: coefficient(stages, stages) = reshape([ &
      gamma, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
      0.5_wp, gamma, 0.0_wp, 0.0_wp, 0.0_wp, &
      17.0_wp/50.0_wp, -1.0_wp/25.0_wp, gamma, 0.0_wp, 0.0_wp, &
      371.0_wp/1360.0_wp, -137.0_wp/2720.0_wp, 15.0_wp/544.0_wp, gamma, 0.0_wp, &
      25.0_wp/24.0_wp, -49.0_wp/48.0_wp, 125.0_wp/16.0_wp, -85.0_wp/12.0_wp, gamma], &
      [stages, stages])

   !> Where in the step its stages are.
   real(wp), parameter :: place(stages) = [0.25_wp, 0.75_wp, 0.55_wp, 0.5_wp, 1.0_wp]

   !> Weights of the error: those of the method less those of the embedded one.
   real(wp), parameter :: error_weight(stages) = [-3.0_wp/16.0_wp, -27.0_wp/32.0_wp, &
      25.0_wp/32.0_wp, 0.0_wp, 0.25_wp]

contains

   !> Impulses of an impact with friction.
   pure subroutine integrate_impact(impact, law, e, tolerance, trouble)
      !> The impact, inverse masses, velocities before and spot set.
      type(impact_type), intent(inout) :: impact
      type(contact_law_type), intent(in) :: law
      !> Coefficient of restitution.
      real(wp), intent(in) :: e
      !> Relative tolerance of velocities [-].
      real(wp), intent(in) :: tolerance
      !> One of the `trouble_*` codes.
      integer, intent(out) :: trouble
      type(impact_type) :: trial
      type(measure_type) :: measure
      real(wp) :: h, largest, target, size_of_error, admitted, factor
      integer :: phase, k
      logical :: solved, over

      trouble = trouble_none
      associate (c => impact%inverse_mass, speed => impact%before(4))
         measure%velocity = sqrt(dot_product(impact%before(1:2), impact%before(1:2)) &
            + (impact%a*impact%before(3))**2 + speed**2)
         measure%spin = abs(impact%before(3)) + measure%velocity &
            *sqrt(c(3, 3)/max(c(1, 1), c(2, 2), tiny(c)))
         measure%work = 0.5_wp*speed**2/c(4, 4)
         impact%resolution = (max(tolerance, smallest_velocity)*measure%velocity)**2
         largest = -speed/(c(4, 4)*least_steps)
      end associate
      admitted = max(of_step*tolerance, smallest_tolerance)
      h = 0.125_wp*largest
      target = 0.0_wp
      phase = 1
      do k = 1, most_steps
         call advance_impact(impact, law, h, measure, trial, size_of_error, solved)
         if (.not. solved) then
            h = 0.25_wp*h
            if (h < smallest_step*largest) exit
            cycle
         end if
         factor = min(max(0.9_wp*(max(size_of_error/admitted, 1.0e-4_wp))**(-0.25_wp), 0.1_wp), &
            4.0_wp)
         if (size_of_error > admitted .and. h > smallest_step*largest) then
            h = factor*h
            cycle
         end if
         if (phase == 1) then
            over = gap_rate(trial) >= 0.0_wp
         else
            ! Friction that stops the rebound ends the impact.
            if (gap_rate(trial) <= 0.0_wp) return
            over = trial%work >= target
         end if
         if (.not. over) then
            impact = trial
            h = min(factor*h, largest)
            cycle
         end if
         call find_phase_end(impact, law, h, phase, target, measure, trial, solved)
         if (.not. solved) then
            h = 0.25_wp*h
            if (h < smallest_step*largest) exit
            cycle
         end if
         impact = trial
         if (phase == 2) then
            impact%normal_loss = impact%normal_loss - target
            return
         end if
         impact%normal_loss = -impact%work
         target = -e**2*impact%work
         if (target <= 0.0_wp) return
         impact%work = 0.0_wp
         phase = 2
      end do
      trouble = trouble_jammed
   end subroutine integrate_impact

   !> Find the step at which a phase of an impact ends: the Illinois method.
   pure subroutine find_phase_end(impact, law, h, phase, target, measure, trial, solved)
      !> The impact before the step.
      type(impact_type), intent(in) :: impact
      type(contact_law_type), intent(in) :: law
      !> A step that is too long [N s].
      real(wp), intent(in) :: h
      !> 1 for compression, 2 for restitution.
      integer, intent(in) :: phase
      !> Work of a restitution at its end [J].
      real(wp), intent(in) :: target
      type(measure_type), intent(in) :: measure
      !> The impact at the end of the phase.
      type(impact_type), intent(out) :: trial
      !> Whether it was found.
      logical, intent(out) :: solved
      real(wp) :: low, high, f_low, f_high, middle, f, unused
      integer :: k, side

      low = 0.0_wp
      high = h
      f_low = merge(gap_rate(impact), impact%work - target, phase == 1)
      call advance_impact(impact, law, h, measure, trial, unused, solved)
      f_high = excess()
      side = 0
      f = f_high
      do k = 1, 100
         if (.not. solved .or. abs(f) <= 4.0_wp*epsilon(f) &
            *merge(abs(impact%before(4)), target, phase == 1)) exit
         middle = (f_high*low - f_low*high)/(f_high - f_low)
         if (middle <= low .or. middle >= high) middle = 0.5_wp*(low + high)
         if (middle <= low .or. middle >= high) exit
         call advance_impact(impact, law, middle, measure, trial, unused, solved)
         f = excess()
         if (f < 0.0_wp) then
            low = middle
            f_low = f
            if (side < 0) f_high = 0.5_wp*f_high
            side = -1
         else
            high = middle
            f_high = f
            if (side > 0) f_low = 0.5_wp*f_low
            side = 1
         end if
      end do

   contains

      !> What is to become zero, at the trial of a step.
      pure real(wp) function excess()
         excess = merge(gap_rate(trial), trial%work - target, phase == 1)
      end function excess

   end subroutine find_phase_end

   !> Rate of the gap in an impact [m/s].
   pure function gap_rate(impact) result(rate)
      type(impact_type), intent(in) :: impact
      real(wp) :: rate

      rate = impact%before(4) + dot_product(impact%inverse_mass(4, :), impact%impulse)
   end function gap_rate

   !> Go on with an impact by a step of the normal impulse.
   pure subroutine advance_impact(impact, law, h, measure, after, size_of_error, solved)
      type(impact_type), intent(in) :: impact
      type(contact_law_type), intent(in) :: law
      !> The step [N s].
      real(wp), intent(in) :: h
      type(measure_type), intent(in) :: measure
      type(impact_type), intent(out) :: after
      !> Largest estimated error, over what errors are measured against [-].
      real(wp), intent(out) :: size_of_error
      !> Whether the equations of the stages were solved.
      logical, intent(out) :: solved
      real(wp) :: wrench(3, stages), rate(stages), error(4)
      integer :: i

      size_of_error = huge(h)
      after = impact
      do i = 1, stages
         after%impulse(1:3) = impact%impulse(1:3) &
            + h*matmul(wrench(:, :i - 1), coefficient(:i - 1, i))
         after%impulse(4) = impact%impulse(4) + place(i)*h
         call solve_stage(after, law, gamma*h, wrench(:, i), solved)
         if (.not. solved) return
         after%impulse(1:3) = after%impulse(1:3) + gamma*h*wrench(:, i)
         rate(i) = gap_rate(after)
      end do
      after%work = impact%work + h*dot_product(coefficient(:, stages), rate)
      error = h*matmul(impact%inverse_mass(:, 1:3), matmul(wrench, error_weight))
      size_of_error = max(maxval(abs(error([1, 2, 4])))/measure%velocity, &
         abs(error(3))/measure%spin, abs(h*dot_product(error_weight, rate))/measure%work)
   end subroutine advance_impact

   !> Wrench over the normal force at the end of an implicit stage, by Newton's method: from the
   !> beginning of the stage, and if that fails from rest, as where friction sticks. Where the stage
   !> cannot be shortened friction is smoothed first, and less and less.
   pure subroutine solve_stage(impact, law, h, wrench, solved, as_it_is)
      !> The impact at the beginning of the stage, its normal impulse at the end.
      type(impact_type), intent(in) :: impact
      type(contact_law_type), intent(in) :: law
      !> Length of the stage [N s].
      real(wp), intent(in) :: h
      !> The wrench [-, m].
      real(wp), intent(out) :: wrench(3)
      !> Whether the iteration converged.
      logical, intent(out) :: solved
      !> Whether the stage cannot be shortened; if not present it can.
      logical, intent(in), optional :: as_it_is
      integer, parameter :: most(3) = [12, 60, 60]
      real(wp) :: start(3), motion(3), value(3), slopes(3, 5), yielding(3, 3), matrix(3, 3)
      real(wp) :: right(3), last(3), arm, resolution
      integer :: i, k, attempt
      logical :: singular

      start = impact%before(1:3) + matmul(impact%inverse_mass(1:3, :), impact%impulse)
      yielding = h*impact%inverse_mass(1:3, 1:3)
      ! The spin is measured by the spot, so that the equations are of one size.
      arm = merge(impact%a, 1.0_wp, impact%a > 0.0_wp)
      solved = .false.
      do attempt = 1, merge(3, 2, present(as_it_is))
         motion = 0.0_wp
         if (attempt == 1) motion = start
         resolution = impact%resolution
         if (attempt == 3) resolution = max(resolution, start(1)**2 + start(2)**2 &
            + (arm*start(3))**2)
         wrench = huge(wrench)
         k = 0
         do while (k < most(attempt))
            k = k + 1
            call law%friction%linearize(law%normal%shape, sliding_type(1.0_wp, impact%a, &
               motion(1), motion(2), motion(3), resolution), value, slopes)
            matrix = -matmul(yielding, slopes(:, 3:5))
            do i = 1, 3
               matrix(i, i) = matrix(i, i) + 1.0_wp
            end do
            right = start + matmul(yielding, value) - motion
            matrix(3, :) = matrix(3, :)*arm
            matrix(:, 3) = matrix(:, 3)/arm
            right(3) = right(3)*arm
            call solve_linear(3, matrix, right, singular)
            if (singular) exit
            right(3) = right(3)/arm
            motion = motion + right
            last = wrench
            wrench = value + matmul(slopes(:, 3:5), right)
            solved = maxval(abs(wrench(1:2) - last(1:2))) <= 1.0e-12_wp .and. &
               abs(wrench(3) - last(3)) <= 1.0e-12_wp*arm
            if (.not. solved) cycle
            if (resolution <= impact%resolution) return
            resolution = max(0.01_wp*resolution, impact%resolution)
            solved = .false.
            wrench = huge(wrench)
            k = 0
         end do
      end do
   end subroutine solve_stage

end module contensou_dynamics_routh
