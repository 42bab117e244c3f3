!> Slip of the nested shells of `contensou_contact_tangential_shells` after an elastic trial.
!>
!> In units of f N and of a length, with twists times the major semi-axis: a shell of the stiffness
!> K that bears g = K e after the trial e slips by the length s along u, |u| = 1, so that
!>    g - s K u = f(u),   f = d phi,   phi(v, w) = l2 Phi(v, c2 w) - l1 Phi(v, c1 w),
!> or sticks where h(u) = g.u - phi(u) is above zero for no u. Closed cases come first:
!> - neither torque nor twist: the limit is a circle of forces, and what is sought is one number;
!> - a circular spot: the slip has the direction of the trial in the plane, which leaves one angle,
!>   and with tau = W/v force and torque follow from one function, which is tabulated for tau <= 1
!>   with its derivative; a cubic and a quartic of 1/tau above;
!> - else Newton's method for the direction, with the derivatives of the exact wrench.
!> Shells side by side, `contensou_contact_tangential_abreast`, come first.
!> Where a shell slips steps are of the third order, as its second derivatives cost little more, and
!> on a circle of the fourth.
!>
!> A rung is another friction model with the wrench W of the whole spot in the place of -dPhi: of
!> its force each shell has the share l2 - l1, of its torque l2 c2 - l1 c1. Most have no potential,
!> and their limits need not be convex.
module contensou_contact_tangential_slip
   use contensou_base_kinds, only : wp
   use contensou_base_vectors, only : cross
   use contensou_contact_spot, only : spot_shape_type
   use contensou_contact_tangential_abreast, only : abreast, short_slip, slip_in_plane, &
      step_on_circles, within_limit
   use contensou_contact_tangential_edges, only : edge_type
   use contensou_contact_tangential_ellipse_pass, only : close_by_bends, close_enough, &
      close_to_limit, lanes, least_pivot, least_spin, longest_step, smallest_force
   use contensou_contact_wrench, only : wrench_jacobian_kernel
   use contensou_contact_wrench_exact, only : wrench_exact_bends
   use contensou_contact_wrench_scaling, only : slip_type
   implicit none(type, external)
   private

   public :: slip_of_shell, sliding_force, stiffness_after, within_rungs, shell_type, shared_type

   !> A shell after an elastic trial, in units of f N and of a length.
   type :: shell_type
      !> Shape of the spot.
      type(spot_shape_type) :: shape
      !> Edges of the shell.
      type(edge_type) :: inner, outer
      !> Friction model; not associated for the exact wrench.
      procedure(wrench_jacobian_kernel), pointer, nopass :: rung => null()
      !> Against shifts along the axes, and the twist times the semi-axis.
      real(wp) :: stiffness(3) = 0.0_wp
      !> Elastic displacement of the trial.
      real(wp) :: trial(3) = 0.0_wp
   contains
      procedure :: load => load_of
      procedure :: torque => torque_of
   end type shell_type

   !> What the edge between two shells bears when it slides in some direction, which both need.
   type :: shared_type
      !> Load within the edge, below zero before anything is set.
      real(wp) :: load = -1.0_wp
      !> Direction.
      real(wp) :: u(3) = 0.0_wp
      real(wp) :: force(3) = 0.0_wp
      !> Its derivatives by the direction.
      real(wp) :: hessian(3, 3) = 0.0_wp
      !> Second derivatives of the force in the plane, as of `wrench_exact_bends`.
      real(wp) :: bends(4) = 0.0_wp
   end type shared_type

   !> Farthest direction from which one such step comes close.
   real(wp), parameter :: near = 0.02_wp

   !> Below this size a step is Newton's whatever it gains, which rounding errors hide.
   real(wp), parameter :: close_by = 1.0e-4_wp

   !> Gain below which a direction is too poor to begin with.
   real(wp), parameter :: poor_gain = -0.5_wp

   !> Slip in units of the trial below which the steps of a direction are those of that slip:
   !> without one nothing is known of the step along the direction, which is left out anyway.
   real(wp), parameter :: least_slip = 1.0e-10_wp

   !> Iterations for the slip of a shell, and halvings of a step.
   integer, parameter :: most_iterations = 60, most_halvings = 30

   !> Iterations after which every second one halves the range where the root is: the limit of a
   !> narrow shell bends sharply where the centre of rotation is on it, and Newton's steps may jump
   !> to and fro there.
   integer, parameter :: newton_alone = 8

   !> What is within the limits of all rungs, as a part of the double cone of pure sliding and pure
   !> spinning: `pade11` on a circle comes down to 0.77.
   real(wp), parameter :: within_rungs = 0.25_wp

