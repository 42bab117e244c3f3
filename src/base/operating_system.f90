!> What the program asks of the operating system beyond standard Fortran: files and their safe
!> replacement, signals, clocks, the terminal.
module contensou_base_operating_system
   use, intrinsic :: iso_c_binding, only : c_associated, c_char, c_double, c_f_pointer, c_int, &
      c_int64_t, c_loc, c_null_char, c_ptr, c_size_t
   use contensou_base_errors, only : error_type, fatal, status_file
   use contensou_base_kinds, only : i8, wp
   use contensou_base_text, only : lower, string_type
   implicit none(type, external)
   private

   public :: list_folder
   public :: node_kind, node_none, node_file, node_folder, node_link, node_loose_link, &
      node_device, node_pipe, node_socket, same_file, longest_name, free_bytes
   public :: rename_file, remove_file, file_exists, is_folder, folder_writable, check_readable, &
      check_writable, is_locked
   public :: is_terminal, obeys_escapes, terminal_width, write_stderr, write_stdout, write_terminal
   public :: catch_signals, signal_received, open_standard_streams
   public :: release_signals, restore_signals
   public :: host_name, wall_seconds, cpu_seconds, utc_now
   public :: text_from_c, reason_of, save_file, checksum, unfinished_suffix
   public :: become
   public :: name_lock_type, remove_dead_lock, lock_suffix, temporary_name, longest_temporary
   public :: sweep_up, first_bytes

   !> Suffix of a file that `save_file` has not finished, as in the C source.
   character(len=*), parameter :: unfinished_suffix = ".new"

   !> Suffix of the file that is locked while a file is written, under whatever names.
   character(len=*), parameter :: lock_suffix = ".part.lock"

   !> The longest that `temporary_name` adds to a name.
   character(len=*), parameter :: longest_temporary = ".part-0123456789abcdef"

   !> The sole right to write what goes by a name.
   type :: name_lock_type
      private
      character(len=:), allocatable :: path
      integer(c_int) :: descriptor = -1
   contains
      procedure :: take => take_lock
      procedure :: leave => leave_lock
   end type name_lock_type

   !> There is nothing of a name.
   integer, parameter :: node_none = 0

   integer, parameter :: node_file = 1

   integer, parameter :: node_folder = 2

   !> A symbolic link to a file.
   integer, parameter :: node_link = 3

   !> A symbolic link to nothing.
   integer, parameter :: node_loose_link = 4

   integer, parameter :: node_device = 5

   integer, parameter :: node_pipe = 6

   integer, parameter :: node_socket = 7

   !> Continue the checksum of some bytes with more.
   interface checksum
      module procedure :: checksum_of_reals
      module procedure :: checksum_of_text
   end interface checksum

   ! Functions of C. One that acts returns 0 or errno, one that answers 1 or 0.
   interface
      !> Give closed standard streams to /dev/null, before any file can take their place.
      subroutine open_standard_streams() bind(c, name="contensou_system_open_standard_streams")
         implicit none(type, external)
      end subroutine open_standard_streams

      !> Undo what the Fortran library made of requests to stop, where the executable holds them
      !> back.
      subroutine restore_signals() bind(c, name="contensou_system_restore_signals")
         implicit none(type, external)
      end subroutine restore_signals

      !> Let requests to stop come that the executable held back from its first instruction on.
      subroutine release_signals() bind(c, name="contensou_system_release_signals")
         implicit none(type, external)
      end subroutine release_signals

      !> Turn what batch systems and lost terminals send into a flag for `signal_received`, what was
      !> held back until then among it: SIGINT, SIGTERM, SIGHUP unless it is ignored, SIGUSR1,
      !> SIGUSR2, SIGXCPU and others. A SIGINT or SIGTERM that follows more than a second later acts
      !> at once. A file-size limit and a closed pipe become write errors.
      subroutine catch_signals() bind(c, name="contensou_system_catch_signals")
         implicit none(type, external)
      end subroutine catch_signals

      !> Number of the last signal caught since `catch_signals`, 0 if none; costs one load.
      function signal_received() result(number) &
         bind(c, name="contensou_system_signal_received")
         import :: c_int
         implicit none(type, external)
         !> Number of the signal, or 0.
         integer(c_int) :: number
      end function signal_received

      !> Seconds of a clock that never jumps, from an arbitrary origin [s].
      function wall_seconds() result(seconds) bind(c, name="contensou_system_wall_seconds")
         import :: c_double
         implicit none(type, external)
         !> Reading of the clock [s].
         real(c_double) :: seconds
      end function wall_seconds

      !> CPU time of this process, all threads together [s].
      function cpu_seconds() result(seconds) bind(c, name="contensou_system_cpu_seconds")
         import :: c_double
         implicit none(type, external)
         !> CPU time [s].
         real(c_double) :: seconds
      end function cpu_seconds

      !> Columns of the terminal on stderr; without one as COLUMNS says, else 80.
      integer(c_int) function terminal_width() bind(c, name="contensou_system_terminal_width")
         import :: c_int
         implicit none(type, external)
      end function terminal_width

      !> Rename after bringing the content to the disk.
      integer(c_int) function c_rename(from, to, replace) bind(c, name="contensou_system_rename")
         import :: c_char, c_int
         implicit none(type, external)
         !> Present name, null-terminated.
         character(kind=c_char), intent(in) :: from(*)
         !> New name, null-terminated.
         character(kind=c_char), intent(in) :: to(*)
         !> Whether a file of the new name is replaced.
         integer(c_int), value :: replace
      end function c_rename

      !> Names in a folder, each followed by a slash; null on failure.
      function c_list(folder) result(names) bind(c, name="contensou_system_list")
         import :: c_char, c_ptr
         implicit none(type, external)
         !> Name of the folder, null-terminated.
         character(kind=c_char), intent(in) :: folder(*)
         !> The names, null-terminated.
         type(c_ptr) :: names
      end function c_list

      subroutine c_free(memory) bind(c, name="contensou_system_free")
         import :: c_ptr
         implicit none(type, external)
         !> Its address.
         type(c_ptr), value :: memory
      end subroutine c_free

      !> Remove a file.
      integer(c_int) function c_remove(path) bind(c, name="contensou_system_remove")
         import :: c_char, c_int
         implicit none(type, external)
         !> Name of the file, null-terminated.
         character(kind=c_char), intent(in) :: path(*)
      end function c_remove

      !> Go on as another program; errno if there is none.
      function c_become(name, words, n) result(code) bind(c, name="contensou_system_become")
         import :: c_char, c_int
         implicit none(type, external)
         !> Its name, null-terminated.
         character(kind=c_char), intent(in) :: name(*)
         !> The words of its command line, each null-terminated.
         character(kind=c_char), intent(in) :: words(*)
         !> Number of words.
         integer(c_int), value :: n
         integer(c_int) :: code
      end function c_become

      !> Whether a name is taken.
      integer(c_int) function c_exists(path) bind(c, name="contensou_system_exists")
         import :: c_char, c_int
         implicit none(type, external)
         !> Name, null-terminated.
         character(kind=c_char), intent(in) :: path(*)
      end function c_exists

      !> Whether a name is that of a folder.
      integer(c_int) function c_is_folder(path) bind(c, name="contensou_system_is_folder")
         import :: c_char, c_int
         implicit none(type, external)
         !> Name, null-terminated.
         character(kind=c_char), intent(in) :: path(*)
      end function c_is_folder

      !> Take a lock: 0, -1 if another process has it, or errno.
      integer(c_int) function c_take_lock(path, patience, descriptor) &
         bind(c, name="contensou_system_take_lock")
         import :: c_char, c_double, c_int
         implicit none(type, external)
         !> Name of its file, null-terminated.
         character(kind=c_char), intent(in) :: path(*)
         !> How long to wait [s].
         real(c_double), value :: patience
         integer(c_int), intent(out) :: descriptor
      end function c_take_lock

      !> Give a lock back.
      subroutine c_leave_lock(path, descriptor) bind(c, name="contensou_system_leave_lock")
         import :: c_char, c_int
         implicit none(type, external)
         !> Name of its file, null-terminated.
         character(kind=c_char), intent(in) :: path(*)
         integer(c_int), value :: descriptor
      end subroutine c_leave_lock

      !> What tells this process from others.
      integer(c_int64_t) function c_process() bind(c, name="contensou_system_process")
         import :: c_int64_t
         implicit none(type, external)
      end function c_process

      !> Remove temporary files of dead processes.
      subroutine c_sweep_up(path) bind(c, name="contensou_system_sweep_up")
         import :: c_char
         implicit none(type, external)
         !> Name beside which they are, null-terminated.
         character(kind=c_char), intent(in) :: path(*)
      end subroutine c_sweep_up

      !> What has a name.
      integer(c_int) function c_node(path) bind(c, name="contensou_system_node")
         import :: c_char, c_int
         implicit none(type, external)
         !> Name, null-terminated.
         character(kind=c_char), intent(in) :: path(*)
      end function c_node

      !> Whether two names are those of one file.
      integer(c_int) function c_same_file(a, b) bind(c, name="contensou_system_same_file")
         import :: c_char, c_int
         implicit none(type, external)
         !> Name, null-terminated.
         character(kind=c_char), intent(in) :: a(*)
         !> Another name, null-terminated.
         character(kind=c_char), intent(in) :: b(*)
      end function c_same_file

      !> Bytes that the name of a file may have in the folder of a path.
      integer(c_int) function c_longest_name(path) bind(c, name="contensou_system_longest_name")
         import :: c_char, c_int
         implicit none(type, external)
         !> Path of the file, null-terminated.
         character(kind=c_char), intent(in) :: path(*)
      end function c_longest_name

      !> Bytes that a file can grow to.
      real(c_double) function c_free_bytes(path) bind(c, name="contensou_system_free_bytes")
         import :: c_char, c_double
         implicit none(type, external)
         !> Name of the file, null-terminated.
         character(kind=c_char), intent(in) :: path(*)
      end function c_free_bytes

      !> Whether a file can be created where its name says.
      integer(c_int) function c_folder_writable(path) &
         bind(c, name="contensou_system_folder_writable")
         import :: c_char, c_int
         implicit none(type, external)
         !> Name of the file, null-terminated.
         character(kind=c_char), intent(in) :: path(*)
      end function c_folder_writable

      !> Whether another process is writing a file.
      integer(c_int) function c_is_locked(path) bind(c, name="contensou_system_is_locked")
         import :: c_char, c_int
         implicit none(type, external)
         !> Name of the file, null-terminated.
         character(kind=c_char), intent(in) :: path(*)
      end function c_is_locked

      !> Whether a standard stream is a terminal.
      integer(c_int) function c_is_terminal(unit) bind(c, name="contensou_system_is_terminal")
         import :: c_int
         implicit none(type, external)
         !> Number of the stream.
         integer(c_int), value :: unit
      end function c_is_terminal

      !> Name of this machine.
      subroutine c_host_name(name, size) bind(c, name="contensou_system_host_name")
         import :: c_char, c_size_t
         implicit none(type, external)
         !> Room for the name and its null character.
         character(kind=c_char), intent(out) :: name(*)
         !> Size of that room.
         integer(c_size_t), value :: size
      end subroutine c_host_name

      !> Date and time.
      subroutine c_utc_now(text, size) bind(c, name="contensou_system_utc_now")
         import :: c_char, c_size_t
         implicit none(type, external)
         !> Room for the text and its null character.
         character(kind=c_char), intent(out) :: text(*)
         !> Size of that room.
         integer(c_size_t), value :: size
      end subroutine c_utc_now

      !> Write to a standard stream.
      function c_write(unit, text, length) result(code) bind(c, name="contensou_system_write")
         import :: c_char, c_int, c_size_t
         implicit none(type, external)
         !> 1 for stdout, 2 for stderr.
         integer(c_int), value :: unit
         !> Bytes to write.
         character(kind=c_char), intent(in) :: text(*)
         !> Number of bytes.
         integer(c_size_t), value :: length
         !> Value of errno, 0 if all went well.
         integer(c_int) :: code
      end function c_write

      !> The same, control characters as escapes.
      function c_print(unit, text, length) result(code) bind(c, name="contensou_system_print")
         import :: c_char, c_int, c_size_t
         implicit none(type, external)
         !> 1 for stdout, 2 for stderr.
         integer(c_int), value :: unit
         !> Bytes to write.
         character(kind=c_char), intent(in) :: text(*)
         !> Number of bytes.
         integer(c_size_t), value :: length
         !> Value of errno, 0 if all went well.
         integer(c_int) :: code
      end function c_print

      !> Whether the terminal does what escape sequences say.
      integer(c_int) function c_obeys_escapes() bind(c, name="contensou_system_obeys_escapes")
         import :: c_int
         implicit none(type, external)
      end function c_obeys_escapes

      !> The system's words for an error number.
      type(c_ptr) function c_reason(code) bind(c, name="contensou_system_reason")
         import :: c_int, c_ptr
         implicit none(type, external)
         !> Value of errno.
         integer(c_int), value :: code
      end function c_reason

      !> Replace a file at once.
      integer(c_int) function c_save(path, bytes, length) bind(c, name="contensou_system_save")
         import :: c_char, c_int, c_size_t
         implicit none(type, external)
         !> Name of the file, null-terminated.
         character(kind=c_char), intent(in) :: path(*)
         !> Its content.
         character(kind=c_char), intent(in) :: bytes(*)
         !> Number of bytes.
         integer(c_size_t), value :: length
      end function c_save

      !> Continue a checksum.
      pure function c_checksum(sum, bytes, length) result(next) &
         bind(c, name="contensou_system_checksum")
         import :: c_int64_t, c_ptr, c_size_t
         implicit none(type, external)
         !> Checksum so far, 0 at the beginning.
         integer(c_int64_t), value :: sum
         !> Address of the bytes.
         type(c_ptr), value :: bytes
         !> Number of bytes.
         integer(c_size_t), value :: length
         !> The checksum with them.
         integer(c_int64_t) :: next
      end function c_checksum

      !> Length of a null-terminated text.
      pure function c_strlen(text) result(length) bind(c, name="strlen")
         import :: c_ptr, c_size_t
         implicit none(type, external)
         !> Null-terminated text.
         type(c_ptr), value :: text
         !> Number of bytes before the null character.
         integer(c_size_t) :: length
      end function c_strlen
   end interface

