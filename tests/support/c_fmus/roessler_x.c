/* The first equation of Roessler's system, x' = -y - z. */
enum { Y, Z, X, N };
static const double start[N] = {0};

static void rates(const Model *m, double s, const double *x, double *dx) {
    dx[0] = -at(m, Y, s) - at(m, Z, s);
}
static void update(Model *m) {}
static fmi2Status advance(Model *m, double t, double h) {
    rk4(m, 1, m->r + X, h, rates);
    return fmi2OK;
}
