!> A scene's right-hand side for programs that integrate it in a way of their own, with the first
!> touch of a contact that is open at the beginning, if they look for one.
!>
!> Calls of the right-hand side are counted. No output; no events but the touch.
module cost_problem
   use contensou_base_kinds, only : wp
   use contensou_integrate_motion, only : motion_type
   implicit none(type, external)
   private

   public :: handle_type, outcome_type, bracket_type, derivative, gap, trial, narrow, resolved

   !> What is integrated; the callbacks get its address.
   type :: handle_type
      type(motion_type) :: motion
      !> Initial state; the bare loop leaves its last one.
      real(wp), allocatable :: y(:)
      !> End of time [s].
      real(wp) :: t_end = 0.0_wp
      !> Gaps of all contacts [m].
      real(wp), allocatable :: gaps(:)
      !> The contact whose touch ends the integration; 0 for none.
      integer :: contact = 0
      !> Calls of the right-hand side.
      integer :: calls = 0
   end type handle_type

   !> What an integration comes to.
   type :: outcome_type
      !> Time of the touch, or the end of time [s].
      real(wp) :: t = 0.0_wp
      !> Whether there was a touch.
      logical :: touched = .false.
      !> Accepted steps.
      integer :: steps = 0
      !> CPU time of the loop [s].
      real(wp) :: cpu = 0.0_wp
   end type outcome_type

   !> Lengths of a step between which the gap changes its sign.
   type :: bracket_type
      !> Lengths of the shorter and of the longer step [s].
      real(wp) :: h(2) = 0.0_wp
      !> Gaps after these, positive and negative [m].
      real(wp) :: gap(2) = 0.0_wp
      !> Which of them was replaced last.
      integer :: replaced = 0
   end type bracket_type

contains

   !> Right-hand side.
   subroutine derivative(self, t, y, rate, outside)
      !> The problem.
      type(handle_type), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> State.
      real(wp), intent(in) :: y(:)
      !> Its time derivative.
      real(wp), intent(out) :: rate(:)
      !> Whether the state is outside the domain of the model.
      logical, intent(out) :: outside

      self%calls = self%calls + 1
      call self%motion%derivative(t, y, rate, outside)
   end subroutine derivative

   !> Gap of the contact that is waited for [m]; 1 without one.
   function gap(self, y) result(value)
      !> The problem.
      type(handle_type), intent(inout) :: self
      !> State.
      real(wp), intent(in) :: y(:)
      real(wp) :: value

      value = 1.0_wp
      if (self%contact == 0) return
      call self%motion%system%gaps(y, self%gaps)
      value = self%gaps(self%contact)
   end function gap

   !> Length of a step between those of a bracket, where the gap is expected to be zero: false
   !> position, and now and then the middle, as rounding can keep the former at one side.
   pure function trial(bracket, round) result(h)
      type(bracket_type), intent(in) :: bracket
      !> Number of the trial.
      integer, intent(in) :: round
      real(wp) :: h

      associate (a => bracket%h(1), b => bracket%h(2), g => bracket%gap)
         h = a + (b - a)*g(1)/(g(1) - g(2))
         if (mod(round, 4) == 0) h = a + 0.5_wp*(b - a)
      end associate
   end function trial

   !> Replace an end of a bracket; Illinois' rule halves the gap of an end that stays twice.
   pure subroutine narrow(bracket, h, value)
      type(bracket_type), intent(inout) :: bracket
      !> Length of a step [s].
      real(wp), intent(in) :: h
      !> Gap after it [m].
      real(wp), intent(in) :: value
      integer :: side

      side = merge(1, 2, value > 0.0_wp)
      bracket%h(side) = h
      bracket%gap(side) = value
      if (bracket%replaced == side) bracket%gap(3 - side) = 0.5_wp*bracket%gap(3 - side)
      bracket%replaced = side
   end subroutine narrow

   !> Whether a bracket is as narrow as time can be told.
   pure function resolved(bracket, t) result(narrow_enough)
      type(bracket_type), intent(in) :: bracket
      !> Time at the beginning of the step [s].
      real(wp), intent(in) :: t
      logical :: narrow_enough

      narrow_enough = bracket%h(2) - bracket%h(1) <= 64.0_wp*spacing(t)
   end function resolved

end module cost_problem
