/* The stepper is a variable of the GNU Scientific Library, which Fortran would define anew. */
#include <gsl/gsl_odeiv2.h>

const gsl_odeiv2_step_type *contensou_rk8pd(void);

const gsl_odeiv2_step_type *contensou_rk8pd(void)
{
  return gsl_odeiv2_step_rk8pd;
}
