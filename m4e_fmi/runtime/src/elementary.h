/* Sine and cosine: below 1 ulp for every finite argument, the same bits on every platform.

   |x| <= 1e5: k = nearest integer of 2x/pi; r = x - k pi/2 as an unevaluated sum hi + lo, with pi/2
   in three pieces (37 + 37 + 53 bits), so that k times each of the first two is exact. Larger x:
   the product with enough digits of 2/pi in whole numbers (Payne and Hanek, 1983). Then minimax
   polynomials on [-pi/4, pi/4] (errors 2^-57.9 of sin and 2^-63.9 of cos, computed by Remez'
   exchange). The core has no branches: compilers turn a loop over it into vector instructions.

   All functions are `static`: a compiled kernel includes this text and computes the same bits. */
#ifndef M4E_ELEMENTARY_H
#define M4E_ELEMENTARY_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "clones.h"
#include "exact.h"

static const double EL_LIMIT = 1e5;
static const double EL_TWO_OVER_PI = 0x1.45f306dc9c883p-1;
static const double EL_ROUND = 0x1.8p52; /* adding it rounds to an integer, kept in the low bits */

static inline uint64_t el_bits(double x) {
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

static inline double el_double(uint64_t bits) {
    double x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

/* hi + lo, the sum not carried out */
typedef struct {
    double hi, lo;
} el_pair;

/* a + b exactly */
static inline el_pair el_sum(double a, double b) {
    const double hi = a + b, back = hi - a;
    return (el_pair){hi, (a - (hi - back)) + (b - back)};
}

/* the same for |a| >= |b| */
static inline el_pair el_quick(double a, double b) {
    const double hi = a + b;
    return (el_pair){hi, b - (hi - a)};
}

/* a b exactly, unless it overflows or is subnormal: halves of 26 digits (Veltkamp, Dekker) */
static inline el_pair el_product(double a, double b) {
    const double half = 0x1p27 + 1.0, hi = a * b, a_ = half * a, b_ = half * b;
    const double a1 = a_ - (a_ - a), a2 = a - a1, b1 = b_ - (b_ - b), b2 = b - b1;
    return (el_pair){hi, ((a1 * b1 - hi) + a1 * b2 + a2 * b1) + a2 * b2};
}

/* Sine and cosine of hi + lo, |hi + lo| <= pi/4. */
static inline void el_series(double hi, double lo, el_pair *sine, el_pair *cosine) {
    const double z = hi * hi, zz = z * z;
    const double s = (-0x1.5555555555548p-3 + z * 0x1.111111110f730p-7) +
                     zz * ((-0x1.a01a019be9218p-13 + z * 0x1.71de35552b731p-19) +
                           zz * (-0x1.ae5e4b840d9afp-26 + z * 0x1.5d8b55a563f2fp-33));
    const double c = (0x1.555555555554bp-5 + z * -0x1.6c16c16c15013p-10) +
                     zz * ((0x1.a01a019c8ed08p-16 + z * -0x1.27e4f7f1412acp-22) +
                           zz * (0x1.1ee9db8e514f3p-29 + z * -0x1.8fa65eab9caecp-37));
    const double half = 0.5 * z, most = 1.0 - half;
    *sine = el_quick(hi, hi * z * s + lo * most);
    *cosine = el_quick(most, ((1.0 - most) - half) + (zz * c - hi * lo));
}

/* Sine and cosine of (quadrant) pi/2 + hi + lo, |hi + lo| <= pi/4. */
static inline void el_finish(uint64_t quadrant, double hi, double lo, double *sine,
                             double *cosine) {
    el_pair sin_r, cos_r;
    el_series(hi, lo, &sin_r, &cos_r);
    const uint64_t swap = 0 - (quadrant & 1);
    const uint64_t a = el_bits(sin_r.hi), b = el_bits(cos_r.hi);
    *sine = el_double(((a & ~swap) | (b & swap)) ^ ((quadrant & 2) << 62));
    *cosine = el_double(((b & ~swap) | (a & swap)) ^ (((quadrant + 1) & 2) << 62));
}

/* |x| <= EL_LIMIT. The difference of two exact terms is split exactly (Knuth's two-sum). */
static inline void el_reduce(double x, uint64_t *quadrant, double *hi_, double *lo_) {
    const double shifted = x * EL_TWO_OVER_PI + EL_ROUND;
    const double k = shifted - EL_ROUND;
    const double first = x - k * 0x1.921fb54440000p+0; /* exact */
    const double second = k * 0x1.68c234c4c0000p-39;   /* exact */
    const double hi = first - second;
    const double back = hi - first;
    const double lo = ((first - (hi - back)) - (second + back)) - k * 0x1.98a2e03707345p-77;
    *quadrant = el_bits(shifted);
    *hi_ = hi;
    *lo_ = lo;
}

static inline void el_core(double x, double *sine, double *cosine) {
    uint64_t quadrant;
    double hi, lo;
    el_reduce(x, &quadrant, &hi, &lo);
    el_finish(quadrant, hi, lo, sine, cosine);
}

static inline uint64_t el_word(const uint32_t *digits, unsigned bit) {
    const unsigned i = bit / 32, shift = bit % 32;
    const uint64_t low = digits[i] | (uint64_t)digits[i + 1] << 32;
    return shift ? low >> shift | (uint64_t)digits[i + 2] << (64 - shift) : low;
}

/* Any finite |x| > EL_LIMIT: x = m 2^e; m times seven 32-bit digits of 2/pi, of which those worth
   multiples of four are left out, gives the quadrant and 128 bits of the fraction. */
static void el_reduce_large(double x, uint64_t *quadrant_, double *hi_, double *lo_) {
    static const uint32_t two_over_pi[] = {
        0xa2f9836e, 0x4e441529, 0xfc2757d1, 0xf534ddc0, 0xdb629599, 0x3c439041, 0xfe5163ab,
        0xdebbc561, 0xb7246e3a, 0x424dd2e0, 0x06492eea, 0x09d1921c, 0xfe1deb1c, 0xb129a73e,
        0xe88235f5, 0x2ebb4484, 0xe99c7026, 0xb45f7e41, 0x3991d639, 0x835339f4, 0x9c845f8b,
        0xbdf9283b, 0x1ff897ff, 0xde05980f, 0xef2f118b, 0x5a0a6d1f, 0x6d367ecf, 0x27cb09b7,
        0x4f463f66, 0x9e5fea2d, 0x7527bac7, 0xebe5f17b, 0x3d0739f7, 0x8a5292ea, 0x6bfb5fb1,
        0x1f8d5d08, 0x56033046, 0xfc7b6bab};
    enum { DIGITS = 7 };
    int exponent;
    const uint64_t m = (uint64_t)ldexp(frexp(fabs(x), &exponent), 53);
    exponent -= 53;
    const int skipped = exponent > 2 ? (exponent - 2) / 32 : 0;
    uint32_t product[DIGITS + 4] = {0};
    for (int half = 0; half < 2; ++half) {
        const uint64_t factor = (m >> (32 * half)) & 0xffffffff;
        uint64_t carry = 0;
        for (int i = 0; i < DIGITS; ++i) {
            carry += factor * two_over_pi[skipped + DIGITS - 1 - i] + product[i + half];
            product[i + half] = (uint32_t)carry;
            carry >>= 32;
        }
        product[DIGITS + half] = (uint32_t)carry;
    }
    const unsigned point = (unsigned)(32 * (skipped + DIGITS) - exponent);
    uint64_t quadrant = el_word(product, point) & 3;
    uint64_t high = el_word(product, point - 64), low = el_word(product, point - 128);
    double sign = x < 0 ? -1.0 : 1.0;
    if (high >> 63) { /* beyond one half: nearer to the next quadrant */
        ++quadrant;
        low = 0 - low;
        high = ~high + (low == 0);
        sign = -sign;
    }
    if (x < 0) quadrant = 0 - quadrant;
    const double a = (double)(high >> 11) * 0x1p-53;
    const double b = (double)((high & 0x7ff) << 42 | low >> 22) * 0x1p-106;
    const double f = a + b, rest = (b - (f - a)) + (double)(low & 0x3fffff) * 0x1p-128;
    const el_pair turned = el_product(f, 0x1.921fb54442d18p+0);
    const double lo = turned.lo + (f * 0x1.1a62633145c07p-54 + rest * 0x1.921fb54442d18p+0);
    *quadrant_ = quadrant;
    *hi_ = sign * turned.hi;
    *lo_ = sign * lo;
}

static inline void el_sincos(double x, double *sine, double *cosine) {
    if (fabs(x) <= EL_LIMIT)
        el_core(x, sine, cosine);
    else if (isfinite(x)) {
        uint64_t quadrant;
        double hi, lo;
        el_reduce_large(x, &quadrant, &hi, &lo);
        el_finish(quadrant, hi, lo, sine, cosine);
    } else
        *sine = *cosine = x - x; /* nan */
}

M4E_CLONES static void el_sincos_many(size_t count, const double *restrict x,
                                      double *restrict sine, double *restrict cosine) {
    for (size_t i = 0; i < count; ++i) el_core(x[i], &sine[i], &cosine[i]);
    for (size_t i = 0; i < count; ++i)
        if (!(fabs(x[i]) <= EL_LIMIT)) el_sincos(x[i], &sine[i], &cosine[i]);
}

static inline double el_sin(double x) {
    double s, c;
    el_sincos(x, &s, &c);
    return s;
}

static inline double el_cos(double x) {
    double s, c;
    el_sincos(x, &s, &c);
    return c;
}

#endif
