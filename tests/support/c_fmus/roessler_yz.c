/* The other equations of Roessler's system, y' = x + y/5 and z' = 1/5 + z (x - 5.7). */
enum { X, Y, Z, N };
static const double start[N] = {0};

static void rates(const Model *m, double s, const double *x, double *dx) {
    dx[0] = at(m, X, s) + x[0] / 5;
    dx[1] = 0.2 + x[1] * (at(m, X, s) - 5.7);
}
static void update(Model *m) {}
static fmi2Status advance(Model *m, double t, double h) {
    rk4(m, 2, m->r + Y, h, rates);
    return fmi2OK;
}
