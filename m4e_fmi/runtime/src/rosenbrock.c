/* RODAS: a linearly implicit method of order 4(3) for stiff systems, L-stable, six stages, one
   factorisation and one Jacobian per step. Hairer, Wanner, Solving Ordinary Differential Equations
   II, section IV.7, with the coefficients of its authors' program RODAS (first set). One lane.

   With k the stages, J = d f / d x and E = 1/(h GAMMA) - J, stage i solves
       E k_i = f(t + c_i h, x + sum_j a_ij k_j) + sum_j (c_ij / h) k_j + h d_i df/dt.
   Stages 5 and 6 start from the embedded solutions; the last one is the error estimate. */
#include <float.h>

#include "integrator.h"

enum { ORDER_STAGES = 6 };
static const double GAMMA = 0.25;
static const double node[ORDER_STAGES] = {0.0, 0.386, 0.21, 0.63, 1.0, 1.0};
static const double slope[ORDER_STAGES] = {0.25, -0.1043, 0.1035, -0.0362, 0.0, 0.0};
static const double a[ORDER_STAGES][5] = {
    {0},
    {1.544},
    {0.9466785280815826, 0.2557011698983284},
    {3.314825187068521, 2.896124015972201, 0.9986419139977817},
    {1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950},
    {1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950, 1.0}};
static const double c[ORDER_STAGES][5] = {
    {0},
    {-5.6688},
    {-2.430093356833875, -0.2063599157091915},
    {-0.1073529058151375, -9.594562251023355, -20.47028614809616},
    {7.496443313967647, -10.24680431464352, -33.99990352819905, 11.70890893206160},
    {8.083246795921522, -7.981132988064893, -31.52159432874371, 16.31930543123136,
     -6.058818238834054}};
static const double dense[2][5] = {
    {10.12623508344586, -7.487995877610167, -34.80091861555747, -7.992771707568823,
     1.025137723295662},
    {-0.6762803392806898, 6.087714651680015, 16.43084320892478, 24.76722511418386,
     -6.594389125716872}};

/* Columns of n + 1 by differences, the last one by time. */
static void difference(m4e_integrator *s) {
    const size_t n = s->n;
    const double *f = s->k[0], t = s->lanes[0].t;
    double *moved = s->work, *result = s->k[1];
    memcpy(moved, s->x, n * sizeof *moved);
    for (size_t j = 0; j <= n; ++j) {
        const double base = j < n ? s->x[j] : t;
        const double wanted = sqrt(DBL_EPSILON * fmax(1e-5, fabs(base)));
        const double delta = (base + wanted) - base; /* what is really added */
        if (j < n) moved[j] = base + delta;
        m4e_rates(s->model, j < n ? t : base + delta, moved, result);
        if (j < n) moved[j] = base;
        for (size_t i = 0; i < n; ++i) s->jacobian[i * (n + 1) + j] = (result[i] - f[i]) / delta;
    }
    s->lanes[0].report.evaluations += n + 1;
}

static void begin(m4e_integrator *s) {
    lane *now = &s->lanes[0];
    if (now->report.accepted > 0) {
        m4e_stage(s, 0.0, s->x, s->k[0]);
        ++now->report.evaluations;
    }
    if (!m4e_jacobian(s->model, now->t, s->x, s->jacobian)) difference(s);
    ++now->report.jacobians;
}

/* LU of 1/(h GAMMA) - J with partial pivoting, in place; 0 if singular or not finite. Rows of
   quadratures are no pivots of others, so that they change no bit of them. */
static int factorise(m4e_integrator *s, double diagonal) {
    const size_t n = s->n;
    double *m = s->matrix;
    for (size_t i = 0; i < n; ++i)
        for (size_t j = 0; j < n; ++j)
            m[i * n + j] = (i == j ? diagonal : 0.0) - s->jacobian[i * (n + 1) + j];
    for (size_t k = 0; k < n; ++k) {
        size_t best = k;
        for (size_t i = k + 1; i < s->group[0].end; ++i)
            if (fabs(m[i * n + k]) > fabs(m[best * n + k])) best = i;
        s->pivot[k] = (uint32_t)best;
        if (!(fabs(m[best * n + k]) > 0.0) || !isfinite(m[best * n + k])) return 0;
        for (size_t j = 0; best != k && j < n; ++j) {
            const double kept = m[k * n + j];
            m[k * n + j] = m[best * n + j];
            m[best * n + j] = kept;
        }
        for (size_t i = k + 1; i < n; ++i) {
            const double factor = m[i * n + k] /= m[k * n + k];
            if (factor != 0.0)
                for (size_t j = k + 1; j < n; ++j) m[i * n + j] -= factor * m[k * n + j];
        }
    }
    return 1;
}

static void solve(const m4e_integrator *s, double *v) {
    const size_t n = s->n;
    const double *m = s->matrix;
    for (size_t i = 0; i < n; ++i) { /* the rows were exchanged whole, factors included */
        const double kept = v[i];
        v[i] = v[s->pivot[i]];
        v[s->pivot[i]] = kept;
    }
    for (size_t i = 0; i < n; ++i)
        for (size_t j = 0; j < i; ++j) v[i] -= m[i * n + j] * v[j];
    for (size_t i = n; i-- > 0;) {
        for (size_t j = i + 1; j < n; ++j) v[i] -= m[i * n + j] * v[j];
        v[i] /= m[i * n + i];
    }
}

static void attempt(m4e_integrator *s) {
    const size_t n = s->n;
    const double h = s->lanes[0].h;
    double **k = s->k + 1; /* k[-1] holds the rates at x */
    m4e_foresee_step(s, ORDER_STAGES - 2, node + 1); /* the first is done, the last two are one */
    s->dense_ready = 0;
    s->lanes[0].error = NAN;
    if (n > 0 && !factorise(s, 1.0 / (h * GAMMA))) return;
    for (int i = 0; i < ORDER_STAGES; ++i) {
        for (size_t q = 0; q < n; ++q) {
            double sum = 0.0;
            for (int j = 0; j < i; ++j) sum += a[i][j] * k[j][q];
            s->x_new[q] = s->x[q] + sum;
        }
        if (i == 0)
            memcpy(k[0], k[-1], n * sizeof **k);
        else
            m4e_stage(s, node[i], s->x_new, k[i]);
        for (size_t q = 0; q < n; ++q) {
            double sum = 0.0;
            for (int j = 0; j < i; ++j) sum += c[i][j] * k[j][q];
            k[i][q] += sum / h + h * slope[i] * s->jacobian[q * (n + 1) + n];
        }
        solve(s, k[i]);
    }
    for (size_t q = 0; q < n; ++q) s->x_new[q] += k[ORDER_STAGES - 1][q];
    s->lanes[0].error = m4e_error(s, 0, k[ORDER_STAGES - 1]);
}

static void interpolant(m4e_integrator *s) {
    for (size_t q = 0; q < s->n; ++q) {
        s->dense[0][q] = s->x_new[q] - s->x[q];
        for (int i = 0; i < 2; ++i) {
            double sum = 0.0;
            for (int j = 0; j < 5; ++j) sum += dense[i][j] * s->k[1 + j][q];
            s->dense[1 + i][q] = sum;
        }
    }
    s->dense_ready = 1;
}

const method m4e_rodas = {4, 6.0, 0, 5, 0, 3, begin, attempt, interpolant};
