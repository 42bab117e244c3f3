!> `contensou version`: the version of the program and of what it is built with.
module contensou_drivers_version
   use contensou_base_build, only : build_compiler, git_commit, program_version
   use contensou_base_errors, only : error_type
   use contensou_base_operating_system, only : write_stdout
   use contensou_drivers_command_line, only : command_line_type, command_type, option_type
   use contensou_files_hdf5_file, only : hdf5_version
   use contensou_integrate_cvode, only : sundials_version
   use contensou_special_gsl, only : gsl_version
   implicit none(type, external)
   private

   public :: version_command

   character(len=*), parameter :: nl = new_line("a")

contains

   !> `contensou version` in the table of commands.
   function version_command() result(command)
      type(command_type) :: command

      command = command_type("version", "version of the program", [option_type ::], &
         alias="--version", execute=print_version)
   end function version_command

   !> Version of the program and of what it is built with.
   subroutine print_version(line, error)
      type(command_line_type), intent(in) :: line
      !> Set when the standard output cannot be written.
      type(error_type), allocatable, intent(out) :: error

      call write_stdout("contensou " // program_version // nl // &
         "commit " // git_commit() // nl // build_compiler // &
         ", SUNDIALS " // sundials_version() // ", HDF5 " // hdf5_version() // &
         ", GSL " // gsl_version() // nl, error)
   end subroutine print_version

end module contensou_drivers_version
