/* How the interpreters get from one instruction to the next. Every operation jumps straight to its
   successor where the compiler has computed goto: the processor then predicts each jump by itself,
   which is three times faster than one `switch` for all. Like operations often follow each other:
   asking for that first saves a quarter. */
#ifndef M4E_DISPATCH_H
#define M4E_DISPATCH_H

#include "internal.h"

#if defined(__GNUC__) && !defined(M4E_NO_COMPUTED_GOTO)
#pragma GCC diagnostic ignored "-Wpedantic"
#define M4E_TARGET(name, expression) [OP_##name] = &&at_##name,
#define M4E_RUN                                                                                   \
    static const void *const target[OPS] = {                                                      \
        M4E_UNARY(M4E_TARGET) M4E_BINARY(M4E_TARGET) M4E_FUSED(M4E_TARGET)                        \
        [OP_SINCOS] = &&at_SINCOS, [OP_END] = &&at_END};                                          \
    M4E_DISPATCH
#define M4E_DISPATCH goto *target[code->code & 255];
#define M4E_NEXT(name)                                                                            \
    ++code;                                                                                       \
    if ((code->code & 255) == OP_##name) goto at_##name;                                          \
    M4E_DISPATCH
#define M4E_CASE(name) at_##name:
#else
#define M4E_RUN for (;;) switch (code->code & 255)
#define M4E_DISPATCH continue;
#define M4E_NEXT(name) ++code; continue;
#define M4E_CASE(name) case OP_##name:
#endif

#endif
