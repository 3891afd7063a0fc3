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

#define M4E_AB const double a = r[code->a], b = r[code->b];
#define M4E_STORE(name, expression) r[code->d] = (expression); M4E_NEXT(name)
#define M4E_RUN1(name, expression) \
    M4E_CASE(name) { const double a = r[code->a]; M4E_STORE(name, expression) }
#define M4E_RUN2(name, expression) M4E_CASE(name) { M4E_AB M4E_STORE(name, expression) }
#define M4E_RUN3(name, expression) \
    M4E_CASE(name) { M4E_AB const double c = r[code->code >> 8]; M4E_STORE(name, expression) }

void m4e_run(const instruction *code, double *r) {
    M4E_RUN {
        M4E_UNARY(M4E_RUN1)
        M4E_BINARY(M4E_RUN2)
        M4E_FUSED(M4E_RUN3)
        M4E_CASE(SINCOS) {
            const uint32_t count = code->code >> 8;
            run_sincos(code, count, r);
            code += count;
            M4E_DISPATCH
        }
        M4E_CASE(END) return;
    }
}
