/* From nodes to instructions: which are needed, in what order, fused, in which registers.

   Order: by depth of sines and cosines (how many lie on the way from the leaves), those of one
   depth first and together, so that they are computed as vectors. Within a depth it depends on what
   the processor waits for. Where few operations can be done side by side, as in a chain of hinges
   in the plane, that is the longest chain of them: its next one comes first, so that there is
   always something to do meanwhile. Where there are many, it is the jump to an operation that was
   not foreseen: then as soon as they can be done, by levels, since a level of a chain of bodies is
   one operation for each body. Of what is equal in that, like operations together. Registers are
   allotted by linear scan: one is free again after the last instruction that reads it. None of this
   changes a rounding. */
#include <stdlib.h>

#include "internal.h"

typedef struct {
    const m4e_program *program;
    int kind;
    uint32_t *uses;  /* by needed nodes and roots; 0: not needed */
    uint32_t *order; /* needed nodes, as they will be computed */
    uint32_t *where; /* of a trigonometric argument: its instruction; later: register of a node */
    uint32_t *last;  /* instruction that reads a node last */
    fusion fused;
    uint32_t needed;
    block *out;
} planner;

enum { THROUGH_REGISTER = 3, SIDE_BY_SIDE = 4 /* operations, on average, are many */ };

static int is_trig(uint8_t op) { return op == OP_SIN || op == OP_COS; }

/* A register for good whose value this block computes. */
static int own(const planner *s, uint32_t node) {
    const uint32_t slot = s->program->slot[node];
    if (slot == M4E_NONE || s->program->op[node] < FIRST_UNARY) return 0;
    return s->kind == (slot < s->program->first_timely ? OF_HOISTED : OF_TIMELY);
}

/* Nodes that have a register for good, which another block fills. */
static int available(const planner *s, uint32_t node) {
    return s->program->slot[node] != M4E_NONE && !own(s, node);
}

static void count_uses(planner *s, uint32_t count, const uint32_t *roots) {
    const m4e_program *p = s->program;
    for (uint32_t i = 0; i < count; ++i) ++s->uses[roots[i]];
    for (uint32_t k = p->count.nodes; k-- > 0;) {
        if (available(s, k)) {
            s->out->timely |= s->uses[k] > 0 && p->slot[k] >= p->first_timely;
            s->uses[k] = 0;
        }
        if (s->uses[k] == 0) continue;
        ++s->needed;
        ++s->uses[p->a[k]];
        if (p->op[k] >= FIRST_BINARY) ++s->uses[p->b[k]];
    }
}

/* How long a result waits for a node, at most, in operations: what an instruction of its own leaves
   in a register is written and read again, which takes as long as two or three of them. */
static uint32_t heights(const planner *s, uint32_t *height) {
    const m4e_program *p = s->program;
    uint32_t most = 0;
    for (uint32_t k = p->count.nodes; k-- > 0;) {
        if (s->uses[k] == 0) continue;
        const uint32_t spent = m4e_is_within(&s->fused, k) ? 1 : THROUGH_REGISTER;
        const uint32_t operand[] = {p->a[k], p->op[k] >= FIRST_BINARY ? p->b[k] : p->a[k]};
        for (int i = 0; i < 2; ++i)
            if (height[operand[i]] < height[k] + spent) height[operand[i]] = height[k] + spent;
        if (height[k] > most) most = height[k];
    }
    return most;
}

/* How many instructions must be done before each node's own, one after the other, at least. */
static void levels(const planner *s, uint32_t *level) {
    const m4e_program *p = s->program;
    for (uint32_t k = 0; k < p->count.nodes; ++k) {
        level[k] = 0;
        if (s->uses[k] == 0) continue;
        const uint32_t operand[] = {p->a[k], p->op[k] >= FIRST_BINARY ? p->b[k] : p->a[k]};
        for (int i = 0; i < 2; ++i) {
            const uint32_t o = operand[i], after = level[o] + !m4e_is_within(&s->fused, o);
            if (s->uses[o] > 0 && level[k] < after) level[k] = after;
        }
    }
}

