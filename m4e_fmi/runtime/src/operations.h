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
/* Two operations in one instruction: the outer one in groups of three, the inner one within. */
#define M4E_FUSED(X)                                                                              \
    X(ADD_ADD, (a + b) + c) X(SUB_ADD, (a - b) + c) X(MUL_ADD, a * b + c)                         \
    X(ADD_SUB, (a + b) - c) X(SUB_SUB, (a - b) - c) X(MUL_SUB, a * b - c)                         \
    X(ADD_MUL, (a + b) * c) X(SUB_MUL, (a - b) * c) X(MUL_MUL, (a * b) * c)                       \
    X(ADD_RSUB, c - (a + b)) X(SUB_RSUB, c - (a - b)) X(MUL_RSUB, c - a * b)

#endif
