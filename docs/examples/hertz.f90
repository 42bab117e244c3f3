!> A barrel-shaped roller on a plane: spot, force and pressure for an approach, and back.
program hertz_example
   use contensou
   implicit none(type, external)

   call show()

contains

   !> Compute and print.
   subroutine show()
      !> Radii of the roller across and along its profile [m].
      real(wp), parameter :: radius_across = 0.010_wp, radius_along = 0.120_wp
      real(wp) :: curvature_a, curvature_b, modulus
      type(hertz_spot_type) :: spot
      type(hertz_type) :: roller

      modulus = effective_modulus(2.1e11_wp, 0.3_wp, 2.1e11_wp, 0.3_wp)
      curvature_a = 0.5_wp/radius_along
      curvature_b = 0.5_wp/radius_across
      call hertz_contact(curvature_a, curvature_b, modulus, 5.0e-6_wp, spot)
      print "(a, f11.6)", "c  [-]  ", 1.0_wp - spot%c1
      print "(a, f11.6)", "a  [mm] ", 1.0e3_wp*spot%a
      print "(a, f11.6)", "b  [mm] ", 1.0e3_wp*spot%b
      print "(a, f11.4)", "N  [N]  ", spot%force
      print "(a, f11.4)", "p0 [MPa]", 1.0e-6_wp*spot%pressure

      ! The curvatures stay, so all but the approach is computed once.
      roller = hertz_type(curvature_a, curvature_b, modulus)
      print "(a, f11.6)", "approach under 100 N [um]          ", 1.0e6_wp*roller%approach(100.0_wp)
      print "(a, f11.6)", "elastic energy at 5 um [mJ]        ", 1.0e3_wp*roller%energy(5.0e-6_wp)
   end subroutine show

end program hertz_example
