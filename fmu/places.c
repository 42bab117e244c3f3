/* States of an instance that are got and set, and their bytes. */
#include "instance.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

static double *doubles(const double *from, int n)
{
   double *copy = malloc(((size_t)n + 1) * sizeof *copy);
   if (copy) memcpy(copy, from, (size_t)n * sizeof *copy);
   return copy;
}

static void free_place(fmu_place *place)
{
   if (!place) return;
   contensou_snapshot_free(place->snapshot);
   free(place->state);
   free(place->inputs);
   free(place->parameters);
   free(place->changed);
   free(place);
}

void fmu_forget(void **handle)
{
   fmu_place *place = contensou_handle_address(*handle, FMU_PLACE);
   contensou_handle_drop(*handle, FMU_PLACE);
   free_place(place);
   *handle = NULL;
}

/* Give a place, if there is all of it, instead of one that was kept there before. */
static int give(fmu_instance *self, fmu_place *place, void **handle)
{
   void *new = NULL;
   if (place->snapshot && place->state && place->inputs && place->parameters && place->changed)
      new = contensou_handle_new(place, FMU_PLACE);
   if (!new) {
      free_place(place);
      return fmu_refuse(self, "there is no memory for a state");
   }
   fmu_forget(handle);
   *handle = new;
   return 0;
}

static void count_of(const fmu_instance *self, int count[3])
{
   count[0] = self->variables.count[FMU_STATE];
   count[1] = self->variables.count[FMU_INPUT];
   count[2] = self->variables.count[FMU_PARAMETER];
}

/* The place of a handle, if it is one of this FMU; NULL, and a message, if it is not. */
static const fmu_place *place_of(fmu_instance *self, void *handle)
{
   const fmu_place *place = contensou_handle_address(handle, FMU_PLACE);
   int count[3];

   count_of(self, count);
   if (place && !memcmp(place->count, count, sizeof count)) return place;
   fmu_refuse(self, place ? "the state is one of another FMU" : "there is no such state any more");
   return NULL;
}

