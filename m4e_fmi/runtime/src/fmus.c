/* Values of an FMU's variables of any type in cells, and FMI 3.0 called by FMI 2.0's functions.

   Source: FMI Specifications 1.0, 2.0.5 and 3.0.2, on getting and setting variable values; of 3.0.2
   sections 2.2 (variables), 2.3.5 (event mode), 4.2 (steps). */
#include "fmus.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

typedef int transfer(void *instance, const uint32_t *references, size_t count, void *values);
typedef int sized_transfer(void *instance, const uint32_t *references, size_t reference_count,
                           void *values, size_t value_count);
typedef int do_step(void *instance, double t, double h, bool no_return, bool *event, bool *end,
                    bool *early, double *reached);
typedef int begin_step(void *instance, double t, double h, int no_return);
typedef int update_discrete_states(void *instance, bool *again, bool *end, bool *nominals,
                                   bool *values, bool *next_defined, double *next);
typedef int enter_mode(void *instance);
typedef int get_state(void *instance, void **state);
typedef int set_state(void *instance, void *state);

enum { WARNING = 1, MOST_EVENTS = 1000, FIRST_ROOM = 64 };
static const double NEAR = 1.5e-9; /* s; communication points are whole nanoseconds */

/* ---- steps and events ---- */

static int is_at(double t, double goal) { return t >= goal - 4 * DBL_EPSILON * fabs(goal); }

int m4e_settle_3(m4e_component_3 *c) {
    ++c->handled;
    for (int k = 0; k < MOST_EVENTS; ++k) {
        bool again = false, end = false, nominals = false, values = false, defined = false;
        double next = INFINITY;
        const int status = ((update_discrete_states *)c->update_discrete_states)(
            c->instance, &again, &end, &nominals, &values, &defined, &next);
        if (status > WARNING) return status;
        if (end) {
            c->ended = c->reached;
            return 0; /* it can only be terminated now */
        }
        c->next_event = defined ? next : INFINITY;
        if (!again) return ((enter_mode *)c->enter_step_mode)(c->instance);
    }
    return M4E_RESTLESS;
}

static int enter_event_mode(const m4e_component_3 *c) {
    return ((enter_mode *)c->enter_event_mode)(c->instance);
}

/* End of the first part of a step from `now` to `stop`: that, or an event before it. */
static double first_end(const m4e_component_3 *c, double now, double stop) {
    return c->has_events && c->next_event > now && c->next_event < stop ? c->next_event : stop;
}

int m4e_begin_step_3(void *component, double t, double h, int no_return) {
    const m4e_component_3 *c = component;
    const double stop = t + h, aim = first_end(c, t, stop);
    if (c->ended < INFINITY) return 0;
    return ((begin_step *)c->begin_step)(c->instance, t, aim == stop ? h : aim - t, no_return);
}

int m4e_do_step_3(void *component, double t, double h, int no_return) {
    m4e_component_3 *c = component;
    const double stop = t + h;
    double now = t;
    if (c->ended < INFINITY) return 0;
    for (int still = 0; still < MOST_EVENTS;) {
        bool event = false, end = false, early = false;
        const double aim = first_end(c, now, stop);
        const double size = now == t && aim == stop ? h : aim - now;
        double last = aim;
        int status = ((do_step *)c->do_step)(c->instance, now, size, no_return, &event, &end,
                                             &early, &last);
        if (!early && status <= WARNING) last = aim;
        c->reached = last;
        if (status > WARNING) return status;
        const int within = last < stop - NEAR;
        if (within && last > t && !c->goes_on && c->has_events) return M4E_EARLY;
        if (end) {
            c->ended = last;
            return status;
        }
        if (c->has_events && (event || is_at(last, c->next_event))) {
            status = enter_event_mode(c);
            if (status <= WARNING) status = m4e_settle_3(c);
            if (status > WARNING || c->ended < INFINITY) return status;
        }
        if (is_at(last, stop)) return status;
        if (within) ++c->interruptions;
        still = last > now ? 0 : still + 1;
        now = last;
    }
    return M4E_RESTLESS;
}

int m4e_save_3(void *component, void **state) {
    const m4e_component_3 *c = component;
    m4e_state_3 *s = *state;
    s->next_event = c->next_event;
    s->reached = c->reached;
    s->ended = c->ended;
    s->interruptions = c->interruptions;
    return ((get_state *)c->get_state)(c->instance, &s->state);
}

