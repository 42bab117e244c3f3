!> `contensou version`: the versions of the program, of what it is built with, and of its files.
module contensou_drivers_version
   use contensou_base_build, only : build_compiler, build_type, git_commit, program_version
   use contensou_base_checkpoint, only : checkpoint_heading
   use contensou_base_errors, only : error_type
   use contensou_base_operating_system, only : write_stdout
   use contensou_drivers_bench_report, only : bench_filetype => filetype, &
      bench_filetype_version => filetype_version
   use contensou_drivers_command_line, only : command_line_type, command_type, option_type
   use contensou_files_cost_table, only : cost_filetype, cost_filetype_version
   use contensou_files_hdf5_file, only : hdf5_version
   use contensou_files_trajectory, only : filetype, filetype_version
   use contensou_integrate_cvode, only : sundials_version
   use contensou_special_gsl, only : gsl_version
   use contensou_sweep_table, only : sweep_filetype, sweep_filetype_version
   implicit none(type, external)
   private

   public :: version_command

   character(len=*), parameter :: nl = new_line("a")

contains

   !> `contensou version` in the table of commands.
   function version_command() result(command)
      type(command_type) :: command

      command = command_type("version", "versions of the program, its libraries, its files", &
         [option_type ::], alias="--version", execute=print_version)
   end function version_command

   !> Version of the program and of what it is built with.
   subroutine print_version(line, error)
      type(command_line_type), intent(in) :: line
      !> Set when the standard output cannot be written.
      type(error_type), allocatable, intent(out) :: error

      call write_stdout("contensou " // program_version // nl // &
         "  commit     " // git_commit() // nl // &
         "  compiler   " // build_compiler // nl // &
         "  build      " // build_type // nl // &
         "  libraries  SUNDIALS " // sundials_version() // ", HDF5 " // hdf5_version() // &
         ", GSL " // gsl_version() // nl // &
         "  files      " // filetype // " " // filetype_version // ", " // &
         sweep_filetype // " " // sweep_filetype_version // ", " // &
         cost_filetype // " " // cost_filetype_version // ", " // &
         bench_filetype // " " // bench_filetype_version // ", " // checkpoint_heading // nl, error)
   end subroutine print_version

end module contensou_drivers_version
