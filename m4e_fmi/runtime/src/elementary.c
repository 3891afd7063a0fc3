/* The elementary functions of elementary.h as functions of the library. */
#include "elementary.h"
#include "m4e.h"

double m4e_sin(double x) { return el_sin(x); }
double m4e_cos(double x) { return el_cos(x); }
void m4e_sincos_many(size_t count, const double *x, double *sine, double *cosine) {
    el_sincos_many(count, x, sine, cosine);
}
