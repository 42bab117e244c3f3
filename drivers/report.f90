!> Texts about a scene that several sub-commands print.
module contensou_drivers_report
   use contensou_base_kinds, only : wp
   use contensou_contact_damping, only : damping_model_type, damping_models
   use contensou_contact_catalogue, only : model_info_type
   use contensou_contact_friction, only : friction_model_type, friction_models
   use contensou_contact_surface, only : shape_names
   use contensou_contact_normal, only : normal_models
   use contensou_dynamics_scene, only : contact_spec_type, scene_type
   implicit none(type, external)
   private

   public :: contact_effects, number_text

contains

   !> The effects that a contact pays for, separated by commas.
   function contact_effects(scene, contact) result(text)
      !> The scene.
      type(scene_type), intent(in) :: scene
      !> The contact.
      type(contact_spec_type), intent(in) :: contact
      character(len=:), allocatable :: text
      type(model_info_type), allocatable :: normal(:)
      type(damping_model_type), allocatable :: damping(:)
      type(friction_model_type), allocatable :: friction(:)

      normal = normal_models()
      damping = damping_models()
      friction = friction_models()
      associate (a => scene%surfaces(contact%surfaces(1))%surface, &
         b => scene%surfaces(contact%surfaces(2))%surface)
         text = trim(shape_names(a%shape)) // " on " // trim(shape_names(b%shape)) // ", " // &
            trim(normal(contact%normal)%name)
      end associate
      if (associated(damping(contact%damping)%kernel)) text = text // ", " // &
         trim(damping(contact%damping)%info%name)
      if (.not. associated(friction(contact%friction)%kernel)) return
      text = text // ", " // trim(friction(contact%friction)%info%name)
      if (friction(contact%friction)%has_torque) then
         if (contact%drilling) then
            text = text // " with drilling torque"
         else
            text = text // " without drilling torque"
         end if
      end if
      if (contact%regularization_velocity > 0.0_wp) text = text // ", regularised"
   end function contact_effects

   !> A number with a given count of significant digits, without superfluous blanks.
   pure function number_text(x, digits) result(text)
      !> The number.
      real(wp), intent(in) :: x
      !> Significant digits, 1 to 17.
      integer, intent(in) :: digits
      character(len=:), allocatable :: text
      character(len=32) :: buffer, form
      integer :: before

      before = 0
      if (abs(x) > 0.0_wp) before = floor(log10(abs(x))) + 1
      if (before < -2 .or. before > 6) then
         write(form, "('(es32.', i0, ')')") max(digits - 1, 1)
      else
         write(form, "('(f32.', i0, ')')") max(digits - before, 0)
      end if
      write(buffer, form) x
      text = trim(adjustl(buffer))
      if (text(len(text):) == ".") text = text(:len(text) - 1)
   end function number_text

end module contensou_drivers_report
