/* force = -k x - d v, at once. */
enum { STIFFNESS, DAMPING, X, V, FORCE, N };
static const double start[N] = {[STIFFNESS] = 1};

static void update(Model *m) {
    m->r[FORCE] = -m->r[STIFFNESS] * m->r[X] - m->r[DAMPING] * m->r[V];
}
static fmi2Status advance(Model *m, double t, double h) { return fmi2OK; }
