!> A sweep: which cases there are, how to make the scene of each, and what is kept of it.
!>
!> A case is a function of its number alone: nothing is kept from case to case, so that any process
!> may do any of them, and memory does not grow with their number (but with the table of
!> `sampling = 'file'`).
module contensou_sweep_plan
   use contensou_base_diagnostics, only : diagnostics_type
   use contensou_base_document, only : document_type, value_logical, value_real, value_text, &
      value_type
   use contensou_base_errors, only : error_type, fatal, status_usage
   use contensou_base_kinds, only : i8, wp
   use contensou_base_numbers, only : to_text
   use contensou_base_settings, only : settings_type
   use contensou_base_text, only : string_type
   use contensou_dynamics_scene, only : scene_type
   use contensou_scene_reader, only : build_case, loaded_scene_type, resolve_scene, scene_file_type
   use contensou_sweep_points, only : points_type
   use contensou_sweep_sampling, only : sampler_type, sampling_file, sampling_grid
   use contensou_sweep_schema, only : vary_linear, vary_list, vary_log
   use contensou_sweep_target, only : target_type, value_words
   implicit none(type, external)
   private

   public :: sweep_type, parameter_column_type, result_column_type

   !> A column of the parameters of a sweep.
   type :: parameter_column_type
      character(len=:), allocatable :: name
      !> Paths that take the value, as `--set` takes them.
      type(string_type), allocatable :: paths(:)
      !> Units; empty for a text, or if they depend on the model.
      character(len=:), allocatable :: units
      character(len=:), allocatable :: long_name
      !> Whether the values are texts, and whether they are whole numbers.
      logical :: is_text = .false., is_whole = .false.
      !> How it varies, one of the `vary_*` codes; 0 for the rows of a table.
      integer :: vary = 0
      !> First and last value, or bounds.
      real(wp) :: first = 0.0_wp, last = 0.0_wp
      !> Number of values in a grid or a list.
      integer(i8) :: count = 1
      !> Values of a list; for a table the texts in it.
      type(value_type), allocatable :: list(:)
      !> What the paths stand for; of use to the reader of sweep files and to `sweep_type` only.
      type(target_type), allocatable :: targets(:)
   contains
      procedure :: words
   end type parameter_column_type

   !> A column of the results of a sweep. All results are handled as reals; those of counts become
   !> integers in the table.
   type :: result_column_type
      character(len=:), allocatable :: name
      character(len=:), allocatable :: units
      character(len=:), allocatable :: long_name
      !> Whether it is a count.
      logical :: is_integer = .false.
      !> One of the `source_*` codes.
      integer :: source = 0
      !> Index into the names of that source.
      integer :: quantity = 0
      !> Body or contact, as an index of the scene; 0 for neither.
      integer :: index = 0
      !> Component of a vector; 1 for a scalar.
      integer :: component = 1
      !> Time of a value [s].
      real(wp) :: time = 0.0_wp
   end type result_column_type

   !> A sweep as read: base scene, parameters, how they vary, what is kept.
   type :: sweep_type
      !> Name of the sweep file.
      character(len=:), allocatable :: path
      character(len=:), allocatable :: text
      !> Settings of the sweep file with defaults, as a namelist text, without those that the rows
      !> do not depend on.
      character(len=:), allocatable :: settings
      !> Name of the base scene's file.
      character(len=:), allocatable :: scene_path
      character(len=:), allocatable :: scene_text
      !> Base scene with all settings, as a namelist text.
      character(len=:), allocatable :: scene_resolved
      !> The base scene.
      type(scene_type) :: scene
      !> Settings that all cases have, as `--set` takes them.
      type(string_type), allocatable :: overrides(:)
      !> Name of the table.
      character(len=:), allocatable :: output
      !> What tells this sweep from others: of two with the same fingerprint, each case has the same
      !> row. 16 hexadecimal digits.
      character(len=16) :: fingerprint = ""
      !> One of the `sampling_*` codes.
      integer :: sampling = sampling_grid
      !> Number of cases; they are numbered from 1.
      integer(i8) :: n_cases = 0
      type(parameter_column_type), allocatable :: parameters(:)
      type(result_column_type), allocatable :: results(:)
      !> Longest wall time of a case [s]; huge without a limit.
      real(wp) :: time_limit = huge(1.0_wp)
      !> Cases of which the whole output file is kept, ascending.
      integer(i8), allocatable :: trajectories(:)
      !> What the cases are made from. Like the components below it is public for the reader of
      !> sweep files, which sets it; others have no use for it.
      type(loaded_scene_type) :: base
      !> Points of Latin hypercube and Sobol sequence.
      type(sampler_type) :: sampler
      !> Table of cases.
      type(points_type) :: points
      !> Whether cases need their bearings expanded again.
      logical :: expands = .false.
   contains
      procedure :: parameters_of
      procedure :: scene_of
      procedure :: overrides_of
      procedure :: inputs
      procedure, private :: value => value_of_case
   end type sweep_type

