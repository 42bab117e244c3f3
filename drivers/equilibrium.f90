!> `contensou equilibrium`: the rest position of a scene under its loads.
module contensou_drivers_equilibrium
   use, intrinsic :: ieee_arithmetic, only : ieee_is_nan
   use contensou_base_errors, only : error_type, fatal, status_usage
   use contensou_base_kinds, only : pi, wp
   use contensou_base_numbers, only : number_text, to_text
   use contensou_base_operating_system, only : remove_file, same_file, temporary_name, write_stdout
   use contensou_base_text, only : command_text, right, string_type, text_buffer_type
   use contensou_drivers_command_line, only : command_line_type, command_type, option_type, &
      set_option, strict_option
   use contensou_drivers_output, only : check_output, output_type
   use contensou_drivers_report, only : heed_warnings
   use contensou_files_equilibrium_file, only : write_equilibrium
   use contensou_files_hdf5_file, only : hdf5_file_type
   use contensou_scene_reader, only : moved_scene_text, read_scene, scene_file_type
   use contensou_study_equilibrium, only : equilibrium_type, find_equilibrium
   implicit none(type, external)
   private

   public :: equilibrium_command

   type(option_type), parameter :: options(*) = [ &
      option_type("SCENE", "", "namelist file", needs="a scene"), &
      option_type("--output", "FILE", "write an HDF5 file", "-o", "the name of a file"), &
      option_type("--scene", "FILE", "write the scene with its bodies at rest", &
      needs="the name of a file"), &
      option_type("--force", "", "replace existing files"), &
      option_type("--quiet", "", "print nothing unless something is wrong", "-q"), &
      strict_option, set_option]

   character(len=*), parameter :: nl = new_line("a")

