/* C interface of Contensou: simulations and kernels. SI units throughout.
 *
 * Nothing here prints, writes files or ends the program. Different simulations may run in different
 * threads.
 * Link with what `pkg-config --libs --static contensou` prints. */
#ifndef CONTENSOU_H
#define CONTENSOU_H

#include <stdbool.h>
#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Return values: success, or an argument outside its domain (the outputs of kernels are then
 * zero). */
enum { CONTENSOU_OK = 0, CONTENSOU_BAD_ARGUMENT = 1 };

/* Number of the interface that this header describes. A program that is compiled with one header
 * and linked with a library of another one gets an error where it makes a simulation, unless the
 * library knows its interface as well. */
#define CONTENSOU_INTERFACE 3

/* Number of the newest interface that the library knows. */
int contensou_interface(void);

/* Version of the library, as "0.1.0". */
const char *contensou_version(void);

/* Errors, simulations, snapshots, friction models and spots are known by handles, which are no
 * addresses: one that was released is answered as NULL is. Texts are addresses, and live as long as
 * is said with each of them. */

/* ---- Errors ---------------------------------------------------------------------------------- */

/* What went wrong. Functions that can fail take the address of a pointer, which they set to an
 * error, to be freed, or to NULL; it may be NULL itself if the text is not wanted. They return
 * CONTENSOU_OK or the status of the error. */
typedef struct contensou_error contensou_error;

/* The text of an error, which may have several lines; "" for NULL. It lives as long as the error. */
const char *contensou_error_message(const contensou_error *error);

/* The exit status of a program that gives up because of an error: 1 the simulation failed, 2 a
 * mistake in the scene, its settings or the call, 74 a file cannot be read; 0 for NULL. */
int contensou_error_status(const contensou_error *error);

/* A mistake in a scene or its settings. Its texts live as long as the error. */
typedef struct {
   const char *source;   /* name of the file or text, or "--set ..." */
   int line, column;     /* from 1; 0 stands for all of it */
   int length;           /* bytes that are meant */
   const char *message;  /* what is wrong */
   const char *expected; /* what would be right; "" if there is nothing to say */
} contensou_mistake;

/* The number of mistakes that an error tells of, each with its place; 0 for other errors. */
int contensou_error_mistakes(const contensou_error *error);

/* One of them, 0 <= i; CONTENSOU_BAD_ARGUMENT if there is none. */
int contensou_error_mistake(const contensou_error *error, int i, contensou_mistake *mistake);

/* Release an error; NULL is admitted. */
void contensou_error_free(contensou_error *error);

/* ---- Simulations ----------------------------------------------------------------------------- */

/* A scene, its equations of motion, and how far its simulation has come: its present. One thread
 * at a time may use a simulation. */
typedef struct contensou_simulation contensou_simulation;

/* What contensou_simulation_new and contensou_simulation_from_text call, with the interface of the
 * header. A text that is not NULL stands in place of the file. */
contensou_simulation *contensou_simulation_make(int interface, const char *name, const char *text,
                                                const char *const settings[], int n,
                                                contensou_error **error);

/* Read a scene file and make a simulation of it.
 *   scene      name of the file
 *   settings   n texts, each as after --set of the program: "scene.t_end = 0.5"; may be NULL
 * Returns NULL and an error with all mistakes if there are any. */
static inline contensou_simulation *contensou_simulation_new(const char *scene,
                                                             const char *const settings[], int n,
                                                             contensou_error **error)
{
   return contensou_simulation_make(CONTENSOU_INTERFACE, scene, NULL, settings, n, error);
}

/* The same from the text of a scene.
 *   name       what the text is called in messages */
static inline contensou_simulation *contensou_simulation_from_text(const char *name,
                                                                   const char *text,
                                                                   const char *const settings[],
                                                                   int n, contensou_error **error)
{
   return contensou_simulation_make(CONTENSOU_INTERFACE, name, text ? text : "", settings, n,
                                    error);
}

/* Release a simulation; NULL is admitted. */
void contensou_simulation_free(contensou_simulation *simulation);

/* Put a simulation back to its beginning, with its parameters; what acts on bodies is again what
 * the scene says. */
int contensou_simulation_reset(contensou_simulation *simulation, contensou_error **error);

