!> Tangential elasticity of a contact in a run: what it remembers, and the wrench that follows from
!> that and from the state.
!>
!> Memory changes at accepted steps only. Within a step the wrench is a function of the state: shift
!> and twist since the last accepted step are differences of states that are integrated with the
!> motion, and the shells (`contensou_contact_tangential_shells`) are moved by these from what they
!> remember. The states are
!> - a unit tangent, the axis, that follows the normal and turns about it by the mean of the two
!>   bodies: what is remembered has its components along it and across it, so that the law is
!>   objective;
!> - the shift of the bodies against each other along the axis and across it, and the twist;
!> - the way of the material through the spot, over the length of relaxation in units of the major
!>   semi-axis: rolling carries strained material out, exp(-way/a) of it is left. (Over the length
!>   itself its rate would be infinite where surfaces touch.)
!> With a law of creep (`contensou_contact_tangential_carry`) the way has no effect. The shifts and
!> the twist are then what is left of them when the creep is taken off, and the creepage that the
!> material carries out of the spot is a state, along the axes of the spot.
!>
!> Where the bodies have slid by many times what the spot can be strained, in the direction in which
!> they slide now and with nothing that stuck, the wrench is that of sliding (`share` 1).
module contensou_contact_tangential_memory
   use contensou_base_checkpoint, only : checkpoint_type
   use contensou_base_kinds, only : wp
   use contensou_contact_creep_law, only : passing_type
   use contensou_contact_friction_law, only : changed, friction_type, sliding_type
   use contensou_contact_spot, only : spot_shape_type
   use contensou_contact_states, only : against_length, state_list_type
   use contensou_contact_tangential_carry, only : carried_type, carry_type
   use contensou_contact_tangential_shells, only : make_room, shells_type, spring_spot_type
   use contensou_special_smooth_step, only : smooth_step
   implicit none(type, external)
   private

   public :: tangential_type, put_tangential_states, put_carried_states, n_states, unit_axis

   !> Which derivative is the one by the first component of the axis.
   integer, parameter :: of_axis = 6

   !> Numbers of state without a law of creep, and with one.
   integer, parameter :: n_states = 6, n_all_states = n_states + 3

   !> Shift since something stuck, over what the whole spot can be strained, from which on sliding
   !> begins to take over, and from which on nothing else is left.
   real(wp), parameter :: long_shift(2) = [12.0_wp, 24.0_wp]

   !> Shift that is remembered, likewise: more than the longest of these, as limits change.
   real(wp), parameter :: longest_shift = 36.0_wp

   !> Cosine between that shift and the sliding velocity, likewise.
   real(wp), parameter :: aligned(2) = [0.9_wp, 0.99_wp]

   !> How far a wrench may be from that of full sliding, over the limit, less than 1: all slips from
   !> the latter on. The share of the limit from which on that is asked, and the sliding that is not
   !> carried, over the velocity times the creepage f p0/G, of which half of it counts.
   real(wp), parameter :: sliding_through(2) = [0.92_wp, 0.99_wp], much = 0.8_wp, &
      little_sliding = 0.1_wp

   !> That sliding likewise, from which on it has the direction of the wrench.
   real(wp), parameter :: distinct_sliding(2) = [0.2_wp, 1.0_wp]

   !> What a force may lag behind, over its limit, for sliding to take over.
   real(wp), parameter :: largest_lag = 1.0e-4_wp

   !> That over the angle by which sliding turns within a strain: the mean displacement of springs
   !> side by side that slide, over what the spot can be strained.
   real(wp), parameter :: lag_of_turn = 1.2_wp

   !> Step of differences, over what the spot can be strained.
   real(wp), parameter :: step_of_differences = 1.0e-5_wp

   !> Way in units of the length of relaxation below which series are used.
   real(wp), parameter :: short_way = 1.0e-3_wp

   !> Semi-axis of a spot over the length scale of a scene, a tenth of an overlap: about.
   real(wp), parameter :: axis_over_length = 1.0e3_wp

   !> Creepage f p0/G of steel: about.
   real(wp), parameter :: creepage_scale = 1.0e-3_wp

   !> The same of spin, over the semi-axis of a spot of a centimetre in radius [1/m].
   real(wp), parameter :: spin_creepage_scale = 1.0_wp

   !> Way in units of the length of relaxation of which nothing is left.
   real(wp), parameter :: long_way = 1.0e3_wp

   !> Number of arguments of a move of the shells.
   integer, parameter :: n_arguments = 16

   !> Tangential elasticity of a contact.
   type :: tangential_type
      !> Friction coefficient f [-].
      real(wp) :: coefficient = 0.0_wp
      !> Shear modulus [Pa] and Poisson's ratio of both bodies together.
      real(wp) :: modulus = 0.0_wp, poisson = 0.0_wp
      !> Least force that counts [N]: errors of the memory are measured against it or the limit.
      real(wp) :: reference = 0.0_wp
      !> Whether there is a torque about the normal.
      logical :: drilling = .true.
      !> What rolling carries out; unallocated where strain only fades.
      type(carry_type), allocatable :: carry
      !> What is remembered, along the axis and across it; the same at the last state that was
      !> evaluated, along the axes of its spot; and room for a step in two halves.
      type(shells_type) :: past, now, half, whole
      !> Shifts, twist and way at the last accepted step, and their rates.
      real(wp) :: anchor(4) = 0.0_wp, rates(4) = 0.0_wp
      !> Shifts and twist of the sliding up to there.
      real(wp) :: slid(3) = 0.0_wp
      !> Limit [N] and size of the spot [m] there.
      real(wp) :: limit = 0.0_wp, a = 0.0_wp
      !> Of the last state that was evaluated: the spot; step and its rates, as `anchor`; the axis
      !> seen from the axes of the shells; sliding velocity and spin; share of sliding.
      type(spring_spot_type) :: spot
      real(wp) :: step(4) = 0.0_wp, step_rates(4) = 0.0_wp
      !> Rates of shifts and twist as far as they are known before the wrench is, and how sure they
      !> are, from 0 to 1: with a law of creep not all of them is.
      real(wp), private :: foreseen(3) = 0.0_wp, sure = 1.0_wp
      real(wp) :: axis(2) = [1.0_wp, 0.0_wp]
      real(wp) :: velocity(3) = 0.0_wp
      real(wp) :: share = 0.0_wp
      !> How far all slips by what rolling does not carry out, from 0 to 1; with a law of creep.
      real(wp), private :: slips = 0.0_wp
      !> Wrench of the last state, along the axes of the shells [N, N m].
      real(wp) :: wrench(3) = 0.0_wp
      !> Whether the state that is evaluated may be the last one again.
      logical :: may_be_same = .false.
      !> Whether `now` is what `past` becomes by a move, its arguments, and what it bears.
      logical, private :: is_moved = .false.
      real(wp), private :: moved(n_arguments) = 0.0_wp, bears(3) = 0.0_wp
   contains
      procedure :: begin
      procedure :: forget
      procedure :: is_loaded
      procedure :: free_rates
      procedure :: evolve
      procedure :: vary
      procedure :: tell
      procedure :: part
      procedure :: deviate
      procedure :: keep
      procedure :: exchange
      procedure, private :: move
      procedure, private :: sliding_share
      procedure, private :: way_rate
   end type tangential_type

