/* FMUs in other processes: the functions of FMI as calls through memory that two processes share.

   The client, in the master, has every function that a master calls, under FMI's own signature and
   the name m4e_remote_<function> (remote_calls.c). The server, in the worker, performs one request
   after the other on the FMU (remote_server.c). A request is the number of a function, up to four
   whole numbers and three reals, and arrays; so is its answer. Arrays beyond M4E_ROOM bytes go in
   pieces. What the FMU logs during a call comes as answers before the last one, each of which the
   client acknowledges. Whoever waits spins for a moment, then sleeps. */
#ifndef M4E_REMOTE_H
#define M4E_REMOTE_H

#include "m4e.h"

enum { /* beside the statuses of FMI */
    M4E_NO_STATUS = 6, /* the FMU has answered a number that is none */
    M4E_LOST = 18, /* the worker does not answer */
    M4E_LATE       /* a function that sets values failed before: `late_function`, `late_status` */
};
enum { M4E_ROOM = 1 << 16, M4E_TEXT_ROOM = 40 << 10 };

/* name, shape of the arguments (remote_calls.c), type of the values */
#define M4E_REMOTE_FUNCTIONS(X)                                                                    \
    X(fmiInstantiateSlave, INSTANTIATE_1, char) X(fmiFreeSlaveInstance, FREE, char)                \
    X(fmiInitializeSlave, INITIALIZE_1, char) X(fmiTerminateSlave, PLAIN, char)                    \
    X(fmiResetSlave, PLAIN, char) X(fmiDoStep, STEP, char)                                         \
    X(fmiGetReal, GET, double) X(fmiSetReal, SET, double)                                          \
    X(fmiGetInteger, GET, int) X(fmiSetInteger, SET, int)                                          \
    X(fmiGetBoolean, GET, char) X(fmiSetBoolean, SET, char)                                        \
    X(fmiGetString, GET_TEXTS, char) X(fmiSetString, SET_TEXTS, char)                              \
    X(fmiSetRealInputDerivatives, SET_ORDERS, double)                                              \
    X(fmiGetRealOutputDerivatives, GET_ORDERS, double)                                             \
    X(fmiGetRealStatus, ANSWER, double)                                                            \
    X(fmi2Instantiate, INSTANTIATE_2, char) X(fmi2FreeInstance, FREE, char)                        \
    X(fmi2SetupExperiment, SETUP, int) X(fmi2EnterInitializationMode, PLAIN, char)                 \
    X(fmi2ExitInitializationMode, PLAIN, char) X(fmi2Terminate, PLAIN, char)                       \
    X(fmi2Reset, PLAIN, char) X(fmi2DoStep, STEP, int)                                             \
    X(fmi2GetReal, GET, double) X(fmi2SetReal, SET, double)                                        \
    X(fmi2GetInteger, GET, int) X(fmi2SetInteger, SET, int)                                        \
    X(fmi2GetBoolean, GET, int) X(fmi2SetBoolean, SET, int)                                        \
    X(fmi2GetString, GET_TEXTS, char) X(fmi2SetString, SET_TEXTS, char)                            \
    X(fmi2SetRealInputDerivatives, SET_ORDERS, double)                                             \
    X(fmi2GetRealOutputDerivatives, GET_ORDERS, double)                                            \
    X(fmi2GetRealStatus, ANSWER, double) X(fmi2GetBooleanStatus, ANSWER, int)                      \
    X(fmi2GetDirectionalDerivative, DERIVATIVE, double)                                            \
    X(fmi2GetFMUstate, GET_STATE, char) X(fmi2SetFMUstate, SET_STATE, char)                        \
    X(fmi2FreeFMUstate, GET_STATE, char) X(fmi2SerializedFMUstateSize, STATE_SIZE, char)           \
    X(fmi2SerializeFMUstate, SERIALIZE, char) X(fmi2DeSerializeFMUstate, DESERIALIZE, char)        \
    X(fmi3InstantiateCoSimulation, INSTANTIATE_3, char) X(fmi3FreeInstance, FREE, char)            \
    X(fmi3EnterInitializationMode, SETUP, char) X(fmi3ExitInitializationMode, PLAIN, char)         \
    X(fmi3EnterConfigurationMode, PLAIN, char) X(fmi3ExitConfigurationMode, PLAIN, char)           \
    X(fmi3EnterEventMode, PLAIN, char) X(fmi3EnterStepMode, PLAIN, char)                           \
    X(fmi3Terminate, PLAIN, char) X(fmi3Reset, PLAIN, char)                                        \
    X(fmi3DoStep, STEP_3, char) X(fmi3UpdateDiscreteStates, DISCRETE, char)                        \
    X(fmi3GetFloat32, GET_SIZED, float) X(fmi3SetFloat32, SET_SIZED, float)                        \
    X(fmi3GetFloat64, GET_SIZED, double) X(fmi3SetFloat64, SET_SIZED, double)                      \
    X(fmi3GetInt8, GET_SIZED, int8_t) X(fmi3SetInt8, SET_SIZED, int8_t)                            \
    X(fmi3GetUInt8, GET_SIZED, uint8_t) X(fmi3SetUInt8, SET_SIZED, uint8_t)                        \
    X(fmi3GetInt16, GET_SIZED, int16_t) X(fmi3SetInt16, SET_SIZED, int16_t)                        \
    X(fmi3GetUInt16, GET_SIZED, uint16_t) X(fmi3SetUInt16, SET_SIZED, uint16_t)                    \
    X(fmi3GetInt32, GET_SIZED, int32_t) X(fmi3SetInt32, SET_SIZED, int32_t)                        \
    X(fmi3GetUInt32, GET_SIZED, uint32_t) X(fmi3SetUInt32, SET_SIZED, uint32_t)                    \
    X(fmi3GetInt64, GET_SIZED, int64_t) X(fmi3SetInt64, SET_SIZED, int64_t)                        \
    X(fmi3GetUInt64, GET_SIZED, uint64_t) X(fmi3SetUInt64, SET_SIZED, uint64_t)                    \
    X(fmi3GetBoolean, GET_SIZED, char) X(fmi3SetBoolean, SET_SIZED, char)                          \
    X(fmi3GetString, GET_TEXTS_SIZED, char) X(fmi3SetString, SET_TEXTS_SIZED, char)                \
    X(fmi3GetBinary, GET_BINARY, char) X(fmi3SetBinary, SET_BINARY, char)                          \
    X(fmi3GetDirectionalDerivative, DERIVATIVE_SIZED, double)                                      \
    X(fmi3GetOutputDerivatives, GET_ORDERS_SIZED, double)                                          \
    X(fmi3GetFMUState, GET_STATE, char) X(fmi3SetFMUState, SET_STATE, char)                        \
    X(fmi3FreeFMUState, GET_STATE, char) X(fmi3SerializedFMUStateSize, STATE_SIZE, char)           \
    X(fmi3SerializeFMUState, SERIALIZE, char) X(fmi3DeserializeFMUState, DESERIALIZE, char)

