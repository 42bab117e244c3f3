!> What concerns a scene as a whole: pairs of surfaces, overlaps at the beginning, and settings that
!> are derived from the scene.
module contensou_scene_checks
   use, intrinsic :: ieee_arithmetic, only : ieee_is_nan
   use contensou_base_diagnostics, only : diagnostics_type, origin_type
   use contensou_base_kinds, only : wp
   use contensou_base_numbers, only : power_text, rounded, to_text
   use contensou_base_schema, only : schema_type
   use contensou_base_settings, only : settings_type
   use contensou_base_resolve, only : largest_number
   use contensou_base_text, only : quote
   use contensou_contact_geometry, only : contact_point_type, contact_trouble, geometry_type, &
      pose_type, track_type, trouble_lost, trouble_no_spot, trouble_none, trouble_text
   use contensou_contact_normal, only : normal_rigid
   use contensou_contact_pairs, only : geometry_models, new_geometry
   use contensou_contact_parameters, only : surroundings_type
   use contensou_contact_tangential_law, only : join_materials
   use contensou_dynamics_assembly, only : contact_length, initial_pose, &
      largest_relative_approach, place_spots
   use contensou_dynamics_equations, only : system_type
   use contensou_dynamics_rests, only : touching_gap
   use contensou_dynamics_mechanism, only : contact_type
   use contensou_dynamics_scene, only : contact_spec_type, motion_rotor, motion_spindle, &
      moves_freely, scene_type
   use contensou_scene_contacts, only : creeps
   use contensou_scene_remedies, only : remedy
   implicit none(type, external)
   private

   public :: check_contacts, check_impacts, check_positions, check_rows, check_overlaps, fill_in

   !> Contacts by surface, as chains from the newest.
   type :: chains_type
      !> For each surface its newest contact, 0 for none, and how many it has.
      integer, allocatable :: newest(:), length(:)
      !> For both surfaces of each contact the one before it; 0 for none.
      integer, allocatable :: older(:, :)
   contains
      procedure :: add
      procedure :: twin_of
   end type chains_type

   !> Largest number of output rows.
   real(wp), parameter :: max_rows = 1.0e9_wp

