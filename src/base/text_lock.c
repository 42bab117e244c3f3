/* One thread at a time handles texts; see text_lock.f90. A thread may lock again what it holds. */
#define _GNU_SOURCE
#include <pthread.h>

void contensou_text_lock(void);
void contensou_text_unlock(void);

static pthread_mutex_t one_at_a_time;
static pthread_once_t prepared = PTHREAD_ONCE_INIT;

static void prepare(void)
{
   pthread_mutexattr_t attributes;
   pthread_mutexattr_init(&attributes);
   pthread_mutexattr_settype(&attributes, PTHREAD_MUTEX_RECURSIVE);
   pthread_mutex_init(&one_at_a_time, &attributes);
   pthread_mutexattr_destroy(&attributes);
}

void contensou_text_lock(void)
{
   pthread_once(&prepared, prepare);
   pthread_mutex_lock(&one_at_a_time);
}

void contensou_text_unlock(void)
{
   pthread_mutex_unlock(&one_at_a_time);
}
