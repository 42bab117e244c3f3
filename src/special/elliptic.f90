!> Complete elliptic integrals K, E, B, D and their derivatives by the complement c1 = 1 - c of the
!> parameter c = m = k^2.
!>
!> With S = sqrt(1 - c sin^2 t), over t from 0 to pi/2: K = int 1/S dt, E = int S dt,
!> B = int cos^2 t/S dt = (E - c1 K)/c, D = int sin^2 t/S dt = (K - E)/c.
!> B and D are the primitives: K = B + D, E = B + c1 D, dK/dc = B/(2 c1), dE/dc = -D/2 are sums
!> and products of positive terms, so nothing cancels.
!>
!> Domain 0 <= c1 <= 1; NaN outside. B and D are polynomials of c1 on intervals given by the
!> exponent and the leading bits of c1; below 2^-60, B = 1 and D = log(4/sqrt(c1)) - 1,
!> with a logarithm of the same kind. Construction of the coefficients:
!> scripts/generate_elliptic.py.
!> NIST DLMF, ch. 19; T. Fukushima, J. Comput. Appl. Math. 282 (2015) 71.
module contensou_special_elliptic
   use contensou_base_kinds, only : i8, pi, wp
   use contensou_special_elliptic_tables, only : binades, intervals, log_2_leading, log_2_rest, &
      log_parts, logarithm, parts
   use contensou_special_gsl, only : gsl_complete_ke
   implicit none(type, external)
   private

   public :: complete_elliptic, complete_elliptic_bd, complete_elliptic_all
   public :: complete_elliptic_of_c, complete_elliptic_bd_of_c, complete_elliptic_all_of_c
   public :: elliptic_k, elliptic_e, elliptic_b, elliptic_d, elliptic_dk_dc, elliptic_de_dc
   public :: elliptic_k_of_c, elliptic_e_of_c, elliptic_b_of_c, elliptic_d_of_c, &
      elliptic_dk_dc_of_c, elliptic_de_dc_of_c
   public :: elliptic_kernel, elliptic_model_type, elliptic_models
   public :: elliptic_tables, elliptic_agm, elliptic_gsl

   !> K and E, or all six: (c1, k, e) or (c1, k, e, b, d, dk_dc, de_dc).
   interface complete_elliptic
      procedure :: complete_elliptic, complete_elliptic_all
   end interface complete_elliptic

   abstract interface
      !> A way to compute all six integrals.
      pure subroutine elliptic_kernel(c1, k, e, b, d, dk_dc, de_dc)
         import :: wp
         implicit none(type, external)
         !> Complement c1 = 1 - c of the parameter [-], in [0, 1].
         real(wp), intent(in) :: c1
         !> Integral K [-].
         real(wp), intent(out) :: k
         !> Integral E [-].
         real(wp), intent(out) :: e
         !> Integral B [-].
         real(wp), intent(out) :: b
         !> Integral D [-].
         real(wp), intent(out) :: d
         !> Derivative dK/dc [-].
         real(wp), intent(out) :: dk_dc
         !> Derivative dE/dc [-].
         real(wp), intent(out) :: de_dc
      end subroutine elliptic_kernel
   end interface

   !> An entry of the table of ways to compute them.
   type :: elliptic_model_type
      character(len=24) :: name = ""
      !> One line: what it is.
      character(len=160) :: summary = ""
      !> Where it comes from.
      character(len=120) :: reference = ""
      procedure(elliptic_kernel), pointer, nopass :: kernel => null()
   end type elliptic_model_type

   !> Bits of the mantissa of a double.
   integer, parameter :: mantissa = 52

   !> Offset of the exponent in the bits of a double.
   integer(i8), parameter :: bias = 1023_i8

   !> Number of trailing bits that do not matter for the interval.
   integer, parameter :: behind_part = mantissa - trailz(parts)

   !> Number of trailing bits that do not matter for the interval of the logarithm.
   integer, parameter :: behind_log_part = mantissa - trailz(log_parts)

   !> Exponent of the smallest c1 that is computed by tables; nothing underflows above it.
   integer(i8), parameter :: least_exponent = -1000_i8

   !> Leading bits of the smallest c1 with an interval of its own.
   integer(i8), parameter :: first_interval = parts*(bias - binades)

   !> Leading bits of the last interval, which ends with 1.
   integer(i8), parameter :: last_interval = parts*bias - 1_i8

   !> Leading bits of the smallest c1 that is computed by tables.
   integer(i8), parameter :: first_regular = parts*(bias + least_exponent)

