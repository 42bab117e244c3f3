!> Slip of shells side by side, by the registers of the machine on which the program runs.
module contensou_contact_tangential_registers
   use, intrinsic :: iso_c_binding, only : c_int
   use contensou_contact_tangential_abreast, only : lay_out, slide_shells, slip_in_plane, &
      slip_on_circles, slip_on_ellipses
   use contensou_contact_tangential_abreast_wide, only : wide_lay_out => lay_out, &
      wide_slide_shells => slide_shells, &
      wide_slip_in_plane => slip_in_plane, wide_slip_on_circles => slip_on_circles, &
      wide_slip_on_ellipses => slip_on_ellipses
   use contensou_contact_tangential_abreast_widest, only : widest_lay_out => lay_out, &
      widest_slide_shells => slide_shells, &
      widest_slip_in_plane => slip_in_plane, widest_slip_on_circles => slip_on_circles, &
      widest_slip_on_ellipses => slip_on_ellipses
   implicit none(type, external)
   private

   public :: side_by_side, kernels_type, numbers_of_register

   !> Procedures of `contensou_contact_tangential_abreast`, for one of the registers.
   type :: kernels_type
      procedure(slip_in_plane), pointer, nopass :: slip_in_plane => null()
      procedure(slip_on_circles), pointer, nopass :: slip_on_circles => null()
      procedure(lay_out), pointer, nopass :: lay_out => null()
      procedure(slip_on_ellipses), pointer, nopass :: slip_on_ellipses => null()
      procedure(slide_shells), pointer, nopass :: slide_shells => null()
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
         kernels%slip_in_plane => widest_slip_in_plane
         kernels%slip_on_circles => widest_slip_on_circles
         kernels%lay_out => widest_lay_out
         kernels%slip_on_ellipses => widest_slip_on_ellipses
         kernels%slide_shells => widest_slide_shells
      else if (held >= 4) then
         kernels%slip_in_plane => wide_slip_in_plane
         kernels%slip_on_circles => wide_slip_on_circles
         kernels%lay_out => wide_lay_out
         kernels%slip_on_ellipses => wide_slip_on_ellipses
         kernels%slide_shells => wide_slide_shells
      else
         kernels%slip_in_plane => slip_in_plane
         kernels%slip_on_circles => slip_on_circles
         kernels%lay_out => lay_out
         kernels%slip_on_ellipses => slip_on_ellipses
         kernels%slide_shells => slide_shells
      end if
   end function side_by_side

end module contensou_contact_tangential_registers
