/* Loaded into the program by test_safe_files.py: a disk that takes half a second to save the entry
   of a file in its folder. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <sys/stat.h>
#include <unistd.h>

int fsync(int descriptor)
{
   int (*original)(int) = (int (*)(int))dlsym(RTLD_NEXT, "fsync");
   struct stat info;
   if (fstat(descriptor, &info) == 0 && S_ISDIR(info.st_mode)) usleep(500000);
   return original(descriptor);
}
