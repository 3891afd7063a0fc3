/* The longest stable internal step of a line of lumped masses, from where its nodes are.

   With mass M, damping C and stiffness K (symmetric, none negative) and a mode u, an eigenvalue of
   small motions solves lambda^2 u*Mu + lambda u*Cu + u*Ku = 0.

   Complex ones: |lambda|^2 = u*Ku/u*Mu. No mode is faster than one segment alone with half its mass
   at either end: (4/l^2) EA/m' of the axial springs, 16 EI/(m' l^4) of bending, 4 T/(m_a l L) of the
   tension T across, and kBot d/m' on the seabed. The axial ones are damped by BA/EA |lambda|/2 of
   critical at least, as BA acts in all segments; bending and tension count as undamped.

   Real ones are below -x nowhere if x M - C + K/x is positive definite, as it grows with x (for x
   above the frequency of the springs, which every step is short enough for). Springs of taut
   segments take from their dampers, whose coefficient becomes (BA - EA/x)/l; a slack segment has
   the damper alone, so that a line that goes slack needs half the step of a taut one. The matrix has
   blocks of 3 x 3 along its diagonal and dyads beside it: its Cholesky factors take some hundred
   operations a node.

   Ends have half a node's mass, as if they were free: what holds them, or hangs there, only adds.

   A segment counts as slack, and a node as on the seabed, that would be there before the step ends
   if it went on as it goes. */
#include "line_steps.h"

#include <math.h>

static const double GROWTH = 1.0001; /* |R| that drag takes up where a mode is hardly damped */
static const double MOST = 256;      /* times `least`: no line needs them, so values are wrong */

/* Along the negative real axis, and for whatever damping between that of a mode and 1. */
static double decay_limit(uint32_t order) { return order == 2 ? 2.0 : 2.785; }
static double limit(uint32_t order) { return order == 2 ? 2.0 : 2.615; }

/* 1 if the exponential series up to `order` does not grow for |lambda| dt = y, damped by `ratio`. */
static int holds(double y, double ratio, uint32_t order) {
    const double x = -y * fmin(ratio, 1), z = sqrt(fmax(y * y - x * x, 0));
    double re = 1, im = 0;
    for (uint32_t k = order; k > 0; k--) {
        const double part = (re * x - im * z) / k;
        im = (re * z + im * x) / k;
        re = 1 + part;
    }
    return y <= limit(order) && re * re + im * im <= GROWTH * GROWTH;
}

/* Unit vector from a to b; its length before. */
static double direction(const double *a, const double *b, double *q) {
    for (int c = 0; c < 3; c++) q[c] = b[c] - a[c];
    const double size = sqrt(dot(q, q));
    for (int c = 0; c < 3; c++) q[c] /= size;
    return size;
}

static int on_bed(const m4e_line_kind *k, const double *r, const double *v, double h) {
    return r[2] + fmin(v[2], 0) * h < k->bed;
}

/* |q' S^-1 q| by Cholesky's factors of a symmetric S; -1 if S is not positive. */
static double inverse_along(double s[3][3], const double *q) {
    double y[3];
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j <= i; j++) {
            for (int c = 0; c < j; c++) s[i][j] -= s[i][c] * s[j][c];
            if (j < i) s[i][j] /= s[j][j];
        }
        if (!(s[i][i] > 0)) return -1;
        s[i][i] = sqrt(s[i][i]);
        y[i] = q[i];
        for (int c = 0; c < i; c++) y[i] -= s[i][c] * y[c];
        y[i] /= s[i][i];
    }
    return dot(y, y);
}

/* 1 if no mode decays faster than x within the next h. */
static int slower(const m4e_line_kind *k, uint32_t n, double l, const double *r, const double *v,
                  const double *u, double h, double x) {
    double before[3] = {0, 0, 0}, after[3] = {0, 0, 0}, taken = 0; /* of the segment before */
    for (size_t i = 0; i <= n; i++) {
        const double *here = r + 3 * i, part = i == 0 || i == n ? l / 2 : l;
        double q[3], s[3][3], flow[3], coupling = 0;
        if (i < n) {
            double rate[3];
            const double size = direction(here, here + 3, after);
            for (size_t c = 0; c < 3; c++) rate[c] = v[3 * i + 3 + c] - v[3 * i + c];
            const int slack = size + fmin(dot(after, rate), 0) * h <= l;
            coupling = fmax(k->damping - (slack ? 0 : k->least / x), 0) / l;
        }
        direction(i > 0 ? here - 3 : here, i < n ? here + 3 : here, q);
        for (size_t c = 0; c < 3; c++) flow[c] = (u ? u[3 * i + c] : 0) - v[3 * i + c];
        const double past = fabs(dot(flow, q)), wet = here[2] < 0;
        const double beside = sqrt(fmax(dot(flow, flow) - past * past, 0));
        const double across =
            x * (wet ? k->across : k->mass) - k->drag * (beside + k->speed);
        const double along =
            x * (wet ? k->along : k->mass) - k->axial_drag * (past + k->speed);
        for (int a = 0; a < 3; a++)
            for (int b = 0; b <= a; b++)
                s[a][b] = part * ((a == b) * across + (along - across) * q[a] * q[b]) -
                          taken * before[a] * before[b] - coupling * after[a] * after[b];
        for (int c = 0; c < 3; c++) s[c][c] -= part * k->mass * k->decay;
        if (on_bed(k, here, v + 3 * i, h)) {
            s[0][0] -= k->friction;
            s[1][1] -= k->friction;
            s[2][2] -= part * k->bed_damping;
        }
        const double share = inverse_along(s, after);
        if (share < 0) return 0;
        taken = coupling + coupling * coupling * share;
        for (int c = 0; c < 3; c++) before[c] = after[c];
    }
    return 1;
}

/* 1 if oscillations hold with steps dt, of a line that is stretched to `longest` segments. */
static int oscillates(const m4e_line_kind *k, double l, double longest, int touches, double dt,
                      uint32_t order) {
    const double axial = 2 / l * sqrt(k->stiffness / k->mass);
    const double bending = 4 / (l * l) * sqrt(k->bending / k->mass);
    const double strain = fmax(longest / l - 1, 0);
    const double across = 2 / l * sqrt(k->stiffness * strain / (1 + strain) / k->across);
    const double bed = touches ? sqrt(k->bed_stiffness / k->mass) : 0;
    const double both = sqrt(axial * axial + bed * bed);
    const double damped = k->bed_stiffness > 0 ? k->bed_damping / k->bed_stiffness * bed / 2 : 1;
    return holds(both * dt, k->damping / k->stiffness * both / 2, order) &&
           holds(bed * dt, damped, order) && holds(bending * dt, 0, order) &&
           holds(across * dt, 0, order);
}

uint64_t m4e_line_steps(const m4e_line_kind *k, uint32_t segments, double length, const double *r,
                        const double *v, const double *u, double h, uint64_t least, uint32_t order,
                        double share) {
    if (!(k->mass > 0)) return least;
    const double l = length / segments;
    double longest = 0;
    int touches = 0;
    for (size_t i = 0; i <= segments; i++) {
        double q[3];
        if (i < segments) longest = fmax(longest, direction(r + 3 * i, r + 3 * i + 3, q));
        touches |= on_bed(k, r + 3 * i, v + 3 * i, h);
    }
    for (uint64_t n = least;; n += 1 + n / 8) {
        const double dt = h / (double)n / share;
        if (n > MOST * (double)least) return n;
        if (oscillates(k, l, longest, touches, dt, order) &&
            slower(k, segments, l, r, v, u, h, decay_limit(order) / dt))
            return n;
    }
}
