!> The default law of creep: the exact theory of steady rolling from a table.
!>
!> With the rolling direction as x, z = (c1 xi, c2 eta, c3 phi) the creepages scaled so that their
!> linear forces and torque are of the size of their limits, tau = |z|, the wrench is
!>    W = alpha L + beta W_exact + gamma omega R(p, ln g),   p = z 2/(z0 + sqrt(z0^2 + 4 tau^2)),
!> L the linear theory of Kalker, W_exact full sliding, and R tabulated from boundary elements on
!> the ball |p| <= 1 as cubic splines in p and in ln g, g being the ratio of the half-length of
!> the spot along the rolling direction to its half-width. S being the force of the strip theory
!> without spin (Haines and Ollerton 1963), which is one from tau = 3 pi/4 on,
!>    beta = S^4,   alpha = (S - beta)/tau,   gamma = tau^2/(tau^2 + gamma0^2),
!> so that small creep has the linear theory; omega tends to zero where creep is without end.
!> Poisson's ratio, and the direction oblique to the axes, enter through L, W_exact and the scales
!> alone. scripts/generate_creep.py makes the table; docs/rolling.md has the errors.
module contensou_contact_creep_table
   use, intrinsic :: iso_fortran_env, only : int16
   use contensou_base_kinds, only : pi, wp
   use contensou_contact_catalogue, only : model_info_type
   use contensou_contact_creep_bounds, only : confine
   use contensou_contact_creep_law, only : creep_model_type, creep_motion_type, creep_spot_type, &
      creep_type, n_velocities
   use contensou_contact_creep_table_values, only : ball, correction, first_ratio, n_ratios, &
      nodes, ratio_step, unit
   use contensou_contact_kalker, only : kalker_matrix
   use contensou_contact_parameters, only : parameters_type
   use contensou_contact_wrench, only : slip_type, wrench_exact, wrench_exact_jacobian
   implicit none(type, external)
   private

   public :: tabulated

   !> Linear force in f N per G a b e0.
   real(wp), parameter :: force_unit = 1.5_wp/pi

   !> tau at which gamma is one half.
   real(wp), parameter :: fade_in = 0.1_wp

   !> 1 - |p|^2 at which omega is one half.
   real(wp), parameter :: fade_out = 1.0e-3_wp

   type, extends(creep_type) :: table_type
   contains
      procedure :: kernel
      procedure :: kernel_slopes
   end type table_type

   !> What the law has of the spot and the rolling direction.
   type :: frame_type
      !> Rolling direction.
      real(wp) :: e(2)
      !> Linear theory in the frame along and across: forces in f N, f N sqrt(a b) over creepages in
      !> e0, with its sign; and the derivative by the angle of the rolling direction.
      real(wp) :: linear(3, 3), linear_slope(3, 3)
      !> Scales of the creepages, and the derivatives by the angle.
      real(wp) :: scales(3), scale_slopes(3)
      !> ln g, and the derivative by the angle.
      real(wp) :: ratio, ratio_slope
   end type frame_type

