!> CPU time by effect, sampled: every so many evaluations one is timed where it happens, and its
!> parts are then done again by themselves, each several times, to share that time out.
!>
!> Samples come at calls that grow by halves until they are a period apart, so that a short run has
!> some as well, and each stands for the calls since the one before: the first evaluation, for which
!> nothing is in the caches yet, may take hundreds of times as long as another. What is done again
!> costs about 35 evaluations a sample: those of 17 samples in 8,000, 1 % of a long run.
module contensou_integrate_profile
   use contensou_base_kinds, only : i8, wp
   use contensou_base_operating_system, only : wall_seconds
   use contensou_base_vectors, only : cross
   use contensou_contact_creep_law, only : passing_type
   use contensou_contact_friction_law, only : sliding_type
   use contensou_contact_geometry, only : contact_point_type, contact_variation_type, pose_type, &
      rolling_velocity, trouble_none
   use contensou_contact_states, only : most_states
   use contensou_dynamics_equations, only : system_type
   use contensou_dynamics_mechanism, only : contact_type, relative_motion
   implicit none(type, external)
   private

   public :: profile_type, profile_names

   !> What CPU time is told of; the first seven make up the right-hand side.
   character(len=*), parameter :: profile_names(*) = [character(len=16) :: "geometry", &
      "normal_force", "ellipse", "friction", "damping", "rolling", "bodies", "jacobian", &
      "events", "output", "integrator"]

   !> Their places.
   integer, parameter :: p_geometry = 1, p_normal = 2, p_ellipse = 3, p_friction = 4, &
      p_damping = 5, p_rolling = 6, p_bodies = 7, p_jacobian = 8, p_events = 9, p_output = 10, &
      p_integrator = 11

   !> One of so many evaluations is sampled in a long run, and the first of all.
   integer(i8), parameter :: period = 4096_i8, first = 8_i8

   !> The same for the Jacobian and the events, which are not done again.
   integer(i8), parameter :: other_period = 64_i8, other_first = 2_i8

   !> Times that a part of nanoseconds is done again, so that it takes many ticks of the clock.
   integer, parameter :: short_repeats = 64

   !> Times that any other part is done again.
   integer, parameter :: repeats = 4

   !> A sample longer than this many of the shortest one was interrupted.
   real(wp), parameter :: interrupted = 8.0_wp

   !> A time that is sampled.
   type :: clock_type
      !> The call to be sampled next, and how many calls later the next one is at most.
      integer(i8) :: next = other_first, period = other_period
      !> Calls so far, and those for which the samples stand.
      integer(i8) :: calls = 0, covered = 0
      !> Time of these [s].
      real(wp) :: total = 0.0_wp
      !> The shortest sample [s].
      real(wp) :: shortest = 1.0e9_wp
   contains
      procedure :: count_call
      procedure :: add
      procedure :: all_over_covered
   end type clock_type

   !> CPU time by effect.
   type :: profile_type
      !> Whether it is taken.
      logical :: active = .false.
      type(clock_type) :: right_hand_side = clock_type(next=first, period=period)
      type(clock_type) :: jacobian
      !> Gaps for events.
      type(clock_type) :: events
      !> Times of the parts done again, of the calls for which samples stand [s].
      real(wp) :: parts(p_bodies) = 0.0_wp
      !> Time of reading the clock [s].
      real(wp) :: overhead = 0.0_wp
      !> Keeps what is done again from being left out.
      real(wp) :: sink = 0.0_wp
   contains
      procedure :: begin
      procedure :: take
      procedure :: result
   end type profile_type

