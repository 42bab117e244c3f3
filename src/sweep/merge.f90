!> Joins the tables of parts of a sweep, each case once.
module contensou_sweep_merge
   use contensou_base_errors, only : error_type, fatal, status_interrupted, status_usage
   use contensou_base_kinds, only : i8
   use contensou_base_numbers, only : to_text
   use contensou_base_operating_system, only : list_folder, signal_received
   use contensou_base_text, only : shorten, starts_with, string_type
   use contensou_sweep_selection, only : parse_ranges, selection_type
   use contensou_sweep_table, only : sweep_difference, sweep_table_type, table_header_type, &
      table_reader_type
   implicit none(type, external)
   private

   public :: merge_type, find_shards, plan_merge, join_tables

   !> Neighbouring cases in neighbouring rows of a table.
   type :: segment_type
      !> Which table.
      integer :: file = 0
      !> First case.
      integer(i8) :: first = 0
      !> Last case.
      integer(i8) :: last = 0
      !> Row of the first one, from 1.
      integer(i8) :: row = 0
   end type segment_type

   !> What tables come to when they are joined.
   type :: merge_type
      !> Names of the tables.
      type(string_type), allocatable :: files(:)
      !> Fingerprint and number of cases of their sweep.
      type(table_header_type) :: header
      !> Cases that are in a table, and that are in none.
      type(selection_type) :: present, missing
      !> Which rows of which tables stand one after the other, each case once.
      type(segment_type), allocatable, private :: segments(:)
   end type merge_type

   abstract interface
      !> Told how far the joining is.
      subroutine tell_interface(done, total)
         implicit none(type, external)
         !> Pieces that are joined, and their number.
         integer, intent(in) :: done, total
      end subroutine tell_interface
   end interface