contains

   !> Names of the files that the sweep is read from; none of them is ever written over.
   pure function inputs(self) result(names)
      class(sweep_type), intent(in) :: self
      type(string_type), allocatable :: names(:)
      integer :: n

      n = 2
      if (allocated(self%points%path)) n = 3
      allocate(names(n))
      names(1)%s = self%path
      names(2)%s = self%scene_path
      if (n == 3) names(3)%s = self%points%path
   end function inputs

   !> Parameters of a case. Thread-safe.
   subroutine parameters_of(self, case_number, values, words)
      class(sweep_type), intent(in) :: self
      !> Number of the case, from 1.
      integer(i8), intent(in) :: case_number
      !> Value of each column; 0 for a text.
      real(wp), intent(out) :: values(:)
      !> Text of each column that is text; empty for the others.
      type(string_type), intent(inout) :: words(:)
      type(value_type) :: value
      integer :: i

      do i = 1, size(self%parameters)
         call self%value(i, case_number, value)
         values(i) = 0.0_wp
         select case (value%kind)
         case (value_text)
            words(i)%s = value%text
         case (value_logical)
            words(i)%s = to_text(value%logical)
         case default
            words(i)%s = ""
            values(i) = value%real
         end select
      end do
   end subroutine parameters_of

   !> A parameter of a case.
   pure subroutine value_of_case(self, p, case_number, value)
      class(sweep_type), intent(in) :: self
      !> Which parameter.
      integer, intent(in) :: p
      !> Number of the case, from 1.
      integer(i8), intent(in) :: case_number
      type(value_type), intent(inout) :: value
      integer(i8) :: stride, i
      real(wp) :: u
      integer :: k

      value%kind = value_real
      associate (parameter => self%parameters(p))
         select case (self%sampling)
         case (sampling_file)
            value%real = self%points%values(p, case_number)
            if (parameter%is_text) then
               k = nint(value%real)
               value = parameter%list(k)
            end if
         case (sampling_grid)
            stride = 1
            do k = p + 1, size(self%parameters)
               stride = stride*self%parameters(k)%count
            end do
            i = mod((case_number - 1)/stride, parameter%count) + 1
            if (parameter%vary == vary_list) then
               value = parameter%list(i)
            else if (i == 1) then
               value%real = parameter%first
            else if (i == parameter%count) then
               value%real = parameter%last
            else
               value%real = between(parameter, real(i - 1, wp)/real(parameter%count - 1, wp))
               if (parameter%is_whole) value%real = anint(value%real)
            end if
         case default
            u = self%sampler%coordinate(case_number, p)
            if (parameter%vary == vary_list) then
               i = min(int(u*real(parameter%count, wp), i8) + 1, parameter%count)
               value = parameter%list(i)
            else
               value%real = between(parameter, u)
            end if
         end select
      end associate
   end subroutine value_of_case

   !> A number between the bounds of a parameter.
   pure function between(parameter, u) result(x)
      type(parameter_column_type), intent(in) :: parameter
      !> Where between them, 0 to 1 [-].
      real(wp), intent(in) :: u
      real(wp) :: x

      if (parameter%vary == vary_log) then
         x = parameter%first*(parameter%last/parameter%first)**u
      else
         x = parameter%first*(1.0_wp - u) + parameter%last*u
      end if
      x = min(max(x, min(parameter%first, parameter%last)), max(parameter%first, parameter%last))
   end function between

   !> Scene of a case, checked as a scene file is. Thread-safe.
   subroutine scene_of(self, case_number, file, error)
      class(sweep_type), intent(in), target :: self
      !> Number of the case, from 1.
      integer(i8), intent(in) :: case_number
      !> The scene; its text and resolved text are not set.
      type(scene_file_type), intent(out) :: file
      !> Set when the case has no valid scene; one line.
      type(error_type), allocatable, intent(out) :: error
      type(string_type), allocatable :: overrides(:)
      type(document_type) :: document
      type(settings_type), target :: settings
      type(diagnostics_type) :: diagnostics
      type(value_type) :: value
      character(len=:), allocatable :: text
      integer :: i, k

      if (self%expands) then
         call self%overrides_of(case_number, overrides)
         document = self%base%raw
         call resolve_scene(document, self%base%schema, overrides, settings, diagnostics)
      else
         settings = self%base%settings
         do i = 1, size(self%parameters)
            call self%value(i, case_number, value)
            do k = 1, size(self%parameters(i)%targets)
               call self%parameters(i)%targets(k)%set(value, self%base%schema, settings)
            end do
         end do
      end if
      if (diagnostics%count() == 0) call build_case(settings, self%base%schema, &
         self%scene_path, file, diagnostics)
      if (diagnostics%count() == 0) return
      text = ""
      do i = 1, diagnostics%kept()
         if (i > 1) text = text // "; "
         text = text // diagnostics%message(i)
         if (diagnostics%expected(i) /= "") text = text // " (expected: " // &
            diagnostics%expected(i) // ")"
      end do
      call fatal(error, text, status_usage)
   end subroutine scene_of

   !> Settings of a case, those of all cases first: `contensou run SCENE --set ...` with them is the
   !> run that the case is. Thread-safe.
   subroutine overrides_of(self, case_number, overrides)
      class(sweep_type), intent(in) :: self
      !> Number of the case, from 1.
      integer(i8), intent(in) :: case_number
      type(string_type), allocatable, intent(out) :: overrides(:)
      type(value_type) :: value
      integer :: i, k, n

      n = size(self%overrides)
      do i = 1, size(self%parameters)
         n = n + size(self%parameters(i)%targets)
      end do
      allocate(overrides(n))
      n = size(self%overrides)
      do i = 1, n
         overrides(i)%s = self%overrides(i)%s
      end do
      do i = 1, size(self%parameters)
         call self%value(i, case_number, value)
         do k = 1, size(self%parameters(i)%targets)
            n = n + 1
            overrides(n)%s = self%parameters(i)%paths(k)%s // "=" // value_words(value)
         end do
      end do
   end subroutine overrides_of

   !> How a parameter varies, in words.
   function words(self) result(text)
      class(parameter_column_type), intent(in) :: self
      character(len=:), allocatable :: text
      integer, parameter :: most_shown = 6
      integer :: i

      select case (self%vary)
      case (vary_list)
         text = ""
         do i = 1, min(size(self%list), most_shown)
            if (i > 1) text = text // ", "
            text = text // value_words(self%list(i))
         end do
         if (size(self%list) > most_shown) text = text // ", ... (" // &
            to_text(size(self%list)) // " values)"
      case (vary_linear, vary_log)
         text = to_text(self%first) // " to " // to_text(self%last)
         if (self%count > 1) text = text // ", " // to_text(self%count) // " values"
         if (self%vary == vary_log) text = text // ", logarithmic"
      case default
         text = "from the table"
      end select
   end function words

end module contensou_sweep_plan
