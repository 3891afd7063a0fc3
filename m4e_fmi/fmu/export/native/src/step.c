/* doStep of a native FMU, by the integrators of the runtime (integrate.c). */
#include <math.h>
#include <string.h>

#include "instance.h"

answer set_input_derivatives(instance *c, const uint32_t references[], size_t count,
                             const int32_t order[], const double values[]) {
    CHECK(c->now.type == CO_SIMULATION, "%s: input derivatives belong to co-simulation",
          c->function);
    const uint32_t *s = scalars_of(c, references, count, count, 0);
    if (!s) return FMI_ERROR;
    CHECK((order && values) || count == 0, "%s: no orders are given", c->function);
    for (size_t i = 0; i < count; ++i) {
        CHECK(s[i] >= first_input(c) && s[i] < first_state(c), "%s is no input",
              name_of(c, s[i]));
        CHECK(order[i] == 1 || order[i] == 2, "input derivatives are of order 1 or 2, not %d",
              (int)order[i]);
        CHECK(isfinite(values[i]), "a derivative of %s was set to %g", name_of(c, s[i]),
              values[i]);
    }
    if (count && c->now.curved != 1) memset(c->first, 0, 2 * c->n.inputs * sizeof *c->first);
    for (size_t i = 0; i < count; ++i)
        (order[i] == 1 ? c->first : c->second)[s[i] - first_input(c)] = values[i];
    if (count) c->now.curved = 1;
    if (count) c->now.held = 0;
    return FMI_OK;
}

/* Inputs and their derivatives `h` later: the input has followed its curve. */
static void move_inputs(instance *c, double h) {
    for (uint32_t i = 0; i < c->n.inputs; ++i) {
        c->u[i] += h * (c->first[i] + 0.5 * h * c->second[i]);
        c->first[i] += h * c->second[i];
    }
    c->now.curved = 2;
}

static answer failure(instance *c, const m4e_report *report) {
    const char *why = "a state or its rate is not finite";
    if (report->status == M4E_SMALL_STEP) why = "the step size needed is too small to go on";
    if (report->status == M4E_MANY_STEPS) why = "too many steps are needed";
    if (report->component < 0) return tell(c, FMI_DISCARD, "%s at t = %.9g s", why, report->time);
    const char *name = name_of(c, first_state(c) + (uint32_t)report->component);
    return tell(c, FMI_DISCARD, "%s at t = %.9g s: %s", why, report->time, name);
}

/* Goes on to `end`, or as far as it goes; the instance is then where it came to. */
static int advance(instance *c, double end, m4e_report *report) {
    const int done = m4e_go_on(c->integrator, c->now.t, c->x, end, (int)c->now.held, c->now.step,
                               &c->now.ahead, report) == M4E_DONE;
    if (!done) m4e_reached(c->integrator, c->x);
    c->now.t = done ? end : report->time;
    c->now.step = report->step;
    c->stale = 1;
    return done;
}

/* The same, with a look at each step of the integrator, after which it may end earlier. */
static int advance_observed(instance *c, double end, m4e_report *report) {
    c->now.ahead = 0;
    m4e_start(c->integrator, c->now.t, c->x, c->now.step);
    while (c->now.t < end) {
        const int how = m4e_step(c->integrator, end, c->x, report);
        if (how < 0) m4e_reached(c->integrator, c->x);
        c->now.t = report->time;
        c->now.step = report->step;
        c->stale = 1;
        if (how < 0) return 0;
        c->now.phase = INTERMEDIATE;
        c->stale_inputs = 0;
        end = c->observe(c, end);
        c->now.phase = STEP;
        if (!c->stale_inputs) continue;
        prepare(c);
        m4e_start(c->integrator, c->now.t, c->x, c->now.step);
    }
    return 1;
}

answer do_step(instance *c, double t, double h) {
    CHECK(h > 0.0 && isfinite(t + h), "%s: no step from %g s over %g s", c->function, t, h);
    CHECK(fabs(t - c->now.t) <= 1e-6 * h + 1e-12 * fabs(t),
          "%s: a step from t = %.12g s, but the time is %.12g s", c->function, t, c->now.t);
    CHECK(!c->now.stops || t + h <= c->now.stop + 1e-6 * h + 1e-12 * fabs(t),
          "%s: a step to %.12g s, but the stop time is %.12g s", c->function, t + h,
          c->now.stop);
    if (!have_integrator(c)) return FMI_ERROR;
    if (c->now.curved == 2) { /* they held for the step before */
        memset(c->first, 0, 2 * c->n.inputs * sizeof *c->first);
        c->now.curved = 0;
    }
    prepare(c);
    if (c->now.curved) m4e_set_input_curves(c->model, t, c->u, c->first, c->second);
    m4e_report report;
    c->now.t = t;
    const int done = c->observe ? advance_observed(c, t + h, &report) : advance(c, t + h, &report);
    c->now.held = !c->now.curved;
    if (c->now.curved) move_inputs(c, c->now.t - t);
    if (done) return FMI_OK;
    c->now.phase = FAILED;
    return failure(c, &report);
}
