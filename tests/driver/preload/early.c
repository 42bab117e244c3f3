/* Loaded into the program by test_signals.py: a signal comes before anything else in it runs
   (EARLY=library) or as its main program has just begun (EARLY=main). SIGNAL is its number. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>

void _gfortran_set_options(int count, int options[]);

static void come(const char *when)
{
   const char *wanted = getenv("EARLY");
   if (wanted && strcmp(wanted, when) == 0) raise(atoi(getenv("SIGNAL")));
}

__attribute__((constructor)) static void loaded(void)
{
   come("library");
}

void _gfortran_set_options(int count, int options[])
{
   void (*original)(int, int[]) = (void (*)(int, int[]))dlsym(RTLD_NEXT, "_gfortran_set_options");
   original(count, options);
   come("main");
}
