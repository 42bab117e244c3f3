!> The one error type of the library, and the exit statuses a driver maps it to.
!>
!> A procedure that can fail takes `type(error_type), allocatable, intent(out) :: error` as its
!> last argument; unallocated means success. Only a driver stops the program.
module contensou_base_errors
   implicit none(type, external)
   private

   public :: error_type, fatal
   public :: status_ok, status_failed, status_usage, status_file, status_interrupted

   !> Everything went well.
   integer, parameter :: status_ok = 0

   !> The run failed (integrator, model outside its domain).
   integer, parameter :: status_failed = 1

   !> Bad usage of the command line, or a bad scene.
   integer, parameter :: status_usage = 2

   !> A file could not be read or written (EX_IOERR of sysexits.h).
   integer, parameter :: status_file = 74

   !> Stopped by a signal; what was computed is readable (EX_TEMPFAIL of sysexits.h).
   integer, parameter :: status_interrupted = 75

   !> A message for the user and the exit status that goes with it.
   type :: error_type
      !> Text for the user, without a leading "error:"; may span lines.
      character(len=:), allocatable :: message
      !> Exit status of the program that gives up because of it.
      integer :: status = status_failed
   end type error_type

contains

   !> Set an error.
   pure subroutine fatal(error, message, status)
      type(error_type), allocatable, intent(out) :: error
      character(len=*), intent(in) :: message
      !> Exit status, one of the `status_*` parameters; default `status_failed`.
      integer, intent(in), optional :: status

      allocate(error)
      error%message = message
      if (present(status)) error%status = status
   end subroutine fatal

end module contensou_base_errors
