!> Linear complementarity problems: w = M z + q with w >= 0, z >= 0 and w.z = 0.
!>
!> C. E. Lemke, Management Sci. 11 (1965) 681: a basic solution is followed from pivot to pivot
!> until the artificial variable leaves. Ties are broken lexicographically, so that no basis comes
!> twice and the method ends (B. C. Eaves, Management Sci. 17 (1971) 612; R. W. Cottle, J.-S. Pang,
!> R. E. Stone, The Linear Complementarity Problem, 1992, section 4.4). With a positive definite M
!> it ends at the solution, with others there may be none or it may not be found.
module contensou_special_complementarity
   use contensou_base_kinds, only : wp
   implicit none(type, external)
   private

   public :: solve_complementarity

   !> Elements of a tableau below this are rounding, for problems with diagonals about 1.
   real(wp), parameter :: negligible = 1.0e-12_wp

contains

   !> Solve a problem by Lemke's method.
   pure subroutine solve_complementarity(matrix, q, z, solved)
      !> M, its diagonal about 1.
      real(wp), intent(in) :: matrix(:, :)
      real(wp), intent(in) :: q(:)
      real(wp), intent(out) :: z(:)
      !> Whether the method ended at a solution and not on a ray.
      logical, intent(out) :: solved
      real(wp) :: tableau(size(q), 0:2*size(q) + 1), largest
      integer :: basis(size(q)), n, i, k, entering, leaving, row

      n = size(q)
      z = 0.0_wp
      solved = all(q >= 0.0_wp)
      if (solved) return
      ! Column 0 is q, 1 to n are w, the next n are z, the last one is the artificial variable. The
      ! columns of w are the inverse of the basis, by whose rows ties are broken.
      tableau = 0.0_wp
      largest = maxval(abs(q))
      tableau(:, 0) = q/largest
      tableau(:, n + 1:2*n) = -matrix
      tableau(:, 2*n + 1) = -1.0_wp
      do i = 1, n
         tableau(i, i) = 1.0_wp
         basis(i) = i
      end do
      entering = 2*n + 1
      row = minloc(q, dim=1)
      do k = 1, 100*(n + 1)
         leaving = basis(row)
         basis(row) = entering
         call pivot(tableau, row, entering)
         solved = leaving == 2*n + 1
         if (solved) exit
         entering = merge(leaving + n, leaving - n, leaving <= n)
         row = blocking_row(tableau, entering, basis)
         if (row == 0) exit
      end do
      if (.not. solved) return
      do i = 1, n
         if (basis(i) > n) z(basis(i) - n) = max(tableau(i, 0), 0.0_wp)*largest
      end do
   end subroutine solve_complementarity

   !> Make a column that of a unit matrix.
   pure subroutine pivot(tableau, row, column)
      real(wp), intent(inout) :: tableau(:, 0:)
      integer, intent(in) :: row
      integer, intent(in) :: column
      integer :: i

      tableau(row, :) = tableau(row, :)/tableau(row, column)
      do i = 1, size(tableau, 1)
         if (i /= row) tableau(i, :) = tableau(i, :) - tableau(i, column)*tableau(row, :)
      end do
   end subroutine pivot

   !> Row whose variable becomes zero first as another one grows; 0 if none does.
   pure function blocking_row(tableau, entering, basis) result(row)
      real(wp), intent(in) :: tableau(:, 0:)
      !> Column of the variable that grows.
      integer, intent(in) :: entering
      !> Variable of each row.
      integer, intent(in) :: basis(:)
      integer :: row
      integer :: i

      row = 0
      do i = 1, size(basis)
         if (.not. tableau(i, entering) > negligible) cycle
         if (row == 0) then
            row = i
         else if (precedes(i)) then
            row = i
         end if
      end do

   contains

      !> Whether the variable of a row becomes zero before that of `row`.
      pure logical function precedes(i)
         integer, intent(in) :: i
         real(wp) :: difference
         integer :: j, artificial

         artificial = 2*size(basis) + 1
         do j = 0, size(basis)
            difference = tableau(i, j)/tableau(i, entering) &
               - tableau(row, j)/tableau(row, entering)
            precedes = difference < 0.0_wp
            if (abs(difference) > negligible) return
            ! The artificial variable leaves as soon as it can.
            if (basis(row) == artificial .or. basis(i) == artificial) then
               precedes = basis(i) == artificial
               return
            end if
         end do
      end function precedes

   end function blocking_row

end module contensou_special_complementarity
