!> Reads groups `contact`.
module contensou_scene_contacts
   use contensou_base_diagnostics, only : diagnostics_type, origin_type
   use contensou_base_kinds, only : wp
   use contensou_base_numbers, only : to_text
   use contensou_base_settings, only : group_settings_type
   use contensou_base_text, only : quote
   use contensou_contact_creep, only : creep_model_type, creep_models, default_creep
   use contensou_contact_damping, only : damping_model_type, damping_models
   use contensou_contact_friction, only : friction_model_type, friction_models
   use contensou_contact_geometry, only : geometry_type
   use contensou_contact_normal, only : normal_rigid
   use contensou_contact_pairs, only : new_geometry
   use contensou_contact_parts, only : n_parts, part_type, read_models
   use contensou_contact_tangential, only : tangential_model_type, tangential_models
   use contensou_contact_tangential_law, only : creep_key
   use contensou_dynamics_scene, only : contact_spec_type, scene_type
   use contensou_scene_references, only : references_type
   implicit none(type, external)
   private

   public :: build_contact, add_spots, remembers, creeps, without_stick

   !> Friction whose limit steady rolling has, and that of curved spots.
   character(len=*), parameter :: exact_friction = "contensou_exact"

   !> Friction without a torque.
   character(len=*), parameter :: without_torque = "coulomb"

   !> Law of creep with which nothing sticks.
   character(len=*), parameter :: without_stick = "sliding"

