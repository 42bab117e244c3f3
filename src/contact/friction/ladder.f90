!> The ladder of friction from Coulomb's law to the exact Contensou-Erismann wrench: kernels without
!> units of `contensou_contact_wrench`, with their parameters.
module contensou_contact_friction_ladder
   use contensou_base_kinds, only : wp
   use contensou_contact_catalogue, only : law_keys_type, model_info_type
   use contensou_contact_friction_law, only : friction_model_type, friction_type, &
      put_drilling, put_friction_coefficient, put_regularization_velocity, sliding_type
   use contensou_contact_parameters, only : parameters_type, surroundings_type
   use contensou_contact_spot, only : spot_shape_type
   use contensou_contact_wrench, only : slip_type, wrench_coulomb, wrench_coulomb_jacobian, &
      wrench_exact, wrench_exact_jacobian, wrench_jacobian_kernel, wrench_kernel, wrench_pade11, &
      wrench_pade11_jacobian, wrench_pade22, wrench_pade22_jacobian, wrench_simplified, &
      wrench_simplified_jacobian
   implicit none(type, external)
   private

   public :: rung_type, coulomb, contensou_simplified, pade11, pade22, contensou_exact
   public :: smoothing

   !> A rung with its parameters.
   type, extends(friction_type) :: rung_type
      procedure(wrench_kernel), pointer, nopass :: kernel => null()
      !> The rung with its derivatives.
      procedure(wrench_jacobian_kernel), pointer, nopass :: jacobian => null()
   contains
      procedure :: wrench => wrench_of
      procedure :: linearize
   end type rung_type

