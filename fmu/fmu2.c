/* FMI 2.0 (Functional Mock-up Interface, standard of the Modelica Association) of an FMU of a scene:
 * model exchange and co-simulation over contensou.h. Types and signatures are those of the
 * standard. */
#include "instance.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define EXPORTED __attribute__((visibility("default")))

typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
typedef const char *fmi2String;
typedef int fmi2Boolean;
typedef unsigned fmi2Reference;
typedef void (*fmi2Logger)(void *, fmi2String, fmi2Status, fmi2String, fmi2String, ...);

typedef struct {
   fmi2Logger logger;
   void *(*allocate)(size_t, size_t);
   void (*free)(void *);
   void (*finished)(void *, fmi2Status);
   void *environment;
} fmi2Callbacks;

typedef struct {
   fmi2Boolean newDiscreteStatesNeeded, terminateSimulation, nominalsOfContinuousStatesChanged,
      valuesOfContinuousStatesChanged, nextEventTimeDefined;
   double nextEventTime;
} fmi2EventInfo;

typedef struct {
   fmu_instance *own;
   fmi2Callbacks callbacks;
   char *name;
} component;

static fmi2Status status_of(int failed)
{
   return failed ? fmi2Error : fmi2OK;
}

static void to_logger(void *to, int failed, const char *message)
{
   component *self = to;
   if (self->callbacks.logger)
      self->callbacks.logger(self->callbacks.environment, self->name,
                             failed ? fmi2Error : fmi2OK, failed ? "logStatusError" : "logAll",
                             "%s", message);
}

#define SELF                                                                                       \
   component *self = contensou_handle_address(c, FMU_INSTANCE);                                    \
   if (!self) return fmi2Error

/* What the host gives, or has room for; no numbers need no room. */
#define GIVEN(place)                                                                               \
   if (!(place)) return missing(self, #place)
#define GIVEN_N(n, place)                                                                          \
   if ((n) > 0 && !(place)) return missing(self, #place)

static fmi2Status missing(component *self, const char *what)
{
   fmu_missing(self->own, what);
   return fmi2Error;
}

/* The folder of a URI "file:///...". */
static char *folder_of(const char *uri)
{
   char *folder, *to;
   const char *from = uri;

   if (!uri) return NULL;
   if (!strncmp(from, "file://", 7)) {
      from += 7;
      if (*from != '/') from = strchr(from, '/');
   } else if (!strncmp(from, "file:", 5)) {
      from += 5;
   }
   if (!from) return NULL;
   folder = to = malloc(strlen(from) + 1);
   if (!folder) return NULL;
   while (*from) {
      unsigned byte;
      if (*from == '%' && sscanf(from + 1, "%2x", &byte) == 1) {
         *to++ = (char)byte;
         from += 3;
      } else {
         *to++ = *from++;
      }
   }
   *to = 0;
   return folder;
}

EXPORTED fmi2Status fmi2SetDebugLogging(void *c, fmi2Boolean on, size_t n, const fmi2String names[])
{
   SELF;
   (void)self, (void)on, (void)n, (void)names;
   return fmi2OK;
}

EXPORTED const char *fmi2GetTypesPlatform(void)
{
   return "default";
}

EXPORTED const char *fmi2GetVersion(void)
{
   return "2.0";
}

static void release(component *self)
{
   if (!self) return;
   fmu_free(self->own);
   free(self->name);
   free(self);
}

EXPORTED void fmi2FreeInstance(void *c)
{
   component *self = contensou_handle_address(c, FMU_INSTANCE);
   contensou_handle_drop(c, FMU_INSTANCE);
   release(self);
}

EXPORTED void *fmi2Instantiate(fmi2String name, int type, fmi2String token, fmi2String resources,
                               const fmi2Callbacks *callbacks, fmi2Boolean visible,
                               fmi2Boolean logging)
{
   component *self = calloc(1, sizeof *self);
   char *folder = folder_of(resources);
   void *handle;
   (void)token, (void)visible, (void)logging;

   if (self && callbacks) self->callbacks = *callbacks;
   if (self) {
      self->name = malloc(strlen(name ? name : "") + 1);
      if (self->name) strcpy(self->name, name ? name : "");
      if (self->name && !folder)
         to_logger(self, 1, "the place of the resources is no URI such as file:///folder");
      if (self->name && folder) self->own = fmu_new(folder, type == 0, to_logger, self);
   }
   free(folder);
   handle = self && self->own ? contensou_handle_new(self, FMU_INSTANCE) : NULL;
   if (!handle) release(self);
   return handle;
}

EXPORTED fmi2Status fmi2SetupExperiment(void *c, fmi2Boolean has_tolerance, double tolerance,
                                        double start, fmi2Boolean has_stop, double stop)
{
   SELF;
   (void)has_tolerance, (void)tolerance, (void)has_stop, (void)stop;
   if (start == 0.0) return fmi2OK;
   to_logger(self, 1, "a scene begins at the time 0");
   return fmi2Error;
}

EXPORTED fmi2Status fmi2EnterInitializationMode(void *c)
{
   SELF;
   (void)self;
   return fmi2OK;
}

EXPORTED fmi2Status fmi2ExitInitializationMode(void *c)
{
   SELF;
   return status_of(fmu_begin(self->own));
}

EXPORTED fmi2Status fmi2Terminate(void *c)
{
   SELF;
   (void)self;
   return fmi2OK;
}

EXPORTED fmi2Status fmi2Reset(void *c)
{
   SELF;
   return status_of(fmu_reset(self->own));
}

EXPORTED fmi2Status fmi2GetReal(void *c, const fmi2Reference references[], size_t n,
                                double values[])
{
   size_t i;
   int failed = 0;
   SELF;
   GIVEN_N(n, references);
   GIVEN_N(n, values);
   for (i = 0; i < n && !failed; i++) failed = fmu_get(self->own, references[i], &values[i]);
   return status_of(failed);
}

EXPORTED fmi2Status fmi2SetReal(void *c, const fmi2Reference references[], size_t n,
                                const double values[])
{
   size_t i;
   int failed = 0;
   SELF;
   GIVEN_N(n, references);
   GIVEN_N(n, values);
   for (i = 0; i < n && !failed; i++) failed = fmu_set(self->own, references[i], values[i]);
   return status_of(failed);
}

/* There are real variables only. */
#define NONE_OF(type, kind)                                                                        \
   EXPORTED fmi2Status fmi2Get##kind(void *c, const fmi2Reference references[], size_t n,          \
                                     type values[])                                                \
   {                                                                                               \
      SELF;                                                                                        \
      (void)self, (void)references, (void)values;                                                  \
      return status_of(n > 0);                                                                     \
   }                                                                                               \
   EXPORTED fmi2Status fmi2Set##kind(void *c, const fmi2Reference references[], size_t n,          \
                                     const type values[])                                          \
   {                                                                                               \
      SELF;                                                                                        \
      (void)self, (void)references, (void)values;                                                  \
      return status_of(n > 0);                                                                     \
   }

