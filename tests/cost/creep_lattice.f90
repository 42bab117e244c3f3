!> Wrenches of steady rolling along an axis of the spot on one lattice, not extrapolated: what a
!> program without extrapolation makes of the exact theory, for tests/driver/test_creep_exact.py.
!>
!> Reads the elements across, then lines of a/b with a along the rolling direction, Poisson's ratio,
!> and the creepages in e0 (spin times sqrt(a b)); writes the forces in f N and the torque in
!> f N sqrt(a b), NaN where no tractions are found.
program creep_lattice
   use, intrinsic :: ieee_arithmetic, only : ieee_quiet_nan, ieee_value
   use, intrinsic :: iso_fortran_env, only : input_unit, output_unit
   use contensou_base_kinds, only : wp
   use contensou_contact_creep_half_space, only : influence_type, lattice_type, resultant, &
      rolling_influence, solve_tractions, spot_lattice
   implicit none(type, external)
   real(wp), parameter :: tolerance = 1.0e-7_wp
   type(lattice_type) :: lattice
   type(influence_type) :: influence
   real(wp), allocatable :: px(:, :), py(:, :)
   real(wp) :: ratio, poisson, creepage(3), wrench(3), residual
   integer :: n, status

   read(input_unit, *) n
   allocate(px(n, n), py(n, n))
   do
      read(input_unit, *, iostat=status) ratio, poisson, creepage
      if (status /= 0) exit
      lattice = spot_lattice(n, sqrt(ratio), 0.0_wp)
      influence = rolling_influence(lattice, poisson)
      px = 0.0_wp
      py = 0.0_wp
      call solve_tractions(lattice, influence, creepage(1) - creepage(3)*lattice%y, &
         creepage(2) + creepage(3)*lattice%x, .true., tolerance, px, py, residual)
      wrench = resultant(lattice, px, py)
      if (.not. residual <= tolerance) wrench = ieee_value(wrench, ieee_quiet_nan)
      write(output_unit, "(3es24.15)") wrench
   end do
end program creep_lattice
