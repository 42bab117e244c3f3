!> FASTSIM as published (J. Kalker, Vehicle System Dynamics 11 (1982) 1): strips along the rolling
!> direction, three flexibilities, and the parabolic bound (2 f N/(pi a b)) (1 - x^2/a^2 - y^2/b^2).
!>
!> n = 20 strips, n elements on each. The traction in the middle of an element counts for all of it.
!> Steps lead from middle to middle, the first one, of half the length, from the inlet: bristles
!> stretch by the sliding at the end of a step all along it, and where the traction is beyond the
!> bound there it is cut. The bound is scaled so that its sum over all elements is f N. Small
!> creepage has the linear force. Of that of spin, with which the sliding varies along a step, steps
!> of first order leave (n - 1)(n - 2)/n^2 = 0.855. So that derivatives have no kinks where elements
!> begin to slip, tractions come to the bound in a corner that is rounded over 0.05 of it, which the
!> published algorithm has not: that is 2e-4 f N in the mean.
!>
!> The published algorithm does not know that full sliding has the pressure of Hertz: where creep is
!> without end it is not the exact wrench. So the wrench is
!>    W = (1 - m) W_fastsim + m W_exact,   m = q^2/(q^2 + 1000^2),
!> q being the creepage in e0: far beyond where creep saturates.
module contensou_contact_creep_fastsim
   use contensou_base_kinds, only : wp
   use contensou_contact_catalogue, only : model_info_type
   use contensou_contact_creep_bounds, only : confine
   use contensou_contact_creep_law, only : creep_model_type, creep_motion_type, creep_spot_type, &
      creep_type
   use contensou_contact_creep_strips, only : cut, flow_type, new_flow, strip_at, strip_type, &
      to_axes
   use contensou_contact_parameters, only : parameters_type
   use contensou_contact_wrench, only : slip_type, wrench_exact
   implicit none(type, external)
   private

   public :: fastsim

   type, extends(creep_type) :: fastsim_type
   contains
      procedure :: kernel
   end type fastsim_type

   !> Strips, and elements on each.
   integer, parameter :: n = 20

   integer :: index

   !> Places of the strips across, in half-widths, and their lengths in that of the middle one.
   real(wp), parameter :: places(n) = [(real(2*index - 1, wp)/real(n, wp) - 1.0_wp, index=1, n)]
   real(wp), parameter :: shares(n) = [(sqrt((1.0_wp - places(index))*(1.0_wp + places(index))), &
      index=1, n)]

   !> y (2 l - y)/l^2 in the middles of the elements of a strip.
   real(wp), parameter :: profile(n) = [(real((2*index - 1)*(2*(n - index) + 1), wp)/ &
      real(n**2, wp), index=1, n)]

   !> Bound in the middle of the spot over f N/(a b), times the sides of its elements.
   real(wp), parameter :: bound = 0.25_wp*real(n, wp)**2/(sum(shares**3)*sum(profile))

   !> Part of the bound within which a traction comes to it in a rounded corner.
   real(wp), parameter :: corner = 0.05_wp

   !> Creepage, in e0, at which half of the wrench is that of full sliding.
   real(wp), parameter :: sliding_creepage = 1.0e3_wp

contains

   !> Row of FASTSIM.
   function fastsim() result(model)
      type(creep_model_type) :: model

      model%info = model_info_type("fastsim", "bristles with a parabolic bound, in the " // &
         "middles of 20 x 20 elements, as published but for a rounded corner of the bound", "", &
         "J. J. Kalker, Vehicle System Dynamics 11 (1982) 1")
      model%create => new_fastsim
   end function fastsim

   !> Make the law.
   subroutine new_fastsim(parameters, creep)
      type(parameters_type), intent(in) :: parameters
      class(creep_type), allocatable, intent(out) :: creep

      allocate(fastsim_type :: creep)
   end subroutine new_fastsim

   !> Wrench of the tractions along strips, from where the material enters.
   pure subroutine kernel(self, spot, motion, wrench)
      class(fastsim_type), intent(in) :: self
      type(creep_spot_type), intent(in) :: spot
      type(creep_motion_type), intent(in) :: motion
      !> Force along the major and the minor axis, torque about the normal.
      real(wp), intent(out) :: wrench(3)
      type(flow_type) :: flow
      type(strip_type) :: strip
      real(wp) :: slides, rolls, exact(3), sums(3), force(2), moment, t(2), y, step
      real(wp) :: middle, most, size2, share
      integer :: i, j

      call wrench_exact(spot%shape, slip_type(motion%x, motion%y, motion%spin), .true., wrench)
      rolls = sliding_creepage*sqrt(motion%rx**2 + motion%ry**2)
      slides = sqrt(motion%x**2 + motion%y**2 + spot%shape%k*motion%spin**2)
      if (rolls <= 0.25_wp*epsilon(rolls)*slides) return
      exact = wrench
      flow = new_flow(spot, motion)
      ! Tractions times V.
      sums = 0.0_wp
      do j = 1, n
         strip = strip_at(flow, motion%spin, places(j), shares(j))
         step = 2.0_wp*strip%l/real(n, wp)
         middle = bound*shares(j)**2*flow%rolls/spot%shape%k
         ! By steps, not by lengths.
         strip%g0 = step*strip%g0
         strip%g1 = step*strip%g1
         ! Less half a step, so that the first one is of half the length.
         t = -0.5_wp*(strip%g0 + 0.5_wp*step*strip%g1)
         force = 0.0_wp
         moment = 0.0_wp
         do i = 1, n
            y = (real(i, wp) - 0.5_wp)*step
            t = t + (strip%g0 + y*strip%g1)
            most = middle*profile(i)
            size2 = t(1)**2 + t(2)**2
            if (size2 > most**2) then
               t = t*(most/sqrt(size2))
            else if (size2 > ((1.0_wp - corner)*most)**2) then
               t = t*cut(sqrt(size2)/most, corner)
            end if
            force = force + t
            moment = moment + y*t(2)
         end do
         sums(:2) = sums(:2) + shares(j)*force
         sums(3) = sums(3) + shares(j)*(moment + (strip%xi - strip%l)*force(2) - &
            strip%eta*force(1))
      end do
      sums = (4.0_wp*spot%shape%k/(real(n, wp)**2*flow%rolls))*sums
      share = slides**2/(slides**2 + rolls**2)
      wrench = share*exact - (1.0_wp - share)*to_axes(flow, sums)
      call confine(spot, motion, wrench)
   end subroutine kernel

end module contensou_contact_creep_fastsim
