!> Bodies with a `place` are put down: moved along gravity until they just touch what is below, or
!> until the normal forces of their contacts carry them.
module contensou_scene_placing
   use contensou_base_diagnostics, only : diagnostics_type, origin_type
   use contensou_base_kinds, only : wp
   use contensou_base_numbers, only : power_text
   use contensou_base_rotations, only : rotation_matrix
   use contensou_base_schema, only : schema_type
   use contensou_base_settings, only : group_settings_type, settings_type
   use contensou_base_text, only : quote
   use contensou_contact_geometry, only : contact_point_type, pose_type, trouble_none
   use contensou_dynamics_assembly, only : assemble, initial_pose
   use contensou_dynamics_equations, only : system_type
   use contensou_dynamics_mechanism, only : contact_type
   use contensou_dynamics_scene, only : moves_freely, scene_type
   use contensou_dynamics_statics, only : assemble_statics, coordinate_type, find_rest, statics_type
   use contensou_scene_references, only : references_type
   implicit none(type, external)
   private

   public :: place_names, place_bodies

   !> How a body is put down.
   character(len=*), parameter :: place_names(*) = [character(len=5) :: "touch", "rest"]

   integer, parameter :: place_rest = 2

   !> Cosine between a normal and the vertical below which a contact carries nothing.
   real(wp), parameter :: steep = 1.0e-6_wp

   !> Most moves on the way to a touch.
   integer, parameter :: most_moves = 10000

   !> What is known of a body above or below others.
   type :: support_type
      !> The contacts of the body with what is settled.
      integer, allocatable :: contacts(:)
   end type support_type

