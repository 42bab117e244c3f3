!> Edges of the nested shells of `contensou_contact_tangential_shells`: what is within a place x, in
!> units of the major semi-axis. The load is l(x) = (3/2)(x - x^3/3), the size of the spot that
!> slips in its place c(x) = l^(2/3), and S(x) the torsional stiffness that makes a pure twist that
!> of Lubkin (1951) on the circle.
!>
!> This file, too, is compiled for each of the registers, see
!> `contensou_contact_tangential_abreast`.
module contensou_contact_tangential_edges
   use contensou_base_kinds, only : wp
   implicit none(type, external)
   private

   public :: edge_type, edge_at, look_within, power_beside, power_of

   !> S(x) = l c [1 + (1 - x) P(x)], from the lowest power of P on.
   real(wp), parameter :: torsion(0:7) = [ &
      -0.8698984413305733_wp, 0.02820047614773492_wp, -2.437429052585694_wp, &
      5.616270271347494_wp, -9.940868532230192_wp, 9.619038470681636_wp, &
      -5.046682352654168_wp, 0.9303813590491786_wp]

   !> c(x) = x^(2/3) P(x^2), P(y) = (3/2 - y/2)^(2/3) to 1e-16 for y from 0 to 1.
   real(wp), parameter :: sizes(0:14) = [ &
      1.3103706971044483_wp, -0.291193488245429872_wp, -0.0161774160138624918_wp, &
      -0.00239665421764174449_wp, -0.000466016199278200998_wp, -0.000103558221386462438_wp, &
      -0.0000249363004048452922_wp, -6.30985681479434043e-6_wp, -1.73263913988514553e-6_wp, &
      -3.29286035701673922e-7_wp, -3.04505043957203034e-7_wp, 1.43286129320521087e-7_wp, &
      -1.30959040750658526e-7_wp, 4.73531406160767908e-8_wp, -1.12996395187295042e-8_wp]

   !> Distance of two places, over one of them, up to which the power of one follows from that of
   !> the other: the error of a series is its cube.
   real(wp), parameter :: beside = 1.0e-3_wp

   !> Edge of a shell.
   type :: edge_type
      !> Load within it.
      real(wp) :: load
      !> Size c of the spot that slips in its place.
      real(wp) :: size
      !> Torsional stiffness within it.
      real(wp) :: torsion
   end type edge_type

contains

   !> Load, size and torsional stiffness within a place.
   elemental function edge_at(x, power) result(edge)
      !> The place in units of the semi-axis, and its power 2/3.
      real(wp), intent(in) :: x, power
      type(edge_type) :: edge

      call look_within(x, power, edge%load, edge%size, edge%torsion)
   end function edge_at

   !> What is within a place.
   elemental subroutine look_within(x, power, load, size, stiffness)
      !> The place in units of the semi-axis, and its power 2/3.
      real(wp), intent(in) :: x, power
      real(wp), intent(out) :: load, size, stiffness
      real(wp) :: y, y2, even, odd

      y = x*x
      y2 = y*y
      load = x*(1.5_wp - 0.5_wp*y)
      ! Two short chains in the place of a long one.
      even = sizes(0) + y2*(sizes(2) + y2*(sizes(4) + y2*(sizes(6) + y2*(sizes(8) &
         + y2*(sizes(10) + y2*(sizes(12) + y2*sizes(14)))))))
      odd = sizes(1) + y2*(sizes(3) + y2*(sizes(5) + y2*(sizes(7) + y2*(sizes(9) &
         + y2*(sizes(11) + y2*sizes(13))))))
      size = power*(even + y*odd)
      even = torsion(0) + y*(torsion(2) + y*(torsion(4) + y*torsion(6)))
      odd = torsion(1) + y*(torsion(3) + y*(torsion(5) + y*torsion(7)))
      stiffness = load*size*(1.0_wp + (1.0_wp - x)*(even + x*odd))
   end subroutine look_within

   !> x^(2/3).
   elemental function power_of(x) result(power)
      !> >= 0.
      real(wp), intent(in) :: x
      real(wp) :: power

      power = (x*x)**(1.0_wp/3.0_wp)
   end function power_of

   !> x^(2/3) where that of another place is known.
   elemental function power_beside(x, other, power_of_other) result(power)
      !> Both > 0.
      real(wp), intent(in) :: x, other
      real(wp), intent(in) :: power_of_other
      real(wp) :: power, way, cube

      way = (x - other)/other
      if (abs(way) < beside) then
         ! A step of Halley's, whose error is the cube of that before it.
         power = power_of_other*(1.0_wp + way*(2.0_wp/3.0_wp - way/9.0_wp))
         cube = power**3
         power = power*((cube + 2.0_wp*x*x)/(2.0_wp*cube + x*x))
      else
         power = power_of(x)
      end if
   end function power_beside

end module contensou_contact_tangential_edges
