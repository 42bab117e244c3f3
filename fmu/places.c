/* States of an instance that are got and set, and their bytes. */
#include "instance.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

static double *doubles(const double *from, int n)
{
   double *copy = malloc(((size_t)n + 1) * sizeof *copy);
   if (copy) memcpy(copy, from, (size_t)n * sizeof *copy);
   return copy;
}

int fmu_keep(fmu_instance *self, fmu_place **place)
{
   const fmu_variables *list = &self->variables;
   contensou_error *error = NULL;
   fmu_place *to = calloc(1, sizeof *to);

   if (!to) return 1;
   to->snapshot = contensou_simulation_save(self->simulation, &error);
   if (fmu_told(self, to->snapshot == NULL, error)) {
      free(to);
      return 1;
   }
   to->begun = self->begun;
   to->fresh = self->fresh;
   to->time = self->time;
   to->state = doubles(self->state, list->count[FMU_STATE]);
   to->inputs = doubles(self->inputs, list->count[FMU_INPUT]);
   to->parameters = doubles(self->parameters, list->count[FMU_PARAMETER]);
   to->changed = malloc(((size_t)list->count[FMU_PARAMETER] + 1) * sizeof *to->changed);
   if (!to->state || !to->inputs || !to->parameters || !to->changed) {
      fmu_forget(to);
      return 1;
   }
   memcpy(to->changed, self->changed, (size_t)list->count[FMU_PARAMETER] * sizeof *to->changed);
   fmu_forget(*place);
   *place = to;
   return 0;
}

/* Let the scene have the parameters that it had at a place. */
static int take_parameters(fmu_instance *self, const fmu_place *place)
{
   int i, same = self->begun == place->begun, n = self->variables.count[FMU_PARAMETER], status;

   for (i = 0; i < n; i++)
      same = same && self->parameters[i] == place->parameters[i] &&
             self->changed[i] == place->changed[i];
   if (same) return 0;
   status = fmu_reset(self);
   if (status) return status;
   memcpy(self->parameters, place->parameters, (size_t)n * sizeof *self->parameters);
   memcpy(self->changed, place->changed, (size_t)n * sizeof *self->changed);
   return place->begun ? fmu_begin(self) : 0;
}

int fmu_go_back(fmu_instance *self, const fmu_place *place)
{
   const fmu_variables *list = &self->variables;
   contensou_error *error = NULL;
   int status;

   if (!place) return 1;
   status = take_parameters(self, place);
   if (status) return status;
   status = contensou_simulation_restore(self->simulation, place->snapshot, &error);
   if (fmu_told(self, status, error)) return status;
   self->begun = place->begun;
   self->known = 0;
   if (self->contact < 0) self->states = contensou_simulation_size(self->simulation);
   self->fresh = place->fresh;
   self->time = place->time;
   memcpy(self->state, place->state, (size_t)list->count[FMU_STATE] * sizeof *self->state);
   memcpy(self->inputs, place->inputs, (size_t)list->count[FMU_INPUT] * sizeof *self->inputs);
   memcpy(self->parameters, place->parameters,
          (size_t)list->count[FMU_PARAMETER] * sizeof *self->parameters);
   memcpy(self->changed, place->changed,
          (size_t)list->count[FMU_PARAMETER] * sizeof *self->changed);
   return 0;
}

void fmu_forget(fmu_place *place)
{
   if (!place) return;
   contensou_snapshot_free(place->snapshot);
   free(place->state);
   free(place->inputs);
   free(place->parameters);
   free(place->changed);
   free(place);
}

/* ---- As bytes -------------------------------------------------------------------------------- */

/* What the bytes of a place begin with. */
typedef struct {
   char what[8];
   uint64_t snapshot; /* bytes of the snapshot, which come last */
   uint64_t sum;      /* of all bytes that follow */
   double time;
   int32_t count[3]; /* states, inputs and parameters */
   int32_t begun, fresh, reserved;
} fmu_head;

static const char fmu_what[8] = {'C', 'T', 'S', ' ', 'F', 'M', 'U', '1'};

static void head_of(const fmu_instance *self, fmu_head *head)
{
   memset(head, 0, sizeof *head);
   memcpy(head->what, fmu_what, sizeof fmu_what);
   head->count[0] = self->variables.count[FMU_STATE];
   head->count[1] = self->variables.count[FMU_INPUT];
   head->count[2] = self->variables.count[FMU_PARAMETER];
}

