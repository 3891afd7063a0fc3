/* Reading a program from its binary form, version 2. All numbers are little-endian.

     0  magic      8 bytes  89 'M' '4' 'E' 0d 0a 1a 0a
     8  version    u32
    12  checksum   u32      CRC-32 (zlib's) of all bytes from offset 16 on
    16  size       u64      of the whole, in bytes
    24  counts     u32 x 9  states, inputs, parameters, outputs, calculated, nodes, literals,
                            entries of the Jacobian, bytes of text
    60  zero       u32
    64  literals   f64 each
        start      f64 each for parameters, inputs, states
        limits     f64 minimum, maximum and nominal value of each variable
        nodes      u32 a, then u32 b, then u8 operation of all; a literal's, state's, input's or
                   parameter's a is its index; else a, b are earlier nodes; unused ones are 0;
                   zeros fill up to a multiple of 4
        roots      u32 node of each state's rate, each output, each calculated parameter
        Jacobian   u32 row, then u32 column, then u32 node of all entries: the derivative of rate
                   `row` by state `column`, or by time where column = states; ascending, others 0
        flags      u32 of each variable: 1 tunable, 2 local
        text       UTF-8, each piece ended by a zero byte: the program's name and description; then
                   name, unit, display unit, what it is the derivative of, description of each
                   variable. Order: parameters, inputs, states, outputs, calculated.

   Every count and index is checked before it is used. */
#include <stdio.h>
#include <stdlib.h>

#include "internal.h"

enum { VERSION = 2, CHECKED_FROM = 16, PIECES = 5 };
static const uint8_t MAGIC[8] = {0x89, 'M', '4', 'E', 0x0d, 0x0a, 0x1a, 0x0a};

typedef struct {
    uint8_t magic[8];
    uint32_t version, checksum;
    uint64_t size;
    uint32_t states, inputs, parameters, outputs, calculated, nodes, literals, entries, text, zero;
} header;

static uint32_t checksum(const uint8_t *p, size_t size) {
    uint32_t table[256], crc = 0xffffffff;
    for (uint32_t i = 0; i < 256; ++i) {
        uint32_t value = i;
        for (int bit = 0; bit < 8; ++bit) value = value >> 1 ^ (0xedb88320 & (0 - (value & 1)));
        table[i] = value;
    }
    for (size_t i = 0; i < size; ++i) crc = table[(crc ^ p[i]) & 255] ^ crc >> 8;
    return ~crc;
}

/* Message of what is wrong with the header, NULL if nothing is. */
static const char *header_problem(const header *h, const uint8_t *bytes, size_t size) {
    if (memcmp(h->magic, MAGIC, sizeof MAGIC) != 0) return "is not a program of m4e_fmi";
    if (h->version > VERSION) return "was written by a newer version of m4e_fmi";
    if (h->version != VERSION || h->zero != 0) return "has a damaged header";
    if (h->size > size) return "is truncated";
    if (h->size < size) return "has bytes after its end";
    if (checksum(bytes + CHECKED_FROM, size - CHECKED_FROM) != h->checksum)
        return "is damaged: its checksum does not match";
    return NULL;
}

typedef struct {
    const uint8_t *at;
    int failed; /* memory is short */
} cursor;

static void *take(cursor *c, uint64_t size) {
    void *copy = malloc((size_t)size + 1);
    if (copy)
        memcpy(copy, c->at, (size_t)size);
    else
        c->failed = 1;
    c->at += size;
    return copy;
}

static uint64_t variables(const m4e_counts *n) {
    return (uint64_t)n->states + n->inputs + n->parameters + n->outputs + n->calculated;
}

/* Size that the counts imply; they are below 2^32, so nothing overflows. */
static uint64_t implied_size(const m4e_counts *n, uint64_t text) {
    const uint64_t given = (uint64_t)n->parameters + n->inputs + n->states;
    const uint64_t doubles = n->literals + given + 3 * variables(n);
    const uint64_t roots = (uint64_t)n->states + n->outputs + n->calculated;
    const uint64_t words = 2 * (uint64_t)n->nodes + roots + 3 * (uint64_t)n->entries + variables(n);
    return sizeof(header) + 8 * doubles + 4 * words + (n->nodes + UINT64_C(3)) / 4 * 4 + text;
}

static const char *nodes_problem(const m4e_program *p) {
    const m4e_counts *n = &p->count;
    for (uint32_t k = 0; k < n->nodes; ++k) {
        const uint8_t op = p->op[k];
        uint32_t most = k; /* a is below this */
        if (op >= NODE_OPS) return "has an unknown operation";
        if (op == OP_LITERAL) most = n->literals;
        if (op == OP_TIME) most = 1;
        if (op == OP_STATE) most = n->states;
        if (op == OP_INPUT) most = n->inputs;
        if (op == OP_PARAMETER) most = n->parameters;
        if (p->a[k] >= most || p->b[k] >= (op >= FIRST_BINARY ? k : 1))
            return "has an operand out of range";
    }
    return NULL;
}

