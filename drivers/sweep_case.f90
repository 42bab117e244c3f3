!> One case of a sweep: from its number to its row, in memory. Thread-safe.
!>
!> The numbers are those that `contensou run` writes for the same scene: the same march, the same
!> rows, the same summary.
module contensou_drivers_sweep_case
   use, intrinsic :: ieee_arithmetic, only : ieee_quiet_nan, ieee_value
   use contensou_sweep_crew, only : begin_piece, crew_stopping
   use contensou_base_errors, only : error_type
   use contensou_base_kinds, only : i8, wp
   use contensou_base_operating_system, only : wall_seconds
   use contensou_base_text, only : number_text
   use contensou_base_text_lock, only : lock_texts, unlock_texts
   use contensou_integrate_march, only : event_touch, observer_type
   use contensou_integrate_motion, only : motion_type
   use contensou_study_simulation, only : new_simulation, simulate, simulation_type
   use contensou_study_quantities, only : final_quantities, row_type
   use contensou_study_quantity, only : quantity_type
   use contensou_study_summary, only : summary_type
   use contensou_scene_reader, only : scene_file_type
   use contensou_sweep_plan, only : source_event, source_state, source_summary, source_value, &
      sweep_type
   use contensou_sweep_table, only : case_complete, case_failed, case_invalid, case_too_long
   implicit none(type, external)
   private

   public :: outline_type, outline_of, run_case

   !> Steps between two looks at the clock.
   integer, parameter :: steps_between = 8

   !> Where the columns of the results come from, in the terms of rows and summaries.
   type :: outline_type
      !> Source of each column, one of the `source_*` codes.
      integer, allocatable :: source(:)
      !> Number in the summary, in the final state of a body, among the events of a contact, or the
      !> quantity of a row.
      integer, allocatable :: place(:)
      !> Body or contact; 0 for neither.
      integer, allocatable :: index(:)
      !> Component within a row.
      integer, allocatable :: component(:)
      !> Columns of values at times, in the order of their times.
      integer, allocatable :: timed(:)
      !> Times of these [s].
      real(wp), allocatable :: times(:)
   end type outline_type

   !> Events of a contact, in the order of `event_names`.
   integer, parameter :: e_first_touch = 1, e_last_touch = 2, e_first_lift = 3, e_last_lift = 4, &
      e_touches = 5, e_lifts = 6

   !> Who looks on at a case.
   type, extends(observer_type) :: witness_type
      !> What is wanted.
      type(outline_type), pointer :: outline => null()
      !> The last row.
      type(row_type) :: row
      !> What the case comes down to so far.
      type(summary_type) :: summary
      !> Events, (`e_*`, contact).
      real(wp), allocatable :: events(:, :)
      !> Values at times, in the order of `timed`.
      real(wp), allocatable :: values(:)
      !> Whether each of these is known.
      logical, allocatable :: taken(:)
      !> The first one that is not.
      integer :: due = 1
      !> Steps since the clock was looked at.
      integer :: steps = 0
      !> When the case is given up [s].
      real(wp) :: deadline = huge(1.0_wp)
      !> Whether it was.
      logical :: late = .false.
   contains
      procedure :: sample
      procedure :: event
      procedure :: after_step
      procedure :: between
   end type witness_type

