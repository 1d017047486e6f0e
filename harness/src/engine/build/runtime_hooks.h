// Included before everything else: text the runtime prints goes to the instance that printed it.
#ifndef HOVERLOCK_RUNTIME_HOOKS_H_
#define HOVERLOCK_RUNTIME_HOOKS_H_
extern int hv_printf(const char* format, ...);
#define VL_PRINTF hv_printf
#define VL_USER_FINISH 1
#define VL_USER_STOP 1
#define VL_USER_FATAL 1
#define VL_USER_WARN 1
#endif
