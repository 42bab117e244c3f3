!> `contensou check` of a sweep: what there is to do, and what it will cost, from a few timed cases.
module contensou_drivers_sweep_check
   use contensou_base_errors, only : error_type
   use contensou_base_kinds, only : i8, wp
   use contensou_base_numbers, only : counted, number_text, to_text
   use contensou_base_operating_system, only : cpu_seconds, write_stdout
   use contensou_base_text, only : join, string_type
   use contensou_integrate_observer, only : observer_type
   use contensou_integrate_motion, only : motion_type
   use contensou_drivers_report, only : heed_warnings
   use contensou_study_simulation, only : new_simulation, simulate, simulation_type
   use contensou_study_quantities, only : row_type
   use contensou_scene_reader, only : scene_file_type
   use contensou_sweep_cases, only : check_output_paths
   use contensou_sweep_plan, only : sweep_type
   use contensou_sweep_reader, only : read_sweep
   use contensou_sweep_selection, only : select_cases, selection_type
   use contensou_sweep_sampling, only : sampling_grid, sampling_names
   implicit none(type, external)
   private

   public :: check_sweep

   !> Observer that does what a case of a sweep does with its rows, until the CPU time is over.
   type, extends(observer_type) :: stopwatch_type
      !> CPU time at which to stop [s].
      real(wp) :: deadline = 0.0_wp
      !> Steps since the clock was looked at.
      integer :: steps = 0
      !> The last row.
      type(row_type) :: row
   contains
      procedure :: sample
      procedure :: after_step
   end type stopwatch_type

   !> What the timed cases came to.
   type :: trial_type
      !> Cases that were timed.
      integer :: n = 0
      !> Those whose scene is not valid.
      integer :: invalid = 0
      !> Those that failed.
      integer :: failed = 0
      !> Those that were left before their end.
      integer :: unfinished = 0
      !> CPU time that they took [s].
      real(wp) :: spent = 0.0_wp
      !> Estimated CPU time of a case: mean, its standard error, least, largest [s].
      real(wp) :: mean = 0.0_wp, uncertainty = 0.0_wp, least = huge(1.0_wp), largest = 0.0_wp
   end type trial_type

   !> Most cases that are timed.
   integer, parameter :: most_trials = 40

   !> CPU time after which no other case is begun [s].
   real(wp), parameter :: budget = 4.0_wp

   !> CPU time after which a case is left [s].
   real(wp), parameter :: longest_trial = 1.0_wp

   !> Steps between two looks at the clock.
   integer, parameter :: steps_between = 16

   !> CPU time of a shard that is aimed at [s]: between 10 and 60 minutes.
   real(wp), parameter :: shard_cpu = 1800.0_wp

   !> Fractional part of the golden ratio: its multiples are spread evenly modulo 1.
   real(wp), parameter :: golden = 0.61803398874989485_wp

   character(len=*), parameter :: nl = new_line("a")