NONE_OF(int, Integer)
NONE_OF(fmi2Boolean, Boolean)
NONE_OF(fmi2String, String)

EXPORTED fmi2Status fmi2GetFMUstate(void *c, void **state)
{
   SELF;
   GIVEN(state);
   return status_of(fmu_keep(self->own, state));
}

EXPORTED fmi2Status fmi2SetFMUstate(void *c, void *state)
{
   SELF;
   GIVEN(state);
   return status_of(fmu_go_back(self->own, state));
}

EXPORTED fmi2Status fmi2FreeFMUstate(void *c, void **state)
{
   SELF;
   (void)self;
   if (!state) return fmi2OK;
   fmu_forget(state);
   return fmi2OK;
}

EXPORTED fmi2Status fmi2SerializedFMUstateSize(void *c, void *state, size_t *size)
{
   SELF;
   GIVEN(state);
   GIVEN(size);
   return status_of(fmu_place_size(self->own, state, size));
}

EXPORTED fmi2Status fmi2SerializeFMUstate(void *c, void *state, char bytes[], size_t size)
{
   SELF;
   GIVEN(state);
   GIVEN(bytes);
   return status_of(fmu_write_place(self->own, state, bytes, size));
}

EXPORTED fmi2Status fmi2DeSerializeFMUstate(void *c, const char bytes[], size_t size, void **state)
{
   SELF;
   GIVEN(bytes);
   GIVEN(state);
   return status_of(fmu_read_place(self->own, bytes, size, state));
}

EXPORTED fmi2Status fmi2GetDirectionalDerivative(void *c, const fmi2Reference unknown[],
                                                 size_t n_unknown, const fmi2Reference known[],
                                                 size_t n_known, const double seed[],
                                                 double product[])
{
   (void)c, (void)unknown, (void)n_unknown, (void)known, (void)n_known, (void)seed, (void)product;
   return fmi2Error;
}

/* ---- Model exchange -------------------------------------------------------------------------- */

EXPORTED fmi2Status fmi2EnterEventMode(void *c)
{
   SELF;
   (void)self;
   return fmi2OK;
}

