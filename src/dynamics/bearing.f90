!> Mechanics of a ball bearing: geometry, equilibrium under an axial load, speeds of rolling.
!>
!> In the plane of the axis and a ball, with r the radius of a ball, r_i and r_o the radii of the
!> grooves, d_m the pitch diameter and P the diametral clearance, the centre circles of the
!> grooves have the radii d_m/2 + (r_i - r) - P/4 and d_m/2 - (r_o - r) + P/4. A ball under load
!> lies on the line through both, which makes the contact angle alpha with the plane of the
!> bearing: tan alpha = h/(r_i + r_o - 2 r - P/2) with h the displacement of the inner ring along
!> the axis against the outer one. The approaches d_i and d_o fill what the line is longer than
!> r_i + r_o - 2 r, and with Q = K_i d_i^(3/2) = K_o d_o^(3/2) an axial load is Z Q sin alpha.
!>
!> Grooves with two arcs each touch an unloaded ball at four points, at a contact angle alpha_0, the
!> lean of the arcs: their centres lie at (r_k - r) sin(alpha_0) on both sides of the plane of the
!> ball, and cos(alpha_0) shortens the plays r_k - r across the axis. Under an axial load a ball is
!> held by the two arcs that are opposite each other.
!> A. Palmgren, Ball and Roller Bearing Engineering (1959); T. A. Harris, Rolling Bearing Analysis
!> (2001), chapters 6 and 7.
module contensou_dynamics_bearing
   use contensou_base_kinds, only : pi, wp
   use contensou_contact_normal, only : normal_type
   use contensou_special_bisection, only : bisection_type
   implicit none(type, external)
   private

   public :: ball_bearing_type, bearing_state_type, largest_angle

   !> Largest contact angle of a ball under an axial load [rad]: a groove ends.
   real(wp), parameter :: largest_angle = 1.2_wp

   !> Balls and grooves.
   type :: ball_bearing_type
      integer :: balls = 0
      !> Radius of a ball and of the pitch circle [m].
      real(wp) :: r = 0.0_wp, pitch = 0.0_wp
      !> Radii of the grooves: inner, outer [m].
      real(wp) :: groove(2) = 0.0_wp
      !> Diametral clearance [m].
      real(wp) :: clearance = 0.0_wp
      !> Contact angle of unloaded balls in grooves with two arcs each [rad]; 0 for one arc.
      real(wp) :: lean = 0.0_wp
   contains
      procedure :: reach
      procedure :: arc_offset
      procedure :: centre_circles
      procedure :: gap
      procedure :: clearance_at
      procedure :: ball_distance
      procedure :: most_balls
      procedure :: largest_clearance
      procedure :: least_pitch
      procedure :: axial_force
      procedure :: find_equilibrium
      procedure :: ball_centre
      procedure :: rolling_speeds
   end type ball_bearing_type

   !> How rings and balls lie against each other.
   type :: bearing_state_type
      !> Contact angle [rad], positive when the inner ring is displaced along the axis against the
      !> outer one.
      real(wp) :: angle = 0.0_wp
      !> Displacement of the inner ring along the axis against the outer one [m].
      real(wp) :: shift = 0.0_wp
      !> Approaches at the inner and the outer ring [m].
      real(wp) :: approach(2) = 0.0_wp
      !> Whether balls lie in the middle of four arcs, all alike.
      logical :: centred = .false.
   end type bearing_state_type

