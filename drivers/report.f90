!> Texts about a scene that several sub-commands print.
module contensou_drivers_report
   use contensou_base_errors, only : error_type, fatal, status_usage
   use contensou_base_kinds, only : i8, wp
   use contensou_base_names, only : names_type
   use contensou_base_numbers, only : counted, number_text, to_text
   use contensou_base_operating_system, only : write_stderr
   use contensou_base_text, only : quote, string_type
   use contensou_contact_parts, only : n_parts, part_type, shared_parts
   use contensou_dynamics_scene, only : body_spec_type, contact_spec_type, motion_fixed, &
      motion_free, motion_prescribed, motion_rotor, motion_spindle, scene_type, stop_angle, &
      stop_conforming, stop_lift, stop_names, stop_position, stop_rest, stop_speed, &
      stop_spec_type, stop_spin, stop_touch
   use contensou_dynamics_springs, only : spring_kinds
   use contensou_scene_reader, only : scene_file_type
   implicit none(type, external)
   private

   public :: bodies_text, bodies_of, contacts_of, springs_of, names_in_short, &
      in_series, stop_words, &
      heed_warnings

contains

   !> Show the warnings of a scene; nothing is to be done then if they are errors.
   subroutine heed_warnings(file, path, strict, error)
      type(scene_file_type), intent(in) :: file
      !> Name of the scene file.
      character(len=*), intent(in) :: path
      !> Whether warnings are errors.
      logical, intent(in) :: strict
      !> Set when there are some and they are errors.
      type(error_type), allocatable, intent(out) :: error

      if (file%n_warnings == 0) return
      call write_stderr(file%warnings)
      if (strict) call fatal(error, counted(int(file%n_warnings, i8), "warning") // " in " // &
         path // ", and --strict allows none; nothing was run", status_usage)
   end subroutine heed_warnings

   !> What drives or loads the bodies of a scene, a line for those that are alike.
   subroutine bodies_of(scene, lines)
      type(scene_type), intent(in) :: scene
      type(string_type), allocatable, intent(out) :: lines(:)
      type(string_type) :: names(size(scene%bodies)), words(size(scene%bodies))
      integer :: i

      do i = 1, size(names)
         names(i)%s = scene%bodies(i)%name
         words(i)%s = body_effects(scene%bodies(i))
      end do
      call put_together(names, words, lines)
   end subroutine bodies_of

   !> The effects that the contacts of a scene pay for, a line for those that are alike.
   subroutine contacts_of(scene, lines)
      type(scene_type), intent(in) :: scene
      type(string_type), allocatable, intent(out) :: lines(:)
      type(string_type) :: names(size(scene%contacts)), words(size(scene%contacts))
      integer :: i

      do i = 1, size(names)
         associate (contact => scene%contacts(i))
            names(i)%s = contact%name
            words(i)%s = ""
            if (contact%spot > 1) cycle
            words(i)%s = contact_effects(scene, contact)
            if (contact%spots == 1) cycle
            names(i)%s = contact%name(:index(contact%name, "[", back=.true.) - 1)
            words(i)%s = words(i)%s // ", up to " // to_text(contact%spots) // " spots"
         end associate
      end do
      call put_together(names, words, lines)
   end subroutine contacts_of

   !> The springs, those of which the same is said in a line.
   subroutine springs_of(scene, lines)
      type(scene_type), intent(in) :: scene
      type(string_type), allocatable, intent(out) :: lines(:)
      type(string_type), allocatable :: names(:), words(:)
      integer :: i

      allocate(names(0), words(0), lines(0))
      if (.not. allocated(scene%springs)) return
      if (size(scene%springs) == 0) return
      deallocate(names, words, lines)
      allocate(names(size(scene%springs)), words(size(scene%springs)))
      do i = 1, size(names)
         associate (spring => scene%springs(i))
            names(i)%s = spring%name
            words(i)%s = trim(spring_kinds(spring%kind))
            if (spring%damps()) words(i)%s = words(i)%s // " with damping"
         end associate
      end do
      call put_together(names, words, lines)
   end subroutine springs_of

   !> The effects that a contact pays for, separated by commas.
   function contact_effects(scene, contact) result(text)
      type(scene_type), intent(in) :: scene
      type(contact_spec_type), intent(in) :: contact
      character(len=:), allocatable :: text
      type(part_type), pointer :: parts(:)
      integer :: i, choice(n_parts)

      parts => shared_parts()
      choice = [contact%normal, contact%damping, contact%friction, contact%rolling, &
         contact%tangential, contact%curvature]
      associate (a => scene%surfaces(contact%surfaces(1))%surface, &
         b => scene%surfaces(contact%surfaces(2))%surface)
         text = a%label() // " on " // b%label()
      end associate
      do i = 1, n_parts
         text = text // parts(i)%words(choice(i), contact%parameters)
      end do
   end function contact_effects

   !> Things of which the same is said, in a line: names, a colon, and what is said. Those whose
   !> names differ in the number at their end are put together, others if they are many.
   subroutine put_together(names, words, lines)
      !> Names of the things.
      type(string_type), intent(in) :: names(:)
      !> What is said of each; nothing is if it is empty.
      type(string_type), intent(in) :: words(:)
      type(string_type), allocatable, intent(out) :: lines(:)
      integer, parameter :: many = 6
      type(names_type) :: kinds
      type(string_type) :: found(size(names))
      integer :: kind(size(names)), members(size(names)), first(size(names) + 2)
      logical :: said(size(names))
      integer :: i, n, n_kinds

      ! Those of which the same is said, kind after kind: `members(first(k):first(k + 1) - 1)`.
      n_kinds = 0
      first = 0
      do i = 1, size(names)
         kind(i) = 0
         if (words(i)%s == "") cycle
         kind(i) = kinds%find(words(i)%s)
         if (kind(i) == 0) then
            n_kinds = n_kinds + 1
            kind(i) = n_kinds
            call kinds%add(words(i)%s, n_kinds)
         end if
         first(kind(i) + 2) = first(kind(i) + 2) + 1
      end do
      first(1:2) = 1
      do i = 3, n_kinds + 2
         first(i) = first(i) + first(i - 1)
      end do
      do i = 1, size(names)
         if (kind(i) == 0) cycle
         members(first(kind(i) + 1)) = i
         first(kind(i) + 1) = first(kind(i) + 1) + 1
      end do
      said = .false.
      n = 0
      do i = 1, size(names)
         if (.not. said(i) .and. kind(i) > 0) call put(i, members(first(kind(i)):first(kind(i) &
            + 1) - 1))
      end do
      allocate(lines(n))
      do i = 1, n
         lines(i)%s = found(i)%s
      end do

   contains

      !> Add a line for a thing and those of its kind that go with it.
      subroutine put(i, own)
         integer, intent(in) :: i
         !> All of its kind.
         integer, intent(in) :: own(:)
         type(string_type) :: theirs(size(own))
         logical :: alike(size(own))
         integer :: k

         theirs = names(own)
         alike = .not. said(own)
         if (count(alike) <= many .or. all_in_series(theirs, alike)) then
            do k = 1, size(own)
               if (alike(k)) alike(k) = own(k) == i .or. in_series(theirs(k)%s, names(i)%s)
            end do
         end if
         said(own) = said(own) .or. alike
         n = n + 1
         found(n)%s = names_in_short(theirs, alike) // ": " // words(i)%s
      end subroutine put

   end subroutine put_together

   !> Whether the names of some things are few series.
   pure logical function all_in_series(names, chosen)
      type(string_type), intent(in) :: names(:)
      !> Which of them.
      logical, intent(in) :: chosen(:)
      integer, parameter :: few = 4
      logical :: left(size(names))
      integer :: i, k, n

      left = chosen
      n = 0
      do i = 1, size(names)
         if (.not. left(i)) cycle
         n = n + 1
         if (n > few) exit
         do k = i, size(names)
            if (left(k)) left(k) = k /= i .and. .not. in_series(names(k)%s, names(i)%s)
         end do
      end do
      all_in_series = n <= few
   end function all_in_series

   !> Whether two names differ in the number at their end only.
   pure logical function in_series(a, b)
      character(len=*), intent(in) :: a, b

      in_series = stem_of(a) == stem_of(b) .and. len(stem_of(a)) < len(a) .and. &
         len(stem_of(b)) < len(b)
   end function in_series

   !> Some names, those that differ in a number at their end as a range: "ball_1..9, cage".
   function names_in_short(names, chosen) result(text)
      type(string_type), intent(in) :: names(:)
      !> Which of them.
      logical, intent(in) :: chosen(:)
      character(len=:), allocatable :: text
      integer, parameter :: most = 6
      integer :: i, last, shown, left, first_number, number
      logical :: done(size(names))

      text = ""
      done = .not. chosen
      shown = 0
      do i = 1, size(names)
         if (done(i)) cycle
         if (shown == most) then
            left = count(.not. done)
            if (left > 1) then
               text = text // " and " // to_text(left) // " more"
               return
            end if
         end if
         if (text /= "") text = text // ", "
         text = text // names(i)%s
         shown = shown + 1
         done(i) = .true.
         first_number = number_of(names(i)%s)
         number = first_number
         if (number < 0) cycle
         last = i
         do
            last = next_of(stem_of(names(i)%s) // to_text(number + 1), last)
            if (last == 0) exit
            done(last) = .true.
            number = number + 1
         end do
         if (number > first_number) text = text // ".." // to_text(number)
      end do

   contains

      !> Where a name is that is left; 0 if it is not there. It is most likely behind another one.
      pure integer function next_of(name, behind)
         character(len=*), intent(in) :: name
         integer, intent(in) :: behind
         integer :: k

         do k = 0, size(names) - 1
            next_of = 1 + modulo(behind + k, size(names))
            if (.not. done(next_of) .and. names(next_of)%s == name) return
         end do
         next_of = 0
      end function next_of

   end function names_in_short

   !> A name without the number at its end.
   pure function stem_of(name) result(stem)
      character(len=*), intent(in) :: name
      character(len=:), allocatable :: stem

      stem = name(:verify(name, "0123456789", back=.true.))
   end function stem_of

   !> The number at the end of a name; -1 if there is none.
   pure integer function number_of(name)
      character(len=*), intent(in) :: name
      integer :: first

      number_of = -1
      first = verify(name, "0123456789", back=.true.) + 1
      if (first > len(name) .or. len(name) - first > 7) return
      read(name(first:), *) number_of
   end function number_of

   !> A condition that ends a run, in words.
   function stop_words(scene, stop, met_by) result(text)
      type(scene_type), intent(in) :: scene
      type(stop_spec_type), intent(in) :: stop
      !> The contact that has met it, if it is about contacts.
      integer, intent(in) :: met_by
      character(len=:), allocatable :: text
      character(len=:), allocatable :: body, contact

      body = "all bodies"
      if (stop%body > 0) body = scene%bodies(stop%body)%name
      contact = ""
      if (met_by > 0) contact = scene%contacts(met_by)%name
      text = "by " // quote(stop%name) // ": "
      select case (stop%kind)
      case (stop_rest)
         text = text // body // " at rest, below " // to_text(stop%threshold) // &
            " J for " // to_text(stop%duration) // " s"
      case (stop_touch)
         text = text // contact // " touches"
      case (stop_lift)
         text = text // contact // " lifts off"
      case (stop_angle)
         text = text // "axis of " // body // " at " // to_text(stop%threshold) // &
            " rad from its direction"
      case (stop_speed)
         text = text // "speed of " // body // " is " // to_text(stop%threshold) // " m/s"
      case (stop_spin)
         text = text // body // " turns at " // to_text(stop%threshold) // " rad/s"
      case (stop_position)
         text = text // "position of " // body // " is " // to_text(stop%threshold) // " m"
      case (stop_conforming)
         text = text // "the surfaces of " // contact // " conform"
      case default
         text = text // trim(stop_names(stop%kind))
      end select
   end function stop_words

   !> How many bodies a scene has, and how they move.
   function bodies_text(scene) result(text)
      type(scene_type), intent(in) :: scene
      character(len=:), allocatable :: text
      integer :: fixed, prescribed, spindle, rotor

      fixed = count(scene%bodies%motion == motion_fixed)
      prescribed = count(scene%bodies%motion == motion_prescribed)
      spindle = count(scene%bodies%motion == motion_spindle)
      rotor = count(scene%bodies%motion == motion_rotor)
      text = to_text(size(scene%bodies)) // ", rigid"
      if (fixed + prescribed + spindle + rotor == 0) then
         text = text // " and free"
      else
         text = text // "; free " // to_text(count(scene%bodies%motion == motion_free))
         if (fixed > 0) text = text // ", fixed " // to_text(fixed)
         if (prescribed > 0) text = text // ", prescribed " // to_text(prescribed)
         if (spindle > 0) text = text // ", spindle " // to_text(spindle)
         if (rotor > 0) text = text // ", rotor " // to_text(rotor)
      end if
   end function bodies_text

   !> What drives or loads a body; blank for a free body without applied loads.
   function body_effects(body) result(text)
      type(body_spec_type), intent(in) :: body
      character(len=:), allocatable :: text

      text = ""
      select case (body%motion)
      case (motion_fixed)
         text = "fixed"
      case (motion_spindle)
         text = "prescribed rotation, free to move"
         if (body%ramp_duration > 0.0_wp) text = text // ", ramp of " // &
            number_text(body%ramp_duration, 4) // " s"
         if (any(abs(body%applied_force) > 0.0_wp)) text = text // ", applied force"
      case (motion_rotor)
         text = "prescribed rotation about its axis, free to move and tilt"
         if (body%ramp_duration > 0.0_wp) text = text // ", ramp of " // &
            number_text(body%ramp_duration, 4) // " s"
         if (any(abs(body%applied_force) > 0.0_wp)) text = text // ", applied force"
         if (any(abs(body%applied_torque) > 0.0_wp)) text = text // ", applied torque"
      case (motion_prescribed)
         text = "prescribed motion"
         if (body%ramp_duration > 0.0_wp) text = text // ", ramp of " // &
            number_text(body%ramp_duration, 4) // " s"
      case default
         if (any(abs(body%applied_force) > 0.0_wp)) text = "applied force"
         if (any(abs(body%applied_torque) > 0.0_wp)) then
            if (text /= "") text = text // ", "
            text = text // "applied torque"
         end if
         if (text /= "" .and. body%load_follows) text = text // ", turning with the body"
      end select
   end function body_effects

end module contensou_drivers_report
