/* y = t, until at `when` it harms its process: 1 goes to another folder, 2 writes to address 0, 3
 * takes `pause` seconds of wall time for each further step. 4 is an error in every step. */
#include <time.h>
#include <unistd.h>
enum { WHAT, WHEN, PAUSE, Y, N };
static const double start[N] = {[WHEN] = 1};

static void update(Model *m) { m->r[Y] = m->t; }
static fmi2Status advance(Model *m, double t, double h) {
    double pause = m->r[PAUSE];
    struct timespec length = {(time_t)pause, (long)(1e9 * (pause - (time_t)pause))};
    if (m->r[WHAT] == 4) return fmi2Error;
    if (t + h < m->r[WHEN]) return fmi2OK;
    if (m->r[WHAT] == 1 && chdir("/")) return fmi2Error;
    if (m->r[WHAT] == 2) *(volatile int *)0 = 1;
    if (m->r[WHAT] == 3) while (nanosleep(&length, &length)) continue; /* after a signal */
    return fmi2OK;
}