contains

   !> Distances across the axis of the centres of the arcs from the centre of an unloaded ball
   !> without clearance: inner, outer [m].
   pure function reach(self) result(distance)
      class(ball_bearing_type), intent(in) :: self
      real(wp) :: distance(2)

      distance = (self%groove - self%r)*cos(self%lean)
   end function reach

   !> The same along the axis, 0 for one arc [m].
   pure function arc_offset(self) result(distance)
      class(ball_bearing_type), intent(in) :: self
      real(wp) :: distance(2)

      distance = (self%groove - self%r)*sin(self%lean)
   end function arc_offset

   !> Radii of the centre circles of the grooves: inner, outer [m].
   pure function centre_circles(self) result(radii)
      class(ball_bearing_type), intent(in) :: self
      real(wp) :: radii(2), play(2)

      play = self%reach()
      radii = self%pitch + [play(1), -play(2)] + 0.25_wp*self%clearance*[-1.0_wp, 1.0_wp]
   end function centre_circles

   !> Distance of the centres of the grooves across the axis [m].
   pure function gap(self) result(distance)
      class(ball_bearing_type), intent(in) :: self
      real(wp) :: distance

      distance = sum(self%groove) - 2.0_wp*self%r - 0.5_wp*self%clearance &
         - sum(self%groove - self%r - self%reach())
   end function gap

   !> Diametral clearance with which the unloaded balls touch at a contact angle [m].
   pure real(wp) function clearance_at(self, angle) result(clearance)
      class(ball_bearing_type), intent(in) :: self
      !> Contact angle [rad].
      real(wp), intent(in) :: angle

      clearance = 4.0_wp*(sum(self%groove) - 2.0_wp*self%r)*sin(0.5_wp*angle)**2
   end function clearance_at

   !> Distance of the centres of two neighbouring balls [m].
   pure function ball_distance(bearing) result(distance)
      class(ball_bearing_type), intent(in) :: bearing
      real(wp) :: distance

      distance = 2.0_wp*bearing%pitch*sin(pi/bearing%balls)
   end function ball_distance

   !> Largest number of balls on the pitch circle at a distance of their centres; 0 for none.
   pure function most_balls(bearing, wanted) result(most)
      class(ball_bearing_type), intent(in) :: bearing
      !> The distance [m].
      real(wp), intent(in) :: wanted
      integer :: most

      most = 0
      if (bearing%pitch > bearing%r) most = floor(pi/asin(min(0.5_wp*wanted/bearing%pitch, &
         1.0_wp))*(1.0_wp - 4.0_wp*epsilon(wanted)))
   end function most_balls

   !> Clearance from which a ball can leave its groove [m].
   !>
   !> Beyond it a ball in the corner of both grooves is past the equator of one of the tubes, which
   !> in a ring is not there; and a ring may be displaced by half of the clearance.
   pure function largest_clearance(bearing) result(clearance)
      class(ball_bearing_type), intent(in) :: bearing
      real(wp) :: clearance
      real(wp) :: play(2)

      play = bearing%groove - bearing%r
      clearance = sum(play) - sqrt(abs(play(1)**2 - play(2)**2))
   end function largest_clearance

   !> Pitch diameter below which a ring has no room on its side of the axis: inner, outer [m].
   pure function least_pitch(bearing) result(diameter)
      class(ball_bearing_type), intent(in) :: bearing
      real(wp) :: diameter(2), shorter(2)

      shorter = bearing%groove - bearing%r - bearing%reach()
      diameter(1) = 2.0_wp*bearing%r + 0.5_wp*bearing%clearance + 2.0_wp*shorter(1)
      diameter(2) = 4.0_wp*bearing%groove(2) - 2.0_wp*bearing%r - 0.5_wp*bearing%clearance &
         - 2.0_wp*shorter(2)
   end function least_pitch

   !> Axial force at a contact angle [N], and the approaches that it goes with.
   subroutine axial_force(bearing, law, angle, approach, force)
      class(ball_bearing_type), intent(in) :: bearing
      !> Normal part of a ball on a ring, whatever its curvatures.
      type(normal_type), intent(in) :: law
      !> Contact angle [rad], >= 0.
      real(wp), intent(in) :: angle
      !> Approaches at the inner and the outer ring [m].
      real(wp), intent(out) :: approach(2)
      !> Axial force of all balls [N].
      real(wp), intent(out) :: force
      real(wp) :: total, soft(2), ball(2), rolling(2), across, along
      type(normal_type) :: normal
      integer :: k, i

      total = max(bearing%gap()/cos(angle) - (sum(bearing%groove) - 2.0_wp*bearing%r), 0.0_wp)
      approach = 0.5_wp*total
      normal = law
      ! The curvatures depend on where the ball lies, by the approach over the radii.
      do i = 1, 4
         ball = bearing%ball_centre(angle, approach)
         rolling = cos(angle)*[1.0_wp, -1.0_wp] &
            /(ball(1) + (bearing%r - approach)*cos(angle)*[-1.0_wp, 1.0_wp])
         do k = 1, 2
            across = 0.5_wp*(1.0_wp/bearing%r - 1.0_wp/bearing%groove(k))
            along = 0.5_wp*(1.0_wp/bearing%r + rolling(k))
            call normal%follow(min(across, along), max(across, along))
            soft(k) = normal%stiffness**(-2.0_wp/3.0_wp)
         end do
         approach = total*soft/sum(soft)
      end do
      force = bearing%balls*(total/sum(soft))**1.5_wp*sin(angle)
   end subroutine axial_force

   !> Equilibrium with an axial load; without a load and without a preload the ring is in the middle
   !> of its clearance. Of two arcs each, without a load or with an interference, too: all four then
   !> carry.
   subroutine find_equilibrium(bearing, law, load, state, largest_load)
      class(ball_bearing_type), intent(in) :: bearing
      !> Normal part of a ball on a ring, whatever its curvatures.
      type(normal_type), intent(in) :: law
      !> Load on the inner ring along the axis against the outer one [N], >= 0.
      real(wp), intent(in) :: load
      type(bearing_state_type), intent(out) :: state
      !> What the bearing carries [N]; negative if it carries the load.
      real(wp), intent(out) :: largest_load
      real(wp) :: low, high, force
      type(bisection_type) :: search

      low = 0.0_wp
      largest_load = -1.0_wp
      state%centred = bearing%lean > 0.0_wp .and. (load <= 0.0_wp .or. bearing%clearance < 0.0_wp)
      if (state%centred) then
         state%approach = -0.25_wp*bearing%clearance*cos(bearing%lean)
         return
      end if
      if (load <= 0.0_wp .and. bearing%clearance >= 0.0_wp) then
         state%approach = -0.25_wp*bearing%clearance
         return
      end if
      if (load > 0.0_wp) then
         associate (play => sum(bearing%groove) - 2.0_wp*bearing%r)
            if (bearing%gap() < play) low = acos(bearing%gap()/play)
         end associate
         high = largest_angle
         call bearing%axial_force(law, high, state%approach, force)
         if (low >= high .or. force < load) then
            largest_load = force
            return
         end if
         call search%begin(low, high, steps=200)
         do while (search%goes_on)
            call bearing%axial_force(law, search%middle, state%approach, force)
            call search%narrow(.not. force < load)
         end do
         low = search%low
      end if
      call bearing%axial_force(law, low, state%approach, force)
      state%angle = low
      state%shift = bearing%gap()*tan(low) - sum(bearing%arc_offset())
   end subroutine find_equilibrium

   !> Distance of the centre of a ball from the axis, and along it from the plane of the outer
   !> groove [m].
   pure function ball_centre(bearing, angle, approach) result(centre)
      class(ball_bearing_type), intent(in) :: bearing
      !> Contact angle [rad].
      real(wp), intent(in) :: angle
      !> Approaches at the inner and the outer ring [m].
      real(wp), intent(in) :: approach(2)
      real(wp) :: centre(2)
      real(wp) :: ring(2)

      ring = bearing%centre_circles()
      centre(1) = ring(2) + (bearing%groove(2) - bearing%r + approach(2))*cos(angle)
      centre(2) = (bearing%groove(2) - bearing%r + approach(2))*sin(angle)
   end function ball_centre

   !> Speeds at which the balls roll on both rings without slip.
   !>
   !> Contacts lie midway between the undeformed surfaces: with the velocity v of the centre,
   !> v + arm_i spin = w_i contact_i and v - arm_o spin = w_o contact_o.
   pure subroutine rolling_speeds(bearing, state, speed, orbit, spin)
      class(ball_bearing_type), intent(in) :: bearing
      type(bearing_state_type), intent(in) :: state
      !> Angular velocities of the rings: inner, outer [rad/s].
      real(wp), intent(in) :: speed(2)
      !> Angular velocity of the balls about the axis of the bearing [rad/s].
      real(wp), intent(out) :: orbit
      !> Angular velocity of a ball across the line of its contacts [rad/s].
      real(wp), intent(out) :: spin
      real(wp) :: centre(2), arm(2), contact(2)

      centre = bearing%ball_centre(state%angle, state%approach)
      arm = bearing%r - 0.5_wp*state%approach
      if (state%centred) then
         centre = [bearing%pitch, 0.0_wp]
         arm = arm*cos(bearing%lean)
      end if
      contact = centre(1) + arm*cos(state%angle)*[-1.0_wp, 1.0_wp]
      spin = (speed(1)*contact(1) - speed(2)*contact(2))/sum(arm)
      orbit = (speed(1)*contact(1) - spin*arm(1))/centre(1)
   end subroutine rolling_speeds

end module contensou_dynamics_bearing
