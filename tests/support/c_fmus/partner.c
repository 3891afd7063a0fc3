/* A second mass on its own spring and damper, and the spring and damper between it and a point that
 * moves as given: x is held during a step, or (MOVES) goes along v, or follows its derivatives.
 * force acts on that point. */
enum { MASS, STIFFNESS, COUPLING, DAMPING, WALL_DAMPING, POINT_X, POINT_V, FORCE, X, V, N };
static const double start[N] = {[MASS] = 1, [STIFFNESS] = 1, [COUPLING] = 1, [DAMPING] = 0};

static double force(const Model *m, double s, const double *x) {
#ifdef MOVES
    double point = m->r[POINT_X] + s * m->r[POINT_V];
#else
    double point = at(m, POINT_X, s);
#endif
    return m->r[COUPLING] * (x[0] - point) + m->r[DAMPING] * (x[1] - at(m, POINT_V, s));
}
static void rates(const Model *m, double s, const double *x, double *dx) {
    dx[0] = x[1];
    dx[1] = (-force(m, s, x) - m->r[STIFFNESS] * x[0] - m->r[WALL_DAMPING] * x[1]) / m->r[MASS];
}
static void update(Model *m) { m->r[FORCE] = force(m, 0, m->r + X); }
static fmi2Status advance(Model *m, double t, double h) {
    rk4(m, 2, m->r + X, h, rates);
    return fmi2OK;
}
