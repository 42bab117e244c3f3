!> Friction part of a contact: what each law of friction must answer, and the keys that most share.
!>
!> A law without states has its wrench and, unless differences will do, the derivatives of it. A law
!> with states has beside that `evolve`, the wrench that acts and the rates of the states; `wrench`
!> is then that of steady sliding, by which impacts of rigid contacts go, which leave a state no
!> time.
module contensou_contact_friction_law
   use contensou_base_kinds, only : wp
   use contensou_base_schema, only : kind_logical, kind_real
   use contensou_contact_catalogue, only : law_keys_type, model_type
   use contensou_contact_parameters, only : parameters_type, surroundings_type
   use contensou_contact_spot, only : circular_shape, spot_shape_type
   use contensou_contact_states, only : most_states, owner_type
   use contensou_contact_wrench, only : wrench_jacobian_kernel, wrench_kernel
   implicit none(type, external)
   private

   public :: friction_type, friction_model_type, sliding_type, changed
   public :: put_friction_coefficient, put_regularization_velocity, put_drilling

   !> Relative step of differences.
   real(wp), parameter :: step = 6.0e-6_wp

   !> Velocity that is small wherever nothing else says so [m/s].
   real(wp), parameter :: creep = 1.0e-6_wp

   !> What friction acts on beside the shape of the spot: its load and size, and how it slides.
   type :: sliding_type
      !> Normal force N [N], >= 0.
      real(wp) :: load = 0.0_wp
      !> Major semi-axis [m], >= 0.
      real(wp) :: a = 0.0_wp
      !> Sliding velocity along the major and the minor axis [m/s].
      real(wp) :: vx = 0.0_wp, vy = 0.0_wp
      !> Spin about the normal [rad/s].
      real(wp) :: w = 0.0_wp
      !> Square of the velocity below which sliding is not resolved [m2/s2], 0 if all is.
      real(wp) :: resolution = 0.0_wp
   end type sliding_type

   !> A law of friction with its parameters.
   type, abstract, extends(owner_type) :: friction_type
      !> Friction coefficient f [-]; with `delta`, how steep friction is near rest is judged by.
      real(wp) :: coefficient = 0.0_wp
      !> Regularisation velocity delta [m/s].
      real(wp) :: delta = 0.0_wp
      !> Whether the drilling torque is part of the law.
      logical :: drilling = .true.
   contains
      !> Wrench in SI units.
      procedure(wrench_of), deferred :: wrench
      procedure :: linearize => differ_wrench
      procedure :: evolve
      procedure :: vary
      procedure :: stored_energy
   end type friction_type

   !> A row in the table of the laws of friction.
   type, extends(model_type) :: friction_model_type
      !> Makes the law from the values of its keys; not associated for `none`.
      procedure(new_friction), pointer :: create => null()
      !> A rung of the ladder, without units; not associated for a law that is none.
      procedure(wrench_kernel), pointer, nopass :: kernel => null()
      !> The rung with its derivatives.
      procedure(wrench_jacobian_kernel), pointer, nopass :: jacobian => null()
   end type friction_model_type

   abstract interface
      !> Friction force and torque on the body that slips, in the axes of the spot.
      pure subroutine wrench_of(self, shape, at, wrench)
         import :: friction_type, sliding_type, spot_shape_type, wp
         implicit none(type, external)
         class(friction_type), intent(in) :: self
         type(spot_shape_type), intent(in) :: shape
         type(sliding_type), intent(in) :: at
         !> Force along the major and the minor axis [N], torque about the normal [N m].
         real(wp), intent(out) :: wrench(3)
      end subroutine wrench_of

      !> Make a law of friction.
      subroutine new_friction(self, parameters, around, friction)
         import :: friction_model_type, friction_type, parameters_type, surroundings_type
         implicit none(type, external)
         class(friction_model_type), intent(in) :: self
         !> Values of its keys.
         type(parameters_type), intent(in) :: parameters
         !> What the contact is between.
         type(surroundings_type), intent(in) :: around
         class(friction_type), allocatable, intent(out) :: friction
      end subroutine new_friction
   end interface

