/* m4e runtime: runs programs (ordinary differential equations as straight-line arithmetic).

   x' = f(t, x, u, p)    y = g(t, x, u, p)    c = h(p)

   A program is read from its binary form (`m4e_program_read`, format in program.c). A model is one
   instance of it: its own parameters, inputs and registers. An integrator advances a model.
   Nothing here has global state; a model and its integrator belong to one thread at a time.
   The same inputs give the same bits on every run; elementary functions and step size control use
   basic arithmetic only, so they agree between platforms as well. */
#ifndef M4E_H
#define M4E_H

#include <stddef.h>
#include <stdint.h>

#include "exact.h"

#ifndef M4E_SHARED /* part of another library, without ensembles */
#define M4E_API
#elif defined _WIN32
#define M4E_API __declspec(dllexport)
#elif defined(__GNUC__)
#define M4E_API __attribute__((visibility("default")))
#else
#define M4E_API
#endif

#if defined(__GNUC__) && !defined(M4E_SHARED)
#pragma GCC visibility push(hidden)
#endif

#define M4E_ABI 6   /* changes with any declaration below */
#define M4E_LANES 8 /* models that an ensemble evaluates at once */

typedef struct m4e_program m4e_program;
typedef struct m4e_model m4e_model;
typedef struct m4e_integrator m4e_integrator;

enum { M4E_TUNABLE = 1, M4E_LOCAL = 2 }; /* flags of variables */

typedef struct {
    uint32_t states, inputs, parameters, outputs, calculated;
    uint32_t nodes, literals, entries; /* entries: of the Jacobian, 0 where there is none */
    uint32_t hoisted;                  /* operations done once per change of a parameter */
    uint32_t timely; /* values of time and parameters only that are computed apart, for rates */
} m4e_counts;

typedef struct {
    double minimum, maximum, nominal;
} m4e_limits; /* of a variable */

enum { M4E_RK45 = 0, M4E_DOP853 = 1, M4E_RODAS = 2, M4E_RK4 = 3 };

enum {
    M4E_DONE = 0,           /* every time asked for was reached */
    M4E_EVENT = 1,          /* a terminal event stopped the run */
    M4E_NOT_FINITE = -1,    /* a rate or a state is inf or nan: `component` is its index */
    M4E_SMALL_STEP = -2,    /* the step size needed is below what floating point resolves */
    M4E_MANY_STEPS = -3,    /* `max_steps` were taken */
    M4E_MANY_EVENTS = -4,   /* more events than there is room for */
    M4E_BAD_ARGUMENT = -5,
    M4E_NO_MEMORY = -6
};

typedef struct {
    int32_t method;
    double rtol, atol; /* local error per step <= atol + rtol |x|, RMS norm */
    double max_step;   /* s; INFINITY for no limit. M4E_RK4 takes the fewest equal steps up to the
                          next time asked for that are not longer, whatever their error */
    uint64_t max_steps; /* of one call */
    uint64_t quadratures; /* the last states, which no rate depends on: a norm of their own */
} m4e_options;

typedef struct {
    int32_t status;
    int32_t component; /* of the state or rate that is not finite, -1 otherwise */
    double time;       /* s, reached */
    double step;       /* s, to be tried next */
    uint64_t evaluations, jacobians, accepted, rejected;
    uint64_t rows;   /* output times reached */
    uint64_t events; /* recorded */
} m4e_report;

/* Events of the model's watched outputs (`count` of them) and where they go: `capacity` places for
   index, time and state (capacity x states). An event is a sign change of a watched output:
   `direction` > 0 rising, < 0 falling, 0 both. The state recorded is that at the far side of the
   crossing. Two crossings within one step go unseen. */
typedef struct {
    uint32_t count;
    const int32_t *direction, *terminal;
    uint64_t capacity;
    uint32_t *index;
    double *time, *state;
} m4e_events;

/* A block: instructions that compute some results from registers, of which the first hold time,
   states, inputs, parameters, hoisted values, literals and timely values. Operations and operands:
   internal.h. */
typedef struct {
    uint32_t code, d, a, b;
} m4e_instruction;

/* A block in compiled form. `fixed` is the register of the first input. Of a model of M4E_LANES
   lanes every number is one of each lane, side by side. */
typedef void m4e_kernel(const double *t, const double *x, const double *fixed, double *result);

typedef struct {
    m4e_instruction *code; /* the last one ends the block */
    uint64_t length;
    uint32_t *result; /* registers */
    uint32_t results, registers, timely; /* timely: it reads such values */
    m4e_kernel *kernel; /* runs instead of the instructions; NULL: none */
} m4e_block;

enum {
    M4E_RATES, M4E_OUTPUTS, M4E_DERIVATIVES, M4E_WATCHED, M4E_TIMELY, M4E_CORNERS, M4E_CONSTANTS,
    M4E_BLOCKS
};

M4E_API int m4e_abi(void);

