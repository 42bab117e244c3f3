!> C interface of simulations; include/contensou.h documents it.
module contensou_capi_simulation
   use, intrinsic :: iso_c_binding, only : c_associated, c_char, c_double, c_f_pointer, &
      c_f_procpointer, c_funptr, c_int, c_loc, c_null_char, c_null_ptr, c_ptr
   use contensou, only : error_type, motion_type, new_simulation, observer_type, simulate, &
      simulation_type, wp
   use contensou_base_errors, only : fatal, status_usage
   use contensou_base_text_lock, only : lock_texts, unlock_texts
   use contensou_capi_kernels, only : bad_argument, ok
   use contensou_dynamics_state, only : position_of, quaternion_of, spin_of, velocity_of
   implicit none(type, external)
   private

   public :: contensou_error_message, contensou_error_status, contensou_error_free
   public :: contensou_simulation_new, contensou_simulate, contensou_simulation_free
   public :: contensou_simulation_time, contensou_simulation_size, contensou_simulation_state
   public :: contensou_simulation_body

   !> An error with its text as C has it.
   type :: error_handle_type
      !> Ended by a zero byte.
      character(len=1, kind=c_char), allocatable :: text(:)
      !> Exit status that belongs to it.
      integer(c_int) :: status = 0
   end type error_handle_type

   abstract interface
      !> Look at a row; another value than 0 asks to stop.
      function look_from_c(time, state, n, user_data) result(stop_now) bind(c)
         import :: c_double, c_int, c_ptr
         implicit none(type, external)
         !> Time [s].
         real(c_double), intent(in), value :: time
         real(c_double), intent(in) :: state(*)
         !> Size of the state.
         integer(c_int), intent(in), value :: n
         !> What the caller of the simulation gave.
         type(c_ptr), intent(in), value :: user_data
         integer(c_int) :: stop_now
      end function look_from_c
   end interface

   !> An observer that hands each row to a C function.
   type, extends(observer_type) :: watcher_type
      procedure(look_from_c), pointer, nopass :: look => null()
      type(c_ptr) :: user_data = c_null_ptr
      !> Whether the function has asked to stop.
      logical :: stops = .false.
   contains
      procedure :: sample
      procedure :: after_step
   end type watcher_type

