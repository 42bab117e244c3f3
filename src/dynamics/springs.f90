!> Springs between two bodies, A and B: bushings, and springs between two points.
!>
!> A bushing joins the point p of B to the point q of A. Its axes are fixed to A: with S their
!> rotation matrix, d = S^T (p - q) is its displacement and t the rotation vector of B against A
!> from the relaxed attitude, both along the axes. It stores
!>    U = d.K d/2 - P.d + t.K_t t/2
!> with the preload P, and gives B at p the force S (P - K d - C d') and the torque
!>    -S (J^-T K_t t + C_t w),   J^-T m = m + t x m/2 + c(t^2) t x (t x m),
!> c(s) = 1/s - cot(sqrt(s)/2)/(2 sqrt(s)), w the relative angular velocity: t' = J^-1 w
!> (J. Stuelpnagel, SIAM Rev. 6 (1964) 422). A takes the opposite wrench at the same point p, so
!> that no energy is gained or lost but in the dashpots, however the bodies move. Rotations are
!> meant up to half a turn.
!>
!> A spring between two points pulls B towards A along the line through them, with the force
!> k (L - L_0) + c L'.
module contensou_dynamics_springs
   use contensou_base_kinds, only : wp
   use contensou_base_rotations, only : rotation_vector
   use contensou_base_vectors, only : cross
   use contensou_contact_geometry, only : pose_type
   implicit none(type, external)
   private

   public :: spring_type, spring_load_type, spring_kinds, spring_bushing, spring_axial

   !> Kinds of springs: three translations and three rotations, or along a line.
   integer, parameter :: spring_bushing = 1, spring_axial = 2

   !> Their names in a scene, in the order of the codes.
   character(len=*), parameter :: spring_kinds(*) = [character(len=8) :: "bushing", "axial"]

   !> Square of an angle below which the series of c is exact [rad2].
   real(wp), parameter :: small = 0.25_wp

   !> A spring with damping.
   type :: spring_type
      !> Bodies; 0 is the ground.
      integer :: a = 0, b = 0
      !> One of the `spring_*` codes.
      integer :: kind = spring_bushing
      !> Points of A and of B, in their frames [m].
      real(wp) :: point(3, 2) = 0.0_wp
      !> Axes of a bushing as columns, in the frame of A.
      real(wp) :: axes(3, 3) = 0.0_wp
      !> Rotation from the frame of B to that of A when relaxed.
      real(wp) :: relaxed(3, 3) = 0.0_wp
      !> Stiffness and damping along the axes [N/m, N s/m]; the first ones are those of a spring
      !> between two points.
      real(wp) :: stiffness(3) = 0.0_wp, damping(3) = 0.0_wp
      !> Those about the axes [N m/rad, N m s/rad].
      real(wp) :: turning_stiffness(3) = 0.0_wp, turning_damping(3) = 0.0_wp
      !> Force on B without displacement, along the axes [N].
      real(wp) :: preload(3) = 0.0_wp
      !> Length of a relaxed spring between two points [m].
      real(wp) :: length = 0.0_wp
   contains
      procedure :: damps
      procedure :: load
      procedure :: vary
   end type spring_type

   !> What a spring does, inertial frame.
   type :: spring_load_type
      !> Force and torque on B, at its point [N, N m].
      real(wp) :: force(3) = 0.0_wp, torque(3) = 0.0_wp
      !> From the centres of mass of A and B to that point [m].
      real(wp) :: arm_a(3) = 0.0_wp, arm_b(3) = 0.0_wp
      !> Energy that it stores [J].
      real(wp) :: energy = 0.0_wp
      !> Power lost in its damping [W].
      real(wp) :: power = 0.0_wp
   end type spring_load_type

   !> How the ends of a spring lie and move against each other.
   type :: stretch_type
      !> Axes of a bushing, inertial frame.
      real(wp) :: axes(3, 3) = 0.0_wp
      !> From the point of A to that of B [m].
      real(wp) :: reach(3) = 0.0_wp
      !> From the centre of mass of A to its own point [m].
      real(wp) :: own_arm(3) = 0.0_wp
      !> Velocity of B against A: where the point of B is for a bushing, else of the points [m/s].
      real(wp) :: velocity(3) = 0.0_wp
      !> Angular velocity of B against A [rad/s].
      real(wp) :: spin(3) = 0.0_wp
      !> Displacement and its rate along the axes [m, m/s]; of a spring between two points its
      !> elongation and the rate of that come first.
      real(wp) :: shift(3) = 0.0_wp, rate(3) = 0.0_wp
      !> Rotation vector and angular velocity, along the axes [rad, rad/s].
      real(wp) :: angle(3) = 0.0_wp, turning(3) = 0.0_wp
      !> Distance of the points [m], and its direction.
      real(wp) :: distance = 0.0_wp, along(3) = 0.0_wp
   end type stretch_type

   !> How a spring varies with a degree of freedom of its bodies.
   type :: change_type
      !> Of the way from the point of A to that of B.
      real(wp) :: reach(3) = 0.0_wp
      !> Rotation of A, and of B against A.
      real(wp) :: turn_a(3) = 0.0_wp, turn(3) = 0.0_wp
      real(wp) :: arm_a(3) = 0.0_wp, arm_b(3) = 0.0_wp
      !> Of velocity and angular velocity of B against A.
      real(wp) :: velocity(3) = 0.0_wp, spin(3) = 0.0_wp
   end type change_type

contains

   !> Whether a spring loses energy.
   pure logical function damps(self)
      class(spring_type), intent(in) :: self

      damps = any(self%damping > 0.0_wp) .or. any(self%turning_damping > 0.0_wp)
   end function damps

   !> What a spring does at two poses.
   pure subroutine load(self, a, b, found)
      class(spring_type), intent(in) :: self
      type(pose_type), intent(in) :: a
      type(pose_type), intent(in) :: b
      type(spring_load_type), intent(out) :: found
      type(stretch_type) :: stretch

      call find(self, a, b, stretch, found)
   end subroutine load

   !> The same, with how the ends lie.
   pure subroutine find(self, a, b, stretch, found)
      class(spring_type), intent(in) :: self
      type(pose_type), intent(in) :: a
      type(pose_type), intent(in) :: b
      type(stretch_type), intent(out) :: stretch
      type(spring_load_type), intent(out) :: found
      real(wp) :: own(3)

      found%arm_b = matmul(b%rotation, self%point(:, 2))
      stretch%own_arm = matmul(a%rotation, self%point(:, 1))
      own = b%position + found%arm_b
      found%arm_a = own - a%position
      stretch%reach = own - (a%position + stretch%own_arm)
      stretch%spin = b%spin - a%spin
      stretch%velocity = b%velocity + cross(b%spin, found%arm_b) - a%velocity
      if (self%kind == spring_axial) then
         stretch%velocity = stretch%velocity - cross(a%spin, stretch%own_arm)
         stretch%distance = norm2(stretch%reach)
         ! At a point there is no direction to pull in.
         if (.not. stretch%distance > 0.0_wp) return
         stretch%along = stretch%reach/stretch%distance
         stretch%shift(1) = stretch%distance - self%length
         stretch%rate(1) = dot_product(stretch%along, stretch%velocity)
         found%force = -(self%stiffness(1)*stretch%shift(1) + self%damping(1)*stretch%rate(1)) &
            *stretch%along
         found%energy = 0.5_wp*self%stiffness(1)*stretch%shift(1)**2
         found%power = self%damping(1)*stretch%rate(1)**2
         return
      end if
      stretch%velocity = stretch%velocity - cross(a%spin, found%arm_a)
      stretch%axes = matmul(a%rotation, self%axes)
      stretch%shift = matmul(stretch%reach, stretch%axes)
      stretch%rate = matmul(stretch%velocity, stretch%axes)
      stretch%turning = matmul(stretch%spin, stretch%axes)
      if (any(self%turning_stiffness > 0.0_wp)) stretch%angle = rotation_vector(matmul( &
         transpose(self%axes), matmul(matmul(matmul(transpose(a%rotation), b%rotation), &
         transpose(self%relaxed)), self%axes)))
      found%force = matmul(stretch%axes, self%preload - self%stiffness*stretch%shift &
         - self%damping*stretch%rate)
      found%torque = matmul(stretch%axes, -restoring(self%turning_stiffness*stretch%angle, &
         stretch%angle) - self%turning_damping*stretch%turning)
      found%energy = 0.5_wp*dot_product(stretch%shift, self%stiffness*stretch%shift) &
         - dot_product(self%preload, stretch%shift) &
         + 0.5_wp*dot_product(stretch%angle, self%turning_stiffness*stretch%angle)
      found%power = dot_product(stretch%rate, self%damping*stretch%rate) &
         + dot_product(stretch%turning, self%turning_damping*stretch%turning)
   end subroutine find

   !> What a spring does, and the derivatives of force on B, torques about the centres of mass of A
   !> and B, and power lost in friction and damping, by translation, rotation, velocity and angular
   !> velocity of A, then of B, inertial frame.
   subroutine vary(self, a, b, found, slopes)
      class(spring_type), intent(in) :: self
      type(pose_type), intent(in) :: a
      type(pose_type), intent(in) :: b
      type(spring_load_type), intent(out) :: found
      !> The derivatives (11, 24).
      real(wp), intent(out) :: slopes(:, :)
      type(stretch_type) :: stretch
      real(wp) :: e(3)
      integer :: k

      call find(self, a, b, stretch, found)
      slopes = 0.0_wp
      if (self%kind == spring_axial .and. .not. stretch%distance > 0.0_wp) return
      do k = 1, 3
         e = 0.0_wp
         e(k) = 1.0_wp
         associate (arm_a => found%arm_a, arm_b => found%arm_b, own => stretch%own_arm)
            if (self%kind == spring_bushing) then
               call move(k, change_type(reach=-e, arm_a=-e, velocity=cross(a%spin, e)))
               call move(3 + k, change_type(reach=-cross(e, own), turn_a=e, turn=-e))
               call move(12 + k, change_type(reach=e, arm_a=e, velocity=-cross(a%spin, e)))
               call move(15 + k, change_type(reach=cross(e, arm_b), turn=e, &
                  arm_b=cross(e, arm_b), arm_a=cross(e, arm_b), &
                  velocity=cross(b%spin - a%spin, cross(e, arm_b))))
               call move(9 + k, change_type(velocity=-cross(e, arm_a), spin=-e))
            else
               call move(k, change_type(reach=-e, arm_a=-e))
               call move(3 + k, change_type(reach=-cross(e, own), turn_a=e, turn=-e, &
                  velocity=-cross(a%spin, cross(e, own))))
               call move(12 + k, change_type(reach=e, arm_a=e))
               call move(15 + k, change_type(reach=cross(e, arm_b), turn=e, &
                  arm_b=cross(e, arm_b), arm_a=cross(e, arm_b), &
                  velocity=cross(b%spin, cross(e, arm_b))))
               call move(9 + k, change_type(velocity=-cross(e, own), spin=-e))
            end if
            call move(6 + k, change_type(velocity=-e))
            call move(18 + k, change_type(velocity=e))
            call move(21 + k, change_type(velocity=cross(e, arm_b), spin=e))
         end associate
      end do

   contains

      !> Variation with one of the degrees of freedom.
      subroutine move(freedom, by)
         !> Which.
         integer, intent(in) :: freedom
         type(change_type), intent(in) :: by

         call vary_load(self, stretch, found, by, slopes(:, freedom))
      end subroutine move

   end subroutine vary

   !> Variation of the load of a spring.
   pure subroutine vary_load(self, stretch, found, by, slopes)
      type(spring_type), intent(in) :: self
      type(stretch_type), intent(in) :: stretch
      type(spring_load_type), intent(in) :: found
      type(change_type), intent(in) :: by
      !> Of the force on B, the torques on A and B and the powers; that of friction is left.
      real(wp), intent(inout) :: slopes(:)
      real(wp) :: d_shift(3), d_rate(3), d_angle(3), d_turning(3), d_force(3), d_torque(3)
      real(wp) :: d_along(3), d_power

      d_torque = 0.0_wp
      if (self%kind == spring_bushing) then
         d_shift = matmul(by%reach - cross(by%turn_a, stretch%reach), stretch%axes)
         d_rate = matmul(by%velocity - cross(by%turn_a, stretch%velocity), stretch%axes)
         d_turning = matmul(by%spin - cross(by%turn_a, stretch%spin), stretch%axes)
         d_force = cross(by%turn_a, found%force) - matmul(stretch%axes, self%stiffness*d_shift &
            + self%damping*d_rate)
         d_power = 2.0_wp*(dot_product(d_rate, self%damping*stretch%rate) &
            + dot_product(d_turning, self%turning_damping*stretch%turning))
         d_torque = cross(by%turn_a, found%torque) - matmul(stretch%axes, &
            self%turning_damping*d_turning)
         if (any(self%turning_stiffness > 0.0_wp)) then
            d_angle = unrolled(matmul(by%turn, stretch%axes), stretch%angle)
            d_torque = d_torque - matmul(stretch%axes, varied(self%turning_stiffness &
               *stretch%angle, stretch%angle, self%turning_stiffness*d_angle, d_angle))
         end if
      else
         d_along = (by%reach - dot_product(stretch%along, by%reach)*stretch%along) &
            /stretch%distance
         d_shift(1) = dot_product(stretch%along, by%reach)
         d_rate(1) = dot_product(d_along, stretch%velocity) &
            + dot_product(stretch%along, by%velocity)
         d_force = -(self%stiffness(1)*d_shift(1) + self%damping(1)*d_rate(1))*stretch%along &
            - (self%stiffness(1)*stretch%shift(1) + self%damping(1)*stretch%rate(1))*d_along
         d_power = 2.0_wp*self%damping(1)*stretch%rate(1)*d_rate(1)
      end if
      slopes(1:3) = d_force
      slopes(4:6) = -d_torque - cross(by%arm_a, found%force) &
         - cross(found%arm_a, d_force)
      slopes(7:9) = d_torque + cross(by%arm_b, found%force) &
         + cross(found%arm_b, d_force)
      slopes(11) = d_power
   end subroutine vary_load

   !> c(s) and its derivative.
   pure subroutine coefficient(s, c, slope)
      !> Square of the angle [rad2].
      real(wp), intent(in) :: s
      real(wp), intent(out) :: c
      real(wp), intent(out) :: slope
      !> B_2k/(2k)! with the sign of the series of c, k = 1, 2, ...
      real(wp), parameter :: terms(*) = [1.0_wp/12.0_wp, 1.0_wp/720.0_wp, 1.0_wp/30240.0_wp, &
         1.0_wp/1209600.0_wp, 1.0_wp/47900160.0_wp, 691.0_wp/1307674368000.0_wp, &
         1.0_wp/74724249600.0_wp]
      real(wp) :: angle
      integer :: k

      if (s < small) then
         c = 0.0_wp
         slope = 0.0_wp
         do k = size(terms), 1, -1
            slope = slope*s + c
            c = c*s + terms(k)
         end do
      else
         angle = sqrt(s)
         c = 1.0_wp/s - 0.5_wp/(angle*tan(0.5_wp*angle))
         slope = -1.0_wp/s**2 + 0.25_wp/(s*angle*tan(0.5_wp*angle)) &
            + 0.125_wp/(s*sin(0.5_wp*angle)**2)
      end if
   end subroutine coefficient

   !> J^-T m, the torque that is conjugate to m.
   pure function restoring(m, t) result(torque)
      real(wp), intent(in) :: m(3)
      !> Rotation vector [rad].
      real(wp), intent(in) :: t(3)
      real(wp) :: torque(3)
      real(wp) :: c, slope

      call coefficient(dot_product(t, t), c, slope)
      torque = m + 0.5_wp*cross(t, m) + c*cross(t, cross(t, m))
   end function restoring

   !> J^-1 w, the rate of the rotation vector.
   pure function unrolled(w, t) result(rate)
      real(wp), intent(in) :: w(3)
      !> Rotation vector [rad].
      real(wp), intent(in) :: t(3)
      real(wp) :: rate(3)
      real(wp) :: c, slope

      call coefficient(dot_product(t, t), c, slope)
      rate = w - 0.5_wp*cross(t, w) + c*cross(t, cross(t, w))
   end function unrolled

   !> Variation of J^-T m.
   pure function varied(m, t, d_m, d_t) result(torque)
      real(wp), intent(in) :: m(3)
      !> Rotation vector [rad].
      real(wp), intent(in) :: t(3)
      !> Variation of m.
      real(wp), intent(in) :: d_m(3)
      !> Variation of the rotation vector [rad].
      real(wp), intent(in) :: d_t(3)
      real(wp) :: torque(3)
      real(wp) :: c, slope

      call coefficient(dot_product(t, t), c, slope)
      torque = d_m + 0.5_wp*(cross(d_t, m) + cross(t, d_m)) &
         + (2.0_wp*slope*dot_product(t, d_t))*cross(t, cross(t, m)) &
         + c*(cross(d_t, cross(t, m)) + cross(t, cross(d_t, m) + cross(t, d_m)))
   end function varied

end module contensou_dynamics_springs
