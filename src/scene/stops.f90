!> Keys and reader of groups `stop`: conditions that end a run.
module contensou_scene_stops
   use contensou_base_diagnostics, only : diagnostics_type, origin_type
   use contensou_base_kinds, only : pi, wp
   use contensou_base_schema, only : domain_text, key_list_type, kind_choice, kind_name, &
      kind_real, kind_reference
   use contensou_base_settings, only : group_settings_type
   use contensou_base_text, only : quote
   use contensou_dynamics_scene, only : crossing_names, moves_freely, scene_type, stop_names, &
      stop_rest, stop_spec_type
   use contensou_scene_references, only : references_type
   implicit none(type, external)
   private

   public :: put_stop_keys, build_stop, complete_stops

   !> Speed that stands for rest where no energy is given [m/s].
   real(wp), parameter :: slow = 1.0e-3_wp

   !> Keys of a group `stop` that some conditions have.
   character(len=*), parameter :: own_keys(*) = [character(len=16) :: "body", "contact", &
      "kinetic_energy", "duration", "angle", "axis", "speed", "angular_velocity", "position", &
      "direction", "crossing"]

   !> Which of them each condition has, in the order of `stop_names`.
   character(len=*), parameter :: keys_of(size(stop_names)) = [character(len=40) :: &
      "body kinetic_energy duration", "contact", "contact", "body angle axis direction crossing", &
      "body speed crossing", "body angular_velocity crossing", &
      "body position direction crossing", "contact"]

   !> The key of the threshold of each condition; blank if it has none that must be given.
   character(len=*), parameter :: threshold_keys(size(stop_names)) = [character(len=16) :: "", "", &
      "", "angle", "speed", "angular_velocity", "position", ""]