int fmu_keep(fmu_instance *self, void **handle)
{
   contensou_error *error = NULL;
   fmu_place *to = calloc(1, sizeof *to);

   if (!to) return fmu_refuse(self, "there is no memory for a state");
   to->snapshot = contensou_simulation_save(self->simulation, &error);
   if (fmu_told(self, to->snapshot == NULL, error)) {
      free(to);
      return 1;
   }
   count_of(self, to->count);
   to->begun = self->begun;
   to->fresh = self->fresh;
   to->time = self->time;
   to->state = doubles(self->state, to->count[0]);
   to->inputs = doubles(self->inputs, to->count[1]);
   to->parameters = doubles(self->parameters, to->count[2]);
   to->changed = malloc(((size_t)to->count[2] + 1) * sizeof *to->changed);
   if (to->changed)
      memcpy(to->changed, self->changed, (size_t)to->count[2] * sizeof *to->changed);
   return give(self, to, handle);
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

int fmu_go_back(fmu_instance *self, void *handle)
{
   const fmu_place *place = place_of(self, handle);
   contensou_error *error = NULL;
   int status;

   if (!place) return 1;
   status = take_parameters(self, place);
   if (status) return status;
   status = contensou_simulation_restore(self->simulation, place->snapshot, &error);
   if (fmu_told(self, status, error)) return status;
   self->begun = place->begun;
   self->next = INFINITY;
   self->known = 0;
   if (self->contact < 0) self->states = contensou_simulation_size(self->simulation);
   self->fresh = place->fresh;
   self->time = place->time;
   memcpy(self->state, place->state, (size_t)place->count[0] * sizeof *self->state);
   memcpy(self->inputs, place->inputs, (size_t)place->count[1] * sizeof *self->inputs);
   memcpy(self->parameters, place->parameters, (size_t)place->count[2] * sizeof(double));
   memcpy(self->changed, place->changed, (size_t)place->count[2] * sizeof *self->changed);
   return 0;
}

/* ---- As bytes -------------------------------------------------------------------------------- */

/* What the bytes of a place begin with. */
typedef struct {
   char what[8];
   uint64_t sum;      /* of all bytes, with 0 in its place */
   uint64_t snapshot; /* bytes of the snapshot, which come last */
   double time;
   int32_t count[3]; /* states, inputs and parameters */
   int32_t begun, fresh, reserved;
} fmu_head;

static const char fmu_what[8] = {'C', 'T', 'S', ' ', 'F', 'M', 'U', '2'};

static fmu_head head_of(const fmu_place *place)
{
   fmu_head head;
   size_t snapshot = 0;
   int i;

   memset(&head, 0, sizeof head);
   memcpy(head.what, fmu_what, sizeof fmu_what);
   if (place->snapshot) contensou_snapshot_bytes(place->snapshot, &snapshot);
   head.snapshot = snapshot;
   for (i = 0; i < 3; i++) head.count[i] = place->count[i];
   head.begun = place->begun;
   head.fresh = place->fresh;
   head.time = place->time;
   return head;
}

/* Bytes of all but the snapshot. */
static size_t own_size(const fmu_head *head)
{
   size_t numbers = (size_t)head->count[0] + (size_t)head->count[1] + (size_t)head->count[2];
   return sizeof *head + numbers * sizeof(double) + (size_t)head->count[2] * sizeof(int32_t);
}

int fmu_place_size(fmu_instance *self, void *handle, size_t *size)
{
   const fmu_place *place = place_of(self, handle);
   fmu_head head;

   if (!place) return 1;
   head = head_of(place);
   *size = own_size(&head) + (size_t)head.snapshot;
   return 0;
}

/* Sum of a head and of the bytes after it: FNV-1a (G. Fowler, L. C. Noll, K.-P. Vo, 1991). */
static uint64_t sum_of(fmu_head head, const char *bytes, size_t n)
{
   uint64_t sum = UINT64_C(14695981039346656037);
   const unsigned char *byte = (const unsigned char *)&head;
   size_t i;

   head.sum = 0;
   for (i = 0; i < sizeof head; i++) sum = (sum ^ byte[i]) * UINT64_C(1099511628211);
   for (i = 0; i < n; i++) sum = (sum ^ (unsigned char)bytes[i]) * UINT64_C(1099511628211);
   return sum;
}

static char *put_bytes(char *to, const void *from, size_t n)
{
   memcpy(to, from, n);
   return to + n;
}

int fmu_write_place(fmu_instance *self, void *handle, char *bytes, size_t size)
{
   const fmu_place *place = place_of(self, handle);
   fmu_head head;
   char *begin = bytes;
   int i;

   if (!place) return 1;
   head = head_of(place);
   if (size < own_size(&head) + (size_t)head.snapshot)
      return fmu_refuse(self, "the state has more bytes than there is room for");
   bytes += sizeof head;
   bytes = put_bytes(bytes, place->state, (size_t)head.count[0] * sizeof(double));
   bytes = put_bytes(bytes, place->inputs, (size_t)head.count[1] * sizeof(double));
   bytes = put_bytes(bytes, place->parameters, (size_t)head.count[2] * sizeof(double));
   for (i = 0; i < head.count[2]; i++) {
      int32_t changed = place->changed[i];
      bytes = put_bytes(bytes, &changed, sizeof changed);
   }
   bytes = put_bytes(bytes, contensou_snapshot_bytes(place->snapshot, NULL), (size_t)head.snapshot);
   head.sum = sum_of(head, begin + sizeof head, (size_t)(bytes - begin) - sizeof head);
   put_bytes(begin, &head, sizeof head);
   return 0;
}

/* Whether bytes are those of a place of this FMU; their head. */
static int is_place(const fmu_instance *self, const char *bytes, size_t size, fmu_head *head)
{
   int count[3], i, same;

   count_of(self, count);
   if (size < sizeof *head) return 0;
   memcpy(head, bytes, sizeof *head);
   same = !memcmp(head->what, fmu_what, sizeof fmu_what);
   for (i = 0; i < 3; i++) same = same && head->count[i] == count[i];
   return same && size >= own_size(head) && head->snapshot == size - own_size(head) &&
          head->sum == sum_of(*head, bytes + sizeof *head, size - sizeof *head);
}

int fmu_read_place(fmu_instance *self, const char *bytes, size_t size, void **handle)
{
   fmu_head head;
   contensou_error *error = NULL;
   fmu_place *to;
   int i;

   if (!is_place(self, bytes, size, &head))
      return fmu_refuse(self, "the bytes are not those of a state of this FMU");
   to = calloc(1, sizeof *to);
   if (!to) return fmu_refuse(self, "there is no memory for a state");
   count_of(self, to->count);
   to->begun = head.begun;
   to->fresh = head.fresh;
   to->time = head.time;
   bytes += sizeof head;
   for (i = 0; i < 3; i++) {
      size_t n = (size_t)head.count[i] * sizeof(double);
      double *numbers = malloc(n + sizeof *numbers);
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
   if (fmu_told(self, to->snapshot == NULL, error)) {
      free_place(to);
      return 1;
   }
   return give(self, to, handle);
}
