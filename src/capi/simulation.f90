!> C interface of simulations; include/contensou.h documents it.
module contensou_capi_simulation
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite, ieee_positive_inf, ieee_value
   use, intrinsic :: iso_c_binding, only : c_associated, c_bool, c_char, c_double, c_f_pointer, &
      c_f_procpointer, c_funptr, c_int, c_loc, c_null_char, c_null_funptr, c_null_ptr, c_ptr, &
      c_size_t
   use contensou_base_checkpoint, only : checkpoint_type
   use contensou_base_diagnostics, only : diagnostics_type
   use contensou_base_errors, only : error_type, fatal, status_usage
   use contensou_base_kinds, only : wp
   use contensou_base_numbers, only : to_text
   use contensou_base_schema, only : kind_integer
   use contensou_base_text, only : lower, nearest, quote, string_type
   use contensou_base_text_lock, only : lock_texts, unlock_texts
   use contensou_capi_errors, only : hand_over
   use contensou_capi_kernels, only : bad_argument, ok
   use contensou_capi_texts, only : c_text_type, get_text, get_texts
   use contensou_dynamics_state, only : position_of, quaternion_of, spin_of, velocity_of
   use contensou_scene_parameters, only : list_parameters, parameter_type
   use contensou_scene_reader, only : load_scene, loaded_scene_type, mistakes_text
   use contensou_study_course, only : course_type, listener_type
   use contensou_study_quantity, only : quantity_type
   implicit none(type, external)
   private

   public :: contensou_interface
   public :: contensou_simulation_make, contensou_simulation_new, contensou_simulation_free
   public :: contensou_simulation_reset, contensou_simulation_settings
   public :: contensou_simulation_warnings, contensou_simulation_observe
   public :: contensou_simulation_advance, contensou_simulation_advance_to_event
   public :: contensou_simulate, contensou_simulation_time, contensou_simulation_end
   public :: contensou_simulation_stop, contensou_simulation_next_corner
   public :: contensou_simulation_parameters, contensou_simulation_parameter
   public :: contensou_simulation_get, contensou_simulation_set, contensou_simulation_set_text
   public :: contensou_simulation_bodies, contensou_simulation_contacts
   public :: contensou_simulation_body_name, contensou_simulation_contact_name
   public :: contensou_simulation_size, contensou_simulation_state
   public :: contensou_simulation_set_state, contensou_simulation_body
   public :: contensou_simulation_derivative, contensou_simulation_jacobian
   public :: contensou_simulation_indicators, contensou_simulation_set_load
   public :: contensou_simulation_set_drive, contensou_simulation_quantities
   public :: contensou_simulation_quantity, contensou_simulation_values
   public :: contensou_simulation_load, contensou_simulation_motion
   public :: contensou_simulation_put_host, contensou_simulation_complete_host_step
   public :: contensou_simulation_update_host
   public :: contensou_simulation_save, contensou_simulation_restore, contensou_simulation_copy
   public :: contensou_snapshot_bytes, contensou_snapshot_new, contensou_snapshot_free

   !> The oldest and the newest interface that the library knows.
   integer(c_int), parameter :: oldest_interface = 1, newest_interface = 2

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

      !> Hear of an event; another value than 0 asks to stop.
      function hear_from_c(time, kind, contact, user_data) result(stop_now) bind(c)
         import :: c_double, c_int, c_ptr
         implicit none(type, external)
         !> Time [s].
         real(c_double), intent(in), value :: time
         !> `event_touch` or `event_lift`.
         integer(c_int), intent(in), value :: kind
         !> From 0.
         integer(c_int), intent(in), value :: contact
         !> What the caller of the simulation gave.
         type(c_ptr), intent(in), value :: user_data
         integer(c_int) :: stop_now
      end function hear_from_c
   end interface

   !> Who hands rows and events to C functions.
   type, extends(listener_type) :: caller_type
      procedure(look_from_c), pointer, nopass :: look => null()
      type(c_ptr) :: look_data = c_null_ptr
      procedure(hear_from_c), pointer, nopass :: hear => null()
      type(c_ptr) :: hear_data = c_null_ptr
   contains
      procedure :: hear_row
      procedure :: hear_event
   end type caller_type

   !> Texts of a quantity.
   type :: quantity_texts_type
      type(c_text_type) :: name, units, description, dims(2)
      !> Its position among the quantities of a row.
      integer :: row = 0
   end type quantity_texts_type

   !> Texts of a parameter.
   type :: parameter_texts_type
      type(c_text_type) :: name, unit, description
   end type parameter_texts_type

   !> What a handle of a simulation stands for.
   type :: handle_type
      !> Its scene.
      type(loaded_scene_type), allocatable :: loaded
      !> Name of the file or text, and the text if there is no file.
      character(len=:), allocatable :: name, text
      !> Settings so far.
      type(string_type), allocatable :: settings(:)
      type(course_type) :: course
      type(caller_type) :: caller
      type(c_text_type) :: resolved, warnings
      type(c_text_type), allocatable :: bodies(:), contacts(:)
      type(quantity_texts_type), allocatable :: quantities(:)
      !> Not allocated before they are asked for.
      type(parameter_type), allocatable :: parameters(:)
      type(parameter_texts_type), allocatable :: parameter_texts(:)
   end type handle_type

   !> A snapshot.
   type :: snapshot_type
      type(c_text_type) :: bytes
      character(len=:), allocatable :: text
   end type snapshot_type

   !> A parameter as C sees it.
   type, bind(c) :: c_parameter_type
      type(c_ptr) :: name
      type(c_ptr) :: unit
      type(c_ptr) :: description
      real(c_double) :: value
      real(c_double) :: low
      real(c_double) :: high
      logical(c_bool) :: above_low
      logical(c_bool) :: is_integer
      logical(c_bool) :: is_given
   end type c_parameter_type

   !> A quantity as C sees it.
   type, bind(c) :: c_quantity_type
      type(c_ptr) :: name
      type(c_ptr) :: units
      type(c_ptr) :: description
      integer(c_int) :: size
      integer(c_int) :: rank
      integer(c_int) :: shape(2)
      type(c_ptr) :: dims(2)
   end type c_quantity_type

   character(len=*), parameter :: no_simulation = "there is no simulation"

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
         handle = c_loc(self)
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

   !> Read the scene of a handle and put its simulation at the beginning; after a mistake all is as
   !> it was.
   logical function load(self, settings, error_out) result(loaded_well)
      type(handle_type), intent(inout), target :: self
      !> All settings.
      type(string_type), intent(in) :: settings(:)
      !> Where to put an error; null if it is not wanted.
      type(c_ptr), intent(in), value :: error_out
      type(loaded_scene_type), allocatable :: loaded
      type(string_type), allocatable :: kept(:)
      type(diagnostics_type) :: diagnostics
      type(error_type), allocatable :: error

      loaded_well = .false.
      allocate(loaded)
      call load_scene(self%name, settings, loaded, diagnostics, error, self%text)
      if (.not. allocated(error) .and. diagnostics%count() > 0) then
         call fatal(error, mistakes_text(diagnostics, loaded%document, self%name), status_usage)
         call hand_over(error, error_out, diagnostics, loaded%document%sources)
         return
      end if
      if (.not. allocated(error)) call self%course%begin(loaded%file, error)
      if (allocated(error)) then
         call hand_over(error, error_out)
         if (allocated(self%loaded)) call self%course%begin(self%loaded%file, error)
         return
      end if
      kept = settings
      call move_alloc(kept, self%settings)
      call move_alloc(loaded, self%loaded)
      self%course%guide%listener => self%caller
      if (allocated(self%parameters)) deallocate(self%parameters, self%parameter_texts)
      call describe(self)
      call hand_over(error, error_out)
      loaded_well = .true.
   end function load

   !> Texts of a simulation for C.
   subroutine describe(self)
      type(handle_type), intent(inout) :: self
      integer :: i, n

      call self%resolved%set(self%loaded%file%resolved)
      call self%warnings%set(self%loaded%file%warnings)
      if (allocated(self%bodies)) deallocate(self%bodies, self%contacts, self%quantities)
      associate (scene => self%course%simulation%scene, row => self%course%guide%row)
         allocate(self%bodies(size(scene%bodies)), self%contacts(size(scene%contacts)), &
            self%quantities(count(row%has)))
         do i = 1, size(scene%bodies)
            call self%bodies(i)%set(scene%bodies(i)%name)
         end do
         do i = 1, size(scene%contacts)
            call self%contacts(i)%set(scene%contacts(i)%name)
         end do
         n = 0
         do i = 1, size(row%has)
            if (.not. row%has(i)) cycle
            n = n + 1
            call describe_quantity(row%quantities(i), self%quantities(n))
            self%quantities(n)%row = i
         end do
      end associate
   end subroutine describe

   !> Texts of a quantity.
   subroutine describe_quantity(quantity, texts)
      type(quantity_type), intent(in) :: quantity
      type(quantity_texts_type), intent(inout) :: texts
      integer :: blank

      call texts%name%set(trim(quantity%name))
      call texts%units%set(trim(quantity%units))
      call texts%description%set(trim(quantity%long_name))
      blank = index(trim(quantity%dims), " ")
      if (blank == 0) blank = len_trim(quantity%dims) + 1
      call texts%dims(1)%set(quantity%dims(:blank - 1))
      call texts%dims(2)%set(trim(adjustl(quantity%dims(blank:))))
   end subroutine describe_quantity

   !> Release a simulation; null is admitted.
   subroutine contensou_simulation_free(handle) bind(c)
      type(c_ptr), intent(in), value :: handle
      type(handle_type), pointer :: self

      if (.not. c_associated(handle)) return
      call c_f_pointer(handle, self)
      ! A simulation under way cannot vanish below itself.
      if (self%course%busy) return
      call self%course%release()
      deallocate(self)
   end subroutine contensou_simulation_free

   !> The simulation of a handle that may be changed; an error if there is none, or it is running.
   subroutine take(handle, self, error)
      type(c_ptr), intent(in), value :: handle
      type(handle_type), pointer, intent(out) :: self
      type(error_type), allocatable, intent(out) :: error

      nullify(self)
      if (.not. c_associated(handle)) then
         call fatal(error, no_simulation, status_usage)
         return
      end if
      call c_f_pointer(handle, self)
      if (self%course%busy) call fatal(error, "an observer cannot change the simulation that it " &
         // "looks at", status_usage)
   end subroutine take

   !> Hand over an error, and its status.
   integer(c_int) function status_of(error, error_out) result(status)
      type(error_type), allocatable, intent(in) :: error
      !> Where to put it; null if it is not wanted.
      type(c_ptr), intent(in), value :: error_out

      status = ok
      if (allocated(error)) status = int(error%status, c_int)
      call hand_over(error, error_out)
   end function status_of

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
      if (.not. c_associated(handle)) return
      call c_f_pointer(handle, self)
      text = self%resolved%address()
   end function contensou_simulation_settings

   !> What is legal in the scene and hardly meant.
   function contensou_simulation_warnings(handle) result(text) bind(c)
      type(c_ptr), intent(in), value :: handle
      type(c_ptr) :: text
      type(handle_type), pointer :: self
      type(c_text_type) :: nothing

      text = nothing%address()
      if (.not. c_associated(handle)) return
      call c_f_pointer(handle, self)
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
      if (.not. c_associated(handle)) return
      call c_f_pointer(handle, self)
      time = self%course%guide%t
   end function contensou_simulation_time

   !> The end of the scene [s]; 0 without a simulation.
   function contensou_simulation_end(handle) result(time) bind(c)
      type(c_ptr), intent(in), value :: handle
      real(c_double) :: time
      type(handle_type), pointer :: self

      time = 0.0_c_double
      if (.not. c_associated(handle)) return
      call c_f_pointer(handle, self)
      time = self%course%simulation%plan%t_end
   end function contensou_simulation_end

   !> Number of the condition that has ended it; 0 for none.
   function contensou_simulation_stop(handle) result(number) bind(c)
      type(c_ptr), intent(in), value :: handle
      integer(c_int) :: number
      type(handle_type), pointer :: self

      number = 0
      if (.not. c_associated(handle)) return
      call c_f_pointer(handle, self)
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
      if (.not. c_associated(handle) .or. .not. ieee_is_finite(time)) return
      call c_f_pointer(handle, self)
      associate (next => self%course%simulation%motion%system%next_corner(time))
         if (next < huge(next)) corner = next
      end associate
   end function contensou_simulation_next_corner

   !> List the parameters unless they are.
   subroutine list(self)
      type(handle_type), intent(inout), target :: self
      integer :: i

      if (allocated(self%parameters)) return
      call lock_texts()
      call list_parameters(self%loaded, self%parameters)
      allocate(self%parameter_texts(size(self%parameters)))
      do i = 1, size(self%parameters)
         associate (texts => self%parameter_texts(i), parameter => self%parameters(i))
            call texts%name%set(parameter%name)
            call texts%unit%set(trim(parameter%key%unit))
            call texts%description%set(trim(parameter%key%doc))
         end associate
      end do
      call unlock_texts()
   end subroutine list

   !> Number of parameters.
   function contensou_simulation_parameters(handle) result(n) bind(c)
      type(c_ptr), intent(in), value :: handle
      integer(c_int) :: n
      type(handle_type), pointer :: self

      n = 0
      if (.not. c_associated(handle)) return
      call c_f_pointer(handle, self)
      call list(self)
      n = size(self%parameters)
   end function contensou_simulation_parameters

   !> A parameter.
   function contensou_simulation_parameter(handle, i, parameter) result(status) bind(c)
      type(c_ptr), intent(in), value :: handle
      !> Its number, from 0.
      integer(c_int), intent(in), value :: i
      !> Where to put it.
      type(c_ptr), intent(in), value :: parameter
      integer(c_int) :: status
      type(handle_type), pointer :: self
      type(c_parameter_type), pointer :: out

      status = bad_argument
      if (.not. c_associated(handle) .or. .not. c_associated(parameter)) return
      call c_f_pointer(handle, self)
      call list(self)
      if (i < 0 .or. i >= size(self%parameters)) return
      call c_f_pointer(parameter, out)
      associate (texts => self%parameter_texts(i + 1), own => self%parameters(i + 1))
         out%name = texts%name%address()
         out%unit = texts%unit%address()
         out%description = texts%description%address()
         out%value = own%value
         out%low = own%key%low
         out%high = own%key%high
         out%above_low = own%key%above_low
         out%is_integer = own%key%kind == kind_integer
         out%is_given = own%given
      end associate
      status = ok
   end function contensou_simulation_parameter

   !> Number of a parameter by its name; 0 if there is none.
   integer function find_parameter(self, name) result(i)
      type(handle_type), intent(inout), target :: self
      character(len=*), intent(in) :: name

      call list(self)
      do i = 1, size(self%parameters)
         if (self%parameters(i)%name == lower(trim(adjustl(name)))) return
      end do
      i = 0
   end function find_parameter

   !> Say that there is no parameter of a name, and which one may be meant.
   subroutine report_parameter(self, name, error)
      type(handle_type), intent(in) :: self
      character(len=*), intent(in) :: name
      type(error_type), allocatable, intent(out) :: error
      type(string_type) :: names(size(self%parameters))
      integer :: i, near

      do i = 1, size(names)
         names(i)%s = self%parameters(i)%name
      end do
      near = nearest(lower(name), names)
      if (near > 0) then
         call fatal(error, "there is no parameter " // quote(name) // ", is " // &
            quote(names(near)%s) // " meant?", status_usage)
      else
         call fatal(error, "there is no parameter " // quote(name), status_usage)
      end if
   end subroutine report_parameter

   !> Value of a parameter.
   function contensou_simulation_get(handle, name, value, error_out) result(status) bind(c)
      type(c_ptr), intent(in), value :: handle
      !> Its name.
      type(c_ptr), intent(in), value :: name
      !> Where to put it.
      type(c_ptr), intent(in), value :: value
      !> Where to put an error; null if it is not wanted.
      type(c_ptr), intent(in), value :: error_out
      integer(c_int) :: status
      type(handle_type), pointer :: self
      real(c_double), pointer :: out
      type(error_type), allocatable :: error
      character(len=:), allocatable :: text
      integer :: i

      call lock_texts()
      if (.not. c_associated(handle)) then
         call fatal(error, no_simulation, status_usage)
      else if (.not. c_associated(value)) then
         call fatal(error, "there is nowhere to put the value", status_usage)
      else
         call c_f_pointer(handle, self)
         call c_f_pointer(value, out)
         call get_text(name, text)
         i = find_parameter(self, text)
         if (i > 0) then
            out = self%parameters(i)%value
         else
            call report_parameter(self, text, error)
         end if
      end if
      status = status_of(error, error_out)
      call unlock_texts()
   end function contensou_simulation_get

   !> Set parameters.
   function contensou_simulation_set(handle, names, values, n, error_out) result(status) bind(c)
      type(c_ptr), intent(in), value :: handle
      !> `n` names.
      type(c_ptr), intent(in), value :: names
      !> Their values.
      type(c_ptr), intent(in), value :: values
      integer(c_int), intent(in), value :: n
      !> Where to put an error; null if it is not wanted.
      type(c_ptr), intent(in), value :: error_out
      integer(c_int) :: status
      type(handle_type), pointer :: self
      type(error_type), allocatable :: error
      type(string_type), allocatable :: list(:)
      real(c_double), pointer :: x(:)
      integer :: i

      call lock_texts()
      call take_to_set(handle, n, c_associated(names) .and. c_associated(values), self, error)
      if (.not. allocated(error) .and. n > 0) then
         call get_texts(names, n, list)
         call c_f_pointer(values, x, [n])
         do i = 1, n
            if (find_parameter(self, list(i)%s) == 0) then
               call report_parameter(self, list(i)%s, error)
            else if (.not. ieee_is_finite(x(i))) then
               call fatal(error, quote(list(i)%s) // " is infinite or not a number", status_usage)
            end if
            if (allocated(error)) exit
            list(i)%s = list(i)%s // " = " // to_text(x(i))
         end do
      end if
      if (allocated(error) .or. n <= 0) then
         status = status_of(error, error_out)
      else
         status = merge(ok, int(status_usage, c_int), change(self, list, error_out))
      end if
      call unlock_texts()
   end function contensou_simulation_set

   !> Set settings of any kind.
   function contensou_simulation_set_text(handle, settings, n, error_out) result(status) bind(c)
      type(c_ptr), intent(in), value :: handle
      !> `n` texts as after `--set`.
      type(c_ptr), intent(in), value :: settings
      integer(c_int), intent(in), value :: n
      !> Where to put an error; null if it is not wanted.
      type(c_ptr), intent(in), value :: error_out
      integer(c_int) :: status
      type(handle_type), pointer :: self
      type(error_type), allocatable :: error
      type(string_type), allocatable :: list(:)

      call lock_texts()
      call take_to_set(handle, n, c_associated(settings), self, error)
      if (allocated(error) .or. n <= 0) then
         status = status_of(error, error_out)
      else
         call get_texts(settings, n, list)
         status = merge(ok, int(status_usage, c_int), change(self, list, error_out))
      end if
      call unlock_texts()
   end function contensou_simulation_set_text

   !> Take a simulation whose settings can be changed.
   subroutine take_to_set(handle, n, given, self, error)
      type(c_ptr), intent(in), value :: handle
      !> Number of settings.
      integer(c_int), intent(in) :: n
      !> Whether they are there.
      logical, intent(in) :: given
      type(handle_type), pointer, intent(out) :: self
      type(error_type), allocatable, intent(out) :: error

      call take(handle, self, error)
      if (allocated(error)) return
      if (n < 0 .or. (n > 0 .and. .not. given)) then
         call fatal(error, "the settings are not there", status_usage)
      else if (self%course%begun) then
         call fatal(error, "parameters can be set before a simulation has begun, or after a " // &
            "reset", status_usage)
      end if
   end subroutine take_to_set

   !> Make the simulation of a handle anew with some settings more.
   logical function change(self, more, error_out)
      type(handle_type), intent(inout), target :: self
      type(string_type), intent(in) :: more(:)
      !> Where to put an error; null if it is not wanted.
      type(c_ptr), intent(in), value :: error_out
      type(string_type), allocatable :: all(:)
      logical :: stays(size(self%settings))
      integer :: i, j, n

      ! What is set again takes the place of what was set.
      do i = 1, size(stays)
         stays(i) = .true.
         do j = 1, size(more)
            if (path_of(more(j)%s) == path_of(self%settings(i)%s)) stays(i) = .false.
         end do
      end do
      allocate(all(count(stays) + size(more)))
      n = 0
      do i = 1, size(stays)
         if (.not. stays(i)) cycle
         n = n + 1
         all(n)%s = self%settings(i)%s
      end do
      do i = 1, size(more)
         all(n + i)%s = more(i)%s
      end do
      change = load(self, all, error_out)
   end function change

   !> What a setting sets.
   pure function path_of(setting) result(path)
      character(len=*), intent(in) :: setting
      character(len=:), allocatable :: path

      path = lower(trim(adjustl(setting(:max(index(setting, "=") - 1, 0)))))
   end function path_of

   !> Number of bodies.
   function contensou_simulation_bodies(handle) result(n) bind(c)
      type(c_ptr), intent(in), value :: handle
      integer(c_int) :: n
      type(handle_type), pointer :: self

      n = 0
      if (.not. c_associated(handle)) return
      call c_f_pointer(handle, self)
      n = size(self%bodies)
   end function contensou_simulation_bodies

   !> Number of contacts.
   function contensou_simulation_contacts(handle) result(n) bind(c)
      type(c_ptr), intent(in), value :: handle
      integer(c_int) :: n
      type(handle_type), pointer :: self

      n = 0
      if (.not. c_associated(handle)) return
      call c_f_pointer(handle, self)
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
      call c_f_pointer(handle, self)
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
      call c_f_pointer(handle, self)
      name = self%contacts(i + 1)%address()
   end function contensou_simulation_contact_name

   !> Size of the state; 0 without a simulation.
   function contensou_simulation_size(handle) result(n) bind(c)
      type(c_ptr), intent(in), value :: handle
      integer(c_int) :: n
      type(handle_type), pointer :: self

      n = 0
      if (.not. c_associated(handle)) return
      call c_f_pointer(handle, self)
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
      if (.not. c_associated(handle) .or. .not. c_associated(state)) return
      call c_f_pointer(handle, self)
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

   !> Numbers from C.
   subroutine view(place, n, x, error)
      type(c_ptr), intent(in), value :: place
      integer(c_int), intent(in) :: n
      real(c_double), pointer, intent(out) :: x(:)
      !> Set when there are none.
      type(error_type), allocatable, intent(out) :: error

      nullify(x)
      if (n <= 0 .or. .not. c_associated(place)) then
         call fatal(error, "the numbers are not there", status_usage)
      else
         call c_f_pointer(place, x, [n])
      end if
   end subroutine view

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
      if (.not. c_associated(handle)) return
      call c_f_pointer(handle, self)
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

   !> Index of a body by its name; 0 if there is none.
   integer function body_of(self, name) result(i)
      type(handle_type), intent(in) :: self
      type(c_ptr), intent(in), value :: name
      character(len=:), allocatable :: text

      call get_text(name, text)
      associate (bodies => self%course%simulation%scene%bodies)
         do i = 1, size(bodies)
            if (bodies(i)%name == text) return
         end do
      end associate
      i = 0
   end function body_of

   !> Copy numbers to a place, unless that is null.
   subroutine put(numbers, place)
      real(wp), intent(in) :: numbers(:)
      type(c_ptr), intent(in), value :: place
      real(c_double), pointer :: x(:)

      if (.not. c_associated(place)) return
      call c_f_pointer(place, x, [size(numbers)])
      x = numbers
   end subroutine put

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

   !> Take a simulation, a time and a state at which it is asked for something.
   subroutine take_at(handle, time, state, n, place, n_out, self, y, out, error)
      type(c_ptr), intent(in), value :: handle
      !> Time [s].
      real(wp), intent(in) :: time
      type(c_ptr), intent(in), value :: state
      !> Size of the state.
      integer(c_int), intent(in) :: n
      !> Where to put what is asked for.
      type(c_ptr), intent(in), value :: place
      !> How much of it `out` shows.
      integer, intent(in) :: n_out
      type(handle_type), pointer, intent(out) :: self
      real(c_double), pointer, intent(out) :: y(:)
      real(c_double), pointer, intent(out) :: out(:)
      type(error_type), allocatable, intent(out) :: error

      nullify(y, out)
      call take(handle, self, error)
      if (allocated(error)) return
      call view(state, n, y, error)
      if (allocated(error)) return
      call self%course%check_state(y, error)
      if (allocated(error)) return
      if (.not. ieee_is_finite(time)) then
         call fatal(error, "the time is infinite or not a number", status_usage)
      else if (.not. c_associated(place)) then
         call fatal(error, "there is nowhere to put the values", status_usage)
      else
         call c_f_pointer(place, out, [n_out])
      end if
   end subroutine take_at

   !> Let a load act on a body.
   function contensou_simulation_set_load(handle, body, force, torque, error_out) &
      result(status) bind(c)
      type(c_ptr), intent(in), value :: handle
      !> Name of the body.
      type(c_ptr), intent(in), value :: body
      !> Force (3) [N].
      type(c_ptr), intent(in), value :: force
      !> Torque (3) [N m].
      type(c_ptr), intent(in), value :: torque
      !> Where to put an error; null if it is not wanted.
      type(c_ptr), intent(in), value :: error_out
      integer(c_int) :: status
      type(handle_type), pointer :: self
      type(error_type), allocatable :: error
      real(c_double), pointer :: f(:), m(:)
      integer :: i

      call take_body(handle, body, force, torque, self, i, f, m, error)
      if (.not. allocated(error)) call self%course%set_load(i, f, m, error)
      status = status_of(error, error_out)
   end function contensou_simulation_set_load

   !> Force and torque applied to a body.
   function contensou_simulation_load(handle, body, force, torque) result(status) bind(c)
      type(c_ptr), intent(in), value :: handle
      !> Its number, from 0.
      integer(c_int), intent(in), value :: body
      !> Where to put the force (3) [N].
      type(c_ptr), intent(in), value :: force
      !> Where to put the torque (3) [N m].
      type(c_ptr), intent(in), value :: torque
      integer(c_int) :: status
      type(handle_type), pointer :: self

      status = bad_argument
      if (body < 0 .or. body >= contensou_simulation_bodies(handle)) return
      call c_f_pointer(handle, self)
      associate (spec => self%course%simulation%motion%system%bodies(body + 1))
         call put(spec%force, force)
         call put(spec%torque, torque)
      end associate
      status = ok
   end function contensou_simulation_load

   !> How a body moves: the number of the name of `motion` in a scene, from 0; -1 if there is none.
   function contensou_simulation_motion(handle, body) result(motion) bind(c)
      type(c_ptr), intent(in), value :: handle
      !> Its number, from 0.
      integer(c_int), intent(in), value :: body
      integer(c_int) :: motion
      type(handle_type), pointer :: self

      motion = -1
      if (body < 0 .or. body >= contensou_simulation_bodies(handle)) return
      call c_f_pointer(handle, self)
      motion = int(self%course%simulation%motion%system%bodies(body + 1)%motion - 1, c_int)
   end function contensou_simulation_motion

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

   !> Let the drive of a body accelerate it.
   function contensou_simulation_set_drive(handle, body, acceleration, angular_acceleration, &
      error_out) result(status) bind(c)
      type(c_ptr), intent(in), value :: handle
      !> Name of the body.
      type(c_ptr), intent(in), value :: body
      !> [m/s2].
      type(c_ptr), intent(in), value :: acceleration
      !> [rad/s2].
      type(c_ptr), intent(in), value :: angular_acceleration
      !> Where to put an error; null if it is not wanted.
      type(c_ptr), intent(in), value :: error_out
      integer(c_int) :: status
      type(handle_type), pointer :: self
      type(error_type), allocatable :: error
      real(c_double), pointer :: a(:), w(:)
      integer :: i

      call take_body(handle, body, acceleration, angular_acceleration, self, i, a, w, error)
      if (.not. allocated(error)) call self%course%set_drive(i, a, w, error)
      status = status_of(error, error_out)
   end function contensou_simulation_set_drive

   !> Take a simulation, one of its bodies and two vectors.
   subroutine take_body(handle, body, first, second, self, i, x, y, error)
      type(c_ptr), intent(in), value :: handle
      !> Name of the body.
      type(c_ptr), intent(in), value :: body
      type(c_ptr), intent(in), value :: first
      type(c_ptr), intent(in), value :: second
      type(handle_type), pointer, intent(out) :: self
      !> Its index.
      integer, intent(out) :: i
      real(c_double), pointer, intent(out) :: x(:)
      real(c_double), pointer, intent(out) :: y(:)
      type(error_type), allocatable, intent(out) :: error
      character(len=:), allocatable :: text

      i = 0
      nullify(x, y)
      call take(handle, self, error)
      if (allocated(error)) return
      call view(first, 3, x, error)
      if (.not. allocated(error)) call view(second, 3, y, error)
      if (allocated(error)) return
      i = body_of(self, body)
      if (i > 0) return
      call lock_texts()
      call get_text(body, text)
      call fatal(error, "there is no body " // quote(text), status_usage)
      call unlock_texts()
   end subroutine take_body

   !> Number of quantities.
   function contensou_simulation_quantities(handle) result(n) bind(c)
      type(c_ptr), intent(in), value :: handle
      integer(c_int) :: n
      type(handle_type), pointer :: self

      n = 0
      if (.not. c_associated(handle)) return
      call c_f_pointer(handle, self)
      n = size(self%quantities)
   end function contensou_simulation_quantities

   !> A quantity.
   function contensou_simulation_quantity(handle, i, quantity) result(status) bind(c)
      type(c_ptr), intent(in), value :: handle
      !> Its number, from 0.
      integer(c_int), intent(in), value :: i
      !> Where to put it.
      type(c_ptr), intent(in), value :: quantity
      integer(c_int) :: status
      type(handle_type), pointer :: self
      type(c_quantity_type), pointer :: out

      status = bad_argument
      if (i < 0 .or. i >= contensou_simulation_quantities(handle)) return
      if (.not. c_associated(quantity)) return
      call c_f_pointer(handle, self)
      call c_f_pointer(quantity, out)
      associate (texts => self%quantities(i + 1), row => self%course%guide%row)
         out%name = texts%name%address()
         out%units = texts%units%address()
         out%description = texts%description%address()
         out%dims = [texts%dims(1)%address(), texts%dims(2)%address()]
         associate (width => row%width(texts%row), components => row%components(texts%row))
            out%size = width
            out%shape = [width/components, components]
            out%rank = 2
            if (components == 1) out%rank = 1
            if (row%quantities(texts%row)%owner() == "") out%rank = 0
         end associate
      end associate
      status = ok
   end function contensou_simulation_quantity

   !> Values of a quantity at the present.
   function contensou_simulation_values(handle, name, values, n, error_out) result(status) bind(c)
      type(c_ptr), intent(in), value :: handle
      !> Its name.
      type(c_ptr), intent(in), value :: name
      !> Where to put them.
      type(c_ptr), intent(in), value :: values
      !> Their number.
      integer(c_int), intent(in), value :: n
      !> Where to put an error; null if it is not wanted.
      type(c_ptr), intent(in), value :: error_out
      integer(c_int) :: status
      type(handle_type), pointer :: self
      type(error_type), allocatable :: error
      character(len=:), allocatable :: text

      if (.not. c_associated(handle)) then
         call fatal(error, no_simulation, status_usage)
      else
         call c_f_pointer(handle, self)
         call get_text(name, text)
         call take_values(self, text, values, int(n), error)
      end if
      status = status_of(error, error_out)
   end function contensou_simulation_values

   !> Put the values of a quantity at a place.
   subroutine take_values(self, name, place, n, error)
      type(handle_type), intent(inout), target :: self
      !> Name of the quantity.
      character(len=*), intent(in) :: name
      type(c_ptr), intent(in), value :: place
      !> Their number as the caller has it.
      integer, intent(in) :: n
      type(error_type), allocatable, intent(out) :: error
      integer :: i

      associate (row => self%course%guide%row)
         do i = 1, size(row%quantities)
            if (row%has(i) .and. row%quantities(i)%name == name) exit
         end do
         if (i <= size(row%quantities)) then
            if (n == row%width(i) .and. c_associated(place)) then
               call self%course%take_values(error)
               if (.not. allocated(error)) call put( &
                  row%values(row%start(i) + 1:row%start(i) + row%width(i)), place)
               return
            end if
         end if
         call lock_texts()
         if (i > size(row%quantities)) then
            call fatal(error, "there is no quantity " // quote(name) // " in this scene", &
               status_usage)
         else if (n /= row%width(i)) then
            call fatal(error, quote(name) // " has " // to_text(row%width(i)) // &
               " values, not " // to_text(n), status_usage)
         else
            call fatal(error, "there is nowhere to put the values", status_usage)
         end if
         call unlock_texts()
      end associate
   end subroutine take_values

   !> Keep where a simulation has come to; null on failure.
   function contensou_simulation_save(handle, error_out) result(snapshot) bind(c)
      type(c_ptr), intent(in), value :: handle
      !> Where to put an error; null if it is not wanted.
      type(c_ptr), intent(in), value :: error_out
      type(c_ptr) :: snapshot
      type(handle_type), pointer :: self
      type(snapshot_type), pointer :: kept
      type(error_type), allocatable :: error
      type(checkpoint_type) :: checkpoint
      integer(c_int) :: status

      snapshot = c_null_ptr
      call lock_texts()
      call take(handle, self, error)
      if (.not. allocated(error)) then
         call checkpoint%begin()
         call self%course%exchange(checkpoint, error)
      end if
      if (.not. allocated(error)) then
         allocate(kept)
         call checkpoint%to_memory(kept%text)
         call kept%bytes%set(kept%text)
         snapshot = c_loc(kept)
      end if
      status = status_of(error, error_out)
      call unlock_texts()
   end function contensou_simulation_save

   !> Bring a simulation to where one has come to.
   function contensou_simulation_restore(handle, snapshot, error_out) result(status) bind(c)
      type(c_ptr), intent(in), value :: handle
      type(c_ptr), intent(in), value :: snapshot
      !> Where to put an error; null if it is not wanted.
      type(c_ptr), intent(in), value :: error_out
      integer(c_int) :: status
      type(handle_type), pointer :: self
      type(snapshot_type), pointer :: kept
      type(error_type), allocatable :: error

      call lock_texts()
      call take(handle, self, error)
      if (.not. allocated(error) .and. .not. c_associated(snapshot)) call fatal(error, &
         "there is no snapshot", status_usage)
      if (.not. allocated(error)) then
         call c_f_pointer(snapshot, kept)
         call bring(self, kept, error)
      end if
      status = status_of(error, error_out)
      call unlock_texts()
   end function contensou_simulation_restore

   !> Bring a simulation to a snapshot; to its beginning if that fails.
   subroutine bring(self, kept, error)
      type(handle_type), intent(inout), target :: self
      type(snapshot_type), intent(in) :: kept
      type(error_type), allocatable, intent(out) :: error
      type(error_type), allocatable :: ignored
      type(checkpoint_type) :: checkpoint

      call checkpoint%from_memory("the snapshot", kept%text, error)
      if (allocated(error)) return
      call self%course%begin(self%loaded%file, error)
      if (allocated(error)) return
      self%course%guide%listener => self%caller
      call self%course%exchange(checkpoint, error)
      if (allocated(error)) call self%course%begin(self%loaded%file, ignored)
   end subroutine bring

   !> A second simulation like the first; null on failure.
   function contensou_simulation_copy(handle, error_out) result(copy) bind(c)
      type(c_ptr), intent(in), value :: handle
      !> Where to put an error; null if it is not wanted.
      type(c_ptr), intent(in), value :: error_out
      type(c_ptr) :: copy
      type(handle_type), pointer :: self, second
      type(snapshot_type), pointer :: kept
      type(error_type), allocatable :: error
      type(c_ptr) :: snapshot
      integer(c_int) :: status

      copy = c_null_ptr
      snapshot = contensou_simulation_save(handle, error_out)
      if (.not. c_associated(snapshot)) return
      call lock_texts()
      call c_f_pointer(handle, self)
      call c_f_pointer(snapshot, kept)
      allocate(second)
      second%name = self%name
      if (allocated(self%text)) second%text = self%text
      allocate(second%loaded, source=self%loaded)
      second%settings = self%settings
      call second%course%begin(second%loaded%file, error)
      if (.not. allocated(error)) then
         call describe(second)
         call bring(second, kept, error)
      end if
      if (allocated(error)) then
         deallocate(second)
      else
         copy = c_loc(second)
      end if
      status = status_of(error, error_out)
      call unlock_texts()
      call contensou_snapshot_free(snapshot)
   end function contensou_simulation_copy

   !> A snapshot as bytes; null for none.
   function contensou_snapshot_bytes(snapshot, size) result(bytes) bind(c)
      type(c_ptr), intent(in), value :: snapshot
      !> Where to put their number; null if it is not wanted.
      type(c_ptr), intent(in), value :: size
      type(c_ptr) :: bytes
      type(snapshot_type), pointer :: kept
      integer(c_size_t), pointer :: n

      bytes = c_null_ptr
      if (.not. c_associated(snapshot)) return
      call c_f_pointer(snapshot, kept)
      bytes = kept%bytes%address()
      if (.not. c_associated(size)) return
      call c_f_pointer(size, n)
      n = len(kept%text)
   end function contensou_snapshot_bytes

   !> A snapshot of bytes; null if they are none.
   function contensou_snapshot_new(bytes, size, error_out) result(snapshot) bind(c)
      type(c_ptr), intent(in), value :: bytes
      !> Their number.
      integer(c_size_t), intent(in), value :: size
      !> Where to put an error; null if it is not wanted.
      type(c_ptr), intent(in), value :: error_out
      type(c_ptr) :: snapshot
      type(snapshot_type), pointer :: kept
      type(error_type), allocatable :: error
      type(checkpoint_type) :: checkpoint
      character(len=1, kind=c_char), pointer :: from(:)
      integer(c_int) :: status
      integer :: i

      snapshot = c_null_ptr
      call lock_texts()
      if (.not. c_associated(bytes) .or. size >= huge(i)) then
         call fatal(error, "there is no snapshot", status_usage)
      else
         allocate(kept)
         call c_f_pointer(bytes, from, [size])
         allocate(character(len=size) :: kept%text)
         do i = 1, int(size)
            kept%text(i:i) = from(i)
         end do
         call checkpoint%from_memory("the snapshot", kept%text, error)
         call kept%bytes%set(kept%text)
         if (allocated(error)) deallocate(kept)
         if (.not. allocated(error)) snapshot = c_loc(kept)
      end if
      status = status_of(error, error_out)
      call unlock_texts()
   end function contensou_snapshot_new

   !> Release a snapshot; null is admitted.
   subroutine contensou_snapshot_free(snapshot) bind(c)
      type(c_ptr), intent(in), value :: snapshot
      type(snapshot_type), pointer :: kept

      if (.not. c_associated(snapshot)) return
      call c_f_pointer(snapshot, kept)
      deallocate(kept)
   end subroutine contensou_snapshot_free

   !> A row is due.
   subroutine hear_row(self, t, y, stop_now)
      class(caller_type), intent(inout) :: self
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)
      logical, intent(out) :: stop_now

      stop_now = .false.
      if (associated(self%look)) stop_now = self%look(t, y, int(size(y), c_int), &
         self%look_data) /= 0
   end subroutine hear_row

   !> A contact touched or lifted off.
   subroutine hear_event(self, t, kind, contact, stop_now)
      class(caller_type), intent(inout) :: self
      real(wp), intent(in) :: t
      integer, intent(in) :: kind
      integer, intent(in) :: contact
      logical, intent(out) :: stop_now

      stop_now = .false.
      if (associated(self%hear)) stop_now = self%hear(t, int(kind, c_int), &
         int(contact - 1, c_int), self%hear_data) /= 0
   end subroutine hear_event

end module contensou_capi_simulation
