!> `contensou fmu`: a scene as a Functional Mock-up Unit.
module contensou_drivers_fmu
   use, intrinsic :: iso_c_binding, only : c_char, c_int, c_loc, c_null_char, c_ptr, c_size_t
   use contensou_base_errors, only : error_type, fatal
   use contensou_base_operating_system, only : remove_file, rename_file, sweep_up, &
      temporary_name, write_stdout
   use contensou_base_text, only : string_type
   use contensou_drivers_command_line, only : command_line_type, command_type, option_type, &
      set_option
   use contensou_drivers_output, only : check_output
   use contensou_scene_reader, only : read_scene, scene_file_type
   implicit none(type, external)
   private

   public :: fmu_command

   type(option_type), parameter :: options(*) = [ &
      option_type("SCENE", "", "namelist file of a scene", needs="a scene"), &
      set_option, &
      option_type("--output", "FILE", "file to write; if not given the name of the scene with " // &
      "the ending .fmu, in this folder", "-o", "the name of a file"), &
      option_type("--contact", "NAME", "a contact of the scene alone, as a force element: " // &
      "poses and velocities in, forces and torques out", needs="the name of a contact"), &
      option_type("--fmi", "N", "version of the interface, 2 or 3; default 3", &
      needs="2 or 3", choices="2 3"), &
      option_type("--force", "", "replace an existing file")]

   !> Room for a message.
   integer, parameter :: most = 65536

   interface
      !> Write the FMU of a scene or a contact; a message if that is not 0.
      function contensou_fmu_write(name, scene, settings, n, contact, fmi, title, output, place, &
         message, room) result(status) bind(c)
         import :: c_char, c_int, c_ptr, c_size_t
         implicit none(type, external)
         character(len=1, kind=c_char), intent(in) :: name(*)
         !> Text of the scene.
         character(len=1, kind=c_char), intent(in) :: scene(*)
         !> Texts as after `--set`.
         type(c_ptr), intent(in) :: settings(*)
         integer(c_int), intent(in), value :: n
         !> Name of a contact; empty for the whole scene.
         character(len=1, kind=c_char), intent(in) :: contact(*)
         !> 2 or 3.
         integer(c_int), intent(in), value :: fmi
         character(len=1, kind=c_char), intent(in) :: title(*)
         !> Name of the file, which the model is called after.
         character(len=1, kind=c_char), intent(in) :: output(*)
         !> Where the file waits for its name.
         character(len=1, kind=c_char), intent(in) :: place(*)
         character(len=1, kind=c_char), intent(out) :: message(*)
         !> Bytes of the buffer.
         integer(c_size_t), intent(in), value :: room
         integer(c_int) :: status
      end function contensou_fmu_write
   end interface

contains

   !> `contensou fmu` in the table of commands.
   function fmu_command() result(command)
      type(command_type) :: command

      command = command_type("fmu", "write a scene as a Functional Mock-up Unit", options, &
         "writes an FMU for model exchange and co-simulation: the numbers of the scene are " // &
         "its parameters, loads and drives its inputs, the quantities of a run its outputs", &
         "contensou fmu tippe_top.nml -o tippe_top.fmu --fmi 2", execute=write_fmu)
   end function fmu_command

   !> Write the FMU of a scene.
   subroutine write_fmu(line, error)
      type(command_line_type), intent(in) :: line
      type(error_type), allocatable, intent(out) :: error
      type(string_type), allocatable :: overrides(:)
      type(scene_file_type) :: file
      type(error_type), allocatable :: ignored
      type(string_type) :: inputs(1)
      character(len=:), allocatable :: scene, output, place, fmi
      character(len=:, kind=c_char), allocatable, target :: texts(:)
      type(c_ptr), allocatable :: settings(:)
      character(len=1, kind=c_char) :: message(most)
      character(len=:), allocatable :: reason
      integer :: i, longest, dot
      integer(c_int) :: status

      scene = line%text("SCENE")
      overrides = line%texts("--set")
      output = line%text("--output")
      fmi = line%text("--fmi")
      if (fmi == "") fmi = "3"
      if (output == "") then
         output = scene(index(scene, "/", back=.true.) + 1:)
         dot = index(output, ".", back=.true.)
         if (dot > 1) output = output(:dot - 1)
         output = output // ".fmu"
      end if
      call read_scene(scene, overrides, "", file, error)
      if (allocated(error)) return
      inputs(1)%s = scene
      call check_output(output, inputs, line%has("--force"), error)
      if (allocated(error)) return
      call sweep_up(output)
      place = temporary_name(output)
      longest = maxval([0, (len(overrides(i)%s), i=1, size(overrides))])
      allocate(character(len=longest + 1) :: texts(size(overrides)))
      allocate(settings(size(overrides)))
      do i = 1, size(overrides)
         texts(i) = overrides(i)%s // c_null_char
         settings(i) = c_loc(texts(i))
      end do
      status = contensou_fmu_write(scene // c_null_char, file%text // c_null_char, settings, &
         int(size(overrides), c_int), line%text("--contact") // c_null_char, &
         merge(2_c_int, 3_c_int, fmi == "2"), file%scene%title // c_null_char, &
         output // c_null_char, place // c_null_char, message, int(most, c_size_t))
      if (status == 0) then
         call rename_file(place, output, error, line%has("--force"))
         if (allocated(error)) then
            call remove_file(place, ignored)
         else
            call write_stdout(output // new_line("a"), error)
         end if
         return
      end if
      reason = ""
      do i = 1, most
         if (message(i) == c_null_char) exit
         reason = reason // message(i)
      end do
      call fatal(error, reason, int(status))
   end subroutine write_fmu

end module contensou_drivers_fmu
