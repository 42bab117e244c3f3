/* Loaded into the program by test_sweep.py: cases whose largest step has one of three values crash,
   hang or end the program. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <math.h>
#include <stdlib.h>
#include <unistd.h>

int CVodeSetMaxStep(void *memory, double largest);

int CVodeSetMaxStep(void *memory, double largest)
{
   int (*original)(void *, double) = (int (*)(void *, double))dlsym(RTLD_NEXT, "CVodeSetMaxStep");
   if (fabs(largest - 0.0101) < 1e-12) *(volatile int *)0 = 1;
   if (fabs(largest - 0.0102) < 1e-12) for (;;) pause();
   if (fabs(largest - 0.0103) < 1e-12) _exit(7);
   if (fabs(largest - 0.0104) < 1e-12) abort();
   return original(memory, largest);
}
