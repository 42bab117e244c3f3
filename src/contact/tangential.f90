!> Table of the models of tangential elasticity.
module contensou_contact_tangential
   use contensou_contact_catalogue, only : model_info_type
   use contensou_contact_tangential_law, only : elastic, rolling, spring, tangential_model_type
   implicit none(type, external)
   private

   public :: tangential_model_type, tangential_models

contains

   !> The models, in the order in which they are listed.
   function tangential_models() result(models)
      type(tangential_model_type), allocatable :: models(:)

      models = [none(), &
         spring(), &
         elastic(), &
         rolling()]
   end function tangential_models

   !> What sticks is rigid.
   function none() result(model)
      type(tangential_model_type) :: model

      model%info = model_info_type("none", &
         "no tangential elasticity: what does not slide is rigid", "", "")
      model%acts = .false.
   end function none

end module contensou_contact_tangential
