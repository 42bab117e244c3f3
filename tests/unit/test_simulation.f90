!> Simulations as a caller of the library sees them: options, mistakes, failures, stopping and going
!> on, saving and restoring.
module test_simulation
   use contensou_base_checkpoint, only : checkpoint_type
   use contensou_base_errors, only : error_type, status_failed, status_usage
   use contensou_base_kinds, only : wp
   use contensou_base_text, only : string_type
   use contensou_dynamics_scene, only : scene_type
   use contensou_integrate_observer, only : observer_type
   use contensou_integrate_motion, only : motion_type
   use contensou_scene_reader, only : read_scene, scene_file_type
   use contensou_study_simulation, only : new_simulation, simulate, simulation_options_type, &
      simulation_type
   use test_harness, only : check, check_close
   use test_scenes, only : ball
   implicit none(type, external)
   private

   public :: run_simulation_tests

   !> Counts rows and steps, and stops after some of these.
   type, extends(observer_type) :: counter_type
      integer :: rows = 0
      !> Time of the last row [s].
      real(wp) :: t = -1.0_wp
      integer :: steps = 0
      !> Steps after which to stop.
      integer :: stop_after = huge(1)
   contains
      procedure :: sample
      procedure :: after_step
   end type counter_type

contains

   !> Run all tests of this module.
   subroutine run_simulation_tests(folder)
      !> Folder for files.
      character(len=*), intent(in) :: folder

      type(string_type) :: none(0), rigid(1)
      integer :: steps

      call test_options()
      call test_mistakes()
      call test_failure()
      call test_scene_and_file("inputs/tippe_top.nml")
      call test_restore("inputs/rattleback.nml", none, "auto", folder, 0.05_wp, 10)
      call test_restore("inputs/tippe_top_rigid.nml", none, "explicit8", folder, 0.05_wp, 10)
      call test_restore("inputs/tippe_top.nml", none, "cvode_bdf", folder, 0.05_wp, 10)
      rigid(1)%s = "body_bore.normal = 'rigid'"
      ! One of two spots is away, or open, or both touch.
      do steps = 2, 302, 50
         call test_restore("tests/hard/ellipsoid_in_bore.nml", none, "explicit8", folder, &
            0.04_wp, steps)
      end do
      do steps = 2, 102, 20
         call test_restore("tests/hard/ellipsoid_in_bore.nml", none, "cvode_bdf", folder, &
            0.04_wp, steps)
         call test_restore("tests/hard/ellipsoid_in_bore.nml", rigid, "explicit8", folder, &
            0.2_wp, steps)
      end do
   end subroutine run_simulation_tests

   !> A row is due.
   subroutine sample(self, motion, t, y, error)
      class(counter_type), intent(inout) :: self
      class(motion_type), intent(inout) :: motion
      !> Time [s].
      real(wp), intent(in) :: t
      !> State.
      real(wp), intent(in) :: y(:)
      !> Never set.
      type(error_type), allocatable, intent(out) :: error

      self%rows = self%rows + 1
      self%t = t
   end subroutine sample

   !> A step is done.
   subroutine after_step(self, t, stop_now, error)
      class(counter_type), intent(inout) :: self
      !> Time reached [s].
      real(wp), intent(in) :: t
      !> Whether to stop here.
      logical, intent(out) :: stop_now
      !> Never set.
      type(error_type), allocatable, intent(out) :: error

      self%steps = self%steps + 1
      stop_now = self%steps >= self%stop_after
   end subroutine after_step

   !> Options stand in place of what the scene says; a scene made in memory needs no names.
   subroutine test_options()
      type(scene_type) :: scene
      type(simulation_type) :: simulation
      type(simulation_options_type) :: options
      type(counter_type) :: counter
      type(observer_type) :: nobody
      type(error_type), allocatable :: error

      call ball(scene, 1.0e-2_wp)
      scene%gravity = [0.0_wp, 0.0_wp, -9.81_wp]
      options%method = "auto"
      options%t_end = 0.2_wp
      options%interval = 0.05_wp
      call new_simulation(scene, simulation, error, options)
      call check(.not. allocated(error), "simulation: is made")
      call check(abs(simulation%time()) <= 0.0_wp .and. .not. simulation%stopped, &
         "simulation: at its beginning")
      call check(simulation%choice%method == "explicit8", "simulation: a method is chosen")
      call check(index(simulation%reason(), "explicit8, because contact 1 ") == 1, &
         "simulation: the reason is " // simulation%reason())
      call simulate(simulation, counter, error)
      call check(.not. allocated(error) .and. counter%rows == 5, "simulation: rows as asked for")
      call check_close(counter%t, 0.2_wp, 1.0e-15_wp, "simulation: the last row is at the end")
      call check(simulation%memory%statistics%steps == counter%steps, "simulation: counts steps")
      call simulate(simulation, counter, error)
      call check(.not. allocated(error) .and. counter%rows == 5, &
         "simulation: at its end there is nothing left to do")
      options%method = "cvode_bdf"
      call new_simulation(scene, simulation, error, options)
      call check(simulation%reason() == "", "simulation: a given method needs no reason")
      call simulate(simulation, nobody, error)
      call check(.not. allocated(error), "simulation: nobody needs to look on")
   end subroutine test_options

   !> Options that make no sense.
   subroutine test_mistakes()
      type(scene_type) :: scene
      type(simulation_options_type) :: options

      call ball(scene, 1.0e-2_wp)
      options%method = "euler"
      call expect("there is no method 'euler'")
      deallocate(options%method)
      options%rtol = 0.0_wp
      call expect("the relative tolerance must be > 0")
      deallocate(options%rtol)
      options%t_end = -1.0_wp
      call expect("the end of time must be > 0")
      deallocate(options%t_end)
      options%max_step = -1.0_wp
      call expect("the largest step must be >= 0")

   contains

      !> The options are refused.
      subroutine expect(message)
         character(len=*), intent(in) :: message
         type(simulation_type) :: simulation
         type(error_type), allocatable :: error

         call new_simulation(scene, simulation, error, options)
         call check(allocated(error), "simulation, refused: " // message)
         if (allocated(error)) call check(error%message == message .and. &
            error%status == status_usage, "simulation: says " // error%message)
      end subroutine expect

   end subroutine test_mistakes

   !> A failure comes back with when, where and why.
   subroutine test_failure()
      type(scene_type) :: scene
      type(simulation_type) :: simulation
      type(observer_type) :: nobody
      type(error_type), allocatable :: error

      call ball(scene, 0.01_wp)
      scene%materials(1)%young = 1.0e6_wp
      scene%bodies(1)%velocity = [0.0_wp, 0.0_wp, -10.0_wp]
      call new_simulation(scene, simulation, error)
      call simulate(simulation, nobody, error)
      call check(allocated(error), "simulation: fails")
      if (.not. allocated(error)) return
      call check(error%status == status_failed, "simulation: failed")
      call check(index(error%message, "the run failed at t = 0.001") == 1, &
         "simulation: says when: " // error%message)
      call check(index(error%message, "contact '1': gap -") > 0, "simulation: says where")
      call check(simulation%failure == "the motion leaves the domain of the model", &
         "simulation: keeps why: " // simulation%failure)
      call check(simulation%time() > 1.0e-3_wp, "simulation: is where it failed")
   end subroutine test_failure

   !> What the reader has assembled and what a simulation assembles are the same.
   subroutine test_scene_and_file(name)
      !> Its file.
      character(len=*), intent(in) :: name
      type(scene_file_type) :: file
      type(simulation_type) :: first, second
      type(simulation_options_type) :: options
      type(observer_type) :: nobody
      type(error_type), allocatable :: error

      call read_scene(name, [string_type ::], "", file, error)
      options%t_end = 0.01_wp
      call new_simulation(file, first, error, options)
      call simulate(first, nobody, error)
      call check(.not. allocated(error), name // ": is simulated as read")
      call new_simulation(file%scene, second, error, options)
      call simulate(second, nobody, error)
      call check(same(first%state(), second%state()), name // ": is assembled as read")
   end subroutine test_scene_and_file

   !> A simulation that was stopped goes on, as does one that is restored from what it saved.
   subroutine test_restore(name, overrides, method, folder, t_end, steps)
      !> Scene.
      character(len=*), intent(in) :: name
      !> Values in place of those of the scene.
      type(string_type), intent(in) :: overrides(:)
      character(len=*), intent(in) :: method
      !> Folder for files.
      character(len=*), intent(in) :: folder
      !> End of time [s].
      real(wp), intent(in) :: t_end
      !> Steps after which it is stopped.
      integer, intent(in) :: steps
      type(scene_file_type) :: file
      type(simulation_type) :: stopped, restored
      type(simulation_options_type) :: options
      type(counter_type) :: counter
      type(observer_type) :: nobody
      type(checkpoint_type) :: saved, read
      type(error_type), allocatable :: error
      character(len=:), allocatable :: path

      path = folder // "/simulation.checkpoint"
      call read_scene(name, overrides, "", file, error)
      options%method = method
      options%t_end = t_end
      call new_simulation(file, stopped, error, options)
      counter%stop_after = steps
      call simulate(stopped, counter, error)
      call check(.not. allocated(error) .and. stopped%stopped .and. stopped%time() < t_end, &
         name // ": is stopped")
      call saved%begin()
      call stopped%exchange(saved)
      call saved%save(path, error)
      call check(.not. allocated(error), name // ": is saved")
      call simulate(stopped, nobody, error)
      call check(.not. allocated(error) .and. .not. stopped%stopped, name // ": goes on")

      call new_simulation(file, restored, error, options)
      call read%load(path, error)
      call restored%exchange(read)
      if (.not. allocated(error)) call read%result(error)
      call check(.not. allocated(error), name // ": is restored")
      call check(restored%time() > 0.0_wp, name // ": is where it was")
      call simulate(restored, nobody, error)
      call check(.not. allocated(error), name // ": goes on when restored")
      call check(same(stopped%state(), restored%state()) .and. same([stopped%time()], &
         [restored%time()]), name // ": restored, the same bits")
      call check(stopped%memory%statistics%steps == restored%memory%statistics%steps, &
         name // ": restored, as many steps")
   end subroutine test_restore

   !> Whether all bits are the same.
   pure function same(a, b) result(answer)
      real(wp), intent(in) :: a(:), b(:)
      logical :: answer

      answer = size(a) == size(b)
      if (answer) answer = all(abs(a - b) <= 0.0_wp)
   end function same

end module test_simulation
