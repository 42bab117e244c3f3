!> The trajectories that a sweep writes once its rows are there, as pieces of work for a crew.
module contensou_sweep_trajectories
   use contensou_sweep_crew, only : crew_stopping, job_type, piece_done, piece_stopped, run_crew
   use contensou_base_errors, only : error_type, fatal, status_file
   use contensou_sweep_journal, only : journal_message_length
   use contensou_base_kinds, only : i8, wp
   use contensou_base_numbers, only : to_text
   use contensou_base_operating_system, only : file_exists, remove_file
   use contensou_base_output_path, only : what_helps
   use contensou_base_text, only : command_text, string_type
   use contensou_sweep_cases, only : cases_type
   use contensou_sweep_selection, only : named, selection_type
   use contensou_scene_reader, only : read_scene, scene_file_type
   use contensou_sweep_plan, only : sweep_type
   use contensou_sweep_table, only : case_complete, case_failed
   use contensou_files_earlier, only : earlier_type, forget
   use contensou_files_recorder, only : recorder_type
   use contensou_study_simulation, only : new_simulation, simulate, simulation_type
   use contensou_files_trajectory, only : part_suffix
   implicit none(type, external)
   private

   public :: trajectories_type, list_trajectories, write_trajectories, run_words

   !> Recorder that stops when its crew does.
   type, extends(recorder_type) :: quiet_recorder_type
   contains
      procedure :: after_step
   end type quiet_recorder_type

   !> Wall time that a case may take whose trajectory is written, over its time limit.
   real(wp), parameter :: writing_allowance = 10.0_wp

   !> Value of errno for what the system says nothing more about.
   integer, parameter :: input_output_error = 5

   !> Trajectories as pieces of work for a crew.
   type, extends(job_type) :: trajectories_type
      type(sweep_type), pointer :: sweep => null()
      integer(i8), allocatable :: numbers(:)
      type(string_type), allocatable :: files(:)
   contains
      procedure :: work => work_trajectory
      procedure :: done => done_trajectory
      procedure :: lost => lost_trajectory
      procedure :: look => look_trajectories
   end type trajectories_type