contains

   !> Row of the table.
   function tabulated() result(model)
      type(creep_model_type) :: model

      model%info = model_info_type("table", &
         "exact theory on two half-spaces, tabulated from boundary_elements", "", &
         "J. J. Kalker, Three-Dimensional Elastic Bodies in Rolling Contact, 1990")
      model%create => new_table
   end function tabulated

   !> Make the law.
   subroutine new_table(parameters, creep)
      type(parameters_type), intent(in) :: parameters
      class(creep_type), allocatable, intent(out) :: creep

      allocate(table_type :: creep)
   end subroutine new_table

   !> A share of full sliding, and what the table adds.
   pure subroutine kernel(self, spot, motion, wrench)
      class(table_type), intent(in) :: self
      type(creep_spot_type), intent(in) :: spot
      type(creep_motion_type), intent(in) :: motion
      !> Force along the major and the minor axis, torque about the normal.
      real(wp), intent(out) :: wrench(3)
      type(frame_type) :: frame
      real(wp) :: rolling, velocity(3), remainder(3), share, unused(3, 5), share_slope(5), root

      call wrench_exact(spot%shape, slip_type(motion%x, motion%y, motion%spin), .true., wrench)
      rolling = hypot(motion%rx, motion%ry)
      if (.not. rolling > 0.0_wp) return
      root = sqrt(spot%shape%k)
      call place(spot, motion, rolling, .false., frame)
      velocity = in_frame(frame, [motion%x, motion%y, root*motion%spin])
      call evaluate(frame, velocity, rolling, .false., share, remainder, share_slope, unused)
      wrench = share*wrench + from_frame(frame, [remainder(1), remainder(2), root*remainder(3)])
      call confine(spot, motion, wrench)
   end subroutine kernel

   !> The wrench and its derivatives by the velocities.
   pure subroutine kernel_slopes(self, spot, motion, wrench, jacobian)
      class(table_type), intent(in) :: self
      type(creep_spot_type), intent(in) :: spot
      type(creep_motion_type), intent(in) :: motion
      !> Force along the major and the minor axis, torque about the normal.
      real(wp), intent(out) :: wrench(3)
      !> Derivative of component i by x, y, spin, rx, ry; those by rx, ry are zero where nothing
      !> rolls.
      real(wp), intent(out) :: jacobian(3, n_velocities)
      type(frame_type) :: frame
      real(wp) :: rolling, velocity(3), remainder(3), share, slopes(3, 5), share_slope(5), root
      real(wp) :: sliding(3), turning(3)
      integer :: i

      jacobian = 0.0_wp
      call wrench_exact_jacobian(spot%shape, slip_type(motion%x, motion%y, motion%spin), wrench, &
         jacobian(:, :3))
      rolling = hypot(motion%rx, motion%ry)
      if (.not. rolling > 0.0_wp) return
      root = sqrt(spot%shape%k)
      call place(spot, motion, rolling, .true., frame)
      velocity = in_frame(frame, [motion%x, motion%y, root*motion%spin])
      call evaluate(frame, velocity, rolling, .true., share, remainder, share_slope, slopes)
      sliding = wrench
      wrench = share*sliding &
         + from_frame(frame, [remainder(1), remainder(2), root*remainder(3)])
      ! From velocities in the frame, the rolling velocity and the angle of the frame to those along
      ! the axes. Turning the frame alone turns velocities back and the force along.
      slopes(:, 5) = slopes(:, 5) + slopes(:, 1)*velocity(2) - slopes(:, 2)*velocity(1) &
         + [-remainder(2), remainder(1), 0.0_wp]
      share_slope(5) = share_slope(5) + share_slope(1)*velocity(2) - share_slope(2)*velocity(1)
      slopes(3, :) = root*slopes(3, :)
      do i = 1, 5
         slopes(:, i) = from_frame(frame, slopes(:, i)) + share_slope(i)*sliding
      end do
      jacobian(:, :3) = share*jacobian(:, :3)
      jacobian(:, 1) = jacobian(:, 1) + frame%e(1)*slopes(:, 1) - frame%e(2)*slopes(:, 2)
      jacobian(:, 2) = jacobian(:, 2) + frame%e(2)*slopes(:, 1) + frame%e(1)*slopes(:, 2)
      jacobian(:, 3) = jacobian(:, 3) + root*slopes(:, 3)
      turning = slopes(:, 5)/rolling
      jacobian(:, 4) = -frame%e(1)*slopes(:, 4) + frame%e(2)*turning
      jacobian(:, 5) = -frame%e(2)*slopes(:, 4) - frame%e(1)*turning
      call confine(spot, motion, wrench, jacobian)
   end subroutine kernel_slopes

   !> A vector of the plane and a third component, turned from the axes into the rolling frame.
   pure function in_frame(frame, vector) result(turned)
      type(frame_type), intent(in) :: frame
      real(wp), intent(in) :: vector(3)
      real(wp) :: turned(3)

      turned = [frame%e(1)*vector(1) + frame%e(2)*vector(2), &
         frame%e(1)*vector(2) - frame%e(2)*vector(1), vector(3)]
   end function in_frame

   !> And back.
   pure function from_frame(frame, vector) result(turned)
      type(frame_type), intent(in) :: frame
      real(wp), intent(in) :: vector(3)
      real(wp) :: turned(3)

      turned = [frame%e(1)*vector(1) - frame%e(2)*vector(2), &
         frame%e(2)*vector(1) + frame%e(1)*vector(2), vector(3)]
   end function from_frame

   !> What the law has of the spot and the rolling direction.
   pure subroutine place(spot, motion, rolling, with_slopes, frame)
      type(creep_spot_type), intent(in) :: spot
      type(creep_motion_type), intent(in) :: motion
      !> Length of the rolling velocity, > 0.
      real(wp), intent(in) :: rolling
      logical, intent(in) :: with_slopes
      type(frame_type), intent(out) :: frame
      real(wp) :: c(3, 3), c_slope(3, 3), square, k, limit
      associate(e => frame%e)
         frame%e = -[motion%rx, motion%ry]/rolling
         k = spot%shape%k
         call kalker_matrix(k, spot%poisson, e, c, c_slope, spot%by_direction)
         frame%linear = -force_unit*c
         limit = spot%shape%torque/sqrt(k)
         frame%scales = force_unit*[c(1, 1), c(2, 2), hypot(c(2, 3), c(3, 3)/limit)]
         square = e(1)**2*k + e(2)**2/k
         frame%ratio = -log(square)
         frame%linear_slope = 0.0_wp
         frame%scale_slopes = 0.0_wp
         frame%ratio_slope = 0.0_wp
         if (with_slopes) then
            frame%linear_slope = -force_unit*c_slope
            frame%scale_slopes = force_unit*[c_slope(1, 1), c_slope(2, 2), force_unit &
               *(c(2, 3)*c_slope(2, 3) + c(3, 3)*c_slope(3, 3)/limit**2)/frame%scales(3)]
            frame%ratio_slope = -2.0_wp*e(1)*e(2)*(1.0_wp/k - k)/square
         end if
      end associate
   end subroutine place

   !> Share of full sliding, and what else the wrench has, in the rolling frame.
   pure subroutine evaluate(frame, velocity, rolling, with_slopes, share, remainder, share_slope, &
      slopes)
      type(frame_type), intent(in) :: frame
      !> Sliding velocities along and across, and of spin.
      real(wp), intent(in) :: velocity(3)
      !> Rolling velocity, > 0.
      real(wp), intent(in) :: rolling
      logical, intent(in) :: with_slopes
      !> beta.
      real(wp), intent(out) :: share
      !> alpha L + gamma omega R.
      real(wp), intent(out) :: remainder(3)
      !> Derivatives of beta by the velocities, the rolling velocity and the angle of the frame.
      real(wp), intent(out) :: share_slope(5)
      !> And of the remainder.
      real(wp), intent(out) :: slopes(3, 5)
      real(wp) :: z(3), z2, size2, root, p(3), inverse, weight, fade, fall, table(3)
      real(wp) :: table_slopes(3, 4), alpha, tau, force, slope, linear(3), fade_rate, fall_rate
      real(wp) :: alpha_rate, share_rate, weight_rate, by_z(3, 3), share_by_z(3), along(3)
      integer :: i

      ! z and tau times the rolling velocity V, without division by it.
      z = frame%scales*velocity
      z2 = dot_product(z, z)
      size2 = sqrt(z2)
      share_slope = 0.0_wp
      slopes = 0.0_wp
      root = sqrt((ball*rolling)**2 + 4.0_wp*z2)
      inverse = 2.0_wp/(ball*rolling + root)
      p = z*inverse
      call interpolate(p, frame%ratio, with_slopes, table, table_slopes)
      ! gamma; and omega of 1 - |p|^2 = ball V inverse, which is exact also where it is small.
      fade = z2/(z2 + (fade_in*rolling)**2)
      fall = ball*rolling*inverse
      weight = fade*fall/(fall + fade_out)
      remainder = weight*table
      ! The strip theory; beyond its end there is no linear part.
      share = 1.0_wp
      alpha = 0.0_wp
      alpha_rate = 0.0_wp
      share_rate = 0.0_wp
      if (size2 < 0.75_wp*pi*rolling) then
         tau = size2/rolling
         call strip(tau, force, slope)
         ! force is S/tau, slope dS/dtau.
         share = (force*tau)**4
         alpha = force*(1.0_wp - (force*tau)**3)
         linear = matmul(frame%linear, velocity)/rolling
         remainder = remainder + alpha*linear
      end if
      if (.not. with_slopes) return

      ! By z V at constant V; fade_rate and the others are derivatives by tau^2 V^2 times two.
      fade_rate = 2.0_wp*(fade_in*rolling)**2/(z2 + (fade_in*rolling)**2)**2
      fall_rate = -2.0_wp*fall*inverse/root
      weight_rate = fade_rate*fall/(fall + fade_out) + fade*fade_out*fall_rate/(fall + fade_out)**2
      along = matmul(table_slopes(:, :3), p)
      do i = 1, 3
         by_z(:, i) = weight*inverse*(table_slopes(:, i) - along*(2.0_wp*z(i)/root)) &
            + weight_rate*z(i)*table
      end do
      share_by_z = 0.0_wp
      if (size2 < 0.75_wp*pi*rolling .and. size2 > 0.0_wp) then
         share_rate = 4.0_wp*(force*tau)**3*slope/(tau*rolling**2)
         alpha_rate = (slope*(1.0_wp - 4.0_wp*(force*tau)**3) - alpha)/(tau*rolling)**2
         share_by_z = share_rate*z
         do i = 1, 3
            by_z(:, i) = by_z(:, i) + alpha_rate*z(i)*linear
         end do
      end if
      do i = 1, 3
         slopes(:, i) = frame%scales(i)*by_z(:, i) + alpha*frame%linear(:, i)/rolling
         share_slope(i) = frame%scales(i)*share_by_z(i)
      end do
      ! Everything depends on the ratios of velocities alone.
      slopes(:, 4) = -matmul(slopes(:, :3), velocity)/rolling
      share_slope(4) = -dot_product(share_slope(:3), velocity)/rolling
      slopes(:, 5) = matmul(by_z, frame%scale_slopes*velocity) &
         + alpha*matmul(frame%linear_slope, velocity)/rolling &
         + weight*table_slopes(:, 4)*frame%ratio_slope
      share_slope(5) = dot_product(share_by_z, frame%scale_slopes*velocity)
   end subroutine evaluate

   !> Force of the strip theory over tau, and its derivative by tau, for tau below 3 pi/4.
   pure subroutine strip(tau, force, slope)
      real(wp), intent(in) :: tau
      !> S/tau.
      real(wp), intent(out) :: force
      !> dS/dtau.
      real(wp), intent(out) :: slope
      real(wp) :: s, h, angle

      s = min(tau*(4.0_wp/(3.0_wp*pi)), 1.0_wp)
      h = sqrt((1.0_wp - s)*(1.0_wp + s))
      angle = acos(s)
      force = (2.0_wp/pi)*(angle + s**3*(2.0_wp + h)/(3.0_wp*(1.0_wp + h)**2))
      slope = (2.0_wp/pi)*(angle - s*h)
   end subroutine strip

   !> The tabulated remainder R, and its derivatives by p and ln g.
   pure subroutine interpolate(p, ratio, with_slopes, values, slopes)
      !> Place in the ball.
      real(wp), intent(in) :: p(3)
      !> ln g; beyond the ends of the table it is that of the end.
      real(wp), intent(in) :: ratio
      logical, intent(in) :: with_slopes
      real(wp), intent(out) :: values(3)
      real(wp), intent(out) :: slopes(3, 4)
      real(wp) :: place(4), weights(4, 4), rates(4, 4), block(12, 4, 4, 2), plane(12, 4, 3)
      real(wp) :: row(12, 4), turn, mirror, x
      integer :: cell(4), i, j, l, m

      ! The other signs of the spin, and of the creepage along, by symmetry.
      turn = sign(1.0_wp, p(3))
      mirror = sign(1.0_wp, turn*p(1))
      place = [real(nodes, wp)*[mirror*turn*p(1), turn*p(2), turn*p(3)], &
         min(max((ratio - first_ratio)/ratio_step, 0.0_wp), real(n_ratios - 1, wp))]
      cell = [min(int(place(1)), nodes - 1), min(max(floor(place(2)), -nodes), nodes - 1), &
         min(int(place(3)), nodes - 1), min(int(place(4)), n_ratios - 2)]
      values = 0.0_wp
      slopes = 0.0_wp
      do i = 1, 4
         x = place(i) - real(cell(i), wp)
         weights(:, i) = [(1.0_wp - x)**3, 4.0_wp + x*x*(3.0_wp*x - 6.0_wp), &
            1.0_wp + 3.0_wp*x*(1.0_wp + x*(1.0_wp - x)), x**3]/6.0_wp
         rates(:, i) = [-(1.0_wp - x)**2, x*(3.0_wp*x - 4.0_wp), 1.0_wp + x*(2.0_wp - 3.0_wp*x), &
            x*x]/2.0_wp
      end do
      ! The sum over ln g, and by its derivative.
      rates(:, 4) = rates(:, 4)/ratio_step
      if (.not. (ratio > first_ratio .and. place(4) < real(n_ratios - 1, wp))) rates(:, 4) = 0.0_wp
      block = 0.0_wp
      do m = 1, 4
         do l = 1, 4
            do j = 1, 4
               call add(correction(1, cell(1) - 1, cell(2) + j - 2, cell(3) + l - 2, cell(4) + m), &
                  weights(m, 4), block(:, j, l, 1))
               if (with_slopes) call add(correction(1, cell(1) - 1, cell(2) + j - 2, &
                  cell(3) + l - 2, cell(4) + m), rates(m, 4), block(:, j, l, 2))
            end do
         end do
      end do
      ! Over the spin, across, along: values first, then with the derivative by the place of each.
      plane(:, :, 1) = contracted(block(:, :, :, 1), weights(:, 3))
      row(:, 1) = matmul(plane(:, :, 1), weights(:, 2))
      values = matmul(reshape(row(:, 1), [3, 4]), weights(:, 1))
      if (with_slopes) then
         plane(:, :, 2) = contracted(block(:, :, :, 1), rates(:, 3))
         plane(:, :, 3) = contracted(block(:, :, :, 2), weights(:, 3))
         row(:, 2) = matmul(plane(:, :, 1), rates(:, 2))
         row(:, 3) = matmul(plane(:, :, 2), weights(:, 2))
         row(:, 4) = matmul(plane(:, :, 3), weights(:, 2))
         slopes(:, 1) = matmul(reshape(row(:, 1), [3, 4]), rates(:, 1))
         do i = 2, 4
            slopes(:, i) = matmul(reshape(row(:, i), [3, 4]), weights(:, 1))
         end do
         slopes(:, :3) = unit*real(nodes, wp)*slopes(:, :3)
         slopes(:, 4) = unit*slopes(:, 4)
         ! Values change with the signs, derivatives with those of the places too.
         slopes(:, 1) = mirror*slopes(:, 1)*[mirror, 1.0_wp, 1.0_wp]
         slopes(:, 2) = slopes(:, 2)*[mirror, 1.0_wp, 1.0_wp]
         slopes(:, 3) = slopes(:, 3)*[mirror, 1.0_wp, 1.0_wp]
         slopes(:, 4) = slopes(:, 4)*turn*[mirror, 1.0_wp, 1.0_wp]
      end if
      values = unit*turn*values*[mirror, 1.0_wp, 1.0_wp]
   end subroutine interpolate

   !> Add coefficients of four places along with a weight.
   pure subroutine add(values, weight, total)
      integer(int16), intent(in) :: values(12)
      real(wp), intent(in) :: weight
      real(wp), intent(inout) :: total(12)

      total = total + weight*real(values, wp)
   end subroutine add

   !> The sum of planes with weights.
   pure function contracted(block, weights) result(plane)
      real(wp), intent(in) :: block(12, 4, 4)
      real(wp), intent(in) :: weights(4)
      real(wp) :: plane(12, 4)

      plane = weights(1)*block(:, :, 1) + weights(2)*block(:, :, 2) + weights(3)*block(:, :, 3) &
         + weights(4)*block(:, :, 4)
   end function contracted

end module contensou_contact_creep_table
