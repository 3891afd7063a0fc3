/* y = x + gain u and z = 2 x, where x' = u - x from `when` on; all are 0 before. */
enum { GAIN, WHEN, U, Y, Z, N };
static const double start[N] = {[WHEN] = 2};

static void rates(const Model *m, double s, const double *x, double *dx) {
    dx[0] = at(m, U, s) - x[0];
}
static void update(Model *m) {
    m->r[Y] = m->t < m->r[WHEN] - 1e-9 ? 0 : m->r[Z] / 2 + m->r[GAIN] * m->r[U];
#ifdef NOISY
    static int calls;
    m->r[Y] *= 1 + 1e-7 * (calls++ % 2);
#endif
}
static fmi2Status advance(Model *m, double t, double h) {
    double x = m->r[Z] / 2;
    if (t > m->r[WHEN] - 1e-9) rk4(m, 1, &x, h, rates);
    m->r[Z] = 2 * x;
    return fmi2OK;
}
static void partly(Model *m) { m->shown[Y] = m->r[GAIN] * m->r[U]; }
