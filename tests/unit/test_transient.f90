!> Tests of rolling with memory: the onset of rolling and of spin against boundary elements in time,
!> the steady state against the law of creep, rest, derivatives and energy.
module test_transient
   use contensou_base_kinds, only : pi, wp
   use contensou_contact_creep, only : creep_model_type, creep_models
   use contensou_contact_creep_law, only : creep_spot, passing_type
   use contensou_contact_friction_ladder, only : rung_type
   use contensou_contact_parameters, only : parameters_type
   use contensou_contact_spot, only : circular_shape, elliptic_shape, spot_shape_type
   use contensou_contact_tangential_carry, only : carried_type
   use contensou_contact_tangential_memory, only : tangential_type
   use contensou_contact_wrench_exact, only : wrench_exact, wrench_exact_jacobian
   use marching_spot, only : march_type
   use test_harness, only : check, check_close, is_checked, random_type, worst_type
   implicit none(type, external)
   private

   public :: run_transient_tests

   !> Steel, in SI units; friction, load, and major semi-axis of the spot.
   real(wp), parameter :: modulus = 8.0e10_wp, poisson = 0.3_wp, friction_coefficient = 0.3_wp, &
      load = 1000.0_wp, a = 1.0e-3_wp

   !> Numbers of state.
   integer, parameter :: n = 9