contains

   !> Put down the bodies that have a `place`.
   subroutine place_bodies(settings, schema, references, scene, system, diagnostics)
      !> The settings; positions are filled in.
      type(settings_type), intent(inout), target :: settings
      type(schema_type), intent(in), target :: schema
      !> Names of the scene.
      type(references_type), intent(in) :: references
      type(scene_type), intent(inout) :: scene
      !> Its equations of motion, made anew where a body has moved.
      type(system_type), allocatable, intent(inout) :: system
      type(diagnostics_type), intent(inout) :: diagnostics
      type(group_settings_type) :: group
      type(origin_type) :: places(size(scene%bodies))
      integer :: place(size(scene%bodies)), i, n

      place = 0
      do i = 1, size(settings%groups)
         group = settings%group(i, schema)
         if (group%group_name() /= "body") cycle
         n = references%numbers(i)
         place(n) = group%choice("place")
         places(n) = group%place("place", 1)
      end do
      if (all(place == 0)) return
      call put_down(scene, system, place, places, diagnostics)
      if (diagnostics%count() > 0) return
      deallocate(system)
      allocate(system)
      call assemble(scene, system)
      do i = 1, size(settings%groups)
         group = settings%group(i, schema)
         if (group%group_name() /= "body") cycle
         n = references%numbers(i)
         if (place(n) == 0) cycle
         call group%derive_numbers("position", scene%bodies(n)%position)
         call group%unset("place")
      end do
   end subroutine place_bodies

   !> Put down the bodies of a scene, from the lowest to the highest; those of the same height do
   !> not carry each other.
   subroutine put_down(scene, system, place, places, diagnostics)
      !> The scene; positions of bodies are changed.
      type(scene_type), intent(inout) :: scene
      !> Its equations of motion; tracks and normal parts of contacts are changed.
      type(system_type), intent(inout) :: system
      !> For each body one of the `place_*` codes, 0 for those that stay.
      integer, intent(in) :: place(:)
      !> Where that is said.
      type(origin_type), intent(in) :: places(:)
      type(diagnostics_type), intent(inout) :: diagnostics
      type(support_type) :: supports(size(place))
      integer :: order(count(place > 0))
      real(wp) :: up(3), height(size(place)), slack
      logical :: settled(0:size(place))
      integer :: before, first, i, k, last

      before = diagnostics%count()
      if (.not. norm2(scene%gravity) > 0.0_wp) then
         i = findloc(place > 0, .true., dim=1)
         call diagnostics%add(places(i), "'place' has no meaning without gravity", &
            "scene.gravity, or a position")
         return
      end if
      up = -scene%gravity/norm2(scene%gravity)
      do i = 1, size(place)
         height(i) = dot_product(up, scene%bodies(i)%position)
         if (place(i) > 0 .and. .not. moves_freely(scene%bodies(i)%motion)) call diagnostics%add( &
            places(i), "body " // quote(scene%bodies(i)%name) // " is not carried: its motion is " &
            // "given", "motion = 'free' or 'spindle'")
      end do
      if (diagnostics%count() > before) return
      call sort(place, height, order)
      settled = .true.
      settled(1:) = place == 0
      first = 1
      do while (first <= size(order))
         last = first
         do while (last < size(order))
            slack = 1.0e-9_wp*max(abs(height(order(first))), scale_of(order(first)))
            if (height(order(last + 1)) - height(order(first)) > slack) exit
            last = last + 1
         end do
         do k = first, last
            call find_support(order(k))
            if (diagnostics%count() > before) return
         end do
         do k = first, last
            call fall(order(k))
         end do
         if (diagnostics%count() > before) return
         settled(order(first:last)) = .true.
         first = last + 1
      end do
      call let_sink()
      if (diagnostics%count() > before) return
      do k = 1, size(order)
         if (place(order(k)) == place_rest .and. diagnostics%count() == before) call &
            check_sides(order(k))
      end do

   contains

      !> Length of the order of a body [m].
      real(wp) function scale_of(body)
         integer, intent(in) :: body
         integer :: c

         scale_of = 0.0_wp
         do c = 1, size(system%contacts)
            associate (contact => system%contacts(c))
               if (contact%a /= body .and. contact%b /= body) cycle
               scale_of = max(scale_of, min(contact%law%geometry%smallest_radius(), 1.0e6_wp))
            end associate
         end do
      end function scale_of

      !> Find the contacts of a body with what is settled.
      subroutine find_support(body)
         integer, intent(in) :: body
         integer :: c, n

         associate (support => supports(body))
            n = 0
            allocate(support%contacts(size(system%contacts)))
            do c = 1, size(system%contacts)
               associate (contact => system%contacts(c))
                  ! Of several spots the first is the closest.
                  if (contact%spot > 1) cycle
                  if (.not. (contact%a == body .and. settled(contact%b) .or. &
                     contact%b == body .and. settled(contact%a))) cycle
               end associate
               n = n + 1
               support%contacts(n) = c
            end do
            support%contacts = support%contacts(:n)
            if (n == 0) call diagnostics%add(places(body), "body " // &
               quote(scene%bodies(body)%name) // " has no contact with anything that stays or is " &
               // "put down before it", "a contact with what is below it; bodies are put down " // &
               "from the lowest position to the highest")
         end associate
      end subroutine find_support

      !> Move a body along gravity until it just touches.
      subroutine fall(body)
         integer, intent(in) :: body
         real(wp) :: start(3), gap, slope, s, s_open, s_closed, reach
         logical :: lost, supported, open_known, closed_known
         integer :: i

         start = scene%bodies(body)%position
         s = 0.0_wp
         s_open = huge(s)
         s_closed = -huge(s)
         reach = 1.0e6_wp*max(scale_of(body), maxval(abs(start)), 1.0e-3_wp)
         do i = 1, most_moves
            call nearest_gap(body, start + s*up, gap, slope, supported, lost)
            if (lost) then
               call fail_for(body, "the search for its closest points has failed")
               return
            end if
            if (.not. supported .or. abs(s) > reach) then
               call fail_for(body, "there is nothing below it to touch")
               return
            end if
            if (gap >= 0.0_wp) s_open = min(s_open, s)
            if (gap < 0.0_wp) s_closed = max(s_closed, s)
            open_known = s_open < huge(s)
            closed_known = s_closed > -huge(s)
            if (abs(gap) <= 0.0_wp) exit
            if (open_known .and. closed_known) then
               if (s_open - s_closed <= rounding_at(start + s*up)) exit
               ! Newton's step where it stays in between.
               s = s - gap/max(slope, steep)
               if (.not. (s > s_closed .and. s < s_open)) s = 0.5_wp*(s_open + s_closed)
            else if (gap > 0.0_wp .and. gap <= 4.0_wp*rounding_at(start + s*up)) then
               ! As near as rounding lets it: a step more would not tell.
               s = s - gap
               if (gap <= rounding_at(start + s*up)) exit
            else
               ! A gap is a distance: nothing is passed by a move of its size. It grows by what it
               ! overlaps by until it is open.
               s = s - gap*merge(1.0_wp, 1.0_wp/max(slope, 0.1_wp), gap > 0.0_wp)
            end if
         end do
         if (open_known .and. closed_known) s = s_open
         scene%bodies(body)%position = start + s*up
      end subroutine fall

      !> Report that a body cannot be put down.
      subroutine fail_for(body, why)
         integer, intent(in) :: body
         character(len=*), intent(in) :: why

         call diagnostics%add(places(body), "body " // quote(scene%bodies(body)%name) // &
            " cannot be put down: " // why, &
            "a position above what it is to touch, where its normal points, or no place")
      end subroutine fail_for

      !> Rounding of the height of a place [m].
      real(wp) function rounding_at(position)
         real(wp), intent(in) :: position(3)

         rounding_at = maxval(spacing(position), mask=abs(up) > 0.0_wp)
      end function rounding_at

      !> Smallest gap of a body with what carries it, and how fast it changes with the height.
      subroutine nearest_gap(body, position, gap, slope, supported, lost)
         integer, intent(in) :: body
         real(wp), intent(in) :: position(3)
         !> Smallest gap of the contacts whose normal has a part along gravity [m].
         real(wp), intent(out) :: gap
         real(wp), intent(out) :: slope
         !> Whether there is such a contact.
         logical, intent(out) :: supported
         !> Whether a search has failed.
         logical, intent(out) :: lost
         real(wp) :: one, n_up
         integer :: i

         gap = huge(gap)
         slope = 0.0_wp
         supported = .false.
         lost = .false.
         do i = 1, size(supports(body)%contacts)
            associate (contact => system%contacts(supports(body)%contacts(i)))
               call look(contact, body, position, one, n_up)
               lost = lost .or. contact%track%lost
               if (n_up <= steep .or. one >= gap) cycle
               gap = one
               slope = n_up
               supported = .true.
            end associate
         end do
      end subroutine nearest_gap

      !> Gap of a contact, and the part of its normal along which it pushes a body up.
      subroutine look(contact, body, position, gap, n_up, at)
         type(contact_type), intent(inout) :: contact
         integer, intent(in) :: body
         real(wp), intent(in) :: position(3)
         real(wp), intent(out) :: gap
         real(wp), intent(out) :: n_up
         type(contact_point_type), intent(out), optional :: at
         type(contact_point_type) :: point
         type(pose_type) :: a, b

         a = initial_pose(scene, contact%a)
         b = initial_pose(scene, contact%b)
         if (contact%a == body) a%position = position
         if (contact%b == body) b%position = position
         n_up = 0.0_wp
         call contact%find_gap(a, b, gap)
         if (contact%track%lost) return
         call contact%locate(a, b, gap, point)
         n_up = dot_product(point%normal, up)
         if (contact%a == body) n_up = -n_up
         if (present(at)) at = point
      end subroutine look

      !> Elastic force of all contacts on a body along the vertical less its load [N], whether rigid
      !> ones carry the rest, and the forces across the vertical.
      subroutine excess(body, position, force, stiffness, held, sideways)
         integer, intent(in) :: body
         real(wp), intent(in) :: position(3)
         real(wp), intent(out) :: force
         !> Its derivative with the height, the sign changed [N/m].
         real(wp), intent(out) :: stiffness
         logical, intent(out) :: held
         real(wp), intent(out) :: sideways(3)
         type(contact_point_type) :: at
         real(wp) :: gap, n_up, f
         integer :: c, trouble

         associate (spec => scene%bodies(body))
            force = dot_product(up, spec%mass*scene%gravity)
            if (spec%load_follows) then
               sideways = matmul(rotation_matrix(spec%quaternion), spec%applied_force)
            else
               sideways = spec%applied_force
            end if
            force = force + dot_product(up, sideways)
            sideways = sideways - dot_product(up, sideways)*up
         end associate
         stiffness = 0.0_wp
         held = .false.
         do c = 1, size(system%contacts)
            associate (contact => system%contacts(c))
               if (contact%spot > 1) cycle
               if (contact%a /= body .and. contact%b /= body) cycle
               call look(contact, body, position, gap, n_up, at)
               if (contact%track%lost .or. gap >= 0.0_wp) then
                  if (contact%rigid .and. gap <= 4.0_wp*rounding_at(position)) held = .true.
                  cycle
               end if
               if (contact%rigid) then
                  held = .true.
                  cycle
               end if
               call contact%follow(at, trouble)
               if (trouble /= trouble_none) cycle
               f = contact%law%normal%force(-gap)
               force = force + f*n_up
               stiffness = stiffness + 1.5_wp*f/(-gap)*n_up**2
               sideways = sideways + f*(merge(-at%normal, at%normal, contact%a == body) - n_up*up)
            end associate
         end do
      end subroutine excess

      !> Let the bodies that are to rest sink along gravity until their contacts carry them, all
      !> together, as the weight of the upper ones compresses the contacts of the lower ones. What a
      !> rigid contact holds stays.
      subroutine let_sink()
         type(system_type) :: bare
         type(statics_type) :: statics
         type(coordinate_type) :: coordinates(size(order))
         real(wp) :: force, stiffness, sideways(3)
         integer :: n, j
         logical :: held

         n = 0
         do j = 1, size(order)
            if (place(order(j)) /= place_rest) cycle
            call excess(order(j), scene%bodies(order(j))%position, force, stiffness, held, sideways)
            if (held .and. force < 0.0_wp) cycle
            n = n + 1
            coordinates(n) = coordinate_type(body=order(j), direction=up)
         end do
         if (n == 0) return
         call assemble_statics(scene, bare)
         call find_rest(bare, coordinates(:n), statics)
         if (statics%balanced) then
            do j = 1, n
               scene%bodies(coordinates(j)%body)%position = &
                  bare%pose(coordinates(j)%body)%position
            end do
         else
            call fail_for(max(statics%body, 1), "its contacts cannot carry it")
         end if
      end subroutine let_sink

      !> What is carried must not be pushed aside.
      subroutine check_sides(body)
         integer, intent(in) :: body
         real(wp) :: force, stiffness, sideways(3), weight
         logical :: held

         call excess(body, scene%bodies(body)%position, force, stiffness, held, sideways)
         weight = scene%bodies(body)%mass*norm2(scene%gravity)
         if (norm2(sideways) <= 1.0e-6_wp*weight) return
         call diagnostics%add(places(body), "body " // quote(scene%bodies(body)%name) // &
            " cannot rest where it is: the forces on it push it aside with " // &
            power_text(norm2(sideways), 3) // " N", "place = 'touch', or a position where the " // &
            "normal forces balance")
      end subroutine check_sides

   end subroutine put_down

   !> The bodies that are to be put down, from the lowest to the highest.
   pure subroutine sort(place, height, order)
      integer, intent(in) :: place(:)
      real(wp), intent(in) :: height(:)
      integer, intent(out) :: order(:)
      integer :: i, j, n

      n = 0
      do i = 1, size(place)
         if (place(i) == 0) cycle
         j = n
         do while (j > 0)
            if (height(order(j)) <= height(i)) exit
            order(j + 1) = order(j)
            j = j - 1
         end do
         order(j + 1) = i
         n = n + 1
      end do
   end subroutine sort

end module contensou_scene_placing