contains

   !> B and D where c1 is in (2^-1000, 1]; elsewhere they are not set.
   pure subroutine regular(c1, bd, found)
      !> Complement c1 = 1 - c of the parameter [-].
      real(wp), intent(in) :: c1
      !> Integrals B and D [-]; one array, so that both are computed by the same instructions.
      real(wp), intent(out) :: bd(2)
      !> Whether c1 is there.
      logical, intent(out) :: found
      integer(i8) :: bits, part, i
      real(wp) :: t(2), s(2), p(2), u, v, g, half

      ! The bits of a positive double grow with it; those of a negative one are a negative number.
      ! One less puts the upper end of an interval into it. Comparing bits never meets a NaN.
      bits = max(transfer(c1, bits), 1_i8)
      part = shiftr(bits - 1_i8, behind_part)
      found = part >= first_regular .and. part <= last_interval
      if (part >= first_interval .and. part <= last_interval) then
         i = part - first_interval
         ! Even and odd terms apart for shorter chains.
         t = c1 - intervals(:, 0, i)
         s = t*t
         p = (intervals(:, 9, i) + t*intervals(:, 10, i)) + s*intervals(:, 11, i)
         p = (intervals(:, 7, i) + t*intervals(:, 8, i)) + s*p
         p = (intervals(:, 5, i) + t*intervals(:, 6, i)) + s*p
         p = (intervals(:, 3, i) + t*intervals(:, 4, i)) + s*p
         bd = intervals(:, 1, i) + (t*intervals(:, 2, i) + s*p)
      else if (found) then
         ! B = 1, D = log(4/sqrt(c1)) - 1 = -(e/2) log 2 + g(m) for c1 = 2^e m, 1 < m <= 2. The sum
         ! of the leading terms is exact.
         i = shiftr(part, trailz(parts)) - bias
         half = -0.5_wp*real(i, wp)
         u = transfer(bits - shiftl(i, mantissa), u)
         i = iand(shiftr(bits - 1_i8, behind_log_part), log_parts - 1_i8)
         u = u - logarithm(0, i)
         v = u*u
         g = u*(logarithm(2, i) + v*(logarithm(4, i) + v*logarithm(6, i)))
         g = g + v*(logarithm(3, i) + v*(logarithm(5, i) + v*logarithm(7, i)))
         bd(1) = 1.0_wp
         bd(2) = (half*log_2_leading + logarithm(1, i)) + (half*log_2_rest + g)
      end if
   end subroutine regular

   !> Integrals where c1 is 0, below 2^-1000, outside the domain, or not a number.
   pure subroutine irregular(c1, k, e, b, d, dk_dc, de_dc)
      use, intrinsic :: ieee_arithmetic, only : ieee_is_nan, ieee_positive_inf, ieee_quiet_nan, &
         ieee_value
      !> Complement c1 = 1 - c of the parameter [-].
      real(wp), intent(in) :: c1
      !> Integral K [-].
      real(wp), intent(out) :: k
      !> Integral E [-].
      real(wp), intent(out) :: e
      !> Integral B [-].
      real(wp), intent(out) :: b
      !> Integral D [-].
      real(wp), intent(out) :: d
      !> Derivative dK/dc [-].
      real(wp), intent(out) :: dk_dc
      !> Derivative dE/dc [-].
      real(wp), intent(out) :: de_dc
      logical :: inside

      inside = .not. ieee_is_nan(c1)
      if (inside) inside = c1 >= 0.0_wp .and. c1 <= 1.0_wp
      if (.not. inside) then
         k = ieee_value(k, ieee_quiet_nan)
         e = k
         b = k
         d = k
         dk_dc = k
         de_dc = k
         return
      end if
      e = 1.0_wp
      b = 1.0_wp
      dk_dc = ieee_value(dk_dc, ieee_positive_inf)
      if (c1 > 0.0_wp) then
         k = log(4.0_wp) - 0.5_wp*log(c1)
         d = k - 1.0_wp
         ! The quotient must not overflow.
         if (c1*huge(c1) > 0.5_wp) dk_dc = 0.5_wp/c1
         de_dc = -0.5_wp*d
      else
         k = dk_dc
         d = dk_dc
         de_dc = -dk_dc
      end if
   end subroutine irregular

   !> Complement of a parameter; a number outside the domain for a negative one.
   pure elemental function complement(c) result(c1)
      !> Parameter c [-].
      real(wp), intent(in) :: c
      real(wp) :: c1
      integer(i8) :: bits

      ! The difference rounds a negative c of small size to the complement 1. Minus zero is zero.
      bits = transfer(c, bits)
      c1 = 1.0_wp - c
      if (bits < 0_i8 .and. shiftl(bits, 1) /= 0_i8) c1 = -1.0_wp
   end function complement

   !> Whether c1 is in (2^-1022, 1], where nothing overflows.
   pure function is_normal(c1)
      !> Complement c1 = 1 - c of the parameter [-].
      real(wp), intent(in) :: c1
      logical :: is_normal
      integer(i8) :: part

      part = shiftr(max(transfer(c1, part), 1_i8) - 1_i8, behind_part)
      is_normal = part >= parts .and. part <= last_interval
   end function is_normal

   !> Integrals K and E.
   pure elemental subroutine complete_elliptic(c1, k, e)
      !> Complement c1 = 1 - c of the parameter [-], in [0, 1].
      real(wp), intent(in) :: c1
      !> Integral K [-].
      real(wp), intent(out) :: k
      !> Integral E [-].
      real(wp), intent(out) :: e
      real(wp) :: bd(2), b, d, dk_dc, de_dc
      logical :: found

      call regular(c1, bd, found)
      if (found) then
         k = bd(1) + bd(2)
         e = bd(1) + c1*bd(2)
      else
         call irregular(c1, k, e, b, d, dk_dc, de_dc)
      end if
   end subroutine complete_elliptic

   !> Integrals B and D.
   pure elemental subroutine complete_elliptic_bd(c1, b, d)
      !> Complement c1 = 1 - c of the parameter [-], in [0, 1].
      real(wp), intent(in) :: c1
      !> Integral B [-].
      real(wp), intent(out) :: b
      !> Integral D [-].
      real(wp), intent(out) :: d
      real(wp) :: bd(2), k, e, dk_dc, de_dc
      logical :: found

      call regular(c1, bd, found)
      if (found) then
         b = bd(1)
         d = bd(2)
      else
         call irregular(c1, k, e, b, d, dk_dc, de_dc)
      end if
   end subroutine complete_elliptic_bd

   !> All integrals and derivatives.
   pure elemental subroutine complete_elliptic_all(c1, k, e, b, d, dk_dc, de_dc)
      !> Complement c1 = 1 - c of the parameter [-], in [0, 1].
      real(wp), intent(in) :: c1
      !> Integral K [-].
      real(wp), intent(out) :: k
      !> Integral E [-].
      real(wp), intent(out) :: e
      !> Integral B [-].
      real(wp), intent(out) :: b
      !> Integral D [-].
      real(wp), intent(out) :: d
      !> Derivative dK/dc [-].
      real(wp), intent(out) :: dk_dc
      !> Derivative dE/dc [-].
      real(wp), intent(out) :: de_dc
      real(wp) :: bd(2)
      logical :: found

      call regular(c1, bd, found)
      if (found) then
         b = bd(1)
         d = bd(2)
         k = b + d
         e = b + c1*d
         dk_dc = b/(c1 + c1)
         de_dc = -0.5_wp*d
      else
         call irregular(c1, k, e, b, d, dk_dc, de_dc)
      end if
   end subroutine complete_elliptic_all

   !> Integrals K and E by the parameter.
   pure elemental subroutine complete_elliptic_of_c(c, k, e)
      !> Parameter c [-], in [0, 1].
      real(wp), intent(in) :: c
      !> Integral K [-].
      real(wp), intent(out) :: k
      !> Integral E [-].
      real(wp), intent(out) :: e

      call complete_elliptic(complement(c), k, e)
   end subroutine complete_elliptic_of_c

   !> Integrals B and D by the parameter.
   pure elemental subroutine complete_elliptic_bd_of_c(c, b, d)
      !> Parameter c [-], in [0, 1].
      real(wp), intent(in) :: c
      !> Integral B [-].
      real(wp), intent(out) :: b
      !> Integral D [-].
      real(wp), intent(out) :: d

      call complete_elliptic_bd(complement(c), b, d)
   end subroutine complete_elliptic_bd_of_c

   !> All integrals and derivatives by the parameter.
   pure elemental subroutine complete_elliptic_all_of_c(c, k, e, b, d, dk_dc, de_dc)
      !> Parameter c [-], in [0, 1].
      real(wp), intent(in) :: c
      !> Integral K [-].
      real(wp), intent(out) :: k
      !> Integral E [-].
      real(wp), intent(out) :: e
      !> Integral B [-].
      real(wp), intent(out) :: b
      !> Integral D [-].
      real(wp), intent(out) :: d
      !> Derivative dK/dc [-].
      real(wp), intent(out) :: dk_dc
      !> Derivative dE/dc [-].
      real(wp), intent(out) :: de_dc

      call complete_elliptic_all(complement(c), k, e, b, d, dk_dc, de_dc)
   end subroutine complete_elliptic_all_of_c

   !> Integral K [-].
   pure elemental function elliptic_k(c1) result(k)
      !> Complement c1 = 1 - c of the parameter [-], in [0, 1].
      real(wp), intent(in) :: c1
      real(wp) :: k
      real(wp) :: e

      call complete_elliptic(c1, k, e)
   end function elliptic_k

   !> Integral E [-].
   pure elemental function elliptic_e(c1) result(e)
      !> Complement c1 = 1 - c of the parameter [-], in [0, 1].
      real(wp), intent(in) :: c1
      real(wp) :: e
      real(wp) :: k

      call complete_elliptic(c1, k, e)
   end function elliptic_e

   !> Integral B [-].
   pure elemental function elliptic_b(c1) result(b)
      !> Complement c1 = 1 - c of the parameter [-], in [0, 1].
      real(wp), intent(in) :: c1
      real(wp) :: b
      real(wp) :: d

      call complete_elliptic_bd(c1, b, d)
   end function elliptic_b

   !> Integral D [-].
   pure elemental function elliptic_d(c1) result(d)
      !> Complement c1 = 1 - c of the parameter [-], in [0, 1].
      real(wp), intent(in) :: c1
      real(wp) :: d
      real(wp) :: b

      call complete_elliptic_bd(c1, b, d)
   end function elliptic_d

   !> Derivative dK/dc [-].
   pure elemental function elliptic_dk_dc(c1) result(dk_dc)
      !> Complement c1 = 1 - c of the parameter [-], in [0, 1].
      real(wp), intent(in) :: c1
      real(wp) :: dk_dc
      real(wp) :: k, e, b, d, de_dc

      call complete_elliptic_all(c1, k, e, b, d, dk_dc, de_dc)
   end function elliptic_dk_dc

   !> Derivative dE/dc [-].
   pure elemental function elliptic_de_dc(c1) result(de_dc)
      !> Complement c1 = 1 - c of the parameter [-], in [0, 1].
      real(wp), intent(in) :: c1
      real(wp) :: de_dc
      real(wp) :: k, e, b, d, dk_dc

      call complete_elliptic_all(c1, k, e, b, d, dk_dc, de_dc)
   end function elliptic_de_dc

   !> Integral K by the parameter [-].
   pure elemental function elliptic_k_of_c(c) result(k)
      !> Parameter c [-], in [0, 1].
      real(wp), intent(in) :: c
      real(wp) :: k

      k = elliptic_k(complement(c))
   end function elliptic_k_of_c

   !> Integral E by the parameter [-].
   pure elemental function elliptic_e_of_c(c) result(e)
      !> Parameter c [-], in [0, 1].
      real(wp), intent(in) :: c
      real(wp) :: e

      e = elliptic_e(complement(c))
   end function elliptic_e_of_c

   !> Integral B by the parameter [-].
   pure elemental function elliptic_b_of_c(c) result(b)
      !> Parameter c [-], in [0, 1].
      real(wp), intent(in) :: c
      real(wp) :: b

      b = elliptic_b(complement(c))
   end function elliptic_b_of_c

   !> Integral D by the parameter [-].
   pure elemental function elliptic_d_of_c(c) result(d)
      !> Parameter c [-], in [0, 1].
      real(wp), intent(in) :: c
      real(wp) :: d

      d = elliptic_d(complement(c))
   end function elliptic_d_of_c

   !> Derivative dK/dc by the parameter [-].
   pure elemental function elliptic_dk_dc_of_c(c) result(dk_dc)
      !> Parameter c [-], in [0, 1].
      real(wp), intent(in) :: c
      real(wp) :: dk_dc

      dk_dc = elliptic_dk_dc(complement(c))
   end function elliptic_dk_dc_of_c

   !> Derivative dE/dc by the parameter [-].
   pure elemental function elliptic_de_dc_of_c(c) result(de_dc)
      !> Parameter c [-], in [0, 1].
      real(wp), intent(in) :: c
      real(wp) :: de_dc

      de_dc = elliptic_de_dc(complement(c))
   end function elliptic_de_dc_of_c

   !> Table of the ways to compute the integrals.
   function elliptic_models() result(models)
      type(elliptic_model_type), allocatable :: models(:)

      allocate(models(4))
      models(1)%name = "tables"
      models(1)%summary = "piecewise polynomials of B and D, indexed by the bits of c1"
      models(1)%reference = "scripts/generate_elliptic.py; NIST DLMF 19.12"
      models(1)%kernel => elliptic_tables
      models(2)%name = "theta"
      models(2)%summary = "theta and Lambert series in the nome, " // &
         "which is a truncated series itself: poor near c = 1"
      models(2)%reference = "Kosenko and Aleksandrov, 7th Modelica Conference (2009) 288"
      models(2)%kernel => elliptic_theta
      models(3)%name = "agm"
      models(3)%summary = "arithmetic-geometric mean of 1 and sqrt(c1)"
      models(3)%reference = "C. F. Gauss; NIST DLMF 19.8"
      models(3)%kernel => elliptic_agm
      models(4)%name = "gsl"
      models(4)%summary = "K and E of the GNU Scientific Library by the modulus sqrt(1 - c1), " // &
         "the others from them: cancel for small c; not a number where c rounds to 1"
      models(4)%reference = "GNU Scientific Library, gsl_sf_ellint_Kcomp and gsl_sf_ellint_Ecomp"
      models(4)%kernel => elliptic_gsl
   end function elliptic_models

   !> All integrals by the tables.
   pure subroutine elliptic_tables(c1, k, e, b, d, dk_dc, de_dc)
      !> Complement c1 = 1 - c of the parameter [-], in [0, 1].
      real(wp), intent(in) :: c1
      !> Integral K [-].
      real(wp), intent(out) :: k
      !> Integral E [-].
      real(wp), intent(out) :: e
      !> Integral B [-].
      real(wp), intent(out) :: b
      !> Integral D [-].
      real(wp), intent(out) :: d
      !> Derivative dK/dc [-].
      real(wp), intent(out) :: dk_dc
      !> Derivative dE/dc [-].
      real(wp), intent(out) :: de_dc

      call complete_elliptic_all(c1, k, e, b, d, dk_dc, de_dc)
   end subroutine elliptic_tables

   !> All integrals by theta functions, as in the paper.
   !>
   !> eps = (1 - c1^(1/4))/(2 (1 + c1^(1/4))),
   !> q = eps + 2 eps^5 + 15 eps^9 + 150 eps^13 + 1707 eps^17,
   !> K = (pi/2) theta_3(q)^2, E = K - (2 pi^2/K) sum n q^n/(1 - q^(2n)).
   !> I. Kosenko and E. Aleksandrov, 7th Modelica Conference (2009) 288.
   pure subroutine elliptic_theta(c1, k, e, b, d, dk_dc, de_dc)
      !> Complement c1 = 1 - c of the parameter [-], in [0, 1].
      real(wp), intent(in) :: c1
      !> Integral K [-].
      real(wp), intent(out) :: k
      !> Integral E [-].
      real(wp), intent(out) :: e
      !> Integral B [-].
      real(wp), intent(out) :: b
      !> Integral D [-].
      real(wp), intent(out) :: d
      !> Derivative dK/dc [-].
      real(wp), intent(out) :: dk_dc
      !> Derivative dE/dc [-].
      real(wp), intent(out) :: de_dc
      real(wp) :: c, eps, eps_4, q, power, square, term, total
      integer :: n

      if (.not. is_normal(c1)) then
         call irregular(c1, k, e, b, d, dk_dc, de_dc)
         return
      end if
      c = 1.0_wp - c1
      eps = sqrt(sqrt(c1))
      eps = (1.0_wp - eps)/(2.0_wp*(1.0_wp + eps))
      eps_4 = eps**4
      q = eps*(1.0_wp + eps_4*(2.0_wp + eps_4*(15.0_wp + eps_4*(150.0_wp + eps_4*1707.0_wp))))
      ! q < 0.624: nine terms of q^(n^2) are enough.
      total = 0.0_wp
      power = q
      square = q*q
      term = q
      do n = 1, 9
         total = total + term
         power = power*square
         term = term*power
         if (term < epsilon(term)*q) exit
      end do
      k = 0.5_wp*pi*(1.0_wp + 2.0_wp*total)**2
      total = 0.0_wp
      power = q
      do n = 1, 100
         term = n*power/(1.0_wp - power*power)
         total = total + term
         if (term <= 0.1_wp*epsilon(term)*total) exit
         power = power*q
      end do
      total = (2.0_wp*pi**2)*total/k
      e = k - total
      if (c > 0.0_wp) then
         d = total/c
         b = k - d
      else
         d = 0.25_wp*pi
         b = d
      end if
      dk_dc = b/(c1 + c1)
      de_dc = -0.5_wp*d
   end subroutine elliptic_theta

   !> All integrals by the arithmetic-geometric mean of 1 and sqrt(c1).
   !>
   !> With c_0^2 = c, c_(n+1) = c_n^2/(4 a_(n+1)): K = pi/(2 a), D = K s, B = K (1 - s),
   !> s = sum 2^(n-1) c_n^2/c. DLMF 19.8.5 and 19.8.6. B cancels for small c1.
   pure subroutine elliptic_agm(c1, k, e, b, d, dk_dc, de_dc)
      !> Complement c1 = 1 - c of the parameter [-], in [0, 1].
      real(wp), intent(in) :: c1
      !> Integral K [-].
      real(wp), intent(out) :: k
      !> Integral E [-].
      real(wp), intent(out) :: e
      !> Integral B [-].
      real(wp), intent(out) :: b
      !> Integral D [-].
      real(wp), intent(out) :: d
      !> Derivative dK/dc [-].
      real(wp), intent(out) :: dk_dc
      !> Derivative dE/dc [-].
      real(wp), intent(out) :: de_dc
      real(wp) :: a, g, z, mean, power, s

      if (.not. is_normal(c1)) then
         call irregular(c1, k, e, b, d, dk_dc, de_dc)
         return
      end if
      g = sqrt(c1)
      ! z = c_n^2/c, from n = 1.
      z = 0.25_wp*(1.0_wp - g)/(1.0_wp + g)
      a = 0.5_wp*(1.0_wp + g)
      g = sqrt(g)
      power = 1.0_wp
      s = 0.5_wp + z
      do while (power*z > 0.1_wp*epsilon(s))
         mean = 0.5_wp*(a + g)
         z = (0.25_wp*z/mean)**2*(1.0_wp - c1)
         g = sqrt(a*g)
         a = mean
         power = 2.0_wp*power
         s = s + power*z
      end do
      k = pi/(a + g)
      d = k*s
      b = k*(1.0_wp - s)
      e = b + c1*d
      dk_dc = b/(c1 + c1)
      de_dc = -0.5_wp*d
   end subroutine elliptic_agm

   !> All integrals from K and E of the GNU Scientific Library.
   !>
   !> NaN where c rounds to 1.
   pure subroutine elliptic_gsl(c1, k, e, b, d, dk_dc, de_dc)
      !> Complement c1 = 1 - c of the parameter [-], in [0, 1].
      real(wp), intent(in) :: c1
      !> Integral K [-].
      real(wp), intent(out) :: k
      !> Integral E [-].
      real(wp), intent(out) :: e
      !> Integral B [-].
      real(wp), intent(out) :: b
      !> Integral D [-].
      real(wp), intent(out) :: d
      !> Derivative dK/dc [-].
      real(wp), intent(out) :: dk_dc
      !> Derivative dE/dc [-].
      real(wp), intent(out) :: de_dc
      real(wp) :: c
      logical :: found

      if (.not. is_normal(c1)) then
         call irregular(c1, k, e, b, d, dk_dc, de_dc)
         return
      end if
      c = 1.0_wp - c1
      call gsl_complete_ke(sqrt(c), k, e, found)
      if (.not. found) then
         call irregular(-1.0_wp, k, e, b, d, dk_dc, de_dc)
         return
      end if
      if (c > 0.0_wp) then
         b = (e - c1*k)/c
         d = (k - e)/c
      else
         b = 0.25_wp*pi
         d = b
      end if
      dk_dc = b/(c1 + c1)
      de_dc = -0.5_wp*d
   end subroutine elliptic_gsl

end module contensou_special_elliptic
