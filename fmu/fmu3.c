/* FMI 3.0 (Functional Mock-up Interface, standard of the Modelica Association) of an FMU of a scene:
 * model exchange and co-simulation over contensou.h. Types and signatures are those of the
 * standard. */
#include "instance.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define EXPORTED __attribute__((visibility("default")))

typedef enum { fmi3OK, fmi3Warning, fmi3Discard, fmi3Error, fmi3Fatal } fmi3Status;
typedef uint32_t fmi3Reference;
typedef void (*fmi3Logger)(void *, fmi3Status, const char *, const char *);

typedef struct {
   fmu_instance *own;
   fmi3Logger logger;
   void *environment;
   bool returns_early, event_mode;
} component;

static fmi3Status status_of(int failed)
{
   return failed ? fmi3Error : fmi3OK;
}

static void to_logger(void *to, int failed, const char *message)
{
   component *self = to;
   if (self->logger)
      self->logger(self->environment, failed ? fmi3Error : fmi3OK,
                   failed ? "logStatusError" : "logAll", message);
}

#define SELF                                                                                       \
   component *self = contensou_handle_address(c, FMU_INSTANCE);                                    \
   if (!self) return fmi3Error

/* What the host gives, or has room for; no numbers need no room. */
#define GIVEN(place)                                                                               \
   if (!(place)) return missing(self, #place)
#define GIVEN_N(n, place)                                                                          \
   if ((n) > 0 && !(place)) return missing(self, #place)

static fmi3Status missing(component *self, const char *what)
{
   fmu_missing(self->own, what);
   return fmi3Error;
}

EXPORTED const char *fmi3GetVersion(void)
{
   return "3.0";
}

EXPORTED fmi3Status fmi3SetDebugLogging(void *c, bool on, size_t n, const char *const names[])
{
   SELF;
   (void)self, (void)on, (void)n, (void)names;
   return fmi3OK;
}

static void *release(component *self)
{
   if (self) fmu_free(self->own);
   free(self);
   return NULL;
}

EXPORTED void fmi3FreeInstance(void *c)
{
   component *self = contensou_handle_address(c, FMU_INSTANCE);
   contensou_handle_drop(c, FMU_INSTANCE);
   release(self);
}

/* An instance; returns its handle. */
static void *instantiate(component how, const char *resources, int exchange)
{
   component *self = malloc(sizeof *self);
   void *handle;
   if (!self) return NULL;
   *self = how;
   if (!resources)
      to_logger(self, 1, "the path of the resources is NULL");
   else
      self->own = fmu_new(resources, exchange, to_logger, self);
   handle = self->own ? contensou_handle_new(self, FMU_INSTANCE) : NULL;
   return handle ? handle : release(self);
}

EXPORTED void *fmi3InstantiateModelExchange(const char *name, const char *token,
                                            const char *resources, bool visible, bool logging,
                                            void *environment, fmi3Logger logger)
{
   (void)name, (void)token, (void)visible, (void)logging;
   return instantiate((component){.environment = environment, .logger = logger}, resources, 1);
}

EXPORTED void *fmi3InstantiateCoSimulation(const char *name, const char *token,
                                           const char *resources, bool visible, bool logging,
                                           bool event_mode, bool returns_early,
                                           const fmi3Reference required[], size_t n,
                                           void *environment, fmi3Logger logger,
                                           void *intermediate)
{
   component how = {.environment = environment, .logger = logger, .event_mode = event_mode,
                    .returns_early = returns_early};
   (void)name, (void)token, (void)visible, (void)logging, (void)required, (void)n;
   (void)intermediate;
   return instantiate(how, resources, 0);
}

EXPORTED void *fmi3InstantiateScheduledExecution(const char *name, const char *token,
                                                 const char *resources, bool visible, bool logging,
                                                 void *environment, fmi3Logger logger, void *clock,
                                                 void *lock, void *unlock)
{
   (void)name, (void)token, (void)resources, (void)visible, (void)logging, (void)environment;
   (void)logger, (void)clock, (void)lock, (void)unlock;
   return NULL;
}

EXPORTED fmi3Status fmi3EnterInitializationMode(void *c, bool has_tolerance, double tolerance,
                                                double start, bool has_stop, double stop)
{
   SELF;
   (void)has_tolerance, (void)tolerance, (void)has_stop, (void)stop;
   if (start == 0.0) return fmi3OK;
   to_logger(self, 1, "a scene begins at the time 0");
   return fmi3Error;
}

EXPORTED fmi3Status fmi3ExitInitializationMode(void *c)
{
   SELF;
   return status_of(fmu_begin(self->own));
}

#define NOTHING(name)                                                                              \
   EXPORTED fmi3Status name(void *c)                                                               \
   {                                                                                               \
      SELF;                                                                                        \
      (void)self;                                                                                  \
      return fmi3OK;                                                                               \
   }

NOTHING(fmi3EnterEventMode)
NOTHING(fmi3Terminate)
NOTHING(fmi3EnterConfigurationMode)
NOTHING(fmi3ExitConfigurationMode)
NOTHING(fmi3EvaluateDiscreteStates)
NOTHING(fmi3EnterContinuousTimeMode)
NOTHING(fmi3EnterStepMode)

EXPORTED fmi3Status fmi3Reset(void *c)
{
   SELF;
   return status_of(fmu_reset(self->own));
}

EXPORTED fmi3Status fmi3GetFloat64(void *c, const fmi3Reference references[], size_t n,
                                   double values[], size_t n_values)
{
   size_t i;
   int failed = n != n_values;
   SELF;
   GIVEN_N(n, references);
   GIVEN_N(n, values);
   for (i = 0; i < n && !failed; i++) failed = fmu_get(self->own, references[i], &values[i]);
   return status_of(failed);
}

EXPORTED fmi3Status fmi3SetFloat64(void *c, const fmi3Reference references[], size_t n,
                                   const double values[], size_t n_values)
{
   size_t i;
   int failed = n != n_values;
   SELF;
   GIVEN_N(n, references);
   GIVEN_N(n, values);
   for (i = 0; i < n && !failed; i++) failed = fmu_set(self->own, references[i], values[i]);
   return status_of(failed);
}

/* There are variables of 64-bit reals only. */
#define NONE_OF(type, kind)                                                                        \
   EXPORTED fmi3Status fmi3Get##kind(void *c, const fmi3Reference references[], size_t n,          \
                                     type values[], size_t n_values)                               \
   {                                                                                               \
      SELF;                                                                                        \
      (void)self, (void)references, (void)values, (void)n_values;                                  \
      return status_of(n > 0);                                                                     \
   }                                                                                               \
   EXPORTED fmi3Status fmi3Set##kind(void *c, const fmi3Reference references[], size_t n,          \
                                     const type values[], size_t n_values)                         \
   {                                                                                               \
      SELF;                                                                                        \
      (void)self, (void)references, (void)values, (void)n_values;                                  \
      return status_of(n > 0);                                                                     \
   }

