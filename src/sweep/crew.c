/*
 * Many independent pieces of work on many threads of one process, such that a piece that crashes or
 * hangs takes at most itself. The Fortran side is crew.f90, where the functions are documented.
 *
 * The caller becomes a supervisor without threads. It starts one worker process, whose threads take
 * the pieces in order. Memory that both share shows which pieces are in hand. When the worker dies,
 * those that it had in hand are done again one at a time, each in a worker of its own; when one of
 * them is beyond its time limit and its thread does not look at the clock, the worker is ended and
 * the others in hand are done again.
 */
#define _GNU_SOURCE

#include <errno.h>
#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/types.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>
#ifdef __linux__
#include <sys/prctl.h>
#endif

/* A piece of work in a worker: 0 or a value of errno, which ends the whole. */
typedef int work_function(void *context, int thread, int64_t piece);
/* Whether a piece is done already. */
typedef int done_function(void *context, int64_t piece);
/* In the supervisor: a piece was given up; 0 or a value of errno. */
typedef int lost_function(void *context, int64_t piece, int late, const char *reason);
/* In the supervisor, some times a second: pieces done by workers so far. */
typedef void look_function(void *context, int64_t finished);

int contensou_crew_cores(void);
void contensou_crew_hold_signals(void);
int contensou_crew_stop_requested(void);
int contensou_crew_run(void *context, int64_t pieces, int threads, double time_limit,
   work_function *work, done_function *done, lost_function *lost, look_function *look,
   char *reason);
void contensou_crew_begin(int thread);
int contensou_crew_stopping(void);
void contensou_system_leave(int status);
void contensou_system_stop_signals(sigset_t *set);

enum { most_threads = 1024, reason_size = 512, stack_size = 16 << 20 };

/* Outcomes of a crew beside values of errno, which are positive. */
enum { crew_complete = 0, crew_stopped = -1, crew_broken = -2 };

/* Times that a piece is tried alone whose worker was killed from outside. */
enum { tries_alone = 3 };

/* Workers that may die in a row without a piece in hand. */
enum { deaths_idle = 5 };

/* Seconds beyond its limit, and the share of the limit, after which a piece counts as hanging; and
   seconds from a request to stop to the end of a worker that does not. */
static const double grace = 1.0, grace_share = 0.1, farewell = 0.5;

/* What a thread has in hand; on a cache line of its own. */
struct hand {
   _Alignas(64) _Atomic int64_t piece;
   /* When it began [ns]; 0 while it waits. */
   _Atomic int64_t since;
};

struct board {
   /* The next piece that nobody took. */
   _Atomic int64_t next;
   /* Pieces to do again, those that nobody took from `again_next` on. */
   _Atomic int64_t again_next;
   int64_t again_count;
   int64_t again[most_threads];
   _Atomic int64_t finished;
   _Atomic int stop;
   _Atomic int failure;
   _Atomic int complete;
   struct hand hands[most_threads];
};

struct crew {
   void *context;
   int64_t pieces;
   int threads;
   double time_limit;
   work_function *work;
   done_function *done;
   lost_function *lost;
   look_function *look;
   char *reason;
   /* The only piece of this worker; -1 for all. */
   int64_t alone;
   /* What the worker writes to the standard error. */
   int words;
};

/* How a worker ended. */
struct ending {
   int complete;
   /* The signal that ended it; 0 for an exit. */
   int signal;
   int status;
   /* Hand whose piece hung; -1 if the supervisor did not end the worker for that. */
   int hung;
};

static struct board *board = NULL;
static struct crew *crew = NULL;
static int stop_seen = 0;

static int64_t now(void)
{
   struct timespec time;
   clock_gettime(CLOCK_MONOTONIC, &time);
   return (int64_t)time.tv_sec * 1000000000 + time.tv_nsec;
}

int contensou_crew_cores(void)
{
   cpu_set_t set;
   int count = 0;
   if (sched_getaffinity(0, sizeof set, &set) == 0) count = CPU_COUNT(&set);
   if (count < 1) count = (int)sysconf(_SC_NPROCESSORS_ONLN);
   return count < 1 ? 1 : count;
}

/* Signals that ask to stop, as they were when the first of them was held back. */
static sigset_t requests;

