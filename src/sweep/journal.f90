!> A file of results of fixed size, one slot for each of a known number of pieces of work, written
!> by many threads in any order and readable however the writers ended: what is half written counts
!> as missing. A process that opens it holds its lock; a process that it starts may go on writing.
module contensou_sweep_journal
   use, intrinsic :: iso_c_binding, only : c_associated, c_char, c_double, c_int, c_int64_t, &
      c_null_char, c_null_ptr, c_ptr
   use contensou_base_errors, only : error_type, fatal, status_file
   use contensou_base_kinds, only : i8, wp
   use contensou_base_operating_system, only : reason_of
   implicit none(type, external)
   private

   public :: journal_type, journal_message_length, journal_bytes

   !> Longest message that is kept [characters].
   integer, parameter :: journal_message_length = 4096

   !> An open journal.
   type :: journal_type
      private
      !> Number of slots.
      integer(i8), public :: count = 0
      !> Numbers in a slot.
      integer, public :: columns = 0
      !> The journal of the C side.
      type(c_ptr) :: handle = c_null_ptr
   contains
      procedure, public :: open
      procedure, public :: write
      procedure, public :: has
      procedure, public :: read
      procedure, public :: sync
      procedure, public :: close
   end type journal_type

   ! Functions of C. One that acts returns 0 or errno.
   interface
      !> Open or create a journal.
      function c_open(path, key, count, columns, replace, outcome) result(handle) &
         bind(c, name="contensou_journal_open")
         import :: c_char, c_int, c_int64_t, c_ptr
         implicit none(type, external)
         !> Name, null-terminated.
         character(kind=c_char), intent(in) :: path(*)
         !> What it is about, null-terminated.
         character(kind=c_char), intent(in) :: key(*)
         !> Number of slots.
         integer(c_int64_t), value :: count
         !> Numbers in a slot.
         integer(c_int64_t), value :: columns
         !> Whether another journal may be overwritten.
         integer(c_int), value :: replace
         !> 0 new, -1 there before, -2 about something else, -3 locked, -4 damaged, or errno.
         integer(c_int), intent(out) :: outcome
         !> The journal; null on failure.
         type(c_ptr) :: handle
      end function c_open

      !> Fill a slot.
      integer(c_int) function c_write(handle, position, number, status, values, message, length) &
         bind(c, name="contensou_journal_write")
         import :: c_char, c_double, c_int, c_int64_t, c_ptr
         implicit none(type, external)
         !> The journal.
         type(c_ptr), value :: handle
         !> Slot, from 0.
         integer(c_int64_t), value :: position
         !> Number of the case.
         integer(c_int64_t), value :: number
         integer(c_int), value :: status
         real(c_double), intent(in) :: values(*)
         character(kind=c_char), intent(in) :: message(*)
         !> Characters of it.
         integer(c_int64_t), value :: length
      end function c_write

      !> Whether a slot is filled.
      integer(c_int) function c_has(handle, position) bind(c, name="contensou_journal_has")
         import :: c_int, c_int64_t, c_ptr
         implicit none(type, external)
         !> The journal.
         type(c_ptr), value :: handle
         !> Slot, from 0.
         integer(c_int64_t), value :: position
      end function c_has

      !> Content of a slot.
      function c_read(handle, position, number, status, values, message, length) result(code) &
         bind(c, name="contensou_journal_read")
         import :: c_char, c_double, c_int, c_int64_t, c_ptr
         implicit none(type, external)
         !> The journal.
         type(c_ptr), value :: handle
         !> Slot, from 0.
         integer(c_int64_t), value :: position
         !> Number of the case.
         integer(c_int64_t), intent(out) :: number
         integer(c_int), intent(out) :: status
         real(c_double), intent(out) :: values(*)
         !> Message; 4096 bytes.
         character(kind=c_char), intent(out) :: message(*)
         !> Characters of it.
         integer(c_int64_t), intent(out) :: length
         !> 1 filled, 0 not, or minus errno.
         integer(c_int) :: code
      end function c_read

      !> Bring what is written to the disk.
      integer(c_int) function c_sync(handle) bind(c, name="contensou_journal_sync")
         import :: c_int, c_ptr
         implicit none(type, external)
         !> The journal.
         type(c_ptr), value :: handle
      end function c_sync

      !> Close a journal.
      subroutine c_close(handle) bind(c, name="contensou_journal_close")
         import :: c_ptr
         implicit none(type, external)
         !> The journal.
         type(c_ptr), value :: handle
      end subroutine c_close
   end interface