contains

   !> Rename a file, replacing one of the new name, so that the new name shows the complete
   !> content or nothing even after a power failure.
   subroutine rename_file(from, to, error, replace)
      !> Present name.
      character(len=*), intent(in) :: from
      !> New name, on the same file system.
      character(len=*), intent(in) :: to
      !> Set when the file could not be brought to the disk or renamed.
      type(error_type), allocatable, intent(out) :: error
      !> Whether a file of the new name is replaced (default) or an error.
      logical, intent(in), optional :: replace
      integer(c_int) :: code, replacing

      replacing = 1
      if (present(replace)) replacing = merge(1_c_int, 0_c_int, replace)
      code = c_rename(trim(from) // c_null_char, trim(to) // c_null_char, replacing)
      if (code /= 0) then
         call fatal(error, "cannot rename " // trim(from) // " to " // trim(to) // ": " // &
            reason_of(code), status_file)
      end if
   end subroutine rename_file

   !> Remove a file; one that is not there counts as removed.
   subroutine remove_file(path, error)
      character(len=*), intent(in) :: path
      !> Set when the file is still there.
      type(error_type), allocatable, intent(out) :: error
      integer(c_int) :: code

      code = c_remove(trim(path) // c_null_char)
      if (code /= 0) then
         call fatal(error, "cannot remove " // trim(path) // ": " // reason_of(code), status_file)
      end if
   end subroutine remove_file

   !> Replace a file, so that a kill or a power failure at any moment leaves the old content or the
   !> new one.
   subroutine save_file(path, bytes, error)
      character(len=*), intent(in) :: path
      !> Its new content.
      character(len=*), intent(in) :: bytes
      !> Set when the old content is still there.
      type(error_type), allocatable, intent(out) :: error
      integer(c_int) :: code

      code = c_save(trim(path) // c_null_char, bytes, len(bytes, c_size_t))
      if (code /= 0) call fatal(error, "cannot write " // trim(path) // ": " // reason_of(code), &
         status_file)
   end subroutine save_file

   !> Continue a checksum with the bytes of reals.
   function checksum_of_reals(sum, values) result(next)
      !> Checksum so far, 0 at the beginning.
      integer(i8), intent(in) :: sum
      real(wp), intent(in), contiguous, target :: values(:)
      !> The checksum with them.
      integer(i8) :: next

      next = sum
      if (size(values) > 0) next = c_checksum(sum, c_loc(values), &
         int(size(values), c_size_t)*storage_size(values)/8)
   end function checksum_of_reals

   !> Continue a checksum with the bytes of a text.
   function checksum_of_text(sum, text) result(next)
      !> Checksum so far, 0 at the beginning.
      integer(i8), intent(in) :: sum
      character(len=*), intent(in), target :: text
      !> The checksum with it.
      integer(i8) :: next

      next = sum
      if (len(text) > 0) next = c_checksum(sum, c_loc(text), len(text, c_size_t))
   end function checksum_of_text

   !> Whether there is a file, folder or device of this name.
   function file_exists(path) result(answer)
      !> Name to look for.
      character(len=*), intent(in) :: path
      !> True if the name is taken.
      logical :: answer

      answer = c_exists(trim(path) // c_null_char) /= 0
   end function file_exists

   !> Whether there is a folder of this name.
   function is_folder(path) result(answer)
      !> Name to look for.
      character(len=*), intent(in) :: path
      !> True if it is a folder.
      logical :: answer

      answer = c_is_folder(trim(path) // c_null_char) /= 0
   end function is_folder

   !> Take the sole right to write what goes by a name.
   subroutine take_lock(self, name, patience, taken, error)
      class(name_lock_type), intent(inout) :: self
      character(len=*), intent(in) :: name
      !> How long to wait for another process [s].
      real(wp), intent(in) :: patience
      !> Whether it was taken; if not, another process has it.
      logical, intent(out) :: taken
      !> Set when nothing can be written there.
      type(error_type), allocatable, intent(out) :: error
      integer(c_int) :: code

      self%path = trim(name) // lock_suffix
      code = c_take_lock(self%path // c_null_char, patience, self%descriptor)
      taken = code == 0
      if (code > 0) call fatal(error, "cannot write " // self%path // ": " // reason_of(code), &
         status_file)
   end subroutine take_lock

   !> Give it back; nothing is done if it was not taken.
   subroutine leave_lock(self)
      class(name_lock_type), intent(inout) :: self

      if (self%descriptor >= 0) call c_leave_lock(self%path // c_null_char, self%descriptor)
      self%descriptor = -1
   end subroutine leave_lock

   !> Remove the lock of a file that is complete, if a process that was killed left it.
   subroutine remove_dead_lock(name)
      character(len=*), intent(in) :: name
      type(name_lock_type) :: lock
      type(error_type), allocatable :: unwritable
      logical :: dead

      if (.not. file_exists(name // lock_suffix)) return
      call lock%take(name, 0.0_wp, dead, unwritable)
      call lock%leave()
   end subroutine remove_dead_lock

   !> A name beside another one under which only this process writes.
   function temporary_name(name) result(temporary)
      character(len=*), intent(in) :: name
      character(len=:), allocatable :: temporary
      character(len=16) :: digits

      write(digits, "(z16.16)") c_process()
      temporary = name // ".part-" // lower(digits)
   end function temporary_name

   !> Remove what dead processes left under temporary names.
   subroutine sweep_up(name)
      !> Name beside which they are.
      character(len=*), intent(in) :: name

      call c_sweep_up(trim(name) // c_null_char)
   end subroutine sweep_up

   !> The first bytes of a file; fewer if it is shorter or cannot be read.
   function first_bytes(path, n) result(bytes)
      character(len=*), intent(in) :: path
      !> How many are wanted.
      integer, intent(in) :: n
      character(len=:), allocatable :: bytes
      character(len=1) :: c
      integer :: unit, stat, i

      bytes = ""
      open(newunit=unit, file=path, access="stream", form="unformatted", status="old", &
         action="read", iostat=stat)
      if (stat /= 0) return
      do i = 1, n
         read(unit, iostat=stat) c
         if (stat /= 0) exit
         bytes = bytes // c
      end do
      close(unit)
   end function first_bytes

   !> What has a name, one of the `node_*` codes or more. Links to what is neither a file nor
   !> nothing count as what they lead to.
   integer function node_kind(path)
      character(len=*), intent(in) :: path

      node_kind = int(c_node(trim(path) // c_null_char))
   end function node_kind

   !> Whether two names are those of one file, however they are spelled.
   logical function same_file(a, b)
      !> Name of a file.
      character(len=*), intent(in) :: a
      !> Another name.
      character(len=*), intent(in) :: b

      same_file = c_same_file(trim(a) // c_null_char, trim(b) // c_null_char) /= 0
   end function same_file

   !> Bytes that the name of a file may have in the folder of a path.
   integer function longest_name(path)
      character(len=*), intent(in) :: path

      longest_name = int(c_longest_name(trim(path) // c_null_char))
   end function longest_name

   !> Bytes that a file can grow to: those that are free on its disk and its own.
   real(wp) function free_bytes(path)
      character(len=*), intent(in) :: path

      free_bytes = c_free_bytes(trim(path) // c_null_char)
   end function free_bytes

   !> Whether the folder part of a file name exists and files can be created in it.
   function folder_writable(path) result(answer)
      !> Name of a file; without a slash its folder is the working folder.
      character(len=*), intent(in) :: path
      !> True if the file could be created.
      logical :: answer

      answer = c_folder_writable(trim(path) // c_null_char) /= 0
   end function folder_writable

   !> See that a file can be read, as far as its name tells.
   subroutine check_readable(path, error)
      character(len=*), intent(in) :: path
      type(error_type), allocatable, intent(out) :: error

      if (is_folder(path)) then
         call fatal(error, path // " cannot be read: it is a folder", status_file)
      else if (.not. file_exists(path)) then
         call fatal(error, path // " cannot be read: it does not exist", status_file)
      end if
   end subroutine check_readable

   !> See that a file can be created or replaced.
   subroutine check_writable(path, what, error)
      character(len=*), intent(in) :: path
      !> What it is, for the message, such as "output file".
      character(len=*), intent(in) :: what
      !> Set when it is a folder, or when files cannot be created where it is to be.
      type(error_type), allocatable, intent(out) :: error

      if (is_folder(path)) then
         call fatal(error, "the " // what // " " // path // " is a folder", status_file)
         return
      end if
      if (.not. folder_writable(path)) call fatal(error, "cannot write " // path // ": " // &
         folder_trouble(path), status_file)
   end subroutine check_writable

   !> Why files cannot be created in the folder of a file.
   function folder_trouble(path) result(words)
      character(len=*), intent(in) :: path
      character(len=:), allocatable :: words
      integer :: slash

      slash = index(path, "/", back=.true.)
      if (slash <= 1) then
         words = "its folder is not writable"
         return
      end if
      words = "its folder " // path(:slash - 1)
      if (is_folder(path(:slash - 1))) then
         words = words // " is not writable"
      else if (file_exists(path(:slash - 1))) then
         words = words // " is a file, not a folder"
      else
         words = words // " does not exist"
      end if
   end function folder_trouble

   !> Whether another process is writing this file, judged by the lock that a writer holds.
   function is_locked(path) result(answer)
      !> Name of the file; one that does not exist is not locked.
      character(len=*), intent(in) :: path
      !> True if the lock is held.
      logical :: answer

      answer = c_is_locked(trim(path) // c_null_char) /= 0
   end function is_locked

   !> Whether a standard stream is a terminal.
   function is_terminal(unit) result(answer)
      !> 1 for standard output, 2 for standard error.
      integer, intent(in) :: unit
      !> True for a terminal.
      logical :: answer

      answer = c_is_terminal(int(unit, c_int)) /= 0
   end function is_terminal

   !> Whether the terminal on stderr does what escape sequences say; one with TERM=dumb shows them.
   logical function obeys_escapes()

      obeys_escapes = c_obeys_escapes() /= 0
   end function obeys_escapes

   !> Write to standard error at once; no line feed is added. Control characters, which names and
   !> titles may have, are shown as escapes.
   subroutine write_stderr(text)
      !> Text to write.
      character(len=*), intent(in) :: text
      integer(c_int) :: code

      ! A closed stderr is nobody's concern.
      code = c_print(2_c_int, text, len(text, c_size_t))
   end subroutine write_stderr

   !> Write to the terminal on standard error what it is to obey, as it stands.
   subroutine write_terminal(text)
      !> Text to write.
      character(len=*), intent(in) :: text
      integer(c_int) :: code

      code = c_write(2_c_int, text, len(text, c_size_t))
   end subroutine write_terminal

   !> Write results to stdout; unlike Fortran's, this write sees a full disk. Control characters,
   !> which names and titles may have, are shown as escapes.
   subroutine write_stdout(text, error, as_is)
      !> Text to write.
      character(len=*), intent(in) :: text
      !> Set when not all of it could be written.
      type(error_type), allocatable, intent(out) :: error
      !> Whether it is written as it stands, for a file that is read again.
      logical, intent(in), optional :: as_is
      integer(c_int) :: code
      logical :: plain

      plain = .false.
      if (present(as_is)) plain = as_is
      if (plain) then
         code = c_write(1_c_int, text, len(text, c_size_t))
      else
         code = c_print(1_c_int, text, len(text, c_size_t))
      end if
      if (code /= 0) call fatal(error, "cannot write to the standard output: " // reason_of(code), &
         status_file)
   end subroutine write_stdout

   !> Go on as another program, which lies beside this one or is found as the shell finds it.
   subroutine become(name, words, trouble)
      character(len=*), intent(in) :: name
      !> Words of its command line.
      type(string_type), intent(in) :: words(:)
      !> Why there is none.
      character(len=:), allocatable, intent(out) :: trouble
      character(len=:), allocatable :: all_words
      integer :: i

      all_words = ""
      do i = 1, size(words)
         all_words = all_words // words(i)%s // c_null_char
      end do
      trouble = reason_of(c_become(name // c_null_char, all_words // c_null_char, &
         size(words, kind=c_int)))
   end subroutine become

   !> Name of this machine.
   function host_name() result(name)
      !> The name, "unknown" if there is none.
      character(len=:), allocatable :: name
      character(kind=c_char, len=256) :: buffer

      call c_host_name(buffer, len(buffer, c_size_t))
      name = buffer(:index(buffer, c_null_char) - 1)
   end function host_name

   !> Date and time in the form 2026-01-31T12:00:00Z.
   function utc_now() result(text)
      !> Coordinated universal time.
      character(len=20) :: text
      character(kind=c_char, len=32) :: buffer

      call c_utc_now(buffer, len(buffer, c_size_t))
      text = buffer(:index(buffer, c_null_char) - 1)
   end function utc_now

   !> Names in a folder, in the order of their bytes; none if it cannot be read.
   subroutine list_folder(folder, names)
      character(len=*), intent(in) :: folder
      type(string_type), allocatable, intent(out) :: names(:)
      type(c_ptr) :: pointer
      character(len=:), allocatable :: text
      integer :: i, n, start

      text = ""
      pointer = c_list(folder // c_null_char)
      if (c_associated(pointer)) then
         text = text_from_c(pointer)
         call c_free(pointer)
      end if
      n = count([(text(i:i) == "/", i=1, len(text))])
      allocate(names(n))
      start = 1
      do i = 1, n
         names(i)%s = text(start:start + index(text(start:), "/") - 2)
         start = start + len(names(i)%s) + 1
      end do
   end subroutine list_folder

   !> Copy of a null-terminated text that C owns.
   function text_from_c(pointer) result(text)
      !> Address of the text; must not be null.
      type(c_ptr), intent(in) :: pointer
      !> The text without its null character.
      character(len=:), allocatable :: text
      character(kind=c_char), pointer :: bytes(:)
      integer :: i

      call c_f_pointer(pointer, bytes, [c_strlen(pointer)])
      allocate(character(len=size(bytes)) :: text)
      do i = 1, size(bytes)
         text(i:i) = bytes(i)
      end do
   end function text_from_c

   !> The system's words for an error number.
   function reason_of(code) result(text)
      !> Value of errno.
      integer(c_int), intent(in) :: code
      !> Such as "No space left on device".
      character(len=:), allocatable :: text

      text = text_from_c(c_reason(code))
   end function reason_of

end module contensou_base_operating_system
