/* What the text of a compiled kernel begins with. LANES models run side by side, as many at a time
   as one register of the processor holds: a `real` is one number of each of those. More at a time
   would leave too few registers. Sums, differences, products and quotients of reals are written as
   such; for the other operations there is each_NAME(a, b). */
#include "functions.h"
#include "operations.h"

#if LANES == 1
enum { AT_A_TIME = 1 };
typedef double real;
#define M4E_EACH(name, expression)                                                                \
    static inline real each_##name(real a, real b) {                                              \
        (void)b;                                                                                  \
        return expression;                                                                        \
    }
#else
#if defined(__AVX512F__)
enum { AT_A_TIME = 8 };
#elif defined(__AVX2__)
enum { AT_A_TIME = 4 };
#else
enum { AT_A_TIME = 2 };
#endif
typedef double real __attribute__((vector_size(8 * AT_A_TIME), aligned(8)));
#define M4E_EACH(name, expression)                                                                \
    static inline real each_##name(real as, real bs) {                                            \
        double x[AT_A_TIME], y[AT_A_TIME];                                                        \
        memcpy(x, &as, sizeof x);                                                                 \
        memcpy(y, &bs, sizeof y);                                                                 \
        for (int l = 0; l < AT_A_TIME; ++l) {                                                     \
            const double a = x[l], b = y[l];                                                      \
            (void)b;                                                                              \
            x[l] = expression;                                                                    \
        }                                                                                         \
        memcpy(&as, x, sizeof x);                                                                 \
        return as;                                                                                \
    }
#endif
M4E_UNARY(M4E_EACH)
M4E_BINARY(M4E_EACH)

enum { PARTS = LANES / AT_A_TIME }; /* reals of one number of all models */
#define OF(vector, index) vector[(index) * PARTS]

#define M4E_KERNEL(name)                                                                          \
    __attribute__((visibility("default"))) void name(const double *t_, const double *x_,          \
                                                     const double *fixed_, double *result_);      \
    void name(const double *t_, const double *x_, const double *fixed_, double *result_)
#define M4E_ARGUMENTS                                                                             \
    const real *restrict t = (const real *)t_, *restrict x = (const real *)x_,                    \
                         *restrict fixed = (const real *)fixed_;                                  \
    real *restrict result = (real *)result_;                                                      \
    for (int part = 0; part < PARTS; ++part, ++t, ++x, ++fixed, ++result)
