!> What contacts with tangential elasticity remember, which changes with an accepted step: the step
!> is taken again, in smaller ones, where the memory would differ with it.
module contensou_integrate_history
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite
   use contensou_base_errors, only : error_type
   use contensou_base_kinds, only : wp
   use contensou_contact_geometry, only : contact_motion_type
   use contensou_integrate_gaps, only : time_to_fall
   use contensou_integrate_integrator, only : graded
   use contensou_integrate_motion, only : motion_type
   use contensou_integrate_step, only : march_type
   implicit none(type, external)
   private

   public :: doubt_memory, remember, doubt_of_host

   !> Deviation of a step that is admitted, over the root of the relative tolerance.
   real(wp), parameter :: admitted = 1.0_wp

   !> The same of the steps of another program, whose methods do not follow the ringing as closely.
   real(wp), parameter :: admitted_of_host = 0.1_wp

   !> How far its steps may bend away from straight ones, over an overlap.
   real(wp), parameter :: admitted_bend = 1.0e-3_wp

   !> Deviation of a step in which the path does not count.
   real(wp), parameter :: of_no_account = 1.0e-7_wp

   !> Part of the step that would just do, and the smallest and the largest change of a step.
   real(wp), parameter :: cautious = 0.7_wp, shrinking = 0.1_wp, growing = 4.0_wp

   !> Step over the time since a touch or until a lift-off: a force that goes as the power 1.5 of
   !> the overlap is not smooth there, and an error test that looks back does not see it.
   !> In an impact, and at most where a gap changes more slowly.
   real(wp), parameter :: near_touch = 0.08_wp, near_slow_touch = 0.1_wp

   !> The same of the time until damping takes the force to zero at an overlap, which is a kink, or
   !> since then, over that of an overlap: as much where the force ends with the overlap.
   real(wp), parameter :: near_kink = 1.5_wp

   !> Part of all these where damping has taken the whole force: nothing but the work of the overlap
   !> that is left is there for an error test.
   real(wp), parameter :: pulled = 0.6_wp

   !> Step over the time in which the acceleration of a gap makes up for the overlap, and over the
   !> sixth root of the relative tolerance: where an impact is smooth and its steps are the longest,
   !> those that grow err by more than an error test of order 5 sees.
   real(wp), parameter :: of_turning = 0.26_wp, root = 1.0_wp/6.0_wp

   !> Slowness up to which a touch is an impact: at half the speed from which on more is admitted.
   real(wp), parameter :: slow_impact = 16.0_wp

   !> Overlap, over a usual one, below which no step is shortened for that.
   real(wp), parameter :: of_no_force = 1.0e-3_wp

   !> Time that no step takes [s].
   real(wp), parameter :: no_time = 1.0e30_wp

   !> Step that is not taken again, in units of the rounding of the time.
   real(wp), parameter :: shortest = 64.0_wp

