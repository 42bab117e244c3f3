!> C interface of the parameters of a simulation; include/contensou.h documents it.
module contensou_capi_parameters
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite
   use, intrinsic :: iso_c_binding, only : c_associated, c_bool, c_double, c_f_pointer, c_int, &
      c_ptr
   use contensou_base_errors, only : error_type, fatal, status_usage
   use contensou_base_numbers, only : to_text
   use contensou_base_schema, only : kind_integer
   use contensou_base_text, only : lower, nearest, quote, string_type
   use contensou_base_text_lock, only : lock_texts, unlock_texts
   use contensou_capi_handles, only : handle_type, load, no_simulation, status_of, take
   use contensou_capi_kernels, only : bad_argument, ok
   use contensou_capi_table, only : address_of, lives, of_simulation
   use contensou_capi_texts, only : get_text, get_texts
   use contensou_scene_parameters, only : list_parameters
   implicit none(type, external)
   private

   public :: contensou_simulation_parameters, contensou_simulation_parameter
   public :: contensou_simulation_get, contensou_simulation_set, contensou_simulation_set_text

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

contains

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
      if (.not. lives(handle, of_simulation)) return
      call c_f_pointer(address_of(handle, of_simulation), self)
      call list(self)
      n = size(self%parameters)
   end function contensou_simulation_parameters

   !> Name, unit, domain and value of a parameter.
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
      if (.not. lives(handle, of_simulation) .or. .not. c_associated(parameter)) return
      call c_f_pointer(address_of(handle, of_simulation), self)
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
      if (.not. lives(handle, of_simulation)) then
         call fatal(error, no_simulation, status_usage)
      else if (.not. c_associated(value)) then
         call fatal(error, "there is nowhere to put the value", status_usage)
      else
         call c_f_pointer(address_of(handle, of_simulation), self)
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

end module contensou_capi_parameters
