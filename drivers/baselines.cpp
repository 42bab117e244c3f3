// Complete elliptic integrals of Boost.Math for `contensou bench`; part of the executable only where
// its headers are found, never of the library. baselines_none.c stands in for this file elsewhere.
#include <cmath>
#include <limits>

#include <boost/math/special_functions/ellint_1.hpp>
#include <boost/math/special_functions/ellint_2.hpp>
#include <boost/math/special_functions/ellint_d.hpp>
#include <boost/version.hpp>

namespace {

// The fastest Boost offers for double: without long double inside, and without exceptions.
typedef boost::math::policies::policy<boost::math::policies::promote_double<false>,
   boost::math::policies::domain_error<boost::math::policies::ignore_error>,
   boost::math::policies::overflow_error<boost::math::policies::ignore_error> >
   policy;

} // namespace

extern "C" {

// Version of Boost, 107400 for 1.74.0; 0 if there is none.
int contensou_boost_version(void)
{
   return BOOST_VERSION;
}

// K and E by the complement c1 of the parameter; NaN where the modulus rounds to 1.
void contensou_boost_ke(double c1, double *k, double *e)
{
   const double modulus = std::sqrt(1.0 - c1);
   if (modulus >= 1.0) {
      *k = *e = std::numeric_limits<double>::quiet_NaN();
      return;
   }
   *k = boost::math::ellint_1(modulus, policy());
   *e = boost::math::ellint_2(modulus, policy());
}

// The same and D.
void contensou_boost_ked(double c1, double *k, double *e, double *d)
{
   const double modulus = std::sqrt(1.0 - c1);
   if (modulus >= 1.0) {
      *k = *e = *d = std::numeric_limits<double>::quiet_NaN();
      return;
   }
   *k = boost::math::ellint_1(modulus, policy());
   *e = boost::math::ellint_2(modulus, policy());
   *d = boost::math::ellint_d(modulus, policy());
}

} // extern "C"