/* All settings of the scene, defaults included, as a scene; "" for NULL. It lives until a parameter
 * is set. */
const char *contensou_simulation_settings(const contensou_simulation *simulation);

/* What is legal in the scene and hardly meant, as text of several lines; "" for nothing. */
const char *contensou_simulation_warnings(const contensou_simulation *simulation);

/* ---- Running --------------------------------------------------------------------------------- */

/* Looks at a row; returns 0 to go on, another value to stop here.
 *   time        [s]
 *   state       n numbers: of each body its position (3) [m], quaternion (4, real part first, body
 *               to inertial frame), velocity (3) [m/s], angular velocity (3) in its own axes
 *               [rad/s]; then the states of the laws of contacts, if they have any; then works of
 *               friction, damping and loads with drives [J], if there are such
 *   user_data   what was given with the observer
 * While it runs it may ask for values, which are those of the row; it must not change the
 * simulation. */
typedef int contensou_observer(double time, const double *state, int n, void *user_data);

/* Kinds of events. */
enum { CONTENSOU_TOUCH = 1, CONTENSOU_LIFT = 2 };

/* Hears of an event; returns 0 to go on, another value to stop after it.
 *   time        [s]
 *   kind        CONTENSOU_TOUCH or CONTENSOU_LIFT
 *   contact     number of the contact, from 0 */
typedef int contensou_event_observer(double time, int kind, int contact, void *user_data);

/* From now on let functions look at rows and events; NULL for nobody. A row is due every
 * output.interval, at the beginning and at the end. */
int contensou_simulation_observe(contensou_simulation *simulation, contensou_observer *row,
                                 contensou_event_observer *event, void *user_data);

/* Go on to a time; with the method that the scene names. The bits of rows and events do not depend
 * on the times gone to. It ends before where an observer stops it, and where a condition of the
 * scene (&stop) is met. Beyond scene.t_end it goes on with what the scene says.
 *   time        [s], not before the present */
int contensou_simulation_advance(contensou_simulation *simulation, double time,
                                 contensou_error **error);

/* The same; it ends at an event, with what follows from it. */
int contensou_simulation_advance_to_event(contensou_simulation *simulation, double time,
                                          contensou_error **error);

/* Simulate to the end of the scene, or until the observer stops; calling it again goes on there.
 * The observer, which may be NULL, takes the place of that of rows meanwhile. */
int contensou_simulate(contensou_simulation *simulation, contensou_observer *observer,
                       void *user_data, contensou_error **error);

/* The present time, and the end of the scene [s]; 0 for NULL. */
double contensou_simulation_time(const contensou_simulation *simulation);
double contensou_simulation_end(const contensou_simulation *simulation);

/* Number of the condition (&stop) that has ended it, from 1; 0 if none has. */
int contensou_simulation_stop(const contensou_simulation *simulation);

/* The next time after another one at which rates are not smooth because a drive ends its ramp [s];
 * infinite for none. */
double contensou_simulation_next_corner(const contensou_simulation *simulation, double time);

/* ---- Parameters ------------------------------------------------------------------------------ */

/* A number of the scene that can be set. Its texts live until a parameter is set. */
typedef struct {
   const char *name;        /* as after --set: "top.spin(3)" */
   const char *unit;        /* "" for none */
   const char *description;
   double value;            /* given, by default, or derived from others */
   double low, high;        /* bounds of its domain; -DBL_MAX and DBL_MAX for none */
   bool above_low;          /* whether low itself is excluded */
   bool is_integer;
   bool is_given;           /* whether the scene or a setting gives it */
} contensou_parameter;

/* The number of parameters; 0 for NULL. */
int contensou_simulation_parameters(contensou_simulation *simulation);

/* One of them, 0 <= i; CONTENSOU_BAD_ARGUMENT if there is none. */
int contensou_simulation_parameter(contensou_simulation *simulation, int i,
                                   contensou_parameter *parameter);

/* The value of one of them. */
int contensou_simulation_get(contensou_simulation *simulation, const char *name, double *value,
                             contensou_error **error);

/* Set n of them at once, and begin with them; nothing changes if there is a mistake. Only before
 * the simulation has begun, or after a reset. */
