!> Loads of contacts and their derivatives by the motion of the two bodies.
!>
!> A load depends on the pose through the contact point, its normal and its curvatures (their
!> variation comes from the geometry) and on the velocities through the kernels' own derivatives.
!> States of parts are degrees of freedom beside those; how fast the frame of their vectors turns is
!> varied with the velocities only, as the vectors are small.
!> That of the force of the elastic energy through the curvatures, small against the normal force by
!> the approach over the radii, comes from differences.
!>
!> A rigid contact has its load at a given normal force, and the second derivative of its gap at
!> given accelerations, from which the Jacobian finds how the normal force varies. The part of it
!> that the velocities make holds third derivatives of the surfaces; its variation with the pose
!> comes from differences, that with the velocities is exact, as it is quadratic in them.
module contensou_dynamics_linear_load
   use contensou_base_kinds, only : wp
   use contensou_base_rotations, only : quaternion_from_axis_angle, rotation_matrix
   use contensou_base_vectors, only : cross
   use contensou_contact_geometry, only : contact_motion_type, contact_point_type, &
      contact_variation_type, pose_type, rolling_velocity, track_type, trouble_none
   use contensou_contact_law, only : along_axes, contact_law_type, spot_motion_type
   use contensou_contact_normal, only : normal_type
   use contensou_contact_states, only : most_numbers, most_states
   use contensou_dynamics_links, only : link_type, set_kinematics
   use contensou_dynamics_mechanism, only : contact_type, frame_spin, relative_motion, &
      resolution_type
   implicit none(type, external)
   private

   public :: freedoms, linear_load_type, linearize, linearize_link, outcomes

   !> Degrees of freedom of a pair: translation, rotation, velocity and angular velocity of A, then
   !> of B; all in the inertial frame.
   integer, parameter :: freedoms = 24

   !> What a contact gives: force on B, torque about the centres of mass of A and of B, power lost
   !> in friction and in damping.
   integer, parameter :: outcomes = 11

   !> Relative step of differences.
   real(wp), parameter :: step = 1.0e-5_wp

   !> Step of the differences of the force through the curvatures, over the approach.
   real(wp), parameter :: shape_step = 1.0e-3_wp

   !> That of finer differences.
   real(wp), parameter :: fine_step = 1.0e-2_wp

   !> Step of the differences of what velocities make of the gap of a rigid contact, over the
   !> smaller of a radian and what moves the contact by its radius of curvature.
   real(wp), parameter :: pose_step = 1.0e-4_wp

   !> Load of a contact and its derivatives.
   type :: linear_load_type
      !> Force on B [N].
      real(wp) :: force(3)
      !> Torques about the centres of mass of A and B [N m].
      real(wp) :: torque_a(3), torque_b(3)
      !> Derivatives of the outcomes by the degrees of freedom and the states of parts.
      real(wp) :: slopes(outcomes, freedoms + most_numbers)
      !> Derivatives of the rates of the states of parts.
      real(wp) :: rate_slopes(most_numbers, freedoms + most_numbers)
      !> Of a rigid contact: derivatives of the second derivative of the gap, with what stabilises
      !> it, at given accelerations in the frames of the state [m/s2 by freedom].
      real(wp) :: gap_slopes(1, freedoms)
   end type linear_load_type

   !> A closed contact at a state: all that its load follows from.
   type, extends(contact_motion_type) :: touch_type
      !> How the contact point varies.
      type(contact_variation_type) :: variation
      !> Whether the contact is rigid, its normal force given.
      logical :: rigid
      !> Whether the curvatures vary.
      logical :: varies
      !> Whether differences are to be as fine as the rest.
      logical :: exactly = .false.
      !> Whether the contact rolls steadily.
      logical :: rolls = .false.
      !> Motion along the axes; the approach of a rigid contact is that by which Hertz's theory has
      !> its normal force.
      type(spot_motion_type) :: spot
      !> Unit tangent along the minor axis of the spot.
      real(wp) :: minor(3)
      !> Arms of the contact point about the centres of mass [m].
      real(wp) :: arm_a(3), arm_b(3)
      !> Force on B [N], and torque about the contact point [N m].
      real(wp) :: force(3), torque(3)
      !> N, the forces along the major and the minor axis [N], torque about the normal [N m].
      real(wp) :: values(4)
      !> Their derivatives by approach, its rate, sliding along the axes and spin.
      real(wp) :: slopes(4, 5)
      !> Elastic force [N].
      real(wp) :: elastic
      !> Of a curved spot: angular velocity of B against A along its axes [rad/s], moment along them
      !> [N m], its derivatives as those of the values, and those of F_x, F_y, T and the moment by
      !> the angular velocity. The curvatures count as constant, but for the normal force.
      real(wp) :: along(2), moment(2), moment_slopes(2, 5), by_rolling(5, 2)
      !> Derivatives of the values and of the elastic force by the curvatures.
      real(wp) :: by_curvature(5, 2)
      !> States of the parts, and their rates.
      real(wp) :: states(most_states), rates(most_states)
      !> Derivatives of the values by the states.
      real(wp) :: by_states(4, most_states)
      !> Derivatives of the rates as those of the values, then by the states.
      real(wp) :: rate_slopes(most_states, 5 + most_states)
      !> Derivatives of the rates by the curvatures.
      real(wp) :: rates_by_curvature(most_states, 2)
      !> In steady rolling: derivatives of F_x, F_y and T by the velocity of the material along the
      !> axes, that velocity [m/s], and its derivatives by a twist of B against A, the velocities
      !> as they are.
      real(wp) :: by_carried(3, 2), carried(3), carried_by_twist(3, 6)
      !> Angular velocity of the frame of the states [rad/s].
      real(wp) :: frame_spin(3)
      !> Force and torque of the elastic energy through the curvatures [N, N m].
      real(wp) :: shape(6)
      !> Their derivatives by a twist of B against A.
      real(wp) :: shape_by_twist(6, 6)
      !> Torque of rolling resistance [N m].
      real(wp) :: rolling(3)
      !> Its derivatives by the curvatures, at the normal force [N m2].
      real(wp) :: rolling_by_curvature(3, 2)
      !> Of a rigid contact: angular accelerations of A and B, inertial frame [rad/s2].
      real(wp) :: turning(3, 2)
      !> Acceleration of B against A at the contact point, but for what velocities make [m/s2].
      real(wp) :: acceleration(3)
      !> Factors of rate and gap in the stabilisation [1/s, 1/s2].
      real(wp) :: stabilisation(2)
   end type touch_type

   !> A small motion of the two bodies, inertial frame.
   type :: displacement_type
      !> Translation and rotation of B against A at the contact point.
      real(wp) :: shift(3) = 0.0_wp, turn(3) = 0.0_wp
      !> Translation at the contact point and rotation of A, which carry both.
      real(wp) :: carry(3) = 0.0_wp, carry_turn(3) = 0.0_wp
      !> Translations of the centres of mass of A and B.
      real(wp) :: shift_a(3) = 0.0_wp, shift_b(3) = 0.0_wp
   end type displacement_type

   !> How a contact varies with a degree of freedom.
   type :: change_type
      real(wp) :: gap = 0.0_wp
      !> Of the curvatures A and B.
      real(wp) :: curvatures(2) = 0.0_wp
      !> Of force and torque of the elastic energy through the curvatures.
      real(wp) :: shape(6) = 0.0_wp
      !> Of the normal and the axes of the spot.
      real(wp) :: normal(3) = 0.0_wp, major(3) = 0.0_wp, minor(3) = 0.0_wp
      !> Of velocity and angular velocity of B against A at the contact point.
      real(wp) :: velocity(3) = 0.0_wp, spin(3) = 0.0_wp
      !> Of the velocity of the material through the spot.
      real(wp) :: carried(3) = 0.0_wp
      real(wp) :: arm_a(3) = 0.0_wp, arm_b(3) = 0.0_wp
      !> Of the acceleration of B against A at the contact point, but for what velocities make.
      real(wp) :: acceleration(3) = 0.0_wp
      !> Of approach, its rate, sliding and spin.
      real(wp) :: motion(5) = 0.0_wp
   end type change_type

