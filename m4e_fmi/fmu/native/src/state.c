/* FMU states: kept, restored, written to bytes and read from them, in any instance of the FMU. */
#include <stdlib.h>
#include <string.h>

#include "instance.h"

static const uint64_t MAGIC = UINT64_C(0x4d34452d464d5532);

typedef struct {
    uint64_t magic, checksum, size; /* size in bytes of the whole */
    status now;
    double values[];
} kept;

static size_t size_of(const instance *c) { return sizeof(kept) + c->count * sizeof *c->values; }

/* FNV-1a of everything that follows the checksum. */
static uint64_t checksum(const void *whole, size_t size) {
    const uint8_t *byte = whole;
    uint64_t hash = UINT64_C(0xcbf29ce484222325);
    for (size_t i = offsetof(kept, size); i < size; ++i)
        hash = (hash ^ byte[i]) * UINT64_C(0x100000001b3);
    return hash;
}

static int sound(const instance *c, const kept *k) {
    return k->magic == MAGIC && k->size == size_of(c) && k->now.identity == c->now.identity;
}

fmi2Status fmi2GetFMUstate(fmi2Component component, fmi2FMUstate *state) {
    ENTER(ANY);
    CHECK(state, "fmi2GetFMUstate: there is nowhere to put the state");
    kept *k = *state;
    CHECK(!k || sound(c, k), "fmi2GetFMUstate: the state given is not of this FMU");
    if (!k) k = calloc(1, size_of(c));
    CHECK(k, "no memory for a state");
    k->magic = MAGIC;
    k->size = size_of(c);
    k->now = c->now;
    memcpy(k->values, c->values, c->count * sizeof *c->values);
    *state = k;
    return fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component component, fmi2FMUstate state) {
    ENTER(ANY);
    const kept *k = state;
    CHECK(k && sound(c, k), "fmi2SetFMUstate: the state given is not of this FMU");
    CHECK(k->now.type == c->now.type,
          "fmi2SetFMUstate: a state of model exchange is none of co-simulation, nor the reverse");
    c->now = k->now;
    memcpy(c->values, k->values, c->count * sizeof *c->values);
    c->stale = c->stale_parameters = c->stale_tangent = 1;
    return fmi2OK;
}

fmi2Status fmi2FreeFMUstate(fmi2Component component, fmi2FMUstate *state) {
    ENTER(ANY);
    if (!state || !*state) return fmi2OK;
    CHECK(sound(c, *state), "fmi2FreeFMUstate: the state given is not of this FMU");
    ((kept *)*state)->magic = 0;
    free(*state);
    *state = NULL;
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component component, fmi2FMUstate state, size_t *size) {
    ENTER(ANY);
    CHECK(state && size && sound(c, state),
          "fmi2SerializedFMUstateSize: the state given is not of this FMU");
    *size = size_of(c);
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component component, fmi2FMUstate state, fmi2Byte bytes[],
                                 size_t size) {
    ENTER(ANY);
    CHECK(state && bytes && sound(c, state) && size >= size_of(c),
          "fmi2SerializeFMUstate: the state given is not of this FMU, or there is no room for it");
    kept *k = state;
    k->checksum = checksum(k, size_of(c));
    memcpy(bytes, k, size_of(c));
    return fmi2OK;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component component, const fmi2Byte bytes[], size_t size,
                                   fmi2FMUstate *state) {
    ENTER(ANY);
    CHECK(bytes && state && size >= size_of(c),
          "fmi2DeSerializeFMUstate: the bytes are no state of this FMU");
    kept *k = malloc(size_of(c));
    CHECK(k, "no memory for a state");
    memcpy(k, bytes, size_of(c));
    const uint32_t phase = k->now.phase;
    if (!sound(c, k) || checksum(k, size_of(c)) != k->checksum || k->now.type > fmi2CoSimulation ||
        phase == 0 || phase > TERMINATED || (phase & (phase - 1))) {
        free(k);
        return tell(c, fmi2Error, "fmi2DeSerializeFMUstate: the bytes are no state of this FMU");
    }
    *state = k;
    return fmi2OK;
}
