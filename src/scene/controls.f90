!> Reads the groups that say what is done with a scene: `scene`, `integrator`, `output`.
module contensou_scene_controls
   use contensou_base_diagnostics, only : diagnostics_type
   use contensou_base_kinds, only : wp
   use contensou_base_numbers, only : to_text
   use contensou_base_settings, only : group_settings_type
   use contensou_base_text, only : quote
   use contensou_dynamics_scene, only : impacts_together, integrator_spec_type, scene_type
   implicit none(type, external)
   private

   public :: build_scene, build_integrator, build_output

contains

   !> Values of the group `scene`.
   subroutine build_scene(group, scene)
      type(group_settings_type), intent(in) :: group
      type(scene_type), intent(inout) :: scene

      scene%title = group%text("title")
      scene%gravity = group%numbers("gravity")
      scene%t_end = group%number("t_end")
      scene%together = group%text("impacts") == impacts_together
   end subroutine build_scene

   !> Values of the group `integrator`.
   subroutine build_integrator(group, integrator)
      type(group_settings_type), intent(in) :: group
      type(integrator_spec_type), intent(inout) :: integrator

      integrator%method = group%text("method")
      integrator%differences = group%text("jacobian") == "differences"
      integrator%jacobian_steps = group%integer("jacobian_steps")
      integrator%rtol = group%number("rtol")
      integrator%length_scale = group%number("length_scale")
      integrator%velocity_scale = group%number("velocity_scale")
      integrator%angular_velocity_scale = group%number("angular_velocity_scale")
      integrator%max_step = group%number("max_step")
   end subroutine build_integrator

   !> Values of the group `output`.
   subroutine build_output(group, path, output_file, scene)
      type(group_settings_type), intent(in) :: group
      !> Name of the scene file.
      character(len=*), intent(in) :: path
      !> Name of the output file from the command line; blank for that of the scene.
      character(len=*), intent(in) :: output_file
      type(scene_type), intent(inout) :: scene
      integer :: slash, dot

      if (output_file /= "") then
         call group%derive_text("file", output_file)
      else if (.not. group%is_given("file")) then
         slash = index(path, "/", back=.true.)
         dot = index(path, ".", back=.true.)
         if (dot <= slash + 1) dot = len(path) + 1
         call group%derive_text("file", path(slash + 1:dot - 1) // ".h5")
      end if
      scene%output%file = group%text("file")
      scene%output%interval = group%number("interval")
      scene%output%contact_geometry = .true.
      if (group%is_given("contact_geometry")) scene%output%contact_geometry = &
         group%flag("contact_geometry")
      if (group%is_given("rolling")) scene%output%rolling = group%flag("rolling")
   end subroutine build_output

end module contensou_scene_controls
