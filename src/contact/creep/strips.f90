!> The simplified theory of rolling (J. Kalker, Vehicle System Dynamics 11 (1982) 1): bristles on
!> strips along the flow of the material, at any angle to the axes of the spot.
!>
!> With xi along c and eta across it the traction on body 1 is -t, and where nothing slips
!>    V dt/dxi = g,   g = M u + w (-eta/L3 + xi/L13, xi/L3)
!> from t = 0 at the inlet on. M = (3 G/(8 l0)) (C11 C12; C12 C22), 1/L3 = 4 G C23 sqrt(ab)/(pi
!> l0^2) and 1/L13, with C13, make the forces of small creep those of Kalker; l0 is the half-length
!> of the strip through the centre. Units: a, f N and e0 are one, so that G = f p0.
module contensou_contact_creep_strips
   use contensou_base_kinds, only : pi, wp
   use contensou_contact_creep_law, only : creep_motion_type, creep_spot_type, linear_theory
   implicit none(type, external)
   private

   public :: flow_type, strip_type, new_flow, strip_at, to_axes, cut

   !> How material flows through a spot, and the flexibilities of its bristles.
   type :: flow_type
      !> Velocity V of the material, > 0, and its direction.
      real(wp) :: rolls, ex, ey
      !> Half-length of the strip through the centre, and half the width across the flow.
      real(wp) :: l0, h
      !> Place xi of the middles of the strips per eta.
      real(wp) :: slope
      !> f p0, and the root of the ratio of the axes.
      real(wp) :: p0, root_k
      !> Sliding velocity along and across the flow.
      real(wp) :: u(2)
      !> M, and 1/L13 and 1/L3.
      real(wp) :: m(2, 2), third(2)
      !> C11, C12, C22, C13, C23, C33 of the linear theory.
      real(wp) :: c(6)
   end type flow_type

   !> What stretches the bristles of a strip, g = g0 + g1 y at the way y from the inlet.
   type :: strip_type
      !> Half-length.
      real(wp) :: l
      !> Place of its centre along and across the flow.
      real(wp) :: xi, eta
      real(wp) :: g0(2), g1(2)
   end type strip_type

contains

   !> The flow through a spot where something rolls.
   pure function new_flow(spot, motion) result(flow)
      type(creep_spot_type), intent(in) :: spot
      type(creep_motion_type), intent(in) :: motion
      type(flow_type) :: flow

      flow%rolls = sqrt(motion%rx**2 + motion%ry**2)
      flow%ex = motion%rx/flow%rolls
      flow%ey = motion%ry/flow%rolls
      call linear_theory(spot, flow%ex, flow%ey, flow%c)
      associate (k => spot%shape%k, ik2 => spot%shape%inverse_k2, ex => flow%ex, ey => flow%ey, &
         c => flow%c)
         flow%p0 = 1.5_wp/(pi*k)
         flow%root_k = sqrt(k)
         flow%l0 = 1.0_wp/sqrt(ex*ex + ey*ey*ik2)
         flow%h = k/flow%l0
         flow%slope = -ex*ey*(ik2 - 1.0_wp)*flow%l0*flow%l0
         flow%u = [motion%x*ex + motion%y*ey, motion%y*ex - motion%x*ey]
         flow%m = (3.0_wp*flow%p0/(8.0_wp*flow%l0))*reshape([c(1), c(2), c(2), c(3)], [2, 2])
         flow%third = (4.0_wp*flow%p0*flow%root_k/(pi*flow%l0*flow%l0))*c(4:5)
      end associate
   end function new_flow

   !> The strip along the flow at a place across it.
   pure function strip_at(flow, spin, place, share) result(strip)
      type(flow_type), intent(in) :: flow
      real(wp), intent(in) :: spin
      !> Place across, in half-widths, and the length of the strip there in that of the middle one.
      real(wp), intent(in) :: place, share
      type(strip_type) :: strip

      strip%eta = flow%h*place
      strip%xi = flow%slope*strip%eta
      strip%l = flow%l0*share
      strip%g1 = spin*flow%third
      strip%g0 = matmul(flow%m, flow%u) + (strip%xi - strip%l)*strip%g1
      strip%g0(1) = strip%g0(1) - spin*strip%eta*flow%third(2)
   end function strip_at

   !> What a traction is multiplied by that comes to the bound: one up to a corner, the bound over
   !> the traction beyond the bound; between what comes of it is a cubic, with the same slopes.
   elemental real(wp) function cut(traction, corner)
      !> Over the bound, > 0.
      real(wp), intent(in) :: traction
      !> Size of the corner as a part of the bound.
      real(wp), intent(in) :: corner
      real(wp) :: near

      near = min(max((traction - 1.0_wp)/corner + 1.0_wp, 0.0_wp), 1.0_wp)
      cut = (min(traction, 1.0_wp - corner) + corner*near*(1.0_wp + near*(1.0_wp - near)))/traction
   end function cut

   !> A wrench along the axes of the spot from that along and across the flow.
   pure function to_axes(flow, wrench) result(turned)
      type(flow_type), intent(in) :: flow
      real(wp), intent(in) :: wrench(3)
      real(wp) :: turned(3)

      turned = [wrench(1)*flow%ex - wrench(2)*flow%ey, wrench(2)*flow%ex + wrench(1)*flow%ey, &
         wrench(3)]
   end function to_axes

end module contensou_contact_creep_strips