/* Even for sines and cosines, odd for what comes after them. */
static void depths(const planner *s, uint32_t *depth) {
    const m4e_program *p = s->program;
    for (uint32_t k = 0; k < p->count.nodes; ++k) {
        depth[k] = 1;
        if (s->uses[k] == 0) continue;
        depth[k] = depth[p->a[k]] | 1;
        if (p->op[k] >= FIRST_BINARY && depth[p->b[k]] > depth[k]) depth[k] = depth[p->b[k]] | 1;
        depth[k] += (uint32_t)is_trig(p->op[k]);
    }
}

/* Stable counting sort of the needed nodes by their keys, all below `keys`. */
static void sort(planner *s, const uint32_t *key, uint32_t keys, uint32_t *place,
                 uint32_t *sorted) {
    uint32_t total = 0;
    memset(place, 0, keys * sizeof *place);
    for (uint32_t i = 0; i < s->needed; ++i) ++place[key[s->order[i]]];
    for (uint32_t d = 0; d < keys; ++d) {
        const uint32_t here = place[d];
        place[d] = total;
        total += here;
    }
    for (uint32_t i = 0; i < s->needed; ++i) sorted[place[key[s->order[i]]]++] = s->order[i];
    memcpy(s->order, sorted, s->needed * sizeof *sorted);
}

/* By operation, then by level or by what waits for a node, then by depth: the last sort decides
   first. */
static int order(planner *s) {
    const uint32_t nodes = s->program->count.nodes, room = (THROUGH_REGISTER + 1) * nodes + OPS;
    uint32_t *key = calloc(2 * (size_t)nodes + room, sizeof *key), count = 0;
    instruction form[2];
    if (!key) return 0;
    uint32_t *sorted = key + nodes, *place = sorted + nodes;
    for (uint32_t k = 0; k < nodes; ++k) {
        m4e_fused(&s->fused, k, form);
        key[k] = form->code & 255;
        if (s->uses[k] > 0) s->order[count++] = k;
    }
    sort(s, key, OPS, place, sorted);
    memset(key, 0, nodes * sizeof *key);
    const uint32_t most = heights(s, key);
    if (s->needed > SIDE_BY_SIDE * (uint64_t)most)
        levels(s, key);
    else
        for (uint32_t k = 0; k < nodes; ++k) key[k] = most - key[k];
    sort(s, key, most + 1, place, sorted);
    depths(s, key);
    sort(s, key, 2 * nodes + 2, place, sorted);
    free(key);
    return 1;
}

static instruction *append(planner *s, instruction i) {
    instruction *place = &s->out->code[s->out->length++];
    *place = i;
    return place;
}

/* One instruction for the sine and the cosine of an argument. */
static void append_trig(planner *s, uint32_t k) {
    const uint32_t argument = s->program->a[k], place = s->where[argument];
    instruction *i = place == M4E_NONE ? NULL : &s->out->code[place];
    if (!i) {
        s->where[argument] = (uint32_t)s->out->length;
        i = append(s, (instruction){OP_SINCOS, M4E_NONE, argument, M4E_NONE});
    }
    *(s->program->op[k] == OP_SIN ? &i->b : &i->d) = k;
}

static void emit(planner *s) {
    const m4e_program *p = s->program;
    memset(s->where, 0xff, (2 * (size_t)p->count.nodes + 2) * sizeof *s->where);
    for (uint32_t i = 0; i < s->needed; ++i) {
        const uint32_t k = s->order[i];
        if (m4e_is_within(&s->fused, k)) continue;
        if (is_trig(p->op[k])) {
            append_trig(s, k);
            continue;
        }
        instruction form[2];
        const int count = m4e_fused(&s->fused, k, form);
        for (int j = 0; j < count; ++j) append(s, form[j]);
    }
    uint32_t run = 0;
    for (uint64_t i = s->out->length; i-- > 0;) {
        const uint32_t op = s->out->code[i].code & 255;
        run = op == OP_SINCOS && run < 0xffffff ? run + 1 : 0;
        if (op == OP_SINCOS) s->out->code[i].code = OP_SINCOS | run << 8;
    }
}

