!> What rolling carries out of a spot that remembers, by a law of creep.
!>
!> The shells of a spot are strained by what is left of the sliding v when the creep u is taken off
!> that the material loses on its way out. With xi the creepage that it carries, a state, V the
!> velocity of the material through the spot and W the wrench of the shells,
!>    u = V (xi + g h Theta d),  xi' = (V/l) g^4 diag(b) M^-1 d,  d = L^-1 (W_law(xi) - W),
!> along the rolling, across and about the normal, L being Kalker's matrix, W = -L xi where nothing
!> slips, and l and w the half-length and the half-width of the spot along the rolling and across. d
!> is what is missing of xi to bear W, by the linear theory. Steady is xi = v/V and W = W_law(v):
!> the steady state of the memory is the law of creep, whichever it is. Without rolling the shells
!> are all there is. Strain that enters leaves the spot after some way. With p = w^2/(l^2 + w^2)
!>    Theta = diag(0.59, 0.61 + 0.4 (1 - p)^7, 0.38),
!>    M = diag(3.9, 0.34 + 1.28 p, 0.23 + 1.1 p),
!>    b = (1 + 34 s, 1 + 2.6 s + 14 s^4, 1 + 8 s).
!> With r the share of the limit that W has, and r_law that of W_law(xi), s = r_law^2/(r_law^2 + r^2
!> + 1e-6), from 0 to 1 and 1/2 where nothing is missing: what is carried grows the faster, the more
!> of it there is, as the material behind strains and leaves after that in front. With q = 4/(3 pi)
!> g = 1/(q + (1 - q) sqrt(1.001 - r)) is about the creepage by which strips bear W over that of the
!> linear theory; 1.001 in the place of 1 keeps its slope finite, by which rounding would grow.
!> Rolling turns a twist of the spot into a shift of what lies behind: beside its diagonal Theta has
!> -0.4 l x^2 across, by what is missing of the spin, with x the part of r^2 that is the torque's.
!> The less the law rises the more creepage is missing for the same d, hence g^4; with it in xi'
!> alone W would ring about steady rolling, and with spin leave it. So near there u has it, too,
!>    h = 1 + diag(0.3, 0.35, 1) (g^3 - 1) (4 s (1 - s))^32 .
!> Where all slips, as W is that of full sliding along v - V xi (to 0.01 of the limit, and a smooth
!> part up to 0.08), W_law(v) takes the place of W_law(xi), or what of it has the share r. Else xi
!> would grow only until it bears the limit, and W have the direction of what is left of v.
!> The closed forms lose the coupling of creepage and spin (C13, C23) before the rest: from L in d
!> it is taken off by as much, as it would have W ring about what such a law says.
!> All this is fitted to the onset of rolling under a constant force, and of spin, by boundary
!> elements in time: docs/rolling.md.
!> Where surfaces touch V/l has no bound, and d counts the less the smaller the spot is.
!> Where u would have W drive its part along W is left out (`hold_back`).
module contensou_contact_tangential_carry
   use contensou_base_kinds, only : pi, wp
   use contensou_base_vectors, only : cross
   use contensou_contact_creep_law, only : creep_spot, creep_spot_type, creep_type, passing_type
   use contensou_contact_kalker, only : kalker_matrix
   use contensou_contact_spot, only : circular_shape, spot_shape_type
   implicit none(type, external)
   private

   public :: carry_type, carried_type

   !> Share of what is missing that is lost at once: along the rolling, across for a spot without
   !> length and what it is more for one without width, and about the normal.
   real(wp), parameter :: theta_along = 0.59_wp, theta_across = 0.61_wp, theta_more = 0.4_wp, &
      theta_about = 0.38_wp

   !> Half-lengths by which what is missing of the spin is lost across, where all is torque.
   real(wp), parameter :: theta_beside = 0.4_wp

   !> Way in half-lengths of the spot over which the rest follows while nothing is carried, for a
   !> spot without width, and what it is more for one without length: along the rolling, across and
   !> about the normal.
   real(wp), parameter :: mu(3) = [3.9_wp, 0.34_wp, 0.23_wp], mu_more(3) = [0.0_wp, 1.28_wp, 1.1_wp]

   !> How much faster it follows the more is carried, and where nearly all is carried and nothing
   !> borne.
   real(wp), parameter :: faster(3) = [34.0_wp, 2.6_wp, 8.0_wp], at_last(3) = [0.0_wp, 14.0_wp, &
      0.0_wp]

   !> Square of a share of the limit that is as good as none.
   real(wp), parameter :: least_share = 1.0e-6_wp

   !> What of g^3 - 1 is lost at once, too, where nothing is missing, and the power of what is one
   !> there: steady rolling is stable by it.
   real(wp), parameter :: steadying(3) = [0.3_wp, 0.35_wp, 1.0_wp]
   integer, parameter :: nearly = 32

   !> Linear over limiting creepage of strips, inverse.
   real(wp), parameter :: q = 4.0_wp/(3.0_wp*pi)

   !> What rounds the root of 1 - r, by which this ends where all slips.
   real(wp), parameter :: rounded = 1.0e-3_wp

   !> Spots below this part of the usual size carry nothing more: V/l has no bound where surfaces
   !> touch, and what rounding makes of a spot there would be followed.
   real(wp), parameter :: smallest = 0.03_wp

   !> Share of the limit up to which it may drive, about.
   real(wp), parameter :: little = 0.03_wp

   !> Relative step of differences.
   real(wp), parameter :: step = 1.0e-6_wp

   !> A spot under load through which material rolls.
   type :: carried_type
      !> Normal force [N] and major semi-axis [m].
      real(wp) :: load, a
      !> Velocity of the material through the spot along the axes [m/s].
      real(wp) :: velocity(2)
      !> Creepage along the axes that is carried, and of spin [1/m].
      real(wp) :: creepage(3)
      !> Force along the axes [N] and torque [N m] that the shells bear, on body 1.
      real(wp) :: wrench(3)
      !> Usual limit of the force [N].
      real(wp) :: usual
      !> Sliding velocity along the axes [m/s] and spin [rad/s], and how far all slips by what of
      !> them is not carried, from 0 to 1; the former counts with the latter only.
      real(wp) :: motion(3) = 0.0_wp, slips = 0.0_wp
   end type carried_type

   !> A law of creep between two materials.
   type :: carry_type
      !> The law.
      class(creep_type), allocatable :: creep
      !> Friction coefficient and moduli; the shape is that of a circle.
      type(creep_spot_type), private :: spot
   contains
      procedure :: begin
      procedure :: lose
      procedure :: vary
      procedure :: creep_scale
   end type carry_type

