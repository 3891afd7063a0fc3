/* Performs calls of FMI on an FMU of this process, as they are asked for by remote_calls.c. */
#include <stdarg.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "remote.h"

typedef uint32_t vr;
typedef void (*any)(void);
enum { CLIENT, SERVER };
enum { WARNING = 1, ERROR = 3 };

typedef void logger_2(void *environment, const char *name, int status, const char *category,
                      const char *message, ...);
typedef struct {
    logger_2 *logger;
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    any finished;
} callbacks_1;
typedef struct {
    logger_2 *logger;
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    any finished;
    void *environment;
} callbacks_2;

static struct {
    m4e_channel *channel;
    uint32_t seen; /* the last request */
    void *component;
    callbacks_2 callbacks;
    unsigned char *request, *answer; /* arrays that do not fit into the channel, or NULL */
    uint64_t number[4];              /* of the call, */
    const unsigned char *at;         /* and its arrays */
    int32_t eager;
} server;
static _Thread_local bool is_serving; /* this thread, during a call */

/* ---- channel ---- */

static int hear(void) {
    m4e_channel *c = server.channel;
    if (!m4e_remote_wait(&c->asked, server.seen, &c->asleep[SERVER], &c->lost, &server.eager)) return 0;
    server.seen = atomic_load(&c->asked);
    return 1;
}

static void answer(int status, int is_message) {
    m4e_channel *c = server.channel;
    c->status = status;
    c->is_message = is_message;
    atomic_fetch_add(&c->answered, 1);
    m4e_remote_wake(&c->answered, &c->asleep[CLIENT]);
}

/* To the client, if it waits for a call; otherwise to standard error. */
static void tell(int status, const char *text) {
    m4e_channel *c = server.channel;
    if (!is_serving) {
        fprintf(stderr, "%s\n", text);
        return;
    }
    strncpy(c->text, text, M4E_TEXT_ROOM - 1);
    answer(status, 1);
    if (!hear()) exit(1); /* the client is gone */
}

static void log_2(void *environment, const char *name, int status, const char *category,
                  const char *message, ...) {
    static _Thread_local char text[M4E_TEXT_ROOM];
    va_list arguments;
    (void)environment, (void)name, (void)category;
    va_start(arguments, message);
    if (vsnprintf(text, sizeof text, message ? message : "", arguments) < 0) text[0] = 0;
    va_end(arguments);
    tell(status, text);
}

static void log_3(void *environment, int status, const char *category, const char *text) {
    (void)environment, (void)category;
    tell(status, text ? text : "");
}

/* ---- arrays ---- */

static const void *given(const unsigned char **at, size_t size) {
    const void *here = *at;
    *at += m4e_remote_padded(size);
    return here;
}

/* Room for an answer of so many bytes; NULL: no memory. */
static void *room(size_t size) {
    free(server.answer);
    server.answer = NULL;
    server.channel->taken = size;
    if (size <= M4E_ROOM) return server.channel->answer;
    return server.answer = calloc(1, size);
}

static int get_texts(any f, const vr *references, size_t count, size_t size, bool sized) {
    typedef int plain(void *, const vr *, size_t, const char **);
    typedef int with_size(void *, const vr *, size_t, const char **, size_t);
    const char **values = calloc(size + 1, sizeof *values);
    size_t total = 0;
    if (!values) return ERROR;
    const int status = sized
                           ? ((with_size *)f)(server.component, references, count, values, size)
                           : ((plain *)f)(server.component, references, count, values);
    for (size_t k = 0; k < size; ++k) {
        if (!values[k] || status > WARNING) values[k] = "";
        total += strlen(values[k]) + 1;
    }
    char *at = room(total);
    for (size_t k = 0; k < size && at; ++k) {
        strcpy(at, values[k]);
        at += strlen(at) + 1;
    }
    free(values);
    return at ? status : ERROR;
}

static int set_texts(any f, const vr *references, size_t count, const char *texts, size_t size,
                     bool sized) {
    typedef int plain(void *, const vr *, size_t, const char *const *);
    typedef int with_size(void *, const vr *, size_t, const char *const *, size_t);
    const char **values = calloc(size + 1, sizeof *values);
    if (!values) return ERROR;
    for (size_t k = 0; k < size; ++k) {
        values[k] = texts;
        texts += strlen(texts) + 1;
    }
    const int status = sized
                           ? ((with_size *)f)(server.component, references, count, values, size)
                           : ((plain *)f)(server.component, references, count, values);
    free(values);
    return status;
}

