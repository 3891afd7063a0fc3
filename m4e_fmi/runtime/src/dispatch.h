/* How the interpreters get from one instruction to the next. Every operation jumps straight to its
   successor where the compiler has computed goto: the processor then predicts each jump by itself,
   which is three times faster than one `switch` for all. Like operations often follow each other:
   asking for that first saves a quarter. Words of an instruction are read two at a time: what the
   processor can read at once limits the speed of all else. */
#ifndef M4E_DISPATCH_H
#define M4E_DISPATCH_H

#include "internal.h"

typedef uint64_t words; /* two neighbouring ones */

static inline words words_at(const uint32_t *place) {
    words w;
    memcpy(&w, place, sizeof w);
    return w;
}

static inline uint32_t left_of(words w) { return (uint32_t)w; }
static inline uint32_t right_of(words w) { return (uint32_t)(w >> 32); }

/* Of the present instruction: its code is `now`, its d is `place`; `ab`, `ef` as they are read. */
#define M4E_READ_NOW                                                                              \
    const words both = words_at(&code->code);                                                     \
    now = left_of(both);                                                                          \
    place = right_of(both);
#define M4E_READ_AB const words ab = words_at(&code->a);
#define M4E_READ_EF const words ef = words_at(&code[1].a);
#define M4E_A left_of(ab)
#define M4E_B right_of(ab)
#define M4E_C (now >> 8)
#define M4E_E left_of(ef)
#define M4E_F right_of(ef)

#if defined(__GNUC__) && !defined(M4E_NO_COMPUTED_GOTO)
#pragma GCC diagnostic ignored "-Wpedantic"
#define M4E_TARGET(name, expression) [OP_##name] = &&at_##name,
#define M4E_TARGETS                                                                               \
    static const void *const target[OPS] = {                                                      \
        M4E_UNARY(M4E_TARGET) M4E_BINARY(M4E_TARGET) M4E_FUSED(M4E_TARGET)                        \
        M4E_CHAINED(M4E_TARGET) M4E_PAIRED(M4E_TARGET)                                            \
        [OP_SINCOS] = &&at_SINCOS, [OP_END] = &&at_END};
#define M4E_RUN                                                                                   \
    M4E_TARGETS                                                                                   \
    uint32_t now;                                                                                 \
    size_t place;                                                                                 \
    M4E_SKIP(0)
#define M4E_SKIP(count)                                                                           \
    {                                                                                             \
        code += count;                                                                            \
        M4E_READ_NOW                                                                              \
        goto *target[now & 255];                                                                  \
    }
#define M4E_NEXT(name, count)                                                                     \
    {                                                                                             \
        code += count;                                                                            \
        M4E_READ_NOW                                                                              \
        if ((now & 255) == OP_##name) goto at_##name;                                             \
        goto *target[now & 255];                                                                  \
    }
#define M4E_CASE(name) at_##name:
#else
#define M4E_RUN                                                                                   \
    uint32_t now;                                                                                 \
    size_t place;                                                                                 \
    for (;;) switch (now = code->code, place = code->d, now & 255)
#define M4E_SKIP(count)                                                                           \
    {                                                                                             \
        code += count;                                                                            \
        continue;                                                                                 \
    }
#define M4E_NEXT(name, count) M4E_SKIP(count)
#define M4E_CASE(name) case OP_##name:
#endif

#endif
