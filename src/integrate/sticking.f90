!> Friction that sticks at rigid contacts, to an implicit method.
!>
!> Velocities of a row whose friction agrees with its accelerations:
!>
!> Friction that sticks is a steep function of velocities far below any tolerance, which an implicit
!> method knows to a share of its tolerance only, while the accelerations of the motion, the
!> derivatives of its interpolant, are as smooth as the motion itself. The velocities of a row are
!> corrected by dv, of the size of the tolerance at most, until both agree where the forces are
!> stiff,
!>
!>     (1/h - A) dv = f(v) - a ,
!>
!> a the accelerations of the motion, f those by the forces, A = df/dv and h the step: what changes
!> slowly (|A| h << 1) stays. Where that is so at all contacts, because they slide fast, nothing is
!> done.
!>
!> A with the slope of friction, f N over the sliding velocity, decays as this grows. An iteration
!> with an A of earlier steps, at a smaller velocity, hardly moves from where it begins and takes
!> this for convergence: so bodies were kicked from 1e-10 to 1e-5 m/s. Where friction is steep the
!> Jacobian is that of the step.
module contensou_integrate_sticking
   use contensou_base_kinds, only : wp
   use contensou_contact_law, only : contact_law_type
   use contensou_dynamics_links, only : link_type
   use contensou_dynamics_scene, only : motion_free
   use contensou_dynamics_state, only : at_velocity, body_size
   use contensou_integrate_motion, only : motion_type
   use contensou_special_elimination, only : solve_linear
   implicit none(type, external)
   private

   public :: balance_forces, look_at_sliding

   !> Velocities of a body.
   integer, parameter :: velocities = 6

   !> Times the velocities are corrected.
   integer, parameter :: most_corrections = 4

   !> Acceleration that forces may lack, over those of the motion.
   real(wp), parameter :: balanced = 1.0e-8_wp

   !> The largest such lack that is told from another.
   real(wp), parameter :: most_lack = 1.0e30_wp

   !> Least 1/h over the largest element of A that keeps the equations regular.
   real(wp), parameter :: regular = 1.0e-10_wp

   !> Errors that add up over the steps since sliding ended, over those of a step.
   real(wp), parameter :: accumulated = 100.0_wp

   !> Velocity of sliding over that which friction may give or take in a step, where it sticks.
   real(wp), parameter :: stuck = 1.0e-3_wp

   !> The same ratio above which friction is not steep: |A| h is its inverse at most, times the
   !> coefficient of friction.
   real(wp), parameter :: fast = 100.0_wp

   !> Ratio of velocities of sliding between which friction has another slope.
   real(wp), parameter :: changed = 1.2_wp