static int get_binary(any f, const vr *references, size_t count, size_t size) {
    typedef int getter(void *, const vr *, size_t, size_t *, const char **, size_t);
    const char **values = calloc(size + 1, sizeof *values);
    size_t *sizes = calloc(size + 1, sizeof *sizes), total = 8 * size;
    if (!values || !sizes) return ERROR;
    const int status = ((getter *)f)(server.component, references, count, sizes, values, size);
    for (size_t k = 0; k < size; ++k) {
        if (!values[k] || status > WARNING) sizes[k] = 0;
        total += sizes[k];
    }
    char *at = room(total), *content = at + 8 * size;
    for (size_t k = 0; k < size && at; ++k) {
        const uint64_t length = sizes[k];
        memcpy(at + 8 * k, &length, sizeof length);
        if (length) memcpy(content, values[k], sizes[k]);
        content += length;
    }
    free(values);
    free(sizes);
    return at ? status : ERROR;
}

static int set_binary(any f, const vr *references, size_t count, const char *at, size_t size) {
    typedef int setter(void *, const vr *, size_t, const size_t *, const char *const *, size_t);
    const char **values = calloc(size + 1, sizeof *values);
    size_t *sizes = calloc(size + 1, sizeof *sizes);
    const char *content = at + 8 * size;
    if (!values || !sizes) return ERROR;
    for (size_t k = 0; k < size; ++k) {
        uint64_t length;
        memcpy(&length, at + 8 * k, sizeof length);
        sizes[k] = (size_t)length;
        values[k] = content;
        content += length;
    }
    const int status = ((setter *)f)(server.component, references, count, sizes, values, size);
    free(values);
    free(sizes);
    return status;
}

/* ---- shapes of arguments: each performs the call `f` of the request in `c` ---- */

#define REQUEST                                                                                    \
    m4e_channel *c = server.channel;                                                               \
    void *i = server.component;                                                                    \
    const uint64_t *n = server.number;                                                             \
    const unsigned char *at = server.at;                                                           \
    (void)c, (void)i, (void)n, (void)at;
#define REFERENCES(count) (const vr *)given(&at, (count) * sizeof(vr))

#define SHAPE(name, ...)                                                                           \
    static int name(any f, size_t size) {                                                          \
        REQUEST(void) size;                                                                        \
        __VA_ARGS__                                                                                \
    }

static int instantiated(void *component) {
    server.component = component;
    server.channel->number[0] = component != NULL;
    return 0;
}

#define NAMES                                                                                      \
    const char *name = (const char *)at, *token = name + m4e_remote_padded(strlen(name) + 1);      \
    const char *place = token + m4e_remote_padded(strlen(token) + 1);

