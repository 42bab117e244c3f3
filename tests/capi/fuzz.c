/* Random sequences of calls of the C interface, right and wrong ones, also of what was released,
 * under sanitizers: nothing may crash, print or hang, and what is refused has an error with a text.
 *
 *   fuzz SEED SEQUENCES    prints "SEQUENCES sequences, N calls, M refused" */
#include <contensou.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { MOST = 3, ROOM = 4096 };

/* CPU time that one call may take, under sanitizers too [s]. */
enum { LONGEST = 60 };

#define STEEL "&material name = 'steel', young = 2e11, poisson = 0.3 /\n"
#define BALL                                                                                       \
   "&surface name = 'plane', body = 'table', shape = 'plane', material = 'steel' /\n"              \
   "&surface name = 'skin', body = 'ball', shape = 'sphere', radius = 0.01, material = 'steel' /\n" \
   "&body name = 'ball', mass = 0.1, inertia = 3*1e-5, position = 0.02, 0, 0.0099999,\n"           \
   "   velocity = 0.1, 0, -0.1, spin = 0, 1, 20 /\n"

static const char *const scenes[] = {
   "&scene t_end = 0.02 /\n" STEEL BALL "&body name = 'table', motion = 'fixed' /\n"
   "&contact name = 'foot', surfaces = 'plane', 'skin', friction = 'contensou_exact',\n"
   "   friction_coefficient = 0.3 /\n",
   "&scene t_end = 0.02 /\n" STEEL BALL "&body name = 'table', motion = 'prescribed',\n"
   "   ramp_duration = 0.005, final_angular_velocity = 0, 0, 3 /\n"
   "&contact name = 'foot', surfaces = 'plane', 'skin', normal = 'rigid', friction = 'pade22',\n"
   "   friction_coefficient = 0.3 /\n",
   "&scene t_end = 0.02 /\n" STEEL BALL "&body name = 'table', motion = 'fixed' /\n"
   "&contact name = 'foot', surfaces = 'plane', 'skin', friction = 'contensou_exact',\n"
   "   friction_coefficient = 0.3, tangential = 'elastic', layers = 2 /\n",
   "&scene t_end = 0.02, gravity = 0, 0, 0 /\n"
   "&body name = 'one', mass = 1, inertia = 1, 2, 2.5, spin = 1, 2, 3 /\n",
   "&scene t_end = ", "", "&body name = 'one' /\n", "\xff\xfe&&&"};

static const char *const words[] = {
   "", " ", "ball", "floor", "table", "one", "foot", "ball.mass", "ball.spin(3)", "scene.t_end",
   "scene.gravity(3)", "foot.friction_coefficient", "position", "gap", "normal_force", "time",
   "energy_kinetic", "velocity", "ball.mas", "ball.mass = 0.2", "scene.t_end = 1e-3",
   "integrator.method = 'explicit8'", "integrator.method = 'cvode_bdf'", "ball.mass = -1",
   "scene.t_end = 'x'", "= 3", "ball.mass =", "foot.friction = 'pade11'", "contensou_exact",
   "coulomb", "none", "\xff\xfe", "a very long name that nothing has, with commas, and more of it"};

static unsigned long long random_state;
static long calls, refused;
static contensou_simulation *simulations[MOST];
static contensou_snapshot *snapshots[MOST];
static contensou_friction *frictions[MOST];
static contensou_tangential *tangentials[MOST];
static contensou_simulation *in_use;

/* A whole number, 0 <= number < n. */
static int below(int n)
{
   random_state = random_state * 6364136223846793005ull + 1442695040888963407ull;
   return (int)((random_state >> 33) % (unsigned)n);
}

static const char *word(void)
{
   return below(20) ? words[below(sizeof words / sizeof *words)] : NULL;
}

