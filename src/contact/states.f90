!> States of the parts of a contact: numbers that are integrated with the motion, as the deflection
!> of bristles or a friction coefficient that relaxes.
!>
!> A part lists its states, gives their rates and what they do to its force. To the part a state is
!> a number, or two for a vector in the tangent plane: its components along the axes of the spot. In
!> the state of a scene such a vector has its three components in the inertial frame, since the axes
!> of a spot may turn about the normal in any way, on a circle also by a jump. Seen from the frame
!> in which the part gives its rates, they are constant: it follows the normal, and turns about it
!> by the mean of the angular velocities of the two bodies.
!> While a contact is open its states are constant.
module contensou_contact_states
   use contensou_base_kinds, only : wp
   use contensou_base_vectors, only : cross
   implicit none(type, external)
   private

   public :: state_type, state_list_type, contact_states_type, owner_type
   public :: most_states, most_numbers
   public :: against_itself, against_length, against_velocity, against_angular_velocity, &
      against_energy

   !> Numbers of state that the parts of a contact may own, a vector counted as two.
   integer, parameter :: most_states = 11

   !> Numbers that these are in the state of a scene.
   integer, parameter :: most_numbers = 16

   !> What the admissible error of a state is measured against beside the state itself: a value in
   !> its own unit, or so much of one of the scales of the integration.
   integer, parameter :: against_itself = 0, against_length = 1, against_velocity = 2, &
      against_angular_velocity = 3, against_energy = 4

   !> A state of a part.
   type :: state_type
      !> Name of the column in the output.
      character(len=31) :: name = ""
      !> UDUNITS text.
      character(len=8) :: units = ""
      character(len=128) :: long_name = ""
      !> Value against which its error counts as soon as the state is smaller.
      real(wp) :: scale = 1.0_wp
      !> Unit of that, one of the `against_*` codes.
      integer :: against = against_itself
      !> Whether it is a vector in the tangent plane.
      logical :: tangent = .false.
      !> Whether its error counts against that value however large the state is.
      logical :: absolute = .false.
   end type state_type

   !> The states of a part.
   type :: state_list_type
      integer :: n = 0
      !> The first `n` of them.
      type(state_type) :: items(most_states)
   contains
      procedure :: put => put_state
      procedure :: numbers
   end type state_list_type

   !> What owns states: the part of a contact. All here is what most parts need not answer.
   type, abstract :: owner_type
   contains
      procedure :: at_touch
      procedure :: after_lift
   end type owner_type

   !> Which numbers of the state vector the parts of a contact own.
   type :: contact_states_type
      !> Numbers in the state of the scene; all of the rest is only set where there are any.
      integer :: n = 0
      !> Numbers to the parts.
      integer :: n_local = 0
      !> Of these, those of damping, which come before those of friction.
      integer :: n_damping = 0
      !> Index of the first one in the state of the scene.
      integer :: first = 0
      !> Whether there are vectors.
      logical :: tangent = .false.
      type(state_type), allocatable :: items(:)
      !> Values, in the inertial frame.
      real(wp), allocatable :: values(:)
      real(wp), allocatable :: rates(:)
      !> Numbers to the parts against which differences and errors are small, see `scale`.
      real(wp), allocatable :: scales(:)
   contains
      procedure :: own
      procedure :: gather
      procedure :: scatter
      procedure :: turn
      procedure :: vectors
      procedure :: place
   end type contact_states_type