contains

   !> Run all tests.
   subroutine run_transient_tests()
      call test_onset(2.0_wp, poisson, [0.75_wp], 0.0175_wp)
      call test_spin(1.0_wp, 1.0_wp, [0.095_wp, 0.025_wp])
      ! Marches of the exact theory, which take minutes with run-time checks.
      if (.not. is_checked()) call test_more_marches()
      call test_steady()
      call test_steady_wrench()
      call test_kept_on_ellipse()
      call test_rest()
      call test_slopes()
      call test_energy()
      call test_drives()
   end subroutine run_transient_tests

   !> The transient law against the exact theory for other spots, materials, forces and spins.
   subroutine test_more_marches()
      call test_onset(1.0_wp, poisson, [0.3_wp, 0.75_wp], 0.0145_wp)
      call test_onset(0.5_wp, poisson, [0.6_wp], 0.0125_wp)
      call test_onset(5.0_wp, poisson, [0.3_wp, 0.75_wp], 0.0195_wp)
      call test_onset(2.0_wp, 0.0_wp, [0.75_wp], 0.0195_wp, 14)
      call test_onset(5.0_wp, 0.5_wp, [0.3_wp, 0.75_wp], 0.0195_wp)
      call test_onset(8.0_wp, poisson, [0.75_wp], 0.0185_wp, 14)
      call test_onset(1.0_wp, poisson, [0.5_wp], 0.088_wp, after=[-0.5_wp])
      call test_spin(1.0_wp, 0.3_wp, [0.026_wp, 0.018_wp])
      call test_spin(2.0_wp, 1.0_wp, [0.115_wp, 0.049_wp])
      call test_spin(0.5_wp, 1.0_wp, [0.075_wp, 0.03_wp])
   end subroutine test_more_marches

   !> A contact with memory and a law of creep, and its friction.
   subroutine make(law, contact, friction, other_poisson)
      !> Name of the law; blank for none.
      character(len=*), intent(in) :: law
      type(tangential_type), intent(out) :: contact
      type(rung_type), intent(out) :: friction
      !> Poisson's ratio, if it is not that of steel.
      real(wp), intent(in), optional :: other_poisson
      type(creep_model_type), allocatable :: models(:)
      type(parameters_type) :: parameters
      integer :: i

      friction%coefficient = friction_coefficient
      friction%kernel => wrench_exact
      friction%jacobian => wrench_exact_jacobian
      contact%coefficient = friction_coefficient
      contact%modulus = modulus
      contact%poisson = poisson
      if (present(other_poisson)) contact%poisson = other_poisson
      call contact%begin(30)
      call contact%forget()
      if (law == "") return
      models = creep_models()
      allocate(contact%carry)
      i = findloc(models%info%name == law, .true., dim=1)
      call models(i)%create(parameters, contact%carry%creep)
      call contact%carry%begin(friction_coefficient, modulus, contact%poisson)
   end subroutine make

   !> Scale of creepage.
   real(wp) function creep_scale(shape)
      type(spot_shape_type), intent(in) :: shape

      creep_scale = 1.5_wp*friction_coefficient*load/(pi*a**2*shape%k*modulus)
   end function creep_scale

   !> Let a time pass: midpoint rule, in some steps that are all accepted.
   subroutine pass(contact, friction, shape, motion, carried, time, steps, y, wrench, lost)
      type(tangential_type), intent(inout) :: contact
      type(rung_type), intent(in) :: friction
      type(spot_shape_type), intent(in) :: shape
      !> Sliding velocity and spin.
      real(wp), intent(in) :: motion(3)
      !> Velocity of the material through the spot.
      real(wp), intent(in) :: carried(2)
      real(wp), intent(in) :: time
      integer, intent(in) :: steps
      real(wp), intent(inout) :: y(:)
      !> At the end.
      real(wp), intent(out) :: wrench(3)
      !> Work that was taken, added to.
      real(wp), intent(inout), optional :: lost
      type(passing_type) :: rolls
      real(wp) :: rates(size(y)), h
      integer :: i

      rolls = passing_type(load, a, motion(1), motion(2), motion(3), 0.0_wp, carried(1), carried(2))
      h = time/real(steps, wp)
      do i = 1, steps
         call contact%evolve(friction, shape, rolls, y, wrench, rates)
         call contact%evolve(friction, shape, rolls, y + 0.5_wp*h*rates, wrench, rates)
         if (present(lost)) lost = lost - h*dot_product(wrench, motion)
         y = y + h*rates
         call contact%evolve(friction, shape, rolls, y, wrench, rates)
         call contact%keep()
      end do
   end subroutine pass

   !> From the tractions of Cattaneo to those of Carter: a spot is loaded at rest and begins to roll
   !> along one of its axes. What boundary elements have to be shifted by to bear a constant force
   !> is the sliding of the law, whose force should be the same. Two lattices, extrapolated: the
   !> errors of one are as large as what is measured.
   subroutine test_onset(ratio, nu, forces, limit, elements, after)
      !> Half-length of the spot along the rolling over its half-width, and Poisson's ratio.
      real(wp), intent(in) :: ratio, nu
      !> Forces that are borne [f N].
      real(wp), intent(in) :: forces(:)
      !> What the force may be off by [f N].
      real(wp), intent(in) :: limit
      !> Elements across of the coarser lattice; 10 if not given.
      integer, intent(in), optional :: elements
      !> What takes the place of the forces once the spot has rolled over its length [f N].
      real(wp), intent(in), optional :: after(:)
      type(march_type) :: march(2)
      type(tangential_type) :: contact
      type(rung_type) :: friction
      type(spot_shape_type) :: shape
      type(worst_type) :: worst
      real(wp) :: y(n), by(3, 2), more(3), wrench(3), unit, force(2), dx
      integer :: i, j, k, direction, axes(3), across(2)

      across = [10, 20]
      if (present(elements)) across = [1, 2]*elements
      shape = elliptic_shape(min(ratio, 1.0_wp/ratio))
      ! Along and across the rolling, and about the normal, in the axes of the spot.
      axes = merge([1, 2, 3], [2, 1, 3], ratio >= 1.0_wp)
      unit = a*sqrt(shape%k)*creep_scale(shape)
      dx = 2.0_wp*a*min(ratio, 1.0_wp)/real(across(1), wp)
      do direction = 1, 2
         do i = 1, size(forces)
            call make("table", contact, friction, nu)
            do k = 1, 2
               call march(k)%begin(across(k), ratio, nu)
            end do
            y = 0.0_wp
            y(1) = 1.0_wp
            by = 0.0_wp
            ! In steps that become shorter.
            do j = 1, 10
               force = 0.0_wp
               force(direction) = -forces(i)*(1.0_wp - (1.0_wp - 0.1_wp*real(j, wp))**2)
               do k = 1, 2
                  call march(k)%bear(force, .false., by(:, k))
               end do
               more = extrapolated(by)
               call pass(contact, friction, shape, more(axes)*unit, [0.0_wp, 0.0_wp], 1.0_wp, 1, &
                  y, wrench)
            end do
            wrench = wrench(axes)
            call check_close(wrench(direction)/(friction_coefficient*load), force(direction), &
               0.02_wp, "at rest: the force")
            by = 0.0_wp
            by(direction, :) = 2.0_wp*sqrt(ratio)/real(across(1), wp)*forces(i)*[0.3_wp, 0.15_wp]
            do j = 1, across(2)
               if (present(after) .and. j > across(1)) force(direction) = -after(i)
               call march(1)%bear(force, .true., by(:, 1))
               call march(2)%bear(force, .true., by(:, 2))
               more = by(:, 2)
               call march(2)%bear(force, .true., more)
               by(:, 2) = by(:, 2) + more
               call pass(contact, friction, shape, passed(by)*(unit/dx), &
                  merge([-1.0_wp, 0.0_wp], [0.0_wp, -1.0_wp], ratio >= 1.0_wp), dx, 16, y, wrench)
               by(:, 2) = more
               wrench = wrench(axes)
               call worst%note(maxval(abs(wrench(1:2)/(friction_coefficient*load) - force)), &
                  i + 10*direction)
            end do
         end do
      end do
      call worst%check_below(limit, "onset of rolling: force, in f N")

   contains

      !> Shift of infinitely small elements, from those of two lattices.
      pure function extrapolated(both) result(shift)
         real(wp), intent(in) :: both(3, 2)
         real(wp) :: shift(3)

         shift = 2.0_wp*both(:, 2) - both(:, 1)
      end function extrapolated

      !> The same in the axes of the spot.
      pure function passed(both) result(shift)
         real(wp), intent(in) :: both(3, 2)
         real(wp) :: shift(3)

         shift = extrapolated(both)
         shift = shift(axes)
      end function passed

   end subroutine test_onset

   !> From rest without tractions to rolling with a spin that goes on and no force: the sliding by
   !> which boundary elements bear none is that of the law, whose force and torque should be theirs.
   subroutine test_spin(ratio, spin, limits)
      !> Half-length of the spot along the rolling, which is along an axis, over its half-width.
      real(wp), intent(in) :: ratio
      !> Creepage of spin [e0/sqrt(a b)].
      real(wp), intent(in) :: spin
      !> What force [f N] and torque [f N sqrt(a b)] may be off by.
      real(wp), intent(in) :: limits(2)
      integer, parameter :: across(2) = [10, 20], elements = 20
      real(wp), parameter :: no_force(2) = 0.0_wp, weights(2) = [-1.0_wp, 2.0_wp]
      type(march_type) :: march(2)
      type(tangential_type) :: contact
      type(rung_type) :: friction
      type(spot_shape_type) :: shape
      type(worst_type) :: worst(2)
      real(wp) :: y(n), by(3, 2), shift(3), torque(2), wrench(3), length, e0, way, e(2)
      integer :: j, k, m

      shape = elliptic_shape(min(ratio, 1.0_wp/ratio))
      length = a*sqrt(shape%k)
      e0 = creep_scale(shape)
      e = merge([1.0_wp, 0.0_wp], [0.0_wp, 1.0_wp], ratio >= 1.0_wp)
      call make("table", contact, friction)
      y = 0.0_wp
      y(1) = 1.0_wp
      by = 0.0_wp
      do k = 1, 2
         call march(k)%begin(across(k), ratio, poisson)
         by(3, k) = spin*2.0_wp*sqrt(ratio)/real(across(k), wp)
      end do
      way = 2.0_wp*sqrt(ratio)/real(across(1), wp)
      do j = 1, elements
         shift = 0.0_wp
         do k = 1, 2
            do m = 1, k
               call march(k)%bear(no_force, .true., by(:, k))
               shift = shift + weights(k)*by(:, k)
            end do
            torque(k) = march(k)%torque()
         end do
         shift = shift*e0/way
         call pass(contact, friction, shape, [e(1)*shift(1) - e(2)*shift(2), &
            e(2)*shift(1) + e(1)*shift(2), shift(3)/length], -e, way*length, 16, y, wrench)
         wrench = wrench/(friction_coefficient*load*[1.0_wp, 1.0_wp, length])
         call worst(1)%note(norm2(wrench(1:2)), j)
         call worst(2)%note(abs(wrench(3) - dot_product(weights, torque)), j)
      end do
      call worst(1)%check_below(limits(1), "onset of spin: force, in f N")
      call worst(2)%check_below(limits(2), "onset of spin: torque, in f N sqrt(a b)")
   end subroutine test_spin

   !> Any creep that goes on ends in the wrench of the law, for every law.
   subroutine test_steady()
      character(len=*), parameter :: laws(5) = [character(len=7) :: "table", "brush", "fastsim", &
         "strip", "polach"]
      type(tangential_type) :: contact
      type(rung_type) :: friction
      type(spot_shape_type) :: shape
      type(random_type) :: random
      type(worst_type) :: worst
      real(wp) :: y(n), motion(3), e(3), wrench(3), expected(3), scale(3)
      integer :: i, j

      do i = 1, size(laws)
         do j = 1, 4
            shape = circular_shape
            if (mod(j, 2) == 0) shape = elliptic_shape(0.5_wp)
            call make(trim(laws(i)), contact, friction)
            e = random%vector(3)
            e = [e(1:2)/norm2(e(1:2)), 0.0_wp]
            motion = 0.8_wp*creep_scale(shape)*random%vector(3)*[1.0_wp, 1.0_wp, 1.0_wp/a]
            y = 0.0_wp
            y(1) = 1.0_wp
            call pass(contact, friction, shape, motion, -e(1:2), 60.0_wp*a, 6000, y, wrench)
            call contact%carry%creep%wrench(creep_spot(shape, friction_coefficient, modulus, &
               poisson), passing_type(load, a, motion(1), motion(2), motion(3), 0.0_wp, -e(1), &
               -e(2)), expected)
            scale = friction_coefficient*load*[1.0_wp, 1.0_wp, a]
            call worst%note(maxval(abs(wrench - expected)/scale), i)
         end do
      end do
      call worst%check_below(1.0e-6_wp, "steady rolling with memory: wrench of the law")
   end subroutine test_steady

   !> Steady rolling with memory bears what the law of creep says, with spin and where the law is on
   !> the limit of full sliding.
   subroutine test_steady_wrench()
      character(len=*), parameter :: laws(5) = [character(len=7) :: "table", "brush", "fastsim", &
         "strip", "polach"]
      ! k, direction of the rolling [deg], creepages along the axes and spin times a, in e0.
      real(wp), parameter :: with_spin(5, 5) = reshape([ &
         1.0_wp, 0.0_wp, 0.0_wp, -1.28_wp, 4.3_wp, &
         1.0_wp, 40.0_wp, 0.0_wp, 0.0_wp, -5.0_wp, &
         0.5_wp, 0.0_wp, 0.3_wp, -0.6_wp, 3.0_wp, &
         0.5_wp, 90.0_wp, 0.0_wp, 0.0_wp, 4.0_wp, &
         0.3_wp, 0.0_wp, 0.0_wp, -1.0_wp, 4.0_wp], [5, 5])
      real(wp), parameter :: on_the_limit(5, 4) = reshape([ &
         1.0_wp, 53.0_wp, 2.0_wp, 0.0_wp, 0.0_wp, &
         1.0_wp, 53.0_wp, 0.0_wp, 10.0_wp, 0.0_wp, &
         1.0_wp, 0.0_wp, -4.0_wp, 4.0_wp, 0.5_wp, &
         0.5_wp, 30.0_wp, -6.0_wp, 3.0_wp, 1.0_wp], [5, 4])
      type(worst_type) :: within, limit
      integer :: i, j

      do j = 1, size(with_spin, 2)
         call within%note(off_the_law("table", poisson, with_spin(:, j)), j)
      end do
      call within%check_below(1.0e-6_wp, "steady rolling with spin: wrench of the law")
      do i = 1, size(laws)
         do j = 1, size(on_the_limit, 2)
            call limit%note(off_the_law(trim(laws(i)), 0.45_wp, on_the_limit(:, j)), 10*i + j)
         end do
      end do
      call limit%check_below(2.0e-3_wp, "steady rolling on the limit: wrench of the law")
   end subroutine test_steady_wrench

   !> What a contact with memory bears after 60 semi-axes of rolling, off what the law says: the
   !> largest component over f N and f N a.
   real(wp) function off_the_law(law, ratio, state) result(off)
      character(len=*), intent(in) :: law
      !> Poisson's ratio.
      real(wp), intent(in) :: ratio
      !> As the states of `test_steady_wrench`.
      real(wp), intent(in) :: state(5)
      type(tangential_type) :: contact
      type(rung_type) :: friction
      type(spot_shape_type) :: shape
      real(wp) :: y(n), motion(3), e(2), wrench(3), expected(3)

      shape = circular_shape
      if (state(1) < 1.0_wp) shape = elliptic_shape(state(1))
      call make(law, contact, friction, ratio)
      e = [cos(state(2)*pi/180.0_wp), sin(state(2)*pi/180.0_wp)]
      motion = creep_scale(shape)*state(3:)*[1.0_wp, 1.0_wp, 1.0_wp/a]
      y = 0.0_wp
      y(1) = 1.0_wp
      call pass(contact, friction, shape, motion, -e, 60.0_wp*a, 12000, y, wrench)
      call contact%carry%creep%wrench(creep_spot(shape, friction_coefficient, modulus, ratio), &
         passing_type(load, a, motion(1), motion(2), motion(3), 0.0_wp, -e(1), -e(2)), expected)
      off = maxval(abs(wrench - expected)/(friction_coefficient*load*[1.0_wp, 1.0_wp, a]))
   end function off_the_law

   !> What is remembered on an ellipse along another axis than its own is not less after a step.
   subroutine test_kept_on_ellipse()
      type(tangential_type) :: contact
      type(rung_type) :: friction
      type(spot_shape_type) :: shape
      type(worst_type) :: worst
      ! Shifts along the axes of the spot, which have their larger part along the other one seen
      ! from the axis that turns with the material: what is taken for what gains or loses.
      real(wp), parameter :: shifts(2, 2) = reshape([1.0_wp, -0.5_wp, 0.5_wp, 1.0_wp], [2, 2])
      real(wp) :: y(6), motion(3), wrench(3), before(3), limit
      integer :: i

      shape = elliptic_shape(0.4_wp)
      limit = friction_coefficient*load
      do i = 1, 2
         call make("", contact, friction)
         y = 0.0_wp
         y(1:2) = [0.8_wp, 0.6_wp]
         motion = 0.3_wp*creep_scale(shape)*a*[shifts(:, i), 0.2_wp/a]
         call pass(contact, friction, shape, motion, [0.0_wp, 0.0_wp], 1.0_wp, 1, y, before)
         call check(norm2(before(1:2)) > 0.1_wp*limit, "an ellipse bears a shift")
         motion = 0.0_wp
         call pass(contact, friction, shape, motion, [0.0_wp, 0.0_wp], 1.0_wp, 20, y, wrench)
         call worst%note(maxval(abs(wrench - before)/(limit*[1.0_wp, 1.0_wp, a])), i)
      end do
      call worst%check_below(1.0e-13_wp, "an ellipse keeps what it bears")
   end subroutine test_kept_on_ellipse

   !> Without rolling the law of creep changes nothing, to the bit.
   subroutine test_rest()
      type(tangential_type) :: with, without
      type(rung_type) :: friction
      type(random_type) :: random
      real(wp) :: y(n), other(6), motion(3), wrench(3), expected(3)
      integer :: i

      call make("table", with, friction)
      call make("", without, friction)
      y = 0.0_wp
      y(1) = 1.0_wp
      other = y(:6)
      do i = 1, 20
         motion = creep_scale(circular_shape)*a*random%vector(3)*[1.0_wp, 1.0_wp, 1.0_wp/a]
         call pass(with, friction, circular_shape, motion, [0.0_wp, 0.0_wp], 1.0_wp, 2, y, wrench)
         call pass(without, friction, circular_shape, motion, [0.0_wp, 0.0_wp], 1.0_wp, 2, other, &
            expected)
         call check(all(abs(wrench - expected) <= 0.0_wp), "at rest: as without a law of creep")
      end do
   end subroutine test_rest

   !> Derivatives of wrench and rates by all that they depend on, against differences.
   subroutine test_slopes()
      type(tangential_type) :: contact
      type(rung_type) :: friction
      type(spot_shape_type) :: shape
      type(random_type) :: random
      type(worst_type) :: worst
      type(passing_type) :: rolls
      real(wp) :: y(n), motion(3), wrench(3), rates(n), slopes(3 + n, 5 + n), h(5 + n), &
         unit(3 + n), e0, ahead(3 + n), behind(3 + n)
      real(wp), parameter :: carried(2) = [-0.8_wp, 0.6_wp]
      integer :: i, j

      do i = 1, 20
         shape = circular_shape
         if (mod(i, 2) == 0) shape = elliptic_shape(0.5_wp)
         call make("table", contact, friction)
         e0 = creep_scale(shape)
         y = 0.0_wp
         y(1:2) = [0.6_wp, 0.8_wp]
         motion = 0.5_wp*e0*random%vector(3)*[1.0_wp, 1.0_wp, 1.0_wp/a]
         call pass(contact, friction, shape, motion, carried, a, 10, y, wrench)
         y(3:5) = y(3:5) + 0.1_wp*e0*a*random%vector(3)*[1.0_wp, 1.0_wp, 1.0_wp/a]
         rolls = passing_type(load, a, motion(1), motion(2), motion(3), 0.0_wp, carried(1), &
            carried(2))
         call contact%vary(friction, shape, rolls, y, wrench, rates, slopes)
         h = 1.0e-6_wp*[load, a, e0, e0, e0/a, 1.0_wp, 1.0_wp, e0*a, e0*a, e0, a, e0, e0, &
            e0/a]
         unit(1:3) = friction_coefficient*load*[1.0_wp, 1.0_wp, a]
         unit(4:) = [1.0_wp, 1.0_wp, e0, e0, e0/a, 1.0_wp, e0/a, e0/a, e0/a**2]
         do j = 1, 5 + n
            call at(h(j), ahead)
            call at(-h(j), behind)
            call worst%note(maxval(abs((ahead - behind)/(2.0_wp*h(j)) - slopes(:, j))/unit) &
               *h(j)*1.0e6_wp, j)
         end do
      end do
      call worst%check_below(2.0e-4_wp, "rolling with memory: derivatives")

   contains

      !> Wrench and rates where one quantity is changed.
      subroutine at(change, values)
         real(wp), intent(in) :: change
         real(wp), intent(out) :: values(3 + n)
         type(passing_type) :: there
         real(wp) :: moved(n)

         there = rolls
         moved = y
         select case (j)
         case (1)
            there%load = there%load + change
         case (2)
            there%a = there%a + change
         case (3)
            there%vx = there%vx + change
         case (4)
            there%vy = there%vy + change
         case (5)
            there%w = there%w + change
         case default
            moved(j - 5) = moved(j - 5) + change
         end select
         call contact%evolve(friction, shape, there, moved, values(:3), values(4:))
      end subroutine at

   end subroutine test_slopes

   !> Over any history, with rolling that turns, stops and comes back, more work is taken than
   !> given.
   subroutine test_energy()
      type(tangential_type) :: contact
      type(rung_type) :: friction
      type(spot_shape_type) :: shape
      type(random_type) :: random
      real(wp) :: y(n), motion(3), e(3), wrench(3), lost, least
      integer :: i, j

      least = huge(least)
      do i = 1, 40
         shape = circular_shape
         if (mod(i, 2) == 0) shape = elliptic_shape(0.3_wp)
         call make("table", contact, friction)
         y = 0.0_wp
         y(1) = 1.0_wp
         lost = 0.0_wp
         do j = 1, 40
            e = 0.0_wp
            if (mod(j, 5) > 0) e = random%vector(3)
            motion = random%decades(-1.5_wp, 0.7_wp)*creep_scale(shape)*random%vector(3) &
               *[1.0_wp, 1.0_wp, 1.0_wp/a]
            call pass(contact, friction, shape, motion, e(1:2), 0.5_wp*a, 20, y, wrench, lost)
            least = min(least, lost/(friction_coefficient*load*a*creep_scale(shape)))
         end do
      end do
      call check(least > -1.0e-6_wp, "rolling with memory: what is taken is never given back")
   end subroutine test_energy

   !> A wrench that is the reverse of what the creepage makes that is carried out drives by no more
   !> than a trace.
   subroutine test_drives()
      real(wp), parameter :: velocity(2) = [-1.0_wp, 0.0_wp]
      type(tangential_type) :: contact
      type(rung_type) :: friction
      type(random_type) :: random
      type(worst_type) :: worst
      real(wp) :: creepage(3), wrench(3), lost(3), rate(3)
      integer :: i

      call make("table", contact, friction)
      do i = 1, 100
         creepage = 5.0_wp*creep_scale(circular_shape)*random%vector(3)*[1.0_wp, 1.0_wp, 1.0_wp/a]
         call contact%carry%creep%wrench(creep_spot(circular_shape, friction_coefficient, modulus, &
            poisson), passing_type(load, a, creepage(1), creepage(2), creepage(3), 0.0_wp, &
            velocity(1), velocity(2)), wrench)
         wrench = -0.9_wp*wrench
         call contact%carry%lose(circular_shape, carried_type(load, a, velocity, creepage, wrench, &
            0.0_wp), lost, rate)
         call worst%note(dot_product(wrench, lost)/dot_product(wrench, creepage), i)
      end do
      call worst%check_below(0.02_wp, "rolling with memory: what is carried out drives nothing")
   end subroutine test_drives

end module test_transient