static double value(void)
{
   static const double odd[] = {0.0, -0.0, 1.0, -1.0, 1e-300, -1e300, 1e300, 1e-3, 0.3,
                                2e11, 1e-5, 0.01};
   switch (below(12)) {
   case 0:
      return NAN;
   case 1:
      return below(2) ? INFINITY : -INFINITY;
   case 2:
   case 3:
   case 4:
      return odd[below(sizeof odd / sizeof *odd)];
   default:
      return (below(2000001) - 1000000) * 1e-6;
   }
}

static void fill(double *x, int n)
{
   int i;
   for (i = 0; i < n; i++) x[i] = value();
}

/* A number of elements: right, or nearly. */
static int length(int n)
{
   return below(8) ? n : n - 2 + below(5) - (below(5) == 0) * 100000;
}

static void fail(const char *what)
{
   fprintf(stderr, "fuzz: %s\n", what);
   abort();
}

/* An error belongs to a status that is not 0, has a text, and is released. */
static void look(int status, contensou_error **asked)
{
   contensou_error *error = asked ? *asked : NULL;
   contensou_mistake mistake;
   int i;

   calls++;
   if (status) refused++;
   if (!asked) return;
   if ((status != 0) != (error != NULL)) fail("a status without an error, or an error without it");
   if (!error) return;
   if (contensou_error_status(error) != status) fail("the status is not that of the error");
   if (!*contensou_error_message(error)) fail("an error without a text");
   for (i = -1; i <= contensou_error_mistakes(error); i++)
      if (contensou_error_mistake(error, i, below(9) ? &mistake : NULL) == CONTENSOU_OK &&
          !*mistake.message)
         fail("a mistake without a text");
   contensou_error_free(error);
   *asked = NULL;
}

/* Changes and asks in the middle of an advance. */
static int on_row(double time, const double *state, int n, void *user_data)
{
   contensou_error *error = NULL;
   double x[ROOM];
   (void)time, (void)state, (void)n, (void)user_data;
   switch (below(40)) {
   case 0:
      look(contensou_simulation_advance(in_use, 1.0, &error), &error);
      break;
   case 1:
      look(contensou_simulation_reset(in_use, &error), &error);
      break;
   case 2:
      contensou_simulation_free(in_use);
      break;
   case 3:
      look(contensou_simulation_values(in_use, word(), x, 3, &error), &error);
      break;
   case 4:
      return 1;
   case 5:
      contensou_snapshot_free(contensou_simulation_save(in_use, NULL));
      break;
   case 6:
      contensou_simulation_free(contensou_simulation_copy(in_use, NULL));
      break;
   default:
      break;
   }
   return 0;
}

static int on_event(double time, int kind, int contact, void *user_data)
{
   (void)time, (void)kind, (void)contact, (void)user_data;
   return below(9) == 0;
}

static void make(contensou_simulation **place, contensou_error **asked)
{
   contensou_error *error = NULL;
   const char *settings[3];
   const char *scene = scenes[below(4)];
   int i, n = below(4) ? 0 : below(4);

   for (i = 0; i < 3; i++) settings[i] = word();
   if (!below(12)) scene = scenes[below(sizeof scenes / sizeof *scenes)];
   contensou_simulation_free(*place);
   if (!below(10)) contensou_simulation_free(*place);
   if (!below(30)) {
      *place = contensou_simulation_make(below(6) - 1, word(), below(2) ? scene : NULL, settings,
                                         below(5) - 1, asked ? &error : NULL);
   } else if (!below(30)) {
      *place = contensou_simulation_new(word(), settings, n, asked ? &error : NULL);
   } else {
      *place = contensou_simulation_from_text(word(), below(20) ? scene : NULL,
                                              below(10) ? settings : NULL, n,
                                              asked ? &error : NULL);
   }
   calls++;
   if (asked && (*place == NULL) != (error != NULL)) fail("neither a simulation nor an error");
   contensou_error_free(error);
}

