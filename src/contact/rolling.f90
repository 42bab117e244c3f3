!> Rolling resistance: a torque in the tangent plane against the rolling of one surface on the
!> other.
!>
!> M = -e N w_t/max(|w_t|, w_0), with w_t the tangential part of the relative angular velocity and
!> w_0 a regularisation, below which the torque fades linearly to zero.
!> The lever arm e [m] is given (`constant`), or follows the spot (`hysteresis`): a fraction of the
!> elastic work of each pass is lost, e = loss (3/16) r with r the semi-axis in the direction of
!> rolling.
!>
!> Sources: K. L. Johnson, Contact Mechanics, 1985, sec. 9.3 (hysteresis); D. Tabor, Proc. R. Soc. A
!> 229 (1955) 198.
module contensou_contact_rolling
   use contensou_base_kinds, only : wp
   use contensou_base_vectors, only : cross
   use contensou_contact_catalogue, only : model_info_type
   implicit none(type, external)
   private

   public :: rolling_type, rolling_models, rolling_none, rolling_constant, rolling_hysteresis

   !> Models, in the order of `rolling_models`.
   integer, parameter :: rolling_none = 1, rolling_constant = 2, rolling_hysteresis = 3

   !> Lever arm over loss and semi-axis [-].
   real(wp), parameter :: johnson = 3.0_wp/16.0_wp

   !> Rolling resistance with its parameters.
   type :: rolling_type
      !> `rolling_constant` or `rolling_hysteresis`.
      integer :: model = rolling_constant
      !> Lever arm [m], or fraction of the elastic work that is lost [-].
      real(wp) :: coefficient = 0.0_wp
      !> Rolling velocity below which the torque fades [rad/s], > 0.
      real(wp) :: regularization = 0.0_wp
   contains
      procedure :: torque
   end type rolling_type

contains

   !> Table of the models.
   pure function rolling_models() result(models)
      type(model_info_type), allocatable :: models(:)
      character(len=*), parameter :: keys = ", rolling_regularization [rad/s]"

      allocate(models(3))
      models(rolling_none) = model_info_type("none", "no rolling resistance", "", "")
      models(rolling_constant) = model_info_type("constant", &
         "M = e N against the rolling, with a constant lever arm e", &
         "rolling_coefficient e [m]" // keys, "C. A. Coulomb, Theorie des machines simples, 1785")
      models(rolling_hysteresis) = model_info_type("hysteresis", &
         "M = (3/16) loss r N, r the semi-axis of the spot in the direction of rolling", &
         "rolling_coefficient loss [-]" // keys, &
         "K. L. Johnson, Contact Mechanics, 1985, sec. 9.3")
   end function rolling_models

   !> Torque on B [N m], in the tangent plane.
   pure function torque(self, load, normal, major, a, b, spin) result(moment)
      !> The part.
      class(rolling_type), intent(in) :: self
      !> Normal force N [N], >= 0.
      real(wp), intent(in) :: load
      !> Unit normal.
      real(wp), intent(in) :: normal(3)
      !> Unit tangent along the major axis of the spot.
      real(wp), intent(in) :: major(3)
      !> Major semi-axis [m].
      real(wp), intent(in) :: a
      !> Minor semi-axis [m].
      real(wp), intent(in) :: b
      !> Angular velocity of B against A [rad/s].
      real(wp), intent(in) :: spin(3)
      real(wp) :: moment(3)
      real(wp) :: x, y, speed, arm

      x = dot_product(spin, major)
      y = dot_product(spin, cross(normal, major))
      speed = sqrt(x*x + y*y)
      arm = self%coefficient
      if (self%model == rolling_hysteresis) then
         ! The direction of rolling is perpendicular to w_t: cos^2 = (y/speed)^2.
         if (speed > 0.0_wp) arm = arm*johnson*a*b*speed/sqrt((b*y)**2 + (a*x)**2)
      end if
      arm = -arm*load/max(speed, self%regularization)
      moment = arm*(spin - dot_product(spin, normal)*normal)
   end function torque

end module contensou_contact_rolling
