!> The cases of a sweep in a bare loop: the scene is read once, the parameter is assigned, nothing
!> is parsed, watched, written or shared. What `contensou sweep -j 1` needs beyond this is its own.
module bare_sweep_witness
   use contensou_base_errors, only : error_type
   use contensou_base_kinds, only : wp
   use contensou_integrate_observer, only : event_touch, observer_type
   use contensou_integrate_motion, only : motion_type
   use contensou_study_quantities, only : row_type
   use contensou_study_summary, only : summary_type
   implicit none(type, external)
   private

   public :: witness_type

   !> Takes what makes the summary.
   type, extends(observer_type) :: witness_type
      !> The last row.
      type(row_type) :: row
      !> What the case comes down to.
      type(summary_type) :: summary
   contains
      procedure :: sample
      procedure :: event
   end type witness_type

contains

   !> A row is due.
   subroutine sample(self, motion, t, y, error)
      class(witness_type), intent(inout) :: self
      class(motion_type), intent(inout) :: motion
      !> Time [s].
      real(wp), intent(in) :: t
      !> State.
      real(wp), intent(in) :: y(:)
      !> Never set.
      type(error_type), allocatable, intent(out) :: error

      call self%summary%add_row(self%row, motion%system, t, y, error)
   end subroutine sample

   !> A contact touched or lifted off.
   subroutine event(self, t, kind, contact, error)
      class(witness_type), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> `event_touch` or `event_lift`.
      integer, intent(in) :: kind
      !> Index of the contact.
      integer, intent(in) :: contact
      !> Never set.
      type(error_type), allocatable, intent(out) :: error

      call self%summary%add_event(kind == event_touch)
   end subroutine event

end module bare_sweep_witness
