!> Texts about a scene that several sub-commands print.
module contensou_drivers_report
   use contensou_base_kinds, only : wp
   use contensou_base_numbers, only : number_text, to_text
   use contensou_base_text, only : quote
   use contensou_contact_parts, only : contact_parts, n_parts, part_type
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
      type(part_type), allocatable :: parts(:)
      integer :: i, choice(n_parts)

      parts = contact_parts()
      choice = [contact%normal, contact%damping, contact%friction, contact%rolling]
      associate (a => scene%surfaces(contact%surfaces(1))%surface, &
         b => scene%surfaces(contact%surfaces(2))%surface)
         text = a%label() // " on " // b%label()
      end associate
      do i = 1, n_parts
         text = text // parts(i)%words(choice(i), contact%parameters)
      end do
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
