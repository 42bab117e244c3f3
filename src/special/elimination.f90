!> Systems of linear equations with full matrices, and which rows of a matrix are independent.
module contensou_special_elimination
   use contensou_base_kinds, only : wp
   implicit none(type, external)
   private

   public :: solve_linear, independent_rows, factorize, solve_factorized, solve_with_gaps
   public :: factorize_with_pivots, solve_with_pivots

   !> Square of the distance of a row of a unit length from those before it, below which it counts
   !> as dependent on them.
   real(wp), parameter :: dependent = 1.0e-9_wp

contains

   !> Solve a small system of linear equations by elimination with row pivots.
   pure subroutine solve_linear(n, matrix, right, singular, least)
      !> Number of unknowns.
      integer, intent(in) :: n
      !> The matrix; overwritten.
      real(wp), intent(inout) :: matrix(:, :)
      !> Right-hand side; the solution on return.
      real(wp), intent(inout) :: right(:)
      !> Whether the matrix is singular to rounding.
      logical, intent(out) :: singular
      !> Least pivot over the largest element, if larger than that.
      real(wp), intent(in), optional :: least
      real(wp) :: factor, held, smallest
      integer :: i, j, k, pivot

      if (n == 1) then
         ! By far the most frequent case.
         smallest = abs(matrix(1, 1))
         singular = .not. smallest > 64.0_wp*epsilon(smallest)*smallest
         if (.not. singular) right(1) = right(1)/matrix(1, 1)
         return
      end if
      if (n == 2 .and. .not. present(least)) then
         call solve_two(matrix, right, singular)
         return
      end if
      singular = .false.
      smallest = 64.0_wp*epsilon(smallest)*n*maxval(abs(matrix(:n, :n)))
      if (present(least)) smallest = max(smallest, least*maxval(abs(matrix(:n, :n))))
      do k = 1, n
         pivot = k - 1 + maxloc(abs(matrix(k:n, k)), dim=1)
         if (.not. abs(matrix(pivot, k)) > smallest) then
            singular = .true.
            return
         end if
         if (pivot /= k) then
            do j = k, n
               held = matrix(k, j)
               matrix(k, j) = matrix(pivot, j)
               matrix(pivot, j) = held
            end do
            held = right(k)
            right(k) = right(pivot)
            right(pivot) = held
         end if
         do i = k + 1, n
            factor = matrix(i, k)/matrix(k, k)
            do j = k + 1, n
               matrix(i, j) = matrix(i, j) - factor*matrix(k, j)
            end do
            right(i) = right(i) - factor*right(k)
         end do
      end do
      do k = n, 1, -1
         do j = k + 1, n
            right(k) = right(k) - matrix(k, j)*right(j)
         end do
         right(k) = right(k)/matrix(k, k)
      end do
   end subroutine solve_linear

   !> The same for two unknowns, step by step what it does for more.
   pure subroutine solve_two(matrix, right, singular)
      real(wp), intent(in) :: matrix(:, :)
      !> Right-hand side; the solution on return.
      real(wp), intent(inout) :: right(:)
      !> Whether the matrix is singular to rounding.
      logical, intent(out) :: singular
      real(wp) :: factor, smallest, corner, first
      integer :: p, q

      p = merge(2, 1, abs(matrix(2, 1)) > abs(matrix(1, 1)))
      q = 3 - p
      smallest = 128.0_wp*epsilon(smallest)*max(abs(matrix(p, 1)), abs(matrix(1, 2)), &
         abs(matrix(2, 2)))
      singular = .not. abs(matrix(p, 1)) > smallest
      if (singular) return
      factor = matrix(q, 1)/matrix(p, 1)
      corner = matrix(q, 2) - factor*matrix(p, 2)
      singular = .not. abs(corner) > smallest
      if (singular) return
      first = right(p)
      right(2) = (right(q) - factor*first)/corner
      right(1) = (first - matrix(p, 2)*right(2))/matrix(p, 1)
   end subroutine solve_two

   !> Rows of a symmetric positive semidefinite matrix with a unit diagonal that are independent, by
   !> Cholesky's method with pivots: the columns of a factor that spans them.
   pure subroutine independent_rows(n, matrix, factor, rank)
      !> Number of rows.
      integer, intent(in) :: n
      real(wp), intent(in) :: matrix(:, :)
      !> The factor, n rows and as many columns as the rank.
      real(wp), intent(inout) :: factor(:, :)
      !> Number of independent rows.
      integer, intent(out) :: rank
      real(wp) :: left, most
      integer :: i, j, pivot

      rank = 0
      do
         pivot = 0
         most = dependent
         do i = 1, n
            left = matrix(i, i)
            do j = 1, rank
               left = left - factor(i, j)**2
            end do
            if (left <= most) cycle
            pivot = i
            most = left
         end do
         if (pivot == 0 .or. rank == n) return
         do i = 1, n
            left = matrix(i, pivot)
            do j = 1, rank
               left = left - factor(i, j)*factor(pivot, j)
            end do
            factor(i, rank + 1) = left/sqrt(most)
         end do
         rank = rank + 1
      end do
   end subroutine independent_rows

   !> Factorize a symmetric positive definite matrix after Cholesky.
   pure subroutine factorize(n, matrix, least, definite)
      !> Number of rows.
      integer, intent(in) :: n
      !> The matrix, of which the lower triangle counts; the factor on return.
      real(wp), intent(inout) :: matrix(:, :)
      !> Least pivot of each row.
      real(wp), intent(in) :: least(:)
      !> Whether all pivots are larger.
      logical, intent(out) :: definite
      integer :: i, j

      definite = .true.
      do j = 1, n
         definite = matrix(j, j) > least(j)
         if (.not. definite) return
         matrix(j, j) = sqrt(matrix(j, j))
         matrix(j + 1:n, j) = matrix(j + 1:n, j)/matrix(j, j)
         do i = j + 1, n
            if (abs(matrix(i, j)) > 0.0_wp) matrix(i:n, i) = matrix(i:n, i) &
               - matrix(i, j)*matrix(i:n, j)
         end do
      end do
   end subroutine factorize

   !> Solve with the factor of `factorize`.
   pure subroutine solve_factorized(n, factor, right)
      !> Number of unknowns.
      integer, intent(in) :: n
      real(wp), intent(in) :: factor(:, :)
      !> Right-hand side; the solution on return.
      real(wp), intent(inout) :: right(:)
      integer :: i

      do i = 1, n
         right(i) = right(i)/factor(i, i)
         right(i + 1:n) = right(i + 1:n) - right(i)*factor(i + 1:n, i)
      end do
      do i = n, 1, -1
         right(i) = (right(i) - dot_product(factor(i + 1:n, i), right(i + 1:n)))/factor(i, i)
      end do
   end subroutine solve_factorized

   !> Factorize a full matrix by elimination with row pivots.
   pure subroutine factorize_with_pivots(n, matrix, pivots, handed)
      !> Number of rows.
      integer, intent(in) :: n
      !> The matrix; both factors on return.
      real(wp), intent(inout) :: matrix(:, :)
      !> The row that each was exchanged with.
      integer, intent(out) :: pivots(:)
      !> Sign of the determinant; zero if a pivot is.
      integer, intent(out) :: handed
      real(wp) :: held
      integer :: j, k

      handed = 1
      do k = 1, n
         pivots(k) = k - 1 + maxloc(abs(matrix(k:n, k)), dim=1)
         if (.not. abs(matrix(pivots(k), k)) > 0.0_wp) then
            handed = 0
            return
         end if
         if (pivots(k) /= k) handed = -handed
         if (matrix(pivots(k), k) < 0.0_wp) handed = -handed
         do j = 1, n
            held = matrix(pivots(k), j)
            matrix(pivots(k), j) = matrix(k, j)
            matrix(k, j) = held
         end do
         matrix(k + 1:n, k) = matrix(k + 1:n, k)/matrix(k, k)
         do j = k + 1, n
            matrix(k + 1:n, j) = matrix(k + 1:n, j) - matrix(k, j)*matrix(k + 1:n, k)
         end do
      end do
   end subroutine factorize_with_pivots

   !> Solve with the factors of `factorize_with_pivots`.
   pure subroutine solve_with_pivots(n, factors, pivots, right)
      !> Number of unknowns.
      integer, intent(in) :: n
      real(wp), intent(in) :: factors(:, :)
      integer, intent(in) :: pivots(:)
      !> Right-hand side; the solution on return.
      real(wp), intent(inout) :: right(:)
      real(wp) :: held
      integer :: k

      do k = 1, n
         held = right(pivots(k))
         right(pivots(k)) = right(k)
         right(k) = held
      end do
      do k = 1, n
         right(k + 1:n) = right(k + 1:n) - right(k)*factors(k + 1:n, k)
      end do
      do k = n, 1, -1
         right(k) = right(k)/factors(k, k)
         right(:k - 1) = right(:k - 1) - right(k)*factors(:k - 1, k)
      end do
   end subroutine solve_with_pivots

   !> Solve a system for several right-hand sides by elimination along the diagonal; an unknown
   !> whose pivot is too small is zero.
   pure subroutine solve_with_gaps(n, matrix, right, least)
      !> Number of unknowns.
      integer, intent(in) :: n
      !> The matrix; overwritten.
      real(wp), intent(inout) :: matrix(:, :)
      !> Right-hand sides as columns; the solutions on return.
      real(wp), intent(inout) :: right(:, :)
      !> Least pivot of each unknown.
      real(wp), intent(in) :: least(:)
      logical :: left_out(n)
      integer :: i, j, k
      real(wp) :: factor

      do k = 1, n
         left_out(k) = .not. abs(matrix(k, k)) > least(k)
         if (left_out(k)) cycle
         do i = k + 1, n
            if (.not. abs(matrix(i, k)) > 0.0_wp) cycle
            factor = matrix(i, k)/matrix(k, k)
            do j = k + 1, n
               matrix(i, j) = matrix(i, j) - factor*matrix(k, j)
            end do
            right(i, :) = right(i, :) - factor*right(k, :)
         end do
      end do
      do k = n, 1, -1
         if (left_out(k)) then
            right(k, :) = 0.0_wp
            cycle
         end if
         do j = k + 1, n
            right(k, :) = right(k, :) - matrix(k, j)*right(j, :)
         end do
         right(k, :) = right(k, :)/matrix(k, k)
      end do
   end subroutine solve_with_gaps

end module contensou_special_elimination