/* NULL and a message where the bytes are not a program. The bytes are not kept. */
M4E_API m4e_program *m4e_program_read(const uint8_t *bytes, size_t size, char *message,
                                      size_t room);
M4E_API void m4e_program_free(m4e_program *program);
M4E_API void m4e_program_counts(const m4e_program *program, m4e_counts *counts);
/* Start values of parameters, inputs and states, one after the other. */
M4E_API const double *m4e_program_starts(const m4e_program *program);
/* Of each variable, in the order of the binary form: limits, flags, and the name (UTF-8). */
M4E_API const m4e_limits *m4e_program_limits(const m4e_program *program);
M4E_API const uint32_t *m4e_program_flags(const m4e_program *program);
M4E_API const char *m4e_program_name(const m4e_program *program, uint32_t variable);

/* `lanes` is 1 or M4E_LANES. Only the `selected` outputs are computed; `watched` ones are event
   functions. The program must outlive its models. NULL where memory is short or an index is out of
   range. */
M4E_API m4e_model *m4e_model_new(const m4e_program *program, uint32_t lanes, uint32_t selected,
                                 const uint32_t *outputs, uint32_t watched,
                                 const uint32_t *events);
M4E_API void m4e_model_free(m4e_model *model);
/* Block of a model, for a writer of kernels, who puts `kernel` there; NULL if there is none. */
M4E_API m4e_block *m4e_model_block(m4e_model *model, int which);

/* One lane only. Parameters: one value each; then `calculated` may be read. */
M4E_API void m4e_set_parameters(m4e_model *model, const double *p);
M4E_API void m4e_set_inputs(m4e_model *model, const double *u);
/* From now on the rates are computed with inputs u + (t - t0) (first + (t - t0) second / 2), until
   inputs are set again. The three arrays are not copied. */
M4E_API void m4e_set_input_curves(m4e_model *model, double t0, const double *u,
                                  const double *first, const double *second);
M4E_API void m4e_rates(m4e_model *model, double t, const double *x, double *result);
M4E_API void m4e_outputs(m4e_model *model, double t, const double *x, double *result);
M4E_API void m4e_calculated(m4e_model *model, double *result);
/* n x (n + 1), row by row: d rates / d x, then d rates / d t; 0 where the program has none, or
   while inputs follow curves, which are part of d / d t. */
M4E_API int m4e_jacobian(m4e_model *model, double t, const double *x, double *result);

/* Integrators of one model. `start` begins at (t, x), trying `step` [s] first: the `step` of the
   last report after a change of inputs or states, 0 where nothing is known. `advance` goes on until
   all `times` (ascending, s) are served, writing one row of states each, and never steps beyond
   `bound`. Calls may be cut anywhere: to one bound, one call or many give the same bits. */
M4E_API m4e_integrator *m4e_integrator_new(m4e_model *model, const m4e_options *options,
                                           const m4e_events *events);
M4E_API void m4e_integrator_free(m4e_integrator *integrator);
M4E_API void m4e_start(m4e_integrator *integrator, double t, const double *x, double step);
M4E_API int m4e_advance(m4e_integrator *integrator, double bound, size_t count,
                        const double *times, double *states, m4e_report *report);
/* One accepted step, not beyond `bound`: M4E_DONE, and where it ended. The same steps as `advance`
   to that bound takes; without event functions. */
M4E_API int m4e_step(m4e_integrator *integrator, double bound, double *state, m4e_report *report);
/* The states at the time that a failed `advance` or `step` reported. */
M4E_API void m4e_reached(const m4e_integrator *integrator, double *x);

/* A communication step of a co-simulation, from (t, x) to `end`, which leaves x there. If nothing
   was set since the step before (`held`), the integrator may go beyond `end`, look up the state
   there and go on from where it is next time; `ahead` tells if it has, and is its own: 0 at first.
   Steps of M4E_RK4, and those with a corner or a jump that depends on time, end at `end`. */
M4E_API int m4e_go_on(m4e_integrator *integrator, double t, double *x, double end, int held,
                      double step, int32_t *ahead, m4e_report *report);
/* What an integrator that is ahead goes on from, so many numbers for n states. */
#define M4E_KEPT(n) (4 + 10 * (size_t)(n))
M4E_API void m4e_keep(const m4e_integrator *integrator, double *kept);
M4E_API void m4e_take_up(m4e_integrator *integrator, const double *kept);

/* `models` simulations of a model of M4E_LANES lanes, explicit methods only; every array has one
   row per model. Each model keeps its own steps: its result is that of a single run to the bit. */
M4E_API int m4e_ensemble(m4e_model *model, const m4e_options *options, size_t models,
                         const double *p, const double *u, const double *x, size_t count,
                         const double *times, double *states, double *outputs,
                         m4e_report *reports);

/* Of the processor, as far as vectors of lanes are concerned: "avx512", "avx2" or "". */
M4E_API const char *m4e_instruction_set(void);

#if defined(__GNUC__) && !defined(M4E_SHARED)
#pragma GCC visibility pop
#endif

#endif
