/*
 * A file of results of fixed size, one slot for each of a known number of cases, written by many
 * threads in any order and readable however the writers ended. The Fortran side is journal.f90,
 * where the functions are documented.
 *
 * Layout, in the byte order of the machine: a header of 4096 bytes, the slots, the messages. A slot
 * carries a checksum over itself and its message; one that is not right counts as empty. Slots and
 * messages are written with one call each, the message first, so that a process that is killed
 * leaves what it had finished. The lock is that of the open file and ends with the last process
 * that holds it.
 */
#define _GNU_SOURCE

#include <errno.h>
#include <fcntl.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

struct journal;

struct journal *contensou_journal_open(const char *path, const char *key, int64_t count,
   int64_t columns, int replace, int *outcome);
int contensou_journal_write(struct journal *journal, int64_t position, int64_t number, int status,
   const double *values, const char *message, int64_t length);
int contensou_journal_has(struct journal *journal, int64_t position);
int contensou_journal_read(struct journal *journal, int64_t position, int64_t *number, int *status,
   double *values, char *message, int64_t *length);
int contensou_journal_sync(struct journal *journal);
void contensou_journal_close(struct journal *journal);
int contensou_system_take_lock(const char *path, double patience, int *descriptor);
size_t contensou_system_utf8_length(const char *text, size_t left);

/* Outcomes of opening beside values of errno, which are positive. */
enum {
   opened_new = 0, opened_again = -1, opened_other = -2, opened_locked = -3, opened_damaged = -4
};

/* Seconds to wait for the processes of a program that was just killed to end. */
enum { patience = 10 };

enum { header_size = 4096, key_size = 2048, message_size = 4096 };

static const char magic[8] = "CONTJRN1";

struct header {
   char magic[8];
   uint64_t checksum;
   int64_t count;
   int64_t columns;
   char key[key_size];
};

struct slot {
   uint64_t checksum;
   int64_t number;
   int64_t status;
   int64_t message_start;
   int64_t message_length;
   double values[];
};

struct journal {
   int file;
   int64_t count;
   int64_t columns;
   size_t slot_bytes;
   /* Where the next message goes, shared by all processes. */
   _Atomic int64_t *tail;
};

/* Checksum of bytes, going on from another; eight bytes at a time. */
static uint64_t mix(uint64_t sum, const void *data, size_t size)
{
   const unsigned char *bytes = data;
   while (size > 0) {
      uint64_t word = 0;
      size_t n = size < sizeof word ? size : sizeof word;
      memcpy(&word, bytes, n);
      sum = (sum ^ word) * UINT64_C(0x9e3779b97f4a7c15);
      sum ^= sum >> 29;
      bytes += n;
      size -= n;
   }
   return sum;
}

static uint64_t slot_checksum(const struct journal *journal, const struct slot *slot,
   const char *message)
{
   uint64_t sum = mix(UINT64_C(0x436f6e74656e736f), &slot->number,
      journal->slot_bytes - sizeof slot->checksum);
   sum = mix(sum, message, (size_t)slot->message_length);
   return sum ? sum : 1;
}

static uint64_t header_checksum(const struct header *header)
{
   return mix(UINT64_C(0x6a6f75726e616c31), &header->count, sizeof *header - sizeof header->magic
      - sizeof header->checksum);
}

static int write_all(int file, const void *data, size_t size, int64_t start)
{
   const char *bytes = data;
   while (size > 0) {
      ssize_t written = pwrite(file, bytes, size, (off_t)start);
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) return errno;
      bytes += written;
      start += written;
      size -= (size_t)written;
   }
   return 0;
}

/* Read as much as there is; what is beyond the end of the file reads as zero. */
static int read_all(int file, void *data, size_t size, int64_t start)
{
   char *bytes = data;
   while (size > 0) {
      ssize_t got = pread(file, bytes, size, (off_t)start);
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) return errno;
      if (got == 0) {
         memset(bytes, 0, size);
         return 0;
      }
      bytes += got;
      start += got;
      size -= (size_t)got;
   }
   return 0;
}

static int64_t slot_start(const struct journal *journal, int64_t position)
{
   return header_size + position * (int64_t)journal->slot_bytes;
}

