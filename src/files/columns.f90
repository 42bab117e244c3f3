!> The tables in an output file of any kind, and their columns as CSV.
!>
!> A table is all that has a row for each value of the same scale: the times of a trajectory, its
!> events, the cases of a sweep, the runs of a cost study. A data set with further dimensions makes
!> a column for each component, named after the data set and the labels of the component, such as
!> position_ball_x.
module contensou_files_columns
   use contensou_base_errors, only : error_type, fatal, status_file, status_usage
   use contensou_base_kinds, only : i8, wp
   use contensou_base_numbers, only : counted, to_text
   use contensou_base_patterns, only : matches_pattern
   use contensou_base_text, only : lower, nearest, quote, string_type, text_buffer_type
   use contensou_files_hdf5_reader, only : class_integer, class_real, class_text, class_unsigned, &
      hdf5_entry_type, hdf5_item_type, hdf5_reader_type, link_hard, object_dataset, object_group, &
      probe
   use contensou_study_quantities, only : row_quantities
   use contensou_study_quantity, only : quantity_type
   implicit none(type, external)
   private

   public :: tables_type

   !> A data set with rows.
   type :: data_type
      character(len=:), allocatable :: name
      !> Path in the file, without the slash at its beginning.
      character(len=:), allocatable :: path
      character(len=:), allocatable :: units, long_name
      type(hdf5_item_type) :: item
      !> Index of its table.
      integer :: table = 0
      !> Its place among the data sets of its table, by size.
      integer :: order = 0
      !> Its columns: numbers of the first and the last one.
      integer :: first = 0, last = -1
      !> Integers that stand for words, and these words.
      integer(i8), allocatable :: flags(:)
      type(string_type), allocatable :: meanings(:)
      !> Integer that stands for what is not known.
      integer(i8), allocatable :: none
      !> A block of its values, those of a row beside each other.
      real(wp), allocatable :: reals(:)
      integer(i8), allocatable :: integers(:)
      type(string_type), allocatable :: texts(:)
   end type data_type

   !> One column of a table: a data set, or a component of one.
   type :: column_type
      character(len=:), allocatable :: name
      !> Its data set.
      integer :: source = 0
   end type column_type

   !> The tables of a file.
   type :: tables_type
      character(len=:), allocatable :: path
      !> What the file says about itself: `complete`, `running`, ...; empty if it does not.
      character(len=:), allocatable :: status
      type(hdf5_reader_type), private :: reader
      type(data_type), allocatable, private :: data(:)
      type(column_type), allocatable, private :: columns(:)
      !> The scales of the tables.
      type(string_type), allocatable, private :: scales(:)
      !> The table that is meant where none is named.
      integer, private :: main = 0
   contains
      procedure :: open => open_tables
      procedure :: close => close_tables
      procedure :: choose
      procedure :: rows
      procedure :: header
      procedure :: lines
      procedure :: list
   end type tables_type

   !> Columns of a file, and components of a data set.
   integer(i8), parameter :: most_columns = 5000000_i8

   !> Values of a data set that are read at a time.
   integer(i8), parameter :: block_values = 262144_i8

   character(len=*), parameter :: nl = new_line("a")

