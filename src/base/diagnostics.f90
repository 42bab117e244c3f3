!> Mistakes in a text that a user wrote, and how they are shown.
!>
!> Each mistake knows where it is, so that all of them can be reported at once in the form
!> that compilers use: file, line and column, the line itself, a caret, and what would be right.
module contensou_base_diagnostics
   use contensou_base_numbers, only : to_text
   use contensou_base_text, only : string_type, utf8_length
   implicit none(type, external)
   private

   public :: origin_type, source_type, diagnostics_type

   !> Place of something in the text it was read from.
   type :: origin_type
      !> Index of the source in the document; 0 if there is none.
      integer :: source = 0
      !> Line, from 1; 0 stands for the source as a whole.
      integer :: line = 0
      !> First byte in the line, from 1.
      integer :: column = 0
      !> Number of bytes.
      integer :: length = 1
   end type origin_type

   !> A text that was read: a file, or a setting from the command line.
   type :: source_type
      !> Name as the user gave it.
      character(len=:), allocatable :: name
      !> Its lines without line ends.
      type(string_type), allocatable :: lines(:)
   end type source_type

   !> One mistake.
   type :: entry_type
      type(origin_type) :: origin
      character(len=:), allocatable :: message
      !> What would be right; not allocated if there is nothing to say.
      character(len=:), allocatable :: expected
   end type entry_type

   !> A growing list of mistakes.
   type :: diagnostics_type
      private
      !> The mistakes in the order in which they were found.
      type(entry_type), allocatable :: entries(:)
      !> Number of mistakes in the list.
      integer :: n_entries = 0
      !> Number of mistakes found; beyond `max_kept` they are only counted.
      integer :: n_found = 0
   contains
      procedure :: add
      procedure :: count => count_entries
      procedure :: is_full
      procedure :: kept
      procedure :: origin => entry_origin
      procedure :: message => entry_message
      procedure :: expected => entry_expected
      procedure :: render
   end type diagnostics_type

   !> Number of mistakes that are kept.
   integer, parameter :: max_kept = 200

   !> Number of earlier mistakes that a new one is compared with.
   integer, parameter :: look_back = 16

   !> Number of mistakes that are shown.
   integer, parameter :: max_shown = 100

   !> Number of characters of a source line that are shown.
   integer, parameter :: window = 100

   !> Characters shown before the caret in a line that is cut.
   integer, parameter :: window_before = 40

   !> Line end of the rendered text.
   character(len=1), parameter :: newline = achar(10)

   !> Horizontal tab.
   character(len=1), parameter :: tab = achar(9)

