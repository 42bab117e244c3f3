!> A dictionary from names to numbers by hashing. Upper and lower case are the same.
module contensou_base_names
   use contensou_base_kinds, only : i8
   use contensou_base_text, only : lower, nearest, string_type
   implicit none(type, external)
   private

   public :: names_type

   !> Names and the number of each.
   type :: names_type
      private
      integer :: n = 0
      !> The names in lower case, the first `n` of them.
      type(string_type), allocatable :: names(:)
      integer, allocatable :: numbers(:)
      !> Position in `names` at the place that the hash of a name gives or, where that is taken,
      !> the next; 0 for none. Its size is a power of two of more than `n`.
      integer, allocatable :: places(:)
   contains
      procedure :: add
      procedure :: find
      procedure :: nearest => nearest_number
   end type names_type

contains

   !> Add a name; one that is there keeps its number.
   pure subroutine add(self, name, number)
      class(names_type), intent(inout) :: self
      character(len=*), intent(in) :: name
      integer, intent(in) :: number
      integer :: place

      if (.not. allocated(self%names)) call resize(self, 8)
      if (self%n == size(self%names)) call resize(self, 2*self%n)
      place = place_of(self, lower(name))
      if (self%places(place) > 0) return
      self%n = self%n + 1
      self%names(self%n)%s = lower(name)
      self%numbers(self%n) = number
      self%places(place) = self%n
   end subroutine add

   !> Number of a name; 0 if it is not there.
   pure integer function find(self, name)
      class(names_type), intent(in) :: self
      character(len=*), intent(in) :: name
      integer :: k

      find = 0
      if (self%n == 0) return
      k = self%places(place_of(self, lower(name)))
      if (k > 0) find = self%numbers(k)
   end function find

   !> Number of the name that is likely meant by one that is not there; 0 for none.
   pure integer function nearest_number(self, name)
      class(names_type), intent(in) :: self
      character(len=*), intent(in) :: name
      integer :: k

      nearest_number = 0
      if (self%n == 0) return
      k = nearest(name, self%names(:self%n))
      if (k > 0) nearest_number = self%numbers(k)
   end function nearest_number

   !> Place of a name, or the free place for it.
   pure integer function place_of(self, name) result(place)
      type(names_type), intent(in) :: self
      !> The name in lower case.
      character(len=*), intent(in) :: name
      ! Hash of Fowler, Noll and Vo.
      integer(i8), parameter :: basis = 2166136261_i8, prime = 16777619_i8
      integer(i8), parameter :: mask = int(z"FFFFFFFF", i8)
      integer(i8) :: hash
      integer :: i

      hash = basis
      do i = 1, len(name)
         hash = iand(ieor(hash, int(ichar(name(i:i)), i8))*prime, mask)
      end do
      place = int(modulo(hash, int(size(self%places), i8))) + 1
      do while (self%places(place) > 0)
         associate (there => self%names(self%places(place))%s)
            if (len(there) == len(name)) then
               if (there == name) return
            end if
         end associate
         place = modulo(place, size(self%places)) + 1
      end do
   end function place_of

   !> Make room for names.
   pure subroutine resize(self, n)
      type(names_type), intent(inout) :: self
      !> Number of names, a power of two.
      integer, intent(in) :: n
      type(string_type), allocatable :: names(:)
      integer, allocatable :: numbers(:)
      integer :: i

      allocate(names(n), numbers(n))
      do i = 1, self%n
         call move_alloc(self%names(i)%s, names(i)%s)
         numbers(i) = self%numbers(i)
      end do
      call move_alloc(names, self%names)
      call move_alloc(numbers, self%numbers)
      if (allocated(self%places)) deallocate(self%places)
      allocate(self%places(4*n), source=0)
      do i = 1, self%n
         self%places(place_of(self, self%names(i)%s)) = i
      end do
   end subroutine resize

end module contensou_base_names
