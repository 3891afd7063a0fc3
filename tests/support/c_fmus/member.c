/* A mass between a point that moves as given and the wall, with springs that may be cubic, a stop in
 * the way of the mass from `armed` on, a spring to the point that changes at `switched`, and a burst
 * of force. end.force_x acts on the point. Steps inside are of `inside` or a little less. */
enum { MASS, STIFFNESS, CUBIC, WALL_DAMPING, COUPLING, COUPLING_CUBIC, DAMPING, STOP, STOP_SIDE,
       STOP_STIFFNESS, STOP_DAMPING, BETWEEN, ARMED, SWITCHED, SWITCH_FACTOR, BURST, BURST_WIDTH, BURST_FORCE,
       INSIDE, POINT_X, POINT_V, PULL, FORCE, X, V, A, N };
static const double start[N] = {[MASS] = 1, [STIFFNESS] = 1, [STOP_SIDE] = 1, [ARMED] = 1e9,
                                [SWITCHED] = 1e9, [BURST] = 1e9, [BURST_WIDTH] = 1, [INSIDE] = 1e-3};

/* On the mass, with its sign; the stop pushes and never pulls. It is on the wall, or on the point. */
static double contact(const Model *m, double s, const double *x) {
    double d = x[0] - (m->r[BETWEEN] ? at(m, POINT_X, s) : 0);
    double in = m->r[STOP_SIDE] * (d - m->r[STOP]);
    double rate = m->r[STOP_SIDE] * (x[1] - (m->r[BETWEEN] ? at(m, POINT_V, s) : 0));
    if (m->t + s < m->r[ARMED] || in <= 0) return 0;
    double push = m->r[STOP_STIFFNESS] * in * (1 + m->r[STOP_DAMPING] * rate);
    return push > 0 ? -m->r[STOP_SIDE] * push : 0;
}
static double link(const Model *m, double s, const double *x) {
    double d = x[0] - at(m, POINT_X, s), t = m->t + s;
    double factor = t >= m->r[SWITCHED] ? m->r[SWITCH_FACTOR] : 1;
    return factor * (m->r[COUPLING] * d + m->r[COUPLING_CUBIC] * d * d * d) +
           m->r[DAMPING] * (x[1] - at(m, POINT_V, s)) - (m->r[BETWEEN] ? contact(m, s, x) : 0);
}
static double burst(const Model *m, double t) {
    double share = (t - m->r[BURST]) / m->r[BURST_WIDTH];
    return share > 0 && share < 1 ? m->r[BURST_FORCE] * sin(3.14159265358979323846 * share) : 0;
}
static void rates(const Model *m, double s, const double *x, double *dx) {
    double own = m->r[STIFFNESS] * x[0] + m->r[CUBIC] * x[0] * x[0] * x[0] + m->r[WALL_DAMPING] * x[1];
    dx[0] = x[1];
    dx[1] = (at(m, PULL, s) + (m->r[BETWEEN] ? 0 : contact(m, s, x)) + burst(m, m->t + s) - link(m, s, x) - own) / m->r[MASS];
}
static void update(Model *m) {
    double dx[2];
    rates(m, 0, m->r + X, dx);
    m->r[FORCE] = link(m, 0, m->r + X);
    m->r[A] = dx[1];
}
static fmi2Status advance(Model *m, double t, double h) {
    int pieces = (int)ceil(h / m->r[INSIDE] * (1 - 1e-9));
    m->t = t;
    rk4_in(m, 2, m->r + X, h, pieces, rates);
    return fmi2OK;
}
