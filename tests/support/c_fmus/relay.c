/* y = 1 until u reaches `high`, then -1 until u reaches `low`: found at the end of a step. */
enum { LOW, HIGH, U, Y, N };
static const double start[N] = {[LOW] = -0.5, [HIGH] = 0.5, [Y] = 1};

static void update(Model *m) {}
static fmi2Status advance(Model *m, double t, double h) {
    double u = at(m, U, h);
    if (u >= m->r[HIGH]) m->r[Y] = -1;
    if (u <= m->r[LOW]) m->r[Y] = 1;
    return fmi2OK;
}
