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
#include <sys/statvfs.h>
#include <time.h>
#include <unistd.h>

int contensou_system_rename(const char *from, const char *to, int replace);
int contensou_system_remove(const char *path);
int contensou_system_exists(const char *path);
int contensou_system_is_folder(const char *path);
int contensou_system_folder_writable(const char *path);
int contensou_system_node(const char *path);
int contensou_system_same_file(const char *a, const char *b);
int contensou_system_longest_name(const char *path);
double contensou_system_free_bytes(const char *path);
int contensou_system_take_lock(const char *path, double patience, int *descriptor);
int contensou_system_share_lock(double patience, int descriptor);
void contensou_system_leave_lock(const char *path, int descriptor);
void contensou_system_sweep_up(const char *path);
uint64_t contensou_system_process(void);
void contensou_system_stop_signals(sigset_t *set);
char *contensou_system_list(const char *folder);
void contensou_system_free(void *memory);
int contensou_system_is_locked(const char *path);
int contensou_system_is_terminal(int unit);
int contensou_system_terminal_width(void);
void contensou_system_open_standard_streams(void);
void contensou_system_hold_signals(void);
void contensou_system_restore_signals(void);
void contensou_system_release_signals(void);
void contensou_system_catch_signals(void);
int contensou_system_signal_received(void);
void contensou_system_host_name(char *name, size_t size);
double contensou_system_wall_seconds(void);
double contensou_system_cpu_seconds(void);
void contensou_system_utc_now(char *text, size_t size);
int contensou_system_write(int unit, const char *text, size_t length);
int contensou_system_print(int unit, const char *text, size_t length);
size_t contensou_system_utf8_length(const char *text, size_t left);
int contensou_system_obeys_escapes(void);
const char *contensou_system_reason(int code);
int contensou_system_save(const char *path, const char *bytes, size_t length);
void contensou_system_leave(int status);
int contensou_system_become(const char *name, const char *words, int count);
uint64_t contensou_system_checksum(uint64_t sum, const unsigned char *bytes, size_t length);

/* The folder part of a file name, to be freed by the caller; null when memory is short. */
static char *folder_of(const char *path)
{
   const char *slash = strrchr(path, '/');
   if (!slash) return strdup(".");
   if (slash == path) return strdup("/");
   return strndup(path, (size_t)(slash - path));
}

/* Go on as another program, which lies beside this one or is found by the shell; its words follow
   each other, each with a null. Returns errno when there is none. */
