/* The models of shell.c as FMI 3.0 FMUs for co-simulation; what is not here is in absent_3.c. */
#include "shell.c"

#include <stdarg.h>
#include <stdio.h>

#include "fmi3Functions.h"

#define STATUS_OF(status) ((fmi3Status)(status))

typedef struct {
    fmi3LogMessageCallback log;
    fmi3InstanceEnvironment environment;
} Receiver;

/* FMI 3.0's logger takes whole texts. */
static void tell(fmi2ComponentEnvironment to, fmi2String name, fmi2Status status,
                 fmi2String category, fmi2String format, ...) {
    char text[256];
    va_list rest;
    va_start(rest, format);
    vsnprintf(text, sizeof text, format, rest);
    va_end(rest);
    Receiver *r = to;
    r->log(r->environment, STATUS_OF(status), category, text);
}

fmi3Instance fmi3InstantiateCoSimulation(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
    fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early, const fmi3ValueReference required[],
    size_t n_required, fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
    fmi3IntermediateUpdateCallback update) {
#ifdef REFUSES
    if (events || early) {
        log(environment, fmi3Error, "logStatusError", "event mode is not supported");
        return NULL;
    }
#endif
    Receiver *r = malloc(sizeof *r);
    *r = (Receiver){log, environment};
    fmi2CallbackFunctions callbacks = {.logger = tell, .componentEnvironment = r};
    return fmi2Instantiate(name, fmi2CoSimulation, token, resources, &callbacks, 0, 0);
}
void fmi3FreeInstance(fmi3Instance c) {
    free(((Model *)c)->environment);
    fmi2FreeInstance(c);
}
fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean d, fmi3Float64 tolerance, fmi3Float64 t0, fmi3Boolean stops, fmi3Float64 t1) {
    ((Model *)c)->t = t0;
    return STATUS_OF(fmi2EnterInitializationMode(c));
}
fmi3Status fmi3ExitInitializationMode(fmi3Instance c) { return STATUS_OF(fmi2ExitInitializationMode(c)); }
fmi3Status fmi3Terminate(fmi3Instance c) { return STATUS_OF(fmi2Terminate(c)); }

fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Float64 v[], size_t n_values) {
    if (n != n_values) return fmi3Error;
    return STATUS_OF(fmi2GetReal(c, vr, n, v));
}
fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Float64 v[], size_t n_values) {
    if (n != n_values) return fmi3Error;
    return STATUS_OF(fmi2SetReal(c, vr, n, v));
}
fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 t, fmi3Float64 h, fmi3Boolean final, fmi3Boolean *event,
                      fmi3Boolean *end, fmi3Boolean *early, fmi3Float64 *last) {
    Model *m = c;
    fmi3Status status = STATUS_OF(fmi2DoStep(c, t, h, final));
    *event = *end = *early = fmi3False;
    *last = status == fmi3OK ? t + h : m->reached;
    return status;
}

#ifdef STATE
fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState *s) { return STATUS_OF(fmi2GetFMUstate(c, s)); }
fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState s) { return STATUS_OF(fmi2SetFMUstate(c, s)); }
fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *s) { return STATUS_OF(fmi2FreeFMUstate(c, s)); }
#endif
#ifdef BYTES
fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState s, size_t *n) { return STATUS_OF(fmi2SerializedFMUstateSize(c, s, n)); }
fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState s, fmi3Byte b[], size_t n) { return STATUS_OF(fmi2SerializeFMUstate(c, s, (fmi2Byte *)b, n)); }
fmi3Status fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte b[], size_t n, fmi3FMUState *s) { return STATUS_OF(fmi2DeSerializeFMUstate(c, (const fmi2Byte *)b, n, s)); }
#endif
#ifdef JACOBIAN
fmi3Status fmi3GetDirectionalDerivative(fmi3Instance c, const fmi3ValueReference z[], size_t nz, const fmi3ValueReference v[], size_t nv, const fmi3Float64 dv[], size_t n_dv, fmi3Float64 dz[], size_t n_dz) {
    if (n_dv != nv || n_dz != nz) return fmi3Error;
    return STATUS_OF(fmi2GetDirectionalDerivative(c, z, nz, v, nv, dv, dz));
}
#endif
