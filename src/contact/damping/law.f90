!> Damping part of a contact: what the normal force gains from the rate of approach, and what each
!> law of it must answer.
!>
!> All laws are of the form N = max(F_el + damping, 0): a contact never pulls.
module contensou_contact_damping_law
   use contensou_base_checkpoint, only : checkpoint_type
   use contensou_base_kinds, only : wp
   use contensou_contact_catalogue, only : model_type
   use contensou_contact_parameters, only : parameters_type, surroundings_type
   use contensou_contact_states, only : most_states, owner_type
   implicit none(type, external)
   private

   public :: damping_type, damping_model_type, damping_kernel, damping_slopes

   !> Relative step of differences.
   real(wp), parameter :: step = 6.0e-6_wp

   !> Rate of approach that is small [m/s].
   real(wp), parameter :: slow = 1.0e-3_wp

   !> A damping law with its parameters. One with states has `evolve` beside `force`, which is then
   !> that of a state in which it would stay.
   type, abstract, extends(owner_type) :: damping_type
   contains
      !> Damping force.
      procedure(force_of), deferred :: force
      !> Its derivatives.
      procedure(slopes_of), deferred :: slopes
      !> Total normal force.
      procedure, non_overridable :: total
      procedure :: evolve
      procedure :: vary
      procedure :: stored_energy
      procedure :: begin_impact
      procedure :: exchange
   end type damping_type

   !> A row in the table of the damping laws.
   type, extends(model_type) :: damping_model_type
      !> Makes the law from the values of its keys; not associated for `none`.
      procedure(new_damping), pointer :: create => null()
      !> Restitution of a rigid contact with this law; not associated if it has none.
      procedure(rigid_restitution), pointer, nopass :: restitute => null()
      !> The law as a function of its coefficient; not associated for a law that is none.
      procedure(damping_kernel), pointer, nopass :: kernel => null()
      !> Its derivatives.
      procedure(damping_slopes), pointer, nopass :: slopes => null()
   end type damping_model_type

   abstract interface
      !> Damping force [N].
      pure function damping_kernel(elastic, approach, rate, coefficient) result(f)
         import :: wp
         implicit none(type, external)
         !> Elastic force [N].
         real(wp), intent(in) :: elastic
         !> Approach d [m], >= 0.
         real(wp), intent(in) :: approach
         !> Rate of approach [m/s].
         real(wp), intent(in) :: rate
         !> Coefficient of the law, in its own unit.
         real(wp), intent(in) :: coefficient
         real(wp) :: f
      end function damping_kernel

      !> Derivatives of a damping force.
      pure function damping_slopes(elastic, approach, rate, coefficient) result(slopes)
         import :: wp
         implicit none(type, external)
         !> Elastic force [N], > 0.
         real(wp), intent(in) :: elastic
         !> Approach d [m], > 0.
         real(wp), intent(in) :: approach
         !> Rate of approach [m/s].
         real(wp), intent(in) :: rate
         !> Coefficient of the law, in its own unit.
         real(wp), intent(in) :: coefficient
         !> By the elastic force [-], the approach [N/m] and its rate [N s/m].
         real(wp) :: slopes(3)
      end function damping_slopes

      !> Damping force [N].
      pure function force_of(self, elastic, approach, rate) result(f)
         import :: damping_type, wp
         implicit none(type, external)
         class(damping_type), intent(in) :: self
         !> Elastic force [N].
         real(wp), intent(in) :: elastic
         !> Approach d [m], >= 0.
         real(wp), intent(in) :: approach
         !> Rate of approach [m/s].
         real(wp), intent(in) :: rate
         real(wp) :: f
      end function force_of

      !> Derivatives of a damping force by the elastic force [-], the approach [N/m] and its rate
      !> [N s/m].
      pure function slopes_of(self, elastic, approach, rate) result(slopes)
         import :: damping_type, wp
         implicit none(type, external)
         class(damping_type), intent(in) :: self
         !> Elastic force [N], > 0.
         real(wp), intent(in) :: elastic
         !> Approach d [m], > 0.
         real(wp), intent(in) :: approach
         !> Rate of approach [m/s].
         real(wp), intent(in) :: rate
         real(wp) :: slopes(3)
      end function slopes_of

      !> Make a damping law.
      subroutine new_damping(self, parameters, around, damping)
         import :: damping_model_type, damping_type, parameters_type, surroundings_type
         implicit none(type, external)
         class(damping_model_type), intent(in) :: self
         !> Values of its keys.
         type(parameters_type), intent(in) :: parameters
         !> What the contact is between.
         type(surroundings_type), intent(in) :: around
         class(damping_type), allocatable, intent(out) :: damping
      end subroutine new_damping

      !> Restitution of a rigid contact.
      pure subroutine rigid_restitution(parameters, restitution, alpha)
         import :: parameters_type, wp
         implicit none(type, external)
         !> Values of the keys of the law.
         type(parameters_type), intent(in) :: parameters
         !> Coefficient of restitution [-], unless it depends on the speed.
         real(wp), intent(out) :: restitution
         !> Hunt-Crossley coefficient by which it depends on the speed [s/m]; 0 if it does not.
         real(wp), intent(out) :: alpha
      end subroutine rigid_restitution
   end interface