void contensou_crew_hold_signals(void)
{
   contensou_system_stop_signals(&requests);
   sigset_t set = requests;
   sigaddset(&set, SIGCHLD);
   sigprocmask(SIG_BLOCK, &set, NULL);
   signal(SIGXFSZ, SIG_IGN);
   signal(SIGPIPE, SIG_IGN);
   stop_seen = 0;
}

int contensou_crew_stop_requested(void)
{
   const struct timespec none = {0, 0};
   if (sigtimedwait(&requests, NULL, &none) > 0) stop_seen = 1;
   return stop_seen;
}

void contensou_crew_begin(int thread)
{
   if (board) atomic_store(&board->hands[thread].since, now());
}

int contensou_crew_stopping(void)
{
   return board && atomic_load_explicit(&board->stop, memory_order_relaxed);
}

/* Take a piece from a counter: it is shown in hand before the counter moves, so that one that was
   taken is never lost. -1 when there are none left. */
static int64_t take(struct hand *hand, _Atomic int64_t *next, int64_t count, const int64_t *list)
{
   int64_t index = atomic_load(next);
   while (index < count) {
      int64_t piece = list ? list[index] : index;
      atomic_store(&hand->since, 0);
      atomic_store(&hand->piece, piece);
      if (atomic_compare_exchange_weak(next, &index, index + 1)) return piece;
   }
   atomic_store(&hand->piece, -1);
   return -1;
}

/* What a thread of the worker does. */
static void *labour(void *argument)
{
   int thread = (int)(intptr_t)argument;
   struct hand *hand = &board->hands[thread];
   while (!atomic_load(&board->stop)) {
      int64_t piece;
      if (crew->alone >= 0) {
         piece = crew->alone;
         atomic_store(&hand->since, 0);
         atomic_store(&hand->piece, piece);
      } else {
         piece = take(hand, &board->again_next, board->again_count, board->again);
         if (piece < 0) piece = take(hand, &board->next, crew->pieces, NULL);
         if (piece < 0) break;
      }
      if (!crew->done(crew->context, piece)) {
         int code = crew->work(crew->context, thread, piece);
         if (code > 0) {
            int none = 0;
            atomic_compare_exchange_strong(&board->failure, &none, code);
            atomic_store(&board->stop, 1);
            break;
         }
         if (code < 0) break;
         atomic_fetch_add(&board->finished, 1);
      }
      atomic_store(&hand->piece, -1);
      atomic_store(&hand->since, 0);
      if (crew->alone >= 0) break;
   }
   return NULL;
}

/* In the worker: let the supervisor stop all. */
static void pass_on(int number)
{
   kill(getppid(), number);
}

/* The worker; does not return. */
static void work(int threads, pid_t parent)
{
#ifdef __linux__
   prctl(PR_SET_PDEATHSIG, SIGKILL);
#endif
   if (getppid() != parent) _exit(1);
   for (int i = 1; i < NSIG; ++i) {
      if (sigismember(&requests, i) == 1) signal(i, SIG_IGN);
   }
   signal(SIGPIPE, SIG_IGN);
   signal(SIGXFSZ, SIG_IGN);
   /* A limit of CPU time is that of each process. */
   if (sigismember(&requests, SIGXCPU) == 1) signal(SIGXCPU, pass_on);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
   /* Nobody wants a thousand backtraces; their first line goes into the row of the case. */
   static const int crashes[] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGTRAP, SIGSYS};
   for (size_t i = 0; i < sizeof crashes / sizeof *crashes; ++i) signal(crashes[i], SIG_DFL);
   struct rlimit none = {0, 0};
   setrlimit(RLIMIT_CORE, &none);
   if (crew->words >= 0) dup2(crew->words, STDERR_FILENO);
#endif
   sigset_t set = requests;
   sigaddset(&set, SIGCHLD);
   sigprocmask(SIG_UNBLOCK, &set, NULL);

   pthread_t *others = calloc((size_t)threads, sizeof *others);
   pthread_attr_t attributes;
   pthread_attr_init(&attributes);
   pthread_attr_setstacksize(&attributes, stack_size);
   int started = 0;
   for (int i = 0; others && i < threads; ++i) {
      if (pthread_create(&others[started], &attributes, labour, (void *)(intptr_t)i) != 0) break;
      ++started;
   }
   /* One thread is enough to go on. */
   if (started == 0) labour((void *)(intptr_t)0);
   for (int i = 0; i < started; ++i) pthread_join(others[i], NULL);
   atomic_store(&board->complete, 1);
   contensou_system_leave(0);
}