static void call_kernels(void)
{
   double x[7][8], out[6][8 * 15], wrench[3], slopes[15];
   const double *inputs[6];
   double *outputs[6];
   ptrdiff_t strides[6], n = below(10) ? below(8) : -1;
   contensou_friction **friction = &frictions[below(MOST)];
   contensou_tangential **tangential = &tangentials[below(MOST)];
   int i, k;

   for (k = 0; k < 6; k++) {
      fill(x[k], 8);
      if (below(2))
         for (i = 0; i < 8; i++) x[k][i] = fabs(x[k][i]);
      strides[k] = below(3) - 1;
      inputs[k] = below(40) ? &x[k][strides[k] < 0 ? 7 : 0] : NULL;
      outputs[k] = below(40) ? out[k] : NULL;
   }
   calls++;
   switch (below(12)) {
   case 0:
      contensou_hertz(x[0][0], x[1][0], x[2][0], x[3][0], outputs[0], outputs[1], outputs[2],
                      outputs[3]);
      break;
   case 1:
      contensou_hertz_array(n, below(20) ? inputs : NULL, below(20) ? strides : NULL,
                            below(20) ? outputs : NULL);
      break;
   case 2:
      contensou_elliptic_array(n, below(20) ? inputs : NULL, below(20) ? strides : NULL,
                               below(20) ? outputs : NULL);
      break;
   case 3:
      contensou_friction_free(*friction);
      if (!below(4)) return;
      *friction = contensou_friction_new(word(), fabs(value()), fabs(value()), below(2));
      break;
   case 4:
      contensou_friction_wrench(*friction, x[0][0], x[1][0], x[2][0], x[3][0], x[4][0], x[5][0],
                                below(20) ? wrench : NULL);
      break;
   case 5:
      contensou_friction_jacobian(*friction, x[0][0], x[1][0], x[2][0], x[3][0], x[4][0], x[5][0],
                                  below(20) ? wrench : NULL, below(20) ? slopes : NULL);
      break;
   case 6:
      contensou_friction_wrench_array(*friction, n, below(20) ? inputs : NULL,
                                      below(20) ? strides : NULL, outputs[0]);
      break;
   case 7:
      contensou_friction_jacobian_array(*friction, n, below(20) ? inputs : NULL,
                                        below(20) ? strides : NULL, outputs[0], outputs[1]);
      break;
   case 8:
      contensou_tangential_stiffness_array(n, below(20) ? inputs : NULL,
                                           below(20) ? strides : NULL, below(20) ? outputs : NULL);
      break;
   case 9:
      contensou_tangential_free(*tangential);
      if (!below(4)) return;
      *tangential = contensou_tangential_new(fabs(value()), value() / 2.0, below(150) - 10);
      break;
   default:
      contensou_tangential_advance_array(*tangential, n, below(20) ? inputs : NULL,
                                         below(20) ? strides : NULL, below(20) ? outputs : NULL);
      break;
   }
}

