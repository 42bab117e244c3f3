!> Tangential elasticity for `contensou bench kernels`: spots that are shifted and twisted to and
!> fro, step by step, at constant load.
!>
!> Lengths are in units of the major semi-axis, forces in f N, and the spot is as stiff as makes the
!> shift at which it slides all over one: k_x = 3/2.
module contensou_drivers_bench_tangential
   use contensou_base_kinds, only : wp
   use contensou_contact_spot, only : spot_shape_type
   use contensou_contact_tangential_shells, only : default_layers, most_layers, shells_type, &
      single_spring, spring_spot_type
   implicit none(type, external)
   private

   public :: follow_history, layers_of_rungs, one_spring, most_layers, rung_name

   !> Stands for the single spring among numbers of layers.
   integer, parameter :: one_spring = 0

   !> Layers of shells, `one_spring` for the model `spring`.
   integer, parameter :: layers_of_rungs(*) = [one_spring, 1, 6, default_layers, 24]

   !> Poisson's ratio of both bodies.
   real(wp), parameter :: poisson = 0.3_wp

contains

   pure function rung_name(layers) result(name)
      !> Number of layers.
      integer, intent(in) :: layers
      character(len=9) :: name

      name = "spring"
      if (layers /= one_spring) write(name, "(a, i0)") "layers_", layers
   end function rung_name

   !> Wrenches of a spot after each step of a history, in f N and f N a.
   pure subroutine follow_history(layers, shape, places, wrenches)
      !> Number of layers.
      integer, intent(in) :: layers
      type(spot_shape_type), intent(in) :: shape
      !> Shifts along the axes and twist, one place after the other.
      real(wp), intent(in) :: places(:, :)
      !> Of each place.
      real(wp), intent(out) :: wrenches(:, :)
      type(shells_type) :: shells
      type(spring_spot_type) :: spot
      real(wp) :: stored, lost, last(3)
      integer :: i

      spot%shape = shape
      spot%a = 1.0_wp
      spot%limit = 1.0_wp
      call spot%stiffen(1.0_wp, poisson)
      call spot%stiffen(1.5_wp/spot%stiffness(1), poisson)
      if (layers == one_spring) then
         shells = single_spring()
      else
         call shells%begin(layers)
      end if
      last = 0.0_wp
      do i = 1, size(places, 2)
         call shells%advance(spot, places(1:3, i) - last, wrenches(1:3, i), stored, lost)
         last = places(1:3, i)
      end do
   end subroutine follow_history

end module contensou_drivers_bench_tangential
