/* The driver of all methods: initial step, step size control, output times, events.

   Step sizes are controlled as in SciPy's solve_ivp (initial step of Hairer, Norsett, Wanner I,
   section II.4; safety 0.9; factors 0.2 to 10; no growth just after a rejection), with one addition:
   a step cut short by the bound does not shrink the step tried after it. */
#include <float.h>
#include <stdlib.h>

#include "integrator.h"

static const double SAFETY = 0.9, SMALLEST_FACTOR = 0.2;

/* x^(-1/root) for root 4, 5, 8, in basic arithmetic: the same bits on every platform. */
static double inverse_root(int root, double x) {
    if (root != 5) return 1.0 / sqrt(sqrt(root == 8 ? sqrt(x) : x));
    uint64_t bits;
    x = fmax(x, 1e-300);
    memcpy(&bits, &x, sizeof bits);
    bits = UINT64_C(0x4cb9999999999999) - bits / 5; /* within 5 %: the exponent divided */
    double y;
    memcpy(&y, &bits, sizeof y);
    for (int i = 0; i < 5; ++i) { /* Newton's method */
        const double square = y * y;
        y *= 1.2 - 0.2 * (x * (square * square * y));
    }
    return y;
}

void m4e_stage(m4e_integrator *s, double c, const double *x, double *result) {
    double t[M4E_LANES];
    m4e_model *m = s->model;
    for (uint32_t l = 0; l < m->lanes; ++l) t[l] = s->lanes[l].t + c * s->lanes[l].h;
    m4e_evaluate(m, m->rates, m->rates_kernel, t, x, result);
}

double m4e_sum(const m4e_integrator *s, uint32_t l, const double *v, const double *x,
               const double *y) {
    const size_t lanes = s->model->lanes;
    double sum = 0.0;
    for (size_t i = l; i < s->n * lanes; i += lanes) {
        const double size = fmax(fabs(x[i]), fabs(y[i]));
        const double ratio = v[i] / (s->options.atol + size * s->options.rtol);
        sum += ratio * ratio;
    }
    return sum;
}

static double rms(const m4e_integrator *s, uint32_t l, const double *v) {
    return sqrt(m4e_sum(s, l, v, s->x, s->x)) / sqrt((double)s->n);
}

/* Index of the first component that is not finite, -1 if all are. */
static int32_t not_finite(const m4e_integrator *s, uint32_t l, const double *v) {
    const size_t lanes = s->model->lanes;
    for (size_t i = 0; i < s->n; ++i)
        if (!isfinite(v[i * lanes + l])) return (int32_t)i;
    return -1;
}

static void stop(lane *now, int32_t status, int32_t component) {
    now->done = 1;
    now->report.status = status;
    now->report.component = component;
    now->report.time = now->t;
}

/* Rates and first step of the lanes in `fresh`, which are at (t, x). Others are evaluated along
   with them, to no effect. */
static void first_steps(m4e_integrator *s, const int *fresh) {
    const uint32_t lanes = s->model->lanes;
    double *f1 = s->k[1], d1[M4E_LANES] = {0}, h0[M4E_LANES] = {0};
    for (uint32_t l = 0; l < lanes; ++l) s->lanes[l].h = 0.0;
    m4e_stage(s, 0.0, s->x, s->work);
    for (uint32_t l = 0; l < lanes; ++l) {
        lane *now = &s->lanes[l];
        if (!fresh[l]) continue;
        now->report.evaluations += 2;
        for (size_t i = 0; i < s->n; ++i) s->k[0][i * lanes + l] = s->work[i * lanes + l];
        const int32_t bad_x = not_finite(s, l, s->x), bad = not_finite(s, l, s->k[0]);
        if (bad_x >= 0 || bad >= 0) stop(now, M4E_NOT_FINITE, bad_x >= 0 ? bad_x : bad);
        const double d0 = rms(s, l, s->x);
        d1[l] = rms(s, l, s->k[0]);
        now->h = h0[l] = fmin(d0 < 1e-5 || d1[l] < 1e-5 ? 1e-6 : 0.01 * d0 / d1[l],
                              now->bound - now->t);
    }
    for (size_t i = 0; i < s->n * lanes; ++i)
        s->work[i] = s->x[i] + h0[i % lanes] * s->k[0][i];
    m4e_stage(s, 1.0, s->work, f1);
    for (uint32_t l = 0; l < lanes; ++l) {
        lane *now = &s->lanes[l];
        if (!fresh[l]) continue;
        for (size_t i = l; i < s->n * lanes; i += lanes) f1[i] -= s->k[0][i];
        const double d2 = rms(s, l, f1) / h0[l], steepest = fmax(d1[l], d2);
        const double h1 = d1[l] <= 1e-15 && d2 <= 1e-15
                              ? fmax(1e-6, h0[l] * 1e-3)
                              : inverse_root(s->method->root, steepest / 0.01);
        const double first = fmin(fmin(100.0 * h0[l], h1), now->bound - now->t);
        now->wanted = s->n == 0 ? INFINITY : fmin(first, s->options.max_step);
    }
}

