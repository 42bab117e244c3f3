!> C interface of the kernels; include/contensou.h documents it.
module contensou_capi_kernels
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite
   use, intrinsic :: iso_c_binding, only : c_bool, c_char, c_double, c_f_pointer, c_int, c_loc, &
      c_null_char, c_null_ptr, c_ptr, c_associated
   use contensou_base_build, only : program_version
   use contensou_contact_friction, only : friction_model_type, friction_models, friction_type
   use contensou_contact_friction_law, only : sliding_type
   use contensou_contact_hertz, only : hertz_contact, hertz_spot_type, in_hertz_domain
   use contensou_contact_parameters, only : parameters_type, surroundings_type
   use contensou_contact_spot, only : circular_shape, elliptic_shape, spot_shape_type
   implicit none(type, external)
   private

   public :: ok, bad_argument
   public :: contensou_version, contensou_hertz
   public :: contensou_friction_new, contensou_friction_wrench, contensou_friction_free

   !> Everything went well.
   integer(c_int), parameter :: ok = 0

   !> An argument is outside its domain.
   integer(c_int), parameter :: bad_argument = 1

   !> What a handle stands for.
   type :: friction_handle_type
      class(friction_type), allocatable :: law
   end type friction_handle_type

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

   !> Hertz contact.
   function contensou_hertz(curvature_a, curvature_b, modulus, approach, a, b, force, pressure) &
      result(status) bind(c)
      !> Half relative curvature A along the major axis [1/m], > 0.
      real(c_double), intent(in), value :: curvature_a
      !> Half relative curvature B along the minor axis [1/m], >= A.
      real(c_double), intent(in), value :: curvature_b
      !> Effective modulus E* [Pa], > 0.
      real(c_double), intent(in), value :: modulus
      !> Approach d [m], >= 0.
      real(c_double), intent(in), value :: approach
      !> Major semi-axis a [m].
      real(c_double), intent(out) :: a
      !> Minor semi-axis b [m].
      real(c_double), intent(out) :: b
      !> Normal force N [N].
      real(c_double), intent(out) :: force
      !> Largest pressure p0 [Pa].
      real(c_double), intent(out) :: pressure
      integer(c_int) :: status
      type(hertz_spot_type) :: spot

      a = 0.0_c_double
      b = 0.0_c_double
      force = 0.0_c_double
      pressure = 0.0_c_double
      status = bad_argument
      if (.not. in_hertz_domain(curvature_a, curvature_b, modulus, approach)) return
      call hertz_contact(curvature_a, curvature_b, modulus, approach, spot)
      a = spot%a
      b = spot%b
      force = spot%force
      pressure = spot%pressure
      status = ok
   end function contensou_hertz

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
      type(friction_handle_type), pointer :: friction
      type(parameters_type) :: parameters
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
      if (.not. models(i)%acts) return
      call parameters%set("friction_coefficient", coefficient)
      call parameters%set("regularization_velocity", delta)
      call parameters%set("drilling", logical(drilling))
      parameters = models(i)%completed(parameters)
      if (models(i)%misfit(parameters) /= "") return
      allocate(friction)
      call models(i)%create(parameters, surroundings_type(), friction%law)
      handle = c_loc(friction)
   end function contensou_friction_new

   !> Friction wrench of an elliptic spot.
   function contensou_friction_wrench(handle, load, a, b, vx, vy, spin, wrench) &
      result(status) bind(c)
      !> From `contensou_friction_new`.
      type(c_ptr), intent(in), value :: handle
      !> Normal force N [N], >= 0.
      real(c_double), intent(in), value :: load
      !> Major semi-axis a [m], along x, > 0.
      real(c_double), intent(in), value :: a
      !> Minor semi-axis b [m], > 0, <= a.
      real(c_double), intent(in), value :: b
      !> Sliding velocity along x [m/s].
      real(c_double), intent(in), value :: vx
      !> Sliding velocity along y [m/s].
      real(c_double), intent(in), value :: vy
      !> Spin about the normal [rad/s].
      real(c_double), intent(in), value :: spin
      !> Force along x and y [N], torque about the normal [N m].
      real(c_double), intent(out) :: wrench(3)
      integer(c_int) :: status
      type(friction_handle_type), pointer :: friction
      type(spot_shape_type) :: shape

      wrench = 0.0_c_double
      status = bad_argument
      if (.not. c_associated(handle)) return
      if (.not. (ieee_is_finite(load) .and. ieee_is_finite(a) .and. ieee_is_finite(b))) return
      if (load < 0.0_c_double .or. b <= 0.0_c_double .or. b > a) return
      shape = circular_shape
      if (b < a) shape = elliptic_shape(b/a)
      call c_f_pointer(handle, friction)
      call friction%law%wrench(shape, sliding_type(load, a, vx, vy, spin), wrench)
      status = ok
   end function contensou_friction_wrench

   !> Release a friction model; null is admitted.
   subroutine contensou_friction_free(handle) bind(c)
      !> From `contensou_friction_new`.
      type(c_ptr), intent(in), value :: handle
      type(friction_handle_type), pointer :: friction

      if (.not. c_associated(handle)) return
      call c_f_pointer(handle, friction)
      deallocate(friction)
   end subroutine contensou_friction_free

end module contensou_capi_kernels
