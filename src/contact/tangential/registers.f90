!> Slip of shells side by side, by the registers of the machine on which the program runs.
module contensou_contact_tangential_registers
   use, intrinsic :: iso_c_binding, only : c_int
   use contensou_contact_tangential_abreast, only : lay_out, slide_shells, slip_in_plane, &
      slip_on_circles, slip_on_ellipses, take_back
   use contensou_contact_tangential_abreast_wide, only : wide_lay_out => lay_out, &
      wide_slide_shells => slide_shells, &
      wide_slip_in_plane => slip_in_plane, wide_slip_on_circles => slip_on_circles, &
      wide_slip_on_ellipses => slip_on_ellipses, wide_take_back => take_back
   use contensou_contact_tangential_abreast_widest, only : widest_lay_out => lay_out, &
      widest_slide_shells => slide_shells, &
      widest_slip_in_plane => slip_in_plane, widest_slip_on_ellipses => slip_on_ellipses, &
      widest_take_back => take_back
   use contensou_contact_tangential_trial, only : recall, stiffen, try_elastic
   use contensou_contact_tangential_trial_wide, only : wide_recall => recall, &
      wide_stiffen => stiffen, wide_try_elastic => try_elastic
   use contensou_contact_tangential_trial_widest, only : widest_recall => recall, &
      widest_stiffen => stiffen, widest_try_elastic => try_elastic
   implicit none(type, external)
   private

   public :: side_by_side, kernels_type, numbers_of_register

   !> Procedures of `contensou_contact_tangential_trial` and `contensou_contact_tangential_abreast`,
   !> for one of the registers.
   type :: kernels_type
      procedure(recall), pointer, nopass :: recall => null()
      procedure(stiffen), pointer, nopass :: stiffen => null()
      procedure(try_elastic), pointer, nopass :: try_elastic => null()
      procedure(slip_in_plane), pointer, nopass :: slip_in_plane => null()
      procedure(slip_on_circles), pointer, nopass :: slip_on_circles => null()
      procedure(lay_out), pointer, nopass :: lay_out => null()
      procedure(slip_on_ellipses), pointer, nopass :: slip_on_ellipses => null()
      procedure(slide_shells), pointer, nopass :: slide_shells => null()
      procedure(take_back), pointer, nopass :: take_back => null()
   end type kernels_type

   interface
      !> Numbers that a register of the machine holds, of those for which there are kernels: 2, 4
      !> or 8.
      pure function numbers_of_register() result(numbers) bind(c, &
         name="contensou_numbers_of_register")
         import :: c_int
         implicit none(type, external)
         integer(c_int) :: numbers
      end function numbers_of_register
   end interface

contains

   !> Those for the machine, or for narrower registers.
   pure type(kernels_type) function side_by_side(numbers) result(kernels)
      !> Numbers that a register holds; those of the machine, if it is not there.
      integer, intent(in), optional :: numbers
      integer :: held

      held = numbers_of_register()
      if (present(numbers)) held = numbers
      if (held >= 8) then
         kernels%recall => widest_recall
         kernels%stiffen => widest_stiffen
         kernels%try_elastic => widest_try_elastic
         kernels%slip_in_plane => widest_slip_in_plane
         ! Its lookups are for one shell at a time: the wider the registers, the longer a shell
         ! waits for the others.
         kernels%slip_on_circles => wide_slip_on_circles
         kernels%lay_out => widest_lay_out
         kernels%slip_on_ellipses => widest_slip_on_ellipses
         kernels%slide_shells => widest_slide_shells
         kernels%take_back => widest_take_back
      else if (held >= 4) then
         kernels%recall => wide_recall
         kernels%stiffen => wide_stiffen
         kernels%try_elastic => wide_try_elastic
         kernels%slip_in_plane => wide_slip_in_plane
         kernels%slip_on_circles => wide_slip_on_circles
         kernels%lay_out => wide_lay_out
         kernels%slip_on_ellipses => wide_slip_on_ellipses
         kernels%slide_shells => wide_slide_shells
         kernels%take_back => wide_take_back
      else
         kernels%recall => recall
         kernels%stiffen => stiffen
         kernels%try_elastic => try_elastic
         kernels%slip_in_plane => slip_in_plane
         kernels%slip_on_circles => slip_on_circles
         kernels%lay_out => lay_out
         kernels%slip_on_ellipses => slip_on_ellipses
         kernels%slide_shells => slide_shells
         kernels%take_back => take_back
      end if
   end function side_by_side

end module contensou_contact_tangential_registers