/* Moves lanes whose step was accepted to its end. */
static void move_on(m4e_integrator *s) {
    const size_t lanes = s->model->lanes;
    const double *f_new = s->k[s->method->last];
    int moved = 0;
    for (uint32_t l = 0; l < lanes; ++l) {
        lane *now = &s->lanes[l];
        if (!now->accepted) continue;
        for (size_t i = l; i < s->n * lanes; i += lanes) {
            s->x[i] = s->x_new[i];
            s->k[0][i] = f_new[i];
        }
        now->t = now->t_new;
        now->h = 0.0;
        now->accepted = 0;
        moved = 1;
    }
    if (moved && s->g) memcpy(s->g, s->g_new, s->events.count * sizeof *s->g);
    if (moved && s->method->begin) s->method->begin(s);
}

/* Chooses the step of the next attempt; stops the lane if there is none. */
static void propose(m4e_integrator *s, lane *now) {
    const double smallest = 10.0 * (nextafter(now->t, INFINITY) - now->t);
    now->h = 0.0;
    if (now->done) return;
    if (now->report.accepted + now->report.rejected >= s->options.max_steps) {
        stop(now, M4E_MANY_STEPS, -1);
        return;
    }
    if (!now->retried)
        now->wanted = fmax(fmin(now->wanted, s->options.max_step), smallest);
    else if (now->wanted < smallest) {
        int32_t bad = -1;
        const uint32_t l = (uint32_t)(now - s->lanes);
        for (int i = 0; !isfinite(now->error) && bad < 0 && i < STAGES; ++i)
            bad = not_finite(s, l, s->k[i]);
        stop(now, bad < 0 ? M4E_SMALL_STEP : M4E_NOT_FINITE, bad);
        return;
    }
    now->cut = now->t + now->wanted > now->bound;
    now->t_new = now->cut ? now->bound : now->t + now->wanted;
    now->h = now->t_new - now->t;
}

static void control(const m4e_integrator *s, lane *now) {
    const double error = s->n == 0 ? 0.0 : now->error;
    now->interpolated = 0;
    now->report.evaluations += s->method->cost;
    const double power = isfinite(error) ? SAFETY * inverse_root(s->method->root, error) : 0.0;
    if (error < 1.0) {
        const double most = now->retried ? 1.0 : s->method->largest_factor;
        const double next = now->h * fmin(most, error == 0.0 ? INFINITY : power);
        now->wanted = now->cut ? fmax(next, now->wanted) : next;
        now->accepted = 1;
        now->retried = 0;
        ++now->report.accepted;
    } else {
        now->wanted = now->h * fmax(SMALLEST_FACTOR, power);
        now->retried = 1;
        ++now->report.rejected;
    }
}

