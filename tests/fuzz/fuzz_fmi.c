/* Random calls of an FMU, in any order and with any arguments: none may crash (run this under
   sanitizers). Usage: fuzz_fmi CALLS SEED RESOURCES GUID REALS STATES. Prints how many calls were
   answered how. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"

enum { INSTANCES = 4, KEPT = 6, MOST = 8, ROOM = 64 };
static uint64_t seed;
static unsigned messages;

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

static void logger(fmi2ComponentEnvironment e, fmi2String name, fmi2Status status,
                   fmi2String category, fmi2String message, ...) {
    (void)e;
    if (!name || !*message || strncmp(category, "logStatus", 9) != 0 || status > fmi2Error) abort();
    ++messages;
}

typedef struct {
    unsigned reals, states;
    fmi2ValueReference r[MOST], q[MOST];
    size_t n, k;
    double v[ROOM], w[ROOM];
    int order[MOST];
} arguments;

static void fill(arguments *a) {
    a->n = below(MOST);
    a->k = below(MOST);
    for (int i = 0; i < MOST; ++i) {
        a->r[i] = below(a->reals + (below(9) == 0));
        a->q[i] = below(a->reals + (below(9) == 0));
        a->order[i] = (int)below(3) + (below(9) != 0 && 1) - (below(9) == 0);
    }
    for (int i = 0; i < ROOM; ++i) a->v[i] = number();
}

static fmi2Status exchange(fmi2Component c, arguments *a) {
    fmi2EventInfo info;
    fmi2Boolean x, y;
    const size_t n = below(5) ? a->states : a->n;
    switch (below(10)) {
        case 0: return fmi2EnterEventMode(c);
        case 1: return fmi2NewDiscreteStates(c, below(9) ? &info : NULL);
        case 2: return fmi2EnterContinuousTimeMode(c);
        case 3: return fmi2CompletedIntegratorStep(c, 1, &x, below(9) ? &y : NULL);
        case 4: return fmi2SetTime(c, number());
        case 5: return fmi2SetContinuousStates(c, below(9) ? a->v : NULL, n);
        case 6: return fmi2GetDerivatives(c, a->w, n);
        case 7: return fmi2GetContinuousStates(c, a->w, n);
        case 8: return fmi2GetNominalsOfContinuousStates(c, a->w, n);
        default: return fmi2GetEventIndicators(c, a->w, below(2));
    }
}

static fmi2Status step(fmi2Component c, arguments *a) {
    fmi2Status status;
    fmi2Integer i;
    fmi2Boolean b;
    fmi2String s;
    double t = 0.0;
    switch (below(9)) {
        case 0: return fmi2SetRealInputDerivatives(c, a->r, a->n, a->order, a->v);
        case 1: return fmi2GetRealOutputDerivatives(c, a->r, a->n, a->order, a->w);
        case 2: return fmi2CancelStep(c);
        case 3: return fmi2GetStatus(c, fmi2DoStepStatus, &status);
        case 4: return fmi2GetIntegerStatus(c, fmi2DoStepStatus, &i);
        case 5: return fmi2GetBooleanStatus(c, (fmi2StatusKind)below(4), &b);
        case 6: return fmi2GetStringStatus(c, fmi2PendingStatus, &s);
        default:
            fmi2GetRealStatus(c, fmi2LastSuccessfulTime, &t);
            return fmi2DoStep(c, below(9) ? t : number(), below(9) ? 0.01 : number(), 1);
    }
}

static fmi2Status variables(fmi2Component c, arguments *a) {
    fmi2Integer i[MOST] = {0};
    fmi2String s[MOST];
    switch (below(10)) {
        case 0: return fmi2GetInteger(c, a->r, a->n, i);
        case 1: return fmi2SetInteger(c, a->r, a->n, i);
        case 2: return fmi2GetBoolean(c, a->r, a->n, i);
        case 3: return fmi2SetBoolean(c, a->r, a->n, i);
        case 4: return fmi2GetString(c, a->r, a->n, s);
        case 5: return fmi2GetReal(c, below(9) ? a->r : NULL, a->n, a->w);
        case 6:
            return fmi2GetDirectionalDerivative(c, a->r, a->n, a->q, a->k, a->v,
                                                below(9) ? a->w : NULL);
        default: return fmi2SetReal(c, a->r, a->n ? 1 : 0, below(9) ? a->v : NULL);
    }
}

static fmi2Status phases(fmi2Component c) {
    const fmi2String categories[] = {"logStatusError", "nonsense"};
    switch (below(16)) {
        case 0:
            return fmi2SetupExperiment(c, (int)below(2), number(), 0.0, below(9) == 0, number());
        case 1: return fmi2Terminate(c);
        case 2: return fmi2Reset(c);
        case 3: return fmi2SetDebugLogging(c, 1, below(3), categories);
        case 4: case 5: case 6: return fmi2EnterInitializationMode(c);
        default: return fmi2ExitInitializationMode(c);
    }
}

static fmi2Status states(fmi2Component c, fmi2FMUstate *kept) {
    static fmi2Byte bytes[4096];
    size_t size = 0;
    fmi2FMUstate *one = &kept[below(KEPT)], made = NULL;
    switch (below(5)) {
        case 0: return fmi2GetFMUstate(c, one);
        case 1: return fmi2SetFMUstate(c, *one);
        case 2: return fmi2FreeFMUstate(c, one);
        default:
            if (fmi2SerializedFMUstateSize(c, *one, &size) != fmi2OK || size > sizeof bytes)
                return fmi2Error;
            fmi2SerializeFMUstate(c, *one, bytes, size);
            if (below(2)) bytes[below((unsigned)size)] ^= (fmi2Byte)(1 + below(100));
            if (fmi2DeSerializeFMUstate(c, bytes, size - (below(9) == 0), &made) != fmi2OK)
                return fmi2Error;
            fmi2FreeFMUstate(c, one);
            *one = made;
            return fmi2OK;
    }
}

int main(int count, char **words) {
    if (count != 7) return 2;
    seed = strtoull(words[2], NULL, 10) * UINT64_C(0x9e3779b97f4a7c15) + 1;
    const fmi2CallbackFunctions callbacks = {logger, calloc, free, NULL, NULL};
    arguments a = {.reals = (unsigned)atoi(words[5]), .states = (unsigned)atoi(words[6])};
    fmi2Component all[INSTANCES] = {NULL};
    fmi2FMUstate kept[KEPT] = {NULL};
    unsigned long answers[fmi2Pending + 1] = {0};
    for (long i = atol(words[1]); i > 0; --i) {
        fmi2Component *c = &all[below(INSTANCES)];
        if (!*c) {
            const char *guid = below(9) ? words[4] : "{wrong}";
            *c = fmi2Instantiate("one", (fmi2Type)below(2), guid, words[3], &callbacks, 0, 1);
            continue;
        }
        if (below(2000) == 0) {
            fmi2FreeInstance(*c);
            *c = NULL;
            continue;
        }
        fill(&a);
        const unsigned kind = below(10);
        ++answers[kind < 2   ? phases(*c)
                  : kind < 3 ? states(*c, kept)
                  : kind < 6 ? variables(*c, &a)
                  : kind < 8 ? exchange(*c, &a)
                             : step(*c, &a)];
    }
    fmi2Component last =
        fmi2Instantiate("last", fmi2CoSimulation, words[4], words[3], &callbacks, 0, 0);
    for (int i = 0; i < KEPT; ++i) fmi2FreeFMUstate(last, &kept[i]);
    for (int i = 0; i < INSTANCES; ++i) fmi2FreeInstance(all[i]);
    fmi2FreeInstance(last);
    fmi2FreeInstance(NULL);
    printf("%lu ok, %lu discarded, %lu errors, %u messages\n", answers[fmi2OK],
           answers[fmi2Discard], answers[fmi2Error], messages);
    return 0;
}
