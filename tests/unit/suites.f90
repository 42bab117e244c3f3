!> All suites of unit tests.
module test_suites
   use test_bearing, only : run_bearing_tests
   use test_comparison, only : run_comparison_tests
   use test_contact, only : run_contact_tests
   use test_creep, only : run_creep_tests
   use test_document, only : run_document_tests
   use test_dynamics, only : run_dynamics_tests
   use test_elliptic, only : run_elliptic_tests
   use test_explicit, only : run_explicit_tests
   use test_geometry, only : run_geometry_tests
   use test_harness, only : check, finish, make_scratch_folder, remove_scratch_folder, set_up, wants
   use test_hdf5_file, only : run_hdf5_file_tests
   use test_hertz, only : run_hertz_tests
   use test_integrate, only : run_integrate_tests
   use test_jacobian, only : run_jacobian_tests
   use test_jacobian_scenes, only : run_jacobian_scenes_tests
   use test_rigid, only : run_rigid_tests
   use test_rolling, only : run_rolling_tests
   use test_schema, only : run_schema_tests
   use test_simulation, only : run_simulation_tests
   use test_springs, only : run_spring_tests
   use test_states, only : run_states_tests
   use test_sweep, only : run_sweep_tests
   use test_tangential, only : run_tangential_tests
   use test_transient, only : run_transient_tests
   use test_wrench, only : run_wrench_tests
   use test_wrench_ellipse, only : run_wrench_ellipse_tests
   implicit none(type, external)
   private

   public :: run_suites

contains

   !> Run the suites that are asked for.
   subroutine run_suites(passed)
      !> Whether something was checked and nothing failed.
      logical, intent(out) :: passed
      character(len=:), allocatable :: folder

      call set_up()
      call make_scratch_folder(folder)
      if (wants("document")) call run_document_tests(check, folder)
      if (wants("elliptic")) call run_elliptic_tests()
      if (wants("hertz")) call run_hertz_tests()
      if (wants("wrench")) call run_wrench_tests()
      if (wants("wrench_ellipse")) call run_wrench_ellipse_tests()
      if (wants("tangential")) call run_tangential_tests()
      if (wants("creep")) call run_creep_tests()
      if (wants("transient")) call run_transient_tests()
      if (wants("contact")) call run_contact_tests()
      if (wants("geometry")) call run_geometry_tests()
      if (wants("rolling")) call run_rolling_tests()
      if (wants("dynamics")) call run_dynamics_tests()
      if (wants("bearing")) call run_bearing_tests()
      if (wants("springs")) call run_spring_tests()
      if (wants("integrate")) call run_integrate_tests()
      if (wants("jacobian")) call run_jacobian_tests()
      if (wants("jacobian_scenes")) call run_jacobian_scenes_tests(folder)
      if (wants("explicit")) call run_explicit_tests()
      if (wants("rigid")) call run_rigid_tests()
      if (wants("states")) call run_states_tests(folder)
      if (wants("schema")) call run_schema_tests()
      if (wants("hdf5_file")) call run_hdf5_file_tests(check, folder)
      if (wants("comparison")) call run_comparison_tests(folder)
      if (wants("simulation")) call run_simulation_tests(folder)
      if (wants("sweep")) call run_sweep_tests(folder)
      call remove_scratch_folder(folder)
      call finish(passed)
   end subroutine run_suites

end module test_suites
