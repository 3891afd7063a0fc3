/* Mooring lines in MoorDyn's memory over a communication step. MoorDyn moves its coupled objects
   with a constant velocity during a call and returns the forces of its last internal stage, so the
   motion is handed over in pieces of a parabola, and a vanishing call at the end gives the forces
   there. Objects with a mass that follows the motion (rods, pinned ends) would take such a call for
   a blow: their forces are carried on from the last two pieces. */
#include <math.h>
#include <string.h>

#include "lines.h"

/* Internal steps during which fairleads keep their velocity, at most: then the chord is as good as
   the parabola beside the errors of those steps. */
enum { PIECE = 4 };
static const double LAST_PART = 1e-9; /* of a step, for the evaluation of its end */
static const double CLOSING = 1e-3;   /* s in which a fairlead goes to where it ought to be, at least */
static const double SPARE = 1e-9;     /* of an internal step, so that rounding adds no other */

static double *position(const m4e_lines *l) { return l->state + M4E_LINES_CLOCK; }
static double *of_fairleads(const m4e_lines *l, int which) {
    return position(l) + (size_t)which * 3 * l->fairleads;
}
static double *velocity(const m4e_lines *l) { return of_fairleads(l, 1); }
static double *given(const m4e_lines *l) { return of_fairleads(l, 2); }
static double *force(const m4e_lines *l) { return of_fairleads(l, 3); }
static double *stage_force(const m4e_lines *l) { return of_fairleads(l, 4); }
static double *shown(const m4e_lines *l) { return of_fairleads(l, 5); }
static double *end_force(const m4e_lines *l) { return of_fairleads(l, 6); }
static double *end_place(const m4e_lines *l) { return end_force(l) + (size_t)6 * l->lines; }
static double *length(const m4e_lines *l) { return end_place(l) + (size_t)6 * l->lines; }

/* x, y, z of all fairleads in `work`, of what was given: `y` is 1 for places, 0 for velocities. */
static const double *expanded(const m4e_lines *l, const double *compact, int y) {
    const size_t n = 3 * (size_t)l->fairleads;
    double *result = l->work + (9 + (size_t)y) * n;
    for (size_t i = 0; i < n; i += 3) {
        const double fixed = l->fixed[i / 3];
        result[i] = *compact++;
        result[i + 1] = isnan(fixed) ? *compact++ : y ? fixed : 0;
        result[i + 2] = *compact++;
    }
    return result;
}

static void cross(const double *a, const double *b, double *result) {
    result[0] = a[1] * b[2] - a[2] * b[1];
    result[1] = a[2] * b[0] - a[0] * b[2];
    result[2] = a[0] * b[1] - a[1] * b[0];
}

/* Place, Euler angles (about x, y', z'') and their rates of a rod from those of its ends a, b. It
   was drawn along `axis`, and does not turn about itself. */
static void pose_of_rod(const double *axis, const double *a, const double *va, double *x,
                        double *v) {
    double r[3], rate[3], k[3], m[3][3];
    for (int c = 0; c < 3; c++) {
        x[c] = a[c];
        v[c] = va[c];
        r[c] = a[3 + c] - a[c];
        rate[c] = va[3 + c] - va[c];
    }
    const double size = dot(r, r);
    cross(r, rate, v + 3);
    for (int c = 0; c < 3; c++) {
        v[3 + c] /= size;
        r[c] /= sqrt(size);
    }
    cross(axis, r, k);
    const double share = 1 / fmax(1 + dot(axis, r), 1e-12);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            m[i][j] = share * k[i] * k[j] + (i == j ? dot(axis, r) : 0);
    m[0][1] -= k[2], m[1][0] += k[2];
    m[0][2] += k[1], m[2][0] -= k[1];
    m[1][2] -= k[0], m[2][1] += k[0];
    x[3] = atan2(-m[1][2], m[2][2]);
    x[4] = asin(fmax(-1, fmin(1, m[0][2])));
    x[5] = atan2(-m[0][1], m[0][0]);
}

/* The pair of forces at the ends of a rod that equals a force and a moment about its end a. */
static void forces_at_ends(const double *a, const double *f, double *result) {
    double r[3];
    for (int c = 0; c < 3; c++) r[c] = a[3 + c] - a[c];
    cross(f + 3, r, result + 3);
    for (int c = 0; c < 3; c++) {
        result[3 + c] /= dot(r, r);
        result[c] = f[c] - result[3 + c];
    }
}

