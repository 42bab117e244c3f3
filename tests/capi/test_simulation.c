/* Simulations by the C interface: mistakes, null pointers, stopping, and two threads.
 *
 *   test_simulation FOLDER    with the shipped scenes; prints one line for each failed check */
#include <contensou.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int passed, failed;

static void check(int condition, const char *name)
{
   if (condition) {
      passed++;
   } else {
      failed++;
      printf("failed: %s\n", name);
   }
}

static const char *folder;

/* One simulation from its file to its end. */
typedef struct {
   const char *scene;
   const char *settings[2];
   double *state;
   int size, rows, status;
} job;

static int count(double time, const double *state, int n, void *user_data)
{
   job *of = user_data;
   of->rows += time >= 0.0 && n > 0 && state[2] == state[2];
   return 0;
}

static void *simulate(void *argument)
{
   job *of = argument;
   char name[4096];
   contensou_simulation *simulation;

   snprintf(name, sizeof name, "%s/%s", folder, of->scene);
   simulation = contensou_simulation_new(name, of->settings, 2, NULL);
   of->rows = 0;
   of->status = contensou_simulate(simulation, count, of, NULL);
   of->size = contensou_simulation_size(simulation);
   of->state = calloc((size_t)of->size + 1, sizeof *of->state);
   contensou_simulation_state(simulation, of->state);
   contensou_simulation_free(simulation);
   return NULL;
}

/* Two simulations side by side end with the bits and rows that each has alone. */
static void check_threads(job first, job second)
{
   job alone[2], together[2];
   pthread_t threads[2];
   int i, round;

   alone[0] = first;
   alone[1] = second;
   for (i = 0; i < 2; i++) {
      simulate(&alone[i]);
      check(alone[i].status == CONTENSOU_OK && alone[i].size >= 13, "a simulation alone");
   }
   for (round = 0; round < 3; round++) {
      for (i = 0; i < 2; i++) {
         together[i] = alone[i];
         check(pthread_create(&threads[i], NULL, simulate, &together[i]) == 0, "a thread");
      }
      for (i = 0; i < 2; i++) {
         pthread_join(threads[i], NULL);
         check(together[i].status == CONTENSOU_OK, "a simulation beside another one");
         check(together[i].rows == alone[i].rows && together[i].size == alone[i].size &&
                  memcmp(together[i].state, alone[i].state,
                         (size_t)alone[i].size * sizeof *alone[i].state) == 0,
               "the bits that it has alone");
         free(together[i].state);
      }
   }
   free(alone[0].state);
   free(alone[1].state);
}

/* The third row is the last that is wanted. */
static int stop_at_third(double time, const double *state, int n, void *user_data)
{
   (void)time, (void)state, (void)n;
   return ++*(int *)user_data == 3;
}

static void check_stop(const char *scene)
{
   const char *settings[] = {"scene.t_end = 0.01", "output.interval = 1e-3"};
   contensou_error *error;
   contensou_simulation *top = contensou_simulation_new(scene, settings, 2, &error);
   double position[3], quaternion[4], velocity[3], spin[3], *state;
   int rows = 0;

   check(top && !error && contensou_error_status(error) == 0 &&
            strcmp(contensou_error_message(error), "") == 0, "a scene without mistakes");
   check(contensou_simulation_time(top) == 0.0, "time at the beginning");
   check(contensou_simulate(top, stop_at_third, &rows, &error) == CONTENSOU_OK && !error &&
            rows == 3 && contensou_simulation_time(top) >= 2e-3 &&
            contensou_simulation_time(top) < 5e-3, "the observer stops");
   check(contensou_simulate(top, NULL, NULL, NULL) == CONTENSOU_OK &&
            contensou_simulation_time(top) == 0.01, "it goes on to its end");
   check(contensou_simulation_body(top, "top", position, quaternion, velocity, spin) ==
            CONTENSOU_OK, "the motion of a body");
   state = calloc((size_t)contensou_simulation_size(top), sizeof *state);
   check(contensou_simulation_state(top, state) == CONTENSOU_OK, "the state");
   check(memcmp(state, position, sizeof position) == 0 &&
            memcmp(state + 3, quaternion, sizeof quaternion) == 0 &&
            memcmp(state + 7, velocity, sizeof velocity) == 0 &&
            memcmp(state + 10, spin, sizeof spin) == 0, "order of the state");
   check(contensou_simulation_body(top, "bottom", position, NULL, NULL, NULL) ==
            CONTENSOU_BAD_ARGUMENT, "no such body");
   check(contensou_simulation_body(top, NULL, position, NULL, NULL, NULL) ==
            CONTENSOU_BAD_ARGUMENT, "body without a name");
   check(contensou_simulation_state(top, NULL) == CONTENSOU_BAD_ARGUMENT, "nowhere to put it");
   free(state);
   contensou_simulation_free(top);
}

