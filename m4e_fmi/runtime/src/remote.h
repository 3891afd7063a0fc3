/* FMUs in other processes: the functions of FMI as calls through memory that two processes share.

   M4E_REMOTE_FUNCTIONS has the signature of each. From it remote_client.c makes, for the master, a
   function m4e_remote_<name> of FMI's own type, and remote_server.c, in the worker, the call of the
   FMU. A request is a list of calls: of functions that set values, which wait for the next one that
   does not, of that one, and after a step of what is expected to be read then. An answer has what
   the last of them bring. What the FMU logs meanwhile comes before the answer. Whoever waits spins
   for a moment, then sleeps. Not on Windows, where nothing starts workers. */
#ifndef M4E_REMOTE_H
#define M4E_REMOTE_H

#include <stdbool.h>

#include "m4e.h"

enum { /* beside the statuses of FMI */
    M4E_NO_STATUS = 6, /* the FMU has answered a number that is none */
    M4E_LOST = 18, /* the worker does not answer */
    M4E_LATE       /* a function that sets values failed before: `late_function`, `late_status` */
};

/* ---- signatures: each argument by its kind, type and name ----

   VALUE    a number
   CHANGED  a place of a number, which the function may change
   GIVEN    an array of as many values as another argument says
   WANTED   the same, to be filled
   ARRAY    an array to read, and how many values it has
   ROOM     an array to fill, and how many values it has
   TEXT     a text, or NULL
   CALLBACKS_1, _2, _3   what an instance calls, in three versions of FMI */

typedef const char *m4e_text;
typedef void *m4e_pointer; /* a state: the worker's address, as it is */

#define PLAIN(A, T)
#define INSTANTIATE_1(A, T)                                                                        \
    A(TEXT, name) A(TEXT, token) A(TEXT, place) A(TEXT, mime) A(VALUE, double, timeout)            \
    A(VALUE, T, visible) A(VALUE, T, interactive) A(CALLBACKS_1, callbacks) A(VALUE, T, logging)
#define INSTANTIATE_2(A, T)                                                                        \
    A(TEXT, name) A(VALUE, T, type) A(TEXT, token) A(TEXT, place) A(CALLBACKS_2, callbacks)        \
    A(VALUE, T, visible) A(VALUE, T, logging)
#define INSTANTIATE_3(A, T)                                                                        \
    A(TEXT, name) A(TEXT, token) A(TEXT, place) A(VALUE, T, visible) A(VALUE, T, logging)          \
    A(VALUE, T, events) A(VALUE, T, early) A(ARRAY, uint32_t, required) A(CALLBACKS_3, logger)
#define INITIALIZE_1(A, T) A(VALUE, double, start) A(VALUE, T, stops) A(VALUE, double, stop)
#define SETUP(A, T) A(VALUE, T, tolerant) A(VALUE, double, tolerance) INITIALIZE_1(A, T)
#define STEP(A, T) A(VALUE, double, t) A(VALUE, double, h) A(VALUE, T, no_return)
#define STEP_3(A, T)                                                                               \
    STEP(A, T) A(CHANGED, T, event) A(CHANGED, T, end) A(CHANGED, T, early)                        \
    A(CHANGED, double, reached)
#define DISCRETE(A, T)                                                                             \
    A(CHANGED, T, again) A(CHANGED, T, end) A(CHANGED, T, nominals) A(CHANGED, T, values)          \
    A(CHANGED, T, defined) A(CHANGED, double, time)
#define STATUS(A, T) A(VALUE, int, kind) A(CHANGED, T, value)
#define REFERENCES(A) A(ARRAY, uint32_t, references)
#define GET(A, T) REFERENCES(A) A(WANTED, T, values, references_count)
#define SET(A, T) REFERENCES(A) A(GIVEN, T, values, references_count)
#define GET_SIZED(A, T) REFERENCES(A) A(ROOM, T, values)
#define SET_SIZED(A, T) REFERENCES(A) A(ARRAY, T, values)
#define SET_ORDERS(A, T)                                                                           \
    REFERENCES(A) A(GIVEN, int32_t, orders, references_count) A(GIVEN, T, values, references_count)
