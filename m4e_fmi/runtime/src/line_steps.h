/* Internal steps of a mooring line that are stable where it is now; see line_steps.c. SI units,
   world frame, Z up. */
#ifndef LINE_STEPS_H
#define LINE_STEPS_H

#include "m4e.h"

static inline double dot(const double *a, const double *b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* A kind of line, per length where a line has it everywhere; without mass: nothing in it moves. */
typedef struct {
    double mass, across, along; /* [kg/m] in air, and with the added mass in water */
    double drag, axial_drag;    /* [kg/m2] rho d Cd, pi rho d CdAx: twice force over speed squared */
    double stiffness, least;    /* [N] largest EA, least EA of a taut segment */
    double damping, bending;    /* [N.s] BA, [N.m2] EI */
    double bed, bed_stiffness, bed_damping; /* [m] z of the seabed, [Pa] kBot d, [Pa.s] cBot d */
    double friction, decay;     /* [N.s/m] of a node on the seabed, [1/s] that a rope has of its own */
    double speed;               /* [m/s] of the water, where nobody says it */
} m4e_line_kind;

/* The number of equal internal steps, `least` or more, for the next h seconds of a line of
   `segments` of an unstretched `length`: nodes at `r` with velocities `v`, in water with velocities
   `u` (each x, y, z of one node after the other; u NULL: still). `order` is that of the Runge-Kutta
   method, 2 or 4; steps are of `share` of the longest stable one at most. */
M4E_API uint64_t m4e_line_steps(const m4e_line_kind *kind, uint32_t segments, double length,
                                const double *r, const double *v, const double *u, double h,
                                uint64_t least, uint32_t order, double share);

#endif
