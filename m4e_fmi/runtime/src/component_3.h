/* FMUs of FMI 3.0 for a master's loop, which knows functions as those of FMI 2.0.

   m4e_do_step_3, m4e_save_3 and m4e_restore_3 stand for fmi2DoStep, fmi2GetFMUstate and
   fmi2SetFMUstate; their first argument is a component. Values are moved by typed.h. */
#ifndef M4E_COMPONENT_3_H
#define M4E_COMPONENT_3_H

#include "m4e.h"

enum { /* beside the statuses of FMI */
    M4E_EARLY = 16, /* an event within the step: it goes up to `reached`, for now */
    M4E_RESTLESS    /* events without end */
};

typedef struct {
    void *instance;
    void (*do_step)(void), (*enter_event_mode)(void);
    void (*update_discrete_states)(void), (*enter_step_mode)(void);
    void (*get_state)(void), (*set_state)(void);
    int32_t has_events; /* it is used with event mode */
    int32_t stepping;   /* initialization is over */
    int32_t goes_on;    /* after an event within a step, to its end */
    double next_event;  /* s; infinite if none is known */
    double reached;     /* s, the last successful time */
    double ended;       /* s, when it asked for the end of the simulation; infinite if it did not:
                           steps after that do nothing */
    uint64_t interruptions; /* events within steps, after which it went on */
    uint64_t handled;       /* times in event mode */
    void (*begin_step)(void); /* of an FMU in another process: asks for a step, which `do_step` then
                                 awaits; else NULL */
} m4e_component_3;

/* The FMU's state, and what is known of its events then. */
typedef struct {
    void *state;
    double next_event, reached, ended;
    uint64_t interruptions;
} m4e_state_3;

M4E_API int m4e_do_step_3(void *component, double t, double h, int no_return);
M4E_API int m4e_begin_step_3(void *component, double t, double h, int no_return);
M4E_API int m4e_save_3(void *component, void **state); /* *state is an m4e_state_3 already */
M4E_API int m4e_restore_3(void *component, void *state);
int m4e_enter_event_mode_3(m4e_component_3 *component);
int m4e_settle_3(m4e_component_3 *component, double t); /* event iteration, and to step mode */

#endif
