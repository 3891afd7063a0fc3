/* Macro steps of a co-simulation: operations on FMUs (FMI 2.0), performed as a schedule lists them.

   Nothing here knows an algorithm: what is got, set, combined and stepped, and in which order, is
   the schedule's. Times are whole nanoseconds; floating point only in calls of FMUs. */
#ifndef M4E_LOOP_H
#define M4E_LOOP_H

#include "m4e.h"

enum {
    M4E_GET,             /* values = Real variables `references`; all must be finite */
    M4E_SET,             /* the reverse */
    M4E_SET_DERIVATIVES, /* time derivatives `orders` of inputs `references` are `values` */
    M4E_DO_STEP,         /* the component steps from `start` by `length`, shares of the macro step */
    M4E_SAVE,            /* keeps the component's state in *state */
    M4E_RESTORE,         /* brings it back */
    M4E_COMBINE,         /* values[i] = sum over the terms k of weights[k][i]
                            source[references[k][i]], + offset[i] unless NULL; without weights,
                            source[references[i]], or source[i] without references */
    M4E_MONITOR,         /* values[0] = how many of the `terms` values at `source` are rough at once:
                            see loop.c; `past` is what it knows of them, `weights` are gates */
    M4E_CALL,            /* function(component, values), of fmus.h; values are cells */
    M4E_BEGIN_STEP,      /* asks a component in another process for the step that a later operation
                            awaits */
    M4E_CHOOSE,          /* values = the readings that count of outputs, Real, */
    M4E_CHOOSE_CELLS     /* or cells (int64_t): see `Choose` of operations.py. At `source` are
                            `count` readings straight after a step; then, each `terms` values
                            further: readings with inputs set to the values that they had, the last
                            readings before the step, those with new inputs, the largest of the
                            first, and 1 where an output has been lost. *past becomes 0 where a
                            cell changes */
};
enum { M4E_NOT_A_NUMBER = -1 }; /* beside the statuses of FMI */

/* How often a component has answered a step with Warning; when the first and last of these began. */
typedef struct {
    uint64_t count;
    double first, last;
} m4e_warned;

typedef struct {
    int32_t kind;
    uint32_t count, terms;
    void *component;
    void (*function)(void); /* the one of FMI that does it */
    const uint32_t *references;
    const int32_t *orders;
    void **state;
    const double *weights, *source, *offset;
    double *past;
    double *values;
    uint64_t stride; /* of rows, if `values` is a block of them; else 0 */
    double start, length, own; /* own: the component's step [s], taken if `length` gives it */
    int64_t origin, period; /* ns; unless period is 0, performed only in steps that end at origin
                               plus a multiple of it, and a step by `own` ends there */
    int32_t in_rows;   /* performed only in steps that end at a row of results */
    int32_t unchecked; /* values that are got or chosen may be nan or infinite */
    m4e_warned *warned; /* of a step; NULL of all else */
} m4e_operation;

/* Seconds of a clock that nobody sets. */
double m4e_seconds(void);

/* Sets the default floating-point environment, after a call of an FMU that may have changed it. */
M4E_API void m4e_restore_environment(void);

/* Performs the operations over the step of h [s] from t [s]; blocks are filled at `row`. The status
   (0 and 1 go on), and the operation that gave it. */
M4E_API int m4e_perform(const m4e_operation *operations, size_t count, double t, double h,
                        uint64_t row, uint64_t *failed);

typedef struct {
    const m4e_operation *step, *row; /* of each step; after each step that is a row of results */
    uint64_t step_count, row_count;
    int64_t now, size;       /* ns */
    int64_t rows_from;       /* ns; all steps that end then or later count as ending at a row */
    uint64_t every, since;   /* steps from row to row; steps since the last */
    uint64_t noted, written; /* rows of blocks that are filled, by `step` and by `row` */
    uint64_t failed;         /* the operation that ended the loop */
    int32_t in_row;          /* it is one of `row` */
    const double *const *ends; /* when components asked for the end; infinite if they did not */
    uint64_t end_count;
    volatile int32_t halt; /* set by another thread: no further step */
} m4e_loop_state;

/* So many steps, fewer if an operation fails, its status then, if a component has asked for the
   end, or at a halt, after one at least. The state tells how far it came. */
M4E_API int m4e_loop(m4e_loop_state *state, uint64_t steps);

#endif
