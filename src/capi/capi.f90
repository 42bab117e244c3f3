!> C interface of the kernels; include/contensou.h documents it.
module contensou_capi_capi
   use, intrinsic :: iso_c_binding, only : c_bool, c_char, c_double, c_f_pointer, c_int, c_loc, &
      c_null_char, c_null_ptr, c_ptr, c_associated
   use contensou_base_build, only : program_version
   use contensou_base_kinds, only : pi
   use contensou_contact_friction, only : friction_model_type, friction_models, friction_type
   use contensou_contact_hertz, only : hertz_circle_stiffness
   use contensou_contact_spot, only : circular_shape
   implicit none(type, external)
   private

   public :: contensou_version, contensou_hertz_circle
   public :: contensou_friction_new, contensou_friction_wrench, contensou_friction_free

   !> Everything went well.
   integer(c_int), parameter :: ok = 0

   !> An argument is outside its domain.
   integer(c_int), parameter :: bad_argument = 1

   !> Version, kept for the C program.
   character(len=1, kind=c_char), target :: version_text(32)

contains

   !> Version of the library as text.
   function contensou_version() result(text) bind(c)
      type(c_ptr) :: text
      integer :: i

      version_text = c_null_char
      do i = 1, min(len(program_version), size(version_text) - 1)
         version_text(i) = program_version(i:i)
      end do
      text = c_loc(version_text)
   end function contensou_version

   !> Hertz contact on a circular spot.
   function contensou_hertz_circle(modulus, radius, approach, force, spot, pressure) &
      result(status) bind(c)
      !> Effective modulus E* [Pa], > 0.
      real(c_double), intent(in), value :: modulus
      !> Relative radius of curvature R [m], > 0.
      real(c_double), intent(in), value :: radius
      !> Approach d [m], >= 0.
      real(c_double), intent(in), value :: approach
      !> Normal force N [N].
      real(c_double), intent(out) :: force
      !> Radius a of the spot [m].
      real(c_double), intent(out) :: spot
      !> Largest pressure p0 [Pa].
      real(c_double), intent(out) :: pressure
      integer(c_int) :: status

      force = 0.0_c_double
      spot = 0.0_c_double
      pressure = 0.0_c_double
      status = bad_argument
      if (.not. (modulus > 0.0_c_double .and. radius > 0.0_c_double)) return
      if (.not. approach >= 0.0_c_double) return
      status = ok
      force = hertz_circle_stiffness(modulus, radius)*approach*sqrt(approach)
      spot = sqrt(radius*approach)
      if (spot > 0.0_c_double) pressure = 1.5_c_double*force/(pi*spot**2)
   end function contensou_hertz_circle

   !> A friction model with its parameters; null if there is no such model or an argument is
   !> outside its domain.
   function contensou_friction_new(model, coefficient, delta, drilling) result(handle) bind(c)
      !> Name of the model as in a scene, ended by a zero byte.
      character(len=1, kind=c_char), intent(in) :: model(*)
      !> Friction coefficient f [-], >= 0.
      real(c_double), intent(in), value :: coefficient
      !> Regularisation velocity [m/s], >= 0; > 0 for `coulomb`.
      real(c_double), intent(in), value :: delta
      !> Whether the drilling torque is part of the model.
      logical(c_bool), intent(in), value :: drilling
      type(c_ptr) :: handle
      type(friction_model_type), allocatable :: models(:)
      type(friction_type), pointer :: friction
      character(len=24) :: name
      integer :: i

      handle = c_null_ptr
      models = friction_models()
      name = ""
      do i = 1, len(name)
         if (model(i) == c_null_char) exit
         name(i:i) = model(i)
      end do
      i = findloc(models%info%name == name, .true., dim=1)
      if (i == 0) return
      if (.not. associated(models(i)%kernel)) return
      if (.not. (coefficient >= 0.0_c_double .and. delta >= 0.0_c_double)) return
      if (models(i)%needs_delta .and. .not. delta > 0.0_c_double) return
      allocate(friction)
      friction%kernel => models(i)%kernel
      friction%coefficient = coefficient
      friction%delta = delta
      friction%drilling = logical(drilling) .and. models(i)%has_torque
      handle = c_loc(friction)
   end function contensou_friction_new

   !> Friction wrench of a circular spot.
   function contensou_friction_wrench(handle, load, spot, vx, vy, spin, wrench) &
      result(status) bind(c)
      !> From `contensou_friction_new`.
      type(c_ptr), intent(in), value :: handle
      !> Normal force N [N], >= 0.
      real(c_double), intent(in), value :: load
      !> Radius a of the spot [m], >= 0.
      real(c_double), intent(in), value :: spot
      !> Sliding velocity along x [m/s].
      real(c_double), intent(in), value :: vx
      !> Sliding velocity along y [m/s].
      real(c_double), intent(in), value :: vy
      !> Spin about the normal [rad/s].
      real(c_double), intent(in), value :: spin
      !> Force along x and y [N], torque about the normal [N m].
      real(c_double), intent(out) :: wrench(3)
      integer(c_int) :: status
      type(friction_type), pointer :: friction

      wrench = 0.0_c_double
      status = bad_argument
      if (.not. c_associated(handle)) return
      if (.not. (load >= 0.0_c_double .and. spot >= 0.0_c_double)) return
      call c_f_pointer(handle, friction)
      call friction%wrench(load, circular_shape, spot, vx, vy, spin, wrench(1), wrench(2), &
         wrench(3))
      status = ok
   end function contensou_friction_wrench

   !> Release a friction model; null is admitted.
   subroutine contensou_friction_free(handle) bind(c)
      !> From `contensou_friction_new`.
      type(c_ptr), intent(in), value :: handle
      type(friction_type), pointer :: friction

      if (.not. c_associated(handle)) return
      call c_f_pointer(handle, friction)
      deallocate(friction)
   end subroutine contensou_friction_free

end module contensou_capi_capi
