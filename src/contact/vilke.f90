!> Vil'ke's volumetric normal force, with explicit formulas for the shape of the spot.
!>
!> Undeformed gap h = A x^2 + B y^2 with 0 < A <= B, approach d, g = A/B.
!> N = (4/3) E* sqrt(R_e) d^(3/2), R_e = 1/(2 sqrt(A B)): volume and area of the overlap of the
!> undeformed bodies alone. Reconstructed: I. Kosenko and E. Aleksandrov, 7th Modelica Conference
!> (2009) 288, name the model without printing it.
!> The parameter c = 1 - c1 of the spot is taken from g without elliptic integrals, by the chord of
!> Hertz's equation (6), c = 1.1033 (1 - g), or by c = 1 - g^(4/3). With it
!> a = sqrt(d/(A + c1 B)), b = sqrt(c1) a, as Hertz's for the exact c1, and p0 = 3 N/(2 pi a b).
!> Domain as of Hertz's contact. The chord has a spot for c1 > 0 only, that is g > 0.0936.
module contensou_contact_vilke
   use, intrinsic :: ieee_arithmetic, only : ieee_quiet_nan, ieee_value
   use contensou_base_kinds, only : pi, wp
   use contensou_contact_catalogue, only : model_info_type
   use contensou_contact_hertz, only : hertz_model_type, hertz_shape, hertz_spot_type, &
      in_hertz_domain, no_spot
   implicit none(type, external)
   private

   public :: vilke_force, vilke_stiffness, vilke_models
   public :: vilke_chord, vilke_power, vilke_exact
   public :: chord_c1, power_c1, vilke_power_index

   !> Position of the power in `vilke_models`.
   integer, parameter :: vilke_power_index = 2

   !> Slope of the chord of c over g from the circle.
   real(wp), parameter :: chord_slope = 1.1033_wp

