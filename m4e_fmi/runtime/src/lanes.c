/* Running instructions on M4E_LANES register files side by side: [register][lane]. */
#include "dispatch.h"
#include "elementary.h"

#define M4E_REGISTER(name, k) const double *const name##s = r + (size_t)(k) * M4E_LANES;
#define M4E_STEP(name, operands, values, expression)                                              \
    M4E_CASE(name) {                                                                              \
        M4E_REGISTER(a, code->a) operands                                                         \
        double *const d = r + (size_t)code->d * M4E_LANES;                                        \
        M4E_EACH_LANE {                                                                           \
            const double a = as[l] values;                                                        \
            d[l] = (expression);                                                                  \
        }                                                                                         \
        M4E_NEXT(name)                                                                            \
    }
#define M4E_B M4E_REGISTER(b, code->b)
#define M4E_C M4E_REGISTER(c, code->code >> 8)
#define M4E_B_VALUE , b = bs[l]
#define M4E_C_VALUE , c = cs[l]
#define M4E_RUN1(name, expression) M4E_STEP(name, , , expression)
#define M4E_RUN2(name, expression) M4E_STEP(name, M4E_B, M4E_B_VALUE, expression)
#define M4E_RUN3(name, expression) M4E_STEP(name, M4E_B M4E_C, M4E_B_VALUE M4E_C_VALUE, expression)

#define M4E_NAME run_plain
#define M4E_TARGETED
#include "lanes.h"

#if defined(__GNUC__) && defined(__x86_64__)
#define M4E_NAME run_avx2
#define M4E_TARGETED __attribute__((target("avx2")))
#include "lanes.h"
#define M4E_NAME run_avx512
#define M4E_TARGETED __attribute__((target("avx512f,prefer-vector-width=512")))
#include "lanes.h"
#endif

const char *m4e_instruction_set(void) {
#if defined(__GNUC__) && defined(__x86_64__)
    if (__builtin_cpu_supports("avx512f")) return "avx512";
    if (__builtin_cpu_supports("avx2")) return "avx2";
#endif
    return "";
}

void m4e_run_lanes(const instruction *code, double *r) {
#if defined(__GNUC__) && defined(__x86_64__)
    const char *set = m4e_instruction_set();
    if (strcmp(set, "avx512") == 0) {
        run_avx512(code, r);
        return;
    }
    if (strcmp(set, "avx2") == 0) {
        run_avx2(code, r);
        return;
    }
#endif
    run_plain(code, r);
}
