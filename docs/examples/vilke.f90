!> Vil'ke's force against Hertz's, and the spot by the formulas for c.
program vilke_example
   use contensou
   implicit none(type, external)

   !> Half relative curvatures [1/m], A/B = 5/12; effective modulus [Pa]; approach [m].
   real(wp), parameter :: a = 50.0_wp, b = 120.0_wp, modulus = 1.15e11_wp, approach = 1.0e-6_wp
   real(wp) :: hertz, c1, major, minor, force, pressure

   call hertz_contact(a, b, modulus, approach, c1, major, minor, hertz, pressure)
   print "(a, 2(f9.5))", "hertz   c, N [N]        ", 1.0_wp - c1, hertz
   call vilke_exact(a, b, modulus, approach, c1, major, minor, force, pressure)
   print "(a, 3(f9.5))", "exact   c, N, N/N_hertz ", 1.0_wp - c1, force, force/hertz
   call vilke_power(a, b, modulus, approach, c1, major, minor, force, pressure)
   print "(a, 3(f9.5))", "power   c, N, N/N_hertz ", 1.0_wp - c1, force, force/hertz
   call vilke_chord(a, b, modulus, approach, c1, major, minor, force, pressure)
   print "(a, 3(f9.5))", "chord   c, N, N/N_hertz ", 1.0_wp - c1, force, force/hertz

end program vilke_example
