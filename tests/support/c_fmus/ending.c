/* y' = 1 + u up to the time `when`, at which it asks for the end of the simulation: it discards the
 * step that reaches it, and is strict afterwards. */
enum { WHEN, U, Y, N };
static const double start[N] = {[WHEN] = 1};

static void update(Model *m) {}
static fmi2Status advance(Model *m, double t, double h) {
    double left = m->r[WHEN] - t;
    m->terminated = h > left - 1e-10;
    if (h > left + 1e-10) h = left;
    m->r[Y] += h * (1 + m->r[U]);
    m->reached = t + h;
    return m->terminated ? fmi2Discard : fmi2OK;
}
