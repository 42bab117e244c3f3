/* Instances of an FMU, made and released many times, two at once, states kept and set again.
 *
 *   fmu_instances RESOURCES COUNT    prints "COUNT instances, resident memory grew by N KiB" */
#include "../../fmu/instance.h"
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void *fmi3InstantiateModelExchange(const char *, const char *, const char *, bool, bool, void *,
                                   void *);
void *fmi3InstantiateCoSimulation(const char *, const char *, const char *, bool, bool, bool, bool,
                                  const uint32_t *, size_t, void *, void *, void *);
int fmi3EnterInitializationMode(void *, bool, double, double, bool, double);
int fmi3ExitInitializationMode(void *);
int fmi3DoStep(void *, double, double, bool, bool *, bool *, bool *, double *);
int fmi3UpdateDiscreteStates(void *, bool *, bool *, bool *, bool *, bool *, double *);
int fmi3GetNumberOfContinuousStates(void *, size_t *);
int fmi3GetContinuousStates(void *, double *, size_t);
int fmi3GetContinuousStateDerivatives(void *, double *, size_t);
int fmi3GetFloat64(void *, const uint32_t *, size_t, double *, size_t);
int fmi3GetFMUState(void *, void **);
int fmi3SetFMUState(void *, void *);
int fmi3FreeFMUState(void *, void **);
void fmi3FreeInstance(void *);

static void need(int condition, const char *what)
{
   if (condition) return;
   printf("failed: %s\n", what);
   exit(1);
}

/* Resident memory of this process [KiB]. */
static long resident(void)
{
   long pages = 0;
   FILE *file = fopen("/proc/self/statm", "r");
   need(file && fscanf(file, "%*d %ld", &pages) == 1, "statm");
   fclose(file);
   return pages * 4;
}

static void *begun(const char *resources, int exchange)
{
   void *one = exchange ? fmi3InstantiateModelExchange("one", "", resources, false, false, NULL,
                                                       NULL)
                        : fmi3InstantiateCoSimulation("one", "", resources, false, false, false,
                                                      false, NULL, 0, NULL, NULL, NULL);
   need(one != NULL, "an instance");
   need(!fmi3EnterInitializationMode(one, false, 0.0, 0.0, false, 0.0) &&
           !fmi3ExitInitializationMode(one), "initialization");
   return one;
}

/* A step, a state that is kept, another step, and that again from the state. */
static void step_twice(void *one)
{
   const uint32_t time = 0;
   bool needed, terminate, early;
   double last, first, second;
   void *state = NULL;

   need(!fmi3DoStep(one, 0.0, 1e-4, false, &needed, &terminate, &early, &last), "a step");
   need(!fmi3GetFMUState(one, &state), "a state");
   need(!fmi3DoStep(one, 1e-4, 1e-4, false, &needed, &terminate, &early, &last), "a second step");
   need(!fmi3GetFloat64(one, &time, 1, &first, 1), "a value");
   need(!fmi3SetFMUState(one, state), "going back");
   need(!fmi3DoStep(one, 1e-4, 1e-4, false, &needed, &terminate, &early, &last), "again");
   need(!fmi3GetFloat64(one, &time, 1, &second, 1) && first == second, "the same");
   need(!fmi3FreeFMUState(one, &state) && !state, "release of a state");
}

static void look_at_rates(void *one)
{
   bool more, terminate, nominals, values, has_next;
   double next, state[256], rates[256];
   size_t n;

   need(!fmi3UpdateDiscreteStates(one, &more, &terminate, &nominals, &values, &has_next, &next),
        "events");
   need(!fmi3GetNumberOfContinuousStates(one, &n) && n <= 256, "the number of states");
   need(!fmi3GetContinuousStates(one, state, n), "states");
   need(!fmi3GetContinuousStateDerivatives(one, rates, n), "rates");
}

int main(int argc, char **argv)
{
   long before = 0;
   int i, count;

   if (argc != 3) return 2;
   count = atoi(argv[2]);
   for (i = 0; i < count; i += 2) {
      void *one = begun(argv[1], 0), *two = begun(argv[1], 1);
      step_twice(one);
      look_at_rates(two);
      fmi3FreeInstance(one);
      fmi3FreeInstance(two);
      if (i < count / 4) before = resident();
   }
   printf("%d instances, resident memory grew by %ld KiB\n", count, resident() - before);
   return 0;
}
