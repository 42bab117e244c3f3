!> Normal part of a contact: elastic force, elastic energy and spot.
module contensou_contact_normal_law
   use contensou_base_kinds, only : wp
   use contensou_contact_catalogue, only : model_type
   use contensou_contact_hertz, only : hertz_contact, hertz_kernel, hertz_spot_type, hertz_type
   use contensou_contact_parameters, only : parameters_type, surroundings_type
   use contensou_contact_spot, only : circular_shape, elliptic_shape_of_c1, spot_shape_type
   implicit none(type, external)
   private

   public :: normal_type, normal_model_type, new_normal

   !> Mean over the impulse of the root of the approach in Hertz's impact, over the largest one:
   !> B(6/5, 1/2)/2.
   real(wp), parameter :: mean_root = 0.5_wp*gamma(1.2_wp)*gamma(0.5_wp) &
      /gamma(1.7_wp)

   !> Normal force: everything but the approach is computed once for given relative curvatures.
   type, extends(hertz_type) :: normal_type
      !> Shape of the spot; kept only where friction needs it.
      type(spot_shape_type) :: shape = circular_shape
      !> Half relative curvature A that the rest belongs to [1/m].
      real(wp) :: curvature_a = 0.0_wp
      !> Half relative curvature B that the rest belongs to [1/m].
      real(wp) :: curvature_b = 0.0_wp
      !> Effective modulus E* [Pa].
      real(wp) :: modulus = 0.0_wp
      !> Whether the shape of the spot is needed.
      logical :: with_shape = .true.
      !> Whether the force is Vil'ke's.
      logical :: volumetric = .false.
      !> Force and spot.
      procedure(hertz_kernel), pointer, nopass :: kernel => null()
   contains
      procedure :: follow
      procedure :: major_axis
      procedure :: minor_axis
      procedure :: spot_of_impact
      procedure :: curvature_forces
   end type normal_type

   !> A row in the table of the normal models.
   type, extends(model_type) :: normal_model_type
      !> Makes the normal part from the values of its keys.
      procedure(create_normal), pointer, nopass :: create => null()
      !> Whether there is no compliance.
      logical :: rigid = .false.
   end type normal_model_type

   abstract interface
      !> Make the normal part of a contact.
      subroutine create_normal(parameters, around, normal)
         import :: normal_type, parameters_type, surroundings_type
         implicit none(type, external)
         !> Values of its keys.
         type(parameters_type), intent(in) :: parameters
         !> What the contact is between.
         type(surroundings_type), intent(in) :: around
         type(normal_type), intent(out) :: normal
      end subroutine create_normal
   end interface

contains

   !> Contact of given curvatures.
   pure function new_normal(modulus, curvature_a, curvature_b, kernel, volumetric, with_shape) &
      result(self)
      !> Effective modulus E* [Pa], > 0.
      real(wp), intent(in) :: modulus
      !> Half relative curvature A along the major axis [1/m], > 0.
      real(wp), intent(in) :: curvature_a
      !> Half relative curvature B along the minor axis [1/m], >= A.
      real(wp), intent(in) :: curvature_b
      !> Force and spot; Hertz's unless said otherwise.
      procedure(hertz_kernel), optional :: kernel
      !> Whether the kernel is Vil'ke's.
      logical, intent(in), optional :: volumetric
      !> Whether the shape of the spot is needed, .true. unless said otherwise.
      logical, intent(in), optional :: with_shape
      type(normal_type) :: self

      self%modulus = modulus
      self%kernel => hertz_contact
      if (present(kernel)) self%kernel => kernel
      if (present(volumetric)) self%volumetric = volumetric
      if (present(with_shape)) self%with_shape = with_shape
      call self%follow(curvature_a, curvature_b)
   end function new_normal

   !> Follow a change of the curvatures; nothing is computed while they stay the same.
   pure subroutine follow(self, curvature_a, curvature_b)
      class(normal_type), intent(inout) :: self
      !> Half relative curvature A along the major axis [1/m], > 0.
      real(wp), intent(in) :: curvature_a
      !> Half relative curvature B along the minor axis [1/m], >= A.
      real(wp), intent(in) :: curvature_b
      type(hertz_spot_type) :: spot

      if (abs(curvature_a - self%curvature_a) <= 0.0_wp .and. &
         abs(curvature_b - self%curvature_b) <= 0.0_wp) return
      self%curvature_a = curvature_a
      self%curvature_b = curvature_b
      call self%kernel(curvature_a, curvature_b, self%modulus, 1.0_wp, spot)
      call self%scale_from(spot)
      if (.not. self%with_shape) return
      if (curvature_a < curvature_b) then
         self%shape = elliptic_shape_of_c1(self%c1)
      else
         self%shape = circular_shape
      end if
   end subroutine follow

   !> Major semi-axis of the spot [m].
   pure function major_axis(self, approach) result(a)
      class(normal_type), intent(in) :: self
      !> Approach d [m], >= 0.
      real(wp), intent(in) :: approach
      real(wp) :: a

      a = self%axis_a*sqrt(approach)
   end function major_axis

   !> Minor semi-axis of the spot [m], whether or not its shape is kept.
   pure function minor_axis(self, approach) result(b)
      class(normal_type), intent(in) :: self
      !> Approach d [m], >= 0.
      real(wp), intent(in) :: approach
      real(wp) :: b

      b = self%major_axis(approach)
      if (self%curvature_a < self%curvature_b) b = sqrt(self%c1)*b
   end function minor_axis

   !> Major semi-axis of the spot of an impact, the mean over the impulse [m].
   pure function spot_of_impact(self, inverse_mass, speed) result(a)
      class(normal_type), intent(in) :: self
      !> Rate of the gap by a unit impulse [1/kg].
      real(wp), intent(in) :: inverse_mass
      !> Speed of approach, of either sign [m/s].
      real(wp), intent(in) :: speed
      real(wp) :: a

      a = mean_root*self%axis_a*(1.25_wp*speed**2/(inverse_mass*self%stiffness))**0.2_wp
   end function spot_of_impact

   !> Generalised forces of the curvatures, -dU/dA and -dU/dB of the elastic energy U(d, A, B) [N
   !> m2].
   !>
   !> Hertz's pressure p makes int p (d - A x^2 - B y^2) - (its own work)/2 stationary, so that
   !> dU/dA = -int p x^2 = -N a^2/5, dU/dB = -N b^2/5. Vil'ke's U goes with (A B)^(-1/4).
   pure subroutine curvature_forces(self, approach, force_a, force_b)
      class(normal_type), intent(in) :: self
      !> Approach d [m], >= 0.
      real(wp), intent(in) :: approach
      !> -dU/dA [N m2].
      real(wp), intent(out) :: force_a
      !> -dU/dB [N m2].
      real(wp), intent(out) :: force_b
      real(wp) :: work

      work = self%force(approach)*approach
      if (self%volumetric) then
         force_a = 0.1_wp*work/self%curvature_a
         force_b = 0.1_wp*work/self%curvature_b
      else
         force_a = 0.2_wp*work*self%axis_a**2
         force_b = 0.2_wp*work*self%axis_b**2
      end if
   end subroutine curvature_forces

end module contensou_contact_normal_law
