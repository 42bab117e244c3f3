!> Conditions that end a run before the end of its time: where within a step one of them is met.
!>
!> A condition on a quantity is met where that crosses its threshold, found on the interpolant of
!> the step; one on the rest of bodies where their kinetic energy has been below its threshold for
!> as long as it asks, so that no turning point is taken for it.
module contensou_integrate_stops
   use contensou_base_checkpoint, only : checkpoint_type
   use contensou_base_kinds, only : wp
   use contensou_base_rotations, only : rotation_matrix
   use contensou_dynamics_mechanism, only : body_type
   use contensou_dynamics_scene, only : crossing_falling, crossing_rising, moves_freely, &
      motion_free, motion_rotor, stop_angle, stop_conforming, stop_lift, stop_position, stop_rest, &
      stop_speed, stop_spec_type, stop_spin, stop_touch
   use contensou_dynamics_state, only : position_of, quaternion_of, spin_of, velocity_of
   use contensou_integrate_integrator, only : integrator_type
   use contensou_special_bisection, only : bisection_type
   implicit none(type, external)
   private

   public :: stops_type

   !> What a march knows of the conditions that may end it.
   type :: stops_type
      !> The condition that has ended it; 0 for none.
      integer :: ended_by = 0
      !> The contact that has met it, if it is about contacts.
      integer :: contact = 0
      !> For each condition, since when bodies have been at rest [s]; negative if they are not.
      real(wp), allocatable :: since(:)
      !> For each condition, by how much its quantity was above its threshold at the end of the last
      !> step, before what events have changed there.
      real(wp), allocatable, private :: excess(:)
      !> Whether the quantity has not left the threshold at which it began.
      logical, allocatable, private :: fresh(:)
   contains
      procedure :: begin
      procedure :: near
      procedure :: find
      procedure :: of_event
      procedure :: of_conforming
      procedure :: exchange
   end type stops_type

   !> Places within a step at which a quantity is looked at.
   integer, parameter :: parts = 4

   !> A quantity is on its threshold within this share of it.
   real(wp), parameter :: on_threshold = 1.0e-12_wp

