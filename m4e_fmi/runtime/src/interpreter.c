/* Running instructions on one register file. */
#include "dispatch.h"
#include "functions.h"

enum { CHUNK = 64 };

/* `count` consecutive OP_SINCOS, as vectors. */
static void run_sincos(const instruction *code, uint32_t count, double *r) {
    if (count == 1) {
        el_sincos(r[code->a], &r[code->b], &r[code->d]);
        return;
    }
    double x[CHUNK], s[CHUNK], c[CHUNK];
    while (count > 0) {
        const uint32_t n = count < CHUNK ? count : CHUNK;
        for (uint32_t i = 0; i < n; ++i) x[i] = r[code[i].a];
        el_sincos_many(n, x, s, c);
        for (uint32_t i = 0; i < n; ++i) {
            r[code[i].b] = s[i];
            r[code[i].d] = c[i];
        }
        code += n;
        count -= n;
    }
}

#define M4E_AB M4E_READ_AB const double a = r[M4E_A], b = r[M4E_B];
#define M4E_EF M4E_READ_EF const double e = r[M4E_E], f = r[M4E_F];
#define M4E_STORE(name, expression, count)                                                        \
    r[place] = (expression);                                                                      \
    M4E_NEXT(name, count)
#define M4E_RUN1(name, expression)                                                                \
    M4E_CASE(name) { const double a = r[code->a]; M4E_STORE(name, expression, 1) }
#define M4E_RUN2(name, expression) M4E_CASE(name) { M4E_AB M4E_STORE(name, expression, 1) }
#define M4E_RUN3(name, expression)                                                                \
    M4E_CASE(name) { M4E_AB const double c = r[M4E_C]; M4E_STORE(name, expression, 1) }
#define M4E_RUN4(name, expression) M4E_CASE(name) { M4E_AB M4E_EF M4E_STORE(name, expression, 2) }
#define M4E_RUN5(name, expression)                                                                \
    M4E_CASE(name) { M4E_AB const double c = r[M4E_C]; M4E_EF M4E_STORE(name, expression, 2) }

void m4e_run(const instruction *code, double *r) {
    M4E_RUN {
        M4E_UNARY(M4E_RUN1)
        M4E_BINARY(M4E_RUN2)
        M4E_FUSED(M4E_RUN3)
        M4E_CHAINED(M4E_RUN5)
        M4E_PAIRED(M4E_RUN4)
        M4E_CASE(SINCOS) {
            run_sincos(code, M4E_C, r);
            M4E_SKIP(M4E_C)
        }
        M4E_CASE(END) return;
    }
}
