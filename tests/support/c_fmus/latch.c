/* y = u at once, from `when` on; 0 before. */
enum { WHEN, U, Y, N };
static const double start[N] = {[WHEN] = 0.5};

static void update(Model *m) { m->r[Y] = m->t < m->r[WHEN] ? 0 : m->r[U]; }
static fmi2Status advance(Model *m, double t, double h) { return fmi2OK; }
