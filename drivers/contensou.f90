!> The executable. It only calls: variables of a main program are never released.
program contensou
   use contensou_drivers_main, only : execute
   implicit none(type, external)
   integer :: status

   call execute(status)
   stop status, quiet=.true.
end program contensou
