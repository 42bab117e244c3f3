/*
 * Stands in for baselines.cpp where Boost.Math or a C++ compiler is missing.
 */
#include <math.h>

int contensou_boost_version(void);
void contensou_boost_ke(double c1, double *k, double *e);
void contensou_boost_ked(double c1, double *k, double *e, double *d);

int contensou_boost_version(void)
{
   return 0;
}

void contensou_boost_ke(double c1, double *k, double *e)
{
   (void)c1;
   *k = *e = NAN;
}

void contensou_boost_ked(double c1, double *k, double *e, double *d)
{
   contensou_boost_ke(c1, k, e);
   *d = NAN;
}
