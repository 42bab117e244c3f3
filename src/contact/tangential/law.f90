!> Tangential part of a contact: what its models are made from, and their keys.
module contensou_contact_tangential_law
   use contensou_base_kinds, only : wp
   use contensou_base_numbers, only : to_text
   use contensou_base_schema, only : kind_integer
   use contensou_contact_catalogue, only : law_keys_type, model_info_type, model_type
   use contensou_contact_friction_law, only : friction_type
   use contensou_contact_parameters, only : parameters_type, surroundings_type
   use contensou_contact_tangential_memory, only : put_tangential_states, tangential_type
   use contensou_contact_tangential_shells, only : default_layers, most_layers, shells_per_layer
   implicit none(type, external)
   private

   public :: tangential_model_type, spring, elastic

   !> A row in the table of the models of tangential elasticity.
   type, extends(model_type) :: tangential_model_type
      !> Whether one spring does for the whole spot.
      logical :: single = .false.
   contains
      procedure :: create
   end type tangential_model_type

contains

   !> Row of the single spring.
   function spring() result(model)
      type(tangential_model_type) :: model

      model%info = model_info_type("spring", &
         "one spring with the stiffness of the spot, |F| <= f N, as granular codes have it", &
         "", "R. D. Mindlin, J. Appl. Mech. 16 (1949) 259")
      model%put_states => put_tangential_states
      model%single = .true.
   end function spring

   !> Row of the nested shells.
   function elastic() result(model)
      type(tangential_model_type) :: model

      model%info = model_info_type("elastic", &
         "nested shells that shear and twist elastically, slip from the rim inwards and remember", &
         "", &
         "J. Jaeger, Arch. Appl. Mech. 65 (1995) 478; J. Lubkin, J. Appl. Mech. 18 (1951) 183")
      model%put_keys => put_elastic_keys
      model%put_states => put_tangential_states
   end function elastic

   !> The keys of the nested shells.
   subroutine put_elastic_keys(list)
      type(law_keys_type), intent(inout) :: list

      call list%put("layers", kind_integer, "layers of the spot that slip one after the other", &
         unit="1", least=1.0_wp, most=real(most_layers, wp), default=to_text(default_layers))
   end subroutine put_elastic_keys

   !> Tangential elasticity with the values of its keys.
   subroutine create(self, parameters, around, friction, tangential)
      class(tangential_model_type), intent(in) :: self
      !> Values of its keys, complete.
      type(parameters_type), intent(in) :: parameters
      !> What the contact is between.
      type(surroundings_type), intent(in) :: around
      !> Friction of the contact.
      class(friction_type), intent(in) :: friction
      type(tangential_type), intent(out) :: tangential
      real(wp) :: shear(2)
      integer :: shells

      shear = 0.5_wp*around%young/(1.0_wp + around%poisson)
      tangential%modulus = 2.0_wp/sum(1.0_wp/shear)
      tangential%poisson = 0.5_wp*tangential%modulus*sum(around%poisson/shear)
      tangential%coefficient = friction%coefficient
      shells = 1
      if (.not. self%single) shells = shells_per_layer*nint(parameters%number("layers", &
         real(default_layers, wp)))
      call tangential%begin(shells)
   end subroutine create

end module contensou_contact_tangential_law