/* State of a lane at a time within its last step, into result[0], result[1], ... */
static void state_at(m4e_integrator *s, uint32_t l, double t, double *result) {
    lane *now = &s->lanes[l];
    const size_t lanes = s->model->lanes;
    const double *exact = t == now->t ? s->x : t == now->t_new ? s->x_new : NULL;
    if (!exact && !s->dense_ready) s->method->interpolant(s);
    if (!exact && !now->interpolated) {
        now->interpolated = 1;
        now->report.evaluations += s->method->dense_cost;
    }
    const double at = (t - now->t) / now->h, rest = 1.0 - at;
    for (size_t i = 0; i < s->n; ++i) {
        const size_t place = i * lanes + l;
        if (exact) {
            result[i] = exact[place];
            continue;
        }
        unsigned j = s->method->dense - 1;
        double value = s->dense[j][place];
        for (; j > 0; --j) value = s->dense[j - 1][place] + (j % 2 ? rest : at) * value;
        result[i] = s->x[place] + at * value;
    }
}

/* Rows of all times up to `reached`. */
static void write_rows(m4e_integrator *s, uint32_t l, double reached) {
    lane *now = &s->lanes[l];
    for (; now->left > 0 && *now->times <= reached; --now->left, ++now->times) {
        state_at(s, l, *now->times, now->states);
        now->states += s->n;
        ++now->report.rows;
    }
}

static void watch(m4e_integrator *s, double t, const double *x, double *g) {
    m4e_evaluate(s->model, s->model->watched, NULL, &t, x, g);
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
        const double middle = i % 3 < 2 && slanted > low && slanted < high ? slanted
                                                                           : low + 0.5 * (high - low);
        if (middle <= low || middle >= high) break;
        state_at(s, 0, middle, s->work);
        watch(s, middle, s->work, values);
        if (crossed(s->g[e], values[e], 0)) {
            high = middle;
            g_high = values[e];
        } else {
            low = middle;
            g_low = values[e];
        }
    }
    state_at(s, 0, high, s->work);
    return high;
}

/* Records the events of the step just accepted in the order of time, up to the first terminal one.
   Returns the time up to which the step counts. */
static double find_events(m4e_integrator *s) {
    lane *now = &s->lanes[0];
    const m4e_events *e = &s->events;
    watch(s, now->t_new, s->x_new, s->g_new);
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
            stop(now, M4E_MANY_EVENTS, (int32_t)first);
            now->report.time = after;
            return after;
        }
        e->index[now->report.events] = first;
        e->time[now->report.events] = after;
        state_at(s, 0, after, e->state + now->report.events * s->n);
        ++now->report.events;
        when[first] = INFINITY;
        if (e->terminal[first]) {
            stop(now, M4E_EVENT, -1);
            now->report.time = after;
            return after;
        }
    }
}

/* One attempt of every lane that is not done. */
static void attempt(m4e_integrator *s) {
    const uint32_t lanes = s->model->lanes;
    int running = 0;
    move_on(s);
    for (uint32_t l = 0; l < lanes; ++l) {
        propose(s, &s->lanes[l]);
        running |= !s->lanes[l].done;
    }
    for (uint32_t l = 0; l < M4E_LANES; ++l) s->step[l] = s->lanes[lanes == 1 ? 0 : l].h;
    if (!running) return;
    s->method->attempt(s);
    for (uint32_t l = 0; l < lanes; ++l)
        if (!s->lanes[l].done) control(s, &s->lanes[l]);
    for (uint32_t l = 0; l < lanes; ++l) {
        lane *now = &s->lanes[l];
        if (now->done || !now->accepted) continue;
        write_rows(s, l, s->g ? find_events(s) : now->t_new);
        if (now->done || now->left > 0) continue;
        stop(now, M4E_DONE, -1);
        now->report.time = now->t_new;
    }
}

static const method *method_of(const m4e_model *m, const m4e_options *o) {
    static const method *const known[] = {&m4e_rk45, &m4e_dop853, &m4e_rodas};
    const int sound = o->rtol >= 0.0 && o->atol >= 0.0 && o->rtol + o->atol > 0.0 &&
                      isfinite(o->rtol + o->atol) && o->max_step > 0.0;
    if (!sound || o->method < 0 || o->method > M4E_RODAS) return NULL;
    return o->method == M4E_RODAS && m->lanes > 1 ? NULL : known[o->method];
}