contains

   !> Read a sweep and report what it will cost.
   subroutine check_sweep(name, overrides, strict, error)
      !> Name of the sweep file.
      character(len=*), intent(in) :: name
      !> Settings that replace those of the scene in all cases.
      type(string_type), intent(in) :: overrides(:)
      !> Whether warnings are errors.
      logical, intent(in) :: strict
      !> Set when the sweep has a mistake.
      type(error_type), allocatable, intent(out) :: error
      type(sweep_type) :: sweep
      type(selection_type) :: selection
      type(trial_type) :: trial
      type(string_type), allocatable :: names(:)
      character(len=:), allocatable :: text
      integer(i8) :: shards
      real(wp) :: hours
      integer :: i

      call read_sweep(name, overrides, "", sweep, error)
      if (.not. allocated(error)) call select_cases("", [0, 0], sweep%n_cases, selection, error)
      if (.not. allocated(error)) call check_output_paths(sweep%output, sweep, selection, .false., &
         error)
      if (allocated(error)) return
      call heed_warnings(sweep%base%file, sweep%scene_path, strict, error)
      if (allocated(error)) return
      text = name // " is in order" // nl // "  scene       " // sweep%scene_path // nl
      if (sweep%scene%title /= "") text = text // "              " // sweep%scene%title // nl
      do i = 1, size(sweep%overrides)
         text = text // "  set         " // sweep%overrides(i)%s // nl
      end do
      text = text // "  sampling    " // trim(sampling_names(sweep%sampling)) // nl
      do i = 1, size(sweep%parameters)
         associate (parameter => sweep%parameters(i))
            text = text // "  parameter   " // parameter%name // unit_text(parameter%units) // &
               ": " // parameter%words() // nl
            if (parameter%long_name /= parameter%name) text = text // "              sets " // &
               parameter%long_name // nl
         end associate
      end do
      allocate(names(size(sweep%results)))
      do i = 1, size(names)
         names(i)%s = sweep%results(i)%name
      end do
      text = text // "  results     " // to_text(size(names)) // ": " // join(names, ", ") // nl
      if (size(sweep%trajectories) > 0) text = text // "  kept, too   the output files of " // &
         counted(size(sweep%trajectories, kind=i8), "case") // nl
      if (sweep%time_limit < huge(hours)) text = text // "  time limit  " // &
         number_text(sweep%time_limit, 4) // " s of wall time for a case" // nl
      text = text // "  output      " // sweep%output // nl
      call time_cases(sweep, trial)
      hours = trial%mean*real(sweep%n_cases, wp)/3600.0_wp
      shards = max(1_i8, min(sweep%n_cases, ceiling(min(hours*3600.0_wp/shard_cpu, 1.0e9_wp), i8)))
      text = text // "cost" // nl // "  trial       " // to_text(trial%n) // trim(merge( &
         " case  ", " cases ", trial%n == 1)) // " in " // number_text(trial%spent, 3) // &
         " s of CPU: " // number_text(trial%least, 3) // " to " // &
         number_text(trial%largest, 3) // " s each, " // number_text(trial%mean, 3) // &
         " s on average" // nl
      if (trial%unfinished > 0) text = text // "              " // &
         to_text(trial%unfinished) // " of them not to the end, their times are extrapolated" // nl
      if (trial%invalid > 0) text = text // "              " // to_text(trial%invalid) // &
         " of them without a valid scene" // nl
      if (trial%failed > 0) text = text // "              " // to_text(trial%failed) // &
         " of them failed" // nl
      text = text // "  table       up to " // number_text(8.0e-6_wp*real(sweep%n_cases, wp) &
         *(size(sweep%results) + size(sweep%parameters) + 1), 2) // " MB" // nl
      text = text // "cases       " // to_text(sweep%n_cases) // nl
      text = text // "cpu_hours   " // number_text(hours, 3) // uncertainty_text(trial) // nl
      text = text // "shards      " // to_text(shards) // "  (about " // &
         number_text(max(hours/real(shards, wp)*60.0_wp, 1.0e-3_wp), 2) // &
         " min of CPU each)" // nl
      call write_stdout(text, error)
   end subroutine check_sweep

   !> A unit in brackets.
   pure function unit_text(units) result(text)
      !> The unit; empty for none.
      character(len=*), intent(in) :: units
      character(len=:), allocatable :: text

      text = ""
      if (units /= "") text = " [" // units // "]"
      if (units == "1") text = " [-]"
   end function unit_text

   !> How far the estimate may be off.
   function uncertainty_text(trial) result(text)
      type(trial_type), intent(in) :: trial
      character(len=:), allocatable :: text

      text = "  (hours of CPU"
      if (trial%n > 2 .and. trial%mean > 0.0_wp) text = text // ", give or take " // &
         to_text(nint(200.0_wp*trial%uncertainty/trial%mean)) // " %"
      text = text // ")"
   end function uncertainty_text

   !> Time some cases, spread evenly over their numbers.
   subroutine time_cases(sweep, trial)
      type(sweep_type), intent(in) :: sweep
      type(trial_type), intent(out) :: trial
      real(wp) :: seconds, squares
      integer(i8) :: number, taken(most_trials)
      integer :: k

      squares = 0.0_wp
      k = 0
      do while (k < most_trials .and. trial%spent < budget)
         k = k + 1
         if (sweep%n_cases <= most_trials) then
            if (k > sweep%n_cases) exit
            number = k
         else
            number = 1 + int(modulo(golden*k, 1.0_wp)*real(sweep%n_cases, wp), i8)
            if (sweep%sampling == sampling_grid) then
               ! Far from each other in the parameters that vary fast, too.
               number = min(number + k, sweep%n_cases)
            end if
            if (any(taken(:k - 1) == number)) then
               taken(k) = 0
               cycle
            end if
         end if
         taken(k) = number
         call time_case(sweep, number, seconds, trial)
         trial%n = trial%n + 1
         trial%mean = trial%mean + seconds
         squares = squares + seconds**2
         trial%least = min(trial%least, seconds)
         trial%largest = max(trial%largest, seconds)
      end do
      trial%mean = trial%mean/trial%n
      if (trial%n > 1) trial%uncertainty = sqrt(max(0.0_wp, squares/trial%n - trial%mean**2) &
         /(trial%n - 1))
   end subroutine time_cases

   !> Run a case, or as much of it as tells its CPU time.
   subroutine time_case(sweep, number, seconds, trial)
      type(sweep_type), intent(in) :: sweep
      !> Number of the case.
      integer(i8), intent(in) :: number
      !> CPU time that it takes, estimated if it is left before its end [s].
      real(wp), intent(out) :: seconds
      !> What is known of the cases so far.
      type(trial_type), intent(inout) :: trial
      type(scene_file_type) :: file
      type(simulation_type) :: simulation
      type(stopwatch_type) :: stopwatch
      type(error_type), allocatable :: error
      real(wp) :: start

      start = cpu_seconds()
      call sweep%scene_of(number, file, error)
      if (allocated(error)) then
         trial%invalid = trial%invalid + 1
         seconds = cpu_seconds() - start
         trial%spent = trial%spent + seconds
         return
      end if
      call new_simulation(file, simulation, error)
      call stopwatch%row%prepare(simulation%motion%system, file%scene%output)
      stopwatch%deadline = start + longest_trial
      if (.not. allocated(error)) call simulate(simulation, stopwatch, error)
      seconds = cpu_seconds() - start
      trial%spent = trial%spent + seconds
      if (allocated(error)) then
         trial%failed = trial%failed + 1
      else if (simulation%stopped) then
         trial%unfinished = trial%unfinished + 1
         if (simulation%time() > 0.0_wp) seconds = seconds*max(1.0_wp, &
            file%scene%t_end/simulation%time())
      end if
      seconds = min(seconds, sweep%time_limit)
   end subroutine time_case

   !> A row is due.
   subroutine sample(self, motion, t, y, error)
      class(stopwatch_type), intent(inout) :: self
      class(motion_type), intent(inout) :: motion
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)
      type(error_type), allocatable, intent(out) :: error

      call self%row%at%look(motion%system, t, y, error)
      if (.not. allocated(error)) call self%row%fill()
   end subroutine sample

   !> Stop when the time is over.
   subroutine after_step(self, t, stop_now, error)
      class(stopwatch_type), intent(inout) :: self
      real(wp), intent(in) :: t
      !> Whether the CPU time is spent.
      logical, intent(out) :: stop_now
      type(error_type), allocatable, intent(out) :: error

      stop_now = .false.
      self%steps = self%steps + 1
      if (self%steps < steps_between) return
      self%steps = 0
      stop_now = cpu_seconds() > self%deadline
   end subroutine after_step

end module contensou_drivers_sweep_check
