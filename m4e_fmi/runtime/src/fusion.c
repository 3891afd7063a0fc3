/* Which additions, subtractions and products share an instruction with another such operation, the
   only one that reads them. An instruction costs a jump, and its result is written and read again,
   which takes longer than an addition; so there shall be as few as can be. From the leaves on, each
   operation knows how few instructions compute it; then, from the results down, the choices that
   led there are taken. None of this changes a rounding. */
#include <stdlib.h>

#include "internal.h"

/* Alone, with its first, its second operand or both within; chained: with the product on one side
   and that of the sum or difference on the other; or within another. */
enum { ALONE, WITH_FIRST, WITH_SECOND, PAIRED, CHAINED, WITHIN, WAYS = WITHIN };

/* Add, sub, mul as 0, 1, 2; -1 for other operations. */
static int ring(const fusion *f, uint32_t node) {
    const uint8_t op = f->program->op[node];
    return op == OP_ADD ? 0 : op == OP_SUB ? 1 : op == OP_MUL ? 2 : -1;
}

static int may_be_within(const fusion *f, uint32_t node) {
    return f->uses[node] == 1 && ring(f, node) >= 0;
}

static int is_product(const fusion *f, uint32_t node) {
    return may_be_within(f, node) && f->program->op[node] == OP_MUL;
}

/* A sum or difference of anything, `rest`, and a product, which is returned; M4E_NONE if not. */
static uint32_t product_of(const fusion *f, uint32_t node, uint32_t *rest) {
    const uint32_t a = f->program->a[node], b = f->program->b[node];
    const uint8_t op = f->program->op[node];
    const int second = (op == OP_ADD || op == OP_SUB) && is_product(f, b);
    if (!second && !(op == OP_ADD && is_product(f, a))) return M4E_NONE;
    *rest = second ? a : b;
    return second ? b : a;
}

typedef struct {
    uint32_t sum, base, first, second; /* (base +- first) +- second */
} chain;

static int find_chain(const fusion *f, uint32_t node, chain *c) {
    c->second = product_of(f, node, &c->sum);
    if (c->second == M4E_NONE || !may_be_within(f, c->sum)) return 0;
    c->first = product_of(f, c->sum, &c->base);
    return c->first != M4E_NONE;
}

/* Instructions for a node, if it is not computed within another. */
static uint32_t apart(const fusion *f, uint32_t node) {
    return may_be_within(f, node) ? f->cost[node] : 0;
}

static uint32_t inside(const fusion *f, uint32_t node) {
    return apart(f, f->program->a[node]) + apart(f, f->program->b[node]);
}

static void choose(const fusion *f, uint32_t node) {
    const uint32_t a = f->program->a[node], b = f->program->b[node];
    const int first = may_be_within(f, a), second = may_be_within(f, b);
    uint32_t cost[WAYS];
    memset(cost, 0xff, sizeof cost);
    cost[ALONE] = apart(f, a) + apart(f, b);
    if (first) cost[WITH_FIRST] = inside(f, a) + apart(f, b);
    if (second) cost[WITH_SECOND] = apart(f, a) + inside(f, b);
    if (first && second) cost[PAIRED] = inside(f, a) + inside(f, b);
    chain c;
    if (find_chain(f, node, &c))
        cost[CHAINED] = apart(f, c.base) + inside(f, c.first) + inside(f, c.second);
    f->how[node] = ALONE;
    for (uint8_t way = 1; way < WAYS; ++way)
        if (cost[way] < cost[f->how[node]]) f->how[node] = way;
    f->cost[node] = 1 + cost[f->how[node]];
}

static void take_in(const fusion *f, uint32_t node) {
    const uint32_t a = f->program->a[node], b = f->program->b[node];
    const uint8_t how = f->how[node];
    chain c;
    if (how == WITH_FIRST || how == PAIRED) f->how[a] = WITHIN;
    if (how == WITH_SECOND || how == PAIRED) f->how[b] = WITHIN;
    if (how == CHAINED && find_chain(f, node, &c))
        f->how[c.sum] = f->how[c.first] = f->how[c.second] = WITHIN;
}

int m4e_fuse(fusion *f) {
    const uint32_t nodes = f->program->count.nodes;
    f->cost = calloc(nodes + (size_t)1, sizeof *f->cost);
    f->how = calloc(nodes + (size_t)1, 1);
    if (!f->cost || !f->how) return 0;
    for (uint32_t k = 0; k < nodes; ++k)
        if (f->uses[k] && ring(f, k) >= 0) choose(f, k);
    for (uint32_t k = nodes; k-- > 0;)
        if (f->how[k] != WITHIN) take_in(f, k);
    return 1;
}

void m4e_fusion_free(fusion *f) {
    free(f->cost);
    free(f->how);
}

int m4e_is_within(const fusion *f, uint32_t node) { return f->how[node] == WITHIN; }

int m4e_fused(const fusion *f, uint32_t node, instruction form[2]) {
    const m4e_program *p = f->program;
    const uint8_t op = p->op[node], how = f->how[node];
    const uint32_t a = p->a[node], b = op >= FIRST_BINARY ? p->b[node] : a;
    form[0] = (instruction){op, node, a, b};
    if (how == ALONE) return 1;
    if (how == WITH_FIRST || how == WITH_SECOND) {
        const uint32_t part = how == WITH_FIRST ? a : b, other = how == WITH_FIRST ? b : a;
        const int outer = op == OP_SUB && how == WITH_SECOND ? 3 : ring(f, node);
        const uint32_t code = (uint32_t)(FIRST_FUSED + 3 * outer + ring(f, part));
        form[0] = (instruction){code | other << 8, node, p->a[part], p->b[part]};
        return 1;
    }
    uint32_t code = (uint32_t)(FIRST_PAIRED + 9 * ring(f, node) + 3 * ring(f, b) + ring(f, a));
    uint32_t first = a, second = b;
    chain c;
    if (how == CHAINED && find_chain(f, node, &c)) {
        code = (uint32_t)(FIRST_CHAINED + 2 * ring(f, c.sum) + ring(f, node)) | c.base << 8;
        first = c.first;
        second = c.second;
    }
    form[0] = (instruction){code, node, p->a[first], p->b[first]};
    form[1] = (instruction){OP_MORE, M4E_NONE, p->a[second], p->b[second]};
    return 2;
}
