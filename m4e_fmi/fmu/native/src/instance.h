/* One instance of the FMU: a program with its own values, and what the standard says of calls. */
#ifndef M4E_INSTANCE_H
#define M4E_INSTANCE_H

#include "fmi2.h"
#include "m4e.h"

#ifdef __GNUC__
#pragma GCC visibility push(hidden)
#endif

/* States of the standard's state machine, as bits: a function names those it may be called in. */
enum {
    INSTANTIATED = 1, INITIALIZATION = 2, EVENT = 4, CONTINUOUS = 8, /* the last two: ME */
    STEP = 16, FAILED = 32, TERMINATED = 64,                         /* the first two: CS */
    SETTABLE = INSTANTIATED | INITIALIZATION | EVENT | CONTINUOUS | STEP,
    READABLE = INITIALIZATION | EVENT | CONTINUOUS | STEP | FAILED | TERMINATED,
    ANY = INSTANTIATED | READABLE
};

/* What a saved state holds besides the values. Plain data without gaps. */
typedef struct {
    uint64_t identity; /* of the FMU: its GUID's hash */
    uint32_t type, phase;
    uint32_t stops;  /* a stop time is known */
    uint32_t curved; /* input derivatives: 0 none, 1 for the next step, 2 of the step done */
    double t, stop, step; /* s */
    double tolerance;
} status;

/* Value references: parameters, calculated ones, inputs, states, outputs, each in the program's
   order. `values` is one array: parameters, inputs, states, first and second input derivatives. */
typedef struct {
    status now;
    m4e_counts n;
    size_t count;  /* of values */
    double *values, *p, *u, *x, *first, *second;
    double *calculated, *y; /* valid unless `stale` */
    int stale, stale_parameters;

    m4e_program *program, *tangent_program;
    m4e_model *model, *tangent;
    m4e_integrator *integrator;
    double *direction, *changes; /* inputs and results of the tangent */
    int stale_tangent;
    int32_t method;
    double built_tolerance; /* of the integrator */

    char *name, *resources;
    fmi2ComponentEnvironment environment;
    void (*logger)(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String, ...);
    unsigned told; /* bit of each status whose messages are logged */
    char last_error[512];
} instance;

/* Logs a message and returns `status`. */
fmi2Status tell(instance *c, fmi2Status status, const char *format, ...)
#ifdef __GNUC__
    __attribute__((format(printf, 3, 4)))
#endif
    ;
/* Whether a function may be called now; if not, says so. */
int allowed(instance *c, unsigned phases, const char *function);
#define ENTER(phases)                                                                             \
    instance *c = component;                                                                      \
    if (!allowed(c, phases, __func__)) return fmi2Error
#define CHECK(condition, ...)                                                                     \
    if (!(condition)) return tell(c, fmi2Error, __VA_ARGS__)

/* Name of the variable of a value reference, which must be one. */
const char *name_of(const instance *c, uint32_t reference);
uint32_t reals(const instance *c); /* number of value references */
uint32_t first_input(const instance *c), first_state(const instance *c),
    first_output(const instance *c);

void to_start(instance *c);
/* Hands parameters and inputs to the model. */
void prepare(instance *c);
/* Brings outputs and calculated parameters up to date. */
void refresh(instance *c);
/* 0 and a message where there is none. */
int have_tangent(instance *c);
int have_integrator(instance *c);
/* Fills `changes` from `direction`: change of each output, then of each calculated parameter. */
void differentiate(instance *c);

#ifdef __GNUC__
#pragma GCC visibility pop
#endif

#endif
