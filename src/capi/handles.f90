!> What the handles of simulations stand for in the C interface, and how they are taken.
module contensou_capi_handles
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite
   use, intrinsic :: iso_c_binding, only : c_associated, c_double, c_f_pointer, c_int, &
      c_null_ptr, c_ptr
   use contensou_base_diagnostics, only : diagnostics_type
   use contensou_base_errors, only : error_type, fatal, status_usage
   use contensou_base_kinds, only : wp
   use contensou_base_text, only : string_type
   use contensou_capi_errors, only : hand_over
   use contensou_capi_kernels, only : ok
   use contensou_capi_table, only : address_of, lives, of_simulation
   use contensou_capi_texts, only : c_text_type, get_text
   use contensou_scene_parameters, only : parameter_type
   use contensou_scene_reader, only : load_scene, loaded_scene_type, mistakes_text
   use contensou_study_course, only : course_type, listener_type
   use contensou_study_quantity, only : quantity_type
   implicit none(type, external)
   private

   public :: handle_type, look_from_c, no_simulation, take, status_of, take_at, view, body_of
   public :: describe, load

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

   !> What callers are told of a quantity.
   type :: quantity_texts_type
      type(c_text_type) :: name, units, description, dims(2)
      !> Its position among the quantities of a row.
      integer :: row = 0
   end type quantity_texts_type

   !> What callers are told of a parameter.
   type :: parameter_texts_type
      type(c_text_type) :: name, unit, description
   end type parameter_texts_type

   !> What a handle of a simulation stands for.
   type :: handle_type
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

   character(len=*), parameter :: no_simulation = "there is no simulation"

contains

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

   !> Fill in what callers are told of a quantity.
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

   !> The simulation of a handle that may be changed; an error if there is none, or it is running.
   subroutine take(handle, self, error)
      type(c_ptr), intent(in), value :: handle
      type(handle_type), pointer, intent(out) :: self
      type(error_type), allocatable, intent(out) :: error

      nullify(self)
      if (.not. lives(handle, of_simulation)) then
         call fatal(error, no_simulation, status_usage)
         return
      end if
      call c_f_pointer(address_of(handle, of_simulation), self)
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

end module contensou_capi_handles
