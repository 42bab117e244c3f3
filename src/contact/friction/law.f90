!> Friction part of a contact: what each law of friction must answer, and the keys that most share.
module contensou_contact_friction_law
   use contensou_base_kinds, only : wp
   use contensou_base_schema, only : kind_logical, kind_real
   use contensou_contact_catalogue, only : law_keys_type, model_type
   use contensou_contact_parameters, only : parameters_type, surroundings_type
   use contensou_contact_spot, only : spot_shape_type
   use contensou_contact_wrench, only : wrench_jacobian_kernel, wrench_kernel
   implicit none(type, external)
   private

   public :: friction_type, friction_model_type
   public :: put_friction_coefficient, put_regularization_velocity, put_drilling

   !> A law of friction with its parameters.
   type, abstract :: friction_type
      !> Friction coefficient f [-]; with `delta`, how steep friction is near rest is judged by.
      real(wp) :: coefficient = 0.0_wp
      !> Regularisation velocity delta [m/s].
      real(wp) :: delta = 0.0_wp
      !> Whether the drilling torque is part of the law.
      logical :: drilling = .true.
   contains
      !> Wrench in SI units.
      procedure(wrench_of), deferred :: wrench
      !> Wrench and its derivatives in SI units.
      procedure(linearize_wrench), deferred :: linearize
   end type friction_type

   !> A row in the table of the laws of friction.
   type, extends(model_type) :: friction_model_type
      !> Makes the law from the values of its keys; not associated for `none`.
      procedure(new_friction), pointer :: create => null()
      !> A rung of the ladder, without units; not associated for a law that is none.
      procedure(wrench_kernel), pointer, nopass :: kernel => null()
      !> The rung with its derivatives.
      procedure(wrench_jacobian_kernel), pointer, nopass :: jacobian => null()
   end type friction_model_type

   abstract interface
      !> Friction force and torque on the body that slips, in the axes of the spot.
      pure subroutine wrench_of(self, load, shape, a, vx, vy, w, resolution, fx, fy, torque)
         import :: friction_type, spot_shape_type, wp
         implicit none(type, external)
         class(friction_type), intent(in) :: self
         !> Normal force N [N], >= 0.
         real(wp), intent(in) :: load
         type(spot_shape_type), intent(in) :: shape
         !> Major semi-axis [m], >= 0.
         real(wp), intent(in) :: a
         !> Sliding velocity along the major axis [m/s].
         real(wp), intent(in) :: vx
         !> Sliding velocity along the minor axis [m/s].
         real(wp), intent(in) :: vy
         !> Spin about the normal [rad/s].
         real(wp), intent(in) :: w
         !> Square of the velocity below which sliding is not resolved [m2/s2], 0 if all is.
         real(wp), intent(in) :: resolution
         !> Force along the major axis [N].
         real(wp), intent(out) :: fx
         !> Force along the minor axis [N].
         real(wp), intent(out) :: fy
         !> Torque about the normal [N m].
         real(wp), intent(out) :: torque
      end subroutine wrench_of

      !> Friction wrench and its derivatives by normal force, size of the spot and velocities.
      pure subroutine linearize_wrench(self, load, shape, a, vx, vy, w, resolution, wrench, slopes)
         import :: friction_type, spot_shape_type, wp
         implicit none(type, external)
         class(friction_type), intent(in) :: self
         !> Normal force N [N], >= 0.
         real(wp), intent(in) :: load
         type(spot_shape_type), intent(in) :: shape
         !> Major semi-axis [m], >= 0.
         real(wp), intent(in) :: a
         !> Sliding velocity along the major axis [m/s].
         real(wp), intent(in) :: vx
         !> Sliding velocity along the minor axis [m/s].
         real(wp), intent(in) :: vy
         !> Spin about the normal [rad/s].
         real(wp), intent(in) :: w
         !> Square of the velocity below which sliding is not resolved [m2/s2], 0 if all is.
         real(wp), intent(in) :: resolution
         !> Force along the major and the minor axis [N], torque about the normal [N m].
         real(wp), intent(out) :: wrench(3)
         !> Derivative of component i by N, a, vx, vy, w.
         real(wp), intent(out) :: slopes(3, 5)
      end subroutine linearize_wrench

      !> Make a law of friction.
      subroutine new_friction(self, parameters, around, friction)
         import :: friction_model_type, friction_type, parameters_type, surroundings_type
         implicit none(type, external)
         class(friction_model_type), intent(in) :: self
         !> Values of its keys.
         type(parameters_type), intent(in) :: parameters
         !> What the contact is between.
         type(surroundings_type), intent(in) :: around
         class(friction_type), allocatable, intent(out) :: friction
      end subroutine new_friction
   end interface

contains

   !> The key friction_coefficient.
   subroutine put_friction_coefficient(list)
      type(law_keys_type), intent(inout) :: list

      call list%put("friction_coefficient", kind_real, "friction coefficient f", unit="1", &
         least=0.0_wp, mandatory=.true.)
   end subroutine put_friction_coefficient

   !> The key regularization_velocity.
   subroutine put_regularization_velocity(list, mandatory)
      type(law_keys_type), intent(inout) :: list
      !> Whether it must be given, and positive.
      logical, intent(in), optional :: mandatory
      character(len=*), parameter :: name = "regularization_velocity", unit = "m s-1"
      character(len=*), parameter :: doc = "velocity delta below which friction falls to zero " // &
         "with the slip velocity; with 0 the wrench of v = w = 0 is zero, and a run smooths " // &
         "its jump there over a velocity that its tolerance does not resolve"

      if (present(mandatory)) then
         if (mandatory) then
            call list%put(name, kind_real, doc, unit=unit, above=0.0_wp, mandatory=.true., &
               example="1.0e-3")
            return
         end if
      end if
      call list%put(name, kind_real, doc, unit=unit, least=0.0_wp, default="0.0")
   end subroutine put_regularization_velocity

   !> The key drilling.
   subroutine put_drilling(list, idle)
      type(law_keys_type), intent(inout) :: list
      !> Whether the law has no such torque, and admits the key all the same.
      logical, intent(in), optional :: idle

      call list%put("drilling", kind_logical, "whether the drilling torque about the normal acts", &
         default=".true.", idle=idle)
   end subroutine put_drilling

end module contensou_contact_friction_law
