/* Registers of the machine on which the program runs. */

int contensou_numbers_of_register(void);

/* How many numbers they hold, of those for which there are kernels (src/meson.build). */
int contensou_numbers_of_register(void)
{
#if defined(__x86_64__) && defined(__GNUC__)
   if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
      return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl")
            && __builtin_cpu_supports("avx512dq") ? 8 : 4;
#endif
   return 2;
}
