/* Random calls of an FMI 3.0 FMU, in any order and with any arguments, also within steps: none may
   crash (run this under sanitizers). Usage: fuzz_fmi3 CALLS SEED RESOURCES TOKEN VARIABLES STATES.
   Prints how many calls were answered how. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi3Functions.h"

enum { INSTANCES = 4, KEPT = 6, MOST = 8, ROOM = 64, VARIABLES = 64 };
static uint64_t seed;
static unsigned messages, updates;

static unsigned below(unsigned limit) { /* xorshift */
    seed ^= seed << 13;
    seed ^= seed >> 7;
    seed ^= seed << 17;
    return (unsigned)(seed >> 32) % limit;
}

static double number(void) {
    const double odd[] = {0.0, 1.0, -1.0, NAN, INFINITY, 0.01};
    return below(4) == 0 ? odd[below(6)] : (double)below(2001) / 1000.0 - 1.0;
}

static void logger(fmi3InstanceEnvironment e, fmi3Status status, fmi3String category,
                   fmi3String message) {
    (void)e;
    if (!*message || strncmp(category, "logStatus", 9) != 0 || status > fmi3Error) abort();
    ++messages;
}

typedef struct {
    unsigned variables, states;
    fmi3ValueReference r[MOST], q[MOST];
    size_t n, k, numbers, others; /* references, and numbers that may be right for them */
    double v[ROOM], w[ROOM];
    fmi3Int32 order[MOST];
} arguments;

static arguments a;
static size_t elements[VARIABLES + 1]; /* elements of each variable; 1 of what is none */
static fmi3FMUState kept[KEPT];

static void fill(void) {
    a.n = below(MOST);
    a.k = below(MOST);
    for (int i = 0; i < MOST; ++i) {
        a.r[i] = below(a.variables + (below(9) == 0));
        a.q[i] = below(a.variables + (below(9) == 0));
        a.order[i] = (fmi3Int32)below(3) + (below(9) != 0) - (below(9) == 0);
    }
    a.numbers = a.others = 0;
    for (size_t i = 0; i < a.n; ++i) a.numbers += elements[a.r[i]];
    for (size_t i = 0; i < a.k; ++i) a.others += elements[a.q[i]];
    if (below(9) == 0) a.numbers = below(5);
    if (below(9) == 0) a.others = below(5);
    if (below(2000) == 0) a.numbers = SIZE_MAX - below(9);
    for (int i = 0; i < ROOM; ++i) a.v[i] = number();
}

static fmi3Status exchange(fmi3Instance c) {
    fmi3Boolean x, y, z, b[2];
    double t;
    size_t count;
    const size_t n = below(5) ? a.states : a.n;
    switch (below(14)) {
        case 0: return fmi3EnterEventMode(c);
        case 1: return fmi3UpdateDiscreteStates(c, &x, &y, &z, b, b + 1, below(9) ? &t : NULL);
        case 2: return fmi3EnterContinuousTimeMode(c);
        case 3: return fmi3CompletedIntegratorStep(c, 1, &x, below(9) ? &y : NULL);
        case 4: return fmi3SetTime(c, number());
        case 5: return fmi3SetContinuousStates(c, below(9) ? a.v : NULL, n);
        case 6: return fmi3GetContinuousStateDerivatives(c, a.w, n);
        case 7: return fmi3GetContinuousStates(c, a.w, n);
        case 8: return fmi3GetNominalsOfContinuousStates(c, a.w, n);
        case 9: return fmi3GetNumberOfContinuousStates(c, below(9) ? &count : NULL);
        case 10: return fmi3GetNumberOfEventIndicators(c, below(9) ? &count : NULL);
        case 11: return fmi3EvaluateDiscreteStates(c);
        case 12: return fmi3EnterConfigurationMode(c);
        default: return fmi3GetEventIndicators(c, a.w, below(2));
    }
}

