!> A spot that slides and spins: the wrench of each rung, and the Jacobian of the exact one.
program wrench_example
   use contensou
   implicit none(type, external)

   !> Semi-axes of the spot [m].
   real(wp), parameter :: a = 2.0e-3_wp, b = 6.0e-4_wp

   !> Friction coefficient [-] and normal force [N].
   real(wp), parameter :: f = 0.3_wp, load = 100.0_wp

   call show()

contains

   !> Compute and print.
   subroutine show()
      !> Sliding velocity [m/s] and spin [rad/s].
      real(wp), parameter :: vx = 0.02_wp, vy = 0.05_wp, w = 30.0_wp
      real(wp) :: wrench(3), jacobian(3, 3), power
      type(spot_shape_type) :: shape
      type(slip_type) :: slip
      integer :: i

      ! Once for each spot; then any number of velocities.
      shape = spot_shape_type(b/a)
      slip = slip_type(vx, vy, a*w)
      print "(a)", "model                       Fx [N]      Fy [N]    Tz [N m]"
      associate (models => friction_models())
         do i = 1, size(models)
            if (.not. associated(models(i)%kernel)) cycle
            call models(i)%kernel(shape, slip, .true., wrench)
            call print_wrench(models(i)%info%name, wrench)
         end do
      end associate

      ! In units of f N and f N a, by (vx, vy, a w) in m/s.
      call friction_wrench(shape, slip, wrench, jacobian)
      print "(a)", "Jacobian of the exact wrench [s/m]"
      do i = 1, 3
         print "(22x, 3f12.6)", jacobian(i, :)
      end do
      power = f*load*wrench_exact_potential(shape, slip)
      print "(a, f25.6)", "power [W]", power

      ! Close to rest, regularised by 1 mm/s.
      slip = slip_type(1.0e-4_wp, 1.0e-4_wp, 1.0e-4_wp, delta=1.0e-3_wp)
      call friction_wrench(shape, slip, .true., wrench)
      call print_wrench("near rest", wrench)
   end subroutine show

   !> Print a wrench in SI units.
   subroutine print_wrench(name, wrench)
      !> What it is of.
      character(len=*), intent(in) :: name
      !> In units of f N and f N a.
      real(wp), intent(in) :: wrench(3)
      character(len=22) :: label

      label = name
      print "(a, 3f12.6)", label, f*load*wrench(1:2), f*load*a*wrench(3)
   end subroutine print_wrench

end program wrench_example