contains

   !> Read a contact.
   subroutine build_contact(group, references, parts, contact, diagnostics)
      type(group_settings_type), intent(in) :: group
      !> Names of the scene.
      type(references_type), intent(in) :: references
      !> The parts of a contact.
      type(part_type), intent(in) :: parts(:)
      type(contact_spec_type), intent(inout) :: contact
      type(diagnostics_type), intent(inout) :: diagnostics
      type(damping_model_type), allocatable :: dampings(:)
      integer :: choice(n_parts)

      contact%name = group%label()
      call references%find(group, "surfaces", 1, contact%surfaces(1), diagnostics)
      call references%find(group, "surfaces", 2, contact%surfaces(2), diagnostics)
      call read_models(group, parts, choice, contact%parameters, diagnostics)
      contact%normal = choice(1)
      contact%damping = choice(2)
      contact%friction = choice(3)
      contact%rolling = choice(4)
      contact%tangential = choice(5)
      contact%curvature = choice(6)
      if (parts(5)%models(contact%tangential)%acts) call check_tangential()
      if (parts(6)%models(contact%curvature)%acts) call check_curved()
      if (contact%normal /= normal_rigid) return
      dampings = damping_models()
      associate (damping => dampings(contact%damping))
         if (.not. associated(damping%restitute)) call diagnostics%add( &
            group%place("damping", 1), "damping " // quote(trim(damping%info%name)) // &
            " has no meaning for a rigid contact", &
            "restitution without damping, or damping = 'hunt_crossley'")
      end associate

   contains

      !> Report what tangential elasticity and steady rolling do not go with.
      subroutine check_tangential()
         type(friction_model_type), allocatable :: models(:)
         type(creep_model_type), allocatable :: laws(:)
         character(len=:), allocatable :: what
         logical :: fits, transient

         transient = remembers(contact%tangential) .and. contact%parameters%has(creep_key)
         what = "tangential elasticity"
         if (transient) what = what // " with a law of creep"
         if (.not. remembers(contact%tangential)) what = "steady rolling"
         if (contact%normal == normal_rigid .and. .not. remembers(contact%tangential)) call &
            diagnostics%add(group%place("tangential", 1), what // &
            " is not available for a rigid contact", &
            "tangential = 'elastic' and creep = 'table', or normal = 'hertz'")
         models = friction_models()
         associate (model => models(contact%friction))
            fits = model%info%name == exact_friction
            if (remembers(contact%tangential) .and. .not. transient) fits = &
               associated(model%jacobian)
            if (.not. fits) call diagnostics%add(group%place("tangential", 1), &
               what // " is not available with friction = " // quote(trim(model%info%name)), &
               "friction = " // quote(exact_friction) // ", or tangential = 'none'")
            if (model%info%name == without_torque) return
         end associate
         if (transient) then
            laws = creep_models()
            associate (law => laws(nint(contact%parameters%number(creep_key))))
               if (law%info%name == without_stick) call diagnostics%add(group%place(creep_key, 1), &
                  "nothing sticks with creep = " // quote(without_stick) // ", so that nothing " &
                  // "is left to remember", "creep = " // quote(default_creep) // &
                  ", or tangential = 'none'")
            end associate
         end if
         if (contact%parameters%number("regularization_velocity") > 0.0_wp) call diagnostics%add( &
            group%place("regularization_velocity", 1), "a regularization_velocity has no " // &
            "meaning with " // what // ", where friction does not jump", &
            "regularization_velocity = 0.0")
         if (contact%parameters%has("drilling")) then
            if (.not. contact%parameters%flag("drilling")) call diagnostics%add( &
               group%place("drilling", 1), what // " is not available without the drilling " // &
               "torque", "drilling = .true., or tangential = 'none'")
         end if
      end subroutine check_tangential

      !> Report what a curved spot does not go with.
      subroutine check_curved()
         if (contact%normal == normal_rigid) call diagnostics%add(group%place("spot", 1), &
            "a curved spot is not available for a rigid contact", &
            "normal = 'hertz', or spot = 'flat'")
         associate (model => parts(3)%models(contact%friction)%info%name)
            if (model /= exact_friction) call diagnostics%add(group%place("spot", 1), &
               "a curved spot is not available with friction = " // quote(trim(model)), &
               "friction = " // quote(exact_friction) // ", or spot = 'flat'")
         end associate
         associate (model => parts(5)%models(contact%tangential))
            if (model%acts) call diagnostics%add(group%place("spot", 1), &
               "a curved spot is not available with tangential = " &
               // quote(trim(model%info%name)), "tangential = 'none', or spot = 'flat'")
         end associate
         if (contact%parameters%has("drilling")) then
            if (.not. contact%parameters%flag("drilling")) call diagnostics%add( &
               group%place("drilling", 1), "a curved spot is not available without the " // &
               "drilling torque", "drilling = .true., or spot = 'flat'")
         end if
      end subroutine check_curved

   end subroutine build_contact

   !> Whether a tangential model remembers what was.
   logical function remembers(model)
      !> Its position in the table.
      integer, intent(in) :: model
      type(tangential_model_type), allocatable :: models(:)

      models = tangential_models()
      remembers = associated(models(model)%put_states)
   end function remembers

   !> Whether a contact has a law of creep.
   logical function creeps(contact)
      type(contact_spec_type), intent(in) :: contact
      type(tangential_model_type), allocatable :: models(:)

      models = tangential_models()
      associate (model => models(contact%tangential))
         creeps = model%steady
         if (.not. creeps) creeps = model%uses(creep_key) .and. contact%parameters%has(creep_key)
      end associate
   end function creeps

   !> Replace each contact that may have several spots by one for each of them, `name[1]`, `name[2]`
   !> and so on.
   subroutine add_spots(scene, places, diagnostics)
      !> The scene; its pairs of surfaces are supported.
      type(scene_type), intent(inout) :: scene
      !> Where the surfaces of each contact are named.
      type(origin_type), allocatable, intent(inout) :: places(:)
      !> Mistakes are appended here.
      type(diagnostics_type), intent(inout) :: diagnostics
      type(contact_spec_type), allocatable :: contacts(:)
      type(origin_type), allocatable :: new_places(:)
      class(geometry_type), allocatable :: geometry
      integer :: spots(size(scene%contacts)), i, k, n

      do i = 1, size(spots)
         associate (indices => scene%contacts(i)%surfaces)
            call new_geometry(scene%surfaces(indices(1))%surface, &
               scene%surfaces(indices(2))%surface, geometry)
         end associate
         spots(i) = geometry%most_spots
      end do
      if (all(spots == 1)) return
      allocate(contacts(sum(spots)), new_places(sum(spots)))
      n = 0
      do i = 1, size(spots)
         do k = 1, spots(i)
            n = n + 1
            contacts(n) = scene%contacts(i)
            contacts(n)%spot = k
            contacts(n)%spots = spots(i)
            new_places(n) = places(i)
            if (spots(i) == 1) cycle
            contacts(n)%name = scene%contacts(i)%name // "[" // to_text(k) // "]"
            call check_name(contacts(n)%name, scene%contacts(i)%name)
         end do
      end do
      ! A condition about a contact is about all of its spots; it has the index of the first.
      do i = 1, size(scene%stops)
         associate (contact => scene%stops(i)%contact)
            if (contact > 0) contact = 1 + sum(spots(:contact - 1))
         end associate
      end do
      call move_alloc(contacts, scene%contacts)
      call move_alloc(new_places, places)

   contains

      !> No other contact may have the name of a spot.
      subroutine check_name(name, of)
         character(len=*), intent(in) :: name
         !> Name of the contact that the spot belongs to.
         character(len=*), intent(in) :: of
         integer :: j

         do j = 1, size(spots)
            if (scene%contacts(j)%name == name) call diagnostics%add(places(j), "contact " // &
               quote(name) // " has the name of a spot of contact " // quote(of), "another name")
         end do
      end subroutine check_name

   end subroutine add_spots

end module contensou_scene_contacts