static fmi3Status of_other_types(fmi3Instance c) {
    uint64_t room[ROOM] = {0};
    fmi3Binary binary[MOST] = {NULL};
    fmi3IntervalQualifier how[MOST];
    switch (below(9)) {
        case 0: return fmi3GetFloat32(c, a.r, a.n, (fmi3Float32 *)room, a.n);
        case 1: return fmi3SetInt8(c, a.r, a.n, (fmi3Int8 *)room, a.n);
        case 2: return fmi3GetBoolean(c, a.r, a.n, (fmi3Boolean *)room, a.n);
        case 3: return fmi3GetBinary(c, a.r, a.n, (size_t *)room, binary, a.n);
        case 4: return fmi3GetClock(c, a.r, a.n, (fmi3Clock *)room);
        case 5: return fmi3GetIntervalDecimal(c, a.r, a.n, a.w, how);
        case 6: return fmi3SetShiftFraction(c, a.r, a.n, room, room);
        case 7: return fmi3ActivateModelPartition(c, a.r[0], number());
        default: return fmi3SetUInt64(c, a.r, a.n, room, a.n);
    }
}

static fmi3Status dependencies(fmi3Instance c) {
    size_t first[ROOM], last[ROOM], count = 0;
    fmi3ValueReference known[ROOM];
    fmi3DependencyKind kind[ROOM];
    const fmi3Status status =
        fmi3GetNumberOfVariableDependencies(c, a.r[0], below(9) ? &count : NULL);
    if (status != fmi3OK || count > ROOM) return status;
    return fmi3GetVariableDependencies(c, a.r[0], first, known, below(9) ? last : NULL, kind,
                                       count - (below(9) == 0 && count));
}

static fmi3Status variables(fmi3Instance c) {
    fmi3String s[MOST];
    const fmi3ValueReference *r = below(9) ? a.r : NULL;
    switch (below(11)) {
        case 0: return of_other_types(c);
        case 1: return fmi3GetString(c, below(2) ? &a.variables : a.r, 1, s, 1);
        case 2:
            return fmi3GetDirectionalDerivative(c, a.r, a.n, a.q, a.k, a.v, a.others,
                                                below(9) ? a.w : NULL, a.numbers);
        case 3:
            return fmi3GetAdjointDerivative(c, a.r, a.n, a.q, a.k, below(9) ? a.v : NULL,
                                            a.numbers, a.w, a.others);
        case 4: return fmi3GetOutputDerivatives(c, a.r, a.n, a.order, a.w, a.numbers);
        case 5: return dependencies(c);
        case 6: case 7: return fmi3GetFloat64(c, r, a.n, below(9) ? a.w : NULL, a.numbers);
        default: return fmi3SetFloat64(c, r, 1, below(9) ? a.v : NULL, elements[a.r[0]]);
    }
}

static fmi3Status phases(fmi3Instance c) {
    const fmi3String categories[] = {"logStatusError", "nonsense"};
    switch (below(16)) {
        case 0: return below(9) ? fmi3GetFMUState(c, &kept[0]) : fmi3Terminate(c);
        case 1: return fmi3Reset(c);
        case 2: return fmi3SetDebugLogging(c, 1, below(3), categories);
        case 3: return fmi3EnterStepMode(c);
        case 4: return fmi3ExitConfigurationMode(c);
        case 5: case 6: case 7: case 8:
            return fmi3EnterInitializationMode(c, below(9) == 0, number(), 0.0, below(9) == 0,
                                               number());
        default: return fmi3ExitInitializationMode(c);
    }
}

static fmi3Status states(fmi3Instance c) {
    static fmi3Byte bytes[4096];
    size_t size = 0;
    fmi3FMUState *one = &kept[below(KEPT)], made = NULL;
    switch (below(5)) {
        case 0: return fmi3GetFMUState(c, one);
        case 1: return fmi3SetFMUState(c, *one);
        case 2: return fmi3FreeFMUState(c, one);
        default:
            if (fmi3SerializedFMUStateSize(c, *one, &size) != fmi3OK || size > sizeof bytes)
                return fmi3Error;
            fmi3SerializeFMUState(c, *one, bytes, size);
            if (below(2)) bytes[below((unsigned)size)] ^= (fmi3Byte)(1 + below(100));
            if (fmi3DeserializeFMUState(c, bytes, size - (below(9) == 0), &made) != fmi3OK)
                return fmi3Error;
            fmi3FreeFMUState(c, one);
            *one = made;
            return fmi3OK;
    }
}

