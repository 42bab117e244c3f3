!> Hertz contact of elastic bodies: curvatures, effective modulus, approach -> elliptic spot, force,
!> pressure; and back from force to approach.
!>
!> Undeformed gap h = A x^2 + B y^2 with 0 < A <= B, x along the major axis; approach d, g = A/B.
!> With the complete elliptic integrals K, B, D of the parameter c = 1 - c1, c1 = (b/a)^2, the shape
!> of the spot follows from g = c1 D/B. In terms of t(g) = B/K:
!> c1 = g t/(1 - t), a = sqrt((1 - t) d/A), b = sqrt(t d/B), N = (2 pi/3) E* a d/K = k_n d^(3/2),
!> p0 = 3 N/(2 pi a b) = E* d/(K b), E = K t (1 + g).
!> t and 1/K are tabulated over g, so the exact contact costs two polynomials. On the circle
!> t = 1/2, K = pi/2: a = sqrt(R d), N = (4/3) E* sqrt(R) d^(3/2), R = 1/(2 A).
!>
!> Domain: A, B, E* from 2^-128 to below 2^128 in SI units, A <= B, 0 <= d < 2^128; quiet NaN
!> outside, also for A > B, since a is measured along the axis of A. Nothing overflows inside.
!> H. Hertz, J. reine angew. Math. 92 (1881) 156; K. L. Johnson, Contact Mechanics, 1985, ch. 4;
!> I. Kosenko and E. Aleksandrov, 7th Modelica Conference (2009) 288, eq. (6).
module contensou_contact_hertz
   use, intrinsic :: ieee_arithmetic, only : ieee_is_nan, ieee_quiet_nan, ieee_value
   use contensou_base_kinds, only : i8, pi, wp
   use contensou_contact_catalogue, only : model_info_type
   use contensou_contact_hertz_tables, only : full_low, full_table, segment_bits, slender_table
   use contensou_special_elliptic, only : elliptic_kernel, elliptic_tables
   implicit none(type, external)
   private

   public :: effective_modulus
   public :: hertz_contact, hertz_shape, hertz_approach, in_hertz_domain
   public :: hertz_type, hertz_spot_type, no_spot, new_hertz
   public :: hertz_kernel, hertz_model_type, hertz_models
   public :: hertz_newton_with

   !> Spot and force of a contact; NaN outside the domain.
   type :: hertz_spot_type
      !> Complementary parameter c1 = (b/a)^2 [-].
      real(wp) :: c1
      !> Major semi-axis a [m].
      real(wp) :: a
      !> Minor semi-axis b [m].
      real(wp) :: b
      !> Force N [N].
      real(wp) :: force
      !> Largest pressure p0 [Pa].
      real(wp) :: pressure
   end type hertz_spot_type

   abstract interface
      !> A way to compute a contact.
      pure subroutine hertz_kernel(curvature_a, curvature_b, modulus, approach, spot)
         import :: hertz_spot_type, wp
         implicit none(type, external)
         !> Half relative curvature A along the major axis [1/m], > 0.
         real(wp), intent(in) :: curvature_a
         !> Half relative curvature B along the minor axis [1/m], >= A.
         real(wp), intent(in) :: curvature_b
         !> Effective modulus E* [Pa], > 0.
         real(wp), intent(in) :: modulus
         !> Approach d [m], >= 0.
         real(wp), intent(in) :: approach
         type(hertz_spot_type), intent(out) :: spot
      end subroutine hertz_kernel
   end interface

   !> An entry of the table of ways to compute a contact.
   type :: hertz_model_type
      type(model_info_type) :: info
      procedure(hertz_kernel), pointer, nopass :: kernel => null()
   end type hertz_model_type

   !> Contact whose curvatures do not change: all but the approach is computed once.
   type :: hertz_type
      !> Stiffness k_n of N = k_n d^(3/2) [N/m^(3/2)].
      real(wp) :: stiffness = 0.0_wp
      !> Complementary parameter c1 = (b/a)^2 of the spot [-].
      real(wp) :: c1 = 1.0_wp
      !> a/sqrt(d) [m^(1/2)].
      real(wp) :: axis_a = 0.0_wp
      !> b/sqrt(d) [m^(1/2)].
      real(wp) :: axis_b = 0.0_wp
      !> p0/sqrt(d) [Pa/m^(1/2)].
      real(wp) :: pressure = 0.0_wp
   contains
      procedure :: contact
      procedure :: force
      procedure :: energy
      procedure :: approach
      procedure :: scale_from
   end type hertz_type

   !> Makes a contact from its curvatures A <= B [1/m] and the effective modulus [Pa].
   interface hertz_type
      procedure :: new_hertz
   end interface hertz_type

   !> Bits of a double below its exponent.
   integer, parameter :: exponent_bits = 52

   !> Exponent, as stored, of the lower bound of the domain, 2^-128.
   integer(i8), parameter :: exponent_low = 895_i8

   !> Binary logarithm of the number of exponents in the domain.
   integer, parameter :: exponent_range = 8

   !> Lower bound of the domain of the ratio of the curvatures [-].
   real(wp), parameter :: ratio_low = 2.0_wp**(-256)

   !> Factor of the force.
   real(wp), parameter :: two_pi_thirds = 2.0_wp*pi/3.0_wp