SHAPE(INSTANTIATE_1, {
    typedef void *instantiate(const char *, const char *, const char *, const char *, double, char,
                              char, callbacks_1, char);
    NAMES
    const callbacks_1 callbacks = {log_2, calloc, free, NULL};
    return instantiated(((instantiate *)f)(name, token, place, "application/x-fmu-sharedlibrary",
                                           c->real[0], (char)n[0], 0, callbacks, (char)n[1]));
})
SHAPE(INSTANTIATE_2, {
    typedef void *instantiate(const char *, int, const char *, const char *, const callbacks_2 *,
                              int, int);
    NAMES
    server.callbacks = (callbacks_2){log_2, calloc, free, NULL, &server};
    return instantiated(((instantiate *)f)(name, (int)n[0], token, place, &server.callbacks,
                                           (int)n[1], (int)n[2]));
})
SHAPE(INSTANTIATE_3, {
    typedef void *instantiate(const char *, const char *, const char *, bool, bool, bool, bool,
                              const vr *, size_t, void *, void *, void *);
    const vr none = 0;
    NAMES
    return instantiated(((instantiate *)f)(name, token, *place ? place : NULL, n[0], n[1], n[2],
                                           n[3], &none, 0, &server, (void *)log_3, NULL));
})
SHAPE(PLAIN, { return ((int (*)(void *))f)(i); })
SHAPE(FREE, {
    ((void (*)(void *))f)(i);
    server.component = NULL;
    return 0;
})
SHAPE(INITIALIZE_1, {
    return ((int (*)(void *, double, char, double))f)(i, c->real[0], (char)n[0], c->real[1]);
})
SHAPE(SETUP, {
    typedef int with_int(void *, int, double, double, int, double);
    typedef int with_bool(void *, bool, double, double, bool, double);
    const double *x = c->real;
    return size == sizeof(int) ? ((with_int *)f)(i, (int)n[0], x[0], x[1], (int)n[1], x[2])
                               : ((with_bool *)f)(i, n[0], x[0], x[1], n[1], x[2]);
})
SHAPE(GET, {
    return ((int (*)(void *, const vr *, size_t, void *))f)(i, REFERENCES(n[0]), n[0],
                                                            room(n[1] * size));
})
SHAPE(SET, {
    const vr *references = REFERENCES(n[0]);
    return ((int (*)(void *, const vr *, size_t, const void *))f)(i, references, n[0], at);
})
SHAPE(GET_SIZED, {
    return ((int (*)(void *, const vr *, size_t, void *, size_t))f)(i, REFERENCES(n[0]), n[0],
                                                                    room(n[1] * size), n[1]);
})
SHAPE(SET_SIZED, {
    const vr *references = REFERENCES(n[0]);
    return ((int (*)(void *, const vr *, size_t, const void *, size_t))f)(i, references, n[0], at,
                                                                          n[1]);
})
SHAPE(GET_TEXTS, { return get_texts(f, REFERENCES(n[0]), n[0], n[1], false); })
SHAPE(GET_TEXTS_SIZED, { return get_texts(f, REFERENCES(n[0]), n[0], n[1], true); })
SHAPE(SET_TEXTS, {
    const vr *references = REFERENCES(n[0]);
    return set_texts(f, references, n[0], (const char *)at, n[1], false);
})
SHAPE(SET_TEXTS_SIZED, {
    const vr *references = REFERENCES(n[0]);
    return set_texts(f, references, n[0], (const char *)at, n[1], true);
})
SHAPE(GET_BINARY, { return get_binary(f, REFERENCES(n[0]), n[0], n[1]); })
SHAPE(SET_BINARY, {
    const vr *references = REFERENCES(n[0]);
    return set_binary(f, references, n[0], (const char *)at, n[1]);
})
SHAPE(SET_ORDERS, {
    typedef int setter(void *, const vr *, size_t, const int32_t *, const double *);
    const vr *references = REFERENCES(n[0]);
    const int32_t *orders = given(&at, n[0] * sizeof *orders);
    return ((setter *)f)(i, references, n[0], orders, (const double *)at);
})
SHAPE(GET_ORDERS, {
    typedef int getter(void *, const vr *, size_t, const int32_t *, double *);
    const vr *references = REFERENCES(n[0]);
    return ((getter *)f)(i, references, n[0], (const int32_t *)at, room(n[1] * sizeof(double)));
})
SHAPE(GET_ORDERS_SIZED, {
    typedef int getter(void *, const vr *, size_t, const int32_t *, double *, size_t);
    const vr *references = REFERENCES(n[0]);
    double *values = room(n[1] * sizeof *values);
    return ((getter *)f)(i, references, n[0], (const int32_t *)at, values, n[1]);
})
SHAPE(DERIVATIVE, {
    typedef int getter(void *, const vr *, size_t, const vr *, size_t, const double *, double *);
    const vr *unknowns = REFERENCES(n[0]);
    const vr *knowns = REFERENCES(n[1]);
    double *found = room(n[3] * sizeof *found);
    return ((getter *)f)(i, unknowns, n[0], knowns, n[1], (const double *)at, found);
})
SHAPE(DERIVATIVE_SIZED, {
    typedef int getter(void *, const vr *, size_t, const vr *, size_t, const double *, size_t,
                       double *, size_t);
    const vr *unknowns = REFERENCES(n[0]);
    const vr *knowns = REFERENCES(n[1]);
    double *found = room(n[3] * sizeof *found);
    return ((getter *)f)(i, unknowns, n[0], knowns, n[1], (const double *)at, n[2], found, n[3]);
})
SHAPE(STEP, {
    return size == sizeof(int)
               ? ((int (*)(void *, double, double, int))f)(i, c->real[0], c->real[1], (int)n[0])
               : ((int (*)(void *, double, double, char))f)(i, c->real[0], c->real[1], (char)n[0]);
})
SHAPE(STEP_3, {
    typedef int do_step(void *, double, double, bool, bool *, bool *, bool *, double *);
    static const uint64_t UNWRITTEN = 0x7ff8dead0000beefu;
    bool event = false, end = false, early = false;
    double reached;
    memcpy(&reached, &UNWRITTEN, sizeof reached);
    const int status =
        ((do_step *)f)(i, c->real[0], c->real[1], n[0], &event, &end, &early, &reached);
    c->number[1] = (uint64_t)event | (uint64_t)end << 1 | (uint64_t)early << 2;
    c->number[2] = memcmp(&reached, &UNWRITTEN, sizeof reached) != 0;
    c->real[2] = reached;
    return status;
})
SHAPE(DISCRETE, {
    typedef int update(void *, bool *, bool *, bool *, bool *, bool *, double *);
    bool flag[5];
    for (int k = 0; k < 5; ++k) flag[k] = n[0] >> k & 1;
    const int status =
        ((update *)f)(i, &flag[0], &flag[1], &flag[2], &flag[3], &flag[4], &c->real[0]);
    c->number[0] = 0;
    for (int k = 0; k < 5; ++k) c->number[0] |= (uint64_t)flag[k] << k;
    return status;
})
SHAPE(ANSWER, {
    if (size == sizeof(double)) return ((int (*)(void *, int, double *))f)(i, (int)n[0], c->real);
    int value = (int)c->real[0];
    const int status = ((int (*)(void *, int, int *))f)(i, (int)n[0], &value);
    c->real[0] = value;
    return status;
})
SHAPE(GET_STATE, {
    void *state = (void *)(uintptr_t)n[0];
    const int status = ((int (*)(void *, void **))f)(i, &state);
    c->number[0] = (uint64_t)(uintptr_t)state;
    return status;
})
SHAPE(SET_STATE, { return ((int (*)(void *, void *))f)(i, (void *)(uintptr_t)n[0]); })
SHAPE(STATE_SIZE, {
    size_t found = 0;
    const int status = ((int (*)(void *, void *, size_t *))f)(i, (void *)(uintptr_t)n[0], &found);
    c->number[1] = found;
    return status;
})
SHAPE(SERIALIZE, {
    return ((int (*)(void *, void *, void *, size_t))f)(i, (void *)(uintptr_t)n[0], room(n[1]),
                                                        n[1]);
})
SHAPE(DESERIALIZE, {
    void *state = (void *)(uintptr_t)n[0];
    const int status = ((int (*)(void *, const void *, size_t, void **))f)(i, at, n[1], &state);
    c->number[0] = (uint64_t)(uintptr_t)state;
    return status;
})

