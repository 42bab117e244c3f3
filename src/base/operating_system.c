/*
 * What the program asks of the operating system beyond standard Fortran: files and their safe
 * replacement, signals, clocks, the terminal. The Fortran side is system.f90.
 *
 * Functions returning int without further remark return 0 or the value of errno.
 */
#define _GNU_SOURCE

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

int contensou_system_rename(const char *from, const char *to, int replace);
int contensou_system_remove(const char *path);
int contensou_system_exists(const char *path);
int contensou_system_is_folder(const char *path);
int contensou_system_folder_writable(const char *path);
char *contensou_system_list(const char *folder);
void contensou_system_free(void *memory);
int contensou_system_is_locked(const char *path);
int contensou_system_is_terminal(int unit);
int contensou_system_terminal_width(void);
void contensou_system_open_standard_streams(void);
void contensou_system_catch_signals(void);
int contensou_system_signal_received(void);
void contensou_system_host_name(char *name, size_t size);
double contensou_system_wall_seconds(void);
double contensou_system_cpu_seconds(void);
void contensou_system_utc_now(char *text, size_t size);
int contensou_system_write(int unit, const char *text, size_t length);
const char *contensou_system_reason(int code);
int contensou_system_save(const char *path, const char *bytes, size_t length);
void contensou_system_leave(int status);
uint64_t contensou_system_checksum(uint64_t sum, const unsigned char *bytes, size_t length);

/* The folder part of a file name, to be freed by the caller; null when memory is short. */
static char *folder_of(const char *path)
{
   const char *slash = strrchr(path, '/');
   if (!slash) return strdup(".");
   if (slash == path) return strdup("/");
   return strndup(path, (size_t)(slash - path));
}

/* Bring a file or folder to the disk. File systems that cannot do it for a folder say EINVAL. */
static int sync_path(const char *path, int flags)
{
   int fd = open(path, O_RDONLY | O_CLOEXEC | flags);
   if (fd < 0) return errno;
   int code = 0;
   if (fsync(fd) != 0 && errno != EINVAL && errno != ENOTSUP) code = errno;
   if (close(fd) != 0 && code == 0) code = errno;
   return code;
}

/* Put a complete file under its final name, so that the name never shows a file whose content
   could still be lost: content first, then the name, then the folder's entry. */
int contensou_system_rename(const char *from, const char *to, int replace)
{
   int code = sync_path(from, 0);
   if (code) return code;
   if (replace) {
      if (rename(from, to) != 0) return errno;
   } else if (renameat2(AT_FDCWD, from, AT_FDCWD, to, RENAME_NOREPLACE) != 0) {
      /* Not every file system can refuse to replace. */
      if (errno != EINVAL && errno != ENOSYS) return errno;
      if (contensou_system_exists(to)) return EEXIST;
      if (rename(from, to) != 0) return errno;
   }
   char *folder = folder_of(to);
   if (!folder) return ENOMEM;
   code = sync_path(folder, O_DIRECTORY);
   free(folder);
   /* A folder may be writable but not readable; the file is in place all the same. */
   return code == EACCES ? 0 : code;
}

/* Remove a file; one that is not there counts as removed. */
int contensou_system_remove(const char *path)
{
   if (unlink(path) != 0 && errno != ENOENT) return errno;
   return 0;
}

/* 1 if there is a file, folder or device of this name. */
int contensou_system_exists(const char *path)
{
   struct stat info;
   return stat(path, &info) == 0;
}

/* Names in a folder in the order of their bytes, each followed by a slash; null on failure. To be
   freed with contensou_system_free. */
char *contensou_system_list(const char *folder)
{
   struct dirent **entries;
   int count = scandir(folder, &entries, NULL, alphasort);
   if (count < 0) return NULL;
   size_t length = 1;
   for (int i = 0; i < count; ++i) length += strlen(entries[i]->d_name) + 1;
   char *names = malloc(length);
   char *to = names;
   for (int i = 0; i < count; ++i) {
      if (names) to += sprintf(to, "%s/", entries[i]->d_name);
      free(entries[i]);
   }
   if (names) *to = '\0';
   free(entries);
   return names;
}

void contensou_system_free(void *memory)
{
   free(memory);
}

/* 1 if there is a folder of this name. */
int contensou_system_is_folder(const char *path)
{
   struct stat info;
   return stat(path, &info) == 0 && S_ISDIR(info.st_mode);
}

/* 1 if the folder part of a file name exists and files can be created in it. */
int contensou_system_folder_writable(const char *path)
{
   char *folder = folder_of(path);
   if (!folder) return 0;
   int writable = contensou_system_is_folder(folder) && access(folder, W_OK | X_OK) == 0;
   free(folder);
   return writable;
}

/* 1 if another process holds the lock that HDF5 takes on a file while writing it. What a killed
   process and its helpers held is free after a moment, so there are some trials. */
