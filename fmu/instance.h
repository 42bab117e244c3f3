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
   double next;     /* time event that the host was told of; infinite for none */
   double *state;   /* of the host */
   int states, contacts;
   int remembers;   /* the last event indicator is that of memory */
   int fresh;       /* the host has put another time or state than the simulation has */
   double *inputs;  /* as they should be */
   double *parameters;
   int *changed;    /* parameters that were set */
   double *values;  /* room for a quantity, rates or indicators of the whole scene */
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
   int count[3]; /* states, inputs and parameters */
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
int fmu_set_time(fmu_instance *self, double time);
int fmu_set_state(fmu_instance *self, const double *state, size_t n);
int fmu_get_state(fmu_instance *self, double *state, size_t n);
int fmu_nominals(fmu_instance *self, double *nominals, size_t n);
int fmu_rates(fmu_instance *self, double *rates, size_t n);
int fmu_indicators(fmu_instance *self, double *values, size_t n);
int fmu_complete(fmu_instance *self, int *events);
int fmu_update(fmu_instance *self, int *changed, double *next);

/* Hosts hold handles of instances and places, of which one that was released is none any more; see
 * handle_table.c. */
enum { FMU_INSTANCE = 101, FMU_PLACE };
void *contensou_handle_new(void *address, int kind);
void *contensou_handle_address(void *handle, int kind);
void contensou_handle_drop(void *handle, int kind);

/* Keep the place where an instance is, instead of one that was kept there before; go back to a
 * place; release it. */
int fmu_keep(fmu_instance *self, void **handle);
int fmu_go_back(fmu_instance *self, void *handle);
void fmu_forget(void **handle);

/* A place as bytes: their number, writing and reading them. */
int fmu_place_size(fmu_instance *self, void *handle, size_t *size);
int fmu_write_place(fmu_instance *self, void *handle, char *bytes, size_t size);
int fmu_read_place(fmu_instance *self, const char *bytes, size_t size, void **handle);

/* Tell the host something, or of an error, which is released. */
void fmu_say(fmu_instance *self, int failed, const char *message);
int fmu_told(fmu_instance *self, int status, contensou_error *error);

/* Tell of a mistake, or of an argument that is NULL; 1. */
int fmu_refuse(fmu_instance *self, const char *why);
int fmu_missing(fmu_instance *self, const char *what);

#endif
