!> Vil'ke's force against Hertz's, and the spot by the formulas for c.
program vilke_example
   use contensou
   implicit none(type, external)

   !> Half relative curvatures [1/m], A/B = 5/12; effective modulus [Pa]; approach [m].
   real(wp), parameter :: a = 50.0_wp, b = 120.0_wp, modulus = 1.15e11_wp, approach = 1.0e-6_wp
   type(hertz_spot_type) :: hertz, spot
   integer :: i

   print "(a)", "formula                    c [-]    N [N]  N/N_Hertz"
   call hertz_contact(a, b, modulus, approach, hertz)
   print "(a, 2(f9.5))", "Hertz                   ", 1.0_wp - hertz%c1, hertz%force
   associate (formulas => vilke_models())
      do i = 1, size(formulas)
         call formulas(i)%kernel(a, b, modulus, approach, spot)
         print "(a, 3(f9.5))", formulas(i)%info%name, 1.0_wp - spot%c1, spot%force, &
            spot%force/hertz%force
      end do
   end associate

end program vilke_example
