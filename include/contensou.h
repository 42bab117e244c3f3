/* C interface of Contensou: simulations and kernels. SI units throughout.
 *
 * Nothing here prints or ends the program. Different simulations may run in different threads.
 * Link with what `pkg-config --libs --static contensou` prints. */
#ifndef CONTENSOU_H
#define CONTENSOU_H

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Return values: success, or an argument outside its domain (the outputs of kernels are then
 * zero). */
enum { CONTENSOU_OK = 0, CONTENSOU_BAD_ARGUMENT = 1 };

/* Version of the library, as "0.1.0". */
const char *contensou_version(void);

/* ---- Errors ---------------------------------------------------------------------------------- */

/* What went wrong. Functions that can fail take the address of a pointer, which they set to an
 * error, to be freed, or to NULL; it may be NULL itself if the text is not wanted. */
typedef struct contensou_error contensou_error;

/* The text of an error, which may have several lines; "" for NULL. It lives as long as the error. */
const char *contensou_error_message(const contensou_error *error);

/* The exit status of a program that gives up because of an error: 1 the simulation failed, 2 a
 * mistake in the scene or its settings, 74 a file cannot be read; 0 for NULL. */
int contensou_error_status(const contensou_error *error);

/* Release an error; NULL is admitted. */
void contensou_error_free(contensou_error *error);

/* ---- Simulations ----------------------------------------------------------------------------- */

/* A scene, its equations of motion, and how far its simulation has come. */
typedef struct contensou_simulation contensou_simulation;

/* Read a scene file and make a simulation of it.
 *   scene      name of the file
 *   settings   n texts, each as after --set of the program: "scene.t_end = 0.5"; may be NULL
 * Returns NULL and an error with all mistakes if there are any. */
contensou_simulation *contensou_simulation_new(const char *scene, const char *const settings[],
                                               int n, contensou_error **error);

/* Looks at a row; returns 0 to go on, another value to stop after this step.
 *   time        [s]
 *   state       n numbers: of each body its position (3) [m], quaternion (4, real part first, body
 *               to inertial frame), velocity (3) [m/s], angular velocity (3) in its own axes
 *               [rad/s]; then works of friction, damping and drives [J], if there are such
 *   user_data   what was given to contensou_simulate */
typedef int contensou_observer(double time, const double *state, int n, void *user_data);

/* Simulate to the end of the scene, or until the observer stops; calling it again goes on there.
 * The observer, which may be NULL, gets a row every output.interval and one at the end.
 * Returns CONTENSOU_OK or the status of the error. */
int contensou_simulate(contensou_simulation *simulation, contensou_observer *observer,
                       void *user_data, contensou_error **error);

/* The time reached [s]; 0 for NULL. */
double contensou_simulation_time(const contensou_simulation *simulation);

/* The number of elements of the state; 0 for NULL. */
int contensou_simulation_size(const contensou_simulation *simulation);

/* The state at the time reached, in the order of contensou_observer. */
int contensou_simulation_state(const contensou_simulation *simulation, double *state);

/* The motion of a body at the time reached; an output may be NULL.
 *   name               of the body in the scene
 * yields
 *   position           centre of mass [m]
 *   quaternion         body to inertial frame, real part first
 *   velocity           of the centre of mass [m/s]
 *   angular_velocity   in the axes of the body [rad/s] */
int contensou_simulation_body(const contensou_simulation *simulation, const char *name,
                              double position[3], double quaternion[4], double velocity[3],
                              double angular_velocity[3]);

/* Release a simulation; NULL is admitted. */
void contensou_simulation_free(contensou_simulation *simulation);

/* ---- Kernels --------------------------------------------------------------------------------- */

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
