!> Observer that writes what a simulation shows to an output file, with checkpoints from which
!> another run can go on.
!>
!>    call recorder%begin(file, simulation, command_line, replace, earlier, error)
!>    if (.not. allocated(error)) call simulate(simulation, recorder, error)
!>    call recorder%finish(simulation, error)
module contensou_files_recorder
   use contensou_base_build, only : git_commit, program_version
   use contensou_base_checkpoint, only : checkpoint_type
   use contensou_base_errors, only : error_type, status_file
   use contensou_base_kinds, only : wp
   use contensou_base_numbers, only : number_text
   use contensou_files_earlier, only : checkpoint_suffix, discard_unreadable, earlier_type, &
      exchange_program, forget, put_aside, settings_item
   use contensou_files_trajectory, only : part_suffix, trajectory_type
   use contensou_integrate_memory, only : memory_type
   use contensou_integrate_observer, only : event_touch, observer_type
   use contensou_integrate_motion, only : motion_type
   use contensou_scene_reader, only : scene_file_type
   use contensou_study_simulation, only : simulation_type
   implicit none(type, external)
   private

   public :: recorder_type

   !> Observer that writes the output file.
   type, extends(observer_type) :: recorder_type
      type(trajectory_type) :: output
      !> Steps since the clock was looked at.
      integer :: steps = 0
      !> Time of the first touch [s].
      real(wp) :: first_touch = 0.0_wp
      !> Contact of the first touch; 0 for none.
      integer :: first_contact = 0
      !> What the method had to say.
      character(len=:), allocatable :: advice
      !> Number of changes of the method.
      integer :: changes = 0
      !> The first change in words.
      character(len=:), allocatable :: first_change
      !> From where the run can go on.
      type(checkpoint_type), private :: checkpoint
   contains
      procedure :: begin
      procedure :: finish
      procedure :: keep
      procedure :: sample
      procedure :: event
      procedure :: after_step
      procedure :: advise
      procedure :: warn
      procedure :: change_method
      procedure, private :: exchange
   end type recorder_type

   !> Steps between two looks at the clock.
   integer, parameter :: steps_between = 64

