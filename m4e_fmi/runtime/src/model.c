/* Models: one program with its own parameters, inputs and registers, on one lane or M4E_LANES. */
#include <stdlib.h>

#include "internal.h"

static block *plan_outputs(const m4e_program *p, uint32_t count, const uint32_t *outputs) {
    uint32_t *roots = malloc((count + (size_t)1) * sizeof *roots);
    block *b = NULL;
    uint32_t known = 0;
    for (; roots && known < count && outputs[known] < p->count.outputs; ++known)
        roots[known] = p->results[outputs[known]];
    if (roots && known == count) b = m4e_block_new(p, count, roots, OF_ALL);
    free(roots);
    return b;
}

m4e_model *m4e_model_new(const m4e_program *program, uint32_t lanes, uint32_t selected,
                         const uint32_t *outputs, uint32_t watched, const uint32_t *events) {
    const m4e_program *p = program;
    if (lanes != 1 && lanes != M4E_LANES) return NULL;
    m4e_model *m = calloc(1, sizeof *m);
    if (!m) return NULL;
    m->run = lanes == 1 ? m4e_run : m4e_lanes_runner();
    m->program = program;
    m->lanes = lanes;
    m->blocks[M4E_RATES] = m4e_block_new(p, p->count.states, p->rates, OF_ALL);
    m->blocks[M4E_OUTPUTS] = plan_outputs(p, selected, outputs);
    m->blocks[M4E_DERIVATIVES] = m4e_block_new(p, p->count.entries, p->derivatives, OF_ALL);
    m->blocks[M4E_WATCHED] = plan_outputs(p, watched, events);
    m->blocks[M4E_TIMELY] = m4e_block_new(p, p->count.timely, p->timely, OF_TIMELY);
    m->blocks[M4E_CORNERS] = m4e_block_new(p, 2 * p->corner_count, p->corners, OF_ALL);
    m->blocks[M4E_CONSTANTS] = m4e_block_new(p, p->count.hoisted, p->hoisted, OF_HOISTED);
    uint32_t registers = 0;
    for (int i = 0; i < M4E_BLOCKS; ++i) {
        if (!m->blocks[i]) goto failed;
        if (m->blocks[i]->registers > registers) registers = m->blocks[i]->registers;
    }
    m->entries = calloc(p->count.entries + (size_t)1, sizeof *m->entries);
    m->sides = calloc(4 * p->corner_count + (size_t)1, sizeof *m->sides);
    m->memory = calloc(registers * (size_t)lanes + 8, sizeof *m->registers);
    if (!m->entries || !m->sides || !m->memory) goto failed;
    /* whole cache lines: one register of all lanes each */
    m->registers = (double *)(((uintptr_t)m->memory + 63) & ~(uintptr_t)63);
    double *literal = m->registers + (p->first_timely - p->count.literals) * (size_t)lanes;
    for (uint32_t i = 0; i < p->count.literals; ++i)
        for (uint32_t l = 0; l < lanes; ++l) literal[i * (size_t)lanes + l] = p->literals[i];
    if (!m4e_timely_new(m)) goto failed;
    m4e_compute_constants(m);
    return m;
failed:
    m4e_model_free(m);
    return NULL;
}

void m4e_model_free(m4e_model *m) {
    if (!m) return;
    for (int i = 0; i < M4E_BLOCKS; ++i) m4e_block_free(m->blocks[i]);
    m4e_timely_free(m);
    free(m->memory);
    free(m->entries);
    free(m->sides);
    free(m);
}

block *m4e_model_block(m4e_model *m, int which) {
    return which >= 0 && which < M4E_BLOCKS ? m->blocks[which] : NULL;
}

void m4e_compute_constants(m4e_model *m) {
    m->run(m->blocks[M4E_CONSTANTS]->code, m->registers);
    m4e_timely_forget(m);
}

static void follow_curves(m4e_model *m, double t) {
    const double since = t - m->curves_from;
    double *u = m->registers + 1 + m->program->count.states;
    for (uint32_t i = 0; i < m->program->count.inputs; ++i)
        u[i] = m->curves[0][i] + since * (m->curves[1][i] + 0.5 * since * m->curves[2][i]);
}

void m4e_evaluate(m4e_model *m, int which, const double *t, const double *x, double *result) {
    const block *b = m->blocks[which];
    const size_t lanes = m->lanes, states = m->program->count.states;
    double *r = m->registers;
    if (which == M4E_RATES && m->curves[0]) follow_curves(m, *t);
    if (b->timely) m4e_timely_at(m, t);
    if (b->kernel) {
        b->kernel(t, x, r + (1 + states) * lanes, result);
        return;
    }
    memcpy(r, t, lanes * sizeof *r);
    memcpy(r + lanes, x, states * lanes * sizeof *r);
    m->run(b->code, r);
    if (lanes == 1)
        for (size_t i = 0; i < b->results; ++i) result[i] = r[b->result[i]];
    else
        for (size_t i = 0; i < b->results; ++i)
            memcpy(result + i * M4E_LANES, r + (size_t)b->result[i] * M4E_LANES,
                   M4E_LANES * sizeof *r);
}

void m4e_set_inputs(m4e_model *m, const double *u) {
    const m4e_counts *n = &m->program->count;
    if (n->inputs) memcpy(m->registers + 1 + n->states, u, n->inputs * sizeof *u);
    m->curves[0] = NULL;
}

void m4e_set_input_curves(m4e_model *m, double t0, const double *u, const double *first,
                          const double *second) {
    m->curves_from = t0;
    m->curves[0] = u;
    m->curves[1] = first;
    m->curves[2] = second;
}

void m4e_set_parameters(m4e_model *m, const double *p) {
    const m4e_counts *n = &m->program->count;
    double *place = m->registers + 1 + (size_t)n->states + n->inputs;
    if (n->parameters) memcpy(place, p, n->parameters * sizeof *p);
    m4e_compute_constants(m);
}

void m4e_rates(m4e_model *m, double t, const double *x, double *result) {
    m4e_evaluate(m, M4E_RATES, &t, x, result);
}

void m4e_outputs(m4e_model *m, double t, const double *x, double *result) {
    m4e_evaluate(m, M4E_OUTPUTS, &t, x, result);
}

void m4e_calculated(m4e_model *m, double *result) {
    const m4e_program *p = m->program;
    for (uint32_t i = 0; i < p->count.calculated; ++i)
        result[i] = m->registers[p->slot[p->constants[i]]];
}

int m4e_jacobian(m4e_model *m, double t, const double *x, double *result) {
    const m4e_program *p = m->program;
    const size_t n = p->count.states;
    if (p->count.entries == 0 || m->curves[0]) return 0;
    m4e_evaluate(m, M4E_DERIVATIVES, &t, x, m->entries);
    memset(result, 0, n * (n + 1) * sizeof *result);
    for (uint32_t i = 0; i < p->count.entries; ++i)
        result[p->rows[i] * (n + 1) + p->columns[i]] = m->entries[i];
    return 1;
}
