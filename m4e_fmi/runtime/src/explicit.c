/* The explicit Runge-Kutta methods: stages, error estimates and dense outputs. */
#include "integrator.h"
#include "tableau.h"

#define ROWS(table) (sizeof(table) / sizeof *(table))

/* Sums of 1 to 13 products, written out so that they stay in registers. */
#define T1 w[0] * k[0][i + l]
#define T2 T1 + w[1] * k[1][i + l]
#define T3 T2 + w[2] * k[2][i + l]
#define T4 T3 + w[3] * k[3][i + l]
#define T5 T4 + w[4] * k[4][i + l]
#define T6 T5 + w[5] * k[5][i + l]
#define T7 T6 + w[6] * k[6][i + l]
#define T8 T7 + w[7] * k[7][i + l]
#define T9 T8 + w[8] * k[8][i + l]
#define T10 T9 + w[9] * k[9][i + l]
#define T11 T10 + w[10] * k[10][i + l]
#define T12 T11 + w[11] * k[11][i + l]
#define T13 T12 + w[12] * k[12][i + l]
#define SUM(n)                                                                                    \
    case n:                                                                                       \
        for (size_t i = 0; i < width; i += M4E_LANES)                                             \
            M4E_EACH_LANE result[i + l] = base[i + l] + step[l] * (T##n);                         \
        break;

/* result = base + h sum(weight k); result is none of the k */
M4E_CLONES static void combine(const m4e_integrator *s, const row *r, const double *base,
                               double *result) {
    const double *const w = r->weight, *k[TERMS];
    const size_t width = s->width;
    double step[M4E_LANES];
    memcpy(step, s->step, sizeof step);
    for (unsigned j = 0; j < TERMS; ++j) k[j] = s->k[r->k[j]];
    switch (r->count) {
        SUM(1) SUM(2) SUM(3) SUM(4) SUM(5) SUM(6) SUM(7) SUM(8) SUM(9) SUM(10) SUM(11) SUM(12)
        SUM(13)
    }
}

static void stages(m4e_integrator *s, const row *rows, unsigned count, unsigned first) {
    for (unsigned i = 0; i < count; ++i) {
        combine(s, &rows[i], s->x, s->work);
        m4e_stage(s, rows[i].c, s->work, s->k[first + i]);
    }
}

/* Tells the model when the rows' stages will be. */
static void foresee(const m4e_integrator *s, const row *rows, unsigned count, const row *more,
                    unsigned more_count) {
    double node[STAGES];
    unsigned nodes = 0;
    for (unsigned i = 0; i < count; ++i)
        if (i == 0 || rows[i].c != rows[i - 1].c) node[nodes++] = rows[i].c;
    for (unsigned i = 0; i < more_count; ++i) node[nodes++] = more[i].c;
    m4e_foresee_step(s, nodes, node);
}

static void attempt(m4e_integrator *s, const row *rows, unsigned count) {
    stages(s, rows, count, 1);
    memcpy(s->x_new, s->work, s->width * sizeof *s->work); /* the last stage is the solution */
    s->dense_ready = 0;
}

/* The rates at a new place are computed when a step is made from there: nothing is left over where
   an FMU's step ends. */
static void begin_rk4(m4e_integrator *s) {
    if (s->lanes[0].report.accepted == 0 && s->model->lanes == 1) return; /* they are there */
    m4e_stage(s, 0.0, s->x, s->k[0]);
}

/* There is no estimate of the error: a step fails only where numbers end. */
static void attempt_rk4(m4e_integrator *s) {
    stages(s, rk4_stages, ROWS(rk4_stages), 1);
    combine(s, &rk4_end, s->x, s->x_new);
    s->dense_ready = 0;
    for (uint32_t l = 0; l < s->model->lanes; ++l) {
        lane *now = &s->lanes[l];
        if (now->done) continue;
        now->error = 0.0;
        now->report.evaluations += now->report.accepted > 0; /* at its start, see begin_rk4 */
        const int32_t bad = m4e_not_finite(s, l, s->x_new);
        if (bad >= 0) m4e_stop(now, M4E_NOT_FINITE, bad);
    }
}

static void attempt_rk45(m4e_integrator *s) {
    foresee(s, rk45_stages, ROWS(rk45_stages), NULL, 0);
    attempt(s, rk45_stages, ROWS(rk45_stages));
    combine(s, rk45_error, s->zero, s->work);
    for (uint32_t l = 0; l < s->model->lanes; ++l)
        s->lanes[l].error = m4e_error(s, l, s->work);
}

static void attempt_dop853(m4e_integrator *s) {
    foresee(s, dop853_stages, ROWS(dop853_stages), dop853_more, ROWS(dop853_more));
    attempt(s, dop853_stages, ROWS(dop853_stages));
    double sum[2][GROUPS][M4E_LANES]; /* of the fifth and the third order */
    for (int i = 0; i < 2; ++i) {
        combine(s, &dop853_error[i], s->zero, s->work);
        for (int j = 0; j < s->groups; ++j)
            for (uint32_t l = 0; l < s->model->lanes; ++l)
                sum[i][j][l] = m4e_sum(s, l, s->group[j], s->work, s->x, s->x_new);
    }
    for (uint32_t l = 0; l < s->model->lanes; ++l)
        for (int j = 0; j < s->groups; ++j) {
            const double both = sum[0][j][l] + 0.01 * sum[1][j][l];
            const double count = (double)(s->group[j].end - s->group[j].first);
            const double error = both == 0.0 ? 0.0 : sum[0][j][l] / sqrt(both * count);
            if (j == 0 || !(error <= s->lanes[l].error)) s->lanes[l].error = error;
        }
}

/* The first three coefficients make value and slope right at both ends. */
static void interpolant(m4e_integrator *s, const row *rows, unsigned count) {
    const double *f = s->k[0], *f_new = s->k[s->method->last];
    for (size_t i = 0; i < s->width; ++i) {
        const double h = s->step[i % M4E_LANES], rise = s->x_new[i] - s->x[i];
        s->dense[0][i] = rise;
        s->dense[1][i] = h * f[i] - rise;
        s->dense[2][i] = 2.0 * rise - h * (f[i] + f_new[i]);
    }
    for (unsigned i = 0; i < count; ++i) combine(s, &rows[i], s->zero, s->dense[3 + i]);
    s->dense_ready = 1;
}

static void interpolant_rk4(m4e_integrator *s) {
    m4e_stage(s, 1.0, s->x_new, s->k[s->method->last]);
    interpolant(s, NULL, 0);
}

static void interpolant_rk45(m4e_integrator *s) {
    interpolant(s, rk45_dense, ROWS(rk45_dense));
}

static void interpolant_dop853(m4e_integrator *s) {
    stages(s, dop853_more, ROWS(dop853_more), ROWS(dop853_stages) + 1);
    interpolant(s, dop853_dense, ROWS(dop853_dense));
}

const method m4e_rk4 = {4, 1.0, 4, 3, 1, 3, begin_rk4, attempt_rk4, interpolant_rk4};
const method m4e_rk45 = {5, 10.0, 6, 6, 0, 4, NULL, attempt_rk45, interpolant_rk45};
const method m4e_dop853 = {
    8, 10.0, 12, 12, 3, 7, NULL, attempt_dop853, interpolant_dop853};