static void call_simulation(void)
{
   static const double times[] = {0.0, 1e-6, 1e-4, 1e-3, -1.0};
   contensou_error *error = NULL, **asked = below(10) ? &error : NULL;
   contensou_simulation **place = &simulations[below(MOST)], *self = *place;
   contensou_snapshot **kept = &snapshots[below(MOST)];
   contensou_parameter parameter;
   contensou_quantity quantity;
   const char *names[4];
   double x[ROOM], y[ROOM], time;
   int i, wild, n = contensou_simulation_size(self);
   bool changed;

   if (2 * n * n > ROOM) fail("a scene is too large");
   in_use = self;
   if (n == 0 && below(4)) {
      make(place, asked);
      return;
   }
   time = contensou_simulation_time(self) + times[below(5)];
   if (!below(20)) time = value();
   if (!below(30)) time = NAN;
   for (i = 0; i < 4; i++) names[i] = word();
   if (n > 0) contensou_simulation_state(self, x);
   if (n == 0 || !below(4)) fill(x, 100);
   else if (!below(2))
      for (i = 0; i < n; i++) x[i] += 1e-4 * value();
   /* What turns or moves too fast takes ages to follow, rightly. */
   wild = 0;
   if (n > 0) contensou_simulation_state(self, y);
   for (i = 0; i < n; i++) wild = wild || fabs(y[i]) > 1e3;
   switch (below(37)) {
   case 0:
   case 1:
      make(place, asked);
      return;
   case 2:
      if (below(3)) return;
      contensou_simulation_free(self);
      if (below(2)) *place = NULL;
      return;
   case 3:
      look(contensou_simulation_reset(self, asked), asked);
      return;
   case 4:
      if (!contensou_simulation_settings(self) || !contensou_simulation_warnings(self))
         fail("no text");
      return;
   case 5:
      contensou_simulation_observe(self, below(2) ? on_row : NULL, below(2) ? on_event : NULL, NULL);
      return;
   case 6:
   case 7:
   case 8:
      if (wild) return;
      if (time > 1.0 && isfinite(time)) time = 1e-3;
      look(contensou_simulation_advance(self, time, asked), asked);
      return;
   case 9:
      if (wild) return;
      if (time > 1.0 && isfinite(time)) time = 1e-3;
      look(contensou_simulation_advance_to_event(self, time, asked), asked);
      return;
   case 10:
      if (wild || below(4)) return;
      look(contensou_simulate(self, below(2) ? on_row : NULL, NULL, asked), asked);
      return;
   case 11:
      contensou_simulation_end(self);
      contensou_simulation_stop(self);
      contensou_simulation_next_corner(self, value());
      return;
   case 12:
      n = contensou_simulation_parameters(self);
      contensou_simulation_parameter(self, below(n + 2) - 1, below(20) ? &parameter : NULL);
      return;
   case 13:
      look(contensou_simulation_get(self, word(), below(20) ? y : NULL, asked), asked);
      return;
   case 14:
      fill(y, 4);
      look(contensou_simulation_set(self, below(20) ? names : NULL, below(20) ? y : NULL,
                                    below(6) - 1 < 5 ? below(5) : -1, asked), asked);
      return;
   case 15:
      look(contensou_simulation_set_text(self, below(20) ? names : NULL, below(6) - 1 < 4
                                            ? below(4) : -1, asked), asked);
      return;
   case 16:
      contensou_simulation_body_name(self, below(6) - 2);
      contensou_simulation_contact_name(self, below(6) - 2);
      contensou_simulation_motion(self, below(6) - 2);
      contensou_simulation_load(self, below(6) - 2, below(9) ? y : NULL, below(9) ? y + 3 : NULL);
      contensou_simulation_contact_body(self, below(6) - 2, below(2));
      return;
   case 17:
      contensou_simulation_state(self, below(9) ? y : NULL);
      return;
   case 18:
      look(contensou_simulation_set_state(self, below(20) ? x : NULL, length(n), asked),
           asked);
      return;
   case 19:
      contensou_simulation_body(self, word(), below(9) ? y : NULL, below(9) ? y + 3 : NULL, y + 7,
                                y + 10);
      return;
   case 20:
      look(contensou_simulation_derivative(self, time, below(20) ? x : NULL, length(n),
                                           below(20) ? y : NULL, asked), asked);
      return;
   case 21:
      look(contensou_simulation_jacobian(self, time, below(20) ? x : NULL, length(n),
                                         below(20) ? y : NULL, asked), asked);
      return;
   case 22:
      look(contensou_simulation_indicators(self, time, below(20) ? x : NULL, length(n),
                                           below(20) ? y : NULL, asked), asked);
      return;
   case 23:
      look(contensou_simulation_contact_load(self, below(4) - 1, below(20) ? x : NULL, length(n),
                                             below(9) ? y : NULL, below(9) ? y + 3 : NULL, y + 6,
                                             asked), asked);
      return;
   case 24:
      look(contensou_simulation_put_host(self, time, below(20) ? x : NULL, length(n), asked),
           asked);
      return;
   case 25:
      look(contensou_simulation_complete_host_step(self, asked), asked);
      return;
   case 26:
      look(contensou_simulation_update_host(self, below(4) ? &changed : NULL, asked), asked);
      return;
   case 27:
      fill(y, 6);
      look(contensou_simulation_set_load(self, word(), below(20) ? y : NULL,
                                         below(20) ? y + 3 : NULL, asked), asked);
      return;
   case 28:
      fill(y, 6);
      look(contensou_simulation_set_drive(self, word(), below(20) ? y : NULL,
                                          below(20) ? y + 3 : NULL, asked), asked);
      return;
   case 29:
      n = contensou_simulation_quantities(self);
      if (contensou_simulation_quantity(self, below(n + 2) - 1, below(20) ? &quantity : NULL))
         return;
      look(contensou_simulation_values(self, word(), y, quantity.size, asked), asked);
      return;
   case 30:
      look(contensou_simulation_values(self, word(), below(20) ? y : NULL, below(9), asked),
           asked);
      return;
   case 31:
      contensou_snapshot_free(*kept);
      if (!below(4)) return;
      *kept = contensou_simulation_save(self, asked);
      look(*kept ? 0 : contensou_error_status(error), asked);
      return;
   case 32:
      look(contensou_simulation_restore(self, *kept, asked), asked);
      return;
   case 33:
      look(contensou_simulation_nominals(self, below(20) ? y : NULL, length(n), asked), asked);
      return;
   case 34:
   case 35:
      contensou_simulation_remembers(self);
      look(contensou_simulation_memory_indicator(self, time, below(20) ? x : NULL, length(n),
                                                 below(20) ? y : NULL, asked), asked);
      return;
   default:
      place = &simulations[below(MOST)];
      if (*place == self || (n == 0 && below(20))) return;
      contensou_simulation_free(*place);
      *place = contensou_simulation_copy(self, asked);
      look(*place ? 0 : contensou_error_status(error), asked);
      return;
   }
}

