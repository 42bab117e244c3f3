!> Contacts with several spots: which spot is where.
!>
!> Each spot is a contact of its own and follows one place at which the gap is smallest among those
!> near by. As soon as the surfaces are close, all such places are looked for, and every one gets a
!> spot before it touches: a spot that touches keeps its place, as does one that has just opened;
!> those that are open take the others in the order in which they lie on one of the surfaces. So the
!> order depends on the state and on what touches, not on steps. A spot without a place is away,
!> with a gap that is not zero.
module contensou_dynamics_spots
   use contensou_base_kinds, only : wp
   use contensou_contact_geometry, only : place_closest, place_none, place_own, same_place, &
      track_type, trouble_merged, trouble_none, trouble_spots, trouble_sudden
   use contensou_dynamics_mechanism, only : contact_type, mechanism_type
   use contensou_dynamics_rests, only : sunk
   implicit none(type, external)
   private

   public :: assign_spots, change_spots, take_back_spots

   !> Places that are told apart.
   integer, parameter :: most_places = 16

   !> A place where the surfaces of a contact are closest.
   type :: place_type
      type(track_type) :: track
      !> Its gap [m].
      real(wp) :: gap = 0.0_wp
      !> The spot that has it; 0 for none.
      integer :: owner = 0
   end type place_type

