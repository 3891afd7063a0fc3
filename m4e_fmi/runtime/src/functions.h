/* Exponential, logarithm, power, hyperbolic tangent, tangent and its relatives: below 1 ulp, the
   same bits on every platform; at zeros, infinities and NaN as C99, annex F, has it.

   Where one double is not enough, numbers are unevaluated sums hi + lo (Dekker, 1971). exp: a
   multiple of log 2 is taken off, and Taylor's series summed. log: a power of two is taken off, and
   2 artanh((m - 1)/(m + 1)) summed. Angles: from a guess within 0.01, turned back by its sine and
   cosine, the rest is small enough for three terms of arctan.

   All functions are `static`, as in elementary.h. */
#ifndef M4E_FUNCTIONS_H
#define M4E_FUNCTIONS_H

#include "elementary.h"

#ifdef __GNUC__
#define EL_APART __attribute__((noinline)) static
#else
#define EL_APART static
#endif

static const double EL_TINY = 0x1p-28; /* its square is nothing beside 1 */
static const double EL_LN2 = 0x1.62e42fefa3000p-1, EL_LN2_REST = 0x1.3de6af278ece6p-42;
static const el_pair EL_PI = {0x1.921fb54442d18p+1, 0x1.1a62633145c07p-53};
static const el_pair EL_THIRD = {0x1.5555555555555p-2, 0x1.5555555555555p-56};
static const el_pair EL_FIFTH = {0x1.999999999999ap-3, -0x1.999999999999ap-57};
static const el_pair EL_ONE = {1.0, 0.0};

static inline el_pair el_times(el_pair a, el_pair b) {
    const el_pair p = el_product(a.hi, b.hi);
    return el_quick(p.hi, p.lo + (a.hi * b.lo + a.lo * b.hi));
}

static inline el_pair el_plus(el_pair a, el_pair b) {
    const el_pair s = el_sum(a.hi, b.hi);
    return el_quick(s.hi, s.lo + (a.lo + b.lo));
}

static inline el_pair el_minus(el_pair a, el_pair b) {
    return el_plus(a, (el_pair){-b.hi, -b.lo});
}

static inline el_pair el_over(el_pair a, el_pair b) {
    const double q = a.hi / b.hi;
    const el_pair p = el_product(q, b.hi);
    return el_quick(q, (((a.hi - p.hi) - p.lo) + (a.lo - q * b.lo)) / b.hi);
}

/* ---- exp, tanh, log, pow ---- */

/* 2^k (1 + p) = exp(x.hi + x.lo), |x| <= 800. */
static inline el_pair el_exp_parts(el_pair x, int *k) {
    const double rounded = (x.hi * (1.0 / EL_LN2) + EL_ROUND) - EL_ROUND;
    const el_pair rest = el_sum(x.hi - rounded * EL_LN2, x.lo - rounded * EL_LN2_REST);
    const double r = rest.hi, z = r * r, zz = z * z;
    const double a = (1.0 / 2 + r * (1.0 / 6)) + z * (1.0 / 24 + r * (1.0 / 120));
    const double b = (1.0 / 720 + r * (1.0 / 5040)) + z * (1.0 / 40320 + r * (1.0 / 362880));
    const double c = (1.0 / 3628800 + r * (1.0 / 39916800)) +
                     z * ((1.0 / 479001600 + r * (1.0 / 6227020800.0)) +
                          z * (1.0 / 87178291200.0));
    *k = (int)rounded; /* k times the first part of log 2, and x.hi less that, are exact */
    return el_quick(r, z * (a + zz * (b + zz * c)) + rest.lo * (1.0 + r));
}

/* 2^k, -1022 <= k <= 1023 */
static inline double el_power_of_two(int k) { return el_double((uint64_t)(k + 1023) << 52); }

/* In two factors: k itself may be out of range. */
static inline double el_exp_pair(el_pair x) {
    int k;
    const el_pair p = el_exp_parts(x, &k), s = el_quick(1.0, p.hi);
    const double value = s.hi + (s.lo + p.lo);
    return value * el_power_of_two(k / 2) * el_power_of_two(k - k / 2);
}