/* One call of MoorDyn: fairleads from `at` with velocity `v`, over h; forces go to `result`. */
static int call(m4e_lines *l, const double *at, const double *v, double h, double *result) {
    const size_t count = 3 * (size_t)l->fairleads; /* a rod has six coordinates and two fairleads */
    double *x = l->work, *xd = x + count, *f = xd + count, t = l->state[0];
    memcpy(x, at, count * sizeof *x);
    memcpy(xd, v, count * sizeof *x);
    for (uint32_t o = 0, n = 0; o < l->objects; n += 3 * l->ends[o++])
        if (l->ends[o] == 2) pose_of_rod(l->axes + 3 * o, at + n, v + n, x + n, xd + n);
    if (l->step(l->system, x, xd, f, &t, &h) != 0) return M4E_LINES_FAILED;
    for (size_t i = 0; i < count; i++)
        if (!isfinite(f[i])) return M4E_LINES_NOT_FINITE;
    /* where water moves, a place that is not a number would end the process in the next call; asked
       for it, MoorDyn answers an error */
    for (uint32_t i = 0; l->moving && i < l->lines; i++)
        for (uint32_t node = 1; node < l->segments[i]; node++) {
            double r[3];
            if (l->node_position(l->line[i], node, r) != 0) return M4E_LINES_NOT_FINITE;
        }
    memcpy(result, f, count * sizeof *f);
    for (uint32_t o = 0, n = 0; o < l->objects; n += 3 * l->ends[o++])
        if (l->ends[o] == 2) forces_at_ends(at + n, f + n, result + n);
    return 0;
}

/* The water's motion at the part s of the interval that was sampled: a parabola through three. */
static void move_water(m4e_lines *l, double s) {
    const size_t n = 6 * (size_t)l->nodes;
    const double *first = l->water, *middle = first + n, *last = middle + n;
    double *now = l->water + 3 * n;
    for (size_t i = 0; i < n; i++)
        now[i] = (1 - 2 * s) * ((1 - s) * first[i] - s * last[i]) + 4 * s * (1 - s) * middle[i];
    l->set_water(l->system, now, now + n / 2, 0.0);
}

/* Internal steps, `least` or more, with which all lines are stable for the next h. */
static uint64_t internal_steps(const m4e_lines *l, double h, uint64_t least) {
    double *r = l->work + (size_t)33 * l->fairleads;
    const double *water = l->water ? l->water + (size_t)18 * l->nodes : NULL;
    for (uint32_t i = 0; i < l->lines; i++) {
        const uint32_t n = l->segments[i];
        double *v = r + 3 * ((size_t)n + 1), size = l->lengths[i];
        for (uint32_t node = 0; node <= n; node++) {
            l->node_position(l->line[i], node, r + 3 * node);
            l->node_velocity(l->line[i], node, v + 3 * node);
        }
        for (uint32_t w = 0; w < l->winches; w++)
            if (l->winch[w] == i) size = length(l)[w];
        least = m4e_line_steps(l->kinds + i, n, size, r, v, water, h, least, l->order, l->share);
        if (water) water += 3 * ((size_t)n + 1);
    }
    return least;
}

static void read_ends(m4e_lines *l) {
    for (uint32_t i = 0; i < l->lines; i++)
        for (uint32_t end = 0; end < 2; end++) {
            l->node_force(l->line[i], end * l->segments[i], end_force(l) + 6 * i + 3 * end);
            l->node_position(l->line[i], end * l->segments[i], end_place(l) + 6 * i + 3 * end);
        }
}

int m4e_lines_evaluate(m4e_lines *l, const double *u) {
    const size_t n = 3 * (size_t)l->fairleads;
    double *at = l->work + 3 * n;
    memcpy(shown(l), u, n * sizeof *u);
    for (size_t i = 0; i < n; i++) at[i] = position(l)[i] - u[i] * l->state[1];
    if (l->water) move_water(l, 1.0);
    for (uint32_t i = 0; i < l->winches; i++) {
        l->set_length(l->line[l->winch[i]], length(l)[i]);
        l->set_rate(l->line[l->winch[i]], 0.0);
    }
    const int failed = call(l, at, u, l->state[1], force(l));
    memcpy(stage_force(l), force(l), n * sizeof *at);
    read_ends(l);
    return failed;
}

/* Rate of a winch that is to have a length at the begin, and a rate. */
static double reel(const m4e_lines *l, const double *winch, uint32_t i, double h) {
    return winch[2 * i + 1] + (winch[2 * i] - length(l)[i]) / fmax(h, CLOSING);
}

