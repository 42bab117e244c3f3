#include "instance.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The text of a file, ended by a zero byte; NULL if it cannot be read. */
static char *read_text(const char *folder, const char *name)
{
   size_t n = strlen(folder) + strlen(name) + 2, size = 0, room = 4096;
   char *path = malloc(n), *text = malloc(room);
   FILE *file = NULL;

   if (path) {
      snprintf(path, n, "%s/%s", folder, name);
      file = fopen(path, "rb");
   }
   free(path);
   if (!file || !text) {
      if (file) fclose(file);
      free(text);
      return NULL;
   }
   for (;;) {
      size += fread(text + size, 1, room - size - 1, file);
      if (size < room - 1) break;
      room *= 2;
      path = realloc(text, room);
      if (!path) {
         free(text);
         fclose(file);
         return NULL;
      }
      text = path;
   }
   fclose(file);
   text[size] = 0;
   return text;
}

void fmu_say(fmu_instance *self, int failed, const char *message)
{
   if (self->log) self->log(self->log_to, failed, message);
}

/* Tell of an error and release it. */
int fmu_told(fmu_instance *self, int status, contensou_error *error)
{
   if (status) fmu_say(self, 1, contensou_error_message(error));
   contensou_error_free(error);
   return status;
}

int fmu_refuse(fmu_instance *self, const char *why)
{
   fmu_say(self, 1, why);
   return 1;
}

int fmu_missing(fmu_instance *self, const char *what)
{
   char message[80];
   snprintf(message, sizeof message, "the argument '%s' is NULL", what);
   return fmu_refuse(self, message);
}

/* Whether the host has room for as many numbers as there are. */
static int wrong_count(fmu_instance *self, const char *what, size_t n, int wanted)
{
   char message[100];
   if (n == (size_t)wanted) return 0;
   snprintf(message, sizeof message, "%zu %s, of which there are %d", n, what, wanted);
   return fmu_refuse(self, message);
}

static int no_variable(fmu_instance *self, unsigned reference)
{
   char message[80];
   snprintf(message, sizeof message, "there is no variable of the value reference %u", reference);
   return fmu_refuse(self, message);
}

static void read_state(fmu_instance *self)
{
   self->known = 0;
   if (self->contact >= 0) return;
   self->states = contensou_simulation_size(self->simulation);
   self->time = contensou_simulation_time(self->simulation);
   contensou_simulation_state(self->simulation, self->state);
   self->fresh = 0;
}

/* How many bodies, contacts, states and numbers of quantities there are. Returns the largest number
 * that one call gives. */
static int shape_of(contensou_simulation *simulation, int shape[4])
{
   int most;
   contensou_quantity quantity;
   int i;

   shape[0] = contensou_simulation_bodies(simulation);
   shape[1] = contensou_simulation_contacts(simulation);
   shape[2] = contensou_simulation_size(simulation);
   shape[3] = 0;
   most = shape[1] > shape[2] ? shape[1] : shape[2];
   for (i = 0; contensou_simulation_quantity(simulation, i, &quantity) == CONTENSOU_OK; i++) {
      shape[3] += quantity.size;
      if (quantity.size > most) most = quantity.size;
   }
   return most;
}

/* Values at the beginning. */
static void start(fmu_instance *self)
{
   const fmu_variables *list = &self->variables;
   int i;
   for (i = 0; i < list->count[FMU_PARAMETER]; i++) {
      self->parameters[i] = list->items[list->first[FMU_PARAMETER] + i].start;
      self->changed[i] = 0;
   }
   for (i = 0; i < list->count[FMU_INPUT]; i++)
      self->inputs[i] = list->items[list->first[FMU_INPUT] + i].start;
   self->begun = 0;
   self->next = INFINITY;
   self->time = 0.0;
   read_state(self);
}