typedef const char *text;
NONE_OF(float, Float32)
NONE_OF(int8_t, Int8)
NONE_OF(uint8_t, UInt8)
NONE_OF(int16_t, Int16)
NONE_OF(uint16_t, UInt16)
NONE_OF(int32_t, Int32)
NONE_OF(uint32_t, UInt32)
NONE_OF(int64_t, Int64)
NONE_OF(uint64_t, UInt64)
NONE_OF(bool, Boolean)
NONE_OF(text, String)

/* What the description says that there is none of. */
#define REFUSED(name, ...)                                                                         \
   EXPORTED fmi3Status name(__VA_ARGS__)                                                           \
   {                                                                                               \
      return fmi3Error;                                                                            \
   }
#pragma GCC diagnostic ignored "-Wunused-parameter"

typedef const uint8_t *binary;
REFUSED(fmi3GetBinary, void *c, const fmi3Reference r[], size_t n, size_t sizes[], binary v[],
        size_t m)
REFUSED(fmi3SetBinary, void *c, const fmi3Reference r[], size_t n, const size_t sizes[],
        const binary v[], size_t m)
REFUSED(fmi3GetClock, void *c, const fmi3Reference r[], size_t n, bool v[])
REFUSED(fmi3SetClock, void *c, const fmi3Reference r[], size_t n, const bool v[])
REFUSED(fmi3GetNumberOfVariableDependencies, void *c, fmi3Reference r, size_t *n)
REFUSED(fmi3GetVariableDependencies, void *c, fmi3Reference r, size_t elements[],
        fmi3Reference independents[], size_t other[], int kinds[], size_t n)
REFUSED(fmi3GetDirectionalDerivative, void *c, const fmi3Reference u[], size_t nu,
        const fmi3Reference k[], size_t nk, const double seed[], size_t ns, double product[],
        size_t np)
REFUSED(fmi3GetAdjointDerivative, void *c, const fmi3Reference u[], size_t nu,
        const fmi3Reference k[], size_t nk, const double seed[], size_t ns, double product[],
        size_t np)
REFUSED(fmi3GetIntervalDecimal, void *c, const fmi3Reference r[], size_t n, double v[], int q[])
REFUSED(fmi3GetIntervalFraction, void *c, const fmi3Reference r[], size_t n, uint64_t counters[],
        uint64_t resolutions[], int q[])
REFUSED(fmi3GetShiftDecimal, void *c, const fmi3Reference r[], size_t n, double v[])
REFUSED(fmi3GetShiftFraction, void *c, const fmi3Reference r[], size_t n, uint64_t counters[],
        uint64_t resolutions[])
REFUSED(fmi3SetIntervalDecimal, void *c, const fmi3Reference r[], size_t n, const double v[])
REFUSED(fmi3SetIntervalFraction, void *c, const fmi3Reference r[], size_t n,
        const uint64_t counters[], const uint64_t resolutions[])
REFUSED(fmi3SetShiftDecimal, void *c, const fmi3Reference r[], size_t n, const double v[])
REFUSED(fmi3SetShiftFraction, void *c, const fmi3Reference r[], size_t n,
        const uint64_t counters[], const uint64_t resolutions[])
