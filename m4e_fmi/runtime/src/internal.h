/* What the parts of the runtime share: operations, programs, blocks of instructions, models. */
#ifndef M4E_INTERNAL_H
#define M4E_INTERNAL_H

#include <math.h>
#include <string.h>

#include "clones.h"
#include "m4e.h"
#include "operations.h"

#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "programs are read, and instructions dispatched, on little-endian processors only"
#endif

#ifdef __GNUC__
#pragma GCC visibility push(hidden)
#endif

#define M4E_NAME(name, expression) OP_##name,
enum {
    OP_LITERAL, OP_TIME, OP_STATE, OP_INPUT, OP_PARAMETER,
    M4E_UNARY(M4E_NAME) M4E_BINARY(M4E_NAME)
    NODE_OPS, /* what follows occurs in instructions only */
    FUSED_BASE = NODE_OPS - 1,
    M4E_FUSED(M4E_NAME)
    M4E_CHAINED(M4E_NAME)
    M4E_PAIRED(M4E_NAME)
    OP_SINCOS, OP_MORE, OP_END, OPS
};
#undef M4E_NAME
enum {
    FIRST_UNARY = OP_NEG, FIRST_BINARY = OP_ADD, FIRST_FUSED = OP_ADD_ADD,
    FIRST_CHAINED = OP_CHAIN_ADD_ADD, FIRST_PAIRED = OP_ADD_ADD_ADD
};

#define M4E_NONE UINT32_MAX
#define M4E_MOST (1u << 24) /* nodes, registers: an index fits the upper bits of a code */

/* Registers of a model, in this order: time, states, inputs, parameters, hoisted values, literals,
   timely values (timely.c), one that nobody reads, temporaries. `slot[node]` is the register of a
   node that has one for good, M4E_NONE for what each block computes. */
struct m4e_program {
    m4e_counts count;
    uint8_t *op;
    uint32_t *a, *b, *slot;
    double *literals, *starts;
    m4e_limits *limits;
    uint32_t *flags;
    char *text;
    uint32_t *rates, *results, *constants, *rows, *columns, *derivatives;
    uint32_t *hoisted, *timely; /* nodes, ascending */
    uint32_t *corners;             /* pairs of nodes, see add_corner */
    uint32_t corner_count;
    uint32_t first_timely, unread; /* registers after the literals, after the timely values */
};

/* code = operation + 256 c (for OP_SINCOS c is the count of consecutive ones); result d;
   OP_SINCOS puts the sine of a into b and the cosine into d. Chained and paired operations have e
   and f as the a and b of the OP_MORE after them. */
typedef m4e_instruction instruction;
typedef m4e_block block;
typedef void runner(const instruction *code, double *registers);

/* Timely values that a model has, and will need. */
enum { FORESEEN = 2 * M4E_LANES };
typedef struct {
    double now;           /* s; time of those in the registers, nan: none */
    runner *run;          /* on M4E_LANES lanes */
    double *wide;         /* registers on M4E_LANES lanes; NULL where there is nothing to foresee */
    int stale;            /* their fixed values are not those of the model */
    uint32_t count;       /* of the times foreseen */
    double time[FORESEEN], *values; /* s; [time][value] */
    void *memory;
} foresight;

struct m4e_model {
    const m4e_program *program;
    uint32_t lanes;
    runner *run;
    double *registers; /* [register][lane] */
    void *memory;
    block *blocks[M4E_BLOCKS];
    foresight timely;
    double *entries; /* of the Jacobian */
    double *sides;   /* of the corners, at two times */
    double curves_from;            /* s; t0 of the curves */
    const double *curves[3];       /* of the inputs: value, first and second derivative; or NULL */
};

/* How each operation becomes an instruction, if `uses` nodes and results read each. */
typedef struct {
    const m4e_program *program;
    const uint32_t *uses;
    uint32_t *cost; /* instructions for a node and what only it needs */
    uint8_t *how;
} fusion;
int m4e_fuse(fusion *f); /* 0: memory is short */
void m4e_fusion_free(fusion *f);
int m4e_is_within(const fusion *f, uint32_t node); /* it is part of another's instruction */
/* Its instruction, with nodes for registers; returns 2 if it takes two, one being OP_MORE. */
int m4e_fused(const fusion *f, uint32_t node, instruction form[2]);

/* Instructions that compute `roots`: the hoisted or the timely values themselves, or what reads
   both from their registers. */
enum { OF_HOISTED, OF_TIMELY, OF_ALL };
block *m4e_block_new(const m4e_program *program, uint32_t count, const uint32_t *roots, int kind);
void m4e_block_free(block *b);
runner m4e_run;
runner *m4e_lanes_runner(void); /* on M4E_LANES register files, for this processor */

/* timely.c; 0: memory is short */
int m4e_timely_new(m4e_model *m);
void m4e_timely_free(m4e_model *m);
/* The values in the registers are those of t, one time per lane. */
void m4e_timely_at(m4e_model *m, const double *t);
/* The model will soon need values at these times. */
void m4e_foresee(m4e_model *m, uint32_t count, const double *times);
/* A parameter has changed. */
void m4e_timely_forget(m4e_model *m);

/* A block at (t, x): one time per lane, vectors as [component][lane]. */
void m4e_evaluate(m4e_model *model, int which, const double *t, const double *x, double *result);
void m4e_compute_constants(m4e_model *model);

#ifdef __GNUC__
#pragma GCC visibility pop
#endif

#endif