/* ---- requests ---- */

#define ENTRY(name, shape, type) {shape, sizeof(type)},
static const struct {
    int (*perform)(any f, size_t size);
    size_t size; /* of a value */
} SHAPES[] = {M4E_REMOTE_FUNCTIONS(ENTRY)};

/* A piece of a request that does not fit. */
static int collect(void) {
    m4e_channel *c = server.channel;
    if (!c->taken) {
        free(server.request);
        server.request = calloc(1, c->given);
    }
    if (!server.request) return ERROR;
    const size_t rest = c->given - c->taken;
    memcpy(server.request + c->taken, c->request, rest < M4E_ROOM ? rest : M4E_ROOM);
    return 0;
}

static int called(any f, uint32_t function, const uint64_t *number, const unsigned char *at) {
    for (int k = 0; k < 4; ++k) server.number[k] = number[k];
    server.at = at;
    atomic_store(&server.channel->present, function);
    return f ? SHAPES[function].perform(f, SHAPES[function].size) : ERROR;
}

/* Sets the values that have come along; 0 if one of these calls fails. */
static int set_late(any const *functions) {
    m4e_channel *c = server.channel;
    const unsigned char *at = c->request, *end = at + c->late;
    while (at < end) {
        m4e_late head;
        memcpy(&head, at, sizeof head);
        const uint64_t number[4] = {head.number[0], head.number[1]};
        at += sizeof head;
        const int status = called(functions[head.function], head.function, number, at);
        if (status > WARNING) {
            c->late_function = head.function;
            c->late_status = status;
            return 0;
        }
        at += head.size;
    }
    return 1;
}

/* Reads what is expected to be wanted after a step. */
static void read_ahead(any const *functions, const unsigned char *references) {
    m4e_channel *c = server.channel;
    const uint64_t number[4] = {c->ahead_counts[0], c->ahead_counts[1]};
    c->ahead_status = called(functions[c->ahead], c->ahead, number, references);
}

static void perform(any const *functions, uint32_t function) {
    m4e_channel *c = server.channel;
    const unsigned char *at = server.request ? server.request : c->request + c->late;
    int status = 0;
    is_serving = true;
    c->ahead_status = -1;
    if (!set_late(functions)) {
        status = M4E_LATE;
    } else if (function != M4E_SETS) {
        status = called(functions[function], function, c->number, at);
        const int steps = SHAPES[function].perform == STEP ||
                          (SHAPES[function].perform == STEP_3 && !c->number[1]);
        if (steps && status <= WARNING && c->ahead != M4E_LOAD) read_ahead(functions, at);
    }
    is_serving = false;
    free(server.request);
    server.request = NULL;
    atomic_store(&c->busy, 0);
    answer(status, 0);
}

void m4e_remote_refuse(m4e_channel *c, const char *why) {
    server.channel = c;
    strncpy(c->text, why, M4E_TEXT_ROOM - 1);
    atomic_store(&c->busy, 0);
    answer(ERROR, 0);
}

int m4e_remote_serve(m4e_channel *c, void (*const *functions)(void)) {
    server.channel = c;
    atomic_store(&c->busy, 0);
    answer(0, 0);
    while (hear()) {
        const uint32_t function = c->function;
        if (function == M4E_END) {
            atomic_store(&c->present, M4E_END);
            return 0;
        }
        if (function == M4E_PIECE) {
            answer(collect(), 0);
        } else if (function == M4E_FETCH) {
            memcpy(c->answer, server.answer + c->given, c->taken);
            answer(0, 0);
        } else {
            perform(functions, function);
        }
    }
    return 1;
}
