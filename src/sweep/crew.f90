!> Many independent pieces of work on many threads of one process, such that a piece that crashes
!> or hangs takes at most itself.
!>
!> `run_crew` starts a worker process whose threads take the pieces in order, and watches it. A
!> piece during which the worker dies is done again alone, in a process of its own; if that dies,
!> too, or if the piece does not end long after its time limit, it is given up and the others go
!> on. If the program is killed the worker ends with it. What a piece leaves must be in a file: the
!> memory of the worker is not that of the caller.
!>
!> Threads that handle texts do so between `lock_texts` and `unlock_texts` of base.
module contensou_sweep_crew
   use, intrinsic :: iso_c_binding, only : c_char, c_double, c_f_pointer, c_funloc, c_funptr, &
      c_int, c_int64_t, c_loc, c_null_char, c_ptr
   use contensou_base_errors, only : error_type, fatal, status_failed, status_file
   use contensou_base_kinds, only : i8, wp
   use contensou_base_operating_system, only : reason_of, text_from_c
   implicit none(type, external)
   private

   public :: job_type, run_crew, available_cores
   public :: hold_signals, stop_requested, begin_piece, crew_stopping
   public :: piece_done, piece_stopped

   integer, parameter :: piece_done = 0

   !> The piece was left because all stop.
   integer, parameter :: piece_stopped = -1

   !> What there is to do, in pieces from 1 on.
   type, abstract :: job_type
   contains
      !> In a thread of the worker: do a piece.
      procedure(work_interface), deferred :: work
      !> Anywhere: whether a piece is done already.
      procedure(done_interface), deferred :: done
      !> In the caller's process: a piece is given up.
      procedure(lost_interface), deferred :: lost
      !> In the caller's process, ten times a second: how far it is.
      procedure(look_interface), deferred :: look
   end type job_type

   abstract interface
      !> Do a piece. Called by many threads at once; calls `begin_piece` when it really begins.
      subroutine work_interface(self, thread, piece, code)
         import :: i8, job_type
         implicit none(type, external)
         class(job_type), intent(in) :: self
         !> Number of the thread, from 0.
         integer, intent(in) :: thread
         integer(i8), intent(in) :: piece
         !> `piece_done`, `piece_stopped`, or a value of errno to end everything.
         integer, intent(out) :: code
      end subroutine work_interface

      !> Whether a piece is done already. Called by many threads at once.
      logical function done_interface(self, piece)
         import :: i8, job_type
         implicit none(type, external)
         class(job_type), intent(in) :: self
         integer(i8), intent(in) :: piece
      end function done_interface

      !> A piece is given up.
      subroutine lost_interface(self, piece, late, reason, code)
         import :: i8, job_type
         implicit none(type, external)
         class(job_type), intent(inout) :: self
         integer(i8), intent(in) :: piece
         !> Whether it did not end in time; otherwise its process died.
         logical, intent(in) :: late
         !> How that died, such as "Segmentation fault".
         character(len=*), intent(in) :: reason
         !> 0, or a value of errno to end everything.
         integer, intent(out) :: code
      end subroutine lost_interface

      !> Look at the progress.
      subroutine look_interface(self, finished)
         import :: i8, job_type
         implicit none(type, external)
         class(job_type), intent(inout) :: self
         !> Pieces that workers have done.
         integer(i8), intent(in) :: finished
      end subroutine look_interface
   end interface

   !> A job behind an address that C can hold.
   type :: holder_type
      class(job_type), pointer :: job => null()
   end type holder_type

   ! Functions of C. One that acts returns 0 or errno.
   interface
      !> Cores that this process may use.
      integer(c_int) function available_cores() bind(c, name="contensou_crew_cores")
         import :: c_int
         implicit none(type, external)
      end function available_cores

      !> Keep the signals that ask to stop for `stop_requested` and `run_crew`.
      subroutine hold_signals() bind(c, name="contensou_crew_hold_signals")
         implicit none(type, external)
      end subroutine hold_signals

      !> In a worker: the clock of a piece begins now.
      subroutine c_begin(thread) bind(c, name="contensou_crew_begin")
         import :: c_int
         implicit none(type, external)
         integer(c_int), value :: thread
      end subroutine c_begin

      !> In a worker: whether all are to stop.
      integer(c_int) function c_stopping() bind(c, name="contensou_crew_stopping")
         import :: c_int
         implicit none(type, external)
      end function c_stopping

      !> Whether a signal has asked to stop.
      integer(c_int) function c_stop_requested() bind(c, name="contensou_crew_stop_requested")
         import :: c_int
         implicit none(type, external)
      end function c_stop_requested

      !> Do all pieces.
      function c_run(context, pieces, threads, time_limit, work, done, lost, look, reason) &
         result(code) bind(c, name="contensou_crew_run")
         import :: c_char, c_double, c_funptr, c_int, c_int64_t, c_ptr
         implicit none(type, external)
         !> What the functions get.
         type(c_ptr), value :: context
         integer(c_int64_t), value :: pieces
         integer(c_int), value :: threads
         !> Time limit of a piece [s].
         real(c_double), value :: time_limit
         !> Do a piece.
         type(c_funptr), value :: work
         !> Whether a piece is done.
         type(c_funptr), value :: done
         !> A piece is given up.
         type(c_funptr), value :: lost
         !> Look at the progress.
         type(c_funptr), value :: look
         !> How the worker died that cannot be kept alive; 512 bytes.
         character(kind=c_char), intent(out) :: reason(*)
         !> 0 complete, -1 stopped, -2 broken, or errno.
         integer(c_int) :: code
      end function c_run
   end interface

