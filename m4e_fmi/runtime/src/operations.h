/* The operations on doubles a, b, c, as expressions; NaN and order of arguments as in Python's min,
   max and sign. Positions are codes of the binary form: append only. */
#ifndef M4E_OPERATIONS_H
#define M4E_OPERATIONS_H

#define M4E_UNARY(X)                                                                              \
    X(NEG, -a) X(ABS, fabs(a)) X(SIGN, (double)((a > 0) - (a < 0))) X(SQRT, sqrt(a))              \
    X(EXP, el_exp(a)) X(LOG, el_log(a)) X(SIN, el_sin(a)) X(COS, el_cos(a)) X(TAN, el_tan(a))     \
    X(ASIN, el_asin(a)) X(ACOS, el_acos(a)) X(ATAN, el_atan(a)) X(TANH, el_tanh(a))
#define M4E_BINARY(X)                                                                             \
    X(ADD, a + b) X(SUB, a - b) X(MUL, a * b) X(DIV, a / b) X(POW, el_pow(a, b))                  \
    X(ATAN2, el_atan2(a, b)) X(MIN, b < a ? b : a) X(MAX, b > a ? b : a)
/* Several operations in one instruction, in order of their codes; each is rounded by itself. Two:
   the outer one in groups of three, the inner one within. */
#define M4E_FUSED(X)                                                                              \
    X(ADD_ADD, (a + b) + c) X(SUB_ADD, (a - b) + c) X(MUL_ADD, a * b + c)                         \
    X(ADD_SUB, (a + b) - c) X(SUB_SUB, (a - b) - c) X(MUL_SUB, a * b - c)                         \
    X(ADD_MUL, (a + b) * c) X(SUB_MUL, (a - b) * c) X(MUL_MUL, (a * b) * c)                       \
    X(ADD_RSUB, c - (a + b)) X(SUB_RSUB, c - (a - b)) X(MUL_RSUB, c - a * b)
/* Two products on top of a number. */
#define M4E_CHAINED(X)                                                                            \
    X(CHAIN_ADD_ADD, (c + a * b) + e * f) X(CHAIN_ADD_SUB, (c + a * b) - e * f)                   \
    X(CHAIN_SUB_ADD, (c - a * b) + e * f) X(CHAIN_SUB_SUB, (c - a * b) - e * f)
/* Both operands of an operation: its name and that of the second in groups, the first within. */
#define M4E_BESIDE(X, OUTER, outer, SECOND, second)                                               \
    X(ADD_##OUTER##_##SECOND, (a + b) outer (e second f))                                         \
    X(SUB_##OUTER##_##SECOND, (a - b) outer (e second f))                                         \
    X(MUL_##OUTER##_##SECOND, (a * b) outer (e second f))
#define M4E_AROUND(X, OUTER, outer)                                                               \
    M4E_BESIDE(X, OUTER, outer, ADD, +) M4E_BESIDE(X, OUTER, outer, SUB, -)                       \
    M4E_BESIDE(X, OUTER, outer, MUL, *)
#define M4E_PAIRED(X) M4E_AROUND(X, ADD, +) M4E_AROUND(X, SUB, -) M4E_AROUND(X, MUL, *)

#endif
