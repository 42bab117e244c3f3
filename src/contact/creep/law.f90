!> Law of creep: the steady wrench of a spot that slides, spins and is passed by material that rolls
!> through it. What each law must answer.
!>
!> Body 1 slides against body 2 with (vx, vy) at the centre of the spot and spins with w; (cx, cy)
!> is the mean velocity of the material of both through the spot, V its length, so that the spot
!> rolls along -c. Creepages are v/V and w/V; no law divides by V but those that have no limit at
!> V = 0.
!>
!> For bodies that are half-spaces and the pressure of Hertz, the wrench in units of f N and f N a
!> depends on the ratio of the axes, on nu, and is homogeneous of degree zero in the five velocities
!> vx, vy, W = a w and r = e0 c,
!>    e0 = f p0/G = 3 f N/(2 pi a b G)
!> being the scale of creepage. So a law is a kernel of these, with derivatives by them; those by
!> load and size follow:
!>    N dF/dN = F + r.dF/dr,   a dF/da = W dF/dW - 2 r.dF/dr,   a dT/da = T + W dT/dW - 2 r.dT/dr
!> at constant shape. docs/rolling.md has the formulas of all laws.
module contensou_contact_creep_law
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite, ieee_quiet_nan, ieee_value
   use contensou_base_kinds, only : i8, pi, wp
   use contensou_contact_catalogue, only : model_type
   use contensou_contact_friction_law, only : sliding_type
   use contensou_contact_kalker, only : kalker_by_direction, kalker_matrix
   use contensou_contact_parameters, only : parameters_type
   use contensou_contact_spot, only : spot_shape_type
   use contensou_contact_wrench_scaling, only : rescaled
   implicit none(type, external)
   private

   public :: creep_type, creep_model_type, creep_spot_type, creep_motion_type, passing_type
   public :: creep_spot, settled_spot, linear_theory

   !> Number of velocities of the kernel: x, y, spin, rx, ry.
   integer, parameter, public :: n_velocities = 5

   !> Number of arguments that a scene varies: N, a, vx, vy, w, cx, cy.
   integer, parameter, public :: n_arguments = 7

   !> Relative step of differences.
   real(wp), parameter :: step = 6.0e-6_wp

   !> Velocities below this part of the largest one are none: their squares would be none.
   real(wp), parameter :: least_part = 1.0e-100_wp

   !> Rolling below this part of sliding changes the wrench over the scale of this part.
   real(wp), parameter :: slow = 1.0e-2_wp

   !> What a law is evaluated for beside load, size and motion.
   type :: creep_spot_type
      !> Shape; the axes of the spot are its major and its minor one.
      type(spot_shape_type) :: shape
      !> Root of the ratio of the minor to the major axis.
      real(wp) :: root_k
      !> Friction coefficient f [-].
      real(wp) :: coefficient
      !> Shear modulus G of both bodies together [Pa], 1/G = (1/G1 + 1/G2)/2.
      real(wp) :: modulus
      !> Poisson's ratio of both together, nu/G = (nu1/G1 + nu2/G2)/2.
      real(wp) :: poisson
      !> Kalker's coefficients by the direction, of shapes that do not change; else there are none,
      !> and each call makes its own.
      real(wp), allocatable :: by_direction(:, :, :)
   end type creep_spot_type

   !> Makes a spot for one call, or a few, from its shape and material.
   interface creep_spot_type
      procedure :: creep_spot
   end interface creep_spot_type

   !> Load, size and sliding of a spot, and what rolls through it.
   type, extends(sliding_type) :: passing_type
      !> Velocity of the material through the spot along the major and the minor axis [m/s].
      real(wp) :: cx = 0.0_wp, cy = 0.0_wp
   end type passing_type

   !> Arguments of a kernel, in a common unit of velocity in which the largest is between 1/2 and 1.
   type :: creep_motion_type
      !> Sliding velocity along the major and the minor axis.
      real(wp) :: x, y
      !> Spin velocity W = a w, with its sign.
      real(wp) :: spin
      !> Velocity of the material through the spot times e0.
      real(wp) :: rx, ry
   end type creep_motion_type

   !> A law of creep with its parameters.
   type, abstract :: creep_type
      !> Whether what rolls sticks where it enters the spot.
      logical :: sticks = .true.
      !> Whether it loses the coupling of creepage and spin before the rest of the linear wrench.
      logical :: uncouples = .false.
      !> Whether nothing exceeds full sliding; else the wrench does not depend on the load.
      logical :: limited = .true.
   contains
      !> Wrench in units of f N and f N a.
      procedure(kernel_of), deferred :: kernel
      procedure :: kernel_slopes => differ_kernel
      !> Wrench in SI units.
      procedure, non_overridable :: wrench
      procedure, non_overridable :: linearize
   end type creep_type

   !> A row in the table of the laws of creep.
   type, extends(model_type) :: creep_model_type
      !> Makes the law from the values of its keys.
      procedure(new_creep), pointer, nopass :: create => null()
   contains
      procedure :: make
   end type creep_model_type

   abstract interface
      !> Steady wrench in units of f N and f N a on the body that slides; something moves.
      pure subroutine kernel_of(self, spot, motion, wrench)
         import :: creep_motion_type, creep_spot_type, creep_type, wp
         implicit none(type, external)
         class(creep_type), intent(in) :: self
         type(creep_spot_type), intent(in) :: spot
         type(creep_motion_type), intent(in) :: motion
         !> Force along the major and the minor axis, torque about the normal.
         real(wp), intent(out) :: wrench(3)
      end subroutine kernel_of

      !> Make a law of creep.
      subroutine new_creep(parameters, creep)
         import :: creep_type, parameters_type
         implicit none(type, external)
         !> Values of its keys, complete.
         type(parameters_type), intent(in) :: parameters
         class(creep_type), allocatable, intent(out) :: creep
      end subroutine new_creep
   end interface

