/* Inside of integrators: what methods share with the driver that calls them.

   Vectors are arrays in groups of M4E_LANES numbers. With one lane a group is consecutive
   components, with M4E_LANES lanes it is one component of every lane; so the same loops serve both,
   and a model gives the same bits alone and in an ensemble. */
#ifndef M4E_INTEGRATOR_H
#define M4E_INTEGRATOR_H

#include "internal.h"

#ifdef __GNUC__
#pragma GCC visibility push(hidden)
#endif

enum { STAGES = 16, DENSE = 7 };

/* One lane's run. `done` is set when it has ended, in whatever way. */
typedef struct {
    double t, t_new, bound, h, wanted; /* s; h: of the attempt, wanted: unless cut by `bound` */
    double error;                      /* of the attempt over the tolerance */
    int done, cut, accepted, retried, interpolated;
    const double *times;
    double *states; /* where the next row goes */
    size_t left;    /* rows still to write */
    uint64_t before; /* attempts of earlier calls */
    m4e_report report;
} lane;

typedef struct {
    int root;                              /* step size goes with error^(-1/root): 4, 5 or 8 */
    double largest_factor;
    unsigned last;                         /* stage that holds the rates at the step's end */
    unsigned cost, dense_cost;             /* evaluations of an attempt, of an interpolant */
    unsigned dense;                        /* coefficients of the dense output */
    void (*begin)(m4e_integrator *);       /* what a step from a new place needs; or NULL */
    void (*attempt)(m4e_integrator *);     /* fills x_new, and `error` of every lane */
    void (*interpolant)(m4e_integrator *); /* fills `dense` for the step just done */
} method;

/* States first to end whose errors are one norm: quadratures have their own, so that they never
   allow the others a larger error. */
typedef struct {
    size_t first, end;
} group;

enum { GROUPS = 2 };

struct m4e_integrator {
    const method *method;
    m4e_model *model;
    m4e_options options;
    m4e_events events;
    double *g, *g_new; /* event functions at both ends of the step; NULL without */
    size_t n, width; /* states; length of a vector */
    group group[GROUPS];
    int groups;
    lane lanes[M4E_LANES];
    double step[M4E_LANES]; /* h of each member of a group */
    int started, dense_ready;
    void *memory;
    double *x, *x_new, *work, *zero, *k[STAGES], *dense[DENSE];
    double *matrix, *jacobian; /* of the stiff method, else NULL */
    uint32_t *pivot;
};

extern const method m4e_rk4, m4e_rk45, m4e_dop853, m4e_rodas;

/* rates at (t + c h, x) of every lane */
void m4e_stage(m4e_integrator *s, double c, const double *x, double *result);
/* an attempt, and what follows from it, may need rates at t + node h */
void m4e_foresee_step(const m4e_integrator *s, unsigned nodes, const double *node);
/* sum of the squares of v / (atol + rtol max(|x|, |y|)) over a lane's components of a group */
double m4e_sum(const m4e_integrator *s, uint32_t l, group of, const double *v, const double *x,
               const double *y);
/* RMS of an error v of the last step, over the tolerance: of the group for which it is largest */
double m4e_error(const m4e_integrator *s, uint32_t l, const double *v);

/* integrate.c */
void m4e_first_steps(m4e_integrator *s, const int *fresh);
void m4e_attempt(m4e_integrator *s);
/* index of the first component that is not finite, -1 if all are */
int32_t m4e_not_finite(const m4e_integrator *s, uint32_t l, const double *v);
void m4e_stop(lane *now, int32_t status, int32_t component);
void m4e_state_at(m4e_integrator *s, uint32_t l, double t, double *result);
void m4e_write_rows(m4e_integrator *s, uint32_t l, double reached);
/* events.c */
void m4e_watch(m4e_integrator *s, double t, const double *x, double *g);
double m4e_find_events(m4e_integrator *s);
/* integrator.c: NULL where options are not sound */
const method *m4e_method_of(const m4e_model *m, const m4e_options *o);
int m4e_ascending(const double *times, size_t count, double from, double bound);

#ifdef __GNUC__
#pragma GCC visibility pop
#endif

#endif
