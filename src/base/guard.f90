!> Work in a process of its own, so that a library that crashes, hangs or takes all memory over a
!> damaged file becomes a message.
!>
!> `start_guard` splits the program in two. The worker does the work, ends with `finish_guard`, and
!> never returns to its caller; its standard output is that of the program. The other process calls
!> `wait_for_worker` and learns how it ended. C code that calls a library notes the file and the
!> object around each call; between two notes the worker may use five seconds of CPU.
module contensou_base_guard
   use, intrinsic :: iso_c_binding, only : c_char, c_double, c_int, c_null_char, c_size_t
   use contensou_base_errors, only : error_type, fatal, status_failed
   use contensou_base_kinds, only : wp
   implicit none(type, external)
   private

   public :: start_guard, finish_guard, wait_for_worker

   interface
      !> Split the program.
      function c_start(memory) result(side) bind(c, name="contensou_guard_start")
         import :: c_double, c_int
         implicit none(type, external)
         !> Bytes of address space that the worker may use.
         real(c_double), value :: memory
         !> 0 in the worker, 1 in the other process, -1 on failure.
         integer(c_int) :: side
      end function c_start

      !> End the worker.
      subroutine c_finish(status) bind(c, name="contensou_guard_finish")
         import :: c_int
         implicit none(type, external)
         integer(c_int), value :: status
      end subroutine c_finish

      !> Wait for the worker.
      function c_wait(status, inside, place, reason, output, size) result(finished) &
         bind(c, name="contensou_guard_wait")
         import :: c_char, c_int, c_size_t
         implicit none(type, external)
         !> Its exit status.
         integer(c_int), intent(out) :: status
         !> 1 if it was at work in a library.
         integer(c_int), intent(out) :: inside
         !> What it was reading; 2048 bytes.
         character(kind=c_char), intent(out) :: place(*)
         !> How it ended; 256 bytes.
         character(kind=c_char), intent(out) :: reason(*)
         !> What it wrote to the standard error.
         character(kind=c_char), intent(out) :: output(*)
         !> Room for that.
         integer(c_size_t), value :: size
         !> 1 if it came to its end.
         integer(c_int) :: finished
      end function c_wait
   end interface

contains

   !> Split the program in two.
   subroutine start_guard(memory, is_worker, error)
      !> Memory that the worker may use [bytes].
      real(wp), intent(in) :: memory
      logical, intent(out) :: is_worker
      !> Set when there can be no worker.
      type(error_type), allocatable, intent(out) :: error
      integer(c_int) :: side

      side = c_start(memory)
      is_worker = side == 0
      if (side < 0) call fatal(error, "no process can be started for the work", status_failed)
   end subroutine start_guard

   !> End the worker; does not return.
   subroutine finish_guard(status)
      integer, intent(in) :: status

      call c_finish(int(status, c_int))
   end subroutine finish_guard

   !> Wait for the worker and say how it ended.
   subroutine wait_for_worker(finished, status, inside, place, reason, output)
      !> Whether it called `finish_guard`.
      logical, intent(out) :: finished
      !> Its exit status.
      integer, intent(out) :: status
      !> Whether it was at work in a library.
      logical, intent(out) :: inside
      !> What it was reading.
      character(len=:), allocatable, intent(out) :: place
      !> How it ended, such as "Segmentation fault".
      character(len=:), allocatable, intent(out) :: reason
      !> What it wrote to the standard error, the first 64 KiB of it.
      character(len=:), allocatable, intent(out) :: output
      character(kind=c_char, len=2048) :: place_buffer
      character(kind=c_char, len=256) :: reason_buffer
      character(kind=c_char, len=65536) :: output_buffer
      integer(c_int) :: code, c_inside, c_finished

      c_finished = c_wait(code, c_inside, place_buffer, reason_buffer, output_buffer, &
         len(output_buffer, c_size_t))
      finished = c_finished /= 0
      status = int(code)
      inside = c_inside /= 0
      place = place_buffer(:index(place_buffer, c_null_char) - 1)
      reason = reason_buffer(:index(reason_buffer, c_null_char) - 1)
      output = output_buffer(:index(output_buffer, c_null_char) - 1)
   end subroutine wait_for_worker

end module contensou_base_guard