int contensou_simulation_set(contensou_simulation *simulation, const char *const names[],
                             const double values[], int n, contensou_error **error);

/* The same for settings of any kind, as after --set: "integrator.method = 'explicit8'". */
int contensou_simulation_set_text(contensou_simulation *simulation, const char *const settings[],
                                  int n, contensou_error **error);

/* ---- State ----------------------------------------------------------------------------------- */

/* The numbers of bodies and contacts, and their names, 0 <= i; NULL if there is none. */
int contensou_simulation_bodies(const contensou_simulation *simulation);
int contensou_simulation_contacts(const contensou_simulation *simulation);
const char *contensou_simulation_body_name(const contensou_simulation *simulation, int i);
const char *contensou_simulation_contact_name(const contensou_simulation *simulation, int i);

/* The number of elements of the state; 0 for NULL. */
int contensou_simulation_size(const contensou_simulation *simulation);

/* The state at the present, in the order of contensou_observer. */
int contensou_simulation_state(const contensou_simulation *simulation, double *state);

/* Set the n numbers of the state at the present. Contacts are closed where surfaces overlap then;
 * those that are rigid resolve their impacts, by which velocities change. */
int contensou_simulation_set_state(contensou_simulation *simulation, const double *state, int n,
                                   contensou_error **error);

/* The motion of a body at the present; an output may be NULL.
 *   name               of the body in the scene
 * yields
 *   position           centre of mass [m]
 *   quaternion         body to inertial frame, real part first
 *   velocity           of the centre of mass [m/s]
 *   angular_velocity   in the axes of the body [rad/s] */
int contensou_simulation_body(const contensou_simulation *simulation, const char *name,
                              double position[3], double quaternion[4], double velocity[3],
                              double angular_velocity[3]);

/* Time derivative of a state of n numbers, with contacts closed and impacts as at the present. */
int contensou_simulation_derivative(contensou_simulation *simulation, double time,
                                    const double *state, int n, double *rate,
                                    contensou_error **error);

/* Derivatives of that by the state: n rows of n numbers, row i for rate i. */
int contensou_simulation_jacobian(contensou_simulation *simulation, double time,
                                  const double *state, int n, double *matrix,
                                  contensou_error **error);

/* Functions of a state, one for each contact, that pass through zero where it touches or lifts off:
 * gaps [m], of closed rigid contacts the normal force, reversed [N]. */
int contensou_simulation_indicators(contensou_simulation *simulation, double time,
                                    const double *state, int n, double *values,
                                    contensou_error **error);

/* What is usual of each of the n numbers of the state, > 0: for methods that measure the error of a
 * number against its size and that. */
int contensou_simulation_nominals(contensou_simulation *simulation, double *nominals, int n,
                                  contensou_error **error);

/* Whether there are contacts with tangential elasticity, which remember accepted steps; and a
 * function of a state that passes through zero where they have to: within a step they take the way
 * of the spot as straight, and their error there is that function, plus 1, in units of the root of
 * the relative tolerance. It is -1 after a step was accepted, and where nothing is remembered. */
bool contensou_simulation_remembers(const contensou_simulation *simulation);
int contensou_simulation_memory_indicator(contensou_simulation *simulation, double time,
                                          const double *state, int n, double *value,
                                          contensou_error **error);

/* What a contact alone does to its bodies in a state: a force element for programs with bodies of
 * their own, a function of poses and velocities. Those with tangential elasticity, which remember,
 * and rigid ones have none. An output may be NULL.
 *   contact      0 <= contact
 * yields, in the inertial frame,
 *   force        on body B [N]; that on A is its reverse
 *   torque_a     on A about its centre of mass, on the ground about the origin [N m]
 *   torque_b     the same on B */
int contensou_simulation_contact_load(contensou_simulation *simulation, int contact,
                                      const double *state, int n, double force[3],
                                      double torque_a[3], double torque_b[3],
                                      contensou_error **error);

/* The number of body A or B of a contact; -1 for the ground, or if there is no such contact. */
int contensou_simulation_contact_body(const contensou_simulation *simulation, int contact,
                                      bool is_b);