fmu_instance *fmu_new(const char *resources, int exchange, fmu_log *log, void *log_to)
{
   fmu_instance *self = calloc(1, sizeof *self);
   char *scene = read_text(resources, "scene.nml");
   char *settings = read_text(resources, "settings.txt");
   char *contact = read_text(resources, "contact.txt");
   const char *list[1024];
   contensou_error *error = NULL;
   char *line;
   int n = 0;

   if (!self) goto failed;
   self->log = log;
   self->log_to = log_to;
   self->exchange = exchange;
   if (!scene) {
      fmu_say(self, 1, "the resource scene.nml cannot be read");
      goto failed;
   }
   for (line = settings; line && *line && n < 1024;) {
      char *end = strchr(line, '\n');
      if (end) *end = 0;
      if (*line) list[n++] = line;
      line = end ? end + 1 : NULL;
   }
   self->simulation = contensou_simulation_from_text("scene.nml", scene, list, n, &error);
   if (fmu_told(self, self->simulation == NULL, error)) goto failed;
   self->contact = contact ? fmu_contact_of(self->simulation, contact) : -1;
   if (contact && self->contact < 0) {
      fmu_say(self, 1, "the scene has no contact of the name in contact.txt");
      goto failed;
   }
   if (fmu_list(self->simulation, self->contact, &self->variables)) goto failed;
   self->contacts = self->contact < 0 ? contensou_simulation_contacts(self->simulation) : 1;
   self->remembers = self->contact < 0 && contensou_simulation_remembers(self->simulation);
   self->poses = calloc((size_t)contensou_simulation_size(self->simulation), sizeof(double));
   /* The list has put the work of loads into the state, which co-simulation does without. */
   self->state = calloc((size_t)self->variables.count[FMU_STATE] + 1, sizeof(double));
   self->inputs = calloc((size_t)self->variables.count[FMU_INPUT] + 1, sizeof(double));
   self->parameters = calloc((size_t)self->variables.count[FMU_PARAMETER] + 1, sizeof(double));
   self->changed = calloc((size_t)self->variables.count[FMU_PARAMETER] + 1, sizeof(int));
   self->values = calloc((size_t)shape_of(self->simulation, self->shape) + 1, sizeof(double));
   if (!self->state || !self->inputs || !self->parameters || !self->changed || !self->values ||
       !self->poses || fmu_reset(self))
      goto failed;
   shape_of(self->simulation, self->shape);
   free(scene);
   free(settings);
   free(contact);
   return self;
failed:
   free(scene);
   free(settings);
   free(contact);
   fmu_free(self);
   return NULL;
}

void fmu_free(fmu_instance *self)
{
   if (!self) return;
   contensou_simulation_free(self->simulation);
   fmu_release(&self->variables);
   free(self->state);
   free(self->inputs);
   free(self->parameters);
   free(self->changed);
   free(self->values);
   free(self->poses);
   free(self);
}

int fmu_reset(fmu_instance *self)
{
   contensou_error *error = NULL;
   const fmu_variables *list = &self->variables;
   int i, n = 0, status = contensou_simulation_reset(self->simulation, &error);

   if (fmu_told(self, status, error)) return status;
   /* Parameters that were set before have their start again. */
   for (i = 0; i < list->count[FMU_PARAMETER]; i++) n += self->changed[i];
   for (i = 0; n > 0 && i < list->count[FMU_PARAMETER]; i++) {
      const fmu_variable *item = &list->items[list->first[FMU_PARAMETER] + i];
      const char *name = item->name;
      if (!self->changed[i]) continue;
      status = contensou_simulation_set(self->simulation, &name, &item->start, 1, &error);
      if (fmu_told(self, status, error)) return status;
   }
   start(self);
   return 0;
}