contains

   !> Force of sliding without a twist.
   pure real(wp) function load_of(self)
      class(shell_type), intent(in) :: self

      load_of = self%outer%load - self%inner%load
   end function load_of

   !> Torque of spinning without sliding.
   pure real(wp) function torque_of(self)
      class(shell_type), intent(in) :: self

      torque_of = self%shape%torque*(self%outer%load*self%outer%size &
         - self%inner%load*self%inner%size)
   end function torque_of

   !> Slip of a shell. Where it slips by the length p along u, the force is that of sliding along u
   !> and equals stiffness*(trial - p*u).
   pure subroutine slip_of_shell(shell, doubt, shared, force, direction, slips, work)
      type(shell_type), intent(in) :: shell
      !> By how much the direction may be off where it is sought first.
      real(wp), intent(in) :: doubt
      !> What was found for the shell outside of it, if any, and for this one.
      type(shared_type), intent(inout) :: shared
      !> Force of the trial on entry; that of sliding if it slips.
      real(wp), intent(inout) :: force(3)
      !> Direction of slip where it is sought first, or zero; that of the slip.
      real(wp), intent(inout) :: direction(3)
      logical, intent(out) :: slips
      !> Work of the slip.
      real(wp), intent(out) :: work
      real(wp) :: load, torque, sliding, inside

      slips = .false.
      work = 0.0_wp
      load = shell%load()
      torque = shell%torque()
      if (.not. (load > 0.0_wp .and. torque > 0.0_wp .and. shell%stiffness(1) > 0.0_wp .and. &
         shell%stiffness(2) > 0.0_wp .and. shell%stiffness(3) > 0.0_wp)) then
         ! So narrow that rounding errors leave nothing of it.
         force = 0.0_wp
         slips = .true.
         return
      end if
      sliding = sqrt(force(1)**2 + force(2)**2)
      ! The limit holds its corners, pure sliding and pure spinning, and is convex.
      inside = 1.0_wp
      if (associated(shell%rung) .and. (abs(force(3)) > 0.0_wp .or. &
         abs(shell%trial(3)) > 0.0_wp)) inside = within_rungs
      if (sliding*torque + abs(force(3))*load <= inside*load*torque) return
      if (abs(force(3)) <= 0.0_wp .and. abs(shell%trial(3)) <= 0.0_wp) then
         slips = .true.
         call slip_alone(load, shell%stiffness, shell%trial, force, direction, work)
      else if (associated(shell%rung)) then
         call slip_by_rung(shell, force, direction, slips, work)
      else if (abs(shell%stiffness(1) - shell%stiffness(2)) <= 0.0_wp .and. &
         .not. shell%shape%c > 0.0_wp) then
         call slip_on_circle(shell, force, direction, slips, work)
      else
         call slip_on_ellipse(shell, doubt, shared, force, direction, slips, work)
      end if
   end subroutine slip_of_shell

   !> Slip of one shell that slips along the plane only.
   pure subroutine slip_alone(load, stiffness, trial, force, direction, work)
      real(wp), intent(in) :: load
      real(wp), intent(in) :: stiffness(3)
      real(wp), intent(in) :: trial(3)
      !> Force of the trial on entry, larger than the load; of sliding on return.
      real(wp), intent(inout) :: force(3)
      real(wp), intent(out) :: direction(3)
      real(wp), intent(out) :: work
      real(wp), dimension(abreast, 2) :: stiffnesses, trials, forces, directions
      real(wp), dimension(abreast) :: loads, works

      loads(1) = load
      stiffnesses(1, :) = stiffness(1:2)
      trials(1, :) = trial(1:2)
      forces(1, :) = force(1:2)
      call slip_in_plane(1, loads, stiffnesses, trials, forces, directions, works)
      force(1:2) = forces(1, :)
      direction = [directions(1, :), 0.0_wp]
      work = works(1)
   end subroutine slip_alone

   !> Slip of a shell of a circular spot: steps as of `step_on_circles` are kept between directions
   !> where less and more spin is known to be needed, in the quadrant where the shell slips.
   pure subroutine slip_on_circle(shell, force, direction, slips, work)
      type(shell_type), intent(in) :: shell
      !> Force of the trial on entry; that of sliding if it slips.
      real(wp), intent(inout) :: force(3)
      !> Direction where it is sought first, or zero; that of the slip.
      real(wp), intent(inout) :: direction(3)
      logical, intent(out) :: slips
      real(wp), intent(out) :: work
      real(wp), dimension(lanes, 2) :: load, size, stiffness, g, u, new, f
      real(wp) :: off(lanes), plane(2), low(2), high(2), length
      integer :: i

      ! Against shift and twist.
      stiffness(1, :) = shell%stiffness(2:3)
      load(1, :) = [shell%outer%load, shell%inner%load]
      size(1, :) = [shell%outer%size, shell%inner%size]
      length = sqrt(shell%trial(1)**2 + shell%trial(2)**2)
      plane = 0.0_wp
      if (length > 0.0_wp) plane = shell%trial(1:2)/length
      g(1, :) = [stiffness(1, 1)*length, abs(force(3))]
      u(1, 1) = direction(1)*plane(1) + direction(2)*plane(2)
      u(1, 2) = direction(3)*sign(1.0_wp, force(3))
      if (.not. min(u(1, 1), u(1, 2)) > 0.0_wp) then
         ! Between those of an infinitely short and an infinitely long slip.
         u(1, 1) = g(1, 1)/shell%load()**2
         u(1, 2) = g(1, 2)/(load(1, 1)*size(1, 1) - load(1, 2)*size(1, 2))**2
      end if
      u(1, :) = u(1, :)/sqrt(u(1, 1)**2 + u(1, 2)**2)
      low = [1.0_wp, 0.0_wp]
      high = [0.0_wp, 1.0_wp]
      f = 0.0_wp
      do i = 1, most_iterations
         call step_on_circles(1, load, size, stiffness, g, u, off, new, f)
         if (off(1) <= 1.0_wp) then
            u(1, :) = new(1, :)
            exit
         end if
         if (new(1, 2)*u(1, 1) > new(1, 1)*u(1, 2)) then
            low = u(1, :)
         else
            high = u(1, :)
         end if
         if (.not. ((i <= newton_alone .or. mod(i, 2) == 0) .and. &
            min(low(1)*new(1, 2) - low(2)*new(1, 1), new(1, 1)*high(2) - new(1, 2)*high(1)) &
            >= 0.0_wp)) then
            new(1, :) = (low + high)/sqrt((low(1) + high(1))**2 + (low(2) + high(2))**2)
         end if
         u(1, :) = new(1, :)
      end do
      length = (g(1, 1) - f(1, 1))*u(1, 1) + (g(1, 2) - f(1, 2))*u(1, 2)
      slips = length > 0.0_wp
      work = 0.0_wp
      if (.not. slips) return
      direction = [u(1, 1)*plane, sign(u(1, 2), force(3))]
      work = (f(1, 1)*u(1, 1) + f(1, 2)*u(1, 2))*length/(stiffness(1, 1)*u(1, 1)**2 &
         + stiffness(1, 2)*u(1, 2)**2)
      force = [f(1, 1)*plane, sign(f(1, 2), force(3))]
   end subroutine slip_on_circle

   !> Slip of a shell of any spot.
   !>
   !> Newton's method for the direction u, |u| = 1, with the derivatives of the force of sliding.
   !> With h(u) = g.u - phi(u), g the force of the trial, a slip along u has the length h/(u.K u)
   !> and gains h^2/(2 u.K u) where h > 0. Where h <= 0 what is sought is the u whose force f is
   !> along g, the largest of g.u/phi(u), until either h > 0 or g is seen to be within the limit.
   !> Steps that do not gain are halved.
   pure subroutine slip_on_ellipse(shell, doubt, shared, force, direction, slips, work)
      !> One of the exact wrench.
      type(shell_type), intent(in) :: shell
      !> By how much the direction may be off where it is sought first.
      real(wp), intent(in) :: doubt
      !> What was found for the shell outside of it, if any, and for this one.
      type(shared_type), intent(inout) :: shared
      !> Force of the trial on entry; that of sliding if it slips.
      real(wp), intent(inout) :: force(3)
      !> Direction where it is sought first, or zero; that of the slip, or where the shell bears the
      !> most before it slips.
      real(wp), intent(inout) :: direction(3)
      logical, intent(out) :: slips
      !> Of the slip.
      real(wp), intent(out) :: work
      real(wp) :: stiffness(3), gain, new_gain, length, u(3), new(3), f(3), new_f(3), &
         hessian(3, 3), new_hessian(3, 3), bends(4), new_bends(4), step(3), bent(3), more(3), &
         rest(3), size, tolerance, diagonal(3), trial
      integer :: i, k

      stiffness = shell%stiffness
      trial = sqrt(dot_product(shell%trial, shell%trial))
      slips = .false.
      work = 0.0_wp
      gain = -1.0_wp
      u = direction
      size = dot_product(u, u)
      if (size > 0.0_wp) then
         u = u/sqrt(size)
         ! That of the shell outside of it, whose edge is known there, unless its own is far better.
         if (abs(shared%load - shell%outer%load) <= 0.0_wp) then
            step = u - shared%u
            size = sqrt(dot_product(step, step))
            if (size < close_by_bends .or. (doubt > close_by_bends .and. size < near)) u = shared%u
         end if
         call sliding_force(shell, u, shared, f, hessian, bends)
         gain = gain_of(force, f, u, stiffness)
      end if
      if (gain < poor_gain) then
         u = first_direction(shell, force)
         call sliding_force(shell, u, shared, f, hessian, bends)
         gain = gain_of(force, f, u, stiffness)
      end if
      do i = 1, most_iterations
         tolerance = close_enough
         length = dot_product(force - f, u)/dot_product(u, stiffness*u)
         if (length > 0.0_wp) then
            diagonal = max(length, least_slip*trial)*stiffness
            call solve(hessian, diagonal, force - f - length*stiffness*u, step)
            if (abs(u(3)) > least_spin .and. maxval(abs(step)) > close_enough) then
               call change_slopes(hessian, bends, u, step, bent)
               call solve(hessian, diagonal, -0.5_wp*bent, more)
               size = maxval(abs(step))
               if (maxval(abs(more)) < 0.5_wp*size) step = step + more
               ! Each order is to the next one as that was to it.
               if (maxval(abs(more))**2 <= smallest_force*size) tolerance = close_by_bends
               step = step/max(1.0_wp + dot_product(step, u), 0.5_wp)
            end if
         else
            if (within_limit(shell%load(), shell%torque(), force, f)) exit
            call solve((1.0_wp + gain)*hessian, short_slip*trial*stiffness, &
               force - (1.0_wp + gain)*f, step)
         end if
         step = step - dot_product(step, u)*u
         size = sqrt(dot_product(step, step))
         if (length > 0.0_wp .and. size < tolerance) then
            rest = hessian(:, 1)*step(1) + hessian(:, 2)*step(2) + hessian(:, 3)*step(3)
            bent = 0.0_wp
            if (size >= close_enough) call change_slopes(hessian, bends, u, step, bent)
            if (dot_product(bent, bent)**2 <= (4.0_wp*smallest_force)**2 &
               *dot_product(rest, rest)) then
               f = f + rest + 0.5_wp*bent
               u = u + step
               exit
            end if
         end if
         if (size > longest_step) step = step*(longest_step/size)
         if (length <= 0.0_wp .and. size < close_to_limit) exit
         do k = 1, most_halvings
            new = u + step
            new = new/sqrt(dot_product(new, new))
            call sliding_force(shell, new, shared, new_f, &
               new_hessian, new_bends)
            new_gain = gain_of(force, new_f, new, stiffness)
            if (new_gain > gain .or. size < close_by) exit
            step = 0.5_wp*step
         end do
         if (.not. (new_gain > gain .or. size < close_by)) exit
         u = new
         f = new_f
         hessian = new_hessian
         bends = new_bends
         gain = new_gain
      end do
      direction = u
      slips = gain > 0.0_wp
      if (.not. slips) return
      work = dot_product(f, u)*dot_product(force - f, u)/dot_product(u, stiffness*u)
      force = f
   end subroutine slip_on_ellipse

   !> Change of the derivatives of the force of sliding along a change of the direction, times that.
   !>
   !> A step s along the direction changes nothing, so s = p + e u with p in the plane; the torque
   !> follows from u.H = 0.
   pure subroutine change_slopes(hessian, bends, u, step, change)
      real(wp), intent(in) :: hessian(3, 3), bends(4)
      !> Direction, with a spin, and its change.
      real(wp), intent(in) :: u(3), step(3)
      real(wp), intent(out) :: change(3)
      real(wp) :: inverse, share, x, y, rates(3)

      inverse = 1.0_wp/u(3)
      share = step(3)*inverse
      x = step(1) - share*u(1)
      y = step(2) - share*u(2)
      change(1) = bends(1)*x*x + 2.0_wp*bends(2)*x*y + bends(3)*y*y
      change(2) = bends(2)*x*x + 2.0_wp*bends(3)*x*y + bends(4)*y*y
      rates = hessian(:, 1)*x + hessian(:, 2)*y
      change(3) = -(rates(1)*x + rates(2)*y + change(1)*u(1) + change(2)*u(2))*inverse
      change = change - 2.0_wp*share*rates
   end subroutine change_slopes

   !> What is gained by a slip along u; where it is not, g.u/phi(u) - 1, from -1 to 0.
   pure function gain_of(force, f, u, stiffness) result(gain)
      !> Force of the trial.
      real(wp), intent(in) :: force(3)
      !> Force of sliding along u.
      real(wp), intent(in) :: f(3)
      real(wp), intent(in) :: u(3)
      real(wp), intent(in) :: stiffness(3)
      real(wp) :: gain

      gain = dot_product(force - f, u)
      if (gain > 0.0_wp) then
         gain = gain*gain/dot_product(u, stiffness*u)
      else
         gain = max(gain/dot_product(f, u), -1.0_wp)
      end if
   end function gain_of

   !> Slip of a shell by a rung of the ladder: Newton's method for the direction as on an ellipse,
   !> without a potential to gain: from the last direction and from that of a short slip, with whole
   !> steps, and with steps after which less is left across. What it comes closest with does where
   !> it does not converge, as at the kinks of a rung: the force is one of sliding all the same.
   pure subroutine slip_by_rung(shell, force, direction, slips, work)
      type(shell_type), intent(in) :: shell
      !> Force of the trial on entry; that of sliding if it slips.
      real(wp), intent(inout) :: force(3)
      !> Direction where it is sought first, or zero; that of the slip.
      real(wp), intent(inout) :: direction(3)
      logical, intent(out) :: slips
      real(wp), intent(out) :: work
      real(wp) :: u(3), f(3), best_f(3), best(3), left, least
      logical :: found
      integer :: i

      work = 0.0_wp
      u = direction
      best = 0.0_wp
      best_f = 0.0_wp
      least = huge(least)
      do i = 1, 4
         ! The last direction is a good beginning where the trial pulls along it still.
         if (i == 3 .or. .not. dot_product(u, force) > 0.0_wp) u = first_direction(shell, force)
         call follow_rung(shell, force, mod(i, 2) == 0, u, f, left, found)
         ! Of a limit that is not convex not all directions along which nothing slips say so.
         found = found .and. dot_product(force - f, u) > 0.0_wp
         if (left < least .or. found) then
            least = left
            best = u
            best_f = f
         end if
         if (found) exit
      end do
      slips = dot_product(force - best_f, best) > 0.0_wp
      if (.not. slips) return
      direction = best
      work = dot_product(best_f, best)*dot_product(force - best_f, best) &
         /dot_product(best, shell%stiffness*best)
      force = best_f
   end subroutine slip_by_rung

   !> Newton's method for the direction of the slip by a rung.
   pure subroutine follow_rung(shell, force, descends, u, f, left, found)
      type(shell_type), intent(in) :: shell
      !> Force of the trial.
      real(wp), intent(in) :: force(3)
      !> Whether each step leaves less across.
      logical, intent(in) :: descends
      !> Direction to begin with, then the one that leaves the least.
      real(wp), intent(inout) :: u(3)
      !> Force of sliding along it, and the size of what it leaves across.
      real(wp), intent(out) :: f(3), left
      !> Whether it is the direction.
      logical, intent(out) :: found
      real(wp) :: stiffness(3), hessian(3, 3), rest(3), step(3), length, size, now(3), force_now(3)
      integer :: i

      stiffness = shell%stiffness
      left = huge(left)
      f = 0.0_wp
      now = u
      found = .false.
      step = 0.0_wp
      do i = 1, most_iterations
         call share_of_rung(shell, now, force_now, hessian)
         rest = force - force_now
         length = dot_product(rest, now)/dot_product(now, stiffness*now)
         if (length > 0.0_wp) rest = rest - length*stiffness*now
         rest = rest - dot_product(rest, now)*now
         size = norm2(rest)
         if (size < left) then
            left = size
            u = now
            f = force_now
         else if (descends) then
            step = 0.5_wp*step
            if (.not. norm2(step) >= close_enough) exit
            now = (u + step)/norm2(u + step)
            cycle
         end if
         call solve_any(hessian, max(length, short_slip*norm2(shell%trial))*stiffness, rest, step)
         step = step - dot_product(step, now)*now
         size = norm2(step)
         found = size < close_enough
         if (found) then
            u = now + step
            f = force_now + matmul(hessian, step)
            exit
         end if
         ! Where the derivatives are singular there is no step.
         if (.not. size < huge(size)) exit
         if (size > longest_step) step = step*(longest_step/size)
         now = (now + step)/norm2(now + step)
      end do
   end subroutine follow_rung

   !> Direction of an infinitely short slip, about.
   pure function first_direction(shell, force) result(u)
      type(shell_type), intent(in) :: shell
      !> Force of the trial.
      real(wp), intent(in) :: force(3)
      real(wp) :: u(3), load, torque

      load = shell%load()
      torque = shell%torque()
      u = force/[load, load, torque]**2
      u = u/sqrt(dot_product(u, u))
   end function first_direction

   !> Force that a shell bears when it slides, and its derivatives by the direction.
   pure subroutine sliding_force(shell, u, shared, force, hessian, bends)
      type(shell_type), intent(in) :: shell
      !> Direction of the slip.
      real(wp), intent(in) :: u(3)
      !> What was found for an edge, taken if it is the outer one; that for the inner edge.
      type(shared_type), intent(inout) :: shared
      real(wp), intent(out) :: force(3), hessian(3, 3)
      !> Second derivatives of the force in the plane; zero for a rung.
      real(wp), intent(out), optional :: bends(4)
      real(wp) :: bends_of_all(4)
      logical :: known

      if (associated(shell%rung)) then
         call share_of_rung(shell, u, force, hessian)
         if (present(bends)) bends = 0.0_wp
         return
      end if
      known = abs(shared%load - shell%outer%load) <= 0.0_wp
      if (known) known = all(abs(shared%u - u) <= 0.0_wp)
      if (known) then
         force = shared%force
         hessian = shared%hessian
         bends_of_all = shared%bends
      else
         call sliding_within(shell%shape, shell%outer, u, force, hessian, bends_of_all)
      end if
      shared%load = shell%inner%load
      shared%u = u
      if (present(bends)) bends = bends_of_all
      if (.not. shell%inner%load > 0.0_wp) return
      call sliding_within(shell%shape, shell%inner, u, shared%force, shared%hessian, shared%bends)
      force = force - shared%force
      hessian = hessian - shared%hessian
      if (present(bends)) bends = bends - shared%bends
   end subroutine sliding_force

   !> The same by a rung: its wrench for the whole spot, the force by the share of the load and the
   !> torque by that of the torque of spinning. What its wrench within two edges differs by is no
   !> limit: where one of them is on the flat side of a kink force would grow against the slip.
   pure subroutine share_of_rung(shell, u, force, hessian)
      type(shell_type), intent(in) :: shell
      !> Direction of the slip.
      real(wp), intent(in) :: u(3)
      real(wp), intent(out) :: force(3), hessian(3, 3)
      real(wp) :: shares(3)
      integer :: i

      call shell%rung(shell%shape, slip_type(u(1), u(2), u(3)), force, hessian)
      shares(1:2) = -shell%load()
      shares(3) = -(shell%outer%load*shell%outer%size - shell%inner%load*shell%inner%size)
      force = shares*force
      do i = 1, 3
         hessian(:, i) = shares*hessian(:, i)
      end do
   end subroutine share_of_rung

   !> Force of sliding of what is within an edge, by the exact wrench, and its derivatives.
   pure subroutine sliding_within(shape, edge, u, force, hessian, bends)
      type(spot_shape_type), intent(in) :: shape
      type(edge_type), intent(in) :: edge
      real(wp), intent(in) :: u(3)
      real(wp), intent(out) :: force(3), hessian(3, 3), bends(4)
      real(wp) :: arm
      integer :: i

      call wrench_exact_bends(shape, u(1), u(2), edge%size*u(3), force, hessian, bends)
      bends = -edge%load*bends
      arm = edge%load*edge%size
      force(1) = -edge%load*force(1)
      force(2) = -edge%load*force(2)
      force(3) = -arm*force(3)
      do i = 1, 2
         hessian(1, i) = -edge%load*hessian(1, i)
         hessian(2, i) = -edge%load*hessian(2, i)
         hessian(3, i) = -arm*hessian(3, i)
      end do
      hessian(1, 3) = -arm*hessian(1, 3)
      hessian(2, 3) = -arm*hessian(2, 3)
      hessian(3, 3) = -(arm*edge%size)*hessian(3, 3)
   end subroutine sliding_within

   !> Derivatives of the force of a shell that has slipped: by the trial, K A^-1 H/s with
   !> A = K + H/s, and by the limit, K A^-1 f, both in the units of the limit. H is that of the
   !> potential at the slip, s its length.
   pure subroutine stiffness_after(shell, direction, length, by_trial, by_limit)
      type(shell_type), intent(in) :: shell
      !> Direction and length of the slip.
      real(wp), intent(in) :: direction(3), length
      real(wp), intent(out) :: by_trial(3, 3), by_limit(3)
      real(wp) :: hessian(3, 3), force(3), column(3)
      type(shared_type) :: shared
      integer :: i

      call sliding_force(shell, direction, shared, force, hessian)
      do i = 1, 3
         call solve_for(shell%rung, hessian, length*shell%stiffness, hessian(:, i), column)
         by_trial(:, i) = shell%stiffness*column
      end do
      ! H/s and K of the same size: the slope by s K is that by K, times s.
      call solve_for(shell%rung, hessian, length*shell%stiffness, length*force, column)
      by_limit = shell%stiffness*column
   end subroutine stiffness_after

   !> Solve (hessian + diagonal) x = right; the derivatives of a potential are symmetric.
   pure subroutine solve_for(rung, hessian, diagonal, right, x)
      procedure(wrench_jacobian_kernel), pointer, intent(in) :: rung
      real(wp), intent(in) :: hessian(3, 3), diagonal(3), right(3)
      real(wp), intent(out) :: x(3)

      if (associated(rung)) then
         call solve_any(hessian, diagonal, right, x)
      else
         call solve(hessian, diagonal, right, x)
      end if
   end subroutine solve_for

   !> Solve (hessian + diagonal) x = right.
   pure subroutine solve_any(hessian, diagonal, right, x)
      real(wp), intent(in) :: hessian(3, 3), diagonal(3), right(3)
      real(wp), intent(out) :: x(3)
      real(wp) :: a(3, 3)
      integer :: i

      a = hessian
      do i = 1, 3
         a(i, i) = a(i, i) + diagonal(i)
      end do
      x = [dot_product(right, cross(a(:, 2), a(:, 3))), dot_product(right, cross(a(:, 3), &
         a(:, 1))), dot_product(right, cross(a(:, 1), a(:, 2)))] &
         /dot_product(a(:, 1), cross(a(:, 2), a(:, 3)))
   end subroutine solve_any

   !> Solve (hessian + diagonal) x = right; the matrix is symmetric and positive definite. Pivots
   !> are not below the diagonal, unless by what rounding makes of them, as the hessian is that of a
   !> convex function.
   pure subroutine solve(hessian, diagonal, right, x)
      real(wp), intent(in) :: hessian(3, 3), diagonal(3), right(3)
      real(wp), intent(out) :: x(3)
      real(wp) :: a11, a21, a31, a22, a32, a33, l21, l31, l32

      a11 = max(hessian(1, 1) + diagonal(1), diagonal(1), least_pivot)
      a21 = hessian(2, 1)
      a31 = hessian(3, 1)
      l21 = a21/a11
      l31 = a31/a11
      a22 = max(hessian(2, 2) + diagonal(2) - l21*a21, &
         epsilon(a22)*(hessian(2, 2) + diagonal(2)), diagonal(2), least_pivot)
      a32 = hessian(3, 2) - l21*a31
      l32 = a32/a22
      a33 = max(hessian(3, 3) + diagonal(3) - l31*a31 - l32*a32, &
         epsilon(a33)*(hessian(3, 3) + diagonal(3)), diagonal(3), least_pivot)
      x(1) = right(1)
      x(2) = right(2) - l21*x(1)
      x(3) = right(3) - l31*x(1) - l32*x(2)
      x(3) = x(3)/a33
      x(2) = x(2)/a22 - l32*x(3)
      x(1) = x(1)/a11 - l21*x(2) - l31*x(3)
   end subroutine solve

end module contensou_contact_tangential_slip
