/* Performs schedules of a co-simulation's macro steps. */
#define _POSIX_C_SOURCE 200809L
#include "loop.h"

#include <math.h>
#include <string.h>
#include <time.h>

#include "clones.h"
#include "environment.h"
#ifdef _WIN32
#include <windows.h>
#endif

typedef int get_real(void *component, const uint32_t *references, size_t count, double *values);
typedef int set_real(void *component, const uint32_t *references, size_t count,
                     const double *values);
typedef int set_derivatives(void *component, const uint32_t *references, size_t count,
                            const int32_t *orders, const double *values);
typedef int do_step(void *component, double t, double h, int no_return);
typedef int save(void *component, void **state);
typedef int restore(void *component, void *state);
typedef int call(void *access, void *cells);

static const double SECOND = 1e9;
static const double ROUNDING = 1e-9; /* share of a component's own step */
static const int WARNING = 1;

double m4e_seconds(void) {
#ifdef _WIN32
    LARGE_INTEGER now, per_second;
    QueryPerformanceCounter(&now);
    QueryPerformanceFrequency(&per_second);
    return (double)now.QuadPart / (double)per_second.QuadPart;
#else
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
#endif
}

static int checked(const m4e_operation *o, const double *values) {
    for (uint32_t i = 0; i < o->count; ++i)
        if (!isfinite(values[i])) return M4E_NOT_A_NUMBER;
    return 0;
}

static int get(const m4e_operation *o, double *values) {
    const int status = ((get_real *)o->function)(o->component, o->references, o->count, values);
    return status > WARNING || o->unchecked || checked(o, values) == 0 ? status : M4E_NOT_A_NUMBER;
}

static void gather(const m4e_operation *o, double *values) {
    if (o->references)
        for (uint32_t i = 0; i < o->count; ++i) values[i] = o->source[o->references[i]];
    else
        memmove(values, o->source, o->count * sizeof *values);
}

/* One rounding per product and sum, in the order of the terms. */
static void combine(const m4e_operation *o, double *values) {
    if (!o->weights) {
        gather(o, values);
        return;
    }
    for (uint32_t i = 0; i < o->count; ++i) {
        double sum = o->weights[i] * o->source[o->references[i]];
        for (size_t k = 1; k < o->terms; ++k) {
            const size_t place = k * o->count + i;
            sum += o->weights[place] * o->source[o->references[place]];
        }
        values[i] = o->offset ? sum + o->offset[i] : sum;
    }
}

static const double LOST = 0.01, NOISE = 1e-9; /* see operations.py */

/* 1 where the second reading is lost; two that are nan are the same. */
static int is_lost(double first, double second, double new, double *size) {
    if (isfinite(first)) *size = fmax(*size, fabs(first));
    const double limit = fmax(LOST * fabs(new - first), NOISE * *size);
    return !(isfinite(second) && fabs(second - first) <= limit);
}

#define DIFFER(a, b) ((a) != (b) && ((a) == (a) || (b) == (b)))
#define CHOOSE(type, is_off)                                                                       \
    type *const first = (type *)o->source, *const second = first + o->terms,                       \
                *const before = second + o->terms, *const new = before + o->terms,                 \
                *const lost = new + 2 * (size_t)o->terms;                                          \
    for (uint32_t i = 0; i < o->count; ++i) {                                                      \
        const int off = (is_off) && DIFFER(second[i], first[i]) && DIFFER(before[i], first[i]);    \
        const type found = off ? first[i] : new[i];                                                \
        if (o->past && found != into[i]) *o->past = 0.0;                                           \
        into[i] = found;                                                                           \
        if (off) lost[i] = 1;                                                                      \
    }

static int choose(const m4e_operation *o, double *into) {
    CHOOSE(double, is_lost(first[i], second[i], new[i], &new[i + o->terms]))
    return o->unchecked ? 0 : checked(o, into);
}

static void choose_cells(const m4e_operation *o, int64_t *into) { CHOOSE(int64_t, 1) }

/* Tells a kink or a jump in a course of equal steps from what went before it.

   Of a smooth course the fourth differences are small, of the order H^4, and change little from one
   step to the next; a kink in its k-th derivative makes one of the order H^k. A value is *rough at
   once* where its fourth difference is more than SUDDEN times its level, a maximum that decays, and
   more than its gate. Where a course stays rough, the level grows until that is nothing new. */
static const double SUDDEN = 4.0, DECAY = 0.95, GROWTH = 1.5, SHARE = 1.0 / 16;

/* How many of `count` values are rough at once. `past` has, for all of them one after the other: the
   last value, its first three differences, the level and the largest of the fourth; then how many
   steps are to be seen before anything is told. */
