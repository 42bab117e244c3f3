!> Table of the laws of friction.
module contensou_contact_friction
   use contensou_contact_catalogue, only : model_info_type
   use contensou_contact_friction_ladder, only : contensou_exact, contensou_simplified, coulomb, &
      pade11, pade22
   use contensou_contact_friction_law, only : friction_model_type, friction_type
   implicit none(type, external)
   private

   public :: friction_type, friction_model_type, friction_models

contains

   !> The laws, in the order in which they are listed.
   function friction_models() result(models)
      type(friction_model_type), allocatable :: models(:)

      models = [none(), &
         coulomb(), &
         contensou_simplified(), &
         pade11(), &
         pade22(), &
         contensou_exact()]
   end function friction_models

   !> No friction.
   function none() result(model)
      type(friction_model_type) :: model

      model%info = model_info_type("none", "no friction", "", "")
      model%acts = .false.
   end function none

end module contensou_contact_friction