contains

   !> Begin where a march begins or goes on.
   subroutine begin(self, specs, bodies, goes_on, t, y)
      class(stops_type), intent(inout) :: self
      !> The conditions.
      type(stop_spec_type), intent(in) :: specs(:)
      type(body_type), intent(in) :: bodies(:)
      !> Whether the march has begun before.
      logical, intent(in) :: goes_on
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)
      integer :: i, n

      n = size(specs)
      if (.not. allocated(self%since)) allocate(self%since(n), source=-1.0_wp)
      if (allocated(self%excess)) deallocate(self%excess, self%fresh)
      allocate(self%excess(n), self%fresh(n))
      do i = 1, n
         self%excess(i) = excess_of(specs(i), bodies, y)
         self%fresh(i) = abs(self%excess(i)) <= on_threshold*abs(specs(i)%threshold)
         if (goes_on .or. specs(i)%kind /= stop_rest) cycle
         if (self%excess(i) <= 0.0_wp) self%since(i) = t
      end do
   end subroutine begin

   !> Whether a condition on a quantity may be met within a step.
   logical function near(self, specs, bodies, t_before, y_before, t, y)
      class(stops_type), intent(in) :: self
      !> The conditions.
      type(stop_spec_type), intent(in) :: specs(:)
      type(body_type), intent(in) :: bodies(:)
      !> Times of the ends of the step [s].
      real(wp), intent(in) :: t_before, t
      !> States there.
      real(wp), intent(in) :: y_before(:), y(:)
      real(wp) :: before, now, reach
      integer :: i

      near = .true.
      do i = 1, size(specs)
         if (.not. is_quantity(specs(i))) cycle
         before = excess_of(specs(i), bodies, y_before)
         now = excess_of(specs(i), bodies, y)
         if ((before > 0.0_wp .neqv. now > 0.0_wp) .or. &
            (before > 0.0_wp .neqv. self%excess(i) > 0.0_wp)) return
         if (self%since(i) >= 0.0_wp .and. self%since(i) + specs(i)%duration <= t) return
         ! How far the quantity may go and come back: twice as far as its rates at the ends tell,
         ! or, where these are not known, four times as far as it went.
         select case (specs(i)%kind)
         case (stop_angle)
            reach = 2.0_wp*(t - t_before)*max(norm2(spin_of(y_before, specs(i)%body)), &
               norm2(spin_of(y, specs(i)%body)))
         case (stop_position)
            reach = 2.0_wp*(t - t_before)*max(norm2(velocity_of(y_before, specs(i)%body)), &
               norm2(velocity_of(y, specs(i)%body)))
         case default
            reach = max(4.0_wp*abs(now - before), 0.5_wp*abs(specs(i)%threshold))
         end select
         if (min(abs(before), abs(now)) <= reach) return
      end do
      near = .false.
   end function near

   !> Find the first time in a step at which a condition on a quantity is met.
   subroutine find(self, specs, bodies, integrator, t_before, y_before, t, found, t_found)
      class(stops_type), intent(inout) :: self
      !> The conditions.
      type(stop_spec_type), intent(in) :: specs(:)
      type(body_type), intent(in) :: bodies(:)
      !> The integration, at the end of the step.
      class(integrator_type), intent(inout) :: integrator
      !> Times of the ends of the step [s].
      real(wp), intent(in) :: t_before, t
      !> State at its beginning.
      real(wp), intent(in) :: y_before(:)
      !> The condition; 0 if none is met.
      integer, intent(out) :: found
      !> When it is met [s]; after the step if none is.
      real(wp), intent(out) :: t_found
      real(wp) :: excess(0:parts), times(0:parts), y(size(y_before), parts), root
      integer :: i, k

      found = 0
      t_found = huge(t)
      do k = 0, parts
         times(k) = t_before + k*(t - t_before)/parts
      end do
      times(parts) = t
      do k = 1, parts
         call integrator%interpolate(times(k), y(:, k))
      end do
      do i = 1, size(specs)
         if (.not. is_quantity(specs(i))) cycle
         excess(0) = excess_of(specs(i), bodies, y_before)
         do k = 1, parts
            excess(k) = excess_of(specs(i), bodies, y(:, k))
         end do
         ! An impact at the end of the last step.
         if (.not. self%fresh(i) .and. (self%excess(i) > 0.0_wp .neqv. excess(0) > 0.0_wp)) then
            call take(t_before, excess(0) > 0.0_wp)
         end if
         do k = 1, parts
            if (self%fresh(i)) then
               self%fresh(i) = abs(excess(k)) <= on_threshold*abs(specs(i)%threshold)
               if (specs(i)%kind /= stop_rest) cycle
            end if
            if (excess(k - 1) > 0.0_wp .eqv. excess(k) > 0.0_wp) cycle
            call locate(specs(i), times(k - 1), times(k), excess(k) > 0.0_wp, root)
            call take(root, excess(k) > 0.0_wp)
         end do
         self%excess(i) = excess(parts)
         if (specs(i)%kind == stop_rest .and. self%since(i) >= 0.0_wp) then
            if (self%since(i) + specs(i)%duration <= t) call meet(max(self%since(i) + &
               specs(i)%duration, t_before))
         end if
      end do

   contains

      !> A quantity crosses its threshold.
      subroutine take(at, rises)
         !> Time [s].
         real(wp), intent(in) :: at
         !> Whether it is above from there on.
         logical, intent(in) :: rises

         if (specs(i)%kind == stop_rest) then
            if (rises .and. self%since(i) >= 0.0_wp) then
               if (self%since(i) + specs(i)%duration <= at) then
                  call meet(self%since(i) + specs(i)%duration)
               end if
            end if
            self%since(i) = merge(-1.0_wp, at, rises)
         else if (rises .and. specs(i)%crossing /= crossing_falling) then
            call meet(at)
         else if (.not. rises .and. specs(i)%crossing /= crossing_rising) then
            call meet(at)
         end if
      end subroutine take

      !> The condition is met.
      subroutine meet(at)
         !> Time [s].
         real(wp), intent(in) :: at

         if (at >= t_found) return
         t_found = at
         found = i
      end subroutine meet

      !> Time at which a quantity crosses its threshold.
      subroutine locate(spec, low, high, rises, root)
         type(stop_spec_type), intent(in) :: spec
         !> Times before and behind [s].
         real(wp), intent(in) :: low, high
         !> Whether it is above behind.
         logical, intent(in) :: rises
         !> The time, on the side behind [s].
         real(wp), intent(out) :: root
         type(bisection_type) :: search
         real(wp) :: at(size(y_before))

         call search%begin(low, high, steps=80)
         do while (search%goes_on)
            call integrator%interpolate(search%middle, at)
            call search%narrow(excess_of(spec, bodies, at) > 0.0_wp .eqv. rises)
         end do
         root = search%high
      end subroutine locate

   end subroutine find

   !> The condition that a touch or a lift-off meets; 0 for none.
   pure integer function of_event(self, specs, touches, contact)
      class(stops_type), intent(in) :: self
      !> The conditions.
      type(stop_spec_type), intent(in) :: specs(:)
      !> Whether the contact touches, not lifts off.
      logical, intent(in) :: touches
      integer, intent(in) :: contact

      of_event = first_of(specs, merge(stop_touch, stop_lift, touches), contact)
   end function of_event

   !> The condition that is met by a contact whose surfaces have come to conform; 0 for none.
   pure integer function of_conforming(self, specs, contact)
      class(stops_type), intent(in) :: self
      !> The conditions.
      type(stop_spec_type), intent(in) :: specs(:)
      integer, intent(in) :: contact

      of_conforming = first_of(specs, stop_conforming, contact)
   end function of_conforming

   !> The first condition of a kind that is about a contact; 0 for none.
   pure integer function first_of(specs, kind, contact)
      !> The conditions.
      type(stop_spec_type), intent(in) :: specs(:)
      !> One of the `stop_*` codes.
      integer, intent(in) :: kind
      integer, intent(in) :: contact

      do first_of = 1, size(specs)
         if (specs(first_of)%kind /= kind) cycle
         if (specs(first_of)%contact == 0 .or. specs(first_of)%contact == contact) return
      end do
      first_of = 0
   end function first_of

   !> Write what a march needs to go on to a checkpoint, or read it back.
   subroutine exchange(self, checkpoint)
      !> What is known; nothing is written without any condition.
      class(stops_type), intent(inout) :: self
      type(checkpoint_type), intent(inout) :: checkpoint

      if (.not. allocated(self%since)) return
      call checkpoint%exchange("at_rest_since", self%since)
   end subroutine exchange

   !> Whether a condition is one on a quantity.
   elemental logical function is_quantity(spec)
      type(stop_spec_type), intent(in) :: spec

      is_quantity = any(spec%kind == [stop_rest, stop_angle, stop_speed, stop_spin, stop_position])
   end function is_quantity

   !> By how much a quantity is above its threshold.
   pure real(wp) function excess_of(spec, bodies, y) result(excess)
      type(stop_spec_type), intent(in) :: spec
      type(body_type), intent(in) :: bodies(:)
      !> State.
      real(wp), intent(in) :: y(:)
      real(wp) :: axis(3), across(3)

      select case (spec%kind)
      case (stop_rest)
         excess = kinetic_energy(spec%body, bodies, y)
      case (stop_angle)
         axis = matmul(rotation_matrix(quaternion_of(y, spec%body)), spec%axis)
         across = [axis(2)*spec%direction(3) - axis(3)*spec%direction(2), &
            axis(3)*spec%direction(1) - axis(1)*spec%direction(3), &
            axis(1)*spec%direction(2) - axis(2)*spec%direction(1)]
         excess = atan2(norm2(across), dot_product(axis, spec%direction))
      case (stop_speed)
         excess = norm2(velocity_of(y, spec%body))
      case (stop_spin)
         excess = norm2(spin_of(y, spec%body))
      case (stop_position)
         excess = dot_product(position_of(y, spec%body), spec%direction)
      case default
         excess = 0.0_wp
      end select
      excess = excess - spec%threshold
   end function excess_of

   !> Kinetic energy of a body that forces move, or of all of them [J].
   pure real(wp) function kinetic_energy(body, bodies, y) result(energy)
      !> The body; 0 for all.
      integer, intent(in) :: body
      type(body_type), intent(in) :: bodies(:)
      !> State.
      real(wp), intent(in) :: y(:)
      real(wp) :: spin(3)
      integer :: i

      energy = 0.0_wp
      do i = 1, size(bodies)
         if (body /= 0 .and. body /= i) cycle
         if (moves_freely(bodies(i)%motion)) energy = energy + &
            0.5_wp*bodies(i)%mass*sum(velocity_of(y, i)**2)
         if (bodies(i)%motion == motion_free) energy = energy + &
            0.5_wp*sum(bodies(i)%inertia*spin_of(y, i)**2)
         if (bodies(i)%motion == motion_rotor) then
            spin = spin_of(y, i)
            energy = energy + 0.5_wp*sum(bodies(i)%inertia(:2)*spin(:2)**2)
         end if
      end do
   end function kinetic_energy

end module contensou_integrate_stops
