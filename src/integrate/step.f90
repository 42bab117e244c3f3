!> A march under way, and looks at states within its step on which nothing that follows depends.
module contensou_integrate_step
   use contensou_base_kinds, only : i8, wp
   use contensou_contact_geometry, only : track_type
   use contensou_dynamics_mechanism, only : gap_type
   use contensou_dynamics_spots, only : assign_spots
   use contensou_integrate_integrator, only : integrator_type, statistics_type
   use contensou_integrate_memory, only : memory_type, plan_type
   use contensou_integrate_motion, only : motion_type
   use contensou_integrate_observer, only : observer_type
   implicit none(type, external)
   private

   public :: march_type, kept_type, look_at_gap, look_at_gaps, view_spots, open_step, &
      keep_workspace, restore_workspace, zero_gap

   !> A march under way: what takes part in it. Where it is stands in its memory.
   type :: march_type
      class(integrator_type), allocatable :: integrator
      class(motion_type), pointer :: motion => null()
      type(plan_type) :: plan
      type(memory_type), pointer :: memory => null()
      class(observer_type), pointer :: observer => null()
      !> Number of the last row.
      integer(i8) :: rows = 0
      !> Right-hand sides for states beside the rows, which do not count.
      integer(i8) :: unasked = 0
      !> Gap that is zero to rounding [m].
      real(wp) :: resolution = 0.0_wp
      !> For each contact 1, -1 or 0 as its gap opens, closes, or neither at the end of the step.
      integer, allocatable :: events(:)
      !> Gaps and their motion where they were looked at last: not while a contact is closed, nor
      !> while it is so far away that it cannot have touched.
      type(gap_type), allocatable :: gap(:)
      !> Part of each gap that cannot have been passed since then [m], and the bound of its rate at
      !> the end of the last step [m/s].
      real(wp), allocatable :: clearance(:), fastest(:)
      !> Whether closed contacts need no look, and far ones neither.
      logical :: may_skip = .false., may_pass = .false.
      !> Whether the last look at a gap was at the end of the last step, and whether one is needed
      !> in this one.
      logical, allocatable :: seen(:), near(:)
      !> Time, state and gaps at the beginning of the step.
      real(wp) :: t_before = 0.0_wp
      real(wp), allocatable :: y_before(:)
      type(gap_type), allocatable :: gap_before(:)
      !> State of a row, contacts that may have closed and opened again within the step, those that
      !> missed a touch, and those that pull: room that is not allocated at each step.
      real(wp), allocatable :: y_row(:)
      logical, allocatable :: suspect(:), missed(:), pulls(:)
      !> Time at which the pace was looked at last [s], steps since, and looks at which it was poor.
      real(wp) :: t_watch = 0.0_wp
      integer :: steps = 0, looks = 0
      !> Time since which no event was, and steps since then, started anew from time to time.
      real(wp) :: t_quiet = 0.0_wp
      integer :: quiet_steps = 0
      !> Whether the method would not come to the end, and another one may take over.
      logical :: stuck = .false.
      !> Steps of the method where `auto` began to look at their mean.
      integer(i8) :: steps_at_look = 0_i8
      !> Steps since the last check of what a tolerance does not tell of.
      integer :: unchecked = 0
      !> Whether a contact is too deep at the end of the step.
      logical :: deep = .false.
      !> Whether the poses are those at the end of the step.
      logical :: posed = .false.
      !> Whether the step is taken, and the march has come to a time within it.
      logical :: inside = .false.
      !> How fast rigid contacts slide and drill [m/s].
      real(wp), allocatable :: sliding(:)
      !> How often the step was taken again because its spots were others.
      integer :: retaken = 0
      !> Rates of the gaps of compliant contacts that remember at the end of the last step [m/s],
      !> and what would press them if contacts could pull [N]; not allocated before there was one.
      real(wp), allocatable :: way_rate(:), way_push(:)
      !> Whether steps are bounded for the sake of what contacts remember.
      logical :: bounded = .false.
      !> Step that these would just admit [s].
      real(wp) :: next_step = 0.0_wp
      !> How often poses had been set when the state that is reached was evaluated for the memory.
      integer(i8) :: times_posed = 0
      !> Condition that is met where the march is; 0 for none.
      integer :: met = 0
      !> Whether there is any.
      logical :: has_stops = .false.
   end type march_type

   !> What a look at a state changes in a system, though the march is to go on as if there had been
   !> none.
   type :: kept_type
      type(track_type), allocatable :: track(:)
      !> Normal forces of rigid contacts [N].
      real(wp), allocatable :: force(:)
      integer :: too_deep, trouble, trouble_code
      logical :: outside
   end type kept_type