contains

   !> Create the output file that the scene names; go on with what an earlier run left.
   subroutine begin(self, file, simulation, command_line, replace, earlier, error)
      class(recorder_type), intent(inout) :: self
      !> The scene with its texts.
      type(scene_file_type), intent(in) :: file
      !> At its beginning; brought to where an earlier run was.
      type(simulation_type), intent(inout) :: simulation
      !> Command line, for the file.
      character(len=*), intent(in) :: command_line
      !> Whether an existing file is replaced.
      logical, intent(in) :: replace
      !> What an earlier run left.
      type(earlier_type), intent(inout) :: earlier
      !> Set when a file cannot be read or written; then there is nothing to finish.
      type(error_type), allocatable, intent(out) :: error

      if (earlier%resumable) call put_aside(file%scene%output%file, earlier, error)
      if (allocated(error)) return
      call self%output%open(file, simulation%motion%system, replace, command_line, error)
      if (allocated(error) .and. .not. self%output%is_open()) return
      if (.not. allocated(error)) then
         if (earlier%resumable) then
            call go_on(self, simulation, earlier, error)
         else
            call self%output%use_method(0.0_wp, trim(simulation%choice%method), &
               simulation%reason())
         end if
      end if
      if (.not. allocated(error)) call forget(self%output%name, .not. earlier%resumable, error)
      if (allocated(error)) call give_up(self, error)
   end subroutine begin

   !> Take over the rows of an earlier run, and bring the simulation to where it was.
   subroutine go_on(self, simulation, earlier, error)
      type(recorder_type), intent(inout) :: self
      type(simulation_type), intent(inout) :: simulation
      type(earlier_type), intent(inout) :: earlier
      !> Set when a file cannot be read or written.
      type(error_type), allocatable, intent(out) :: error

      call self%output%restore(earlier%source, earlier%checkpoint, error)
      call simulation%exchange(earlier%checkpoint)
      call self%exchange(earlier%checkpoint)
      if (.not. allocated(error)) call earlier%checkpoint%result(error)
      if (.not. allocated(error)) return
      error%status = status_file
      error%message = error%message // new_line("a") // "the rows written before are in " // &
         earlier%source
   end subroutine go_on

   !> Complete the output file and give it its name; if the simulation was stopped or failed leave
   !> its part, which says so.
   subroutine finish(self, simulation, error)
      class(recorder_type), intent(inout) :: self
      !> Where it ended.
      type(simulation_type), intent(in) :: simulation
      !> Why it failed, if it did; its message is completed. Set when a file cannot be written.
      type(error_type), allocatable, intent(inout) :: error
      type(error_type), allocatable :: write_error
      character(len=11) :: status

      associate (profile => simulation%motion%profile)
         if (profile%active) self%output%cpu_by_effect = profile%result(simulation%cpu, &
            self%output%cpu_output)
      end associate
      if (allocated(error)) then
         if (error%status == status_file) then
            call give_up(self, error)
            return
         end if
      end if
      status = merge("interrupted", "complete   ", simulation%stopped)
      if (allocated(error)) status = "failed"
      if (allocated(simulation%plan%stops)) then
         associate (by => simulation%memory%stops%ended_by)
            self%output%summary%stop = by
            if (by > 0) self%output%stopped_by = simulation%plan%stops(by)%name
         end associate
      end if
      call self%output%finish(simulation%motion%system, simulation%memory%y, &
         simulation%memory%statistics, trim(status), write_error)
      if (allocated(error)) then
         if (.not. allocated(write_error)) call forget(self%output%name, .true., write_error)
         if (allocated(write_error)) then
            error%message = error%message // new_line("a") // write_error%message
         else
            error%message = error%message // new_line("a") // "the rows so far are in " // &
               self%output%name // part_suffix
         end if
      else if (allocated(write_error)) then
         call move_alloc(write_error, error)
         call give_up(self, error)
      else if (.not. simulation%stopped) then
         call forget(self%output%name, .true., error)
      end if
   end subroutine finish

   !> Give up after a failure to write.
   subroutine give_up(self, error)
      class(recorder_type), intent(inout) :: self
      !> The failure; its message is completed.
      type(error_type), allocatable, intent(inout) :: error

      call self%output%abandon()
      call discard_unreadable(self%output%name, error)
   end subroutine give_up

   !> Bring the rows to the disk, and then from where the run can go on.
   subroutine keep(self, motion, memory, error)
      class(recorder_type), intent(inout) :: self
      class(motion_type), intent(inout) :: motion
      type(memory_type), intent(inout) :: memory
      !> Set when a file cannot be written.
      type(error_type), allocatable, intent(out) :: error
      character(len=64) :: version, commit

      self%keep_due = .false.
      call self%output%flush(error)
      if (allocated(error)) return
      version = program_version
      commit = git_commit()
      call self%checkpoint%begin()
      call exchange_program(self%checkpoint, version, commit)
      call self%checkpoint%exchange(settings_item, self%output%settings_sum)
      call self%output%exchange(self%checkpoint)
      call memory%exchange(motion, self%checkpoint)
      call self%exchange(self%checkpoint)
      call self%checkpoint%save(self%output%name // checkpoint_suffix, error)
   end subroutine keep

   !> Write to a checkpoint what the summary of a run tells besides, or read it back.
   subroutine exchange(self, checkpoint)
      class(recorder_type), intent(inout) :: self
      type(checkpoint_type), intent(inout) :: checkpoint

      call checkpoint%exchange("first_contact", self%first_contact)
      call checkpoint%exchange("first_touch", self%first_touch)
      call checkpoint%exchange("changes", self%changes)
      call checkpoint%exchange_allocatable("advice", self%advice)
      call checkpoint%exchange_allocatable("first_change", self%first_change)
   end subroutine exchange

   !> A row is due.
   subroutine sample(self, motion, t, y, error)
      class(recorder_type), intent(inout) :: self
      class(motion_type), intent(inout) :: motion
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)
      type(error_type), allocatable, intent(out) :: error

      call self%output%row(motion%system, t, y, error)
   end subroutine sample

   !> A contact touched or lifted off.
   subroutine event(self, t, kind, contact, error)
      class(recorder_type), intent(inout) :: self
      real(wp), intent(in) :: t
      integer, intent(in) :: kind
      integer, intent(in) :: contact
      type(error_type), allocatable, intent(out) :: error

      if (kind == event_touch .and. self%first_contact == 0) then
         self%first_touch = t
         self%first_contact = contact
      end if
      call self%output%event(t, kind, contact, error)
   end subroutine event

   !> A step is done: is a checkpoint due?
   subroutine after_step(self, t, stop_now, error)
      class(recorder_type), intent(inout) :: self
      real(wp), intent(in) :: t
      logical, intent(out) :: stop_now
      type(error_type), allocatable, intent(out) :: error

      stop_now = .false.
      self%steps = self%steps + 1
      if (self%steps < steps_between) return
      self%steps = 0
      self%keep_due = self%output%flush_is_due()
   end subroutine after_step

   !> The method has something to say.
   subroutine advise(self, t, text)
      class(recorder_type), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> What it says.
      character(len=*), intent(in) :: text

      self%advice = "since t = " // number_text(t, 4) // " s " // text
   end subroutine advise

   !> What the user should know of the run.
   subroutine warn(self, text)
      class(recorder_type), intent(inout) :: self
      !> What it is.
      character(len=*), intent(in) :: text

      self%output%warning = text
   end subroutine warn

   !> `auto` goes on with another method.
   subroutine change_method(self, t, method, reason)
      class(recorder_type), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> The method from here on.
      character(len=*), intent(in) :: method
      !> Why.
      character(len=*), intent(in) :: reason

      call self%output%use_method(t, method)
      self%changes = self%changes + 1
      if (self%changes == 1) self%first_change = method // " since t = " // number_text(t, 4) // &
         " s, because " // reason
   end subroutine change_method

end module contensou_files_recorder