static int below(const uint32_t *values, size_t count, uint32_t limit) {
    for (size_t i = 0; i < count; ++i)
        if (values[i] >= limit) return 0;
    return 1;
}

static const char *roots_problem(const m4e_program *p) {
    const m4e_counts *n = &p->count;
    if (!below(p->rates, n->states, n->nodes) || !below(p->results, n->outputs, n->nodes) ||
        !below(p->constants, n->calculated, n->nodes) ||
        !below(p->derivatives, n->entries, n->nodes) || !below(p->rows, n->entries, n->states) ||
        !below(p->columns, n->entries, n->states + 1))
        return "has a result out of range";
    for (uint32_t i = 1; i < n->entries; ++i)
        if (p->rows[i] < p->rows[i - 1] ||
            (p->rows[i] == p->rows[i - 1] && p->columns[i] <= p->columns[i - 1]))
            return "has a Jacobian out of order";
    return NULL;
}

static const char *text_problem(const m4e_counts *n, const char *text, size_t size) {
    uint64_t pieces = 0;
    for (size_t i = 0; i < size; ++i) pieces += text[i] == 0;
    if (size == 0 || text[size - 1] != 0 || pieces != 2 + PIECES * variables(n))
        return "has damaged text";
    return NULL;
}

/* What a node depends on: parameters, time besides, or anything. */
enum { FIXED, TIMELY, MOVING };

static uint8_t variability(const m4e_program *p, uint32_t node, const uint8_t *how) {
    const uint8_t op = p->op[node];
    if (op == OP_LITERAL || op == OP_PARAMETER) return FIXED;
    if (op < FIRST_UNARY) return op == OP_TIME ? TIMELY : MOVING;
    const uint8_t a = how[p->a[node]], b = op >= FIRST_BINARY ? how[p->b[node]] : a;
    return a > b ? a : b;
}

/* Arguments of operations that bend or jump where two of them are equal; or one, twice, is zero. */
static void add_corner(m4e_program *p, uint32_t node) {
    const uint8_t op = p->op[node];
    const uint32_t a = p->a[node], b = op >= FIRST_BINARY ? p->b[node] : a;
    if (op != OP_ABS && op != OP_SIGN && op != OP_MIN && op != OP_MAX) return;
    if (op >= FIRST_BINARY && a == b) return;
    p->corners[2 * p->corner_count] = a;
    p->corners[2 * p->corner_count++ + 1] = b;
}

/* Lists the timely nodes that rates, or what moves in them, read, and gives them the registers from
   `first` on; none where they take less work than it is to keep them. Lists their corners, too. */
static void assign_timely(m4e_program *p, uint32_t first, const uint8_t *how, uint8_t *needed) {
    enum { WITHIN = 1, READ = 2, LEAST_WORK = 200 };
    m4e_counts *n = &p->count;
    uint32_t work = 0;
    memset(needed, 0, n->nodes);
    for (uint32_t i = 0; i < n->states; ++i) needed[p->rates[i]] = READ;
    for (uint32_t k = n->nodes; k-- > 0;) {
        if (!needed[k] || p->op[k] < FIRST_UNARY) continue;
        needed[p->a[k]] |= how[k] == MOVING ? READ : WITHIN;
        if (p->op[k] >= FIRST_BINARY) needed[p->b[k]] |= how[k] == MOVING ? READ : WITHIN;
        work += how[k] == TIMELY;
        if (how[k] == TIMELY) add_corner(p, k);
    }
    for (uint32_t k = 0; work >= LEAST_WORK && k < n->nodes; ++k) {
        if (how[k] != TIMELY || !(needed[k] & READ) || p->op[k] < FIRST_UNARY) continue;
        p->slot[k] = first + n->timely;
        p->timely[n->timely++] = k;
    }
}

/* Nodes that depend on parameters only and are read by others, or are results, are computed once
   per change of a parameter. Also gives the leaves their registers. */
static int assign_slots(m4e_program *p) {
    m4e_counts *n = &p->count;
    uint8_t *how = calloc(n->nodes + (size_t)1, 1), *read = calloc(n->nodes + (size_t)1, 1);
    if (!how || !read) goto done;
    for (uint32_t i = 0; i < n->states; ++i) read[p->rates[i]] = 1;
    for (uint32_t i = 0; i < n->outputs; ++i) read[p->results[i]] = 1;
    for (uint32_t i = 0; i < n->calculated; ++i) read[p->constants[i]] = 1;
    for (uint32_t i = 0; i < n->entries; ++i) read[p->derivatives[i]] = 1;
    for (uint32_t k = 0; k < n->nodes; ++k) {
        const uint8_t op = p->op[k];
        const int leaf = op < FIRST_UNARY, binary = op >= FIRST_BINARY;
        how[k] = variability(p, k, how);
        if (!leaf && how[k] != FIXED) read[p->a[k]] = 1;
        if (binary && how[k] != FIXED) read[p->b[k]] = 1;
    }
    const uint32_t input = 1 + n->states, parameter = input + n->inputs;
    const uint32_t hoisted = parameter + n->parameters;
    for (uint32_t k = 0; k < n->nodes; ++k) {
        if (p->op[k] < FIRST_UNARY || how[k] != FIXED || !read[k]) continue;
        p->slot[k] = hoisted + n->hoisted;
        p->hoisted[n->hoisted++] = k;
    }
    const uint32_t literal = hoisted + n->hoisted;
    const uint32_t first[] = {literal, 0, 1, input, parameter};
    for (uint32_t k = 0; k < n->nodes; ++k)
        if (p->op[k] < FIRST_UNARY) p->slot[k] = first[p->op[k]] + p->a[k];
    p->first_timely = literal + n->literals;
    assign_timely(p, p->first_timely, how, read);
    p->unread = p->first_timely + n->timely;
done:
    free(how);
    free(read);
    return how && read;
}

