!> One simulation among many, and what is taken from it as a row of numbers: scalars of its summary,
!> components of its final state, events of contacts, values at times.
module contensou_study_case
   use, intrinsic :: ieee_arithmetic, only : ieee_quiet_nan, ieee_value
   use contensou_base_errors, only : error_type
   use contensou_base_kinds, only : wp
   use contensou_dynamics_scene, only : output_spec_type
   use contensou_integrate_observer, only : event_touch, observer_type
   use contensou_integrate_motion, only : motion_type
   use contensou_study_quantities, only : row_type, shared_quantities
   use contensou_study_quantity, only : if_rolling, quantity_type
   use contensou_study_simulation, only : simulation_type
   use contensou_study_summary, only : summary_type
   implicit none(type, external)
   private

   public :: outline_type, witness_type
   public :: source_summary, source_state, source_event, source_value, event_names

   !> A result is a scalar of `/summary`: `quantity` is an index into `summary_quantities`.
   integer, parameter :: source_summary = 1

   !> A result is a component of the final state: `quantity` is an index into
   !> `final_quantities`, `index` the body.
   integer, parameter :: source_state = 2

   !> A result is about the events of a contact: `quantity` is an index into `event_names`, `index`
   !> the contact.
   integer, parameter :: source_event = 3

   !> A result is a value of a trajectory at a time: `quantity` is an index into
   !> `row_quantities`, `index` the body or contact, 0 for neither.
   integer, parameter :: source_value = 4

   !> What is kept of the events of a contact.
   character(len=*), parameter :: event_names(*) = [character(len=11) :: "first_touch", &
      "last_touch", "first_lift", "last_lift", "touches", "lifts"]

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
   contains
      procedure :: prepare
      procedure :: collect
      procedure :: sample
      procedure :: event
      procedure :: between
   end type witness_type

contains

   !> Make a witness ready.
   subroutine prepare(self, outline, motion)
      class(witness_type), intent(inout) :: self
      type(outline_type), intent(in), target :: outline
      type(motion_type), intent(in) :: motion
      type(quantity_type), pointer :: quantities(:)
      type(output_spec_type) :: wanted

      self%outline => outline
      wanted%contact_geometry = .true.
      quantities => shared_quantities()
      wanted%rolling = any(quantities(outline%place(outline%timed))%there == if_rolling)
      call self%row%prepare(motion%system, wanted)
      allocate(self%events(e_lifts, motion%n_events))
      self%events = ieee_value(1.0_wp, ieee_quiet_nan)
      self%events(e_touches:, :) = 0.0_wp
      allocate(self%values(size(self%outline%timed)))
      self%values = ieee_value(1.0_wp, ieee_quiet_nan)
      allocate(self%taken(size(self%values)))
      self%taken = .false.
      if (size(self%values) > 0) self%next_time = self%outline%times(1)
   end subroutine prepare

   !> Fill the columns of a case that is complete.
   subroutine collect(self, simulation, results)
      class(witness_type), intent(inout) :: self
      !> At its end.
      type(simulation_type), intent(in) :: simulation
      real(wp), intent(inout) :: results(:)
      real(wp), allocatable :: summary(:), state(:, :)
      integer :: i

      self%summary%stop = simulation%memory%stops%ended_by
      summary = self%summary%values(simulation%memory%statistics)
      call self%row%final_state(simulation%motion%system, simulation%memory%t, &
         simulation%memory%y, state)
      associate (o => self%outline)
         do i = 1, size(results)
            select case (o%source(i))
            case (source_summary)
               results(i) = summary(o%place(i))
            case (source_state)
               ! A parameter may be the number of parts of a bearing.
               if (o%index(i) <= size(state, 2)) results(i) = state(o%place(i), o%index(i))
            case (source_event)
               if (o%index(i) <= size(self%events, 2)) then
                  results(i) = self%events(o%place(i), o%index(i))
               end if
            case default
               ! A value at a time.
               cycle
            end select
         end do
         do i = 1, size(o%timed)
            results(o%timed(i)) = self%values(i)
         end do
      end associate
   end subroutine collect

   !> A row is due.
   subroutine sample(self, motion, t, y, error)
      class(witness_type), intent(inout) :: self
      class(motion_type), intent(inout) :: motion
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)
      type(error_type), allocatable, intent(out) :: error

      call self%summary%add_row(self%row, motion%system, t, y, error)
      if (allocated(error)) return
      ! A value at the time of a row is that of the row.
      if (self%next_time <= t + 16.0_wp*spacing(t)) call take_values(self, t)
   end subroutine sample

   !> A state that is asked for beside the rows.
   subroutine between(self, motion, t, y, error)
      class(witness_type), intent(inout) :: self
      class(motion_type), intent(inout) :: motion
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)
      type(error_type), allocatable, intent(out) :: error

      call self%summary%look(self%row, motion%system, t, y, error)
      if (.not. allocated(error)) call take_values(self, t)
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
            *self%row%quantities(place)%components
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
      real(wp), intent(in) :: t
      integer, intent(in) :: kind
      integer, intent(in) :: contact
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

end module contensou_study_case
