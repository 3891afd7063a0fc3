/* Calls for values, derivatives and steps by their shapes, as remote_calls.c has them. */
#include <stdlib.h>
#include <string.h>

#include "remote_client.h"

enum { WARNING = 1, SURE = 2 /* steps after which it is known what is read */ };

/* A text with its end; NULL as an empty one. */
static m4e_given text(const char *s) {
    return (m4e_given){s ? s : "", s ? strlen(s) + 1 : 1};
}

/* From now on, these values are expected to be read after steps. */
static void learn(m4e_ahead *a, uint32_t function, const vr *references, size_t count,
                  size_t values, size_t size) {
    vr *copy = size <= M4E_ROOM ? malloc(count * sizeof *copy + 1) : NULL;
    void *room = copy ? malloc(size + 1) : NULL;
    free(a->references);
    free(a->values);
    a->references = room ? copy : NULL;
    a->values = room;
    if (!room) {
        free(copy);
        a->seen = 0;
        return;
    }
    memcpy(copy, references, count * sizeof *copy);
    a->function = function;
    a->counts[0] = count;
    a->counts[1] = values;
    a->size = size;
}

/* Values that have come along with the last step; 0 if these have not. */
static int was_ahead(m4e_remote *r, uint32_t function, const vr *references, size_t count,
                     size_t values, void *to, size_t size) {
    m4e_ahead *a = &r->ahead;
    const int same = a->function == function && a->counts[0] == count && a->size == size &&
                     a->references && !memcmp(a->references, references, count * sizeof(vr));
    if (!r->has_stepped) return 0;
    r->has_stepped = 0;
    a->seen = same ? a->seen + (a->seen < SURE) : 1;
    if (same && a->ready) {
        a->ready = 0;
        memcpy(to, a->values, size);
        return 1;
    }
    if (!same) learn(a, function, references, count, values, size);
    return 0;
}

int m4e_remote_get_now(m4e_remote *r, uint32_t function, const vr *references, size_t count,
                   size_t values, void *to, size_t size) {
    m4e_channel *c = m4e_remote_begin(r);
    const m4e_given given[] = {{references, count * sizeof *references}};
    const m4e_wanted wanted[] = {{to, values * size}};
    c->number[0] = count;
    c->number[1] = values;
    return ASK(function, given, wanted);
}

int m4e_remote_get(m4e_remote *r, uint32_t function, const vr *references, size_t count,
                   size_t values, void *to, size_t size) {
    if (was_ahead(r, function, references, count, values, to, values * size))
        return r->ahead.status;
    return m4e_remote_get_now(r, function, references, count, values, to, size);
}

int m4e_remote_set(m4e_remote *r, uint32_t function, const vr *references, size_t count,
                   size_t values, const void *from, size_t size) {
    m4e_channel *c = m4e_remote_begin(r);
    const m4e_given given[] = {{references, count * sizeof *references}, {from, values * size}};
    if (!m4e_remote_set_late(r, function, given, COUNT(given), count, values)) return 0;
    c->number[0] = count;
    c->number[1] = values;
    return m4e_remote_ask(r, function, given, COUNT(given), NULL, 0);
}

/* Texts of an answer, one after the other, stay where they are up to the next call. */
int m4e_remote_get_texts(m4e_remote *r, uint32_t function, const vr *references, size_t count,
                     const char **values, size_t size) {
    const int status = m4e_remote_get_now(r, function, references, count, size, NULL, 0);
    const char *end, *at = status >= M4E_LOST ? NULL : m4e_remote_answer(r, &end);
    if (!at) return status < M4E_LOST ? M4E_LOST : status;
    for (size_t k = 0; k < size; ++k) {
        if (at >= end) return M4E_LOST;
        values[k] = at;
        at += strlen(at) + 1;
    }
    return status;
}

