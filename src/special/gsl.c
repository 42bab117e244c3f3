/* What the GNU Scientific Library has as variables, which Fortran would define anew. */
#include <gsl/gsl_qrng.h>
#include <gsl/gsl_version.h>

gsl_qrng *contensou_sobol_new(int dimensions);
const char *contensou_gsl_version(void);

gsl_qrng *contensou_sobol_new(int dimensions)
{
  return gsl_qrng_alloc(gsl_qrng_sobol, (unsigned int)dimensions);
}

const char *contensou_gsl_version(void)
{
  return gsl_version;
}
