/* Source: FMI Specification 3.0.2, sections 2.2 (variables), 2.3.5 (event mode), 4.2 (steps). */
#include "component_3.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>

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
            status = m4e_enter_event_mode_3(c);
            if (status <= WARNING) status = m4e_settle_3(c, last);
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