M4E_CLONES static double monitor(uint32_t count, const double *now, const double *gate,
                                 double *past) {
    double *const value = past, *const first = past + count, *const second = first + count,
           *const third = second + count, *const level = third + count,
           *const largest = level + count, *const wait = largest + count;
    const double told = *wait > 0.0 ? INFINITY : SUDDEN, decay = *wait > 0.0 ? 0.0 : DECAY;
    double found = 0.0;
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC ivdep
#endif
    for (uint32_t i = 0; i < count; ++i) {
        const double d1 = now[i] - value[i], d2 = d1 - first[i], d3 = d2 - second[i];
        const double rough = fabs(d3 - third[i]), usual = level[i];
        const double least = told * usual > gate[i] ? told * usual : gate[i];
        const int sudden = rough > least && decay > 0.0;
        const double grown = GROWTH * usual > SHARE * rough ? GROWTH * usual : SHARE * rough;
        const double calm = rough > decay * usual ? rough : decay * usual;
        value[i] = now[i], first[i] = d1, second[i] = d2, third[i] = d3;
        level[i] = sudden ? grown : calm;
        largest[i] = decay > 0.0 && rough > largest[i] ? rough : largest[i];
        found += sudden ? 1.0 : 0.0;
    }
    if (*wait > 0.0) *wait -= 1.0;
    return found;
}

/* The piece of the macro step that the component steps by. */
static int step(const m4e_operation *o, double t, double h) {
    do_step *const f = (do_step *)o->function;
    const double length = o->length * h;
    if (o->period) return f(o->component, t + h - o->own, o->own, 1);
    const int whole = fabs(length - o->own) < ROUNDING * o->own;
    return f(o->component, t + o->start * h, whole ? o->own : length, 1);
}

static int is_due(const m4e_operation *o, double end) {
    return (llround(end * SECOND) - o->origin) % o->period == 0;
}

void m4e_restore_environment(void) { m4e_default_environment(); }

static int perform(const m4e_operation *o, double t, double h, uint64_t row) {
    double *values = o->values + row * o->stride;
    void (*const f)(void) = o->function;
    switch (o->kind) {
    case M4E_GET: return get(o, values);
    case M4E_SET: return ((set_real *)f)(o->component, o->references, o->count, values);
    case M4E_SET_DERIVATIVES:
        return ((set_derivatives *)f)(o->component, o->references, o->count, o->orders, values);
    case M4E_DO_STEP: return step(o, t, h);
    case M4E_BEGIN_STEP: step(o, t, h); return 0; /* the status comes when the step is awaited */
    case M4E_SAVE: return ((save *)f)(o->component, o->state);
    case M4E_RESTORE: return ((restore *)f)(o->component, *o->state);
    case M4E_MONITOR: *values = monitor(o->terms, o->source, o->weights, o->past); return 0;
    case M4E_CHOOSE: return choose(o, values);
    case M4E_CHOOSE_CELLS: choose_cells(o, (int64_t *)values); return 0;
    case M4E_CALL: return ((call *)f)(o->component, values);
    default: combine(o, values); return 0;
    }
}

static void note_warning(m4e_warned *w, double t) {
    if (!w) return;
    if (!w->count++) w->first = t;
    w->last = t;
}

/* Without those `in_rows` where the step ends at no row. */
static int perform_all(const m4e_operation *operations, size_t count, double t, double h,
                       uint64_t row, int at_row, uint64_t *failed) {
    for (size_t i = 0; i < count; ++i) {
        const m4e_operation *o = &operations[i];
        if (o->in_rows && !at_row) continue;
        if (o->period && !is_due(o, t + h)) continue;
        const int status = perform(o, t, h, row);
        if (o->function) m4e_default_environment();
        if (!status) continue;
        if (status == WARNING) {
            note_warning(o->warned, t);
            continue;
        }
        *failed = i;
        return status;
    }
    return 0;
}

int m4e_perform(const m4e_operation *operations, size_t count, double t, double h, uint64_t row,
                uint64_t *failed) {
    return perform_all(operations, count, t, h, row, 1, failed);
}

static int is_over(const m4e_loop_state *s) {
    for (uint64_t k = 0; k < s->end_count; ++k)
        if (*s->ends[k] < INFINITY) return 1;
    return 0;
}

int m4e_loop(m4e_loop_state *s, uint64_t steps) {
    for (uint64_t made = 0; made < steps && !is_over(s) && !(made && s->halt); ++made) {
        const double t = (double)s->now / SECOND, h = (double)s->size / SECOND;
        const int at_row = s->since + 1 >= s->every || s->now + s->size >= s->rows_from;
        int status = perform_all(s->step, s->step_count, t, h, s->noted, at_row, &s->failed);
        s->in_row = 0;
        if (status) return status;
        s->now += s->size;
        ++s->noted;
        if (++s->since < s->every) continue;
        s->in_row = 1;
        status = m4e_perform(s->row, s->row_count, 0.0, 0.0, s->written, &s->failed);
        if (status) return status;
        s->since = 0;
        ++s->written;
    }
    return 0;
}