contains

   !> Shifts, twist and the way rolled, along a tangent that turns with the material.
   subroutine put_tangential_states(list)
      type(state_list_type), intent(inout) :: list

      call list%put("tangential_axis", "1", "tangent that turns about the normal with the " // &
         "material: shift_along is measured along it", 1.0_wp, tangent=.true.)
      call list%put("shift_along", "m", "shift of B against A along tangential_axis", 1.0_wp, &
         against_length, absolute=.true.)
      call list%put("shift_across", "m", "shift of B against A across tangential_axis", 1.0_wp, &
         against_length, absolute=.true.)
      call list%put("twist", "rad", "twist of B against A about the normal", 1.0e-4_wp, &
         absolute=.true.)
      call list%put("rolled", "m", "way of the material through the spot over the length of " // &
         "relaxation, times the major semi-axis", axis_over_length, against_length, absolute=.true.)
   end subroutine put_tangential_states

   !> The states of rolling by a law of creep.
   subroutine put_carried_states(list)
      type(state_list_type), intent(inout) :: list

      call list%put("carried_creepage", "1", "creepage of B against A that the material " // &
         "carries out of the spot", creepage_scale, tangent=.true.)
      call list%put("carried_spin", "m-1", "creepage of spin that the material carries out of " // &
         "the spot", spin_creepage_scale)
   end subroutine put_carried_states

   !> Make room for shells, without a contact.
   pure subroutine begin(self, shells)
      class(tangential_type), intent(inout) :: self
      !> Their number.
      integer, intent(in) :: shells

      call make_room(self%past, shells)
      call make_room(self%now, shells)
      call make_room(self%half, shells)
      call make_room(self%whole, shells)
      self%is_moved = .false.
   end subroutine begin

   !> Begin without a contact.
   pure subroutine forget(self)
      class(tangential_type), intent(inout) :: self

      call self%past%clear()
      self%is_moved = .false.
      self%anchor = 0.0_wp
      self%rates = 0.0_wp
      self%slid = 0.0_wp
      self%limit = 0.0_wp
      self%a = 0.0_wp
   end subroutine forget

   !> Whether there was a spot at the last accepted step.
   pure logical function is_loaded(self)
      class(tangential_type), intent(in) :: self

      is_loaded = self%past%n > 0
   end function is_loaded

   !> Rates of the states where nothing is borne: those with which they go on from a touch.
   pure function free_rates(self, shape, motion, carried, states) result(rates)
      class(tangential_type), intent(in) :: self
      !> Of the spot that is about to be there.
      type(spot_shape_type), intent(in) :: shape
      !> Sliding velocity along the axes of the spot [m/s] and spin [rad/s].
      real(wp), intent(in) :: motion(3)
      !> Velocity of the material through the spot along these axes [m/s].
      real(wp), intent(in) :: carried(2)
      !> Six, nine with a law of creep.
      real(wp), intent(in) :: states(:)
      real(wp) :: rates(size(states))

      rates = 0.0_wp
      rates(3:5) = along(unit_axis(states(1:2)), motion)
      ! It does not depend on the size.
      rates(6) = self%way_rate(spring_spot_type(shape, 1.0_wp, 0.0_wp, self%modulus, &
         self%poisson), carried)
   end function free_rates

   !> Unit vector along the axis: any, where none is set. A place where surfaces come close later
   !> has none before it touches.
   pure function unit_axis(axis) result(unit)
      real(wp), intent(in) :: axis(2)
      real(wp) :: unit(2)
      real(wp) :: length

      length = sqrt(axis(1)**2 + axis(2)**2)
      unit = [1.0_wp, 0.0_wp]
      if (length > 0.0_wp) unit = axis/length
   end function unit_axis

   !> A motion along the axis and across it.
   pure function along(axis, motion)
      !> Unit vector.
      real(wp), intent(in) :: axis(2)
      !> Along the axes of the spot, and about the normal.
      real(wp), intent(in) :: motion(3)
      real(wp) :: along(3)

      along = [axis(1)*motion(1) + axis(2)*motion(2), axis(1)*motion(2) - axis(2)*motion(1), &
         motion(3)]
   end function along

   !> Wrench at given states, and the rates of these.
   pure subroutine evolve(self, friction, shape, rolls, states, wrench, rates, slopes)
      class(tangential_type), intent(inout) :: self
      !> What acts where the whole spot slides.
      class(friction_type), intent(in) :: friction
      type(spot_shape_type), intent(in) :: shape
      type(passing_type), intent(in) :: rolls
      !> Six, nine with a law of creep.
      real(wp), intent(in) :: states(:)
      !> Force along the major and the minor axis [N], torque about the normal [N m].
      real(wp), intent(out) :: wrench(3)
      !> Time derivatives of the states.
      real(wp), intent(out) :: rates(:)
      !> Derivatives of `self%wrench` by shifts and twist since the last step, and by the limit;
      !> meant where sliding has no share.
      real(wp), intent(out), optional :: slopes(3, 4)
      real(wp) :: axis(2), carried(2), sliding(3), speed, lost_to_creep(3), rest(3)
      real(wp) :: creep, fast
      logical :: circle

      circle = .not. abs(1.0_wp - shape%k) > 0.0_wp
      axis = unit_axis(states(1:2))
      self%spot%shape = shape
      self%spot%a = rolls%a
      self%spot%limit = self%coefficient*rolls%load
      call self%spot%stiffen(self%modulus, self%poisson)
      self%velocity = [rolls%vx, rolls%vy, rolls%w]
      carried = [rolls%cx, rolls%cy]
      self%step = states(3:6) - self%anchor
      self%sure = 1.0_wp
      if (allocated(self%carry)) then
         ! What is carried out does not make the shells slip; the rest that is lost is small where
         ! they slide.
         speed = sqrt(carried(1)**2 + carried(2)**2)
         self%velocity = self%velocity - speed*states(7:9)
         self%step(4) = 0.0_wp
         self%sure = smooth_step(1.0_wp - speed*size_of(states(7:9), rolls%a) &
            /max(size_of(self%velocity, rolls%a), tiny(speed)), aligned)
      end if
      self%step_rates = [along(axis, self%velocity), self%way_rate(self%spot, carried)]
      self%foreseen = self%step_rates(1:3)
      rates(:6) = [0.0_wp, 0.0_wp, self%step_rates]
      ! On a circle all axes are alike, and the axis does as well as any.
      self%axis = axis
      if (circle) self%axis = [1.0_wp, 0.0_wp]
      if (circle) self%velocity(1:2) = self%step_rates(1:2)
      self%wrench = 0.0_wp
      self%share = self%sliding_share(self%step)
      if (allocated(self%carry) .and. self%share > 0.0_wp) then
         creep = speed*self%carry%creep_scale(shape, rolls%load, rolls%a)
         if (creep > 0.0_wp) self%share = self%share &
            *smooth_step(size_of(self%velocity, rolls%a)/creep, distinct_sliding)
      end if
      if (.not. self%may_be_same) self%is_moved = .false.
      if (self%share < 1.0_wp) call self%move(self%wrench, slopes)
      if (self%share > 0.0_wp) then
         call slide(self, friction, shape, rolls, self%velocity, sliding)
         self%wrench = (1.0_wp - self%share)*self%wrench + self%share*sliding
      end if
      wrench = self%wrench
      if (circle) then
         wrench(1) = axis(1)*self%wrench(1) - axis(2)*self%wrench(2)
         wrench(2) = axis(2)*self%wrench(1) + axis(1)*self%wrench(2)
      end if
      if (.not. allocated(self%carry)) return
      self%slips = 0.0_wp
      if (speed > 0.0_wp .and. self%spot%limit > 0.0_wp) then
         if (share_of_limit(wrench) > much) then
            rest = [rolls%vx, rolls%vy, rolls%w] - speed*states(7:9)
            call slide(self, friction, shape, rolls, rest, sliding)
            creep = little_sliding*speed*self%carry%creep_scale(shape, rolls%load, rolls%a)
            fast = size_of(rest, rolls%a)
            self%slips = smooth_step(1.0_wp - share_of_limit(wrench - sliding), sliding_through) &
               *fast**2/(fast**2 + creep**2)
         end if
      end if
      call self%carry%lose(shape, carried_type(rolls%load, rolls%a, carried, states(7:9), &
         wrench, self%reference, [rolls%vx, rolls%vy, rolls%w], self%slips), lost_to_creep, &
         rates(7:9))
      self%step_rates(1:3) = along(axis, [rolls%vx, rolls%vy, rolls%w] - lost_to_creep)
      rates(3:5) = self%step_rates(1:3)

   contains

      !> Size of a wrench over the limit.
      pure real(wp) function share_of_limit(wrench)
         real(wp), intent(in) :: wrench(3)

         share_of_limit = norm2(wrench/(self%spot%limit &
            *[1.0_wp, 1.0_wp, rolls%a*shape%torque]))
      end function share_of_limit

   end subroutine evolve

   !> Wrench of full sliding with a velocity along the axes of the spot [m/s] and a spin [rad/s].
   pure subroutine slide(self, friction, shape, rolls, velocity, wrench)
      class(tangential_type), intent(in) :: self
      class(friction_type), intent(in) :: friction
      type(spot_shape_type), intent(in) :: shape
      type(passing_type), intent(in) :: rolls
      real(wp), intent(in) :: velocity(3)
      real(wp), intent(out) :: wrench(3)
      type(sliding_type) :: steady

      if (self%drilling) then
         steady = rolls%sliding_type
         steady%vx = velocity(1)
         steady%vy = velocity(2)
         steady%w = velocity(3)
         steady%resolution = 0.0_wp
         call friction%wrench(shape, steady, wrench)
      else
         wrench = -self%spot%limit/max(norm2(velocity(1:2)), tiny(velocity)) &
            *[velocity(1:2), 0.0_wp]
      end if
   end subroutine slide

   !> Rate of the way through the spot in lengths of relaxation, a b G C11/k_x with Kalker's
   !> creepage coefficient C11 along the direction of rolling, times a [m/s].
   pure real(wp) function way_rate(self, spot, carried) result(rate)
      class(tangential_type), intent(in) :: self
      type(spring_spot_type), intent(in) :: spot
      !> Velocity of the material through the spot along its axes [m/s].
      real(wp), intent(in) :: carried(2)
      real(wp) :: area, circle

      rate = 0.0_wp
      associate (k => spot%shape%k)
         area = spot%a*k*self%modulus
         if (.not. area > 0.0_wp) return
         ! 1/C11 on the circle, and its change with the ratio of the semi-axes at nu = 0.3.
         circle = area/(0.294524_wp - (0.206244_wp - 0.00288_wp*self%poisson)*self%poisson)
         rate = sqrt((carried(1)*spot%stiffness(1)/(circle*(0.79_wp + 0.21_wp/k)))**2 &
            + (carried(2)*spot%stiffness(2)/(circle*(0.82_wp + 0.18_wp*k*sqrt(k))))**2)
      end associate
   end function way_rate

   !> Length of relaxation of the twist over that of the shift, inverse: on the circle.
   pure real(wp) function twist_rate(poisson) result(ratio)
      real(wp), intent(in) :: poisson

      ratio = (2.0_wp - poisson)*(2.0_wp/3.0_wp) &
         *(0.828349_wp + (0.0590_wp + 0.0204_wp*poisson)*poisson) &
         /(0.294524_wp - (0.206244_wp - 0.00288_wp*poisson)*poisson)
   end function twist_rate

   !> Way through a spot in lengths of relaxation.
   pure real(wp) function lengths(step, spot)
      real(wp), intent(in) :: step(4)
      type(spring_spot_type), intent(in) :: spot

      lengths = 0.0_wp
      if (step(4) > 0.0_wp .and. spot%a > 0.0_wp) lengths = min(step(4), long_way*spot%a)/spot%a
   end function lengths

   !> What is left of a strain after a way.
   pure real(wp) function left(way)
      real(wp), intent(in) :: way

      if (way < short_way) then
         left = 1.0_wp - max(way, 0.0_wp)*(1.0_wp - (way/2.0_wp)*(1.0_wp - (way/3.0_wp) &
            *(1.0_wp - way/4.0_wp)))
      else
         left = exp(-way)
      end if
   end function left

   !> What is left of a strain that has grown evenly on the way.
   pure real(wp) function left_of_growth(way) result(part)
      real(wp), intent(in) :: way

      if (way < short_way) then
         part = 1.0_wp - 0.5_wp*max(way, 0.0_wp)*(1.0_wp - (way/3.0_wp)*(1.0_wp - way/4.0_wp))
      else
         part = (1.0_wp - exp(-way))/way
      end if
   end function left_of_growth

   !> Shells of the last state that was evaluated, moved by its step, in `now`; only once.
   pure subroutine move(self, wrench, slopes)
      class(tangential_type), intent(inout) :: self
      real(wp), intent(out) :: wrench(3)
      !> As of `strain`.
      real(wp), intent(out), optional :: slopes(3, 4)
      real(wp) :: arguments(n_arguments)

      associate (spot => self%spot)
         arguments = [self%step, self%foreseen, self%sure, self%axis, spot%shape%k, spot%a, &
            spot%limit, spot%stiffness]
      end associate
      if (present(slopes)) self%is_moved = .false.
      if (self%is_moved) self%is_moved = all(abs(arguments - self%moved) <= 0.0_wp)
      if (.not. self%is_moved) then
         call strain(self%past, self%axis, self%spot, self%step, self%foreseen, self%sure, &
            self%poisson, self%drilling, self%now, self%bears, slopes)
         self%moved = arguments
         self%is_moved = .true.
      end if
      wrench = self%bears
   end subroutine move

   !> Size of a velocity and a spin.
   pure real(wp) function size_of(velocity, a)
      !> Velocity along the axes [m/s] and spin [rad/s], or creepages.
      real(wp), intent(in) :: velocity(3)
      !> Semi-axis [m].
      real(wp), intent(in) :: a

      size_of = sqrt(velocity(1)**2 + velocity(2)**2 + (a*velocity(3))**2)
   end function size_of

   !> Shells moved by a step.
   pure subroutine strain(past, axis, spot, step, speed, sure, poisson, drilling, now, wrench, &
      slopes)
      !> What is remembered.
      type(shells_type), intent(in) :: past
      !> The axis along which it is, seen from the axes of the spot.
      real(wp), intent(in) :: axis(2)
      type(spring_spot_type), intent(in) :: spot
      !> Shifts along the axis and across it, twist, and way times the major semi-axis.
      real(wp), intent(in) :: step(4)
      !> Rates of shifts and twist at the end of the step, and how sure they are, from 0 to 1.
      real(wp), intent(in) :: speed(3), sure
      !> Poisson's ratio.
      real(wp), intent(in) :: poisson
      !> Whether there is a torque about the normal.
      logical, intent(in) :: drilling
      !> What becomes of it, along the axes of the spot.
      type(shells_type), intent(inout) :: now
      real(wp), intent(out) :: wrench(3)
      !> Derivatives of the wrench by shifts and twist, and by the limit.
      real(wp), intent(out), optional :: slopes(3, 4)
      real(wp) :: motion(3), way, twisted, shifted, turned, remains(3), by_shift(3), part(3)

      way = lengths(step, spot)
      twisted = way*twist_rate(poisson)
      shifted = left_of_growth(way)
      turned = left_of_growth(twisted)
      motion(1) = shifted*(axis(1)*step(1) - axis(2)*step(2))
      motion(2) = shifted*(axis(2)*step(1) + axis(1)*step(2))
      part = [1.0_wp, 1.0_wp, merge(1.0_wp, 0.0_wp, drilling)]
      motion(3) = turned*part(3)*step(3)
      remains(1) = left(way)
      remains(2) = remains(1)
      remains(3) = left(twisted)
      call now%take(past, axis, remains)
      ! What slips in the step fades as what is strained does: sliding has the same direction for
      ! any length of it.
      now%fading = turned/shifted
      now%turning = sure*[shifted, shifted, turned]*turning_of(spot, axis, part*step(1:3), &
         part*speed)
      call now%advance(spot, motion, wrench, settled=.false., slopes=slopes)
      if (.not. present(slopes)) return
      by_shift = slopes(:, 1)
      slopes(:, 1) = shifted*(axis(1)*by_shift + axis(2)*slopes(:, 2))
      slopes(:, 2) = shifted*(axis(1)*slopes(:, 2) - axis(2)*by_shift)
      slopes(:, 3) = turned*slopes(:, 3)
      if (.not. drilling) slopes(:, 3) = 0.0_wp
   end subroutine strain

   !> What is to be added to a step, along the axes of the spot, for its direction to be that of the
   !> rates at its end. What slips is along the step: along its mean a force would lag behind a
   !> direction that turns by half of the turn in the step. Nothing where the step does not turn, or
   !> turns by far.
   pure function turning_of(spot, axis, step, speed) result(turning)
      type(spring_spot_type), intent(in) :: spot
      real(wp), intent(in) :: axis(2), step(3), speed(3)
      real(wp) :: turning(3), d(3), v(3), dd, vv, dv

      turning = 0.0_wp
      d = [axis(1)*step(1) - axis(2)*step(2), axis(2)*step(1) + axis(1)*step(2), step(3)]
      v = [axis(1)*speed(1) - axis(2)*speed(2), axis(2)*speed(1) + axis(1)*speed(2), speed(3)]
      dd = dot_product(d, spot%stiffness*d)
      vv = dot_product(v, spot%stiffness*v)
      dv = dot_product(d, spot%stiffness*v)
      if (.not. (dd*vv > 0.0_wp .and. dv > 0.0_wp)) return
      turning = smooth_step(dv/sqrt(dd*vv), aligned)*(v*(dv/vv) - d)
   end function turning_of

   !> Share of sliding in the wrench.
   pure real(wp) function sliding_share(self, step) result(share)
      class(tangential_type), intent(in) :: self
      real(wp), intent(in) :: step(4)
      real(wp) :: shift(3), speed(3), way, fast

      share = 0.0_wp
      if (.not. (self%spot%limit > 0.0_wp .and. self%spot%a > 0.0_wp)) return
      shift = in_strains(self, sliding_to(self, step))
      way = sqrt(dot_product(shift, shift))
      if (way <= long_shift(1)) return
      speed = in_strains(self, self%step_rates(1:3))
      fast = sqrt(dot_product(speed, speed))
      if (.not. fast > 0.0_wp) return
      share = smooth_step(way, long_shift) &
         *smooth_step(dot_product(shift, speed)/(way*fast), aligned)
   end function sliding_share

   !> Shifts and twist since something stuck, as far as rolling has left of them.
   pure function sliding_to(self, step) result(shift)
      class(tangential_type), intent(in) :: self
      real(wp), intent(in) :: step(4)
      real(wp) :: shift(3), way

      way = lengths(step, self%spot)
      shift = left(way)*self%slid + left_of_growth(way)*step(1:3)
   end function sliding_to

   !> Shifts and twist, or their rates, over what the whole spot can be strained: now or at the last
   !> accepted step, whichever is more. Where it can bear less than it did it slips without sliding.
   pure function in_strains(self, shift) result(strains)
      class(tangential_type), intent(in) :: self
      real(wp), intent(in) :: shift(3)
      real(wp) :: strains(3)

      associate (spot => self%spot)
         strains = shift*spot%stiffness/(spot%limit*[1.0_wp, 1.0_wp, spot%a*spot%shape%torque]) &
            /fall(self)
      end associate
      if (.not. self%drilling) strains(3) = 0.0_wp
   end function in_strains

   !> What the spot could be strained at the last accepted step over what it can be now, if more.
   pure real(wp) function fall(self)
      class(tangential_type), intent(in) :: self

      fall = 1.0_wp
      if (self%a > 0.0_wp) fall = max(self%limit*self%spot%a/(self%spot%limit*self%a), 1.0_wp)
   end function fall

   !> Wrench and rates of the states, and their derivatives by normal force, size of the spot,
   !> velocities and states. Those by load, shift and twist are the consistent ones of the shells;
   !> by differences are those by the size and the way, on ellipses by the axis, and all where
   !> sliding has a share or all slips. What the velocities do to the way is left out.
   pure subroutine vary(self, friction, shape, rolls, states, wrench, rates, slopes)
      class(tangential_type), intent(inout) :: self
      class(friction_type), intent(in) :: friction
      type(spot_shape_type), intent(in) :: shape
      type(passing_type), intent(in) :: rolls
      !> Six, nine with a law of creep.
      real(wp), intent(in) :: states(:)
      real(wp), intent(out) :: wrench(3)
      real(wp), intent(out) :: rates(:)
      !> Derivatives of the wrench, then of the rates, by N, a, vx, vy, w, then by the states.
      real(wp), intent(out) :: slopes(:, :)
      real(wp) :: h(5 + n_all_states), speed, by_step(3, 4), axis(2), length, change(2)
      real(wp) :: velocity(2), lost(3), rate(3), by_creep(6, 8)
      logical :: differs(5 + n_all_states), circle
      integer :: i, j, n

      call self%evolve(friction, shape, rolls, states, wrench, rates, by_step)
      slopes = 0.0_wp
      associate (spot => self%spot)
         if (.not. (spot%limit > 0.0_wp .and. spot%a > 0.0_wp)) return
         speed = max(sqrt(rolls%vx**2 + rolls%vy**2 + (rolls%a*rolls%w)**2), 1.0e-9_wp)
         h(1) = step_of_differences*rolls%load
         h(2) = step_of_differences*rolls%a
         h(3:4) = step_of_differences*speed
         h(5) = h(3)/rolls%a
         h(6:7) = step_of_differences
         h(8:9) = step_of_differences*spot%limit/spot%stiffness(1)
         h(10) = step_of_differences*spot%limit*spot%a/spot%stiffness(3)
         h(11) = step_of_differences*rolls%a
      end associate
      n = 5 + size(states)
      if (allocated(self%carry) .and. rolls%a > 0.0_wp) h(12:14) = step_of_differences &
         *max(abs(states(7:9)), self%carry%creep_scale(shape, rolls%load, rolls%a) &
         *[1.0_wp, 1.0_wp, 1.0_wp/rolls%a])
      circle = .not. abs(1.0_wp - shape%k) > 0.0_wp
      differs = self%share > 0.0_wp .or. self%slips > 0.0_wp
      differs([2, 11]) = .true.
      if (.not. circle) differs(6:7) = .true.
      axis = unit_axis(states(1:2))
      length = sqrt(states(1)**2 + states(2)**2)
      ! Without an axis there is nothing to vary.
      if (.not. length > 0.0_wp) length = 1.0_wp
      velocity = [rolls%vx, rolls%vy]
      if (allocated(self%carry)) then
         velocity = [axis(1)*rates(3) - axis(2)*rates(4), axis(2)*rates(3) + axis(1)*rates(4)]
         differs(11) = .false.
      end if
      if (.not. differs(1)) then
         slopes(1:3, 1) = self%coefficient*by_step(:, 4)
         slopes(6, 3:4) = axis
         slopes(7, 3:4) = [-axis(2), axis(1)]
         slopes(8, 5) = 1.0_wp
         slopes(1:3, 8:10) = by_step(:, 1:3)
      end if
      if (circle .and. .not. differs(1)) then
         do i = 1, 10
            if (i == 1 .or. i >= 8) slopes(1:2, i) = [axis(1)*slopes(1, i) - axis(2)*slopes(2, i), &
               axis(2)*slopes(1, i) + axis(1)*slopes(2, i)]
         end do
         do i = 1, 2
            ! The axis is made a unit vector.
            change = -axis(i)*axis
            change(i) = change(i) + 1.0_wp
            change = change/length
            associate (w => self%wrench)
               slopes(1:2, 5 + i) = [change(1)*w(1) - change(2)*w(2), &
                  change(2)*w(1) + change(1)*w(2)]
            end associate
            slopes(6:7, 5 + i) = [change(1)*velocity(1) + change(2)*velocity(2), &
               change(1)*velocity(2) - change(2)*velocity(1)]
         end do
      end if
      if (allocated(self%carry)) then
         call self%carry%vary(shape, carried_type(rolls%load, rolls%a, [rolls%cx, rolls%cy], &
            states(7:9), wrench, self%reference), lost, rate, by_creep)
         by_creep(1:2, :) = reshape([(axis(1)*by_creep(1, i) + axis(2)*by_creep(2, i), &
            axis(1)*by_creep(2, i) - axis(2)*by_creep(1, i), i=1, 8)], [2, 8])
         do i = 1, n
            if (differs(i)) cycle
            associate (by_wrench => matmul(by_creep(:, 6:8), slopes(:3, i)))
               slopes(6:8, i) = slopes(6:8, i) - by_wrench(1:3)
               slopes(10:12, i) = slopes(10:12, i) + by_wrench(4:6)
            end associate
            if (i > 1 .and. i < 12) cycle
            j = merge(1, i - 9, i == 1)
            slopes(6:8, i) = slopes(6:8, i) - by_creep(1:3, j)
            slopes(10:12, i) = slopes(10:12, i) + by_creep(4:6, j)
         end do
      end if
      do i = 1, n
         if (i == of_axis + 1 .or. .not. differs(i)) cycle
         call differ(self, friction, shape, rolls, states, i, h(i), slopes(:, i))
         ! The size of the axis does not count.
         if (i == of_axis) then
            slopes(:, i + 1) = slopes(:, i)*(axis(1)/length)
            slopes(:, i) = slopes(:, i)*(-axis(2)/length)
         end if
      end do
      ! The last state that was evaluated is this one.
      call self%evolve(friction, shape, rolls, states, wrench, rates)
   end subroutine vary

   !> Derivatives of wrench and rates by one of the quantities that `vary` names, by differences; in
   !> the place of the first component of the axis by the angle by which it is turned.
   pure subroutine differ(self, friction, shape, rolls, states, i, h, slopes)
      class(tangential_type), intent(inout) :: self
      class(friction_type), intent(in) :: friction
      type(spot_shape_type), intent(in) :: shape
      type(passing_type), intent(in) :: rolls
      real(wp), intent(in) :: states(:)
      !> Which quantity, and its change.
      integer, intent(in) :: i
      real(wp), intent(in) :: h
      real(wp), intent(out) :: slopes(:)
      type(passing_type) :: there
      real(wp) :: varied(3 + size(states), 2), moved(size(states)), change
      integer :: k

      do k = 1, 2
         change = merge(h, -h, k == 2)
         there = rolls
         moved = states
         if (i < of_axis) then
            there%sliding_type = changed(rolls%sliding_type, i, change)
         else if (i == of_axis) then
            moved(1:2) = moved(1:2) + change*[-states(2), states(1)]
         else
            moved(i - 5) = moved(i - 5) + change
         end if
         call self%evolve(friction, shape, there, moved, varied(:3, k), varied(4:, k))
      end do
      slopes = (varied(:, 2) - varied(:, 1))/(2.0_wp*h)
   end subroutine differ

   !> What the last state that was evaluated holds.
   pure subroutine tell(self, stored, stuck, displacement)
      class(tangential_type), intent(inout) :: self
      !> Elastic energy [J].
      real(wp), intent(out) :: stored
      !> Share of the area of the spot that has not slipped since the last accepted step.
      real(wp), intent(out) :: stuck
      !> Elastic displacement of B against A over the whole spot, along the axis and across it [m].
      real(wp), intent(out) :: displacement(2)
      real(wp) :: shift(2), wrench(3)

      stored = 0.0_wp
      stuck = 0.0_wp
      displacement = 0.0_wp
      if (.not. (self%spot%limit > 0.0_wp .and. self%spot%a > 0.0_wp)) return
      ! Where sliding is all that is left the shells are not moved yet.
      if (self%share > 0.0_wp) then
         call self%move(wrench)
         call self%now%slide(self%spot, self%velocity, self%share)
         self%is_moved = .false.
      end if
      stored = self%now%energy()
      if (self%share <= 0.0_wp) stuck = self%now%stuck_share()
      shift = -self%wrench(1:2)/self%spot%stiffness(1:2)
      displacement(1) = self%axis(1)*shift(1) + self%axis(2)*shift(2)
      displacement(2) = self%axis(1)*shift(2) - self%axis(2)*shift(1)
   end subroutine tell

   !> Take note that the surfaces are apart.
   pure subroutine part(self)
      class(tangential_type), intent(inout) :: self

      self%spot%a = 0.0_wp
      self%spot%limit = 0.0_wp
      self%spot%stiffness = 0.0_wp
      self%share = 0.0_wp
      self%wrench = 0.0_wp
   end subroutine part

   !> Error of the wrench of the last state that was evaluated, over the limit of friction: twice
   !> its distance from that of two steps in place of the one, as it grows with their square.
   !>
   !> Within a step the wrench follows from the shift at its end, whatever came in between. So where
   !> the motion turns back in the step the two may be those to that place and back from there, too;
   !> and what counts as well is the error where it is back where it was, as friction may have
   !> another sign up to there.
   subroutine deviate(self, time_step, deviation, turn)
      class(tangential_type), intent(inout) :: self
      !> Time since the last accepted step [s].
      real(wp), intent(in) :: time_step
      real(wp), intent(out) :: deviation
      !> Part of the step after which the motion turns back or what has slipped sticks, 1 where
      !> neither is so.
      real(wp), intent(out) :: turn
      type(spring_spot_type) :: spot
      real(wp) :: first(4), rest(4), wrench(3), scale
      logical :: turns_back

      deviation = 0.0_wp
      turn = 1.0_wp
      scale = max(self%spot%limit, self%limit, self%reference)
      if (.not. (self%spot%limit > 0.0_wp .and. self%spot%a > 0.0_wp)) return
      if (self%share < 1.0_wp) then
         call begin_with(0.5_wp)
         call end_with_rest()
      end if
      turn = turning_back(self)
      turns_back = turn < 1.0_wp
      if (.not. turns_back) turn = sticking_again(self, time_step)
      if (turn >= 1.0_wp) return
      call begin_with(turn)
      if (turns_back) call compare_way_back()
      if (self%share < 1.0_wp) call end_with_rest()

   contains

      !> Take the first part of the step, along the cubic with these rates at its ends.
      subroutine begin_with(part)
         real(wp), intent(in) :: part

         first = (part*part*(3.0_wp - 2.0_wp*part))*self%step + (part*(1.0_wp - part)*time_step) &
            *((1.0_wp - part)*self%rates - part*self%step_rates)
         first(4) = min(max(first(4), 0.0_wp), max(self%step(4), 0.0_wp))
         rest = self%step - first
         spot = self%spot
         spot%limit = (1.0_wp - part)*self%limit + part*self%spot%limit
         spot%a = (1.0_wp - part)*self%a + part*self%spot%a
         call spot%stiffen(self%modulus, self%poisson)
         call strain(self%past, self%axis, spot, first, (1.0_wp - part)*self%rates(1:3) &
            + part*self%foreseen, self%sure, self%poisson, self%drilling, self%half, wrench)
         call self%half%turn_to(self%axis)
      end subroutine begin_with

      !> Compare the way back from there, as far as the way there at most, with one step to its end.
      subroutine compare_way_back()
         real(wp) :: once(3), back

         back = min(1.0_wp, norm2(in_strains(self, first(1:3))) &
            /max(norm2(in_strains(self, rest(1:3))), tiny(back)))
         call strain(self%past, self%axis, self%spot, first + back*rest, self%foreseen, self%sure, &
            self%poisson, self%drilling, self%whole, once)
         call strain(self%half, self%axis, self%spot, back*rest, self%foreseen, self%sure, &
            self%poisson, self%drilling, self%whole, wrench)
         deviation = max(deviation, apart(wrench, once))
      end subroutine compare_way_back

      !> Take the rest of it.
      subroutine end_with_rest()
         call strain(self%half, self%axis, self%spot, rest, self%foreseen, self%sure, &
            self%poisson, self%drilling, self%whole, wrench)
         deviation = max(deviation, (1.0_wp - self%share)*apart(wrench, self%bears))
      end subroutine end_with_rest

      !> Twice the distance of two wrenches, over the limit.
      pure real(wp) function apart(one, other)
         real(wp), intent(in) :: one(3), other(3)

         apart = 2.0_wp*norm2((one - other)/[1.0_wp, 1.0_wp, self%spot%a])/scale
      end function apart

   end subroutine deviate

   !> Part of the step of the last state that was evaluated after which it goes back, 1 where it
   !> does not: where sliding and spin, as straight between the ends, are least.
   pure real(wp) function turning_back(self) result(part)
      class(tangential_type), intent(in) :: self
      real(wp), dimension(3) :: begin, end

      part = 1.0_wp
      begin = in_strains(self, self%rates(1:3))
      end = in_strains(self, self%step_rates(1:3))
      if (dot_product(begin, end) < 0.0_wp) part = dot_product(begin, begin - end) &
         /dot_product(begin - end, begin - end)
   end function turning_back

   !> Part of the step after which what has slipped sticks as the limit grows by more than the force
   !> would, 1 where it does not: rates of the shift as straight between the ends, that of the limit
   !> as even.
   pure real(wp) function sticking_again(self, time_step) result(part)
      class(tangential_type), intent(in) :: self
      real(wp), intent(in) :: time_step
      real(wp) :: begin, end, growth

      part = 1.0_wp
      growth = (self%spot%limit - self%limit)/self%spot%limit
      if (.not. growth > 0.0_wp) return
      begin = time_step*norm2(in_strains(self, self%rates(1:3)))
      end = time_step*norm2(in_strains(self, self%step_rates(1:3)))
      if (begin > growth .and. end < growth) part = (begin - growth)/(begin - end)
   end function sticking_again

   !> Accept the last state that was evaluated: it is remembered.
   pure subroutine keep(self)
      class(tangential_type), intent(inout) :: self
      real(wp) :: wrench(3)

      call self%move(wrench)
      self%is_moved = .false.
      call note_sliding(self)
      ! The wrench is to go on where it was: with the same share if the way of sliding goes on.
      if (self%share >= 1.0_wp .or. (self%share > 0.0_wp .and. all(abs(self%slid) <= 0.0_wp))) then
         call self%now%slide(self%spot, self%velocity, self%share)
      end if
      call self%now%turn_to(self%axis)
      call self%now%settle(self%spot)
      call self%past%copy(self%now)
      call self%past%foresee(self%spot%a - self%a)
      self%anchor = self%anchor + self%step
      self%step = 0.0_wp
      self%rates = self%step_rates
      self%limit = self%spot%limit
      self%a = self%spot%a
   end subroutine keep

   !> Remember how far the bodies have slid, unless something sticks, slips against the sliding, or
   !> the sliding turns or is made up for what rolling carries out so that the force lags behind.
   pure subroutine note_sliding(self)
      class(tangential_type), intent(inout) :: self
      real(wp) :: slid(3), shift(3), speed(3), before(3), way, fast, turn, step

      slid = sliding_to(self, self%step)
      self%slid = 0.0_wp
      if (.not. (self%spot%limit > 0.0_wp .and. self%spot%a > 0.0_wp)) return
      if (self%share <= 0.0_wp .and. self%now%stuck_share() > 0.0_wp) return
      if (dot_product(self%wrench, self%velocity) >= 0.0_wp) return
      shift = in_strains(self, slid)
      speed = in_strains(self, self%step_rates(1:3))
      way = sqrt(dot_product(shift, shift))
      fast = sqrt(dot_product(speed, speed))
      if (dot_product(shift, speed) <= aligned(1)*way*fast) return
      speed = speed/fast
      before = in_strains(self, self%rates(1:3))
      turn = norm2(before - dot_product(before, speed)*speed)/fast
      step = norm2(in_strains(self, self%step(1:3)))
      ! After a step that is long by itself the next one begins as that has ended.
      if (step < longest_shift .and. lag_of_turn*turn + lengths(self%step, self%spot) &
         > largest_lag*step) return
      self%slid = slid*(min(1.0_wp, longest_shift/way)/fall(self))
   end subroutine note_sliding

   !> Write what is remembered to a checkpoint or read it back.
   subroutine exchange(self, checkpoint)
      class(tangential_type), intent(inout) :: self
      type(checkpoint_type), intent(inout) :: checkpoint

      call checkpoint%exchange("tangential_anchor", self%anchor)
      call checkpoint%exchange("tangential_rates", self%rates)
      call checkpoint%exchange("tangential_slid", self%slid)
      call checkpoint%exchange("tangential_limit", self%limit)
      call checkpoint%exchange("tangential_a", self%a)
      call self%past%exchange(checkpoint)
      self%is_moved = .false.
   end subroutine exchange

end module contensou_contact_tangential_memory