int contensou_system_is_locked(const char *path)
{
   /* Some network file systems grant an exclusive lock on writable descriptors only. */
   int fd = open(path, O_RDWR | O_CLOEXEC | O_NONBLOCK);
   if (fd < 0) fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
   if (fd < 0) return 0;
   int locked = 1;
   for (int trial = 0; trial < 50 && locked; ++trial) {
      if (trial > 0) nanosleep(&(struct timespec){0, 10 * 1000 * 1000}, NULL);
      locked = flock(fd, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
   }
   close(fd);
   return locked;
}

/* 1 if a standard stream (1 output, 2 error) is a terminal. */
int contensou_system_is_terminal(int unit)
{
   return isatty(unit) == 1;
}

/* Columns of the terminal: of stderr, else as the environment says, else 80. */
int contensou_system_terminal_width(void)
{
   struct winsize window;
   if (ioctl(STDERR_FILENO, TIOCGWINSZ, &window) == 0 && window.ws_col > 0) return window.ws_col;
   const char *columns = getenv("COLUMNS");
   long width = columns ? strtol(columns, NULL, 10) : 0;
   return width > 0 && width < 10000 ? (int)width : 80;
}

static volatile sig_atomic_t received = 0;

/* When the first of them came [s]. */
static volatile double first_request = 0.0;

/* Note the signal. A request to stop that comes a second after the first or later acts at once;
 * one that comes sooner is the same request, sent to the process and to its group. */
static void note_signal(int number)
{
   double now = contensou_system_wall_seconds();
   if (received != 0 && number != SIGUSR1 && now - first_request > 1.0) {
      signal(number, SIG_DFL);
      raise(number);
   }
   if (received == 0) first_request = now;
   received = number;
}

/* Give descriptors 0 to 2 to /dev/null where they are closed: a file that got one of them would
 * take in what is written to the standard streams. */
void contensou_system_open_standard_streams(void)
{
   int fd;
   do {
      fd = open("/dev/null", O_RDWR);
   } while (fd >= 0 && fd <= STDERR_FILENO);
   if (fd > STDERR_FILENO) close(fd);
}

/* Turn requests to stop into a flag; let a write to a closed pipe or beyond a limit fail. */
void contensou_system_catch_signals(void)
{
   struct sigaction action;
   memset(&action, 0, sizeof action);
   sigemptyset(&action.sa_mask);
   /* Restarting keeps a write that is under way from failing with EINTR. */
   action.sa_flags = SA_RESTART;
   action.sa_handler = note_signal;
   received = 0;
   sigaction(SIGINT, &action, NULL);
   sigaction(SIGTERM, &action, NULL);
   sigaction(SIGUSR1, &action, NULL);
   signal(SIGXFSZ, SIG_IGN);
   signal(SIGPIPE, SIG_IGN);
}

/* Number of the last signal caught, 0 if none. */
int contensou_system_signal_received(void)
{
   return (int)received;
}

/* Name of this machine, null-terminated. */
void contensou_system_host_name(char *name, size_t size)
{
   if (gethostname(name, size) != 0) snprintf(name, size, "unknown");
   name[size - 1] = '\0';
}

static double seconds(clockid_t clock)
{
   struct timespec now;
   if (clock_gettime(clock, &now) != 0) return 0.0;
   return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Seconds of a clock that never jumps, from an arbitrary origin. */
double contensou_system_wall_seconds(void)
{
   return seconds(CLOCK_MONOTONIC);
}

/* CPU seconds of this process, all threads. */
double contensou_system_cpu_seconds(void)
{
   return seconds(CLOCK_PROCESS_CPUTIME_ID);
}

/* Date and time as 2026-01-31T12:00:00Z, null-terminated. */
void contensou_system_utc_now(char *text, size_t size)
{
   time_t now = time(NULL);
   struct tm parts;
   if (size == 0) return;
   text[0] = '\0';
   if (gmtime_r(&now, &parts)) strftime(text, size, "%Y-%m-%dT%H:%M:%SZ", &parts);
}

/* Write to stdout (1) or stderr (2) as it stands, unbuffered. */
int contensou_system_write(int unit, const char *text, size_t length)
{
   while (length > 0) {
      ssize_t written = write(unit, text, length);
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) return errno;
      text += written;
      length -= (size_t)written;
   }
   return 0;
}

/* The system's words for a value of errno. */
const char *contensou_system_reason(int code)
{
   return strerror(code);
}

/* Replace a file by these bytes, so that after a kill or a power failure at any moment there is
   either the old content or the new one. */
int contensou_system_save(const char *path, const char *bytes, size_t length)
{
   size_t size = strlen(path) + sizeof ".new";
   char *temporary = malloc(size);
   if (!temporary) return ENOMEM;
   snprintf(temporary, size, "%s.new", path);
   int code = 0;
   int fd = open(temporary, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
   if (fd < 0) {
      code = errno;
   } else {
      code = contensou_system_write(fd, bytes, length);
      if (close(fd) != 0 && code == 0) code = errno;
      if (code == 0) code = contensou_system_rename(temporary, path, 1);
      if (code != 0) unlink(temporary);
   }
   free(temporary);
   return code;
}

/* Continue the checksum of some bytes with more; 0 begins one. FNV-1a of 64 bits, over words of eight
   bytes as far as they go, whose upper half each step brings down, and then over bytes: the sum of
   rows of reals does not depend on how many are added at a time. */
uint64_t contensou_system_checksum(uint64_t sum, const unsigned char *bytes, size_t length)
{
   const uint64_t prime = UINT64_C(0x100000001b3);
   if (sum == 0) sum = UINT64_C(0xcbf29ce484222325);
   for (; length >= sizeof(uint64_t); length -= sizeof(uint64_t), bytes += sizeof(uint64_t)) {
      uint64_t word;
      memcpy(&word, bytes, sizeof word);
      sum = (sum ^ word) * prime;
      sum ^= sum >> 32;
   }
   for (size_t i = 0; i < length; ++i) sum = (sum ^ bytes[i]) * prime;
   return sum;
}

/* End a process that fork() made, without what its parent will do at its own end. */
void contensou_system_leave(int status)
{
#ifdef CONTENSOU_COVERAGE
   /* Its counts, which only exit() would write. */
   extern void __gcov_dump(void);
   __gcov_dump();
#endif
   _exit(status);
}
