/* y' = gain u with u held during a step. */
enum { GAIN, U, Y, N };
static const double start[N] = {[GAIN] = 1};

static void update(Model *m) {}
static fmi2Status advance(Model *m, double t, double h) {
    m->r[Y] += h * m->r[GAIN] * m->r[U];
    return fmi2OK;
}
