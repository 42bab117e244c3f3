/* An instance of an FMU of a scene or of a contact alone, whichever version of FMI asks. */
#ifndef CONTENSOU_FMU_INSTANCE_H
#define CONTENSOU_FMU_INSTANCE_H

#include "variables.h"

typedef void fmu_log(void *to, int failed, const char *message);

typedef struct {
   contensou_simulation *simulation;
   fmu_variables variables;
   int exchange;    /* model exchange, not co-simulation */
   int contact;     /* number of the contact that it is of; -1 for the whole scene */
   int begun;       /* parameters are taken, the simulation is at its beginning */
   double time;     /* of the host, or that asked for last */
   double *state;   /* of the host */
   int states, contacts;
   int fresh;       /* the host has put another time or state than the simulation has */
   double *inputs;  /* as they should be */
   double *parameters;
   int *changed;    /* parameters that were set */
   double *values;  /* room for a quantity */
   double *poses;   /* of a contact alone: the state of its scene, with the inputs */
   double wrenches[2][6]; /* of a contact alone: on A and B */
   int known;       /* the wrenches are those of the inputs */
   int shape[4];    /* how many bodies, contacts, states and numbers of quantities there are */
   fmu_log *log;
   void *log_to;
} fmu_instance;

/* Where an instance is. */
typedef struct {
   contensou_snapshot *snapshot;
   int begun, fresh;
   double time, *state, *inputs, *parameters;
   int *changed;
} fmu_place;

fmu_instance *fmu_new(const char *resources, int exchange, fmu_log *log, void *log_to);
void fmu_free(fmu_instance *self);
int fmu_reset(fmu_instance *self);
int fmu_begin(fmu_instance *self);
int fmu_get(fmu_instance *self, unsigned reference, double *value);
int fmu_set(fmu_instance *self, unsigned reference, double value);
int fmu_step(fmu_instance *self, double time, int to_event, double *reached, int *event);
int fmu_set_state(fmu_instance *self, const double *state, size_t n);
int fmu_rates(fmu_instance *self, double *rates, size_t n);
int fmu_indicators(fmu_instance *self, double *values, size_t n);
int fmu_complete(fmu_instance *self);
int fmu_update(fmu_instance *self, int *changed, double *next);
int fmu_keep(fmu_instance *self, fmu_place **place);
int fmu_go_back(fmu_instance *self, const fmu_place *place);
void fmu_forget(fmu_place *place);

/* A place as bytes: their number, writing and reading them. */
int fmu_place_size(const fmu_instance *self, const fmu_place *place, size_t *size);
int fmu_write_place(const fmu_instance *self, const fmu_place *place, char *bytes, size_t size);
int fmu_read_place(fmu_instance *self, const char *bytes, size_t size, fmu_place **place);

/* Tell the host something, or of an error, which is released. */
void fmu_say(fmu_instance *self, int failed, const char *message);
int fmu_told(fmu_instance *self, int status, contensou_error *error);

#endif