/* One piece of memory for all vectors; a stride that is no power of two spares the cache. */
static int make_room(m4e_integrator *s) {
    const size_t numbers = s->n * s->model->lanes, groups = (numbers + M4E_LANES - 1) / M4E_LANES;
    const size_t square = s->method == &m4e_rodas ? s->n + 1 : 0, g = s->model->watched->results;
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
    const int sound = method_of(model, options) &&
                      model->watched->results == (events ? events->count : 0);
    m4e_integrator *s = sound ? calloc(1, sizeof *s) : NULL;
    if (!s) return NULL;
    s->method = method_of(model, options);
    s->model = model;
    s->options = *options;
    s->options.rtol = fmax(options->rtol, 100.0 * DBL_EPSILON);
    if (events) s->events = *events;
    s->n = model->program->count.states;
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

void m4e_start(m4e_integrator *s, double t, const double *x) {
    s->lanes[0] = (lane){.t = t, .t_new = t};
    s->started = 0;
    if (s->n) memcpy(s->x, x, s->n * sizeof *x);
}

static int ascending(const double *times, size_t count, double from, double bound) {
    for (size_t i = 0; i < count; ++i) {
        if (!(times[i] >= from && times[i] <= bound)) return 0;
        from = times[i];
    }
    return isfinite(bound);
}

int m4e_advance(m4e_integrator *s, double bound, size_t count, const double *times,
                double *states, m4e_report *report) {
    lane *now = &s->lanes[0];
    now->bound = bound;
    now->times = times;
    now->states = states;
    now->left = count;
    now->report.rows = 0;
    if (now->report.status == M4E_DONE) {
        now->done = 0;
        if (s->model->lanes != 1 || !ascending(times, count, now->t, bound))
            stop(now, M4E_BAD_ARGUMENT, -1);
        else
            write_rows(s, 0, now->accepted ? now->t_new : now->t);
        if (now->left == 0 && !now->done) {
            stop(now, M4E_DONE, -1);
            now->report.time = now->accepted ? now->t_new : now->t;
        }
    }
    if (!now->done && !s->started) {
        const int fresh[] = {1};
        s->started = 1;
        first_steps(s, fresh);
        if (s->g && !now->done) watch(s, now->t, s->x, s->g);
        if (s->method->begin && !now->done) s->method->begin(s);
    }
    while (!now->done) attempt(s);
    now->report.step = now->wanted;
    *report = now->report;
    return report->status;
}

static m4e_report failure(int32_t status) {
    return (m4e_report){.status = status, .component = -1};
}

int m4e_simulate(m4e_model *model, const m4e_options *options, const m4e_events *events,
                 const double *x, size_t count, const double *times, double *states,
                 double *outputs, m4e_report *report) {
    if (count == 0 || model->lanes != 1 || !method_of(model, options)) {
        *report = failure(M4E_BAD_ARGUMENT);
        return report->status;
    }
    m4e_integrator *s = m4e_integrator_new(model, options, events);
    if (!s) {
        *report = failure(M4E_NO_MEMORY);
        return report->status;
    }
    m4e_start(s, times[0], x);
    m4e_advance(s, times[count - 1], count, times, states, report);
    const size_t n = s->n, selected = model->outputs->results;
    for (size_t i = 0; selected > 0 && i < report->rows; ++i)
        m4e_outputs(model, times[i], states + i * n, outputs + i * selected);
    m4e_integrator_free(s);
    return report->status;
}

/* Everything of an ensemble, one row per model. */
typedef struct {
    size_t models, count;
    const double *p, *u, *x, *times;
    double *states, *outputs;
    m4e_report *reports;
    size_t model[M4E_LANES]; /* that a lane runs */
} ensemble;

/* Parameters and inputs of a model into the registers of a lane. */
static void load(const ensemble *e, m4e_model *m, uint32_t l, size_t model) {
    const m4e_counts *n = &m->program->count;
    double *r = m->registers + (1 + (size_t)n->states) * M4E_LANES + l;
    for (size_t i = 0; i < n->inputs; ++i, r += M4E_LANES) *r = e->u[model * n->inputs + i];
    for (size_t i = 0; i < n->parameters; ++i, r += M4E_LANES)
        *r = e->p[model * n->parameters + i];
}

/* Puts the next models into lanes that are done; 0 if there is none left and all are done. */
static int fill_lanes(m4e_integrator *s, ensemble *e, size_t *next) {
    int fresh[M4E_LANES] = {0}, any = 0, running = 0;
    const size_t n = s->n, count = e->count;
    for (uint32_t l = 0; l < M4E_LANES; ++l) {
        lane *now = &s->lanes[l];
        if (now->done && e->model[l] < e->models) {
            now->report.step = now->wanted;
            e->reports[e->model[l]] = now->report;
            e->model[l] = e->models;
        }
        if (now->done && *next < e->models) {
            const size_t model = e->model[l] = (*next)++;
            load(e, s->model, l, model);
            *now = (lane){.t = e->times[0], .t_new = e->times[0], .bound = e->times[count - 1],
                          .times = e->times, .left = count,
                          .states = e->states + model * count * n};
            for (size_t i = 0; i < n; ++i) s->x[i * M4E_LANES + l] = e->x[model * n + i];
            write_rows(s, l, now->t);
            if (now->left == 0) stop(now, M4E_DONE, -1);
            fresh[l] = any = 1;
        }
        running |= e->model[l] < e->models;
    }
    if (any) m4e_compute_constants(s->model);
    if (any) first_steps(s, fresh);
    return running;
}

static void ensemble_outputs(m4e_model *m, ensemble *e) {
    const size_t n = m->program->count.states, selected = m->outputs->results;
    double *x = calloc((n + selected + 1) * M4E_LANES, sizeof *x), *y = x + n * M4E_LANES;
    for (size_t first = 0; selected > 0 && x && first < e->models; first += M4E_LANES) {
        const size_t left = e->models - first, lanes = left < M4E_LANES ? left : M4E_LANES;
        for (uint32_t l = 0; l < lanes; ++l) load(e, m, l, first + l);
        m4e_compute_constants(m);
        for (size_t k = 0; k < e->count; ++k) {
            double t[M4E_LANES];
            for (size_t l = 0; l < M4E_LANES; ++l) t[l] = e->times[k];
            for (size_t l = 0; l < lanes; ++l)
                for (size_t i = 0; i < n; ++i)
                    x[i * M4E_LANES + l] = e->states[((first + l) * e->count + k) * n + i];
            m4e_evaluate(m, m->outputs, NULL, t, x, y);
            for (size_t l = 0; l < lanes; ++l)
                for (size_t i = 0; k < e->reports[first + l].rows && i < selected; ++i)
                    e->outputs[((first + l) * e->count + k) * selected + i] = y[i * M4E_LANES + l];
        }
    }
    free(x);
}

int m4e_ensemble(m4e_model *model, const m4e_options *options, size_t models, const double *p,
                 const double *u, const double *x, size_t count, const double *times,
                 double *states, double *outputs, m4e_report *reports) {
    ensemble e = {models, count, p, u, x, times, states, outputs, reports, {0}};
    size_t next = 0;
    if (count == 0 || model->lanes != M4E_LANES || !method_of(model, options) ||
        !ascending(times, count, times[0], times[count - 1]))
        return M4E_BAD_ARGUMENT;
    m4e_integrator *s = m4e_integrator_new(model, options, NULL);
    if (!s) return M4E_NO_MEMORY;
    for (uint32_t l = 0; l < M4E_LANES; ++l) {
        s->lanes[l].done = 1;
        e.model[l] = models;
    }
    while (fill_lanes(s, &e, &next)) attempt(s);
    m4e_integrator_free(s);
    ensemble_outputs(model, &e);
    return M4E_DONE;
}
