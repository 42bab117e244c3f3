!> What to do about surfaces that overlap at the beginning: touch one of them from its other side,
!> or move a body.
module contensou_scene_remedies
   use contensou_base_kinds, only : wp
   use contensou_base_numbers, only : number_text, rounded, to_text
   use contensou_base_text, only : quote
   use contensou_contact_geometry, only : contact_point_type, geometry_type, pose_type, track_type
   use contensou_contact_pairs, only : new_geometry
   use contensou_contact_shapes_shape, only : shape_info_type
   use contensou_contact_surface, only : surface_type
   use contensou_dynamics_assembly, only : largest_relative_approach
   use contensou_dynamics_mechanism, only : contact_type
   use contensou_dynamics_scene, only : contact_spec_type, moves_freely, scene_type
   implicit none(type, external)
   private

   public :: remedy

contains

   !> What would be right instead of an overlap; empty if nobody knows.
   function remedy(scene, spec, contact, pose_a, pose_b) result(text)
      type(scene_type), intent(in) :: scene
      type(contact_spec_type), intent(in) :: spec
      !> The contact; its track is changed.
      type(contact_type), intent(inout) :: contact
      !> Poses of its bodies.
      type(pose_type), intent(in) :: pose_a, pose_b
      character(len=:), allocatable :: text
      integer :: which

      do which = 2, 1, -1
         text = other_side(scene, spec, contact%rigid, which, pose_a, pose_b)
         if (text /= "") return
      end do
      text = move(scene, contact, pose_a, pose_b)
   end function remedy

   !> How to touch one of the surfaces from its other side; empty if they would overlap then, too.
   function other_side(scene, spec, rigid, which, pose_a, pose_b) result(text)
      type(scene_type), intent(in) :: scene
      type(contact_spec_type), intent(in) :: spec
      !> Whether the contact is rigid.
      logical, intent(in) :: rigid
      !> Which of the surfaces is turned, 1 or 2.
      integer, intent(in) :: which
      !> Poses of the bodies.
      type(pose_type), intent(in) :: pose_a, pose_b
      character(len=:), allocatable :: text
      class(geometry_type), allocatable :: geometry
      character(len=:), allocatable :: problem, name
      type(surface_type) :: pair(2), as_it_was
      type(shape_info_type) :: info
      type(track_type) :: track
      real(wp) :: gap, most
      integer :: i

      text = ""
      do i = 1, 2
         pair(i) = scene%surfaces(spec%surfaces(i))%surface
      end do
      as_it_was = pair(which)
      name = quote(scene%surfaces(spec%surfaces(which))%name)
      info = as_it_was%shape%info()
      associate (turned => pair(which))
         if (info%hollow /= "") then
            turned%inside = .not. turned%inside
         else if (info%name == "plane") then
            turned%frame(:, 2:3) = -turned%frame(:, 2:3)
         else
            return
         end if
         call new_geometry(pair(1), pair(2), geometry, problem)
         if (.not. allocated(geometry)) return
         call geometry%gap(pose_a, pose_b, track, gap)
         most = largest_relative_approach*geometry%smallest_radius()
         if (rigid) most = 0.0_wp
         if (track%lost .or. .not. gap >= -most) return
         if (info%hollow == "") then
            text = "the normal of surface " // name // " turned round, normal = " // &
               three(turned%frame(:, 3))
         else if (turned%inside) then
            text = "side = 'inside' of surface " // name
         else
            text = "surface " // name // " without side = 'inside'"
         end if
      end associate
      if (abs(gap) <= 1.0e-9_wp*geometry%smallest_radius()) then
         text = text // ": then they just touch"
      else
         text = text // ": then the gap is " // number_text(gap, 4) // " m"
      end if
   end function other_side

   !> How far a body of a contact would have to move to just touch; empty if that was not found.
   function move(scene, contact, pose_a, pose_b) result(text)
      type(scene_type), intent(in) :: scene
      !> The contact; its track is changed.
      type(contact_type), intent(inout) :: contact
      !> Poses of its bodies.
      type(pose_type), intent(in) :: pose_a, pose_b
      character(len=:), allocatable :: text
      type(contact_point_type) :: at
      type(track_type) :: track
      type(pose_type) :: pose(2)
      real(wp) :: direction(3), position(3), distance, before, gap, gap_before, slope, radius
      integer :: body, moved, i

      text = ""
      track = contact%track
      call contact%find_gap(pose_a, pose_b, gap)
      if (contact%track%lost) return
      call contact%locate(pose_a, pose_b, gap, at)
      moved = 2
      body = contact%b
      if (.not. free(contact%b)) then
         moved = 1
         body = contact%a
      end if
      if (.not. free(body)) return
      direction = at%normal
      if (moved == 1) direction = -direction
      if (.not. abs(norm2(direction) - 1.0_wp) < 1.0e-6_wp) return
      radius = contact%law%geometry%smallest_radius()
      before = 0.0_wp
      gap_before = gap
      distance = -gap
      do i = 1, 50
         pose = [pose_a, pose_b]
         pose(moved)%position = pose(moved)%position + distance*direction
         contact%track = track
         call contact%find_gap(pose(1), pose(2), gap)
         if (contact%track%lost) return
         if (abs(gap) <= 1.0e-12_wp*max(radius, abs(distance))) exit
         slope = (gap - gap_before)/(distance - before)
         if (.not. slope > 0.01_wp) return
         before = distance
         gap_before = gap
         distance = distance - gap/slope
         if (.not. abs(distance - before) > 0.0_wp) exit
      end do
      if (.not. abs(gap) <= 1.0e-9_wp*max(radius, abs(distance)) .or. distance <= 0.0_wp) return
      position = pose(moved)%position
      text = "body " // quote(scene%bodies(body)%name) // " moved by " // &
         number_text(distance, 4) // " m along " // three(direction) // &
         ", where they just touch: position = " // three(position)

   contains

      !> Whether a body moves freely.
      pure logical function free(body)
         !> Its index; 0 for the ground.
         integer, intent(in) :: body

         free = .false.
         if (body > 0) free = moves_freely(scene%bodies(body)%motion)
      end function free

   end function move

   !> Three numbers as a scene has them.
   function three(x) result(text)
      real(wp), intent(in) :: x(3)
      character(len=:), allocatable :: text
      real(wp) :: value
      integer :: i

      text = ""
      do i = 1, 3
         value = 0.0_wp
         if (abs(x(i)) > 1.0e-12_wp*norm2(x)) value = rounded(x(i), 10)
         if (i > 1) text = text // ", "
         text = text // to_text(value)
      end do
   end function three

end module contensou_scene_remedies
