!> The rest position of a scene under its loads: deflections, loads of the contacts, and the
!> stiffness of its rings.
module contensou_study_equilibrium
   use, intrinsic :: ieee_arithmetic, only : ieee_quiet_nan, ieee_value
   use contensou_base_errors, only : error_type, fatal, status_failed, status_usage
   use contensou_base_kinds, only : pi, wp
   use contensou_base_numbers, only : number_text
   use contensou_base_rotations, only : quaternion_of_matrix, rotation_vector
   use contensou_base_text, only : quote
   use contensou_base_vectors, only : cross, unit_vector
   use contensou_contact_geometry, only : contact_motion_type
   use contensou_contact_shapes_sphere, only : sphere_type
   use contensou_contact_shapes_torus, only : torus_type
   use contensou_dynamics_equations, only : system_type
   use contensou_dynamics_scene, only : motion_free, motion_rotor, motion_spindle, moves_freely, &
      scene_type
   use contensou_dynamics_statics, only : assemble_statics, begin_statics, coordinate_type, &
      find_rest, find_stiffness, reduced, statics_type
   implicit none(type, external)
   private

   public :: equilibrium_type, ring_type, settled_contact_type, find_equilibrium

   !> A ring: a body that turns as prescribed, or that carries a groove, and is free to move.
   type :: ring_type
      integer :: body = 0
      !> Its axes: across, across, along the axis; inertial frame.
      real(wp) :: frame(3, 3) = 0.0_wp
      !> Stiffness against translations along the three and tilts about the first two axes, all else
      !> yielding [N/m, N/rad, N m/m, N m/rad].
      real(wp) :: stiffness(5, 5) = 0.0_wp
   end type ring_type

   !> A contact in the rest position.
   type :: settled_contact_type
      !> Normal force [N], approach [m], semi-axes of the spot [m], largest pressure [Pa].
      real(wp) :: force = 0.0_wp, approach = 0.0_wp, semi_axes(2) = 0.0_wp, pressure = 0.0_wp
      !> Angle of the normal with the plane of a groove [rad]; not a number without one.
      real(wp) :: angle = 0.0_wp
   end type settled_contact_type

   !> The rest position.
   type :: equilibrium_type
      !> The scene with its bodies there.
      type(scene_type) :: scene
      !> How far each body has moved [m] and turned [rad], inertial frame.
      real(wp), allocatable :: shift(:, :), turn(:, :)
      type(settled_contact_type), allocatable :: contacts(:)
      type(ring_type), allocatable :: rings(:)
      !> Largest load that does not balance, over the loads of its body [-].
      real(wp) :: residual = 0.0_wp
      integer :: iterations = 0
   end type equilibrium_type

