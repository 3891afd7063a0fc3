/* Integrators as objects. */
#include <float.h>
#include <stdlib.h>

#include "integrator.h"

const method *m4e_method_of(const m4e_model *m, const m4e_options *o) {
    static const method *const known[] = {&m4e_rk45, &m4e_dop853, &m4e_rodas, &m4e_rk4};
    const int sound = o->rtol >= 0.0 && o->atol >= 0.0 && o->rtol + o->atol > 0.0 &&
                      isfinite(o->rtol + o->atol) && o->max_step > 0.0 &&
                      (o->quadratures == 0 || o->quadratures < m->program->count.states);
    if (!sound || o->method < 0 || o->method > M4E_RK4) return NULL;
    return o->method == M4E_RODAS && m->lanes > 1 ? NULL : known[o->method];
}

/* One piece of memory for all vectors; a stride that is no power of two spares the cache. */
static int make_room(m4e_integrator *s) {
    const size_t numbers = s->n * s->model->lanes, groups = (numbers + M4E_LANES - 1) / M4E_LANES;
    const size_t square = s->method == &m4e_rodas ? s->n + 1 : 0;
    const size_t g = s->model->blocks[M4E_WATCHED]->results;
    s->width = groups * M4E_LANES;
    double **vectors[4 + STAGES + DENSE] = {&s->x, &s->x_new, &s->work, &s->zero};
    for (int i = 0; i < STAGES; ++i) vectors[4 + i] = &s->k[i];
    for (int i = 0; i < DENSE; ++i) vectors[4 + STAGES + i] = &s->dense[i];
    const size_t stride = (groups | 1) * M4E_LANES + M4E_LANES, count = 4 + STAGES + DENSE;
    if (square > 0 && s->n > SIZE_MAX / 32 / square) return 0;
    s->memory = calloc(stride * count + 2 * s->n * square + 4 * g + 8, sizeof(double));
    s->pivot = calloc(s->n + 1, sizeof *s->pivot);
    if (!s->memory || !s->pivot) return 0;
    double *next = (double *)(((uintptr_t)s->memory + 63) & ~(uintptr_t)63);
    for (size_t i = 0; i < count; ++i, next += stride) *vectors[i] = next;
    s->matrix = next;
    s->jacobian = next + s->n * s->n * (square > 0);
    if (g > 0) {
        s->g = s->jacobian + s->n * square;
        s->g_new = s->g + g;
    }
    return 1;
}

m4e_integrator *m4e_integrator_new(m4e_model *model, const m4e_options *options,
                                   const m4e_events *events) {
    const uint32_t watched = model->blocks[M4E_WATCHED]->results;
    const int sound = m4e_method_of(model, options) && watched == (events ? events->count : 0);
    m4e_integrator *s = sound ? calloc(1, sizeof *s) : NULL;
    if (!s) return NULL;
    s->method = m4e_method_of(model, options);
    s->model = model;
    s->options = *options;
    s->options.rtol = fmax(options->rtol, 100.0 * DBL_EPSILON);
    if (events) s->events = *events;
    s->n = model->program->count.states;
    const size_t motion = s->n - options->quadratures;
    s->group[0] = (group){0, motion};
    s->group[1] = (group){motion, s->n};
    s->groups = options->quadratures > 0 ? 2 : 1;
    if (make_room(s)) return s;
    m4e_integrator_free(s);
    return NULL;
}

void m4e_integrator_free(m4e_integrator *s) {
    if (!s) return;
    free(s->memory);
    free(s->pivot);
    free(s);
}

void m4e_start(m4e_integrator *s, double t, const double *x, double step) {
    s->lanes[0] = (lane){.t = t, .t_new = t, .wanted = step > 0.0 ? step : 0.0};
    s->started = 0;
    if (s->n) memcpy(s->x, x, s->n * sizeof *x);
}

int m4e_ascending(const double *times, size_t count, double from, double bound) {
    for (size_t i = 0; i < count; ++i) {
        if (!(times[i] >= from && times[i] <= bound)) return 0;
        from = times[i];
    }
    return isfinite(bound);
}

/* Evaluations at the place where the integrator starts, unless they are done. */
static void begin(m4e_integrator *s) {
    const int fresh[] = {1};
    lane *now = &s->lanes[0];
    if (now->done || s->started) return;
    s->started = 1;
    m4e_first_steps(s, fresh);
    if (s->g && !now->done) m4e_watch(s, now->t, s->x, s->g);
    if (s->method->begin && !now->done) s->method->begin(s);
}

int m4e_advance(m4e_integrator *s, double bound, size_t count, const double *times,
                double *states, m4e_report *report) {
    lane *now = &s->lanes[0];
    now->bound = bound;
    now->times = times;
    now->states = states;
    now->left = count;
    now->report.rows = 0;
    now->before = now->report.accepted + now->report.rejected;
    if (now->report.status == M4E_DONE) {
        now->done = 0;
        if (s->model->lanes != 1 || !m4e_ascending(times, count, now->t, bound))
            m4e_stop(now, M4E_BAD_ARGUMENT, -1);
        else
            m4e_write_rows(s, 0, now->accepted ? now->t_new : now->t);
        if (now->left == 0 && !now->done) {
            m4e_stop(now, M4E_DONE, -1);
            now->report.time = now->accepted ? now->t_new : now->t;
        }
    }
    begin(s);
    while (!now->done) m4e_attempt(s);
    now->report.step = now->wanted;
    *report = now->report;
    return report->status;
}

int m4e_step(m4e_integrator *s, double bound, double *state, m4e_report *report) {
    lane *now = &s->lanes[0];
    const double t = now->accepted ? now->t_new : now->t;
    now->bound = bound;
    now->left = 0;
    if (now->report.status == M4E_DONE) now->done = 0;
    if (s->model->lanes != 1 || !(bound > t && isfinite(bound)))
        m4e_stop(now, M4E_BAD_ARGUMENT, -1);
    begin(s);
    while (!now->done) m4e_attempt(s); /* no times are asked for: the first step done ends it */
    now->report.step = now->wanted;
    *report = now->report;
    if (report->status < 0) return report->status;
    report->time = now->t_new;
    m4e_state_at(s, 0, now->t_new, state);
    return M4E_DONE;
}

void m4e_reached(const m4e_integrator *s, double *x) {
    if (s->n) memcpy(x, s->x, s->n * sizeof *x);
}
