!> The output file of a run: docs/output.md describes its format.
!>
!> Rows are collected and appended in chunks, handed to the system every few seconds, so that a
!> killed run leaves what it had. The file is written under the name NAME.part and renamed when it
!> is complete: a file under its final name is a complete result.
module contensou_files_trajectory
   use, intrinsic :: ieee_arithmetic, only : ieee_quiet_nan, ieee_value
   use contensou_base_errors, only : error_type, fatal, status_file
   use contensou_base_kinds, only : i8, wp
   use contensou_base_numbers, only : to_text
   use contensou_base_operating_system, only : checksum, cpu_seconds, file_exists, remove_file, &
      wall_seconds
   use contensou_base_text, only : pad, string_type
   use contensou_contact_damping, only : damping_model_type, damping_models
   use contensou_contact_friction, only : friction_model_type, friction_models
   use contensou_contact_normal, only : normal_model_type, normal_models
   use contensou_contact_shapes_shape, only : shape_info_type
   use contensou_contact_surface, only : size_type
   use contensou_dynamics_scene, only : scene_type, solid_parts
   use contensou_dynamics_equations, only : system_type
   use contensou_dynamics_springs, only : spring_kinds
   use contensou_integrate_integrator, only : statistics_type
   use contensou_integrate_memory, only : row_count
   use contensou_integrate_observer, only : event_touch
   use contensou_integrate_profile, only : profile_names
   use contensou_base_checkpoint, only : checkpoint_type
   use contensou_files_hdf5_file, only : hdf5_file_type, hdf5_series_type, series_real, series_text
   use contensou_files_hdf5_reader, only : class_real, class_text, hdf5_item_type, &
      hdf5_reader_type, max_rank
   use contensou_files_provenance, only : put_header, put_input
   use contensou_scene_reader, only : scene_file_type
   use contensou_study_quantities, only : final_quantities, row_type
   use contensou_study_quantity, only : quantity_type
   use contensou_study_summary, only : summary_quantities, summary_stop, summary_type
   implicit none(type, external)
   private

   public :: trajectory_type, filetype, filetype_version, part_suffix
   public :: check_rows

   !> What the file is, for programs that open it.
   character(len=*), parameter :: filetype = "contensou-trajectory"

   !> Version of the format: the second number grows with additions, the first with changes.
   character(len=*), parameter :: filetype_version = "1.6"

   !> Suffix of a file that is not complete.
   character(len=*), parameter :: part_suffix = ".part"

   !> Rows that wait to be written together, at most ...
   integer, parameter :: most_rows = 4096

   !> ... and while they are few, of how many numbers in all.
   integer, parameter :: few_rows = 512, most_numbers = 2**19

   integer, parameter :: chunk_events = 64

   !> A quantity of the rows: its series with the rows that wait to be appended.
   type :: column_type
      character(len=:), allocatable :: name
      !> Its numbers in a row.
      integer :: first = 0, last = -1
      type(hdf5_series_type) :: series
      !> Rows that wait, (numbers of a row, rows of a chunk).
      real(wp), allocatable :: rows(:, :)
      !> Checksum of the rows appended so far.
      integer(i8) :: sum = 0
   end type column_type

   !> An output file that is being written.
   type :: trajectory_type
      !> What the run comes down to so far.
      type(summary_type) :: summary
      !> Name of the complete file.
      character(len=:), allocatable :: name
      !> Whether it may replace an existing file.
      logical :: replace = .false.
      !> Checksum of the settings that it holds.
      integer(i8) :: settings_sum = 0
      type(hdf5_file_type), private :: file
      !> Columns of the trajectory.
      type(column_type), allocatable, private :: columns(:)
      type(row_type), private :: last
      !> Rows that wait, and how many are written together: those of a chunk, less what a flush has
      !> written of it already.
      integer, private :: waiting = 0, chunk_rows = few_rows, begun_rows = 0
      !> Times of events that wait [s].
      real(wp), private :: event_time(chunk_events)
      !> Kinds of events that wait.
      character(len=8), private :: event_kind(chunk_events)
      !> Contacts of events that wait, as indices.
      integer, private :: event_contact(chunk_events)
      integer, private :: events_waiting = 0
      type(hdf5_series_type), private :: event_series(3)
      !> Checksums of the events appended so far, of each series.
      integer(i8), private :: event_sum(3) = 0
      !> How often this run was begun or continued.
      integer(i8) :: lives = 1
      !> Names of the contacts, padded.
      character(len=:), allocatable, private :: contact_names(:)
      !> Names of the bodies, padded.
      character(len=:), allocatable, private :: body_names(:)
      character(len=:), allocatable, private :: spring_names(:)
      !> Methods that were used, in order.
      character(len=11), allocatable, private :: methods(:)
      !> Times since when each was used [s].
      real(wp), allocatable, private :: method_times(:)
      !> Why the method `auto` begins with was chosen; not allocated without `auto`.
      character(len=:), allocatable :: choice
      !> Name of the condition that ended the run; not allocated without.
      character(len=:), allocatable :: stopped_by
      !> What the user should know of the run; not allocated: nothing.
      character(len=:), allocatable :: warning
      !> CPU time by effect [s]; not allocated if it was not asked for.
      real(wp), allocatable :: cpu_by_effect(:)
      !> When the file was last flushed [s].
      real(wp), private :: last_flush = 0.0_wp
      !> Seconds between two flushes.
      real(wp) :: flush_interval = 5.0_wp
      !> CPU time spent in writing rows [s].
      real(wp) :: cpu_output = 0.0_wp
      !> Clocks at the beginning, earlier by the time of the lives before: wall, CPU [s].
      real(wp), private :: clocks(2) = 0.0_wp
   contains
      procedure :: open
      procedure :: row
      procedure :: event
      procedure :: use_method
      procedure :: flush_is_due
      procedure :: flush
      procedure :: exchange
      procedure :: restore
      procedure :: elapsed
      procedure :: finish
      procedure :: abandon
      procedure :: is_open
   end type trajectory_type

