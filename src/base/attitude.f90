!> Attitudes and directions as the settings of a group give them.
module contensou_base_attitude
   use contensou_base_diagnostics, only : diagnostics_type
   use contensou_base_kinds, only : wp
   use contensou_base_rotations, only : quaternion_from_axis_angle, unit_quaternion
   use contensou_base_settings, only : group_settings_type
   use contensou_base_text, only : quote
   use contensou_base_vectors, only : frame_along
   implicit none(type, external)
   private

   public :: read_attitude, read_frame

contains

   !> Attitude by `axis` and `angle` or by `quaternion`.
   subroutine read_attitude(group, attitude, diagnostics)
      type(group_settings_type), intent(in) :: group
      !> Unit quaternion; unchanged if none is given.
      real(wp), intent(inout) :: attitude(4)
      type(diagnostics_type), intent(inout) :: diagnostics
      real(wp) :: axis(3), quaternion(4)
      logical :: turned

      turned = group%is_given("axis") .or. group%is_given("angle")
      if (.not. group%is_given("angle")) call group%refuse("axis", "'axis' without 'angle'", &
         "both, or neither", diagnostics)
      if (.not. group%is_given("axis")) call group%refuse("angle", "'angle' without 'axis'", &
         "both, or neither", diagnostics)
      if (turned) call group%refuse("quaternion", "the attitude is given twice", &
         "either quaternion, or axis and angle", diagnostics)
      if (group%is_set("axis") .and. group%is_set("angle")) then
         axis = group%numbers("axis")
         if (any(abs(axis) > 0.0_wp)) then
            attitude = quaternion_from_axis_angle(axis, group%number("angle"))
         else
            call diagnostics%add(group%place("axis", 1), "'axis' is a zero vector", &
               "an axis of any length but zero")
         end if
      else if (group%is_set("quaternion")) then
         quaternion = group%vector("quaternion", 4)
         if (any(abs(quaternion) > 0.0_wp)) then
            attitude = unit_quaternion(quaternion)
         else
            call diagnostics%add(group%place("quaternion", 1), "'quaternion' is zero", &
               "(w, x, y, z) of any norm but zero, components of 1e-40 to 1e40")
         end if
      end if
   end subroutine read_attitude

   !> Frame whose third axis a key gives.
   subroutine read_frame(group, name, frame, diagnostics)
      type(group_settings_type), intent(in) :: group
      !> Name of the key.
      character(len=*), intent(in) :: name
      !> Rotation matrix; unchanged if the key is not given.
      real(wp), intent(inout) :: frame(3, 3)
      type(diagnostics_type), intent(inout) :: diagnostics
      real(wp) :: along(3)

      if (.not. group%is_set(name)) return
      along = group%numbers(name)
      if (any(abs(along) > 0.0_wp)) then
         frame = frame_along(along)
      else
         call diagnostics%add(group%place(name, 1), quote(name) // " is a zero vector", &
            "a " // name // " of any length but zero")
      end if
   end subroutine read_frame

end module contensou_base_attitude
