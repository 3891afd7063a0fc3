/* Timely values: what rates read that depends on time and parameters only, such as the forces of
   waves. They are computed once for each time, by a block of their own, and where an integrator
   says which times it will need, for M4E_LANES of them at once: the instructions are those of a
   single time, so are the bits. */
#include <stdlib.h>

#include "internal.h"

/* Times for which it takes longer to compute them one by one. */
enum { LEAST_TIMES = 3 };

int m4e_timely_new(m4e_model *m) {
    foresight *f = &m->timely;
    const size_t count = m->program->count.timely, registers = m->blocks[M4E_TIMELY]->registers;
    if (count == 0 || m->lanes != 1) return 1;
    f->memory = calloc(registers * M4E_LANES + count * FORESEEN + 8, sizeof *f->wide);
    if (!f->memory) return 0;
    f->wide = (double *)(((uintptr_t)f->memory + 63) & ~(uintptr_t)63);
    f->run = m4e_lanes_runner(); /* asks the processor: as long as thousands of operations */
    f->values = f->wide + registers * M4E_LANES;
    return 1;
}

void m4e_timely_free(m4e_model *m) { free(m->timely.memory); }

void m4e_timely_forget(m4e_model *m) {
    m->timely.now = NAN;
    m->timely.count = 0;
    m->timely.stale = 1;
}

static void compute(m4e_model *m, const double *t) {
    const block *b = m->blocks[M4E_TIMELY];
    const size_t lanes = m->lanes, fixed = (1 + (size_t)m->program->count.states) * lanes;
    double *r = m->registers;
    memcpy(r, t, lanes * sizeof *r);
    if (b->kernel)
        b->kernel(t, r + lanes, r + fixed, r + m->program->first_timely * lanes);
    else
        m->run(b->code, r);
}

/* The same bits of a time: 0.0 is not -0.0, and nan is none. */
static int same(double a, double b) { return a == b && memcmp(&a, &b, sizeof a) == 0; }

void m4e_timely_at(m4e_model *m, const double *t) {
    foresight *f = &m->timely;
    const size_t count = m->program->count.timely;
    if (!f->wide) {
        compute(m, t);
        return;
    }
    if (same(f->now, *t)) return;
    f->now = *t;
    for (uint32_t k = 0; k < f->count; ++k) {
        if (!same(f->time[k], *t)) continue;
        memcpy(m->registers + m->program->first_timely, f->values + k * count,
               count * sizeof *f->values);
        return;
    }
    compute(m, t);
}

/* Parameters, what is computed from them, and literals, on all lanes. */
static void spread_fixed(m4e_model *m) {
    const m4e_counts *n = &m->program->count;
    for (size_t r = 1 + (size_t)n->states + n->inputs; r < m->program->first_timely; ++r)
        for (size_t l = 0; l < M4E_LANES; ++l) m->timely.wide[r * M4E_LANES + l] = m->registers[r];
    m->timely.stale = 0;
}

void m4e_foresee(m4e_model *m, uint32_t count, const double *times) {
    foresight *f = &m->timely;
    const uint32_t values = m->program->count.timely;
    if (!f->wide) return;
    if (f->stale) spread_fixed(m);
    f->count = 0;
    for (uint32_t from = 0; count >= from + LEAST_TIMES && from < FORESEEN; from += M4E_LANES) {
        const uint32_t left = count - from, many = left < M4E_LANES ? left : M4E_LANES;
        for (uint32_t l = 0; l < M4E_LANES; ++l)
            f->wide[l] = times[from + (l < many ? l : many - 1)];
        f->run(m->blocks[M4E_TIMELY]->code, f->wide);
        const double *found = f->wide + (size_t)m->program->first_timely * M4E_LANES;
        for (uint32_t l = 0; l < many; ++l)
            for (uint32_t i = 0; i < values; ++i)
                f->values[(from + l) * (size_t)values + i] = found[i * (size_t)M4E_LANES + l];
        memcpy(f->time + from, times + from, many * sizeof *times);
        f->count += many;
    }
}
