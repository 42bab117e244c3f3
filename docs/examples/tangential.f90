!> A spot that is loaded, sheared to and fro, twisted, and unloaded.
program tangential_example
   use contensou
   implicit none(type, external)

   !> Semi-axes of the spot [m].
   real(wp), parameter :: a = 1.0e-3_wp, b = 6.0e-4_wp

   !> Normal force [N], friction coefficient, shear modulus [Pa], Poisson's ratio.
   real(wp), parameter :: load = 100.0_wp, f = 0.3_wp, modulus = 8.0e10_wp, poisson = 0.3_wp

   call show()

contains

   !> Compute and print.
   subroutine show()
      !> Steps of shift along the axes [m] and twist [rad].
      real(wp), parameter :: steps(3, 5) = reshape([ &
         1.0e-7_wp, 0.0_wp, 0.0_wp, -1.5e-7_wp, 0.0_wp, 0.0_wp, 1.5e-7_wp, 0.0_wp, 0.0_wp, &
         0.0_wp, 0.0_wp, 4.0e-4_wp, 0.0_wp, 0.0_wp, 0.0_wp], [3, 5])
      real(wp) :: wrench(3), stored, lost
      type(spring_spot_type) :: spot
      type(shells_type) :: shells
      integer :: i

      spot = spring_spot_type(spot_shape_type(b/a), a, f*load, modulus, poisson)
      print "(a, 3es14.6)", "stiffness", spot%stiffness

      call shells%begin()
      print "(a)", "        Fx [N]      Fy [N]    Tz [N m]  stored [uJ]    lost [uJ]"
      do i = 1, size(steps, 2)
         ! The last step leaves an eighth of the load on a spot of half the size.
         if (i == size(steps, 2)) then
            spot%a = a/2
            spot%limit = f*load/8
            call spot%stiffen(modulus, poisson)
         end if
         call shells%advance(spot, steps(:, i), wrench, stored, lost)
         print "(i2, 2f12.6, f12.7, 2f13.7)", i, wrench, 1.0e6_wp*stored, 1.0e6_wp*lost
      end do
   end subroutine show

end program tangential_example