contains

   !> See whether the step is to be taken again, for the sake of what the contacts are to remember.
   subroutine doubt_memory(self, again, error)
      type(march_type), intent(inout) :: self
      !> Whether the march is at the beginning of the step again.
      logical, intent(out) :: again
      !> Set when the integration cannot go on there.
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: time_step, largest, bound, part

      again = .false.
      associate (memory => self%memory, t => self%memory%t)
         time_step = t - self%t_before
         call self%motion%system%evaluate_memory(memory%t, memory%y)
         self%times_posed = self%motion%system%times_posed
         bound = admitted*sqrt(self%motion%scales%rtol)
         call deviate(self%motion, time_step, bound, largest, part)
         associate (steps => self%integrator%steps_of_no_path)
            steps = merge(0, steps + 1, largest > of_no_account)
         end associate
         self%next_step = time_step*part
         again = largest > bound .and. time_step > shortest*spacing(t)
         if (.not. again) return
         call self%integrator%bound_step(graded(max(self%next_step, shrinking*time_step)))
         self%bounded = .true.
         t = self%t_before
         memory%y = self%y_before
         where (self%seen) self%gap = self%gap_before
         self%clearance = 0.0_wp
         call self%integrator%restart(t, memory%y, error)
      end associate
   end subroutine doubt_memory

   !> Largest deviation of a step to the state that contacts have evaluated, and the part of the
   !> step that would do, over 1 where more would.
   subroutine deviate(motion, time_step, bound, largest, part)
      class(motion_type), intent(inout) :: motion
      !> Time since the last accepted step [s].
      real(wp), intent(in) :: time_step
      !> What is admitted of it.
      real(wp), intent(in) :: bound
      !> Error of a wrench over the limit of friction.
      real(wp), intent(out) :: largest
      real(wp), intent(out) :: part
      real(wp) :: deviation, turn, enough
      integer :: i

      largest = 0.0_wp
      part = cautious*sqrt(bound/tiny(bound))
      do i = 1, size(motion%system%contacts)
         if (.not. allocated(motion%system%contacts(i)%tangential)) cycle
         call motion%system%contacts(i)%tangential%deviate(time_step, deviation, turn)
         largest = max(largest, deviation)
         enough = cautious*sqrt(bound/max(deviation, tiny(deviation)))
         ! What goes back is to begin with a step.
         if (deviation > bound .and. turn < 1.0_wp) enough = max(turn, enough)
         part = min(part, enough)
      end do
   end subroutine deviate

   !> A function of a state that another program has integrated to, which passes through zero where
   !> contacts have to remember it: the deviation over what is admitted, less 1. The loads of spots,
   !> too, are taken as straight over time.
   subroutine doubt_of_host(motion, before, rate_before, t, y, doubt)
      class(motion_type), intent(inout) :: motion
      !> Time of what the contacts remember [s].
      real(wp), intent(in) :: before
      !> Rates of the gaps at that time [m/s].
      real(wp), intent(in) :: rate_before(:)
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)
      !> Finite; below zero while no contact need remember.
      real(wp), intent(out) :: doubt
      real(wp), dimension(motion%n_events) :: gap, rate
      real(wp) :: largest, bend, bound, part
      integer :: i

      doubt = -1.0_wp
      if (.not. t - before > shortest*spacing(t)) return
      call motion%system%evaluate_memory(t, y)
      bound = admitted_of_host*sqrt(motion%scales%rtol)
      call deviate(motion, t - before, bound, largest, part)
      doubt = largest/bound - 1.0_wp
      call motion%system%gaps(y, gap)
      call motion%system%gap_rates(y, rate)
      do i = 1, motion%n_events
         if (.not. allocated(motion%system%contacts(i)%tangential)) cycle
         bend = 0.125_wp*(t - before)*abs(rate(i) - rate_before(i))
         doubt = max(doubt, bend/(admitted_bend*max(-gap(i), motion%scales%usual_overlap())) &
            - 1.0_wp)
      end do
      if (.not. ieee_is_finite(doubt)) doubt = -1.0_wp
   end subroutine doubt_of_host

   !> Let the contacts remember the step, and bound the next one.
   subroutine remember(self)
      type(march_type), intent(inout) :: self
      real(wp) :: time_step, bound
      integer :: i

      associate (system => self%motion%system, memory => self%memory)
         ! Unless that is the state that was evaluated last. Gaps and forces that are sought are
         ! closer the second time, and the steps of two spots do not go on from what is found first.
         if (system%searches .or. system%constraints%n_rigid > 0 .or. &
            system%times_posed /= self%times_posed) then
            call system%evaluate_memory(memory%t, memory%y)
         end if
         do i = 1, size(system%contacts)
            if (allocated(system%contacts(i)%tangential)) call system%contacts(i)%tangential%keep()
         end do
         call heed_touches(self)
         ! Bounds for the sake of gaps are lifted elsewhere.
         if (memory%bounded_until > 0.0_wp) return
         time_step = memory%t - self%t_before
         ! A step that an event cut short may be less than time resolves.
         bound = graded(max(min(self%next_step, growing*time_step), shortest*spacing(memory%t)))
         if (self%plan%max_step > 0.0_wp) bound = min(bound, self%plan%max_step)
         if (self%next_step < growing*time_step) then
            call self%integrator%bound_step(bound)
            self%bounded = .true.
         else if (self%bounded) then
            if (bound > self%plan%t_end) bound = self%plan%max_step
            call self%integrator%bound_step(bound)
            self%bounded = bound < self%plan%t_end .and. bound > 0.0_wp
         end if
      end associate
   end subroutine remember

   !> Tell a method how long its next step may be where compliant contacts that remember have
   !> touched or are about to lift off, and within an impact.
   subroutine heed_touches(self)
      !> The march, its poses those of the state that is reached.
      type(march_type), intent(inout) :: self
      type(contact_motion_type) :: now
      real(wp) :: overlap, least, bend, slowness, near, time_step
      real(wp), dimension(self%motion%n_ways) :: rate, push
      logical :: known
      integer :: i

      time_step = self%memory%t - self%t_before
      known = allocated(self%way_rate) .and. time_step > 0.0_wp
      least = of_no_force*self%motion%scales%usual_overlap()
      associate (motion => self%motion, reach => self%integrator%reach)
         reach = huge(reach)
         self%integrator%impact = .false.
         motion%way_speed = 0.0_wp
         push = 0.0_wp
         do i = 1, motion%n_ways
            call motion%system%observe(motion%way(i), now)
            overlap = -now%at%gap
            rate(i) = now%gap_rate()
            if (overlap < 0.0_wp) then
               bend = 0.0_wp
               if (known) bend = (self%way_rate(i) - rate(i))/time_step
               reach = min(reach, time_to_fall(max(-overlap, near_touch*least), rate(i), bend))
               cycle
            end if
            if (rate(i) > 0.0_wp .and. overlap < least) cycle
            overlap = max(overlap, least)
            bend = 0.0_wp
            if (known) bend = abs(rate(i) - self%way_rate(i))/time_step
            motion%way_speed(i) = sqrt(bend*overlap)
            slowness = motion%slowness(i)
            if (slowness <= slow_impact) self%integrator%impact = .true.
            near = min(near_slow_touch, near_touch*slowness)
            push(i) = motion%system%contacts(motion%way(i))%law%push(overlap, -rate(i))
            if (push(i) < 0.0_wp) near = pulled*near
            if (near*overlap < abs(rate(i))*no_time) reach = min(reach, near*overlap/abs(rate(i)))
            if (overlap < bend*no_time) reach = min(reach, of_turning*slowness &
               *motion%scales%rtol**root*sqrt(overlap/bend))
            if (known) reach = min(reach, near*max(near_kink*time_of_kink(push(i), &
               self%way_push(i), time_step), least/max(abs(rate(i)), least/no_time)))
         end do
      end associate
      self%way_rate = rate
      self%way_push = push
   end subroutine heed_touches

   !> Time until a force that would pull beyond zero is zero, or since then, if it goes on as it has
   !> [s].
   pure real(wp) function time_of_kink(push, before, time_step) result(time)
      !> The force as it would be, at the end of a step and at its beginning [N].
      real(wp), intent(in) :: push, before
      !> [s], > 0.
      real(wp), intent(in) :: time_step
      real(wp) :: fall

      time = no_time
      fall = before - push
      if (fall > 0.0_wp .and. abs(push) < fall*(no_time/time_step)) time = abs(push)/fall*time_step
   end function time_of_kink

end module contensou_integrate_history