int m4e_restore_3(void *component, void *state) {
    m4e_component_3 *c = component;
    const m4e_state_3 *s = state;
    c->next_event = s->next_event;
    c->reached = s->reached;
    c->ended = s->ended;
    c->interruptions = s->interruptions;
    return ((set_state *)c->set_state)(c->instance, s->state);
}

/* ---- texts ---- */

static uint64_t hashed(const char *text) { /* FNV-1a */
    uint64_t hash = 14695981039346656037u;
    for (; *text; ++text) hash = (hash ^ (unsigned char)*text) * 1099511628211u;
    return hash;
}

/* The slot of a text, or the free one where it belongs. */
static uint64_t *slot_of(const m4e_texts *t, const char *text) {
    uint64_t k = hashed(text) % t->size;
    while (t->slots[k] && strcmp(t->texts[t->slots[k] - 1], text) != 0) k = (k + 1) % t->size;
    return &t->slots[k];
}

static int grow(m4e_texts *t) {
    const uint64_t room = t->room ? 2 * t->room : FIRST_ROOM;
    char **texts = realloc(t->texts, room * sizeof *texts);
    if (!texts) return 0;
    t->texts = texts;
    uint64_t *slots = calloc(2 * room, sizeof *slots);
    if (!slots) return 0;
    free(t->slots);
    t->slots = slots;
    t->room = room;
    t->size = 2 * room;
    for (uint64_t k = 0; k < t->count; ++k) *slot_of(t, t->texts[k]) = k + 1;
    return 1;
}

int64_t m4e_text_place(m4e_texts *t, const char *text) {
    if (!text) text = "";
    if (t->count == t->room && !grow(t)) return -1;
    uint64_t *slot = slot_of(t, text);
    if (!*slot) {
        const size_t size = strlen(text) + 1;
        char *copy = malloc(size);
        if (!copy) return -1;
        memcpy(copy, text, size);
        t->texts[t->count++] = copy;
        *slot = t->count;
    }
    return (int64_t)(*slot - 1);
}

const char *m4e_text_at(const m4e_texts *t, int64_t place) { return t->texts[place]; }

void m4e_texts_free(m4e_texts *t) {
    for (uint64_t k = 0; k < t->count; ++k) free(t->texts[k]);
    free(t->texts);
    free(t->slots);
    memset(t, 0, sizeof *t);
}

/* ---- values ---- */

static int move(const m4e_access *a, const m4e_part *p, void (*f)(void)) {
    void *instance = a->component ? a->component->instance : a->instance;
    if (p->sized)
        return ((sized_transfer *)f)(instance, p->references, p->reference_count, p->buffer,
                                     p->value_count);
    return ((transfer *)f)(instance, p->references, p->reference_count, p->buffer);
}

static int64_t cell_at(const m4e_part *p, uint32_t k, m4e_texts *texts) {
    const void *b = p->buffer;
    switch (p->layout) {
    case M4E_I8: return ((const int8_t *)b)[k];
    case M4E_U8: return ((const uint8_t *)b)[k];
    case M4E_I16: return ((const int16_t *)b)[k];
    case M4E_U16: return ((const uint16_t *)b)[k];
    case M4E_I32: return ((const int32_t *)b)[k];
    case M4E_U32: return ((const uint32_t *)b)[k];
    case M4E_F32: {
        const double real = ((const float *)b)[k];
        int64_t cell;
        memcpy(&cell, &real, sizeof cell);
        return cell;
    }
    case M4E_TEXT: return m4e_text_place(texts, ((const char *const *)b)[k]);
    default: return ((const int64_t *)b)[k];
    }
}

/* Doubles that are their cells, as most values are: from the buffer, and into it, where it is told
   if one was another. */
static void get_doubles(const m4e_part *p, double *values) {
    const double *buffer = p->buffer;
    for (uint64_t i = 0; i < p->count; ++i) values[p->members[i]] = buffer[p->places[i]];
}

static int put_doubles(const m4e_part *p, const double *values) {
    double *buffer = p->buffer;
    int other = 0;
    for (uint64_t i = 0; i < p->count; ++i) {
        const double value = values[p->members[i]];
        other |= buffer[p->places[i]] != value;
        buffer[p->places[i]] = value;
    }
    return other;
}

