/* Fuzzing of the loader and of what runs after it: no input may crash, leak or run away.

   With libFuzzer:  clang -fsanitize=fuzzer,address,undefined -DWITH_LIBFUZZER ...
   Without:         cc -fsanitize=address,undefined -I SRC fuzz_program.c SRC/{*}.c -lm
                    ./a.out COUNT SEED FILE...   mutates the programs in the files COUNT times.
   Most mutants get a right size and checksum again, so that the checks behind those are reached. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "m4e.h"

static unsigned long accepted;

static void run(const m4e_program *program, const m4e_counts *n) {
    static const double times[] = {0.0, 0.01, 0.02};
    const size_t states = n->states;
    double *x = calloc(8 * (states + 1) * (states + 2), sizeof *x);
    double *p = calloc(2 * ((size_t)n->parameters + n->inputs + 1), sizeof *p);
    double *rows = calloc(6 * (states + n->outputs + 1), sizeof *rows);
    uint32_t *all = calloc(n->outputs + (size_t)1, sizeof *all);
    for (uint32_t i = 0; i < n->outputs; ++i) all[i] = i;
    for (size_t i = 0; i < 2 * states; ++i) x[i] = 0.1 * (double)i;
    for (size_t i = 0; i < 2 * (size_t)n->parameters; ++i) p[i] = 1.0;
    m4e_model *one = m4e_model_new(program, 1, n->outputs, all, 0, NULL);
    m4e_model *many = m4e_model_new(program, M4E_LANES, n->outputs, all, 0, NULL);
    double *y = rows + 6 * states;
    if (one && many && x && p && rows) {
        m4e_report report, reports[2];
        m4e_set_parameters(one, p);
        m4e_set_inputs(one, p + 2 * (size_t)n->parameters);
        m4e_jacobian(one, 0.0, x, x + 2 * states);
        for (int method = M4E_RK45; method <= M4E_RODAS; ++method) {
            const m4e_options options = {method, 1e-3, 1e-3, INFINITY, 5, 0};
            m4e_simulate(one, &options, NULL, x, 3, times, rows, y, &report);
            if (method != M4E_RODAS)
                m4e_ensemble(many, &options, 2, p, p + 2 * (size_t)n->parameters, x, 3, times, rows,
                             y, reports);
        }
        if (n->calculated) {
            double *c = calloc(n->calculated, sizeof *c);
            if (c) m4e_calculated(one, c);
            free(c);
        }
    }
    m4e_model_free(one);
    m4e_model_free(many);
    free(x);
    free(p);
    free(rows);
    free(all);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    char message[200] = "";
    m4e_program *program = m4e_program_read(data, size, message, sizeof message);
    if (!program) {
        if (!message[0]) abort(); /* a refusal always says why */
        return 0;
    }
    m4e_counts counts;
    m4e_program_counts(program, &counts);
    ++accepted;
    run(program, &counts);
    m4e_program_free(program);
    return 0;
}

#ifndef WITH_LIBFUZZER
static uint64_t state;

static uint32_t next(uint32_t limit) { /* xorshift */
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return limit ? (uint32_t)(state >> 32) % limit : 0;
}

static void put(uint8_t *at, uint64_t value, int bytes) {
    for (int i = 0; i < bytes; ++i) at[i] = (uint8_t)(value >> (8 * i));
}

static void repair(uint8_t *data, size_t size) {
    uint32_t crc = 0xffffffff;
    put(data + 16, size, 8);
    for (size_t i = 16; i < size; ++i) {
        crc ^= data[i];
        for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (0xedb88320 & (0 - (crc & 1)));
    }
    put(data + 12, ~crc, 4);
}

static size_t mutate(uint8_t *data, size_t size, size_t room) {
    static const uint32_t odd[] = {0, 1, 2, 0x7f, 0xff, 0x100, 0xffff, 0xffffff, 0x7fffffff,
                                   0xfffffffe, 0xffffffff};
    for (uint32_t i = 1 + next(4); i-- > 0 && size > 0;) {
        const uint32_t at = next((uint32_t)size), kind = next(8);
        if (kind == 0) data[at] ^= (uint8_t)(1u << next(8));
        if (kind == 1) data[at] = (uint8_t)next(256);
        if (kind == 2) size = at;
        if (kind == 3 && size + 4 <= room) {
            memmove(data + at + 4, data + at, size - at);
            size += 4;
        }
        if (kind >= 4 && size > 28) { /* a word of the header, or of the body */
            const uint32_t word = kind < 6 ? 24 + 4 * next(10) : at & ~3u;
            if (word + 4 <= size) put(data + word, kind == 7 ? next(64) : odd[next(11)], 4);
        }
    }
    if (next(4) > 0 && size >= 64) repair(data, size);
    return size;
}

int main(int count, char **arguments) {
    const unsigned long wanted = count > 3 ? strtoul(arguments[1], NULL, 10) : 0;
    state = count > 3 ? strtoull(arguments[2], NULL, 10) * 2654435761u + 1 : 1;
    const size_t room = 1 << 20;
    uint8_t *seed = malloc(room), *data = malloc(room);
    unsigned long tried = 0;
    for (int f = 3; f < count && seed && data; ++f) {
        FILE *file = fopen(arguments[f], "rb");
        if (!file) continue;
        const size_t size = fread(seed, 1, room / 2, file);
        fclose(file);
        for (unsigned long i = 0; i < wanted / (unsigned long)(count - 3); ++i, ++tried) {
            memcpy(data, seed, size);
            const size_t mutated = mutate(data, size, room);
            uint8_t *exact = malloc(mutated + 1); /* so that reading past the end is seen */
            if (!exact) break;
            memcpy(exact, data, mutated);
            LLVMFuzzerTestOneInput(exact, mutated);
            free(exact);
        }
    }
    free(seed);
    free(data);
    printf("%lu inputs, %lu accepted\n", tried, accepted);
    return tried > 0 ? 0 : 1;
}
#endif
