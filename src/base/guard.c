/*
 * Work in a process of its own, so that a library that crashes, hangs or takes all memory over a
 * damaged file becomes a message. The Fortran side is guard.f90, where the functions are
 * documented.
 *
 * The two processes share one page, in which the work notes what it is about to do.
 */
#define _GNU_SOURCE

#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <sys/types.h>
#include <sys/wait.h>
#include <unistd.h>
#ifdef __linux__
#include <sys/prctl.h>
#endif

int contensou_guard_start(double memory);
void contensou_guard_enter(const char *path, const char *object);
void contensou_guard_leave(void);
void contensou_guard_finish(int status);
int contensou_guard_wait(int *status, int *inside, char *place, char *reason, char *output,
   size_t size);
void contensou_system_leave(int status);

/* CPU time that one step of the work may take before it is taken for endless [s]. */
enum { STEP_SECONDS = 5 };

struct watch {
   /* Whether a library is at work that a damaged file can make crash. */
   volatile int inside;
   /* Whether the work came to its end. */
   volatile int finished;
   /* What is being read. */
   char place[2048];
};

static struct watch *watch = NULL;
static pid_t worker = -1;
static int channel = -1;

/* Memory of the work, unless a sanitizer has reserved all there is. */
static void limit_memory(double bytes)
{
#if !defined(__SANITIZE_ADDRESS__)
   struct rlimit limit;
   if (getrlimit(RLIMIT_AS, &limit) != 0) return;
   rlim_t wanted = (rlim_t)bytes;
   if (limit.rlim_max != RLIM_INFINITY && limit.rlim_max < wanted) wanted = limit.rlim_max;
   if (limit.rlim_cur != RLIM_INFINITY && limit.rlim_cur < wanted) wanted = limit.rlim_cur;
   limit.rlim_cur = wanted;
   setrlimit(RLIMIT_AS, &limit);
#else
   (void)bytes;
#endif
}

/* Give the work another span of CPU time. Without a handler the signal ends the process, however
   mangled its memory is. */
static void wind_up(void)
{
   struct itimerval timer;
   memset(&timer, 0, sizeof timer);
   timer.it_value.tv_sec = STEP_SECONDS;
   setitimer(ITIMER_PROF, &timer, NULL);
}

int contensou_guard_start(double memory)
{
   int ends[2];
   void *page = mmap(NULL, sizeof *watch, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1,
      0);
   if (page == MAP_FAILED) return -1;
   if (pipe(ends) != 0) {
      munmap(page, sizeof *watch);
      return -1;
   }
   watch = page;
   pid_t parent = getpid();
   worker = fork();
   if (worker > 0) {
      close(ends[1]);
      channel = ends[0];
      return 1;
   }
   if (worker < 0) {
      int code = errno;
      close(ends[0]);
      close(ends[1]);
      munmap(page, sizeof *watch);
      watch = NULL;
      errno = code;
      return -1;
   }
#ifdef __linux__
   prctl(PR_SET_PDEATHSIG, SIGKILL);
   if (getppid() != parent) _exit(1); /* it died before that */
#else
   (void)parent;
#endif
   struct rlimit none = {0, 0};
   setrlimit(RLIMIT_CORE, &none);
   close(ends[0]);
   /* What libraries print as they crash belongs into the message, or nowhere. */
   dup2(ends[1], STDERR_FILENO);
   if (ends[1] != STDERR_FILENO) close(ends[1]);
   signal(SIGPROF, SIG_DFL);
   signal(SIGPIPE, SIG_IGN);
   static const int crashes[] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT};
   for (size_t i = 0; i < sizeof crashes / sizeof *crashes; ++i) signal(crashes[i], SIG_DFL);
   limit_memory(memory);
   wind_up();
   return 0;
}

void contensou_guard_enter(const char *path, const char *object)
{
   if (!watch) return;
   snprintf(watch->place, sizeof watch->place, "%s%s%s", path, object[0] ? ", object " : "",
      object);
   watch->inside = 1;
   wind_up();
}

void contensou_guard_leave(void)
{
   if (watch) watch->inside = 0;
}

void contensou_guard_finish(int status)
{
   if (watch) watch->finished = 1;
   contensou_system_leave(status);
}

int contensou_guard_wait(int *status, int *inside, char *place, char *reason, char *output,
   size_t size)
{
   size_t used = 0;
   int code = 0;
   char spill[4096];
   for (;;) {
      char *to = used + 1 < size ? output + used : spill;
      size_t room = used + 1 < size ? size - 1 - used : sizeof spill;
      ssize_t got = read(channel, to, room);
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) break;
      if (to != spill) used += (size_t)got;
   }
   output[used] = '\0';
   close(channel);
   pid_t found;
   do {
      found = waitpid(worker, &code, 0);
   } while (found < 0 && errno == EINTR);
   memcpy(place, watch->place, sizeof watch->place);
   place[sizeof watch->place - 1] = '\0';
   *inside = watch->inside;
   *status = WIFEXITED(code) ? WEXITSTATUS(code) : 0;
   int finished = found > 0 && watch->finished && WIFEXITED(code);
   if (found > 0 && WIFSIGNALED(code)) {
      if (WTERMSIG(code) == SIGPROF) {
         snprintf(reason, 256, "no end after %d s of CPU time", STEP_SECONDS);
      } else {
         snprintf(reason, 256, "%s", strsignal(WTERMSIG(code)));
      }
   } else {
      snprintf(reason, 256, "exit status %d", *status);
   }
   munmap(watch, sizeof *watch);
   watch = NULL;
   return finished;
}
