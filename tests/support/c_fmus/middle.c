/* A mass on a spring and damper to a point that moves as given, on its own spring and damper to the
 * wall, and under a force; end.force acts on that point. Inputs are held or follow derivatives. */
enum { MASS, STIFFNESS, COUPLING, DAMPING, WALL_DAMPING, POINT_X, POINT_V, PULL, FORCE, X, V, A, N };
static const double start[N] = {[MASS] = 1, [STIFFNESS] = 1, [COUPLING] = 1, [DAMPING] = 0};

static double force(const Model *m, double s, const double *x) {
    return m->r[COUPLING] * (x[0] - at(m, POINT_X, s)) + m->r[DAMPING] * (x[1] - at(m, POINT_V, s));
}
static void rates(const Model *m, double s, const double *x, double *dx) {
    double own = m->r[STIFFNESS] * x[0] + m->r[WALL_DAMPING] * x[1];
    dx[0] = x[1];
    dx[1] = (at(m, PULL, s) - force(m, s, x) - own) / m->r[MASS];
}
static void update(Model *m) {
    double dx[2];
    rates(m, 0, m->r + X, dx);
    m->r[FORCE] = force(m, 0, m->r + X);
    m->r[A] = dx[1];
}
static fmi2Status advance(Model *m, double t, double h) {
    rk4(m, 2, m->r + X, h, rates);
    return fmi2OK;
}