static fmi3Status step(fmi3Instance c) {
    static double t;
    fmi3Boolean x, y, z;
    double reached = t;
    if (below(9) == 0) t = below(9) ? 0.0 : number();
    const fmi3Status status = fmi3DoStep(c, t, below(9) ? 0.01 * (1 + below(90)) : number(), 1, &x,
                                         &y, below(99) ? &z : NULL, &reached);
    t = reached;
    return status;
}

static fmi3Status any(fmi3Instance c) {
    fill();
    const unsigned kind = below(10);
    return kind < 2   ? phases(c)
           : kind < 3 ? states(c)
           : kind < 6 ? variables(c)
           : kind < 8 ? exchange(c)
                      : step(c);
}

/* The environment is the place of the instance. */
static void update(fmi3InstanceEnvironment e, fmi3Float64 t, fmi3Boolean set, fmi3Boolean get,
                   fmi3Boolean finished, fmi3Boolean may_return, fmi3Boolean *early,
                   fmi3Float64 *early_time) {
    fmi3Instance c = *(fmi3Instance *)e;
    if (!set || !get || !finished || !isfinite(t)) abort();
    ++updates;
    for (unsigned n = below(3); n > 0; --n) any(c);
    if (below(50) == 0) fmi3FreeInstance(c);
    if (below(4)) return;
    *early = 1;
    if (below(3)) *early_time = below(2) ? number() : t + 0.001 * below(9);
    (void)may_return;
}

static fmi3Instance opened(fmi3Instance *place, char **words) {
    const char *token = below(9) ? words[4] : "{wrong}";
    if (below(2))
        return fmi3InstantiateModelExchange("one", token, words[3], 0, below(9) != 0, place,
                                            logger);
    fill();
    return fmi3InstantiateCoSimulation("one", token, words[3], 0, below(9) != 0, below(9) == 0,
                                       below(2), a.r, below(3), place, logger,
                                       below(3) ? update : NULL);
}

static void find_sizes(fmi3Instance c) {
    for (fmi3ValueReference r = 0; r <= a.variables; ++r) {
        elements[r] = ROOM / MOST;
        while (elements[r] > 1 && fmi3GetFloat64(c, &r, 1, a.w, elements[r]) != fmi3OK) --elements[r];
    }
}

int main(int count, char **words) {
    if (count != 7 || atoi(words[5]) > VARIABLES) return 2;
    seed = strtoull(words[2], NULL, 10) * UINT64_C(0x9e3779b97f4a7c15) + 1;
    a.variables = (unsigned)atoi(words[5]);
    a.states = (unsigned)atoi(words[6]);
    static fmi3Instance all[INSTANCES];
    fmi3Instance last =
        fmi3InstantiateModelExchange("last", words[4], words[3], 0, 0, NULL, logger);
    find_sizes(last);
    unsigned long answers[fmi3Fatal + 1] = {0};
    for (long i = atol(words[1]); i > 0; --i) {
        fmi3Instance *c = &all[below(INSTANCES)];
        if (!*c) {
            *c = opened(c, words);
        } else if (below(2000) == 0) {
            fmi3FreeInstance(*c);
            *c = NULL;
        } else {
            ++answers[any(*c)];
        }
    }
    for (int i = 0; i < KEPT; ++i) fmi3FreeFMUState(last, &kept[i]);
    for (int i = 0; i < INSTANCES; ++i) fmi3FreeInstance(all[i]);
    fmi3FreeInstance(last);
    fmi3FreeInstance(NULL);
    printf("%lu ok, %lu discarded, %lu errors, %u messages, %u updates\n", answers[fmi3OK],
           answers[fmi3Discard], answers[fmi3Error], messages, updates);
    return 0;
}
