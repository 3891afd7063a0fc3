/* What the text of a compiled kernel begins with. LANES models run side by side: a `real` is one
   number of each. Sums, differences, products and quotients of reals are written as such; for the
   other operations there is each_NAME(a, b). */
#include "functions.h"
#include "operations.h"

#if LANES == 1
typedef double real;
#define M4E_EACH(name, expression)                                                                \
    static inline real each_##name(real a, real b) {                                              \
        (void)b;                                                                                  \
        return expression;                                                                        \
    }
#else
typedef double real __attribute__((vector_size(8 * LANES), aligned(8)));
#define M4E_EACH(name, expression)                                                                \
    static inline real each_##name(real as, real bs) {                                            \
        double x[LANES], y[LANES];                                                                \
        memcpy(x, &as, sizeof x);                                                                 \
        memcpy(y, &bs, sizeof y);                                                                 \
        for (int l = 0; l < LANES; ++l) {                                                         \
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

#define M4E_KERNEL(name)                                                                          \
    __attribute__((visibility("default"))) void name(const double *t_, const double *x_,          \
                                                     const double *fixed_, double *result_);      \
    void name(const double *t_, const double *x_, const double *fixed_, double *result_)
#define M4E_ARGUMENTS                                                                             \
    const real *restrict t = (const real *)t_, *restrict x = (const real *)x_,                    \
                         *restrict fixed = (const real *)fixed_;                                  \
    real *restrict result = (real *)result_;                                                      \
    (void)t, (void)x, (void)fixed;