/* Let inputs act that are not what acts. */
static int put_inputs(fmu_instance *self)
{
   const fmu_variables *list = &self->variables;
   contensou_error *error = NULL;
   int i, k;

   for (i = 0; i < list->count[FMU_INPUT];) {
      const fmu_variable *item = &list->items[list->first[FMU_INPUT] + i];
      int body = item->object, status, moved = 0;
      const char *name = contensou_simulation_body_name(self->simulation, body);
      double six[6] = {0.0}, now[6] = {0.0};
      for (; i < list->count[FMU_INPUT]; i++) {
         item = &list->items[list->first[FMU_INPUT] + i];
         if (item->object != body) break;
         six[item->place] = self->inputs[i];
      }
      if (contensou_simulation_motion(self->simulation, body) == CONTENSOU_FREE) {
         contensou_simulation_load(self->simulation, body, now, now + 3);
         for (k = 0; k < 6; k++) moved += six[k] != now[k];
         if (!moved) continue;
         status = contensou_simulation_set_load(self->simulation, name, six, six + 3, &error);
      } else {
         status = contensou_simulation_set_drive(self->simulation, name, six, six + 3, &error);
      }
      if (fmu_told(self, status, error)) return status;
   }
   return 0;
}

/* Take the parameters, and begin. */
int fmu_begin(fmu_instance *self)
{
   const fmu_variables *list = &self->variables;
   contensou_error *error = NULL;
   const char **names;
   double *values;
   int i, n = 0, status = 0, shape[4];

   if (self->begun) return 0;
   names = malloc(((size_t)list->count[FMU_PARAMETER] + 1) * sizeof *names);
   values = malloc(((size_t)list->count[FMU_PARAMETER] + 1) * sizeof *values);
   if (!names || !values) {
      free(names);
      free(values);
      return 1;
   }
   for (i = 0; i < list->count[FMU_PARAMETER]; i++) {
      if (!self->changed[i]) continue;
      names[n] = list->items[list->first[FMU_PARAMETER] + i].name;
      values[n++] = self->parameters[i];
   }
   if (n) status = contensou_simulation_set(self->simulation, names, values, n, &error);
   free(names);
   free(values);
   if (fmu_told(self, status, error)) return status;
   shape_of(self->simulation, shape);
   if (memcmp(shape, self->shape, sizeof shape))
      return fmu_refuse(self, "parameters change how many bodies, contacts, states or quantities "
                              "there are, for which another FMU has to be written, with --set");
   if (self->contact >= 0) {
      contensou_simulation_state(self->simulation, self->poses);
      self->begun = 1;
      return 0;
   }
   if (self->exchange) {
      status = fmu_take_loads(self->simulation, &error);
      if (fmu_told(self, status, error)) return status;
      status = contensou_simulation_update_host(self->simulation, NULL, &error);
      if (fmu_told(self, status, error)) return status;
   }
   self->begun = 1;
   status = put_inputs(self);
   read_state(self);
   return status;
}

/* Let the simulation be where the host is. */
static int follow(fmu_instance *self)
{
   contensou_error *error = NULL;
   int status = fmu_begin(self);

   if (status || !self->fresh) return status;
   status = contensou_simulation_put_host(self->simulation, self->time, self->state, self->states,
                                          &error);
   if (!status) self->fresh = 0;
   return fmu_told(self, status, error);
}

int fmu_rates(fmu_instance *self, double *rates, size_t n)
{
   contensou_error *error = NULL;
   int status = fmu_begin(self), finite = 1;
   size_t i;

   if (status || wrong_count(self, "rates", n, self->states)) return 1;
   for (i = 0; i < n; i++) finite = finite && isfinite(self->state[i]);
   if (finite) {
      status = contensou_simulation_derivative(self->simulation, self->time, self->state,
                                               self->states, rates, &error);
      if (status != 1) return fmu_told(self, status, error);
      contensou_error_free(error);
   }
   /* A step that is too long has gone out of the domain of the model. Rates that are no numbers let
    * the host take a shorter one, also one that ends at any status; its iteration may then ask for
    * those of a state that is no number either. */
   for (i = 0; i < n; i++) rates[i] = NAN;
   return 0;
}

/* Put the inputs of a contact alone into the state of its scene. */
static int pose(fmu_instance *self)
{
   const fmu_variables *list = &self->variables;
   int i, status = fmu_begin(self);

   for (i = 0; i < list->count[FMU_INPUT]; i++) {
      const fmu_variable *item = &list->items[list->first[FMU_INPUT] + i];
      double *body = self->poses + 13 * item->object, turned[3];
      body[item->place] = self->inputs[i];
      /* The angular velocity comes last. */
      if (item->place < 12) continue;
      fmu_turn(body + 3, 1, body + 10, turned);
      memcpy(body + 10, turned, sizeof turned);
   }
   return status;
}

