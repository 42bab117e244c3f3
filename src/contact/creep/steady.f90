!> Steady rolling in a contact: a law of creep with the materials of the two bodies.
!>
!> What rolls has no jump at rest, and no velocity is needed to smooth one. Where a contact neither
!> rolls nor slides nor spins the wrench jumps as that of full sliding does, over velocities that no
!> tolerance resolves. There it is s W, with q the velocity of all three together, r what is
!> resolved and delta = r (1 + q^2/r^2)^(-3/2), as for full sliding:
!>    s = q/sqrt(q^2 + delta^2),
!> which changes the wrench by (r/q)^8/2 away from rest, and nothing beyond 100 r.
module contensou_contact_creep_steady
   use contensou_base_kinds, only : wp
   use contensou_contact_creep_law, only : creep_spot, creep_spot_type, creep_type, n_arguments, &
      passing_type, settled_spot
   use contensou_contact_friction_law, only : friction_type
   use contensou_contact_spot, only : circular_shape, spot_shape_type
   implicit none(type, external)
   private

   public :: steady_type

   !> Square of the velocity in units of what is resolved beyond which all is.
   real(wp), parameter :: resolved = 1.0e4_wp

   !> A law of creep between two materials.
   type :: steady_type
      !> The law.
      class(creep_type), allocatable :: creep
      !> Friction coefficient, moduli, and the shape that was met last.
      type(creep_spot_type), private :: spot
   contains
      procedure :: begin
      procedure :: follow
      procedure :: wrench
      procedure :: linearize
      procedure :: reach
      procedure, private :: known
      procedure, private :: spot_of
   end type steady_type

contains

   !> Take the materials.
   subroutine begin(self, coefficient, modulus, poisson)
      class(steady_type), intent(inout) :: self
      !> Friction coefficient f [-].
      real(wp), intent(in) :: coefficient
      !> Shear modulus [Pa] and Poisson's ratio of both bodies together.
      real(wp), intent(in) :: modulus, poisson

      self%spot = creep_spot(circular_shape, coefficient, modulus, poisson)
   end subroutine begin

   !> Take the shape of the spot, so that what follows from it is at hand.
   pure subroutine follow(self, shape, settled)
      class(steady_type), intent(inout) :: self
      type(spot_shape_type), intent(in) :: shape
      !> Whether it stays the same.
      logical, intent(in) :: settled

      if (self%known(shape) .and. .not. settled) return
      self%spot = self%spot_of(shape)
      if (settled) self%spot = settled_spot(self%spot)
   end subroutine follow

   !> Whether a shape is that which was met last.
   pure logical function known(self, shape)
      class(steady_type), intent(in) :: self
      type(spot_shape_type), intent(in) :: shape

      known = .not. abs(shape%k - self%spot%shape%k) > 0.0_wp
   end function known

   !> The spot of another shape.
   pure function spot_of(self, shape) result(spot)
      class(steady_type), intent(in) :: self
      type(spot_shape_type), intent(in) :: shape
      type(creep_spot_type) :: spot

      spot = creep_spot(shape, self%spot%coefficient, self%spot%modulus, self%spot%poisson)
   end function spot_of

   !> Friction force along the axes of the spot [N] and torque about the normal [N m].
   pure subroutine wrench(self, shape, at, force)
      class(steady_type), intent(in) :: self
      type(spot_shape_type), intent(in) :: shape
      type(passing_type), intent(in) :: at
      real(wp), intent(out) :: force(3)
      real(wp) :: u

      ! A spot that is known is not copied.
      if (self%known(shape)) then
         call self%creep%wrench(self%spot, at, force)
      else
         call self%creep%wrench(self%spot_of(shape), at, force)
      end if
      if (.not. at%resolution > 0.0_wp) return
      u = square_of(self, at)/at%resolution
      if (u < resolved) force = sqrt(share_of(u))*force
   end subroutine wrench

   !> The same with its derivatives by N, a, vx, vy, w, cx, cy, at constant shape.
   pure subroutine linearize(self, friction, shape, at, force, slopes)
      class(steady_type), intent(in) :: self
      !> What acts where the whole spot slides.
      class(friction_type), intent(in) :: friction
      type(spot_shape_type), intent(in) :: shape
      type(passing_type), intent(in) :: at
      real(wp), intent(out) :: force(3)
      real(wp), intent(out) :: slopes(3, n_arguments)
      real(wp) :: u, share, by_u, by(n_arguments)
      integer :: i

      u = square_of(self, at)
      if (.not. u > 0.0_wp) then
         slopes = 0.0_wp
         call friction%linearize(shape, at%sliding_type, force, slopes(:, :5))
         return
      end if
      if (self%known(shape)) then
         call self%creep%linearize(self%spot, at, force, slopes)
      else
         call self%creep%linearize(self%spot_of(shape), at, force, slopes)
      end if
      if (.not. at%resolution > 0.0_wp) return
      u = u/at%resolution
      if (u >= resolved) return
      share = share_of(u)
      ! Of the logarithm of the factor.
      by_u = 0.5_wp/u - 0.5_wp*(1.0_wp - 3.0_wp/(1.0_wp + u)**4)*(share/u)
      by = [0.0_wp, at%a*at%w**2, at%vx, at%vy, at%a**2*at%w, at%cx, at%cy] &
         *(2.0_wp/at%resolution*by_u)
      if (.not. self%creep%sticks) by(6:7) = 0.0_wp
      do i = 1, n_arguments
         slopes(:, i) = sqrt(share)*(slopes(:, i) + by(i)*force)
      end do
      force = sqrt(share)*force
   end subroutine linearize

   !> Sliding velocity over which friction grows where nothing slips yet [m/s]: that of f N on the
   !> slope G a b C11/V of the linear theory, C11 = 4.2.
   pure real(wp) function reach(self, shape, load, a, rolling)
      class(steady_type), intent(in) :: self
      type(spot_shape_type), intent(in) :: shape
      !> Normal force [N].
      real(wp), intent(in) :: load
      !> Major semi-axis [m], > 0.
      real(wp), intent(in) :: a
      !> Velocity of the material through the spot V [m/s].
      real(wp), intent(in) :: rolling

      reach = 0.0_wp
      if (self%creep%sticks) reach = self%spot%coefficient*load*rolling &
         /(4.2_wp*self%spot%modulus*shape%k*a**2)
   end function reach

   !> Square of all velocities together on which the wrench depends [m2/s2].
   pure real(wp) function square_of(self, at) result(square)
      type(steady_type), intent(in) :: self
      type(passing_type), intent(in) :: at

      square = at%vx**2 + at%vy**2 + (at%a*at%w)**2
      if (self%creep%sticks) square = square + at%cx**2 + at%cy**2
   end function square_of

   !> Square of the factor at the square of the velocity in units of what is resolved.
   pure real(wp) function share_of(u) result(share)
      real(wp), intent(in) :: u

      share = u/(u + 1.0_wp/(1.0_wp + u)**3)
   end function share_of

end module contensou_contact_creep_steady