#define DIRECTION(A) A(ARRAY, uint32_t, unknowns) A(ARRAY, uint32_t, knowns)
#define DERIVATIVE(A, T)                                                                           \
    DIRECTION(A) A(GIVEN, T, seed, knowns_count) A(WANTED, T, found, unknowns_count)
#define DERIVATIVE_SIZED(A, T) DIRECTION(A) A(ARRAY, T, seed) A(ROOM, T, found)
#define GET_STATE(A, T) A(CHANGED, m4e_pointer, state)
#define SET_STATE(A, T) A(VALUE, m4e_pointer, state)
#define STATE_SIZE(A, T) A(VALUE, m4e_pointer, state) A(CHANGED, size_t, size)
#define SERIALIZE(A, T) A(VALUE, m4e_pointer, state) A(ROOM, char, bytes)
#define DESERIALIZE(A, T) A(ARRAY, char, bytes) A(CHANGED, m4e_pointer, state)

/* Name, how it is asked for, signature, its type T. How: NOW; LATE, at the next one that is not;
   AHEAD, with a step if it was read after the last ones; STEP; MAKE, FREE the instance. */
#define M4E_VALUES(X, fmi, Name, get, set, T)                                                      \
    X(fmi##Get##Name, AHEAD, get, T) X(fmi##Set##Name, LATE, set, T)
#define M4E_VALUES_3(X, Name, T) M4E_VALUES(X, fmi3, Name, GET_SIZED, SET_SIZED, T)
#define M4E_REMOTE_FUNCTIONS(X)                                                                    \
    X(fmiInstantiateSlave, MAKE, INSTANTIATE_1, char) X(fmiFreeSlaveInstance, FREE, PLAIN, )       \
    X(fmiInitializeSlave, NOW, INITIALIZE_1, char) X(fmiTerminateSlave, NOW, PLAIN, )              \
    X(fmiDoStep, STEP, STEP, char)                                                                 \
    M4E_VALUES(X, fmi, Real, GET, SET, double) M4E_VALUES(X, fmi, Integer, GET, SET, int)          \
    M4E_VALUES(X, fmi, Boolean, GET, SET, char)                                                    \
    X(fmiGetString, NOW, GET, m4e_text) X(fmiSetString, NOW, SET, m4e_text)                        \
    X(fmiSetRealInputDerivatives, LATE, SET_ORDERS, double)                                        \
    X(fmiGetRealStatus, NOW, STATUS, double)                                                       \
    X(fmi2Instantiate, MAKE, INSTANTIATE_2, int) X(fmi2FreeInstance, FREE, PLAIN, )                \
    X(fmi2SetupExperiment, NOW, SETUP, int) X(fmi2EnterInitializationMode, NOW, PLAIN, )           \
    X(fmi2ExitInitializationMode, NOW, PLAIN, ) X(fmi2Terminate, NOW, PLAIN, )                     \
    X(fmi2DoStep, STEP, STEP, int)                                                                 \
    M4E_VALUES(X, fmi2, Real, GET, SET, double) M4E_VALUES(X, fmi2, Integer, GET, SET, int)        \
    M4E_VALUES(X, fmi2, Boolean, GET, SET, int)                                                    \
    X(fmi2GetString, NOW, GET, m4e_text) X(fmi2SetString, NOW, SET, m4e_text)                      \
    X(fmi2SetRealInputDerivatives, LATE, SET_ORDERS, double)                                       \
    X(fmi2GetRealStatus, NOW, STATUS, double) X(fmi2GetBooleanStatus, NOW, STATUS, int)            \
    X(fmi2GetDirectionalDerivative, NOW, DERIVATIVE, double)                                       \
    X(fmi2GetFMUstate, NOW, GET_STATE, ) X(fmi2SetFMUstate, NOW, SET_STATE, )                      \
    X(fmi2FreeFMUstate, NOW, GET_STATE, ) X(fmi2SerializedFMUstateSize, NOW, STATE_SIZE, )         \
    X(fmi2SerializeFMUstate, NOW, SERIALIZE, ) X(fmi2DeSerializeFMUstate, NOW, DESERIALIZE, )      \
    X(fmi3InstantiateCoSimulation, MAKE, INSTANTIATE_3, bool) X(fmi3FreeInstance, FREE, PLAIN, )   \
    X(fmi3EnterInitializationMode, NOW, SETUP, bool) X(fmi3ExitInitializationMode, NOW, PLAIN, )   \
    X(fmi3EnterConfigurationMode, NOW, PLAIN, ) X(fmi3ExitConfigurationMode, NOW, PLAIN, )         \
    X(fmi3EnterEventMode, NOW, PLAIN, ) X(fmi3EnterStepMode, NOW, PLAIN, )                         \
    X(fmi3Terminate, NOW, PLAIN, ) X(fmi3DoStep, STEP, STEP_3, bool)                               \
    X(fmi3UpdateDiscreteStates, NOW, DISCRETE, bool)                                               \
    M4E_VALUES_3(X, Float32, float) M4E_VALUES_3(X, Float64, double)                               \
    M4E_VALUES_3(X, Int8, int8_t) M4E_VALUES_3(X, UInt8, uint8_t)                                  \
    M4E_VALUES_3(X, Int16, int16_t) M4E_VALUES_3(X, UInt16, uint16_t)                              \
    M4E_VALUES_3(X, Int32, int32_t) M4E_VALUES_3(X, UInt32, uint32_t)                              \
    M4E_VALUES_3(X, Int64, int64_t) M4E_VALUES_3(X, UInt64, uint64_t)                              \
    M4E_VALUES_3(X, Boolean, bool)                                                                 \
    X(fmi3GetString, NOW, GET_SIZED, m4e_text) X(fmi3SetString, NOW, SET_SIZED, m4e_text)          \
    X(fmi3GetDirectionalDerivative, NOW, DERIVATIVE_SIZED, double)                                 \
    X(fmi3GetFMUState, NOW, GET_STATE, ) X(fmi3SetFMUState, NOW, SET_STATE, )                      \
    X(fmi3FreeFMUState, NOW, GET_STATE, ) X(fmi3SerializedFMUStateSize, NOW, STATE_SIZE, )         \
    X(fmi3SerializeFMUState, NOW, SERIALIZE, ) X(fmi3DeserializeFMUState, NOW, DESERIALIZE, )

#define M4E_REMOTE_NUMBER(name, how, signature, T) M4E_##name,
enum { M4E_REMOTE_FUNCTIONS(M4E_REMOTE_NUMBER) M4E_LOAD, M4E_END };

typedef struct {
    void (*functions[4])(void); /* logger, allocateMemory, freeMemory, stepFinished */
} callbacks_1;
typedef struct {
    callbacks_1 callbacks;
    void *environment;
} callbacks_2;

/* Parameters of a function after the instance. */
#define PARAMETER(kind, ...) PARAMETER_##kind(__VA_ARGS__)
#define PARAMETER_VALUE(T, name) , T name
#define PARAMETER_CHANGED(T, name) , T *name
#define PARAMETER_GIVEN(T, name, count) , const T *name
#define PARAMETER_WANTED(T, name, count) , T *name
#define PARAMETER_ARRAY(T, name) , const T *name, size_t name##_count
#define PARAMETER_ROOM(T, name) , T *name, size_t name##_count
#define PARAMETER_TEXT(name) , const char *name
#define PARAMETER_CALLBACKS_1(name) , callbacks_1 name
#define PARAMETER_CALLBACKS_2(name) , const callbacks_2 *name
#define PARAMETER_CALLBACKS_3(name) , void *environment, void (*name)(void), void (*update)(void)
#define WITHOUT_FIRST(...) WITHOUT_FIRST_OF(__VA_ARGS__)
#define WITHOUT_FIRST_OF(first, ...) __VA_ARGS__

/* Bytes of a value; 0 of a text. */
#define SIZE_OF(T) _Generic((T *)0, m4e_text *: 0, default: sizeof(T))

/* ---- requests and answers ---- */

/* Values one after the other, each in a multiple of 8 bytes. */
typedef struct {
    unsigned char *at;
    size_t size, room;
    size_t place; /* the next to be taken */
    int failed;   /* there was no memory, or no such value */
} m4e_bytes;

void *m4e_extend(m4e_bytes *to, size_t size); /* place for so many bytes more; NULL: no memory */
void m4e_put(m4e_bytes *to, const void *value, size_t size);
void m4e_put_blob(m4e_bytes *to, const void *bytes, size_t size); /* and its size before it */
void m4e_put_all(m4e_bytes *to, const void *values, size_t count, size_t size);
/* The next so many bytes; NULL where there are less. */
void *m4e_take(m4e_bytes *from, size_t size);
void *m4e_take_blob(m4e_bytes *from, size_t *size);
const char *m4e_take_text(m4e_bytes *from); /* NULL if it was NULL, or is none */

/* One way between the processes, for one parcel at a time. */
typedef struct {
    _Atomic uint32_t sent;   /* changes with every parcel */
    _Atomic uint32_t asleep; /* who waits for it is to be woken */
    uint32_t kind;
    uint64_t size;
    unsigned char bytes[1 << 16];
} m4e_way;

/* The memory that both share; all zero at first. */
typedef struct {
    _Atomic int32_t lost;     /* set by the client's side: the worker is gone */
    _Atomic uint32_t calls;   /* requests so far */
    _Atomic int32_t busy;     /* one of them is going on, until the server has an answer */
    _Atomic uint32_t present; /* the function that the FMU performs, or has performed last */
    uint32_t late_function;
    int32_t late_status;
    m4e_way way[2]; /* to the client, to the server */
} m4e_channel;

/* One end of a channel. */
typedef struct {
    m4e_channel *channel;
    enum { M4E_CLIENT, M4E_SERVER } side;
    uint32_t seen; /* parcels */
    int eager;     /* whether spinning helps: 1, or minus the waits up to the next try */
    m4e_bytes in, out;
} m4e_end;

/* Parcels: none will come, one that is acknowledged by the next, which goes on with its bytes, or
   says nothing; a message of the FMU; a request, the last one; an answer. */
enum { M4E_NOTHING, M4E_PART, M4E_GO_ON, M4E_MESSAGE, M4E_REQUEST, M4E_LEAVE, M4E_ANSWER };

void m4e_send(m4e_end *end, uint32_t kind, const void *bytes, size_t size);
uint32_t m4e_await_parcel(m4e_end *end); /* its kind; its bytes stay where they are */
uint32_t m4e_hear(m4e_end *end);         /* the same with its bytes in `in`, a zero after them */
void m4e_wake(m4e_way *way);

/* An answer begins with it. */
typedef struct {
    int32_t status, ahead_status; /* of what was read after a step; -1: nothing */
    uint64_t ahead;               /* where that begins, in bytes */
} m4e_answer;

enum { M4E_TEXT_ROOM = 40 << 10 };
typedef struct {
    int64_t status;
    char text[M4E_TEXT_ROOM];
} m4e_message;

/* Server: tells that it is ready, and performs what is asked for with these functions (NULL: none),
   up to the end. 0, or 1 if the client's side has given up. */
M4E_API int m4e_remote_serve(m4e_channel *channel, void (*const *functions)(void));
M4E_API void m4e_remote_refuse(m4e_channel *channel, const char *why); /* instead */

#endif
