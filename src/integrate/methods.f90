!> Methods of integration: their names and their integrators.
module contensou_integrate_methods
   use contensou_integrate_cvode, only : cvode_type
   use contensou_integrate_explicit8, only : explicit8_type
   use contensou_integrate_integrator, only : integrator_type
   implicit none(type, external)
   private

   public :: integrator_methods, jacobian_kinds, new_integrator

   !> Methods of integration, as named in a scene.
   character(len=*), parameter :: integrator_methods(*) = [character(len=11) :: &
      "cvode_bdf", "cvode_adams", "explicit8", "auto"]

   !> Jacobians of implicit methods, as named in a scene.
   character(len=*), parameter :: jacobian_kinds(*) = [character(len=11) :: "analytic", &
      "differences"]

contains

   !> An integration by a method.
   subroutine new_integrator(method, integrator)
      !> One of `integrator_methods`.
      character(len=*), intent(in) :: method
      !> The integration, to be started.
      class(integrator_type), allocatable, intent(out) :: integrator

      if (method == "explicit8") then
         allocate(explicit8_type :: integrator)
      else
         allocate(cvode_type :: integrator)
      end if
   end subroutine new_integrator

end module contensou_integrate_methods
