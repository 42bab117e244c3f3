!> Vil'ke's force against Hertz's, and the spot by the formulas for c.
program vilke_example
   use contensou
   implicit none(type, external)

   !> Half relative curvatures [1/m], A/B = 5/12; effective modulus [Pa]; approach [m].
   real(wp), parameter :: a = 50.0_wp, b = 120.0_wp, modulus = 1.15e11_wp, approach = 1.0e-6_wp
   type(hertz_spot_type) :: hertz, spot

   call hertz_contact(a, b, modulus, approach, hertz)
   print "(a, 2(f9.5))", "hertz   c, N [N]        ", 1.0_wp - hertz%c1, hertz%force
   call vilke_exact(a, b, modulus, approach, spot)
   print "(a, 3(f9.5))", "exact   c, N, N/N_hertz ", 1.0_wp - spot%c1, spot%force, spot%force/hertz%force
   call vilke_power(a, b, modulus, approach, spot)
   print "(a, 3(f9.5))", "power   c, N, N/N_hertz ", 1.0_wp - spot%c1, spot%force, spot%force/hertz%force
   call vilke_chord(a, b, modulus, approach, spot)
   print "(a, 3(f9.5))", "chord   c, N, N/N_hertz ", 1.0_wp - spot%c1, spot%force, spot%force/hertz%force

end program vilke_example
