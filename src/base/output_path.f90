!> Which names a file may be written under: never that of a file that the command reads, never one
!> that is taken by anything but a regular file, and with room for the files beside it.
module contensou_base_output_path
   use contensou_base_errors, only : error_type, fatal, status_file, status_usage
   use contensou_base_numbers, only : to_text
   use contensou_base_operating_system, only : longest_name, node_device, node_file, node_folder, &
      node_kind, node_link, node_loose_link, node_none, node_pipe, node_socket, same_file
   use contensou_base_text, only : shorten, string_type
   implicit none(type, external)
   private

   public :: check_output_path, what_helps

   !> Bytes of a path that the system takes.
   integer, parameter :: longest_path = 4095

   !> Bytes of a name that is too long that a message shows.
   integer, parameter :: shown = 60

contains

   !> See that a file can be written under a name, and that nothing else is lost by it.
   subroutine check_output_path(path, what, inputs, suffixes, replace, error)
      !> Name of the file.
      character(len=*), intent(in) :: path
      !> What it is, for the message, such as "output file".
      character(len=*), intent(in) :: what
      !> Names of the files that the command reads.
      type(string_type), intent(in) :: inputs(:)
      !> What the names of the files beside it have in addition, such as ".part".
      character(len=*), intent(in) :: suffixes(:)
      !> Whether a file that exists is replaced.
      logical, intent(in) :: replace
      !> Set when it must not be written.
      type(error_type), allocatable, intent(out) :: error
      integer :: i, room, used

      if (path(len(path):) == "/") then
         call fatal(error, "the " // what // " " // path // " is a folder", status_file)
         return
      end if
      if (path == "-") then
         call fatal(error, "the " // what // " needs a name: - alone means a terminal or a pipe, " &
            // "which cannot be it; ./- is a file", status_file)
         return
      end if
      room = longest_name(path)
      used = len(path) - index(path, "/", back=.true.)
      do i = 1, size(suffixes)
         if (used + len_trim(suffixes(i)) <= room .and. &
            len(path) + len_trim(suffixes(i)) <= longest_path) cycle
         if (used + maxval(len_trim(suffixes)) > room) then
            call fatal(error, "the name of the " // what // " " // shorten(path, shown) // &
               " is too long: a file beside it has " // trim(suffixes(i)) // &
               " after its name, and a name here has at most " // to_text(room) // &
               " bytes; up to " // to_text(room - maxval(len_trim(suffixes))) // &
               " bytes will do, these are " // to_text(used), status_file)
         else
            call fatal(error, "the path of the " // what // " " // shorten(path, shown) // &
               " is too long: it has " // to_text(len(path)) // " bytes; up to " // &
               to_text(longest_path - maxval(len_trim(suffixes))) // " will do", status_file)
         end if
         return
      end do
      call check_name(path, "", what, inputs, replace, error)
      do i = 1, size(suffixes)
         if (allocated(error)) return
         call check_name(path, trim(suffixes(i)), what, inputs, .true., error)
      end do
   end subroutine check_output_path

   !> Check the name of a file, or of one beside it.
   subroutine check_name(path, suffix, what, inputs, may_replace, error)
      !> Name of the file.
      character(len=*), intent(in) :: path
      !> What the name of that beside it has in addition; blank for the file itself.
      character(len=*), intent(in) :: suffix
      !> What the file is, for the message.
      character(len=*), intent(in) :: what
      !> Names of the files that the command reads.
      type(string_type), intent(in) :: inputs(:)
      !> Whether what has this name is replaced.
      logical, intent(in) :: may_replace
      !> Set when it must not be written.
      type(error_type), allocatable, intent(inout) :: error
      character(len=:), allocatable :: name, kind
      integer :: node, k

      name = path // suffix
      node = node_kind(name)
      if (node == node_none) return
      do k = 1, size(inputs)
         if (.not. same_file(name, inputs(k)%s)) cycle
         kind = " is a file that is read"
         if (name /= inputs(k)%s) kind = " is " // inputs(k)%s // ", which is read"
         if (suffix == "") then
            call fatal(error, "the " // what // " " // name // kind // &
               "; -o FILE writes another one", status_usage)
         else
            call fatal(error, name // ", which is written beside the " // what // "," // &
               kind // "; -o FILE writes another one", status_usage)
         end if
         return
      end do
      if (node == node_file .or. (node == node_link .and. .not. may_replace)) return
      select case (node)
      case (node_folder)
         call fatal(error, "the " // what // " " // name // " is a folder", status_file)
         return
      case (node_link, node_loose_link)
         kind = "symbolic link"
      case (node_device)
         kind = "device"
      case (node_pipe)
         kind = "pipe"
      case (node_socket)
         kind = "socket"
      case default
         kind = "special file"
      end select
      if (suffix == "") then
         call fatal(error, "the " // what // " " // name // " is a " // kind // &
            ", only regular files are replaced; -o FILE writes another one", status_file)
      else
         call fatal(error, name // ", which is written beside the " // what // ", is a " // &
            kind // ", only regular files are replaced; remove it, or -o FILE writes " // &
            "another one", status_file)
      end if
   end subroutine check_name

   !> What helps where a file exists: the end of a message.
   function what_helps(path) result(text)
      character(len=*), intent(in) :: path
      character(len=:), allocatable :: text

      text = "; -o FILE writes another one"
      if (node_kind(path) == node_file) text = "; --force replaces it, -o FILE writes another one"
   end function what_helps

end module contensou_base_output_path
