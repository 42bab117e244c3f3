!> Texts about a scene that several sub-commands print.
module contensou_drivers_report
   use contensou_base_kinds, only : wp
   use contensou_base_text, only : number_text, quote, to_text
   use contensou_contact_damping, only : damping_model_type, damping_models
   use contensou_contact_catalogue, only : model_info_type
   use contensou_contact_friction, only : friction_model_type, friction_models
   use contensou_contact_hertz, only : hertz_model_type
   use contensou_contact_normal, only : normal_models, normal_vilke
   use contensou_contact_rolling, only : rolling_models, rolling_none
   use contensou_contact_vilke, only : vilke_models
   use contensou_dynamics_scene, only : body_spec_type, contact_spec_type, motion_fixed, &
      motion_free, motion_prescribed, motion_spindle, scene_type
   implicit none(type, external)
   private

   public :: bodies_text, body_effects, contact_effects

contains

   !> The effects that a contact pays for, separated by commas.
   function contact_effects(scene, contact) result(text)
      type(scene_type), intent(in) :: scene
      type(contact_spec_type), intent(in) :: contact
      character(len=:), allocatable :: text
      type(model_info_type), allocatable :: normal(:)
      type(damping_model_type), allocatable :: damping(:)
      type(friction_model_type), allocatable :: friction(:)
      type(hertz_model_type), allocatable :: vilke(:)
      type(model_info_type), allocatable :: rolling(:)

      normal = normal_models()
      damping = damping_models()
      friction = friction_models()
      associate (a => scene%surfaces(contact%surfaces(1))%surface, &
         b => scene%surfaces(contact%surfaces(2))%surface)
         text = a%label() // " on " // b%label() // ", " // &
            trim(normal(contact%normal)%name)
         if (contact%normal == normal_vilke) then
            vilke = vilke_models()
            text = text // " with the " // trim(vilke(contact%ellipse)%info%name) // " ellipse"
         end if
      end associate
      if (associated(damping(contact%damping)%kernel)) text = text // ", " // &
         trim(damping(contact%damping)%info%name)
      if (contact%rolling /= rolling_none) then
         rolling = rolling_models()
         text = text // ", rolling resistance " // trim(rolling(contact%rolling)%name)
      end if
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

   !> How many bodies a scene has, and how they move.
   function bodies_text(scene) result(text)
      type(scene_type), intent(in) :: scene
      character(len=:), allocatable :: text
      integer :: fixed, prescribed, spindle

      fixed = count(scene%bodies%motion == motion_fixed)
      prescribed = count(scene%bodies%motion == motion_prescribed)
      spindle = count(scene%bodies%motion == motion_spindle)
      text = to_text(size(scene%bodies)) // ", rigid"
      if (fixed + prescribed + spindle == 0) then
         text = text // " and free"
      else
         text = text // "; free " // to_text(count(scene%bodies%motion == motion_free))
         if (fixed > 0) text = text // ", fixed " // to_text(fixed)
         if (prescribed > 0) text = text // ", prescribed " // to_text(prescribed)
         if (spindle > 0) text = text // ", spindle " // to_text(spindle)
      end if
   end function bodies_text

   !> What drives or loads a body; blank for a free body without applied loads.
   function body_effects(body) result(text)
      type(body_spec_type), intent(in) :: body
      character(len=:), allocatable :: text

      text = ""
      select case (body%motion)
      case (motion_fixed)
         text = "fixed"
      case (motion_spindle)
         text = "prescribed rotation, free to move"
         if (body%ramp_duration > 0.0_wp) text = text // ", ramp of " // &
            number_text(body%ramp_duration, 4) // " s"
         if (any(abs(body%applied_force) > 0.0_wp)) text = text // ", applied force"
      case (motion_prescribed)
         text = "prescribed motion"
         if (body%ramp_duration > 0.0_wp) text = text // ", ramp of " // &
            number_text(body%ramp_duration, 4) // " s"
      case default
         if (any(abs(body%applied_force) > 0.0_wp)) text = "applied force"
         if (any(abs(body%applied_torque) > 0.0_wp)) then
            if (text /= "") text = text // ", "
            text = text // "applied torque"
         end if
         if (text /= "" .and. body%load_follows) text = text // ", turning with the body"
      end select
   end function body_effects

end module contensou_drivers_report
