!> A Hertz spot as tangential elasticity sees it: shape and size, the limit of friction, stiffness.
module contensou_contact_tangential_spot
   use contensou_base_kinds, only : wp
   use contensou_contact_spot, only : spot_shape_type
   use contensou_contact_tangential_stiffness, only : tangential_stiffness
   use contensou_contact_wrench, only : wrench_jacobian_kernel
   implicit none(type, external)
   private

   public :: spring_spot_type

   !> A spot with its load and stiffness.
   type :: spring_spot_type
      type(spot_shape_type) :: shape
      !> Major semi-axis [m].
      real(wp) :: a
      !> Limit of the friction force, f N [N].
      real(wp) :: limit
      !> k_x, k_y [N/m] and k_T [N m] where nothing slips.
      real(wp) :: stiffness(3)
      !> Friction model whose limit it has; not associated for the exact wrench.
      procedure(wrench_jacobian_kernel), pointer, nopass :: rung => null()
   contains
      procedure :: stiffen
   end type spring_spot_type

   !> Makes a spot with the stiffness of its materials.
   interface spring_spot_type
      procedure :: stiff_spot
   end interface spring_spot_type

contains

   !> A spot with the stiffness of its materials.
   pure function stiff_spot(shape, a, limit, modulus, poisson) result(spot)
      type(spot_shape_type), intent(in) :: shape
      !> Major semi-axis [m], >= 0.
      real(wp), intent(in) :: a
      !> Limit of the friction force, f N [N], >= 0.
      real(wp), intent(in) :: limit
      !> Shear modulus G of both bodies together [Pa], >= 0.
      real(wp), intent(in) :: modulus
      !> Poisson's ratio of both together, from -1 to 1/2.
      real(wp), intent(in) :: poisson
      type(spring_spot_type) :: spot

      spot%shape = shape
      spot%a = a
      spot%limit = limit
      call spot%stiffen(modulus, poisson)
   end function stiff_spot

   !> Set the stiffness of a spot of known shape and size.
   pure subroutine stiffen(self, modulus, poisson)
      class(spring_spot_type), intent(inout) :: self
      !> Shear modulus G of both bodies together [Pa], >= 0.
      real(wp), intent(in) :: modulus
      !> Poisson's ratio of both together, from -1 to 1/2.
      real(wp), intent(in) :: poisson

      call tangential_stiffness(self%shape, self%a, modulus, poisson, self%stiffness)
   end subroutine stiffen

end module contensou_contact_tangential_spot
