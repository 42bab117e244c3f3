!> K and E and the Sobol sequences of the GNU Scientific Library, if it is installed.
!>
!> The library is looked for at run time, so that a program that does not use it does not need it.
module contensou_special_gsl
   use, intrinsic :: iso_c_binding, only : c_associated, c_char, c_double, c_f_pointer, &
      c_f_procpointer, c_funptr, c_int, c_null_char, c_null_ptr, c_ptr
   use contensou_base_kinds, only : i8, wp
   implicit none(type, external)
   private

   public :: load_gsl, gsl_complete_ke
   public :: gsl_sobol_directions, sobol_bits, sobol_most_dimensions

   !> Bits of the numbers of a Sobol sequence.
   integer, parameter :: sobol_bits = 30

   !> Largest number of dimensions of a Sobol sequence.
   integer, parameter :: sobol_most_dimensions = 40

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

      !> Make a quasi-random sequence.
      function sequence_alloc(kind, dimensions) result(sequence) bind(c)
         import :: c_int, c_ptr
         implicit none(type, external)
         !> Kind of the sequence.
         type(c_ptr), intent(in), value :: kind
         !> Number of dimensions.
         integer(c_int), intent(in), value :: dimensions
         type(c_ptr) :: sequence
      end function sequence_alloc

      !> Free a sequence.
      subroutine sequence_free(sequence) bind(c)
         import :: c_ptr
         implicit none(type, external)
         !> The sequence.
         type(c_ptr), intent(in), value :: sequence
      end subroutine sequence_free

      !> Next point of a sequence.
      function sequence_get(sequence, point) result(code) bind(c)
         import :: c_double, c_int, c_ptr
         implicit none(type, external)
         !> The sequence.
         type(c_ptr), intent(in), value :: sequence
         !> The point.
         real(c_double), intent(out) :: point(*)
         integer(c_int) :: code
      end function sequence_get
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

   !> Direction numbers of the Sobol sequence in the order of the library, so that point n, from 1,
   !> is the exclusive or of those of the bits of the Gray code of n. To be called before threads
   !> start.
   subroutine gsl_sobol_directions(dimensions, n, directions, found)
      !> Number of dimensions, 1 to `sobol_most_dimensions`.
      integer, intent(in) :: dimensions
      !> Number of points, below 2^`sobol_bits`. The time that this takes grows with it.
      integer(i8), intent(in) :: n
      !> The numbers, (bit, dimension), as many bits as n has.
      integer(i8), allocatable, intent(out) :: directions(:, :)
      !> Whether the library is there.
      logical, intent(out) :: found
      procedure(sequence_alloc), pointer :: alloc
      procedure(sequence_free), pointer :: free
      procedure(sequence_get), pointer :: get
      type(c_ptr), pointer :: kind
      type(c_ptr) :: handle, sequence
      type(c_funptr) :: address(3), variable
      real(wp) :: point(dimensions)
      integer(i8) :: numerator(dimensions), before(dimensions), i
      integer(c_int) :: code
      integer :: bit, bits

      bits = 64 - leadz(n)
      allocate(directions(bits, dimensions), source=0_i8)
      handle = library_handle()
      found = c_associated(handle)
      if (.not. found) return
      address = [dlsym(handle, "gsl_qrng_alloc" // c_null_char), &
         dlsym(handle, "gsl_qrng_free" // c_null_char), &
         dlsym(handle, "gsl_qrng_get" // c_null_char)]
      variable = dlsym(handle, "gsl_qrng_sobol" // c_null_char)
      found = c_associated(address(1)) .and. c_associated(address(2)) .and. &
         c_associated(address(3)) .and. c_associated(variable)
      if (.not. found) return
      call c_f_procpointer(address(1), alloc)
      call c_f_procpointer(address(2), free)
      call c_f_procpointer(address(3), get)
      ! The kind is a variable that points to it.
      call c_f_pointer(transfer(variable, c_null_ptr), kind)
      sequence = alloc(kind, int(dimensions, c_int))
      found = c_associated(sequence)
      if (.not. found) return
      numerator = 0
      bit = 1
      ! Point i differs from the one before by the direction of the lowest bit of i.
      do i = 1, shiftl(1_i8, bits - 1)
         code = get(sequence, point)
         found = found .and. code == 0
         before = numerator
         numerator = nint(point*2.0_wp**sobol_bits, i8)
         if (i == shiftl(1_i8, bit - 1)) then
            directions(bit, :) = ieor(numerator, before)
            bit = bit + 1
         end if
      end do
      call free(sequence)
   end subroutine gsl_sobol_directions

   !> Open the library.
   function library_handle() result(handle)
      !> The library, or null.
      type(c_ptr) :: handle
      character(len=*), parameter :: names(4) = [character(len=12) :: "libgsl.so.28", &
         "libgsl.so.27", "libgsl.so.25", "libgsl.so"]
      integer :: i

      handle = c_null_ptr
      do i = 1, size(names)
         handle = dlopen(trim(names(i)) // c_null_char, 1_c_int)
         if (c_associated(handle)) exit
      end do
   end function library_handle

   !> Look for the library. To be called once before threads start.
   subroutine load_gsl(found)
      !> Whether it is there.
      logical, intent(out) :: found
      type(c_ptr) :: handle
      type(c_funptr) :: kcomp, ecomp

      found = associated(gsl_sf_ellint_kcomp)
      if (found) return
      handle = library_handle()
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