contains

   !> Row of the regularised Amontons-Coulomb law.
   function coulomb() result(model)
      type(friction_model_type) :: model

      model = rung("coulomb", &
         "regularised Amontons-Coulomb: |F| = f N min(v/delta, 1), no torque", &
         "C. A. Coulomb, Theorie des machines simples, 1785", &
         wrench_coulomb, wrench_coulomb_jacobian)
      model%put_keys => put_coulomb_keys
   end function coulomb

   !> Row of the simplified model.
   function contensou_simplified() result(model)
      type(friction_model_type) :: model

      model = rung("contensou_simplified", &
         "piecewise linear: force linear in u = v/(a|w|) up to 1/k, torque k_T then T1/u", &
         "Kosenko and Aleksandrov, 7th Modelica Conference (2009) 288", &
         wrench_simplified, wrench_simplified_jacobian)
   end function contensou_simplified

   !> Row of the Pade model with one term.
   function pade11() result(model)
      type(friction_model_type) :: model

      model = rung("pade11", &
         "Pade, one term at rest and at infinity: F = k u/(1 + k u), T = k_T T1/(T1 + k_T u)", &
         "V. Ph. Zhuravlev, J. Appl. Math. Mech. 62 (1998) 705", &
         wrench_pade11, wrench_pade11_jacobian)
   end function pade11

   !> Row of the Pade model with two terms.
   function pade22() result(model)
      type(friction_model_type) :: model

      model = rung("pade22", "Pade, two terms at rest and at infinity", &
         "V. Ph. Zhuravlev, J. Appl. Math. Mech. 67 (2003) 137", &
         wrench_pade22, wrench_pade22_jacobian)
   end function pade22

   !> Row of the exact wrench.
   function contensou_exact() result(model)
      type(friction_model_type) :: model

      model = rung("contensou_exact", "exact Contensou-Erismann wrench of the Hertz pressure", &
         "P. Contensou, in: Kreiselprobleme, 1963; Th. Erismann, ZAMP 5 (1954) 355", &
         wrench_exact, wrench_exact_jacobian)
   end function contensou_exact

   !> A row.
   function rung(name, summary, reference, kernel, jacobian) result(model)
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: summary
      character(len=*), intent(in) :: reference
      procedure(wrench_kernel) :: kernel
      procedure(wrench_jacobian_kernel) :: jacobian
      type(friction_model_type) :: model

      model%info = model_info_type(name, summary, "", reference)
      model%put_keys => put_rung_keys
      model%create => new_rung
      model%kernel => kernel
      model%jacobian => jacobian
   end function rung

   subroutine put_rung_keys(list)
      type(law_keys_type), intent(inout) :: list

      call put_friction_coefficient(list)
      call put_regularization_velocity(list)
      call put_drilling(list)
   end subroutine put_rung_keys

   !> The keys of Coulomb's law.
   subroutine put_coulomb_keys(list)
      type(law_keys_type), intent(inout) :: list

      call put_friction_coefficient(list)
      call put_regularization_velocity(list, mandatory=.true.)
      call put_drilling(list, idle=.true.)
   end subroutine put_coulomb_keys

   !> A rung with the values of its keys.
   subroutine new_rung(self, parameters, around, friction)
      class(friction_model_type), intent(in) :: self
      type(parameters_type), intent(in) :: parameters
      type(surroundings_type), intent(in) :: around
      class(friction_type), allocatable, intent(out) :: friction
      type(rung_type), allocatable :: law

      allocate(law)
      law%kernel => self%kernel
      law%jacobian => self%jacobian
      law%coefficient = parameters%number("friction_coefficient")
      law%delta = parameters%number("regularization_velocity")
      law%drilling = parameters%flag("drilling") .and. self%uses("drilling")
      call move_alloc(law, friction)
   end subroutine new_rung

   !> Friction force and torque on the body that slips, in the axes of the spot.
   pure subroutine wrench_of(self, shape, at, wrench)
      class(rung_type), intent(in) :: self
      type(spot_shape_type), intent(in) :: shape
      type(sliding_type), intent(in) :: at
      real(wp), intent(out) :: wrench(3)
      real(wp) :: limit

      call self%kernel(shape, slip_of(self, at), self%drilling, wrench)
      limit = self%coefficient*at%load
      wrench(1) = limit*wrench(1)
      wrench(2) = limit*wrench(2)
      wrench(3) = limit*at%a*wrench(3)
   end subroutine wrench_of

   !> Velocities of the spot, with the part's own regularisation velocity or what an integrator
   !> resolves near rest.
   pure function slip_of(self, at) result(slip)
      class(rung_type), intent(in) :: self
      type(sliding_type), intent(in) :: at
      type(slip_type) :: slip

      slip%x = at%vx
      slip%y = at%vy
      slip%spin = at%a*at%w
      slip%delta = self%delta
      if (at%resolution <= 0.0_wp) return
      slip%delta = smoothing(self%delta, at%resolution, &
         slip%x*slip%x + slip%y*slip%y + slip%spin*slip%spin)
   end function slip_of

   !> Regularisation velocity with what an integrator resolves near rest.
   !>
   !> Where sliding and spinning stop together the wrench jumps, over a velocity that no tolerance
   !> can resolve. There delta grows to r, the velocity that is resolved: r (1 + V^2/r^2)^(-3/2) at
   !> the velocity V. Away from rest that changes the wrench by (r/V)^8, and nothing beyond 100 r.
   pure real(wp) function smoothing(delta, resolution, square)
      !> The law's own regularisation velocity [m/s].
      real(wp), intent(in) :: delta
      !> r^2 [m2/s2], > 0.
      real(wp), intent(in) :: resolution
      !> V^2 [m2/s2].
      real(wp), intent(in) :: square

      smoothing = delta
      if (square >= 1.0e4_wp*resolution) return
      smoothing = max(delta, resolution**2/(resolution + square)/sqrt(resolution + square))
   end function smoothing

   !> Friction wrench and its derivatives by normal force, size of the spot and velocities.
   pure subroutine linearize(self, shape, at, wrench, slopes)
      class(rung_type), intent(in) :: self
      type(spot_shape_type), intent(in) :: shape
      type(sliding_type), intent(in) :: at
      real(wp), intent(out) :: wrench(3), slopes(3, 5)
      type(slip_type) :: slip
      real(wp) :: unit(3), velocity(3)

      slip = slip_of(self, at)
      call self%jacobian(shape, slip, wrench, slopes(:, 3:5))
      if (slip%delta > self%delta) then
         ! The wrench is homogeneous of degree zero in the velocities and delta together.
         velocity = [slip%x, slip%y, slip%spin]
         slopes(:, 1) = matmul(slopes(:, 3:5), velocity) &
            *(3.0_wp/(at%resolution + dot_product(velocity, velocity)))
         slopes(:, 3) = slopes(:, 3) + slopes(:, 1)*velocity(1)
         slopes(:, 4) = slopes(:, 4) + slopes(:, 1)*velocity(2)
         slopes(:, 5) = slopes(:, 5) + slopes(:, 1)*velocity(3)
      end if
      if (.not. self%drilling) then
         wrench(3) = 0.0_wp
         slopes(3, 3:5) = 0.0_wp
      end if
      unit = self%coefficient*[1.0_wp, 1.0_wp, at%a]
      slopes(:, 1) = unit*wrench
      unit = at%load*unit
      slopes(:, 2) = unit*slopes(:, 5)*at%w
      slopes(3, 2) = slopes(3, 2) + self%coefficient*at%load*wrench(3)
      slopes(:, 3) = unit*slopes(:, 3)
      slopes(:, 4) = unit*slopes(:, 4)
      slopes(:, 5) = unit*slopes(:, 5)*at%a
      wrench = unit*wrench
   end subroutine linearize

end module contensou_contact_friction_ladder