/* Bytes of all but the snapshot. */
static size_t own_size(const fmu_head *head)
{
   size_t numbers = (size_t)head->count[0] + (size_t)head->count[1] + (size_t)head->count[2];
   return sizeof *head + numbers * sizeof(double) + (size_t)head->count[2] * sizeof(int32_t);
}

int fmu_place_size(const fmu_instance *self, const fmu_place *place, size_t *size)
{
   fmu_head head;
   if (!place || !size || !contensou_snapshot_bytes(place->snapshot, size)) return 1;
   head_of(self, &head);
   *size += own_size(&head);
   return 0;
}

/* Sum of bytes: FNV-1a (G. Fowler, L. C. Noll, K.-P. Vo, 1991). */
static uint64_t sum_of(const char *bytes, size_t n)
{
   uint64_t sum = UINT64_C(14695981039346656037);
   size_t i;
   for (i = 0; i < n; i++) sum = (sum ^ (unsigned char)bytes[i]) * UINT64_C(1099511628211);
   return sum;
}

static char *put_bytes(char *to, const void *from, size_t n)
{
   memcpy(to, from, n);
   return to + n;
}

int fmu_write_place(const fmu_instance *self, const fmu_place *place, char *bytes, size_t size)
{
   fmu_head head;
   char *begin = bytes;
   size_t wanted, snapshot;
   int i;

   if (!bytes || fmu_place_size(self, place, &wanted) || size < wanted) return 1;
   head_of(self, &head);
   contensou_snapshot_bytes(place->snapshot, &snapshot);
   head.snapshot = snapshot;
   head.time = place->time;
   head.begun = place->begun;
   head.fresh = place->fresh;
   bytes += sizeof head;
   bytes = put_bytes(bytes, place->state, (size_t)head.count[0] * sizeof(double));
   bytes = put_bytes(bytes, place->inputs, (size_t)head.count[1] * sizeof(double));
   bytes = put_bytes(bytes, place->parameters, (size_t)head.count[2] * sizeof(double));
   for (i = 0; i < head.count[2]; i++) {
      int32_t changed = place->changed[i];
      bytes = put_bytes(bytes, &changed, sizeof changed);
   }
   put_bytes(bytes, contensou_snapshot_bytes(place->snapshot, NULL), snapshot);
   head.sum = sum_of(begin + sizeof head, wanted - sizeof head);
   put_bytes(begin, &head, sizeof head);
   return 0;
}

int fmu_read_place(fmu_instance *self, const char *bytes, size_t size, fmu_place **place)
{
   fmu_head head, own;
   contensou_error *error = NULL;
   fmu_place *to;
   size_t n;
   int i;

   head_of(self, &own);
   if (bytes && size >= sizeof head) memcpy(&head, bytes, sizeof head);
   if (!bytes || !place || size < own_size(&own) || memcmp(head.what, own.what, sizeof own.what) ||
       memcmp(head.count, own.count, sizeof own.count) ||
       head.snapshot != size - own_size(&own) ||
       head.sum != sum_of(bytes + sizeof head, size - sizeof head)) {
      fmu_say(self, 1, "the bytes are not those of a state of this FMU");
      return 1;
   }
   to = calloc(1, sizeof *to);
   if (!to) return 1;
   to->begun = head.begun;
   to->fresh = head.fresh;
   to->time = head.time;
   bytes += sizeof head;
   for (i = 0; i < 3; i++) {
      double *numbers = malloc(((size_t)head.count[i] + 1) * sizeof *numbers);
      n = (size_t)head.count[i] * sizeof *numbers;
      if (numbers) memcpy(numbers, bytes, n);
      bytes += n;
      *(i == 0 ? &to->state : i == 1 ? &to->inputs : &to->parameters) = numbers;
   }
   to->changed = malloc(((size_t)head.count[2] + 1) * sizeof *to->changed);
   for (i = 0; to->changed && i < head.count[2]; i++) {
      int32_t changed;
      memcpy(&changed, bytes + (size_t)i * sizeof changed, sizeof changed);
      to->changed[i] = changed;
   }
   bytes += (size_t)head.count[2] * sizeof(int32_t);
   to->snapshot = contensou_snapshot_new(bytes, (size_t)head.snapshot, &error);
   if (fmu_told(self, to->snapshot == NULL, error) || !to->state || !to->inputs ||
       !to->parameters || !to->changed) {
      fmu_forget(to);
      return 1;
   }
   fmu_forget(*place);
   *place = to;
   return 0;
}