/* Whether there is a c, the upper bits of the code. */
static int has_third(uint32_t op) { return op >= FIRST_FUSED && op < FIRST_PAIRED; }

/* Registers read by an instruction: its a, its b unless that is a result, its c. */
static size_t operands(const instruction *i, uint32_t *node) {
    const uint32_t op = i->code & 255;
    size_t count = 0;
    node[count++] = i->a;
    if (op != OP_SINCOS && i->b != i->a) node[count++] = i->b;
    if (has_third(op) && i->code >> 8 != i->a && i->code >> 8 != i->b)
        node[count++] = i->code >> 8;
    return count;
}

typedef struct {
    uint32_t *free, count, next;
} pool;

static uint32_t take(planner *s, pool *registers, uint32_t node) {
    if (node == M4E_NONE) return s->program->unread;
    if (own(s, node)) return s->where[node] = s->program->slot[node];
    const uint32_t r = registers->count ? registers->free[--registers->count] : registers->next++;
    return s->where[node] = r;
}

static void allot(planner *s, uint32_t count, const uint32_t *roots) {
    const m4e_program *p = s->program;
    block *out = s->out;
    uint32_t node[3];
    pool registers = {s->order, 0, p->unread + 1};
    for (uint32_t k = 0; k < p->count.nodes; ++k) s->where[k] = available(s, k) ? p->slot[k] : 0;
    for (uint64_t i = 0; i < out->length; ++i)
        for (size_t j = operands(&out->code[i], node); j-- > 0;) s->last[node[j]] = (uint32_t)i;
    for (uint32_t i = 0; i < count; ++i) s->last[roots[i]] = M4E_NONE;
    for (uint64_t i = 0; i < out->length; ++i) {
        instruction *now = &out->code[i];
        const uint32_t op = now->code & 255;
        for (size_t j = operands(now, node); j-- > 0;)
            if (s->last[node[j]] == i && s->where[node[j]] > p->unread)
                registers.free[registers.count++] = s->where[node[j]];
        if (has_third(op)) now->code = op | s->where[now->code >> 8] << 8;
        now->a = s->where[now->a];
        now->b = op == OP_SINCOS ? take(s, &registers, now->b) : s->where[now->b];
        now->d = take(s, &registers, now->d);
    }
    append(s, (instruction){OP_END, 0, 0, 0});
    out->registers = registers.next;
    for (uint32_t i = 0; i < count; ++i) out->result[i] = s->where[roots[i]];
}

block *m4e_block_new(const m4e_program *program, uint32_t count, const uint32_t *roots, int kind) {
    const size_t n = program->count.nodes + (size_t)1;
    planner s = {.program = program, .kind = kind};
    uint32_t *memory = calloc(5 * n, sizeof *memory);
    int done = 0;
    s.out = calloc(1, sizeof *s.out);
    if (memory && s.out) {
        s.uses = memory;
        s.order = memory + n;
        s.last = memory + 2 * n;
        s.where = memory + 3 * n;
        s.out->result = malloc((count + (size_t)1) * sizeof *s.out->result);
        s.out->results = count;
        count_uses(&s, count, roots);
        s.fused = (fusion){.program = program, .uses = s.uses};
        s.out->code = malloc((s.needed + (size_t)1) * sizeof *s.out->code);
        done = s.out->result && s.out->code && m4e_fuse(&s.fused) && order(&s);
    }
    if (done) {
        emit(&s);
        allot(&s, count, roots);
    } else {
        m4e_block_free(s.out);
        s.out = NULL;
    }
    free(memory);
    m4e_fusion_free(&s.fused);
    return s.out;
}

void m4e_block_free(block *b) {
    if (!b) return;
    free(b->code);
    free(b->result);
    free(b);
}
