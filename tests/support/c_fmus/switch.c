/* y' = 1 before `when` and -1 after. A step across that time is discarded, and ends there. */
enum { WHEN, Y, N };
static const double start[N] = {[WHEN] = 1};

static void update(Model *m) {}
static fmi2Status advance(Model *m, double t, double h) {
    double left = m->r[WHEN] - t, near = 1e-9;
    if (left > near && h > left + near) {
        m->r[Y] += left;
        m->reached = m->r[WHEN];
        return fmi2Discard;
    }
    m->r[Y] += left > near ? h : -h;
    return fmi2OK;
}
