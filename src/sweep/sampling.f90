!> Points of a unit cube by their number alone: Latin hypercubes and Sobol sequences without state.
!>
!> Latin hypercube of n points: in each dimension the points lie in the n strata [i/n, (i+1)/n) in
!> an order that a keyed permutation gives, a Feistel network on the numbers below 4^k >= n that is
!> applied again until the result is below n (cycle walking: J. Black, P. Rogaway, Ciphers with
!> arbitrary finite domains, CT-RSA 2002).
!>
!> Sobol sequence: point n is the exclusive or of the direction numbers of the bits of the Gray code
!> of n (I. A. Antonov, V. M. Saleev, USSR Comput. Math. Math. Phys. 19 (1979) 252); the direction
!> numbers are those of the GNU Scientific Library. A seed shifts all points by the same vector
!> modulo 1 (R. Cranley, T. N. L. Patterson, SIAM J. Numer. Anal. 13 (1976) 904).
module contensou_sweep_sampling
   use contensou_base_kinds, only : i8, wp
   use contensou_special_gsl, only : gsl_sobol_directions, sobol_bits, sobol_most_dimensions
   implicit none(type, external)
   private

   public :: sampler_type, sampling_names, sampling_grid, sampling_latin, sampling_sobol, &
      sampling_file
   public :: permuted, uniform, sobol_bits, sobol_most_dimensions, hash_text, hash_values

   !> Every combination of the values of all parameters.
   integer, parameter :: sampling_grid = 1

   !> A Latin hypercube.
   integer, parameter :: sampling_latin = 2

   !> A Sobol sequence.
   integer, parameter :: sampling_sobol = 3

   !> The rows of a table.
   integer, parameter :: sampling_file = 4

   character(len=*), parameter :: sampling_names(*) = [character(len=15) :: "grid", &
      "latin_hypercube", "sobol", "file"]

   !> Lowest 32 bits.
   integer(i8), parameter :: low32 = int(z"FFFFFFFF", i8)

   !> Rounds of the Feistel network.
   integer, parameter :: rounds = 8

   !> What makes the points of a unit cube.
   type :: sampler_type
      !> One of the `sampling_*` codes; Latin hypercube or Sobol sequence.
      integer :: sampling = 0
      !> Number of points.
      integer(i8) :: n = 0
      integer(i8) :: seed = 0
      !> Direction numbers, (bit, dimension).
      integer(i8), allocatable :: directions(:, :)
      !> Shift of each dimension [-].
      real(wp), allocatable :: shift(:)
   contains
      procedure :: begin
      procedure :: coordinate
   end type sampler_type

