/* y' = rate (u - y) by one step of Euler's method for each step: stable up to steps of 2/rate. */
enum { RATE, U, Y, N };
static const double start[N] = {[RATE] = 1};

static void update(Model *m) {}
static fmi2Status advance(Model *m, double t, double h) {
    m->r[Y] += h * m->r[RATE] * (m->r[U] - m->r[Y]);
    return fmi2OK;
}
