!> Who looks on while a march goes on.
module contensou_integrate_observer
   use contensou_base_errors, only : error_type
   use contensou_base_kinds, only : wp
   use contensou_integrate_memory, only : memory_type
   use contensou_integrate_motion, only : motion_type
   implicit none(type, external)
   private

   public :: event_lift, event_touch, observer_type

   !> A gap closes.
   integer, parameter :: event_touch = 1

   !> A gap opens.
   integer, parameter :: event_lift = 2

   !> Who looks on; this one does nothing.
   type :: observer_type
      !> Whether `keep` is to be called after this step; `after_step` may set it.
      logical :: keep_due = .false.
      !> Time of a state that is asked for beside the rows [s]; a march hands it to `between` when
      !> it has come there, and runs on as if it had not been asked.
      real(wp) :: next_time = huge(1.0_wp)
      !> Time beyond which the march does not go: if that is within a step, it hands the state there
      !> to `at_wait` and returns, and goes on with the same step when it is called again [s].
      real(wp) :: wait = huge(1.0_wp)
   contains
      procedure :: sample
      procedure :: event
      procedure :: after_step
      procedure :: between
      procedure :: at_wait
      procedure :: advise
      procedure :: warn
      procedure :: change_method
      procedure :: keep
   end type observer_type

contains

   !> A row is due; nobody looks at it unless an observer overrides this.
   subroutine sample(self, motion, t, y, error)
      class(observer_type), intent(inout) :: self
      class(motion_type), intent(inout) :: motion
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)
      !> Set to end the march.
      type(error_type), allocatable, intent(out) :: error
   end subroutine sample

   !> A contact touched or lifted off; nobody takes note unless an observer overrides this.
   subroutine event(self, t, kind, contact, error)
      class(observer_type), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> `event_touch` or `event_lift`.
      integer, intent(in) :: kind
      integer, intent(in) :: contact
      !> Set to end the march.
      type(error_type), allocatable, intent(out) :: error
   end subroutine event

   !> A step is done; another one follows unless an observer overrides this.
   subroutine after_step(self, t, stop_now, error)
      class(observer_type), intent(inout) :: self
      !> Time reached [s].
      real(wp), intent(in) :: t
      logical, intent(out) :: stop_now
      !> Set to end the march.
      type(error_type), allocatable, intent(out) :: error

      stop_now = .false.
   end subroutine after_step

   !> The state at `next_time`; nobody asked for it unless an observer overrides this.
   subroutine between(self, motion, t, y, error)
      class(observer_type), intent(inout) :: self
      class(motion_type), intent(inout) :: motion
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)
      !> Set to end the march.
      type(error_type), allocatable, intent(out) :: error

      self%next_time = huge(t)
   end subroutine between

   !> The state at `wait`; nobody asked for it unless an observer overrides this.
   subroutine at_wait(self, motion, t, y, error)
      class(observer_type), intent(inout) :: self
      class(motion_type), intent(inout) :: motion
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)
      !> Set to end the march.
      type(error_type), allocatable, intent(out) :: error
   end subroutine at_wait

   !> The method has something to say to the user; nobody listens unless an observer overrides this.
   subroutine advise(self, t, text)
      class(observer_type), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> What it says.
      character(len=*), intent(in) :: text
   end subroutine advise

   !> What the user should know of a run that came to its end; nobody listens unless an observer
   !> overrides this.
   subroutine warn(self, text)
      class(observer_type), intent(inout) :: self
      !> What it is.
      character(len=*), intent(in) :: text
   end subroutine warn

   !> `auto` goes on with another method; nobody takes note unless an observer overrides this.
   subroutine change_method(self, t, method, reason)
      class(observer_type), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> The method from here on.
      character(len=*), intent(in) :: method
      !> Why.
      character(len=*), intent(in) :: reason
   end subroutine change_method

   !> The march can be continued from here; forgotten unless an observer overrides this.
   subroutine keep(self, motion, memory, error)
      class(observer_type), intent(inout) :: self
      class(motion_type), intent(inout) :: motion
      type(memory_type), intent(inout) :: memory
      !> Set to end the march.
      type(error_type), allocatable, intent(out) :: error

      self%keep_due = .false.
   end subroutine keep

end module contensou_integrate_observer
