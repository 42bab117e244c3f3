!> Normal part of a contact: elastic force, elastic energy and spot.
module contensou_contact_normal
   use contensou_base_kinds, only : wp
   use contensou_contact_catalogue, only : model_info_type
   use contensou_contact_hertz, only : hertz_type, new_hertz
   use contensou_contact_spot, only : circular_shape, elliptic_shape_of_c1, spot_shape_type
   implicit none(type, external)
   private

   public :: normal_type, normal_models, new_normal

   !> Normal force of two surfaces whose relative curvatures do not change: everything but the
   !> approach is computed once, at set-up.
   type, extends(hertz_type) :: normal_type
      !> Shape of the spot.
      type(spot_shape_type) :: shape = circular_shape
   contains
      !> Major semi-axis of the spot.
      procedure :: major_axis
   end type normal_type

contains

   !> Table of the normal models.
   pure function normal_models() result(models)
      type(model_info_type), allocatable :: models(:)

      allocate(models(1))
      models(1) = model_info_type("hertz", &
         "Hertz: N = k_n d^(3/2), on a circle (4/3) E* sqrt(R) d^(3/2) with a = sqrt(R d)", &
         "young [Pa] and poisson of the two materials", &
         "H. Hertz, J. reine angew. Math. 92 (1881) 156")
   end function normal_models

   !> Hertz contact of given curvatures.
   pure function new_normal(modulus, curvature_a, curvature_b) result(self)
      !> Effective modulus E* [Pa], > 0.
      real(wp), intent(in) :: modulus
      !> Half relative curvature A along the major axis [1/m], > 0.
      real(wp), intent(in) :: curvature_a
      !> Half relative curvature B along the minor axis [1/m], >= A.
      real(wp), intent(in) :: curvature_b
      type(normal_type) :: self

      self%hertz_type = new_hertz(curvature_a, curvature_b, modulus)
      if (curvature_a < curvature_b) self%shape = elliptic_shape_of_c1(self%c1)
   end function new_normal

   !> Major semi-axis of the spot [m].
   pure function major_axis(self, approach) result(a)
      !> The part.
      class(normal_type), intent(in) :: self
      !> Approach d [m], >= 0.
      real(wp), intent(in) :: approach
      real(wp) :: a

      a = self%axis_a*sqrt(approach)
   end function major_axis

end module contensou_contact_normal
