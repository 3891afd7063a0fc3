/* y = t until something happens at `when`: 2 Discard, 3 Error, 4 Fatal, 7 a jump, 8 inf, 9 nan; 5 is
 * Discard and 6 Fatal for a step longer than `when`; 1 is Discard of a step over it, up to there. */
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
    if (what == 1 && t < m->r[WHEN] - 1e-12 && t + h > m->r[WHEN] + 1e-12) {
        m->reached = m->r[WHEN];
        return fmi2Discard;
    }
    if (what == 6 && h > m->r[WHEN]) return fmi2Fatal;
    if (what == 5 && h > m->r[WHEN]) return fmi2Discard;
    if (what >= 2 && what <= 4 && t + h >= m->r[WHEN]) {
        SAY(m, fmi2Error, "the %s ran dry", "pump");
        return (fmi2Status)what;
    }
    return fmi2OK;
}