contains

   !> The keys of a stop condition.
   subroutine put_stop_keys(list)
      type(key_list_type), intent(inout) :: list
      character(len=*), parameter :: g = "stop"

      call list%put(g, "name", kind_name, doc="name of the condition, for the summary and the " // &
         "output file; not given, it is that of when")
      call list%put(g, "when", kind_choice, words=stop_names, mandatory=.true., &
         doc="what ends the run: rest (of bodies, for a duration), touch or lift (of surfaces" // &
         "), angle (of an axis of the body with a direction), speed, spin (angular velocity) " // &
         "or position of the body, each where it crosses its value, or conforming (surfaces " // &
         "come to touch along a line or an area, as of a coin that comes to lie flat)")
      call list%put(g, "body", kind_reference, target="body", &
         doc="body that the condition is about; may be left out if there is only one, and " // &
         "with when = 'rest', which then is about all bodies together")
      call list%put(g, "contact", kind_reference, target="contact", &
         doc="contact that touch, lift or conforming is about; any, if not given")
      call list%put(g, "kinetic_energy", kind_real, unit="J", above=0.0_wp, &
         doc="kinetic energy below which bodies are at rest; not given, that of their mass at " // &
         "1e-3 m/s")
      call list%put(g, "duration", kind_real, unit="s", least=0.0_wp, default="0.1", &
         doc="time for which the kinetic energy has to stay below, so that a turning point, " // &
         "as at the top of a bounce, is not taken for rest; the run ends when it is over")
      call list%put(g, "angle", kind_real, unit="rad", above=0.0_wp, most=pi, &
         doc="angle between axis and direction")
      call list%put(g, "axis", kind_real, values=3, unit="1", default="0, 0, 1", &
         doc="axis in the frame of the body, of any length but zero")
      call list%put(g, "speed", kind_real, unit="m s-1", above=0.0_wp, &
         doc="speed of the centre of mass")
      call list%put(g, "angular_velocity", kind_real, unit="rad s-1", above=0.0_wp, &
         doc="magnitude of the angular velocity")
      call list%put(g, "position", kind_real, unit="m", &
         doc="coordinate of the centre of mass along direction")
      call list%put(g, "direction", kind_real, values=3, unit="1", default="0, 0, 1", &
         doc="direction in the inertial frame, of any length but zero")
      call list%put(g, "crossing", kind_choice, words=crossing_names, default="'any'", &
         doc="how the value is crossed: rising, falling, or any of the two; a value at which " // &
         "the run begins is not crossed there")
   end subroutine put_stop_keys

   !> Read a stop condition.
   subroutine build_stop(group, references, stop, diagnostics)
      type(group_settings_type), intent(in) :: group
      !> Names of the scene.
      type(references_type), intent(in) :: references
      type(stop_spec_type), intent(inout) :: stop
      type(diagnostics_type), intent(inout) :: diagnostics
      character(len=:), allocatable :: name
      integer :: k, before

      stop%kind = group%choice("when")
      stop%name = group%label()
      if (stop%kind < 1) return
      if (stop%name == "") stop%name = trim(stop_names(stop%kind))
      do k = 1, size(own_keys)
         name = trim(own_keys(k))
         if (has(stop%kind, name)) cycle
         call group%refuse(name, quote(name) // " has no meaning for when = " // &
            quote(trim(stop_names(stop%kind))), "keys that go with it: " // &
            trim(keys_of(stop%kind)), diagnostics)
         call group%unset(name)
      end do
      before = diagnostics%count()
      call references%find(group, "body", 1, stop%body, diagnostics)
      call references%find(group, "contact", 1, stop%contact, diagnostics)
      if (group%is_set("body") .and. stop%body == 0 .and. diagnostics%count() == before) call &
         diagnostics%add(group%place("body", 1), "the ground never moves", "the name of a body")
      name = trim(threshold_keys(stop%kind))
      if (name /= "") then
         if (group%lacks(name)) call diagnostics%add(group%origin, quote(name) // &
            " is missing in group &stop with when = " // quote(trim(stop_names(stop%kind))), &
            name // " = " // domain_text(group%key(name)))
         stop%threshold = group%number(name)
      else if (stop%kind == stop_rest) then
         stop%threshold = group%number("kinetic_energy")
      end if
      if (stop%kind == stop_rest) stop%duration = group%number("duration")
      stop%crossing = max(group%choice("crossing"), 1)
      call read_direction("axis", stop%axis)
      call read_direction("direction", stop%direction)

   contains

      !> A vector that becomes one of length 1.
      subroutine read_direction(key, vector)
         character(len=*), intent(in) :: key
         real(wp), intent(inout) :: vector(3)

         if (.not. has(stop%kind, key)) return
         vector = group%numbers(key)
         if (any(abs(vector) > 0.0_wp)) then
            vector = vector/maxval(abs(vector))
            vector = vector/norm2(vector)
         else if (group%is_set(key)) then
            call diagnostics%add(group%place(key, 1), quote(key) // " is a zero vector", &
               "a vector of any length but zero")
         end if
      end subroutine read_direction

   end subroutine build_stop

   !> What the conditions of a scene say about bodies that they do not name.
   subroutine complete_stops(scene, places, diagnostics)
      type(scene_type), intent(inout) :: scene
      !> Where each condition is given.
      type(origin_type), intent(in) :: places(:)
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i, k

      do i = 1, size(scene%stops)
         associate (stop => scene%stops(i))
            if (stop%kind < 1) cycle
            if (stop%kind == stop_rest) then
               if (stop%threshold > 0.0_wp) cycle
               do k = 1, size(scene%bodies)
                  if (all(stop%body /= [0, k])) cycle
                  if (.not. moves_freely(scene%bodies(k)%motion)) cycle
                  stop%threshold = stop%threshold + 0.5_wp*scene%bodies(k)%mass*slow**2
               end do
               if (stop%threshold <= 0.0_wp) call diagnostics%add(places(i), &
                  "no force moves what the condition 'rest' is about", &
                  "a body whose motion is 'free'")
            else if (has(stop%kind, "body") .and. stop%body == 0) then
               stop%body = 1
               if (size(scene%bodies) > 1) call diagnostics%add(places(i), &
                  "'body' is missing in group &stop with when = " // &
                  quote(trim(stop_names(stop%kind))), "body = the name of a body in quotes")
            end if
         end associate
      end do
   end subroutine complete_stops

   !> Whether a condition has a key.
   pure logical function has(kind, key)
      !> One of the `stop_*` codes.
      integer, intent(in) :: kind
      character(len=*), intent(in) :: key

      has = index(" " // keys_of(kind), " " // key // " ") > 0
   end function has

end module contensou_scene_stops
