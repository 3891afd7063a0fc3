/* A bouncing ball as an FMI 3.0 FMU with event mode. Flights are exact parabolas.
 *
 * An impact ends a step early if that is allowed; with `announces` it is told as next event time
 * instead. After `last` impacts the ball asks for the end of the simulation. `kick` is a discrete
 * input, a velocity that is added when it changes; `push` an acceleration, held during a step. Without EVENTS there is no event mode: impacts
 * happen within steps. Everything in the wrong mode is an error with a text. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fmi3Functions.h"

enum { TIME, GRAVITY, RESTITUTION, ANNOUNCES, LAST, KICK, H, V, HITS, PUSH, N };
enum { INSTANTIATED = 1, INITIALIZATION = 2, EVENT = 4, STEP = 8 };
static const double start[N] = {[GRAVITY] = 10, [RESTITUTION] = 0.5, [LAST] = 1e9, [H] = 1};

typedef struct {
    double r[N], kicked;
    int mode, impact, events, early;
    fmi3LogMessageCallback log;
    fmi3InstanceEnvironment environment;
} Ball;

static fmi3Status refuse(Ball *b, const char *why) {
    b->log(b->environment, fmi3Error, "logStatusError", why);
    return fmi3Error;
}
#define ONLY_IN(modes) \
    Ball *b = c;       \
    if (!(b->mode & (modes))) return refuse(b, __func__)

/* Time until the ball is on the ground. */
static double left(const Ball *b) {
    double v = b->r[V], g = b->r[GRAVITY] - b->r[PUSH];
    if (b->r[H] <= 0 && v <= 0) return 0;
    return (v + sqrt(v * v + 2 * g * fmax(b->r[H], 0))) / g;
}
static void fly(Ball *b, double h) {
    double g = b->r[GRAVITY] - b->r[PUSH];
    b->r[H] += h * b->r[V] - h * h / 2 * g;
    b->r[V] -= h * g;
    b->r[TIME] += h;
}
static void bounce(Ball *b) {
    b->r[H] = 0;
    b->r[V] *= -b->r[RESTITUTION];
    b->r[HITS] += 1;
    b->impact = 0;
}

fmi3Instance fmi3InstantiateCoSimulation(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
    fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early, const fmi3ValueReference required[],
    size_t n_required, fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
    fmi3IntermediateUpdateCallback update) {
#ifndef EVENTS
    if (events) return NULL;
#endif
    Ball *b = calloc(1, sizeof *b);
    memcpy(b->r, start, sizeof start);
    b->mode = INSTANTIATED;
    b->events = events;
    b->early = early;
    b->log = log;
    b->environment = environment;
    return b;
}
void fmi3FreeInstance(fmi3Instance c) { free(c); }
fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean d, fmi3Float64 tolerance, fmi3Float64 t0, fmi3Boolean stops, fmi3Float64 t1) {
    ONLY_IN(INSTANTIATED);
    b->r[TIME] = t0;
    b->mode = INITIALIZATION;
    return fmi3OK;
}
fmi3Status fmi3ExitInitializationMode(fmi3Instance c) {
    ONLY_IN(INITIALIZATION);
    b->mode = b->events ? EVENT : STEP;
    b->kicked = b->r[KICK];
    return fmi3OK;
}
fmi3Status fmi3Terminate(fmi3Instance c) {
    ONLY_IN(EVENT | STEP);
    return fmi3OK;
}
fmi3Status fmi3EnterEventMode(fmi3Instance c) {
    ONLY_IN(STEP);
    if (!b->events) return refuse(b, "it was instantiated without event mode");
    b->mode = EVENT;
    return fmi3OK;
}
fmi3Status fmi3EnterStepMode(fmi3Instance c) {
    ONLY_IN(EVENT);
    if (b->impact || b->kicked != b->r[KICK]) return refuse(b, "there is an event to be handled");
    b->mode = STEP;
    return fmi3OK;
}
fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *again, fmi3Boolean *end, fmi3Boolean *nominals,
                                    fmi3Boolean *values, fmi3Boolean *defined, fmi3Float64 *next) {
    ONLY_IN(EVENT);
    *again = *nominals = *values = *defined = fmi3False;
    if (b->impact) {
        bounce(b);
        *again = *values = fmi3True; /* once more, so that importers have to ask */
    } else if (b->kicked != b->r[KICK]) {
        b->r[V] += b->r[KICK];
        b->kicked = b->r[KICK];
        *values = fmi3True;
    }
    *end = b->r[HITS] >= b->r[LAST];
    if (b->r[ANNOUNCES]) {
        *defined = fmi3True;
        *next = b->r[TIME] + left(b);
    }
    return fmi3OK;
}

fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Float64 v[], size_t n_values) {
    ONLY_IN(INITIALIZATION | EVENT | STEP);
    for (size_t i = 0; i < n; i++) v[i] = b->r[vr[i]];
    return fmi3OK;
}
fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Float64 v[], size_t n_values) {
    Ball *b = c;
    for (size_t i = 0; i < n; i++) {
        if (b->mode == STEP && b->events && vr[i] != PUSH) return refuse(b, "discrete variables are set in event mode");
        b->r[vr[i]] = v[i];
    }
    return fmi3OK;
}

fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 t, fmi3Float64 h, fmi3Boolean final, fmi3Boolean *event,
                      fmi3Boolean *end, fmi3Boolean *early, fmi3Float64 *last) {
    ONLY_IN(STEP);
    *event = *end = *early = fmi3False;
    if (b->impact) return refuse(b, "there is an event to be handled");
    if (fabs(t - b->r[TIME]) > 1e-12 * (1 + t)) return refuse(b, "that is not where the last step ended");
    double stop = t + h;
    if (!b->events && b->kicked != b->r[KICK]) {
        b->r[V] += b->r[KICK];
        b->kicked = b->r[KICK];
    }
    for (double wait; (wait = left(b)) <= stop - b->r[TIME] + 1e-15;) {
        fly(b, wait);
        b->impact = 1;
        if (!b->events) {
            bounce(b);
            if (b->r[HITS] >= b->r[LAST]) {
                *end = fmi3True;
                b->r[TIME] = stop;
                break;
            }
            continue;
        }
        *event = fmi3True;
        *last = b->r[TIME];
        *early = *last < stop;
        if (*early && !b->early) return refuse(b, "an impact within the step, which may not end early");
        return fmi3OK;
    }
    fly(b, stop - b->r[TIME]);
    b->r[TIME] = stop;
    *last = stop;
    return fmi3OK;
}

#ifdef STATE
fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState *s) {
    if (!*s) *s = malloc(sizeof(Ball));
    memcpy(*s, c, sizeof(Ball));
    return fmi3OK;
}
fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState s) {
    memcpy(c, s, sizeof(Ball));
    return fmi3OK;
}
fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *s) {
    free(*s);
    *s = NULL;
    return fmi3OK;
}
fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState s, size_t *n) {
    *n = sizeof(Ball);
    return fmi3OK;
}
fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState s, fmi3Byte b[], size_t n) {
    memcpy(b, s, n);
    return fmi3OK;
}
fmi3Status fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte b[], size_t n, fmi3FMUState *s) {
    *s = memcpy(malloc(n), b, n);
    return fmi3OK;
}
#endif
