!> Mass, moments of inertia and centre of mass of bodies from their surfaces and `density`, or from
!> radii of gyration.
module contensou_scene_solids
   use contensou_base_diagnostics, only : diagnostics_type, origin_type
   use contensou_base_kinds, only : wp
   use contensou_base_numbers, only : to_text
   use contensou_base_resolve, only : largest_number
   use contensou_base_schema, only : schema_type
   use contensou_base_settings, only : group_settings_type, settings_type
   use contensou_base_text, only : quote
   use contensou_contact_shapes_shape, only : solid_type
   use contensou_dynamics_scene, only : body_spec_type, scene_type, surface_spec_type
   use contensou_scene_references, only : references_type
   implicit none(type, external)
   private

   public :: is_solid, weigh_bodies

   !> Largest product of inertia, of the largest moment, that counts as rounding.
   real(wp), parameter :: rounding = 1.0e-12_wp

contains

   !> Whether a body leaves its mass or inertia to be found.
   logical function is_solid(group)
      !> The group `body`.
      type(group_settings_type), intent(in) :: group

      is_solid = group%is_given("density") .or. group%is_given("solid") .or. &
         group%is_given("radius_of_gyration") .or. group%is_given("solid_length") .or. &
         group%is_given("solid_part")
   end function is_solid

   !> Find mass, inertia and centre of mass of the bodies that are solids.
   subroutine weigh_bodies(settings, schema, references, scene, diagnostics)
      !> The settings; what is found is filled in.
      type(settings_type), intent(inout), target :: settings
      type(schema_type), intent(in), target :: schema
      !> Names of the scene.
      type(references_type), intent(in) :: references
      type(scene_type), intent(inout) :: scene
      type(diagnostics_type), intent(inout) :: diagnostics
      type(group_settings_type) :: group
      logical :: moved(0:size(scene%bodies))
      real(wp) :: centre(3)
      integer :: i, k, n

      moved = .false.
      do i = 1, size(settings%groups)
         group = settings%group(i, schema)
         if (group%group_name() /= "body") cycle
         if (.not. is_solid(group)) cycle
         n = references%numbers(i)
         call weigh(group, references, scene%bodies(n), n, scene%surfaces, moved(n), centre, &
            diagnostics)
         if (.not. moved(n)) cycle
         do k = 1, size(scene%springs)
            associate (spring => scene%springs(k))
               if (spring%a == n .and. spring%placed(1)) spring%point(:, 1) = &
                  spring%point(:, 1) - centre
               if (spring%b == n .and. spring%placed(2)) spring%point(:, 2) = &
                  spring%point(:, 2) - centre
            end associate
         end do
      end do
      if (.not. any(moved)) return
      do i = 1, size(settings%groups)
         group = settings%group(i, schema)
         if (group%group_name() /= "surface") cycle
         associate (surface => scene%surfaces(references%numbers(i)))
            if (moved(surface%body)) call group%derive_numbers("centre", surface%surface%centre)
         end associate
      end do
   end subroutine weigh_bodies

   !> Find mass, inertia and centre of mass of a body. Its surfaces get coordinates whose origin is
   !> that centre.
   subroutine weigh(group, references, body, number, surfaces, moved, centre, &
      diagnostics)
      !> The group `body`; mass and inertia are derived.
      type(group_settings_type), intent(in) :: group
      !> Names of the scene.
      type(references_type), intent(in) :: references
      type(body_spec_type), intent(inout) :: body
      !> Number of the body.
      integer, intent(in) :: number
      !> The surfaces of the scene.
      type(surface_spec_type), intent(inout) :: surfaces(:)
      !> Whether its surfaces have got other coordinates.
      logical, intent(out) :: moved
      !> Its centre of mass in the old ones [m]; set if they have.
      real(wp), intent(out) :: centre(3)
      type(diagnostics_type), intent(inout) :: diagnostics
      type(solid_type) :: solid
      real(wp) :: tensor(3, 3), gyration(3)
      integer :: before, i, k

      moved = .false.
      centre = 0.0_wp
      before = diagnostics%count()
      call check_keys(group, diagnostics)
      if (diagnostics%count() > before) return
      if (group%is_given("radius_of_gyration")) then
         gyration = group%numbers("radius_of_gyration")
         k = group%count("radius_of_gyration")
         if (k == 1) gyration = gyration(1)
         if (k == 2) call diagnostics%add(group%place("radius_of_gyration", 2), &
            "'radius_of_gyration' has two values", "one number or three")
         call take(body%mass, gyration**2, "radius_of_gyration")
         return
      end if
      call find_solid(group, references, body, number, surfaces, k, solid, diagnostics)
      if (k == 0) return
      associate (surface => surfaces(k)%surface)
         centre = surface%centre + matmul(surface%frame, solid%centre)
         do i = 1, 3
            tensor(:, i) = surface%frame(:, i)*solid%gyration(i)
         end do
         tensor = matmul(tensor, transpose(surface%frame))
      end associate
      do i = 1, 3
         gyration(i) = tensor(i, i)
         tensor(i, i) = 0.0_wp
      end do
      if (maxval(abs(tensor)) > rounding*maxval(gyration)) then
         call diagnostics%add(place_of_solid(group), "the axes of body " // quote(body%name) // &
            " are not those of its solid: products of inertia are not zero", &
            "axis and angle of the body, not of its surface " // quote(surfaces(k)%name))
         return
      end if
      surfaces(k)%solid_part = max(1, group%choice("solid_part"))
      if (solid%cut) surfaces(k)%solid_length = group%number("solid_length")
      if (group%is_given("density")) then
         call take(group%number("density")*solid%volume, gyration, "density")
      else
         call take(body%mass, gyration, "mass")
      end if
      if (diagnostics%count() > before .or. all(abs(centre) <= 0.0_wp)) return
      moved = .true.
      do i = 1, size(surfaces)
         if (surfaces(i)%body == number) surfaces(i)%surface%centre = &
            surfaces(i)%surface%centre - centre
      end do

   contains

      !> Take what was found.
      subroutine take(mass, squares, source)
         real(wp), intent(in) :: mass
         !> Squares of the radii of gyration [m2].
         real(wp), intent(in) :: squares(3)
         !> The key that it comes from.
         character(len=*), intent(in) :: source
         character(len=*), parameter :: sources(*) = [character(len=18) :: "density", "solid", &
            "solid_length", "solid_part", "radius_of_gyration"]
         integer :: k

         if (diagnostics%count() > before) return
         body%mass = mass
         body%inertia = mass*squares
         if (any([mass, body%inertia] > largest_number) .or. &
            any([mass, body%inertia] < 1.0_wp/largest_number)) call diagnostics%add( &
            group%place(source, 1), "mass " // to_text(mass) // " kg and inertia " // &
            to_text(maxval(body%inertia)) // " kg m2 of " // quote(body%name) // " follow", &
            "numbers from " // to_text(1.0_wp/largest_number) // " to " // to_text(largest_number))
         if (diagnostics%count() > before) return
         call group%derive_number("mass", mass)
         call group%derive_numbers("inertia", body%inertia)
         do k = 1, size(sources)
            call group%unset(trim(sources(k)))
         end do
      end subroutine take

   end subroutine weigh

   !> Keys that exclude or need each other.
   subroutine check_keys(group, diagnostics)
      type(group_settings_type), intent(in) :: group
      type(diagnostics_type), intent(inout) :: diagnostics

      if (group%is_given("density")) call group%refuse("mass", "the mass is given twice", &
         "either density or mass", diagnostics)
      if (group%is_given("radius_of_gyration")) then
         call group%refuse("inertia", "the inertia is given twice", &
            "either radius_of_gyration or inertia", diagnostics)
         call refuse_with("density")
         call refuse_with("solid")
         call refuse_with("solid_length")
         call refuse_with("solid_part")
         if (.not. group%is_given("density")) call group%require("mass", &
            group%place("radius_of_gyration"), "'radius_of_gyration' needs 'mass'", &
            "mass = a number > 0.0 [kg]", diagnostics)
         return
      end if
      call group%refuse("inertia", "the inertia is given twice: it follows from the solid", &
         "either inertia, with mass, or a solid", diagnostics)
      if (.not. group%is_given("density")) call group%require("mass", place_of_solid(group), &
         "a solid needs its density", "density = a number > 0.0 [kg m-3], or mass", diagnostics)

   contains

      !> A key that has no meaning beside radii of gyration.
      subroutine refuse_with(name)
         character(len=*), intent(in) :: name

         call group%refuse(name, "'" // name // "' beside 'radius_of_gyration'", &
            "either a solid or radius_of_gyration, with mass", diagnostics)
      end subroutine refuse_with

   end subroutine check_keys

   !> Find the surface that bounds a body, and its solid.
   subroutine find_solid(group, references, body, number, surfaces, k, found, diagnostics)
      type(group_settings_type), intent(in) :: group
      type(references_type), intent(in) :: references
      type(body_spec_type), intent(in) :: body
      !> Number of the body.
      integer, intent(in) :: number
      type(surface_spec_type), intent(in) :: surfaces(:)
      !> Number of the surface; 0 after a mistake.
      integer, intent(out) :: k
      type(solid_type), intent(out) :: found
      type(diagnostics_type), intent(inout) :: diagnostics
      type(origin_type) :: place
      integer :: before, n, part

      call references%find(group, "solid", 1, k, diagnostics)
      if (group%is_given("solid") .and. k == 0) return
      before = diagnostics%count()
      place = place_of_solid(group)
      n = count(surfaces%body == number)
      if (k > 0) then
         if (surfaces(k)%body /= number) call diagnostics%add(group%place("solid", 1), &
            "surface " // quote(surfaces(k)%name) // " is not on body " // quote(body%name), &
            "a surface of the body")
      else if (n == 1) then
         k = findloc(surfaces%body, number, dim=1)
      else if (n == 0) then
         call diagnostics%add(place, "body " // quote(body%name) // " has no surface that bounds " &
            // "its solid", "a group &surface with body = " // quote(body%name))
      else
         call diagnostics%add(place, "body " // quote(body%name) // " has " // to_text(n) // &
            " surfaces, of which one bounds its solid", "solid = the name of that surface")
      end if
      if (diagnostics%count() > before) k = 0
      if (k == 0) return
      associate (surface => surfaces(k)%surface)
         if (.not. allocated(surface%shape)) then
            k = 0
            return
         end if
         part = 0
         select case (group%choice("solid_part"))
         case (2)
            part = -1
         case (3)
            part = 1
         case default
            continue
         end select
         call surface%shape%solid(part, group%number("solid_length"), found)
         if (surface%inside .or. .not. (found%volume > 0.0_wp .or. found%cut)) then
            call diagnostics%add(place, surface%words() // " bounds no solid", &
               "the outside of a sphere, an ellipsoid, a torus, or of a cylinder, cone or " // &
               "paraboloid with solid_length; otherwise mass and inertia")
         else if (found%cut) then
            call group%require("solid_length", place, surface%words() // " has no ends", &
               "solid_length = a number > 0.0 [m]", diagnostics)
         else
            call group%refuse("solid_length", surface%words() // " has a length of its own", &
               "no solid_length", diagnostics)
         end if
         if (part /= 0 .and. .not. found%has_halves) call group%refuse("solid_part", &
            surface%words() // " has no halves here", "solid_part = 'whole'", diagnostics)
      end associate
      if (diagnostics%count() > before) k = 0
   end subroutine find_solid

   !> Where it is said that a body is a solid.
   type(origin_type) function place_of_solid(group) result(place)
      type(group_settings_type), intent(in) :: group

      place = group%place("solid_part")
      if (group%is_given("solid_length")) place = group%place("solid_length")
      if (group%is_given("solid")) place = group%place("solid")
      if (group%is_given("density")) place = group%place("density")
   end function place_of_solid

end module contensou_scene_solids