contains

   !> Text of an error, ended by a zero byte; empty for none.
   function contensou_error_message(handle) result(text) bind(c)
      !> The error; null for none.
      type(c_ptr), intent(in), value :: handle
      type(c_ptr) :: text
      character(len=1, kind=c_char), save, target :: nothing(1) = [c_null_char]
      type(error_handle_type), pointer :: error

      text = c_loc(nothing)
      if (.not. c_associated(handle)) return
      call c_f_pointer(handle, error)
      text = c_loc(error%text)
   end function contensou_error_message

   !> Exit status of a program that gives up because of an error; 0 for none.
   function contensou_error_status(handle) result(status) bind(c)
      !> The error; null for none.
      type(c_ptr), intent(in), value :: handle
      integer(c_int) :: status
      type(error_handle_type), pointer :: error

      status = 0
      if (.not. c_associated(handle)) return
      call c_f_pointer(handle, error)
      status = error%status
   end function contensou_error_status

   !> Release an error; null is admitted.
   subroutine contensou_error_free(handle) bind(c)
      type(c_ptr), intent(in), value :: handle
      type(error_handle_type), pointer :: error

      if (.not. c_associated(handle)) return
      call c_f_pointer(handle, error)
      deallocate(error)
   end subroutine contensou_error_free

   !> Read a scene file and make a simulation of it; null on failure.
   function contensou_simulation_new(scene, settings, n, error_out) result(handle) bind(c)
      !> Name of the scene file.
      type(c_ptr), intent(in), value :: scene
      !> `n` texts as after `--set`; null for none.
      type(c_ptr), intent(in), value :: settings
      integer(c_int), intent(in), value :: n
      !> Where to put an error; null if it is not wanted.
      type(c_ptr), intent(in), value :: error_out
      type(c_ptr) :: handle
      type(simulation_type), pointer :: simulation
      type(error_type), allocatable :: error
      character(len=:), allocatable :: path, list(:)

      handle = c_null_ptr
      call lock_texts()
      call get_text(scene, path)
      call get_texts(settings, int(n), list)
      allocate(simulation)
      call new_simulation(path, simulation, error, list)
      if (allocated(error)) then
         deallocate(simulation)
      else
         handle = c_loc(simulation)
      end if
      call hand_over(error, error_out)
      call unlock_texts()
   end function contensou_simulation_new

   !> Simulate to the end, or until the callback asks to stop.
   function contensou_simulate(handle, look, user_data, error_out) result(status) bind(c)
      !> From `contensou_simulation_new`.
      type(c_ptr), intent(in), value :: handle
      !> Called for each row; null for nobody.
      type(c_funptr), intent(in), value :: look
      !> What it gets as its last argument.
      type(c_ptr), intent(in), value :: user_data
      !> Where to put an error; null if it is not wanted.
      type(c_ptr), intent(in), value :: error_out
      integer(c_int) :: status
      type(simulation_type), pointer :: simulation
      type(watcher_type) :: watcher
      type(error_type), allocatable :: error

      status = ok
      if (.not. c_associated(handle)) then
         call fatal(error, "there is no simulation", status_usage)
      else
         call c_f_pointer(handle, simulation)
         if (c_associated(look)) call c_f_procpointer(look, watcher%look)
         watcher%user_data = user_data
         call simulate(simulation, watcher, error)
      end if
      if (allocated(error)) status = int(error%status, c_int)
      call hand_over(error, error_out)
   end function contensou_simulate

   !> Release a simulation; null is admitted.
   subroutine contensou_simulation_free(handle) bind(c)
      !> From `contensou_simulation_new`.
      type(c_ptr), intent(in), value :: handle
      type(simulation_type), pointer :: simulation

      if (.not. c_associated(handle)) return
      call c_f_pointer(handle, simulation)
      deallocate(simulation)
   end subroutine contensou_simulation_free

   !> Time reached [s]; 0 without a simulation.
   function contensou_simulation_time(handle) result(time) bind(c)
      !> From `contensou_simulation_new`.
      type(c_ptr), intent(in), value :: handle
      real(c_double) :: time
      type(simulation_type), pointer :: simulation

      time = 0.0_c_double
      if (.not. c_associated(handle)) return
      call c_f_pointer(handle, simulation)
      time = simulation%time()
   end function contensou_simulation_time

   !> Size of the state; 0 without a simulation.
   function contensou_simulation_size(handle) result(n) bind(c)
      !> From `contensou_simulation_new`.
      type(c_ptr), intent(in), value :: handle
      integer(c_int) :: n
      type(simulation_type), pointer :: simulation

      n = 0
      if (.not. c_associated(handle)) return
      call c_f_pointer(handle, simulation)
      n = int(size(simulation%state()), c_int)
   end function contensou_simulation_size

   !> State at the time reached.
   function contensou_simulation_state(handle, state) result(status) bind(c)
      !> From `contensou_simulation_new`.
      type(c_ptr), intent(in), value :: handle
      !> As many numbers as `contensou_simulation_size` says.
      type(c_ptr), intent(in), value :: state
      integer(c_int) :: status
      type(simulation_type), pointer :: simulation
      real(c_double), pointer :: y(:)

      status = bad_argument
      if (.not. (c_associated(handle) .and. c_associated(state))) return
      call c_f_pointer(handle, simulation)
      call c_f_pointer(state, y, [size(simulation%state())])
      y = simulation%state()
      status = ok
   end function contensou_simulation_state

   !> Motion of a body at the time reached.
   function contensou_simulation_body(handle, name, position, quaternion, velocity, spin) &
      result(status) bind(c)
      !> From `contensou_simulation_new`.
      type(c_ptr), intent(in), value :: handle
      !> Name of the body.
      type(c_ptr), intent(in), value :: name
      !> Centre of mass [m], three numbers; null if it is not wanted, as each of these.
      type(c_ptr), intent(in), value :: position
      !> Attitude, body to inertial frame, four numbers.
      type(c_ptr), intent(in), value :: quaternion
      !> Velocity of the centre of mass [m/s].
      type(c_ptr), intent(in), value :: velocity
      !> Angular velocity in the axes of the body [rad/s].
      type(c_ptr), intent(in), value :: spin
      integer(c_int) :: status
      type(simulation_type), pointer :: simulation
      character(len=:), allocatable :: wanted
      integer :: i

      status = bad_argument
      if (.not. c_associated(handle)) return
      call c_f_pointer(handle, simulation)
      call get_text(name, wanted)
      do i = 1, size(simulation%scene%bodies)
         if (simulation%scene%bodies(i)%name /= wanted) cycle
         associate (y => simulation%memory%y)
            call put(position_of(y, i), position)
            call put(quaternion_of(y, i), quaternion)
            call put(velocity_of(y, i), velocity)
            call put(spin_of(y, i), spin)
         end associate
         status = ok
      end do
   end function contensou_simulation_body

   !> Put numbers where C wants them.
   subroutine put(numbers, place)
      real(wp), intent(in) :: numbers(:)
      !> Null if they are not wanted.
      type(c_ptr), intent(in), value :: place
      real(c_double), pointer :: x(:)

      if (.not. c_associated(place)) return
      call c_f_pointer(place, x, [size(numbers)])
      x = numbers
   end subroutine put

   !> Put an error, or null, where C wants it.
   subroutine hand_over(error, place)
      type(error_type), allocatable, intent(in) :: error
      !> Null if it is not wanted.
      type(c_ptr), intent(in), value :: place
      type(error_handle_type), pointer :: handle
      type(c_ptr), pointer :: out
      integer :: i

      if (.not. c_associated(place)) return
      call c_f_pointer(place, out)
      out = c_null_ptr
      if (.not. allocated(error)) return
      allocate(handle)
      handle%status = int(error%status, c_int)
      allocate(handle%text(len(error%message) + 1))
      do i = 1, len(error%message)
         handle%text(i) = error%message(i:i)
      end do
      handle%text(size(handle%text)) = c_null_char
      out = c_loc(handle)
   end subroutine hand_over

   !> A C string; null is an empty one.
   subroutine get_text(place, text)
      type(c_ptr), intent(in), value :: place
      character(len=:), allocatable, intent(out) :: text
      character(len=1, kind=c_char), pointer :: bytes(:)
      integer :: i, n

      n = 0
      if (c_associated(place)) then
         do
            call c_f_pointer(place, bytes, [n + 1])
            if (bytes(n + 1) == c_null_char) exit
            n = n + 1
         end do
      end if
      allocate(character(len=n) :: text)
      do i = 1, n
         text(i:i) = bytes(i)
      end do
   end subroutine get_text

   !> An array of C strings, padded with blanks; null is an empty one.
   subroutine get_texts(place, n, list)
      type(c_ptr), intent(in), value :: place
      integer, intent(in) :: n
      character(len=:), allocatable, intent(out) :: list(:)
      character(len=:), allocatable :: text
      type(c_ptr), pointer :: texts(:)
      integer :: i, longest

      if (n <= 0 .or. .not. c_associated(place)) then
         allocate(character(len=0) :: list(0))
         return
      end if
      call c_f_pointer(place, texts, [n])
      longest = 0
      do i = 1, n
         call get_text(texts(i), text)
         longest = max(longest, len(text))
      end do
      allocate(character(len=longest) :: list(n))
      do i = 1, n
         call get_text(texts(i), text)
         list(i) = text
      end do
   end subroutine get_texts

   !> A row is due.
   subroutine sample(self, motion, t, y, error)
      class(watcher_type), intent(inout) :: self
      class(motion_type), intent(inout) :: motion
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)
      type(error_type), allocatable, intent(out) :: error

      if (.not. associated(self%look) .or. self%stops) return
      self%stops = self%look(t, y, int(size(y), c_int), self%user_data) /= 0
   end subroutine sample

   !> A step is done.
   subroutine after_step(self, t, stop_now, error)
      class(watcher_type), intent(inout) :: self
      real(wp), intent(in) :: t
      logical, intent(out) :: stop_now
      type(error_type), allocatable, intent(out) :: error

      stop_now = self%stops
   end subroutine after_step

end module contensou_capi_simulation
