!> Table of the laws of creep.
module contensou_contact_creep
   use contensou_contact_creep_boundary_elements, only : boundary_elements
   use contensou_contact_creep_brush, only : brush
   use contensou_contact_creep_closed, only : linear, polach, strip
   use contensou_contact_creep_fastsim, only : fastsim
   use contensou_contact_creep_law, only : creep_model_type, creep_type
   use contensou_contact_creep_sliding, only : full_sliding
   use contensou_contact_creep_table, only : tabulated
   implicit none(type, external)
   private

   public :: creep_type, creep_model_type, creep_models, default_creep

   !> The law that is meant where none is named.
   character(len=*), parameter :: default_creep = "table"

contains

   !> The laws, in the order in which they are listed.
   function creep_models() result(models)
      type(creep_model_type), allocatable :: models(:)

      models = [full_sliding(), &
         linear(), &
         strip(), &
         polach(), &
         fastsim(), &
         brush(), &
         tabulated(), &
         boundary_elements()]
   end function creep_models

end module contensou_contact_creep