contains

   !> Find the tables of the shards of a sweep.
   subroutine find_shards(output, files)
      !> Name of the table of the whole sweep.
      character(len=*), intent(in) :: output
      !> Names of what is found.
      type(string_type), allocatable, intent(out) :: files(:)
      type(string_type), allocatable :: names(:)
      character(len=:), allocatable :: folder, stem, suffix
      integer :: slash, dot, i, n
      logical, allocatable :: wanted(:)

      slash = index(output, "/", back=.true.)
      dot = index(output, ".", back=.true.)
      if (dot <= slash + 1) dot = len(output) + 1
      folder = output(:slash)
      stem = output(slash + 1:dot - 1)
      suffix = output(dot:)
      if (folder == "") then
         call list_folder(".", names)
      else
         call list_folder(folder, names)
      end if
      allocate(wanted(size(names)))
      do i = 1, size(names)
         associate (name => names(i)%s)
            wanted(i) = starts_with(name, stem // "_") .and. len(name) > len(stem) + len(suffix)
            if (wanted(i)) wanted(i) = name(len(name) - len(suffix) + 1:) == suffix
            if (wanted(i)) wanted(i) = is_part(name(len(stem) + 1:len(name) - len(suffix)))
         end associate
      end do
      allocate(files(count(wanted)))
      n = 0
      do i = 1, size(names)
         if (.not. wanted(i)) cycle
         n = n + 1
         files(n)%s = folder // names(i)%s
      end do
   end subroutine find_shards

   !> Whether a text is what the name of a part has after that of the whole: `_shard_1_of_4`,
   !> `_cases_1_to_9`, or both.
   function is_part(text)
      character(len=*), intent(in) :: text
      logical :: is_part
      character(len=:), allocatable :: rest

      rest = text
      if (starts_with(rest, "_cases_")) call take("_cases_", "_to_")
      if (starts_with(rest, "_shard_")) call take("_shard_", "_of_")
      is_part = rest == "" .and. text /= ""

   contains

      !> Take a word, a number, another word and another number away.
      subroutine take(before, between)
         !> First word.
         character(len=*), intent(in) :: before
         !> Second word.
         character(len=*), intent(in) :: between
         integer :: n

         rest = rest(len(before) + 1:)
         n = verify(rest // "_", "0123456789") - 1
         if (n < 1) return
         rest = rest(n + 1:)
         if (.not. starts_with(rest, between)) return
         rest = rest(len(between) + 1:)
         n = verify(rest // "_", "0123456789") - 1
         if (n < 1) rest = "?"
         rest = rest(n + 1:)
      end subroutine take

   end function is_part

   !> Read what tables say about themselves and plan how they are joined.
   subroutine plan_merge(files, fingerprint, hint, plan, error)
      type(string_type), intent(in) :: files(:)
      !> Fingerprint that they must have; empty for that of the first one.
      character(len=*), intent(in) :: fingerprint
      !> What to do about one of another sweep.
      character(len=*), intent(in) :: hint
      !> The plan; the header is set to what the sweep says if there are no tables.
      type(merge_type), intent(inout) :: plan
      !> Set when they do not belong together.
      type(error_type), allocatable, intent(out) :: error
      type(table_reader_type) :: first, reader
      type(segment_type), allocatable :: segments(:), more(:), longer(:)
      type(table_header_type) :: wanted
      character(len=:), allocatable :: why
      integer :: i

      wanted = plan%header
      plan%files = files
      allocate(segments(0))
      do i = 1, size(files)
         if (i == 1) then
            call first%open(files(1)%s, error)
            if (allocated(error)) return
            reader = first
            plan%header = first%header
            why = ""
         else
            call reader%open(files(i)%s, error)
            if (allocated(error)) exit
            why = reader%difference(first)
         end if
         if (fingerprint /= "" .and. reader%header%fingerprint /= fingerprint) then
            call fatal(error, files(i)%s // " is of another sweep, or of this one before it " // &
               "was changed: " // sweep_difference(reader%header, wanted) // "; " // hint, &
               status_usage)
         else if (why /= "") then
            call fatal(error, files(1)%s // " and " // files(i)%s // " cannot be joined: " // why, &
               status_usage)
         else
            call list_segments(reader%header, i, more, error)
            if (allocated(error)) error%message = files(i)%s // " is damaged: " // error%message
         end if
         if (i > 1) call reader%close()
         if (allocated(error)) exit
         allocate(longer(size(segments) + size(more)))
         longer(:size(segments)) = segments
         longer(size(segments) + 1:) = more
         call move_alloc(longer, segments)
      end do
      if (size(files) > 0) call first%close()
      if (.not. allocated(error)) call order_segments(segments, plan)
   end subroutine plan_merge

   !> The cases of a table.
   subroutine list_segments(header, file, segments, error)
      !> What the table says about itself.
      type(table_header_type), intent(in) :: header
      !> Number of the table.
      integer, intent(in) :: file
      type(segment_type), allocatable, intent(out) :: segments(:)
      !> Set when there are more or fewer cases than rows.
      type(error_type), allocatable, intent(out) :: error
      type(selection_type) :: selection
      character(len=:), allocatable :: wrong
      integer(i8) :: row
      integer :: i

      call parse_ranges(header%cases, header%n_cases, selection, wrong)
      if (.not. allocated(wrong)) then
         if (selection%count() /= header%n_rows) wrong = header%cases
      end if
      if (allocated(wrong)) then
         call fatal(error, "it has " // to_text(header%n_rows) // " rows for the cases " // &
            shorten(header%cases, 60), status_usage)
         return
      end if
      allocate(segments(size(selection%ranges, 2)))
      row = 1
      do i = 1, size(segments)
         segments(i) = segment_type(file, selection%ranges(1, i), selection%ranges(2, i), row)
         row = row + segments(i)%last - segments(i)%first + 1
      end do
   end subroutine list_segments

   !> Put the rows of all tables in the order of their cases, each case once.
   subroutine order_segments(segments, plan)
      !> The cases of all tables.
      type(segment_type), intent(inout) :: segments(:)
      type(merge_type), intent(inout) :: plan
      type(segment_type) :: kept(size(segments))
      integer(i8), dimension(2, size(segments) + 1) :: present, missing
      integer(i8) :: next
      integer :: i, n, n_present, n_missing

      call sort(segments)
      n = 0
      n_missing = 0
      next = 1
      do i = 1, size(segments)
         associate (segment => segments(i))
            if (segment%last < next) cycle
            if (segment%first > next) call leave_out(segment%first - 1)
            n = n + 1
            kept(n) = segment
            kept(n)%row = segment%row + next - segment%first
            kept(n)%first = next
            next = segment%last + 1
         end associate
      end do
      if (next <= plan%header%n_cases) call leave_out(plan%header%n_cases)
      ! The cases that are there stand between those that are not.
      n_present = 0
      next = 1
      do i = 1, n_missing
         if (missing(1, i) > next) then
            n_present = n_present + 1
            present(:, n_present) = [next, missing(1, i) - 1]
         end if
         next = missing(2, i) + 1
      end do
      if (next <= plan%header%n_cases) then
         n_present = n_present + 1
         present(:, n_present) = [next, plan%header%n_cases]
      end if
      plan%segments = kept(:n)
      plan%present%ranges = present(:, :n_present)
      plan%missing%ranges = missing(:, :n_missing)

   contains

      !> Note that the cases up to this one are in no table.
      subroutine leave_out(last)
         integer(i8), intent(in) :: last

         n_missing = n_missing + 1
         missing(:, n_missing) = [next, last]
         next = last + 1
      end subroutine leave_out

   end subroutine order_segments

   !> Put segments in the order of their first cases.
   recursive subroutine sort(segments)
      type(segment_type), intent(inout) :: segments(:)
      type(segment_type) :: sorted(size(segments))
      integer :: half, i, j, k

      if (size(segments) < 2) return
      half = size(segments)/2
      call sort(segments(:half))
      call sort(segments(half + 1:))
      i = 1
      j = half + 1
      do k = 1, size(segments)
         if (j <= size(segments) .and. i <= half) then
            if (segments(i)%first <= segments(j)%first) then
               sorted(k) = segments(i)
               i = i + 1
            else
               sorted(k) = segments(j)
               j = j + 1
            end if
         else if (i <= half) then
            sorted(k) = segments(i)
            i = i + 1
         else
            sorted(k) = segments(j)
            j = j + 1
         end if
      end do
      segments = sorted
   end subroutine sort

   !> Write the table of all cases that are present.
   subroutine join_tables(plan, output, replace, command_line, tell, counts, error)
      type(merge_type), intent(in) :: plan
      !> Name of the table.
      character(len=*), intent(in) :: output
      !> Whether it may replace an existing file.
      logical, intent(in) :: replace
      !> Command line, for the table.
      character(len=*), intent(in) :: command_line
      !> Told how far it is, now and then.
      procedure(tell_interface) :: tell
      !> Number of cases of each status, from 0.
      integer(i8), intent(out) :: counts(0:)
      !> Set when a file cannot be read or written.
      type(error_type), allocatable, intent(out) :: error
      type(table_reader_type) :: reader
      type(sweep_table_type) :: table
      integer :: i, opened

      counts = 0
      opened = 0
      do i = 1, size(plan%segments)
         if (signal_received() /= 0) then
            call fatal(error, "interrupted", status_interrupted)
            exit
         end if
         associate (segment => plan%segments(i))
            if (segment%file /= opened) then
               if (opened > 0) call reader%close()
               opened = 0
               call reader%open(plan%files(segment%file)%s, error)
               if (allocated(error)) exit
               opened = segment%file
            end if
            if (i == 1) call table%open_like(output, replace, reader, plan%present%text(), &
               command_line, error)
            if (.not. allocated(error)) call table%append_from(reader, segment%row, segment%row + &
               segment%last - segment%first, error)
         end associate
         if (allocated(error)) exit
         if (mod(i, 100) == 0) call tell(i, size(plan%segments))
      end do
      if (opened > 0) call reader%close()
      if (allocated(error)) then
         call table%abandon()
         return
      end if
      call table%finish(error)
      counts = table%counts
   end subroutine join_tables

end module contensou_sweep_merge