contains

   !> Gaps and their motion at the state that is reached.
   subroutine look_at_gaps(self)
      type(march_type), intent(inout) :: self
      integer :: i

      call self%motion%system%set_poses(self%memory%y)
      do i = 1, size(self%gap)
         call look_at_gap(self, i)
      end do
   end subroutine look_at_gaps

   !> A gap and its motion at the state that is reached, whose poses are set.
   subroutine look_at_gap(self, index)
      type(march_type), intent(inout) :: self
      integer, intent(in) :: index

      associate (system => self%motion%system)
         call system%gap_motion(index, self%gap(index))
         self%seen(index) = .true.
         self%clearance(index) = 0.0_wp
         if (.not. (self%may_pass .and. self%integrator%free_interpolation)) return
         self%clearance(index) = self%gap(index)%value
         self%fastest(index) = system%fastest(index, self%memory%y, self%memory%t - self%t_before)
      end associate
   end subroutine look_at_gap

   !> See the spots as they are at a state within the step, with what touches in it.
   subroutine view_spots(self, y)
      type(march_type), intent(inout) :: self
      real(wp), intent(in) :: y(:)
      integer :: index, trouble

      call self%motion%system%set_poses(y)
      call assign_spots(self%motion%system, self%memory%closed, index, trouble)
   end subroutine view_spots

   !> Begin to look at states within the step, of which nothing that follows is to depend, and keep
   !> what is to be put back.
   subroutine open_step(self, t, kept)
      type(march_type), intent(inout) :: self
      !> Time within the step [s].
      real(wp), intent(in) :: t
      type(kept_type), intent(out) :: kept
      type(statistics_type) :: before, after
      real(wp) :: y(self%motion%n)

      call keep_workspace(self%motion, kept)
      before = self%integrator%statistics()
      call self%integrator%interpolate(t, y)
      after = self%integrator%statistics()
      if (min(self%memory%row*self%plan%interval, self%plan%t_end) < self%memory%t) then
         ! A row has the same need of what the interpolation takes.
         call keep_workspace(self%motion, kept)
      else
         self%unasked = self%unasked + after%derivatives - before%derivatives
      end if
   end subroutine open_step

   !> Keep what a look at a state changes.
   subroutine keep_workspace(motion, kept)
      class(motion_type), intent(in) :: motion
      type(kept_type), intent(out) :: kept

      associate (system => motion%system)
         kept%too_deep = system%too_deep
         kept%trouble = system%trouble
         kept%trouble_code = system%trouble_code
         kept%outside = system%outside
         allocate(kept%track(motion%n_events), kept%force(motion%n_events))
         kept%track = system%contacts%track
         kept%force = system%contacts%normal_force
      end associate
   end subroutine keep_workspace

   !> Put back what a look at a state has changed.
   subroutine restore_workspace(motion, kept)
      class(motion_type), intent(inout) :: motion
      type(kept_type), intent(in) :: kept

      associate (system => motion%system)
         system%contacts%track = kept%track
         system%contacts%normal_force = kept%force
         system%too_deep = kept%too_deep
         system%trouble = kept%trouble
         system%trouble_code = kept%trouble_code
         system%outside = kept%outside
      end associate
   end subroutine restore_workspace

   !> Gap that is zero to rounding [m].
   pure real(wp) function zero_gap(y)
      !> State.
      real(wp), intent(in) :: y(:)

      zero_gap = 64.0_wp*epsilon(y)*(1.0_wp + maxval(abs(y)))
   end function zero_gap

end module contensou_integrate_step