contains

   !> Begin: see what a look at the clock costs.
   subroutine begin(self)
      class(profile_type), intent(inout) :: self
      real(wp) :: start
      integer :: i

      self%active = .true.
      self%overhead = huge(start)
      do i = 1, 1000
         start = wall_seconds()
         self%overhead = min(self%overhead, wall_seconds() - start)
      end do
   end subroutine begin

   !> Count a call, and tell whether it is to be timed.
   pure subroutine count_call(self, timed)
      class(clock_type), intent(inout) :: self
      logical, intent(out) :: timed

      self%calls = self%calls + 1_i8
      timed = self%calls == self%next
      if (timed) self%next = self%calls + min(self%period, max(self%calls/2_i8, 1_i8))
   end subroutine count_call

   !> Add a sample, unless it was interrupted.
   pure subroutine add(self, seconds)
      class(clock_type), intent(inout) :: self
      !> Time of one call [s].
      real(wp), intent(in) :: seconds

      if (seconds > interrupted*self%shortest) return
      self%total = self%total + max(seconds, 0.0_wp)*(self%calls - self%covered)
      self%covered = self%calls
      self%shortest = min(self%shortest, max(seconds, 1.0e-9_wp))
   end subroutine add

   !> All calls over those for which samples stand, zero without any.
   pure real(wp) function all_over_covered(self)
      class(clock_type), intent(in) :: self

      all_over_covered = 0.0_wp
      if (self%covered > 0_i8) all_over_covered = real(self%calls, wp)/self%covered
   end function all_over_covered

   !> Note the time of a right-hand side, and do its parts again.
   subroutine take(self, system, seconds)
      class(profile_type), intent(inout) :: self
      !> The equations of motion, their poses those of the evaluation.
      type(system_type), intent(inout) :: system
      !> Time that the evaluation took [s].
      real(wp), intent(in) :: seconds
      type(contact_point_type) :: at
      real(wp) :: gap, velocity(3), spin(3), x, elastic, rate, force(3), major, torque(3), start, &
         local(most_states), rates(most_states)
      type(sliding_type) :: slides
      integer(i8) :: calls
      integer :: i, r, trouble

      calls = self%right_hand_side%calls - self%right_hand_side%covered
      call self%right_hand_side%add(seconds - self%overhead)
      ! It was interrupted.
      if (self%right_hand_side%covered < self%right_hand_side%calls) return
      do i = 1, size(system%contacts)
         associate (c => system%contacts(i), a => system%pose(system%contacts(i)%a), &
            b => system%pose(system%contacts(i)%b))
            call start_clock()
            do r = 1, repeats
               call c%find_gap(a, b, gap)
               if (gap >= 0.0_wp .or. c%track%lost) cycle
               call c%locate(a, b, gap, at)
               call relative_motion(a, b, at%point, velocity, spin)
               self%sink = self%sink + velocity(1)
            end do
            call stop_clock(p_geometry, repeats)
            if (gap >= 0.0_wp .or. c%track%lost) cycle
            if (.not. c%law%geometry%constant_curvatures) then
               call start_clock()
               do r = 1, repeats
                  call c%follow(at, trouble)
               end do
               call stop_clock(p_ellipse, repeats)
               if (trouble /= trouble_none) cycle
            end if
            rate = -dot_product(velocity, at%normal)
            elastic = 0.0_wp
            call start_clock()
            do r = 1, short_repeats
               elastic = c%law%normal%force(varied())
               self%sink = self%sink + elastic
            end do
            call stop_clock(p_normal, short_repeats)
            if (allocated(c%law%damping)) then
               call start_clock()
               do r = 1, short_repeats
                  self%sink = self%sink + c%law%damping%total(elastic, varied(), rate)
               end do
               call stop_clock(p_damping, short_repeats)
            end if
            if (allocated(c%law%friction)) then
               major = 0.0_wp
               call start_clock()
               do r = 1, short_repeats
                  major = c%law%normal%major_axis(varied())
                  self%sink = self%sink + major
               end do
               call stop_clock(p_ellipse, short_repeats)
               call start_clock()
               do r = 1, repeats
                  x = 1.0_wp + r*epsilon(x)
                  slides = sliding_type(x*elastic, major, dot_product(velocity, at%major), &
                     dot_product(velocity, cross(at%normal, at%major)), &
                     dot_product(spin, at%normal), system%resolution%of(a, b, at%point))
                  if (allocated(c%law%steady)) then
                     call roll(c, a, b, at, velocity, spin, slides, force)
                  else if (allocated(c%tangential)) then
                     local = c%local_states(at)
                     call c%tangential%evolve(c%law%friction, c%law%normal%shape, &
                        passing_type(slides), local(c%states%n_damping + 1:c%states%n_local), &
                        force, rates(:c%states%n_local - c%states%n_damping))
                  else
                     call c%law%friction%wrench(c%law%normal%shape, slides, force)
                  end if
                  self%sink = self%sink + force(1)
               end do
               call stop_clock(p_friction, repeats)
            end if
            if (allocated(c%law%rolling)) then
               call start_clock()
               do r = 1, repeats
                  x = 1.0_wp + r*epsilon(x)
                  torque = c%law%rolling%torque(x*elastic, at%normal, at%major, &
                     c%law%normal%axis_a*sqrt(-gap), c%law%normal%axis_b*sqrt(-gap), spin)
                  self%sink = self%sink + torque(1)
               end do
               call stop_clock(p_rolling, repeats)
            end if
         end associate
      end do

   contains

      !> Wrench in steady rolling.
      subroutine roll(c, a, b, at, velocity, spin, slides, force)
         type(contact_type), intent(in) :: c
         type(pose_type), intent(in) :: a
         type(pose_type), intent(in) :: b
         type(contact_point_type), intent(in) :: at
         real(wp), intent(in) :: velocity(3)
         real(wp), intent(in) :: spin(3)
         type(sliding_type), intent(in) :: slides
         real(wp), intent(out) :: force(3)
         type(contact_variation_type) :: variation
         real(wp) :: carried(3)

         call c%law%geometry%vary(a, b, c%track, at, variation)
         carried = rolling_velocity(variation, velocity, spin)
         call c%law%steady%wrench(c%law%normal%shape, passing_type(slides, &
            dot_product(carried, at%major), dot_product(carried, cross(at%normal, at%major))), &
            force)
      end subroutine roll

      !> The approach, in each repetition another one.
      pure real(wp) function varied()
         varied = -gap*(1.0_wp + r*epsilon(gap))
      end function varied

      !> Look at the clock.
      subroutine start_clock()
         start = wall_seconds()
      end subroutine start_clock

      !> Add to a part what one of its repetitions took.
      subroutine stop_clock(part, times)
         integer, intent(in) :: part
         !> Of repetitions.
         integer, intent(in) :: times
         real(wp) :: passed

         passed = (wall_seconds() - start - self%overhead)/times
         if (passed < interrupted*seconds) self%parts(part) = self%parts(part) &
            + max(passed, 0.0_wp)*calls
      end subroutine stop_clock

   end subroutine take

   !> CPU time of everything [s], in the order of `profile_names`.
   pure function result(self, cpu, output) result(seconds)
      class(profile_type), intent(in) :: self
      !> CPU time of the whole integration [s].
      real(wp), intent(in) :: cpu
      !> CPU time of writing rows [s].
      real(wp), intent(in) :: output
      real(wp) :: seconds(size(profile_names))
      real(wp) :: whole, known

      seconds = 0.0_wp
      whole = self%right_hand_side%total*self%right_hand_side%all_over_covered()
      seconds(:p_rolling) = self%parts(:p_rolling)*self%right_hand_side%all_over_covered()
      known = sum(seconds(:p_rolling))
      ! Parts done again can overlap less than in the whole.
      if (known > whole .and. known > 0.0_wp) seconds(:p_rolling) = seconds(:p_rolling)*whole/known
      seconds(p_bodies) = max(whole - sum(seconds(:p_rolling)), 0.0_wp)
      seconds(p_jacobian) = self%jacobian%total*self%jacobian%all_over_covered()
      seconds(p_events) = self%events%total*self%events%all_over_covered()
      seconds(p_output) = output
      seconds(p_integrator) = max(cpu - sum(seconds), 0.0_wp)
   end function result

end module contensou_integrate_profile
