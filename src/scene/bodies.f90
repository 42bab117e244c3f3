!> Reads groups `body`: how a body moves, where it begins, and what is applied to it.
module contensou_scene_bodies
   use contensou_base_attitude, only : read_attitude
   use contensou_base_diagnostics, only : diagnostics_type
   use contensou_base_kinds, only : wp
   use contensou_base_numbers, only : to_text
   use contensou_base_rotations, only : rotation_matrix
   use contensou_base_schema, only : domain_text
   use contensou_base_settings, only : group_settings_type
   use contensou_base_text, only : quote
   use contensou_dynamics_scene, only : body_spec_type, frame_names, motion_fixed, motion_free, &
      motion_names, motion_prescribed, motion_rotor, moves_freely, turns_by_drive
   use contensou_scene_repeats, only : repeat_keys
   use contensou_scene_solids, only : is_solid
   implicit none(type, external)
   private

   public :: build_body

contains

   !> Read a body.
   subroutine build_body(group, body, diagnostics)
      type(group_settings_type), intent(in) :: group
      type(body_spec_type), intent(inout) :: body
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i, largest

      body%name = group%label()
      ! Of bodies with a count each is one without it here.
      do i = 1, size(repeat_keys)
         if (.not. group%is_given("count")) call group%refuse(trim(repeat_keys(i)), "'" // &
            trim(repeat_keys(i)) // "' without 'count'", "count = how many bodies there are", &
            diagnostics)
      end do
      body%mass = group%number("mass")
      body%inertia = group%numbers("inertia")
      body%position = group%numbers("position")
      body%velocity = group%numbers("velocity")
      ! A thin disc is allowed to miss equality by rounding.
      if (group%is_set("inertia") .and. &
         2.0_wp*maxval(body%inertia) > sum(body%inertia)*(1.0_wp + 1.0e-12_wp)) then
         largest = maxloc(body%inertia, dim=1)
         call diagnostics%add(group%place("inertia", largest), &
            "the inertia of " // quote(body%name) // " violates the triangle inequality", &
            "no principal moment larger than the sum of the other two, here at most " // &
            to_text(sum(body%inertia, mask=[1, 2, 3] /= largest)))
      end if
      call read_attitude(group, body%quaternion, diagnostics)
      if (group%is_given("spin")) call group%refuse("angular_velocity", &
         "the angular velocity is given twice", &
         "either spin (body axes) or angular_velocity (inertial frame)", diagnostics)
      body%spin = group%numbers("spin")
      if (group%is_set("angular_velocity")) then
         body%spin = matmul(group%numbers("angular_velocity"), rotation_matrix(body%quaternion))
         ! The default of the other is not in force; the resolved text would have both.
         call group%unset("spin")
      end if
      body%motion = max(group%choice("motion"), 1)
      call check_motion(group, body, diagnostics)
      call build_drive(group, body, diagnostics)
      body%held_along = group%numbers("held_along")
      if (norm2(body%held_along) > 0.0_wp) body%held_along = body%held_along/norm2(body%held_along)
      body%applied_force = group%numbers("applied_force")
      body%applied_torque = group%numbers("applied_torque")
      body%load_follows = .false.
      if (group%choice("applied_frame") > 0) then
         body%load_follows = frame_names(group%choice("applied_frame")) == "body"
      end if
   end subroutine build_body

   !> Keys that the motion of a body has no use for, and those that it needs.
   subroutine check_motion(group, body, diagnostics)
      type(group_settings_type), intent(in) :: group
      !> The body; its motion is set.
      type(body_spec_type), intent(in) :: body
      type(diagnostics_type), intent(inout) :: diagnostics
      character(len=*), parameter :: no_load = &
         "no applied load: nothing can move this body otherwise"

      if (body%motion /= motion_prescribed) call refuse("final_velocity", &
         "motion = 'prescribed', or no final_velocity")
      if (.not. turns_by_drive(body%motion)) then
         call refuse("final_angular_velocity", &
            "motion = 'prescribed', or no final_angular_velocity")
         call refuse("ramp_duration", "motion = 'prescribed', or no ramp_duration")
      end if
      if (.not. moves_freely(body%motion)) then
         call refuse("applied_force", no_load)
         call refuse("applied_frame", no_load)
      end if
      if (all(body%motion /= [motion_free, motion_rotor])) call refuse("applied_torque", no_load)
      if (.not. moves_freely(body%motion)) call refuse("held_along", "no held_along: nothing " // &
         "moves this body otherwise")
      if (body%motion == motion_rotor) call check_rotor()
      if (body%motion == motion_fixed) then
         call refuse_motion("velocity")
         call refuse_motion("spin")
         call refuse_motion("angular_velocity")
      end if
      if (group%is_given("density")) return
      if (body%motion == motion_free .or. moves_freely(body%motion)) call need("mass")
      ! The inertia of a body that a drive turns has no say.
      if (any(body%motion == [motion_free, motion_rotor]) .and. .not. is_solid(group)) call &
         need("inertia")

   contains

      !> A key that has no meaning for this motion.
      subroutine refuse(name, expected)
         character(len=*), intent(in) :: name
         character(len=*), intent(in) :: expected

         call group%refuse(name, "'" // name // "' has no meaning for a body whose motion is '" // &
            trim(motion_names(body%motion)) // "'", expected, diagnostics)
      end subroutine refuse

      !> A rotor is round, and its drive turns it about its axis.
      subroutine check_rotor()
         real(wp) :: final(3)

         if (group%is_set("inertia")) then
            if (abs(body%inertia(1) - body%inertia(2)) > 1.0e-12_wp*body%inertia(1)) call &
               diagnostics%add(group%place("inertia", 2), "rotor " // quote(body%name) // &
               " is not round: its moments of inertia across its third axis differ", &
               "inertia = " // to_text(body%inertia(1)) // ", " // to_text(body%inertia(1)) // &
               ", ...")
         end if
         if (.not. group%is_set("final_angular_velocity")) return
         final = matmul(group%numbers("final_angular_velocity"), rotation_matrix(body%quaternion))
         if (norm2(final(:2)) > 1.0e-9_wp*norm2(final)) call diagnostics%add( &
            group%place("final_angular_velocity", 1), "the final angular velocity of rotor " // &
            quote(body%name) // " is not along its third axis", "a multiple of that axis")
      end subroutine check_rotor

      !> A velocity of a body at rest; zeros are in order.
      subroutine refuse_motion(name)
         character(len=*), intent(in) :: name

         if (any(abs(group%numbers(name)) > 0.0_wp)) call refuse(name, &
            "motion = 'prescribed', which keeps the initial velocities")
      end subroutine refuse_motion

      !> A key that this motion needs.
      subroutine need(name)
         character(len=*), intent(in) :: name

         if (group%lacks(name)) call diagnostics%add(group%origin, "'" // name // &
            "' is missing in group &body" // group%named(), name // " = " // &
            domain_text(group%key(name)) // alternative(name))
      end subroutine need

      !> What can stand in place of a key.
      pure function alternative(name) result(words)
         character(len=*), intent(in) :: name
         character(len=:), allocatable :: words

         select case (name)
         case ("mass")
            words = "; or density, for mass and inertia of a solid with the surface of the body"
         case ("inertia")
            words = "; or radius_of_gyration, or density in place of mass and inertia"
         case default
            words = ""
         end select
      end function alternative

   end subroutine check_motion

   !> How a drive changes the velocities of a body.
   subroutine build_drive(group, body, diagnostics)
      type(group_settings_type), intent(in) :: group
      !> The body; its motion and initial state are set.
      type(body_spec_type), intent(inout) :: body
      type(diagnostics_type), intent(inout) :: diagnostics
      logical :: driven

      body%final_velocity = body%velocity
      body%final_angular_velocity = matmul(rotation_matrix(body%quaternion), body%spin)
      if (group%is_set("final_velocity")) body%final_velocity = group%numbers("final_velocity")
      if (group%is_set("final_angular_velocity")) then
         body%final_angular_velocity = group%numbers("final_angular_velocity")
      end if
      body%ramp_duration = group%number("ramp_duration")
      if (.not. turns_by_drive(body%motion)) return
      driven = group%is_given("final_velocity") .or. group%is_given("final_angular_velocity")
      if (driven .and. .not. (group%is_given("ramp_duration") .or. &
         group%is_misspelt("ramp_duration"))) then
         call group%refuse("final_velocity", "'final_velocity' without 'ramp_duration'", &
            "ramp_duration = a number > 0 [s]", diagnostics)
         call group%refuse("final_angular_velocity", &
            "'final_angular_velocity' without 'ramp_duration'", &
            "ramp_duration = a number > 0 [s]", diagnostics)
      else if (.not. driven) then
         call group%refuse("ramp_duration", "'ramp_duration' without a final velocity", &
            "final_velocity or final_angular_velocity", diagnostics)
      end if
   end subroutine build_drive

end module contensou_scene_bodies
