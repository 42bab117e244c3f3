!> What laws of creep may not do: exceed the limit of friction, or drive. Several flexibilities and
!> splines do a little, on needles most of all.
!>
!> Force and torque of the size x, over f N and over the torque of pure spin, are those of the size
!>    x up to one,   1 + s (1 - exp((1 - x)/s)) above,   s = 5e-4,
!> so that the derivatives are continuous and full sliding is left as it is. Of what drives the part
!> along the velocities is left out.
module contensou_contact_creep_bounds
   use contensou_base_kinds, only : wp
   use contensou_contact_creep_law, only : creep_motion_type, creep_spot_type, n_velocities
   implicit none(type, external)
   private

   public :: confine

   !> What force and torque may exceed their limits by, as a part of them.
   real(wp), parameter :: excess = 5.0e-4_wp

   !> What is taken off beside the part that drives, for rounding errors.
   real(wp), parameter :: margin = 1.0e-10_wp

contains

   !> Confine a wrench in units of f N and f N a, and its derivatives.
   pure subroutine confine(spot, motion, wrench, jacobian)
      type(creep_spot_type), intent(in) :: spot
      type(creep_motion_type), intent(in) :: motion
      real(wp), intent(inout) :: wrench(3)
      !> By x, y, spin, rx, ry.
      real(wp), intent(inout), optional :: jacobian(3, n_velocities)
      real(wp) :: slides(3), by(n_velocities), square, drive
      integer :: i

      square = wrench(1)**2 + wrench(2)**2
      if (square > 1.0_wp) call shorten(sqrt(square), 1, 2, wrench, jacobian)
      if (abs(wrench(3)) > spot%shape%torque) call shorten(abs(wrench(3))/spot%shape%torque, 3, 3, &
         wrench, jacobian)
      slides = [motion%x, motion%y, motion%spin]
      drive = dot_product(wrench, slides)
      if (.not. drive > 0.0_wp) return
      square = dot_product(slides, slides)
      drive = drive/square
      if (present(jacobian)) then
         by = matmul(slides, jacobian)
         by(:3) = by(:3) + wrench - 2.0_wp*drive*slides
         do i = 1, n_velocities
            jacobian(:, i) = jacobian(:, i) - (by(i)/square)*slides
         end do
         do i = 1, 3
            jacobian(i, i) = jacobian(i, i) - drive
         end do
      end if
      wrench = wrench - (drive*(1.0_wp + margin))*slides
   end subroutine confine

   !> Shorten the components between two, of the size x > 1 in units of their limit.
   pure subroutine shorten(x, first, last, wrench, jacobian)
      real(wp), intent(in) :: x
      integer, intent(in) :: first, last
      real(wp), intent(inout) :: wrench(3)
      real(wp), intent(inout), optional :: jacobian(3, n_velocities)
      real(wp) :: beyond, factor, along, slope
      integer :: i

      beyond = exp((1.0_wp - x)/excess)
      factor = (1.0_wp + excess*(1.0_wp - beyond))/x
      if (present(jacobian)) then
         ! Of the factor, by x, over x.
         slope = (beyond - factor)/x**2
         do i = 1, n_velocities
            along = dot_product(wrench(first:last), jacobian(first:last, i)) &
               /dot_product(wrench(first:last), wrench(first:last))*x**2
            jacobian(first:last, i) = factor*jacobian(first:last, i) &
               + (slope*along)*wrench(first:last)
         end do
      end if
      wrench(first:last) = factor*wrench(first:last)
   end subroutine shorten

end module contensou_contact_creep_bounds
