!> C interface of what acts on the bodies of a simulation; include/contensou.h documents it.
module contensou_capi_loads
   use, intrinsic :: iso_c_binding, only : c_double, c_f_pointer, c_int, c_ptr
   use contensou_base_errors, only : error_type, fatal, status_usage
   use contensou_base_text, only : quote
   use contensou_base_text_lock, only : lock_texts, unlock_texts
   use contensou_capi_handles, only : body_of, handle_type, status_of, take, view
   use contensou_capi_kernels, only : bad_argument, ok, put
   use contensou_capi_states, only : contensou_simulation_bodies
   use contensou_capi_table, only : address_of, of_simulation
   use contensou_capi_texts, only : get_text
   implicit none(type, external)
   private

   public :: contensou_simulation_set_load, contensou_simulation_load, contensou_simulation_motion
   public :: contensou_simulation_set_drive

contains

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
      call c_f_pointer(address_of(handle, of_simulation), self)
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
      call c_f_pointer(address_of(handle, of_simulation), self)
      motion = int(self%course%simulation%motion%system%bodies(body + 1)%motion - 1, c_int)
   end function contensou_simulation_motion

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

end module contensou_capi_loads