/* What a contact alone does to its bodies, in `wrenches`; no numbers out of the domain of the
 * model, as in a step of the host that is too long. */
static int find_wrenches(fmu_instance *self)
{
   contensou_error *error = NULL;
   double *on_a = self->wrenches[0], *on_b = self->wrenches[1];
   int k, status = pose(self);

   if (status || self->known) return status;
   status = contensou_simulation_contact_load(self->simulation, self->contact, self->poses,
                                              contensou_simulation_size(self->simulation), on_b,
                                              on_a + 3, on_b + 3, &error);
   if (status > 1) return fmu_told(self, status, error);
   contensou_error_free(error);
   for (k = 0; k < 3; k++) on_a[k] = -on_b[k];
   for (k = 0; k < 6 && status; k++) on_a[k] = on_b[k] = NAN;
   self->known = 1;
   return 0;
}

/* A quantity of a contact alone. */
static int follow_poses(fmu_instance *self)
{
   contensou_error *error = NULL;
   int status = pose(self);
   if (!status)
      status = contensou_simulation_put_host(self->simulation, self->time, self->poses,
                                             contensou_simulation_size(self->simulation), &error);
   return fmu_told(self, status, error);
}

int fmu_indicators(fmu_instance *self, double *values, size_t n)
{
   contensou_error *error = NULL;
   int status = fmu_begin(self);

   if (status || wrong_count(self, "event indicators", n, self->contacts + self->remembers))
      return 1;
   if (self->contact >= 0) {
      if (pose(self)) return 1;
      status = contensou_simulation_indicators(self->simulation, self->time, self->poses,
                                               contensou_simulation_size(self->simulation),
                                               self->values, &error);
      *values = self->values[self->contact];
      return fmu_told(self, status, error);
   }
   status = contensou_simulation_indicators(self->simulation, self->time, self->state,
                                            self->states, values, &error);
   if (!status && self->remembers)
      status = contensou_simulation_memory_indicator(self->simulation, self->time, self->state,
                                                     self->states, values + self->contacts, &error);
   return fmu_told(self, status, error);
}

int fmu_get(fmu_instance *self, unsigned reference, double *value)
{
   const fmu_variables *list = &self->variables;
   const fmu_variable *item;
   contensou_error *error = NULL;
   contensou_quantity quantity;
   int status;

   if (reference >= (unsigned)list->n) return no_variable(self, reference);
   item = &list->items[reference];
   switch (item->kind) {
   case FMU_TIME:
      *value = self->time;
      return 0;
   case FMU_PARAMETER:
      *value = self->parameters[item->place];
      return 0;
   case FMU_INPUT:
      *value = self->inputs[(int)reference - list->first[FMU_INPUT]];
      return 0;
   case FMU_STATE:
      status = fmu_begin(self);
      *value = item->place < self->states ? self->state[item->place] : 0.0;
      return status;
   case FMU_RATE:
      *value = 0.0;
      if (item->place >= self->states && self->begun) return 0;
      status = fmu_rates(self, self->values, (size_t)self->states);
      if (!status && item->place < self->states) *value = self->values[item->place];
      return status;
   case FMU_INDICATOR:
      status = fmu_indicators(self, self->values, (size_t)(self->contacts + self->remembers));
      *value = self->values[item->place];
      return status;
   default:
      if (item->object == FMU_ON_A || item->object == FMU_ON_B) {
         status = find_wrenches(self);
         *value = self->wrenches[item->object == FMU_ON_B][item->place];
         return status;
      }
      status = self->contact < 0 ? follow(self) : follow_poses(self);
      if (status) return status;
      contensou_simulation_quantity(self->simulation, item->object, &quantity);
      status = contensou_simulation_values(self->simulation, quantity.name, self->values,
                                           quantity.size, &error);
      *value = self->values[item->place];
      return fmu_told(self, status, error);
   }
}