contains

   !> Friction wrench and its derivatives by normal force, size of the spot and velocities: by
   !> differences, unless a law knows better.
   pure subroutine differ_wrench(self, shape, at, wrench, slopes)
      class(friction_type), intent(in) :: self
      type(spot_shape_type), intent(in) :: shape
      type(sliding_type), intent(in) :: at
      !> Force along the major and the minor axis [N], torque about the normal [N m].
      real(wp), intent(out) :: wrench(3)
      !> Derivative of component i by N, a, vx, vy, w.
      real(wp), intent(out) :: slopes(3, 5)
      type(sliding_type) :: there
      real(wp) :: varied(3, 2), h(2)
      integer :: i, k

      call self%wrench(shape, at, wrench)
      do i = 1, 5
         do k = 1, 2
            call shift(at, i, self%delta, k == 1, there, h(k))
            call self%wrench(shape, there, varied(:, k))
         end do
         slopes(:, i) = (varied(:, 1) - varied(:, 2))/(h(1) - h(2))
      end do
   end subroutine differ_wrench

   !> Vary what friction acts on by a small step.
   pure subroutine shift(at, which, delta, up, there, h)
      type(sliding_type), intent(in) :: at
      !> 1 load, 2 major semi-axis, 3 and 4 sliding velocity, 5 spin.
      integer, intent(in) :: which
      !> Velocity over which friction changes near rest [m/s], 0 for none.
      real(wp), intent(in) :: delta
      logical, intent(in) :: up
      type(sliding_type), intent(out) :: there
      !> The step; none where the load or the size of the spot would become negative.
      real(wp), intent(out) :: h
      real(wp) :: speed

      speed = sqrt(at%vx**2 + at%vy**2 + (at%a*at%w)**2 + at%resolution)
      speed = max(speed, delta, creep)
      select case (which)
      case (1)
         h = step*merge(at%load, 1.0_wp, at%load > 0.0_wp)
         if (.not. up) h = merge(-h, 0.0_wp, at%load > 0.0_wp)
      case (2)
         h = step*merge(at%a, 1.0e-6_wp, at%a > 0.0_wp)
         if (.not. up) h = merge(-h, 0.0_wp, at%a > 0.0_wp)
      case (3:4)
         h = merge(step, -step, up)*speed
      case default
         h = merge(step, -step, up)*merge(speed/max(at%a, tiny(speed)), 1.0_wp, at%a > 0.0_wp)
      end select
      there = changed(at, which, h)
   end subroutine shift

   !> What friction acts on, one of it changed.
   pure function changed(at, which, h) result(there)
      type(sliding_type), intent(in) :: at
      !> 1 load, 2 major semi-axis, 3 and 4 sliding velocity, 5 spin.
      integer, intent(in) :: which
      !> By how much.
      real(wp), intent(in) :: h
      type(sliding_type) :: there

      there = at
      select case (which)
      case (1)
         there%load = at%load + h
      case (2)
         there%a = at%a + h
      case (3)
         there%vx = at%vx + h
      case (4)
         there%vy = at%vy + h
      case default
         there%w = at%w + h
      end select
   end function changed

   !> Wrench at given states, and the rates of these: that of a law without states.
   pure subroutine evolve(self, shape, at, states, wrench, rates)
      class(friction_type), intent(in) :: self
      type(spot_shape_type), intent(in) :: shape
      type(sliding_type), intent(in) :: at
      real(wp), intent(in) :: states(:)
      !> Force along the major and the minor axis [N], torque about the normal [N m].
      real(wp), intent(out) :: wrench(3)
      !> Time derivatives of the states.
      real(wp), intent(out) :: rates(:)

      call self%wrench(shape, at, wrench)
      rates = 0.0_wp
   end subroutine evolve

   !> Wrench and rates of the states, and their derivatives by normal force, size of the spot,
   !> velocities and states: by differences, unless a law knows better.
   pure subroutine vary(self, shape, at, states, scales, wrench, rates, slopes)
      class(friction_type), intent(in) :: self
      type(spot_shape_type), intent(in) :: shape
      type(sliding_type), intent(in) :: at
      real(wp), intent(in) :: states(:)
      !> Values against which the states count as small.
      real(wp), intent(in) :: scales(:)
      !> Force along the major and the minor axis [N], torque about the normal [N m].
      real(wp), intent(out) :: wrench(3)
      !> Time derivatives of the states.
      real(wp), intent(out) :: rates(:)
      !> Derivatives of the wrench, then of the rates, by N, a, vx, vy, w, then by the states.
      real(wp), intent(out) :: slopes(:, :)
      type(sliding_type) :: there
      real(wp) :: varied(3 + most_states, 2), moved(most_states), h(2)
      integer :: i, k, n

      if (size(states) == 0) then
         call self%linearize(shape, at, wrench, slopes)
         return
      end if
      n = size(states)
      call self%evolve(shape, at, states, wrench, rates)
      do i = 1, 5
         do k = 1, 2
            call shift(at, i, self%delta, k == 1, there, h(k))
            call self%evolve(shape, there, states, varied(:3, k), varied(4:3 + n, k))
         end do
         slopes(:, i) = (varied(:3 + n, 1) - varied(:3 + n, 2))/(h(1) - h(2))
      end do
      do i = 1, n
         do k = 1, 2
            moved(:n) = states
            h(k) = merge(step, -step, k == 1)*max(abs(states(i)), scales(i))
            moved(i) = states(i) + h(k)
            call self%evolve(shape, at, moved(:n), varied(:3, k), varied(4:3 + n, k))
         end do
         slopes(:, 5 + i) = (varied(:3 + n, 1) - varied(:3 + n, 2))/(h(1) - h(2))
      end do
   end subroutine vary

   !> Energy that is stored in the states [J]: none. It counts as lost in friction when it is lost.
   pure real(wp) function stored_energy(self, shape, at, states)
      class(friction_type), intent(in) :: self
      type(spot_shape_type), intent(in) :: shape
      type(sliding_type), intent(in) :: at
      real(wp), intent(in) :: states(:)

      stored_energy = 0.0_wp
   end function stored_energy

   !> The key friction_coefficient.
   subroutine put_friction_coefficient(list)
      type(law_keys_type), intent(inout) :: list

      call list%put("friction_coefficient", kind_real, "friction coefficient f", unit="1", &
         least=0.0_wp, mandatory=.true.)
   end subroutine put_friction_coefficient

   !> The key regularization_velocity.
   subroutine put_regularization_velocity(list, mandatory)
      type(law_keys_type), intent(inout) :: list
      !> Whether it must be given, and positive.
      logical, intent(in), optional :: mandatory
      character(len=*), parameter :: name = "regularization_velocity", unit = "m s-1"
      character(len=*), parameter :: doc = "velocity delta below which friction falls to zero " // &
         "with the slip velocity; with 0 the wrench of v = w = 0 is zero, and a run smooths " // &
         "its jump there over a velocity that its tolerance does not resolve"

      if (present(mandatory)) then
         if (mandatory) then
            call list%put(name, kind_real, doc, unit=unit, above=0.0_wp, mandatory=.true., &
               example="1.0e-3")
            return
         end if
      end if
      call list%put(name, kind_real, doc, unit=unit, least=0.0_wp, default="0.0")
   end subroutine put_regularization_velocity

   !> The key drilling.
   subroutine put_drilling(list, idle)
      type(law_keys_type), intent(inout) :: list
      !> Whether the law has no such torque, and admits the key all the same.
      logical, intent(in), optional :: idle

      call list%put("drilling", kind_logical, "whether the drilling torque about the normal acts", &
         default=".true.", idle=idle)
   end subroutine put_drilling

end module contensou_contact_friction_law
