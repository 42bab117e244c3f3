!> Ways to compute that `contensou bench kernels` measures as yardsticks and nobody else calls: the
!> elliptic integrals of Boost, and Hertz's contact by Newton's method over other integrals.
module contensou_drivers_bench_baselines
   use, intrinsic :: iso_c_binding, only : c_double, c_int
   use contensou_base_kinds, only : wp
   use contensou_contact_hertz, only : hertz_newton_with, hertz_spot_type
   use contensou_special_elliptic, only : elliptic_agm, elliptic_gsl
   implicit none(type, external)
   private

   public :: boost_version, boost_ke, elliptic_boost, newton_agm, newton_gsl

   interface
      !> Version of Boost, 0 if it is not there.
      function boost_version() result(version) bind(c, name="contensou_boost_version")
         import :: c_int
         implicit none(type, external)
         integer(c_int) :: version
      end function boost_version

      pure subroutine boost_ke(c1, k, e) bind(c, name="contensou_boost_ke")
         import :: c_double
         implicit none(type, external)
         !> Complement c1 = 1 - c of the parameter.
         real(c_double), intent(in), value :: c1
         !> Integral K.
         real(c_double), intent(out) :: k
         !> Integral E.
         real(c_double), intent(out) :: e
      end subroutine boost_ke

      pure subroutine boost_ked(c1, k, e, d) bind(c, name="contensou_boost_ked")
         import :: c_double
         implicit none(type, external)
         !> Complement c1 = 1 - c of the parameter.
         real(c_double), intent(in), value :: c1
         !> Integral K.
         real(c_double), intent(out) :: k
         !> Integral E.
         real(c_double), intent(out) :: e
         !> Integral D.
         real(c_double), intent(out) :: d
      end subroutine boost_ked
   end interface

contains

   !> All elliptic integrals from K, E and D of Boost.
   pure subroutine elliptic_boost(c1, k, e, b, d, dk_dc, de_dc)
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

      call boost_ked(c1, k, e, d)
      b = k - d
      dk_dc = b/(c1 + c1)
      de_dc = -0.5_wp*d
   end subroutine elliptic_boost

   !> Contact by Newton's method with the arithmetic-geometric mean.
   pure subroutine newton_agm(curvature_a, curvature_b, modulus, approach, spot)
      !> Half relative curvature A along the major axis [1/m], > 0.
      real(wp), intent(in) :: curvature_a
      !> Half relative curvature B along the minor axis [1/m], >= A.
      real(wp), intent(in) :: curvature_b
      !> Effective modulus E* [Pa], > 0.
      real(wp), intent(in) :: modulus
      !> Approach d [m], >= 0.
      real(wp), intent(in) :: approach
      type(hertz_spot_type), intent(out) :: spot

      call hertz_newton_with(elliptic_agm, curvature_a, curvature_b, modulus, approach, spot)
   end subroutine newton_agm

   !> Contact by Newton's method with K and E of the GNU Scientific Library.
   pure subroutine newton_gsl(curvature_a, curvature_b, modulus, approach, spot)
      !> Half relative curvature A along the major axis [1/m], > 0.
      real(wp), intent(in) :: curvature_a
      !> Half relative curvature B along the minor axis [1/m], >= A.
      real(wp), intent(in) :: curvature_b
      !> Effective modulus E* [Pa], > 0.
      real(wp), intent(in) :: modulus
      !> Approach d [m], >= 0.
      real(wp), intent(in) :: approach
      type(hertz_spot_type), intent(out) :: spot

      call hertz_newton_with(elliptic_gsl, curvature_a, curvature_b, modulus, approach, spot)
   end subroutine newton_gsl

end module contensou_drivers_bench_baselines