contains

   !> `contensou equilibrium` in the table of commands.
   function equilibrium_command() result(command)
      type(command_type) :: command

      command = command_type("equilibrium", "rest position under the loads: deflections, " // &
         "contact loads, stiffness", options, "finds where contacts, springs, gravity and " // &
         "applied loads balance without friction and at rest, and prints deflections, loads " // &
         "of contacts, contact angles and the stiffness of rings", execute=report_equilibrium)
   end function equilibrium_command

   !> Find the rest position, print it, and write files if they are asked for.
   subroutine report_equilibrium(line, error)
      type(command_line_type), intent(in) :: line
      !> Set when there is a mistake, no rest position, or a file cannot be written.
      type(error_type), allocatable, intent(out) :: error
      type(scene_file_type) :: file
      type(equilibrium_type) :: found
      type(string_type) :: inputs(1)
      character(len=:), allocatable :: output, scene, text

      inputs(1)%s = line%text("SCENE")
      output = line%text("--output")
      scene = line%text("--scene")
      call read_scene(inputs(1)%s, line%texts("--set"), "", file, error)
      if (allocated(error)) return
      call heed_warnings(file, inputs(1)%s, line%has("--strict"), error)
      if (allocated(error)) return
      if (output /= "") call check_output(output, inputs, line%has("--force"), error)
      if (.not. allocated(error) .and. scene /= "") call check_output(scene, inputs, &
         line%has("--force"), error)
      if (.not. allocated(error) .and. output /= "" .and. scene /= "") then
         if (same_file(output, scene) .or. output == scene) call fatal(error, &
            "-o and --scene name the same file", status_usage)
      end if
      if (allocated(error)) return
      call find_equilibrium(file%scene, found, error)
      if (allocated(error)) return
      if (.not. line%has("--quiet")) call write_stdout(summary(found), error)
      if (.not. allocated(error) .and. scene /= "") then
         call moved_scene_text(inputs(1)%s, line%texts("--set"), found%scene, text, error)
         if (.not. allocated(error)) call write_scene()
      end if
      if (.not. allocated(error) .and. output /= "") call write_file()

   contains

      !> The scene with its bodies at rest, as a file.
      subroutine write_scene()
         type(output_type) :: target_file

         call target_file%open(scene, inputs, line%has("--force"), error)
         if (.not. allocated(error)) call target_file%write(text, error)
         if (.not. allocated(error)) call target_file%finish(error)
         call target_file%abandon()
      end subroutine write_scene

      !> Write the HDF5 file.
      subroutine write_file()
         type(hdf5_file_type) :: hdf5
         character(len=:), allocatable :: temporary
         type(error_type), allocatable :: ignored

         temporary = temporary_name(output)
         call write_equilibrium(found, file%text, file%resolved, command_text(line%words), &
            temporary, hdf5, error)
         if (.not. allocated(error)) call hdf5%close_as(output, line%has("--force"), error)
         if (.not. allocated(error)) return
         call hdf5%abandon()
         call remove_file(temporary, ignored)
      end subroutine write_file

   end subroutine report_equilibrium

   !> What is printed.
   function summary(found) result(text)
      type(equilibrium_type), intent(in) :: found
      character(len=:), allocatable :: text
      type(text_buffer_type) :: buffer
      integer :: i, k, closed

      call buffer%add("at rest after " // to_text(found%iterations) // " iterations, loads " // &
         "balanced to " // number_text(found%residual, 2) // nl)
      call buffer%add("bodies       moved by x, y, z [um]" // repeat(" ", 16) // &
         "turned about x, y, z [mrad]" // nl)
      do i = 1, size(found%scene%bodies)
         if (.not. (any(abs(found%shift(:, i)) > 0.0_wp) .or. any(abs(found%turn(:, i)) > &
            0.0_wp))) cycle
         call buffer%add("  " // padded(found%scene%bodies(i)%name, 14))
         do k = 1, 3
            call buffer%add(right(number_text(1.0e6_wp*found%shift(k, i), 6), 13))
         end do
         do k = 1, 3
            call buffer%add(right(number_text(1.0e3_wp*found%turn(k, i), 5), 12))
         end do
         call buffer%add(nl)
      end do
      closed = count(found%contacts%force > 0.0_wp)
      call buffer%add("contacts     " // to_text(closed) // " of " // &
         to_text(size(found%contacts)) // " carry" // nl)
      if (closed > 0) call buffer%add("  " // padded("", 18) // "     load [N]" // &
         " approach [um]  angle [deg]  pressure [MPa]" // nl)
      do i = 1, size(found%contacts)
         associate (contact => found%contacts(i))
            if (contact%force <= 0.0_wp) cycle
            call buffer%add("  " // padded(found%scene%contacts(i)%name, 18) // &
               right(number_text(contact%force, 7), 13) // &
               right(number_text(1.0e6_wp*contact%approach, 6), 14))
            if (ieee_is_nan(contact%angle)) then
               call buffer%add(right("", 13))
            else
               call buffer%add(right(number_text(contact%angle*180.0_wp/pi, 5), 13))
            end if
            call buffer%add(right(number_text(1.0e-6_wp*contact%pressure, 5), 16) // nl)
         end associate
      end do
      do i = 1, size(found%rings)
         associate (ring => found%rings(i))
            call buffer%add("stiffness of " // found%scene%bodies(ring%body)%name // &
               ": along and across, axes 1, 2, 3 = (" // vector(ring%frame(:, 1)) // "), (" // &
               vector(ring%frame(:, 2)) // "), (" // vector(ring%frame(:, 3)) // ")" // nl)
            call buffer%add("        " // "   shift 1 [m]   shift 2 [m]   shift 3 [m]" // &
               "  tilt 1 [rad]  tilt 2 [rad]" // nl)
            do k = 1, 5
               call buffer%add("  " // row_names(k))
               call add_row(ring%stiffness(k, :))
            end do
         end associate
      end do
      text = buffer%text()

   contains

      !> Name of a row of a stiffness matrix.
      pure function row_names(row) result(name)
         integer, intent(in) :: row
         character(len=7) :: name
         character(len=7), parameter :: names(5) = ["F 1 [N]", "F 2 [N]", "F 3 [N]", "M 1 Nm ", &
            "M 2 Nm "]

         name = names(row)
      end function row_names

      !> Add the numbers of a row.
      subroutine add_row(values)
         real(wp), intent(in) :: values(:)
         integer :: m

         do m = 1, size(values)
            call buffer%add(right(number_text(values(m), 7), 14))
         end do
         call buffer%add(nl)
      end subroutine add_row

      !> Components of a vector.
      function vector(values) result(words)
         real(wp), intent(in) :: values(3)
         character(len=:), allocatable :: words

         words = number_text(values(1), 4) // ", " // number_text(values(2), 4) // ", " // &
            number_text(values(3), 4)
      end function vector

   end function summary

   !> A text with blanks up to a width.
   pure function padded(text, width) result(cell)
      character(len=*), intent(in) :: text
      integer, intent(in) :: width
      character(len=:), allocatable :: cell

      cell = text // repeat(" ", max(0, width - len(text)))
   end function padded

end module contensou_drivers_equilibrium
