!> Complete elliptic integrals by complement and by parameter, one by one and as arrays.
program elliptic_example
   use contensou
   implicit none(type, external)

   call show()

contains

   !> Compute and print.
   subroutine show()
      real(wp) :: c1(5), k(5), e(5), b(5), d(5), values(6)
      integer :: i

      ! Axis ratios from the circle to a needle; c1 is their square.
      c1 = [1.0_wp, 0.5_wp, 1.0e-3_wp, 1.0e-10_wp, 0.0_wp]**2
      call complete_elliptic(c1, k, e)
      call complete_elliptic_bd(c1, b, d)
      print "(a)", "       c1             K             E             D"
      do i = 1, size(c1)
         print "(es9.2, 3f14.10)", c1(i), k(i), e(i), d(i)
      end do

      ! By the parameter c = 1 - c1: K, E, B, D, dK/dc, dE/dc.
      call complete_elliptic_all(1.0_wp - 0.687_wp, values(1), values(2), values(3), values(4), &
         values(5), values(6))
      print "(a, 6f10.6)", "c = 0.687", values
   end subroutine show

end program elliptic_example
