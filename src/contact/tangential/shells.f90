!> Tangential elasticity of a Hertz spot with local slip and memory: nested shells, each with an
!> elastic displacement of its own and a limit that is convex in force and torque together.
!>
!> A shell between the places x1 < x2, in units of the major semi-axis a, has the share x2 - x1 of
!> the stiffness against shift and S(x2) - S(x1) of that against twist. It slips as the difference
!> of two Hertz spots does: with Phi(v, w) the friction potential of the spot for the friction
!> model of the contact, l(x) = (3/2)(x - x^3/3) the load within x and c(x) = l^(2/3),
!>    phi(v, w) = l2 Phi(v, c2 w) - l1 Phi(v, c1 w),
!> which is convex, as l Phi(v, c(l) w) has a second derivative that grows with l. The potentials of
!> all shells sum to Phi, so full sliding gives the wrench of the friction model for any number of
!> shells. Without twist the shells are the springs of the method of dimensionality reduction
!> (Jaeger 1995, Popov and Hess 2015): many shells follow Cattaneo, Mindlin and Deresiewicz for any
!> history. S(x) makes a pure twist that of Lubkin (1951) on the circle.
!>
!> A step is an elastic trial e, after which each shell slips by the p that solves
!>    K (e - p) in d phi(p):
!> the minimum of the convex phi(p) + (e - p).K(e - p)/2. Formulas, errors: docs/tangential.md.
module contensou_contact_tangential_shells
   use contensou_base_kinds, only : wp
   use contensou_contact_spot, only : spot_shape_type
   use contensou_contact_tangential_nest, only : make_room, nest_type
   use contensou_contact_tangential_slip, only : slip_of_shell, sliding_force, stiffness_after
   use contensou_contact_tangential_spot, only : spring_spot_type
   implicit none(type, external)
   private

   public :: shells_type, single_spring, spring_spot_type, default_layers, most_layers, &
      shells_per_layer, make_room

   !> Layers if nothing else is said, and the most.
   integer, parameter :: default_layers = 10, most_layers = 128

   !> Shells in a layer, which slip one after the other.
   integer, parameter :: shells_per_layer = 3

   !> Slip over the elastic displacement below which the stiffness after it is that of this one.
   real(wp), parameter :: shortest_slip = 1.0e-8_wp

   !> The shells of a contact, from the centre to the rim, with what they remember.
   type, extends(nest_type) :: shells_type
   contains
      procedure :: begin
      procedure :: advance
      procedure :: slide
   end type shells_type

