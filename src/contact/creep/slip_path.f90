!> Tractions of a spot that rolls, by following a path of solutions from full sliding: slow, but it
!> comes to the end.
!>
!> The tractions p of n elements, x components first, solve
!>    p = P(p - rho s),  s = m w + B p,  P(q) = q within the bound g, else g q/|q|,
!> w being the slip of rigid bodies and m a share of it. For every m there is a solution (Hartman
!> and Stampacchia: P maps on discs), and where m is so large that everything slides there is one
!> only. With m, solutions form curves, which end nowhere, as tractions are bounded; so the one that
!> begins in full sliding comes to every m > 0. It may turn back on its way, where solutions that
!> are followed along m end. So its length is the parameter: a smooth piece as long as no element
!> begins to slip or to stick, beyond which the equations of the new piece hold. The sign of their
!> determinant, completed by the direction of the path, stays the same and says which way is on
!> (E. Allgower and K. Georg, Numerical Continuation Methods, 1990).
module contensou_contact_creep_slip_path
   use contensou_base_kinds, only : wp
   use contensou_special_elimination, only : factorize_with_pivots, solve_with_pivots
   implicit none(type, external)
   private

   public :: follow_path

   !> Most steps along the path, and most corrections of one.
   integer, parameter :: most_steps = 20000, most_corrections = 12

   !> Corrections of a step after which the next one may be longer.
   integer, parameter :: quick_corrections = 4

   !> The first and the longest step; tractions and ln m are the coordinates.
   real(wp), parameter :: first_step = 1.0_wp, longest_step = 4.0_wp

   !> Step that is too short to go on.
   real(wp), parameter :: least_step = 1.0e-13_wp

   !> Part of its bound by which an element may pass the point where it begins to slip or to stick,
   !> and by which steps are to pass it.
   real(wp), parameter :: most_passed = 1.0e-6_wp, passed = 0.1_wp*most_passed

   !> Error of ln m at the end.
   real(wp), parameter :: end_error = 1.0e-12_wp

   !> Cosine of the angle to the direction before, below which the new one completes the equations
   !> in its place.
   real(wp), parameter :: least_cosine = 0.3_wp

   !> The problem.
   type :: problem_type
      !> Number of elements.
      integer :: n
      !> B, rho w and g.
      real(wp), allocatable :: influence(:, :), rigid(:), bound(:)
      real(wp) :: rho
   end type problem_type

   !> A point of the path, or near it.
   type :: point_type
      !> Error of the equations.
      real(wp), allocatable :: f(:)
      !> Direction of p - rho s, g over its size, and by how much of g it is longer.
      real(wp), allocatable :: ex(:), ey(:), part(:), excess(:)
   end type point_type

