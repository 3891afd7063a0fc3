/* How functions of FMI 3.0 begin: `self` is the instance that they are called with. */
#ifndef M4E_FMI3_CALLS_H
#define M4E_FMI3_CALLS_H

#include "fmi3.h"
#include "instance.h"

#define ENTER(phases)                                                                             \
    instance *c = self;                                                                           \
    if (!allowed(c, phases, __func__)) return fmi3Error
#define NEEDS(condition, text)                                                                    \
    if (!(condition)) return (fmi3Status)tell(c, FMI_ERROR, "%s: " text, __func__)
#define NEEDS_ANSWERS(condition) NEEDS(condition, "there is nowhere to put the answer")
#define NEEDS_EXCHANGE                                                                            \
    NEEDS(c->now.type == MODEL_EXCHANGE, "this belongs to model exchange")

#endif