REFUSED(fmi3GetOutputDerivatives, void *c, const fmi3Reference r[], size_t n, const int32_t o[],
        double v[], size_t m)
REFUSED(fmi3ActivateModelPartition, void *c, fmi3Reference clock, double time)

EXPORTED fmi3Status fmi3GetFMUState(void *c, void **state)
{
   SELF;
   GIVEN(state);
   return status_of(fmu_keep(self->own, state));
}

EXPORTED fmi3Status fmi3SetFMUState(void *c, void *state)
{
   SELF;
   GIVEN(state);
   return status_of(fmu_go_back(self->own, state));
}

EXPORTED fmi3Status fmi3FreeFMUState(void *c, void **state)
{
   SELF;
   (void)self;
   if (!state) return fmi3OK;
   fmu_forget(state);
   return fmi3OK;
}

EXPORTED fmi3Status fmi3SerializedFMUStateSize(void *c, void *state, size_t *size)
{
   SELF;
   GIVEN(state);
   GIVEN(size);
   return status_of(fmu_place_size(self->own, state, size));
}

EXPORTED fmi3Status fmi3SerializeFMUState(void *c, void *state, uint8_t bytes[], size_t size)
{
   SELF;
   GIVEN(state);
   GIVEN(bytes);
   return status_of(fmu_write_place(self->own, state, (char *)bytes, size));
}

EXPORTED fmi3Status fmi3DeserializeFMUState(void *c, const uint8_t bytes[], size_t size,
                                            void **state)
{
   SELF;
   GIVEN(bytes);
   GIVEN(state);
   return status_of(fmu_read_place(self->own, (const char *)bytes, size, state));
}

EXPORTED fmi3Status fmi3UpdateDiscreteStates(void *c, bool *more, bool *terminate, bool *nominals,
                                             bool *values, bool *has_next, double *next)
{
   double time = INFINITY;
   int changed = 0, failed = 0;
   SELF;
   /* In co-simulation the method has taken the events of its step. */
   if (self->own->exchange) failed = fmu_update(self->own, &changed, &time);
   if (more) *more = false;
   if (terminate) *terminate = contensou_simulation_stop(self->own->simulation) > 0;
   if (nominals) *nominals = false;
   if (values) *values = changed;
   if (has_next) *has_next = isfinite(time);
   if (next) *next = isfinite(time) ? time : 0.0;
   return status_of(failed);
}

EXPORTED fmi3Status fmi3CompletedIntegratorStep(void *c, bool no_going_back, bool *event_mode,
                                                bool *terminate)
{
   int events, failed;
   SELF;
   (void)no_going_back;
   failed = fmu_complete(self->own, &events);
   if (event_mode) *event_mode = events;
   if (terminate) *terminate = false;
   return status_of(failed);
}

EXPORTED fmi3Status fmi3SetTime(void *c, double time)
{
   SELF;
   return status_of(fmu_set_time(self->own, time));
}

EXPORTED fmi3Status fmi3SetContinuousStates(void *c, const double state[], size_t n)
{
   SELF;
   GIVEN_N(n, state);
   return status_of(fmu_set_state(self->own, state, n));
}

EXPORTED fmi3Status fmi3GetContinuousStateDerivatives(void *c, double rates[], size_t n)
{
   SELF;
   GIVEN_N(n, rates);
   return status_of(fmu_rates(self->own, rates, n));
}

EXPORTED fmi3Status fmi3GetEventIndicators(void *c, double values[], size_t n)
{
   SELF;
   GIVEN_N(n, values);
   return status_of(fmu_indicators(self->own, values, n));
}

EXPORTED fmi3Status fmi3GetContinuousStates(void *c, double state[], size_t n)
{
   SELF;
   GIVEN_N(n, state);
   return status_of(fmu_get_state(self->own, state, n));
}

EXPORTED fmi3Status fmi3GetNominalsOfContinuousStates(void *c, double nominals[], size_t n)
{
   SELF;
   GIVEN_N(n, nominals);
   return status_of(fmu_nominals(self->own, nominals, n));
}

EXPORTED fmi3Status fmi3GetNumberOfEventIndicators(void *c, size_t *n)
{
   SELF;
   GIVEN(n);
   *n = (size_t)(self->own->contacts + self->own->remembers);
   return fmi3OK;
}

EXPORTED fmi3Status fmi3GetNumberOfContinuousStates(void *c, size_t *n)
{
   SELF;
   GIVEN(n);
   *n = (size_t)self->own->variables.count[FMU_STATE];
   return fmi3OK;
}

EXPORTED fmi3Status fmi3DoStep(void *c, double now, double step, bool no_going_back,
                               bool *event_needed, bool *terminate, bool *early, double *last)
{
   double reached;
   int event;
   bool stopped;
   SELF;
   (void)no_going_back;
   if (fmu_step(self->own, now + step, self->returns_early, &reached, &event)) return fmi3Error;
   stopped = contensou_simulation_stop(self->own->simulation) > 0;
   if (last) *last = reached;
   if (terminate) *terminate = stopped;
   if (early) *early = event;
   if (event_needed) *event_needed = event && self->event_mode && !stopped;
   return fmi3OK;
}
