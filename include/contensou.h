/* C interface of the kernels of Contensou. SI units throughout.
 *
 * Link with what `pkg-config --libs --static contensou` prints. */
#ifndef CONTENSOU_H
#define CONTENSOU_H

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Return values: success, or an argument outside its domain (the outputs are then zero). */
enum { CONTENSOU_OK = 0, CONTENSOU_BAD_ARGUMENT = 1 };

/* Version of the library, as "0.1.0". */
const char *contensou_version(void);

/* Hertz contact of bodies whose undeformed gap is A x^2 + B y^2.
 *   curvature_a  A [1/m], > 0
 *   curvature_b  B [1/m], >= A; both are 1/(2R) for a sphere of radius R on a plane
 *   modulus      effective modulus E* [Pa], > 0
 *   approach     d [m], >= 0
 * yields
 *   a, b         semi-axes of the spot along x and y [m]
 *   force        N [N]
 *   pressure     largest pressure p0 = 3 N/(2 pi a b) [Pa] */
int contensou_hertz(double curvature_a, double curvature_b, double modulus, double approach,
                    double *a, double *b, double *force, double *pressure);

/* A friction model with its parameters. */
typedef struct contensou_friction contensou_friction;

/* Make a friction model.
 *   model        "coulomb", "contensou_simplified", "pade11", "pade22" or "contensou_exact"
 *   coefficient  friction coefficient f, >= 0
 *   delta        regularisation velocity [m/s], >= 0, and > 0 for "coulomb"
 *   drilling     whether the drilling torque is part of the model
 * Returns NULL if there is no such model or an argument is outside its domain. */
contensou_friction *contensou_friction_new(const char *model, double coefficient, double delta,
                                           bool drilling);

/* Friction wrench on the body that slips.
 *   load      normal force N [N], >= 0
 *   a, b      semi-axes of the spot along x and y [m], 0 < b <= a
 *   vx, vy    sliding velocity of the centre of the spot [m/s]
 *   spin      angular velocity about the normal [rad/s]
 * yields wrench = { Fx [N], Fy [N], Tz [N m] }. */
int contensou_friction_wrench(const contensou_friction *friction, double load, double a, double b,
                              double vx, double vy, double spin, double wrench[3]);

/* Release a friction model; NULL is admitted. */
void contensou_friction_free(contensou_friction *friction);

#ifdef __cplusplus
}
#endif

#endif
