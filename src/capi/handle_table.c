/* Handles of the C interface; see table.f90. A handle is the number of a slot and how often that was
 * given out, so a handle that was released is not one of what came after it. Slots stay where they
 * are, and looking at one takes no lock. */
#include <pthread.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdlib.h>

enum { CHUNK = 1024, CHUNKS = 4096, SLOT_BITS = 22 };

typedef struct {
   _Atomic uint64_t tag; /* how often it was given out, and the kind; kind 0: free */
   uintptr_t hidden;     /* the address, inverted: what nobody releases is a leak */
   uint32_t next;        /* the next free slot */
} slot;

void *contensou_handle_new(void *address, int kind);
void *contensou_handle_address(void *handle, int kind);
void contensou_handle_drop(void *handle, int kind);

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static slot *_Atomic chunks[CHUNKS];
static uint32_t used = 1, first_free; /* slot 0 is none */

static slot *slot_of(uint32_t i)
{
   slot *chunk = i < CHUNK * CHUNKS ? atomic_load(&chunks[i / CHUNK]) : NULL;
   return chunk ? &chunk[i % CHUNK] : NULL;
}

/* The slot of a handle that is one of a kind; NULL for others. */
static slot *found(void *handle, int kind)
{
   const uint64_t value = (uint64_t)(uintptr_t)handle;
   slot *at = slot_of((uint32_t)(value & ((1u << SLOT_BITS) - 1)));
   return at && atomic_load(&at->tag) == ((value >> SLOT_BITS) << 8 | (uint64_t)kind) ? at : NULL;
}

/* A handle for an address; NULL where there are no more. */
void *contensou_handle_new(void *address, int kind)
{
   slot *at = NULL;
   uint32_t i;
   uint64_t count = 0;

   pthread_mutex_lock(&lock);
   i = first_free;
   if (i) {
      at = slot_of(i);
      first_free = at->next;
   } else if (used < CHUNK * CHUNKS) {
      i = used;
      if (!slot_of(i)) atomic_store(&chunks[i / CHUNK], (slot *)calloc(CHUNK, sizeof(slot)));
      at = slot_of(i);
      used += at != NULL;
   }
   if (at) {
      at->hidden = ~(uintptr_t)address;
      count = ((atomic_load(&at->tag) >> 8) + 1) & (((uint64_t)1 << (64 - SLOT_BITS)) - 1);
      atomic_store(&at->tag, count << 8 | (uint64_t)kind);
   }
   pthread_mutex_unlock(&lock);
   return at ? (void *)(uintptr_t)(count << SLOT_BITS | i) : NULL;
}

/* The address of a handle that has not been released; NULL for all else. */
void *contensou_handle_address(void *handle, int kind)
{
   slot *at = found(handle, kind);
   return at ? (void *)~at->hidden : NULL;
}

/* Release a handle. */
void contensou_handle_drop(void *handle, int kind)
{
   slot *at;

   pthread_mutex_lock(&lock);
   at = found(handle, kind);
   if (at) {
      atomic_store(&at->tag, atomic_load(&at->tag) & ~(uint64_t)255);
      at->next = first_free;
      first_free = (uint32_t)((uint64_t)(uintptr_t)handle & ((1u << SLOT_BITS) - 1));
   }
   pthread_mutex_unlock(&lock);
}
