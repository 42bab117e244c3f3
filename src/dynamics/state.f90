!> The state of a system: which number is where.
!>
!> State of a body, 13 numbers: centre of mass r (inertial), quaternion q (w, x, y, z; body to
!> inertial; its norm carries no meaning), velocity v (inertial), angular velocity (body frame).
!> After the bodies come, only if the scene has them, the states of the parts of contacts, one
!> contact after the other, and then the work of friction, the work of damping and the work supplied
!> by applied loads and drives, so that a run closes its own energy balance. The first two are lost
!> but for what states of parts store.
!> The accessors take a state or its time derivative alike.
module contensou_dynamics_state
   use contensou_base_kinds, only : wp
   implicit none(type, external)
   private

   public :: layout_type, body_size, at_position, at_quaternion, at_velocity, at_spin
   public :: position_of, quaternion_of, velocity_of, spin_of, put_body, add_to_motion

   !> Numbers of state per body.
   integer, parameter :: body_size = 13

   !> Place of the first number of each kind among those of a body.
   integer, parameter :: at_position = 1, at_quaternion = 4, at_velocity = 8, at_spin = 11

   !> Layout of a state.
   type :: layout_type
      !> Length of the state.
      integer :: n = 0
      !> Number of bodies, without the ground.
      integer :: bodies = 0
      !> Number of states of parts.
      integer :: states = 0
      !> Index of the work of friction; 0 without friction.
      integer :: friction = 0
      !> Index of the work of damping; 0 without damping.
      integer :: damping = 0
      !> Index of the work of applied loads and drives; 0 without them.
      integer :: applied = 0
   contains
      procedure :: lay_out
      procedure :: works
   end type layout_type

contains

   !> Give each number of a state its place: bodies, states of parts, works.
   pure subroutine lay_out(self, bodies, states, friction, damping, applied)
      class(layout_type), intent(inout) :: self
      integer, intent(in) :: bodies
      !> Number of states of parts.
      integer, intent(in) :: states
      !> Whether anything rubs.
      logical, intent(in) :: friction
      !> Whether anything else loses energy.
      logical, intent(in) :: damping
      !> Whether loads or drives supply energy.
      logical, intent(in) :: applied

      self%bodies = bodies
      self%states = states
      self%n = body_size*bodies + states
      call append(self%n, friction, self%friction)
      call append(self%n, damping, self%damping)
      call append(self%n, applied, self%applied)
   end subroutine lay_out

   !> Append a number to the state if the scene has it.
   pure subroutine append(n, has_it, index)
      !> Length of the state.
      integer, intent(inout) :: n
      logical, intent(in) :: has_it
      !> Index of the number; 0 if the scene does not have it.
      integer, intent(out) :: index

      index = 0
      if (.not. has_it) return
      n = n + 1
      index = n
   end subroutine append

   !> Number of works.
   pure integer function works(self)
      class(layout_type), intent(in) :: self

      works = count([self%friction, self%damping, self%applied] > 0)
   end function works

   !> Centre of mass of a body [m].
   pure function position_of(y, body) result(position)
      real(wp), intent(in) :: y(:)
      !> Index of the body, 1 to the number of bodies.
      integer, intent(in) :: body
      real(wp) :: position(3)
      integer :: k

      k = body_size*(body - 1) + at_position
      position = y(k:k + 2)
   end function position_of

   !> Quaternion of a body, of any norm.
   pure function quaternion_of(y, body) result(quaternion)
      real(wp), intent(in) :: y(:)
      integer, intent(in) :: body
      real(wp) :: quaternion(4)
      integer :: k

      k = body_size*(body - 1) + at_quaternion
      quaternion = y(k:k + 3)
   end function quaternion_of

   !> Velocity of the centre of mass of a body [m/s].
   pure function velocity_of(y, body) result(velocity)
      real(wp), intent(in) :: y(:)
      integer, intent(in) :: body
      real(wp) :: velocity(3)
      integer :: k

      k = body_size*(body - 1) + at_velocity
      velocity = y(k:k + 2)
   end function velocity_of

   !> Angular velocity of a body, body frame [rad/s].
   pure function spin_of(y, body) result(spin)
      real(wp), intent(in) :: y(:)
      integer, intent(in) :: body
      real(wp) :: spin(3)
      integer :: k

      k = body_size*(body - 1) + at_spin
      spin = y(k:k + 2)
   end function spin_of

   !> Set all numbers of a body.
   pure subroutine put_body(y, body, position, quaternion, velocity, spin)
      real(wp), intent(inout) :: y(:)
      integer, intent(in) :: body
      real(wp), intent(in) :: position(3)
      real(wp), intent(in) :: quaternion(4)
      real(wp), intent(in) :: velocity(3)
      !> Angular velocity, body frame.
      real(wp), intent(in) :: spin(3)
      integer :: k

      k = body_size*(body - 1)
      y(k + at_position:k + at_position + 2) = position
      y(k + at_quaternion:k + at_quaternion + 3) = quaternion
      y(k + at_velocity:k + at_velocity + 2) = velocity
      y(k + at_spin:k + at_spin + 2) = spin
   end subroutine put_body

   !> Add to velocity and angular velocity of a body.
   pure subroutine add_to_motion(y, body, velocity, spin)
      real(wp), intent(inout) :: y(:)
      integer, intent(in) :: body
      real(wp), intent(in) :: velocity(3)
      !> Angular velocity, body frame.
      real(wp), intent(in) :: spin(3)
      integer :: k

      k = body_size*(body - 1)
      y(k + at_velocity:k + at_velocity + 2) = y(k + at_velocity:k + at_velocity + 2) + velocity
      y(k + at_spin:k + at_spin + 2) = y(k + at_spin:k + at_spin + 2) + spin
   end subroutine add_to_motion

end module contensou_dynamics_state