contains

   !> Open a file and find its tables.
   subroutine open_tables(self, path, error)
      class(tables_type), intent(inout) :: self
      character(len=*), intent(in) :: path
      !> Set when it cannot be read, is damaged, or has no tables.
      type(error_type), allocatable, intent(out) :: error
      type(error_type), allocatable :: ignored

      self%path = path
      allocate(self%data(0), self%columns(0), self%scales(0))
      call probe(path, error)
      if (.not. allocated(error)) call self%reader%open(path, error)
      if (allocated(error)) return
      call self%reader%read_text("/", "status", self%status, ignored)
      call find_data(self, error)
      if (.not. allocated(error)) call name_columns(self, error)
      if (.not. allocated(error)) call find_main(self)
      if (.not. allocated(error) .and. size(self%data) == 0) call fatal(error, path // &
         " is no output file of contensou: it has no columns", status_usage)
      if (allocated(error)) call self%close()
   end subroutine open_tables

   !> Find the data sets with rows, in the root and in the groups there.
   subroutine find_data(self, error)
      type(tables_type), intent(inout) :: self
      type(error_type), allocatable, intent(out) :: error
      type(hdf5_entry_type), allocatable :: entries(:)
      integer(i8) :: address
      integer :: i, kind

      call find_in_group(self, "", error)
      if (.not. allocated(error)) call self%reader%list("/", .false., entries, error)
      if (allocated(error)) return
      do i = 1, size(entries)
         if (entries(i)%link /= link_hard) cycle
         call self%reader%object("/" // entries(i)%name, kind, address, error)
         if (.not. allocated(error) .and. kind == object_group) call find_in_group(self, &
            entries(i)%name // "/", error)
         if (allocated(error)) return
      end do
   end subroutine find_data

   !> Find the data sets with rows in a group.
   subroutine find_in_group(self, group, error)
      type(tables_type), intent(inout) :: self
      !> Its path, empty or with a slash at its end.
      character(len=*), intent(in) :: group
      type(error_type), allocatable, intent(out) :: error
      type(hdf5_entry_type), allocatable :: entries(:)
      type(string_type), allocatable :: ordered(:)
      type(data_type) :: data
      integer(i8) :: address
      integer :: i, kind

      call self%reader%list("/" // group, .false., entries, error)
      if (allocated(error)) return
      call listed_columns(self, group, ordered)
      do i = 1, size(entries)
         if (entries(i)%link /= link_hard) cycle
         call self%reader%object("/" // group // entries(i)%name, kind, address, error)
         if (allocated(error)) return
         if (kind /= object_dataset) cycle
         call open_data(self, group, entries(i)%name, data, error)
         if (allocated(error)) return
         if (.not. data%item%is_open()) cycle
         if (data%order == 0) data%order = size(self%data) + place_of(data, ordered)
         call add_data(self, data)
      end do
   end subroutine find_in_group

   !> What puts a data set into its place among the others of its group.
   integer function place_of(data, ordered) result(place)
      type(data_type), intent(in) :: data
      !> Columns of the group in their order; may be empty.
      type(string_type), intent(in) :: ordered(:)
      integer, parameter :: far = 100000000
      type(quantity_type), allocatable :: quantities(:)
      integer :: i

      place = far
      if (data%name == "message") place = 3*far
      if (index(data%path, "results/") == 1) place = 2*far
      if (index(data%path, "trajectory/") == 1) then
         quantities = row_quantities()
         do i = 1, size(quantities)
            if (quantities(i)%name == data%name) place = i*1000
         end do
      end if
      do i = 1, size(ordered)
         if (ordered(i)%s == data%name) place = place + (i - size(ordered) - 1)*1000
      end do
   end function place_of

   !> The columns of a group as its attribute `columns` lists them; none without it.
   subroutine listed_columns(self, group, names)
      type(tables_type), intent(in) :: self
      character(len=*), intent(in) :: group
      type(string_type), allocatable, intent(out) :: names(:)
      type(hdf5_item_type) :: item
      type(error_type), allocatable :: ignored

      call self%reader%open_item("/" // group, "columns", item, ignored)
      if (.not. allocated(ignored)) then
         if (item%class == class_text .and. item%rank == 1 .and. .not. item%is_null) call &
            item%read_texts([0_i8], item%extents(:1), int(item%extents(1)), names, ignored)
         call item%close()
      end if
      if (.not. allocated(names)) allocate(names(0))
   end subroutine listed_columns

   !> Open a data set and find its table.
   subroutine open_data(self, group, name, data, error)
      type(tables_type), intent(inout) :: self
      character(len=*), intent(in) :: group, name
      !> The data set; its item is not open if it has no rows.
      type(data_type), intent(out) :: data
      type(error_type), allocatable, intent(out) :: error
      type(hdf5_item_type) :: scale
      type(error_type), allocatable :: ignored
      character(len=:), allocatable :: of, text
      integer(i8) :: address, flags(256)
      integer :: kind

      data%name = name
      data%path = group // name
      call self%reader%open_item("/" // data%path, "", data%item, error)
      if (allocated(error)) return
      associate (item => data%item)
         if (item%is_null .or. item%rank < 1 .or. item%rank > 3 .or. all(item%class /= &
            [class_real, class_integer, class_unsigned, class_text])) then
            call item%close()
            return
         end if
         data%units = item%units()
         call item%open_scale(0, scale)
         of = data%path
         if (scale%is_open()) then
            of = scale%name
            call scale%close()
            ! It is in the same group, or in the root.
            call self%reader%object("/" // group // of, kind, address, ignored)
            if (.not. allocated(ignored)) of = group // of
         end if
      end associate
      data%table = table_of(self, of)
      if (of == data%path) data%order = -huge(1)
      call self%reader%read_text("/" // data%path, "long_name", data%long_name, ignored)
      if (all(data%item%class /= [class_integer, class_unsigned])) return
      call self%reader%read_text("/" // data%path, "flag_meanings", text, ignored)
      if (.not. allocated(ignored)) then
         call take_integers("flag_values")
         call split(text, data%meanings)
         if (kind == size(data%meanings)) data%flags = flags(:kind)
      end if
      call take_integers("_FillValue")
      if (kind == 1) data%none = flags(1)

   contains

      !> Take the integers of an attribute.
      subroutine take_integers(attribute)
         character(len=*), intent(in) :: attribute
         type(hdf5_item_type) :: values

         kind = 0
         call self%reader%open_item("/" // data%path, attribute, values, ignored)
         if (allocated(ignored)) return
         if (any(values%class == [class_integer, class_unsigned]) .and. values%rank < 2 .and. &
            .not. values%is_null) then
            kind = 1
            if (values%rank == 1) kind = int(min(values%extents(1), int(size(flags) + 1, i8)))
            if (kind > size(flags)) then
               kind = 0
            else
               call values%read([0_i8], [int(kind, i8)], flags(:kind), ignored)
               if (allocated(ignored)) kind = 0
            end if
         end if
         call values%close()
      end subroutine take_integers

   end subroutine open_data

   !> The words of a text.
   subroutine split(text, words)
      character(len=*), intent(in) :: text
      type(string_type), allocatable, intent(out) :: words(:)
      integer :: i, n, start

      allocate(words(count([(text(i:i) /= " ", i=1, len(text))])))
      n = 0
      start = 1
      do i = 1, len(text) + 1
         if (i <= len(text)) then
            if (text(i:i) /= " ") cycle
         end if
         if (i > start) then
            n = n + 1
            words(n)%s = text(start:i - 1)
         end if
         start = i + 1
      end do
      words = words(:n)
   end subroutine split

   !> Number of the table with a scale; a new one if there is none.
   integer function table_of(self, scale) result(table)
      type(tables_type), intent(inout) :: self
      character(len=*), intent(in) :: scale
      type(string_type), allocatable :: longer(:)
      integer :: n

      n = size(self%scales)
      do table = 1, n
         if (self%scales(table)%s == scale) return
      end do
      allocate(longer(n + 1))
      longer(:n) = self%scales
      longer(n + 1)%s = scale
      call move_alloc(longer, self%scales)
   end function table_of

   !> Add a data set, behind those of its table that come before it.
   subroutine add_data(self, data)
      type(tables_type), intent(inout) :: self
      type(data_type), intent(in) :: data
      type(data_type), allocatable :: longer(:)
      integer :: n, place

      n = size(self%data)
      place = n
      do while (place > 0)
         if (self%data(place)%table < data%table) exit
         if (self%data(place)%table == data%table .and. self%data(place)%order < data%order) exit
         place = place - 1
      end do
      allocate(longer(n + 1))
      longer(:place) = self%data(:place)
      longer(place + 1) = data
      longer(place + 2:) = self%data(place + 1:)
      call move_alloc(longer, self%data)
   end subroutine add_data

   !> Name the columns of all data sets.
   subroutine name_columns(self, error)
      type(tables_type), intent(inout) :: self
      type(error_type), allocatable, intent(out) :: error
      type(column_type), allocatable :: columns(:)
      type(string_type), allocatable :: outer(:), inner(:)
      integer(i8) :: total, width
      integer :: d, i, k, n

      total = 0
      do d = 1, size(self%data)
         associate (item => self%data(d)%item)
            width = 1
            do i = 2, item%rank
               if (width <= most_columns) width = width*min(item%extents(i), most_columns)
            end do
            total = total + width
            if (total > most_columns) then
               call fatal(error, self%path // " is damaged: " // self%data(d)%path // &
                  " has too many components", status_file)
               return
            end if
         end associate
      end do
      allocate(columns(total))
      n = 0
      do d = 1, size(self%data)
         self%data(d)%first = n + 1
         call labels_of(self%data(d)%item, 2, outer)
         call labels_of(self%data(d)%item, 3, inner)
         do i = 1, size(outer)
            do k = 1, size(inner)
               n = n + 1
               columns(n)%source = d
               columns(n)%name = self%data(d)%name // outer(i)%s // inner(k)%s
            end do
         end do
         self%data(d)%last = n
      end do
      call move_alloc(columns, self%columns)
   end subroutine name_columns

   !> What the labels of a dimension add to the name of a column; nothing if there is none.
   subroutine labels_of(item, dimension, labels)
      type(hdf5_item_type), intent(in) :: item
      !> Dimension, from 1.
      integer, intent(in) :: dimension
      type(string_type), allocatable, intent(out) :: labels(:)
      type(hdf5_item_type) :: scale
      type(string_type), allocatable :: texts(:)
      type(error_type), allocatable :: ignored
      integer :: i, n

      if (item%rank < dimension) then
         allocate(labels(1))
         labels(1)%s = ""
         return
      end if
      n = int(item%extents(dimension))
      allocate(labels(n))
      call item%open_scale(dimension - 1, scale)
      if (scale%is_open()) then
         if (scale%class == class_text .and. scale%extents(1) == n .and. n > 0) call &
            scale%read_texts([0_i8], [int(n, i8)], n, texts, ignored)
         call scale%close()
      end if
      do i = 1, n
         labels(i)%s = "_" // to_text(i)
         if (.not. allocated(texts) .or. allocated(ignored)) cycle
         labels(i)%s = "_" // texts(i)%s
      end do
   end subroutine labels_of

   !> Find the table that is meant where none is named: that of the default group, or of the root.
   subroutine find_main(self)
      type(tables_type), intent(inout) :: self
      type(error_type), allocatable :: ignored
      character(len=:), allocatable :: group
      integer :: d, most, table, n

      call self%reader%read_text("/", "default", group, ignored)
      if (allocated(ignored)) group = ""
      if (group /= "") group = group // "/"
      self%main = 1
      most = 0
      do table = 1, size(self%scales)
         associate (scale => self%scales(table)%s)
            if (scale(:index(scale, "/")) /= group) cycle
         end associate
         n = count([(self%data(d)%table == table, d=1, size(self%data))])
         if (n > most) self%main = table
         most = max(most, n)
      end do
   end subroutine find_main

   !> Close the file.
   subroutine close_tables(self)
      class(tables_type), intent(inout) :: self
      integer :: d

      if (allocated(self%data)) then
         do d = 1, size(self%data)
            call self%data(d)%item%close()
         end do
      end if
      call self%reader%close()
   end subroutine close_tables

   !> Choose columns of one table, by words that are patterns of their names.
   subroutine choose(self, words, chosen, error)
      class(tables_type), intent(in) :: self
      !> Names of columns or data sets, those of other tables than the main one with their group,
      !> such as events/kind; with `*` for any characters and `?` for one. None: the main table.
      type(string_type), intent(in) :: words(:)
      !> Numbers of the columns, in the order of the words.
      integer, allocatable, intent(out) :: chosen(:)
      !> Set when a word stands for none, or the columns are of several tables.
      type(error_type), allocatable, intent(out) :: error
      integer :: places(size(self%columns))
      logical :: taken(size(self%columns)), found
      integer :: c, n, w, first_word

      taken = .false.
      n = 0
      if (size(words) == 0) then
         do c = 1, size(self%columns)
            if (self%data(self%columns(c)%source)%table == self%main) call take(c)
         end do
      end if
      first_word = 0
      do w = 1, size(words)
         found = .false.
         do c = 1, size(self%columns)
            if (.not. stands_for(self, lower(words(w)%s), c)) cycle
            found = .true.
            if (.not. taken(c)) call take(c)
            if (first_word == 0) first_word = w
            associate (a => self%data(self%columns(places(1))%source)%table, &
               b => self%data(self%columns(c)%source)%table)
               if (a == b) cycle
               call fatal(error, quote(words(first_word)%s) // " and " // quote(words(w)%s) // &
                  " are of different tables: " // table_text(self, a) // ", " // &
                  table_text(self, b) // "; export them one by one", status_usage)
               return
            end associate
         end do
         if (found) cycle
         call unknown_column(self, words(w)%s, error)
         return
      end do
      chosen = places(:n)

   contains

      !> Take a column.
      subroutine take(c)
         integer, intent(in) :: c

         taken(c) = .true.
         n = n + 1
         places(n) = c
      end subroutine take

   end subroutine choose

   !> Whether a word stands for a column.
   pure logical function stands_for(self, word, c)
      type(tables_type), intent(in) :: self
      !> The word in lower case.
      character(len=*), intent(in) :: word
      !> Number of the column.
      integer, intent(in) :: c
      character(len=:), allocatable :: pattern

      associate (data => self%data(self%columns(c)%source), name => self%columns(c)%name)
         stands_for = .false.
         if (data%table == self%main) stands_for = matches_pattern(word, lower(name)) .or. &
            matches_pattern(word, lower(data%name))
         if (stands_for .or. index(word, "/") == 0) return
         pattern = word(max(verify(word, "/"), 1):)
         stands_for = matches_pattern(pattern, lower(data%path)) .or. matches_pattern(pattern, &
            lower(data%path(:len(data%path) - len(data%name)) // name))
      end associate
   end function stands_for

   !> Report a word that stands for no column.
   subroutine unknown_column(self, word, error)
      type(tables_type), intent(in) :: self
      character(len=*), intent(in) :: word
      type(error_type), allocatable, intent(out) :: error
      type(string_type) :: candidates(size(self%data) + size(self%columns))
      integer :: c, d, near, n

      n = 0
      do d = 1, size(self%data)
         associate (data => self%data(d))
            n = n + 1
            candidates(n)%s = data%path
            if (data%table == self%main .and. index(word, "/") == 0) candidates(n)%s = data%name
         end associate
      end do
      do c = 1, size(self%columns)
         if (self%data(self%columns(c)%source)%table /= self%main) cycle
         n = n + 1
         candidates(n)%s = self%columns(c)%name
      end do
      if (scan(word, "*?") > 0) then
         call fatal(error, "no column of " // self%path // " matches " // quote(word) // &
            "; contensou export " // self%path // " --list lists them", status_usage)
         return
      end if
      near = nearest(word, candidates(:n))
      if (near > 0) then
         call fatal(error, self%path // " has no column " // quote(word) // "; did you mean " // &
            quote(candidates(near)%s) // "?", status_usage)
      else
         call fatal(error, self%path // " has no column " // quote(word) // &
            "; contensou export " // self%path // " --list lists them", status_usage)
      end if
   end subroutine unknown_column

   !> A table in words.
   function table_text(self, table) result(text)
      type(tables_type), intent(in) :: self
      integer, intent(in) :: table
      character(len=:), allocatable :: text
      type(error_type), allocatable :: ignored
      integer(i8) :: n

      call table_rows(self, table, n, ignored)
      text = self%scales(table)%s // " has " // counted(n, "row")
   end function table_text

   !> Number of rows of some columns.
   subroutine rows(self, chosen, n, error)
      class(tables_type), intent(in) :: self
      integer, intent(in) :: chosen(:)
      integer(i8), intent(out) :: n
      !> Set when the columns of the table are not equally long, and the file is complete.
      type(error_type), allocatable, intent(out) :: error

      n = 0
      if (size(chosen) > 0) call table_rows(self, self%data(self%columns(chosen(1))%source)%table, &
         n, error)
   end subroutine rows

   !> Number of rows of a table: those that all of its columns have.
   subroutine table_rows(self, table, n, error)
      class(tables_type), intent(in) :: self
      integer, intent(in) :: table
      integer(i8), intent(out) :: n
      !> Set when its columns are not equally long, and the file is complete.
      type(error_type), allocatable, intent(out) :: error
      integer(i8) :: most
      integer :: d

      n = huge(n)
      most = 0
      do d = 1, size(self%data)
         if (self%data(d)%table /= table) cycle
         n = min(n, self%data(d)%item%extents(1))
         most = max(most, self%data(d)%item%extents(1))
      end do
      if (n < most .and. self%status == "complete") call fatal(error, self%path // &
         " is damaged: columns of " // self%scales(table)%s // " are not equally long", status_file)
   end subroutine table_rows

   !> The line with the names and units of some columns.
   function header(self, chosen) result(text)
      class(tables_type), intent(in) :: self
      integer, intent(in) :: chosen(:)
      character(len=:), allocatable :: text
      type(text_buffer_type) :: line
      integer :: i

      do i = 1, size(chosen)
         associate (column => self%columns(chosen(i)))
            if (i > 1) call line%add(",")
            if (has_unit(self%data(column%source))) then
               call line%add(cell(column%name // " [" // self%data(column%source)%units // "]"))
            else
               call line%add(cell(column%name))
            end if
         end associate
      end do
      call line%add(nl)
      text = line%text()
   end function header

   !> Whether the values of a data set are numbers with a unit.
   pure logical function has_unit(data)
      type(data_type), intent(in) :: data

      has_unit = data%units /= "" .and. .not. allocated(data%flags)
   end function has_unit

   !> Some rows of some columns: as many as are worth reading at a time.
   subroutine lines(self, chosen, first, last, text, error)
      class(tables_type), intent(inout) :: self
      integer, intent(in) :: chosen(:)
      !> First row, from 1; behind the last one that was read afterwards.
      integer(i8), intent(inout) :: first
      !> Last row.
      integer(i8), intent(in) :: last
      character(len=:), allocatable, intent(out) :: text
      type(error_type), allocatable, intent(out) :: error
      type(text_buffer_type) :: buffer
      logical :: needed(size(self%data))
      integer(i8) :: n, row, width
      integer :: d, i

      needed = .false.
      width = 0
      do i = 1, size(chosen)
         d = self%columns(chosen(i))%source
         if (.not. needed(d)) width = width + self%data(d)%last - self%data(d)%first + 1
         needed(d) = .true.
      end do
      n = min(last - first + 1, max(block_values/max(width, 1_i8), 1_i8))
      do d = 1, size(needed)
         if (needed(d)) call read_block(self%data(d), first - 1, n, error)
         if (allocated(error)) return
      end do
      do row = 1, n
         do i = 1, size(chosen)
            if (i > 1) call buffer%add(",")
            associate (data => self%data(self%columns(chosen(i))%source))
               call buffer%add(value_text(data, (row - 1)*(data%last - data%first + 1) + &
                  chosen(i) - data%first + 1))
            end associate
         end do
         call buffer%add(nl)
      end do
      first = first + n
      text = buffer%text()
   end subroutine lines

   !> Read some rows of a data set.
   subroutine read_block(data, first, n, error)
      type(data_type), intent(inout) :: data
      !> First row, from 0.
      integer(i8), intent(in) :: first
      !> Number of rows.
      integer(i8), intent(in) :: n
      type(error_type), allocatable, intent(out) :: error
      integer(i8) :: start(3), extents(3), values

      start = 0
      start(1) = first
      extents = data%item%extents(:3)
      extents(1) = n
      values = n*(data%last - data%first + 1)
      select case (data%item%class)
      case (class_real)
         if (allocated(data%reals)) deallocate(data%reals)
         allocate(data%reals(values))
         if (values > 0) call data%item%read(start, extents, data%reals, error)
      case (class_text)
         if (values > 0) call data%item%read_texts(start, extents, int(values), data%texts, error)
      case default
         if (allocated(data%integers)) deallocate(data%integers)
         allocate(data%integers(values))
         if (values > 0) call data%item%read(start, extents, data%integers, error)
      end select
   end subroutine read_block

   !> A value of a block as a cell; empty if it is not known.
   pure function value_text(data, i) result(text)
      type(data_type), intent(in) :: data
      !> Index in the block.
      integer(i8), intent(in) :: i
      character(len=:), allocatable :: text
      integer :: k

      select case (data%item%class)
      case (class_real)
         text = to_text(data%reals(i))
      case (class_text)
         text = cell(data%texts(i)%s)
      case default
         text = to_text(data%integers(i))
         if (allocated(data%none)) then
            if (data%integers(i) == data%none) text = ""
         end if
         if (.not. allocated(data%flags)) return
         k = findloc(data%flags, data%integers(i), dim=1)
         if (k > 0) text = data%meanings(k)%s
      end select
   end function value_text

   !> A text as a cell (RFC 4180): in quotes where it has to be.
   pure function cell(words) result(text)
      character(len=*), intent(in) :: words
      character(len=:), allocatable :: text
      integer :: i

      text = words
      if (words == "") return
      if (scan(words, ',"' // char(10) // char(13)) == 0 .and. words(1:1) /= " " .and. &
         words(len(words):) /= " ") return
      text = '"'
      do i = 1, len(words)
         if (words(i:i) == '"') text = text // '"'
         text = text // words(i:i)
      end do
      text = text // '"'
   end function cell

   !> The tables and their columns, for people.
   function list(self) result(text)
      class(tables_type), intent(in) :: self
      character(len=:), allocatable :: text
      type(text_buffer_type) :: buffer
      character(len=:), allocatable :: columns
      integer :: d, k, n, table, widths(3)

      do k = 0, size(self%scales)
         table = k
         if (k == 0) table = self%main
         if (k == self%main) cycle
         n = count([(self%data(d)%table == table, d=1, size(self%data))])
         if (n < 2) cycle
         if (k > 0) call buffer%add(nl)
         call buffer%add(table_text(self, table))
         if (k == 0) call buffer%add("; these columns without --columns")
         call buffer%add(nl)
         widths = 0
         do d = 1, size(self%data)
            if (self%data(d)%table == table) widths = max(widths, [len(shown_name(d)), &
               len(self%data(d)%units), len(range_of(d))])
         end do
         do d = 1, size(self%data)
            if (self%data(d)%table /= table) cycle
            columns = range_of(d)
            call buffer%add("  " // padded(shown_name(d), widths(1)) // "  " // &
               padded(self%data(d)%units, widths(2)) // "  ")
            if (widths(3) > 0) call buffer%add(padded(columns, widths(3)) // "  ")
            call buffer%add(self%data(d)%long_name // nl)
         end do
      end do
      text = buffer%text()

   contains

      !> Name by which a data set is chosen.
      pure function shown_name(d) result(name)
         integer, intent(in) :: d
         character(len=:), allocatable :: name

         name = self%data(d)%path
         if (self%data(d)%table == self%main) name = self%data(d)%name
      end function shown_name

      !> Its first and last columns, if there are several.
      pure function range_of(d) result(range)
         integer, intent(in) :: d
         character(len=:), allocatable :: range

         range = ""
         associate (data => self%data(d))
            if (data%last < data%first .or. data%item%rank < 2) return
            range = self%columns(data%first)%name
            if (data%last > data%first) range = range // " .. " // self%columns(data%last)%name
         end associate
      end function range_of

      !> A text with blanks behind it.
      pure function padded(word, width) result(wide)
         character(len=*), intent(in) :: word
         integer, intent(in) :: width
         character(len=:), allocatable :: wide

         wide = word // repeat(" ", max(width - len(word), 0))
      end function padded

   end function list

end module contensou_files_columns
