/* y' = gain u with u held during a step, or following its derivatives. */
enum { GAIN, U, Y, N };
static const double start[N] = {[GAIN] = 1};

static void update(Model *m) {}
static fmi2Status advance(Model *m, double t, double h) {
    m->r[Y] += h * m->r[GAIN] * (m->r[U] + h / 2 * m->d1[U] + h * h / 6 * m->d2[U]);
    return fmi2OK;
}
