/* Running instructions on M4E_LANES register files side by side: [register][lane]. */
#if defined(__GNUC__) && defined(__x86_64__)
#include <cpuid.h>
#endif

#include "dispatch.h"
#include "functions.h"

#define M4E_REGISTER(name, k) const double *const name##s = r + (size_t)(k) * M4E_LANES;
#define M4E_STEP(name, count, operands, values, expression)                                       \
    M4E_CASE(name) {                                                                              \
        operands                                                                                  \
        double *const d = r + (size_t)place * M4E_LANES;                                          \
        M4E_EACH_LANE {                                                                           \
            values                                                                                \
            d[l] = (expression);                                                                  \
        }                                                                                         \
        M4E_NEXT(name, count)                                                                     \
    }
#define M4E_AB M4E_READ_AB M4E_REGISTER(a, M4E_A) M4E_REGISTER(b, M4E_B)
#define M4E_EF M4E_READ_EF M4E_REGISTER(e, M4E_E) M4E_REGISTER(f, M4E_F)
#define M4E_AB_VALUES const double a = as[l], b = bs[l];
#define M4E_C_VALUE const double c = cs[l];
#define M4E_EF_VALUES const double e = es[l], f = fs[l];
#define M4E_RUN1(name, expression)                                                                \
    M4E_STEP(name, 1, M4E_REGISTER(a, code->a), const double a = as[l];, expression)
#define M4E_RUN2(name, expression) M4E_STEP(name, 1, M4E_AB, M4E_AB_VALUES, expression)
#define M4E_RUN3(name, expression)                                                                \
    M4E_STEP(name, 1, M4E_AB M4E_REGISTER(c, M4E_C), M4E_AB_VALUES M4E_C_VALUE, expression)
#define M4E_RUN4(name, expression)                                                                \
    M4E_STEP(name, 2, M4E_AB M4E_EF, M4E_AB_VALUES M4E_EF_VALUES, expression)
#define M4E_RUN5(name, expression)                                                                \
    M4E_STEP(name, 2, M4E_AB M4E_EF M4E_REGISTER(c, M4E_C),                                       \
             M4E_AB_VALUES M4E_C_VALUE M4E_EF_VALUES, expression)

#define M4E_NAME run_plain
#define M4E_TARGETED
#include "lanes.h"

#if defined(__GNUC__) && defined(__x86_64__)
#define M4E_NAME run_avx2
#define M4E_TARGETED __attribute__((target("avx2")))
#include "lanes.h"
#define M4E_NAME run_avx512
#ifdef __clang__
#define M4E_TARGETED __attribute__((target("avx512f")))
#else
#define M4E_TARGETED __attribute__((target("avx512f,prefer-vector-width=512")))
#endif
#include "lanes.h"
#endif

#if defined(__GNUC__) && defined(__x86_64__)
/* Asked of the processor itself: not every compiler's library answers __builtin_cpu_supports. */
const char *m4e_instruction_set(void) {
    enum { AVX_KEPT = 0x6, AVX512_KEPT = 0xe6 }; /* registers that the system saves */
    unsigned a, b, c, d, kept, high;
    if (!__get_cpuid(1, &a, &b, &c, &d) || !(c & bit_OSXSAVE)) return "";
    __asm__("xgetbv" : "=a"(kept), "=d"(high) : "c"(0));
    if (!__get_cpuid_count(7, 0, &a, &b, &c, &d)) return "";
    if ((kept & AVX512_KEPT) == AVX512_KEPT && (b & bit_AVX512F)) return "avx512";
    return (kept & AVX_KEPT) == AVX_KEPT && (b & bit_AVX2) ? "avx2" : "";
}

runner *m4e_lanes_runner(void) {
    const char *set = m4e_instruction_set();
    if (strcmp(set, "avx512") == 0) return run_avx512;
    return strcmp(set, "avx2") == 0 ? run_avx2 : run_plain;
}
#else
const char *m4e_instruction_set(void) { return ""; }
runner *m4e_lanes_runner(void) { return run_plain; }
#endif
