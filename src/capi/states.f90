!> C interface of the state of a simulation and of what the equations of motion say of states;
!> include/contensou.h documents it.
module contensou_capi_states
   use, intrinsic :: iso_c_binding, only : c_associated, c_bool, c_double, c_f_pointer, c_int, &
      c_null_ptr, c_ptr
   use contensou_base_errors, only : error_type, fatal, status_usage
   use contensou_base_kinds, only : wp
   use contensou_capi_handles, only : body_of, handle_type, status_of, take, take_at, view
   use contensou_capi_kernels, only : bad_argument, ok, put
   use contensou_capi_table, only : address_of, lives, of_simulation
   use contensou_dynamics_state, only : position_of, quaternion_of, spin_of, velocity_of
   implicit none(type, external)
   private

   public :: contensou_simulation_bodies, contensou_simulation_contacts
   public :: contensou_simulation_body_name, contensou_simulation_contact_name
   public :: contensou_simulation_size, contensou_simulation_state, contensou_simulation_set_state
   public :: contensou_simulation_body, contensou_simulation_derivative
   public :: contensou_simulation_jacobian, contensou_simulation_indicators
   public :: contensou_simulation_nominals
   public :: contensou_simulation_remembers, contensou_simulation_memory_indicator
   public :: contensou_simulation_put_host, contensou_simulation_complete_host_step
   public :: contensou_simulation_update_host, contensou_simulation_contact_load
   public :: contensou_simulation_contact_body

