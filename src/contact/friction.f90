!> Friction part of a contact: a rung of the ladder with its parameters.
module contensou_contact_friction
   use contensou_base_kinds, only : wp
   use contensou_contact_catalogue, only : model_info_type
   use contensou_contact_spot, only : spot_shape_type
   use contensou_contact_wrench, only : wrench_coulomb, wrench_coulomb_jacobian, &
      wrench_exact, wrench_exact_jacobian, wrench_jacobian_kernel, wrench_kernel, wrench_pade11, &
      wrench_pade11_jacobian, wrench_pade22, wrench_pade22_jacobian, wrench_simplified, &
      wrench_simplified_jacobian
   implicit none(type, external)
   private

   public :: friction_type, friction_model_type, friction_models

   !> A friction model with its parameters.
   type :: friction_type
      !> Friction coefficient f [-].
      real(wp) :: coefficient = 0.0_wp
      !> Regularisation velocity delta [m/s].
      real(wp) :: delta = 0.0_wp
      !> Whether the drilling torque is part of the model.
      logical :: drilling = .true.
      !> The rung.
      procedure(wrench_kernel), pointer, nopass :: kernel => null()
      !> The rung with its derivatives.
      procedure(wrench_jacobian_kernel), pointer, nopass :: jacobian => null()
   contains
      !> Wrench in SI units.
      procedure :: wrench
      !> Wrench and its derivatives in SI units.
      procedure :: linearize
      !> Regularisation velocity that acts.
      procedure, private :: effective_delta
   end type friction_type

   !> An entry of the table.
   type :: friction_model_type
      !> What a user reads.
      type(model_info_type) :: info
      !> The rung; not associated for `none`.
      procedure(wrench_kernel), pointer, nopass :: kernel => null()
      !> The rung with its derivatives; not associated for `none`.
      procedure(wrench_jacobian_kernel), pointer, nopass :: jacobian => null()
      !> Whether a regularisation velocity must be given.
      logical :: needs_delta = .false.
      !> Whether the model has a drilling torque.
      logical :: has_torque = .true.
   end type friction_model_type

