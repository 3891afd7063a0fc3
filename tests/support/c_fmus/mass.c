/* m x'' = force - c x - d x' with the force held during a step, or following its derivatives. */
enum { MASS, STIFFNESS, DAMPING, FORCE, X, V, A, N };
static const double start[N] = {[MASS] = 1, [STIFFNESS] = 0, [DAMPING] = 0};

static void rates(const Model *m, double s, const double *x, double *dx) {
    dx[0] = x[1];
    dx[1] = (at(m, FORCE, s) - m->r[STIFFNESS] * x[0] - m->r[DAMPING] * x[1]) / m->r[MASS];
}
static void update(Model *m) {
    double dx[2];
    rates(m, 0, m->r + X, dx);
    m->r[A] = dx[1];
}
static fmi2Status advance(Model *m, double t, double h) {
    rk4(m, 2, m->r + X, h, rates);
    return fmi2OK;
}
