/* The floating-point environment, which code of others may have changed: rounding, flushing of
   subnormal numbers to zero, traps. */
#ifndef M4E_ENVIRONMENT_H
#define M4E_ENVIRONMENT_H

#include <fenv.h>

#if defined(__x86_64__) || defined(_M_X64)
#include <xmmintrin.h>
#endif

/* The default again. On x86-64 a look at the controls tells in a few nanoseconds that it is there
   (those of the x87 too, which Windows gives no meaning). */
static inline void m4e_default_environment(void) {
#if defined(__x86_64__) || defined(_M_X64)
    unsigned short x87 = 0x37f;
#if defined(__GNUC__) && !defined(_WIN32)
    __asm__ volatile("fnstcw %0" : "=m"(x87));
#endif
    if ((_mm_getcsr() & ~0x3fu) == 0x1f80 && x87 == 0x37f) return;
#endif
    fesetenv(FE_DFL_ENV);
}

#endif
