/* y = t. From `when` on, each step logs `count` messages of status `logged`, of `kinds` different kinds
 * (numbers in them differ besides), and answers `answer`. */
enum { LOGGED, ANSWER, COUNT, KINDS, WHEN, Y, N };
static const double start[N] = {[LOGGED] = 1, [COUNT] = 1, [KINDS] = 1};

static void update(Model *m) { m->r[Y] = m->t; }
static fmi2Status advance(Model *m, double t, double h) {
    if (t < m->r[WHEN] - 1e-9) return fmi2OK;
    for (int k = 0; k < (int)m->r[COUNT]; k++) {
        const int kind = k % (int)m->r[KINDS];
        const char word[] = {'a' + kind / 676 % 26, 'a' + kind / 26 % 26, 'a' + kind % 26, 0};
        SAY(m, (fmi2Status)m->r[LOGGED], "\033[31mline %s\033[0m is\n\t%.6g m\a too long, t = %g",
            word, 1e3 * t + k, t);
    }
    return (fmi2Status)m->r[ANSWER];
}
