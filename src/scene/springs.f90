!> Springs of a scene: the keys of their group, what they must say, and what follows from where
!> bodies begin.
module contensou_scene_springs
   use contensou_base_attitude, only : read_attitude
   use contensou_base_diagnostics, only : diagnostics_type
   use contensou_base_kinds, only : wp
   use contensou_base_rotations, only : rotation_matrix, unit_quaternion
   use contensou_base_schema, only : key_list_type, kind_choice, kind_name, kind_real, &
      kind_reference, schema_type
   use contensou_base_settings, only : group_settings_type, settings_type
   use contensou_base_text, only : quote
   use contensou_contact_geometry, only : pose_type
   use contensou_dynamics_assembly, only : initial_pose
   use contensou_dynamics_scene, only : motion_fixed, motion_prescribed, scene_type, &
      spring_spec_type
   use contensou_dynamics_springs, only : spring_axial, spring_bushing, spring_kinds
   use contensou_scene_references, only : references_type
   implicit none(type, external)
   private

   public :: spring_group, put_spring_keys, build_spring, complete_springs

   character(len=*), parameter :: spring_group = "spring"

contains

   subroutine put_spring_keys(list)
      type(key_list_type), intent(inout) :: list
      character(len=*), parameter :: s = spring_group

      call list%put(s, "name", kind_name, mandatory=.true., doc="name of the spring")
      call list%put(s, "bodies", kind_reference, values=2, mandatory=.true., target="body", &
         doc="the bodies A and B, one of which may be 'ground'; forces are reported as they " // &
         "act on B")
      call list%put(s, "kind", kind_choice, words=spring_kinds, default="'bushing'", &
         doc="bushing, with three translations and three rotations along axes fixed to A, or " // &
         "axial, along the line between two points")
      call list%put(s, "first_point", kind_real, values=3, unit="m", &
         doc="where the spring is fastened to A, frame of A; not given, where second_point is " // &
         "at the beginning, and without both the centre of mass of B, or of A if B is the " // &
         "ground; of an axial one the origin of A")
      call list%put(s, "second_point", kind_real, values=3, unit="m", &
         doc="where it is fastened to B, frame of B; not given, where first_point is at the " // &
         "beginning; of an axial one the origin of B")
      call list%put(s, "axis", kind_real, values=3, unit="1", &
         doc="axis of the rotation from the axes of A to those of a bushing, of any length; " // &
         "goes with angle")
      call list%put(s, "angle", kind_real, unit="rad", doc="angle of that rotation about axis")
      call list%put(s, "quaternion", kind_real, values=4, unit="1", &
         doc="attitude (w, x, y, z) of the axes of a bushing, to the frame of A; instead of " // &
         "axis and angle")
      call list%put(s, "stiffness", kind_real, values=3, fewer=.true., unit="N m-1", &
         least=0.0_wp, doc="stiffness along the axes, or one for all; of an axial one its " // &
         "only one; 0 if not given")
      call list%put(s, "damping", kind_real, values=3, fewer=.true., unit="N s m-1", &
         least=0.0_wp, doc="damping along the axes, or one for all, likewise")
      call list%put(s, "rotational_stiffness", kind_real, values=3, fewer=.true., &
         unit="N m rad-1", least=0.0_wp, doc="stiffness of a bushing about its axes, or one " // &
         "for all, for rotations up to half a turn; 0 if not given")
      call list%put(s, "rotational_damping", kind_real, values=3, fewer=.true., &
         unit="N m s rad-1", least=0.0_wp, doc="damping of a bushing about its axes, or one " // &
         "for all; 0 if not given")
      call list%put(s, "preload", kind_real, values=3, unit="N", &
         doc="force of a bushing on B where its points coincide, along its axes; none if not given")
      call list%put(s, "length", kind_real, unit="m", least=0.0_wp, &
         doc="length of a relaxed axial spring; not given, that of the beginning")
      call list%put(s, "relaxed_quaternion", kind_real, values=4, unit="1", &
         doc="attitude (w, x, y, z) of B against A, to the frame of A, in which a bushing is " // &
         "not twisted; not given, that of the beginning")
   end subroutine put_spring_keys

   !> Read a spring.
   subroutine build_spring(group, references, spring, diagnostics)
      type(group_settings_type), intent(in) :: group
      !> Names of the scene.
      type(references_type), intent(in) :: references
      type(spring_spec_type), intent(inout) :: spring
      type(diagnostics_type), intent(inout) :: diagnostics
      real(wp) :: quaternion(4)
      character(len=*), parameter :: of_bushing(*) = [character(len=20) :: "axis", "angle", &
         "quaternion", "rotational_stiffness", "rotational_damping", "preload", &
         "relaxed_quaternion"]
      integer :: i

      spring%name = group%label()
      call references%find(group, "bodies", 1, spring%a, diagnostics)
      call references%find(group, "bodies", 2, spring%b, diagnostics)
      spring%kind = max(group%choice("kind"), 1)
      spring%placed = [group%is_given("first_point"), group%is_given("second_point")]
      spring%point(:, 1) = group%numbers("first_point")
      spring%point(:, 2) = group%numbers("second_point")
      quaternion = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      call read_attitude(group, quaternion, diagnostics)
      spring%axes = rotation_matrix(quaternion)
      call read_coefficients("stiffness", spring%stiffness)
      call read_coefficients("damping", spring%damping)
      call read_coefficients("rotational_stiffness", spring%turning_stiffness)
      call read_coefficients("rotational_damping", spring%turning_damping)
      spring%preload = group%numbers("preload")
      spring%measured = group%is_given("length")
      spring%length = group%number("length")
      spring%aligned = group%is_given("relaxed_quaternion")
      if (spring%aligned .and. group%is_set("relaxed_quaternion")) then
         quaternion = group%vector("relaxed_quaternion", 4)
         if (any(abs(quaternion) > 0.0_wp)) then
            spring%relaxed = rotation_matrix(unit_quaternion(quaternion))
         else
            call diagnostics%add(group%place("relaxed_quaternion", 1), &
               "'relaxed_quaternion' is zero", "(w, x, y, z) of any norm but zero")
         end if
      end if
      if (spring%kind == spring_axial) then
         do i = 1, size(of_bushing)
            call group%refuse(trim(of_bushing(i)), "'" // trim(of_bushing(i)) // &
               "' has no meaning for a spring between two points", "kind = 'bushing', or no " // &
               trim(of_bushing(i)), diagnostics)
         end do
      else
         call group%refuse("length", "'length' has no meaning for a bushing, which is relaxed " // &
            "where its points coincide", "kind = 'axial', or no length", diagnostics)
      end if
      if (.not. (any(spring%stiffness > 0.0_wp) .or. any(spring%turning_stiffness > 0.0_wp) .or. &
         any(abs(spring%preload) > 0.0_wp) .or. spring%damps()) .and. group%complete) call &
         diagnostics%add(group%origin, "spring " // quote(spring%name) // " does nothing", &
         "stiffness, damping, rotational_stiffness, rotational_damping or preload")

   contains

      !> Read coefficients along three axes: one for all or three, of an axial spring its only one.
      subroutine read_coefficients(key, values)
         character(len=*), intent(in) :: key
         real(wp), intent(out) :: values(3)

         values = 0.0_wp
         if (.not. group%is_set(key)) return
         values = group%numbers(key)
         if (spring%kind == spring_axial) then
            if (group%count(key) > 1) call diagnostics%add(group%place(key, 2), "'" // key // &
               "' of a spring between two points has several values", "one number")
            values(2:) = 0.0_wp
         else if (group%count(key) == 1) then
            values = values(1)
         else if (group%count(key) == 2) then
            call diagnostics%add(group%place(key, 2), "'" // key // "' has two values", &
               "one number or three")
         end if
      end subroutine read_coefficients

   end subroutine build_spring

   !> Check the bodies of the springs, and let points, lengths and attitudes that are not given
   !> follow from where bodies begin; they are filled in.
   subroutine complete_springs(settings, schema, references, scene, diagnostics)
      type(settings_type), intent(inout), target :: settings
      type(schema_type), intent(in), target :: schema
      !> Names of the scene.
      type(references_type), intent(in) :: references
      type(scene_type), intent(inout) :: scene
      type(diagnostics_type), intent(inout) :: diagnostics
      type(group_settings_type) :: group
      integer :: i

      do i = 1, size(settings%groups)
         group = settings%group(i, schema)
         if (group%group_name() /= spring_group) cycle
         associate (spring => scene%springs(references%numbers(i)))
            if (spring%a == spring%b) then
               call diagnostics%add(group%place("bodies", 2), "spring " // quote(spring%name) // &
                  " joins a body to itself", "two bodies, or a body and 'ground'")
            else if (stays(spring%a) .and. stays(spring%b)) then
               call diagnostics%add(group%place("bodies", 1), "spring " // quote(spring%name) // &
                  ": neither of its bodies yields", "a body whose motion is 'free'")
            else
               call complete(group, scene, spring, diagnostics)
            end if
         end associate
      end do

   contains

      !> Whether a spring cannot move a body.
      logical function stays(body)
         integer, intent(in) :: body

         stays = body == 0
         if (body > 0) stays = any(scene%bodies(body)%motion == [motion_fixed, motion_prescribed])
      end function stays

   end subroutine complete_springs

   !> Let what a spring does not say follow from where its bodies begin.
   subroutine complete(group, scene, spring, diagnostics)
      type(group_settings_type), intent(in) :: group
      type(scene_type), intent(in) :: scene
      type(spring_spec_type), intent(inout) :: spring
      type(diagnostics_type), intent(inout) :: diagnostics
      type(pose_type) :: a, b
      real(wp) :: place(3)

      a = initial_pose(scene, spring%a)
      b = initial_pose(scene, spring%b)
      if (spring%kind == spring_bushing) then
         if (.not. any(spring%placed)) spring%placed = [spring%b == 0, spring%b > 0]
         if (.not. spring%placed(1)) then
            place = b%position + matmul(b%rotation, spring%point(:, 2))
            spring%point(:, 1) = matmul(place - a%position, a%rotation)
         else if (.not. spring%placed(2)) then
            place = a%position + matmul(a%rotation, spring%point(:, 1))
            spring%point(:, 2) = matmul(place - b%position, b%rotation)
         end if
      end if
      call group%derive_numbers("first_point", spring%point(:, 1))
      call group%derive_numbers("second_point", spring%point(:, 2))
      if (spring%kind == spring_axial) then
         associate (reach => b%position + matmul(b%rotation, spring%point(:, 2)) - a%position &
            - matmul(a%rotation, spring%point(:, 1)))
            if (.not. norm2(reach) > 0.0_wp) call diagnostics%add(group%place("bodies", 1), &
               "the two points of spring " // quote(spring%name) // " coincide at the " // &
               "beginning: it has no direction", "first_point and second_point at a distance")
            if (.not. spring%measured) spring%length = norm2(reach)
         end associate
         call group%derive_number("length", spring%length)
      else if (any(spring%turning_stiffness > 0.0_wp)) then
         if (.not. spring%aligned) then
            associate (qa => attitude_of(spring%a), qb => attitude_of(spring%b))
               call align(qa, qb)
            end associate
         end if
      end if

   contains

      !> Attitude of a body at the beginning.
      function attitude_of(body) result(quaternion)
         integer, intent(in) :: body
         real(wp) :: quaternion(4)

         quaternion = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
         if (body > 0) quaternion = scene%bodies(body)%quaternion
      end function attitude_of

      !> Take the attitude of B against A, qa* o qb, as the relaxed one.
      subroutine align(qa, qb)
         real(wp), intent(in) :: qa(4)
         real(wp), intent(in) :: qb(4)
         real(wp) :: q(4)

         q(1) = qa(1)*qb(1) + dot_product(qa(2:4), qb(2:4))
         q(2) = qa(1)*qb(2) - qa(2)*qb(1) - qa(3)*qb(4) + qa(4)*qb(3)
         q(3) = qa(1)*qb(3) - qa(3)*qb(1) - qa(4)*qb(2) + qa(2)*qb(4)
         q(4) = qa(1)*qb(4) - qa(4)*qb(1) - qa(2)*qb(3) + qa(3)*qb(2)
         q = unit_quaternion(q)
         call group%derive_numbers("relaxed_quaternion", q)
         spring%relaxed = rotation_matrix(q)
      end subroutine align

   end subroutine complete

end module contensou_scene_springs
