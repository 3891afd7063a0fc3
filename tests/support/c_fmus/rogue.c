/* y = t until something happens at `when`: 2 Discard, 3 Error, 4 Fatal, 7 a jump, 8 inf, 9 nan. */
enum { WHAT, WHEN, Y, N };
static const double start[N] = {[WHEN] = 1};

static void update(Model *m) {
    m->r[Y] = m->t;
    if (m->t >= m->r[WHEN]) {
        if (m->r[WHAT] == 7) m->r[Y] += 100;
        if (m->r[WHAT] == 8) m->r[Y] = INFINITY;
        if (m->r[WHAT] == 9) m->r[Y] = NAN;
    }
}
static fmi2Status advance(Model *m, double t, double h) {
    int what = (int)m->r[WHAT];
    if (what >= 2 && what <= 4 && t + h >= m->r[WHEN]) {
        SAY(m, fmi2Error, "the %s ran dry", "pump");
        return (fmi2Status)what;
    }
    return fmi2OK;
}