contains

   !> Take the materials.
   pure subroutine begin(self, coefficient, modulus, poisson)
      class(carry_type), intent(inout) :: self
      !> Friction coefficient f [-].
      real(wp), intent(in) :: coefficient
      !> Shear modulus [Pa] and Poisson's ratio of both bodies together.
      real(wp), intent(in) :: modulus, poisson

      self%spot = creep_spot(circular_shape, coefficient, modulus, poisson)
   end subroutine begin

   !> Creepage f p0/G of a spot; zero without a load.
   pure real(wp) function creep_scale(self, shape, load, a)
      class(carry_type), intent(in) :: self
      type(spot_shape_type), intent(in) :: shape
      !> Normal force [N] and major semi-axis [m].
      real(wp), intent(in) :: load, a

      creep_scale = 0.0_wp
      if (load > 0.0_wp .and. a > 0.0_wp) creep_scale = 1.5_wp*self%spot%coefficient*load &
         /(pi*a**2*shape%k*self%spot%modulus)
   end function creep_scale

   !> What is lost to creep, and how the creepage that is carried changes.
   pure subroutine lose(self, shape, at, lost, rate)
      class(carry_type), intent(in) :: self
      type(spot_shape_type), intent(in) :: shape
      type(carried_type), intent(in) :: at
      !> Velocity along the axes [m/s] and spin [rad/s] that do not strain the shells.
      real(wp), intent(out) :: lost(3)
      !> Time derivative of the creepage [1/s].
      real(wp), intent(out) :: rate(3)
      type(creep_spot_type) :: spot
      real(wp) :: speed, e(2), c(3, 3), slope(3, 3), e0, root, limit, bears(3), steady(3)
      real(wp) :: missing(3), square, along, wide, borne, carried, twisted, beside, g

      lost = 0.0_wp
      rate = 0.0_wp
      speed = sqrt(at%velocity(1)**2 + at%velocity(2)**2)
      e0 = self%creep_scale(shape, at%load, at%a)
      if (.not. (speed > 0.0_wp .and. e0 > 0.0_wp)) return
      spot = creep_spot(shape, self%spot%coefficient, self%spot%modulus, self%spot%poisson)
      e = -at%velocity/speed
      limit = spot%coefficient*at%load
      call self%creep%wrench(spot, passing_type(at%load, at%a, at%creepage(1), at%creepage(2), &
         at%creepage(3), 0.0_wp, -e(1), -e(2)), bears)
      root = sqrt(shape%k)
      call kalker_matrix(shape%k, spot%poisson, e, c, slope)
      if (self%creep%uncouples) call uncouple(c, turned(at%creepage, 1.0_wp/(at%a*root)), &
         turned(bears, at%a*root))
      borne = share_squared(at%wrench)
      call cut(bears, 1.0_wp)
      if (at%slips > 0.0_wp) then
         call self%creep%wrench(spot, passing_type(at%load, at%a, at%motion(1), at%motion(2), &
            at%motion(3), 0.0_wp, at%velocity(1), at%velocity(2)), steady)
         call cut(steady, borne)
         bears = bears + at%slips*(steady - bears)
      end if
      missing = turned((bears - at%wrench)/limit, at%a*root)
      ! Squares of sizes, in units of their own.
      square = limit**(2.0_wp/3.0_wp)
      missing = (pi/1.5_wp)*e0*solved(c, missing) &
         *(square/(square + smallest**2*at%usual**(2.0_wp/3.0_wp)))
      ! Half-length of the spot, inverse, in semi-axes. w^2/(l^2 + w^2) is linear in its square.
      along = sqrt(e(1)**2 + (e(2)/shape%k)**2)
      wide = ((e(1)*shape%k)**2 + e(2)**2)/(1.0_wp + shape%k**2)
      carried = share_squared(bears)
      carried = carried/(carried + borne + least_share)
      rate = (1.0_wp + faster*carried + at_last*carried**4)*missing/(mu + mu_more*wide)
      g = 1.0_wp/(q + (1.0_wp - q)*sqrt(1.0_wp + rounded - min(sqrt(borne), 1.0_wp)))
      twisted = (at%wrench(3)/(limit*at%a*shape%torque))**2/(borne + least_share)
      beside = theta_beside/(along*root)*twisted**2*missing(3)
      missing = [theta_along, theta_across + theta_more*(1.0_wp - wide)**7, theta_about]*missing
      missing(2) = missing(2) - beside
      missing = (1.0_wp + steadying*((g**3 - 1.0_wp)*(4.0_wp*carried*(1.0_wp - carried))**nearly)) &
         *missing
      missing = [e(1)*missing(1) - e(2)*missing(2), e(2)*missing(1) + e(1)*missing(2), &
         missing(3)/(at%a*root)]
      rate = [e(1)*rate(1) - e(2)*rate(2), e(2)*rate(1) + e(1)*rate(2), rate(3)/(at%a*root)]
      lost = speed*(at%creepage + g*missing)
      rate = (speed/at%a*along*g**4)*rate
      call hold_back(at%wrench, at%a*root, little*(limit + at%usual), lost)

   contains

      !> Square of the share of the limit that a wrench has.
      pure real(wp) function share_squared(wrench)
         real(wp), intent(in) :: wrench(3)

         share_squared = (wrench(1)/limit)**2 + (wrench(2)/limit)**2 &
            + (wrench(3)/(limit*at%a*shape%torque))**2
      end function share_squared

      !> Leave the part of a wrench that has a share of the limit.
      pure subroutine cut(wrench, most)
         real(wp), intent(inout) :: wrench(3)
         !> Square of the share.
         real(wp), intent(in) :: most
         real(wp) :: share

         share = share_squared(wrench)
         if (share > most) wrench = sqrt(most/share)*wrench
      end subroutine cut

      !> Along the rolling, across and about the normal.
      pure function turned(wrench, arm)
         !> Along the axes and about the normal.
         real(wp), intent(in) :: wrench(3)
         !> What a torque is divided by [m].
         real(wp), intent(in) :: arm
         real(wp) :: turned(3)

         turned = [e(1)*wrench(1) + e(2)*wrench(2), e(1)*wrench(2) - e(2)*wrench(1), wrench(3)/arm]
      end function turned

   end subroutine lose

   !> Take off the linear theory the coupling of creepage and spin that a law has lost.
   pure subroutine uncouple(c, creepage, wrench)
      !> Kalker's matrix.
      real(wp), intent(inout) :: c(3, 3)
      !> Along the rolling, across, and spin times sqrt(a b).
      real(wp), intent(in) :: creepage(3)
      !> What the law bears, over any force, the torque also over sqrt(a b).
      real(wp), intent(in) :: wrench(3)
      real(wp), dimension(3) :: direct, coupled
      real(wp) :: dd, dc, cc, wd, wc, part

      direct = [c(1:2, 1)*creepage(1) + c(1:2, 2)*creepage(2), c(3, 3)*creepage(3)]
      coupled = [c(1:2, 3)*creepage(3), c(3, 1)*creepage(1) + c(3, 2)*creepage(2)]
      ! Closest to a direct + b coupled is the wrench where a and b solve a system of two equations.
      dd = dot_product(direct, direct)
      dc = dot_product(direct, coupled)
      cc = dot_product(coupled, coupled)
      wd = dot_product(wrench, direct)
      wc = dot_product(wrench, coupled)
      part = wd*cc - wc*dc
      if (.not. abs(part) > 0.0_wp) return
      part = min(max((wc*dd - wd*dc)/part, 0.0_wp), 1.0_wp)
      c(1:2, 3) = part*c(1:2, 3)
      c(3, 1:2) = part*c(3, 1:2)
   end subroutine uncouple

   !> Take off a loss what would have the wrench drive: the material that leaves the spot takes
   !> energy out of it, but brings none.
   pure subroutine hold_back(wrench, arm, small, lost)
      real(wp), intent(in) :: wrench(3)
      !> What a torque is divided by to be a force [m], and a force up to which it may drive, about
      !> [N].
      real(wp), intent(in) :: arm, small
      real(wp), intent(inout) :: lost(3)
      real(wp) :: power

      power = dot_product(wrench, lost)
      if (.not. power > 0.0_wp) return
      power = power/(wrench(1)**2 + wrench(2)**2 + (wrench(3)/arm)**2 + small**2)
      lost = lost - power*[wrench(1:2), wrench(3)/arm**2]
   end subroutine hold_back

   !> The same with the derivatives of loss and rate, by differences: by load, size, creepage and
   !> wrench.
   pure subroutine vary(self, shape, at, lost, rate, slopes)
      class(carry_type), intent(in) :: self
      type(spot_shape_type), intent(in) :: shape
      type(carried_type), intent(in) :: at
      !> As for `lose`.
      real(wp), intent(out) :: lost(3), rate(3)
      !> Derivatives of loss, then of rate, by load, size, the creepages and the wrench.
      real(wp), intent(out) :: slopes(6, 8)
      real(wp) :: x(8), h(8), e0, varied(6, 2)
      integer :: i, k

      call self%lose(shape, at, lost, rate)
      slopes = 0.0_wp
      e0 = self%creep_scale(shape, at%load, at%a)
      if (.not. e0 > 0.0_wp) return
      h = step*[at%load, at%a, max(abs(at%creepage), e0*[1.0_wp, 1.0_wp, 1.0_wp/at%a]), &
         self%spot%coefficient*at%load*[1.0_wp, 1.0_wp, at%a*shape%torque]]
      do i = 1, size(x)
         do k = 1, 2
            x = [at%load, at%a, at%creepage, at%wrench]
            x(i) = x(i) + merge(h(i), -h(i), k == 1)
            call self%lose(shape, carried_type(x(1), x(2), at%velocity, x(3:5), x(6:8), &
               at%usual), varied(:3, k), varied(4:, k))
         end do
         slopes(:, i) = (varied(:, 1) - varied(:, 2))/(2.0_wp*h(i))
      end do
   end subroutine vary

   !> Solution of a regular system of three equations.
   pure function solved(matrix, right) result(x)
      real(wp), intent(in) :: matrix(3, 3), right(3)
      real(wp) :: x(3)
      real(wp) :: inverse(3, 3)

      inverse(1, :) = cross(matrix(:, 2), matrix(:, 3))
      inverse(2, :) = cross(matrix(:, 3), matrix(:, 1))
      inverse(3, :) = cross(matrix(:, 1), matrix(:, 2))
      x = matmul(inverse, right)/dot_product(inverse(1, :), matrix(:, 1))
   end function solved

end module contensou_contact_tangential_carry
