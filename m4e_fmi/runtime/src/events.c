/* Events: sign changes of watched outputs, located on the dense output. */
#include <float.h>

#include "integrator.h"

void m4e_watch(m4e_integrator *s, double t, const double *x, double *g) {
    m4e_evaluate(s->model, M4E_WATCHED, &t, x, g);
}

static int crossed(double before, double after, int32_t direction) {
    return (direction >= 0 && before < 0.0 && after >= 0.0) ||
           (direction <= 0 && before > 0.0 && after <= 0.0);
}

/* The first time representable at which event `e` has crossed, within a few roundings of time:
   false position that gives way to bisection. Leaves the state there in `work`. */
static double locate(m4e_integrator *s, uint32_t e, double *values) {
    const lane *now = &s->lanes[0];
    double low = now->t, high = now->t_new, g_low = s->g[e], g_high = s->g_new[e];
    for (int i = 0; high - low > 4.0 * DBL_EPSILON * fabs(high) && i < 200; ++i) {
        const double slanted = high - g_high * (high - low) / (g_high - g_low);
        const int within = i % 3 < 2 && slanted > low && slanted < high;
        const double middle = within ? slanted : low + 0.5 * (high - low);
        if (middle <= low || middle >= high) break;
        m4e_state_at(s, 0, middle, s->work);
        m4e_watch(s, middle, s->work, values);
        if (crossed(s->g[e], values[e], 0)) {
            high = middle;
            g_high = values[e];
        } else {
            low = middle;
            g_low = values[e];
        }
    }
    m4e_state_at(s, 0, high, s->work);
    return high;
}

/* Records the events of the step just accepted in the order of time, up to the first terminal one.
   Returns the time up to which the step counts. */
double m4e_find_events(m4e_integrator *s) {
    lane *now = &s->lanes[0];
    const m4e_events *e = &s->events;
    m4e_watch(s, now->t_new, s->x_new, s->g_new);
    double after = now->t, *values = s->g_new + e->count, *when = values + e->count;
    for (uint32_t i = 0; i < e->count; ++i)
        when[i] = crossed(s->g[i], s->g_new[i], e->direction[i]) ? locate(s, i, values) : INFINITY;
    for (;;) {
        uint32_t first = 0;
        for (uint32_t i = 1; i < e->count; ++i)
            if (when[i] < when[first]) first = i;
        if (!isfinite(when[first])) return now->t_new;
        after = when[first];
        if (now->report.events >= e->capacity) {
            m4e_stop(now, M4E_MANY_EVENTS, (int32_t)first);
            now->report.time = after;
            return after;
        }
        e->index[now->report.events] = first;
        e->time[now->report.events] = after;
        m4e_state_at(s, 0, after, e->state + now->report.events * s->n);
        ++now->report.events;
        when[first] = INFINITY;
        if (e->terminal[first]) {
            m4e_stop(now, M4E_EVENT, -1);
            now->report.time = after;
            return after;
        }
    }
}
