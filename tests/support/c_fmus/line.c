/* As a mooring line: the end moves from x along v, its force -k x - d v is that at the end of the
 * step and does not change when the inputs are set afterwards. */
enum { STIFFNESS, DAMPING, X, V, FORCE, STEPPED, N };
static const double start[N] = {[STIFFNESS] = 1};

static double force(const Model *m, double s) {
    return -m->r[STIFFNESS] * (m->r[X] + s * m->r[V]) - m->r[DAMPING] * m->r[V];
}
static void update(Model *m) {
    if (!m->r[STEPPED]) m->r[FORCE] = force(m, 0);
}
static fmi2Status advance(Model *m, double t, double h) {
    m->r[FORCE] = force(m, h);
    m->r[STEPPED] = 1;
    return fmi2OK;
}
