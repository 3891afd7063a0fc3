/* Tells a kink or a jump in a course of equal steps from what went before it.

   Of a smooth course the fourth differences are small, of the order H^4, and change little from one
   step to the next; a kink in its k-th derivative makes one of the order H^k. A value is *rough at
   once* where its fourth difference is more than SUDDEN times its level, a maximum that decays, and
   more than its gate. Where a course stays rough, the level grows until that is nothing new. */
#include <math.h>

#include "clones.h"
#include "loop.h"

static const double SUDDEN = 4.0, DECAY = 0.95, GROWTH = 1.5, SHARE = 1.0 / 16;

M4E_CLONES double m4e_monitor(uint32_t count, const double *now, const double *gate,
                              double *past) {
    double *const value = past, *const first = past + count, *const second = first + count,
           *const third = second + count, *const level = third + count,
           *const largest = level + count, *const wait = largest + count;
    const double told = *wait > 0.0 ? INFINITY : SUDDEN, decay = *wait > 0.0 ? 0.0 : DECAY;
    double found = 0.0;
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC ivdep
#endif
    for (uint32_t i = 0; i < count; ++i) {
        const double d1 = now[i] - value[i], d2 = d1 - first[i], d3 = d2 - second[i];
        const double rough = fabs(d3 - third[i]), usual = level[i];
        const double least = told * usual > gate[i] ? told * usual : gate[i];
        const int sudden = rough > least && decay > 0.0;
        const double grown = GROWTH * usual > SHARE * rough ? GROWTH * usual : SHARE * rough;
        const double calm = rough > decay * usual ? rough : decay * usual;
        value[i] = now[i], first[i] = d1, second[i] = d2, third[i] = d3;
        level[i] = sudden ? grown : calm;
        largest[i] = decay > 0.0 && rough > largest[i] ? rough : largest[i];
        found += sudden ? 1.0 : 0.0;
    }
    if (*wait > 0.0) *wait -= 1.0;
    return found;
}
