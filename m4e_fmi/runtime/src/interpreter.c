/* Running instructions: on one register file, or on M4E_LANES of them side by side. */
#include "elementary.h"
#include "internal.h"

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

/* Every operation jumps straight to the next where the compiler has computed goto: the processor
   then predicts each jump by itself. */
#if defined(__GNUC__) && !defined(M4E_NO_COMPUTED_GOTO)
#pragma GCC diagnostic ignored "-Wpedantic"
#define M4E_DISPATCH goto *target[code->code & 255];
#define M4E_CASE(name) at_##name:
#else
#define M4E_DISPATCH continue;
#define M4E_CASE(name) case OP_##name:
#endif
#define M4E_AB const double a = r[code->a], b = r[code->b];
#define M4E_STORE(expression) r[code->d] = (expression); ++code; M4E_DISPATCH
#define M4E_RUN1(name, expression) \
    M4E_CASE(name) { const double a = r[code->a]; M4E_STORE(expression) }
#define M4E_RUN2(name, expression) M4E_CASE(name) { M4E_AB M4E_STORE(expression) }
#define M4E_RUN3(name, expression) \
    M4E_CASE(name) { M4E_AB const double c = r[code->code >> 8]; M4E_STORE(expression) }

void m4e_run(const instruction *code, double *r) {
#if defined(__GNUC__) && !defined(M4E_NO_COMPUTED_GOTO)
#define M4E_TARGET(name, expression) [OP_##name] = &&at_##name,
    static const void *const target[OPS] = {M4E_UNARY(M4E_TARGET) M4E_BINARY(M4E_TARGET)
                                                M4E_FUSED(M4E_TARGET)
                                            [OP_SINCOS] = &&at_SINCOS, [OP_END] = &&at_END};
    M4E_DISPATCH {
#else
    for (;;) switch (code->code & 255) {
#endif
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

/* The same on lanes. Operands and result of an operation are the same register or apart. */
#define M4E_LANE(name, k) const double *const name##s = r + (size_t)(k) * M4E_LANES;
#define M4E_EACH(expression, more) \
    M4E_EACH_LANE { const double a = as[l], b = bs[l]; more (void)b; d[l] = (expression); } break;
#define M4E_LANES12(name, expression) case OP_##name: M4E_EACH(expression, )
#define M4E_LANES3(name, expression) \
    case OP_##name: { M4E_LANE(c, code->code >> 8) M4E_EACH(expression, const double c = cs[l];) }

M4E_CLONES void m4e_run_lanes(const instruction *code, double *r) {
    for (;; ++code) {
        M4E_LANE(a, code->a)
        M4E_LANE(b, code->b)
        double *const d = r + (size_t)code->d * M4E_LANES;
        switch (code->code & 255) {
            M4E_UNARY(M4E_LANES12)
            M4E_BINARY(M4E_LANES12)
            M4E_FUSED(M4E_LANES3)
            case OP_SINCOS: {
                double s[M4E_LANES], c[M4E_LANES];
                el_sincos_many(M4E_LANES, as, s, c);
                memcpy(r + (size_t)code->b * M4E_LANES, s, sizeof s);
                memcpy(d, c, sizeof c);
                break;
            }
            default: return;
        }
    }
}
