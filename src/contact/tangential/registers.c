/* Registers of the machine on which the program runs. */

int contensou_wide_registers(void);

/* Whether it has those for which `abreast_wide` is compiled (src/meson.build). */
int contensou_wide_registers(void)
{
#if defined(__x86_64__) && defined(__GNUC__)
   return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
#else
   return 0;
#endif
}