contains

   !> Effective modulus of two materials [Pa], 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2.
   pure function effective_modulus(young_a, poisson_a, young_b, poisson_b) result(modulus)
      !> Young's modulus of the first material [Pa], > 0.
      real(wp), intent(in) :: young_a
      !> Poisson's ratio of the first material, in (-1, 0.5].
      real(wp), intent(in) :: poisson_a
      !> Young's modulus of the second material [Pa], > 0.
      real(wp), intent(in) :: young_b
      !> Poisson's ratio of the second material, in (-1, 0.5].
      real(wp), intent(in) :: poisson_b
      real(wp) :: modulus

      modulus = 1.0_wp/((1.0_wp - poisson_a**2)/young_a + (1.0_wp - poisson_b**2)/young_b)
   end function effective_modulus

   !> Spot, force and largest pressure of a contact, exact to rounding.
   pure subroutine hertz_contact(curvature_a, curvature_b, modulus, approach, spot)
      real(wp), intent(in) :: curvature_a, curvature_b, modulus, approach
      type(hertz_spot_type), intent(out) :: spot
      real(wp) :: g, pair(2), t, inverse_k, t1, product

      if (.not. in_range(curvature_a, curvature_b, modulus, approach)) then
         call hertz_edge(curvature_a, curvature_b, modulus, approach, spot)
         return
      end if
      g = curvature_a/curvature_b
      if (g < full_low) then
         call slender_shape(g, pair)
      else
         call full_shape(g, pair)
      end if
      t = pair(1)
      inverse_k = pair(2)
      t1 = 1.0_wp - t
      spot%a = sqrt(t1*(approach/curvature_a))
      spot%c1 = g*t/t1
      spot%b = sqrt(t*(approach/curvature_b))
      product = modulus*approach*inverse_k
      spot%force = two_pi_thirds*product*spot%a
      spot%pressure = product/spot%b
   end subroutine hertz_contact

   !> Contact outside the range of `hertz_contact`: zero or a very small approach, or no contact.
   pure subroutine hertz_edge(curvature_a, curvature_b, modulus, approach, spot)
      !> Half relative curvature A along the major axis [1/m].
      real(wp), intent(in) :: curvature_a
      !> Half relative curvature B along the minor axis [1/m].
      real(wp), intent(in) :: curvature_b
      !> Effective modulus E* [Pa].
      real(wp), intent(in) :: modulus
      !> Approach d [m].
      real(wp), intent(in) :: approach
      type(hertz_spot_type), intent(out) :: spot
      real(wp) :: t, inverse_k, axis_a, axis_b, root

      if (.not. in_hertz_domain(curvature_a, curvature_b, modulus, approach)) then
         spot = no_spot()
         return
      end if
      call hertz_shape(curvature_a/curvature_b, spot%c1, t, inverse_k)
      ! Here d < 2^-128, so a product with d may be smaller than any number, but not with sqrt(d).
      root = sqrt(approach)
      axis_a = sqrt((1.0_wp - t)/curvature_a)
      axis_b = sqrt(t/curvature_b)
      spot%a = axis_a*root
      spot%b = axis_b*root
      spot%force = two_pi_thirds*modulus*inverse_k*axis_a*approach*root
      spot%pressure = modulus*inverse_k/axis_b*root
   end subroutine hertz_edge

   !> Shape of the spot: all that depends on the ratio of the curvatures alone.
   pure subroutine hertz_shape(g, c1, t, inverse_k)
      !> Ratio g = A/B of the curvatures [-], in [2^-256, 1]; NaN outside.
      real(wp), intent(in) :: g
      !> Complementary parameter c1 = (b/a)^2 [-].
      real(wp), intent(out) :: c1
      !> Ratio t = B/K of elliptic integrals [-], in (0, 1/2].
      real(wp), intent(out) :: t
      !> 1/K [-].
      real(wp), intent(out) :: inverse_k
      integer(i8) :: bits
      real(wp) :: pair(2)

      bits = transfer(g, bits)
      ! Numbers that are not negative are in the order of their bits.
      if (bits < transfer(ratio_low, 0_i8) .or. bits > transfer(1.0_wp, 0_i8)) then
         t = ieee_value(t, ieee_quiet_nan)
         inverse_k = t
         c1 = t
         return
      end if
      if (g < full_low) then
         call slender_shape(g, pair)
      else
         call full_shape(g, pair)
      end if
      t = pair(1)
      inverse_k = pair(2)
      c1 = g*t/(1.0_wp - t)
   end subroutine hertz_shape

   !> t and 1/K of a spot that is not slender.
   pure subroutine full_shape(g, pair)
      !> Ratio g = A/B of the curvatures [-], in [2^-10, 1].
      real(wp), intent(in) :: g
      !> t = B/K and 1/K [-]; one array, so that both are computed by the same instructions.
      real(wp), intent(out) :: pair(2)
      real(wp) :: h, h2, h4

      associate (p => full_table(:, :, shiftr(transfer(g, 0_i8), segment_bits)))
         h = g - p(1, 1)
         h2 = h*h
         h4 = h2*h2
         pair = p(:, 2) + ((h*p(:, 3) + h2*(p(:, 4) + h*p(:, 5))) &
            + h4*((p(:, 6) + h*p(:, 7)) + h2*(p(:, 8) + h*p(:, 9) + h2*p(:, 10))))
      end associate
   end subroutine full_shape

   !> t and 1/K of a slender spot.
   pure subroutine slender_shape(g, pair)
      !> Ratio g = A/B of the curvatures [-], in [2^-256, 2^-10].
      real(wp), intent(in) :: g
      !> t = B/K and 1/K [-].
      real(wp), intent(out) :: pair(2)
      real(wp) :: y, h, h2, h4

      y = -log(g)
      associate (p => slender_table(:, :, shiftr(transfer(y, 0_i8), segment_bits)))
         h = y - p(1, 1)
         h2 = h*h
         h4 = h2*h2
         pair = p(:, 2) + ((p(:, 3) + h*p(:, 4) + h2*(p(:, 5) + h*p(:, 6))) &
            + h4*((p(:, 7) + h*p(:, 8)) + h2*(p(:, 9) + h*p(:, 10)) + h4*(p(:, 11) + h*p(:, 12))))
      end associate
   end subroutine slender_shape

   !> Whether A, B, E* and d are in [2^-128, 2^128) and A <= B; NaN is not, and raises no exception.
   pure function in_range(curvature_a, curvature_b, modulus, approach) result(inside)
      !> Half relative curvature A [1/m].
      real(wp), intent(in) :: curvature_a
      !> Half relative curvature B [1/m].
      real(wp), intent(in) :: curvature_b
      !> Effective modulus E* [Pa].
      real(wp), intent(in) :: modulus
      !> Approach d [m].
      real(wp), intent(in) :: approach
      logical :: inside
      integer(i8) :: bits_a, bits_b, bits_e, bits_d, excess

      bits_a = transfer(curvature_a, bits_a)
      bits_b = transfer(curvature_b, bits_b)
      bits_e = transfer(modulus, bits_e)
      bits_d = transfer(approach, bits_d)
      ! Sign and exponent less the lowest one: all bits above the lower eight are to be zero.
      excess = ior( &
         ior(shiftr(bits_a, exponent_bits) - exponent_low, &
         shiftr(bits_b, exponent_bits) - exponent_low), &
         ior(shiftr(bits_e, exponent_bits) - exponent_low, &
         shiftr(bits_d, exponent_bits) - exponent_low))
      ! Numbers that are not negative are in the order of their bits.
      inside = bits_a <= bits_b .and. shiftr(excess, exponent_range) == 0_i8
   end function in_range

   !> Whether a contact is in the domain of `hertz_contact`; raises no exception.
   pure function in_hertz_domain(curvature_a, curvature_b, modulus, approach) result(inside)
      !> Half relative curvature A [1/m].
      real(wp), intent(in) :: curvature_a
      !> Half relative curvature B [1/m].
      real(wp), intent(in) :: curvature_b
      !> Effective modulus E* [Pa].
      real(wp), intent(in) :: modulus
      !> Approach d [m].
      real(wp), intent(in) :: approach
      logical :: inside

      inside = .not. ieee_is_nan(approach)
      if (inside) inside = approach >= 0.0_wp
      ! Any approach from zero on is as good as 1 m where it is below 1 m.
      if (inside) inside = in_range(curvature_a, curvature_b, modulus, max(approach, 1.0_wp))
   end function in_hertz_domain

   !> Contact whose curvatures do not change; its components are NaN outside the domain.
   pure function new_hertz(curvature_a, curvature_b, modulus) result(self)
      !> Half relative curvature A along the major axis [1/m], > 0.
      real(wp), intent(in) :: curvature_a
      !> Half relative curvature B along the minor axis [1/m], >= A.
      real(wp), intent(in) :: curvature_b
      !> Effective modulus E* [Pa], > 0.
      real(wp), intent(in) :: modulus
      type(hertz_type) :: self
      type(hertz_spot_type) :: spot

      call hertz_contact(curvature_a, curvature_b, modulus, 1.0_wp, spot)
      call self%scale_from(spot)
   end function new_hertz

   !> Take over the contact of an approach of 1 m.
   pure subroutine scale_from(self, spot)
      class(hertz_type), intent(inout) :: self
      type(hertz_spot_type), intent(in) :: spot

      self%stiffness = spot%force
      self%c1 = spot%c1
      self%axis_a = spot%a
      self%axis_b = spot%b
      self%pressure = spot%pressure
   end subroutine scale_from

   !> NaN, for what is outside the domain.
   pure function no_spot() result(spot)
      type(hertz_spot_type) :: spot

      spot%c1 = ieee_value(spot%c1, ieee_quiet_nan)
      spot = hertz_spot_type(spot%c1, spot%c1, spot%c1, spot%c1, spot%c1)
   end function no_spot

   !> Spot, force and largest pressure.
   pure subroutine contact(self, approach, spot)
      class(hertz_type), intent(in) :: self
      !> Approach d [m], >= 0.
      real(wp), intent(in) :: approach
      type(hertz_spot_type), intent(out) :: spot
      real(wp) :: root

      root = sqrt(approach)
      spot%c1 = self%c1
      spot%a = self%axis_a*root
      spot%b = self%axis_b*root
      spot%force = self%stiffness*approach*root
      spot%pressure = self%pressure*root
   end subroutine contact

   !> Force [N], N = k_n d^(3/2).
   pure function force(self, approach)
      class(hertz_type), intent(in) :: self
      !> Approach d [m], >= 0.
      real(wp), intent(in) :: approach
      real(wp) :: force

      force = self%stiffness*approach*sqrt(approach)
   end function force

   !> Elastic energy [J], (2/5) k_n d^(5/2).
   pure function energy(self, approach)
      class(hertz_type), intent(in) :: self
      !> Approach d [m], >= 0.
      real(wp), intent(in) :: approach
      real(wp) :: energy

      energy = 0.4_wp*self%stiffness*approach**2*sqrt(approach)
   end function energy

   !> Approach [m] that belongs to a force, d = (N/k_n)^(2/3).
   pure function approach(self, force)
      class(hertz_type), intent(in) :: self
      !> Force N [N], >= 0.
      real(wp), intent(in) :: force
      real(wp) :: approach

      approach = two_thirds_power(force/self%stiffness)
   end function approach

   !> Approach [m] that belongs to a force; NaN outside the domain.
   pure function hertz_approach(curvature_a, curvature_b, modulus, force) result(approach)
      !> Half relative curvature A along the major axis [1/m], > 0.
      real(wp), intent(in) :: curvature_a
      !> Half relative curvature B along the minor axis [1/m], >= A.
      real(wp), intent(in) :: curvature_b
      !> Effective modulus E* [Pa], > 0.
      real(wp), intent(in) :: modulus
      !> Force N [N], >= 0, below 2^128.
      real(wp), intent(in) :: force
      real(wp) :: approach
      type(hertz_type) :: self

      if (in_hertz_domain(curvature_a, curvature_b, modulus, force)) then
         self = new_hertz(curvature_a, curvature_b, modulus)
         approach = self%approach(force)
      else
         approach = ieee_value(approach, ieee_quiet_nan)
      end if
   end function hertz_approach

   !> x^(2/3), to 2 ulp; pow() with a rounded exponent loses some ten for small x.
   pure function two_thirds_power(x) result(y)
      !> Base, >= 0.
      real(wp), intent(in) :: x
      real(wp) :: y
      real(wp) :: root

      if (x < tiny(x)) then
         y = x**(2.0_wp/3.0_wp)
         return
      end if
      root = x**(1.0_wp/3.0_wp)
      ! A step of Newton's method: what is left of x is exact enough.
      root = root - (root*root*root - x)/(3.0_wp*root*root)
      y = root*root
   end function two_thirds_power

   !> Table of the ways to compute a contact.
   function hertz_models() result(models)
      type(hertz_model_type), allocatable :: models(:)
      character(len=*), parameter :: keys = "curvatures A <= B [1/m], E* [Pa], approach [m]"

      allocate(models(4))
      models(1)%info = model_info_type("tables", &
         "exact: t = B/K and 1/K by piecewise polynomials of g = A/B", keys, &
         "H. Hertz, J. reine angew. Math. 92 (1881) 156; scripts/generate_hertz.py")
      models(1)%kernel => hertz_contact
      models(2)%info = model_info_type("newton", &
         "exact: g = c1 D/B solved for c1 by Newton's method in log(c1)", keys, &
         "Kosenko and Aleksandrov, 7th Modelica Conference (2009) 288, eq. (6)")
      models(2)%kernel => hertz_newton
      models(3)%info = model_info_type("brewe_hamrock", &
         "power law for the axis ratio, linear fits for the elliptic integrals; A/B from 0.01", &
         keys, "D. Brewe and B. Hamrock, J. Lubr. Technol. 99 (1977) 485")
      models(3)%kernel => hertz_brewe_hamrock
      models(4)%info = model_info_type("greenwood", &
         "circles of equivalent radii, axis ratio (B/A)^(2/3); moderate ellipses", keys, &
         "J. Greenwood, J. Tribology 107 (1985) 501")
      models(4)%kernel => hertz_greenwood
   end function hertz_models

   !> Contact by Newton's method on g = c1 D/B, with the tabulated elliptic integrals.
   pure subroutine hertz_newton(curvature_a, curvature_b, modulus, approach, spot)
      real(wp), intent(in) :: curvature_a, curvature_b, modulus, approach
      type(hertz_spot_type), intent(out) :: spot

      call hertz_newton_with(elliptic_tables, curvature_a, curvature_b, modulus, approach, spot)
   end subroutine hertz_newton

   !> Contact by Newton's method on g = c1 D/B, with elliptic integrals of choice.
   !>
   !> In log(c1) the slope of log(c1 D/B) is between 1/2 and 1, so a few steps do. Steps that leave
   !> the interval known to hold the root are replaced by its geometric mean.
   pure subroutine hertz_newton_with(integrals, curvature_a, curvature_b, modulus, approach, spot)
      procedure(elliptic_kernel) :: integrals
      real(wp), intent(in) :: curvature_a, curvature_b, modulus, approach
      type(hertz_spot_type), intent(out) :: spot
      !> Largest number of steps.
      integer, parameter :: max_steps = 100
      !> Relative size of a step that is the last one.
      real(wp), parameter :: small_step = 1.0e-8_wp
      real(wp) :: c1, g, k, e, b_integral, d_integral, dk_dc, de_dc, low, high, ratio, slope, next
      integer :: step
      logical :: last

      spot = no_spot()
      if (.not. in_hertz_domain(curvature_a, curvature_b, modulus, approach)) return
      g = curvature_a/curvature_b
      ! The leading terms near the circle and for slender spots.
      low = tiny(low)
      high = 1.0_wp
      if (g > 0.1_wp) then
         next = g*g**(1.0_wp/3.0_wp)
      else
         next = 2.0_wp*g/log(16.0_wp/g)
      end if
      last = .false.
      do step = 1, max_steps
         c1 = next
         call integrals(c1, k, e, b_integral, d_integral, dk_dc, de_dc)
         if (ieee_is_nan(b_integral) .or. ieee_is_nan(d_integral)) then
            spot = no_spot()
            return
         else if (min(b_integral, d_integral) <= 0.0_wp) then
            spot = no_spot()
            return
         end if
         ratio = c1*d_integral/(b_integral*g)
         if (ratio > 1.0_wp) high = c1
         if (ratio < 1.0_wp) low = c1
         ! d log(c1 D/B)/d log(c1) = 1 - c1 (D'/D - B'/B), where ' is d/dc;
         ! B' + D' = dK/dc = B/(2 c1), B' + c1 D' = D/2.
         if (last) exit
         slope = 0.75_wp
         if (c1 < 0.999999_wp) then
            slope = (b_integral/c1 - d_integral)/(2.0_wp*(1.0_wp - c1))
            slope = 1.0_wp - c1*(slope/d_integral - (0.5_wp*b_integral/c1 - slope)/b_integral)
         end if
         next = c1*exp(-log(ratio)/slope)
         if (next < low .or. next > high) next = sqrt(low)*sqrt(high)
         last = abs(next - c1) <= small_step*c1
      end do
      k = b_integral + d_integral
      spot%c1 = c1
      spot%a = sqrt(d_integral/k*(approach/curvature_a))
      spot%b = sqrt(b_integral/k*(approach/curvature_b))
      spot%force = two_pi_thirds*modulus*approach*spot%a/k
      spot%pressure = modulus*spot%b*(curvature_b/b_integral)
   end subroutine hertz_newton_with

   !> Contact by the fits of Brewe and Hamrock.
   !>
   !> a/b = 1.0339 (B/A)^0.6360, E = 1.0003 + 0.5968 A/B, K = 1.5277 + 0.6023 log(B/A), given for
   !> B/A up to 100. Their d = K ((9/(2 E R)) (N/(2 pi (a/b) E*))^2)^(1/3) and
   !> b = (3 E N R/(pi (a/b) E*))^(1/3), 1/R = 2 (A + B), are here solved for N and b by d.
   !> D. Brewe and B. Hamrock, J. Lubr. Technol. 99 (1977) 485.
   pure subroutine hertz_brewe_hamrock(curvature_a, curvature_b, modulus, approach, spot)
      real(wp), intent(in) :: curvature_a, curvature_b, modulus, approach
      type(hertz_spot_type), intent(out) :: spot
      real(wp) :: ratio, axis_ratio, k_integral, e_integral

      if (.not. in_hertz_domain(curvature_a, curvature_b, modulus, approach)) then
         spot = no_spot()
         return
      end if
      ratio = curvature_b/curvature_a
      axis_ratio = 1.0339_wp*ratio**0.6360_wp
      e_integral = 1.0003_wp + 0.5968_wp/ratio
      k_integral = 1.5277_wp + 0.6023_wp*log(ratio)
      spot%c1 = 1.0_wp/(axis_ratio*axis_ratio)
      spot%b = sqrt(e_integral*approach/(k_integral*(curvature_a + curvature_b)))
      spot%a = axis_ratio*spot%b
      spot%force = two_pi_thirds*modulus*approach*spot%a/k_integral
      spot%pressure = modulus*spot%b*(curvature_a + curvature_b)/e_integral
   end subroutine hertz_brewe_hamrock

   !> Contact by Greenwood's equivalent circles.
   !>
   !> Formulas of the circle with the radius (A'B')^(-1/2) for the approach and
   !> (A'B'(A' + B')/2)^(-1/3) for spot and pressure, A' = 2 A, B' = 2 B; a/b = (B/A)^(2/3).
   !> J. Greenwood, J. Tribology 107 (1985) 501.
   pure subroutine hertz_greenwood(curvature_a, curvature_b, modulus, approach, spot)
      real(wp), intent(in) :: curvature_a, curvature_b, modulus, approach
      type(hertz_spot_type), intent(out) :: spot
      real(wp) :: axis_ratio, root, mean, squares

      if (.not. in_hertz_domain(curvature_a, curvature_b, modulus, approach)) then
         spot = no_spot()
         return
      end if
      axis_ratio = (curvature_b/curvature_a)**(2.0_wp/3.0_wp)
      spot%c1 = 1.0_wp/(axis_ratio*axis_ratio)
      ! N = (4/3) E* sqrt(R d) d, and (a b)^(3/2) = (3/4) N R/E* with the other radius.
      root = sqrt(approach/(2.0_wp*sqrt(curvature_a*curvature_b)))
      spot%force = (4.0_wp/3.0_wp)*modulus*approach*root
      squares = 4.0_wp*curvature_a*curvature_b*(curvature_a + curvature_b)
      mean = (approach*root)**(1.0_wp/3.0_wp)*squares**(-1.0_wp/9.0_wp)
      root = sqrt(axis_ratio)
      spot%a = mean*root
      spot%b = mean/root
      spot%pressure = 0.0_wp
      if (mean > 0.0_wp) spot%pressure = 1.5_wp*spot%force/(pi*mean*mean)
   end subroutine hertz_greenwood

end module contensou_contact_hertz