/* A host is a program that integrates the motion with a method of its own, from rates and
 * indicators. It tells of its time and state, of each step that it has accepted, and of events:
 * where an indicator has passed through zero, and once at the beginning. Where contacts remember, a
 * step has to end where the indicator of memory passes through zero, and to be accepted. What
 * follows from an event (impacts, states of the laws of contacts) may change the state, as *changed
 * tells. */
int contensou_simulation_put_host(contensou_simulation *simulation, double time,
                                  const double *state, int n, contensou_error **error);
int contensou_simulation_complete_host_step(contensou_simulation *simulation,
                                            contensou_error **error);
int contensou_simulation_update_host(contensou_simulation *simulation, bool *changed,
                                     contensou_error **error);

/* ---- What acts on bodies --------------------------------------------------------------------- */

/* Let a force at the centre of mass [N] and a torque [N m] act on a body that moves freely, in the
 * frame of its applied_force and in place of it, from the present on. The state gets the work of
 * loads as its last number where it has none yet. */
int contensou_simulation_set_load(contensou_simulation *simulation, const char *body,
                                  const double force[3], const double torque[3],
                                  contensou_error **error);

/* The force and torque applied to body i, 0 <= i; an output may be NULL. */
int contensou_simulation_load(const contensou_simulation *simulation, int i, double force[3],
                              double torque[3]);

/* How bodies move. */
enum { CONTENSOU_FREE = 0, CONTENSOU_FIXED = 1, CONTENSOU_PRESCRIBED = 2, CONTENSOU_SPINDLE = 3 };

/* How body i moves; -1 if there is none. */
int contensou_simulation_motion(const contensou_simulation *simulation, int i);

/* Let the drive of a body accelerate it [m/s2], [rad/s2] in the inertial frame, beside what the
 * scene says, from the present on. A spindle has no acceleration of this kind. */
int contensou_simulation_set_drive(contensou_simulation *simulation, const char *body,
                                   const double acceleration[3],
                                   const double angular_acceleration[3], contensou_error **error);

/* ---- Outputs --------------------------------------------------------------------------------- */

/* A quantity of rows, as in the group /trajectory of a file. Its texts live as long as the
 * simulation. */
typedef struct {
   const char *name;
   const char *units;       /* UDUNITS */
   const char *description;
   int size;                /* numbers: the product of the shape */
   int rank;                /* 0, 1 or 2 */
   int shape[2];            /* bodies or contacts, then components */
   const char *dims[2];     /* "body" or "contact", then "xyz", "wxyz" or "axis" */
} contensou_quantity;

/* The number of quantities; 0 for NULL. */
int contensou_simulation_quantities(contensou_simulation *simulation);

/* One of them, 0 <= i; CONTENSOU_BAD_ARGUMENT if there is none. */
int contensou_simulation_quantity(contensou_simulation *simulation, int i,
                                  contensou_quantity *quantity);

/* The n values of a quantity at the present, components of a body or contact side by side. */
int contensou_simulation_values(contensou_simulation *simulation, const char *name, double *values,
                                int n, contensou_error **error);

/* ---- Copies ---------------------------------------------------------------------------------- */

/* Where a simulation has come to. Taking one ends the step under way at the present: what follows
 * is the same, bit for bit, for the simulation and for those that are brought there. */
typedef struct contensou_snapshot contensou_snapshot;

/* Keep where a simulation has come to; NULL and an error if it has failed. */
contensou_snapshot *contensou_simulation_save(contensou_simulation *simulation,
                                              contensou_error **error);

/* Bring a simulation there, which is of the same scene with the same settings. */
int contensou_simulation_restore(contensou_simulation *simulation,
                                 const contensou_snapshot *snapshot, contensou_error **error);

/* A second simulation like the first; observers are not copied. */
contensou_simulation *contensou_simulation_copy(contensou_simulation *simulation,
                                                contensou_error **error);

/* A snapshot as bytes, for a file or another process; they live as long as it. */
const char *contensou_snapshot_bytes(const contensou_snapshot *snapshot, size_t *size);
contensou_snapshot *contensou_snapshot_new(const char *bytes, size_t size,
                                           contensou_error **error);

/* Release a snapshot; NULL is admitted. */
void contensou_snapshot_free(contensou_snapshot *snapshot);

/* ---- Kernels --------------------------------------------------------------------------------- */

