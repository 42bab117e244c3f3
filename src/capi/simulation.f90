!> C interface of simulations: making, running and releasing them; include/contensou.h documents it.
module contensou_capi_simulation
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite, ieee_positive_inf, ieee_value
   use, intrinsic :: iso_c_binding, only : c_associated, c_double, c_f_pointer, c_f_procpointer, &
      c_funptr, c_int, c_loc, c_null_ptr, c_ptr
   use contensou_base_errors, only : error_type, fatal, status_usage
   use contensou_base_kinds, only : wp
   use contensou_base_numbers, only : to_text
   use contensou_base_text_lock, only : lock_texts, unlock_texts
   use contensou_capi_errors, only : hand_over
   use contensou_capi_handles, only : handle_type, load, look_from_c, status_of, take
   use contensou_capi_kernels, only : bad_argument, ok
   use contensou_capi_table, only : address_of, drop_handle, lives, new_handle, of_simulation
   use contensou_capi_texts, only : c_text_type, get_text, get_texts
   implicit none(type, external)
   private

   public :: contensou_interface, contensou_simulation_make, contensou_simulation_new
   public :: contensou_simulation_free, contensou_simulation_reset, contensou_simulation_settings
   public :: contensou_simulation_warnings, contensou_simulation_observe
   public :: contensou_simulation_advance, contensou_simulation_advance_to_event
   public :: contensou_simulate, contensou_simulation_time, contensou_simulation_end
   public :: contensou_simulation_stop, contensou_simulation_next_corner

   !> The oldest and the newest interface that the library knows.
   integer(c_int), parameter :: oldest_interface = 1, newest_interface = 3

