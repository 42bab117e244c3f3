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
      integer :: i

      ! Once for each spot; then any number of velocities.
      shape = elliptic_shape(b/a)
      print "(a)", "model           Fx [N]      Fy [N]    Tz [N m]"
      call print_wrench("exact", wrench_exact, shape, [vx, vy, a*w], 0.0_wp)
      call print_wrench("simplified", wrench_simplified, shape, [vx, vy, a*w], 0.0_wp)
      call print_wrench("pade11", wrench_pade11, shape, [vx, vy, a*w], 0.0_wp)
      call print_wrench("pade22", wrench_pade22, shape, [vx, vy, a*w], 0.0_wp)

      ! In units of f N and f N a, by (vx, vy, a w) in m/s.
      call wrench_exact_jacobian(shape, slip_type(vx, vy, a*w), wrench, jacobian)
      print "(a)", "Jacobian of the exact wrench [s/m]"
      do i = 1, 3
         print "(10x, 3f12.6)", jacobian(i, :)
      end do
      power = f*load*wrench_exact_potential(shape, slip_type(vx, vy, a*w))
      print "(a, f13.6)", "power [W]", power

      ! Close to rest, regularised by 1 mm/s.
      call print_wrench("near rest", wrench_exact, shape, [1.0e-4_wp, 1.0e-4_wp, 1.0e-4_wp], &
         1.0e-3_wp)
   end subroutine show

   !> Compute a wrench and print it in SI units.
   subroutine print_wrench(name, kernel, shape, v, delta)
      !> What it is of.
      character(len=*), intent(in) :: name
      !> The rung.
      procedure(wrench_kernel) :: kernel
      type(spot_shape_type), intent(in) :: shape
      !> Velocity (vx, vy, a w) [m/s].
      real(wp), intent(in) :: v(3)
      !> Regularisation velocity [m/s].
      real(wp), intent(in) :: delta
      character(len=10) :: label
      real(wp) :: r(3)

      call kernel(shape, slip_type(v(1), v(2), v(3), delta), .true., r)
      label = name
      print "(a, 3f12.6)", label, f*load*r(1), f*load*r(2), f*load*a*r(3)
   end subroutine print_wrench

end program wrench_example