contains

   !> Prepare for a number of dimensions.
   subroutine begin(self, dimensions, shifted)
      !> The sampler; sampling, n and seed are set.
      class(sampler_type), intent(inout) :: self
      !> Number of dimensions; for a Sobol sequence at most `sobol_most_dimensions`.
      integer, intent(in) :: dimensions
      !> Whether the points of a Sobol sequence are shifted.
      logical, intent(in) :: shifted
      integer :: d

      if (self%sampling /= sampling_sobol) return
      call gsl_sobol_directions(dimensions, self%n, self%directions)
      allocate(self%shift(dimensions), source=0.0_wp)
      if (.not. shifted) return
      do d = 1, dimensions
         self%shift(d) = uniform(self%seed, d, 0_i8)
      end do
   end subroutine begin

   !> A coordinate of a point, in [0, 1).
   pure real(wp) function coordinate(self, i, d)
      class(sampler_type), intent(in) :: self
      !> Number of the point, from 1.
      integer(i8), intent(in) :: i
      !> Dimension, from 1.
      integer, intent(in) :: d
      integer(i8) :: gray, numerator
      integer :: bit

      if (self%sampling == sampling_latin) then
         coordinate = (real(permuted(i - 1, self%n, self%seed, d), wp) + uniform(self%seed, d, i)) &
            /real(self%n, wp)
      else
         gray = ieor(i, shiftr(i, 1))
         numerator = 0
         do bit = 1, size(self%directions, 1)
            if (btest(gray, bit - 1)) numerator = ieor(numerator, self%directions(bit, d))
         end do
         coordinate = real(numerator, wp)*2.0_wp**(-sobol_bits) + self%shift(d)
         if (coordinate >= 1.0_wp) coordinate = coordinate - 1.0_wp
      end if
      coordinate = min(coordinate, 1.0_wp - epsilon(coordinate))
   end function coordinate

   !> Where a keyed permutation of 0 to n - 1 sends a number.
   pure integer(i8) function permuted(i, n, seed, key)
      !> The number, from 0.
      integer(i8), intent(in) :: i
      !> How many there are, at most 2^40.
      integer(i8), intent(in) :: n
      integer(i8), intent(in) :: seed
      !> Which permutation.
      integer, intent(in) :: key
      ! On fewer numbers a Feistel network has few permutations.
      integer, parameter :: least_half = 4
      integer(i8) :: left, right, next, mask
      integer :: half, round

      half = least_half
      do while (shiftl(1_i8, 2*half) < n)
         half = half + 1
      end do
      mask = shiftl(1_i8, half) - 1
      permuted = i
      do
         left = shiftr(permuted, half)
         right = iand(permuted, mask)
         do round = 1, rounds
            next = ieor(left, iand(hash(seed, 64*key + round, right), mask))
            left = right
            right = next
         end do
         permuted = ior(shiftl(left, half), right)
         if (permuted < n) exit
      end do
   end function permuted

   !> A number in [0, 1) that looks random, always the same for the same arguments.
   pure real(wp) function uniform(seed, key, i)
      integer(i8), intent(in) :: seed
      !> Which sequence.
      integer, intent(in) :: key
      !> Number in the sequence.
      integer(i8), intent(in) :: i
      integer(i8) :: high, low

      high = hash(seed, -2*key, i)
      low = hash(seed, -2*key - 1, i)
      uniform = real(ior(shiftl(high, 21), shiftr(low, 11)), wp)*2.0_wp**(-53)
   end function uniform

   !> 32 bits that depend on all bits of the arguments.
   pure integer(i8) function hash(seed, key, i)
      integer(i8), intent(in) :: seed
      !> Which function.
      integer, intent(in) :: key
      !> Argument.
      integer(i8), intent(in) :: i

      hash = mixed(ieor(iand(seed, low32), int(z"9E3779B9", i8)))
      hash = mixed(ieor(hash, iand(shiftr(seed, 32), low32)))
      hash = mixed(ieor(hash, iand(int(key, i8), low32)))
      hash = mixed(ieor(hash, iand(i, low32)))
      hash = mixed(ieor(hash, iand(shiftr(i, 32), low32)))
   end function hash

   !> 64 bits that depend on all of a text.
   pure integer(i8) function hash_text(text)
      character(len=*), intent(in) :: text
      integer(i8) :: high, low
      integer :: i

      high = 1
      low = 2
      do i = 1, len(text)
         high = mixed(ieor(high, int(ichar(text(i:i)), i8)))
         low = mixed(ieor(low, int(ichar(text(i:i)), i8)))
      end do
      hash_text = ior(shiftl(high, 32), low)
   end function hash_text

   !> 64 bits that depend on all of a table of numbers.
   pure integer(i8) function hash_values(start, values)
      !> Bits to begin with.
      integer(i8), intent(in) :: start
      real(wp), intent(in) :: values(:, :)
      integer(i8) :: high, low
      integer :: i, k

      high = shiftr(start, 32)
      low = iand(start, low32)
      do i = 1, size(values, 2)
         do k = 1, size(values, 1)
            high = hash(high, 1, transfer(values(k, i), 0_i8))
            low = hash(low, 2, transfer(values(k, i), 0_i8))
         end do
      end do
      hash_values = ior(shiftl(high, 32), low)
   end function hash_values

   !> A permutation of the 32-bit numbers each bit of which depends on every bit (the finalizer of
   !> A. Appleby's MurmurHash3, with a start that does not leave zero where it is).
   pure integer(i8) function mixed(x)
      !> A number of 32 bits.
      integer(i8), intent(in) :: x

      mixed = iand(x + int(z"6A09E667", i8), low32)
      mixed = ieor(mixed, shiftr(mixed, 16))
      mixed = times(mixed, int(z"85EBCA6B", i8))
      mixed = ieor(mixed, shiftr(mixed, 13))
      mixed = times(mixed, int(z"C2B2AE35", i8))
      mixed = ieor(mixed, shiftr(mixed, 16))
   end function mixed

   !> Product modulo 2^32, without overflow on the way.
   pure function times(a, b) result(c)
      !> A factor of 32 bits.
      integer(i8), intent(in) :: a
      !> Another one.
      integer(i8), intent(in) :: b
      integer(i8) :: c

      c = iand(shiftl(iand(a*shiftr(b, 16), int(z"FFFF", i8)), 16) + a*iand(b, int(z"FFFF", i8)), &
         low32)
   end function times

end module contensou_sweep_sampling
