/* Source: FMI Specification 3.0.2, sections 2.2 (variables), 2.3.5 (event mode), 4.2 (steps). */
#include "component_3.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>

typedef int transfer(void *instance, const uint32_t *references, size_t reference_count,
                     void *values, size_t value_count);
typedef int do_step(void *instance, double t, double h, bool no_return, bool *event, bool *end,
                    bool *early, double *reached);
typedef int begin_step(void *instance, double t, double h, int no_return);
typedef int update_discrete_states(void *instance, bool *again, bool *end, bool *nominals,
                                   bool *values, bool *next_defined, double *next);
typedef int enter_mode(void *instance);
typedef int get_state(void *instance, void **state);
typedef int set_state(void *instance, void *state);

enum { WARNING = 1, MOST_EVENTS = 1000 };
static const double NEAR = 1.5e-9; /* s; communication points are whole nanoseconds */

static int is_at(double t, double goal) { return t >= goal - 4 * DBL_EPSILON * fabs(goal); }

static int move(const m4e_component_3 *c, const m4e_part_3 *p, void (*function)(void)) {
    return ((transfer *)function)(c->instance, p->references, p->reference_count, p->buffer,
                                  p->value_count);
}

static double buffered(const m4e_part_3 *p, uint64_t i) {
    const uint32_t place = p->places[i];
    return p->single ? (double)((const float *)p->buffer)[place]
                     : ((const double *)p->buffer)[place];
}

int m4e_get_3(void *access, const uint32_t *references, size_t count, double *values) {
    const m4e_access_3 *a = access;
    int status = 0;
    (void)references, (void)count;
    for (uint64_t k = 0; k < a->count; ++k) {
        const m4e_part_3 *p = &a->parts[k];
        const int answer = move(a->component, p, p->get);
        if (answer > WARNING) return answer;
        if (answer > status) status = answer;
        for (uint64_t i = 0; i < p->count; ++i) values[p->members[i]] = buffered(p, i);
    }
    return status;
}

int m4e_settle_3(m4e_component_3 *c, double t) {
    ++c->handled;
    for (int k = 0; k < MOST_EVENTS; ++k) {
        bool again = false, end = false, nominals = false, values = false, defined = false;
        double next = INFINITY;
        const int status = ((update_discrete_states *)c->update_discrete_states)(
            c->instance, &again, &end, &nominals, &values, &defined, &next);
        if (status > WARNING) return status;
        if (end) {
            c->ended = t;
            return 0; /* it can only be terminated now */
        }
        c->next_event = defined ? next : INFINITY;
        if (!again) return ((enter_mode *)c->enter_step_mode)(c->instance);
    }
    return M4E_RESTLESS;
}

int m4e_enter_event_mode_3(m4e_component_3 *c) {
    return ((enter_mode *)c->enter_event_mode)(c->instance);
}

static int in_event_mode(m4e_component_3 *c, const m4e_part_3 *p) {
    int status = m4e_enter_event_mode_3(c);
    if (status > WARNING) return status;
    if (p) status = move(c, p, p->set);
    return status > WARNING ? status : m4e_settle_3(c, c->reached);
}

static int set(m4e_component_3 *c, const m4e_part_3 *p, const double *values) {
    const int ended = c->ended < INFINITY; /* in event mode, for good */
    const int quietly = ended || !(p->discrete && c->has_events && c->stepping);
    if (p->partial || !quietly) {
        const int status = move(c, p, p->get);
        if (status > WARNING) return status;
    }
    int changed = 0;
    for (uint64_t i = 0; i < p->count; ++i) {
        const double value = values[p->members[i]];
        const uint32_t place = p->places[i];
        changed |= p->single ? ((float *)p->buffer)[place] != (float)value
                             : ((double *)p->buffer)[place] != value;
        if (p->single)
            ((float *)p->buffer)[place] = (float)value;
        else
            ((double *)p->buffer)[place] = value;
    }
    if (quietly) return move(c, p, p->set);
    return changed ? in_event_mode(c, p) : 0;
}

int m4e_set_3(void *access, const uint32_t *references, size_t count, const double *values) {
    const m4e_access_3 *a = access;
    int status = 0;
    (void)references, (void)count;
    for (uint64_t k = 0; k < a->count; ++k) {
        const int answer = set(a->component, &a->parts[k], values);
        if (answer > WARNING) return answer;
        if (answer > status) status = answer;
    }
    return status;
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
            status = in_event_mode(c, 0);
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