contains

   !> Number of bodies.
   function contensou_simulation_bodies(handle) result(n) bind(c)
      type(c_ptr), intent(in), value :: handle
      integer(c_int) :: n
      type(handle_type), pointer :: self

      n = 0
      if (.not. lives(handle, of_simulation)) return
      call c_f_pointer(address_of(handle, of_simulation), self)
      n = size(self%bodies)
   end function contensou_simulation_bodies

   !> Number of contacts.
   function contensou_simulation_contacts(handle) result(n) bind(c)
      type(c_ptr), intent(in), value :: handle
      integer(c_int) :: n
      type(handle_type), pointer :: self

      n = 0
      if (.not. lives(handle, of_simulation)) return
      call c_f_pointer(address_of(handle, of_simulation), self)
      n = size(self%contacts)
   end function contensou_simulation_contacts

   !> Name of a body; null if there is none.
   function contensou_simulation_body_name(handle, i) result(name) bind(c)
      type(c_ptr), intent(in), value :: handle
      !> Its number, from 0.
      integer(c_int), intent(in), value :: i
      type(c_ptr) :: name
      type(handle_type), pointer :: self

      name = c_null_ptr
      if (i < 0 .or. i >= contensou_simulation_bodies(handle)) return
      call c_f_pointer(address_of(handle, of_simulation), self)
      name = self%bodies(i + 1)%address()
   end function contensou_simulation_body_name

   !> Name of a contact; null if there is none.
   function contensou_simulation_contact_name(handle, i) result(name) bind(c)
      type(c_ptr), intent(in), value :: handle
      !> Its number, from 0.
      integer(c_int), intent(in), value :: i
      type(c_ptr) :: name
      type(handle_type), pointer :: self

      name = c_null_ptr
      if (i < 0 .or. i >= contensou_simulation_contacts(handle)) return
      call c_f_pointer(address_of(handle, of_simulation), self)
      name = self%contacts(i + 1)%address()
   end function contensou_simulation_contact_name

   !> Size of the state; 0 without a simulation.
   function contensou_simulation_size(handle) result(n) bind(c)
      type(c_ptr), intent(in), value :: handle
      integer(c_int) :: n
      type(handle_type), pointer :: self

      n = 0
      if (.not. lives(handle, of_simulation)) return
      call c_f_pointer(address_of(handle, of_simulation), self)
      n = size(self%course%guide%y)
   end function contensou_simulation_size

   !> State at the present.
   function contensou_simulation_state(handle, state) result(status) bind(c)
      type(c_ptr), intent(in), value :: handle
      !> As many numbers as `contensou_simulation_size` says.
      type(c_ptr), intent(in), value :: state
      integer(c_int) :: status
      type(handle_type), pointer :: self

      status = bad_argument
      if (.not. lives(handle, of_simulation) .or. .not. c_associated(state)) return
      call c_f_pointer(address_of(handle, of_simulation), self)
      call put(self%course%guide%y, state)
      status = ok
   end function contensou_simulation_state

   !> Set the state at the present.
   function contensou_simulation_set_state(handle, state, n, error_out) result(status) bind(c)
      type(c_ptr), intent(in), value :: handle
      type(c_ptr), intent(in), value :: state
      !> Size of the state.
      integer(c_int), intent(in), value :: n
      !> Where to put an error; null if it is not wanted.
      type(c_ptr), intent(in), value :: error_out
      integer(c_int) :: status
      type(handle_type), pointer :: self
      type(error_type), allocatable :: error
      real(c_double), pointer :: y(:)

      call take(handle, self, error)
      if (.not. allocated(error)) call view(state, n, y, error)
      if (.not. allocated(error)) call self%course%set_state(y, error)
      status = status_of(error, error_out)
   end function contensou_simulation_set_state

   !> Position, attitude and velocities of a body at the present.
   function contensou_simulation_body(handle, name, position, quaternion, velocity, &
      angular_velocity) result(status) bind(c)
      type(c_ptr), intent(in), value :: handle
      !> Name of the body.
      type(c_ptr), intent(in), value :: name
      !> Centre of mass (3) [m].
      type(c_ptr), intent(in), value :: position
      !> Body to inertial frame (4).
      type(c_ptr), intent(in), value :: quaternion
      !> Of the centre of mass (3) [m/s].
      type(c_ptr), intent(in), value :: velocity
      !> In the axes of the body (3) [rad/s].
      type(c_ptr), intent(in), value :: angular_velocity
      integer(c_int) :: status
      type(handle_type), pointer :: self
      integer :: i

      status = bad_argument
      if (.not. lives(handle, of_simulation)) return
      call c_f_pointer(address_of(handle, of_simulation), self)
      i = body_of(self, name)
      if (i == 0) return
      associate (y => self%course%guide%y)
         call put(position_of(y, i), position)
         call put(quaternion_of(y, i), quaternion)
         call put(velocity_of(y, i), velocity)
         call put(spin_of(y, i), angular_velocity)
      end associate
      status = ok
   end function contensou_simulation_body

   !> Time derivative of a state.
   function contensou_simulation_derivative(handle, time, state, n, rate, error_out) &
      result(status) bind(c)
      type(c_ptr), intent(in), value :: handle
      !> Time [s].
      real(c_double), intent(in), value :: time
      type(c_ptr), intent(in), value :: state
      !> Size of the state.
      integer(c_int), intent(in), value :: n
      !> Where to put it.
      type(c_ptr), intent(in), value :: rate
      !> Where to put an error; null if it is not wanted.
      type(c_ptr), intent(in), value :: error_out
      integer(c_int) :: status
      type(handle_type), pointer :: self
      type(error_type), allocatable :: error
      real(c_double), pointer :: y(:), out(:)

      call take_at(handle, time, state, n, rate, int(n), self, y, out, error)
      if (.not. allocated(error)) call self%course%derivative(time, y, out, error)
      status = status_of(error, error_out)
   end function contensou_simulation_derivative

   !> Derivatives of the rates by the state.
   function contensou_simulation_jacobian(handle, time, state, n, matrix, error_out) &
      result(status) bind(c)
      type(c_ptr), intent(in), value :: handle
      !> Time [s].
      real(c_double), intent(in), value :: time
      type(c_ptr), intent(in), value :: state
      !> Size of the state.
      integer(c_int), intent(in), value :: n
      !> Where to put them, row by row.
      type(c_ptr), intent(in), value :: matrix
      !> Where to put an error; null if it is not wanted.
      type(c_ptr), intent(in), value :: error_out
      integer(c_int) :: status
      type(handle_type), pointer :: self
      type(error_type), allocatable :: error
      real(c_double), pointer :: y(:), out(:), by_column(:, :)
      real(wp), allocatable :: slopes(:, :)

      call take_at(handle, time, state, n, matrix, 1, self, y, out, error)
      if (.not. allocated(error)) then
         allocate(slopes(n, n))
         call self%course%jacobian(time, y, slopes, error)
         if (.not. allocated(error)) then
            call c_f_pointer(matrix, by_column, [n, n])
            by_column = transpose(slopes)
         end if
      end if
      status = status_of(error, error_out)
   end function contensou_simulation_jacobian

   !> Functions that are zero at events.
   function contensou_simulation_indicators(handle, time, state, n, values, error_out) &
      result(status) bind(c)
      type(c_ptr), intent(in), value :: handle
      !> Time [s].
      real(c_double), intent(in), value :: time
      type(c_ptr), intent(in), value :: state
      !> Size of the state.
      integer(c_int), intent(in), value :: n
      !> Where to put them.
      type(c_ptr), intent(in), value :: values
      !> Where to put an error; null if it is not wanted.
      type(c_ptr), intent(in), value :: error_out
      integer(c_int) :: status
      type(handle_type), pointer :: self
      type(error_type), allocatable :: error
      real(c_double), pointer :: y(:), out(:)

      call take_at(handle, time, state, n, values, 0, self, y, out, error)
      if (.not. allocated(error)) then
         call c_f_pointer(values, out, [size(self%contacts)])
         call self%course%indicators(time, y, out, error)
      end if
      status = status_of(error, error_out)
   end function contensou_simulation_indicators

   !> What is usual of each number of the state.
   function contensou_simulation_nominals(handle, nominals, n, error_out) result(status) bind(c)
      type(c_ptr), intent(in), value :: handle
      !> Where to put them.
      type(c_ptr), intent(in), value :: nominals
      !> Size of the state.
      integer(c_int), intent(in), value :: n
      !> Where to put an error; null if it is not wanted.
      type(c_ptr), intent(in), value :: error_out
      integer(c_int) :: status
      type(handle_type), pointer :: self
      type(error_type), allocatable :: error
      real(c_double), pointer :: values(:)

      call take(handle, self, error)
      if (.not. allocated(error)) call view(nominals, n, values, error)
      if (.not. allocated(error)) then
         if (n == self%course%simulation%motion%n) then
            call self%course%nominals(values)
         else
            call fatal(error, "the state has another number of numbers", status_usage)
         end if
      end if
      status = status_of(error, error_out)
   end function contensou_simulation_nominals

   !> Whether contacts remember accepted steps.
   function contensou_simulation_remembers(handle) result(is_so) bind(c)
      type(c_ptr), intent(in), value :: handle
      logical(c_bool) :: is_so
      type(handle_type), pointer :: self

      is_so = .false._c_bool
      if (.not. lives(handle, of_simulation)) return
      call c_f_pointer(address_of(handle, of_simulation), self)
      is_so = logical(self%course%remembers(), c_bool)
   end function contensou_simulation_remembers

   !> A function that is zero where contacts have to remember an accepted step.
   function contensou_simulation_memory_indicator(handle, time, state, n, indicator, error_out) &
      result(status) bind(c)
      type(c_ptr), intent(in), value :: handle
      !> Time [s].
      real(c_double), intent(in), value :: time
      type(c_ptr), intent(in), value :: state
      !> Size of the state.
      integer(c_int), intent(in), value :: n
      !> Where to put it.
      type(c_ptr), intent(in), value :: indicator
      !> Where to put an error; null if it is not wanted.
      type(c_ptr), intent(in), value :: error_out
      integer(c_int) :: status
      type(handle_type), pointer :: self
      type(error_type), allocatable :: error
      real(c_double), pointer :: y(:), out(:)

      call take_at(handle, time, state, n, indicator, 1, self, y, out, error)
      if (.not. allocated(error)) call self%course%memory_indicator(time, y, out(1), error)
      status = status_of(error, error_out)
   end function contensou_simulation_memory_indicator

   !> What a contact alone does to its bodies at a state.
   function contensou_simulation_contact_load(handle, contact, state, n, force, torque_a, &
      torque_b, error_out) result(status) bind(c)
      type(c_ptr), intent(in), value :: handle
      !> Its number, from 0.
      integer(c_int), intent(in), value :: contact
      type(c_ptr), intent(in), value :: state
      !> Size of the state.
      integer(c_int), intent(in), value :: n
      !> Where to put the force on B (3) [N].
      type(c_ptr), intent(in), value :: force
      !> Where to put the torque on A (3) [N m].
      type(c_ptr), intent(in), value :: torque_a
      !> Where to put the torque on B (3) [N m].
      type(c_ptr), intent(in), value :: torque_b
      !> Where to put an error; null if it is not wanted.
      type(c_ptr), intent(in), value :: error_out
      integer(c_int) :: status
      type(handle_type), pointer :: self
      type(error_type), allocatable :: error
      real(c_double), pointer :: y(:), out(:)
      real(wp) :: on_b(3), torque(3, 2)

      call take_at(handle, 0.0_wp, state, n, state, 0, self, y, out, error)
      if (.not. allocated(error)) then
         if (contact < 0 .or. contact >= size(self%contacts)) then
            call fatal(error, "there is no contact of this number", status_usage)
         else
            call self%course%contact_load(int(contact) + 1, y, on_b, torque, error)
         end if
      end if
      if (.not. allocated(error)) then
         call put(on_b, force)
         call put(torque(:, 1), torque_a)
         call put(torque(:, 2), torque_b)
      end if
      status = status_of(error, error_out)
   end function contensou_simulation_contact_load

   !> Number of body A or B of a contact, from 0; -1 for the ground, and where there is no contact.
   function contensou_simulation_contact_body(handle, contact, is_b) result(body) bind(c)
      type(c_ptr), intent(in), value :: handle
      !> Number of the contact, from 0.
      integer(c_int), intent(in), value :: contact
      !> Whether body B is meant.
      logical(c_bool), intent(in), value :: is_b
      integer(c_int) :: body
      type(handle_type), pointer :: self

      body = -1
      if (contact < 0 .or. contact >= contensou_simulation_contacts(handle)) return
      call c_f_pointer(address_of(handle, of_simulation), self)
      associate (own => self%course%simulation%motion%system%contacts(contact + 1))
         body = int(merge(own%b, own%a, logical(is_b)) - 1, c_int)
      end associate
   end function contensou_simulation_contact_body

   !> Let the present be where another program has integrated to.
   function contensou_simulation_put_host(handle, time, state, n, error_out) result(status) bind(c)
      type(c_ptr), intent(in), value :: handle
      !> Time [s].
      real(c_double), intent(in), value :: time
      type(c_ptr), intent(in), value :: state
      !> Size of the state.
      integer(c_int), intent(in), value :: n
      !> Where to put an error; null if it is not wanted.
      type(c_ptr), intent(in), value :: error_out
      integer(c_int) :: status
      type(handle_type), pointer :: self
      type(error_type), allocatable :: error
      real(c_double), pointer :: y(:), out(:)

      call take_at(handle, time, state, n, state, 0, self, y, out, error)
      if (.not. allocated(error)) call self%course%put_host(time, y, error)
      status = status_of(error, error_out)
   end function contensou_simulation_put_host

   !> The other program has accepted a step to the present.
   function contensou_simulation_complete_host_step(handle, error_out) result(status) bind(c)
      type(c_ptr), intent(in), value :: handle
      !> Where to put an error; null if it is not wanted.
      type(c_ptr), intent(in), value :: error_out
      integer(c_int) :: status
      type(handle_type), pointer :: self
      type(error_type), allocatable :: error

      call take(handle, self, error)
      if (.not. allocated(error)) call self%course%complete_host_step()
      status = status_of(error, error_out)
   end function contensou_simulation_complete_host_step

   !> Take the events at the present for another program that integrates.
   function contensou_simulation_update_host(handle, changed, error_out) result(status) bind(c)
      type(c_ptr), intent(in), value :: handle
      !> Where to put whether the state is another one; null if it is not wanted.
      type(c_ptr), intent(in), value :: changed
      !> Where to put an error; null if it is not wanted.
      type(c_ptr), intent(in), value :: error_out
      integer(c_int) :: status
      type(handle_type), pointer :: self
      type(error_type), allocatable :: error
      logical(c_bool), pointer :: out
      logical :: is_new

      is_new = .false.
      call take(handle, self, error)
      if (.not. allocated(error)) call self%course%update_host(is_new, error)
      if (c_associated(changed)) then
         call c_f_pointer(changed, out)
         out = is_new
      end if
      status = status_of(error, error_out)
   end function contensou_simulation_update_host

end module contensou_capi_states
