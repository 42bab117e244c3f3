!> C interface of the kernels; include/contensou.h documents it.
module contensou_capi_kernels
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite
   use, intrinsic :: iso_c_binding, only : c_bool, c_char, c_double, c_f_pointer, c_int, c_loc, &
      c_null_char, c_null_ptr, c_ptr, c_associated
   use contensou_base_build, only : program_version
   use contensou_base_kinds, only : wp
   use contensou_base_text_lock, only : lock_texts, unlock_texts
   use contensou_capi_table, only : address_of, drop_handle, lives, new_handle, of_friction
   use contensou_capi_texts, only : get_text
   use contensou_contact_friction, only : friction_model_type, friction_models, friction_type
   use contensou_contact_friction_law, only : sliding_type
   use contensou_contact_hertz, only : hertz_contact, hertz_spot_type, in_hertz_domain
   use contensou_contact_parameters, only : parameters_type, surroundings_type
   use contensou_contact_spot, only : circular_shape, elliptic_shape, spot_shape_type
   implicit none(type, external)
   private

   public :: friction_handle_type, ok, bad_argument, put, law_of, rub, vary_rub
   public :: contensou_version, contensou_hertz
   public :: contensou_friction_new, contensou_friction_wrench, contensou_friction_jacobian
   public :: contensou_friction_free

   !> Everything went well.
   integer(c_int), parameter :: ok = 0

   !> An argument is outside its domain.
   integer(c_int), parameter :: bad_argument = 1

   !> What a handle stands for.
   type :: friction_handle_type
      class(friction_type), allocatable :: law
   end type friction_handle_type

   !> Ends with a null.
   character(len=len(program_version) + 1, kind=c_char), target :: version_text = &
      program_version // c_null_char

