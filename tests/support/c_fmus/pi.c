/* A PI controller: output 2 e + 3 I of the error e = 1 - y and its integral I' = e. */
enum { Y, INTEGRAL, U, N };
static const double start[N] = {0};

static void rates(const Model *m, double s, const double *x, double *dx) {
    dx[0] = 1 - at(m, Y, s);
}
static void update(Model *m) { m->r[U] = 2 * (1 - m->r[Y]) + 3 * m->r[INTEGRAL]; }
static fmi2Status advance(Model *m, double t, double h) {
    rk4(m, 1, m->r + INTEGRAL, h, rates);
    return fmi2OK;
}
