/* Communication steps. As long as nothing is set between them they cut no step of the integrator:
   it goes on as if they were not there, and its dense output gives the states. Where something is
   set, it starts again from the states at that time. */
#include "integrator.h"

static const double FARTHEST = 100.0; /* beyond the end, in communication steps */

static int sign(double v) { return (v > 0.0) - (v < 0.0); }

/* No corner or jump that depends on time alone, as of a table, is between two times. */
static int is_smooth(m4e_model *m, const double *x, double from, double to) {
    const uint32_t count = m->program->corner_count, *corner = m->program->corners;
    double *before = m->sides, *after = before + 2 * (size_t)count;
    if (count == 0) return 1;
    m4e_evaluate(m, M4E_CORNERS, &from, x, before);
    m4e_evaluate(m, M4E_CORNERS, &to, x, after);
    for (uint32_t i = 0; i < 2 * count; i += 2) {
        const int alone = corner[i + 1] == corner[i];
        if (sign(before[i] - (alone ? 0.0 : before[i + 1])) !=
            sign(after[i] - (alone ? 0.0 : after[i + 1])))
            return 0;
    }
    return 1;
}

/* To `end` without a regard for it; 0 where that cannot be. */
static int go_ahead(m4e_integrator *s, double t, double *x, double end, m4e_report *report) {
    const lane *now = &s->lanes[0];
    double *found = s->work; /* not used any more where a row is written */
    if (m4e_advance(s, end + FARTHEST * (end - t), 1, &end, found, report) != M4E_DONE) return 0;
    if (now->t >= t && !is_smooth(s->model, x, now->t, now->t_new)) return 0;
    memcpy(x, found, s->n * sizeof *x);
    return 1;
}

int m4e_go_on(m4e_integrator *s, double t, double *x, double end, int held, double step,
              int32_t *ahead, m4e_report *report) {
    if (held && s->n > 0 && s->method != &m4e_rk4 && !s->model->curves[0]) {
        if (!*ahead) m4e_start(s, t, x, step);
        *ahead = go_ahead(s, t, x, end, report);
        if (*ahead) return M4E_DONE;
    }
    *ahead = 0;
    m4e_start(s, t, x, step);
    return m4e_advance(s, end, 1, &end, x, report);
}

/* Vectors that a step just made leaves behind. */
#define VECTORS(s) {s->x, s->x_new, s->k[s->method->last], s->dense[0], s->dense[1], s->dense[2],  \
                    s->dense[3], s->dense[4], s->dense[5], s->dense[6]}
enum { KEPT_VECTORS = 3 + DENSE };

void m4e_keep(const m4e_integrator *s, double *kept) {
    const lane *now = &s->lanes[0];
    const double *vectors[KEPT_VECTORS] = VECTORS(s);
    const double numbers[] = {now->t, now->t_new, now->h, now->wanted};
    memcpy(kept, numbers, sizeof numbers);
    for (size_t i = 0; i < KEPT_VECTORS; ++i)
        memcpy(kept + 4 + i * s->n, vectors[i], s->n * sizeof *kept);
}

void m4e_take_up(m4e_integrator *s, const double *kept) {
    double *vectors[KEPT_VECTORS] = VECTORS(s);
    m4e_start(s, kept[0], kept + 4, kept[3]);
    lane *now = &s->lanes[0];
    now->t_new = kept[1];
    now->h = kept[2];
    now->accepted = 1;
    now->report.accepted = 1;
    s->started = s->dense_ready = 1;
    for (size_t i = 0; i < KEPT_VECTORS; ++i)
        memcpy(vectors[i], kept + 4 + i * s->n, s->n * sizeof *kept);
}
