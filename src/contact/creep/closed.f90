!> Laws of creep in closed form: the linear wrench, reduced to what friction admits.
!>
!> In rolling axes, with tau the linear force over f N, the force of the creepages xi and eta falls
!> from tau f N to R(tau) f N, and the torque of spin alike:
!>    linear  R = tau, at any size;
!>    strip   R = (3/2) (s acos s + 2/3 - h + h^3/3), s = 4 tau/(3 pi) < 1, h = sqrt(1 - s^2):
!>            Carter's solution on each strip along the rolling direction;
!>    polach  R = (2/pi) (s/(1 + s^2) + atan s), s = pi tau/4: the brush with the pressure of Hertz.
!> With spin tau^2 is the sum of the squares of the force of xi and eta, of that of phi, and of the
!> torque of phi in f N sqrt(ab)/2. The lateral force of spin and the torque of creepage (C13, C23),
!> which together do no work, are multiplied by R'(tau): they vanish where all slips. So every law
!> dissipates, and has the linear wrench at small creep; with much spin none is accurate.
module contensou_contact_creep_closed
   use, intrinsic :: ieee_arithmetic, only : ieee_quiet_nan, ieee_value
   use contensou_base_kinds, only : pi, wp
   use contensou_contact_catalogue, only : model_info_type
   use contensou_contact_creep_law, only : creep_model_type, creep_motion_type, creep_spot_type, &
      creep_type, linear_theory
   use contensou_contact_parameters, only : parameters_type
   use contensou_special_angle, only : quadrant_angle
   implicit none(type, external)
   private

   public :: linear, strip, polach

   !> The reductions.
   integer, parameter :: nothing = 1, strips = 2, bristles = 3

   !> A law of this kind.
   type, extends(creep_type) :: closed_type
      !> One of the reductions. No pointer to a procedure: what is called cannot be inlined.
      integer :: reduction = nothing
   contains
      procedure :: kernel
   end type closed_type