/* Hand whose piece is long beyond its limit; -1 if there is none. */
static int find_hung(int threads)
{
   /* Without a limit it is the largest number there is. */
   if (crew->time_limit > 1e9) return -1;
   double most = crew->time_limit * (1.0 + grace_share) + grace;
   int64_t time = now();
   for (int i = 0; i < threads; ++i) {
      int64_t since = atomic_load(&board->hands[i].since);
      if (since > 0 && (double)(time - since) * 1e-9 > most) return i;
   }
   return -1;
}

/* Start a worker and wait for its end. */
static int supervise(int threads, struct ending *ending)
{
   memset(ending, 0, sizeof *ending);
   ending->hung = -1;
   atomic_store(&board->complete, 0);
   for (int i = 0; i < threads; ++i) {
      atomic_store(&board->hands[i].piece, -1);
      atomic_store(&board->hands[i].since, 0);
   }
   if (crew->words >= 0 && ftruncate(crew->words, 0) == 0) lseek(crew->words, 0, SEEK_SET);
   pid_t parent = getpid();
   pid_t worker = fork();
   if (worker < 0) return errno;
   if (worker == 0) work(threads, parent);

   sigset_t set = requests;
   sigaddset(&set, SIGCHLD);
   const struct timespec while_working = {0, 100000000}, while_leaving = {0, 10000000};
   int64_t stop_time = 0;
   for (;;) {
      int code = 0;
      pid_t found = waitpid(worker, &code, WNOHANG);
      if (found == worker) {
         ending->complete = WIFEXITED(code) && WEXITSTATUS(code) == 0 &&
            atomic_load(&board->complete);
         if (WIFSIGNALED(code)) ending->signal = WTERMSIG(code);
         if (WIFEXITED(code)) ending->status = WEXITSTATUS(code);
         return 0;
      }
      if (found < 0 && errno != EINTR) return errno;
      crew->look(crew->context, atomic_load(&board->finished));
      int caught = sigtimedwait(&set, NULL, stop_time ? &while_leaving : &while_working);
      if (caught > 0 && caught != SIGCHLD) stop_seen = 1;
      if (stop_seen && stop_time == 0) {
         atomic_store(&board->stop, 1);
         stop_time = now();
      }
      if (stop_time && (double)(now() - stop_time) * 1e-9 > farewell) kill(worker, SIGKILL);
      if (!stop_time && ending->hung < 0) {
         ending->hung = find_hung(threads);
         if (ending->hung >= 0) {
            kill(worker, SIGKILL);
            /* Which pieces were in hand must not change any more. */
            while (waitpid(worker, &code, 0) < 0 && errno == EINTR) continue;
            ending->signal = SIGKILL;
            return 0;
         }
      }
   }
}

/* How a worker ended, in words, with the first line that it wrote. */
static void explain(const struct ending *ending, char *text)
{
   char line[256] = "";
   if (crew->words >= 0) {
      ssize_t got = pread(crew->words, line, sizeof line - 1, 0);
      line[got > 0 ? got : 0] = '\0';
      size_t skipped = strspn(line, " \n");
      memmove(line, line + skipped, strlen(line + skipped) + 1);
      line[strcspn(line, "\n")] = '\0';
   }
   if (ending->signal) {
      snprintf(text, reason_size, "%s%s%s", strsignal(ending->signal), line[0] ? ": " : "", line);
   } else {
      snprintf(text, reason_size, "exit status %d%s%s", ending->status, line[0] ? ": " : "", line);
   }
}

/* Pieces in the hands of a worker that has ended, without those that are done: each once. */
static int collect(int threads, int64_t *pieces, int *hands)
{
   int count = 0;
   for (int i = 0; i < threads; ++i) {
      int64_t piece = atomic_load(&board->hands[i].piece);
      if (piece < 0 || crew->done(crew->context, piece)) continue;
      int known = 0;
      for (int j = 0; j < count; ++j) known = known || pieces[j] == piece;
      if (known) continue;
      pieces[count] = piece;
      hands[count++] = i;
   }
   return count;
}