EL_APART double el_exp(double x) {
    if (fabs(x) <= 800.0) return el_exp_pair((el_pair){x, 0.0});
    return x != x ? x : x > 0 ? (double)INFINITY : 0.0;
}

EL_APART double el_tanh(double x) {
    const double a = fabs(x);
    if (a < EL_TINY || x != x) return x;
    if (a > 22.0) return copysign(1.0, x);
    int k;
    const el_pair p = el_exp_parts((el_pair){2.0 * a, 0.0}, &k);
    const double scale = el_power_of_two(k);
    const el_pair e = el_plus(el_sum(scale, -1.0), (el_pair){scale * p.hi, scale * p.lo});
    const el_pair q = el_over(e, el_plus(e, (el_pair){2.0, 0.0}));
    return copysign(q.hi + q.lo, x);
}

/* log x to about 100 bits, 0 < x < infinity: x = 2^k m, m in [1/sqrt 2, sqrt 2). */
static inline el_pair el_log_pair(double x) {
    const int small = x < 0x1p-1022;
    const uint64_t bits = el_bits(small ? x * 0x1p54 : x), root = UINT64_C(0x3fe6a09e667f3bcd);
    const int64_t power = (int64_t)(bits - root) >> 52;
    const double m = el_double(bits - ((uint64_t)power << 52));
    const double k = (double)power - (small ? 54.0 : 0.0);
    const el_pair s = el_over((el_pair){m - 1.0, 0.0}, el_sum(m, 1.0)), zs = el_times(s, s);
    const double z = zs.hi, zz = z * z, z4 = zz * zz;
    const double a = (1.0 / 7 + z * (1.0 / 9)) + zz * (1.0 / 11 + z * (1.0 / 13));
    const double b = (1.0 / 15 + z * (1.0 / 17)) + zz * (1.0 / 19 + z * (1.0 / 21));
    const double c = (1.0 / 23 + z * (1.0 / 25)) + zz * (1.0 / 27 + z * (1.0 / 29));
    el_pair sum = {a + z4 * (b + z4 * c), 0.0};
    sum = el_plus(EL_FIFTH, el_times(zs, sum));
    sum = el_plus(EL_THIRD, el_times(zs, sum));
    sum = el_times(s, el_plus(EL_ONE, el_times(zs, sum)));
    const el_pair whole = el_sum(k * EL_LN2, 2.0 * sum.hi); /* k times the first part is exact */
    return el_quick(whole.hi, whole.lo + (2.0 * sum.lo + k * EL_LN2_REST));
}

EL_APART double el_log(double x) {
    if (x > 0 && x < (double)INFINITY) {
        const el_pair l = el_log_pair(x);
        return l.hi + l.lo;
    }
    return x == 0 ? -(double)INFINITY : x < 0 ? (double)NAN : x;
}

/* 1 if y is odd, 2 if even, 0 if no whole number. */
static inline int el_whole(double y) {
    const double a = fabs(y);
    if (a >= 0x1p53) return 2; /* infinity, too */
    const uint64_t n = (uint64_t)a;
    return (double)n != a ? 0 : n & 1 ? 1 : 2;
}

EL_APART double el_pow(double x, double y) {
    if (y == 0 || x == 1.0) return 1.0;
    if (x != x || y != y) return x + y;
    const double a = fabs(x), infinity = (double)INFINITY;
    const int negative = signbit(x) != 0, whole = el_whole(y);
    const double sign = negative && whole == 1 ? -1.0 : 1.0;
    if (fabs(y) == infinity) return a == 1.0 ? 1.0 : (a > 1.0) == (y > 0) ? infinity : 0.0;
    if (a == 0 || a == infinity) return sign * ((a == 0) == (y < 0) ? infinity : 0.0);
    if (negative && !whole) return (double)NAN;
    const el_pair l = el_log_pair(a);
    const double size = y * l.hi;
    if (!(fabs(size) < 800.0)) return sign * (size > 0 ? infinity : 0.0);
    return sign * el_exp_pair(el_times(l, (el_pair){y, 0.0}));
}

