!> K and E and the Sobol sequences of the GNU Scientific Library.
module contensou_special_gsl
   use, intrinsic :: iso_c_binding, only : c_double, c_int, c_ptr
   use contensou_base_kinds, only : i8, wp
   use contensou_base_operating_system, only : text_from_c
   implicit none(type, external)
   private

   public :: gsl_complete_ke, gsl_version
   public :: gsl_sobol_directions, sobol_bits, sobol_most_dimensions

   !> Bits of the numbers of a Sobol sequence.
   integer, parameter :: sobol_bits = 30

   !> Largest number of dimensions of a Sobol sequence.
   integer, parameter :: sobol_most_dimensions = 40

   interface
      !> K by its modulus.
      pure function ellint_kcomp(modulus, mode) result(integral) bind(c, name="gsl_sf_ellint_Kcomp")
         import :: c_double, c_int
         implicit none(type, external)
         !> Modulus sqrt(c) [-].
         real(c_double), intent(in), value :: modulus
         !> Precision; 0 is double.
         integer(c_int), intent(in), value :: mode
         real(c_double) :: integral
      end function ellint_kcomp

      !> E by its modulus.
      pure function ellint_ecomp(modulus, mode) result(integral) bind(c, name="gsl_sf_ellint_Ecomp")
         import :: c_double, c_int
         implicit none(type, external)
         !> Modulus sqrt(c) [-].
         real(c_double), intent(in), value :: modulus
         !> Precision; 0 is double.
         integer(c_int), intent(in), value :: mode
         real(c_double) :: integral
      end function ellint_ecomp

      !> Make a Sobol sequence; of gsl.c.
      type(c_ptr) function sobol_new(dimensions) bind(c, name="contensou_sobol_new")
         import :: c_int, c_ptr
         implicit none(type, external)
         !> Number of dimensions.
         integer(c_int), intent(in), value :: dimensions
      end function sobol_new

      !> Next point of a sequence.
      integer(c_int) function qrng_get(sequence, point) bind(c, name="gsl_qrng_get")
         import :: c_double, c_int, c_ptr
         implicit none(type, external)
         type(c_ptr), intent(in), value :: sequence
         real(c_double), intent(out) :: point(*)
      end function qrng_get

      subroutine qrng_free(sequence) bind(c, name="gsl_qrng_free")
         import :: c_ptr
         implicit none(type, external)
         type(c_ptr), intent(in), value :: sequence
      end subroutine qrng_free

      !> Version; of gsl.c.
      type(c_ptr) function c_version() bind(c, name="contensou_gsl_version")
         import :: c_ptr
         implicit none(type, external)
      end function c_version
   end interface

contains

   !> Version of the library in use.
   function gsl_version() result(text)
      !> Such as "2.7.1".
      character(len=:), allocatable :: text

      text = text_from_c(c_version())
   end function gsl_version

   !> Direction numbers of the Sobol sequence in the order of the library, so that point n, from 1,
   !> is the exclusive or of those of the bits of the Gray code of n.
   subroutine gsl_sobol_directions(dimensions, n, directions)
      !> Number of dimensions, 1 to `sobol_most_dimensions`.
      integer, intent(in) :: dimensions
      !> Number of points, below 2^`sobol_bits`. The time that this takes grows with it.
      integer(i8), intent(in) :: n
      !> The numbers, (bit, dimension), as many bits as n has.
      integer(i8), allocatable, intent(out) :: directions(:, :)
      type(c_ptr) :: sequence
      real(wp) :: point(dimensions)
      integer(i8) :: numerator(dimensions), before(dimensions), i
      integer(c_int) :: code
      integer :: bit, bits

      bits = 64 - leadz(n)
      allocate(directions(bits, dimensions), source=0_i8)
      sequence = sobol_new(int(dimensions, c_int))
      numerator = 0
      bit = 1
      ! Point i differs from the one before by the direction of the lowest bit of i.
      do i = 1, shiftl(1_i8, bits - 1)
         code = qrng_get(sequence, point)
         before = numerator
         numerator = nint(point*2.0_wp**sobol_bits, i8)
         if (i == shiftl(1_i8, bit - 1)) then
            directions(bit, :) = ieor(numerator, before)
            bit = bit + 1
         end if
      end do
      call qrng_free(sequence)
   end subroutine gsl_sobol_directions

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
      found = modulus*modulus < 1.0_wp
      if (found) then
         k = ellint_kcomp(modulus, 0_c_int)
         e = ellint_ecomp(modulus, 0_c_int)
      else
         k = 0.0_wp
         e = 0.0_wp
      end if
   end subroutine gsl_complete_ke

end module contensou_special_gsl
