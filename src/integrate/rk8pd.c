/* Steps of rk8pd of the GNU Scientific Library, whose structures Fortran need not know. */
#include <gsl/gsl_odeiv2.h>

typedef int derivative_t(double t, const double y[], double rate[], void *parameters);

gsl_odeiv2_step *contensou_rk8pd_new(size_t n);
int contensou_rk8pd_step(gsl_odeiv2_step *stepper, double t, double h, double y[], double error[],
                         const double rate[], derivative_t *derivative, void *parameters);
void contensou_rk8pd_free(gsl_odeiv2_step *stepper);

gsl_odeiv2_step *contensou_rk8pd_new(size_t n)
{
  return gsl_odeiv2_step_alloc(gsl_odeiv2_step_rk8pd, n);
}

/* The right-hand side at the end is left to the caller: a step that is rejected needs none. */
int contensou_rk8pd_step(gsl_odeiv2_step *stepper, double t, double h, double y[], double error[],
                         const double rate[], derivative_t *derivative, void *parameters)
{
  const gsl_odeiv2_system system = {derivative, NULL, stepper->dimension, parameters};

  return gsl_odeiv2_step_apply(stepper, t, h, y, error, rate, NULL, &system);
}

void contensou_rk8pd_free(gsl_odeiv2_step *stepper)
{
  gsl_odeiv2_step_free(stepper);
}