int m4e_lines_settle(m4e_lines *l, const double *compact) {
    const double *u = expanded(l, compact, 0);
    const size_t size = 3 * l->fairleads * sizeof *u;
    if (memcmp(given(l), u, size) == 0) return 0;
    memcpy(velocity(l), u, size);
    memcpy(given(l), u, size);
    l->state[2] = 0;
    return l->inert ? 0 : m4e_lines_evaluate(l, u);
}

int m4e_lines_advance(m4e_lines *l, double t, double h, const double *place, const double *speed,
                      const double *winch) {
    const double *at = expanded(l, place, 1), *u = expanded(l, speed, 0);
    const size_t n = 3 * (size_t)l->fairleads;
    double *start = l->work + 4 * n, *end = start + n, *chord = end + n, *mean = chord + n,
           *bend = mean + n;
    const double lead = h / 2 + l->state[2]; /* from the velocity that is known to the mean one */
    const uint64_t steps = (uint64_t)ceil(h / l->longest * (1 - SPARE)), least = steps ? steps : 1;
    /* MoorDyn has accelerations from velocities of pieces that are all as long */
    const uint64_t pieces = l->inert ? least : (least + PIECE - 1) / PIECE;
    const uint64_t intervals = (uint64_t)fmax(1, ceil(h / l->interval - SPARE));
    const uint64_t size = (pieces + intervals - 1) / intervals; /* pieces of an interval */
    const double last = l->inert ? 0 : LAST_PART * h;
    double from = 0, piece = 0, inner = 0, begun = 0, ended = h;
    for (size_t i = 0; i < n; i++) {
        mean[i] = u[i] + (at[i] - position(l)[i]) / fmax(h, CLOSING);
        bend[i] = (mean[i] - velocity(l)[i]) / lead;
    }
    memcpy(start, position(l), n * sizeof *start);
    for (uint64_t k = 0; k < pieces; k++) {
        const uint64_t done = k * least / pieces, next_done = (k + 1) * least / pieces;
        const double to = k + 1 == pieces ? h - last : h * (double)next_done / (double)least;
        for (size_t i = 0; i < n; i++) {
            end[i] = position(l)[i] + mean[i] * to - bend[i] / 2 * to * (h - to);
            chord[i] = (end[i] - start[i]) / (to - from);
        }
        for (uint32_t i = 0; i < l->winches; i++) {
            const double rate = reel(l, winch, i, h);
            l->set_length(l->line[l->winch[i]], length(l)[i] + rate * from);
            l->set_rate(l->line[l->winch[i]], rate);
        }
        if (l->water) {
            if (k % size == 0) {
                const uint64_t next = k + size < pieces ? k + size : pieces;
                begun = from;
                ended = next == pieces ? h : h * (double)(next * least / pieces) / (double)least;
                if (l->sample(t + begun, t + ended) != 0) return M4E_LINES_NO_WATER;
            }
            move_water(l, ((from + to) / 2 - begun) / (ended - begun));
        }
        memcpy(force(l), stage_force(l), n * sizeof *start);
        l->state[0] = t + from;
        inner = (to - from) / (double)internal_steps(l, to - from, next_done - done);
        l->set_dt(l->system, inner * (1 + SPARE));
        const int failed = call(l, start, chord, to - from, stage_force(l));
        if (failed) return failed;
        memcpy(start, end, n * sizeof *start);
        piece = to - from;
        from = to;
    }
    for (uint32_t i = 0; i < l->winches; i++) length(l)[i] += reel(l, winch, i, h) * h;
    for (size_t i = 0; i < n; i++) {
        position(l)[i] = h < CLOSING ? position(l)[i] + mean[i] * h : at[i] + u[i] * h;
        velocity(l)[i] = mean[i];
        given(l)[i] = u[i];
        /* where it is not evaluated: from the last stage on to the end */
        const double ahead = (l->order == 2 ? 0.5 : 0) * inner / piece;
        force(l)[i] = stage_force(l)[i] + ahead * (stage_force(l)[i] - force(l)[i]);
        mean[i] += bend[i] * h / 2;
    }
    l->state[0] = t + h;
    l->state[1] = LAST_PART * h;
    l->state[2] = h / 2;
    if (!l->inert) return m4e_lines_evaluate(l, mean);
    read_ends(l);
    return 0;
}

void m4e_lines_nodes(const m4e_lines *l, uint32_t line, double *rows) {
    for (uint32_t n = 0; n <= l->segments[line]; n++, rows += 4) {
        double tension[3];
        if (l->node_position(l->line[line], n, rows)) rows[0] = rows[1] = rows[2] = NAN;
        rows[3] = l->node_tension(l->line[line], n, tension) ? NAN : sqrt(dot(tension, tension));
    }
}
