!> Normal part of a contact: elastic force, elastic energy and size of the spot.
module contensou_contact_normal
   use contensou_base_kinds, only : wp
   use contensou_contact_catalogue, only : model_info_type
   use contensou_contact_hertz, only : hertz_circle_stiffness
   use contensou_contact_spot, only : circular_shape, spot_shape_type
   implicit none(type, external)
   private

   public :: normal_type, normal_models, new_normal

   !> Normal force of two surfaces whose relative curvatures do not change: everything but the
   !> approach is computed once, at set-up.
   type :: normal_type
      !> Stiffness k_n of N = k_n d^(3/2) [N/m^(3/2)].
      real(wp) :: stiffness = 0.0_wp
      !> a^2/d, the square of the major semi-axis over the approach [m].
      real(wp) :: axis_square = 0.0_wp
      !> Shape of the spot.
      type(spot_shape_type) :: shape = circular_shape
   contains
      !> Elastic force.
      procedure :: force
      !> Elastic energy.
      procedure :: energy
      !> Major semi-axis of the spot.
      procedure :: major_axis
   end type normal_type

contains

   !> Table of the normal models.
   pure function normal_models() result(models)
      type(model_info_type), allocatable :: models(:)

      allocate(models(1))
      models(1) = model_info_type("hertz", &
         "Hertz: N = (4/3) E* sqrt(R) d^(3/2), a = sqrt(R d), on a circular spot", &
         "young [Pa] and poisson of the two materials", &
         "H. Hertz, J. reine angew. Math. 92 (1881) 156")
   end function normal_models

   !> Hertz contact on a circular spot.
   pure function new_normal(modulus, curvature) result(self)
      !> Effective modulus E* [Pa], > 0.
      real(wp), intent(in) :: modulus
      !> Half relative curvature A = 1/(2R) [1/m], > 0.
      real(wp), intent(in) :: curvature
      type(normal_type) :: self
      real(wp) :: radius

      radius = 0.5_wp/curvature
      self%stiffness = hertz_circle_stiffness(modulus, radius)
      self%axis_square = radius
      self%shape = circular_shape
   end function new_normal

   !> Elastic force [N].
   pure function force(self, approach) result(f)
      !> The part.
      class(normal_type), intent(in) :: self
      !> Approach d [m], >= 0.
      real(wp), intent(in) :: approach
      real(wp) :: f

      f = self%stiffness*approach*sqrt(approach)
   end function force

   !> Elastic energy [J], (2/5) k_n d^(5/2).
   pure function energy(self, approach) result(e)
      !> The part.
      class(normal_type), intent(in) :: self
      !> Approach d [m], >= 0.
      real(wp), intent(in) :: approach
      real(wp) :: e

      e = 0.4_wp*self%stiffness*approach**2*sqrt(approach)
   end function energy

   !> Major semi-axis of the spot [m].
   pure function major_axis(self, approach) result(a)
      !> The part.
      class(normal_type), intent(in) :: self
      !> Approach d [m], >= 0.
      real(wp), intent(in) :: approach
      real(wp) :: a

      a = sqrt(self%axis_square*approach)
   end function major_axis

end module contensou_contact_normal
