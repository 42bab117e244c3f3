!> Working precision and integer kinds used throughout.
module contensou_base_kinds
   use, intrinsic :: iso_fortran_env, only : int64, real64
   implicit none(type, external)
   private

   public :: wp, i8, pi

   !> Working precision: IEEE double.
   integer, parameter :: wp = real64

   !> Eight-byte integer for counters.
   integer, parameter :: i8 = int64

   !> Circle constant [-].
   real(wp), parameter :: pi = 3.14159265358979323846264338327950288_wp

end module contensou_base_kinds