int contensou_system_become(const char *name, const char *words, int count)
{
   char here[4096];
   ssize_t length = readlink("/proc/self/exe", here, sizeof here - 1);
   char **list = calloc((size_t)count + 2, sizeof *list);
   char *folder = NULL, *path = NULL;
   int code = ENOMEM;
   if (!list) return code;
   list[0] = (char *)name;
   for (int i = 1; i <= count; ++i) {
      list[i] = (char *)words;
      words += strlen(words) + 1;
   }
   here[length > 0 ? length : 0] = '\0';
   folder = folder_of(here);
   if (folder) path = malloc(strlen(folder) + strlen(name) + 2);
   if (path) {
      sprintf(path, "%s/%s", folder, name);
      if (access(path, X_OK) == 0) execv(path, list);
      else execvp(name, list);
      code = errno;
   }
   free(path);
   free(folder);
   free(list);
   return code;
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

/* Kinds of nodes, as operating_system.f90 knows them. */
enum {
   NODE_NONE = 0, NODE_FILE = 1, NODE_FOLDER = 2, NODE_LINK = 3, NODE_LOOSE_LINK = 4,
   NODE_DEVICE = 5, NODE_PIPE = 6, NODE_SOCKET = 7, NODE_OTHER = 8
};

/* What has this name. A link is one to a file, or to nothing; other links count as what they lead
   to. */
int contensou_system_node(const char *path)
{
   struct stat info;
   if (lstat(path, &info) != 0) return NODE_NONE;
   int is_link = S_ISLNK(info.st_mode);
   if (is_link && stat(path, &info) != 0) return NODE_LOOSE_LINK;
   if (S_ISREG(info.st_mode)) return is_link ? NODE_LINK : NODE_FILE;
   if (S_ISDIR(info.st_mode)) return NODE_FOLDER;
   if (S_ISCHR(info.st_mode) || S_ISBLK(info.st_mode)) return NODE_DEVICE;
   if (S_ISFIFO(info.st_mode)) return NODE_PIPE;
   return S_ISSOCK(info.st_mode) ? NODE_SOCKET : NODE_OTHER;
}

/* 1 if two names are those of one file, however they are spelled, or will be. */
int contensou_system_same_file(const char *a, const char *b)
{
   struct stat one, other;
   int a_exists = stat(a, &one) == 0;
   int b_exists = stat(b, &other) == 0;
   if (a_exists != b_exists) return 0;
   if (!a_exists) {
      const char *a_slash = strrchr(a, '/');
      const char *b_slash = strrchr(b, '/');
      if (strcmp(a_slash ? a_slash + 1 : a, b_slash ? b_slash + 1 : b) != 0) return 0;
      char *a_folder = folder_of(a);
      char *b_folder = folder_of(b);
      int known = a_folder && b_folder && stat(a_folder, &one) == 0 && stat(b_folder, &other) == 0;
      free(a_folder);
      free(b_folder);
      if (!known) return 0;
   }
   return one.st_ino == other.st_ino && one.st_dev == other.st_dev;
}

/* Bytes that the name of a file may have in the folder of a path. */
int contensou_system_longest_name(const char *path)
{
   char *folder = folder_of(path);
   long longest = folder ? pathconf(folder, _PC_NAME_MAX) : -1;
   free(folder);
   return longest > 0 && longest < 65536 ? (int)longest : 255;
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

/* Bytes that a file of this name can grow to: those that are free on its disk and its own. */
double contensou_system_free_bytes(const char *path)
{
   struct statvfs disk;
   struct stat info;
   double own = stat(path, &info) == 0 ? 512.0 * (double)info.st_blocks : 0.0;
   char *folder = folder_of(path);
   int known = folder && statvfs(folder, &disk) == 0 && disk.f_frsize > 0 && disk.f_blocks > 0;
   free(folder);
   return known ? own + (double)disk.f_bavail * (double)disk.f_frsize : 9e18;
}

/* Whether somebody asks this process to stop: a signal that was caught, or one that is held back. */
static int stop_is_wanted(void)
{
   sigset_t wanted, pending;
   if (contensou_system_signal_received()) return 1;
   contensou_system_stop_signals(&wanted);
   if (sigpending(&pending) != 0) return 0;
   for (int i = 1; i < NSIG; ++i) {
      if (sigismember(&wanted, i) == 1 && sigismember(&pending, i) == 1) return 1;
   }
   return 0;
}

/* Take the lock that goes with a file, waiting up to some seconds: 0, -1 if another process has it,
   or errno. The file has this name at that moment; where there are no locks all can have them. */
int contensou_system_take_lock(const char *path, double patience, int *descriptor)
{
   double start = contensou_system_wall_seconds();
   for (;;) {
      struct stat mine, named;
      int code = 0;
      int fd = open(path, O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0666);
      if (fd < 0 && errno == EACCES) fd = open(path, O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
      *descriptor = fd;
      if (fd < 0) return errno;
      if (flock(fd, LOCK_EX | LOCK_NB) != 0) code = errno;
      if (code == ENOLCK || code == ENOSYS || code == EOPNOTSUPP || code == EINVAL) code = 0;
      /* Who had it before may have removed it in between. */
      if (code == 0 && fstat(fd, &mine) == 0 && stat(path, &named) == 0
         && mine.st_ino == named.st_ino && mine.st_dev == named.st_dev) return 0;
      close(fd);
      *descriptor = -1;
      if (code == 0) continue;
      if (code != EWOULDBLOCK && code != EINTR) return code;
      if (contensou_system_wall_seconds() - start >= patience || stop_is_wanted()) return -1;
      nanosleep(&(struct timespec){0, 10 * 1000 * 1000}, NULL);
   }
}

/* Let others share a lock, so that they may read the file but not write to it: 0, or -1 if another
   process took it for itself meanwhile, as systems may allow. Where there are no locks it is shared
   anyway. */
int contensou_system_share_lock(double patience, int descriptor)
{
   double start = contensou_system_wall_seconds();
   while (flock(descriptor, LOCK_SH | LOCK_NB) != 0) {
      if (errno != EWOULDBLOCK && errno != EINTR) return 0;
      if (contensou_system_wall_seconds() - start >= patience) return -1;
      nanosleep(&(struct timespec){0, 10 * 1000 * 1000}, NULL);
   }
   return 0;
}

/* Give a lock back and remove its file, before anyone else can have it. */
void contensou_system_leave_lock(const char *path, int descriptor)
{
   if (descriptor < 0) return;
   unlink(path);
   close(descriptor);
}

/* What tells this process from others that write to the same file system. */
uint64_t contensou_system_process(void)
{
   char name[256];
   contensou_system_host_name(name, sizeof name);
   uint64_t sum = contensou_system_checksum(0, (const unsigned char *)name, strlen(name));
   return (sum ^ sum >> 32) << 32 | (uint64_t)(uint32_t)getpid();
}

/* Whether the writer of a file NAME.part-XXX is known to live, or may: here its number tells, of
   another computer only that the file changed within the last hour. */
static int may_live(const char *digits, int fd)
{
   uint64_t writer = strtoull(digits, NULL, 16);
   struct stat info;
   if (writer >> 32 == contensou_system_process() >> 32) {
      pid_t number = (pid_t)(uint32_t)writer;
      return number > 0 && number != getpid() && (kill(number, 0) == 0 || errno == EPERM);
   }
   return fstat(fd, &info) == 0 && time(NULL) - info.st_mtime < 3600;
}

/* Remove what dead processes left of the files that they wrote beside a name: NAME.part-XXX. Who
   writes by HDF5 holds a lock on its file, others are looked for. */
void contensou_system_sweep_up(const char *path)
{
   char *folder = folder_of(path);
   DIR *directory = folder ? opendir(folder) : NULL;
   const char *slash = strrchr(path, '/');
   const char *base = slash ? slash + 1 : path;
   size_t length = strlen(base);
   struct dirent *entry;
   while (directory && (entry = readdir(directory))) {
      if (strncmp(entry->d_name, base, length) != 0) continue;
      if (strncmp(entry->d_name + length, ".part-", 6) != 0) continue;
      const char *rest = entry->d_name + length + 6;
      if (strlen(rest) != 16 || strspn(rest, "0123456789abcdef") != 16) continue;
      int fd = openat(dirfd(directory), entry->d_name, O_RDWR | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
      if (fd < 0) continue;
      if (flock(fd, LOCK_EX | LOCK_NB) == 0 && !may_live(rest, fd)) {
         unlinkat(dirfd(directory), entry->d_name, 0);
      }
      close(fd);
   }
   if (directory) closedir(directory);
   free(folder);
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

/* What batch systems, shells and lost terminals send to have a program end. */
static const int stop_signals[] = {SIGINT, SIGTERM, SIGHUP, SIGUSR1, SIGUSR2, SIGXCPU, SIGALRM,
   SIGVTALRM, SIGQUIT,
#ifdef SIGPWR
   SIGPWR
#endif
};

enum { STOP_SIGNALS = sizeof stop_signals / sizeof *stop_signals };

/* What a program that holds them back was started with. */
static int held = 0;
static sigset_t mask_at_start;
static struct sigaction actions_at_start[STOP_SIGNALS];

/* Hold back requests to stop until there is somebody to heed them. An executable calls this before
   anything else in it runs. */
void contensou_system_hold_signals(void)
{
   sigset_t set;
   sigemptyset(&set);
   for (int i = 0; i < STOP_SIGNALS; ++i) {
      sigaction(stop_signals[i], NULL, &actions_at_start[i]);
      sigaddset(&set, stop_signals[i]);
   }
   held = sigprocmask(SIG_BLOCK, &set, &mask_at_start) == 0;
}

/* Undo what the Fortran library does to some of them at its start: backtraces, also for requests
   that are ignored. */
void contensou_system_restore_signals(void)
{
   if (!held) return;
   for (int i = 0; i < STOP_SIGNALS; ++i) sigaction(stop_signals[i], &actions_at_start[i], NULL);
}

/* Let come what was held back. */
void contensou_system_release_signals(void)
{
   if (held) sigprocmask(SIG_SETMASK, &mask_at_start, NULL);
   held = 0;
}

/* Those of them that are not ignored, as nohup lets SIGHUP be. A shell lets what it starts in the
   background ignore SIGINT, which some batch systems send all the same. */
void contensou_system_stop_signals(sigset_t *set)
{
   sigemptyset(set);
   for (int i = 0; i < STOP_SIGNALS; ++i) {
      struct sigaction action;
      int number = stop_signals[i];
      if (number != SIGINT && number != SIGTERM && number != SIGUSR1
         && sigaction(number, NULL, &action) == 0 && action.sa_handler == SIG_IGN) continue;
      sigaddset(set, number);
   }
}

/* Note the signal. A user's request to stop that comes a second after the first or later acts at
 * once; one that comes sooner is the same request, sent to the process and to its group. */
static void note_signal(int number)
{
   double now = contensou_system_wall_seconds();
   if (received != 0 && (number == SIGINT || number == SIGTERM || number == SIGQUIT)
      && now - first_request > 1.0) {
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

/* Turn requests to stop into a flag, those that were held back among them; let a write to a closed
   pipe or beyond a limit fail. */
void contensou_system_catch_signals(void)
{
   struct sigaction action;
   memset(&action, 0, sizeof action);
   sigemptyset(&action.sa_mask);
   /* Restarting keeps a write that is under way from failing with EINTR. */
   action.sa_flags = SA_RESTART;
   action.sa_handler = note_signal;
   received = 0;
   sigset_t set;
   contensou_system_stop_signals(&set);
   for (int i = 1; i < NSIG; ++i) {
      if (sigismember(&set, i) == 1) sigaction(i, &action, NULL);
   }
   signal(SIGXFSZ, SIG_IGN);
   signal(SIGPIPE, SIG_IGN);
   contensou_system_release_signals();
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

/* Bytes of the character of UTF-8 that a text begins with; 0 if it begins with none. */
size_t contensou_system_utf8_length(const char *text, size_t left)
{
   const unsigned char *byte = (const unsigned char *)text;
   if (left == 0) return 0;
   if (byte[0] < 0x80) return 1;
   size_t size = byte[0] >= 0xc2 && byte[0] <= 0xdf ? 2 : (byte[0] & 0xf0) == 0xe0 ? 3
      : byte[0] >= 0xf0 && byte[0] <= 0xf4 ? 4 : 0;
   if (size == 0 || size > left) return 0;
   for (size_t i = 1; i < size; ++i) {
      if ((byte[i] & 0xc0) != 0x80) return 0;
   }
   /* Forms that are too long, surrogates, and beyond the last code point. */
   if ((byte[0] == 0xe0 && byte[1] < 0xa0) || (byte[0] == 0xed && byte[1] > 0x9f)
      || (byte[0] == 0xf0 && byte[1] < 0x90) || (byte[0] == 0xf4 && byte[1] > 0x8f)) return 0;
   return size;
}

/* Whether a character does something to a terminal instead of being shown: controls but line feeds
   and tabs, ends of lines, marks, overrides and isolates of the direction, byte order marks. */
static int is_control(unsigned code)
{
   if (code < 0x20) return code != '\n' && code != '\t';
   return (code >= 0x7f && code < 0xa0) || code == 0x61c || code == 0x200e || code == 0x200f
      || (code >= 0x2028 && code <= 0x202e) || (code >= 0x2066 && code <= 0x2069)
      || code == 0xfeff;
}

/* Write to stdout (1) or stderr (2) with such characters, and bytes that are no characters, as the
   escapes of C. */
int contensou_system_print(int unit, const char *text, size_t length)
{
   char *shown = NULL;
   char *to = NULL;
   for (size_t i = 0; i < length;) {
      size_t size = contensou_system_utf8_length(text + i, length - i);
      unsigned code = (unsigned char)text[i];
      if (size == 2) code = (code & 0x1f) << 6 | (text[i + 1] & 0x3f);
      if (size == 3) {
         code = (code & 0xf) << 12 | (text[i + 1] & 0x3f) << 6 | (text[i + 2] & 0x3f);
      }
      int hidden = size == 0 || (size < 4 && is_control(code));
      if (hidden && !shown) {
         /* At most six bytes for one. */
         shown = to = malloc(6 * length + 1);
         if (!shown) return ENOMEM;
         memcpy(to, text, i);
         to += i;
      }
      if (size == 0) size = 1;
      if (hidden) {
         to += sprintf(to, size == 1 ? "\\x%02x" : "\\u%04x", code);
      } else if (shown) {
         memcpy(to, text + i, size);
         to += size;
      }
      i += size;
   }
   int status = shown ? contensou_system_write(unit, shown, (size_t)(to - shown))
                      : contensou_system_write(unit, text, length);
   free(shown);
   return status;
}

/* 1 unless the terminal is one that shows escape sequences instead of obeying them. */
int contensou_system_obeys_escapes(void)
{
   const char *term = getenv("TERM");
   return !term || strcmp(term, "dumb") != 0;
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