/* Do a piece in a worker of its own until it is done or has shown that it cannot be. */
static int do_alone(int64_t piece)
{
   struct ending ending;
   char text[reason_size];
   for (int tries = 1;; ++tries) {
      crew->alone = piece;
      int code = supervise(1, &ending);
      crew->alone = -1;
      if (code) return code;
      if (stop_seen || atomic_load(&board->failure) || ending.complete) return 0;
      if (crew->done(crew->context, piece)) return 0;
      if (ending.hung >= 0) return crew->lost(crew->context, piece, 1, "");
      /* From outside, or as memory was short: that may have meant another piece. */
      if (ending.signal == SIGKILL && tries < tries_alone) continue;
      explain(&ending, text);
      return crew->lost(crew->context, piece, 0, text);
   }
}

/* All workers, one after the other. */
static int run_all(void)
{
   int64_t pieces[most_threads], before = 0;
   int hands[most_threads];
   int idle = 0;
   for (;;) {
      struct ending ending;
      if (contensou_crew_stop_requested()) return crew_stopped;
      int code = supervise(crew->threads, &ending);
      if (code) return code;
      contensou_crew_stop_requested();
      if (atomic_load(&board->failure)) return atomic_load(&board->failure);
      if (stop_seen) return crew_stopped;
      if (ending.complete) return crew_complete;

      int count = collect(crew->threads, pieces, hands);
      int64_t progress = atomic_load(&board->finished) + atomic_load(&board->next);
      idle = count == 0 && progress == before ? idle + 1 : 0;
      before = progress;
      if (idle >= deaths_idle) {
         explain(&ending, crew->reason);
         return crew_broken;
      }
      /* What is left of the pieces to do again stays there. */
      int64_t left = board->again_count - atomic_load(&board->again_next);
      int64_t kept = 0;
      if (left > 0) memmove(board->again, board->again + atomic_load(&board->again_next),
         (size_t)left * sizeof *board->again);
      else left = 0;
      board->again_count = left;
      atomic_store(&board->again_next, 0);
      for (int i = 0; i < count; ++i) {
         int listed = pieces[i] >= atomic_load(&board->next);
         for (int64_t j = 0; j < left; ++j) listed = listed || board->again[j] == pieces[i];
         /* Shown in hand, but not taken. */
         if (listed) continue;
         code = 0;
         if (ending.hung == hands[i]) {
            code = crew->lost(crew->context, pieces[i], 1, "");
         } else if (ending.hung >= 0) {
            pieces[kept++] = pieces[i];
         } else {
            code = do_alone(pieces[i]);
         }
         if (code) return code;
         if (atomic_load(&board->failure)) return atomic_load(&board->failure);
         if (stop_seen) return crew_stopped;
      }
      /* There is room: all of them were in hand or waited for one of as many threads. */
      for (int64_t i = 0; i < kept && board->again_count < most_threads; ++i)
         board->again[board->again_count++] = pieces[i];
   }
}

int contensou_crew_run(void *context, int64_t pieces, int threads, double time_limit,
   work_function *work, done_function *done, lost_function *lost, look_function *look,
   char *reason)
{
   struct crew mine = {.context = context, .pieces = pieces, .time_limit = time_limit,
      .work = work, .done = done, .lost = lost, .look = look, .reason = reason, .alone = -1};
   reason[0] = '\0';
   mine.threads = threads < 1 ? 1 : threads > most_threads ? most_threads : threads;
   board = mmap(NULL, sizeof *board, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
   if (board == MAP_FAILED) {
      board = NULL;
      return errno;
   }
   mine.words = memfd_create("contensou worker", MFD_CLOEXEC);
   crew = &mine;
   contensou_crew_hold_signals();
   int code = run_all();
   look(context, atomic_load(&board->finished));
   crew = NULL;
   munmap(board, sizeof *board);
   board = NULL;
   if (mine.words >= 0) close(mine.words);
   return code;
}
