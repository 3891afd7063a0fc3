/* Numerical integrators: driver of all methods, initial step, step size control, output times.

   Step sizes are controlled as in SciPy's solve_ivp (initial step of Hairer, Norsett, Wanner I,
   section II.4; safety 0.9; factors 0.2 to 10; no growth just after a rejection); what is added is
   that a step cut short by the bound does not shrink the step tried after it. */
#include "integrator.h"

static const double SAFETY = 0.9, SMALLEST_FACTOR = 0.2;
/* Part of the way to go below which a step is too small, near t = 0 too, where rounding is not. */
static const double HOPELESS = 1e-20;

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
    double t[M4E_LANES] = {0};
    m4e_model *m = s->model;
    for (uint32_t l = 0; l < m->lanes; ++l) t[l] = s->lanes[l].t + c * s->lanes[l].h;
    m4e_evaluate(m, M4E_RATES, t, x, result);
}

void m4e_foresee_step(const m4e_integrator *s, unsigned nodes, const double *node) {
    const lane *now = &s->lanes[0];
    double times[STAGES + 2];
    if (s->model->lanes > 1) return;
    for (unsigned i = 0; i < nodes; ++i) times[i] = now->t + node[i] * now->h;
    times[nodes] = now->t_new; /* may differ from t + h by a rounding */
    const int inside = now->left > 0 && *now->times < now->t_new;
    if (inside) times[nodes + 1] = *now->times;
    m4e_foresee(s->model, nodes + 1 + (unsigned)inside, times);
}

double m4e_sum(const m4e_integrator *s, uint32_t l, group of, const double *v, const double *x,
               const double *y) {
    const size_t lanes = s->model->lanes;
    double sum = 0.0;
    for (size_t i = of.first * lanes + l; i < of.end * lanes; i += lanes) {
        const double size = fmax(fabs(x[i]), fabs(y[i]));
        const double ratio = v[i] / (s->options.atol + size * s->options.rtol);
        sum += ratio * ratio;
    }
    return sum;
}

double m4e_error(const m4e_integrator *s, uint32_t l, const double *v) {
    double largest = 0.0;
    for (int i = 0; i < s->groups; ++i) {
        const group of = s->group[i];
        const double sum = m4e_sum(s, l, of, v, s->x, s->x_new);
        const double error = sqrt(sum) / sqrt((double)(of.end - of.first));
        if (i == 0 || !(error <= largest)) largest = error;
    }
    return largest;
}

static double rms(const m4e_integrator *s, uint32_t l, const double *v) {
    return sqrt(m4e_sum(s, l, s->group[0], v, s->x, s->x)) / sqrt((double)s->group[0].end);
}

int32_t m4e_not_finite(const m4e_integrator *s, uint32_t l, const double *v) {
    const size_t lanes = s->model->lanes;
    for (size_t i = 0; i < s->n; ++i)
        if (!isfinite(v[i * lanes + l])) return (int32_t)i;
    return -1;
}

void m4e_stop(lane *now, int32_t status, int32_t component) {
    now->done = 1;
    now->report.status = status;
    now->report.component = component;
    now->report.time = now->t;
}

/* Rates and first step of the lanes in `fresh`, which are at (t, x). Others are evaluated along
   with them, to no effect. */
void m4e_first_steps(m4e_integrator *s, const int *fresh) {
    const uint32_t lanes = s->model->lanes;
    const int given = s->method == &m4e_rk4 || (lanes == 1 && s->lanes[0].wanted > 0.0);
    double *f1 = s->k[1], d1[M4E_LANES] = {0}, h0[M4E_LANES] = {0};
    for (uint32_t l = 0; l < lanes; ++l) s->lanes[l].h = 0.0;
    m4e_stage(s, 0.0, s->x, s->work);
    for (uint32_t l = 0; l < lanes; ++l) {
        lane *now = &s->lanes[l];
        if (!fresh[l]) continue;
        ++now->report.evaluations;
        for (size_t i = 0; i < s->n; ++i) s->k[0][i * lanes + l] = s->work[i * lanes + l];
        const int32_t bad_x = m4e_not_finite(s, l, s->x), bad = m4e_not_finite(s, l, s->k[0]);
        if (bad_x >= 0 || bad >= 0) m4e_stop(now, M4E_NOT_FINITE, bad_x >= 0 ? bad_x : bad);
        if (given) continue;
        const double d0 = rms(s, l, s->x);
        d1[l] = rms(s, l, s->k[0]);
        now->h = h0[l] = fmin(d0 < 1e-5 || d1[l] < 1e-5 ? 1e-6 : 0.01 * d0 / d1[l],
                              now->bound - now->t);
    }
    if (given) return;
    for (size_t i = 0; i < s->n * lanes; ++i)
        s->work[i] = s->x[i] + h0[i % lanes] * s->k[0][i];
    m4e_stage(s, 1.0, s->work, f1);
    for (uint32_t l = 0; l < lanes; ++l) {
        lane *now = &s->lanes[l];
        if (!fresh[l]) continue;
        ++now->report.evaluations;
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

/* The first of the fewest equal steps to the next time asked for. */
static void equal_step(const m4e_integrator *s, lane *now) {
    const double end = now->left > 0 ? *now->times : now->bound, whole = end - now->t;
    const double count = ceil(whole / s->options.max_step * (1.0 - 1e-9)); /* but for rounding */
    now->t_new = count > 1.0 ? now->t + whole / count : end;
    now->h = now->t_new - now->t;
}

/* Chooses the step of the next attempt; stops the lane if there is none. */
static void propose(m4e_integrator *s, lane *now) {
    const double roundings = 10.0 * (nextafter(now->t, INFINITY) - now->t);
    const double smallest = fmax(roundings, HOPELESS * (now->bound - now->t));
    now->h = 0.0;
    if (now->done) return;
    if (now->report.accepted + now->report.rejected - now->before >= s->options.max_steps) {
        m4e_stop(now, M4E_MANY_STEPS, -1);
        return;
    }
    if (s->method == &m4e_rk4) {
        equal_step(s, now);
        return;
    }
    if (!now->retried)
        now->wanted = fmax(fmin(now->wanted, s->options.max_step), smallest);
    else if (now->wanted < smallest) {
        int32_t bad = -1;
        const uint32_t l = (uint32_t)(now - s->lanes);
        for (int i = 0; !isfinite(now->error) && bad < 0 && i < STAGES; ++i)
            bad = m4e_not_finite(s, l, s->k[i]);
        m4e_stop(now, bad < 0 ? M4E_SMALL_STEP : M4E_NOT_FINITE, bad);
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
void m4e_state_at(m4e_integrator *s, uint32_t l, double t, double *result) {
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
void m4e_write_rows(m4e_integrator *s, uint32_t l, double reached) {
    lane *now = &s->lanes[l];
    for (; now->left > 0 && *now->times <= reached; --now->left, ++now->times) {
        m4e_state_at(s, l, *now->times, now->states);
        now->states += s->n;
        ++now->report.rows;
    }
}

/* One attempt of every lane that is not done. */
void m4e_attempt(m4e_integrator *s) {
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
        m4e_write_rows(s, l, s->g ? m4e_find_events(s) : now->t_new);
        if (now->done || now->left > 0) continue;
        m4e_stop(now, M4E_DONE, -1);
        now->report.time = now->t_new;
    }
}
