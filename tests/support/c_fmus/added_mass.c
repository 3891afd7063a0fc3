/* force = -added a - k x, at once: added mass exchanged as a force, and a spring. */
enum { ADDED, STIFFNESS, X, A, FORCE, N };
static const double start[N] = {[STIFFNESS] = 1};

static void update(Model *m) {
    m->r[FORCE] = -m->r[ADDED] * m->r[A] - m->r[STIFFNESS] * m->r[X];
}
static fmi2Status advance(Model *m, double t, double h) { return fmi2OK; }