/* Whether making a simulation fails with a status and a text that contains another one. */
static int refused(const char *scene, const char *setting, int status, const char *text)
{
   const char *settings[] = {setting};
   contensou_error *error = NULL;
   contensou_simulation *none = contensou_simulation_new(scene, settings, 1, &error);
   int right = !none && contensou_error_status(error) == status &&
               strstr(contensou_error_message(error), text) != NULL;

   if (!right) printf("%s\n", contensou_error_message(error));
   contensou_error_free(error);
   contensou_simulation_free(none);
   return right;
}

/* A program that was compiled with another header is told so, unless its interface is known. */
static void check_interfaces(const char *scene)
{
   contensou_error *error = NULL;
   contensou_simulation *old;

   check(contensou_interface() == CONTENSOU_INTERFACE, "the interface of header and library");
   check(!contensou_simulation_make(CONTENSOU_INTERFACE + 1, scene, NULL, NULL, 0, &error) &&
            contensou_error_status(error) == 2 &&
            strstr(contensou_error_message(error), "compiled with a header of interface"),
         "a header that is newer than the library");
   contensou_error_free(error);
   check(!contensou_simulation_make(0, scene, NULL, NULL, 0, NULL), "a header that is too old");
   old = contensou_simulation_make(1, scene, NULL, NULL, 0, NULL);
   check(old != NULL, "a header that is old, and known");
   contensou_simulation_free(old);
}

/* The load of a contact alone is what the equations of motion have of it. */
static void check_contact_load(const char *scene)
{
   const char *settings[] = {"scene.gravity = 0, 0, 0", "top.position(3) = 0.012"};
   contensou_error *error = NULL;
   contensou_simulation *top = contensou_simulation_new(scene, settings, 2, &error);
   const int n = contensou_simulation_size(top);
   double *state = calloc((size_t)n, sizeof *state), *rate = calloc((size_t)n, sizeof *rate);
   double force[3], on_floor[3], on_top[3], mass, arm[3];
   int a, b, i, sign;

   contensou_simulation_state(top, state);
   contensou_simulation_get(top, "top.mass", &mass, NULL);
   check(contensou_simulation_derivative(top, 0.0, state, n, rate, &error) == CONTENSOU_OK &&
            contensou_simulation_contact_load(top, 0, state, n, force, on_top, on_floor, &error) ==
               CONTENSOU_OK, "the load of a contact");
   a = contensou_simulation_contact_body(top, 0, false);
   b = contensou_simulation_contact_body(top, 0, true);
   check(a + b == -1, "the top and the ground");
   /* The force is that on B. */
   sign = b == 0 ? 1 : -1;
   for (i = 0; i < 3; i++)
      check(sign * force[i] / mass == rate[7 + i] && rate[9] > 0.0, "the acceleration");
   /* Moments about the origin are in balance. */
   if (b == 0) memcpy(arm, on_top, sizeof arm), memcpy(on_top, on_floor, sizeof arm),
               memcpy(on_floor, arm, sizeof arm);
   for (i = 0; i < 3; i++) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      const double moment = sign * (state[j] * force[k] - state[k] * force[j]);
      check(on_floor[i] + on_top[i] + moment < 1e-15 && on_floor[i] + on_top[i] + moment > -1e-15,
            "moments in balance");
   }
   check(contensou_simulation_contact_load(top, 1, state, n, force, NULL, NULL, &error) ==
            CONTENSOU_OK && force[0] == 0.0 && force[2] == 0.0, "an open contact");
   check(contensou_simulation_contact_load(top, 2, state, n, force, NULL, NULL, &error) == 2,
         "no such contact");
   contensou_error_free(error);
   check(contensou_simulation_contact_load(top, 0, state, n - 1, force, NULL, NULL, &error) == 2,
         "a state of the wrong length");
   contensou_error_free(error);
   check(contensou_simulation_contact_body(top, 7, true) == -1 &&
            contensou_simulation_contact_body(NULL, 0, true) == -1, "bodies of no contact");
   free(state);
   free(rate);
   contensou_simulation_free(top);
}

