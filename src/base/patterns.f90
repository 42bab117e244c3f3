!> Names chosen by patterns.
module contensou_base_patterns
   implicit none(type, external)
   private

   public :: matches_pattern

contains

   !> Whether a name matches a pattern, in which `*` stands for any characters and `?` for one.
   pure logical function matches_pattern(pattern, name)
      character(len=*), intent(in) :: pattern
      character(len=*), intent(in) :: name
      integer :: i, j, star, mark

      ! The star that was met last takes one more character whenever what follows it fails.
      i = 1
      j = 1
      star = 0
      mark = 0
      matches_pattern = .false.
      do while (j <= len(name))
         if (i <= len(pattern)) then
            if (pattern(i:i) == "*") then
               star = i
               mark = j
               i = i + 1
               cycle
            else if (pattern(i:i) == "?" .or. pattern(i:i) == name(j:j)) then
               i = i + 1
               j = j + 1
               cycle
            end if
         end if
         if (star == 0) return
         mark = mark + 1
         j = mark
         i = star + 1
      end do
      matches_pattern = verify(pattern(min(i, len(pattern) + 1):), "*") == 0
   end function matches_pattern

end module contensou_base_patterns
