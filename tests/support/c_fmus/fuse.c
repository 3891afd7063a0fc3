/* force = -k x, at once; ends with a message of its own where |x| is beyond `limit`. */
enum { STIFFNESS, LIMIT, X, V, FORCE, N };
static const double start[N] = {[STIFFNESS] = 1, [LIMIT] = 1e6};

static void update(Model *m) { m->r[FORCE] = -m->r[STIFFNESS] * m->r[X]; }
static fmi2Status advance(Model *m, double t, double h) {
    if (fabs(m->r[X]) <= m->r[LIMIT]) return fmi2OK;
    SAY(m, fmi2Error, "the fuse has blown");
    return fmi2Error;
}