contains

   !> Add a state.
   subroutine put_state(self, name, units, long_name, scale, against, tangent, absolute)
      class(state_list_type), intent(inout) :: self
      !> Name of the column in the output.
      character(len=*), intent(in) :: name
      !> UDUNITS text.
      character(len=*), intent(in) :: units
      character(len=*), intent(in) :: long_name
      !> Value against which its error counts as soon as the state is smaller, > 0.
      real(wp), intent(in) :: scale
      !> Unit of that, one of the `against_*` codes; that of the state unless given.
      integer, intent(in), optional :: against
      !> Whether it is a vector in the tangent plane.
      logical, intent(in), optional :: tangent
      !> Whether its error counts against that value however large the state is.
      logical, intent(in), optional :: absolute

      self%n = self%n + 1
      associate (item => self%items(self%n))
         item%name = name
         item%units = units
         item%long_name = long_name
         item%scale = scale
         if (present(against)) item%against = against
         if (present(tangent)) item%tangent = tangent
         if (present(absolute)) item%absolute = absolute
      end associate
   end subroutine put_state

   !> Numbers that the states are to their part.
   pure integer function numbers(self)
      class(state_list_type), intent(in) :: self

      numbers = self%n + count(self%items(:self%n)%tangent)
   end function numbers

   !> Values when the surfaces touch: zero.
   pure subroutine at_touch(self, speed, states)
      class(owner_type), intent(in) :: self
      !> Speed of approach [m/s].
      real(wp), intent(in) :: speed
      real(wp), intent(out) :: states(:)

      states = 0.0_wp
   end subroutine at_touch

   !> Values after lift-off: zero.
   pure subroutine after_lift(self, states)
      class(owner_type), intent(in) :: self
      real(wp), intent(out) :: states(:)

      states = 0.0_wp
   end subroutine after_lift

   !> Take the states of the parts.
   subroutine own(self, damping, friction)
      class(contact_states_type), intent(inout) :: self
      type(state_list_type), intent(in) :: damping
      type(state_list_type), intent(in) :: friction

      self%n_damping = damping%numbers()
      self%n_local = self%n_damping + friction%numbers()
      self%n = self%n_local + count(damping%items(:damping%n)%tangent) &
         + count(friction%items(:friction%n)%tangent)
      if (self%n == 0) return
      allocate(self%items(damping%n + friction%n), self%values(self%n), self%rates(self%n), &
         self%scales(self%n_local))
      self%items(:damping%n) = damping%items(:damping%n)
      self%items(damping%n + 1:) = friction%items(:friction%n)
      self%tangent = any(self%items%tangent)
      self%values = 0.0_wp
      self%rates = 0.0_wp
      self%scales = 1.0_wp
   end subroutine own

   !> Values as the parts see them.
   pure subroutine gather(self, values, major, minor, states)
      class(contact_states_type), intent(in) :: self
      !> Values in the inertial frame.
      real(wp), intent(in) :: values(:)
      !> Unit tangents along the axes of the spot.
      real(wp), intent(in) :: major(3)
      real(wp), intent(in) :: minor(3)
      !> Values along these.
      real(wp), intent(out) :: states(:)
      integer :: i, j, k

      j = 0
      k = 0
      do i = 1, size(self%items)
         if (self%items(i)%tangent) then
            states(j + 1) = dot_product(values(k + 1:k + 3), major)
            states(j + 2) = dot_product(values(k + 1:k + 3), minor)
            j = j + 2
            k = k + 3
         else
            j = j + 1
            k = k + 1
            states(j) = values(k)
         end if
      end do
   end subroutine gather

   !> Add numbers of the parts to those of the scene.
   pure subroutine scatter(self, states, major, minor, values)
      class(contact_states_type), intent(in) :: self
      !> Numbers along the axes of the spot.
      real(wp), intent(in) :: states(:)
      real(wp), intent(in) :: major(3)
      real(wp), intent(in) :: minor(3)
      !> Numbers in the inertial frame, added to.
      real(wp), intent(inout) :: values(:)
      integer :: i, j, k

      j = 0
      k = 0
      do i = 1, size(self%items)
         if (self%items(i)%tangent) then
            values(k + 1:k + 3) = values(k + 1:k + 3) + states(j + 1)*major + states(j + 2)*minor
            j = j + 2
            k = k + 3
         else
            j = j + 1
            k = k + 1
            values(k) = values(k) + states(j)
         end if
      end do
   end subroutine scatter

   !> Add to rates what a rotation does to vectors.
   pure subroutine turn(self, values, spin, rates)
      class(contact_states_type), intent(in) :: self
      real(wp), intent(in) :: values(:)
      !> Angular velocity [rad/s].
      real(wp), intent(in) :: spin(3)
      real(wp), intent(inout) :: rates(:)
      integer :: i, k

      k = 0
      do i = 1, size(self%items)
         if (self%items(i)%tangent) then
            rates(k + 1:k + 3) = rates(k + 1:k + 3) + cross(spin, values(k + 1:k + 3))
            k = k + 3
         else
            k = k + 1
         end if
      end do
   end subroutine turn

   !> Which numbers to the parts are components of vectors.
   pure function vectors(self)
      class(contact_states_type), intent(in) :: self
      logical :: vectors(self%n_local)
      integer :: i, j

      j = 0
      do i = 1, size(self%items)
         vectors(j + 1) = self%items(i)%tangent
         if (self%items(i)%tangent) then
            vectors(j + 2) = .true.
            j = j + 1
         end if
         j = j + 1
      end do
   end function vectors

   !> Index of the number before the first one of a state in the state of the scene; -1 if the
   !> contact has no state of that name.
   pure integer function place(self, name)
      class(contact_states_type), intent(in) :: self
      character(len=*), intent(in) :: name
      integer :: i

      if (self%n > 0) then
         place = self%first - 1
         do i = 1, size(self%items)
            if (self%items(i)%name == name) return
            place = place + merge(3, 1, self%items(i)%tangent)
         end do
      end if
      place = -1
   end function place

end module contensou_contact_states
