!> Mechanics of a ball bearing: geometry, equilibrium and speeds of rolling against hand formulas.
module test_bearing
   use contensou_base_kinds, only : pi, wp
   use contensou_contact_hertz, only : effective_modulus
   use contensou_contact_normal_law, only : new_normal, normal_type
   use contensou_dynamics_bearing, only : ball_bearing_type, bearing_state_type
   use test_harness, only : check, check_close, check_relative
   implicit none(type, external)
   private

   public :: run_bearing_tests

contains

   !> Run all of them.
   subroutine run_bearing_tests()
      type(ball_bearing_type) :: bearing

      bearing = ball_bearing_type(balls=9, r=4.0e-3_wp, pitch=19.5e-3_wp, &
         groove=[4.12e-3_wp, 4.16e-3_wp], clearance=10.0e-6_wp)
      call test_geometry(bearing)
      call test_equilibrium(bearing)
      call test_speeds(bearing)
   end subroutine run_bearing_tests

   !> Radii and bounds.
   subroutine test_geometry(bearing)
      type(ball_bearing_type), intent(in) :: bearing
      type(ball_bearing_type) :: other
      real(wp) :: ring(2), centre(2), least(2)

      ring = bearing%centre_circles()
      call check_relative(ring(1), 19.5e-3_wp + 0.12e-3_wp - 2.5e-6_wp, 1.0e-15_wp, &
         "bearing: centre circle of the inner groove")
      call check_relative(ring(2), 19.5e-3_wp - 0.16e-3_wp + 2.5e-6_wp, 1.0e-15_wp, &
         "bearing: centre circle of the outer groove")
      call check_relative(bearing%gap(), ring(1) - ring(2), 1.0e-12_wp, &
         "bearing: distance of the centre circles")
      centre = bearing%ball_centre(0.0_wp, [0.0_wp, 0.0_wp])
      call check_relative(centre(1), bearing%pitch + 2.5e-6_wp, 1.0e-15_wp, &
         "bearing: a ball touches the outer groove")
      call check_relative(bearing%ball_distance(), 39.0e-3_wp*sin(pi/9.0_wp), 1.0e-15_wp, &
         "bearing: distance of two balls")
      other = bearing
      other%balls = bearing%most_balls(8.0e-3_wp)
      call check(other%ball_distance() > 8.0e-3_wp, "bearing: so many balls find room")
      other%balls = other%balls + 1
      call check(other%ball_distance() < 8.0e-3_wp, "bearing: one more does not")
      other%pitch = 3.0e-3_wp
      call check(other%most_balls(8.0e-3_wp) == 0, "bearing: no ball on a small circle")
      least = bearing%least_pitch()
      other = bearing
      other%pitch = 0.5_wp*least(1)
      ring = other%centre_circles()
      call check_relative(ring(1), other%groove(1), 1.0e-12_wp, "bearing: least inner ring")
      other%pitch = 0.5_wp*least(2)
      ring = other%centre_circles()
      call check_relative(ring(2), other%groove(2), 1.0e-12_wp, "bearing: least outer ring")
      call check_relative(bearing%largest_clearance(), 0.28e-3_wp - sqrt(0.16e-3_wp**2 &
         - 0.12e-3_wp**2), 1.0e-12_wp, "bearing: largest clearance")
   end subroutine test_geometry

   !> Axial load and contact angle.
   subroutine test_equilibrium(bearing)
      type(ball_bearing_type), intent(in) :: bearing
      type(normal_type) :: normal
      type(bearing_state_type) :: state
      real(wp) :: approach(2), force, largest

      normal = new_normal(effective_modulus(2.1e11_wp, 0.3_wp, 2.1e11_wp, 0.3_wp), 100.0_wp, &
         100.0_wp, with_shape=.false.)
      call bearing%find_equilibrium(normal, 0.0_wp, state, largest)
      call check_close(maxval(abs(state%approach + 2.5e-6_wp)), 0.0_wp, 1.0e-20_wp, &
         "bearing: without load in the middle of the clearance")
      call check(largest < 0.0_wp, "bearing: no load is carried")
      call bearing%find_equilibrium(normal, 1000.0_wp, state, largest)
      call check(largest < 0.0_wp, "bearing: 1000 N are carried")
      call bearing%axial_force(normal, state%angle, approach, force)
      call check_relative(force, 1000.0_wp, 1.0e-11_wp, "bearing: axial load")
      call check_relative(state%shift, bearing%gap()*tan(state%angle), 1.0e-14_wp, &
         "bearing: displacement")
      ! The line through the centres of the grooves is longer by the approaches.
      call check_relative(sum(state%approach), hypot(bearing%gap(), state%shift) - 0.28e-3_wp, &
         1.0e-10_wp, "bearing: approaches")
      call bearing%find_equilibrium(normal, 1.0e9_wp, state, largest)
      call check(largest > 1000.0_wp .and. largest < 1.0e9_wp, "bearing: 1e9 N are too much")
   end subroutine test_equilibrium

   !> Speeds of the balls.
   subroutine test_speeds(bearing)
      type(ball_bearing_type), intent(in) :: bearing
      type(bearing_state_type) :: state
      real(wp) :: orbit, spin, centre(2)

      state%angle = 0.4_wp
      centre = bearing%ball_centre(state%angle, state%approach)
      call bearing%rolling_speeds(state, [100.0_wp, 0.0_wp], orbit, spin)
      ! The epicyclic formula of catalogues, with the radius of the circle of the centres.
      associate (ratio => bearing%r*cos(state%angle)/centre(1))
         call check_relative(orbit, 50.0_wp*(1.0_wp - ratio), 1.0e-13_wp, "bearing: cage speed")
         call check_relative(spin, 50.0_wp*centre(1)/bearing%r*(1.0_wp - ratio), 1.0e-13_wp, &
            "bearing: speed of a ball")
      end associate
      call bearing%rolling_speeds(state, [100.0_wp, 100.0_wp], orbit, spin)
      call check_relative(orbit, 100.0_wp, 1.0e-13_wp, "bearing: rings that turn together")
      call check_relative(spin, -100.0_wp*cos(state%angle), 1.0e-13_wp, &
         "bearing: balls that turn with them")
   end subroutine test_speeds

end module test_bearing