int m4e_remote_set_texts(m4e_remote *r, uint32_t function, const vr *references, size_t count,
                     const char *const *values, size_t size) {
    m4e_channel *c = m4e_remote_begin(r);
    size_t total = 0;
    for (size_t k = 0; k < size; ++k) total += text(values[k]).size;
    char *whole = malloc(total + 1), *at = whole;
    if (!whole) return M4E_LOST;
    for (size_t k = 0; k < size; ++k) {
        const m4e_given one = text(values[k]);
        memcpy(at, one.at, one.size);
        at += one.size;
    }
    const m4e_given given[] = {{references, count * sizeof *references}, {whole, total}};
    c->number[0] = count;
    c->number[1] = size;
    const int status = m4e_remote_ask(r, function, given, COUNT(given), NULL, 0);
    free(whole);
    return status;
}

int m4e_remote_with_orders(m4e_remote *r, uint32_t function, const vr *references, size_t count,
                       const int32_t *orders, const double *given_values, double *values,
                       size_t size) {
    m4e_channel *c = m4e_remote_begin(r);
    const m4e_given given[] = {{references, count * sizeof *references},
                               {orders, count * sizeof *orders},
                               {given_values, given_values ? size * sizeof *values : 0}};
    if (given_values && !m4e_remote_set_late(r, function, given, COUNT(given), count, size))
        return 0;
    const m4e_wanted wanted[] = {{values, values ? size * sizeof *values : 0}};
    c->number[0] = count;
    c->number[1] = size;
    return ASK(function, given, wanted);
}

int m4e_remote_derivative(m4e_remote *r, uint32_t function, const vr *unknowns,
                          size_t unknown_count, const vr *knowns, size_t known_count,
                          const double *seed, size_t seeds, double *found, size_t size) {
    m4e_channel *c = m4e_remote_begin(r);
    const m4e_given given[] = {{unknowns, unknown_count * sizeof *unknowns},
                               {knowns, known_count * sizeof *knowns},
                               {seed, seeds * sizeof *seed}};
    const m4e_wanted wanted[] = {{found, size * sizeof *found}};
    c->number[0] = unknown_count;
    c->number[1] = known_count;
    c->number[2] = seeds;
    c->number[3] = size;
    return ASK(function, given, wanted);
}

static int post_step(m4e_remote *r, uint32_t function, double t, double h, int no_return) {
    m4e_channel *c = m4e_remote_begin(r);
    c->real[0] = t;
    c->real[1] = h;
    c->number[0] = (uint64_t)(no_return != 0);
    const m4e_ahead *a = &r->ahead;
    if (a->seen < SURE) {
        c->ahead = M4E_LOAD;
        return m4e_remote_post(r, function, NULL, 0);
    }
    const m4e_given given[] = {{a->references, a->counts[0] * sizeof(vr)}};
    c->ahead = a->function;
    c->ahead_counts[0] = a->counts[0];
    c->ahead_counts[1] = a->counts[1];
    return m4e_remote_post(r, function, given, COUNT(given));
}

static int is_begun(const m4e_remote *r, double t, double h, int no_return) {
    return r->stepping && r->t == t && r->h == h && r->no_return == (no_return != 0);
}

void m4e_remote_begin_step(void *remote, double t, double h, int no_return, uint32_t function) {
    m4e_remote *r = remote;
    if (is_begun(r, t, h, no_return)) return;
    r->late_answer = post_step(r, function, t, h, no_return);
    r->stepping = 1;
    r->t = t;
    r->h = h;
    r->no_return = no_return != 0;
}

int m4e_remote_step(m4e_remote *r, uint32_t function, double t, double h, int no_return) {
    m4e_remote_begin_step(r, t, h, no_return, function);
    const m4e_channel *c = r->channel;
    const int status = m4e_remote_await(r);
    m4e_ahead *a = &r->ahead;
    r->has_stepped = 1;
    a->ready = status <= WARNING && c->ahead != M4E_LOAD && c->ahead_status >= 0;
    if (!a->ready) return status;
    a->status = c->ahead_status;
    memcpy(a->values, c->answer, a->size);
    return status;
}