contains

   !> Create the file with everything that is known before the run.
   subroutine open(self, file, system, replace, command_line, error)
      class(trajectory_type), intent(inout) :: self
      !> The scene with its texts; it names the complete file.
      type(scene_file_type), intent(in) :: file
      type(system_type), intent(in) :: system
      !> Whether it may replace an existing file.
      logical, intent(in) :: replace
      character(len=*), intent(in) :: command_line
      type(error_type), allocatable, intent(out) :: error

      self%name = file%scene%output%file
      self%replace = replace
      self%settings_sum = checksum(0_i8, file%resolved)
      self%clocks = [wall_seconds(), cpu_seconds()]
      self%last_flush = self%clocks(1)
      call collect_names(self, file%scene)
      associate (f => self%file)
         call f%create(self%name // part_suffix, error)
         if (allocated(error)) return
         if (file_exists(self%name) .and. .not. replace) then
            ! Another run has finished it since the caller looked.
            call remove_file(self%name // part_suffix, error)
            call f%abandon()
            call fatal(error, self%name // " exists", status_file)
            return
         end if
         call put_header(f, filetype, filetype_version, "running", error, file%scene%title)
         call f%put_attribute("/", "NX_class", "NXroot", error)
         call f%put_attribute("/", "default", "trajectory", error)
         call put_input(f, file%text, file%resolved, command_line, error)
         call put_bodies(self, file%scene, error)
         call put_surfaces(self%file, file%scene, error)
         call put_contacts(self, file%scene, error)
         call put_springs(self, file%scene, error)
         call create_columns(self, system, file%scene, error)
         call create_events(self, error)
         ! A failure is kept by the file, so that this last call sees the first one.
         call f%flush(error)
      end associate
   end subroutine open

   !> Names of bodies and contacts as padded arrays.
   subroutine collect_names(self, scene)
      type(trajectory_type), intent(inout) :: self
      type(scene_type), intent(in) :: scene
      type(string_type) :: bodies(size(scene%bodies)), contacts(size(scene%contacts))
      type(string_type), allocatable :: springs(:)
      integer :: i

      do i = 1, size(bodies)
         bodies(i)%s = scene%bodies(i)%name
      end do
      do i = 1, size(contacts)
         contacts(i)%s = scene%contacts(i)%name
      end do
      call pad(bodies, self%body_names)
      call pad(contacts, self%contact_names)
      allocate(springs(0))
      if (allocated(scene%springs)) then
         deallocate(springs)
         allocate(springs(size(scene%springs)))
         do i = 1, size(springs)
            springs(i)%s = scene%springs(i)%name
         end do
      end if
      call pad(springs, self%spring_names)
   end subroutine collect_names

   !> Names, masses and moments of inertia of the bodies.
   subroutine put_bodies(self, scene, error)
      type(trajectory_type), intent(inout) :: self
      type(scene_type), intent(in) :: scene
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: mass(size(scene%bodies)), inertia(3, size(scene%bodies))
      integer :: i

      do i = 1, size(scene%bodies)
         mass(i) = scene%bodies(i)%mass
         inertia(:, i) = scene%bodies(i)%inertia
      end do
      associate (f => self%file)
         call f%create_group("/body", error)
         call f%put_labels("/body/name", self%body_names, "name of the body", error)
         call f%put_labels("/body/xyz", ["x", "y", "z"], "principal axis", error)
         call f%put_array("/body/mass", mass, ["/body/name"], "kg", "mass", error)
         call f%put_array("/body/inertia", inertia, ["/body/name", "/body/xyz "], "kg m2", &
            "principal moments of inertia", error)
      end associate
   end subroutine put_bodies

   !> The materials, and the surfaces: what it takes to draw the bodies.
   subroutine put_surfaces(file, scene, error)
      type(hdf5_file_type), intent(inout) :: file
      type(scene_type), intent(in) :: scene
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: s = "/surface/", scale(*) = ["/surface/name"]
      type(string_type) :: materials(size(scene%materials))
      type(string_type), dimension(size(scene%surfaces)) :: names, bodies, shapes, made_of
      character(len=10) :: parts(size(scene%surfaces))
      real(wp) :: centre(3, size(scene%surfaces)), axes(3, 3, size(scene%surfaces)), &
         length(size(scene%surfaces))
      character(len=:), allocatable :: padded(:)
      type(shape_info_type) :: info
      integer :: i

      do i = 1, size(scene%materials)
         materials(i)%s = scene%materials(i)%name
      end do
      call pad(materials, padded)
      call file%create_group("/material", error)
      call file%put_labels("/material/name", padded, "name of the material", error)
      call file%put_array("/material/young", scene%materials%young, ["/material/name"], "Pa", &
         "Young's modulus", error)
      call file%put_array("/material/poisson", scene%materials%poisson, ["/material/name"], "1", &
         "Poisson's ratio", error)
      parts = ""
      length = ieee_value(1.0_wp, ieee_quiet_nan)
      do i = 1, size(scene%surfaces)
         associate (spec => scene%surfaces(i))
            names(i)%s = spec%name
            bodies(i)%s = "ground"
            if (spec%body > 0) bodies(i)%s = scene%bodies(spec%body)%name
            made_of(i)%s = scene%materials(spec%material)%name
            info = spec%surface%shape%info()
            shapes(i)%s = trim(info%name)
            centre(:, i) = spec%surface%centre
            axes(:, :, i) = spec%surface%frame
            if (spec%solid_part > 0) parts(i) = solid_parts(spec%solid_part)
            if (spec%solid_length > 0.0_wp) length(i) = spec%solid_length
         end associate
      end do
      call file%create_group("/surface", error)
      call pad(names, padded)
      call file%put_labels(s // "name", padded, "name of the surface", error)
      call file%put_labels(s // "xyz", ["x", "y", "z"], "axis of the body", error)
      call file%put_labels(s // "axis", ["1", "2", "3"], "axis of the shape", error)
      call pad(bodies, padded)
      call file%put_texts(s // "body", padded, scale, "body that carries the surface", error)
      call pad(shapes, padded)
      call file%put_texts(s // "shape", padded, scale, "shape of the surface", error)
      call file%put_texts(s // "side", merge("inside ", "outside", scene%surfaces%surface%inside), &
         scale, "side of the shape that is touched", error)
      call pad(made_of, padded)
      call file%put_texts(s // "material", padded, scale, "material of the surface", error)
      call file%put_array(s // "centre", centre, [character(len=13) :: scale, s // "xyz"], "m", &
         "origin of the frame of the shape, frame of the body", error)
      call file%put_array(s // "axes", axes, [character(len=13) :: scale, s // "axis", &
         s // "xyz"], "1", "axes of the frame of the shape, frame of the body", error)
      call file%put_texts(s // "solid_part", parts, scale, "part of the shape that the solid " // &
         "of the body is; empty where the scene does not say that it bounds one", error)
      call file%put_array(s // "solid_length", length, scale, "m", &
         "length of that solid where the shape has no ends", error)
      call put_sizes(file, scene, error)
   end subroutine put_surfaces

   !> The sizes of the surfaces, a data set for each key that one of their shapes has.
   subroutine put_sizes(file, scene, error)
      type(hdf5_file_type), intent(inout) :: file
      type(scene_type), intent(in) :: scene
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: text = &
         "size of the shape; not a number where it has none of this name"
      type(size_type) :: kinds(32)
      real(wp) :: values(3, size(scene%surfaces))
      integer :: i, j, k, n

      n = 0
      do i = 1, size(scene%surfaces)
         do j = 1, size(scene%surfaces(i)%sizes)
            associate (item => scene%surfaces(i)%sizes(j))
               if (item%name == "" .or. any(kinds(:n)%name == item%name)) cycle
               n = n + 1
               kinds(n) = item
            end associate
         end do
      end do
      do k = 1, n
         values = ieee_value(values, ieee_quiet_nan)
         do i = 1, size(scene%surfaces)
            do j = 1, size(scene%surfaces(i)%sizes)
               associate (item => scene%surfaces(i)%sizes(j))
                  if (item%name == kinds(k)%name) values(:, i) = item%values
               end associate
            end do
         end do
         if (kinds(k)%n == 1) then
            call file%put_array("/surface/" // trim(kinds(k)%name), values(1, :), &
               ["/surface/name"], trim(kinds(k)%unit), text, error)
         else
            call file%put_array("/surface/" // trim(kinds(k)%name), values, ["/surface/name", &
               "/surface/axis"], trim(kinds(k)%unit), text, error)
         end if
      end do
   end subroutine put_sizes

   !> The contacts and their models.
   subroutine put_contacts(self, scene, error)
      type(trajectory_type), intent(inout) :: self
      type(scene_type), intent(in) :: scene
      type(error_type), allocatable, intent(out) :: error
      type(normal_model_type), allocatable :: normal(:)
      type(damping_model_type), allocatable :: damping(:)
      type(friction_model_type), allocatable :: friction(:)
      type(string_type) :: names(2*size(scene%contacts))
      character(len=:), allocatable :: padded(:), surfaces(:, :)
      integer :: i, n

      normal = normal_models()
      damping = damping_models()
      friction = friction_models()
      n = size(scene%contacts)
      do i = 1, n
         names(2*i - 1)%s = scene%surfaces(scene%contacts(i)%surfaces(1))%name
         names(2*i)%s = scene%surfaces(scene%contacts(i)%surfaces(2))%name
      end do
      call pad(names, padded)
      allocate(character(len=len(padded)) :: surfaces(2, n))
      surfaces(1, :) = padded(1::2)
      surfaces(2, :) = padded(2::2)
      associate (f => self%file, scale => ["/contact/name"])
         call f%create_group("/contact", error)
         call f%put_labels("/contact/name", self%contact_names, "name of the contact", error)
         call f%put_labels("/contact/side", ["A", "B"], "side of the contact", error)
         call f%put_texts("/contact/surfaces", surfaces, ["/contact/name", "/contact/side"], &
            "surfaces that touch", error)
         call f%put_texts("/contact/normal", normal(scene%contacts%normal)%info%name, scale, &
            "normal force model", error)
         call f%put_texts("/contact/damping", damping(scene%contacts%damping)%info%name, scale, &
            "damping law", error)
         call f%put_texts("/contact/friction", friction(scene%contacts%friction)%info%name, scale, &
            "friction model", error)
      end associate
   end subroutine put_contacts

   subroutine put_springs(self, scene, error)
      type(trajectory_type), intent(inout) :: self
      type(scene_type), intent(in) :: scene
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: s = "/spring/", scale(*) = ["/spring/name"]
      type(string_type) :: names(2*size(self%spring_names))
      character(len=:), allocatable :: padded(:), bodies(:, :)
      integer :: i, k, body

      if (size(self%spring_names) == 0) return
      do i = 1, size(scene%springs)
         do k = 1, 2
            body = merge(scene%springs(i)%a, scene%springs(i)%b, k == 1)
            names(2*(i - 1) + k)%s = "ground"
            if (body > 0) names(2*(i - 1) + k)%s = scene%bodies(body)%name
         end do
      end do
      call pad(names, padded)
      allocate(character(len=len(padded)) :: bodies(2, size(scene%springs)))
      bodies(1, :) = padded(1::2)
      bodies(2, :) = padded(2::2)
      associate (f => self%file)
         call f%create_group("/spring", error)
         call f%put_labels(s // "name", self%spring_names, "name of the spring", error)
         call f%put_labels(s // "side", ["A", "B"], "side of the spring", error)
         call f%put_labels(s // "xyz", ["x", "y", "z"], "axis of the body", error)
         call f%put_texts(s // "bodies", bodies, ["/spring/name", "/spring/side"], &
            "bodies that it joins", error)
         call f%put_texts(s // "kind", spring_kinds(scene%springs%kind), scale, "kind", error)
         call f%put_array(s // "first_point", reshape([(scene%springs(i)%point(:, 1), i=1, &
            size(scene%springs))], [3, size(scene%springs)]), ["/spring/name", "/spring/xyz "], &
            "m", "where it is fastened to A, frame of A", error)
         call f%put_array(s // "second_point", reshape([(scene%springs(i)%point(:, 2), i=1, &
            size(scene%springs))], [3, size(scene%springs)]), ["/spring/name", "/spring/xyz "], &
            "m", "where it is fastened to B, frame of B", error)
      end associate
   end subroutine put_springs

   !> The columns of the trajectory with their scales.
   subroutine create_columns(self, system, scene, error)
      type(trajectory_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      type(scene_type), intent(in) :: scene
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: t = "/trajectory/"
      integer, allocatable :: places(:)
      integer(i8) :: rows, most
      integer :: i

      associate (f => self%file)
         call f%create_group("/trajectory", error)
         call f%put_labels(t // "body", self%body_names, "body", error)
         call f%put_labels(t // "contact", self%contact_names, "contact", error)
         if (size(self%spring_names) > 0) call f%put_labels(t // "spring", self%spring_names, &
            "spring", error)
         call f%put_labels(t // "xyz", ["x", "y", "z"], "axis of the inertial frame", error)
         call f%put_labels(t // "wxyz", ["w", "x", "y", "z"], "component of a quaternion", error)
         call f%put_labels(t // "axis", ["major", "minor"], "axis of the spot", error)
         call self%last%prepare(system, scene%output)
         rows = row_count(scene%t_end, scene%output%interval) + 1_i8
         most = max(few_rows, min(most_rows, most_numbers/size(self%last%values)))
         ! All chunks are as good as full.
         self%chunk_rows = int((rows - 1_i8)/((rows - 1_i8)/most + 1_i8) + 1_i8)
         places = pack([(i, i=1, size(self%last%has))], self%last%has)
         allocate(self%columns(size(places)))
         do i = 1, size(places)
            call create_column(self%columns(i), self%last%quantities(places(i)), &
               self%last%start(places(i)), self%last%width(places(i)))
         end do
         call f%put_attribute("/trajectory", "NX_class", "NXdata", error)
         call f%put_attribute("/trajectory", "signal", "energy_kinetic", error)
         call f%put_attribute("/trajectory", "axes", "time", error)
         call f%put_attribute_values("/trajectory", "auxiliary_signals", [character(len=16) :: &
            "energy_potential", "energy_elastic", "work_friction", "work_damping"], error)
      end associate

   contains

      !> Create the series of a quantity.
      subroutine create_column(column, q, start, width)
         type(column_type), intent(inout) :: column
         type(quantity_type), intent(in) :: q
         !> Number before its first one in a row.
         integer, intent(in) :: start
         !> Its numbers in a row.
         integer, intent(in) :: width
         character(len=24) :: scales(3)
         integer :: extents(2), n

         column%name = trim(q%name)
         column%first = start + 1
         column%last = start + width
         allocate(column%rows(width, self%chunk_rows))
         extents = [width/q%components, q%components]
         n = 0
         if (q%dims /= "") n = 1
         if (q%dims /= q%owner()) n = 2
         scales = [character(len=24) :: t // "time", t // q%owner(), &
            t // q%dims(len_trim(q%owner()) + 2:)]
         ! Time is the scale of the others.
         call self%file%create_series(t // column%name, extents(:n), &
            scales(:merge(0, n + 1, column%name == "time")), column%name == "time", &
            self%chunk_rows, trim(q%units), trim(q%long_name), series_real, column%series, error)
      end subroutine create_column

   end subroutine create_columns

   !> The series of the events.
   subroutine create_events(self, error)
      type(trajectory_type), intent(inout) :: self
      type(error_type), allocatable, intent(out) :: error
      integer, parameter :: no_extents(0) = [integer ::]

      associate (f => self%file, dims => ["/events/time"])
         call f%create_group("/events", error)
         call f%create_series("/events/time", no_extents, dims(:0), .true., chunk_events, "s", &
            "time of the event", series_real, self%event_series(1), error)
         call f%create_series("/events/kind", no_extents, dims, .false., chunk_events, "", &
            "touch or lift", series_text, self%event_series(2), error)
         call f%create_series("/events/contact", no_extents, dims, .false., chunk_events, "", &
            "name of the contact", series_text, self%event_series(3), error)
      end associate
   end subroutine create_events

   !> Add a row.
   subroutine row(self, system, t, y, error)
      class(trajectory_type), intent(inout) :: self
      !> The equations of motion; their workspace is changed.
      type(system_type), intent(inout) :: system
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)
      type(error_type), allocatable, intent(out) :: error
      integer :: i

      call self%summary%add_row(self%last, system, t, y, error)
      if (allocated(error)) return
      self%waiting = self%waiting + 1
      do i = 1, size(self%columns)
         associate (column => self%columns(i))
            column%rows(:, self%waiting) = self%last%values(column%first:column%last)
         end associate
      end do
      if (self%begun_rows + self%waiting == self%chunk_rows) call append_rows(self, error)
   end subroutine row

   !> Append the rows that wait.
   subroutine append_rows(self, error)
      class(trajectory_type), intent(inout) :: self
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: start
      integer :: i

      start = cpu_seconds()
      do i = 1, size(self%columns)
         associate (column => self%columns(i))
            call self%file%append(column%series, self%waiting, column%rows, error)
            if (allocated(error)) return
            call add_to_sum(column%sum, size(column%rows, 1)*self%waiting, column%rows)
         end associate
      end do
      self%begun_rows = modulo(self%begun_rows + self%waiting, self%chunk_rows)
      self%waiting = 0
      self%cpu_output = self%cpu_output + cpu_seconds() - start
   end subroutine append_rows

   !> Continue a checksum by the first numbers of some rows.
   subroutine add_to_sum(sum, n, numbers)
      integer(i8), intent(inout) :: sum
      !> How many.
      integer, intent(in) :: n
      real(wp), intent(in) :: numbers(n)

      sum = checksum(sum, numbers)
   end subroutine add_to_sum

   !> Add an event.
   subroutine event(self, t, kind, contact, error)
      class(trajectory_type), intent(inout) :: self
      real(wp), intent(in) :: t
      integer, intent(in) :: kind
      integer, intent(in) :: contact
      type(error_type), allocatable, intent(out) :: error

      call self%summary%add_event(kind == event_touch)
      self%events_waiting = self%events_waiting + 1
      self%event_time(self%events_waiting) = t
      self%event_kind(self%events_waiting) = merge("touch", "lift ", kind == event_touch)
      self%event_contact(self%events_waiting) = contact
      if (self%events_waiting == chunk_events) call append_events(self, error)
   end subroutine event

   !> Append the events that wait.
   subroutine append_events(self, error)
      class(trajectory_type), intent(inout) :: self
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: nl = new_line("a")
      character(len=len(self%contact_names)) :: names(self%events_waiting)
      integer :: i, n

      n = self%events_waiting
      if (n == 0) return
      do i = 1, n
         names(i) = self%contact_names(self%event_contact(i))
      end do
      call self%file%append(self%event_series(1), n, self%event_time, error)
      if (allocated(error)) return
      call self%file%append(self%event_series(2), n, self%event_kind, error)
      if (allocated(error)) return
      call self%file%append(self%event_series(3), n, names, error)
      if (allocated(error)) return
      self%event_sum(1) = checksum(self%event_sum(1), self%event_time(:n))
      do i = 1, n
         self%event_sum(2) = checksum(self%event_sum(2), trim(self%event_kind(i)) // nl)
         self%event_sum(3) = checksum(self%event_sum(3), trim(names(i)) // nl)
      end do
      self%events_waiting = 0
   end subroutine append_events

   !> Whether the last flush is some seconds ago.
   logical function flush_is_due(self)
      class(trajectory_type), intent(in) :: self

      flush_is_due = wall_seconds() - self%last_flush >= self%flush_interval
   end function flush_is_due

   !> Append what waits and bring the file to the disk.
   subroutine flush(self, error)
      class(trajectory_type), intent(inout) :: self
      type(error_type), allocatable, intent(out) :: error

      self%last_flush = wall_seconds()
      if (self%waiting > 0) call append_rows(self, error)
      if (allocated(error)) return
      call append_events(self, error)
      if (allocated(error)) return
      call self%file%flush(error)
      if (allocated(error)) return
      call self%file%sync(error)
   end subroutine flush

   !> Wall and CPU time of the run so far, earlier lives included [s].
   function elapsed(self) result(seconds)
      class(trajectory_type), intent(in) :: self
      real(wp) :: seconds(2)

      seconds = [wall_seconds(), cpu_seconds()] - self%clocks
   end function elapsed

   !> Write to a checkpoint what a flushed file holds and what is known of the run besides, or read
   !> it back.
   subroutine exchange(self, checkpoint)
      class(trajectory_type), intent(inout) :: self
      type(checkpoint_type), intent(inout) :: checkpoint
      real(wp) :: seconds(2)
      integer :: n, i

      call exchange_sums(self, checkpoint)
      call checkpoint%exchange("lives", self%lives)
      call checkpoint%exchange("cpu_output", self%cpu_output)
      seconds = self%elapsed()
      call checkpoint%exchange("seconds", seconds)
      if (checkpoint%is_reading()) self%clocks = self%clocks - seconds
      call checkpoint%exchange_allocatable("choice", self%choice)
      n = 0
      if (allocated(self%methods)) n = size(self%methods)
      call checkpoint%exchange("methods", n)
      if (checkpoint%is_reading()) allocate(self%methods(n), self%method_times(n))
      do i = 1, n
         call checkpoint%exchange("method_" // to_text(i), self%methods(i))
      end do
      call checkpoint%exchange("method_times", self%method_times)
   end subroutine exchange

   !> Write to a checkpoint what rows and events a flushed file holds, or read it back.
   subroutine exchange_sums(self, checkpoint)
      class(trajectory_type), intent(inout) :: self
      type(checkpoint_type), intent(inout) :: checkpoint
      integer :: n, i

      call self%summary%exchange(checkpoint)
      n = 0
      if (allocated(self%columns)) n = size(self%columns)
      call checkpoint%exchange("columns", n)
      if (.not. allocated(self%columns)) allocate(self%columns(n))
      do i = 1, size(self%columns)
         call checkpoint%exchange_allocatable("column", self%columns(i)%name)
         call checkpoint%exchange("row_sum", self%columns(i)%sum)
      end do
      call checkpoint%exchange("event_sums", self%event_sum)
   end subroutine exchange_sums

   !> See that a file has the rows and events that a checkpoint speaks of.
   !>
   !> The HDF5 library can crash over a file that was damaged: see contensou_base_guard.
   subroutine check_rows(path, checkpoint, error)
      character(len=*), intent(in) :: path
      type(checkpoint_type), intent(inout) :: checkpoint
      !> Set when it has others.
      type(error_type), allocatable, intent(out) :: error
      type(trajectory_type) :: nobody

      call exchange_sums(nobody, checkpoint)
      call checkpoint%result(error)
      if (.not. allocated(error)) call copy_rows(nobody, path, .false., error)
   end subroutine check_rows

   !> Take over what an earlier life wrote: its rows and events up to a checkpoint, and what is
   !> known of the run besides. Its own rows are those first ones.
   subroutine restore(self, path, checkpoint, error)
      !> The file, open and empty.
      class(trajectory_type), intent(inout) :: self
      !> Name of the file that the earlier life wrote.
      character(len=*), intent(in) :: path
      type(checkpoint_type), intent(inout) :: checkpoint
      !> Set when one of the files cannot be read or written.
      type(error_type), allocatable, intent(out) :: error

      call self%exchange(checkpoint)
      call checkpoint%result(error)
      if (.not. allocated(error)) call copy_rows(self, path, .true., error)
      self%begun_rows = int(modulo(self%summary%rows, int(self%chunk_rows, i8)))
      if (.not. allocated(error)) call self%file%flush(error)
      if (.not. allocated(error)) call self%file%sync(error)
      self%lives = self%lives + 1
   end subroutine restore

   !> Read the rows and events of a file up to its summary, compare them with their checksums, and
   !> append them to another one.
   subroutine copy_rows(self, path, append, error)
      !> The other file, with the summary and the checksums; unless appended to, its columns need
      !> not be set.
      type(trajectory_type), intent(inout) :: self
      !> Name of the file to read.
      character(len=*), intent(in) :: path
      logical, intent(in) :: append
      !> Set when one of the files cannot be read or written, or has other rows.
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: parts(3) = [character(len=7) :: "time", "kind", "contact"]
      type(hdf5_reader_type) :: reader
      integer(i8) :: events
      integer :: i

      ! The checkpoint has sums of its own, of the rows up to it: those in a chunk that was being
      ! written when the run was killed are good.
      call reader%open(path, error, lenient=.true.)
      if (allocated(error)) return
      do i = 1, size(self%columns)
         associate (column => self%columns(i))
            call copy_series("/trajectory/", column%name, class_real, column%series, &
               self%summary%rows, few_rows, column%sum)
         end associate
      end do
      events = self%summary%touches + self%summary%lifts
      do i = 1, size(parts)
         call copy_series("/events/", trim(parts(i)), merge(class_real, class_text, i == 1), &
            self%event_series(i), events, chunk_events, self%event_sum(i))
      end do
      call reader%close()
      if (allocated(error)) error%message = path // ": " // error%message

   contains

      !> Copy the first rows of a series; nothing after an error.
      subroutine copy_series(group, name, class, series, rows, block, expected)
         !> Path of its group, with a slash at the end.
         character(len=*), intent(in) :: group
         character(len=*), intent(in) :: name
         !> `class_real` or `class_text`.
         integer, intent(in) :: class
         !> Where its rows go.
         type(hdf5_series_type), intent(in) :: series
         integer(i8), intent(in) :: rows
         !> Rows that are copied at a time.
         integer, intent(in) :: block
         !> Checksum of the rows.
         integer(i8), intent(in) :: expected
         type(hdf5_item_type) :: item
         type(string_type), allocatable :: texts(:)
         character(len=:), allocatable :: padded(:)
         real(wp), allocatable :: values(:)
         integer(i8) :: done, start(max_rank), count(max_rank), sum
         integer :: k, n, width

         if (allocated(error)) return
         call reader%open_item(group // name, "", item, error)
         if (allocated(error)) return
         if (item%class /= class .or. item%rank < 1 .or. item%extents(1) < rows) then
            call fatal(error, name // " has fewer rows than its checkpoint", status_file)
            call item%close()
            return
         end if
         width = int(product(item%extents(2:item%rank)))
         allocate(values(width*block))
         start = 0
         count = item%extents
         sum = 0
         done = 0
         do while (done < rows .and. .not. allocated(error))
            n = int(min(rows - done, int(block, i8)))
            start(1) = done
            count(1) = n
            if (class == class_text) then
               call item%read_texts(start, count, n, texts, error)
               if (allocated(error)) exit
               do k = 1, n
                  sum = checksum(sum, texts(k)%s // new_line("a"))
               end do
               call pad(texts(:n), padded)
               if (append) call self%file%append(series, n, padded, error)
            else
               if (width > 0) call item%read(start, count, values, error)
               if (allocated(error)) exit
               sum = checksum(sum, values(:n*width))
               if (append) call self%file%append(series, n, &
                  reshape(values(:n*width), [width, n]), error)
            end if
            done = done + n
         end do
         if (.not. allocated(error) .and. sum /= expected) call fatal(error, &
            "the rows of " // name // " are not those of its checkpoint", status_file)
         call item%close()
      end subroutine copy_series

   end subroutine copy_rows

   !> Take note of the method that is used from here on.
   subroutine use_method(self, t, method, choice)
      class(trajectory_type), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      character(len=*), intent(in) :: method
      !> Why `auto` begins with it; empty without `auto`, not present later on.
      character(len=*), intent(in), optional :: choice
      character(len=len(self%methods)), allocatable :: methods(:)

      if (present(choice)) then
         if (choice /= "") self%choice = choice
      end if
      if (.not. allocated(self%methods)) then
         allocate(self%methods(0), self%method_times(0))
      end if
      allocate(methods(size(self%methods) + 1))
      methods(:size(self%methods)) = self%methods
      methods(size(methods)) = method
      call move_alloc(methods, self%methods)
      self%method_times = [self%method_times, t]
   end subroutine use_method

   !> Write what remains, close, and give a complete file its final name.
   subroutine finish(self, system, y, statistics, status, error)
      class(trajectory_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      !> Final state.
      real(wp), intent(in) :: y(:)
      !> Counters of the integrator.
      type(statistics_type), intent(in) :: statistics
      !> `complete`, `interrupted` or `failed`.
      character(len=*), intent(in) :: status
      type(error_type), allocatable, intent(out) :: error

      if (self%waiting > 0) call append_rows(self, error)
      if (allocated(error)) return
      call append_events(self, error)
      if (allocated(error)) return
      associate (f => self%file, wall => wall_seconds() - self%clocks(1), &
         cpu => cpu_seconds() - self%clocks(2))
         call f%create_group("/integrator", error)
         call f%put_value("/integrator/steps", statistics%steps, "1", "steps", error)
         call f%put_value("/integrator/right_hand_sides", statistics%derivatives, "1", &
            "evaluations of the right-hand side, those for Jacobians included", error)
         call f%put_value("/integrator/jacobians", statistics%jacobians, "1", "Jacobians", error)
         call f%put_value("/integrator/error_test_failures", statistics%error_test_failures, "1", &
            "failed error tests", error)
         call f%put_value("/integrator/convergence_failures", statistics%convergence_failures, &
            "1", "failed nonlinear iterations", error)
         call f%put_value("/integrator/last_step", statistics%last_step, "s", "last step", error)
         if (allocated(self%methods)) then
            call f%put_labels("/integrator/method", self%methods, &
               "methods that were used, in order", error)
            call f%put_array("/integrator/method_since", self%method_times, &
               ["/integrator/method"], "s", "time since when each method was used", error)
         end if
         if (allocated(self%choice)) call f%put_text("/integrator/choice", self%choice, &
            "why auto began with its first method", error)
         if (allocated(self%cpu_by_effect)) then
            call f%put_labels("/integrator/effect", profile_names, &
               "what CPU time is spent in", error)
            call f%put_array("/integrator/cpu_by_effect", self%cpu_by_effect, &
               ["/integrator/effect"], "s", "CPU time by effect, sampled", error)
            call f%put_array("/integrator/cpu_share", self%cpu_by_effect &
               /max(sum(self%cpu_by_effect), tiny(1.0_wp)), ["/integrator/effect"], "1", &
               "share of the CPU time", error)
         end if
         call f%put_value("/integrator/cpu_output", self%cpu_output, "s", &
            "CPU time spent in writing rows", error)
         call f%put_value("/integrator/cpu_integration", cpu - self%cpu_output, "s", &
            "CPU time spent in everything else", error)
         call f%put_value("/provenance/wall_s", wall, "s", "wall time of the run", error)
         call f%put_value("/provenance/cpu_s", cpu, "s", "CPU time of the run", error)
         call f%put_value("/provenance/lives", self%lives, "1", &
            "how often the run was begun or continued", error)
         call put_summary(self, system, y, statistics, cpu, error)
         if (allocated(self%stopped_by)) call f%put_attribute("/", "stopped_by", self%stopped_by, &
            error)
         call f%put_attribute("/", "status", status, error)
         if (allocated(self%warning)) call f%put_attribute("/", "warning", self%warning, error)
         ! A failure is kept by the file, so that closing reports the first one.
         if (status == "complete") then
            call f%close_as(self%name, self%replace, error)
         else
            call f%close(error)
         end if
      end associate
   end subroutine finish

   !> The row that a run is in a sweep.
   subroutine put_summary(self, system, y, statistics, cpu, error)
      class(trajectory_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      !> Final state.
      real(wp), intent(in) :: y(:)
      !> Counters of the integrator.
      type(statistics_type), intent(in) :: statistics
      !> CPU time of the run [s].
      real(wp), intent(in) :: cpu
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: g = "/summary/"
      real(wp), allocatable :: state(:, :)
      real(wp) :: values(size(summary_quantities))
      type(quantity_type), allocatable :: finals(:)
      integer :: i, first, last

      values = self%summary%values(statistics)
      call self%last%final_state(system, self%summary%time, y, state)
      finals = final_quantities()
      associate (f => self%file)
         call f%create_group("/summary", error)
         call f%put_labels(g // "body", self%body_names, "body", error)
         call f%put_labels(g // "xyz", ["x", "y", "z"], "axis of the inertial frame", error)
         call f%put_labels(g // "wxyz", ["w", "x", "y", "z"], "component of a quaternion", error)
         do i = 1, size(summary_quantities)
            if (i == summary_stop .and. self%summary%stop < 0) cycle
            associate (q => summary_quantities(i))
               if (q%is_integer) then
                  call f%put_value(g // trim(q%name), nint(values(i), i8), trim(q%units), &
                     trim(q%long_name), error)
               else
                  call f%put_value(g // trim(q%name), values(i), trim(q%units), &
                     trim(q%long_name), error)
               end if
            end associate
         end do
         call f%put_value(g // "cpu_s", cpu, "s", "CPU time of the run", error)
         last = 0
         do i = 1, size(finals)
            associate (q => finals(i))
               first = last + 1
               last = last + q%components
               call f%put_array(g // trim(q%name), state(first:last, :), &
                  [character(len=13) :: g // "body", g // q%dims(len("body ") + 1:)], &
                  trim(q%units), trim(q%long_name), error)
            end associate
         end do
      end associate
   end subroutine put_summary

   !> Whether the file was created and is not finished.
   pure function is_open(self) result(answer)
      class(trajectory_type), intent(in) :: self
      logical :: answer

      answer = self%file%is_open()
   end function is_open

   !> Give up after a failure to write: nothing stays open.
   subroutine abandon(self)
      class(trajectory_type), intent(inout) :: self

      call self%file%abandon()
   end subroutine abandon

end module contensou_files_trajectory
