!> Table of the laws of rolling resistance.
module contensou_contact_rolling
   use contensou_contact_catalogue, only : model_info_type
   use contensou_contact_rolling_law, only : rolling_model_type, rolling_type
   use contensou_contact_rolling_lever, only : constant, hysteresis
   implicit none(type, external)
   private

   public :: rolling_type, rolling_model_type, rolling_models

contains

   !> The laws, in the order in which they are listed.
   function rolling_models() result(models)
      type(rolling_model_type), allocatable :: models(:)

      models = [none(), &
         constant(), &
         hysteresis()]
   end function rolling_models

   !> No rolling resistance.
   function none() result(model)
      type(rolling_model_type) :: model

      model%info = model_info_type("none", "no rolling resistance", "", "")
      model%acts = .false.
   end function none

end module contensou_contact_rolling