contains

   !> Append a mistake, unless it was found at the same place just before: an option that sets a
   !> key of several groups is looked at once for each.
   pure subroutine add(self, origin, message, expected)
      class(diagnostics_type), intent(inout) :: self
      type(origin_type), intent(in) :: origin
      !> What is wrong; one line.
      character(len=*), intent(in) :: message
      !> What would be right; one line.
      character(len=*), intent(in), optional :: expected
      type(entry_type), allocatable :: bigger(:)
      integer :: i

      do i = self%n_entries, max(self%n_entries - look_back, 1), -1
         associate (entry => self%entries(i))
            if (entry%origin%source == origin%source .and. entry%origin%line == origin%line .and. &
               entry%origin%column == origin%column .and. entry%message == message) return
         end associate
      end do
      self%n_found = self%n_found + 1
      if (self%n_entries == max_kept) return
      if (.not. allocated(self%entries)) allocate(self%entries(8))
      if (self%n_entries == size(self%entries)) then
         allocate(bigger(2*self%n_entries))
         do i = 1, self%n_entries
            bigger(i)%origin = self%entries(i)%origin
            call move_alloc(self%entries(i)%message, bigger(i)%message)
            call move_alloc(self%entries(i)%expected, bigger(i)%expected)
         end do
         call move_alloc(bigger, self%entries)
      end if
      i = self%n_entries + 1
      self%n_entries = i
      self%entries(i)%origin = origin
      self%entries(i)%message = message
      if (present(expected)) self%entries(i)%expected = expected
   end subroutine add

   !> Number of mistakes.
   pure integer function count_entries(self)
      class(diagnostics_type), intent(in) :: self

      count_entries = self%n_found
   end function count_entries

   !> Whether further mistakes are only counted.
   pure logical function is_full(self)
      class(diagnostics_type), intent(in) :: self

      is_full = self%n_entries == max_kept
   end function is_full

   !> Number of mistakes that are kept; `origin`, `message` and `expected` take 1 to this.
   pure integer function kept(self)
      class(diagnostics_type), intent(in) :: self

      kept = self%n_entries
   end function kept

   !> Place of a mistake.
   pure function entry_origin(self, i) result(origin)
      class(diagnostics_type), intent(in) :: self
      !> Index in the order in which the mistakes were found.
      integer, intent(in) :: i
      type(origin_type) :: origin

      origin = self%entries(i)%origin
   end function entry_origin

   !> What is wrong at a mistake.
   pure function entry_message(self, i) result(message)
      class(diagnostics_type), intent(in) :: self
      !> Index in the order in which the mistakes were found.
      integer, intent(in) :: i
      character(len=:), allocatable :: message

      message = self%entries(i)%message
   end function entry_message

   !> What would be right at a mistake; empty if there is nothing to say.
   pure function entry_expected(self, i) result(expected)
      class(diagnostics_type), intent(in) :: self
      !> Index in the order in which the mistakes were found.
      integer, intent(in) :: i
      character(len=:), allocatable :: expected

      expected = ""
      if (allocated(self%entries(i)%expected)) expected = self%entries(i)%expected
   end function entry_expected

   !> Text that shows the mistakes, sorted by place; each line ends with a line end.
   pure function render(self, sources, kind) result(text)
      class(diagnostics_type), intent(in) :: self
      !> Sources that the places refer to.
      type(source_type), intent(in) :: sources(:)
      !> What they are, "error" if not given.
      character(len=*), intent(in), optional :: kind
      !> The text; empty if there are no mistakes.
      character(len=:), allocatable :: text
      character(len=:), allocatable :: word
      integer, allocatable :: order(:)
      integer :: i, n_more

      text = ""
      word = "error"
      if (present(kind)) word = kind
      call sort(self, order)
      do i = 1, min(self%n_entries, max_shown)
         text = text // render_entry(self%entries(order(i)), sources, word)
      end do
      n_more = self%n_found - max_shown
      if (n_more == 1) then
         text = text // "... and 1 more " // word // newline
      else if (n_more > 1) then
         text = text // "... and " // to_text(n_more) // " more " // word // "s" // newline
      end if
   end function render

   !> Order of the mistakes by source, line and column; equal places keep their order.
   pure subroutine sort(self, order)
      class(diagnostics_type), intent(in) :: self
      !> Indices of the mistakes in their new order.
      integer, allocatable, intent(out) :: order(:)
      integer :: i, j

      allocate(order(self%n_entries))
      do i = 1, self%n_entries
         j = i - 1
         do while (j > 0)
            if (.not. comes_before(self%entries(i)%origin, self%entries(order(j))%origin)) exit
            order(j + 1) = order(j)
            j = j - 1
         end do
         order(j + 1) = i
      end do
   end subroutine sort

   !> Whether a place comes before another.
   pure logical function comes_before(a, b)
      !> First place.
      type(origin_type), intent(in) :: a
      !> Second place.
      type(origin_type), intent(in) :: b

      if (a%source /= b%source) then
         comes_before = a%source < b%source
      else if (a%line /= b%line) then
         comes_before = a%line < b%line
      else
         comes_before = a%column < b%column
      end if
   end function comes_before

   !> Text that shows one mistake.
   pure function render_entry(entry, sources, kind) result(text)
      type(entry_type), intent(in) :: entry
      !> Sources that its place refers to.
      type(source_type), intent(in) :: sources(:)
      !> What it is.
      character(len=*), intent(in) :: kind
      character(len=:), allocatable :: text
      character(len=:), allocatable :: excerpt
      type(origin_type) :: origin
      integer :: column
      logical :: has_line

      origin = entry%origin
      text = ""
      excerpt = ""
      if (origin%source >= 1 .and. origin%source <= size(sources)) then
         if (allocated(sources(origin%source)%name)) then
            text = printable(sources(origin%source)%name)
         end if
         if (origin%line > 0) then
            column = origin%column
            has_line = .false.
            if (allocated(sources(origin%source)%lines)) then
               has_line = origin%line <= size(sources(origin%source)%lines)
            end if
            if (has_line) then
               call render_excerpt(sources(origin%source)%lines(origin%line)%s, origin, &
                  column, excerpt)
            end if
            text = text // ":" // to_text(origin%line) // ":" // to_text(column)
         end if
         text = text // ": "
      end if
      text = text // kind // ": " // printable(entry%message) // newline // excerpt
      if (allocated(entry%expected)) then
         text = text // "  expected: " // printable(entry%expected) // newline
      end if
   end function render_entry

   !> The line of a mistake, and below it a caret; a long line is cut around the caret.
   pure subroutine render_excerpt(line, origin, column, excerpt)
      !> Source line.
      character(len=*), intent(in) :: line
      type(origin_type), intent(in) :: origin
      !> Column of the mistake in characters, from 1.
      integer, intent(out) :: column
      !> The two lines.
      character(len=:), allocatable, intent(out) :: excerpt
      ! Bytes at which the last characters before the caret begin, as a ring.
      integer :: starts(0:window - 1)
      character(len=:), allocatable :: carets, gutter, number, shown
      integer :: byte, caret_byte, first, first_byte, i, last_byte, n_after, n_before
      logical :: cut_left, cut_right

      starts = 1
      caret_byte = max(1, min(origin%column, len(line) + 1))
      byte = 1
      n_before = 0
      do while (byte < caret_byte)
         starts(modulo(n_before, window)) = byte
         n_before = n_before + 1
         byte = byte + max(1, character_length(line, byte))
      end do
      caret_byte = byte
      column = n_before + 1

      n_after = 0
      do while (byte <= len(line) .and. n_after < window)
         n_after = n_after + 1
         byte = byte + max(1, character_length(line, byte))
      end do

      ! Number of characters that are left out at the beginning.
      first = 0
      if (byte <= len(line)) then
         first = max(0, n_before - window_before)
      else if (n_before + n_after > window) then
         first = max(0, min(n_before - window_before, n_before + n_after - window))
      end if
      cut_left = first > 0
      first_byte = 1
      if (cut_left) first_byte = starts(modulo(first, window))
      if (first == n_before) first_byte = caret_byte
      byte = caret_byte
      do i = 1, window - (n_before - first)
         if (byte > len(line)) exit
         byte = byte + max(1, character_length(line, byte))
      end do
      last_byte = byte - 1
      cut_right = byte <= len(line)

      shown = printable(line(first_byte:last_byte))
      carets = blank_out(line(first_byte:caret_byte - 1)) // "^"
      byte = caret_byte + max(1, character_length(line, caret_byte))
      do while (byte <= last_byte .and. byte < origin%column + origin%length)
         carets = carets // "~"
         byte = byte + max(1, character_length(line, byte))
      end do
      if (cut_left) then
         shown = "..." // shown
         carets = "   " // carets
      end if
      if (cut_right) shown = shown // "..."

      number = to_text(origin%line)
      gutter = repeat(" ", max(5, len(number)))
      excerpt = gutter(len(number) + 1:) // number // " | " // shown // newline // &
         gutter // " | " // carets // newline
   end subroutine render_excerpt

   !> Text with bytes that cannot be printed replaced by `?`; tabs stay.
   pure function printable(s) result(t)
      character(len=*), intent(in) :: s
      !> Text that is safe to print.
      character(len=:), allocatable :: t
      integer :: i, n

      t = s
      i = 1
      do while (i <= len(s))
         n = character_length(s, i)
         if (n == 0 .and. s(i:i) /= tab) t(i:i) = "?"
         i = i + max(1, n)
      end do
   end function printable

   !> As many blanks as a text has characters, with its tabs kept.
   pure function blank_out(s) result(t)
      character(len=*), intent(in) :: s
      character(len=:), allocatable :: t
      integer :: i

      t = ""
      i = 1
      do while (i <= len(s))
         if (s(i:i) == tab) then
            t = t // tab
         else
            t = t // " "
         end if
         i = i + max(1, character_length(s, i))
      end do
   end function blank_out

   !> Number of bytes of the printable character of UTF-8 that begins at a byte; 0 if none does.
   pure function character_length(s, i) result(n)
      character(len=*), intent(in) :: s
      !> Index of the byte.
      integer, intent(in) :: i
      !> The number of bytes, 0 to 4.
      integer :: n
      integer :: second, third

      n = 0
      if (i > len(s)) return
      n = utf8_length(s, i)
      select case (ichar(s(i:i)))
      case (0:31, 127)
         n = 0
      case (194)
         ! C1 controls.
         if (n == 2) then
            if (ichar(s(i + 1:i + 1)) < 160) n = 0
         end if
      case (226)
         ! Marks, overrides and isolates of the direction, and ends of lines.
         if (n == 3) then
            second = ichar(s(i + 1:i + 1))
            third = ichar(s(i + 2:i + 2))
            if (second == 128 .and. (any(third == [142, 143]) .or. (third >= 168 .and. &
               third <= 174))) n = 0
            if (second == 129 .and. third >= 166 .and. third <= 169) n = 0
         end if
      case default
         continue
      end select
   end function character_length

end module contensou_base_diagnostics
