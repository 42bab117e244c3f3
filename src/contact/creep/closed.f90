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
   use contensou_base_kinds, only : i8, pi, wp
   use contensou_contact_catalogue, only : model_info_type
   use contensou_contact_creep_law, only : creep_model_type, creep_motion_type, creep_spot_type, &
      creep_type, linear_theory, n_velocities
   use contensou_contact_creep_strip_values, only : parts, reductions, split
   use contensou_contact_kalker, only : kalker_six
   use contensou_contact_parameters, only : parameters_type
   implicit none(type, external)
   private

   public :: linear, strip, polach

   !> The reductions.
   integer, parameter :: nothing = 1, strips = 2, bristles = 3

   !> What is added to a number below one to round it to a part: the last bits of the sum have the
   !> number of it. A conversion takes longer.
   real(wp), parameter :: to_parts = 1.5_wp*2.0_wp**(digits(1.0_wp) - 1)/real(parts, wp)

   !> Angle by which the direction of rolling is varied.
   real(wp), parameter :: turn = 6.0e-6_wp

   !> A law of this kind.
   type, extends(creep_type) :: closed_type
      !> One of the reductions. No pointer to a procedure: what is called cannot be inlined.
      integer :: reduction = nothing
      !> Force of a creepage of e0 in units of C f N, or of what the reduction takes: against it.
      real(wp) :: factor = -1.5_wp/pi
   contains
      procedure :: kernel
   end type closed_type

   !> The linear theory.
   type, extends(closed_type) :: linear_type
   contains
      procedure :: kernel_slopes => linear_slopes
   end type linear_type

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
      type(linear_type), allocatable :: made

      allocate(made)
      made%limited = .false.
      call move_alloc(made, creep)
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
      made%uncouples = .true.
      if (reduction == strips) made%factor = (4.0_wp/(3.0_wp*pi))*made%factor
      call move_alloc(made, creep)
   end subroutine new_closed

   !> The reduced linear wrench.
   pure subroutine kernel(self, spot, motion, wrench)
      class(closed_type), intent(in) :: self
      type(creep_spot_type), intent(in) :: spot
      type(creep_motion_type), intent(in) :: motion
      !> Force along the major and the minor axis, torque about the normal.
      real(wp), intent(out) :: wrench(3)
      real(wp) :: rx, ry, inverse, ex, ey, x, y, spin, mirror, mx, my, mspin, root_k
      real(wp) :: c11, c12, c22, c13, c23, c33, c(6)
      real(wp) :: fx, fy, torque, gx, gy, twist, square, ratio, slope

      rx = motion%rx
      ry = motion%ry
      inverse = rx**2 + ry**2
      if (.not. inverse > 0.0_wp) then
         if (abs(motion%x) + abs(motion%y) + abs(motion%spin) > 0.0_wp) then
            call at_rest(self, spot, motion, wrench)
         else
            wrench = 0.0_wp
         end if
         return
      end if
      ! The coefficients first: the rest takes less, and would keep their quotient waiting.
      root_k = spot%root_k
      if (allocated(spot%by_direction)) then
         call kalker_six(spot%by_direction, spot%poisson, root_k, abs(rx), abs(ry), &
            c11, c12, c22, c13, c23, c33)
      else
         call linear_theory(spot, abs(rx), abs(ry), c)
         c11 = c(1)
         c12 = c(2)
         c22 = c(3)
         c13 = c(4)
         c23 = c(5)
         c33 = c(6)
      end if
      ! Creepages in units of e0 and, for spin, of e0/sqrt(ab); G a b e0 = (3/(2 pi)) f N.
      ! Along what passes, against rolling: force and torque of spin have another sign than those
      ! of creepage. So have C12 and C13 between the other axes.
      inverse = 1.0_wp/inverse
      x = (self%factor*inverse)*(motion%x*rx + motion%y*ry)
      y = (self%factor*inverse)*(motion%y*rx - motion%x*ry)
      inverse = sqrt(inverse)
      ex = inverse*rx
      ey = inverse*ry
      spin = (self%factor*inverse)*(motion%spin*root_k)
      mirror = sign(1.0_wp, rx*ry)
      mx = mirror*x
      my = mirror*y
      mspin = mirror*spin
      fx = c11*x + c12*my
      fy = c12*mx + c22*y
      twist = c13*mx + c23*y
      gx = c13*mspin
      gy = c23*spin
      torque = c33*spin
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
      fx = ratio*fx - slope*gx
      fy = ratio*fy - slope*gy
      wrench(1) = fx*ex - fy*ey
      wrench(2) = fy*ex + fx*ey
      wrench(3) = root_k*(ratio*torque + slope*twist)
   end subroutine kernel

   !> The linear wrench and its derivatives.
   !>
   !> The wrench is linear in the sliding and falls as 1/r with the rolling, whatever the creepage.
   !> Differences by r, as wide as the sliding where creepages are large, would pass beyond r = 0;
   !> only the direction of rolling is varied.
   pure subroutine linear_slopes(self, spot, motion, wrench, jacobian)
      class(linear_type), intent(in) :: self
      type(creep_spot_type), intent(in) :: spot
      type(creep_motion_type), intent(in) :: motion
      !> Force along the major and the minor axis, torque about the normal.
      real(wp), intent(out) :: wrench(3)
      !> Derivative of component i by x, y, spin, rx, ry.
      real(wp), intent(out) :: jacobian(3, n_velocities)
      type(creep_motion_type) :: there
      real(wp) :: e(2), varied(3, 2), aside(3), inverse, angle
      integer :: k

      call self%kernel(spot, motion, wrench)
      inverse = hypot(motion%rx, motion%ry)
      if (.not. inverse > 0.0_wp) then
         ! No value, nor derivatives.
         jacobian = spread(wrench, 2, n_velocities)
         return
      end if
      inverse = 1.0_wp/inverse
      do k = 1, 3
         there = creep_motion_type(0.0_wp, 0.0_wp, 0.0_wp, motion%rx, motion%ry)
         if (k == 1) there%x = 1.0_wp
         if (k == 2) there%y = 1.0_wp
         if (k == 3) there%spin = 1.0_wp
         call self%kernel(spot, there, jacobian(:, k))
      end do
      do k = 1, 2
         angle = merge(turn, -turn, k == 1)
         there = motion
         there%rx = motion%rx - angle*motion%ry
         there%ry = motion%ry + angle*motion%rx
         call self%kernel(spot, there, varied(:, k))
      end do
      aside = (varied(:, 1) - varied(:, 2))/(2.0_wp*turn)
      e = inverse*[motion%rx, motion%ry]
      jacobian(:, 4) = inverse*(-wrench*e(1) - aside*e(2))
      jacobian(:, 5) = inverse*(-wrench*e(2) + aside*e(1))
   end subroutine linear_slopes

   !> Wrench without rolling: all slips; against the linear force, whose direction has no limit, so
   !> against the velocities. The linear one has no value.
   pure subroutine at_rest(self, spot, motion, wrench)
      class(closed_type), intent(in) :: self
      type(creep_spot_type), intent(in) :: spot
      type(creep_motion_type), intent(in) :: motion
      !> Force along the major and the minor axis, torque about the normal.
      real(wp), intent(out) :: wrench(3)
      real(wp) :: w, root_k, size

      if (self%reduction == nothing) then
         wrench = ieee_value(wrench, ieee_quiet_nan)
         return
      end if
      root_k = spot%root_k
      w = motion%spin*root_k
      size = sqrt(motion%x**2 + motion%y**2 + w**2)
      ! Not the same operations on x and y: from those the compiler makes one load of both, even
      ! where something rolls, which waits for whoever has written them one after the other.
      wrench = [-motion%x/size, -(1.0_wp/size)*motion%y, -0.5_wp*root_k*w/size]
   end subroutine at_rest

   !> Strips with Carter's solution.
   pure subroutine reduce_strips(square, ratio, slope)
      !> s^2, in units of which the force is.
      real(wp), intent(in) :: square
      !> R(tau)/s, R'(tau) tau/s.
      real(wp), intent(out) :: ratio, slope
      real(wp) :: held, rounded, root, outer, d(2), d2(2), both(2)
      integer(i8) :: j

      ! No branches, which would fail as often as not. The root is s below the split, but for a
      ! factor which the table has, and h above; no part of the table waits for it.
      held = min(square, 1.0_wp)
      rounded = held + to_parts
      j = iand(transfer(rounded, 0_i8), 255_i8)
      d = held - (rounded - to_parts)
      root = sqrt(min((1.0_wp/split - 1.0_wp)*held, 1.0_wp - held))
      outer = 1.0_wp/sqrt(max(square, split))
      d2 = d*d
      both = ((reductions(:, 0, j) + d*reductions(:, 1, j)) &
         + d2*(reductions(:, 2, j) + d*reductions(:, 3, j))) &
         + (d2*d2)*((reductions(:, 4, j) + d*reductions(:, 5, j)) + d2*reductions(:, 6, j))
      ratio = (root*both(1) + reductions(1, -1, j)) + outer
      slope = root*both(2) + reductions(2, -1, j)
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
