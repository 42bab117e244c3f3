!> Bisection: where between two bounds a statement begins to be true.
!>
!>    call search%begin(low, high)
!>    do while (search%goes_on)
!>       call search%narrow(is_beyond(search%middle))
!>    end do
!>
!> At the end no number lies between the bounds, unless the steps were limited.
module contensou_special_bisection
   use contensou_base_kinds, only : wp
   implicit none(type, external)
   private

   public :: bisection_type

   !> A search under way.
   type :: bisection_type
      !> What is sought lies behind `low` and not behind `high`.
      real(wp) :: low = 0.0_wp, high = 0.0_wp
      !> Where to look next.
      real(wp) :: middle = 0.0_wp
      !> Whether there is anything left to look at.
      logical :: goes_on = .false.
      !> How many steps may still be made.
      integer, private :: steps = 0
   contains
      procedure :: begin
      procedure :: narrow
   end type bisection_type

contains

   pure subroutine begin(self, low, high, steps)
      class(bisection_type), intent(inout) :: self
      real(wp), intent(in) :: low, high
      !> How many steps are made at the most; without it, until nothing lies between the bounds.
      integer, intent(in), optional :: steps

      self%low = low
      self%high = high
      self%steps = huge(steps)
      if (present(steps)) self%steps = steps
      call halve(self)
   end subroutine begin

   !> Take the middle as the new bound on its side.
   pure subroutine narrow(self, beyond)
      class(bisection_type), intent(inout) :: self
      !> Whether the middle is what is sought, or lies behind it.
      logical, intent(in) :: beyond

      if (beyond) then
         self%high = self%middle
      else
         self%low = self%middle
      end if
      self%steps = self%steps - 1
      call halve(self)
   end subroutine narrow

   pure subroutine halve(self)
      class(bisection_type), intent(inout) :: self

      self%middle = 0.5_wp*(self%low + self%high)
      self%goes_on = self%steps > 0 .and. self%low < self%middle .and. self%middle < self%high
   end subroutine halve
end module contensou_special_bisection