contains

   !> Begin without a contact.
   pure subroutine begin(self, layers)
      class(shells_type), intent(inout) :: self
      !> Number of layers, 1 to 128; 10 if not given.
      integer, intent(in), optional :: layers
      integer :: number

      number = default_layers
      if (present(layers)) number = layers
      call self%clear()
      call make_room(self, shells_per_layer*number)
   end subroutine begin

   !> One spring with the stiffness of the whole spot, as granular codes have it.
   pure function single_spring() result(shells)
      type(shells_type) :: shells

      call make_room(shells, 1)
   end function single_spring

   !> Move the bodies by a step at the load of the spot.
   pure subroutine advance(self, spot, step, wrench, stored, lost, settled, slopes)
      class(shells_type), intent(inout) :: self
      type(spring_spot_type), intent(in) :: spot
      !> Shift of body 1 against body 2 along the axes [m] and twist [rad].
      real(wp), intent(in) :: step(3)
      !> Force along the axes [N] and torque [N m] on body 1.
      real(wp), intent(out) :: wrench(3)
      !> Elastic energy after the step [J].
      real(wp), intent(out) :: stored
      !> Work of the slip in the step and what a smaller spot has let go [J], >= 0.
      real(wp), intent(out) :: lost
      !> Whether shells are merged and divided so that their number stays, unless that is left to
      !> `settle`: without it the wrench is a continuous function of spot and step.
      logical, intent(in), optional :: settled
      !> Derivatives of the wrench by the step, and by the limit at constant size.
      real(wp), intent(out), optional :: slopes(3, 4)
      real(wp) :: stiffness(3), trial(3), force(3), bearing(3), work, units(3), part, &
         per_unit(3), lengths(3), springs(3)
      logical :: slips
      integer :: j, new

      wrench = 0.0_wp
      if (present(slopes)) slopes = 0.0_wp
      call self%resize(spot, lost, settled, new)
      stored = 0.0_wp
      if (self%n == 0) return
      if (.not. spot%limit > 0.0_wp) then
         lost = lost + self%energy()
         self%shift(:, :self%n) = 0.0_wp
         self%slipped(:self%n) = .false.
         return
      end if
      ! Units of f N and of lengths.
      units = spot%limit*[1.0_wp, 1.0_wp, spot%a]
      per_unit = 1.0_wp/units
      lengths = units/spot%limit
      springs = spot%limit*per_unit**2
      do j = self%n, 1, -1
         stiffness = self%share(:, j)
         ! Area that is new has come one by one.
         part = 1.0_wp
         if (j > self%n - new) part = (real(self%n - j, wp) + 0.5_wp)/real(new, wp)
         trial = self%shift(:, j) + part*step
         force = stiffness*trial
         bearing = force*per_unit
         if (j < self%n .and. all(abs(self%direction(:, j)) <= 0.0_wp)) self%direction(:, j) = &
            self%direction(:, j + 1)
         call slip_of_shell(spot%shape, self%within(j - 1), self%within(j), spot%rung, &
            stiffness*springs, trial*lengths, bearing, self%direction(:, j), slips, work)
         self%slipped(j) = slips
         if (present(slopes)) call add_slopes(self, j, spot, stiffness, units, trial, bearing, &
            part, slopes)
         if (slips) then
            force = bearing*units
            trial = force/max(stiffness, tiny(stiffness))
            lost = lost + spot%limit*work
         end if
         self%shift(:, j) = trial
         wrench = wrench - force
         stored = stored + 0.5_wp*dot_product(force, trial)
      end do
   end subroutine advance

   !> Add what a shell contributes to the derivatives of the wrench.
   pure subroutine add_slopes(self, j, spot, stiffness, units, trial, bearing, part, slopes)
      class(shells_type), intent(in) :: self
      !> The shell.
      integer, intent(in) :: j
      type(spring_spot_type), intent(in) :: spot
      !> Its stiffness, and units of force and torque.
      real(wp), intent(in) :: stiffness(3), units(3)
      !> Elastic displacement of the trial.
      real(wp), intent(in) :: trial(3)
      !> Force of the shell in its units.
      real(wp), intent(in) :: bearing(3)
      !> Part of the step that the trial has.
      real(wp), intent(in) :: part
      real(wp), intent(inout) :: slopes(3, 4)
      real(wp) :: k(3), slip(3), length, by_trial(3, 3), by_limit(3)
      integer :: i

      if (.not. self%slipped(j)) then
         do i = 1, 3
            slopes(i, i) = slopes(i, i) - part*stiffness(i)
         end do
         return
      end if
      k = stiffness*(spot%limit/units**2)
      if (.not. minval(k) > 0.0_wp) return
      ! So narrow that it bears nothing, where nothing has moved.
      if (.not. any(abs(self%direction(:, j)) > 0.0_wp)) return
      slip = trial*(units/spot%limit) - bearing/k
      length = max(norm2(slip), shortest_slip*norm2(bearing/k))
      call stiffness_after(spot%shape, self%within(j - 1), self%within(j), spot%rung, k, &
         self%direction(:, j), length, by_trial, by_limit)
      do i = 1, 3
         slopes(:, i) = slopes(:, i) - part*by_trial(:, i)*units*units(i)/spot%limit
      end do
      slopes(:, 4) = slopes(:, 4) - by_limit*units/spot%limit
   end subroutine add_slopes

   !> Bear what sliding gives.
   pure subroutine slide(self, spot, velocity, share)
      class(shells_type), intent(inout) :: self
      type(spring_spot_type), intent(in) :: spot
      !> Sliding velocity along the axes [m/s] and spin [rad/s].
      real(wp), intent(in) :: velocity(3)
      !> Share of that, the rest is as it was.
      real(wp), intent(in) :: share
      real(wp) :: u(3), force(3), stiffness(3), hessian(3, 3), size
      integer :: j

      u = velocity*[1.0_wp, 1.0_wp, spot%a]
      size = sqrt(dot_product(u, u))
      if (.not. size > 0.0_wp) return
      u = u/size
      do j = 1, self%n
         stiffness = self%share(:, j)
         call sliding_force(spot%shape, self%within(j - 1), self%within(j), spot%rung, u, force, &
            hessian)
         force = force*spot%limit*[1.0_wp, 1.0_wp, spot%a]
         self%shift(:, j) = (1.0_wp - share)*self%shift(:, j) + share*force/max(stiffness, &
            tiny(stiffness))
         self%direction(:, j) = u
         self%slipped(j) = .true.
      end do
   end subroutine slide

end module contensou_contact_tangential_shells
