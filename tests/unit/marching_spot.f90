!> A spot that is followed through time by boundary elements: the exact theory of what the transient
!> law of rolling approximates.
!>
!> Units are those of `contensou_contact_creep_half_space`: lengths in sqrt(a b), shifts in
!> sqrt(a b) e0, forces in f N. A step is over one element, in rolling or at rest.
module marching_spot
   use contensou_base_kinds, only : wp
   use contensou_contact_creep_half_space, only : contact_influence, displace, influence_type, &
      lattice_type, resultant, spot_lattice
   implicit none(type, external)
   private

   public :: march_type

   !> Error of tractions.
   real(wp), parameter :: tolerance = 1.0e-7_wp

   !> Error of a force that is to be borne.
   real(wp), parameter :: force_tolerance = 1.0e-5_wp

   !> The spot.
   type :: march_type
      type(lattice_type) :: lattice
      !> Influence of tractions where they are, and of those that have moved by one element.
      type(influence_type) :: still, moved
      real(wp), allocatable :: px(:, :), py(:, :)
      !> Inverse of the derivative of the force by the shift, about.
      real(wp) :: inverse(2, 2) = 0.0_wp
   contains
      procedure :: begin
      procedure :: shift
      procedure :: bear
      procedure :: torque
   end type march_type

contains

   !> Begin without tractions.
   subroutine begin(self, n, ratio, poisson)
      class(march_type), intent(inout) :: self
      !> Elements across.
      integer, intent(in) :: n
      !> a/b, a along the rolling direction.
      real(wp), intent(in) :: ratio
      real(wp), intent(in) :: poisson

      self%lattice = spot_lattice(n, sqrt(ratio), 0.0_wp)
      self%still = contact_influence(self%lattice, poisson, 0.0_wp)
      self%moved = contact_influence(self%lattice, poisson, 1.0_wp)
      if (allocated(self%px)) deallocate(self%px, self%py)
      allocate(self%px(n, n), self%py(n, n), source=0.0_wp)
      self%inverse = reshape([-1.0_wp, 0.0_wp, 0.0_wp, -1.0_wp], [2, 2])
   end subroutine begin

   !> Shift and twist the bodies. The influence is symmetric: the tractions are those for which a
   !> convex function is least, found element by element.
   subroutine shift(self, by, rolls, wrench, first_x, first_y)
      class(march_type), intent(inout) :: self
      !> Shift along and across the rolling direction, and twist.
      real(wp), intent(in) :: by(3)
      !> Whether the spot rolls by one element in the meantime.
      logical, intent(in) :: rolls
      real(wp), intent(out) :: wrench(3)
      !> Tractions before the step, if they are not those that it has; the guess is those.
      real(wp), intent(in), optional :: first_x(:, :), first_y(:, :)
      integer, parameter :: most_sweeps = 20000
      real(wp), dimension(self%lattice%n, self%lattice%n) :: sx, sy, before_x, before_y
      real(wp) :: x, y, own, largest, bound
      integer :: i, j, k, l, sweep

      before_x = self%px
      before_y = self%py
      if (present(first_x)) before_x = first_x
      if (present(first_y)) before_y = first_y
      associate (lattice => self%lattice, n => self%lattice%n, still => self%still)
         if (rolls) then
            call displace(lattice, self%moved, before_x, before_y, sx, sy)
         else
            call displace(lattice, still, before_x, before_y, sx, sy)
         end if
         before_x = sx
         before_y = sy
         call displace(lattice, still, self%px, self%py, sx, sy)
         sx = sx + by(1) - by(3)*lattice%y - before_x
         sy = sy + by(2) + by(3)*lattice%x - before_y
         own = max(still%xx(0, 0), still%yy(0, 0))
         do sweep = 1, most_sweeps
            largest = 0.0_wp
            do j = 1, n
               do i = lattice%first(j), lattice%last(j)
                  x = self%px(i, j) - sx(i, j)/own
                  y = self%py(i, j) - sy(i, j)/own
                  bound = lattice%bound(i, j)/max(hypot(x, y), lattice%bound(i, j))
                  x = bound*x - self%px(i, j)
                  y = bound*y - self%py(i, j)
                  if (.not. abs(x) + abs(y) > 0.0_wp) cycle
                  largest = max(largest, abs(x), abs(y))
                  self%px(i, j) = self%px(i, j) + x
                  self%py(i, j) = self%py(i, j) + y
                  do l = 1, n
                     do k = lattice%first(l), lattice%last(l)
                        sx(k, l) = sx(k, l) + still%xx(k - i, l - j)*x + still%xy(k - i, l - j)*y
                        sy(k, l) = sy(k, l) + still%xy(k - i, l - j)*x + still%yy(k - i, l - j)*y
                     end do
                  end do
               end do
            end do
            if (largest < tolerance) exit
         end do
         wrench = resultant(lattice, self%px, self%py)
      end associate
   end subroutine shift

   !> Shift the bodies until they bear a force, by Broyden's method.
   subroutine bear(self, force, rolls, by)
      class(march_type), intent(inout) :: self
      !> Force along and across the rolling direction.
      real(wp), intent(in) :: force(2)
      !> Whether the spot rolls by one element in the meantime.
      logical, intent(in) :: rolls
      !> A guess, then the shift; the twist is given.
      real(wp), intent(inout) :: by(3)
      integer, parameter :: most_steps = 60
      real(wp), dimension(self%lattice%n, self%lattice%n) :: first_x, first_y
      real(wp) :: wrench(3), miss(2), more(2), change(2), product(2)
      integer :: step

      first_x = self%px
      first_y = self%py
      call self%shift(by, rolls, wrench, first_x, first_y)
      miss = wrench(1:2) - force
      do step = 1, most_steps
         if (maxval(abs(miss)) < force_tolerance) exit
         more = -matmul(self%inverse, miss)
         by(1:2) = by(1:2) + more
         change = -miss
         call self%shift(by, rolls, wrench, first_x, first_y)
         miss = wrench(1:2) - force
         change = change + miss
         product = matmul(self%inverse, change)
         self%inverse = self%inverse + spread((more - product)/dot_product(more, product), 2, 2) &
            *spread(matmul(more, self%inverse), 1, 2)
      end do
   end subroutine bear

   !> Torque about the normal.
   pure real(wp) function torque(self)
      class(march_type), intent(in) :: self
      real(wp) :: wrench(3)

      wrench = resultant(self%lattice, self%px, self%py)
      torque = wrench(3)
   end function torque

end module marching_spot