contains

   !> Row of the linear theory.
   function linear() result(model)
      type(creep_model_type) :: model

      model%info = model_info_type("linear", "nothing slips: F = -G a b (C11 xi, C22 eta + " // &
         "C23 phi), at any size; NaN without rolling", "", "J. J. Kalker, thesis, Delft 1967")
      model%create => new_linear
   end function linear

   !> Row of the theory of strips.
   function strip() result(model)
      type(creep_model_type) :: model

      model%info = model_info_type("strip", "Carter's solution on each strip, in closed form, " // &
         "R = (3/2)(s acos s + 2/3 - h + h^3/3), s = 4 tau/(3 pi); for little spin", "", &
         "D. J. Haines, E. Ollerton, Proc. IMechE 177 (1963) 95")
      model%create => new_strip
   end function strip

   !> Row of Polach's law.
   function polach() result(model)
      type(creep_model_type) :: model

      model%info = model_info_type("polach", "brush with the pressure of Hertz, in closed form, " &
         // "R = (2/pi)(s/(1 + s^2) + atan s), s = pi tau/4; for little spin", "", &
         "O. Polach, Vehicle System Dynamics Suppl. 33 (1999) 728")
      model%create => new_polach
   end function polach

   !> Make the linear theory.
   subroutine new_linear(parameters, creep)
      type(parameters_type), intent(in) :: parameters
      class(creep_type), allocatable, intent(out) :: creep

      call new_closed(nothing, creep)
   end subroutine new_linear

   !> Make the theory of strips.
   subroutine new_strip(parameters, creep)
      type(parameters_type), intent(in) :: parameters
      class(creep_type), allocatable, intent(out) :: creep

      call new_closed(strips, creep)
   end subroutine new_strip

   !> Make Polach's law.
   subroutine new_polach(parameters, creep)
      type(parameters_type), intent(in) :: parameters
      class(creep_type), allocatable, intent(out) :: creep

      call new_closed(bristles, creep)
   end subroutine new_polach

   !> Make a law.
   subroutine new_closed(reduction, creep)
      !> One of the reductions.
      integer, intent(in) :: reduction
      class(creep_type), allocatable, intent(out) :: creep
      type(closed_type), allocatable :: made

      allocate(made)
      made%reduction = reduction
      call move_alloc(made, creep)
   end subroutine new_closed

   !> The reduced linear wrench.
   pure subroutine kernel(self, spot, motion, wrench)
      class(closed_type), intent(in) :: self
      type(creep_spot_type), intent(in) :: spot
      type(creep_motion_type), intent(in) :: motion
      !> Force along the major and the minor axis, torque about the normal.
      real(wp), intent(out) :: wrench(3)
      real(wp) :: inverse, ex, ey, x, y, spin, fx, fy, torque, gx, gy, twist, root_k
      real(wp) :: square, ratio, slope, c(6)

      inverse = motion%rx**2 + motion%ry**2
      if (.not. inverse > 0.0_wp) then
         if (abs(motion%x) + abs(motion%y) + abs(motion%spin) > 0.0_wp) then
            call at_rest(self, spot, motion, wrench)
         else
            wrench = 0.0_wp
         end if
         return
      end if
      inverse = sqrt(1.0_wp/inverse)
      ex = -inverse*motion%rx
      ey = -inverse*motion%ry
      call linear_theory(spot, motion%rx, motion%ry, c)
      root_k = spot%root_k
      ! Creepages in units of e0 and, for spin, of e0/sqrt(ab); G a b e0 = (3/(2 pi)) f N.
      inverse = (1.5_wp/pi)*inverse
      x = inverse*(motion%x*ex + motion%y*ey)
      y = inverse*(motion%y*ex - motion%x*ey)
      spin = inverse*motion%spin*root_k
      fx = -(c(1)*x + c(2)*y)
      fy = -(c(2)*x + c(3)*y)
      torque = -c(6)*spin
      gx = -c(4)*spin
      gy = -c(5)*spin
      twist = c(4)*x + c(5)*y
      square = (fx**2 + fy**2) + (4.0_wp*torque**2 + (gx**2 + gy**2))
      select case (self%reduction)
      case (strips)
         call reduce_strips(square, ratio, slope)
      case (bristles)
         call reduce_brush(sqrt(square), ratio, slope)
      case default
         ratio = 1.0_wp
         slope = 1.0_wp
      end select
      fx = ratio*fx + slope*gx
      fy = ratio*fy + slope*gy
      wrench = [fx*ex - fy*ey, fy*ex + fx*ey, root_k*(ratio*torque + slope*twist)]
   end subroutine kernel

   !> Wrench without rolling: all slips; against the linear force, whose direction has no limit, so
   !> against the velocities. The linear one has no value.
   pure subroutine at_rest(self, spot, motion, wrench)
      class(closed_type), intent(in) :: self
      type(creep_spot_type), intent(in) :: spot
      type(creep_motion_type), intent(in) :: motion
      !> Force along the major and the minor axis, torque about the normal.
      real(wp), intent(out) :: wrench(3)
      real(wp) :: w, root_k

      if (self%reduction == nothing) then
         wrench = ieee_value(wrench, ieee_quiet_nan)
         return
      end if
      root_k = spot%root_k
      w = motion%spin*root_k
      wrench = -[motion%x, motion%y, 0.5_wp*root_k*w]/sqrt(motion%x**2 + motion%y**2 + w**2)
   end subroutine at_rest

   !> Strips with Carter's solution.
   pure subroutine reduce_strips(square, ratio, slope)
      !> Square of the linear force over f N.
      real(wp), intent(in) :: square
      !> R(tau)/tau, R'(tau).
      real(wp), intent(out) :: ratio, slope
      real(wp) :: s2, s, h, angle

      s2 = square*(4.0_wp/(3.0_wp*pi))**2
      if (s2 >= 1.0_wp) then
         ratio = 1.0_wp/sqrt(square)
         slope = 0.0_wp
         return
      end if
      s = sqrt(s2)
      h = sqrt(1.0_wp - s2)
      ! acos s.
      angle = quadrant_angle(s, h, 1.0_wp - s2)
      slope = (2.0_wp/pi)*(angle - s*h)
      ! 2/3 - h + h^3/3 = (1 - h)^2 (2 + h)/3, which does not cancel as s^2 = (1 - h)(1 + h).
      ratio = (2.0_wp/pi)*(angle + s2*s*(2.0_wp + h)/(3.0_wp*(1.0_wp + h)**2))
   end subroutine reduce_strips

   !> Brush with the pressure of Hertz.
   pure subroutine reduce_brush(tau, ratio, slope)
      !> Linear force over f N, >= 0.
      real(wp), intent(in) :: tau
      !> R(tau)/tau, R'(tau).
      real(wp), intent(out) :: ratio, slope
      real(wp) :: s, square

      s = 0.25_wp*pi*tau
      if (s > 1.0e-4_wp) then
         if (s < 1.0e50_wp) then
            square = 1.0_wp + s*s
            ratio = (2.0_wp/pi)*(s/square + atan(s))/tau
            slope = 1.0_wp/square**2
         else
            ratio = 1.0_wp/tau
            slope = 0.0_wp
         end if
      else
         ratio = 1.0_wp - (2.0_wp/3.0_wp)*s*s
         slope = 1.0_wp - 2.0_wp*s*s
      end if
   end subroutine reduce_brush

end module contensou_contact_creep_closed
