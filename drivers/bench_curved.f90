!> The friction of a curved spot for `contensou bench kernels`: a ball in a groove that rolls, at
!> the bounds of the error that there are.
module contensou_drivers_bench_curved
   use contensou_base_kinds, only : wp
   use contensou_contact_spot, only : spot_shape_type
   use contensou_contact_wrench_curved, only : bend_type, coarsest, mapped_only, &
      slender_only, wrench_curved
   use contensou_contact_wrench_scaling, only : slip_type
   implicit none(type, external)
   private

   public :: curved_10, curved_6, curved_4, curved_mapped, curved_slender, curved_product, &
      curved_reference, slip_by_rolling

   !> Slip by rolling between the centre and the ends of the spot [m/s], the unit of the others.
   real(wp), parameter :: slip_by_rolling = 1.0_wp

   !> The ball rolls about the major axis; the curvature along the minor axis is 0.45 of that across
   !> the groove.
   type(bend_type), parameter :: bend = bend_type(rise=[1.0e-3_wp, 0.0_wp, 0.45e-3_wp], &
      turning=[0.0_wp, slip_by_rolling/1.0e-3_wp])

contains

   !> Within 1e-10 f N.
   pure subroutine curved_10(shape, slip, with_torque, wrench)
      type(spot_shape_type), intent(in) :: shape
      type(slip_type), intent(in) :: slip
      logical, intent(in) :: with_torque
      real(wp), intent(out) :: wrench(3)

      call bounded(shape, slip, with_torque, 1.0e-10_wp, wrench)
   end subroutine curved_10

   !> Within 1e-6 f N.
   pure subroutine curved_6(shape, slip, with_torque, wrench)
      type(spot_shape_type), intent(in) :: shape
      type(slip_type), intent(in) :: slip
      logical, intent(in) :: with_torque
      real(wp), intent(out) :: wrench(3)

      call bounded(shape, slip, with_torque, 1.0e-6_wp, wrench)
   end subroutine curved_6

   !> Within 1e-4 f N.
   pure subroutine curved_4(shape, slip, with_torque, wrench)
      type(spot_shape_type), intent(in) :: shape
      type(slip_type), intent(in) :: slip
      logical, intent(in) :: with_torque
      real(wp), intent(out) :: wrench(3)

      call bounded(shape, slip, with_torque, 1.0e-4_wp, wrench)
   end subroutine curved_4

   !> Chords that follow the slip, without a bound.
   pure subroutine curved_mapped(shape, slip, with_torque, wrench)
      type(spot_shape_type), intent(in) :: shape
      type(slip_type), intent(in) :: slip
      logical, intent(in) :: with_torque
      real(wp), intent(out) :: wrench(3)

      call bounded(shape, slip, with_torque, mapped_only, wrench)
   end subroutine curved_mapped

   !> Flat chords that follow the slip, without a bound.
   pure subroutine curved_slender(shape, slip, with_torque, wrench)
      type(spot_shape_type), intent(in) :: shape
      type(slip_type), intent(in) :: slip
      logical, intent(in) :: with_torque
      real(wp), intent(out) :: wrench(3)

      call bounded(shape, slip, with_torque, slender_only, wrench)
   end subroutine curved_slender

   !> The product rule, without a bound.
   pure subroutine curved_product(shape, slip, with_torque, wrench)
      type(spot_shape_type), intent(in) :: shape
      type(slip_type), intent(in) :: slip
      logical, intent(in) :: with_torque
      real(wp), intent(out) :: wrench(3)

      call bounded(shape, slip, with_torque, coarsest, wrench)
   end subroutine curved_product

   !> What they are compared with.
   pure subroutine curved_reference(shape, slip, wrench)
      type(spot_shape_type), intent(in) :: shape
      type(slip_type), intent(in) :: slip
      real(wp), intent(out) :: wrench(3)

      call bounded(shape, slip, .true., 1.0e-13_wp, wrench)
   end subroutine curved_reference

   !> Within a bound.
   pure subroutine bounded(shape, slip, with_torque, bound, wrench)
      type(spot_shape_type), intent(in) :: shape
      type(slip_type), intent(in) :: slip
      logical, intent(in) :: with_torque
      !> Bound of the error over f N.
      real(wp), intent(in) :: bound
      real(wp), intent(out) :: wrench(3)
      real(wp) :: moment(2)

      call wrench_curved(shape, slip, bend, bound, wrench, moment)
      if (.not. with_torque) wrench(3) = 0.0_wp
   end subroutine bounded

end module contensou_drivers_bench_curved