contains

   !> Follow the path.
   pure subroutine follow_path(influence, rigid, bound, rho, tolerance, share, p, found)
      !> B, twice the elements each way.
      real(wp), intent(in) :: influence(:, :)
      !> w.
      real(wp), intent(in) :: rigid(:)
      !> g, of every element.
      real(wp), intent(in) :: bound(:)
      real(wp), intent(in) :: rho
      !> Error of the tractions on the way.
      real(wp), intent(in) :: tolerance
      !> The share m, > 1, where the path begins.
      real(wp), intent(in) :: share
      !> Tractions there; then those of m = 1.
      real(wp), intent(inout) :: p(:)
      !> Whether the path came to m = 1.
      logical, intent(out) :: found
      type(problem_type) :: problem
      type(point_type) :: here, there
      real(wp), allocatable :: matrix(:, :)
      real(wp), dimension(size(p) + 1) :: x, y, tangent, row
      real(wp), dimension(size(bound)) :: gap, gap_there, rate
      real(wp) :: h, longest
      integer :: pivots(size(p) + 1), orientation, handed, step, corrections, i, m
      logical :: slips(size(bound)), at_change, at_end

      found = .false.
      problem = problem_type(size(bound), influence, rho*rigid, bound, rho)
      m = size(x)
      allocate(matrix(m, m))
      x = [p, log(share)]
      slips = .false.
      call evaluate(problem, slips, x, here)
      slips = here%excess > 0.0_wp
      row = 0.0_wp
      row(m) = -1.0_wp
      orientation = 0
      longest = first_step
      do step = 1, most_steps
         call evaluate(problem, slips, x, here)
         call differentiate(problem, slips, x, here, row, matrix)
         call factorize_with_pivots(m, matrix, pivots, handed)
         if (handed == 0) return
         if (orientation == 0) orientation = handed
         tangent = 0.0_wp
         tangent(m) = 1.0_wp
         call solve_with_pivots(m, matrix, pivots, tangent)
         tangent = tangent*(real(orientation*handed, wp)/norm2(tangent))
         if (abs(dot_product(row, tangent)) < least_cosine) then
            row = tangent
            call differentiate(problem, slips, x, here, row, matrix)
            call factorize_with_pivots(m, matrix, pivots, handed)
            if (handed == 0) return
         end if

         ! To where the first element changes, if that is near.
         gap = merge(here%excess, -here%excess, slips)
         rate = excess_rate(problem, x, here, tangent)
         rate = merge(rate, -rate, slips)
         h = longest
         do i = 1, problem%n
            if (h*rate(i) < -(max(gap(i), 0.0_wp) + passed)) then
               h = (max(gap(i), 0.0_wp) + passed)/(-rate(i))
            end if
         end do
         at_change = h < longest
         do
            y = x + h*tangent
            call correct(problem, slips, matrix, pivots, row, x, h*dot_product(row, tangent), &
               tolerance, y, there, corrections)
            at_end = .false.
            if (corrections > most_corrections) then
               h = 0.5_wp*h
               longest = h
            else
               gap_there = merge(there%excess, -there%excess, slips)
               i = minloc(gap_there, dim=1)
               at_end = y(m) < end_error
               if (gap_there(i) < -most_passed) then
                  h = h*min(max((max(gap(i), 0.0_wp) + passed)/(max(gap(i), 0.0_wp) &
                     - gap_there(i)), 0.05_wp), 0.9_wp)
                  at_change = .true.
               else if (y(m) < -end_error) then
                  h = h*min(max(x(m)/(x(m) - y(m)), 0.05_wp), 1.0_wp)
               else
                  exit
               end if
            end if
            if (h < least_step) return
         end do
         x = y
         if (at_end) then
            p = x(:m - 1)
            found = .true.
            return
         end if
         slips = slips .neqv. gap_there < 0.0_wp
         row = tangent
         if (at_change) then
            longest = max(longest, h)
         else if (corrections <= quick_corrections) then
            longest = min(1.6_wp*longest, longest_step)
         end if
      end do
   end subroutine follow_path

   !> Correct a point with the factors from where the step began.
   pure subroutine correct(problem, slips, factors, pivots, row, x, advance, tolerance, y, there, &
      corrections)
      type(problem_type), intent(in) :: problem
      !> Elements that slip.
      logical, intent(in) :: slips(:)
      real(wp), intent(in) :: factors(:, :)
      integer, intent(in) :: pivots(:)
      !> Last row of the equations.
      real(wp), intent(in) :: row(:)
      !> Where the step began.
      real(wp), intent(in) :: x(:)
      !> What the last equation is to have.
      real(wp), intent(in) :: advance
      real(wp), intent(in) :: tolerance
      !> The point: a guess, then corrected.
      real(wp), intent(inout) :: y(:)
      !> What there is.
      type(point_type), intent(inout) :: there
      !> Number of corrections; more than the most if they do not converge.
      integer, intent(out) :: corrections
      real(wp) :: error(size(y)), size_now, size_before
      integer :: m

      m = size(y)
      size_before = huge(size_before)
      do corrections = 0, most_corrections
         call evaluate(problem, slips, y, there)
         error = [there%f, dot_product(row, y - x) - advance]
         size_now = maxval(abs(error))
         if (size_now <= tolerance) return
         if (.not. size_now < 0.7_wp*size_before .and. corrections > 3) exit
         size_before = size_now
         call solve_with_pivots(m, factors, pivots, error)
         y = y - error
      end do
      corrections = most_corrections + 1
   end subroutine correct

   !> The equations at a point.
   pure subroutine evaluate(problem, slips, x, point)
      type(problem_type), intent(in) :: problem
      !> Elements that slip.
      logical, intent(in) :: slips(:)
      !> Tractions and ln m.
      real(wp), intent(in) :: x(:)
      type(point_type), intent(inout) :: point
      real(wp) :: slip(2*problem%n), qx, qy, q
      integer :: i, j

      if (.not. allocated(point%f)) then
         allocate(point%f(2*problem%n), point%ex(problem%n), point%ey(problem%n), &
            point%part(problem%n), point%excess(problem%n))
      end if
      slip = rho_slip(problem, x(:2*problem%n), exp(x(2*problem%n + 1)))
      do i = 1, problem%n
         j = i + problem%n
         qx = x(i) - slip(i)
         qy = x(j) - slip(j)
         q = max(hypot(qx, qy), tiny(q))
         point%ex(i) = qx/q
         point%ey(i) = qy/q
         point%part(i) = problem%bound(i)/q
         point%excess(i) = q/problem%bound(i) - 1.0_wp
         if (slips(i)) then
            point%f(i) = x(i) - problem%bound(i)*point%ex(i)
            point%f(j) = x(j) - problem%bound(i)*point%ey(i)
         else
            point%f(i) = slip(i)
            point%f(j) = slip(j)
         end if
      end do
   end subroutine evaluate

   !> rho s of tractions, or its change.
   pure function rho_slip(problem, p, share) result(slip)
      type(problem_type), intent(in) :: problem
      real(wp), intent(in) :: p(:)
      !> Of the slip of rigid bodies.
      real(wp), intent(in) :: share
      real(wp) :: slip(size(p))
      integer :: i

      slip = share*problem%rigid
      do i = 1, size(p)
         slip = slip + (problem%rho*p(i))*problem%influence(:, i)
      end do
   end function rho_slip

   !> Change of the excess along a direction.
   pure function excess_rate(problem, x, point, tangent) result(rate)
      type(problem_type), intent(in) :: problem
      real(wp), intent(in) :: x(:)
      !> What there is at x.
      type(point_type), intent(in) :: point
      real(wp), intent(in) :: tangent(:)
      real(wp) :: rate(problem%n), change(2*problem%n)
      integer :: n

      n = problem%n
      change = tangent(:2*n) - rho_slip(problem, tangent(:2*n), exp(x(2*n + 1))*tangent(2*n + 1))
      rate = (point%ex*change(:n) + point%ey*change(n + 1:))/problem%bound
   end function excess_rate

   !> Derivatives of the equations by tractions and ln m, and a last row: with the derivatives D of
   !> P they are 1 - D (1 - rho B), and D rho m w. Where an element sticks D is one.
   pure subroutine differentiate(problem, slips, x, point, row, matrix)
      type(problem_type), intent(in) :: problem
      !> Elements that slip.
      logical, intent(in) :: slips(:)
      real(wp), intent(in) :: x(:)
      !> What there is at x.
      type(point_type), intent(in) :: point
      real(wp), intent(in) :: row(:)
      real(wp), intent(out) :: matrix(:, :)
      real(wp) :: first, second, turn, share
      integer :: i, j, k, n

      n = problem%n
      share = exp(x(2*n + 1))
      do k = 1, 2*n + 1
         do i = 1, n
            j = i + n
            if (k <= 2*n) then
               first = problem%rho*problem%influence(i, k)
               second = problem%rho*problem%influence(j, k)
            else
               first = share*problem%rigid(i)
               second = share*problem%rigid(j)
            end if
            if (slips(i)) then
               if (k == i) first = first - 1.0_wp
               if (k == j) second = second - 1.0_wp
               turn = point%part(i)*(point%ex(i)*second - point%ey(i)*first)
               first = -point%ey(i)*turn
               second = point%ex(i)*turn
               if (k == i) first = first + 1.0_wp
               if (k == j) second = second + 1.0_wp
            end if
            matrix(i, k) = first
            matrix(j, k) = second
         end do
         matrix(2*n + 1, k) = row(k)
      end do
   end subroutine differentiate

end module contensou_contact_creep_slip_path