contains

   !> Give the places of all contacts with several spots to these.
   subroutine assign_spots(mechanism, held, index, trouble)
      !> The mechanism, its poses set; tracks are changed.
      class(mechanism_type), intent(inout) :: mechanism
      !> For each contact whether it touches, so that it keeps its place.
      logical, intent(in) :: held(:)
      !> Contact that cannot have a place of its own; 0 if all can.
      integer, intent(out) :: index
      !> Why, one of the `trouble_*` codes.
      integer, intent(out) :: trouble
      integer :: i, n

      index = 0
      trouble = trouble_none
      do i = 1, size(mechanism%contacts)
         n = mechanism%contacts(i)%spots
         if (n < 2 .or. mechanism%contacts(i)%spot > 1) cycle
         call assign_group(mechanism, i, held(i:i + n - 1), trouble)
         if (trouble == trouble_none) cycle
         index = i
         return
      end do
   end subroutine assign_spots

   !> Give the places of a contact to its spots.
   subroutine assign_group(mechanism, first, held, trouble)
      class(mechanism_type), intent(inout) :: mechanism
      !> Its first spot.
      integer, intent(in) :: first
      !> Which spots touch.
      logical, intent(in) :: held(:)
      !> One of the `trouble_*` codes.
      integer, intent(out) :: trouble
      type(place_type) :: place(most_places)
      type(track_type) :: found(most_places)
      real(wp) :: gap(size(held)), gaps(most_places), limit
      !> Which keep their places.
      logical :: firm(size(held))
      integer :: i, j, k, n

      trouble = trouble_none
      firm = held
      associate (contacts => mechanism%contacts(first:first + size(held) - 1), &
         a => mechanism%pose(mechanism%contacts(first)%a), &
         b => mechanism%pose(mechanism%contacts(first)%b))
         do k = 1, size(held)
            call contacts(k)%find_gap(a, b, gap(k))
         end do
         limit = contacts(1)%law%largest_approach
         if (contacts(1)%track%place == place_closest .and. gap(1) >= limit .and. &
            .not. any(held)) then
            contacts(2:)%track%place = place_none
            return
         end if
         call contacts(1)%law%geometry%find_places(a, b, limit, found(:most_places - size(held)), &
            gaps(:most_places - size(held)), n)
         do i = 1, n
            place(i)%track = found(i)
            place(i)%gap = gaps(i)
         end do
         ! Places that are followed count, found or not.
         do k = 1, size(held)
            if (.not. has_place(contacts(k)%track)) cycle
            if (gap(k) >= limit .and. .not. held(k)) cycle
            j = place_of(contacts(k)%track, place(:n), contacts(1)%law%geometry%length)
            if (j == 0) then
               n = n + 1
               j = n
            end if
            ! As it is followed, to the last digit.
            place(j)%track = contacts(k)%track
            place(j)%gap = gap(k)
            ! What is known of a rigid contact that has just opened is known of its place.
            if (.not. (held(k) .or. contacts(k)%leaving)) cycle
            i = place(j)%owner
            if (i > 0) then
               if (.not. held(k)) cycle
               if (held(i)) then
                  ! Two that touch have become one, in between nothing holds the surfaces apart.
                  trouble = trouble_merged
                  return
               end if
               firm(i) = .false.
            end if
            firm(k) = .true.
            place(j)%owner = k
         end do
         call give_open(contacts(1)%law%geometry%ordering, place(:n), firm, trouble)
         if (trouble /= trouble_none) return
         do k = 1, size(held)
            j = 0
            do i = 1, n
               if (place(i)%owner == k) j = i
            end do
            if (j > 0) then
               call keep(contacts(k), place(j)%track, place(j)%gap, held(k), &
                  leash_of(place(:n), j))
            else if (held(k)) then
               ! It is lost, which the right-hand side tells.
               cycle
            else if (k == 1 .and. all(place(:n)%owner == 0)) then
               if (contacts(k)%track%place /= place_closest) contacts(k)%track = track_type()
            else
               contacts(k)%track = track_type(place=place_none, away=.true.)
            end if
         end do
         if (contacts(1)%track%place == place_closest) call contacts(1)%find_gap(a, b, gap(1))
      end associate
   end subroutine assign_group

   !> Number of the place that a track is at; 0 for none.
   pure integer function place_of(track, places, length)
      type(track_type), intent(in) :: track
      type(place_type), intent(in) :: places(:)
      !> Length of the order of the surfaces [m].
      real(wp), intent(in) :: length

      do place_of = size(places), 1, -1
         if (same_place(track, places(place_of)%track, length)) return
      end do
   end function place_of

   !> Half the distance of a place from the next one [m].
   pure real(wp) function leash_of(places, index)
      type(place_type), intent(in) :: places(:)
      integer, intent(in) :: index
      integer :: other

      leash_of = huge(leash_of)
      do other = 1, size(places)
         if (other == index) cycle
         associate (one => places(index)%track, next => places(other)%track)
            leash_of = min(leash_of, 0.5_wp*norm2(one%first - next%first), &
               0.5_wp*norm2(one%second - next%second))
         end associate
      end do
   end function leash_of

   !> Whether a track is at a place.
   pure logical function has_place(track)
      type(track_type), intent(in) :: track

      has_place = track%place /= place_none .and. .not. (track%away .or. track%lost)
   end function has_place

   !> Give the places that nothing holds to the spots that are open: in the order of the surface if
   !> there are enough spots, else the closest ones.
   subroutine give_open(ordering, place, firm, trouble)
      !> The surface, 1 for A and 2 for B.
      integer, intent(in) :: ordering
      type(place_type), intent(inout) :: place(:)
      !> Which spots keep their places.
      logical, intent(in) :: firm(:)
      !> Set where a place that overlaps is left over.
      integer, intent(inout) :: trouble
      real(wp) :: x(3, size(place)), key(size(place)), spread(3)
      logical :: free(size(place))
      integer :: i, j, k, axis

      free = place%owner == 0
      do while (count(free) > count(.not. firm))
         i = maxloc(place%gap, dim=1, mask=free)
         free(i) = .false.
         if (place(i)%gap < 0.0_wp) trouble = trouble_spots
      end do
      if (.not. any(free)) return
      do i = 1, size(place)
         x(:, i) = place(i)%track%first
         if (ordering == 2) x(:, i) = place(i)%track%second
      end do
      do axis = 1, 3
         spread(axis) = maxval(x(axis, :), mask=free) - minval(x(axis, :), mask=free)
      end do
      key = x(maxloc(spread, dim=1), :)
      k = 0
      do j = 1, count(free)
         do
            k = k + 1
            if (.not. firm(k)) exit
         end do
         i = minloc(key, dim=1, mask=free)
         place(i)%owner = k
         free(i) = .false.
      end do
   end subroutine give_open

   !> Let a spot have a place.
   subroutine keep(contact, place, gap, held, leash)
      type(contact_type), intent(inout) :: contact
      type(track_type), intent(in) :: place
      !> Its gap [m].
      real(wp), intent(in) :: gap
      !> Whether the spot touches.
      logical, intent(in) :: held
      !> How far from here it may be found [m].
      real(wp), intent(in) :: leash

      contact%track = track_type(known=.true., first=place%first, second=place%second, &
         normal=place%normal, place=place_own, overlaps=gap < 0.0_wp, &
         pinned=held .and. contact%rigid, anchor=reshape([place%first, place%second], [3, 2]), &
         leash=leash)
   end subroutine keep

   !> Gap below which an open contact overlaps [m]: a rigid one may have opened just below zero.
   pure real(wp) function rounded_gap(contact)
      type(contact_type), intent(in) :: contact

      rounded_gap = 0.0_wp
      if (contact%rigid) rounded_gap = -sunk*contact%law%geometry%smallest_radius()
   end function rounded_gap

   !> Give the places at the end of a step to the spots, and see whether one that touches there was
   !> not where it is now.
   subroutine change_spots(mechanism, held, touching, again, index, trouble)
      !> The mechanism, its poses those at the end of a step.
      class(mechanism_type), intent(inout) :: mechanism
      !> For each contact whether it touched in the step.
      logical, intent(in) :: held(:)
      !> Whether it touches at its end.
      logical, intent(in) :: touching(:)
      !> Whether the step is to be taken again with the spots as they are now.
      logical, intent(out) :: again
      !> Contact that cannot have a place of its own; 0 if all can.
      integer, intent(out) :: index
      !> Why, one of the `trouble_*` codes.
      integer, intent(out) :: trouble
      type(track_type) :: before(size(held))
      real(wp) :: gap
      integer :: i

      again = .false.
      do i = 1, size(held)
         associate (contact => mechanism%contacts(i))
            if (contact%spots < 2) cycle
            call contact%find_gap(mechanism%pose(contact%a), mechanism%pose(contact%b), gap)
            before(i) = contact%track
         end associate
      end do
      call assign_spots(mechanism, held, index, trouble)
      if (index > 0) return
      do i = 1, size(held)
         associate (contact => mechanism%contacts(i), geometry => &
            mechanism%contacts(i)%law%geometry)
            if (contact%spots < 2 .or. held(i)) cycle
            if (has_place(contact%track) .and. has_place(before(i))) then
               if (same_place(contact%track, before(i), geometry%length)) cycle
            else if (.not. has_place(before(i)) .and. .not. has_place(contact%track)) then
               cycle
            end if
            call contact%find_gap(mechanism%pose(contact%a), mechanism%pose(contact%b), gap)
            again = again .or. touching(i) .or. (gap < rounded_gap(contact) .and. &
               has_place(contact%track))
         end associate
      end do
   end subroutine change_spots

   !> Follow the spots back to the beginning of a step.
   subroutine take_back_spots(mechanism, held, born, index, trouble)
      !> The mechanism, its poses those at the beginning, its tracks those at the end.
      class(mechanism_type), intent(inout) :: mechanism
      !> For each contact whether it touches.
      logical, intent(in) :: held(:)
      !> Whether one that overlaps at the end has no place at the beginning.
      logical, intent(out) :: born
      !> Contact that overlaps at the beginning, which nobody saw; 0 for none.
      integer, intent(out) :: index
      !> Why, one of the `trouble_*` codes.
      integer, intent(out) :: trouble
      type(track_type) :: after
      real(wp) :: gap
      integer :: i, j

      born = .false.
      index = 0
      trouble = trouble_none
      do i = 1, size(held)
         associate (contact => mechanism%contacts(i))
            if (contact%spots < 2) cycle
            if (contact%track%place /= place_own) cycle
            after = contact%track
            if (held(i)) then
               call contact%find_gap(mechanism%pose(contact%a), mechanism%pose(contact%b), gap)
               cycle
            end if
            contact%track%overlaps = .false.
            contact%track%leash = huge(gap)
            call contact%find_gap(mechanism%pose(contact%a), mechanism%pose(contact%b), gap)
            if (contact%track%away) then
               contact%track = track_type(place=place_none, away=.true.)
               born = born .or. after%overlaps
            else if (gap < rounded_gap(contact)) then
               index = i
               trouble = trouble_sudden
            else
               contact%track%anchor(:, 1) = contact%track%first
               contact%track%anchor(:, 2) = contact%track%second
               contact%track%leash = after%leash
            end if
         end associate
      end do
      if (index == 0) return
      ! At the beginning the two may be one.
      associate (contact => mechanism%contacts(index))
         do j = index - contact%spot + 1, index - contact%spot + contact%spots
            if (held(j) .and. same_place(contact%track, mechanism%contacts(j)%track, &
               contact%law%geometry%length)) trouble = trouble_merged
         end do
      end associate
   end subroutine take_back_spots

end module contensou_dynamics_spots
