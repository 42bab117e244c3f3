!> Contact law: the exchangeable parts of a contact, and the load they give together.
!>
!> A part that a scene does not name is absent, not zero: it is neither evaluated nor stored.
!> `evolve` and `vary` are `evaluate` and `linearize` of a law whose parts own states.
module contensou_contact_law
   use contensou_base_kinds, only : wp
   use contensou_base_vectors, only : cross
   use contensou_contact_creep_law, only : n_arguments, passing_type
   use contensou_contact_creep_steady, only : steady_type
   use contensou_contact_curved_spot, only : curved_spot_type
   use contensou_contact_damping_law, only : damping_type
   use contensou_contact_friction_law, only : friction_type, sliding_type
   use contensou_contact_geometry, only : contact_motion_type, contact_point_type, &
      geometry_type
   use contensou_contact_normal_law, only : normal_type
   use contensou_contact_rolling_law, only : rolling_type
   use contensou_contact_states, only : most_states
   use contensou_contact_tangential_memory, only : tangential_type
   implicit none(type, external)
   private

   public :: contact_law_type, contact_load_type, spot_motion_type, along_axes

   !> The parts.
   type :: contact_law_type
      !> Where the surfaces are closest.
      class(geometry_type), allocatable :: geometry
      !> Normal force.
      type(normal_type) :: normal
      !> Damping; unallocated for none.
      class(damping_type), allocatable :: damping
      !> Friction; unallocated for none.
      class(friction_type), allocatable :: friction
      !> Rolling resistance; unallocated for none.
      class(rolling_type), allocatable :: rolling
      !> Steady rolling; unallocated where the whole spot slides, or remembers.
      type(steady_type), allocatable :: steady
      !> Curvature of the spot; unallocated for a flat one.
      type(curved_spot_type), allocatable :: curved
      !> Largest approach that Hertz's theory admits [m].
      real(wp) :: largest_approach = 0.0_wp
      !> Numbers of state of damping, which come before those of friction.
      integer :: n_damping = 0
   contains
      procedure :: evaluate
      procedure :: linearize
      procedure :: evolve
      procedure :: vary
      procedure :: hold
      procedure :: vary_hold
      procedure :: roll
      procedure :: vary_roll
      procedure :: bend
      procedure, private :: press
      procedure :: push
      procedure, private :: passing
      procedure, private :: vary_press
      procedure :: sliding
   end type contact_law_type

   !> How a spot is pressed and moved along its axes: what a law is linearized about.
   type :: spot_motion_type
      !> Approach d [m], > 0.
      real(wp) :: approach = 0.0_wp
      !> Its rate [m/s].
      real(wp) :: rate = 0.0_wp
      !> Sliding velocity along the axes [m/s], spin [rad/s].
      real(wp) :: sliding(3) = 0.0_wp
      !> Velocity of the material through the spot along the axes [m/s].
      real(wp) :: carried(2) = 0.0_wp
      !> Square of the velocity below which sliding is not resolved [m2/s2], 0 if all is.
      real(wp) :: resolution = 0.0_wp
   end type spot_motion_type

   !> What a closed contact does to body B (and, reversed, to body A).
   type :: contact_load_type
      !> Normal force N [N], >= 0.
      real(wp) :: normal_force = 0.0_wp
      !> Friction force on B [N], inertial frame.
      real(wp) :: friction_force(3) = 0.0_wp
      !> Friction torque on B about the normal [N m].
      real(wp) :: friction_torque = 0.0_wp
      !> Torque of rolling resistance on B [N m], inertial frame, in the tangent plane.
      real(wp) :: rolling_torque(3) = 0.0_wp
      !> Moment of friction on B over a curved spot [N m], inertial frame, in the tangent plane.
      real(wp) :: curvature_moment(3) = 0.0_wp
      !> Power that friction and rolling resistance take [W]: lost, >= 0, unless states store some.
      real(wp) :: friction_power = 0.0_wp
      !> Power that damping takes [W], lost as well.
      real(wp) :: damping_power = 0.0_wp
   end type contact_load_type

