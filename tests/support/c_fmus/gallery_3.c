/* An FMI 3.0 FMU with variables of all types. y = gain u, element by element, for `size` elements; z
 * is the same in Float32, w the sum of what the parameters of other types are, echo the bytes. */
#include <stdlib.h>
#include <string.h>

#include "fmi3Functions.h"

enum { MOST = 64, SIZE = 1, GAIN, U, Y, U32, Y32, SUM, I8, U8, I16, U16, I32, U32BITS, I64, U64, FLAG, WORD, BYTES, MODE, ECHO };

typedef struct {
    uint64_t size;
    double gain, u[MOST];
    float u32[2];
    double whole[MODE + 1]; /* of the other types, by value reference */
    uint8_t bytes[MOST];
    size_t n_bytes;
    int configuring, running;
} Gallery;

fmi3Instance fmi3InstantiateCoSimulation(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
    fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early, const fmi3ValueReference required[],
    size_t n_required, fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
    fmi3IntermediateUpdateCallback update) {
    Gallery *g = calloc(1, sizeof *g);
    g->size = 3;
    g->gain = 1;
    for (int i = 0; i < MOST; i++) g->u[i] = 0.5;
    return g;
}
void fmi3FreeInstance(fmi3Instance c) { free(c); }
fmi3Status fmi3EnterConfigurationMode(fmi3Instance c) { ((Gallery *)c)->configuring = 1; return fmi3OK; }
fmi3Status fmi3ExitConfigurationMode(fmi3Instance c) { ((Gallery *)c)->configuring = 0; return fmi3OK; }
fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean d, fmi3Float64 tolerance, fmi3Float64 t0, fmi3Boolean stops, fmi3Float64 t1) {
    ((Gallery *)c)->running = 1;
    return fmi3OK;
}
fmi3Status fmi3ExitInitializationMode(fmi3Instance c) { return fmi3OK; }
fmi3Status fmi3Terminate(fmi3Instance c) { return fmi3OK; }
fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 t, fmi3Float64 h, fmi3Boolean final, fmi3Boolean *event,
                      fmi3Boolean *end, fmi3Boolean *early, fmi3Float64 *last) {
    *event = *end = *early = fmi3False;
    *last = t + h;
    return fmi3OK;
}

fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Float64 v[], size_t n_values) {
    Gallery *g = c;
    size_t k = 0;
    if (!g->running) return fmi3Error;
    for (size_t i = 0; i < n; i++) {
        size_t size = vr[i] == U || vr[i] == Y ? g->size : 1;
        for (size_t j = 0; j < size; j++, k++) {
            if (k == n_values) return fmi3Error;
            v[k] = 0;
            if (vr[i] == GAIN) v[k] = g->gain;
            if (vr[i] == U) v[k] = g->u[j];
            if (vr[i] == Y) v[k] = g->gain * g->u[j];
            if (vr[i] == SUM)
                for (int w = I8; w <= MODE; w++) v[k] += g->whole[w];
        }
    }
    return k == n_values ? fmi3OK : fmi3Error;
}
fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Float64 v[], size_t n_values) {
    Gallery *g = c;
    size_t k = 0;
    for (size_t i = 0; i < n; i++) {
        size_t size = vr[i] == U ? g->size : 1;
        if (k + size > n_values) return fmi3Error;
        for (size_t j = 0; j < size; j++, k++)
            if (vr[i] == GAIN) g->gain = v[k];
            else g->u[j] = v[k];
    }
    return k == n_values ? fmi3OK : fmi3Error;
}
fmi3Status fmi3GetFloat32(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Float32 v[], size_t n_values) {
    Gallery *g = c;
    if (n_values != 2 * n) return fmi3Error;
    for (size_t i = 0; i < n_values; i++) v[i] = (vr[i / 2] == Y32 ? (float)g->gain : 1) * g->u32[i % 2];
    return fmi3OK;
}
fmi3Status fmi3SetFloat32(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Float32 v[], size_t n_values) {
    if (n_values != 2 || n != 1 || vr[0] != U32) return fmi3Error;
    memcpy(((Gallery *)c)->u32, v, sizeof(float) * 2);
    return fmi3OK;
}

#define WHOLE(name, type)                                                                                    \
    fmi3Status fmi3Set##name(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const type v[], size_t n_values) { \
        for (size_t i = 0; i < n; i++) ((Gallery *)c)->whole[vr[i]] = (double)v[i];                          \
        return fmi3OK;                                                                                       \
    }
WHOLE(Int8, fmi3Int8)
WHOLE(UInt8, fmi3UInt8)
WHOLE(Int16, fmi3Int16)
WHOLE(UInt16, fmi3UInt16)
WHOLE(Int32, fmi3Int32)
WHOLE(UInt32, fmi3UInt32)
WHOLE(Int64, fmi3Int64)
WHOLE(Boolean, fmi3Boolean)

fmi3Status fmi3SetUInt64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3UInt64 v[], size_t n_values) {
    Gallery *g = c;
    if (vr[0] != SIZE) {
        g->whole[vr[0]] = (double)v[0];
        return fmi3OK;
    }
    if (!g->configuring || v[0] > MOST) return fmi3Error;
    g->size = v[0];
    return fmi3OK;
}
fmi3Status fmi3SetString(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3String v[], size_t n_values) {
    ((Gallery *)c)->whole[vr[0]] = (double)strlen(v[0]);
    return fmi3OK;
}
fmi3Status fmi3SetBinary(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const size_t sizes[], const fmi3Binary v[], size_t n_values) {
    Gallery *g = c;
    if (sizes[0] > MOST) return fmi3Error;
    g->n_bytes = sizes[0];
    memcpy(g->bytes, v[0], sizes[0]);
    for (size_t i = 0; i < sizes[0]; i++) g->whole[vr[0]] += v[0][i];
    return fmi3OK;
}
fmi3Status fmi3GetBinary(fmi3Instance c, const fmi3ValueReference vr[], size_t n, size_t sizes[], fmi3Binary v[], size_t n_values) {
    if (n != 1 || vr[0] != ECHO || n_values != 1) return fmi3Error;
    sizes[0] = ((Gallery *)c)->n_bytes;
    v[0] = ((Gallery *)c)->bytes;
    return fmi3OK;
}
#ifdef STATE
fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState *s) {
    if (!*s) *s = malloc(sizeof(Gallery));
    memcpy(*s, c, sizeof(Gallery));
    return fmi3OK;
}
fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState s) { memcpy(c, s, sizeof(Gallery)); return fmi3OK; }
fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *s) { free(*s); *s = NULL; return fmi3OK; }
#endif
