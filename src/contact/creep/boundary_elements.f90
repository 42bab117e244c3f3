!> The exact theory of steady rolling as a law of creep: boundary elements on the spot, on two
!> lattices, extrapolated linearly in the size of the elements.
!>
!> What remains of the error is known where creep is so large that nothing sticks: the wrench is
!>    W = (n W_n - n' W_n')/(n - n') + m (W_exact - S),   m = |creepage|^2/(|creepage|^2 + 30^2),
!> S being what the lattices, extrapolated alike, make of full sliding. And where creep is so small
!> that nothing slips: (1 - tau^2)^3 (L - L') is added, L being the linear theory, L' what the
!> lattices make of it and tau < 1 its size, or the creepage over e0 where that is larger. On spots
!> so slender that L has no coefficients it is the part of L' that it would be on the last one.
module contensou_contact_creep_boundary_elements
   use, intrinsic :: ieee_arithmetic, only : ieee_quiet_nan, ieee_value
   use contensou_base_kinds, only : pi, wp
   use contensou_contact_catalogue, only : model_info_type
   use contensou_contact_creep_bounds, only : confine
   use contensou_contact_creep_half_space, only : influence_type, lattice_type, refine, resultant, &
      rolling_influence, solve_tractions, spot_lattice
   use contensou_contact_creep_law, only : creep_model_type, creep_motion_type, creep_spot_type, &
      creep_type
   use contensou_contact_kalker, only : kalker_matrix, least_ratio
   use contensou_contact_parameters, only : parameters_type
   use contensou_contact_wrench, only : slip_type, wrench_exact
   implicit none(type, external)
   private

   public :: boundary_elements, elements_type, new_elements, roll, elements_key, least_elements, &
      most_elements

   !> Elements across the spot, of the fine lattice; the coarse one has half of them. The areas of
   !> both discs of elements, extrapolated, err by 0.2 % only, which those of most pairs do not.
   integer, parameter :: default_elements = 36

   !> The fewest and the most of them.
   integer, parameter :: least_elements = 4, most_elements = 96

   !> Their name among the values that the law is made of.
   character(len=*), parameter :: elements_key = "elements"

   !> Errors of tractions, times the creepage where that is less than e0.
   real(wp), parameter :: tolerance = 1.0e-7_wp

   !> Creepages beyond this many e0 are scaled down to it; the wrench differs by less than its
   !> inverse.
   real(wp), parameter :: largest_creepage = 1.0e6_wp

   !> Creepage, in e0, at which half of what the lattices err in full sliding is taken off.
   real(wp), parameter :: sliding_creepage = 30.0_wp

   type, extends(creep_type) :: boundary_elements_type
      !> Elements across the spot, of the coarse and of the fine lattice.
      integer, private :: across(2) = [default_elements/2, default_elements]
   contains
      procedure :: kernel
   end type boundary_elements_type

   !> Both lattices of a spot and what acts on them.
   type :: elements_type
      type(lattice_type) :: lattice(2)
      !> Influence of tractions on the slip.
      type(influence_type) :: influence(2)
      !> Tractions, last by lattice.
      real(wp), allocatable :: px(:, :, :), py(:, :, :)
   end type elements_type

   !> How a spot rolls: along x in units of sqrt(a b), e0, and the spot obliquely to it.
   type :: rolling_frame_type
      !> Rolling direction, along the major and the minor axis.
      real(wp) :: e(2)
      !> Half the chord through the centre along the rolling direction.
      real(wp) :: half_length
      !> Shift of the middle of the chords along x per y.
      real(wp) :: shear
      !> Creepages along and across the rolling direction, and of spin.
      real(wp) :: creepage(3)
   end type rolling_frame_type

contains

   !> Row of the boundary elements.
   function boundary_elements() result(model)
      type(creep_model_type) :: model

      model%info = model_info_type("boundary_elements", &
         "exact theory on two half-spaces: slip and stick of every element of the spot", "", &
         "J. J. Kalker, Three-Dimensional Elastic Bodies in Rolling Contact, 1990")
      model%create => new_boundary_elements
   end function boundary_elements

   !> Make the law.
   subroutine new_boundary_elements(parameters, creep)
      type(parameters_type), intent(in) :: parameters
      class(creep_type), allocatable, intent(out) :: creep
      type(boundary_elements_type), allocatable :: made

      allocate(made)
      made%across = nint(parameters%number(elements_key, real(default_elements, wp)))*[1, 2]/2
      call move_alloc(made, creep)
   end subroutine new_boundary_elements

   !> Wrench of the tractions that are solved for on all elements.
   pure subroutine kernel(self, spot, motion, wrench)
      class(boundary_elements_type), intent(in) :: self
      type(creep_spot_type), intent(in) :: spot
      type(creep_motion_type), intent(in) :: motion
      !> Force along the major and the minor axis, torque about the normal.
      real(wp), intent(out) :: wrench(3)
      type(rolling_frame_type) :: frame
      type(elements_type) :: elements
      real(wp) :: sliding(3), linear(3), root, small

      call wrench_exact(spot%shape, slip_type(motion%x, motion%y, motion%spin), .true., wrench)
      if (.not. max(abs(motion%rx), abs(motion%ry)) > 0.0_wp) return
      frame = rolling_frame(spot%shape%k, motion)
      if (.not. maxval(abs(frame%creepage)) > 0.0_wp) return
      root = sqrt(spot%shape%k)
      sliding = [frame%e(1)*wrench(1) + frame%e(2)*wrench(2), &
         frame%e(1)*wrench(2) - frame%e(2)*wrench(1), wrench(3)/root]
      elements = new_elements(self%across, frame%half_length, frame%shear, spot%poisson)
      call roll(elements, frame%creepage, sliding, wrench)
      small = sum(frame%creepage**2)
      if (small < 1.0_wp) then
         call stick(elements, frame%creepage, linear)
         small = max(small, linear(1)**2 + linear(2)**2 + (root*linear(3)/spot%shape%torque)**2)
         if (small < 1.0_wp) wrench = wrench &
            + (1.0_wp - small)**3*missing(self%across, spot, motion, frame, linear)
      end if
      wrench = [frame%e(1)*wrench(1) - frame%e(2)*wrench(2), &
         frame%e(2)*wrench(1) + frame%e(1)*wrench(2), root*wrench(3)]
      call confine(spot, motion, wrench)
   end subroutine kernel

   !> What lattices miss of the linear theory, in the rolling frame.
   pure function missing(across, spot, motion, frame, linear)
      !> Elements across, of the coarse and of the fine lattice.
      integer, intent(in) :: across(2)
      type(creep_spot_type), intent(in) :: spot
      type(creep_motion_type), intent(in) :: motion
      !> How the spot rolls.
      type(rolling_frame_type), intent(in) :: frame
      !> What they have of it.
      real(wp), intent(in) :: linear(3)
      real(wp) :: missing(3), c(3, 3), c_slope(3, 3), last(3)
      type(rolling_frame_type) :: stout
      type(elements_type) :: elements

      call kalker_matrix(max(spot%shape%k, least_ratio), spot%poisson, frame%e, c, c_slope)
      missing = -(1.5_wp/pi)*matmul(c, frame%creepage)
      if (spot%shape%k >= least_ratio) then
         missing = missing - linear
         return
      end if
      stout = rolling_frame(least_ratio, motion)
      elements = new_elements(across, stout%half_length, stout%shear, spot%poisson)
      call stick(elements, frame%creepage, last)
      missing = (missing - last)*(norm2(linear)/norm2(last))
   end function missing

   !> Elements of a spot, without tractions.
   pure function new_elements(n, half_length, shear, poisson) result(elements)
      !> Elements across, of the coarse and of the fine lattice.
      integer, intent(in) :: n(2)
      !> Half the chord through the centre, along the rolling direction.
      real(wp), intent(in) :: half_length
      !> Shift of the middle of a chord along x per y.
      real(wp), intent(in) :: shear
      !> Poisson's ratio of both bodies together.
      real(wp), intent(in) :: poisson
      type(elements_type) :: elements
      integer :: i

      do i = 1, 2
         elements%lattice(i) = spot_lattice(n(i), half_length, shear)
         elements%influence(i) = rolling_influence(elements%lattice(i), poisson)
      end do
      allocate(elements%px(n(2), n(2), 2), elements%py(n(2), n(2), 2), source=0.0_wp)
   end function new_elements

   !> Wrench of steady rolling, in the rolling frame.
   pure subroutine roll(elements, creepage, sliding, wrench)
      !> The tractions it has are the first guess.
      type(elements_type), intent(inout) :: elements
      !> Along and across, and of spin; not all are zero.
      real(wp), intent(in) :: creepage(3)
      !> Exact wrench of full sliding.
      real(wp), intent(in) :: sliding(3)
      real(wp), intent(out) :: wrench(3)
      real(wp) :: rolled(3, 2), slid(3, 2), share
      integer :: i, n

      do i = 1, 2
         associate(lattice => elements%lattice(i))
            n = lattice%n
            if (i == 2) then
               call refine(elements%lattice(1), lattice, elements%px(:, :, 1), elements%px(:, :, 2))
               call refine(elements%lattice(1), lattice, elements%py(:, :, 1), elements%py(:, :, 2))
            end if
            call steady_tractions(lattice, elements%influence(i), creepage, .true., &
               elements%px(:n, :n, i), elements%py(:n, :n, i))
            rolled(:, i) = resultant(lattice, elements%px(:n, :n, i), elements%py(:n, :n, i))
            slid(:, i) = full_sliding(lattice, creepage)
         end associate
      end do
      share = 1.0_wp/(1.0_wp + (sliding_creepage/norm2(creepage))**2)
      wrench = matmul(rolled - share*slid, weights(elements)) + share*sliding
   end subroutine roll

   !> Wrench where everything sticks, in the rolling frame.
   pure subroutine stick(elements, creepage, wrench)
      !> The tractions it has are the first guess.
      type(elements_type), intent(inout) :: elements
      !> Along and across, and of spin; not all are zero.
      real(wp), intent(in) :: creepage(3)
      real(wp), intent(out) :: wrench(3)
      real(wp) :: rolled(3, 2)
      integer :: i, n

      do i = 1, 2
         associate(lattice => elements%lattice(i))
            n = lattice%n
            call steady_tractions(lattice, elements%influence(i), creepage, .false., &
               elements%px(:n, :n, i), elements%py(:n, :n, i))
            rolled(:, i) = resultant(lattice, elements%px(:n, :n, i), elements%py(:n, :n, i))
         end associate
      end do
      wrench = matmul(rolled, weights(elements))
   end subroutine stick

   !> Weights of the coarse and of the fine lattice in the extrapolation.
   pure function weights(elements) result(weight)
      type(elements_type), intent(in) :: elements
      real(wp) :: weight(2)

      weight = real([-elements%lattice(1)%n, elements%lattice(2)%n], wp) &
         /real(elements%lattice(2)%n - elements%lattice(1)%n, wp)
   end function weights

   !> How a spot rolls.
   pure function rolling_frame(k, motion) result(frame)
      !> Ratio of the minor to the major axis.
      real(wp), intent(in) :: k
      !> Something rolls.
      type(creep_motion_type), intent(in) :: motion
      type(rolling_frame_type) :: frame
      real(wp) :: rolling, square, largest

      rolling = hypot(motion%rx, motion%ry)
      frame%e = -[motion%rx, motion%ry]/rolling
      square = frame%e(1)**2*k + frame%e(2)**2/k
      frame%half_length = 1.0_wp/sqrt(square)
      frame%shear = -frame%e(1)*frame%e(2)*(1.0_wp/k - k)/square
      frame%creepage = [motion%x*frame%e(1) + motion%y*frame%e(2), &
         motion%y*frame%e(1) - motion%x*frame%e(2), motion%spin*sqrt(k)]
      largest = maxval(abs(frame%creepage))
      if (largest > largest_creepage*rolling) then
         frame%creepage = frame%creepage/(largest/largest_creepage)
      else
         frame%creepage = frame%creepage/rolling
      end if
   end function rolling_frame

   !> Tractions of steady rolling.
   pure subroutine steady_tractions(lattice, influence, creepage, bounded, px, py)
      type(lattice_type), intent(in) :: lattice
      !> Influence on the slip of steady rolling.
      type(influence_type), intent(in) :: influence
      !> Along and across, and of spin.
      real(wp), intent(in) :: creepage(3)
      !> Whether friction bounds them.
      logical, intent(in) :: bounded
      !> Tractions: a guess, then the solution; NaN if there is none.
      real(wp), intent(inout) :: px(:, :), py(:, :)
      real(wp) :: residual, error

      error = tolerance*min(norm2(creepage), 1.0_wp)
      call solve_tractions(lattice, influence, creepage(1) - creepage(3)*lattice%y, &
         creepage(2) + creepage(3)*lattice%x, bounded, error, px, py, residual)
      if (residual > error) then
         px = ieee_value(px, ieee_quiet_nan)
         py = px
      end if
   end subroutine steady_tractions

   !> What a lattice makes of full sliding.
   pure function full_sliding(lattice, creepage) result(wrench)
      type(lattice_type), intent(in) :: lattice
      !> Along and across, and of spin.
      real(wp), intent(in) :: creepage(3)
      real(wp) :: wrench(3)
      real(wp), dimension(lattice%n, lattice%n) :: x, y, scale

      x = creepage(1) - creepage(3)*lattice%y
      y = creepage(2) + creepage(3)*lattice%x
      scale = -lattice%bound/max(hypot(x, y), tiny(x))
      wrench = resultant(lattice, scale*x, scale*y)
   end function full_sliding

end module contensou_contact_creep_boundary_elements