contains

   !> Bytes that a journal takes for each piece of work, as in the C source.
   pure real(wp) function journal_bytes(columns)
      !> Numbers in a slot.
      integer, intent(in) :: columns

      journal_bytes = 40.0_wp + 8.0_wp*columns
   end function journal_bytes

   !> Open a journal, or create it.
   subroutine open(self, path, key, count, columns, replace, again, error)
      class(journal_type), intent(inout) :: self
      character(len=*), intent(in) :: path
      !> What the work is; one that was begun for something else is refused. Up to 2000 characters.
      character(len=*), intent(in) :: key
      !> Number of slots.
      integer(i8), intent(in) :: count
      !> Numbers in a slot.
      integer, intent(in) :: columns
      !> Whether one that was begun for something else is overwritten.
      logical, intent(in) :: replace
      !> Whether it was there before.
      logical, intent(out) :: again
      !> Set when it cannot be opened, or is refused.
      type(error_type), allocatable, intent(out) :: error
      integer(c_int) :: outcome

      self%count = count
      self%columns = columns
      self%handle = c_open(path // c_null_char, key // c_null_char, count, &
         int(columns, c_int64_t), merge(1_c_int, 0_c_int, replace), outcome)
      again = outcome == -1
      if (c_associated(self%handle)) return
      select case (outcome)
      case (-2)
         call fatal(error, path // " is not of this sweep and these cases; --force replaces it, " &
            // "-o FILE writes another one", status_file)
      case (-4)
         call fatal(error, path // " is damaged, or was not left by a sweep; --force " // &
            "replaces it, -o FILE writes another one", status_file)
      case (-3)
         call fatal(error, "another process is writing " // path, status_file)
      case default
         call fatal(error, "cannot write " // path // ": " // reason_of(outcome), &
            status_file)
      end select
   end subroutine open

   !> Fill a slot. Thread-safe.
   subroutine write(self, position, number, status, values, message, code)
      class(journal_type), intent(in) :: self
      !> Slot, from 1.
      integer(i8), intent(in) :: position
      !> Number of the case.
      integer(i8), intent(in) :: number
      integer, intent(in) :: status
      !> Numbers, as many as there are columns.
      real(wp), intent(in) :: values(:)
      character(len=*), intent(in) :: message
      !> 0, or a value of errno.
      integer, intent(out) :: code

      code = int(c_write(self%handle, position - 1, number, int(status, c_int), values, message, &
         len(message, c_int64_t)))
   end subroutine write

   !> Whether a slot is filled. Thread-safe.
   logical function has(self, position)
      class(journal_type), intent(in) :: self
      !> Slot, from 1.
      integer(i8), intent(in) :: position

      has = c_has(self%handle, position - 1) /= 0
   end function has

   !> Content of a slot.
   subroutine read(self, position, found, number, status, values, message, length, error)
      class(journal_type), intent(in) :: self
      !> Slot, from 1.
      integer(i8), intent(in) :: position
      !> Whether it is filled.
      logical, intent(out) :: found
      !> Number of the case.
      integer(i8), intent(out) :: number
      integer, intent(out) :: status
      !> Numbers, as many as there are columns.
      real(wp), intent(out) :: values(:)
      character(len=journal_message_length), intent(out) :: message
      !> Characters of it.
      integer, intent(out) :: length
      type(error_type), allocatable, intent(out) :: error
      integer(c_int) :: code, c_status
      integer(c_int64_t) :: c_length

      number = 0
      c_status = 0
      c_length = 0
      code = c_read(self%handle, position - 1, number, c_status, values, message, c_length)
      found = code == 1
      status = int(c_status)
      length = int(c_length)
      if (code < 0) call fatal(error, "cannot read the journal of the sweep: " // &
         reason_of(-code), status_file)
   end subroutine read

   !> Bring what is written to the disk.
   subroutine sync(self, error)
      class(journal_type), intent(in) :: self
      type(error_type), allocatable, intent(out) :: error
      integer(c_int) :: code

      code = c_sync(self%handle)
      if (code /= 0) call fatal(error, "cannot write the journal of the sweep: " // &
         reason_of(code), status_file)
   end subroutine sync

   !> Close it; the lock ends.
   subroutine close(self)
      class(journal_type), intent(inout) :: self

      call c_close(self%handle)
      self%handle = c_null_ptr
   end subroutine close

end module contensou_sweep_journal
