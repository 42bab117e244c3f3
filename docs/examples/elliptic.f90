!> Complete elliptic integrals by complement and by parameter, one by one and as arrays.
program elliptic_example
   use contensou
   implicit none(type, external)

   call show()

contains

   !> Compute and print.
   subroutine show()
      real(wp), dimension(5) :: c1, k, e, b, d, dk_dc, de_dc
      integer :: i

      ! Axis ratios from the circle to a needle; c1 is their square.
      c1 = [1.0_wp, 0.5_wp, 1.0e-3_wp, 1.0e-10_wp, 0.0_wp]**2
      call complete_elliptic(c1, k, e, b, d, dk_dc, de_dc)
      print "(a)", "       c1             K             E             D"
      do i = 1, size(c1)
         print "(es9.2, 3f14.10)", c1(i), k(i), e(i), d(i)
      end do

      ! By the parameter c = 1 - c1; the first two alone cost less.
      call complete_elliptic(1.0_wp - 0.687_wp, k(1), e(1), b(1), d(1), dk_dc(1), de_dc(1))
      print "(a, 6f10.6)", "c = 0.687", k(1), e(1), b(1), d(1), dk_dc(1), de_dc(1)
   end subroutine show

end program elliptic_example