/* ---- tangent and angles ---- */

/* Sine and cosine as pairs. */
static inline void el_sincos_pairs(double x, el_pair *sine, el_pair *cosine) {
    uint64_t quadrant;
    double hi, lo;
    if (fabs(x) <= EL_LIMIT)
        el_reduce(x, &quadrant, &hi, &lo);
    else
        el_reduce_large(x, &quadrant, &hi, &lo);
    el_pair s, c;
    el_series(hi, lo, &s, &c);
    const double of_sine = quadrant & 2 ? -1.0 : 1.0, of_cosine = (quadrant + 1) & 2 ? -1.0 : 1.0;
    const el_pair a = quadrant & 1 ? c : s, b = quadrant & 1 ? s : c;
    *sine = (el_pair){of_sine * a.hi, of_sine * a.lo};
    *cosine = (el_pair){of_cosine * b.hi, of_cosine * b.lo};
}

EL_APART double el_tan(double x) {
    if (fabs(x) < EL_TINY) return x;
    if (!isfinite(x)) return x - x;
    el_pair s, c;
    el_sincos_pairs(x, &s, &c);
    const el_pair q = el_over(s, c);
    return q.hi + q.lo;
}

/* Angle of the direction (x, y) in the first quadrant; the larger of the two is about 1. */
EL_APART el_pair el_angle(el_pair y, el_pair x) {
    const int steep = y.hi > x.hi;
    const double t = steep ? x.hi / y.hi : y.hi / x.hi, near = t / (1.0 + 0.28 * t * t);
    const double guess = steep ? 0.5 * EL_PI.hi - near : near;
    el_pair s, c;
    el_sincos_pairs(guess, &s, &c);
    const el_pair across = el_minus(el_times(y, c), el_times(x, s));
    const double along = x.hi * c.hi + y.hi * s.hi;
    const double d = (across.hi + across.lo) / along, dd = d * d;
    return el_quick(guess, d - d * dd * (1.0 / 3 - dd * (1.0 / 5)));
}

/* An angle in the first quadrant, or what it is short of pi. */
static inline double el_turned(el_pair angle, int back) {
    if (back) angle = el_minus(EL_PI, angle);
    return angle.hi + angle.lo;
}

EL_APART double el_atan2(double y, double x) {
    if (x != x || y != y) return x + y;
    const int back = signbit(x) != 0;
    double a = fabs(x), b = fabs(y);
    if (b == 0) return back ? copysign(EL_PI.hi, y) : y;
    if (!back && b < a * EL_TINY) return y / x;
    if (a == (double)INFINITY || b == (double)INFINITY) {
        a = a == (double)INFINITY;
        b = b == (double)INFINITY;
    }
    int exponent;
    (void)frexp(fmax(a, b), &exponent);
    a = ldexp(a, -exponent);
    b = ldexp(b, -exponent);
    return copysign(el_turned(el_angle((el_pair){b, 0.0}, (el_pair){a, 0.0}), back), y);
}

static inline double el_atan(double x) { return el_atan2(x, 1.0); }

/* sqrt(1 - a^2), 0 <= a <= 1 */
static inline el_pair el_other_side(double a) {
    const el_pair w = el_times(el_sum(1.0, -a), el_sum(1.0, a));
    const double root = sqrt(w.hi);
    if (root == 0) return w;
    const el_pair square = el_product(root, root);
    return el_quick(root, (((w.hi - square.hi) - square.lo) + w.lo) / (2.0 * root));
}

EL_APART double el_asin(double x) {
    const double a = fabs(x);
    if (!(a <= 1.0)) return x != x ? x : (double)NAN;
    if (a < EL_TINY) return x;
    return copysign(el_turned(el_angle((el_pair){a, 0.0}, el_other_side(a)), 0), x);
}

EL_APART double el_acos(double x) {
    const double a = fabs(x);
    if (!(a <= 1.0)) return x != x ? x : (double)NAN;
    return el_turned(el_angle(el_other_side(a), (el_pair){a, 0.0}), x < 0);
}

#endif
