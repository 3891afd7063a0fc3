/* x'' = mu (1 - x^2) x' - x + u: from a small start along an exponential to a limit cycle. */
enum { MU, U, X, DX, N };
static const double start[N] = {[MU] = 2, [X] = 1e-9};

static void rates(const Model *m, double s, const double *x, double *dx) {
    dx[0] = x[1];
    dx[1] = m->r[MU] * (1 - x[0] * x[0]) * x[1] - x[0] + at(m, U, s);
}
static void update(Model *m) {}
static fmi2Status advance(Model *m, double t, double h) {
    rk4(m, 2, m->r + X, h, rates);
    return fmi2OK;
}
