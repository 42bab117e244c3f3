!> How often pairs of groups were visited: groups of HDF5 can hold each other.
module contensou_compare_visits
   use contensou_base_kinds, only : i8
   implicit none(type, external)
   private

   public :: visits_type

   !> Pairs of groups and the number of visits to them, as a hash table.
   type :: visits_type
      private
      !> Two addresses and a count, (3, slots).
      integer(i8), allocatable :: table(:, :)
      !> Number of such pairs.
      integer :: n = 0
   contains
      procedure :: visit
   end type visits_type

contains

   !> Count a visit to a pair of groups.
   function visit(self, addresses) result(times)
      class(visits_type), intent(inout) :: self
      !> Addresses of the groups.
      integer(i8), intent(in) :: addresses(2)
      !> Number of visits so far, this one included.
      integer :: times
      integer(i8), allocatable :: old(:, :), longer(:, :)
      integer :: i, k

      if (.not. allocated(self%table)) then
         allocate(self%table(3, 0:63))
         self%table = 0
      end if
      if (2*self%n > size(self%table, 2)) then
         allocate(longer(3, 0:2*size(self%table, 2) - 1))
         longer = 0
         call move_alloc(self%table, old)
         do i = 0, ubound(old, 2)
            if (old(3, i) == 0) cycle
            k = slot_of(longer, old(:2, i))
            longer(:, k) = old(:, i)
         end do
         call move_alloc(longer, self%table)
      end if
      k = slot_of(self%table, addresses)
      if (self%table(3, k) == 0) self%n = self%n + 1
      self%table(:2, k) = addresses
      self%table(3, k) = self%table(3, k) + 1
      times = int(self%table(3, k))
   end function visit

   !> Place of a pair of addresses in a table, by open addressing.
   pure function slot_of(table, addresses) result(k)
      !> Addresses and counts; a power of two of them, some of which are free.
      integer(i8), intent(in) :: table(:, 0:)
      !> The pair.
      integer(i8), intent(in) :: addresses(2)
      !> Its place, or a free one.
      integer :: k

      k = int(iand(ieor(ieor(addresses(1), shiftr(addresses(1), 7)), &
         ieor(shiftl(addresses(2), 3), shiftr(addresses(2), 11))), &
         int(size(table, 2) - 1, i8)))
      do while (table(3, k) /= 0)
         if (all(table(:2, k) == addresses)) exit
         k = modulo(k + 1, size(table, 2))
      end do
   end function slot_of

end module contensou_compare_visits
