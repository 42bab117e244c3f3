!> Feeds mutated scenes to the scene reader: `fuzz_reader SEED COUNT SCRATCH SCENE...`.
!>
!> Each must be read or be refused by a message with the status of a wrong scene, and what is read
!> must be read again from its resolved settings. The scene under test is in the file SCRATCH, so
!> that it is at hand after a crash; a scene that breaks a rule ends the program with status 1.
module fuzz_reader_run
   use contensou_base_errors, only : error_type, status_usage
   use contensou_base_kinds, only : i8
   use contensou_base_schema, only : key_type
   use contensou_base_text, only : string_type
   use contensou_scene_reader, only : read_scene, scene_file_type
   use contensou_scene_schema, only : schema_keys
   implicit none(type, external)
   private

   public :: run

   !> State of the random numbers (Knuth's MMIX generator, high bits of it).
   integer(i8) :: state = 0

   !> Longest scene [bytes].
   integer, parameter :: longest = 20000

   !> What numbers and texts are replaced by.
   character(len=*), parameter :: tokens(*) = [character(len=24) :: "0", "-1", "1", "1e308", &
      "-1e308", "1e-308", "1e-320", "1e999", "nan", "inf", "-infinity", "3*1.0", "1000000*1.0", &
      "99999999999999999999*1", "0*1", "'", '"', "''", "'x'", "&", "/", "&end", "!", ",", ";", &
      "=", "(", "(1)", "(2:3)", "(0)", "%", ".true.", ".f.", "&body", "&contact", "&surface", &
      "&scene", "name", "'ground'", "'plane'", "'sphere'", "'torus'", "'ellipsoid'", "'cylinder'", &
      "'inside'", "'prescribed'", "'fixed'", "'coulomb'", "'tsuji'", "'vilke'", "'hysteresis'", &
      "1d-3", "1.", ".5", "0.3", "1e-3", "1e3", "1e-30", "1e30", "1e40", "1e-40", "0.02", &
      "-0.02", "1, 0, 0", "0, 0, 0", "0, 0, 1e-30", "1e30, 0, 0", "1e", "+", "--1", "0x10", &
      "1,,2", "2*", "*3", "$", "@", "\", "~"]

contains

   !> Read the command line and feed all scenes; status 0 if all went well.
   subroutine run(status)
      !> Exit status.
      integer, intent(out) :: status
      type(string_type), allocatable :: corpus(:)
      type(key_type), allocatable :: keys(:)
      character(len=:), allocatable :: scratch, text
      integer(i8) :: count, i
      integer :: seen(2), j, length
      real :: start, before, after, slowest

      status = 0
      if (command_argument_count() < 4) then
         write(*, "(a)") "usage: fuzz_reader SEED COUNT SCRATCH SCENE..."
         status = 2
         return
      end if
      scratch = argument(1)
      read(scratch, *) state
      scratch = argument(2)
      read(scratch, *) count
      scratch = argument(3)
      allocate(corpus(command_argument_count() - 3))
      do j = 1, size(corpus)
         corpus(j)%s = contents(argument(3 + j))
      end do
      keys = schema_keys()
      seen = 0
      slowest = 0.0
      call cpu_time(start)
      before = start
      do i = 1, count
         ! In two statements: gfortran would call the function for the text and for its length.
         j = below(size(corpus)) + 1
         text = corpus(j)%s
         do j = 0, below(1 + below(5))
            call mutate(text, corpus, keys)
         end do
         length = min(len(text), longest)
         call feed(text(:length), scratch, seen, status)
         call cpu_time(after)
         slowest = max(slowest, after - before)
         before = after
         if (status /= 0) return
      end do
      write(*, "(i0, a, i0, a, i0, a, f0.1, a, f0.3, a)") count, " scenes: ", seen(1), " read, ", &
         seen(2), " refused; ", before - start, " s, slowest ", slowest, " s"
   end subroutine run

   !> Read one scene.
   subroutine feed(text, scratch, seen, status)
      !> The scene.
      character(len=*), intent(in) :: text
      !> File to write it to.
      character(len=*), intent(in) :: scratch
      !> Scenes read and refused so far.
      integer, intent(inout) :: seen(2)
      !> Set to 1 if a rule is broken.
      integer, intent(inout) :: status
      type(scene_file_type) :: file, again
      type(error_type), allocatable :: error
      type(string_type) :: none(0)

      call write_file(scratch, text)
      call read_scene(scratch, none, "", file, error)
      if (allocated(error)) then
         seen(2) = seen(2) + 1
         if (error%status == status_usage .and. len_trim(error%message) > 0) return
         write(*, "(a)") "refused in a wrong way: " // error%message
         status = 1
         return
      end if
      seen(1) = seen(1) + 1
      call write_file(scratch // ".resolved", file%resolved)
      call read_scene(scratch // ".resolved", none, "", again, error)
      if (.not. allocated(error)) return
      write(*, "(a)") "the resolved settings are no scene: " // error%message
      status = 1
   end subroutine feed

   !> Change a text somewhere.
   subroutine mutate(text, corpus, keys)
      character(len=:), allocatable, intent(inout) :: text
      !> Texts to take parts of.
      type(string_type), intent(in) :: corpus(:)
      !> Keys of the scene file.
      type(key_type), intent(in) :: keys(:)
      integer :: first, last, other, from, to

      first = below(len(text) + 1) + 1
      last = min(first - 1 + below(12), len(text))
      select case (below(14))
      case (0)
         if (first <= len(text)) text(first:first) = achar(below(256))
      case (1)
         text = text(:first - 1) // text(last + 1:)
      case (2)
         last = min(first - 1 + below(300), len(text))
         text = text(:first - 1) // text(last + 1:)
      case (3)
         last = min(first - 1 + below(300), len(text))
         text = text(:last) // text(first:)
      case (4)
         other = below(size(corpus)) + 1
         from = below(len(corpus(other)%s) + 1) + 1
         to = min(from - 1 + below(300), len(corpus(other)%s))
         text = text(:first - 1) // corpus(other)%s(from:to) // text(first:)
      case (5)
         text = text(:first - 1) // trim(tokens(below(size(tokens)) + 1)) // text(first:)
      case (6)
         text = text(:first - 1) // " " // trim(keys(below(size(keys)) + 1)%name) // " = " // &
            trim(tokens(below(size(tokens)) + 1)) // " " // text(first:)
      case default
         ! A whole value: from a word behind to the next separator.
         from = scan(text(first:), "0123456789'")
         if (from == 0) return
         from = first - 1 + from
         to = scan(text(from + 1:), " ,/" // new_line("a"))
         if (to == 0) return
         text = text(:from - 1) // trim(tokens(below(size(tokens)) + 1)) // text(from + to:)
      end select
   end subroutine mutate

   !> A whole number from 0 to n - 1.
   function below(n) result(k)
      !> Upper bound, > 0.
      integer, intent(in) :: n
      integer :: k
      integer(i8), parameter :: mask = 2_i8**31 - 1_i8

      ! Modulo 2**62, in halves: no product overflows.
      state = iand(add_products(state), 2_i8**62 - 1_i8)
      k = int(mod(iand(ishft(state, -31), mask), int(n, i8)))

   contains

      !> 25214903917 s + 11, modulo 2**62, from halves of 31 bits.
      pure function add_products(s) result(product)
         !> The state.
         integer(i8), intent(in) :: s
         integer(i8) :: product, low, high
         integer(i8), parameter :: a_low = 1590268653_i8, a_high = 11_i8

         low = iand(s, mask)
         high = iand(ishft(s, -31), mask)
         high = iand(low*a_high + iand(high*a_low, mask), mask)
         low = low*a_low + 11_i8
         product = iand(low, mask) + ishft(iand(high + ishft(low, -31), mask), 31)
      end function add_products

   end function below

   !> A word of the command line.
   function argument(i) result(word)
      !> Its position.
      integer, intent(in) :: i
      character(len=:), allocatable :: word
      integer :: length

      call get_command_argument(i, length=length)
      allocate(character(len=length) :: word)
      call get_command_argument(i, word)
   end function argument

   !> Bytes of a file.
   function contents(path) result(text)
      !> Its name.
      character(len=*), intent(in) :: path
      character(len=:), allocatable :: text
      integer :: unit, length

      open(newunit=unit, file=path, access="stream", form="unformatted", status="old", &
         action="read")
      inquire(unit=unit, size=length)
      allocate(character(len=length) :: text)
      read(unit) text
      close(unit)
   end function contents

   !> Write a file.
   subroutine write_file(path, text)
      !> Its name.
      character(len=*), intent(in) :: path
      !> What it holds.
      character(len=*), intent(in) :: text
      integer :: unit

      open(newunit=unit, file=path, access="stream", form="unformatted", status="replace", &
         action="write")
      write(unit) text
      close(unit)
   end subroutine write_file

end module fuzz_reader_run
