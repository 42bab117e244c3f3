/* Two simulations side by side do not wait for each other: nothing locks the texts in derivatives,
 * Jacobians, steps and rows, and their threads give up the processor for nothing. Their states have
 * the bits that they have alone.
 *
 *   test_threads FOLDER [times]    with the shipped scenes; prints one line for each failed check,
 *                                  and with "times" the wall time of two threads over that of one
 *
 * The linker lets calls of the lock pass here first (--wrap). */
#define _GNU_SOURCE
#include <contensou.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>

void __real_contensou_text_lock(void);
void __wrap_contensou_text_lock(void);

static atomic_long locks;

void __wrap_contensou_text_lock(void)
{
   locks++;
   __real_contensou_text_lock();
}

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

/* A simulation that is brought to its end. */
typedef struct {
   contensou_simulation *simulation;
   double end, *state, *matrix, *values;
   int size, rows, status;
   long waits;
} job;

static int row(double time, const double *state, int n, void *user_data)
{
   job *of = user_data;
   (void)state, (void)n;
   of->rows += time >= 0.0;
   return contensou_simulation_values(of->simulation, "energy_kinetic", of->values, 1, NULL);
}

static job made(const char *folder, const char *name, const char *setting)
{
   char scene[4096];
   job new = {0};

   snprintf(scene, sizeof scene, "%s/%s.nml", folder, name);
   new.simulation = contensou_simulation_new(scene, &setting, 1, NULL);
   new.end = contensou_simulation_end(new.simulation);
   new.size = contensou_simulation_size(new.simulation);
   new.state = malloc((size_t)new.size * sizeof(double));
   new.values = malloc((size_t)new.size * sizeof(double));
   new.matrix = malloc((size_t)(new.size * new.size) * sizeof(double));
   return new;
}

/* Ask for all that a host asks for, then run. */
static void *run(void *argument)
{
   job *of = argument;
   struct rusage before, after;
   int i;

   getrusage(RUSAGE_THREAD, &before);
   contensou_simulation_observe(of->simulation, row, NULL, of);
   contensou_simulation_state(of->simulation, of->state);
   of->status = 0;
   for (i = 0; i < 50; i++) {
      of->status |= contensou_simulation_derivative(of->simulation, 0.0, of->state, of->size,
                                                    of->values, NULL);
      of->status |= contensou_simulation_jacobian(of->simulation, 0.0, of->state, of->size,
                                                  of->matrix, NULL);
      of->status |= contensou_simulation_indicators(of->simulation, 0.0, of->state, of->size,
                                                    of->values, NULL);
   }
   for (i = 1; i <= 20 && of->status == 0; i++)
      of->status = contensou_simulation_advance(of->simulation, of->end * i / 20, NULL);
   getrusage(RUSAGE_THREAD, &after);
   of->waits = after.ru_nvcsw - before.ru_nvcsw;
   contensou_simulation_state(of->simulation, of->state);
   return NULL;
}

static void release(job *of)
{
   contensou_simulation_free(of->simulation);
   free(of->state);
   free(of->values);
   free(of->matrix);
}

static double now(void)
{
   struct timespec at;
   clock_gettime(CLOCK_MONOTONIC, &at);
   return (double)at.tv_sec + 1e-9 * (double)at.tv_nsec;
}

int main(int argc, char **argv)
{
   static const char *const names[] = {"tippe_top", "ellipsoid_egg"};
   static const char *const ends[] = {"scene.t_end = 0.1", "scene.t_end = 0.1"};
   static const char *const long_ends[] = {"scene.t_end = 8", "scene.t_end = 8"};
   const char *const *settings = argc > 2 ? long_ends : ends;
   job jobs[2];
   double *states[2];
   pthread_t threads[2];
   double start, alone = 0.0, together;
   long locked;
   int i;

   if (argc < 2) return 2;
   for (i = 0; i < 2; i++) {
      jobs[i] = made(argv[1], names[i], settings[i]);
      locked = locks;
      start = now();
      run(&jobs[i]);
      alone += now() - start;
      check(jobs[i].status == CONTENSOU_OK && jobs[i].rows > 2, "a simulation alone");
      check(locks == locked, "derivatives, steps and rows do not lock");
      states[i] = jobs[i].state;
      jobs[i].state = NULL;
      release(&jobs[i]);
   }
   check(locks > 0, "reading a scene does");
   for (i = 0; i < 2; i++) jobs[i] = made(argv[1], names[i], settings[i]);
   start = now();
   for (i = 0; i < 2; i++) pthread_create(&threads[i], NULL, run, &jobs[i]);
   for (i = 0; i < 2; i++) pthread_join(threads[i], NULL);
   together = now() - start;
   for (i = 0; i < 2; i++) {
      check(jobs[i].status == CONTENSOU_OK, "a simulation beside another one");
      check(jobs[i].waits <= 5, "a thread waits for nothing");
      check(!memcmp(jobs[i].state, states[i], (size_t)jobs[i].size * sizeof(double)),
            "beside another one it has the bits that it has alone");
      free(states[i]);
      release(&jobs[i]);
   }
   if (argc > 2) printf("alone %.3f s, together %.3f s: %.3f\n", alone, together,
                        together / alone);
   printf("%d passed, %d failed\n", passed, failed);
   return failed > 0;
}