contains

   !> Table of the friction models.
   function friction_models() result(models)
      type(friction_model_type), allocatable :: models(:)
      character(len=*), parameter :: keys = "friction_coefficient [-], drilling, " // &
         "regularization_velocity [m/s] (default 0: no regularisation)"

      allocate(models(6))
      models(1)%info = model_info_type("none", "no friction", "", "")
      models(1)%has_torque = .false.
      models(2)%info = model_info_type("coulomb", &
         "regularised Amontons-Coulomb: |F| = f N min(v/delta, 1), no torque", &
         "friction_coefficient [-], regularization_velocity [m/s] (mandatory)", &
         "C. A. Coulomb, Theorie des machines simples, 1785")
      models(2)%kernel => wrench_coulomb
      models(2)%jacobian => wrench_coulomb_jacobian
      models(2)%needs_delta = .true.
      models(2)%has_torque = .false.
      models(3)%info = model_info_type("contensou_simplified", &
         "piecewise linear: force linear in u = v/(a|w|) up to 1/k, torque k_T then T1/u", &
         keys, "Kosenko and Aleksandrov, 7th Modelica Conference (2009) 288")
      models(3)%kernel => wrench_simplified
      models(3)%jacobian => wrench_simplified_jacobian
      models(4)%info = model_info_type("pade11", &
         "Pade, one term at rest and at infinity: F = k u/(1 + k u), T = k_T T1/(T1 + k_T u)", &
         keys, "V. Ph. Zhuravlev, J. Appl. Math. Mech. 62 (1998) 705")
      models(4)%kernel => wrench_pade11
      models(4)%jacobian => wrench_pade11_jacobian
      models(5)%info = model_info_type("pade22", &
         "Pade, two terms at rest and at infinity", &
         keys, "V. Ph. Zhuravlev, J. Appl. Math. Mech. 67 (2003) 137")
      models(5)%kernel => wrench_pade22
      models(5)%jacobian => wrench_pade22_jacobian
      models(6)%info = model_info_type("contensou_exact", &
         "exact Contensou-Erismann wrench of the Hertz pressure", &
         keys, "P. Contensou, in: Kreiselprobleme, 1963; Th. Erismann, ZAMP 5 (1954) 355")
      models(6)%kernel => wrench_exact
      models(6)%jacobian => wrench_exact_jacobian
   end function friction_models

   !> Friction force and torque on the body that slips, in the axes of the spot.
   pure subroutine wrench(self, load, shape, a, vx, vy, w, resolution, fx, fy, torque)
      !> The part.
      class(friction_type), intent(in) :: self
      !> Normal force N [N], >= 0.
      real(wp), intent(in) :: load
      type(spot_shape_type), intent(in) :: shape
      !> Major semi-axis [m], >= 0.
      real(wp), intent(in) :: a
      !> Sliding velocity along the major axis [m/s].
      real(wp), intent(in) :: vx
      !> Sliding velocity along the minor axis [m/s].
      real(wp), intent(in) :: vy
      !> Spin about the normal [rad/s].
      real(wp), intent(in) :: w
      !> Square of the velocity below which sliding is not resolved [m2/s2], 0 if all is.
      real(wp), intent(in) :: resolution
      !> Force along the major axis [N].
      real(wp), intent(out) :: fx
      !> Force along the minor axis [N].
      real(wp), intent(out) :: fy
      !> Torque about the normal [N m].
      real(wp), intent(out) :: torque
      real(wp) :: limit

      call self%kernel(shape, vx, vy, a*w, self%effective_delta(vx, vy, a*w, resolution), &
         self%drilling, fx, fy, torque)
      limit = self%coefficient*load
      fx = limit*fx
      fy = limit*fy
      torque = limit*a*torque
   end subroutine wrench

   !> Regularisation velocity [m/s]: the part's own, or what an integrator resolves near rest.
   !>
   !> Where sliding and spinning stop together the wrench jumps, over a velocity that no tolerance
   !> can resolve. There delta grows to r, the velocity that is resolved: r (1 + V^2/r^2)^(-3/2) at
   !> the velocity V. Away from rest that changes the wrench by (r/V)^8, and nothing beyond 100 r.
   pure function effective_delta(self, vx, vy, spin, resolution) result(delta)
      !> The part.
      class(friction_type), intent(in) :: self
      !> Sliding velocity along the major axis [m/s].
      real(wp), intent(in) :: vx
      !> Sliding velocity along the minor axis [m/s].
      real(wp), intent(in) :: vy
      !> Spin velocity a w [m/s].
      real(wp), intent(in) :: spin
      !> r^2 [m2/s2], 0 for a perfect resolution.
      real(wp), intent(in) :: resolution
      real(wp) :: delta
      real(wp) :: square

      delta = self%delta
      if (resolution <= 0.0_wp) return
      square = vx*vx + vy*vy + spin*spin
      if (square >= 1.0e4_wp*resolution) return
      delta = max(delta, resolution**2/(resolution + square)/sqrt(resolution + square))
   end function effective_delta

   !> Friction wrench and its derivatives by normal force, size of the spot and velocities.
   pure subroutine linearize(self, load, shape, a, vx, vy, w, resolution, wrench, slopes)
      !> The part.
      class(friction_type), intent(in) :: self
      !> Normal force N [N], >= 0.
      real(wp), intent(in) :: load
      type(spot_shape_type), intent(in) :: shape
      !> Major semi-axis [m], >= 0.
      real(wp), intent(in) :: a
      !> Sliding velocity along the major axis [m/s].
      real(wp), intent(in) :: vx
      !> Sliding velocity along the minor axis [m/s].
      real(wp), intent(in) :: vy
      !> Spin about the normal [rad/s].
      real(wp), intent(in) :: w
      !> Square of the velocity below which sliding is not resolved [m2/s2], 0 if all is.
      real(wp), intent(in) :: resolution
      !> Force along the major and the minor axis [N], torque about the normal [N m].
      real(wp), intent(out) :: wrench(3)
      !> Derivative of component i by N, a, vx, vy, w.
      real(wp), intent(out) :: slopes(3, 5)
      real(wp) :: unit(3), motion(3), delta

      motion = [vx, vy, a*w]
      delta = self%effective_delta(vx, vy, a*w, resolution)
      call self%jacobian(shape, vx, vy, a*w, delta, wrench, slopes(:, 3:5))
      if (delta > self%delta) then
         ! The wrench is homogeneous of degree zero in the velocities and delta together.
         slopes(:, 1) = matmul(slopes(:, 3:5), motion) &
            *(3.0_wp/(resolution + dot_product(motion, motion)))
         slopes(:, 3) = slopes(:, 3) + slopes(:, 1)*motion(1)
         slopes(:, 4) = slopes(:, 4) + slopes(:, 1)*motion(2)
         slopes(:, 5) = slopes(:, 5) + slopes(:, 1)*motion(3)
      end if
      if (.not. self%drilling) then
         wrench(3) = 0.0_wp
         slopes(3, 3:5) = 0.0_wp
      end if
      unit = self%coefficient*[1.0_wp, 1.0_wp, a]
      slopes(:, 1) = unit*wrench
      unit = load*unit
      slopes(:, 2) = unit*slopes(:, 5)*w
      slopes(3, 2) = slopes(3, 2) + self%coefficient*load*wrench(3)
      slopes(:, 3) = unit*slopes(:, 3)
      slopes(:, 4) = unit*slopes(:, 4)
      slopes(:, 5) = unit*slopes(:, 5)*a
      wrench = unit*wrench
   end subroutine linearize

end module contensou_contact_friction