contains

   !> A contact needs two different bodies, one of which yields, and a pair of shapes that is
   !> supported.
   subroutine check_contacts(scene, places, diagnostics)
      type(scene_type), intent(in) :: scene
      !> Where the surfaces of each contact are named.
      type(origin_type), intent(in) :: places(:)
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics
      class(geometry_type), allocatable :: geometry
      character(len=:), allocatable :: problem
      type(chains_type) :: seen
      real(wp) :: modulus, poisson
      integer :: i, twin

      allocate(seen%newest(size(scene%surfaces)), source=0)
      allocate(seen%length(size(scene%surfaces)), source=0)
      allocate(seen%older(2, size(scene%contacts)))
      do i = 1, size(scene%contacts)
         if (i > 1) call seen%add(i - 1, scene%contacts(i - 1)%surfaces)
         associate (a => scene%surfaces(scene%contacts(i)%surfaces(1)), &
            b => scene%surfaces(scene%contacts(i)%surfaces(2)), place => places(i))
            if (a%body == b%body) then
               call diagnostics%add(place, "surfaces " // quote(a%name) // " and " // &
                  quote(b%name) // " of contact " // quote(scene%contacts(i)%name) // &
                  " belong to the same body", "surfaces of two bodies")
               cycle
            end if
            twin = seen%twin_of(scene%contacts, places, i)
            if (twin > 0) then
               call diagnostics%add(place, "surfaces " // quote(a%name) // " and " // &
                  quote(b%name) // " of contact " // quote(scene%contacts(i)%name) // &
                  " are those of contact " // quote(scene%contacts(twin)%name) // &
                  ", too: their forces would add up", "one contact for a pair of surfaces")
               cycle
            end if
            if (.not. moves(scene, a%body) .and. .not. moves(scene, b%body)) then
               call diagnostics%add(place, "contact " // quote(scene%contacts(i)%name) // &
                  ": neither of its bodies is free", "a body whose motion is 'free'")
               cycle
            end if
            if (scene%contacts(i)%normal == normal_rigid .and. &
               (spins(scene, a%body) .or. spins(scene, b%body))) then
               call diagnostics%add(place, "contact " // quote(scene%contacts(i)%name) // &
                  ": a rigid contact cannot carry a body whose motion is 'spindle' or 'rotor'", &
                  "normal = 'hertz' or 'vilke'")
               cycle
            end if
            call new_geometry(a%surface, b%surface, geometry, problem)
            if (.not. allocated(geometry)) call diagnostics%add(place, "surfaces " // &
               quote(a%name) // " and " // quote(b%name) // " of contact " // &
               quote(scene%contacts(i)%name) // ": " // problem, &
               "surfaces that touch in a point, of one of the pairs (" // pairs() // ")")
            if (.not. creeps(scene%contacts(i))) cycle
            call join_materials(surroundings_type(young=scene%materials([a%material, &
               b%material])%young, poisson=scene%materials([a%material, b%material])%poisson), &
               modulus, poisson)
            if (poisson < 0.0_wp) call diagnostics%add(place, "Poisson's ratio of both bodies " &
               // "of contact " // quote(scene%contacts(i)%name) // " together is " // &
               to_text(rounded(poisson, 3)) // ", and laws of creep are for 0 to 0.5", &
               "materials with poisson >= 0, or tangential = 'elastic' without creep")
         end associate
      end do
   end subroutine check_contacts

   !> Put a contact before those of its surfaces.
   pure subroutine add(self, contact, pair)
      class(chains_type), intent(inout) :: self
      integer, intent(in) :: contact
      !> Its surfaces.
      integer, intent(in) :: pair(2)
      integer :: side

      do side = 1, merge(1, 2, pair(1) == pair(2))
         self%older(side, contact) = self%newest(pair(side))
         self%newest(pair(side)) = contact
         self%length(pair(side)) = self%length(pair(side)) + 1
      end do
   end subroutine add

   !> The first contact with the surfaces of another one that is written elsewhere; 0 for none.
   pure integer function twin_of(self, contacts, places, contact)
      class(chains_type), intent(in) :: self
      type(contact_spec_type), intent(in) :: contacts(:)
      !> Where the surfaces of each contact are named.
      type(origin_type), intent(in) :: places(:)
      integer, intent(in) :: contact
      integer :: k, side

      twin_of = 0
      associate (pair => contacts(contact)%surfaces)
         ! The shorter chain: all bodies may touch one floor.
         side = merge(1, 2, self%length(pair(1)) <= self%length(pair(2)))
         k = self%newest(pair(side))
         do while (k > 0)
            associate (other => contacts(k)%surfaces, p => places(contact), q => places(k))
               ! One contact as written may stand for several.
               if (all(pair == other) .or. all(pair == other([2, 1]))) then
                  if (p%source /= q%source .or. p%line /= q%line .or. p%column /= q%column) then
                     twin_of = k
                  end if
               end if
               k = self%older(merge(1, 2, other(1) == pair(side)), k)
            end associate
         end do
      end associate
   end function twin_of

   !> Whether a body is a spindle or a rotor.
   pure logical function spins(scene, body)
      type(scene_type), intent(in) :: scene
      !> Index of the body; 0 for the ground.
      integer, intent(in) :: body

      spins = .false.
      if (body > 0) spins = any(scene%bodies(body)%motion == [motion_spindle, motion_rotor])
   end function spins

   !> Whether a body yields to a contact.
   pure logical function moves(scene, body)
      type(scene_type), intent(in) :: scene
      !> Index of the body; 0 for the ground.
      integer, intent(in) :: body

      moves = .false.
      if (body > 0) moves = moves_freely(scene%bodies(body)%motion)
   end function moves

   !> Supported pairs, in words.
   function pairs() result(text)
      character(len=:), allocatable :: text
      integer :: k

      associate (models => geometry_models())
         text = trim(models(1)%name)
         do k = 2, size(models)
            text = text // "; " // trim(models(k)%name)
         end do
      end associate
   end function pairs

   !> Only rigid contacts have impacts that could be taken together.
   subroutine check_impacts(scene, place, diagnostics)
      type(scene_type), intent(in) :: scene
      !> Where it is said how impacts are taken.
      type(origin_type), intent(in) :: place
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics

      if (.not. scene%together .or. any(scene%contacts%normal == normal_rigid)) return
      call diagnostics%add(place, "impacts has no meaning: no contact is rigid", &
         "a contact with normal = 'rigid', or no impacts")
   end subroutine check_impacts

   !> The output must not have too many rows.
   subroutine check_rows(scene, place, diagnostics)
      type(scene_type), intent(in) :: scene
      !> Where the interval of the output is given.
      type(origin_type), intent(in) :: place
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics

      if (scene%output%interval > 0.0_wp .and. scene%t_end > max_rows*scene%output%interval) then
         call diagnostics%add(place, "the output would have more than " // &
            to_text(nint(max_rows)) // " rows", "a larger output.interval")
      end if
   end subroutine check_rows

   !> Derive the settings that depend on the scene.
   subroutine fill_in(settings, schema, scene, system)
      type(settings_type), intent(inout), target :: settings
      type(schema_type), intent(in), target :: schema
      type(scene_type), intent(inout) :: scene
      !> Its equations of motion; left as they were.
      type(system_type), intent(in) :: system
      integer :: i

      if (scene%output%interval <= 0.0_wp) scene%output%interval = 1.0e-3_wp*scene%t_end
      if (scene%integrator%length_scale <= 0.0_wp) scene%integrator%length_scale = &
         contact_length(scene, system, scene%integrator%velocity_scale)
      ! What is derived is a number that a scene may give.
      scene%output%interval = max(scene%output%interval, 1.0_wp/largest_number)
      scene%integrator%length_scale = min(max(scene%integrator%length_scale, &
         1.0_wp/largest_number), largest_number)
      do i = 1, size(settings%groups)
         associate (group => settings%group(i, schema))
            select case (group%group_name())
            case ("output")
               call group%derive_number("interval", scene%output%interval)
            case ("integrator")
               call group%derive_number("length_scale", scene%integrator%length_scale)
            case default
               ! Nothing in the other groups is derived.
            end select
         end associate
      end do
   end subroutine fill_in

   !> Bodies so far from the origin that the rounding of their positions hides what contacts do.
   subroutine check_positions(scene, system, places, diagnostics)
      type(scene_type), intent(in) :: scene
      !> Its equations of motion.
      type(system_type), intent(in) :: system
      !> Where the position of each body is given.
      type(origin_type), intent(in) :: places(:)
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics
      real(wp), dimension(size(scene%bodies)) :: largest, limit
      integer :: tightest(size(scene%bodies)), body(2), i, k

      do i = 1, size(scene%bodies)
         largest(i) = maxval(abs(scene%bodies(i)%position))
      end do
      limit = largest
      tightest = 0
      do i = 1, size(system%contacts)
         associate (contact => system%contacts(i))
            body = [contact%a, contact%b]
            do k = 1, 2
               if (body(k) == 0) cycle
               if (contact%largest_position >= limit(body(k))) cycle
               tightest(body(k)) = i
               limit(body(k)) = contact%largest_position
            end do
         end associate
      end do
      do i = 1, size(scene%bodies)
         if (tightest(i) == 0) cycle
         call diagnostics%add(places(i), "body " // quote(scene%bodies(i)%name) // ": " // &
            short(largest(i)) // " m from the origin a position is rounded by " // &
            short(spacing(largest(i))) // " m, which is not small against the overlaps of " // &
            "contact " // quote(scene%contacts(tightest(i))%name), "coordinates of at most " // &
            short(limit(i)) // " m, for which the origin may be moved")
      end do
   end subroutine check_positions

   !> Surfaces that overlap too much or conform at the beginning.
   subroutine check_overlaps(scene, system, places, diagnostics)
      type(scene_type), intent(in) :: scene
      !> Its equations of motion; left as they were.
      type(system_type), intent(inout) :: system
      !> Where the surfaces of each contact are named.
      type(origin_type), intent(in) :: places(:)
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics
      type(pose_type) :: pose(0:size(scene%bodies))
      type(track_type) :: track
      integer :: i, trouble

      do i = 0, size(scene%bodies)
         pose(i) = initial_pose(scene, i)
      end do
      if (system%several_spots) then
         call place_spots(scene, system, i, trouble)
         if (i > 0) then
            call diagnostics%add(places(i), "contact " // quote(scene%contacts(i)%name) // &
               " at the beginning: " // trouble_text(trouble), "surfaces that are closest in " // &
               "at most " // to_text(scene%contacts(i)%spots) // " points")
            return
         end if
      end if
      do i = 1, size(system%contacts)
         associate (contact => system%contacts(i))
            track = contact%track
            call check_overlap(scene, scene%contacts(i), contact, pose(contact%a), &
               pose(contact%b), places(i), diagnostics)
            contact%track = track
         end associate
      end do
   end subroutine check_overlaps

   !> Whether the surfaces of a contact overlap too much or conform at the beginning.
   subroutine check_overlap(scene, spec, contact, pose_a, pose_b, place, diagnostics)
      type(scene_type), intent(in) :: scene
      type(contact_spec_type), intent(in) :: spec
      !> The contact; its track is changed.
      type(contact_type), intent(inout) :: contact
      !> Poses of its bodies.
      type(pose_type), intent(in) :: pose_a, pose_b
      !> Where its surfaces are named.
      type(origin_type), intent(in) :: place
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics
      type(contact_point_type) :: at
      real(wp) :: gap, deepest
      integer :: trouble

      if (ieee_is_nan(contact%law%normal%stiffness)) then
         call diagnostics%add(place, "the stiffness of contact " // quote(spec%name) // &
            " is beyond what can be computed with", &
            "curvatures of the surfaces of 1e-38 to 1e38 per metre and moduli of 1e-38 to 1e38 Pa")
         return
      end if
      ! It never has one, so that this need not wait for the surfaces to touch.
      if (contact%law%geometry%constant_curvatures .and. &
         ieee_is_nan(contact%law%normal%axis_a)) then
         call add_trouble(scene, spec, trouble_no_spot, place, diagnostics)
         return
      end if
      call contact%find_gap(pose_a, pose_b, gap)
      if (contact%rigid .and. -gap > touching_gap(contact)) then
         call diagnostics%add(place, "the surfaces of the rigid contact " // &
            quote(spec%name) // " overlap by " // short(-gap) // &
            " m at the beginning", "a position with a gap of zero, to " // &
            short(touching_gap(contact)) // " m, or a positive one" // &
            what_helps(scene, spec, contact, pose_a, pose_b))
         return
      end if
      deepest = contact%deepest(pose_a, pose_b, gap)
      if (-gap > deepest) then
         call diagnostics%add(place, "the surfaces of contact " // quote(spec%name) // &
            " overlap by " // short(-gap) // " m at the beginning", "at most " // &
            short(deepest) // " m, " // short(largest_relative_approach) // &
            " of the smallest radius of curvature" // less_in_hollow(scene, spec) // &
            what_helps(scene, spec, contact, pose_a, pose_b))
         return
      end if
      trouble = trouble_none
      if (contact%track%lost) then
         trouble = trouble_lost
      else if (gap < 0.0_wp) then
         call contact%locate(pose_a, pose_b, gap, at)
         trouble = contact_trouble(contact%track, at)
         if (trouble == trouble_none .and. ieee_is_nan(contact%law%normal%axis_a)) then
            trouble = trouble_no_spot
         end if
      end if
      if (trouble /= trouble_none) call add_trouble(scene, spec, trouble, place, diagnostics)
   end subroutine check_overlap

   !> Say why two surfaces cannot touch.
   subroutine add_trouble(scene, spec, trouble, place, diagnostics)
      type(scene_type), intent(in) :: scene
      type(contact_spec_type), intent(in) :: spec
      !> One of the `trouble_*` codes.
      integer, intent(in) :: trouble
      !> Where the surfaces are named.
      type(origin_type), intent(in) :: place
      type(diagnostics_type), intent(inout) :: diagnostics
      character(len=:), allocatable :: right

      right = "surfaces that are closest in one point"
      if (trouble == trouble_no_spot) right = &
         "one of these two, or curvatures that differ less"
      call diagnostics%add(place, "surfaces " // &
         quote(scene%surfaces(spec%surfaces(1))%name) // " and " // &
         quote(scene%surfaces(spec%surfaces(2))%name) // " of contact " // &
         quote(spec%name) // " at the beginning: " // trouble_text(trouble), right)
   end subroutine add_trouble

   !> What reduces the bound of an overlap; blank if nothing does.
   pure function less_in_hollow(scene, spec) result(text)
      type(scene_type), intent(in) :: scene
      type(contact_spec_type), intent(in) :: spec
      character(len=:), allocatable :: text

      text = ""
      if (any(scene%surfaces(spec%surfaces)%surface%inside)) text = &
         ", less in a concave surface"
   end function less_in_hollow

   !> What would keep surfaces from overlapping, behind a semicolon; blank if nothing is known.
   function what_helps(scene, spec, contact, pose_a, pose_b) result(text)
      type(scene_type), intent(in) :: scene
      type(contact_spec_type), intent(in) :: spec
      !> The contact; its track is changed.
      type(contact_type), intent(inout) :: contact
      !> Poses of its bodies.
      type(pose_type), intent(in) :: pose_a, pose_b
      character(len=:), allocatable :: text

      text = remedy(scene, spec, contact, pose_a, pose_b)
      if (text /= "") text = "; " // text
   end function what_helps

   !> A number with four digits.
   function short(x) result(text)
      !> The number.
      real(wp), intent(in) :: x
      character(len=:), allocatable :: text

      text = power_text(x, 4)
      if (x >= 1.0e-2_wp .and. x < 1.0e3_wp) text = to_text(rounded(x, 4))
   end function short

end module contensou_scene_checks