contains

   !> Table of the formulas for the spot; each gives the same force.
   function vilke_models() result(models)
      type(hertz_model_type), allocatable :: models(:)
      character(len=*), parameter :: keys = "curvatures A <= B [1/m], E* [Pa], approach [m]"
      character(len=*), parameter :: paper = &
         "Kosenko and Aleksandrov, 7th Modelica Conference (2009) 288; force reconstructed"

      allocate(models(3))
      models(1)%info = model_info_type("chord", &
         "c = 1.1033 (1 - A/B), the chord of Hertz's equation; no spot below A/B = 0.0936", &
         keys, paper)
      models(1)%kernel => vilke_chord
      models(vilke_power_index)%info = model_info_type("power", "c = 1 - (A/B)^(4/3)", keys, paper)
      models(vilke_power_index)%kernel => vilke_power
      models(3)%info = model_info_type("exact", "c of Hertz's contact", keys, paper)
      models(3)%kernel => vilke_exact
   end function vilke_models

   !> Stiffness k_n of N = k_n d^(3/2) [N/m^(3/2)]; NaN outside the domain.
   pure function vilke_stiffness(curvature_a, curvature_b, modulus) result(stiffness)
      !> Half relative curvature A along the major axis [1/m], > 0.
      real(wp), intent(in) :: curvature_a
      !> Half relative curvature B along the minor axis [1/m], >= A.
      real(wp), intent(in) :: curvature_b
      !> Effective modulus E* [Pa], > 0.
      real(wp), intent(in) :: modulus
      real(wp) :: stiffness

      if (in_hertz_domain(curvature_a, curvature_b, modulus, 0.0_wp)) then
         stiffness = (4.0_wp/3.0_wp)*modulus*sqrt(0.5_wp/sqrt(curvature_a*curvature_b))
      else
         stiffness = ieee_value(stiffness, ieee_quiet_nan)
      end if
   end function vilke_stiffness

   !> Force [N]; NaN outside the domain.
   pure function vilke_force(curvature_a, curvature_b, modulus, approach) result(force)
      !> Half relative curvature A along the major axis [1/m], > 0.
      real(wp), intent(in) :: curvature_a
      !> Half relative curvature B along the minor axis [1/m], >= A.
      real(wp), intent(in) :: curvature_b
      !> Effective modulus E* [Pa], > 0.
      real(wp), intent(in) :: modulus
      !> Approach d [m], >= 0.
      real(wp), intent(in) :: approach
      real(wp) :: force

      if (in_hertz_domain(curvature_a, curvature_b, modulus, approach)) then
         force = (4.0_wp/3.0_wp)*modulus*approach &
            *sqrt(approach*(0.5_wp/sqrt(curvature_a*curvature_b)))
      else
         force = ieee_value(force, ieee_quiet_nan)
      end if
   end function vilke_force

   !> c1 = 1 - c by the chord c = 1.1033 (1 - g) [-]; not positive for g < 0.0936.
   pure function chord_c1(g) result(c1)
      !> Ratio g = A/B of the curvatures [-], in (0, 1].
      real(wp), intent(in) :: g
      real(wp) :: c1

      c1 = chord_slope*g - (chord_slope - 1.0_wp)
      if (g >= 1.0_wp) c1 = 1.0_wp
   end function chord_c1

   !> c1 = 1 - c by the power c = 1 - g^(4/3) [-].
   pure function power_c1(g) result(c1)
      !> Ratio g = A/B of the curvatures [-], in (0, 1].
      real(wp), intent(in) :: g
      real(wp) :: c1

      c1 = g*g**(1.0_wp/3.0_wp)
   end function power_c1

   !> Contact with the spot of the chord, of which there is none if A/B is small.
   pure subroutine vilke_chord(curvature_a, curvature_b, modulus, approach, spot)
      real(wp), intent(in) :: curvature_a, curvature_b, modulus, approach
      type(hertz_spot_type), intent(out) :: spot

      spot%c1 = 0.0_wp
      if (in_hertz_domain(curvature_a, curvature_b, modulus, approach)) then
         spot%c1 = chord_c1(curvature_a/curvature_b)
      end if
      call complete(curvature_a, curvature_b, modulus, approach, spot)
   end subroutine vilke_chord

   !> Contact with the spot of the power.
   pure subroutine vilke_power(curvature_a, curvature_b, modulus, approach, spot)
      real(wp), intent(in) :: curvature_a, curvature_b, modulus, approach
      type(hertz_spot_type), intent(out) :: spot

      spot%c1 = 0.0_wp
      if (in_hertz_domain(curvature_a, curvature_b, modulus, approach)) then
         spot%c1 = power_c1(curvature_a/curvature_b)
      end if
      call complete(curvature_a, curvature_b, modulus, approach, spot)
   end subroutine vilke_power

   !> Contact with Hertz's spot.
   pure subroutine vilke_exact(curvature_a, curvature_b, modulus, approach, spot)
      real(wp), intent(in) :: curvature_a, curvature_b, modulus, approach
      type(hertz_spot_type), intent(out) :: spot
      real(wp) :: t, inverse_k

      spot%c1 = 0.0_wp
      if (in_hertz_domain(curvature_a, curvature_b, modulus, approach)) then
         call hertz_shape(curvature_a/curvature_b, spot%c1, t, inverse_k)
      end if
      call complete(curvature_a, curvature_b, modulus, approach, spot)
   end subroutine vilke_exact

   !> Force, spot and largest pressure that belong to c1; all but the force NaN if c1 is not
   !> positive.
   pure subroutine complete(curvature_a, curvature_b, modulus, approach, spot)
      real(wp), intent(in) :: curvature_a, curvature_b, modulus, approach
      type(hertz_spot_type), intent(inout) :: spot
      real(wp) :: force

      force = vilke_force(curvature_a, curvature_b, modulus, approach)
      if (spot%c1 <= 0.0_wp) then
         spot = no_spot()
         spot%force = force
         return
      end if
      spot%force = force
      spot%a = sqrt(approach/(curvature_a + spot%c1*curvature_b))
      spot%b = sqrt(spot%c1)*spot%a
      spot%pressure = 0.0_wp
      ! Factor by factor: the area of a small spot may be smaller than any number.
      if (spot%b > 0.0_wp) spot%pressure = (1.5_wp/pi)*(force/spot%a)/spot%b
   end subroutine complete

end module contensou_contact_vilke
