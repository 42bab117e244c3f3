!> Rolling part of a contact: a torque in the tangent plane against the rolling of one surface on
!> the other, and what each law of it must answer.
module contensou_contact_rolling_law
   use contensou_base_kinds, only : wp
   use contensou_contact_catalogue, only : model_type
   use contensou_contact_parameters, only : parameters_type, surroundings_type
   implicit none(type, external)
   private

   public :: rolling_type, rolling_model_type

   !> Rolling resistance with its parameters.
   type, abstract :: rolling_type
      !> Rolling velocity below which the torque fades [rad/s], > 0.
      real(wp) :: regularization = 0.0_wp
      !> Whether the torque depends on the size of the spot.
      logical :: follows_spot = .false.
   contains
      procedure(torque_of), deferred :: torque
   end type rolling_type

   !> A row in the table of the laws of rolling resistance.
   type, extends(model_type) :: rolling_model_type
      !> Makes the law from the values of its keys; not associated for `none`.
      procedure(new_rolling), pointer :: create => null()
   end type rolling_model_type

   abstract interface
      !> Torque on B [N m], in the tangent plane; proportional to the load where it does not follow
      !> the spot.
      pure function torque_of(self, load, normal, major, a, b, spin) result(moment)
         import :: rolling_type, wp
         implicit none(type, external)
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
      end function torque_of

      !> Make a law of rolling resistance.
      subroutine new_rolling(self, parameters, around, rolling)
         import :: parameters_type, rolling_model_type, rolling_type, surroundings_type
         implicit none(type, external)
         class(rolling_model_type), intent(in) :: self
         !> Values of its keys.
         type(parameters_type), intent(in) :: parameters
         !> What the contact is between.
         type(surroundings_type), intent(in) :: around
         class(rolling_type), allocatable, intent(out) :: rolling
      end subroutine new_rolling
   end interface

end module contensou_contact_rolling_law
