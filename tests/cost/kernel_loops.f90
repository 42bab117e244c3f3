!> A loop over one of the kernels that the C interface and the Python package give on arrays.
!>
!> kernel_loops KERNEL N ROUNDS passes N elements some times, with the arguments of LOOPS in
!> tests/driver/test_kernel_arrays.py.
program kernel_loops
   use, intrinsic :: iso_fortran_env, only : error_unit
   use contensou, only : complete_elliptic, friction_wrench, hertz_contact, hertz_spot_type, &
      shells_type, slip_type, spot_shape_type, spring_spot_type, wp
   implicit none(type, external)
   !> f [-], N [N], a [m], G [Pa] and nu [-].
   real(wp), parameter :: coefficient = 0.3_wp, load = 2.0_wp, major = 1.0e-3_wp
   real(wp), parameter :: shear = 8.0e10_wp, poisson = 0.3_wp

   call run_loop()

contains

   !> What the command line says.
   subroutine run_loop()
      character(len=16) :: kernel, number
      real(wp), allocatable :: x(:), y(:, :)
      type(shells_type) :: shells
      integer :: n, rounds, i

      call get_command_argument(1, kernel)
      call get_command_argument(2, number)
      read (number, *) n
      call get_command_argument(3, number)
      read (number, *) rounds
      allocate(x(n), y(20, n))
      x = [(real(i, wp)/n, i=1, n)]
      call shells%begin()
      do i = 1, rounds
         select case (kernel)
         case ("hertz")
            call touch(x, y)
         case ("elliptic")
            call integrate(x, y)
         case ("wrench")
            call rub(x, y)
         case ("jacobian")
            call vary(x, y)
         case ("stiffness")
            call stiffen(x, y)
         case ("tangential")
            call shift(shells, x, y)
         case default
            error stop "kernel_loops: there is no such kernel"
         end select
      end do
      write (error_unit, "(es24.16)") sum(y(1, :))
   end subroutine run_loop

   !> Hertz contacts.
   subroutine touch(x, y)
      real(wp), intent(in) :: x(:)
      real(wp), intent(inout) :: y(:, :)
      type(hertz_spot_type) :: spot
      integer :: i

      do i = 1, size(x)
         call hertz_contact(50.0_wp*x(i), 70.0_wp*x(i), 1.1e11_wp, 1.0e-6_wp*x(i), spot)
         y(1, i) = spot%a
         y(2, i) = spot%b
         y(3, i) = spot%force
         y(4, i) = spot%pressure
      end do
   end subroutine touch

   !> Elliptic integrals.
   subroutine integrate(x, y)
      real(wp), intent(in) :: x(:)
      real(wp), intent(inout) :: y(:, :)
      integer :: i

      do i = 1, size(x)
         call complete_elliptic(x(i), y(1, i), y(2, i))
      end do
   end subroutine integrate

   !> Friction wrenches.
   subroutine rub(x, y)
      real(wp), intent(in) :: x(:)
      real(wp), intent(inout) :: y(:, :)
      real(wp) :: wrench(3)
      integer :: i

      do i = 1, size(x)
         call friction_wrench(spot_shape_type(0.7_wp*major/major), &
            slip_type(0.05_wp, 0.01_wp, major*100.0_wp*x(i)), .true., wrench)
         y(:3, i) = coefficient*load*wrench*[1.0_wp, 1.0_wp, major]
      end do
   end subroutine rub

   !> Friction wrenches with their derivatives by N, a, vx, vy and the spin.
   subroutine vary(x, y)
      real(wp), intent(in) :: x(:)
      real(wp), intent(inout) :: y(:, :)
      real(wp) :: wrench(3), jacobian(3, 3), unit(3), slopes(3, 5)
      integer :: i

      do i = 1, size(x)
         call friction_wrench(spot_shape_type(0.7_wp*major/major), &
            slip_type(0.05_wp, 0.01_wp, major*100.0_wp*x(i)), wrench, jacobian)
         unit = coefficient*load*[1.0_wp, 1.0_wp, major]
         slopes(:, 1) = unit*wrench/load
         slopes(:, 2) = unit*jacobian(:, 3)*100.0_wp*x(i)
         slopes(3, 2) = slopes(3, 2) + coefficient*load*wrench(3)
         slopes(:, 3) = unit*jacobian(:, 1)
         slopes(:, 4) = unit*jacobian(:, 2)
         slopes(:, 5) = unit*jacobian(:, 3)*major
         y(:3, i) = unit*wrench
         y(4:18, i) = reshape(transpose(slopes), [15])
      end do
   end subroutine vary

   !> Stiffness of spots on which nothing slips.
   subroutine stiffen(x, y)
      real(wp), intent(in) :: x(:)
      real(wp), intent(inout) :: y(:, :)
      type(spring_spot_type) :: spot
      integer :: i

      do i = 1, size(x)
         spot%shape = spot_shape_type(0.7_wp*x(i)*major/(x(i)*major))
         spot%a = x(i)*major
         call spot%stiffen(shear, poisson)
         y(:3, i) = spot%stiffness
      end do
   end subroutine stiffen

   !> Steps of a spot with local slip and memory.
   subroutine shift(shells, x, y)
      type(shells_type), intent(inout) :: shells
      real(wp), intent(in) :: x(:)
      real(wp), intent(inout) :: y(:, :)
      type(spring_spot_type) :: spot
      integer :: i

      do i = 1, size(x)
         spot%shape = spot_shape_type(0.7_wp*major/major)
         spot%a = major
         spot%limit = coefficient*load
         call spot%stiffen(shear, poisson)
         call shells%advance(spot, [1.0e-9_wp*(x(i) - 0.5_wp), 0.0_wp, 0.0_wp], y(:3, i), y(4, i), &
            y(5, i))
      end do
   end subroutine shift

end program kernel_loops
