!> K and E of the GNU Scientific Library, if it is installed.
!>
!> The library is looked for at run time, so that a program that does not use it does not need it.
module contensou_special_gsl
   use, intrinsic :: iso_c_binding, only : c_associated, c_char, c_double, c_f_procpointer, &
      c_funptr, c_int, c_null_char, c_null_ptr, c_ptr
   use contensou_base_kinds, only : wp
   implicit none(type, external)
   private

   public :: load_gsl, gsl_complete_ke

   abstract interface
      !> A complete elliptic integral by its modulus.
      pure function complete_integral(modulus, mode) result(integral) bind(c)
         import :: c_double, c_int
         implicit none(type, external)
         !> Modulus sqrt(c) [-].
         real(c_double), intent(in), value :: modulus
         !> Precision; 0 is double.
         integer(c_int), intent(in), value :: mode
         real(c_double) :: integral
      end function complete_integral
   end interface

   interface
      !> Open a shared library.
      function dlopen(name, mode) result(handle) bind(c, name="dlopen")
         import :: c_char, c_int, c_ptr
         implicit none(type, external)
         !> Name, ended by a zero byte.
         character(len=1, kind=c_char), intent(in) :: name(*)
         !> When symbols are resolved; 1 is when they are used.
         integer(c_int), intent(in), value :: mode
         type(c_ptr) :: handle
      end function dlopen

      !> Find a procedure in a shared library.
      function dlsym(handle, name) result(address) bind(c, name="dlsym")
         import :: c_char, c_funptr, c_ptr
         implicit none(type, external)
         !> The library.
         type(c_ptr), intent(in), value :: handle
         !> Name, ended by a zero byte.
         character(len=1, kind=c_char), intent(in) :: name(*)
         type(c_funptr) :: address
      end function dlsym
   end interface

   !> Integral K of the library; not associated if it is not loaded.
   procedure(complete_integral), pointer, protected :: gsl_sf_ellint_kcomp => null()

   !> Integral E of the library.
   procedure(complete_integral), pointer, protected :: gsl_sf_ellint_ecomp => null()

contains

   !> Look for the library. To be called once before threads start.
   subroutine load_gsl(found)
      !> Whether it is there.
      logical, intent(out) :: found
      character(len=*), parameter :: names(4) = [character(len=12) :: "libgsl.so.28", &
         "libgsl.so.27", "libgsl.so.25", "libgsl.so"]
      type(c_ptr) :: handle
      type(c_funptr) :: kcomp, ecomp
      integer :: i

      found = associated(gsl_sf_ellint_kcomp)
      if (found) return
      handle = c_null_ptr
      do i = 1, size(names)
         handle = dlopen(trim(names(i)) // c_null_char, 1_c_int)
         if (c_associated(handle)) exit
      end do
      if (.not. c_associated(handle)) return
      kcomp = dlsym(handle, "gsl_sf_ellint_Kcomp" // c_null_char)
      ecomp = dlsym(handle, "gsl_sf_ellint_Ecomp" // c_null_char)
      found = c_associated(kcomp) .and. c_associated(ecomp)
      if (.not. found) return
      call c_f_procpointer(ecomp, gsl_sf_ellint_ecomp)
      call c_f_procpointer(kcomp, gsl_sf_ellint_kcomp)
   end subroutine load_gsl

   !> Integrals K and E.
   pure subroutine gsl_complete_ke(modulus, k, e, found)
      !> Modulus sqrt(c) [-], in [0, 1].
      real(wp), intent(in) :: modulus
      !> Integral K [-].
      real(wp), intent(out) :: k
      !> Integral E [-].
      real(wp), intent(out) :: e
      !> Whether there are results.
      logical, intent(out) :: found

      ! Where modulus^2 rounds to 1 the library would call its error handler, which aborts.
      found = modulus*modulus < 1.0_wp .and. associated(gsl_sf_ellint_kcomp)
      if (found) then
         k = gsl_sf_ellint_kcomp(modulus, 0_c_int)
         e = gsl_sf_ellint_ecomp(modulus, 0_c_int)
      else
         k = 0.0_wp
         e = 0.0_wp
      end if
   end subroutine gsl_complete_ke

end module contensou_special_gsl