/* What was released is answered as NULL is, also when something else has been made since. */
static void check_released(const char *scene)
{
   contensou_error *error = NULL, *again = NULL;
   contensou_simulation *one = contensou_simulation_new(scene, NULL, 0, NULL), *other;
   contensou_snapshot *kept = contensou_simulation_save(one, NULL);
   double state[64];

   contensou_snapshot_free(kept);
   contensou_simulation_free(one);
   other = contensou_simulation_new(scene, NULL, 0, NULL);
   check(other && other != one, "a handle of its own");
   contensou_simulation_free(one);
   check(contensou_simulation_size(other) == 13 + 2, "another simulation stays");
   check(contensou_simulation_size(one) == 0 && contensou_simulation_time(one) == 0.0 &&
            contensou_simulation_state(one, state) == CONTENSOU_BAD_ARGUMENT &&
            contensou_simulation_body_name(one, 0) == NULL &&
            contensou_simulation_parameters(one) == 0, "what was released has nothing");
   check(contensou_simulation_advance(one, 1.0, &error) == 2 &&
            strcmp(contensou_error_message(error), "there is no simulation") == 0,
         "what was released does nothing");
   contensou_error_free(error);
   check(strcmp(contensou_error_message(error), "") == 0 && contensou_error_status(error) == 0,
         "an error that was released");
   contensou_error_free(error);
   check(contensou_simulation_restore(other, kept, &again) == 2 &&
            strcmp(contensou_error_message(again), "there is no snapshot") == 0 &&
            contensou_snapshot_bytes(kept, NULL) == NULL, "a snapshot that was released");
   contensou_error_free(again);
   contensou_snapshot_free(kept);
   check(contensou_simulation_size((contensou_simulation *)state) == 0, "an address is no handle");
   contensou_simulation_free(other);
}

int main(int argc, char **argv)
{
   const job top = {"tippe_top.nml", {"scene.t_end = 0.05", "integrator.method = 'auto'"},
                    NULL, 0, 0, 0};
   const job egg = {"ellipsoid_egg.nml", {"scene.t_end = 0.05", "integrator.rtol = 1e-9"},
                    NULL, 0, 0, 0};
   const job bearing = {"bearing_6205.nml", {"scene.t_end = 2e-4", "output.interval = 1e-5"},
                        NULL, 0, 0, 0};
   contensou_error *error = NULL;
   char scene[4096], deep[4096];
   const char *fast[] = {"ball.velocity(3) = -1e4"};
   contensou_simulation *ball;

   if (argc != 2) return 2;
   folder = argv[1];
   snprintf(scene, sizeof scene, "%s/tippe_top.nml", folder);
   snprintf(deep, sizeof deep, "%s/bouncing_ball.nml", folder);

   check_stop(scene);
   check_interfaces(scene);
   check_released(scene);
   check_contact_load(scene);
   check_threads(top, top);
   check_threads(egg, bearing);

   check(refused("no such file.nml", "scene.t_end = 1", 74, "no such file.nml"), "no such file");
   check(refused(scene, "top.mas = 1", 2, "expected"), "a key that there is not");
   check(refused(scene, "top.mass = -1", 2, "mass"), "a value out of its domain");
   check(refused(NULL, "top.mass = 1", 2, "is empty"), "no name of a scene");
   check(contensou_simulation_new(NULL, NULL, 0, NULL) == NULL, "an error that nobody wants");
   ball = contensou_simulation_new(deep, fast, 1, &error);
   check(ball && contensou_simulate(ball, NULL, NULL, &error) == 1 && error &&
            contensou_error_status(error) == 1 &&
            strstr(contensou_error_message(error), "the run failed at t = ") != NULL,
         "a simulation that fails");
   contensou_error_free(error);
   contensou_simulation_free(ball);

   check(contensou_simulate(NULL, NULL, NULL, &error) == 2 &&
            strcmp(contensou_error_message(error), "there is no simulation") == 0, "null");
   contensou_error_free(error);
   check(contensou_simulation_time(NULL) == 0.0 && contensou_simulation_size(NULL) == 0 &&
            contensou_simulation_state(NULL, NULL) == CONTENSOU_BAD_ARGUMENT &&
            contensou_simulation_body(NULL, "top", NULL, NULL, NULL, NULL) ==
               CONTENSOU_BAD_ARGUMENT, "getters of null");
   contensou_simulation_free(NULL);
   contensou_error_free(NULL);

   printf("%d passed, %d failed\n", passed, failed);
   return failed > 0;
}