contains

   !> Correct the velocities of a row with closed rigid contacts, by what the tolerance explains.
   subroutine balance_forces(motion, t, rate, step, y)
      !> The motion; its workspace is changed.
      type(motion_type), intent(inout) :: motion
      !> Time of the row [s].
      real(wp), intent(in) :: t
      !> Time derivative of the interpolant.
      real(wp), intent(in) :: rate(:)
      !> Step in which the row lies [s].
      real(wp), intent(in) :: step
      !> State of the row.
      real(wp), intent(inout) :: y(:)
      real(wp), allocatable :: matrix(:, :), factor(:, :), change(:), entries(:)
      real(wp) :: now(size(y)), trial(size(y)), admissible(size(y))
      real(wp) :: pace, missing, least
      integer, allocatable :: place(:)
      integer :: number(size(y)), i, k, n, c
      logical :: outside, singular

      if (.not. allocated(motion%row) .or. .not. step > 0.0_wp) return
      if (slides_fast(motion, step)) return
      call list_velocities(motion, place, number)
      n = size(place)
      if (n == 0) return
      call motion%derivative(t, y, now, outside)
      if (outside) return
      least = lack(now)
      if (least <= balanced) return
      allocate(matrix(n, n), factor(n, n), change(n), entries(size(motion%row)))
      call motion%jacobian(t, y, entries)
      matrix = 0.0_wp
      do c = 1, n
         do k = motion%column_start(place(c)), motion%column_start(place(c) + 1) - 1
            i = number(motion%row(k))
            if (i > 0) matrix(i, c) = -entries(k)
         end do
      end do
      pace = max(1.0_wp/step, regular*maxval(abs(matrix)))
      do c = 1, n
         matrix(c, c) = matrix(c, c) + pace
      end do
      call motion%admissible_error(y, admissible)
      trial = y
      do k = 1, most_corrections
         factor = matrix
         change = now(place) - rate(place)
         call solve_linear(n, factor, change, singular)
         if (singular) return
         trial(place) = trial(place) + change
         if (any(abs(trial - y) > accumulated*admissible)) return
         call motion%derivative(t, trial, now, outside)
         if (outside) return
         missing = lack(now)
         if (missing >= least) return
         least = missing
         y = trial
         if (least <= balanced) return
      end do

   contains

      !> Largest acceleration that the forces lack, over those of the motion.
      pure real(wp) function lack(accelerations)
         !> Those by the forces.
         real(wp), intent(in) :: accelerations(:)
         real(wp) :: apart, scale
         integer :: j

         lack = 0.0_wp
         do j = 1, n, 3
            apart = norm2(rate(place(j:j + 2)) - accelerations(place(j:j + 2)))
            scale = norm2(rate(place(j:j + 2))) + norm2(motion%system%gravity)
            if (apart > scale*most_lack) then
               ! A body at rest without gravity has no acceleration to compare with.
               lack = most_lack
            else if (scale > 0.0_wp) then
               lack = max(lack, apart/scale)
            end if
         end do
      end function lack

   end subroutine balance_forces

   !> Whether the slope of friction at a rigid contact may be another one in the next step: where it
   !> sticks, and where it may end sliding, or begin as much, within a step and sliding has changed.
   subroutine look_at_sliding(motion, step, speed, steep)
      !> The motion, as its last right-hand side left it.
      type(motion_type), intent(in) :: motion
      !> The last step [s].
      real(wp), intent(in) :: step
      !> How fast each contact slides and drills, a step before and now [m/s].
      real(wp), intent(inout) :: speed(:)
      logical, intent(out) :: steep
      real(wp) :: now, gain
      integer :: i

      steep = .false.
      do i = 1, motion%system%constraints%n_links
         associate (link => motion%system%constraints%links(i), &
            law => motion%system%contacts(motion%system%constraints%links(i)%contact)%law, &
            before => speed(motion%system%constraints%links(i)%contact))
            if (.not. allocated(law%friction) .or. .not. link%normal_force > 0.0_wp) cycle
            now = sliding_of(link, law)
            gain = step*link%normal_force*sum(link%inverse_mass)
            steep = steep .or. now < stuck*gain .or. (min(before, now) < gain .and. &
               max(before, now) > changed*min(before, now))
            before = now
         end associate
      end do
   end subroutine look_at_sliding

   !> Whether friction changes little with the velocities at all closed contacts, within a step.
   pure logical function slides_fast(motion, step)
      !> The motion, as its last right-hand side left it.
      type(motion_type), intent(in) :: motion
      !> The step [s].
      real(wp), intent(in) :: step
      integer :: i

      slides_fast = .true.
      do i = 1, motion%system%constraints%n_links
         associate (link => motion%system%constraints%links(i), &
            contact => motion%system%contacts(motion%system%constraints%links(i)%contact))
            if (.not. allocated(contact%law%friction)) cycle
            slides_fast = contact%states%n == 0 .and. link%normal_force > 0.0_wp
            if (slides_fast) slides_fast = sliding_of(link, contact%law) &
               > fast*step*link%normal_force*sum(link%inverse_mass)
            if (.not. slides_fast) return
         end associate
      end do
   end function slides_fast

   !> How fast a contact slides and drills [m/s].
   pure real(wp) function sliding_of(link, law)
      type(link_type), intent(in) :: link
      type(contact_law_type), intent(in) :: law

      sliding_of = norm2(link%motion(1:2)) + law%normal%axis_a &
         *sqrt(law%normal%approach(link%normal_force))*abs(link%motion(3))
   end function sliding_of

   !> Velocities of the free bodies that rigid contacts with friction hold.
   subroutine list_velocities(motion, place, number)
      type(motion_type), intent(in) :: motion
      !> Their places in the state.
      integer, allocatable, intent(out) :: place(:)
      !> For each place in the state: number of the velocity; 0 for others.
      integer, intent(out) :: number(:)
      logical :: held(0:size(motion%system%bodies))
      integer :: i, k, n

      held = .false.
      do i = 1, size(motion%system%contacts)
         associate (contact => motion%system%contacts(i))
            if (.not. contact%closed .or. .not. allocated(contact%law%friction)) cycle
            held(contact%a) = .true.
            held(contact%b) = .true.
         end associate
      end do
      allocate(place(velocities*count(held(1:))))
      number = 0
      n = 0
      do i = 1, size(motion%system%bodies)
         if (.not. held(i) .or. motion%system%bodies(i)%motion /= motion_free) cycle
         do k = 1, velocities
            n = n + 1
            place(n) = body_size*(i - 1) + at_velocity - 1 + k
            number(place(n)) = n
         end do
      end do
      place = place(:n)
   end subroutine list_velocities

end module contensou_integrate_sticking