static const char *read_body(m4e_program *p, const uint8_t *bytes, size_t text) {
    const m4e_counts *n = &p->count;
    cursor c = {bytes + sizeof(header), 0};
    const size_t word = sizeof(uint32_t), given = (size_t)n->parameters + n->inputs + n->states;
    p->literals = take(&c, n->literals * sizeof *p->literals);
    p->starts = take(&c, given * sizeof *p->starts);
    p->limits = take(&c, variables(n) * sizeof *p->limits);
    p->a = take(&c, n->nodes * word);
    p->b = take(&c, n->nodes * word);
    p->op = take(&c, (n->nodes + (size_t)3) / 4 * 4);
    p->rates = take(&c, n->states * word);
    p->results = take(&c, n->outputs * word);
    p->constants = take(&c, n->calculated * word);
    p->rows = take(&c, n->entries * word);
    p->columns = take(&c, n->entries * word);
    p->derivatives = take(&c, n->entries * word);
    p->flags = take(&c, variables(n) * word);
    p->text = take(&c, text);
    p->slot = malloc((n->nodes + (size_t)1) * word);
    p->hoisted = malloc((n->nodes + (size_t)1) * word);
    p->timely = malloc((n->nodes + (size_t)1) * word);
    p->corners = malloc(2 * (n->nodes + (size_t)1) * word);
    if (c.failed || !p->slot || !p->hoisted || !p->timely || !p->corners)
        return "does not fit into memory";
    memset(p->slot, 0xff, n->nodes * word);
    const char *problem = nodes_problem(p);
    if (!problem) problem = roots_problem(p);
    if (!problem) problem = text_problem(n, p->text, text);
    if (!problem && !assign_slots(p)) problem = "does not fit into memory";
    for (uint32_t i = 0; !problem && i < n->calculated; ++i) {
        const uint32_t slot = p->slot[p->constants[i]];
        if (slot < 1 + n->states + n->inputs || slot >= p->first_timely)
            problem = "has a calculated parameter that varies";
    }
    return problem;
}

m4e_program *m4e_program_read(const uint8_t *bytes, size_t size, char *message, size_t room) {
    m4e_program *p = NULL;
    header h;
    const char *problem = "is too short to be a program";
    if (size >= sizeof h) {
        memcpy(&h, bytes, sizeof h);
        problem = header_problem(&h, bytes, size);
    }
    if (!problem) {
        const m4e_counts count = {h.states, h.inputs, h.parameters, h.outputs, h.calculated,
                                  h.nodes, h.literals, h.entries, 0, 0};
        if (implied_size(&count, h.text) != size)
            problem = "has counts that do not match its size";
        else if (variables(&count) + count.nodes + count.literals >= M4E_MOST)
            problem = "is larger than this version can run";
        else if (!(p = calloc(1, sizeof *p)))
            problem = "does not fit into memory";
        else {
            p->count = count;
            problem = read_body(p, bytes, h.text);
        }
    }
    if (!problem) return p;
    m4e_program_free(p);
    snprintf(message, room, "%s", problem);
    return NULL;
}

void m4e_program_free(m4e_program *p) {
    if (!p) return;
    void *parts[] = {p->op,      p->a,         p->b,    p->slot,    p->literals,    p->rates,
                     p->results, p->constants, p->rows, p->columns, p->derivatives, p->hoisted,
                     p->timely,  p->corners,   p->starts, p->limits, p->flags, p->text};
    for (size_t i = 0; i < sizeof parts / sizeof *parts; ++i) free(parts[i]);
    free(p);
}

void m4e_program_counts(const m4e_program *program, m4e_counts *counts) {
    *counts = program->count;
}

const double *m4e_program_starts(const m4e_program *program) { return program->starts; }

const m4e_limits *m4e_program_limits(const m4e_program *program) { return program->limits; }

const uint32_t *m4e_program_flags(const m4e_program *program) { return program->flags; }

const char *m4e_program_name(const m4e_program *program, uint32_t variable) {
    const char *piece = program->text;
    for (uint64_t i = 0; i < 2 + PIECES * (uint64_t)variable; ++i) piece += strlen(piece) + 1;
    return piece;
}

int m4e_abi(void) { return M4E_ABI; }
