/*
 * The first thing that runs in the executable, before any library begins: requests to stop are held
 * back until a command heeds them or lets them come.
 */
void contensou_system_hold_signals(void);

#ifdef __linux__
__attribute__((section(".preinit_array"), used)) static void (*const first)(void) =
   contensou_system_hold_signals;
#else
__attribute__((constructor)) static void first(void)
{
   contensou_system_hold_signals();
}
#endif