int m4e_get_typed(m4e_access *a, int64_t *cells) {
    int worst = 0;
    for (uint64_t n = 0; n < a->part_count; ++n) {
        const m4e_part *p = &a->parts[n];
        const int status = move(a, p, p->get);
        a->failed = n;
        if (status > WARNING) return status;
        if (status > worst) worst = status;
        if (p->layout == M4E_F64) {
            get_doubles(p, (double *)(void *)cells);
            continue;
        }
        for (uint64_t i = 0; i < p->count; ++i) {
            const int64_t value = cell_at(p, p->places[i], a->texts);
            const int64_t cell = p->truth ? value != 0 : value;
            int64_t *known = &cells[p->members[i]];
            if (p->layout == M4E_TEXT && cell < 0) return M4E_NO_MEMORY;
            if (a->changed && cell != *known) *a->changed = 0.0;
            *known = cell;
        }
    }
    return worst;
}

/* The value of element k becomes a cell's, or a Real; whether it was another. */
static int put(const m4e_part *p, uint32_t k, int64_t cell, double real, const m4e_texts *texts) {
#define PUT(type, value) {                                                                         \
        type *at = &((type *)p->buffer)[k];                                                        \
        const type old = *at;                                                                      \
        *at = (type)(value);                                                                       \
        return old != *at;                                                                         \
    }
    switch (p->layout) {
    case M4E_I8: PUT(int8_t, cell)
    case M4E_U8: PUT(uint8_t, cell)
    case M4E_I16: PUT(int16_t, cell)
    case M4E_U16: PUT(uint16_t, cell)
    case M4E_I32: PUT(int32_t, cell)
    case M4E_U32: PUT(uint32_t, cell)
    case M4E_F32: PUT(float, real)
    case M4E_F64: PUT(double, real)
    case M4E_TEXT: {
        const char **at = &((const char **)p->buffer)[k], *text = m4e_text_at(texts, cell);
        const int other = !*at || strcmp(*at, text) != 0;
        *at = text;
        return other;
    }
    default: PUT(int64_t, cell)
    }
#undef PUT
}

/* Fills the buffer of a part; what is set in event mode counts as `changed` where it differs from
   what the FMU has. */
static int fill(m4e_access *a, const m4e_part *p, const int64_t *cells, int look,
                int *changed) {
    if (p->partial || look) {
        const int status = move(a, p, p->get);
        if (status > WARNING) return status;
    }
    if (!a->taken && p->layout == M4E_F64) {
        *changed = put_doubles(p, (const double *)(const void *)cells);
        return 0;
    }
    *changed = 0;
    for (uint64_t i = 0; i < p->count; ++i) {
        const m4e_taken *t = a->taken ? &a->taken[p->members[i]] : NULL;
        const int64_t cell = cells[t ? t->source : p->members[i]];
        double real;
        memcpy(&real, &cell, sizeof real);
        if (t && p->layout != M4E_TEXT && (cell < t->low || cell > t->high)) {
            a->failed = p->members[i];
            return M4E_DOES_NOT_FIT;
        }
        if (t) real = t->factor * (t->large ? (double)(uint64_t)cell : (double)cell) + t->offset;
        *changed |= put(p, p->places[i], cell, real, a->texts);
    }
    return 0;
}

int m4e_set_typed(m4e_access *a, const int64_t *cells) {
    m4e_component_3 *c = a->component;
    const int events = c && c->has_events && c->stepping && !(c->ended < INFINITY);
    int worst = 0, entered = 0;
    for (uint64_t n = 0; n < a->part_count; ++n) { /* those set in event mode are the last */
        const m4e_part *p = &a->parts[n];
        const int look = events && p->discrete;
        int changed, status;
        a->failed = n;
        status = fill(a, p, cells, look, &changed);
        if (status > WARNING || status < 0) return status;
        if (look && !changed) continue;
        if (look && !entered) {
            status = enter_event_mode(c);
            if (status > WARNING) return status;
            entered = 1;
        }
        status = move(a, p, p->set);
        if (status > WARNING) return status;
        if (status > worst) worst = status;
    }
    if (!entered) return worst;
    const int status = m4e_settle_3(c);
    return status > worst ? status : worst;
}

int m4e_get_3(void *access, const uint32_t *references, size_t count, double *values) {
    (void)references, (void)count;
    return m4e_get_typed(access, (int64_t *)(void *)values);
}

int m4e_set_3(void *access, const uint32_t *references, size_t count, const double *values) {
    (void)references, (void)count;
    return m4e_set_typed(access, (const int64_t *)(const void *)values);
}