contains

   !> Version of the library as text.
   function contensou_version() result(text) bind(c)
      type(c_ptr) :: text

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
      !> Where to put the major semi-axis a [m]; null if it is not wanted, as all that follow.
      type(c_ptr), intent(in), value :: a
      !> Minor semi-axis b [m].
      type(c_ptr), intent(in), value :: b
      !> Normal force N [N].
      type(c_ptr), intent(in), value :: force
      !> Largest pressure p0 [Pa].
      type(c_ptr), intent(in), value :: pressure
      integer(c_int) :: status
      real(c_double) :: spot(4)

      call hertz(curvature_a, curvature_b, modulus, approach, spot, status)
      call put(spot(1:1), a)
      call put(spot(2:2), b)
      call put(spot(3:3), force)
      call put(spot(4:4), pressure)
   end function contensou_hertz

   !> Hertz contact; zeros outside of the domain.
   pure subroutine hertz(curvature_a, curvature_b, modulus, approach, spot, status)
      real(wp), intent(in) :: curvature_a, curvature_b, modulus, approach
      !> a, b, N, p0.
      real(wp), intent(out) :: spot(4)
      integer(c_int), intent(out) :: status
      type(hertz_spot_type) :: found

      spot = 0.0_wp
      status = bad_argument
      if (.not. in_hertz_domain(curvature_a, curvature_b, modulus, approach)) return
      call hertz_contact(curvature_a, curvature_b, modulus, approach, found)
      spot = [found%a, found%b, found%force, found%pressure]
      status = ok
   end subroutine hertz

   !> A friction model with its parameters; null if there is no such model or an argument is
   !> outside its domain.
   function contensou_friction_new(model, coefficient, delta, drilling) result(handle) bind(c)
      !> Name of the model as in a scene.
      type(c_ptr), intent(in), value :: model
      !> Friction coefficient f [-], >= 0.
      real(c_double), intent(in), value :: coefficient
      !> Regularisation velocity [m/s], >= 0; > 0 for `coulomb`.
      real(c_double), intent(in), value :: delta
      !> Whether the drilling torque is part of the model.
      logical(c_bool), intent(in), value :: drilling
      type(c_ptr) :: handle
      type(friction_handle_type), pointer :: friction
      character(len=:), allocatable :: name

      handle = c_null_ptr
      if (.not. (ieee_is_finite(coefficient) .and. ieee_is_finite(delta))) return
      call lock_texts()
      call get_text(model, name)
      allocate(friction)
      call create(name, coefficient, delta, logical(drilling), friction%law)
      if (allocated(friction%law)) then
         handle = new_handle(c_loc(friction), of_friction)
      else
         deallocate(friction)
      end if
      call unlock_texts()
   end function contensou_friction_new

   !> Make a law of friction by its name; not allocated if there is none or a number is out of its
   !> domain.
   subroutine create(name, coefficient, delta, drilling, law)
      character(len=*), intent(in) :: name
      !> Friction coefficient f [-].
      real(wp), intent(in) :: coefficient
      !> Regularisation velocity [m/s].
      real(wp), intent(in) :: delta
      !> Whether the drilling torque is part of the model.
      logical, intent(in) :: drilling
      class(friction_type), allocatable, intent(out) :: law
      type(friction_model_type), allocatable :: models(:)
      type(parameters_type) :: parameters
      integer :: i

      models = friction_models()
      i = findloc(models%info%name == name, .true., dim=1)
      if (i == 0) return
      if (.not. models(i)%acts) return
      call parameters%set("friction_coefficient", coefficient)
      call parameters%set("regularization_velocity", delta)
      call parameters%set("drilling", drilling)
      parameters = models(i)%completed(parameters)
      if (models(i)%misfit(parameters) /= "") return
      call models(i)%create(parameters, surroundings_type(), law)
   end subroutine create

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
      !> Where to put the force along x and y [N] and the torque about the normal [N m].
      type(c_ptr), intent(in), value :: wrench
      integer(c_int) :: status
      real(c_double) :: found(3)
      type(friction_handle_type), pointer :: friction

      friction => law_of(handle)
      found = 0.0_c_double
      status = bad_argument
      if (associated(friction)) call rub(friction, [load, a, b, vx, vy, spin], found, status)
      if (.not. c_associated(wrench)) status = bad_argument
      call put(found, wrench)
   end function contensou_friction_wrench

   !> Friction wrench of an elliptic spot, and its derivatives.
   function contensou_friction_jacobian(handle, load, a, b, vx, vy, spin, wrench, slopes) &
      result(status) bind(c)
      !> As of `contensou_friction_wrench`.
      type(c_ptr), intent(in), value :: handle
      real(c_double), intent(in), value :: load
      real(c_double), intent(in), value :: a
      real(c_double), intent(in), value :: b
      real(c_double), intent(in), value :: vx
      real(c_double), intent(in), value :: vy
      real(c_double), intent(in), value :: spin
      type(c_ptr), intent(in), value :: wrench
      !> For each component its derivatives by N, by a at constant b/a, by vx, vy and the spin.
      type(c_ptr), intent(in), value :: slopes
      integer(c_int) :: status
      real(c_double) :: found(3), by_column(3, 5)
      type(friction_handle_type), pointer :: friction

      friction => law_of(handle)
      found = 0.0_c_double
      by_column = 0.0_c_double
      status = bad_argument
      if (associated(friction)) call vary_rub(friction, [load, a, b, vx, vy, spin], found, &
         by_column, status)
      if (.not. (c_associated(wrench) .and. c_associated(slopes))) status = bad_argument
      call put(found, wrench)
      call put([transpose(by_column)], slopes)
   end function contensou_friction_jacobian

   !> Friction wrench; zero outside of the domain.
   subroutine rub(friction, x, wrench, status)
      type(friction_handle_type), intent(in) :: friction
      !> N, a, b, vx, vy, spin.
      real(wp), intent(in) :: x(6)
      real(wp), intent(out) :: wrench(3)
      integer(c_int), intent(out) :: status
      type(spot_shape_type) :: shape
      type(sliding_type) :: slides

      call take_spot(x, shape, slides, status)
      if (status == ok) then
         call friction%law%wrench(shape, slides, wrench)
      else
         wrench = 0.0_wp
      end if
   end subroutine rub

   !> Friction wrench and its derivatives; zero outside of the domain.
   subroutine vary_rub(friction, x, wrench, slopes, status)
      type(friction_handle_type), intent(in) :: friction
      !> N, a, b, vx, vy, spin.
      real(wp), intent(in) :: x(6)
      real(wp), intent(out) :: wrench(3)
      !> Derivative of component i by N, a at constant b/a, vx, vy, spin.
      real(wp), intent(out) :: slopes(3, 5)
      integer(c_int), intent(out) :: status
      type(spot_shape_type) :: shape
      type(sliding_type) :: slides

      wrench = 0.0_wp
      slopes = 0.0_wp
      call take_spot(x, shape, slides, status)
      if (status == ok) call friction%law%linearize(shape, slides, wrench, slopes)
   end subroutine vary_rub

   !> The friction model of a handle; null for none.
   function law_of(handle) result(friction)
      type(c_ptr), intent(in) :: handle
      type(friction_handle_type), pointer :: friction

      nullify(friction)
      if (lives(handle, of_friction)) call c_f_pointer(address_of(handle, of_friction), friction)
   end function law_of

   !> Take the spot on which a friction model acts.
   pure subroutine take_spot(x, shape, slides, status)
      !> N, a, b, vx, vy, spin.
      real(wp), intent(in) :: x(6)
      type(spot_shape_type), intent(out) :: shape
      type(sliding_type), intent(out) :: slides
      !> `bad_argument` if a number is out of its domain.
      integer(c_int), intent(out) :: status

      status = bad_argument
      if (.not. all(ieee_is_finite(x))) return
      if (x(1) < 0.0_wp .or. x(3) <= 0.0_wp .or. x(3) > x(2)) return
      if (x(3) < x(2)) then
         shape = elliptic_shape(x(3)/x(2))
         if (.not. ieee_is_finite(shape%k)) return
      else
         shape = circular_shape
      end if
      slides = sliding_type(x(1), x(2), x(4), x(5), x(6))
      status = ok
   end subroutine take_spot

   !> Copy numbers to a place, unless that is null.
   subroutine put(numbers, place)
      real(wp), intent(in) :: numbers(:)
      type(c_ptr), intent(in), value :: place
      real(c_double), pointer :: x(:)

      if (.not. c_associated(place)) return
      call c_f_pointer(place, x, [size(numbers)])
      x = numbers
   end subroutine put

   !> Release a friction model; null is admitted.
   subroutine contensou_friction_free(handle) bind(c)
      !> From `contensou_friction_new`.
      type(c_ptr), intent(in), value :: handle
      type(friction_handle_type), pointer :: friction

      if (.not. lives(handle, of_friction)) return
      call c_f_pointer(address_of(handle, of_friction), friction)
      call drop_handle(handle, of_friction)
      deallocate(friction)
   end subroutine contensou_friction_free

end module contensou_capi_kernels
