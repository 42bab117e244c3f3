!> The rest position of a scene as an HDF5 file; docs/equilibrium.md describes it.
module contensou_files_equilibrium_file
   use contensou_base_errors, only : error_type
   use contensou_base_kinds, only : wp
   use contensou_base_text, only : pad, string_type
   use contensou_files_hdf5_file, only : hdf5_file_type
   use contensou_files_provenance, only : put_header, put_input
   use contensou_study_equilibrium, only : equilibrium_type
   implicit none(type, external)
   private

   public :: write_equilibrium

   !> What the file is, for programs that open it, and the version of its format.
   character(len=*), parameter :: filetype = "contensou-equilibrium", filetype_version = "1.0"

contains

   !> Write everything.
   subroutine write_equilibrium(found, namelist, resolved, command_line, name, file, error)
      type(equilibrium_type), intent(in) :: found
      !> Text of the scene file.
      character(len=*), intent(in) :: namelist
      character(len=*), intent(in) :: resolved
      character(len=*), intent(in) :: command_line
      character(len=*), intent(in) :: name
      !> The file, left open.
      type(hdf5_file_type), intent(inout) :: file
      type(error_type), allocatable, intent(out) :: error

      call file%create(name, error)
      if (allocated(error)) return
      call put_header(file, filetype, filetype_version, "complete", error, found%scene%title)
      call file%put_attribute("/", "NX_class", "NXroot", error)
      call put_input(file, namelist, resolved, command_line, error)
      call put_bodies(found, file, error)
      if (size(found%contacts) > 0) call put_contacts(found, file, error)
      if (size(found%rings) > 0) call put_rings(found, file, error)
      ! A failure is kept by the file, so that this last call sees the first one.
      call file%flush(error)
   end subroutine write_equilibrium

   !> Where the bodies are.
   subroutine put_bodies(found, file, error)
      type(equilibrium_type), intent(in) :: found
      type(hdf5_file_type), intent(inout) :: file
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: b = "/body/"
      character(len=*), parameter :: vector(2) = ["/body/name", "/body/xyz "], &
         quaternion(2) = ["/body/name", "/body/wxyz"]
      type(string_type) :: names(size(found%scene%bodies))
      character(len=:), allocatable :: padded(:)
      real(wp) :: position(3, size(names)), attitude(4, size(names))
      integer :: i

      do i = 1, size(names)
         names(i)%s = found%scene%bodies(i)%name
         position(:, i) = found%scene%bodies(i)%position
         attitude(:, i) = found%scene%bodies(i)%quaternion
      end do
      call pad(names, padded)
      call file%create_group("/body", error)
      call file%put_labels(b // "name", padded, "name of the body", error)
      call file%put_labels(b // "xyz", ["x", "y", "z"], "axis of the inertial frame", error)
      call file%put_labels(b // "wxyz", ["w", "x", "y", "z"], "component of a quaternion", error)
      call file%put_array(b // "position", position, vector, "m", "centre of mass at rest", error)
      call file%put_array(b // "quaternion", attitude, quaternion, "1", &
         "attitude at rest, body to inertial frame", error)
      call file%put_array(b // "displacement", found%shift, vector, "m", &
         "displacement from the position of the scene", error)
      call file%put_array(b // "rotation", found%turn, vector, "rad", &
         "rotation vector from the attitude of the scene, inertial frame", error)
   end subroutine put_bodies

   !> What the contacts carry.
   subroutine put_contacts(found, file, error)
      type(equilibrium_type), intent(in) :: found
      type(hdf5_file_type), intent(inout) :: file
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: c = "/contact/", scale(1) = ["/contact/name"]
      type(string_type) :: names(size(found%contacts))
      character(len=:), allocatable :: padded(:)
      real(wp) :: axes(2, size(names))
      integer :: i

      do i = 1, size(names)
         names(i)%s = found%scene%contacts(i)%name
         axes(:, i) = found%contacts(i)%semi_axes
      end do
      call pad(names, padded)
      call file%create_group("/contact", error)
      call file%put_labels(c // "name", padded, "name of the contact", error)
      call file%put_labels(c // "axis", ["major", "minor"], "axis of the spot", error)
      call file%put_array(c // "normal_force", found%contacts%force, scale, "N", "normal force", &
         error)
      call file%put_array(c // "approach", found%contacts%approach, scale, "m", &
         "overlap of the undeformed surfaces, negative for a gap", error)
      call file%put_array(c // "contact_angle", found%contacts%angle, scale, "rad", &
         "angle of the normal with the plane of a groove; NaN if open or without one", error)
      call file%put_array(c // "pressure", found%contacts%pressure, scale, "Pa", &
         "largest pressure in the spot", error)
      call file%put_array(c // "semi_axes", axes, ["/contact/name", "/contact/axis"], "m", &
         "semi-axes of the spot", error)
   end subroutine put_contacts

   subroutine put_rings(found, file, error)
      type(equilibrium_type), intent(in) :: found
      type(hdf5_file_type), intent(inout) :: file
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: r = "/ring/"
      type(string_type) :: names(size(found%rings))
      character(len=:), allocatable :: padded(:)
      real(wp) :: stiffness(5, 5, size(names)), frame(3, 3, size(names))
      integer :: i

      do i = 1, size(names)
         names(i)%s = found%scene%bodies(found%rings(i)%body)%name
         ! Rows first in the file.
         stiffness(:, :, i) = transpose(found%rings(i)%stiffness)
         frame(:, :, i) = found%rings(i)%frame
      end do
      call pad(names, padded)
      call file%create_group("/ring", error)
      call file%put_labels(r // "name", padded, "body that is a ring", error)
      call file%put_labels(r // "load", ["force_1 ", "force_2 ", "force_3 ", "moment_1", &
         "moment_2"], "load along and about the axes of the ring", error)
      call file%put_labels(r // "coordinate", ["shift_1", "shift_2", "shift_3", "tilt_1 ", &
         "tilt_2 "], "translation and tilt along and about the axes of the ring", error)
      call file%put_labels(r // "axis", ["1", "2", "3"], "axis of the ring; the last is its own", &
         error)
      call file%put_labels(r // "xyz", ["x", "y", "z"], "axis of the inertial frame", error)
      call file%put_array(r // "stiffness", stiffness, [character(len=16) :: r // "name", &
         r // "load", r // "coordinate"], "", "stiffness in N, m and rad, all else yielding", error)
      call file%put_array(r // "frame", frame, [character(len=16) :: r // "name", r // "axis", &
         r // "xyz"], "1", "axes of the ring, inertial frame", error)
   end subroutine put_rings

end module contensou_files_equilibrium_file
