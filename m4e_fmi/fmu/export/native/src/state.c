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

/* After the values comes what the integrator goes on from, if it is ahead. */
static size_t size_of(const instance *c) {
    return sizeof(kept) + (c->count + M4E_KEPT(c->n.states)) * sizeof *c->values;
}

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

#define CHECK_SOUND(state) \
    CHECK((state) && sound(c, state), "%s: the state given is not of this FMU", c->function)

answer keep_state(instance *c, void **state) {
    CHECK(state, "%s: there is nowhere to put the state", c->function);
    if (*state) CHECK_SOUND(*state);
    kept *k = *state ? *state : calloc(1, size_of(c));
    CHECK(k, "no memory for a state");
    k->magic = MAGIC;
    k->size = size_of(c);
    k->now = c->now;
    memcpy(k->values, c->values, c->count * sizeof *c->values);
    if (c->now.ahead) m4e_keep(c->integrator, k->values + c->count);
    *state = k;
    return FMI_OK;
}

/* The stop time stays that of this instance: a state may be one of a shorter run. */
answer restore_state(instance *c, const void *state) {
    const kept *k = state;
    CHECK_SOUND(k);
    CHECK(k->now.type == c->now.type,
          "%s: a state of model exchange is none of co-simulation, nor the reverse", c->function);
    const uint32_t stops = c->now.stops;
    const double stop = c->now.stop;
    const int other = memcmp(c->p, k->values, c->n.parameters * sizeof *c->p) != 0;
    c->now = k->now;
    c->now.stops = stops;
    c->now.stop = stop;
    memcpy(c->values, k->values, c->count * sizeof *c->values);
    c->stale = 1;
    c->stale_parameters |= other; /* what follows from the same parameters is computed already */
    c->stale_tangent |= other;
    if (!c->now.ahead) return FMI_OK;
    if (!have_integrator(c)) return FMI_ERROR;
    m4e_take_up(c->integrator, k->values + c->count);
    return FMI_OK;
}

answer free_state(instance *c, void **state) {
    if (!state || !*state) return FMI_OK;
    CHECK_SOUND(*state);
    ((kept *)*state)->magic = 0;
    free(*state);
    *state = NULL;
    return FMI_OK;
}

answer state_size(instance *c, const void *state, size_t *size) {
    CHECK_SOUND(state);
    CHECK(size, "%s: there is nowhere to put the size", c->function);
    *size = size_of(c);
    return FMI_OK;
}

answer write_state(instance *c, void *state, void *bytes, size_t size) {
    CHECK_SOUND(state);
    CHECK(bytes && size >= size_of(c), "%s: there is no room for the state", c->function);
    kept *k = state;
    k->checksum = checksum(k, size_of(c));
    memcpy(bytes, k, size_of(c));
    return FMI_OK;
}

answer read_state(instance *c, const void *bytes, size_t size, void **state) {
    CHECK(bytes && state && size >= size_of(c), "%s: the bytes are no state of this FMU",
          c->function);
    kept *k = malloc(size_of(c));
    CHECK(k, "no memory for a state");
    memcpy(k, bytes, size_of(c));
    const uint32_t phase = k->now.phase;
    if (!sound(c, k) || checksum(k, size_of(c)) != k->checksum || k->now.type > CO_SIMULATION ||
        phase == 0 || phase > TERMINATED || (phase & (phase - 1))) {
        free(k);
        return tell(c, FMI_ERROR, "%s: the bytes are no state of this FMU", c->function);
    }
    *state = k;
    return FMI_OK;
}