/* Hertz contact of bodies whose undeformed gap is A x^2 + B y^2.
 *   curvature_a  A [1/m], > 0
 *   curvature_b  B [1/m], >= A; both are 1/(2R) for a sphere of radius R on a plane
 *   modulus      effective modulus E* [Pa], > 0
 *   approach     d [m], >= 0
 * yields, unless the output is NULL
 *   a, b         semi-axes of the spot along x and y [m]
 *   force        N [N]
 *   pressure     largest pressure p0 = 3 N/(2 pi a b) [Pa] */
int contensou_hertz(double curvature_a, double curvature_b, double modulus, double approach,
                    double *a, double *b, double *force, double *pressure);

/* The same for n contacts. Element i of an input is inputs[k][i*strides[k]], in the order above;
 * the stride 0 repeats a number, a negative one goes back. Outputs lie side by side, and are NaN
 * outside of the domain. */
int contensou_hertz_array(ptrdiff_t n, const double *const inputs[4], const ptrdiff_t strides[4],
                          double *const outputs[4]);

/* Complete elliptic integrals K and E of n complements c1 = 1 - k^2 of the parameter, in [0, 1]. */
int contensou_elliptic_array(ptrdiff_t n, const double *const inputs[1], const ptrdiff_t strides[1],
                             double *const outputs[2]);

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

/* The same for n spots: load, a, b, vx, vy, spin by strides, as of contensou_hertz_array; three
 * numbers for each spot. */
int contensou_friction_wrench_array(const contensou_friction *friction, ptrdiff_t n,
                                    const double *const inputs[6], const ptrdiff_t strides[6],
                                    double *wrenches);

/* The same with derivatives: three rows, for Fx, Fy and Tz, of five, by N, by a at constant b/a, by
 * vx, vy and the spin. */
int contensou_friction_jacobian(const contensou_friction *friction, double load, double a, double b,
                                double vx, double vy, double spin, double wrench[3],
                                double slopes[15]);

/* The same for n spots: inputs as of contensou_friction_wrench_array, three and fifteen numbers for
 * each spot. */
int contensou_friction_jacobian_array(const contensou_friction *friction, ptrdiff_t n,
                                      const double *const inputs[6], const ptrdiff_t strides[6],
                                      double *wrenches, double *slopes);

/* Release a friction model; NULL is admitted. */
void contensou_friction_free(contensou_friction *friction);

/* Stiffness of n spots on which nothing slips. Inputs: a, b [m], 0 < b <= a, shear modulus G [Pa]
 * and Poisson's ratio nu of both bodies together:
 *   1/G = (1/G1 + 1/G2)/2,  nu/G = (nu1/G1 + nu2/G2)/2
 * Outputs: k_x, k_y [N/m] and k_T [N m]. */
int contensou_tangential_stiffness_array(ptrdiff_t n, const double *const inputs[4],
                                         const ptrdiff_t strides[4], double *const outputs[3]);

/* A spot with local slip, and its memory. */
typedef struct contensou_tangential contensou_tangential;

/* Make a spot that remembers nothing yet.
 *   modulus      shear modulus G of both bodies together [Pa], > 0
 *   poisson      Poisson's ratio of both together, from -1 to 1/2
 *   layers       from 1 to 128; 0 for one spring without local slip, -1 for as many as a scene
 *                has unless it tells
 * Returns NULL if an argument is outside its domain. */
contensou_tangential *contensou_tangential_new(double modulus, double poisson, int layers);

/* n steps of the spot, one after the other. Inputs: limit f N [N], semi-axes a and b [m],
 * 0 < b <= a, shift of body 1 against body 2 along x and y [m] and twist [rad] since the step
 * before. Outputs, each of n numbers: Fx, Fy [N], Tz [N m] on body 1, the elastic energy after the
 * step [J] and what was lost in it [J]. Without a limit the spot is open and forgets. A step out of
 * the domain gives NaN and is not remembered. */
int contensou_tangential_advance_array(contensou_tangential *tangential, ptrdiff_t n,
                                       const double *const inputs[6], const ptrdiff_t strides[6],
                                       double *const outputs[5]);

/* Release a spot; NULL is admitted. */
void contensou_tangential_free(contensou_tangential *tangential);

#ifdef __cplusplus
}
#endif

#endif