/* A snapshot as bytes, perhaps with some of them wrong or without its end. */
static void call_snapshot(void)
{
   contensou_error *error = NULL;
   contensou_snapshot *again;
   size_t size = 0, i;
   const char *bytes = contensou_snapshot_bytes(snapshots[below(MOST)], below(20) ? &size : NULL);
   char *copy = malloc(size + 1);

   if (!copy) return;
   if (bytes && size) memcpy(copy, bytes, size);
   for (i = 0; i < 3 && size > 0 && below(2); i++) copy[below((int)size)] ^= (char)(1 << below(8));
   if (!below(4) && size > 0) size = (size_t)below((int)size);
   again = contensou_snapshot_new(below(20) ? copy : NULL, size, &error);
   look(again ? 0 : contensou_error_status(error), &error);
   error = NULL;
   if (again && below(2)) {
      contensou_simulation *self = simulations[below(MOST)];
      look(contensou_simulation_restore(self, again, &error), &error);
   }
   contensou_snapshot_free(again);
   free(copy);
}

int main(int argc, char **argv)
{
   long i, sequences;
   int k;

   if (argc != 3) return 2;
   random_state = strtoull(argv[1], NULL, 10) * 2862933555777941757ull + 1;
   sequences = strtol(argv[2], NULL, 10);
   for (i = 0; i < sequences; i++) {
      int steps = 1 + below(12);
      for (k = 0; k < steps; k++) {
         int which = below(10);
         clock_t begin = clock();
         if (which < 7) call_simulation();
         else if (which < 9) call_kernels();
         else call_snapshot();
         if (clock() - begin > (clock_t)LONGEST * CLOCKS_PER_SEC) fail("a call that hangs");
      }
   }
   for (k = 0; k < MOST; k++) {
      contensou_simulation_free(simulations[k]);
      contensou_snapshot_free(snapshots[k]);
      contensou_friction_free(frictions[k]);
      contensou_tangential_free(tangentials[k]);
   }
   printf("%ld sequences, %ld calls, %ld refused\n", sequences, calls, refused);
   return 0;
}
