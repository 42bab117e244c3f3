!> What every file says of itself: what it is and what it was made with.
module contensou_files_provenance
   use contensou_base_build, only : build_compiler, build_flags, git_commit, program_version
   use contensou_base_errors, only : error_type
   use contensou_base_operating_system, only : host_name, utc_now
   use contensou_integrate_cvode, only : sundials_version
   use contensou_files_hdf5_file, only : hdf5_file_type, hdf5_version
   use contensou_special_gsl, only : gsl_version
   implicit none(type, external)
   private

   public :: put_header, put_input, put_provenance

contains

   !> Write the attributes of the root that every file has.
   subroutine put_header(file, filetype, version, status, error, title)
      type(hdf5_file_type), intent(inout) :: file
      !> What the file is, for programs that open it.
      character(len=*), intent(in) :: filetype
      !> Version of its format.
      character(len=*), intent(in) :: version
      !> How far its content is.
      character(len=*), intent(in) :: status
      type(error_type), allocatable, intent(out) :: error
      !> Title of the scene.
      character(len=*), intent(in), optional :: title

      call file%put_attribute("/", "filetype", filetype, error)
      call file%put_attribute("/", "filetype_version", version, error)
      call file%put_attribute("/", "program_version", program_version, error)
      call file%put_attribute("/", "git_commit", git_commit(), error)
      call file%put_attribute("/", "created", utc_now(), error)
      call file%put_attribute("/", "status", status, error)
      if (present(title)) call file%put_attribute("/", "title", title, error)
      call file%put_attribute("/", "Conventions", "CF-1.8", error)
   end subroutine put_header

   !> Write what a run was made from, and what it was made with.
   subroutine put_input(file, namelist, resolved, command_line, error)
      type(hdf5_file_type), intent(inout) :: file
      !> Text of the scene file.
      character(len=*), intent(in) :: namelist
      !> The scene with all settings.
      character(len=*), intent(in) :: resolved
      character(len=*), intent(in) :: command_line
      type(error_type), allocatable, intent(out) :: error

      call file%create_group("/input", error)
      call file%put_text("/input/namelist", namelist, "text of the scene file", error)
      call file%put_text("/input/resolved", resolved, "all settings with defaults", error)
      call file%put_text("/input/command_line", command_line, "command line", error)
      call put_provenance(file, error)
   end subroutine put_input

   !> Write the group `/provenance`.
   subroutine put_provenance(file, error)
      type(hdf5_file_type), intent(inout) :: file
      type(error_type), allocatable, intent(out) :: error

      call file%create_group("/provenance", error)
      call file%put_text("/provenance/compiler", build_compiler, "compiler", error)
      call file%put_text("/provenance/flags", build_flags, "compiler flags", error)
      call file%put_text("/provenance/hdf5", hdf5_version(), "version of HDF5", error)
      call file%put_text("/provenance/sundials", sundials_version(), "version of SUNDIALS", error)
      call file%put_text("/provenance/gsl", gsl_version(), "version of GSL", error)
      call file%put_text("/provenance/host", host_name(), "host", error)
   end subroutine put_provenance

end module contensou_files_provenance