#define M4E_REMOTE_NUMBER(name, shape, type) M4E_##name,
enum { M4E_REMOTE_FUNCTIONS(M4E_REMOTE_NUMBER) M4E_LOAD, M4E_END, M4E_SETS, M4E_PIECE, M4E_FETCH };

/* The memory that both share; all zero at first. */
typedef struct {
    _Atomic uint32_t asked;     /* changes with every request, */
    _Atomic uint32_t answered;  /* and with every answer */
    _Atomic uint32_t asleep[2]; /* client, server: to be woken */
    _Atomic int32_t lost;       /* set by the client's side: the worker is gone */
    _Atomic uint32_t calls;     /* of functions, so far */
    _Atomic int32_t busy;       /* one of them is going on, until the server has an answer */
    _Atomic uint32_t present;   /* the function that the FMU performs, or has performed last */
    uint32_t late_function;
    int32_t late_status;
    uint32_t function;
    int32_t status;     /* the answer's */
    int32_t is_message; /* the answer is a message of the FMU with this status */
    uint64_t number[4];
    double real[3];
    uint64_t late;         /* bytes of values to be set first, at the begin of the request */
    uint64_t given, taken; /* bytes of the arrays of a request, and of its answer */
    uint32_t ahead;        /* function that reads values after a step; M4E_LOAD: none */
    int32_t ahead_status;
    uint64_t ahead_counts[2]; /* of references, of values */
    unsigned char request[M4E_ROOM], answer[M4E_ROOM];
    char text[M4E_TEXT_ROOM];
} m4e_channel;

/* Receives messages of the FMU. */
typedef struct {
    int version; /* of FMI */
    void (*logger)(void);
    void *environment;
    char name[256];
} m4e_listener;