contains

   !> Load of a contact with compliance, and its derivatives.
   subroutine linearize(contact, a, b, resolution, load, closed, exactly)
      type(contact_type), intent(inout) :: contact
      type(pose_type), intent(in) :: a
      type(pose_type), intent(in) :: b
      !> What is resolved of the velocities.
      type(resolution_type), intent(in) :: resolution
      !> The load; not set when open.
      type(linear_load_type), intent(out) :: load
      !> Whether the contact is closed.
      logical, intent(out) :: closed
      !> Whether differences are to be as fine as the rest; not if not given.
      logical, intent(in), optional :: exactly
      type(touch_type) :: touch
      real(wp) :: gap
      integer :: trouble

      call contact%find_gap(a, b, gap)
      closed = gap < 0.0_wp .and. .not. contact%track%lost
      if (.not. closed) return
      call contact%locate(a, b, gap, touch%at)
      touch%rigid = .false.
      touch%varies = .not. contact%law%geometry%constant_curvatures
      call contact%follow(touch%at, trouble)
      closed = trouble == trouble_none
      if (.not. closed) return
      touch%spot%approach = -gap
      if (allocated(contact%law%curved)) call contact%bend(a, b, touch%at)
      touch%spot%resolution = resolution%of(a, b, touch%at%point)
      if (present(exactly)) touch%exactly = exactly
      call vary_touch(touch, contact, a, b, load)
   end subroutine linearize

   !> Load of a closed rigid contact at its normal force, the derivatives of the load, and those of
   !> the second derivative of the gap at given accelerations.
   subroutine linearize_link(contact, link, a, b, acceleration, load)
      !> The contact, its normal part as in the right-hand side.
      type(contact_type), intent(inout) :: contact
      !> Its state, the normal force known.
      type(link_type), intent(in) :: link
      type(pose_type), intent(in) :: a
      type(pose_type), intent(in) :: b
      !> Accelerations of the centres of mass (1:3) and angular accelerations (4:6) of A and B,
      !> inertial frame [m/s2, rad/s2].
      real(wp), intent(in) :: acceleration(6, 2)
      type(linear_load_type), intent(out) :: load
      type(touch_type) :: touch
      real(wp) :: bias_slopes(freedoms)

      touch%at = link%at
      touch%rigid = .true.
      touch%varies = .not. contact%law%geometry%constant_curvatures
      touch%spot%resolution = link%resolution
      touch%values(1) = link%normal_force
      touch%turning = acceleration(4:6, :)
      touch%acceleration = acceleration(1:3, 2) + cross(acceleration(4:6, 2), link%arm(:, 2)) &
         - acceleration(1:3, 1) - cross(acceleration(4:6, 1), link%arm(:, 1))
      ! The pace itself is not varied: gap and rate, which it multiplies, are close to zero.
      touch%stabilisation = [2.0_wp*sqrt(link%pace), link%pace]
      call vary_touch(touch, contact, a, b, load)
      call differ_bias(contact, link, a, b, bias_slopes)
      load%gap_slopes(1, :) = load%gap_slopes(1, :) + bias_slopes
   end subroutine linearize_link

   !> Values of a contact at its state, N, F_x, F_y, T and the elastic force, and their derivatives
   !> by approach, its rate, sliding and spin. For a rigid contact N is given, and with it the
   !> approach.
   pure subroutine evaluate(law, touch, values, slopes, elastic)
      !> The law, its normal part as the curvatures have it.
      type(contact_law_type), intent(in) :: law
      !> The contact; of a rigid one the normal force is given.
      type(touch_type), intent(in) :: touch
      real(wp), intent(out) :: values(4)
      !> Their derivatives.
      real(wp), intent(out) :: slopes(4, 5)
      !> The elastic force [N].
      real(wp), intent(out) :: elastic
      real(wp) :: by_motion(3, 5)

      if (.not. touch%rigid) then
         elastic = law%normal%force(touch%spot%approach)
         call law%linearize(touch%spot, values, slopes)
         return
      end if
      elastic = 0.0_wp
      slopes = 0.0_wp
      values(1) = touch%values(1)
      values(2:4) = 0.0_wp
      if (.not. allocated(law%friction)) return
      call law%friction%linearize(law%normal%shape, law%sliding(values(1), &
         approach_of(law, values(1)), touch%spot%sliding, touch%spot%resolution), values(2:4), &
         by_motion)
      slopes(2:4, 3:5) = by_motion(:, 3:5)
   end subroutine evaluate

   !> The same of a compliant contact that rolls or whose parts own states: values, rates and their
   !> derivatives.
   subroutine evaluate_states(contact, touch, alone)
      type(contact_type), intent(inout) :: contact
      !> The contact at its state: the rest is set.
      type(touch_type), intent(inout) :: touch
      !> Whether the derivatives may be left as they are.
      logical, intent(in) :: alone
      real(wp) :: values(4 + most_states), slopes(4 + most_states, 5 + most_states)
      real(wp) :: scales(most_states)

      associate (law => contact%law, states => contact%states, n => contact%states%n_local)
         if (n > 0) scales(:n) = states%scales
         touch%elastic = law%normal%force(touch%spot%approach)
         touch%states = contact%local_states(touch%at)
         if (allocated(contact%tangential) .and. alone) then
            call law%vary_hold(touch%spot, touch%states(:n), states%scales, contact%tangential, &
               values(:4 + n))
            touch%values = values(:4)
            touch%rates(:n) = values(5:4 + n)
            return
         end if
         if (allocated(contact%tangential)) then
            call law%vary_hold(touch%spot, touch%states(:n), states%scales, contact%tangential, &
               values(:4 + n), slopes(:4 + n, :5 + n))
         else if (allocated(law%steady)) then
            call law%vary_roll(touch%spot, touch%states(:n), scales(:n), values(:4 + n), &
               slopes(:4 + n, :5 + n), touch%by_carried)
         else
            call law%vary(touch%spot, touch%states(:n), states%scales, values(:4 + n), &
               slopes(:4 + n, :5 + n))
         end if
         touch%values = values(:4)
         touch%slopes = slopes(:4, :5)
         touch%by_states(:, :n) = slopes(:4, 6:5 + n)
         touch%rates(:n) = values(5:4 + n)
         touch%rate_slopes(:n, :5 + n) = slopes(5:4 + n, :5 + n)
      end associate
   end subroutine evaluate_states

   !> Approach by which Hertz's theory has a normal force [m]; 0 for none.
   pure function approach_of(law, normal_force) result(approach)
      type(contact_law_type), intent(in) :: law
      !> Normal force [N].
      real(wp), intent(in) :: normal_force
      real(wp) :: approach

      approach = 0.0_wp
      if (normal_force > 0.0_wp) approach = law%normal%approach(normal_force)
   end function approach_of

   !> Load of a closed contact and its derivatives.
   subroutine vary_touch(touch, contact, a, b, load)
      !> The contact at its state: `at`, `rigid`, `varies`, the resolution and the approach, or the
      !> normal force and the accelerations, are set.
      type(touch_type), intent(inout) :: touch
      !> The contact; it is left as it was.
      type(contact_type), intent(inout) :: contact
      type(pose_type), intent(in) :: a
      type(pose_type), intent(in) :: b
      type(linear_load_type), intent(inout) :: load
      real(wp), parameter :: none(3) = 0.0_wp
      type(change_type) :: unchanged
      real(wp) :: e(3)
      integer :: k

      call set_touch(touch, contact, a, b)
      associate (arm_a => touch%arm_a, arm_b => touch%arm_b)
         load%force = touch%force
         load%torque_a = -touch%torque - cross(arm_a, touch%force)
         load%torque_b = touch%torque + cross(arm_b, touch%force)
         do k = 1, 3
            e = 0.0_wp
            e(k) = 1.0_wp
            call move(k, displacement_type(shift=-e, carry=e, shift_a=e))
            call move(3 + k, displacement_type(shift=-cross(e, arm_a), turn=-e, &
               carry=cross(e, arm_a), carry_turn=e))
            call speed_up(6 + k, -e, none)
            call speed_up(9 + k, -cross(e, arm_a), -e)
            call move(12 + k, displacement_type(shift=e, shift_b=e))
            call move(15 + k, displacement_type(shift=cross(e, arm_b), turn=e))
            call speed_up(18 + k, e, none)
            call speed_up(21 + k, cross(e, arm_b), e)
         end do
      end associate
      do k = 1, contact%states%n
         call vary_load(touch, contact, a, freedoms + k, unchanged, load)
      end do

   contains

      !> Variation with the poses.
      subroutine move(freedom, by)
         !> Which degree of freedom.
         integer, intent(in) :: freedom
         type(displacement_type), intent(in) :: by
         type(change_type) :: change

         call displace(touch, a, b, by, change)
         call vary_load(touch, contact, a, freedom, change, load)
      end subroutine move

      !> Variation with the velocities.
      subroutine speed_up(freedom, faster, faster_spin)
         !> Which degree of freedom.
         integer, intent(in) :: freedom
         !> Velocity of B against A at the contact point.
         real(wp), intent(in) :: faster(3)
         !> Angular velocity of B against A.
         real(wp), intent(in) :: faster_spin(3)
         type(change_type) :: change

         change%velocity = faster
         change%spin = faster_spin
         if (touch%rolls) change%carried = rolling_velocity(touch%variation, faster, faster_spin)
         call vary_load(touch, contact, a, freedom, change, load)
      end subroutine speed_up

   end subroutine vary_touch

   !> Values of a closed contact and their derivatives by what they depend on at once.
   subroutine set_touch(touch, contact, a, b)
      !> As for `vary_touch`; the rest is set.
      type(touch_type), intent(inout) :: touch
      !> The contact; it is left as it was.
      type(contact_type), intent(inout) :: contact
      type(pose_type), intent(in) :: a
      type(pose_type), intent(in) :: b

      call contact%law%geometry%vary(a, b, contact%track, touch%at, touch%variation)
      call relative_motion(a, b, touch%at%point, touch%velocity, touch%spin)
      touch%minor = cross(touch%at%normal, touch%at%major)
      touch%arm_a = touch%at%point - a%position
      touch%arm_b = touch%at%point - b%position
      touch%rolls = allocated(contact%law%steady)
      touch%spot%rate = -touch%gap_rate()
      touch%spot%sliding = along_axes(touch%contact_motion_type, touch%minor)
      touch%shape = 0.0_wp
      if (touch%rigid) touch%spot%approach = approach_of(contact%law, touch%values(1))
      if (contact%evolves) then
         touch%carried = rolling_velocity(touch%variation, merge(0.0_wp, touch%velocity, &
            allocated(contact%tangential)), touch%spin)
         touch%spot%carried = [dot_product(touch%carried, touch%at%major), &
            dot_product(touch%carried, touch%minor)]
         call evaluate_states(contact, touch, alone=.false.)
      else
         call evaluate(contact%law, touch, touch%values, touch%slopes, touch%elastic)
      end if
      if (touch%rolls) call differ_carried(contact, a, b, touch)
      if (touch%varies) then
         call differ_curvatures(contact, touch)
         if (.not. touch%rigid) then
            call contact%shape_force(a, b, touch%at, touch%shape)
            if (touch%exactly) then
               call differ_finely(contact, a, b, touch%at, touch%shape_by_twist)
            else
               call differ_shape_force(contact, a, b, touch%at, touch%shape, touch%shape_by_twist)
            end if
         end if
      end if
      if (contact%states%n > 0) touch%frame_spin = frame_spin(a, b, &
         touch%contact_motion_type, touch%variation)
      if (allocated(contact%law%curved)) then
         touch%along = [dot_product(touch%spin, touch%at%major), dot_product(touch%spin, &
            touch%minor)]
         call contact%law%bend(touch%spot, touch%along, touch%values, touch%slopes, touch%moment, &
            touch%moment_slopes, touch%by_rolling)
      end if
      touch%rolling = 0.0_wp
      if (allocated(contact%law%rolling)) touch%rolling = rolling_torque(contact%law, &
         touch%spot%approach, touch%values(1), touch%at%normal, touch%at%major, touch%spin)
      associate (at => touch%at, values => touch%values)
         touch%force = values(1)*at%normal + values(2)*at%major + values(3)*touch%minor &
            + touch%shape(1:3)
         touch%torque = values(4)*at%normal + touch%rolling + touch%shape(4:6)
         if (allocated(contact%law%curved)) touch%torque = touch%torque &
            + touch%moment(1)*at%major + touch%moment(2)*touch%minor
      end associate
   end subroutine set_touch

   !> Change of a contact with the poses of its bodies.
   pure subroutine displace(touch, a, b, by, change)
      type(touch_type), intent(in) :: touch
      type(pose_type), intent(in) :: a
      type(pose_type), intent(in) :: b
      type(displacement_type), intent(in) :: by
      type(change_type), intent(out) :: change
      real(wp) :: twist(6), point(3)

      twist = [by%shift, by%turn]
      if (touch%varies .and. .not. touch%rigid) then
         change%shape = matmul(touch%shape_by_twist, twist)
         change%shape(1:3) = change%shape(1:3) + cross(by%carry_turn, touch%shape(1:3))
         change%shape(4:6) = change%shape(4:6) + cross(by%carry_turn, touch%shape(4:6))
      end if
      associate (at => touch%at, variation => touch%variation, turning => touch%turning)
         point = matmul(variation%point, twist) + by%carry
         change%arm_a = point - by%shift_a
         change%arm_b = point - by%shift_b
         change%gap = dot_product(at%normal, by%shift)
         change%curvatures = [dot_product(variation%curvature_a, twist), &
            dot_product(variation%curvature_b, twist)]
         change%normal = matmul(variation%normal, twist)
         change%major = dot_product(variation%turn, twist)*touch%minor &
            - dot_product(at%major, change%normal)*at%normal + cross(by%carry_turn, at%major)
         change%normal = change%normal + cross(by%carry_turn, at%normal)
         ! The state has angular accelerations in the frames of the bodies, which turn.
         if (touch%rigid) change%acceleration = cross(turning(:, 2), change%arm_b) &
            + cross(cross(by%turn + by%carry_turn, turning(:, 2)), touch%arm_b) &
            - cross(turning(:, 1), change%arm_a) &
            - cross(cross(by%carry_turn, turning(:, 1)), touch%arm_a)
         change%velocity = cross(b%spin, change%arm_b) - cross(a%spin, change%arm_a)
         ! The pair as it was, turned with A, has the velocity turned back.
         if (touch%rolls) change%carried = matmul(touch%carried_by_twist, twist) &
            + cross(by%carry_turn, touch%carried) + rolling_velocity(variation, change%velocity &
            - cross(by%carry_turn, touch%velocity), -cross(by%carry_turn, touch%spin))
      end associate
   end subroutine displace

   !> Variation of the load.
   subroutine vary_load(touch, contact, a, freedom, d, load)
      type(touch_type), intent(in) :: touch
      type(contact_type), intent(in) :: contact
      type(pose_type), intent(in) :: a
      !> Which degree of freedom, or which state behind these.
      integer, intent(in) :: freedom
      !> That of the contact; `minor` and `motion` follow from the rest, and are set.
      type(change_type), intent(inout) :: d
      type(linear_load_type), intent(inout) :: load
      real(wp) :: d_values(4), d_force(3), d_torque(3), d_elastic, d_rolling(3), d_along(2)
      real(wp) :: d_moment(2)

      associate (at => touch%at, minor => touch%minor, velocity => touch%velocity, &
         spin => touch%spin, values => touch%values, outcome => load%slopes(:, freedom))
         d%minor = cross(d%normal, at%major) + cross(at%normal, d%major)
         d%motion(1) = -d%gap
         d%motion(2) = -dot_product(d%velocity, at%normal) - dot_product(velocity, d%normal)
         d%motion(3) = dot_product(d%velocity, at%major) + dot_product(velocity, d%major)
         d%motion(4) = dot_product(d%velocity, minor) + dot_product(velocity, d%minor)
         d%motion(5) = dot_product(d%spin, at%normal) + dot_product(spin, d%normal)
         d_values = matmul(touch%slopes, d%motion)
         if (allocated(contact%law%curved)) then
            d_along = [dot_product(d%spin, at%major) + dot_product(spin, d%major), &
               dot_product(d%spin, minor) + dot_product(spin, d%minor)]
            d_values(2:4) = d_values(2:4) + matmul(touch%by_rolling(1:3, :), d_along)
            d_moment = matmul(touch%moment_slopes, d%motion) &
               + matmul(touch%by_rolling(4:5, :), d_along)
         end if
         if (touch%rolls) d_values(2:4) = d_values(2:4) &
            + matmul(touch%by_carried, [dot_product(d%carried, at%major) &
            + dot_product(touch%carried, d%major), dot_product(d%carried, minor) &
            + dot_product(touch%carried, d%minor)])
         if (contact%states%n > 0) call vary_states(touch, contact, a, freedom, d, d_values, load)
         d_elastic = 0.0_wp
         if (.not. touch%rigid) d_elastic = -1.5_wp*touch%elastic/touch%spot%approach*d%gap
         if (touch%varies) then
            d_values = d_values + matmul(touch%by_curvature(1:4, :), d%curvatures)
            d_elastic = d_elastic + dot_product(touch%by_curvature(5, :), d%curvatures)
         end if
         d_force = d_values(1)*at%normal + values(1)*d%normal + d_values(2)*at%major &
            + values(2)*d%major + d_values(3)*minor + values(3)*d%minor
         d_torque = d_values(4)*at%normal + values(4)*d%normal
         if (touch%varies) then
            d_force = d_force + d%shape(1:3)
            d_torque = d_torque + d%shape(4:6)
         end if
         if (allocated(contact%law%curved)) d_torque = d_torque + d_moment(1)*at%major &
            + touch%moment(1)*d%major + d_moment(2)*minor + touch%moment(2)*d%minor
         d_rolling = 0.0_wp
         if (allocated(contact%law%rolling)) then
            d_rolling = vary_rolling(touch, contact%law, d, d_values(1))
            if (touch%varies) d_rolling = d_rolling + matmul(touch%rolling_by_curvature, &
               d%curvatures)
            d_torque = d_torque + d_rolling
         end if
         outcome(1:3) = d_force
         outcome(4:6) = -d_torque - cross(d%arm_a, touch%force) - cross(touch%arm_a, d_force)
         outcome(7:9) = d_torque + cross(d%arm_b, touch%force) + cross(touch%arm_b, d_force)
         outcome(10) = -(d_values(2)*dot_product(velocity, at%major) + values(2)*d%motion(3) &
            + d_values(3)*dot_product(velocity, minor) + values(3)*d%motion(4) &
            + d_values(4)*dot_product(spin, at%normal) + values(4)*d%motion(5)) &
            - dot_product(d_rolling, spin) - dot_product(touch%rolling, d%spin)
         if (allocated(contact%law%curved)) outcome(10) = outcome(10) &
            - dot_product(d_moment, touch%along) - dot_product(touch%moment, d_along)
         if (touch%rigid) then
            outcome(11) = 0.0_wp
            load%gap_slopes(1, freedom) = dot_product(d%normal, touch%acceleration) &
               + dot_product(at%normal, d%acceleration) &
               - touch%stabilisation(1)*d%motion(2) + touch%stabilisation(2)*d%gap
         else
            outcome(11) = (d_values(1) - d_elastic)*touch%spot%rate &
               + (values(1) - touch%elastic)*d%motion(2)
         end if
      end associate
   end subroutine vary_load

   !> Variation of the rates of the states of parts, and what the states add to that of the load.
   subroutine vary_states(touch, contact, a, freedom, d, d_values, load)
      type(touch_type), intent(in) :: touch
      type(contact_type), intent(in) :: contact
      type(pose_type), intent(in) :: a
      !> Which degree of freedom, or which state behind these.
      integer, intent(in) :: freedom
      type(change_type), intent(in) :: d
      !> Of N, F_x, F_y and T; added to.
      real(wp), intent(inout) :: d_values(4)
      type(linear_load_type), intent(inout) :: load
      real(wp) :: d_states(contact%states%n), d_local(contact%states%n_local)
      real(wp) :: along(contact%states%n_local), d_rates(contact%states%n_local)
      real(wp) :: twist(6), turning(3), of_a(3), of_b(3)

      associate (states => contact%states, n => contact%states%n_local, at => touch%at, &
         slopes => load%rate_slopes(:contact%states%n, freedom))
         d_states = 0.0_wp
         if (freedom > freedoms) d_states(freedom - freedoms) = 1.0_wp
         call states%gather(d_states, at%major, touch%minor, d_local)
         ! A number has no axes, and none of its variation: what is left is that of vectors.
         call states%gather(states%values, d%major, d%minor, along)
         where (states%vectors()) d_local = d_local + along
         d_values = d_values + matmul(touch%by_states(:, :n), d_local)
         d_rates = matmul(touch%rate_slopes(:n, :5), d%motion) &
            + matmul(touch%rate_slopes(:n, 6:5 + n), d_local)
         if (touch%varies) d_rates = d_rates &
            + matmul(touch%rates_by_curvature(:n, :), d%curvatures)
         slopes = 0.0_wp
         call states%scatter(d_rates, at%major, touch%minor, slopes)
         if (.not. states%tangent) return
         d_rates = touch%rates(:n)
         where (.not. states%vectors()) d_rates = 0.0_wp
         call states%scatter(d_rates, d%major, d%minor, slopes)
         call states%turn(d_states, touch%frame_spin, slopes)
         of_a = 0.0_wp
         of_b = 0.0_wp
         if (freedom > 9 .and. freedom <= 12) of_a(freedom - 9) = 1.0_wp
         if (freedom > 21 .and. freedom <= 24) of_b(freedom - 21) = 1.0_wp
         twist = [d%velocity, d%spin]
         turning = matmul(touch%variation%normal, twist)
         turning = turning + cross(of_a, at%normal) + cross(a%spin, d%normal)
         turning = cross(at%normal, turning) &
            + 0.5_wp*dot_product(of_a + of_b, at%normal)*at%normal
         call states%turn(states%values, turning, slopes)
      end associate
   end subroutine vary_states

   !> Variation of the torque of rolling resistance, by differences: it has no sharp scale but its
   !> regularisation.
   pure function vary_rolling(touch, law, d, d_load) result(d_moment)
      type(touch_type), intent(in) :: touch
      type(contact_law_type), intent(in) :: law
      type(change_type), intent(in) :: d
      !> Of the normal force.
      real(wp), intent(in) :: d_load
      real(wp) :: d_moment(3)
      real(wp) :: h, scale

      d_moment = 0.0_wp
      if (touch%values(1) > 0.0_wp) d_moment = touch%rolling*(d_load/touch%values(1))
      associate (at => touch%at, spin => touch%spin, load => touch%values(1), &
         approach => touch%spot%approach)
         if (law%rolling%follows_spot .and. .not. touch%rigid) then
            d_moment = d_moment - touch%rolling*(0.5_wp*d%gap/approach)
         end if
         scale = max(norm2(spin), law%rolling%regularization)
         h = norm2(d%normal) + norm2(d%major) + norm2(d%spin)/scale
         if (h <= 0.0_wp) return
         h = step*min(law%rolling%regularization/scale, 1.0_wp)/h
         d_moment = d_moment + (rolling_torque(law, approach, load, at%normal &
            + h*d%normal, at%major + h*d%major, spin + h*d%spin) - rolling_torque(law, &
            approach, load, at%normal - h*d%normal, at%major - h*d%major, spin &
            - h*d%spin))/(2.0_wp*h)
      end associate
   end function vary_rolling

   !> Torque of rolling resistance [N m].
   pure function rolling_torque(law, approach, normal_force, normal, major, relative) &
      result(moment)
      !> The law, its normal part as the curvatures have it.
      type(contact_law_type), intent(in) :: law
      !> Approach, or that by which Hertz's theory has the normal force [m].
      real(wp), intent(in) :: approach
      !> Normal force [N].
      real(wp), intent(in) :: normal_force
      real(wp), intent(in) :: normal(3)
      !> Major axis.
      real(wp), intent(in) :: major(3)
      !> Angular velocity of B against A [rad/s].
      real(wp), intent(in) :: relative(3)
      real(wp) :: moment(3), root

      moment = 0.0_wp
      ! A spot without size has no lever arm.
      if (law%rolling%follows_spot .and. .not. approach > 0.0_wp) return
      root = sqrt(approach)
      moment = law%rolling%torque(normal_force, normal, major, law%normal%axis_a*root, &
         law%normal%axis_b*root, relative)
   end function rolling_torque

   !> Derivatives of the force of the elastic energy through the curvatures by a twist of B at the
   !> contact point, by differences: they need no more than two digits, as the force is smaller than
   !> the normal force by the approach over the radii.
   subroutine differ_shape_force(contact, a, b, at, force, by_twist)
      !> The contact; it is left as it was.
      type(contact_type), intent(inout) :: contact
      type(pose_type), intent(in) :: a
      type(pose_type), intent(in) :: b
      !> Where it touches.
      type(contact_point_type), intent(in) :: at
      !> Force and torque there.
      real(wp), intent(in) :: force(6)
      !> The derivatives.
      real(wp), intent(out) :: by_twist(6, 6)
      type(track_type) :: track
      type(normal_type) :: normal
      type(pose_type) :: moved
      type(contact_point_type) :: there
      real(wp) :: h, twist(6), gap, varied(6)
      integer :: i, k, trouble

      track = contact%track
      normal = contact%law%normal
      by_twist = 0.0_wp
      do i = 1, 6
         h = shape_step*abs(at%gap)
         if (i > 3) h = h*2.0_wp*at%curvature_b
         twist = 0.0_wp
         twist(i) = h
         moved = b
         moved%position = b%position + twist(1:3) + cross(twist(4:6), b%position - at%point)
         do k = 1, 3
            moved%rotation(:, k) = b%rotation(:, k) + cross(twist(4:6), b%rotation(:, k))
         end do
         call contact%find_gap(a, moved, gap)
         call contact%locate(a, moved, gap, there)
         call contact%follow(there, trouble)
         if (trouble == trouble_none .and. gap < 0.0_wp) then
            call contact%shape_force(a, moved, there, varied)
            by_twist(:, i) = (varied - force)/h
         end if
         contact%track = track
         contact%law%normal = normal
      end do
   end subroutine differ_shape_force

   !> Derivatives of the force of the elastic energy through the curvatures by differences of fourth
   !> order, for what needs all digits.
   subroutine differ_finely(contact, a, b, at, by_twist)
      !> The contact; it is left as it was.
      type(contact_type), intent(inout) :: contact
      type(pose_type), intent(in) :: a
      type(pose_type), intent(in) :: b
      !> Where it touches.
      type(contact_point_type), intent(in) :: at
      !> The derivatives.
      real(wp), intent(out) :: by_twist(6, 6)
      integer, parameter :: offsets(4) = [-2, -1, 1, 2]
      real(wp), parameter :: weights(4) = [1.0_wp, -8.0_wp, 8.0_wp, -1.0_wp]/12.0_wp
      type(track_type) :: track
      type(normal_type) :: normal
      type(pose_type) :: moved
      type(contact_point_type) :: there
      real(wp) :: h, twist(6), gap, varied(6)
      integer :: i, k, trouble

      track = contact%track
      normal = contact%law%normal
      by_twist = 0.0_wp
      do i = 1, 6
         h = fine_step*abs(at%gap)
         ! A turn moves the point of contact by no more than a shift does.
         if (i > 3) h = h*2.0_wp*at%curvature_b
         do k = 1, size(offsets)
            twist = 0.0_wp
            twist(i) = offsets(k)*h
            moved = b
            call turn_about(moved, at%point, twist)
            call contact%find_gap(a, moved, gap)
            call contact%locate(a, moved, gap, there)
            call contact%follow(there, trouble)
            if (trouble == trouble_none .and. gap < 0.0_wp) then
               call contact%shape_force(a, moved, there, varied)
               by_twist(:, i) = by_twist(:, i) + weights(k)/h*varied
            end if
            contact%track = track
            contact%law%normal = normal
         end do
      end do
   end subroutine differ_finely

   !> Derivatives of the velocity of the material through the spot by a twist of B at the contact
   !> point, the velocities as they are, by central differences: they hold third derivatives of the
   !> surfaces.
   subroutine differ_carried(contact, a, b, touch)
      !> The contact; it is left as it was.
      type(contact_type), intent(inout) :: contact
      type(pose_type), intent(in) :: a
      type(pose_type), intent(in) :: b
      !> Its state; the derivatives are set.
      type(touch_type), intent(inout) :: touch
      type(track_type) :: track
      type(pose_type) :: moved
      type(contact_point_type) :: there
      type(contact_variation_type) :: variation
      real(wp) :: twist(6), h, gap, ends(3, 2)
      integer :: i, k

      track = contact%track
      do i = 1, 6
         h = pose_step
         if (i <= 3) h = h*0.5_wp/touch%at%curvature_b
         do k = 1, 2
            twist = 0.0_wp
            twist(i) = merge(h, -h, k == 1)
            moved = b
            call turn_about(moved, touch%at%point, twist)
            call contact%find_gap(a, moved, gap)
            call contact%locate(a, moved, gap, there)
            call contact%law%geometry%vary(a, moved, contact%track, there, variation)
            ends(:, k) = rolling_velocity(variation, touch%velocity, touch%spin)
            contact%track = track
         end do
         touch%carried_by_twist(:, i) = (ends(:, 1) - ends(:, 2))/(2.0_wp*h)
      end do
   end subroutine differ_carried

   !> Move a pose, and turn it about a point.
   pure subroutine turn_about(pose, point, twist)
      type(pose_type), intent(inout) :: pose
      real(wp), intent(in) :: point(3)
      !> Translation [m], then rotation [rad].
      real(wp), intent(in) :: twist(6)
      real(wp) :: rotation(3, 3)

      pose%position = pose%position + twist(1:3)
      if (.not. norm2(twist(4:6)) > 0.0_wp) return
      rotation = rotation_matrix(quaternion_from_axis_angle(twist(4:6), norm2(twist(4:6))))
      pose%position = point + matmul(rotation, pose%position - point)
      pose%rotation = matmul(rotation, pose%rotation)
   end subroutine turn_about

   !> Derivatives of N, F_x, F_y, T, the elastic force, the rates of states and the torque of
   !> rolling resistance by the curvatures A and B, by differences of the shape of the spot, which
   !> the wrench depends on smoothly.
   subroutine differ_curvatures(contact, touch)
      !> The contact; its normal part is left as it was.
      type(contact_type), intent(inout) :: contact
      !> Its state; the derivatives are set.
      type(touch_type), intent(inout) :: touch
      type(normal_type) :: normal
      type(touch_type) :: there
      real(wp) :: curvatures(2), varied(2), unused(4, 5), ends(2), rolling(3, 2), approach
      real(wp) :: results(5 + most_states, 2)
      integer :: i, k, n

      n = contact%states%n_local
      normal = contact%law%normal
      curvatures = [normal%curvature_a, normal%curvature_b]
      do i = 1, 2
         do k = 1, 2
            varied = curvatures
            varied(i) = varied(i)*(1.0_wp + merge(step, -step, k == 1))
            ! A <= B: one-sided at the circle.
            if (varied(1) > varied(2)) varied = curvatures
            ends(k) = varied(i)
            call contact%law%normal%follow(varied(1), varied(2))
            if (contact%evolves) then
               there = touch
               call evaluate_states(contact, there, alone=.true.)
               results(:5, k) = [there%values, there%elastic]
               results(6:5 + n, k) = there%rates(:n)
            else
               call evaluate(contact%law, touch, results(1:4, k), unused, results(5, k))
            end if
            if (.not. allocated(contact%law%rolling)) cycle
            approach = touch%spot%approach
            if (touch%rigid) approach = approach_of(contact%law, touch%values(1))
            rolling(:, k) = rolling_torque(contact%law, approach, touch%values(1), &
               touch%at%normal, touch%at%major, touch%spin)
         end do
         touch%by_curvature(:, i) = 0.0_wp
         touch%rates_by_curvature(:n, i) = 0.0_wp
         touch%rolling_by_curvature(:, i) = 0.0_wp
         if (ends(1) > ends(2)) then
            touch%by_curvature(:, i) = (results(:5, 1) - results(:5, 2))/(ends(1) - ends(2))
            ! Friction over a curved spot is dear, and changes by the approach over the radii.
            if (allocated(contact%law%curved)) touch%by_curvature(2:4, i) = 0.0_wp
            touch%rates_by_curvature(:n, i) = &
               (results(6:5 + n, 1) - results(6:5 + n, 2))/(ends(1) - ends(2))
            if (allocated(contact%law%rolling)) touch%rolling_by_curvature(:, i) = &
               (rolling(:, 1) - rolling(:, 2))/(ends(1) - ends(2))
         end if
      end do
      contact%law%normal = normal
   end subroutine differ_curvatures

   !> Derivatives of the second derivative of the gap that velocities make, by central differences.
   subroutine differ_bias(contact, link, a, b, slopes)
      !> The contact; it is left as it was.
      type(contact_type), intent(inout) :: contact
      type(link_type), intent(in) :: link
      type(pose_type), intent(in) :: a
      type(pose_type), intent(in) :: b
      !> Derivatives by the degrees of freedom.
      real(wp), intent(out) :: slopes(freedoms)
      type(pose_type) :: moved(2)
      type(track_type) :: track
      type(link_type) :: there
      real(wp), parameter :: unmoved(3, 2) = 0.0_wp
      real(wp) :: e(3), h, ends(2), length, speed, spin, gap
      integer :: i, k, side, kind

      track = contact%track
      there = link
      length = 0.5_wp/link%at%curvature_b
      ! The bias is quadratic in these, so that differences are exact, whatever the step.
      spin = max(norm2(a%spin), norm2(b%spin))
      speed = max(norm2(b%velocity - a%velocity), spin*length)
      if (.not. speed > 0.0_wp) speed = 1.0_wp
      if (.not. spin > 0.0_wp) spin = speed/length
      do side = 1, 2
         do kind = 1, 4
            select case (kind)
            case (1)
               h = pose_step*length
            case (2)
               h = pose_step*min(1.0_wp, length/max(norm2(link%arm(:, side)), length))
            case (3)
               h = speed
            case default
               h = spin
            end select
            do i = 1, 3
               e = 0.0_wp
               e(i) = 1.0_wp
               do k = 1, 2
                  moved = [a, b]
                  call shift_pose(moved(side), kind, merge(h, -h, k == 1)*e)
                  call contact%find_gap(moved(1), moved(2), gap)
                  call contact%locate(moved(1), moved(2), gap, there%at)
                  call set_kinematics(there, contact%law, contact%track, moved(1), moved(2), &
                     unmoved)
                  ends(k) = there%bias
                  contact%track = track
               end do
               slopes(12*(side - 1) + 3*(kind - 1) + i) = (ends(1) - ends(2))/(2.0_wp*h)
            end do
         end do
      end do
   end subroutine differ_bias

   !> Move a pose or its velocities.
   pure subroutine shift_pose(pose, kind, by)
      type(pose_type), intent(inout) :: pose
      !> 1 position [m], 2 rotation about the centre of mass [rad], 3 velocity [m/s], 4 angular
      !> velocity [rad/s].
      integer, intent(in) :: kind
      !> By how much, inertial frame.
      real(wp), intent(in) :: by(3)
      real(wp) :: rotation(3, 3)

      select case (kind)
      case (1)
         pose%position = pose%position + by
      case (2)
         rotation = rotation_matrix(quaternion_from_axis_angle(by, norm2(by)))
         pose%rotation = matmul(rotation, pose%rotation)
      case (3)
         pose%velocity = pose%velocity + by
      case default
         pose%spin = pose%spin + by
      end select
   end subroutine shift_pose

end module contensou_dynamics_linear_load
