!> Tests of the HDF5 writer and of what it needs from the system.
module test_hdf5_file
   use contensou_base_errors, only : error_type, status_file
   use contensou_base_kinds, only : i8, wp
   use contensou_base_operating_system, only : catch_signals, cpu_seconds, file_exists, &
      folder_writable, host_name, is_folder, is_locked, remove_file, rename_file, &
      signal_received, terminal_width, utc_now, wall_seconds
   use contensou_files_hdf5_file, only : hdf5_file_type, hdf5_series_type, &
      hdf5_version, series_integer, series_real, series_text
   use contensou_files_hdf5_reader, only : readable_status
   use test_harness, only : shell_quote
   implicit none(type, external)
   private

   public :: run_hdf5_file_tests

   abstract interface
      !> Count a check.
      subroutine check_interface(condition, name)
         implicit none(type, external)
         !> Whether it passed.
         logical, intent(in) :: condition
         !> What was checked.
         character(len=*), intent(in) :: name
      end subroutine check_interface
   end interface

contains

   !> Run all tests of this module.
   subroutine run_hdf5_file_tests(check, folder)
      !> Called once for each check.
      procedure(check_interface) :: check
      !> Folder to write to.
      character(len=*), intent(in) :: folder

      call test_system(check, folder)
      call test_whole_file(check, folder)
      call test_empty_series(check, folder)
      call test_status(check, folder)
      call test_create_failures(check, folder)
      call test_misuse(check, folder)
      call test_abandon(check, folder)
      call test_disk_full(check)
   end subroutine run_hdf5_file_tests

   !> Files, clocks and signals.
   subroutine test_system(check, folder)
      !> Called once for each check.
      procedure(check_interface) :: check
      !> Folder to write to.
      character(len=*), intent(in) :: folder

      type(error_type), allocatable :: error
      character(len=20) :: now
      real(wp) :: start
      integer :: unit

      call check(is_folder(folder), "is_folder: a folder")
      call check(.not. is_folder(folder // "/missing"), "is_folder: nothing there")
      call check(folder_writable(folder // "/file"), "folder_writable: a writable folder")
      call check(.not. folder_writable(folder // "/missing/file"), "folder_writable: none there")

      open(newunit=unit, file=folder // "/old", status="replace", action="write")
      write(unit, "(a)") "content"
      close(unit)
      call check(.not. is_folder(folder // "/old"), "is_folder: a file")
      call check(.not. folder_writable(folder // "/old/file"), &
         "folder_writable: a file in its place")
      call check(.not. is_locked(folder // "/old"), "is_locked: a file of nobody")
      call rename_file(folder // "/old", folder // "/new", error)
      call check(.not. allocated(error), "rename_file: succeeds")
      call check(file_exists(folder // "/new"), "rename_file: the new name is there")
      call check(.not. file_exists(folder // "/old"), "rename_file: the old name is gone")
      call rename_file(folder // "/old", folder // "/new", error)
      call check_error(check, error, "No such file or directory", "rename_file: nothing to rename")
      call remove_file(folder // "/new", error)
      call check(.not. allocated(error), "remove_file: succeeds")
      call check(.not. file_exists(folder // "/new"), "remove_file: the file is gone")
      call remove_file(folder // "/new", error)
      call check(.not. allocated(error), "remove_file: nothing to remove is no error")
      call remove_file(folder, error)
      call check(allocated(error), "remove_file: a folder is refused")

      start = wall_seconds()
      call check(wall_seconds() >= start, "wall_seconds: never goes back")
      call check(cpu_seconds() > 0.0_wp, "cpu_seconds: positive")
      now = utc_now()
      call check(now(5:5) == "-" .and. now(11:11) == "T" .and. now(20:20) == "Z", "utc_now: form")
      call check(len(host_name()) > 0, "host_name: not empty")
      call check(terminal_width() > 0, "terminal_width: positive")
      call catch_signals()
      call check(signal_received() == 0, "signal_received: none yet")
   end subroutine test_system

   !> A file with everything in it.
   subroutine test_whole_file(check, folder)
      !> Called once for each check.
      procedure(check_interface) :: check
      !> Folder to write to.
      character(len=*), intent(in) :: folder

      integer, parameter :: n_rows = 100
      type(error_type), allocatable :: error
      type(hdf5_file_type) :: file
      type(hdf5_series_type) :: time, position, event_time, kind, count
      real(wp) :: times(n_rows), positions(3, 2, n_rows)
      character(len=:), allocatable :: path
      integer :: i

      path = folder // "/whole.h5"
      call file%create(path // ".part", error)
      call check(.not. allocated(error) .and. file%is_open(), "create")
      if (allocated(error)) return
      call file%put_attribute("/", "status", "running", error)
      call check(.not. allocated(error), "put_attribute: text")
      call file%create_group("/body", error)
      call check(.not. allocated(error), "create_group")
      call file%create_group("/events", error)
      call file%create_group("/trajectory", error)
      call file%put_attribute_values("/trajectory", "axes", &
         [character(len=4) :: "time", "body", "xyz"], error)
      call check(.not. allocated(error), "put_attribute: texts")
      call file%put_attribute_values("/", "filetype_version", 1, error)
      call check(.not. allocated(error), "put_attribute: integer")
      call file%put_attribute_values("/", "filetype_version", 2.0_wp, error)
      call check(.not. allocated(error), "put_attribute: real in place of an integer")

      call file%put_labels("/body/body", [character(len=8) :: "top", "kreisel"], "body", error)
      call check(.not. allocated(error), "put_labels")
      call file%put_labels("/body/xyz", ["x", "y", "z"], "Cartesian component", error)
      call file%put_array("/body/mass", [1.0_wp, 2.0_wp], ["/body/body"], "kg", "mass", error)
      call check(.not. allocated(error), "put_array: reals")
      call file%put_array("/body/inertia", reshape([1.0_wp, 2.0_wp, 3.0_wp, 4.0_wp, 5.0_wp, &
         6.0_wp], [3, 2]), [character(len=10) :: "/body/body", "/body/xyz"], "kg m2", &
         "principal moments of inertia", error)
      call check(.not. allocated(error), "put_array: table of reals")
      call file%put_array("/body/index", [1, 2], ["/body/body"], "1", "index", error)
      call check(.not. allocated(error), "put_array: integers")
      call file%put_texts("/body/shape", [character(len=6) :: "sphere", "plane"], ["/body/body"], &
         "shape", error)
      call check(.not. allocated(error), "put_array: texts")
      call file%put_texts("/body/words", reshape(["a", "b", "c", "d", "e", "f"], [3, 2]), &
         [character(len=10) :: "/body/body", "/body/xyz"], "words", error)
      call check(.not. allocated(error), "put_array: table of texts")
      call file%put_text("/input", "&body" // new_line("a") // " name = 'Kreisel'  ", "scene", &
         error)
      call check(.not. allocated(error), "put_text")
      call file%put_value("/steps", 12, "1", "steps", error)
      call check(.not. allocated(error), "put_value: integer")
      call file%put_value("/bytes", 3000000000_i8, "byte", "bytes", error)
      call check(.not. allocated(error), "put_value: eight-byte integer")
      call file%put_value("/cpu", 1.5_wp, "s", "CPU time", error)
      call check(.not. allocated(error), "put_value: real")

      call file%put_labels("/trajectory/body", ["top    ", "kreisel"], "body", error)
      call file%put_labels("/trajectory/xyz", ["x", "y", "z"], "Cartesian component", error)
      call file%create_series("/trajectory/time", [integer ::], [character(len=1) ::], .true., &
         64, "s", "time", series_real, time, error)
      call check(.not. allocated(error), "create_series: scale")
      call file%create_series("/trajectory/position", [2, 3], [character(len=16) :: &
         "/trajectory/time", "/trajectory/body", "/trajectory/xyz"], .false., 64, "m", &
         "position", series_real, position, error)
      call check(.not. allocated(error), "create_series: three dimensions")
      call file%create_series("/events/time", [integer ::], [character(len=1) ::], .true., 16, &
         "s", "time of the event", series_real, event_time, error)
      call file%create_series("/events/kind", [integer ::], ["/events/time"], .false., 16, "", &
         "touch or lift", series_text, kind, error)
      call check(.not. allocated(error), "create_series: text")
      call file%create_series("/events/count", [integer ::], ["/events/time"], .false., 16, "1", &
         "number of the event", series_integer, count, error)
      call check(.not. allocated(error), "create_series: integer")

      times = [(0.1_wp*i, i = 0, n_rows - 1)]
      positions = reshape([(real(i, wp), i = 1, size(positions))], shape(positions))
      call file%append(time, n_rows, times, error)
      call check(.not. allocated(error), "append: more than a chunk")
      call file%append(position, 60, positions(:, :, :60), error)
      call check(.not. allocated(error), "append: a section")
      call file%append(position, n_rows - 60, positions(:, :, 61:), error)
      call check(.not. allocated(error), "append: the rest")
      call file%append(event_time, 1, 0.25_wp, error)
      call check(.not. allocated(error), "append: a scalar")
      call file%append(kind, 1, ["touch "], error)
      call check(.not. allocated(error), "append: text")
      call file%append(count, 1, [1], error)
      call check(.not. allocated(error), "append: integer")
      call file%append(time, 0, times, error)
      call check(.not. allocated(error), "append: nothing")

      call file%flush(error)
      call check(.not. allocated(error), "flush")
      call file%put_attribute("/", "status", "complete", error)
      call check(.not. allocated(error), "put_attribute: rewritten")
      call file%close(error)
      call check(.not. allocated(error) .and. .not. file%is_open(), "close")
      call file%close(error)
      call check(.not. allocated(error), "close: twice is no error")
      call rename_file(path // ".part", path, error)
      call check(.not. allocated(error), "rename under the final name")
      call check_status(check, path, "complete", "whole file")
      call check(len(hdf5_version()) >= 5, "hdf5_version")
   end subroutine test_whole_file

   !> A run that ends before its first row, in a scene without contacts.
   subroutine test_empty_series(check, folder)
      !> Called once for each check.
      procedure(check_interface) :: check
      !> Folder to write to.
      character(len=*), intent(in) :: folder

      type(error_type), allocatable :: error
      type(hdf5_file_type) :: file
      type(hdf5_series_type) :: time, gap
      character(len=1) :: names(0)
      real(wp) :: gaps(0, 5)

      call file%create(folder // "/empty.h5", error)
      if (allocated(error)) return
      call file%put_attribute("/", "status", "complete", error)
      call file%put_labels("/contact", names, "contact", error)
      call check(.not. allocated(error), "put_labels: none")
      call file%create_series("/time", [integer ::], names, .true., 64, "s", "time", &
         series_real, time, error)
      call file%create_series("/gap", [0], [character(len=8) :: "/time", "/contact"], .false., &
         64, "m", "gap", series_real, gap, error)
      call check(.not. allocated(error), "create_series: rows of no values")
      call file%append(gap, 5, gaps, error)
      call check(.not. allocated(error), "append: rows of no values")
      call file%close(error)
      call check(.not. allocated(error), "close: empty series")
      call check_status(check, folder // "/empty.h5", "complete", "empty series")
   end subroutine test_empty_series

   !> What is said of files that are missing, foreign, being written or without a status.
   subroutine test_status(check, folder)
      !> Called once for each check.
      procedure(check_interface) :: check
      !> Folder to write to.
      character(len=*), intent(in) :: folder

      type(error_type), allocatable :: error
      type(hdf5_file_type) :: file, other
      character(len=:), allocatable :: status_text
      integer :: unit

      call readable_status(folder // "/missing.h5", status_text, error)
      call check_error(check, error, "it does not exist", "status: missing file")

      open(newunit=unit, file=folder // "/foreign.h5", status="replace", action="write")
      write(unit, "(a)") "no HDF5 at all"
      close(unit)
      call readable_status(folder // "/foreign.h5", status_text, error)
      call check_error(check, error, "foreign.h5", "status: not HDF5")

      call file%create(folder // "/live.h5", error)
      call check(is_locked(folder // "/live.h5"), "is_locked: a file being written")
      call file%put_attribute("/", "title", "live", error)
      call other%create(folder // "/live.h5", error)
      call check_error(check, error, "another program has it open", "create: a file being written")
      call file%close(error)
      call check(.not. is_locked(folder // "/live.h5"), "is_locked: a closed file")
      call readable_status(folder // "/live.h5", status_text, error)
      call check_error(check, error, "status", "status: none in the file")
   end subroutine test_status

   !> Places where no file can be.
   subroutine test_create_failures(check, folder)
      !> Called once for each check.
      procedure(check_interface) :: check
      !> Folder to write to.
      character(len=*), intent(in) :: folder

      type(error_type), allocatable :: error
      type(hdf5_file_type) :: file
      character(len=:), allocatable :: locked

      call file%create(folder // "/missing/file.h5", error)
      call check_error(check, error, "No such file or directory", "create: missing folder")
      call check(.not. file%is_open(), "create: no file open after a failure")
      call file%create(folder, error)
      call check_error(check, error, "Is a directory", "create: a folder of that name")

      locked = folder // "/locked"
      call execute_command_line("mkdir -p " // shell_quote(locked) // " && chmod 500 " // &
         shell_quote(locked))
      ! The superuser may write everywhere.
      if (.not. folder_writable(locked // "/file.h5")) then
         call file%create(locked // "/file.h5", error)
         call check_error(check, error, "Permission denied", "create: unwritable folder")
      end if
      call execute_command_line("chmod 700 " // shell_quote(locked) // " && rmdir " // &
         shell_quote(locked))
      call file%create("/proc/contensou.h5", error)
      call check(allocated(error), "create: a file system that takes no files")
   end subroutine test_create_failures

   !> Calls that make no sense are errors, and the first is the one reported at the end.
   subroutine test_misuse(check, folder)
      !> Called once for each check.
      procedure(check_interface) :: check
      !> Folder to write to.
      character(len=*), intent(in) :: folder

      type(error_type), allocatable :: error
      type(hdf5_file_type) :: file
      type(hdf5_series_type) :: time, never
      character(len=1) :: none(0)

      call file%flush(error)
      call check_error(check, error, "no output file", "flush: no file open")
      call file%put_text("/text", "text", "text", error)
      call check_error(check, error, "no output file", "put_text: no file open")
      call file%abandon()
      call check(.not. file%is_open(), "abandon: no file open")

      call file%create(folder // "/misuse.h5", error)
      call file%create_series("/time", [integer ::], none, .true., 64, "s", "time", series_real, &
         time, error)
      call file%append(time, 3, [1.0_wp, 2.0_wp], error)
      call check_error(check, error, "too few values appended to /time", "append: short buffer")
      call file%append(time, 2, [1, 2], error)
      call check_error(check, error, "wrong type", "append: wrong type")
      call file%append(never, 1, [1.0_wp], error)
      call check_error(check, error, "never created", "append: series never created")
      call file%put_array("/mass", [1.0_wp], ["/nowhere"], "kg", "mass", error)
      call check_error(check, error, "/nowhere", "put_array: missing scale")
      call file%create_group("/fine", error)
      call check_error(check, error, "/nowhere", "create_group: after a failure")
      call file%close(error)
      call check_error(check, error, "/nowhere", "close: reports an earlier failure")
      call check(.not. file%is_open(), "close: nothing open after a failure")
   end subroutine test_misuse

   !> What was flushed before a file was given up is there, what came later is not.
   subroutine test_abandon(check, folder)
      !> Called once for each check.
      procedure(check_interface) :: check
      !> Folder to write to.
      character(len=*), intent(in) :: folder

      type(error_type), allocatable :: error
      type(hdf5_file_type) :: file
      type(hdf5_series_type) :: time
      character(len=1) :: none(0)
      real(wp) :: times(1000)

      times = 1.0_wp
      call file%create(folder // "/abandoned.h5", error)
      call file%put_attribute("/", "status", "running", error)
      call file%create_series("/time", [integer ::], none, .true., 64, "s", "time", series_real, &
         time, error)
      call file%append(time, 1000, times, error)
      call file%flush(error)
      call check(.not. allocated(error), "abandon: flushed before")
      call file%append(time, 1000, times, error)
      call file%put_attribute("/", "status", "failed", error)
      call file%abandon()
      call check(.not. file%is_open(), "abandon")
      call check(.not. is_locked(folder // "/abandoned.h5"), "abandon: lock released")
      call check_status(check, folder // "/abandoned.h5", "running", "abandoned file")
   end subroutine test_abandon

   !> A device that is always full.
   subroutine test_disk_full(check)
      !> Called once for each check.
      procedure(check_interface) :: check

      type(error_type), allocatable :: error
      type(hdf5_file_type) :: file

      if (.not. file_exists("/dev/full")) return
      call file%create("/dev/full", error)
      call check(allocated(error) .and. .not. file%is_open(), "create: full device")
   end subroutine test_disk_full

   !> Check the status of a file.
   subroutine check_status(check, path, expected, name)
      !> Called once for each check.
      procedure(check_interface) :: check
      !> Name of the file.
      character(len=*), intent(in) :: path
      !> Status that it should have.
      character(len=*), intent(in) :: expected
      !> What was checked.
      character(len=*), intent(in) :: name

      type(error_type), allocatable :: error
      character(len=:), allocatable :: status_text

      call readable_status(path, status_text, error)
      call check(.not. allocated(error) .and. status_text == expected, "status: " // name)
   end subroutine check_status

   !> Check that an error is set, has the right exit status and says something.
   subroutine check_error(check, error, fragment, name)
      !> Called once for each check.
      procedure(check_interface) :: check
      !> Error that should be set.
      type(error_type), allocatable, intent(in) :: error
      !> Part of its message.
      character(len=*), intent(in) :: fragment
      !> What was checked.
      character(len=*), intent(in) :: name

      logical :: passed

      passed = allocated(error)
      if (passed) passed = error%status == status_file .and. index(error%message, fragment) > 0
      call check(passed, name)
   end subroutine check_error

end module test_hdf5_file
