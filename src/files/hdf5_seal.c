/*
 * The seal of a complete file: 64 bytes behind its end that hold its size and the CRC-32 of all of
 * it, in words. HDF5 reads over them, and cuts them off when it changes the file. So damage of any
 * kind is seen before HDF5, which may crash over it, looks at the file.
 */
#include "hdf5_common.h"

#include <fcntl.h>
#include <unistd.h>
#include <zlib.h>

enum { SEAL_SIZE = 64, BLOCK = 1 << 16, BLOCKS_BETWEEN_NOTES = 1024 };

static const char magic[] = "contensou-seal 1 ";

/* src/base/guard.c */
void contensou_guard_enter(const char *path, const char *object);

/* Make the seal of the first bytes of a file; 0 or errno. */
static int make_seal(int fd, int64_t size, const char *path, char *seal)
{
   uLong crc = crc32(0, NULL, 0);
   unsigned char *block = malloc(BLOCK);
   if (!block) return ENOMEM;
   int code = 0;
   int64_t done = 0;
   for (int i = 0; done < size && code == 0; ++i) {
      if (i % BLOCKS_BETWEEN_NOTES == 0) contensou_guard_enter(path, "");
      int64_t left = size - done;
      ssize_t got = pread(fd, block, left < BLOCK ? (size_t)left : BLOCK, (off_t)done);
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) {
         code = got < 0 ? errno : EIO;
      } else {
         crc = crc32(crc, block, (uInt)got);
         done += got;
      }
   }
   free(block);
   memset(seal, ' ', SEAL_SIZE);
   int used = snprintf(seal, SEAL_SIZE, "%ssize %lld crc %08lx", magic, (long long)size, crc);
   seal[used] = ' ';
   seal[SEAL_SIZE - 1] = '\n';
   return code;
}

int contensou_hdf5_seal(int fd, const char *path)
{
   struct stat info;
   char seal[SEAL_SIZE];
   if (fstat(fd, &info) != 0) return errno;
   int code = make_seal(fd, (int64_t)info.st_size, path, seal);
   for (size_t done = 0; done < SEAL_SIZE && code == 0;) {
      ssize_t put = pwrite(fd, seal + done, SEAL_SIZE - done, info.st_size + (off_t)done);
      if (put < 0 && errno != EINTR) code = errno;
      if (put > 0) done += (size_t)put;
   }
   /* No half of a seal stays. */
   if (code && ftruncate(fd, info.st_size) != 0) return code;
   return code;
}

/* Where HDF5 says that a file ends; -1 if it does not. */
static int64_t end_of_hdf5(int fd)
{
   static const unsigned char signature[8] = {0x89, 'H', 'D', 'F', '\r', '\n', 0x1a, '\n'};
   unsigned char block[64];
   if (pread(fd, block, sizeof block, 0) != (ssize_t)sizeof block) return -1;
   if (memcmp(block, signature, sizeof signature) != 0) return -1;
   int at = block[8] == 0 ? 40 : block[8] == 1 ? 44 : block[8] <= 3 ? 28 : 0;
   if (at == 0 || block[block[8] < 2 ? 13 : 9] != 8) return -1;
   uint64_t end = 0;
   for (int i = 7; i >= 0; --i) end = end << 8 | block[at + i];
   return end > INT64_MAX ? -1 : (int64_t)end;
}

int contensou_hdf5_check_seal(const char *path)
{
   struct stat info;
   char found[SEAL_SIZE], seal[SEAL_SIZE];
   int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
   if (fd < 0) return SEAL_NONE;
   int outcome = SEAL_NONE;
   if (fstat(fd, &info) == 0 && S_ISREG(info.st_mode) && info.st_size >= SEAL_SIZE
      && pread(fd, found, SEAL_SIZE, info.st_size - SEAL_SIZE) == SEAL_SIZE) {
      int64_t end = end_of_hdf5(fd);
      if (memcmp(found, magic, sizeof magic - 1) == 0) {
         outcome = make_seal(fd, (int64_t)info.st_size - SEAL_SIZE, path, seal) == 0
            && memcmp(found, seal, SEAL_SIZE) == 0 ? SEAL_GOOD : SEAL_BROKEN;
      } else if (end > 0 && info.st_size > end && info.st_size <= end + SEAL_SIZE) {
         /* There was one. */
         outcome = SEAL_BROKEN;
      }
   }
   close(fd);
   return outcome;
}
