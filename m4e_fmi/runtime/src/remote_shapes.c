/* Calls of FMI's functions, by the shape of their arguments, with what a request has. */
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "remote_server.h"

typedef uint32_t vr;
typedef void (*any)(void);
enum { WARNING = M4E_REMOTE_WARNING, ERROR = M4E_REMOTE_ERROR };

typedef void logger_2(void *environment, const char *name, int status, const char *category,
                      const char *message, ...);
typedef void logger_3(void *environment, int status, const char *category, const char *text);
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

static callbacks_2 kept_callbacks;

/* ---- arrays ---- */

static const void *given(const unsigned char **at, size_t size) {
    const void *here = *at;
    *at += m4e_remote_padded(size);
    return here;
}

/* Room for an answer of so many bytes; NULL: no memory. */
static void *room(size_t size) {
    free(m4e_serving.answer);
    m4e_serving.answer = NULL;
    m4e_serving.channel->taken = size;
    if (size <= M4E_ROOM) return m4e_serving.channel->answer;
    return m4e_serving.answer = calloc(1, size);
}

static int get_texts(any f, const vr *references, size_t count, size_t size, bool sized) {
    typedef int plain(void *, const vr *, size_t, const char **);
    typedef int with_size(void *, const vr *, size_t, const char **, size_t);
    const char **values = calloc(size + 1, sizeof *values);
    size_t total = 0;
    if (!values) return ERROR;
    void *i = m4e_serving.component;
    const int status = sized ? ((with_size *)f)(i, references, count, values, size)
                             : ((plain *)f)(i, references, count, values);
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
    void *i = m4e_serving.component;
    const int status = sized ? ((with_size *)f)(i, references, count, values, size)
                             : ((plain *)f)(i, references, count, values);
    free(values);
    return status;
}

static int get_binary(any f, const vr *references, size_t count, size_t size) {
    typedef int getter(void *, const vr *, size_t, size_t *, const char **, size_t);
    const char **values = calloc(size + 1, sizeof *values);
    size_t *sizes = calloc(size + 1, sizeof *sizes), total = 8 * size;
    if (!values || !sizes) return ERROR;
    const int status = ((getter *)f)(m4e_serving.component, references, count, sizes, values, size);
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
    const int status = ((setter *)f)(m4e_serving.component, references, count, sizes, values, size);
    free(values);
    free(sizes);
    return status;
}

/* ---- shapes of arguments: each performs the call `f` of the request in `c` ---- */

#define REQUEST                                                                                    \
    m4e_channel *c = m4e_serving.channel;                                                          \
    void *i = m4e_serving.component;                                                               \
    const uint64_t *n = m4e_serving.number;                                                        \
    const unsigned char *at = m4e_serving.at;                                                      \
    (void)c, (void)i, (void)n, (void)at;
#define REFERENCES(count) (const vr *)given(&at, (count) * sizeof(vr))

#define SHAPE(name, ...)                                                                           \
    static int name(any f, size_t size) {                                                          \
        REQUEST(void) size;                                                                        \
        __VA_ARGS__                                                                                \
    }

static int instantiated(void *component) {
    m4e_serving.component = component;
    m4e_serving.channel->number[0] = component != NULL;
    return 0;
}

#define NAMES                                                                                      \
    const char *name = (const char *)at, *token = name + m4e_remote_padded(strlen(name) + 1);      \
    const char *place = token + m4e_remote_padded(strlen(token) + 1);

SHAPE(INSTANTIATE_1, {
    typedef void *instantiate(const char *, const char *, const char *, const char *, double, char,
                              char, callbacks_1, char);
    NAMES
    const callbacks_1 callbacks = {m4e_remote_log, calloc, free, NULL};
    return instantiated(((instantiate *)f)(name, token, place, "application/x-fmu-sharedlibrary",
                                           c->real[0], (char)n[0], 0, callbacks, (char)n[1]));
})
SHAPE(INSTANTIATE_2, {
    typedef void *instantiate(const char *, int, const char *, const char *, const callbacks_2 *,
                              int, int);
    NAMES
    kept_callbacks = (callbacks_2){m4e_remote_log, calloc, free, NULL, &m4e_serving};
    return instantiated(((instantiate *)f)(name, (int)n[0], token, place, &kept_callbacks,
                                           (int)n[1], (int)n[2]));
})
SHAPE(INSTANTIATE_3, {
    typedef void *instantiate(const char *, const char *, const char *, bool, bool, bool, bool,
                              const vr *, size_t, void *, logger_3 *, any);
    const vr none = 0;
    NAMES
    return instantiated(((instantiate *)f)(name, token, *place ? place : NULL, n[0], n[1], n[2],
                                           n[3], &none, 0, &m4e_serving, m4e_remote_log_3, NULL));
})
SHAPE(PLAIN, { return ((int (*)(void *))f)(i); })
SHAPE(FREE, {
    ((void (*)(void *))f)(i);
    m4e_serving.component = NULL;
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

/* ---- all functions ---- */

#define ENTRY(name, shape, type) {shape, sizeof(type)},
const m4e_remote_shape M4E_REMOTE_SHAPES[] = {M4E_REMOTE_FUNCTIONS(ENTRY)};

int m4e_remote_is_step(uint32_t function) {
    const m4e_remote_shape *s = &M4E_REMOTE_SHAPES[function];
    return s->perform == STEP || (s->perform == STEP_3 && !m4e_serving.channel->number[1]);
}
