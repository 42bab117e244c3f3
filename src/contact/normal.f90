!> Table of the models of the normal force.
module contensou_contact_normal
   use contensou_base_kinds, only : wp
   use contensou_base_schema, only : kind_choice, kind_real
   use contensou_base_text, only : string_type, strings
   use contensou_contact_catalogue, only : law_keys_type, model_info_type
   use contensou_contact_hertz, only : hertz_model_type
   use contensou_contact_normal_law, only : new_normal, normal_model_type, normal_type
   use contensou_contact_parameters, only : parameters_type, surroundings_type
   use contensou_contact_vilke, only : vilke_models, vilke_power_index
   implicit none(type, external)
   private

   public :: normal_type, normal_model_type, normal_models, normal_hertz, normal_vilke, normal_rigid

   !> Models of the normal force, in the order of `normal_models`.
   integer, parameter :: normal_hertz = 1, normal_vilke = 2, normal_rigid = 3

contains

   !> The models, in the order in which they are listed.
   function normal_models() result(models)
      type(normal_model_type), allocatable :: models(:)

      models = [hertz(), &
         vilke(), &
         rigid()]
   end function normal_models

   !> Row of Hertz's force.
   function hertz() result(model)
      type(normal_model_type) :: model

      model%info = model_info_type("hertz", &
         "Hertz: N = k_n d^(3/2), on a circle (4/3) E* sqrt(R) d^(3/2) with a = sqrt(R d)", &
         "young [Pa] and poisson of the two materials", &
         "H. Hertz, J. reine angew. Math. 92 (1881) 156")
      model%create => new_hertz
   end function hertz

   !> Row of Vil'ke's force.
   function vilke() result(model)
      type(normal_model_type) :: model

      model%info = model_info_type("vilke", &
         "Vil'ke's volumetric force: N = (4/3) E* sqrt(R_e) d^(3/2), R_e = 1/(2 sqrt(A B))", &
         "young [Pa] and poisson of the two materials", &
         "Kosenko and Aleksandrov, 7th Modelica Conference (2009) 288; force reconstructed")
      model%put_keys => put_vilke_keys
      model%create => new_vilke
   end function vilke

   !> Row of the contact without compliance.
   function rigid() result(model)
      type(normal_model_type) :: model

      model%info = model_info_type("rigid", &
         "no compliance: N from the equations of motion, spot of Hertz at N, impacts with " // &
         "restitution e", &
         "young [Pa] and poisson (spot), damping (hunt_crossley only)", &
         "J. Baumgarte, CMAME 1 (1972) 1; W. J. Stronge, Impact Mechanics, 2000")
      model%put_keys => put_rigid_keys
      model%create => new_hertz
      model%rigid = .true.
   end function rigid

   !> The keys of Vil'ke's force.
   subroutine put_vilke_keys(list)
      type(law_keys_type), intent(inout) :: list

      call list%put("ellipse", kind_choice, "formula for the spot; 'power' if not given", &
         otherwise="power", choices=ellipse_names)
   end subroutine put_vilke_keys

   !> The keys of a contact without compliance.
   subroutine put_rigid_keys(list)
      type(law_keys_type), intent(inout) :: list

      call list%put("restitution", kind_real, "coefficient of restitution (1 if not given)", &
         unit="1", symbol="e", otherwise="1", least=0.0_wp, most=1.0_wp)
   end subroutine put_rigid_keys

   !> Names of the formulas for the spot.
   function ellipse_names() result(names)
      type(string_type), allocatable :: names(:)
      type(hertz_model_type), allocatable :: models(:)

      models = vilke_models()
      names = strings(models%info%name)
   end function ellipse_names

   !> Hertz's force.
   subroutine new_hertz(parameters, around, normal)
      type(parameters_type), intent(in) :: parameters
      type(surroundings_type), intent(in) :: around
      type(normal_type), intent(out) :: normal

      normal = new_normal(around%modulus, around%curvatures(1), around%curvatures(2), &
         with_shape=around%with_shape)
   end subroutine new_hertz

   !> Vil'ke's force.
   subroutine new_vilke(parameters, around, normal)
      type(parameters_type), intent(in) :: parameters
      type(surroundings_type), intent(in) :: around
      type(normal_type), intent(out) :: normal
      type(hertz_model_type), allocatable :: models(:)
      integer :: ellipse

      models = vilke_models()
      ellipse = nint(parameters%number("ellipse", otherwise=real(vilke_power_index, wp)))
      normal = new_normal(around%modulus, around%curvatures(1), around%curvatures(2), &
         models(ellipse)%kernel, volumetric=.true., with_shape=around%with_shape)
   end subroutine new_vilke

end module contensou_contact_normal