contains

   !> Number of the newest interface.
   function contensou_interface() result(number) bind(c)
      integer(c_int) :: number

      number = newest_interface
   end function contensou_interface

   !> Make a simulation; null on failure.
   function contensou_simulation_make(interface, name, text, settings, n, error_out) &
      result(handle) bind(c)
      !> Number of the interface for which the caller was compiled.
      integer(c_int), intent(in), value :: interface
      !> Name of the scene file or text.
      type(c_ptr), intent(in), value :: name
      !> The text; null for a file.
      type(c_ptr), intent(in), value :: text
      !> `n` texts as after `--set`; null for none.
      type(c_ptr), intent(in), value :: settings
      integer(c_int), intent(in), value :: n
      !> Where to put an error; null if it is not wanted.
      type(c_ptr), intent(in), value :: error_out
      type(c_ptr) :: handle
      type(handle_type), pointer :: self
      type(error_type), allocatable :: error

      handle = c_null_ptr
      call lock_texts()
      if (interface < oldest_interface .or. interface > newest_interface) then
         call fatal(error, "the program was compiled with a header of interface " // &
            to_text(int(interface)) // ", the library knows " // to_text(int(oldest_interface)) // &
            " to " // to_text(int(newest_interface)), status_usage)
      else if (n < 0 .or. (n > 0 .and. .not. c_associated(settings))) then
         call fatal(error, "the settings are not there", status_usage)
      end if
      if (allocated(error)) then
         call hand_over(error, error_out)
         call unlock_texts()
         return
      end if
      allocate(self)
      call get_text(name, self%name)
      if (c_associated(text)) call get_text(text, self%text)
      call get_texts(settings, n, self%settings)
      if (load(self, self%settings, error_out)) then
         handle = new_handle(c_loc(self), of_simulation)
      else
         deallocate(self)
      end if
      call unlock_texts()
   end function contensou_simulation_make

   !> The same for programs compiled with the first interface.
   function contensou_simulation_new(scene, settings, n, error_out) result(handle) bind(c)
      !> Name of the scene file.
      type(c_ptr), intent(in), value :: scene
      !> `n` texts as after `--set`; null for none.
      type(c_ptr), intent(in), value :: settings
      integer(c_int), intent(in), value :: n
      !> Where to put an error; null if it is not wanted.
      type(c_ptr), intent(in), value :: error_out
      type(c_ptr) :: handle

      handle = contensou_simulation_make(oldest_interface, scene, c_null_ptr, settings, n, &
         error_out)
   end function contensou_simulation_new

   !> Release a simulation; null is admitted.
   subroutine contensou_simulation_free(handle) bind(c)
      type(c_ptr), intent(in), value :: handle
      type(handle_type), pointer :: self

      if (.not. lives(handle, of_simulation)) return
      call c_f_pointer(address_of(handle, of_simulation), self)
      ! A simulation under way cannot vanish below itself.
      if (self%course%busy) return
      call drop_handle(handle, of_simulation)
      call self%course%release()
      deallocate(self)
   end subroutine contensou_simulation_free

   !> Put a simulation back to its beginning.
   function contensou_simulation_reset(handle, error_out) result(status) bind(c)
      type(c_ptr), intent(in), value :: handle
      !> Where to put an error; null if it is not wanted.
      type(c_ptr), intent(in), value :: error_out
      integer(c_int) :: status
      type(handle_type), pointer :: self
      type(error_type), allocatable :: error

      call take(handle, self, error)
      if (.not. allocated(error)) call self%course%begin(self%loaded%file, error)
      status = status_of(error, error_out)
   end function contensou_simulation_reset

   !> All settings of the scene.
   function contensou_simulation_settings(handle) result(text) bind(c)
      type(c_ptr), intent(in), value :: handle
      type(c_ptr) :: text
      type(handle_type), pointer :: self
      type(c_text_type) :: nothing

      text = nothing%address()
      if (.not. lives(handle, of_simulation)) return
      call c_f_pointer(address_of(handle, of_simulation), self)
      text = self%resolved%address()
   end function contensou_simulation_settings

   !> What is legal in the scene and hardly meant.
   function contensou_simulation_warnings(handle) result(text) bind(c)
      type(c_ptr), intent(in), value :: handle
      type(c_ptr) :: text
      type(handle_type), pointer :: self
      type(c_text_type) :: nothing

      text = nothing%address()
      if (.not. lives(handle, of_simulation)) return
      call c_f_pointer(address_of(handle, of_simulation), self)
      text = self%warnings%address()
   end function contensou_simulation_warnings

   !> Let functions look at rows and events.
   function contensou_simulation_observe(handle, row, event, user_data) result(status) bind(c)
      type(c_ptr), intent(in), value :: handle
      !> Called for each row; null for nobody.
      type(c_funptr), intent(in), value :: row
      !> Called for each event; null for nobody.
      type(c_funptr), intent(in), value :: event
      !> What they get as their last argument.
      type(c_ptr), intent(in), value :: user_data
      integer(c_int) :: status
      type(handle_type), pointer :: self
      type(error_type), allocatable :: error

      call take(handle, self, error)
      status = bad_argument
      if (allocated(error)) return
      associate (caller => self%caller)
         nullify(caller%look, caller%hear)
         if (c_associated(row)) call c_f_procpointer(row, caller%look)
         if (c_associated(event)) call c_f_procpointer(event, caller%hear)
         caller%look_data = user_data
         caller%hear_data = user_data
      end associate
      status = ok
   end function contensou_simulation_observe

   !> Go on to a time.
   function contensou_simulation_advance(handle, time, error_out) result(status) bind(c)
      type(c_ptr), intent(in), value :: handle
      !> Time [s].
      real(c_double), intent(in), value :: time
      !> Where to put an error; null if it is not wanted.
      type(c_ptr), intent(in), value :: error_out
      integer(c_int) :: status

      status = go_to(handle, time, .false., error_out)
   end function contensou_simulation_advance

   !> Go on to a time or an event.
   function contensou_simulation_advance_to_event(handle, time, error_out) result(status) bind(c)
      type(c_ptr), intent(in), value :: handle
      !> Time [s].
      real(c_double), intent(in), value :: time
      !> Where to put an error; null if it is not wanted.
      type(c_ptr), intent(in), value :: error_out
      integer(c_int) :: status

      status = go_to(handle, time, .true., error_out)
   end function contensou_simulation_advance_to_event

   !> Go on to a time, perhaps only to the next event.
   integer(c_int) function go_to(handle, time, to_events, error_out) result(status)
      type(c_ptr), intent(in), value :: handle
      !> Time [s].
      real(wp), intent(in) :: time
      logical, intent(in) :: to_events
      !> Where to put an error; null if it is not wanted.
      type(c_ptr), intent(in), value :: error_out
      type(handle_type), pointer :: self
      type(error_type), allocatable :: error

      call take(handle, self, error)
      if (.not. allocated(error)) call self%course%advance(time, error, to_events)
      status = status_of(error, error_out)
   end function go_to

   !> Simulate to the end, or until the callback asks to stop.
   function contensou_simulate(handle, look, user_data, error_out) result(status) bind(c)
      type(c_ptr), intent(in), value :: handle
      !> Called for each row; null for nobody.
      type(c_funptr), intent(in), value :: look
      !> What it gets as its last argument.
      type(c_ptr), intent(in), value :: user_data
      !> Where to put an error; null if it is not wanted.
      type(c_ptr), intent(in), value :: error_out
      integer(c_int) :: status
      type(handle_type), pointer :: self
      type(error_type), allocatable :: error
      procedure(look_from_c), pointer :: before
      type(c_ptr) :: data_before

      call take(handle, self, error)
      if (.not. allocated(error)) then
         associate (caller => self%caller)
            before => caller%look
            data_before = caller%look_data
            nullify(caller%look)
            if (c_associated(look)) call c_f_procpointer(look, caller%look)
            caller%look_data = user_data
            call self%course%advance(max(self%course%simulation%plan%t_end, &
               self%course%guide%t), error)
            caller%look => before
            caller%look_data = data_before
         end associate
      end if
      status = status_of(error, error_out)
   end function contensou_simulate

   !> The present [s]; 0 without a simulation.
   function contensou_simulation_time(handle) result(time) bind(c)
      type(c_ptr), intent(in), value :: handle
      real(c_double) :: time
      type(handle_type), pointer :: self

      time = 0.0_c_double
      if (.not. lives(handle, of_simulation)) return
      call c_f_pointer(address_of(handle, of_simulation), self)
      time = self%course%guide%t
   end function contensou_simulation_time

   !> The end of the scene [s]; 0 without a simulation.
   function contensou_simulation_end(handle) result(time) bind(c)
      type(c_ptr), intent(in), value :: handle
      real(c_double) :: time
      type(handle_type), pointer :: self

      time = 0.0_c_double
      if (.not. lives(handle, of_simulation)) return
      call c_f_pointer(address_of(handle, of_simulation), self)
      time = self%course%simulation%plan%t_end
   end function contensou_simulation_end

   !> Number of the condition that has ended it; 0 for none.
   function contensou_simulation_stop(handle) result(number) bind(c)
      type(c_ptr), intent(in), value :: handle
      integer(c_int) :: number
      type(handle_type), pointer :: self

      number = 0
      if (.not. lives(handle, of_simulation)) return
      call c_f_pointer(address_of(handle, of_simulation), self)
      number = int(self%course%simulation%memory%stops%ended_by, c_int)
   end function contensou_simulation_stop

   !> The next end of a ramp [s]; infinite for none.
   function contensou_simulation_next_corner(handle, time) result(corner) bind(c)
      type(c_ptr), intent(in), value :: handle
      !> The time after which [s].
      real(c_double), intent(in), value :: time
      real(c_double) :: corner
      type(handle_type), pointer :: self

      corner = ieee_value(corner, ieee_positive_inf)
      if (.not. lives(handle, of_simulation) .or. .not. ieee_is_finite(time)) return
      call c_f_pointer(address_of(handle, of_simulation), self)
      associate (next => self%course%simulation%motion%system%next_corner(time))
         if (next < huge(next)) corner = next
      end associate
   end function contensou_simulation_next_corner

end module contensou_capi_simulation
