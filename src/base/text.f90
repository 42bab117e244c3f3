!> Small tools for text: case, quoting, lists, and the nearest known word.
module contensou_base_text
   implicit none(type, external)
   private

   public :: string_type, text_buffer_type
   public :: lower, quote, pad, plural, right, strings, join, shorten, starts_with
   public :: edit_distance, nearest, did_you_mean, command_text
   public :: utf8_length, invalid_byte, invalid_byte_text, valid_utf8

   !> A text of its own length, for lists of texts.
   type :: string_type
      character(len=:), allocatable :: s
   end type string_type

   !> A long text in the making; it grows by doubling.
   type :: text_buffer_type
      private
      !> The text so far and room for more.
      character(len=:), allocatable :: bytes
      !> Length of the text.
      integer :: n = 0
   contains
      procedure :: add => add_text
      procedure :: text => buffered_text
   end type text_buffer_type

   !> Index of the candidate nearest to a word, 0 if none is near.
   interface nearest
      module procedure :: nearest_character
      module procedure :: nearest_string
   end interface nearest

   !> Shortest word that may match as a part of a candidate.
   integer, parameter :: shortest_part = 3

contains

   !> Append a text to a buffer.
   pure subroutine add_text(self, text)
      class(text_buffer_type), intent(inout) :: self
      character(len=*), intent(in) :: text
      character(len=:), allocatable :: bigger

      if (.not. allocated(self%bytes)) allocate(character(len=256) :: self%bytes)
      if (self%n + len(text) > len(self%bytes)) then
         allocate(character(len=2*(self%n + len(text))) :: bigger)
         bigger(:self%n) = self%bytes(:self%n)
         call move_alloc(bigger, self%bytes)
      end if
      self%bytes(self%n + 1:self%n + len(text)) = text
      self%n = self%n + len(text)
   end subroutine add_text

   !> Text of a buffer so far.
   pure function buffered_text(self) result(text)
      class(text_buffer_type), intent(in) :: self
      character(len=:), allocatable :: text

      text = ""
      if (self%n > 0) text = self%bytes(:self%n)
   end function buffered_text

   !> Text with the ASCII letters in lower case; other bytes are kept.
   pure function lower(s) result(t)
      character(len=*), intent(in) :: s
      character(len=len(s)) :: t
      integer :: i

      do i = 1, len(s)
         if (s(i:i) >= "A" .and. s(i:i) <= "Z") then
            t(i:i) = achar(iachar(s(i:i)) + 32)
         else
            t(i:i) = s(i:i)
         end if
      end do
   end function lower

   !> Fortran character literal of a text, with quotes in it doubled.
   pure function quote(s) result(t)
      character(len=*), intent(in) :: s
      character(len=:), allocatable :: t
      integer :: i, n

      n = 2 + len(s)
      do i = 1, len(s)
         if (s(i:i) == "'") n = n + 1
      end do
      allocate(character(len=n) :: t)
      t(1:1) = "'"
      n = 1
      do i = 1, len(s)
         n = n + 1
         t(n:n) = s(i:i)
         if (s(i:i) == "'") then
            n = n + 1
            t(n:n) = "'"
         end if
      end do
      t(n + 1:) = "'"
   end function quote

   !> Texts of their own length from texts padded with blanks.
   pure function strings(padded) result(names)
      !> Padded texts.
      character(len=*), intent(in) :: padded(:)
      type(string_type), allocatable :: names(:)
      integer :: i

      allocate(names(size(padded)))
      do i = 1, size(padded)
         names(i)%s = trim(padded(i))
      end do
   end function strings

   !> Texts as an array of one length, that of the longest one and at least one.
   pure subroutine pad(texts, padded)
      type(string_type), intent(in) :: texts(:)
      character(len=:), allocatable, intent(out) :: padded(:)
      integer :: i, longest

      longest = 1
      do i = 1, size(texts)
         longest = max(longest, len(texts(i)%s))
      end do
      allocate(character(len=longest) :: padded(size(texts)))
      do i = 1, size(texts)
         padded(i) = texts(i)%s
      end do
   end subroutine pad

   !> A text at the right end of a column, with a blank before it.
   pure function right(text, width) result(cell)
      character(len=*), intent(in) :: text
      !> Width of the column.
      integer, intent(in) :: width
      character(len=:), allocatable :: cell

      cell = repeat(" ", max(1, width - len(text))) // text
   end function right

   !> Texts of a list one after the other with a separator between them.
   pure function join(list, separator) result(t)
      !> Texts to join; one that is not allocated counts as empty.
      type(string_type), intent(in) :: list(:)
      !> Text between two of them.
      character(len=*), intent(in) :: separator
      character(len=:), allocatable :: t
      integer :: i

      t = ""
      do i = 1, size(list)
         if (i > 1) t = t // separator
         if (allocated(list(i)%s)) t = t // list(i)%s
      end do
   end function join

   !> Text cut to a number of bytes and ended by `...` if it is longer; never cuts a character.
   pure function shorten(s, width) result(t)
      character(len=*), intent(in) :: s
      !> Largest number of bytes of the result, at least 3.
      integer, intent(in) :: width
      character(len=:), allocatable :: t
      integer :: last

      if (len(s) <= width) then
         t = s
         return
      end if
      ! Bytes 128 to 191 continue a character of UTF-8.
      last = max(width - 3, 0)
      do while (last > 0)
         if (iand(ichar(s(last + 1:last + 1)), 192) /= 128) exit
         last = last - 1
      end do
      t = s(1:last) // "..."
   end function shorten

   !> Whether a text begins with another.
   pure logical function starts_with(s, prefix)
      character(len=*), intent(in) :: s
      !> Beginning to look for.
      character(len=*), intent(in) :: prefix

      starts_with = .false.
      if (len(s) >= len(prefix)) starts_with = s(1:len(prefix)) == prefix
   end function starts_with

   !> A command line of the program as one text.
   pure function command_text(words) result(text)
      !> Its words after the name of the program.
      type(string_type), intent(in) :: words(:)
      character(len=:), allocatable :: text
      integer :: i

      text = "contensou"
      do i = 1, size(words)
         if (verify(words(i)%s, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ" // &
            "0123456789-_./=,+:@%") > 0 .or. words(i)%s == "") then
            text = text // " " // quote(words(i)%s)
         else
            text = text // " " // words(i)%s
         end if
      end do
   end function command_text

   !> Number of bytes of the character of UTF-8 that begins at a byte, 1 to 4; 0 if none does.
   pure integer function utf8_length(s, i) result(n)
      character(len=*), intent(in) :: s
      !> Index of the byte.
      integer, intent(in) :: i
      integer :: j, lead, second

      lead = ichar(s(i:i))
      select case (lead)
      case (0:127)
         n = 1
         return
      case (194:223)
         n = 2
      case (224:239)
         n = 3
      case (240:244)
         n = 4
      case default
         n = 0
      end select
      if (i + n - 1 > len(s)) n = 0
      do j = i + 1, i + n - 1
         if (iand(ichar(s(j:j)), 192) /= 128) n = 0
         if (n == 0) exit
      end do
      if (n == 0) return
      ! Forms that are too long, surrogates, and beyond the last code point.
      second = ichar(s(i + 1:i + 1))
      if (lead == 224 .and. second < 160) n = 0
      if (lead == 237 .and. second > 159) n = 0
      if (lead == 240 .and. second < 144) n = 0
      if (lead == 244 .and. second > 143) n = 0
   end function utf8_length

   !> Index of the first byte of a text that is not UTF-8; 0 if there is none.
   pure integer function invalid_byte(s) result(i)
      character(len=*), intent(in) :: s
      integer :: n

      i = 1
      do while (i <= len(s))
         n = utf8_length(s, i)
         if (n == 0) return
         i = i + n
      end do
      i = 0
   end function invalid_byte

   !> What is wrong with a byte that is not UTF-8.
   pure function invalid_byte_text(byte) result(text)
      character(len=1), intent(in) :: byte
      character(len=:), allocatable :: text
      character(len=2) :: digits

      write(digits, "(z2.2)") ichar(byte)
      text = "byte 0x" // digits // " is not UTF-8"
   end function invalid_byte_text

   !> A text with a question mark for each byte that is not UTF-8.
   pure function valid_utf8(s) result(t)
      character(len=*), intent(in) :: s
      character(len=len(s)) :: t
      integer :: i

      t = s
      do
         i = invalid_byte(t)
         if (i == 0) exit
         t(i:i) = "?"
      end do
   end function valid_utf8

   !> Damerau-Levenshtein distance of two texts (optimal string alignment): the number of
   !> insertions, deletions, substitutions and swaps of neighbours that turn one into the other.
   pure integer function edit_distance(a, b, most)
      character(len=*), intent(in) :: a
      character(len=*), intent(in) :: b
      !> Any number above this will do for a larger distance; not given, there is no such bound.
      integer, intent(in), optional :: most
      ! Rows i - 2, i - 1 and i of the table of distances between beginnings of the texts; only
      ! what lies within `limit` of the diagonal can be so small.
      integer :: rows(0:len(b), 0:2)
      integer :: before, cost, current, i, j, limit, previous

      limit = max(len(a), len(b))
      if (present(most)) limit = min(limit, most)
      edit_distance = limit + 1
      if (abs(len(a) - len(b)) > limit) return
      rows = limit + 1
      rows(:, 0) = [(j, j=0, len(b))]
      do i = 1, len(a)
         current = mod(i, 3)
         previous = mod(i + 2, 3)
         before = mod(i + 1, 3)
         rows(:, current) = limit + 1
         if (i <= limit) rows(0, current) = i
         do j = max(1, i - limit), min(len(b), i + limit)
            cost = 1
            if (a(i:i) == b(j:j)) cost = 0
            edit_distance = min(rows(j, previous) + 1, rows(j - 1, current) + 1, &
               rows(j - 1, previous) + cost)
            if (i > 1 .and. j > 1) then
               if (a(i:i) == b(j - 1:j - 1) .and. a(i - 1:i - 1) == b(j:j)) then
                  edit_distance = min(edit_distance, rows(j - 2, before) + 1)
               end if
            end if
            rows(j, current) = edit_distance
         end do
         edit_distance = limit + 1
         if (minval(rows(:, current)) > limit .and. minval(rows(:, previous)) > limit) return
      end do
      edit_distance = rows(len(b), mod(len(a), 3))
   end function edit_distance

   !> End of a message about an unknown word: `; did you mean 'x'?` if a candidate is near.
   pure function did_you_mean(word, candidates, otherwise) result(text)
      !> Word as the user wrote it.
      character(len=*), intent(in) :: word
      !> Known words; trailing blanks do not count.
      character(len=*), intent(in) :: candidates(:)
      !> What follows the semicolon if none is near.
      character(len=*), intent(in) :: otherwise
      character(len=:), allocatable :: text
      integer :: i

      i = nearest(word, candidates)
      text = "; " // otherwise
      if (i > 0) text = "; did you mean " // quote(trim(candidates(i))) // "?"
   end function did_you_mean

   !> Index of the candidate nearest to a word, 0 if none is near.
   pure function nearest_character(word, candidates) result(best)
      !> Word as the user wrote it; case does not matter.
      character(len=*), intent(in) :: word
      !> Known words; trailing blanks do not count.
      character(len=*), intent(in) :: candidates(:)
      !> Index of the nearest candidate or 0.
      integer :: best
      type(string_type), allocatable :: list(:)
      integer :: i

      allocate(list(size(candidates)))
      do i = 1, size(candidates)
         list(i)%s = trim(candidates(i))
      end do
      best = nearest_string(word, list)
   end function nearest_character

   !> Index of the candidate nearest to a word, 0 if none is near.
   !>
   !> Near means an edit distance of at most a third of the word's length (but 1 is always
   !> allowed); failing that, a candidate that begins with the word, then one that contains it.
   pure function nearest_string(word, candidates) result(best)
      !> Word as the user wrote it; case does not matter.
      character(len=*), intent(in) :: word
      !> Known words.
      type(string_type), intent(in) :: candidates(:)
      !> Index of the nearest candidate or 0.
      integer :: best
      integer :: containing, i, shortest, starting

      best = 0
      starting = 0
      containing = 0
      shortest = min(max(1, len_trim(word)/3) + 1, len_trim(word))
      do i = 1, size(candidates)
         if (allocated(candidates(i)%s)) call consider(lower(trim(word)), &
            lower(candidates(i)%s), i, shortest, best, starting, containing)
      end do
      if (best == 0) best = starting
      if (best == 0) best = containing
   end function nearest_string

   !> Consider a candidate for the nearest word.
   pure subroutine consider(sought, candidate, index_of_it, shortest, best, starting, containing)
      !> The word and the candidate, in lower case.
      character(len=*), intent(in) :: sought, candidate
      !> Index of the candidate.
      integer, intent(in) :: index_of_it
      !> Smallest edit distance so far; only smaller ones count.
      integer, intent(inout) :: shortest
      !> Index of the candidate that has it; 0 for none.
      integer, intent(inout) :: best
      !> Index of the first candidate that begins with the word, and that contains it; 0 for none.
      integer, intent(inout) :: starting, containing
      integer :: distance

      distance = edit_distance(sought, candidate, shortest - 1)
      if (distance < shortest) then
         shortest = distance
         best = index_of_it
      end if
      if (len(sought) < shortest_part) return
      if (starting == 0 .and. starts_with(candidate, sought)) starting = index_of_it
      if (containing == 0 .and. index(candidate, sought) > 0) containing = index_of_it
   end subroutine consider

   !> The plural of a noun.
   pure function plural(noun)
      character(len=*), intent(in) :: noun
      character(len=:), allocatable :: plural
      integer :: n

      n = len_trim(noun)
      plural = noun(:n) // "s"
      if (n < 2) return
      if (noun(n:n) /= "y" .or. scan(noun(n - 1:n - 1), "aeiou") > 0) return
      plural = noun(:n - 1) // "ies"
   end function plural

end module contensou_base_text