contains

   !> Where the columns of a sweep come from.
   function outline_of(sweep) result(outline)
      type(sweep_type), intent(in) :: sweep
      type(outline_type) :: outline
      type(quantity_type), allocatable :: finals(:)
      integer :: i, n

      finals = final_quantities()
      n = size(sweep%results)
      allocate(outline%source(n), outline%place(n), outline%index(n), outline%component(n))
      do i = 1, n
         associate (r => sweep%results(i))
            outline%source(i) = r%source
            outline%index(i) = r%index
            outline%component(i) = r%component
            outline%place(i) = r%quantity
            if (r%source == source_state) outline%place(i) = r%component + &
               sum(finals(:r%quantity - 1)%components())
         end associate
      end do
      call order_times(sweep, outline)
   end function outline_of

   !> Order the values at times by their times.
   subroutine order_times(sweep, outline)
      type(sweep_type), intent(in) :: sweep
      !> Where its columns come from.
      type(outline_type), intent(inout) :: outline
      integer :: i, j, column, n

      n = count(outline%source == source_value)
      allocate(outline%timed(n), outline%times(n))
      n = 0
      do i = 1, size(sweep%results)
         if (sweep%results(i)%source /= source_value) cycle
         n = n + 1
         outline%timed(n) = i
      end do
      do i = 2, n
         column = outline%timed(i)
         j = i - 1
         do while (j >= 1)
            if (sweep%results(outline%timed(j))%time <= sweep%results(column)%time) exit
            outline%timed(j + 1) = outline%timed(j)
            j = j - 1
         end do
         outline%timed(j + 1) = column
      end do
      do i = 1, n
         outline%times(i) = sweep%results(outline%timed(i))%time
      end do
   end subroutine order_times

   !> Run a case.
   subroutine run_case(sweep, outline, number, thread, results, status, message, stopped)
      type(sweep_type), intent(in) :: sweep
      !> Where its columns come from.
      type(outline_type), intent(in), target :: outline
      !> Number of the case.
      integer(i8), intent(in) :: number
      !> Number of the thread of a crew; 0 outside of one.
      integer, intent(in) :: thread
      !> The columns; NaN unless the case is complete.
      real(wp), intent(out) :: results(:)
      !> One of the `case_*` codes.
      integer, intent(out) :: status
      !> What went wrong.
      character(len=:), allocatable, intent(out) :: message
      !> Whether the case was left because all stop; then there is no row.
      logical, intent(out) :: stopped
      type(scene_file_type) :: file
      type(simulation_type) :: simulation
      type(witness_type) :: witness
      type(error_type), allocatable :: error

      results = ieee_value(results, ieee_quiet_nan)
      message = ""
      stopped = .false.
      status = case_invalid
      call lock_texts()
      call begin_piece(thread)
      if (sweep%time_limit < huge(sweep%time_limit)) witness%deadline = wall_seconds() + &
         sweep%time_limit
      call sweep%scene_of(number, file, error)
      if (.not. allocated(error)) then
         status = case_failed
         call new_simulation(file, simulation, error)
      end if
      if (allocated(error)) then
         message = error%message
         call unlock_texts()
         return
      end if
      call unlock_texts()

      witness%outline => outline
      call prepare(witness, simulation%motion)
      call simulate(simulation, witness, error)
      if (witness%late) then
         status = case_too_long
         call lock_texts()
         message = "given up at t = " // number_text(simulation%time(), 6) // " s after " // &
            number_text(sweep%time_limit, 4) // " s of wall time"
         call unlock_texts()
      else if (allocated(error)) then
         message = error%message
      else if (simulation%stopped) then
         stopped = .true.
      else
         status = case_complete
         call collect(witness, simulation, results)
      end if
   end subroutine run_case

   !> Make a witness ready.
   subroutine prepare(witness, motion)
      type(witness_type), intent(inout) :: witness
      type(motion_type), intent(in) :: motion

      call witness%row%prepare(motion%system)
      allocate(witness%events(e_lifts, motion%n_events))
      witness%events = ieee_value(1.0_wp, ieee_quiet_nan)
      witness%events(e_touches:, :) = 0.0_wp
      allocate(witness%values(size(witness%outline%timed)))
      witness%values = ieee_value(1.0_wp, ieee_quiet_nan)
      allocate(witness%taken(size(witness%values)))
      witness%taken = .false.
      if (size(witness%values) > 0) witness%next_time = witness%outline%times(1)
   end subroutine prepare

   !> Fill the columns of a case that is complete.
   subroutine collect(witness, simulation, results)
      type(witness_type), intent(inout) :: witness
      !> At its end.
      type(simulation_type), intent(in) :: simulation
      !> The columns.
      real(wp), intent(inout) :: results(:)
      real(wp), allocatable :: summary(:), state(:, :)
      integer :: i

      summary = witness%summary%values(simulation%memory%statistics)
      call witness%row%final_state(simulation%motion%system, simulation%memory%t, &
         simulation%memory%y, state)
      associate (o => witness%outline)
         do i = 1, size(results)
            select case (o%source(i))
            case (source_summary)
               results(i) = summary(o%place(i))
            case (source_state)
               ! A parameter may be the number of parts of a bearing.
               if (o%index(i) <= size(state, 2)) results(i) = state(o%place(i), o%index(i))
            case (source_event)
               if (o%index(i) <= size(witness%events, 2)) then
                  results(i) = witness%events(o%place(i), o%index(i))
               end if
            case default
               ! A value at a time.
               cycle
            end select
         end do
         do i = 1, size(o%timed)
            results(o%timed(i)) = witness%values(i)
         end do
      end associate
   end subroutine collect

   !> A row is due.
   subroutine sample(self, motion, t, y, error)
      class(witness_type), intent(inout) :: self
      class(motion_type), intent(inout) :: motion
      !> Time [s].
      real(wp), intent(in) :: t
      !> State.
      real(wp), intent(in) :: y(:)
      !> Never set.
      type(error_type), allocatable, intent(out) :: error

      call self%summary%add_row(self%row, motion%system, t, y)
      ! A value at the time of a row is that of the row.
      if (self%next_time <= t + 16.0_wp*spacing(t)) call take_values(self, t)
   end subroutine sample

   !> A state that is asked for beside the rows.
   subroutine between(self, motion, t, y)
      class(witness_type), intent(inout) :: self
      class(motion_type), intent(inout) :: motion
      !> Time [s].
      real(wp), intent(in) :: t
      !> State.
      real(wp), intent(in) :: y(:)

      call self%summary%look(self%row, motion%system, t, y)
      call take_values(self, t)
   end subroutine between

   !> Take the values at the time of the last row; a later one may come before an earlier one.
   subroutine take_values(self, t)
      type(witness_type), intent(inout) :: self
      !> Time of the row [s].
      real(wp), intent(in) :: t
      integer :: i, column, place, within

      do i = self%due, size(self%values)
         if (self%outline%times(i) > t + 16.0_wp*spacing(t)) exit
         if (self%taken(i) .or. self%outline%times(i) < t - 16.0_wp*spacing(t)) cycle
         column = self%outline%timed(i)
         place = self%outline%place(column)
         within = self%outline%component(column)
         if (self%outline%index(column) > 1) within = within + (self%outline%index(column) - 1) &
            *self%row%quantities(place)%components()
         if (within <= self%row%width(place)) self%values(i) = &
            self%row%values(self%row%start(place) + within)
         self%taken(i) = .true.
      end do
      self%next_time = huge(t)
      do i = self%due, size(self%values)
         self%due = i
         if (self%taken(i)) cycle
         self%next_time = self%outline%times(i)
         exit
      end do
   end subroutine take_values

   !> A contact touched or lifted off.
   subroutine event(self, t, kind, contact, error)
      class(witness_type), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> `event_touch` or `event_lift`.
      integer, intent(in) :: kind
      !> Index of the contact.
      integer, intent(in) :: contact
      !> Never set.
      type(error_type), allocatable, intent(out) :: error
      integer :: first, last, number

      call self%summary%add_event(kind == event_touch)
      first = merge(e_first_touch, e_first_lift, kind == event_touch)
      last = merge(e_last_touch, e_last_lift, kind == event_touch)
      number = merge(e_touches, e_lifts, kind == event_touch)
      associate (e => self%events(:, contact))
         if (e(number) <= 0.0_wp) e(first) = t
         e(last) = t
         e(number) = e(number) + 1.0_wp
      end associate
   end subroutine event

   !> A step is done: is there time for another one?
   subroutine after_step(self, t, stop_now, error)
      class(witness_type), intent(inout) :: self
      !> Time reached [s].
      real(wp), intent(in) :: t
      !> Whether to stop here.
      logical, intent(out) :: stop_now
      !> Never set.
      type(error_type), allocatable, intent(out) :: error

      stop_now = crew_stopping()
      if (stop_now .or. self%deadline >= huge(t)) return
      self%steps = self%steps + 1
      if (self%steps < steps_between) return
      self%steps = 0
      self%late = wall_seconds() > self%deadline
      stop_now = self%late
   end subroutine after_step

end module contensou_drivers_sweep_case
