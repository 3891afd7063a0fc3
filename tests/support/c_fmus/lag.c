/* The plant y' = u - y with u held during a step, or following its derivatives. */
enum { U, Y, N };
static const double start[N] = {0};

static void rates(const Model *m, double s, const double *x, double *dx) {
    dx[0] = at(m, U, s) - x[0];
}
static void update(Model *m) {}
static fmi2Status advance(Model *m, double t, double h) {
    rk4(m, 1, m->r + Y, h, rates);
    return fmi2OK;
}