contains

   !> The trajectories that are wanted of these cases.
   subroutine list_trajectories(sweep, selection, may_exist, force, list, error)
      type(sweep_type), intent(in), target :: sweep
      type(selection_type), intent(in) :: selection
      !> Whether files that exist are no reason not to begin.
      logical, intent(in) :: may_exist
      !> Whether to remove these.
      logical, intent(in) :: force
      type(trajectories_type), intent(inout) :: list
      !> Set when a file is in the way.
      type(error_type), allocatable, intent(out) :: error
      integer :: i, n
      logical :: is

      n = 0
      do i = 1, size(sweep%trajectories)
         if (selection%position_of(sweep%trajectories(i)) > 0) n = n + 1
      end do
      allocate(list%numbers(n), list%files(n))
      list%sweep => sweep
      n = 0
      do i = 1, size(sweep%trajectories)
         if (selection%position_of(sweep%trajectories(i)) == 0) cycle
         n = n + 1
         list%numbers(n) = sweep%trajectories(i)
         list%files(n)%s = named(sweep%output, "_case_" // to_text(list%numbers(n)))
         is = file_exists(list%files(n)%s)
         if (is .and. .not. may_exist) then
            call fatal(error, list%files(n)%s // " exists" // what_helps(list%files(n)%s), &
               status_file)
            return
         end if
         if (is .and. force) call remove_file(list%files(n)%s, error)
         if (allocated(error)) return
      end do
   end subroutine list_trajectories

   !> Write the trajectories that are not there, one at a time.
   subroutine write_trajectories(list, cases, stopped, error)
      type(trajectories_type), intent(inout) :: list
      class(cases_type), intent(in) :: cases
      !> Whether a signal came.
      logical, intent(out) :: stopped
      !> Set when the work cannot go on.
      type(error_type), allocatable, intent(out) :: error
      type(trajectories_type) :: wanted
      real(wp) :: results(size(cases%sweep%results))
      character(len=journal_message_length) :: message
      integer(i8) :: number
      integer :: i, n, status, length
      logical :: found, runs(size(list%numbers))

      stopped = .false.
      if (size(list%numbers) == 0) return
      do i = 1, size(list%numbers)
         call cases%journal%read(cases%selection%position_of(list%numbers(i)), found, number, &
            status, results, message, length, error)
         if (allocated(error)) return
         ! A case that never ended has none; one that failed leaves its rows in a .part file.
         runs(i) = found .and. any(status == [case_complete, case_failed])
      end do
      allocate(wanted%numbers(count(runs)), wanted%files(count(runs)))
      wanted%sweep => list%sweep
      n = 0
      do i = 1, size(list%numbers)
         if (.not. runs(i)) cycle
         n = n + 1
         wanted%numbers(n) = list%numbers(i)
         wanted%files(n)%s = list%files(i)%s
      end do
      call run_crew(wanted, int(n, i8), 1, writing_allowance*min(cases%sweep%time_limit, &
         huge(1.0_wp)/writing_allowance), stopped, error)
      if (allocated(error)) error%message = "cannot write the trajectories " // &
         named(cases%sweep%output, "_case_N") // ": " // error%message
   end subroutine write_trajectories

   !> Run a case as `contensou run` does, in a process of its own.
   subroutine work_trajectory(self, thread, piece, code)
      class(trajectories_type), intent(in) :: self
      integer, intent(in) :: thread
      !> Which one.
      integer(i8), intent(in) :: piece
      !> `piece_done`, `piece_stopped` or a value of errno.
      integer, intent(out) :: code
      type(scene_file_type) :: file
      type(string_type), allocatable :: overrides(:), words(:)
      type(error_type), allocatable :: error, remove_error
      type(earlier_type) :: nothing
      type(simulation_type) :: simulation
      type(quiet_recorder_type) :: recorder

      code = piece_done
      associate (sweep => self%sweep, name => self%files(piece)%s)
         call sweep%overrides_of(self%numbers(piece), overrides)
         call read_scene(sweep%scene_path, overrides, name, file, error)
         if (allocated(error)) return
         call run_words(sweep%scene_path, overrides, name, words)
         call new_simulation(file, simulation, error)
         if (allocated(error)) return
         recorder%output%flush_interval = huge(1.0_wp)
         call recorder%begin(file, simulation, command_text(words), .false., nothing, error)
         if (.not. allocated(error)) then
            call simulate(simulation, recorder, error)
            call recorder%finish(simulation, error)
         end if
         if (simulation%stopped) then
            call remove_file(name // part_suffix, remove_error)
            call forget(name, .true., remove_error)
            code = piece_stopped
            return
         end if
         if (.not. allocated(error)) return
         if (error%status == status_file) code = input_output_error
      end associate
   end subroutine work_trajectory

   !> A step is done: do all stop?
   subroutine after_step(self, t, stop_now, error)
      class(quiet_recorder_type), intent(inout) :: self
      real(wp), intent(in) :: t
      logical, intent(out) :: stop_now
      type(error_type), allocatable, intent(out) :: error

      call self%recorder_type%after_step(t, stop_now, error)
      stop_now = crew_stopping()
   end subroutine after_step

   !> Words of the command line that runs a case alone.
   pure subroutine run_words(scene_path, overrides, output, words)
      !> Name of the scene file.
      character(len=*), intent(in) :: scene_path
      !> Values that the case has, NAME=VALUE.
      type(string_type), intent(in) :: overrides(:)
      !> Name of the trajectory; blank for the one that the scene says.
      character(len=*), intent(in) :: output
      type(string_type), allocatable, intent(out) :: words(:)
      integer :: i, n

      n = 2*size(overrides) + 2
      allocate(words(merge(n, n + 2, output == "")))
      words(1)%s = "run"
      words(2)%s = scene_path
      do i = 1, size(overrides)
         words(2*i + 1)%s = "--set"
         words(2*i + 2)%s = overrides(i)%s
      end do
      if (output == "") return
      words(n + 1)%s = "-o"
      words(n + 2)%s = output
   end subroutine run_words

   !> Whether a trajectory is there.
   logical function done_trajectory(self, piece)
      class(trajectories_type), intent(in) :: self
      !> Which one.
      integer(i8), intent(in) :: piece

      done_trajectory = file_exists(self%files(piece)%s)
   end function done_trajectory

   !> A trajectory that cannot be written is not there.
   subroutine lost_trajectory(self, piece, late, reason, code)
      class(trajectories_type), intent(inout) :: self
      !> Which one.
      integer(i8), intent(in) :: piece
      !> Whether it did not end in time.
      logical, intent(in) :: late
      !> How its process died.
      character(len=*), intent(in) :: reason
      !> 0.
      integer, intent(out) :: code

      code = 0
   end subroutine lost_trajectory

   !> Nothing is shown of trajectories.
   subroutine look_trajectories(self, finished)
      class(trajectories_type), intent(inout) :: self
      !> Trajectories that were written by now.
      integer(i8), intent(in) :: finished
   end subroutine look_trajectories

end module contensou_sweep_trajectories