contains

   !> Make the law of a row, with the defaults of its keys.
   subroutine make(self, law)
      class(creep_model_type), intent(in) :: self
      class(creep_type), allocatable, intent(out) :: law

      call self%create(self%completed(parameters_type()), law)
   end subroutine make

   !> A spot for one call, or a few.
   pure function creep_spot(shape, coefficient, modulus, poisson) result(spot)
      type(spot_shape_type), intent(in) :: shape
      !> Friction coefficient f [-], >= 0.
      real(wp), intent(in) :: coefficient
      !> Shear modulus G [Pa], > 0.
      real(wp), intent(in) :: modulus
      !> Poisson's ratio, from 0 to 1/2.
      real(wp), intent(in) :: poisson
      type(creep_spot_type) :: spot

      spot%shape = shape
      spot%root_k = sqrt(shape%k)
      spot%coefficient = coefficient
      spot%modulus = modulus
      spot%poisson = poisson
   end function creep_spot

   !> The same spot with what follows from its shape alone, for many calls.
   pure function settled_spot(spot) result(settled)
      type(creep_spot_type), intent(in) :: spot
      type(creep_spot_type) :: settled

      settled = spot
      settled%by_direction = kalker_by_direction(spot%shape%k, spot%poisson)
   end function settled_spot

   !> Kalker's coefficients C11, C12, C22, C13, C23, C33 of a spot that rolls.
   pure subroutine linear_theory(spot, rx, ry, c)
      type(creep_spot_type), intent(in) :: spot
      !> Velocity of the material through the spot, in either sense.
      real(wp), intent(in) :: rx, ry
      real(wp), intent(out) :: c(6)
      real(wp) :: matrix(3, 3), slope(3, 3)

      call kalker_matrix(spot%shape%k, spot%poisson, [rx, ry]/sqrt(rx*rx + ry*ry), matrix, slope, &
         spot%by_direction)
      c = [matrix(1, 1), matrix(1, 2), matrix(2, 2), matrix(1, 3), matrix(2, 3), matrix(3, 3)]
   end subroutine linear_theory

   !> Wrench of a law.
   pure subroutine wrench(self, spot, at, force)
      class(creep_type), intent(in) :: self
      type(creep_spot_type), intent(in) :: spot
      type(passing_type), intent(in) :: at
      !> Force along the major and the minor axis [N], torque about the normal [N m]: none without
      !> load, friction or motion; NaN outside the domain.
      real(wp), intent(out) :: force(3)
      type(creep_motion_type) :: motion
      integer :: shift
      logical :: acts

      call prepare(spot, at, motion, shift, acts, force)
      if (.not. acts) return
      call self%kernel(spot, motion, force)
      force = spot%coefficient*at%load*[force(1), force(2), at%a*force(3)]
   end subroutine wrench

   !> Wrench of a law and its derivatives.
   !>
   !> Those by load and size are at constant shape of the spot. Entries that would overflow are the
   !> largest number of the kind.
   pure subroutine linearize(self, spot, at, force, slopes)
      class(creep_type), intent(in) :: self
      type(creep_spot_type), intent(in) :: spot
      type(passing_type), intent(in) :: at
      !> Force along the major and the minor axis [N], torque about the normal [N m].
      real(wp), intent(out) :: force(3)
      !> Derivative of component i by N, a, vx, vy, w, cx, cy.
      real(wp), intent(out) :: slopes(3, n_arguments)
      type(creep_motion_type) :: motion
      type(passing_type) :: loaded
      real(wp) :: jacobian(3, n_velocities), rolling(3), unit(3), e0
      integer :: shift, i
      logical :: acts

      slopes = 0.0_wp
      call prepare(spot, at, motion, shift, acts, force)
      if (.not. acts) then
         slopes = slopes + spread(force, 2, n_arguments)
         if (.not. (abs(force(1)) <= 0.0_wp .and. abs(at%load) <= 0.0_wp)) return
         ! The first load meets full sliding: e0 is zero. What has no limit is not full sliding even
         ! there: it takes its force at once, with any load, and then no more.
         if (.not. self%limited) return
         loaded = at
         loaded%load = 1.0_wp
         loaded%cx = 0.0_wp
         loaded%cy = 0.0_wp
         call self%wrench(spot, loaded, slopes(:, 1))
         return
      end if
      call self%kernel_slopes(spot, motion, force, jacobian)
      unit = spot%coefficient*at%load*[1.0_wp, 1.0_wp, at%a]
      rolling = jacobian(:, 4)*motion%rx + jacobian(:, 5)*motion%ry
      slopes(:, 1) = unit*(force + rolling)/at%load
      slopes(:, 2) = jacobian(:, 3)*motion%spin - 2.0_wp*rolling
      slopes(3, 2) = slopes(3, 2) + force(3)
      slopes(:, 2) = unit*slopes(:, 2)/at%a
      e0 = creepage_scale(spot, at)
      do i = 1, 3
         jacobian(i, :) = rescaled(unit(i)*jacobian(i, :), shift)
      end do
      slopes(:, 3:4) = jacobian(:, 1:2)
      slopes(:, 5) = at%a*jacobian(:, 3)
      slopes(:, 6:7) = e0*jacobian(:, 4:5)
      force = unit*force
   end subroutine linearize

   !> Arguments of the kernel, unless the wrench is known without it.
   pure subroutine prepare(spot, at, motion, shift, acts, force)
      type(creep_spot_type), intent(in) :: spot
      type(passing_type), intent(in) :: at
      type(creep_motion_type), intent(out) :: motion
      !> The unit of velocity is 2**(-shift) m/s.
      integer, intent(out) :: shift
      !> Whether the kernel has to be asked.
      logical, intent(out) :: acts
      !> The wrench if not: zero without load, friction or motion, NaN outside the domain.
      real(wp), intent(out) :: force(3)
      real(wp) :: e0, largest, least, factor

      motion = creep_motion_type(0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp)
      shift = 0
      force = 0.0_wp
      ! Before any comparison: comparing a NaN raises an exception.
      acts = ieee_is_finite(at%load) .and. ieee_is_finite(at%a) .and. ieee_is_finite(at%vx) .and. &
         ieee_is_finite(at%vy) .and. ieee_is_finite(at%w) .and. ieee_is_finite(at%cx) .and. &
         ieee_is_finite(at%cy) .and. ieee_is_finite(spot%shape%k) .and. &
         ieee_is_finite(spot%coefficient) .and. ieee_is_finite(spot%modulus) .and. &
         ieee_is_finite(spot%poisson)
      if (acts) acts = at%load >= 0.0_wp .and. at%a >= 0.0_wp .and. spot%coefficient >= 0.0_wp &
         .and. spot%modulus > 0.0_wp .and. spot%poisson >= 0.0_wp .and. spot%poisson <= 0.5_wp
      if (.not. acts) then
         force = ieee_value(force, ieee_quiet_nan)
         return
      end if
      acts = at%load > 0.0_wp .and. spot%coefficient > 0.0_wp
      if (.not. acts) return
      motion = creep_motion_type(at%vx, at%vy, at%a*at%w, 0.0_wp, 0.0_wp)
      if (at%a > 0.0_wp) then
         e0 = creepage_scale(spot, at)
         motion%rx = e0*at%cx
         motion%ry = e0*at%cy
      else
         ! A point under load is strained without end, and gives no force, where anything rolls.
         acts = .not. max(abs(at%cx), abs(at%cy)) > 0.0_wp
         if (.not. acts) return
      end if
      largest = max(abs(motion%x), abs(motion%y), abs(motion%spin), abs(motion%rx), abs(motion%ry))
      acts = largest > 0.0_wp
      if (.not. acts) return
      call scale_of(largest, shift, factor)
      least = least_part*largest
      motion%x = part(motion%x)
      motion%y = part(motion%y)
      motion%spin = part(motion%spin)
      motion%rx = part(motion%rx)
      motion%ry = part(motion%ry)

   contains

      !> A velocity in the common unit.
      pure real(wp) function part(velocity)
         real(wp), intent(in) :: velocity

         part = 0.0_wp
         if (abs(velocity) < least) return
         if (factor > 0.0_wp) then
            part = factor*velocity
         else
            part = scale(velocity, shift)
         end if
      end function part

   end subroutine prepare

   !> The power of two that brings a number to between 1/2 and 1. From its bits: `exponent` and
   !> `scale` are calls of a library.
   pure subroutine scale_of(largest, shift, factor)
      !> > 0.
      real(wp), intent(in) :: largest
      !> The power.
      integer, intent(out) :: shift
      !> Two to that power, zero if that is no normal number.
      real(wp), intent(out) :: factor
      integer(i8) :: biased

      biased = ishft(transfer(largest, biased), 1 - digits(largest))
      if (biased >= 1_i8 .and. biased < 2*maxexponent(largest) - 3) then
         shift = int(maxexponent(largest) - 2 - biased)
         factor = transfer(ishft(2*maxexponent(largest) - 3 - biased, digits(largest) - 1), factor)
      else
         shift = -exponent(largest)
         factor = 0.0_wp
      end if
   end subroutine scale_of

   !> Scale of creepage e0 = f p0/G.
   pure real(wp) function creepage_scale(spot, at)
      type(creep_spot_type), intent(in) :: spot
      type(passing_type), intent(in) :: at

      creepage_scale = 1.5_wp*spot%coefficient*at%load/(pi*at%a**2*spot%shape%k*spot%modulus)
   end function creepage_scale

   !> Kernel and its derivatives by the velocities: by differences, unless a law knows better.
   pure subroutine differ_kernel(self, spot, motion, wrench, jacobian)
      class(creep_type), intent(in) :: self
      type(creep_spot_type), intent(in) :: spot
      type(creep_motion_type), intent(in) :: motion
      !> Force along the major and the minor axis, torque about the normal.
      real(wp), intent(out) :: wrench(3)
      !> Derivative of component i by x, y, spin, rx, ry.
      real(wp), intent(out) :: jacobian(3, n_velocities)
      real(wp) :: varied(3, 2), slides, rolls, h
      integer :: i, k

      call self%kernel(spot, motion, wrench)
      slides = max(abs(motion%x), abs(motion%y), abs(motion%spin))
      rolls = max(abs(motion%rx), abs(motion%ry))
      do i = 1, n_velocities
         h = step*max(slides, rolls)
         if (i > 3) h = step*max(slow*slides, rolls)
         do k = 1, 2
            call self%kernel(spot, varied_by(motion, i, merge(h, -h, k == 1)), varied(:, k))
         end do
         jacobian(:, i) = (varied(:, 1) - varied(:, 2))/(2.0_wp*h)
      end do
   end subroutine differ_kernel

   !> A motion of which one velocity is varied.
   pure function varied_by(motion, which, h) result(there)
      type(creep_motion_type), intent(in) :: motion
      !> 1 to 5: x, y, spin, rx, ry.
      integer, intent(in) :: which
      real(wp), intent(in) :: h
      type(creep_motion_type) :: there

      there = motion
      select case (which)
      case (1)
         there%x = motion%x + h
      case (2)
         there%y = motion%y + h
      case (3)
         there%spin = motion%spin + h
      case (4)
         there%rx = motion%rx + h
      case default
         there%ry = motion%ry + h
      end select
   end function varied_by

end module contensou_contact_creep_law
