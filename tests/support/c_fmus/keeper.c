/* y' = gain u, of which it keeps the value in a static variable, as if there were but one instance. */
enum { GAIN, U, Y, N };
static const double start[N] = {[GAIN] = 1};
static double kept;

static void update(Model *m) { m->r[Y] = kept; }
static fmi2Status advance(Model *m, double t, double h) {
    kept += h * m->r[GAIN] * m->r[U];
    return fmi2OK;
}
