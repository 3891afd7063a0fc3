/* One instance of the FMU: a program with its own values, and what both versions of FMI do with it.
   fmi.c has the standards' names for what is declared here. */
#ifndef M4E_INSTANCE_H
#define M4E_INSTANCE_H

#include "m4e.h"

#ifdef __GNUC__
#pragma GCC visibility push(hidden)
#endif

/* The numbers of fmi2Status and fmi3Status. */
typedef enum { FMI_OK, FMI_WARNING, FMI_DISCARD, FMI_ERROR, FMI_FATAL } answer;
/* Those of fmi2Type. */
enum { MODEL_EXCHANGE, CO_SIMULATION };
/* States of the standards' state machines, as bits: a function names those it may be called in. */
enum {
    INSTANTIATED = 1, INITIALIZATION = 2, EVENT = 4, CONTINUOUS = 8, /* the last two: ME */
    STEP = 16, FAILED = 32, TERMINATED = 64, INTERMEDIATE = 128,     /* CS; the last: in a step */
    EXCHANGE = 256, /* beside them: only in model exchange */
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
    uint32_t held;   /* nothing was set since the last step */
    int32_t ahead;   /* the integrator is beyond the time, see m4e_go_on */
    double t, stop, step; /* s */
    double tolerance;
} status;

typedef struct instance instance;
/* Tells the importer a message, in the way of its version of FMI. */
typedef void logging(const instance *c, answer how, const char *category, const char *message);
typedef void callback(void); /* to be cast to what it is */

struct instance {
    status now;
    m4e_counts n;
    size_t count; /* of values: parameters, inputs, states, first and second input derivatives */
    double *values, *p, *u, *x, *first, *second; /* the others are within values */
    double *before; /* values to go back to */
    double *rates;
    double *y; /* outputs and calculated parameters, valid unless `stale` */
    int stale, stale_parameters, stale_inputs;
    uint32_t time_first; /* 1: value reference 0 is time, and all others follow it (FMI 3.0) */
    uint32_t *listed[2]; /* scalars */
    size_t room[2];

    m4e_program *program, *tangent_program;
    m4e_model *model, *tangent;
    m4e_integrator *integrator;
    double *direction, *changes; /* inputs and results of the tangent */
    int stale_tangent;
    int32_t method;
    double step_size; /* s; the longest of M4E_RK4 */
    double default_tolerance, built_tolerance; /* of the integrator: the last is the present one */

    /* Called after each step of the integrator, unless NULL; answers where to stop. */
    double (*observe)(instance *c, double end);
    callback *observer;
    int may_return; /* before the end of a step */

    char *name, *resources;
    void *environment;
    logging *log;
    callback *logger;
    unsigned told;        /* bit of each answer whose messages are logged */
    const char *function; /* called last */
    char last_error[512];
};

/* What an importer says when it wants an instance. */
typedef struct {
    const char *name, *token, *resources;
    uint32_t type, time_first;
    void *environment;
    logging *log;
    callback *logger;
} request;

/* NULL and a message where it cannot be. Failures are told until it is said what is. */
instance *instance_new(const request *wanted);
void instance_free(instance *c);
enum { TOLD_NOTHING = 0, TOLD_FAILURES = 28, TOLD_ALL = 31 };
answer set_logging(instance *c, int on, size_t count, const char *const categories[]);

/* Logs a message and returns `how`. */
answer tell(instance *c, answer how, const char *format, ...)
#ifdef __GNUC__
    __attribute__((format(printf, 3, 4)))
#endif
    ;
/* Whether a function may be called now; if not, says so. */
int allowed(instance *c, unsigned phases, const char *function);
#define CHECK(condition, ...)                                                                     \
    if (!(condition)) return tell(c, FMI_ERROR, __VA_ARGS__)

/* Name of a scalar, which must be one. */
const char *name_of(const instance *c, uint32_t scalar);
/* Limits of a variable of the program. */
const m4e_limits *limits_of(const instance *c, uint32_t scalar);
uint32_t scalars(const instance *c); /* without time, whose number it is */
uint32_t first_input(const instance *c), first_state(const instance *c),
    first_output(const instance *c), first_calculated(const instance *c);

/* Content of a file in resources and a zero byte; NULL and a message. */
uint8_t *read_resource(instance *c, const char *file, size_t *size);
/* Scalars are numbered as in the binary form: parameters, inputs, states, outputs, calculated
   parameters; after them, time. Number of the value references of scalars; that of the String. */
uint32_t reference_count(const instance *c), text_reference(const instance *c);
/* The scalars of value references, which must be `numbers`; NULL and a message if they are not.
   There are two lists, 0 and 1, each good until the next call for it. */
const uint32_t *scalars_of(instance *c, const uint32_t references[], size_t count, size_t numbers,
                           int list);

void to_start(instance *c);
/* Times in s; `tolerance` counts if `tolerant`, `stop` if it `stops`. */
answer set_experiment(instance *c, int tolerant, double tolerance, double start, int stops,
                      double stop);

/* Hands parameters and inputs to the model. */
void prepare(instance *c);
/* Brings outputs and calculated parameters up to date. */
void refresh(instance *c);
/* 0 and a message where there is none. */
int have_tangent(instance *c);
int have_integrator(instance *c);
answer not_finite(instance *c, uint32_t scalar, double value);

/* variables.c: `room` and `given` count values */
answer get_values(instance *c, const uint32_t references[], size_t count, double values[],
                  size_t room);
answer set_values(instance *c, const uint32_t references[], size_t count, const double values[],
                  size_t given);
answer get_text(instance *c, const uint32_t references[], size_t count, const char *values[],
                size_t room);
answer set_time(instance *c, double t);
answer set_states(instance *c, const double x[], size_t count);
answer get_states(instance *c, double x[], size_t count);
answer get_rates(instance *c, double rates[], size_t count);
answer get_nominals(instance *c, double nominals[], size_t count);

/* derivatives.c */
answer directional_derivative(instance *c, const uint32_t unknown[], size_t unknowns,
                              const uint32_t known[], size_t knowns, const double seed[],
                              size_t seeds, double result[], size_t results);
answer adjoint_derivative(instance *c, const uint32_t unknown[], size_t unknowns,
                          const uint32_t known[], size_t knowns, const double seed[],
                          size_t seeds, double result[], size_t results);
answer output_derivatives(instance *c, const uint32_t references[], size_t count,
                          const int32_t order[], double values[], size_t room);

/* step.c */
answer set_input_derivatives(instance *c, const uint32_t references[], size_t count,
                             const int32_t order[], const double values[]);
answer do_step(instance *c, double t, double h);

/* files.c: the path that a file URI names, percent-encoding resolved, with `file` appended; a plain
   path is taken as it is. Content of a file and a zero byte. NULL: no memory, or cannot be read. */
char *files_path(const char *uri, const char *file);
uint8_t *files_read(const char *path, size_t *size);

/* state.c: FMU states */
answer keep_state(instance *c, void **state);
answer restore_state(instance *c, const void *state);
answer free_state(instance *c, void **state);
answer state_size(instance *c, const void *state, size_t *size);
answer write_state(instance *c, void *state, void *bytes, size_t size);
answer read_state(instance *c, const void *bytes, size_t size, void **state);

#ifdef __GNUC__
#pragma GCC visibility pop
#endif

#endif
