!> Table of the damping laws.
module contensou_contact_damping
   use contensou_base_kinds, only : wp
   use contensou_contact_catalogue, only : model_info_type
   use contensou_contact_damping_coefficient, only : hunt_crossley_law, tsuji_law, viscous_law
   use contensou_contact_damping_law, only : damping_model_type, damping_type
   use contensou_contact_parameters, only : parameters_type
   implicit none(type, external)
   private

   public :: damping_type, damping_model_type, damping_models

contains

   !> The laws, in the order in which they are listed.
   function damping_models() result(models)
      type(damping_model_type), allocatable :: models(:)

      models = [none(), &
         hunt_crossley_law(), &
         viscous_law(), &
         tsuji_law()]
   end function damping_models

   !> No damping.
   function none() result(model)
      type(damping_model_type) :: model

      model%info = model_info_type("none", "no damping: N = F_el", "", "")
      model%acts = .false.
      model%restitute => restitute
   end function none

   !> Restitution of a rigid contact without a damping law: elastic bodies give everything back.
   pure subroutine restitute(parameters, restitution, alpha)
      type(parameters_type), intent(in) :: parameters
      real(wp), intent(out) :: restitution
      real(wp), intent(out) :: alpha

      restitution = parameters%number("restitution", otherwise=1.0_wp)
      alpha = 0.0_wp
   end subroutine restitute

end module contensou_contact_damping