contains

   !> Normal force with damping [N], >= 0.
   pure function total(self, elastic, approach, rate) result(f)
      class(damping_type), intent(in) :: self
      !> Elastic force [N].
      real(wp), intent(in) :: elastic
      !> Approach d [m], >= 0.
      real(wp), intent(in) :: approach
      !> Rate of approach [m/s].
      real(wp), intent(in) :: rate
      real(wp) :: f

      f = max(elastic + self%force(elastic, approach, rate), 0.0_wp)
   end function total

   !> Damping force at given states, and the rates of these: that of a law without states.
   pure subroutine evolve(self, elastic, approach, rate, states, f, rates)
      class(damping_type), intent(in) :: self
      !> Elastic force [N].
      real(wp), intent(in) :: elastic
      !> Approach d [m], >= 0.
      real(wp), intent(in) :: approach
      !> Rate of approach [m/s].
      real(wp), intent(in) :: rate
      real(wp), intent(in) :: states(:)
      !> Damping force [N].
      real(wp), intent(out) :: f
      !> Time derivatives of the states.
      real(wp), intent(out) :: rates(:)

      f = self%force(elastic, approach, rate)
      rates = 0.0_wp
   end subroutine evolve

   !> Damping force and rates of the states, and their derivatives by elastic force, approach, its
   !> rate and the states: by differences, unless a law knows better.
   pure subroutine vary(self, elastic, approach, rate, states, scales, f, rates, slopes)
      class(damping_type), intent(in) :: self
      !> Elastic force [N], > 0.
      real(wp), intent(in) :: elastic
      !> Approach d [m], > 0.
      real(wp), intent(in) :: approach
      !> Rate of approach [m/s].
      real(wp), intent(in) :: rate
      real(wp), intent(in) :: states(:)
      !> Values against which the states count as small.
      real(wp), intent(in) :: scales(:)
      !> Damping force [N].
      real(wp), intent(out) :: f
      !> Time derivatives of the states.
      real(wp), intent(out) :: rates(:)
      !> Derivatives of the force, then of the rates.
      real(wp), intent(out) :: slopes(:, :)
      real(wp) :: x(3 + most_states), h(3 + most_states), varied(1 + most_states, 2)
      integer :: i, k, n

      call self%evolve(elastic, approach, rate, states, f, rates)
      if (size(states) == 0) then
         slopes(1, :) = self%slopes(elastic, approach, rate)
         return
      end if
      n = size(states)
      h(:3) = step*[elastic, approach, max(abs(rate), slow)]
      h(4:3 + n) = step*max(abs(states), scales)
      do i = 1, 3 + n
         do k = 1, 2
            x(:3) = [elastic, approach, rate]
            x(4:3 + n) = states
            x(i) = x(i) + merge(h(i), -h(i), k == 1)
            call self%evolve(x(1), x(2), x(3), x(4:3 + n), varied(1, k), &
               varied(2:1 + n, k))
         end do
         slopes(:, i) = (varied(:1 + n, 1) - varied(:1 + n, 2))/(2.0_wp*h(i))
      end do
   end subroutine vary

   !> Energy that is stored in the states [J]: none. It counts as lost in damping when it is lost.
   pure real(wp) function stored_energy(self, elastic, approach, states)
      class(damping_type), intent(in) :: self
      !> Elastic force [N].
      real(wp), intent(in) :: elastic
      !> Approach d [m], >= 0.
      real(wp), intent(in) :: approach
      real(wp), intent(in) :: states(:)

      stored_energy = 0.0_wp
   end function stored_energy

   !> Take note of the speed of an impact; most laws do not depend on it.
   pure subroutine begin_impact(self, speed, changed)
      class(damping_type), intent(inout) :: self
      !> Speed of approach at touch [m/s].
      real(wp), intent(in) :: speed
      !> Whether the force has changed.
      logical, intent(out) :: changed

      changed = .false.
   end subroutine begin_impact

   !> Write what a law remembers of an impact to a checkpoint or read it back; most have nothing.
   subroutine exchange(self, checkpoint)
      class(damping_type), intent(inout) :: self
      type(checkpoint_type), intent(inout) :: checkpoint

   end subroutine exchange

end module contensou_contact_damping_law
