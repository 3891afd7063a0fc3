/* Ensembles: M4E_LANES models side by side, a lane that is done takes the next model. */
#include <stdlib.h>

#include "integrator.h"

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
            m4e_write_rows(s, l, now->t);
            if (now->left == 0) m4e_stop(now, M4E_DONE, -1);
            fresh[l] = any = 1;
        }
        running |= e->model[l] < e->models;
    }
    if (any) m4e_compute_constants(s->model);
    if (any) m4e_first_steps(s, fresh);
    return running;
}

static void ensemble_outputs(m4e_model *m, ensemble *e) {
    const size_t n = m->program->count.states, selected = m->blocks[M4E_OUTPUTS]->results;
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
            m4e_evaluate(m, M4E_OUTPUTS, t, x, y);
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
    if (count == 0 || model->lanes != M4E_LANES || !m4e_method_of(model, options) ||
        !m4e_ascending(times, count, times[0], times[count - 1]))
        return M4E_BAD_ARGUMENT;
    m4e_integrator *s = m4e_integrator_new(model, options, NULL);
    if (!s) return M4E_NO_MEMORY;
    for (uint32_t l = 0; l < M4E_LANES; ++l) {
        s->lanes[l].done = 1;
        e.model[l] = models;
    }
    while (fill_lanes(s, &e, &next)) m4e_attempt(s);
    m4e_integrator_free(s);
    ensemble_outputs(model, &e);
    return M4E_DONE;
}
