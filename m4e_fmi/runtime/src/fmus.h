/* FMUs for a master's loop: values of variables of any type, and FMUs of FMI 3.0, of which the loop
   knows the functions as those of FMI 2.0.

   m4e_do_step_3, m4e_save_3 and m4e_restore_3 stand for fmi2DoStep, fmi2GetFMUstate and
   fmi2SetFMUstate; their first argument is a component. m4e_get_3 and m4e_set_3 stand for
   fmi2GetReal and fmi2SetReal; theirs is an access, and references are not used.

   Each value lies in a cell of 64 bits: a whole number (unsigned ones of 64 bits by their bits), a
   Boolean as 0 or 1, a String as its place among the texts, a Real as a double. Reals take values
   of other cells, too. */
#ifndef M4E_FMUS_H
#define M4E_FMUS_H

#include "m4e.h"

enum { /* beside the statuses of FMI */
    M4E_DOES_NOT_FIT = -2, /* a value is none of the type */
    M4E_EARLY = 16,        /* an event within the step: it goes up to `reached`, for now */
    M4E_RESTLESS           /* events without end */
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
M4E_API int m4e_settle_3(m4e_component_3 *component); /* event iteration, and to step mode */
M4E_API int m4e_save_3(void *component, void **state); /* *state is an m4e_state_3 already */
M4E_API int m4e_restore_3(void *component, void *state);

enum { /* how values of a type lie in memory */
    M4E_I8, M4E_U8, M4E_I16, M4E_U16, M4E_I32, M4E_U32, M4E_I64, M4E_U64, M4E_F32, M4E_F64, M4E_TEXT
};

/* Different texts, each at its place; they stay where they are. All zero is an empty one. */
typedef struct {
    char **texts;
    uint64_t *slots; /* of a hash table, `size` of them: a place + 1, 0 where free */
    uint64_t count, room, size;
} m4e_texts;

M4E_API int64_t m4e_text_place(m4e_texts *texts, const char *text); /* -1: no memory */
M4E_API const char *m4e_text_at(const m4e_texts *texts, int64_t place);
M4E_API void m4e_texts_free(m4e_texts *texts);

/* Variables of one type, whole arrays: buffer[places[i]] is the value of member members[i]. */
typedef struct {
    void (*get)(void), (*set)(void); /* of FMI, for this type */
    const uint32_t *references, *places, *members;
    void *buffer;
    uint64_t reference_count, value_count, count;
    int32_t layout;   /* of the values in the buffer */
    int32_t sized;    /* FMI 3.0: the functions take the number of values */
    int32_t partial;  /* some elements are not among the members: they stay as they are */
    int32_t discrete; /* set in event mode, where there is one */
    int32_t truth;    /* Booleans: what is not 0 is 1 */
} m4e_part;

/* What a member takes: cells[source], which is to be from `low` to `high`, of an unsigned type if
   `large`; a Real takes factor * value + offset of it. */
typedef struct {
    int64_t low, high;
    double factor, offset;
    uint32_t source;
    int32_t large;
} m4e_taken;

typedef struct {
    void *instance;
    m4e_component_3 *component; /* of FMI 3.0; otherwise NULL */
    const m4e_part *parts;
    uint64_t part_count;
    m4e_texts *texts;
    const m4e_taken *taken; /* to set; NULL: each Real is a cell, at the place of the member */
    double *changed;        /* to get: becomes 0 where a cell changes; may be NULL */
    uint64_t failed;        /* the part that failed; the member whose value does not fit */
} m4e_access;

M4E_API int m4e_get_typed(m4e_access *access, int64_t *cells);
M4E_API int m4e_set_typed(m4e_access *access, const int64_t *cells);
M4E_API int m4e_get_3(void *access, const uint32_t *references, size_t count, double *values);
M4E_API int m4e_set_3(void *access, const uint32_t *references, size_t count, const double *values);

#endif
