!> Tangential part of a contact: what its models are made from, and their keys.
module contensou_contact_tangential_law
   use contensou_base_kinds, only : wp
   use contensou_base_numbers, only : to_text
   use contensou_base_schema, only : kind_choice, kind_integer
   use contensou_base_text, only : quote, string_type, strings
   use contensou_contact_catalogue, only : law_keys_type, model_info_type, model_type
   use contensou_contact_creep, only : creep_model_type, creep_models, creep_type, default_creep
   use contensou_contact_creep_steady, only : steady_type
   use contensou_contact_friction_ladder, only : rung_type
   use contensou_contact_friction_law, only : friction_type
   use contensou_contact_parameters, only : parameters_type, surroundings_type
   use contensou_contact_tangential_memory, only : put_carried_states, put_tangential_states, &
      tangential_type
   use contensou_contact_tangential_shells, only : default_layers, most_layers, shells_per_layer
   use contensou_contact_wrench, only : wrench_exact_jacobian
   implicit none(type, external)
   private

   public :: tangential_model_type, spring, elastic, rolling, creep_names, creep_key, join_materials

   !> Key that names the law of creep.
   character(len=*), parameter :: creep_key = "creep"

   !> A row in the table of the models of tangential elasticity.
   type, extends(model_type) :: tangential_model_type
      !> Whether one spring does for the whole spot.
      logical :: single = .false.
      !> Whether it is steady rolling, without memory.
      logical :: steady = .false.
   contains
      procedure :: create
      procedure :: create_steady
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
      model%put_more_states => put_carried_states
      model%more_with = creep_key
   end function elastic

   !> Row of steady rolling.
   function rolling() result(model)
      type(tangential_model_type) :: model

      model%info = model_info_type("rolling", &
         "what rolls sticks where it enters the spot: steady rolling by a law of creep", "", &
         "J. J. Kalker, Three-Dimensional Elastic Bodies in Rolling Contact, 1990")
      model%put_keys => put_rolling_keys
      model%steady = .true.
   end function rolling

   !> The keys of steady rolling.
   subroutine put_rolling_keys(list)
      type(law_keys_type), intent(inout) :: list

      call list%put(creep_key, kind_choice, "law of creep; " // quote(default_creep) // &
         " if not given", otherwise=default_creep, choices=creep_names)
   end subroutine put_rolling_keys

   !> Names of the laws of creep.
   function creep_names() result(names)
      type(string_type), allocatable :: names(:)
      type(creep_model_type), allocatable :: models(:)

      models = creep_models()
      names = strings(models%info%name)
   end function creep_names

   !> The keys of the nested shells.
   subroutine put_elastic_keys(list)
      type(law_keys_type), intent(inout) :: list

      call list%put("layers", kind_integer, "layers of the spot that slip one after the other", &
         unit="1", least=1.0_wp, most=real(most_layers, wp), default=to_text(default_layers))
      call list%put(creep_key, kind_choice, "law of creep that rolling tends to; not given, " // &
         "strain only fades", choices=creep_names)
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
      integer :: shells

      call join_materials(around, tangential%modulus, tangential%poisson)
      tangential%coefficient = friction%coefficient
      tangential%drilling = friction%drilling
      select type (friction)
      type is (rung_type)
         ! The exact wrench has a potential, and cases of its own.
         if (.not. associated(friction%jacobian, wrench_exact_jacobian)) tangential%spot%rung => &
            friction%jacobian
      end select
      shells = 1
      if (.not. self%single) shells = shells_per_layer*nint(parameters%number("layers", &
         real(default_layers, wp)))
      call tangential%begin(shells)
      if (self%single .or. .not. parameters%has(creep_key)) return
      allocate(tangential%carry)
      call create_creep(parameters, tangential%carry%creep)
      call tangential%carry%begin(friction%coefficient, tangential%modulus, tangential%poisson)
   end subroutine create

   !> The law of creep that is named, or the one that is meant where none is.
   subroutine create_creep(parameters, creep)
      type(parameters_type), intent(in) :: parameters
      class(creep_type), allocatable, intent(out) :: creep
      type(creep_model_type), allocatable :: models(:)
      integer :: law

      models = creep_models()
      law = findloc(models%info%name == default_creep, .true., dim=1)
      if (parameters%has(creep_key)) law = nint(parameters%number(creep_key))
      call models(law)%create(models(law)%completed(parameters), creep)
   end subroutine create_creep

   !> Steady rolling with the values of its keys.
   subroutine create_steady(self, parameters, around, friction, steady)
      class(tangential_model_type), intent(in) :: self
      !> Values of its keys, complete.
      type(parameters_type), intent(in) :: parameters
      !> What the contact is between.
      type(surroundings_type), intent(in) :: around
      !> Friction of the contact.
      class(friction_type), intent(in) :: friction
      type(steady_type), intent(out) :: steady
      real(wp) :: modulus, poisson

      call create_creep(parameters, steady%creep)
      call join_materials(around, modulus, poisson)
      call steady%begin(friction%coefficient, modulus, poisson)
   end subroutine create_steady

   !> Shear modulus and Poisson's ratio of both bodies together: 1/G = (1/G1 + 1/G2)/2,
   !> nu/G = (nu1/G1 + nu2/G2)/2.
   pure subroutine join_materials(around, modulus, poisson)
      type(surroundings_type), intent(in) :: around
      !> [Pa].
      real(wp), intent(out) :: modulus
      real(wp), intent(out) :: poisson
      real(wp) :: shear(2)

      shear = 0.5_wp*around%young/(1.0_wp + around%poisson)
      modulus = 2.0_wp/sum(1.0_wp/shear)
      poisson = 0.5_wp*modulus*sum(around%poisson/shear)
   end subroutine join_materials

end module contensou_contact_tangential_law
