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
#include "mutate.h"

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
            m4e_integrator *alone = m4e_integrator_new(one, &options, NULL);
            if (alone) m4e_start(alone, times[0], x, 0.0);
            if (alone) m4e_advance(alone, times[2], 3, times, rows, &report);
            m4e_integrator_free(alone);
            m4e_outputs(one, times[0], x, y);
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
            if (next(4) > 0 && mutated >= 64) repair(data, mutated);
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