struct journal *contensou_journal_open(const char *path, const char *key, int64_t count,
   int64_t columns, int replace, int *outcome)
{
   int file;
   *outcome = contensou_system_take_lock(path, patience, &file);
   if (*outcome < 0) *outcome = opened_locked;
   if (*outcome != 0) return NULL;
   struct journal *journal = calloc(1, sizeof *journal);
   struct header *wanted = calloc(1, header_size);
   struct header *found = calloc(1, header_size);
   void *page = mmap(NULL, sizeof *journal->tail, PROT_READ | PROT_WRITE,
      MAP_SHARED | MAP_ANONYMOUS, -1, 0);
   int code = 0;
   if (!journal || !wanted || !found || page == MAP_FAILED) code = ENOMEM;
   struct stat info;
   if (code == 0 && fstat(file, &info) != 0) code = errno;
   if (code == 0) {
      journal->file = file;
      journal->count = count;
      journal->columns = columns;
      journal->slot_bytes = sizeof(struct slot) + (size_t)columns * sizeof(double);
      journal->tail = page;
      memcpy(wanted->magic, magic, sizeof magic);
      wanted->count = count;
      wanted->columns = columns;
      strncpy(wanted->key, key, key_size - 1);
      wanted->checksum = header_checksum(wanted);
      code = read_all(file, found, header_size, 0);
   }
   if (code == 0) {
      int is_journal = memcmp(found->magic, magic, sizeof magic) == 0;
      int is_sound = is_journal && found->checksum == header_checksum(found);
      if (info.st_size > 0 && memcmp(found, wanted, sizeof *wanted) == 0) {
         *outcome = opened_again;
      } else if (info.st_size > (is_journal ? header_size : 0) && !replace) {
         *outcome = is_sound ? opened_other : opened_damaged;
      } else {
         *outcome = opened_new;
         if (ftruncate(file, 0) != 0) code = errno;
         if (code == 0) code = write_all(file, wanted, header_size, 0);
      }
   }
   int usable = *outcome != opened_other && *outcome != opened_damaged;
   if (code == 0 && usable) {
      int64_t end = slot_start(journal, count);
      if (info.st_size < end || *outcome == opened_new) {
         if (ftruncate(file, (off_t)end) != 0) code = errno;
      } else {
         end = (int64_t)info.st_size;
      }
      *journal->tail = end;
   }
   free(wanted);
   free(found);
   if (code == 0 && usable) return journal;
   if (code != 0) *outcome = code;
   if (page != MAP_FAILED) munmap(page, sizeof *journal->tail);
   close(file);
   free(journal);
   return NULL;
}

/* Copy a message, as far as there is room, in UTF-8 whatever a library has put into it: a table has
   no other texts. */
static int64_t take_message(const char *message, int64_t length, char *text)
{
   int64_t used = 0;
   for (int64_t i = 0; i < length;) {
      size_t size = contensou_system_utf8_length(message + i, (size_t)(length - i));
      size_t taken = size ? size : 1;
      if (used + (int64_t)taken > message_size) break;
      memcpy(text + used, size ? message + i : "?", taken);
      used += (int64_t)taken;
      i += (int64_t)taken;
   }
   return used;
}

int contensou_journal_write(struct journal *journal, int64_t position, int64_t number, int status,
   const double *values, const char *message, int64_t length)
{
   int64_t bytes[(journal->slot_bytes + 7) / 8];
   struct slot *slot = (struct slot *)bytes;
   if (position < 0 || position >= journal->count) return EINVAL;
   char text[message_size];
   length = take_message(message, length, text);
   slot->number = number;
   slot->status = status;
   slot->message_start = 0;
   slot->message_length = length;
   memcpy(slot->values, values, (size_t)journal->columns * sizeof *values);
   if (length > 0) {
      slot->message_start = atomic_fetch_add(journal->tail, length);
      int code = write_all(journal->file, text, (size_t)length, slot->message_start);
      if (code) return code;
   }
   slot->checksum = slot_checksum(journal, slot, text);
   return write_all(journal->file, slot, journal->slot_bytes, slot_start(journal, position));
}

int contensou_journal_read(struct journal *journal, int64_t position, int64_t *number, int *status,
   double *values, char *message, int64_t *length)
{
   int64_t bytes[(journal->slot_bytes + 7) / 8];
   struct slot *slot = (struct slot *)bytes;
   char text[message_size];
   if (position < 0 || position >= journal->count) return -EINVAL;
   int code = read_all(journal->file, slot, journal->slot_bytes, slot_start(journal, position));
   if (code) return -code;
   if (slot->checksum == 0 || slot->message_length < 0 || slot->message_length > message_size)
      return 0;
   if (slot->message_length > 0) {
      if (slot->message_start < slot_start(journal, journal->count)) return 0;
      code = read_all(journal->file, text, (size_t)slot->message_length, slot->message_start);
      if (code) return -code;
   }
   if (slot->checksum != slot_checksum(journal, slot, text)) return 0;
   *number = slot->number;
   *status = (int)slot->status;
   *length = slot->message_length;
   if (values) memcpy(values, slot->values, (size_t)journal->columns * sizeof *values);
   if (message) memcpy(message, text, (size_t)slot->message_length);
   return 1;
}

int contensou_journal_has(struct journal *journal, int64_t position)
{
   int64_t number, length;
   int status;
   return contensou_journal_read(journal, position, &number, &status, NULL, NULL, &length) == 1;
}

int contensou_journal_sync(struct journal *journal)
{
   if (fdatasync(journal->file) != 0 && errno != EINVAL && errno != ENOTSUP) return errno;
   return 0;
}

void contensou_journal_close(struct journal *journal)
{
   if (!journal) return;
   close(journal->file);
   munmap((void *)journal->tail, sizeof *journal->tail);
   free(journal);
}
