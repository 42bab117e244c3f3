!> One case of a sweep: from its number to its row, in memory. Thread-safe.
!>
!> The numbers are those that `contensou run` writes for the same scene: the same march, the same
!> rows, the same summary.
module contensou_sweep_case
   use, intrinsic :: ieee_arithmetic, only : ieee_quiet_nan, ieee_value
   use contensou_base_errors, only : error_type, fatal
   use contensou_base_kinds, only : i8, wp
   use contensou_base_numbers, only : number_text
   use contensou_base_operating_system, only : wall_seconds
   use contensou_base_text_lock, only : lock_texts, unlock_texts
   use contensou_scene_reader, only : scene_file_type
   use contensou_study_case, only : outline_type, source_state, source_value, witness_type
   use contensou_study_quantities, only : final_quantities
   use contensou_study_quantity, only : quantity_type
   use contensou_study_simulation, only : new_simulation, simulate, simulation_type
   use contensou_sweep_crew, only : begin_piece, crew_stopping
   use contensou_sweep_plan, only : sweep_type
   use contensou_sweep_table, only : case_complete, case_failed, case_invalid, case_too_long
   implicit none(type, external)
   private

   public :: outline_of, run_case

   !> Steps between two looks at the clock.
   integer, parameter :: steps_between = 8

   !> A witness that stops when its time is over or its crew stops.
   type, extends(witness_type) :: hurried_type
      !> Steps since the clock was looked at.
      integer :: steps = 0
      !> When the case is given up [s].
      real(wp) :: deadline = huge(1.0_wp)
      !> Whether it was.
      logical :: late = .false.
   contains
      procedure :: after_step
   end type hurried_type

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
               sum(finals(:r%quantity - 1)%components)
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

   !> Build and simulate a case; what goes wrong is its status and message.
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
      character(len=:), allocatable, intent(out) :: message
      !> Whether the case was left because all stop; then there is no row.
      logical, intent(out) :: stopped
      type(scene_file_type) :: file
      type(simulation_type) :: simulation
      type(hurried_type) :: witness
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
      if (.not. allocated(error)) call check_spots(sweep%scene%contacts%spots, &
         simulation%scene%contacts%spots, error)
      if (allocated(error)) then
         message = error%message
         call unlock_texts()
         return
      end if
      call unlock_texts()

      call witness%prepare(outline, simulation%motion)
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
         call witness%collect(simulation, results)
      end if
   end subroutine run_case

   !> See that the contacts have as many spots as in the scene of the sweep, that columns are of.
   subroutine check_spots(base, own, error)
      !> Spots of the contacts of the scene of the sweep.
      integer, intent(in) :: base(:)
      !> Spots of those of the case.
      integer, intent(in) :: own(:)
      !> Set when they differ.
      type(error_type), allocatable, intent(out) :: error
      logical :: same

      if (all(base == 1) .and. all(own == 1)) return
      same = size(base) == size(own)
      if (same) same = all(base == own)
      if (.not. same) call fatal(error, "surfaces of this case can touch in another number of " // &
         "places than in the scene of the sweep, whose spots are the columns of the table; a " // &
         "sweep for the cases with as many spots as its scene keeps them apart")
   end subroutine check_spots

   !> A step is done: is there time for another one?
   subroutine after_step(self, t, stop_now, error)
      class(hurried_type), intent(inout) :: self
      real(wp), intent(in) :: t
      logical, intent(out) :: stop_now
      type(error_type), allocatable, intent(out) :: error

      stop_now = crew_stopping()
      if (stop_now .or. self%deadline >= huge(t)) return
      self%steps = self%steps + 1
      if (self%steps < steps_between) return
      self%steps = 0
      self%late = wall_seconds() > self%deadline
      stop_now = self%late
   end subroutine after_step

end module contensou_sweep_case
