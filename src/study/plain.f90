!> Scenes, simulations and observers for programs that call the library: settings as plain texts,
!> a procedure in place of an observer.
!>
!>    call new_simulation("tippe_top.nml", simulation, error, ["scene.t_end = 0.5"])
!>    call simulate(simulation, look, error)
!>
!> calls look(t, y) for each row.
module contensou_study_plain
   use contensou_base_errors, only : error_type
   use contensou_base_kinds, only : wp
   use contensou_base_text, only : string_type
   use contensou_integrate_observer, only : observer_type
   use contensou_integrate_motion, only : motion_type
   use contensou_scene_reader, only : read_scene_with => read_scene, scene_file_type
   use contensou_study_simulation, only : new_simulation, simulate_observed => simulate, &
      simulation_type
   implicit none(type, external)
   private

   public :: new_simulation, read_scene, simulate

   !> Make a simulation of a scene at its beginning: of a file, of what was read, or of a scene.
   interface new_simulation
      module procedure new_simulation_of_path
   end interface new_simulation

   !> Simulate to the end, with an observer or a procedure that looks at each row.
   interface simulate
      procedure :: simulate_observed
      module procedure simulate_watched
   end interface simulate

   abstract interface
      !> Look at a row.
      subroutine look_at(t, y)
         import :: wp
         implicit none(type, external)
         !> Time [s].
         real(wp), intent(in) :: t
         !> State: position, quaternion, velocity, angular velocity of each body, then works.
         real(wp), intent(in) :: y(:)
      end subroutine look_at
   end interface

   !> An observer that hands each row to a procedure.
   type, extends(observer_type) :: watcher_type
      procedure(look_at), pointer, nopass :: look => null()
   contains
      procedure :: sample
   end type watcher_type

contains

   !> Read a scene file and check everything.
   subroutine read_scene(path, file, error, settings)
      !> Name of the scene file.
      character(len=*), intent(in) :: path
      type(scene_file_type), intent(out) :: file
      !> Set with all mistakes found; nothing of `file` is to be used then.
      type(error_type), allocatable, intent(out) :: error
      !> What differs from the file, as after `--set`: "scene.t_end = 0.5".
      character(len=*), intent(in), optional :: settings(:)
      type(string_type), allocatable :: overrides(:)
      integer :: i, n

      n = 0
      if (present(settings)) n = size(settings)
      allocate(overrides(n))
      do i = 1, n
         overrides(i)%s = trim(settings(i))
      end do
      call read_scene_with(path, overrides, "", file, error)
   end subroutine read_scene

   !> Read a scene file and make a simulation of it.
   subroutine new_simulation_of_path(path, simulation, error, settings)
      !> Name of the scene file.
      character(len=*), intent(in) :: path
      !> The simulation, at the beginning of its time.
      type(simulation_type), intent(out) :: simulation
      !> Set with all mistakes of the scene.
      type(error_type), allocatable, intent(out) :: error
      !> What differs from the file, as after `--set`.
      character(len=*), intent(in), optional :: settings(:)
      type(scene_file_type) :: file

      call read_scene(path, file, error, settings)
      if (.not. allocated(error)) call new_simulation(file, simulation, error)
   end subroutine new_simulation_of_path

   !> Simulate to the end; a procedure looks at each row.
   subroutine simulate_watched(simulation, look, error)
      type(simulation_type), intent(inout), target :: simulation
      procedure(look_at) :: look
      !> Set when the integration failed.
      type(error_type), allocatable, intent(out) :: error
      type(watcher_type) :: watcher

      watcher%look => look
      call simulate_observed(simulation, watcher, error)
   end subroutine simulate_watched

   !> A row is due.
   subroutine sample(self, motion, t, y, error)
      class(watcher_type), intent(inout) :: self
      class(motion_type), intent(inout) :: motion
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)
      type(error_type), allocatable, intent(out) :: error

      call self%look(t, y)
   end subroutine sample

end module contensou_study_plain