contains

   !> Do all pieces of a job that are not done.
   subroutine run_crew(job, pieces, threads, time_limit, stopped, error)
      class(job_type), intent(inout), target :: job
      integer(i8), intent(in) :: pieces
      integer, intent(in) :: threads
      !> Wall time of a piece after which, and some more, it is given up [s].
      real(wp), intent(in) :: time_limit
      !> Whether a signal asked to stop before all were done.
      logical, intent(out) :: stopped
      !> Set when the work cannot go on; `status_file` if its results cannot be written.
      type(error_type), allocatable, intent(out) :: error
      type(holder_type), target :: holder
      character(kind=c_char, len=512) :: buffer
      integer(c_int) :: code

      holder%job => job
      code = c_run(c_loc(holder), pieces, int(threads, c_int), time_limit, &
         c_funloc(work_callback), c_funloc(done_callback), c_funloc(lost_callback), &
         c_funloc(look_callback), buffer)
      stopped = code == -1
      if (code == -2) then
         call fatal(error, "the processes for the work end at once: " // &
            buffer(:index(buffer, c_null_char) - 1), status_failed)
      else if (code > 0) then
         call fatal(error, reason_of(code), status_file)
      end if
   end subroutine run_crew

   !> In a worker: the clock of the piece in hand begins now.
   subroutine begin_piece(thread)
      integer, intent(in) :: thread

      call c_begin(int(thread, c_int))
   end subroutine begin_piece

   !> In a worker: whether all are to stop; costs one load.
   logical function crew_stopping()

      crew_stopping = c_stopping() /= 0
   end function crew_stopping

   !> Whether a signal has asked to stop since `hold_signals`.
   logical function stop_requested()

      stop_requested = c_stop_requested() /= 0
   end function stop_requested

   !> Do a piece.
   function work_callback(context, thread, piece) result(code) bind(c, name="")
      !> The holder.
      type(c_ptr), value :: context
      integer(c_int), value :: thread
      !> Number of the piece, from 0.
      integer(c_int64_t), value :: piece
      integer(c_int) :: code
      type(holder_type), pointer :: holder
      integer :: outcome

      call c_f_pointer(context, holder)
      call holder%job%work(int(thread), piece + 1, outcome)
      code = int(outcome, c_int)
   end function work_callback

   !> Whether a piece is done.
   function done_callback(context, piece) result(answer) bind(c, name="")
      !> The holder.
      type(c_ptr), value :: context
      !> Number of the piece, from 0.
      integer(c_int64_t), value :: piece
      integer(c_int) :: answer
      type(holder_type), pointer :: holder
      logical :: done

      call c_f_pointer(context, holder)
      done = holder%job%done(piece + 1)
      answer = merge(1_c_int, 0_c_int, done)
   end function done_callback

   !> A piece is given up.
   function lost_callback(context, piece, late, reason) result(code) bind(c, name="")
      !> The holder.
      type(c_ptr), value :: context
      !> Number of the piece, from 0.
      integer(c_int64_t), value :: piece
      !> 1 if it did not end in time.
      integer(c_int), value :: late
      !> How its process died.
      type(c_ptr), value :: reason
      integer(c_int) :: code
      type(holder_type), pointer :: holder
      integer :: outcome

      call c_f_pointer(context, holder)
      call holder%job%lost(piece + 1, late /= 0, text_from_c(reason), outcome)
      code = int(outcome, c_int)
   end function lost_callback

   !> Look at the progress.
   subroutine look_callback(context, finished) bind(c, name="")
      !> The holder.
      type(c_ptr), value :: context
      !> Pieces that workers have done.
      integer(c_int64_t), value :: finished
      type(holder_type), pointer :: holder

      call c_f_pointer(context, holder)
      call holder%job%look(finished)
   end subroutine look_callback

end module contensou_sweep_crew