int fmu_set(fmu_instance *self, unsigned reference, double value)
{
   const fmu_variables *list = &self->variables;
   const fmu_variable *item;

   if (reference >= (unsigned)list->n) return no_variable(self, reference);
   if (!isfinite(value)) return fmu_refuse(self, "a value is infinite or not a number");
   item = &list->items[reference];
   if (item->kind == FMU_PARAMETER) {
      if (self->parameters[item->place] == value) return 0;
      if (self->begun)
         return fmu_refuse(self, "parameters can be set before the simulation has begun");
      self->parameters[item->place] = value;
      self->changed[item->place] = 1;
      return 0;
   }
   if (item->kind == FMU_INPUT) {
      double *input = &self->inputs[(int)reference - list->first[FMU_INPUT]];
      if (*input == value) return 0;
      *input = value;
      self->known = 0;
      if (self->contact >= 0) return 0;
      if (!self->begun || !self->exchange) return 0;
      if (follow(self)) return 1;
      return put_inputs(self);
   }
   return fmu_refuse(self, "only parameters and inputs can be set");
}

int fmu_step(fmu_instance *self, double time, int to_event, double *reached, int *event)
{
   contensou_error *error = NULL;
   int status = fmu_begin(self);

   if (!isfinite(time)) return fmu_refuse(self, "the end of the step is no time");
   if (self->contact >= 0) {
      self->time = *reached = time;
      *event = 0;
      return status;
   }
   if (!status) status = put_inputs(self);
   if (status) return status;
   status = to_event ? contensou_simulation_advance_to_event(self->simulation, time, &error)
                     : contensou_simulation_advance(self->simulation, time, &error);
   if (fmu_told(self, status, error)) return status;
   read_state(self);
   *reached = self->time;
   *event = self->time < time;
   return 0;
}

int fmu_set_time(fmu_instance *self, double time)
{
   if (!isfinite(time)) return fmu_refuse(self, "the time is infinite or not a number");
   self->time = time;
   self->fresh = 1;
   return 0;
}

int fmu_set_state(fmu_instance *self, const double *state, size_t n)
{
   if (fmu_begin(self) || wrong_count(self, "states", n, self->states)) return 1;
   if (n > 0) memcpy(self->state, state, n * sizeof *state);
   self->fresh = 1;
   return 0;
}

int fmu_get_state(fmu_instance *self, double *state, size_t n)
{
   if (fmu_begin(self) || wrong_count(self, "states", n, self->states)) return 1;
   if (n > 0) memcpy(state, self->state, n * sizeof *state);
   return 0;
}

int fmu_nominals(fmu_instance *self, double *nominals, size_t n)
{
   contensou_error *error = NULL;
   if (fmu_begin(self) || wrong_count(self, "states", n, self->states)) return 1;
   if (n == 0) return 0;
   return fmu_told(self, contensou_simulation_nominals(self->simulation, nominals, self->states,
                                                       &error), error);
}

/* A step is accepted; whether the host has to hear of a time event before the one it knows. */
int fmu_complete(fmu_instance *self, int *events)
{
   contensou_error *error = NULL;
   int status;

   *events = 0;
   if (self->contact >= 0) return fmu_begin(self);
   status = follow(self);
   if (!status) status = contensou_simulation_complete_host_step(self->simulation, &error);
   if (!status)
      *events = contensou_simulation_next_corner(self->simulation, self->time) < self->next;
   return fmu_told(self, status, error);
}

int fmu_update(fmu_instance *self, int *changed, double *next)
{
   contensou_error *error = NULL;
   bool is_new = false;
   int status;

   *next = INFINITY;
   if (self->contact >= 0) return fmu_begin(self);
   status = follow(self);
   if (!status) status = contensou_simulation_update_host(self->simulation, &is_new, &error);
   if (fmu_told(self, status, error)) return status;
   read_state(self);
   *changed = is_new;
   self->next = *next = contensou_simulation_next_corner(self->simulation, self->time);
   return 0;
}
