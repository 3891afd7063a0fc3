/* Mooring lines of MoorDyn, whose functions come by their addresses; see lines.c. SI units, world
   frame, x, y, z of one fairlead after the other; what is given has no y where it is fixed. */
#ifndef LINES_H
#define LINES_H

#include "line_steps.h"

/* Numbers of `state` before those of fairleads: time, length of an evaluating call, time since
   `velocity` was that of the fairleads. Then of each fairlead position, velocity, velocity that
   was set last, force, force of the last stage, velocity of the last evaluation; of each line the
   forces of its ends A and B on what holds them, and their places; of each winch the length. */
#define M4E_LINES_CLOCK 3

enum { M4E_LINES_FAILED = 1, M4E_LINES_NOT_FINITE = 2, M4E_LINES_NO_WATER = 3 };

typedef struct {
    int (*step)(void *system, const double *x, const double *xd, double *f, double *t, double *dt);
    int (*set_dt)(void *system, double dt);
    int (*set_water)(void *system, const double *velocity, const double *acceleration, double t);
    int (*node_position)(void *line, unsigned node, double *r);
    int (*node_velocity)(void *line, unsigned node, double *v);
    int (*node_force)(void *line, unsigned node, double *f);
    int (*node_tension)(void *line, unsigned node, double *t);
    int (*set_length)(void *line, double length);
    int (*set_rate)(void *line, double rate);
    int (*sample)(double t, double end); /* fills `water` from t to end; 0: it could */
    void *system;
    void **line;
    const uint32_t *segments;
    const uint32_t *ends; /* of each coupled object: 1 for a point, 2 for the ends of a rod */
    const double *axes;   /* of each coupled object: the direction of a rod as drawn */
    const double *fixed;  /* of each fairlead: its y, or nan where it moves in space */
    const uint32_t *winch; /* numbers of the lines whose length is set */
    const m4e_line_kind *kinds; /* of each line */
    const double *lengths;      /* of each line, unless a winch sets it */
    uint32_t lines, fairleads, objects, winches, nodes;
    int32_t inert;     /* coupled objects have masses of their own */
    int32_t moving;    /* the water moves */
    uint32_t order;    /* of the Runge-Kutta method */
    double share;      /* of the longest stable step that is taken */
    double longest;    /* internal step [s] */
    double interval;   /* [s] at which the water is sampled, at most */
    double *water; /* velocity, acceleration of all nodes: at the begin, in the middle, at the end
                      of an interval, and now; NULL: the water is not moved from outside */
    double *state, *work; /* work: 33 numbers a fairlead, 6 a node of the longest line */
} m4e_lines;

/* Forces of fairleads with this velocity where they are, by a vanishing call. */
M4E_API int m4e_lines_evaluate(m4e_lines *lines, const double *velocity);
/* Let fairleads have this velocity now, unless it was set last; without masses forces follow. */
M4E_API int m4e_lines_settle(m4e_lines *lines, const double *velocity);
/* A step from t over h: fairleads end at `position` + `velocity` h, wherever they were, or go there
   within a millisecond if h is less; of each winch a length at t and a rate. */
M4E_API int m4e_lines_advance(m4e_lines *lines, double t, double h, const double *position,
                              const double *velocity, const double *winch);
/* x, y, z and tension at each node of a line, counted from 0; nan where MoorDyn has no number. */
M4E_API void m4e_lines_nodes(const m4e_lines *lines, uint32_t line, double *rows);

#endif
