!> Unit tests: `unit_tests [-v] [PART OF THE NAME OF A SUITE]`, in the root of the project.
program unit_tests
   use test_suites, only : run_suites
   implicit none(type, external)
   logical :: passed

   call run_suites(passed)
   if (.not. passed) stop 1, quiet=.true.
end program unit_tests
