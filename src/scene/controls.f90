!> Reads the groups that say what is done with a scene: `scene`, `integrator`, `output`, `cost`.
module contensou_scene_controls
   use contensou_base_diagnostics, only : diagnostics_type
   use contensou_base_kinds, only : wp
   use contensou_base_settings, only : group_settings_type
   use contensou_base_text, only : quote, to_text
   use contensou_dynamics_scene, only : cost_spec_type, integrator_spec_type, scene_type
   implicit none(type, external)
   private

   public :: build_scene, build_integrator, build_output, build_cost

contains

   !> Values of the group `scene`.
   subroutine build_scene(group, scene)
      type(group_settings_type), intent(in) :: group
      type(scene_type), intent(inout) :: scene

      scene%title = group%text("title")
      scene%gravity = group%numbers("gravity")
      scene%t_end = group%number("t_end")
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
   end subroutine build_output

   !> Values of the group `cost`.
   subroutine build_cost(group, cost, diagnostics)
      type(group_settings_type), intent(in) :: group
      type(cost_spec_type), intent(inout) :: cost
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i

      cost%friction = choices("friction")
      cost%normal = choices("normal")
      allocate(cost%methods(group%count("methods")))
      do i = 1, size(cost%methods)
         if (group%is_set("methods")) cost%methods(i) = group%text("methods", i)
      end do
      call refuse_doubles("methods", group%choices("methods"))
      call refuse_doubles("friction", cost%friction)
      call refuse_doubles("normal", cost%normal)
      cost%rtol = group%vector("rtol", group%count("rtol"))
      cost%counts(choices("quantities")) = .true.
      cost%reference_rtol = group%number("reference_rtol")
      if (group%is_set("rtol") .and. cost%reference_rtol >= minval(cost%rtol)) call &
         diagnostics%add(group%place("reference_rtol", 1), &
         "the reference is not tighter than what it is compared with", &
         "reference_rtol < " // to_text(minval(cost%rtol)) // ", the smallest of rtol")
      cost%measure = max(1, group%choice("measure"))
      cost%samples = group%integer("samples")
      cost%repeats = group%integer("repeats")
      cost%cpu_limit = group%number("cpu_limit")

   contains

      !> Positions of the choices of a key; none if it has no usable value.
      function choices(name) result(list)
         character(len=*), intent(in) :: name
         integer, allocatable :: list(:)

         allocate(list(0))
         if (group%is_set(name)) list = group%choices(name)
      end function choices

      !> Nothing is compared with itself.
      subroutine refuse_doubles(name, list)
         character(len=*), intent(in) :: name
         !> Its choices; 0 after a mistake.
         integer, intent(in) :: list(:)
         integer :: j

         do j = 2, size(list)
            if (list(j) > 0 .and. any(list(:j - 1) == list(j))) call diagnostics%add( &
               group%place(name, j), quote(group%text(name, j)) // " stands twice in '" // name // &
               "'", "each choice once")
         end do
      end subroutine refuse_doubles

   end subroutine build_cost

end module contensou_scene_controls