/* Values to be set, before references and values themselves, each padded. */
typedef struct {
    uint32_t function, reserved;
    uint64_t number[2], size; /* size: of all that follows, in bytes */
} m4e_late;

/* Client: what is read after steps. */
typedef struct {
    uint32_t function;
    uint64_t counts[2];
    uint32_t *references;
    size_t size;   /* of the values, in bytes */
    int32_t seen;  /* how many steps were followed by this, one after the other */
    int32_t ready; /* 1: the values of the last step are in `values`, not read yet */
    int32_t status;
    void *values;
} m4e_ahead;

/* Client: one instance of an FMU in a worker, which is its component. */
typedef struct {
    m4e_channel *channel;
    uint32_t seen;    /* the last answer */
    int32_t stepping; /* a step is asked for, and not awaited yet: with these arguments; */
    int32_t late_answer; /* its status, if it was not even asked for */
    double t, h;
    int32_t no_return;
    int32_t has_stepped; /* the last call was a step */
    int32_t eager;
    m4e_ahead ahead;
    unsigned char late[M4E_ROOM / 2];
    size_t late_size;
    m4e_listener listener;
    char *kept; /* texts, valid up to the next call */
    size_t kept_size;
} m4e_remote;

typedef struct {
    const void *at;
    size_t size; /* bytes */
} m4e_given;
typedef struct {
    void *at;
    size_t size;
} m4e_wanted;

M4E_API m4e_remote *m4e_remote_new(m4e_channel *channel); /* NULL: no memory */
M4E_API void m4e_remote_free(m4e_remote *remote);
M4E_API void m4e_remote_use(m4e_remote *remote); /* the next instance of this thread is there */
M4E_API int m4e_remote_await(m4e_remote *remote); /* the first answer: 0, or why in its text */
M4E_API int m4e_remote_flush(m4e_remote *remote); /* sets values now; M4E_LATE, M4E_LOST, 0, 1 */
M4E_API int m4e_remote_end(m4e_remote *remote); /* has the server return, and waits for nothing; 1:
                                                   it cannot, in a step that is not awaited */
M4E_API void m4e_remote_give_up(m4e_channel *channel); /* the worker is gone: ends all waiting */
M4E_API const char *m4e_remote_name(uint32_t function); /* NULL: there is no such function */
M4E_API const char *m4e_remote_text(const m4e_remote *remote); /* of the last message or refusal */
M4E_API size_t m4e_remote_size(void); /* of m4e_channel, in bytes */

/* Begins a request; its numbers and reals are then to be set. A step that was begun and not awaited
   has been made then, and values that were read ahead are forgotten. */
m4e_channel *m4e_remote_begin(m4e_remote *remote);
/* Asks for it with `given` arrays, and waits; the status, `wanted` arrays filled. */
int m4e_remote_ask(m4e_remote *remote, uint32_t function, const m4e_given *given, int given_count,
                   const m4e_wanted *wanted, int wanted_count);
int m4e_remote_post(m4e_remote *remote, uint32_t function, const m4e_given *given, int count);
/* Asks for a step, which the call of `function` with the same arguments then awaits. */
void m4e_remote_begin_step(void *remote, double t, double h, int no_return, uint32_t function);
/* The answer's arrays as a whole up to `end`, where a zero follows, in memory that is kept up to the
   next call; NULL: lost. */
char *m4e_remote_answer(m4e_remote *remote, const char **end);

/* Waits until `word` is no longer `old` or `lost` is set; 0 if it is still. `eager`, 0 at first, is
   where it keeps whether spinning helps. */
int m4e_remote_wait(_Atomic uint32_t *word, uint32_t old, _Atomic uint32_t *asleep,
                    _Atomic int32_t *lost, int32_t *eager);
void m4e_remote_wake(_Atomic uint32_t *word, _Atomic uint32_t *asleep);
/* Values that are to be set go along with the next request: 0, or 1 if they do not fit. */
int m4e_remote_set_late(m4e_remote *remote, uint32_t function, const m4e_given *given, int count,
                        uint64_t references, uint64_t values);
size_t m4e_remote_padded(size_t size); /* that arrays take in a request or answer */

/* Server: tells that it is ready, and performs what is asked for with these functions (NULL: none),
   up to M4E_END. 0, or 1 if the client's side has given up. */
M4E_API int m4e_remote_serve(m4e_channel *channel, void (*const *functions)(void));
M4E_API void m4e_remote_refuse(m4e_channel *channel, const char *why); /* instead */

#endif