contains

   !> Load of a closed contact.
   pure subroutine evaluate(self, now, resolution, load)
      class(contact_law_type), intent(in) :: self
      !> Where the contact is, its gap < 0, and how it moves.
      type(contact_motion_type), intent(in) :: now
      !> Square of the velocity below which sliding is not resolved [m2/s2], 0 if all is.
      real(wp), intent(in) :: resolution
      type(contact_load_type), intent(out) :: load
      type(sliding_type) :: slides
      real(wp) :: approach, rate, elastic, minor(3), wrench(3)

      approach = -now%at%gap
      elastic = self%normal%force(approach)
      load%normal_force = elastic
      if (allocated(self%damping)) then
         rate = -now%gap_rate()
         load%normal_force = self%damping%total(elastic, approach, rate)
         load%damping_power = (load%normal_force - elastic)*rate
      end if
      if (allocated(self%friction)) then
         minor = cross(now%at%normal, now%at%major)
         slides = sliding_type(load%normal_force, self%normal%major_axis(approach), &
            dot_product(now%velocity, now%at%major), dot_product(now%velocity, minor), &
            dot_product(now%spin, now%at%normal), resolution)
         if (allocated(self%curved)) then
            call rub_curved(self, now, minor, slides, load)
         else
            call self%friction%wrench(self%normal%shape, slides, wrench)
            call take_friction(now%at, minor, slides, wrench, load)
         end if
      end if
      if (allocated(self%rolling)) call add_rolling(self, now, load)
   end subroutine evaluate

   !> Put the wrench of friction into a load.
   pure subroutine take_friction(at, minor, slides, wrench, load)
      type(contact_point_type), intent(in) :: at
      !> Unit tangent along the minor axis of the spot.
      real(wp), intent(in) :: minor(3)
      type(sliding_type), intent(in) :: slides
      !> Force along the major and the minor axis [N], torque about the normal [N m].
      real(wp), intent(in) :: wrench(3)
      type(contact_load_type), intent(inout) :: load

      load%friction_force = wrench(1)*at%major + wrench(2)*minor
      load%friction_torque = wrench(3)
      load%friction_power = -(wrench(1)*slides%vx + wrench(2)*slides%vy + wrench(3)*slides%w)
   end subroutine take_friction

   !> Put friction over a curved spot into a load.
   pure subroutine rub_curved(self, now, minor, slides, load)
      class(contact_law_type), intent(in) :: self
      type(contact_motion_type), intent(in) :: now
      !> Unit tangent along the minor axis of the spot.
      real(wp), intent(in) :: minor(3)
      type(sliding_type), intent(in) :: slides
      type(contact_load_type), intent(inout) :: load
      real(wp) :: wrench(3), moment(2)

      associate (at => now%at, spin => now%spin)
         call self%curved%wrench(self%normal%shape, slides, [dot_product(spin, at%major), &
            dot_product(spin, minor)], wrench, moment)
         call take_friction(at, minor, slides, wrench, load)
         load%curvature_moment = moment(1)*at%major + moment(2)*minor
         load%friction_power = load%friction_power - dot_product(load%curvature_moment, spin)
      end associate
   end subroutine rub_curved

   !> Add rolling resistance to a load.
   pure subroutine add_rolling(self, now, load)
      type(contact_law_type), intent(in) :: self
      type(contact_motion_type), intent(in) :: now
      type(contact_load_type), intent(inout) :: load
      real(wp) :: root

      root = sqrt(-now%at%gap)
      load%rolling_torque = self%rolling%torque(load%normal_force, now%at%normal, now%at%major, &
         self%normal%axis_a*root, self%normal%axis_b*root, now%spin)
      load%friction_power = load%friction_power - dot_product(load%rolling_torque, now%spin)
   end subroutine add_rolling

   !> Load of a closed contact at given states, and the rates of these.
   pure subroutine evolve(self, now, resolution, states, load, rates)
      class(contact_law_type), intent(in) :: self
      !> Where the contact is, its gap < 0, and how it moves.
      type(contact_motion_type), intent(in) :: now
      !> Square of the velocity below which sliding is not resolved [m2/s2], 0 if all is.
      real(wp), intent(in) :: resolution
      !> States of damping, then of friction.
      real(wp), intent(in) :: states(:)
      type(contact_load_type), intent(out) :: load
      !> Time derivatives of the states.
      real(wp), intent(out) :: rates(:)
      type(sliding_type) :: slides
      real(wp) :: minor(3), wrench(3)

      call self%press(now, states(:self%n_damping), load, rates(:self%n_damping))
      if (allocated(self%friction)) then
         minor = cross(now%at%normal, now%at%major)
         slides = self%sliding(load%normal_force, -now%at%gap, along_axes(now, minor), resolution)
         if (allocated(self%curved)) then
            call rub_curved(self, now, minor, slides, load)
         else
            call self%friction%evolve(self%normal%shape, slides, states(self%n_damping + 1:), &
               wrench, rates(self%n_damping + 1:))
            call take_friction(now%at, minor, slides, wrench, load)
         end if
      end if
      if (allocated(self%rolling)) call add_rolling(self, now, load)
   end subroutine evolve

   !> Normal force as it would be if the contact could pull, without the states of its damping [N].
   pure real(wp) function push(self, approach, rate)
      class(contact_law_type), intent(in) :: self
      !> Approach d [m], >= 0.
      real(wp), intent(in) :: approach
      !> Its rate [m/s].
      real(wp), intent(in) :: rate

      push = self%normal%force(approach)
      if (allocated(self%damping)) push = push + self%damping%force(push, approach, rate)
   end function push

   !> Normal force of a closed contact at given states, and the rates of these.
   pure subroutine press(self, now, states, load, rates)
      class(contact_law_type), intent(in) :: self
      type(contact_motion_type), intent(in) :: now
      !> States of damping.
      real(wp), intent(in) :: states(:)
      type(contact_load_type), intent(inout) :: load
      !> Time derivatives of the states.
      real(wp), intent(out) :: rates(:)
      real(wp) :: approach, rate, elastic, force

      approach = -now%at%gap
      elastic = self%normal%force(approach)
      load%normal_force = elastic
      if (.not. allocated(self%damping)) return
      rate = -now%gap_rate()
      call self%damping%evolve(elastic, approach, rate, states, force, rates)
      load%normal_force = max(elastic + force, 0.0_wp)
      load%damping_power = (load%normal_force - elastic)*rate
   end subroutine press

   !> Load of a closed contact with tangential elasticity, and the rates of its states.
   pure subroutine hold(self, now, carried, states, tangential, load, rates)
      class(contact_law_type), intent(in) :: self
      !> Where the contact is, its gap < 0, and how it moves.
      type(contact_motion_type), intent(in) :: now
      !> Velocity of the material through the spot [m/s].
      real(wp), intent(in) :: carried(3)
      !> States of damping, then of tangential elasticity.
      real(wp), intent(in) :: states(:)
      type(tangential_type), intent(inout) :: tangential
      type(contact_load_type), intent(out) :: load
      !> Time derivatives of the states.
      real(wp), intent(out) :: rates(:)
      type(passing_type) :: rolls
      real(wp) :: minor(3), wrench(3)

      call self%press(now, states(:self%n_damping), load, rates(:self%n_damping))
      minor = cross(now%at%normal, now%at%major)
      rolls = self%passing(load%normal_force, now, minor, carried, 0.0_wp)
      call tangential%evolve(self%friction, self%normal%shape, rolls, &
         states(self%n_damping + 1:), wrench, rates(self%n_damping + 1:))
      call take_friction(now%at, minor, rolls%sliding_type, wrench, load)
      if (allocated(self%rolling)) call add_rolling(self, now, load)
   end subroutine hold

   !> Load of a closed contact in steady rolling, and the rates of the states of damping.
   pure subroutine roll(self, now, carried, resolution, states, load, rates)
      class(contact_law_type), intent(in) :: self
      !> Where the contact is, its gap < 0, and how it moves.
      type(contact_motion_type), intent(in) :: now
      !> Velocity of the material through the spot [m/s].
      real(wp), intent(in) :: carried(3)
      !> Square of the velocity below which motion is not resolved [m2/s2], 0 if all is.
      real(wp), intent(in) :: resolution
      !> States of damping.
      real(wp), intent(in) :: states(:)
      type(contact_load_type), intent(out) :: load
      !> Time derivatives of the states.
      real(wp), intent(out) :: rates(:)
      type(passing_type) :: rolls
      real(wp) :: minor(3), wrench(3)

      call self%press(now, states, load, rates)
      minor = cross(now%at%normal, now%at%major)
      rolls = self%passing(load%normal_force, now, minor, carried, resolution)
      call self%steady%wrench(self%normal%shape, rolls, wrench)
      call take_friction(now%at, minor, rolls%sliding_type, wrench, load)
      if (allocated(self%rolling)) call add_rolling(self, now, load)
   end subroutine roll

   !> Sliding velocity along the axes of the spot [m/s], and spin about the normal [rad/s].
   pure function along_axes(now, minor) result(motion)
      type(contact_motion_type), intent(in) :: now
      !> Unit tangent along the minor axis of the spot.
      real(wp), intent(in) :: minor(3)
      real(wp) :: motion(3)

      motion(1) = dot_product(now%velocity, now%at%major)
      motion(2) = dot_product(now%velocity, minor)
      motion(3) = dot_product(now%spin, now%at%normal)
   end function along_axes

   !> What slides, and what rolls through the spot, at a normal force.
   pure function passing(self, load, now, minor, carried, resolution) result(rolls)
      class(contact_law_type), intent(in) :: self
      !> Normal force [N], >= 0.
      real(wp), intent(in) :: load
      type(contact_motion_type), intent(in) :: now
      !> Unit tangent along the minor axis of the spot.
      real(wp), intent(in) :: minor(3)
      !> Velocity of the material through the spot [m/s].
      real(wp), intent(in) :: carried(3)
      !> Square of the velocity below which sliding is not resolved [m2/s2], 0 if all is.
      real(wp), intent(in) :: resolution
      type(passing_type) :: rolls

      rolls%sliding_type = self%sliding(load, -now%at%gap, along_axes(now, minor), resolution)
      rolls%cx = dot_product(carried, now%at%major)
      rolls%cy = dot_product(carried, minor)
   end function passing

   !> What slides at a normal force.
   pure function sliding(self, load, approach, motion, resolution) result(slides)
      class(contact_law_type), intent(in) :: self
      !> Normal force [N], >= 0.
      real(wp), intent(in) :: load
      !> Approach d [m], >= 0.
      real(wp), intent(in) :: approach
      !> Sliding velocity along the axes [m/s], spin [rad/s].
      real(wp), intent(in) :: motion(3)
      !> Square of the velocity below which sliding is not resolved [m2/s2], 0 if all is.
      real(wp), intent(in) :: resolution
      type(sliding_type) :: slides

      slides = sliding_type(load, self%normal%major_axis(approach), motion(1), motion(2), &
         motion(3), resolution)
   end function sliding

   !> Normal force, friction force along the major and the minor axis, and friction torque about the
   !> normal, with their derivatives by the approach [m], its rate [m/s], the sliding velocities
   !> along the two axes [m/s] and the spin [rad/s], at constant curvatures.
   pure subroutine linearize(self, at, values, slopes)
      class(contact_law_type), intent(in) :: self
      type(spot_motion_type), intent(in) :: at
      !> N, F_x, F_y [N], T [N m].
      real(wp), intent(out) :: values(4)
      !> Derivative of value i by d, d', v_x, v_y, w.
      real(wp), intent(out) :: slopes(4, 5)
      type(sliding_type) :: slides
      real(wp) :: elastic, by_elastic(3), by_motion(3, 5)

      values = 0.0_wp
      slopes = 0.0_wp
      elastic = self%normal%force(at%approach)
      values(1) = elastic
      slopes(1, 1) = 1.5_wp*elastic/at%approach
      if (allocated(self%damping)) then
         values(1) = self%damping%total(elastic, at%approach, at%rate)
         if (values(1) > 0.0_wp) then
            by_elastic = self%damping%slopes(elastic, at%approach, at%rate)
            slopes(1, 1) = slopes(1, 1)*(1.0_wp + by_elastic(1)) + by_elastic(2)
            slopes(1, 2) = by_elastic(3)
         else
            slopes(1, 1) = 0.0_wp
         end if
      end if
      if (.not. allocated(self%friction)) return
      slides = self%sliding(values(1), at%approach, at%sliding, at%resolution)
      call self%friction%linearize(self%normal%shape, slides, values(2:4), by_motion)
      slopes(2:4, 1) = by_motion(:, 1)*slopes(1, 1) + by_motion(:, 2)*(0.5_wp*slides%a/at%approach)
      slopes(2:4, 2) = by_motion(:, 1)*slopes(1, 2)
      slopes(2:4, 3:5) = by_motion(:, 3:5)
   end subroutine linearize

   !> Friction over a curved spot at a normal force whose derivatives are known: replaces that of a
   !> flat one in values and derivatives, and gives what is more.
   pure subroutine bend(self, at, rolling, values, slopes, moment, moment_slopes, by_rolling)
      class(contact_law_type), intent(in) :: self
      type(spot_motion_type), intent(in) :: at
      !> Angular velocity of B against A along the axes of the spot [rad/s].
      real(wp), intent(in) :: rolling(2)
      !> N, F_x, F_y [N], T [N m].
      real(wp), intent(inout) :: values(4)
      !> Derivative of value i by d, d', v_x, v_y, w.
      real(wp), intent(inout) :: slopes(4, 5)
      !> Moment along the axes [N m], and its derivatives likewise.
      real(wp), intent(out) :: moment(2), moment_slopes(2, 5)
      !> Derivatives of F_x, F_y, T and the moment by `rolling`.
      real(wp), intent(out) :: by_rolling(5, 2)
      type(sliding_type) :: slides
      real(wp) :: friction(5), by_motion(5, 7), all_slopes(5, 5)

      slides = self%sliding(values(1), at%approach, at%sliding, at%resolution)
      call self%curved%linearize(self%normal%shape, slides, rolling, friction, by_motion)
      all_slopes(:, 1) = by_motion(:, 1)*slopes(1, 1) &
         + by_motion(:, 2)*(0.5_wp*slides%a/at%approach)
      all_slopes(:, 2) = by_motion(:, 1)*slopes(1, 2)
      all_slopes(:, 3:5) = by_motion(:, 3:5)
      values(2:4) = friction(1:3)
      slopes(2:4, :) = all_slopes(1:3, :)
      moment = friction(4:5)
      moment_slopes = all_slopes(4:5, :)
      by_rolling = by_motion(:, 6:7)
   end subroutine bend

   !> Normal force, friction force along the major and the minor axis, friction torque about the
   !> normal and rates of the states, with their derivatives by the approach [m], its rate [m/s],
   !> the sliding velocities along the two axes [m/s], the spin [rad/s] and the states, at constant
   !> curvatures.
   pure subroutine vary(self, at, states, scales, values, slopes)
      class(contact_law_type), intent(in) :: self
      type(spot_motion_type), intent(in) :: at
      !> States of damping, then of friction.
      real(wp), intent(in) :: states(:)
      !> Values against which they count as small.
      real(wp), intent(in) :: scales(:)
      !> N, F_x, F_y [N], T [N m], then the rates.
      real(wp), intent(out) :: values(:)
      !> Derivative of value i by d, d', v_x, v_y, w, then by the states.
      real(wp), intent(out) :: slopes(:, :)
      type(sliding_type) :: slides
      real(wp) :: by_motion(3 + most_states, 5 + most_states)
      integer :: nd, nf

      nd = self%n_damping
      nf = size(states) - nd
      call self%vary_press(at, states(:nd), scales(:nd), values, slopes)
      if (.not. allocated(self%friction)) return
      slides = self%sliding(values(1), at%approach, at%sliding, at%resolution)
      call self%friction%vary(self%normal%shape, slides, states(nd + 1:), scales(nd + 1:), &
         values(2:4), values(5 + nd:), by_motion(:3 + nf, :5 + nf))
      call chain(nd, nf, slides%a, at%approach, by_motion, slopes)
   end subroutine vary

   !> The same with tangential elasticity.
   pure subroutine vary_hold(self, at, states, scales, tangential, values, slopes)
      class(contact_law_type), intent(in) :: self
      type(spot_motion_type), intent(in) :: at
      !> States of damping, then of tangential elasticity.
      real(wp), intent(in) :: states(:)
      !> Values against which they count as small.
      real(wp), intent(in) :: scales(:)
      type(tangential_type), intent(inout) :: tangential
      !> N, F_x, F_y [N], T [N m], then the rates.
      real(wp), intent(out) :: values(:)
      !> Derivative of value i by d, d', v_x, v_y, w, then by the states; they are dear.
      real(wp), intent(out), optional :: slopes(:, :)
      type(passing_type) :: rolls
      real(wp) :: by_motion(3 + most_states, 5 + most_states)
      real(wp) :: by_press(4 + most_states, 5 + most_states)
      integer :: nd, nf

      nd = self%n_damping
      nf = size(states) - nd
      call self%vary_press(at, states(:nd), scales(:nd), values, by_press(:size(values), &
         :5 + size(states)))
      rolls = passing_type(self%sliding(values(1), at%approach, at%sliding, 0.0_wp), &
         at%carried(1), at%carried(2))
      if (.not. present(slopes)) then
         call tangential%evolve(self%friction, self%normal%shape, rolls, states(nd + 1:), &
            values(2:4), values(5 + nd:))
         return
      end if
      slopes = by_press(:size(values), :5 + size(states))
      call tangential%vary(self%friction, self%normal%shape, rolls, states(nd + 1:), &
         values(2:4), values(5 + nd:), by_motion(:3 + nf, :5 + nf))
      call chain(nd, nf, rolls%a, at%approach, by_motion, slopes)
   end subroutine vary_hold

   !> The same in steady rolling, and the derivatives of the wrench by the velocity of the material.
   pure subroutine vary_roll(self, at, states, scales, values, slopes, by_carried)
      class(contact_law_type), intent(in) :: self
      type(spot_motion_type), intent(in) :: at
      !> States of damping.
      real(wp), intent(in) :: states(:)
      !> Values against which they count as small.
      real(wp), intent(in) :: scales(:)
      !> N, F_x, F_y [N], T [N m], then the rates.
      real(wp), intent(out) :: values(:)
      !> Derivative of value i by d, d', v_x, v_y, w, then by the states.
      real(wp), intent(out) :: slopes(:, :)
      !> Derivative of F_x, F_y, T by the velocity of the material.
      real(wp), intent(out) :: by_carried(3, 2)
      type(passing_type) :: rolls
      real(wp) :: by_motion(3, n_arguments)

      call self%vary_press(at, states, scales, values, slopes)
      rolls = passing_type(self%sliding(values(1), at%approach, at%sliding, at%resolution), &
         at%carried(1), at%carried(2))
      call self%steady%linearize(self%friction, self%normal%shape, rolls, values(2:4), by_motion)
      call chain(size(states), 0, rolls%a, at%approach, by_motion(:, :5), slopes)
      by_carried = by_motion(:, 6:7)
   end subroutine vary_roll

   !> Complete derivatives by approach and rate from those of friction by load and size of the spot.
   pure subroutine chain(nd, nf, a, approach, by_motion, slopes)
      !> Numbers of state of damping and of friction.
      integer, intent(in) :: nd, nf
      !> Major semi-axis and approach [m].
      real(wp), intent(in) :: a, approach
      !> Derivatives of friction and of the rates of its states by N, a, v_x, v_y, w, states.
      real(wp), intent(in) :: by_motion(:, :)
      real(wp), intent(inout) :: slopes(:, :)
      integer :: i, row

      do i = 1, 3 + nf
         row = merge(1, 1 + nd, i <= 3) + i
         slopes(row, :) = by_motion(i, 1)*slopes(1, :)
         slopes(row, 1) = slopes(row, 1) + by_motion(i, 2)*(0.5_wp*a/approach)
         slopes(row, 3:5) = by_motion(i, 3:5)
         slopes(row, 6 + nd:) = by_motion(i, 6:5 + nf)
      end do
   end subroutine chain

   !> Normal force and the rates of the states of damping, with their derivatives; zeros else.
   pure subroutine vary_press(self, at, states, scales, values, slopes)
      class(contact_law_type), intent(in) :: self
      type(spot_motion_type), intent(in) :: at
      !> States of damping.
      real(wp), intent(in) :: states(:)
      !> Values against which they count as small.
      real(wp), intent(in) :: scales(:)
      real(wp), intent(out) :: values(:)
      real(wp), intent(out) :: slopes(:, :)
      real(wp) :: elastic, stiffness, force
      real(wp) :: by_normal(1 + most_states, 3 + most_states)
      integer :: nd, i, row

      nd = self%n_damping
      values = 0.0_wp
      slopes = 0.0_wp
      elastic = self%normal%force(at%approach)
      stiffness = 1.5_wp*elastic/at%approach
      values(1) = elastic
      slopes(1, 1) = stiffness
      if (allocated(self%damping)) then
         call self%damping%vary(elastic, at%approach, at%rate, states, scales, force, &
            values(5:4 + nd), by_normal(:1 + nd, :3 + nd))
         values(1) = max(elastic + force, 0.0_wp)
         do i = 0, nd
            row = merge(1, 4 + i, i == 0)
            slopes(row, 1) = by_normal(1 + i, 1)*stiffness + by_normal(1 + i, 2)
            slopes(row, 2) = by_normal(1 + i, 3)
            slopes(row, 6:5 + nd) = by_normal(1 + i, 4:3 + nd)
         end do
         slopes(1, 1) = slopes(1, 1) + stiffness
         if (.not. values(1) > 0.0_wp) slopes(1, :) = 0.0_wp
      end if
   end subroutine vary_press

end module contensou_contact_law
