!> Reads groups `contact`.
module contensou_scene_contacts
   use contensou_base_diagnostics, only : diagnostics_type
   use contensou_base_settings, only : group_settings_type
   use contensou_base_text, only : quote
   use contensou_contact_damping, only : damping_model_type, damping_models
   use contensou_contact_normal, only : normal_rigid
   use contensou_contact_parts, only : n_parts, part_type, read_models
   use contensou_dynamics_scene, only : contact_spec_type
   use contensou_scene_references, only : references_type
   implicit none(type, external)
   private

   public :: build_contact

contains

   !> Read a contact.
   subroutine build_contact(group, references, parts, contact, diagnostics)
      type(group_settings_type), intent(in) :: group
      !> Names of the scene.
      type(references_type), intent(in) :: references
      !> The parts of a contact.
      type(part_type), intent(in) :: parts(:)
      type(contact_spec_type), intent(inout) :: contact
      type(diagnostics_type), intent(inout) :: diagnostics
      type(damping_model_type), allocatable :: dampings(:)
      integer :: choice(n_parts)

      contact%name = group%label()
      call references%find(group, "surfaces", 1, contact%surfaces(1), diagnostics)
      call references%find(group, "surfaces", 2, contact%surfaces(2), diagnostics)
      call read_models(group, parts, choice, contact%parameters, diagnostics)
      contact%normal = choice(1)
      contact%damping = choice(2)
      contact%friction = choice(3)
      contact%rolling = choice(4)
      if (contact%normal /= normal_rigid) return
      dampings = damping_models()
      associate (damping => dampings(contact%damping))
         if (.not. associated(damping%restitute)) call diagnostics%add( &
            group%place("damping", 1), "damping " // quote(trim(damping%info%name)) // &
            " has no meaning for a rigid contact", &
            "restitution without damping, or damping = 'hunt_crossley'")
      end associate
   end subroutine build_contact

end module contensou_scene_contacts
