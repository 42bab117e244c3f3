!> Table of the shapes of a spot across its plane: flat, or curved as the surfaces are on average.
module contensou_contact_curvature
   use contensou_base_schema, only : kind_real
   use contensou_base_kinds, only : wp
   use contensou_contact_catalogue, only : law_keys_type, model_info_type, model_type
   use contensou_contact_curved_spot, only : curved_spot_type
   use contensou_contact_friction_law, only : friction_type
   use contensou_contact_parameters, only : parameters_type
   use contensou_contact_wrench_curved, only : slender_only
   implicit none(type, external)
   private

   public :: curvature_model_type, curvature_models, spot_flat, spot_curved, spot_slender

   !> Models of the shape of a spot, in the order of `curvature_models`.
   integer, parameter :: spot_flat = 1, spot_curved = 2, spot_slender = 3

   !> A row of the table.
   type, extends(model_type) :: curvature_model_type
      !> Whether the error of friction has a bound.
      logical :: bounded = .true.
   contains
      procedure :: create
   end type curvature_model_type

contains

   !> The models, in the order in which they are listed.
   function curvature_models() result(models)
      type(curvature_model_type), allocatable :: models(:)

      models = [flat(), &
         curved(), &
         slender()]
   end function curvature_models

   !> A flat spot.
   function flat() result(model)
      type(curvature_model_type) :: model

      model%info = model_info_type("flat", "friction of a flat spot: v + w n x r slips", "", "")
      model%acts = .false.
   end function flat

   !> A curved spot.
   function curved() result(model)
      type(curvature_model_type) :: model

      model%info = model_info_type("curved", &
         "Heathcote slip: v + w n x r + (1/2)(r.L r) w_t x n slips, L = (L_B - L_A)/2", "", &
         "R. L. Heathcote, Proc. Inst. Automob. Eng. 15 (1920) 569")
      model%put_keys => put_curved_keys
   end function curved

   !> A curved spot that is slender.
   function slender() result(model)
      type(curvature_model_type) :: model

      model%info = model_info_type("slender", &
         "the same with the mean of r.L r along each chord: without a bound of the error", "", &
         "docs/curved_spot.md")
      model%bounded = .false.
   end function slender

   !> The keys of a curved spot.
   subroutine put_curved_keys(list)
      type(law_keys_type), intent(inout) :: list

      call list%put("spot_error", kind_real, "bound of the error of friction over f N", unit="1", &
         least=1.0e-13_wp, most=1.0e-3_wp, default="1.0e-10")
   end subroutine put_curved_keys

   !> A curved spot with the values of its keys.
   subroutine create(self, parameters, friction, spot)
      class(curvature_model_type), intent(in) :: self
      !> Values of its keys, complete.
      type(parameters_type), intent(in) :: parameters
      !> Friction of the contact.
      class(friction_type), intent(in) :: friction
      type(curved_spot_type), intent(out) :: spot

      spot%error = slender_only
      if (self%bounded) spot%error = parameters%number("spot_error")
      spot%coefficient = friction%coefficient
      spot%delta = friction%delta
   end subroutine create

end module contensou_contact_curvature
