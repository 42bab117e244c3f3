!> What a file was made with.
module contensou_files_provenance
   use contensou_base_build, only : build_compiler, build_flags
   use contensou_base_errors, only : error_type
   use contensou_base_operating_system, only : host_name
   use contensou_integrate_cvode, only : sundials_version
   use contensou_files_hdf5_file, only : hdf5_file_type, hdf5_version
   use contensou_special_gsl, only : gsl_version
   implicit none(type, external)
   private

   public :: put_provenance

contains

   !> Write the group `/provenance`.
   subroutine put_provenance(file, error)
      type(hdf5_file_type), intent(inout) :: file
      !> Set on failure.
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