EXPORTED fmi2Status fmi2NewDiscreteStates(void *c, fmi2EventInfo *info)
{
   double next = INFINITY;
   int changed = 0, failed;
   SELF;
   GIVEN(info);
   failed = fmu_update(self->own, &changed, &next);
   memset(info, 0, sizeof *info);
   info->valuesOfContinuousStatesChanged = changed;
   info->nextEventTimeDefined = isfinite(next);
   info->nextEventTime = isfinite(next) ? next : 0.0;
   return status_of(failed);
}

EXPORTED fmi2Status fmi2EnterContinuousTimeMode(void *c)
{
   SELF;
   (void)self;
   return fmi2OK;
}

EXPORTED fmi2Status fmi2CompletedIntegratorStep(void *c, fmi2Boolean no_going_back,
                                                fmi2Boolean *event_mode, fmi2Boolean *terminate)
{
   int events, failed;
   SELF;
   (void)no_going_back;
   failed = fmu_complete(self->own, &events);
   if (event_mode) *event_mode = events;
   if (terminate) *terminate = 0;
   return status_of(failed);
}

EXPORTED fmi2Status fmi2SetTime(void *c, double time)
{
   SELF;
   return status_of(fmu_set_time(self->own, time));
}

EXPORTED fmi2Status fmi2SetContinuousStates(void *c, const double state[], size_t n)
{
   SELF;
   GIVEN_N(n, state);
   return status_of(fmu_set_state(self->own, state, n));
}

EXPORTED fmi2Status fmi2GetDerivatives(void *c, double rates[], size_t n)
{
   SELF;
   GIVEN_N(n, rates);
   return status_of(fmu_rates(self->own, rates, n));
}

EXPORTED fmi2Status fmi2GetEventIndicators(void *c, double values[], size_t n)
{
   SELF;
   GIVEN_N(n, values);
   return status_of(fmu_indicators(self->own, values, n));
}

EXPORTED fmi2Status fmi2GetContinuousStates(void *c, double state[], size_t n)
{
   SELF;
   GIVEN_N(n, state);
   return status_of(fmu_get_state(self->own, state, n));
}

EXPORTED fmi2Status fmi2GetNominalsOfContinuousStates(void *c, double nominals[], size_t n)
{
   SELF;
   GIVEN_N(n, nominals);
   return status_of(fmu_nominals(self->own, nominals, n));
}

/* ---- Co-simulation --------------------------------------------------------------------------- */

EXPORTED fmi2Status fmi2SetRealInputDerivatives(void *c, const fmi2Reference references[], size_t n,
                                                const int orders[], const double values[])
{
   (void)c, (void)references, (void)n, (void)orders, (void)values;
   return fmi2Error;
}

EXPORTED fmi2Status fmi2GetRealOutputDerivatives(void *c, const fmi2Reference references[],
                                                 size_t n, const int orders[], double values[])
{
   (void)c, (void)references, (void)n, (void)orders, (void)values;
   return fmi2Error;
}

EXPORTED fmi2Status fmi2DoStep(void *c, double now, double step, fmi2Boolean no_going_back)
{
   double reached;
   int event;
   SELF;
   (void)no_going_back;
   if (fmu_step(self->own, now + step, 0, &reached, &event)) return fmi2Error;
   return event ? fmi2Discard : fmi2OK;
}

EXPORTED fmi2Status fmi2CancelStep(void *c)
{
   (void)c;
   return fmi2Error;
}

EXPORTED fmi2Status fmi2GetStatus(void *c, int kind, fmi2Status *value)
{
   SELF;
   (void)kind;
   GIVEN(value);
   *value = fmi2OK;
   return fmi2OK;
}

EXPORTED fmi2Status fmi2GetRealStatus(void *c, int kind, double *value)
{
   SELF;
   (void)kind;
   GIVEN(value);
   *value = self->own->time;
   return fmi2OK;
}

EXPORTED fmi2Status fmi2GetIntegerStatus(void *c, int kind, int *value)
{
   SELF;
   (void)kind;
   GIVEN(value);
   return fmi2Discard;
}

EXPORTED fmi2Status fmi2GetBooleanStatus(void *c, int kind, fmi2Boolean *value)
{
   SELF;
   (void)kind;
   GIVEN(value);
   *value = contensou_simulation_stop(self->own->simulation) > 0;
   return fmi2OK;
}

EXPORTED fmi2Status fmi2GetStringStatus(void *c, int kind, fmi2String *value)
{
   SELF;
   (void)kind;
   GIVEN(value);
   *value = "";
   return fmi2Discard;
}
