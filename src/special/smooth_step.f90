!> A step from 0 to 1 that begins and ends with slope zero.
module contensou_special_smooth_step
   use contensou_base_kinds, only : wp
   implicit none(type, external)
   private

   public :: smooth_step

contains

   !> The step.
   pure real(wp) function smooth_step(x, between)
      real(wp), intent(in) :: x
      !> Where it begins and ends.
      real(wp), intent(in) :: between(2)

      smooth_step = min(max((x - between(1))/(between(2) - between(1)), 0.0_wp), 1.0_wp)
      smooth_step = smooth_step*smooth_step*(3.0_wp - 2.0_wp*smooth_step)
   end function smooth_step

end module contensou_special_smooth_step
