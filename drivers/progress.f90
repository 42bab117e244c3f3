!> Progress of a command on stderr: a bar on a terminal, a line for each tenth elsewhere.
module contensou_drivers_progress
   use contensou_base_kinds, only : i8, wp
   use contensou_base_numbers, only : to_text
   use contensou_base_operating_system, only : is_terminal, obeys_escapes, terminal_width, &
      wall_seconds, write_stderr, write_terminal
   implicit none(type, external)
   private

   public :: progress_type

   !> Wall time between two changes of the bar [s].
   real(wp), parameter :: refresh = 0.1_wp

   !> Largest width of the bar.
   integer, parameter :: widest = 40

   !> What a terminal takes for: back to the beginning of the line, and clear it.
   character(len=*), parameter :: clear_line = achar(13) // achar(27) // "[K"

   !> How far a command is: a bar on a terminal, tenths elsewhere.
   type :: progress_type
      private
      logical :: shown = .false.
      !> Whether stderr is a terminal that obeys escape sequences.
      logical :: terminal = .false.
      !> Share of the work that was done before.
      real(wp) :: share_before = 0.0_wp
      !> Tenths that were told.
      integer :: tenths = 0
      !> Wall time at the beginning and of the last change of the bar [s].
      real(wp) :: start = 0.0_wp, last = 0.0_wp
   contains
      procedure :: begin
      procedure :: is_due
      procedure :: tell
      procedure :: note
      procedure :: stage
      procedure :: clear
   end type progress_type

contains

   !> Begin, or begin again where an earlier life has been: the clock runs from here on.
   subroutine begin(self, quiet, share)
      class(progress_type), intent(inout) :: self
      !> Whether nothing is to be written.
      logical, intent(in) :: quiet
      !> Share of the work that was done before, 0 to 1.
      real(wp), intent(in) :: share

      self%shown = .not. quiet
      self%terminal = is_terminal(2)
      if (self%terminal) self%terminal = obeys_escapes()
      self%share_before = share
      self%tenths = int(10.0_wp*share)
      self%start = wall_seconds()
      self%last = self%start
   end subroutine begin

   !> Whether there is something to tell: cheap, to be asked before words are made for `tell`.
   logical function is_due(self, share)
      class(progress_type), intent(in) :: self
      !> Share of the work that is done, 0 to 1.
      real(wp), intent(in) :: share

      is_due = self%shown .and. share > self%share_before
      if (.not. is_due) return
      if (self%terminal) then
         is_due = wall_seconds() - self%last >= refresh
      else
         is_due = int(10.0_wp*share) > self%tenths
      end if
   end function is_due

   !> Tell how far the work is.
   subroutine tell(self, share, words)
      !> The progress; `is_due`.
      class(progress_type), intent(inout) :: self
      !> Share of the work that is done, 0 to 1.
      real(wp), intent(in) :: share
      !> What is done, in words.
      character(len=*), intent(in) :: words
      character(len=:), allocatable :: text
      integer :: filled, width

      self%last = wall_seconds()
      self%tenths = int(10.0_wp*share)
      text = " %, " // words // ", " // time_left(self, share) // " left"
      if (self%terminal) then
         text = "] " // to_text(int(100.0_wp*share)) // text
         width = max(min(widest, terminal_width() - len(text) - 2), 0)
         filled = int(share*width)
         call write_terminal(clear_line)
         call write_stderr("[" // repeat("#", filled) // repeat(" ", width - filled) // text)
      else
         call write_stderr("contensou: " // to_text(10*self%tenths) // text // new_line("a"))
      end if
   end subroutine tell

   !> Wall time to the end if the work goes on at the pace so far, in words.
   function time_left(self, share) result(text)
      class(progress_type), intent(in) :: self
      !> Share of the work that is done, above that at the beginning.
      real(wp), intent(in) :: share
      character(len=:), allocatable :: text
      integer(i8) :: seconds

      seconds = nint(min((self%last - self%start)*(1.0_wp - share)/(share - self%share_before), &
         1.0e9_wp), i8)
      text = to_text(seconds) // " s"
      if (seconds >= 120) text = to_text(seconds/60) // " min"
      if (seconds >= 7200) text = to_text(seconds/3600) // " h " // &
         to_text(mod(seconds, 3600_i8)/60) // " min"
   end function time_left

   !> Write a line of its own.
   subroutine note(self, words)
      class(progress_type), intent(in) :: self
      character(len=*), intent(in) :: words

      call self%clear()
      if (self%shown) call write_stderr("contensou: " // words // new_line("a"))
   end subroutine note

   !> Tell what begins, where nobody knows what share of the work it is: on a terminal in place of
   !> the bar, elsewhere as a line.
   subroutine stage(self, words)
      class(progress_type), intent(in) :: self
      !> What begins.
      character(len=*), intent(in) :: words

      if (self%shown .and. self%terminal) then
         call write_terminal(clear_line)
         call write_stderr(words)
      else
         call self%note(words)
      end if
   end subroutine stage

   !> Remove the bar from the terminal.
   subroutine clear(self)
      class(progress_type), intent(in) :: self

      if (self%shown .and. self%terminal) call write_terminal(clear_line)
   end subroutine clear

end module contensou_drivers_progress