contains

   !> Find the rest position of a scene.
   subroutine find_equilibrium(scene, found, error)
      type(scene_type), intent(in) :: scene
      type(equilibrium_type), intent(out) :: found
      !> Set when there is none.
      type(error_type), allocatable, intent(out) :: error
      type(system_type) :: system
      type(statics_type) :: statics
      type(coordinate_type), allocatable :: coordinates(:)
      integer :: i

      call assemble_statics(scene, system)
      do i = 1, size(scene%contacts)
         if (.not. system%contacts(i)%rigid) cycle
         call fatal(error, "contact " // quote(scene%contacts(i)%name) // " is rigid and has " // &
            "no deflection: --set contact.normal=hertz gives it compliance", status_usage)
         return
      end do
      coordinates = free_coordinates(scene, system)
      if (size(coordinates) == 0) then
         call fatal(error, "no body of the scene is free to move", status_usage)
         return
      end if
      call find_rest(system, coordinates, statics)
      if (.not. statics%balanced) then
         i = max(statics%body, 1)
         call fatal(error, "no rest position was found: the loads on body " // &
            quote(scene%bodies(i)%name) // " do not balance, " // number_text(statics%residual, 3) &
            // " of them is left; a body that nothing carries has none" // turning(scene, i), &
            status_failed)
         return
      end if
      found%scene = scene
      found%residual = statics%residual
      found%iterations = statics%iterations
      allocate(found%shift(3, size(scene%bodies)), found%turn(3, size(scene%bodies)))
      call keep_poses()
      allocate(found%contacts(size(scene%contacts)))
      do i = 1, size(found%contacts)
         call settle_contact(scene, system, i, found%contacts(i))
      end do
      call find_rings(scene, system, found%rings)

   contains

      !> Keep where the bodies are.
      subroutine keep_poses()
         real(wp) :: rotation(3, 3)
         type(system_type) :: before
         integer :: k

         call assemble_statics(scene, before)
         do k = 1, size(scene%bodies)
            associate (body => found%scene%bodies(k), pose => system%pose(k), &
               first => before%pose(k))
               found%shift(:, k) = pose%position - first%position
               rotation = matmul(pose%rotation, transpose(first%rotation))
               found%turn(:, k) = 0.0_wp
               if (any(abs(pose%rotation - first%rotation) > 0.0_wp)) found%turn(:, k) = &
                  rotation_vector(rotation)
               body%position = pose%position
               if (any(abs(pose%rotation - first%rotation) > 0.0_wp)) body%quaternion = &
                  quaternion_of_matrix(pose%rotation)
            end associate
         end do
      end subroutine keep_poses

   end subroutine find_equilibrium

   !> What else may keep a body from resting: a torque about an axis that nothing holds.
   pure function turning(scene, body) result(text)
      type(scene_type), intent(in) :: scene
      integer, intent(in) :: body
      character(len=:), allocatable :: text

      text = ""
      associate (loaded => scene%bodies(body))
         if (loaded%motion == motion_free .and. any(abs(loaded%applied_torque) > 0.0_wp)) text = &
            ", nor one whose torque turns it: motion = 'rotor', of a bearing ring_motion, holds it"
      end associate
   end function turning

   !> The ways in which the bodies of a scene are free to move.
   function free_coordinates(scene, system) result(coordinates)
      type(scene_type), intent(in) :: scene
      type(system_type), intent(in) :: system
      type(coordinate_type), allocatable :: coordinates(:)
      type(coordinate_type) :: all_of_them(6*size(scene%bodies))
      real(wp) :: e(3), frame(3, 3)
      integer :: i, k, n

      n = 0
      do i = 1, size(scene%bodies)
         associate (body => scene%bodies(i))
            if (.not. moves_freely(body%motion)) cycle
            if (norm2(body%held_along) > 0.0_wp) then
               frame = frame_of_axis(body%held_along)
               do k = 1, 2
                  call add(frame(:, k), .false.)
               end do
            else
               do k = 1, 3
                  e = 0.0_wp
                  e(k) = 1.0_wp
                  call add(e, .false.)
               end do
            end if
            if (body%motion == motion_free) then
               if (is_ball(i)) cycle
               do k = 1, 3
                  e = 0.0_wp
                  e(k) = 1.0_wp
                  call add(e, .true.)
               end do
            else if (body%motion == motion_rotor) then
               do k = 1, 2
                  call add(system%pose(i)%rotation(:, k), .true.)
                  all_of_them(n)%follows = .true.
               end do
            end if
         end associate
      end do
      coordinates = all_of_them(:n)

   contains

      !> Whether nothing changes when a body turns about its centre of mass: it touches with spheres
      !> about that only.
      logical function is_ball(body)
         integer, intent(in) :: body
         integer :: s

         is_ball = .true.
         do s = 1, size(scene%surfaces)
            if (scene%surfaces(s)%body /= body) cycle
            associate (surface => scene%surfaces(s)%surface)
               select type (shape => surface%shape)
               type is (sphere_type)
                  is_ball = is_ball .and. all(abs(surface%centre) <= 0.0_wp)
               class default
                  is_ball = .false.
               end select
            end associate
         end do
         if (.not. allocated(scene%springs)) return
         do s = 1, size(scene%springs)
            if (scene%springs(s)%a == body .or. scene%springs(s)%b == body) is_ball = .false.
         end do
      end function is_ball

      !> Let the body move along a direction, or turn about it.
      subroutine add(direction, turns)
         real(wp), intent(in) :: direction(3)
         logical, intent(in) :: turns

         n = n + 1
         all_of_them(n) = coordinate_type(body=i, direction=direction, turns=turns)
      end subroutine add

   end function free_coordinates

   !> Axes along an axis, which is the last of them: for the third axis of the inertial frame its
   !> first and second one, and so on in a circle.
   pure function frame_of_axis(axis) result(frame)
      !> Unit vector.
      real(wp), intent(in) :: axis(3)
      real(wp) :: frame(3, 3)
      real(wp) :: e(3)

      e = 0.0_wp
      e(modulo(maxloc(abs(axis), dim=1), 3) + 1) = 1.0_wp
      frame(:, 3) = axis
      frame(:, 1) = unit_vector(e - dot_product(e, axis)*axis)
      frame(:, 2) = cross(axis, frame(:, 1))
   end function frame_of_axis

   !> What a contact carries in the rest position.
   subroutine settle_contact(scene, system, index, settled)
      type(scene_type), intent(in) :: scene
      !> The system at rest.
      type(system_type), intent(inout) :: system
      integer, intent(in) :: index
      type(settled_contact_type), intent(out) :: settled
      type(contact_motion_type) :: now
      real(wp) :: axis(3), centre(3), outward(3), radial
      integer :: trouble

      settled%angle = ieee_value(1.0_wp, ieee_quiet_nan)
      call system%observe(index, now)
      settled%approach = -now%at%gap
      associate (contact => system%contacts(index), a => system%pose(system%contacts(index)%a))
         if (contact%track%away .or. contact%track%lost .or. settled%approach <= 0.0_wp) return
         call contact%follow(now%at, trouble)
         settled%force = contact%law%normal%force(settled%approach)
         settled%semi_axes = [contact%law%normal%major_axis(settled%approach), &
            contact%law%normal%minor_axis(settled%approach)]
         settled%pressure = 1.5_wp*settled%force/(pi*product(settled%semi_axes))
         associate (surface => scene%surfaces(scene%contacts(index)%surfaces(1))%surface)
            select type (shape => surface%shape)
            class is (torus_type)
               if (.not. surface%inside) return
               axis = matmul(a%rotation, surface%frame(:, 3))
               centre = a%position + matmul(a%rotation, surface%centre)
            class default
               return
            end select
         end associate
         outward = now%at%point - centre
         outward = outward - dot_product(outward, axis)*axis
         radial = dot_product(now%at%normal, outward)/norm2(outward)
         if (abs(radial) > 0.0_wp) settled%angle = &
            atan(dot_product(now%at%normal, axis)/radial)
      end associate
   end subroutine settle_contact

   !> The rings of a scene and their stiffness.
   subroutine find_rings(scene, system, rings)
      type(scene_type), intent(in) :: scene
      !> The system at rest.
      type(system_type), intent(inout) :: system
      type(ring_type), allocatable, intent(out) :: rings(:)
      type(coordinate_type), allocatable :: coordinates(:)
      type(statics_type) :: statics
      type(ring_type) :: found(size(scene%bodies))
      logical :: yielding(6*size(scene%bodies) + 5)
      real(wp) :: axis(3)
      integer :: i, k, n, m
      logical :: is_ring, good

      n = 0
      coordinates = free_coordinates(scene, system)
      do i = 1, size(scene%bodies)
         call look_at(scene, system, i, is_ring, axis)
         if (.not. is_ring) cycle
         n = n + 1
         found(n)%body = i
         found(n)%frame = frame_of_axis(axis)
         m = size(coordinates)
         call begin_statics(statics, [coordinates, (coordinate_type(body=i, &
            direction=found(n)%frame(:, modulo(k - 1, 3) + 1), turns=k > 3), k=1, 5)])
         yielding(:m) = coordinates%body /= i
         if (scene%bodies(i)%motion == motion_free) call let_turn(i)
         call find_stiffness(system, statics, good, exactly=.true.)
         yielding(m + 1:m + 5) = .false.
         call reduced(statics, [(m + k, k=1, 5)], yielding(:m + 5), found(n)%stiffness)
      end do
      rings = found(:n)

   contains

      !> A free ring may turn about its axis: that takes the place of the rotation next to it, as
      !> one about another direction would yield together with the tilts that are kept.
      subroutine let_turn(body)
         integer, intent(in) :: body
         integer :: j, best

         best = 0
         do j = 1, m
            if (coordinates(j)%body /= body .or. .not. coordinates(j)%turns) cycle
            if (best == 0) best = j
            if (abs(dot_product(coordinates(j)%direction, axis)) > &
               abs(dot_product(coordinates(best)%direction, axis))) best = j
         end do
         if (best == 0) return
         yielding(best) = .true.
         statics%coordinates(best)%direction = axis
      end subroutine let_turn

   end subroutine find_rings

   !> Whether a body is a ring, and its axis.
   subroutine look_at(scene, system, body, ring, along)
      type(scene_type), intent(in) :: scene
      type(system_type), intent(in) :: system
      integer, intent(in) :: body
      logical, intent(out) :: ring
      real(wp), intent(out) :: along(3)
      integer :: s

      ring = .false.
      along = [0.0_wp, 0.0_wp, 1.0_wp]
      associate (motion => scene%bodies(body)%motion, pose => system%pose(body))
         if (.not. moves_freely(motion)) return
         ring = motion == motion_spindle .or. motion == motion_rotor
         if (motion == motion_rotor) along = pose%rotation(:, 3)
         do s = 1, size(scene%surfaces)
            associate (surface => scene%surfaces(s)%surface)
               if (scene%surfaces(s)%body /= body .or. .not. surface%inside) cycle
               select type (shape => surface%shape)
               class is (torus_type)
                  ring = .true.
                  along = matmul(pose%rotation, surface%frame(:, 3))
                  return
               class default
                  cycle
               end select
            end associate
         end do
      end associate
   end subroutine look_at

end module contensou_study_equilibrium
