!> A motion that another program integrates: what a march does beside its steps.
module contensou_integrate_host
   use contensou_base_errors, only : error_type
   use contensou_base_kinds, only : wp
   use contensou_dynamics_rests, only : lower_threshold, open_contact, touching_gap
   use contensou_dynamics_spots, only : assign_spots
   use contensou_integrate_events, only : begin_impact, note_separation, take_events
   use contensou_integrate_integrator, only : integrator_type, statistics_type
   use contensou_integrate_problem, only : problem_type
   use contensou_integrate_step, only : march_type, zero_gap
   implicit none(type, external)
   private

   public :: host_step, host_events

   !> The integration of another program: it starts anew by itself.
   type, extends(integrator_type) :: foreign_type
   contains
      procedure :: start
      procedure :: step
      procedure :: interpolate
      procedure :: restart
      procedure :: bound_step
      procedure :: statistics
      procedure :: free
   end type foreign_type

contains

   !> Let contacts take note of a step that was accepted, up to the state in memory.
   subroutine host_step(self)
      type(march_type), intent(inout) :: self
      integer :: i, index, trouble

      associate (system => self%motion%system, memory => self%memory)
         if (system%several_spots .and. allocated(memory%closed)) then
            call system%set_poses(memory%y)
            call assign_spots(system, memory%closed, index, trouble)
         end if
         if (system%remembers) then
            call system%evaluate_memory(memory%t, memory%y)
            do i = 1, size(system%contacts)
               if (allocated(system%contacts(i)%tangential)) call &
                  system%contacts(i)%tangential%keep()
            end do
         end if
         if (any(system%contacts%leaving)) call note_separation(self%motion, memory%y)
      end associate
   end subroutine host_step

   !> Take the events at the state in memory: contacts whose gap has passed zero since the last
   !> call, and closed rigid ones that pull.
   subroutine host_events(self, changed, error)
      type(march_type), intent(inout) :: self
      !> Whether the state is another one.
      logical, intent(out) :: changed
      !> Set when impacts cannot be resolved.
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: indicator(self%motion%n_events), gap(self%motion%n_events), &
         rate(self%motion%n_events)
      real(wp) :: before(size(self%memory%y))
      logical :: damping_changed
      integer :: i, n

      n = self%motion%n_events
      changed = .false.
      allocate(foreign_type :: self%integrator)
      allocate(self%events(n), source=0)
      associate (memory => self%memory, system => self%motion%system)
         before = memory%y
         call system%gaps(memory%y, gap)
         call system%gap_rates(memory%y, rate)
         if (.not. allocated(memory%closed)) then
            allocate(memory%undecided(n), source=.false.)
            allocate(memory%closed(n))
            memory%closed = gap <= zero_gap(memory%y)
            do i = 1, n
               if (system%contacts(i)%rigid) memory%closed(i) = system%contacts(i)%closed
               if (memory%closed(i)) call begin_impact(self%motion, i, -rate(i), damping_changed)
            end do
            return
         end if
         call self%motion%events(memory%t, memory%y, indicator)
         do i = 1, n
            associate (contact => system%contacts(i), closed => memory%closed(i))
               if (contact%rigid .and. contact%closed) then
                  if (indicator(i) > 0.0_wp) self%events(i) = 1
               else if (contact%rigid) then
                  call look_at_open(self, i, indicator(i), gap(i), rate(i))
               else if (closed .and. gap(i) > 0.0_wp) then
                  self%events(i) = 1
               else if (.not. closed .and. gap(i) <= 0.0_wp) then
                  self%events(i) = -1
               end if
            end associate
         end do
         if (any(self%events /= 0)) call take_events(self, .false., error)
         changed = any(abs(memory%y - before) > 0.0_wp)
      end associate
   end subroutine host_events

   !> See whether an open rigid contact touches. What has opened and is still within rounding of its
   !> place touches where it comes lower; where it only seems to, it is waited for below.
   subroutine look_at_open(self, i, indicator, gap, rate)
      type(march_type), intent(inout) :: self
      !> The contact.
      integer, intent(in) :: i
      !> What passes through zero where it touches [m].
      real(wp), intent(in) :: indicator
      !> Gap [m] and its rate [m/s].
      real(wp), intent(in) :: gap, rate

      associate (system => self%motion%system, contact => self%motion%system%contacts(i))
         if (contact%leaving) then
            if (indicator > 0.0_wp) return
            if (rate < 0.0_wp) then
               self%events(i) = -1
            else
               call lower_threshold(system, i)
            end if
         else if (gap <= touching_gap(contact) .and. rate < 0.0_wp) then
            self%events(i) = -1
         else if (gap <= 0.0_wp) then
            call open_contact(system, i)
         end if
      end associate
   end subroutine look_at_open

   !> Begin an integration: nothing to do.
   subroutine start(self, problem, method, t, y, t_end, max_step, error)
      class(foreign_type), intent(inout) :: self
      class(problem_type), intent(in), target :: problem
      character(len=*), intent(in) :: method
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)
      real(wp), intent(in) :: t_end
      real(wp), intent(in) :: max_step
      type(error_type), allocatable, intent(out) :: error
   end subroutine start

   !> Steps are those of the other program: the state stays.
   subroutine step(self, t, y, events, error)
      class(foreign_type), intent(inout) :: self
      real(wp), intent(inout) :: t
      real(wp), intent(out) :: y(:)
      integer, intent(out) :: events(:)
      type(error_type), allocatable, intent(out) :: error

      y = 0.0_wp
      events = 0
   end subroutine step

   !> There is no step to look into.
   subroutine interpolate(self, t, y)
      class(foreign_type), intent(inout) :: self
      real(wp), intent(in) :: t
      real(wp), intent(out) :: y(:)

      y = 0.0_wp
   end subroutine interpolate

   !> The other program starts anew by itself.
   subroutine restart(self, t, y, error)
      class(foreign_type), intent(inout) :: self
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)
      type(error_type), allocatable, intent(out) :: error
   end subroutine restart

   !> Nothing is bounded.
   subroutine bound_step(self, max_step)
      class(foreign_type), intent(inout) :: self
      real(wp), intent(in) :: max_step
   end subroutine bound_step

   !> Nothing is counted.
   function statistics(self) result(s)
      class(foreign_type), intent(in) :: self
      type(statistics_type) :: s

      s = statistics_type()
   end function statistics

   !> Nothing is kept.
   subroutine free(self)
      class(foreign_type), intent(inout) :: self
   end subroutine free

end module contensou_integrate_host
