!> Rolling resistance by a lever arm of the normal force:
!> M = -e N w_t/max(|w_t|, w_0), with w_t the tangential part of the relative angular velocity and
!> w_0 a regularisation, below which the torque fades linearly to zero.
!> The lever arm e [m] is given (`constant`), or follows the spot (`hysteresis`): a fraction of the
!> elastic work of each pass is lost. With x along the major axis the pressure p does work on the
!> leading half of the spot, w_x y - w_y x > 0, at the rate
!>    int p (w_x y - w_y x) dx dy = (3/16) N sqrt((a w_y)^2 + (b w_x)^2),
!> so that e = (3/16) loss r with r = sqrt((a w_y)^2 + (b w_x)^2)/|w_t|; along an axis of the spot r
!> is the semi-axis in the direction of rolling.
!>
!> Sources: K. L. Johnson, Contact Mechanics, 1985, sec. 9.3 (hysteresis); D. Tabor, Proc. R. Soc. A
!> 229 (1955) 198.
module contensou_contact_rolling_lever
   use contensou_base_kinds, only : wp
   use contensou_base_schema, only : kind_real
   use contensou_base_vectors, only : cross
   use contensou_contact_catalogue, only : law_keys_type, model_info_type
   use contensou_contact_parameters, only : parameters_type, surroundings_type
   use contensou_contact_rolling_law, only : rolling_model_type, rolling_type
   implicit none(type, external)
   private

   public :: lever_type, constant, hysteresis

   !> Lever arm over loss and semi-axis [-].
   real(wp), parameter :: johnson = 3.0_wp/16.0_wp

   !> Rolling resistance by a lever arm.
   type, extends(rolling_type) :: lever_type
      !> Lever arm [m], or fraction of the elastic work that is lost [-].
      real(wp) :: coefficient = 0.0_wp
   contains
      procedure :: torque
   end type lever_type

contains

   !> Row of the constant lever arm.
   function constant() result(model)
      type(rolling_model_type) :: model

      model%info = model_info_type("constant", &
         "M = e N against the rolling, with a constant lever arm e", "", &
         "C. A. Coulomb, Theorie des machines simples, 1785")
      model%put_keys => put_constant_keys
      model%create => new_constant
   end function constant

   !> Row of the lever arm that follows the spot.
   function hysteresis() result(model)
      type(rolling_model_type) :: model

      model%info = model_info_type("hysteresis", &
         "M = (3/16) loss r N, r = sqrt((a w_y)^2 + (b w_x)^2)/|w|, a and b the semi-axes", "", &
         "K. L. Johnson, Contact Mechanics, 1985, sec. 9.3")
      model%put_keys => put_hysteresis_keys
      model%create => new_hysteresis
   end function hysteresis

   !> The keys of the constant lever arm.
   subroutine put_constant_keys(list)
      type(law_keys_type), intent(inout) :: list

      call list%put("rolling_coefficient", kind_real, "lever arm of the normal force", &
         symbol="e", unit="m", least=0.0_wp, mandatory=.true.)
      call put_regularization(list)
   end subroutine put_constant_keys

   !> The keys of the lever arm that follows the spot.
   subroutine put_hysteresis_keys(list)
      type(law_keys_type), intent(inout) :: list

      call list%put("rolling_coefficient", kind_real, "share of the elastic work that is lost", &
         symbol="loss", unit="1", least=0.0_wp, mandatory=.true.)
      call put_regularization(list)
   end subroutine put_hysteresis_keys

   !> The key rolling_regularization.
   subroutine put_regularization(list)
      type(law_keys_type), intent(inout) :: list

      call list%put("rolling_regularization", kind_real, "rolling velocity below which the " // &
         "rolling resistance falls to zero linearly", unit="rad s-1", above=0.0_wp, &
         mandatory=.true.)
   end subroutine put_regularization

   !> A constant lever arm.
   subroutine new_constant(self, parameters, around, rolling)
      class(rolling_model_type), intent(in) :: self
      type(parameters_type), intent(in) :: parameters
      type(surroundings_type), intent(in) :: around
      class(rolling_type), allocatable, intent(out) :: rolling

      allocate(rolling, source=new_lever(parameters, .false.))
   end subroutine new_constant

   !> A lever arm that follows the spot.
   subroutine new_hysteresis(self, parameters, around, rolling)
      class(rolling_model_type), intent(in) :: self
      type(parameters_type), intent(in) :: parameters
      type(surroundings_type), intent(in) :: around
      class(rolling_type), allocatable, intent(out) :: rolling

      allocate(rolling, source=new_lever(parameters, .true.))
   end subroutine new_hysteresis

   !> A lever arm.
   pure function new_lever(parameters, follows_spot) result(law)
      type(parameters_type), intent(in) :: parameters
      logical, intent(in) :: follows_spot
      type(lever_type) :: law

      law%coefficient = parameters%number("rolling_coefficient")
      law%regularization = parameters%number("rolling_regularization")
      law%follows_spot = follows_spot
   end function new_lever

   !> Torque on B [N m], in the tangent plane.
   pure function torque(self, load, normal, major, a, b, spin) result(moment)
      class(lever_type), intent(in) :: self
      real(wp), intent(in) :: load, normal(3), major(3), a, b, spin(3)
      real(wp) :: moment(3)
      real(wp) :: x, y, speed, arm

      x = dot_product(spin, major)
      y = dot_product(spin, cross(normal, major))
      speed = sqrt(x*x + y*y)
      arm = self%coefficient
      if (self%follows_spot) then
         if (speed > 0.0_wp) arm = arm*johnson*sqrt((a*y)**2 + (b*x)**2)/speed
      end if
      arm = -arm*load/max(speed, self%regularization)
      moment = arm*(spin - dot_product(spin, normal)*normal)
   end function torque

end module contensou_contact_rolling_lever
